# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the loops from a scene: of its equal discs, or of a radius of 1 m (see `loops`)."""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.physics.slip import FRICTION_LAWS, Springs
from lammps_jump.physics.slots import Slots
from lammps_jump.scene.scene import Scene

from .arrays import Constants, Law, Memory, Motion
from .ledger import inertia


class SpringNumbers(NamedTuple):
    """Numbers of `Memory` that a scene fixes, by the names there; pairs and, by wall, walls."""

    ratio: float
    damping: float
    rolling: tuple[float, float, float]
    rolling_at: np.ndarray


def _springs_of(scene: Scene, springs: Springs, walls: list[str]) -> SpringNumbers:
    """Numbers of the springs with memory, of these walls."""
    roll, c, mass = springs.rolling, scene.coefficients, scene.mass
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
    return SpringNumbers(springs.tangential_ratio, springs.tangential_damping_ratio, pair, at)


class Memories:
    """What contacts of a scene remember, as the loops take it: one object as long as nothing of it changes."""

    def __init__(self, scene: Scene):
        self._scene = scene
        self._held: Memory | None = None

    def of(self, discs: Any, walls: Any, full: np.ndarray, time_step: float) -> Memory | None:
        """The memory of discs beside walls; None where contacts have none.

        `full` takes the id of a disc that has no slot left; springs go on by a time step (s), or stay as they are with
        0.
        """
        if self._scene.springs is None:
            return None
        d, held = discs, self._held
        if held is None or held.chain is not walls.chain or held.slots.partner is not d.partner:
            slots = Slots(d.partner, d.sigma, d.spring, d.roll, d.touched)
            of = _springs_of(self._scene, self._scene.springs, walls.names)
            held = Memory(slots, d.ids, walls.chain, walls.around, full, time_step, *of)
        if held.time_step != time_step:
            held = held._replace(time_step=time_step)
        self._held = held
        return held


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


def wall_numbers(scene: Scene, name: str, share: float = 1.0) -> tuple[float, float, float, float]:
    """Stiffness (N/m), dashpot and slope of the viscous ramp (N s/m, or of a radius of 1 m), friction of a wall.

    `share` is the root of the effective mass over that of a nominal disc; where discs are not equal, each contact has
    its own.
    """
    law, mass = scene.wall_law(name), scene.mass
    if scene.sizes is None:
        damping, ramp = share * (mass * law.gamma_normal), share * (mass * law.gamma_tangential)
        return law.stiffness, damping, ramp, law.friction
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
