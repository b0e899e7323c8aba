"""What the scripts about benchmarks share: printed lines, the file that keeps them as rows, and what a row is about."""

import json
import math
import os

# What a row is about; every other value of it is a figure, or tells more about the scene.
IDENTITY = "scene stage dofs rows mesh kind na nc budget_ms isa threads".split()
NOT_OURS = ("budget_ms", "thesis_ms", "cholmod_ms")
STAGES = "assembly factor detection compliance qp advance cycle".split()


class BadFile(Exception):
    """What was found, and what would be right."""


def read_value(text):
    """A number, None for nan, or the text."""
    try:
        number = float(text)
    except ValueError:
        return text
    if not math.isfinite(number):
        return None
    return int(number) if number == int(number) and "." not in text else number


def read_line(line):
    """The row of a line of name=value pairs; None for any other line."""
    words = line.split()
    if not words or any("=" not in word for word in words) or not words[0].startswith("scene="):
        return None
    return {name: read_value(text) for name, text in (word.split("=", 1) for word in words)}


def read_file(path):
    """(header, rows) of a file that scripts/benchmark --json wrote."""
    name = os.path.basename(path)
    try:
        with open(path, encoding="utf-8") as file:
            content = json.load(file)
    except OSError as error:
        raise BadFile(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise BadFile(f"{name}: no JSON: {error}") from None
    rows = content.get("rows") if isinstance(content, dict) else None
    if not isinstance(rows, list) or not all(isinstance(row, dict) and isinstance(row.get("scene"), str) for row in rows):
        raise BadFile(f"{name}: expected an object with a list 'rows' of objects with a 'scene', as scripts/benchmark --json writes")
    if not rows:
        raise BadFile(f"{name}: no rows in it")
    header = {name: value for name, value in content.items() if name != "rows"}
    return header, rows


def write_file(path, header, rows):
    """A line a row, so that two files can be compared by eye too."""
    text = json.dumps(header, indent=1)[:-2]
    lines = ",\n".join("  " + json.dumps(row) for row in rows)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f'{text},\n "rows": [\n{lines}\n ]\n}}\n')


def identify(row):
    """((name, value), ...) of what a row is about. In a series over contacts their number is part of that."""
    names = IDENTITY + (["contacts"] if row["scene"] == "scaling_contacts" else [])
    return tuple((name, row[name]) for name in names if row.get(name) is not None)


def durations(row):
    """Of what we take: value by name, names with their unit."""
    return {
        name: value
        for name, value in row.items()
        if name.endswith(("_ms", "_us")) and name not in NOT_OURS and isinstance(value, (int, float))
    }


def pick(rows, scene, stage=None):
    return [row for row in rows if row["scene"] == scene and (stage is None or row.get("stage") == stage)]


def list_scenes(rows):
    """Names in the order of their first row."""
    return list(dict.fromkeys(row["scene"] for row in rows))
