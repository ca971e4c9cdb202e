# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump, with what theory says beside them; docs/analysis.md explains them."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, nan

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.statistics import Mean
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

from .certainty import LOWER_BOUNDS, Drift, Members, drift, errors, members
from .frame import Balance, Mass, Roller, share
from .head import Budget
from .result import Heap, JumpResult
from .stream import Stream
from .tail import Tail, against_inflow

DEVELOPED_SHARE = 0.7
"""A front whose depth ratio stays below this share of Bélanger's is still on its way to be a jump."""

SHARED = ("verdict", "reason", "window", "heap", "developed", "roller", "tail", "stream", "mass")
"""Fields of a `JumpResult` that stand in a `Jump` too."""


@dataclass(frozen=True)
class Jump(Estimates):
    """Hydraulic jump in numbers; 1 is upstream, 2 downstream; NaN where it was not measured.

    ``_error`` is the standard error within this run in the same unit, NaN where one run cannot tell. Depths s are by
    mass, h by the free surface. The front is where a sharp step would hold the same mass.
    """

    verdict: str
    reason: str
    headline: str = ""
    notes: tuple[str, ...] = field(default=(), metadata={"summary": False})
    inflow: theory.Inflow | None = None
    window: tuple[float, float] = (nan, nan)
    frames_found: int | None = None
    frames_in_window: int | None = None
    share_found: float = number("", "share of the window's frames that have a jump", default=nan)
    heap: Heap | None = None
    time: float = number("s", "time of the last frame used", default=nan)
    position: float = number("m", "front at that time", default=nan)
    toe: float = number("m", "toe at that time", default=nan)
    end: float = number("m", "end at that time", default=nan)
    froude: float = estimate("", "Froude number, front's frame", label="Fr1")
    froude_lab: float = estimate("", "Froude number of the stream, laboratory frame")
    froude_downstream: float = estimate("", "Froude number downstream, front's frame")
    y1: float = estimate("m", "mass depth s upstream", label="y1")
    y2: float = estimate("m", "mass depth s downstream", label="y2")
    belanger_y2: float = estimate("m", "sequent depth by Bélanger, front's frame", label="Bélanger")
    speed: float = estimate("m/s", "velocity of the front", label="shock speed")
    length: float = estimate("m", "length of the jump", label="length")
    h1: float = estimate("m", "surface depth h upstream")
    h2: float = estimate("m", "surface depth h downstream")
    u1: float = estimate("m/s", "mean velocity u upstream")
    u2: float = estimate("m/s", "mean velocity u downstream")
    packing_1: float = estimate("", "packing upstream")
    packing_2: float = estimate("", "packing downstream")
    beta_1: float = estimate("", "momentum coefficient β upstream")
    beta_2: float = estimate("", "momentum coefficient β downstream")
    toe_speed: float = estimate("m/s", "velocity of the toe")
    end_speed: float = estimate("m/s", "velocity of the end")
    developed: bool | None = None
    jump_class: str | None = field(default=None, metadata={"key": "class"})
    sequent_ratio: float = estimate("", "sequent-depth ratio s₂/s₁")
    belanger_ratio: float = estimate("", "Bélanger, front's frame")
    belanger_deviation: float = estimate("", "s₂/s₁ over Bélanger's ratio, less one")
    density_ratio: float = estimate("", "bulk density downstream over upstream")
    density_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the density ratio")
    density_relation_deviation: float = estimate("", "s₂/s₁ over that ratio, less one")
    full_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with density, bed force and β")
    pressure_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the contact pressure")
    pressure_coefficient_1: float = estimate("", "contact pressure over hydrostatic, upstream")
    pressure_coefficient_2: float = estimate("", "contact pressure over hydrostatic, downstream")
    length_mass: float = estimate("m", "length by the mass depth")
    length_ramp: float = estimate("m", "length by the fitted ramps")
    length_over_y2: float = estimate("", "length over y2")
    length_theory: float = estimate("m", "length by thesis (4.27)")
    length_usbr: float = estimate("m", "length by the USBR curve")
    head_upstream: float = estimate("m", "head, front's frame, upstream")
    head_downstream: float = estimate("m", "head, front's frame, downstream")
    head_lost: float = estimate("m", "head lost, energy budget", label="head lost")
    budget: Budget | None = None
    energy_loss: float = estimate("m", "difference of s + (u − c)²/2g")
    energy_loss_theory: float = estimate("m", "head lost by Bélanger")
    energy_loss_depths: float = number("m", "head lost by the two depths", default=nan)
    momentum_upstream: float = estimate("N/m", "momentum function upstream")
    momentum_downstream: float = estimate("N/m", "momentum function downstream")
    momentum_residual: float = estimate("", "momentum function 1 − 2 over 2")
    momentum_terms: Balance | None = None
    mass: Mass | None = None
    roller: Roller | None = None
    tail: Tail | None = None
    stream: Stream | None = None
    drift: Drift | None = None
    members: Members | None = None
    lower_bounds: tuple[str, ...] = LOWER_BOUNDS
    measured: JumpResult | None = field(default=None, metadata={"summary": False})


def inflow_theory(flow: Flow) -> theory.Inflow | None:
    """What hydraulics says of the inflow: Froude number, Bélanger depth, lengths, loss; None without an inflow."""
    if not flow.inflow_depth or not flow.inflow_speed or flow.gravity <= 0:
        return None
    return theory.inflow_theory(flow.inflow_depth, flow.inflow_speed, flow.gravity)


def summarise_jump(result: JumpResult, delivered: tuple[Mean, Mean] | None = None) -> Jump:
    """Numbers of a measured jump.

    Parameters
    ----------
    result : JumpResult
    delivered : (Mean, Mean), optional
        Depth (m) and mean velocity (m/s) behind the inlet, which the tail water is held against; by default those that
        were asked for.
    """
    shared = {name: getattr(result, name) for name in SHARED}
    jump = Jump(inflow=inflow_theory(result.flow), momentum_terms=result.balance, measured=result, **shared)
    if result.track is None:
        return jump
    found, frames = int(result.used.sum()), int(result.in_window.sum())
    jump = replace(jump, frames_found=found, frames_in_window=frames, share_found=found / frames if frames else nan)
    if result.upstream is None:
        return jump
    pieces = [_numbers(piece) for piece in result.pieces]
    jump = replace(jump, **_numbers(result), **errors(jump, pieces), drift=drift(pieces))
    jump = replace(jump, members=members(jump))
    if jump.inflow is not None:
        stream = delivered or (Mean(jump.inflow.depth, 0.0), Mean(jump.inflow.velocity, 0.0))
        front = Mean(result.direction * result.motion.speed, jump.speed_error)
        jump = replace(jump, tail=against_inflow(result.tail, stream, front, result.flow.gravity))
    if jump.verdict == "jump" and jump.sequent_ratio < DEVELOPED_SHARE * jump.belanger_ratio:
        share = 100 * jump.sequent_ratio / jump.belanger_ratio
        also = f" The depth ratio is {share:.0f} % of Bélanger's: the flow behind is still filling up."
        jump = replace(jump, verdict="jump not developed", reason=jump.reason + also)
    return jump


def _numbers(result: JumpResult) -> dict[str, object]:
    """Numbers of a `Jump`, by their keys, of what was measured in a window or in a piece of it."""
    found = _places(result) | _states(result)
    found["length_over_y2"] = found["length"] / found["y2"]
    return found | (_against_theory(result, found) if result.flow.timed else {})


def _places(result: JumpResult) -> dict[str, float]:
    """Places along x at the last frame used, velocities, and lengths."""
    track, motion = result.track, result.motion
    used = result.used
    time = float(track.time[used][-1])
    front = float(motion.start + motion.speed * time)
    return {
        "time": time,
        "position": front,
        "toe": front + result.direction * result.toe,
        "end": front + result.direction * result.end,
        "speed": motion.speed,
        "toe_speed": result.toe_speed,
        "end_speed": result.end_speed,
        "length": result.surface_end - result.surface_toe,
        "length_mass": result.end - result.toe,
        "length_ramp": result.direction * float(np.median(track.end[used] - track.toe[used])),
    }


def _states(result: JumpResult) -> dict[str, float]:
    """Depths, velocities, packing, Froude numbers, momentum and head on both sides."""
    one, two, density, found = result.upstream, result.downstream, result.flow.scene.density, {}
    for k, state in ((1, one), (2, two)):
        found |= {f"y{k}": state.mass_depth, f"h{k}": state.surface_depth}
        found |= {f"u{k}": result.direction * state.velocity}
        found |= {f"packing_{k}": state.packing, f"beta_{k}": state.beta}
    return found | {
        "froude": one.froude_relative,
        "froude_lab": one.froude,
        "froude_downstream": two.froude_relative,
        "sequent_ratio": found["y2"] / found["y1"],
        "density_ratio": share(two.bulk_density, one.bulk_density),
        "head_upstream": one.head,
        "head_downstream": two.head,
        "energy_loss": one.head - two.head,
        "momentum_upstream": density * result.balance.upstream,
        "momentum_downstream": density * result.balance.downstream,
        "momentum_residual": result.balance.classical,
    }


def _against_theory(result: JumpResult, found: Mapping[str, float]) -> dict[str, object]:
    """Sequent ratio, length and loss beside theory, which takes in one measured ingredient after the other.

    `density_relation_ratio`: the change of density (`theory.sequent_ratio`); `full_relation_ratio`: bed force and
    slope, and the momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure,
    and what the control volume stores.
    """
    one, two, terms = result.upstream, result.downstream, result.balance
    froude, s1, s2, ratio, density = (found[key] for key in ("froude", "y1", "y2", "sequent_ratio", "density_ratio"))
    betas, belanger = (found["beta_1"], found["beta_2"]), theory.belanger(froude)
    # forces over g s1^2/2, the unit of the relations
    unit = one.still(one.mass_depth) / terms.downstream
    push = (terms.bed + terms.slope) / unit
    expected = _sequent_ratio(froude, density)
    against: dict[str, object] = {
        "jump_class": theory.jump_class(froude),
        "belanger_ratio": belanger,
        "belanger_y2": s1 * belanger,
        "belanger_deviation": share(ratio, belanger) - 1,
        "density_relation_ratio": expected,
        "density_relation_deviation": ratio / expected - 1,
        "full_relation_ratio": _sequent_ratio(froude, density, -push / (1.0 + ratio), *betas),
        "length_theory": theory.silvester_jump_length(froude, s1),
        "length_usbr": theory.usbr_jump_length(froude, s1),
        "energy_loss_theory": theory.energy_loss(s1, s1 * belanger),
        "energy_loss_depths": theory.energy_loss(s1, s2),
    }
    if isfinite(terms.pressure):
        thrusts = (state.thrust / state.still(state.mass_depth) for state in (one, two))
        largest = _largest_ratio(froude, *betas, *thrusts, push + terms.unsteady / unit)
        against["pressure_relation_ratio"] = largest
        for k, state in ((1, one), (2, two)):
            against[f"pressure_coefficient_{k}"] = share(state.thrust, state.still(state.surface_depth))
    return against


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
