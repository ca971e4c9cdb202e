# SPDX-License-Identifier: GPL-2.0-or-later
"""Run-up and overtopping: the highest place that water reaches on a slope or wall, and what goes over it.

An *obstacle* is where the bed rises from where the discs are to a *crest*. The tongue ends before the first gap of two
diameters along the slope. Where it has come to an upright face, the highest place is the top of the discs that stand
before the face without such a gap. A disc has gone over when it was last seen beyond the crest.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.devices.front import bulk_front, stack_top
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import Quantity, Wanted
from lammps_jump.analysis.report.page import Section, Table, described
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.scene.chains import X0, X1
from lammps_jump.units import known, number

PER_DIAMETER = 4
"""Places on a diameter at which the bed is looked at."""
MOST_PLACES = 20_000
LOWEST = 3.0
"""Diameters by which a bed must rise to be an obstacle; half of it in half a diameter is an upright face."""
BEFORE = 3.0
"""Diameters before an upright face in which discs stand at it."""
STRIP = 2.0
"""Width of the strips in which the surface of still water is looked for, diameters."""


class Obstacle(NamedTuple):
    """A rise of the bed, seen from the discs.

    Attributes
    ----------
    side : int
        1 where it lies at larger x than the discs, else -1.
    name : str
        Wall whose top is the crest.
    foot, face, crest, behind : float
        Where the rise begins, its last upright face (NaN without), the begin and the end of its top, along x, m.
    low, top : float
        Height of the bed at foot and crest, m.
    x, bed : ndarray
        The bed from foot to crest, m, in the order of x.
    """

    side: int
    name: str
    foot: float
    face: float
    crest: float
    behind: float
    low: float
    top: float
    x: np.ndarray
    bed: np.ndarray


@dataclass(frozen=True)
class RunUp:
    """The highest place of the water on one obstacle, and what has gone over it."""

    highest: float = number(
        "m", "highest place y of the water on the slope or wall", default=nan, label="highest water"
    )
    run_up: float = number("m", "the same over the still water", default=nan, label="run-up over still water")
    time: float = number("s", "time of the highest place", default=nan, label="at")
    place: float = number("m", "place x of the highest water", default=nan)
    still: float = number("m", "height y of the still water, before walls move or at the start", default=nan)
    crest: float = number("m", "height y of the crest", default=nan)
    over: float = number(
        "m^2", "volume that has gone over the crest, by mass", default=nan, label="volume over the crest"
    )
    over_discs: int = number("", "discs that have gone over the crest", default=0)
    diameters: float = number("", "run-up over the diameter", default=nan)
    reaches_crest: bool | None = None
    still_passes: bool | None = None
    wall: str | None = None
    reason: str | None = None
    history: tuple[np.ndarray, ...] | None = field(default=None, metadata={"summary": False})


def can_run_up(flow: Flow) -> bool:
    """Whether waves can run up in a scene: discs without friction under gravity, none that flow in, ends not joined."""
    scene = flow.scene
    known = scene.steps > 0 and len(scene.positions) > 0 and not scene.periodic and flow.gravity > 0
    return known and not (scene.rubs or scene.inlets or scene.pours)


def obstacles_of(flow: Flow, middle: float) -> list[Obstacle]:
    """What stands to the left and to the right of discs around x = middle, m."""
    (low, high), d = flow.x_range, flow.scene.diameter
    step = max(d / PER_DIAMETER, (high - low) / MOST_PLACES)
    ends = [wall.faces.shape[:, [X0, X1]].ravel() for wall in flow.scene.permanent]
    ends = [one[(one > low) & (one < high)] for one in ends]
    x = np.unique(np.concatenate([np.arange(low + 0.5 * step, high, step), *ends]))
    found = (_obstacle(flow, x, side, middle) for side in (-1, 1))
    return [one for one in found if one is not None]


def _obstacle(flow: Flow, x: np.ndarray, side: int, middle: float) -> Obstacle | None:
    d = flow.scene.diameter
    way = x[x >= middle] if side > 0 else x[x <= middle][::-1]
    bed = surface_from(flow, way)
    end = np.flatnonzero(~np.isfinite(bed))
    way, bed = (values[: end[0] if end.size else None] for values in (way, bed))
    if len(bed) < 2:
        return None
    top = np.maximum.accumulate(bed)
    # the first top behind which the bed falls again, else the highest place
    falls = np.flatnonzero((top - bed > LOWEST * d) & (top - np.minimum.accumulate(bed) >= LOWEST * d))
    crest = float(top[falls[0]] if falls.size else top[-1])
    at = int(np.flatnonzero(bed >= crest - 1e-9)[0])
    low = int(np.flatnonzero(bed[: at + 1] <= bed[: at + 1].min() + 1e-9)[-1])
    if crest - bed[low] < LOWEST * d:
        return None
    level = np.flatnonzero(bed[at:] < crest - 1e-9)
    behind = at + (int(level[0]) if level.size else len(bed) - at) - 1
    index = np.arange(low, at + 1)
    rises = bed[index] - bed[np.maximum(index - PER_DIAMETER // 2, low)]
    upright = index[rises > 0.5 * LOWEST * d]
    face = float(way[upright[-1]]) if upright.size else nan
    name = _whose(flow, float(way[at]), crest)
    if any(one.wall.name == name and one.motion.kind is not None for one in flow.scene.walls):
        return None
    part = slice(low, at + 1)
    order = np.argsort(way[part])
    return Obstacle(
        side, name, float(way[low]), face, float(way[at]), float(way[behind]),
        float(bed[low]), crest, way[part][order], bed[part][order],
    )  # fmt: skip


def surface_from(flow: Flow, way: np.ndarray) -> np.ndarray:
    """Height of what stands in the way of water that comes along x, m, of the shape of `way`; NaN from its end on.

    It is the highest top of the standing walls that reach down to the height of the place before: the bed of
    `Flow.bed_height`, and besides a slope that is hollow below.
    """
    solids = [solid for wall in flow.scene.permanent for solid in wall.grounds(way)]
    if not solids:
        return np.full(way.shape, nan)
    undersides, tops = (np.array(part) for part in zip(*solids, strict=True))
    found, before = np.full(way.shape, nan), float(flow.bed_height(way[:1])[0])
    for k in range(len(way)):
        reach = undersides[:, k] <= before + flow.scene.smallest
        there = tops[reach, k]
        if not np.isfinite(there).any():
            break
        found[k] = before = float(np.nanmax(there))
    return found


def _whose(flow: Flow, x: float, top: float) -> str:
    """Name of the wall that is as high as this at x, m; empty for none."""
    for wall in flow.scene.permanent:
        tops = [np.asarray(upper, float) for _, upper in wall.grounds(np.array([x]))]
        if any(np.isclose(one, top).any() for one in tops):
            return wall.name
    return ""


class RunUpWatch:
    """Collects the highest place on each obstacle frame by frame, the still water, and where discs were last seen."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self.obstacles: list[Obstacle] = []
        self.still, self._moved, self.begin = nan, False, -inf
        self.rows: list[list[tuple[float, float, float, float]]] = []
        self.levels: list[float] = []
        self._seen = np.zeros((0, 3))
        self._first: np.ndarray | None = None
        self._poses: Sequence[object] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        if not can_run_up(self.flow) or not frame.n:
            return
        if self._first is None:
            self._begin(frame)
        self._find_still(frame, time)
        now = np.column_stack([frame.ids, frame.x, self.flow.relative_masses(frame)])
        gone = self._seen[~np.isin(self._seen[:, 0], now[:, 0])]
        self._seen = np.concatenate([now, gone])
        for obstacle, rows in zip(self.obstacles, self.rows, strict=True):
            rows.append((time, *self._highest(frame, obstacle), self._over(obstacle)))

    def _begin(self, frame: Frame) -> None:
        self._first = np.column_stack([frame.ids, frame.x])
        self.obstacles = obstacles_of(self.flow, float(np.median(frame.x)))
        self.rows = [[] for _ in self.obstacles]
        if all(one.motion.kind is None for one in self.flow.scene.walls):
            self.levels = [level_before(frame, self.flow, one) for one in self.obstacles]

    def _find_still(self, frame: Frame, time: float) -> None:
        """Keep the level of the water up to the first motion of a wall."""
        moving = [one for one in self.flow.scene.walls if one.motion.kind is not None]
        if self._moved or not moving:
            return
        step = round(self.flow.step_at(time))
        poses = [one.motion.pose(step) for one in moving]
        self._poses = self._poses or poses
        self._moved = poses != self._poses
        if not self._moved:
            self.still, self.begin = level_of(frame, self.flow), time

    def _highest(self, frame: Frame, obstacle: Obstacle) -> tuple[float, float]:
        """Highest place of the water on an obstacle, y and x, m; NaN where there is none."""
        flow, side = self.flow, obstacle.side
        d, largest = flow.scene.diameter, 2.0 * flow.largest_radius(frame)
        # where nominal discs with the same outer edges would stand
        beyond = flow.radii(frame) - flow.scene.radius
        away = side * (frame.x - obstacle.foot) + beyond
        reach = side * (obstacle.crest - obstacle.foot)
        here = (away > -BEFORE * d) & (away < reach)
        if not here.any() or away[here].min() > 0.0:
            return nan, nan
        tip = bulk_front(away[here], d, largest)
        face = side * (obstacle.face - obstacle.foot)
        if isfinite(face) and tip >= face - BEFORE * d:
            stands = (side * (frame.x - obstacle.face) < 0) & (side * (frame.x - obstacle.face) > -BEFORE * d)
            ground = float(np.interp(obstacle.face - side * BEFORE * d, obstacle.x, obstacle.bed))
            return ground + stack_top((frame.y + beyond)[stands], d, ground, largest), obstacle.face
        place = obstacle.foot + side * min(tip, reach)
        return (float(np.interp(place, obstacle.x, obstacle.bed)), place) if tip > 0 else (nan, nan)

    def _over(self, obstacle: Obstacle) -> float:
        """Relative mass of the discs that were before the crest at the start and were last seen beyond it."""
        beyond = self._seen[obstacle.side * (self._seen[:, 1] - obstacle.behind) > 0]
        return float(beyond[np.isin(beyond[:, 0], self._before(obstacle)), 2].sum())

    def _before(self, obstacle: Obstacle) -> np.ndarray:
        first = np.zeros((0, 2)) if self._first is None else self._first
        return first[obstacle.side * (first[:, 1] - obstacle.crest) < 0, 0]

    def count_over(self, obstacle: Obstacle) -> int:
        """Discs that have gone over an obstacle."""
        beyond = self._seen[obstacle.side * (self._seen[:, 1] - obstacle.behind) > 0, 0]
        return int(np.isin(beyond, self._before(obstacle)).sum())

    def result(self) -> RunUpWatch:
        """All that was taken in."""
        return self


def level_of(frame: Frame, flow: Flow) -> float:
    """Height y of the surface of water: median of the highest edges of strips with more than a layer of discs, m."""
    width = STRIP * flow.scene.diameter
    strip = np.floor((frame.x - frame.x.min()) / width).astype(int)
    top = np.full(strip.max() + 1, -np.inf)
    np.maximum.at(top, strip, frame.y + flow.radii(frame))
    deep = np.bincount(strip) > 2 * STRIP
    return float(np.median(top[deep])) if deep.any() else nan


def level_before(frame: Frame, flow: Flow, obstacle: Obstacle) -> float:
    """Height y of the surface of the water at the foot of an obstacle, m; NaN where none lies there."""
    before, d = obstacle.side * (obstacle.foot - frame.x), flow.scene.diameter
    if not ((before >= 0) & (before < BEFORE * d)).any():
        return nan
    half = 0.5 * obstacle.side * (obstacle.foot - float(np.median(frame.x)))
    near = (before >= 0) & (before <= max(half, BEFORE * d))
    columns = {name: column[near] for name, column in frame.columns.items()}
    return level_of(make_frame(frame.step, frame.time, frame.box, columns), flow)


def analyse(gathered: Gathered) -> RunUp | None:
    """Run-up and overtopping of the obstacle that the water climbs highest; None where nothing stands in its way."""
    flow, watch = gathered.flow, gathered.histories["runup"]
    assert isinstance(watch, RunUpWatch)
    found = [(k, np.array(rows).T) for k, rows in enumerate(watch.rows) if rows]
    reached = [(k, rows) for k, rows in found if np.isfinite(rows[1][rows[0] >= watch.begin]).any()]
    if not found:
        return None
    if not reached:
        return RunUp(reason="the water has not reached the foot of the slope or wall")
    which, rows = max(reached, key=lambda pair: (pair[1][3][-1], np.nanmax(pair[1][1])))
    obstacle, still = watch.obstacles[which], watch.levels[which] if watch.levels else watch.still
    time, height, place, over = rows
    height = np.where(time < watch.begin, nan, height)  # before walls move, the water comes to rest
    at = int(np.nanargmax(height))
    highest, d, area = float(height[at]), flow.scene.diameter, flow.scene.mass / flow.scene.density
    recent = over[time >= time[-1] - 0.05 * (time[-1] - time[0])][0]
    run_up = highest - still
    return RunUp(
        highest,
        run_up,
        float(time[at]),
        float(place[at]),
        still,
        obstacle.top,
        area * float(over[-1]),
        watch.count_over(obstacle),
        run_up / d,
        bool(highest >= obstacle.top - 0.5 * d or over[-1] > 0),
        bool(over[-1] > recent),
        obstacle.name or None,
        history=(time, height, area * over),
    )


def tables(runup: RunUp) -> Tables:
    """Highest place of the water (m) and volume that has gone over (m^2) against time."""
    if runup.history is None:
        return {}
    return {"runup.csv": dict(zip(("time", "height", "over"), runup.history, strict=True))}


def figures(runup: RunUp, gathered: Gathered) -> Drawings:
    """Highest place and volume against time."""
    if runup.history is None:
        return {}
    time, height, over = runup.history
    levels = {"crest": runup.crest} | ({"still water": runup.still} if isfinite(runup.still) else {})
    panels = [Panel("Highest water\non the obstacle, y [m]", [Trace("", time, height)], levels=levels)]
    panels += [Panel("Gone over the\ncrest [m²]", [Trace("", time, over)])] if over[-1] > 0 else []
    return {"runup": Chart("run-up and overtopping", TIME, panels)}


def section(runup: RunUp) -> Section:
    """Highest place, still water, crest, and what went over."""
    if not known(runup.highest):
        return Section("Run-up", [])
    keys = ("highest", "still", "run_up", "time", "place", "crest", "over", "over_discs")
    return Section("Run-up", [Table(described(runup, *(key for key in keys if known(getattr(runup, key)))))])


QUANTITY = Quantity(
    name="runup",
    title="Run-up and overtopping",
    result=RunUp,
    definitions="""\
obstacle      where the bed rises by three diameters or more from where the discs are; its crest is the first top
highest       bed under the end of the tongue, before the first gap of two diameters along the slope; before an upright
              face the top of the discs that stand there without such a gap
still water   median of the highest edges of strips two diameters wide, before walls move; without such walls that
              of the water before the foot of the obstacle at the start
over          discs that were before the crest at the start and were last seen beyond it, their mass over ρ
""",
    always=lambda _: True,
    collector=RunUpWatch,
    analyse=analyse,
    files={"runup.csv": "highest water on a slope or wall, and what has gone over it, against time"},
    captions={"runup": "Run-up and overtopping"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(
        Wanted("highest", label="highest water, y"),
        Wanted("run_up", label="run-up over still water"),
        Wanted("over", label="volume over the crest"),
    ),
    rank=30,
)
