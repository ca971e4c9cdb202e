# SPDX-License-Identifier: GPL-2.0-or-later
"""The front of a collapsing column: where it is, how high the column is, how fast its surface moves.

Definitions (docs/measuring.md): the *bulk front* ends the row of discs that starts at the back wall and has no gap of
two diameters (the largest disc's) or more between neighbours in x; the *99 % front* is the quantile of the discs'
right edges.
"""
# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, isnan, nan, sqrt
from typing import Any, NamedTuple, cast

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described, percent
from lammps_jump.analysis.statistics import known_mean
from lammps_jump.analysis.verdicts.kinds import A_JUMP, against_water, at, part
from lammps_jump.analysis.verdicts.water import has_front, ritter_holds
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.physics import jump as waves
from lammps_jump.physics import measured
from lammps_jump.units import known, number, shown

ASPECT = 2
"""n² = H/a of the columns in Martin & Moyce's tables."""
GAP = 2.0
"""Diameters of empty x that end the bulk."""


@dataclass(frozen=True)
class FrontHistory:
    """Front and column against time; lengths in m from the back wall, NaN where a frame holds no disc.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    bulk, quantile : ndarray
        Bulk front and 99 % front.
    height : ndarray
        Top of the column at the back wall: highest edge of the discs within a diameter of it and connected to the bed.
    top_speed : ndarray
        Speed of the surface: mean velocity (m/s, along x) of the topmost disc of every diameter of x in the bulk.
    tip_speed : ndarray
        Mean velocity along x of the discs within five diameters behind the bulk front, m/s.
    back : float
        Position of the back wall, m.
    column : (float, float)
        Base a and height H of the column at the start, m; NaN where discs come in: nothing collapses then.
    """

    time: np.ndarray
    bulk: np.ndarray
    quantile: np.ndarray
    height: np.ndarray
    top_speed: np.ndarray
    tip_speed: np.ndarray
    back: float
    column: tuple[float, float]


@dataclass(frozen=True)
class Ritter:
    """Bulk front against Ritter's front on a dry, frictionless bed, while that holds."""

    valid_until: float = number("s", "time at which Ritter's wave meets the back wall")
    frames: int = number("", "frames compared")
    front_speed: float = number("m/s", "speed of Ritter's front, 2 √(g H)")
    rms: float = number("", "RMS of the relative difference")


@dataclass(frozen=True)
class MartinMoyce:
    """Front and column height against the measurements of Martin & Moyce (1952), T > 0.8 for the front.

    Their tables belong to n² = 2, and a slope to n² = 1; a column of another shape is held against neither (NaN).
    """

    aspect: float = number("", "aspect n² = H/a (Martin & Moyce: 2)")
    comparable: bool  # type: ignore[misc]  # a `number` is no default
    points: int = number("", "points of their table within the record")
    mean_bulk: float = number("", "Martin & Moyce, bulk front, T > 0.8: mean difference")
    rms_bulk: float = number("", "Martin & Moyce, bulk front, T > 0.8: RMS difference")
    rms_99: float = number("", "Martin & Moyce, 99 % front: RMS difference")
    rms_height: float = number("", "Martin & Moyce, column height: RMS difference")
    slope: float = number("", "slope dZ/dT of the bulk front")
    aspect_of_table: float = number("", "aspect of their column of this shape", default=nan)
    slope_of_table: float = number("", "slope dZ/dT, Martin & Moyce, column of this shape", default=nan)


@dataclass(frozen=True)
class Front:
    """Front of a collapsing column at the last frame that holds discs, its speed, and theory to compare.

    `martin_moyce` is None unless the flow is to be compared with water. Pages and screens then leave Ritter out, too.
    """

    time: float = number("s", "time of the last frame that holds discs", default=nan)
    position: float = number("m", "bulk front at the end", default=nan, label="front at")
    position_99: float = number("m", "99 % of the discs within", default=nan)
    column_height: float = number("m", "column at the back wall at the end", default=nan)
    column_base: float = number("m", "base of the column at the start", default=nan)
    column_depth: float = number("m", "height of the column at the start", default=nan)
    highest_surface_speed: float = number("m/s", "highest mean speed of the surface", default=nan)
    free_length: float = number("m", "distance from the back wall to an obstacle or the end of the bed", default=nan)
    speed: float = number("m/s", "mean speed of the front", default=nan, label="speed")
    arrival_time: float = number("s", "arrival at the first obstacle", default=nan)
    gate_open: float = number("s", "time at which the rising gate is out of the way", default=nan)
    ritter: Ritter | None = None
    martin_moyce: MartinMoyce | None = None
    stopped_by: str | None = None
    reason: str | None = None
    history: FrontHistory | None = field(default=None, metadata={"summary": False})


def back_wall(flow: Flow) -> float | None:
    """Position of the vertical wall that the column leans on, m; None where there is none."""
    starts = (wall.room("x")[0] for wall in flow.scene.permanent)
    return next((start for start in starts if isfinite(start)), None)


def bulk_front(x: np.ndarray, diameter: float, largest: float = 0.0) -> float:
    """Right edge of the last disc before the first gap of `GAP` diameters between neighbours in x; NaN for none.

    `largest` is the diameter (m) that gaps go by, where discs are larger than the diameter.
    """
    if not len(x):
        return nan
    ordered = np.sort(x)
    gaps = np.flatnonzero(np.diff(ordered) > GAP * max(diameter, largest))
    return float(ordered[gaps[0] if gaps.size else -1]) + 0.5 * diameter


def quantile_front(x: np.ndarray, diameter: float, share: float = 0.99) -> float:
    """Right edge that `share` of the discs do not pass, m; NaN for none."""
    return float(np.quantile(x, share)) + 0.5 * diameter if len(x) else nan


def stop_beside(flow: Flow, place: float, side: int) -> str:
    """Neighbours that discs ending at x = `place` (m) touch to their left (`side` -1) or right (1), in words; or empty.

    A wall, a step of the bed, an outlet or the end of the domain within a diameter of them: they would go further.
    """
    scene, d = flow.scene, flow.scene.diameter
    index = 0 if side < 0 else 1
    for wall in scene.permanent:
        if abs(wall.room("x")[index] - place) < d:
            return f"wall '{wall.name}'"
    here, ahead = flow.bed_height(np.array([place - 0.5 * side * d, place + side * d]))
    if ahead - here > d:
        return "a step of the bed"
    ways = "below", "above"
    if any(one.axis == "x" and one.side == ways[index] and side * (one.at - place) < d for one in scene.outlets):
        return "an outlet"
    return "the end of the domain" if side * (scene.domain[0][index] - place) < d else ""


def stack_top(y: np.ndarray, diameter: float, bed: float, largest: float = 0.0) -> float:
    """Top edge of the discs that lie on the bed without a gap of `GAP` diameters, m above it.

    0 for none, NaN where no bed is known.
    """
    if isnan(bed):
        return nan
    if not len(y) or y.min() - bed > 0.5 * diameter + GAP * max(diameter, largest):
        return 0.0
    return bulk_front(y, diameter, largest) - bed


class FrontTracker:
    """Follows the front from frame to frame; ask for `result` at the end."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self.back = back_wall(flow)
        self._rows: list[tuple[float, ...]] = []
        self._column: tuple[float, float] | None = None
        self._of_column = np.zeros(0, np.int64)
        self._fed, self._open = False, self.back is None

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        d, largest = self.flow.scene.diameter, 2 * self.flow.largest_radius(frame)
        if not frame.n:
            return self._rows.append((time, nan, nan, nan, nan, nan))
        # where nominal discs with the same right and top edges would be
        larger = self.flow.radii(frame) - self.flow.scene.radius
        x, y, left = frame.x + larger, frame.y + larger, frame.x - larger
        if self.back is None:  # no wall: the column's own left edge at the start
            self.back = float(left.min()) - 0.5 * d
        if self._open and not (ahead := left >= self.back - 0.5 * d).all():  # the rest runs the other way
            columns = {name: values[ahead] for name, values in frame.columns.items()}
            return self.add(make_frame(frame.step, frame.time, frame.box, columns), time)
        bed = float(self.flow.bed_height(self.back + 0.5 * d))
        near = left - self.back < 0.5 * d + largest
        front = bulk_front(x, d, largest)
        top, tip = nan, nan
        bulk = np.flatnonzero(x + 0.5 * d <= front + 1e-12)
        if bulk.size and self.flow.velocities and "vx" in frame.columns:
            strip = ((x[bulk] - self.back) / d).astype(int)
            order = np.lexsort((y[bulk], strip))
            highest = order[np.flatnonzero(np.diff(strip[order], append=strip.max() + 1))]
            top = float(known_mean(frame.vx[bulk[highest]]))
            tip = float(known_mean(frame.vx[bulk[x[bulk] + 0.5 * d >= front - 5 * d]]))
        height = stack_top(y[near], d, bed, largest)
        # the column when the gate opens; NaN where no disc is at the back wall
        if self._column is None or time <= 0:
            self._column, self._of_column = (front - self.back if height != 0 else nan, height or nan), frame.ids
        self._fed = self._fed or not np.isin(frame.ids, self._of_column).all()
        self._rows.append((time, front - self.back, quantile_front(x, d) - self.back, height, top, tip))

    def result(self) -> FrontHistory:
        """The history of all frames added."""
        rows = np.array(self._rows, float).reshape(-1, 6)
        column = self._column if self._column and not self._fed else (nan, nan)
        time, bulk, quantile, height, top, tip = rows.T
        return FrontHistory(time, bulk, quantile, height, top, tip, nan if self.back is None else self.back, column)


def rms(off: np.ndarray) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(off**2))) if len(off) else nan


def off_curve(x: np.ndarray, y: np.ndarray, curve_x: Any, curve_y: Any, beyond: float = -inf) -> np.ndarray:
    """Relative difference of y(x), linear in between, at the points x > `beyond` of a curve that x covers."""
    good = np.isfinite(x) & np.isfinite(y)
    if not good.any():
        return np.empty(0)
    x, y, curve_x = x[good], y[good], np.asarray(curve_x, float)
    take = (curve_x > beyond) & (curve_x <= x.max()) & (curve_x >= x.min())
    return np.interp(curve_x[take], x, y) / np.asarray(curve_y, float)[take] - 1.0


def dimensionless(history: FrontHistory, gravity: float) -> dict[str, np.ndarray]:
    """Martin & Moyce's variables: T = n t sqrt(g/a), tau = t sqrt(g/a), Z = front/a (both fronts), h/H; n^2 = H/a."""
    base, height = history.column
    tau = history.time * sqrt(gravity / base)
    return {
        "T": sqrt(height / base) * tau,
        "tau": tau,
        "Z": history.bulk / base,
        "Z99": history.quantile / base,
        "h": history.height / height,
    }


class Way(NamedTuple):
    """Way before a front.

    Attributes
    ----------
    length : float
        Distance from the back wall to the first thing in the way, or to where the bed ends or turns, m; infinite for
        none, NaN where no bed is known under the front.
    blocked : bool
        Something is there, or the bed rises; a slope that levels out does not.
    """

    length: float
    blocked: bool


def way(flow: Flow, history: FrontHistory, base: float) -> Way:
    """Way before a front at `base`, m from the back wall."""
    base = history.back + base
    probe = np.linspace(base, flow.scene.domain[0][1], 2000)
    height = flow.bed_height(probe)
    if not (np.isfinite(height[:2]).all() and probe[1] > probe[0]):  # a channel that is full has no way before it
        return Way(nan, False)
    slope = (height[1] - height[0]) / (probe[1] - probe[0])
    straight = height[0] + slope * (probe - base)
    blocks = [(wall.extent[0][0], wall.extent[1][1]) for wall in flow.scene.permanent if wall.finite]
    near = base + flow.scene.diameter
    faces = [start for start, top in blocks if start > near and top > height[0] + slope * (start - base) + 1e-9]
    face = min([*faces, *(wall.room("x")[1] for wall in flow.scene.permanent)], default=inf)
    # the bed may end, or turn, before anything is in the way
    changed = np.flatnonzero(~(np.abs(height - straight) < 1e-9))
    if changed.size and probe[k := changed[0]] < face:
        return Way(float(probe[k]) - history.back, bool(height[k] > max(straight[k], height[k - 1] + 1e-9)))
    return Way(float(face) - history.back, isfinite(face))


def rising_gate(flow: Flow, x: float) -> float:
    """Time (s) at which a sheet that rises at the face of the column (x, m) stands still, NaN where there is none."""
    for wall, motion in flow.scene.walls:
        (low, high), _ = wall.extent
        until = motion.kind.until if motion.kind is not None else None
        if until is not None and low - flow.scene.diameter <= x <= high + flow.scene.diameter:
            return float(until)
    return nan


def analyse_front(history: FrontHistory, flow: Flow) -> Front:
    """Front at the end, its speed, Ritter's front while that holds; with `Flow.water` Martin & Moyce's tables."""
    good = np.isfinite(history.bulk)
    base, depth = history.column
    if not good.any() or base <= 0:
        return Front(reason="no frame holds a disc, so there is no front", history=history)
    last, gravity = np.flatnonzero(good)[-1], flow.gravity
    compared = gravity > 0 and depth > 0 and flow.timed
    base = base if isfinite(base) else float(history.bulk[good][0])
    free, blocked = way(flow, history, base)
    live = good & (history.time >= 0)
    # once the front meets an obstacle, neither theory holds any more; without a bed none ever does
    met = history.time[live & ~(history.bulk < free - 0.5 * flow.scene.diameter)]
    end = min(met.tolist(), default=inf)
    running = live & (history.time < end) & (history.bulk > base + 0.1 * (free - base if isfinite(free) else base))
    speed = np.polyfit(history.time[running], history.bulk[running], 1)[0] if running.sum() >= 3 else nan
    return Front(
        time=float(history.time[last]) if flow.timed else nan,
        position=float(history.back + history.bulk[last]),
        position_99=float(history.back + history.quantile[last]),
        column_height=float(history.height[last]),
        column_base=history.column[0],
        column_depth=depth,
        highest_surface_speed=float(np.nanmax(history.top_speed)) if np.isfinite(history.top_speed).any() else nan,
        free_length=free,
        speed=float(speed) if flow.timed else nan,
        arrival_time=end if flow.timed and isfinite(end) and blocked else nan,
        gate_open=rising_gate(flow, base + history.back),
        ritter=_ritter(history, base, depth, gravity, end) if compared else None,
        martin_moyce=_martin_moyce(history, gravity, end) if compared and flow.water else None,
        stopped_by=stop_beside(flow, float(history.back + history.bulk[last]), 1) or None,
        reason=None if blocked else _no_arrival(free, end),
        history=history,
    )


def _no_arrival(free: float, end: float) -> str | None:
    """Why there is no time of arrival, where the way of the front has ended without an obstacle."""
    if isnan(free):
        return "no bed is known under the front of the column: neither its mean speed nor an arrival is measured"
    if isfinite(end):
        return f"the bed ends, falls or levels out {free:z.3g} m from the back wall, so the front has met no obstacle"
    return None


def _ritter(history: FrontHistory, base: float, depth: float, gravity: float, end: float) -> Ritter | None:
    """Ritter's front compared with that of the discs; None without a frame to compare."""
    limit = waves.ritter_wall_time(base, depth, gravity)
    inside = (history.time > 0) & (history.time <= min(limit, end)) & np.isfinite(history.bulk)
    if not inside.any():
        return None
    expected = base + np.array([waves.ritter_front(t, depth, gravity) for t in history.time[inside]])
    return Ritter(limit, int(inside.sum()), 2.0 * sqrt(gravity * depth), rms(history.bulk[inside] / expected - 1.0))


def _martin_moyce(history: FrontHistory, gravity: float, end: float) -> MartinMoyce:
    live = (history.time >= 0) & (history.time <= end)
    variables = {name: values[live] for name, values in dimensionless(history, gravity).items()}
    front, tall = measured.MARTIN_MOYCE_FRONT, measured.MARTIN_MOYCE_HEIGHT
    curves = ("T", "Z", front, 0.8), ("T", "Z99", front, 0.8), ("tau", "h", tall, -inf)
    straight = (variables["T"] >= 1.43) & (variables["T"] <= 3.33) & np.isfinite(variables["Z"])
    slope = np.polyfit(variables["T"][straight], variables["Z"][straight], 1)[0] if straight.sum() >= 3 else nan
    aspect = history.column[1] / history.column[0]
    own = next((shape for shape in measured.MARTIN_MOYCE_FRONT_SLOPE if abs(aspect - shape) < 0.1), nan)
    bulk, most, column = (
        off_curve(variables[x], variables[y], table.x, table.y, beyond) if own == ASPECT else np.empty(0)
        for x, y, table, beyond in curves
    )
    return MartinMoyce(
        aspect=aspect,
        comparable=own == ASPECT,
        points=len(bulk),
        mean_bulk=float(bulk.mean()) if len(bulk) else nan,
        rms_bulk=rms(bulk),
        rms_99=rms(most),
        rms_height=rms(column),
        slope=float(slope),
        aspect_of_table=float(own),
        slope_of_table=measured.MARTIN_MOYCE_FRONT_SLOPE.get(own, nan),
    )


def analyse(gathered: Gathered) -> Front:
    """Front of a run."""
    return analyse_front(gathered.histories["front"], gathered.flow)


def tables(front: Front) -> Tables:
    """Front and column against time, m and m/s."""
    return {"front.csv": {name: value for name, value in vars(front.history).items() if isinstance(value, np.ndarray)}}


def figures(front: Front, gathered: Gathered) -> Drawings:
    """The front against time. Of water also the measurements of Martin & Moyce."""
    flow, history = gathered.flow, cast(FrontHistory, front.history)
    water = martin_moyce_chart(history, flow) if flow.water else None
    return {"front": front_chart(history, flow), "martin_moyce": water}


def section(front: Front) -> Section:
    """The numbers of the front. Those of water are listed with Ritter and Martin & Moyce."""
    if not known(front.position):
        return Section("Front", [Text(shown(front.reason), "warn")])
    rows: list[tuple[str, Any]] = []
    if known(front.column_base):
        size = " × ".join(shown(value, digits=3) for value in (front.column_base, front.column_depth))
        rows.append(("Column at the start, base × height [m]", size))
    rows += described(front, "position", "position_99", "column_height", "speed", "arrival_time")
    moyce, ritter = front.martin_moyce, front.ritter
    if moyce and ritter:
        until = f"Ritter's front, holds until t = {ritter.valid_until:z.2g} s: RMS difference"
        rows.append((until, percent(ritter.rms)))
    if moyce:
        rows += described(moyce, "aspect")
        keys = ("mean_bulk", "rms_bulk", "rms_99", "rms_height") if moyce.comparable else ()
        rows += [(label, percent(value)) for label, value in described(moyce, *keys)]
        rows += described(moyce, "slope", "slope_of_table")
    return Section("Front", [Table(rows), *([Text(front.reason, "warn")] if front.reason else [])])


def front_chart(history: FrontHistory, flow: Flow) -> Chart | None:
    """Front, column height and surface speed against time. Of water also Ritter's front while it holds."""
    if not np.isfinite(history.bulk).any():
        return None
    (base, depth), gravity, time = history.column, flow.gravity, history.time
    fronts = [Trace("bulk front", time, history.bulk), Trace("99 % of the discs", time, history.quantile, "second")]
    if flow.water and gravity > 0 and depth > 0 and flow.timed:
        limit = waves.ritter_wall_time(base, depth, gravity)
        t = np.linspace(0, max(min(limit, time.max()), 1e-9), 20)
        label = f"Ritter, until its wave meets the back wall (t = {limit:z.2g} s)"
        fronts.append(Trace(label, t, base + 2 * t * np.sqrt(gravity * depth), "theory"))
    speeds = (
        Trace("surface, mean", time, history.top_speed),
        Trace("tip (last 5 d)", time, history.tip_speed, "second"),
    )
    panels = (
        Panel("Distance from\nthe back wall [m]", fronts, height=1.5),
        Panel("Column at the\nback wall [m]", (Trace("column", time, history.height),), ylim=(0.0, None)),
        Panel("Velocity u [m/s]", speeds),
    )
    return Chart("front and column", flow.time_axis, panels)


def martin_moyce_chart(history: FrontHistory, flow: Flow) -> Chart | None:
    """Front and column height in Martin & Moyce's variables, with their measurements."""
    gravity, (base, depth) = flow.gravity, history.column
    if not (flow.timed and np.isfinite(history.bulk).any() and gravity > 0 and base > 0 and depth > 0):
        return None
    values, live = dimensionless(history, gravity), history.time >= 0
    if live.sum() < 2:
        return None
    ahead, same = way(flow, history, base), abs(depth / base - ASPECT) < 0.1
    fronts = [
        Trace("bulk front", values["T"][live], values["Z"][live]),
        Trace("99 % of the discs", values["T"][live], values["Z99"][live], "second"),
    ]
    columns = [Trace("column", values["tau"][live], values["h"][live])]
    for lines, table in ((fronts, measured.MARTIN_MOYCE_FRONT), (columns, measured.MARTIN_MOYCE_HEIGHT)):
        lines += (
            [Trace("Martin & Moyce 1952, n² = 2", np.array(table.x), np.array(table.y), "measured")] if same else []
        )
    free = ahead.length / base if ahead.blocked else inf
    top = max(5.0, 1.08 * min(free, 6))
    obstacle = {"first obstacle": free} if free < top else {}
    ends = (0.0, float(min(values["T"].max(), 5))), (0.0, float(min(values["tau"].max(), 5.5)))
    panels = (
        Panel("Z = front / a", fronts, "T = n t √(g/a)", obstacle, xlim=ends[0], ylim=(1.0, top)),
        Panel("h / H", columns, "τ = t √(g/a)", xlim=ends[1], ylim=(0.0, 1.05)),
    )
    return Chart(f"n² = H/a = {depth / base:z.3g}{'' if same else ': no measured curve'}", "", panels)


RITTER = "ritter.front_speed"
WATER = """\
Ritter        front of water in an endless reservoir, a + 2 √(g H) t, until its wave meets the back wall
T, Z, n²      n t √(g/a), front/a, H/a of the column of base a and height H at the start
dZ/dT         slope of the bulk front over T, from Martin & Moyce's table beside it where that has the same n²
"""
"""Meaning of its numbers where it is compared with water."""


def _goes(wanted: HeadlineNumber, summary: Mapping[str, Any]) -> bool:
    front = part(summary, "front")
    if wanted.key == "speed" and (wanted.other == RITTER) != ritter_holds(front):
        return False
    return _is_shown(summary) and part(summary, "jump").get("verdict") not in A_JUMP


def _is_shown(summary: Mapping[str, Any]) -> bool:
    return "given" not in summary or has_front(summary)


def _time(summary: Mapping[str, Any]) -> dict[str, str]:
    time = at(summary, "front.time")
    return {"time": "the last frame" if time is None else f"{time:z.3g} s"}


QUANTITY = Quantity(
    name="front",
    title="Front of a collapse",
    result=Front,
    definitions="""\
bulk front    right edge of the last disc in x before the first gap of two diameters between neighbours' centres;
              without a back wall of the discs from the column's left edge on
99 % front    right edge that 99 % of the discs do not pass
column        top of the discs within one diameter of the back wall, up to the first vertical gap of two diameters
speed         straight line through the bulk front, from a tenth of the free path to the first obstacle
errors        none: one run cannot tell; repeat it from other starts
""",
    beside=WATER,
    collector=FrontTracker,
    analyse=analyse,
    files={"front.csv": "front and column against time"},
    captions={"front": "Front and column", "martin_moyce": "Against Martin & Moyce (1952)"},
    tables=tables,
    figures=figures,
    linked="front",
    section=section,
    headline=(
        HeadlineNumber("position", label="front after {time}"),
        HeadlineNumber("speed", "Ritter", RITTER, holds="of a wave of water on a dry, level bed without friction"),
        HeadlineNumber("speed"),
        HeadlineNumber(
            "martin_moyce.mean_bulk",
            "discs: −20 to 0 %",
            label="off Martin & Moyce’s water",
            scale=0.01,
            unit="%",
            result=MartinMoyce,
        ),
        HeadlineNumber("arrival_time", rank=115),
        HeadlineNumber("column_height", label="column at the back wall", rank=115),
        HeadlineNumber("position_99", rank=115),
    ),
    rank=90,
    is_shown=_goes,
    label_values=_time,
    shown=_is_shown,
    defined=lambda summary: WATER if against_water(part(summary, "front")) else "",
)
