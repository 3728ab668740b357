"""EXUDYN's models of the machines: planar cables and beams, minimal coordinates, thin plates.

A job gives `model`: `cable` (`ObjectANCFCable2D`), `beam` (`ObjectBeamGeometricallyExact2D` with two nodes, `beam3` with
three), `plate` (`ObjectANCFThinPlate`), `tree` (`ObjectKinematicTree`: minimal coordinates), `planar` (redundant coordinates of rigid
bodies in the plane), and `elements`; `dt`, `scheme` (`alpha` with `radius`, or `trapezoidal` with velocity constraints), `modified`
(Newton), `numeric` (tangents by finite differences), `tolerance`, `dense`, `reduced` (integration); or `explicit` (name of an explicit
solver), with `relative` (tolerance) where steps are automatic.

What needs Python while it runs is kept small: samples are recorded by sensors in compiled code, prescribed angles are set once a step.
"""

import json
import math
import sys
import time

import machines
import problems

NAME = "EXUDYN"
PACKAGES = ["exudyn", "numpy"]


def command(python, job_file):
    return [python, "-W", "ignore", __file__, job_file]


class Model:
    """A system with what the models share."""

    def __init__(self, job, exu, item):
        self.job, self.exu, self.item = job, exu, item
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.driven = []
        self.ground = self.system.AddNode(item.NodePointGround(referenceCoordinates=[0, 0, 0]))
        self.fixed = self.system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=self.ground, coordinate=0))

    def hold(self, node, coordinate, motion=None):
        """Holds a displacement of a node, or prescribes it as a function of time."""
        at = self.system.AddMarker(self.item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        joint = self.system.AddObject(self.item.ObjectConnectorCoordinate(markerNumbers=[self.fixed, at]))
        if motion:
            self.driven.append((joint, motion))

    def rod(self, section, start, length, velocity):
        """Nodes of a straight rod along x; `velocity` gives that of a point and the angular velocity."""
        n, job, item = self.job["elements"], self.job, self.item
        intervals = 2 * n if job["model"] == "beam3" else n
        nodes = []
        for k in range(intervals + 1):
            x = start + length * k / intervals
            vx, vy, spin = velocity(x)
            if job["model"] == "cable":
                nodes.append(self.system.AddNode(item.NodePoint2DSlope1(
                    referenceCoordinates=[x, 0, 1, 0], initialVelocities=[vx, vy, 0, spin])))
            else:
                nodes.append(self.system.AddNode(item.NodeRigidBody2D(
                    referenceCoordinates=[x, 0, 0], initialVelocities=[vx, vy, spin])))
        thin = 1e3 if job.get("thin") else 1.0
        common = dict(length=length / n, massPerLength=section["mass"], bendingStiffness=section["bending"],
                      axialStiffness=section["axial"])
        for k in range(n):
            if job["model"] == "cable":
                self.system.AddObject(item.ObjectANCFCable2D(
                    **common, nodeNumbers=nodes[k:k + 2], useReducedOrderIntegration=job.get("reduced", 0)))
            else:
                step = intervals // n
                self.system.AddObject(item.ObjectBeamGeometricallyExact2D(
                    **common, nodeNumbers=nodes[k * step:(k + 1) * step + 1], shearStiffness=section["shear"] * thin,
                    crossSectionInertia=section["inertia"] / thin))
        return nodes

    def turn(self, node, angle):
        """Prescribes the direction of a rod at a node."""
        if self.job["model"] == "cable":
            self.hold(node, 2, lambda t: math.cos(angle(t)) - 1)
            self.hold(node, 3, lambda t: math.sin(angle(t)))
        else:
            self.hold(node, 2, angle)

    def plate(self, origin, axes, size, thickness, young, poisson, density, grid):
        """Nodes of a flat plate, row by row of its first side."""
        import numpy as np

        item, (nu, nv) = self.item, grid
        stiffness = young / (1 - poisson**2) * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
        u, v = (np.array(axis, float) for axis in axes)
        nodes = [[self.system.AddNode(item.NodePointSlope12(referenceCoordinates=[
            *(np.array(origin) + u * size[0] * i / nu + v * size[1] * j / nv), *u, *v])) for j in range(nv + 1)] for i in range(nu + 1)]
        for i in range(nu):
            for j in range(nv):
                self.system.AddObject(item.ObjectANCFThinPlate(
                    thickness=thickness, density=density, strainCoefficients=stiffness * thickness,
                    curvatureCoefficients=stiffness * thickness**3 / 12, slopesScalingX=[size[0] / nu] * 4, slopesScalingY=[size[1] / nv] * 4,
                    nodeNumbers=[nodes[i][j], nodes[i + 1][j], nodes[i + 1][j + 1], nodes[i][j + 1]],
                    useReducedOrderIntegration=self.job["reduced"]))
        return nodes

    def record(self, nodes, kind="Position"):
        """Sensors, whose samples stay in memory."""
        return [self.system.AddSensor(self.item.SensorNode(
            nodeNumber=node, outputVariableType=getattr(self.exu.OutputVariableType, kind), storeInternal=True)) for node in nodes]


def spin_up(model):
    data = machines.SPIN_UP
    if model.job["model"] == "plate":
        n = model.job["elements"]
        thickness, width = data["thickness"], data["width"]
        nodes = model.plate([0, 0, -width / 2], ([1, 0, 0], [0, 0, 1]), [data["length"], width], thickness, data["young"], 0.0,
                            data["density"], (n, 1))
        for node in nodes[0]:
            for c in range(9):
                model.hold(node, c, {3: lambda t: math.cos(machines.spin(t)) - 1, 4: lambda t: math.sin(machines.spin(t))}.get(c))
        return model.record([nodes[-1][0]])
    nodes = model.rod(data, 0.0, data["length"], lambda x: (0, 0, 0))
    model.hold(nodes[0], 0)
    model.hold(nodes[0], 1)
    model.turn(nodes[0], machines.spin)
    return model.record([nodes[-1]])


def slider_crank(model):
    data = machines.SLIDER_CRANK
    crank, length, rate = data["crank"], data["length"], data["rate"]
    spin = -rate * crank / length
    along = lambda x: rate * crank * (1 - (x - crank) / length)
    pin = (lambda t: crank * (math.cos(rate * t) - 1), lambda t: crank * math.sin(rate * t))
    n = model.job["elements"]
    if model.job["model"] == "plate":
        nodes = model.plate([crank, 0, -data["width"] / 2], ([1, 0, 0], [0, 0, 1]), [length, data["width"]], data["thickness"],
                            data["young"], 0.0, data["density"], (n, 1))
        for i, row in enumerate(nodes):
            for node in row:
                x = crank + length * i / n
                model.system.SetNodeParameter(node, "initialVelocities", [0, along(x), 0, 0, spin, 0, 0, 0, 0])
        for node in nodes[0]:
            for c in (0, 1, 2):
                model.hold(node, c, pin[c] if c < 2 else None)
        for node in nodes[-1]:
            model.hold(node, 1)
            model.system.AddObject(model.item.ObjectMassPoint(mass=data["slider"] / 2, nodeNumber=node))
        return model.record([nodes[0][0], nodes[n // 2][0], nodes[-1][0]])
    nodes = model.rod(data, crank, length, lambda x: (0, along(x), spin))
    if model.job.get("crank"):
        item, system = model.item, model.system
        node = system.AddNode(item.NodeRigidBody2D(referenceCoordinates=[0, 0, 0], initialVelocities=[0, 0, rate]))
        body = system.AddObject(item.ObjectRigidBody2D(mass=0.1, inertia=1e-4, nodeNumber=node))
        for c in (0, 1, 2):
            model.hold(node, c, (lambda t: rate * t) if c == 2 else None)
        here = system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[crank, 0, 0]))
        system.AddObject(item.ObjectJointRevolute2D(markerNumbers=[here, system.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[0]))]))
    else:
        model.hold(nodes[0], 0, pin[0])
        model.hold(nodes[0], 1, pin[1])
    model.hold(nodes[-1], 1)
    model.system.AddObject(model.item.ObjectMassPoint2D(mass=data["slider"], nodeNumber=nodes[-1]))
    return model.record([nodes[0], nodes[len(nodes) // 2], nodes[-1]])


def chain(model):
    import numpy as np

    data, item, exu = machines.CHAIN, model.item, model.exu
    n, length, mass = data["links"], data["length"], data["mass"]
    inertia = machines.link_inertia()
    if model.job["model"] == "tree":
        node = model.system.AddNode(item.NodeGenericODE2(numberOfODE2Coordinates=n, referenceCoordinates=[0] * n, initialCoordinates=[0] * n,
                                                         initialCoordinates_t=[0] * n))
        model.system.AddObject(item.ObjectKinematicTree(
            nodeNumber=node, jointTypes=[exu.JointType.RevoluteZ] * n, linkParents=list(range(-1, n - 1)),
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList([[0, 0, 0]] + [[length, 0, 0]] * (n - 1)),
            linkInertiasCOM=exu.Matrix3DList([np.diag(inertia)] * n), linkCOMs=exu.Vector3DList([[length / 2, 0, 0]] * n),
            linkMasses=[mass] * n, gravity=[0, -machines.GRAVITY, 0]))
        return model.record([node], "Coordinates")
    nodes, last = [], model.system.AddMarker(item.MarkerNodePosition(nodeNumber=model.ground))
    for k in range(n):
        node = model.system.AddNode(item.NodeRigidBody2D(referenceCoordinates=[(k + 0.5) * length, 0, 0]))
        body = model.system.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia[2], nodeNumber=node))
        here = lambda x: model.system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))
        model.system.AddObject(item.ObjectJointRevolute2D(markerNumbers=[last, here(-length / 2)]))
        model.system.AddLoad(item.LoadForceVector(markerNumber=here(0), loadVector=[0, -mass * machines.GRAVITY, 0]))
        last = here(length / 2)
        nodes.append(node)
    return model.record(nodes)


def plate(model):
    import peer_exudyn

    data, n = machines.PLATE, model.job["elements"]
    nodes = model.plate([0, 0, 0], ([1, 0, 0], [0, 1, 0]), [data["side"]] * 2, data["thickness"], data["young"], data["poisson"],
                        data["density"], (n, n))
    for node in (nodes[0][0], nodes[0][-1]):
        for c in (0, 1, 2):
            model.hold(node, c)
    # Consistent weights on positions and slopes, as in the comparison of shells.
    import numpy as np

    h, (points, weights) = data["side"] / n, np.polynomial.legendre.leggauss(4)
    shares = sum(a * b * np.array(peer_exudyn.plate_shapes(r, s)) for r, a in zip(points, weights) for s, b in zip(points, weights))
    pressure = data["density"] * data["thickness"] * machines.GRAVITY
    total = {}
    for i in range(n):
        for j in range(n):
            for a, node in enumerate((nodes[i][j], nodes[i + 1][j], nodes[i + 1][j + 1], nodes[i][j + 1])):
                for c in range(3):
                    share = shares[3 * a + c] * (h / 2) ** 2 * (h / 2 if c else 1.0)
                    total[node, 3 * c + 2] = total.get((node, 3 * c + 2), 0.0) - pressure * share
    for (node, c), load in total.items():
        if abs(load) > 1e-14:
            at = model.system.AddMarker(model.item.MarkerNodeCoordinate(nodeNumber=node, coordinate=c))
            model.system.AddLoad(model.item.LoadCoordinate(markerNumber=at, load=float(load)))
    return model.record([nodes[n][0], nodes[n][n // 2], nodes[0][n // 2]])


def settings_of(model):
    exu, job = model.exu, model.job
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.0 if "relative" in job else machines.EVERY[job["problem"]]
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense if job.get("dense") else exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    run = settings.timeIntegration
    run.endTime = machines.END[job["problem"]]
    run.verboseMode = 0
    run.numberOfSteps = round(run.endTime / job["dt"])
    run.adaptiveStep = False
    if "explicit" in job:
        run.automaticStepSize = "relative" in job
        if run.automaticStepSize:
            run.relativeTolerance, run.absoluteTolerance = job["relative"], job["relative"]
        return settings, getattr(exu.DynamicSolverType, job["explicit"])
    run.newton.useModifiedNewton = job.get("modified", True)
    run.newton.numericalDifferentiation.forODE2 = job.get("numeric", False)
    run.newton.relativeTolerance, run.newton.absoluteTolerance = job["tolerance"], job.get("absolute", 1e-10)
    run.generalizedAlpha.spectralRadius = job.get("radius", 0.9)
    run.generalizedAlpha.computeInitialAccelerations = job.get("start", True)
    trapezoidal = job.get("scheme") == "trapezoidal"
    return settings, exu.DynamicSolverType.TrapezoidalIndex2 if trapezoidal else exu.DynamicSolverType.GeneralizedAlpha


def main():
    job, folder = problems.read_job(sys.argv[1])
    if job.get("fast", True):
        # The library without range checks.
        sys.exudynFast = True
    import exudyn as exu
    import exudyn.itemInterface as item

    model = Model(job, exu, item)
    sensors = {"spin-up": spin_up, "slider-crank": slider_crank, "chain": chain, "plate": plate}[job["problem"]](model)
    system = model.system
    if model.driven:
        def drive(_system, t):
            for joint, motion in model.driven:
                system.SetObjectParameter(joint, "offset", motion(t))
            return True

        system.SetPreStepUserFunction(drive)
    system.Assemble()
    settings, solver = settings_of(model)
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        exu.SolveDynamic(system, settings, solverType=solver)
    except exu.SolverError:
        sys.exit("Newton's method does not converge")
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    rows = [[x for sensor in samples for x in sensor]
            for samples in zip(*([list(map(float, row)) for row in system.GetSensorStoredData(s)] for s in sensors))]
    problems.write_rows(folder, rows)
    it = system.sys["dynamicSolver"].it
    problems.write_statistics(folder, version=exu.__version__, steps=it.currentStepIndex - 1, iterations=it.newtonStepsCount,
                                       jacobians=it.newtonJacobiCount, solve=cpu, solve_wall=wall)


def finish(job, folder):
    """Samples in the common form: position after position, of every sample."""
    found = json.loads((folder / "statistics.json").read_text())
    rows = problems.read_rows(folder)
    if job["model"] == "tree":
        places = [[t for t in row[1:]] for row in rows]
        found["motion"] = [machines.chain_places(angles, relative=True) for angles in places]
    else:
        # A sensor's row is the time and three numbers.
        found["motion"] = [[row[k:k + 4][1:] for k in range(0, len(row), 4)] for row in rows]
    times = [row[0] for row in rows]
    found["motion"] = [machines.interpolate(times, found["motion"], t) for t in machines.samples(job["problem"])]
    found["compared"] = machines.compared(job["problem"], found.pop("motion"))
    return found


if __name__ == "__main__":
    main()
