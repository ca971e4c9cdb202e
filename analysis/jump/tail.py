# SPDX-License-Identifier: GPL-2.0-or-later
"""The tail water: depth and slope behind the jump; and what theory makes of the stream before it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.statistics import Mean, as_fields, mean_of, propagated
from lammps_jump.physics import jump as theory
from lammps_jump.physics import jump as waves
from lammps_jump.units import Estimates, estimate, number

if TYPE_CHECKING:
    import xarray as xr

BEHIND_FRONT = 1.2
"""Distance from the front at which a jump of discs has ended, in depths of the tail water (measured)."""
SILL_REACH = 0.5
"""Distance from the end of the channel at which the stretch ends, in the same depths: most of the fall over a sill."""
LEAST_BINS = 3


@dataclass(frozen=True)
class Tail(Estimates):
    """Tail water of a jump; NaN where the channel behind the jump is too short to tell.

    Its mass depth is `Jump.y2`, and the drift of that `Drift.y2`.
    """

    length: float = number("m", "mean length of the tail water", default=nan)
    slope: float = estimate("", "slope of its surface")
    depth: Mean = field(default=Mean(nan, nan), metadata={"summary": False})
    drift: float = field(default=nan, metadata={"summary": False})
    lower_bounds: tuple[str, ...] = ("slope",)


def measure_tail(stream: xr.Dataset, front: np.ndarray, depth: float, stretch: float = 1.0) -> Tail:
    """Depth and slope of the tail water, frame by frame, between the jump and the end of the channel.

    Parameters
    ----------
    stream : xarray.Dataset
        ``mass_depth`` and ``surface_depth`` (m) over (time, x), along the stream, up to a sill or fall.
    front : ndarray, shape (frames,), m
    depth : float
        Depth behind the jump, m: sets the zone, `BEHIND_FRONT` behind the front to `SILL_REACH` before the end.
    stretch : float
        Both distances are divided by it.
    """
    x, mass, surface = (stream[name].values for name in ("x", "mass_depth", "surface_depth"))
    half = 0.5 * (x[1] - x[0])
    end = x[-1] + half - SILL_REACH / stretch * depth
    rows = []
    for s, h, start in zip(mass, surface, front + BEHIND_FRONT / stretch * depth, strict=True):
        inside = (x - half >= start) & (x + half <= end) & np.isfinite(s) & np.isfinite(h)
        if inside.sum() >= LEAST_BINS:
            rows.append((np.polyfit(x[inside], h[inside], 1)[0], s[inside].mean(), 2 * half * inside.sum()))
    if len(rows) < max(2, 0.5 * len(front)):
        return Tail()
    slope, level, length = (np.array(column) for column in zip(*rows, strict=True))
    late, early = level[len(level) // 2 :].mean(), level[: len(level) // 2].mean()
    drift = float(late - early)
    return Tail(float(length.mean()), **as_fields(slope=mean_of(slope)), depth=mean_of(level), drift=drift)


Stream = tuple[Mean, Mean, Mean]
"""Mass depth (m) and mean velocity (m/s) of a stream, and velocity of the front along it (m/s)."""


def froude(depth: float, velocity: float, front: float, gravity: float) -> float:
    """Froude number of a stream in the frame of the front."""
    return waves.relative_froude(velocity, depth, front, gravity)


def sequent(depth: float, velocity: float, front: float, gravity: float) -> float:
    """Sequent depth of a stream by Bélanger, in the frame of the front, m."""
    return depth * theory.belanger(froude(depth, velocity, front, gravity))


def against(y2: Mean, stream: Stream, length: Mean, gravity: float) -> dict[str, Mean]:
    """The depth behind the jump and its length against theory for a stream, frame of the front; by the keys of `Jump`.

    Parameters
    ----------
    y2 : Mean
        Mass depth behind the jump, m.
    stream : (Mean, Mean, Mean)
    length : Mean
        Of the jump, m.
    gravity : float
        m/s^2.
    """

    def of(relation: Callable[[float, float], float]) -> Mean:
        """A function of Froude number and depth."""
        return propagated(lambda y, u, c: relation(froude(y, u, c, gravity), y), *stream)

    return {
        "y1": stream[0],
        "y2": y2,
        "froude": of(lambda number, _: number),
        "belanger_y2": of(lambda number, y: y * theory.belanger(number)),
        "belanger_deviation": propagated(lambda s, y, u, c: s / sequent(y, u, c, gravity) - 1.0, y2, *stream),
        "length_over_y2": propagated(lambda long, s: long / s, length, y2),
        "length_theory": of(theory.silvester_jump_length),
        "length_usbr": of(theory.usbr_jump_length),
        "head_lost_theory": of(lambda number, y: theory.energy_loss(y, y * theory.belanger(number))),
    }
