"""Tests and verification cases must fail on NaN: refuses folds that drop it.

`f64::max`, `f64::min` and nalgebra's `amax` take a number before NaN, so the largest deviation of a result that is NaN
everywhere is 0. `tegula::norm` has maximum norms that keep it.

Usage: python3 scripts/check_nan.py [FOLDER]; the folder of the repository is the default.
"""

import re
import sys
from pathlib import Path

ADVICE = "drops NaN: use `max_norm` or `larger` of `tegula::norm`"
# Anything that says that a call of `max` or `min` compares real numbers.
REAL = r"\d\.\d|\de-\d|f64|abs\(\)|norm\(|norm_squared\(|error|worst|drift|_size\b"
# An argument that is a whole number.
WHOLE = r"(?:\w+ [-+] )?\d+"
PATTERNS = [
    re.compile(r"\bf(?:64|32)::(?:max|min|clamp)\b"),
    re.compile(r"\.a(?:max|min)\(\)"),
    # A fold or reduction over pairs: `fold(0.0_f64, |a, b| a.max(b.abs()))`.
    re.compile(r"\b(?:fold|reduce)\([^;]{0,60}?\|[^|;]*\|[^;]{0,80}?\.(?:max|min)\((?=[^)])"),
    # A running maximum: `worst = worst.max(…)`.
    re.compile(r"\b([\w.]+(?:\[\w+\])?) = \1\.(?:max|min)\("),
    re.compile(rf"^.*(?:{REAL}).*\.(?:max|min)\((?!{WHOLE}\))[^)].*$", re.M),
    re.compile(rf"^.*\.(?:max|min)\([^)\n]*(?:{REAL}).*$", re.M),
]


def test_code(path: Path) -> tuple[int, str]:
    """First line (from 0) and text of what a file has of tests or cases."""
    text = path.read_text(encoding="utf-8")
    inside = {"tests", "verify", "locking"} & set(path.parts)
    if inside or path.stem == "tests":
        return 0, text
    at = text.find("#[cfg(test)]")
    return (0, "") if at < 0 else (text.count("\n", 0, at), text[at:])


def found(text: str) -> list[int]:
    """Lines (from 0) of a text on which numbers are compared so that NaN is lost."""
    code = re.sub(r"//[^\n]*", "", text)
    return sorted({code.count("\n", 0, m.end()) for p in PATTERNS for m in p.finditer(code)})


def own_test() -> None:
    """The patterns find what they are made for."""
    bad = [
        "x.fold(0.0, f64::max)",
        "x.iter()\n    .fold(0.0_f64, |m, x| m.max(x.abs()))",
        "errors[i] = errors[i].max(e);",
        "(a - b).amax() < 1e-3",
        "let error = relative(0).max(relative(1)); // error",
        "assert!(soft.max(1e-11) < x);",
        "x.reduce(|a, b| a.max(b))",
    ]
    good = ["columns[i.min(j)].entry(i.max(j))", "steps.iter().max().unwrap()", "max_norm(x)", "(n).max(3)", "(n - 1).max(1) as f64"]
    missed = [t for t in bad[:4] + bad[5:] if not found(t)] + [t for t in good if found(t)]
    if missed:
        sys.exit(f"check_nan.py misjudges {missed}")


def main() -> None:
    own_test()
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    places = []
    for path in sorted(path for folder in ("crates", "verification") for path in (root / folder).rglob("*.rs")):
        path = path.relative_to(root)
        first, text = test_code(root / path) if "target" not in path.parts else (0, "")
        lines = text.splitlines()
        places += [f"{path}:{first + n + 1}: {lines[n].strip()}" for n in found(text)]
    print("\n".join(f"{place}\n    {ADVICE}" for place in places) or "no fold over results drops NaN")
    sys.exit(bool(places))


if __name__ == "__main__":
    main()
