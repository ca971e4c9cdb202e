# SPDX-License-Identifier: GPL-2.0-or-later
"""Streams at a jump, in the laboratory: the one before it, and the tail water behind it; what theory makes of both.

Discs of the stream before it touch before they reach the jump: their contacts carry thrust upstream, and the stream
slows down and thickens. Momentum flux plus thrust stays the same along a level floor without friction. The thrust is
the whole contact force through a plane, so hydrostatic pressure is in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.statistics import Mean, as_fields, mean_of, propagated
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

from .track import AlongStream, JumpTrack

if TYPE_CHECKING:
    import xarray as xr


STRETCH = 5.0
"""Length of the stretches of the table, in depths of the stream; a quarter of a stream shorter than four of them."""
COMPRESSED = 0.04
"""Thrust above hydrostatic pressure from which the stream counts as compressed, as a share of the momentum flux."""
LEAST_COMPRESSED = 3.0
"""Least length of a compressed stretch at that level, in depths: shorter ones are chance contacts."""
NEAR_INLET = 15.0
"""A compression front this many depths downstream of the inlet has reached it: it stops there, as measured."""


@dataclass(frozen=True)
class Stream(AlongStream):
    """The stream from the inlet to the toe, means over the window; arrays have one value a stretch, NaN not known.

    Attributes
    ----------
    start, stop : ndarray, m
        Ends of the stretches along x.
    mass_depth, velocity, discharge : ndarray
        m, m/s, m^2/s.
    momentum_flux, thrust, total, total_error : ndarray
        Momentum flux and contact force over the density, their sum and its standard error, m^3/s^2.
    froude, belanger_y2, deviation : ndarray
        In the frame of the front: Froude number, sequent depth by Bélanger (m), and how far the depth after the jump
        lies off it, a share.
    """

    ALONG = ("start", "stop", "velocity", "discharge", "compression")
    start: np.ndarray
    stop: np.ndarray
    mass_depth: np.ndarray
    velocity: np.ndarray
    discharge: np.ndarray
    momentum_flux: np.ndarray
    thrust: np.ndarray
    total: np.ndarray
    total_error: np.ndarray
    froude: np.ndarray
    belanger_y2: np.ndarray
    deviation: np.ndarray
    total_deviation: float = number("", "largest deviation of momentum flux + thrust from its mean", default=nan)
    compression: float = number("m", "front of the compression before the toe", default=nan)
    undisturbed: float = number("m", "stretch from the inlet to the front of the compression", default=nan)
    at_inlet: bool = False


def compression_front(stream: xr.Dataset, track: JumpTrack, gravity: float) -> np.ndarray:
    """Begin of the compressed stretch before the toe in each frame, m; NaN where there is none; shape (frames,).

    It is the place from which the thrust up to the toe, less g s^2/2 and less `COMPRESSED` of the momentum flux, adds
    up to most: where a cumulative sum turns. Gaps do not end the stretch. Before a jump is known it goes to the end of
    the reach.
    """
    x, depth, flux = (stream[name].values for name in ("x", "mass_depth", "momentum_flux"))
    width = x[1] - x[0]
    excess = stream["thrust"].values - 0.5 * gravity * depth**2 - COMPRESSED * flux
    ends = np.where(np.isfinite(track.toe), track.toe, track.reach_end) - width
    places = np.full(len(ends), nan)
    for k, end in enumerate(ends):
        before = np.flatnonzero(x + 0.5 * width <= end)
        if len(before) >= 4:
            sums = width * np.cumsum(excess[k, before][::-1])[::-1]
            first = int(np.argmax(sums))
            least = LEAST_COMPRESSED * COMPRESSED * np.median(flux[k, before]) * np.median(depth[k, before])
            if sums[first] > least > 0:
                places[k] = x[first] - 0.5 * width
    return places


def measure_stream(
    stream: xr.Dataset, track: JumpTrack, used: np.ndarray, speed: float, depth: float, gravity: float
) -> Stream | None:
    """State of the stream by stretches, from a depth after the inlet to the place the toe reaches in the window.

    Parameters
    ----------
    stream : xarray.Dataset
        Of the reach, along the stream; ``thrust`` where contacts are known.
    track : JumpTrack
    used : ndarray of bool, shape (frames,)
    speed : float
        Of the front along the stream, m/s.
    depth : float
        Behind the jump, m.
    gravity : float
        m/s^2 across the bed.

    Returns
    -------
    Stream or None
        None where there is no room for a stretch.
    """
    x = stream.x.values
    width = x[1] - x[0]
    window = stream.isel(time=used)
    before = np.flatnonzero(x + 0.5 * width <= np.quantile(track.toe[used], 0.05) - width)
    typical = float(np.median(window["mass_depth"].values[:, before])) if before.size else nan
    before = before[x[before] - 0.5 * width >= x[0] - 0.5 * width + typical - 1e-9] if before.size else before
    bins = max(1, min(round(STRETCH * typical / width), len(before) // 4)) if isfinite(typical) else 1
    groups = before[: len(before) // bins * bins].reshape(-1, bins)
    if not len(groups):
        return None

    def means(name: str) -> np.ndarray:
        return window[name].values[:, groups].mean(axis=2)

    s, q, m = map(means, ("mass_depth", "discharge", "momentum_flux"))
    push = means("thrust") if "thrust" in window else np.full_like(s, nan)
    total = [mean_of(values) for values in (m + push).T]
    mean_depth, mean_discharge = s.mean(axis=0), q.mean(axis=0)
    velocity = mean_discharge / mean_depth
    froude = (velocity - speed) / np.sqrt(gravity * mean_depth)
    sequent = mean_depth * np.array([theory.belanger(value) for value in froude])
    levels = np.array([value.value for value in total])
    place = median_place(track.compression[used]) if track.compression is not None else nan
    clear = place - (x[0] - 0.5 * width)
    return Stream(
        start=x[groups[:, 0]] - 0.5 * width,
        stop=x[groups[:, -1]] + 0.5 * width,
        mass_depth=mean_depth,
        velocity=velocity,
        discharge=mean_discharge,
        momentum_flux=m.mean(axis=0),
        thrust=push.mean(axis=0),
        total=levels,
        total_error=np.array([value.error for value in total]),
        froude=froude,
        belanger_y2=sequent,
        deviation=depth / sequent - 1.0,
        total_deviation=float(np.abs(levels / levels.mean() - 1.0).max()),
        compression=place,
        undisturbed=clear,
        at_inlet=bool(clear < NEAR_INLET * mean_depth[0]),
    )


def median_place(places: np.ndarray) -> float:
    """Median place; NaN where fewer than half of the frames have one."""
    known = places[np.isfinite(places)]
    return float(np.median(known)) if known.size and known.size >= 0.5 * len(places) else nan


def running_median(places: np.ndarray, frames: int = 9) -> np.ndarray:
    """Median place over that many frames around each, shape (frames,): the compression front as a line."""
    half = frames // 2
    return np.array([median_place(places[max(0, k - half) : k + half + 1]) for k in range(len(places))])


BEHIND_FRONT = 1.2
"""Distance from the front at which a jump of discs has ended, in depths of the tail water (measured)."""
SILL_REACH = 0.5
"""Distance from the end of the channel at which the stretch ends, in the same depths: most of the fall over a sill."""
LEAST_BINS = 3


@dataclass(frozen=True)
class Tail(Estimates):
    """Tail water of a jump; NaN where the channel downstream of the jump is too short to tell.

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
        Depth after the jump, m: sets the zone, from `BEHIND_FRONT` after the front to `SILL_REACH` before the end.
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


StreamMeans = tuple[Mean, Mean, Mean]
"""Mass depth (m) and mean velocity (m/s) of a stream, and velocity of the front along it (m/s)."""


def froude(depth: float, velocity: float, front: float, gravity: float) -> float:
    """Froude number of a stream in the frame of the front."""
    return theory.relative_froude(velocity, depth, front, gravity)


def sequent(depth: float, velocity: float, front: float, gravity: float) -> float:
    """Sequent depth of a stream by Bélanger, in the frame of the front, m."""
    return depth * theory.belanger(froude(depth, velocity, front, gravity))


def against(y2: Mean, stream: StreamMeans, length: Mean, gravity: float) -> dict[str, Mean]:
    """The depth after the jump and its length against theory for a stream, frame of the front; by the keys of `Jump`.

    Parameters
    ----------
    y2 : Mean
        Mass depth downstream of the jump, m.
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
