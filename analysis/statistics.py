# SPDX-License-Identifier: GPL-2.0-or-later
"""Standard errors of correlated series: by blocking, and from eight pieces of a window.

Source of blocking: H. Flyvbjerg and H. G. Petersen, "Error estimates on averages of correlated data", J. Chem. Phys. 91
(1989) 461, eqs 20-28: halve the series by averaging neighbours; the naive standard error rises until the blocks are
independent and then stays level.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

import numpy as np

from lammps_jump.units import Estimates

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


PIECES = 8
"""Equal pieces of a window: a quantity is computed in each, and their scatter is its error (docs/analysis.md)."""
WAVES = 4
"""Longest waves over the pieces that are looked at for slow swings."""
STUDENT = 2.776
"""Standard errors in a 95 % interval: Student's t with `WAVES` degrees of freedom."""


@dataclass(frozen=True)
class Mean:
    """A mean and its standard error, from eight pieces; the error is NaN with fewer than two samples a piece."""

    value: float
    error: float

    @classmethod
    def of(cls, found: Estimates, key: str) -> Mean:
        """An estimate of a result, with its error."""
        return cls(getattr(found, key), getattr(found, f"{key}_error"))


def as_fields(**means: Mean) -> dict[str, float]:
    """Fields of a result of `Estimates`: each number under its name, its error under ``<name>_error``."""
    values = {name: mean.value for name, mean in means.items()}
    return values | {f"{name}_error": mean.error for name, mean in means.items()}


def piece_bounds(samples: int) -> list[int]:
    """First sample of each of the `PIECES` pieces, and the last sample; empty with fewer than two samples a piece."""
    if samples < 2 * PIECES:
        return []
    return np.round(np.linspace(0, samples - 1, PIECES + 1)).astype(int).tolist()


def piece_error(values: np.ndarray) -> float:
    """Standard error of the mean of a quantity from its values in the pieces; NaN with fewer pieces or a NaN.

    The larger of s / sqrt(n), which takes pieces for independent, and of the size of the `WAVES` longest waves,
    ``e^2 = mean of L_j^2 / n`` with ``L_j = sqrt(2/n) sum cos(pi j (i + 1/2)/n) x_i``: swings slower than a piece.
    """
    n = len(values)
    if n < PIECES:
        return nan
    waves = np.cos(np.pi * np.outer(np.arange(1, WAVES + 1), np.arange(n) + 0.5) / n)
    slow = np.mean((waves @ (values - values.mean())) ** 2) * 2 / n / n
    return float(np.sqrt(max(np.var(values, ddof=1) / n, slow)))


def mean_of(series: np.ndarray) -> Mean:
    """Mean of one series, shape (samples,), without the samples that are NaN; NaN where nothing is left."""
    good = series[np.isfinite(series)]
    if not good.size:
        return Mean(nan, nan)
    pieces = np.array_split(good, PIECES) if piece_bounds(len(good)) else []
    return Mean(float(good.mean()), piece_error(np.array([piece.mean() for piece in pieces])))


STEP = 1e-3
"""Errors by which `propagated` moves an argument: small, so that the function is straight there."""


def propagated(function: Callable[..., float], *measured: Mean) -> Mean:
    """A function of measured numbers, and the error that theirs, taken as independent, hand on."""
    values = np.array([number.value for number in measured])
    moves = STEP * np.diag([number.error for number in measured])
    changes = [(function(*(values + move)) - function(*(values - move))) / (2 * STEP) for move in moves]
    return Mean(float(function(*values)), float(np.sqrt(np.sum(np.square(changes)))))
