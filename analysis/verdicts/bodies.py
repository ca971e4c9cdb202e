# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts on structures: which bodies float, slide, tip, turn or rest and how far; where a tailgate holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any

from lammps_jump import units

from .kinds import Doubt, Said, Verdict, part, place, shown

MOST = 2
"""Bodies of which the title tells."""
STOOD, LEVEL = 0.01, 0.1
"""Radii of gyration and degrees below which a body has not moved: it sinks so far into what carries it."""
OFF = 0.1
"""Share by which a draught may lie off that by weight."""


def farthest_first(summary: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Bodies of which something is known, by name; those that came farthest first."""
    bodies_named = [(name, body) for name, body in part(summary, "bodies").items() if isinstance(body, Mapping)]
    known = [(name, body) for name, body in bodies_named if body.get("largest_displacement") is not None]
    yield from sorted(known, key=lambda item: -item[1]["largest_displacement"])


def _one(name: str, body: Mapping[str, Any]) -> str:
    """Sentence on one body: how it is at the end, and what happened before."""
    many = body.get("alike")
    often = f" in {many[0]} of {many[1]} starts" if many else ""
    since = f"rests from {body['rest_since']:z.1f} s on" if body.get("rest") else ""
    if body.get("state") in SAID:
        said = SAID[body["state"]](body)
        sentences = _events(body)
        sentences += [since] * bool(since and sentences)  # what has only stood or floats has rested all the time
        ways = _ways(body) if body["state"] in ("lies", "leans") else ""
        return f"The body {name} {said}{often}" + (f": it {_listed(sentences)}" if sentences else "") + ways
    turned = f" and turns by up to {body['largest_turn']:z.0f} degrees" if body["largest_turn"] >= 1 else ""
    if body["largest_displacement"] < STOOD * sqrt(body["inertia"] / body["mass"]) and body["largest_turn"] < LEVEL:
        return f"The body {name} stands"
    rests = f", and {since}" if since else ""
    return f"The body {name} comes {body['largest_displacement']:z.2f} m far{turned}{rests}"


def _afloat(body: Mapping[str, Any]) -> str:
    draught, error = body.get("draught"), body.get("draught_interval")
    if draught is None:
        return "is afloat"
    return f"floats with a draught of {draught:z.2f}{'' if error is None else f' ± {error:z.2f}'} m"


def _ways(body: Mapping[str, Any]) -> str:
    """Sentence on how far base and centre of mass have come."""
    base, centre = body.get("base_way"), body.get("centre_way")
    known = base is not None and centre is not None
    return f". Its base came {base:z.2f} m far, its centre of mass {centre:z.2f} m" if known else ""


SIDES = {"right": "its right side", "left": "its left side", "top": "its top", "base": "another face of its underside"}
SAID: Mapping[str, Said] = {
    "stands": lambda body: "stands",
    "slid": lambda body: f"has slid by {abs(body['slid_by']):z.2f} m",
    "leans": lambda body: f"leans to the {body['side']} by {abs(body['lean']):z.0f} degrees",
    "lies": lambda body: f"has toppled and lies on {SIDES[body['side']]}",
    "afloat": _afloat,
    "left": lambda body: "has left",
}
"""Words of the title for each state."""
EVENTS = {"slides_at": "slides from {:z.1f} s on", "tips_at": "tips at {:z.1f} s", "falls_at": "falls at {:z.1f} s"}
STATES = {"lies": "lies from {:z.1f} s on", "leans": "leans from {:z.1f} s on", "left": "leaves at {:z.1f} s"}


def _events(body: Mapping[str, Any]) -> list[str]:
    """Events of a body, in their order."""
    if body.get("state") == "afloat":
        return []
    times_of_events = [(body[key], words) for key, words in EVENTS.items() if body.get(key) is not None]
    if body.get("state_since") is not None and body["state"] in STATES:
        times_of_events.append((body["state_since"], STATES[body["state"]]))
    return [words.format(time) for time, words in sorted(times_of_events, key=lambda one: one[0])]


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def _title(summary: Mapping[str, Any]) -> str:
    bodies_named = list(farthest_first(summary))
    said = [_one(name, body) for name, body in bodies_named[:MOST]]
    more = f" The report tells of {len(bodies_named)} bodies." if len(bodies_named) > MOST else ""
    return ". ".join(said) + "." + more if said else ""


def _still_moves(summary: Mapping[str, Any]) -> str:
    moving = [name for name, body in farthest_first(summary) if not body.get("rest") and not body.get("floats")]
    names = ", ".join(moving[:4]) + (f" and {len(moving) - 4} more" if len(moving) > 4 else "")
    return f"{names} still move{'s' if len(moving) == 1 else ''} at the end: run longer" if moving else ""


def _not_by_weight(summary: Mapping[str, Any]) -> str:
    off = [
        f"the draught of {name} is {shown(body['draught'])} m, that by its weight {shown(body['draught_by_weight'])} "
        "m: discs at rest carry a body before it has sunk that far"
        for name, body in farthest_first(summary)
        if body.get("floats") and body.get("draught_by_weight")
        and abs(body["draught"] / body["draught_by_weight"] - 1) > OFF
    ]  # fmt: skip
    return "; ".join(off)


BODIES = Verdict(
    "What do the bodies do?",
    "The body caisson has slid by 1.37 m: it slides from 1.8 s on and rests from 6.6 s on.",
    (
        "bodies.<body>.state", "bodies.<body>.slid_by", "bodies.<body>.base_way", "bodies.<body>.centre_way",
        "bodies.<body>.lean", "bodies.<body>.slides_at", "bodies.<body>.tips_at", "bodies.<body>.falls_at",
        "bodies.<body>.state_since", "bodies.<body>.rest_since", "bodies.<body>.draught",
        "bodies.<body>.largest_displacement", "bodies.<body>.largest_turn",
    ),
    _title,
    (
        Doubt("a body still moves at the end", _still_moves),
        Doubt("a draught lies more than a tenth off that by the weight of the body", _not_by_weight),
    ),
)  # fmt: skip


ROUGH = 0.1
"""Interval of the height over the height, above which it is called rough."""


def _gates(summary: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Gates by name."""
    return ((name, gate) for name, gate in part(summary, "tailgate").items() if isinstance(gate, Mapping))


def _sure(gate: Mapping[str, Any], key: str) -> float | None:
    """Half of the 95 % interval of a number, over starts where there are some, else within the run."""
    return gate.get(f"{key}_error") or gate.get(f"{key}_interval")


def _number(gate: Mapping[str, Any], key: str) -> str:
    """A number in m with its interval."""
    return units.shown(gate[key], "m", _sure(gate, key), digits=3)


def _held(gate: Mapping[str, Any]) -> str:
    """Quantity that a gate holds, in words; an older run does not say which of the two it is."""
    what = {"front": "the front at x = {}", "depth": "a mass depth of {}"}.get(gate.get("holds") or "", "{}")
    return what.format(_number(gate, "held"))


def _often(gate: Mapping[str, Any]) -> str:
    """In how many starts it is as said, of a gate of several."""
    many = gate.get("alike")
    return f" in {many[0]} of {many[1]} starts" if many else ""


def _answer(name: str, gate: Mapping[str, Any]) -> str:
    if gate.get("height") is None:
        return f"The gate {name} has found no height{_often(gate)}"
    crest = f"y = {_number(gate, 'height')}"
    if gate.get("settled_at") is None:
        request = f"{gate['target']:zg} m is asked for"
        return f"The gate {name} stands with its crest at {crest} and {_held(gate)}{_often(gate)}, where {request}"
    return f"The gate {name} holds {_held(gate)} with its crest at {crest}{_often(gate)}"


def _height(summary: Mapping[str, Any]) -> str:
    said = [_answer(name, gate) for name, gate in _gates(summary)]
    return ". ".join(said) + "." if said else ""


def _at_length(summary: Mapping[str, Any]) -> str:
    said = []
    for name, gate in _gates(summary):
        said.append(_answer(name, gate))
        if gate.get("settled_at") is not None:
            mean = " in the mean" if _often(gate) else ""
            said[-1] += f"; it has settled at {place(gate['settled_at'])} s{mean}"
        if gate.get("water") is not None:
            said.append(f"Water would need a crest at y = {place(gate['water'])} m, by energy without loss")
    return ". ".join(said) + "." if said else ""


def _rough(summary: Mapping[str, Any]) -> str:
    return "; ".join(
        f"the height of {name} is known to ± {shown(half)} m only: run longer"
        for name, gate in _gates(summary)
        if gate.get("height") is not None and (half := _sure(gate, "height") or 0.0) > ROUGH * abs(gate["height"])
    )


def _unsettled(summary: Mapping[str, Any]) -> str:
    reasons = []
    for name, gate in _gates(summary):
        same, starts = gate.get("alike") or (1, 1)
        if gate.get("settled_at") is None and gate.get("reason"):
            reasons.append(f"the gate {name} has not settled{_often(gate)}: {gate['reason']}")
        elif same < starts:
            other = "not settled" if gate.get("settled_at") is not None else "settled"
            reasons.append(f"the gate {name} has {other} in {starts - same} of {starts} starts")
    return "; ".join(reasons)


TAILGATE = Verdict(
    "How high must the sill be?",
    "The gate sill holds the front at x = 30.02 ± 0.11 m with its crest at y = 1.793 ± 0.031 m.",
    tuple(
        f"tailgate.<wall>.{key}"
        for key in ("height", "height_interval", "held", "held_interval", "target", "settled_at", "water")
    ),
    _height,
    (
        Doubt("a gate has not settled: what it holds is not at its target within its interval", _unsettled),
        Doubt("the height is known to no better than a tenth", _rough),
    ),
    _at_length,
)
