# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdict on bodies that move freely: which float, slide, tip, turn or rest, and how far each came."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any

from .kinds import Doubt, Verdict, part, shown

MOST = 2
"""Bodies of which the title tells."""
STOOD, LEVEL = 0.01, 0.1
"""Radii of gyration and degrees below which a body has stood: it sinks so far into what carries it."""
OFF = 0.1
"""Share by which a draught may lie off that by weight."""


def _told(summary: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Bodies of which something is known, by name; those that came farthest first."""
    found = [(name, body) for name, body in part(summary, "bodies").items() if isinstance(body, Mapping)]
    known = [(name, body) for name, body in found if body.get("largest_displacement") is not None]
    yield from sorted(known, key=lambda item: -item[1]["largest_displacement"])


def _one(name: str, body: Mapping[str, Any]) -> str:
    """What one body did."""
    if body.get("floats") and body.get("draught") is not None:
        error = body.get("draught_interval")
        off = "" if error is None else f" ± {error:z.2f}"
        return f"The body {name} floats with a draught of {body['draught']:z.2f}{off} m"
    way = abs(body["end_x"] - body["start_x"])
    since = f", and rests from {body['rest_since']:z.1f} s on" if body.get("rest") else ""
    if body.get("tips_at") is not None and not _earlier(body, "slides_at", "tips_at"):
        return f"The body {name} tips at {body['tips_at']:z.1f} s{since}"
    if body.get("slides_at") is not None:
        return f"The body {name} slides {way:z.2f} m from {body['slides_at']:z.1f} s on" + since.replace(" on", "")
    if body["largest_displacement"] < STOOD * sqrt(body["inertia"] / body["mass"]) and body["largest_turn"] < LEVEL:
        return f"The body {name} stands"
    turned = f" and turns by up to {body['largest_turn']:z.0f} degrees" if body["largest_turn"] >= 1 else ""
    return f"The body {name} comes {body['largest_displacement']:z.2f} m far{turned}{since}"


def _earlier(body: Mapping[str, Any], one: str, other: str) -> bool:
    """Whether one time is known and before another."""
    return body.get(one) is not None and body[one] < body[other]


def _title(summary: Mapping[str, Any]) -> str:
    told = list(_told(summary))
    said = [_one(name, body) for name, body in told[:MOST]]
    more = f" The report tells of {len(told)} bodies." if len(told) > MOST else ""
    return ". ".join(said) + "." + more if said else ""


def _still_moves(summary: Mapping[str, Any]) -> str:
    moving = [name for name, body in _told(summary) if not body.get("rest") and not body.get("floats")]
    names = ", ".join(moving[:4]) + (f" and {len(moving) - 4} more" if len(moving) > 4 else "")
    return f"{names} still move{'s' if len(moving) == 1 else ''} at the end: run longer" if moving else ""


def _not_by_weight(summary: Mapping[str, Any]) -> str:
    off = [
        f"the draught of {name} is {shown(body['draught'])} m, that by its weight {shown(body['draught_by_weight'])} "
        "m: discs at rest carry a body before it has sunk that far"
        for name, body in _told(summary)
        if body.get("floats") and body.get("draught_by_weight")
        and abs(body["draught"] / body["draught_by_weight"] - 1) > OFF
    ]  # fmt: skip
    return "; ".join(off)


BODIES = Verdict(
    "What do the bodies do?",
    "The body caisson slides 1.37 m from 1.8 s on, and rests from 6.6 s.",
    (
        "bodies.<body>.largest_displacement", "bodies.<body>.largest_turn", "bodies.<body>.rest_since",
        "bodies.<body>.slides_at", "bodies.<body>.tips_at", "bodies.<body>.draught",
    ),
    _title,
    (
        Doubt("a body still moves at the end", _still_moves),
        Doubt("a draught lies more than a tenth off that by the weight of the body", _not_by_weight),
    ),
)  # fmt: skip
