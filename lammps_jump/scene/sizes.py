# SPDX-License-Identifier: GPL-2.0-or-later
"""Diameters of discs that are not equal: a function of the id of a disc and the seed of the run.

No random generator and no file: every engine computes the same diameters, on any number of ranks and after a restart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.physics import grading

SEED_STEP = 0.7548776662466927
"""Shift of the ids from one seed to the next: 1/p with the plastic number p, p^3 = p + 1."""
ID_STEP = 0.6180339887498949
"""Distance of the quantiles of one id and the next, on a circle of length 1: the golden section (sqrt(5) - 1)/2."""


@dataclass(frozen=True)
class Sizes:
    """Distribution of diameters by number, in pieces; within a piece diameters are uniform.

    Attributes
    ----------
    shares : tuple of float
        Share of each piece in the number of discs; their sum is 1.
    low, high : tuple of float
        Least and largest diameter of each piece, m; equal where all its discs are.
    seed : int
    own : tuple of (int, int, float)
        First and last id of discs that have a diameter of their own, m: of rough beds.
    given : tuple of float
        Diameters of the first ids, m: of discs that come from an earlier run.
    """

    shares: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    seed: int = 1
    own: tuple[tuple[int, int, float], ...] = ()
    given: tuple[float, ...] = ()

    @property
    def smallest(self) -> float:
        """Smallest diameter, m."""
        return min((*self.low, *self.given, *(diameter for *_, diameter in self.own)))

    @property
    def largest(self) -> float:
        """Largest diameter, m."""
        return max((*self.high, *self.given, *(diameter for *_, diameter in self.own)))

    @property
    def is_curve(self) -> bool:
        """Tells whether they are a grading curve: several pieces with a width."""
        return len(self.shares) > 1 and all(high > low for low, high in zip(self.low, self.high, strict=True))

    @property
    def mean_square(self) -> float:
        """Mean of the squared diameter, m^2: the mean mass over the density."""
        pieces = zip(self.shares, self.low, self.high, strict=True)
        return sum(share * (low * low + low * high + high * high) / 3.0 for share, low, high in pieces)

    def passing(self, diameters: ArrayLike, power: int = 2) -> np.ndarray:
        """Part of the mass that is in discs not larger than these diameters (m); of the number with the power 0."""
        return grading.passing(*self._arrays, diameters, power)

    def passing_error(self, diameters: ArrayLike, count: float) -> np.ndarray:
        """Counting error of `passing` where so many discs are drawn."""
        return grading.passing_error(*self._arrays, diameters, count)

    def diameter_at(self, part: float) -> float:
        """Diameter that this part of the mass is not larger than, m: 0.5 gives d50."""
        return grading.diameter_at(*self._arrays, part)

    @property
    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.array(self.shares), np.array(self.low), np.array(self.high)

    @property
    def shift(self) -> float:
        """Shift that the seed adds to an id."""
        return self.seed * SEED_STEP

    @cached_property
    def pieces(self) -> np.ndarray:
        """Quantile where each piece begins, where it ends, its least diameter (m) and its slope (m); shape (n, 4)."""
        ends = np.cumsum(self.shares)
        ends[-1] = 1.0
        begins = np.concatenate([[0.0], ends[:-1]])
        slopes = (np.array(self.high) - self.low) / self.shares
        return np.column_stack([begins, ends, self.low, slopes])

    def quantiles(self, ids: ArrayLike) -> np.ndarray:
        """Quantile of each id, in [0, 1): the fraction of ``(id + shift) * ID_STEP``; shape of `ids`."""
        turned = (np.asarray(ids, float) + self.shift) * ID_STEP
        return turned - np.floor(turned)

    def diameters(self, ids: ArrayLike) -> np.ndarray:
        """Diameter of each id, m; shape of `ids`."""
        u = self.quantiles(ids)
        begins, ends, low, slope = self.pieces.T
        piece = np.minimum(np.searchsorted(ends, u, side="right"), len(ends) - 1)
        result = low[piece] + slope[piece] * (u - begins[piece])
        if self.given:
            known = np.array(self.given)
            result = np.where(np.asarray(ids) <= len(known), known[np.clip(ids, 1, len(known)) - 1], result)
        for first, last, diameter in self.own:
            result = np.where((np.asarray(ids) >= first) & (np.asarray(ids) <= last), diameter, result)
        return result
