"""Preprocessor of mdbook: typesets the formulas of the book as MathML, which browsers render without network access.

`$…$` is a formula in a line, `$$…$$` a displayed one; `\\\\(…\\\\)` and `\\\\[…\\\\]` are the same. Code spans and code blocks are
left alone, `\\$` is a dollar. Formulas are written in the subset of LaTeX that `Parser` knows. A formula outside of it fails the
build, with its page.

Usage: mdbook runs it, see book/book.toml. `python3 scripts/book_math.py 'LATEX'` prints the MathML of one formula.
"""

import json
import re
import sys

GREEK = "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigmaf sigma tau upsilon phi chi psi omega"
LETTERS = {name: chr(0x3B1 + i) for i, name in enumerate(GREEK.split())}
LETTERS |= {name.capitalize(): chr(0x391 + i) for i, name in enumerate(GREEK.split()) if name != "sigmaf"}
LETTERS |= {"varepsilon": "ε", "varphi": "φ", "epsilon": "ϵ", "phi": "ϕ", "vartheta": "ϑ", "ell": "ℓ"}
UPRIGHT = {"partial": "∂", "nabla": "∇", "infty": "∞", "emptyset": "∅"}
FUNCTIONS = "ln log exp sin cos tan det dim arg".split()
LIMITS = {"sum": "∑", "prod": "∏", "min": "min", "max": "max", "lim": "lim"}
INTEGRALS = {"int": "∫", "oint": "∮"}
OPERATORS = {
    "cdot": "⋅", "times": "×", "otimes": "⊗", "oplus": "⊕", "pm": "±", "mp": "∓", "circ": "∘", "to": "→", "leftarrow": "←",
    "Rightarrow": "⇒", "le": "≤", "ge": "≥", "ne": "≠", "approx": "≈", "equiv": "≡", "sim": "∼", "ll": "≪", "gg": "≫",
    "in": "∈", "mid": "∣", "dots": "…", "ldots": "…", "cdots": "⋯", "colon": ":", "perp": "⊥", "propto": "∝", "parallel": "∥",
}  # fmt: skip
FENCES = {"lvert": "|", "rvert": "|", "lVert": "‖", "rVert": "‖", "langle": "⟨", "rangle": "⟩", "{": "{", "}": "}"}
OPENING = ("lvert", "lVert", "langle", "{")
ACCENTS = {"hat": "^", "bar": "¯", "tilde": "~", "dot": "˙", "ddot": "¨", "overline": "¯", "widetilde": "~"}
SPACES = {",": 0.167, ":": 0.222, ";": 0.278, " ": 0.333, "!": -0.167, "quad": 1.0, "qquad": 2.0}
SIZES = {"bigl": 1.3, "bigr": 1.3, "Bigl": 1.8, "Bigr": 1.8}
MATRICES = {"aligned": ("", ""), "bmatrix": ("[", "]"), "pmatrix": ("(", ")"), "cases": ("{", "")}
# Tokens that close a group; tokens before which a function needs no space.
CLOSING = ("}", "&", "\\\\", "\\right", "\\end")
TIGHT = ("\\left", "\\right", "\\end", "\\bigl", "\\Bigl", "\\bigr", "\\Bigr", "\\quad", "\\qquad", "\\le", "\\ge")
TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\d+(?:\.\d+)?|\s+|.", re.S)
# Code is matched first, so that its dollars are no formulas.
FORMULA = re.compile(
    r"(?P<code>^(?P<indent>[ >]*)(?P<fence>```+|~~~+).*?(?:^[ >]*(?P=fence)[`~]*[ \t]*$|\Z)|(?P<ticks>`+)(?!`).*?(?<!`)(?P=ticks)(?!`))"
    r"|(?P<escaped>\\\$)"
    r"|\$\$(?P<display>.+?)\$\$|\\\\\[(?P<display2>.+?)\\\\\]|\\\\\((?P<inline2>.+?)\\\\\)"
    r"|\$(?P<inline>(?:[^$\n]|\n(?!\s*\n))+?)\$"
    r"|(?P<stray>\$)",
    re.S | re.M,
)


class Unknown(Exception):
    """Formula that is not in the subset of LaTeX."""


def text(characters: str) -> str:
    """Characters as Markdown and HTML leave them: all but letters, digits and spaces by their number."""
    return "".join(c if c.isalnum() or ord(c) > 127 else f"&#{ord(c)};" for c in characters)


def tag(name: str, content: str, **attributes: str) -> str:
    return f"<{name}{''.join(f' {k}={chr(34)}{v}{chr(34)}' for k, v in attributes.items())}>{content}</{name}>"


def row(nodes: list[str]) -> str:
    return nodes[0] if len(nodes) == 1 else tag("mrow", "".join(nodes))


def bold(character: str) -> str:
    """Bold letter of the block of mathematical letters: Latin ones and digits upright, Greek ones slanted."""
    for first, last, to in [("A", "Z", 0x1D400), ("a", "z", 0x1D41A), ("0", "9", 0x1D7CE), ("α", "ω", 0x1D736)]:
        if first <= character <= last:
            return chr(to + ord(character) - ord(first))
    # Greek capitals have an unused place in the middle, in both blocks.
    if "Α" <= character <= "Ω":
        return chr(0x1D71C + ord(character) - ord("Α"))
    raise Unknown(f"no bold {character!r}")


class Parser:
    """Recursive descent from LaTeX to MathML."""

    def __init__(self, source: str):
        self.tokens = TOKEN.findall(source)
        self.at = 0
        # Whether an operand stands before the present place: a sign without one is a prefix.
        self.operand = False

    def peek(self) -> str:
        """Next token that is no space, or nothing at the end."""
        while self.at < len(self.tokens) and self.tokens[self.at].isspace():
            self.at += 1
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def next(self) -> str:
        token = self.peek()
        if not token:
            raise Unknown("the formula ends too early")
        self.at += 1
        return token

    def expect(self, token: str) -> None:
        found = self.next()
        if found != token:
            raise Unknown(f"{token!r} expected, found {found!r}")

    def formula(self) -> str:
        nodes = self.nodes(())
        if not nodes:
            raise Unknown("the formula is empty")
        return row(nodes)

    def nodes(self, stops: tuple[str, ...]) -> list[str]:
        """Nodes up to one of the stops, which is not read."""
        out: list[str] = []
        self.operand = False
        while self.peek() not in (*stops, ""):
            if self.peek() in CLOSING:
                raise Unknown(f"unexpected {self.peek()!r}")
            out.append(self.scripts())
        return out

    def scripts(self) -> str:
        """Atom with its primes, subscript and superscript."""
        name = self.peek().removeprefix("\\")
        base = self.atom()
        operand, lower, upper = self.operand, "", []
        while self.peek() in ("^", "_", "'"):
            mark = self.next()
            if mark == "'":
                upper.append(tag("mo", "′"))
            elif mark == "^" and (not upper or upper[-1].startswith("<mo>′")):
                upper.append(self.argument())
            elif mark == "_" and not lower:
                lower = self.argument()
            else:
                raise Unknown("two subscripts or two superscripts")
        self.operand = operand
        if lower or upper:
            kind = ("m" + "under" * bool(lower) + "over" * bool(upper)) if name in LIMITS else ("m" + "sub" * bool(lower) + "sup" * bool(upper))
            base = tag(kind, base + lower + (row(upper) if upper else ""))
        gap = name in (*FUNCTIONS, "operatorname") and (self.peek()[:1].isalnum() or self.peek()[1:].isalpha() and self.peek() not in TIGHT)
        return tag("mrow", base + space(0.167)) if gap else base

    def argument(self) -> str:
        """Argument of a command or script: a group, or one digit, letter or command."""
        if self.peek() == "{":
            self.next()
            nodes = self.nodes(("}",))
            self.expect("}")
            content = row(nodes)
        elif len(self.peek()) > 1 and self.peek()[0].isdigit():
            digits = self.tokens[self.at]
            self.tokens[self.at : self.at + 1] = [digits[0], digits[1:]]
            content = tag("mn", self.next())
        else:
            content = self.atom()
        self.operand = True
        return content

    def raw(self) -> str:
        """Characters of an argument, with their spaces."""
        self.expect("{")
        start = self.at
        while self.next() != "}":
            pass
        return "".join(self.tokens[start : self.at - 1])

    def atom(self) -> str:
        if self.peek() == "{":
            return self.argument()
        token = self.next()
        if token in "+-*=<>/,.;:!":
            return self.operator({"-": "−", "*": "∗"}.get(token, token))
        if token in "()[]":
            return self.fence(token, token in "([")
        if token.startswith("\\"):
            return self.command(token[1:])
        self.operand = True
        if token[0].isdigit():
            return tag("mn", text(token))
        if token.isascii() and token.isalpha():
            return tag("mi", token)
        raise Unknown("write \\lvert and \\rvert for |" if token == "|" else f"unknown character {token!r}")

    def command(self, name: str) -> str:
        if name in OPERATORS:
            return self.operator(OPERATORS[name])
        if name in LIMITS or name in INTEGRALS:
            self.operand = False
            gaps = {} if name in ("sum", "prod") else {"lspace": "0.167em", "rspace": "0.167em"}
            return tag("mo", LIMITS[name], movablelimits="true", **gaps) if name in LIMITS else tag("mo", INTEGRALS[name])
        if name in FENCES:
            return self.fence(FENCES[name], name in OPENING)
        if name in SIZES:
            return self.fence(self.delimiter(), name.endswith("l"), SIZES[name])
        if name in SPACES:
            return space(SPACES[name])
        node = self.structure(name)
        self.operand = True
        return node

    def structure(self, name: str) -> str:
        """Command that makes an operand."""
        if name in LETTERS:
            return tag("mi", LETTERS[name], **({"mathvariant": "normal"} if name[0].isupper() else {}))
        if name in UPRIGHT:
            return tag("mi", UPRIGHT[name], mathvariant="normal")
        if name in FUNCTIONS:
            return tag("mi", name)
        if name in ("frac", "tfrac", "dfrac"):
            fraction = tag("mfrac", self.argument() + self.argument())
            style = {"tfrac": "false", "dfrac": "true"}.get(name)
            return tag("mstyle", fraction, displaystyle=style, scriptlevel="0") if style else fraction
        if name == "sqrt":
            return tag("msqrt", self.argument())
        if name in ACCENTS:
            mark = tag("mo", text(ACCENTS[name]), stretchy=str(name in ("overline", "widetilde")).lower())
            return tag("mover", self.argument() + mark, accent="true")
        if name in ("mathbf", "boldsymbol"):
            return self.bold()
        if name == "text":
            return tag("mtext", text(self.raw().replace(" ", "\u00a0")))
        if name in ("mathrm", "operatorname"):
            word = self.raw()
            return tag("mi", text(word), **({"mathvariant": "normal"} if len(word) == 1 else {}))
        if name == "left":
            left = self.delimiter()
            nodes = self.nodes(("\\right",))
            self.expect("\\right")
            right = self.delimiter()
            return tag("mrow", self.fence(left, True, 0.0) + row(nodes) + self.fence(right, False, 0.0))
        if name == "begin":
            return self.environment()
        raise Unknown(f"unknown command \\{name}")

    def delimiter(self) -> str:
        """Delimiter after \\left, \\right and their like; empty for a dot."""
        token = self.next()
        if token not in ("(", ")", "[", "]", ".") and token[1:] not in FENCES:
            raise Unknown(f"unknown delimiter {token!r}")
        return FENCES.get(token[1:], token.strip("."))

    def bold(self) -> str:
        """Letters of the argument in bold, each an identifier of its own."""
        letters = re.findall(r"\\[A-Za-z]+|\S", self.raw() if self.peek() == "{" else self.next())
        plain = [LETTERS.get(letter[1:], "?") if letter.startswith("\\") else letter for letter in letters]
        return row([tag("mi", bold(letter)) for letter in plain])

    def environment(self) -> str:
        name = self.raw()
        if name not in MATRICES:
            raise Unknown(f"unknown environment {name!r}")
        rows: list[list[str]] = [[]]
        stop = ""
        while stop != "\\end":
            rows[-1].append(row(self.nodes(("&", "\\\\", "\\end"))))
            stop = self.next()
            if stop == "\\\\":
                rows.append([])
        if self.raw() != name:
            raise Unknown(f"\\begin{{{name}}} without its \\end")
        # A last line break is followed by nothing.
        rows = rows[:-1] if rows[-1] == [row([])] else rows

        def style(column: int) -> str:
            """Sides of a relation meet, pairs of columns stand apart."""
            side = "right" if name == "aligned" and column % 2 == 0 else "left"
            gap = f"padding-left:{2 if side == 'right' and column else 0}em;padding-right:0;" if name == "aligned" else ""
            # The second value moves blocks, such as cells hold in browsers, too.
            return f"{gap}text-align:{side};text-align:-webkit-{side}"

        styled = name in ("aligned", "cases")
        cells = [[tag("mtd", c, **({"style": style(i)} if styled else {})) for i, c in enumerate(r)] for r in rows]
        table = "".join(tag("mtr", "".join(r)) for r in cells)
        table = tag("mtable", table, **({"displaystyle": "true"} if name == "aligned" else {}))
        left, right = MATRICES[name]
        return tag("mrow", self.fence(left, True, 0.0) + table + self.fence(right, False, 0.0))

    def operator(self, character: str) -> str:
        """Operator; plus and minus without an operand before them are signs."""
        sign = {"form": "prefix"} if character in "+−±∓" and not self.operand else {}
        tight = {"lspace": "0", "rspace": "0"} if character in "/.!" else {}
        self.operand = character in ".!…⋯"
        return tag("mo", text(character), **sign, **tight)

    def fence(self, character: str, opens: bool, size: float | None = None) -> str:
        """Delimiter as high as a line of text, of a given size (em), or as high as what it encloses (0)."""
        self.operand = not opens
        if not character:
            return ""
        sized = {"minsize": f"{size}em", "maxsize": f"{size}em"} if size else {}
        stretchy = str(size is not None).lower()
        return tag("mo", text(character), form="prefix" if opens else "postfix", fence="true", stretchy=stretchy, **sized)


def space(width: float) -> str:
    return f'<mspace width="{width}em"></mspace>'


def mathml(source: str, display: bool = False) -> str:
    """MathML of a formula in LaTeX.

    Raises `Unknown` where the formula is not in the subset.
    """
    return tag("math", Parser(source).formula(), **({"display": "block"} if display else {}))


def page(content: str, path: str) -> str:
    """Page with its formulas typeset. Raises `Unknown` with path and formula where one is not in the subset."""

    def typeset(match: re.Match) -> str:
        if match["code"] is not None or match["escaped"]:
            return match[0].replace("\\$", "$") if match["escaped"] else match[0]
        source = match["display"] or match["display2"] or match["inline"] or match["inline2"] or ""
        try:
            if match["stray"]:
                raise Unknown("a dollar without its partner; \\$ is a dollar")
            return mathml(source, bool(match["display"] or match["display2"]))
        except Unknown as error:
            line = content[: match.start()].count("\n") + 1
            raise Unknown(f"book/src/{path}:{line}: {error}, in the formula {match[0].strip()!r}") from None

    return FORMULA.sub(typeset, content)


def chapters(items: list) -> None:
    """Typesets the formulas of all chapters in place."""
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter:
            chapter["content"] = page(chapter["content"], chapter.get("source_path") or chapter["name"])
            chapters(chapter["sub_items"])


def main() -> None:
    if sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2:] != ["html"])
    try:
        if sys.argv[1:]:
            print(mathml(sys.argv[1]))
        else:
            _, book = json.load(sys.stdin)
            chapters(book["items"])
            json.dump(book, sys.stdout)
    except Unknown as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
