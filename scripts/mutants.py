#!/usr/bin/env python3
"""Mutation test: how many small errors the tests notice, by module.

    python3 scripts/mutants.py [--out FOLDER] [--shard K/N | --sample N] [--budget SECONDS] [MODULE...]

The program `scripts/mutants` writes all mutants (one operator, sign or returned value changed, as by cargo-mutants) into one copy
of the repository; it is compiled once, and a number in the environment chooses the mutant. Each test runs alone first, which
tells its time and the mutants that it reaches. Then each mutant runs through the tests that reach it, those that noticed its
neighbours first, then the quick ones, until one fails; a test that takes far too long fails. Documentation tests and the tests of
the texts of the repository do not count.

A run takes every twentieth mutant, other ones each week of the year; `--shard 0/1` takes all, `--sample N` takes N of each module,
the same ones each time. With `--budget` a mutant that survives tests of so many seconds counts as missed, though a later test
might have noticed it: the share is then a lower bound. The folder (`target/mutants` unless given; about 5 GB) keeps the copy, the
compiled tests, `outcomes.json`, `table.md`, and `missed.txt` with the mutants that no test noticed. The exit code is 1 if less than
90 % of the mutants of a module are noticed. A mutant that no test reaches is missed; mutants that do not compile do not count.
Linux only.
"""

import argparse
import collections
import concurrent.futures
import datetime
import hashlib
import json
import math
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
LEAST = 0.9
# Parts of all mutants, one a week.
PARTS = 20
MODULES = {
    "element": "crates/tegula/src/element/**/*.rs",
    "material": "crates/tegula/src/material/**/*.rs",
    "analysis": "crates/tegula/src/analysis/**/*.rs",
    "out": "crates/tegula-io/src/out/**/*.rs",
}
# Crates that see the mutants.
CRATES = ("tegula", "tegula-io")
# Test programs that read the texts of the repository.
TEXTS = {"architecture", "book"}
# A test that takes this many times its time, and as many seconds more, is stopped.
TIMES, MORE = 5, 5
# Bytes of memory and of a file that a test may take.
MEMORY, FILE = 6 << 30, 1 << 30
TEST_FILE = re.compile(r"#\[cfg\(test\)\]\s*mod (\w+);")
# The number that makes `is` of the crate below record.
RECORD = 0xFFFFFFFF
CRATE = """//! The chosen mutant: its number is read from the environment when the program starts.
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

const RECORD: u32 = u32::MAX;
static ACTIVE: AtomicU32 = AtomicU32::new(0);
static REACHED: [AtomicBool; 1 << 17] = [const { AtomicBool::new(false) }; 1 << 17];

/// True for the chosen mutant.
#[inline(always)]
pub fn is(number: u32) -> bool {
    let active = ACTIVE.load(Relaxed);
    active == number || (active == RECORD && record(number))
}

/// True if the chosen mutant is one of these, or all are recorded.
#[inline(always)]
pub fn within(first: u32, last: u32) -> bool {
    let active = ACTIVE.load(Relaxed);
    active.wrapping_sub(first) <= last - first || active == RECORD
}

#[cold]
#[inline(never)]
fn record(number: u32) -> bool {
    REACHED[number as usize].store(true, Relaxed);
    false
}

extern "C" fn start() {
    ACTIVE.store(std::env::var("MUTANT").ok().and_then(|n| n.parse().ok()).unwrap_or(0), Relaxed);
}

extern "C" fn end() {
    if ACTIVE.load(Relaxed) == RECORD
        && let Ok(folder) = std::env::var("MUTANT_REACH")
    {
        let all = REACHED.iter().enumerate().filter(|(_, r)| r.load(Relaxed)).map(|(n, _)| format!("{n}\\n"));
        let _ = std::fs::write(format!("{folder}/{}", std::process::id()), all.collect::<String>());
    }
}

#[used]
#[unsafe(link_section = ".init_array")]
static START: extern "C" fn() = start;
#[used]
#[unsafe(link_section = ".fini_array")]
static END: extern "C" fn() = end;
"""


def put(path, text):
    """Writes a file unless it has this text: unchanged files are not compiled again."""
    if not path.exists() or path.read_bytes() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text)


def files_of(module):
    """Source files of a module, without those of tests."""
    paths = sorted(ROOT.glob(MODULES[module]))
    of_tests = set()
    for path in paths:
        folder = path.parent if path.name == "mod.rs" else path.with_suffix("")
        of_tests |= {folder / f"{name}.rs" for name in TEST_FILE.findall(path.read_text(encoding="utf-8"))}
    return [str(p.relative_to(ROOT)) for p in paths if p not in of_tests]


def copy(to, mutated):
    """Copies the repository, with the crate that chooses the mutant."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
    for name in listed.decode().split("\0"):
        if name and name not in mutated and (ROOT / name).is_file():
            text = (ROOT / name).read_bytes()
            if name in [f"crates/{crate}/Cargo.toml" for crate in CRATES]:
                text = text.replace(b"[dependencies]\n", b'[dependencies]\nmutant = { path = "../mutant" }\n', 1)
            if name == "Cargo.toml":
                text = text.replace(b'debug = "line-tables-only"', b"debug = false")
                # The mutants make the code of the kernels long, and the optimiser takes its time.
                text = text.replace(b"opt-level = 2", b"opt-level = 1")
                # One unit needs no optimisation between units, which takes longer than all the rest.
                for crate in CRATES:
                    head = f"[profile.dev.package.{crate}]\n".encode()
                    if head not in text:
                        text += b"\n" + head
                    text = text.replace(head, head + b"codegen-units = 1\n")
                text = text.replace(b'members = [', b'members = ["crates/mutant", ')
            if name != "Cargo.lock" or not (to / name).exists():
                put(to / name, text)
    put(to / "crates/mutant/Cargo.toml", b'[package]\nname = "mutant"\nversion = "0.0.0"\nedition = "2024"\n')
    put(to / "crates/mutant/src/lib.rs", CRATE.encode())


def write_mutants(tool, to, files, dropped):
    """Writes the mutated files; returns all mutants."""
    (to.parent / "dropped.txt").write_text(" ".join(map(str, sorted(dropped))), encoding="utf-8")
    command = [str(tool), str(ROOT), str(to), str(to.parent / "dropped.txt"), *files]
    found = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    return {m["number"]: m for m in found}


def blamed(mutants, start):
    """Mutants of a file that a message of the compiler about one of its bytes points at."""
    for key in ("branches", "site", "body"):
        ranges = [(e - s, m["number"]) for m in mutants for s, e in m[key] if s <= start < e]
        if ranges:
            size = min(ranges)[0]
            return {number for length, number in ranges if length == size}
    return set()


def compile_errors(to, environment):
    """Error messages of the compiler."""
    command = ["cargo", "check", "--workspace", "--lib", "--message-format=json", "--quiet"]
    out = subprocess.run(command, cwd=to, env=environment, capture_output=True, text=True, check=False)
    messages = [json.loads(line) for line in out.stdout.splitlines() if line.startswith("{")]
    errors = [m["message"] for m in messages if m["reason"] == "compiler-message" and m["message"]["level"] == "error"]
    if out.returncode and not errors:
        sys.exit(out.stderr)
    return [e for e in errors if e["spans"]]


def compiling_mutants(tool, to, files, environment):
    """Writes the mutants, leaves out those that do not compile; returns the others."""
    path = to.parent / "not_compiled.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    texts = "\n".join((ROOT / f).read_text(encoding="utf-8") for f in files)
    key = hashlib.sha256(texts.encode()).hexdigest()
    dropped = set(known.get(key, []))
    while True:
        mutants = write_mutants(tool, to, files, dropped)
        errors = compile_errors(to, environment)
        if not errors:
            path.write_text(json.dumps(known | {key: sorted(dropped)}), encoding="utf-8")
            return {n: m for n, m in mutants.items() if n not in dropped}, len(dropped)
        alive, found = collections.defaultdict(list), set()
        for number, mutant in mutants.items():
            if number not in dropped:
                alive[mutant["file"]].append(mutant)
        for error in errors:
            spans = sorted(error["spans"], key=lambda s: not s["is_primary"])
            found |= next((b for s in spans if (b := blamed(alive[s["file_name"]], s["byte_start"]))), set())
        if not found:
            sys.exit("".join(e["rendered"] for e in errors))
        dropped |= found
        print(f"{len(errors)} errors of the compiler, {len(dropped)} mutants left out", flush=True)


def build(to, environment):
    """Compiles the tests; returns the test programs with their folders."""
    command = ["cargo", "test", "--no-run", "--workspace", "--lib", "--bins", "--tests", "--message-format=json", "--quiet"]
    out = subprocess.run(command, cwd=to, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if out.returncode:
        sys.exit("the copy does not compile")
    programs = {}
    for line in out.stdout.splitlines():
        message = json.loads(line) if line.startswith("{") else {"reason": "text"}
        if message["reason"] == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            if message["target"]["name"] not in TEXTS:
                programs[message["executable"]] = str(pathlib.Path(message["manifest_path"]).parent)
    return programs


class Tests:
    """The tests, and how to run one of them."""

    def __init__(self, programs, folder):
        self.folder, self.programs = folder, programs
        self.environment = os.environ | {
            "RAYON_NUM_THREADS": "1",
            "INSTA_UPDATE": "no",
            "PROPTEST_DISABLE_FAILURE_PERSISTENCE": "1",
            "RUST_BACKTRACE": "0",
        }
        self.all = []
        for program in programs:
            out = subprocess.run([program, "--list", "--format", "terse"], capture_output=True, text=True, check=True)
            names = [line.removesuffix(": test") for line in out.stdout.splitlines() if line.endswith(": test")]
            self.all += [(program, name) for name in names]

    def run(self, test, mutant, limit, reach=None):
        """Runs a test with a mutant; True if it passes."""
        program, name = test
        with_mutant = self.environment | {"MUTANT": str(mutant), "CARGO_MANIFEST_DIR": self.programs[program]}
        scratch = self.folder / f"scratch-{threading.get_ident()}"
        scratch.mkdir(parents=True, exist_ok=True)
        with_mutant |= {"TMPDIR": str(scratch)} | ({"MUTANT_REACH": str(reach)} if reach else {})
        process = subprocess.Popen(
            [program, "--exact", name, "--include-ignored", "--test-threads=1", "--quiet"],
            cwd=self.programs[program],
            env=with_mutant,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=limits,
        )
        try:
            return process.wait(limit) == 0
        except subprocess.TimeoutExpired:
            return False
        finally:
            # Its own children, too, if it left any.
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()
            shutil.rmtree(scratch, ignore_errors=True)


def limits():
    """Limits of a test process: a mutant must not fill memory or disk."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def reach(tests, folder, jobs):
    """Seconds of each test that passes and the mutants that it reaches; a file keeps them for programs that stay the same."""
    stamps = {p: os.path.getmtime(p) for p in tests.programs}
    path = folder / "reach.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"programs": {}, "tests": []}
    kept = [t for t in known["tests"] if known["programs"].get(t[0][0]) == stamps.get(t[0][0], 0)]
    new = [t for t in tests.all if known["programs"].get(t[0]) != stamps[t[0]]]

    def one(test):
        to = folder / "reach" / str(abs(hash(test)))
        to.mkdir(parents=True, exist_ok=True)
        passed = tests.run(test, RECORD, 900, to)
        # Recording is slow; the time of the test is that without it.
        start = time.monotonic()
        passed = passed and tests.run(test, 0, 900)
        seconds = time.monotonic() - start
        numbers = {int(n) for part in to.iterdir() for n in part.read_text(encoding="utf-8").split()}
        shutil.rmtree(to)
        if not passed:
            print(f"fails without a mutant, does not count: {test[1]}", flush=True)
        return [test, seconds, sorted(numbers) if passed else []]

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        kept += [r for r in pool.map(one, new) if r[2]]
    path.write_text(json.dumps({"programs": stamps, "tests": kept}), encoding="utf-8")
    return {tuple(test): (seconds, set(numbers)) for test, seconds, numbers in kept}


def judge(mutant, tests, reached, killers, budget):
    """Runs a mutant through the tests that reach it: the outcome, the test that notices, and the seconds of the tests run."""
    number, at = mutant["number"], (mutant["file"], mutant["function"])
    reaching = [t for t, (_, numbers) in reached.items() if number in numbers]
    if not reaching:
        return "unreached", None, 0.0

    def order(test):
        return -killers[at][test], -killers[mutant["file"]][test], reached[test][0]

    spent = 0.0
    for test in sorted(reaching, key=order):
        seconds = reached[test][0]
        if budget and spent + seconds > budget and spent:
            return "budget", None, spent
        spent += seconds
        if not tests.run(test, number, TIMES * seconds + MORE):
            killers[at][test] += 1
            killers[mutant["file"]][test] += 1
            return "caught", test[1], spent
    return "missed", None, spent


def chosen(mutants, module, options):
    """Mutants of a module that a run takes."""
    files = set(files_of(module))
    own = [m for _, m in sorted(mutants.items()) if m["file"] in files]
    if options.sample:
        return random.Random(f"mutants of {module}").sample(own, min(options.sample, len(own)))
    part, parts = map(int, options.shard.split("/"))
    return own[part % parts :: parts]


def interval(caught, total):
    """Confidence interval (95 %) of a share in a sample (Wilson 1927)."""
    z = 1.959964
    if not total:
        return 0.0, 1.0
    p = caught / total
    middle, half = p + z * z / (2 * total), z * math.sqrt(p * (1 - p) / total + z * z / (4 * total * total))
    return (middle - half) / (1 + z * z / total), (middle + half) / (1 + z * z / total)


def table(results, counts):
    """Markdown table of the outcomes of all modules."""
    lines = [
        "| module | all mutants | run | caught | missed | missed in the budget | unreached | noticed | 95 % interval |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---|",
    ]
    for module, found in results.items():
        count = collections.Counter(o["outcome"] for o in found)
        cells = [counts[module], len(found), *(count[k] for k in ("caught", "missed", "budget", "unreached"))]
        low, high = interval(count["caught"], len(found))
        cells += [f"{100 * count['caught'] / max(1, len(found)):.1f} %", f"{100 * low:.0f} to {100 * high:.0f} %"]
        lines.append(f"| {module} | {' | '.join(map(str, cells))} |")
    return "\n".join(lines) + "\n"


def describe(outcome):
    """Line of `missed.txt`."""
    m = outcome["mutant"]
    place = f"{m['file']}:{m['line']}:{m['column']}"
    return f"{place} [{outcome['outcome']}] {m['kind']} in {m['function']}: {m['original'][:160]} → {m['mutant']} ({m['number']})\n"


def write_results(out, results, counts):
    """Writes the files of the results."""
    (out / "table.md").write_text(table(results, counts), encoding="utf-8")
    missed = [o for found in results.values() for o in found if o["outcome"] != "caught"]
    missed.sort(key=lambda o: (o["mutant"]["file"], o["mutant"]["line"], o["mutant"]["column"]))
    (out / "missed.txt").write_text("".join(map(describe, missed)), encoding="utf-8")
    (out / "outcomes.json").write_text(json.dumps(results), encoding="utf-8")


def arguments():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", help=f"of {', '.join(MODULES)}; all unless given")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "target/mutants")
    week = datetime.date.today().isocalendar().week
    parser.add_argument("--shard", metavar="K/N", default=f"{week % PARTS}/{PARTS}", help="the K-th of N parts, K from 0")
    parser.add_argument("--sample", metavar="N", type=int, help="N mutants of each module, the same ones each time")
    parser.add_argument("--budget", metavar="SECONDS", type=float, default=0.0, help="of tests for one mutant; all unless given")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="tests at a time")
    parser.add_argument("--only", metavar="NUMBER", type=int, nargs="+", default=[], help="mutants of these numbers")
    options = parser.parse_args()
    unknown = set(options.modules) - set(MODULES)
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    return options


def main():
    """Run the modules and judge them."""
    options = arguments()
    out = options.out.resolve()
    environment = os.environ | {"CARGO_TARGET_DIR": str(out / "build"), "CARGO_INCREMENTAL": "0"}
    tool = ROOT / "scripts/mutants/Cargo.toml"
    subprocess.run(["cargo", "build", "--quiet", "--manifest-path", str(tool)], env=environment, check=True)
    # Only the modules that are run have mutants: the others are compiled sooner and run at full speed.
    files = [f for module in options.modules or MODULES for f in files_of(module)]
    copy(out / "copy", set(files))
    mutants, not_compiled = compiling_mutants(out / "build/debug/mutants", out / "copy", files, environment)
    print(f"{len(mutants)} mutants, {not_compiled} more do not compile", flush=True)
    tests = Tests(build(out / "copy", environment), out)
    reached = reach(tests, out, options.jobs)
    print(f"{len(reached)} tests reach mutants and take {sum(s for s, _ in reached.values()):.0f} s", flush=True)
    killers = collections.defaultdict(collections.Counter)
    results, counts = {}, {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for module in options.modules or MODULES:
            counts[module] = sum(m["file"] in set(files_of(module)) for m in mutants.values())
            run = [m for m in chosen(mutants, module, options) if not options.only]
            run += [mutants[n] for n in options.only if mutants[n]["file"] in set(files_of(module))]
            results[module] = []

            def one(mutant):
                outcome, test, seconds = judge(mutant, tests, reached, killers, options.budget)
                keys = ("number", "file", "line", "column", "function", "kind", "original", "mutant")
                return {"outcome": outcome, "test": test, "seconds": seconds, "mutant": {k: mutant[k] for k in keys}}

            for outcome in pool.map(one, run):
                results[module].append(outcome)
                if outcome["outcome"] != "caught":
                    print(describe(outcome), end="", flush=True)
                write_results(out, results, counts)
    print(table(results, counts))
    return 1 if any(sum(o["outcome"] == "caught" for o in f) < LEAST * len(f) for f in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
