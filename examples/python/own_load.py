"""Loads that are functions: a cantilever whose tip meets a soft stop, and dashpots that damp its vibration.

The stop, at a distance g below the tip, pushes with a force k (δ − g), so the tip goes down by δ = (F + k g)/(3 E I/L³ + k). Dashpots with a
constant c of each length let all vibrations of the beam decay by exp(−c t/(2 ρ A)).
"""

import numpy as np

import tegula

LENGTH, WIDTH, THICKNESS, YOUNG, DENSITY = 1.0, 0.1, 0.01, 2.1e11, 7850.0
BEAM = 3.0 * YOUNG * WIDTH * THICKNESS**3 / 12.0 / LENGTH**3
FORCE, STOP, GAP = 30.0, 4.0 * BEAM, 2e-3
ELEMENTS, END = 20, 0.5
DAMPING = 2.0 * DENSITY * WIDTH * THICKNESS / END  # amplitudes fall to 1/e

keys = {
    "analysis": {"type": "static"},
    "mesh": {"type": "plate", "size": [LENGTH, WIDTH], "grid": {"elements": [ELEMENTS, 1]}},
    "materials": {"steel": {"type": "isotropic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}},
    "sections": [{"material": "steel", "thickness": THICKNESS}],
    "conditions": [{"type": "clamp", "on": "u_min"}],
    "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -FORCE / WIDTH]}],
    "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False, "fields": []},
}


def stop(load_factor, positions):
    """Force of the stop, shared by the nodes of the tip; nothing above it."""
    forces = np.zeros_like(positions)
    forces[:, 2] = STOP / len(positions) * np.maximum(-GAP - positions[:, 2], 0.0)
    return forces


deflection = -tegula.run(keys, loads=[tegula.NodalForce("u_max", stop, name="stop")]).history["tip.uz"][-1]
exact = (FORCE + STOP * GAP) / (BEAM + STOP)
print(f"tip {1e3 * deflection:.4f} mm down, beam theory {1e3 * exact:.4f} mm")
assert abs(deflection / exact - 1.0) < 2e-3


def dashpots(time, positions, velocities):
    """Damping force on each node, which stands for the length of half an element on each side, and half of the width."""
    lengths = np.full(len(positions), 0.5 * LENGTH / ELEMENTS)
    lengths[positions[:, 0] > LENGTH - 0.5 * LENGTH / ELEMENTS] *= 0.5
    return -DAMPING * lengths[:, None] * velocities


scheme = {"type": "energy-momentum"}
swing = {**keys, "analysis": {"type": "transient", "end_time": END, "time_step": 5e-4, "scheme": scheme}, "loads": []}
swing["initial_velocities"] = [{"on": "all", "angular_velocity": [0.0, -1.0, 0.0], "center": [0.0, 0.0, 0.0]}]
simulation = tegula.Model(swing).simulation(loads=[tegula.NodalForce("all", dashpots, name="dashpots")])
start = simulation.energies.kinetic
while not simulation.finished:
    simulation.advance()
left = simulation.energies.kinetic + simulation.energies.strain
# The energy oscillates about its mean decay by c/(2 ρ A ω), 4 % with the first circular frequency ω.
print(f"energy left {left / start:.4f}, theory {np.exp(-2.0):.4f}; taken by the dashpots {-simulation.energies.work / start:.4f}")
assert abs(left / start / np.exp(-2.0) - 1.0) < 0.05
assert abs(start + simulation.energies.work - left) < 1e-9 * start
