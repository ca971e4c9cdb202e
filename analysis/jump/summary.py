"""The numbers of a jump for the summary, with what theory says beside them; keys are explained in docs/analysis.md."""

from __future__ import annotations

from math import isfinite, sqrt

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.physics import jump as theory

from .result import JumpResult

DEVELOPED_SHARE = 0.7
"""A front whose depth ratio stays below this share of Bélanger's is still on its way to be a jump."""


def inflow_theory(flow: Flow) -> dict | None:
    """What hydraulics says of the inflow: Froude number, Bélanger depth, lengths, loss; None without an inflow."""
    depth, speed = flow.inflow_depth, flow.inflow_speed
    gravity = -flow.scene.gravity[1]
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
    flow = result.flow
    summary = {"verdict": result.verdict, "reason": result.reason, **_absent(), "inflow": inflow_theory(flow)}
    summary["window"] = list(result.window)
    if result.track is not None and result.in_window is not None:
        summary["frames_found"] = int((result.track.found & result.in_window).sum())
        summary["frames_in_window"] = int(result.in_window.sum())
    summary["heap"] = result.heap
    if result.upstream is None:
        return summary
    gravity, sign = -flow.scene.gravity[1], result.direction
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
    if summary["verdict"] == "jump" and summary["sequent_ratio"] < DEVELOPED_SHARE * summary["belanger_ratio"]:
        share = 100 * summary["sequent_ratio"] / summary["belanger_ratio"]
        summary["verdict"] = "jump not developed"
        summary["reason"] += f" The depth ratio is {share:.0f} % of Bélanger's: the flow behind is still filling up."
    summary |= _lengths(result, froude, s1, s2)
    summary |= _energy(result, gravity)
    terms = result.balance
    summary |= {
        "momentum_upstream": flow.scene.density * terms.upstream,
        "momentum_downstream": flow.scene.density * terms.downstream,
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

    `density_relation_ratio`: the change of density (`physics.jump.sequent_ratio`); `full_relation_ratio`: bed force and
    slope, and the momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure,
    and what the control volume stores.
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
