# SPDX-License-Identifier: GPL-2.0-or-later
"""From the data of a case to its validated fields; every complaint names its place and the remedy."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from pydantic import ValidationError

from lammps_jump.errors import CaseError
from lammps_jump.files import plain
from lammps_jump.quoting import plain_name

from .explain import explain
from .fields import CaseFields
from .text import CaseSource, override

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
        data["name"] = plain_name(default_name)
    try:
        fields = CaseFields.model_validate(data)
    except ValidationError as error:
        raise explain(error, source) from None
    names = [wall.name for wall in fields.walls]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise source.error(("walls", index, "name"), f"two walls are called '{name}'; give each its own name")
    if not fields.initial and fields.inflow is None:
        raise source.error((), "there are no discs: give initial (a column, lattice or list) or inflow")
    return fields
