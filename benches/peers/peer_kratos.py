"""Kratos Multiphysics (BSD licence, PyPI `KratosMultiphysics` and applications): corotational shells.

A job may give `element` (name in Kratos), `solver` (linear solver), `steps` (load steps), `tolerance`, `modified` (one
tangent a step: modified Newton), `line_search`, `criterion` (`displacement` or `residual`),
`dt` and `alpha` (time step and Bossak parameter; 0 is the trapezoidal rule of Newmark).

Strategy and scheme are driven from Python as Kratos' own solvers do it. The displacement criterion ends
an iteration when the last increment is below `tolerance` times the increment of the step.
"""

import sys

import problems

NAME = "Kratos"
PACKAGES = ["KratosMultiphysics", "KratosStructuralMechanicsApplication", "KratosLinearSolversApplication",
            "KratosConstitutiveLawsApplication", "numpy"]


def command(python, job_file):
    return [python, __file__, job_file]


def model(job):
    """A model part with nodes, elements, material, supports and the degrees of freedom of a shell."""
    import KratosMultiphysics as KM
    import KratosMultiphysics.ConstitutiveLawsApplication
    import KratosMultiphysics.StructuralMechanicsApplication as SM

    problem, n = job["problem"], job["elements"]
    part = MODEL.CreateModelPart("shell", 2)
    part.ProcessInfo[KM.DOMAIN_SIZE] = 3
    variables = [KM.DISPLACEMENT, KM.ROTATION, KM.REACTION, KM.REACTION_MOMENT, SM.POINT_LOAD, KM.VOLUME_ACCELERATION]
    if problem == "pendulum":
        variables += [KM.VELOCITY, KM.ACCELERATION, KM.ANGULAR_VELOCITY, KM.ANGULAR_ACCELERATION]
    for variable in variables:
        part.AddNodalSolutionStepVariable(variable)
    properties = part.CreateNewProperties(1)
    properties[KM.YOUNG_MODULUS], properties[KM.POISSON_RATIO] = problems.YOUNG[problem], problems.POISSON
    properties[KM.THICKNESS] = problems.THICKNESS
    properties[KM.DENSITY] = problems.density(problem, n)
    law = "ReissnerMindlinShellElasticConstitutiveLaw" if job["element"].startswith("MITC") \
        else "LinearElasticPlaneStress2DLaw"
    properties.SetValue(KM.CONSTITUTIVE_LAW, KM.KratosGlobals.GetConstitutiveLaw(law).Clone())
    for k, (x, _, _) in enumerate(problems.nodes(problem, n)):
        part.CreateNewNode(k + 1, *x)
    for k, quad in enumerate(problems.quads(n)):
        part.CreateNewElement(job["element"], k + 1, [a + 1 for a in quad], properties)
    for axis in "XYZ":
        for name, reaction in ("DISPLACEMENT_", "REACTION_"), ("ROTATION_", "REACTION_MOMENT_"):
            KM.VariableUtils().AddDof(getattr(KM, name + axis), getattr(KM, reaction + axis), part)
            if problem in problems.STATIC:
                for k in problems.clamped(n):
                    part.Nodes[k + 1].Fix(getattr(KM, name + axis))
        if problem == "pendulum":
            part.Nodes[1].Fix(getattr(KM, "DISPLACEMENT_" + axis))
    return part, properties


def strategy(job, part, scheme):
    import KratosMultiphysics as KM
    import KratosMultiphysics.LinearSolversApplication
    from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

    linear = ConstructSolver(KM.Parameters('{"solver_type": "%s"}' % job["solver"]))
    builder = KM.ResidualBasedBlockBuilderAndSolver(linear)
    if job.get("criterion") == "residual":
        criterion = KM.ResidualCriteria(job["tolerance"], 1e-14)
    else:
        criterion = KM.DisplacementCriteria(job["tolerance"], 1e-14)
    criterion.SetEchoLevel(0)
    kind = KM.LineSearchStrategy if job.get("line_search") else KM.ResidualBasedNewtonRaphsonStrategy
    newton = kind(part, scheme, criterion, builder, job.get("iterations", 60), False, False, True)
    newton.SetEchoLevel(0)
    newton.Initialize()
    if job.get("modified"):
        newton.SetKeepSystemConstantDuringIterations(True)
    return newton, builder


def step(newton, part):
    """Solves one step; returns the number of iterations."""
    import KratosMultiphysics as KM

    newton.InitializeSolutionStep()
    newton.Predict()
    if not newton.SolveSolutionStep():
        sys.exit("Newton's method does not converge in a step that ends at %g" % part.ProcessInfo[KM.TIME])
    newton.FinalizeSolutionStep()
    return part.ProcessInfo[KM.NL_ITERATION_NUMBER]


def main():
    job, folder = problems.read_job(sys.argv[1])
    import KratosMultiphysics as KM
    import KratosMultiphysics.StructuralMechanicsApplication as SM

    global MODEL
    MODEL = KM.Model()
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    problem, n = job["problem"], job["elements"]
    part, properties = model(job)
    displacements = lambda: [list(node.GetSolutionStepValue(KM.DISPLACEMENT)) for node in part.Nodes]
    iterations, steps = 0, 0
    if problem in problems.STATIC:
        loaded = problems.edge(n) if problem == "cylinder" else range((n + 1) ** 2)
        forces = problems.edge_forces(n) if problem == "cylinder" else [problems.GRAVITY] * (n + 1) ** 2
        variable = SM.POINT_LOAD if problem == "cylinder" else KM.VOLUME_ACCELERATION
        if problem == "cylinder":
            for k, a in enumerate(loaded):
                part.CreateNewCondition("PointLoadCondition3D1N", k + 1, [a + 1], properties)
        newton, builder = strategy(job, part, KM.ResidualBasedIncrementalUpdateStaticScheme())
        for steps in range(1, job["steps"] + 1):
            factor = steps / job["steps"]
            part.CloneTimeStep(factor)
            for a, force in zip(loaded, forces):
                part.Nodes[a + 1].SetSolutionStepValue(variable, KM.Array3([0, 0, -factor * force]))
            iterations += step(newton, part)
        problems.write_rows(folder, displacements())
    else:
        weight = KM.Array3([0, 0, -problems.GRAVITY])
        for every in part.Nodes:
            for back in (0, 1):
                every.SetSolutionStepValue(KM.VOLUME_ACCELERATION, back, weight)
                # The scheme starts from rest only if it knows that the shell begins to fall at once.
                if every.Id != 1:
                    every.SetSolutionStepValue(KM.ACCELERATION, back, weight)
        newton, builder = strategy(job, part, KM.ResidualBasedBossakDisplacementScheme(job["alpha"]))
        per_sample = round(problems.EVERY / job["dt"])
        motion = displacements()
        for _ in problems.samples()[1:]:
            for _ in range(per_sample):
                steps += 1
                part.CloneTimeStep(steps * problems.EVERY / per_sample)
                iterations += step(newton, part)
            motion += displacements()
        problems.write_rows(folder, motion)
    fixed = 6 * (n + 1) if problem in problems.STATIC else 3
    problems.write_statistics(folder, version=KM.KratosGlobals.Kernel.Version(), steps=steps, iterations=iterations,
                              unknowns=builder.GetEquationSystemSize() - fixed)


def finish(job, folder):
    return problems.read_results(job, folder)


if __name__ == "__main__":
    main()
