"""Which runs of the machines are compared, and which give the limits that errors refer to.

A run is a dictionary as in `jobs`; `kind` says what is beside what: beams, shells, rigid bodies.
"""

BEAMS, SHELLS, BODIES = "beams", "shells", "rigid bodies"
# Rods that shear and whose sections have inertia, and rods and plates without both. Where they differ by less than 1e-5 the first counts.
SHEAR, NORMAL = "shear-flexible", "Bernoulli, Kirchhoff"
TITLES = {"spin-up": "Spin-up of a beam", "slider-crank": "Elastic slider-crank", "chain": "Chain of twenty bars", "plate": "Plate on joints"}
EM, ALPHA = {"type": "energy-momentum"}, {"type": "generalized-alpha", "spectral_radius": 0.8}
FOURTH = {"type": "energy-momentum", "order": 4}
# Elements with consistent mass have the frequencies of a beam to fourth order where the transverse shear is stabilised by 1.25.
MITC, DYNAMIC = {"element": "mitc4"}, {"element": "mitc4", "shear_stabilization": 1.25}
STABLE = {"element": "mitc4", "shear_stabilization": 0.1}
NEWTON = {"spin-up": {"tolerance": 1e-5, "absolute": 1e-6, "modified": False}, "slider-crank": {"tolerance": 1e-5},
          "plate": {"tolerance": 1e-3, "radius": 0.6}}


def run(peer, kind, family, theory, problem, model, elements, **job):
    return {"peer": peer, "kind": kind, "family": family, "theory": theory, "row": "default",
            "job": {"problem": problem, "model": model, "elements": elements, **job}}


def ours(kind, family, problem, model, elements, theory=SHEAR, section=None, **analysis):
    job = {"analysis": analysis, **({"section": section} if section else {})}
    # The step once more, where errors are sorted by it.
    return run("tegula", kind, family, theory, problem, model, elements, dt=analysis.get("time_step", analysis.get("tolerance")), **job)


def theirs(kind, family, problem, model, elements, theory=SHEAR, **job):
    return run("EXUDYN", kind, family, theory, problem, model, elements, **job)


def runs():
    yield from spin_up()
    yield from slider_crank()
    yield from chain()
    yield from plate()


def spin_up():
    p = "spin-up"
    for n, dt in ((8, 0.04), (8, 0.02), (12, 0.02), (16, 0.04), (16, 0.02), (24, 0.02), (32, 0.01)):
        yield ours(BEAMS, "beam, energy-momentum", p, "beam", n, time_step=dt, scheme=EM)
    for n, dt in ((8, 0.04), (8, 0.02), (12, 0.02), (16, 0.02), (16, 0.01), (24, 0.01), (32, 0.01), (32, 0.005), (48, 0.005)):
        yield ours(BEAMS, "beam, generalized alpha", p, "beam", n, time_step=dt, scheme=ALPHA)
    for n, dt in ((4, 0.04), (4, 0.02), (6, 0.02), (8, 0.02), (8, 0.01), (12, 0.01), (16, 0.005)):
        yield ours(SHELLS, "MITC, energy-momentum", p, "shell", n, section=MITC, time_step=dt, scheme=EM)
        yield ours(SHELLS, "MITC, generalized alpha", p, "shell", n, section=MITC, time_step=dt, scheme=ALPHA)
    for n, dt in ((2, 0.02), (4, 0.02), (4, 0.01), (6, 0.01), (8, 0.01), (8, 0.005), (8, 0.0025)):
        yield theirs(BEAMS, "ANCF cable, full Newton, dense", p, "cable", n, dt=dt, dense=True, **NEWTON[p])
        yield theirs(BEAMS, "ANCF cable, full Newton, sparse", p, "cable", n, dt=dt, **NEWTON[p])
    for n, dt in ((2, 0.02), (3, 0.01), (4, 0.02), (4, 0.01)):
        yield theirs(BEAMS, "three-node beam, full Newton", p, "beam3", n, dt=dt, **NEWTON[p])
    for n, dt in ((2, 0.01), (4, 0.02), (4, 0.01), (8, 0.01)):
        for modified in (False, True) if dt == 0.01 else (False,):
            yield theirs(SHELLS, "ANCF thin plate, %s Newton" % ("modified" if modified else "full"), p, "plate", n, dt=dt, reduced=1,
                         radius=0.6, tolerance=1e-4, absolute=1e-5, modified=modified)


def slider_crank():
    p = "slider-crank"
    for n, dt in ((4, 2e-4), (6, 2e-4), (8, 2e-4), (8, 1e-4), (12, 1e-4), (16, 1e-4), (24, 1e-4), (24, 5e-5), (32, 5e-5), (48, 5e-5)):
        yield ours(BEAMS, "beam, energy-momentum", p, "beam", n, time_step=dt, scheme=EM)
        yield ours(BEAMS, "beam, generalized alpha", p, "beam", n, time_step=dt, scheme=ALPHA)
    for n, dt in ((4, 2e-4), (6, 2e-4), (8, 2e-4), (8, 1e-4), (12, 1e-4), (16, 1e-4), (16, 5e-5), (24, 5e-5), (32, 2e-5)):
        yield ours(SHELLS, "MITC, shear stabilised for vibrations, energy-momentum", p, "shell", n, section=DYNAMIC, time_step=dt, scheme=EM)
        yield ours(SHELLS, "MITC, shear stabilised for vibrations, generalized alpha", p, "shell", n, section=DYNAMIC, time_step=dt, scheme=ALPHA)
    for n, dt in ((16, 1e-4), (32, 1e-4), (48, 5e-5)):
        yield ours(SHELLS, "default element, energy-momentum", p, "shell", n, time_step=dt, scheme=EM)
    for n, dt in ((2, 4e-4), (2, 2e-4), (4, 2e-4), (4, 1e-4), (4, 5e-5), (8, 5e-5), (8, 2e-5)):
        for tolerance in (1e-3, 1e-5):
            yield theirs(BEAMS, "ANCF cable, Newton to %g" % tolerance, p, "cable", n, NORMAL, dt=dt, tolerance=tolerance)
    for n, dt in ((2, 1e-4), (4, 1e-4), (4, 5e-5)):
        yield theirs(BEAMS, "three-node beam", p, "beam3", n, dt=dt, **NEWTON[p])
    for n, dt in ((2, 4e-4), (2, 2e-4), (4, 1e-4), (4, 5e-5), (8, 2.5e-5)):
        for radius in (0.6, 0.9):
            yield theirs(SHELLS, "ANCF thin plate, spectral radius %g" % radius, p, "plate", n, NORMAL, dt=dt, reduced=1, tolerance=1e-4,
                         radius=radius)


def chain():
    p = "chain"
    for model, family in (("spherical", "spherical joints"), ("revolute", "revolute joints")):
        for tolerance in (1e-3, 1e-4, 1e-5) if model == "spherical" else (1e-4,):
            yield ours(BODIES, family + ", energy-momentum", p, model, 0, tolerance=tolerance, scheme=EM)
        for dt in (0.0025, 0.001) if model == "spherical" else (0.0025,):
            yield ours(BODIES, family + ", energy-momentum, constant steps", p, model, 0, time_step=dt, scheme=EM)
    for dt in (0.005, 0.0025):
        yield ours(BODIES, "spherical joints, fourth order", p, "spherical", 0, time_step=dt, scheme=FOURTH)
    for relative in (3e-2, 1e-2, 1e-3, 1e-4, 1e-5):
        yield theirs(BODIES, "minimal coordinates, DOPRI5", p, "tree", 0, dt=0.05 * relative**0.2, explicit="DOPRI5", relative=relative)
    for dt in (0.005, 0.0025, 0.001):
        yield theirs(BODIES, "minimal coordinates, RK44", p, "tree", 0, dt=dt, explicit="RK44")
        yield theirs(BODIES, "joints, trapezoidal rule", p, "planar", 0, dt=dt, scheme="trapezoidal", tolerance=1e-3, modified=False)
    for dt in (0.001, 0.0005):
        yield theirs(BODIES, "joints, generalized alpha", p, "planar", 0, dt=dt, tolerance=1e-5)


def plate():
    p = "plate"
    for n, tolerances in ((2, (1e-3, 3e-4)), (4, (1e-3, 3e-4, 1e-4)), (6, (1e-4,)), (8, (3e-4, 1e-4, 3e-5)), (12, (1e-4, 3e-5, 1e-5)), (16, (3e-5, 1e-5)),
                          (24, (3e-6,))):
        for tolerance in tolerances:
            yield ours(SHELLS, "MITC, stabilised shear", p, "shell", n, section=STABLE, tolerance=tolerance)
    for n in (4, 8, 16):
        yield ours(SHELLS, "default settings", p, "shell", n, tolerance=1e-5)
    for n, dt in ((2, 0.003), (2, 0.0025), (4, 0.005), (4, 0.0025), (6, 0.0025), (8, 0.0025)):
        yield theirs(SHELLS, "ANCF thin plate, full Newton", p, "plate", n, dt=dt, reduced=1, modified=False, **NEWTON[p])
    for n, dt in ((2, 0.0025), (4, 0.0025), (4, 0.00125)):
        yield theirs(SHELLS, "ANCF thin plate, modified Newton", p, "plate", n, dt=dt, reduced=1, **NEWTON[p])


def limit_runs():
    """Of each theory one code of each program: meshes of which each is twice as fine as the one before, and half the step."""
    steps = {"time_step": 0.005, "scheme": EM}
    for n, factor in ((32, 1), (64, 1), (32, 2)):
        yield run("tegula", BEAMS, "beam", SHEAR, "spin-up", "beam", n, analysis={**steps, "time_step": 0.005 / factor}, dt=0.005 / factor)
        yield run("EXUDYN", BEAMS, "ANCF cable", SHEAR, "spin-up", "cable", n // 4, dt=0.005 / factor, tolerance=1e-6, absolute=1e-7)
        for theory, thin in ((SHEAR, False), (NORMAL, True)):
            dt = 1e-5 / factor
            yield run("tegula", BEAMS, "beam", theory, "slider-crank", "beam", n, analysis={**steps, "time_step": dt}, dt=dt, thin=thin)
            yield run("EXUDYN", BEAMS, "ANCF cable" if thin else "three-node beam", theory, "slider-crank", "cable" if thin else "beam3",
                      n // 4, dt=dt, tolerance=1e-6)
    for n in (16, 32, 64):
        for family, section in (("ems", {}), ("mitc4, stabilised shear", STABLE)):
            yield run("tegula", SHELLS, family, SHEAR, "plate", "shell", n, analysis={"tolerance": 1e-6}, section=section)
        yield run("EXUDYN", SHELLS, "ANCF thin plate", SHEAR, "plate", "plate", n // 4, dt=0.000625, reduced=1, **NEWTON["plate"])
