# SPDX-License-Identifier: GPL-2.0-or-later
"""A heap: shape of the discs at the last frame, its slopes, and how far a column has run out.

The surface is that of the profiles, in bins one diameter wide. On each side of the top a straight line is fitted to
the bins between 20 % and 80 % of the height. *Run-out* goes by two fronts: the *bulk* ends before the first gap of
two diameters between neighbours in x, seen from the column; the *99 % front* is what 1 % of the discs pass. A run-out
ends at no wall, and there is none where discs have come to one, to an outlet or to the end of the domain.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import atan, atan2, degrees, isfinite, nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.devices.front import bulk_front, quantile_front, stop_beside
from lammps_jump.analysis.draw.chart import PLACE, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import bin_frames
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import student
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import devices, measured
from lammps_jump.units import Estimates, estimate, known, number, sure_of

from .rest import RestHistory, rests

LOW, HIGH = 0.2, 0.8
"""Shares of the height between which a flank is fitted."""
MOST_INTERVAL = 45.0
"""Half of an interval from which on a flank has no angle, degrees."""
FEWEST = 4
"""Bins of a flank."""
BESIDE = 5
"""Empty bins to either side of the heap that its table holds."""
SAME_ASPECT = 0.1
"""Share by which the aspect of a column may be off that of a published heap whose shape is compared."""


@dataclass(frozen=True)
class Heap(Estimates):
    """Heap at the last frame; intervals are half of 95 % intervals, from the scatter about the fitted line."""

    height: float = number("m", "height of the heap over the bed", default=nan, label="height")
    height_in_diameters: float = number("", "height over the diameter", default=nan)
    top: float = number("m", "place x of its top", default=nan)
    angle: float = estimate(
        "degree", "angle of the flanks to the horizontal", label="angle of the flanks", interval="± of it, from the fit"
    )
    angle_left: float = estimate("degree", "angle of the left flank", interval="± of it, from the fit")
    angle_right: float = estimate("degree", "angle of the right flank", interval="± of it, from the fit")
    left: float = number("m", "left end of the bulk", default=nan)
    right: float = number("m", "right end of the bulk", default=nan)
    base: float = number("m", "base L₀ of the column at the start (half of one that falls to both sides)", default=nan)
    aspect: float = number("", "aspect a = H₀/L₀ of the column at the start", default=nan)
    run_out: float = number("m", "run-out L − L₀ of the bulk", default=nan)
    run_out_99: float = number("m", "run-out L − L₀ of the 99 % front", default=nan)
    run_out_over_base: float = number(
        "", "run-out of the bulk over the base, (L − L₀)/L₀", default=nan, label="run-out over base"
    )
    run_out_99_over_base: float = number("", "run-out of the 99 % front over the base", default=nan)
    height_over_base: float = number("", "height of the heap over the base of the column, h/L₀", default=nan)
    discs: float = number("", "run-out over base, discs 2.5 a (Staron & Hinch 2005)", default=nan)
    rods: float = number("", "run-out over base, aluminium rods (arXiv 1512.05180)", default=nan)
    sand: float = number("", "run-out over base, sand (Lube et al. 2005)", default=nan)
    height_rods: float = number("", "height over base, aluminium rods (arXiv 1512.05180)", default=nan)
    shape_off: float = number("", "h/L₀ less that of published discs of this aspect, root mean square", default=nan)
    friction: float = number("", "friction coefficient of the discs", default=nan)
    at_rest: bool | None = None
    left_at: str | None = None
    right_at: str | None = None
    no_run_out: str | None = None
    reason: str | None = None
    shape: Shape | None = field(default=None, metadata={"summary": False})


class Shape(NamedTuple):
    """The surface of a heap.

    Attributes
    ----------
    x : ndarray, shape (bins,), m
    bed, depth : ndarray, shape (bins,), m
        Height of the bed, and depth of the discs over it.
    flanks : tuple of Flank
        Left and right.
    """

    x: np.ndarray
    bed: np.ndarray
    depth: np.ndarray
    flanks: tuple[Flank, Flank]


class Flank(NamedTuple):
    """Straight line through the surface of a flank; NaN where there is none.

    Attributes
    ----------
    fall : float
        Fall over distance from the top.
    interval : float
        Half of the 95 % interval of the fall.
    x, y : (float, float)
        Ends of the line, m.
    """

    fall: float = nan
    interval: float = nan
    x: tuple[float, float] = (nan, nan)
    y: tuple[float, float] = (nan, nan)


class StandingColumn(NamedTuple):
    """A column at the start, m: its ends and height, and whether it is free to fall to the left and to the right."""

    left: float
    right: float
    height: float
    free: tuple[bool, bool]

    @property
    def base(self) -> float:
        """L0, m: half of the width where both sides are free."""
        return (self.right - self.left) * (0.5 if all(self.free) else 1.0)

    @property
    def back(self) -> float:
        """Place from which L0 is measured, m: the wall, or the middle."""
        return 0.5 * (self.left + self.right) if all(self.free) else self.left if self.free[1] else self.right

    @property
    def sides(self) -> tuple[int, ...]:
        """Sides to which it falls: -1, 1."""
        return tuple(side for side, free in zip((-1, 1), self.free, strict=True) if free)


class LastFrames(NamedTuple):
    """Remains of the frames: the last one with discs, its time (s), and the column at the start, if there was one."""

    frame: Frame | None
    time: float
    column: StandingColumn | None


def flank_of(x: np.ndarray, surface: np.ndarray, depth: np.ndarray, side: int, stretch: float = 1.0) -> Flank:
    """The flank of a heap to its left (`side` -1) or right (1).

    Its bins lie between the last one, seen from the top, that is higher than `HIGH` and the first one that is lower
    than `LOW` of the height. A flank that ends before it is as low leans on something: it is none.

    Parameters
    ----------
    x, surface, depth : ndarray, shape (bins,), m
        Surface is the height of the free surface, depth that over the bed.
    side : int
    stretch : float
        Factor on the range from `LOW` to `HIGH`.
    """
    height = depth.max(initial=0.0)
    more = 0.5 * (stretch - 1.0) * (HIGH - LOW)
    highest = np.flatnonzero(depth == height)
    order = np.arange(highest[-1], len(x)) if side > 0 else np.arange(highest[0], -1, -1)
    low = np.flatnonzero(depth[order] < (LOW - more) * height)
    if not height > 0 or not low.size:
        return Flank()
    begin = np.flatnonzero(depth[order[: low[0]]] > (HIGH + more) * height)[-1] + 1
    part = order[begin : low[0]]
    if len(part) < FEWEST:
        return Flank()
    away, y = np.abs(x[part] - x[part[0]]), surface[part]
    place = away - away.mean()
    fall = -float(place @ y) / float(place @ place)
    off = y - y.mean() + fall * place
    total = float(off @ off)
    # neighbours share discs: their residuals go together
    together = min(max(float(off[1:] @ off[:-1]) / total + 2.0 / len(part), 0.0), 0.9) if total > 0 else 0.0
    error = sqrt(total / (len(part) - 2) / float(place @ place) * (1.0 + together) / (1.0 - together))
    ends = tuple(float(y.mean() - fall * place[k]) for k in (0, -1))
    return Flank(
        fall, student(len(part) - 2, 0.975) * error, (float(x[part[0]]), float(x[part[-1]])), (ends[0], ends[1])
    )


class HeapWatch:
    """Keeps the column at the start, and the last frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self._last: tuple[Frame | None, float] = (None, nan)
        self._column: StandingColumn | None = None
        self._ids = np.zeros(0, np.int64)
        self._fed = False

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        if not frame.n:
            return
        if self._last[0] is None or time <= 0:
            self._column, self._ids = self._column_of(frame), frame.ids
        self._fed = self._fed or not np.isin(frame.ids, self._ids).all()
        self._last = frame, time

    def _column_of(self, frame: Frame) -> StandingColumn | None:
        """The discs of a frame as a column; None where walls hold them on both sides, or where they hang in the air."""
        radii, d = self.flow.radii(frame), self.flow.scene.diameter
        left, right = float((frame.x - radii).min()), float((frame.x + radii).max())
        top, bed = float((frame.y + radii).max()), self.flow.bed_height(np.array([0.5 * (left + right)]))[0]
        rooms = [wall.room("x") for wall in self.flow.scene.permanent]
        free = all(abs(left - low) > d for low, _ in rooms), all(abs(right - high) > d for _, high in rooms)
        bottom = float((frame.y - radii).min())
        if bottom - bed > d:
            return None
        height = top - float(bed if np.isfinite(bed) else bottom)
        return StandingColumn(left, right, height, free) if any(free) and height > 0 else None

    def result(self) -> LastFrames:
        """Remains of all frames."""
        return LastFrames(*self._last, None if self._fed else self._column)


def shape_of(frame: Frame, flow: Flow) -> Shape:
    """Surface of a frame in bins one diameter wide, and its flanks."""
    dataset = bin_frames([frame], replace(flow, bin_width=flow.scene.diameter))
    x, bed, depth = dataset["x"].values, dataset["bed"].values, np.nan_to_num(dataset["surface_depth"].values[0])
    bed = np.where(np.isfinite(bed), bed, np.nanmin(bed) if np.isfinite(bed).any() else 0.0)
    left, right = (flank_of(x, bed + depth, depth, side, flow.fit_stretch) for side in (-1, 1))
    return Shape(x, bed, depth, (left, right))


def cut_to_discs(shape: Shape) -> Shape:
    """The shape from the first bin with discs to the last, with `BESIDE` empty ones to either side."""
    wet = np.flatnonzero(shape.depth > 0)
    if not wet.size:
        return shape
    part = slice(max(wet[0] - BESIDE, 0), wet[-1] + BESIDE + 1)
    return Shape(shape.x[part], shape.bed[part], shape.depth[part], shape.flanks)


def analyse(gathered: Gathered) -> Heap:
    """The heap of a run at its last frame; with a reason where the scene makes none."""
    flow, remains = gathered.flow, gathered.histories["heap"]
    assert isinstance(remains, LastFrames)
    if flow.gravity <= 0 or flow.scene.inlets:
        return Heap(reason="a heap needs gravity, and no rows of inflow")
    if remains.frame is None:
        return Heap(reason="no frame holds a disc")
    shape = cut_to_discs(shape_of(remains.frame, flow))
    height = float(shape.depth.max())
    if not height > 0:
        return Heap(reason="no disc lies on the bed")
    flank_angles = [_angle(flank, side, flow) for flank, side in zip(shape.flanks, (-1, 1), strict=True)]
    angles, intervals = zip(*flank_angles, strict=True)
    known = np.isfinite(angles)
    frame, scene = remains.frame, flow.scene
    middle = float(shape.x[shape.depth == height].mean())
    left, right = (_end(frame, flow, middle, side, bulk=True) for side in (-1, 1))
    rest = gathered.histories.get("rest")
    both = float(np.sqrt(np.sum(np.array(intervals)[known] ** 2)) / known.sum()) if known.any() else nan
    sure = {"angle_interval": both, "angle_left_interval": intervals[0], "angle_right_interval": intervals[1]}
    return Heap(
        height=height,
        height_in_diameters=height / scene.diameter,
        top=middle,
        angle=float(np.mean(np.array(angles)[known])) if known.any() else nan,
        angle_left=angles[0],
        angle_right=angles[1],
        **sure,
        left=left,
        right=right,
        left_at=stop_beside(flow, left, -1) or None,
        right_at=stop_beside(flow, right, 1) or None,
        **_run_out(remains, flow, shape),
        friction=scene.coefficients.friction,
        at_rest=rests(rest, flow) if isinstance(rest, RestHistory) else None,
        shape=shape,
    )


def _angle(flank: Flank, side: int, flow: Flow) -> tuple[float, float]:
    """Angle of a flank to the horizontal and half of its interval, degrees; gravity may be tilted."""
    tilt = degrees(atan2(flow.scene.gravity[0], flow.gravity))
    interval = degrees(flank.interval / (1.0 + flank.fall**2))
    angle = degrees(atan(flank.fall)) + side * tilt, interval
    return (nan, nan) if interval > MOST_INTERVAL else angle  # a few bins that lie on no line


def _end(frame: Frame, flow: Flow, start: float, side: int, *, bulk: bool) -> float:
    """End of the discs on one side of a place (m): the bulk from there on, or 99 % of them, m."""
    d, radii = flow.scene.diameter, flow.radii(frame)
    # where nominal discs with the same outer edges would be
    outer = side * (frame.x - start) + radii - flow.scene.radius
    outer = outer[outer > -d]
    front = bulk_front(outer, d, 2 * flow.largest_radius(frame)) if bulk else quantile_front(outer, d)
    return start + side * front


def _run_out(remains: LastFrames, flow: Flow, shape: Shape) -> dict[str, Any]:
    """Numbers of a column that has run out, by key; none where there was no column."""
    column, frame = remains.column, remains.frame
    if column is None or frame is None:
        return {}
    base, start = column.base, column.back
    ends = [[(side, _end(frame, flow, start, side, bulk=bulk)) for side in column.sides] for bulk in (True, False)]
    runs = [float(np.mean([abs(end - start) for _, end in some])) - base for some in ends]
    aspect, height = column.height / base, float(shape.depth.max())
    met = [next(filter(None, (stop_beside(flow, end, side) for side, end in some)), "") for some in ends]
    if any(met):  # of both: what 1 % of the discs have not passed may be the wall, too
        return {"base": base, "aspect": aspect, "no_run_out": f"the discs have come to {met[0] or met[1]}"}
    return {
        "base": base,
        "aspect": aspect,
        "run_out": runs[0],
        "run_out_99": runs[1],
        "run_out_over_base": runs[0] / base,
        "run_out_99_over_base": runs[1] / base,
        "height_over_base": height / base,
        "discs": devices.run_out_of_discs(aspect),
        "rods": devices.run_out_of_rods(aspect),
        "sand": devices.run_out_of_sand(aspect),
        "height_rods": devices.height_of_rods(aspect),
        "shape_off": _shape_off(shape, column),
    }


def published_shape(column: StandingColumn | None) -> measured.DiscHeap | None:
    """The published heap of a column of this aspect; None where there is none."""
    if column is None:
        return None
    aspect = column.height / column.base
    return next((one for one in measured.DISC_HEAPS if abs(aspect / one.aspect - 1.0) < SAME_ASPECT), None)


def _shape_off(shape: Shape, column: StandingColumn) -> float:
    """Root mean square of h/L0 less that of published discs; NaN where there are none of this aspect."""
    theirs = published_shape(column)
    if theirs is None:
        return nan
    places = [column.back + side * column.base * np.array(theirs.shape.x) for side in column.sides]
    ours = np.mean([np.interp(x, shape.x, shape.depth) for x in places], axis=0) / column.base
    return float(np.sqrt(np.mean((ours - np.array(theirs.shape.y)) ** 2)))


def tables(heap: Heap) -> Tables:
    """Surface of the heap: bed, depth above it and height over x, m."""
    shape = heap.shape
    if shape is None:
        return {}
    return {"heap.csv": {"x": shape.x, "bed": shape.bed, "depth": shape.depth, "height": shape.bed + shape.depth}}


def figures(heap: Heap, gathered: Gathered) -> Drawings:
    """Surface of the heap with its flanks, and published discs where there are some of its aspect."""
    shape, remains = heap.shape, gathered.histories.get("heap")
    if shape is None:
        return {}
    lines = [Trace("discs, last frame", shape.x, shape.bed + shape.depth), Trace("bed", shape.x, shape.bed, "faint")]
    for flank, angle in zip(shape.flanks, (heap.angle_left, heap.angle_right), strict=True):
        if isfinite(angle):
            lines.append(Trace(f"flank, {angle:z.1f} degrees", np.array(flank.x), np.array(flank.y), "fit"))
    column = remains.column if isinstance(remains, LastFrames) else None
    theirs = published_shape(column)
    if theirs is not None and column is not None:
        x = column.back + column.sides[-1] * column.base * np.array(theirs.shape.x)
        y = np.interp(x, shape.x, shape.bed) + column.base * np.array(theirs.shape.y)
        lines.append(Trace("discs by contact dynamics", x, y, "measured"))
    panel = Panel("Height [m]", lines, xlim=(heap.left - 2 * heap.height, heap.right + 2 * heap.height))
    return {"heap": Chart("shape of the heap", PLACE, [panel])}


def section(heap: Heap) -> Section:
    """Height and slopes; run-out of a column compared with published ones."""
    if not known(heap.height):
        return Section("Heap", [Text(heap.reason or "", "warn")])
    rows = [*described(heap, "height", "top", "left", "right")]
    for key, words in (("angle", "flanks"), ("angle_left", "left flank"), ("angle_right", "right flank")):
        if known(angle := getattr(heap, key)):
            value = f"{angle:z.1f} ± {sure_of(heap, key).value:z.1f}"
            rows.append((f"Angle of the {words} to the horizontal [degrees], 95 %", value))
    blocks: list[Text | Table] = []
    if heap.at_rest is False:
        blocks.append(Text("The discs still move: shape and run-out are those of the last frame, not at rest.", "warn"))
    if heap.no_run_out:
        blocks.append(Text(f"There is no run-out: {heap.no_run_out}, where they would go further.", "warn"))
    if known(heap.run_out):
        keys = ("base", "aspect", "run_out", "run_out_99", "run_out_over_base", "run_out_99_over_base")
        rows += described(heap, *keys, "height_over_base", "friction")
        published = ("discs", "rods", "sand", "height_rods", "shape_off")
        rows += described(heap, *(key for key in published if known(getattr(heap, key))))
    return Section("Heap", [*blocks, Table(rows)])


FALLEN = "of columns of {} that fall on a level bed"
QUANTITY = Quantity(
    name="heap",
    title="Heap",
    result=Heap,
    definitions="""\
surface       free surface in bins one diameter wide, last frame; height: the largest depth over the bed
angle         straight line through the bins from 80 % down to 20 % of the height, to the horizontal; ± is half of the
              95 % interval, from their scatter about the line; a flank that leans on a wall is none
run-out       L − L₀; L₀ base of the column at the start, half of it where it falls to both sides (the mean is given);
              none where the discs have come to a wall, a step of the bed, an outlet or the end of the domain
fronts        bulk: before the first gap of two diameters between neighbours in x; 99 %: what 1 % of the discs pass
discs, rods, sand   published, for the same a = H₀/L₀; they are of other grains: friction and sizes differ
""",
    collector=HeapWatch,
    analyse=analyse,
    files={"heap.csv": "surface of the heap at the last frame"},
    captions={"heap": "Shape of the heap at the last frame"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(
        HeadlineNumber("run_out_over_base", "rods", "rods", holds=FALLEN.format("rods")),
        HeadlineNumber("run_out_over_base", "sand", "sand", holds=FALLEN.format("sand")),
        HeadlineNumber("height_over_base", "rods", "height_rods", holds=FALLEN.format("rods")),
        HeadlineNumber("angle"),
        HeadlineNumber("height", rank=75),
    ),
    rank=60,
    is_shown=lambda wanted, summary: not wanted.other or part(summary, "heap").get(wanted.other) is not None,
)
