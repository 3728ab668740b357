"""Reports in a browser: how long one takes to open, and how fast its shapes move.

    pip install . selenium && python3 benches/report_frames.py [REPORT.html ...]

Needs Chromium with its driver, as the tests of `python/tests/browser.py` do. Without arguments a square plate of 64 × 64 elements is computed
in 200 states. Chromium draws without a graphics card, so that the figures are those of the slowest computers; an idle machine is needed. The processor time for each drawing, of all
processes of Chromium, depends less on what else the machine does; some 25 to 40 ms of it a page costs in which a line of text alone changes.

The canvas has 1066 × 532 pixels. The opening time is that from the navigation to the first picture. While the states play, the times that
`requestAnimationFrame` hands over at the drawings are kept, 100 at least, and the median of the times between two of them is printed with the drawings
per second; nothing is read back from the graphics card. The states of a report last six seconds, so that 200 states are 33 drawings per second at most.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python/tests"))

from browser import chromium  # noqa: E402
from reports import fine_model  # noqa: E402

DRAWINGS = 101

PLAY = """
const [wanted, done] = arguments, times = [];
window.report.then(({ stage }) => {
  const { viewer } = stage, { draw } = viewer;
  let ticks = 0, present = performance.now();
  const turn = (now) => {
    ticks++;
    present = now;
    if (times.length < wanted) return requestAnimationFrame(turn);
    viewer.draw = draw;
    stage.stop();
    done([times, viewer.canvas.clientWidth, viewer.canvas.clientHeight, ticks]);
  };
  requestAnimationFrame(turn);
  viewer.draw = function (...rest) {
    draw.apply(viewer, rest);
    times.push(present);
  };
  stage.at(0);
  stage.toggle();
});
"""


def processor_time(driver: int) -> float:
    """Seconds of the processors that Chromium has spent, with the software that draws in place of a graphics card."""
    parents: dict[int, list[int]] = {}
    spent: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents.setdefault(int(fields[1]), []).append(int(entry.name))
        spent[int(entry.name)] = int(fields[11]) + int(fields[12])
    found, total = [driver], 0
    while found:
        process = found.pop()
        total += spent.get(process, 0)
        found += parents.get(process, [])
    return total / os.sysconf("SC_CLK_TCK")


def measured(path: Path) -> None:
    """Opens a report, plays it and prints the figures."""
    browser = chromium(1200, 1000)
    try:
        browser.get(path.resolve().as_uri())
        opened = browser.execute_async_script(
            "const done = arguments[0];"
            "window.report.then(() => requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now()))));"
        )
        if not browser.execute_async_script("const done = arguments[0]; window.report.then(({ stage }) => done(Number(stage.slider.max)));"):
            print(f"{path.name}: opened in {opened / 1000:.2f} s; it has one state, which does not move")
            return
        browser.execute_script("document.querySelector('canvas').scrollIntoView({ block: 'center' });")
        before = processor_time(browser.service.process.pid)
        times, width, height, ticks = browser.execute_async_script(PLAY, DRAWINGS)
        spent = processor_time(browser.service.process.pid) - before
    finally:
        browser.quit()
    gaps = [b - a for a, b in zip(times, times[1:])]
    print(
        f"{path.name}: {path.stat().st_size / 1e6:.1f} MB, opened in {opened / 1000:.2f} s, canvas {width} × {height},",
        f"median {statistics.median(gaps):.1f} ms between drawings, {1000 * len(gaps) / (times[-1] - times[0]):.1f} drawings per second,",
        f"{1000 * spent / len(times):.1f} ms of processor time for each, {1000 * ticks / (times[-1] - times[0]):.0f} turns of the page per second",
    )


def main() -> None:
    paths = [Path(name) for name in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as folder:
        if not paths:
            import tegula

            paths = [tegula.Model(fine_model()).run(folder).report()]
        for path in paths:
            measured(path)


if __name__ == "__main__":
    main()
