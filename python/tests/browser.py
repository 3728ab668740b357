"""Headless Chromium that opens pages of the package.

Needs selenium, and Chromium with its driver (packages `chromium` and `chromium-driver` of Debian); its tests are skipped without them,
unless the environment variable TEGULA_BROWSER is set, which asks for them.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import unittest
from pathlib import Path
from typing import Any, ClassVar

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None  # type: ignore[assignment, unused-ignore]

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")


def chromium(width: int, height: int) -> Any:
    """Headless Chromium that draws without a graphics card."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--disable-dev-shm-usage",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        f"--window-size={width},{height}",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(str(DRIVER)))
    browser.set_script_timeout(120)
    return browser


@unittest.skipUnless(
    os.environ.get("TEGULA_BROWSER") or (webdriver and CHROMIUM and DRIVER), "there is no browser to test with"
)
class InBrowser(unittest.TestCase):
    """Tests with a browser and a folder."""

    browser: ClassVar[Any]
    folder: ClassVar[Path]

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.browser = chromium(1200, 1000)
        cls.addClassCleanup(cls.browser.quit)

    def opened(self, path: Path) -> None:
        """Opens a report and waits until it is drawn."""
        self.browser.get(path.as_uri())
        # On a busy machine the driver may answer before the page has begun.
        outcome = self.browser.execute_async_script(
            """const done = arguments[0];
            const wait = () => {
              if (window.report) window.report.then(() => done('drawn'), (e) => done(String(e.stack)));
              else setTimeout(wait, 50);
            };
            wait();"""
        )
        self.assertEqual(outcome, "drawn")

    def script(self, text: str) -> Any:
        """Value of a script that knows the state of the report as `state`."""
        return self.browser.execute_async_script(
            f"const done = arguments[0]; window.report.then((state) => {{ {text} }});"
        )

    def pixels(self) -> list[int]:
        """Colours of the canvas: number of pixels that are not white, and sums that a moving shape changes."""
        found = self.script(
            """const { viewer } = state.stage, { gl, canvas } = viewer; viewer.draw();
            const p = new Uint8Array(4 * canvas.width * canvas.height);
            gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
            let drawn = 0, x = 0, y = 0, coloured = 0;
            for (let i = 0; i < p.length; i += 4) {
              if (p[i] + p[i + 1] + p[i + 2] > 720) continue;
              drawn++; x += (i / 4) % canvas.width; y += Math.floor(i / 4 / canvas.width);
              if (Math.max(p[i], p[i + 1], p[i + 2]) - Math.min(p[i], p[i + 1], p[i + 2]) > 60) coloured++;
            }
            done([drawn, Math.round(x / drawn), Math.round(y / drawn), coloured, canvas.width * canvas.height]);"""
        )
        return [int(n) for n in found]

    def assert_silent(self) -> None:
        """The console has no message."""
        self.assertEqual(self.browser.get_log("browser"), [])
