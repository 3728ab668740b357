#!/usr/bin/env python3
"""Draws the figures of the element guide, `book/src/pictures/elements/*.svg`, from runs of the program.

    python3 scripts/element_guide.py PROGRAM            # computes all figures and prints their numbers
    python3 scripts/element_guide.py PROGRAM --check    # compares newly computed numbers with those of the figures and of the page

Names of studies behind PROGRAM choose some; `--models FOLDER` leaves the model files and results in FOLDER.

References are closed forms and published values; each study names its own.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from line_plot import Plot, Series, kept, svg

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "book" / "src" / "element-guide.md"
PICTURES = ROOT / "book" / "src" / "pictures" / "elements"
YOUNG = 1e7
Model = dict


def toml(value: object) -> str:
    """A value as inline TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


class Program:
    """The program, and the folder for models and results."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder, self.count = path, folder, 0

    def run(self, name: str, model: Model) -> Path:
        """Result folder of a model; the run may end early, at a critical point."""
        self.count += 1
        stem = f"{self.count:03}-{name}"
        file = self.folder / f"{stem}.toml"
        file.write_text("".join(f"{k} = {toml(v)}\n" for k, v in model.items()), encoding="utf-8")
        out = self.folder / stem
        done = subprocess.run([self.path, "run", file, "--out", out, "--quiet", "--force"], capture_output=True, text=True)
        if done.returncode not in (0, 3):
            sys.exit(f"{file}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return out

    def moved(self, name: str, model: Model, axis: int, point: str = "tip") -> float:
        """Displacement of a point at the end of a complete run."""
        out = self.run(name, model)
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
        return summary["points"][point]["displacement"][axis]

    def reached(self, name: str, model: Model) -> float:
        """Load factor of the last equilibrium."""
        with open(self.run(name, model) / "history.csv", encoding="utf-8") as file:
            return float(list(csv.DictReader(file))[-1]["time"])


def base(mesh: Model, section: Model, material: Model, thickness: float, point: str, linear: bool = True) -> Model:
    """A static model without supports and loads; `section` has the keys that differ between elements."""
    return {
        "analysis": {"type": "static", "linear": linear},
        "mesh": mesh,
        "materials": {"m": material},
        "sections": [{"material": "m", "thickness": thickness, **section}],
        "output": {"points": [{"name": "tip", "on": point}], "pictures": False, "fields": []},
    }


def isotropic(poisson: float, young: float = YOUNG) -> Model:
    return {"type": "isotropic", "young": young, "poisson": poisson}


def plate(size: list[float], elements: list[int]) -> Model:
    return {"type": "plate", "size": size, "grid": {"elements": elements}}


def arrays(nu: int, nv: int, at: Callable[[int, int], list[float]], **keys: object) -> Model:
    """Mesh of nu × nv elements with the node (i, j) at `at(i, j)`, and the sets root, tip, near, far and `tip j`."""

    def node(i: int, j: int) -> int:
        return j * (nu + 1) + i

    sets = {"root": [node(0, j) for j in range(nv + 1)], "tip": [node(nu, j) for j in range(nv + 1)]}
    sets |= {"near": [node(i, 0) for i in range(nu + 1)], "far": [node(i, nv) for i in range(nu + 1)]}
    sets |= {f"{end} {j}": [node(i, j)] for end, i in [("root", 0), ("tip", nu)] for j in range(nv + 1)}
    return {
        "type": "arrays",
        "nodes": [at(i, j) for j in range(nv + 1) for i in range(nu + 1)],
        "quads": [[node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)] for j in range(nv) for i in range(nu)],
        "node_sets": sets,
        **keys,
    }


def shared(vector: list[float], nv: int) -> list[Model]:
    """A force on the edge `tip` as a constant line load."""
    loads = []
    for j in range(nv + 1):
        part = (0.5 if j in (0, nv) else 1.0) / nv
        loads.append({"type": "force", "on": f"tip {j}", "value": [part * v for v in vector]})
    return loads


def section(element: str, **keys: object) -> Model:
    return {"element": element, **keys}


def ticks(*values: float) -> dict[float, str]:
    return {v: f"{v:g}" for v in values}


RATIO = ticks(0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2)


def shear(p: Program) -> Plot:
    """Cantilever strip of eight elements under a force at its end, ν = 0; S. P. Timoshenko's beam, k = 5/6."""
    slenderness, n, width = [5, 10, 20, 50, 100, 200, 500, 1000], 8, 0.1

    def exact(s: float) -> float:
        return 4 / YOUNG * (1 + 0.6 / s**2)

    def strip(s: float, keys: Model) -> float:
        h = 1 / s
        model = base(plate([1.0, width], [n, 1]), keys, isotropic(0.0), h, "u_max_v_min")
        model["conditions"] = [{"type": "clamp", "on": "u_min"}]
        model["loads"] = [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, h**3]}]
        return p.moved("shear", model, 2) / exact(s)

    def beam(s: float) -> float:
        h = 1 / s
        model = {
            # Small displacements: a force that moves the end by 1e-6 of the length.
            "analysis": {"type": "static"},
            "materials": {"m": isotropic(0.0)},
            "beams": [{"name": "b", "points": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "elements": n, "direction": [0.0, 0.0, 1.0], "section": {"type": "rectangle", "size": [h, width]}, "material": "m"}],
            "joints": [{"type": "fixed", "name": "root", "between": ["ground", "b.start"], "at": [0.0, 0.0, 0.0]}],
            "loads": [{"type": "force", "on": "b.end", "value": [0.0, 0.0, 2.5 * width * h**3]}],
        }
        with open(p.run("shear-beam", model) / "history.csv", encoding="utf-8") as file:
            return float(list(csv.DictReader(file))[-1]["body.b.end.z"]) / (2.5 * exact(s))

    plot = Plot("Transverse shear: strip of 8 elements", "length over thickness L/h", "deflection over exact", ticks(5, 10, 20, 50, 100, 200, 500, 1000), RATIO, x_log=True)
    cases = [("ems, mitc4", section("ems")), ("cm, solid-shell", section("cm")), ("ancf-full", section("ancf-full")), ("ems without ANS", section("ems", ans_shear=False))]
    plot.series = [Series(name, slenderness, [strip(s, keys) for s in slenderness]) for name, keys in cases]
    plot.series.append(Series("beam", slenderness, [beam(s) for s in slenderness]))
    fine = [5 * 10 ** (i / 20) for i in range(47)]
    plot.series.append(Series("1/(1 + kGl²/Eh²)", fine, [1 / (1 + 5 / 12 * (s / n) ** 2) for s in fine], marked=False))
    return plot


def square(p: Program) -> Plot:
    """Square cantilever plate, ν = 0.3, 8 × 8 elements; Reissner–Mindlin plate by a p-version of order 8."""
    with open(ROOT / "verification" / "reference" / "plate_converged.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    exact = {round(1 / float(row["H_m"])): -float(row["uz_corner_m"]) for row in rows if row["order"] == "8"}
    slenderness = sorted(exact)

    def ratio(s: float, keys: Model) -> float:
        model = base(plate([1.0, 1.0], [8, 8]), keys, isotropic(0.3, 2.1e11), 1 / s, "u_max_v_min")
        model["conditions"] = [{"type": "clamp", "on": "u_min"}]
        model["loads"] = [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, 5e7 / s**3]}]
        return p.moved("square", model, 2) / exact[s]

    plot = Plot("Square cantilever plate of 8 × 8 elements, ν = 0.3", "length over thickness L/h", "deflection over exact", ticks(10, 100, 1000), RATIO, x_log=True)
    cases = [("ems, mitc4", section("ems")), ("cm, solid-shell", section("cm")), ("cm without thickness EAS", section("cm", thickness_eas=0)), ("ancf-full", section("ancf-full")), ("ems without ANS", section("ems", ans_shear=False))]
    plot.series = [Series(name, slenderness, [ratio(s, keys) for s in slenderness]) for name, keys in cases]
    return plot


def thickness(p: Program) -> Plot:
    """Strip bent into a cylinder: deflection of plate theory, F L³/(3 D) and the shear with k = 5/6."""
    numbers, n, h = [0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49], 16, 0.01

    def strip(nu: float, keys: Model) -> float:
        model = base(plate([1.0, 1 / n], [n, 1]), keys, isotropic(nu), h, "u_max_v_min")
        model["conditions"] = [{"type": "clamp", "on": "u_min"}, *({"type": "symmetry", "on": on, "normal": [0.0, 1.0, 0.0]} for on in ("v_min", "v_max"))]
        model["loads"] = [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, h**3]}]
        exact = (4 * (1 - nu * nu) + 2.4 * (1 + nu) * h * h) / YOUNG
        return p.moved("thickness", model, 2) / exact

    plot = Plot("Poisson thickness locking: strip bent into a cylinder", "Poisson's ratio ν", "deflection over exact", ticks(0, 0.1, 0.2, 0.3, 0.4, 0.5), RATIO)
    cases = [("ems, mitc4", section("ems")), ("cm, solid-shell", section("cm")), ("cm without thickness EAS", section("cm", thickness_eas=0)), ("ancf-full", section("ancf-full"))]
    plot.series = [Series(name, numbers, [strip(nu, keys) for nu in numbers]) for name, keys in cases]
    fine = [0.005 * i for i in range(100)]
    plot.series.append(Series("(1 − 2ν)/(1 − ν)²", fine, [(1 - 2 * v) / (1 - v) ** 2 for v in fine], marked=False))
    return plot


def arch_exact(slenderness: float) -> float:
    """Castigliano's deflection of a quarter circle R = 1, ν = 0, under a force h³ per width along the tangent of the clamped end."""
    return math.pi / (4 * YOUNG) * (12 + 3.4 / slenderness**2)


def arch(p: Program, name: str, s: float, mesh: Model, keys: Model, root: str, tip: str, loads: Callable[[float], list[Model]]) -> float:
    model = base(mesh, keys, isotropic(0.0), 1 / s, tip)
    model["conditions"] = [{"type": "clamp", "on": root}]
    model["loads"] = loads(s**-3)
    return -p.moved(name, model, 2) / arch_exact(s)


def cylinder(n: int) -> Model:
    return {"type": "cylinder", "radius": 1.0, "angles": [0.0, 90.0], "start": [1.0, 0.0, 0.0], "axis": [0.0, 1.0, 0.0], "length": 0.25, "grid": {"elements": [n, 1]}}


def curvature(p: Program) -> Plot:
    """Quarter arch of eight elements; Castigliano's theorem."""
    slenderness = [5, 10, 20, 50, 100, 200, 500, 1000]

    def ratio(s: float, keys: Model) -> float:
        return arch(p, "curvature", s, cylinder(8), keys, "u_min", "u_max_v_min", lambda f: [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -f]}])

    plot = Plot("Curvature thickness locking: quarter arch of 8 elements", "radius over thickness R/h", "deflection over exact", ticks(5, 10, 20, 50, 100, 200, 500, 1000), RATIO, x_log=True)
    cases = [("ems", section("ems")), ("cm, solid-shell", section("cm")), ("mitc4", section("mitc4")), ("ems without ANS thickness", section("ems", ans_thickness=False)), ("cm without ANS thickness", section("cm", ans_thickness=False)), ("ancf-full", section("ancf-full"))]
    plot.series = [Series(name, slenderness, [ratio(s, keys) for s in slenderness]) for name, keys in cases]
    return plot


def folds(p: Program) -> Plot:
    """Quarter arch as a polygon of strips; Castigliano's theorem for the circle and for the polygon."""
    meshes, s, width = [2, 3, 4, 6, 8, 12, 16], 100.0, 0.25

    def polygon(n: int, **keys: object) -> Model:
        def at(i: int, j: int) -> list[float]:
            angle = 0.5 * math.pi * i / n
            return [math.cos(angle), width * j, -math.sin(angle)]

        return arrays(n, 1, at, **keys)

    def ratio(n: int, mesh: Model) -> float:
        return arch(p, "folds", s, mesh, section("ems"), "root", "tip 0", lambda f: shared([0.0, 0.0, -f * width], 1))

    def exact_normals(n: int) -> float:
        return arch(p, "folds", s, cylinder(n), section("ems"), "u_min", "u_max_v_min", lambda f: [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -f]}])

    def closed(n: int) -> float:
        """Bending of the polygon: integral of the squared moment arm along its sides, over that of the circle, π/4."""
        total = 0.0
        for i in range(n):
            a, b = (math.cos(0.5 * math.pi * k / n) for k in (i, i + 1))
            side = 2 * math.sin(0.25 * math.pi / n)
            total += side * (a * a + a * b + b * b) / 3
        return total / (math.pi / 4)

    plot = Plot("Folds and normals: quarter arch, R/h = 100", "elements along the arch", "deflection over exact", ticks(2, 3, 4, 6, 8, 12, 16), ticks(0.7, 0.8, 0.9, 1.0, 1.1), x_log=True)
    plot.series = [
        Series("normals of the circle", meshes, [exact_normals(n) for n in meshes]),
        Series("from facets, folds from 20°", meshes, [ratio(n, polygon(n)) for n in meshes]),
        Series("from facets, fold_angle = 180", meshes, [ratio(n, polygon(n, fold_angle=180)) for n in meshes]),
        Series("polygon of rigid corners", meshes, [closed(n) for n in meshes], marked=False),
    ]
    return plot


PARTS = ["stable-eas", "mitc4+", "assumed-shear", "displacement"]


def membrane(p: Program) -> Plot:
    """Quarter cylinder of 8 × 8 elements, inner nodes moved by up to 0.3 of an element; Castigliano's theorem."""
    slenderness = [10, 20, 50, 100, 200, 500, 1000]

    def ratio(s: float, keys: Model, distortion: float) -> float:
        mesh = cylinder(8) | {"length": 1.0, "grid": {"elements": [8, 8], "distortion": distortion}}
        return arch(p, "membrane", s, mesh, keys, "u_min", "u_max_v_min", lambda f: [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -f]}])

    plot = Plot("Membrane locking: quarter cylinder, distorted mesh of 8 × 8", "radius over thickness R/h", "deflection over exact", ticks(10, 20, 50, 100, 200, 500, 1000), RATIO, x_log=True)
    cases = [("ems, not distorted", section("ems"), 0.0), ("ems, mitc4, stable-eas", section("ems"), 0.3), ("ems, mitc4+", section("ems", membrane="mitc4+"), 0.3), ("cm, solid-shell", section("cm"), 0.3), ("ancf-full", section("ancf-full"), 0.3)]
    plot.series = [Series(name, slenderness, [ratio(s, keys, distortion) for s in slenderness]) for name, keys, distortion in cases]
    return plot


SHAPES = {"rectangles": (0.0, 0.0), "parallelograms": (1.0, 1.0), "trapezoids": (1.0, -1.0)}


def slender(p: Program) -> Plot:
    """Beam 6 × 0.2 of MacNeal and Harder 1985, bent in its plane, 0.1081; six elements, each divided."""
    parts = [1, 2, 4, 8]

    def ratio(k: int, shape: str, keys: Model) -> float:
        even, odd = SHAPES[shape]

        def line(i: int, v: float) -> float:
            sign = 0.0 if i in (0, 6) else (even if i % 2 else odd)
            return i + sign * 0.1 * (2 * v - 1)

        def at(i: int, j: int) -> list[float]:
            v, (whole, part) = j / k, divmod(i, k)
            a, b = line(whole, v), line(min(whole + 1, 6), v)
            return [a + (b - a) * part / k, 0.2 * v, 0.0]

        model = base(arrays(6 * k, k, at), keys, isotropic(0.3), 0.1, "tip 0")
        model["conditions"] = [{"type": "clamp", "on": "root"}]
        model["loads"] = shared([0.0, 1.0, 0.0], k)
        return p.moved("slender", model, 1) / 0.1081

    plot = Plot("Bending in the plane: slender beam of MacNeal and Harder", "elements over the depth", "deflection over 0.1081", {k: str(k) for k in parts}, RATIO, x_log=True)
    for part in ("stable-eas", "displacement"):
        for shape in SHAPES:
            plot.series.append(Series(f"{shape}, {part}", parts, [ratio(k, shape, section("ems", membrane=part)) for k in parts]))
    return plot


def volume(p: Program) -> Plot:
    """Thick-walled cylinder of MacNeal and Harder 1985 in plane strain: radii 3 and 9, 10°, five elements; G. Lamé's solution."""
    numbers = [0.3, 0.45, 0.49, 0.499, 0.4999, 0.49999]
    radii, angle = [3.0, 3.5, 4.2, 5.2, 6.75, 9.0], math.radians(10.0)
    normals = [[math.sin(angle / 2), math.cos(angle / 2), 0.0], [math.sin(angle / 2), -math.cos(angle / 2), 0.0]]

    def ratio(nu: float, keys: Model) -> float:
        def at(i: int, j: int) -> list[float]:
            turn = angle * (j - 0.5)
            return [radii[i] * math.cos(turn), radii[i] * math.sin(turn), 0.0]

        model = base(arrays(5, 1, at), keys, isotropic(nu, 1000.0), 1.0, "root 1")
        model["conditions"] = [{"type": "symmetry", "on": on, "normal": n} for on, n in zip(["near", "far"], normals, strict=True)]
        model["conditions"].append({"type": "fix", "on": "all", "position": ["z"], "director": ["x", "y", "z"]})
        # A pressure of 1 on the chord between the two inner nodes.
        model["loads"] = [{"type": "force", "on": "root", "value": [3.0 * math.sin(angle / 2), 0.0, 0.0]}]
        exact = (1 + nu) * 9 / (1000.0 * 72) * ((1 - 2 * nu) * 3 + 27)
        return p.moved("volume", model, 0) / math.cos(angle / 2) / exact

    plot = Plot("Volumetric locking: thick cylinder in plane strain", "0.5 − ν", "displacement over exact", {1e-5: "10⁻⁵", 1e-4: "10⁻⁴", 1e-3: "10⁻³", 1e-2: "0.01", 0.1: "0.1", 1.0: "1"}, RATIO, x_log=True)
    plot.series = [Series(f"cm, {part}", [0.5 - nu for nu in numbers], [ratio(nu, section("cm", membrane=part)) for nu in numbers]) for part in PARTS]
    return plot


def block(p: Program) -> Plot:
    """Half of a block of rubber between smooth plates in plane strain; M. A. Biot: no loss of stability above 0.544."""
    meshes, push = [2, 4, 8], 0.48

    def stretch(n: int, keys: Model) -> float:
        law = {"type": "neo-hookean", "shear": 1.0, "bulk": 1000.0}
        model = base(plate([1.0, 1.0], [n, n]), keys, law, 1.0, "u_max_v_max", linear=False)
        model["analysis"] |= {"load_steps": 24, "max_cutbacks": 8}
        model["conditions"] = [
            {"type": "fix", "on": "all", "position": ["z"], "director": ["x", "y", "z"]},
            {"type": "fix", "on": "u_min", "position": ["x"]},
            {"type": "fix", "on": "v_min", "position": ["y"]},
            {"type": "prescribe", "on": "v_max", "component": "y", "value": -push},
        ]
        return 1 - push * p.reached("block", model)

    plot = Plot("Enhanced strains in compression: block of rubber", "elements along a side", "stretch at loss of stability", {n: str(n) for n in meshes}, ticks(0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0), x_log=True)
    plot.series = [Series(f"cm, {part}", meshes, [stretch(n, section("cm", membrane=part, thickness_eas=0)) for n in meshes]) for part in PARTS]
    plot.series.append(Series("surface of a half-space, 0.544", [2, 8], [0.5437, 0.5437], marked=False))
    return plot


def stretched(p: Program) -> Plot:
    """Clamped square, h = L/20, of n × 1 elements under an edge load; T. Sussman and K.-J. Bathe 2014: 1.2 over the aspect ratio."""
    ratios, strain, h = [2, 4, 8, 16, 32, 64], 0.1, 0.05

    def stable(n: int, keys: Model) -> float:
        model = base(plate([1.0, 1.0], [n, 1]), keys, isotropic(0.0, 1e6), h, "u_max_v_min", linear=False)
        model["analysis"]["load_steps"] = 10
        model["conditions"] = [{"type": "clamp", "on": "u_min"}]
        model["loads"] = [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, strain * 1e6 * h * h / 6]}]
        return strain * p.reached("stretched", model)

    plot = Plot("Enhanced strains in stretched elements", "aspect ratio of the elements", "fibre strain reached (load: 0.1)", {n: str(n) for n in ratios}, {0.01: "0.01", 0.02: "0.02", 0.05: "0.05", 0.1: "0.1", 0.2: "0.2"}, x_log=True, y_log=True)
    cases = [("ems, eas", section("ems", membrane="eas")), ("ems, mitc4+", section("ems", membrane="mitc4+")), ("ems, stable-eas", section("ems")), ("ems, displacement", section("ems", membrane="displacement"))]
    plot.series = [Series(name, ratios, [stable(n, keys) for n in ratios]) for name, keys in cases]
    plot.series.append(Series("1.2 over the aspect ratio", [6, 64], [0.2, 1.2 / 64], marked=False))
    return plot


def drilling(p: Program) -> Plot:
    """Strip 1 × 0.2 under a moment about its normal at the end; E. W. Bernoulli's beam, rotation M L/(E I)."""
    meshes, length, depth, h = [1, 2, 4, 8], 1.0, 0.2, 0.01
    exact = length / (YOUNG * h * depth**3 / 12)

    def rotation(n: int, load: str) -> float:
        model = base(plate([length, depth], [5 * n, n]), section("ems"), isotropic(0.0), h, "u_max_v_min")
        model["output"]["points"].append({"name": "top", "on": "u_max_v_max"})
        model["conditions"] = [{"type": "clamp", "on": "u_min"}]
        small = 1e-6
        if load == "edge-moment":
            model["loads"] = [{"type": "edge-moment", "on": "u_max", "value": [0.0, 0.0, small / depth]}]
        elif load == "couple":
            model["loads"] = [{"type": "force", "on": f"u_max_v_{end}", "value": [sign * small / depth, 0.0, 0.0]} for end, sign in [("min", 1.0), ("max", -1.0)]]
        else:
            model["analysis"]["linear"] = False
            model["bodies"] = [{"name": "end", "at": [length, depth / 2, 0.0], "attached": ["u_max"]}]
            model["loads"] = [{"type": "moment", "on": "end", "value": [0.0, 0.0, small]}]
        out = p.run("drilling", model)
        points = json.loads((out / "summary.json").read_text(encoding="utf-8"))["points"]
        return (points["tip"]["displacement"][0] - points["top"]["displacement"][0]) / depth / (exact * small)

    plot = Plot("Drilling: strip under a moment about its normal", "elements over the depth", "rotation of the end over exact", {n: str(n) for n in meshes}, ticks(0.8, 0.9, 1.0, 1.1, 1.2), x_log=True)
    cases = [("edge-moment on the edge", "edge-moment"), ("couple of forces at the corners", "couple"), ("moment on a rigid end", "body")]
    plot.series = [Series(name, meshes, [rotation(n, load) for n in meshes]) for name, load in cases]
    return plot


STUDIES: dict[str, Callable[[Program], Plot]] = {
    f.__name__: f for f in (shear, square, thickness, curvature, membrane, folds, slender, volume, block, stretched, drilling)
}
# Numbers in the text of the page: study, series, point of it, format.
QUOTED = [
    ("shear", "ems without ANS", 4, "{:.3f}"),
    ("square", "ancf-full", 2, "{:.2f} at L/h = 1000"),
    ("thickness", "cm without thickness EAS", 3, "{:.2f} of its deflection at ν = 0.3"),
    ("curvature", "ems without ANS thickness", 7, "{:.2f} of the deflection at R/h = 1000"),
    ("curvature", "ancf-full", 4, "{:.2f} at R/h = 100"),
    ("membrane", "ems, mitc4, stable-eas", 3, "{:.2f} of the deflection at R/h = 100"),
    ("membrane", "ems, mitc4, stable-eas", 6, "{:.2f} at R/h = 1000"),
    ("membrane", "ems, mitc4+", 6, "`mitc4+` has {:.2f}"),
    ("folds", "from facets, folds from 20°", 0, "{:.2f} with folds"),
    ("folds", "from facets, fold_angle = 180", 0, "{:.2f} with `fold_angle = 180`"),
    ("folds", "normals of the circle", 0, "{:.2f} with the normals of the circle"),
    ("slender", "trapezoids, stable-eas", 0, "{:.2f} with trapezoids"),
    ("slender", "trapezoids, stable-eas", 1, "{:.2f} on two elements"),
    ("slender", "parallelograms, stable-eas", 0, "{:.2f} with parallelograms"),
    ("slender", "rectangles, displacement", 0, "{:.2f} with rectangles"),
    ("volume", "cm, displacement", 3, "{:.2f} of the displacement at ν = 0.499"),
    ("block", "cm, stable-eas", 2, "{:.2f} with `stable-eas`"),
    ("block", "cm, mitc4+", 2, "{:.2f} with `mitc4+`"),
    ("block", "cm, assumed-shear", 2, "{:.2f} with `assumed-shear`"),
    ("stretched", "ems, eas", 4, "{:.3f} at an aspect ratio of 32"),
    ("drilling", "edge-moment on the edge", 3, "{:.2f} of the rotation"),
]
# Numbers of figures may differ by round-off of another processor; ends of unstable paths by a cut-back step.
TOLERANCE = 2e-3


def same(shown: dict, fresh: dict) -> bool:
    """True if all coordinates agree; never for NaN."""
    if shown.keys() != fresh.keys():
        return False
    pairs = [(a, b) for name in shown for p, q in zip(shown[name], fresh[name], strict=True) for a, b in zip(p, q, strict=True)]
    return all(abs(a - b) <= TOLERANCE * max(1e-3, abs(a)) for a, b in pairs)


def missing(study: str, plot: Plot) -> list[str]:
    """Numbers of a study that the page does not have as they are."""
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    values = {s.name: s.y for s in plot.series}
    wanted = [form.format(values[name][point]) for owner, name, point, form in QUOTED if owner == study]
    return [f"{PAGE.name}: not found: {text}" for text in wanted if text not in page]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("studies", nargs="*", metavar="STUDY")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--models", type=Path)
    options = parser.parse_args()
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.models or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        program = Program(options.program.resolve(), folder.resolve())
        for name in options.studies or STUDIES:
            plot = STUDIES[name](program)
            file = PICTURES / f"{name}.svg"
            print(f"{plot.title}: {plot.y_label}")
            for s in plot.series:
                if s.marked:
                    print(f"  {s.name:34}" + " ".join(f"{y:8.4f}" for y in s.y))
            if not options.check:
                PICTURES.mkdir(parents=True, exist_ok=True)
                file.write_text(svg(plot, f"scripts/element_guide.py, study {name}"), encoding="utf-8")
            elif not same(kept(file), plot.numbers()):
                failed.append(f"{file.relative_to(ROOT)}: shows other numbers")
            failed += missing(name, plot)
    if failed:
        sys.exit("\n".join(failed))


if __name__ == "__main__":
    main()
