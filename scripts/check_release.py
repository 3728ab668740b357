#!/usr/bin/env python3
"""Refuses files of a release that contradict each other: versions, the oldest Rust version, licences, links on PyPI.

Usage: check_release.py
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def contradictions() -> list[str]:
    """Sentences about what does not fit together."""
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
    package = workspace["package"]
    out = []
    citation = (ROOT / "CITATION.cff").read_text()
    for key, value in [("version", package["version"]), ("repository-code", package["repository"])]:
        found = re.search(rf"^{key}: (.*)$", citation, re.MULTILINE)
        if not found or found[1].strip() != value:
            out.append(f"CITATION.cff: `{key}` is not {value}, as in Cargo.toml")
    for name in package["license"].split(" OR "):
        if f"  - {name}\n" not in citation:
            out.append(f"CITATION.cff: the licence {name} of Cargo.toml is missing")
    changes = (ROOT / "CHANGELOG.md").read_text()
    sections = re.findall(r"^## \[(.*)\]", changes, re.MULTILINE)
    if sections[:2] != ["Unreleased", package["version"]]:
        out.append(f"CHANGELOG.md: its first sections are not [Unreleased] and [{package['version']}], the version of Cargo.toml")
    for name, dependency in workspace["dependencies"].items():
        if name.startswith("tegula") and dependency.get("version") != package["version"]:
            out.append(f"Cargo.toml: the version of the dependency {name} is not {package['version']}")
    rust = package["rust-version"]
    for name in ["CONTRIBUTING.md", ".ci/run"]:
        if f"Rust {rust} or later" not in (ROOT / name).read_text():
            out.append(f"{name}: it does not name Rust {rust}, the `rust-version` of Cargo.toml")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    if project["license"] != package["license"]:
        out.append("pyproject.toml: its licence is not that of Cargo.toml")
    for name in project["license-files"]:
        if not (ROOT / name).is_file():
            out.append(f"pyproject.toml: {name} does not exist")
    out += wrong_links("python/README.md", package["repository"])
    return out


def wrong_links(name: str, repository: str) -> list[str]:
    """Sentences about links of a text outside of the repository: relative ones, and those to files that do not exist."""
    out = []
    raw = repository.replace("github.com", "raw.githubusercontent.com")
    for target in re.findall(r"\]\(([^)\s]*)\)", (ROOT / name).read_text(encoding="utf-8")):
        path = re.fullmatch(rf"(?:{re.escape(repository)}/(?:blob|tree)|{re.escape(raw)})/HEAD/([^#]*)(?:#.*)?", target)
        if path and not (ROOT / path[1]).exists():
            out.append(f"{name}: the link {target} leads to a file that does not exist")
        elif not target.startswith("https://"):
            out.append(f"{name}: PyPI shows it, where the link {target} leads nowhere: give the whole address, {repository}/blob/HEAD/…")
    return out


def main() -> int:
    found = contradictions()
    print("\n".join(found) or "the files of a release agree")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
