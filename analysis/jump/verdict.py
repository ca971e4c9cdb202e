# SPDX-License-Identifier: GPL-2.0-or-later
"""The verdict on a jump in words: one sentence for the top of the page, and notes on the state before the jump."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from dataclasses import fields, replace
from math import isfinite
from typing import Any

from lammps_jump.analysis.report.headline import A_JUMP
from lammps_jump.analysis.report.page import cut, percent_of, with_error
from lammps_jump.units import AT_LEAST, sure_of

from .certainty import starts_needed
from .found import Jump, Local, MeasuredJump, TrackedJump
from .frame import Balance
from .summary import FRICTION, SLOPE


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
"""The same of the states beside it; velocities where the file has them."""


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


def _kept(found: Jump | Local, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: value for name, value in vars(found).items() if name.removesuffix("_error") in names}


def headline(jump: Jump) -> str:
    """Headline: what happened, what to compare with what, and how sure that is."""
    if jump.verdict not in A_JUMP:
        return f"No hydraulic jump to compare with Bélanger: {jump.verdict}. {_sentence(jump.reason)}"
    name = {"jump": "Hydraulic jump", "marginal jump": "Now and then a jump"}.get(jump.verdict, "Jump not developed")
    at = f"{jump.frames_found} of {jump.frames_in_window} frames, front at {_number(jump, 'speed', 'm/s')}"
    said = (f"{name}: found in {at}.", compared(jump), left_out(jump), FILLS * bool(jump.filling), _how_sure(jump))
    return " ".join(filter(None, said)).replace("-", "−")


def compared(jump: Jump) -> str:
    """The depth behind the jump against Bélanger's of a named state."""
    off = percent_of(jump.belanger_deviation, *sure_of(jump, OFF))
    return (
        f"Compare the {jump.at}, {_number(jump, 'y2', 'm')}, with {_number(jump, 'belanger_y2', 'm')} by Bélanger "
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


def _number(found: Jump | Local, key: str, unit: str = "") -> str:
    return with_error(found, key, unit=unit)


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
    """Sentence on where the numbers beside the jump were measured, and how far contacts changed the stream there."""
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
