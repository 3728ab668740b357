"""Writes the gallery of the examples, `book/src/gallery.md` with its pictures, from runs of all examples.

Usage: python3 scripts/gallery.py PROGRAM [EXAMPLE ...]; with names it draws only the pictures of these, and leaves the page.
       python3 scripts/gallery.py --check fails where an example or a picture is missing in the page; it runs nothing.
"""

import csv
import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
PAGE = ROOT / "book" / "src" / "gallery.md"
PICTURES = ROOT / "book" / "src" / "pictures" / "gallery"
LARGEST = 62_000  # bytes of a picture
HEAD = """# Gallery of examples

Every model of the folder `examples` with a picture, the number that it is compared with, and the time that it takes at most on two cores, with all files and pictures of the run.
`tegula run examples/NAME` computes it; the comments at its head have a sketch and the formulas, and a test compares it with the expected number. `scripts/gallery.py` writes this page.
"""


class Result:
    """Result folder of a run, or of one of its steps."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))

    def step(self, name: str) -> "Result":
        return Result(self.folder / name)

    def table(self, name: str) -> dict[str, list[float]]:
        """Columns of numbers of a table; words become NaN."""

        def number(text: str) -> float:
            try:
                return float(text)
            except ValueError:
                return math.nan

        with open(self.folder / name, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        return {column: [number(row[column]) for row in rows] for column in rows[0]}

    def column(self, name: str) -> list[float]:
        return self.table("history.csv")[name]

    def last(self, name: str) -> float:
        return self.column(name)[-1]

    def moved(self, point: str, axis: int) -> float:
        return self.summary["points"][point]["displacement"][axis]

    def critical(self, kind: str) -> list[float]:
        """Load factors of the critical points of a kind, in the order of the path."""
        return [p["load_factor"] for p in self.summary["critical_points"] if p["kind"] == kind]


@dataclass
class Entry:
    """One example: its picture, what it shows, and its number."""

    file: str
    # File of the result folder, or None: drawn by `tegula render` with these options.
    picture: str | None
    options: list[str]
    shows: str
    quantity: str
    expected: str
    source: str
    computed: Callable[[Result], float]
    form: str
    # Folder of the step that is drawn.
    step: str = ""
    size: str = "640,400"

    @property
    def stem(self) -> str:
        return Path(self.file).stem

    @property
    def title(self) -> str:
        text = (EXAMPLES / self.file).read_text(encoding="utf-8")
        patterns = {"toml": r'^title = "(.*)"$', "inp": r"^\*HEADING\n(.*)$", "bdf": r"^TITLE = (.*)$"}
        return re.search(patterns[self.file.rpartition(".")[2]], text, re.M)[1]


def crossing(x: list[float], y: list[float], value: float) -> float:
    """First x at which y, linear between rows, has a value."""
    for i in range(1, len(x)):
        if (y[i - 1] - value) * (y[i] - value) <= 0 and y[i] != y[i - 1]:
            return x[i - 1] + (x[i] - x[i - 1]) * (value - y[i - 1]) / (y[i] - y[i - 1])
    return math.nan


def bimetal_radius(r: Result) -> float:
    x, z = 0.1 + r.moved("tip", 0), r.moved("tip", 2)
    return 1e3 * 0.5 * math.hypot(x, z) / math.sin(math.atan2(z, x))


def bow_of_coupler(r: Result) -> float:
    """Largest distance of C from its place in the rigid linkage."""
    h = r.table("history.csv")
    most = 0.0
    for i, t in enumerate(h["time"]):
        angle = 2 * math.pi * t - math.sin(2 * math.pi * t)
        b = (-0.2 * math.sin(angle), 0.2 * math.cos(angle))
        dx, dy = 0.8 - b[0], -0.4 - b[1]
        d = math.hypot(dx, dy)
        along = (d * d + 0.8**2 - 0.6**2) / (2 * d)
        across = math.sqrt(0.8**2 - along**2)
        c = (b[0] + (along * dx - across * dy) / d, b[1] + (along * dy + across * dx) / d)
        most = max(most, math.hypot(h["body.C.x"][i] - c[0], h["body.C.y"][i] - c[1]))
    return 1e3 * most


def wing_moment(r: Result) -> float:
    """Largest deviation of the moment of the drive from that of a rigid wing, in per cent of the largest moment, in the last half of the motion."""
    h = r.table("history.csv")
    mass = 0.5 * 0.15 * 2 * (2.5e-4 * 1600 + 5e-3 * 60)
    inertia = mass * 0.25 / 3
    times, drive = h["time"], h["joint.drive.my"]

    def angle(t: float) -> float:
        return math.radians(40) * (1 - math.exp(-((t / 0.2) ** 4))) * math.sin(2 * math.pi * 4 * t)

    pairs = []
    for i in range(1, len(times)):
        # Reactions are means over a step.
        t, dt = 0.5 * (times[i] + times[i - 1]), 1e-4
        if t > 0.5:
            acceleration = (angle(t + dt) - 2 * angle(t) + angle(t - dt)) / dt**2
            rigid = inertia * acceleration + mass * 9.81 * 0.25 * math.cos(angle(t))
            pairs.append((-drive[i], rigid))
    largest = max(abs(rigid) for _, rigid in pairs)
    return 100 * max(abs(a - b) for a, b in pairs) / largest


def fold_moment(r: Result) -> float:
    """Mean moment of both drives over both ways between 60 and 160 degrees, in mN m."""
    h = r.table("history.csv")
    turn = [180 * math.sin(math.pi * (t / 4 + t * t / 8) / 3) ** 2 for t in h["time"]]
    ways = [[0.0, 0.0], [0.0, 0.0]]
    for i in range(1, len(turn)):
        if all(60 <= a < 160 for a in turn[i - 1 : i + 1]):
            way, step = ways[turn[i] < turn[i - 1]], abs(turn[i] - turn[i - 1])
            way[0] += 0.5 * (h["joint.drive left.my"][i] - h["joint.drive right.my"][i]) * step
            way[1] += step
    return 1e3 * sum(0.5 * work / angle for work, angle in ways)


def plateau_moment(r: Result) -> float:
    """Mean moment between 60 and 160 degrees along the path, in mN m."""
    turn, moment = r.column("time"), r.column("joint.drive.my")
    rows = [i for i in range(1, len(turn)) if turn[i - 1] > 0.25 and turn[i] < 0.9]
    way = sum(turn[i] - turn[i - 1] for i in rows)
    return 1e3 * sum(0.5 * (moment[i] + moment[i - 1]) * (turn[i] - turn[i - 1]) for i in rows) / way


def leaf_rate(r: Result) -> float:
    def height(step: str) -> float:
        h = r.step(step)
        return h.last("body.chassis.z") - h.last("body.axle.z")

    return 1e-3 * 200 / (height("1-weight") - height("2-payload"))


def freudenstein(r: Result) -> float:
    """Largest deviation of the rocker from Freudenstein's equation, in degrees."""
    a, b, c, d = 0.10, 0.35, 0.30, 0.40
    worst = 0.0
    for phi, psi in zip(map(math.radians, r.column("sensor.crank.angle")), map(math.radians, r.column("sensor.rocker.angle")), strict=True):
        psi += math.pi / 2
        diagonal = math.sqrt(a * a + d * d - 2 * a * d * math.cos(phi))
        # The rocker, seen from C: the line to A, and the angle of the triangle A, B, C.
        to_a = math.atan2(a * math.sin(phi), a * math.cos(phi) - d)
        inside = math.acos((c * c + diagonal**2 - b * b) / (2 * c * diagonal))
        error = (psi - (to_a - inside) + math.pi) % (2 * math.pi) - math.pi
        worst = max(worst, abs(math.degrees(error)))
    return worst


def driven_slider(r: Result) -> float:
    """Largest deviation of the slider from the length of the rod, in metres."""
    worst = 0.0
    for t, x in zip(r.column("time"), r.column("body.slider.x"), strict=True):
        phi = 2 * math.pi * t
        y, z = 0.1 - 0.08 * math.sin(phi), 0.12 + 0.08 * math.cos(phi)
        worst = max(worst, abs(x - math.sqrt(0.09 - y * y - z * z)))
    return worst


def rotor(r: Result) -> float:
    """Lowest bending frequency at 60 rad/s in the fixed frame, in rad/s."""
    table = r.table("campbell.csv")
    return min(w for s, w in zip(table["speed"], table["fixed_frame_omega"], strict=True) if s == 60.0 and w > 0)


def water_moment(r: Result) -> float:
    return -1e-3 * r.summary["supports"]["bottom"]["moment"][1] / (2 * 9.144 * math.sin(math.radians(5)))


def resonance(r: Result) -> float:
    table = r.table("frequency_response.csv")
    low = [(a, f) for f, a in zip(table["frequency_hz"], table["tip.uz/force.amplitude"], strict=True) if 10 < f < 22]
    return min(low)[1]


MESHES = "Plates and shells in equilibrium"
PATHS = "Buckling and equilibrium paths"
MODES = "Natural frequencies"
MOTION = "Shells in motion"
MACHINES = "Shells in mechanisms"
BODIES = "Rigid bodies and joints"

SECTIONS: dict[str, list[Entry]] = {
    MESHES: [
        Entry("cantilever_plate.toml", None, ["--field", "displacement.z", "--scale", "200"],
              "A square plate, clamped at one edge, under a force along the opposite edge: the simplest model. The free edge is not straight, because the plate curves across its length. The picture enlarges the deflection 200 times.",
              "deflection of the free corner", "−0.88076 mm", "an independent program and OpenSees on the same mesh; Valkeapää and others, Nonlinear Dynamics 80 (2015), Sect. 5.1",
              lambda r: 1e3 * r.moved("corner", 2), "{:.5f} mm", size="480,300"),
        Entry("quarter_cylinder_static.toml", None, [],
              "A corner force bends a thin quarter cylinder far beyond the linear range, in one load step.",
              "vertical displacement of the corner", "−1.19624 m", "an independent program; Valkeapää and others 2015, Sect. 5.2",
              lambda r: r.moved("corner", 2), "{:.5f} m", size="540,340"),
        Entry("composite_plate.toml", None, ["--field", "tsai_wu", "--view", "-60,45"],
              "A laminate [0/90]s under a uniform load, with stresses and failure indices of its plies; the picture shows the Tsai–Wu index.",
              "deflection of the middle", "0.10250 mm", "Navier's series by first-order theory: J. N. Reddy, Mechanics of Laminated Composite Plates and Shells, 2004",
              lambda r: 1e3 * r.moved("middle", 2), "{:.5f} mm", size="480,300"),
        Entry("bimetal_strip.toml", "snapshots.png", [],
              "Two bonded foils of brass and invar curl when they are heated: thermal strain, a layup and a large rotation.",
              "radius of the strip", "75.30 mm", "S. Timoshenko, J. Opt. Soc. Am. 11 (1925) 233–255",
              bimetal_radius, "{:.2f} mm"),
        Entry("yielding_strip.toml", "snapshots.png", [],
              "A steel strip is bent to four times the curvature at which it yields. Plastic zones grow from both faces and leave an elastic core.",
              "strain energy and dissipation at the end", "48.18 mJ", "moment of an elastic, ideally plastic rectangle",
              lambda r: r.last("strain") + r.last("dissipated"), "{:.2f} mJ"),
        Entry("water_tank.toml", None, ["--field", "bending.2", "--scale", "3000", "--view", "-30,12"],
              "A sector of a concrete tank under the pressure of water, which grows with the depth: sets by place, and a load with a distribution.",
              "clamping moment at the bottom", "62.10 kN m/m", "S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, 1959, § 117",
              water_moment, "{:.2f} kN m/m"),
        Entry("tube_torque.toml", None, ["--field", "displacement", "--scale", "100", "--view", "-60,45"],
              "A distributing coupling puts a torque on the free end of a thin tube without making it rigid.",
              "twist of the end", "0.2258° (circle) to 0.2284° (polygon with 32 corners)", "R. Bredt's torsion constant of closed thin sections",
              lambda r: r.last("sensor.twist.angle"), "{:.4f}°"),
        Entry("ribbed_strip.toml", None, ["--field", "membrane.1", "--scale", "60", "--view", "-60,20"],
              "A beam along a line of the mesh stiffens a strip: its cross-sections carry the nodes of the shell. A strain gauge is on the upper face.",
              "deflection of the end", "2.2120 mm, without shear", "the cantilever with the T-section",
              lambda r: -1e3 * r.moved("end", 2), "{:.4f} mm"),
        Entry("box_beam.bdf", None, ["--field", "displacement", "--scale", "40"],
              "A bulk data file of Nastran: four sheets that meet at right angles, a rigid end (RBE2), and a torque. The picture enlarges the displacements 40 times.",
              "displacement of a corner of the end along y", "0.3095 mm, from a rotation of 6.190·10⁻³ rad at 50 mm", "R. Bredt's formula for closed thin sections",
              lambda r: 1e3 * r.moved("node 401", 1), "{:.4f} mm", size="540,340"),
        Entry("sze_cantilever.inp", None, ["--view", "-50,25"],
              "An input file of Abaqus and CalculiX: a strip under a shear force, which bends it by two thirds of its length.",
              "displacement of the end along z", "6.698", "K. Y. Sze, X. H. Liu, S. H. Lo, Finite Elem. Anal. Des. 40 (2004) 1551–1569",
              lambda r: next(iter(r.summary["points"].values()))["displacement"][2], "{:.3f}"),
    ],
    PATHS: [
        Entry("plate_buckling.toml", None, ["--field", "displacement.z", "--mode", "2"],
              "Linear buckling of a simply supported square plate under compression. The second mode has two half waves along the load.",
              "first load factor", "4 for a thin plate, 3.998 with shear", "G. H. Bryan, Proc. London Math. Soc. 22 (1890) 54–67",
              lambda r: r.summary["load_factors"][0], "{:.4f}", size="480,300"),
        Entry("hinged_roof_path.toml", "load_displacement.png", [],
              "The equilibrium path of a hinged roof turns back in load and in deflection. A path follows it by power series.",
              "first limit load", "586.77 N", "an independent program; benchmark of Sze, Liu and Lo 2004, Sect. 3.6",
              lambda r: 3000 * r.critical("limit")[0], "{:.2f} N"),
        Entry("arch_branches.toml", "load_displacement.png", [],
              "All equilibria of a shallow arch: the path of symmetric shapes, and the paths of asymmetric shapes that connect its two bifurcations.",
              "load factor of the first bifurcation", "0.4036", "Y.-L. Pi, M. A. Bradford, B. Uy, Int. J. Solids Struct. 39 (2002) 105–125",
              lambda r: r.critical("bifurcation")[0], "{:.4f}"),
        Entry("arch_snap.toml", "point_top.png", [],
              "A static analysis leads a thicker arch to its limit point. A push of 1 % makes it snap, and the motion ends in the equilibrium beyond the snap.",
              "limit load", "7.385 N/m²", "Pi, Bradford and Uy 2002",
              lambda r: 10 * r.step("1-to_the_limit_point").critical("limit")[0], "{:.3f} N/m²", step="2-snap"),
        Entry("von_mises_truss.toml", "load_displacement.png", [],
              "A body on a vertical slide between two springs snaps through. Power series follow the path, in which the inverse lengths of the springs are series, too.",
              "first limit load factor", "1", "closed form: the load is scaled with the limit load of two springs",
              lambda r: r.critical("limit")[0], "{:.6f}"),
        Entry("lee_frame.toml", "load_displacement.png", [],
              "Two beams that are welded at a right angle snap through. Power series follow the path with the constraints of beams and joints, one factorisation a step.",
              "limit load", "1.85 kN", "S. L. Lee, F. S. Manuel, E. C. Rossow, J. Eng. Mech. Div. ASCE 94 (1968) 521–547; J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79–116",
              lambda r: r.critical("limit")[0], "{:.3f} kN"),
        Entry("tape_spring_path.toml", None, ["--view", "-30,20"],
              "A tape spring snaps into a fold when its end is turned, and the fold grows under a constant moment. The path contains the unstable equilibria between.",
              "mean moment of the fold", "32.66 mN m for a fold that is a part of a cylinder; the edges of the tape curl and need less", "W. Wüst, ZAMM 34 (1954) 444–454; K. A. Seffen, S. Pellegrino, Proc. R. Soc. Lond. A 455 (1999) 1003–1048",
              plateau_moment, "{:.2f} mN m"),
    ],
    MODES: [
        Entry("free_plate_modes.toml", None, ["--field", "displacement.z", "--mode", "9"],
              "A free square plate has six rigid modes and then its elastic ones. The picture shows the third elastic mode.",
              "first elastic frequency", "2.14138 Hz", "an independent program on the same mesh; 2.1435 Hz for thin plates; Valkeapää and others 2015, Sect. 5.3",
              lambda r: r.summary["frequencies_hz"][6], "{:.5f} Hz", size="480,300"),
        Entry("preloaded_plate.toml", None, ["--field", "displacement.z"],
              "Four analyses in one model: a plate is stretched, its modes about the stretched state are computed, it is bent by a pressure, and it vibrates when the pressure is removed.",
              "first frequency of the stretched plate", "104.0 Hz", "A. W. Leissa, Vibration of Plates, NASA SP-160, 1969, Sect. 10.1",
              lambda r: r.step("2-modes").summary["frequencies_hz"][0], "{:.1f} Hz", step="2-modes", size="520,325"),
        Entry("frequency_response.toml", "frequency_response.png", [],
              "The response of a cantilever to a harmonic force at its tip, with modal damping. Residual vectors carry the modes that are not computed.",
              "anti-resonance between the first two resonances", "18.4 Hz", "receptance of a Bernoulli beam",
              resonance, "{:.1f} Hz"),
        Entry("rotor_campbell.toml", "campbell.png", [],
              "The Campbell diagram of an elastic shaft with a disc. Gyroscopic moments split the modes in which the disc tilts.",
              "lowest bending frequency at 60 rad/s", "56.85 rad/s", "O. Bauchau and others, Multibody Syst. Dyn. 37 (2016) 29–48",
              rotor, "{:.2f} rad/s"),
    ],
    MOTION: [
        Entry("quarter_cylinder_pendulum.toml", None, ["--at", "0.4", "--view", "-50,20"],
              "A soft curved shell, held at one corner by a spherical joint, falls and swings under its weight.",
              "height of the opposite corner at 0.4 s", "0.058 m on a mesh of 32 × 32, on this one within 5 mm", "an independent program; Valkeapää and others 2015, Sect. 5.4",
              lambda r: crossing(r.column("opposite.z"), r.column("time"), 0.4), "{:.3f} m", size="600,375"),
        Entry("stress_wave.toml", "point_middle.png", [],
              "A sudden tension at the end of a strip travels along it with the speed of sound, computed by explicit steps. The picture shows the middle, which rests until the front arrives at 97 µs.",
              "displacement of the end at the end of the run", "0.5952 mm", "d'Alembert's solution; K. F. Graff, Wave Motion in Elastic Solids",
              lambda r: 1e3 * r.moved("end", 0), "{:.4f} mm"),
    ],
    MACHINES: [
        Entry("hub_pendulum.toml", None, ["--at", "0.5", "--view", "-70,50"],
              "A plate is attached to a rigid hub, which turns on a hinge along the normal of the plate. It swings in its plane like a rigid pendulum.",
              "x coordinate of the tip after half a period", "−1 m", "elliptic integral of a physical pendulum",
              lambda r: r.last("tip.x"), "{:.5f} m"),
        Entry("flexible_four_bar.toml", None, ["--field", "tsai_wu", "--at", "0.64", "--view", "-80,60"],
              "A linkage with a laminated coupler, whose plies have stresses and failure indices, turns once.",
              "largest distance of C from its place in the rigid linkage", "the shortening by the bow, below 0.1 mm", "closed form of the rigid linkage",
              bow_of_coupler, "{:.3f} mm"),
        Entry("flapping_wing.toml", None, ["--at", "0.48", "--view", "-60,50"],
              "A sandwich wing, whose root is a rigid patch on a driven hinge, flaps up and down four times a second.",
              "largest difference between the moment of the drive and that of a rigid wing", "below 1 % of the largest moment", "magnification by the first mode of the clamped wing, 0.5 %",
              wing_moment, "{:.2f} %"),
        Entry("leaf_spring_axle.toml", None, ["--view", "-60,15"],
              "An axle on two leaf springs from a Gmsh mesh: under the weight of the chassis, under a payload, and bouncing.",
              "rate of the four half leaves", "41.15 kN/m", "beam of linear width; the seats make the leaves 0.8 % stiffer",
              leaf_rate, "{:.2f} kN/m", step="1-weight"),
        Entry("tape_spring.toml", None, ["--at", "2.0", "--view", "-60,15"],
              "Two drives fold a tape spring and unfold it again. It snaps into the fold, which grows under a constant moment, and out of it.",
              "mean moment of the drives between 60° and 160°", "20.43 mN m", "least energy of a fold with curled edges, after W. Wüst 1954 and Seffen and Pellegrino 1999",
              fold_moment, "{:.2f} mN m"),
    ],
    BODIES: [
        Entry("slider_crank.toml", None, ["--at", "2.0", "--view", "-60,25"],
              "A spatial slider-crank moves freely under its weight: a crank on a hinge, a rod on a spherical and a universal joint, and a slider.",
              "position of the slider at 5 s", "0.24076 m", "IFToMM library of computational benchmarks, reference solution by F. Gonzalez",
              lambda r: r.last("body.slider.x"), "{:.5f} m"),
        Entry("spatial_slider_crank.toml", None, ["--at", "0.15", "--view", "-40,20"],
              "A kinematic analysis of this mechanism with a prescribed rotation gives its motion and the forces that it needs, without integration.",
              "largest deviation of the slider from the length of its rod", "0", "closed form",
              driven_slider, "{:.0e} m"),
        Entry("assembled_four_bar.toml", None, ["--at", "0.2", "--view", "-80,55"],
              "A four-bar linkage whose parts are drawn apart. The program assembles it, and a motor drives it once round.",
              "largest deviation of the angle of the rocker", "0", "Freudenstein's equation",
              freudenstein, "{:.0e}°"),
        Entry("door.toml", "snapshots.png", [],
              "A door with friction in its hinge bounces off a stop and comes to rest.",
              "angle at which the door stands", "51.346°", "energy balance of the friction torque and of the impact",
              lambda r: r.last("joint.hinge.angle"), "{:.3f}°"),
        Entry("gear_train.toml", "energy.png", [],
              "A motor drives a drum through two stages of gears. The bodies have no shapes, so the picture shows the energies.",
              "turns of the motor in 1 s", "5.585", "reduced moment of inertia",
              lambda r: r.last("sensor.motor.angle") / 360, "{:.3f}"),
        Entry("rack_and_pinion.toml", "energy.png", [],
              "A moment turns a pinion, whose teeth push a rack along its guide.",
              "way of the rack in 1 s", "0.6 m", "mass and moment of inertia of both",
              lambda r: r.last("body.rack.x"), "{:.5f} m"),
        Entry("lead_screw.toml", "energy.png", [],
              "A nut falls along a screw and turns: the potential energy becomes kinetic energy of the fall and of the rotation.",
              "height after 2 s", "−2.206 m", "mass and moment of inertia of the nut",
              lambda r: r.last("body.nut.z"), "{:.3f} m"),
        Entry("tautochrone.toml", "energy.png", [],
              "Two beads slide along cycloid wires. From whatever height they start, they reach the lowest point at the same time.",
              "time at which the higher bead passes the lowest point", "1.0030 s", "C. Huygens, Horologium oscillatorium, 1673",
              lambda r: crossing(r.column("time"), r.column("body.high.x"), 0.0), "{:.4f} s"),
    ],
}  # fmt: skip


def entries() -> list[Entry]:
    return [entry for section in SECTIONS.values() for entry in section]


def rounded(seconds: float) -> str:
    """Time in whole seconds, below 1 s in tenths."""
    return f"{seconds:.0f} s" if seconds >= 1 else f"{max(seconds, 0.1):.1f} s"


def draw(program: Path, entry: Entry, result: Path) -> None:
    """The picture of an example."""
    folder, target = result / entry.step, PICTURES / f"{entry.stem}.png"
    if entry.picture:
        shutil.copyfile(folder / entry.picture, target)
    else:
        command = [program, "render", folder, "--out", target, "--size", entry.size, *entry.options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    if target.stat().st_size > LARGEST:
        sys.exit(f"{target}: {target.stat().st_size} bytes, more than {LARGEST}")


def compute(program: Path, entry: Entry, folder: Path, runs: int) -> float:
    """Runs an example; the least time of a few runs."""
    times = []
    for _ in range(runs):
        begin = time.monotonic()
        command = [program, "run", EXAMPLES / entry.file, "--out", folder, "--force", "--quiet", "--threads", "2"]
        run = subprocess.run(command, capture_output=True, text=True)
        times.append(time.monotonic() - begin)
        if run.returncode != 0:
            sys.exit(f"{entry.file}: {run.stderr}")
    return min(times)


def text_of(entry: Entry, value: str, seconds: float) -> str:
    """The part of the page about an example."""
    value = re.sub(r"-(?=\d)", "−", value)
    if power := re.fullmatch(r"(\d)e−(\d+)(.*)", value):
        value = f"{power[1]}·10{str(-int(power[2])).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}{power[3]}"
    return f"""### {entry.title}

![{entry.title}](pictures/gallery/{entry.stem}.png)

{entry.shows}

| `{entry.file}` | {entry.quantity} |
|---|---|
| expected | {entry.expected} ({entry.source}) |
| computed | {value} |
| time | {rounded(seconds)} |

"""


def write(program: Path, chosen: list[str]) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    if unknown := [name for name in chosen if name not in [e.stem for e in entries()]]:
        sys.exit(f"no examples: {', '.join(unknown)}")
    page = HEAD
    with tempfile.TemporaryDirectory() as temporary:
        for section, members in SECTIONS.items():
            page += f"\n## {section}\n\n"
            for entry in members:
                if chosen and entry.stem not in chosen:
                    continue
                result = Path(temporary) / entry.stem
                seconds = compute(program, entry, result, 1 if chosen else 3)
                draw(program, entry, result)
                number = entry.computed(Result(result))
                if not math.isfinite(number):
                    sys.exit(f"{entry.file}: the computed number is {number}")
                value = entry.form.format(number)
                print(f"{entry.stem}: {value}, expected {entry.expected}; {seconds:.2f} s", flush=True)
                page += text_of(entry, value, seconds)
                shutil.rmtree(result)
    if not chosen:
        PAGE.write_text(page.rstrip("\n") + "\n", encoding="utf-8")


def mistakes() -> list[str]:
    """Everything that is missing in the page, or too much."""
    page = PAGE.read_text(encoding="utf-8")
    models = {p.name for p in EXAMPLES.iterdir() if p.suffix in (".toml", ".inp", ".bdf")}
    known = {entry.file: entry for entry in entries()}
    found = [f"examples/{name} is missing in scripts/gallery.py" for name in sorted(models - known.keys())]
    found += [f"scripts/gallery.py names examples/{name}, which is not there" for name in sorted(known.keys() - models)]
    if not page.startswith(HEAD):
        found.append("the beginning of book/src/gallery.md is not that of scripts/gallery.py")
    for name in sorted(models & known.keys()):
        entry = known[name]
        picture = PICTURES / f"{entry.stem}.png"
        for part in [f"### {entry.title}\n", f"(pictures/gallery/{entry.stem}.png)", entry.shows, f"| `{name}` | {entry.quantity} |", f"| expected | {entry.expected} ({entry.source}) |"]:
            if part not in page:
                found.append(f"book/src/gallery.md: examples/{name} lacks {part.strip()!r}")
        if not picture.is_file() or not picture.read_bytes().startswith(b"\x89PNG"):
            found.append(f"{picture.relative_to(ROOT)} is missing")
        elif picture.stat().st_size > LARGEST:
            found.append(f"{picture.relative_to(ROOT)} has more than {LARGEST} bytes")
    shown = set(re.findall(r"\(pictures/gallery/([^)]+)\)", page))
    found += [f"book/src/pictures/gallery/{p.name} is not in the page" for p in sorted(PICTURES.glob("*")) if p.name not in shown]
    return found


def main() -> None:
    match sys.argv[1:]:
        case ["--check"]:
            found = mistakes()
            sys.exit("\n".join([*found, "write it anew: python3 scripts/gallery.py target/release/tegula"]) if found else 0)
        case [program, *chosen] if not program.startswith("-"):
            write(Path(program).resolve(), chosen)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
