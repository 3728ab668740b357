"""The Python code of the book, the examples and the docstrings runs."""

import doctest
import os
import re
import runpy
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import Any

import tegula

ROOT = Path(__file__).resolve().parents[2]


class Documents(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, Path.cwd())
        os.chdir(folder.name)

    def test_the_code_of_the_book_runs(self) -> None:
        blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / "book/src/python.md").read_text("utf-8"), re.M | re.S)
        self.assertGreater(len(blocks), 4)
        names: dict[str, object] = {}
        for block in blocks:
            exec(compile(block, "python.md", "exec"), names)
        result = names["result"]
        assert isinstance(result, tegula.Result)
        self.assertAlmostEqual(result.history["tip.uz"][-1], -0.01904, places=5)

    def test_the_code_of_the_page_on_pypi_runs(self) -> None:
        (block,) = re.findall(r"^```python\n(.*?)^```$", (ROOT / "python/README.md").read_text("utf-8"), re.M | re.S)
        names: dict[str, Any] = {}
        exec(compile(block, "README.md", "exec"), names)
        self.assertAlmostEqual(names["result"].history["tip.uz"][-1], -0.01904, places=5)

    def test_the_examples_find_the_numbers_of_the_literature(self) -> None:
        examples = sorted((ROOT / "examples/python").glob("*.py"))
        self.assertGreater(len(examples), 2)
        for example in examples:
            with self.subTest(example=example.name), warnings.catch_warnings():
                warnings.simplefilter("error")
                runpy.run_path(str(example), run_name="__main__")

    def test_the_docstrings_are_right(self) -> None:
        for module, least in ((tegula, 4), (tegula.parts, 2)):
            tried = doctest.testmod(module)
            self.assertGreaterEqual(tried.attempted, least)
            self.assertEqual(tried.failed, 0)


if __name__ == "__main__":
    unittest.main()
