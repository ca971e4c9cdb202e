"""From a file and ``--set`` texts to a validated `Case`; every complaint names file, line, field and remedy."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from .explain import explain
from .fields import Case
from .text import CaseSource, override, parse_source, read_source


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
        raise explain(error, source) from None
    names = [wall.name for wall in case.walls]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise source.error(("walls", index, "name"), f"two walls are called '{name}'; give each its own name")
    if not case.initial and case.inflow is None:
        raise source.error((), "there are no discs: give initial (a column, lattice or list) or inflow")
    return LoadedCase(case, source)
