"""tegula itself: `target/release/tegula run`, or the program in the environment variable TEGULA.

A job without further keys takes every default of the program: element, membrane, shear, solver, tolerances. It may
give keys of the model file's section (`section`), of its analysis (`analysis`), `fields` of the output, `directors` (the hypar's mesh is one layer of
hexahedra, which has the exact normals, instead of quadrilaterals) and `grading` (of the cylinder, for its limit). Pictures are switched
off, and fields are written at the end only: the others do no more.
"""

import csv
import json
import os
import pathlib

import problems

NAME = "tegula"
PACKAGES = []
PROGRAM = pathlib.Path(os.environ.get("TEGULA") or pathlib.Path(__file__).resolve().parents[2] / "target/release/tegula")


def command(_python, job_file):
    job, folder = problems.read_job(job_file)
    (folder / "case.toml").write_text(model(job))
    if job["problem"] == "hypar":
        write_mesh(job, folder / "hypar.msh")
    return [str(PROGRAM.resolve()), "run", "case.toml", "--out", "out", "--threads", str(job.get("threads", 1)), "--quiet"]


def toml(value):
    """A value as it is written in the model file."""
    if isinstance(value, dict):
        return "{ " + ", ".join("%s = %s" % (k, toml(v)) for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def model(job):
    problem, n = job["problem"], job["elements"]
    static = problem in problems.STATIC
    text = ["[analysis]", 'type = "%s"' % ("static" if static else "transient")]
    text += ["%s = %s" % (key, toml(value)) for key, value in job.get("analysis", {}).items()]
    if not static:
        text += ["end_time = %r" % problems.END]
    text += ["[mesh]"]
    if problem == "hypar":
        text += ['type = "gmsh"', 'file = "hypar.msh"']
    else:
        text += ['type = "cylinder"', "axis = [0.0, 1.0, 0.0]", "radius = 1.0", "length = 1.0"]
        if problem == "cylinder":
            text += ["center = [1.0, 0.0, 0.0]", "start = [-1.0, 0.0, 0.0]", "angles = [0.0, 90.0]"]
        else:
            text += ["center = [0.0, 0.0, 1.0]", "start = [0.0, 0.0, -1.0]", "angles = [0.0, -90.0]"]
        text += ["grid = { elements = [%d, %d] }" % (n, n)]
    text += ["[materials.sheet]", 'type = "isotropic"', "young = %r" % problems.YOUNG[problem],
             "poisson = %r" % problems.POISSON]
    if problem == "hypar":
        text += ["density = %r" % problems.HYPAR_DENSITY]
    text += ["[[sections]]", 'material = "sheet"', "thickness = %r" % problems.THICKNESS]
    text += ["%s = %s" % (key, toml(value)) for key, value in job.get("section", {}).items()]
    if problem == "cylinder":
        text += ["[[conditions]]", 'type = "clamp"', 'on = "u_min"', "[[loads]]", 'type = "edge"', 'on = "u_max"',
                 "value = [0.0, 0.0, %r]" % -problems.EDGE_FORCE]
    elif problem == "hypar":
        text += ["[[conditions]]", 'type = "clamp"', 'on = "root"']
    else:
        text += ["total_mass = %r" % problems.PENDULUM_MASS, "[[conditions]]", 'type = "spherical"',
                 'on = "u_min_v_min"']
    if problem != "cylinder":
        text += ["[[loads]]", 'type = "gravity"', "value = [0.0, 0.0, %r]" % -problems.GRAVITY]
    text += ["[output]", "interval = 1.0", "pictures = false"]
    if "fields" in job:
        text += ["fields = %s" % toml(job["fields"])]
    text += ["points = ["]
    for name, (u, v) in compared(problem).items():
        x, _, _ = problems.surface(problem, u, v)
        text += ['  { name = "%s", at = [%.12f, %.12f, %.12f] },' % (name, *x)]
    return "\n".join(text + ["]"]) + "\n"


def compared(problem):
    """Recorded points, as (u, v): the common grid or the corners."""
    if problem in problems.STATIC:
        steps = range(problems.GRID + 1)
        return {"p%d-%d" % (i, j): (i / problems.GRID, j / problems.GRID) for i in steps for j in steps}
    return problems.CORNERS


def write_mesh(job, path):
    """The hypar as quadrilaterals, or as one layer of hexahedra, in Gmsh's format 2.2."""
    n, count = job["elements"], (job["elements"] + 1) ** 2
    points = list(problems.nodes("hypar", n))
    layers = [0.0]
    if job.get("directors"):
        layers = [-0.5 * problems.THICKNESS, 0.5 * problems.THICKNESS]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '1 1 "root"',
             '%d 2 "shell"' % (1 + len(layers)), "$EndPhysicalNames", "$Nodes", str(count * len(layers))]
    for k, offset in enumerate(layers):
        for a, ((x, y, z), by_u, by_v) in enumerate(points):
            normal = (by_u[1] * by_v[2] - by_u[2] * by_v[1], by_u[2] * by_v[0] - by_u[0] * by_v[2],
                      by_u[0] * by_v[1] - by_u[1] * by_v[0])
            factor = offset / sum(c * c for c in normal) ** 0.5
            lines.append("%d %.16g %.16g %.16g" % (k * count + a + 1, x + factor * normal[0], y + factor * normal[1],
                                                   z + factor * normal[2]))
    lines += ["$EndNodes", "$Elements", str(n + n * n)]
    lines += ["%d 1 2 1 1 %d %d" % (k + 1, k + 1, k + 2) for k in range(n)]
    for e, quad in enumerate(problems.quads(n)):
        corners = [k * count + a + 1 for k in range(len(layers)) for a in quad]
        lines.append(" ".join(map(str, (n + e + 1, 3 if len(layers) == 1 else 5, 2, 2, 2, *corners))))
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n")


def finish(job, folder):
    summary = json.loads((folder / "out/summary.json").read_text())
    found = {key: summary[key] for key in ("version", "steps", "iterations", "unknowns")}
    names = compared(job["problem"])
    if job["problem"] in problems.STATIC:
        found["grid"] = [summary["points"][name]["displacement"] for name in names]
        found["work"] = -summary["energy"]["potential"]
        return found
    rows = list(csv.DictReader((folder / "out/history.csv").open()))
    times = [float(row["time"]) for row in rows]
    column = lambda key: [float(row[key]) for row in rows]
    corners = {name: [column("%s.u%s" % (name, axis)) for axis in "xyz"] for name in names}
    weight = column("potential")
    found["corners"] = [{name: [cubic(times, values, t) for values in corners[name]] for name in names}
                        for t in problems.samples()]
    found["work"] = [-cubic(times, weight, t) for t in problems.samples()]
    return found


def cubic(times, values, t):
    """The value at `t` of the cubic through the four neighbours of a table: steps do not end at the samples."""
    k = min(max(sum(1 for x in times if x <= t) - 2, 0), len(times) - 4)
    total = 0.0
    for a in range(k, k + 4):
        weight = 1.0
        for b in range(k, k + 4):
            if b != a:
                weight *= (t - times[b]) / (times[a] - times[b])
        total += weight * values[a]
    return total
