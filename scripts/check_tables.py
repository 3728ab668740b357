#!/usr/bin/env python3
"""Compare the tables that the book shows with freshly computed ones.

    tegula verify patch paper-tables --tables FOLDER
    python scripts/check_tables.py FOLDER book/src/verification

Every table of the book must be in FOLDER with the same rows and columns. Text such as `pass` must be equal; numbers
may differ by two units of the last printed digit, which another processor may round otherwise. The exit code is 1 if
a table differs. To renew the tables of the book, compute them into its folder.
"""

import pathlib
import sys
from decimal import Decimal, InvalidOperation


def cells(path):
    """The cells of the Markdown table in a file, by rows; lines outside of it are rows of one cell."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("|:"):
            continue
        rows.append([c.strip() for c in line.strip().strip("|").split("|")] if line.startswith("|") else [line])
    return rows


def same(shown, fresh):
    """True for equal texts, and for numbers that differ by rounding; never for what is no number."""
    if {shown.lower(), fresh.lower()} & {"nan", "inf", "-inf"}:
        return False
    if shown == fresh:
        return True
    try:
        a, b = Decimal(shown), Decimal(fresh)
    except InvalidOperation:
        return False
    last_digit = Decimal(1).scaleb(a.as_tuple().exponent)
    return abs(a - b) <= 2 * last_digit


def differences(shown, fresh):
    """What differs between two tables."""
    if len(shown) != len(fresh):
        return [f"{len(shown)} lines in the book, {len(fresh)} computed"]
    found = []
    for number, (a, b) in enumerate(zip(shown, fresh), 1):
        if len(a) != len(b) or not all(map(same, a, b)):
            found.append(f"line {number}:\n    book:     {' | '.join(a)}\n    computed: {' | '.join(b)}")
    return found


def main():
    """Compare all tables of the book."""
    if len(sys.argv) != 3:
        print(__doc__)
        return 1
    fresh, book = map(pathlib.Path, sys.argv[1:])
    tables = sorted(book.glob("*.md"))
    if not tables:
        print(f"{book}: no tables")
        return 1
    failed = False
    for table in tables:
        computed = fresh / table.name
        found = differences(cells(table), cells(computed)) if computed.exists() else ["it was not computed"]
        failed |= bool(found)
        print(f"{table}: {'ok' if not found else 'DIFFERS: ' + '; '.join(found)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
