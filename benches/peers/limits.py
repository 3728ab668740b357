"""Limits of mesh (and time step) to which errors refer, one for each theory, extrapolated from the meshes of several codes.

The displacements of three meshes, each twice as fine as the one before, approach their limit like a geometric
series: with the ratio q of the last two distances it is c + (c - b) q / (1 - q). The motions of the pendulum are
extrapolated with second order, in space from the two finest meshes, in time from two step sizes on a coarser mesh.
The limit of a theory is the weighted mean over its codes. The standard deviation s of a code is taken as the relative step from its
finest run to what is extrapolated from it, together with 1e-4: by that codes differ anyway, in how they measure large bending strains. The limit is
known to (Σ 1/s²)^(-1/2), times the ratio of Birge (Phys. Rev. 40 (1932) 207) where codes differ by more than their s.
"""

import json
import math

import jobs
import problems


def norm(a):
    return math.sqrt(sum(x * x for x in a))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def flat(problem, found):
    """All compared displacements as one vector."""
    if problem in problems.STATIC:
        return [x for row in found["grid"] for x in row]
    return [x for sample in found["corners"] for name in problems.CORNERS for x in sample[name]]


def works(found):
    return found["work"] if isinstance(found["work"], list) else [found["work"]]


def geometric(a, b, c):
    """Limit of a series of vectors whose distances shrink by a constant ratio."""
    q = norm(minus(c, b)) / norm(minus(b, a))
    q = min(q, 0.6)
    return [z + (z - y) * q / (1 - q) for y, z in zip(b, c)]


def second_order(coarse, fine, factor=2):
    return [z + (z - y) / (factor**2 - 1) for y, z in zip(coarse, fine)]


def write(runs, path, keep):
    """Extrapolates what every code says of every theory, and writes means and distances."""
    found = json.loads(path.read_text()) if keep and path.exists() else {}
    codes = {}
    for run in runs:
        result = run["found"][-1]
        if "failure" in result:
            print("left out:", run["peer"], run["family"], run["job"], result["failure"])
            continue
        problem = run["job"]["problem"]
        code = codes.setdefault((problem, run["theory"]), {}).setdefault(run["peer"] + ", " + run["family"], [])
        code.append((run["job"], flat(problem, result), works(result)))
    for (problem, theory), members in codes.items():
        extrapolated = {}
        for name, meshes in members.items():
            limit = (static_limit if problem in problems.STATIC else motion_limit)(meshes)
            if limit:
                extrapolated[name] = limit
        limit = found.setdefault(problem, {})[theory] = {"codes": {}}
        for key in "displacement", "energy":
            value = mean([(code[key], code[key + " step"]) for code in extrapolated.values()])
            limit[key] = [float("%.9g" % x) for x in value]
            for name, code in extrapolated.items():
                entry = limit["codes"].setdefault(name, {"meshes": code["meshes"]})
                entry[key] = norm(minus(code[key], value)) / norm(value)
                entry[key + " step"] = code[key + " step"]
        for name, entry in limit["codes"].items():
            print(problem, theory, name, extrapolated[name]["energy"][-1],
                  {key: "%.1e" % entry[key] for key in entry if key != "meshes"})
    path.write_text(json.dumps(found) + "\n")


def mean(vectors):
    """Weighted mean of (vector, step)."""
    weights = [1 / deviation(step) ** 2 for _, step in vectors]
    return [sum(w * x for w, x in zip(weights, column)) / sum(weights) for column in zip(*(v for v, _ in vectors))]


def deviation(step):
    """Standard deviation that a code is given."""
    return math.sqrt(step**2 + 1e-8)


def uncertainty(limit, key):
    """Standard deviation of the weighted mean, times the ratio of Birge if it is above 1."""
    codes = [(code[key], deviation(code[key + " step"])) for code in limit["codes"].values()]
    birge = math.sqrt(sum((distance / s) ** 2 for distance, s in codes) / max(len(codes) - 1, 1))
    return max(birge, 1.0) / math.sqrt(sum(1 / s**2 for _, s in codes))


def with_steps(meshes, finest, limit):
    """The limit of one code, with its relative steps from the finest run."""
    found = {"meshes": sorted({job["elements"] for job, _, _ in meshes}), **limit}
    for key, run in zip(("displacement", "energy"), finest):
        found[key + " step"] = norm(minus(limit[key], run)) / norm(limit[key])
    return found


def static_limit(meshes):
    meshes = sorted(meshes, key=lambda mesh: mesh[0]["elements"])
    if len(meshes) < 3:
        return None
    (_, a, wa), (_, b, wb), (_, c, wc) = meshes[-3:]
    return with_steps(meshes, (c, wc), {"displacement": geometric(a, b, c), "energy": geometric(wa, wb, wc)})


def motion_limit(meshes):
    """Of meshes alone where steps are tiny; else of the two finest meshes, plus what half the step changes on a coarser one."""
    if not any("dt" in job for job, _, _ in meshes):
        return static_limit(meshes)
    dt = max(job["dt"] for job, _, _ in meshes)
    long_steps = sorted((mesh for mesh in meshes if mesh[0]["dt"] == dt), key=lambda mesh: mesh[0]["elements"])
    short_steps = {job["elements"]: (job, u, work) for job, u, work in meshes if job["dt"] == dt / 2}
    pairs = [(mesh, short_steps[mesh[0]["elements"]]) for mesh in long_steps if mesh[0]["elements"] in short_steps]
    if len(long_steps) < 2 or not pairs:
        return None
    (coarse, fine), (long, short) = long_steps[-2:], pairs[-1]
    found = {}
    for key, k in ("displacement", 1), ("energy", 2):
        space = second_order(coarse[k], fine[k], fine[0]["elements"] / coarse[0]["elements"])
        time = minus(second_order(long[k], short[k]), long[k])
        found[key] = [x + y for x, y in zip(space, time)]
    return with_steps(meshes, fine[1:], found)
