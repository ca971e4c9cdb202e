# SPDX-License-Identifier: GPL-2.0-or-later
"""Varied numbers by measurements: likelihood, samples of the posterior, 95 % ranges.

The prior is flat in the ranges. The likelihood is Student's t over all measured numbers at once. Its covariance is that
of the measurement, of the scatter over starts, and of the emulator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

DRAWN = 8192
"""Places of one look at the likelihood."""
KEPT = 2000
"""Samples of the posterior, of equal weight."""
FAR = 12.0
"""Drop of the log likelihood behind which nothing is looked for: 4.9 standard deviations of one number."""
LOOKS, LEAST = 12, 0.7
"""Times that the looked-at box may shrink, and the share of its size above which it does no more."""
MASS, NEAR = 0.95, 0.005
"""Of a range; distance from an end of the prior that is none."""

LogLikelihood = Callable[[np.ndarray], np.ndarray]
"""Of places in the unit cube, shape (n, varied), to shape (n,)."""


def log_t(off: np.ndarray, covariance: np.ndarray, freedom: np.ndarray) -> np.ndarray:
    """Log density of Student's t in several dimensions, but for a constant of the dimensions.

    Source: S. Kotz and S. Nadarajah, Multivariate t Distributions and Their Applications, Cambridge 2004, eq. 1.1.

    Parameters
    ----------
    off : ndarray, shape (n, k)
        Measured numbers less the emulated ones.
    covariance : ndarray, shape (n, k, k)
        Scale matrix.
    freedom : ndarray, shape (n,)
        Degrees of freedom; infinite for a normal distribution.
    """
    from scipy.special import gammaln

    k = off.shape[1]
    lower = np.linalg.cholesky(covariance)
    whitened = np.linalg.solve(lower, off[..., None])[..., 0]
    square = np.sum(whitened**2, axis=1)
    logs = -np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1)
    nu = np.where(np.isfinite(freedom), freedom, 1.0)
    t = gammaln(0.5 * (nu + k)) - gammaln(0.5 * nu) - 0.5 * k * np.log(0.5 * nu)
    t = t - 0.5 * (nu + k) * np.log1p(square / nu)
    return logs + np.where(np.isfinite(freedom), t, -0.5 * square)


@dataclass(frozen=True)
class Posterior:
    """Samples of the varied numbers, and their weights.

    Attributes
    ----------
    places : ndarray, shape (n, varied)
        In the unit cube.
    weights : ndarray, shape (n,)
        Their sum is 1.
    best : ndarray, shape (varied,)
        The place of the largest likelihood that was found.
    """

    places: np.ndarray
    weights: np.ndarray
    best: np.ndarray

    def range_of(self, number: int) -> tuple[float, float]:
        """The shortest range that holds 95 % of one varied number, widened to `best`, and to an end that is `NEAR`."""
        low, high = shortest(self.places[:, number], self.weights)
        low, high = min(low, float(self.best[number])), max(high, float(self.best[number]))
        return low if low > NEAR else 0.0, high if high < 1.0 - NEAR else 1.0

    @property
    def covariance(self) -> np.ndarray:
        """Of the varied numbers, shape (varied, varied)."""
        return np.atleast_2d(np.cov(self.places.T, aweights=self.weights, ddof=0))

    @property
    def correlation(self) -> np.ndarray:
        """Of the varied numbers, shape (varied, varied)."""
        sd = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(sd, sd)

    def drawn(self, count: int = KEPT) -> np.ndarray:
        """Samples of equal weight, shape (count, varied), the same at every call."""
        return self.places[np.random.default_rng(0).choice(len(self.places), count, p=self.weights)]


def shortest(values: np.ndarray, weights: np.ndarray, mass: float = MASS) -> tuple[float, float]:
    """The shortest range that holds this share of weighted values."""
    order = np.argsort(values, kind="stable")
    x, total = values[order], np.cumsum(weights[order])
    lows = np.linspace(0.0, 1.0 - mass, 101)
    low, high = (np.interp(share, total, x) for share in (lows, lows + mass))
    narrow = int(np.argmin(high - low))
    return float(low[narrow]), float(high[narrow])


def sample(log_likelihood: LogLikelihood, varied: int) -> Posterior:
    """Draw from the posterior: Sobol points of a box that shrinks and turns round what is likely, with weights.

    Parameters
    ----------
    log_likelihood : callable
    varied : int
        How many numbers are varied.
    """
    axes, low, high = np.eye(varied), np.zeros(varied), np.ones(varied)
    best, most = np.full(varied, 0.5), -inf
    for look in range(LOOKS):
        places = (low + sobol(DRAWN, varied, look) * (high - low)) @ axes.T
        places = places[((places >= 0) & (places <= 1)).all(axis=1)]
        found = log_likelihood(places)
        if found.max() > most:
            best, most = places[int(np.argmax(found))], float(found.max())
        near = places[found > most - FAR]
        turned = np.linalg.eigh(np.atleast_2d(np.cov(near.T)))[1] if len(near) > varied else axes
        along = near @ turned
        pad = 0.05 * np.ptp(along, axis=0) + (high - low).min() / DRAWN
        smaller = along.min(axis=0) - pad, along.max(axis=0) + pad
        if np.prod((smaller[1] - smaller[0]) / (high - low)) > LEAST:
            break
        axes, (low, high) = turned, smaller
    weights = np.exp(found - found.max())
    return Posterior(places, weights / weights.sum(), best)


def sobol(count: int, varied: int, seed: int) -> np.ndarray:
    """The first points of a scrambled Sobol sequence in the unit cube, shape (count, varied)."""
    from scipy.stats import qmc  # 0.5 s

    power = max(1, int(np.ceil(np.log2(count))))
    return qmc.Sobol(varied, scramble=True, seed=seed).random_base2(power)[:count]
