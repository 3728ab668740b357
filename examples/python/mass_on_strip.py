"""Co-simulation: Python integrates a mass on a spring that hangs at the tip of a strip, iterated in each time step.

In each step the spring exerts the constant force k (e₀ + e₁)/2 from its elongations e at both ends of the step. The mean
velocity of the mass follows from it, and the strip takes the step again until the force no longer changes. So the energy that
the strip gives is what mass and spring receive. The model of both in one file gives the motion for comparison.
"""

import tegula

MASS, SPRING, STEP, END, DROP = 0.3, 200.0, 1e-3, 0.5, -0.5

strip = {
    "analysis": {"type": "transient", "end_time": END, "time_step": STEP, "scheme": {"type": "energy-momentum"}},
    "mesh": {"type": "plate", "size": [1.0, 0.1], "grid": {"elements": [12, 1]}},
    "materials": {"steel": {"type": "isotropic", "young": 2.1e11, "poisson": 0.0, "density": 7850.0}},
    "sections": [{"material": "steel", "thickness": 0.005}],
    "conditions": [{"type": "clamp", "on": "u_min"}],
    "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False, "fields": []},
}
# A body without rotation of the edge's own: the force acts in its middle.
edge = {"name": "edge", "at": [1.0, 0.05, 0.0], "attached": ["u_max"]}

coupled = {
    **strip,
    "bodies": [edge],
    "amplitudes": {"spring": {"type": "constant", "value": 0.0}},
    "loads": [{"type": "force", "on": "edge", "value": [0.0, 0.0, 1.0], "amplitude": "spring"}],
}
simulation = tegula.Model(coupled).simulation(signals=["spring"])


def tip() -> float:
    return simulation.values()["tip.uz"]


place, velocity, exchanged, iterations = 0.0, DROP, 0.0, 0
while not simulation.finished:
    start, force = tip(), SPRING * (place - tip())
    while True:
        simulation.set("spring", force)
        simulation.advance()
        iterations += 1
        new_velocity = velocity - STEP * force / MASS
        new_place = place + 0.5 * STEP * (velocity + new_velocity)
        mean = SPRING * 0.5 * ((place - start) + (new_place - tip()))
        if abs(mean - force) <= 1e-12 * SPRING * abs(DROP) * STEP:
            break
        force = mean
        simulation.repeat()
    exchanged += abs(force * (tip() - start))
    place, velocity = new_place, new_velocity

energy = 0.5 * MASS * velocity**2 + 0.5 * SPRING * (place - tip()) ** 2
energy += simulation.energies.kinetic + simulation.energies.strain
error = abs(energy - 0.5 * MASS * DROP**2) / exchanged

both = {
    **strip,
    "bodies": [edge, {"name": "mass", "at": [1.0, 0.05, -1.0], "mass": MASS,
                        "velocity": [0.0, 0.0, DROP]}],
    "springs": [{"name": "spring", "between": ["edge", "mass"], "points": [[1.0, 0.05, 0.0], [1.0, 0.05, -1.0]],
                 "stiffness": SPRING}],
}
history = tegula.run(both).history
difference = abs(history["tip.uz"][-1] - tip()) / abs(history["tip.uz"]).max()
print(f"{iterations} iterations, tip at {tip():.6f} m, energy balance {error:.1e} of the exchanged energy, "
      f"distance to the model of both {difference:.1e}")
assert error < 1e-9 and difference < 1e-6
