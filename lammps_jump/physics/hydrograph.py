# SPDX-License-Identifier: GPL-2.0-or-later
"""An inflow against time: depth and mean speed in straight lines, and when the discs of each row enter.

Between two rows of the table depth h and speed u are linear in time, so that the discharge h u is a parabola and what
came in, its integral, a cubic. At a depth h there are K rows as in a steady inflow (`inlet.row_count`), and row i
carries the share w_i of the discharge. Its phase is the integral of w_i h u / a, with the mean square a of a diameter:
the number of discs that it owes. Disc k enters where the phase is k + 1/2, so that a row is never off by more than half
a disc, whatever the table does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .elementary import power
from .inlet import LEAST_GAP, REFUSAL_GAP, row_count

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
        found = np.zeros((2, len(t)))
        found[0, 1:] = np.cumsum(np.diff(t) * 0.5 * (h[1:] + h[:-1]))
        found[1, 1:] = np.cumsum(np.diff(t) * _parabola(h[:-1], h[1:], u[:-1], u[1:]))
        return found[0], found[1]

    @property
    def rise(self) -> float:
        """Largest ratio of a speed to a lower one before it; 1 where the speed never grows."""
        speeds = np.array(self.speeds)
        return float(np.max(speeds / np.minimum.accumulate(speeds)))

    @property
    def leap(self) -> tuple[float, float]:
        """Largest ratio of a speed to that `TRAVEL` depths of the stream before, and the time of the lower one, s."""
        depth = max(self.depths)
        found = [
            (float(self.speed(time + TRAVEL * depth / speed)) / speed, time)
            for time, speed in zip(self.times, self.speeds, strict=True)
        ]
        return max(found, key=lambda one: one[0])

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
    found = []
    for row in range(most):
        share = np.where(rows > row, shape[row] / whole[rows], 0.0)
        phase = np.append(0.0, np.cumsum(share * np.diff(carried) / mean_square))
        owed = np.arange(floor(phase[-1] + 0.5)) + 0.5
        piece = np.searchsorted(phase, owed) - 1
        wanted = carried[piece] + (owed - phase[piece]) * mean_square / share[piece]
        times = graph._times_of(wanted, ends[piece], ends[piece + 1])
        found.append(RowEntries(times, rows[piece] * share[piece]))
    return found


def _pieces(graph: Hydrograph, duration: float, layer: float) -> np.ndarray:
    """Times (s) between which the number of rows, each `layer` deep, stays and depth and speed are straight lines."""
    inner = [t for t in graph.times if 0 < t < duration]
    ends = np.array([0.0, *inner, duration])
    depths, found = graph.depth(ends), [ends]
    for t0, t1, h0, h1 in zip(ends[:-1], ends[1:], depths[:-1], depths[1:], strict=True):
        low, high = sorted((h0, h1))
        levels = layer * np.arange(floor(low / layer) + 1, floor(high / layer) + 1)
        found.append(t0 + (t1 - t0) * (levels - h0) / (h1 - h0 or 1.0))
    return np.unique(np.concatenate(found))
