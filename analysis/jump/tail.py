# SPDX-License-Identifier: GPL-2.0-or-later
"""The tail water: depth and slope behind the jump, and the depth that Bélanger gives for the inflow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan

import numpy as np
import xarray as xr

from lammps_jump.analysis.statistics import Mean, as_fields, mean_of, propagated
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

from .certainty import TAIL_BOUNDS

BEHIND_FRONT = 1.2
"""Distance from the front at which a jump of discs has ended, in depths of the tail water (measured)."""
SILL_REACH = 0.5
"""Distance from the end of the channel at which the stretch ends, in the same depths: most of the fall over a sill."""
LEAST_BINS = 3


@dataclass(frozen=True)
class Tail(Estimates):
    """Tail water of a jump; NaN where the channel behind the jump is too short to tell."""

    length: float = number("m", "mean length of the tail water", default=nan)
    slope: float = estimate("", "slope of its surface")
    depth: float = estimate("m", "its mass depth")
    belanger_y2: float = estimate("m", "sequent depth of the inflow by Bélanger, front's frame")
    belanger_deviation: float = estimate("", "its mass depth over Bélanger's, less one")
    lower_bounds: tuple[str, ...] = TAIL_BOUNDS


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
    return Tail(float(length.mean()), **as_fields(slope=mean_of(slope), depth=mean_of(level)))


def against_inflow(tail: Tail, inflow: tuple[Mean, Mean], speed: Mean, gravity: float) -> Tail:
    """The tail water with Bélanger's sequent depth of the inflow in the frame of the front.

    Parameters
    ----------
    tail : Tail
    inflow : (Mean, Mean)
        Depth (m) and mean velocity (m/s) of the stream behind the inlet.
    speed : Mean
        Velocity of the front along the stream, m/s.
    gravity : float
        m/s^2.
    """

    def sequent(depth: float, velocity: float, front: float) -> float:
        return theory.sequent_depth(abs(velocity) - front, depth, gravity)

    expected = propagated(sequent, *inflow, speed)
    off = propagated(lambda found, *stream: found / sequent(*stream) - 1.0, Mean.of(tail, "depth"), *inflow, speed)
    return replace(tail, **as_fields(belanger_y2=expected, belanger_deviation=off))
