# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of all members, and their statistics at each point: mean, scatter, interval over starts, own errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.statistics import student
from lammps_jump.analysis.tables import value_at

from .study import Study

if TYPE_CHECKING:
    import xarray as xr

STATISTICS = ("mean", "sd", "se", "low", "high", "n", "own_error", "chi2")
"""Of each number at each point, over the members that have it: mean, standard deviation, standard error of the mean,
bounds of the interval of Student's t, count; root mean square of the errors that single runs state of themselves, and
the mean of (deviation from the mean / stated error)^2."""
DISAGREE = 1.5
"""chi2 above which the errors of single runs are called too small."""


def number_at(summary: Mapping[str, Any], path: str) -> float:
    """A number of ``summary.json``; NaN where there is none, or where its verdict makes it meaningless."""
    parent, _, key = path.rpartition(".")
    value, beside = value_at(summary, path), value_at(summary, parent)
    quantity = QUANTITIES.get(path.partition(".")[0])
    judged = isinstance(beside, Mapping) and "verdict" in beside
    meant = quantity is None or not judged or quantity.applies(key, quantity.read(beside))
    return float(value) if isinstance(value, int | float) and meant else nan


def row_of(summary: Mapping[str, Any], study: Study) -> dict[str, float | str]:
    """Collected numbers of a run, the error of each as ``<path>_error``, and the verdicts."""
    row: dict[str, float | str] = {}
    for item in study.collect:
        row |= {path: number_at(summary, path) for path in (item.path, f"{item.path}_error")}
        name = item.path.partition(".")[0]
        if isinstance(part := summary.get(name), Mapping) and part.get("verdict"):
            row[f"{name}.verdict"] = part["verdict"]
    return row


def statistics(values: ArrayLike, errors: ArrayLike, confidence: float) -> dict[str, float]:
    """`STATISTICS` of one number over members; NaN values are left out.

    The interval is that of Student's t with n - 1 degrees of freedom. For right errors of single runs with k degrees
    of freedom chi2 is k/(k - 2).
    """
    known = np.isfinite(np.asarray(values, float))
    x, own = np.asarray(values, float)[known], np.asarray(errors, float)[known]
    n, mean = len(x), x.mean() if len(x) else nan
    sd = x.std(ddof=1) if n > 1 else nan
    se = sd / np.sqrt(n) if n > 1 else nan
    half = student(n - 1, 0.5 * (1 + confidence)) * se if n > 1 else nan
    stated = own[np.isfinite(own) & (own > 0)]
    chi2 = nan
    if n > 1 and len(stated) == n:
        chi2 = float(np.mean(((x - mean) / own) ** 2) * n / (n - 1))
    error = float(np.sqrt(np.mean(stated**2))) if len(stated) else nan
    return dict(zip(STATISTICS, map(float, (mean, sd, se, mean - half, mean + half, n, error, chi2)), strict=True))


def mean_of(values: Sequence[float | None]) -> tuple[float, float]:
    """Mean over starts and half of its 95 % interval (Student's t); values that are NaN or None are left out."""
    known = np.array([nan if value is None else value for value in values], float)
    statistics_of = statistics(known, np.full(len(known), nan), 0.95)
    return statistics_of["mean"], statistics_of["high"] - statistics_of["mean"]


def table_of(study: Study, values: pd.DataFrame) -> xr.Dataset:
    """The statistics of every point.

    Parameters
    ----------
    study : Study
    values : DataFrame
        A row for each member that is done: ``point`` and the columns of `row_of`.

    Returns
    -------
    xarray.Dataset
        Dimensions are the axes, and ``statistic``; one variable for each collected number. ``members`` is the number
        of runs that are done, ``verdicts`` their results, in words.
    """
    import xarray as xr  # 0.3 s

    groups = [values[values["point"] == point] for point in range(len(study.points))]
    names = [axis.name for axis in study.axes]
    coordinates: dict[str, Any] = {"statistic": list(STATISTICS)}
    for axis in study.axes:
        coordinates |= {path: (axis.name, _coordinate(column)) for path, column in axis.columns.items()}
    data: dict[str, Any] = {}
    for item in study.collect:
        pairs = ((group[item.path], group[f"{item.path}_error"]) for group in groups)
        rows = [[*statistics(*pair, study.fields.confidence).values()] for pair in pairs]
        array = np.array(rows).reshape(*study.shape, len(STATISTICS))
        data[item.path] = ([*names, "statistic"], array, {"units": item.unit, "long_name": item.meaning})
    data["members"] = (names, np.array([len(group) for group in groups]).reshape(study.shape))
    data["verdicts"] = (names, np.array([kinds(group) for group in groups], dtype=object).reshape(study.shape))
    return xr.Dataset(data, coordinates, {"confidence": study.fields.confidence})


def records(table: xr.Dataset, path: str) -> list[dict[str, float]]:
    """`STATISTICS` of one number at each point, by name."""
    cells = table[path].values.reshape(-1, len(STATISTICS)).tolist()
    return [dict(zip(STATISTICS, cell, strict=True)) for cell in cells]


def _coordinate(values: Sequence[Any]) -> list[Any]:
    """Numbers as they are; else texts."""
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    return list(values) if numbers else [value if isinstance(value, str) else str(value) for value in values]


def kinds(group: pd.DataFrame) -> str:
    """Kinds of result of the members of a point, with number: ``jump 5, marginal jump 3``; or empty."""
    said = []
    for name in (column for column in group if column.endswith(".verdict")):
        counts = group[name].fillna("none").value_counts()
        said.append(", ".join(f"{word} {count}" for word, count in counts.items()))
    return "; ".join(filter(None, said))


def flat(table: xr.Dataset, study: Study) -> pd.DataFrame:
    """The table as rows, one a point: values of the axes, ``<path>`` and ``<path>_<statistic>`` of each number."""
    cells: dict[str, Any] = {}
    for item in study.collect:
        for name, values in zip(STATISTICS, table[item.path].values.reshape(-1, len(STATISTICS)).T, strict=True):
            column = item.path if name == "mean" else f"{item.path}_{name}"
            cells[column] = values.astype(int) if name == "n" else values
    cells |= {name: table[name].values.ravel() for name in ("members", "verdicts")}
    return pd.concat([pd.DataFrame(study.points), pd.DataFrame(cells)], axis=1)


FIRST = 4
"""Members from which the table first tells the width of an interval."""


def members_needed(numbers: Mapping[str, float], share: float) -> int | None:
    """Members for which the interval would be within ± `share` of the mean; None where that is unknown.

    The half width goes with one over the root of the members. Without an interval it is `FIRST`.
    """
    half, target = numbers["high"] - numbers["mean"], share * abs(numbers["mean"])
    if not isfinite(half):
        return FIRST
    if not target > 0:
        return None
    return max(2, ceil(numbers["n"] * (half / target) ** 2)) if half > target else int(numbers["n"])
