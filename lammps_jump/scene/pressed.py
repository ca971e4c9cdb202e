# SPDX-License-Identifier: GPL-2.0-or-later
"""Stretches of outlines over which the force of the discs is summed at every step: bins of a face, and gauges."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, isfinite
from typing import NamedTuple

import numpy as np

from .chains import (
    ARC_LENGTH,
    AT_START,
    CX,
    CY,
    ENDLESS,
    KIND,
    LENGTH,
    PHI,
    RADIUS,
    SEGMENT,
    SMOOTH_TURN,
    TX0,
    TX1,
    TY0,
    TY1,
    X0,
    Y0,
    Faces,
    Point,
)
from .walls import Interval, Wall

MOST_INTERVALS = 2000
"""Stretches of all walls together: every window keeps three numbers of each."""


@dataclass(frozen=True, slots=True)
class FaceStretch:
    """A stretch of the outline of a wall, with the discs on its left.

    Attributes
    ----------
    wall : str
    begin, end : float
        Along the outline, m.
    place, along : (float, float)
        Its middle, m, and the unit vector along the outline there, where the case has the wall.
    gauge : bool
        It is the gauge of a point, and no bin.
    """

    wall: str
    begin: float
    end: float
    place: Point
    along: Point
    gauge: bool = False

    @property
    def width(self) -> float:
        """Length along the outline, m."""
        return self.end - self.begin


class SmoothRun(NamedTuple):
    """Faces that join smoothly, from one place along the outline to another, m."""

    begin: float
    end: float


def runs_of(wall: Wall, room: Interval | None = None) -> list[SmoothRun]:
    """Runs of the outline of a wall, of one chain; `room`: where an endless one is looked at, along its outline, m."""
    faces = wall.faces
    if (faces.codes[:, AT_START] == ENDLESS).any():
        assert room is not None
        return [SmoothRun(*room)]
    shape = faces.shape[np.argsort(faces.shape[:, ARC_LENGTH])]
    turns = shape[:-1, TX1] * shape[1:, TX0] + shape[:-1, TY1] * shape[1:, TY0] < cos(SMOOTH_TURN)
    first = [0, *(np.flatnonzero(turns) + 1).tolist(), len(shape)]
    ends = shape[:, ARC_LENGTH] + shape[:, LENGTH]
    return [SmoothRun(float(shape[one, ARC_LENGTH]), float(ends[other - 1])) for one, other in pairwise(first)]


def bins_of(wall: Wall, count: int, room: Interval | None = None) -> list[FaceStretch]:
    """At least so many bins of the outline, of about one width; none goes over a corner."""
    runs = runs_of(wall, room)
    width = sum(run.end - run.begin for run in runs) / count
    stretches = []
    for run in runs:
        parts = max(1, ceil((run.end - run.begin) / width - 1e-9))
        ends = np.linspace(run.begin, run.end, parts + 1).tolist()
        stretches += [stretch_of(wall, begin, end) for begin, end in pairwise(ends)]
    return stretches


def gauge_of(wall: Wall, point: Point, width: float, room: Interval | None = None) -> FaceStretch:
    """The stretch of some width (m) around the foot of a point on the outline; it ends at corners."""
    place, face = foot_of(wall.faces, point)
    run = next(run for run in runs_of(wall, room) if run.begin - 1e-9 <= place <= run.end + 1e-9) if face >= 0 else None
    low, high = run or SmoothRun(place, place)
    return stretch_of(wall, max(low, place - 0.5 * width), min(high, place + 0.5 * width), gauge=True)


def foot_of(faces: Faces, point: Point) -> tuple[float, int]:
    """Place along the outline of the point of it that is nearest to a point, m, and its face."""
    best, foot = np.inf, (0.0, -1)
    for face, row in enumerate(faces.shape):
        length = row[LENGTH] if isfinite(row[LENGTH]) else np.inf
        if faces.codes[face, AT_START] == ENDLESS:
            there = float((point[0] - row[X0]) * row[TX0] + (point[1] - row[Y0]) * row[TY0])
        elif faces.codes[face, KIND] == SEGMENT:
            way = (point[0] - row[X0]) * row[TX0] + (point[1] - row[Y0]) * row[TY0]
            there = float(np.clip(way, 0.0, length))
        else:
            samples = np.linspace(0.0, length, 2001)
            at = np.array([at_place(faces, face, float(one))[0] for one in samples])
            there = float(samples[np.argmin(np.hypot(*(at - point).T))])
        (x, y), _ = at_place(faces, face, there)
        away = float(np.hypot(point[0] - x, point[1] - y))
        if away < best - 1e-12:
            best, foot = away, (float(row[ARC_LENGTH]) + there, face)
    return foot


def at_place(faces: Faces, face: int, way: float) -> tuple[Point, Point]:
    """Point (m) and unit vector along a face, so far from its start, m."""
    row = faces.shape[face]
    if faces.codes[face, KIND] == SEGMENT:
        return (float(row[X0] + way * row[TX0]), float(row[Y0] + way * row[TY0])), (float(row[TX0]), float(row[TY0]))
    angle = row[PHI] + way / row[RADIUS]
    c, s = float(np.cos(angle)), float(np.sin(angle))
    return (float(row[CX] + row[RADIUS] * s), float(row[CY] - row[RADIUS] * c)), (c, s)


def stretch_of(wall: Wall, begin: float, end: float, *, gauge: bool = False) -> FaceStretch:
    """The stretch between two places along the outline of a wall, m."""
    faces, middle = wall.faces, 0.5 * (begin + end)
    starts = faces.shape[:, ARC_LENGTH]
    endless = faces.codes[0, AT_START] == ENDLESS
    face = 0 if endless else int(np.flatnonzero(starts <= middle + 1e-12)[-1])
    place, along = at_place(faces, face, middle - (0.0 if endless else float(starts[face])))
    return FaceStretch(wall.name, begin, end, place, along, gauge)
