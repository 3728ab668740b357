"""The page of `tegula run --watch` in a browser: headless Chromium shows a run that goes on, and stops it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
import unittest
from pathlib import Path
from typing import Any

from browser import InBrowser

try:
    from selenium.webdriver.common.by import By
except ImportError:
    pass

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("TEGULA_PROGRAM", ROOT / "target" / "release" / "tegula"))
# It swings for hours.
PENDULUM = """
title = "Plate that swings <down> & up"
[analysis]
type = "transient"
end_time = 1e5
time_step = 0.01
scheme = { type = "energy-momentum" }
[mesh]
type = "plate"
size = [1.0, 0.5]
[mesh.grid]
elements = [8, 4]
[materials.rubber]
type = "isotropic"
young = 2e7
poisson = 0.3
density = 500.0
[[sections]]
material = "rubber"
thickness = 0.02
[[conditions]]
type = "spherical"
on = "u_min"
[[loads]]
type = "gravity"
value = [0.0, 0.0, -9.81]
[output]
points = [{ name = "tip", on = "u_max_v_max" }]
interval = 1e4
pictures = false
"""


def program() -> str:
    """The compiled program."""
    if not PROGRAM.is_file():
        message = f"{PROGRAM} is missing: build it by `cargo build --release`, or name it in TEGULA_PROGRAM"
        if os.environ.get("TEGULA_BROWSER"):
            raise FileNotFoundError(message)
        raise unittest.SkipTest(message)
    return str(PROGRAM)


class Run:
    """A run with a page."""

    def __init__(self, model: Path, out: Path) -> None:
        arguments = [program(), "run", str(model), "--out", str(out), "--watch", "-j", "1"]
        self.process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        found = re.search(r"http://127\.0\.0\.1:\d+/[0-9a-f]{32}/", self.process.stderr.readline())
        assert found is not None
        self.url = found.group()

    def end(self) -> int:
        """Exit code."""
        self.process.communicate(timeout=60)
        return self.process.returncode

    def kill(self) -> None:
        self.process.kill()
        self.process.communicate()


class Watching(InBrowser):
    def started(self, name: str, model: str) -> Run:
        path = self.folder / f"{name}.toml"
        path.write_text(model)
        run = Run(path, self.folder / name)
        self.addCleanup(run.kill)
        self.browser.get(run.url)
        self.assertEqual(self.value("typeof window.watch"), "object")
        return run

    def value(self, expression: str) -> Any:
        return self.browser.execute_script(f"const page = window.watch && window.watch.page; return {expression};")

    def until(self, expression: str) -> None:
        """Waits until an expression of the page is true."""
        end = time.monotonic() + 60
        while not self.value(expression):
            self.assertLess(time.monotonic(), end, expression)
            time.sleep(0.1)

    def drawn(self) -> tuple[int, int, int]:
        """Number of pixels of the canvas that are not white, and their mean place."""
        found = self.value(
            """(() => { const { viewer } = page.stage, { gl, canvas } = viewer; viewer.draw();
            const p = new Uint8Array(4 * canvas.width * canvas.height);
            gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
            let [n, x, y] = [0, 0, 0];
            for (let i = 0; i < p.length; i += 4)
              if (p[i] + p[i + 1] + p[i + 2] <= 720) { n++; x += (i / 4) % canvas.width; y += Math.floor(i / 4 / canvas.width); }
            return [n, Math.round(x / n), Math.round(y / n)]; })()"""
        )
        return int(found[0]), int(found[1]), int(found[2])

    def status(self) -> str:
        return str(self.browser.find_element(By.ID, "status").text)

    def test_a_run_is_shown_while_it_goes_on_and_stopped(self) -> None:
        run = self.started("pendulum", PENDULUM)
        self.until("page.curves && page.curves.rows > 5 && page.known.shape > 1")
        self.assertEqual(self.browser.title, "Plate that swings <down> & up")
        self.assertEqual(self.status(), "running")
        self.assertIn("time", self.browser.find_element(By.ID, "step").text)
        titles = [title.text for title in self.browser.find_elements(By.CSS_SELECTOR, ".u-title")]
        self.assertEqual(titles, ["displacement of tip", "energies", "step size"])
        number, x, y = self.drawn()
        self.assertGreater(number, 1500)
        rows, shape = self.value("[page.curves.rows, page.known.shape]")
        points = "page.curves.plots.get('energies').plot.data[0].length"
        before, meshes = self.value(points), self.value("(window.kept = page.stage.viewer.meshes[0], 1)")
        self.until(f"page.curves.rows > {rows + 3} && page.known.shape > {shape + 2}")
        # The plots follow the data at their own pace.
        self.until(f"{points} > {before}")
        self.assertTrue(meshes and self.value("window.kept === page.stage.viewer.meshes[0]"), "the scene is not built anew")
        moved = self.drawn()
        self.assertNotEqual(moved, (number, x, y), "the shape moves")
        # Colours by the stress, which is everywhere and somewhere largest.
        self.assertEqual(self.value("page.stage.field.value"), "von_mises/")
        self.assertIn("von mises", self.browser.find_element(By.CSS_SELECTOR, "#scene select").text)
        low, high = self.value("page.stage.viewer.range")
        self.assertTrue(0.0 <= low < high, (low, high))
        self.assertEqual(self.value("page.shapes.stress.length"), 32)
        # A second page has all of it, too.
        self.browser.switch_to.new_window("tab")
        self.browser.get(run.url)
        self.until("page.curves && page.curves.rows > 5")
        self.browser.close()
        self.browser.switch_to.window(self.browser.window_handles[0])
        self.browser.find_element(By.ID, "stop").click()
        self.assertEqual(run.end(), 130)
        self.until("page.whole")
        self.assertEqual(self.status(), "interrupted")
        self.assertIn("--resume", self.browser.find_element(By.ID, "line").text)
        summary = json.loads((self.folder / "pendulum" / "summary.json").read_text())
        self.assertEqual(summary["status"], "interrupted")
        last = self.value("page.curves.of('time').at(-1)")
        self.assertEqual(last, summary["time"], "the page shows the last step")
        self.assertEqual(self.value("page.curves.of('tip.uz').at(-1)"), summary["points"]["tip"]["displacement"][2])
        self.assert_silent()

    def test_a_browser_that_goes_away_does_not_disturb_the_run(self) -> None:
        run = self.started("left", PENDULUM.replace("end_time = 1e5", "end_time = 5.0"))
        self.until("page.known.part === 1")
        self.browser.get("about:blank")
        self.assertEqual(run.end(), 0)
        self.assert_silent()

    def test_the_end_of_a_run_is_shown(self) -> None:
        began = time.monotonic()
        run = self.started("roof", (ROOT / "examples" / "hinged_roof_path.toml").read_text())
        self.until("page.whole")
        self.assertEqual((self.status(), run.end()), ("complete", 0))
        self.assertLess(time.monotonic() - began, 60)
        titles = [title.text for title in self.browser.find_elements(By.CSS_SELECTOR, ".u-title")]
        self.assertEqual(titles[0], "equilibrium path (dashed: negative eigenvalues)")
        self.assertGreater(self.drawn()[0], 5000)
        self.assert_silent()

    def test_mechanisms_and_steps_are_shown(self) -> None:
        for name in ("slider_crank.toml", "preloaded_plate.toml"):
            text = (ROOT / "examples" / name).read_text().replace("end_time = 0.2", "end_time = 0.01")
            run = self.started(name.removesuffix(".toml"), text)
            self.until("page.whole")
            self.assertEqual((self.status(), run.end()), ("complete", 0))
            self.assertGreater(self.drawn()[0], 500, name)
            self.assertGreaterEqual(self.value("page.known.part"), 1)
            self.assert_silent()


if __name__ == "__main__":
    unittest.main()
