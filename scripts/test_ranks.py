#!/usr/bin/env python3
"""Compares runs on several ranks of MPI with those of one process: test_ranks.py PROGRAM [MODEL ...].

PROGRAM is built with the feature `petsc`. Counts of steps and factorisations are equal, those of iterations to a thousandth; numbers of the history, of the modes
and of the critical points differ by no more than 1e-9 of the largest number of their kind, accelerations and reactions by 1e-8, and those of motions by 1e-6
behind the time 0.4. The second derivatives of an equation that is solved to 1e-10 or so are known to that many digits only. Of a model with `:iterative` behind its
name a finer mesh is solved by BDDC, whose results are those of one process to the last bit.
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RANKS = (1, 2, 3, 4)
CLOSE, DERIVED, LATER, LATE = 1e-9, 1e-8, 1e-6, 0.4
MORE = 1e-3
COUNTS = ("status", "steps", "iterations", "factorizations", "cutbacks", "negative_pivots")
MODELS = (
    "verification/models/quarter_cylinder.toml",
    "examples/quarter_cylinder_static.toml:iterative",
    "examples/lee_frame.toml",
    "examples/hinged_roof_path.toml",
    "examples/free_plate_modes.toml",
    "examples/plate_buckling.toml",
    "examples/flexible_four_bar.toml",
    "examples/stress_wave.toml",
    "examples/yielding_strip.toml",
)
# Open MPI refuses the administrator, as whom containers run, and more ranks than cores.
ENVIRONMENT = dict(
    os.environ,
    OMPI_ALLOW_RUN_AS_ROOT="1",
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
    OMPI_MCA_rmaps_base_oversubscribe="1",
    OMPI_MCA_btl_vader_single_copy_mechanism="none",
    OMP_NUM_THREADS="1",
)


def run(command, timeout=600):
    return subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=timeout)


def prepared(model, folder):
    """Path of a model, and whether its results are to be the same bits."""
    name, _, is_iterative = model.partition(":")
    if not is_iterative:
        return ROOT / name, False
    text = (ROOT / name).read_text()
    for old, new in (('type = "static"', 'type = "static"\nlinear_solver = "iterative"'), ("[32, 32]", "[96, 64]")):
        assert old in text, (name, old)
        text = text.replace(old, new)
    path = folder / "iterative.toml"
    path.write_text(text)
    return path, True


def same_bits(serial, parallel):
    """Tables and fields that are not the same bytes."""
    files = [p for p in sorted(serial.rglob("*")) if p.suffix in (".csv", ".vtu")]
    wrong = [f"{p.relative_to(serial)} has other bytes" for p in files if p.read_bytes() != (parallel / p.relative_to(serial)).read_bytes()]
    return wrong if files else ["no files"]


def table(path):
    with open(path, newline="") as lines:
        rows = [row for row in csv.reader(lines) if not row[0].startswith("#")]
    names, numbers = rows[0], []
    for row in rows[1:]:
        numbers.append([float(x) if x not in ("", "true", "false") else None for x in row])
    return names, numbers


# Quantities beside which others are round-off: forces beside moments, the power of a joint beside the energies.
BESIDE = {name: "energy" for name in ("kinetic", "strain", "potential", "work", "dissipated", "total", "power")}
BESIDE |= {"f": "reaction", "m": "reaction"}


def kind(name):
    """Columns of one quantity: displacements of all points, reactions of all supports, loads and joints, energies."""
    last = name.split(".")[-1].rstrip("xyz123")
    return BESIDE.get(last, last)


# Residuals, errors of closed constraints and of balances are round-off themselves; the step of a path is made of the last term of its series.
ROUND_OFF = ("residual", "drift", "error", "balance", "iterations", "step_size")
SECOND_DERIVATIVES = ("reaction", "a", "alpha_")


def difference(one, other):
    """Largest difference of two tables over its limit, with its place."""
    (names, a), (also, b) = table(one), table(other)
    if names != also or len(a) != len(b):
        return math.inf, f"{len(a)} rows and {len(names)} columns, {len(b)} rows and {len(also)} columns"
    scales = {}
    for row in a:
        for name, x in zip(names, row):
            if x is not None and math.isfinite(x):
                scales[kind(name)] = max(scales.get(kind(name), 0.0), abs(x))
    worst = (0.0, "")
    for ra, rb in zip(a, b):
        moves = names[0] == "time"
        for name, x, y in zip(names, ra, rb):
            if any(word in name for word in ROUND_OFF):
                continue
            close = DERIVED if kind(name) in SECOND_DERIVATIVES else CLOSE
            limit = LATER if moves and ra[0] > LATE else close
            if x is None or y is None:
                value = 0.0 if x == y else math.inf
            else:
                value = abs(x - y) / (limit * max(scales[kind(name)], 1e-300))
            if not value <= worst[0]:
                worst = (value, f"{name} at {names[0]} {ra[0]}: {x} and {y}")
    return worst


def compare(serial, parallel, resumes=0):
    """What differs between two result folders, and the largest difference over its limit; a resumed run may factor a tangent once more."""
    wrong, worst = [], 0.0
    for path in sorted(serial.rglob("summary.json")):
        place = path.relative_to(serial)
        a, b = (json.loads((folder / place).read_text()) for folder in (serial, parallel))
        for key in COUNTS:
            x, y = a.get(key), b.get(key)
            # Iterations of a motion end at a residual that is nearly round-off.
            same = abs(x - y) <= MORE * x if key == "iterations" else x == y
            if key == "factorizations":
                same = x <= y <= x + resumes
            if not same:
                wrong.append(f"{place}: {key} {x} and {y}")
        for x, y in zip(a.get("critical_points") or [], b.get("critical_points") or [], strict=True):
            close = abs(x["load_factor"] - y["load_factor"]) <= CLOSE * abs(x["load_factor"])
            if x["kind"] != y["kind"] or not close:
                wrong.append(f"{place}: {x} and {y}")
    tables = [p for p in sorted(serial.rglob("*.csv")) if p.name in ("history.csv", "modes.csv", "campbell.csv")]
    for path in tables:
        place = path.relative_to(serial)
        value, where = difference(path, parallel / place)
        worst = max(worst, value)
        if not value <= 1.0:
            wrong.append(f"{place}: {value:.1e} of what is allowed: {where}")
    if not tables:
        wrong.append("no table")
    return wrong, worst


def main():
    program = str(Path(sys.argv[1]).resolve())
    failed = 0
    for model in sys.argv[2:] or MODELS:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            path, is_exact = prepared(model, folder)
            began = time.time()
            done = run([program, "run", str(path), "--out", str(folder / "serial"), "--quiet", "-j", "1"])
            if done.returncode:
                sys.exit(f"{model}: {done.stderr}")
            cells = [f"{time.time() - began:.1f} s alone"]
            for ranks in RANKS:
                began, out = time.time(), folder / f"ranks-{ranks}"
                command = ["mpirun", "-n", str(ranks), program, "run", str(path), "--out", str(out), "--quiet", "-j", "1"]
                try:
                    done = run(command)
                    wrong, worst = compare(folder / "serial", out) if done.returncode == 0 else ([done.stderr], math.inf)
                    if is_exact and done.returncode == 0:
                        wrong += same_bits(folder / "serial", out)
                except subprocess.TimeoutExpired:
                    wrong, worst = ["does not end"], math.inf
                cells.append(f"{ranks}: {time.time() - began:.1f} s {worst:.1e}")
                for line in wrong:
                    print(f"{model} on {ranks} ranks: {line}")
                failed += bool(wrong)
            print(f"{model}: " + ", ".join(cells), flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
