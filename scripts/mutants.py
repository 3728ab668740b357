#!/usr/bin/env python3
"""Mutation test: how many small errors the tests notice, by module.

    cargo install cargo-mutants --locked
    python3 scripts/mutants.py [--out FOLDER] [--shard K/N] [MODULE...]

`cargo mutants` replaces one operator, sign or returned value at a time and runs the tests of the module. Every mutant compiles
the library anew, so a run takes every twentieth mutant, other ones each week of the year; `--shard 0/1` takes all. The folder
(`target/mutants` unless given) gets the output of the tool, `table.md`, and `missed.txt` with the mutants that no test noticed.
The exit code is 1 if less than 90 % of the mutants of a module are noticed. A timeout counts as noticed; mutants that do not
compile do not count.
"""

import argparse
import datetime
import json
import pathlib
import subprocess
import sys

LEAST = 0.9
# Parts of all mutants, one a week.
PARTS = 20
# Package, files, and the tests that should notice.
MODULES = {
    "element": ("tegula", "crates/tegula/src/element/**/*.rs", ["--lib", "--test", "elements", "--test", "analyses"]),
    "material": ("tegula", "crates/tegula/src/material/**/*.rs", ["--lib", "--test", "elements", "--test", "analyses"]),
    "analysis": ("tegula", "crates/tegula/src/analysis/**/*.rs", ["--lib", "--test", "analyses"]),
    "out": ("tegula-io", "crates/tegula-io/src/out/**/*.rs", ["--lib", "--tests"]),
}
# Seconds for the tests of a mutant, and for compiling it.
TIMEOUT, BUILD_TIMEOUT = 600, 1800


def run(module, out, shard):
    """Outcomes of the mutants of a module, by their names."""
    package, files, tests = MODULES[module]
    command = ["cargo", "mutants", "--package", package, "--file", files, "--output", str(out), "--no-shuffle"]
    command += ["--timeout", str(TIMEOUT), "--build-timeout", str(BUILD_TIMEOUT)]
    command += ["--shard", shard, "--sharding", "round-robin", "--", *tests]
    out.mkdir(parents=True, exist_ok=True)
    # 2: missed mutants, 3: timeouts; both are counted below.
    code = subprocess.run(command, check=False).returncode
    if code not in (0, 2, 3):
        sys.exit(f"cargo mutants ended with the exit code {code}")
    return outcomes(json.loads((out / "mutants.out/outcomes.json").read_text(encoding="utf-8")))


def outcomes(report):
    """Names of the mutants of a report by outcome."""
    found = {"CaughtMutant": [], "MissedMutant": [], "Timeout": [], "Unviable": []}
    for outcome in report["outcomes"]:
        if outcome["scenario"] != "Baseline":
            found.setdefault(outcome["summary"], []).append(outcome["scenario"]["Mutant"]["name"])
    return found


def share(found):
    """Noticed mutants over all that compile; 1 if there is none."""
    noticed = len(found["CaughtMutant"]) + len(found["Timeout"])
    total = noticed + len(found["MissedMutant"])
    return noticed / total if total else 1.0


def table(results):
    """Markdown table of the outcomes of all modules."""
    lines = ["| module | caught | timeout | missed | not compiled | noticed |", "|---|---:|---:|---:|---:|---:|"]
    for module, found in results.items():
        counts = [str(len(found[k])) for k in ("CaughtMutant", "Timeout", "MissedMutant", "Unviable")]
        lines.append(f"| {module} | {' | '.join(counts)} | {100 * share(found):.0f} % |")
    return "\n".join(lines) + "\n"


def main():
    """Run the modules and judge them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", help=f"of {', '.join(MODULES)}; all unless given")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("target/mutants"))
    week = datetime.date.today().isocalendar().week
    parser.add_argument("--shard", metavar="K/N", default=f"{week % PARTS}/{PARTS}", help="the K-th of N parts, K from 0")
    options = parser.parse_args()
    unknown = set(options.modules) - set(MODULES)
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    if subprocess.run(["cargo", "mutants", "--version"], capture_output=True, check=False).returncode:
        sys.exit("cargo-mutants is missing: cargo install cargo-mutants --locked")
    results = {}
    for module in options.modules or MODULES:
        results[module] = run(module, options.out / module, options.shard)
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "table.md").write_text(table(results), encoding="utf-8")
        missed = [name for found in results.values() for name in found["MissedMutant"]]
        (options.out / "missed.txt").write_text("".join(f"{name}\n" for name in missed), encoding="utf-8")
    print(table(results))
    return 1 if any(share(found) < LEAST for found in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
