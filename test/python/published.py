"""Whether files are as the formats' owners describe them: published_formats.json.

A description is the name of a type, "= VALUE" as Python prints it, alternatives of these with " | " between, a list with the
description of each of its items, or a dictionary of keys. Each key must be there, but for one that ends in "?". Others may be
there only if "*" describes them.
"""
import json
import numbers
import pathlib

FORMATS = json.loads((pathlib.Path(__file__).parent / "published_formats.json").read_text(encoding="utf-8"))
TYPES = {"int": numbers.Integral, "float": numbers.Real, "str": str, "list": list, "dict": dict, "object": object, "null": type(None)}


def _fits(value, described):
    if described.startswith("= "):
        return str(value) == described[2:]
    return isinstance(value, TYPES[described]) and not (described in ("int", "float") and isinstance(value, bool))


def problems(value, described, place=""):
    """Differences between value and description, a line each."""
    if isinstance(described, str):
        return [] if any(_fits(value, each) for each in described.split(" | ")) else [f"{place}: {value!r} is not {described}"]
    if isinstance(described, list):
        if not isinstance(value, list):
            return [f"{place}: {value!r} is no list"]
        return [line for i, item in enumerate(value) for line in problems(item, described[0], f"{place}[{i}]")]
    if not isinstance(value, dict):
        return [f"{place}: {value!r} is no dictionary"]
    keys = {key.rstrip("?"): each for key, each in described.items()}
    missing = [f"{place}.{key} is missing" for key in described if key != "*" and not key.endswith("?") and key not in value]
    unknown = [f"{place}.{key} is unknown" for key in value if key not in keys and "*" not in keys]
    return missing + unknown + [line for key, item in value.items() if key in keys or "*" in keys
                                for line in problems(item, keys.get(key, keys.get("*")), f"{place}.{key}")]
