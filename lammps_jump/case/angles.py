# SPDX-License-Identifier: GPL-2.0-or-later
"""Coefficients that a case gives as angles, such as ``friction: 22 deg``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lammps_jump.quoting import echoed
from lammps_jump.units import InUnit
from lammps_jump.written import angle_of, tangent

from .field_words import fields_at, notes_of
from .fields import CaseFields
from .text import PathKey, dotted_path


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
