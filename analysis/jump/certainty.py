# SPDX-License-Identifier: GPL-2.0-or-later
"""Certainty of the jump of one run: errors from the pieces of the window, drift, and what only more starts can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import ceil, isfinite, nan
from typing import Any

import numpy as np

from lammps_jump.analysis.statistics import piece_error
from lammps_jump.units import Estimates, number, numbers_of

GOAL = 0.03
"""Relative standard error of the mean of several starts that `Members` aims at."""
MISSED = {"y2": 0.60, "speed": 0.52, "froude": 0.44}
"""Largest share of the variance between starts that the window of one run missed (16 starts of a jump, windows of 3, 6
and 13 s, each share to 0.15; docs/measuring.md)."""

UNTOLD = (
    "y2", "speed", "length_mass", "local.y2", "local.u2", "local.h2", "local.packing_2",
)  # fmt: skip
"""Numbers measured in the frames whose error one run cannot tell: it misses part of the variance between starts, or
its 95 % intervals held less than 90 % of fresh starts (benchmarks/error_bars.py; docs/measuring.md)."""
STATES = ("local.y1", "local.u1", "local.y2", "local.u2", "speed")
MADE_OF = {
    "froude": ("speed",), "belanger_y2": ("speed",), "belanger_deviation": ("y2", "belanger_y2"),
    "head_lost_theory": ("speed",), "length_theory": ("speed",), "length_usbr": ("speed",), "length_over_y2": ("y2",),
    "local.froude": ("local.u1", "local.y1", "speed"), "local.froude_lab": ("local.u1", "local.y1"),
    "local.froude_downstream": ("local.u2", "local.y2", "speed"),
    "local.beta_1": ("local.u1", "speed"), "local.beta_2": ("local.u2", "speed"),
    "local.sequent_ratio": ("local.y1", "local.y2"),
    "sloping_y2": ("speed",), "sloping_deviation": ("y2", "sloping_y2"), "local.sloping_ratio": ("local.froude",),
    "local.belanger_ratio": ("local.froude",), "local.belanger_y2": ("local.froude", "local.y1"),
    "local.belanger_deviation": ("local.sequent_ratio", "local.belanger_ratio"),
    "local.density_ratio": ("local.y1", "local.y2", "local.h2"),
    "local.density_relation_ratio": ("local.froude", "local.density_ratio"),
    "local.density_relation_deviation": ("local.sequent_ratio", "local.density_relation_ratio"),
    "local.full_relation_ratio": ("local.froude", "local.density_ratio"), "local.pressure_relation_ratio": STATES,
    "local.pressure_relation_deviation": STATES,
    "local.pressure_coefficient_1": ("local.y1",), "local.pressure_coefficient_2": ("local.y2", "local.h2"),
    "local.head_upstream": ("local.froude", "local.y1"), "local.head_downstream": ("local.y2", "local.u2", "speed"),
    "local.energy_loss": ("local.head_upstream", "local.head_downstream"),
    "local.energy_loss_theory": ("local.froude", "local.y1"),
    "local.momentum_upstream": ("local.froude",), "local.momentum_downstream": ("local.y2",),
    "local.momentum_residual": ("local.momentum_upstream", "local.momentum_downstream"),
}  # fmt: skip
"""What a number is made of. What is made of a number that one run cannot tell is one of these itself."""


def inherited(untold: Sequence[str], made_of: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """These numbers and all that are made of them, however far."""
    found = dict.fromkeys(untold)
    while more := [key for key, parts in made_of.items() if key not in found and found.keys() & set(parts)]:
        found |= dict.fromkeys(more)
    return tuple(found)


BOUNDS = inherited(UNTOLD, MADE_OF)
LOWER_BOUNDS = tuple(key for key in BOUNDS if not key.startswith("local."))
"""Numbers of a `Jump` whose error is a lower bound."""
LOCAL_BOUNDS = tuple(key.removeprefix("local.") for key in BOUNDS if key.startswith("local."))
"""The same of the state beside the jump."""


@dataclass(frozen=True)
class Drift:
    """Mean of the second half of the window less that of the first; NaN where the window has no pieces."""

    y2: float = number("m", "drift of y2 within the window", default=nan)
    speed: float = number("m/s", "drift of the velocity of the front within the window", default=nan)
    length: float = number("m", "drift of the length within the window", default=nan)


@dataclass(frozen=True)
class Members:
    """Runs from slightly moved starts whose mean has a standard error of 3 %, at least; None where not known."""

    y2: int | None = number("", "runs for y2 to 3 %, at least", default=None)
    speed: int | None = number("", "runs for the velocity of the front to 3 %, at least", default=None)
    froude: int | None = number("", "runs for the Froude number to 3 %, at least", default=None)


def errors(jump: Estimates, pieces: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Standard error within this run of each number of a `Jump` that has one, by its key ``<number>_error``."""
    names = [key for key in numbers_of(jump) if key.endswith("_error")]
    return {name: piece_error(_values(pieces, name.removesuffix("_error"))) for name in names}


def drift(pieces: Sequence[Mapping[str, Any]]) -> Drift:
    """Drift of the main numbers within the window."""
    if not pieces:
        return Drift()
    half = len(pieces) // 2
    found = {field.name: _values(pieces, field.name) for field in fields(Drift)}
    return Drift(**{name: float(values[half:].mean() - values[:half].mean()) for name, values in found.items()})


def members(jump: Estimates) -> Members:
    """Number of starts needed, with the variance that one run misses added to its own errors."""

    def needed(key: str) -> int | None:
        value, error = getattr(jump, key), getattr(jump, f"{key}_error")
        if not isfinite(error) or abs(value) <= 2 * error:  # no share of a number that may be zero
            return None
        return max(1, ceil(error**2 / (1.0 - MISSED[key]) / (GOAL * value) ** 2))

    return Members(**{key: needed(key) for key in MISSED})


def starts_needed(found: Members | None) -> str:
    """Number of runs for each number that has one, in words; empty where none has."""
    names = {"y2": "y2", "speed": "the velocity of the front", "froude": "the Froude number"}
    counts = {name: getattr(found, key, None) for key, name in names.items()}
    texts = [f"{count} {'run' if count == 1 else 'runs'} for {name}" for name, count in counts.items() if count]
    return ", ".join([*texts[:-2], " and ".join(texts[-2:])]) if texts else ""


def _values(pieces: Sequence[Mapping[str, Any]], key: str) -> np.ndarray:
    return np.array([piece.get(key, nan) for piece in pieces], float)
