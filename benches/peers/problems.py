"""The two problems that all programs compute, as plain numbers, and what they share.

`cylinder`: a quarter cylinder under large deformation (Valkeapaa et al., Nonlinear Dynamics 80 (2015)
1133-1146, Sect. 5.2, upright and loaded downwards): x = 1 - cos t, z = sin t, 0 <= t <= 90 degrees,
0 <= y <= 1; the edge t = 0 is clamped, a dead force (0, 0, -20) acts at the corner (1, 1, 1).

`pendulum`: the quarter cylinder x = sin t, z = 1 - cos t, softer, of 5 kg, is held at its corner (0, 0, 0)
by a spherical joint and swings under its weight for 1 s (Sect. 5.4).

All meshes are n x n, uniform in angle and y. A job is a dictionary: `problem`, `elements`, and what the
program needs to know beyond that. Every program leaves `result.json` in the folder of the job.
"""

import json
import math
import pathlib

THICKNESS, POISSON = 0.01, 0.3
CYLINDER = {"young": 2.1e8, "force": 20.0}
PENDULUM = {"young": 2.1e7, "mass": 5.0, "gravity": 9.81, "end": 1.0, "every": 0.01}
# Points that are compared, as (row of the angle, row of y): 0 is the first, 1 the last.
POINTS = {
    "cylinder": {"corner": (1, 1), "other corner": (1, 0)},
    "pendulum": {"opposite": (1, 1), "arc_end": (1, 0), "axial_end": (0, 1)},
}


def nodes(problem, n):
    """Positions and the unit tangents along the arc, row by row of the angle."""
    for i in range(n + 1):
        t = 0.5 * math.pi * i / n
        c, s = math.cos(t), math.sin(t)
        for j in range(n + 1):
            if problem == "cylinder":
                yield (1 - c, j / n, s), (s, 0.0, c)
            else:
                yield (s, j / n, 1 - c), (c, 0.0, s)


def quads(n):
    """Nodes of the elements, counted from 0, first along the arc and then along y."""
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j
            yield a, a + n + 1, a + n + 2, a + 1


def node_of(point, n):
    """The number, from 0, of a compared point."""
    i, j = point
    return i * n * (n + 1) + j * n


def density(n):
    """Such that the facets of the mesh, whose area is a little below that of the cylinder, weigh 5 kg."""
    chord = 2 * math.sin(0.25 * math.pi / n)
    return PENDULUM["mass"] / (n * chord * THICKNESS)


def reference_of(peer, job):
    """Name of the fine solution of a pendulum, which has the same scheme: Kratos computes with two."""
    return "pendulum " + peer + (" Newmark" if peer == "Kratos" and job["alpha"] == 0.0 else "")


def samples():
    """Times at which the motion is compared."""
    count = round(PENDULUM["end"] / PENDULUM["every"])
    return [PENDULUM["every"] * k for k in range(count + 1)]


def read_job(path):
    """The job, and the folder that its results go to."""
    path = pathlib.Path(path)
    return json.loads(path.read_text()), path.parent


def write_field(folder, rows):
    """The deformed mesh: a row a node."""
    with open(folder / "field.csv", "w") as file:
        file.write("node,ux,uy,uz\n")
        for k, row in enumerate(rows):
            file.write("%d,%.9e,%.9e,%.9e\n" % (k, row[0], row[1], row[2]))


def write_result(folder, **what):
    """What the table needs: `version`, `unknowns`, `steps`, `iterations`, and `points` or `history`."""
    (folder / "result.json").write_text(json.dumps(what, indent=1))
