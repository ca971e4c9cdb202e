# SPDX-License-Identifier: GPL-2.0-or-later
"""Constants of the loops from a scene: of its equal discs, or of a radius of 1 m (see `arrays`)."""

from __future__ import annotations

from typing import Any

import numpy as np

from lammps_jump.physics.law import Slots
from lammps_jump.scene.scene import Scene

from .arrays import Constants, Lists, Memory, StepConstants
from .ledger import inertia

DEFAULT_SKIN = 0.3
"""Skin of the neighbour list over the diameter where the scene gives none."""


class Memories:
    """Memory of the contacts of a scene, as the loops take it: one object as long as nothing of it changes."""

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
            held = Memory(slots, d.ids, walls.chain, walls.around, full, time_step)
        if held.time_step != time_step:
            held = held._replace(time_step=time_step)
        self._held = held
        return held


def constants_of(scene: Scene, skin: float) -> Constants:
    """Constants of a scene, with a neighbour list of this skin (m)."""
    return Constants(scene.largest, scene.law_numbers(), motion_of(scene, skin))


def motion_of(scene: Scene, skin: float) -> StepConstants:
    """Constants of the motion, with a neighbour list of this skin (m)."""
    square = 1.0 if scene.sizes is None else scene.radius * scene.radius
    mass = scene.mass / square
    weight = mass * scene.gravity[0], mass * scene.gravity[1]
    return StepConstants(scene.time_step, mass, inertia(scene) / square**2, *weight, (0.5 * skin) ** 2)


def lists_of(scene: Scene, skin: float, *, inside: bool) -> Lists:
    """Arguments of lists of this skin (m); where `inside` is true, loops make them within `Loops.advance`."""
    domain, ends = (*scene.domain[0], *scene.domain[1]), [wall.extent[0] for wall, _ in scene.walls if scene.period]
    return Lists(
        domain, skin, scene.largest, inside, np.zeros(2), scene.period or 0.0, np.zeros(1), np.reshape(ends, (-1, 2))
    )
