"""Tests of the formulas of the book: `python3 scripts/test_book_math.py`."""

import json
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import book_math
from book_math import Unknown, mathml, page


def shape(source: str) -> str:
    """Elements and texts of a formula, in brackets."""

    def of(node: ElementTree.Element) -> str:
        return f"{node.tag}({node.text or ''.join(map(of, node))})"

    return "".join(map(of, ElementTree.fromstring(mathml(source))))


class Formulas(unittest.TestCase):
    def test_scripts_take_one_digit_or_a_group(self):
        self.assertEqual(shape("x_1^{10}"), "msubsup(mi(x)mn(1)mn(10))")
        self.assertEqual(shape("x^2_{ab}"), "msubsup(mi(x)mrow(mi(a)mi(b))mn(2))")
        self.assertEqual(shape(r"\tfrac12"), "mstyle(mfrac(mn(1)mn(2)))")
        self.assertEqual(shape("u'"), "msup(mi(u)mo(′))")

    def test_limits_of_sums_stand_below_and_above_those_of_integrals_beside(self):
        self.assertEqual(shape(r"\sum_a^b"), "munderover(mo(∑)mi(a)mi(b))")
        self.assertEqual(shape(r"\int_A"), "msub(mo(∫)mi(A))")

    def test_a_sign_without_an_operand_before_it_is_a_prefix(self):
        for source, signs in [("-a", 1), ("a - b", 0), ("a = -b", 1), ("(-a)", 1), ("(a) - b", 0), ("a_1 - b", 0)]:
            self.assertEqual(mathml(source).count('form="prefix">−'), signs, source)
        self.assertEqual(mathml(r"\dot{a} - \left(b\right) - \hat{c}").count('form="prefix">−'), 0)

    def test_letters_are_greek_bold_or_upright(self):
        self.assertEqual(shape(r"\lambda\varepsilon\Gamma"), "mrow(mi(λ)mi(ε)mi(Γ))")
        self.assertEqual(shape(r"\mathbf{K}\boldsymbol{\alpha}\mathbf 0"), "mrow(mi(𝐊)mi(𝜶)mi(𝟎))")
        self.assertEqual(shape(r"\mathrm{lin}\,\text{if it is}"), "mrow(mi(lin)mspace()mtext(if\u00a0it\u00a0is))")

    def test_functions_stand_apart_from_letters_and_close_to_brackets(self):
        self.assertEqual(shape(r"\ln a"), "mrow(mrow(mi(ln)mspace())mi(a))")
        self.assertEqual(shape(r"\operatorname{tr}\mathbf{A}"), "mrow(mrow(mi(tr)mspace())mi(𝐀))")
        self.assertEqual(shape(r"\ln(a)"), "mrow(mi(ln)mo(()mi(a)mo()))")

    def test_matrices_and_aligned_relations_are_tables(self):
        matrix = shape(r"\begin{bmatrix} a & b \\ c & d \end{bmatrix}")
        rows = "mtr(mtd(mi(a))mtd(mi(b)))mtr(mtd(mi(c))mtd(mi(d)))"
        self.assertEqual(matrix, f"mrow(mo([)mtable({rows})mo(]))")
        self.assertEqual(shape(r"\begin{aligned} a &= b \\ \end{aligned}").count("mtr"), 1)

    def test_other_formulas_are_refused(self):
        wrong = [r"\foo", "a_b_c", "{a", "a}", r"\left(a", "a & b", "|a|", r"\begin{array}a\end{array}", "", "é", r"\mathbf{+}",
                 r"\frac{a}", r"\begin{cases} a", "a^"]  # fmt: skip
        for source in wrong:
            self.assertRaises(Unknown, mathml, source)


class Pages(unittest.TestCase):
    def test_formulas_are_typeset_and_code_is_not(self):
        for source in ["`$a$`", "```text\n$a$\n```", "``a ` $b$``", "> ```\n> $a$\n> ```"]:
            self.assertEqual(page(source, "x.md"), source)
        for source in ["$a$", "the $a$.", r"\\(a\\)", "`b` $a$ `c`", "$a\n$"]:
            self.assertEqual(page(source, "x.md").count("<math><mi>a</mi></math>"), 1, source)
        for source in ["$$a$$", "$$\na\n$$", r"\\[a\\]"]:
            self.assertEqual(page(source, "x.md"), '<math display="block"><mi>a</mi></math>')
        self.assertEqual(page(r"5 \$ and $a$", "x.md"), "5 $ and <math><mi>a</mi></math>")

    def test_markdown_finds_nothing_to_format(self):
        made = mathml(r"a * b_c = [d] \{e\} \lvert f\rvert !" + r"\text{*_`~'}")
        texts = re.findall(r">([^<]*)<", made)
        self.assertFalse([t for t in texts if re.search(r"[*_`~\[\]{}|!']", t)])
        self.assertIn("*_`~'", "".join(ElementTree.fromstring(made).itertext()))

    def test_a_wrong_formula_names_page_line_and_formula(self):
        for content in ["one\n\n$\\foo$", "one\n\n$$\n\\foo\n$$", "one\n\n\\foo costs 5 $"]:
            with self.assertRaises(Unknown) as caught:
                page(content, "theory/x.md")
            self.assertIn("book/src/theory/x.md:3: ", str(caught.exception))
        self.assertIn("dollar", str(caught.exception))

    def test_mdbook_gets_its_book_back_or_an_error(self):
        def run(content: str) -> subprocess.CompletedProcess:
            below = {"Chapter": {"name": "b", "source_path": "b.md", "content": content, "sub_items": []}}
            above = {"Chapter": {"name": "a", "source_path": "a.md", "content": "$c$", "sub_items": [below]}}
            book = json.dumps([{}, {"items": ["Separator", {"PartTitle": "p"}, above]}])
            script = Path(book_math.__file__)
            return subprocess.run([sys.executable, script], input=book, text=True, capture_output=True, check=False)

        done = run("$d$")
        self.assertEqual(done.returncode, 0)
        self.assertEqual(json.loads(done.stdout)["items"][2]["Chapter"]["sub_items"][0]["Chapter"]["content"], page("$d$", ""))
        failed = run(r"$\foo$")
        self.assertEqual((failed.returncode, failed.stdout), (1, ""))
        self.assertIn(r"b.md:1: unknown command \foo", failed.stderr)


if __name__ == "__main__":
    unittest.main()
