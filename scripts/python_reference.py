"""Writes the reference of the Python package, `book/src/python-reference.md`, from its signatures and docstrings.

Usage: python3 scripts/python_reference.py [--check]; with --check it fails where the page is not up to date. Nothing is imported.
"""

import ast
import inspect
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "python" / "tegula"
PAGE = ROOT / "book" / "src" / "python-reference.md"
CHAPTERS = {
    "Models": ["Model", "run"],
    "Knock-down curves": ["knock_down", "KnockDown"],
    "Meshes of other packages": ["from_gmsh", "from_meshio", "from_pyvista"],
    "Results": ["Result", "Table", "Frame", "Fields", "FieldArrays", "StateSpace"],
    "Step by step": ["Simulation", "Energies", "Statistics", "Progress"],
    "Equations of motion": ["Equations", "State"],
    "Loads and materials of your own": ["NodalForce", "ElasticLaw"],
    "Errors and warnings": ["TegulaError", "ModelError", "Diagnostic", "AnalysisError", "OutputError", "ModelWarning"],
}
# Names of the package that have no section of their own.
OTHERS = {"parts", "__version__"}
HEAD = """# Python reference

All classes and functions of the package `tegula`, from its docstrings; [Python](python.md) explains them with examples. `scripts/python_reference.py` writes this page.

Arrays are those of NumPy; in shapes n is the number of nodes, m that of elements, and V that of nodal vectors, unless the text says otherwise. Lengths, forces and
times have the units of the model. `Keys` is a dictionary with the keys of a model file (`Mapping[str, Any]`), and `Materials` a dictionary of laws by the names of their
materials.
"""
SECTIONS = ("Args", "Returns", "Raises")


def modules(folder: Path) -> dict[str, ast.Module]:
    return {path.stem: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.py"))}


def definitions(trees: dict[str, ast.Module]) -> dict[str, ast.ClassDef | ast.FunctionDef]:
    """Classes and functions of the modules by their names."""
    return {node.name: node for tree in trees.values() for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


def exported(front: ast.Module) -> set[str]:
    """Names in `__all__`."""
    values = [node.value for node in front.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"]
    return set(ast.literal_eval(values[0]))


def text_of(docstring: str) -> str:
    """A docstring as Markdown: its sections are lists."""
    out: list[str] = []
    section = ""
    for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(docstring)):
        lines = paragraph.splitlines()
        if (title := lines[0].removesuffix(":")) in SECTIONS and lines[0].endswith(":"):
            section = title
            out.append(f"*{section}*\n\n{items(lines[1:], section)}")
        elif paragraph.startswith("    "):
            out.append("```text\n" + inspect.cleandoc(paragraph) + "\n```")
        else:
            out.append(" ".join(line.strip() for line in lines))
    return "\n\n".join(out)


def items(lines: list[str], section: str) -> str:
    """Entries of a section; deeper lines continue the one above."""
    joined: list[str] = []
    for line in lines:
        if line.startswith(" " * 8) and joined:
            joined[-1] += " " + line.strip()
        else:
            joined.append(line.strip())
    if section == "Returns":
        return " ".join(joined)
    return "\n".join(re.sub(r"^([\w.]+): ", r"- `\1`: ", line) for line in joined)


def signature(node: ast.FunctionDef, name: str) -> str:
    """Call of a function with its annotations, without `self` and private arguments."""
    arguments = node.args
    before = len(arguments.args) - len(arguments.defaults)
    shown = [
        f"{argument_text(a)}{'' if i < before else ' = ' + ast.unparse(arguments.defaults[i - before])}"
        for i, a in enumerate(arguments.args)
        if a.arg not in ("self", "cls")
    ]
    named = [
        f"{argument_text(a)}{'' if default is None else ' = ' + ast.unparse(default)}"
        for a, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
        if not a.arg.startswith("_")
    ]
    if named:
        shown += ["*", *named]
    if arguments.kwarg:
        shown.append(f"**{argument_text(arguments.kwarg)}")
    result = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__init__" else ""
    line = f"{name}({', '.join(shown)}){result}"
    return line if len(line) <= 110 else f"{name}(\n    " + ",\n    ".join(shown) + f",\n){result}"


def argument_text(argument: ast.arg) -> str:
    return f"{argument.arg}: {ast.unparse(argument.annotation)}" if argument.annotation else argument.arg


def is_a(node: ast.FunctionDef, decorator: str) -> bool:
    return any(ast.unparse(d) == decorator for d in node.decorator_list)


def function(node: ast.FunctionDef, name: str, heading: str) -> str:
    return f"{heading} `{name}`\n\n```python\n{signature(node, name)}\n```\n\n{text_of(described(node, name))}\n"


def described(node: ast.ClassDef | ast.FunctionDef, name: str) -> str:
    docstring = ast.get_docstring(node, clean=True)
    if not docstring:
        sys.exit(f"scripts/python_reference.py: {name} has no docstring")
    return docstring


def attributes(node: ast.ClassDef) -> list[tuple[str, str, str]]:
    """Name, type and description of fields and properties."""
    found = []
    for part, below in zip(node.body, [*node.body[1:], None]):
        if not (isinstance(part, ast.AnnAssign) and isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)):
            continue
        name = ast.unparse(part.target)
        if not name.startswith("_"):
            found.append((name, ast.unparse(part.annotation), text_of(str(below.value.value))))
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and is_a(part, "property") and not part.name.startswith("_"):
            name = f"{node.name}.{part.name}"
            kind = ast.unparse(part.returns) if part.returns else ""
            found.append((part.name, kind, text_of(described(part, name))))
    return found


def class_text(node: ast.ClassDef) -> str:
    """Section of a class: constructor, attributes, methods."""
    functions = {part.name: part for part in node.body if isinstance(part, ast.FunctionDef)}
    docstring = text_of(described(node, node.name))
    code = ""
    # Classes whose constructor is not described are made by others.
    if "*Args*" in docstring and "__init__" in functions:
        code = f"```python\n{signature(functions['__init__'], node.name)}\n```\n\n"
    bases = [ast.unparse(base) for base in node.bases]
    kind = "".join(f" A kind of `{base}`." for base in bases if base.endswith(("Error", "Warning", "Exception")))
    text = f"### `{node.name}`\n\n{code}{docstring}{kind}\n"
    if found := attributes(node):
        text += "\n| attribute | type | is |\n|---|---|---|\n"
        text += "".join(f"| `{name}` | {f'`{escaped(kind)}`' if kind else ''} | {in_cell(description)} |\n" for name, kind, description in found)
    for name, part in functions.items():
        if not name.startswith("_") and not is_a(part, "property"):
            text += "\n" + function(part, f"{node.name}.{name}", "####")
    return text


def escaped(text: str) -> str:
    return text.replace("|", r"\|")


def in_cell(text: str) -> str:
    """Text of a cell of a table, whose lists are sentences."""
    text = re.sub(r"\n\n\*Raises\*\n\n", " Raises ", text)
    text = re.sub(r"\n- ", "; ", text).replace("Raises - ", "Raises ")
    return escaped(" ".join(text.split()))


def parts_text() -> str:
    """Section of the classes of `tegula.parts`."""
    text = "## Tables of the model file\n\n"
    text += "The classes of `tegula.parts` have the keys of the [model file](model-file.md) as keywords and attributes, and these methods:\n\n"
    base = definitions({"_part": ast.parse((PACKAGE / "_part.py").read_text(encoding="utf-8"))})["Part"]
    assert isinstance(base, ast.ClassDef)
    for part in base.body:
        if isinstance(part, ast.FunctionDef) and not part.name.startswith("_"):
            text += function(part, f"Part.{part.name}", "###") + "\n"
    trees = {name: tree for name, tree in modules(PACKAGE / "parts").items() if name != "__init__"}
    text += "| class | `type` | is |\n|---|---|---|\n"
    for tree in trees.values():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and node.name != "ModelKeys":
                kinds = [ast.literal_eval(keyword.value) for keyword in node.keywords]
                first = text_of(described(node, node.name)).split("\n\n")[0]
                text += f"| `{node.name}` | {f'`{kinds[0]}`' if kinds else ''} | {escaped(first)} |\n"
    return text


def page() -> str:
    trees = modules(PACKAGE)
    known = definitions({name: tree for name, tree in trees.items() if name != "__init__"})
    listed = {name for names in CHAPTERS.values() for name in names}
    if wrong := listed ^ (exported(trees["__init__"]) - OTHERS):
        sys.exit(f"scripts/python_reference.py: CHAPTERS and `__all__` of the package differ: {', '.join(sorted(wrong))}")
    out = [HEAD]
    for title, names in CHAPTERS.items():
        out.append(f"## {title}\n")
        for name in names:
            node = known[name]
            out.append(class_text(node) if isinstance(node, ast.ClassDef) else function(node, name, "###"))
        if title == "Models":
            out.append(parts_text())
    return "\n".join(out)


def main() -> None:
    if "--check" not in sys.argv:
        PAGE.write_text(page(), encoding="utf-8")
    elif not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page():
        sys.exit("book/src/python-reference.md is not up to date: run python3 scripts/python_reference.py")


if __name__ == "__main__":
    main()
