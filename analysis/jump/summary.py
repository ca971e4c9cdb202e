# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump, with what theory says beside them; docs/analysis.md explains them."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import isfinite, nan, sqrt

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.physics import jump as theory
from lammps_jump.units import number

from .frame import Balance, Mass, Roller
from .result import Heap, JumpResult
from .tail import Tail, against_inflow

DEVELOPED_SHARE = 0.7
"""A front whose depth ratio stays below this share of Bélanger's is still on its way to be a jump."""


@dataclass(frozen=True)
class MomentumTerms:
    """Terms of the momentum balance over the downstream momentum function."""

    profile: float = number("", "uneven velocities and their fluctuations")
    packing: float = number("", "surface depth in place of mass depth")
    pressure: float = number("", "contact pressure beyond hydrostatic")
    bed: float = number("", "force of the bed")
    slope: float = number("", "gravity along the bed")
    unsteady: float = number("", "momentum stored between the stations")
    unexplained: float = number("", "left unexplained")
    pressure_error: float = number("", "standard error of the pressure's part")


@dataclass(frozen=True)
class Jump:
    """Hydraulic jump in numbers; 1 is upstream, 2 downstream; NaN where it was not measured.

    ``_error`` is the standard error of the mean in the same unit, NaN where one run cannot tell. Depths s are by mass,
    h by the free surface. The front is where a sharp step would hold the same mass.
    """

    verdict: str
    reason: str
    inflow: theory.Inflow | None = None
    window: tuple[float, float] = (nan, nan)
    frames_found: int | None = None
    frames_in_window: int | None = None
    heap: Heap | None = None
    time: float = number("s", "time of the last frame used", default=nan)
    position: float = number("m", "front at that time", default=nan)
    toe: float = number("m", "toe at that time", default=nan)
    end: float = number("m", "end at that time", default=nan)
    froude: float = number("", "Froude number, front's frame", default=nan, label="Fr1")
    froude_error: float = number("", "standard error of the Froude number", default=nan)
    froude_lab: float = number("", "Froude number of the stream, laboratory frame", default=nan)
    froude_downstream: float = number("", "Froude number downstream, front's frame", default=nan)
    y1: float = number("m", "mass depth s upstream", default=nan, label="y1")
    y1_error: float = number("m", "standard error of y1", default=nan)
    y2: float = number("m", "mass depth s downstream", default=nan, label="y2")
    y2_error: float = number("m", "standard error of y2", default=nan)
    belanger_y2: float = number("m", "sequent depth by Bélanger, front's frame", default=nan, label="Bélanger")
    speed: float = number("m/s", "velocity of the front", default=nan, label="shock speed")
    speed_error: float = number("m/s", "standard error of the velocity of the front", default=nan)
    length: float = number("m", "length of the jump", default=nan, label="length")
    length_error: float = number("m", "standard error of the length", default=nan)
    h1: float = number("m", "surface depth h upstream", default=nan)
    h1_error: float = number("m", "standard error of h1", default=nan)
    h2: float = number("m", "surface depth h downstream", default=nan)
    h2_error: float = number("m", "standard error of h2", default=nan)
    u1: float = number("m/s", "mean velocity u upstream", default=nan)
    u1_error: float = number("m/s", "standard error of u1", default=nan)
    u2: float = number("m/s", "mean velocity u downstream", default=nan)
    u2_error: float = number("m/s", "standard error of u2", default=nan)
    packing_1: float = number("", "packing upstream", default=nan)
    packing_2: float = number("", "packing downstream", default=nan)
    beta_1: float = number("", "momentum coefficient β upstream", default=nan)
    beta_2: float = number("", "momentum coefficient β downstream", default=nan)
    toe_speed: float = number("m/s", "velocity of the toe", default=nan)
    toe_speed_error: float = number("m/s", "standard error of the velocity of the toe", default=nan)
    end_speed: float = number("m/s", "velocity of the end", default=nan)
    end_speed_error: float = number("m/s", "standard error of the velocity of the end", default=nan)
    developed: bool | None = None
    jump_class: str | None = field(default=None, metadata={"key": "class"})
    sequent_ratio: float = number("", "sequent-depth ratio s₂/s₁", default=nan)
    sequent_ratio_error: float = number("", "standard error of s₂/s₁", default=nan)
    belanger_ratio: float = number("", "Bélanger, front's frame", default=nan)
    belanger_ratio_error: float = number("", "standard error of Bélanger's ratio", default=nan)
    belanger_deviation: float = number("", "s₂/s₁ over Bélanger's ratio, less one", default=nan)
    density_ratio: float = number("", "bulk density downstream over upstream", default=nan)
    density_relation_ratio: float = number("", "s₂/s₁ by momentum, with the density ratio", default=nan)
    density_relation_deviation: float = number("", "s₂/s₁ over that ratio, less one", default=nan)
    full_relation_ratio: float = number("", "s₂/s₁ by momentum, with density, bed force and β", default=nan)
    pressure_relation_ratio: float = number("", "s₂/s₁ by momentum, with the contact pressure", default=nan)
    pressure_coefficient_1: float = number("", "contact pressure over hydrostatic, upstream", default=nan)
    pressure_coefficient_2: float = number("", "contact pressure over hydrostatic, downstream", default=nan)
    length_mass: float = number("m", "length by the mass depth", default=nan)
    length_ramp: float = number("m", "length by the fitted ramps", default=nan)
    length_over_y2: float = number("", "length over y2", default=nan)
    length_theory: float = number("m", "length by thesis (4.27)", default=nan)
    length_usbr: float = number("m", "length by the USBR curve", default=nan)
    head_upstream: float = number("m", "head, front's frame, upstream", default=nan)
    head_downstream: float = number("m", "head, front's frame, downstream", default=nan)
    energy_loss: float = number("m", "head lost", default=nan)
    energy_loss_error: float = number("m", "standard error of the head lost", default=nan)
    energy_loss_theory: float = number("m", "head lost by Bélanger", default=nan)
    energy_loss_depths: float = number("m", "head lost by the two depths", default=nan)
    momentum_upstream: float = number("N/m", "momentum function upstream", default=nan)
    momentum_downstream: float = number("N/m", "momentum function downstream", default=nan)
    momentum_residual: float = number("", "momentum function 1 − 2 over 2", default=nan)
    momentum_terms: MomentumTerms | None = None
    mass: Mass | None = None
    roller: Roller | None = None
    tail: Tail | None = None
    measured: JumpResult | None = field(default=None, metadata={"summary": False})


def inflow_theory(flow: Flow) -> theory.Inflow | None:
    """What hydraulics says of the inflow: Froude number, Bélanger depth, lengths, loss; None without an inflow."""
    depth, speed = flow.inflow_depth, flow.inflow_speed
    gravity = -flow.scene.gravity[1]
    if not depth or not speed or gravity <= 0:
        return None
    return theory.inflow_theory(depth, speed, gravity)


def summarise_jump(result: JumpResult) -> Jump:
    """Numbers of a measured jump."""
    jump = Jump(result.verdict, result.reason, inflow_theory(result.flow), result.window, heap=result.heap,
                measured=result)  # fmt: skip
    if result.track is not None:
        found = result.track.found & result.in_window
        jump = replace(jump, frames_found=int(found.sum()), frames_in_window=int(result.in_window.sum()))
    if result.upstream is None:
        return jump
    one, two = result.upstream, result.downstream
    froude, ratio = one.froude_relative, two.mass_depth.value / one.mass_depth.value
    belanger = theory.belanger(froude)
    if jump.verdict == "jump" and ratio < DEVELOPED_SHARE * belanger:
        also = f" The depth ratio is {100 * ratio / belanger:.0f} % of Bélanger's: the flow behind is still filling up."
        jump = replace(jump, verdict="jump not developed", reason=jump.reason + also)
    return replace(
        jump,
        **_motion(result),
        **_states(result),
        **_relations(result, ratio),
        **_lengths(result),
        **_heads(result),
        **_momentum(result),
        developed=result.developed,
        froude=froude,
        froude_lab=one.froude,
        froude_downstream=two.froude_relative,
        jump_class=theory.jump_class(froude),
        sequent_ratio=ratio,
        sequent_ratio_error=ratio * sqrt(sum((x.error / x.value) ** 2 for x in (one.mass_depth, two.mass_depth))),
        belanger_ratio=belanger,
        belanger_y2=one.mass_depth.value * belanger,
        belanger_deviation=ratio / belanger - 1,
        mass=result.mass,
        roller=result.roller,
        tail=_tail(result, jump.inflow),
    )


def _tail(result: JumpResult, inflow: theory.Inflow | None) -> Tail:
    """Tail water, held against the inflow where there is one."""
    if inflow is None:
        return result.tail
    found = against_inflow(result.tail.depth, inflow, result.motion.speed, -result.flow.scene.gravity[1])
    return replace(result.tail, belanger_y2=found[0], belanger_deviation=found[1])


def _motion(result: JumpResult) -> dict[str, float]:
    """Places at the last frame used, and velocities, along x."""
    sign, motion = result.direction, result.motion
    time = float(result.track.time[np.flatnonzero(result.track.found & result.in_window)[-1]])
    front = float(motion.start + motion.speed * time)
    return {
        "time": time,
        "position": sign * front,
        "toe": sign * (front + result.toe),
        "end": sign * (front + result.end),
        "speed": result.speed,
        "speed_error": motion.error,
        "toe_speed": sign * result.toe_motion.speed,
        "toe_speed_error": result.toe_motion.error,
        "end_speed": sign * result.end_motion.speed,
        "end_speed_error": result.end_motion.error,
    }


def _states(result: JumpResult) -> dict[str, float]:
    """Depths, velocities, packing and momentum coefficients on both sides."""
    found = {}
    for k, state in ((1, result.upstream), (2, result.downstream)):
        found |= {f"y{k}": state.mass_depth.value, f"y{k}_error": state.mass_depth.error}
        found |= {f"h{k}": state.surface_depth.value, f"h{k}_error": state.surface_depth.error}
        found |= {f"u{k}": result.direction * state.velocity.value, f"u{k}_error": state.velocity.error}
        found |= {f"packing_{k}": state.packing.value, f"beta_{k}": state.beta(result.motion.speed)}
    return found


def _relations(result: JumpResult, ratio: float) -> dict[str, float]:
    """Sequent ratios by momentum, one measured ingredient after the other.

    `density_relation_ratio`: the change of density (`theory.sequent_ratio`); `full_relation_ratio`: bed force and
    slope, and the momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure,
    and what the control volume stores.
    """
    one, two, terms, gravity = result.upstream, result.downstream, result.balance, -result.flow.scene.gravity[1]
    froude, s1 = one.froude_relative, one.mass_depth.value
    beta_1, beta_2 = one.beta(result.motion.speed), two.beta(result.motion.speed)
    density_ratio = two.bulk_density / one.bulk_density
    # K (1 + S) = -2 F / (g s1^2) with F the force of bed and slope along the stream
    resistance = -2.0 * (terms.bed + terms.slope) / (gravity * s1**2) / (1.0 + ratio)
    expected = _sequent_ratio(froude, density_ratio)
    values = {
        "density_ratio": density_ratio,
        "density_relation_ratio": expected,
        "density_relation_deviation": ratio / expected - 1,
        "full_relation_ratio": _sequent_ratio(froude, density_ratio, resistance, beta_1, beta_2),
    }
    if isfinite(terms.pressure):
        thrust = [2.0 * state.thrust.value / (gravity * state.mass_depth.value**2) for state in (one, two)]
        other = 2.0 * (terms.bed + terms.slope + terms.unsteady) / (gravity * s1**2)
        values["pressure_relation_ratio"] = _largest_ratio(froude, beta_1, beta_2, *thrust, other)
        values["pressure_coefficient_1"] = thrust[0] * s1 / one.surface_depth.value
        values["pressure_coefficient_2"] = thrust[1] * two.mass_depth.value / two.surface_depth.value
    return values


def _sequent_ratio(*arguments: float) -> float:
    """`theory.sequent_ratio`, NaN where it has no solution."""
    try:
        return theory.sequent_ratio(*arguments)
    except ValueError:
        return nan


def _largest_ratio(froude, beta_1, beta_2, thrust_1, thrust_2, other) -> float:
    """Largest root S of 2 Fr^2 (beta_1 - beta_2/S) + p1 - p2 S^2 + other = 0; p thrust over g s^2/2; NaN for none."""
    roots = np.roots([-thrust_2, 0.0, 2 * froude**2 * beta_1 + thrust_1 + other, -2 * froude**2 * beta_2])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(real.max()) if real.size and real.max() > 0 else nan


def _lengths(result: JumpResult) -> dict[str, float]:
    track, one, two = result.track, result.upstream, result.downstream
    used = track.found & result.in_window
    length = result.surface_end - result.surface_toe
    return {
        "length": length,
        "length_mass": result.end - result.toe,
        "length_ramp": float(np.median(track.end[used] - track.toe[used])),
        "length_over_y2": length / two.mass_depth.value,
        "length_theory": theory.silvester_jump_length(one.froude_relative, one.mass_depth.value),
        "length_usbr": theory.usbr_jump_length(one.froude_relative, one.mass_depth.value),
    }


def _heads(result: JumpResult) -> dict[str, float]:
    """Head up- and downstream in the front's frame, s + (u - c)^2/(2 g), and what is lost, m."""
    one, two, c, gravity = result.upstream, result.downstream, result.motion.speed, -result.flow.scene.gravity[1]
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


def _momentum(result: JumpResult) -> dict[str, float | MomentumTerms]:
    terms: Balance = result.balance
    shares = {name: getattr(terms, name) / terms.downstream for name in MomentumTerms.__dataclass_fields__}
    return {
        "momentum_upstream": result.flow.scene.density * terms.upstream,
        "momentum_downstream": result.flow.scene.density * terms.downstream,
        "momentum_residual": terms.classical / terms.downstream,
        "momentum_terms": MomentumTerms(**shares),
    }
