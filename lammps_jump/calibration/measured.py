# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves of a run, by the columns of its tables, and the curves that a person has measured."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan
from pathlib import Path

import numpy as np

from lammps_jump.dump.tables import LARGEST, table_of
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import read_file
from lammps_jump.foreign import number_of
from lammps_jump.quoting import echoed, shortened
from lammps_jump.runs.summary import Results

PROFILES, PROFILES_FILE = "profiles", "profiles.nc"
"""Name of the means over x in profiles.nc, beside the names of the CSV tables."""
FEWEST = 2
"""Measured points that must lie where the run has a curve."""
MOST_MEASURED = 10_000_000
"""Bytes of a file with measured points."""


def parse_columns(text: str) -> dict[str, str]:
    """Columns of the run and of the file: ``time=t,gauges.depth_5=h``; the first pair is the axis.

    Raises
    ------
    CaseError
        Fewer than two pairs, or a word that is none.
    """
    pairs = dict(part.strip().split("=", 1) for part in text.split(",") if part.count("=") == 1)
    if len(pairs) < 2 or len(pairs) != len(text.split(",")) or not all("." in name for name in list(pairs)[1:]):
        raise CaseError(
            f"--columns {text}: expected AXIS=COLUMN,TABLE.COLUMN=COLUMN, such as time=t,gauges.depth_5=h or "
            "x=x,profiles.mass_depth_mean=depth"
        )
    return pairs


def curve_of(results: Results, axis: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The axis and a column of a table of a run, without rows that hold no number.

    Raises
    ------
    CaseError
        No such table or column; says which there are.
    DumpError
        A table that is not as the analysis wrote it.
    """
    table, column = name.split(".", 1)
    x, y = _of_profiles(results, axis, name) if table == PROFILES else _of_table(results, table, axis, column)
    known_rows = np.isfinite(x) & np.isfinite(y)
    order = np.argsort(x[known_rows], kind="stable")
    return x[known_rows][order], y[known_rows][order]


def _of_profiles(results: Results, axis: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    path, column = results.folder / PROFILES_FILE, name.split(".", 1)[1]
    found = results.dataset()
    known = [str(key) for key in found if found[key].dims == ("x",) and found[key].dtype.kind in "fiu"]
    if column not in known or axis != "x" or "x" not in found.coords:
        raise CaseError(f"{name} against {axis}: profiles.nc has, against x: {shortened(', '.join(known))}")
    x, y = np.array(found["x"], float), np.array(found[column], float)
    if max(np.abs(np.nan_to_num(x)).max(), np.abs(np.nan_to_num(y)).max()) > LARGEST:
        raise DumpError(f"{path}: {column}: a number beyond {LARGEST:zg}; analyse the run again")
    return x, y


def _of_table(results: Results, name: str, axis: str, column: str) -> tuple[np.ndarray, np.ndarray]:
    tables = [table for table in results.tables if not table.startswith("profiles")]
    if name not in tables:
        there = ", ".join([*tables, PROFILES])
        raise CaseError(f"{name}.{column}: {results.folder} has no table {shortened(name)}; there are {there}")
    found = results.table(name)
    for one in (axis, column):
        if one not in found.heads:
            raise CaseError(f"{name}.csv has no column {shortened(one)}; there are {shortened(', '.join(found.heads))}")
    return found.numbers(axis), found.numbers(column)


def measured_of(path: Path, columns: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Columns of a person's file, SI, by their names there.

    Raises
    ------
    CaseError
        No such file or column, or a value that is no number, with its line.
    """
    try:
        data = read_file(path, MOST_MEASURED)
    except OSError as error:
        told = error.strerror or error
        raise CaseError(f"{path} cannot be read: {told}; name a CSV file with a line of heads") from None
    table = table_of(data, str(path), comments=True, fewest=FEWEST, error=CaseError)
    heads, found = table.heads, {}
    for name in columns.values():
        if heads.count(name) != 1:
            apart = "; put commas between the columns" if any(sign in heads[0] for sign in ";\t") else ""
            many = "no column" if name not in heads else "more than one column"
            raise CaseError(f"{path} has {many} {name}; there are {shortened(', '.join(heads))}{apart}")
        found[name] = np.array([finite(path, line, name, cells[heads.index(name)]) for line, cells in table.rows])
    return found


def finite(path: Path, line: int, name: str, cell: str) -> float:
    """A cell as a number; CaseError, with its place, where it is none or one beyond all measure."""
    try:
        value = number_of(cell)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise CaseError(
            f"{path}, line {line}, column {name}: {echoed(cell)} is no finite number; write 1.5 or 2e-3, or begin the "
            "line with # to leave it out"
        )
    if abs(value) > LARGEST:
        raise CaseError(
            f"{path}, line {line}, column {name}: {value:zg} is beyond {LARGEST:zg}; write it in SI, or begin the line "
            "with # to leave it out"
        )
    return value
