# SPDX-License-Identifier: GPL-2.0-or-later
"""Lists of the twin: discs in the core's order, close pairs among all pairs, discs near walls, the thesis' own search.

The order of rows and of the discs in them is that of the core, because it decides the order of sums.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from lammps_jump.engines.native.arrays import LISTED, NO_ROOM, Near, State
from lammps_jump.engines.native.discs import LISTS, DiscArrays
from lammps_jump.scene.chains import Faces
from lammps_jump.scene.faces import FaceGrid, list_near

from .contact import radius_of

CELLS_A_DISC = 16
"""Cells of the search at most, over the number of discs."""


def outside(n: int, x: np.ndarray, y: np.ndarray, domain: tuple[float, ...]) -> int:
    """The last of n discs outside the domain or not a number, or -1."""
    x, y = x[:n], y[:n]
    inside = (x >= domain[0]) & (x <= domain[1]) & (y >= domain[2]) & (y <= domain[3])
    lost = np.flatnonzero(~inside)
    return int(lost[-1]) if lost.size else -1


def _order_of(discs: DiscArrays, reach: float) -> np.ndarray:
    """Discs in the order of the core: by cells of its search, those along the shorter side counted fastest.

    Cells are as wide as the reach (m), wider where a few discs are far apart. Nothing but the order comes of them.
    """
    n, x, y = discs.n, discs.x[: discs.n], discs.y[: discs.n]
    wide, high = float(x.max() - x.min()), float(y.max() - y.min())
    width = max(reach, sqrt(wide * high / max(CELLS_A_DISC * n, 4096)), wide / 1e6, high / 1e6)
    inverse = 1.0 / width
    columns, rows = int(wide * inverse) + 1, int(high * inverse) + 1
    across, up = ((x - x.min()) * inverse).astype(np.int64), ((y - y.min()) * inverse).astype(np.int64)
    if rows > columns:
        columns, rows, across, up = rows, columns, up, across
    return np.argsort(np.minimum(across, columns - 1) * rows + np.minimum(up, rows - 1), kind="stable")


def list_pairs(state: State) -> int:
    """Sort the discs and list all pairs closer than the reach, of all pairs; a disc outside, `LISTED` or `NO_ROOM`."""
    d, lists = state.discs, state.lists
    assert lists is not None
    n = d.sorted_rows = d.n
    d.listed_as = next(LISTS)
    if (lost := outside(n, d.x, d.y, lists.domain)) >= 0:
        return lost
    d.start[0] = 0
    if n == 0:
        return LISTED
    order = _order_of(d, lists.widest + lists.skin)
    for name, column in d.columns.items():
        if column.sorted:
            array = getattr(d, name)
            array[:n] = array[:n][order]
    d.x0[:n], d.y0[:n] = d.x[:n], d.y[:n]
    reach = lists.skin if d.radius is not None else lists.widest + lists.skin
    for i in range(n):
        if not _put_row(d, i, _close(d, i, np.arange(i + 1, n), reach)):
            return NO_ROOM
    return LISTED


def _close(discs: DiscArrays, i: int, others: np.ndarray, reach: float, shift: float = 0.0) -> np.ndarray:
    """Other discs within the reach of disc i (m), which lies `shift` further along x."""
    dx, dy = discs.x[i] + shift - discs.x[others], discs.y[i] - discs.y[others]
    apart = reach if discs.radius is None else reach + discs.radius[i] + discs.radius[others]
    return others[dx * dx + dy * dy < apart * apart]


def _put_row(discs: DiscArrays, row: int, close: np.ndarray) -> bool:
    """Put discs into a row of the list; False where there is no room."""
    begin = int(discs.start[row])
    end = begin + close.size
    if end > discs.neighbours.size:
        return False
    discs.neighbours[begin:end], discs.start[row + 1] = close, end
    return True


def closest(discs: DiscArrays, x: float, y: float) -> float:
    """Square of the distance from a point to the closest disc (m^2); infinite where there is none."""
    dx, dy = x - discs.x[: discs.n], y - discs.y[: discs.n]
    return float(np.min(dx * dx + dy * dy, initial=inf))


def append_row(discs: DiscArrays, i: int, reach: float) -> bool:
    """List row of disc i, the newest: every older disc within the reach (m); False where there is no room."""
    return _put_row(discs, i, _close(discs, i, np.arange(i), reach))


def image_rows(discs: DiscArrays, reach: tuple[float, float, float], owner: np.ndarray, shift: np.ndarray) -> int:
    """Pairs across the seam of a periodic channel: a row for each disc near its left end, after the n others.

    The row's disc is a period further on. Returns the number of rows, or -1 where there is no room.
    """
    n, period, (listed, widest, low) = discs.n, discs.period, reach
    assert period is not None
    owner[:n], shift[:n] = np.arange(n), 0.0
    right = np.flatnonzero(discs.x[:n] > low + period - widest)
    rows = n
    for i in np.flatnonzero(discs.x[:n] < low + widest).tolist():
        if not _put_row(discs, rows, _close(discs, i, right, listed, period)):
            return -1
        owner[rows], shift[rows] = i, period
        rows += 1
    return rows


def cell_pairs(state: State) -> int:
    """Touching pairs by the thesis' contact search (its chapter 3); the number of rows, or -1.

    Every disc is entered in each cell that its square overlaps; within a cell every two discs are tried, and a
    touching pair counts only in the cell that holds its contact point, which divides the line of centres as the radii.
    -1: a disc is outside the grid, or there is no room.
    """
    d, grid = state.discs, state.grid
    assert grid is not None
    cells: dict[tuple[int, int], list[int]] = {}
    for i in range(d.n):
        px, py = (d.x[i] - grid.x_low) * grid.inverse, (d.y[i] - grid.y_low) * grid.inverse
        if not (0.0 <= px < grid.columns and 0.0 <= py < grid.rows):
            return -1
        reach = radius_of(state, i) * grid.inverse
        for cx in range(int(max(px - reach, 0.0)), min(int(px + reach), grid.columns - 1) + 1):
            for cy in range(int(max(py - reach, 0.0)), min(int(py + reach), grid.rows - 1) + 1):
                cells.setdefault((cx, cy), []).append(i)
    rows = count = 0
    _, owner, start, neighbours, *_ = state.pairs
    assert owner is not None
    start[0] = 0
    for cell in sorted(cells):
        members = cells[cell]
        for place, i in enumerate(members):
            for j in members[place + 1 :]:
                if _contact_cell(state, i, j) == cell:
                    if count == neighbours.size:
                        return -1
                    neighbours[count] = j
                    count += 1
            owner[rows], start[rows + 1] = i, count
            rows += 1
    grid.used[0] = rows
    return rows


def _contact_cell(state: State, i: int, j: int) -> tuple[int, int] | None:
    """The cell that holds the contact point of two discs; None where they do not touch."""
    d, grid = state.discs, state.grid
    assert grid is not None
    a, b = radius_of(state, i), radius_of(state, j)
    dx, dy = d.x[i] - d.x[j], d.y[i] - d.y[j]
    if not dx * dx + dy * dy < (a + b) * (a + b):
        return None
    share = 0.5 if d.radius is None else b / (a + b)
    x, y = share * d.x[i] + (1.0 - share) * d.x[j], share * d.y[i] + (1.0 - share) * d.y[j]
    return int((x - grid.x_low) * grid.inverse), int((y - grid.y_low) * grid.inverse)


def near_walls(
    seen: tuple[int, np.ndarray, np.ndarray],
    wall: int,
    faces: Faces,
    grid: FaceGrid,
    near: Near,
    found: tuple[int, int],
) -> tuple[int, int]:
    """Discs near one wall, by `lammps_jump.scene.faces.list_near`."""
    return list_near(seen, wall, faces, grid, (near.discs, near.plain, near.last, near.faces), found)
