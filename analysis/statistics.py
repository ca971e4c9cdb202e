# SPDX-License-Identifier: GPL-2.0-or-later
"""Standard errors of correlated series by blocking.

Source: H. Flyvbjerg and H. G. Petersen, "Error estimates on averages of correlated data", J. Chem. Phys. 91 (1989)
461, eqs 20-28: halve the series by averaging neighbours; the naive standard error rises until the blocks are
independent and then stays level.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np

LEAST_SAMPLES = 8
"""Fewer samples (or blocks) than this give no standard error: its own relative error would exceed a quarter."""


@dataclass(frozen=True)
class BlockAverage:
    """Means of series with their standard errors; arrays of the series' shape without the time axis.

    Attributes
    ----------
    mean : ndarray
    standard_error : ndarray
        NaN where there is none: fewer than `LEAST_SAMPLES` samples, or no plateau before the blocks ran out.
    lower_bound : ndarray
        Largest standard error seen at any level with at least `LEAST_SAMPLES` blocks: up to noise, the truth is
        no less.
    blocks : ndarray of int
        Number of independent blocks at the plateau; 0 where there is none.
    """

    mean: np.ndarray
    standard_error: np.ndarray
    lower_bound: np.ndarray
    blocks: np.ndarray


def block_average(series: np.ndarray) -> BlockAverage:
    """Mean and standard error of correlated series.

    A level is the plateau when no later level with at least `LEAST_SAMPLES` blocks exceeds it by more than that
    level's own error, s / sqrt(2 (n - 1)); the last such level alone proves nothing and is not taken, unless
    the series is constant. Samples that are NaN make that column NaN: means over gaps would hide them.

    Parameters
    ----------
    series : array_like, shape (samples, …)
        Equally spaced in time.

    Returns
    -------
    BlockAverage
    """
    data = np.asarray(series, float)
    shape = data.shape[1:]
    data = data.reshape(len(data), -1)
    columns = data.shape[1]
    nothing = np.full(columns, np.nan)
    mean = data.mean(axis=0) if len(data) else nothing
    levels, errors, counts = [], [], []
    block = data
    while len(block) >= LEAST_SAMPLES:
        n = len(block)
        level = np.sqrt(np.var(block, axis=0) / (n - 1))
        levels.append(level)
        errors.append(level / np.sqrt(2.0 * (n - 1)))
        counts.append(n)
        block = 0.5 * (block[: n // 2 * 2 : 2] + block[1 : n // 2 * 2 : 2])
    standard_error, blocks = nothing.copy(), np.zeros(columns, int)
    for i in range(len(levels) - 1):
        level_out = np.ones(columns, bool)
        for j in range(i + 1, len(levels)):
            level_out &= levels[j] <= levels[i] + errors[j]
        take = level_out & np.isnan(standard_error)
        standard_error[take] = levels[i][take]
        blocks[take] = counts[i]
    if len(levels) == 1:  # 8 to 15 samples: one level proves no plateau, except for a constant
        constant = levels[0] == 0
        standard_error[constant], blocks[constant] = 0.0, counts[0]
    lower = np.max(levels, axis=0) if levels else nothing
    return BlockAverage(*(part.reshape(shape) for part in (mean, standard_error, lower, blocks)))


@dataclass(frozen=True)
class Mean:
    """A mean and its standard error (blocking; its lower bound where the window is too short; NaN below 8 frames)."""

    value: float
    error: float


def mean_of(series: np.ndarray) -> Mean:
    """Mean of one series, shape (samples,), without the samples that are NaN; NaN where nothing is left."""
    good = series[np.isfinite(series)]
    if not good.size:
        return Mean(nan, nan)
    result = block_average(good)
    error = float(result.standard_error)
    return Mean(float(result.mean), error if np.isfinite(error) else float(result.lower_bound))
