"""Cost of Python: one model by the command line, by `run` with a progress function, and by `advance` in a loop.

    pip install . && cargo build --release && python3 benches/python_overhead.py

Times on the clock of the whole process with a thread for each processor, the smallest of the repetitions, on an idle machine;
the start of Python and the import of NumPy are listed by themselves. The cost of a call of the progress function is the median
difference of processor times of pairs of runs of 10 000 steps with and without it.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REPETITIONS = 3

MODEL = """
[analysis]
type = "transient"
end_time = 1.0
time_step = 1e-3
[mesh]
type = "cylinder"
center = [0.0, 0.0, 1.0]
axis = [0.0, 1.0, 0.0]
start = [0.0, 0.0, -1.0]
radius = 1.0
angles = [0.0, -90.0]
length = 1.0
[mesh.grid]
elements = [32, 32]
[materials.rubber]
type = "isotropic"
young = 2.1e7
poisson = 0.3
[[sections]]
material = "rubber"
thickness = 0.01
total_mass = 5.0
[[conditions]]
type = "spherical"
on = "u_min_v_min"
[[loads]]
type = "gravity"
value = [0.0, 0.0, -9.81]
[output]
points = [{ name = "opposite", on = "u_max_v_max" }]
pictures = false
interval = 0.1
"""

RUN = "import tegula; n = []; tegula.Model.read('model.toml').run('out', force=True, progress=n.append); assert len(n) == 1001"
LOOP = """
import tegula
s = tegula.Model.read('model.toml').simulation()
while not s.finished:
    s.advance()
"""
# Runs of one element with and without a function follow one another, so that both see the same load of the machine, and the processor time
# is taken, which other processes lengthen least. The cost of a call is the median of the differences; behind it stands its standard error,
# 1.25 σ/√n, with σ from the range between the quartiles.
CALLS = """
import statistics, time, tegula
STEPS, PAIRS = 10_000, 40
text = open('model.toml').read().replace('[32, 32]', '[1, 1]').replace('time_step = 1e-3', f'time_step = {1 / STEPS}')
model = tegula.Model.from_toml(text)
def seconds(progress):
    start = time.process_time()
    model.run(progress=progress)
    return time.process_time() - start
calls = []
seconds(calls.append)
assert len(calls) == STEPS + 1
nothing = lambda p: None
found = [1e6 * (seconds(nothing) - seconds(None)) / len(calls) for _ in range(PAIRS)]
lower, _, upper = statistics.quantiles(found, n=4)
print(f'{statistics.median(found):.2f} ± {1.25 * (upper - lower) / 1.35 / PAIRS**0.5:.2f}')
"""


def elapsed(command: list[str], folder: str) -> float:
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - start


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.toml").write_text(MODEL)
        program = str(ROOT / "target/release/tegula")
        commands = {
            "command line": [program, "run", "model.toml", "--out", "out", "--force", "--quiet"],
            "run() with progress": [sys.executable, "-c", RUN],
            "advance() in a loop, no files": [sys.executable, "-c", LOOP],
            "start of Python": [sys.executable, "-c", "import tegula"],
        }
        times = {name: [] for name in commands}
        for _ in range(REPETITIONS):
            for name, command in commands.items():
                times[name].append(elapsed(command, folder))
        best = {name: min(found) for name, found in times.items()}
        for name, seconds in best.items():
            print(f"{name:32} {seconds:8.3f} s")
        own = best["run() with progress"] - best["start of Python"]
        print(f"overhead of run() with progress: {100 * (own / best['command line'] - 1):.1f} %")
        calls = subprocess.run([sys.executable, "-c", CALLS], cwd=folder, check=True, capture_output=True, text=True)
        print(f"a call of the progress function: {calls.stdout.strip()} µs")


if __name__ == "__main__":
    main()
