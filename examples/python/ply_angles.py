"""A study of two parameters: deflection and first frequency of a cantilever of carbon fibres over ply angle and thickness.

A strip of one ply with fibres along its length is a beam of Young's modulus E1: w = F L³/(3 E1 I), and the first bending
frequency is 3.516/(2π L²) √(E1 I/(ρ A)) (S. Timoshenko, Vibration Problems in Engineering).
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
import tegula

LENGTH, WIDTH, FORCE, DENSITY, E1 = 1.0, 0.1, 0.01, 1600.0, 130e9


def strip(angle: float, thickness: float, analysis: dict[str, object]) -> tegula.Model:
    return tegula.Model({
        "analysis": analysis,
        "mesh": {"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [16, 2]}},
        "materials": {"carbon": {"type": "orthotropic", "young": [E1, 9e9, 9e9], "poisson": [0.3, 0.3, 0.4],
                                 "shear": [5e9, 5e9, 3e9], "density": DENSITY}},
        "sections": [{"layup": {"stacking": f"[{angle}]", "material": "carbon", "ply_thickness": thickness}}],
        "conditions": [{"type": "clamp", "on": "u_min"}],
        "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -FORCE / WIDTH]}],
        "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False, "fields": []},
    })


def study(parameters: tuple[float, float]) -> tuple[float, float]:
    static = strip(*parameters, {"type": "static"}).run()
    # Modes about the unloaded strip.
    modal = strip(*parameters, {"type": "modal", "modes": 1, "prestressed": True}).run()
    return -static.history["tip.uz"][-1], modal.frequencies[0]


angles, thicknesses = np.linspace(0.0, 90.0, 10), np.linspace(0.004, 0.01, 4)
with ThreadPoolExecutor(2) as pool:
    found = np.array(list(pool.map(study, product(angles, thicknesses)))).reshape(10, 4, 2)
print("angle   deflection [µm] and frequency [Hz] for each thickness")
for angle, row in zip(angles, found):
    print(f"{angle:5.1f}  ", "  ".join(f"{1e6 * w:8.2f} {f:6.3f}" for w, f in row))

inertia = WIDTH * thicknesses**3 / 12.0
deflection = FORCE * LENGTH**3 / (3.0 * E1 * inertia)
frequency = 3.516 / (2.0 * np.pi * LENGTH**2) * np.sqrt(E1 * inertia / (DENSITY * WIDTH * thicknesses))
assert np.abs(found[0, :, 0] / deflection - 1.0).max() < 0.01
assert np.abs(found[0, :, 1] / frequency - 1.0).max() < 0.01
assert (np.diff(found[:, :, 0], axis=0) > 0.0).all(), "fibres across the strip make it softer"
