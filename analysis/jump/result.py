# SPDX-License-Identifier: GPL-2.0-or-later
"""The hydraulic jump of a run: found, followed, measured in its own frame, and held against theory.

Definitions stand in docs/analysis.md.
"""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass, replace
from math import isfinite, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.units import number

from .frame import (
    END_SHARE,
    TOE_SHARE,
    Balance,
    Mass,
    MovingProfile,
    Roller,
    State,
    balance,
    crossing,
    mass_balance,
    measure_state,
    move_along,
    roller,
    zones,
)
from .tail import Tail, measure_tail
from .track import JumpTrack, Motion, straight_motion, track_jump

if TYPE_CHECKING:
    import xarray as xr

    from lammps_jump.analysis.contacts import ContactSeries

FIELDS = ("mass_depth", "surface_depth", "discharge", "momentum_flux", "energy_flux", "packing", "surface_velocity")
STILL = 0.02
"""Below this share of sqrt(g s) the discs of a bin count as standing."""
HEAP_SLOPE = 0.02
"""A standing surface steeper than this is a heap: water at rest is level."""
INLET_REACH = 2.0
"""The inlet is drowned when the toe is closer than this many inflow depths (or bins) to it."""


@dataclass(frozen=True)
class Heap:
    """Discs behind the jump that stand still."""

    standing_share: float = number("", "share of the discs behind the toe that stand still", default=nan)
    surface_slope: float = number("", "slope of the surface behind the crest", default=nan)

    @property
    def locked(self) -> bool:
        """Most discs stand still under a sloping surface: friction has locked them."""
        return self.standing_share > 0.5 and abs(self.surface_slope) > HEAP_SLOPE


@dataclass(frozen=True)
class JumpResult:
    """All that is known of a jump; `verdict` says whether it is one.

    Attributes
    ----------
    verdict : {'jump', 'no jump found', 'drowned inlet', 'locked heap'}
    reason : str
        One sentence behind the verdict.
    direction : int
        +1 for a stream towards larger x, -1 towards smaller; positions below are along the stream from `origin`, and
        ``x = direction * position``.
    track : JumpTrack or None
    in_window : ndarray of bool, shape (frames,)
    toe_motion, end_motion, motion : Motion or None
        Of the toe, the end and the front of equal mass.
    moving : MovingProfile or None
    toe, end : float
        In the moving frame, from the mean mass depth, m from the front; `surface_toe`, `surface_end` from the surface.
    upstream, downstream : State or None
    developed : bool
        A level stretch behind the end was there to be measured.
    balance : Balance or None
    mass : Mass or None
    roller : Roller or None
    heap : Heap or None
    tail : Tail or None
    """

    verdict: str
    reason: str
    flow: Flow
    direction: int
    track: JumpTrack | None = None
    in_window: np.ndarray | None = None
    toe_motion: Motion | None = None
    end_motion: Motion | None = None
    motion: Motion | None = None
    moving: MovingProfile | None = None
    toe: float = nan
    end: float = nan
    surface_toe: float = nan
    surface_end: float = nan
    upstream: State | None = None
    downstream: State | None = None
    developed: bool = False
    balance: Balance | None = None
    mass: Mass | None = None
    roller: Roller | None = None
    heap: Heap | None = None
    tail: Tail | None = None
    window: tuple[float, float] = (nan, nan)
    bin_width: float = nan

    @property
    def speed(self) -> float:
        """Velocity of the front in the laboratory, m/s along x."""
        return self.direction * self.motion.speed if self.motion else nan

    def tables(self) -> dict[str, dict[str, np.ndarray]]:
        """CSV tables: the track, and the mean profile in the moving frame."""
        result = {}
        if self.track is not None:
            track, sign = self.track, self.direction
            result["jump_track.csv"] = {
                "time": track.time,
                "toe": sign * track.toe,
                "end": sign * track.end,
                "position": sign * track.position,
                "mass_depth_1": track.depth_1,
                "mass_depth_2": track.depth_2,
                "velocity_1": sign * track.velocity_1,
                "velocity_2": sign * track.velocity_2,
                "found": track.found.astype(int),
            }
        if self.moving is not None:
            means = {name: self.moving.mean(name) for name in self.moving.fields}
            result["jump_frame.csv"] = {"distance": self.moving.xi, **means}
        return result


def level_reach(profiles: xr.Dataset, flow: Flow, direction: int) -> slice:
    """Bins, in the stream's order, of the longest stretch of level bed: up to a sill or a fall."""
    bed = profiles["bed"].values[::direction]
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(np.abs(np.diff(bed)) < 0.05 * flow.scene.diameter)) + 1
    ends = np.concatenate([[0], breaks, [len(bed)]])
    runs = [(stop - start, -start) for start, stop in itertools.pairwise(ends) if np.isfinite(bed[start])]
    length, start = max(runs, default=(0, 0))
    return slice(int(-start), int(-start + length))


def analyse_jump(profiles: xr.Dataset, flow: Flow, contacts: ContactSeries | None = None) -> JumpResult:
    """Find the jump in depth profiles, follow it, measure it in its own frame.

    Parameters
    ----------
    profiles : xarray.Dataset
        Of `profiles.compute_profiles`; its window is used.
    flow : Flow
    contacts : ContactSeries, optional
        On the same bins; adds contact pressure and the force of the bed to the momentum balance.

    Returns
    -------
    JumpResult
        With verdict 'no jump found' and the reason where there is none.
    """
    time = profiles["time"].values
    window = (profiles.attrs["window_begin"], profiles.attrs["window_end"])
    width = profiles.attrs["bin_width"]
    in_window = (time >= window[0] - 1e-9) & (time <= window[1] + 1e-9)
    total = float(np.nansum(profiles["discharge"].values[in_window]))
    direction = -1 if total < 0 else 1
    common = {"flow": flow, "direction": direction, "window": window, "bin_width": width, "in_window": in_window}
    gravity = -flow.scene.gravity[1]
    if gravity <= 0:
        return JumpResult("no jump found", "there is no gravity towards the bed", **common)
    reach = level_reach(profiles, flow, direction)
    if reach.stop - reach.start < 8:
        return JumpResult("no jump found", "fewer than eight bins of level bed to look at", **common)
    x = direction * profiles["x"].values[::direction][reach]
    data = {name: profiles[name].values[:, ::direction][:, reach] for name in FIELDS}
    for name in ("discharge", "energy_flux", "surface_velocity"):
        data[name] = direction * data[name]
    if contacts is not None:
        scale = 1.0 / flow.scene.density
        data["thrust"] = scale * contacts.thrust[:, ::direction][:, reach]
        data["bed"] = direction * scale / width * contacts.wall_fx[:, ::direction][:, reach]
    edges = np.concatenate([x - 0.5 * width, [x[-1] + 0.5 * width]])
    track = track_jump(edges, time, data["mass_depth"], data["discharge"], gravity, flow.scene.diameter, in_window)
    used = track.found & in_window
    if used.sum() < max(2, 0.5 * in_window.sum()):
        heap = _heap(edges, data, in_window, edges[0], gravity)
        why = _why_none(track, in_window, data, heap, gravity, flow.inflow_depth)
        return JumpResult(*why, track=track, heap=heap, **common)
    motions = {
        "toe_motion": straight_motion(time[used], track.toe[used]),
        "end_motion": straight_motion(time[used], track.end[used]),
        "motion": straight_motion(time[used], track.position[used]),
    }
    heap = _heap(edges, data, used, float(np.mean(track.end[used])), gravity)
    result = JumpResult("jump", "", track=track, heap=heap, **motions, **common)
    result = _measure(result, x, data, used, gravity)
    verdict, reason = _judge(result, edges[0], used, gravity)
    return replace(result, verdict=verdict, reason=reason)


def _measure(result: JumpResult, x: np.ndarray, data: dict, used: np.ndarray, gravity: float) -> JumpResult:
    """Average in the moving frame; toe, end, states, balances."""
    track, speed = result.track, result.motion.speed
    shifted = {name: values[used] for name, values in data.items()}
    # the frame moves with the fitted straight motion: a control volume at a steady speed has an exact balance
    front = result.motion.start + speed * track.time[used]
    moving = move_along(x, track.time[used], shifted, front, track.reach_end[used])
    toe = float(np.median(track.toe[used] - front))
    end = float(np.median(track.end[used] - front))
    levels = float(np.median(track.depth_1[used])), float(np.median(track.depth_2[used]))
    depth, surface = moving.mean("mass_depth"), moving.mean("surface_depth")
    # twice: the states need the ends, the ends need the levels
    for _ in range(2):
        before, behind, enough = zones(moving, toe, end, *levels)
        one = measure_state(moving, before, speed, gravity)
        two = measure_state(moving, behind, speed, gravity)
        toe, end = _ends(moving.xi, depth, one.mass_depth.value, two.mass_depth.value, toe, end)
    ends = _ends(moving.xi, surface, one.surface_depth.value, two.surface_depth.value, toe, end)
    flow = result.flow
    along = result.direction * flow.scene.gravity[0]
    return replace(
        result,
        moving=moving,
        toe=toe,
        end=end,
        surface_toe=ends[0],
        surface_end=ends[1],
        upstream=one,
        downstream=two,
        developed=enough,
        balance=balance(moving, one, two, speed, gravity, along),
        mass=mass_balance(moving, one, two, speed),
        roller=roller(moving, speed, toe, end),
        tail=measure_tail(
            x,
            track.time[used],
            data["mass_depth"][used],
            data["surface_depth"][used],
            front,
            two.mass_depth.value,
        ),
    )


def _ends(xi, values, level_1, level_2, toe, end) -> tuple[float, float]:
    """Where the mean profile has made 5 % and 95 % of its rise; the given places where it does not cross."""
    rise = level_2 - level_1
    new_toe = crossing(xi, values, level_1 + TOE_SHARE * rise, toe)
    new_end = crossing(xi, values, level_1 + END_SHARE * rise, end)
    new_toe = new_toe if isfinite(new_toe) else toe
    return new_toe, max(new_end if isfinite(new_end) else end, new_toe)


def _heap(edges: np.ndarray, data: dict, chosen: np.ndarray, start: float, gravity: float) -> Heap:
    """How much of the discs behind the jump stands still, and how steep their surface is."""
    middle = 0.5 * (edges[1:] + edges[:-1])
    depth, discharge = data["mass_depth"][chosen].mean(axis=0), data["discharge"][chosen].mean(axis=0)
    behind = (middle > start) & (depth > 0)
    if behind.sum() < 3:
        return Heap()
    s, q = depth[behind], discharge[behind]
    standing = np.abs(q / s) < STILL * np.sqrt(gravity * s)
    share = float(s[standing].sum() / s.sum())
    crest = int(np.argmax(s))
    slope = nan
    if len(s) - crest >= 3:
        slope = float(np.polyfit(middle[behind][crest:], s[crest:], 1)[0])
    return Heap(share, slope)


def _judge(result: JumpResult, inlet: float, used: np.ndarray, gravity: float) -> tuple[str, str]:
    """Jump, locked heap or drowned inlet, and the reason."""
    track, heap = result.track, result.heap
    late = np.flatnonzero(used)[-max(1, int(used.sum()) // 5) :]
    distance = float(np.median(track.toe[late])) - inlet
    drowned = distance < INLET_REACH * max(result.flow.inflow_depth or 0.0, result.bin_width)
    if heap.locked:
        return "locked heap", (
            f"behind the toe {100 * heap.standing_share:.0f} % of the discs stand still under a surface that "
            f"slopes by {heap.surface_slope:+.3f}: friction has locked them, this is no hydraulic jump."
            f"{' It has reached the inlet.' if drowned else ''}"
        )
    if drowned:
        return "drowned inlet", f"the toe stands {distance:.2f} m from the inlet: the inflow is no longer free."
    words = "moves upstream" if result.motion.speed < 0 else "moves downstream"
    uncertain = 2 * result.motion.error if isfinite(result.motion.error) else 0.0
    if abs(result.motion.speed) <= max(uncertain, 1e-6 * sqrt(gravity * track.depth_2[used].mean())):
        words = "stands still within the error"
    tail = "" if result.developed else " No level stretch behind its end: the downstream state is a lower bound."
    return "jump", f"the front {words} at {result.speed:+.2f} m/s.{tail}"


def _why_none(track, in_window, data, heap, gravity, inflow) -> tuple[str, str]:
    """Verdict and reason: the commonest reason of the window, and whether the inlet is drowned or the flow locked."""
    reasons = Counter(reason.split(" (")[0] for reason, inside in zip(track.why, in_window, strict=True) if inside)
    reasons.pop("", None)
    counted = ", ".join(f"{reason} ({n} of {int(in_window.sum())} frames)" for reason, n in reasons.most_common(2))
    if heap.locked:
        share, slope = heap.standing_share, heap.surface_slope
        reason = f"{100 * share:.0f} % of the discs stand still under a surface that slopes by {slope:+.3f}; {counted}"
        return "locked heap", reason
    depth, discharge = (data[name][in_window].mean(axis=0)[:3] for name in ("mass_depth", "discharge"))
    if inflow and depth.mean() > 0:
        froude = discharge.sum() / depth.sum() / sqrt(gravity * depth.mean())
        if depth.mean() > 1.5 * inflow and froude < 1:
            return "drowned inlet", (
                f"the flow at the inlet is {depth.mean():.2f} m deep (inflow {inflow:.2f} m) and subcritical "
                f"(Fr = {froude:.2f}): what jump there was has run over the inlet"
            )
    return "no jump found", counted or "no frame in the window"
