"""Knock-down curves: critical loads over the amplitude of imperfections."""

from __future__ import annotations

import math
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np
import tegula

NU, RADIUS, THICKNESS = 0.3, 1.0, 0.01
C = math.sqrt(3.0 * (1.0 - NU * NU))
WAVELENGTH = 2.0 * math.pi * math.sqrt(RADIUS * THICKNESS / (2.0 * C))
STRESS = THICKNESS / (RADIUS * C)
"""Classical stress over Young's modulus."""


def cylinder() -> dict[str, Any]:
    """Half a buckle of an axially compressed cylinder with an axisymmetric imperfection of a hundredth of its thickness.

    Load factor 1 shortens it by the strain of the classical stress.
    """
    angle = math.radians(20.0)
    length = 2.0 * WAVELENGTH
    return {
        "analysis": {"type": "path", "end_load": 1.2},
        "mesh": {
            "type": "cylinder", "axis": [0, 1, 0], "start": [0, 0, 1], "radius": RADIUS, "angles": [0.0, 20.0], "length": length,
            "grid": {"elements": [9, 24]},
        },
        "materials": {"m": {"type": "isotropic", "young": 1.0, "poisson": NU}},
        "sections": [{"material": "m", "thickness": THICKNESS}],
        "conditions": [
            {"type": "symmetry", "on": "u_min", "normal": [1, 0, 0]},
            {"type": "symmetry", "on": "u_max", "normal": [math.cos(angle), 0, -math.sin(angle)]},
            {"type": "symmetry", "on": "v_min", "normal": [0, 1, 0]},
            {"type": "fix", "on": "v_max", "position": [], "director": ["y"]},
            {"type": "prescribe", "on": "v_max", "of": "position", "component": "y", "value": -length * STRESS},
        ],
        "imperfections": [{"type": "wave", "amplitude": -0.01 * THICKNESS, "direction": [0, 1, 0], "wavelength": WAVELENGTH}],
        "output": {"pictures": False, "fields": []},
    }


def one_term(mu: float) -> float:
    """Lowest root of (1 − λ)³ − c μ (1 + λ/2)(1 − λ) + (c μ)²/2: Donnell's equations with one term of the buckles, about the compressed imperfect state.

    The load is the mean stress over the classical one.
    """
    a = C * mu
    roots = np.roots([-1.0, 3.0 + 0.5 * a, -3.0 + 0.5 * a, 1.0 - a + 0.5 * a * a])
    return float(min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0.0))


class KnockDown(unittest.TestCase):
    def test_a_compressed_cylinder_loses_the_load_of_koiters_theory(self) -> None:
        seen: list[tuple[float, float]] = []
        with tempfile.TemporaryDirectory() as folder:
            found = tegula.knock_down(cylinder(), [5, 20], folder, report=lambda *pair: seen.append(pair))
            self.assertEqual({path.name for path in Path(folder).iterdir()}, {"factor-5", "factor-20"})
            area = math.radians(20.0) * RADIUS * THICKNESS
            for factor, result in zip(found.factors, found.results):
                stress = abs(result.history["support.v_max.fy"][-1]) / area / STRESS
                with self.subTest(factor):
                    self.assertLess(abs(stress / one_term(0.01 * factor) - 1.0), 0.01)
        self.assertEqual(found.kinds, ["bifurcation", "bifurcation"])
        self.assertEqual(seen, list(zip(found.factors, found.load_factors)))
        # The imperfect cylinder is softer: it is shortened by more than the strain of its stress.
        self.assertTrue((found.load_factors > [one_term(0.05), one_term(0.2)]).all())

    def test_paths_without_a_critical_point_have_none(self) -> None:
        keys = cylinder()
        keys["analysis"]["end_load"] = 0.1
        with tempfile.TemporaryDirectory() as folder:
            # Factors that differ in the last digit have folders of their own.
            tegula.knock_down(keys, [0.1, 0.1 + 2e-17 + 1e-16], folder)
            self.assertEqual(len(list(Path(folder).iterdir())), 2)
        found = tegula.knock_down(keys, [0.0, 1.0])
        self.assertTrue(np.isnan(found.load_factors).all())
        self.assertEqual(found.kinds, [None, None])

    def test_models_without_a_path_or_imperfections_are_refused(self) -> None:
        with self.assertRaisesRegex(ValueError, "imperfections"):
            tegula.knock_down({**cylinder(), "imperfections": []}, [1.0])
        static = {**cylinder(), "analysis": {"type": "static"}}
        with self.assertRaisesRegex(ValueError, 'type = "path"'):
            tegula.knock_down(static, [1.0])
        steps = {key: value for key, value in cylinder().items() if key != "analysis"}
        steps["steps"] = [{"analysis": cylinder()["analysis"]}]
        with self.assertRaisesRegex(ValueError, 'type = "path"'):
            tegula.knock_down(steps, [1.0])
        with self.assertRaisesRegex(ValueError, "finite"):
            tegula.knock_down(cylinder(), [math.nan])


if __name__ == "__main__":
    unittest.main()
