"""Scenes put together by hand, without a case file: for tests, small experiments and timing."""

from __future__ import annotations

import numpy as np

from lammps_jump.physics.contact import derive, stiffness

from .scene import Scene
from .walls import Wall


def handmade_scene(
    positions,
    velocities,
    walls: tuple[Wall, ...] = (),
    *,
    diameter: float = 0.2,
    density: float = 1000.0,
    restitution: float = 0.2,
    friction: float = 0.0,
    friction_law: str = "hooke",
    penetration_fraction: float = 10.0,
    impact_speed: float = 16.0,
    stiffness_wall: float | None = None,
    time_step_fraction: float = 0.05,
    integrator: str = "velocity_verlet",
    correct_restitution: bool = False,
    rotation: bool = False,
    tangential_damping: float | None = None,
    gravity: tuple[float, float] = (0.0, -9.81),
    domain=((-100.0, 100.0), (-100.0, 100.0)),
    **others,
) -> Scene:
    """A `Scene` from discs, walls and contact parameters.

    Parameters
    ----------
    positions, velocities : array_like, shape (n, 2)
        m, m/s.
    walls : tuple of Wall
    others
        Further fields of `Scene` (steps, inlets, outlets, probes …); the overlap limit is twice the design overlap
        d/n unless given. The other parameters are those of `lammps_jump.physics.contact.derive`.
    """
    k = stiffness(density, penetration_fraction, impact_speed)
    coefficients = derive(
        density=density,
        diameter=diameter,
        restitution=restitution,
        friction=friction,
        stiffness=k,
        stiffness_wall=k if stiffness_wall is None else stiffness_wall,
        impact_speed=impact_speed,
        time_step_fraction=time_step_fraction,
        integrator=integrator,
        correct_restitution=correct_restitution,
        rotation=rotation,
        tangential_damping=tangential_damping,
        touch=others.get("touch", "sharp"),
    )
    others.setdefault("overlap_limit", 2.0 * diameter / penetration_fraction)
    others.setdefault("name", "handmade")
    others.setdefault("description", "")
    return Scene(
        diameter=diameter,
        density=density,
        gravity=gravity,
        coefficients=coefficients,
        friction_law=friction_law,
        rotation=rotation,
        integrator=integrator,
        domain=domain,
        positions=np.asarray(positions, float).reshape(-1, 2),
        velocities=np.asarray(velocities, float).reshape(-1, 2),
        walls=tuple(walls),
        **others,
    )
