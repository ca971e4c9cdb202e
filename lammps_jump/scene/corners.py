# SPDX-License-Identifier: GPL-2.0-or-later
"""Corners of walls as discs, with which bodies and walls meet each other's faces.

A convex joint is a disc inside the outline that touches both of its faces, of `radius` or, where the faces are too
short for that, a smaller one. A convex arc is a disc of its own radius, in the directions of the arc alone. A whole
circle is one disc. Ends of open lines are discs that touch the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, pi
from typing import NamedTuple

import numpy as np

from lammps_jump.physics.elementary import atan2, cos, sin, tan
from lammps_jump.scene.chains import (
    AFTER,
    ARC,
    AT_END,
    AT_START,
    BEFORE,
    CONVEX,
    CX,
    CY,
    FREE,
    KIND,
    LENGTH,
    RADIUS,
    TX0,
    TX1,
    TY0,
    TY1,
    X0,
    X1,
    Y0,
    Y1,
    Faces,
)

STRAIGHT = 1e-6
"""Turn below which a joint is no corner, rad: round-off between the pieces of an arc."""
SHARPEST = 0.1
"""Half of the angle inside a corner below which it is taken as the end of a line, rad."""


class BodyCorner(NamedTuple):
    """A disc: centre and radius (m), and directions of an arc at its two ends; 0 of a disc that is felt all round."""

    x: float
    y: float
    radius: float
    tx0: float = 0.0
    ty0: float = 0.0
    tx1: float = 0.0
    ty1: float = 0.0


def corners_of(faces: Faces, wall: int, radius: float) -> list[BodyCorner]:
    """Corners of a wall among faces, rounded by a radius (m)."""
    own = range(int(faces.first[wall]), int(faces.first[wall + 1]))
    circle = round_of(faces, wall)
    if circle is not None:
        return [circle]
    return [corner for face in own for corner in _of_face(faces, face, radius)]


def largest_radius(faces: Faces, wall: int) -> float:
    """Radius at which two rounded corners of a wall of lines meet in the middle of a side, m; infinite without any."""
    return min((corner.radius for corner in corners_of(faces, wall, inf)), default=inf)


def round_of(faces: Faces, wall: int) -> BodyCorner | None:
    """The disc that a wall is, where it is one whole circle with discs outside; else None."""
    own = slice(int(faces.first[wall]), int(faces.first[wall + 1]))
    codes, shape = faces.codes[own], faces.shape[own]
    if not len(codes) or (codes[:, KIND] != ARC).any() or (shape[:, RADIUS] >= 0).any():
        return None
    if np.ptp(shape[:, [CX, CY, RADIUS]], axis=0).max() > 1e-9 * abs(shape[0, RADIUS]) or codes[0, BEFORE] < 0:
        return None
    return BodyCorner(float(shape[0, CX]), float(shape[0, CY]), float(-shape[0, RADIUS]))


def _of_face(faces: Faces, face: int, radius: float) -> Iterator[BodyCorner]:
    code, row = faces.codes[face], faces.shape[face].tolist()
    if code[KIND] == ARC and row[RADIUS] < 0:
        yield BodyCorner(row[CX], row[CY], -row[RADIUS], row[TX0], row[TY0], row[TX1], row[TY1])
    if code[AT_START] == FREE:
        yield _end(row[X0], row[Y0], row[TX0], row[TY0], row[TX0], row[TY0], radius)
    if code[AT_END] == FREE:
        yield _end(row[X1], row[Y1], -row[TX1], -row[TY1], row[TX1], row[TY1], radius)
    if code[AT_END] != CONVEX:
        return
    after = faces.shape[code[AFTER]].tolist()
    ux, uy, vx, vy = row[TX1], row[TY1], after[TX0], after[TY0]
    turn = -atan2(ux * vy - uy * vx, ux * vx + uy * vy)  # to the right, above 0
    if turn < -0.5 * pi:
        turn += 2 * pi
    if turn < STRAIGHT:
        return
    half = 0.5 * (pi - turn)  # of the angle inside
    x, y = row[X1], row[Y1]
    if half < SHARPEST:
        yield BodyCorner(x - radius * ux, y - radius * uy, radius)
        return
    lengths = [one[LENGTH] for one, kind in ((row, code[KIND]), (after, faces.codes[code[AFTER], KIND])) if kind != ARC]
    own = min([radius, *(0.5 * length * tan(half) for length in lengths)])
    # from the corner along the face before, and then off it to the right, into the solid
    back = own / tan(half)
    yield BodyCorner(x - back * ux + own * uy, y - back * uy - own * ux, own)


def _end(x: float, y: float, ix: float, iy: float, tx: float, ty: float, radius: float) -> BodyCorner:
    """A disc at the open end of a line, behind it; (ix, iy) points along the line from the end."""
    return BodyCorner(x + radius * (ix + ty), y + radius * (iy - tx), radius)


def shown(corner: BodyCorner, pose: tuple[float, float, float], about: tuple[float, float]) -> tuple[float, float]:
    """Centre of a corner of a wall that is displaced (m, m) and turned (rad) about a point, m."""
    dx, dy = corner.x - about[0], corner.y - about[1]
    c, s = cos(pose[2]), sin(pose[2])
    return about[0] + pose[0] + c * dx - s * dy, about[1] + pose[1] + s * dx + c * dy
