# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a verdict: a question, the sentences that answer it from a summary, its numbers, and its doubts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from lammps_jump.physics.slip import FRICTION_LAWS

Said = Callable[[Mapping[str, Any]], str]
"""Makes a sentence of a summary; empty where there is nothing to be said."""


class Doubt(NamedTuple):
    """Condition that makes a verdict doubtful.

    Attributes
    ----------
    when : str
        The condition in words, for the table of the site.
    found : callable(summary) -> str
        What this run shows of it, with its numbers; empty where the condition does not hold.
    """

    when: str
    found: Said


class Verdict(NamedTuple):
    """One question that a run may answer.

    Attributes
    ----------
    question : str
    answer : str
        The kind of sentence, for the table of the site.
    numbers : tuple of str
        Keys of ``summary.json`` that the sentences are made of.
    title : callable(summary) -> str
        One short sentence for the top of the page; empty where the question is not asked or cannot be answered.
    doubts : tuple of Doubt
    sentence : callable(summary) -> str, or None
        What screens and logs say at more length; None: the title.
    closes : bool
        No other title is put after it.
    alone : bool
        It answers only where no verdict before it does, and no other title is put after it.
    unanswered : callable(summary) -> str, or None
        Why there is no answer, where the case asks for one; else empty.
    """

    question: str
    answer: str
    numbers: tuple[str, ...]
    title: Said
    doubts: tuple[Doubt, ...]
    sentence: Said | None = None
    closes: bool = False
    alone: bool = False
    unanswered: Said | None = None

    def said(self, summary: Mapping[str, Any]) -> str:
        """The longer sentence."""
        return (self.sentence or self.title)(summary)

    def doubted(self, summary: Mapping[str, Any]) -> list[str]:
        """Sentence on what is doubtful about this answer of a summary, or why there is none."""
        if not self.title(summary):
            why = self.unanswered(summary) if self.unanswered else ""
            return [f"{self.question} {why[:1].upper()}{why[1:]}"] if why else []
        return [text for doubt in self.doubts if (text := doubt.found(summary))]


def part(summary: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The numbers of a quantity; empty where it was not made."""
    value = summary.get(key)
    return value if isinstance(value, Mapping) else {}


def asked_of_a_dump(quantity: str, summary: Mapping[str, Any]) -> bool:
    """Tells whether somebody requested a quantity: of a dump by an option, of a run by its case."""
    return "given" not in summary or quantity in (summary["given"].get("analyses") or ())


def of_grains(summary: Mapping[str, Any]) -> bool:
    """Tells whether friction has a memory: contacts carry slopes at rest, as those of grains do and of water do not."""
    law = FRICTION_LAWS.get(summary.get("friction_law") or "")
    return law is not None and law.remembers


def reason(quantity: str) -> Said:
    """Why a quantity was not found."""
    return lambda summary: part(summary, quantity).get("reason") or ""


def above(key: str, limit: float, text: str, scale: float = 1.0) -> Said:
    """A doubt that holds where the size of a number is above a limit; `text` takes the scaled size as ``{}``."""

    def found(summary: Mapping[str, Any]) -> str:
        value = at(summary, key)
        return text.format(shown(scale * abs(value))) if value is not None and abs(value) > limit else ""

    return found


def below(key: str, limit: float, text: str) -> Said:
    """A doubt that holds where a number is below a limit; `text` takes it as ``{}``."""

    def found(summary: Mapping[str, Any]) -> str:
        value = at(summary, key)
        return text.format(shown(value)) if value is not None and value < limit else ""

    return found


def at(summary: Mapping[str, Any], key: str) -> Any:
    """Number at ``quantity.number``; None where there is none."""
    quantity, _, name = key.partition(".")
    value = part(summary, quantity).get(name)
    return None if isinstance(value, bool) or not isinstance(value, int | float) else value


def shown(value: float) -> str:
    """Two significant digits, ``1.0``, ``12``; whole numbers as they are."""
    if isinstance(value, int):
        return str(value)
    whole = abs(value) >= 99.5
    return f"{value:z.0f}" if whole else f"{value:z#.2g}".rstrip(".")


def place(value: float) -> str:
    """A place along x or y, three digits."""
    return f"{value:z.3g}"


# --- verdicts of a jump in words, and which numbers go with which verdict ---------------------------------------------


A_JUMP = {"jump": "A hydraulic jump", "marginal jump": "Now and then a jump", "jump not developed": "A growing jump"}
"""Verdicts on flows that have a jump, in words."""
WITH = {(): "", ("friction",): " with friction", ("slope",): " on a slope",
        ("friction", "slope"): " with friction on a slope"}  # fmt: skip
"""Words for what Bélanger's relation leaves out, behind a verdict."""
AT_SILL = "jump at the sill"
"""Verdict on a rise that goes on up to the sill or fall: nothing downstream of it can be compared."""
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
    """Tells whether a number of a jump belongs to the result: no length of a jump where there is none."""
    if verdict in ("marginal jump", "jump not developed"):
        return key not in OF_A_STEADY_JUMP
    return verdict == "jump" or (key not in OF_A_JUMP and not key.startswith("local."))
