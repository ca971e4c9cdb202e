# SPDX-License-Identifier: GPL-2.0-or-later
"""State of a structure at the end, and what happened to it on the way: it slid, tipped, fell.

A body stands on a face of its convex hull, the one that looks most downward at the start. From then on its pose tells
all: along the floor it slides as far as both ends of that face have come, about an end of it it tips. At the end it
stands on that face or lies on another one, or leans.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, inf, isfinite, nan, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.walls import BodyHistory
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import MovingWall

MOVED = 0.01
"""Widths of a body by which it has slid, or by which an end of its base has risen, where that counts."""
UPRIGHT, FLAT = radians(2.0), radians(15.0)
"""Turn up to which a body stands as it stood; angle up to which a face is the one that it lies on."""
LEAST_FACE = 0.2
"""Length of a face that carries a body, in its width."""
DOWNWARD = cos(radians(45.0))
"""Least share of downward in the normal of a base."""
CARRIED = 0.2
"""Share of its weight below which nothing carries a body: it is in the air."""
ROWS = 3
"""Rows at the end over which that is looked at."""


class HullFace(NamedTuple):
    """A face of a convex hull where the case has the body: its ends (m), and its outward normal."""

    first: np.ndarray
    last: np.ndarray
    normal: np.ndarray

    @property
    def length(self) -> float:
        """Length, m."""
        return float(hypot(*(self.last - self.first)))


@dataclass(frozen=True)
class Standing:
    """State of a body at the end; times are s, NaN where it did not happen.

    Attributes
    ----------
    state : {'stands', 'slid', 'leans', 'lies', 'left'} or None
        None: it did not stand, and `reason` says why; of what floats, others tell.
    side : {'right', 'left', 'top', 'base'} or None
        The side on which it lies, as the body was at the start; base: another face of its underside.
    turn : float
        From its initial position, rad; anticlockwise.
    slid_by : float
        Way of the middle of its base along it, towards larger x, m.
    slides_at, tips_at, falls_at, since : float
        Since when it is in the state of the end.
    base : ndarray, shape (rows,)
        How far the middle of its base has come at each row since its release, m.
    """

    state: str | None = None
    side: str | None = None
    turn: float = nan
    slid_by: float = nan
    slides_at: float = nan
    tips_at: float = nan
    falls_at: float = nan
    since: float = nan
    base: np.ndarray | None = None
    reason: str | None = None


def faces_of(corners: np.ndarray) -> list[HullFace]:
    """Faces of the convex hull of corners, shape (n, 2), m, anticlockwise; those on one line are one."""
    from scipy.spatial import ConvexHull  # 0.2 s

    ring = corners[ConvexHull(corners).vertices]
    way = np.roll(ring, -1, axis=0) - ring
    angle = np.arctan2(way[:, 1], way[:, 0])
    bends = np.flatnonzero(np.abs(np.angle(np.exp(1j * (angle - np.roll(angle, 1))))) > 1e-6)
    ring = ring[bends]
    ends = np.roll(ring, -1, axis=0)
    along = (ends - ring) / np.hypot(*(ends - ring).T)[:, None]
    return [HullFace(a, b, np.array([t[1], -t[0]])) for a, b, t in zip(ring, ends, along, strict=True)]


class BaseWay(NamedTuple):
    """A base against time, from the release of its body on.

    Attributes
    ----------
    time : ndarray, shape (rows,), s
    along, up : ndarray, shape (rows, 2), m
        How far its two ends have come along it, towards larger x, and upwards, from where they were.
    turn : ndarray, shape (rows,), rad
    width : float
        Of the body, m.
    fast : float
        Speed of a fall from `MOVED` of that width, m/s.
    """

    time: np.ndarray
    along: np.ndarray
    up: np.ndarray
    turn: np.ndarray
    width: float
    fast: float


def standing_of(flow: Flow, one: MovingWall, history: BodyHistory) -> Standing:
    """State of a body at the end of its history."""
    kind, g = one.motion.kind, np.array(flow.scene.gravity)
    assert isinstance(kind, Free)
    if away := left_since(flow, history):
        return Standing("left", since=away)
    start = max(int(np.searchsorted(history.time, kind.begin, side="right")) - 1, 0)
    faces = faces_of(_outline(one)) if flow.g else []
    base = _base(faces, _width(one), g, float(history.angle[start]))
    if why := _why_not(flow, kind, history, start, base):
        return Standing(reason=why)
    assert base is not None
    ends = np.stack([placed(end, kind, history) for end in (base.first, base.last)], axis=1)
    along = turned(base.last - base.first, float(history.angle[start])) / base.length
    up = turned(-base.normal, float(history.angle[start]))
    way, width = ends[start:] - ends[start], _width(one)
    path = BaseWay(
        history.time[start:], way @ along, way @ up, history.angle[start:] - history.angle[start], width,
        sqrt(2.0 * MOVED * width * flow.g),
    )  # fmt: skip
    slides, tips, falls = times_of(path)
    if falls <= path.time[0] + float(path.time[1] - path.time[0]) + 0.5 * path.fast / flow.g:
        return Standing(reason=NOTHING_BELOW)
    state, side, since = _at_end(path, faces, base, float(history.angle[start]), g / flow.g)
    if not carried(flow, history.time[-1 - ROWS :], history.vx[-1 - ROWS :], history.vy[-1 - ROWS :]):
        return Standing(reason=IN_THE_AIR, falls_at=falls if isfinite(falls) else nan)
    middle = path.along.mean(axis=1)
    return Standing(
        state, side, turn=float(path.turn[-1]), slid_by=float(middle[-1]), slides_at=slides, tips_at=tips,
        falls_at=falls if isfinite(falls) else nan, since=since, base=np.hypot(middle, path.up.mean(axis=1)),
    )  # fmt: skip


NOTHING_BELOW = "it stood on nothing at the start"
IN_THE_AIR = "it is in the air at the end"


def _why_not(flow: Flow, kind: Free, history: BodyHistory, start: int, base: HullFace | None) -> str:
    """Why a body does not stand at the start; empty where it may."""
    if not flow.g:
        return "there is no gravity"
    if kind.hinge is not None:
        return "it turns about a hinge"
    if base is None:
        return "it has no base to stand on"
    rows = slice(start + 1, start + 2 + ROWS)  # the velocity of its release is known from the next row on
    if len(history.time) - start < 2:
        return "it is held to the end"
    return "" if carried(flow, history.time[rows], history.vx[rows], history.vy[rows]) else NOTHING_BELOW


def left_since(flow: Flow, history: BodyHistory) -> float:
    """Time from which on a body has left, s, with its centre of mass; 0 where it has not."""
    (x0, x1), (y0, y1) = flow.scene.domain
    away = (history.x < x0) | (history.x > x1) | (history.y < y0) | (history.y > y1)
    for outlet in flow.scene.outlets:
        place = history.x if outlet.axis == "x" else history.y
        away |= place > outlet.at if outlet.side == "above" else place < outlet.at
    if not away[-1]:
        return 0.0
    here = np.flatnonzero(~away)
    return float(history.time[here[-1] + 1 if here.size else 0])


def carried(flow: Flow, time: np.ndarray, vx: np.ndarray, vy: np.ndarray) -> bool:
    """Tells whether anything carries a body over some rows: its acceleration is another than that of gravity."""
    span = float(time[-1] - time[0])
    if span <= 0:
        return True
    off = np.array([vx[-1] - vx[0], vy[-1] - vy[0]]) / span - np.array(flow.scene.gravity)
    return bool(hypot(*off) >= CARRIED * flow.g)


def times_of(path: BaseWay) -> tuple[float, float, float]:
    """Times at which a body has slid, tipped and fallen, s; NaN (infinite of a fall) where it has not.

    What happens in a fall is neither: a fall lowers both ends of the base faster than what gives way does.
    """
    least = MOVED * path.width
    along, low, high = path.along, path.up.min(axis=1), path.up.max(axis=1)
    slid = (np.abs(along).min(axis=1) > least) & (np.sign(along).prod(axis=1) > 0)
    tipped = (high > least) & (low < 0.5 * high)
    sinks = -np.gradient(path.up.mean(axis=1), path.time)
    fallen = (high < -least) & (sinks > 0.5 * path.fast)
    g = path.fast**2 / (2.0 * least)
    at = [float(path.time[np.argmax(one)]) if one.any() else inf for one in (slid, tipped, fallen)]
    free = sqrt(2.0 * least / g)  # it takes so long to fall so far
    slides, tips = (time if time < at[2] - 2.0 * free else nan for time in at[:2])
    return slides if slides < inf else nan, tips if tips < inf else nan, at[2] - free


def _at_end(
    path: BaseWay, faces: list[HullFace], base: HullFace, angle: float, down: np.ndarray
) -> tuple[str, str | None, float]:
    """State at the end, the side on which the body lies or to which it leans, and since when, s."""
    floor = turned(base.normal, angle)
    states = [_state(float(turn), faces, base, angle, (floor, down)) for turn in path.turn]
    other = [row for row, state in enumerate(states) if state != states[-1]]
    since = float(path.time[other[-1] + 1]) if other else float(path.time[0])
    state, side = states[-1]
    if state == "stands" and abs(path.along[-1].mean()) > MOVED * path.width:
        return "slid", None, nan
    return state, side, nan if state == "stands" else since


def _state(
    turn: float, faces: list[HullFace], base: HullFace, angle: float, floors: tuple[np.ndarray, np.ndarray]
) -> tuple[str, str | None]:
    """Tells whether a body that has turned so far (rad) stands, lies or leans, and to which side."""
    off = atan2(sin(turn), cos(turn))
    if abs(off) <= UPRIGHT:
        return "stands", None
    near = [max(float(turned(face.normal, angle + turn) @ floor) for floor in floors) for face in faces]
    best = int(np.argmax(near))
    if float(faces[best].normal @ base.normal) < 1.0 - 1e-9 and near[best] >= cos(FLAT):
        return "lies", side_of(faces[best], base)
    return "leans", "left" if off > 0 else "right"


def side_of(face: HullFace, base: HullFace) -> str:
    """Side of a body on which a face is, its base below: right, left, top, or base for one next to the base."""
    up = -base.normal
    across = degrees(atan2(float(face.normal @ np.array([up[1], -up[0]])), float(face.normal @ up)))
    if abs(across) <= 45.0:
        return "top"
    if abs(across) > 135.0:
        return "base"
    return "right" if across > 0 else "left"


def base_at(one: MovingWall, gravity: np.ndarray, angle: float) -> HullFace | None:
    """The face that a body stands on when it has turned so far (rad), ends from left to right; None without one.

    It is the face of the convex hull that looks most downward, where that is long enough and looks down.
    """
    return _base(faces_of(_outline(one)), _width(one), gravity, angle)


def _base(faces: list[HullFace], width: float, gravity: np.ndarray, angle: float) -> HullFace | None:
    """The base among the faces of a body of some width, m."""
    long = [face for face in faces if face.length >= LEAST_FACE * width]
    if not long:
        return None
    down = gravity / hypot(*gravity)
    best = max(long, key=lambda face: float(turned(face.normal, angle) @ down))
    if float(turned(best.normal, angle) @ down) < DOWNWARD:
        return None
    # its ends from left to right, so that ways along it are towards larger x
    return best if turned(best.last - best.first, angle)[0] >= 0 else best._replace(first=best.last, last=best.first)


def _width(one: MovingWall) -> float:
    low, high = one.wall.extent[0]
    return high - low


def _outline(one: MovingWall) -> np.ndarray:
    return np.asarray(one.wall.outline((-inf, inf), (-inf, inf))[0])


def turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector turned anticlockwise by an angle, rad."""
    c, s = cos(angle), sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def placed(point: np.ndarray, kind: Free, history: BodyHistory) -> np.ndarray:
    """Place of a point of a body at each row, m, shape (rows, 2)."""
    arm, c, s = point - np.array(kind.centre), np.cos(history.angle), np.sin(history.angle)
    return np.column_stack([history.x + c * arm[0] - s * arm[1], history.y + s * arm[0] + c * arm[1]])
