"""Quarter cylinder pendulum: a soft curved shell, held at one corner by a spherical joint, swings under its weight.

Valkeapää et al., Nonlinear Dynamics 80 (2015) 1133–1146, Sect. 5.4. An independent program has the opposite corner at
(0.831, 1.031, 0.058) m after 0.4 s on a mesh of 32 × 32.
"""

import numpy as np
import tegula

model = tegula.Model({
    "title": "Quarter cylinder pendulum",
    "analysis": {"type": "transient", "end_time": 0.4, "scheme": {"type": "energy-momentum"}},
    "mesh": {"type": "cylinder", "center": [0.0, 0.0, 1.0], "axis": [0.0, 1.0, 0.0], "start": [0.0, 0.0, -1.0],
             "radius": 1.0, "angles": [0.0, -90.0], "length": 1.0, "grid": {"elements": [16, 16]}},
    "materials": {"rubber": {"type": "isotropic", "young": 2.1e7, "poisson": 0.3}},
    "sections": [{"material": "rubber", "thickness": 0.01, "total_mass": 5.0}],
    "conditions": [{"type": "spherical", "on": "u_min_v_min"}],
    "loads": [{"type": "gravity", "value": [0.0, 0.0, -9.81]}],
    "output": {"points": [{"name": "opposite", "on": "u_max_v_max"}], "interval": 0.05},
})
history = model.run().history
corner = [history[f"opposite.{axis}"][-1] for axis in "xyz"]
energy = np.ptp(history["total"]) / history["kinetic"].max()
print(f"corner at 0.4 s: {np.round(corner, 4)} m, energy kept to {energy:.1e} of the kinetic energy")
assert np.linalg.norm(np.subtract(corner, [0.831, 1.031, 0.058])) < 5e-3 and energy < 1e-8
