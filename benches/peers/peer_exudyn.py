"""EXUDYN (BSD licence, PyPI `exudyn`): thin plates of the absolute nodal coordinate formulation.

`ObjectANCFThinPlate` is the only shell of EXUDYN: a Kirchhoff plate, bicubic without the mixed terms, with
a position and two slopes at a node. A job may give `reduced` (integration), `steps` (load steps), `dt`,
`radius` (spectral radius of generalized alpha; 1 with `trapezoidal` is Newmark's trapezoidal rule),
`modified` (modified Newton), `numeric` (element tangents by finite differences instead of automatic
differentiation) and `tolerance`. At the clamped edge position and tangent plane are held; stretch is free.
"""

import sys

import problems

NAME = "EXUDYN"
PACKAGES = ["exudyn", "numpy"]


def command(python, job_file):
    return [python, "-W", "ignore", __file__, job_file]


def model(job):
    """The system, its nodes, and the numbers of unknowns and constraints."""
    import exudyn as exu
    import exudyn.itemInterface as item
    import numpy as np

    problem, n = job["problem"], job["elements"]
    system = CONTAINER.AddSystem()
    young = (problems.CYLINDER if problem == "cylinder" else problems.PENDULUM)["young"]
    nu, h = problems.POISSON, problems.THICKNESS
    plane = young / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    nodes = [system.AddNode(item.NodePointSlope12(referenceCoordinates=[*x, *tangent, 0, 1, 0]))
             for x, tangent in problems.nodes(problem, n)]
    # A cubic follows the arc closely: 5 kg are on the cylinder itself, not on facets.
    rho = problems.PENDULUM["mass"] / (0.5 * np.pi * h)
    plates = []
    for quad in problems.quads(n):
        plates.append(system.AddObject(item.ObjectANCFThinPlate(
            thickness=h, density=rho, strainCoefficients=plane * h, curvatureCoefficients=plane * h**3 / 12,
            nodeNumbers=[nodes[a] for a in quad], useReducedOrderIntegration=job["reduced"])))
    ground = system.AddNode(item.NodePointGround(referenceCoordinates=[0, 0, 0]))
    fixed = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))

    def hold(node, coordinates):
        for c in coordinates:
            marker = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[node], coordinate=c))
            system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[fixed, marker]))
        return len(coordinates)

    held = 0
    if problem == "cylinder":
        for j in range(n + 1):
            # The first slope points along z at this edge; its length stays free.
            held += hold(j, (0, 1, 2, 3, 4, 6, 7, 8))
        corner = system.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[-1]))
        system.AddLoad(item.LoadForceVector(markerNumber=corner, loadVector=[0, 0, -problems.CYLINDER["force"]]))
    else:
        held += hold(0, (0, 1, 2))
        for plate in plates:
            body = system.AddMarker(item.MarkerBodyMass(bodyNumber=plate))
            system.AddLoad(item.LoadMassProportional(markerNumber=body,
                                                     loadVector=[0, 0, -problems.PENDULUM["gravity"]]))
    return system, nodes, 9 * len(nodes) - held


def main():
    job, folder = problems.read_job(sys.argv[1])
    import exudyn as exu

    global CONTAINER
    CONTAINER = exu.SystemContainer()
    problem, n = job["problem"], job["elements"]
    system, nodes, unknowns = model(job)
    node = lambda name: nodes[problems.node_of(problems.POINTS[problem][name], n)]
    names = problems.POINTS[problem]
    displacement = lambda k: [float(x) for x in system.GetNodeOutput(k, exu.OutputVariableType.Displacement)]
    motion = lambda: {p: displacement(node(p)) for p in names}
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = job.get("threads", 1)
    history = []
    if problem == "cylinder":
        solver = settings.staticSolver
        solver.numberOfLoadSteps = job["steps"]
        solver.newton.maxIterations = 60
        run = exu.MainSolverStatic()
    else:
        solver = settings.timeIntegration
        solver.endTime = problems.PENDULUM["end"]
        solver.numberOfSteps = round(problems.PENDULUM["end"] / job["dt"])
        solver.generalizedAlpha.spectralRadius = job["radius"]
        solver.generalizedAlpha.useNewmark = job.get("trapezoidal", False)
        solver.adaptiveStep = False
        run = exu.MainSolverImplicitSecondOrder()
        every = problems.PENDULUM["every"]

        def record(_system, time):
            # Called after every step, and once before the first.
            if abs(time - len(history) * every) < 0.1 * job["dt"]:
                history.append(motion())
            return True

    solver.newton.useModifiedNewton = job["modified"]
    solver.newton.numericalDifferentiation.forODE2 = job["numeric"]
    solver.newton.relativeTolerance = job["tolerance"]
    system.Assemble()
    if problem == "pendulum":
        history.append(motion())
        system.SetPostStepUserFunction(record)
    if not run.SolveSystem(system, settings):
        sys.exit("Newton's method does not converge after step %d" % (run.it.currentStepIndex - 1))
    problems.write_field(folder, (displacement(k) for k in nodes))
    problems.write_result(folder, version=exu.__version__, steps=run.it.currentStepIndex - 1,
                          iterations=run.it.newtonStepsCount, unknowns=unknowns,
                          jacobians=run.it.newtonJacobiCount, points=motion(), history=history)


if __name__ == "__main__":
    main()
