"""Reports in a browser: headless Chromium shows them, moves the shapes and reports no error."""

from __future__ import annotations

import re
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

import tegula
from browser import InBrowser
from reports import fine_model

try:
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError:
    pass

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

PENDULUM: dict[str, Any] = {
    "title": "Plate that swings <down> & up",
    "analysis": {"type": "transient", "end_time": 0.3, "time_step": 0.01},
    "mesh": {"type": "plate", "size": [1.0, 0.5], "grid": {"elements": [8, 4]}},
    "materials": {"rubber": {"type": "isotropic", "young": 2e7, "poisson": 0.3, "density": 500.0}},
    "sections": [{"material": "rubber", "thickness": 0.02}],
    "conditions": [{"type": "spherical", "on": "u_min"}],
    "loads": [{"type": "gravity", "value": [0.0, 0.0, -9.81]}],
    "output": {"points": [{"name": "tip", "on": "u_max_v_max"}], "every": 1, "pictures": False},
}


class Reports(InBrowser):
    def result(self, name: str, model: dict[str, Any]) -> tegula.Result:
        return tegula.Model(model).run(self.folder / name)

    def test_shapes_move_with_the_slider_and_the_keys(self) -> None:
        result = self.result("pendulum", PENDULUM)
        path = result.report()
        self.assertEqual(path, self.folder / "pendulum" / "report.html")
        self.opened(path)
        self.assertEqual(self.browser.title, PENDULUM["title"])
        drawn, x, y, coloured, whole = self.pixels()
        self.assertGreater(drawn, 0.02 * whole)
        self.assertGreater(coloured, 0.3 * drawn)
        slider = self.browser.find_element(By.CSS_SELECTOR, "input[type=range]")
        self.assertEqual(int(slider.get_attribute("max")), len(result.frames) - 1)
        self.assertIn("0.3", self.browser.find_element(By.CSS_SELECTOR, ".time output").text)
        self.browser.execute_script(
            "arguments[0].value = 0; arguments[0].dispatchEvent(new Event('input'));", slider
        )
        self.assertIn("time 0", self.browser.find_element(By.CSS_SELECTOR, ".time output").text)
        at_start = self.pixels()
        self.assertGreater(abs(at_start[1] - x) + abs(at_start[2] - y), 20, "the slider moves the shape")
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        canvas.send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(slider.get_property("value"), "1")
        canvas.send_keys("+")
        self.assertEqual(self.script("done(state.stage.scale.value)"), "1.25")
        before = self.script("done(state.stage.viewer.view.azimuth)")
        ActionChains(self.browser).click_and_hold(canvas).move_by_offset(40, 10).release().perform()
        self.assertNotEqual(self.script("done(state.stage.viewer.view.azimuth)"), before)
        canvas.send_keys("r")
        self.assertEqual(self.script("done(state.stage.viewer.view.azimuth)"), before)
        canvas.send_keys(" ")
        time.sleep(0.7)
        canvas.send_keys(" ")
        self.assertGreater(int(slider.get_property("value")), 1, "the animation moves on")
        self.assert_silent()

    def test_values_are_those_of_the_files(self) -> None:
        result = self.result("values", PENDULUM)
        self.opened(result.report())
        frame = result.frames[20].to_meshio()
        displacement = frame.point_data["displacement"]
        von_mises = frame.cell_data["von_mises"][0]
        shown = self.script(
            """(async () => { const { shapes } = state.stage, [mesh] = shapes.meshes;
            const f = await shapes.field('von_mises/');
            done([mesh.displacement[20].map((u) => Array.from(u)), Array.from(f.values[20]), f.atPoints,
              Array.from(mesh.references[0]), shapes.scene.values[20]]); })();"""
        )
        for axis in range(3):
            every = [abs(f.to_meshio().point_data["displacement"][:, axis]).max() for f in result.frames]
            for found, exact in zip(shown[0][axis], displacement[:, axis], strict=True):
                self.assertLess(abs(found - exact), 2e-5 * max(every) + 1e-12)
        for found, exact in zip(shown[1], von_mises, strict=True):
            self.assertLess(abs(found - exact), 1e-4 * von_mises.max() + 1e-3)
        self.assertFalse(shown[2])
        for found, exact in zip(shown[3], frame.points.ravel(), strict=True):
            self.assertAlmostEqual(found, exact, delta=1e-6)
        self.assertEqual(shown[4], result.frames[20].time)
        history = self.script(
            "columnsOf(state.parts[0].history).then((columns) => done(Array.from(columns.get('tip.uz'))));"
        )
        self.assertEqual(history, list(result.history["tip.uz"]))
        # The history of a node is that of its point.
        node = int(abs(frame.points - [1.0, 0.5, 0.0]).sum(axis=1).argmin())
        self.script(f"state.stage.pick({{ mesh: 0, point: {node} }}); done(0);")
        curve = self.script("done(Array.from(state.stage.picked.curves[2].ys))")
        for found, exact in zip(curve, result.history["tip.uz"], strict=True):
            self.assertAlmostEqual(found, exact, delta=2e-5)
        self.assert_silent()

    def test_modes_are_animated(self) -> None:
        model = {
            **{key: PENDULUM[key] for key in ("mesh", "materials", "sections", "conditions")},
            "analysis": {"type": "modal", "modes": 5},
            "output": {"pictures": False},
        }
        result = self.result("modes", model)
        self.opened(result.report())
        label = self.browser.find_element(By.CSS_SELECTOR, ".time output").text
        number, frequency = re.fullmatch(r"mode (\d+): f = (\S+)", label).groups()  # type: ignore[union-attr]
        self.assertAlmostEqual(float(frequency), result.frequencies[int(number) - 1], delta=1e-5 * float(frequency))
        self.assertGreater(float(frequency), 0.1, "the first mode that is not rigid")
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        before = self.pixels()
        canvas.send_keys(" ")
        time.sleep(0.8)
        self.assertGreater(self.script("done(state.stage.phase)"), 0.1)
        self.assertNotEqual(self.pixels(), before)
        self.assert_silent()

    def test_paths_show_their_critical_points(self) -> None:
        result = tegula.Model.read(EXAMPLES / "hinged_roof_path.toml").run(self.folder / "path")
        self.opened(result.report())
        text = self.browser.find_element(By.TAG_NAME, "main").text
        for point in result.summary["critical_points"]:
            self.assertIn(f"{point['load_factor']:.6f}"[:7], text)
        self.assertIn("equilibrium path", text)
        label = self.browser.find_element(By.CSS_SELECTOR, ".time output").text
        self.assertAlmostEqual(float(label.split()[-1]), result.history["time"][-1], delta=1e-5)
        self.assertIn("Hinged roof", text, "the model file")
        self.assert_silent()

    def moved(self, mesh: int) -> tuple[list[float], list[float]]:
        """Displacements that are drawn, and the reference from which they count."""
        moved, reference = self.script(
            f"""const drawn = state.stage.viewer.meshes[{mesh}];
            done([Array.from(drawn.moved), Array.from(drawn.reference)]);"""
        )
        return [x - x0 for x, x0 in zip(moved, reference, strict=True)], reference

    def assert_parallel(self, found: list[float], exact: Any) -> None:
        """Two shapes differ by a factor above 0."""
        product = sum(a * b for a, b in zip(found, exact, strict=True))
        sizes = sum(a * a for a in found) * sum(b * b for b in exact)
        self.assertGreater(product, 0.9999 * sizes**0.5)

    def test_critical_modes_are_about_the_states_of_their_points(self) -> None:
        result = tegula.Model.read(EXAMPLES / "hinged_roof_path.toml").run(self.folder / "critical")
        self.opened(result.report())
        self.script("state.stage.picker.selectedIndex = 1; state.stage.open(1).then(() => done(0));")
        frames = result._frames("critical_modes.pvd")
        self.assertEqual(len(frames), 2)
        for number, frame in enumerate(frames):
            self.script(f"state.stage.at({number}); done(0);")
            grid = frame.to_meshio()
            found, reference = self.moved(0)
            self.assert_parallel(found, grid.point_data["displacement"].ravel())
            for x, exact in zip(reference, grid.points.ravel(), strict=True):
                self.assertAlmostEqual(x, exact, delta=1e-3)
        self.assert_silent()

    def test_complex_modes_turn_from_their_shape_to_that_of_a_quarter_period_later(self) -> None:
        result = tegula.Model.read(EXAMPLES / "rotor_campbell.toml").run(self.folder / "rotor")
        self.opened(result.report())
        frames = {frame.time: frame for frame in result._frames("mode_bodies.pvd")}
        mode = next(t for t in sorted(frames) if t + 0.25 in frames)
        place = self.script(f"done(state.stage.shapes.shown.findIndex((i) => state.stage.shapes.scene.values[i] === {mode}));")
        self.script(f"state.stage.at({place}); done(0);")
        for phase, value in ((0.0, mode), (1.5707963267948966, mode + 0.25)):
            self.script(f"state.stage.phase = {phase}; state.stage.update(); done(0);")
            self.assert_parallel(self.moved(0)[0], frames[value].to_meshio().point_data["displacement"].ravel())
        self.assert_silent()

    def test_deformed_files_and_names_with_blanks(self) -> None:
        output = {**PENDULUM["output"], "deformed": True, "points": [{"name": "a  b.c", "on": "u_max_v_max"}]}
        result = self.result("deformed", {**PENDULUM, "output": output})
        self.opened(result.report())
        last = result.frames[-1].to_meshio()
        found, reference = self.moved(0)
        for u, x, moved in zip(found, reference, last.points.ravel(), strict=True):
            self.assertAlmostEqual(u + x, moved, delta=1e-4)
        for x, exact in zip(reference, (last.points - last.point_data["displacement"]).ravel(), strict=True):
            self.assertAlmostEqual(x, exact, delta=1e-5)
        self.assertIn("a  b.c.uz", self.script("done(Array.from(document.querySelectorAll('.plots option'), (o) => o.value))"))
        self.assert_silent()

    def test_columns_that_are_constant_have_a_plot(self) -> None:
        model = {**PENDULUM, "loads": [], "output": {**PENDULUM["output"], "points": []}}
        self.opened(self.result("still", model).report())
        self.assert_silent()

    def test_picked_nodes_are_those_that_are_seen(self) -> None:
        tube = {"type": "cylinder", "radius": 1.0, "angles": [0.0, 180.0], "length": 2.0, "axis": [0.0, 1.0, 0.0],
                "start": [1.0, 0.0, 0.0], "grid": {"elements": [12, 8]}}
        model = {**PENDULUM, "mesh": tube, "loads": [], "output": {"pictures": False}}
        self.opened(self.result("tube", model).report())
        seen, hidden, wrong = self.script(
            """const { viewer } = state.stage, at = viewer.project(viewer.meshes[0]), count = at.length / 3;
            let [seen, hidden, wrong] = [0, 0, 0];
            for (let p = 0; p < count; p++) {
              const found = viewer.pick(at[3 * p], at[3 * p + 1]).point;
              if (found === p) seen++;
              else if (at[3 * found + 2] < at[3 * p + 2] - 0.3) hidden++;
              else wrong++;
            }
            done([seen, hidden, wrong]);"""
        )
        self.assertGreater(seen, 50)
        self.assertGreater(hidden, 10)
        self.assertLess(wrong, 8)
        self.assert_silent()

    def test_steps_are_in_one_report_that_phones_can_show(self) -> None:
        text = (EXAMPLES / "preloaded_plate.toml").read_text().replace("end_time = 0.2", "end_time = 0.01")
        result = tegula.Model.from_toml(text).run(self.folder / "steps")
        self.opened(result.report())
        choice = self.browser.find_element(By.CSS_SELECTOR, ".controls select")
        shown = [option.text for option in choice.find_elements(By.TAG_NAME, "option")]
        self.assertEqual(shown[:2], ["1-preload: States", "2-modes: Modes"])
        self.script("state.stage.picker.selectedIndex = 1; state.stage.open(1).then(() => done(0));")
        self.assertIn("mode", self.browser.find_element(By.CSS_SELECTOR, ".time output").text)
        self.browser.set_window_size(500, 900)
        self.addCleanup(self.browser.set_window_size, 1200, 1000)
        self.opened(self.folder / "steps" / "report.html")
        wide = self.script("done(document.documentElement.scrollWidth - document.documentElement.clientWidth)")
        self.assertLessEqual(wide, 0, "nothing is wider than the screen of a phone")
        self.assert_silent()

    def test_fine_meshes_show_their_colours_in_every_state(self) -> None:
        result = tegula.Model(fine_model()).run(self.folder / "fine")
        path = result.report()
        self.assertLess(path.stat().st_size, 30e6)
        self.opened(path)
        slider = self.browser.find_element(By.CSS_SELECTOR, "input[type=range]")
        self.assertEqual(int(slider.get_attribute("max")), 199)
        self.assertTrue(self.script("done(state.stage.edges.checked)"))
        drawn, _, _, coloured, whole = self.pixels()
        self.assertGreater(drawn, 0.05 * whole)
        self.assertGreater(coloured, 0.3 * drawn, "edges of elements do not cover the faces")
        shown = self.script(
            """const { stage } = state, shown = [];
            for (let i = 0; i <= Number(stage.slider.max); i++) {
              stage.at(i);
              stage.viewer.draw();
              shown.push([stage.label.textContent, stage.viewer.meshes[0].moved.at(-1)]);
            }
            done(shown);"""
        )
        self.assertEqual(len({label for label, _ in shown}), 200)
        self.assertGreater(len({height for _, height in shown}), 190, "the shape moves")
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        canvas.send_keys(Keys.HOME, " ")
        time.sleep(1.0)
        self.assertGreater(self.script("done(state.stage.viewer.frames)"), 200)
        canvas.send_keys(" ")
        self.assert_silent()

    def test_edges_are_drawn_of_elements_that_are_large(self) -> None:
        for elements, edged in (([4, 4], True), ([64, 64], False)):
            model = {**PENDULUM, "mesh": {"type": "plate", "size": [1.0, 1.0], "grid": {"elements": elements}},
                     "analysis": {"type": "static"}, "conditions": [{"type": "clamp", "on": "u_min"}]}
            self.opened(self.result(f"edges{elements[0]}", model).report())
            dark = self.script(
                """const { viewer } = state.stage, { gl, canvas } = viewer;
                viewer.draw();
                const size = 4 * canvas.width * canvas.height;
                const read = (on) => {
                  viewer.show.edges = on;
                  viewer.draw();
                  const p = new Uint8Array(size);
                  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
                  return p;
                };
                const [without, edged] = [read(false), read(true)];
                let faces = 0, changed = 0;
                for (let i = 0; i < size; i += 4) {
                  if (without[i] + without[i + 1] + without[i + 2] > 720) continue;
                  faces++;
                  if (Math.abs(without[i + 1] - edged[i + 1]) > 12) changed++;
                }
                done(changed / faces);"""
            )
            self.assertLess(dark, 0.15)
            if edged:
                self.assertGreater(dark, 0.002)
        self.assert_silent()

    def test_keys_turn_zoom_and_move_the_view(self) -> None:
        self.opened(self.result("keys", PENDULUM).report())
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        view = "done([state.stage.viewer.view.azimuth, state.stage.viewer.view.elevation, state.stage.viewer.view.distance])"
        azimuth, elevation, distance = self.script(view)
        at = self.script("done(state.stage.slider.value)")
        canvas.send_keys(Keys.SHIFT, Keys.ARROW_LEFT, Keys.ARROW_UP, Keys.NULL)
        canvas.send_keys("i")
        turned = self.script(view)
        self.assertEqual(turned[:2], [azimuth + 5, elevation + 5])
        self.assertAlmostEqual(turned[2], 0.8 * distance)
        self.assertEqual(self.script("done(state.stage.slider.value)"), at, "the state stays")
        target = self.script("done(state.stage.viewer.view.target)")
        canvas.send_keys("d")
        self.assertNotEqual(self.script("done(state.stage.viewer.view.target)"), target)
        canvas.send_keys("r")
        self.assertEqual(self.script(view), [azimuth, elevation, distance])
        self.assert_silent()

    def test_the_legend_of_phones_is_beside_the_shape(self) -> None:
        path = self.result("phone", PENDULUM).report()
        self.browser.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 3, "mobile": True}
        )
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.opened(path)
        bottom, top, high = self.script(
            """const place = (name) => document.querySelector(name).getBoundingClientRect();
            done([place('.bar').bottom, place('canvas').top, place('canvas').height]);"""
        )
        self.assertLessEqual(bottom, top + 1)
        self.assertGreater(high, 200)
        self.assert_silent()

    def test_a_notebook_shows_the_report(self) -> None:
        result = self.result("notebook", PENDULUM)
        page = self.folder / "notebook.html"
        page.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body>{result._repr_html_()}</body>")
        self.browser.get(page.as_uri())
        self.browser.switch_to.frame(self.browser.find_element(By.TAG_NAME, "iframe"))
        self.addCleanup(self.browser.switch_to.default_content)
        self.assertEqual(self.script("done(state.stage.shapes.instants)"), len(result.frames))
        self.assertGreater(self.pixels()[0], 1000)
        self.browser.switch_to.default_content()
        self.assert_silent()


class Files(unittest.TestCase):
    def test_a_report_is_one_file_without_network(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            result = tegula.Model(PENDULUM).run(folder)
            text = result.report(Path(folder) / "own.html").read_text(encoding="utf-8")
            self.assertIn("<title>Plate that swings &lt;down&gt; &amp; up</title>", text)
            self.assertIn("default-src 'none'", text)
            self.assertEqual(re.findall(r"<(?:link|img|script|iframe)[^>]*(?:src|href)=\"(?!data:)", text), [])
            self.assertLess(len(text), 2_000_000)
            with self.assertRaisesRegex(tegula.OutputError, "summary.json"):
                tegula.Result(folder).folder.joinpath("summary.json").unlink()
                result.report()


if __name__ == "__main__":
    unittest.main()
