"""The three problems that all programs compute, as plain numbers, and what their scripts share.

`cylinder` (static): quarter cylinder x = 1 - cos t, z = sin t, 0 <= t <= 90 degrees, 0 <= y <= 1, clamped at
t = 0; the dead force (0, 0, -20) is spread evenly over the free edge t = 90 degrees.

`hypar` (static): hyperbolic paraboloid z = y^2 - x^2, -1/2 <= x, y <= 1/2, clamped at x = -1/2, under its own
weight along -z, which acts on the reference area.

`pendulum` (transient): quarter cylinder x = sin t, z = 1 - cos t of 5 kg, held at its corner (0, 0, 0) by a
spherical joint, falls from rest under its weight and swings for 1 s (Valkeapaa et al., Nonlinear Dynamics 80
(2015) 1133-1146, Sect. 5.4).

All are 0.01 thick and St. Venant-Kirchhoff with Poisson's ratio 0.3. A mesh has n x n elements, uniform in the
parameters u and v (angle and y, or x and y), from 0 to 1 each. A job is a dictionary: `problem`, `elements`, and
the settings of the program. Every program leaves the displacements of its nodes; `measures` turns them into the
numbers that are compared.
"""

import json
import math
import pathlib

THICKNESS, POISSON, GRAVITY = 0.01, 0.3, 9.81
YOUNG = {"cylinder": 2.1e8, "hypar": 3e7, "pendulum": 2.1e7}
EDGE_FORCE = 20.0
HYPAR_DENSITY = 1000.0
PENDULUM_MASS = 5.0
END, EVERY = 1.0, 0.01
STATIC = ("cylinder", "hypar")
# Static displacements are compared at this many equal intervals along u and v.
GRID = 4
# Motions are compared at three corners, as (u, v).
CORNERS = {"opposite": (1, 1), "arc_end": (1, 0), "axial_end": (0, 1)}


def surface(problem, u, v):
    """Position and its derivatives along u and v."""
    if problem == "hypar":
        x, y = u - 0.5, v - 0.5
        return (x, y, y * y - x * x), (1.0, 0.0, -2 * x), (0.0, 1.0, 2 * y)
    t, turn = 0.5 * math.pi * u, 0.5 * math.pi
    c, s = math.cos(t), math.sin(t)
    if problem == "cylinder":
        return (1 - c, v, s), (turn * s, 0.0, turn * c), (0.0, 1.0, 0.0)
    return (s, v, 1 - c), (turn * c, 0.0, turn * s), (0.0, 1.0, 0.0)


def nodes(problem, n):
    """Position and both derivatives at the nodes, row by row of u."""
    for i in range(n + 1):
        for j in range(n + 1):
            yield surface(problem, i / n, j / n)


def quads(n):
    """Nodes of the elements, counted from 0, first along u and then along v."""
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j
            yield a, a + n + 1, a + n + 2, a + 1


def serendipity(n):
    """Eight-node elements on the nodes of a mesh of 2 n x 2 n: corners, then the middles of the sides."""
    at = lambda i, j: i * (2 * n + 1) + j
    for i in range(0, 2 * n, 2):
        for j in range(0, 2 * n, 2):
            yield (at(i, j), at(i + 2, j), at(i + 2, j + 2), at(i, j + 2),
                   at(i + 1, j), at(i + 2, j + 1), at(i + 1, j + 2), at(i, j + 1))


def clamped(n):
    """Nodes of the clamped edge u = 0."""
    return range(n + 1)


def edge(n):
    """Nodes of the free edge u = 1, in order."""
    return range(n * (n + 1), (n + 1) ** 2)


def corner(name, n):
    """Node of a compared corner."""
    u, v = CORNERS[name]
    return u * n * (n + 1) + v * n


def density(problem, n, facets=True):
    """Mass density. That of the pendulum gives its mesh, of facets or of cubics, the mass of 5 kg."""
    if problem == "hypar":
        return HYPAR_DENSITY
    arc = n * 2 * math.sin(0.25 * math.pi / n) if facets else 0.5 * math.pi
    return PENDULUM_MASS / (arc * THICKNESS)


def edge_forces(n, quadratic=False):
    """Nodal shares of the force on the free edge, consistent with linear or quadratic sides (n counts elements)."""
    if quadratic:
        shares = [0.0] * (2 * n + 1)
        for k in range(n):
            for a, weight in zip((0, 1, 2), (1, 4, 1)):
                shares[2 * k + a] += weight / (6 * n)
    else:
        shares = [(0.5 if k in (0, n) else 1.0) / n for k in range(n + 1)]
    return [EDGE_FORCE * share for share in shares]


def weights(problem, n, quadratic=False):
    """Nodal weights: integrals of the shape functions of bilinear or serendipity elements, times density, thickness, g."""
    import numpy as np

    elements = np.array(list(serendipity(n) if quadratic else quads(n)))
    x = np.array([position for position, _, _ in nodes(problem, 2 * n if quadratic else n)])[elements]
    found = np.zeros(((2 * n if quadratic else n) + 1) ** 2)
    points = [(-math.sqrt(0.6), 5 / 9), (0.0, 8 / 9), (math.sqrt(0.6), 5 / 9)]
    for r, weight_r in points:
        for s, weight_s in points:
            shape, by_r, by_s = (serendipity_shapes if quadratic else bilinear_shapes)(r, s)
            normal = np.cross(np.einsum("a,eac->ec", by_r, x), np.einsum("a,eac->ec", by_s, x))
            area = weight_r * weight_s * np.linalg.norm(normal, axis=1)
            np.add.at(found, elements, area[:, None] * np.array(shape))
    rho = PENDULUM_MASS / (THICKNESS * found.sum()) if problem == "pendulum" else HYPAR_DENSITY
    return rho * THICKNESS * GRAVITY * found


SIGNS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def bilinear_shapes(r, s):
    """Shape functions and their derivatives at r, s of the unit square from -1 to 1."""
    return ([0.25 * (1 + a * r) * (1 + b * s) for a, b in SIGNS], [0.25 * a * (1 + b * s) for a, b in SIGNS],
            [0.25 * b * (1 + a * r) for a, b in SIGNS])


def serendipity_shapes(r, s):
    """The same of the eight-node element."""
    shape = [0.25 * (1 + a * r) * (1 + b * s) * (a * r + b * s - 1) for a, b in SIGNS]
    by_r = [0.25 * a * (1 + b * s) * (2 * a * r + b * s) for a, b in SIGNS]
    by_s = [0.25 * b * (1 + a * r) * (a * r + 2 * b * s) for a, b in SIGNS]
    for a, b in ((0, -1), (1, 0), (0, 1), (-1, 0)):
        if a == 0:
            shape.append(0.5 * (1 - r * r) * (1 + b * s))
            by_r.append(-r * (1 + b * s))
            by_s.append(0.5 * b * (1 - r * r))
        else:
            shape.append(0.5 * (1 - s * s) * (1 + a * r))
            by_r.append(0.5 * a * (1 - s * s))
            by_s.append(-s * (1 + a * r))
    return shape, by_r, by_s


def samples():
    """Times at which the motion is compared."""
    return [EVERY * k for k in range(round(END / EVERY) + 1)]


def work(problem, n, u, quadratic=False):
    """Work of the dead loads on the nodal displacements `u` (rows x, y, z): their negative potential."""
    import numpy as np

    loads = np.zeros(len(u))
    if problem == "cylinder":
        fine = 2 * n if quadratic else n
        loads[list(edge(fine))] = edge_forces(n, quadratic)
    else:
        loads = weights(problem, n, quadratic)
    return -float(np.dot(loads, [0.0 if math.isnan(z) else z for z in np.asarray(u)[:, 2]]))


def measures(problem, n, u, quadratic=False):
    """What is compared of static displacements: those of the common grid, and the work of the loads."""
    fine = 2 * n if quadratic else n
    skip = fine // GRID
    grid = [list(map(float, u[i * (fine + 1) + j][:3])) for i in range(0, fine + 1, skip) for j in range(0, fine + 1, skip)]
    return {"grid": grid, "work": work(problem, n, u, quadratic)}


def motion_measures(n, motion, quadratic=False):
    """What is compared of a motion, sample by sample: displacements of the corners, and the work of the weight."""
    import numpy as np

    loads = weights("pendulum", n, quadratic)
    fine = 2 * n if quadratic else n
    return {"corners": [{name: list(map(float, u[corner(name, fine)][:3])) for name in CORNERS} for u in motion],
            "work": [-float(np.dot(loads, np.nan_to_num(np.asarray(u)[:, 2]))) for u in motion]}


def read_job(path):
    """The job, and the folder that its results go to."""
    path = pathlib.Path(path)
    return json.loads(path.read_text()), path.parent


def write_rows(folder, rows, name="field.csv"):
    """Displacements (and more) of the nodes: a row a node."""
    with open(folder / name, "w") as file:
        for row in rows:
            file.write(",".join("%.12e" % x for x in row) + "\n")


def read_rows(folder, name="field.csv"):
    return [[float(x) for x in line.split(",")] for line in (folder / name).read_text().splitlines()]


def write_statistics(folder, **what):
    """What the program knows of its run: `version`, `unknowns`, `steps`, `iterations`."""
    (folder / "statistics.json").write_text(json.dumps(what))


def read_results(job, folder, quadratic=False):
    """Statistics and measures of a program that wrote its nodal displacements, sample by sample in a motion."""
    n, rows = job["elements"], read_rows(folder)
    found = json.loads((folder / "statistics.json").read_text())
    if job["problem"] in STATIC:
        return {**found, **measures(job["problem"], n, rows, quadratic)}
    count = len(rows) // len(samples())
    motion = [rows[k:k + count] for k in range(0, len(rows), count)]
    return {**found, **motion_measures(n, motion, quadratic)}
