# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts of a jump in words, and which numbers go with which verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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
DISCS = (-0.2, 0.0)
"""Mean difference of fronts of frictionless discs from Martin & Moyce's water, five starts (docs/theory.md)."""


FELL = 0.01
"""Run-out over base from which on a column has fallen: a bed that lies as it lay is none."""


def against_water(front: Mapping[str, Any]) -> bool:
    """Tells whether the case asks for a comparison with water: ``analysis.front: water``."""
    return bool(front.get("martin_moyce"))


OF_A_STEADY_JUMP = ("length", "head_lost", "head_lost_theory", "local.energy_loss")
"""Numbers that mean nothing where the jump comes and goes, or is still filling up."""
OF_A_JUMP = (*OF_A_STEADY_JUMP, "belanger_y2", "belanger_deviation", "froude", "y1", "y2")
"""Numbers that mean nothing where there is no jump."""


def applies(key: str, verdict: str) -> bool:
    """Tells whether a number of a jump goes with what was found: no length of a jump where there is none."""
    if verdict in ("marginal jump", "jump not developed"):
        return key not in OF_A_STEADY_JUMP
    return verdict == "jump" or (key not in OF_A_JUMP and not key.startswith("local."))
