# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of an inflow of discs that carry the discharge asked for: heights, speeds and intervals in whole steps.

The thesis (4.1-4.2) fills the depth with touching rows and lets a disc follow at 1.02 diameters. Rows so close drag
each other: 3 % of the discs are refused, and intervals in whole steps lose more. Here there are more rows. The discs of
a row are `LEAST_GAP` or more apart, none is refused, and the mass depth is the depth asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from .elementary import power

LEAST_GAP = 1.10
"""Least distance of followers in a row, in largest diameters."""
REFUSAL_GAP = 1.05
"""Distance of followers, in largest diameters, below which places of some are still occupied (measured)."""
THESIS_GAP = 1.02
"""Distance of followers in a row of the thesis, in diameters."""
ROUNDING = REFUSAL_GAP / LEAST_GAP
"""Share of the least gap that rounding to a raster of steps may leave."""
COARSEST_RASTER = 8
"""Steps of the first raster tried; a finer one where discharge or gaps would be off."""
LARGEST_ERROR = 1e-3
"""Relative error of the planned discharge that a raster coarser than a step may have: less than what is told."""
EXACT = 2e-4
"""Relative error of the planned discharge at which no interval is changed any more."""

SHIFT = 1e-6
"""Largest relative change of a row's speed by the seed of a run."""

Change = tuple[float, tuple[tuple[int, int], ...]]
"""Gain of a change of intervals, and the rows that change by so many ticks."""


@dataclass(frozen=True)
class RowPlan:
    """Rows of an inflow, from the bed upward.

    Attributes
    ----------
    heights, speeds : tuple of float
        m above the bed, m/s.
    steps : tuple of int
        Steps from one disc of the row to the next; multiples of `raster`.
    raster : int
    discharge : float
        What the rows carry as planned, m^2/s.
    """

    heights: tuple[float, ...]
    speeds: tuple[float, ...]
    steps: tuple[int, ...]
    raster: int
    discharge: float


def row_count(depth: float, mean_square: float, largest: float, least_gap: float = LEAST_GAP) -> int:
    """Rows of an inflow: K = ceil(g y1 D / a), with the least gap g, the largest diameter D and a = mean of d^2.

    K rows of discs at a distance of K a / y1 >= g D have the mass depth y1.
    """
    return max(1, ceil(least_gap * depth * largest / mean_square - 1e-9))


def row_speeds(rows: int, mean_speed: float, profile: str = "power_law") -> tuple[float, ...]:
    """Speed of each row, m/s; their mean is Va.

    Parameters
    ----------
    rows : int
    mean_speed : float
        Va, m/s.
    profile : {'power_law', 'uniform'}
        ``v_i`` in the ratio of ``((i + 1/2)/K)^(1/7)`` (thesis 4.1-4.2), or Va in every row.

    Raises
    ------
    ValueError
        Unknown profile.
    """
    if profile not in ("power_law", "uniform"):
        raise ValueError(f"row_speeds: unknown profile {profile!r}; use 'power_law' or 'uniform'")
    exponent = 1.0 / 7.0 if profile == "power_law" else 0.0
    shares = [power((i + 0.5) / rows, exponent) for i in range(rows)]
    return tuple(mean_speed * rows * share / sum(shares) for share in shares)


def seeded_speeds(speeds: tuple[float, ...], seed: int) -> tuple[float, ...]:
    """The speeds times 1 + `SHIFT` r, r uniform in [-1, 1) and drawn with the seed; seed 0 leaves them as they are.

    Collisions make a flow of it that differs within a second: runs with other seeds are other samples.
    """
    return tuple(speed * factor for speed, factor in zip(speeds, seed_factors(len(speeds), seed), strict=True))


def seed_factors(rows: int, seed: int) -> tuple[float, ...]:
    """Factors by which `seeded_speeds` multiplies the speed of each row."""
    draws = np.random.default_rng(seed).uniform(-1.0, 1.0, rows) if seed else np.zeros(rows)
    return tuple(1.0 + SHIFT * float(draw) for draw in draws)


def whole_intervals(ideal: np.ndarray, wanted: float) -> np.ndarray:
    """Whole numbers near `ideal`, each within 1 of it, whose reciprocals add up to `wanted` as nearly as found.

    Begins with the rounded numbers. Then it changes one number by 1, or two against each other, whichever helps most,
    until the relative error is below `EXACT` or nothing helps.
    """
    n = np.maximum(1, np.rint(ideal)).astype(np.int64)
    for _ in range(4 * len(n)):
        missing = wanted - float(np.sum(1.0 / n))
        if abs(missing) < EXACT * wanted:
            break
        # gain of each permitted change: fewer steps carry more, more steps less
        rows = np.arange(len(n))
        fewer = rows[(n > 1) & (np.abs(n - 1 - ideal) <= 1)]
        more = rows[np.abs(n + 1 - ideal) <= 1]
        up, down = 1.0 / (n[fewer] - 1) - 1.0 / n[fewer], 1.0 / (n[more] + 1) - 1.0 / n[more]
        changes: list[Change] = [(gain, ((row, -1),)) for gain, row in zip(up, fewer, strict=True)]
        changes += [(loss, ((row, 1),)) for loss, row in zip(down, more, strict=True)]
        order = np.argsort(down)
        for gain, row in zip(up, fewer, strict=True):
            place = np.searchsorted(down[order], missing - gain)
            for other in order[max(0, place - 1) : place + 1]:
                if more[other] != row:
                    changes.append((gain + down[other], ((row, -1), (more[other], 1))))
        best = min(changes, key=lambda change: abs(missing - change[0]), default=(0.0, ()))
        if abs(missing - best[0]) >= abs(missing):
            break
        for row, change in best[1]:
            n[row] += change
    return n


def thesis_rows(
    depth: float, diameter: float, mean_speed: float, time_step: float, *, profile: str = "power_law"
) -> RowPlan:
    """Rows of the thesis (4.1-4.2): as many as the depth holds, a disc every `THESIS_GAP` diameters.

    Speeds are (8/7) Va (y_i/y1)^(1/7) at the row centres, or Va; intervals are rounded up to whole steps. They carry
    up to 3 % less than Va y1, and lose 3 % more where discs are refused.

    Parameters
    ----------
    depth, diameter, mean_speed, time_step : float
        y1 (m), d (m), Va (m/s), s.
    profile : {'power_law', 'uniform'}
    """
    heights = tuple((i + 0.5) * diameter for i in range(floor(depth / diameter + 1e-9)))  # 0.6 / 0.2 is below 3
    speeds = tuple(
        mean_speed * (8.0 / 7.0 * power(y / depth, 1.0 / 7.0) if profile == "power_law" else 1.0) for y in heights
    )
    steps = tuple(max(1, ceil(THESIS_GAP * diameter / (speed * time_step) - 1e-9)) for speed in speeds)
    return RowPlan(heights, speeds, steps, 1, sum(diameter * diameter / (n * time_step) for n in steps))


def plan_rows(
    depth: float,
    mean_speed: float,
    time_step: float,
    *,
    mean_square: float,
    largest: float,
    profile: str = "power_law",
    least_gap: float = LEAST_GAP,
    coarsest: int = 1,
) -> RowPlan:
    """Rows of an inflow that carry ``mean_speed * depth`` with the mass depth `depth`.

    Parameters
    ----------
    depth, mean_speed, time_step : float
        y1 (m), Va (m/s), s.
    mean_square : float
        Mean of the squared diameter, m^2; d^2 of equal discs.
    largest : float
        Largest diameter, m: the distance of the rows.
    profile : {'power_law', 'uniform'}
    least_gap : float
        Least distance of followers in a row, in largest diameters.
    coarsest : int
        Coarsest raster of the intervals, steps; one less until the discharge is within `LARGEST_ERROR` and every gap is
        wide enough.
    """
    rows = row_count(depth, mean_square, largest, least_gap)
    speeds = row_speeds(rows, mean_speed, profile)
    gap = rows * mean_square / depth
    raster = coarsest
    while True:
        tick = raster * time_step
        ideal = gap / (np.array(speeds) * tick)
        intervals = whole_intervals(ideal, mean_speed * depth * tick / mean_square)
        discharge = float(np.sum(mean_square / (intervals * tick)))
        narrowest = float(np.min(intervals * tick * speeds))
        error = abs(discharge / (mean_speed * depth) - 1.0)
        if raster == 1 or (error < LARGEST_ERROR and narrowest > ROUNDING * least_gap * largest):
            break
        raster -= 1
    heights = tuple((i + 0.5) * largest for i in range(rows))
    return RowPlan(heights, speeds, tuple(int(n) * raster for n in intervals), raster, discharge)
