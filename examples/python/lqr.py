"""A linear–quadratic regulator damps the bending vibration of a flexible arm with 1 % damping of its own.

The regulator comes from the linearisation of a modal analysis, reduced to the first two bending modes; it acts on the nonlinear
model by a force in the middle of the arm. The gain K = R⁻¹BᵀP follows from the stable invariant subspace of the Hamiltonian
matrix (B. D. O. Anderson, J. B. Moore, Optimal Control: Linear Quadratic Methods, 1990, Sect. 3.3). The damping of the motion
must be that of the eigenvalues of A − BK, where A has all modes.
"""

import numpy as np
import tegula

STEP, END = 2e-4, 0.36
LENGTH, THICKNESS, YOUNG, DENSITY = 0.5, 0.004, 7e10, 2700.0
# First circular frequency of a cantilever; damping proportional to the mass.
OMEGA = 1.8751**2 / LENGTH**2 * np.sqrt(YOUNG * THICKNESS**2 / (12.0 * DENSITY))

arm = {
    "mesh": {"type": "plate", "size": [LENGTH, 0.04], "grid": {"elements": [16, 2]}},
    "materials": {"aluminium": {"type": "isotropic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}},
    "sections": [{"material": "aluminium", "thickness": THICKNESS}],
    "conditions": [{"type": "clamp", "on": "u_min"}],
    "damping": {"mass": 2.0 * 0.01 * OMEGA},
    "output": {"points": [{"name": "middle", "on": "middle"}, {"name": "tip", "on": "u_max_v_min"}],
               "pictures": False, "fields": []},
}
force = {"type": "force", "on": "middle", "value": [0.0, 0.0, 1.0]}

# Linearisation: two bending modes, from the displacements of two points.
modal = {"type": "modal", "modes": 6, "inputs": [{"name": "force", "loads": [force]}]}
system = tegula.run({**arm, "analysis": modal}).state_space
number = len(system.omega)
outputs = [system.outputs.index(name) for name in ("middle.uz", "tip.uz")]
size = np.abs(system.c[outputs, :6]).max(axis=0)
bending = np.flatnonzero(size > 1e-3 * size.max())[:2]
states = np.concatenate([bending, number + bending])
a, b = system.a[np.ix_(states, states)], system.b[states]
to_modes = np.linalg.inv(system.c[np.ix_(outputs, bending)])

# Regulator: the weight of the states is their energy.
weight = np.diag(np.concatenate([system.omega[bending] ** 2, np.ones(2)]))
cost = 2e-2
hamiltonian = np.block([[a, -b @ b.T / cost], [-weight, -a.T]])
values, vectors = np.linalg.eig(hamiltonian)
stable = vectors[:, values.real < 0.0]
gain = b.T @ np.real(stable[4:] @ np.linalg.inv(stable[:4])) / cost


def damping_of(matrix: np.ndarray) -> float:
    """Damping ratio of the eigenvalue of lowest frequency."""
    value = min(np.linalg.eigvals(matrix), key=abs)
    return float(-value.real / abs(value))


def swing(gain: np.ndarray) -> float:
    """Damping ratio of the arm's swing, from the decay of the energy in the first mode."""
    motion = tegula.Model({
        **arm,
        "analysis": {"type": "transient", "end_time": END, "time_step": STEP, "scheme": {"type": "energy-momentum"}},
        "amplitudes": {"control": {"type": "constant", "value": 0.0}},
        "loads": [{**force, "amplitude": "control"}],
        "initial_velocities": [{"on": "all", "angular_velocity": [0.0, -0.5, 0.0]}],
    }).simulation(signals=["control"])
    points = [motion.nodes_on("middle")[0], motion.nodes_on("u_max_v_min")[0]]
    times, energies = [], []
    while not motion.finished:
        coordinates = to_modes @ motion.displacements[points, 2]
        rates = to_modes @ motion.velocities[points, 2]
        motion.set("control", -(gain @ np.concatenate([coordinates, rates])).item())
        motion.advance()
        times.append(motion.time)
        energies.append((system.omega[bending[0]] * coordinates[0]) ** 2 + rates[0] ** 2)
    # The energy of the first mode falls with exp(−2 ζ ω t). Later on what is left belongs to higher modes.
    late = np.array(times) > 0.06
    slope = np.polyfit(np.array(times)[late], np.log(np.array(energies)[late]), 1)[0]
    return float(-slope / (2.0 * system.omega[bending[0]]))


open_loop, closed_loop = swing(np.zeros((1, 4))), swing(gain)
# The regulator sees the displacements of two points, to which all modes contribute.
seen = to_modes @ system.c[outputs, :number]
whole = np.concatenate([gain[:, :2] @ seen, gain[:, 2:] @ seen], axis=1)
expected = damping_of(system.a - system.b @ whole)
print(f"damping ratio of the first mode: {100 * open_loop:.2f} % alone, {100 * closed_loop:.2f} % controlled, "
      f"{100 * expected:.2f} % by the eigenvalues of A − BK")
assert abs(open_loop / 0.01 - 1.0) < 0.05 and closed_loop > 3.0 * open_loop
assert abs(closed_loop / expected - 1.0) < 0.05
