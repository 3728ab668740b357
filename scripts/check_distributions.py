#!/usr/bin/env python3
"""Refuses distributions of the Python package that PyPI would show or pip would install wrongly; nothing is compiled.

Usage: check_distributions.py FOLDER, which has wheels and source distributions (`.tar.gz`).

A wheel has all modules of the package, the stub and the mark of types; the source distribution has them, the licences, and all crates, so that
cargo reads it. The texts on PyPI have no relative links.
"""

import re
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MODULES = [path.relative_to(ROOT / "python").as_posix() for path in sorted((ROOT / "python/tegula").rglob("*.py*")) if path.suffix != ".pyc"]


def relative_links(name: str, metadata: str) -> list[str]:
    """Sentences about links of a text that lead nowhere on PyPI."""
    targets = re.findall(r"\]\(([^)\s]*)\)", metadata.partition("\n\n")[2])
    if not targets:
        return [f"{name}: its metadata has no text with links: give pyproject.toml a `readme`"]
    return [f"{name}: the link {target} leads nowhere on PyPI: give the whole address" for target in targets if not target.startswith("https://")]


def of_wheel(path: Path) -> list[str]:
    """Sentences about what is wrong with a wheel."""
    with zipfile.ZipFile(path) as wheel:
        names = wheel.namelist()
        metadata = next(name for name in names if name.endswith(".dist-info/METADATA"))
        out = relative_links(path.name, wheel.read(metadata).decode("utf-8"))
    expected = [*MODULES, "tegula/py.typed"]
    out += [f"{path.name}: {name} is missing" for name in expected if name not in names]
    if not any(re.fullmatch(r"tegula/_tegula\..*(so|pyd)", name) for name in names):
        out.append(f"{path.name}: it has no compiled part")
    for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
        if not any(name.endswith(f".dist-info/licenses/{licence}") for name in names):
            out.append(f"{path.name}: {licence} is missing")
    return out


def of_source(path: Path) -> list[str]:
    """Sentences about what is wrong with a source distribution."""
    with tempfile.TemporaryDirectory() as folder, tarfile.open(path) as archive:
        archive.extractall(folder, filter="data")
        root = Path(folder) / path.name.removesuffix(".tar.gz")
        out = relative_links(path.name, (root / "PKG-INFO").read_text(encoding="utf-8"))
        expected = [*(f"python/{name}" for name in MODULES), "python/tegula/py.typed", "LICENSE-MIT", "LICENSE-APACHE", "Cargo.lock"]
        out += [f"{path.name}: {name} is missing" for name in expected if not (root / name).is_file()]
        command = ["cargo", "metadata", "--locked", "--no-deps", "--format-version", "1", "--manifest-path", str(root / "Cargo.toml")]
        read = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
        if read.returncode:
            out.append(f"{path.name}: cargo does not read it: {read.stderr.strip()}")
        # Files that the crates include when they are compiled, such as templates.
        crates = [file for file in subprocess.run(
            ["git", "ls-files", "crates"], cwd=ROOT, check=True, capture_output=True, text=True, encoding="utf-8"
        ).stdout.splitlines() if re.match(r"crates/(tegula|tegula-io|tegula-python|tegula-sparse)/(src|templates)/", file)]  # fmt: skip
        out += [f"{path.name}: {name} is missing" for name in crates if not (root / name).is_file()]
    return out


def main() -> int:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    wheels, sources = sorted(folder.glob("*.whl")), sorted(folder.glob("*.tar.gz"))
    found = [] if wheels or sources else [f"{folder}: it has no wheel and no source distribution"]
    found += [sentence for path in wheels for sentence in of_wheel(path)]
    found += [sentence for path in sources for sentence in of_source(path)]
    print("\n".join(found) or "the distributions are complete")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
