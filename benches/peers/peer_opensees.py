"""OpenSees (own licence, free for research; PyPI `openseespy`): ASDShellQ4 with corotational frames, and ShellNLDKGQ.

A job may give `element`, `system` (linear solver), `steps` (load steps), `tolerance` (norm of the
increment of displacements). Needs the system libraries liblapack3 and libblas3.
"""

import sys

import problems

NAME = "OpenSees"
PACKAGES = ["openseespy"]


def command(python, job_file):
    return [python, __file__, job_file]


def main():
    job, folder = problems.read_job(sys.argv[1])
    import openseespy.opensees as ops

    n, options = job["elements"], job["element"].split()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.section("ElasticMembranePlateSection", 1, problems.CYLINDER["young"], problems.POISSON, problems.THICKNESS, 0.0)
    for k, (x, _) in enumerate(problems.nodes("cylinder", n)):
        ops.node(k + 1, *x)
    for k, quad in enumerate(problems.quads(n)):
        ops.element(options[0], k + 1, *(a + 1 for a in quad), 1, *options[1:])
    for j in range(n + 1):
        ops.fix(j + 1, 1, 1, 1, 1, 1, 1)
    names = problems.POINTS["cylinder"]
    tag = lambda name: problems.node_of(names[name], n) + 1
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(tag("corner"), 0.0, 0.0, -problems.CYLINDER["force"], 0.0, 0.0, 0.0)
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
    problems.write_field(folder, (ops.nodeDisp(k + 1)[:3] for k in range((n + 1) ** 2)))
    problems.write_result(folder, version=ops.version(), steps=job["steps"], iterations=iterations,
                          unknowns=6 * n * (n + 1), points={p: ops.nodeDisp(tag(p))[:3] for p in names})


if __name__ == "__main__":
    main()
