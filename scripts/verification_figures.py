"""Figures of the verification manual: computed curves and the reference points, by case.

Figures of `FIGURES` are drawn from the values of `tegula verify --json`, the tables that the book shows, and the reference tables; those of
`verification_curves.CURVES` from runs of the models. Each figure keeps the numbers of its curves, so that `--check` compares numbers and not pixels.
"""

import csv
import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from line_plot import Plot, Series, numbers_of

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "verification/reference"
TABLES = ROOT / "book/src/verification"

Rows = list[dict]
Figures = dict[str, Plot]


def records(name: str) -> list[dict[str, str]]:
    """Rows of a reference table."""
    lines = (REFERENCE / f"{name}.csv").read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def table(name: str) -> list[list[str]]:
    """Rows of a table that the book shows, its heads first."""
    lines = (TABLES / f"{name}.md").read_text().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]


def side(mesh: str) -> int:
    """Elements along the first side of a mesh such as 16x16."""
    return int(mesh.split("x")[0])


def label(value: float) -> str:
    """Short label of a tick, with a minus sign."""
    return f"{value:.6g}".replace("-", "−")


def even_ticks(values: Iterable[float]) -> dict[float, str]:
    """Ticks at round numbers about some values, five to eight of them."""
    values = list(values)
    low, high = min(values), max(values)
    if high - low < 1e-12 * max(abs(high), 1.0):
        low, high = low - 0.5, high + 0.5
    rough = (high - low) / 6
    power = 10 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1, 2, 2.5, 5, 10) if factor * power >= rough * 0.999)
    first, last = math.floor(low / step + 1e-6), math.ceil(high / step - 1e-6)
    return {round(k * step, 12): label(round(k * step, 12)) for k in range(first, last + 1)}


def powers(values: Iterable[float], base: float = 10) -> dict[float, str]:
    """Ticks at the powers of a base about some values."""
    exponents = [math.log(value, base) for value in values if value > 0]
    first, last = math.floor(min(exponents) + 1e-6), math.ceil(max(exponents) - 1e-6)
    last = max(last, first + 1)
    upper = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

    def name(k: int) -> str:
        return label(base**k) if base != 10 or -2 <= k <= 3 else "10" + str(k).translate(upper)

    return {base**k: name(k) for k in range(first, last + 1)}


def plot(title: str, x: str, y: str, series: list[Series], *, x_base: float = 0, y_base: float = 0, x_ticks=None, y_ticks=None) -> Plot:
    """Plot whose axes end at round numbers; a base makes an axis logarithmic."""
    all_x, all_y = ([value for s in series for value in getattr(s, axis)] for axis in "xy")
    x_ticks = x_ticks or (powers(all_x, x_base) if x_base else even_ticks(all_x))
    y_ticks = y_ticks or (powers(all_y, y_base) if y_base else even_ticks(all_y))
    return Plot(title, x, y, x_ticks, y_ticks, series, bool(x_base), bool(y_base))


def points(name: str, of: Iterable[tuple[float, float]], **look: bool) -> Series:
    """Series of pairs."""
    x, y = zip(*of, strict=True)
    return Series(name, x, y, **look)


def by_mesh(rows: Rows, quantity: str, element: str) -> list[tuple[int, dict]]:
    """Rows of a quantity and an element, by the elements along a side."""
    found = [row for row in rows if row["quantity"] == quantity and row["element"] == element]
    return sorted(((side(row["mesh"]), row) for row in found), key=lambda pair: pair[0])


MESH = "elements along a side"


def plate(rows: Rows) -> Figures:
    """Deflection of the corner over the converged one, with and without remedies."""
    out = {}
    exact = {record["H_m"]: float(record["uz_corner_m"]) for record in records("plate_converged") if record["model"].startswith("p-version")}
    for slenderness, height in ((1000, "0.001"), (10, "0.1")):
        series = []
        for name in ("ems", "cm eas4+4", "cm no thickness eas", "ems no ans shear"):
            found = by_mesh(rows, f"L/H = {slenderness}: corner deflection", name)
            series.append(points(name, [(n, row["value"] / exact[height]) for n, row in found]))
        series.append(Series("converged plate theory", [1, 32], [1, 1], marked=False))
        title = f"Cantilever plate, L/H = {slenderness}: corner deflection"
        out[f"plate-{slenderness}"] = plot(title, MESH, "deflection over plate theory", series, x_base=2)
    return out


def quarter_cylinder(rows: Rows) -> Figures:
    """Deflection of the loaded corner over the mesh in the four set-ups, beside the reference program."""
    series = []
    for setup in ("S1", "S2", "S3", "S4"):
        found = by_mesh(rows, f"{setup}: loaded corner u_z", "ems")
        series.append(points(f"{setup}, ems", [(n, abs(row["value"])) for n, row in found], markers=False))
    reference = [(int(r["n"]), abs(float(r["uz"]))) for r in records("quarter_cylinder") if r["element"] == "EMS" and int(r["n"]) <= 64]
    series.append(points("independent program", reference, line=False))
    deflection = plot("Quarter cylinder: deflection of the loaded corner", MESH, "|u_z| [m]", series, x_base=2)
    rows_of_figure = table("paper-figure-7")[1:]
    errors = [
        points(name, [(side(row[0]), float(row[column])) for row in rows_of_figure]) for name, column in (("ems", 2), ("cm", 4))
    ]
    first = errors[0].y[0]
    errors.append(Series("second order", [4, 64], [first, first / 256], marked=False))
    convergence = plot("Set-up S1: error against the finest mesh", MESH, "error of u_z [m]", errors, x_base=2, y_base=10)
    return {"quarter-cylinder": deflection, "quarter-cylinder-error": convergence}


def frequencies(rows: Rows) -> Figures:
    """Error of the first frequencies over the mesh, against Mindlin's plate by Ritz."""
    out = {}
    truth = {record["L/H"]: record for record in records("free_plate") if record["model"] == "truth Mindlin ks=0.833"}
    for slenderness in (1000, 10):
        series = []
        for mode in (1, 3, 5):
            found = by_mesh(rows, f"L/H = {slenderness}: Omega {mode}", "ems ks=5/6")
            exact = float(truth[str(slenderness)][f"Omega{mode}"])
            series.append(points(f"mode {mode}, ems", [(n, row["value"] / exact - 1) for n, row in found]))
        start = series[0].y[0]
        last = series[0].x[-1]
        series.append(Series("second order", [4, last], [start, start * (4 / last) ** 2], marked=False))
        title = f"Free plate, L/H = {slenderness}: frequencies"
        out[f"frequencies-{slenderness}"] = plot(title, MESH, "relative error", series, x_base=2, y_base=10)
    return out


def patch(_: Rows) -> Figures:
    """Errors of the elements that fail a patch test, by test."""
    heads, *body = table("patch-tests")
    tests = heads[2:]
    series = []
    for mesh in ("regular", "distorted"):
        errors = [(row[0], [float(cell) for cell in row[2:] if cell[0].isdigit()]) for row in body if row[1] == mesh]
        failing = [(name, max(found)) for name, found in errors if found]
        series.append(points(f"{mesh} mesh, bending", [(k, error) for k, (_, error) in enumerate(failing)], line=False))
        names = [name for name, _ in failing]
    assert tests[1] == "bending"
    ticks = dict(enumerate(["cm eas4+1", "cm, no t.-eas", "ems, no ans", "ancf-full"]))
    assert names == ["cm eas4+1", "cm no thickness eas", "ems no ans shear", "ancf-full"]
    end = len(ticks) - 0.5
    series.append(Series("limit of all other elements", [-0.5, end], [1e-8, 1e-8], marked=False))
    ticks = {-0.5: "", **ticks, end: ""}
    return {"patch": plot("Patch tests: elements that fail", "element", "error of the bending test", series, y_base=10, x_ticks=ticks)}


def paper_tables(_: Rows) -> Figures:
    """Tables 1 to 3: all elements over the mesh; table 4: frequencies over the mode."""
    series = []
    for number, slenderness in ((1, 1000), (2, 100), (3, 10)):
        corner = [row for row in table(f"paper-table-{number}")[1:] if row[1] == "corner"]
        for column, name in ((2, "EMS"), (3, "CM")):
            pairs = [(side(row[0]), float(row[column]) / float(row[6])) for row in corner]
            series.append(points(f"{name}, L/H = {slenderness}", pairs))
    series.append(Series("plate theory", [2, 32], [1, 1], marked=False))
    deflection = plot("Tables 1–3: corner deflection over plate theory", MESH, "deflection over plate theory", series, x_base=2)
    body = table("paper-table-4")[1:]
    modes = []
    for element, mesh in (("EMS", "16x16"), ("CM eas4+4", "16x16"), ("ancf-full", "16x16"), ("Mindlin (Ritz)", "")):
        row = next(row for row in body if row[:3] == ["100", element, mesh])
        modes.append(points(f"{element} {mesh}".strip(), [(k + 1, float(value)) for k, value in enumerate(row[3:8])]))
    frequency = plot("Table 4: free plate, L/H = 100", "elastic mode", "Ω = ω/(π² √(D/ρHL⁴))", modes)
    return {"paper-tables": deflection, "paper-tables-frequencies": frequency}


def membrane_parts(_: Rows) -> Figures:
    """Strain up to which a strip is stable over the aspect ratio; Cook's membrane over the mesh."""
    heads, *body = table("membrane-stretched")
    stable = [points(name, [(int(row[0]), float(row[k])) for row in body]) for k, name in enumerate(heads) if k]
    heads, *body = table("membrane-accuracy")
    cook = [
        points(name, [(side(row[0].split(", ")[1]), float(row[k])) for row in body if row[0].startswith("Cook")])
        for k, name in enumerate(heads)
        if k
    ]
    cook.append(Series("literature, 23.96", [4, 16], [1, 1], marked=False))
    return {
        "membrane-parts": plot("Clamped strip: strain up to which it is stable", "aspect ratio of the elements", "fibre strain (computed to 0.1)", stable, x_base=2),
        "membrane-parts-cook": plot("Cook's membrane", MESH, "deflection over the literature", cook, x_base=2),
    }


def linear_benchmarks(rows: Rows) -> Figures:
    """Displacements over those of the literature."""
    out = {}
    literature = {record["problem"]: float(record["literature"]) for record in records("linear_benchmarks")}
    titles = {"scordelis_lo": "Scordelis-Lo roof", "pinched_cylinder": "Pinched cylinder", "hemisphere_18": "Hemisphere with a hole"}
    for case, title in titles.items():
        own = [row for row in rows if row["case"] == case]
        series = []
        for element in ("ems", "cm eas4+4", "ems no ans shear"):
            found = by_mesh(own, "displacement", element)
            series.append(points(element, [(n, abs(row["value"]) / literature[case]) for n, row in found]))
        series.append(Series("literature", [4, 32], [1, 1], marked=False))
        out[case.replace("_", "-")] = plot(f"{title}: displacement", MESH, "displacement over literature", series, x_base=2)
    return out


# Title, quantities with their names in the legend, and mesh of the problems of Sze, Liu and Lo.
SZE = {
    "S1": ("Strip under end shear", {"-U": "−u", "W": "w"}, "16x1"),
    "S2": ("Strip under an end moment", {"-U": "−u", "W": "w"}, "16x1"),
    "S3": ("Slit annulus under a line force", {"WA_inner": "w of A", "WB_outer": "w of B"}, "10x80"),
    "S4": ("Hemisphere with a hole", {"VA_smaller": "v of A", "-UB_larger": "−u of B"}, "16x16"),
}


def load_curve(rows: Rows, quantity: str, element: str, mesh: str) -> list[tuple[float, float]]:
    """Displacement and load ratio of the rows "QUANTITY at RATIO"."""
    out = [(0.0, 0.0)]
    for row in rows:
        name, _, ratio = row["quantity"].rpartition(" at ")
        if (name, row["element"], row["mesh"]) == (quantity, element, mesh):
            out.append((row["value"], float(ratio)))
    return out


def sze(rows: Rows) -> Figures:
    """Load–displacement curves of EMS and the published points."""
    out = {}
    for problem, (title, quantities, mesh) in SZE.items():
        own = [row for row in rows if row["case"] == f"sze-{problem}"]
        series = [points(f"{name}, ems {mesh}", load_curve(own, quantity, "ems", mesh), markers=False) for quantity, name in quantities.items()]
        published = [record for record in records("sze") if (record["problem"], record["element"], record["mesh"]) == (problem, "EMS", mesh)]
        for k, name in ((1, "first"), (2, "second")):
            pairs = [(float(r[f"lit{k}"]), float(r["load_ratio"])) for r in published if r[f"lit{k}"]]
            name = list(quantities.values())[k - 1]
            series.append(points(f"{name}, {'exact' if problem == 'S2' else 'Sze, Liu, Lo'}", pairs, line=False))
        out[f"sze-{problem.lower()}"] = plot(title, "displacement [m]", "load over full load", series)
    return out


def sze_literature(rows: Rows) -> Figures:
    """Load–displacement curves on fine meshes and the sharper references."""
    out = {}
    sources = {"S1": "elastica", "S2": "exact arc", "S3": "Naghdi's shell", "S4": "CalculiX"}
    meshes = {"S1": "16x1", "S2": "32x1", "S3": "10x80", "S4": "32x32"}
    for problem, (title, quantities, _) in SZE.items():
        own = [row for row in rows if row["case"] == f"sze-{problem}-literature"]
        mesh, series = meshes[problem], []
        for element in ("ems", "cm eas4+4"):
            series += [
                points(f"{name}, {element} {mesh}", load_curve(own, quantity, element, mesh), markers=False)
                for quantity, name in quantities.items()
            ]
        for quantity, name in quantities.items():
            known = [r for r in records("sze_literature") if (r["problem"], r["quantity"]) == (problem, quantity)]
            series.append(points(f"{name}, {sources[problem]}", [(float(r["value"]), float(r["load_ratio"])) for r in known], line=False))
        out[f"sze-literature-{problem.lower()}"] = plot(title, "displacement [m]", "load over full load", series)
    return out


def thin_sphere(first: float, second: float) -> list[tuple[float, float]]:
    """Pressure p R/h of a thin sphere of incompressible rubber over its stretch."""
    stretches = [1 + 0.025 * k for k in range(61)]
    return [(l, (1 / l - l**-7) * (first + second * l * l)) for l in stretches]


def balloon(rows: Rows) -> Figures:
    """Pressure over the stretch."""
    series = []
    for element in ("cm", "solid-shell"):
        own = [row for row in rows if row["element"] == element]
        at = [(float(row["quantity"].split()[-1]), row["value"]) for row in own if "at stretch" in row["quantity"]]
        series.append(points(f"{element} 3x8x8", at, line=False))
        if element == "cm":
            limit = {row["quantity"].split()[0]: row["value"] for row in own if "limit" in row["quantity"]}
            series.append(points("limit, cm", [(limit["stretch"], limit["limit"])], line=False))
    series.append(points("thin sphere, exact", thin_sphere(2, 0), marked=False))
    return {"balloon": plot("Balloon of neo-Hookean rubber", "stretch", "pressure p R/(μ h)", series)}


def imperfect_cylinder(rows: Rows) -> Figures:
    """Bifurcation load over the amplitude of the imperfection, Koiter's formula, and one term of Donnell's equations."""
    c = math.sqrt(3 * (1 - 0.3**2))

    def asymptotic(mu: float) -> float:
        b = 1 + 0.75 * c * mu
        return b - math.sqrt(b * b - 1)

    def one_term(mu: float) -> float:
        a, low, high = c * mu, 0.0, asymptotic(mu)
        for _ in range(60):
            middle = (low + high) / 2
            positive = (1 - middle) ** 3 - a * (1 + middle / 2) * (1 - middle) + a * a / 2 > 0
            low, high = (middle, high) if positive else (low, middle)
        return (low + high) / 2

    amplitudes = [0.22 * (k / 40) ** 2 for k in range(41)]
    computed = [(float(row["quantity"].split()[4]), row["value"]) for row in rows if row["quantity"].endswith("Donnell's equations")]
    series = [
        points("ems 18x40", computed, line=False),
        points("Donnell, one term", [(mu, one_term(mu)) for mu in amplitudes], markers=False),
        points("Koiter's formula", [(mu, asymptotic(mu)) for mu in amplitudes], marked=False),
    ]
    return {"imperfect-cylinder": plot("Cylinder under axial compression", "amplitude over thickness", "bifurcation load over classical", series)}


def bimetal(rows: Rows) -> Figures:
    """Curvature over the ratio of the thicknesses by Timoshenko's formula, and the strips."""

    def curvature(m: float, n: float) -> float:
        top = (1 + m) ** 2
        return 6 * 20e-6 * 10 / 1e-4 * top / (3 * top + (1 + m * n) * (m * m + 1 / (m * n)))

    ratios = [0.25 * 16 ** (k / 40) for k in range(41)]
    series = [points(f"Timoshenko, E1/E2 = {n:g}", [(m, curvature(m, n)) for m in ratios], markers=False) for n in (1.0, 2.0, 0.4, 1.5)]
    for element in ("ems", "cm"):
        pairs = [(float(re.search(r"h1/h2 = ([\d.]+)", row["quantity"])[1]), row["value"]) for row in rows if row["element"] == element]
        series.append(points(f"{element} 16x1", pairs, line=False))
    return {"bimetal": plot("Bimetal strip: curvature", "thickness ratio h1/h2", "curvature [1/m]", series, x_base=2)}


def composites(rows: Rows) -> Figures:
    """Deflections and frequency of the plates by layup, beside Navier's series."""
    layups = ["[0/90]", "[0/90/90/0]", "[0/90]4"]
    ticks = {-0.5: "", 0: "[0/90]", 1: "[0/90/90/0]", 2: "[0/90]₄", 2.5: ""}
    known = {(record["layup"], record["quantity"]): float(record["value"]) for record in records("composites")}
    deflections, waves = [], []
    for quantity, out in (("sinusoidal", deflections), ("uniform", deflections), ("frequency", waves)):
        for element in ("ems", "cm"):
            pairs = []
            for k, layup in enumerate(layups):
                found = [row for row in rows if row["element"] == element and row["mesh"] == "32x32" and layup + ":" in row["quantity"] + ":" and quantity in row["quantity"]]
                pairs += [(k, row["value"]) for row in found[:1]]
            out.append(points(f"{element}, {quantity}", pairs, line=False))
        out.append(points(f"Navier, {quantity}", [(k, known[layup, quantity]) for k, layup in enumerate(layups)], line=False))
    return {
        "composites": plot("Cross-ply plates: deflection of the centre", "layup", "100 w E₂ h³/(q a⁴)", deflections, x_ticks=ticks),
        "composites-frequency": plot("Cross-ply plates: first frequency", "layup", "ω a²/h √(ρ/E₂)", waves, x_ticks=ticks),
    }


def large_cantilever(rows: Rows) -> Figures:
    """Displacements of both corners over the load, and the solid elements."""
    out = {}
    for point in ("loaded", "other"):
        series = []
        for axis in "xz":
            pairs = load_curve(rows, f"{point} corner u_{axis}", "ems", "32x32")
            series.append(points(f"|u{axis}|, ems 32x32", [(abs(u), ratio) for u, ratio in pairs], markers=False))
        for component in ("ux", "uz"):
            known = [r for r in records("large_cantilever") if (r["mesh"], r["point"]) == ("32x32", point)]
            series.append(points(f"|{component}|, CalculiX", [(abs(float(r[component])), float(r["load_ratio"])) for r in known], line=False))
        title = f"Cantilever plate: the {'loaded' if point == 'loaded' else 'other free'} corner"
        out[f"large-cantilever-{point}"] = plot(title, "displacement [m]", "load over full load", series)
    return out


def categories(names: list[str]) -> dict[float, str]:
    """Ticks of an axis of names, with half a place before the first and behind the last one."""
    return {-0.5: "", **dict(enumerate(names)), len(names) - 0.5: ""}


def macneal_beams(_: Rows) -> Figures:
    """Tip displacements over theory by the shape of the elements, on the coarse meshes of the paper and on fine ones."""
    body = table("macneal-harder-beams")[1:]
    beams = list(dict.fromkeys(row[0] for row in body))
    out = {}
    for load in ("in-plane shear", "out-of-plane shear"):
        series = []
        for column, element in ((3, "ems"), (4, "cm")):
            for k, mesh in enumerate(("coarse", "fine")):
                values = [[float(row[column]) for row in body if row[:2] == [beam, load]][k] for beam in beams]
                series.append(points(f"{element}, {mesh} mesh", enumerate(values), line=False))
        series.append(Series("theory", [-0.5, 4.5], [1, 1], marked=False))
        ticks = categories(["rectangles", "trapezoids", "parallelogr.", "curved", "twisted"])
        name = load.removesuffix(" shear")
        out[f"macneal-harder-beams-{name}"] = plot(f"Beams of MacNeal and Harder: {load}", "beam", "tip displacement over theory", series, x_ticks=ticks)
    return out


def macneal_plates(_: Rows) -> Figures:
    """Deflections of the middle over the paper's, by support and aspect ratio."""
    body = table("macneal-harder-plates")[1:]
    plates = list(dict.fromkeys(row[0] for row in body))
    series = []
    for load in ("pressure", "force"):
        for k, mesh in enumerate(("4x4", "fine mesh")):
            values = [[float(row[3]) for row in body if row[:2] == [plate, load]][k] for plate in plates]
            series.append(points(f"ems {mesh}, {load}", enumerate(values), line=False))
    series.append(Series("paper", [-0.5, 3.5], [1, 1], marked=False))
    ticks = categories([plate.replace("supported", "supp.").replace("b/a = ", "") for plate in plates])
    return {"macneal-harder-plates": plot("Plates of MacNeal and Harder", "support, aspect ratio b/a", "deflection over the paper's", series, x_ticks=ticks)}


def results(rows: Rows) -> Figures:
    """Frequencies of the supported strip, and the flight of the thrown plate."""
    modes = [row for row in rows if re.fullmatch(r"supported strip: mode \d, frequency_hz", row["quantity"])]
    numbers = range(1, len(modes) + 1)
    frequency = [
        Series("ems 64x2", list(numbers), [row["value"] for row in modes], line=False),
        Series("closed form", list(numbers), [row["reference"] for row in modes], marked=False),
    ]
    flight, exact = [], []
    for component, axis in enumerate("xyz", 1):
        ending = f": displacement, history, component {component}"
        own = [(float(re.findall(r"[\d.]+", row["quantity"])[0]), row) for row in rows if row["quantity"].startswith("thrown plate at") and row["quantity"].endswith(ending)]
        flight.append(points(axis, [(0.0, 0.0), *((t, row["value"]) for t, row in own)], line=False))
    velocity = [s.y[-1] + (9.81 / 2 if k == 2 else 0.0) for k, s in enumerate(flight)]
    times = [k / 40 for k in range(41)]
    for k, (axis, speed) in enumerate(zip("xyz", velocity, strict=True)):
        gravity = 9.81 / 2 if k == 2 else 0.0
        exact.append(points(f"{axis}, free flight", [(t, speed * t - gravity * t * t) for t in times], marked=False))
    return {
        "results-frequencies": plot("Supported strip: frequencies", "mode", "frequency [Hz]", frequency, x_ticks={k: str(k) for k in numbers}),
        "results-flight": plot("Thrown plate: displacement of its centre", "time [s]", "displacement [m]", flight + exact),
    }


FIGURES: dict[str, Callable[[Rows], Figures]] = {
    "plate": plate,
    "quarter-cylinder": quarter_cylinder,
    "frequencies": frequencies,
    "patch": patch,
    "paper-tables": paper_tables,
    "membrane-parts": membrane_parts,
    "linear-benchmarks": linear_benchmarks,
    "sze": sze,
    "sze-literature": sze_literature,
    "balloon": balloon,
    "paths-imperfect-cylinder": imperfect_cylinder,
    "bimetal": bimetal,
    "macneal-harder-beams": macneal_beams,
    "macneal-harder-plates": macneal_plates,
    "results": results,
    "composites": composites,
    "large-cantilever": large_cantilever,
}


def figures_agree(shown: str, fresh: str) -> bool:
    """Whether two figures differ by rounding only: by a thousandth of the range of each series."""
    a, b = numbers_of(shown), numbers_of(fresh)
    if {name: len(xy[0]) for name, xy in a.items()} != {name: len(xy[0]) for name, xy in b.items()}:
        return False
    for name, axes in a.items():
        for old, new in zip(axes, b[name], strict=True):
            allowed = 2e-3 * max(max(old) - min(old), 1e-6 * max(map(abs, old)))
            if any(not abs(x - y) <= allowed for x, y in zip(old, new, strict=True)):
                return False
    return True
