# SPDX-License-Identifier: GPL-2.0-or-later
"""Place of the jump in each frame: a ramp between two levels, fitted to the mass depth; and how fast it moves.

The stream flows towards larger x here; `result.analyse_jump` mirrors streams towards smaller x.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import nan, sqrt
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from lammps_jump.analysis.statistics import piece_bounds, piece_error

if TYPE_CHECKING:
    import xarray as xr

LEAST_RATIO = 1.5
"""A rise below this ratio of mass depths is taken for waves of the stream, not for a jump (Fr1 = 1.37)."""
LEAST_SHARE = 0.6
"""The ramp must explain this share of the depth's variance along the reach."""
CREST_SHARE = 0.8
"""The reach ends where the depth after its crest falls below this share of it: drawdown, or a heap's back."""
TO_THE_END = "the rise goes on up to the end of the level bed"
"""Reason of a frame with a supercritical stream that is held up, but has no level water downstream."""
COARSE = 64
"""Most places tried for each end of the ramp in the first search; the second is eight times finer."""


class FrontRamp(NamedTuple):
    """Two levels with a straight ramp from `toe` to `end` between them; `share` is the variance explained."""

    toe: float
    end: float
    depth_1: float
    depth_2: float
    share: float


class _Ramps(NamedTuple):
    """Unit ramps: toe and end in bins, mean over each bin (ramps, bins), and mean and variance of these means."""

    toe: np.ndarray
    end: np.ndarray
    shapes: np.ndarray
    mean: np.ndarray
    spread: np.ndarray


def _ramps(bins: int, toe: np.ndarray, end: np.ndarray) -> _Ramps:
    """Unit ramps, a step where toe and end coincide."""
    edges, start, stop = np.arange(bins + 1.0), toe[:, None], end[:, None]
    length = np.maximum(stop - start, 1e-12)
    integral = 0.5 * np.clip(edges - start, 0.0, length) ** 2 / length + np.maximum(edges - stop, 0.0)
    shapes = np.diff(integral, axis=1)
    mean = shapes.mean(axis=1)
    return _Ramps(toe, end, shapes, mean, (shapes**2).mean(axis=1) - mean**2)


@lru_cache(maxsize=64)
def _coarse(bins: int) -> _Ramps:
    """All ramps between a coarse set of edges."""
    places = np.unique(np.round(np.linspace(0, bins, min(bins, COARSE) + 1)).astype(int))[1:-1].astype(float)
    i, j = np.triu_indices(len(places))
    return _ramps(bins, places[i], places[j])


def _best(depth: np.ndarray, ramps: _Ramps) -> FrontRamp | None:
    """The ramp that leaves the least squares, rising ones only."""
    toe, end, shapes, mean, spread = ramps
    covariance = shapes @ depth / len(depth) - mean * depth.mean()
    rise = np.where(spread > 1e-12, covariance / np.maximum(spread, 1e-12), 0.0)
    gain = np.where(rise > 0, rise * covariance, -1.0)
    best = int(np.argmax(gain))
    if gain[best] <= 0:
        return None
    low, share = depth.mean() - rise[best] * mean[best], gain[best] / max(depth.var(), 1e-300)
    return FrontRamp(*(float(value) for value in (toe[best], end[best], low, low + rise[best], share)))


def fit_ramp(edges: np.ndarray, depth: np.ndarray) -> FrontRamp | None:
    """Least-squares ramp through a depth profile, ends to an eighth of a bin; None where nothing rises.

    Parameters
    ----------
    edges : ndarray, shape (bins + 1,), m
        Equally spaced.
    depth : ndarray, shape (bins,), m
    """
    bins, width = len(depth), edges[1] - edges[0]
    if bins < 4 or not np.isfinite(depth).all() or np.ptp(depth) <= 1e-9 * np.abs(depth).max():
        return None
    ramp = _best(depth, _coarse(bins))
    if ramp is None:
        return None
    reach = max(1.0, bins / COARSE)
    offsets = np.linspace(-reach, reach, 17)
    i, j = np.meshgrid(ramp.toe + offsets, ramp.end + offsets, indexing="ij")
    # the coarse edges themselves are among the candidates, so the second fit is never worse
    keep = (i <= j) & (i > 0) & (j < bins)
    best = _best(depth, _ramps(bins, i[keep], j[keep])) or ramp
    return best._replace(toe=edges[0] + best.toe * width, end=edges[0] + best.end * width)


@dataclass(frozen=True)
class AlongStream:
    """Base of results whose places and velocities are along the stream at first; `ALONG` names them."""

    ALONG: ClassVar[tuple[str, ...]] = ()

    def turned(self, direction: int) -> Self:
        """The same along x, for a stream towards `direction` = +1 or -1."""
        return replace(self, **{name: _turned(getattr(self, name), direction) for name in self.ALONG})


def _turned(value: Any, direction: int) -> Any:
    if isinstance(value, AlongStream):
        return value.turned(direction)
    return None if value is None else direction * value


@dataclass(frozen=True)
class JumpTrack(AlongStream):
    """The jump frame by frame; NaN where it was not found, and `why` says the reason.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    toe, end : ndarray, m
        Of the fitted ramp.
    position : ndarray, m
        Where a sharp front between the mean levels of the window would hold the same mass.
    mass_depth_1, mass_depth_2, velocity_1, velocity_2 : ndarray
        Mass depth (m) and velocity (m/s) of the fitted levels' stretches.
    reach_end : ndarray, m
        Where the part of the profile that was looked at ends.
    why : tuple of str
        Empty where a jump was found.
    compression : ndarray or None, m
        Front of the compressed stream before the toe; None where contact forces are not known.
    """

    ALONG = ("toe", "end", "position", "velocity_1", "velocity_2", "reach_end", "compression")
    time: np.ndarray
    toe: np.ndarray
    end: np.ndarray
    position: np.ndarray
    mass_depth_1: np.ndarray
    mass_depth_2: np.ndarray
    velocity_1: np.ndarray
    velocity_2: np.ndarray
    reach_end: np.ndarray
    why: tuple[str, ...]
    compression: np.ndarray | None = None

    @property
    def found(self) -> np.ndarray:
        """Mask of the frames that have a jump, shape (frames,)."""
        return np.array([not reason for reason in self.why], bool)


def _crest_reach(depth: np.ndarray) -> int:
    """Number of bins up to where the depth, smoothed over five bins, has fallen off after its crest."""
    padded = np.pad(depth, 2, mode="edge")
    smooth = np.convolve(padded, np.full(5, 0.2), mode="valid")
    crest = int(np.argmax(smooth))
    below = np.flatnonzero(smooth[crest:] < CREST_SHARE * smooth[crest])
    return crest + int(below[0]) if below.size else len(depth)


def track_jump(
    stream: xr.Dataset, edges: np.ndarray, gravity: float, diameter: float, in_window: np.ndarray
) -> JumpTrack:
    """Follow the jump through the frames.

    A frame has a jump where a ramp that rises at least `LEAST_RATIO`-fold explains `LEAST_SHARE` of the depth's
    variance, the stream before it is deeper than half a disc and supercritical, and the one after it subcritical.

    Parameters
    ----------
    stream : xarray.Dataset
        Mass depth (m) and discharge (m^2/s) of the reach, dims (time, x): level floor, nothing in the way.
    edges : ndarray, shape (bins + 1,), m
    gravity : float
        m/s^2 across the bed.
    diameter : float
        m.
    in_window : ndarray of bool, shape (frames,)
        Frames whose levels define `position`.
    """
    depth, discharge = stream["mass_depth"].values, stream["discharge"].values
    bins = [_crest_reach(row) for row in depth]
    looks = [_look(edges[: n + 1], depth[k, :n], discharge[k, :n], gravity, diameter) for k, n in enumerate(bins)]
    why = tuple(look if isinstance(look, str) else "" for look in looks)
    toe, end, depth_1, depth_2, velocity_1, velocity_2 = np.array(
        [(nan,) * 6 if isinstance(look, str) else look for look in looks]
    ).T
    is_seen = ~np.isnan(toe)
    position = np.full(len(looks), nan)
    chosen = is_seen & in_window if (is_seen & in_window).any() else is_seen
    if chosen.any():
        level_1, level_2 = (float(np.median(level[chosen])) for level in (depth_1, depth_2))
        for k in np.flatnonzero(is_seen):
            position[k] = equivalent_position(edges, depth[k], toe[k], end[k], level_1, level_2)
    return JumpTrack(stream.time.values, toe, end, position, depth_1, depth_2, velocity_1, velocity_2, edges[bins], why)


def _look(
    edges: np.ndarray, depth: np.ndarray, discharge: np.ndarray, gravity: float, diameter: float
) -> str | tuple[float, ...]:
    """Toe, end, depths and velocities of the jump of one frame, or the reason why it has none."""
    if depth.max(initial=0.0) < 0.5 * diameter:
        return "the channel is dry"
    ramp = fit_ramp(edges, depth)
    if ramp is None or ramp.depth_2 < LEAST_RATIO * max(ramp.depth_1, 0.0):
        return f"the depth nowhere rises by a factor of {LEAST_RATIO}"
    middle = 0.5 * (edges[1:] + edges[:-1])
    before, behind = middle < ramp.toe, middle > ramp.end
    if before.any() and not behind.any() and _backed_up(edges, depth, discharge, gravity, ramp.toe):
        return TO_THE_END
    if not before.any() or not behind.any():
        return "the rise has no level stretch on both sides"
    depth_1, depth_2 = depth[before].mean(), depth[behind].mean()
    if depth_1 < 0.5 * diameter:
        return "no stream in front of the rise: a wave runs on a dry bed"
    if ramp.share < LEAST_SHARE:
        return f"no ramp between two levels fits (it explains {100 * ramp.share:z.0f} % of the variance)"
    velocity_1, velocity_2 = (discharge[side].sum() / depth[side].sum() for side in (before, behind))
    froude_1, froude_2 = velocity_1 / sqrt(gravity * depth_1), velocity_2 / sqrt(gravity * depth_2)
    if froude_1 <= 1:
        return f"the stream in front of the rise is subcritical (Fr = {froude_1:z.2f})"
    if froude_2 >= 1:
        return f"the stream behind the rise is still supercritical (Fr = {froude_2:z.2f})"
    return ramp.toe, ramp.end, depth_1, depth_2, velocity_1, velocity_2


def _backed_up(edges: np.ndarray, depth: np.ndarray, discharge: np.ndarray, gravity: float, toe: float) -> bool:
    """Tells whether the stream is supercritical before a toe and subcritical in the mean after it."""
    before = edges[1:] <= toe
    parts = (before, edges[:-1] >= toe)
    if not all(part.any() and depth[part].mean() > 0 for part in parts):
        return False
    first, last = (discharge[part].sum() / depth[part].sum() / sqrt(gravity * depth[part].mean()) for part in parts)
    return first > 1 > last


def equivalent_position(
    edges: np.ndarray, depth: np.ndarray, toe: float, end: float, depth_1: float, depth_2: float
) -> float:
    """Place where a step between two levels holds the mass of the profile around the ramp, m (exact for any step).

    ``(x - a) s1 + (b - x) s2 = integral of s from a to b``, with a and b at bin edges a bin beyond the ramp's ends.
    """
    width = edges[1] - edges[0]
    first = max(0, int(np.floor((toe - edges[0]) / width)) - 1)
    last = min(len(depth), int(np.ceil((end - edges[0]) / width)) + 1)
    a, b = edges[first], edges[last]
    return float((b * depth_2 - a * depth_1 - depth[first:last].sum() * width) / (depth_2 - depth_1))


@dataclass(frozen=True)
class FrontMotion(AlongStream):
    """Straight-line motion.

    Attributes
    ----------
    speed, error : float
        m/s; the error is the scatter of the speeds of eight pieces of the record.
    start : float
        Position at t = 0 of the fit, m.
    points : int
    """

    ALONG = ("speed", "start")
    speed: float
    error: float
    start: float
    points: int


def straight_motion(time: np.ndarray, position: np.ndarray) -> FrontMotion:
    """Speed by least squares; NaN with fewer than two points, its error with fewer than two points a piece."""
    good = np.isfinite(position) & np.isfinite(time)
    t, x = time[good], position[good]
    n = len(t)
    if n < 2 or np.ptp(t) == 0:
        return FrontMotion(nan, nan, nan, n)
    centred = t - t.mean()
    speed = float(centred @ x) / float(centred @ centred)
    return FrontMotion(speed, piece_error(piece_speeds(t, x)), float(x.mean() - speed * t.mean()), n)


def piece_speeds(time: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Displacement over time of each piece of a record, m/s, shape (pieces,); empty where it is too short."""
    bounds = piece_bounds(len(time))
    return np.diff(position[bounds]) / np.diff(time[bounds]) if bounds else np.empty(0)
