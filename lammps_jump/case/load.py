"""From the data of a case to its validated fields; every complaint names its place and the remedy."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from lammps_jump.errors import CaseError
from lammps_jump.files import plain

from .fields import CaseFields, InflowField, InitialField, WallField
from .text import CaseSource, PathKey, nearest, override

Changes = Mapping[str, object] | Iterable[str]
"""Values by path, ``{"walls.sill.y": [-10, 3]}``, or texts ``path=value`` as of ``--set``."""


@dataclass(frozen=True)
class PlacedFields:
    """The validated values of a case, and where each stands.

    Attributes
    ----------
    fields : CaseFields
        The values, every default filled in; frozen.
    source : CaseSource
        The places, for messages.
    """

    fields: CaseFields
    source: CaseSource = field(repr=False, compare=False)


def json_text(value: object) -> str:
    """A value as JSON, which is YAML too; CaseError where it is none of a case."""
    try:
        return json.dumps(plain(value))
    except (TypeError, ValueError):
        raise CaseError(f"{value!r} is no value of a case; numbers, texts, lists and mappings are allowed") from None


def validated(source: CaseSource, changes: Changes, default_name: str) -> CaseFields:
    """The fields of a case after its changes, which also stand in `source` then.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, the value, what is allowed and what to do.
    """
    if isinstance(changes, Mapping):
        changes = [f"{path}={json_text(value)}" for path, value in changes.items()]
    for assignment in changes:
        override(source, assignment)
    data = dict(source.data)
    if "name" not in data:
        cleaned = "".join(letter if letter.isalnum() or letter in "_.-" else "_" for letter in default_name).lstrip(
            "_.-"
        )
        data["name"] = cleaned or "case"
    try:
        fields = CaseFields.model_validate(data)
    except ValidationError as error:
        raise _explain(error, source) from None
    names = [wall.name for wall in fields.walls]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise source.error(("walls", index, "name"), f"two walls are called '{name}'; give each its own name")
    if not fields.initial and fields.inflow is None:
        raise source.error((), "there are no discs: give initial (a column, lattice or list) or inflow")
    return fields


def _explain(error: ValidationError, source: CaseSource) -> CaseError:
    problems = error.errors(include_url=False)
    # an unknown key often explains a missing one: say the unknown key first
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")
    first = problems[0]
    path = _data_path(first["loc"], source.data)
    more = f" ({len(problems) - 1} more after this one)" if len(problems) > 1 else ""
    return CaseError(f"{source.place(path)}: {_sentence(first, path)}{more}")


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


def _sentence(problem: dict, path: PathKey) -> str:
    kind, context, value = problem["type"], problem.get("ctx", {}), problem.get("input")
    bounds = {
        "greater_than": ("> {gt}", "gt"),
        "greater_than_equal": (">= {ge}", "ge"),
        "less_than": ("< {lt}", "lt"),
        "less_than_equal": ("<= {le}", "le"),
    }
    if kind == "extra_forbidden":
        return f"unknown field; {nearest(str(path[-1]), _known_fields(problem['loc']))}"
    if kind == "missing":
        return "is required and not there; `lammps-jump new hydraulic_jump` shows a whole case"
    if kind in bounds:
        text, key = bounds[kind]
        limits = _limits(problem["loc"])
        return f"{value!r} is out of range; allowed is {limits or text.format(**{key: context[key]})}"
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
    if kind in ("model_type", "dict_type"):
        return f"{value!r} is a single value; this field is a group of fields (`lammps-jump new` shows one)"
    return f"{value!r} does not fit: {problem['msg'][0].lower()}{problem['msg'][1:]}"


def _tags(path: PathKey) -> str:
    field = {"walls": WallField, "initial": InitialField, "inflow": InflowField}.get(str(path[0]))
    members = get_args(get_args(field)[0]) if field else ()
    return ", ".join(f"'{get_args(member.model_fields['kind'].annotation)[0]}'" for member in members)


def _model_at(location: tuple) -> type[BaseModel] | None:
    """The model that owns the last part of pydantic's location."""
    model: type[BaseModel] | None = CaseFields
    for part in location[:-1]:
        if model is None or isinstance(part, int):
            continue
        if part in model.model_fields:
            model = _submodel(model.model_fields[part], None) or model
        else:
            model = _tagged(part) or model
    return model


def _tagged(tag: str) -> type[BaseModel] | None:
    for kinds in (WallField, InitialField, InflowField):
        for member in get_args(get_args(kinds)[0]):
            if get_args(member.model_fields["kind"].annotation)[0] == tag:
                return member
    return None


def _submodel(field: Any, _: None) -> type[BaseModel] | None:
    stack = [field.annotation]
    while stack:
        annotation = stack.pop()
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return annotation
        stack.extend(get_args(annotation))
    return None


def _known_fields(location: tuple) -> list[str]:
    model = _model_at(location)
    return list(model.model_fields) if model else []


def _limits(location: tuple) -> str:
    model = _model_at(location)
    if model is None or location[-1] not in model.model_fields:
        return ""
    signs = {"Gt": ("gt", ">"), "Ge": ("ge", ">="), "Lt": ("lt", "<"), "Le": ("le", "<=")}
    parts = []
    for item in model.model_fields[location[-1]].metadata:
        if type(item).__name__ in signs:
            attribute, sign = signs[type(item).__name__]
            parts.append(f"{sign} {getattr(item, attribute):g}")
    return " and ".join(parts)
