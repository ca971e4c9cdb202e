# SPDX-License-Identifier: GPL-2.0-or-later
"""Further numbers of the case that move a measurement which no run reaches, by runs that change one of them.

The runs are at the point that is nearest to the measurements, with starts of their own, and count to the budget. What
a change does is taken along the gap between the measurement and the runs of that point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case.discs import GradingCurve
from lammps_jump.errors import CaseError, DumpError, JumpError
from lammps_jump.sweeps import Pool, Start, plan, run_starts

from .model import Model, TargetPart
from .study import Calibration

BESIDES = "besides"
"""Folder of these runs."""
NUMBERS: dict[str, tuple[float, float]] = {
    "contact.friction": (0.05, 0.9),
    "contact.rolling.friction": (0.0, 0.4),
    "contact.restitution": (0.05, 0.95),
    "discs.sizes.spread": (0.0, 0.4),
    "slope": (-5.0, 5.0),
}
"""Numbers that are tried, and the range that they have in grains and flows."""
RELATIVE = ("inflow.depth", "inflow.mean_speed", "inflow.discharge", "discs.density", "discs.diameter")
"""Numbers that are tried at a part more of what the case has."""
MORE = 1.25
STEP = 0.5
"""Part of the way to the farther end of its range by which a number is changed."""
SURE = 2.0
"""Standard errors above which an effect is one."""
LISTED = 3
"""Numbers that are listed for each target."""


@dataclass(frozen=True)
class Change:
    """A number of the case that is changed at the nearest point.

    Attributes
    ----------
    path : str
    before, after : float
    """

    path: str
    before: float
    after: float


def changes_of(study: Calibration, values: Mapping[str, float]) -> list[Change]:
    """Changes that can be tried, at the point that has these values: fields that the case has, and that stay a case."""
    case = study.case.replace(dict(values))
    curve = isinstance(case.fields.discs.sizes, GradingCurve)  # its sizes are no multiples of the nominal one
    changes = []
    for path in (*NUMBERS, *RELATIVE):
        if path in study.vary or (curve and path == "discs.diameter"):
            continue
        if (before := _number_at(case.fields, path)) is None:
            continue
        if path in RELATIVE:
            after = MORE * before
        else:
            low, high = NUMBERS[path]
            end = low if before - low > high - before else high
            after = before + STEP * (end - before)
        change = Change(path, before, float(f"{after:z.3g}"))
        if change.after != before and _can_be_run(study, values, change):
            changes.append(change)
    return changes


def _number_at(fields: object, path: str) -> float | None:
    """The number of a field; None where the case has none there, or another kind of value."""
    value: Any = fields
    for name in path.split("."):
        value = getattr(value, name, None)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _can_be_run(study: Calibration, values: Mapping[str, float], change: Change) -> bool:
    try:
        plan(study.case, [Start(0, {**values, change.path: change.after}, 1)], {})
    except JumpError:
        return False
    return True


@dataclass(frozen=True)
class NearestEffects:
    """Result of the runs that change one further number at the nearest point.

    Attributes
    ----------
    changes : tuple of Change
        Those that were tried.
    left : tuple of Change
        Those for which no runs were left.
    values : dict of str to ndarray, shape (changes, starts, k)
        Of each target, NaN where a run has none.
    runs : int
    """

    changes: tuple[Change, ...]
    left: tuple[Change, ...]
    values: Mapping[str, np.ndarray]
    runs: int


def look_besides(
    study: Calibration, values: Mapping[str, float], folder: Path, pool: Pool, *, used: int, first_seed: int
) -> NearestEffects:
    """Run the changes at a point, as many as the budget has room for.

    Parameters
    ----------
    study : Calibration
    values : mapping
        Of the nearest point.
    folder : Path
        Of the calibration.
    pool : Pool
    used : int
        Runs of the budget that are used.
    first_seed : int
        Of their starts.
    """
    possible = changes_of(study, values)
    count = max(0, min(len(possible), (study.budget - used) // study.members))
    starts = [
        Start(number, {**values, change.path: change.after}, first_seed + number * study.members + k)
        for number, change in enumerate(possible[:count])
        for k in range(study.members)
    ]
    seen = {one.name: np.full((count, study.members, len(one.measured)), np.nan) for one in study.targets}
    for place, made in enumerate(run_starts(study.case, starts, folder / BESIDES, pool) if starts else []):
        number, k = divmod(place, study.members)
        for target in study.targets:
            try:
                seen[target.name][number, k] = target.of_run(made.folder, made.summary) if made.summary else np.nan
            except (CaseError, DumpError):  # a table that this run has not, or a damaged one: nothing is known of it
                continue
    return NearestEffects(tuple(possible[:count]), tuple(possible[count:]), seen, len(starts))


def movers(model: Model, part: TargetPart, near: int, besides: NearestEffects) -> list[dict[str, Any]]:
    """The changes that move a target along its gap, those that close most of it first.

    Each has ``path``, ``before``, ``after``; ``closes``, the part of the gap that the change takes away, below 0 where
    it widens it; of a number also ``from_value`` and ``to_value``.

    Parameters
    ----------
    model : Model
    part : TargetPart
        Of the target.
    near : int
        The point at which the changes were made, among those of the model.
    besides : Besides
    """
    number = [one.target.name for one in model.parts].index(part.target.name)
    base = model.values[number][near]
    starts = int(np.isfinite(base).all(axis=1).sum())
    kept = besides.values[part.target.name][..., part.kept]
    gap = part.target.measured - np.nanmean(base, axis=0)
    size = float(np.linalg.norm(gap))
    along = gap / size if size else np.ones(len(gap)) / np.sqrt(len(gap))
    scatter = float(np.sum(np.abs(along) * np.nan_to_num(part.scatter)))  # as if all points went together
    moving = []
    for change, values in zip(besides.changes, kept, strict=True):
        some = np.isfinite(values).all(axis=1)
        if not some.any() or not size:
            continue
        mean = values[some].mean(axis=0)
        moved = float(along @ (mean - np.nanmean(base, axis=0)))
        if abs(moved) <= SURE * scatter * np.sqrt(1 / starts + 1 / some.sum()):
            continue
        one: dict[str, Any] = {
            "path": change.path,
            "before": change.before,
            "after": change.after,
            "closes": moved / size,
        }
        if not part.target.axis:
            one |= {"from_value": float(np.nanmean(base)), "to_value": float(mean[0])}
        moving.append(one)
    return sorted(moving, key=lambda one: -abs(one["closes"]))[:LISTED]


def tried(besides: NearestEffects | None) -> dict[str, Sequence[str]]:
    """Paths that were tried, and those that were not, as plain data."""
    if besides is None:
        return {"tried": [], "left": []}
    return {"tried": [one.path for one in besides.changes], "left": [one.path for one in besides.left]}
