"""EXUDYN (BSD licence, PyPI `exudyn`): thin plates of the absolute nodal coordinate formulation.

`ObjectANCFThinPlate` is the only shell of EXUDYN: a Kirchhoff shell, cubic without the mixed terms of the bicubic, with
a position and two slopes at a node. The slopes are unit vectors along the parameter lines, scaled by the length of the
element there, so the reference surface is exact for the hypar and fourth order for the cylinders. At a clamped
edge position and tangent plane are held; stretch is free. Loads are consistent nodal loads, on slopes too: the
program's `LoadMassProportional` gives the two mirrored halves of the hypar different displacements (2 % apart on
32 x 32 elements).

A job may give `reduced` (integration), `steps` (load steps), `dt`, `radius` (spectral radius of generalized alpha),
`trapezoidal` (Newmark's trapezoidal rule instead), `modified` (modified Newton), `numeric` (element tangents by
finite differences instead of automatic differentiation) and `tolerance`.
"""

import sys

import problems

NAME = "EXUDYN"
PACKAGES = ["exudyn", "numpy"]


def command(python, job_file):
    return [python, "-W", "ignore", __file__, job_file]


def plate_shapes(r, s):
    """The 12 shape functions at r, s of the unit square from -1 to 1: value and both derivatives, node by node."""
    found = []
    for a, b in problems.SIGNS:
        found.append(0.125 * (1 + a * r) * (1 + b * s) * (2 + a * r + b * s - r * r - s * s))
        found.append(0.125 * a * (1 + a * r) ** 2 * (a * r - 1) * (1 + b * s))
        found.append(0.125 * b * (1 + a * r) * (1 + b * s) ** 2 * (b * s - 1))
    return found


def loads(problem, n):
    """Consistent loads along -z on position and both slopes of each node, node by node."""
    import numpy as np

    points = list(problems.nodes(problem, n))
    lengths = [(1.0, np.linalg.norm(by_u) / (2 * n), np.linalg.norm(by_v) / (2 * n)) for _, by_u, by_v in points]
    found = np.zeros((len(points), 3))
    gauss = list(zip(*np.polynomial.legendre.leggauss(4)))
    for e, quad in enumerate(problems.quads(n)):
        u, v = (e // n) / n, (e % n) / n
        if problem == "cylinder":
            # Along the free edge r = 1 of the last elements.
            along = [(1.0, s, weight * problems.EDGE_FORCE / (2 * n)) for s, weight in gauss] if e // n == n - 1 else []
        else:
            along = []
            for r, weight_r in gauss:
                for s, weight_s in gauss:
                    _, by_u, by_v = problems.surface(problem, u + 0.5 * (1 + r) / n, v + 0.5 * (1 + s) / n)
                    area = np.linalg.norm(np.cross(by_u, by_v)) * weight_r * weight_s / (2 * n) ** 2
                    along.append((r, s, area * problems.density(problem, n, facets=False) * problems.THICKNESS
                                  * problems.GRAVITY))
        for r, s, force in along:
            shapes = plate_shapes(r, s)
            for k, node in enumerate(quad):
                for c in range(3):
                    found[node, c] += force * shapes[3 * k + c] * lengths[node][c]
    return found


def model(job):
    """The system, its nodes, and the number of unknowns."""
    import exudyn as exu
    import exudyn.itemInterface as item
    import numpy as np

    problem, n = job["problem"], job["elements"]
    system = CONTAINER.AddSystem()
    nu, h = problems.POISSON, problems.THICKNESS
    plane = problems.YOUNG[problem] / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    nodes, lengths = [], []
    for x, by_u, by_v in problems.nodes(problem, n):
        size_u, size_v = np.linalg.norm(by_u), np.linalg.norm(by_v)
        lengths.append((size_u / n, size_v / n))
        nodes.append(system.AddNode(item.NodePointSlope12(
            referenceCoordinates=[*x, *np.divide(by_u, size_u), *np.divide(by_v, size_v)])))
    for quad in problems.quads(n):
        system.AddObject(item.ObjectANCFThinPlate(
            thickness=h, density=problems.density(problem, n, facets=False), strainCoefficients=plane * h,
            curvatureCoefficients=plane * h**3 / 12, nodeNumbers=[nodes[a] for a in quad],
            slopesScalingX=[lengths[a][0] for a in quad], slopesScalingY=[lengths[a][1] for a in quad],
            useReducedOrderIntegration=job["reduced"]))
    ground = system.AddNode(item.NodePointGround(referenceCoordinates=[0, 0, 0]))
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    marker = lambda node, c: system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[node], coordinate=c))
    held = 0
    if problem in problems.STATIC:
        _, by_u, _ = problems.surface(problem, 0.0, 0.0)
        for node in problems.clamped(n):
            for c in (0, 1, 2, 4, 6, 7, 8):
                system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[fixed, marker(node, c)]))
            # The first slope stays along its direction in the plane y = const.; its length is free.
            system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[marker(node, 3), marker(node, 5)],
                                                            factorValue1=by_u[0] / by_u[2]))
            held += 8
    else:
        for c in range(3):
            system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[fixed, marker(0, c)]))
        held = 3
    for node, forces in enumerate(loads(problem, n)):
        if problem in problems.STATIC and node in problems.clamped(n):
            continue
        for c, force in zip((2, 5, 8), forces):
            if force != 0.0:
                system.AddLoad(item.LoadCoordinate(markerNumber=marker(node, c), load=-float(force)))
    return system, nodes, 9 * len(nodes) - held


def main():
    job, folder = problems.read_job(sys.argv[1])
    import exudyn as exu

    global CONTAINER
    CONTAINER = exu.SystemContainer()
    problem = job["problem"]
    system, nodes, unknowns = model(job)
    # Displacements of position and slopes.
    state = lambda: [list(map(float, system.GetNodeOutput(k, exu.OutputVariableType.Coordinates))) for k in nodes]
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = job.get("threads", 1)
    motion = []
    if problem in problems.STATIC:
        solver = settings.staticSolver
        solver.numberOfLoadSteps = job["steps"]
        solver.newton.maxIterations = 60
        solver.adaptiveStep = False
        run = exu.MainSolverStatic()
    else:
        solver = settings.timeIntegration
        solver.endTime = problems.END
        solver.numberOfSteps = round(problems.END / job["dt"])
        solver.generalizedAlpha.spectralRadius = job["radius"]
        solver.generalizedAlpha.useNewmark = job.get("trapezoidal", False)
        solver.adaptiveStep = False
        run = exu.MainSolverImplicitSecondOrder()

        def record(_system, time):
            # Called after every step, and once before the first.
            if abs(time - len(motion) * problems.EVERY) < 0.1 * job["dt"]:
                motion.append(state())
            return True

    solver.newton.useModifiedNewton = job["modified"]
    solver.newton.numericalDifferentiation.forODE2 = job["numeric"]
    solver.newton.relativeTolerance = job["tolerance"]
    system.Assemble()
    if problem == "pendulum":
        motion.append(state())
        system.SetPostStepUserFunction(record)
    if not run.SolveSystem(system, settings):
        sys.exit("Newton's method does not converge after step %d" % (run.it.currentStepIndex - 1))
    if problem in problems.STATIC:
        motion.append(state())
    problems.write_rows(folder, [row for sample in motion for row in sample])
    problems.write_statistics(folder, version=exu.__version__, steps=run.it.currentStepIndex - 1,
                              iterations=run.it.newtonStepsCount, unknowns=unknowns,
                              jacobians=run.it.newtonJacobiCount)


def finish(job, folder):
    """The work is that of the loads on positions and slopes."""
    import numpy as np

    found = problems.read_results(job, folder)
    rows = np.array(problems.read_rows(folder)).reshape(-1, (job["elements"] + 1) ** 2, 3, 3)
    forces = loads(job["problem"], job["elements"])
    works = [-float(np.sum(forces * sample[:, :, 2])) for sample in rows]
    found["work"] = works[0] if job["problem"] in problems.STATIC else works
    return found


if __name__ == "__main__":
    main()
