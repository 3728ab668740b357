#!/usr/bin/env python3
"""Count the instructions of the element work of a Newton iteration and compare with those kept.

    cargo build --release --example instruction_counts
    python3 scripts/count_instructions.py           # fails if a part takes 5 % more than benches/instructions.json
    python3 scripts/count_instructions.py --write   # writes that file anew: for changes that are meant

Needs valgrind. Counts do not depend on what else the machine does; they do on the compiler. A count far below
the kept one is reported, so that the gain is kept by writing the file.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "target/release/examples/instruction_counts"
KEPT = ROOT / "benches/instructions.json"
# Not the factorisation: how its dense kernels divide their work depends on the caches of the machine.
PARTS = ("force", "tangent", "tangent-cm", "tangent-and-scatter")
MORE = 1.05
REPETITIONS = (1, 11)


def count(part, repetitions):
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PROGRAM, part, str(repetitions)]
    done = subprocess.run(command, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found:
        sys.exit(f"{part}: valgrind failed\n{done.stderr[-2000:]}")
    return int(found.group(1))


def main():
    first, last = REPETITIONS
    counts = {part: (count(part, last) - count(part, first)) // (last - first) for part in PARTS}
    if "--write" in sys.argv:
        KEPT.write_text(json.dumps(counts, indent=2) + "\n")
    kept = json.loads(KEPT.read_text())
    failed = False
    for part, now in counts.items():
        ratio = now / kept[part]
        verdict = "" if 1 / MORE <= ratio <= MORE else "  MORE" if ratio > 1 else "  less: keep it by --write"
        failed |= ratio > MORE
        print(f"{part:22} {now:>12} instructions, {ratio:.3f} of what is kept{verdict}")
    if failed:
        sys.exit("more instructions than kept in benches/instructions.json: find out why, or write it anew")


if __name__ == "__main__":
    main()
