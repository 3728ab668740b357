#!/usr/bin/env python3
"""Count the instructions of the element work of a Newton iteration and compare with those kept.

    cargo build --release --example instruction_counts
    python3 scripts/count_instructions.py           # fails if a part takes 15 % more than benches/instructions.json
                                                    # by the same compiler, on the same architecture
    python3 scripts/count_instructions.py --write   # writes that file anew: for changes that are meant

What the kernels and the factorisation compute is held exactly by the tests `operations_per_element_are_those_that_are_known`
and `a_factorisation_costs_what_is_known`, which count floating-point operations, of AVX-512 as of any other registers.
Instructions show what only machine code has: values that leave the registers, loops that are no longer vectorised, sums
that are no longer fused; such a loss is a third or more. A few per cent come and go with the inlining of other code and
decide nothing. Valgrind runs the AVX2 code: it does not know AVX-512.

Needs valgrind. Counts do not depend on what else the machine does; they do on the compiler and the architecture.
With others than those of the file differences are reported only. A count far below the kept one is reported, so that
the gain is kept by writing the file.
"""

import json
import pathlib
import platform
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "target/release/examples/instruction_counts"
KEPT = ROOT / "benches/instructions.json"
# Not the factorisation: how its dense kernels divide their work depends on the caches of the machine.
PARTS = ("force", "tangent", "tangent-cm", "tangent-and-scatter")
MORE = 1.15
REPETITIONS = (1, 11)


def count(part, repetitions):
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PROGRAM, part, str(repetitions)]
    done = subprocess.run(command, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found:
        sys.exit(f"{part}: valgrind failed\n{done.stderr[-2000:]}")
    return int(found.group(1))


def machine():
    """What counts depend on."""
    rustc = subprocess.run(["rustc", "--version"], cwd=ROOT, capture_output=True, text=True, check=True)
    return {"rustc": rustc.stdout.strip(), "architecture": platform.machine()}


def main():
    first, last = REPETITIONS
    here = machine()
    counts = {part: (count(part, last) - count(part, first)) // (last - first) for part in PARTS}
    if "--write" in sys.argv:
        KEPT.write_text(json.dumps({**here, **counts}, indent=2) + "\n")
    kept = json.loads(KEPT.read_text())
    same, failed = all(kept[key] == here[key] for key in here), False
    for part, now in counts.items():
        ratio = now / kept[part]
        verdict = "" if 1 / MORE <= ratio <= MORE else "  MORE" if ratio > 1 else "  less: keep it by --write"
        failed |= ratio > MORE and same
        print(f"{part:22} {now:>12} instructions, {ratio:.3f} of what is kept{verdict}")
    if not same:
        print("the kept counts were taken with {rustc} on {architecture}; here is ".format(**kept)
              + "{rustc} on {architecture}, so differences decide nothing".format(**here))
    if failed:
        sys.exit("more instructions than kept in benches/instructions.json: find out why, or write it anew")


if __name__ == "__main__":
    main()
