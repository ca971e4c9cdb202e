# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all fields of a case file, made of what the fields tell: meaning, kind, unit, range and default."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from lammps_jump.case.field_words import fields_by_name
from lammps_jump.case.fields import CaseFields
from lammps_jump.units import to_si, unit_in_words

from . import NONE

# ruff: noqa: RUF001  (a dash is meant for readers)

Schema = dict[str, Any]
SIGNS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
"""Bounds of numbers."""
MOST = {"maxItems": "items", "maxLength": "characters"}
"""Bounds of lists and texts."""
WORDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}
PAGE = re.compile(r"(?<=[( ])([\w/]*?)(\w+\.md)(#[\w-]+)?(?=\))")
"""A page of the docs that a field names."""
DIMENSIONS = {
    "m": "length", "m/s": "speed", "m/s^2": "acceleration", "m^2/s": "discharge per metre of width", "s": "time",
    "kg/m^3": "density", "degree": "angle", "degree/s": "rate of turn", "kg/m": "mass per metre of width",
    "kg*m": "moment of inertia per metre of width", "Pa": "pressure", "N/m": "stiffness, force per metre of width",
    "1/s": "rate", "1": "plain number",
}  # fmt: skip
"""What a number of each unit is."""
TRIED = (
    "mm um cm km in ft yd cm/s mm/s km/h ft/s mph knot cm/s^2 ft/s^2 N/kg m^3/s/m cm^2/s l/s/m ft^2/s us ms min h day "
    "g/cm3 g/cm^3 t/m3 lb/ft^3 rad mrad turn rad/s rpm t/m g/cm lb/ft t*m kg*m^2/m kPa MPa GPa bar N/mm^2 psi kN/m "
    "MN/m N/mm lbf/ft 1/ms 1/min Hz kHz % permille ppm"
).split()
"""Units that people give; each stands in the row of the fields that take it."""
HEAD = """\
# All fields of a case

This page is made from the models that check a case file. [The case file](../case.md) shows by examples how a case is
written. Values outside the ranges are refused before the run. A number with a unit is text, such as `"20 cm"`.
*Needed* marks a field that must be given. A – marks a default that the program finds, or none.
"""


def page() -> str:
    """The page, Markdown."""
    whole = CaseFields.model_json_schema()
    blocks = [HEAD, *_units(whole), *_section("the case", whole, whole)]
    for title, model in _models(whole):
        blocks += _section(title, model, whole)
    return "\n".join(blocks)


def _units(whole: Schema) -> Iterator[str]:
    """The units that are taken, each with what one of it is."""
    yield "## Units that are taken\n"
    yield "| a number that is | in | may also be given in (what one of it is) |\n|---|---|---|"
    for unit in DIMENSIONS:
        taken = [text for tried in TRIED if tried != unit if (text := _worth(tried, unit))]
        yield f"| {DIMENSIONS[unit]} | {NONE if unit == '1' else unit_in_words(unit)} | {', '.join(taken)} |"
    if unknown := set(_units_in(whole)) - set(DIMENSIONS):
        raise KeyError(f"units of fields without a word for what they measure: {', '.join(sorted(unknown))}")
    yield ""
    yield (
        "A friction coefficient may be given as an angle from 0 to below 90 degrees, whose tangent is taken. A count "
        "has no unit.\n"
    )


def _worth(tried: str, unit: str) -> str:
    """What 1 of a unit is in the unit of a field; empty where the field does not take it."""
    try:
        return f"`{tried}` ({to_si(f'1 {tried}', '' if unit == '1' else unit):.6g})"
    except ValueError:
        return ""


def _units_in(part: Any) -> Iterator[str]:
    if isinstance(part, dict):
        if isinstance(part.get("unit"), str):
            yield part["unit"]
        for value in part.values():
            yield from _units_in(value)
    elif isinstance(part, list):
        for value in part:
            yield from _units_in(value)


def names() -> set[str]:
    """Dotted names of all fields, without kinds: ``contact.friction``, ``walls.motion.rate``."""
    return {*fields_by_name(CaseFields)}


def _models(whole: Schema) -> Iterator[tuple[str, Schema]]:
    """Groups of fields below the root, each once a place, with the title of its section."""
    seen: set[tuple[str, str]] = set()
    waiting = [(name, part) for name, part in whole["properties"].items()]
    while waiting:
        path, part = waiting.pop(0)
        for reference in _references(part):
            if (path, reference) in seen:
                continue
            seen.add((path, reference))
            model = whole["$defs"][reference]
            if "properties" not in model:
                waiting.insert(0, (path, model))
                continue
            kind = model["properties"].get("kind", {}).get("const")
            yield (f"{path}, kind {kind}" if kind else path), model
            waiting += [(f"{path}.{name}", inner) for name, inner in model["properties"].items()]


def _references(part: Any) -> Iterator[str]:
    if isinstance(part, dict):
        if "$ref" in part:
            yield part["$ref"].rpartition("/")[2]
        for key, value in part.items():
            if key not in ("default", "discriminator"):
                yield from _references(value)
    elif isinstance(part, list):
        for value in part:
            yield from _references(value)


def _section(title: str, model: Schema, whole: Schema) -> Iterator[str]:
    yield f"## {title}\n"
    if ", kind " in title:
        yield model["description"].splitlines()[0] + "\n"
    yield "| field | meaning | kind | unit | range | default |\n|---|---|---|---|---|---|"
    needed = model.get("required", ())
    for name, part in model["properties"].items():
        if name == "kind" and "const" in part:
            continue
        if "description" not in part:
            raise KeyError(f"{title}: {name} has no description; give it one at the field")
        meaning = PAGE.sub(r"[\2](../\1\2\3)", part["description"])
        default = "needed" if name in needed else _default(part)
        if model is whole and name == "name":
            default = "name of the file"
        cells = (meaning, _kind(part, whole), _unit(part, whole), _range(part, whole), default)
        yield f"| `{name}` | {' | '.join(cells)} |"
    yield ""


def _default(part: Schema) -> str:
    value = part.get("default")
    if value is None or (isinstance(value, dict) and value):
        return NONE
    if isinstance(value, bool):
        return str(value).lower()
    if value in ("", [], {}):
        return "none"
    return f"{value:g}" if isinstance(value, float) else f"`{value}`" if isinstance(value, str) else str(value)


def _parts(part: Schema, whole: Schema) -> list[Schema]:
    """Alternatives of a field, null left out."""
    if "$ref" in part:
        inner = whole["$defs"][part["$ref"].rpartition("/")[2]]
        return [inner] if "properties" in inner else _parts(inner, whole)
    several = part.get("anyOf") or part.get("oneOf")
    if not several:
        return [] if part.get("type") == "null" else [part]
    return [found for one in several for found in _parts(one, whole)]


def _kind(part: Schema, whole: Schema) -> str:
    said = dict.fromkeys(_one_kind(one, whole) for one in _parts(part, whole))
    if "number" in said:
        said.pop("text", None)  # a number with a unit
    return " or ".join(said) or NONE


def _one_kind(part: Schema, whole: Schema) -> str:
    if "properties" in part:
        kind = part["properties"].get("kind", {}).get("const")
        return f"kind `{kind}`" if kind else "fields below"
    if "const" in part:
        return f"`{part['const']}`"
    if "enum" in part:
        return " or ".join(f"`{str(value).lower() if isinstance(value, bool) else value}`" for value in part["enum"])
    if part.get("type") == "array":
        if inner := part.get("prefixItems"):
            return "[" + ", ".join(_kind(one, whole) for one in inner) + "]"
        return f"list of {_kind(part.get('items', {}), whole)}"
    if part.get("type") == "object":
        return "fields by name"
    return WORDS.get(part.get("type", ""), "any")


def _search(part: Any, whole: Schema) -> Iterator[Schema]:
    """A field's own schema and those of its alternatives and items, groups of fields left out."""
    if not isinstance(part, dict):
        return
    yield part
    if "properties" in part:
        return
    if "$ref" in part:
        inner = whole["$defs"][part["$ref"].rpartition("/")[2]]
        if "properties" not in inner:
            yield from _search(inner, whole)
    for key in ("anyOf", "oneOf", "prefixItems"):
        for one in part.get(key, ()):
            yield from _search(one, whole)
    for key in ("items", "additionalProperties"):
        yield from _search(part.get(key), whole)


def _unit(part: Schema, whole: Schema) -> str:
    units = dict.fromkeys(one["unit"] for one in _search(part, whole) if "unit" in one)
    return ", ".join(unit_in_words(unit) for unit in units if unit != "1") or NONE


def _range(part: Schema, whole: Schema) -> str:
    found = []
    for one in _search(part, whole):
        found.append(" and ".join(f"{sign} {one[key]:g}" for key, sign in SIGNS.items() if key in one))
        if "prefixItems" not in one:  # a pair has two
            found += [f"at most {one[key]} {what}" for key, what in MOST.items() if key in one]
    return "; ".join(filter(None, dict.fromkeys(found))) or NONE
