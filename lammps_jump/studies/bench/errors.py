"""Errors of benchmark settings: against an exact answer where there is one, else against a converged ensemble.

A setting is run from several slightly moved starts. Its error in a quantity is the distance of its ensemble's mean from
the mean of the reference's (the finest step), over its size; of a curve, the root mean square along it.
What the two ensembles' own scatter would give by chance alone, were the two equal, is the *floor*: sqrt(s^2/n +
s_ref^2/n_ref). Below it nothing can be told apart. An energy box has an exact answer, no deviation; the error is the
median over the starts of the largest one, its floor is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

EXACT = {"energy deviation": 0.0}
"""Quantities whose true value is known."""


def curve_length(members: Sequence[Any]) -> int:
    """Shortest length among lists of numbers."""
    return min(len(member) for member in members)


def _stack(members: Sequence[Any]) -> np.ndarray:
    """Members as an array of shape (members, points)."""
    if isinstance(members[0], list):
        points = curve_length(members)
        return np.array([member[:points] for member in members], float)
    return np.array(members, float)[:, None]


def quantity_error(name: str, members: Sequence[Any], reference: Sequence[Any] | None) -> dict[str, float | None]:
    """Error, floor and single-run scatter of one quantity, as shares of its size.

    Parameters
    ----------
    name : str
    members, reference : sequence of float or of list of float
        One value or curve a run; None values (nothing measured) are left out.

    Returns
    -------
    dict
        error, floor, scatter, value (mean, for single numbers); None where it cannot be told.
    """
    members = [member for member in members if member is not None]
    nothing = {"error": None, "floor": None, "scatter": None, "value": None}
    if not members:
        return nothing
    if name in EXACT:
        values = np.abs(np.array(members, float) - EXACT[name])
        spread = float(values.std(ddof=1)) if len(values) > 1 else None
        return {"error": float(np.median(values)), "floor": 0.0, "scatter": spread, "value": float(np.median(values))}
    reference = [member for member in reference or () if member is not None]
    if not reference:
        return nothing
    ours, theirs = _stack(members), _stack(reference)
    points = min(ours.shape[1], theirs.shape[1])
    ours, theirs = ours[:, :points], theirs[:, :points]
    mean = theirs.mean(axis=0)
    size = float(np.sqrt(np.mean(mean**2)))
    if size == 0:
        return nothing
    error = float(np.sqrt(np.mean((ours.mean(axis=0) - mean) ** 2))) / size
    floor = scatter = None
    if len(ours) > 1 and len(theirs) > 1:
        one, two = ours.var(axis=0, ddof=1), theirs.var(axis=0, ddof=1)
        floor = float(np.sqrt(np.mean(one / len(ours) + two / len(theirs)))) / size
        scatter = float(np.sqrt(np.mean(one))) / size
    value = float(ours.mean()) if points == 1 else None
    return {"error": error, "floor": floor, "scatter": scatter, "value": value}


def names_of(runs: Sequence[dict[str, Any]]) -> list[str]:
    """Quantities that some run measured, in order; words such as a verdict are no quantities."""
    found: dict[str, None] = {}
    for run in runs:
        for name, value in run.get("measures", {}).items():
            if isinstance(value, int | float | list):
                found[name] = None
    return list(found)


def setting_errors(
    runs: Sequence[dict[str, Any]], reference: Sequence[dict[str, Any]]
) -> dict[str, dict[str, float | None]]:
    """`quantity_error` of every quantity of a setting's runs."""

    def members(source, name):
        return [run["measures"].get(name) for run in source if run["status"] == "complete"]

    return {
        name: quantity_error(name, members(runs, name), members(reference, name))
        for name in names_of([*runs, *reference])
    }


def pareto(points: Sequence[tuple[float, float]]) -> list[int]:
    """Indices of the points (time, error) that no other beats in both, from fast to slow."""
    order = sorted(range(len(points)), key=lambda i: points[i])
    best, front = float("inf"), []
    for i in order:
        if points[i][1] < best:
            best = points[i][1]
            front.append(i)
    return front


def cheapest(rows: Sequence[dict[str, Any]], quantity: str, accuracy: float) -> dict[str, Any] | None:
    """The quickest row whose error in `quantity` is within `accuracy` and whose floor lets one say so; else None.

    Rows with another stiffness or disc size are other flows, whatever their error, and are not chosen.

    Parameters
    ----------
    rows : sequence of dict
        With ``seconds`` and ``errors``.
    """
    good = []
    for row in rows:
        entry, setting = row["errors"].get(quantity), row.get("setting") or {}
        if setting.get("penetration") is not None or setting.get("diameter") is not None:
            continue
        if not entry or entry["error"] is None or row["seconds"] is None:
            continue
        if entry["error"] <= accuracy and (entry["floor"] or 0.0) <= accuracy:
            good.append(row)
    return min(good, key=lambda row: row["seconds"], default=None)
