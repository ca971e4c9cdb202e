# SPDX-License-Identifier: GPL-2.0-or-later
"""Divergence of two runs of a case after they have agreed: of the engines, and of the native engine from itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene.scene import Scene

from .ensembles import perturbed
from .trajectories import (
    AGREEMENT,
    Growth,
    Separation,
    crossing_step,
    fit_growth,
    plain_scene,
    separation,
    trajectory,
)

FRAMES = 400
TWIN_JITTER = 1e-15
"""The twin of the native run starts this far off (diameters, and shares of speeds): a few last digits."""
LEVELS = (1e-12, AGREEMENT, 1e-6, 1e-3, 1e-1)


@dataclass(frozen=True)
class Divergence:
    """Divergence of two runs of a case after they have agreed.

    Attributes
    ----------
    engines, twin : Separation
        LAMMPS from native; native from native with a start a few last digits off.
    growth, twin_growth : Growth
    levels : dict of str to (step or None)
        First step beyond each separation, in diameters.
    """

    engines: Separation
    twin: Separation
    growth: Growth
    twin_growth: Growth
    levels: dict[str, int | None]
    kernel: str


def measure_divergence(scene: Scene, kernel: str, work: float) -> Divergence:
    """Compare both engines, and the native engine with its twin, until discs have parted or `work` is done."""
    bare = replace(scene, probes=())
    steps = parting_step(bare, work)
    interval = max(1, steps // FRAMES)
    long = plain_scene(scene, max(interval, steps // interval * interval), interval)
    native = trajectory(long, "native")
    part = separation(native, trajectory(long, kernel), scene.diameter)
    twin = separation(native, trajectory(perturbed(long, 1, TWIN_JITTER), "native"), scene.diameter)
    levels = {f"{level:g}": crossing_step(part, level) for level in LEVELS}
    dt = scene.time_step
    growths = (fit_growth(one.steps, one.largest, dt) for one in (part, twin))
    return Divergence(part, twin, *growths, levels, kernel)


def parting_step(scene: Scene, work: float, level: float = 1.0) -> int:
    """Return a step soon after the native engine and its twin have parted by `level` d; at most `work` disc-steps."""
    one, two = (NativeSimulation(s, ledger=False) for s in (scene, perturbed(scene, 1, TWIN_JITTER)))
    while one.step < scene.steps and one.disc_steps < work:
        chunk = min(200, scene.steps - one.step)
        one.run(chunk)
        two.run(chunk)
        if not np.array_equal(one.ids, two.ids):
            break
        apart = np.abs(one.positions - two.positions)
        if apart.size and apart.max() > level * scene.diameter:
            break
    return min(scene.steps, one.step + one.step // 4)
