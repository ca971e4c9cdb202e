# SPDX-License-Identifier: GPL-2.0-or-later
"""A Gaussian process in place of the runs: one number of a run over the varied numbers, with its own variance.

Source: C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006: eqs 2.25 and
2.26 (mean and variance), 5.12 (leave-one-out without fitting again).
"""

from __future__ import annotations

import warnings
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import lru_cache
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.errors import SetupError

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor
    from threadpoolctl import ThreadpoolController

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
    found: AbstractContextManager[object] = _libraries().limit(limits=1)
    return found


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
    scatter that is larger here than there, or that few starts have told too small.

    Parameters
    ----------
    places : ndarray, shape (points, varied)
        In the unit cube.
    values : ndarray, shape (points,)
    noise : ndarray, shape (points,), or None
        Variance of each value by the scatter over starts; None where it is not known, and is fitted.
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
