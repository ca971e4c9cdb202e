# SPDX-License-Identifier: GPL-2.0-or-later
"""Lists of the twin: discs sorted by cell, pairs that are close, discs near walls, the thesis' own search.

The order of rows and of the discs in them is that of the core, because it decides the order of sums.
"""

from __future__ import annotations

import numpy as np

from lammps_jump.engines.native.arrays import Box, Cells, Near, State
from lammps_jump.engines.native.discs import DiscArrays
from lammps_jump.scene.chains import Faces
from lammps_jump.scene.near import FaceGrid, list_near

from .contact import radius_of


def extent(n: int, x: np.ndarray, y: np.ndarray, domain: tuple[float, ...]) -> Box:
    """Smallest box around the discs, and the last of those outside the domain or not a number, or -1."""
    x, y = x[:n], y[:n]
    inside = (x >= domain[0]) & (x <= domain[1]) & (y >= domain[2]) & (y <= domain[3])
    lost = np.flatnonzero(~inside)
    a, b = np.min(x, initial=domain[1]), np.max(x, initial=domain[0])
    c, d = np.min(y, initial=domain[3]), np.max(y, initial=domain[2])
    return float(a), float(b), float(c), float(d), int(lost[-1]) if lost.size else -1


def sort(discs: DiscArrays, cells: Cells) -> None:
    """Counting sort by cell: the first disc of each cell, the cell of each place, the place of each disc.

    A frame of empty cells surrounds the grid: (columns + 2) x (rows + 2) cells, rows counted fastest; `transpose` puts
    x along the rows. The columns of the discs move to their places.
    """
    n = discs.n
    across = ((discs.x[:n] - cells.x_low) * cells.inverse).astype(np.int64)
    up = ((discs.y[:n] - cells.y_low) * cells.inverse).astype(np.int64)
    if cells.transpose:
        across, up = up, across
    height = cells.rows + 2
    cell = (np.minimum(across, cells.columns - 1) + 1) * height + np.minimum(up, cells.rows - 1) + 1
    order = np.argsort(cell, kind="stable")
    discs.cell[:n] = cell[order]
    count = (cells.columns + 2) * height
    discs.cell_start[: count + 1] = np.searchsorted(discs.cell[:n], np.arange(count + 1))
    discs.cell_start[count + 1] = n
    for name, column in discs.columns.items():
        if column.sorted:
            array = getattr(discs, name)
            array[:n] = array[order]


def _close(discs: DiscArrays, i: int, others: np.ndarray, reach: float, shift: float = 0.0) -> np.ndarray:
    """Those of other discs within the reach of disc i (m), which stands `shift` further along x."""
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


def pair_list(discs: DiscArrays, reach: float, rows: int) -> int:
    """Half list of all pairs closer than the reach (m); its length, or -1 where there is no room.

    Candidates of a disc are the rest of its own cell with the next cell of the column, and three of the next column.
    """
    height, start = rows + 2, discs.cell_start
    discs.start[0] = 0
    for i, c in enumerate(discs.cell[: discs.n].tolist()):
        own = np.arange(i + 1, start[c + 2])
        others = np.concatenate([own, np.arange(start[c + height - 1], start[c + height + 2])])
        if not _put_row(discs, i, _close(discs, i, others, reach)):
            return -1
    return int(discs.start[discs.n])


def image_rows(discs: DiscArrays, reach: tuple[float, float, float], owner: np.ndarray, shift: np.ndarray) -> int:
    """Pairs across the seam of a periodic channel: a row for each disc near its left end, behind the n others.

    The row's disc stands a period further on. Returns the number of rows, or -1 where there is no room.
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
    """Discs near one wall, by `lammps_jump.scene.near.list_near`."""
    return list_near(seen, wall, faces, grid, (near.discs, near.plain, near.last, near.faces), found)
