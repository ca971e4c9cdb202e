# SPDX-License-Identifier: GPL-2.0-or-later
"""Points about which moments are taken: what they are in words, where they are, and the toes of a body.

A moment says nothing without its point. That of a body is recorded about its centre of mass or its hinge, where a
structure is looked at about the toe over which it would turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.devices.standing import FLAT, base_at, placed
from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.side_files.bodies import BodyHistory
from lammps_jump.scene.motion import MovingWall, Pose, reference


class MomentPoint(NamedTuple):
    """A point in words, ``its centre of mass``, and where it is at each row of a record, m, arrays of shape (rows,)."""

    words: str
    x: np.ndarray
    y: np.ndarray


class Toes(NamedTuple):
    """Moments about the ends of the base of a body, anticlockwise.

    Attributes
    ----------
    left, right : ndarray, shape (rows,)
        Of the discs, N m/m.
    upright : ndarray of bool, shape (rows,)
        Whether it stands on its base still, turned by at most `FLAT`: else it has no toes.
    weight_left, weight_right : float
        Of its weight at its release, N m/m: what holds it, as long as it stands upright.
    """

    left: np.ndarray
    right: np.ndarray
    upright: np.ndarray
    weight_left: float
    weight_right: float


def point_of(name: str, history: ForceHistory, flow: Flow, bodies: Mapping[str, BodyHistory]) -> MomentPoint | None:
    """Point about which the record has the moment of a structure, or of a group; None where the scene tells none."""
    walls = {one.wall.name: one for one in flow.scene.walls}
    group = dict(flow.scene.groups).get(name)
    one = walls.get(group[0] if group else name)
    if one is None:
        return None
    of = f"the point of {one.wall.name}" if group else ""
    rows = len(history.time)
    if one.motion.kind is None:
        return MomentPoint(of or "its point", *(np.full(rows, place) for place in reference(one)))
    if one.motion.free and one.motion.free.hinge is None:
        body = bodies.get(one.wall.name)
        return body and MomentPoint(of or "its centre of mass", *_at(body, history.time).T)
    where = np.array([_moved(one, flow, float(time)) for time in history.time]).reshape(rows, 2)
    words = "its hinge" if one.motion.free else "the point that it turns about"
    return MomentPoint(of or words, *where.T)


def _moved(one: MovingWall, flow: Flow, time: float) -> tuple[float, float]:
    """The point of turning of a wall at a time (s), m."""
    motion, (x, y) = one.motion, reference(one)
    if motion.free:
        return x, y
    pose = flow.poses.at(time).get(one.wall.name) if motion.is_state and flow.poses else motion.pose(flow.step_at(time))
    pose = pose or Pose()
    return x + pose.x, y + pose.y


def _at(body: BodyHistory, time: np.ndarray) -> np.ndarray:
    """Centre of mass at some times (s), m, shape (times, 2)."""
    return np.column_stack([np.interp(time, body.time, body.x), np.interp(time, body.time, body.y)])


def toes_of(one: MovingWall, flow: Flow, history: ForceHistory, point: MomentPoint, body: BodyHistory) -> Toes | None:
    """Moments about both toes of a body; None of one that turns about a hinge or has no base.

    Notes
    -----
    ``M_toe = M + (r - r_toe) x F``, with the point r of the moment M.
    """
    kind = one.motion.free
    if kind is None or kind.hinge is not None or not flow.g:
        return None
    start = max(int(np.searchsorted(body.time, kind.begin, side="right")) - 1, 0)
    base = base_at(one, np.array(flow.scene.gravity), float(body.angle[start]))
    if base is None:
        return None
    moments, weights = [], []
    for end in (base.first, base.last):
        path = placed(end, kind, body)
        x, y = (np.interp(history.time, body.time, place) for place in path.T)
        moments.append(history.moment + (point.x - x) * history.fy - (point.y - y) * history.fx)
        arm = np.array([body.x[start], body.y[start]]) - path[start]
        weights.append(float(arm[0] * kind.weight[1] - arm[1] * kind.weight[0]))
    turn = np.interp(history.time, body.time, body.angle - body.angle[start])
    return Toes(moments[0], moments[1], np.abs(turn) <= FLAT, weights[0], weights[1])
