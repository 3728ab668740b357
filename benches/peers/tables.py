"""From runs to tables: errors against the limits, ratios of times at equal error, Markdown and CSV."""

import csv
import math

import limits
import problems

BEGIN, END = "<!-- peers:begin -->", "<!-- peers:end -->"
TITLES = {"cylinder": "Quarter cylinder under an edge load", "hypar": "Hyperbolic paraboloid under its weight",
          "pendulum": "Pendulum"}
LEVELS = (0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001, 0.0005, 0.0003, 0.0002, 0.0001)
SIDE_BY_SIDE = ("Kratos", "EXUDYN", "OpenSees", "CalculiX")
MEASURES = {"error": "displacement", "energy": "energy"}
# Errors below this multiple of the distance between the codes' limits say nothing.
TRUST = 3


def table_rows(runs, known):
    """A dictionary a run: times of its repetitions, and errors against the limit of its theory."""
    rows = []
    for run in runs:
        job, found = run["job"], run["found"]
        last = found[-1]
        row = {"problem": job["problem"], "program": run["peer"], "family": run["family"], "theory": run["theory"],
               "row": run["row"], "elements": job["elements"], "job": job, "version": last.get("version", ""),
               "step": step(job), "failure": last.get("failure", ""), "repetitions": len(found)}
        row.update({key: last.get(key) for key in ("unknowns", "steps", "iterations")})
        times = [one["cpu"] for one in found if "cpu" in one]
        if times:
            row["cpu"], row["spread"] = min(times), max(times) / min(times) - 1
            row["wall"] = min(one["wall"] for one in found if "wall" in one)
        if not row["failure"]:
            row.update(errors(job["problem"], last, known[job["problem"]][run["theory"]]))
        rows.append(row)
    return rows


def step(job):
    """Time step or tolerance of a motion; smaller is finer."""
    return job.get("dt") or job.get("analysis", {}).get("tolerance") or 0.0


def errors(problem, found, limit):
    """Root mean squares over the compared points (and times): all components together, each one, and of the work."""
    u, exact = limits.flat(problem, found), limit["displacement"]
    work = limits.works(found)
    size = limits.norm(exact)
    difference = limits.minus(u, exact)
    parts = {axis: limits.norm(difference[k::3]) / size for k, axis in enumerate("xyz")}
    return {"error": limits.norm(difference) / size, "energy": limits.norm(limits.minus(work, limit["energy"]))
            / limits.norm(limit["energy"]), **parts}


def front(rows, measure):
    """(error, CPU seconds) of the runs that no other run beats in both, coarse to fine.

    A run counts with the largest error among its own and those of the finer runs of its family, so that a coarse mesh
    whose error happens to change its sign gains nothing.
    """
    points = []
    for row in rows:
        if row["failure"]:
            continue
        finer = [o[measure] for o in rows if not o["failure"] and o["family"] == row["family"]
                 and o["elements"] >= row["elements"] and o["step"] <= row["step"]]
        points.append((row["cpu"], max(finer)))
    kept = []
    for cpu, error in sorted(points):
        if not kept or error < kept[-1][0]:
            kept.append((error, cpu))
    return kept


def cost(front_, error):
    """CPU seconds for an error, between the runs linear in logarithms; and -1, 0, 1: the coarsest run is already
    more exact, the error lies between runs, the finest run is not as exact."""
    if error >= front_[0][0]:
        return front_[0][1], -1 if error > front_[0][0] else 0
    for (e0, c0), (e1, c1) in zip(front_, front_[1:]):
        if error >= e1:
            part = math.log(e0 / error) / math.log(e0 / e1)
            return c0 * (c1 / c0) ** part, 0
    return front_[-1][1], 1


def ratio(theirs, ours, error):
    """CPU seconds there over here at an error, as (number, sign): sign "<" or ">" where one side is a bound."""
    if not theirs or not ours:
        return None
    (a, side_a), (b, side_b) = cost(theirs, error), cost(ours, error)
    if side_a == 1 and side_b == 1 or side_a == -1 and side_b == -1:
        return None
    # A run that is too exact costs too much, one that is not exact enough too little.
    sign = ""
    if side_a == 1 or side_b == -1:
        sign = ">"
    if side_a == -1 or side_b == 1:
        sign = "<" if not sign else "?"
    return (a / b, sign) if sign != "?" else None


def number(value):
    return "%.2g" % value if value < 10 else "%.0f" % value


def percent(value):
    return "%.2g %%" % (100 * value)


def shown(found):
    return "—" if found is None else found[1] + number(found[0])


def group(rows, program, row=""):
    return [r for r in rows if r["program"] == program and (not row or r["row"] == row)]


def ratio_table(rows, known, measure):
    """Ratios at errors of the list: against the default settings here, and in brackets against the best ones."""
    peers = list(dict.fromkeys(r["program"] for r in rows if r["program"] != "tegula"))
    fronts = {peer: front(group(rows, peer), measure) for peer in peers}
    ours = {row: front(group(rows, "tegula", row), measure) for row in ("default", "best")}
    ours["best"] = front(group(rows, "tegula"), measure)
    theories = {r["program"]: r["theory"] for r in rows}
    lines = ["| %s error | tegula [CPU s] | %s |" % (MEASURES[measure], " | ".join(peers)),
             "|---:|---:|" + "---:|" * len(peers)]
    table = []
    for level in LEVELS:
        cells = []
        for peer in peers:
            sure = level >= TRUST * max(limits.uncertainty(known[t], MEASURES[measure]) for t in (theories[peer], theories["tegula"]))
            pair = [ratio(fronts[peer], ours[row], level) if sure else None for row in ("default", "best")]
            cells.append(pair)
        if all(pair == [None, None] for pair in cells):
            continue
        seconds = [cost(ours[row], level) for row in ("default", "best")]
        text = ["%s%s" % ({-1: "≤", 0: "", 1: ">"}[side], number(value)) for value, side in seconds]
        lines.append("| %s | %s (%s) | %s |" % (percent(level), *text, " | ".join(
            "—" if pair == [None, None] else "%s (%s)" % (shown(pair[0]), shown(pair[1])) for pair in cells)))
        table.append((level, dict(zip(peers, cells))))
    return lines, table


def finest_common(rows, known, peer, measure, row):
    """The smallest error that both programs reach and the limits can tell, and the ratio there."""
    theirs = front(group(rows, peer), measure)
    ours = front(group(rows, "tegula", "default" if row == "default" else ""), measure)
    if not theirs or not ours:
        return None
    theory = group(rows, peer)[0]["theory"], group(rows, "tegula")[0]["theory"]
    error = max(theirs[-1][0], ours[-1][0], TRUST * max(limits.uncertainty(known[t], MEASURES[measure]) for t in theory))
    return error, ratio(theirs, ours, error)


def summary_table(rows, known):
    lines = ["| problem | error in | " + " | ".join(SIDE_BY_SIDE) + " |",
             "|:--|:--|" + "---:|" * len(SIDE_BY_SIDE)]
    for problem in dict.fromkeys(r["problem"] for r in rows):
        mine = [r for r in rows if r["problem"] == problem]
        for measure, name in MEASURES.items():
            cells = []
            for peer in SIDE_BY_SIDE:
                pair = [finest_common(mine, known[problem], peer, measure, row) for row in ("default", "best")]
                cells.append(" ; ".join("—" if one is None or one[1] is None else "%s%s at %s"
                                       % (one[1][1], number(one[1][0]), percent(one[0])) for one in pair))
            lines.append("| %s | %s | %s |" % (problem, name, " | ".join(cells)))
    return lines


COLUMNS = [("program", "program"), ("family", "settings"), ("mesh", "mesh"), ("unknowns", "unknowns"), ("steps", "steps"),
           ("iterations", "iterations"), ("cpu", "CPU s"), ("spread", "spread"), ("x", "error x"), ("y", "y"), ("z", "z"),
           ("error", "all"), ("energy", "energy")]


def cell(row, key):
    value = row.get(key)
    if key == "mesh":
        return "%d×%d" % (row["elements"], row["elements"]) + (", %g ms" % (1e3 * row["job"]["dt"]) if "dt" in row["job"]
                    else ", tolerance %g" % row["step"] if row["step"] else "")
    if key == "cpu" and row["failure"]:
        return "—: " + row["failure"].replace("|", "/")
    if value is None:
        return ""
    if key == "family":
        return ("**%s**" if row["row"] == "default" else "%s") % value
    if key == "cpu":
        return "%.2f" % value if value < 10 else "%.1f" % value
    if key == "spread":
        return "%.0f %%" % (100 * value)
    if key in ("error", "energy", "x", "y", "z"):
        return "%.2g %%" % (100 * value) if value < 1 else "%.0f %%" % (100 * value)
    return str(value)


def run_table(rows):
    lines = ["| " + " | ".join(title for _, title in COLUMNS) + " |", "|:--|:--|" + "---:|" * (len(COLUMNS) - 2)]
    return lines + ["| " + " | ".join(cell(row, key) for key, _ in COLUMNS) + " |" for row in rows]


def limit_table(known):
    lines = ["| problem | theory | from | meshes | distance | step | energy: distance | step |",
             "|:--|:--|:--|:--|---:|---:|---:|---:|"]
    for problem, theories in known.items():
        for theory, limit in theories.items():
            for name, code in limit["codes"].items():
                shares = [percent(code[key]) for key in ("displacement", "displacement step", "energy", "energy step")]
                lines.append("| " + " | ".join((problem, theory, name, ", ".join(map(str, code["meshes"])), *shares)) + " |")
    return lines


def write(runs, known, about, folder, page):
    """Prints the tables, writes them as CSV and Markdown, and between the marks of the book's page."""
    rows = table_rows(runs, known)
    parts = ["### At the smallest error that both reach", "", *summary_table(rows, known), ""]
    for problem in dict.fromkeys(row["problem"] for row in rows):
        mine = [row for row in rows if row["problem"] == problem]
        parts += ["### " + TITLES[problem], ""]
        for measure in MEASURES:
            parts += [*ratio_table(mine, known[problem], measure)[0], ""]
        parts += [*run_table(mine), ""]
    parts += ["### Limits", "", *limit_table(known), ""]
    with open(folder / "runs.csv", "w", newline="") as file:
        keys = ["problem", "program", "family", "theory", "elements", "step", "unknowns", "steps", "iterations", "repetitions",
                "cpu", "spread", "wall", "x", "y", "z", "error", "energy", "failure"]
        writer = csv.writer(file)
        writer.writerow(keys)
        writer.writerows([row.get(key) for key in keys] for row in rows)
    versions = {row["program"]: row["version"].replace('"', "").split("--")[0].strip() for row in rows if row["version"]}
    parts.append("Versions: " + ", ".join("%s %s" % item for item in versions.items()) + ".")
    parts.append("Computed on %s: %s. CPU seconds are the fewest of %s repetitions; the spread is by how much the most "
                 "exceed them." % (about["date"], about["machine"], "–".join(
                     map(str, sorted({row["repetitions"] for row in rows if not row["failure"]})))))
    if about["note"]:
        parts.append(about["note"])
    text = "\n".join(parts)
    (folder / "peers.md").write_text(text + "\n")
    print("\n" + text)
    if page is not None:
        old = page.read_text()
        start, end = old.index(BEGIN) + len(BEGIN), old.index(END)
        page.write_text(old[:start] + "\n" + text + "\n" + old[end:])
