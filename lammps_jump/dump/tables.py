# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables in CSV: those of a run folder, and those that a person has measured."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path

import numpy as np

from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import read_file
from lammps_jump.foreign import number_of
from lammps_jump.quoting import echoed, shortened

MOST_BYTES = 200_000_000
"""Of a table that is read."""
MOST_ROWS = 2_000_000
LARGEST = 1e100
"""Size of a number: squares of larger ones do not end."""
WORDS = {"": nan, "True": 1.0, "False": 0.0}
"""What stands for a number in the tables of a run."""


@dataclass(frozen=True)
class TextTable:
    """A table of texts, each row as long as the heads.

    Attributes
    ----------
    place : str
        Its file, for messages.
    heads : tuple of str
    rows : tuple of (int, list of str)
        Number of the line, and its cells.
    error : type
        Kind of the error where a cell is no number.
    """

    place: str
    heads: tuple[str, ...]
    rows: tuple[tuple[int, list[str]], ...]
    error: type[JumpError] = DumpError

    def numbers(self, name: str) -> np.ndarray:
        """A column, NaN where a cell is empty; one that is not there, a text or a number too large is an error."""
        if self.heads.count(name) != 1:
            many = "more than one" if name in self.heads else "no"
            raise self.error(
                f"{self.place}: {many} column {shortened(name)}; there are {shortened(', '.join(self.heads))}"
            )
        k = self.heads.index(name)
        return np.array([self._number(line, name, cells[k]) for line, cells in self.rows], float)

    def _number(self, line: int, name: str, cell: str) -> float:
        try:
            value = WORDS[cell] if cell in WORDS else number_of(cell)
        except ValueError:
            raise self.error(f"{self.place}, line {line}, column {name}: {echoed(cell)} is no number") from None
        if isfinite(value) and abs(value) > LARGEST:
            raise self.error(f"{self.place}, line {line}, column {name}: {value:g} is beyond {LARGEST:g}")
        return value


def read_table(path: Path) -> TextTable:
    """A CSV table of a run folder; DumpError where it cannot be read or is none."""
    try:
        return table_of(read_file(path, MOST_BYTES), str(path))
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error})") from None


def table_of(
    data: bytes, place: str, *, comments: bool = False, fewest: int = 0, error: type[JumpError] = DumpError
) -> TextTable:
    """The table of a text in CSV with a line of heads, without empty lines.

    Parameters
    ----------
    data : bytes
        UTF-8.
    place : str
        Its file, for messages.
    comments : bool
        Leave out lines that begin with #.
    fewest : int
        Rows that it must have.
    error : type
        Kind of the errors.

    Raises
    ------
    JumpError
        No text, fewer or too many rows, or a row with more or fewer values than there are heads.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise error(f"{place} cannot be read: it is no text in UTF-8; name a CSV file with a line of heads") from None
    rows: list[tuple[int, list[str]]] = []
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), 1):
        if not line.strip() or (comments and line.lstrip().startswith("#")):
            continue
        try:
            rows.append((number, [cell.strip() for cell in next(csv.reader([line]))]))
        except csv.Error as wrong:
            raise error(f"{place}, line {number}: {wrong}") from None
        if len(rows[-1][1]) != len(rows[0][1]):
            raise error(f"{place}, line {number}: {len(rows[-1][1])} values, but {len(rows[0][1])} heads")
        if len(rows) > MOST_ROWS + 1:
            raise error(f"{place}: more than {MOST_ROWS} rows; write fewer")
    if not rows or len(rows) <= fewest:
        raise error(f"{place} has {max(0, len(rows) - 1)} rows below its heads; {fewest} are needed")
    return TextTable(place, tuple(rows[0][1]), tuple(rows[1:]), error)
