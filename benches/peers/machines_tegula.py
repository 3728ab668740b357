"""tegula's models of the machines: beams, strips of shell on rigid patches, rigid bodies, a plate.

A job gives `model` (`beam`, `shell`; of the chain the type of its joints), `elements`, `analysis` (keys of the model file), and
optionally `section` and `across` (elements across a strip).
"""

import csv
import json

import machines
import peer_tegula
import problems
from peer_tegula import toml

NAME = "tegula"
PACKAGES = []


def command(_python, job_file):
    job, folder = problems.read_job(job_file)
    (folder / "case.toml").write_text(model(job))
    return [str(peer_tegula.PROGRAM.resolve()), "run", "case.toml", "--out", "out", "--threads", "1", "--quiet"]


def entry(table, **keys):
    return ["[%s]" % table, *("%s = %s" % (key, toml(value)) for key, value in keys.items())]


def body(name, at, mass, inertia, **keys):
    return entry("[bodies]", name=name, at=at, mass=mass, inertia=inertia, **keys)


def joint(kind, name, sides, at, **keys):
    return entry("[joints]", type=kind, name=name, between=sides, at=at, **keys)


def strip(job, data, start, poisson=0.0):
    """A strip of shell along x, across z."""
    return [*entry("mesh", type="plate", origin=[start, 0.0, -data["width"] / 2], size=[data["length"], data["width"]],
                   u_axis=[1, 0, 0], v_axis=[0, 0, 1]),
            *entry("mesh.grid", elements=[job["elements"], job.get("across", 1)]),
            *entry("materials.sheet", type="isotropic", young=data["young"], poisson=poisson, density=data["density"]),
            *entry("[sections]", material="sheet", thickness=data["thickness"], **job.get("section", {}))]


def beam(job, data, start, **keys):
    thin = 1e3 if job.get("thin") else 1.0
    constants = dict(type="constants", axial=data["axial"], shear=[data["shear"] * thin] * 2, bending=[data["bending"]] * 2,
                     torsion=data["bending"], mass=data["mass"], inertia=[data["inertia"] / thin] * 2)
    return entry("[beams]", name="rod", points=[[start, 0, 0], [start + data["length"], 0, 0]], elements=job["elements"],
                 direction=[0, 0, 1], section=constants, **keys)


def drive(first, second, expression):
    return [*entry("[joints]", type="driven-angle", name="drive", between=[first, second], axis=[0, 0, 1], angle=57.29577951308232,
                   amplitude="angle"), *entry("amplitudes.angle", type="expression", expression=expression)]


ORIGIN = [0.0, 0.0, 0.0]
Z = [0, 0, 1]


def spin_up(job):
    data, root = machines.SPIN_UP, "rod.start"
    if job["model"] == "shell":
        lines = [*strip(job, data, 0.0), *entry("[bodies]", name="hub", at=ORIGIN, attached=["u_min"])]
        root = "hub"
    else:
        lines = beam(job, data, 0.0)
    return [*lines, *joint("revolute", "hinge", ["ground", root], ORIGIN, axis=Z),
            *drive("ground", root, "4/15*(t^2/2 + (15/(2*PI))^2*(cos(2*PI*t/15) - 1))")]


def slider_crank(job):
    data = machines.SLIDER_CRANK
    crank, length, rate = data["crank"], data["length"], data["rate"]
    pin, slider = [crank, 0.0, 0.0], [crank + length, 0.0, 0.0]
    start = dict(velocity=[0, rate * crank, 0], angular_velocity=[0, 0, -rate * crank / length])
    first, last, lines = "rod.start", "rod.end", []
    if job["model"] == "shell":
        first, last = "big end", "small end"
        lines += [*strip(job, data, crank), *entry("[initial_velocities]", center=pin, **start),
                  *entry("[bodies]", name=first, at=pin, attached=["u_min"], **start),
                  *entry("[bodies]", name=last, at=slider, attached=["u_max"], angular_velocity=start["angular_velocity"])]
    else:
        lines += beam(job, data, crank, history=[0, job["elements"] // 2, job["elements"]], **start)
    lines += body("crank", [crank / 2, 0, 0], 0.1, [1e-5, 1e-4, 1e-4], velocity=[0, rate * crank / 2, 0], angular_velocity=[0, 0, rate])
    lines += body("slider", slider, data["slider"], [1e-5] * 3)
    lines += joint("revolute", "bearing", ["ground", "crank"], ORIGIN, axis=Z) + drive("ground", "crank", "%g*t" % rate)
    lines += joint("revolute", "pin", ["crank", first], pin, axis=Z) + joint("spherical", "wrist", [last, "slider"], slider)
    return lines + joint("prismatic", "guide", ["ground", "slider"], slider, axis=[1, 0, 0])


def chain(job):
    data, lines, last = machines.CHAIN, [], "ground"
    length = data["length"]
    for k in range(data["links"]):
        name = "link%d" % (k + 1)
        lines += body(name, [(k + 0.5) * length, 0, 0], data["mass"], machines.link_inertia())
        lines += joint(job["model"], "joint%d" % (k + 1), [last, name], [k * length, 0, 0],
                       **({"axis": Z} if job["model"] == "revolute" else {}))
        last = name
    return lines + entry("[loads]", type="gravity", value=[0, -machines.GRAVITY, 0])


def plate(job):
    data, n = machines.PLATE, job["elements"]
    lines = [*entry("mesh", type="plate", size=[data["side"]] * 2), *entry("mesh.grid", elements=[n, n]),
             *entry("materials.sheet", type="isotropic", young=data["young"], poisson=data["poisson"], density=data["density"]),
             *entry("[sections]", material="sheet", thickness=data["thickness"], **job.get("section", {}))]
    for name in "u_min_v_min", "u_min_v_max":
        lines += entry("[conditions]", type="spherical", on=name)
    return lines + entry("[loads]", type="gravity", value=[0, 0, -machines.GRAVITY])


def points(job):
    """Points of a shell that are recorded, by name, in the order in which they are compared."""
    problem, side = job["problem"], machines.PLATE["side"]
    if problem == "plate":
        return {"corner": [side, 0, 0], "free": [side, side / 2, 0], "held": [0, side / 2, 0]}
    if job["model"] != "shell":
        return {}
    if problem == "spin-up":
        return {"tip": [machines.SPIN_UP["length"], 0, -machines.SPIN_UP["width"] / 2]}
    data = machines.SLIDER_CRANK
    return {name: [data["crank"] + x * data["length"], 0, -data["width"] / 2] for name, x in (("pin", 0.0), ("middle", 0.5), ("wrist", 1.0))}


def model(job):
    problem = job["problem"]
    lines = entry("analysis", type="transient", end_time=machines.END[problem], **job["analysis"])
    lines += entry("output", pictures=False, fields=["displacement"], interval=machines.END[problem],
                   points=[{"name": name, "at": at} for name, at in points(job).items()])
    build = {"spin-up": spin_up, "slider-crank": slider_crank, "chain": chain, "plate": plate}[problem]
    return "\n".join(lines + build(job)) + "\n"


def recorded(job):
    """First parts of the columns of the compared places."""
    if points(job):
        return list(points(job))
    n = job["elements"] if job["problem"] != "chain" else 0
    return {"spin-up": ["body.rod.end"], "slider-crank": ["body.rod.start", "body.rod.%d" % (n // 2), "body.rod.end"],
            "chain": ["body.link%d" % (k + 1) for k in range(machines.CHAIN["links"])]}[job["problem"]]


def finish(job, folder):
    summary = json.loads((folder / "out/summary.json").read_text())
    found = {key: summary[key] for key in ("version", "steps", "iterations", "unknowns")}
    found.update(jacobians=summary["factorizations"], solve=summary["cpu_s"], solve_wall=summary["wall_s"])
    with open(folder / "out/history.csv") as file:
        rows = csv.reader(file)
        header = next(rows)
        columns = [header.index(name + "." + c) for name in recorded(job) for c in "xyz"]
        table = [(float(row[header.index("time")]), [float(row[k]) for k in columns]) for row in rows]
    times = [t for t, _ in table]
    motion = [[row[k:k + 3] for k in range(0, len(row), 3)] for _, row in table]
    motion = [machines.interpolate(times, motion, t) for t in machines.samples(job["problem"])]
    found["compared"] = machines.compared(job["problem"], motion)
    return found
