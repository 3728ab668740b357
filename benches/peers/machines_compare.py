#!/usr/bin/env python3
"""Compute machines with tegula and EXUDYN, and write tables of errors, times and ratios.

    cargo build --release
    python3 benches/peers/compare.py --install                        # once: venv in target/peers, from PyPI
    python3 benches/peers/machines_compare.py --repetitions 3         # about a quarter of an hour on one quiet core
    python3 benches/peers/machines_compare.py --limits                # the solutions that errors refer to; needs scipy

How times are measured, runs kept and ratios taken at equal error is told in `compare.py`. Beside the CPU time of the whole process stand
that of the solution alone, without the start of Python and of the program, and medians.
"""

import argparse
import datetime
import importlib.util
import json
import os
import pathlib
import statistics
import sys

import compare
import limits
import machines
import machines_exudyn
import machines_jobs
import machines_tegula
import tables

LIMITS = compare.HERE / "machines_limits.json"
PEERS = {"tegula": machines_tegula, "EXUDYN": machines_exudyn}
LEVELS = (0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001, 0.0005, 0.0002, 0.0001)
# Limits of two programs have to agree to this part of an error that is compared.
AGREEMENT = 0.1


def chain_limit():
    """The chain in its angles, by Runge and Kutta's method of eighth order with a tolerance of 1e-12; the same with 1e-10 tells the error."""
    import numpy as np
    from scipy.integrate import solve_ivp

    n, length, mass = (machines.CHAIN[key] for key in ("links", "length", "mass"))
    # The centre of bar i is the sum of all bars before it and half of its own.
    reach = np.tril(np.ones((n, n)), -1) + 0.5 * np.eye(n)
    inertia, weight = mass * length**2 * reach.T @ reach, mass * machines.GRAVITY * length * reach.sum(0)
    own = machines.link_inertia()[2] * np.eye(n)

    def rates(_, y):
        angle, rate = y[:n], y[n:]
        between = angle[:, None] - angle[None, :]
        force = -(inertia * np.sin(between)) @ rate**2 - weight * np.cos(angle)
        return np.concatenate([rate, np.linalg.solve(inertia * np.cos(between) + own, force)])

    found = []
    for tolerance in (1e-12, 1e-10):
        motion = solve_ivp(rates, (0, machines.END["chain"]), np.zeros(2 * n), method="DOP853", rtol=tolerance, atol=0.1 * tolerance,
                           t_eval=machines.samples("chain"))
        found.append(machines.compared("chain", [machines.chain_places(angles) for angles in motion.y[:n].T]))
    return {"codes": {"DOP853 in minimal coordinates": distance(found[1], found[0])}, "compared": rounded(found[0]),
            "apart": distance(found[1], found[0])}


def distance(a, b):
    return limits.norm(limits.minus(a, b)) / limits.norm(b)


def average(vectors):
    return [sum(x) / len(x) for x in zip(*vectors)]


def rounded(values):
    return [float("%.9g" % x) for x in values]


def code_limit(members):
    """The limit of one code, extrapolated from its two finest meshes, and where there are three runs of two meshes, from two steps."""
    members = sorted(members, key=lambda member: (-member[0].get("dt", 0), member[0]["elements"]))
    (coarse, a), (fine, b), (last, c) = members
    if last["elements"] > fine["elements"]:
        return limits.second_order(b, c)
    # Cubic elements converge with fourth order, the three-node beam too.
    space = limits.second_order(a, b, 2 if coarse["model"] in ("beam", "shell") else 4)
    return [x + y for x, y in zip(space, limits.minus(limits.second_order(a, c), a))]


def write_limits(out, only):
    known = json.loads(LIMITS.read_text()) if LIMITS.exists() and only else {}
    runs = [run for run in machines_jobs.limit_runs() if only in (None, run["job"]["problem"])]
    codes = {}
    for run in compare.run_all(runs, 1, 3600, out, timed=False, peers=PEERS):
        job, found = run["job"], run["found"][-1]
        codes.setdefault((job["problem"], run["theory"]), {}).setdefault("%s, %s" % (run["peer"], run["family"]), []).append(
            (job, found["compared"]))
    for (problem, theory), members in codes.items():
        values = {name: code_limit(runs) for name, runs in members.items()}
        programs = [average([value for name, value in values.items() if name.startswith(peer)]) for peer in PEERS]
        mean = average([value for value in programs if value])
        known.setdefault(problem, {})[theory] = {
            "codes": {name: distance(value, mean) for name, value in values.items()}, "compared": rounded(mean),
            "apart": max(distance(a, b) for a in values.values() for b in values.values())}
    if only in (None, "chain"):
        known["chain"] = {machines_jobs.SHEAR: chain_limit()}
    LIMITS.write_text(json.dumps(known) + "\n")
    for problem, theories in known.items():
        for theory, limit in theories.items():
            print(problem, theory, limit["codes"])


def table_rows(runs, known):
    """A dictionary a run: the fewest and the median of its times, and its error."""
    rows = []
    for run in runs:
        job, found = run["job"], run["found"]
        row = {"problem": job["problem"], "kind": run["kind"], "program": run["peer"], "family": run["family"], "theory": run["theory"],
               "elements": job["elements"], "job": job, "step": job["dt"], "failure": found[-1].get("failure", "")}
        if not row["failure"]:
            row.update({key: found[-1].get(key) for key in ("version", "steps", "iterations", "jacobians")})
            for key in ("cpu", "wall", "solve"):
                row[key], row["median " + key] = min(one[key] for one in found), statistics.median(one[key] for one in found)
            row["error"] = distance(found[-1]["compared"], known[job["problem"]][run["theory"]]["compared"])
        rows.append(row)
    return rows


def front(rows, program, key):
    chosen = [{**row, "cpu": row.get(key)} for row in rows if row["program"] == program]
    return tables.front(chosen, "error")


def ratio_table(rows, known):
    """Times at equal error of the whole process and of the solution."""
    theories = {row["theory"] for row in rows}
    apart = max(known[theory]["apart"] for theory in theories)
    lines = ["| error | tegula [CPU s] | EXUDYN [CPU s] | ratio | tegula, solution | EXUDYN, solution | ratio |", "|---:|---:|---:|---:|---:|---:|---:|"]
    for level in LEVELS:
        if AGREEMENT * level < apart:
            continue
        cells = []
        for key in ("cpu", "solve"):
            fronts = [front(rows, program, key) for program in ("tegula", "EXUDYN")]
            if not all(fronts) or any(level < one[-1][0] for one in fronts):
                break
            costs = [tables.cost(one, level) for one in fronts]
            cells += ["%s%.3f" % ("≤" if side < 0 else "", value) for value, side in costs]
            cells.append(tables.shown(tables.ratio(fronts[1], fronts[0], level)))
        if len(cells) == 6:
            lines.append("| %s | %s |" % (tables.percent(level), " | ".join(cells)))
    return lines


def run_table(rows):
    lines = ["| program | settings | elements | step or tolerance | steps | iterations | factorisations | CPU s | median | solution | median | wall | error |",
             "|:--|:--|" + "---:|" * 11]
    for row in rows:
        last = [row["failure"].replace("|", "/")] + [""] * 8 if row["failure"] else [
            row["steps"], row["iterations"], row["jacobians"], *("%.3f" % row[key] for key in
            ("cpu", "median cpu", "solve", "median solve", "wall")), tables.percent(row["error"])]
        lines.append("| " + " | ".join(map(str, (row["program"], row["family"], row["elements"], "%.3g" % row["step"], *last))) + " |")
    return lines


def write(runs, known, out, note):
    rows = table_rows(runs, known)
    parts = []
    for problem, kind in dict.fromkeys((row["problem"], row["kind"]) for row in rows):
        mine = [row for row in rows if (row["problem"], row["kind"]) == (problem, kind)]
        parts += ["### %s: %s" % (machines_jobs.TITLES[problem], kind), "", *ratio_table(mine, known[problem]), "", *run_table(mine), ""]
    parts += ["### Limits", "", "| problem | theory | from | distance from their mean |", "|:--|:--|:--|---:|"]
    parts += ["| %s | %s | %s | %s |" % (problem, theory, name, tables.percent(value)) for problem, theories in known.items()
              for theory, limit in theories.items() for name, value in limit["codes"].items()]
    versions = {row["program"]: row["version"].replace('"', "") for row in rows if not row["failure"]}
    count = max(len(run["found"]) for run in runs)
    parts += ["", "Versions: %s. Computed on %s: %s. The fewest and the median of %d repetitions." % (
        ", ".join("%s %s" % item for item in versions.items()), datetime.date.today().isoformat(), compare.machine(), count), note or ""]
    text = "\n".join(parts)
    (out / "machines.md").write_text(text + "\n")
    print("\n" + text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limits", action="store_true", help="compute machines_limits.json again and end")
    parser.add_argument("--only", choices=tuple(machines.END), help="one of the machines")
    parser.add_argument("--repetitions", type=int, default=3, help="of every run")
    parser.add_argument("--limit", type=float, default=300, help="wall seconds after which a run is given up")
    parser.add_argument("--out", type=pathlib.Path, default=compare.RESULTS, help="folder of results")
    parser.add_argument("--note", help="a sentence to put below the tables")
    options = parser.parse_args()
    if importlib.util.find_spec("numpy") is None:
        os.execv(compare.PYTHON, [compare.PYTHON, *sys.argv])
    out = options.out.resolve()
    if options.limits:
        return write_limits(out, options.only)
    chosen = [run for run in machines_jobs.runs() if options.only in (None, run["job"]["problem"])]
    write(compare.run_all(chosen, options.repetitions, options.limit, out, peers=PEERS), json.loads(LIMITS.read_text()), out, options.note)


if __name__ == "__main__":
    main()
