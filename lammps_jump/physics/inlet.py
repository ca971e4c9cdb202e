# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of an inflow of discs that carry the requested discharge, steady or against time.

The thesis (4.1-4.2) fills the depth with touching rows and lets a disc follow at 1.02 diameters. Rows so close drag
each other: 3 % of the discs are refused, and intervals in whole steps lose more. Here there are more rows. The discs of
a row are `LEAST_GAP` or more apart, none is refused, and the mass depth is the requested depth.

Between two rows of the table depth h and speed u are linear in time, so that the discharge h u is a parabola and what
came in, its integral, a cubic. At a depth h there are K rows as in a steady inflow (`inlet.row_count`), and row i
carries the share w_i of the discharge. Its phase is the integral of w_i h u / a, with the mean square a of a diameter:
the number of discs that it owes. Disc k enters where the phase is k + 1/2, so that a row is never off by more than half
a disc, whatever the table does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

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
"""Relative error of the planned discharge that a raster coarser than a step may have: less than is reported."""
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
    """Whole numbers near `ideal`, each within 1 of it, whose reciprocals add up to nearly `wanted`.

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


# --- an inflow against time: depth and mean speed in straight lines, and when the discs of each row enter -------------


TRAVEL = 10.0
"""Depths that the stream runs in the time over which `Hydrograph.leap` looks at its speed."""
HALVINGS = 60
"""Of an interval of time, to find when a volume has come in: what is left is round-off."""


@dataclass(frozen=True)
class Hydrograph:
    """Depth (m) and mean speed (m/s) at times (s) that grow; linear between, constant before the first and after.

    Attributes
    ----------
    times, depths, speeds : tuple of float
    """

    times: tuple[float, ...]
    depths: tuple[float, ...]
    speeds: tuple[float, ...]

    @property
    def changes(self) -> bool:
        """Tells whether it is not the same at all times."""
        return len(set(self.depths)) > 1 or len(set(self.speeds)) > 1

    def depth(self, time: ArrayLike) -> np.ndarray:
        """Depth at a time (s, one or many), m."""
        return np.interp(np.asarray(time, float), self.times, self.depths)

    def speed(self, time: ArrayLike) -> np.ndarray:
        """Mean speed at a time (s, one or many), m/s."""
        return np.interp(np.asarray(time, float), self.times, self.speeds)

    @cached_property
    def _sums(self) -> tuple[np.ndarray, np.ndarray]:
        """Integrals of depth (m s) and of discharge (m^2) from the first row to each row."""
        t, h, u = (np.array(column) for column in (self.times, self.depths, self.speeds))
        sums = np.zeros((2, len(t)))
        sums[0, 1:] = np.cumsum(np.diff(t) * 0.5 * (h[1:] + h[:-1]))
        sums[1, 1:] = np.cumsum(np.diff(t) * _parabola(h[:-1], h[1:], u[:-1], u[1:]))
        return sums[0], sums[1]

    @property
    def rise(self) -> float:
        """Largest ratio of a speed to a lower one before it; 1 where the speed never grows."""
        speeds = np.array(self.speeds)
        return float(np.max(speeds / np.minimum.accumulate(speeds)))

    @property
    def leap(self) -> tuple[float, float]:
        """Largest ratio of a speed to that `TRAVEL` depths of the stream before, and the time of the lower one, s."""
        depth = max(self.depths)
        leaps = [
            (float(self.speed(time + TRAVEL * depth / speed)) / speed, time)
            for time, speed in zip(self.times, self.speeds, strict=True)
        ]
        return max(leaps, key=lambda one: one[0])

    def least_gap(self, asked: float) -> float:
        """Least distance of followers in a row, in largest diameters: `asked`, or more where the speed grows.

        Fast discs run into slower ones before them and push them. Where equal masses of speeds v and r v have met they
        run at v (1 + r)/2. A disc of speed r v finds its place free behind them if a row leaves it
        2 r/(1 + r) times the room that it needs.
        """
        return max(asked, REFUSAL_GAP * 2.0 * self.rise / (1.0 + self.rise))

    def integrals(self, time: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Integrals of depth (m s) and of discharge (m^2) from the first row to a time (s, one or many)."""
        t, time = np.array(self.times), np.asarray(time, float)
        row = np.clip(np.searchsorted(t, time, "right") - 1, 0, None)
        past, h0, u0 = time - t[row], np.array(self.depths)[row], np.array(self.speeds)[row]
        h1, u1 = self.depth(time), self.speed(time)
        filled, carried = self._sums
        return filled[row] + past * 0.5 * (h0 + h1), carried[row] + past * _parabola(h0, h1, u0, u1)

    def means(self, begin: float, end: float) -> tuple[float, float]:
        """Means of depth (m) and discharge (m^2/s) from one time to another, s; of no time the values then."""
        if end <= begin:
            depth = float(self.depth(begin))
            return depth, depth * float(self.speed(begin))
        filled, carried = self.integrals(np.array([begin, end]))
        return float(filled[1] - filled[0]) / (end - begin), float(carried[1] - carried[0]) / (end - begin)

    def _times_of(self, carried: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Times between `low` and `high` (s) until which so much (m^2) has come in; shapes (n,)."""
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            late = self.integrals(middle)[1] >= carried
            low, high = np.where(late, low, middle), np.where(late, middle, high)
        return high


def _parabola(h0: np.ndarray, h1: np.ndarray, u0: np.ndarray, u1: np.ndarray) -> np.ndarray:
    """Mean of the product of two straight lines."""
    return (2 * h0 * u0 + h0 * u1 + h1 * u0 + 2 * h1 * u1) / 6


class RowEntries(NamedTuple):
    """Times at which the discs of a row enter (s), and speeds over the mean speed of that time; shapes (discs,)."""

    times: np.ndarray
    relative: np.ndarray


def entries_of_rows(
    graph: Hydrograph,
    duration: float,
    *,
    mean_square: float,
    largest: float,
    profile: str = "power_law",
    least_gap: float = LEAST_GAP,
) -> list[RowEntries]:
    """Entries of each row from t = 0 on, from the bed upward; arguments as of `inlet.plan_rows`.

    Row i of K has the speed u K w_i with w_i in the ratio of (i + 1/2)^(1/7), as in a steady inflow. Discs of a row are
    K a / h apart when they enter, `Hydrograph.least_gap` or more.
    """
    least_gap = graph.least_gap(least_gap)
    ends = _pieces(graph, duration, mean_square / (least_gap * largest))
    middle = graph.depth(0.5 * (ends[1:] + ends[:-1]))
    rows = np.array([row_count(h, mean_square, largest, least_gap) if h > 0 else 0 for h in middle])
    carried = graph.integrals(ends)[1]
    most = int(rows.max(initial=0))
    shape = np.array([power(i + 0.5, 1.0 / 7.0 if profile == "power_law" else 0.0) for i in range(most)])
    whole = np.append(np.inf, np.cumsum(shape))  # no row carries anything where there are none
    row_entries = []
    for row in range(most):
        share = np.where(rows > row, shape[row] / whole[rows], 0.0)
        phase = np.append(0.0, np.cumsum(share * np.diff(carried) / mean_square))
        owed = np.arange(floor(phase[-1] + 0.5)) + 0.5
        piece = np.searchsorted(phase, owed) - 1
        wanted = carried[piece] + (owed - phase[piece]) * mean_square / share[piece]
        times = graph._times_of(wanted, ends[piece], ends[piece + 1])
        row_entries.append(RowEntries(times, rows[piece] * share[piece]))
    return row_entries


def _pieces(graph: Hydrograph, duration: float, layer: float) -> np.ndarray:
    """Times (s) between which the number of rows, each `layer` deep, stays and depth and speed are straight lines."""
    inner = [t for t in graph.times if 0 < t < duration]
    ends = np.array([0.0, *inner, duration])
    depths, pieces = graph.depth(ends), [ends]
    for t0, t1, h0, h1 in zip(ends[:-1], ends[1:], depths[:-1], depths[1:], strict=True):
        low, high = sorted((h0, h1))
        levels = layer * np.arange(floor(low / layer) + 1, floor(high / layer) + 1)
        pieces.append(t0 + (t1 - t0) * (levels - h0) / (h1 - h0 or 1.0))
    return np.unique(np.concatenate(pieces))
