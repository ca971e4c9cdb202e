"""The front of a collapsing column: where it is, how high the column stands, how fast its surface moves.

Definitions (docs/analysis.md): the *bulk front* ends the row of discs that starts at the back wall and has no gap of
two diameters or more between neighbours in x; the *99 % front* is the quantile of the discs' right edges.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, nan, sqrt

import numpy as np

from lammps_jump.dump.frame import Frame
from lammps_jump.physics import jump as theory
from lammps_jump.physics import measured as reference_data

from .flow import FlowContext

GAP = 2.0
"""Diameters of empty x that end the bulk."""


@dataclass(frozen=True)
class FrontHistory:
    """Front and column against time; lengths in m from the back wall, NaN where a frame holds no disc.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    bulk, quantile : ndarray
        Bulk front and 99 % front.
    height : ndarray
        Top of the column at the back wall: highest edge of the discs within a diameter of it and connected to the bed.
    top_speed : ndarray
        Speed of the surface: mean velocity (m/s, along x) of the topmost disc of every diameter of x in the bulk.
    tip_speed : ndarray
        Mean velocity along x of the discs within five diameters behind the bulk front, m/s.
    back : float
        Position of the back wall, m.
    column : (float, float)
        Base a and height H of the column at the start, m.
    """

    time: np.ndarray
    bulk: np.ndarray
    quantile: np.ndarray
    height: np.ndarray
    top_speed: np.ndarray
    tip_speed: np.ndarray
    back: float
    column: tuple[float, float]


def back_wall(context: FlowContext) -> float | None:
    """Position of the vertical wall that the column leans on, m; None where there is none."""
    starts = (wall.room("x")[0] for wall in context.walls)
    return next((start for start in starts if isfinite(start)), None)


def bulk_front(x: np.ndarray, diameter: float) -> float:
    """Right edge of the last disc before the first gap of `GAP` diameters between neighbours in x; NaN for none."""
    if not len(x):
        return nan
    ordered = np.sort(x)
    gaps = np.flatnonzero(np.diff(ordered) > GAP * diameter)
    return float(ordered[gaps[0] if gaps.size else -1]) + 0.5 * diameter


def quantile_front(x: np.ndarray, diameter: float, share: float = 0.99) -> float:
    """Right edge that `share` of the discs do not pass, m; NaN for none."""
    return float(np.quantile(x, share)) + 0.5 * diameter if len(x) else nan


def stack_top(y: np.ndarray, diameter: float, bed: float) -> float:
    """Top edge of the discs that stand on the bed without a gap of `GAP` diameters, m above it; 0 for none."""
    ordered = np.sort(y)
    if not ordered.size or ordered[0] - bed > 0.5 * diameter + GAP * diameter:
        return 0.0
    gaps = np.flatnonzero(np.diff(ordered) > GAP * diameter)
    return float(ordered[gaps[0] if gaps.size else -1]) + 0.5 * diameter - bed


class FrontTracker:
    """Follows the front from frame to frame; ask for `result` at the end."""

    def __init__(self, context: FlowContext):
        self.context = context
        self.back = back_wall(context)
        self._rows: list[tuple[float, ...]] = []
        self._column: tuple[float, float] | None = None

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        d, x, y = self.context.diameter, frame.x, frame.y
        if not frame.n:
            self._rows.append((time, nan, nan, nan, nan, nan))
            return
        if self.back is None:  # no wall: the column's own left edge at the start
            self.back = float(x.min()) - 0.5 * d
        bed = float(self.context.bed_height(np.array([self.back + 0.5 * d]))[0])
        if not np.isfinite(bed):
            bed = float(y.min()) - 0.5 * d
        near = x - self.back < 1.5 * d
        front = bulk_front(x, d)
        top, tip = nan, nan
        bulk = np.flatnonzero(x + 0.5 * d <= front + 1e-12)
        if bulk.size and {"vx"} <= set(frame.columns):
            strip = ((x[bulk] - self.back) / d).astype(int)
            order = np.lexsort((y[bulk], strip))
            highest = order[np.flatnonzero(np.diff(strip[order], append=strip.max() + 1))]
            top = float(np.mean(frame.vx[bulk[highest]]))
            tip = float(np.mean(frame.vx[bulk[x[bulk] + 0.5 * d >= front - 5 * d]]))
        height = stack_top(y[near], d, bed)
        # the column as it stands when the gate opens
        if self._column is None or time <= 0:
            self._column = (front - self.back, height)
        self._rows.append((time, front - self.back, quantile_front(x, d) - self.back, height, top, tip))

    def result(self) -> FrontHistory:
        """The history of all frames added."""
        rows = np.array(self._rows, float).reshape(-1, 6)
        back = nan if self.back is None else self.back
        return FrontHistory(*rows.T, back, self._column or (nan, nan))


@dataclass(frozen=True)
class Comparison:
    """A measured curve against another one.

    Attributes
    ----------
    x, measured, expected : ndarray
    rms : float
        Root mean square of measured/expected - 1; NaN where they have no x in common.
    """

    x: np.ndarray
    measured: np.ndarray
    expected: np.ndarray

    @property
    def rms(self) -> float:
        """Root mean square of the relative difference."""
        return float(np.sqrt(np.mean((self.measured / self.expected - 1.0) ** 2))) if len(self.x) else nan


def against_curve(x: np.ndarray, y: np.ndarray, curve_x, curve_y, *, beyond: float = -np.inf) -> Comparison:
    """Measured y(x), linear in between, at the points x > `beyond` of a tabulated curve that the measurement covers."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    curve_x, curve_y = np.asarray(curve_x, float), np.asarray(curve_y, float)
    take = (curve_x > beyond) & (curve_x <= x.max()) & (curve_x >= x.min()) if x.size else np.zeros(len(curve_x), bool)
    return Comparison(curve_x[take], np.interp(curve_x[take], x, y) if x.size else curve_x[take], curve_y[take])


def dimensionless(history: FrontHistory, gravity: float) -> dict[str, np.ndarray]:
    """Martin & Moyce's variables: T = n t sqrt(g/a), tau = t sqrt(g/a), Z = front/a (both fronts), h/H; n^2 = H/a."""
    base, height = history.column
    tau = history.time * sqrt(gravity / base)
    return {
        "T": sqrt(height / base) * tau,
        "tau": tau,
        "Z": history.bulk / base,
        "Z99": history.quantile / base,
        "h": history.height / height,
    }


def free_length(context: FlowContext, history: FrontHistory) -> float:
    """Distance from the back wall to the first thing in the way of the front, m; infinite where there is none."""
    base = history.back + history.column[0]
    bed = float(context.bed_height(np.array([base]))[0])
    starts = [wall.extent[0][0] for wall in context.walls if wall.finite]
    faces = [start for start in starts if start > base + context.diameter]
    faces += [wall.room("x")[1] for wall in context.walls]
    # the floor may end before anything stands in the way
    probe = np.linspace(base, context.domain[0][1], 2000)
    level = context.bed_height(probe)
    changed = np.flatnonzero(~(np.abs(level - bed) < 1e-9))
    faces += [float(probe[changed[0]])] if changed.size else []
    return min(faces, default=inf) - history.back


def summarise_front(history: FrontHistory, context: FlowContext) -> dict:
    """Numbers for the summary: fronts at the end, against Ritter while it holds, against Martin & Moyce.

    Parameters
    ----------
    history : FrontHistory
    context : FlowContext

    Returns
    -------
    dict
        position, position_99, column_height at the last frame that holds discs; column_base and column_depth at the
        start; time (s); speed: bulk front between a tenth and all of the free path, from a straight-line fit;
        `ritter`: times while it holds and RMS of the front; `martin_moyce`: RMS of bulk and 99 % front for
        T > 0.8, of the height, slope dZ/dT on [1.43, 3.33], their table's aspect ratio (2) and ours.
    """
    good = np.isfinite(history.bulk)
    base, depth = history.column
    nothing = {"position": None, "position_99": None, "column_height": None, "speed": None}
    if not good.any() or not base > 0:
        return {**nothing, "reason": "no frame holds a disc, so there is no front"}
    last = np.flatnonzero(good)[-1]
    gravity = -context.gravity[1]
    free = free_length(context, history)
    summary = {
        "time": float(history.time[last]),
        "position": float(history.back + history.bulk[last]),
        "position_99": float(history.back + history.quantile[last]),
        "column_height": float(history.height[last]),
        "column_base": base,
        "column_depth": depth,
        "highest_surface_speed": _none(np.nanmax(history.top_speed) if np.isfinite(history.top_speed).any() else nan),
        "free_length": None if np.isinf(free) else float(free),
        "speed": None,
        "arrival_time": None,
        "ritter": None,
        "martin_moyce": None,
    }
    running = good & (history.time >= 0) & (history.bulk > base + 0.1 * (free - base if np.isfinite(free) else base))
    hit = np.flatnonzero(good & (history.time >= 0) & (history.bulk >= free - 0.5 * context.diameter))
    if hit.size:
        summary["arrival_time"] = float(history.time[hit[0]])
        running[hit[0] :] = False
    if running.sum() >= 3:
        summary["speed"] = float(np.polyfit(history.time[running], history.bulk[running], 1)[0])
    if gravity <= 0 or depth <= 0:
        return summary
    # once the front meets an obstacle, neither theory speaks of it any more
    end = history.time[hit[0]] if hit.size else np.inf
    summary["ritter"] = _ritter(history, base, depth, gravity, end)
    summary["martin_moyce"] = _martin_moyce(history, gravity, end)
    return summary


def _ritter(history: FrontHistory, base: float, depth: float, gravity: float, end: float) -> dict:
    limit = theory.ritter_wall_time(base, depth, gravity)
    inside = (history.time > 0) & (history.time <= min(limit, end)) & np.isfinite(history.bulk)
    expected = base + np.array([theory.ritter_front(t, depth, gravity) for t in history.time[inside]])
    comparison = Comparison(history.time[inside], history.bulk[inside], expected)
    return {
        "valid_until": limit,
        "frames": int(inside.sum()),
        "front_speed": 2.0 * sqrt(gravity * depth),
        "rms": _none(comparison.rms),
    }


def _martin_moyce(history: FrontHistory, gravity: float, end: float) -> dict:
    variables = dimensionless(history, gravity)
    live = (history.time >= 0) & (history.time <= end)
    variables = {name: values[live] for name, values in variables.items()}
    front, tall = reference_data.MARTIN_MOYCE_FRONT, reference_data.MARTIN_MOYCE_HEIGHT
    bulk = against_curve(variables["T"], variables["Z"], front.x, front.y, beyond=0.8)
    most = against_curve(variables["T"], variables["Z99"], front.x, front.y, beyond=0.8)
    column = against_curve(variables["tau"], variables["h"], tall.x, tall.y)
    straight = (variables["T"] >= 1.43) & (variables["T"] <= 3.33) & np.isfinite(variables["Z"])
    slope = np.polyfit(variables["T"][straight], variables["Z"][straight], 1)[0] if straight.sum() >= 3 else nan
    aspect = history.column[1] / history.column[0]
    return {
        "aspect": aspect,
        "aspect_of_table": 2.0,
        "comparable": bool(abs(aspect - 2.0) < 0.1),
        "points": len(bulk.x),
        "rms_bulk": _none(bulk.rms),
        "rms_99": _none(most.rms),
        "rms_height": _none(column.rms),
        "slope": _none(slope),
        "slope_of_table": reference_data.MARTIN_MOYCE_FRONT_SLOPE[2],
    }


def _none(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
