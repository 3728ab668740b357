"""Models, results and what belongs to them are copied, pickled, and handed from process to process."""

import concurrent.futures
import copy
import gc
import multiprocessing
import operator
import os
import pickle
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np
from test_package import LENGTH, THICKNESS, WIDTH, YOUNG, cantilever

import tegula


def of_arrays() -> dict[str, Any]:
    """A cantilever on a mesh of arrays with coordinates that no decimal number has."""
    x, y = np.meshgrid(np.linspace(0.0, LENGTH, 7) / 3.0, np.linspace(0.0, WIDTH, 2) / 3.0, indexing="ij")
    first = 2 * np.arange(6)
    mesh = {
        "type": "arrays",
        "nodes": np.column_stack([x.ravel(), y.ravel(), 0.01 * np.sin(x.ravel())]),
        "quads": np.column_stack([first, first + 2, first + 3, first + 1]),
        "node_sets": {"u_min": [0, 1], "u_max_v_min": [12]},
        "edge_sets": {"u_max": [[12, 13]]},
    }
    return cantilever(mesh=mesh)


def copies(value: Any) -> list[Any]:
    """Copies of a value in each way."""
    protocols = [pickle.loads(pickle.dumps(value, p)) for p in range(2, pickle.HIGHEST_PROTOCOL + 1)]
    return [copy.copy(value), copy.deepcopy(value), *protocols]


class Pickles(unittest.TestCase):
    def test_models_of_arrays_are_equal_to_the_last_bit(self) -> None:
        model = tegula.Model(of_arrays())
        expected = model.equations().reference
        self.assertEqual(expected.shape, (28, 3))
        self.assertTrue(np.isfinite(expected).all())
        for other in copies(model):
            self.assertEqual(other, model)
            np.testing.assert_array_equal(other.equations().reference, expected)

    def test_results_in_folders_are_read_from_there(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            self.addCleanup(os.chdir, Path.cwd())
            os.chdir(folder)
            result = tegula.run(cantilever(), "out")
            data = pickle.dumps(result)
            self.assertLess(len(data), 500)
            os.chdir("/")
            again = pickle.loads(data)
            self.assertEqual(again.folder, Path(folder).resolve() / "out")
            self.assertEqual(again.summary, result.summary)

    def test_results_in_temporary_folders_bring_their_files(self) -> None:
        result = tegula.run(cantilever())
        frame = copy.deepcopy(result).frames[-1]
        self.assertEqual(frame.path.parent, result.frames[-1].path.parent)
        data = pickle.dumps((result, result.frames[-1], result.history))
        expected = {path.name: path.read_bytes() for path in result.folder.iterdir() if path.is_file()}
        self.assertGreater(len(expected), 4)
        tip, summary = result.history["tip.uz"], result.summary
        first = result.folder
        del result, frame
        gc.collect()
        self.assertFalse(first.exists())
        again, frame, history = pickle.loads(data)
        self.assertEqual({path.name: path.read_bytes() for path in again.folder.iterdir() if path.is_file()}, expected)
        self.assertEqual(again.summary, summary)
        np.testing.assert_array_equal(again.history["tip.uz"], tip)
        np.testing.assert_array_equal(history["tip.uz"], tip)
        with self.assertRaisesRegex(ValueError, "read-only"):
            history["tip.uz"][0] = 1.0
        # The frame keeps the one folder of both.
        folder = again.folder
        self.assertEqual(frame, again.frames[-1])
        del again
        gc.collect()
        self.assertTrue(frame.path.exists())
        del frame
        gc.collect()
        self.assertFalse(folder.exists())

    def test_tables_are_read_whole_and_without_unfinished_rows(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            result = tegula.run(cantilever(), folder)
            text = 'time,"a, b"\n0.1,NaN\n1e-300,-0.0\n2.0,1.2'
            (Path(folder) / "own.csv").write_text(text)
            table = result.table("own.csv")
        self.assertEqual(list(table), ["time", "a, b"])
        self.assertEqual(table["time"].tolist(), [0.1, 1e-300])
        self.assertTrue(np.isnan(table["a, b"][0]) and np.signbit(table["a, b"][1]))
        for other in copies(table):
            np.testing.assert_array_equal(other["a, b"], table["a, b"])
            self.assertFalse(other["time"].flags.writeable)

    def test_results_of_steps_and_modes_keep_their_parts(self) -> None:
        steps = [
            {"name": "preload", "analysis": {"type": "static"}},
            {"name": "modes", "analysis": {"type": "modal", "modes": 2}},
        ]
        result = tegula.run(cantilever(analysis=None, steps=steps)).analyses["modes"]
        for other in copies(result):
            np.testing.assert_array_equal(other.frequencies, result.frequencies)
            self.assertEqual(len(other.modes), 2)
            self.assertTrue(all(frame.path.exists() for frame in other.modes))
        inputs = [{"name": "force", "loads": cantilever()["loads"]}]
        analysis = {"type": "modal", "modes": 2, "inputs": inputs}
        space = tegula.run(cantilever(analysis=analysis, loads=[])).state_space
        for other in copies(space):
            np.testing.assert_array_equal(other.a, space.a)
            self.assertEqual((other.inputs, other.outputs), (space.inputs, space.outputs))

    def test_processes_take_models_and_give_results_and_states(self) -> None:
        model = tegula.Model(of_arrays())
        simulation = model.simulation()
        simulation.advance()
        context = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
            result, state = (pool.submit(operator.methodcaller(*call), model) for call in (("run",), ("equations",)))
            found = result.result().history["tip.uz"]
            # Equations do not leave their process, and the pool says why.
            with self.assertRaisesRegex(TypeError, "pickle the model"):
                state.result()
            forces = pool.submit(_forces_of, model, simulation.state).result()
        own = model.run().history["tip.uz"]
        self.assertLess(own[-1], -1e-4)
        np.testing.assert_array_equal(found, own)
        np.testing.assert_array_equal(forces, simulation.equations.residual(simulation.state))
        self.assertLess(np.abs(forces).max(), 1e-6 * YOUNG * THICKNESS)


def _forces_of(model: tegula.Model, state: tegula.State) -> Any:
    return model.equations().residual(state)


if __name__ == "__main__":
    unittest.main()
