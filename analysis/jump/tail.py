# SPDX-License-Identifier: GPL-2.0-or-later
"""The tail water: depth and slope behind the jump, and the depth that Bélanger gives for the inflow."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.statistics import mean_of
from lammps_jump.physics import jump as theory
from lammps_jump.units import number

if TYPE_CHECKING:
    import xarray as xr

BEHIND_FRONT = 1.2
"""Distance from the front at which a jump of discs has ended, in depths of the tail water (measured)."""
SILL_REACH = 0.5
"""Distance from the end of the channel at which the stretch ends, in the same depths: most of the fall over a sill."""
LEAST_BINS = 3


@dataclass(frozen=True)
class Tail:
    """Tail water of a jump; NaN where the channel behind the jump is too short to tell."""

    length: float = number("m", "mean length of the tail water", default=nan)
    slope: float = number("", "slope of its surface", default=nan)
    slope_error: float = number("", "standard error of the slope", default=nan)
    depth: float = number("m", "its mass depth", default=nan)
    depth_error: float = number("m", "standard error of its mass depth", default=nan)
    belanger_y2: float = number("m", "sequent depth of the inflow by Bélanger, front's frame", default=nan)
    belanger_deviation: float = number("", "its mass depth over Bélanger's, less one", default=nan)


def measure_tail(stream: xr.Dataset, front: np.ndarray, depth: float) -> Tail:
    """Depth and slope of the tail water, frame by frame, between the jump and the end of the channel.

    Parameters
    ----------
    stream : xarray.Dataset
        ``mass_depth`` and ``surface_depth`` (m) over (time, x), along the stream, up to a sill or fall.
    front : ndarray, shape (frames,), m
    depth : float
        Depth behind the jump, m: sets the zone, `BEHIND_FRONT` behind the front to `SILL_REACH` before the end.
    """
    x, mass, surface = (stream[name].values for name in ("x", "mass_depth", "surface_depth"))
    half = 0.5 * (x[1] - x[0])
    end = x[-1] + half - SILL_REACH * depth
    rows = []
    for s, h, start in zip(mass, surface, front + BEHIND_FRONT * depth, strict=True):
        inside = (x - half >= start) & (x + half <= end) & np.isfinite(s) & np.isfinite(h)
        if inside.sum() >= LEAST_BINS:
            rows.append((np.polyfit(x[inside], h[inside], 1)[0], s[inside].mean(), 2 * half * inside.sum()))
    if len(rows) < max(2, 0.5 * len(front)):
        return Tail()
    slope, level, length = (np.array(column) for column in zip(*rows, strict=True))
    slopes, depths = mean_of(slope), mean_of(level)
    return Tail(float(length.mean()), slopes.value, slopes.error, depths.value, depths.error)


def against_inflow(depth: float, inflow: theory.Inflow, speed: float, gravity: float) -> tuple[float, float]:
    """Bélanger's sequent depth of the inflow in the frame of the front (m), and how far `depth` lies off it, a share.

    Parameters
    ----------
    depth : float
        Mass depth of the tail water, m.
    inflow : Inflow
        Depth y1 and mean velocity Va of the inflow.
    speed : float
        Velocity of the front along the stream, m/s.
    gravity : float
        m/s^2.
    """
    sequent = inflow.depth * theory.belanger(theory.froude(abs(inflow.velocity) - speed, inflow.depth, gravity))
    return sequent, depth / sequent - 1.0
