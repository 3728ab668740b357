"""Models of objects: the classes of `tegula.parts` have the names and keys of the model file."""

import copy
import dataclasses
import os
import pickle
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

import tegula
from tegula import parts

ROOT = Path(__file__).resolve().parents[2]
LENGTH, THICKNESS, YOUNG, LOAD = 10.0, 0.1, 2.1e11, -1e3


def cantilever() -> parts.Model:
    """A strip of the width 1 without Poisson's effect, clamped at one end and loaded at the other one."""
    return parts.Model(
        analysis=parts.Static(),
        mesh=parts.PlateMesh(size=np.array([LENGTH, 1.0]), grid=parts.Grid(elements=(20, 2))),
        materials={"steel": parts.IsotropicMaterial(young=np.float32(YOUNG), poisson=0, density=7850.0)},
        sections=[parts.Section(material="steel", thickness=THICKNESS)],
        conditions=[parts.Clamp(on="u_min")],
        loads=[parts.EdgeLoad(on="u_max", value=[0.0, 0.0, LOAD])],
        output=parts.Output(points=[parts.OutputPoint(name="tip", on="u_max_v_min")], pictures=False),
    )


def has_tables(value: Any) -> bool:
    """Whether dictionaries with keys of a table are left in a value."""
    if isinstance(value, dict):
        return "type" in value or any(map(has_tables, value.values()))
    if isinstance(value, (list, tuple)):
        return any(isinstance(item, dict) or has_tables(item) for item in value)
    return isinstance(value, parts.Part) and any(map(has_tables, vars(value).values()))


class Parts(unittest.TestCase):
    def test_the_cantilever_of_objects_sinks_as_beam_theory_says(self) -> None:
        exact = LOAD * LENGTH**3 / (3.0 * YOUNG * THICKNESS**3 / 12.0)
        model = cantilever()
        keywords: Any = vars(model)
        for result in (tegula.Model(model).run(), tegula.run(model), tegula.Model(**keywords).run()):
            self.assertLess(abs(result.history["tip.uz"][-1] / exact - 1.0), 1e-3)

    def test_examples_become_objects_and_the_same_models(self) -> None:
        examples = sorted((ROOT / "examples").glob("*.toml"))
        self.assertGreater(len(examples), 30)
        for example in examples:
            with self.subTest(example=example.name):
                read = tegula.Model.read(example)
                objects = parts.Model.from_dict(read.keys())
                self.assertFalse(has_tables(objects))
                self.assertEqual(tegula.Model(objects, folder=example.parent).keys(), read.keys())
                self.assertEqual(parts.Model.from_dict(objects.as_dict()), objects)
                self.assertEqual(eval(repr(objects), vars(parts)), objects)

    def test_objects_and_dictionaries_contain_each_other(self) -> None:
        keys = cantilever().as_dict()
        self.assertEqual(keys["loads"], [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, LOAD]}])
        mixed = {**keys, "loads": [parts.EdgeLoad(on="u_max", value=[0.0, 0.0, LOAD])], "analysis": parts.Static()}
        self.assertEqual(tegula.Model(mixed), tegula.Model(keys))
        model = cantilever()
        model.mesh = keys["mesh"]
        self.assertEqual(tegula.Model(model), tegula.Model(keys))
        step = parts.AnalysisStep(name="one", analysis=parts.Static(continue_="path"))
        self.assertEqual(step.as_dict(), {"name": "one", "analysis": {"type": "static", "continue": "path"}})
        self.assertEqual(parts.AnalysisStep.from_dict(step.as_dict()), step)

    def test_objects_are_copied_changed_compared_and_pickled(self) -> None:
        model = cantilever()
        for other in (copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
            self.assertEqual(other, model)
        load = parts.EdgeLoad(on="u_max", value=np.array([0.0, 0.0, 1.0]))
        self.assertEqual(load, parts.EdgeLoad(on="u_max", value=(0, 0, 1)))
        self.assertNotEqual(load, dataclasses.replace(load, on="u_min"))
        self.assertNotEqual(load, parts.EdgeMomentLoad(on="u_max", value=[0, 0, 1]))
        load.amplitude = "ramp"
        self.assertEqual(load.as_dict()["amplitude"], "ramp")

    def test_wrong_keys_are_named_with_those_that_exist(self) -> None:
        known: Any = parts
        for wrong, message in (
            (lambda: known.EdgeLoad(on="end", valu=[0, 0, 1]), r"EdgeLoad has no key 'valu' \(did you mean 'value'\?\); its keys are: on, value"),
            (lambda: known.EdgeLoad(on="end"), "EdgeLoad needs `value`"),
            (lambda: known.EdgeLoad("end"), r"EdgeLoad takes its keys by their names, as EdgeLoad\(on=…\)"),
            (lambda: known.Model.from_dict({"loads": [{"type": "edge", "valu": 1}]}), r"^loads\[0\]: EdgeLoad has no key 'valu'"),
            (lambda: tegula.Model(analysi=parts.Static()), r"Model has no key 'analysi' \(did you mean 'analysis'\?\)"),  # type: ignore[call-arg]
            (lambda: tegula.Model(parts.Static()), "a tegula.parts.Model is expected, not Static"),  # type: ignore[arg-type]
            (lambda: tegula.Model({}, title="two"), "put title into the argument"),
            (lambda: tegula.Model("model.toml"), "Model.read reads a file"),  # type: ignore[arg-type]
        ):
            with self.assertRaisesRegex(TypeError, message):
                wrong()
        with self.assertRaisesRegex(AttributeError, r"Static has no key 'load_step' \(did you mean 'load_steps'\?\)"):
            known.Static().load_step = 3
        with self.assertRaisesRegex(ValueError, r"^loads\[0\]: the type 'edgy' is unknown \(did you mean 'edge'\?\); there are: force, "):
            parts.Model.from_dict({"loads": [{"type": "edgy"}]})

    def test_wrong_values_are_refused_at_their_place(self) -> None:
        model = cantilever()
        model.sections = [parts.Section(material="steel", thickness=-1.0)]
        with self.assertRaises(tegula.ModelError) as caught:
            tegula.Model(model).check()
        self.assertEqual(caught.exception.diagnostics[0].key, "sections[0].thickness")
        load = parts.EdgeLoad(on="u_max", value=[0.0, 0.0, LOAD])
        load.value = [0.0, load]  # type: ignore[list-item]
        with self.assertRaisesRegex(TypeError, r"^loads\[0\]\.value\[1\]"):
            tegula.Model({"loads": [load]})

    def test_every_class_is_described(self) -> None:
        for name in set(parts.__all__) - {"Part", "ModelKeys"}:
            made = getattr(parts, name)
            if isinstance(made, type):
                self.assertTrue(dataclasses.is_dataclass(made), name)
                for field in dataclasses.fields(made):
                    self.assertIn(f" {field.name}: ", made.__doc__ or "", name)

    def test_classes_are_loaded_when_they_are_asked_for(self) -> None:
        code = "import sys, tegula; tegula.Model.from_toml; assert 'tegula.parts' not in sys.modules; tegula.parts.Static()"
        subprocess.run([sys.executable, "-c", code], check=True)

    def test_mypy_knows_the_keys(self) -> None:
        try:
            import mypy  # noqa: F401
        except ImportError as missing:
            self.skipTest(str(missing))
        text = (
            "from tegula import Model, from_meshio, parts\n"
            "Model(analysis=parts.Static(load_steps=10), mesh=from_meshio(None), loads=[parts.EdgeLoad(on='a', value=[0, 0, -1])])\n"
            "parts.EdgeLoad(on='a', valu=[0, 0, -1])\n"
            "parts.EdgeLoad(on=3, value=[0, 0, -1])\n"
            "parts.Static(method='newto')\n"
            "Model(analysi=parts.Static())\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "snippet.py").write_text(text, encoding="utf-8")
            paths = os.pathsep.join(filter(None, [str(Path(tegula.__file__).parents[1]), os.environ.get("MYPYPATH")]))
            command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--follow-imports=silent", "snippet.py"]
            if Path(tegula.__file__).is_relative_to(ROOT):
                environment = {**os.environ, "MYPYPATH": paths}
            else:
                environment = dict(os.environ)
            found = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8").stdout
        lines = [line for line in found.splitlines() if "error:" in line]
        self.assertEqual({line.split(":")[1] for line in lines}, {"3", "4", "5", "6"}, found)


if __name__ == "__main__":
    unittest.main()
