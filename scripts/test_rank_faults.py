#!/usr/bin/env python3
"""Tests faults of runs on several ranks: test_rank_faults.py PROGRAM [KILLS].

If KILLS is not 0, a rank is killed so often at random moments, and the run resumed until it ends: its history is that of an undisturbed run, with the iterative solver to the last bit. Ctrl-C stops all
ranks, and the run goes on on another number of ranks. A rank that cannot write ends all. Ranks with other model files, without a model, and with a result folder of another model are refused with a message of one rank.
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from test_ranks import ENVIRONMENT, ROOT, compare, prepared, run, same_bits

MODEL = ROOT / "examples/quarter_cylinder_pendulum.toml"
PLATE = ROOT / "verification/models/quarter_cylinder.toml"


def command(program, ranks, out, *more, model=MODEL):
    return ["mpirun", "-n", str(ranks), program, "run", str(model), "--out", str(out), "--quiet", "-j", "1", *more]


def ranks_of(process):
    """Processes that an `mpirun` has started."""
    found = []
    for folder in Path("/proc").iterdir():
        try:
            parent = int(folder.joinpath("stat").read_text().rsplit(")", 1)[1].split()[1]) if folder.name.isdigit() else 0
        except (OSError, ValueError):
            continue
        if parent == process.pid:
            found.append(int(folder.name))
    return sorted(found)


def killed(program, folder, kills, model, is_exact=False):
    """A run one of whose ranks is killed again and again, resumed to its end."""
    random.seed(1)
    whole, out, resume = folder / f"{model.stem}-whole", folder / f"{model.stem}-killed", []
    done = run(command(program, 2, whole, model=model))
    assert done.returncode == 0, done.stderr
    for _ in range(kills):
        process = subprocess.Popen(
            command(program, 2, out, *resume, model=model), env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(random.uniform(1.0, 5.0))
        ranks = ranks_of(process)
        if ranks:
            try:
                os.kill(random.choice(ranks), signal.SIGKILL)
            except ProcessLookupError:
                pass
        assert process.wait(timeout=60) != 0 or not ranks, "a run with a killed rank has ended as if nothing were wrong"
        resume = ["--resume"] if (out / "checkpoint.bin").is_file() else ["--force"]
    done = run(command(program, 2, out, *resume, model=model))
    assert done.returncode == 0, done.stderr
    wrong, worst = compare(whole, out, kills)
    wrong += same_bits(whole, out) if is_exact else []
    assert not wrong, wrong
    how = "to the last bit" if is_exact else f"to {worst:.1e} of the limits"
    print(f"{model.stem}: {kills} times a rank was killed; the history is that of an undisturbed run {how}", flush=True)
    return whole


def stopped(program, folder, whole):
    """A run that Ctrl-C stops, and another number of ranks ends."""
    out = folder / "stopped"
    process = subprocess.Popen(command(program, 2, out), env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(3.0)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode != 0, "the run has ended before it was stopped"
    done = run(command(program, 3, out, "--resume"))
    assert done.returncode == 0, done.stderr
    wrong, _ = compare(whole, out, 1)
    assert not wrong, wrong
    print("stopped on 2 ranks, ended on 3")


def refused(program, folder):
    """Mistakes of the call, each with a part of its message."""
    other = folder / "other.toml"
    other.write_text(PLATE.read_text().replace("\n", "\n# other\n", 1))
    first, second = (["-n", "1", program, "run", str(model), "--out", str(folder / "two")] for model in (PLATE, other))
    missing = ["-n", "1", program, "run", str(folder / "none.toml"), "--out", str(folder / "two")]
    wrong = folder / "wrong.toml"
    wrong.write_text("[nothing]\n" + PLATE.read_text())
    cases = [
        (["mpirun", *first, ":", *second], "the model files of the ranks differ"),
        (["mpirun", *first, ":", *missing], "can be read by rank 0, but not by all others"),
        (command(program, 2, folder / "two", model=folder / "none.toml"), "there is no such file"),
        *[(command(program, 5, folder / "two", model=wrong), 'unknown key "nothing"')] * 5,
        (command(program, 2, folder / "strip", model=PLATE), "it holds the results of another model"),
    ]
    done = run(command(program, 2, folder / "strip", model=ROOT / "examples/stress_wave.toml"))
    assert done.returncode == 0, done.stderr
    for call, message in cases:
        done = run(call, timeout=60)
        said = done.stdout + done.stderr
        assert done.returncode != 0 and said.count("error: ") == 1 and message in said, said
    print(f"{len(cases)} mistakes are refused")


def unwritable(program, folder):
    """A rank that cannot write any more ends all of them with its message."""
    temporary = folder / "temporary"
    temporary.mkdir()
    process = subprocess.Popen(
        command(program, 2, folder / "unwritable"), env=ENVIRONMENT | {"TMPDIR": str(temporary)}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    deadline = time.time() + 60
    while not list(temporary.glob("tegula-rank-*/results/history.csv")):
        assert time.time() < deadline and process.poll() is None, "rank 1 does not begin"
        time.sleep(0.1)
    for path in temporary.glob("tegula-rank-*"):
        shutil.rmtree(path, ignore_errors=True)
    said, _ = process.communicate(timeout=120)
    assert process.returncode != 0 and said.count("error: rank 1 of 2") == 1, said
    print("a rank that cannot write ends all")


def main():
    program = str(Path(sys.argv[1]).resolve())
    kills = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        refused(program, folder)
        unwritable(program, folder)
        if kills:
            stopped(program, folder, killed(program, folder, kills, MODEL))
            model, _ = prepared("examples/quarter_cylinder_static.toml:iterative", folder)
            model.write_text(model.read_text().replace('solver = "iterative"', 'solver = "iterative"\nload_steps = 40'))
            killed(program, folder, kills, model, is_exact=True)


if __name__ == "__main__":
    main()
