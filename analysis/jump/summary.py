# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump, with what theory says beside them; docs/measuring.md explains them."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, nan, sqrt

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.statistics import Mean, as_fields, known_mean, propagated
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

from .certainty import LOCAL_BOUNDS, LOWER_BOUNDS, Drift, Members, drift, errors, members
from .frame import Balance, Mass, Roller, measure_state, share
from .head import Budget
from .result import JumpResult, StandingHeap
from .stream import Stream
from .tail import Tail, against, froude

DEVELOPED_SHARE = 0.7
"""A front whose depth stays below this share of Bélanger's is still on its way to be a jump."""
DELIVERED, ASKED, BEFORE = "delivered inflow", "inflow asked for", "stream before the toe"
"""Streams that the depth behind a jump is held against."""
FRICTION, SLOPE = "friction", "slope"
"""What Bélanger's relation leaves out."""
TAIL, BEHIND = "tail water", "depth behind the end"
"""What is held against them."""

SHARED = ("verdict", "reason", "window", "heap", "developed", "roller", "tail", "stream", "mass")
"""Fields of a `JumpResult` that stand in a `Jump` too."""


@dataclass(frozen=True)
class Local(Estimates):
    """The flow beside the jump and theory for it, frame of the front; 1 is before the toe, 2 behind the end.

    Depths s are by mass, h by the free surface. The comparison of a `Jump` is another one: with the delivered inflow.
    """

    froude: float = estimate("", "Froude number before the toe, front's frame")
    froude_lab: float = estimate("", "Froude number before the toe, laboratory")
    froude_downstream: float = estimate("", "Froude number behind the end, front's frame")
    y1: float = estimate("m", "mass depth s before the toe")
    y2: float = estimate("m", "mass depth s behind the end")
    h1: float = estimate("m", "surface depth h before the toe")
    h2: float = estimate("m", "surface depth h behind the end")
    u1: float = estimate("m/s", "mean velocity u before the toe")
    u2: float = estimate("m/s", "mean velocity u behind the end")
    packing_1: float = estimate("", "packing before the toe")
    packing_2: float = estimate("", "packing behind the end")
    beta_1: float = estimate("", "momentum coefficient β before the toe")
    beta_2: float = estimate("", "momentum coefficient β behind the end")
    sequent_ratio: float = estimate("", "s₂/s₁ beside the jump")
    pressure_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the measured thrust")
    pressure_relation_deviation: float = estimate("", "s₂/s₁ over that ratio, less one")
    belanger_ratio: float = estimate("", "s₂/s₁ by Bélanger")
    belanger_y2: float = estimate("m", "sequent depth by Bélanger of the state before the toe")
    belanger_deviation: float = estimate("", "s₂/s₁ over Bélanger's ratio, less one")
    density_ratio: float = estimate("", "bulk density downstream over upstream")
    density_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the density ratio")
    density_relation_deviation: float = estimate("", "s₂/s₁ over that ratio, less one")
    sloping_ratio: float = estimate("", "s₂/s₁ by Bélanger with the weight of the jump along the bed")
    full_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with density, bed force, slope and β")
    pressure_coefficient_1: float = estimate("", "contact pressure over hydrostatic, before the toe")
    pressure_coefficient_2: float = estimate("", "contact pressure over hydrostatic, behind the end")
    head_upstream: float = estimate("m", "head s + (u − c)²/2g before the toe")
    head_downstream: float = estimate("m", "head s + (u − c)²/2g behind the end")
    energy_loss: float = estimate("m", "difference of s + (u − c)²/2g")
    energy_loss_theory: float = estimate("m", "head lost by Bélanger, of the state before the toe")
    energy_loss_depths: float = number("m", "head lost by the two depths", default=nan)
    momentum_upstream: float = estimate("N/m", "momentum function before the toe")
    momentum_downstream: float = estimate("N/m", "momentum function behind the end")
    momentum_residual: float = estimate("", "momentum function 1 − 2 over 2")
    moved_y1: float = number("m", "change of y1 where its stretch lies one depth further upstream", default=nan)
    moved_froude: float = number("", "change of the Froude number, the same", default=nan)
    moved_belanger_y2: float = number("m", "change of Bélanger's depth, the same", default=nan)
    moved_y2: float = number("m", "change of y2 where its stretch lies as far further down", default=nan)
    lower_bounds: tuple[str, ...] = LOCAL_BOUNDS


@dataclass(frozen=True)
class Jump(Estimates):
    """Hydraulic jump in numbers; NaN where it was not measured.

    `y1`, `froude`, `y2`, `belanger_y2` and `belanger_deviation` are the one comparison with theory: the depth `at`
    against Bélanger's for the stream `of`, in the frame of the front; `left_out` of the relation. ``_error`` is the
    standard error within this run in the same unit, NaN where one run cannot tell. The front is where a sharp step
    would hold the same mass.
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
    heap: StandingHeap | None = None
    filling: bool | None = None
    time: float = number("s", "time of the last frame used", default=nan)
    position: float = number("m", "front at that time", default=nan)
    toe: float = number("m", "toe at that time", default=nan)
    end: float = number("m", "end at that time", default=nan)
    of: str = ""
    at: str = ""
    left_out: tuple[str, ...] = ()
    froude: float = estimate("", "Froude number, front's frame", label="Fr1")
    y1: float = estimate("m", "mass depth of the stream", label="y1")
    y2: float = estimate("m", "sequent depth, by mass", label="y2")
    belanger_y2: float = estimate("m", "sequent depth by Bélanger, front's frame", label="Bélanger")
    belanger_deviation: float = estimate("", "sequent depth over Bélanger's, less one", label="deviation")
    bed_slope: float = number("", "fall of the bed along the stream, per length along the level", default=nan)
    sloping_y2: float = estimate("m", "sequent depth by Bélanger with the weight of the jump along the bed")
    sloping_deviation: float = estimate("", "sequent depth over that, less one")
    speed: float = estimate("m/s", "velocity of the front", label="shock speed")
    length: float = estimate("m", "length of the jump", label="length")
    toe_speed: float = estimate("m/s", "velocity of the toe")
    end_speed: float = estimate("m/s", "velocity of the end")
    developed: bool | None = None
    jump_class: str | None = field(default=None, metadata={"key": "class"})
    length_mass: float = estimate("m", "length by the mass depth")
    length_ramp: float = estimate("m", "length by the fitted ramps")
    length_over_y2: float = estimate("", "length over y2")
    length_theory: float = estimate("m", "length by thesis (4.27)")
    length_usbr: float = estimate("m", "length by the USBR curve")
    head_lost: float = estimate("m", "head lost, energy budget", label="head lost")
    head_lost_theory: float = estimate("m", "head lost by Bélanger")
    budget: Budget | None = None
    local: Local | None = None
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
    pieces = [_places(piece) for piece in result.pieces]
    beside = [_local(piece) for piece in result.pieces]
    local = Local(**_local(result), **_moved(result))
    local = replace(local, **errors(local, beside))
    jump = replace(jump, local=local, **_places(result))
    jump = replace(jump, **errors(jump, pieces))
    jump = replace(jump, **_compared(jump, delivered))
    moved = drift([place | {"y2": depth["y2"]} for place, depth in zip(pieces, beside, strict=True)])
    if jump.at == TAIL and pieces:
        moved = replace(moved, y2=result.tail.drift)
    jump = replace(jump, drift=moved, members=members(jump), filling=_filling(jump))
    if jump.verdict == "jump" and (why := _undeveloped(jump)):
        jump = replace(jump, verdict="jump not developed", reason=f"{jump.reason} {why}")
    return jump


def _streams(jump: Jump, delivered: tuple[Mean, Mean] | None) -> tuple[str, Mean, Mean]:
    """Name, depth (m) and velocity along the stream (m/s) of what the depth behind the jump is held against."""
    if jump.inflow is None:
        return BEFORE, Mean.of(jump.local, "y1"), Mean.of(jump.local, "u1")
    asked = Mean(jump.inflow.depth, 0.0), Mean(jump.inflow.velocity, 0.0)
    return (DELIVERED, *delivered) if delivered else (ASKED, *asked)


def _compared(jump: Jump, delivered: tuple[Mean, Mean] | None) -> dict[str, object]:
    """The fields of the one comparison with theory: tail water, else the depth behind the end, against a stream."""
    result, local = jump.measured, jump.local
    level = isfinite(result.tail.depth.value)
    y2 = result.tail.depth if level else Mean.of(local, "y2")
    if not result.flow.timed:
        return as_fields(y1=Mean.of(local, "y1"), y2=y2)
    of, depth, velocity = _streams(jump, delivered)
    sign, gravity = result.direction, result.flow.gravity
    forward = abs(velocity.value) if jump.inflow else sign * velocity.value
    stream = depth, Mean(forward, velocity.error), Mean(sign * jump.speed, jump.speed_error)
    found = against(y2, stream, Mean.of(jump, "length"), gravity)
    if of == BEFORE:  # the same numbers, whose errors the pieces of the window tell
        found |= {name: Mean.of(local, name) for name in ("froude", "belanger_y2")}
    kind = theory.jump_class(found["froude"].value)
    scene, there = result.flow.scene, []
    if fall := _fall(result):
        area = _area(result)

        def sequent(y: float, u: float, c: float) -> float:
            return y * theory.sloping_ratio(froude(y, u, c, gravity), 2 * fall * area / y**2)

        found["sloping_y2"] = propagated(sequent, *stream)
        found["sloping_deviation"] = propagated(lambda s, *one: s / sequent(*one) - 1.0, y2, *stream)
    there += [FRICTION] if scene.rubs else []
    there += [SLOPE] if scene.gravity[0] else []
    words = {
        "of": of,
        "at": TAIL if level else BEHIND,
        "left_out": tuple(there),
        "jump_class": kind,
        "bed_slope": fall or nan,
    }
    return as_fields(**found) | words


def _fall(result: JumpResult) -> float:
    """Tangent of the angle by which the bed falls along the stream."""
    return result.direction * result.flow.scene.gravity[0] / result.flow.gravity


def _area(result: JumpResult) -> float:
    """Area of the water between toe and end, by mass, m^2."""
    moving = result.moving
    return float(known_mean(moving.integral(moving.fields["mass_depth"], result.toe, result.end)))


def _filling(jump: Jump) -> bool:
    """Whether the front runs upstream and has no level tail water behind it yet: the channel still fills."""
    upstream = -jump.measured.direction * jump.speed
    return jump.at == BEHIND and upstream > 2 * np.nan_to_num(jump.speed_error)


def _undeveloped(jump: Jump) -> str:
    """Why the depth behind the front is not that of a jump yet, as a sentence; empty where it is."""
    reached = jump.y2 / jump.belanger_y2
    if reached < DEVELOPED_SHARE:
        return f"The depth behind it is {100 * reached:z.0f} % of Bélanger's: the flow behind is still filling up."
    return ""


def _moved(result: JumpResult) -> dict[str, float]:
    """Changes of the numbers of the states where their stretches are moved one depth away from the jump."""
    one, two = result.upstream, result.downstream
    far, down = (
        measure_state(result.moving, (start + by, stop + by), one.speed, one.gravity)
        for (start, stop), by in ((one.zone, -one.mass_depth), (two.zone, one.mass_depth))
    )
    ratios = [theory.belanger(state.froude_relative) * state.mass_depth for state in (one, far)]
    return {
        "moved_y1": far.mass_depth - one.mass_depth,
        "moved_froude": far.froude_relative - one.froude_relative,
        "moved_belanger_y2": ratios[1] - ratios[0],
        "moved_y2": down.mass_depth - two.mass_depth,
    }


def _local(result: JumpResult) -> dict[str, float]:
    """Numbers of a `Local`, by their keys, of what was measured in a window or in a piece of it."""
    found = _states(result)
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


def _against_theory(result: JumpResult, found: Mapping[str, float]) -> dict[str, float]:
    """Sequent ratio and loss beside theory, which takes in one measured ingredient after the other.

    `density_relation_ratio`: the change of density (`theory.sequent_ratio`); `full_relation_ratio`: bed force and
    slope, and the momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure,
    and what the control volume stores.
    """
    one, two, terms = result.upstream, result.downstream, result.balance
    fr1, s1, s2, ratio, density = (found[key] for key in ("froude", "y1", "y2", "sequent_ratio", "density_ratio"))
    betas, belanger = (found["beta_1"], found["beta_2"]), theory.belanger(fr1)
    # forces over g s1^2/2, the unit of the relation with thrust
    unit = one.still(one.mass_depth) / terms.downstream
    push = (terms.bed + terms.slope) / unit
    # the unit of the relations with densities is g s1 h1/2: their Froude number is that of the height
    loose = one.bulk_density
    expected = _sequent_ratio(fr1 * sqrt(loose), density)
    against: dict[str, float] = {
        "belanger_ratio": belanger,
        "belanger_y2": s1 * belanger,
        "belanger_deviation": share(ratio, belanger) - 1,
        "density_relation_ratio": expected,
        "density_relation_deviation": ratio / expected - 1,
        "full_relation_ratio": _sequent_ratio(fr1 * sqrt(loose), density, -push * loose / (1.0 + ratio), *betas),
        "energy_loss_theory": theory.energy_loss(s1, s1 * belanger),
        "energy_loss_depths": theory.energy_loss(s1, s2),
    }
    if fall := _fall(result):
        against["sloping_ratio"] = theory.sloping_ratio(fr1, 2 * fall * _area(result) / s1**2)
    if isfinite(terms.pressure):
        thrusts = (state.thrust / state.still(state.mass_depth) for state in (one, two))
        largest = _largest_ratio(fr1, *betas, *thrusts, push + terms.unsteady / unit)
        against |= {"pressure_relation_ratio": largest, "pressure_relation_deviation": ratio / largest - 1}
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
