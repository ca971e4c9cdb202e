# SPDX-License-Identifier: GPL-2.0-or-later
"""Pydantic's errors in sentences: the place in the file, what is wrong, what is allowed, what to do."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, get_args, get_type_hints

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from lammps_jump.errors import CaseError

from .fields import CaseFields, InflowField, InitialField, SizesField, WallField
from .text import CaseSource, PathKey, nearest

UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
"""What pydantic calls a key that a model or a dataclass does not have."""


UNIONS = {"walls": WallField, "initial": InitialField, "inflow": InflowField, "sizes": SizesField}
"""Fields whose ``kind`` tells which other fields they have."""
SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
"""Bounds as pydantic calls them."""


def explain(error: ValidationError, source: CaseSource, model: type[BaseModel] = CaseFields) -> CaseError:
    """The first problem as a `CaseError` with its place in the file, and the number of others; fields of `model`."""
    problems = error.errors(include_url=False)
    # an unknown key often explains a missing one: say the unknown key first
    problems.sort(key=lambda problem: problem["type"] not in UNKNOWN)
    first = problems[0]
    path = _data_path(first["loc"], source.data)
    more = f" ({len(problems) - 1} more after this one)" if len(problems) > 1 else ""
    return CaseError(f"{source.place(path)}: {_sentence(first, path, model)}{more}")


def _data_path(location: tuple, data: Any) -> PathKey:
    """Pydantic's location without the tags of discriminated unions and the branches of unions."""
    path: list[str | int] = []
    here = data
    for position, part in enumerate(location):
        last = position == len(location) - 1
        if isinstance(here, dict) and (part in here or (last and part != here.get("kind"))):
            path.append(part)
            here = here.get(part)
        elif isinstance(here, list) and isinstance(part, int):
            path.append(part)
            here = here[part] if part < len(here) else None
    return tuple(path)


def _sentence(problem: dict, path: PathKey, model: type[BaseModel]) -> str:
    kind, context, value = problem["type"], problem.get("ctx", {}), problem.get("input")
    if kind in UNKNOWN:
        return f"unknown field; {nearest(str(path[-1]), _known_fields(problem['loc'], model))}"
    if kind == "missing":
        return "is required and not there; `lammps-jump new hydraulic_jump` shows a whole case"
    if kind.startswith(("greater_than", "less_than")):
        broken = " and ".join(f"{SIGNS[key]} {context[key]}" for key in SIGNS if key in context)
        return f"{value!r} is out of range; allowed is {_limits(problem['loc'], model) or broken}"
    if kind == "literal_error":
        return f"{value!r} is not known; allowed is {context['expected']}"
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        tags = context.get("expected_tags") or _tags(path)
        return f"kind: {context.get('tag', 'missing')} is not known; allowed is {tags}"
    if kind == "value_error":
        return str(context["error"])
    if kind == "string_pattern_mismatch":
        letters = "letters, digits and _" if path[0] == "walls" else "letters, digits, _ . and -"
        return f"{value!r} is not a usable name; {letters} are allowed"
    if kind in ("tuple_type", "list_type", "too_long", "too_short", "missing_argument"):
        return f"{value!r} does not fit: {problem['msg'].lower()}; a pair is written [low, high], a list with dashes"
    if kind in ("model_type", "model_attributes_type", "dataclass_type", "dict_type"):
        return f"{value!r} is a single value; this field is a group of fields (`lammps-jump new` shows one)"
    return f"{value!r} does not fit: {problem['msg'][0].lower()}{problem['msg'][1:]}"


def _tags(path: PathKey) -> str:
    union = next(UNIONS[part] for part in path if part in UNIONS)
    return ", ".join(f"'{_tag(member)}'" for member in _members(union))


def _members(union: object) -> tuple[type, ...]:
    return get_args(get_args(union)[0])


def fields_of(model: type) -> dict[str, FieldInfo]:
    """Fields of a pydantic model or of a dataclass, by name."""
    if issubclass(model, BaseModel):
        return model.model_fields
    hints = get_type_hints(model, include_extras=True)
    return {item.name: FieldInfo.from_annotation(hints[item.name]) for item in fields(model)}


def _tag(model: type) -> str:
    return get_args(fields_of(model)["kind"].annotation)[0]


def _model_at(location: tuple, model: type) -> type:
    """The model that owns the last part of pydantic's location, from `model` on."""
    union = None
    for part in location[:-1]:
        union = UNIONS.get(part, union)
        if isinstance(part, str):
            field = fields_of(model).get(part)
            model = (_submodel(field) if field else _tagged(part, union)) or model
    return model


def _tagged(tag: str, union: object) -> type | None:
    return next((member for member in _members(union) if _tag(member) == tag), None) if union else None


def _submodel(field: FieldInfo) -> type[BaseModel] | None:
    stack = [field.annotation]
    while stack:
        annotation = stack.pop()
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return annotation
        stack.extend(get_args(annotation))
    return None


def _known_fields(location: tuple, model: type) -> list[str]:
    return list(fields_of(_model_at(location, model)))


def _limits(location: tuple, model: type) -> str:
    field = fields_of(_model_at(location, model)).get(location[-1])
    if field is None:
        return ""
    bounds = ((sign, getattr(item, key, None)) for item in field.metadata for key, sign in SIGNS.items())
    return " and ".join(f"{sign} {bound:g}" for sign, bound in bounds if bound is not None)
