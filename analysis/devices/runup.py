# SPDX-License-Identifier: GPL-2.0-or-later
"""Run-up and overtopping: the highest place that water reaches on a slope or wall, and what goes over it.

An *obstacle* is where the bed rises from where the discs are to a *crest*. The tongue ends before the first gap of two
diameters along the slope. Where it has come to an upright face, the highest place is the top of the discs that lie
before the face without such a gap. A disc has gone over when it was last seen beyond the crest.

On a slope over whose crest water goes there is no highest place: its end is the crest, whatever the water would reach.
Water that is over the crest from the start runs up nowhere. What goes over has a head, a depth and a discharge.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.devices.front import bulk_front, stack_top
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.physics import jump
from lammps_jump.scene.chains import X0, X1
from lammps_jump.units import known, number

PER_DIAMETER = 4
"""Places on a diameter at which the bed is looked at."""
MOST_PLACES = 20_000
LOWEST = 3.0
"""Diameters by which a bed must rise to be an obstacle; half of it in half a diameter is an upright face."""
BEFORE = 3.0
"""Diameters before an upright face within which discs are at it."""
STRIP = 2.0
"""Width of the strips in which the surface of still water is looked for, and of the narrowest crest, diameters."""
LEAST = 30
"""Discs that go over, from which on there is a discharge: fewer scatter by more than a fifth."""
PART = 0.1
"""Share of the time in which water goes over, over whose mean the discharge is largest."""


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
    freeboard: float = number("m", "crest over the still water", default=nan)
    time: float = number("s", "time of the highest place", default=nan, label="at")
    place: float = number("m", "place x of the highest water", default=nan)
    still: float = number("m", "height y of the still water, before walls move or at the start", default=nan)
    crest: float = number("m", "height y of the crest", default=nan)
    over: float = number(
        "m^2", "volume that has gone over the crest, by mass", default=nan, label="volume over the crest"
    )
    over_discs: int = number("", "discs that have gone over the crest", default=0)
    over_since: float = number("s", "water goes over since", default=nan)
    over_until: float = number("s", "the last disc goes over at", default=nan)
    head: float = number(
        "m", "head over the crest, mean while water goes over", default=nan, label="head over the crest"
    )
    largest_head: float = number("m", "largest head over the crest", default=nan)
    depth: float = number("m", "mass depth on the crest, mean while water goes over", default=nan)
    largest_depth: float = number("m", "largest mass depth on the crest", default=nan)
    discharge: float = number(
        "m^2/s", "discharge over the crest, mean while water goes over", default=nan, label="discharge over the crest"
    )
    largest_discharge: float = number("m^2/s", "largest discharge, mean over a tenth of that time", default=nan)
    critical_discharge: float = number("m^2/s", "critical flow on the crest under this head, mean", default=nan)
    diameters: float = number("", "run-up over the diameter", default=nan)
    reaches_crest: bool | None = None
    still_passes: bool | None = None
    wall: str | None = None
    reason: str | None = None
    no_run_up: str | None = None
    no_head: str | None = None
    history: tuple[np.ndarray, ...] | None = field(default=None, metadata={"summary": False})


def can_run_up(flow: Flow) -> bool:
    """Tells whether waves can run up: discs without friction under gravity, none that flow in, ends not joined."""
    scene = flow.scene
    known = scene.steps > 0 and len(scene.positions) > 0 and not scene.periodic and flow.gravity > 0
    return known and not (scene.rubs or scene.inlets or scene.pours)


def obstacles_of(flow: Flow, middle: float) -> list[Obstacle]:
    """Obstacles to the left and to the right of discs around x = middle, m."""
    (low, high), d = flow.x_range, flow.scene.diameter
    step = max(d / PER_DIAMETER, (high - low) / MOST_PLACES)
    ends = [wall.faces.shape[:, [X0, X1]].ravel() for wall in flow.scene.permanent]
    ends = [one[(one > low) & (one < high)] for one in ends]
    x = np.unique(np.concatenate([np.arange(low + 0.5 * step, high, step), *ends]))
    obstacles = (_obstacle(flow, x, side, middle) for side in (-1, 1))
    return [one for one in obstacles if one is not None]


def _obstacle(flow: Flow, x: np.ndarray, side: int, middle: float) -> Obstacle | None:
    d = flow.scene.diameter
    way = x[x >= middle] if side > 0 else x[x <= middle][::-1]
    bed = surface_from(flow, way)
    end = np.flatnonzero(~np.isfinite(bed))
    way, bed = (values[: end[0] if end.size else None] for values in (way, bed))
    if len(bed) < 2:
        return None
    top = np.maximum.accumulate(bed)
    # the first top after which the bed falls again, else the highest place
    falls = np.flatnonzero((top - bed > LOWEST * d) & (top - np.minimum.accumulate(bed) >= LOWEST * d))
    crest = float(top[falls[0]] if falls.size else top[-1])
    at = int(np.flatnonzero(bed >= crest - 1e-9)[0])
    low = int(np.flatnonzero(bed[: at + 1] <= bed[: at + 1].min() + 1e-9)[-1])
    if crest - bed[low] < LOWEST * d:
        return None
    level = np.flatnonzero(bed[at:] < crest - 1e-9)
    last_behind = at + (int(level[0]) if level.size else len(bed) - at) - 1
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
        side, name, float(way[low]), face, float(way[at]), float(way[last_behind]),
        float(bed[low]), crest, way[part][order], bed[part][order],
    )  # fmt: skip


def surface_from(flow: Flow, way: np.ndarray) -> np.ndarray:
    """Height of what is in the way of water that comes along x, m, of the shape of `way`; NaN from its end on.

    It is the highest top of the standing walls that reach down to the height of the place before: the bed of
    `Flow.bed_height`, and besides a slope that is hollow below.
    """
    solids = [solid for wall in flow.scene.permanent for solid in wall.grounds(way)]
    if not solids:
        return np.full(way.shape, nan)
    undersides, tops = (np.array(part) for part in zip(*solids, strict=True))
    surface, before = np.full(way.shape, nan), float(flow.bed_height(way[:1])[0])
    for k in range(len(way)):
        reach = undersides[:, k] <= before + flow.scene.smallest
        there = tops[reach, k]
        if not np.isfinite(there).any():
            break
        surface[k] = before = float(np.nanmax(there))
    return surface


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
        self.rows: list[list[tuple[float, ...]]] = []
        self.levels: list[float] = []
        self.reaches: list[float] = []
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
        for obstacle, rows, reach in zip(self.obstacles, self.rows, self.reaches, strict=True):
            rows[-1] += level_before(frame, self.flow, obstacle, reach), self._depth(frame, obstacle)

    def _begin(self, frame: Frame) -> None:
        self._first = np.column_stack([frame.ids, frame.x])
        middle = float(np.median(frame.x))
        self.obstacles = obstacles_of(self.flow, middle)
        self.rows = [[] for _ in self.obstacles]
        self.reaches = [
            max(0.5 * one.side * (one.foot - middle), BEFORE * self.flow.scene.diameter) for one in self.obstacles
        ]
        if all(one.motion.kind is None for one in self.flow.scene.walls):
            self.levels = [
                level_before(frame, self.flow, *pair) for pair in zip(self.obstacles, self.reaches, strict=True)
            ]

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
        # where nominal discs with the same outer edges would be
        beyond = flow.radii(frame) - flow.scene.radius
        away = side * (frame.x - obstacle.foot) + beyond
        reach = side * (obstacle.crest - obstacle.foot)
        here = (away > -BEFORE * d) & (away < reach)
        if not here.any() or away[here].min() > 0.0:
            return nan, nan
        tip = bulk_front(away[here], d, largest)
        face = side * (obstacle.face - obstacle.foot)
        if isfinite(face) and tip >= face - BEFORE * d:
            is_near = (side * (frame.x - obstacle.face) < 0) & (side * (frame.x - obstacle.face) > -BEFORE * d)
            ground = float(np.interp(obstacle.face - side * BEFORE * d, obstacle.x, obstacle.bed))
            return ground + stack_top((frame.y + beyond)[is_near], d, ground, largest), obstacle.face
        place = obstacle.foot + side * min(tip, reach)
        return (float(np.interp(place, obstacle.x, obstacle.bed)), place) if tip > 0 else (nan, nan)

    def _depth(self, frame: Frame, obstacle: Obstacle) -> float:
        """Mass depth on the crest, m: of the discs over it, from its begin on over two diameters or more."""
        d = self.flow.scene.diameter
        width, way = max(abs(obstacle.behind - obstacle.crest), STRIP * d), obstacle.side * (frame.x - obstacle.crest)
        here = (way > 0) & (way <= width) & (frame.y > obstacle.top)
        return float(self.flow.relative_masses(frame)[here].sum()) * d**2 / width

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


def level_before(frame: Frame, flow: Flow, obstacle: Obstacle, reach: float) -> float:
    """Height y of the surface of the water up to `reach` (m) before an obstacle, m; NaN where none lies at its foot."""
    before, d = obstacle.side * (obstacle.foot - frame.x), flow.scene.diameter
    if not ((before >= 0) & (before < BEFORE * d)).any():
        return nan
    near = (before >= 0) & (before <= reach)
    columns = {name: column[near] for name, column in frame.columns.items()}
    return level_of(make_frame(frame.step, frame.time, frame.box, columns), flow)


def analyse(gathered: Gathered) -> RunUp | None:
    """Run-up and overtopping of the obstacle that the water climbs highest; None without an obstacle."""
    flow, watch = gathered.flow, gathered.histories["runup"]
    assert isinstance(watch, RunUpWatch)
    histories = [(k, np.array(rows).T) for k, rows in enumerate(watch.rows) if rows]
    reached = [(k, rows) for k, rows in histories if np.isfinite(rows[1][rows[0] >= watch.begin]).any()]
    if not histories:
        return None
    if not reached:
        return RunUp(reason="the water has not reached the foot of the slope or wall")
    which, rows = max(reached, key=lambda pair: (pair[1][3][-1], np.nanmax(pair[1][1])))
    obstacle, still = watch.obstacles[which], watch.levels[which] if watch.levels else watch.still
    time, height, place, over, level, depth = rows
    height = np.where(time < watch.begin, nan, height)  # before walls move, the water comes to rest
    area = flow.scene.mass / flow.scene.density * over
    gone = _gone_over(flow, obstacle, (time, area, level, depth), watch.count_over(obstacle))
    why = _why_no_run_up(flow, obstacle, (height, place), still, gone["over_discs"])
    at, d = int(np.nanargmax(height)), flow.scene.diameter
    highest = float(height[at]) if not why else nan
    recent = over[time >= time[-1] - 0.05 * (time[-1] - time[0])][0]
    reaches = np.nanmax(height) >= obstacle.top - 0.5 * d or over[-1] > 0
    return RunUp(
        highest=highest, run_up=highest - still, freeboard=obstacle.top - still,
        time=nan if why else float(time[at]), place=nan if why else float(place[at]),
        still=still, crest=obstacle.top, diameters=(highest - still) / d,
        reaches_crest=bool(reaches), still_passes=bool(over[-1] > recent), wall=obstacle.name or None,
        no_run_up=why or None, **gone,
        history=(time, height, area, level - obstacle.top, depth),
    )  # fmt: skip


def _why_no_run_up(
    flow: Flow, obstacle: Obstacle, rows: tuple[np.ndarray, np.ndarray], still: float, discs: int
) -> str:
    """Why there is no highest place on an obstacle, over which so many discs have gone; empty where there is one.

    On an upright face water may be higher than the crest; on a slope its end tells nothing once it is the crest.
    """
    (height, place), d = rows, flow.scene.diameter
    if still >= obstacle.top - 0.5 * d:
        return "the water stands over the crest from the start"
    known = np.isfinite(height)
    passes = discs >= LEAST or bool((np.abs(place[known] - obstacle.crest) < 0.5 * d).any())
    if not isfinite(obstacle.face) and passes:
        return "the water goes over the crest, and a slope has no highest place then"
    if np.nanmax(height) < still - d:
        return "the water has not risen over its still level on it"
    return ""


def _gone_over(flow: Flow, obstacle: Obstacle, rows: tuple[np.ndarray, ...], discs: int) -> dict[str, Any]:
    """Flow over an obstacle: volume (m^2), and of the time while it does head, depth (m) and discharge (m^2/s).

    Parameters
    ----------
    flow : Flow
    obstacle : Obstacle
    rows : tuple of ndarray, shape (frames,)
        Time (s), volume that has gone over (m^2), height y of the water before it and mass depth on its crest (m).
    discs : int
        That have gone over.
    """
    time, over, level, depth = rows
    over_crest: dict[str, Any] = {"over": float(over[-1]), "over_discs": discs}
    rises = np.flatnonzero(np.diff(over) > 0)
    if not rises.size:
        return over_crest
    first, last = int(rises[0]), int(rises[-1]) + 1
    passing, span = slice(first, last + 1), float(time[last] - time[first])
    over_crest |= {"over_since": float(time[first]), "over_until": float(time[last])}
    if discs < LEAST or span <= 0:
        return over_crest | {"no_head": f"{discs} discs have gone over, too few for a discharge"}
    ends = np.linspace(time[first], time[last], round(1 / PART) + 1)
    over_crest |= {
        "discharge": float(over[last] - over[first]) / span,
        "largest_discharge": float(np.diff(np.interp(ends, time, over)).max()) / (PART * span),
        "depth": float(depth[passing].mean()),
        "largest_depth": float(depth[passing].max()),
    }
    head = level[passing] - obstacle.top
    is_known = np.isfinite(head) & (head > 0)
    if is_known.mean() < 0.5:
        return over_crest | {"no_head": "the water before it stands below the crest most of the time"}
    return over_crest | {
        "head": float(head[is_known].mean()),
        "largest_head": float(head[is_known].max()),
        "critical_discharge": sum(jump.critical_discharge(one, flow.g) for one in head[is_known].tolist()) / len(head),
    }


def tables(runup: RunUp) -> Tables:
    """Highest place of the water (m), volume that has gone over (m^2), head and depth on the crest (m) against time."""
    if runup.history is None:
        return {}
    return {"runup.csv": dict(zip(("time", "height", "over", "head", "depth"), runup.history, strict=True))}


def figures(runup: RunUp, gathered: Gathered) -> Drawings:
    """Highest place where there is one, volume and head against time."""
    if runup.history is None:
        return {}
    time, height, over, head, depth = runup.history
    levels = {"crest": runup.crest} | ({"still water": runup.still} if isfinite(runup.still) else {})
    panels = []
    if not runup.no_run_up:
        panels.append(Panel("Highest water\non the obstacle, y [m]", [Trace("", time, height)], levels=levels))
    if isfinite(runup.discharge):
        lines = [Trace("depth on the crest", time, depth, "second")]
        if isfinite(runup.head):
            lines.insert(0, Trace("head over the crest", time, np.where(head > 0, head, nan)))
        panels.append(Panel("Over the crest [m]", lines))
    panels += [Panel("Gone over the\ncrest [m²]", [Trace("", time, over)])] if over[-1] > 0 else []
    return {"runup": Chart("run-up and overtopping", TIME, panels)} if panels else {}


KEYS = (
    "highest", "still", "run_up", "time", "place", "crest", "freeboard", "over", "over_discs", "over_since",
    "over_until", "discharge", "largest_discharge", "critical_discharge", "head", "largest_head", "depth",
    "largest_depth",
)  # fmt: skip


def section(runup: RunUp) -> Section:
    """Highest place, still water, crest, and what went over."""
    if not known(runup.crest):
        return Section("Run-up", [])
    rows = described(runup, *(key for key in KEYS if known(getattr(runup, key))))
    why = [f"No run-up is told: {runup.no_run_up}." if runup.no_run_up else ""]
    why.append(f"No head is told: {runup.no_head}." if runup.no_head else "")
    return Section("Run-up", [Table(rows), *(Text(text, "small") for text in why)])


OF_WATER = "of water that flows over a crest without loss, at the head of each instant"
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
run-up        told where water meets a face or slope below the crest. There is none on a slope over whose crest water
              goes, and where water stands over the crest from the start
discharge     volume over the time from the first disc that goes over to the last; of 30 discs or more
head          level of the water before the foot (as of the still water) over the crest, mean of the frames of that time
              in which it is above the crest; critical: √g (2h/3)^1.5 of each, what water of this head would carry
depth         mass of the discs on the crest over ρ and its width, which is two diameters or more
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
        HeadlineNumber("highest", label="highest water, y"),
        HeadlineNumber("run_up", label="run-up over still water"),
        HeadlineNumber("discharge", "critical flow", "critical_discharge", "discharge over the crest", holds=OF_WATER),
        HeadlineNumber("head", label="head over the crest"),
        HeadlineNumber("over", label="volume over the crest"),
    ),
    rank=30,
)
