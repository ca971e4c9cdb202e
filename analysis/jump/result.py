# SPDX-License-Identifier: GPL-2.0-or-later
"""The hydraulic jump of a run: detected, followed, measured in its own frame, and compared with theory.

Definitions are in docs/measuring.md.
"""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace
from math import isfinite, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.contacts import ContactSeries
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.statistics import piece_bounds
from lammps_jump.analysis.verdicts.kinds import AT_SILL

from . import frame
from .found import MeasuredJump, StandingHeap, TrackedJump
from .stream import compression_front, measure_stream, measure_tail
from .track import TO_THE_END, FrontMotion, JumpTrack, piece_speeds, straight_motion, track_jump

if TYPE_CHECKING:
    import xarray as xr

Stretches = tuple[tuple[float, float], tuple[float, float]]

FIELDS = ["mass_depth", "surface_depth", "discharge", "momentum_flux", "energy_flux", "packing", "surface_velocity"]
ODD = ("discharge", "energy_flux", "surface_velocity", "bed")
"""Variables that change their sign with the direction of x."""
STILL = 0.02
"""Below this share of sqrt(g s) the discs of a bin count as standing."""
SURE, MARGINAL = 0.9, 0.1
"""Share of the window's frames with a jump that makes a jump, and that makes a marginal one."""
LEVEL = 0.05
"""Change of the bed's height from bin to bin below which it counts as level, in diameters."""
BAFFLE = 0.25
"""A block that is lower than this share of the depth above it does not end the level bed."""
INLET_REACH = 2.0
"""The inlet is drowned when the toe is closer than this many inflow depths (or bins) to it."""


def level_reach(bed: np.ndarray, diameter: float) -> np.ndarray:
    """Bins, in the stream's order, of the longest stretch of level bed (heights in m): up to a sill or a fall."""
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(np.abs(np.diff(bed)) < LEVEL * diameter)) + 1
    stretches = [bins for bins in np.split(np.arange(len(bed)), breaks) if np.isfinite(bed[bins[0]])]
    return max(stretches, key=len, default=np.arange(0))


def without_baffles(bed: np.ndarray, depth: np.ndarray, width: float, diameter: float) -> np.ndarray:
    """Heights of the bed (m) in bins of this width, with baffle blocks taken off.

    A baffle is on one level bed, is lower than `BAFFLE` of the depth (m) above it and shorter than that depth.
    """
    bare = bed.copy()
    longest = int(np.nanmax(depth, initial=0.0) / width)
    for bins in range(1, min(longest, len(bed) - 2) + 1):
        for first in range(1, len(bed) - bins):
            block, before, behind = slice(first, first + bins), bare[first - 1], bare[first + bins]
            water = float(depth[block].min())
            rise = bare[block].min() - before, bare[block].max() - before
            if (
                abs(behind - before) < LEVEL * diameter
                and 0 < rise[0] <= rise[1] < BAFFLE * water
                and bins * width < water
            ):
                bare[block] = before
    return bare


def analyse_jump(profiles: xr.Dataset, flow: Flow, contacts: ContactSeries | None = None) -> TrackedJump:
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
    TrackedJump
        One that was detected is a `MeasuredJump`; else the verdict is another, with its reason.
    """
    window, gravity = window_of(profiles), flow.gravity
    in_window = within(profiles["time"].values, window)
    direction = -1 if np.nansum(profiles["discharge"].values[in_window]) < 0 else 1
    nothing = TrackedJump("no jump found", "", window=window, flow=flow, direction=direction, in_window=in_window)
    if gravity <= 0:
        return replace(nothing, reason="there is no gravity towards the bed")
    depth = profiles["mass_depth"].values[in_window].mean(axis=0)
    bare = without_baffles(profiles["bed"].values, depth, profiles.attrs["bin_width"], flow.scene.diameter)
    reach = level_reach(bare[::direction], flow.scene.diameter)
    if len(reach) < 8:
        return replace(nothing, reason="fewer than eight bins of level bed to look at")
    fields = profiles[FIELDS]
    if contacts is not None:
        scale, dims = 1.0 / flow.scene.density, ("time", "x")
        bed = scale / profiles.attrs["bin_width"] * contacts.wall_fx
        fields = fields.assign(thrust=(dims, scale * contacts.thrust), bed=(dims, bed))
    stream = frame.along_stream(fields, direction, ODD).isel(x=reach)
    at_sill = np.flatnonzero((profiles["bed"].values != bare)[::direction][reach])
    stream.attrs["clear"] = int(at_sill[0]) if at_sill.size else len(reach)
    jump = _follow(nothing, stream, profiles.attrs["bin_width"]).turned(direction)
    if not isinstance(jump, MeasuredJump):
        return jump
    return replace(jump, pieces=tuple(piece.turned(direction) for piece in jump.pieces))


def _follow(nothing: TrackedJump, stream: xr.Dataset, width: float) -> TrackedJump:
    """The jump of a stream towards larger x, on a level bed, in bins of this width, m."""
    flow, in_window, gravity = nothing.flow, nothing.in_window, nothing.flow.gravity
    x, time = stream.x.values, stream.time.values
    edges = np.append(x - 0.5 * width, x[-1] + 0.5 * width)
    near = INLET_REACH * max(flow.inflow_depth or 0.0, width)
    begin = edges[0] * nothing.direction
    # a level bed at the foot of a chute has no inlet that could be drowned
    from_inlet = all(abs(row.x - begin) <= near for row in flow.scene.inlets)
    inflow = flow.inflow_depth if from_inlet else None
    track = track_jump(stream, edges, gravity, flow.scene.diameter, in_window)
    if "thrust" in stream:
        track = replace(track, compression=compression_front(stream, track, gravity))
    used = track.found & in_window
    share = used.sum() / max(in_window.sum(), 1)
    if used.sum() < 2 or share < 0.5:
        inside = stream.isel(time=in_window)
        heap = _heap(inside, edges[0], gravity)
        verdict, reason = _why_none(track, in_window, inside, heap, gravity, inflow)
        if used.sum() < 2 or share < MARGINAL or verdict != "no jump found":
            return replace(nothing, verdict=verdict, reason=reason, track=track, heap=heap)
    heap = _heap(stream.isel(time=used), float(np.mean(track.end[used])), gravity)
    known = replace(
        nothing,
        heap=heap,
        toe_speed=straight_motion(time[used], track.toe[used]).speed,
        end_speed=straight_motion(time[used], track.end[used]).speed,
    )
    result = _measure(known, track, straight_motion(time[used], track.position[used]), stream, used)
    late = np.flatnonzero(used)[-max(1, int(used.sum()) // 5) :]
    to_inlet = float(np.median(track.toe[late])) - edges[0]
    drowned = from_inlet and to_inlet < near
    verdict, reason = _judge(result, heap, gravity, to_inlet, drowned)
    if verdict == "jump" and share < SURE:
        others = _why_none(track, in_window, stream, heap, gravity, None)[1]
        verdict = "marginal jump"
        reason = f"{100 * share:z.0f} % of the frames have a jump, others not: {others}. {reason}"
    return replace(result, verdict=verdict, reason=reason)


def _measure(
    known: TrackedJump, track: JumpTrack, motion: FrontMotion, stream: xr.Dataset, used: np.ndarray
) -> MeasuredJump:
    """Average in the moving frame; toe, end, states, balances."""
    speed = motion.speed
    # the frame moves with the fitted straight motion: a control volume at a steady speed has an exact balance
    front = motion.start + speed * track.time[used]
    moving = frame.move_along(stream.isel(time=used), front, track.reach_end[used])
    toe = float(np.median(track.toe[used] - front))
    end = float(np.median(track.end[used] - front))
    levels = float(np.median(track.mass_depth_1[used])), float(np.median(track.mass_depth_2[used]))
    before, behind, _ = frame.zones(moving, toe, end, *levels)
    result = _within(known, track, motion, moving, (before, behind), (toe, end))
    # twice: the states need the ends, the ends need the levels
    toe, end = result.mass_toe, result.mass_end
    before, behind, enough = frame.zones(moving, toe, end, *levels)
    result = _within(known, track, motion, moving, (before, behind), (toe, end))
    toe, end = result.mass_toe, result.mass_end
    depth = result.downstream.mass_depth
    # water beyond a baffle is lower: it takes up momentum
    tail = measure_tail(stream.isel(time=used, x=slice(stream.attrs["clear"])), front, depth, known.flow.fit_stretch)
    level = tail.depth.value if isfinite(tail.depth.value) else depth
    inlet = measure_stream(stream, track, used, speed, level, result.flow.gravity)
    roller = frame.roller(moving, speed, toe, end)
    result = replace(result, stream=inlet, developed=enough, roller=roller, tail=tail)
    return replace(result, pieces=_pieces(result))


def _within(
    known: TrackedJump,
    track: JumpTrack,
    motion: FrontMotion,
    moving: frame.Moving,
    stretches: Stretches,
    around: tuple[float, float],
) -> MeasuredJump:
    """States, ends and balances from frames of the moving frame, in the zones of the states."""
    one, two = (frame.measure_state(moving, zone, motion.speed, known.flow.gravity) for zone in stretches)
    toe, end = _ends(moving, "mass_depth", one, two, *around)
    ends = _ends(moving, "surface_depth", one, two, toe, end)
    measured = {
        "track": track,
        "motion": motion,
        "moving": moving,
        "mass_toe": toe,
        "mass_end": end,
        "surface_toe": ends[0],
        "surface_end": ends[1],
        "upstream": one,
        "downstream": two,
        "momentum_terms": frame.balance(moving, one, two, known.direction * known.flow.scene.gravity[0]),
        "mass": frame.mass_balance(moving, one, two),
    }
    return MeasuredJump(**vars(known) | measured)


def _pieces(whole: MeasuredJump) -> tuple[MeasuredJump, ...]:
    """The jump of each piece of the window, with the speed of that piece."""
    frames = np.flatnonzero(whole.used)
    track = whole.track
    speeds = [piece_speeds(track.time[frames], line[frames]) for line in (track.toe, track.end, track.position)]
    result = []
    bounds = itertools.pairwise(piece_bounds(len(frames)))
    for (first, stop), toe, end, front in zip(bounds, *speeds, strict=True):
        inside = np.zeros_like(whole.in_window)
        inside[frames[first:stop]] = True
        motion = FrontMotion(float(front), nan, nan, 2)
        piece = replace(whole, in_window=inside, toe_speed=float(toe), end_speed=float(end))
        zones_kept = whole.upstream.zone, whole.downstream.zone
        moving = whole.moving.cut(slice(first, stop))
        result.append(_within(piece, track, motion, moving, zones_kept, (whole.mass_toe, whole.mass_end)))
    known = all(isfinite(piece.upstream.mass_depth + piece.downstream.mass_depth) for piece in result)
    return tuple(result) if known else ()


def _ends(
    moving: frame.Moving, name: str, one: frame.FlowState, two: frame.FlowState, toe: float, end: float
) -> tuple[float, float]:
    """Places where the mean profile of a depth has made 5 % and 95 % of its rise; the given ones where it does not."""
    profile, level = moving.smoothed(name, frame.SMOOTHED * two.mass_depth), getattr(one, name)
    rise = getattr(two, name) - level
    toe = frame.crossing(moving.xi, profile, level + frame.TOE_SHARE * rise, toe)
    end = frame.crossing(moving.xi, profile, level + frame.END_SHARE * rise, end)
    return toe, max(end, toe)


def _heap(stream: xr.Dataset, start: float, gravity: float) -> StandingHeap:
    """Share of the discs downstream of the jump that stands still, and how steep their surface is."""
    x, depth, discharge = stream.x.values, *(stream[name].values.mean(axis=0) for name in ("mass_depth", "discharge"))
    behind = (x > start) & (depth > 0)
    x, s, q = x[behind], depth[behind], discharge[behind]
    if len(x) < 3:
        return StandingHeap()
    standing = np.abs(q / s) < STILL * np.sqrt(gravity * s)
    crest = int(np.argmax(s))
    slope = float(np.polyfit(x[crest:], s[crest:], 1)[0]) if len(s) - crest >= 3 else nan
    return StandingHeap(float(s[standing].sum() / s.sum()), slope)


def _judge(result: MeasuredJump, heap: StandingHeap, gravity: float, to_inlet: float, drowned: bool) -> tuple[str, str]:
    """Jump, locked heap or drowned inlet, and the reason."""
    motion = result.motion
    if heap.locked:
        return "locked heap", (
            f"behind the toe {100 * heap.standing_share:z.0f} % of the discs stand still under a surface that "
            f"slopes by {heap.surface_slope:+z.3f}: friction has locked them, this is no hydraulic jump."
            f"{' It has reached the inlet.' if drowned else ''}"
        )
    if drowned:
        return "drowned inlet", f"the toe stands {to_inlet:z.2f} m from the inlet: the inflow is no longer free."
    words = "moves upstream" if motion.speed < 0 else "moves downstream"
    uncertain = 2 * motion.error if isfinite(motion.error) else 0.0
    if abs(motion.speed) <= max(uncertain, 1e-6 * sqrt(gravity * result.track.mass_depth_2[result.used].mean())):
        words = "stands still within the error"
    tail = "" if result.developed else " No level stretch behind its end: the downstream state is a lower bound."
    return ("jump", f"the front {words}.{tail}")


def _why_none(
    track: JumpTrack,
    in_window: np.ndarray,
    stream: xr.Dataset,
    heap: StandingHeap,
    gravity: float,
    inflow: float | None,
) -> tuple[str, str]:
    """Verdict and reason: the commonest reason of the window, and whether the inlet is drowned or the flow locked."""
    reasons = Counter(reason.split(" (")[0] for reason, inside in zip(track.why, in_window, strict=True) if inside)
    reasons.pop("", None)
    counted = ", ".join(f"{reason} ({n} of {int(in_window.sum())} frames)" for reason, n in reasons.most_common(2))
    if heap.locked:
        share, slope = heap.standing_share, heap.surface_slope
        reason = (
            f"{100 * share:z.0f} % of the discs stand still under a surface that slopes by {slope:+z.3f}; {counted}"
        )
        return "locked heap", reason
    depth, discharge = (stream[name].values.mean(axis=0)[:3] for name in ("mass_depth", "discharge"))
    if inflow and depth.mean() > 0:
        froude = discharge.sum() / depth.sum() / sqrt(gravity * depth.mean())
        if depth.mean() > 1.5 * inflow and froude < 1:
            return "drowned inlet", (
                f"the flow at the inlet is {depth.mean():z.2f} m deep (inflow {inflow:z.2f} m) and subcritical "
                f"(Fr = {froude:z.2f}): what jump there was has run over the inlet"
            )
    if reasons and reasons.most_common(1)[0][0] == TO_THE_END:
        return AT_SILL, f"{counted}: there is no level water behind it to compare with theory"
    return "no jump found", counted or "no frame in the window"
