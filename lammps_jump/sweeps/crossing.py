# SPDX-License-Identifier: GPL-2.0-or-later
"""Search for the place at which a number that scatters comes to a value: bisection, regression, 95 % range.

Bisection by the means over starts finds a bracket with a part of the runs. The others are spread over a window around
it, and no value decides their places: a search that goes where the last value was near finds what it looks for. All
values near the window are fitted by a line or, with five places and more, by a parabola. The range is that of all
places at which the value lies within the 95 % band of the fit (Fieller 1954, "Some problems in interval estimation",
J. R. Stat. Soc. B 16, 175; of a parabola the same set).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.statistics import student

SHARE = 0.6
"""Most of the places that bisection takes; the others are spread over the window."""
WIDER = 1.5
"""Half of the window in widths of the bracket, and half of what the fit takes in halves of the window."""
CURVED = 5
"""Places from which on a parabola is fitted."""
FREEDOM = 4
"""Degrees of freedom from which on the scatter is that of places within the range alone."""
GRID = 4001
"""Places of the range at which the band is looked at."""


class CrossingPlace(NamedTuple):
    """Place where a number comes to a value, its 95 % range, and whether it rises there; NaN where it is not known."""

    value: float = nan
    low: float = nan
    high: float = nan
    rises: bool = True


class Bracketed(NamedTuple):
    """Two places next to each other with the number on either side; and whether it rises there."""

    low: float
    high: float
    rises: bool


class StartScatter(NamedTuple):
    """Standard deviation over starts, pooled over places, and the ends of its 95 % interval; 0 of single starts."""

    value: float = 0.0
    low: float = 0.0
    high: float = 0.0


def scatter_of(tried: Mapping[float, np.ndarray]) -> StartScatter:
    """Scatter over starts at the places that were tried; without the first two, ends of the range, where others tell.

    The interval is by the chi-squared distribution of the pooled variance.
    """
    from scipy.special import chdtri  # 0.1 s

    known = [np.asarray(y, float)[np.isfinite(y)] for y in tried.values()]
    inner = known[2:] if sum(len(y) - 1 for y in known[2:] if len(y)) >= FREEDOM else known
    free = sum(len(y) - 1 for y in inner if len(y) > 1)
    if not free:
        return StartScatter()
    squares = sum(float(np.sum((y - y.mean()) ** 2)) for y in inner if len(y) > 1)
    low, high = (float(np.sqrt(squares / chdtri(free, tail))) for tail in (0.025, 0.975))
    return StartScatter(float(np.sqrt(squares / free)), low, high)


def normal(share: float) -> float:
    """Standard deviations from the mean of a normal distribution below which a share of it lies."""
    from scipy.special import ndtri

    return float(ndtri(share))


class CrossingSearch:
    """A search for the place at which a number that scatters comes to a value.

    Parameters
    ----------
    number : float
    room : (float, float)
        Places that are looked at.
    most : int
        Places that may be tried, at least 3.
    """

    def __init__(self, number: float, room: tuple[float, float], most: int):
        self.number, self.room, self.most = number, room, max(most, 3)

    def _first(self, unit: Mapping[float, np.ndarray]) -> int:
        """Places that bisection takes: until the mean at one is not surely on one side, or its part is used."""
        most = max(3, round(SHARE * self.most))
        unsure = (k for k, y in enumerate(unit.values(), 1) if k > 2 and len(y) > 1 and not _sure(y))
        return min(next(unsure, most), most)

    def _unit(self, tried: Mapping[float, np.ndarray]) -> dict[float, np.ndarray]:
        """Places of the unit range, in their order, and what their values have over the number."""
        scale = self.room[1] - self.room[0]
        off = {(x - self.room[0]) / scale: np.asarray(y, float) - self.number for x, y in tried.items()}
        return {x: y[np.isfinite(y)] for x, y in off.items()}

    def next_place(self, tried: Mapping[float, np.ndarray]) -> float | None:
        """The place to try next, by the values at those tried, in their order; None where all have been tried."""
        if len(tried) >= self.most:
            return None
        unit = self._unit(tried)
        if len(unit) < 2:
            return self.room[len(unit)]
        first = self._first(unit)
        if len(unit) < first or not _scatter(unit):
            place = _halved(unit)
        else:
            low, high = _window(dict(list(unit.items())[:first]))
            spread = self.most - first
            left = np.linspace(low, high, spread)[_spread_order(spread)]
            place = float(left[len(unit) - first])
            while any(abs(place - there) < 1e-9 for there in unit):
                place += 1e-4 if place < 0.5 else -1e-4
        return self.room[0] + (self.room[1] - self.room[0]) * place

    def answer(self, tried: Mapping[float, np.ndarray]) -> CrossingPlace:
        """Place at which the values come to the number, and its range."""
        unit = {x: y for x, y in self._unit(tried).items() if y.size}
        bracket = _bracket(unit)
        if bracket is None:
            return CrossingPlace()
        if not _scatter(unit):
            root, low, high = _between(unit, bracket), bracket.low, bracket.high
            return CrossingPlace(self._place(root), self._place(low), self._place(high), bracket.rises)
        low, high = _window(dict(list(unit.items())[: self._first(unit)]))
        middle, half = 0.5 * (low + high), 0.5 * WIDER * (high - low)
        near = {x: y for x, y in unit.items() if abs(x - middle) <= half + 1e-12}
        crossed = _crossed(near, middle) if len(near) > 2 else None
        crossed = crossed or _crossed(unit, middle, straight=True)
        if crossed is None:
            return CrossingPlace()
        return CrossingPlace(
            self._place(crossed.value), self._place(crossed.low), self._place(crossed.high), crossed.rises
        )

    def _place(self, unit: float) -> float:
        return self.room[0] + (self.room[1] - self.room[0]) * unit


def _scatter(unit: Mapping[float, np.ndarray]) -> bool:
    """Tells whether starts differ; of single starts it is taken that they do."""
    values = [y for y in unit.values() if y.size]
    size = max((float(np.abs(y).max()) for y in values), default=0.0)
    return not any(len(y) > 1 for y in values) or any(float(np.ptp(y)) > 1e-9 * size for y in values if len(y) > 1)


def _means(unit: Mapping[float, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Places in their order and means there, of those that have a value."""
    known = sorted((x, float(y.mean())) for x, y in unit.items() if y.size)
    return np.array([x for x, _ in known]), np.array([y for _, y in known])


def _bracket(unit: Mapping[float, np.ndarray]) -> Bracketed | None:
    """The bracket; of several the middle one; None where all means are on one side."""
    x, y = _means(unit)
    changes = np.flatnonzero(np.sign(y[:-1]) * np.sign(y[1:]) <= 0)
    if not changes.size:
        return None
    k = int(changes[len(changes) // 2])
    return Bracketed(float(x[k]), float(x[k + 1]), bool(y[k + 1] > y[k]))


def _halved(unit: Mapping[float, np.ndarray]) -> float:
    """The middle of the bracket, or of the widest gap where there is none."""
    bracket, x = _bracket(unit), np.sort(np.array(list(unit)))
    if bracket is not None:  # places without a value may be in it
        x = x[(x >= bracket.low) & (x <= bracket.high)]
    widest = int(np.argmax(np.diff(x)))
    return float(0.5 * (x[widest] + x[widest + 1]))


def _between(unit: Mapping[float, np.ndarray], bracket: Bracketed) -> float:
    """Place in a bracket by a straight line."""
    low, high = (float(unit[place].mean()) for place in (bracket.low, bracket.high))
    return bracket.low + (bracket.high - bracket.low) * (low / (low - high) if low != high else 0.5)


def _window(unit: Mapping[float, np.ndarray]) -> tuple[float, float]:
    """Window around the bracket that results from bisection, within the range; all of it where there is none."""
    bracket = _bracket(unit)
    if bracket is None:
        return 0.0, 1.0
    middle, half = 0.5 * (bracket.low + bracket.high), WIDER * (bracket.high - bracket.low)
    half = min(half, 0.5)
    middle = min(max(middle, half), 1.0 - half)
    return middle - half, middle + half


def _spread_order(count: int) -> np.ndarray:
    """Order in which places of a row are tried: far apart first, so that a part of them covers the row too."""
    return np.array(sorted(range(count), key=lambda k: (int(f"{k:016b}"[::-1], 2), k)), int)


def _least_squares(x: np.ndarray, y: np.ndarray, at: np.ndarray, power: int) -> tuple[np.ndarray, np.ndarray, float]:
    middle = x.mean()
    matrix, there = (np.vander(one - middle, power + 1, increasing=True) for one in (x, at))
    solution, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    free = len(x) - power - 1
    value = there @ solution
    if free < 1:
        return value, np.full(len(at), np.inf), np.inf
    scatter = float(np.sqrt(np.sum((y - matrix @ solution) ** 2) / free))
    cover = np.linalg.pinv(matrix.T @ matrix)
    band = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", there, cover, there), 0.0))
    return value, student(free, 0.975) * scatter * band, scatter


def _crossed(unit: Mapping[float, np.ndarray], near: float, *, straight: bool = False) -> CrossingPlace | None:
    """The place by a fit to values at some places, the one next to `near`; None where the fit has none.

    Places far from it are left out until the fit holds: until what it misses is no more than the scatter over starts.
    """
    grid, places = np.linspace(0.0, 1.0, GRID), dict(unit)
    while True:
        x = np.concatenate([np.full(len(y), place) for place, y in places.items()])
        y = np.concatenate(list(places.values()))
        power = 2 if len(places) >= CURVED and not straight else 1
        value, error, scatter = _least_squares(x, y, grid, power)
        at = np.flatnonzero(np.sign(value[:-1]) != np.sign(value[1:]))
        if not at.size:
            return None
        k = int(at[np.argmin(np.abs(grid[at] - near))])
        root = float(grid[k] - value[k] * (grid[k + 1] - grid[k]) / (value[k + 1] - value[k]))
        if straight or len(places) < 3 or _holds(places, power, scatter):
            off = _other_root(x, y, grid, power + 1, root) if len(places) >= power + 2 else 0.0
            low, high = _connected(grid, np.abs(value) <= error, root)
            if len(places) == 2:  # nothing tells how straight it is between them
                low, high = min(low, *places), max(high, *places)
            return CrossingPlace(root, max(low - off, 0.0), min(high + off, 1.0), bool(value[k + 1] > value[k]))
        near = min(max(root, min(places)), max(places))
        places.pop(max(places, key=lambda place: abs(place - near)))


def _other_root(x: np.ndarray, y: np.ndarray, grid: np.ndarray, power: int, root: float) -> float:
    """Distance from a root to that of a fit of another power: what the form of the fit may be wrong by."""
    value = _least_squares(x, y, grid, power)[0]
    at = np.flatnonzero(np.sign(value[:-1]) != np.sign(value[1:]))
    return float(np.abs(grid[at] - root).min()) if at.size else 0.0


def _connected(grid: np.ndarray, inside: np.ndarray, root: float) -> tuple[float, float]:
    """Ends of the stretch of a grid around a place in which all is inside."""
    low = high = int(np.argmin(np.abs(grid - root)))
    while low > 0 and inside[low - 1]:
        low -= 1
    while high < len(grid) - 1 and inside[high + 1]:
        high += 1
    return float(grid[max(low - 1, 0)]), float(grid[min(high + 1, len(grid) - 1)])


def _holds(places: Mapping[float, np.ndarray], power: int, scatter: float) -> bool:
    """Tells whether a fit misses the means by no more than starts scatter (F test of lack of fit, 95 %)."""
    from scipy.special import fdtri  # 0.1 s

    pure = sum(float(np.sum((y - y.mean()) ** 2)) for y in places.values())
    count = sum(map(len, places.values()))
    within, beyond = count - len(places), len(places) - power - 1
    if within < 1 or beyond < 1:
        return True
    lack = scatter**2 * (count - power - 1) - pure
    return lack / beyond <= float(fdtri(beyond, within, 0.95)) * pure / within


def _sure(off: np.ndarray) -> bool:
    """Tells whether the mean of values is surely not 0, by its 95 % interval; one start is taken as sure."""
    if len(off) < 2:
        return True
    half = student(len(off) - 1, 0.975) * float(off.std(ddof=1)) / np.sqrt(len(off))
    return bool(abs(off.mean()) > half)


def all_on_one_side(y: dict[float, np.ndarray], number: float) -> bool:
    """Tells whether values at every place are surely above a number, or below it, by their 95 % intervals.

    A single start is taken as sure.
    """
    signs = set()
    for values in y.values():
        known = values[np.isfinite(values)] - number
        if known.size:
            signs.add(int(np.sign(known.mean())) if _sure(known) else 0)
    return len(signs) == 1 and 0 not in signs
