"""Writes the classes of the Python package for the tables of the model file, `python/tegula/parts/`, from the program's schema.

Usage: python3 scripts/python_classes.py PROGRAM [--check]; with --check it fails where the files are not up to date.
"""

import json
import keyword
import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent.parent / "python" / "tegula" / "parts"
WIDTH = 120
# Titles of the modules, and the definitions of the schema that they have; each uses its own and those of modules above it.
MODULES = {
    "mesh": ("Meshes, sets and markers", ["Grid", "MeshSource", "MeshSet", "Imperfection", "Marker"]),
    "loads": (
        "Supports, loads, masses and functions of time",
        ["FieldName", "Distribution", "Ground", "Load", "Axis", "NodalVector", "Condition", "PrescribedStrain",
         "InitialVelocity", "AddedMass", "Damping", "Foundation", "Amplitude"],
    ),
    "sections": (
        "Materials and sections",
        ["Strengths", "NeoHookeanForm", "Material", "ElementKind", "Membrane", "LayupPly", "Layup", "Section"],
    ),
    "bodies": (
        "Bodies, beams, springs and ties",
        ["BodyShape", "RigidBody", "BeamSection", "Beam", "SpringDamper", "TorsionSpring", "Bushing", "Tie"],
    ),
    "joints": ("Joints", ["JointFriction", "JointStops", "Joint"]),
    "output": ("Sensors and output", ["Sensor", "OutputPoint", "Cut", "Field", "Still", "Units", "Output"]),
    "analysis": (
        "Analyses",
        ["NewtonMethod", "LinearSolver", "Crossing", "StopCondition", "Continuation", "PathMethod", "AllBranches", "Branches",
         "PathEnd", "FactorSigns", "Spacing", "FrequencyResponse", "ResponseInput", "Scheme", "Analysis", "AnalysisStep"],
    ),
    "model": ("The whole model", ["Model"]),
}  # fmt: skip
# Word behind the type in the name of a class: `edge` of `Load` is `EdgeLoad`.
SUFFIX = {
    "Analysis": "",
    "Scheme": "",
    "Condition": "",
    "MeshSource": "Mesh",
    "MeshSet": "Set",
    "BodyShape": "Shape",
    "AddedMass": "Mass",
    "PrescribedStrain": "Strain",
}
# Names that this rule would not give.
NAMES = {
    ("Analysis", "path"): "EquilibriumPath",
    ("Scheme", "hht"): "HHT",
    ("Scheme", "bdf2"): "BDF2",
    ("MeshSource", "none"): "NoMesh",
    ("MeshSource", "abaqus"): "AbaqusMesh",
    ("MeshSource", "vtu"): "VTUMesh",
    ("BodyShape", "stl"): "STLShape",
    ("Condition", "spherical"): "SphericalSupport",
    ("Condition", "symmetry"): "SymmetryPlane",
    ("Condition", "prescribe"): "PrescribedMotion",
    ("PrescribedStrain", "prestress"): "Prestress",
}
HEAD = '''"""{title} of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

'''


def class_name(union: str, kind: str) -> str:
    """Name of the class of a type, such as `EdgeLoad`."""
    words = "".join(word.capitalize() for word in kind.split("-"))
    return NAMES.get((union, kind), words + SUFFIX.get(union, union))


def kinds(definition: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Tables of a definition by their `type`; none where it has only one."""
    return {case["if"]["properties"]["type"]["const"]: case["then"] for case in definition.get("allOf", [])}


def annotation(node: dict[str, Any], definitions: dict[str, Any]) -> str:
    """Annotation of a value of the schema."""
    if "$ref" in node:
        name = node["$ref"].rsplit("/", 1)[1]
        return f"{name} | Keys" if definitions[name].get("type") == "object" else name
    if "anyOf" in node:
        options = " | ".join(annotation(option, definitions) for option in node["anyOf"])
        return " | ".join(dict.fromkeys(options.split(" | ")))
    if isinstance(node["type"], list):
        return " | ".join(annotation({**node, "type": kind}, definitions) for kind in node["type"])
    if node["type"] == "array":
        inner = annotation(node["items"], definitions)
        arrays = {"Number": "Numbers", "Integer": "Integers", "Numbers": "Rows", "Integers": "IntegerRows"}
        return arrays.get(inner, f"Sequence[{inner}]")
    if node["type"] == "object":
        return f"Mapping[str, {annotation(node['additionalProperties'], definitions)}]"
    return {"string": "str", "number": "Number", "integer": "Integer", "boolean": "bool"}[node["type"]]


def values(node: dict[str, Any], definitions: dict[str, Any]) -> list[str]:
    """Texts that a value may be, as its items may; none where it is no enumeration."""
    node = node.get("items", node)
    node = definitions[node["$ref"].rsplit("/", 1)[1]] if "$ref" in node else node
    return [name for option in node.get("anyOf", []) for name in values(option, definitions)] or (
        node.get("enum", []) if node.get("type") == "string" else []
    )


def sentence(text: str) -> str:
    """A description in one line, without backslashes, which docstrings would need twice."""
    return re.sub(r"\s+", " ", text).strip().replace("\\", "\\\\").replace('"""', "'''")


def wrapped(text: str, first: str, rest: str) -> str:
    return textwrap.fill(text, WIDTH, initial_indent=first, subsequent_indent=rest, break_long_words=False, break_on_hyphens=False)


def python_name(key: str) -> str:
    """Name of a key in Python: words of the language have an underscore."""
    return f"{key}_" if keyword.iskeyword(key) else key


def keys_of(table: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Keys of a table but its type, those that are required first."""
    required = table.get("required", [])
    found = {key: node for key, node in table.get("properties", {}).items() if key != "type" or "const" not in node}
    return {key: found[key] for key in sorted(found, key=lambda key: key not in required)}


def class_of(name: str, table: dict[str, Any], kind: str | None, definitions: dict[str, Any]) -> str:
    """Text of a class."""
    required, found = table.get("required", []), keys_of(table)
    lines = [f"class {name}(Part" + (f', type="{kind}"' if kind else "") + "):"]
    head = wrapped(sentence(table["description"]), '    """', "    ")
    if not found:
        return "\n".join([*lines, head + '"""', ""])
    lines += [head, "", "    Args:"]
    for key, node in found.items():
        texts = values(node, definitions)
        more = f" Values: {', '.join(f'`{text}`' for text in texts)}." if texts else ""
        lines.append(wrapped(f"{python_name(key)}: {sentence(node['description'])}{more}", " " * 8, " " * 12))
    lines += ['    """', ""]
    for key, node in found.items():
        end = "" if key in required else " | None = None"
        lines.append(f"    {python_name(key)}: {annotation(node, definitions)}{end}")
    return "\n".join([*lines, ""])


def alias(name: str, options: list[str], description: str) -> str:
    """Text of a name for a union."""
    line = f"{name} = {' | '.join(options)}"
    if len(line) > WIDTH:
        line = f"{name} = (\n    " + "\n    | ".join(options) + "\n)"
    return f'{line}\n{wrapped(sentence(description), chr(34) * 3, "")}"""\n'


def literal(name: str, definition: dict[str, Any]) -> str:
    """Text of an enumeration, with the meaning of each value."""
    texts = [f'"{text}"' for text in definition["enum"]]
    line = f"{name} = Literal[{', '.join(texts)}]"
    if len(line) > WIDTH:
        line = f"{name} = Literal[\n    " + ",\n    ".join(texts) + ",\n]"
    meaning = [sentence(text) for text in definition["enumDescriptions"]]
    lines = [f'{line}\n{wrapped(sentence(definition["description"]), chr(34) * 3, "")}\n']
    lines += [wrapped(f"`{text}`: {what}", "", "    ") for text, what in zip(definition["enum"], meaning, strict=True)]
    return "\n".join([*lines, '"""', ""])


def parts_of(name: str, definitions: dict[str, Any]) -> dict[str, str]:
    """Texts of a definition by the names that they define."""
    definition = definitions[name]
    tables = kinds(definition)
    if tables:
        names = {kind: class_name(name, kind) for kind in tables}
        out = {names[kind]: class_of(names[kind], table, kind, definitions) for kind, table in tables.items()}
        return {**out, name: alias(name, list(names.values()), definition["description"])}
    if "anyOf" in definition:
        return {name: alias(name, annotation(definition, definitions).split(" | "), definition["description"])}
    if "enum" in definition:
        return {name: literal(name, definition)}
    return {name: class_of(name, definition, None, definitions)}


def keywords_of(model: dict[str, Any], definitions: dict[str, Any]) -> str:
    """Text of the keywords of `tegula.Model`."""
    lines = ["class ModelKeys(TypedDict, total=False):", '    """Tables of the model, as the keywords of `tegula.Model`."""', ""]
    lines += [f"    {key}: {annotation(node, definitions)} | None" for key, node in keys_of(model).items()]
    return "\n".join([*lines, ""])


def imports(text: str, homes: dict[str, str], own: set[str]) -> str:
    """Imports of a module: the names that stand in its code."""
    code = re.sub(r'""".*?"""', "", text, flags=re.S)
    words = set(re.findall(r"\w+", re.sub(r'"[^"]*"', "", code)))
    lines = []
    for module, names in [
        ("collections.abc", ["Mapping", "Sequence"]),
        ("typing", ["Literal", "TypedDict"]),
        (".._part", ["Integer", "IntegerRows", "Integers", "Keys", "Number", "Numbers", "Part", "Rows"]),
    ]:
        if used := [name for name in names if name in words]:
            lines.append(f"from {module} import {', '.join(used)}")
            if not module.startswith("."):
                continue
    others: dict[str, list[str]] = {}
    for name in sorted(words & homes.keys() - own):
        others.setdefault(homes[name], []).append(name)
    for module, names in sorted(others.items()):
        line = f"from .{module} import {', '.join(names)}"
        lines.append(line if len(line) <= WIDTH else f"from .{module} import (\n" + "".join(f"    {n},\n" for n in names) + ")")
    at = next(i for i, line in enumerate(lines) if line.startswith("from ."))
    lines.insert(at, "")
    return "\n".join(line for i, line in enumerate(lines) if line or i) + "\n\n\n"


def files(schema: dict[str, Any]) -> dict[str, str]:
    """Texts of the modules by their file names."""
    definitions = dict(schema["$defs"])
    model = {key: value for key, value in schema.items() if key != "$defs"}
    marker = model["properties"]["markers"]["items"]
    definitions["Marker"] = marker
    model["properties"]["markers"]["items"] = {"$ref": "#/$defs/Marker"}
    definitions["Model"] = model
    placed = [name for _, names in MODULES.values() for name in names]
    if wrong := set(placed) ^ definitions.keys():
        sys.exit(f"scripts/python_classes.py: MODULES and the schema differ: {', '.join(sorted(wrong))}")
    out, homes = {}, {}
    for module, (title, names) in MODULES.items():
        texts = {key: text for name in names for key, text in parts_of(name, definitions).items()}
        if module == "model":
            texts["ModelKeys"] = keywords_of(model, definitions)
        if twice := texts.keys() & homes.keys():
            sys.exit(f"scripts/python_classes.py: two classes have the name {', '.join(twice)}: give one another name in NAMES")
        homes |= dict.fromkeys(texts, module)
        body = "\n\n".join(texts.values())
        out[f"{module}.py"] = HEAD.format(title=title) + imports(body, homes, {*texts}) + body
    out["__init__.py"] = front(homes)
    return out


def front(homes: dict[str, str]) -> str:
    """Text of the package that has all classes."""
    text = '''"""Tables of the model file as classes with its names and keys; written by `scripts/python_classes.py` from `tegula schema`.

A table of a `type` is a class of its own, named by the type and the kind of table: `type = "edge"` of a load is `EdgeLoad`.
Keys are given by their names, and keys that are left out have the values that the program gives them.

>>> from tegula import parts
>>> parts.EdgeLoad(on="u_max", value=[0.0, 0.0, -1e3]).as_dict()
{'type': 'edge', 'on': 'u_max', 'value': [0.0, 0.0, -1000.0]}
"""

from .._part import Part
'''
    for module in sorted(MODULES):
        names = sorted(name for name, home in homes.items() if home == module)
        text += f"from .{module} import (\n" + "".join(f"    {name},\n" for name in names) + ")\n"
    return text + "\n__all__ = [\n" + "".join(f'    "{name}",\n' for name in sorted([*homes, "Part"])) + "]\n"


def main() -> None:
    programs = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(programs) != 1:
        sys.exit(__doc__)
    schema = json.loads(subprocess.run([programs[0], "schema"], check=True, capture_output=True, text=True, encoding="utf-8").stdout)
    texts = files(schema)
    FOLDER.mkdir(exist_ok=True)
    present = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.py")}
    if "--check" in sys.argv:
        if present != texts:
            sys.exit(f"{FOLDER} is not up to date: run python3 scripts/python_classes.py target/release/tegula")
        return
    for name in present.keys() - texts.keys():
        (FOLDER / name).unlink()
    for name, text in texts.items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
