#!/usr/bin/env python3
"""Feeds arbitrary files to all readers, by cargo-fuzz.

    cargo install cargo-fuzz && rustup toolchain install nightly
    python3 scripts/fuzz.py [--seconds 900] [--keep] [TARGET...]

Each target (`fuzz/readers.rs`) runs for a quarter of an hour unless `--seconds` tells otherwise. Files that make a
reader panic, take 30 s or 2 GiB are kept in `target/fuzz/TARGET/found`, and the exit code is 1: repair the reader and run again.
`--keep` writes the smallest set of files that reach all that was reached, of up to 2000 bytes each, to `fuzz/corpus/TARGET.gz`: a line in
base64 for each file. The test `files_of_the_corpus_are_read_or_refused` feeds these to the readers.
"""

import argparse
import base64
import gzip
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGETS = ["mesh_file", "vtu_file", "keyword_input", "model_file", "result_file", "checkpoint"]
# Examples and data of the tests, with which a target begins beside its corpus.
SEEDS = {
    "mesh_file": ["crates/tegula-io/tests/data/*.msh", "examples/*.inp", "examples/*.bdf"],
    "vtu_file": ["crates/tegula-io/tests/data/vtu/*.vtu"],
    "keyword_input": ["examples/*.inp", "examples/*.bdf"],
    "model_file": ["crates/tegula-io/templates/*.toml", "examples/*.toml"],
    "result_file": [],
    "checkpoint": [],
}
LARGEST = 2000


def fuzz(program: pathlib.Path, target: str, seconds: int, keep: bool) -> bool:
    """Whether a target ran without finding anything."""
    work = ROOT / "target/fuzz" / target
    files, found = work / "corpus", work / "found"
    files.mkdir(parents=True, exist_ok=True)
    found.mkdir(exist_ok=True)
    packed = ROOT / f"fuzz/corpus/{target}.gz"
    for number, line in enumerate(gzip.decompress(packed.read_bytes()).splitlines()):
        (files / f"kept-{number}").write_bytes(base64.b64decode(line))
    for pattern in SEEDS[target]:
        for seed in ROOT.glob(pattern):
            shutil.copy(seed, files)
    limits = ["-timeout=30", "-rss_limit_mb=2048", "-max_len=20000"]
    # One process beside the one that leads: it goes on after a find.
    go_on = ["-fork=1", "-ignore_crashes=1", "-ignore_timeouts=1", "-ignore_ooms=1"]
    subprocess.run(
        [program, files, f"-artifact_prefix={found}/", f"-max_total_time={seconds}", *limits, *go_on], check=False
    )
    if keep:
        smallest = work / "smallest"
        shutil.rmtree(smallest, ignore_errors=True)
        smallest.mkdir()
        subprocess.run([program, "-merge=1", *limits, smallest, files], check=True)
        contents = sorted((path.read_bytes() for path in smallest.iterdir()), key=lambda data: (len(data), data))
        lines = [base64.b64encode(data) for data in contents if len(data) <= LARGEST]
        packed.write_bytes(gzip.compress(b"\n".join(lines) + b"\n", 9, mtime=0))
    return not any(found.iterdir())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=int, default=900)
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args()
    unknown = [target for target in options.targets if target not in TARGETS]
    if unknown:
        parser.error(f"there is no target {unknown[0]}; there are {', '.join(TARGETS)}")
    built = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target/fuzz/build")).resolve()
    # Without the address sanitizer, which would find little in code without `unsafe`, and halves the speed.
    command = ["cargo", "+nightly", "fuzz", "build", "-s", "none"]
    subprocess.run(command, cwd=ROOT / "fuzz", env={**os.environ, "CARGO_TARGET_DIR": str(built)}, check=True)
    programs = next(built.glob("*/release/mesh_file")).parent
    fine = [fuzz(programs / target, target, options.seconds, options.keep) for target in options.targets or TARGETS]
    return 0 if all(fine) else 1


if __name__ == "__main__":
    sys.exit(main())
