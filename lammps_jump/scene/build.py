# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene from arrays, without a case file: for tests, small experiments and timing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.physics.contact import ContactNumbers, derive, stiffness

from .motion import MovingWall
from .scene import Scene
from .walls import Wall

CONTACT = {
    "restitution": 0.2,
    "friction": 0.0,
    "time_step_fraction": 0.05,
    "integrator": "velocity_verlet",
    "correct_restitution": False,
    "rotation": False,
    "tangential_damping": None,
    "touch": "sharp",
}
"""Fields of `lammps_jump.physics.contact.ContactNumbers` unless given."""


def handmade_scene(
    positions: ArrayLike,
    velocities: ArrayLike,
    walls: tuple[Wall | MovingWall, ...] = (),
    *,
    diameter: float = 0.2,
    density: float = 1000.0,
    largest_overlap: float = 0.1,
    impact_speed: float = 16.0,
    **others: Any,
) -> Scene:
    """A `Scene` from discs, walls and contact parameters.

    Parameters
    ----------
    positions, velocities : array_like, shape (n, 2)
        m, m/s.
    walls : tuple of Wall or MovingWall
        A `Wall` stands.
    diameter, density : float
        m, kg/m^3.
    largest_overlap, impact_speed : float
        Over the diameter (1/n), and v0 (m/s), of thesis (3.20), for the stiffness of discs and walls.
    others
        `stiffness_wall` (N/m; that of disc pairs unless given), further fields of the contact (see `CONTACT`) and of
        `Scene` (sizes, steps, inlets, outlets, probes …). Unless given, the domain extends to 100 m on all sides, and
        the overlap limit is twice the largest overlap.
    """
    k = stiffness(density, largest_overlap, impact_speed)
    law = {name: others.get(name, value) for name, value in CONTACT.items()}
    springs = others.get("springs")
    contact = ContactNumbers(
        density=density,
        diameter=diameter,
        stiffness=k,
        stiffness_wall=others.pop("stiffness_wall", None) or k,
        impact_speed=impact_speed,
        smallest=sizes.smallest if (sizes := others.get("sizes")) else None,
        tangential_damping_ratio=springs.tangential_damping_ratio if springs else None,
        **law,
    )
    fields = {
        "name": "handmade",
        "description": "",
        "gravity": (0.0, -9.81),
        "friction_law": "viscous",
        "domain": ((-100.0, 100.0), (-100.0, 100.0)),
        "overlap_limit": 2.0 * diameter * largest_overlap,
        **{name: law[name] for name in ("rotation", "integrator", "touch")},
        **{name: value for name, value in others.items() if name not in CONTACT},
    }
    return Scene(
        diameter=diameter,
        density=density,
        coefficients=derive(contact),
        positions=np.asarray(positions, float).reshape(-1, 2),
        velocities=np.asarray(velocities, float).reshape(-1, 2),
        walls=walls,  # type: ignore[arg-type]  # the scene lets plain walls stand
        **fields,
    )
