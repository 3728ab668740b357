"""Text of a model in TOML."""

import json


def toml(value: object) -> str:
    """Value in TOML; tables are inline ones."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


def model_text(model: dict) -> str:
    """Model file of a dictionary: a line for each of its tables."""
    return "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in model.items())
