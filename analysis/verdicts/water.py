# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts on water that is not a jump: a column that collapses, waves, run-up and overtopping, impact on a wall."""

# ruff: noqa: RUF001  (minus signs and quotation marks are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import Any

from lammps_jump.analysis.report.page import percent
from lammps_jump.analysis.verdicts.kinds import DISCS, against_water
from lammps_jump.physics.jump import GRAVITY

from .kinds import Doubt, Verdict, asked_of_a_dump, at, below, part, place, shown

CREEPS = 0.02
"""Share of √(g H) of a column below which its front creeps."""
ONE_WAY = 0.7
"""Share of the mean speed that the mean velocity has where discs run as a stream."""

MANY_OVER = 100
"""Discs over a crest from which on their volume is the answer, and no run-up."""
RUNNING = 0.2
"""Momentum flux of what comes over the largest thrust of water at rest from which on water runs against a wall."""


def collapsed(front: Mapping[str, Any]) -> bool:
    """Tells whether there was a column at the start, whose front then ran."""
    return front.get("column_base") is not None and front.get("speed") is not None


def has_front(summary: Mapping[str, Any]) -> bool:
    """Tells whether page and screen show the front: a case requested it; in a dump a column fell, or a stream runs."""
    front = part(summary, "front")
    if front.get("position") is None:
        return False
    if collapsed(front) or asked_of_a_dump("front", summary) or "state" not in summary:
        return True
    along, speed = at(summary, "state.along"), at(summary, "state.mean_speed")
    return along is not None and speed is not None and abs(along) > ONE_WAY * speed


def ritter_holds(front: Mapping[str, Any]) -> bool:
    """Tells whether Ritter's front holds as long as the mean speed is taken: up to the first obstacle, or the end."""
    until = (front.get("ritter") or {}).get("valid_until")
    end = front.get("arrival_time") if front.get("arrival_time") is not None else front.get("time")
    return against_water(front) and until is not None and end is not None and end <= until


def _collapse(summary: Mapping[str, Any]) -> str:
    front = part(summary, "front")
    if not has_front(summary) or part(summary, "heap").get("run_out_over_base") is not None:  # reported by the heap
        return ""
    if not collapsed(front):
        after = "" if front.get("time") is None else f" after {front['time']:z.3g} s"
        return f"The front of the discs is at {front['position']:z.3g} m{after}."
    ritter = ritter_holds(front) and (front.get("ritter") or {}).get("front_speed")
    more = f"; Ritter’s would run at {shown(ritter)} m/s" if ritter else ""
    arrival = front.get("arrival_time")
    more = f" and meets the obstacle after {shown(arrival)} s" if arrival is not None else more
    opens = front.get("gate_open")
    what = f"The gate opens in {shown(opens)} s: the" if opens is not None else "A column collapses: its"
    slow = front["speed"] < CREEPS * sqrt(GRAVITY * (front.get("column_depth") or 0.0))
    return f"{what} front {'creeps' if slow else 'runs'} at {shown(front['speed'])} m/s{more}."


def _collapse_at_length(summary: Mapping[str, Any]) -> str:
    front = part(summary, "front")
    if "position" not in front:
        return ""
    if front["position"] is None:
        return "" if "given" in summary else f"No front to compare: {front.get('reason') or 'none was found'}."
    if not has_front(summary):
        return ""
    after = front.get("time")
    speed = f", mean speed {front['speed']:z.2f} m/s" if front.get("speed") is not None else ""
    flow, of = "The", " of the discs"
    if collapsed(front):
        of = ""
        column = f"A column of {front['column_base']:z.3g} × {front['column_depth']:z.3g} m"
        opens = front.get("gate_open")
        flow = (
            f"{column} collapsed; its"
            if opens is None
            else f"{column} ran out below a gate that rose until {opens:z.3g} s; its"
        )
    when = "at the last frame" if after is None else f"after {after:z.2f} s"
    arrival = front.get("arrival_time")
    said = [f"{flow} front{of} is at {front['position']:z.2f} m {when}{speed}."]
    if arrival is not None and collapsed(front):  # where it is at the end tells where the obstacle is
        said = [f"{flow} front ran at {front['speed']:z.2f} m/s and met the first obstacle after {arrival:z.2f} s."]
    elif arrival is not None:
        said.append(f"It met the first obstacle after {arrival:z.2f} s.")
    said += _against_water(front)
    return " ".join([*said, "One run cannot say how sure that is: repeat it from other starts."])


def _against_water(front: Mapping[str, Any]) -> list[str]:
    said = []
    water, ritter = front.get("martin_moyce") or {}, front.get("ritter") or {}
    if water.get("mean_bulk") is not None:
        low, high = (100 * bound for bound in DISCS)
        inside = "as discs do" if low <= 100 * water["mean_bulk"] <= high else "unlike discs"
        off = f"{100 * water['mean_bulk']:+z.0f} % off Martin & Moyce's water in the mean"
        said.append(f"It is {off} (a column twice as high as wide), {inside} ({low:z.0f} to {high:z.0f} %).")
    elif water.get("slope_of_table") is not None and water.get("slope") is not None:
        of_table = f"{water['slope_of_table']:z.2f}"
        said.append(f"Slope dZ/dT {water['slope']:z.2f}; Martin & Moyce's water of this shape has {of_table}.")
    elif water:
        said.append(
            f"No measured curve of water belongs to it: it is {water['aspect']:z.2g} times as high as wide; "
            "measured are columns as high as wide, and twice as high."
        )
    if water and ritter.get("rms") is not None:
        said.append(
            f"Ritter's front, until {ritter['valid_until']:z.2f} s: RMS difference {percent(ritter['rms'], 0)}."
        )
    return said


def _lone_discs(summary: Mapping[str, Any]) -> str:
    bulk, far, base = (at(summary, f"front.{key}") for key in ("position", "position_99", "column_base"))
    if bulk is None or far is None or base is None or abs(far - bulk) <= 0.25 * max(abs(bulk), base):
        return ""
    return f"bulk and 99 % of the discs end at different places, {place(bulk)} and {place(far)} m"


def _front_stopped(summary: Mapping[str, Any]) -> str:
    front = part(summary, "front")
    stop = front.get("stopped_by") if front.get("arrival_time") is None else None  # an arrival is reported as one
    return f"the front has come to {stop} at the end: it would go further" if stop else ""


def _slow_gate(summary: Mapping[str, Any]) -> str:
    opens = at(summary, "front.gate_open")
    return f"the gate takes {shown(opens)} s to open: no closed form belongs to it" if opens is not None else ""


COLLAPSE = Verdict(
    "How fast does a column collapse, and when does it arrive?",
    "A column collapses: its front runs at 3.6 m/s and meets the obstacle after 1.9 s.",
    ("front.position", "front.speed", "front.arrival_time", "front.ritter", "front.martin_moyce"),
    _collapse,
    (
        Doubt("the bulk and 99 % of the discs end at places a quarter apart", _lone_discs),
        Doubt("a gate takes its time to open", _slow_gate),
        Doubt("the front touches a wall, an outlet or the end of the domain at the end", _front_stopped),
    ),
    _collapse_at_length,
)


def _waves(summary: Mapping[str, Any]) -> str:
    waves = part(summary, "waves")
    if waves.get("height") is None:
        return ""
    pairs = list(zip(waves["gauges"], waves["heights"], strict=True))
    last = f" and {pairs[-1][1]:z.2f} m at x = {pairs[-1][0]:zg} m" if len(pairs) > 1 else ""
    return f"Waves of {shown(waves['period'])} s are {pairs[0][1]:z.2f} m high at x = {pairs[0][0]:zg} m{last}."


def _die_out(summary: Mapping[str, Any]) -> str:
    first, last = at(summary, "waves.height"), at(summary, "waves.height_last")
    if not first or last is None or last >= 0.5 * first:
        return ""
    lost = 100 * (1 - last / first)
    return f"the waves lose {lost:z.0f} % of their height between the gauges: discs lose energy as water does not"


WAVES = Verdict(
    "How high are the waves of a paddle?",
    "Waves of 4.0 s are 0.59 m high at x = 4.5 m and 0.20 m at x = 12 m.",
    ("waves.period", "waves.height", "waves.height_last", "waves.height_piston"),
    _waves,
    (
        Doubt(
            "the window holds fewer than three periods", below("waves.periods", 3, "the window holds {} periods only")
        ),
        Doubt("the waves lose half of their height between the gauges", _die_out),
    ),
)


def _run_up(summary: Mapping[str, Any]) -> str:
    runup = part(summary, "runup")
    on = f"{runup['wall']}" if runup.get("wall") else "the slope"
    still, over, crest = runup.get("run_up"), runup.get("over") or 0.0, runup.get("crest")
    if crest is None or (runup.get("highest") is None and not over):
        return ""
    if over and (runup.get("highest") is None or runup["highest"] <= crest):
        return _goes_over(runup, on)
    above_still = f", {shown(still)} m over the still water" if still is not None else ""
    tail = f"{shown(over)} m² go over the crest at y = {place(crest)} m"
    tail += " by the end, and more comes" if runup.get("still_passes") else ""
    if not over:
        tail = f"nothing goes over the crest at y = {place(crest)} m"
    return f"The water reaches y = {place(runup['highest'])} m on {on}{above_still}; {tail}."


def _goes_over(overtopping: Mapping[str, Any], on: str) -> str:
    """Sentence on what goes over a crest, where there is no run-up."""
    total, crest = f"{shown(overtopping['over'])} m²", place(overtopping["crest"])
    if overtopping.get("discharge") is None:
        return f"{total} of water go over {on}, whose crest is at y = {crest} m."
    head = f" under a head of {shown(overtopping['head'])} m" if overtopping.get("head") is not None else ""
    rate = shown(overtopping["discharge"])
    return f"{rate} m²/s of water go over {on}{head} in the mean, {total} in all; its crest is at y = {crest} m."


def _to_the_crest(summary: Mapping[str, Any]) -> str:
    runup = part(summary, "runup")
    if not runup.get("reaches_crest") or (runup.get("freeboard") is not None and runup["freeboard"] <= 0):
        return ""
    if (runup.get("over_discs") or 0) >= MANY_OVER:  # it is overtopped, and nobody asks for a run-up
        return ""
    return "the water reaches the crest: a higher slope or wall would show a higher run-up"


def _few_over(summary: Mapping[str, Any]) -> str:
    discs = at(summary, "runup.over_discs")
    if not discs or discs >= MANY_OVER:
        return ""
    return f"{discs} discs make the volume over the crest, which scatters by {100 / discs**0.5:z.0f} % at least"


RUN_UP = Verdict(
    "How high does a wave run up, and how much goes over?",
    "The water reaches y = 1.9 m on seawall, 1.0 m over the still water; nothing goes over the crest at y = 2.5 m.",
    (
        "runup.highest",
        "runup.run_up",
        "runup.still",
        "runup.freeboard",
        "runup.over",
        "runup.over_discs",
        "runup.discharge",
        "runup.head",
    ),
    _run_up,
    (
        Doubt("the water reaches the crest, where fewer than 100 discs go over: a lower bound", _to_the_crest),
        Doubt("fewer than 100 discs go over", _few_over),
        Doubt(
            "the run-up is less than three diameters",
            below("runup.diameters", 3.0, "the run-up is {} diameters, and the surface is known to about one"),
        ),
    ),
)


def struck(summary: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
    """Name and force of the probed wall that water runs against: that of the run-up, else that with the largest peak.

    An upright face towards a flow has an oncoming momentum; floors and walls that move have none. Water at rest before
    a wall does not run against it. The name is empty where there is no such wall.
    """
    walls = {name: one for name, one in part(summary, "force").items() if isinstance(one, Mapping) and "peak" in one}
    known = [pair for pair in walls.items() if None not in (pair[1]["peak"], pair[1].get("stagnation"))]
    climbed = part(summary, "runup").get("wall")
    known = [pair for pair in known if pair[0] == climbed] or [pair for pair in known if runs_against(pair[1])]
    return max(known, key=lambda pair: abs(pair[1]["peak"]), default=("", {}))


def runs_against(force: Mapping[str, Any]) -> bool:
    """Tells whether discs bring momentum besides the thrust of the deepest water; what climbs the wall is that deep."""
    return (force.get("oncoming_flux") or 0.0) > RUNNING * (force.get("hydrostatic") or 0.0)


def _impact(summary: Mapping[str, Any]) -> str:
    name, force = struck(summary)
    if not name or "inflow" in summary or summary.get("friction_law"):
        return ""
    if not force["peak"]:
        return f"Nothing pushes {name}."
    along = {"fx": " along x", "fy": " along y"}.get(force.get("component") or "", "")
    when = f", at t = {force['peak_time']:z.2f} s" if force.get("peak_time") is not None else ""
    return f"The discs push {name} with {shown(abs(force['peak']) / 1e3)} kN/m{along} at most{when}."


def _spike(summary: Mapping[str, Any]) -> str:
    _, force = struck(summary)
    raw, peak = force.get("peak_unfiltered"), force.get("peak")
    if not raw or not peak or abs(raw) <= 1.5 * abs(peak):
        return ""
    return f"without low-pass the peak is {shown(abs(raw / peak))} times as high: single discs strike the wall"


def _unbalanced(summary: Mapping[str, Any]) -> str:
    identities = part(summary, "force").get("identity") or {}
    off = [one["relative"] for one in identities.values() if one.get("complete") and one.get("relative") is not None]
    if max(off, default=0.0) <= 0.05:
        return ""
    return f"the impulses of walls and gravity miss the momentum of the discs by {shown(100 * max(off))} %"


def _overtopped(summary: Mapping[str, Any]) -> str:
    """Sentence on what goes over weirs and below gates; the run-up tells of its own wall."""
    if _run_up(summary):
        return ""
    said = []
    for name, one in part(summary, "overtopping").items():
        for key, where, head in (("discharge", "over", "head"), ("below", "below", "below_head")):
            if one.get(key) is not None:
                under = f" under a head of {shown(one[head])} m" if one.get(head) is not None else ""
                said.append(f"{shown(one[key])} m²/s go {where} {name}{under}")
    return f"{'; '.join(said)}." if said else ""


def _few_pass(summary: Mapping[str, Any]) -> str:
    """Structures over which few discs have gone."""
    sentences = [
        f"{one['discs']} discs make what goes over {name}"
        for name, one in part(summary, "overtopping").items()
        if one.get("discharge") is not None and (one.get("discs") or 0) < MANY_OVER
    ]
    return "; ".join(sentences)


OVERTOPPED = Verdict(
    "How much goes over a weir or below a gate, and under which head?",
    "0.42 m²/s go over weir under a head of 0.51 m.",
    ("overtopping.<structure>.discharge", "overtopping.<structure>.head", "overtopping.<structure>.below"),
    _overtopped,
    (Doubt("fewer than 100 discs go over", _few_pass),),
)


IMPACT = Verdict(
    "How hard do discs strike a wall?",
    "The discs push seawall with 4.7 kN/m along x at most, at t = 5.41 s.",
    ("force.<wall>.peak", "force.<wall>.peak_time", "force.<wall>.peak_unfiltered", "force.<wall>.impulse"),
    _impact,
    (
        Doubt("the peak without low-pass is more than half higher", _spike),
        Doubt("impulses and momentum differ by more than 5 %", _unbalanced),
    ),
)
