"""Comments and the book speak the field's language: refuses doc lines that cannot be understood alone, and private words.

Usage: python3 scripts/check_words.py [--count]; with --count it prints the number of places by file and rule.
"""

import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# A doc line begins with the thing that it describes.
BEGINNING = re.compile(r"^\s*//[/!]\s+(What|Those|That of|The same|As before)\b")
# Words for which the field has others.
WORDS = {
    r"\bwork(?:s|ed|ing)? off\b": "eliminate, factor, process",
    r"\btake[ns]? off\b|\btook off\b": "subtract; Schur update",
    r"\bpass(?:es|ed)? on\b": "contribution block; transfer",
    r"\bwhat waits\b": "contribution-block stack",
    r"\bsubstructures?\b": "subdomain",
    r"\bturned? inside out\b|\binside out\b": "inverted element",
    r"\bstations?\b": "integration point",
    r"\bportions?\b": "batch",
    r"\bsparing\b": "low-memory mode",
    r"\bloose nodes?\b": "orphan node",
    r"\bgoes? on from\b": "restarts from",
    r"\bwith care\b": "threshold pivoting",
    r"\bin doubt\b": "growth check",
    r"\btorn\b": "partially assembled",
    r"\blikeness\b": "congruent elements",
    r"\bpieces of the mesh\b": "subdomain",
    r"\bfold ties?\b": "director-angle constraint",
    r"\blost moments?\b": "drilling component",
    r"\bloads? that follow\b": "follower load",
    r"\brounding floor\b": "stagnation at round-off",
    r"\bat (?:the|their|its) price\b": "cost",
    r"\bgoes? on with\b": "resumes, continues",
    r"\bh(?:e|o)lds? against\b": "compare with",
    r"\bslips? of the pen\b": "misspelt",
    r"\bfront door\b": "entry page",
    r"\bas the user says\b": "as the model file gives",
    r"\bpress(?:es|ed) flat\b|\bno answer to\b": "the law cannot be evaluated",
    r"\bpull(?:s|ed)? the bottom\b|\bpress(?:es|ed)? the top\b": "tension, compression",
    r"\b(?:hardly|likely not) meant\b": "not intended",
    r"\bwithout a word\b": "without a message",
}
PATTERNS = [(re.compile(word, re.I), better) for word, better in WORDS.items()]


def found(path: Path) -> list[tuple[int, str, str]]:
    """Line (from 1), rule and advice of everything wrong in a file."""
    out = []
    book = path.suffix == ".md"
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not book and BEGINNING.match(line):
            out.append((number, "beginning", "begin with a noun of the field"))
        text = line if book else line[line.find("//"):] if "//" in line else ""
        text = re.sub(r"`[^`]*`", "", text)
        out += [(number, pattern.pattern, better) for pattern, better in PATTERNS if pattern.search(text)]
    return out


def main() -> None:
    code = [p for folder in ("crates", "verification") for p in sorted((ROOT / folder).rglob("*.rs"))]
    files = [p for p in code if "target" not in p.parts]
    files += sorted((ROOT / "book" / "src").rglob("*.md"))
    files += [ROOT / f"{name}.md" for name in ("README", "ARCHITECTURE", "CHANGELOG", "CONTRIBUTING")]
    places = [(path.relative_to(ROOT), *place) for path in files for place in found(path)]
    if "--count" in sys.argv:
        for name, count in [("files", Counter(str(p[0]) for p in places)), ("rules", Counter(p[2] for p in places))]:
            print(name, *(f"{n:4} {key}" for key, n in count.most_common()), sep="\n  ")
    else:
        print("\n".join(f"{path}:{number}: {better}" for path, number, _, better in places) or "no private words")
    sys.exit(bool(places))


if __name__ == "__main__":
    main()
