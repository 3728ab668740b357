"""CalculiX: the path by a prescribed deflection of the middle (it has no arc length); its shells are expanded to solids.

A job gives `element` (S4 or S8R), `increment` (the first, as part of the whole deflection; CalculiX chooses the next ones), `most` (the
longest) and `controls` (lines of `*CONTROLS`).
"""

import paths_roof as roof
import peer_calculix
from problems import quads, read_job, serendipity

NAME = peer_calculix.NAME


def command(_python, job_file):
    job, folder = read_job(job_file)
    write_input(job, folder / "case.inp")
    return peer_calculix.run_input()


def write_input(job, path):
    n = job["elements"]
    quadratic = peer_calculix.quadratic(job)
    fine = 2 * n if quadratic else n
    elements = list(serendipity(n) if quadratic else quads(n))
    used = {a for element in elements for a in element}
    lines = ["*NODE, NSET=ALL"]
    lines += ["%d, %.12g, %.12g, %.12g" % (k + 1, *x) for k, x in enumerate(roof.nodes(fine)) if k in used]
    lines += ["*ELEMENT, TYPE=%s, ELSET=SHELL" % job["element"]]
    lines += [", ".join(str(a) for a in (k + 1, *(a + 1 for a in element))) for k, element in enumerate(elements)]
    for name, nodes in ("CREST", roof.crest(fine)), ("MIDDLE", roof.middle(fine)), ("HINGE", roof.hinge(fine)):
        lines += ["*NSET, NSET=" + name, *("%d," % (k + 1) for k in nodes if k in used)]
    lines += ["*NSET, NSET=CENTRE", "1,",
              "*MATERIAL, NAME=SHEET", "*ELASTIC", "%r, %r" % (roof.YOUNG, roof.POISSON),
              "*SHELL SECTION, ELSET=SHELL, MATERIAL=SHEET", "%r" % job["thickness"],
              # Rotations about the normal must stay free: holding them, too, makes the nodes' expansions rigid, and the roof nearly clamped.
              "*BOUNDARY", "CREST, 1, 1", "CREST, 5, 5", "MIDDLE, 2, 2", "MIDDLE, 4, 4", "HINGE, 1, 3",
              "*STEP, NLGEOM, INC=100000", "*STATIC", "%r, 1.0, 1e-8, %r" % (job["increment"], job["most"])]
    lines += job.get("controls", [])
    lines += ["*BOUNDARY", "1, 3, 3, %r" % -roof.END, "*NODE PRINT, NSET=CENTRE", "U", "*NODE PRINT, NSET=HINGE, TOTALS=ONLY", "RF", "*END STEP"]
    path.write_text("\n".join(lines) + "\n")


def finish(_job, folder):
    """Reads what the program printed. The force of a prescribed deflection is that of the hinge: the printed one of the middle lacks
    the parts of the expanded nodes."""
    deflections, forces, into = [], [], None
    for line in (folder / "case.dat").read_text().splitlines():
        words = line.split()
        if words[:1] == ["displacements"]:
            into = deflections
        elif words[:2] == ["total", "force"]:
            into = forces
        elif into is not None and len(words) >= 3:
            into.append(float(words[-1]))
    found = peer_calculix.statistics(folder)
    return roof.measures({**found, "factorisations": found["iterations"],
                          "path": [(0.0, 0.0)] + [(-u, 4.0 * f) for u, f in zip(deflections, forces)]})
