# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact search of the native engine: sort discs by cell, build the half neighbour list.

Cells as wide as the list's reach, counted along the shorter side of the flow first, so that neighbours in space are
neighbours in memory. Because the discs are sorted by cell, the candidates of a disc are two stretches of memory:
the rest of its own cell with the next cell of the column, and three cells of the next column.
"""

from __future__ import annotations

import numpy as np
from numba import njit


def _extent_py(n, x, y, x_low, x_high, y_low, y_high):
    """Smallest box around the discs (xlo, xhi, ylo, yhi) and the index of a disc outside the domain, or -1.

    A NaN is outside.
    """
    a, b, c, d = x_high, x_low, y_high, y_low
    lost = -1
    for i in range(n):
        px, py = x[i], y[i]
        if not (px >= x_low and px <= x_high and py >= y_low and py <= y_high):
            lost = i
        a = min(a, px)
        b = max(b, px)
        c = min(c, py)
        d = max(d, py)
    return a, b, c, d, lost


def _sort_py(n, x, y, x_low, y_low, inverse, columns, rows, transpose, cell_start, cell, order):
    """Counting sort by cell: fills ``cell_start`` (first disc of each cell), ``cell`` (sorted) and ``order``.

    A frame of empty cells surrounds the grid: (columns + 2) x (rows + 2) cells, rows counted fastest;
    `transpose` puts x along the rows.
    """
    height = rows + 2
    for c in range(cell_start.size):
        cell_start[c] = 0
    for i in range(n):
        cx = int((x[i] - x_low) * inverse)
        cy = int((y[i] - y_low) * inverse)
        if transpose:
            cx, cy = cy, cx
        c = (min(cx, columns - 1) + 1) * height + min(cy, rows - 1) + 1
        order[i] = c
        cell_start[c + 2] += 1
    for c in range(2, cell_start.size):
        cell_start[c] += cell_start[c - 1]
    for i in range(n):  # cell_start[c + 1] runs from the first disc of cell c to the first of the next one
        c = order[i]
        place = cell_start[c + 1]
        cell_start[c + 1] = place + 1
        cell[place] = c
        order[i] = place


def _permute_py(n, source, place, scratch):
    """``source[place[i]] = source[i]`` for i < n, through `scratch`."""
    for i in range(n):
        scratch[place[i]] = source[i]
    for i in range(n):
        source[i] = scratch[i]


def _pair_list_py(n, x, y, radius, reach, rows, cell_start, cell, start, neighbours):
    """Half neighbour list of all pairs closer than the reach; returns its length, or -1 where `neighbours` is short.

    The reach is of centres, and of surfaces where discs have radii of their own (`radius` not None).
    """
    height = rows + 2
    count = 0
    room = neighbours.size
    start[0] = 0
    for i in range(n):
        c = cell[i]
        xi, yi = x[i], y[i]
        far = reach if radius is None else reach + radius[i]
        low = cell_start[c + height - 1]
        high = cell_start[c + height + 2]
        last = cell_start[c + 2]
        if count + (last - i) + (high - low) > room:
            return -1
        for first, end in ((i + 1, last), (low, high)):
            for j in range(first, end):
                dx = xi - x[j]
                dy = yi - y[j]
                apart = far if radius is None else far + radius[j]
                neighbours[count] = j
                count += dx * dx + dy * dy < apart * apart
        start[i + 1] = count
    return count


def _image_rows_py(n, x, y, radius, reach, widest, low, period, start, neighbours, owner, shift):
    """List pairs across the seam of a periodic channel, a row for each disc near its left end, behind the n others.

    The row's disc stands `period` further on (`Pairs`). Returns the number of rows, or -1 where `neighbours` is short.
    `widest` is the largest reach of centres, `reach` as in `pair_list`.
    """
    near = np.empty(n, np.int64)
    strip = 0
    for i in range(n):
        owner[i], shift[i] = i, 0.0
        if x[i] > low + period - widest:
            near[strip] = i
            strip += 1
    rows, count = n, start[n]
    for i in range(n):
        if not x[i] < low + widest:
            continue
        if count + strip > neighbours.size:
            return -1
        far = reach if radius is None else reach + radius[i]
        for p in range(strip):
            j = near[p]
            dx, dy = x[i] + period - x[j], y[i] - y[j]
            apart = far if radius is None else far + radius[j]
            neighbours[count] = j
            count += dx * dx + dy * dy < apart * apart
        owner[rows], shift[rows] = i, period
        rows += 1
        start[rows] = count
    return rows


def _closest_py(n, x, y, px, py):
    """Square of the distance from (px, py) to the closest disc; inf where there is none."""
    least = np.inf
    for i in range(n):
        dx = px - x[i]
        dy = py - y[i]
        least = min(least, dx * dx + dy * dy)
    return least


def _append_row_py(i, x, y, radius, reach, start, neighbours):
    """List row of disc i, the newest: every older disc within the reach; False where `neighbours` is short."""
    count = start[i]
    for j in range(i):
        dx = x[i] - x[j]
        dy = y[i] - y[j]
        apart = reach if radius is None else reach + radius[i] + radius[j]
        if dx * dx + dy * dy < apart * apart:
            if count == neighbours.size:
                return False
            neighbours[count] = j
            count += 1
    start[i + 1] = count
    return True


extent = njit(cache=True)(_extent_py)
sort = njit(cache=True)(_sort_py)
permute = njit(cache=True)(_permute_py)
pair_list = njit(cache=True)(_pair_list_py)
image_rows = njit(cache=True)(_image_rows_py)
closest = njit(cache=True)(_closest_py)
append_row = njit(cache=True)(_append_row_py)
