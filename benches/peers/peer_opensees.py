"""OpenSees (own licence, free for research; PyPI `openseespy`): ASDShellQ4 with corotational frames, static problems only.

A job may give `element`, `system` (linear solver), `steps` (load steps), `tolerance` (norm of the
increment of displacements). Needs the system libraries liblapack3 and libblas3.
"""

import sys

import problems

NAME = "OpenSees"
PACKAGES = ["openseespy", "numpy"]


def command(python, job_file):
    return [python, __file__, job_file]


def main():
    job, folder = problems.read_job(sys.argv[1])
    import openseespy.opensees as ops

    problem, n, options = job["problem"], job["elements"], job["element"].split()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.section("ElasticMembranePlateSection", 1, problems.YOUNG[problem], problems.POISSON, problems.THICKNESS, 0.0)
    for k, (x, _, _) in enumerate(problems.nodes(problem, n)):
        ops.node(k + 1, *x)
    for k, quad in enumerate(problems.quads(n)):
        ops.element(options[0], k + 1, *(a + 1 for a in quad), 1, *options[1:])
    for k in problems.clamped(n):
        ops.fix(k + 1, 1, 1, 1, 1, 1, 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    loads = zip(problems.edge(n), problems.edge_forces(n)) if problem == "cylinder" \
        else enumerate(problems.weights(problem, n))
    for k, force in loads:
        ops.load(k + 1, 0.0, 0.0, -float(force), 0.0, 0.0, 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM" if job["system"].startswith(("Band", "Profile")) else "Plain")
    ops.system(job["system"])
    ops.test("NormDispIncr", job["tolerance"], 60, 0)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / job["steps"])
    ops.analysis("Static")
    iterations = 0
    for k in range(job["steps"]):
        failed = ops.analyze(1) != 0
        iterations += ops.testIter()
        if failed:
            sys.exit("Newton's method does not converge in load step %d of %d" % (k + 1, job["steps"]))
    problems.write_rows(folder, (ops.nodeDisp(k + 1)[:3] for k in range((n + 1) ** 2)))
    problems.write_statistics(folder, version=ops.version(), steps=job["steps"], iterations=iterations,
                              unknowns=6 * n * (n + 1))


def finish(job, folder):
    return problems.read_results(job, folder)


if __name__ == "__main__":
    main()
