# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables in files beside a case, whose rows are the points of a wall or of a motion."""

from __future__ import annotations

from lammps_jump.errors import CaseError
from lammps_jump.files import read_file
from lammps_jump.foreign import foreign
from lammps_jump.quoting import echoed
from lammps_jump.scene.tracks import MOST_ROWS
from lammps_jump.units import to_si

from .text import CaseSource, FileTable, PathKey, dotted_path

MOST_TABLE = 10_000_000
"""Bytes of a table that a case names."""
SHAPE = {"x": "m", "y": "m"}
TABLES = {"line": SHAPE, "polygon": SHAPE, "table": {"t": "s", **SHAPE, "angle": "degree"}}
"""Columns and units of the tables that may stand in place of points, by the kind of their wall or motion."""


def read_tables(source: CaseSource) -> None:
    """Read the tables that walls and their motions name; those that are read already are kept.

    Raises
    ------
    CaseError
        A case without a folder, a file outside of it, no table, points beside the file; with file and line.
    """
    known, source.tables = source.tables, {}
    walls = source.data.get("walls")
    for index, wall in enumerate(walls if isinstance(walls, list) else []):
        if not isinstance(wall, dict):
            continue
        for path, group in ((("walls", index), wall), (("walls", index, "motion"), wall.get("motion"))):
            if not isinstance(group, dict) or not isinstance(name := group.get("file"), str):
                continue
            if (kind := group.get("kind")) in TABLES:
                old = known.get(path)
                source.tables[path] = old if old and old.name == name else _table(source, path, name, TABLES[kind])
                if group.get("points") is not None:
                    raise CaseError(f"{source.place((*path, 'file'))}: points and file are both given; keep one")


def _table(source: CaseSource, path: PathKey, name: str, columns: dict[str, str]) -> FileTable:
    """A table with these columns (name: unit), by name where its first row has words, else in their order."""
    place = source.place((*path, "file"))
    if source.folder is None:
        raise CaseError(f"{place}: {echoed(name)}: the case is of no file, so that it has no folder: give points")
    file = source.folder / name
    with foreign(CaseError, f"{place}: {echoed(name)} cannot be read", "name a CSV file beside the case"):
        found = file.resolve(strict=True)
        if not found.is_relative_to(source.folder.resolve()):
            raise CaseError(f"{place}: {echoed(name)} lies outside the folder of the case; copy it there")
        text = read_file(found, MOST_TABLE).decode("utf-8-sig")
    return FileTable(name, str(file), *_rows(text, columns, str(file), dotted_path(path)))


def _rows(text: str, columns: dict[str, str], file: str, field: str) -> tuple[list[list[float]], list[int]]:
    """Rows of a text, and the lines where they stand."""
    rows: list[list[float]] = []
    lines: list[int] = []
    order: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        cells = _cells(line)
        if not cells:
            continue
        if not order:
            words = [cell.lower() for cell in cells]
            if set(columns) <= set(words):
                order = [words.index(column) for column in columns]
                continue
            order = list(range(len(columns)))
        if len(rows) == MOST_ROWS:
            raise CaseError(f"{file}:{number}: {field}: more than {MOST_ROWS} rows; write fewer")
        rows.append(_row(cells, order, columns, f"{file}:{number}: {field}"))
        lines.append(number)
    if not rows:
        raise CaseError(f"{file}: {field}: holds no row; its columns are {', '.join(columns)}")
    return rows, lines


def _cells(line: str) -> list[str]:
    """Cells of a line between semicolons, else commas, else blanks; none of an empty line or a comment."""
    if not line.strip() or line.lstrip().startswith("#"):
        return []
    sign = next((sign for sign in ";," if sign in line), None)
    return [cell.strip().strip('"') for cell in line.split(sign)]


def _row(cells: list[str], order: list[int], columns: dict[str, str], place: str) -> list[float]:
    if len(cells) <= max(order):
        raise CaseError(
            f"{place}: has {len(cells)} cells; the columns are {', '.join(columns)}, in this order or under their names"
        )
    row = []
    for index, (column, unit) in zip(order, columns.items(), strict=True):
        try:
            row.append(to_si(cells[index], unit))
        except ValueError as error:
            raise CaseError(f"{place}: column {column}: {error}") from None
    return row
