# SPDX-License-Identifier: GPL-2.0-or-later
"""Corners that meet faces, and the numbers of the contact: input of engines on bodies and walls."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt

import numpy as np

from lammps_jump.core.law import LawNumbers
from lammps_jump.physics.contact import SMOOTH_SHARE, Coefficients, damping
from lammps_jump.scene.chains import lay
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import Scene

from .bodies import BodyCorner, corners_of, round_of

SLOTS = 8
"""Contacts that a corner remembers."""
LARGEST_OVERLAP = 1.5
"""Overlap of a corner over its radius that ends a run: from 2 on nothing pushes it back."""


def corners(scene: Scene) -> list[tuple[int, BodyCorner]]:
    """Corners of all walls of a scene, each with the number of its wall."""
    body_corners: list[tuple[int, BodyCorner]] = []
    for number, (wall, motion) in enumerate(scene.walls):
        radius = motion.free.corner_radius if motion.free else 0.25 * scene.smallest
        body_corners += [(number, corner) for corner in corners_of(wall.faces, 0, radius)]
    return body_corners


def corner_names(walls: Sequence[MovingWall]) -> tuple[str, ...]:
    """Names of the corners of walls, in the order of `corners`: the wall, and the number of the corner there."""
    return tuple(f"{wall.name}:{number}" for wall, _ in walls for number in range(len(corners_of(wall.faces, 0, 1.0))))


def meets(there: Sequence[MovingWall]) -> np.ndarray:
    """Tells whether corners of the first wall meet faces of the second, shape (walls, walls).

    A circle is a disc that meets the faces of others: their corners do not meet it again, and of two circles one does.
    """
    count = len(there)
    body = np.array([one.motion.free is not None for one in there])
    faces = lay([(wall.chains(), wall.deep) for wall, _ in there])
    is_round = np.array([round_of(faces, wall) is not None for wall in range(count)])
    can_meet = (body[:, None] | body[None, :]) & ~np.eye(count, dtype=bool)
    can_meet &= is_round[:, None] | ~is_round[None, :]
    return can_meet & ~(is_round[:, None] & is_round[None, :] & np.tril(np.ones((count, count), bool)))


def yielding(one: MovingWall) -> float:
    """Most that a body gives way to a force on one of its corners, 1/kg: of a free block 4/M; 0 of a wall."""
    free = one.motion.free
    if free is None:
        return 0.0
    there = corners_of(one.wall.faces, 0, free.corner_radius)
    return max(free.yielding((corner.x, corner.y)) for corner in there)


def stiffness_between(c: Coefficients, one: MovingWall, two: MovingWall | None = None) -> float:
    """Stiffness of contacts of two walls, one of them a body, or of a body and a wall without numbers of its own, N/m.

    That which one of them has of its own, the smaller one of two. Without any, as much more than that of a disc and a
    wall as the effective mass is: k = m_eff omega^2, at the frequency omega of a disc and a wall. So a heavy body needs
    no shorter step and sinks as deep as a disc of the same speed. The mass is that of the corner that gives way most;
    a light body has the stiffness of discs.
    """
    both = [one] if two is None else [one, two]
    own = [stiffness for wall, _ in both if (stiffness := wall.stiffness) is not None]
    return min(own) if own else max(c.stiffness_wall, c.omega_wall**2 / sum(map(yielding, both)))


def laws_between(scene: Scene, walls: Sequence[MovingWall]) -> np.ndarray:
    """Numbers of contacts of each two walls, shape (walls, walls, 5).

    Stiffness (`stiffness_between`); dashpot and slope of the viscous ramp over the root of the effective mass; what the
    dashpot is less, as it sees the half step; friction. Where both walls have a restitution or friction of their own,
    the smaller one counts; where neither has, that of the scene.
    """
    laws = np.zeros((len(walls), len(walls), len(LawNumbers._fields) + 1))
    for i, one in enumerate(walls):
        for j, two in enumerate(walls[: i + 1]):
            if i != j and (one.motion.free or two.motion.free):
                laws[i, j] = laws[j, i] = _between(scene, one, two)
    return laws


def _between(scene: Scene, one: MovingWall, two: MovingWall) -> tuple[float, ...]:
    c, owns = scene.coefficients, (one.wall.own_law, two.wall.own_law)
    stiffness = stiffness_between(c, one, two)
    restitution, friction = (
        min((value for own in owns if (value := own[k]) is not None), default=other)
        for k, other in ((1, c.restitution), (2, c.friction))
    )
    by_root_mass = damping(restitution, stiffness, 1.0)
    share = 0.0 if c.correction == 1.0 else SMOOTH_SHARE if scene.touch == "smooth" else 1.0
    laws = (scene.wall_law(wall.name) for wall in (one.wall, two.wall))
    ramp = max(law.gamma_tangential * sqrt(scene.mass * stiffness / law.stiffness) for law in laws)
    # of second order in the step: `lagged_correction` is 1 - xi omega dt / 2
    lag = share * by_root_mass**2 * scene.time_step / 4.0
    of = scene.law_numbers()
    # attraction and rolling are of discs
    law = LawNumbers(
        stiffness, by_root_mass, ramp, friction if scene.rubs else nan, of.sign_ramp, of.touch,
        spring_ratio=of.spring_ratio, spring_damping=of.spring_damping,
    )  # fmt: skip
    return *law, lag
