#!/usr/bin/env python3
"""Errors of the integrators over the step, on the heavy top of the verification.

    cargo build --release
    python3 benches/order_of_schemes.py [target/release/tegula]

Writes the plot `book/src/pictures/heavy_top_order.svg` and prints the table: largest errors of positions (length) and of the angular
velocity in the body (rad/s) at 0.1, 0.2 and 0.5 s, against the reference values of the verification, and orders between the two
smallest steps of each scheme whose errors are above the digits of the reference.
"""

import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
STEPS = [2e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5]
SCHEMES = {
    "energy-momentum": '{ type = "energy-momentum" }',
    "energy-momentum, order 4": '{ type = "energy-momentum", order = 4 }',
    "generalized-alpha": '{ type = "generalized-alpha" }',
    "bdf2": '{ type = "bdf2" }',
}
COLOURS = ["#1f5fa8", "#b3261e", "#2e7d32", "#6a1b9a"]
QUANTITIES = {"position": ["body.top.x", "body.top.y", "body.top.z"], "angular velocity": ["body.top.w1", "body.top.w3"]}
#: Round-off of the reference values, which have eight decimals, with a margin.
DIGITS = 2e-8


def errors(program, step, scheme, wanted, folder):
    """Largest error of each quantity."""
    text = (ROOT / "verification/models/machines/heavy_top.toml").read_text(encoding="utf-8")
    text = re.sub(r"time_step = .*", f"time_step = {step!r}", text)
    text = re.sub(r"scheme = .*", f"scheme = {scheme}", text)
    model = folder / "model.toml"
    model.write_text(text, encoding="utf-8")
    command = [program, "run", model, "--out", folder / "out", "--quiet", "--force"]
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    with open(folder / "out" / "history.csv", newline="", encoding="utf-8") as file:
        history = list(csv.DictReader(file))
    out = []
    for columns in QUANTITIES.values():
        largest = 0.0
        for row in (row for row in wanted if row["quantity"] in columns):
            at = min(history, key=lambda r: abs(float(r["time"]) - float(row["time_s"])))
            if not abs(float(at["time"]) - float(row["time_s"])) < 1e-9:
                raise SystemExit(f"no step ends at {row['time_s']} s")
            off = abs(float(at[row["quantity"]]) - float(row["value"]))
            # NaN counts as the largest error.
            largest = largest if off <= largest else off
        out.append(largest)
    return out


def order(values):
    """Order between the two smallest steps with errors above the digits of the reference."""
    good = [(step, error) for step, error in zip(STEPS, values) if error > DIGITS]
    (a, first), (b, last) = good[-2:]
    return math.log(first / last) / math.log(a / b)


def plot(table):
    """Two plots of the errors over the step, as SVG."""
    width, height, left, top, gap = 330, 300, 60, 30, 90
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * width + left + gap + 20} {height + 110}" font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    steps = (math.log10(3e-5), math.log10(3e-3))
    for k, (title, (low, high)) in enumerate(zip(QUANTITIES, [(-9, 0), (-8, 2)])):
        x0 = left + k * (width + gap)
        x = lambda step: x0 + width * (math.log10(step) - steps[0]) / (steps[1] - steps[0])
        y = lambda error: top + height * (high - math.log10(error)) / (high - low)
        unit = ["m", "rad/s"][k]
        lines.append(f'<text x="{x0 + width / 2}" y="{top - 10}" text-anchor="middle">error of the {title} [{unit}]</text>')
        for decade in range(low, high + 1):
            at = y(10.0**decade)
            lines.append(f'<line x1="{x0}" y1="{at:.1f}" x2="{x0 + width}" y2="{at:.1f}" stroke="#ddd"/>')
            lines.append(f'<text x="{x0 - 6}" y="{at + 4:.1f}" text-anchor="end">10<tspan dy="-4" font-size="9">{decade}</tspan></text>')
        for step in (1e-4, 1e-3):
            at = x(step)
            lines.append(f'<line x1="{at:.1f}" y1="{top}" x2="{at:.1f}" y2="{top + height}" stroke="#ddd"/>')
            lines.append(f'<text x="{at:.1f}" y="{top + height + 18}" text-anchor="middle">{step * 1e3:g} ms</text>')
        lines.append(f'<rect x="{x0}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#444"/>')
        for (name, values), colour in zip(table.items(), COLOURS):
            points = [(x(step), y(error[k])) for step, error in zip(STEPS, values) if error[k] > 10.0**low]
            path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
            lines.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
            lines += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3.5" fill="{colour}"/>' for a, b in points]
    for i, (name, colour) in enumerate(zip(table, COLOURS)):
        at, down = left + (i % 2) * (width + gap), top + height + 45 + 22 * (i // 2)
        lines.append(f'<line x1="{at}" y1="{down}" x2="{at + 26}" y2="{down}" stroke="{colour}" stroke-width="2"/>')
        lines.append(f'<text x="{at + 34}" y="{down + 4}">{name}</text>')
    return "\n".join([*lines, "</svg>", ""])


def main():
    """Run all, write the plot, print the table."""
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/tegula").resolve()
    with open(ROOT / "verification/reference/machines.csv", newline="", encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        wanted = [row for row in rows if row["machine"] == "heavy_top"]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        table = {name: [errors(program, step, keys, wanted, folder) for step in STEPS] for name, keys in SCHEMES.items()}
    head = " | ".join(f"{step * 1e3:g} ms" for step in STEPS)
    print(f"| scheme | error of | {head} | order |\n|---|---|{'---:|' * (len(STEPS) + 1)}")
    for name, values in table.items():
        for k, quantity in enumerate(QUANTITIES):
            cells = " | ".join(f"{error[k]:.1e}" if error[k] > DIGITS else f"<{DIGITS:.0e}" for error in values)
            print(f"| {name} | {quantity} | {cells} | {order([error[k] for error in values]):.1f} |")
    (ROOT / "book/src/pictures/heavy_top_order.svg").write_text(plot(table), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
