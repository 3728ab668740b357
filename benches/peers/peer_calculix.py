"""CalculiX (GPL; Debian package `calculix-ccx`): shells that are expanded to solids, S4 and S8R.

A job may give `element` and `increment` (first load increment; CalculiX chooses the next ones). SPOOLES is
the solver that Debian's program has. An S8R mesh of n x n elements has nodes in the middle of all sides.
"""

import re
import shutil

import problems

NAME = "CalculiX"
PACKAGES = []
PROGRAM = "ccx"


def command(_python, job_file):
    if shutil.which(PROGRAM) is None:
        raise FileNotFoundError("ccx is not installed: apt-get install calculix-ccx")
    job, folder = problems.read_job(job_file)
    write_input(job, folder / "case.inp")
    return [PROGRAM, "-i", "case"]


def write_input(job, path):
    n, quadratic = job["elements"], job["element"].startswith("S8")
    fine = 2 * n if quadratic else n
    used, elements = set(), []
    if quadratic:
        at = lambda i, j: i * (fine + 1) + j + 1
        for i in range(0, fine, 2):
            for j in range(0, fine, 2):
                elements.append([at(i, j), at(i + 2, j), at(i + 2, j + 2), at(i, j + 2),
                                 at(i + 1, j), at(i + 2, j + 1), at(i + 1, j + 2), at(i, j + 1)])
    else:
        elements = [[a + 1 for a in quad] for quad in problems.quads(n)]
    for element in elements:
        used.update(element)
    lines = ["*NODE, NSET=ALL"]
    lines += ["%d, %.12g, %.12g, %.12g" % (k + 1, *x)
              for k, (x, _) in enumerate(problems.nodes("cylinder", fine)) if k + 1 in used]
    lines += ["*ELEMENT, TYPE=%s, ELSET=SHELL" % job["element"]]
    lines += [", ".join(map(str, [k + 1, *element])) for k, element in enumerate(elements)]
    lines += ["*NSET, NSET=CLAMP, GENERATE", "1, %d, 1" % (fine + 1), "*MATERIAL, NAME=SHEET", "*ELASTIC",
              "%g, %g" % (problems.CYLINDER["young"], problems.POISSON), "*SHELL SECTION, ELSET=SHELL, MATERIAL=SHEET",
              "%g" % problems.THICKNESS, "*BOUNDARY", "CLAMP, 1, 6", "*STEP, NLGEOM, INC=1000", "*STATIC",
              "%g, 1.0" % job["increment"], "*CLOAD", "%d, 3, %g" % ((fine + 1)**2, -problems.CYLINDER["force"]),
              "*NODE PRINT, NSET=ALL, FREQUENCY=100000", "U", "*END STEP"]
    path.write_text("\n".join(lines) + "\n")


def finish(job, folder):
    """Reads what the program printed and leaves it in the common form."""
    n = job["elements"]
    fine = 2 * n if job["element"].startswith("S8") else n
    rows = {}
    for line in (folder / "case.dat").read_text().splitlines():
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            rows[int(words[0])] = [float(x) for x in words[1:]]
    steps, iterations = 0, 0
    for line in (folder / "case.sta").read_text().splitlines():
        words = line.split()
        if len(words) == 7 and words[0].isdigit():
            steps, iterations = steps + 1, iterations + int(words[3])
    log = (folder / "log.txt").read_text()
    unknowns = max((int(x) for x in re.findall(r"number of equations\s+(\d+)", log)), default=0)
    version = re.search(r"CalculiX Version ([\d.]+)", log)
    names = problems.POINTS["cylinder"]
    points = {p: rows[problems.node_of(names[p], fine) + 1] for p in names}
    problems.write_result(folder, version=version.group(1) if version else "", steps=steps, iterations=iterations,
                          unknowns=unknowns, points=points)
