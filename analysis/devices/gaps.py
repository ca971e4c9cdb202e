# SPDX-License-Identifier: GPL-2.0-or-later
"""Gaps between walls that discs pass: where walls come closest to each other, and which discs cross there.

A *gap* is a straight line from a corner or an end of a standing wall to the nearest place of another face. It is a
narrow place: along both walls the distance grows. Of gaps that the same discs pass one after the other, the narrowest
counts. The tracks of the discs decide which gaps are outlets: nothing is assumed of their place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, degrees, hypot
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.chains import ARC, AT_START, CX, CY, ENDLESS, KIND, PHI, RADIUS, SWEEP, TX0, TY0, X0, X1, Y0, Y1
from lammps_jump.scene.scene import Scene

PIECES = 8
"""Straight pieces that stand for an arc of at most a quarter turn."""
SQUARE = 1e-6
"""Cosine up to which a face counts as square to a gap."""
FEWEST = 5
"""Discs that must pass a gap."""
LEAST = 0.05
"""Share of the discs of the busiest gap that must pass another one."""
SERIES = 0.5
"""Share of common discs from which on two gaps lie behind each other."""


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


class Joined(NamedTuple):
    """Straight faces: their ends, shapes (faces, 2), m, and for each end the directions in which faces leave it."""

    start: np.ndarray
    end: np.ndarray
    leaving: dict[tuple[float, float], list[np.ndarray]]


def straight_faces(scene: Scene) -> Joined:
    """Faces of the walls that stand, arcs in pieces, and the rows of rough beds."""
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
    return Joined(start, end, leaving)


def _key(point: np.ndarray) -> tuple[float, float]:
    return round(float(point[0]), 9), round(float(point[1]), 9)


def _lines(codes: np.ndarray, shape: np.ndarray, reach: float) -> list[tuple[np.ndarray, bool]]:
    """Corners of each face, shape (points, 2), and whether it has no ends."""
    found = []
    for code, one in zip(codes, shape, strict=True):
        if code[AT_START] == ENDLESS:
            along = reach * one[[TX0, TY0]]
            found.append((np.array([one[[X0, Y0]] - along, one[[X0, Y0]] + along]), True))
        elif code[KIND] == ARC:
            angle = one[PHI] - np.copysign(0.5 * np.pi, one[RADIUS]) + one[SWEEP] * np.linspace(0, 1, PIECES + 1)
            round_ = one[[CX, CY]] + abs(one[RADIUS]) * np.column_stack([np.cos(angle), np.sin(angle)])
            found.append((round_, False))
        else:
            found.append((one[[X0, Y0, X1, Y1]].reshape(2, 2), False))
    return found


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
    found: dict[tuple[Any, ...], Gap] = {}
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
            if ends not in found and _narrow(there, here, leaving) and not _blocked(here, there, start, end):
                found[ends] = Gap(*ends)
    return sorted(found.values(), key=lambda gap: (round(gap.width / scene.diameter, 6), -gap.middle[1]))


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
        for number, gap in enumerate(self.gaps):
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
                self._events.append((np.full(hit.size, number), ids[hit], when, side, mass[hit]))

    def outlets(self) -> list[GapFlow]:
        """The gaps that discs pass; of those behind each other the narrowest."""
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
