# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts between bodies, and of bodies and walls: materials of two, and numbers that the loops take."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan, sqrt

import numpy as np

from lammps_jump.core.law import LawNumbers
from lammps_jump.physics.contact import SMOOTH_SHARE, damping
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import Scene


def share_of(scene: Scene, one: MovingWall) -> float:
    """Root of the effective mass of a nominal disc and a wall over that of the disc: sqrt(M/(m + M)); 1 of no body."""
    free = one.motion.free
    return 1.0 if free is None else sqrt(free.mass / (scene.mass + free.mass))


def law_at(scene: Scene, one: MovingWall) -> LawNumbers:
    """Numbers of the law of a disc and a wall; of a body with the effective mass, where no contact has its own."""
    law = scene.law_numbers(one.wall.name)
    if one.motion.free is None or scene.sizes is not None:
        return law
    share = share_of(scene, one)
    return law._replace(damping=share * law.damping, tangential=share * law.tangential)


def bulk_of(scene: Scene, one: MovingWall) -> float:
    """Radius of a disc of the mass of a body, m; 0 of a wall that is none."""
    free = one.motion.free
    return 0.0 if free is None else scene.radius * sqrt(free.mass / scene.mass)


def laws_between(scene: Scene, walls: Sequence[MovingWall]) -> np.ndarray:
    """Numbers of contacts of each two walls, as `BodyState.between` has them.

    Where both have a number of their own, the smaller one counts; where neither has, that of the scene.
    """
    found = np.zeros((len(walls), len(walls), len(LawNumbers._fields) + 1))
    for i, one in enumerate(walls):
        for j, two in enumerate(walls[: i + 1]):
            if one.motion.free or two.motion.free:
                found[i, j] = found[j, i] = _between(scene, one, two)
    return found


def _between(scene: Scene, one: MovingWall, two: MovingWall) -> tuple[float, ...]:
    c, owns = scene.coefficients, (one.wall.own_law, two.wall.own_law)
    stiffness, restitution, friction = (
        min((value for own in owns if (value := own[k]) is not None), default=other)
        for k, other in enumerate((c.stiffness_wall, c.restitution, c.friction))
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
