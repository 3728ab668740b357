"""The bar of the progress: on a terminal, in a notebook, and nowhere."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
import types
import unittest
from typing import Any
from unittest import mock

import tegula
from tegula._progress import Bar

SWING: dict[str, Any] = {
    "analysis": {"type": "transient", "end_time": 0.05, "time_step": 1e-3, "scheme": {"type": "energy-momentum"}},
    "mesh": {"type": "plate", "size": [10.0, 1.0], "grid": {"elements": [20, 2]}},
    "materials": {"steel": {"type": "isotropic", "young": 2.1e11, "poisson": 0.0, "density": 7850.0}},
    "sections": [{"material": "steel", "thickness": 0.1}],
    "conditions": [{"type": "clamp", "on": "u_min"}],
    "loads": [{"type": "edge", "on": "u_max", "value": [0.0, 0.0, -1e3]}],
    "output": {"pictures": False},
}


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        return 2


class Handle:
    """Handle of an output of a notebook, with what it has shown."""

    def __init__(self, shown: list[dict[str, str]]) -> None:
        self.shown = shown

    def update(self, data: dict[str, str], raw: bool) -> None:
        assert raw
        self.shown.append(data)


def notebook(shown: list[dict[str, str]], kernel: object = "kernel") -> Any:
    """Modules in place of those of IPython, which keep what is shown."""

    def display(data: dict[str, str], raw: bool, display_id: bool) -> Handle:
        assert raw and display_id
        shown.append(data)
        return Handle(shown)

    shell = types.SimpleNamespace(kernel=kernel) if kernel else types.SimpleNamespace()
    own: dict[str, Any] = {"IPython": types.ModuleType("IPython"), "IPython.display": types.ModuleType("IPython.display")}
    own["IPython"].get_ipython = lambda: shell
    own["IPython.display"].display = display
    return mock.patch.dict(sys.modules, own)


class Bars(unittest.TestCase):
    def setUp(self) -> None:
        self.enterContext(mock.patch("os.get_terminal_size", return_value=os.terminal_size((120, 24))))

    def test_a_terminal_shows_a_line_that_ends_with_the_run(self) -> None:
        with mock.patch.object(sys, "stderr", Terminal()) as stream:
            result = tegula.Model(SWING).run(progress=True)
        text = stream.getvalue()
        self.assertTrue(text.startswith("\r[" + "." * 20 + "]   0 %  time 0 of 0.05, step 0"), text[:120])
        last = text.rstrip("\n").split("\r")[-1]
        self.assertTrue(last.startswith("[" + "#" * 20 + "] 100 %  time 0.05, 50 steps, "), last)
        self.assertIn(f"{result.summary['iterations']} iterations", last)
        self.assertEqual(text.count("\n"), 1)
        self.assertTrue(all(len(line.removesuffix("\x1b[K")) < 120 for line in text.rstrip("\n").split("\r")))

    def test_where_nothing_can_be_shown_nothing_is(self) -> None:
        for progress in (True, False, None):
            with mock.patch.object(sys, "stderr", io.StringIO()) as stream:
                tegula.Model(SWING).run(progress=progress)
            self.assertEqual(stream.getvalue(), "")
        with mock.patch.object(sys, "stderr", None):
            tegula.Model(SWING).run(progress=True)

    def test_a_notebook_has_one_output_that_is_updated(self) -> None:
        shown: list[dict[str, str]] = []
        static = {**SWING, "analysis": {"type": "static"}}
        with notebook(shown), mock.patch.object(sys, "stderr", Terminal()) as stream:
            tegula.Model(static).run(progress=True)
        self.assertEqual(stream.getvalue(), "")
        self.assertGreater(len(shown), 1)
        self.assertIn('<progress value="1.0000" max="1"', shown[-1]["text/html"])
        self.assertRegex(shown[-1]["text/plain"], r"^100 %  load factor 1, \d+ steps?, \d+ iterations, ")
        # IPython on a terminal is no notebook.
        with notebook(shown, kernel=None), mock.patch.object(sys, "stderr", Terminal()) as stream:
            tegula.Model(static).run(progress=True)
        self.assertIn("load factor", stream.getvalue())

    def test_failed_and_interrupted_runs_say_so(self) -> None:
        for error, word in ((KeyboardInterrupt, "interrupted at time 0.25 of 1, 3 steps, 6 iterations"), (ValueError, "failed after time 0.25 of 1")):
            with self.subTest(error=error), mock.patch.object(sys, "stderr", Terminal()) as stream:
                with self.assertRaises(error), Bar() as bar:
                    bar(tegula.Progress(0, 0.0, 1.0, 0.1, 0))
                    bar(tegula.Progress(3, 0.25, 1.0, 0.1, 6))
                    raise error
                last = stream.getvalue().split("\r")[-1]
                self.assertIn(word, last)
                self.assertTrue(last.endswith("\n"))

    def test_a_bar_that_cannot_be_shown_does_not_end_the_run(self) -> None:
        class Closed(Terminal):
            def write(self, text: str) -> int:
                raise BrokenPipeError

        with mock.patch.object(sys, "stderr", Closed()):
            self.assertEqual(tegula.Model(SWING).run(progress=True).status, "complete")

    def test_updates_are_few_and_steps_cost_little(self) -> None:
        with mock.patch.object(sys, "stderr", Terminal()) as stream:
            begun = time.monotonic()
            with Bar() as bar:
                for step in range(20_000):
                    bar(tegula.Progress(step, step / 20_000, 1.0, 1e-4, 3))
            seconds = time.monotonic() - begun
        self.assertLess(stream.getvalue().count("\r"), 10 * seconds + 4)
        self.assertLess(seconds / 20_000, 1e-4, "a call takes less than 0.1 ms")

    def test_the_bar_of_several_analyses_begins_anew(self) -> None:
        with mock.patch.object(sys, "stderr", Terminal()) as stream, Bar() as bar:
            for progress in ((0, 0.0, 1.0), (1, 1.0, 1.0), (0, 1.0, 3.0), (1, 2.0, 3.0)):
                bar(tegula.Progress(*progress, 1.0, 1, "time (load factor)"))
        self.assertIn("time (load factor) 2 of 3, 1 step, 2 iterations", stream.getvalue().split("\r")[-1])

    def test_a_search_for_modes_tells_how_many_are_found(self) -> None:
        plate = {**SWING, "analysis": {"type": "modal", "modes": 30}, "loads": []}
        plate["mesh"] = {"type": "plate", "size": [10.0, 10.0], "grid": {"elements": [16, 16]}}
        calls: list[tegula.Progress] = []
        tegula.Model(plate).run(progress=calls.append)
        self.assertEqual({call.parameter for call in calls}, {"modes"})
        self.assertEqual({call.end for call in calls}, {30.0})
        found = [call.time for call in calls]
        self.assertEqual((found, found[-1]), (sorted(found), 30.0))
        self.assertGreater(len(found), 2)
        with mock.patch.object(sys, "stderr", Terminal()) as stream:
            tegula.Model(plate).run(progress=True)
        self.assertRegex(stream.getvalue().split("\r")[-1], r"100 %  30 of 30 modes, basis of \d+ vectors, ")

    @unittest.skipUnless(hasattr(os, "openpty"), "there are no pseudo-terminals")
    def test_ctrl_c_on_a_terminal_ends_the_line(self) -> None:
        long = {**SWING, "analysis": {**SWING["analysis"], "end_time": 1e3}}
        program = (
            "import signal, tegula\n"
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "try:\n"
            f"    tegula.Model.from_toml({tegula.Model(long).text!r}).run(progress=True)\n"
            "except KeyboardInterrupt:\n"
            "    print('caught')\n"
        )
        master, slave = os.openpty()
        self.addCleanup(os.close, master)
        with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=slave, text=True) as child:
            os.close(slave)
            shown = b""
            while b"step 1" not in shown:
                shown += os.read(master, 4096)
            child.send_signal(signal.SIGINT)
            while b"interrupted at time" not in shown or not shown.endswith(b"\n"):
                shown += os.read(master, 4096)
            self.assertEqual(child.communicate(timeout=60)[0], "caught\n")
        self.assertIn(b"[....", shown)


if __name__ == "__main__":
    unittest.main()
