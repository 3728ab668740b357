#!/usr/bin/env python3
"""Compute the same three problems here and with other programs, and write tables of errors, times and ratios.

    cargo build --release
    python3 benches/peers/compare.py --install                        # once: venv in target/peers, from PyPI
    python3 benches/peers/compare.py --repetitions 4 --book     # about half an hour on one quiet core
    python3 benches/peers/compare.py --only pendulum --peers tegula,EXUDYN
    python3 benches/peers/compare.py --limits                         # the solutions that errors refer to: hours, rarely

CalculiX and the libraries of OpenSees come from the system: `apt-get install calculix-ccx liblapack3 libblas3`.
Python 3.11 or another version for which Kratos has a wheel. TEGULA and PEERS_PYTHON in the environment name another program
and another interpreter than `target/release/tegula` and `target/peers/bin/python`.

Times are those of the whole process, from its start until its results are on disk: CPU seconds (user and
system, with all its children, by `wait4`) and wall seconds. All runs are done once, then all once more, and so on. What
has been computed is kept in the folder of results, one file a run, so that an interrupted comparison goes on where
it stopped; other settings, or another build of tegula, are other runs. The tables go to that folder, as Markdown and CSV, and to
`book/src/benchmarks/peers.md` with `--book`. The book's page says what the errors and ratios are.
"""

import argparse
import datetime
import hashlib
import importlib.util
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

import jobs
import limits
import peer_calculix
import peer_exudyn
import peer_kratos
import peer_opensees
import peer_tegula
import tables

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
VENV = ROOT / "target/peers"
PYTHON = os.environ.get("PEERS_PYTHON") or str(VENV / "bin/python")
RESULTS = ROOT / "target/peers-results"
PEERS = {peer.NAME: peer for peer in (peer_tegula, peer_kratos, peer_exudyn, peer_opensees, peer_calculix)}


def install():
    """Makes the virtual environment and installs all peers of PyPI in their newest versions."""
    subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
    for peer in PEERS.values():
        if peer.PACKAGES:
            done = subprocess.run([VENV / "bin/pip", "install", "--quiet", *peer.PACKAGES])
            print(peer.NAME, "installed" if done.returncode == 0 else "cannot be installed: see above")


def compute(peer, job, limit, folder):
    """One job in a process of its own: what it found and its times, or the reason why it found nothing."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    job_file = folder / "job.json"
    job_file.write_text(json.dumps(job))
    threads = str(job.get("threads", 1))
    environment = {**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads, "CCX_NPROC": threads}
    try:
        line = peer.command(PYTHON, str(job_file))
        start = time.perf_counter()
        with open(folder / "log.txt", "w") as log:
            process = subprocess.Popen(line, cwd=folder, env=environment, stdout=log, stderr=log)
    except OSError as error:
        return {"failure": str(error)}
    usage = None
    while usage is None:
        pid, status, rusage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            usage = rusage
        elif time.perf_counter() - start > limit:
            process.kill()
            os.wait4(process.pid, 0)
            return {"failure": "not done after %g s" % limit}
        else:
            time.sleep(0.002)
    times = {"wall": time.perf_counter() - start, "cpu": usage.ru_utime + usage.ru_stime}
    process.returncode = os.waitstatus_to_exitcode(status)
    failure = "ended with %d" % process.returncode
    if process.returncode == 0:
        try:
            return {**peer.finish(job, folder), **times}
        except (OSError, KeyError, ValueError, IndexError) as error:
            failure = "results cannot be read: %r" % error
    words = [x.strip() for x in (folder / "log.txt").read_text(errors="replace").splitlines()
             if x.strip(" =*|") and x != "Process 0 Terminating"]
    errors = [x for x in words if x.lower().lstrip("*").startswith("error")]
    return {"failure": (errors or words or [failure])[-1][:160], **times}


def kept_in(out, name, job, timed=True):
    """File of a run: its name tells program, settings and, of tegula where times matter, the build. Runs for limits, which may
    have shared the machine with others, lie apart."""
    build = hashlib.sha256(peer_tegula.PROGRAM.read_bytes()).hexdigest() if name == "tegula" and timed else ""
    key = hashlib.sha256(json.dumps([name, job, build], sort_keys=True).encode()).hexdigest()[:16]
    return out / ("runs" if timed else "limits") / ("%s-%s-%s.json" % (job["problem"], name, key))


def run_all(chosen, repetitions, limit, out, timed=True, peers=PEERS):
    """Does what is missing of all runs, repetition by repetition, and returns them with what they found."""
    runs = [{**run, "file": kept_in(out, run["peer"], run["job"], timed)} for run in chosen]
    for repetition in range(repetitions):
        for run in runs:
            found = json.loads(run["file"].read_text()) if run["file"].exists() else []
            if len(found) > repetition or (found and "failure" in found[-1]):
                continue
            result = compute(peers[run["peer"]], run["job"], limit, out / ("job-%d" % os.getpid()))
            run["file"].parent.mkdir(parents=True, exist_ok=True)
            run["file"].write_text(json.dumps(found + [result]))
            settings = {k: v for k, v in run["job"].items() if k in ("elements", "dt", "steps", "analysis")}
            print(repetition + 1, run["job"]["problem"], run["peer"], run["family"], settings,
                  result.get("failure") or "%.2f CPU s, %.2f s" % (result["cpu"], result["wall"]), flush=True)
    return [{**run, "found": json.loads(run["file"].read_text())[:repetitions]} for run in runs if run["file"].exists()]


def machine():
    """Processor, cores and system, for the tables."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return "%s, %d cores, %s" % (model, os.cpu_count(), platform.platform(terse=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--install", action="store_true", help="install the peers and end")
    parser.add_argument("--limits", action="store_true", help="compute limits.json again and end")
    parser.add_argument("--only", choices=tuple(jobs.PROBLEMS), help="one of the problems")
    parser.add_argument("--peers", help="names, separated by commas; tegula always takes part")
    parser.add_argument("--repetitions", type=int, default=3, help="of every run")
    parser.add_argument("--limit", type=float, default=1800, help="wall seconds after which a run is given up")
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS, help="folder of results")
    parser.add_argument("--tables", action="store_true", help="tables of what has been computed; compute nothing")
    parser.add_argument("--note", help="a sentence to put below the tables")
    parser.add_argument("--book", action="store_true", help="put the tables into the book")
    options = parser.parse_args()
    if options.install:
        return install()
    if importlib.util.find_spec("numpy") is None:
        # The environment of the peers has it.
        os.execv(PYTHON, [PYTHON, *sys.argv])
    out = options.out.resolve()
    if options.limits:
        runs = run_all([run for run in jobs.limit_runs() if options.only in (None, run["job"]["problem"])], 1, 6 * 3600, out, timed=False)
        return limits.write(runs, HERE / "limits.json", keep=options.only)
    wanted = set(options.peers.split(",")) | {"tegula"} if options.peers else set(PEERS)
    chosen = [run for run in jobs.runs() if options.only in (None, run["job"]["problem"]) and run["peer"] in wanted]
    repetitions = options.repetitions
    if options.tables:
        chosen = [run for run in chosen if kept_in(out, run["peer"], run["job"]).exists()]
    runs = run_all(chosen, 0 if options.tables else repetitions, options.limit, out)
    if options.tables:
        runs = [{**run, "found": json.loads(run["file"].read_text())[:repetitions]} for run in runs]
    about = {"date": datetime.date.today().isoformat(), "machine": machine(), "note": options.note}
    page = ROOT / "book/src/benchmarks/peers.md" if options.book else None
    tables.write(runs, json.loads((HERE / "limits.json").read_text()), about, out, page)


if __name__ == "__main__":
    main()
