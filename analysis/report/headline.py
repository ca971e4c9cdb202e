# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts of a jump in words, what is compared with theory, and which numbers go with which verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

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


def against_water(front: Mapping) -> bool:
    """Whether the case asks for a comparison with water: ``analysis.front: water``."""
    return bool(front.get("martin_moyce"))


OF_A_STEADY_JUMP = ("length", "head_lost", "head_lost_theory", "local.energy_loss")
"""Numbers that mean nothing where the jump comes and goes, or is still filling up."""
OF_A_JUMP = (*OF_A_STEADY_JUMP, "belanger_y2", "belanger_deviation", "froude", "y1", "y2")
"""Numbers that mean nothing where there is no jump."""


OF_A_CLOSED_BOX = {"max_deviation", "drift"}
"""Errors of the engine, where nothing dissipates and no disc comes or goes."""


def belongs(key: str, found: Mapping) -> bool:
    """Whether a number of a quantity goes with what was found: no length of a jump where there is none."""
    if key in OF_A_CLOSED_BOX and found.get("conservative") is False:
        return False
    verdict = found.get("verdict", "jump")
    if verdict in ("marginal jump", "jump not developed"):
        return key not in OF_A_STEADY_JUMP
    return verdict == "jump" or (key not in OF_A_JUMP and not key.startswith("local."))
