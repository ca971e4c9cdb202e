# SPDX-License-Identifier: GPL-2.0-or-later
"""The wave that a structure throws back: where it is, how fast it runs, and the bore that theory expects."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.jump.track import Motion, straight_motion
from lammps_jump.physics import jump as theory
from lammps_jump.scene.walls import Wall

if TYPE_CHECKING:
    import xarray as xr

HALF = 0.5
"""The front stands where the velocity has fallen to this share of the highest velocity of the oncoming stream."""


@dataclass(frozen=True)
class ReflectedWave:
    """A wave running back from a structure.

    Attributes
    ----------
    structure : str
    time, position : ndarray, shape (n,)
        s, m; NaN before the stream arrives and after the wave has met the column or the stream has run dry.
    motion : Motion
        Straight-line fit over all of them.
    depth, velocity : float
        Oncoming stream just before the front, means over the frames: mass depth (m), velocity (m/s).
    bore_depth, bore_speed : float
        What a wall that stops this stream throws back: depth (m) and velocity (m/s) of the bore.
    """

    structure: str
    time: np.ndarray
    position: np.ndarray
    motion: Motion
    depth: float
    velocity: float
    bore_depth: float
    bore_speed: float

    def summary(self) -> dict:
        """Plain numbers."""
        return {
            "structure": self.structure,
            "frames": self.motion.points,
            "speed": self.motion.speed,
            "speed_error": self.motion.error,
            "oncoming_depth": self.depth,
            "oncoming_velocity": self.velocity,
            "bore_speed": self.bore_speed,
            "bore_depth": self.bore_depth,
        }

    def sentence(self) -> str:
        """One sentence for the report."""
        if self.motion.points < 3:
            return f"No wave could be followed back from '{self.structure}'."
        speed = f"{self.motion.speed:+.2f} ± {self.motion.error:.2f} m/s"
        return (
            f"The wave thrown back by '{self.structure}' runs at {speed}; the oncoming stream of {self.depth:.2f} m "
            f"and {self.velocity:.2f} m/s stopped by a wall would throw back a bore of {self.bore_depth:.2f} m at "
            f"{self.bore_speed:+.2f} m/s (no errors of the stream from one run)."
        )


def track_reflection(profiles: xr.Dataset, structure: Wall, flow: Flow) -> ReflectedWave | None:
    """Follow the front between oncoming and stopped flow from the structure back upstream; None without a stream.

    In every frame with a stream towards the structure it is the place, downstream of the highest velocity, where the
    mean velocity has fallen to half of that highest one. It counts from the first frame in which the bin at the
    structure is deeper than a disc until the highest velocity has fallen to a fifth of what it was at that time.
    """
    width, low = profiles.attrs["bin_width"], profiles.attrs["x_low"]
    stop = int(np.floor((structure.extent[0][0] - low) / width + 1e-9))
    if stop < 4:
        return None
    x = profiles["x"].values[:stop]
    depth, discharge = profiles["mass_depth"].values[:, :stop], profiles["discharge"].values[:, :stop]
    time = profiles["time"].values
    wet = depth > 0.5 * flow.scene.diameter
    velocity = np.where(wet, discharge / np.where(wet, depth, 1.0), nan)
    arrived = np.flatnonzero((depth[:, -1] > flow.scene.diameter) & (time > 0))
    if not arrived.size:
        return None
    position = np.full(len(time), nan)
    streams = []
    first_speed = None
    for k in range(arrived[0], len(time)):
        u = velocity[k]
        if not np.isfinite(u).any():
            break
        top = int(np.nanargmax(u))
        first_speed = first_speed or u[top]
        if not u[top] > 0.2 * first_speed or first_speed <= 0:
            break
        level = HALF * u[top]
        below = np.flatnonzero(u[top:] < level)
        if not below.size:
            continue
        j = top + int(below[0])
        if j < 2 or j == top:
            continue
        position[k] = x[j - 1] + (u[j - 1] - level) / (u[j - 1] - u[j]) * width
        before = max(0, j - 3)
        streams.append((depth[k, before:j].mean(), np.nanmean(u[before:j])))
    good = np.isfinite(position)
    if not good.any():
        return None
    oncoming_depth, oncoming_velocity = (float(v) for v in np.mean(streams, axis=0))
    bore = theory.reflected_bore(oncoming_depth, oncoming_velocity, -flow.scene.gravity[1])
    motion = straight_motion(time[good], position[good])
    return ReflectedWave(structure.name, time, position, motion, oncoming_depth, oncoming_velocity, *bore)
