# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of a run folder; tables, those of a folder and those that a person has measured."""

from __future__ import annotations

import csv
import glob
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import DUMP_NAMES, FORCES_HEADER, forces_header, read_file, text_of, write_text
from lammps_jump.folders import read_marker
from lammps_jump.foreign import number_of
from lammps_jump.quoting import echoed, shortened
from lammps_jump.scene.motion import MovingWall, arms
from lammps_jump.scene.scene import Scene

from .read import Dump, by_numbers, files_of, open_dump

Groups = Sequence[tuple[str, Sequence[str]]]
Row = tuple[Any, ...]
"""Step, name, fx, fy (N/m), moment (N) and, where walls move, power (W/m): means over the window that ends there."""
KNOWN_NAMES = (*DUMP_NAMES.values(), "dump.bin", "dump.lammpsbin.gz")
FORCE_COLUMNS = tuple(FORCES_HEADER.split(","))


@dataclass(frozen=True)
class ForceHistory:
    """Force on one structure: means over the windows that end at `time`.

    Attributes
    ----------
    time : ndarray, shape (n,), s
    fx, fy : ndarray, shape (n,), N per metre of width
        Force of the discs on the structure.
    moment : ndarray, shape (n,), N m per metre of width
        About the lower-left corner (a block) or the point nearest the origin (a plane), of a wall that moves about its
        moving pivot; counter-clockwise positive.
    power : ndarray, shape (n,), W per metre of width, or None
        Of the structure on the discs; None where no wall moves.
    """

    time: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    moment: np.ndarray
    power: np.ndarray | None = None


def find_dump(*places: str | Path) -> Path:
    """The dump of a folder, the file itself, or the pattern of the files that are one dump.

    The dump of a folder of results is the one that was analysed. Of other folders it is the first of `KNOWN_NAMES` in
    them, else their files ``dump.*``: one, or several whose names differ in numbers alone. A run folder may so hold
    other dumps besides its own.

    Parameters
    ----------
    *places : str or Path
        A folder, a file or a pattern; or all the files of one pattern, as a shell hands them over.

    Raises
    ------
    DumpError
        Nothing there, a folder without a dump, or several dumps.
    """
    place, *more = (Path(place) for place in places)
    if more:
        path = place.parent / _pattern(file.name for file in (place, *more))
        if {place, *more} != {*files_of(path)}:
            raise DumpError(
                f"{place}, {more[0]}{', …' if more[1:] else ''}: allowed is one dump, or all files of one pattern; "
                "name one dump, or put the pattern in quotes, such as 'dump.*.lammps'."
            )
        return path
    if not place.is_dir():
        if not files_of(place):
            raise DumpError(f"{place}: there is no such file or folder.")
        return place
    marker = read_marker(place)
    if marker is not None and marker.kind == "analysis":
        path = Path(marker.about.get("dump", ""))
        if not files_of(path):
            raise DumpError(f"{place}: holds the results of {path}, which is no longer there; put the dump back")
        return path
    for name in KNOWN_NAMES:
        if (place / name).is_file():
            return place / name
    others = sorted(path for path in place.glob("dump.*") if path.is_file())
    if not others:
        raise DumpError(f"{place}: no dump in this folder (looked for dump.*). Did the run finish?")
    name = _pattern(path.name for path in others)
    if not name:
        raise DumpError(
            f"{place}: {len(others)} dumps in this folder ({others[0].name} … {others[-1].name}); name one of them."
        )
    return others[0] if len(others) == 1 else place / name


def _pattern(names: Iterable[str]) -> str:
    """Pattern of names that differ in numbers alone; empty where they differ in more."""
    parts = [by_numbers(name) for name in names]
    if len({tuple(part[::2]) for part in parts}) > 1:
        return ""
    return "".join(glob.escape(same[0]) if len(set(same)) == 1 else "*" for same in zip(*parts, strict=True))


def read_dump(place: str | Path) -> Dump:
    """The dump of a file, of a folder, or of a pattern such as ``dump.*.lammps`` for files of a frame or more each.

    Raises
    ------
    DumpError
        See `find_dump` and `open_dump`.
    """
    return open_dump(find_dump(place))


def forces_in(folder: Path) -> Mapping[str, ForceHistory]:
    """Forces of a run folder by structure; empty where none were recorded, or the file is damaged.

    For pages, which are whole without them.
    """
    try:
        return read_forces(folder / "forces.csv")
    except DumpError:
        return {}


def read_forces(path: str | Path) -> dict[str, ForceHistory]:
    """``forces.csv`` by structure; an empty dict where the file has only its header.

    Raises
    ------
    DumpError
        Not there, a wrong header, or a line that is no row of it (a cut-off last line is left out).
    """
    return forces_of(text_of(Path(path)), path)


def forces_of(text: str, path: str | Path) -> dict[str, ForceHistory]:
    """`read_forces` of a text; `path` is its name in messages."""
    rows: dict[str, list[tuple[float, ...]]] = {}
    lines = text.splitlines()
    header = tuple(name.strip() for name in lines[0].split(",")) if lines else ()
    missing = [name for name in FORCE_COLUMNS[:4] if name not in header]
    if missing:
        raise DumpError(f"{path}, line 1: no column '{missing[0]}'; expected {','.join(FORCE_COLUMNS)}.")
    columns = ("time", "fx", "fy", "moment", *(["power"] if "power" in header else []))
    for number, line in enumerate(lines[1:], start=2):
        if not line:
            continue
        try:
            cells = dict(zip(header, next(csv.reader([line])), strict=True))
            values = tuple(number_of(cells.get(name, "nan")) for name in columns)
        except (ValueError, csv.Error):
            if number == len(lines) and not text.endswith("\n"):
                break
            raise DumpError(
                f"{path}, line {number}: {line[:60]!r} is no row of {shortened(','.join(header))}."
            ) from None
        rows.setdefault(cells["structure"].strip(), []).append(values)
    return {name: ForceHistory(*np.array(values).T) for name, values in rows.items()}


def with_groups(rows: Iterable[Row], groups: Groups, walls: Sequence[MovingWall]) -> Iterator[Row]:
    """Rows of walls, and after those of each step a row a group.

    Force and power are sums. The moment is about the point of the group's first wall: each wall's own, and its force at
    its arm. Arms are constant, so that this is exact for means over a window.
    """
    by_name = {one.wall.name: one for one in walls}
    leads = {name: arms(name, [by_name[member] for member in members]) for name, members in groups}
    for step, rows_of_step in groupby(rows, key=lambda row: row[0]):
        own = list(rows_of_step)
        yield from own
        values = {name: np.array(numbers, float) for _, name, *numbers in own}
        for name, members in groups:
            if not all(member in values for member in members):
                continue  # the last window of a run that was torn
            total = np.sum([values[member] for member in members], axis=0)
            forces = np.array([values[member][:2] for member in members])
            total[2] += float(np.sum(leads[name][:, 0] * forces[:, 1] - leads[name][:, 1] * forces[:, 0]))
            yield step, name, *map(float, total)


def write_forces(path: str | Path, scene: Scene, forces: Iterable[tuple[Any, ...]]) -> None:
    """Write ``forces.csv``, means over windows; rows of the scene's groups are added.

    Parameters
    ----------
    path : str or Path
    scene : Scene
    forces : iterable of tuple
        Rows of step at the end of the window, structure, fx, fy (N/m), moment (N) and, where walls move, power (W/m).
    """
    rows = (
        f"{scene.time(step):.10g},{name},{','.join(f'{value:.10g}' for value in values)}\n"
        for step, name, *values in with_groups(forces, scene.groups, scene.walls)
    )
    write_text(Path(path), "".join([f"{forces_header(power=scene.moves)}\n", *rows]))


MOST_BYTES = 200_000_000
"""Of a table that is read."""
MOST_ROWS = 2_000_000
LARGEST = 1e100
"""Size of a number: squares of larger ones do not end."""
WORDS = {"": nan, "True": 1.0, "False": 0.0}
"""Words for a number in the tables of a run."""


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
