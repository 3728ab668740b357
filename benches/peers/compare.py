#!/usr/bin/env python3
"""Compute the same problems here and with other programs, and write tables of times and errors.

    cargo build --release
    python3 benches/peers/compare.py --install        # once: venv in target/peers, from PyPI
    python3 benches/peers/compare.py                  # everything; 10 to 30 minutes
    python3 benches/peers/compare.py --only pendulum --peers tegula,EXUDYN
    python3 benches/peers/compare.py --references     # the fine solutions, rarely; an hour; with --only fewer

CalculiX and the libraries of OpenSees come from the system: `apt-get install calculix-ccx liblapack3 libblas3`.
Python 3.11 or another version for which Kratos has a wheel.

Times are those of the whole process, from its start until its results are on disk: CPU seconds (user and
system, with all its children, by `wait4`) and wall seconds. Results go to `target/peers-results`; the tables
also to `book/src/benchmarks/peers.md` with `--book`. Errors are those against converged solutions in
`references.json`; the book's page says how they are meant. A program that cannot do a job shows its message.
"""

import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

import peer_calculix
import peer_exudyn
import peer_kratos
import peer_opensees
import peer_tegula
import problems
from tables import cylinder_rows, pendulum_rows, write_tables

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
VENV = ROOT / "target/peers"
RESULTS = ROOT / "target/peers-results"
PEERS = {peer.NAME: peer for peer in (peer_tegula, peer_kratos, peer_exudyn, peer_opensees, peer_calculix)}

MITC = {"element": "MITCThickShellCorotationalElement3D4N", "tolerance": 1e-6,
        "solver": "LinearSolversApplication.sparse_lu"}
ANCF = {"reduced": 1, "modified": False, "numeric": False, "tolerance": 1e-8}
ASD = {"element": "ASDShellQ4 -corotational", "system": "UmfPack", "steps": 1, "tolerance": 1e-6}


def cylinder_jobs():
    """Every program in as few load steps as it converges with."""
    for n in (8, 16, 24, 32, 48, 64, 96, 128):
        yield "tegula", "ems", {"elements": n}
    # As Kratos' element has it.
    for element in "ems", "mitc4":
        for n in (8, 16, 32, 64):
            yield "tegula", element + ", stabilised shear", {"elements": n, "element": element,
                                                             "shear_stabilization": 0.1}
    yield "tegula", "ems, 2 threads", {"elements": 64, "threads": 2}
    for n in (16, 32, 64):
        yield "Kratos", "MITC corotational, sparse LU", {"elements": n, "steps": 1, **MITC}
    yield "Kratos", "MITC corotational, AMGCL", {"elements": 64, "steps": 1, **MITC, "solver": "amgcl"}
    for n in (32, 64):
        yield "Kratos", "MITC corotational, sparse LU, 5 load steps", {"elements": n, "steps": 5, **MITC}
    yield "Kratos", "DKQ thin corotational", {"elements": 32, "steps": 2, **MITC,
                                              "element": "ShellThinElementCorotational3D4N"}
    # Waiting threads of OpenMP count as work.
    yield "Kratos", "MITC corotational, sparse LU, 2 threads", {"elements": 64, "steps": 1, "threads": 2, **MITC}
    for n in (8, 16, 32, 64):
        yield "EXUDYN", "ANCF thin plate", {"elements": n, "steps": 1, **ANCF}
    for n in (16, 32, 64):
        yield "OpenSees", "ASDShellQ4 corotational, UMFPACK", {"elements": n, **ASD}
    yield "OpenSees", "ShellNLDKGQ, UMFPACK", {"elements": 16, **ASD, "element": "ShellNLDKGQ", "steps": 10}
    for n in (16, 32, 64):
        yield "CalculiX", "S4, SPOOLES", {"elements": n, "element": "S4", "increment": 1.0}
    yield "CalculiX", "S4R, SPOOLES", {"elements": 32, "element": "S4R", "increment": 1.0}
    for n in (8, 16, 32):
        yield "CalculiX", "S8R, SPOOLES", {"elements": n, "element": "S8R", "increment": 1.0}


def pendulum_jobs():
    """8 x 8 elements, 1 s; every program with steps of several sizes."""
    for tolerance in (1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7):
        yield "tegula", "Newmark, tolerance %g" % tolerance, {"tolerance": tolerance}
    dynamic = {**ANCF, "radius": 0.9, "modified": True, "numeric": True}
    for dt in (0.0025, 0.00125, 0.000625):
        yield "EXUDYN", "generalized alpha 0.9, %g ms" % (1e3 * dt), {"dt": dt, **dynamic}
    yield "EXUDYN", "the same, tolerance 1e-5", {"dt": 0.00125, **dynamic, "tolerance": 1e-5}
    for dt in (0.0025, 0.00125):
        yield "Kratos", "Bossak -0.05, %g ms" % (1e3 * dt), {"dt": dt, "alpha": -0.05, **MITC}
    yield "Kratos", "Newmark, 2.5 ms", {"dt": 0.0025, "alpha": 0.0, **MITC}


def reference_jobs():
    """What the errors are measured against: name, program, job.

    Those of the pendulum have a quarter of the smallest step of the same scheme, which a tolerance goes with to the third
    power.
    """
    for n in (64, 128, 256):
        yield "cylinder tegula %d" % n, "tegula", {"problem": "cylinder", "elements": n}
        yield "cylinder tegula mitc4 %d" % n, "tegula", {"problem": "cylinder", "elements": n, "element": "mitc4"}
    finest = {}
    for peer, _, job in pendulum_jobs():
        size, key = "dt" if "dt" in job else "tolerance", problems.reference_of(peer, job)
        if key not in finest or job[size] < finest[key][1][size]:
            finest[key] = peer, job
    for key, (peer, job) in finest.items():
        finer = {"dt": job["dt"] / 4} if "dt" in job else {"tolerance": job["tolerance"] / 4**3}
        yield key, peer, {**job, **finer, "problem": "pendulum", "elements": 8}


def install():
    """Makes the virtual environment and installs all peers of PyPI in their newest versions."""
    subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
    for peer in PEERS.values():
        if peer.PACKAGES:
            done = subprocess.run([VENV / "bin/pip", "install", "--quiet", *peer.PACKAGES])
            print(peer.NAME, "installed" if done.returncode == 0 else "cannot be installed: see above")


def compute(name, job, limit, results=RESULTS):
    """One job in a process of its own: `result.json` and the times, or the reason why there is none."""
    peer, folder = PEERS[name], results.resolve() / "job"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    job_file = folder / "job.json"
    job_file.write_text(json.dumps(job))
    threads = str(job.get("threads", 1))
    environment = {**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads, "CCX_NPROC": threads}
    try:
        line = peer.command(str(VENV / "bin/python"), str(job_file))
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
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    words = [x for x in (folder / "log.txt").read_text(errors="replace").splitlines()
             if x.strip(" =*|") and x != "Process 0 Terminating"]
    if process.returncode == 0 and hasattr(peer, "finish"):
        try:
            peer.finish(job, folder)
        except (OSError, KeyError, ValueError) as error:
            words.append("results cannot be read: %r" % error)
    cpu = usage.ru_utime + usage.ru_stime
    if not (folder / "result.json").exists():
        errors = [x for x in words if x.startswith("error: ")]
        last = (errors or words or ["ended with %d" % process.returncode])[-1].strip()
        return {"failure": last[:120], "cpu": cpu, "wall": wall}
    return {**json.loads((folder / "result.json").read_text()), "cpu": cpu, "wall": wall}


def best_of(repeats, name, job, limit, results):
    """Short jobs are repeated: the machine may be busy with other work."""
    best = compute(name, job, limit, results)
    for _ in range(repeats - 1):
        if "failure" in best or best["wall"] > 10:
            break
        again = compute(name, job, limit, results)
        if again.get("cpu", math.inf) < best["cpu"]:
            best = again
    return best


def keep(runs, problem, kept, raw):
    """Writes all runs so far, so that an interrupted comparison can be resumed."""
    runs[problem] = sorted(kept, key=lambda run: list(PEERS).index(run["peer"]))
    raw.parent.mkdir(parents=True, exist_ok=True)
    raw.write_text(json.dumps(runs))


def machine():
    """Processor, cores and system, for the table."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return "%s, %d cores, %s" % (model, os.cpu_count(), platform.platform(terse=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--install", action="store_true", help="install the peers and end")
    parser.add_argument("--references", action="store_true", help="compute references.json again and end")
    parser.add_argument("--only", choices=("cylinder", "pendulum"), help="one of the problems")
    parser.add_argument("--peers", help="names, separated by commas; tegula always takes part")
    parser.add_argument("--largest", type=int, default=128, help="finest mesh of the cylinder")
    parser.add_argument("--repeat", type=int, default=3, help="best of so many, for runs below 10 s")
    parser.add_argument("--limit", type=float, default=1800, help="wall seconds after which a job is given up")
    parser.add_argument("--resume", action="store_true", help="keep what earlier runs have computed")
    parser.add_argument("--out", type=pathlib.Path, default=RESULTS, help="folder of results")
    parser.add_argument("--note", help="a sentence to put below the tables")
    parser.add_argument("--book", action="store_true", help="put the tables into the book")
    options = parser.parse_args()
    if options.install:
        return install()
    if options.references:
        kept = HERE / "references.json"
        found = json.loads(kept.read_text()) if options.only else {}
        for key, name, job in reference_jobs():
            if options.only not in (None, job["problem"]):
                continue
            result = compute(name, job, 7200)
            if "failure" in result:
                sys.exit("%s: %s" % (key, result["failure"]))
            found[key] = {k: result[k] for k in ("version", "points", "history") if result.get(k)}
            print(key, flush=True)
        return kept.write_text(json.dumps(found) + "\n")
    wanted = set(options.peers.split(",")) | {"tegula"} if options.peers else set(PEERS)
    raw = options.out / "raw.json"
    runs = json.loads(raw.read_text()) if raw.exists() else {}
    for problem, jobs in ("cylinder", cylinder_jobs), ("pendulum", pendulum_jobs):
        if options.only not in (None, problem):
            continue
        earlier = runs.get(problem, [])
        kept = [run for run in earlier if run["peer"] not in wanted]
        for name, label, job in jobs():
            job = {"problem": problem, "elements": 8, **job}
            if name not in wanted or job["elements"] > options.largest:
                continue
            same = [run for run in earlier if options.resume and run["label"] == label and run["job"] == job
                    and not run["result"].get("failure", "").startswith("not done")]
            if same:
                kept += same
                continue
            result = best_of(options.repeat, name, job, options.limit, options.out)
            print(problem, name, label, job["elements"], result.get("failure") or "%.2f CPU s, %.2f s"
                  % (result["cpu"], result["wall"]), flush=True)
            kept.append({"peer": name, "label": label, "job": job, "result": result})
            keep(runs, problem, kept, raw)
        keep(runs, problem, kept, raw)
    references = json.loads((HERE / "references.json").read_text())
    about = {"date": datetime.date.today().isoformat(), "machine": machine(), "note": options.note,
             "repeat": options.repeat}
    tables = {"cylinder": cylinder_rows(runs.get("cylinder", []), references),
              "pendulum": pendulum_rows(runs.get("pendulum", []), references)}
    page = ROOT / "book/src/benchmarks/peers.md" if options.book else None
    write_tables(tables, runs, about, options.out, page)


if __name__ == "__main__":
    main()
