# SPDX-License-Identifier: GPL-2.0-or-later
"""Pairs of points that are close to each other."""

from __future__ import annotations

import numpy as np

from lammps_jump.core.library import INTEGER, REAL, REALS, SHORTS, core, function

_close_pairs = function("jump_close_pairs", INTEGER, REALS, REALS, REAL, SHORTS, SHORTS, INTEGER, result=INTEGER)


def close_pairs(x: np.ndarray, y: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points closer than `reach`, each once; points at one place are no pair (nothing says which way).

    Parameters
    ----------
    x, y : ndarray of float64, contiguous, shape (n,), m
    reach : float
        m.

    Returns
    -------
    first, second : ndarray of int32, shape (pairs,)
        Without the core in another order, and a pair may stand the other way round.
    """
    if core() is None:
        return _pairs_of_tree(x, y, reach)
    size = 4 * x.size
    while True:
        first, second = np.empty(size, np.int32), np.empty(size, np.int32)
        count = _close_pairs(x.size, x, y, reach, first, second, size)
        if count <= size:
            return first[:count], second[:count]
        size = count


def _pairs_of_tree(x: np.ndarray, y: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    from scipy.spatial import cKDTree  # 0.2 s

    pairs = (
        cKDTree(np.column_stack([x, y])).query_pairs(reach, output_type="ndarray") if x.size else np.empty((0, 2), int)
    )
    first, second = pairs[np.lexsort(pairs.T[::-1])].T.astype(np.int32)
    distance2 = (x[second] - x[first]) ** 2 + (y[second] - y[first]) ** 2
    kept = (distance2 < reach * reach) & (distance2 > 0.0)
    return first[kept], second[kept]
