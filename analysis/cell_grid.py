# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs sorted into square cells: what every neighbour search of the analysis starts from."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit


def _sort_into_cells_py(x, y, side):
    """Counting sort of points into cells of `side` or, where strays would make too many, coarser ones.

    Parameters
    ----------
    x, y : ndarray, shape (n,), n > 0, m
    side : float
        Wanted side of a cell, m; points closer than it are in the same or in adjacent cells.

    Returns
    -------
    home : ndarray of int, shape (n,)
        Cell of each point; cell = column * rows + row.
    start : ndarray of int, shape (cells + 1,)
        Cell c holds ``order[start[c]:start[c + 1]]``.
    order : ndarray of int, shape (n,)
        Points by cell, in each in their own order.
    columns, rows : int
    """
    n = x.size
    x0, y0 = x.min(), y.min()
    wide, high = x.max() - x0, y.max() - y0
    # sparse spray over a large box must not cost memory: at most about 8 cells a point
    side = max(side, sqrt((wide + side) * (high + side) / (8.0 * n + 64.0)))
    columns, rows = int(wide / side) + 1, int(high / side) + 1
    start = np.zeros(columns * rows + 1, np.int64)
    home = np.empty(n, np.int64)
    for i in range(n):
        home[i] = int((x[i] - x0) / side) * rows + int((y[i] - y0) / side)
        start[home[i] + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
    fill = start[:-1].copy()
    order = np.empty(n, np.int64)
    for i in range(n):
        order[fill[home[i]]] = i
        fill[home[i]] += 1
    return home, start, order, columns, rows


def _list_pairs_py(x, y, reach, first, second):
    """Fill `first` and `second` with the pairs of `close_pairs`; their number, of which what fits is written."""
    _, start, order, columns, rows = sort_into_cells(x, y, reach)
    square = reach * reach
    count = 0
    for cx in range(columns):
        for cy in range(rows):
            c = cx * rows + cy
            for a in range(start[c], start[c + 1]):
                i = order[a]
                for neighbour in range(5):  # itself and half of the eight around it: each pair once
                    ox = 0 if neighbour < 2 else 1
                    oy = (0, 1, -1, 0, 1)[neighbour]
                    if cx + ox >= columns or cy + oy < 0 or cy + oy >= rows:
                        continue
                    other = (cx + ox) * rows + cy + oy
                    for b in range(a + 1 if neighbour == 0 else start[other], start[other + 1]):
                        j = order[b]
                        dx, dy = x[j] - x[i], y[j] - y[i]
                        distance2 = dx * dx + dy * dy
                        if distance2 >= square or distance2 == 0.0:
                            continue
                        if count < first.size:
                            first[count] = i
                            second[count] = j
                        count += 1
    return count


def close_pairs(x: np.ndarray, y: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points closer than `reach`, each once; points at one place are no pair (nothing says which way).

    Parameters
    ----------
    x, y : ndarray of float64, contiguous, shape (n,), m
    reach : float
        m.

    Returns
    -------
    first, second : ndarray of int, shape (pairs,)
    """
    size = 4 * x.size
    while x.size > 1:
        first, second = np.empty(size, np.int32), np.empty(size, np.int32)
        count = _list_pairs(x, y, reach, first, second)
        if count <= size:
            return first[:count], second[:count]
        size = count
    return np.empty(0, np.int32), np.empty(0, np.int32)


# numba caches the machine code of `profiles._connected` together with that of `sort_into_cells`: after a change of the
# sort, profiles.py must be touched too.
sort_into_cells = njit(cache=True)(_sort_into_cells_py)
_list_pairs = njit(cache=True)(_list_pairs_py)
