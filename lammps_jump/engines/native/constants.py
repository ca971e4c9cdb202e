# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the loops from a scene: of its equal discs, or of a radius of 1 m (see `loops`)."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene.scene import Scene

from .arrays import Constants, Law, Motion
from .ledger import inertia


class SpringNumbers(NamedTuple):
    """Numbers of `Memory` that a scene fixes, by the names there; pairs and, by wall, walls."""

    ratio: float
    damping: float
    rolling: tuple[float, float, float]
    rolling_at: np.ndarray


def springs_of(scene: Scene, walls: list[str]) -> SpringNumbers | None:
    """Numbers of the springs with memory, of these walls; None where contacts have none."""
    if scene.springs is None:
        return None
    roll, c, mass = scene.springs.rolling, scene.coefficients, scene.mass
    if roll is None:
        pair, at = (0.0, 0.0, 0.0), np.zeros((len(walls), 3))
    else:
        pair = roll.stiffness_ratio * c.stiffness, roll.damping * 0.5 * mass * c.gamma_normal, roll.friction
        laws = [scene.wall_law(name) for name in walls]
        at = np.array(
            [
                (
                    roll.stiffness_ratio * law.stiffness,
                    roll.damping * mass * law.gamma_normal,
                    roll.friction if law.rolling is None else law.rolling,
                )
                for law in laws
            ]
        ).reshape(-1, 3)
    return SpringNumbers(scene.springs.tangential_ratio, scene.springs.tangential_damping_ratio, pair, at)


def constants_of(scene: Scene, skin: float) -> Constants:
    """Constants of a scene, with a neighbour list of this skin (m)."""
    friction = scene.coefficients.friction if scene.rubs else None
    sign = None if friction is None else FRICTION_LAWS[scene.friction_law].ramp
    touch = scene.touch_width if scene.touch == "smooth" and scene.touch_width > 0 else None
    return Constants(law_of(scene), motion_of(scene, skin), friction, sign, touch, scene.cohesion)


def law_of(scene: Scene) -> Law:
    """Contact law of two discs."""
    c, mass = scene.coefficients, scene.mass
    if scene.sizes is None:
        return Law(scene.diameter, c.stiffness, 0.5 * mass * c.gamma_normal, 0.5 * mass * c.gamma_tangential)
    pair = sqrt(mass) / scene.radius * c.damping_by_root_mass
    return Law(scene.largest, c.stiffness, pair, c.tangential_ratio * pair if c.friction else 0.0)


def wall_numbers(scene: Scene, name: str) -> tuple[float, float, float, float]:
    """Stiffness (N/m), dashpot and slope of the viscous ramp (N s/m, or of a radius of 1 m), friction of a wall."""
    law, mass = scene.wall_law(name), scene.mass
    if scene.sizes is None:
        return law.stiffness, mass * law.gamma_normal, mass * law.gamma_tangential, law.friction
    damping = sqrt(mass) / scene.radius * (law.gamma_normal * sqrt(mass))
    # without a dashpot springs with memory have none along the wall either; the other laws are refused
    ramp = law.gamma_tangential / law.gamma_normal * damping if law.friction and law.gamma_normal else 0.0
    return law.stiffness, damping, ramp, law.friction


def motion_of(scene: Scene, skin: float) -> Motion:
    """Constants of the motion, with a neighbour list of this skin (m)."""
    square = 1.0 if scene.sizes is None else scene.radius**2
    mass = scene.mass / square
    weight = mass * scene.gravity[0], mass * scene.gravity[1]
    return Motion(scene.time_step, mass, inertia(scene) / square**2, *weight, (0.5 * skin) ** 2)
