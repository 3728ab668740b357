#!/usr/bin/env python3
"""Factor the same shell matrices here and with Intel's MKL PARDISO, and print a table of ratios.

    python3 -m venv /tmp/peers && /tmp/peers/bin/pip install mkl numpy
    cargo build --release --example factor_times
    /tmp/peers/bin/python benches/peers/pardiso.py [ELEMENTS ...]

Both programs run one after the other on the same machine. Times are the best of five.
"""

import ctypes
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
OURS = ROOT / "target/release/examples/factor_times"


def mkl():
    """The library of the wheel, wherever pip put it."""
    libraries = pathlib.Path(sys.prefix) / "lib"
    names = sorted(libraries.glob("libmkl_rt.so*"))
    if not names:
        sys.exit(f"no libmkl_rt.so in {libraries}: pip install mkl")
    return ctypes.CDLL(str(names[0]))


def pardiso(library, threads, path):
    """Best times of analysis, factorisation and solution in seconds."""
    library.MKL_Set_Num_Threads(threads)
    raw = path.read_bytes()
    n, entries = (int(x) for x in np.frombuffer(raw, np.uint64, 2))
    at = 16
    pointers = np.frombuffer(raw, np.uint64, n + 1, at).astype(np.int32) + 1
    at += 8 * (n + 1)
    rows = np.frombuffer(raw, np.uint64, entries, at).astype(np.int32) + 1
    values = np.frombuffer(raw, np.float64, entries, at + 8 * entries).copy()
    handle, options = np.zeros(64, np.int64), np.zeros(64, np.int32)
    # Own options: nested dissection, no matching.
    options[0], options[1] = 1, 2
    right, x, order = np.ones(n), np.zeros(n), np.zeros(n, np.int32)

    def call(phase):
        integer = lambda k: ctypes.byref(ctypes.c_int(k))
        data = lambda a: a.ctypes.data_as(ctypes.c_void_p)
        error = ctypes.c_int(0)
        start = time.perf_counter()
        # Lower columns are upper rows: type 2 is symmetric positive definite.
        library.pardiso(data(handle), integer(1), integer(1), integer(2), integer(phase), integer(n), data(values),
                        data(pointers), data(rows), data(order), integer(1), data(options), integer(0), data(right),
                        data(x), ctypes.byref(error))
        if error.value != 0:
            sys.exit(f"PARDISO ended with {error.value} in phase {phase}")
        return time.perf_counter() - start

    times = [call(11), min(call(22) for _ in range(5)), min(call(33) for _ in range(5))]
    call(-1)
    return times


def main():
    library = mkl()
    sizes = [int(a) for a in sys.argv[1:]] or [64, 128, 256]
    print("| unknowns | threads | step | tegula [ms] | PARDISO [ms] | ratio |")
    print("|---:|---:|:--|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        matrix = pathlib.Path(folder) / "matrix.bin"
        for elements in sizes:
            for threads in (1, 2):
                out = subprocess.run([OURS, str(elements), str(threads), matrix], check=True, capture_output=True)
                unknowns, *ours = out.stdout.split()[:4]
                theirs = pardiso(library, threads, matrix)
                for step, a, b in zip(("analysis", "factorisation", "solution"), map(float, ours), theirs):
                    print(f"| {int(unknowns)} | {threads} | {step} | {1e3 * a:.1f} | {1e3 * b:.1f} | {a / b:.2f} |",
                          flush=True)


if __name__ == "__main__":
    main()
