#!/usr/bin/env python3
"""Compare the run counters of the verification with the kept ones.

    tegula verify --statistics FILE
    python3 scripts/check_statistics.py FILE verification/statistics.txt

Steps, iterations, factorisations and cut-backs are the same on every run, whatever the number of threads. Other vector
instructions round otherwise: where the processors named in the first lines differ, a count may differ by 2 and 2 %. Those of
paths, which locate bifurcations down to round-off, may differ by 4, and iterations of modes by a block of 8 vectors. Counts of
analyses with cut-backs, where rounding may decide about a step, may differ by 8 %, and those with more cut-backs than steps by a
factor of four: a sheet with wrinkles has taken 386 factorisations on one processor and 642 on another, and four turned copies of
one sheet 234 to 655 on one processor. The exit code is 1 if anything else differs. To accept a new state:

    tegula verify --statistics verification/statistics.txt
"""

import difflib
import pathlib
import sys


def rows(text):
    """Rows of a table with one line a model: lines of several models are repeated, without their sum of unknowns."""
    out = []
    for line in text.splitlines()[2:]:
        case, models, analysis, unknowns, *counts = line.split()
        out += [(case, analysis, None if models != "1" else unknowns, *map(int, counts))] * int(models)
    return out


def near(kept, fresh):
    """True for rows of the same model whose counts differ by rounding."""
    few = {"modal": 8, "path": 4}.get(kept[1], 2)
    steps, cutbacks = kept[3], max(kept[-1], fresh[-1])
    share = 3.0 if cutbacks > steps else 0.08 if cutbacks else 0.02
    counts = zip(kept[3:], fresh[3:])
    return kept[:2] == fresh[:2] and all(abs(a - b) <= few + share * min(a, b) for a, b in counts)


def differences(kept, fresh):
    """Lines that differ, as a diff."""
    if kept.splitlines()[0] != fresh.splitlines()[0]:
        a, b = rows(kept), rows(fresh)
        if len(a) == len(b) and all(map(near, a, b)):
            return []
    return list(difflib.unified_diff(kept.splitlines(), fresh.splitlines(), "kept", "computed", lineterm="", n=1))


def main():
    """Compare two files."""
    if len(sys.argv) != 3:
        print(__doc__)
        return 1
    fresh, kept = (pathlib.Path(p).read_text(encoding="utf-8") for p in sys.argv[1:])
    found = differences(kept, fresh)
    print("\n".join(found) if found else f"{sys.argv[2]}: {len(rows(kept))} analyses, ok")
    if found:
        print("If this is meant, accept it: tegula verify --statistics verification/statistics.txt")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
