# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump and its verdict, with what theory says of them; docs/measuring.md explains them."""
# ruff: noqa: RUF001  (minus signs are meant for readers)

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from math import isfinite, nan, sqrt
from typing import Any

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.report.page import cut, percent_of, with_error
from lammps_jump.analysis.statistics import Mean, as_fields, known_mean, propagated
from lammps_jump.analysis.verdicts.kinds import A_JUMP
from lammps_jump.physics import jump as theory
from lammps_jump.units import AT_LEAST, sure_of

from .found import Jump, Local, MeasuredJump, TrackedJump, drift, errors, members, starts_needed
from .frame import Balance, measure_state, share
from .stream import Tail, against, froude

DEVELOPED_SHARE = 0.7
"""A front whose depth stays below this share of Bélanger's is still on its way to be a jump."""
DELIVERED, ASKED, BEFORE = "delivered inflow", "inflow asked for", "stream before the toe"
"""Streams that the depth downstream of a jump is compared with."""
FRICTION, SLOPE = "friction", "slope"
"""Forces that Bélanger's relation leaves out."""
TAIL, BEHIND = "tail water", "depth behind the end"
"""Depths that are held against them."""


def inflow_theory(flow: Flow) -> theory.Inflow | None:
    """Hydraulics of the inflow: Froude number, Bélanger depth, lengths, loss; None without an inflow."""
    if not flow.inflow_depth or not flow.inflow_speed or flow.gravity <= 0:
        return None
    return theory.inflow_theory(flow.inflow_depth, flow.inflow_speed, flow.gravity)


def summarise_jump(jump: TrackedJump, delivered: tuple[Mean, Mean] | None = None) -> TrackedJump:
    """A measured jump with its numbers.

    Parameters
    ----------
    jump : TrackedJump
        As measured.
    delivered : (Mean, Mean), optional
        Depth (m) and mean velocity (m/s) after the inlet, to compare the tail water with; by default those that
        were requested.
    """
    jump = replace(jump, inflow=inflow_theory(jump.flow))
    if jump.track is None:
        return jump
    seen, frames = int((jump.track.found & jump.in_window).sum()), int(jump.in_window.sum())
    jump = replace(jump, frames_found=seen, frames_in_window=frames, share_found=seen / frames if frames else nan)
    if not isinstance(jump, MeasuredJump):
        return jump
    pieces = [_places(piece) for piece in jump.pieces]
    local_states = [_local(piece) for piece in jump.pieces]
    local = Local(**_local(jump), **_moved(jump))
    local = replace(local, **errors(local, local_states))
    jump = replace(jump, local=local, **_places(jump))
    jump = replace(jump, **errors(jump, pieces))
    tail = jump.tail or Tail()
    jump = replace(jump, **_compared(jump, local, tail, delivered))
    moved = drift([place | {"y2": depth["y2"]} for place, depth in zip(pieces, local_states, strict=True)])
    if jump.at == TAIL and pieces:
        moved = replace(moved, y2=tail.drift)
    jump = replace(jump, drift=moved, members=members(jump), filling=_filling(jump))
    if jump.verdict == "jump" and (why := _undeveloped(jump)):
        jump = replace(jump, verdict="jump not developed", reason=f"{jump.reason} {why}")
    return jump


def _streams(jump: MeasuredJump, local: Local, delivered: tuple[Mean, Mean] | None) -> tuple[str, Mean, Mean]:
    """Name, depth (m) and velocity along the stream (m/s) of what the depth after the jump is compared with."""
    if jump.inflow is None:
        return BEFORE, Mean.of(local, "y1"), Mean.of(local, "u1")
    means = Mean(jump.inflow.depth, 0.0), Mean(jump.inflow.velocity, 0.0)
    return (DELIVERED, *delivered) if delivered else (ASKED, *means)


def _compared(jump: MeasuredJump, local: Local, tail: Tail, delivered: tuple[Mean, Mean] | None) -> dict[str, Any]:
    """The fields of the one comparison with theory: tail water, else the depth after the end, against a stream."""
    level = isfinite(tail.depth.value)
    y2 = tail.depth if level else Mean.of(local, "y2")
    if not jump.flow.timed:
        return as_fields(y1=Mean.of(local, "y1"), y2=y2)
    of, depth, velocity = _streams(jump, local, delivered)
    sign, gravity = jump.direction, jump.flow.gravity
    forward = abs(velocity.value) if jump.inflow else sign * velocity.value
    stream = depth, Mean(forward, velocity.error), Mean(sign * jump.speed, jump.speed_error)
    means = against(y2, stream, Mean.of(jump, "length"), gravity)
    if of == BEFORE:  # the same numbers, whose errors the pieces of the window tell
        means |= {name: Mean.of(local, name) for name in ("froude", "belanger_y2")}
    kind = theory.jump_class(means["froude"].value)
    scene, there = jump.flow.scene, []
    if fall := _fall(jump):
        area = _area(jump)

        def sequent(y: float, u: float, c: float) -> float:
            return y * theory.sloping_ratio(froude(y, u, c, gravity), 2 * fall * area / y**2)

        means["sloping_y2"] = propagated(sequent, *stream)
        means["sloping_deviation"] = propagated(lambda s, *one: s / sequent(*one) - 1.0, y2, *stream)
    there += [FRICTION] if scene.rubs else []
    there += [SLOPE] if scene.gravity[0] else []
    words = {
        "of": of,
        "at": TAIL if level else BEHIND,
        "left_out": tuple(there),
        "jump_class": kind,
        "bed_slope": fall or nan,
    }
    return as_fields(**means) | words


def _fall(result: MeasuredJump) -> float:
    """Tangent of the angle by which the bed falls along the stream."""
    return result.direction * result.flow.scene.gravity[0] / result.flow.gravity


def _area(result: MeasuredJump) -> float:
    """Area of the water between toe and end, by mass, m^2."""
    moving = result.moving
    return float(known_mean(moving.integral(moving.fields["mass_depth"], result.mass_toe, result.mass_end)))


def _filling(jump: MeasuredJump) -> bool:
    """Tells whether the front runs upstream and has no level tail water after it yet: the channel still fills."""
    upstream = -jump.direction * jump.speed
    return jump.at == BEHIND and upstream > 2 * np.nan_to_num(jump.speed_error)


def _undeveloped(jump: MeasuredJump) -> str:
    """Why the depth downstream of the front is not that of a jump yet, as a sentence; empty where it is."""
    reached = jump.y2 / jump.belanger_y2
    if reached < DEVELOPED_SHARE:
        return f"The depth behind it is {100 * reached:z.0f} % of Bélanger's: the flow behind is still filling up."
    return ""


def _moved(result: MeasuredJump) -> dict[str, Any]:
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


def _local(result: MeasuredJump) -> dict[str, Any]:
    """Numbers of a `Local`, by their keys, of what was measured in a window or in a piece of it."""
    states = _states(result)
    return states | (_against_theory(result, states) if result.flow.timed else {})


def _places(result: MeasuredJump) -> dict[str, Any]:
    """Places along x at the last frame used, velocities, and lengths."""
    track, motion = result.track, result.motion
    used = result.used
    time = float(track.time[used][-1])
    front = float(motion.start + motion.speed * time)
    return {
        "time": time,
        "position": front,
        "toe": front + result.direction * result.mass_toe,
        "end": front + result.direction * result.mass_end,
        "speed": motion.speed,
        "toe_speed": result.toe_speed,
        "end_speed": result.end_speed,
        "length": result.surface_end - result.surface_toe,
        "length_mass": result.mass_end - result.mass_toe,
        "length_ramp": result.direction * float(np.median(track.end[used] - track.toe[used])),
    }


def _states(result: MeasuredJump) -> dict[str, float]:
    """Depths, velocities, packing, Froude numbers, momentum and head on both sides."""
    one, two, density = result.upstream, result.downstream, result.flow.scene.density
    states: dict[str, float] = {}
    for k, state in ((1, one), (2, two)):
        states |= {f"y{k}": state.mass_depth, f"h{k}": state.surface_depth}
        states |= {f"u{k}": result.direction * state.velocity}
        states |= {f"packing_{k}": state.packing, f"beta_{k}": state.beta}
    return states | {
        "froude": one.froude_relative,
        "froude_lab": one.froude,
        "froude_downstream": two.froude_relative,
        "sequent_ratio": states["y2"] / states["y1"],
        "density_ratio": share(two.bulk_density, one.bulk_density),
        "head_upstream": one.head,
        "head_downstream": two.head,
        "energy_loss": one.head - two.head,
        "momentum_upstream": density * result.momentum_terms.upstream,
        "momentum_downstream": density * result.momentum_terms.downstream,
        "momentum_residual": result.momentum_terms.classical,
    }


def _against_theory(result: MeasuredJump, states: Mapping[str, float]) -> dict[str, float]:
    """Sequent ratio and loss against theory, which takes in one measured ingredient after the other.

    `density_relation_ratio`: the change of density (`theory.sequent_ratio`); `full_relation_ratio`: bed force and
    slope, and the momentum coefficients too; `pressure_relation_ratio`: in place of hydrostatics the contact pressure,
    and what the control volume stores.
    """
    one, two, terms = result.upstream, result.downstream, result.momentum_terms
    fr1, s1, s2, ratio, density = (states[key] for key in ("froude", "y1", "y2", "sequent_ratio", "density_ratio"))
    betas, belanger = (states["beta_1"], states["beta_2"]), theory.belanger(fr1)
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
        thrusts = one.thrust / one.still(s1), two.thrust / two.still(s2)
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


def _largest_ratio(
    froude: float, beta_1: float, beta_2: float, thrust_1: float, thrust_2: float, other: float
) -> float:
    """Largest root S of 2 Fr^2 (beta_1 - beta_2/S) + p1 - p2 S^2 + other = 0; p thrust over g s^2/2; NaN for none."""
    roots = np.roots([-thrust_2, 0.0, 2 * froude**2 * beta_1 + thrust_1 + other, -2 * froude**2 * beta_2])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(real.max()) if real.size and real.max() > 0 else nan


def worded(jump: TrackedJump) -> TrackedJump:
    """The jump with its headline, its notes, and a reason that says where the state before the toe was measured."""
    if isinstance(jump, MeasuredJump) and jump.verdict in A_JUMP:
        jump = replace(jump, reason=f"{jump.reason} {belongs_to(jump)}", notes=notes(jump))
    return replace(jump, headline=headline(jump))


WITHOUT_TIMES = (
    "y1", "y2", "length", "length_mass", "length_ramp", "position", "toe", "end", "share_found", "window",
    "frames_found", "frames_in_window", "heap",
)  # fmt: skip
"""Numbers of a jump that follow from the discs' places."""
BESIDE_WITHOUT_TIMES = (
    "y1", "y2", "h1", "h2", "u1", "u2", "packing_1", "packing_2", "sequent_ratio", "density_ratio",
)  # fmt: skip
"""The same of the states next to it; velocities where the file has them."""


def untimed(jump: TrackedJump) -> TrackedJump:
    """The jump of a dump without times: no velocity of the front, hence no Froude number, no head and no theory."""
    known = _kept(jump, WITHOUT_TIMES)
    if jump.local is not None:
        known["local"] = Local(**_kept(jump.local, BESIDE_WITHOUT_TIMES))
    aside = (one.name for one in fields(TrackedJump) if not one.metadata.get("summary", True))
    known |= {name: getattr(jump, name) for name in aside} | {"notes": ()}
    if jump.verdict not in A_JUMP:
        return TrackedJump(jump.verdict, jump.reason, headline(jump), **known)
    said = (
        f"A step in depth is found in {jump.frames_found} of {jump.frames_in_window} frames: mass depth "
        f"{cut(jump, 'y1', unit='m')} before it, {cut(jump, 'y2', unit='m')} behind. Without times "
        "its speed, Froude number and head are not known, and nothing says that it is a hydraulic jump."
    )
    verdict = "marginal jump" if jump.verdict == "marginal jump" else "jump"
    return TrackedJump(verdict, said, said, **known)


def _kept(part: Jump | Local, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: value for name, value in vars(part).items() if name.removesuffix("_error") in names}


def headline(jump: Jump) -> str:
    """Headline: what happened, what to compare with what, and how sure that is."""
    if jump.verdict not in A_JUMP:
        return f"No hydraulic jump to compare with Bélanger: {jump.verdict}. {_sentence(jump.reason)}"
    name = {"jump": "Hydraulic jump", "marginal jump": "Now and then a jump"}.get(jump.verdict, "Jump not developed")
    at = f"{jump.frames_found} of {jump.frames_in_window} frames, front at {_number(jump, 'speed', 'm/s')}"
    said = (f"{name}: found in {at}.", compared(jump), left_out(jump), FILLS * bool(jump.filling), _how_sure(jump))
    return " ".join(filter(None, said)).replace("-", "−")


def compared(jump: Jump) -> str:
    """The depth downstream of the jump against Bélanger's of a named state."""
    off = percent_of(jump.belanger_deviation, *sure_of(jump, OFF))
    of = "sequent depth" if jump.at == TAIL else jump.at
    return (
        f"Compare the {of}, {_number(jump, 'y2', 'm')}, with {_number(jump, 'belanger_y2', 'm')} by Bélanger "
        f"for the {jump.of} in the front's frame (Fr = {_number(jump, 'froude')}): {off}."
    )


OFF = "belanger_deviation"
FILLS = "The channel still fills: there is no level tail water yet, and the depth is a lower bound."


def left_out(jump: Jump) -> str:
    """Sentence on what Bélanger's relation leaves out of this flow: friction and a sloping bed."""
    terms = jump.momentum_terms or Balance()
    known = {FRICTION: ("friction; that of the bed", terms.bed), SLOPE: ("the slope of the bed; it", terms.slope)}
    said = [
        f"Bélanger's relation leaves out {name} is {percent_of(term)} of the momentum function."
        for name, term in (known[name] for name in jump.left_out)
    ]
    if isfinite(jump.sloping_y2):
        off = percent_of(jump.sloping_deviation, *sure_of(jump, "sloping_deviation"))
        said.append(f"With the weight of the jump along the bed it gives {_number(jump, 'sloping_y2', 'm')}: {off}.")
    return " ".join(said)


def _number(part: Jump | Local, key: str, unit: str = "") -> str:
    return with_error(part, key, unit=unit)


def _how_sure(jump: Jump) -> str:
    if not isfinite(jump.speed_error):
        return "Too few frames for errors."
    needed = starts_needed(jump.members)
    return (
        f"± is within this run; a standard error of 3 % takes {AT_LEAST}{needed}."
        if needed
        else "± is within this run."
    )


def belongs_to(jump: MeasuredJump) -> str:
    """Sentence on where the numbers near the jump were measured, and how far contacts changed the stream there."""
    near, far = -jump.upstream.zone[1], -jump.upstream.zone[0]
    text = f"The state before the toe is that of the stream {near:z.1f} to {far:z.1f} m before the front"
    stream = jump.stream
    if stream is None or not isfinite(stream.compression):
        return f"{text}."
    return (
        f"{text}. Contacts compress that stream from x = {stream.compression:z.0f} m on: behind the inlet its "
        f"Froude number is {stream.froude[0]:z.2f}."
    )


def notes(jump: Jump) -> tuple[str, ...]:
    """Warnings: the compression before the jump has reached the inlet."""
    stream = jump.stream
    if stream is None or not stream.at_inlet:
        return ()
    return (
        f"the compression front before the jump stands {stream.undisturbed:z.1f} m behind the inlet: the stream before "
        "the jump is no longer the inflow. Compare with Bélanger's depth of the inflow, lengthen the channel or take "
        "an earlier window.",
    )


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"
