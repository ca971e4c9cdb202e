# SPDX-License-Identifier: GPL-2.0-or-later
"""Differences of small samples with confidence intervals, and tests of many of them with few false alarms."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import comb, nan

import numpy as np
from scipy import stats

CONFIDENCE = 0.95
"""Of the intervals that are printed."""
FAMILY_ERROR = 0.01
"""Chance that any of all comparisons of a study is called different although none is (Holm over quantities)."""
RESOLUTION = 1e-6
"""Differences below this share of a quantity's size are the rounding of files and formats, not of the engines."""
MOST_PERMUTATIONS = 20_000


@dataclass(frozen=True)
class Difference:
    """Difference of two means.

    Attributes
    ----------
    mean_1, mean_2 : float
    deviation_1, deviation_2 : float
        Standard deviations among members.
    difference, half_width : float
        mean_2 - mean_1 and the half width of its `CONFIDENCE` interval (Welch).
    p : float
        Two-sided, Welch.
    p_permutation : float
        Exact permutation test of the difference of means; NaN with too many permutations.
    n_1, n_2 : int
    """

    mean_1: float
    mean_2: float
    deviation_1: float
    deviation_2: float
    difference: float
    half_width: float
    p: float
    p_permutation: float
    n_1: int
    n_2: int


def welch(one: np.ndarray, two: np.ndarray, scale: float | None = None) -> Difference:
    """Return the difference of the means of two samples of unequal variance.

    B. L. Welch, Biometrika 34 (1947) 28: t = (m2 - m1)/sqrt(s1^2/n1 + s2^2/n2) with the Welch-Satterthwaite degrees
    of freedom. The variance of each mean gets a floor of (`RESOLUTION` scale)^2, so that samples that agree to
    rounding (before chaos has set in) are not told apart by their last digits.

    Parameters
    ----------
    one, two : array_like, shape (n_1,), (n_2,)
        NaN is left out.
    scale : float, optional
        Size of the quantity; default the larger absolute mean.

    Returns
    -------
    Difference
        With NaN half width and p where a sample has fewer than two values.
    """
    one, two = (np.asarray(v, float)[np.isfinite(np.asarray(v, float))] for v in (one, two))
    n1, n2 = len(one), len(two)
    if not n1 or not n2:
        return Difference(
            *(float(v.mean()) if len(v) else nan for v in (one, two)), nan, nan, nan, nan, nan, nan, n1, n2
        )
    m1, m2 = float(one.mean()), float(two.mean())
    if n1 < 2 or n2 < 2:
        return Difference(m1, m2, nan, nan, m2 - m1, nan, nan, nan, n1, n2)
    s1, s2 = float(one.std(ddof=1)), float(two.std(ddof=1))
    if s1 == s2 == m2 - m1 == 0.0:
        return Difference(m1, m2, s1, s2, m2 - m1, 0.0, 1.0, 1.0, n1, n2)
    floor = (RESOLUTION * (scale if scale is not None else max(abs(m1), abs(m2)))) ** 2
    half, p = _welch(m2 - m1, s1**2 / n1 + floor, s2**2 / n2 + floor, n1, n2)
    return Difference(m1, m2, s1, s2, m2 - m1, float(half), float(p), permutation_p(one, two), n1, n2)


def _welch(difference, v1, v2, n1: int, n2: int, points: int = 1):
    """Return half width and p of a difference of means with variances `v1`, `v2`, each one of `points`."""
    total = np.where(v1 + v2 > 0, v1 + v2, 1.0)
    freedom = total**2 / np.where(v1 + v2 > 0, v1**2 / (n1 - 1) + v2**2 / (n2 - 1), 1.0)
    half = stats.t.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / points, freedom) * np.sqrt(v1 + v2)
    return half, 2.0 * stats.t.sf(np.abs(difference) / np.sqrt(total), freedom)


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


@dataclass(frozen=True)
class Band:
    """Two sets of curves, point by point.

    Attributes
    ----------
    difference, half_width : ndarray, shape (points,)
        Half width of the simultaneous interval: Bonferroni over the points, so that all of them hold at once with
        `CONFIDENCE`.
    p : float
        Of the hypothesis that no point differs: least p times the number of points (Bonferroni).
    worst : int
        Point of the least p; -1 where nothing can be compared.
    points : int
        Points compared.
    """

    mean_1: np.ndarray
    mean_2: np.ndarray
    deviation_1: np.ndarray
    deviation_2: np.ndarray
    difference: np.ndarray
    half_width: np.ndarray
    p: float
    worst: int
    points: int


def compare_curves(one: np.ndarray, two: np.ndarray) -> Band:
    """Compare point by point (Welch) with Bonferroni over the points.

    Parameters
    ----------
    one, two : ndarray, shape (members, points)
        Points at which any member has no number are left out.
    """
    good = np.isfinite(one).all(axis=0) & np.isfinite(two).all(axis=0)
    scale = float(np.max(np.abs(np.concatenate([one[:, good], two[:, good]])), initial=0.0))
    floor = (RESOLUTION * scale) ** 2
    n1, n2 = len(one), len(two)
    columns = np.full((6, one.shape[1]), nan)
    a, b = one[:, good], two[:, good]
    points = int(good.sum())
    if not points or n1 < 2 or n2 < 2:
        return Band(*columns, nan, -1, points)
    m1, m2, s1, s2 = a.mean(axis=0), b.mean(axis=0), a.std(axis=0, ddof=1), b.std(axis=0, ddof=1)
    half, p = _welch(m2 - m1, s1**2 / n1 + floor, s2**2 / n2 + floor, n1, n2, points)
    columns[:, good] = m1, m2, s1, s2, m2 - m1, half
    worst = int(np.flatnonzero(good)[np.argmin(p)])
    return Band(*columns, float(min(1.0, p.min() * points)), worst, points)


def holm(ps: dict[str, float]) -> dict[str, float]:
    """Return adjusted p values: below a they reject with family-wise error a (S. Holm, Scand. J. Statist. 6 (1979) 65).

    NaN stays NaN and does not count.
    """
    known = sorted((p, name) for name, p in ps.items() if p == p)
    adjusted, highest = dict.fromkeys(ps, nan), 0.0
    for rank, (p, name) in enumerate(known):
        highest = max(highest, min(1.0, (len(known) - rank) * p))
        adjusted[name] = highest
    return adjusted


def block_means(values: np.ndarray, blocks: int) -> np.ndarray:
    """Return means of `blocks` equal parts along the last axis (fewer where there are fewer values)."""
    count = values.shape[-1]
    cuts = np.linspace(0, count, min(blocks, count) + 1).astype(int)
    return np.stack([values[..., a:b].mean(axis=-1) for a, b in pairwise(cuts)], axis=-1)
