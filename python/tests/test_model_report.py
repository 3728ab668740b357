"""Reports of models: the browser shows mesh, supports, loads and sets; wrong models show their mistakes."""

from __future__ import annotations

import re
import tempfile
import unittest
from pathlib import Path
from typing import Any

import tegula
from browser import InBrowser

try:
    from selenium.webdriver.common.by import By
except ImportError:
    pass

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

MODEL: dict[str, Any] = {
    "title": "Plate <of> two & sections",
    "analysis": {"type": "static"},
    "mesh": {"type": "plate", "size": [2.0, 1.0], "grid": {"elements": [8, 4]}},
    "materials": {"steel": {"type": "isotropic", "young": 2e11, "poisson": 0.3, "density": 7850.0}},
    "sections": [{"material": "steel", "thickness": 0.02}],
    "conditions": [{"type": "clamp", "on": "u_min"}, {"type": "symmetry", "on": "v_max", "normal": [0.0, 1.0, 0.0]}],
    "loads": [
        {"type": "edge", "on": "u_max", "value": [0.0, 0.0, -1e3]},
        {"type": "pressure", "value": 250.0},
        {"type": "force", "on": "u_max_v_min", "value": [0.0, 5.0, 0.0]},
    ],
    "output": {"points": [{"name": "tip", "on": "u_max_v_min"}], "pictures": False},
}

# Numbers of pixels of the canvas near a colour of the palette.
COUNT = """const near = (code) => { const { viewer } = state.stage, { gl, canvas } = viewer; viewer.draw();
  const p = new Uint8Array(4 * canvas.width * canvas.height), c = channels(code).map((x) => 255 * x);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
  let n = 0;
  for (let i = 0; i < p.length; i += 4) if (Math.hypot(p[i] - c[0], p[i + 1] - c[1], p[i + 2] - c[2]) < 12) n++;
  return n; };"""
GREEN, VERMILLION, BLUE = "#009e73", "#d55e00", "#0072b2"


class ModelsInBrowser(InBrowser):
    def count(self, colour: str) -> int:
        return int(self.script(f"{COUNT} done(near('{colour}'));"))

    def marks(self, subject: str) -> dict[str, str]:
        """Names and notes of the marks of a kind."""
        return dict(self.script(f"done(state.stage.marks.list.filter((m) => m.subject === '{subject}').map((m) => [m.name, m.note]));"))

    def tick(self, name: str) -> None:
        """Clicks on the entry of a mark, and waits until it is drawn or gone."""
        self.script(
            f"""const entry = [...document.querySelectorAll('.marks label')].find((l) => l.querySelector('span').textContent === '{name}');
            const mark = state.stage.marks.list.find((m) => m.name === '{name}'), box = entry.querySelector('input');
            box.checked = !box.checked; state.stage.marks.show(mark, box.checked).then(() => done(0));"""
        )

    def test_supports_loads_and_sets_are_drawn_and_can_be_hidden(self) -> None:
        self.opened(tegula.Model(MODEL).report(self.folder / "model.html"))
        self.assertEqual(self.browser.title, MODEL["title"])
        self.assertEqual(self.marks("support"), {"clamp on u_min": "5 nodes", "symmetry on v_max": "9 nodes"})
        loads = self.marks("load")
        self.assertEqual(
            loads, {"edge load on u_max": "(0, 0, -1000)", "pressure load on all": "250", "force load on u_max_v_min": "(0, 5, 0)"}
        )
        text = self.browser.find_element(By.TAG_NAME, "main").text
        for part in ("Shell elements 32", "Nodes 45", "Mass 314", "static", "steel isotropic", "[materials.steel]"):
            self.assertIn(part, text)
        supported = self.count(GREEN)
        self.assertGreater(supported, 300)
        self.tick("clamp on u_min")
        self.assertLess(self.count(GREEN), 0.8 * supported)
        self.tick("symmetry on v_max")
        self.assertEqual(self.count(GREEN), 0)
        arrows = self.count(VERMILLION)
        self.assertGreater(arrows, 300)
        for name in loads:
            self.tick(name)
        self.assertEqual(self.count(VERMILLION), 0)
        self.assertEqual(self.count(BLUE), 0)
        self.tick(next(iter(self.marks("set"))))
        self.assertGreater(self.count(BLUE), 20)
        self.assert_silent()

    def test_marked_nodes_and_arrows_are_those_of_the_model(self) -> None:
        model = tegula.Model(MODEL)
        self.opened(model.report(self.folder / "values.html"))
        nodes, arrows = self.script(
            """(async () => { const [clamp] = state.stage.marks.list, edge = state.stage.marks.list.find((m) => m.name === 'edge load on u_max');
            done([Array.from(new Uint32Array(await bytesOf(clamp.nodes))), Array.from(new Float32Array(await bytesOf(edge.arrows)))]); })();"""
        )
        simulation = model.simulation()
        self.assertEqual(nodes, list(simulation.nodes_on("u_min")))
        self.assertEqual(len(arrows), 6 * 4, "an arrow at the middle of each edge")
        for i, y in enumerate((0.125, 0.375, 0.625, 0.875)):
            for found, exact in zip(arrows[6 * i : 6 * i + 6], (2.0, y, 0.0, 0.0, 0.0, -0.24), strict=True):
                self.assertAlmostEqual(found, exact, places=6)
        self.script("state.stage.pick({ mesh: 0, point: 44 }); setTimeout(() => done(0), 300);")
        told = self.browser.find_element(By.CSS_SELECTOR, ".node").text
        self.assertIn("Node 44 (counted from 0, as in the files) at (2, 1, 0)", told)
        self.assertIn("It is in symmetry on v_max, edge load on u_max, ", told)
        self.assert_silent()

    def test_sides_and_sections_have_colours(self) -> None:
        self.opened(tegula.Model(MODEL).report(self.folder / "sides.html"))
        side = """state.stage.viewer.marks = []; state.stage.field.value = 'side'; state.stage.recolour().then(() => { %s
            const { viewer } = state.stage, { gl, canvas } = viewer; viewer.draw(); const p = new Uint8Array(4);
            gl.readPixels(canvas.width / 2 + 3, canvas.height / 2 + 3, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p); done(Array.from(p)); });"""
        above = self.script(side % "")
        below = self.script(side % "state.stage.viewer.view.elevation = -40;")
        self.assertGreater(above[2], above[0], "blue on the side of the directors")
        self.assertGreater(below[0], below[2], "orange on the other side")
        self.assertIn("other side", self.browser.find_element(By.CSS_SELECTOR, ".bar").text)
        nodes = [[x, y, 0.0] for x in (0.0, 1.0, 2.0) for y in (0.0, 1.0)]
        sets = {"quad_sets": {"left": [0], "right": [1]}, "node_sets": {"u_min": [0, 1]}}
        steel = MODEL["sections"][0]
        two = {
            **MODEL,
            "mesh": {"type": "arrays", "nodes": nodes, "quads": [[0, 2, 3, 1], [2, 4, 5, 3]], **sets},
            "sections": [{**steel, "on": "left"}, {**steel, "on": "right", "thickness": 0.03}],
            "conditions": MODEL["conditions"][:1], "loads": MODEL["loads"][1:2], "output": {"pictures": False},
        }
        self.opened(tegula.Model(two).report(self.folder / "two.html"))
        categories = self.script("done([state.stage.chosen.categories, Array.from(state.stage.chosen.values[0])])")
        self.assertEqual(categories, [["left: steel, thickness 0.02", "right: steel, thickness 0.03"], [0, 1]])
        self.opened(tegula.Model.read(EXAMPLES / "slider_crank.toml").report(self.folder / "crank.html"))
        self.assertGreater(len(self.marks("joint")), 0)
        self.assert_silent()

    def test_all_examples_have_pages_without_errors(self) -> None:
        drawn = 0
        for example in sorted(EXAMPLES.glob("*.toml")):
            with self.subTest(example=example.name):
                self.opened(tegula.Model.read(example).report(self.folder / f"{example.stem}.html"))
                # Bodies without shapes and without a mesh have no picture.
                if self.script("done(Boolean(state.stage));"):
                    drawn += 1
                    self.assertGreater(self.pixels()[0], 500)
                self.assert_silent()
        self.assertGreater(drawn, 25)

    def test_phones_and_notebooks_show_models(self) -> None:
        model = tegula.Model(MODEL)
        page = self.folder / "notebook.html"
        page.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body>{model._repr_html_()}</body>")
        self.browser.get(page.as_uri())
        self.browser.switch_to.frame(self.browser.find_element(By.TAG_NAME, "iframe"))
        self.assertGreater(self.pixels()[0], 1000)
        self.browser.switch_to.default_content()
        self.browser.set_window_size(500, 900)
        self.addCleanup(self.browser.set_window_size, 1200, 1000)
        self.opened(model.report(self.folder / "phone.html"))
        wide = self.script("done(document.documentElement.scrollWidth - document.documentElement.clientWidth)")
        self.assertLessEqual(wide, 0, "nothing is wider than the screen of a phone")
        self.assert_silent()


class Files(unittest.TestCase):
    def test_a_report_of_a_model_is_one_file_without_network(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = tegula.Model(MODEL).report(Path(folder) / "own.html")
            text = path.read_text(encoding="utf-8")
        self.assertIn("<title>Plate &lt;of&gt; two &amp; sections</title>", text)
        self.assertEqual(re.findall(r"<(?:link|img|script|iframe)[^>]*(?:src|href)=\"(?!data:)", text), [])
        self.assertLess(len(text), 200_000)

    def test_wrong_models_show_their_mistakes(self) -> None:
        wrong = tegula.Model({**MODEL, "conditions": [{"type": "clamp", "on": "<b>nowhere</b>"}]})
        shown = wrong._repr_html_()
        self.assertNotIn("iframe", shown)
        self.assertNotIn("<b>", shown)
        self.assertIn("conditions[0].on", shown)
        self.assertIn("&lt;b&gt;nowhere&lt;/b&gt;", shown)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "wrong.html"
            with self.assertRaises(tegula.ModelError):
                wrong.report(path)
            self.assertFalse(path.exists())
            with self.assertRaises(tegula.OutputError):
                tegula.Model(MODEL).report(Path(folder) / "nowhere" / "model.html")

    def test_pages_have_a_greatest_size(self) -> None:
        mesh = {"type": "plate", "size": [2.0, 1.0], "grid": {"elements": [640, 320]}}
        with tempfile.TemporaryDirectory() as folder:
            path = tegula.Model({**MODEL, "mesh": mesh}).report(Path(folder) / "large.html")
            size = path.stat().st_size
        self.assertLess(size, 30e6)
        self.assertGreater(size, 1e6, "it has the mesh of 204 800 elements")


if __name__ == "__main__":
    unittest.main()
