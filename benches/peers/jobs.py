"""Which runs are compared, and which runs give the limits that errors refer to.

A run is a dictionary: `peer`, `family` (settings in words: a family shares all but mesh and time step), `theory` (whose
limit its error refers to), `job`, and for the runs of tegula `row`, `default` or `best`.
"""

PROBLEMS = ("cylinder", "hypar", "pendulum")
SHEAR, KIRCHHOFF, SOLID = "shear-flexible shell", "Kirchhoff shell", "solid"

MITC = {"element": "MITCThickShellCorotationalElement3D4N"}
DKQ = {"element": "ShellThinElementCorotational3D4N"}
LU, AMG = {"solver": "LinearSolversApplication.sparse_lu"}, {"solver": "amgcl"}
# Load steps and tolerances: as few, and as loose, as spoil neither convergence nor the result.
KRATOS = {"cylinder": {"steps": 1, "tolerance": 1e-4}, "hypar": {"steps": 5, "tolerance": 1e-3}}
EXUDYN = {"cylinder": {"steps": 1, "tolerance": 1e-8, "modified": False, "numeric": False},
          "hypar": {"steps": 1, "tolerance": 1e-6, "modified": False, "numeric": True},
          "pendulum": {"tolerance": 1e-3, "modified": True, "numeric": True, "radius": 0.9}}
ASD = {"element": "ASDShellQ4 -corotational", "system": "UmfPack", "steps": 1, "tolerance": 1e-4}
# Default tolerances of CalculiX leave an error of the order of that of the mesh.
TIGHT = {"controls": ["*CONTROLS, PARAMETERS=FIELD", "1e-4, 1e-2"]}
INCREMENT = {"cylinder": {"increment": 0.34}, "hypar": {"increment": 0.5}}
STABILISED = {"shear_stabilization": 0.1}
# The best settings found for tegula; no fields but displacements, as the others.
BEST = {"cylinder": {}, "hypar": {"section": STABILISED}, "pendulum": {"section": STABILISED}}
NAMES = {"cylinder": "displacements only", "hypar": "stabilised shear, displacements only",
         "pendulum": "stabilised shear, displacements only"}


def run(peer, family, theory, problem, elements, row="", **job):
    return {"peer": peer, "family": family, "theory": theory, "row": row,
            "job": {"problem": problem, "elements": elements, **job}}


def runs():
    for problem in ("cylinder", "hypar"):
        yield from static_runs(problem)
    yield from pendulum_runs()


def static_runs(problem):
    for n in (4, 8, 12, 16, 24, 32, 48, 64, 96, 128):
        yield run("tegula", "default settings", SHEAR, problem, n, "default")
        yield run("tegula", NAMES[problem], SHEAR, problem, n, "best", fields=["displacement"], **BEST[problem])
    if not BEST[problem]:
        for n in (16, 32, 64):
            yield run("tegula", "stabilised shear", SHEAR, problem, n, section=STABILISED)
    for n in (8, 16, 32, 64):
        yield run("Kratos", "MITC, AMGCL", SHEAR, problem, n, **KRATOS[problem], **MITC, **AMG)
    yield run("Kratos", "MITC, sparse LU", SHEAR, problem, 32, **KRATOS[problem], **MITC, **LU)
    for n in (4, 8, 16, 32):
        yield run("EXUDYN", "ANCF thin plate", KIRCHHOFF, problem, n, reduced=1, **EXUDYN[problem])
    for n in (8, 16, 32):
        yield run("OpenSees", "ASDShellQ4, UMFPACK", SHEAR, problem, n, **ASD)
    for n in (8, 16, 32):
        yield run("CalculiX", "S8R, SPOOLES", SOLID, problem, n, element="S8R", **INCREMENT[problem], **TIGHT)
    for n in (16, 32, 64):
        yield run("CalculiX", "S4, SPOOLES", SOLID, problem, n, element="S4", **INCREMENT[problem], **TIGHT)


def pendulum_runs():
    """Meshes and time steps together: each is as coarse as the other allows."""
    for n in (4, 8, 12, 16, 24, 32):
        yield run("tegula", "default settings", SHEAR, "pendulum", n, "default")
    for n, tolerances in ((4, (1e-3, 1e-4)), (8, (1e-3, 3e-4, 1e-4)), (12, (3e-4, 1e-4, 3e-5)), (16, (1e-4, 1e-5)),
                          (24, (1e-5, 1e-6)), (32, (1e-6,))):
        for tolerance in tolerances:
            yield run("tegula", NAMES["pendulum"], SHEAR, "pendulum", n, "best", fields=["displacement"],
                      analysis={"tolerance": tolerance}, **BEST["pendulum"])
    for n, dt, alpha in ((4, 0.005, -0.3), (8, 0.005, -0.3), (8, 0.0025, -0.05), (12, 0.0025, -0.05), (16, 0.0025, -0.05)):
        yield run("Kratos", "MITC, Bossak %g, sparse LU" % alpha, SHEAR, "pendulum", n, dt=dt, alpha=alpha, tolerance=1e-3,
                  **MITC, **LU)
    for n, dt in ((4, 0.00125), (4, 0.000625), (6, 0.000625), (8, 0.000625), (8, 0.0003125)):
        yield run("EXUDYN", "ANCF thin plate", KIRCHHOFF, "pendulum", n, dt=dt, reduced=1, **EXUDYN["pendulum"])
    for n, dt, alpha in ((4, 0.005, -0.3), (6, 0.005, -0.3), (8, 0.005, -0.3), (8, 0.0025, -0.05)):
        yield run("CalculiX", "S8R, alpha %g, SPOOLES" % alpha, SOLID, "pendulum", n, dt=dt, alpha=alpha, element="S8R")


def limit_runs():
    """Meshes of each code from which the limit of each theory is extrapolated."""
    ours = ((SHEAR, "ems", {"element": "ems"}),
            (SHEAR, "mitc4, stabilised shear", {"element": "mitc4", **STABILISED}),
            (KIRCHHOFF, "ems, 1000 times the shear stiffness", {"element": "ems", "shear_correction": [1000.0, 1000.0]}),
            (SOLID, "solid-shell", {"element": "solid-shell"}))
    for problem in ("cylinder", "hypar"):
        hypar = problem == "hypar"
        for n in (64, 128, 256):
            for theory, family, section in ours:
                yield run("tegula", family, theory, problem, n, section=section)
        for n in (16, 32, 64):
            yield run("EXUDYN", "ANCF thin plate", KIRCHHOFF, problem, n, reduced=1,
                      **{**EXUDYN["cylinder"], "tolerance": 1e-8})
        for n in (32, 64, 128):
            yield run("Kratos", "DKQ", KIRCHHOFF, problem, n, **{**KRATOS[problem], "tolerance": 1e-6}, **DKQ, **LU)
            yield run("Kratos", "MITC", SHEAR, problem, n, **{**KRATOS[problem], "tolerance": 1e-6}, **MITC,
                      **(AMG if hypar else LU))
            yield run("CalculiX", "S4", SOLID, problem, n, element="S4", increment=0.5 if hypar else 1.0, **TIGHT)
        for n in (16, 32, 64):
            yield run("CalculiX", "S8R", SOLID, problem, n, element="S8R", increment=0.5 if hypar else 1.0, **TIGHT)
    for theory, family, section in ours:
        for n in (16, 32, 64) if family == "ems" else (8, 16, 32):
            if family != "mitc4, stabilised shear":
                yield run("tegula", family, theory, "pendulum", n, section=section, analysis={"tolerance": 1e-7})
    for n, dt in ((8, 0.0025), (16, 0.0025), (8, 0.00125)):
        yield run("Kratos", "MITC", SHEAR, "pendulum", n, dt=dt, alpha=-0.05, tolerance=1e-3, **MITC, **LU)
        yield run("EXUDYN", "ANCF thin plate", KIRCHHOFF, "pendulum", n, dt=dt / 4, reduced=1, **EXUDYN["pendulum"])
    for n, dt in ((8, 0.0025), (12, 0.0025), (8, 0.00125)):
        yield run("CalculiX", "S8R", SOLID, "pendulum", n, dt=dt, alpha=-0.05, element="S8R")
