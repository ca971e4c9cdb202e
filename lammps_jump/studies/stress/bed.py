# SPDX-License-Identifier: GPL-2.0-or-later
"""A settled bed over many steps: kinetic energy must not rise, its height must not drift, no disc may leave."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lammps_jump.dump.find import read_dump
from lammps_jump.physics.contact import damping_ratio, stable_fraction
from lammps_jump.studies.runs import execute

from .limits import ENGINES, arrangement_scene, integrator_of


@dataclass(frozen=True)
class Bed:
    """What a resting bed did.

    Attributes
    ----------
    engine : str
    steps, discs : int
    seconds : float
        Processor time, s.
    right : bool
    message : str
    kinetic_share, drift : float or None
        Largest kinetic energy over m g d of all discs, and drift of the mean height (d), in the second half.
    """

    engine: str
    steps: int
    discs: int
    seconds: float
    right: bool
    message: str
    kinetic_share: float | None = None
    drift: float | None = None


def resting_bed(engine: str, steps: int) -> Bed:
    """Run a settled bed for some steps on one engine of `limits.ENGINES`."""
    fraction = min(0.1, 0.6 * stable_fraction(damping_ratio(0.2), integrator_of(engine)))
    scene = arrangement_scene("column", fraction, 0.2, integrator_of(engine), side=3)
    count, every = len(scene.positions), max(1, steps // 20)
    scene = replace(
        scene, steps=20 * every, output_steps=every, velocities=np.zeros_like(scene.velocities), overlap_limit=0.04
    )
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), ENGINES[engine])
        frames = list(read_dump(Path(folder))) if result.status == "complete" else []
    if not frames:
        return Bed(engine, steps, count, result.cpu_seconds, False, f"{result.status}: {result.message}")
    kinetic = [0.5 * scene.mass * float(np.sum(f.vx**2 + f.vy**2)) for f in frames]
    half = len(frames) // 2
    share = max(kinetic[half:]) / (scene.mass * 9.81 * scene.diameter * count)
    drift = (float(frames[-1].y.mean()) - float(frames[half].y.mean())) / scene.diameter
    right = bool(share < 1e-9 and abs(drift) < 1e-6 and result.lost == 0 and len(frames[-1].x) == count)
    text = f"kinetic energy at most {share:.1e} of m g d in the second half, mean height drifts {drift:+.1e} d"
    return Bed(engine, steps, count, result.cpu_seconds, right, text, share, drift)
