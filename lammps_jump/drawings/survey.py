# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of a survey: chainage and level, one line."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from contextlib import suppress
from math import isfinite
from pathlib import Path

from lammps_jump.errors import CaseError
from lammps_jump.foreign import foreign, number_of
from lammps_jump.quoting import echoed
from lammps_jump.units import to_si

from .strokes import GatheredStrokes, LayeredDrawing

COLUMNS = {
    "chainage": ("chainage", "station", "distance", "x"),
    "level": ("level", "elevation", "height", "z", "y"),
}
"""Words of the head of a table, for each of its two columns."""
MOST_LINES = 2_000_000
"""Lines of a table, empty ones among them."""
MOST_COLUMNS = 10_000
"""Cells of a row."""
LONGEST_HEAD = 60
"""Letters of the head of a column."""
HEAD = re.compile(r"\s*([A-Za-z]+)[\s_]*[\[(]?\s*([A-Za-z]*)\s*[\])]?\s*")
"""A word, and perhaps a unit in brackets or behind a line: chainage (m), level [ft], x_mm."""


def read_survey(data: bytes, file: str) -> LayeredDrawing:
    """A table of chainage and level, by comma, semicolon, tab or blanks.

    Raises
    ------
    CaseError
        No such columns, two units, cells that are no numbers; with the line.
    """
    rows = _rows(_lines(data, file), file)
    head_line, head = next(rows, (0, []))
    if not head:
        raise CaseError(f"{file}: is empty; a survey has a head such as `chainage (m),level (m)`, and rows of numbers")
    order, unit = _columns(head, f"{file}:{head_line}")
    points: list[tuple[float, float]] = []
    found = GatheredStrokes(file)
    for number, cells in rows:
        found.room(len(points))
        x, y = (_number(cells, index, head, f"{file}:{number}") for index in order)
        if not points or (x, y) != points[-1]:
            points.append((x, y))
    if len(points) < 2:
        raise CaseError(f"{file}: {len(points)} row of numbers; a line needs two different ones or more")
    found.stroke(Path(file).stem, points)
    return LayeredDrawing(file, unit[1], unit[0], found.layers())


def _lines(data: bytes, file: str) -> Iterator[str]:
    """Lines of a text; CaseError where it is none, or has too many."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaseError(f"{file}: is not text (byte {error.start} is not UTF-8); a survey is a CSV file") from None
    count = sum(map(text.count, "\n\r"))
    if count > MOST_LINES:
        raise CaseError(f"{file}: has {count:,} lines; at most {MOST_LINES:,} are read, and a wall needs far fewer")
    return iter(text.splitlines())


def _rows(lines: Iterator[str], file: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each row, as many as the head has; empty ones at the end and lines of `#` are left out.

    The head says what stands between cells: a semicolon, a tab, a comma or blanks. A cell may stand in quotes.
    """
    sign, width = "", 0
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        if (longest := max(map(line.count, ";\t, "))) > MOST_COLUMNS:
            raise CaseError(
                f"{file}:{number}: has {longest:,} cells or blanks; at most {MOST_COLUMNS:,} are read in a row"
            )
        if not width:
            sign = next((sign for sign in (";", "\t", ",") if sign in line), " ")
        cells = [cell.strip() for cell in (line.split() if sign == " " else line.split(sign))]
        if '"' in line and sign != " ":
            with foreign(CaseError, f"{file}:{number}: is no row of a table", "mend the row"):
                cells = [cell.strip() for cell in next(csv.reader([line], delimiter=sign, strict=True))]
        while len(cells) > max(width, 1) and not cells[-1]:
            cells.pop()
        width = width or len(cells)
        if len(cells) != width:
            raise CaseError(
                f"{file}:{number}: has {len(cells)} cells where the head has {width}; a number has a point, not a "
                "comma, and what stands between the cells is the same in all rows"
            )
        yield number, cells


def _number(cells: list[str], index: int, head: list[str], place: str) -> float:
    """The number of a cell; CaseError for what is none, or has a unit of its own."""
    with suppress(ValueError):
        if isfinite(value := number_of(cells[index])):
            return value
    raise CaseError(
        f"{place}: {echoed(cells[index])} under {head[index]} is no number; expected is one such as 10.5, in the unit "
        "of the head: mend the row, or take it out"
    )


def _columns(head: list[str], place: str) -> tuple[list[int], tuple[str, float | None]]:
    """Columns of chainage and level, and the unit: what tells it, and in metres."""
    words = [HEAD.fullmatch(cell) if len(cell) <= LONGEST_HEAD else None for cell in head]
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
