"""From runs to tables: errors, ratios, Markdown and CSV."""

import csv
import math

from problems import reference_of

BEGIN, END = "<!-- peers:begin -->", "<!-- peers:end -->"


def flat(points):
    """All components of all compared points as one vector."""
    return [x for name in sorted(points) for x in points[name]]


def distance(a, b):
    return math.sqrt(sum((x - y)**2 for x, y in zip(a, b)))


def cylinder_limit(references, element=""):
    """Limit of the meshes of 64, 128 and 256 elements: their distances shrink like a geometric series."""
    key = "cylinder tegula " + element
    a, b, c = (flat(references["%s%d" % (key, n)]["points"]) for n in (64, 128, 256))
    ratio = distance(b, c) / distance(a, b)
    return [z + (z - y) * ratio / (1 - ratio) for y, z in zip(b, c)]


def own_limit(runs, run):
    """Limit of the program's own meshes, of second order from its two finest; none from less than two."""
    same = {r["job"]["elements"]: flat(r["result"]["points"]) for r in runs
            if r["label"].split(",")[0] == run["label"].split(",")[0] and r["peer"] == run["peer"]
            and "failure" not in r["result"]}
    finest = max(same, default=0)
    if finest // 2 not in same:
        return None
    return [z + (z - y) / 3 for y, z in zip(same[finest // 2], same[finest])]


def cylinder_rows(runs, references):
    """A dictionary a run: errors against both limits, and ratios on the same mesh and at equal error."""
    limit = cylinder_limit(references)
    size = distance(limit, [0.0] * len(limit))
    rows = []
    for run in runs:
        row = head(run)
        if "points" in run["result"] and "failure" not in run["result"]:
            points = flat(run["result"]["points"])
            own = limit if run["peer"] == "tegula" else own_limit(runs, run)
            row["error"] = distance(points, limit) / size
            row["own error"] = distance(points, own) / size if own else None
        rows.append(row)
    ours = [row for row in rows if row["program"] == "tegula" and "threads" not in row["how"]]
    for row in rows:
        if row["program"] != "tegula" and not row["failure"]:
            plain = [o for o in ours if o["how"] == "ems"]
            row["same mesh"] = ratio(row, [o for o in plain if o["elements"] == row["elements"]])
            row["equal error"] = ratio(row, [o for o in ours if o["error"] <= row["error"]])
            if row["own error"] is not None:
                row["equal own error"] = ratio(row, [o for o in ours if o["error"] <= row["own error"]])
    return rows


def pendulum_rows(runs, references):
    """The error is the root mean square over points and times of the distance to fine steps on the same mesh."""
    rows = []
    for run in runs:
        row = head(run)
        history, fine = run["result"].get("history"), references.get(reference_of(run["peer"], run["job"]))
        if history and fine and not row["failure"]:
            pairs = [(a[p], b[p]) for a, b in zip(history, fine["history"]) for p in a]
            row["error"] = math.sqrt(sum(distance(a, b)**2 for a, b in pairs) / len(pairs))
        rows.append(row)
    ours = [row for row in rows if row["program"] == "tegula" and not row["failure"]]
    for row in rows:
        if row["program"] != "tegula" and row.get("error") is not None:
            row["equal error"] = ratio(row, [o for o in ours if o["error"] <= row["error"]])
    return rows


def head(run):
    result = run["result"]
    return {"program": run["peer"], "how": run["label"], "elements": run["job"]["elements"],
            "unknowns": result.get("unknowns"), "steps": result.get("steps"), "iterations": result.get("iterations"),
            "cpu": result.get("cpu"), "wall": result.get("wall"), "failure": result.get("failure", "")}


def ratio(row, ours):
    """CPU seconds there over the fewest here, and which run here it was; none if no run here qualifies."""
    if not ours:
        return None
    best = min(ours, key=lambda o: o["cpu"])
    return {"ratio": row["cpu"] / best["cpu"], "elements": best["elements"], "how": best["how"]}


COLUMNS = {
    "cylinder": [("program", "program"), ("how", "shell, solver"), ("elements", "mesh"), ("unknowns", "unknowns"),
                 ("steps", "load steps"), ("iterations", "iterations"), ("cpu", "CPU s"), ("wall", "wall s"),
                 ("error", "error"), ("own error", "error, own limit"), ("same mesh", "same mesh"),
                 ("equal error", "equal error"), ("equal own error", "equal own error")],
    "pendulum": [("program", "program"), ("how", "steps"), ("unknowns", "unknowns"), ("steps", "time steps"),
                 ("iterations", "iterations"), ("cpu", "CPU s"), ("wall", "wall s"), ("error", "error in time [mm]"),
                 ("equal error", "equal error")],
}


def cell(problem, row, key):
    value = row.get(key)
    if key == "cpu" and row["failure"]:
        return "—: " + row["failure"].replace("|", "/")
    if value is None:
        return ""
    if isinstance(value, dict):
        which = "%d×%d" % (value["elements"], value["elements"]) if problem == "cylinder" \
            else value["how"].split()[-1]
        return "%.*f (%s)" % (1 if value["ratio"] < 10 else 0, value["ratio"], which) \
            if key != "same mesh" else "%.*f" % (1 if value["ratio"] < 10 else 0, value["ratio"])
    if key in ("cpu", "wall"):
        return "%.2f" % value if value < 10 else "%.1f" % value
    if key in ("error", "own error"):
        return "%.1f" % (1e3 * value) if problem == "pendulum" else "%.2f %%" % (100 * value)
    if key == "elements":
        return "%d×%d" % (value, value)
    return str(value)


def markdown(problem, rows):
    columns = COLUMNS[problem]
    lines = ["| " + " | ".join(title for _, title in columns) + " |",
             "|:--|:--|" + "---:|" * (len(columns) - 2)]
    lines += ["| " + " | ".join(cell(problem, row, key) for key, _ in columns) + " |" for row in rows]
    return "\n".join(lines)


def write_tables(tables, runs, about, folder, page):
    """Prints the tables, writes them as CSV and Markdown, and between the marks of the book's page."""
    parts = []
    for problem, title in ("cylinder", "### Quarter cylinder"), ("pendulum", "### Pendulum"):
        rows = tables[problem]
        if not rows:
            continue
        parts += [title, "", markdown(problem, rows), ""]
        with open(folder / (problem + ".csv"), "w", newline="") as file:
            keys = [key for key, _ in COLUMNS[problem]] + ["failure"]
            writer = csv.writer(file)
            writer.writerow(keys)
            for row in rows:
                writer.writerow([value["ratio"] if isinstance(value, dict) else value
                                 for value in (row.get(key) for key in keys)])
    versions = {}
    for run in sum(runs.values(), []):
        if run["result"].get("version"):
            versions[run["peer"]] = run["result"]["version"].replace('"', "").split("--")[0].strip()
    parts.append("Versions: " + ", ".join("%s %s" % item for item in versions.items()) + ".")
    parts.append("Computed on %s: %s." % (about["date"], about["machine"]))
    parts.append("A run that takes no more than 10 s on the clock counts with the fewest CPU seconds of %d; longer ones "
                 "are computed once." % about["repeat"])
    if about["note"]:
        parts.append(about["note"])
    text = "\n".join(parts)
    (folder / "peers.md").write_text(text + "\n")
    print("\n" + text)
    if page is not None:
        old = page.read_text()
        start, end = old.index(BEGIN) + len(BEGIN), old.index(END)
        page.write_text(old[:start] + "\n" + text + "\n" + old[end:])
