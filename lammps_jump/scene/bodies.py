# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies: motion, and the corners as discs with which they and walls meet each other's faces.

A convex joint is a disc inside the outline that touches both of its faces, of `radius` or, where the faces are too
short for that, a smaller one. A convex arc is a disc of its own radius, in the directions of the arc alone. A whole
circle is one disc. Ends of open lines are discs that touch the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, pi, sqrt
from typing import Literal, NamedTuple

import numpy as np

from lammps_jump.physics.bodies import about_point
from lammps_jump.physics.elementary import atan2, cos, hypot, sin, tan

from .chains import (
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
    Point,
)
from .tracks import Kind

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


@dataclass(frozen=True)
class Free(Kind):
    """A body: its weight and what touches it move it, from `begin` on.

    Attributes
    ----------
    mass, inertia : float
        kg/m, and kg m about the centre of mass, per metre of width.
    centre : (float, float)
        Centre of mass where the case has it, m.
    weight : (float, float)
        N/m.
    hinge : (float, float), optional
        It turns about this point only, m.
    axes : (bool, bool, bool)
        Whether it moves along x and y, and turns.
    velocity : (float, float)
        Of the centre of mass where it is released, m/s.
    spin : float
        rad/s.
    corner_radius : float
        By which its corners are rounded where they meet walls and other bodies, m.
    """

    kind: Literal["free"] = field(default="free", kw_only=True, repr=False)
    mass: float
    inertia: float
    centre: Point
    weight: Point = (0.0, 0.0)
    hinge: Point | None = None
    axes: tuple[bool, bool, bool] = (True, True, True)
    velocity: Point = (0.0, 0.0)
    spin: float = 0.0
    corner_radius: float = 0.0

    turns = True

    @property
    def point(self) -> Point:
        """Point that it turns about where the case has it, m: the hinge, or the centre of mass."""
        return self.hinge or self.centre

    @property
    def arm(self) -> Point:
        """From there to the centre of mass, m."""
        return self.centre[0] - self.point[0], self.centre[1] - self.point[1]

    @property
    def freedom(self) -> tuple[bool, bool, bool]:
        """Tells whether that point moves along x and y, and the body turns about it."""
        return self.axes if self.hinge is None else (False, False, self.axes[2])

    @property
    def inertia_there(self) -> float:
        """Moment of inertia about that point, kg m."""
        return about_point(self.mass, self.inertia, hypot(*self.arm))

    def ways(self, arms: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Motion by forces on the body: ``ways @ ways.T`` are the velocities along them that impulses of 1 N s give.

        The square of a row is what the body gives way to a force of 1 N there, 1/kg.

        Parameters
        ----------
        arms : ndarray, shape (n, 2)
            From the point of turning to where they act, m.
        directions : ndarray, shape (n, 2)
            Unit vectors.

        Returns
        -------
        ndarray, shape (n, 3)
            Along x and y and as a turn, kg^-1/2.
        """
        lever = arms[:, 0] * directions[:, 1] - arms[:, 1] * directions[:, 0]
        scale = np.array([1.0 / sqrt(self.mass), 1.0 / sqrt(self.mass), 1.0 / sqrt(self.inertia_there)])
        return np.column_stack([directions, lever]) * scale * np.array(self.freedom)

    def gives_way(self, arms: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Compliance of the body to forces of 1 N, each alone, 1/kg, shape (n,); parameters as of `ways`."""
        return np.sum(self.ways(arms, directions) ** 2, axis=1)

    def yielding(self, point: Point) -> float:
        """Most that the body gives way to a force of 1 N at a point of where the case has it (m), 1/kg."""
        x, y = self.ways(np.subtract([point, point], self.point), np.eye(2))
        a, b, d = float(x @ x), float(x @ y), float(y @ y)
        return 0.5 * (a + d) + sqrt((0.5 * (a - d)) ** 2 + b * b)
