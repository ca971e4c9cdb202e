# SPDX-License-Identifier: GPL-2.0-or-later
"""Varied numbers by measurements: the emulator in place of runs, likelihood, posterior, 95 % ranges.

The prior is flat in the ranges. The likelihood is Student's t over all measured numbers at once. Its covariance is that
of the measurement, of the scatter over starts, and of the emulator.

Source: C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006: eqs 2.25 and
2.26 (mean and variance), 5.12 (leave-one-out without fitting again).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import lru_cache
from math import inf, nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.errors import SetupError

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor
    from threadpoolctl import ThreadpoolController

DRAWN = 8192
"""Places of one look at the likelihood."""
KEPT = 2000
"""Samples of the posterior, of equal weight."""
FAR = 12.0
"""Drop of the log likelihood beyond which no search is made: 4.9 standard deviations of one number."""
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
        The place of the largest likelihood of the search.
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
        likelihoods = log_likelihood(places)
        if likelihoods.max() > most:
            best, most = places[int(np.argmax(likelihoods))], float(likelihoods.max())
        near = places[likelihoods > most - FAR]
        turned = np.linalg.eigh(np.atleast_2d(np.cov(near.T)))[1] if len(near) > varied else axes
        along = near @ turned
        pad = 0.05 * np.ptp(along, axis=0) + (high - low).min() / DRAWN
        smaller = along.min(axis=0) - pad, along.max(axis=0) + pad
        if np.prod((smaller[1] - smaller[0]) / (high - low)) > LEAST:
            break
        axes, (low, high) = turned, smaller
    weights = np.exp(likelihoods - likelihoods.max())
    return Posterior(places, weights / weights.sum(), best)


def sobol(count: int, varied: int, seed: int) -> np.ndarray:
    """The first points of a scrambled Sobol sequence in the unit cube, shape (count, varied)."""
    from scipy.stats import qmc  # 0.5 s

    power = max(1, int(np.ceil(np.log2(count))))
    return qmc.Sobol(varied, scramble=True, seed=seed).random_base2(power)[:count]


LACKING = (
    "calibrate needs scikit-learn, which is not installed; `pip install 'lammps-jump[calibrate]'` or `pip install "
    "scikit-learn` adds it"
)
FLOOR = 1e-8
"""Least variance of a point over that of all points: the matrix stays regular."""
LENGTHS = (0.1, 10.0)
"""Lengths over which a number may change, in ranges of a varied number."""


def require_sklearn() -> None:
    """Raise SetupError where scikit-learn is missing: before any run is made."""
    try:
        import sklearn.gaussian_process  # noqa: F401  (0.5 s)
    except ImportError:
        raise SetupError(LACKING) from None


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    from threadpoolctl import ThreadpoolController  # comes with scikit-learn

    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Linear algebra on one thread for the time of a ``with`` block: matrices of tens of rows gain nothing by more."""
    context: AbstractContextManager[object] = _libraries().limit(limits=1)
    return context


@dataclass(frozen=True)
class Emulator:
    """One number of the runs over the unit cube of the varied numbers.

    Attributes
    ----------
    process : GaussianProcessRegressor
        Of ``(y - centre) / scale``.
    centre, scale : float
        Mean and standard deviation over the points, in the number's unit.
    scatter : float
        Variance of one run, where no point has two starts: the part that no smooth curve explains. NaN otherwise.
    left_out : ndarray, shape (points,)
        Value at each point less what the others say of it, in the number's unit.
    left_out_sd : ndarray, shape (points,)
        What the others say that this difference should be.
    """

    process: GaussianProcessRegressor
    centre: float
    scale: float
    scatter: float
    left_out: np.ndarray
    left_out_sd: np.ndarray

    @property
    def chi2(self) -> float:
        """Mean square of the left-out differences over what was expected of them; about 1 for a fair emulator."""
        return float(np.mean((self.left_out / self.left_out_sd) ** 2))

    @property
    def fitted(self) -> float:
        """Points over points less fitted numbers: a size and lengths that are fitted make the variance too small."""
        points, numbers = len(self.left_out), len(self.process.kernel_.theta)
        return points / max(points - numbers, 1)

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean of the runs at places of the unit cube, and the variance of what is known of it.

        The variance grows with `fitted`, and with `chi2` where the left-out points say that it is too small.

        Parameters
        ----------
        places : ndarray, shape (n, varied)

        Returns
        -------
        mean, variance : ndarray, shape (n,)
            In the number's unit, and its square.
        """
        with one_thread():
            mean, sd = self.process.predict(places, return_std=True)
        own = 0.0 if np.isnan(self.scatter) else self.scatter
        variance = np.maximum(self.scale**2 * sd**2 - own, 0.0)
        return self.centre + self.scale * mean, max(1.0, self.chi2) * self.fitted * variance


def emulate(places: np.ndarray, values: np.ndarray, noise: np.ndarray | None) -> Emulator:
    """Fit an emulator to the means of the points: a smooth function, and a part of each point that it does not explain.

    That part is the scatter of a run where no other is known. Else it belongs to what the emulator does not know: a
    scatter that is larger here than there, or that few starts have given too small.

    Parameters
    ----------
    places : ndarray, shape (points, varied)
        In the unit cube.
    values : ndarray, shape (points,)
    noise : ndarray, shape (points,), or None
        Variance of each value by the scatter over starts; None: it is fitted.
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    centre, scale = float(values.mean()), float(values.std()) or 1.0
    smooth = ConstantKernel(1.0, (1e-2, 1e3)) * RBF(np.ones(places.shape[1]), LENGTHS)
    kernel = smooth + WhiteKernel(1e-2, (1e-6, 2.0))
    alpha = np.full(len(values), FLOOR) if noise is None else noise / scale**2 + FLOOR
    process = GaussianProcessRegressor(kernel, alpha=alpha, n_restarts_optimizer=1, random_state=0)
    with warnings.catch_warnings(), one_thread():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound: a number that hardly matters
        process.fit(places, (values - centre) / scale)
    scatter = float(process.kernel_.k2.noise_level) * scale**2 if noise is None else nan
    return Emulator(process, centre, scale, scatter, *_left_out(process, scale))


def _left_out(process: GaussianProcessRegressor, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Each value less its prediction by the others, and the expected size of that: eq. 5.12."""
    from scipy.linalg import cho_solve

    inverse = cho_solve((process.L_, True), np.eye(len(process.L_)))
    diagonal = np.diag(inverse)
    return scale * (inverse @ process.y_train_) / diagonal, scale / np.sqrt(diagonal)
