# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction mu(I) and packing phi(I) of discs sheared at a held pressure, in a box without walls (`loops`)."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from . import loops
from .cell import Cell
from .discs import FluidDiscs
from .law import shear_rate

INERTIAL = (0.3, 0.1, 0.03, 0.01, 0.003)
"""Inertial numbers, from quick to slow: each begins where the one before has ended."""
COUNT = 600
APART = {0.3: (3.0, 8.0), 0.1: (2.0, 6.0), 0.03: (1.0, 4.0), 0.01: (0.7, 2.5), 0.003: (0.4, 1.2)}
"""Strain before and while the means are taken, by inertial number."""
ROWS = 20
EXPANDED = 0.4
"""Packing below which discs are a gas, which expands for ever."""


class Sheared(NamedTuple):
    """Means of a sheared box: inertial number, friction mu, packing phi, pressure (Pa)."""

    inertial: float
    friction: float
    packing: float
    pressure: float


def sheared(
    discs: FluidDiscs, pressure: float, seed: int, *, numbers: Sequence[float] = INERTIAL, count: int = COUNT
) -> list[Sheared]:
    """Shear one start at each inertial number, from quick to slow; those at which discs expand are left out.

    Parameters
    ----------
    discs : FluidDiscs
    pressure : float
        Held, Pa.
    seed : int
    numbers : sequence of float
    count : int
        Discs of the box.
    """
    cell, rate, found = Cell(discs, count, seed), 0.0, []
    cell.close(pressure)
    for number in sorted(numbers, reverse=True):
        before, during = APART.get(number, (1.0, 3.0))
        old, rate = rate, shear_rate(number, discs.diameter, discs.density, pressure)
        cell.shear(old, rate)
        cell.advance(before / rate, 1, rate=rate, pressure=pressure)
        record = cell.advance(during / rate, ROWS, rate=rate, pressure=pressure)
        one = of_record(record, rate, cell)
        if one.packing > EXPANDED:
            found.append(one)
    return found


def of_record(record: np.ndarray, rate: float, cell: Cell) -> Sheared:
    """Means of a record of `Cell.advance` at a rate (1/s)."""
    means = record.mean(axis=0)
    pressure = 0.5 * float(means[loops.SXX] + means[loops.SYY])
    inertial = rate * cell.discs.diameter * sqrt(cell.discs.density / pressure)
    packing = cell.covered / float(means[loops.AREA])
    return Sheared(inertial, -float(means[loops.SXY]) / pressure, packing, pressure)
