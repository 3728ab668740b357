"""CalculiX (GPL; Debian package `calculix-ccx`): shells that are expanded to solids, S4 and S8R, and solids.

A job may give `element` (S4, S8R, or C3D20R and C3D8I with `layers` of elements over the thickness), `increment` (first load
increment; CalculiX chooses the next ones), `controls` (lines of `*CONTROLS`), `solver`, `dt` and `alpha` (fixed time step and
parameter of the alpha method). SPOOLES is the direct solver that Debian's program has. An S8R mesh of n x n
elements has nodes in the middle of all sides.
"""

import re
import shutil

import problems

NAME = "CalculiX"
PACKAGES = []
PROGRAM = "ccx"


def command(_python, job_file):
    job, folder = problems.read_job(job_file)
    write_input(job, folder / "case.inp")
    return run_input()


def run_input():
    """Command line that computes the file case.inp."""
    if shutil.which(PROGRAM) is None:
        raise FileNotFoundError("ccx is not installed: apt-get install calculix-ccx")
    return [PROGRAM, "-i", "case"]


def quadratic(job):
    return job["element"].startswith("S8")


def write_input(job, path):
    problem, n = job["problem"], job["elements"]
    fine = 2 * n if quadratic(job) else n
    elements = list(problems.serendipity(n) if quadratic(job) else problems.quads(n))
    used = {a for element in elements for a in element}
    lines = ["*NODE, NSET=ALL"]
    lines += ["%d, %.12g, %.12g, %.12g" % (k + 1, *x) for k, (x, _, _) in enumerate(problems.nodes(problem, fine))
              if k in used]
    lines += ["*ELEMENT, TYPE=%s, ELSET=SHELL" % job["element"]]
    lines += [", ".join(str(a) for a in (k + 1, *(a + 1 for a in element))) for k, element in enumerate(elements)]
    lines += ["*NSET, NSET=CLAMP", *("%d," % (k + 1) for k in problems.clamped(fine)),
              "*MATERIAL, NAME=SHEET", "*ELASTIC", "%r, %r" % (problems.YOUNG[problem], problems.POISSON),
              "*DENSITY", "%r" % problems.density(problem, n, facets=not quadratic(job)),
              "*SHELL SECTION, ELSET=SHELL, MATERIAL=SHEET", "%r" % problems.THICKNESS]
    lines += ["*BOUNDARY", "CLAMP, 1, 6" if problem in problems.STATIC else "1, 1, 3"]
    lines += ["*STEP, NLGEOM, INC=100000"]
    if problem in problems.STATIC:
        lines += ["*STATIC" + solver(job), "%r, 1.0" % job["increment"]]
    else:
        lines += ["*DYNAMIC, DIRECT, ALPHA=%r" % job["alpha"] + solver(job), "%r, %r" % (job["dt"], problems.END)]
    lines += job.get("controls", [])
    if problem == "cylinder":
        forces = problems.edge_forces(n, quadratic(job))
        lines += ["*CLOAD", *("%d, 3, %.15g" % (k + 1, -force) for k, force in zip(problems.edge(fine), forces))]
    else:
        lines += ["*DLOAD", "SHELL, GRAV, %r, 0., 0., -1." % problems.GRAVITY]
    every = 100000 if problem in problems.STATIC else round(problems.EVERY / job["dt"])
    lines += ["*NODE PRINT, NSET=ALL, FREQUENCY=%d" % every, "U", "*END STEP"]
    path.write_text("\n".join(lines) + "\n")


def solver(job):
    return ", SOLVER=" + job["solver"] if "solver" in job else ""


def finish(job, folder):
    """Reads what the program printed and leaves it in the common form."""
    n = job["elements"]
    fine = 2 * n if quadratic(job) else n
    motion = []
    for line in (folder / "case.dat").read_text().splitlines():
        words = line.split()
        if line.lstrip().startswith("displacements"):
            motion.append([[float("nan")] * 3 for _ in range((fine + 1) ** 2)])
        elif len(words) == 4 and words[0].isdigit():
            motion[-1][int(words[0]) - 1] = [float(x) for x in words[1:]]
    found = statistics(folder)
    if job["problem"] in problems.STATIC:
        return {**found, **problems.measures(job["problem"], n, motion[-1], quadratic(job))}
    start = [[0.0] * 3 for _ in range((fine + 1) ** 2)]
    return {**found, **problems.motion_measures(n, [start, *motion], quadratic(job))}


def statistics(folder):
    """Version, increments, iterations and equations of a run."""
    steps, iterations = 0, 0
    for line in (folder / "case.sta").read_text().splitlines():
        words = line.split()
        if len(words) == 7 and words[0].isdigit():
            steps, iterations = steps + 1, iterations + int(words[3])
    log = (folder / "log.txt").read_text()
    unknowns = max((int(x) for x in re.findall(r"number of equations\s+(\d+)", log)), default=0)
    version = re.search(r"CalculiX Version ([\d.]+)", log)
    return {"version": version.group(1) if version else "", "steps": steps, "iterations": iterations, "unknowns": unknowns}
