# SPDX-License-Identifier: GPL-2.0-or-later
"""The error of a curve that was measured without one: its size, and how far along the curve it is alike.

The curves of the runs span a few components. What the measured curve has beside them no number of the case explains:
it tells what errors are possible. The likelihood is then a mean over these errors (A. Gelman et al., Bayesian Data
Analysis, 3rd ed., CRC 2013, sec. 3.1: a nuisance number is integrated out). An error that is alike over some length
has the covariance exp(-distance/length) (C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine
Learning, MIT Press 2006, sec. 4.2.1): the points of the curve are then fewer pieces of news than they are points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

POSSIBLE = 16
"""Possible errors that the likelihood is a mean over, all equally likely."""
LEAST, MOST = 1e-4, 0.25
"""Possible sizes, in ranges of the measured curve; who measures worse knows it, and can say it."""
SIZES, LENGTHS = 40, 5
"""Sizes, evenly in their logarithm, and lengths that are weighed."""
LONGEST = 0.5
"""Longest length over which an error is alike, in extents of the curve."""
ROUND_OFF = 1e-9
"""Added to the diagonal, in variances of the error: points may stand at one place."""
ROUGH = 1e-4
"""As `ROUND_OFF`, of the scatter over starts: part of its variance that each point has of its own."""


@dataclass(frozen=True)
class PossibleErrors:
    """Errors that a curve may have, all equally likely.

    Attributes
    ----------
    sizes : ndarray, shape (m,)
        Standard deviations, in the unit of the curve.
    lengths : ndarray, shape (m,)
        Over which they are alike, in the unit of the axis; 0 where each point has its own.
    at : ndarray, shape (k,)
        The axis of the curve.
    """

    sizes: np.ndarray
    lengths: np.ndarray
    at: np.ndarray

    @property
    def typical(self) -> float:
        """Median of the sizes."""
        return float(np.median(self.sizes))

    def in_numbers(self, directions: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """Covariances in the numbers of a curve, shape (m, components, components).

        Parameters
        ----------
        directions : ndarray, shape (components, k)
        scale : ndarray, shape (k,)
        """
        onto = directions / scale
        shapes = {length: onto @ alike(self.at, length) @ onto.T for length in set(self.lengths)}
        return np.array([size**2 * shapes[length] for size, length in zip(self.sizes, self.lengths, strict=True)])


def alike(at: np.ndarray, length: float) -> np.ndarray:
    """Correlation of errors along a curve, shape (k, k): exp(-distance/length); each its own where the length is 0."""
    if not length:
        return np.eye(len(at))
    return np.exp(-np.abs(at[:, None] - at) / length) + ROUND_OFF * np.eye(len(at))


def possible_errors(
    at: np.ndarray, measured: np.ndarray, beside: np.ndarray, own: np.ndarray, scatter: np.ndarray
) -> PossibleErrors:
    """Errors by how likely they make what a measured curve has beside the components of the runs.

    Parameters
    ----------
    at, measured : ndarray, shape (k,)
        The curve.
    beside : ndarray, shape (k - components, k)
        Takes from a curve what no component explains; its rows are directions over the scales of the points.
    own : ndarray, shape (k - components,)
        What the measured curve has there.
    scatter : ndarray, shape (k, k)
        Covariance of the curve of a single run.
    """
    span = float(np.ptp(measured)) or float(np.abs(measured).max()) or 1.0
    sizes = span * np.geomspace(LEAST, MOST, SIZES)
    lengths = _lengths(at)
    known = beside @ scatter @ beside.T
    logs = np.array([_logs(own, beside @ alike(at, length) @ beside.T, known, sizes) for length in lengths])
    weights = np.exp(logs - logs.max()).ravel()
    drawn = np.searchsorted(np.cumsum(weights / weights.sum()), (np.arange(POSSIBLE) + 0.5) / POSSIBLE)
    length, size = np.unravel_index(np.minimum(drawn, weights.size - 1), logs.shape)
    return PossibleErrors(sizes[size], np.array(lengths)[length], at)


def _lengths(at: np.ndarray) -> list[float]:
    """Lengths over which errors along a curve may be alike; 0 is the first."""
    extent = float(np.ptp(at))
    return [0.0, *np.geomspace(extent / (len(at) - 1), LONGEST * extent, LENGTHS - 1)] if extent else [0.0]


def scatter_of(at: np.ndarray, off: np.ndarray, freedom: float) -> np.ndarray:
    """Covariance of the curve of a single run, shape (k, k), by what its starts differ from their mean.

    Of k points with f degrees of freedom the part k/(k + f) is that of a curve whose scatter is alike over the length
    that the starts tell.

    Parameters
    ----------
    at : ndarray, shape (k,)
    off : ndarray, shape (n, k)
    freedom : float
        Of `off`; 0 where no point of the ranges has two starts, and nothing is known.
    """
    found = off.T @ off / max(freedom, 1.0)
    sd = np.sqrt(np.diag(found))
    if not sd.any():
        return found
    some = sd > 0
    own, best, most = off[:, some] / sd[some], 0.0, -np.inf
    for length in _lengths(at):
        shape = alike(at[some], length) + ROUGH * np.eye(some.sum())
        log = -0.5 * (freedom * np.linalg.slogdet(shape)[1] + np.sum(own * np.linalg.solve(shape, own.T).T))
        if log > most:
            best, most = length, log
    keep = freedom / (freedom + len(at))
    return keep * found + (1 - keep) * alike(at, best) * np.outer(sd, sd)


def _logs(own: np.ndarray, shape: np.ndarray, known: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Log density of normal numbers of the covariance ``size^2 shape + known``, of each size."""
    from scipy.linalg import eigh

    # one decomposition for all sizes: in its basis both parts are diagonal
    values, vectors = eigh(known, shape + ROUND_OFF * np.trace(shape) / len(shape) * np.eye(len(shape)))
    variances = sizes[:, None] ** 2 + np.maximum(values, 0.0)
    turned = vectors.T @ own
    logs: np.ndarray = -0.5 * np.sum(turned**2 / variances + np.log(variances), axis=1)
    return logs + float(np.linalg.slogdet(vectors)[1])


def together(curves: Sequence[PossibleErrors]) -> np.ndarray:
    """Order in which possible errors of the curves go together, shape (m, curves): a Latin hypercube."""
    rng = np.random.default_rng(0)
    return np.array([rng.permutation(POSSIBLE) if k else np.arange(POSSIBLE) for k in range(len(curves))]).T
