# SPDX-License-Identifier: GPL-2.0-or-later
"""Entries put into the text of a case; all else in it stays, comments too."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import yaml

import lammps_jump.case as cases
from lammps_jump.case.text import read_text
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import change_text, real_path, writes

from .entries import Entry, yaml_text

DASH = re.compile("^( *)-", re.MULTILINE)
"""The beginning of an item, and what stands before it."""
MOST_TRIES = 5
"""How often walls are added anew to a case that another program has changed meanwhile."""


def write_into(path: Path, found: Sequence[Entry]) -> None:
    """Add walls to a case file, whole or not at all; see `change_text`. Of a link, to the file that it leads to.

    What another program writes into the file meanwhile stays.

    Raises
    ------
    CaseError
        A file that is no case, walls that stand in brackets, a name that is taken, a case that is refused with them.
    DumpError
        The file cannot be written, or another program changes it all the time.
    """
    place = real_path(path)
    for _ in range(MOST_TRIES):
        before = read_text(place)
        cases.parse_case(before, str(path), folder=path.parent)
        text = with_walls(before, found, str(path))
        cases.parse_case(text, str(path), folder=path.parent)
        with writes(path, remedy="correct the permissions of file and folder"):
            if change_text(place, before, text) is not None:
                return
    raise DumpError(f"{path}: another program changes it all the time; nothing was added, import again once that ends")


def with_walls(text: str, found: Sequence[Entry], file: str = "<case>") -> str:
    """The text of a case with further walls behind those that it has.

    Raises
    ------
    CaseError
        Walls or all fields in brackets, or a name that is taken.
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
        if key.value != "walls":
            continue
        if isinstance(value, yaml.SequenceNode) and value.flow_style and value.value:
            raise CaseError(
                f"{file}:{value.start_mark.line + 1}: walls: stand in brackets; write them one below the other, each "
                "behind a dash, and import again"
            )
        if not value.value:  # walls: [], or nothing; comments in it and behind it stay
            whole, start, end = "".join(rows), value.start_mark.index, value.end_mark.index
            line, stop, rest = whole[end:].partition("\n")
            inside = whole[start + 1 : end - 1]
            return "".join([whole[:start].rstrip(" "), inside.rstrip(" "), line, stop, yaml_text(found), rest])
        taken = {name.value for item in value.value for word, name in item.value if word.value == "name"}
        for entry in found:
            if entry.wall["name"] in taken:
                raise CaseError(
                    f"{file}: there is a wall '{entry.wall['name']}' already; delete it there, or give another name by "
                    f"--layer '{entry.layer}'=NAME"
                )
        after = _last_line(value) + 1
        dash = DASH.search(text, value.start_mark.index - value.start_mark.column)  # an anchor may stand before it
        rows.insert(after, yaml_text(found, dash[1] if dash else ""))
        return "".join(rows)
    rows.insert(tree.end_mark.line if tree.end_mark.column == 0 else len(rows), f"walls:\n{yaml_text(found)}")
    return "".join(rows)


def _last_line(node: yaml.Node) -> int:
    """Line, from 0, on which the last value of a node ends; comments behind it do not count."""
    if isinstance(node, yaml.MappingNode | yaml.SequenceNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _last_line(last[1] if isinstance(last, tuple) else last)
    end = node.end_mark
    return end.line - 1 if end.column == 0 and end.line > node.start_mark.line else end.line
