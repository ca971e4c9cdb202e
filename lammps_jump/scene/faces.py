# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of a disc with a wall of faces: which faces push, from where, and the cells that list faces near a disc.

The rule. A face gives a candidate where its foot, the nearest point, lies inside it; a joint gives one where the feet
of both neighbours lie on it. At a corner, a face whose foot is its end keeps a candidate of its own. If the nearest
candidate is behind its face, the centre is inside the solid, and that face alone pushes. Else the deepest pushes, and
with it each one of another run, or of the same run whose tangent differs by more than `SMOOTH_TURN` from those that
push already. The energy of a contact without friction is then k/2 times the sum over runs of the squared overlap, and
continuous. Planes and boxes push from any depth, each face on its own.

Plain loops, which the twin calls. The core and the plugin hold their own copies (``faces.h``); tests compare them.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor, inf, pi, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.physics.elementary import atan2

from .chains import (
    AFTER,
    ARC,
    ARC_LENGTH,
    AT_END,
    AT_START,
    BEFORE,
    CONVEX,
    CORNER,
    CX,
    CY,
    ENDLESS,
    FREE,
    KIND,
    LENGTH,
    LOOP,
    PHI,
    RADIUS,
    RUN,
    SEGMENT,
    SMOOTH_TURN,
    SWEEP,
    TX0,
    TX1,
    TY0,
    TY1,
    X0,
    X1,
    Y0,
    Y1,
    Faces,
    boxes,
)

MOST = 16
"""Contacts of a disc with one wall, at most: the deepest ones."""
SAME_TURN = SMOOTH_TURN * (1 + 1e-6)
"""Turn between two contacts of a run up to which they are one, rad; a little above the limit of a smooth joint."""
TIE = 1e-9
"""Radii by which a face behind must be nearer than one in front: round-off parts the two faces of a sheet."""
NOWHERE, INSIDE, BEGIN, END = range(4)
"""Place of the foot of a candidate; `NOWHERE`: no candidate."""
Disc = tuple[float, float, float]
"""Place and radius of a disc, m."""


def _ends(faces: Faces, f: int, px: float, py: float) -> tuple[bool, bool]:
    """Tells whether the foot of a point lies at or before the start of a face, and at or after its end."""
    codes, shape = faces[:2]
    before = codes[f, AT_START] != ENDLESS
    if before:
        before = shape[f, TX0] * (px - shape[f, X0]) + shape[f, TY0] * (py - shape[f, Y0]) <= 0.0
    behind = codes[f, AT_END] != ENDLESS
    if behind:
        behind = shape[f, TX1] * (px - shape[f, X1]) + shape[f, TY1] * (py - shape[f, Y1]) >= 0.0
    return before, behind


def _at_joint(shape: np.ndarray, f: int, end: bool, front: bool, px: float, py: float) -> tuple[float, float, float]:
    """Signed distance of a point to one end of a face, and the unit vector from there; the face's normal on the end."""
    if end:
        vx, vy, tx, ty = shape[f, X1], shape[f, Y1], shape[f, TX1], shape[f, TY1]
    else:
        vx, vy, tx, ty = shape[f, X0], shape[f, Y0], shape[f, TX0], shape[f, TY0]
    dx, dy = px - vx, py - vy
    r = sqrt(dx * dx + dy * dy)
    if r == 0.0:
        return 0.0, -ty, tx
    if front:
        return r, dx / r, dy / r
    return -r, -dx / r, -dy / r


def _in_front(shape: np.ndarray, f: int, end: bool, px: float, py: float) -> bool:
    """Tells whether a point lies in front of the line that touches a face at one end."""
    if end:
        return shape[f, TX1] * (py - shape[f, Y1]) - shape[f, TY1] * (px - shape[f, X1]) >= 0.0
    return shape[f, TX0] * (py - shape[f, Y0]) - shape[f, TY0] * (px - shape[f, X0]) >= 0.0


def _candidate(faces: Faces, f: int, px: float, py: float) -> tuple[int, float, float, float]:
    """Candidate of a face for a point: (place of the foot, signed distance in m, normal).

    The distance is negative behind the face. A joint counts once, at the end of the face before it.
    """
    codes, shape = faces[:2]
    before, behind = _ends(faces, f, px, py)
    if not before and not behind:
        if codes[f, KIND] == ARC:
            dx, dy = px - shape[f, CX], py - shape[f, CY]
            r = sqrt(dx * dx + dy * dy)
            rho = shape[f, RADIUS]
            if r == 0.0:
                return NOWHERE, inf, 0.0, 0.0
            if rho > 0.0:
                return INSIDE, rho - r, -dx / r, -dy / r
            return INSIDE, r + rho, dx / r, dy / r
        tx, ty = shape[f, TX0], shape[f, TY0]
        return INSIDE, tx * (py - shape[f, Y0]) - ty * (px - shape[f, X0]), -ty, tx
    joint = codes[f, AT_END] if behind else codes[f, AT_START]
    front = joint == CONVEX or joint == FREE or _in_front(shape, f, behind, px, py)
    shared = False
    if joint != FREE:
        # the neighbour answers by the same function: no point falls between two answers
        if behind:
            shared = _ends(faces, codes[f, AFTER], px, py)[0]
        else:
            shared = _ends(faces, codes[f, BEFORE], px, py)[1]
    if joint == FREE or (shared and behind) or (joint == CORNER and front and not shared):
        gap, nx, ny = _at_joint(shape, f, behind, front, px, py)
        return END if behind else BEGIN, gap, nx, ny
    return NOWHERE, inf, 0.0, 0.0


def _tangent(faces: Faces, f: int, place: int, nx: float, ny: float) -> float:
    """Angle of the wall's tangent at a candidate, rad, unwrapped along the chain."""
    codes, shape = faces[:2]
    phi = shape[f, PHI]
    if place == INSIDE and codes[f, KIND] != ARC:
        return phi
    tx, ty = shape[f, TX0], shape[f, TY0]
    if place == END:
        phi += shape[f, SWEEP]
        tx, ty = shape[f, TX1], shape[f, TY1]
    angle = atan2(tx * -nx - ty * ny, tx * ny - ty * nx)
    if place == END and codes[f, AT_END] == CONVEX and angle > 0.5 * pi:
        angle -= 2.0 * pi
    return phi + angle


def _apart(faces: Faces, f: int, g: int, one: float, two: float) -> bool:
    """Tells whether contacts of faces f and g, with these tangent angles, push each on its own."""
    codes = faces.codes
    if codes[f, RUN] != codes[g, RUN]:
        return True
    turn = abs(one - two)
    if codes[f, LOOP] == 1:
        turn -= 2.0 * pi * floor(turn / (2.0 * pi))
        turn = min(turn, 2.0 * pi - turn)
    return turn > SAME_TURN


def touching(faces: Faces, deep: int, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc with one wall; returns their number.

    Parameters
    ----------
    faces : Faces
    deep : int
        1 where the wall pushes from any depth.
    near : ndarray of int64
        The faces to look at.
    disc : (float, float, float)
        Place and radius, m.
    found : ndarray, shape (MOST, 4)
        Takes signed distance (m), normal and tangent angle (rad) of each contact, the deepest first.
    which : ndarray of int64, shape (MOST,)
        Takes the face of each contact.
    """
    px, py, radius = disc
    codes, shape = faces[:2]
    if deep == 1:
        return _behind(faces, near, disc, found, which)
    nearest = deepest = lowest = inf
    touch = 0
    for f in near:
        place = NOWHERE
        if codes[f, KIND] == SEGMENT:  # as `_candidate`, without a call: most faces near a disc have no candidate
            tx, ty, dx, dy = shape[f, TX0], shape[f, TY0], px - shape[f, X0], py - shape[f, Y0]
            line = tx * dy - ty * dx
            if line >= radius or line <= -radius:
                continue
            start, end = codes[f, AT_START], codes[f, AT_END]
            if tx * dx + ty * dy <= 0.0 and start != ENDLESS:
                if start != FREE and start != CORNER:
                    continue
            elif tx * (px - shape[f, X1]) + ty * (py - shape[f, Y1]) >= 0.0 and end != ENDLESS:
                g = codes[f, AFTER]
                if end != FREE and end != CORNER:
                    if shape[g, TX0] * (px - shape[g, X0]) + shape[g, TY0] * (py - shape[g, Y0]) > 0.0:
                        continue
            else:
                place, gap, nx, ny = INSIDE, line, -ty, tx
        if place == NOWHERE:
            place, gap, nx, ny = _candidate(faces, f, px, py)
            if place == NOWHERE:
                continue
        away = abs(gap)
        if gap < 0.0:
            away += TIE * radius
        if away < lowest:
            nearest, lowest = gap, away
            if gap < 0.0:
                found[0, 0], found[0, 1], found[0, 2] = gap, nx, ny
                which[0] = f
        if gap >= 0.0 and gap < radius:
            touch += 1
            if gap < deepest:
                deepest = gap
                if nearest >= 0.0:
                    found[0, 0], found[0, 1], found[0, 2] = gap, nx, ny
                    which[0] = f
    if nearest < 0.0:
        return 1 if -nearest < radius else 0
    if touch < 2:
        return touch
    return _select(faces, near, disc, found, which)


def _out_of_reach(faces: Faces, f: int, px: float, py: float, front: float, behind: float) -> bool:
    """Tells whether a point is further in front of or behind the line of a straight face than this (m)."""
    codes, shape = faces[:2]
    if codes[f, KIND] != SEGMENT:
        return False
    line = shape[f, TX0] * (py - shape[f, Y0]) - shape[f, TY0] * (px - shape[f, X0])
    return line >= front or line <= behind


def _behind(faces: Faces, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc with a wall that pushes from any depth: each face on its own."""
    px, py, radius = disc
    kept = 0
    for f in near:
        if _out_of_reach(faces, f, px, py, radius, -inf):
            continue
        place, gap, nx, ny = _candidate(faces, f, px, py)
        if place == INSIDE and gap < radius and kept < MOST:
            found[kept, 0], found[kept, 1], found[kept, 2] = gap, nx, ny
            which[kept] = f
            kept += 1
    return kept


def _select(faces: Faces, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc that several candidates touch, in front: the deepest, then those that push on their own."""
    px, py, radius = disc
    kept = 0
    while kept < MOST:
        best = radius
        for f in near:
            if _out_of_reach(faces, f, px, py, best, -best):
                continue
            place, gap, nx, ny = _candidate(faces, f, px, py)
            if place == NOWHERE or gap < 0.0 or gap >= best:
                continue
            angle = _tangent(faces, f, place, nx, ny)
            own = True
            for k in range(kept):
                own = own and (which[k] != f) and _apart(faces, f, which[k], angle, found[k, 3])
            if own:
                best = gap
                found[kept, 0], found[kept, 1], found[kept, 2], found[kept, 3] = gap, nx, ny, angle
                which[kept] = f
        if best == radius:
            break
        kept += 1
    return kept


def foot_at(faces: Faces, f: int, px: float, py: float) -> float:
    """Arc length of the foot of a point on a face, m, counted along the chain from its start.

    It names a place of the wall whatever the faces: a contact that goes on over a joint changes it by its way alone.
    """
    codes, shape = faces[:2]
    before, behind = _ends(faces, f, px, py)
    if before:
        return shape[f, ARC_LENGTH]
    if behind:
        return shape[f, ARC_LENGTH] + shape[f, LENGTH]
    tx, ty = shape[f, TX0], shape[f, TY0]
    if codes[f, KIND] == SEGMENT:
        return shape[f, ARC_LENGTH] + tx * (px - shape[f, X0]) + ty * (py - shape[f, Y0])
    dx, dy, rho = px - shape[f, CX], py - shape[f, CY], shape[f, RADIUS]
    out = ty * dx - tx * dy if rho > 0.0 else tx * dy - ty * dx  # along the radius at the start
    return shape[f, ARC_LENGTH] + abs(rho) * atan2(tx * dx + ty * dy, out)


def away(faces: Faces, f: int, px: float, py: float) -> float:
    """Distance of a point to a face, m; negative behind it, where its foot is inside."""
    shape = faces.shape
    before, behind = _ends(faces, f, px, py)
    if not before and not behind:
        return _candidate(faces, f, px, py)[1]
    first = _at_joint(shape, f, False, True, px, py)[0] if before else inf
    return min(first, _at_joint(shape, f, True, True, px, py)[0] if behind else inf)


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
    """Tells whether a point faces a straight face, a margin (m) from its ends: its line is then enough."""
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
            start = np.concatenate([[0], ends[:-1]])  # the first face of each cell, one place after its own
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
        First face of the wall, and that after its last.
    cells : (float, float, float, int, int)
        Lower left corner (m), cells per metre, columns, rows.
    reach : float
        m.
    start, listed : ndarray of int64
        Listing moves ``start[cell + 1]`` from the first to after the last face of the cell.
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
