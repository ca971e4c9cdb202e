"""A case: read from a file, text or mapping, changed and validated; every complaint names its place and the remedy."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import yaml
from pydantic import BaseModel, ValidationError

import lammps_jump
from lammps_jump.errors import CaseError
from lammps_jump.files import plain
from lammps_jump.provenance import short_hash
from lammps_jump.scene.scene import Scene

from . import derived, to_scene, view
from .fields import CaseFields, InflowField, InitialField, WallField
from .text import CaseSource, PathKey, nearest, override, parse_source, read_source

if TYPE_CHECKING:
    from lammps_jump.runs.run import Run

Changes = Mapping[str, object] | Iterable[str]
"""Values by path, ``{"walls.sill.y": [-10, 3]}``, or texts ``path=value`` as of ``--set``."""


@dataclass(frozen=True)
class Case:
    """A validated case.

    Attributes
    ----------
    fields : CaseFields
        The values, every default filled in; frozen.
    source : CaseSource
        Where each value stands, for messages.
    """

    fields: CaseFields
    source: CaseSource = field(repr=False, compare=False)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.fields.name

    @cached_property
    def hash(self) -> str:
        """Twelve hex digits, equal for cases that give the same run: name, description and analysis are left out."""
        data = _plain_data(self.fields)
        return short_hash({key: data[key] for key in data if key not in ("name", "description", "analysis")})

    def replace(self, changes: Changes) -> Case:
        """The case with other values, validated as a file is.

        Parameters
        ----------
        changes : mapping or iterable of str
            Values by path, ``{"contact.friction": 0.1, "walls.sill.y": [-10, 3]}``: list items by name or index.
            Numbers are SI, texts may carry a unit (``"20 cm"``). Or texts ``path=value``, as of ``--set``.

        Raises
        ------
        CaseError
            A path that is not there, or a value that is not allowed.
        """
        source = self.source
        copied = replace(
            source,
            data=copy.deepcopy(source.data) | {"name": self.name},
            lines=dict(source.lines),
            overrides=dict(source.overrides),
        )
        return _validated(copied, changes, self.name)

    def scene(self) -> Scene:
        """The engine-neutral numbers of the case, SI.

        Raises
        ------
        CaseError
            A scene that cannot be run: an unstable step, discs inside walls, a domain too large.
        """
        return self._scene

    @cached_property
    def _scene(self) -> Scene:
        return to_scene.build_scene(self)

    def check(self) -> derived.Derived:
        """Everything derived from the case: coefficients, theory of the inflow, what is skipped, warnings.

        Raises
        ------
        CaseError
            As `scene`.
        """
        return derived.Derived(self.fields, self.scene())

    def run(self, folder: str | Path | None = None, **options: Any) -> Run:
        """Run the case in a folder; `lammps_jump.run` lists the options. A stored result returns at once."""
        return lammps_jump.run(self, folder, **options)

    def to_yaml(self) -> str:
        """The case as YAML text, every default filled in, in the order of the fields."""
        data = _plain_data(self.fields)
        return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)

    def _repr_html_(self) -> str:
        return view.case_html(self.name, self.scene())


def load_case(source: str | Path | Mapping[str, object], changes: Changes | None = None) -> Case:
    """Read, change and validate a case.

    Parameters
    ----------
    source : str, Path or mapping
        A YAML file, a run folder (its ``case.yaml``), or the fields themselves.
    changes : mapping or iterable of str, optional
        See `Case.replace`.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, the value, what is allowed and what to do.
    """
    if isinstance(source, Mapping):
        return _validated(CaseSource(file="<case>", data=json.loads(_json(dict(source)))), changes or (), "case")
    path = Path(source)
    if (path / "case.yaml").is_file():
        path /= "case.yaml"
    return _validated(read_source(path), changes or (), path.stem)


def parse_case(text: str, file: str = "<case>", changes: Changes = ()) -> Case:
    """As `load_case`, from YAML text; `file` is its name in messages."""
    return _validated(parse_source(text, file), changes, Path(file).stem)


def _json(value: object) -> str:
    try:
        return json.dumps(plain(value))
    except (TypeError, ValueError):
        raise CaseError(f"{value!r} is no value of a case; numbers, texts, lists and mappings are allowed") from None


def _plain_data(fields: CaseFields) -> dict[str, Any]:
    """Plain data without the empty optional fields, which would only be noise for a reader."""

    def prune(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: prune(item) for key, item in value.items() if item is not None}
        if isinstance(value, list | tuple):
            return [prune(item) for item in value]
        return value

    return prune(fields.model_dump(mode="json"))


def _validated(source: CaseSource, changes: Changes, default_name: str) -> Case:
    if isinstance(changes, Mapping):
        changes = [f"{path}={_json(value)}" for path, value in changes.items()]
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
    return Case(fields, source)


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
