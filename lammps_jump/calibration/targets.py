# SPDX-License-Identifier: GPL-2.0-or-later
"""Measurements: tables, numbers and curves with their errors, and the same of a run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from lammps_jump.case.base import Strict
from lammps_jump.dump.find import LARGEST, table_of
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import read_file
from lammps_jump.foreign import number_of
from lammps_jump.quoting import echoed, shortened
from lammps_jump.runs.summary import Results, open_results
from lammps_jump.sweeps.table import number_at
from lammps_jump.units import Plain

PROFILES, PROFILES_FILE = "profiles", "profiles.nc"
"""Name of the means over x in profiles.nc, in addition to the names of the CSV tables."""
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
    dataset = results.dataset()
    known = [str(key) for key in dataset if dataset[key].dims == ("x",) and dataset[key].dtype.kind in "fiu"]
    if column not in known or axis != "x" or "x" not in dataset.coords:
        raise CaseError(f"{name} against {axis}: profiles.nc has, against x: {shortened(', '.join(known))}")
    x, y = np.array(dataset["x"], float), np.array(dataset[column], float)
    if max(np.abs(np.nan_to_num(x)).max(), np.abs(np.nan_to_num(y)).max()) > LARGEST:
        raise DumpError(f"{path}: {column}: a number beyond {LARGEST:zg}; analyse the run again")
    return x, y


def _of_table(results: Results, name: str, axis: str, column: str) -> tuple[np.ndarray, np.ndarray]:
    tables = [table for table in results.tables if not table.startswith("profiles")]
    if name not in tables:
        there = ", ".join([*tables, PROFILES])
        raise CaseError(f"{name}.{column}: {results.folder} has no table {shortened(name)}; there are {there}")
    columns = results.table(name)
    for one in (axis, column):
        if one not in columns.heads:
            raise CaseError(
                f"{name}.csv has no column {shortened(one)}; there are {shortened(', '.join(columns.heads))}"
            )
    return columns.numbers(axis), columns.numbers(column)


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
        reason = error.strerror or error
        raise CaseError(f"{path} cannot be read: {reason}; name a CSV file with a line of heads") from None
    table = table_of(data, str(path), comments=True, fewest=FEWEST, error=CaseError)
    heads, heads_read = table.heads, {}
    for name in columns.values():
        if heads.count(name) != 1:
            apart = "; put commas between the columns" if any(sign in heads[0] for sign in ";\t") else ""
            many = "no column" if name not in heads else "more than one column"
            raise CaseError(f"{path} has {many} {name}; there are {shortened(', '.join(heads))}{apart}")
        heads_read[name] = np.array([finite(path, line, name, cells[heads.index(name)]) for line, cells in table.rows])
    return heads_read


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


EXAMPLE = '--target "jump.y2=6.7 ± 0.1"'
ALONG, LEVEL, ENDS = ("x",), 1e-9, ((0, 1), (-1, -2))
"""Axes along which a curve goes on that ends level, as that of a heap on its bed; share of its range that is level."""
COVERED = 0.5
"""Least share of the measured points at which a run must have its curve."""
UNSTATED_FEWEST = 5
"""Points of a curve without a stated error: fewer do not tell their error."""
Positive = Annotated[Plain, Field(gt=0)]


@dataclass(frozen=True)
class Target:
    """A measured number, or the points of a measured curve.

    Attributes
    ----------
    name : str
        Key of ``summary.json``, or ``TABLE.COLUMN`` of a run.
    measured, error : ndarray, shape (k,)
        In the unit of the number; one value of a number. The errors of a curve are NaN where none was stated: they are
        estimated (`unstated`).
    axis : str
        Of a curve; empty of a number.
    at : ndarray, shape (k,)
        Along that axis; empty of a number.
    """

    name: str
    measured: np.ndarray
    error: np.ndarray
    axis: str = ""
    at: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def stated(self) -> bool:
        """Tells whether the error was given with the measurement."""
        return bool(np.isfinite(self.error).all())

    def of_run(self, folder: Path, summary: Mapping[str, Any]) -> np.ndarray:
        """The same numbers of a run, shape (k,); NaN where it has none.

        Raises
        ------
        CaseError
            A table or column that no run of this case has.
        DumpError
            Results that are not as the analysis wrote them.
        """
        if not self.axis:
            return np.array([number_at(summary, self.name)])
        x, y = curve_of(open_results(folder), self.axis, self.name)
        if len(x) < FEWEST:
            return np.full(len(self.at), np.nan)
        flat = [self.axis in ALONG and abs(y[end] - y[next_to_end]) <= LEVEL * np.ptp(y) for end, next_to_end in ENDS]
        ends = [y[end] if level else np.nan for level, (end, _) in zip(flat, ENDS, strict=True)]
        return np.interp(self.at, x, y, *ends)

    def lacking(self, values: np.ndarray) -> str:
        """Why the numbers of a run cannot be used; empty where they can."""
        known = np.isfinite(values)
        if not self.axis:
            return "" if known.all() else f"no {self.name}"
        few = known.mean() < COVERED or known.sum() < FEWEST
        return f"{self.name} at {known.sum()} of {len(known)} measured points" if few else ""

    @property
    def as_field(self) -> dict[str, Any]:
        """As it is written in a study file, without the file of the measurement."""
        if not self.axis:
            return {"key": self.name, "value": float(self.measured[0]), "error": float(self.error[0])}
        lists = {"at": self.at, "values": self.measured} | ({"errors": self.error} if self.stated else {})
        return {"curve": self.name, "axis": self.axis, **{key: list(map(float, one)) for key, one in lists.items()}}


class TargetField(Strict):
    """A target of a study file: a number, points of a curve, or columns of a file."""

    key: str | None = None
    value: Plain | None = None
    error: Positive | None = None
    data: str | None = None
    columns: str | None = None
    curve: str | None = None
    axis: str | None = None
    at: list[Plain] | None = None
    values: list[Plain] | None = None
    errors: list[Positive] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> TargetField:
        given = self.model_fields_set
        curve = {"curve", "axis", "at", "values"}
        if given not in ({"key", "value", "error"}, {"data", "columns"}, curve, {*curve, "errors"}):
            raise ValueError(
                "does not fit; allowed is {key: jump.y2, value: 6.7, error: 0.1}, or {data: heap.csv, columns: "
                "'x=x,heap.depth=h ± 0.01'}"
            )
        if self.at is not None and self.values is not None:
            errors = self.values if self.errors is None else self.errors
            if not FEWEST <= len(self.at) == len(self.values) == len(errors):
                raise ValueError("at, values and errors need one length, two points or more")
            if self.errors is None and len(self.at) < UNSTATED_FEWEST:
                raise ValueError(_few(len(self.at), "add errors: [0.01, …]"))
        return self

    def targets(self, place: Path) -> list[Target]:
        """The targets that it means; files are looked for in `place`."""
        if self.key is not None:
            return [Target(self.key, np.array([self.value]), np.array([self.error]))]
        if self.data is not None and self.columns is not None:
            return of_file(place / self.data, self.columns)
        assert self.values is not None  # with `curve`
        errors = self.errors or [nan] * len(self.values)
        arrays = [np.array(one, float) for one in (self.values, errors, self.at)]
        return [Target(str(self.curve), arrays[0], arrays[1], str(self.axis), arrays[2])]


def parse_target(text: str) -> dict[str, Any]:
    """Key, value and error of ``--target``: ``jump.y2=6.7 ± 0.1`` (or ``+-``).

    Raises
    ------
    CaseError
        Another text.
    """
    number = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
    match = re.fullmatch(rf"\s*([^=\s]+)\s*=\s*({number})\s*(?:±|\+-|\+/-)\s*({number})\s*", text, re.ASCII)
    if not match:
        raise CaseError(f"--target {shortened(text)}: expected a key, a value and its error, for example {EXAMPLE}")
    error = float(match[3])
    if not error > 0:
        raise CaseError(f"--target {shortened(text)}: the error is {error:zg}; allowed is > 0")
    return {"key": match[1], "value": float(match[2]), "error": error}


def of_file(path: Path, columns: str) -> list[Target]:
    """Curves of a person's file, by ``x=x,heap.depth=h ± 0.01``; the error is a number or a column, or not stated.

    Raises
    ------
    CaseError
        As `parse_columns` and `measured_of`; an error that is no number and no column, or not above 0; fewer points
        without an error than tell it.
    """
    words = [part.replace("+-", "±").split("±") for part in columns.split(",")]
    pairs = parse_columns(",".join(part[0].strip() for part in words))
    said = {part[0].split("=", 1)[0].strip(): part[1].strip() for part in words if len(part) == 2 and "=" in part[0]}
    named = {name: text for name, text in said.items() if not _is_number(text)}
    (axis, own_axis), *wanted = pairs.items()
    given = measured_of(path, {**pairs, **{f"± {name}": text for name, text in named.items()}})
    targets = []
    for name, own in wanted:
        text = said.get(name)
        if name in named:
            error = given[named[name]]
        else:
            error = np.full(len(given[own]), nan if text is None else finite(path, 1, name, text))
        if (error <= 0).any():
            least = f"{error.min():zg}; allowed is > 0. Leave ± away where the error is not known: it is estimated then"
            raise CaseError(f"{path}: the error of {name} is {least}")
        if text is None and len(error) < UNSTATED_FEWEST:
            raise CaseError(f"{path}: {name}: {_few(len(error), 'write it behind the column: h ± 0.01')}")
        order = np.argsort(given[own_axis], kind="stable")
        targets.append(Target(name, given[own][order], error[order], axis, given[own_axis][order]))
    return targets


def _few(count: int, remedy: str) -> str:
    """Why so few points cannot be taken without an error."""
    return f"{count} points do not tell their error, and none is stated; {UNSTATED_FEWEST} or more do. Else {remedy}"


def _is_number(text: str) -> bool:
    try:
        number_of(text)
    except ValueError:
        return False
    return True
