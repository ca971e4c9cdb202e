# SPDX-License-Identifier: GPL-2.0-or-later
"""Grading curves: which part of the mass, or of the number, of discs is smaller than a size.

A curve is held in pieces, each with its share in the number of discs, and with diameters that are uniform within it by
number. The mass of a disc goes with the square of its diameter (thesis 3.3), as it does in the rest of this program.
"""

from __future__ import annotations

from math import fsum

import numpy as np
from numpy.typing import ArrayLike

from .elementary import exp

ROOT_OF_TWO_PI = 2.5066282746310002
TERMS = 120
"""Of the series of the normal distribution; up to 5 standard deviations the last ones are below 1e-17."""


def normal_part(z: float) -> float:
    """Part of a normal distribution below z standard deviations, |z| <= 5, with the same bits on every system.

    1/2 + exp(-z^2/2)/sqrt(2 pi) (z + z^3/3 + z^5/(3 5) + …): M. Abramowitz and I. A. Stegun, Handbook of Mathematical
    Functions, 1964, eq. 26.2.11. All terms have one sign.
    """
    term, terms = z, [z]
    for k in range(1, TERMS):
        term *= z * z / (2 * k + 1)
        terms.append(term)
    return 0.5 + exp(-0.5 * z * z) / ROOT_OF_TWO_PI * fsum(terms)


def mean_squares(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Mean of d^2 of each piece, m^2: (l^2 + l h + h^2)/3, the integral of d^2 over a uniform density."""
    return (low * low + low * high + high * high) / 3.0


def number_shares(low: np.ndarray, high: np.ndarray, masses: np.ndarray) -> np.ndarray:
    """Shares of pieces in the number of discs, by those in their mass: as many as the mass over that of a disc.

    Parameters
    ----------
    low, high : ndarray, shape (n,), m
    masses : ndarray, shape (n,)
        Shares in the mass; their sum is 1.
    """
    numbers = masses / mean_squares(low, high)
    shares: np.ndarray = numbers / fsum(numbers)  # in one order on every system
    return shares


def passing(shares: np.ndarray, low: np.ndarray, high: np.ndarray, sizes: ArrayLike, power: int = 2) -> np.ndarray:
    """Part of all discs that is not larger than some sizes: by mass, or by number where the power is 0.

    The integral of d^p over a uniform density from l to s is (s^(p+1) - l^(p+1))/((p + 1)(h - l)).

    Parameters
    ----------
    shares, low, high : ndarray, shape (n,)
        Pieces: share in the number, least and largest diameter (m).
    sizes : array_like, m
    power : int
        Of the diameter, in what is summed.
    """
    s = np.asarray(sizes, float)[..., None]
    wide = high > low
    cut, width = np.clip(s, low, high), np.where(wide, high - low, 1.0)
    below = np.where(wide, (cut ** (power + 1) - low ** (power + 1)) / ((power + 1) * width), (s >= high) * low**power)
    whole = np.where(wide, (high ** (power + 1) - low ** (power + 1)) / ((power + 1) * width), low**power)
    parts_passing: np.ndarray = (below @ shares) / (whole @ shares)
    return parts_passing


def diameter_at(shares: np.ndarray, low: np.ndarray, high: np.ndarray, part: float, power: int = 2) -> float:
    """Size that this part of the discs is not larger than, m: the inverse of `passing`, piece by piece.

    Parameters
    ----------
    shares, low, high : ndarray, shape (n,)
        Pieces in the order of their sizes.
    part : float
        By mass, or by number where the power is 0: 0.5 gives d50.
    power : int
    """
    ends = passing(shares, low, high, high, power)
    one = min(int(np.searchsorted(ends, part * (1 - 1e-12))), len(ends) - 1)
    begin = float(passing(shares, low, high, low[one], power)) if high[one] > low[one] else 0.0
    if not high[one] > low[one] or ends[one] <= begin:
        return float(high[one])
    within = (part - begin) / (ends[one] - begin)
    order = power + 1
    return float((low[one] ** order + within * (high[one] ** order - low[one] ** order)) ** (1.0 / order))


def passing_error(shares: np.ndarray, low: np.ndarray, high: np.ndarray, sizes: ArrayLike, count: float) -> np.ndarray:
    """Standard error of `passing`, by mass, of so many discs drawn at random: the counting error of a curve.

    Source: variance of a ratio of two sums, W. G. Cochran, Sampling Techniques, 3rd ed., Wiley 1977, eq. 2.39, with
    m and m [d <= s] as the two: ((1 - F)^2 E[m^2, d <= s] + F^2 E[m^2, d > s]) / (n E[m]^2).

    Parameters
    ----------
    shares, low, high : ndarray, shape (n,)
    sizes : array_like, m
    count : float
        Discs.
    """
    by_mass = passing(shares, low, high, sizes)
    fourth = passing(shares, low, high, sizes, 4)
    whole = np.where(high > low, (high**5 - low**5) / (5.0 * np.where(high > low, high - low, 1.0)), low**4) @ shares
    mean = mean_squares(low, high) @ shares
    variance = whole * ((1 - by_mass) ** 2 * fourth + by_mass**2 * np.maximum(1 - fourth, 0.0))
    errors: np.ndarray = np.sqrt(variance / max(count, 1.0)) / mean
    return errors
