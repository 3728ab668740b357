"""Writes the index of the keys of the model file, `book/src/key-index.md`, from the tables of the pages that explain them.

Usage: python3 scripts/key_index.py [--check]; with --check it fails where the page is not up to date.
"""

import re
import sys
from pathlib import Path

BOOK = Path(__file__).resolve().parent.parent / "book" / "src"
PAGES = ["model-file.md", "composites.md", "bodies-and-joints.md"]
# Keys that the pages explain in sentences.
EXTRA = {
    "angle": ("Keys of a layup", "composites.md#keys-of-a-layup"),
    **{unit: ("Output: units", "model-file.md#output") for unit in ("energy", "force", "frequency", "stress", "time")},
}
NAME = re.compile(r"`([a-z][a-z_0-9]*)`")
HEAD = """# Index of keys

All keys of the [model file](model-file.md) in alphabetical order, with the sections that have them. `scripts/key_index.py`
writes this page.

| key | in |
|---|---|
"""


def anchor(heading: str) -> str:
    """Anchor that mdbook gives to a heading."""
    kept = "".join(c for c in heading.lower().strip() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def keys() -> dict[str, list[tuple[str, str]]]:
    """Sections (title, address) by key."""
    found: dict[str, list[tuple[str, str]]] = {}
    for name in PAGES:
        collect(name, found)
    for key, place in EXTRA.items():
        found.setdefault(key, []).append(place)
    return found


def collect(name: str, found: dict[str, list[tuple[str, str]]]) -> None:
    """Adds the keys of a page."""
    above, section, inside, column = "", ("", ""), False, None

    def add(names: list[str], place: tuple[str, str]) -> None:
        for name in names:
            if place not in found.setdefault(name, []):
                found[name].append(place)

    for line in (BOOK / name).read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            inside = not inside
        if inside:
            continue
        if heading := re.match(r"(#+) (.*)", line):
            level, text = len(heading[1]), heading[2]
            if level == 2:
                above = text
            short = re.sub(r"`type = \"([^\"]*)\"`.*", r"\1", text).strip("`")
            section = (f"{above}: {short}" if level == 3 else text, f"{name}#{anchor(text)}")
            # Tables of the file are headings of the page.
            if level == 2 and name == PAGES[0]:
                add([text.lower().replace(" ", "_")], section)
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        if not cells:
            column = None
        elif column is None:
            # The first line of a table: a column of keys, or keys as names of columns.
            column = next((i for i, cell in enumerate(cells) if cell in ("key", "keys", "top-level key")), -1)
            add([key for cell in cells for key in NAME.findall(cell)], section)
        elif 0 <= column < len(cells):
            add(NAME.findall(re.sub(r"\([^)]*\)", "", cells[column])), section)
        if common := re.match(r"All take an optional `([a-z_]+)`", line):
            add([common[1]], section)


def page() -> str:
    rows = [
        f"| `{key}` | " + ", ".join(f"[{title}]({to})" for title, to in places) + " |"
        for key, places in sorted(keys().items())
    ]
    return HEAD + "\n".join(rows) + "\n"


def main() -> None:
    path = BOOK / "key-index.md"
    if "--check" not in sys.argv:
        path.write_text(page(), encoding="utf-8")
    elif not path.exists() or path.read_text(encoding="utf-8") != page():
        sys.exit("book/src/key-index.md is not up to date: run python3 scripts/key_index.py")


if __name__ == "__main__":
    main()
