# SPDX-License-Identifier: GPL-2.0-or-later
"""The foot of a bed that falls behind the inlet: the stream there, by energy without loss, and the jump it would make.

Numbers of the inflow hold at the inlet. Down a spillway or over steps the jump stands at the foot, in another stream.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from lammps_jump.physics import jump
from lammps_jump.scene import Scene
from lammps_jump.scene.walls import bed_height
from lammps_jump.units import number

LEVEL = 0.05
"""Slope below which a bed is level: its change of height over a diameter, in diameters."""
LEAST_FALL = 0.5
"""Fall in diameters from which on a bed has a foot."""
POINTS = 4000


@dataclass(frozen=True)
class Foot:
    """The stream at the foot of the bed, and the jump that it would make there."""

    x: float = number("m", "foot of the bed: its longest level stretch begins at x")
    fall: float = number("m", "fall of the bed from the inlet to the foot")
    length: float = number("m", "length of the level bed behind the foot")
    stream: jump.Inflow | None = None


def foot_of(scene: Scene, depth: float, speed: float, gravity: float) -> Foot | None:
    """The foot behind the rows of a scene that carry a depth (m) and a speed (m/s); None on a level or tilted bed.

    The depth there is that of the fast stream with the energy at the inlet and the fall: the least that friction and
    impacts would leave. Where the bed rises the stream stays None.
    """
    if not scene.inlets or scene.gravity[0] or not (depth > 0 and speed > 0):
        return None
    start = min(scene.inlets, key=lambda one: one.y).x
    ends = [outlet.at for outlet in scene.outlets if outlet.axis == "x" and outlet.side == "above"]
    x = np.linspace(start, min([scene.domain[0][1], *ends]), POINTS)
    bed = bed_height(scene.permanent, x, scene.smallest)
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(np.abs(np.diff(bed)) < LEVEL * np.diff(x))) + 1
    begins, long = np.append(0, breaks), np.diff(breaks, prepend=0, append=POINTS)
    longest = int(np.argmax(np.where(np.isfinite(bed[begins]), long, 0)))
    first, last = begins[longest], begins[longest] + long[longest] - 1
    if long[longest] < 2 or not isfinite(bed[first]) or not isfinite(bed[0]):  # a chute to the end has no foot
        return None
    fall = float(bed[0] - bed[first])
    if fall < LEAST_FALL * scene.diameter:
        return None
    discharge = speed * depth
    energy = jump.specific_energy(depth, speed, gravity) + fall
    y1 = jump.fast_depth(discharge, energy, gravity)
    stream = jump.inflow_theory(y1, discharge / y1, gravity) if isfinite(y1) else None
    return Foot(float(x[first]), fall, float(x[last] - x[first]), stream)
