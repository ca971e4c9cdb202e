# SPDX-License-Identifier: GPL-2.0-or-later
"""What a point of ``lammps-jump stress`` measures."""

from __future__ import annotations

from typing import Any

from lammps_jump.studies.bench import collision_scene, measure_collisions

from .limits import ENGINES, integrator_of
from .limits import crystal_growth as crystal_growth
from .limits import measure_limit as measure_limit
from .limits import resting_bed as resting_bed
from .scenes import judge as judge
from .scenes import judge_bypassed as judge_bypassed


def gain(engine: str, fraction: float) -> dict[str, Any]:
    """Return mean and scatter over entry phases of the relative change of energy of one elastic collision."""
    scene = collision_scene(fraction, 1.0, integrator=integrator_of(engine))
    found = measure_collisions(scene, ENGINES[engine])["restitution"] ** 2 - 1.0
    return {"engine": engine, "fraction": fraction, "mean": float(found.mean()), "scatter": float(found.std())}
