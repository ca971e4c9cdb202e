# SPDX-License-Identifier: GPL-2.0-or-later
"""The title of a page, the sentences of a screen and the doubts of a run, from its summary."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from lammps_jump.analysis.report.page import percent

from .bodies import BODIES, TAILGATE
from .grains import DRUM, HEAP, INCLINE, OUTLET
from .jump import HYDRAULIC_JUMP
from .kinds import Doubt, Verdict, at, part, shown
from .water import COLLAPSE, IMPACT, OVERTOPPED, RUN_UP, WAVES


def _conserved(summary: Mapping[str, Any]) -> Mapping[str, Any]:
    energy = part(summary, "energy")
    return energy if energy.get("conservative") and energy.get("max_deviation") is not None else {}


def _energy(summary: Mapping[str, Any]) -> str:
    energy = _conserved(summary)
    return f"The energy stays within {percent(energy['max_deviation'])} of that of the start." if energy else ""


def _energy_at_length(summary: Mapping[str, Any]) -> str:
    energy = _conserved(summary)
    return (
        f"The energy deviates from that of the start by at most {percent(energy['max_deviation'], 4)}; exact "
        "integration would keep it. The number is exact for this run."
        if energy
        else ""
    )


def _drifts(summary: Mapping[str, Any]) -> str:
    off = at(summary, "energy.max_deviation")
    return f"it changes by {shown(100 * off)} %: halve run.time_step_fraction" if off is not None and off > 0.02 else ""


ENERGY = Verdict(
    "Does a closed box keep its energy?",
    "The energy stays within 0.9 % of that of the start.",
    ("energy.max_deviation", "energy.drift", "energy.initial"),
    _energy,
    (Doubt("the energy changes by more than 2 %", _drifts),),
    _energy_at_length,
    alone=True,
)


SLOW = 0.01
"""Median speed over √(g d) below which discs are slow."""


def is_foreign(summary: Mapping[str, Any]) -> bool:
    """Tells whether the summary is that of a dump of which no case is known."""
    return "given" in summary and "case_yaml" not in summary


def _size(summary: Mapping[str, Any]) -> str:
    state = part(summary, "state")
    return f"they take {shown(state['length'])} m along x and {shown(state['height'])} m in height"


def _state(summary: Mapping[str, Any]) -> str:
    state = part(summary, "state")
    share = state.get("speed_over_root_gd")
    discs = state.get("discs")
    if not discs:
        return ""
    begin = f"A dump of {discs} discs, of whose scene nothing is known: " if is_foreign(summary) else ""
    if state.get("at_rest"):
        said = f"{discs} discs are at rest; {_size(summary)}."
    elif state.get("speed") is None:
        said = f"how fast the {discs} discs move is not known; {_size(summary)}."
    elif share is not None and share < SLOW:
        said = f"{discs} discs are slow, {shown(state['speed'])} m/s in the median; {_size(summary)}."
    elif summary.get("gravity") == 0 or state.get("at_rest") is None:
        said = f"{discs} discs move at {shown(state['speed'])} m/s, the median of their speeds at the end."
    else:
        said = f"{discs} discs still move, at {shown(state['speed'])} m/s in the median; {_size(summary)}."
    said = said.replace(f"{discs} discs", "they", 1) if begin else said
    return begin + said if begin else f"{said[:1].upper()}{said[1:]}"


def _falls_on(summary: Mapping[str, Any]) -> str:
    state = part(summary, "state")
    share = state.get("speed_over_root_gd")
    if state.get("at_rest") or share is None or share >= SLOW:
        return ""
    return "the discs are slow, and have not rested for 20 √(d/g) yet: run longer"


def _lost(summary: Mapping[str, Any]) -> str:
    state = part(summary, "state")
    first, last = state.get("first_discs") or 0, state.get("discs") or 0
    return f"{first - last} of {first} discs have left" if last < first else ""


def _untold(summary: Mapping[str, Any]) -> str:
    return (
        "walls, inflow and the way of contacts are not in a dump: give the case with --case, or ask for what is there"
        if is_foreign(summary)
        else ""
    )


DISCS = Verdict(
    "What do the discs do, where nothing else is asked or known?",
    "812 discs are at rest; they take 2.0 m along x and 0.41 m in height.",
    ("state.discs", "state.speed", "state.at_rest", "state.length", "state.height"),
    _state,
    (
        Doubt("the discs are slow and do not rest", _falls_on),
        Doubt("discs have left", _lost),
        Doubt("a dump of which nothing is known", _untold),
    ),
    alone=True,
)


VERDICTS = (
    OUTLET,
    HEAP,
    DRUM,
    INCLINE,
    TAILGATE,
    HYDRAULIC_JUMP,
    BODIES,
    WAVES,
    COLLAPSE,
    RUN_UP,
    OVERTOPPED,
    IMPACT,
    ENERGY,
    DISCS,
)
"""In the order in which they claim the title. Pages, screens and the table of the site are made from it."""
TOGETHER = 2
"""Answers of one title."""
STATUS = {"failed": "The run failed.", "interrupted": "The run was interrupted.", "running": "The run goes on."}
"""Titles of runs that did not end."""


def answered(summary: Mapping[str, Any]) -> list[tuple[str, int]]:
    """Titles and numbers of the verdicts that answer, in their order."""
    titles: list[tuple[str, int]] = []
    for number, verdict in enumerate(VERDICTS):
        said = "" if titles and verdict.alone else verdict.title(summary)
        if said:
            titles.append((said, number))
            if verdict.closes or verdict.alone:
                break
    return titles


def verdict(summary: Mapping[str, Any]) -> str:
    """One or two short sentences on what happened, the title of a report; empty where there is nothing to be said.

    `summary` is that of a run, or of starts of one case, as of `tables.together`.
    """
    status = summary.get("status") or "complete"
    if status != "complete":
        return STATUS.get(status, f"The run is {status}.")
    return _signed(" ".join(said for said, _ in answered(summary)[:TOGETHER]))


def headline(summary: Mapping[str, Any]) -> str:
    """The sentences at length, from what a summary holds; empty where there is nothing to be said."""
    said = [VERDICTS[number].said(summary) for _, number in answered(summary)]
    if not said and "position" in (summary.get("front") or {}):
        said = [COLLAPSE.said(summary)]
    return _signed(" ".join(filter(None, said)))


def doubts(summary: Mapping[str, Any]) -> list[str]:
    """Doubts about the answers of the title in this run, as sentences."""
    if (summary.get("status") or "complete") != "complete":
        return []
    shown = {number for _, number in answered(summary)[:TOGETHER]}
    sentences = [
        text
        for number, one in enumerate(VERDICTS)
        if number in shown or not one.title(summary)
        for text in one.doubted(summary)
    ]
    return [_signed(f"{text[:1].upper()}{text[1:].rstrip('.')}.") for text in dict.fromkeys(sentences)]


def _signed(text: str) -> str:
    return re.sub(r"(?<![\w.-])-(?=[\d.])", "\N{MINUS SIGN}", text)
