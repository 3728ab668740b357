"""A controller damps a swinging strip: between time steps it sets a force from the velocity of the tip.

The force −c v at the tip does the work of a damper of constant c. The strip is a cantilever of mass m, each of whose modes
moves the tip as an oscillator of the mass m/4 (W. Weaver, S. P. Timoshenko, D. H. Young, Vibration Problems in Engineering,
5th ed. 1990, Sect. 5.11). So the energy falls with exp(−c t/(m/4)).
"""

import numpy as np
import tegula

WIDTH, THICKNESS, DENSITY, DAMPING = 0.1, 0.01, 7850.0, 5.0

strip = tegula.Model({
    "analysis": {"type": "transient", "end_time": 1.0, "time_step": 1e-3,
                 "scheme": {"type": "energy-momentum"}},
    "mesh": {"type": "plate", "size": [1.0, WIDTH], "grid": {"elements": [16, 2]}},
    "materials": {"steel": {"type": "isotropic", "young": 2.1e11, "poisson": 0.0, "density": DENSITY}},
    "sections": [{"material": "steel", "thickness": THICKNESS}],
    "conditions": [{"type": "clamp", "on": "u_min"}],
    "initial_velocities": [{"on": "all", "angular_velocity": [0.0, -0.3, 0.0]}],
    "amplitudes": {"control": {"type": "constant", "value": 0.0}},
    "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, 1.0 / WIDTH], "amplitude": "control"}],
})
simulation = strip.simulation(signals=["control"])
tip = simulation.nodes_on("u_max")[1]


def energy() -> float:
    return simulation.energies.kinetic + simulation.energies.strain


first = energy()
while not simulation.finished:
    simulation.set("control", -DAMPING * simulation.velocities[tip, 2])
    simulation.advance()

rate = np.log(first / energy()) / simulation.end
expected = DAMPING / (0.25 * DENSITY * THICKNESS * WIDTH)
print(f"energy decays with {rate:.3f} 1/s, that of oscillators with {expected:.3f} 1/s")
assert abs(rate / expected - 1.0) < 0.03
