# SPDX-License-Identifier: GPL-2.0-or-later
"""Differences of small samples with confidence intervals, and tests of many of them with few false alarms."""

from __future__ import annotations

from itertools import pairwise
from math import comb, nan
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

CONFIDENCE = 0.95
"""Of the intervals that are printed."""
FAMILY_ERROR = 0.01
"""Chance that any of all comparisons of a study is called different although none is (Holm over quantities)."""
RESOLUTION = 1e-6
"""Differences below this share of a quantity's size are the rounding of files and formats, not of the engines."""
DECIDES = 0.1
"""Half width of an interval, as a share of the quantity, above which finding no difference decides nothing."""
MOST_PERMUTATIONS = 20_000
Value = TypeVar("Value")


class Difference(NamedTuple, Generic[Value]):
    """Difference of two means: numbers, or arrays with an entry for each point of a curve.

    Attributes
    ----------
    mean_1, mean_2 : float or ndarray
    deviation_1, deviation_2 : float or ndarray
        Standard deviations among members.
    difference, half_width : float or ndarray
        mean_2 - mean_1 and the half width of its `CONFIDENCE` interval (Welch). The intervals of all points of a curve
        hold at once (Bonferroni).
    p : float or ndarray
        Two-sided, Welch.
    p_permutation : float
        Exact permutation test of the difference of means; NaN with too many permutations, and for curves.
    n_1, n_2 : int or ndarray
    """

    mean_1: Value
    mean_2: Value
    deviation_1: Value
    deviation_2: Value
    difference: Value
    half_width: Value
    p: Value
    p_permutation: float
    n_1: Value
    n_2: Value


def welch(one: np.ndarray, two: np.ndarray, scale: float | None = None, points: int = 1) -> Difference[Any]:
    """Return the difference of the means of two samples of unequal variance.

    B. L. Welch, Biometrika 34 (1947) 28: t = (m2 - m1)/sqrt(s1^2/n1 + s2^2/n2) with the Welch-Satterthwaite degrees
    of freedom. The variance of each mean gets a floor of (`RESOLUTION` scale)^2, so that samples that agree to
    rounding (before chaos has set in) are not told apart by their last digits.

    Parameters
    ----------
    one, two : ndarray, shape (n_1,) and (n_2,), or (n_1, points) and (n_2, points)
        NaN is left out.
    scale : float, optional
        Size of the quantity; default the larger absolute mean.
    points : int
        Number of intervals that are to hold at once.

    Returns
    -------
    Difference
        With NaN half width and p where a sample has fewer than two values.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        (n1, m1, s1), (n2, m2, s2) = _moments(one), _moments(two)
        gap = m2 - m1
        same = (s1 == 0) & (s2 == 0) & (gap == 0)
        size = np.where(same, 0.0, np.fmax(np.abs(m1), np.abs(m2))) if scale is None else scale
        floor = (RESOLUTION * size) ** 2
        v1, v2 = s1**2 / n1 + floor, s2**2 / n2 + floor
        total = np.where(v1 + v2 == 0, 1.0, v1 + v2)
        freedom = total**2 / np.where(v1 + v2 == 0, 1.0, v1**2 / (n1 - 1) + v2**2 / (n2 - 1))
    half = stats.t.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / points, freedom) * np.sqrt(v1 + v2)
    p = 2.0 * stats.t.sf(np.abs(gap) / np.sqrt(total), freedom)
    exact = permutation_p(one[np.isfinite(one)], two[np.isfinite(two)]) if one.ndim == 1 and p == p else nan
    return Difference(m1, m2, s1, s2, gap, half, p, exact, n1, n2)


def _moments(sample: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return number, mean and standard deviation of the values that are not NaN, along the first axis."""
    n = np.isfinite(sample).sum(axis=0)
    mean = np.nansum(sample, axis=0) / n
    return n, mean, np.sqrt(np.nansum((sample - mean) ** 2, axis=0) / np.maximum(n - 1, 0))


def permutation_p(one: np.ndarray, two: np.ndarray) -> float:
    """Return the share of all ways to deal the values into two samples whose means differ by at least as much.

    The test assumes only that the labels could be exchanged. Its least value is 1 / C(n1 + n2, n1), twice that for
    samples of equal size. NaN where there are more than `MOST_PERMUTATIONS` ways.
    """
    if comb(len(one) + len(two), len(one)) > MOST_PERMUTATIONS:
        return nan
    # centred first: rounding of a large common part must not decide ties
    centre = np.concatenate([one, two]).mean()
    exact = {"vectorized": True, "n_resamples": np.inf, "alternative": "greater"}
    return float(stats.permutation_test((one - centre, two - centre), _gap, **exact).pvalue)


def _gap(one: np.ndarray, two: np.ndarray, axis: int) -> np.ndarray:
    return np.abs(one.mean(axis=axis) - two.mean(axis=axis))


def compare_curves(one: np.ndarray, two: np.ndarray) -> Difference[np.ndarray]:
    """Compare point by point (Welch) with Bonferroni over the points.

    Parameters
    ----------
    one, two : ndarray, shape (members, points)
        Points at which any member has no number are left out.
    """
    good = np.isfinite(one).all(axis=0) & np.isfinite(two).all(axis=0)
    one, two = (np.where(good, side, nan) for side in (one, two))
    scale = float(np.nanmax(np.abs([*one, *two]), initial=0.0))
    return welch(one, two, scale, max(1, int(good.sum())))


def holm(ps: dict[str, float]) -> dict[str, float]:
    """Return adjusted p values: below a they reject with family-wise error a (S. Holm, Scand. J. Statist. 6 (1979) 65).

    NaN stays NaN and does not count.
    """
    known = pd.Series(ps, dtype=float).dropna().sort_values()
    adjusted = (known * np.arange(len(known), 0, -1)).clip(upper=1.0).cummax()
    return {name: float(adjusted.get(name, nan)) for name in ps}


def block_means(values: ArrayLike, blocks: int) -> np.ndarray:
    """Return means of `blocks` equal parts of a series (fewer where there are fewer values)."""
    values = np.asarray(values, float)
    cuts = np.linspace(0, len(values), min(blocks, len(values)) + 1).astype(int)
    return np.array([values[a:b].mean() for a, b in pairwise(cuts)])
