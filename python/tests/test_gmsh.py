"""The mesh of a model of Gmsh is that of the file which Gmsh writes of it."""

import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

import tegula
from tegula import parts

MISSING = ""
try:
    import gmsh  # type: ignore[import-not-found, import-untyped, unused-ignore]
except (ImportError, OSError) as missing:
    # Without the libraries of a desktop the package is there, and cannot be loaded.
    MISSING = str(missing)

ROOT = Path(__file__).resolve().parents[2]
YOUNG, LOAD = 2.1e11, -1e3


def setUpModule() -> None:
    if MISSING:
        raise unittest.SkipTest(MISSING)


def model_of(mesh: Any, clamped: list[str], loaded: str) -> tegula.Model:
    """A plate that is clamped along sets and loaded along another one."""
    return tegula.Model(
        analysis=parts.Static(),
        mesh=mesh,
        materials={"steel": parts.IsotropicMaterial(young=YOUNG, poisson=0.0)},
        sections=[parts.Section(material="steel", thickness=0.1)],
        conditions=[parts.Clamp(on=name) for name in clamped],
        loads=[parts.EdgeLoad(on=loaded, value=[0.0, 0.0, LOAD])],
    )


class Meshes(unittest.TestCase):
    def setUp(self) -> None:
        gmsh.initialize(interruptible=False)
        self.addCleanup(gmsh.finalize)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.RecombineAll", 1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def two_rectangles(self) -> None:
        """A strip of the length 3 of two surfaces that are reversed, with groups of points, curves and surfaces."""
        occ = gmsh.model.occ
        occ.addRectangle(0.0, 0.0, 0.0, 2.0, 1.0)
        occ.addRectangle(2.0, 0.0, 0.0, 1.0, 1.0)
        occ.fragment([(2, 1)], [(2, 2)])
        occ.synchronize()
        on = {x: gmsh.model.getEntitiesInBoundingBox(x - 0.01, -1, -1, x + 0.01, 2, 1, 1)[0][1] for x in (0.0, 3.0)}
        gmsh.model.addPhysicalGroup(1, [on[0.0]], name="left")
        gmsh.model.addPhysicalGroup(1, [on[3.0]], 5)
        gmsh.model.addPhysicalGroup(0, [gmsh.model.getEntities(0)[-1][1]], name="corner")
        for surfaces, number, name in (([-1], 7, "first"), ([-2], 8, ""), ([-1, -2], 9, "both")):
            gmsh.model.addPhysicalGroup(2, surfaces, number, name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
        gmsh.model.mesh.generate(2)

    def same(self, sets: list[str], clamped: list[str], loaded: str, form: float = 4.1) -> None:
        gmsh.option.setNumber("Mesh.MshFileVersion", form)
        file = self.folder / "part.msh"
        gmsh.write(str(file))
        taken = model_of(tegula.from_gmsh(), clamped, loaded).simulation()
        read = model_of(parts.GmshMesh(file=str(file)), clamped, loaded).simulation()
        np.testing.assert_array_equal(taken.quads, read.quads)
        # The file has 16 digits.
        np.testing.assert_allclose(taken.positions, read.positions, rtol=0.0, atol=1e-15)
        for name in sets:
            np.testing.assert_array_equal(taken.nodes_on(name), read.nodes_on(name), name)

    def test_the_mesh_is_that_of_the_written_file(self) -> None:
        self.two_rectangles()
        for form in (4.1, 2.2):
            with self.subTest(form=form):
                self.same(["left", "5", "corner", "first", "8", "both", "all"], ["left"], "5", form)

    def test_an_example_is_read_equally(self) -> None:
        gmsh.merge(str(ROOT / "examples/leaf_spring_axle.geo"))
        gmsh.model.mesh.generate(2)
        self.same(["leaves", "left seat", "right rear end"], ["left front end", "right front end"], "left rear end")

    def test_the_strip_sinks_as_beam_theory_says(self) -> None:
        self.two_rectangles()
        result = model_of(tegula.from_gmsh(), ["left"], "5").run()
        lowest = result.frames[-1].read().point_data["displacement"][:, 2].min()
        self.assertLess(abs(lowest / (LOAD * 3.0**3 / (3.0 * YOUNG * 0.1**3 / 12.0)) - 1.0), 5e-3)

    def test_without_groups_all_elements_are_taken(self) -> None:
        gmsh.model.occ.addRectangle(0.0, 0.0, 0.0, 2.0, 1.0)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        self.assertEqual({*tegula.from_gmsh()}, {"type", "nodes", "quads"})
        number = len(tegula.from_gmsh()["quads"])
        gmsh.model.addPhysicalGroup(1, [1], name="side")
        with self.assertRaisesRegex(ValueError, "once there are physical groups, give the surfaces one"):
            tegula.from_gmsh()
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.option.setNumber("Mesh.ScalingFactor", 0.001)
        taken = tegula.from_gmsh()
        self.assertEqual(len(taken["quads"]), number)
        self.assertEqual(taken["nodes"].max(), 0.002)

    def test_other_meshes_are_refused(self) -> None:
        gmsh.option.setNumber("Mesh.RecombineAll", 0)
        gmsh.model.occ.addRectangle(0.0, 0.0, 0.0, 2.0, 1.0)
        gmsh.model.occ.synchronize()
        with self.assertRaisesRegex(ValueError, "no quadrilaterals"):
            tegula.from_gmsh()
        gmsh.model.mesh.generate(2)
        with self.assertRaisesRegex(ValueError, "[0-9]+ of type Triangle 3; .*Mesh.RecombineAll"):
            tegula.from_gmsh()

    def test_curves_outside_of_the_mesh_are_refused(self) -> None:
        gmsh.model.occ.addRectangle(0.0, 0.0, 0.0, 2.0, 1.0)
        gmsh.model.occ.addPoint(0.5, 0.5, 0.0, tag=50)
        gmsh.model.occ.addPoint(1.5, 0.5, 0.0, tag=51)
        line = gmsh.model.occ.addLine(50, 51)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [1], name="plate")
        gmsh.model.addPhysicalGroup(1, [line], name="stiffener")
        gmsh.model.mesh.generate(2)
        with self.assertRaisesRegex(ValueError, "physical curve 'stiffener' is not the side of an element: embed the curve"):
            tegula.from_gmsh()
        gmsh.model.removePhysicalGroups([(1, 1)])
        gmsh.model.addPhysicalGroup(0, [50], name="middle")
        with self.assertRaisesRegex(ValueError, "physical point 'middle' belongs to no element"):
            tegula.from_gmsh()


class Without(unittest.TestCase):
    def test_gmsh_without_a_model_is_told(self) -> None:
        with self.assertRaisesRegex(ValueError, "call gmsh.initialize"):
            tegula.from_gmsh()


if __name__ == "__main__":
    unittest.main()
