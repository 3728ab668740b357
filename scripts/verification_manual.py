#!/usr/bin/env python3
"""Writes the verification manual of the book, one page for each case, from the values of a verification.

    tegula verify --json verify.json
    python3 scripts/verification_manual.py verify.json PROGRAM [--all] [--check]

The figures show the values of the verification; those of whole histories and paths are drawn from runs of the models by PROGRAM, in less than a minute of
processor time. Cases without values, and without `--all` the figures of those that take long, stay as they are. Definition and comparison come from the table of
cases in `book/src/verification.md`, sources from the remarks of the reference tables, models from `verification/models`; the files of a case are those that its
code includes, or the table `OWN`. With `--check` nothing is written, and the exit code is 1 where a page or figure is missing, has other words, or has numbers
that differ by more than two units of the last printed digit, in figures by more than two thousandths of the range of a curve.
"""

import html
import json
import math
import re
import sys
from collections import defaultdict
from pathlib import Path

from check_tables import same
from line_plot import svg
from verification_curves import CURVES, LONG, Run, runner
from verification_figures import FIGURES, figures_agree

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "book/src"
PAGES = BOOK / "verification/cases"
PICTURES = BOOK / "pictures/verification"
CODE = ROOT / "verification/src/verify"
# Values that a page lists one by one at most; of more it gives the largest use of each element and mesh.
LISTED = 40
# Lines that a model may have at most to be shown.
SHOWN = 60
# Uses below are drawn at the left end of the picture.
LEAST = 1e-4


def cases() -> list[tuple[list[str], str, str]]:
    """Names, what is compared and with what, by the rows of the table of cases."""
    text = (BOOK / "verification.md").read_text()
    table = text.split("| case | compared | with |\n|---|---|---|\n")[1].split("\n\n")[0]
    rows = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in table.splitlines()]
    return [(re.findall(r"`([a-z0-9-]+)`", names), compared, reference) for names, compared, reference in rows]


def with_origin(rows: list[tuple[list[str], str, str]]) -> list[tuple[list[str], str, str]]:
    """The rows of the table with *the same* replaced by what it refers to."""
    out = []
    for names, compared, reference in rows:
        if reference.startswith("the same"):
            reference = out[-1][2] + reference.removeprefix("the same")
        out.append((names, compared, reference))
    return out


# Files of cases whose code holds several cases.
OWN = {
    "linear-benchmarks": ["linear_benchmarks.csv", "scordelis_lo.toml", "pinched_cylinder.toml", "hemisphere.toml"],
    "sze": ["sze.csv", "strip.toml", "slit_annulus.toml"],
    "sze-literature": ["sze_literature.csv", "strip.toml", "slit_annulus.toml"],
    "balloon": ["balloon.csv"],
    "bimetal": [],
    "paths-roofs": ["sze_paths.csv", "hinged_roof.toml"],
    "paths-balloon": ["balloon.csv"],
    "paths-full-load": ["sze_paths.csv", "open_cylinder.toml", "strip.toml", "slit_annulus.toml"],
    "hinged-plate": ["transients.csv", "hinged_plate.toml"],
    "oscillating-plate": ["transients.csv", "oscillating_plate.toml"],
    "machines": ["machines.csv"],
    "flexible-machines": ["machines.csv"],
    "flexible-machines-shells": ["machines.csv"],
}


def files_of(names: list[str]) -> tuple[list[Path], list[Path]]:
    """Models and reference tables that the code of these cases includes, or those of the table above."""
    models, tables = [], []
    if names[0] in OWN:
        for name in OWN[names[0]]:
            found = next((ROOT / "verification").glob(f"*/{name}"))
            (models if found.suffix == ".toml" else tables).append(found)
        return models, tables
    for path in sorted(CODE.glob("*.rs")):
        text = path.read_text()
        if any(f'name: "{name}"' in text for name in names):
            for kind, name in re.findall(r'include_str!\("\.\./\.\./(models|reference)/([\w/.-]+)"\)', text):
                (models if kind == "models" else tables).append(ROOT / "verification" / kind / name)
    return models, tables


def use(row: dict) -> float:
    """Difference over what is allowed, or value over limit."""
    if row["verdict"] == "at-most":
        return 0.0 if row["value"] == 0.0 else row["value"] / row["reference"]
    difference = abs(row["value"] - row["reference"])
    if row["verdict"] == "relative":
        difference /= abs(row["reference"])
    return 0.0 if row["tolerance"] == 0.0 else difference / row["tolerance"]


def number(value: float) -> str:
    # Round-off differs between processors.
    return f"{value:.4g}" if value == 0.0 or abs(value) >= 1e-9 else "< 1e-9"


def percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def allowed(row: dict) -> str:
    if row["verdict"] == "at-most":
        return "below the limit"
    if row["tolerance"] == 0.0:
        return "equal"
    return percent_of(row["tolerance"]) if row["verdict"] == "relative" else f"± {number(row['tolerance'])}"


def percent_of(tolerance: float) -> str:
    return f"{100 * tolerance:.3g} %"


def every_value(rows: list[dict]) -> list[str]:
    out = ["| quantity | element | mesh | value | reference or limit | allowed | use |", "|:--|:--|--:|--:|--:|--:|--:|"]
    for row in rows:
        quantity = row["quantity"].replace("|", "\\|")
        element = f"`{row['element']}`" if row["element"] else ""
        numbers = [number(row["value"]), number(row["reference"]), allowed(row), percent(use(row))]
        out.append(f"| {quantity} | {element} | {row['mesh']} | " + " | ".join(numbers) + " |")
    return out


def largest_uses(rows: list[dict]) -> list[str]:
    """Largest use by part and element, with a column for each mesh."""
    several = len({row["case"] for row in rows}) > 1
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    groups = defaultdict(lambda: defaultdict(list))
    for row in rows:
        prefix, colon, _ = row["quantity"].partition(": ")
        parts = ([row["case"]] if several else []) + ([prefix] if colon else [])
        groups[", ".join(parts), row["element"]][row["mesh"]].append(use(row))
    heads = [mesh or "largest use" for mesh in meshes]
    out = [f"| part | element | values | {' | '.join(heads)} |", "|:--|:--|--:|" + "--:|" * len(meshes)]
    for (part, element), of_mesh in groups.items():
        element = f"`{element}`" if element else ""
        count = sum(map(len, of_mesh.values()))
        cells = [percent(max(of_mesh[mesh])) if of_mesh[mesh] else "" for mesh in meshes]
        out.append(f"| {part} | {element} | {count} | {' | '.join(cells)} |")
    return out


def picture(rows: list[dict]) -> str:
    """Uses of all values by element, on a logarithmic axis that ends at what is allowed."""
    elements = list(dict.fromkeys(row["element"] or "model" for row in rows))
    left, width, height, top = 210, 420, 20, 24
    bottom = top + height * len(elements)

    def place(value: float) -> float:
        decades = -math.log10(LEAST)
        return left + width * (1 + math.log10(min(max(value, LEAST), 1.0)) / decades)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + width + 24} {bottom + 40}" role="img" '
        'font-family="sans-serif" font-size="12" fill="currentColor">',
        "<title>Use of the tolerance by all values, by element</title>",
    ]
    for power in range(-4, 1):
        x = place(10.0**power)
        parts.append(f'<path d="M{x:.0f} {top}V{bottom}" stroke="currentColor" opacity="{0.9 if power == 0 else 0.25}"/>')
        label = f"{100 * 10.0**power:g} %"
        parts.append(f'<text x="{x:.0f}" y="{bottom + 16}" text-anchor="middle">{label}</text>')
    for line, element in enumerate(elements):
        y = top + height * (line + 0.5)
        parts.append(f'<text x="{left - 10}" y="{y + 4:.0f}" text-anchor="end">{element}</text>')
        places = sorted({round(place(use(row))) for row in rows if (row["element"] or "model") == element})
        ticks = "".join(f"M{x} {y - 6:.0f}v12" for x in places)
        parts.append(f'<path d="{ticks}" stroke="#0b6fa4" stroke-width="2" opacity="0.6"/>')
    parts.append(f'<text x="{left + width / 2:.0f}" y="{bottom + 34}" text-anchor="middle">use of the tolerance</text></svg>')
    return "\n".join(parts)


def source(path: Path) -> str:
    """Remarks at the beginning of a reference table."""
    lines = path.read_text().splitlines()
    remarks = lines[: next(i for i, line in enumerate(lines) if not line.startswith("#"))]
    return " ".join(line.lstrip("# ").strip() for line in remarks)


def drawn(case: str, rows: list[dict], run: Run, long: bool) -> dict[Path, str] | None:
    """Figures of a case by their files; None where they stay as they are."""
    plots = {}
    if case in FIGURES:
        plots = FIGURES[case](rows)
    elif case not in CURVES:
        sys.exit(f"{case} has no figure: draw one in scripts/verification_figures.py or scripts/verification_curves.py")
    elif case not in LONG or long:
        plots = CURVES[case](run)
    else:
        return None
    return {PICTURES / f"{name}.svg": svg(plot, f"tegula, verification case {case}") for name, plot in plots.items()}


def shown(name: str) -> list[Path]:
    """Figures that the page of a case shows now."""
    path = PAGES / f"{name}.md"
    text = path.read_text() if path.is_file() else ""
    return [BOOK / place for place in re.findall(r"^!\[.*\]\(\.\./\.\./(.+)\)$", text, re.MULTILINE)]


def caption(figure: Path, fresh: dict[Path, str]) -> str:
    """Title of a figure."""
    text = fresh[figure] if figure in fresh else figure.read_text()
    return html.unescape(text.split("<title>")[1].split("</title>")[0])


def page(name: str, compared: str, reference: str, rows: list[dict], figures: list[str]) -> str:
    models, tables = files_of([name])
    capital = compared[0].upper() + compared[1:]
    compared = re.sub(r"\]\((?!http)", "](../../", capital)
    reference = re.sub(r"\]\((?!http)", "](../../", reference)
    lines = [f"# `{name}`", "", f"{compared.rstrip('.')}.", "", f"*Compared with* {reference.rstrip('.')}.", ""]
    lines += [f"    tegula verify {name}", ""]
    if tables:
        lines += ["## Sources", ""]
        lines += [f"- `{path.relative_to(ROOT)}`: {source(path)}" for path in dict.fromkeys(tables)] + [""]
    lines += ["## Figures", ""]
    for figure in figures:
        lines += [figure, ""]
    lines += ["## Values", ""]
    worst = max(map(use, rows))
    lines += [f"{len(rows)} value{'s' if len(rows) > 1 else ''}; the largest use of a tolerance or limit is {percent(worst)}.", ""]
    if len(rows) > LISTED:
        lines += ["The largest use by part, element and mesh; `--json` writes every value.", ""]
    lines += (every_value(rows) if len(rows) <= LISTED else largest_uses(rows)) + [""]
    lines += ["Each tick is a value.", "", picture(rows), ""]
    if models:
        lines += ["## Models", ""]
        for path in dict.fromkeys(models):
            text = path.read_text().rstrip()
            name = f"`{path.relative_to(ROOT)}`"
            if len(text.splitlines()) <= SHOWN:
                lines += [f"{name}:", "", "```toml", text, "```", ""]
            else:
                lines += [name, ""]
    return "\n".join(lines)


def contents(lines_of: dict[str, str]) -> str:
    lines = [
        "# Verification manual",
        "",
        "One page for each case of `tegula verify`: definition, sources, curves beside their reference points, values and models. [Verification](verification.md) tells",
        "how cases are judged. *Use* is the largest difference over its tolerance, or value over its limit. `scripts/verification_manual.py` writes these pages.",
        "",
        "| case | values | largest use |",
        "|:--|--:|--:|",
    ]
    return "\n".join([*lines, *lines_of.values()]) + "\n"


def kept_line(name: str) -> str:
    """Line of a case in the contents as they are."""
    found = re.search(rf"^\| \[`{name}`\].*$", (BOOK / "verification-manual.md").read_text(), re.MULTILINE)
    if not found:
        sys.exit(f"the verification has no values of {name}: compute it, too")
    return found[0]


def agree(shown: str, fresh: str) -> bool:
    """Whether two pages differ by rounding only; uses, also those of the picture, may be those of round-off."""
    texts = [re.sub(r"<svg.*?</svg>|\d+ %", "", text, flags=re.DOTALL) for text in (shown, fresh)]
    a, b = (re.split(r"([-+]?\d[\d.]*(?:e[-+]?\d+)?)", text) for text in texts)
    return len(a) == len(b) and all(same(x.strip(), y.strip()) for x, y in zip(a, b))


def pages(rows: list[dict], run: Run, long: bool) -> dict[Path, str]:
    """Texts of the pages, the contents and the figures by their files; cases without values are left out."""
    fresh, listed = {}, {}
    for names, compared, reference in with_origin(cases()):
        for name in names:
            own = [row for row in rows if row["run"] == name]
            if not own:
                listed[name] = kept_line(name)
                continue
            figures = drawn(name, own, run, long)
            fresh |= figures or {}
            paths = shown(name) if figures is None else list(figures)
            images = [f"![{caption(path, fresh)}](../../{path.relative_to(BOOK)})" for path in paths]
            fresh[PAGES / f"{name}.md"] = page(name, compared, reference, own, images)
            listed[name] = f"| [`{name}`](verification/cases/{name}.md) | {len(own)} | {percent(max(map(use, own)))} |"
    missing = {row["run"] for row in rows} - set(listed)
    if missing:
        sys.exit(f"book/src/verification.md does not describe {', '.join(sorted(missing))}")
    fresh[BOOK / "verification-manual.md"] = contents(listed)
    summary = (BOOK / "SUMMARY.md").read_text()
    absent = [name for name in listed if f"(verification/cases/{name}.md)" not in summary]
    if absent:
        sys.exit(f"book/src/SUMMARY.md does not list {', '.join(absent)}")
    return fresh


def main() -> int:
    paths = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    if len(paths) != 2:
        sys.exit(__doc__)
    rows = json.loads(Path(paths[0]).read_text())
    fresh = pages(rows, runner(str(Path(paths[1]).resolve())), "--all" in sys.argv)
    if "--check" in sys.argv:
        wrong = []
        for path, text in fresh.items():
            same_text = figures_agree if path.suffix == ".svg" else agree
            if not path.is_file() or not same_text(path.read_text(), text):
                wrong.append(path)
        for path in wrong:
            print(f"{path.relative_to(ROOT)} is not up to date")
        return 1 if wrong else 0
    PAGES.mkdir(parents=True, exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    for path, text in fresh.items():
        path.write_text(text)
    print(f"{len(fresh)} pages and figures")
    return 0


if __name__ == "__main__":
    sys.exit(main())
