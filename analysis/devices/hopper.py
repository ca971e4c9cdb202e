# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs that leave through gaps between walls: their mass in a second, while the flow is on.

Which gaps these are follows from walls and tracks (`gaps`). The window runs by itself from flow on to flow off: from
the first to the last time at which the discharge is at least half of its usual value. A window that the case asks for
cuts it.

A *gap* is a straight line from a corner or an end of a standing wall to the nearest place of another face. It is a
narrow place: along both walls the distance grows. Of gaps that the same discs pass one after the other, the narrowest
counts. The tracks of the discs decide which gaps are outlets: nothing is assumed of their place.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import atan2, degrees, hypot, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described, percent
from lammps_jump.analysis.statistics import piece_bounds, piece_error
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import devices
from lammps_jump.scene.chains import ARC, AT_START, CX, CY, ENDLESS, KIND, PHI, RADIUS, SWEEP, TX0, TY0, X0, X1, Y0, Y1
from lammps_jump.scene.scene import Scene
from lammps_jump.units import Estimates, estimate, known, number

PIECES = 8
"""Straight pieces that replace an arc of at most a quarter turn."""
SQUARE = 1e-6
"""Cosine up to which a face counts as square to a gap."""
FEWEST = 5
"""Discs that must pass a gap."""
LEAST = 0.05
"""Share of the discs of the busiest gap that must pass another one."""
SERIES = 0.5
"""Share of common discs from which on two gaps are in series."""


class Gap(NamedTuple):
    """Both ends of a gap, m."""

    start: tuple[float, float]
    end: tuple[float, float]

    @property
    def width(self) -> float:
        """Its length, m."""
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    @property
    def middle(self) -> tuple[float, float]:
        """Its middle, m."""
        return 0.5 * (self.start[0] + self.end[0]), 0.5 * (self.start[1] + self.end[1])

    def left_of(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance (m) of points from its line, above 0 to the left of the way from start to end."""
        (x0, y0), (x1, y1) = self
        return ((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / self.width


@dataclass(frozen=True)
class GapFlow:
    """A gap and the discs that have passed it, in the direction of most.

    Attributes
    ----------
    gap : Gap
    side : int
        1 where discs pass to the left of the way from start to end, else -1.
    ids : ndarray, shape (discs,)
        In the order of `time`.
    time : ndarray, shape (discs,), s
        When each disc passed for the last time.
    mass : ndarray, shape (discs,)
        Of the disc over that of the nominal disc.
    """

    gap: Gap
    side: int
    ids: np.ndarray
    time: np.ndarray
    mass: np.ndarray

    @property
    def turn(self) -> float:
        """Angle from the direction -y to the way of the discs, counter-clockwise, degrees."""
        (x0, y0), (x1, y1) = self.gap
        # of the left normal (y0 - y1, x1 - x0), times the side; a turn of -y by the angle is (sin, -cos)
        return degrees(atan2(self.side * (y0 - y1), -self.side * (x1 - x0))) + 0.0


class FaceEnds(NamedTuple):
    """Straight faces: their ends, shapes (faces, 2), m, and for each end the directions in which faces leave it."""

    start: np.ndarray
    end: np.ndarray
    leaving: dict[tuple[float, float], list[np.ndarray]]


def straight_faces(scene: Scene) -> FaceEnds:
    """Faces of the walls at rest, arcs in pieces, and the rows of rough beds."""
    reach = 2.0 * max(high - low for low, high in scene.domain)
    shapes = [one.wall.faces for one in scene.walls if one.motion.kind is None and one.wall in scene.permanent]
    lines = [line for faces in shapes for line in _lines(faces.codes, faces.shape, reach)]
    lines += _rows(scene)
    leaving: dict[tuple[float, float], list[np.ndarray]] = {}
    ends = []
    for points, endless in lines:
        ends += list(pairwise(points))
        for one, other in () if endless else ends[1 - len(points) :]:
            along = (other - one) / np.hypot(*(other - one))
            leaving.setdefault(_key(one), []).append(along)
            leaving.setdefault(_key(other), []).append(-along)
    start, end = np.array(ends, float).reshape(-1, 2, 2).transpose(1, 0, 2)
    return FaceEnds(start, end, leaving)


def _key(point: np.ndarray) -> tuple[float, float]:
    return round(float(point[0]), 9), round(float(point[1]), 9)


def _lines(codes: np.ndarray, shape: np.ndarray, reach: float) -> list[tuple[np.ndarray, bool]]:
    """Corners of each face, shape (points, 2), and whether it has no ends."""
    lines = []
    for code, one in zip(codes, shape, strict=True):
        if code[AT_START] == ENDLESS:
            along = reach * one[[TX0, TY0]]
            lines.append((np.array([one[[X0, Y0]] - along, one[[X0, Y0]] + along]), True))
        elif code[KIND] == ARC:
            angle = one[PHI] - np.copysign(0.5 * np.pi, one[RADIUS]) + one[SWEEP] * np.linspace(0, 1, PIECES + 1)
            round_ = one[[CX, CY]] + abs(one[RADIUS]) * np.column_stack([np.cos(angle), np.sin(angle)])
            lines.append((round_, False))
        else:
            lines.append((one[[X0, Y0, X1, Y1]].reshape(2, 2), False))
    return lines


def _rows(scene: Scene) -> list[tuple[np.ndarray, bool]]:
    """Lines through neighbours of a rough bed, through which no disc passes."""
    if scene.fixed is None:
        return []
    places = scene.positions[scene.fixed.first - 1 : scene.fixed.last]
    near = np.hypot(*np.diff(places, axis=0).T) < 2.0 * scene.diameter
    return [(places[k : k + 2], False) for k in np.flatnonzero(near)]


def gaps_of(scene: Scene) -> list[Gap]:
    """Every narrow place between standing walls through which the smallest disc fits, the narrowest first."""
    start, end, leaving = straight_faces(scene)
    gaps: dict[tuple[Any, ...], Gap] = {}
    along = end - start
    squared = np.einsum("ij,ij->i", along, along)
    for corner in leaving:
        here = np.array(corner)
        share = np.clip(np.einsum("ij,ij->i", here - start, along) / squared, 0.0, 1.0)
        nearest = start + share[:, None] * along
        far = np.hypot(*(nearest - here).T)
        with np.errstate(invalid="ignore", divide="ignore"):
            towards = np.max(np.array(leaving[corner]) @ (nearest - here).T / far, axis=0)
        for k in np.flatnonzero((far > scene.smallest) & (towards <= SQUARE)):
            there, ends = nearest[k], tuple(sorted((corner, _key(nearest[k]))))
            if ends not in gaps and _narrow(there, here, leaving) and not _blocked(here, there, start, end):
                gaps[ends] = Gap(*ends)
    return sorted(gaps.values(), key=lambda gap: (round(gap.width / scene.diameter, 6), -gap.middle[1]))


def _narrow(one: np.ndarray, other: np.ndarray, leaving: dict[tuple[float, float], list[np.ndarray]]) -> bool:
    """Tells whether no face leads from one point towards the other."""
    across = (other - one) / np.hypot(*(other - one))
    return max((float(way @ across) for way in leaving.get(_key(one), ())), default=0.0) <= SQUARE


def _blocked(one: np.ndarray, other: np.ndarray, start: np.ndarray, end: np.ndarray) -> bool:
    """Tells whether a face crosses the way from one point to another, or touches it between them."""
    across, along, off = other - one, end - start, start - one
    cross = across[0] * along[:, 1] - across[1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / cross
        place = (off[:, 0] * across[1] - off[:, 1] * across[0]) / cross
    inside = (share > 1e-6) & (share < 1.0 - 1e-6) & (place > -1e-9) & (place < 1.0 + 1e-9)
    return bool(inside.any())


class Crossings:
    """Collects the discs that cross gaps from one frame to the next; straight ways between frames."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow, self.gaps = flow, gaps_of(flow.scene)
        self.longest = 0.5 * (flow.scene.domain[0][1] - flow.scene.domain[0][0])  # beyond: it left by a joined end
        self._before: tuple[Frame, float, np.ndarray] | None = None
        self._events: list[tuple[np.ndarray, ...]] = []
        self.times: list[float] = []
        self.begin: Frame | None = None

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        order = np.argsort(frame.ids, kind="stable")
        if self._before is not None and self.gaps:
            self._cross(frame, time, order)
        self.begin = self.begin or frame
        self._before = frame, time, order
        self.times.append(time)

    def _cross(self, frame: Frame, time: float, order: np.ndarray) -> None:
        assert self._before is not None
        before, since, order_before = self._before
        ids, then, now = np.intersect1d(before.ids[order_before], frame.ids[order], True, return_indices=True)
        then, now = order_before[then], order[now]
        x0, y0, x1, y1 = before.x[then], before.y[then], frame.x[now], frame.y[now]
        mass = self.flow.relative_masses(frame)[now]
        for which, gap in enumerate(self.gaps):
            one, other = gap.left_of(x0, y0), gap.left_of(x1, y1)
            crossed = np.flatnonzero(((one < 0) != (other < 0)) & (np.abs(x1 - x0) < self.longest))
            share = one[crossed] / (one[crossed] - other[crossed])
            x, y = (p[crossed] + share * (q[crossed] - p[crossed]) for p, q in ((x0, x1), (y0, y1)))
            (ax, ay), (bx, by) = gap
            place = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / gap.width**2
            inside = (place >= 0.0) & (place <= 1.0)
            hit = crossed[inside]
            if hit.size:
                side = np.where(other[hit] < 0, -1, 1)
                when = since + share[inside] * (time - since)
                self._events.append((np.full(hit.size, which), ids[hit], when, side, mass[hit]))

    def outlets(self) -> list[GapFlow]:
        """The gaps that discs pass; of those in series the narrowest."""
        if not self._events:
            return []
        number, ids, time, side, mass = (np.concatenate(column) for column in zip(*self._events, strict=True))
        every = [
            _passed(gap, ids[here], time[here], side[here], mass[here])
            for k, gap in enumerate(self.gaps)
            if (here := number == k).any()
        ]
        most = max(len(one.ids) for one in every)
        return in_parallel([one for one in every if len(one.ids) >= max(FEWEST, LEAST * most)])

    def result(self) -> Crossings:
        """All that crossed."""
        return self


def _passed(gap: Gap, ids: np.ndarray, time: np.ndarray, side: np.ndarray, mass: np.ndarray) -> GapFlow:
    """The discs that end on the other side of a gap than they began, in the direction of most."""
    known, index = np.unique(ids, return_inverse=True)
    net = np.bincount(index, side)
    way = 1 if net.sum() >= 0 else -1
    last = np.zeros(len(known), int)
    np.maximum.at(last, index, np.arange(len(ids)))  # events are in the order of time
    last = last[net * way > 0]
    last = last[np.argsort(time[last], kind="stable")]
    return GapFlow(gap, way, ids[last], time[last], mass[last])


def in_parallel(every: Sequence[GapFlow]) -> list[GapFlow]:
    """Of outlets, the narrowest first, those that do not share their discs with a narrower one."""
    kept: list[GapFlow] = []
    for one in every:
        common = [len(np.intersect1d(one.ids, other.ids)) / min(len(one.ids), len(other.ids)) for other in kept]
        if max(common, default=0.0) <= SERIES:
            kept.append(one)
    return kept


PIECE = 0.05
"""Share of the record over which the discharge at a time is taken."""
DISCS = 10
"""Discs that pass in that time, at least."""
ON = 0.5
"""Share of the usual discharge from which on the flow is on."""
DOWN = 30.0
"""Largest angle between the way of the discs and gravity at which the law for outlets in a floor is used, degrees."""


@dataclass(frozen=True)
class Hopper(Estimates):
    """Discs that leave through gaps, from flow on to flow off."""

    discharge: float = estimate("kg/s/m", "mass of discs through all gaps in a second", label="discharge")
    change: float = number(
        "", "discharge of the second half of the window over that of the first, less one", default=nan
    )
    slot: float = number("m", "width of the gap, where there is one alone", default=nan, label="width of the gap")
    slot_in_diameters: float = number("", "width of that gap over the diameter", default=nan)
    beverloo: float = number(
        "", "discharge over ρ √g (D − 1.4 d)^1.5, after Beverloo", default=nan, label="over ρ √g (D − 1.4 d)^1.5"
    )
    left: float = number("", "share of the mass that is left above the gaps at the end of the window", default=nan)
    begin: float = number("s", "flow on: begin of the window", default=nan)
    end: float = number("s", "flow off: end of the window", default=nan)
    goes_on: bool | None = None
    discs: int = number("", "discs that passed in the window", default=0)
    pause: float = number("s", "longest time in the window in which no disc passes", default=nan)
    usual_pause: float = number("s", "window over the discs that passed in it", default=nan)
    gaps: int = number("", "gaps that discs pass beside each other", default=0)
    gap_x: tuple[float, ...] = ()
    gap_y: tuple[float, ...] = ()
    gap_width: tuple[float, ...] = ()
    gap_turn: tuple[float, ...] = ()
    gap_discharge: tuple[float, ...] = ()
    gap_discs: tuple[int, ...] = ()
    no_beverloo: str | None = None
    reason: str | None = None
    time: np.ndarray | None = field(default=None, metadata={"summary": False})
    mass: np.ndarray | None = field(default=None, metadata={"summary": False})
    passed: np.ndarray | None = field(default=None, metadata={"summary": False})


def analyse(gathered: Gathered) -> Hopper:
    """Discharge through gaps; with a reason where none is found."""
    flow, watch = gathered.flow, gathered.histories["hopper"]
    assert isinstance(watch, Crossings)
    if not watch.gaps:
        return Hopper(reason="no two walls that stand leave a gap between them")
    outlets = watch.outlets()
    if not outlets:
        return Hopper(reason="discs pass no gap between walls that stand")
    time = np.array(watch.times)
    nominal = flow.scene.mass
    passed = np.array([nominal * _sum_until(one, time) for one in outlets])
    requested = flow.window if flow.asked_window and flow.window else (-np.inf, np.inf)
    window = flow_on(time, passed.sum(axis=0), sum(len(one.ids) for one in outlets), requested)
    known = {"time": time, "passed": passed, "mass": _above(flow, watch, outlets, passed), **_gaps(outlets)}
    if window is None:
        return Hopper(**known, reason="fewer than four frames lie between flow on and flow off")
    return Hopper(**known, **_discharge(flow, outlets, known, window, ends=flow_ends(time, passed.sum(axis=0))))


def _sum_until(outlet: GapFlow, time: np.ndarray) -> np.ndarray:
    """Sum of the masses that have passed up to each time."""
    total = np.append(0.0, np.cumsum(outlet.mass))
    return total[np.searchsorted(outlet.time, time, side="right")]


def flow_on(
    time: np.ndarray, passed: np.ndarray, discs: int, requested: tuple[float, float]
) -> tuple[float, float] | None:
    """Begin and end of the flow, s, within a requested window; None where the window has fewer than four frames.

    Parameters
    ----------
    time : ndarray, shape (frames,), s
    passed : ndarray, shape (frames,), kg/m
        Mass that has passed up to each frame.
    discs : int
        Discs that have passed, in all.
    requested : (float, float)
        s.
    """
    rate = discharge_over_time(time, passed, max(PIECE, DISCS / max(discs, 1)))
    there = np.isfinite(rate) & (time >= requested[0]) & (time <= requested[1])
    flowing = rate[there & (rate > 0)]
    if not flowing.size:
        return None
    # the rate at which half of the mass passes faster
    order = np.sort(flowing)
    usual = order[np.searchsorted(np.cumsum(order), 0.5 * order.sum())]
    on = np.flatnonzero(there & (rate >= ON * usual))
    return (float(time[on[0]]), float(time[on[-1]])) if on[-1] - on[0] >= 3 else None


def flow_ends(time: np.ndarray, passed: np.ndarray) -> bool:
    """Tells whether no disc passes any more in the last `PIECE` of the record."""
    return bool(passed[time >= time[-1] - PIECE * (time[-1] - time[0])][0] == passed[-1])


def _gaps(outlets: Sequence[GapFlow]) -> dict[str, Any]:
    """Places, widths and directions of the gaps, by key."""
    return {
        "gaps": len(outlets),
        "gap_x": tuple(one.gap.middle[0] for one in outlets),
        "gap_y": tuple(one.gap.middle[1] for one in outlets),
        "gap_width": tuple(one.gap.width for one in outlets),
        "gap_turn": tuple(one.turn for one in outlets),
    }


def _discharge(
    flow: Flow, outlets: Sequence[GapFlow], known: Mapping[str, Any], window: tuple[float, float], *, ends: bool
) -> dict[str, Any]:
    """Numbers of the window, by key."""
    time, passed, mass, scene = known["time"], known["passed"], known["mass"], flow.scene
    inside = (time >= window[0]) & (time <= window[1])
    t, each = time[inside], passed[:, inside]
    total, half = each.sum(axis=0), len(t) // 2
    rate, first, second = (slope_of(t[part], total[part]) for part in (slice(None), slice(half + 1), slice(half, None)))
    bounds = piece_bounds(len(t))
    pieces = [(total[b] - total[a]) / (t[b] - t[a]) for a, b in pairwise(bounds)]
    passes = np.sort(np.concatenate([one.time for one in outlets]))
    passes = passes[(passes >= window[0]) & (passes <= window[1])]
    alone = outlets[0].gap.width if len(outlets) == 1 else nan
    why = "" if len(outlets) == 1 else f"discs pass {len(outlets)} gaps beside each other"
    why = why or _no_beverloo(alone / scene.diameter, outlets[0].turn)
    known_mass = mass is not None and mass[0] > 0
    return {
        "discharge": rate,
        "discharge_error": piece_error(np.array(pieces)) if pieces else nan,
        "change": second / first - 1.0 if first > 0 else nan,
        "slot": alone,
        "slot_in_diameters": alone / scene.diameter,
        "beverloo": nan if why else devices.beverloo_number(rate, alone, scene.diameter, scene.density, flow.g),
        "no_beverloo": why or None,
        "left": float(np.interp(window[1], time, mass) / mass[0]) if known_mass else nan,
        "begin": window[0],
        "end": window[1],
        "goes_on": not ends,
        "discs": len(passes),
        "pause": float(np.diff([window[0], *passes, window[1]]).max()),
        "usual_pause": (window[1] - window[0]) / max(len(passes), 1),
        "gap_discharge": tuple(slope_of(t, one) for one in each),
        "gap_discs": tuple(len(one.ids) for one in outlets),
    }


def _no_beverloo(width: float, turn: float) -> str:
    """Why Beverloo's law does not hold for one gap of this width (diameters) and way (degrees from -y); else empty."""
    if abs(turn) > DOWN:
        return f"discs pass at {abs(turn):z.0f} degrees to gravity, and the law is for gaps in a floor"
    if width < devices.BEVERLOO_FROM:
        return (
            f"the gap is {width:z.1f} d wide; the law holds from {devices.BEVERLOO_FROM:zg} d on, below it discs arch"
        )
    return ""


def _above(flow: Flow, crossings: Crossings, outlets: Sequence[GapFlow], passed: np.ndarray) -> np.ndarray | None:
    """Mass before the gaps at each time, kg/m; None where discs come in meanwhile."""
    frame, scene = crossings.begin, flow.scene
    if frame is None or scene.inlets or scene.pours:
        return None
    far = [np.hypot(frame.x - one.gap.middle[0], frame.y - one.gap.middle[1]) for one in outlets]
    sides = np.array([one.side * one.gap.left_of(frame.x, frame.y) for one in outlets])
    before = np.take_along_axis(sides, np.argmin(far, axis=0)[None], 0)[0] < 0
    return scene.mass * float(flow.relative_masses(frame)[before].sum()) - passed.sum(axis=0)


def slope_of(time: np.ndarray, mass: np.ndarray) -> float:
    """Slope of the straight line through masses (kg/m) against times (s), kg/s/m; NaN for fewer than two."""
    return float(np.polyfit(time, mass, 1)[0]) if len(time) > 1 else nan


def discharge_over_time(time: np.ndarray, passed: np.ndarray, piece: float = PIECE) -> np.ndarray:
    """Discharge against time, kg/s/m: mass that passes in a piece of the record around each frame; NaN at its ends.

    Parameters
    ----------
    time : ndarray, shape (frames,), s
    passed : ndarray, shape (frames,), kg/m
        Mass that has passed up to each frame.
    piece : float
        Share of the record.
    """
    rates, reach = np.full(len(time), nan), max(1, round(0.5 * piece * len(time)))
    if len(time) > 2 * reach:
        rates[reach:-reach] = (passed[2 * reach :] - passed[: -2 * reach]) / (time[2 * reach :] - time[: -2 * reach])
    return rates


def tables(hopper: Hopper) -> Tables:
    """Mass before the gaps, kg/m, discharge of all and of each gap, kg/s/m, against time."""
    if hopper.time is None or hopper.passed is None:
        return {}
    columns = {"time": hopper.time} | ({"mass": hopper.mass} if hopper.mass is not None else {})
    columns |= {"discharge": discharge_over_time(hopper.time, hopper.passed.sum(axis=0))}
    if len(hopper.passed) > 1:
        columns |= {f"discharge_{k}": discharge_over_time(hopper.time, one) for k, one in enumerate(hopper.passed, 1)}
    return {"hopper.csv": columns}


def figures(hopper: Hopper, gathered: Gathered) -> Drawings:
    """Mass before the gaps, and the discharge, against time."""
    if hopper.time is None or hopper.passed is None:
        return {}
    total = hopper.passed.sum(axis=0)
    mean = {"mean of the window": hopper.discharge / 1e3} if isfinite(hopper.discharge) else {}
    rates = [Trace("", hopper.time, discharge_over_time(hopper.time, total) / 1e3)]
    label, mass = ("Mass above the\nslot [t/m]", hopper.mass) if hopper.mass is not None else ("Passed [t/m]", total)
    panels = (
        Panel(label, [Trace("", hopper.time, mass / 1e3)]),
        Panel("Discharge\n[t/s per metre]", rates, levels=mean, ylim=(0.0, None)),
    )
    window = (hopper.begin, hopper.end) if isfinite(hopper.begin) else None
    return {"hopper": Chart("discs that pass the gap", TIME, panels, window)}


def section(hopper: Hopper) -> Section:
    """Discharge, its window and steadiness; gaps by their places."""
    if not known(hopper.discharge):
        return Section("Outlet", [Text(hopper.reason or "", "warn")])
    rows = described(hopper, "discharge", "begin", "end", "discs")
    if known(hopper.slot):
        rows += described(hopper, "slot", "slot_in_diameters")
    if known(hopper.change):
        rows.append(("Change from the first half of the window to the second", percent(hopper.change)))
    if known(hopper.beverloo):
        rows += described(hopper, "beverloo")
    elif hopper.no_beverloo:
        rows.append(("Beverloo's law is not asked", hopper.no_beverloo))
    keys = ("gap_x", "gap_y", "gap_width", "gap_turn", "gap_discharge", "gap_discs")
    gaps = list(zip(*(getattr(hopper, key) for key in keys), strict=True))
    header = ("Gap, x [m]", "y [m]", "width [m]", "way to −y [degrees]", "discharge [kg/s/m]", "discs, whole run")
    return Section("Outlet", [Table(rows), Table(gaps, header)])


QUANTITY = Quantity(
    name="hopper",
    title="Outlet",
    result=Hopper,
    definitions="""\
gap           narrow place between standing walls that discs pass, from their tracks; of gaps behind each other the
              narrowest; width D, and the way of the discs to the direction −y, counter-clockwise
discharge     slope of the mass that has passed against time, over the window;  change: second half over first
window        from flow on to flow off: from the first to the last time with half of the usual discharge, which half of
              the mass passes faster; a window that the case asks for cuts it
Beverloo      W/(ρ √g (D − 1.4 d)^1.5), ρ and d of a disc, for one gap from 6 d on in a floor: by the law of Beverloo,
              Leniger & van de Velde (1961) in two dimensions the same for every gap and height of fill
""",
    collector=Crossings,
    analyse=analyse,
    files={"hopper.csv": "mass before the gaps that discs pass, and discharge, against time"},
    captions={"hopper": "Discs that pass the gap"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(
        HeadlineNumber("discharge", label="discharge, per metre"),
        HeadlineNumber("beverloo"),
        HeadlineNumber("slot", label="width of the gap"),
        HeadlineNumber("slot_in_diameters", label="width of the gap over the diameter", rank=78),
        HeadlineNumber(
            "change", label="discharge, second half of the window over the first", scale=0.01, unit="%", rank=78
        ),
    ),
    rank=50,
)
