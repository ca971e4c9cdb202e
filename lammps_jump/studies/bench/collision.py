# SPDX-License-Identifier: GPL-2.0-or-later
"""Pairs of discs that collide, with their closed forms: restitution, duration, largest overlap, over entry phases.

All pairs of one run are independent: pair i starts so that first touch falls at another share of a time step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lammps_jump.case.to_scene import TOUCH_STEPS
from lammps_jump.physics import contact
from lammps_jump.scene import Scene, handmade_scene
from lammps_jump.studies.runs import run_frames

DIAMETER, DENSITY, SPEED, OVERLAP = 0.2, 1000.0, 16.0, 0.1
PHASES = 64


def collision_scene(
    fraction: float, restitution: float, *, correct: bool = True, speed: float = SPEED, phases: int = PHASES, **law: Any
) -> Scene:
    """Return `phases` pairs of discs, 3 d apart from each other, each about to collide head-on at `speed` (m/s).

    It has the corrected dashpot and the width of a smooth touch that a case gets; `law` may hold integrator and touch.
    """
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    dt = fraction * contact.critical_time_step(k, contact.disc_mass(DENSITY, DIAMETER))
    gaps = speed * dt * (1.0 + (np.arange(phases) + 0.5) / phases)
    left = np.column_stack([-0.5 * (DIAMETER + gaps), 3 * DIAMETER * np.arange(phases)])
    return handmade_scene(
        np.stack([left, left * [-1, 1]], axis=1), np.tile([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (phases, 1)),
        name="collision", description="pairs of discs, head-on", gravity=(0.0, 0.0), diameter=DIAMETER,
        density=DENSITY, largest_overlap=OVERLAP, impact_speed=SPEED, restitution=restitution,
        time_step_fraction=fraction, correct_restitution=correct, skin=0.3 * DIAMETER,
        touch_width=TOUCH_STEPS * SPEED * dt if law.get("touch") == "smooth" else 0.0,
        steps=int(1.6 * expected(restitution)["duration"] / dt) + 8,
        overlap_limit=DIAMETER,  # a single elastic pair may go deeper than a case allows: that is what is measured
        **law,
    )  # fmt: skip


def measure_collisions(scene: Scene, kernel: str) -> dict[str, np.ndarray]:
    """Return restitution, duration (s) and largest overlap (m) of every pair, shape (phases,).

    The overlap is the largest at a step, the duration the number of steps in contact: both are right to a step.
    """
    _, frames = run_frames(scene, kernel)
    x = np.array([frame.x for frame in frames])
    overlap = scene.diameter - (x[:, 1::2] - x[:, 0::2])
    before, after = (frame.vx[1::2] - frame.vx[0::2] for frame in (frames[0], frames[-1]))
    duration = (overlap > 0).sum(axis=0) * scene.time_step
    return {"restitution": -after / before, "duration": duration, "overlap": overlap.max(axis=0)}


def expected(restitution: float, speed: float = SPEED) -> dict[str, float]:
    """Return the closed forms for the same pair (docs/theory.md, one collision, exactly)."""
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    omega = contact.angular_frequency(k, 0.5 * contact.disc_mass(DENSITY, DIAMETER))
    return {
        "restitution": restitution,
        "duration": contact.contact_duration(restitution, omega),
        "overlap": contact.largest_overlap(speed, restitution, omega),
    }
