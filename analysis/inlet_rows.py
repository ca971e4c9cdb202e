# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of a stream that an inlet lets in disc by disc, by a frame, and what its sums over bins make of them.

Discs of a row follow each other at the distance v T, with the time T from turn to turn. Frames whose times are whole
multiples of T see all of them at the same places, again and again: their mean is that of one picture, and a bin that
holds two and a half discs of a row reads two or three. So a disc counts over the way that it goes within T. That is
the mean over this time for all that goes straight on, and shifts nothing by more than v T/2 elsewhere.

At an inlet and at an outlet discs come and go with their centres. There is none behind that plane whose area would
stand for what those before it have behind the plane: the sums fold it back.
"""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple

import numpy as np

from lammps_jump.dump.frame import Frame
from lammps_jump.scene.walls import Interval

from .flow import Flow

NEAR = 0.25
"""Share of the distance of followers by which the last disc of a row may lie off its place, where its row runs."""
FARTHEST = 5.0
"""Distance of followers, in largest diameters, from which on a row rests in between."""


class Ways(NamedTuple):
    """Over which ways the centres of discs count in sums over bins.

    Attributes
    ----------
    start, stop : ndarray, shape (n,), m
        Ends of each way.
    weight : ndarray, shape (n,)
        Share of a disc that counts; 0 of one that is beyond the ends.
    ends : (float, float)
        Planes at which discs come and go, m; infinite where there is none.
    """

    start: np.ndarray
    stop: np.ndarray
    weight: np.ndarray
    ends: Interval = (-inf, inf)

    @classmethod
    def none(cls, x: np.ndarray) -> Ways:
        """Discs count where they are."""
        return cls(x, x, np.ones(len(x)))


class RunningRows(NamedTuple):
    """Rows of an inlet that run at a frame, with the disc of each that comes next, arrays of shape (rows,).

    Attributes
    ----------
    interval : s
        Time from its last disc to the next one.
    x, y, u, v : m, m/s
        Where the next disc would be if it came at its velocity all the way: behind the inlet.
    """

    interval: np.ndarray
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray


NO_ROWS = RunningRows(*np.empty((5, 0)))


class OpenEnds(NamedTuple):
    """Ends of a range: planes at which discs come or go, m, infinite where there is none.

    `inlet` is the one at which they come, NaN without.
    """

    begin: float
    end: float
    inlet: float

    @classmethod
    def of(cls, flow: Flow) -> OpenEnds:
        """Ends of the range of a flow."""
        scene, (low, high) = flow.scene, flow.x_range
        rows = [row for row in scene.inlets if row.vx]
        planes = {(row.x, row.vx > 0) for row in rows}
        planes |= {(one.at, one.side == "below") for one in scene.outlets if one.axis == "x"}
        inlet = next((row.x for row in rows if row.x == (low if row.vx > 0 else high)), nan)
        return cls(low if (low, True) in planes else -inf, high if (high, False) in planes else inf, inlet)

    def ways(self, x: np.ndarray, half: np.ndarray) -> Ways:
        """Ways of discs at x that go `half` a way on either side, m.

        What lies behind the inlet is no way: the disc was not there yet. Behind an outlet others have gone before.
        """
        start, stop, weight = x - half, x + half, np.where((x < self.begin) | (x > self.end), 0.0, 1.0)
        if self.inlet in (self.begin, self.end):
            if self.inlet == self.begin:
                start, passed = np.maximum(start, self.begin), x > self.end
            else:
                stop, passed = np.minimum(stop, self.end), x < self.begin
            goes = (half > 0) & ~passed
            weight = np.where(goes, np.maximum(stop - start, 0.0) / np.where(goes, 2.0 * half, 1.0), weight)
        return Ways(start, stop, weight, (self.begin, self.end))


def running_rows(flow: Flow, frame: Frame) -> RunningRows:
    """Rows that run at a frame: the last disc of each is where its velocity has brought it.

    So it is in no dump of another run, and at no drowned inlet.
    """
    scene, rows = flow.scene, flow.scene.inlets
    if not rows or not flow.time_step:
        return NO_ROWS
    farthest, found = FARTHEST * scene.largest, []
    inlet = np.flatnonzero(np.abs(frame.x - rows[0].x) < farthest)
    x, y = frame.x[inlet], frame.y[inlet]
    for row in rows:
        turns = row.turns_around(frame.step)
        if turns is None or not row.vx:
            continue
        since, ahead = ((frame.step - turn) * flow.time_step for turn in turns)
        last, coming = (row.speed_at(turn) for turn in turns)
        distance = abs(last) * (since - ahead)
        off = np.abs(x - row.x - last * since), np.abs(y - row.y - row.vy * since)
        if distance < farthest and ((off[0] < NEAR * distance) & (off[1] < row.clearance)).any():
            found.append((since - ahead, row.x + coming * ahead, row.y + row.vy * ahead, coming, row.vy))
    return RunningRows(*np.array(found).T) if found else NO_ROWS


def intervals_of(y: np.ndarray, rows: RunningRows) -> np.ndarray:
    """Time from disc to disc of the row nearest to each height (m), s, shape of `y`; 0 where no row runs."""
    if not len(rows.y):
        return np.zeros(len(y))
    order = np.argsort(rows.y)
    heights = rows.y[order]
    return rows.interval[order][np.searchsorted(0.5 * (heights[1:] + heights[:-1]), y)]
