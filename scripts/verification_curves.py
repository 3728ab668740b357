"""Figures of the verification manual that show a whole history or path: runs of the models of the cases, beside their reference points.

`tegula verify` judges these curves by one number each, their distance from the reference, so that its values do not contain them.
"""

import bisect
import csv
import math
import subprocess
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path

from line_plot import Series
from toml_text import model_text
from verification_figures import ROOT, Figures, plot, points, records, thin_sphere

MODELS = ROOT / "verification/models"
# Points of a curve in a figure.
SHOWN = 240

Columns = dict[str, list[float]]
Run = Callable[[dict], Columns]


def runner(program: str) -> Run:
    """Function that runs a model with a program and returns the columns of its history."""

    def run(model: dict) -> Columns:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "model.toml")
            # Field files are not needed.
            model["output"] = {"pictures": False, "every": 1_000_000, "points": model.get("output", {}).get("points", [])}
            path.write_text(model_text(model), encoding="utf-8")
            subprocess.run([program, "run", path, "--out", Path(folder, "out"), "--quiet"], check=True, timeout=600)
            with open(Path(folder, "out/history.csv"), encoding="utf-8") as file:
                heads, *rows = csv.reader(file)
        return {head: [float(row[k] or "nan") for row in rows] for k, head in enumerate(heads)}

    return run


def model_of(name: str, *watched: str) -> dict:
    """Model of the verification; the only nodes of the sets `watched` are recorded."""
    model = tomllib.loads((MODELS / f"{name}.toml").read_text())
    for name in watched:
        model.setdefault("output", {}).setdefault("points", []).append({"name": name, "on": name})
    return model


def between(x: list[float], y: list[float], at: float) -> float:
    """Value of a curve at a place, straight between its points."""
    k = min(max(bisect.bisect_left(x, at), 1), len(x) - 1)
    part = (at - x[k - 1]) / (x[k] - x[k - 1])
    return y[k - 1] + part * (y[k] - y[k - 1])


def history(name: str, columns: Columns, value: str | list[float], end: float = math.inf, **look: bool) -> Series:
    """History of a column at equal times, so that the figure does not depend on the time steps."""
    times = columns["time"]
    values = columns[value] if isinstance(value, str) else value
    end = min(end, times[-1])
    at = [end * k / SHOWN for k in range(SHOWN + 1)]
    return Series(name, at, [between(times, values, t) for t in at], markers=False, **look)


def path(name: str, x: list[float], y: list[float]) -> Series:
    """Path at points of equal distance in the figure."""
    across, up = max(map(abs, x)), max(map(abs, y))
    length = [0.0]
    for k in range(1, len(x)):
        length.append(length[-1] + math.hypot((x[k] - x[k - 1]) / across, (y[k] - y[k - 1]) / up))
    at = [length[-1] * k / SHOWN for k in range(SHOWN + 1)]
    return Series(name, [between(length, x, s) for s in at], [between(length, y, s) for s in at], markers=False)


def known(machine: str, quantity: Callable[[str], bool], scale: float = 1.0) -> list[tuple[float, float]]:
    """Reference points of a machine: time, value."""
    rows = [row for row in records("machines") if row["machine"] == machine and quantity(row["quantity"])]
    return [(float(row["time_s"]), scale * float(row["value"])) for row in rows]


def late_load(model: dict, step: float) -> dict:
    """Model with constant steps whose loads grow over the first one, as `tegula verify` compares it."""
    model["analysis"]["time_step"] = step
    model["amplitudes"] = {"late": {"type": "ramp", "end": step}}
    for load in model["loads"]:
        load["amplitude"] = "late"
    return model


def published_motion(run: Run, name: str, prefix: str, step: float, title: str) -> Figures:
    """Deflection of the free corner of a plate over time."""
    found = run(late_load(model_of(name, "u_max_v_min"), step))
    reference = [(float(r["time_s"]), float(r["value"])) for r in records("transients") if r["case"].startswith(prefix)]
    series = [history("ems", found, "u_max_v_min.uz"), points("Strand7 (Wilson)", reference, line=False)]
    return {name.replace("_", "-"): plot(title, "time [s]", "u_z of the free corner [m]", series)}


def hinged_plate(run: Run) -> Figures:
    """Plate that is released on a hinge."""
    return published_motion(run, "hinged_plate", "T5", 0.01, "Plate released on a hinge (T5)")


def oscillating_plate(run: Run) -> Figures:
    """Clamped plate under sudden pressure."""
    return published_motion(run, "oscillating_plate", "T6", 1.0, "Clamped plate under sudden pressure (T6)")


# Columns of the reference tables and names of the corners.
CORNERS = {
    "u_max_v_max": ("free_opposite", "opposite corner"),
    "u_max_v_min": ("free_arc_end_y0", "end of the arc"),
    "u_min_v_max": ("free_th0_y1", "end of the axis"),
}


def swing(run: Run, n: int, reference: str, end: float) -> Figures:
    """Heights of the corners of the quarter cylinder pendulum."""
    model = model_of("pendulum", *CORNERS)
    model["mesh"]["grid"]["elements"] = [n, n]
    model["analysis"].update(end_time=end, scheme={"type": "newmark"})
    found = run(model)
    series = [history(f"{name}, ems {n}x{n}", found, f"{corner}.z") for corner, (_, name) in CORNERS.items()]
    rows = [row for row in records(reference) if float(row["t"]) <= end + 1e-9][::4]
    series += [
        points(f"{name}, independent", [(float(row["t"]), float(row[f"{column}_z"])) for row in rows], line=False)
        for column, name in CORNERS.values()
    ]
    return {f"pendulum-{n}": plot("Quarter cylinder pendulum", "time [s]", "height z [m]", series)}


def pendulum(run: Run) -> Figures:
    """Pendulum on the mesh of the reference."""
    return swing(run, 16, "pendulum_n16_trapezoid_dt05", 1.0)


def pendulum_fine(run: Run) -> Figures:
    """Pendulum on a finer mesh than that of the reference."""
    return swing(run, 64, "pendulum_n32_hht005_dt05", 0.8)


def machine(run: Run, name: str, curves: dict[str, tuple[str, Callable[[str], bool]]], title: str, y: str, source: str) -> Figures:
    """Columns of the history of a machine, and the reference points."""
    found = run(model_of(f"machines/{name}"))
    series = [history(f"{legend}, tegula", found, column) for legend, (column, _) in curves.items()]
    series += [points(f"{legend}, {source}", known(name, which), line=False) for legend, (_, which) in curves.items()]
    return {name.replace("_", "-"): plot(title, "time [s]", y, series)}


def columns_of(**names: str) -> dict[str, tuple[str, Callable[[str], bool]]]:
    """Curves whose reference has the name of the column."""
    return {legend: (column, column.__eq__) for legend, column in names.items()}


def machines(run: Run) -> Figures:
    """Rigid mechanisms."""
    out = machine(run, "slider_crank", columns_of(slider="body.slider.x"), "Spatial slider–crank", "x of the slider [m]", "index 1")
    out |= machine(run, "governor", columns_of(slider="body.slider.z"), "Governor", "height of the slider [m]", "three freedoms")
    out |= machine(run, "heavy_top", columns_of(x="body.top.x", y="body.top.y", z="body.top.z"), "Heavy top", "mass centre [m]", "Runge–Kutta 8")
    return out


def bow(found: Columns, names: list[str]) -> list[float]:
    """Distance of the second of three points from the chord between the others over its length, in the plane x-y."""
    names = [f"body.{name}" if f"body.{name}.x" in found else name for name in names]
    out = []
    for k in range(len(found["time"])):
        (ax, ay), (bx, by), (cx, cy) = ((found[f"{name}.x"][k], found[f"{name}.y"][k]) for name in names)
        chord, rise = (cx - ax, cy - ay), (bx - (ax + cx) / 2, by - (ay + cy) / 2)
        out.append((chord[0] * rise[1] - chord[1] * rise[0]) / (chord[0] ** 2 + chord[1] ** 2))
    return out


def spin_up_angle(t: float) -> float:
    """Angle of the drive of the spin-up, Ω (t²/2 + (T/2π)² (cos(2πt/T) − 1))/T up to T."""
    full, rate = 15.0, 4.0
    if t > full:
        return rate * (t - full / 2)
    return rate / full * (t * t / 2 + (full / math.tau) ** 2 * (math.cos(math.tau * t / full) - 1))


def flexible(run: Run, shell: bool) -> Figures:
    """Machines with beams, or with strips of shell in their place."""
    end, kind, of = ("_shell", "ems", ", strips of shell") if shell else ("", "beams", "")
    out: Figures = {}
    tip = "tip" if shell else "body.strand.end"
    out |= machine(run, f"soft_pendulum{end}", columns_of(x=f"{tip}.x", y=f"{tip}.y"), "Soft pendulum" + of, "free end [m]", "SE(3) code")
    tip = "tip" if shell else "body.beam.end"
    found = run(model_of(f"machines/spin_up{end}"))
    angles = [spin_up_angle(t) for t in found["time"]]
    aside = [y * math.cos(a) - x * math.sin(a) for x, y, a in zip(found[f"{tip}.x"], found[f"{tip}.y"], angles, strict=True)]
    series = [history(f"across, {kind}", found, aside), points("across, SE(3) code", known(f"spin_up{end}", lambda name: name.endswith(".2")), line=False)]
    out[f"spin-up{end}".replace("_", "-")] = plot("Spin-up of a beam" + of, "time [s]", "deflection of the tip [m]", series)
    names = ["big_end", "middle", "small_end"] if shell else ["rod.start", "rod.8", "rod.end"]
    found = run(model_of(f"machines/flexible_slider_crank{end}"))
    reference = known(f"flexible_slider_crank{end}", lambda name: name.startswith("bow@"))
    series = [history(f"rod, {kind}", found, bow(found, names)), points("rod, EXUDYN", reference, line=False)]
    out[f"flexible-slider-crank{end}".replace("_", "-")] = plot("Flexible slider–crank" + of, "time [s]", "bow of the rod over its length", series)
    corner = "body.coupler.end"
    columns = columns_of(x=f"{corner}.x", y=f"{corner}.y", z=f"{corner}.z")
    out |= machine(run, f"skewed_four_bar{end}", columns, "Four-bar with a skewed hinge" + of, "end of the coupler [m]", "SE(3) code")
    place = "middle" if shell else "body.strip.20"
    columns = columns_of(z=f"{place}.z") if shell else columns_of(z=f"{place}.z", y=f"{place}.y")
    out |= machine(run, f"lateral_buckling{end}", columns, "Lateral buckling by a crank" + of, "middle of the strip [m]", "director beams")
    return out


def roof(run: Run, problem: str, title: str) -> Figures:
    """Path of a hinged roof: deflection under the force, and load ratio."""
    model = model_of("hinged_roof", "u_min_v_min")
    model["analysis"].update(end_load=1.25, points=40)
    section = {"thickness": 6.35 if problem == "S8b" else 12.7, "material": "m"}
    if problem == "S8d":
        section = {"layup": {"stacking": "[90/0/90]", "material": "ply", "ply_thickness": 12.7 / 3, "direction": [0.0, 1.0, 0.0]}}
    model["sections"] = [section]
    return {f"path-{problem.lower()}": path_figure(run(model), "u_min_v_min.uz", -1.0, problem, title, "16x16", "deflection [mm]")}


def path_figure(found: Columns, column: str, sign: float, problem: str, title: str, mesh: str, x: str):
    """Load ratio over a displacement, and the published points."""
    series = [path(f"ems {mesh}", [sign * u for u in found[column]], found["time"])]
    published = [(float(r["value"]), float(r["load_ratio"])) for r in records("sze_paths") if r["problem"] == problem]
    return plot(title, x, "load over full load", [*series, points("Sze, Liu, Lo", published, line=False)])


def roofs(run: Run) -> Figures:
    """Hinged roofs through limit points and a snap-back."""
    titles = {"S8a": "Hinged roof, 12.7 mm", "S8b": "Hinged roof, 6.35 mm: snap-back", "S8d": "Laminated hinged roof, 12.7 mm"}
    return {name: figure for problem, title in titles.items() for name, figure in roof(run, problem, title).items()}


def full_load(run: Run) -> Figures:
    """Open cylinder and slit annulus along their paths."""
    found = run(model_of("open_cylinder", "u_min_v_min"))
    out = {"path-s5": path_figure(found, "u_min_v_min.uz", 1.0, "S5", "Open cylinder pulled by two forces", "24x16", "displacement [m]")}
    model = model_of("slit_annulus", "u_min_v_min", "u_max_v_min")
    model["analysis"] = {"type": "path"}
    found = run(model)
    series = [path(f"w of {name}, ems 6x30", found[f"{corner}.uz"], found["time"]) for name, corner in (("A", "u_min_v_min"), ("B", "u_max_v_min"))]
    rows = [r for r in records("sze") if (r["problem"], r["element"], r["mesh"]) == ("S3", "EMS", "6x30")]
    series += [points(f"w of {name}, independent", [(float(r[f"value{k}"]), float(r["load_ratio"])) for r in rows], line=False) for k, name in ((1, "A"), (2, "B"))]
    out["path-s3"] = plot("Slit annulus under a line force", "displacement [m]", "load over full load", series)
    return out


def sphere_octant(n: int) -> dict:
    """Octant of a sphere of radius 1: three faces of a cube with n × n elements each, pushed out to the sphere."""
    numbers: dict[tuple[int, ...], int] = {}

    def node(face: int, i: int, j: int) -> int:
        key = [n, n, n]
        key[(face + 1) % 3], key[(face + 2) % 3] = i, j
        return numbers.setdefault(tuple(key), len(numbers))

    quads = [
        [node(face, i, j), node(face, i + 1, j), node(face, i + 1, j + 1), node(face, i, j + 1)]
        for face in range(3)
        for j in range(n)
        for i in range(n)
    ]
    cube = [[math.tan(math.pi / 4 * k / n) for k in key] for key in numbers]
    nodes = [[x / math.hypot(*place) for x in place] for place in cube]
    sets = {f"{name} = 0": [number for key, number in numbers.items() if key[axis] == 0] for axis, name in enumerate("xyz")}
    return {"type": "arrays", "nodes": nodes, "quads": quads, "node_sets": sets}


def spheres(run: Run) -> Figures:
    """Pressure of spheres of rubber over their stretch, by the volume that they enclose."""
    laws = {
        "neo-Hooke": ({"type": "neo-hookean", "shear": 1.0, "bulk": 2e3}, (2.0, 0.0)),
        "Mooney-Rivlin": ({"type": "mooney-rivlin", "c10": 0.7, "c01": 0.1, "bulk": 1e3}, (2.8, 0.4)),
    }
    mesh, computed, exact = sphere_octant(8), [], []
    for name, (law, pressure) in laws.items():
        model = {
            "analysis": {"type": "path", "end_load": 10.0, "stop": [{"column": "sensor.inside.volume", "value": 2.5**3 * math.pi / 6, "direction": "rising"}]},
            "mesh": mesh,
            "materials": {"m": law},
            "sections": [{"element": "cm", "material": "m", "thickness": 0.01}],
            "conditions": [{"type": "symmetry", "on": f"{axis} = 0", "normal": [float(axis == other) for other in "xyz"]} for axis in "xyz"],
            "loads": [{"type": "pressure", "value": -0.01}],
            "sensors": [{"type": "volume", "name": "inside", "on": "all"}],
        }
        found = run(model)
        volumes = found["sensor.inside.volume"]
        computed.append(path(f"{name}, cm 3x8x8", [(v / volumes[0]) ** (1 / 3) for v in volumes], found["time"]))
        exact.append(points(f"{name}, thin sphere", thin_sphere(*pressure)[::3], line=False))
    return {"paths-balloon": plot("Spheres of rubber under pressure", "stretch", "pressure p R/h", computed + exact)}


def follower_loads(run: Run) -> Figures:
    """Ways of the end of the strip: under follower pressure, and rolled up by a moment."""
    model = model_of("follower_strip", "u_max_v_max")
    # More steps than the case takes, for a smooth curve.
    model["analysis"]["load_steps"] = 100
    found = run(model)
    reference = {row["axis"]: float(row["position"]) for row in records("follower_strip")}
    series = [path("ems 40x2", found["u_max_v_max.x"], found["u_max_v_max.z"]), points("independent program", [(reference["x"], reference["z"])], line=False)]
    out = {"follower-pressure": plot("Strip under follower pressure: way of its end", "x [m]", "z [m]", series)}
    model = model_of("follower_strip", "u_max_v_max")
    model["mesh"]["grid"]["elements"] = [160, 2]
    (law,) = model["materials"].values()
    law["poisson"] = 0.0
    model["sections"][0]["thickness"] = 0.02
    moment = law["young"] * 0.02**3 / 12 * 4 * math.tau / 10
    model["analysis"] = {"type": "static", "load_steps": 160}
    model["loads"] = [{"type": "edge-moment", "on": "u_max", "value": [0.0, moment, 0.0]}]
    found = run(model)
    angles = [2 * math.pi * 4 * k / 200 for k in range(1, 201)]
    down = -1.0 if min(found["u_max_v_max.z"]) < -1 else 1.0
    circle = [(10 * math.sin(a) / a, down * 10 * (1 - math.cos(a)) / a) for a in angles]
    series = [path("ems 160x2", found["u_max_v_max.x"], found["u_max_v_max.z"]), points("bending to a circle", circle, marked=False)]
    out["follower-roll-up"] = plot("Strip rolled up four turns: way of its end", "x [m]", "z [m]", series)
    return out


# Model, title, mesh of the publication, components that are shown, and position of the tip at the start.
SUDDEN = {
    "T1": ("cantilever_corner_force", "T1: plate under a sudden corner force", 4, "z", 0.0),
    "T2": ("laminated_cylinder_force", "T2: laminate under a sudden corner force", 6, "xyz", 1.0),
    "T3": ("laminated_cylinder_gravity", "T3: laminate under gravity", 8, "xz", 1.0),
}


def sudden_loads(run: Run, factor: int) -> Figures:
    """Tips of suddenly loaded shells, with meshes finer than the published ones by a factor."""
    out = {}
    for problem, (name, title, n, components, start) in SUDDEN.items():
        model = model_of(name, "u_max_v_max")
        n *= factor
        model["mesh"]["grid"]["elements"] = [n, n]
        if factor == 1:
            for section in model["sections"]:
                section["element"] = "cm"
        found = run(model)
        legend = f"{'ems' if factor > 1 else 'cm'} {n}x{n}"
        series = [history(f"{c}, {legend}", found, [start + u for u in found[f"u_max_v_max.u{c}"]]) for c in components]
        for c in components:
            rows = [r for r in records("transients_literature") if (r["case"], r["component"]) == (problem, c)][::3]
            series.append(points(f"{c}, Chrono", [(float(r["time_s"]), float(r["value"])) for r in rows], line=False))
        ending = "" if factor == 1 else "-fine"
        out[f"transient-{problem.lower()}{ending}"] = plot(title, "time [s]", "deflection [m]" if problem == "T1" else "tip [m]", series)
    return out


CURVES: dict[str, Callable[[Run], Figures]] = {
    "hinged-plate": hinged_plate,
    "oscillating-plate": oscillating_plate,
    "pendulum": pendulum,
    "pendulum-64": pendulum_fine,
    "machines": machines,
    "flexible-machines": lambda run: flexible(run, False),
    "flexible-machines-shells": lambda run: flexible(run, True),
    "paths-roofs": roofs,
    "paths-full-load": full_load,
    "paths-balloon": spheres,
    "follower-loads": follower_loads,
    "transients-literature": lambda run: sudden_loads(run, 1),
    "transients-literature-fine": lambda run: sudden_loads(run, 4),
}
# Cases whose curves take a quarter of a minute and more: their figures are kept, and drawn anew with --all.
LONG = {"paths-balloon", "pendulum-64", "transients-literature-fine"}
