"""Runs the tutorials of the book and compares what they print with what the pages show.

Usage: python3 scripts/test_tutorials.py PROGRAM [PAGE ...], with a Python that has the package `tegula`, and the path of the program.
"""

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import traceback
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

BOOK = Path(__file__).resolve().parent.parent / "book" / "src"
PAGES = ["tutorial.md", "tutorial-python.md"]
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w])")
FENCE = re.compile(r"^( *)(`{3,}|~{3,})(.*)$")


class Wrong(Exception):
    """A page that differs from the program, with its line (from 1)."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


@dataclass
class Block:
    """A fenced block: language, line of its first text line (from 1), text."""

    language: str
    line: int
    text: str


def blocks(page: str) -> list[Block]:
    """All blocks of code of a page, in order; refuses those that cannot be run."""
    found, inside, lines = [], None, page.splitlines()
    for number, line in enumerate(lines, 1):
        fence = FENCE.match(line)
        if inside is not None:
            if line == "```":
                found.append(inside)
                inside = None
            elif fence:
                raise Wrong(number, "a block ends with ``` at the beginning of the line, without blanks")
            else:
                inside.text += line + "\n"
        elif fence:
            if fence[1] or fence[2] != "```":
                raise Wrong(number, "a block begins with ``` at the beginning of the line")
            if fence[3] not in ("toml", "sh", "python", "text"):
                raise Wrong(number, f"blocks are toml, sh, python or text, not {fence[3]!r}: this one would not be run")
            inside = Block(fence[3], number + 1, "")
        elif line.startswith(("    ", "\t")) and number > 1 and not lines[number - 2].strip():
            raise Wrong(number, "an indented block would not be run: put it between fences")
        elif re.search(r"<(pre|code)\b", line):
            raise Wrong(number, "a block in HTML would not be run: put it between fences")
    if inside is not None:
        raise Wrong(inside.line, "the block has no end")
    return found


def unit_of_last_digit(number: str) -> float:
    """Tolerance of a number: one unit of its last digit, nothing for whole numbers but round-off."""
    mantissa, _, exponent = number.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    if decimals == 0 and not exponent:
        return 1e-9
    return 1.0001 * 10.0 ** (int(exponent or 0) - decimals)


def line_agrees(shown: str, real: str) -> bool:
    """Whether a line of the page is one of the output: same words, numbers within the digits shown."""
    if shown.endswith(" ..."):
        return any(line_agrees(shown.removesuffix(" ..."), real[:end]) for end in range(len(real)))
    if " ".join(NUMBER.sub("#", shown).split()) != " ".join(NUMBER.sub("#", real).split()):
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(real), strict=True)
    return all(abs(float(a) - float(b)) <= unit_of_last_digit(a) for a, b in pairs)


def compare(expected: Block, output: str) -> None:
    """Compares a block with the output before it; `...` stands for any number of lines."""
    real = output.rstrip("\n").splitlines()
    shown = expected.text.rstrip("\n").splitlines()
    if not [line for line in shown if line != "..."]:
        raise Wrong(expected.line, "the block shows no line of the output")
    at, free = 0, False
    for offset, line in enumerate(shown):
        if line == "...":
            free = True
            continue
        rest = range(at, len(real)) if free else range(at, min(at + 1, len(real)))
        match = next((i for i in rest if line_agrees(line, real[i])), None)
        if match is None:
            there = "\n".join(f"    {r}" for r in real[at : at + 12]) or "    (nothing)"
            raise Wrong(expected.line + offset, f"the page shows\n    {line}\nbut the output has there\n{there}")
        at, free = match + 1, False
    if not free and at < len(real):
        raise Wrong(expected.line + len(shown) - 1, f"the output has a line more than the page shows:\n    {real[at]}")


def write_model(block: Block, folder: Path) -> None:
    """Writes a model file under the name in its first line."""
    name = re.match(r"# ([\w-]+\.toml)\n", block.text)
    if not name:
        raise Wrong(block.line, "the first line of a model names its file: `# NAME.toml`")
    if (folder / name[1]).exists():
        raise Wrong(block.line, f"{name[1]} is there already")
    (folder / name[1]).write_text(block.text, encoding="utf-8")


def run_shell(block: Block, folder: Path, path: str) -> str:
    """Standard output of shell commands; the first one that fails ends the test."""
    environment = {**os.environ, "PATH": path}
    run = subprocess.run(["bash", "-euo", "pipefail", "-c", block.text], cwd=folder, env=environment,
                         capture_output=True, text=True, timeout=600)  # fmt: skip
    if run.returncode != 0:
        raise Wrong(block.line, f"the commands end with code {run.returncode}:\n{run.stdout}{run.stderr}")
    return run.stdout


def run_python(block: Block, name: str, names: dict) -> str:
    """What Python code prints, in the namespace of the page."""
    out = io.StringIO()
    try:
        # Lines of messages are those of the page.
        code = compile("\n" * (block.line - 1) + block.text, name, "exec")
        with redirect_stdout(out):
            exec(code, names)
    except Exception as error:
        inside = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == name]
        place = error.lineno if isinstance(error, SyntaxError) else inside[-1]
        raise Wrong(place or block.line, f"{type(error).__name__}: {error}") from error
    return out.getvalue()


def check(name: str, folder: Path, path: str) -> int:
    """Runs a page in an empty folder; the number of blocks compared."""
    page = (BOOK / name).read_text(encoding="utf-8")
    for number, line in enumerate(page.splitlines(), 1):
        for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", line):
            if not (BOOK / target).is_file():
                raise Wrong(number, f"there is no picture {target}")
    names: dict = {"__name__": "__main__"}
    before, output, written, called, compared = None, "", {}, "", 0
    for block in [*blocks(page), None]:
        if block is not None and block.language == "text":
            if before is None:
                raise Wrong(block.line - 1, "a text block shows the output of the sh or python block before it; this one would not be compared")
            compare(block, output)
            before, compared = None, compared + 1
            continue
        if before is not None and before.language == "python" and output:
            raise Wrong(before.line, f"the page does not show what this block prints:\n{output}")
        if block is None:
            break
        before = block
        if block.language == "toml":
            write_model(block, folder)
            written[re.match(r"# (\S+)", block.text)[1]] = block.line
            before = None
        elif block.language == "sh":
            called += block.text
            output = run_shell(block, folder, path)
        else:
            output = run_python(block, name, names)
    for model, line in written.items():
        if model not in called:
            raise Wrong(line, f"no command uses {model}")
    if compared == 0:
        raise Wrong(1, "the page compares nothing")
    return compared


def main() -> None:
    if len(sys.argv) < 2 or not os.access(sys.argv[1], os.X_OK):
        sys.exit(__doc__)
    program = Path(sys.argv[1]).resolve()
    home = os.getcwd()
    for name in sys.argv[2:] or PAGES:
        with tempfile.TemporaryDirectory() as temporary:
            work, tools = Path(temporary) / "work", Path(temporary) / "tools"
            work.mkdir()
            tools.mkdir()
            (tools / "tegula").symlink_to(program)
            path = os.pathsep.join([str(tools), str(Path(sys.executable).parent), os.environ["PATH"]])
            os.chdir(work)
            try:
                print(f"{name}: {check(name, work, path)} outputs are those of the page")
            except Wrong as wrong:
                sys.exit(f"book/src/{name}:{wrong.line}: {wrong}")
            finally:
                os.chdir(home)


if __name__ == "__main__":
    main()
