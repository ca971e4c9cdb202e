# SPDX-License-Identifier: GPL-2.0-or-later
"""One disc at walls that are drawn, for closed forms. Units: d, m and g are 1."""

from __future__ import annotations

from dataclasses import dataclass

from lammps_jump.scene.chains import Chain
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.walls import Wall

R, K = 0.5, 100.0
"""Radius, and stiffness unless said: a disc at rest lies 0.01 d deep."""


@dataclass(frozen=True)
class Drawn(Wall):
    """A wall of chains that are given."""

    drawn: tuple[Chain, ...]
    kind: str = "drawn"
    name: str = "wall"

    def chains(self):
        return self.drawn


def one_disc(place, velocity, *chains, fraction=0.05, **more):
    """One disc at a wall of chains, elastic and without friction unless said."""
    walls = (Drawn(chains),) if chains else more.pop("walls")
    return handmade_scene(
        [place], [velocity], walls, diameter=2 * R, density=1.0, impact_speed=1.0, time_step_fraction=fraction,
        steps=10**8, output_steps=10**7, skin=0.3, overlap_limit=R, domain=((-30, 30), (-30, 30)),
        **{"restitution": 1.0, "largest_overlap": 0.1, "gravity": (0.0, -1.0), **more},
    )  # fmt: skip


def energy(scene, engine):
    """Kinetic, gravitational and elastic energy of a disc that touches one face at most."""
    (wall,) = scene.permanent
    ((x, y),), ((u, v),) = engine.positions, engine.velocities
    overlap = max(R - float(wall.distance(x, y)), 0.0)
    return 0.5 * (u * u + v * v) + y + 0.5 * scene.coefficients.stiffness_wall * overlap**2
