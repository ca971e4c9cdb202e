# SPDX-License-Identifier: GPL-2.0-or-later
"""The wave that a structure throws back: where it is, how fast it runs, and the bore that theory expects."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.jump.track import straight_motion
from lammps_jump.physics import jump as waves
from lammps_jump.scene.walls import Wall
from lammps_jump.units import Estimates, estimate, number, shown

if TYPE_CHECKING:
    import xarray as xr

HALF = 0.5
"""The front is where the velocity has fallen to this share of the highest velocity of the oncoming stream."""


@dataclass(frozen=True)
class ReflectedWave(Estimates):
    """A wave running back from a structure, and the bore that a wall would throw back of the same stream.

    Its `time` (s) and `position` (m) have the shape (frames,). The position is NaN before the stream arrives and after
    the wave has met the column or the stream has run dry. `start` is that of the straight-line fit at t = 0.
    """

    structure: str
    frames: int = number("", "frames in which the wave was found")
    speed: float = estimate("m/s", "velocity of the wave, straight-line fit")
    oncoming_depth: float = number("m", "mass depth of the stream just before the wave", default=nan)
    oncoming_velocity: float = number("m/s", "velocity of that stream", default=nan)
    bore_speed: float = number("m/s", "velocity of the bore", default=nan)
    bore_depth: float = number("m", "depth of the bore", default=nan)
    start: float = field(default=nan, metadata={"summary": False})
    time: np.ndarray | None = field(default=None, metadata={"summary": False})
    position: np.ndarray | None = field(default=None, metadata={"summary": False})

    def sentence(self) -> str:
        """One sentence for the report."""
        if self.frames < 3:
            return f"No wave could be followed back from '{self.structure}'."
        speed = shown(self.speed, "m/s", self.speed_error, alone=True)
        return (
            f"The wave thrown back by '{self.structure}' runs at {speed}; the oncoming stream of "
            f"{self.oncoming_depth:z.2f} m and {self.oncoming_velocity:z.2f} m/s stopped by a wall would throw back a "
            f"bore of {self.bore_depth:z.2f} m at {self.bore_speed:+z.2f} m/s."
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
        below = top + np.flatnonzero(u[top:] < level)
        if not below.size or below[0] < 2:
            continue
        j = int(below[0])
        position[k] = x[j - 1] + (u[j - 1] - level) / (u[j - 1] - u[j]) * width
        before = max(0, j - 3)
        streams.append((depth[k, before:j].mean(), np.nanmean(u[before:j])))
    good = np.isfinite(position)
    if not good.any():
        return None
    before_depth, before_speed = (float(v) for v in np.mean(streams, axis=0))
    bore_depth, bore_speed = waves.reflected_bore(before_depth, before_speed, flow.gravity)
    fit = straight_motion(time[good], position[good])
    return ReflectedWave(
        structure.name, fit.points, fit.speed, oncoming_depth=before_depth, oncoming_velocity=before_speed,
        bore_speed=bore_speed, bore_depth=bore_depth, start=fit.start, time=time, position=position,
        **{"speed_error": fit.error},  # a field that `estimate` adds
    )  # fmt: skip
