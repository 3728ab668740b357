#!/usr/bin/env python3
"""Checks that the blocks of the book are true: every model and fragment of a model, every command line, the Python of the page on results.

    python3 scripts/check_book.py PROGRAM [--python]

`tegula check` must accept each TOML block. A block with a title is a whole model; another one is a fragment and is merged into a base model of `book/bases`,
`plate.toml` unless a comment in front of the block says otherwise: `<!-- block: base: sheet; bodies: arm, tip -->`. Keys of the comment:

- `base`: base model; tables of the fragment replace its tables, and lists of tables are appended to its lists;
- `without`: tables and lists of the base that are left out;
- `into`: list of the base whose first entry gets the keys of the fragment;
- `bodies`, `materials`, `amplitudes`: names that the fragment uses and the base lacks; these are added;
- `sets`: names of sets that are added, each as NAME = set of the base;
- `part of`: name of a model that the blocks of a page with this name make together;
- `after`: command line that runs before a Python block, in a folder with the examples.

Command lines of `tegula` in shell blocks, indented blocks and code within the text are compared with `tegula --help` and the help of their command. With `--python`
the Python blocks of `results.md` are run, too; they need h5py, pandas, pyarrow and SciPy.
"""

import functools
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from toml_text import model_text

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "book/src"
BASES = ROOT / "book/bases"
# Pages that scripts/test_tutorials.py runs as a whole, and the folder of those whose models `tegula verify` runs.
RUN_ELSEWHERE = {"tutorial.md", "tutorial-python.md", "cases"}
KEYS = {"base", "without", "into", "bodies", "materials", "amplitudes", "sets", "part of", "after"}


@dataclass
class Block:
    """Fenced block: page, line of its fence (from 1), language, text, and what the comment in front of it says."""

    page: str
    line: int
    language: str
    text: str = ""
    says: dict[str, str] = field(default_factory=dict)

    def names(self, key: str) -> list[str]:
        """Names behind a key of the comment."""
        return [name.strip() for name in self.says.get(key, "").split(",") if name.strip()]

    @property
    def place(self) -> str:
        """Place in the book, for messages."""
        return f"book/src/{self.page}:{self.line}"


def comment_in_front(lines: list[str], line: int) -> dict[str, str]:
    """Keys and values of the comment above a fence, which stands in `lines[line]`."""
    above = [text.strip() for text in lines[max(0, line - 2) : line] if text.strip()]
    found = re.fullmatch(r"<!-- block: (.*) -->", above[-1]) if above else None
    if not found:
        return {}
    says = dict(re.split(r":\s+", part.strip(), maxsplit=1) for part in found[1].split(";"))
    if unknown := says.keys() - KEYS:
        raise ValueError(f"unknown key of a comment: {', '.join(sorted(unknown))}")
    return says


def blocks(page: Path) -> list[Block]:
    """Blocks of a page."""
    lines, found, inside = page.read_text(encoding="utf-8").splitlines(), [], None
    for number, line in enumerate(lines):
        if inside is not None and line.strip() == "```":
            found.append(inside)
            inside = None
        elif inside is not None:
            inside.text += line + "\n"
        elif fence := re.fullmatch(r"\s*```(\S*)", line):
            name = page.relative_to(BOOK).as_posix()
            inside = Block(name, number + 1, fence[1], says=comment_in_front(lines, number))
    return found


def added(block: Block) -> dict:
    """Bodies, materials, amplitudes and sets that the comment of a block adds to its base."""
    # Bodies lie apart from each other, and none of them on a joint of the book.
    bodies = [
        {"name": name, "at": [3.0 + place, 5.0, 7.0], "mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
        for place, name in enumerate(block.names("bodies"))
    ]
    sets = [dict(zip(("name", "of"), re.split(r"\s*=\s*", pair), strict=True)) for pair in block.names("sets")]
    return {
        "bodies": bodies,
        "materials": {
            name: {"type": "isotropic", "young": 210e9, "poisson": 0.3, "density": 7800.0, "expansion": 1e-5}
            for name in block.names("materials")
        },
        "amplitudes": {name: {"type": "ramp", "end": 1.0} for name in block.names("amplitudes")},
        "sets": [{"type": "union", "name": pair["name"], "of": [pair["of"]]} for pair in sets],
    }


def merge(base: dict, fragment: dict) -> dict:
    """Base with the tables of a fragment; tables by name and lists grow, other tables are replaced."""
    out = dict(base)
    for key, value in fragment.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            out[key] = out.get(key, []) + value
        elif key in ("materials", "amplitudes"):
            out[key] = {**out.get(key, {}), **value}
        elif value:
            out[key] = value
    if "steps" in fragment:
        out.pop("analysis", None)
    return out


def model(block: Block) -> str:
    """Whole model of a block."""
    fragment = tomllib.loads(block.text)
    if "title" in fragment and "base" not in block.says:
        return block.text
    path = BASES / f"{block.says.get('base', 'plate')}.toml"
    base = tomllib.loads(path.read_text(encoding="utf-8"))
    for name in block.names("without"):
        del base[name]
    if "into" in block.says:
        base[block.says["into"]][0].update(fragment)
        fragment = {}
    whole = merge(merge(base, added(block)), fragment)
    return model_text(whole)


def models(all_blocks: list[Block]) -> list[tuple[Block, str]]:
    """Models of the TOML blocks, each with the block that messages name."""
    out, parts = [], {}
    for block in all_blocks:
        if block.language == "toml" and "part of" in block.says:
            parts.setdefault((block.page, block.says["part of"]), []).append(block)
        elif block.language == "toml":
            out.append((block, model(block)))
    joined = [(of[0], "\n".join(block.text for block in of)) for of in parts.values()]
    return out + joined


def check(program: str, text: str) -> str | None:
    """Message where `tegula check` refuses the model of a block."""
    with tempfile.TemporaryDirectory() as folder:
        for file in BASES.iterdir():
            if file.suffix != ".toml":
                shutil.copy(file, folder)
        Path(folder, "model.toml").write_text(text, encoding="utf-8")
        run = subprocess.run([program, "check", "model.toml"], cwd=folder, capture_output=True, text=True, timeout=60)
    return None if run.returncode == 0 else f"tegula check ends with {run.returncode}:\n{run.stdout}{run.stderr}"


@functools.cache
def help_of(program: str, command: str | None) -> str:
    """Help of the program or of a command."""
    arguments = [program, command, "--help"] if command else [program, "--help"]
    return subprocess.run(arguments, capture_output=True, text=True, timeout=60, check=True).stdout


def command_lines(page: Path, found: list[Block]) -> list[tuple[int, str]]:
    """Command lines of `tegula` on a page, with their lines: in shell blocks, in indented blocks and between backticks."""
    out = [
        (block.line + 1 + number, line)
        for block in found
        if block.language in ("sh", "")
        for number, line in enumerate(block.text.splitlines())
    ]
    fenced = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        fenced ^= line.lstrip().startswith("```")
        if not fenced:
            out += [(number, line.strip())] if line.startswith("    ") else [(number, code) for code in re.findall(r"`(tegula [^`]+)`", line)]
    # Programs of a package, such as tegula-cli, are others.
    calls = r"(?:^|&&|\|)\s*(tegula(?: [^|&>#…]*)?)"
    return [(number, call.strip()) for number, line in out for call in re.findall(calls, line)]


def wrong_call(program: str, call: str) -> str | None:
    """Message where a command line names a command or an option that the program does not have."""
    words = shlex.split(call)[1:]
    commands = re.findall(r"^  (\w+)  ", help_of(program, None).split("Commands:")[1].split("Options:")[0], re.MULTILINE)
    if not words or words[0] in ("--help", "-h", "--version", "-V"):
        return None
    if words[0] not in commands:
        return f"{call!r}: there is no command {words[0]!r}"
    known = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", help_of(program, words[0]).split("Options:")[-1]))
    unknown = [word for word in words[1:] if re.match(r"--?[a-z]", word) and word.split("=")[0] not in known]
    return f"{call!r}: {words[0]} has no option {', '.join(unknown)}" if unknown else None


def run_python(program: str, found: list[Block]) -> None:
    """Runs Python blocks, each in a folder with the examples, behind the command line of its comment."""
    home = Path.cwd()
    for block in found:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                for file in (ROOT / "examples").glob("*.toml"):
                    shutil.copy(file, folder)
                for line in block.says["after"].split("&&"):
                    words = shlex.split(line)
                    subprocess.run([program, *words[1:]], check=True, capture_output=True, timeout=120)
                exec(compile("\n" * block.line + block.text, block.page, "exec"), {})
            finally:
                os.chdir(home)


def main() -> int:
    arguments = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    if len(arguments) != 1 or not os.access(arguments[0], os.X_OK):
        sys.exit(__doc__)
    program = str(Path(arguments[0]).resolve())
    pages = [page for page in sorted(BOOK.rglob("*.md")) if not RUN_ELSEWHERE & {page.name, page.parent.name}]
    wrong, checked, calls, python = [], 0, 0, []
    for page in pages:
        found = blocks(page)
        for block, text in models(found):
            checked += 1
            if message := check(program, text):
                wrong.append(f"{block.place}: {message}")
        for number, call in command_lines(page, found):
            calls += 1
            if message := wrong_call(program, call):
                wrong.append(f"book/src/{page.relative_to(BOOK)}:{number}: {message}")
        python += [block for block in found if block.language == "python" and page.name == "results.md"]
    if "--python" in sys.argv:
        run_python(program, python)
        print(f"{len(python)} Python blocks run")
    print(f"{checked} models and fragments checked, {calls} command lines compared, {len(wrong)} wrong")
    for message in wrong:
        print(message)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
