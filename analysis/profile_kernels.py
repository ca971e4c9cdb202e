"""Inner loops of the profiles: sharing discs among bins by area, and finding the free surface."""

from __future__ import annotations

from math import asin, ceil, floor, pi, sqrt

import numpy as np
from numba import njit

from .cell_grid import sort_into_cells

LINES_PER_DIAMETER = 8
REACH = 2.0
"""Centres up to this many diameters apart are neighbours: a whole disc would fit between two that are not."""


def _left_share_py(a):
    """Share of a unit disc's area left of x = a (exact): 1/2 + (a sqrt(1 - a^2) + asin a) / pi."""
    if a <= -1.0:
        return 0.0
    if a >= 1.0:
        return 1.0
    return 0.5 + (a * sqrt(1.0 - a * a) + asin(a)) / pi


def _bin_frame_py(x, y, vx, vy, low, width, radius, sums, beyond):
    """Add discs to ``sums[quantity, bin]`` and ``beyond`` (left, right), in shares of area.

    Quantities: number, sum of u, of u^2, of u |v|^2 / 2, of y, of v.
    """
    bins = sums.shape[1]
    for i in range(len(x)):
        left = (x[i] - radius - low) / width
        if left >= bins:
            beyond[1] += 1.0
            continue
        if (x[i] + radius - low) / width <= 0.0:
            beyond[0] += 1.0
            continue
        u = vx[i]
        kinetic = 0.5 * (u * u + vy[i] * vy[i])
        first = max(floor(left), -1)
        done = 0.0
        k = first
        while done < 1.0:
            # everything outside the range is one bin on either side
            upto = 1.0 if k >= bins else _left_share((low + (k + 1) * width - x[i]) / radius)
            share = upto - done
            done = upto
            if k < 0:
                beyond[0] += share
            elif k >= bins:
                beyond[1] += share
            else:
                sums[0, k] += share
                sums[1, k] += share * u
                sums[2, k] += share * u * u
                sums[3, k] += share * u * kinetic
                sums[4, k] += share * y[i]
                sums[5, k] += share * vy[i]
            k += 1


def _connected_py(x, y, bed, reach, radius):
    """Which discs hang together with the bed: a flag each (breadth first over a cell grid of side `reach`)."""
    n = len(x)
    joined = np.zeros(n, np.bool_)
    if n == 0:
        return joined
    cell, start, members, nx, ny = sort_into_cells(x, y, reach)
    queue = np.empty(n, np.int64)
    tail = 0
    for i in range(n):
        # at most a diameter of air below the disc; false where the bed is NaN
        if -2.0 * radius <= y[i] - bed[i] <= 3.0 * radius:
            joined[i] = True
            queue[tail] = i
            tail += 1
    head = 0
    limit = reach * reach * (1.0 + 1e-12)
    while head < tail:
        i = queue[head]
        head += 1
        cx, cy = cell[i] // ny, cell[i] % ny
        for kx in range(max(cx - 1, 0), min(cx + 2, nx)):
            for ky in range(max(cy - 1, 0), min(cy + 2, ny)):
                c = kx * ny + ky
                for m in range(start[c], start[c + 1]):
                    j = members[m]
                    if not joined[j]:
                        dx, dy = x[j] - x[i], y[j] - y[i]
                        if dx * dx + dy * dy <= limit:
                            joined[j] = True
                            queue[tail] = j
                            tail += 1
    return joined


def _surface_frame_py(x, y, vx, bed, bed_lines, low, width, bins, radius):
    """Depth of the free surface (m) and mean u of the discs that form it (m/s, NaN where dry), a value a bin.

    `bed` is the floor's height under each disc, `bed_lines` at each line, m; line k of the range stands at
    ``low + (k + 1/2) spacing``. A line without a floor makes its bin NaN.
    """
    joined = _connected(x, y, bed, REACH * 2.0 * radius, radius)
    lines = len(bed_lines)
    per_bin = lines // bins
    spacing = width / per_bin
    top = np.full(lines, -1, np.int64)
    for i in range(len(x)):
        if joined[i]:
            first = max(ceil((x[i] - radius - low) / spacing - 0.5), 0)
            last = min(floor((x[i] + radius - low) / spacing - 0.5), lines - 1)
            for k in range(first, last + 1):
                if top[k] < 0 or y[i] > y[top[k]]:
                    top[k] = i
    depth = np.zeros(bins)
    speed = np.zeros(bins)
    for b in range(bins):
        wet = 0
        for k in range(b * per_bin, (b + 1) * per_bin):
            if np.isnan(bed_lines[k]):
                depth[b] = np.nan
            elif top[k] >= 0 and y[top[k]] + radius > bed_lines[k]:
                depth[b] += y[top[k]] + radius - bed_lines[k]
                speed[b] += vx[top[k]]
                wet += 1
        depth[b] /= per_bin
        speed[b] = speed[b] / wet if wet else np.nan
    return depth, speed


_left_share = njit(cache=True)(_left_share_py)
_connected = njit(cache=True)(_connected_py)
bin_frame = njit(cache=True)(_bin_frame_py)
surface_frame = njit(cache=True)(_surface_frame_py)
