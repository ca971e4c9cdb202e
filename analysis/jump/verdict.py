# SPDX-License-Identifier: GPL-2.0-or-later
"""The verdict on a jump in words: one sentence for the top of the page, and notes on the state before the jump."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from dataclasses import replace
from math import isfinite

from lammps_jump.analysis.report.headline import A_JUMP
from lammps_jump.analysis.report.page import with_error
from lammps_jump.analysis.statistics import Mean, propagated
from lammps_jump.units import AT_LEAST

from .certainty import starts_needed
from .summary import Jump
from .tail import Tail


def worded(jump: Jump) -> Jump:
    """The jump with its headline, its notes, and a reason that names the state of Bélanger's number."""
    if jump.verdict in A_JUMP:
        jump = replace(jump, reason=f"{jump.reason} {belongs_to(jump)}", notes=notes(jump))
    return replace(jump, headline=headline(jump))


WITHOUT_TIMES = (
    "y1", "y2", "h1", "h2", "u1", "u2", "packing_1", "packing_2", "sequent_ratio", "density_ratio", "length",
    "length_mass", "length_ramp", "length_over_y2", "position", "toe", "end", "share_found", "window", "frames_found",
    "frames_in_window", "heap",
)  # fmt: skip
"""Numbers of a jump that follow from the discs' places and, where the file has them, velocities."""


def untimed(jump: Jump) -> Jump:
    """The jump of a dump without times: no velocity of the front, hence no Froude number, no head and no theory."""
    known = {name: value for name, value in vars(jump).items() if name.removesuffix("_error") in WITHOUT_TIMES}
    held = jump.measured and replace(jump.measured, motion=None, moving=None, stream=None)
    if jump.verdict not in A_JUMP:
        return Jump(jump.verdict, jump.reason, headline(jump), measured=held, **known)
    said = (
        f"A step in depth is found in {jump.frames_found} of {jump.frames_in_window} frames: mass depth "
        f"{_number(jump, 'y1', 'm')} before it, {_number(jump, 'y2', 'm')} behind. Without times "
        "its speed, Froude number and head are not known, and nothing says that it is a hydraulic jump."
    )
    verdict = "marginal jump" if jump.verdict == "marginal jump" else "jump"
    return Jump(verdict, said, said, measured=held, **known)


def headline(jump: Jump) -> str:
    """What happened, what to compare with what, and how sure that is."""
    if jump.verdict not in A_JUMP:
        return f"No hydraulic jump to compare with Bélanger: {jump.verdict}. {_sentence(jump.reason)}"
    name = {"jump": "Hydraulic jump", "marginal jump": "Now and then a jump"}.get(jump.verdict, "Jump not developed")
    at = f"{jump.frames_found} of {jump.frames_in_window} frames, front at {_number(jump, 'speed', 'm/s')}"
    return f"{name}: found in {at}. {compared(jump)} {_how_sure(jump)}".replace("-", "−")


def compared(jump: Jump) -> str:
    """The depth behind the jump against Bélanger's of a named state."""
    tail, inflow = jump.tail, jump.tail is not None and isfinite(jump.tail.belanger_y2)
    level = tail is not None and isfinite(tail.depth)
    place, *depth = ("tail water", tail, "depth") if level else ("depth", jump, "y2")
    state, held = ("delivered inflow", tail) if inflow else ("stream just before the toe", jump)
    two = Mean.of(*depth), Mean.of(held, "belanger_y2")
    off = propagated(lambda found, expected: 100 * (found / expected - 1), *two)
    more = f" ± {AT_LEAST}{off.error:.1f}" if isfinite(off.error) else ""
    return (
        f"Compare the {place} behind it, {_number(*depth, 'm')}, with {_number(held, 'belanger_y2', 'm')} by Bélanger "
        f"for the {state} in the front's frame: {off.value:+.1f}{more} %."
    )


def _number(found: Jump | Tail, key: str, unit: str = "") -> str:
    return with_error(vars(found), key, unit=unit)


def _how_sure(jump: Jump) -> str:
    if not isfinite(jump.speed_error):
        return "Too few frames for errors."
    needed = starts_needed(vars(jump.members))
    return (
        f"± is within this run; a standard error of 3 % takes {AT_LEAST}{needed}."
        if needed
        else "± is within this run."
    )


def belongs_to(jump: Jump) -> str:
    """The state that the numbers of index 1, and with them Bélanger's, belong to."""
    near, far = -jump.measured.upstream.zone[1], -jump.measured.upstream.zone[0]
    ratio, depth = (
        text if "±" in (text := _number(jump, key)) else f"{getattr(jump, key):.2f}" for key in ("belanger_ratio", "y1")
    )
    text = (
        f"Bélanger's ratio {ratio} belongs to the stream {near:.1f} to {far:.1f} m before the front (s₁ = {depth} m, "
        f"Fr = {_number(jump, 'froude')}; ± within this run)"
    )
    stream = jump.stream
    if stream is None or not isfinite(stream.compression):
        return f"{text}."
    return (
        f"{text}. Contacts compress that stream from x = {stream.compression:.0f} m on. The first stretch behind the "
        f"inlet has Fr = {stream.froude[0]:.2f}: y₂ lies {100 * stream.deviation[0]:+.1f} % off its Bélanger depth "
        f"and {100 * jump.belanger_deviation:+.1f} % off that of the compressed stream."
    )


def notes(jump: Jump) -> tuple[str, ...]:
    """Warnings: the compression before the jump has reached the inlet."""
    stream = jump.stream
    if stream is None or not stream.at_inlet:
        return ()
    return (
        f"the compression front before the jump stands {stream.undisturbed:.1f} m behind the inlet: the stream before "
        "the jump is no longer the inflow. Compare with Bélanger's depth of the inflow, lengthen the channel or take "
        "an earlier window.",
    )


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"
