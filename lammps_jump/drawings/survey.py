# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of a survey: chainage and level, one line."""

from __future__ import annotations

import re
from pathlib import Path

from lammps_jump.errors import CaseError
from lammps_jump.quoting import echoed
from lammps_jump.units import to_si

from .strokes import GatheredStrokes, LayeredDrawing

COLUMNS = {
    "chainage": ("chainage", "station", "distance", "x"),
    "level": ("level", "elevation", "height", "z", "y"),
}
"""Words of the head of a table, for each of its two columns."""
HEAD = re.compile(r"\s*([A-Za-z]+)[\s_]*[\[(]?\s*([A-Za-z]*)\s*[\])]?\s*")
"""A word, and perhaps a unit in brackets or behind a line: chainage (m), level [ft], x_mm."""


def read_survey(data: bytes, file: str) -> LayeredDrawing:
    """A table of chainage and level, by comma, semicolon, tab or blanks.

    Raises
    ------
    CaseError
        No such columns, two units, cells that are no numbers; with the line.
    """
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise CaseError(f"{file}: is not text (byte {error.start} is not UTF-8); a survey is a CSV file") from None
    rows = [(number, _cells(line)) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not rows:
        raise CaseError(f"{file}: is empty; a survey has a head such as `chainage (m),level (m)`, and rows of numbers")
    head_line, head = rows[0]
    order, unit = _columns(head, f"{file}:{head_line}")
    points: list[tuple[float, float]] = []
    for number, cells in rows[1:]:
        try:
            x, y = (float(to_si(cells[index], "")) for index in order)
        except (ValueError, IndexError):
            raise CaseError(
                f"{file}:{number}: {echoed(','.join(cells))} has no two numbers under {head[order[0]]} and "
                f"{head[order[1]]}; mend the row, or take it out"
            ) from None
        if not points or (x, y) != points[-1]:
            points.append((x, y))
    if len(points) < 2:
        raise CaseError(f"{file}: {len(points)} row of numbers; a line needs two different ones or more")
    found = GatheredStrokes()
    found.stroke(Path(file).stem, points)
    return LayeredDrawing(file, unit[1], unit[0], found.layers())


def _cells(line: str) -> list[str]:
    """Cells of a row."""
    for sign in (";", "\t", ","):
        if sign in line:
            return [cell.strip() for cell in line.split(sign)]
    return line.split()


def _columns(head: list[str], place: str) -> tuple[list[int], tuple[str, float | None]]:
    """Columns of chainage and level, and the unit: what tells it, and in metres."""
    words = [HEAD.fullmatch(cell) for cell in head]
    order: list[int] = []
    for wanted, known in COLUMNS.items():
        found = [i for i, word in enumerate(words) if word and word[1].lower() in known]
        if len(found) != 1:
            raise CaseError(
                f"{place}: columns {echoed(', '.join(head))}: {len(found)} of them are a {wanted} "
                f"({', '.join(known)}); expected is one of each, such as `chainage (m),level (m)`"
            )
        order += found
    names = [word[2] if (word := words[i]) else "" for i in order]
    if names[0] != names[1]:
        raise CaseError(
            f"{place}: chainage is in {names[0] or 'no unit'} and level in {names[1] or 'no unit'}; give both one unit"
        )
    if not names[0]:
        return order, ("the head of the table has no unit", None)
    try:
        return order, (f"the head of the table says {names[0]}", float(to_si(f"1 {names[0]}", "m")))
    except ValueError as error:
        raise CaseError(f"{place}: {error}") from None
