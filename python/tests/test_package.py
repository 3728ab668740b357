"""The package as its users see it: models, runs, results, errors, simulations."""

import copy
import json
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import tegula

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

# Length, width, thickness, Young's modulus, line load.
LENGTH, WIDTH, THICKNESS, YOUNG, LOAD = 10.0, 1.0, 0.1, 2.1e11, -1e3
INERTIA = WIDTH * THICKNESS**3 / 12.0


def cantilever(**changes: Any) -> dict[str, Any]:
    """A strip without Poisson's effect, clamped at one end and loaded at the other one."""
    keys: dict[str, Any] = {
        "title": "cantilever",
        "analysis": {"type": "static"},
        "mesh": {"type": "plate", "size": np.array([LENGTH, WIDTH]), "grid": {"elements": (20, 2)}},
        "materials": {
            "steel": {"type": "isotropic", "young": np.float64(YOUNG), "poisson": 0, "density": 7850.0}
        },
        "sections": [{"material": "steel", "thickness": THICKNESS}],
        "conditions": [{"type": "clamp", "on": "u_min"}],
        "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, LOAD]}],
        "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False},
    }
    return {**keys, **changes}


SCHEME = {"type": "energy-momentum"}
SWING: dict[str, Any] = {"type": "transient", "end_time": 0.05, "time_step": 1e-3, "scheme": SCHEME}


class Models(unittest.TestCase):
    def test_dictionaries_and_text_give_equal_models(self) -> None:
        model = tegula.Model(cantilever())
        self.assertEqual(model.title, "cantilever")
        again = tegula.Model.from_toml(model.text, path="<dict>")
        self.assertEqual(model, again)
        self.assertEqual(tegula.Model(model.keys()).text, model.text)
        self.assertEqual(model.keys()["mesh"]["size"], [LENGTH, WIDTH])

    def test_models_are_copied_and_pickled(self) -> None:
        model = tegula.Model(cantilever())
        for other in (copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
            self.assertEqual(other, model)
            self.assertEqual(hash(other), hash(model))

    def strip(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Nodes and elements of the mesh of the cantilever."""
        x, y = np.meshgrid(np.linspace(0.0, LENGTH, 21), np.linspace(0.0, WIDTH, 3), indexing="ij")
        nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(63)])
        first = (3 * np.arange(20)[:, None] + np.arange(2)).ravel()
        return nodes, np.column_stack([first, first + 3, first + 4, first + 1])

    def tip(self, mesh: dict[str, Any]) -> float:
        keys = cantilever(mesh=mesh, conditions=[{"type": "clamp", "on": "root"}])
        keys["loads"][0]["on"] = "end"
        keys["output"]["points"][0]["on"] = "corner"
        return float(tegula.Model(keys).run().history["tip.uz"][-1])

    def test_meshes_of_arrays_are_those_of_the_generator(self) -> None:
        nodes, quads = self.strip()
        mesh = {"type": "arrays", "nodes": nodes, "quads": quads, "node_sets": {"root": np.arange(3), "corner": [60]},
                "edge_sets": {"end": np.array([[60, 61], [61, 62]])}}
        expected = float(tegula.Model(cantilever()).run().history["tip.uz"][-1])
        self.assertAlmostEqual(self.tip(mesh) / expected, 1.0, places=9)
        mesh["quads"] = np.where(quads == 62, 63, quads)
        with self.assertRaisesRegex(tegula.ModelError, "element 39 has the node 63, and the mesh has 63 nodes"):
            self.tip(mesh)

    def test_meshes_of_meshio_and_pyvista_become_models(self) -> None:
        try:
            import meshio  # type: ignore[import-not-found, import-untyped, unused-ignore]
            import pyvista  # type: ignore[import-not-found, import-untyped, unused-ignore]
        except ImportError as missing:
            self.skipTest(str(missing))
        nodes, quads = self.strip()
        end = [[60, 61], [61, 62]]
        expected = float(tegula.Model(cantilever()).run().history["tip.uz"][-1])
        # Sets of two blocks of elements, of lines and of points; two coordinates; a node that no element has.
        sets = {"left": [np.arange(10), [], [], []], "both": [[9], [0], [], []], "end": [[], [], [0, 1], []], "corner": [[], [], [], [0]],
                "gmsh:bounding_entities": [[0], [], [], []]}
        cells = [("quad", quads[:20]), ("quad", quads[20:]), ("line", end), ("vertex", [[60]])]
        mesh = meshio.Mesh(np.vstack([nodes[:, :2], [[9.0, 9.0]]]), cells, cell_sets=sets, point_sets={"root": np.arange(3), "reference": [63]})
        taken = tegula.from_meshio(mesh)
        self.assertEqual(taken["quad_sets"]["left"].tolist(), list(range(10)))
        self.assertEqual(taken["quad_sets"]["both"].tolist(), [9, 20])
        self.assertEqual(taken["edge_sets"]["end"].tolist(), end)
        self.assertEqual({*taken["node_sets"]}, {"root", "corner"})
        self.assertAlmostEqual(self.tip(taken) / expected, 1.0, places=9)
        # Physical groups, as of Gmsh.
        groups = meshio.Mesh(nodes, cells[:3], cell_data={"gmsh:physical": [np.full(20, 7), np.full(20, 8), np.full(2, 7)]},
                             field_data={"first": np.array([7, 2]), "end": np.array([7, 1])}, point_sets={"root": [0, 1, 2], "corner": [60]})
        taken = tegula.from_meshio(groups)
        self.assertEqual(taken["quad_sets"]["first"].tolist(), list(range(20)))
        self.assertEqual(taken["quad_sets"]["8"].tolist(), list(range(20, 40)))
        self.assertAlmostEqual(self.tip(taken) / expected, 1.0, places=9)
        triangles = meshio.Mesh(nodes, [("triangle", [[0, 1, 3]])])
        with self.assertRaisesRegex(ValueError, "1 cells of type triangle"):
            tegula.from_meshio(triangles)

        surface = pyvista.PolyData(nodes, np.column_stack([np.full(40, 4), quads]))
        surface.point_data["root"] = np.arange(63) < 3
        surface.point_data["corner"] = np.arange(63) == 60
        surface.cell_data["end"] = np.arange(40) >= 38
        taken = tegula.from_pyvista(surface)
        self.assertEqual(taken["quad_sets"]["end"].tolist(), [38, 39])
        taken["edge_sets"] = {"end": end}
        taken.pop("quad_sets")
        self.assertAlmostEqual(self.tip(taken) / expected, 1.0, places=9)
        image = pyvista.ImageData(dimensions=(3, 2, 1))
        self.assertEqual(tegula.from_pyvista(image)["quads"].tolist(), [[0, 1, 4, 3], [1, 2, 5, 4]])
        with self.assertRaisesRegex(ValueError, "combine"):
            tegula.from_pyvista(pyvista.MultiBlock([surface]))
        with self.assertRaisesRegex(ValueError, "number 5 of VTK"):
            tegula.from_pyvista(pyvista.PolyData(nodes, [3, 0, 1, 3]))

    def test_keys_that_are_none_are_left_out(self) -> None:
        self.assertNotIn("title", tegula.Model(cantilever(title=None)).keys())

    def test_every_mistake_is_named_with_its_key(self) -> None:
        keys = cantilever(loads=[{"type": "edge", "on": "u_max", "valu": [0, 0, 1]}])
        keys["sections"][0]["thickness"] = -1.0
        with self.assertRaises(tegula.ModelError) as caught:
            tegula.Model(keys).check()
        found = caught.exception.diagnostics
        self.assertIn("loads[0].valu", [d.key for d in found])
        self.assertIn('unknown key "valu" (did you mean "value"?)', str(caught.exception))
        self.assertEqual(str(pickle.loads(pickle.dumps(caught.exception))), str(caught.exception))

    def test_sets_are_checked_with_the_mesh(self) -> None:
        model = tegula.Model(cantilever(conditions=[{"type": "clamp", "on": "left"}]))
        for refused in (model.check, model.run, model.simulation):
            with self.assertRaises(tegula.ModelError) as caught:
                refused()
            self.assertEqual(caught.exception.diagnostics[0].key, "conditions[0].on")

    def test_values_without_a_counterpart_are_refused_at_their_place(self) -> None:
        endless: list[Any] = []
        endless.append(endless)
        for value, error in ((object(), TypeError), (10**30, ValueError), (endless, ValueError), (1j, TypeError)):
            keys = cantilever(loads=[{"type": "edge", "on": "u_max", "value": [0.0, 0.0, value]}])
            with self.assertRaisesRegex(error, r"^loads\[0\]\.value\[2\]"):
                tegula.Model(keys)

    def test_values_that_are_no_numbers_are_refused(self) -> None:
        for value in (float("nan"), float("inf")):
            keys = cantilever(loads=[{"type": "edge", "on": "u_max", "value": [0.0, 0.0, value]}])
            with self.assertRaises(tegula.ModelError):
                tegula.Model(keys).check()

    def test_files_that_do_not_exist_are_model_errors(self) -> None:
        with self.assertRaisesRegex(tegula.ModelError, "there is no such file"):
            tegula.Model.read("no_such_model.toml")


class Runs(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name) / "result"

    def test_the_tip_of_a_cantilever_sinks_as_beam_theory_says(self) -> None:
        seen: list[tegula.Progress] = []
        result = tegula.Model(cantilever()).run(self.out, progress=seen.append)
        exact = LOAD * WIDTH * LENGTH**3 / (3.0 * YOUNG * INERTIA)
        self.assertEqual(result.status, "complete")
        self.assertLess(abs(result.history["tip.uz"][-1] / exact - 1.0), 1e-3)
        self.assertLess(abs(result.history["support.u_min.fz"][-1] + LOAD * WIDTH), 1e-6)
        self.assertEqual([p.step for p in seen], [0, 1])
        self.assertEqual(seen[-1].time, 1.0)
        self.assertEqual(json.loads((self.out / "summary.json").read_text()), result.summary)
        again = tegula.Result(self.out)
        np.testing.assert_array_equal(again.history["tip.uz"], result.history["tip.uz"])

    def test_results_in_a_temporary_folder_last_as_long_as_the_result(self) -> None:
        result = tegula.run(cantilever())
        folder = result.folder
        self.assertTrue(all(frame.path.exists() for frame in result.frames))
        self.assertEqual(len(result.frames), 2)
        del result
        self.assertFalse(folder.exists())

    def test_frames_are_arrays_without_other_packages(self) -> None:
        result = tegula.Model(cantilever()).run()
        grid = result.frames[-1].read()
        x, y = np.meshgrid(np.linspace(0.0, LENGTH, 21), np.linspace(0.0, WIDTH, 3), indexing="ij")
        expected = np.column_stack([x.ravel(), y.ravel(), np.zeros(63)])
        order, rows = np.lexsort(expected.T), np.lexsort(np.round(grid.points, 9).T)
        self.assertLess(np.abs(grid.points[rows] - expected[order]).max(), 1e-12)
        self.assertEqual((grid.quads.shape, grid.lines.shape), ((40, 4), (0, 2)))
        # All corners of an element are an element apart at most.
        corners = grid.points[grid.quads]
        self.assertLess(abs(np.ptp(corners[:, :, 0], axis=1) - LENGTH / 20.0).max(), 1e-12)
        deflection = grid.point_data["displacement"][:, 2]
        tip = result.history["tip.uz"][-1]
        self.assertLess(abs(deflection.min() / tip - 1.0), 1e-9)
        for name in grid.cell_data:
            self.assertEqual(len(grid.cell_data[name]), 40)
        with self.assertRaisesRegex(KeyError, "there is no field 'heat'; there are: .*displacement"):
            grid.point_data["heat"]
        with tempfile.TemporaryDirectory() as folder:
            broken = Path(folder) / "broken.vtu"
            broken.write_text(result.frames[-1].path.read_text()[:2000])
            with self.assertRaises(tegula.OutputError):
                tegula.Frame(0.0, broken).read()

    def test_fields_are_read_by_meshio_and_pyvista(self) -> None:
        try:
            import meshio  # type: ignore[import-not-found, import-untyped, unused-ignore]  # noqa: F401
            import pyvista  # type: ignore[import-not-found, import-untyped, unused-ignore]  # noqa: F401
        except ImportError as missing:
            self.skipTest(str(missing))
        result = tegula.run(cantilever())
        mesh = result.frames[-1].to_meshio()
        grid = result.frames[-1].to_pyvista()
        self.assertEqual(mesh.points.shape, (63, 3))
        self.assertEqual((grid.n_points, grid.n_cells), (63, 40))
        lowest = result.history["tip.uz"][-1]
        for values in (mesh.point_data["displacement"], grid.point_data["displacement"]):
            self.assertLess(abs(np.min(values[:, 2]) / lowest - 1.0), 1e-6)

    def test_frequencies_of_a_free_strip(self) -> None:
        keys = cantilever(analysis={"type": "modal", "modes": 7}, conditions=[], loads=[])
        result = tegula.run(keys)
        self.assertLess(np.abs(result.frequencies[:6]).max(), 1e-6 * result.frequencies[6])
        # Free beam: (4.730041/L)² √(EI/ρA), S. Timoshenko, Vibration Problems in Engineering.
        exact = 4.730041**2 / LENGTH**2 * np.sqrt(YOUNG * INERTIA / (7850.0 * WIDTH * THICKNESS)) / (2.0 * np.pi)
        self.assertLess(abs(result.frequencies[6] / exact - 1.0), 5e-3)
        self.assertEqual(len(result.modes), 7)
        with self.assertRaisesRegex(tegula.OutputError, "no buckling analysis"):
            _ = result.load_factors
        with self.assertRaisesRegex(tegula.OutputError, "no state space"):
            _ = result.state_space
        with self.assertRaisesRegex(tegula.OutputError, "no history"):
            _ = result.history

    def test_the_state_space_has_the_modes_as_eigenvalues(self) -> None:
        force = {"type": "edge", "on": "u_max", "value": [0.0, 0.0, 1.0]}
        inputs = [{"name": "force", "loads": [force]}]
        analysis = {"type": "modal", "modes": 4, "damping_ratio": 0.01, "inputs": inputs}
        result = tegula.run(cantilever(analysis=analysis, loads=[]))
        system = result.state_space
        states = 2 * len(system.omega)
        shapes = [matrix.shape for matrix in (system.a, system.b, system.c, system.d)]
        self.assertEqual(shapes, [(states, states), (states, 1), (3, states), (3, 1)])
        self.assertEqual((system.inputs, system.outputs), (["force"], ["tip.ux", "tip.uy", "tip.uz"]))
        np.testing.assert_allclose(system.omega[:4], 2.0 * np.pi * result.frequencies, rtol=1e-12)
        np.testing.assert_allclose(system.damping_ratio[:4], 0.01, rtol=1e-12)
        values = np.linalg.eigvals(system.a)
        lowest = values[np.argmin(np.abs(values))]
        self.assertLess(abs(-lowest.real / abs(lowest) / 0.01 - 1.0), 1e-9)
        self.assertLess(abs(abs(lowest) / system.omega[0] - 1.0), 1e-9)
        # Static response: force/area along the edge.
        static = system.d - system.c @ np.linalg.solve(system.a, system.b)
        exact = WIDTH * LENGTH**3 / (3.0 * YOUNG * INERTIA)
        self.assertLess(abs(static[2, 0] / exact - 1.0), 1e-3)

    def test_runs_with_steps_have_the_result_of_each(self) -> None:
        steps = [
            {"name": "preload", "analysis": {"type": "static"}},
            {"name": "modes", "analysis": {"type": "modal", "modes": 1}},
        ]
        keys = cantilever(analysis=None, steps=steps)
        result = tegula.run(keys)
        self.assertEqual(list(result.analyses), ["preload", "modes"])
        self.assertLess(result.analyses["preload"].history["tip.uz"][-1], 0.0)
        self.assertEqual(len(result.analyses["modes"].frequencies), 1)
        with self.assertRaisesRegex(ValueError, "run"):
            tegula.Model(keys).simulation()

    def test_paths_have_the_results_of_their_branches(self) -> None:
        keys = tegula.Model.read(EXAMPLES / "arch_branches.toml").keys()
        keys["output"]["pictures"] = False
        result = tegula.run(keys)
        points = [p for p in result.summary["critical_points"] if p["kind"] == "bifurcation"]
        self.assertGreater(len(points), 0)
        self.assertEqual(set(result.branches), {side * (i + 1) for i in range(len(points)) for side in (1, -1)})
        for number, branch in result.branches.items():
            self.assertEqual(branch.status, "complete")
            # The arch leans to one side behind the bifurcation, to the other one on the counterpart, and never on the path.
            sway, other = (result.branches[n].history["top.ux"] for n in (number, -number))
            first, counterpart = (s[np.argmax(np.abs(s) > 1e-4)] for s in (sway, other))
            self.assertGreater(abs(first), 1e-4, f"branch {number}")
            self.assertEqual(np.sign(first), -np.sign(counterpart), f"branch {number}")
        self.assertLess(np.abs(result.history["top.ux"]).max(), 1e-6)

    def test_folders_of_other_models_are_not_overwritten(self) -> None:
        tegula.run(EXAMPLES / "cantilever_plate.toml", self.out)
        other = tegula.Model(cantilever(title="another"))
        with self.assertRaisesRegex(tegula.OutputError, "cantilever_plate.toml"):
            other.run(self.out)
        self.assertEqual(other.run(self.out, force=True).summary["title"], "another")
        again = tegula.Model(cantilever(title="a third one"))
        with self.assertRaisesRegex(tegula.OutputError, "`force=True`"):
            again.run(self.out)
        other.run(self.out)
        with self.assertRaisesRegex(ValueError, "empty"):
            other.run("")

    def test_forked_processes_are_told_that_they_have_no_threads(self) -> None:
        program = (
            "import os, tegula\n"
            f"model = tegula.Model.from_toml({tegula.Model(cantilever()).text!r})\n"
            "model.check()\n"
            "if os.fork() == 0:\n"
            "    try:\n"
            "        model.run()\n"
            "    except RuntimeError as error:\n"
            "        print(error, flush=True)\n"
            "    os._exit(0)\n"
            "os.wait()\n"
        )
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        self.assertIn('get_context("spawn")', done.stdout)

    def test_failures_name_the_cause_and_keep_the_results_so_far(self) -> None:
        # The column buckles before full load.
        euler = np.pi**2 * YOUNG * INERTIA / (4.0 * LENGTH**2)
        loads = [{"type": "edge", "on": "u_max", "value": [-3.0 * euler / WIDTH, 0.0, 0.0]}]
        with self.assertRaises(tegula.AnalysisError) as caught:
            tegula.Model(cantilever(loads=loads)).run(self.out)
        self.assertIn("buckl", str(caught.exception))
        self.assertEqual(caught.exception.folder, self.out)
        self.assertEqual(tegula.Result(self.out).status, "failed")
        partial = caught.exception.result
        assert partial is not None
        self.assertEqual(partial.history["time"][0], 0.0)
        self.assertIn("buckl", str(pickle.loads(pickle.dumps(caught.exception))))

    def test_exceptions_of_the_progress_end_the_run_which_resumes(self) -> None:
        class Enough(Exception):
            pass

        def stop(progress: tegula.Progress) -> None:
            if progress.step == 20:
                raise Enough

        model = tegula.Model(cantilever(analysis=SWING))
        with self.assertRaises(Enough):
            model.run(self.out, progress=stop)
        self.assertEqual(tegula.Result(self.out).status, "interrupted")
        resumed = model.run(self.out, resume=True)
        whole = model.run()
        np.testing.assert_array_equal(resumed.history["tip.uz"], whole.history["tip.uz"])

    def test_ctrl_c_ends_the_run_after_the_step(self) -> None:
        long = {**SWING, "end_time": 1e3}
        program = (
            "import signal, tegula\n"
            # Programs in the background of a shell ignore Ctrl-C.
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            f"model = tegula.Model.from_toml({tegula.Model(cantilever(analysis=long)).text!r})\n"
            "try:\n"
            f"    model.run({str(self.out)!r}, progress=lambda p: p.step == 3 and print('begun', flush=True))\n"
            "except KeyboardInterrupt as error:\n"
            "    print(error)\n"
        )
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert child.stdout is not None
        self.assertEqual(child.stdout.readline(), "begun\n")
        child.send_signal(signal.SIGINT)
        rest, _ = child.communicate(timeout=60)
        self.assertEqual(child.returncode, 0, rest)
        self.assertIn("resume=True", rest)
        self.assertIn(str(self.out), rest)
        self.assertEqual(tegula.Result(self.out).status, "interrupted")

    def test_other_threads_run_meanwhile(self) -> None:
        finished = threading.Event()
        counts = 0

        def solve() -> None:
            tegula.run(cantilever(analysis={**SWING, "end_time": 0.5}))
            finished.set()

        thread = threading.Thread(target=solve)
        thread.start()
        while not finished.is_set():
            counts += 1
            time.sleep(1e-3)
        thread.join()
        self.assertGreater(counts, 10)

    def test_warnings_of_a_model_are_warnings_of_python(self) -> None:
        # Its loads have no effect.
        keys = cantilever(analysis={"type": "modal", "modes": 1})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = tegula.run(keys)
        found = [str(w.message) for w in caught if issubclass(w.category, tegula.ModelWarning)]
        self.assertEqual(found, result.warnings)
        self.assertTrue(found)
        self.assertEqual({w.filename for w in caught}, {__file__})

    def test_statics_warns_where_a_very_stiff_spring_does_not_carry_its_load(self) -> None:
        axis = [1.0, 0.0, 0.0]
        bodies = [{"name": name, "at": [x, 0.0, 0.0], "mass": 1.0} for name, x in (("a", 1.0), ("b", 2.0))]
        guides = [{"type": "prismatic", "name": f"guide.{b['name']}", "between": ["ground", b["name"]], "at": b["at"],
                   "axis": axis} for b in bodies]
        guided = [{**b, "inertia": [1.0, 1.0, 1.0]} for b in bodies]
        warned = {}
        for stiff in (1e6, 1e16):
            springs = [
                {"name": "stiff", "between": ["ground", "a"], "points": [[0.3, 0.0, 0.0], [1.0, 0.0, 0.0]], "stiffness": stiff},
                {"name": "soft", "between": ["a", "b"], "points": [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], "stiffness": 100.0},
            ]
            keys = {"analysis": {"type": "static"}, "bodies": guided, "joints": guides, "springs": springs,
                    "loads": [{"type": "force", "on": "b", "value": axis}], "output": {"pictures": False}}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    result = tegula.run(keys)
                except tegula.AnalysisError:
                    warned[stiff] = True
                    continue
            carried = abs(abs(result.history["spring.stiff.force"][-1]) - 1.0) < 1e-3
            warned[stiff] = any("balance only up to" in w for w in result.warnings)
            self.assertTrue(carried or warned[stiff])
        self.assertEqual(warned, {1e6: False, 1e16: True})

    def test_what_is_no_result_folder_is_told(self) -> None:
        with self.assertRaisesRegex(tegula.OutputError, "no result folder"):
            tegula.Result(self.out)
        result = tegula.Model(cantilever()).run(self.out)
        with self.assertRaisesRegex(KeyError, "tip.uz"):
            _ = result.history["tip.u"]
        for damaged in ("time,a\n1,2,3\n", "", "time\n0.0\nx\n"):
            (self.out / "history.csv").write_text(damaged)
            with self.assertRaisesRegex(tegula.OutputError, "history.csv` cannot be used"):
                _ = tegula.Result(self.out).history
        for damaged in ("{}", "[]", "null", "{"):
            (self.out / "summary.json").write_text(damaged)
            with self.assertRaisesRegex(tegula.OutputError, "damaged"):
                tegula.Result(self.out)


class Simulations(unittest.TestCase):
    def test_a_simulation_gives_the_history_of_the_run(self) -> None:
        model = tegula.Model(cantilever(analysis=SWING))
        history = model.run().history
        simulation = model.simulation()
        row = 0
        while True:
            values = simulation.values()
            self.assertEqual(list(values), list(history))
            for name, column in history.items():
                self.assertEqual(values[name], column[row], f"{name} at row {row}")
            if simulation.finished:
                break
            simulation.advance()
            row += 1
        self.assertEqual(row, len(history["time"]) - 1)
        self.assertEqual(simulation.time, simulation.end)
        self.assertEqual(simulation.statistics.steps, row)
        with self.assertRaisesRegex(ValueError, "come to its end"):
            simulation.advance()

    def test_arrays_have_a_row_for_each_node(self) -> None:
        simulation = tegula.Model(cantilever(analysis=SWING)).simulation()
        first = simulation.positions
        simulation.advance(5)
        tip = simulation.nodes_on("u_max")
        self.assertEqual(simulation.quads.shape, (40, 4))
        self.assertEqual(first.shape, (63, 3))
        np.testing.assert_allclose(simulation.positions - simulation.displacements, first, atol=1e-14)
        self.assertEqual(simulation.displacements[tip[0], 2], simulation.values()["tip.uz"])
        np.testing.assert_allclose(np.linalg.norm(simulation.directors, axis=1), 1.0, atol=1e-3)
        self.assertTrue((simulation.velocities[tip, 2] < 0.0).all())
        np.testing.assert_allclose(first[tip, 0], LENGTH, atol=1e-12)
        self.assertAlmostEqual(simulation.energies.kinetic, simulation.values()["kinetic"])
        with self.assertRaisesRegex(KeyError, "no set"):
            simulation.nodes_on("nowhere")

    def test_a_signal_takes_the_place_of_an_amplitude(self) -> None:
        keys = cantilever(analysis=SWING, amplitudes={"push": {"type": "constant", "value": 0.0}})
        keys["loads"][0]["amplitude"] = "push"
        model = tegula.Model(keys)
        simulation = model.simulation(signals=["push"])
        self.assertEqual((simulation.signals, simulation.signal("push")), (["push"], 0.0))
        simulation.advance(2)
        self.assertEqual(np.abs(simulation.displacements).max(), 0.0)
        simulation.set("push", 1.0)
        simulation.advance(2)
        self.assertLess(simulation.values()["tip.uz"], 0.0)
        with self.assertRaisesRegex(KeyError, "push"):
            simulation.set("pull", 1.0)
        with self.assertRaisesRegex(KeyError, "no amplitude"):
            model.simulation(signals=["pull"])
        keys["analysis"] = {"type": "static"}
        with self.assertRaisesRegex(ValueError, "transient"):
            tegula.Model(keys).simulation(signals=["push"])
        for scheme in ("newmark", "hht", "generalized-alpha", "bdf2", "explicit"):
            keys["analysis"] = {**SWING, "scheme": {"type": scheme}}
            with self.assertRaisesRegex(ValueError, "energy-momentum"):
                tegula.Model(keys).simulation(signals=["push"])
        keys["analysis"] = SWING
        keys["conditions"].append({"type": "prescribe", "on": "u_max", "component": "y", "value": 1.0, "amplitude": "push"})
        with self.assertRaisesRegex(ValueError, "moves supports"):
            tegula.Model(keys).simulation(signals=["push"])
        keys["conditions"].pop()
        keys["materials"]["steel"]["expansion"] = 1e-5
        keys["prescribed_strains"] = [{"type": "thermal", "temperature": 10.0, "amplitude": "push"}]
        with self.assertRaisesRegex(ValueError, "scales prescribed strains"):
            tegula.Model(keys).simulation(signals=["push"])

    def test_values_refer_to_the_last_step_whatever_is_set_for_the_next_one(self) -> None:
        keys = cantilever(analysis=SWING, amplitudes={"push": {"type": "constant", "value": 1.0}})
        keys["loads"][0]["amplitude"] = "push"
        simulation = tegula.Model(keys).simulation(signals=["push"])
        simulation.advance(3)
        before = simulation.values()
        simulation.set("push", 100.0)
        self.assertEqual(simulation.values(), before)
        self.assertEqual(simulation.signal("push"), 100.0)
        self.assertLess(abs(before["load.edge.u_max.fz"] / (LOAD * WIDTH) - 1.0), 1e-12)
        simulation.advance()
        self.assertLess(abs(simulation.values()["load.edge.u_max.fz"] / (100.0 * LOAD * WIDTH) - 1.0), 1e-12)
        for value in (float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "push"):
                simulation.set("push", value)

    def test_the_work_of_signals_is_the_energy_that_the_model_gains(self) -> None:
        keys = cantilever(analysis=SWING, conditions=[], amplitudes={"push": {"type": "constant", "value": 0.0}})
        keys["loads"][0]["amplitude"] = "push"
        simulation = tegula.Model(keys).simulation(signals=["push"])
        momentum, step = 0.0, SWING["time_step"]
        for value in (2.0, 0.0, 0.0, -4.0, 0.0, 1.0):
            simulation.set("push", value)
            simulation.advance()
            momentum += value * LOAD * WIDTH * step
            energies = simulation.energies
            self.assertLess(abs(simulation.values()["pz"] - momentum), 1e-9 * abs(LOAD) * step)
            self.assertLess(abs(energies.kinetic + energies.strain - energies.work), 1e-9 * energies.kinetic)

    def test_a_joint_that_a_signal_drives_turns_its_body(self) -> None:
        body = {"name": "wheel", "at": [0.0, 0.0, 0.0], "mass": 1.0, "inertia": [1.0, 1.0, 1.0]}
        pivot = {"type": "revolute", "name": "pivot", "between": ["ground", "wheel"], "at": [0.0, 0.0, 0.0],
                 "axis": [0.0, 0.0, 1.0]}
        motor = {"type": "driven-angle", "name": "motor", "between": ["ground", "wheel"], "axis": [0.0, 0.0, 1.0],
                 "angle": 180.0 / np.pi, "amplitude": "angle"}
        keys = {"analysis": SWING, "bodies": [body], "joints": [pivot, motor],
                "amplitudes": {"angle": {"type": "constant", "value": 0.0}}}
        simulation = tegula.Model(keys).simulation(signals=["angle"])
        acceleration = 3.0
        while not simulation.finished:
            end = simulation.time + SWING["time_step"]
            simulation.set("angle", 0.5 * acceleration * end**2)
            simulation.advance()
        speed = acceleration * simulation.time
        self.assertLess(abs(simulation.values()["lz"] / speed - 1.0), 0.02)
        self.assertLess(abs(simulation.energies.work / (0.5 * speed**2) - 1.0), 0.05)

    def test_a_failed_step_leaves_the_state_as_it_was(self) -> None:
        keys = cantilever(analysis=SWING)
        keys["amplitudes"] = {"push": {"type": "constant", "value": 0.0}}
        keys["loads"][0]["amplitude"] = "push"
        one, other = (tegula.Model(keys).simulation(signals=["push"]) for _ in range(2))
        one.advance()
        other.advance()
        one.set("push", 1e300)
        before = one.values()
        with self.assertRaises(tegula.AnalysisError):
            one.advance()
        self.assertEqual(one.values(), before)
        for simulation in (one, other):
            simulation.set("push", 1e-6)
            simulation.advance()
        self.assertEqual(one.time, other.time)
        scale = np.abs(other.displacements).max()
        np.testing.assert_allclose(one.displacements, other.displacements, rtol=0.0, atol=1e-6 * scale)

    def test_steps_are_repeated_with_other_signals(self) -> None:
        for analysis in (SWING, {**SWING, "time_step": None}):
            keys = cantilever(analysis=analysis, amplitudes={"push": {"type": "constant", "value": 1.0}})
            keys["loads"][0]["amplitude"] = "push"
            one, other = (tegula.Model(keys).simulation(signals=["push"]) for _ in range(2))
            for refused in (one, other):
                with self.assertRaisesRegex(ValueError, "no step to repeat"):
                    refused.repeat()
            one.advance(3)
            other.advance(3)
            start, energies, time = other.displacements, other.energies, other.time
            one.advance()
            end = one.time
            other.set("push", 1.5)
            other.advance()
            for push in (0.5, 1.0):
                other.repeat()
                with self.assertRaisesRegex(ValueError, "undone"):
                    other.values()
                self.assertEqual(other.time, time)
                np.testing.assert_array_equal(other.displacements, start)
                np.testing.assert_allclose(other.energies, energies, rtol=1e-12, atol=1e-12)
                # A step that fails still ends there when it is taken again.
                other.set("push", 1e300)
                with self.assertRaises(tegula.AnalysisError):
                    other.advance()
                other.set("push", push)
                other.advance()
            self.assertEqual(other.time, end)
            scale = np.abs(one.displacements).max()
            np.testing.assert_allclose(other.displacements, one.displacements, rtol=0.0, atol=1e-6 * scale)
            with self.assertRaisesRegex(ValueError, "no step to repeat"):
                other.repeat()
                other.repeat()

    def test_analyses_without_steps_are_refused(self) -> None:
        keys = cantilever(analysis={"type": "modal", "modes": 1})
        with self.assertRaisesRegex(ValueError, "no steps"):
            tegula.Model(keys).simulation()

    def test_simulations_warn_about_their_model(self) -> None:
        keys = cantilever()
        keys["mesh"]["origin"] = [1e8, 0.0, 0.0]
        warned = tegula.Model(keys).check()
        self.assertTrue(warned)
        with self.assertWarns(tegula.ModelWarning) as caught:
            tegula.Model(keys).simulation()
        self.assertIn(str(caught.warning), warned)

    def test_a_simulation_advances_beside_runs_that_read_it(self) -> None:
        simulation = tegula.Model(cantilever(analysis={**SWING, "end_time": 1.0})).simulation()
        times: list[float] = []

        def solve() -> None:
            tegula.Model(cantilever(analysis=SWING)).run(progress=lambda _: times.append(simulation.time))

        runs = [threading.Thread(target=solve) for _ in range(4)]
        steps = threading.Thread(target=lambda: [simulation.advance() for _ in range(100)])
        for thread in (*runs, steps):
            thread.start()
        for thread in (*runs, steps):
            thread.join(timeout=60)
            self.assertFalse(thread.is_alive())
        self.assertEqual(len(times), 4 * 51)

    def test_simulations_work_from_several_threads(self) -> None:
        simulation = tegula.Model(cantilever(analysis=SWING)).simulation()
        errors: list[BaseException] = []

        def read() -> None:
            try:
                for _ in range(200):
                    self.assertTrue(np.isfinite(simulation.displacements).all())
            except BaseException as error:
                errors.append(error)

        thread = threading.Thread(target=read)
        thread.start()
        simulation.advance(20)
        thread.join()
        self.assertEqual(errors, [])


if __name__ == "__main__":
    unittest.main()
