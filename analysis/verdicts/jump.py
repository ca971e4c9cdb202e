# SPDX-License-Identifier: GPL-2.0-or-later
"""The verdict on a hydraulic jump."""

# ruff: noqa: RUF001  (minus signs and quotation marks are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from math import floor, log10
from typing import Any

from lammps_jump.analysis.verdicts.kinds import A_JUMP, AT_SILL, WITH

from .kinds import Doubt, Verdict, above, asked_of_a_dump, at, below, of_grains, part, shown
from .water import collapsed

SWALLOWED = "no jump found"
"""Verdict that says nothing where no stream flows in."""


def is_asked(summary: Mapping[str, Any]) -> bool:
    """Tells whether page and screen show what was looked for: a case requested a jump, or a dump has one."""
    jump = part(summary, "jump")
    is_jump = jump.get("verdict") in (*A_JUMP, AT_SILL)
    return bool(jump.get("verdict")) and (is_jump or asked_of_a_dump("jump", summary))


def is_spoken_of(summary: Mapping[str, Any]) -> bool:
    """Tells whether the title may speak of a jump: detected, or requested where a stream flows in; never of grains."""
    jump = part(summary, "jump")
    if not is_asked(summary) or of_grains(summary):
        return False
    if jump["verdict"] in A_JUMP:
        return True
    return not collapsed(part(summary, "front")) and ("inflow" in summary or jump["verdict"] != SWALLOWED)


def title(summary: Mapping[str, Any]) -> str:
    """The jump in a sentence: its depth against Bélanger's, and what its front does."""
    if not is_spoken_of(summary):
        return ""
    jump = part(summary, "jump")
    has, starts = summary.get("starts") or (1, 1)
    said = _jump(jump, 2.0 if starts == 1 else 1.0)
    return said.replace(".", f" in {has} of {starts} starts.", 1) if has < starts else said


def sentence(summary: Mapping[str, Any]) -> str:
    """Sentence on what to compare with what, as the analysis of the jump says it."""
    return (part(summary, "jump").get("headline") or "") if is_spoken_of(summary) else ""


CREEPS = 0.02
"""Share of the speed of the stream before it below which a front creeps."""
FAR = 2.0
"""Depth over Bélanger's, less one, from which on his relation does not apply."""


def _off(of: str, off: float, error: float | None) -> str:
    """A difference from Bélanger's, rounded to its error; equal where it is within that."""
    if off > FAR:
        return f"its {of} is {shown(1 + off)} times Bélanger’s, whose relation does not apply to it"
    if not error:
        return f"its {of} is {abs(100 * off):z.2g} % {'above' if off > 0 else 'below'} Bélanger’s"
    if abs(off) <= error:
        return f"its {of} equals Bélanger’s within {float(f'{100 * error:z.1g}'):zg} %"
    digits = max(0, -floor(log10(100 * error)))
    return f"its {of} is {abs(100 * off):z.{digits}f} % {'above' if off > 0 else 'below'} Bélanger’s"


def _jump(jump: Mapping[str, Any], errors: float) -> str:
    """Verdict on a jump; its front is stationary within so many of its errors."""
    if jump["verdict"] == AT_SILL:
        return "A jump that ends at the sill: no level water to compare."
    if jump["verdict"] not in A_JUMP:
        none = jump["verdict"].startswith("no jump")
        return "No hydraulic jump." if none else f"No hydraulic jump: {jump['verdict']}."
    said = []
    off, of, left_out = jump.get("belanger_deviation"), jump.get("at") or "depth", jump.get("left_out") or ()
    of = "sequent depth" if of == "tail water" else of  # as the number at the top is called
    if off is not None:
        but = ", which leaves that out," if left_out and jump["verdict"] == "jump" else ""
        said.append(_off(of, off, jump.get("belanger_deviation_error")) + but)
    speed, error = jump.get("speed"), jump.get("speed_error") or 0.0
    if speed is not None and abs(speed) <= errors * error:
        said.append("its front stands")
    elif speed is not None:
        way = "upstream" if speed * ((jump.get("local") or {}).get("u1") or 1.0) < 0 else "downstream"
        slow = abs(speed) < CREEPS * abs((jump.get("local") or {}).get("u1") or 0.0)
        said.append(f"its front {'creeps' if slow else 'moves'} {way} at {shown(abs(speed))} m/s")
    tail = " and ".join(said)
    name = A_JUMP[jump["verdict"]]
    if jump["verdict"] == "jump":
        name += WITH[tuple(left_out)] + " that still fills the channel" * bool(jump.get("filling"))
    return " ".join(filter(None, (f"{name}.", f"{tail[:1].upper()}{tail[1:]}." if tail else "")))


def _filling(summary: Mapping[str, Any]) -> str:
    if not part(summary, "jump").get("filling"):
        return ""
    return "the channel still fills: the depth behind the jump is a lower bound; run longer"


def _drift(summary: Mapping[str, Any]) -> str:
    jump = part(summary, "jump")
    moved, depth = (jump.get("drift") or {}).get("y2"), jump.get("y2")
    if moved is None or not depth or abs(moved) <= 0.05 * depth:
        return ""
    return f"the depth behind the jump changes by {shown(100 * abs(moved) / depth)} % within the window"


def _left_out(summary: Mapping[str, Any]) -> str:
    out = part(summary, "jump").get("left_out") or ()
    return f"Bélanger’s relation leaves out {' and '.join(out)}" if out else ""


def _at_inlet(summary: Mapping[str, Any]) -> str:
    stream = part(summary, "jump").get("stream") or {}
    return "the stream before the jump is compressed up to the inlet" if stream.get("at_inlet") else ""


def _frames(summary: Mapping[str, Any]) -> str:
    count = at(summary, "jump.frames_in_window")
    return f"the window holds {count} frames, too few for errors" if count is not None and count < 16 else ""


def _unanswered(summary: Mapping[str, Any]) -> str:
    if not is_asked(summary) or is_spoken_of(summary) or collapsed(part(summary, "front")):
        return ""
    if of_grains(summary):
        return "these are grains, whose friction has memory: no relation for water applies to them"
    return f"none: {part(summary, 'jump').get('reason') or 'no stream flows in'}"


HYDRAULIC_JUMP = Verdict(
    "Is there a hydraulic jump, and is it as deep as theory says?",
    "A hydraulic jump. Its sequent depth is 1.0 % below Bélanger’s and its front stands.",
    ("jump.verdict", "jump.y2", "jump.belanger_y2", "jump.belanger_deviation", "jump.speed", "jump.length"),
    title,
    (
        Doubt("the channel still fills", _filling),
        Doubt(
            "a jump is found in less than 90 % of the frames",
            below("jump.share_found", 0.9, "a jump is found in a share of {} of the frames only"),
        ),
        Doubt("the depth drifts by more than 5 % within the window", _drift),
        Doubt("friction or a sloping bed, which Bélanger’s relation leaves out", _left_out),
        Doubt("the stream is compressed up to the inlet", _at_inlet),
        Doubt("the window holds fewer than 16 frames", _frames),
        Doubt(
            "the inflow is more than 2 % off what was asked for",
            above("inflow.deviation", 0.02, "the inflow is {} % off what was asked for", 100.0),
        ),
    ),
    sentence,
    closes=True,
    unanswered=_unanswered,
)
