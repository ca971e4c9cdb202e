# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts on grains: an outlet, a heap, a drum, a layer on a slope."""

# ruff: noqa: RUF001  (Greek letters and minus signs are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lammps_jump.analysis.verdicts.kinds import FELL

from .kinds import Doubt, Verdict, above, at, below, of_grains, part, place, reason, shown


def _outlet(summary: Mapping[str, Any]) -> str:
    hopper = part(summary, "hopper")
    rate = hopper.get("discharge")
    if rate is None:
        return ""
    gaps = hopper.get("gap_x") or ()
    if len(gaps) < 2:
        where = f" at x = {place(gaps[0])} m" if gaps else ""
        through = f"a gap of {shown(hopper['slot'])} m{where}"
    else:
        each = zip(hopper["gap_discharge"], hopper["gap_width"], gaps, strict=True)
        shares = ", ".join(f"{shown(one / 1e3)} through {shown(w)} m at x = {place(x)} m" for one, w, x in each)
        through = f"{len(gaps)} gaps: {shares}"
    return f"Discs leave at {shown(rate / 1e3)} t/s per metre through {through}."


def _law(summary: Mapping[str, Any]) -> str:
    number, width = at(summary, "hopper.beverloo"), at(summary, "hopper.slot_in_diameters")
    if number is None:  # why there is none is among the doubts
        return ""
    at_width = f" The gap is {shown(width)} d wide; the law holds from 6 d on." if width else ""
    return f" Over ρ √g (D − 1.4 d)^1.5, after Beverloo, that is {shown(number)}.{at_width}"


def _outlet_at_length(summary: Mapping[str, Any]) -> str:
    said = _outlet(summary)
    return said + _law(summary) if at(summary, "hopper.discharge") is not None else said


def _few_pass(summary: Mapping[str, Any]) -> str:
    discs = at(summary, "hopper.discs")
    return f"{discs} discs pass while the flow is on" if discs is not None and discs < 100 else ""


def _pause(summary: Mapping[str, Any]) -> str:
    pause, usual = at(summary, "hopper.pause"), at(summary, "hopper.usual_pause")
    if pause is None or not usual or pause <= 20 * usual:
        return ""
    return (
        f"no disc passes for {shown(pause)} s, {pause / usual:z.0f} times the usual pause: the flow stops and goes on"
    )


def _no_law(summary: Mapping[str, Any]) -> str:
    why = part(summary, "hopper").get("no_beverloo")
    return f"there is no number of Beverloo: {why}" if why else ""


OUTLET = Verdict(
    "How much leaves a silo or hopper, and through which gap?",
    "Discs leave at 0.18 t/s per metre through a gap of 0.10 m at x = 0.1 m.",
    ("hopper.discharge", "hopper.slot", "hopper.gap_x", "hopper.gap_width", "hopper.beverloo", "hopper.begin"),
    _outlet,
    (
        Doubt("fewer than 100 discs pass while the flow is on", _few_pass),
        Doubt(
            "the discharge changes by more than 15 % from the first half of the window to the second",
            above("hopper.change", 0.15, "the discharge changes by {} % within the window", 100.0),
        ),
        Doubt("no disc passes for 20 times the usual pause: arches", _pause),
        Doubt("several gaps, a gap below six diameters, or a gap in a side wall: no law is asked", _no_law),
    ),
    _outlet_at_length,
    unanswered=reason("hopper"),
)  # fmt: skip


def _heap(summary: Mapping[str, Any]) -> str:
    heap = part(summary, "heap")
    if heap.get("height") is None:
        return ""
    rests = "still moves" if heap.get("at_rest") is False else "is at rest" if heap.get("at_rest") else "stands"
    slope = "" if heap.get("angle") is None else f", its flanks slope at {heap['angle']:z.0f} degrees"
    if (heap.get("run_out_over_base") or 0.0) < FELL:
        return f"A {'heap' if slope else 'bed'} of {shown(heap['height'])} m {rests}{slope}."
    return f"The column has run out {shown(heap['run_out_over_base'])} times its base and {rests}{slope}."


def _touches(summary: Mapping[str, Any]) -> str:
    heap = part(summary, "heap")
    if heap.get("no_run_out"):
        return f"there is no run-out: {heap['no_run_out']}"
    # a bed lies between walls, and a column leans on one from the start
    if heap.get("angle") is None or heap.get("base") is not None:
        return ""
    at_ends = dict.fromkeys(heap[key] for key in ("left_at", "right_at") if heap.get(key))
    return f"the heap touches {' and '.join(at_ends)}, so that its height and slope are not its own" if at_ends else ""


def _moves(summary: Mapping[str, Any]) -> str:
    rest = part(summary, "heap").get("at_rest")
    if rest is None:
        rest = part(summary, "state").get("at_rest")
    return "the discs still move: height and slope are those of the last frame" if rest is False else ""


def _wide(summary: Mapping[str, Any]) -> str:
    half = at(summary, "heap.angle_interval")
    return (
        f"the flanks are no straight lines: their angle is known to ± {shown(half)} degrees"
        if half and half > 5
        else ""
    )


def _unlike(summary: Mapping[str, Any]) -> str:
    left, right = at(summary, "heap.angle_left"), at(summary, "heap.angle_right")
    if left is None or right is None:
        return ""
    sure = sum(at(summary, f"heap.angle_{side}_interval") or 0.0 for side in ("left", "right"))
    if abs(left - right) <= max(5.0, sure):
        return ""
    return f"the flanks differ: {left:z.0f} degrees to the left and {right:z.0f} to the right"


def _creeps(summary: Mapping[str, Any]) -> str:
    if "friction_law" not in summary or of_grains(summary):
        return ""
    return "friction has no memory (contact.friction_law: history): a heap creeps and flattens"


HEAP = Verdict(
    "How high and how steep is a heap? How far does a column of grains run out?",
    "A heap of 0.23 m is at rest, its flanks slope at 21 degrees.",
    ("heap.height", "heap.angle", "heap.angle_interval", "heap.run_out_over_base", "heap.at_rest"),
    _heap,
    (
        Doubt("the discs still move", _moves),
        Doubt("the angle is known to more than ± 5 degrees", _wide),
        Doubt("the flanks differ by more than 5 degrees and their intervals", _unlike),
        Doubt(
            "the heap is less than ten diameters high",
            below("heap.height_in_diameters", 10.0, "the heap is {} diameters high"),
        ),
        Doubt("friction has no memory", _creeps),
        Doubt("the heap, or what a column runs out to, touches a wall, an outlet or the end of the domain", _touches),
    ),
    unanswered=reason("heap"),
)


def _drum(summary: Mapping[str, Any]) -> str:
    drum = part(summary, "drum")
    angle = drum.get("angle")
    if angle is None:
        return ""
    return f"The drum turns, and its surface slopes at {angle:z.1f} degrees."


def _centrifuge(summary: Mapping[str, Any]) -> str:
    froude = at(summary, "drum.froude")
    if froude is None or 1e-4 <= froude <= 0.1:
        return ""
    why = "the surface is bent, no straight slope" if froude > 0.1 else "discs fall in avalanches"
    return f"its Froude number is {shown(froude)}: {why}"


DRUM = Verdict(
    "How steep is the surface in a drum that turns?",
    "The drum turns, and its surface slopes at 24.9 degrees.",
    ("drum.angle", "drum.angle_error", "drum.scatter", "drum.froude", "drum.turns"),
    _drum,
    (
        Doubt("the window holds less than half a turn", below("drum.turns", 0.5, "the window holds {} of a turn")),
        Doubt(
            "the angle swings by more than 3 degrees from frame to frame",
            above("drum.scatter", 3.0, "the angle swings by {} degrees from frame to frame"),
        ),
        Doubt("the Froude number ω²R/g is not between 0.0001 and 0.1", _centrifuge),
        Doubt(
            "the drum is less than a fifth full, or more than four fifths",
            lambda summary: _filled(at(summary, "drum.filling")),
        ),
    ),
    unanswered=reason("drum"),
)


def _filled(share: float | None) -> str:
    return f"the discs fill {shown(100 * share)} % of the drum" if share is not None and not 0.2 <= share <= 0.8 else ""


def _incline(summary: Mapping[str, Any]) -> str:
    layers = part(summary, "layers")
    speed = layers.get("velocity")
    if speed is None:
        return ""
    if part(summary, "state").get("at_rest"):
        return "The layer rests on its bed."
    rubs = f"; its effective friction is {shown(layers['friction'])}" if layers.get("friction") is not None else ""
    return f"The layer flows at {shown(abs(speed))} m/s{rubs}."


def _changes(summary: Mapping[str, Any]) -> str:
    change = at(summary, "layers.change")
    if change is None or abs(change) <= 0.1 or part(summary, "state").get("at_rest"):
        return ""
    way = "faster" if change > 0 else "slower"
    return f"the layer is {shown(100 * abs(change))} % {way} in the second half of the window: it is not steady"


INCLINE = Verdict(
    "How does a layer of grains flow on a slope?",
    "The layer flows at 0.35 m/s; its effective friction is 0.36.",
    ("layers.velocity", "layers.friction", "layers.inertial_number", "layers.packing", "layers.change"),
    _incline,
    (
        Doubt("the velocity changes by more than 10 % within the window", _changes),
        Doubt("fewer than ten layers hold discs", below("layers.layers", 10, "{} layers hold discs")),
    ),
    unanswered=reason("layers"),
)
