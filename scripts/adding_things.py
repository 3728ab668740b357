"""Adds the examples of the developer pages to a copy of the program and runs the contract tests on them.

Usage: python3 scripts/adding_things.py [--replace OLD NEW]

Every page `book/src/developers/*.md` that teaches to add something holds the code of one new file and one line of a registry:

    <!-- file: PATH -->                  the next code block is a new file
    <!-- line of PATH: OPENING -->       the next code block, one line, joins the block that the line OPENING begins
                                          (without its `$`, which begins a formula in the book)

The copy lies in `target/toys` and uses the folder `target` for its builds, so that dependencies are compiled once; files that
have not changed keep their time. A test must have gone through every example: the contract tests print `contract: KIND NAME`.
With --replace, the text OLD in the files of the pages becomes NEW: a wrong example must make the script fail.
"""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "target" / "toys"
# Examples that the contract tests must have gone through.
EXPECTED = [
    "material stiffening", "joint slot", "section sandwich", "load attraction", "support guide", "element plain", "scheme damped", "reader obj",
    "case stretched-strip",
]
# Contract tests. The whole workspace is named, because other sets of packages would compile dependencies with other features.
TARGETS = ["--test", "elements", "--test", "analyses", "--test", "readers", "--test", "fast_cases"]
NAMES = ["material::", "element_contract::", "contracts::", "every_reader", "fast_cases"]
MARK = re.compile(r"<!-- (?:file: (?P<file>\S+)|line of (?P<registry>\S+): (?P<opening>.*?)) -->\n```rust,ignore\n(?P<code>.*?)```\n", re.S)


def write(path: Path, text: bytes) -> None:
    """Writes a file whose content differs."""
    if not path.exists() or path.read_bytes() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text)


def insert(text: str, opening: str, line: str) -> str:
    """Adds a line at the end of the block that begins with the line `opening`."""
    lines = text.splitlines(keepends=True)
    starts = [i for i, found in enumerate(lines) if found.strip().lstrip("$") == opening]
    if len(starts) != 1:
        sys.exit(f"{len(starts)} lines are `{opening}`, not one")
    indent = len(lines[starts[0]]) - len(lines[starts[0]].lstrip())
    closing = lines[starts[0]][:indent] + "}\n"
    lines.insert(lines.index(closing, starts[0]), line)
    return "".join(lines)


def examples() -> tuple[dict[str, str], dict[str, list[tuple[str, str]]]]:
    """New files by path, and lines of registries (opening, line) by path."""
    files, lines = {}, {}
    for page in sorted((ROOT / "book" / "src" / "developers").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        found = list(MARK.finditer(text))
        kinds = ["file" if m["file"] else "line" for m in found]
        if len(found) != text.count("<!-- ") or kinds not in ([], ["file", "line"]):
            sys.exit(f"{page.name}: expected the code of one new file and one line of a registry, found {kinds}")
        for m in found:
            if m["file"]:
                files[m["file"]] = m["code"]
            elif m["code"].count("\n") != 1:
                sys.exit(f"{page.name}: the registry takes one line")
            else:
                lines.setdefault(m["registry"], []).append((m["opening"], m["code"]))
    return files, lines


def copy(replace: list[str]) -> list[Path]:
    """Copy of the program with the examples; returns the new files."""
    listed = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, check=True, capture_output=True, text=True).stdout.split("\0")
    files, lines = examples()
    wanted = {n for n in names if n and (ROOT / n).is_file()} | set(files)
    for old in [p for p in COPY.rglob("*") if p.is_file()]:
        if str(old.relative_to(COPY)) not in wanted:
            old.unlink()
    for name in wanted - set(files):
        content = (ROOT / name).read_bytes()
        for opening, line in lines.pop(name, []):
            content = insert(content.decode(), opening, line).encode()
        write(COPY / name, content)
    if lines:
        sys.exit(f"no such registry: {', '.join(lines)}")
    used = False
    for name, code in files.items():
        if (ROOT / name).exists():
            sys.exit(f"{name} exists: the example needs a name of its own")
        if replace:
            used |= replace[0] in code
            code = code.replace(*replace)
        write(COPY / name, code.encode())
    if replace and not used:
        sys.exit(f"no example holds `{replace[0]}`")
    return [COPY / name for name in files]


def main() -> None:
    replace = sys.argv[2:4] if sys.argv[1:2] == ["--replace"] else []
    begin = time.monotonic()
    new = copy(replace)
    if not replace:
        subprocess.run(["rustfmt", "--check", "--edition", "2024", *new], cwd=COPY, check=True)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(ROOT / "target"), "CARGO_PROFILE_DEV_OPT_LEVEL": "1"}
    environment |= {"CARGO_PROFILE_DEV_DEBUG": "false"}
    command = ["cargo", "test", "--workspace", *TARGETS, "--", "--nocapture", *NAMES]
    run = subprocess.run(command, cwd=COPY, env=environment, stdout=subprocess.PIPE, text=True)
    if run.returncode:
        sys.exit(f"{run.stdout[-6000:]}\nthe examples of the developer pages fail: {' '.join(command)}")
    went = set(re.findall(r"contract: (\S+ \S+)", run.stdout))
    if missing := [name for name in EXPECTED if name not in went]:
        sys.exit(f"no contract test went through {', '.join(missing)}")
    print(f"one new file and one line each, in {time.monotonic() - begin:.0f} s: {', '.join(EXPECTED)}")


if __name__ == "__main__":
    if shutil.which("cargo") is None:
        sys.exit("cargo is missing")
    main()
