# SPDX-License-Identifier: GPL-2.0-or-later
"""The motion of a body: a wall whose pose is state of the run, with mass and moment of inertia."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt
from typing import Literal

import numpy as np

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
