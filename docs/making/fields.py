# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all fields of a case file: kind, unit, range and default, read from the models."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any, get_args

import yaml

from lammps_jump.analysis.quantities import LISTED
from lammps_jump.case.explain import fields_of
from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.base import Strict
from lammps_jump.scene import tracks, walls

from . import NONE

# ruff: noqa: RUF001  (a dash is meant for readers)

Schema = dict[str, Any]
UNIT = "SI unit: "
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
"""Bounds as pydantic calls them."""
UNITS = {"m^3": "m³", "m^2": "m²", "s^2": "s²", "degree": "degrees"}
WORDS = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}
MEANINGS: dict[str, str] = yaml.safe_load(Path(__file__).with_name("meanings.yaml").read_text(encoding="utf-8"))
"""What the fields mean, by `_key`; the analyses tell of their own."""
MEANINGS |= {f"analysis.{name}": one.asks for name, one in LISTED.items() if one.asks}
HEAD = """\
# All fields of a case

This page is made from the models that check a case file. [The case file](../case.md) shows by examples how a case is
written. Values outside the ranges are refused before the run. A number with a unit is text, such as `"20 cm"`.
*Needed* marks a field that must be given. A – marks a default that the program finds, or none.
"""


def page() -> str:
    """The page, Markdown."""
    whole = CaseFields.model_json_schema()
    blocks = [HEAD, *_section("the case", whole, whole)]
    for title, model in _models(whole):
        blocks += _section(title, model, whole)
    return "\n".join(blocks)


def meaning(title: str, name: str) -> str:
    """What a field of a group means; a field without a meaning stops the build."""
    return MEANINGS[_key(title, name)]


def keys() -> set[str]:
    """Keys of `MEANINGS` that the fields of all models ask for."""
    whole = CaseFields.model_json_schema()
    groups = [("the case", whole), *_models(whole)]
    return {
        _key(title, name)
        for title, model in groups
        for name, part in model["properties"].items()
        if not (name == "kind" and "const" in part)
    }


def _key(title: str, name: str) -> str:
    path, _, kind = title.partition(", kind ")
    if title == "the case":
        return name
    return own if kind and (own := f"{path}.{kind}.{name}") in MEANINGS else f"{path}.{name}"


def names() -> set[str]:
    """Dotted names of all fields, without kinds: ``contact.friction``, ``walls.motion.rate``."""
    whole = CaseFields.model_json_schema()
    found = {name for name in whole["properties"]}
    for title, model in _models(whole):
        found |= {f"{title.split(',')[0]}.{name}" for name in model["properties"]}
    return found


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


def _classes() -> dict[str, type]:
    """Classes of the groups of fields, by name."""
    found = [CaseFields, *(value for part in (walls, tracks) for value in vars(part).values() if is_dataclass(value))]
    waiting = [Strict]
    while waiting:
        found += (below := waiting.pop().__subclasses__())
        waiting += below
    return {getattr(one, "model_config", {}).get("title", one.__name__): one for one in found}


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
    yield "| field | meaning | kind | unit | range | default |\n|---|---|---|---|---|---|"
    needed = model.get("required", ())
    known = _classes().get(model["title"])
    fields = fields_of(known) if known else {}
    for name, part in model["properties"].items():
        if name == "kind" and "const" in part:
            continue
        default = "needed" if name in needed else _default(part, whole)
        if model is whole and name == "name":
            default = "name of the file"
        span = _range(part, fields.get(name), whole)
        unit = _unit(part, fields.get(name), whole)
        yield f"| `{name}` | {meaning(title, name)} | {_kind(part, whole)} | {unit} | {span} | {default} |"
    yield ""


def _default(part: Schema, whole: Schema) -> str:
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


def _search(part: Any, whole: Schema, deep: bool = True) -> Iterator[Schema]:
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
    yield from _search(part.get("items"), whole)


def _unit(part: Schema, field: Any, whole: Schema) -> str:
    told = [one.get("description", "") for one in _search(part, whole)]
    for item in getattr(field, "metadata", ()):  # a description of the field hides that of its unit
        told.append((getattr(item, "json_schema", None) or {}).get("description", ""))
    units = dict.fromkeys(text.removeprefix(UNIT) for text in told if text.startswith(UNIT))
    said = ", ".join(unit for unit in units if unit != "1") or NONE
    for old, new in UNITS.items():
        said = said.replace(old, new)
    return said


def _range(part: Schema, field: Any, whole: Schema) -> str:
    bounds = [*getattr(field, "metadata", ()), *_limits_within(getattr(field, "annotation", None))]
    found = [_bound(lambda key, item=item: getattr(item, key, None)) for item in bounds]
    both = " and ".join(dict.fromkeys(filter(None, found)))
    told = [both] if both else [_bound(one.get) for one in _search(part, whole)]
    return "; ".join(filter(None, dict.fromkeys(told))) or NONE


def _bound(get: Any) -> str:
    return " and ".join(f"{sign} {get(key):g}" for key, sign in SIGNS.items() if get(key) is not None)


def _limits_within(kind: Any) -> Iterator[Any]:
    """What annotates a type, or types within it."""
    if isinstance(kind, type):
        return
    for item in getattr(kind, "__metadata__", ()):
        yield from getattr(item, "metadata", (item,))
    for inner in get_args(kind):
        yield from _limits_within(inner)
