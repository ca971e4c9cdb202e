# SPDX-License-Identifier: GPL-2.0-or-later
"""Errors of benchmark settings: against an exact answer where there is one, else against a converged ensemble.

A setting is run from several slightly moved starts. Its error is the distance between the mean of its ensemble and
that of the reference (the finest step), over the size of the latter. For a curve it is the root mean square along it.
The *floor* is the distance that scatter alone gives two equal ensembles: sqrt(s^2/n + s_ref^2/n_ref). Errors below it
cannot be told from zero. An energy box has an exact answer, no deviation. Its error is the median over the starts of
the largest deviation, and its floor is 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np
import pandas as pd

from lammps_jump.analysis.profiles import read_profiles
from lammps_jump.dump.find import read_forces
from lammps_jump.sweeps import Made
from lammps_jump.sweeps.store import Results

EXACT = {"energy deviation": 0.0}
"""Quantities whose true value is known."""

Value = float | list[float] | None


class QuantityError(NamedTuple):
    """Error of one quantity; None where it cannot be told.

    Attributes
    ----------
    error, floor, scatter : float or None
        Shares of the size of the quantity; `scatter` is that of a single run.
    value : float or None
        Mean, for single numbers.
    """

    error: float | None = None
    floor: float | None = None
    scatter: float | None = None
    value: float | None = None


def quantity_error(name: str, members: Sequence[Value], reference: Sequence[Value] | None) -> QuantityError:
    """Return error, floor and single-run scatter of one quantity, as shares of its size.

    Parameters
    ----------
    name : str
    members, reference : sequence of float or of list of float
        One value or curve a run; None values (nothing measured) are left out.
    """
    curves = [[np.atleast_1d(one) for one in side or () if one is not None] for side in (members, reference)]
    if name in EXACT and curves[0]:
        values = np.abs(np.concatenate(curves[0]) - EXACT[name])
        spread = float(values.std(ddof=1)) if len(values) > 1 else None
        return QuantityError(float(np.median(values)), 0.0, spread, float(np.median(values)))
    points = min((len(curve) for side in curves for curve in side), default=0)
    ours, theirs = (np.array([curve[:points] for curve in side], float) for side in curves)
    mean = theirs.mean(axis=0) if len(theirs) else np.zeros(1)
    size = _root_mean_square(mean)
    if size == 0 or not len(ours):
        return QuantityError()
    floor = scatter = None
    if len(ours) > 1 and len(theirs) > 1:
        one, two = ours.var(axis=0, ddof=1), theirs.var(axis=0, ddof=1)
        floor = float(np.sqrt(np.mean(one / len(ours) + two / len(theirs)))) / size
        scatter = float(np.sqrt(np.mean(one))) / size
    value = float(ours.mean()) if points == 1 else None
    return QuantityError(_root_mean_square(ours.mean(axis=0) - mean) / size, floor, scatter, value)


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


CURVE_POINTS = 20


def measure(run: Made) -> dict[str, Value]:
    """Return the numbers and curves of a run that its case asks for; none of a run that is not complete."""
    found: dict[str, Value] = {}
    summary, folder = run.summary, run.folder
    if energy := summary.get("energy"):
        found["energy deviation"] = energy["max_deviation"]
    if summary.get("front"):
        table = pd.read_csv(folder / "front.csv")
        times = np.linspace(0.1, 1.0, CURVE_POINTS) * summary["simulated_time"]
        found["front position"] = np.interp(times, table["time"], table["quantile"]).tolist()
        found["column height"] = np.interp(times, table["time"], table["height"]).tolist()
    if jump := summary.get("jump"):
        depth = read_profiles(folder / "profiles.nc")["mass_depth_mean"].values
        found["depth profile"] = np.nan_to_num(depth, posinf=0.0, neginf=0.0).tolist()
        found |= {"sequent depth": jump["y2"], "shock speed": jump["speed"]}
    for name, force in read_forces(folder / "forces.csv").items() if summary.get("force") else ():
        step = float(np.median(np.diff(force.time)))
        found[f"impulse {name}"] = float(np.hypot(force.fx.sum(), force.fy.sum())) * step
    return found


def names_of(runs: Iterable[Mapping[str, Value]]) -> list[str]:
    """Return the quantities that some run measured, in order."""
    return list(dict.fromkeys(name for run in runs for name, value in run.items() if value is not None))


def setting_errors(
    runs: Sequence[Mapping[str, Value]], reference: Sequence[Mapping[str, Value]]
) -> dict[str, QuantityError]:
    """Return `quantity_error` of every quantity of a setting's runs."""
    return {
        name: quantity_error(name, *([measures.get(name) for measures in side] for side in (runs, reference)))
        for name in names_of([*runs, *reference])
    }


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Return the indices of the points (time, error) that no other beats in both, from fast to slow."""
    errors = pd.DataFrame(points, columns=["time", "error"]).sort_values(["time", "error"]).error
    return errors.index[errors < errors.cummin().shift(fill_value=inf)].tolist()


def cheapest(rows: Sequence[Results], quantity: str, accuracy: float) -> Results | None:
    """Return the quickest row whose error and floor in `quantity` are within `accuracy`; None where there is none.

    Rows with another stiffness or disc size are other flows and are not chosen.
    """
    good = [
        row for row in rows
        if row["setting"].get("penetration") is None and row["setting"].get("diameter") is None
        and row["errors"][quantity]["error"] <= accuracy and (row["errors"][quantity]["floor"] or 0.0) <= accuracy
    ]  # fmt: skip
    return min(good, key=lambda row: row["seconds"], default=None)
