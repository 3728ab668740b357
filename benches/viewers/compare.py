"""The viewer of reports beside libraries that could take its place: size, time and processor time of a picture of one animation.

    pip install selenium && python3 benches/viewers/compare.py [--rounds 3]

Needs Chromium with its driver, Node and the network: `npm` fetches the libraries, and esbuild bundles what a page needs of them. A mesh of 64 × 64 quadrilaterals
moves and changes its colours in each picture on a canvas of 1066 × 532 pixels; Chromium draws without a graphics card. The times are those between two turns of
`requestAnimationFrame`, medians of 100 pictures; the processor time is that of all processes of the browser. The README of
`crates/tegula-io/assets/report` has the table.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "python/tests"), str(ROOT / "benches")]

from browser import chromium  # noqa: E402
from report_frames import processor_time  # noqa: E402

PACKAGES = ["three@0.187", "@kitware/vtk.js@37.4", "plotly.js-dist-min@4.1", "esbuild@0.28"]
PICTURES = 100
COLOURS = '<script type="application/json" id="colours">{"palette": ["#0072b2"], "viridis": ["#440154", "#21918c", "#fde725"]}</script>'
CANVAS = '<canvas style="width: 1066px; height: 532px"></canvas>'
BOX = '<div id="box" style="width: 1066px; height: 532px"></div>'


def scripts(folder: Path) -> dict[str, tuple[str, str]]:
    """What each page holds besides its own script: its element, and the library, which esbuild bundles with the script where it is a module."""
    subprocess.run(["npm", "install", "--silent", "--prefix", folder, *PACKAGES], check=True)
    for name in ("three", "vtk"):
        (folder / f"{name}.js").write_text((HERE / f"{name}.js").read_text(), encoding="utf-8")
        bundle = [folder / "node_modules/.bin/esbuild", folder / f"{name}.js", "--bundle", "--minify", f"--outfile={folder / name}.min.js"]
        subprocess.run(bundle, check=True, capture_output=True)
    own = ROOT / "crates/tegula-io/assets/report/viewer.js"
    plotly = folder / "node_modules/plotly.js-dist-min/plotly.min.js"
    return {
        "viewer.js": (COLOURS + CANVAS, own.read_text(encoding="utf-8") + (HERE / "viewer.js").read_text(encoding="utf-8")),
        "three.js": (CANVAS, (folder / "three.min.js").read_text(encoding="utf-8")),
        "vtk.js": (BOX, (folder / "vtk.min.js").read_text(encoding="utf-8")),
        "plotly.js": (BOX, plotly.read_text(encoding="utf-8") + "</script><script>" + (HERE / "plotly.js").read_text(encoding="utf-8")),
    }


def measured(page: Path) -> tuple[float, float]:
    """Median time between two pictures and processor time of each (ms)."""
    browser = chromium(1200, 1000)
    try:
        browser.get(page.as_uri())
        end = time.monotonic() + 30.0
        while not browser.execute_script("return Boolean(window.bench)"):
            if time.monotonic() > end:
                sys.exit(f"{page.name} is not ready: {browser.get_log('browser')}")
            time.sleep(0.1)
        browser.execute_async_script("bench(20, arguments[0])")
        before = processor_time(browser.service.process.pid)
        times = browser.execute_async_script(f"bench({PICTURES}, arguments[0])")
        spent = processor_time(browser.service.process.pid) - before
    finally:
        browser.quit()
    return statistics.median(b - a for a, b in zip(times, times[1:])), 1000.0 * spent / PICTURES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder, data = Path(name), (HERE / "data.js").read_text(encoding="utf-8")
        pages = scripts(folder)
        found: dict[str, list[tuple[float, float]]] = {library: [] for library in pages}
        for library, (element, script) in pages.items():
            text = f'<!DOCTYPE html><meta charset="utf-8"><body>{element}<script>{data}</script><script>{script}</script>'
            (folder / f"{library}.html").write_text(text, encoding="utf-8")
        # Rounds alternate, so that what else the machine does meets all of them.
        for _ in range(options.rounds):
            for library in pages:
                found[library].append(measured(folder / f"{library}.html"))
    for library, (_, script) in pages.items():
        times, spent = zip(*found[library])
        size = len(script.encode()) / 1000.0
        print(f"{library:10} {size:6.0f} kB   {min(times):4.0f} to {max(times):4.0f} ms a picture   {min(spent):4.0f} to {max(spent):4.0f} ms of processor time")


if __name__ == "__main__":
    main()
