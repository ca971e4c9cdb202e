# SPDX-License-Identifier: GPL-2.0-or-later
"""Pydantic's errors in sentences: place, what is wrong, what is allowed, what to do; coefficients given as angles."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from lammps_jump.errors import CaseError
from lammps_jump.quoting import echoed, shortened
from lammps_jump.units import InUnit
from lammps_jump.written import angle_of, is_quantity, odd_blank, tangent

from . import field_words
from .field_words import (
    SIGNS,
    Vector,
    briefly,
    fields_at,
    fields_by_name,
    fields_of,
    kind_of,
    models_in,
    notes_of,
    range_of,
    vector_in,
)
from .fields import CaseFields
from .text import CaseSource, PathKey, dotted_path, nearest

UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
"""What pydantic calls a key that a model or a dataclass does not have."""

CLOSE = 0.75
"""Likeness of spelling from which a word is taken for a misspelt one, before words of the same meaning elsewhere."""
MOST_OTHERS = 6
"""Other problems of a case that a message names."""
MOST_NAMED = 3
"""Fields of other groups that a message names."""


def explain(error: ValidationError, source: CaseSource, model: type[BaseModel]) -> CaseError:
    """The first problem as a `CaseError` with its place in the file, and the number of others; fields of `model`."""
    problems = error.errors(include_url=False)
    # an unknown key often explains a missing one: say the unknown key first
    problems.sort(key=lambda problem: problem["type"] not in UNKNOWN)
    first = problems[0]
    path = _data_path(first["loc"], source.whole)
    if first["type"] == "union_tag_invalid":
        path += ("kind",)
    path += getattr(first.get("ctx", {}).get("error"), "path", ())  # of a `PlaceError`
    if first["type"] == "missing" and isinstance(first["loc"][-1], int):
        path = path[:-1]  # of the vector that lacks it
    more = f" ({len(problems) - 1} more after this one{_others(problems, source)})" if len(problems) > 1 else ""
    return CaseError(f"{source.place(path)}: {_sentence(first, path, model)}{more}")


def _others(problems: Sequence[ErrorDetails], source: CaseSource) -> str:
    """Places of the other problems, as far as they are few."""
    paths = dict.fromkeys(dotted_path(_data_path(problem["loc"], source.whole)) for problem in problems[1:])
    return f": {', '.join(paths)}" if all(paths) and len(paths) <= MOST_OTHERS else ""


def _data_path(location: tuple[Any, ...], data: Any) -> PathKey:
    """Pydantic's location without the tags of discriminated unions, some of which begin with <, and of branches."""
    path: list[str | int] = []
    here = data
    for position, part in enumerate(location):
        last = position == len(location) - 1
        if isinstance(here, dict) and (part in here or (last and part != here.get("kind") and str(part)[:1] != "<")):
            path.append(part)
            here = here.get(part)
        elif isinstance(here, list) and isinstance(part, int):
            path.append(part)
            here = here[part] if part < len(here) else None
    return tuple(path)


def _sentence(problem: ErrorDetails, path: PathKey, model: type[BaseModel]) -> str:
    kind, context, value = problem["type"], problem.get("ctx", {}), problem.get("input")
    if vector := _vector(problem, path, model):
        return vector
    if kind in UNKNOWN:
        if blank := odd_blank(str(path[-1])):
            return f"unknown field, with {blank} in its name; write blanks alone"
        if value is None and re.fullmatch(r"[0-9]+\D*", str(path[-1])):
            return "unknown field; a decimal comma ends a number in braces: decimals have a point, such as 0.2"
        return f"unknown field; {_meant(path, _models_at(problem['loc'][:-1], model), model)}"
    if kind == "missing":
        fields = fields_at(model, problem["loc"])
        words = [repr(word) for field in fields for word in get_args(field.annotation) if isinstance(word, str)]
        known = f"allowed is {', '.join(words)}" if words else "`lammps-jump new hydraulic_jump` shows a whole case"
        said = f" ({said})" if (said := briefly(fields)) else ""
        return f"is required and not there{said}; {known}"
    if kind.startswith(("greater_than", "less_than")):
        broken = " and ".join(f"{SIGNS[key]} {context[key]}" for key in SIGNS if key in context)
        return f"{echoed(value)} is out of range; allowed is {range_of(fields_at(model, problem['loc'])) or broken}"
    if kind == "literal_error":
        return f"{echoed(value)} is not known; allowed is {context['expected']}"
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _kind(context.get("tag"), value, [kind_of(item) or "" for item in _models_at(problem["loc"], model)])
    if kind == "value_error":
        return str(context["error"])
    if kind == "string_pattern_mismatch":
        return f"{echoed(value)} is not a usable name; allowed: {briefly(fields_at(model, problem['loc']))}"
    if kind in ("tuple_type", "list_type") and isinstance(value, str | int | float):
        return f"{echoed(value)} is a single value; this field is a list: [{shortened(str(value))}]"
    if kind in ("tuple_type", "list_type", "too_long", "too_short", "missing_argument"):
        written = "point is written [x, y]" if "points" in path else "pair is written [low, high]"
        return f"{echoed(value)} does not fit: {problem['msg'].lower()}; a {written}, a list with dashes"
    if kind in ("model_type", "model_attributes_type", "dataclass_type", "dict_type"):
        if blank := odd_blank(value) if isinstance(value, str) else "":
            return f"{echoed(value)} has {blank}, which YAML takes for a letter of a text; write blanks alone"
        return f"{echoed(value)} is a single value; this field is a group of fields (`lammps-jump new` shows one)"
    return f"{echoed(value)} does not fit: {problem['msg'][0].lower()}{problem['msg'][1:]}"


NUMBER_WORDS = {2: "two", 3: "three", 4: "four"}


def _vector(problem: ErrorDetails, path: PathKey, model: type[BaseModel]) -> str:
    """Lack or surplus of a vector, an interval or a row of numbers; empty where the problem is another."""
    kind, location, value = problem["type"], problem["loc"], problem.get("input")
    if kind == "missing" and isinstance(location[-1], int):
        location = location[:-1]
    elif kind not in ("tuple_type", "list_type", "too_long", "too_short"):
        return ""
    if not (vector := vector_in(fields_at(model, location))):
        return ""
    given = list(value) if isinstance(value, list | tuple) else [value]
    words = NUMBER_WORDS.get(vector.length, str(vector.length))
    example = shortened(", ".join(_example(given, vector)))
    point = " [x, y]" if "points" in path and vector.length == 2 else ""
    needs = f"needs {words} numbers{point}, for example [{example}]"
    if value is None:
        return f"is empty; {needs}"
    if len(given) > vector.length:
        return f"{echoed(value)} has {len(given)} values; {needs} (decimals have a point: 0.5)"
    return f"{echoed(value)} does not fit: {needs}"


def _example(given: list[Any], vector: Vector) -> list[str]:
    """Numbers of a vector, those that were given among them."""
    texts = [f"{one:zg}" for one in given if isinstance(one, int | float) and not isinstance(one, bool)]
    if not texts and given and isinstance(given[0], str):  # 8 m/s, or 8, 0
        parts = given if is_quantity(given[0]) else re.split(r"[\s,;]+", given[0].strip("[]() "))
        texts = [one for one in parts if isinstance(one, str) and is_quantity(one)]
    if vector.rises and len(texts) == 1 and re.match(r"[0-9.]*[1-9]", texts[0]):
        return ["0", *texts]
    last = "1" if vector.rises and texts == ["0"] else "0"
    return [*(texts or ["1"]), *[last] * vector.length][: vector.length]


def _meant(path: PathKey, models: list[type], whole: type[BaseModel]) -> str:
    """Fields that an unknown key may mean: of its group by meaning or spelling, or one of another group."""
    word, known = str(path[-1]), list(_fields(models))
    own = (getattr(item, "NO_FIELDS", {}).get(word) for item in models)
    if hint := next(filter(None, own), None):
        return hint
    group = ".".join(part for part in path[:-1] if isinstance(part, str))
    named = fields_by_name(whole) if whole is CaseFields else {}
    found = [one.told(briefly(named[one.path])) for one in field_words.meanings(word) if named]
    here = [one for one in found if one.group == group and one.name in known]
    if here or difflib.get_close_matches(word, known, n=1, cutoff=CLOSE):
        return f"write {here[0]}" if here else nearest(word, known)
    away = {one.path: str(one) for one in found if one.group != group and len(one.name) > 1}  # x and y: of what?
    elsewhere = [other for other in named if other.rpartition(".")[2] == word and other.rpartition(".")[0] != group]
    away |= {other: other for other in elsewhere if other not in away}
    if not away:
        return nearest(word, known)
    texts = list(away.values()) if len(away) == 1 else list(away)[:MOST_NAMED]
    return f"perhaps {' or '.join(texts)} is meant"


def _kind(tag: object, value: object, known: list[str]) -> str:
    """A group whose kind is missing or not known: the kinds, and the one that is meant."""
    allowed = ", ".join(f"'{one}'" for one in known)
    if tag is None:
        typed = " ('type' is called kind here)" if isinstance(value, dict) and "type" in value else ""
        return f"kind is missing{typed}; allowed is {allowed}"
    meant = [one for one in field_words.kinds(str(tag)) if one in known]
    meant = meant or difflib.get_close_matches(str(tag), known, n=1)
    hint = f"; did you mean '{meant[0]}'?" if meant else ""
    return f"{echoed(tag)} is not known; allowed is {allowed}{hint}"


def _models_at(location: tuple[Any, ...], model: type) -> list[type]:
    """The models that may stand at pydantic's location, from `model` on."""
    return [found for field in fields_at(model, location) for found in models_in(field.annotation)]


def _fields(models: list[type]) -> dict[str, FieldInfo]:
    return {name: field for item in models for name, field in fields_of(item).items()}


def slopes_of_angles(data: Any) -> tuple[str, ...]:
    """Sentences on the numbers of a case's data that are tangents of angles, one each, in the order of the data."""
    found = []
    for path, text in _texts(data, ()):
        if (angle := angle_of(text)) is None:  # most texts are none, and looking for their fields takes long
            continue
        fields = fields_at(CaseFields, path)
        if any(isinstance(note, InUnit) and note.slope for field in fields for note in notes_of(field)):
            found.append(f"{_named(data, path)}: {tangent(angle):z.3g}, the tangent of {echoed(text)}")
    return tuple(found)


def _texts(data: Any, path: PathKey) -> Iterator[tuple[PathKey, str]]:
    """Texts in plain data, with their paths."""
    if isinstance(data, str):
        yield path, data
    elif isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _texts(value, (*path, key))


def _named(data: Any, path: PathKey) -> str:
    """A path as ``--set`` takes it, items of lists by their names where they have one: ``walls.bed.friction``."""
    parts: list[str] = []
    for part in path:
        data = data[part]
        own = data.get("name") if isinstance(data, dict) and isinstance(part, int) else None
        parts.append(str(part if own is None else own))
    return dotted_path(tuple(parts))
