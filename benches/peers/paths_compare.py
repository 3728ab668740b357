#!/usr/bin/env python3
"""Follow the equilibrium path of the hinged roof with tegula, Kratos and CalculiX, and write a table of times.

    cargo build --release
    python3 benches/peers/compare.py --install                          # once: venv in target/peers, from PyPI
    python3 benches/peers/paths_compare.py --repetitions 2 --book       # about an hour on one quiet core
    python3 benches/peers/paths_compare.py --meshes 16,32

How times are measured and runs kept is told in `compare.py`. The book's page says what the columns are.
"""

import argparse
import datetime
import pathlib

import compare
import paths_calculix
import paths_kratos
import paths_tegula

PEERS = {peer.NAME: peer for peer in (paths_tegula, paths_kratos, paths_calculix)}
BEGIN, END = "<!-- paths:begin -->", "<!-- paths:end -->"
PAGE = compare.ROOT / "book/src/benchmarks/paths.md"
THICK, THIN = 12.7, 6.35
KRATOS = {"element": "MITCThickShellCorotationalElement3D4N", "solver": "LinearSolversApplication.sparse_lu", "tolerance": 1e-4}


def runs(meshes):
    """Steps of the others: as many as find the limit to 0.1 %, and the fewest that get through."""
    for n in meshes:
        for thickness in (THICK, THIN):
            for method in ("series", "arc-length"):
                yield run("tegula", {"series": "power series (default)", "arc-length": "arc length"}[method], n, thickness,
                          analysis={} if method == "series" else {"method": method})
            # A prescribed deflection cannot follow the thin roof: one mesh shows it.
            if thickness == THIN and n != meshes[0]:
                continue
            for steps in (20, 5):
                yield run("Kratos", "MITC, %d steps of the deflection" % steps, n, thickness, steps=steps, **KRATOS)
            if n == meshes[0]:
                yield run("Kratos", "MITC, arc length", n, thickness, steps=100, force=200.0, arc_length={}, **KRATOS)
            for most in (0.05, 0.1):
                yield run("CalculiX", "S4, increments up to %g mm" % (30.0 * most), n, thickness, element="S4", increment=most, most=most)
            yield run("CalculiX", "S8R, half the elements, increments up to 1.5 mm", n, thickness, element="S8R", half=True,
                      increment=0.05, most=0.05)


def run(peer, family, elements, thickness, half=False, **job):
    return {"peer": peer, "family": family, "mesh": elements,
            "job": {"problem": "roof", "elements": elements // 2 if half else elements, "thickness": thickness, **job}}


def table(done):
    """A row a run: fewest CPU seconds of the repetitions, and how many times those of the series on the same mesh they are."""
    own = {(row["mesh"], row["job"]["thickness"]): fewest(row) for row in done
           if row["peer"] == "tegula" and not row["job"]["analysis"]}
    for thickness in (THICK, THIN):
        yield "### Roof of %g mm" % thickness
        yield ""
        yield "| mesh | program | settings | unknowns | steps | factorisations | CPU s | times the series | first limit [N] |"
        yield "|---:|:--|:--|---:|---:|---:|---:|---:|---:|"
        for row in done:
            last = row["found"][-1]
            if row["job"]["thickness"] != thickness:
                continue
            cells = ["%d×%d" % (row["mesh"], row["mesh"]), row["peer"], row["family"]]
            if "failure" in last:
                cells += ["", "", "", "", "", "does not get through: " + last["failure"]]
            else:
                cpu = fewest(row)
                cells += [last["unknowns"], last["steps"], last["factorisations"], "%.3g" % cpu,
                          "%.3g" % (cpu / own[row["mesh"], thickness]), "%.1f" % last["limit"]]
            yield "| " + " | ".join(map(str, cells)) + " |"
        yield ""


def fewest(row):
    return min(found["cpu"] for found in row["found"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", default="16,32,64,128", help="elements along a side of the quarter, separated by commas")
    parser.add_argument("--repetitions", type=int, default=2, help="of every run")
    parser.add_argument("--limit", type=float, default=3600, help="wall seconds after which a run is given up")
    parser.add_argument("--out", type=pathlib.Path, default=compare.RESULTS, help="folder of results")
    parser.add_argument("--book", action="store_true", help="put the table into the book")
    options = parser.parse_args()
    meshes = [int(n) for n in options.meshes.split(",")]
    done = compare.run_all(list(runs(meshes)), options.repetitions, options.limit, options.out.resolve(), peers=PEERS)
    versions = {row["peer"]: last["version"] for row in done for last in row["found"] if last.get("version")}
    text = "\n".join(table(done)) + "\n%s; %s; %s; the fewest of %d repetitions.\n" % (
        datetime.date.today().isoformat(), compare.machine(), ", ".join("%s %s" % pair for pair in versions.items()), options.repetitions)
    print(text)
    if options.book:
        page = PAGE.read_text()
        PAGE.write_text(page[:page.index(BEGIN) + len(BEGIN)] + "\n" + text + page[page.index(END):])


if __name__ == "__main__":
    main()
