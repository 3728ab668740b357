"""tegula itself: `target/release/tegula run`, the path by power series or by the arc-length method; nothing is tuned.

A job may give keys of the analysis (`analysis`), `method` among them. Pictures and all fields but displacements are switched off.
"""

import csv
import json

import paths_roof as roof
import peer_tegula
from problems import read_job

NAME = "tegula"
# Force on the whole roof at load factor 1; the path ends before it.
FORCE = 6000.0


def command(_python, job_file):
    job, folder = read_job(job_file)
    (folder / "case.toml").write_text(model(job))
    return [str(peer_tegula.PROGRAM.resolve()), "run", "case.toml", "--out", "out", "--threads", "1", "--quiet"]


def model(job):
    n = job["elements"]
    lines = ["[analysis]", 'type = "path"', 'stop = [{ column = "middle.uz", value = %r }]' % -roof.END]
    lines += ["%s = %s" % (key, peer_tegula.toml(value)) for key, value in job.get("analysis", {}).items()]
    lines += ["[mesh]", 'type = "cylinder"', "axis = [0.0, 1.0, 0.0]", "start = [0.0, 0.0, 1.0]", "radius = %r" % roof.RADIUS,
              "angles = [0.0, 5.729577951308232]", "length = %r" % roof.HALF_LENGTH, "grid = { elements = [%d, %d] }" % (n, n),
              "[materials.sheet]", 'type = "isotropic"', "young = %r" % roof.YOUNG, "poisson = %r" % roof.POISSON,
              "[[sections]]", 'material = "sheet"', "thickness = %r" % job["thickness"],
              "[[conditions]]", 'type = "symmetry"', 'on = "u_min"', "normal = [1.0, 0.0, 0.0]",
              "[[conditions]]", 'type = "symmetry"', 'on = "v_min"', "normal = [0.0, 1.0, 0.0]",
              "[[conditions]]", 'type = "hinge"', 'on = "u_max"',
              "[[loads]]", 'type = "force"', 'on = "u_min_v_min"', "value = [0.0, 0.0, %r]" % (-0.25 * FORCE),
              "[output]", 'points = [{ name = "middle", on = "u_min_v_min" }]', 'fields = ["displacement"]', "pictures = false"]
    return "\n".join(lines) + "\n"


def finish(_job, folder):
    summary = json.loads((folder / "out/summary.json").read_text())
    rows = list(csv.DictReader((folder / "out/history.csv").open()))
    path = [(-float(row["middle.uz"]), FORCE * float(row["time"])) for row in rows]
    found = {key: summary[key] for key in ("version", "steps", "unknowns")}
    found = roof.measures({**found, "factorisations": summary["factorizations"], "path": path})
    # The program locates the limit itself.
    limits = [point["load_factor"] for point in summary["critical_points"] if point["kind"] == "limit"]
    return {**found, "limit": FORCE * limits[0]} if limits else found
