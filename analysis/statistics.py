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
from typing import Any

import numpy as np

from lammps_jump.units import Estimates

LEAST_SAMPLES = 8
"""Fewer samples (or blocks) than this give no standard error: its own relative error would exceed a quarter."""


def block_average(series: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    mean, standard_error : ndarray, shape (…)
        The error is NaN where there is none: fewer than `LEAST_SAMPLES` samples, or no plateau before the blocks ran
        out.
    """
    block = np.asarray(series, float)
    error = np.full(block.shape[1:], np.nan)
    mean = block.mean(axis=0) if len(block) else error
    levels, own = [], []
    while len(block) >= LEAST_SAMPLES:
        n = len(block)
        levels.append(np.sqrt(np.var(block, axis=0) / (n - 1)))
        own.append(levels[-1] / np.sqrt(2.0 * (n - 1)))
        block = 0.5 * (block[: n // 2 * 2 : 2] + block[1 : n // 2 * 2 : 2])
    for i, level in enumerate(levels[:-1]):
        plateau = np.all(
            [later <= level + off for later, off in zip(levels[i + 1 :], own[i + 1 :], strict=True)], axis=0
        )
        error = np.where(plateau & np.isnan(error), level, error)
    if len(levels) == 1:  # 8 to 15 samples: one level proves no plateau, except for a constant
        error = np.where(levels[0] == 0, 0.0, error)
    return mean, error


PIECES = 8
"""Equal pieces of a window: a quantity is computed in each, and their scatter is its error (docs/measuring.md)."""
WAVES = 4
"""Longest waves over the pieces that are looked at for slow swings."""
STUDENT = 2.776
"""Standard errors in a 95 % interval: Student's t with `WAVES` degrees of freedom."""


def student(freedom: float, share: float) -> float:
    """Quantile of Student's t with so many degrees of freedom: this share of it lies below."""
    from scipy.special import stdtrit  # 0.1 s; scipy.stats, with the same quantile, 0.4 s

    return float(stdtrit(freedom, share))


@dataclass(frozen=True)
class Mean:
    """A mean and its standard error, from eight pieces; the error is NaN with fewer than two samples a piece."""

    value: float
    error: float

    @classmethod
    def of(cls, estimates: Estimates, key: str) -> Mean:
        """An estimate of a result, with its error."""
        return cls(getattr(estimates, key), getattr(estimates, f"{key}_error"))


def as_fields(**means: Mean) -> dict[str, Any]:
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


def known_mean(values: np.ndarray, axis: int = 0) -> np.ndarray:
    """Mean along an axis of the values that are not NaN; NaN where there are none."""
    known = ~np.isnan(values)
    with np.errstate(invalid="ignore"):
        return np.where(known, values, 0.0).sum(axis=axis) / known.sum(axis=axis)


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
