"""From a file and ``--set`` texts to a validated `Case`; every complaint names file, line, field and remedy."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_args, get_type_hints

import yaml
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from lammps_jump.errors import CaseError

from .fields import Case, InflowField, InitialField, WallField
from .text import CaseSource, PathKey, nearest, override, parse_source, read_source


@dataclass(frozen=True)
class LoadedCase:
    """A validated case and the text it came from (for later errors that concern the scene)."""

    case: Case
    source: CaseSource


def load_case(path: str | Path, assignments: Iterable[str] = ()) -> LoadedCase:
    """Read, change by ``--set`` and validate a case.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, the value, what is allowed and what to do.
    """
    return _validated(read_source(path), assignments, Path(path).stem)


def parse_case(text: str, file: str = "<case>", assignments: Iterable[str] = ()) -> LoadedCase:
    """As `load_case`, from text."""
    return _validated(parse_source(text, file), assignments, Path(file).stem)


def resolved_yaml(case: Case) -> str:
    """The case with every default filled in, as YAML text in the order of the fields."""
    return yaml.safe_dump(_plain_data(case), sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


def case_hash(case: Case) -> str:
    """Twelve hex digits that are equal for cases that must give the same run (name and analysis left out)."""
    data = _plain_data(case)
    for key in ("name", "description", "analysis"):
        data.pop(key, None)
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:12]


def _plain_data(case: Case) -> dict[str, Any]:
    """Plain data without the empty optional fields, which would only be noise for a reader."""

    def prune(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: prune(item) for key, item in value.items() if item is not None}
        if isinstance(value, list | tuple):
            return [prune(item) for item in value]
        return value

    return prune(case.model_dump(mode="json"))


def _validated(source: CaseSource, assignments: Iterable[str], default_name: str) -> LoadedCase:
    for assignment in assignments:
        override(source, assignment)
    data = dict(source.data)
    if "name" not in data:
        cleaned = "".join(letter if letter.isalnum() or letter in "_.-" else "_" for letter in default_name).lstrip(
            "_.-"
        )
        data["name"] = cleaned or "case"
    try:
        case = Case.model_validate(data)
    except ValidationError as error:
        raise _explain(error, source) from None
    names = [wall.name for wall in case.walls]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise source.error(("walls", index, "name"), f"two walls are called '{name}'; give each its own name")
    if not case.initial and case.inflow is None:
        raise source.error((), "there are no discs: give initial (a column, lattice or list) or inflow")
    return LoadedCase(case, source)


UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
"""What pydantic calls a key that a model or a dataclass does not have."""


def _explain(error: ValidationError, source: CaseSource) -> CaseError:
    problems = error.errors(include_url=False)
    # an unknown key often explains a missing one: say the unknown key first
    problems.sort(key=lambda problem: problem["type"] not in UNKNOWN)
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
    if kind in UNKNOWN:
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
    if kind in ("model_type", "dataclass_type", "dict_type"):
        return f"{value!r} is a single value; this field is a group of fields (`lammps-jump new` shows one)"
    return f"{value!r} does not fit: {problem['msg'][0].lower()}{problem['msg'][1:]}"


def _tags(path: PathKey) -> str:
    field = {"walls": WallField, "initial": InitialField, "inflow": InflowField}.get(str(path[0]))
    members = get_args(get_args(field)[0]) if field else ()
    return ", ".join(f"'{_tag(member)}'" for member in members)


def fields_of(model: type) -> dict[str, FieldInfo]:
    """Fields of a pydantic model or of a dataclass, by name."""
    if issubclass(model, BaseModel):
        return model.model_fields
    hints = get_type_hints(model, include_extras=True)
    return {item.name: FieldInfo.from_annotation(hints[item.name]) for item in fields(model)}


def _tag(model: type) -> str:
    return get_args(fields_of(model)["kind"].annotation)[0]


def _model_at(location: tuple) -> type:
    """The model that owns the last part of pydantic's location."""
    model: type = Case
    for part in location[:-1]:
        if isinstance(part, int):
            continue
        if part in fields_of(model):
            model = _submodel(fields_of(model)[part]) or model
        else:
            model = _tagged(part) or model
    return model


def _tagged(tag: str) -> type | None:
    unions = (WallField, InitialField, InflowField)
    return next((member for field in unions for member in get_args(get_args(field)[0]) if _tag(member) == tag), None)


def _submodel(field: FieldInfo) -> type[BaseModel] | None:
    stack = [field.annotation]
    while stack:
        annotation = stack.pop()
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return annotation
        stack.extend(get_args(annotation))
    return None


def _known_fields(location: tuple) -> list[str]:
    return list(fields_of(_model_at(location)))


def _limits(location: tuple) -> str:
    field = fields_of(_model_at(location)).get(location[-1])
    if field is None:
        return ""
    signs = {"Gt": ("gt", ">"), "Ge": ("ge", ">="), "Lt": ("lt", "<"), "Le": ("le", "<=")}
    parts = []
    for item in field.metadata:
        if type(item).__name__ in signs:
            attribute, sign = signs[type(item).__name__]
            parts.append(f"{sign} {getattr(item, attribute):g}")
    return " and ".join(parts)
