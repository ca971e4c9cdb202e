# SPDX-License-Identifier: GPL-2.0-or-later
"""A settled bed over many steps: kinetic energy must not rise, its height must not drift, no disc may leave."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from lammps_jump.dump.find import read_dump
from lammps_jump.physics.contact import damping_ratio, stable_fraction
from lammps_jump.studies.runs import execute
from lammps_jump.studies.store import Results

from .limits import ENGINES, arrangement_scene, integrator_of


def resting_bed(engine: str, steps: int) -> Results:
    """Run a settled bed for some steps on one engine of `limits.ENGINES`.

    Returns
    -------
    dict
        Engine, steps, discs, processor time (s), whether it is right, a message; ``kinetic_share``, the largest kinetic
        energy over m g d of all discs, and ``drift`` of the mean height (d), both in the second half, None without.
    """
    fraction = min(0.1, 0.6 * stable_fraction(damping_ratio(0.2), integrator_of(engine)))
    scene = arrangement_scene("column", fraction, 0.2, integrator_of(engine), side=3)
    count, every = len(scene.positions), max(1, steps // 20)
    scene = replace(
        scene, steps=20 * every, output_steps=every, velocities=np.zeros_like(scene.velocities), overlap_limit=0.04
    )
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), ENGINES[engine])
        frames = list(read_dump(Path(folder))) if result.status == "complete" else []
    bed: Results = {"engine": engine, "steps": steps, "discs": count, "seconds": result.cpu_seconds, "right": False,
                    "message": f"{result.status}: {result.message}", "kinetic_share": None, "drift": None}  # fmt: skip
    if not frames:
        return bed
    late = frames[len(frames) // 2 :]
    kinetic = max(0.5 * scene.mass * float(np.sum(f.vx**2 + f.vy**2)) for f in late)
    share = kinetic / (scene.mass * 9.81 * scene.diameter * count)
    drift = (float(late[-1].y.mean()) - float(late[0].y.mean())) / scene.diameter
    right = bool(share < 1e-9 and abs(drift) < 1e-6 and result.lost == 0 and len(late[-1].x) == count)
    text = f"kinetic energy at most {share:.1e} of m g d in the second half, mean height drifts {drift:+.1e} d"
    return bed | {"right": right, "message": text, "kinetic_share": share, "drift": drift}
