#!/usr/bin/env python3
"""Packs the crates as for crates.io and checks that they could be published.

Usage: check_packages.py [--compile]

Each package has a README and both licences, and `cargo publish --dry-run` (of Rust 1.90 or later) has no objection to any of them. With `--compile`, which takes some minutes, all of them compile from what is packed, without the
files of the repository.
"""

import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NEEDED = ["README.md", "LICENSE-MIT", "LICENSE-APACHE", "Cargo.toml"]


def main() -> int:
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
    all_crates = ["--workspace", "--exclude", "tegula-python", "--no-verify", "--allow-dirty", "--quiet"]
    command = ["cargo", "package", *all_crates]
    subprocess.run(["cargo", "publish", "--dry-run", *all_crates], cwd=ROOT, check=True)
    for old in (target / "package").glob("*.crate"):
        old.unlink()
    subprocess.run(command, cwd=ROOT, check=True)
    packages = sorted((target / "package").glob("*.crate"))
    missing = []
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for package in packages:
            with tarfile.open(package) as archive:
                archive.extractall(folder, filter="data")
            name = package.stem
            names.append(name)
            missing += [f"{package.name}: no {needed}" for needed in NEEDED if not (Path(folder) / name / needed).is_file()]
        versionless = {name: name.rsplit("-", 1)[0] for name in names}
        patches = "".join(f'{crate} = {{ path = "{name}" }}\n' for name, crate in versionless.items())
        members = ", ".join(f'"{name}"' for name in names)
        workspace = f'[workspace]\nresolver = "3"\nmembers = [{members}]\n\n[patch.crates-io]\n{patches}'
        (Path(folder) / "Cargo.toml").write_text(workspace)
        (Path(folder) / "Cargo.lock").write_bytes((ROOT / "Cargo.lock").read_bytes())
        environment = {**os.environ, "CARGO_TARGET_DIR": str(target / "package/build")}
        check = ["cargo", "check", "--quiet", "--workspace"]
        if "--compile" in sys.argv and subprocess.run(check, cwd=folder, env=environment, check=False).returncode:
            missing.append("the packages do not compile without the repository")
    print("\n".join(missing) or f"{len(packages)} packages are complete")
    return 1 if missing or len(packages) < 5 else 0


if __name__ == "__main__":
    sys.exit(main())
