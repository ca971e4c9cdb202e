# SPDX-License-Identifier: GPL-2.0-or-later
"""The sentences at the top of a report and of the screen: what happened, what to compare with what, and how sure."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from math import floor, log10
from typing import NamedTuple

from .page import percent

A_JUMP = {
    "jump": "A hydraulic jump",
    "marginal jump": "Now and then a jump",
    "jump not developed": "A growing jump",
}
"""Verdicts on flows that have a jump, in words."""
WITH = {(): "", ("friction",): " with friction", ("slope",): " on a slope",
        ("friction", "slope"): " with friction on a slope"}  # fmt: skip
"""What Bélanger's relation leaves out, behind a verdict."""
AT_SILL = "jump at the sill"
"""Verdict on a rise that goes on up to the sill or fall: nothing behind it can be compared."""


class Against(NamedTuple):
    """A measured number of a jump and the number of theory that it is held against: keys of ``summary.json: jump``."""

    key: str
    label: str
    words: str
    theory: str


COMPARED = (
    Against("y2", "sequent depth", "Bélanger", "belanger_y2"),
    Against("speed", "front velocity", "from mass", "mass.speed_from_mass"),
    Against("length", "jump length", "thesis (4.27)", "length_theory"),
    Against("length", "jump length", "USBR", "length_usbr"),
    Against("head_lost", "head lost", "Bélanger", "head_lost_theory"),
)
"""What is measured of a jump and what theory says: the one comparison, for page, tiles and screen."""
DISCS = (-0.2, 0.0)
"""Mean difference of fronts of frictionless discs from Martin & Moyce's water, five starts (docs/theory.md)."""


FELL = 0.01
"""Run-out over base from which on a column has fallen: a bed that lies as it lay is none."""


def _waves(waves: Mapping) -> str:
    if waves.get("height") is None:
        return ""
    pairs = list(zip(waves["gauges"], waves["heights"], strict=True))
    last = f" and {pairs[-1][1]:.2f} m at x = {pairs[-1][0]:g} m" if len(pairs) > 1 else ""
    return f"Waves of {_short(waves['period'])} s are {pairs[0][1]:.2f} m high at x = {pairs[0][0]:g} m{last}."


def _drum(drum: Mapping) -> str:
    angle = drum.get("angle")
    return "" if angle is None else f"The drum turns, and its surface slopes at {angle:.1f} degrees."


def _hopper(hopper: Mapping) -> str:
    rate = hopper.get("discharge")
    if rate is None:
        return ""
    return f"The hopper lets out {_short(rate / 1e3)} t/s per metre through a slot of {_short(hopper['slot'])} m."


def _heap(heap: Mapping) -> str:
    if heap.get("height") is None:
        return ""
    rests = "still moves" if heap.get("at_rest") is False else "is at rest" if heap.get("at_rest") else "stands"
    slope = "" if heap.get("angle") is None else f", its flanks slope at {heap['angle']:.0f} degrees"
    if (heap.get("run_out_over_base") or 0.0) < FELL:
        return f"A {'heap' if slope else 'bed'} of {_short(heap['height'])} m {rests}{slope}."
    return f"The column has run out {_short(heap['run_out_over_base'])} times its base and {rests}{slope}."


OF_DEVICES = {"waves": _waves, "drum": _drum, "hopper": _hopper, "heap": _heap}
"""Sentences on flows that a device or the grains make, by the key of their quantity."""


def verdict(summary: Mapping) -> str:
    """One short sentence on what happened, the title of a report; empty where there is nothing to be said.

    `summary` is that of a run, or of starts of one case, as of `rows.together`.
    """
    status = summary.get("status") or "complete"
    if status != "complete":
        return f"The run is {status}."
    jump, front, energy = _parts(summary)
    said = next(filter(None, (say(summary.get(key) or {}) for key, say in OF_DEVICES.items())), "")
    if said:
        return said.replace("-", "−")
    if jump:
        has, starts = summary.get("starts") or (1, 1)
        said = _jump(jump, 2.0 if starts == 1 else 1.0)
        said = said.replace(".", f" in {has} of {starts} starts.", 1) if has < starts else said
    elif front.get("position") is not None:
        said = _collapse(front)
    elif energy.get("conservative") and energy.get("max_deviation") is not None:
        said = f"The energy stays within {percent(energy['max_deviation'])} of that of the start."
    return said.replace("-", "−")


def _collapse(front: Mapping) -> str:
    if not _collapsed(front):
        after = "" if front.get("time") is None else f" after {front['time']:.3g} s"
        return f"The front of the discs is at {front['position']:.3g} m{after}."
    ritter = against_water(front) and (front.get("ritter") or {}).get("front_speed")
    more = f"; Ritter’s would run at {_short(ritter)} m/s" if ritter else ""
    arrival = front.get("arrival_time")
    more = f" and meets the obstacle after {_short(arrival)} s" if arrival is not None else more
    opens = front.get("gate_open")
    what = f"The gate opens in {_short(opens)} s: the" if opens is not None else "A column collapses: its"
    return f"{what} front runs at {_short(front['speed'])} m/s{more}."


def _collapsed(front: Mapping) -> bool:
    """Whether there was a column at the start, whose front then ran."""
    return front.get("column_base") is not None and front.get("speed") is not None


def against_water(front: Mapping) -> bool:
    """Whether the case asks for a comparison with water: ``analysis.front: water``."""
    return bool(front.get("martin_moyce"))


def _short(value: float) -> str:
    """Two significant digits, ``1.0``, ``12``."""
    return f"{value:#.2g}".rstrip(".")


def _off(of: str, off: float, error: float | None) -> str:
    """A difference from Bélanger's, rounded to its error; equal where it is within that."""
    if not error:
        return f"its {of} is {abs(100 * off):.2g} % {'above' if off > 0 else 'below'} Bélanger’s"
    if abs(off) <= error:
        return f"its {of} equals Bélanger’s within {float(f'{100 * error:.1g}'):g} %"
    digits = max(0, -floor(log10(100 * error)))
    return f"its {of} is {abs(100 * off):.{digits}f} % {'above' if off > 0 else 'below'} Bélanger’s"


def _jump(jump: Mapping, errors: float) -> str:
    """Verdict on a jump; its front stands within so many of its errors."""
    if jump["verdict"] == AT_SILL:
        return "A jump that ends at the sill: no level water to compare."
    if jump["verdict"] not in A_JUMP:
        return (
            "No hydraulic jump." if jump["verdict"].startswith("no jump") else f"No hydraulic jump: {jump['verdict']}."
        )
    said = []
    off, of, left_out = jump.get("belanger_deviation"), jump.get("at") or "depth", jump.get("left_out") or ()
    if off is not None:
        but = ", which leaves that out," if left_out else ""
        said.append(_off(of, off, jump.get("belanger_deviation_error")) + but)
    speed, error = jump.get("speed"), jump.get("speed_error") or 0.0
    if speed is not None and abs(speed) <= errors * error:
        said.append("its front stands")
    elif speed is not None:
        way = "upstream" if speed * ((jump.get("local") or {}).get("u1") or 1.0) < 0 else "downstream"
        said.append(f"its front moves {way} at {_short(abs(speed))} m/s")
    tail = " and ".join(said)
    name = A_JUMP[jump["verdict"]]
    if jump["verdict"] == "jump":
        name += WITH[tuple(left_out)] + " that still fills the channel" * bool(jump.get("filling"))
    return " ".join(filter(None, (f"{name}.", f"{tail[:1].upper()}{tail[1:]}." if tail else "")))


def _parts(summary: Mapping) -> list[Mapping]:
    found = (summary.get(key) for key in ("jump", "front", "energy"))
    jump, front, energy = (part if isinstance(part, Mapping) else {} for part in found)
    if jump.get("verdict") in A_JUMP:  # a jump is no collapsing column
        return [jump, {}, energy]
    return [{} if _collapsed(front) else jump, front, energy]


def headline(summary: Mapping) -> str:
    """The sentence, from what a summary holds; empty where there is nothing to be said."""
    jump, front, energy = _parts(summary)
    said = [jump.get("headline") or ""]
    said += [_front(front)] if "position" in front else []
    said += [say(summary.get(key) or {}) for key, say in OF_DEVICES.items()]
    if energy.get("conservative") and energy.get("max_deviation") is not None and not any(said):
        said.append(
            f"The energy deviates from that of the start by at most {percent(energy['max_deviation'], 4)}; exact "
            "integration would keep it. The number is exact for this run."
        )
    return " ".join(filter(None, said)).replace("-", "−")


OF_A_STEADY_JUMP = ("length", "head_lost", "head_lost_theory", "local.energy_loss")
"""Numbers that mean nothing where the jump comes and goes, or is still filling up."""
OF_A_JUMP = (*OF_A_STEADY_JUMP, "belanger_y2", "belanger_deviation", "froude", "y1", "y2")
"""Numbers that mean nothing where there is no jump."""


def belongs(key: str, found: Mapping) -> bool:
    """Whether a number of a quantity goes with its verdict: no length of a jump where there is none."""
    verdict = found.get("verdict", "jump")
    if verdict in ("marginal jump", "jump not developed"):
        return key not in OF_A_STEADY_JUMP
    return verdict == "jump" or (key not in OF_A_JUMP and not key.startswith("local."))


def _front(front: Mapping) -> str:
    if front["position"] is None:
        return f"No front to compare: {front.get('reason') or 'none was found'}."
    after = front.get("time")
    speed = f", mean speed {front['speed']:.2f} m/s" if front.get("speed") is not None else ""
    flow = "The discs’" if front.get("column_base") is not None else "Discs flow in; the"
    if _collapsed(front):
        column = f"A column of {front['column_base']:.3g} × {front['column_depth']:.3g} m"
        opens = front.get("gate_open")
        flow = (
            f"{column} collapsed; its"
            if opens is None
            else f"{column} ran out below a gate that rose until {opens:.3g} s; its"
        )
    said = [
        f"{flow} front is at "
        f"{front['position']:.2f} m {'at the last frame' if after is None else f'after {after:.2f} s'}{speed}."
    ]
    if front.get("arrival_time") is not None:
        said.append(f"It met the first obstacle after {front['arrival_time']:.2f} s.")
    water, ritter = front.get("martin_moyce") or {}, front.get("ritter") or {}
    if water.get("mean_bulk") is not None:
        low, high = (100 * bound for bound in DISCS)
        inside = "as discs do" if low <= 100 * water["mean_bulk"] <= high else "unlike discs"
        off = f"{100 * water['mean_bulk']:+.0f} % off Martin & Moyce's water (n² = 2) in the mean"
        said.append(f"It is {off}, {inside} ({low:.0f} to {high:.0f} %).")
    elif water.get("slope_of_table") is not None and water.get("slope") is not None:
        said.append(
            f"Slope dZ/dT {water['slope']:.2f}; Martin & Moyce's water of this shape has {water['slope_of_table']:.2f}."
        )
    elif water:
        said.append(f"No measured curve of water belongs to its shape (n² = {water['aspect']:.2f}; measured: 1 and 2).")
    if water and ritter.get("rms") is not None:
        said.append(f"Ritter's front, until {ritter['valid_until']:.2f} s: RMS difference {percent(ritter['rms'], 0)}.")
    return " ".join([*said, "One run cannot say how sure that is: repeat it from other starts."])
