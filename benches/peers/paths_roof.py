"""The hinged cylindrical roof of Sze, Liu and Lo (Finite Elem. Anal. Des. 40 (2004) 1551–1569, Sect. 3.6), isotropic: a quarter.

Lengths in mm, forces in N. Node i (n + 1) + j lies at the angle 0.1 i/n from the crest and at the distance 254 j/n from the
middle. The straight edge i = n is hinged, the curved edge j = n is free; the force acts on the middle, node 0.
"""

import json
import math

RADIUS, ANGLE, HALF_LENGTH = 2540.0, 0.1, 254.0
YOUNG, POISSON = 3102.75, 0.3
# The path is followed until the middle has sunk by this much.
END = 30.0


def nodes(n):
    return [(RADIUS * math.sin(ANGLE * i / n), HALF_LENGTH * j / n, RADIUS * math.cos(ANGLE * i / n))
            for i in range(n + 1) for j in range(n + 1)]


def crest(n):
    """Nodes of the plane of symmetry x = 0."""
    return range(n + 1)


def middle(n):
    """Nodes of the plane of symmetry y = 0."""
    return range(0, (n + 1) ** 2, n + 1)


def hinge(n):
    return range(n * (n + 1), (n + 1) ** 2)


def write_path(folder, points, **statistics):
    """The path as deflections of the middle and forces on the whole roof, and what the program knows of its run."""
    (folder / "path.json").write_text(json.dumps({**statistics, "path": points}))


def read_path(folder):
    return measures(json.loads((folder / "path.json").read_text()))


def measures(found):
    """The first limit of the force, from the parabola through the highest point and its neighbours."""
    path = found["path"]
    if not path or path[-1][0] < 0.999 * END:
        return {**found, "failure": "ends at a deflection of %.4g mm" % (path[-1][0] if path else 0.0)}
    top = next(k for k in range(1, len(path) - 1) if path[k - 1][1] < path[k][1] >= path[k + 1][1])
    return {**found, "limit": vertex(*path[top - 1:top + 2]), "end": path[-1][1]}


def vertex(a, b, c):
    """The largest force on the parabola through three points, over the length of the chords: a path may turn back in deflection."""
    scale = max(p[1] for p in (a, b, c))
    chord = lambda p, q: math.hypot((q[0] - p[0]) / END, (q[1] - p[1]) / scale)
    s, t = -chord(a, b), chord(b, c)
    slope_left, slope_right = (a[1] - b[1]) / s, (c[1] - b[1]) / t
    curvature = (slope_right - slope_left) / (t - s)
    slope = slope_left - curvature * s
    return b[1] - slope**2 / (4.0 * curvature)
