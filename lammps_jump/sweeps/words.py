# SPDX-License-Identifier: GPL-2.0-or-later
"""Words and units of what a study varies, as the fields of a case tell them."""

from __future__ import annotations

from lammps_jump.case.field_words import fields_at, label_of, unit_of
from lammps_jump.case.fields import CaseFields
from lammps_jump.units import POWERS

NAMED = {"walls": "wall", "bodies": "body"}
"""Lists whose items have names, and what an item without one is called."""


def words(path: str) -> str:
    """Label of a field, in a few words; the path where it has none."""
    group, _, rest = path.partition(".")
    label = label_of(fields_at(CaseFields, path.split(".")))
    if not label:
        return path
    if group not in NAMED:
        return path if path[-1].isdigit() else label  # the end of what?
    name = rest.partition(".")[0]
    return f"{label} of the {f'{NAMED[group]} {name}' if name.isdigit() else name.replace('_', ' ')}"


def unit(path: str) -> str:
    """Its SI unit, empty where there is none."""
    return unit_of(fields_at(CaseFields, path.split("."))).replace("degree", "°")


def heading(path: str) -> str:
    """Words and unit, for a table or an axis."""
    return f"{words(path)} [{unit(path).translate(POWERS)}]" if unit(path) else words(path)
