# SPDX-License-Identifier: GPL-2.0-or-later
"""The motion of a body: a wall whose pose is state of the run, with mass and moment of inertia."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from lammps_jump.physics.bodies import about_point
from lammps_jump.physics.elementary import hypot
from lammps_jump.scene.chains import Point
from lammps_jump.scene.tracks import Kind


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
        """Whether that point moves along x and y, and the body turns about it."""
        return self.axes if self.hinge is None else (False, False, self.axes[2])

    @property
    def inertia_there(self) -> float:
        """Moment of inertia about that point, kg m."""
        return about_point(self.mass, self.inertia, hypot(*self.arm))
