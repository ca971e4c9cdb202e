# SPDX-License-Identifier: GPL-2.0-or-later
"""The title of a page, the sentences of a screen and the doubts of a run, from its summary."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from .bodies import BODIES
from .gates import TAILGATE
from .grains import DRUM, HEAP, INCLINE, OUTLET
from .jump import HYDRAULIC_JUMP
from .plain import DISCS, ENERGY
from .water import COLLAPSE, IMPACT, RUN_UP, WAVES

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
    found: list[tuple[str, int]] = []
    for number, verdict in enumerate(VERDICTS):
        said = "" if found and verdict.alone else verdict.title(summary)
        if said:
            found.append((said, number))
            if verdict.closes or verdict.alone:
                break
    return found


def verdict(summary: Mapping[str, Any]) -> str:
    """One or two short sentences on what happened, the title of a report; empty where there is nothing to be said.

    `summary` is that of a run, or of starts of one case, as of `rows.together`.
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
    found = [
        text
        for number, one in enumerate(VERDICTS)
        if number in shown or not one.title(summary)
        for text in one.doubted(summary)
    ]
    return [_signed(f"{text[:1].upper()}{text[1:].rstrip('.')}.") for text in dict.fromkeys(found)]


def _signed(text: str) -> str:
    return re.sub(r"(?<![\w.-])-(?=[\d.])", "\N{MINUS SIGN}", text)
