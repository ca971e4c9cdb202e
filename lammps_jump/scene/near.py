# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs near a wall, and faces of it near each: cells that list faces, and lists of discs.

Plain loops; the core and the plugin hold their own copies (``near.h``, ``faces.h``).
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from .chains import AT_END, AT_START, ENDLESS, KIND, SEGMENT, TX0, TX1, TY0, TY1, X0, X1, Y0, Y1, Faces, boxes
from .faces import away

FEW = 8
"""Faces up to which a wall is searched without a grid."""
MOST_CELLS = 1_000_000
Room = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Arrays that `list_near` fills: discs, plain, last and near."""


class FaceGrid(NamedTuple):
    """Cells that list the faces of each wall near them, in the wall's own frame; one cell where there are few faces.

    Attributes
    ----------
    box : ndarray, shape (faces, 4)
        Box of each face with the reach, m.
    wall_box : ndarray, shape (walls, 4)
    place : ndarray, shape (walls, 3)
        Lower left corner (m) and cells per metre.
    cells : ndarray of int64, shape (walls, 3)
        Columns, rows, first cell.
    start, faces : ndarray of int64
        Faces of cell c: ``faces[start[c]:start[c + 1]]``.
    reach : float
        Distance from a face up to which discs are listed, m.
    """

    box: np.ndarray
    wall_box: np.ndarray
    place: np.ndarray
    cells: np.ndarray
    start: np.ndarray
    faces: np.ndarray
    reach: float


def _plain(faces: Faces, f: int, px: float, py: float, margin: float) -> bool:
    """Tells whether a point is beside a straight face and a margin (m) from its ends: its line is then enough."""
    codes, shape = faces[:2]
    if codes[f, KIND] != SEGMENT:
        return False
    start, end = codes[f, AT_START] == ENDLESS, codes[f, AT_END] == ENDLESS
    if not start:
        start = shape[f, TX0] * (px - shape[f, X0]) + shape[f, TY0] * (py - shape[f, Y0]) > margin
    if not end:
        end = shape[f, TX1] * (px - shape[f, X1]) + shape[f, TY1] * (py - shape[f, Y1]) < -margin
    return bool(start and end)


def grid_of(faces: Faces, cell: float, reach: float, mark: Callable[..., None] | None = None) -> FaceGrid:
    """Cells for the search of faces.

    Parameters
    ----------
    faces : Faces
    cell : float
        Side of a cell, m; it is made wider where a wall has more than a million cells.
    reach : float
        Distance from a face up to which discs are listed, m.
    mark : callable, optional
        A faster `mark_cells`.
    """
    mark = mark_cells if mark is None else mark
    walls = len(faces.first) - 1
    box = boxes(faces) + np.array([-reach, reach, -reach, reach])
    wall_box, place, cells = np.zeros((walls, 4)), np.zeros((walls, 3)), np.ones((walls, 3), np.int64)
    starts, listed, total = [np.zeros(1, np.int64)], [], 0
    for wall in range(walls):
        begin, end = int(faces.first[wall]), int(faces.first[wall + 1])
        own = box[begin:end]
        x_low, x_high, y_low, y_high = wall_box[wall] = (*_span(own[:, :2]), *_span(own[:, 2:]))
        start, mine = np.array([end - begin]), np.arange(begin, end)
        cells[wall, 2] = sum(map(len, starts)) - 1
        if end - begin > FEW and np.isfinite(wall_box[wall]).all():
            side = max(cell, sqrt((x_high - x_low) * (y_high - y_low) / MOST_CELLS))
            columns, rows = int((x_high - x_low) / side) + 1, int((y_high - y_low) / side) + 1
            place[wall], cells[wall, :2] = (x_low, y_low, 1.0 / side), (columns, rows)
            ask = (faces, box, (begin, end), (*place[wall], columns, rows), reach)
            start = np.zeros(columns * rows + 1, np.int64)
            mark(*ask, start, np.empty(0, np.int64))
            ends = np.cumsum(start)
            mine = np.empty(ends[-1], np.int64)
            start = np.concatenate([[0], ends[:-1]])  # the first face of each cell, one place behind its own
            mark(*ask, start, mine)
            start = start[1:]
        starts.append(start + total)
        listed.append(mine)
        total += len(mine)
    return FaceGrid(
        box, wall_box, place, cells, np.concatenate(starts), np.concatenate([*listed, np.empty(0, np.int64)]), reach
    )


def _span(ends: np.ndarray) -> tuple[float, float]:
    return float(ends.min(initial=inf)), float(ends.max(initial=-inf))


def mark_cells(
    faces: Faces, box: np.ndarray, ends: tuple[int, int], cells: tuple[float, float, float, int, int],
    reach: float, start: np.ndarray, listed: np.ndarray,
) -> None:  # fmt: skip
    """Count the faces near each cell of one wall in ``start[cell + 1]``; with room in `listed`, list them from there.

    Parameters
    ----------
    faces : Faces
    box : ndarray
        As in `FaceGrid`.
    ends : (int, int)
        First face of the wall, and that behind its last.
    cells : (float, float, float, int, int)
        Lower left corner (m), cells per metre, columns, rows.
    reach : float
        m.
    start, listed : ndarray of int64
        Listing moves ``start[cell + 1]`` from the first to behind the last face of the cell.
    """
    x_low, y_low, inverse, columns, rows = cells
    far = reach + sqrt(0.5) / inverse

    def run(low: float, high: float, corner: float, most: int) -> range:
        return range(max(int((low - corner) * inverse), 0), min(int((high - corner) * inverse) + 1, most))

    for f in range(*ends):
        for column in run(box[f, 0], box[f, 1], x_low, columns):
            for row in run(box[f, 2], box[f, 3], y_low, rows):
                px, py = x_low + (column + 0.5) / inverse, y_low + (row + 0.5) / inverse
                if abs(away(faces, f, px, py)) <= far:
                    cell = column * rows + row
                    if listed.size:
                        listed[start[cell + 1]] = f
                    start[cell + 1] += 1


def list_near(
    seen: tuple[int, np.ndarray, np.ndarray],
    wall: int,
    faces: Faces,
    grid: FaceGrid,
    room: Room,
    found: tuple[int, int],
) -> tuple[int, int]:
    """List the discs near one wall, in its own frame, and the faces near each; returns (rows, faces), or -1: too short.

    Parameters
    ----------
    seen : (int, ndarray, ndarray)
        Number of discs and their places, m.
    wall : int
    faces : Faces
    grid : FaceGrid
    room : (ndarray, ndarray, ndarray, ndarray)
        Takes discs, plain, last and near. Row r of the list is disc ``discs[r]`` with the faces
        ``near[last[r]:last[r + 1]]``; ``plain[r]`` is 1 where there is one straight face whose ends are out of reach.
    found : (int, int)
        Row and face to go on from.
    """
    (n, x, y), (discs, plain, last, near), (row, count) = seen, room, found
    a, b, c, d = grid.wall_box[wall, 0], grid.wall_box[wall, 1], grid.wall_box[wall, 2], grid.wall_box[wall, 3]
    x_low, y_low, inverse = grid.place[wall, 0], grid.place[wall, 1], grid.place[wall, 2]
    columns, rows, offset = grid.cells[wall, 0], grid.cells[wall, 1], grid.cells[wall, 2]
    box, reach = grid.box, grid.reach
    for i in range(n):
        px, py = x[i], y[i]
        if not (px > a and px < b and py > c and py < d):
            continue
        cell = offset
        if inverse > 0.0:
            column = min(max(int((px - x_low) * inverse), 0), columns - 1)
            cell += column * rows + min(max(int((py - y_low) * inverse), 0), rows - 1)
        first, end = grid.start[cell], grid.start[cell + 1]
        if row + 1 >= last.size or count + end - first > near.size:
            return row, -1
        begin = count
        for p in range(first, end):
            f = grid.faces[p]
            if px > box[f, 0] and px < box[f, 1] and py > box[f, 2] and py < box[f, 3]:
                gap = away(faces, f, px, py)
                if gap < reach and (faces.deep[wall] == 1 or gap > -reach):
                    near[count] = f
                    count += 1
        if count > begin:
            discs[row] = i
            plain[row] = count == begin + 1 and _plain(faces, near[begin], px, py, reach)
            row += 1
            last[row] = count
    return row, count
