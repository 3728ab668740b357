"""Kratos Multiphysics: the path by a prescribed deflection of the middle, or by its strategy of Ramm's arc length.

A job gives `element`, `solver`, `steps` (equal steps of the deflection) and `tolerance` (of the increment of displacements relative to that of
the step), or `arc_length` (parameters of `ArcLengthStrategy`) with `steps`, the most steps, and `force`, that of the first one.
"""

import json
import sys

import paths_roof as roof
from problems import quads, read_job

NAME = "Kratos"


def command(python, job_file):
    return [python, __file__, job_file]


def main():
    job, folder = read_job(sys.argv[1])
    import KratosMultiphysics as KM
    import KratosMultiphysics.ConstitutiveLawsApplication
    import KratosMultiphysics.LinearSolversApplication
    import KratosMultiphysics.StructuralMechanicsApplication as SM
    from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    n = job["elements"]
    models = KM.Model()
    part = models.CreateModelPart("shell", 2)
    part.ProcessInfo[KM.DOMAIN_SIZE] = 3
    for variable in KM.DISPLACEMENT, KM.ROTATION, KM.REACTION, KM.REACTION_MOMENT, SM.POINT_LOAD, KM.VOLUME_ACCELERATION:
        part.AddNodalSolutionStepVariable(variable)
    properties = part.CreateNewProperties(1)
    properties[KM.YOUNG_MODULUS], properties[KM.POISSON_RATIO] = roof.YOUNG, roof.POISSON
    properties[KM.THICKNESS], properties[KM.DENSITY] = job["thickness"], 1.0
    law = "ReissnerMindlinShellElasticConstitutiveLaw" if job["element"].startswith("MITC") else "LinearElasticPlaneStress2DLaw"
    properties.SetValue(KM.CONSTITUTIVE_LAW, KM.KratosGlobals.GetConstitutiveLaw(law).Clone())
    for k, x in enumerate(roof.nodes(n)):
        part.CreateNewNode(k + 1, *x)
    for k, quad in enumerate(quads(n)):
        part.CreateNewElement(job["element"], k + 1, [a + 1 for a in quad], properties)
    for axis in "XYZ":
        KM.VariableUtils().AddDof(getattr(KM, "DISPLACEMENT_" + axis), getattr(KM, "REACTION_" + axis), part)
        KM.VariableUtils().AddDof(getattr(KM, "ROTATION_" + axis), getattr(KM, "REACTION_MOMENT_" + axis), part)
    for held, names in ((roof.crest(n), ("DISPLACEMENT_X", "ROTATION_Y", "ROTATION_Z")),
                        (roof.middle(n), ("DISPLACEMENT_Y", "ROTATION_X", "ROTATION_Z")),
                        (roof.hinge(n), ("DISPLACEMENT_X", "DISPLACEMENT_Y", "DISPLACEMENT_Z"))):
        for k in held:
            for name in names:
                part.Nodes[k + 1].Fix(getattr(KM, name))
    middle = part.Nodes[1]
    builder = KM.ResidualBasedBlockBuilderAndSolver(ConstructSolver(KM.Parameters('{"solver_type": "%s"}' % job["solver"])))
    criterion = KM.DisplacementCriteria(job["tolerance"], 1e-14)
    criterion.SetEchoLevel(0)
    scheme = KM.ResidualBasedIncrementalUpdateStaticScheme()
    path, iterations = [(0.0, 0.0)], 0
    arc = "arc_length" in job
    if arc:
        loaded = part.CreateSubModelPart("loaded")
        loaded.AddNodes([1])
        loaded.CreateNewCondition("PointLoadCondition3D1N", 1, [1], properties)
        middle.SetSolutionStepValue(SM.POINT_LOAD, KM.Array3([0.0, 0.0, -0.25 * job["force"]]))
        settings = {"desired_iterations": 4, "max_radius_factor": 20.0, "min_radius_factor": 0.5,
                    "loads_sub_model_part_list": ["loaded"], "loads_variable_list": ["POINT_LOAD"],
                    "max_iteration": 60, "compute_reactions": False, "reform_dofs_at_each_step": False, "move_mesh_flag": True,
                    **job["arc_length"]}
        strategy = KM.ArcLengthStrategy(part, scheme, criterion, builder, KM.Parameters(json.dumps(settings)))
    else:
        middle.Fix(KM.DISPLACEMENT_Z)
        strategy = KM.ResidualBasedNewtonRaphsonStrategy(part, scheme, criterion, builder, 60, True, False, True)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    for k in range(1, job["steps"] + 1):
        part.CloneTimeStep(k / job["steps"])
        if not arc:
            middle.SetSolutionStepValue(KM.DISPLACEMENT_Z, -roof.END * k / job["steps"])
        strategy.InitializeSolutionStep()
        strategy.Predict()
        converged = strategy.SolveSolutionStep()
        iterations += part.ProcessInfo[KM.NL_ITERATION_NUMBER]
        if not converged:
            roof.write_path(folder, path)
            sys.exit("does not converge behind a deflection of %.4g mm" % path[-1][0])
        strategy.FinalizeSolutionStep()
        force = middle.GetSolutionStepValue(SM.POINT_LOAD)[2] if arc else middle.GetSolutionStepValue(KM.REACTION)[2]
        path.append((-middle.GetSolutionStepValue(KM.DISPLACEMENT_Z), -4.0 * force))
        if path[-1][0] >= roof.END * (1 - 1e-9):
            break
    roof.write_path(folder, path, version=KM.KratosGlobals.Kernel.Version(), steps=len(path) - 1, factorisations=iterations,
                    unknowns=sum(1 for node in part.Nodes for name in ("DISPLACEMENT", "ROTATION") for axis in "XYZ"
                                 if not node.IsFixed(getattr(KM, name + "_" + axis))))


def finish(_job, folder):
    return roof.read_path(folder)


if __name__ == "__main__":
    main()
