# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdict on tailgates: the height of the crest, and what it holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lammps_jump import units

from .kinds import Doubt, Verdict, part, place, shown

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
        asked = f"{gate['target']:zg} m is asked for"
        return f"The gate {name} stands with its crest at {crest} and {_held(gate)}{_often(gate)}, where {asked}"
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
    found = []
    for name, gate in _gates(summary):
        same, starts = gate.get("alike") or (1, 1)
        if gate.get("settled_at") is None and gate.get("reason"):
            found.append(f"the gate {name} has not settled{_often(gate)}: {gate['reason']}")
        elif same < starts:
            other = "not settled" if gate.get("settled_at") is not None else "settled"
            found.append(f"the gate {name} has {other} in {starts - same} of {starts} starts")
    return "; ".join(found)


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
