"""tegula itself: `target/release/tegula run` with all its files; no pictures, which the others do not draw either.

A job may give `element`, `shear_stabilization`, `scheme`, `tolerance` of the time steps, and `plain` (fewest files: only the field
of displacements, at the end).
"""

import csv
import json
import pathlib

import problems

NAME = "tegula"
PACKAGES = []
PROGRAM = pathlib.Path(__file__).resolve().parents[2] / "target/release/tegula"


def command(_python, job_file):
    job, folder = problems.read_job(job_file)
    (folder / "case.toml").write_text(model(job))
    return [str(PROGRAM), "run", "case.toml", "--out", "out", "--threads", str(job.get("threads", 1)), "--quiet"]


def model(job):
    problem, n = job["problem"], job["elements"]
    cylinder = problem == "cylinder"
    text = ["[analysis]"]
    if cylinder:
        text += ['type = "static"']
    else:
        text += ['type = "transient"', "end_time = %g" % problems.PENDULUM["end"], "tolerance = %g" % job["tolerance"],
                 'scheme = { type = "%s" }' % job.get("scheme", "newmark")]
    text += ["[mesh]", 'type = "cylinder"', "axis = [0.0, 1.0, 0.0]", "radius = 1.0", "length = 1.0"]
    if cylinder:
        text += ["center = [1.0, 0.0, 0.0]", "start = [-1.0, 0.0, 0.0]", "angles = [0.0, 90.0]"]
    else:
        text += ["center = [0.0, 0.0, 1.0]", "start = [0.0, 0.0, -1.0]", "angles = [0.0, -90.0]"]
    young = (problems.CYLINDER if cylinder else problems.PENDULUM)["young"]
    text += ["grid = { elements = [%d, %d] }" % (n, n), "[materials.sheet]", 'type = "isotropic"',
             "young = %r" % young, "poisson = %r" % problems.POISSON, "[[sections]]", 'material = "sheet"',
             "thickness = %r" % problems.THICKNESS, 'element = "%s"' % job.get("element", "ems"),
             "shear_stabilization = %g" % job.get("shear_stabilization", 0.0)]
    if cylinder:
        text += ["[[conditions]]", 'type = "clamp"', 'on = "u_min"', "[[loads]]", 'type = "force"',
                 'on = "u_max_v_max"', "value = [0.0, 0.0, %r]" % -problems.CYLINDER["force"]]
    else:
        text += ["total_mass = %r" % problems.PENDULUM["mass"], "[[conditions]]", 'type = "spherical"',
                 'on = "u_min_v_min"', "[[loads]]", 'type = "gravity"',
                 "value = [0.0, 0.0, %r]" % -problems.PENDULUM["gravity"]]
    sides = ("min", "max")
    points = ['{ name = "%s", on = "u_%s_v_%s" }' % (p, sides[i], sides[j])
              for p, (i, j) in problems.POINTS[problem].items()]
    # Fields at the end only, as the others: the motion of the points is written at every step anyway.
    text += ["[output]", "points = [%s]" % ", ".join(points), "interval = 1.0", "pictures = false"]
    if job.get("plain"):
        text += ['fields = ["displacement"]']
    return "\n".join(text) + "\n"


def finish(job, folder):
    summary = json.loads((folder / "out/summary.json").read_text())
    names = problems.POINTS[job["problem"]]
    points = {p: summary["points"][p]["displacement"] for p in names}
    history = []
    if job["problem"] == "pendulum":
        rows = list(csv.DictReader((folder / "out/history.csv").open()))
        times = [float(row["time"]) for row in rows]
        columns = {p: [[float(row["%s.u%s" % (p, axis)]) for row in rows] for axis in "xyz"] for p in names}
        for t in problems.samples():
            history.append({p: [cubic(times, values, t) for values in columns[p]] for p in names})
    problems.write_result(folder, version=summary["version"], steps=summary["steps"],
                          iterations=summary["iterations"], unknowns=summary["unknowns"], points=points,
                          history=history)


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
