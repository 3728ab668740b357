#!/usr/bin/env python3
"""Time and error of four rigid mechanisms of the verification, with steps that are as long as their gates allow.

    cargo build --release
    python3 benches/time_machines.py [target/release/tegula]

Prints the processor time of the whole process on one thread (the least of five runs), and the largest error of a position over
all reference values, each with its gate. The definitions are those of the verification manual (case `machines`); only the length
of the steps differs. The exit code is 1 where an error is beyond its gate; times are printed and not judged.
"""

import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
#: Model, step, gates: processor time (s), error of positions (length; of the squeezer 1e-4 rad at an arm of 0.02 m).
GATES = [
    ("pendulum", 1e-3, 0.2, 1e-4),
    ("squeezer", 5e-5, 0.2, 2e-6),
    ("bricard", 1e-2, 0.3, 1e-3),
    ("slider_crank", 5e-4, 0.5, 5e-5),
]
REPETITIONS = 5


def rotated(q, x):
    """Vector turned by a unit quaternion, scalar first."""
    w, *v = q
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    t = [2 * c for c in cross(v, x)]
    return [x[i] + w * t[i] + cross(v, t)[i] for i in range(3)]


def value(quantity, row, start):
    """Quantity of a history: a column, or `BODY@X Y Z.c`, component c of the point of a body that is at X Y Z at the start."""
    if "@" not in quantity:
        return float(row[quantity])
    body, rest = quantity.split("@")
    place, component = rest.rsplit(".", 1)
    centre = lambda r: [float(r[f"body.{body}.{c}"]) for c in "xyz"]
    arm = [float(x) - c for x, c in zip(place.split(), centre(start))]
    turned = rotated([float(row[f"body.{body}.q{i}"]) for i in range(4)], arm)
    i = "xyz".index(component)
    return centre(row)[i] + turned[i]


def run(program, text, folder):
    """Processor time of a run, and its history."""
    model = folder / "model.toml"
    model.write_text(text)
    before = os.times()
    command = [program, "run", model, "--out", folder / "out", "--threads", "1", "--quiet", "--force"]
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    time = after.children_user + after.children_system - before.children_user - before.children_system
    with open(folder / "out" / "history.csv", newline="", encoding="utf-8") as file:
        return time, list(csv.DictReader(file))


def main():
    """Print the table."""
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/tegula").resolve()
    with open(ROOT / "verification/reference/machines.csv", newline="", encoding="utf-8") as file:
        wanted = list(csv.DictReader(line for line in file if not line.startswith("#")))
    print("| machine | step | CPU s | gate | largest error | gate |\n|---|---:|---:|---:|---:|---:|")
    missed = False
    for name, step, most_time, most_error in GATES:
        text = (ROOT / f"verification/models/machines/{name}.toml").read_text(encoding="utf-8")
        text = re.sub(r"time_step = \S+", f"time_step = {step!r}", text)
        rows = [r for r in wanted if r["machine"] == name and ("@" in r["quantity"] or r["quantity"].startswith("body."))]
        rows = [r for r in rows if r["quantity"][-2:] in (".x", ".y", ".z")]
        with tempfile.TemporaryDirectory() as folder:
            runs = [run(program, text, pathlib.Path(folder)) for _ in range(REPETITIONS)]
        history = runs[0][1]
        error = 0.0
        for row in rows:
            at = min(history, key=lambda r: abs(float(r["time"]) - float(row["time_s"])))
            if not abs(float(at["time"]) - float(row["time_s"])) < 1e-9:
                raise SystemExit(f"{name}: no step ends at {row['time_s']} s")
            off = abs(value(row["quantity"], at, history[0]) - float(row["value"]))
            # NaN counts as the largest error.
            error = error if off <= error else off
        missed |= not error <= most_error
        time = min(time for time, _ in runs)
        print(f"| {name} | {step:g} s | {time:.3f} | {most_time} | {error:.1e} m | {most_error:.0e} m |")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
