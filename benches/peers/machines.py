"""Four machines as plain numbers, and what is compared of their motion.

`spin-up`: a straight elastic beam, clamped in a hub that begins to turn (Haug's beam, with the constants of the
example of V. Sonneville's SE(3) finite-element code). Compared is the displacement of its tip in the frame of the hub.

`slider-crank`: a crank at constant speed, an elastic rod and a slider of half its mass (data of Jonker and Meijaard). Crank and rod
begin in line, with the velocities of a rigid rod, unstressed. Compared is the deflection of the rod's middle over its length.

`chain`: twenty bars on hinges fall from rest, straight and horizontal. Compared are the centres of the bars. A small disturbance of the
start grows less than tenfold in the time compared.

`plate`: a square plate on spherical joints at two neighbouring corners falls from rest, horizontal. Compared are a free
corner, the middle of the free side and the middle of the side between the joints.

A job is a dictionary: `problem`, `model`, `elements`, and settings of the program.
"""

import bisect
import math

GRAVITY = 9.81
END = {"spin-up": 14.0, "slider-crank": 0.08, "chain": 1.5, "plate": 0.4}
EVERY = {"spin-up": 0.1, "slider-crank": 2e-4, "chain": 0.01, "plate": 0.01}
# The strip has the same stiffness and mass over its width, which is free.
SPIN_UP = {"length": 8.0, "axial": 5.03e6, "shear": 1.94e6, "bending": 566.0, "mass": 0.201, "inertia": 2.2739e-5,
           "young": 6.8952e10, "density": 6.8952e10 * 0.201 / 5.03e6, "thickness": math.sqrt(12 * 566 / 5.03e6), "width": 0.2}
# A round rod of 6 mm, or a strip with the same area and bending stiffness.
AREA = math.pi * 0.003**2
SLIDER_CRANK = {"crank": 0.15, "length": 0.3, "rate": 150.0, "slider": 0.0333779, "young": 2e11, "density": 7870.0,
                "axial": 2e11 * AREA, "bending": 2e11 * AREA * 0.003**2 / 4, "shear": 2e11 / 2 * AREA * 5 / 6, "mass": 7870 * AREA,
                "inertia": 7870 * AREA * 0.003**2 / 4, "thickness": 0.00519615, "width": 0.0054414}
CHAIN = {"links": 20, "length": 0.1, "width": 0.01, "mass": 0.1}
PLATE = {"side": 1.0, "thickness": 0.001, "young": 2e10, "poisson": 0.3, "density": 2000.0}


def spin(t):
    """Angle of the hub."""
    return 4 / 15 * (t * t / 2 + (15 / (2 * math.pi)) ** 2 * (math.cos(2 * math.pi * t / 15) - 1))


def link_inertia():
    """Of a box of square section, along its length and across."""
    across = CHAIN["mass"] * (CHAIN["length"] ** 2 + CHAIN["width"] ** 2) / 12
    return [CHAIN["mass"] * CHAIN["width"] ** 2 / 6, across, across]


def chain_places(angles, relative=False):
    """Centres of the links."""
    x = y = total = 0.0
    places, length = [], CHAIN["length"]
    for angle in angles:
        total = total + angle if relative else angle
        c, s = length * math.cos(total), length * math.sin(total)
        places.append([x + c / 2, y + s / 2, 0.0])
        x, y = x + c, y + s
    return places


def samples(problem):
    return [EVERY[problem] * k for k in range(1, round(END[problem] / EVERY[problem]) + 1)]


def interpolate(times, motion, t):
    """The places at `t`: of a step that ends there, or of the cubic through four neighbours."""
    k = bisect.bisect_left(times, t * (1 - 1e-9))
    if k < len(times) and abs(times[k] - t) < 1e-7 * t:
        return motion[k]
    k = min(max(k - 2, 0), len(times) - 4)
    near = range(k, k + 4)
    weights = [math.prod((t - times[b]) / (times[a] - times[b]) for b in near if b != a) for a in near]
    return [[sum(w * motion[a][p][c] for w, a in zip(weights, near)) for c in range(3)] for p in range(len(motion[k]))]


def compared(problem, motion):
    """What is compared of the places of the recorded points, sample after sample."""
    found = []
    for t, places in zip(samples(problem), motion):
        if problem == "spin-up":
            (x, y, _), c, s = places[0], math.cos(spin(t)), math.sin(spin(t))
            found += [x * c + y * s - SPIN_UP["length"], y * c - x * s]
        elif problem == "slider-crank":
            (ax, ay, _), (mx, my, _), (bx, by, _) = places
            dx, dy = bx - ax, by - ay
            found.append((dx * (my - (ay + by) / 2) - dy * (mx - (ax + bx) / 2)) / (dx * dx + dy * dy))
        else:
            found += [x for place in places for x in place]
    return found
