#!/usr/bin/env python3
"""How the cost of a static analysis grows with the mesh: CPU seconds and memory of whole runs.

    cargo build --release
    python3 benches/growth.py [--largest 256]

The quarter cylinder of `examples/quarter_cylinder_static.toml` (large deformation in one load step) on finer and
finer meshes, from process start to results on disk, without pictures. CPU seconds (user and system), wall seconds and
peak memory are those of the whole process, by `wait4`. CPU seconds are per iteration too, as finer meshes may need one
more. The exponent is that of the least-squares line through the logarithms of CPU seconds per iteration and number of
elements. Explicit steps have `cargo run --release --example growth_explicit`.
"""

import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "target/release/tegula"
MODEL = ROOT / "examples/quarter_cylinder_static.toml"


def run(n, folder):
    """The summary of a run, with `cpu`, `wall` (s) and `peak` (bytes) of its process."""
    text = re.sub(r"elements = \[\d+, *\d+\]", f"elements = [{n}, {n}]", MODEL.read_text())
    text = text.replace("[output]", "[output]\npictures = false")
    model, out = folder / f"{n}.toml", folder / str(n)
    model.write_text(text)
    start = time.perf_counter()
    process = subprocess.Popen([PROGRAM, "run", model, "--out", out, "--quiet"])
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{n} x {n} elements: the run ended with {process.returncode}")
    # Linux counts memory in units of 1024 bytes, macOS in bytes.
    unit = 1 if sys.platform == "darwin" else 1024
    return {**json.loads((out / "summary.json").read_text()), "cpu": usage.ru_utime + usage.ru_stime,
            "wall": wall, "peak": unit * usage.ru_maxrss}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--largest", type=int, default=256, help="elements along a side of the finest mesh")
    largest = parser.parse_args().largest
    print("| elements | unknowns | iterations | factorisations | CPU s | wall s | CPU s per iteration | peak MB |")
    print("|---:|---:|---:|---:|---:|---:|---:|---:|")
    points = []
    with tempfile.TemporaryDirectory() as folder:
        n = 32
        while n <= largest:
            s = run(n, pathlib.Path(folder))
            per_iteration = s["cpu"] / s["iterations"]
            points.append((math.log(s["elements"]), math.log(per_iteration)))
            print(f"| {s['elements']} | {s['unknowns']} | {s['iterations']} | {s['factorizations']} | {s['cpu']:.2f} "
                  f"| {s['wall']:.2f} | {per_iteration:.3f} | {s['peak'] / 1e6:.0f} |", flush=True)
            n *= 2
    mean = [sum(p[i] for p in points) / len(points) for i in (0, 1)]
    slope = (sum((x - mean[0]) * (y - mean[1]) for x, y in points)
             / sum((x - mean[0]) ** 2 for x, _ in points))
    print(f"\nCPU seconds per iteration grow with the number of elements to the power {slope:.2f}")


if __name__ == "__main__":
    main()
