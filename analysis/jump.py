"""The hydraulic jump of a run: found, followed, measured in its own frame, and held against theory.

Definitions stand in docs/analysis.md.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import isfinite, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump import theory

from .context import FlowContext
from .jump_state import (
    END_SHARE,
    TOE_SHARE,
    Balance,
    MovingProfile,
    State,
    account_of_mass,
    balance,
    crossing,
    measure_state,
    move_along,
    roller,
    zones,
)
from .jump_track import JumpTrack, Motion, straight_motion, track_jump

if TYPE_CHECKING:
    import xarray as xr

    from .contact_series import ContactSeries

FIELDS = ("mass_depth", "surface_depth", "discharge", "momentum_flux", "energy_flux", "packing", "surface_velocity")
STILL = 0.02
"""Below this share of sqrt(g s) the discs of a bin count as standing."""
HEAP_SLOPE = 0.02
"""A standing surface steeper than this is a heap: water at rest is level."""
INLET_REACH = 2.0
"""The inlet is drowned when the toe is closer than this many inflow depths (or bins) to it."""


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
    mass, roller, heap, theory : dict
    """

    verdict: str
    reason: str
    context: FlowContext
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
    mass: dict | None = None
    roller: dict | None = None
    heap: dict | None = None
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


def level_reach(profiles: xr.Dataset, context: FlowContext, direction: int) -> slice:
    """Bins, in the stream's order, from the first that has a bed as far as it stays level: up to a sill or a fall."""
    bed = profiles["bed"].values[::direction]
    start = int(np.argmax(np.isfinite(bed)))
    same = np.abs(bed[start:] - bed[start]) < 0.05 * context.diameter
    stop = int(np.argmin(same)) if not same.all() else len(same)
    return slice(start, start + stop)


def analyse_jump(profiles: xr.Dataset, context: FlowContext, contacts: ContactSeries | None = None) -> JumpResult:
    """Find the jump in depth profiles, follow it, measure it in its own frame.

    Parameters
    ----------
    profiles : xarray.Dataset
        Of `profiles.compute_profiles`; its window is used.
    context : FlowContext
    contacts : ContactSeries, optional
        On the same bins; adds contact pressure and the force of the bed to the momentum account.

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
    common = {"context": context, "direction": direction, "window": window, "bin_width": width, "in_window": in_window}
    gravity = -context.gravity[1]
    if gravity <= 0:
        return JumpResult("no jump found", "there is no gravity towards the bed", **common)
    reach = level_reach(profiles, context, direction)
    if reach.stop - reach.start < 8:
        return JumpResult("no jump found", "fewer than eight bins of level bed to look at", **common)
    x = direction * profiles["x"].values[::direction][reach]
    data = {name: profiles[name].values[:, ::direction][:, reach] for name in FIELDS}
    for name in ("discharge", "energy_flux", "surface_velocity"):
        data[name] = direction * data[name]
    if contacts is not None:
        scale = 1.0 / context.density
        data["thrust"] = scale * contacts.thrust[:, ::direction][:, reach]
        data["bed"] = direction * scale / width * contacts.wall_fx[:, ::direction][:, reach]
    edges = np.concatenate([x - 0.5 * width, [x[-1] + 0.5 * width]])
    track = track_jump(edges, time, data["mass_depth"], data["discharge"], gravity, context.diameter, in_window)
    used = track.found & in_window
    if used.sum() < max(2, 0.5 * in_window.sum()):
        return replace(_none_found(track, in_window, data, edges, gravity, context, common), track=track)
    motions = {
        "toe_motion": straight_motion(time[used], track.toe[used]),
        "end_motion": straight_motion(time[used], track.end[used]),
        "motion": straight_motion(time[used], track.position[used]),
    }
    result = JumpResult("jump", "", track=track, **motions, **common)
    result = _measure(result, x, data, used, gravity)
    return _judge(result, edges, data, used, gravity)


def _measure(result: JumpResult, x: np.ndarray, data: dict, used: np.ndarray, gravity: float) -> JumpResult:
    """Average in the moving frame; toe, end, states, balances."""
    track, speed = result.track, result.motion.speed
    shifted = {name: values[used] for name, values in data.items()}
    # the fitted straight motion carries the frame: a control volume at a steady speed has an exact account
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
    context = result.context
    along = result.direction * context.gravity[0]
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
        mass=account_of_mass(moving, one, two, speed),
        roller=roller(moving, speed, toe, end),
    )


def _ends(xi, values, level_1, level_2, toe, end) -> tuple[float, float]:
    """Where the mean profile has made 5 % and 95 % of its rise; the given places where it does not cross."""
    rise = level_2 - level_1
    new_toe = crossing(xi, values, level_1 + TOE_SHARE * rise, toe)
    new_end = crossing(xi, values, level_1 + END_SHARE * rise, end)
    new_toe = new_toe if isfinite(new_toe) else toe
    return new_toe, max(new_end if isfinite(new_end) else end, new_toe)


def _heap(edges: np.ndarray, data: dict, chosen: np.ndarray, start: np.ndarray, gravity: float) -> dict:
    """How much of the discs behind the jump stands still, and how steep their surface is."""
    middle = 0.5 * (edges[1:] + edges[:-1])
    depth, discharge = data["mass_depth"][chosen].mean(axis=0), data["discharge"][chosen].mean(axis=0)
    behind = (middle > float(np.mean(start))) & (depth > 0)
    if behind.sum() < 3:
        return {"standing_share": None, "surface_slope": None}
    s, q = depth[behind], discharge[behind]
    standing = np.abs(q / s) < STILL * np.sqrt(gravity * s)
    share = float(s[standing].sum() / s.sum())
    crest = int(np.argmax(s))
    slope = nan
    if len(s) - crest >= 3:
        slope = float(np.polyfit(middle[behind][crest:], s[crest:], 1)[0])
    return {"standing_share": share, "surface_slope": slope}


def _judge(result: JumpResult, edges: np.ndarray, data: dict, used: np.ndarray, gravity: float) -> JumpResult:
    """Jump, locked heap or drowned inlet."""
    track, context = result.track, result.context
    late = np.flatnonzero(used)[-max(1, int(used.sum()) // 5) :]
    heap = _heap(edges, data, used, track.end[used], gravity)
    result = replace(result, heap=heap)
    inflow = context.inflow_depth or 0.0
    distance = float(np.median(track.toe[late])) - edges[0]
    drowned = distance < INLET_REACH * max(inflow, result.bin_width)
    if _locked(heap):
        also = " It has reached the inlet." if drowned else ""
        return replace(
            result,
            verdict="locked heap",
            reason=f"behind the toe {100 * heap['standing_share']:.0f} % of the discs stand still under a surface that "
            f"slopes by {heap['surface_slope']:+.3f}: friction has locked them, this is no hydraulic jump.{also}",
        )
    if drowned:
        return replace(
            result,
            verdict="drowned inlet",
            reason=f"the toe stands {distance:.2f} m from the inlet: the inflow is no longer free.",
        )
    words = "moves upstream" if result.motion.speed < 0 else "moves downstream"
    if abs(result.motion.speed) < 2 * (result.motion.error if isfinite(result.motion.error) else 0.0):
        words = "stands still within the error"
    tail = "" if result.developed else " No level stretch behind its end: the downstream state is a lower bound."
    return replace(result, reason=f"the front {words} at {result.speed:+.2f} m/s.{tail}")


def _locked(heap: dict) -> bool:
    slope = heap["surface_slope"]
    return (heap["standing_share"] or 0.0) > 0.5 and slope is not None and isfinite(slope) and abs(slope) > HEAP_SLOPE


def _none_found(track, in_window, data, edges, gravity, context, common) -> JumpResult:
    """Say why: the commonest reason of the window, and whether the inlet is drowned or the flow locked."""
    reasons = Counter(reason.split(" (")[0] for reason, inside in zip(track.why, in_window, strict=True) if inside)
    reasons.pop("", None)
    counted = ", ".join(f"{reason} ({n} of {int(in_window.sum())} frames)" for reason, n in reasons.most_common(2))
    depth, discharge = data["mass_depth"][in_window].mean(axis=0), data["discharge"][in_window].mean(axis=0)
    first = slice(0, 3)
    start = np.full(int(in_window.sum()), edges[0])
    heap = _heap(edges, data, in_window, start, gravity) if in_window.any() else None
    inflow = context.inflow_depth
    if heap and _locked(heap):
        share, slope = heap["standing_share"], heap["surface_slope"]
        reason = f"{100 * share:.0f} % of the discs stand still under a surface that slopes by {slope:+.3f}; {counted}"
        return JumpResult("locked heap", reason, heap=heap, **common)
    if inflow and depth[first].mean() > 0:
        froude = discharge[first].sum() / depth[first].sum() / sqrt(gravity * depth[first].mean())
        if depth[first].mean() > 1.5 * inflow and froude < 1:
            reason = (
                f"the flow at the inlet is {depth[first].mean():.2f} m deep (inflow {inflow:.2f} m) and subcritical "
                f"(Fr = {froude:.2f}): what jump there was has run over the inlet"
            )
            return JumpResult("drowned inlet", reason, heap=heap, **common)
    return JumpResult("no jump found", counted or "no frame in the window", heap=heap, **common)


def inflow_theory(context: FlowContext) -> dict | None:
    """What hydraulics says of the inflow: Froude number, Bélanger depth, lengths, loss; None without an inflow."""
    depth, speed = context.inflow_depth, context.inflow_speed
    gravity = -context.gravity[1]
    if not depth or not speed or gravity <= 0:
        return None
    froude = theory.froude(abs(speed), depth, gravity)
    y2 = depth * theory.belanger(froude)
    return {
        "depth": depth,
        "velocity": speed,
        "froude": froude,
        "class": theory.jump_class(froude),
        "belanger_y2": y2,
        "length": theory.silvester_jump_length(froude, depth),
        "length_usbr": theory.usbr_jump_length(froude, depth),
        "energy_loss": theory.energy_loss(depth, y2) if y2 > 0 else None,
    }


def _absent() -> dict:
    names = "toe end position y1 y2 h1 h2 u1 u2 froude froude_lab froude_downstream speed speed_error belanger_y2"
    more = "sequent_ratio belanger_ratio density_ratio density_relation_ratio momentum_residual length energy_loss"
    return dict.fromkeys(f"{names} {more}".split())


def summarise_jump(result: JumpResult) -> dict:
    """Numbers for the summary; None where there is none. Keys are explained in docs/analysis.md."""
    context = result.context
    summary = {"verdict": result.verdict, "reason": result.reason, **_absent(), "inflow": inflow_theory(context)}
    summary["window"] = list(result.window)
    if result.track is not None and result.in_window is not None:
        summary["frames_found"] = int((result.track.found & result.in_window).sum())
        summary["frames_in_window"] = int(result.in_window.sum())
    summary["heap"] = result.heap
    if result.upstream is None:
        return summary
    gravity, sign = -context.gravity[1], result.direction
    one, two, track = result.upstream, result.downstream, result.track
    used = np.flatnonzero(track.found & result.in_window)
    s1, s2 = one.mass_depth.value, two.mass_depth.value
    froude = one.froude_relative
    front = float(result.motion.start + result.motion.speed * track.time[used[-1]])
    density_ratio = two.bulk_density / one.bulk_density
    summary |= {
        "time": float(track.time[used[-1]]),
        "position": sign * front,
        "toe": sign * (front + result.toe),
        "end": sign * (front + result.end),
        "speed": result.speed,
        "speed_error": result.motion.error,
        "toe_speed": sign * result.toe_motion.speed,
        "toe_speed_error": result.toe_motion.error,
        "end_speed": sign * result.end_motion.speed,
        "end_speed_error": result.end_motion.error,
        "developed": result.developed,
        "y1": s1,
        "y1_error": one.mass_depth.error,
        "y2": s2,
        "y2_error": two.mass_depth.error,
        "h1": one.surface_depth.value,
        "h2": two.surface_depth.value,
        "u1": sign * one.velocity.value,
        "u2": sign * two.velocity.value,
        "packing_1": one.packing.value,
        "packing_2": two.packing.value,
        "beta_1": one.beta(result.motion.speed),
        "beta_2": two.beta(result.motion.speed),
        "froude": froude,
        "froude_lab": one.froude,
        "froude_downstream": two.froude_relative,
        "class": theory.jump_class(froude),
        "sequent_ratio": s2 / s1,
        "sequent_ratio_error": s2 / s1 * sqrt((one.mass_depth.error / s1) ** 2 + (two.mass_depth.error / s2) ** 2),
        "belanger_ratio": theory.belanger(froude),
        "belanger_y2": s1 * theory.belanger(froude),
        "density_ratio": density_ratio,
    }
    summary |= _relations(result, gravity)
    summary["belanger_deviation"] = summary["sequent_ratio"] / summary["belanger_ratio"] - 1
    summary |= _lengths(result, froude, s1, s2)
    summary |= _energy(result, gravity)
    terms = result.balance
    summary |= {
        "momentum_upstream": context.density * terms.upstream,
        "momentum_downstream": context.density * terms.downstream,
        "momentum_residual": terms.classical / terms.downstream,
        "momentum_terms": {
            name: getattr(terms, name) / terms.downstream
            for name in ("profile", "packing", "pressure", "bed", "slope", "unsteady", "unexplained")
        },
        "mass": result.mass,
        "roller": result.roller,
    }
    summary["momentum_terms"]["pressure_error"] = terms.pressure_error / terms.downstream
    return summary


def _relations(result: JumpResult, gravity: float) -> dict:
    """Sequent ratios by momentum, one measured ingredient after the other.

    `density_relation_ratio`: the change of density (PHYSICS 2.2c); `full_relation_ratio`: bed force and slope, and the
    momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure, and what the
    control volume stores.
    """
    one, two, terms = result.upstream, result.downstream, result.balance
    froude, s1, s2 = one.froude_relative, one.mass_depth.value, two.mass_depth.value
    beta_1, beta_2 = one.beta(result.motion.speed), two.beta(result.motion.speed)
    density_ratio = two.bulk_density / one.bulk_density
    # K (1 + S) = -2 F / (g s1^2) with F the force of bed and slope along the stream
    resistance = -2.0 * (terms.bed + terms.slope) / (gravity * s1**2) / (1.0 + s2 / s1)
    values: dict[str, float | None] = {}
    for name, arguments in (
        ("density_relation_ratio", (froude, density_ratio)),
        ("full_relation_ratio", (froude, density_ratio, resistance, beta_1, beta_2)),
    ):
        try:
            values[name] = theory.sequent_ratio(*arguments)
        except ValueError:
            values[name] = None
    values["pressure_relation_ratio"] = None
    if isfinite(terms.pressure):
        thrust = [2.0 * state.thrust.value / (gravity * state.mass_depth.value**2) for state in (one, two)]
        other = 2.0 * (terms.bed + terms.slope + terms.unsteady) / (gravity * s1**2)
        values["pressure_relation_ratio"] = _largest_ratio(froude, beta_1, beta_2, *thrust, other)
        values["pressure_coefficient_1"] = thrust[0] * s1 / one.surface_depth.value
        values["pressure_coefficient_2"] = thrust[1] * s2 / two.surface_depth.value
    expected = values["density_relation_ratio"]
    values["density_relation_deviation"] = s2 / s1 / expected - 1 if expected else None
    return values


def _largest_ratio(froude, beta_1, beta_2, thrust_1, thrust_2, other) -> float | None:
    """Largest root S of 2 Fr^2 (beta_1 - beta_2/S) + p1 - p2 S^2 + other = 0; p thrust over g s^2/2."""
    roots = np.roots([-thrust_2, 0.0, 2 * froude**2 * beta_1 + thrust_1 + other, -2 * froude**2 * beta_2])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(real.max()) if real.size and real.max() > 0 else None


def _lengths(result: JumpResult, froude: float, s1: float, s2: float) -> dict:
    track = result.track
    used = track.found & result.in_window
    length = result.surface_end - result.surface_toe
    return {
        "length": length,
        "length_mass": result.end - result.toe,
        "length_ramp": float(np.median(track.end[used] - track.toe[used])),
        "length_over_y2": length / s2,
        "length_theory": theory.silvester_jump_length(froude, s1),
        "length_usbr": theory.usbr_jump_length(froude, s1),
    }


def _energy(result: JumpResult, gravity: float) -> dict:
    """Head up- and downstream in the front's frame, s + (u - c)^2/(2 g), and what is lost, m."""
    one, two, c = result.upstream, result.downstream, result.motion.speed
    s1, s2 = one.mass_depth.value, two.mass_depth.value
    head_1 = theory.specific_energy(s1, one.velocity.value - c, gravity)
    head_2 = theory.specific_energy(s2, two.velocity.value - c, gravity)
    return {
        "head_upstream": head_1,
        "head_downstream": head_2,
        "energy_loss": head_1 - head_2,
        "energy_loss_theory": theory.energy_loss(s1, s1 * theory.belanger(one.froude_relative)),
        "energy_loss_depths": theory.energy_loss(s1, s2),
    }
