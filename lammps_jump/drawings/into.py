# SPDX-License-Identifier: GPL-2.0-or-later
"""Entries put into the text of a case; all else in it stays, comments too."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from math import hypot
from pathlib import Path
from typing import Any

import yaml

import lammps_jump.case as cases
from lammps_jump.case.text import read_text
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import change_text, real_path, writes
from lammps_jump.units import Point

from .entries import Entry, flow, yaml_text

DASH = re.compile("^( *)-", re.MULTILINE)
"""The beginning of an item, and what comes before it."""
DRAWN = {
    "wall line": ("walls", "line"),
    "wall block": ("walls", "block"),
    "wall circle": ("walls", "circle"),
    "body block": ("bodies", "block"),
    "body circle": ("bodies", "circle"),
    "column": ("initial", "column"),
}
"""List of the case, and kind, of what can be drawn in its picture."""
MOST_TRIES = 5
"""Times that walls are added anew, at most, to a case that another program has changed meanwhile."""


def write_into(path: Path, entries: Sequence[Entry]) -> None:
    """Add walls to a case file, whole or not at all; see `change_text`. Of a link, to the file that it leads to.

    What another program writes into the file meanwhile stays.

    Raises
    ------
    CaseError
        A file that is no case, walls that are in brackets, a name that is taken, a case that is refused with them.
    DumpError
        The file cannot be written, or another program changes it all the time.
    """
    place = real_path(path)
    for _ in range(MOST_TRIES):
        before = read_text(place)
        cases.parse_case(before, str(path), folder=path.parent)
        text = with_walls(before, entries, str(path))
        cases.parse_case(text, str(path), folder=path.parent)
        with writes(path, remedy="correct the permissions of file and folder"):
            if change_text(place, before, text) is not None:
                return
    raise DumpError(f"{path}: another program changes it all the time; nothing was added, import again once that ends")


def with_walls(text: str, entries: Sequence[Entry], file: str = "<case>") -> str:
    """The text of a case with further walls after those that it has.

    Raises
    ------
    CaseError
        Walls or all fields in brackets, or a name that is taken.
    """
    taken = names_in(text)
    for entry in entries:
        if entry.wall["name"] in taken:
            raise CaseError(
                f"{file}: there is a wall '{entry.wall['name']}' already; delete it there, or give another name by "
                f"--layer '{entry.layer}'=NAME"
            )
    return with_items(text, "walls", partial(yaml_text, entries), file)


def with_drawn(text: str, what: str, points: Sequence[Point], density: float, file: str = "<case>") -> str:
    """The text of a case with a shape that was drawn in its picture.

    Parameters
    ----------
    text : str
    what : str
        One of `DRAWN`.
    points : sequence of (float, float)
        Two: ends of a line, corners of a rectangle, centre and rim of a circle, m.
    density : float
        Of a body, kg/m^3.
    file : str

    Raises
    ------
    CaseError
        A shape without width or height, or a list that is in brackets.
    """
    part, kind = DRAWN[what]
    item = _shape(kind, points, file)
    if part != "initial":
        stem, taken = what.split()[0], names_in(text)
        free = next(name for name in (f"{stem}_{number}" for number in count(1)) if name not in taken)
        item = {"name": free, **item, **({"density": density} if part == "bodies" else {})}
    row = f"- {flow(item)}\n"
    return with_items(text, part, lambda indent="  ": f"{indent}{row}", file)


def _shape(kind: str, points: Sequence[Point], file: str) -> dict[str, Any]:
    """Fields of a shape between two points."""
    (x0, y0), (x1, y1) = points
    if kind == "circle":
        fields: dict[str, Any] = {"centre": [x0, y0], "radius": float(f"{hypot(x1 - x0, y1 - y0):.4g}")}
        empty = not fields["radius"]
    elif kind == "line":
        fields, empty = {"points": [[x0, y0], [x1, y1]], "sheet": True}, (x0, y0) == (x1, y1)
    else:
        fields, empty = {"x": sorted([x0, x1]), "y": sorted([y0, y1])}, x0 == x1 or y0 == y1
    if empty:
        raise CaseError(f"{file}: the {kind} has no size; draw it from one place to another")
    return {"kind": kind, **fields, **({"gate": False} if kind == "column" else {})}


def names_in(text: str) -> set[str]:
    """Names of walls and bodies that the text of a case has."""
    tree = yaml.compose(text, Loader=yaml.SafeLoader)
    assert isinstance(tree, yaml.MappingNode)  # a case that was read
    lists = [value.value for key, value in tree.value if key.value in ("walls", "bodies") and value.value]
    items = [item.value for node in lists for item in node if isinstance(item, yaml.MappingNode)]
    return {name.value for item in items for word, name in item if word.value == "name"}


def with_items(text: str, part: str, rows_of: Callable[..., str], file: str) -> str:
    """The text of a case with further items after those that a list of it has; all else in it stays.

    Parameters
    ----------
    text : str
    part : str
        Name of the list, ``walls``.
    rows_of : callable
        The new rows, for what comes before a dash.
    file : str

    Raises
    ------
    CaseError
        The list or all fields are in brackets.
    """
    tree = yaml.compose(text, Loader=yaml.SafeLoader)
    rows = text.splitlines(keepends=True)
    if rows and not rows[-1].endswith("\n"):
        rows[-1] += "\n"
    assert isinstance(tree, yaml.MappingNode)  # a case that was read
    if tree.flow_style:
        raise CaseError(
            f"{file}:{tree.start_mark.line + 1}: the fields stand in braces; write them one below the other, and "
            "import again"
        )
    for key, value in tree.value:
        if key.value != part:
            continue
        if isinstance(value, yaml.SequenceNode) and value.flow_style and value.value:
            raise CaseError(
                f"{file}:{value.start_mark.line + 1}: {part}: stand in brackets; write them one below the other, each "
                "behind a dash, and import again"
            )
        if not value.value:  # walls: [], or nothing; comments in it and after it stay
            whole, start, end = "".join(rows), value.start_mark.index, value.end_mark.index
            line, stop, rest = whole[end:].partition("\n")
            inside = whole[start + 1 : end - 1]
            return "".join([whole[:start].rstrip(" "), inside.rstrip(" "), line, stop, rows_of(), rest])
        after = _last_line(value) + 1
        dash = DASH.search(text, value.start_mark.index - value.start_mark.column)  # an anchor may precede it
        rows.insert(after, rows_of(dash[1] if dash else ""))
        return "".join(rows)
    rows.insert(tree.end_mark.line if tree.end_mark.column == 0 else len(rows), f"{part}:\n{rows_of()}")
    return "".join(rows)


def _last_line(node: yaml.Node) -> int:
    """Line, from 0, on which the last value of a node ends; comments after it do not count."""
    if isinstance(node, yaml.MappingNode | yaml.SequenceNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _last_line(last[1] if isinstance(last, tuple) else last)
    end = node.end_mark
    return end.line - 1 if end.column == 0 and end.line > node.start_mark.line else end.line
