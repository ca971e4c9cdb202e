# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdict on tailgates: the height that holds what the case asks for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .kinds import Doubt, Verdict, part, shown

ROUGH = 0.1
"""Interval of the height over the height, above which it is called rough."""


def _gates(summary: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Gates that have found a height, by name."""
    for name, gate in part(summary, "tailgate").items():
        if isinstance(gate, Mapping) and gate.get("height") is not None:
            yield name, gate


def _height(summary: Mapping[str, Any]) -> str:
    said = []
    for name, gate in _gates(summary):
        error = gate.get("height_interval")
        height = f"{gate['height']:z.2f}" + ("" if error is None else f" ± {error:z.2f}")
        said.append(f"The gate {name} holds with its crest at y = {height} m")
    return ". ".join(said) + "." if said else ""


def _rough(summary: Mapping[str, Any]) -> str:
    return "; ".join(
        f"the height of {name} is known to ± {shown(gate['height_interval'])} m only: run longer"
        for name, gate in _gates(summary)
        if (gate.get("height_interval") or 0.0) > ROUGH * abs(gate["height"])
    )


TAILGATE = Verdict(
    "How high must the sill be?",
    "The gate sill holds with its crest at y = 1.79 ± 0.03 m.",
    ("tailgate.<wall>.height", "tailgate.<wall>.height_interval", "tailgate.<wall>.settled_at"),
    _height,
    (Doubt("the height is known to no better than a tenth", _rough),),
)
