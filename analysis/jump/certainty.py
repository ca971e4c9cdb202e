# SPDX-License-Identifier: GPL-2.0-or-later
"""How sure one run is of its jump: errors from the pieces of the window, drift, and what only more starts can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import ceil, isfinite, nan

import numpy as np

from lammps_jump.analysis.statistics import piece_error
from lammps_jump.units import number

GOAL = 0.03
"""Relative standard error of the mean of several starts that `Members` aims at."""
MISSED = {"y2": 0.60, "speed": 0.52, "froude": 0.44}
"""Largest share of the variance between starts that the window of one run missed (16 starts of a jump, windows of 3, 6
and 13 s, each share to 0.15; docs/analysis.md)."""

LOWER_BOUNDS = (
    *MISSED, "h2", "u1", "u2", "froude_lab", "sequent_ratio", "length_mass", "packing_2", "beta_1", "head_downstream",
)  # fmt: skip
"""Numbers whose error is a lower bound: one run misses part of it, or its 95 % intervals held less than 90 % of fresh
starts (benchmarks/error_bars.py; docs/analysis.md). h2 and u2 go with y2."""
TAIL_BOUNDS = ("depth", "belanger_y2", "belanger_deviation")
"""The same of the tail water; the latter two have the velocity of the front in them."""


@dataclass(frozen=True)
class Drift:
    """Mean of the second half of the window less that of the first; NaN where the window has no pieces."""

    y1: float = number("m", "drift of y1 within the window", default=nan)
    y2: float = number("m", "drift of y2 within the window", default=nan)
    sequent_ratio: float = number("", "drift of s₂/s₁ within the window", default=nan)
    froude: float = number("", "drift of the Froude number within the window", default=nan)
    speed: float = number("m/s", "drift of the velocity of the front within the window", default=nan)
    length: float = number("m", "drift of the length within the window", default=nan)


@dataclass(frozen=True)
class Members:
    """Runs from slightly moved starts whose mean has a standard error of 3 %, at least; None where not known."""

    y2: int | None = number("", "runs for y2 to 3 %, at least", default=None)
    speed: int | None = number("", "runs for the velocity of the front to 3 %, at least", default=None)
    froude: int | None = number("", "runs for the Froude number to 3 %, at least", default=None)


def errors(jump: object, pieces: Sequence[Mapping]) -> dict[str, float]:
    """Standard error within this run of each number of a `Jump` that has one, by its key ``<number>_error``."""
    names = [field.name for field in fields(jump) if field.name.endswith("_error")]
    return {name: piece_error(_values(pieces, name.removesuffix("_error"))) for name in names}


def drift(pieces: Sequence[Mapping]) -> Drift:
    """Drift of the main numbers within the window."""
    if not pieces:
        return Drift()
    half = len(pieces) // 2
    found = {field.name: _values(pieces, field.name) for field in fields(Drift)}
    return Drift(**{name: float(values[half:].mean() - values[:half].mean()) for name, values in found.items()})


def members(jump: object) -> Members:
    """Number of starts needed, with the variance that one run misses added to its own errors."""

    def needed(key: str) -> int | None:
        value, error = getattr(jump, key), getattr(jump, f"{key}_error")
        if not isfinite(error) or abs(value) <= 2 * error:  # no share of a number that may be zero
            return None
        return max(1, ceil(error**2 / (1.0 - MISSED[key]) / (GOAL * value) ** 2))

    return Members(**{key: needed(key) for key in MISSED})


def starts_needed(found: Mapping[str, int | None]) -> str:
    """Number of runs for each number that has one, in words; empty where none has."""
    names = {"y2": "y2", "speed": "the velocity of the front", "froude": "the Froude number"}
    known = {name: count for key, name in names.items() if (count := found.get(key)) is not None}
    texts = [f"{count} {'run' if count == 1 else 'runs'} for {name}" for name, count in known.items()]
    return ", ".join([*texts[:-2], " and ".join(texts[-2:])]) if texts else ""


def _values(pieces: Sequence[Mapping], key: str) -> np.ndarray:
    return np.array([piece.get(key, nan) for piece in pieces], float)
