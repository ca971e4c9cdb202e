# SPDX-License-Identifier: GPL-2.0-or-later
"""A curve of a run, or of the starts of a study, against a curve that a person has measured."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.errors import CaseError
from lammps_jump.files import whole

PROFILES = "profiles"
"""Name of the means over x in profiles.nc, beside the names of the CSV tables."""
FEWEST = 2
"""Measured points that must lie where the run has a curve."""


@dataclass(frozen=True)
class Distance:
    """How far the curve of a run is from measured points; units are those of the two columns.

    Attributes
    ----------
    column, measured : str
        ``TABLE.COLUMN`` of the run, and the column of the file.
    points, points_measured : int
        Measured points that lie where all starts have a curve, and all of them.
    starts : int
    mean, mean_interval : float
        Mean of run - measured, and ± of its 95 % interval over starts (Student's t); NaN of one run.
    rms : float
        Root mean square of the difference, of the mean curve of all starts.
    rms_over_range : float
        The same over the range of the measured values.
    """

    column: str
    measured: str
    points: int
    points_measured: int
    starts: int
    mean: float
    mean_interval: float
    rms: float
    rms_over_range: float


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


def tables_of(folder: Path) -> dict[str, list[str]]:
    """Columns of the CSV tables of a run folder that have an axis, by the name of the table."""
    found = {}
    for path in sorted(folder.glob("*.csv")):
        with path.open() as file:
            columns = file.readline().strip().split(",")
        if len(columns) > 1 and "structure" not in columns:
            found[path.stem] = columns
    return found


def curve_of(folder: Path, axis: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The axis and a column of a table of a run folder, without rows that hold no number.

    Raises
    ------
    CaseError
        No such table or column; says which there are.
    """
    import pandas as pd  # 0.3 s

    table, column = name.split(".", 1)
    if table == PROFILES:
        import xarray as xr

        if not (folder / "profiles.nc").is_file():
            raise CaseError(f"{folder}: no profiles.nc; analyse the run first")
        with xr.open_dataset(folder / "profiles.nc", engine="scipy") as found:
            known = [key for key in found if found[key].dims == ("x",)]
            if column not in known or axis != "x":
                raise CaseError(f"{name} against {axis}: profiles.nc has, against x: {', '.join(map(str, known))}")
            x, y = np.array(found["x"], float), np.array(found[column], float)
    else:
        known_tables = tables_of(folder)
        if table not in known_tables:
            raise CaseError(f"{name}: {folder} has no table {table}; there are {', '.join([*known_tables, PROFILES])}")
        for one in (axis, column):
            if one not in known_tables[table]:
                raise CaseError(f"{table}.csv has no column {one}; there are {', '.join(known_tables[table])}")
        rows = pd.read_csv(folder / f"{table}.csv")
        x, y = rows[axis].to_numpy(float), rows[column].to_numpy(float)
    known_rows = np.isfinite(x) & np.isfinite(y)
    order = np.argsort(x[known_rows], kind="stable")
    return x[known_rows][order], y[known_rows][order]


def measured_of(path: Path, columns: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Columns of a person's file, SI, by their names there.

    Raises
    ------
    CaseError
        No such file or column, or a value that is no number, with its line.
    """
    (_, heads), *rows = table_of(path)
    found = {}
    for name in columns.values():
        if heads.count(name) != 1:
            apart = "; put commas between the columns" if any(sign in heads[0] for sign in ";\t") else ""
            many = "no column" if name not in heads else "more than one column"
            raise CaseError(f"{path} has {many} {name}; there are {', '.join(heads)}{apart}")
        found[name] = np.array([finite(path, line, name, cells[heads.index(name)]) for line, cells in rows])
    return found


def table_of(path: Path) -> list[tuple[int, list[str]]]:
    """Number and cells of each line of a CSV file, heads first, without empty lines and those that begin with #.

    Raises
    ------
    CaseError
        It cannot be read, has no row, or a row has more or fewer values than there are heads.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        told = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        raise CaseError(f"{path} cannot be read: {told}; name a CSV file with a line of heads") from None
    kept = [
        (number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    rows = [(number, [cell.strip() for cell in next(csv.reader([line]))]) for number, line in kept]
    if len(rows) <= FEWEST:
        raise CaseError(f"{path} has {max(0, len(rows) - 1)} rows below its heads; {FEWEST} are needed")
    for number, cells in rows:
        if len(cells) != len(rows[0][1]):
            raise CaseError(f"{path}, line {number}: {len(cells)} values, but {len(rows[0][1])} heads")
    return rows


def finite(path: Path, line: int, name: str, cell: str) -> float:
    """A cell as a number; CaseError, with its place, where it is none."""
    try:
        value = float(cell)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise CaseError(
            f"{path}, line {line}, column {name}: {cell!r} is no finite number; write 1.5 or 2e-3, or begin the line "
            "with # to leave it out"
        )
    return value


def starts_of(folder: Path) -> list[Path]:
    """The run folders of a study that are complete, or the folder itself.

    Raises
    ------
    CaseError
        A folder of neither, or without a complete run.
    """
    if (folder / "summary.json").is_file():
        return [folder]
    runs = sorted(path.parent for path in folder.glob("runs/*/summary.json"))
    found = [path for path in runs if json.loads((path / "summary.json").read_text()).get("status") == "complete"]
    if not found:
        raise CaseError(f"{folder} holds no complete run; name a run folder, or that of the starts of one case")
    return found


def distance(curves: list[tuple[np.ndarray, np.ndarray]], at: np.ndarray, measured: np.ndarray) -> dict[str, Any]:
    """Deviation of curves (axis, values) of some starts from measured points; keys as of `Distance`.

    Curves are taken at the measured points by straight lines. Points beyond the end of a curve are left out.

    Raises
    ------
    CaseError
        Fewer than `FEWEST` points in common.
    """
    from scipy.special import stdtrit

    low, high = max(x[0] for x, _ in curves), min(x[-1] for x, _ in curves)
    inside = (at >= low) & (at <= high)
    if inside.sum() < FEWEST:
        raise CaseError(
            f"the run has its curve from {low:g} to {high:g}, the points lie from {at.min():g} to {at.max():g}: "
            f"{inside.sum()} points in common, {FEWEST} are needed; are the units the same (SI)?"
        )
    off = np.array([np.interp(at[inside], x, y) - measured[inside] for x, y in curves])
    means, n = off.mean(axis=1), len(curves)
    rms, extent = float(np.sqrt(np.mean(off.mean(axis=0) ** 2))), float(np.ptp(measured))
    return {
        "points": int(inside.sum()),
        "points_measured": len(at),
        "starts": n,
        "mean": float(means.mean()),
        "mean_interval": float(stdtrit(n - 1, 0.975) * means.std(ddof=1) / np.sqrt(n)) if n > 1 else nan,
        "rms": rms,
        "rms_over_range": rms / extent if extent > 0 else nan,
    }


def compare_with_data(folder: Path, data: Path, columns: str, out: Path | None = None) -> tuple[list[Distance], Path]:
    """Hold curves of a run, or of the starts of a study, against a person's measured ones.

    Parameters
    ----------
    folder : Path
        A run folder, or that of the starts of one case.
    data : Path
        CSV with a line of heads; SI. Lines that begin with # are left out.
    columns : str
        As of `parse_columns`.
    out : Path, optional
        Folder of ``compared.json``, ``compared.md`` and ``compared.png``; unless given, ``<folder>_against_<data>``.

    Returns
    -------
    list of Distance, Path
        One for each pair of columns but the axis, and the folder.

    Raises
    ------
    CaseError
        A table, column or file that is not there, a value that is no number, no points in common.
    """
    from matplotlib.figure import Figure

    pairs = parse_columns(columns)
    (axis, own_axis), *wanted = pairs.items()
    given, places = measured_of(data, pairs), starts_of(folder)
    at = given[own_axis]
    found, drawn = [], []
    for name, own in wanted:
        curves = [curve_of(place, axis, name) for place in places]
        if any(len(x) < FEWEST for x, _ in curves):
            raise CaseError(f"{name}: a run has fewer than {FEWEST} values of it")
        found.append(Distance(name, own, **distance(curves, at, given[own])))
        drawn.append((name, own, curves))
    out = out or Path(f"{folder.absolute().name}_against_{data.stem}")
    out.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=(7, 3.2 * len(drawn)), layout="constrained")
    for place, (name, own, curves) in zip(figure.subplots(len(drawn), squeeze=False)[:, 0], drawn, strict=True):
        for number, (x, y) in enumerate(curves):
            place.plot(x, y, color="#0b2f6b", lw=1.4, label=None if number else f"run: {name}")
        place.plot(at, given[own], "o", ms=4, mfc="white", mec="#a02c3c", label=f"measured: {own}")
        place.set_xlabel("time [s]" if axis == "time" else f"{axis} [SI]")
        place.set_ylabel(f"{name} [SI]")
        place.grid(alpha=0.3)
        place.legend(frameon=False)
    figure.savefig(out / "compared.png", dpi=150)
    plain = [{key: None if value != value else value for key, value in asdict(one).items()} for one in found]
    for file, text in (
        ("compared.json", json.dumps(plain, indent=1) + "\n"),
        ("compared.md", page(found, folder, data)),
    ):
        with whole(out / file) as new:
            new.write_text(text)
    return found, out


def page(found: list[Distance], folder: Path, data: Path) -> str:
    """The distances as a page in Markdown."""
    lines = [
        f"# {folder.absolute().name} against {data.name}",
        "",
        "| run | measured | points | mean of run - measured | root mean square | over the measured range |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for one in found:
        sure = f" ± {one.mean_interval:.2g}" if one.starts > 1 else ""
        lines.append(
            f"| {one.column} | {one.measured} | {one.points} of {one.points_measured} | {one.mean:.4g}{sure} | "
            f"{one.rms:.3g} | {100 * one.rms_over_range:.1f} % |"
        )
    starts = found[0].starts
    told = (
        f"± is the 95 % interval over {starts} starts."
        if starts > 1
        else "One run has no interval: repeat it from other starts."
    )
    return "\n".join([*lines, "", told, "", "![the curves](compared.png)", ""])
