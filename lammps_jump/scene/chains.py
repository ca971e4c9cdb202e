# SPDX-License-Identifier: GPL-2.0-or-later
"""Chains of faces: the one shape that every wall is made of.

A face is a straight segment or a circular arc of at most a quarter turn. A chain is drawn with the discs on its left. A
floor runs from left to right, the outline of a solid clockwise, that of a hollow counter-clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, pi, radians, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.core.columns import FaceKind, Joint
from lammps_jump.physics.elementary import asin, atan2, cos, hypot, sin

Point = tuple[float, float]

SEGMENT, ARC = (kind.value for kind in FaceKind)
"""Kinds of faces."""
CONVEX, SMOOTH, CORNER, FREE, ENDLESS = (joint.value for joint in Joint)
"""Kinds of joints: a turn away from the discs; one towards them, up to `SMOOTH_TURN`; beyond it; open; none."""
SMOOTH_TURN = radians(5.0)
"""Largest turn towards the discs at which two faces push as one, rad. Smaller ones rock in a V, larger ones jump."""

KIND, WALL, RUN, LOOP, BEFORE, AFTER, AT_START, AT_END = range(8)
"""Columns of `Faces.codes`."""
X0, Y0, X1, Y1, TX0, TY0, TX1, TY1, CX, CY, RADIUS, PHI, SWEEP, LENGTH, ARC_LENGTH = range(15)
"""Columns of `Faces.shape`."""


@dataclass(frozen=True)
class Chain:
    """Faces that follow each other.

    Attributes
    ----------
    points : tuple of (float, float)
        Corners in order, m.
    bends : tuple of float
        Radius (m) of the arc from each point to the next; above 0 it turns left, below 0 right; 0 is straight. Of the
        two arcs it is the shorter one. Empty: all are straight.
    closed : bool
        The last point is joined to the first.
    endless : bool
        The line through two points, without ends.
    """

    points: tuple[Point, ...]
    bends: tuple[float, ...] = ()
    closed: bool = False
    endless: bool = False


class Face(NamedTuple):
    """One face: its kind, ends (m), directions there, and of an arc the centre and radius (m; below 0: turns right)."""

    kind: int
    start: Point
    end: Point
    first: Point
    last: Point
    centre: Point = (0.0, 0.0)
    radius: float = 0.0
    sweep: float = 0.0

    @property
    def length(self) -> float:
        """Length along the face, m."""
        return abs(self.radius * self.sweep) if self.kind == ARC else hypot(*np.subtract(self.end, self.start))


class Faces(NamedTuple):
    """Faces of walls as flat arrays; a row a face.

    Attributes
    ----------
    codes : ndarray of int64, shape (faces, 8)
        Kind; wall; run (faces without a corner between them); whether the run is a closed loop; the faces before and
        after (-1: none); the kinds of both joints.
    shape : ndarray, shape (faces, 15)
        Both ends (m), unit directions there, centre and radius (m), tangent angle at the start, unwrapped along the
        chain (rad), its change along the face (rad), length and arc length at the start (m).
    first : ndarray of int64, shape (walls + 1,)
        First face of each wall.
    deep : ndarray of int64, shape (walls,)
        1 where discs behind a face are pushed back from any depth.
    """

    codes: np.ndarray
    shape: np.ndarray
    first: np.ndarray
    deep: np.ndarray


FACE = np.dtype([("codes", np.int64, 8), ("shape", float, 15)])
"""A row of `Faces` as the core has it (``core/walls/faces.h``)."""


def records_of(faces: Faces) -> np.ndarray:
    """Faces as the core has them, shape (faces,) of `FACE`."""
    records = np.empty(len(faces.codes), FACE)
    records["codes"], records["shape"] = faces.codes, faces.shape
    return records


def _straight(start: Point, end: Point) -> Face:
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = hypot(dx, dy)
    along = dx / length, dy / length
    return Face(SEGMENT, start, end, along, along)


def _arc(start: Point, end: Point, radius: float) -> list[Face]:
    """Arc from one point to another as pieces of at most a quarter turn."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    chord = hypot(dx, dy)
    half = min(1.0, chord / (2 * abs(radius)))
    sweep = 2 * asin(half) * (1 if radius > 0 else -1)
    away = radius * sqrt(1 - half * half) / chord
    centre = 0.5 * (start[0] + end[0]) - away * dy, 0.5 * (start[1] + end[1]) + away * dx
    pieces = max(1, ceil(abs(sweep) / (0.5 * pi) - 1e-9))
    begin = atan2(start[1] - centre[1], start[0] - centre[0])
    corners = [start, *(_on(centre, radius, begin + sweep * i / pieces) for i in range(1, pieces)), end]
    return [_piece(centre, radius, sweep / pieces, *ends) for ends in pairwise(corners)]


def _on(centre: Point, radius: float, angle: float) -> Point:
    return centre[0] + abs(radius) * cos(angle), centre[1] + abs(radius) * sin(angle)


def _piece(centre: Point, radius: float, sweep: float, start: Point, end: Point) -> Face:
    first, last = (
        (
            -(y - centre[1]) / radius / (length := hypot(x - centre[0], y - centre[1]) / abs(radius)),
            (x - centre[0]) / radius / length,
        )
        for x, y in (start, end)
    )
    return Face(ARC, start, end, first, last, centre, radius, sweep)


def circle(centre: Point, radius: float, *, inside: bool) -> Chain:
    """A whole circle, with the discs inside or outside it."""
    (x, y), r = centre, radius
    points = (x + r, y), (x, y + r), (x - r, y), (x, y - r)
    return Chain(points if inside else points[::-1], (r if inside else -r,) * 4, closed=True)


def faces_of_chain(chain: Chain) -> list[Face]:
    """Faces of a chain in order; arcs in pieces of at most a quarter turn."""
    ends = (*chain.points, chain.points[0]) if chain.closed else chain.points
    bends = chain.bends or (0.0,) * (len(ends) - 1)
    faces: list[Face] = []
    for start, end, bend in zip(ends, ends[1:], bends, strict=False):
        faces += _arc(start, end, bend) if bend else [_straight(start, end)]
    return faces


def turn(before: Face, after: Face) -> float:
    """Turn from one face to the next, rad, positive towards the discs; a turn right about is -pi."""
    (ax, ay), (bx, by) = before.last, after.first
    angle = atan2(ax * by - ay * bx, ax * bx + ay * by)
    return -pi if angle > pi - 1e-9 else angle


def joint(angle: float) -> int:
    """Kind of a joint by its turn, rad."""
    if angle < 0:
        return CONVEX
    return SMOOTH if angle <= SMOOTH_TURN * (1 + 1e-9) else CORNER


def lay(walls: list[tuple[tuple[Chain, ...], bool]]) -> Faces:
    """Flat faces of walls, each given by its chains and whether it pushes from any depth."""
    codes: list[tuple[int, ...]] = []
    shape: list[tuple[float, ...]] = []
    first, run = [0], 0
    for wall, (chains, _) in enumerate(walls):
        for chain in chains:
            rows, numbers, run = _chain_rows(chain, wall, run, len(codes))
            codes += rows
            shape += numbers
        first.append(len(codes))
    return Faces(
        np.array(codes, np.int64).reshape(-1, 8),
        np.array(shape, float).reshape(-1, 15),
        np.array(first, np.int64),
        np.array([deep for _, deep in walls], np.int64),
    )


def _chain_rows(
    chain: Chain, wall: int, run: int, begin: int
) -> tuple[list[tuple[int, ...]], list[tuple[float, ...]], int]:
    """Rows of the faces of one chain, and the number of the next run; `begin` is the index of its first face."""
    faces = faces_of_chain(chain)
    count = len(faces)
    outer = ENDLESS if chain.endless else FREE
    turns = [turn(faces[i - 1], faces[i]) for i in range(count)]  # at the start of each face
    at_start = [joint(angle) if i or chain.closed else outer for i, angle in enumerate(turns)]
    corners = [i for i in range(count) if at_start[i] == CORNER]
    if chain.closed and corners:  # a run must not go over the place where the numbers begin
        shift = corners[0]
        faces, turns = faces[shift:] + faces[:shift], turns[shift:] + turns[:shift]
        at_start = at_start[shift:] + at_start[:shift]
    loop = chain.closed and not corners
    phi, way = atan2(faces[0].first[1], faces[0].first[0]), 0.0
    rows: list[tuple[int, ...]] = []
    numbers: list[tuple[float, ...]] = []
    for i, face in enumerate(faces):
        if i:
            phi += turns[i]
            run += at_start[i] == CORNER
        before = begin + i - 1 if i else (begin + count - 1 if chain.closed else -1)
        after = begin + i + 1 if i < count - 1 else (begin if chain.closed else -1)
        at_end = at_start[(i + 1) % count] if chain.closed or i < count - 1 else outer
        rows.append((face.kind, wall, run, int(loop), before, after, at_start[i], at_end))
        ends = (*face.start, *face.end, *face.first, *face.last)
        numbers.append((*ends, *face.centre, face.radius, phi, face.sweep, face.length, way))
        phi += face.sweep
        way += face.length
    return rows, numbers, run + 1


def moved(faces: Faces, pose: tuple[float, float, float], about: Point) -> Faces:
    """Faces of a wall that is displaced by ``pose[:2]`` (m) and turned by ``pose[2]`` (rad) about a point (m)."""
    shape = faces.shape.copy()
    c, s = cos(pose[2]), sin(pose[2])
    for x, y, ox, oy, px, py in (
        *((column, column + 1, *about, pose[0], pose[1]) for column in (X0, X1, CX)),
        *((column, column + 1, 0.0, 0.0, 0.0, 0.0) for column in (TX0, TX1)),
    ):
        dx, dy = faces.shape[:, x] - ox, faces.shape[:, y] - oy
        shape[:, x], shape[:, y] = ox + px + c * dx - s * dy, oy + py + s * dx + c * dy
    shape[:, PHI] += pose[2]
    return faces._replace(shape=shape)


def boxes(faces: Faces, *, deep: bool = True) -> np.ndarray:
    """Smallest box of each face, (xlo, xhi, ylo, yhi), m, shape (faces, 4).

    Without end where the face has none and, if `deep`, behind the faces of a wall that pushes from any depth.
    """
    boxes_of_faces = np.empty((len(faces.codes), 4))
    for i, (code, row) in enumerate(zip(faces.codes, faces.shape, strict=True)):
        xs, ys = _spread(code, row)
        if deep and faces.deep[code[WALL]]:
            nx, ny = -row[TY0], row[TX0]
            xs += [-inf if nx > 0 else inf] if abs(nx) > 1e-12 else []
            ys += [-inf if ny > 0 else inf] if abs(ny) > 1e-12 else []
        boxes_of_faces[i] = min(xs), max(xs), min(ys), max(ys)
    return boxes_of_faces


def _spread(code: np.ndarray, row: np.ndarray) -> tuple[list[float], list[float]]:
    """Coordinates whose smallest and largest bound a face."""
    xs, ys = [row[X0], row[X1]], [row[Y0], row[Y1]]
    if code[AT_START] == ENDLESS:
        xs += [-inf, inf] if abs(row[TX0]) > 1e-12 else []
        ys += [-inf, inf] if abs(row[TY0]) > 1e-12 else []
    if code[KIND] == ARC:
        for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            x, y = row[CX] + abs(row[RADIUS]) * dx, row[CY] + abs(row[RADIUS]) * dy
            if (
                row[TX0] * (x - row[X0]) + row[TY0] * (y - row[Y0])
                > 0
                > row[TX1] * (x - row[X1]) + row[TY1] * (y - row[Y1])
            ):
                xs.append(x)
                ys.append(y)
    return xs, ys


def distance(faces: Faces, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """Distance of points to the nearest face, m; negative behind it; an array of x's shape.

    Parameters
    ----------
    faces : Faces
    x, y : array_like, m
    """
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    count = len(faces.codes)
    if count <= BUNCH:
        return _nearest(faces, range(count), x, y, np.full(x.shape, inf))
    px, py, box = x.ravel(), y.ravel(), boxes(faces, deep=False)
    bunches = [range(first, min(first + BUNCH, count)) for first in range(0, count, BUNCH)]
    known = np.full(px.shape, inf)  # no point is farther from the faces than from one of their ends
    for bunch in bunches:
        known = np.minimum(known, np.hypot(px - faces.shape[bunch[0], X0], py - faces.shape[bunch[0], Y0]))
    distances = np.full(px.shape, inf)
    for bunch in bunches:
        (xlo, xhi), (ylo, yhi) = ((box[bunch, a].min(), box[bunch, a + 1].max()) for a in (0, 2))
        apart = np.hypot(
            np.maximum(0.0, np.maximum(xlo - px, px - xhi)), np.maximum(0.0, np.maximum(ylo - py, py - yhi))
        )
        near = apart <= known * (1 + 1e-9) + 1e-12
        if near.any():
            distances[near] = _nearest(faces, bunch, px[near], py[near], distances[near])
    return distances.reshape(x.shape)


BUNCH = 32
"""Faces that are left out together where a point is nearer to others."""


def _nearest(faces: Faces, some: range, x: np.ndarray, y: np.ndarray, nearest: np.ndarray) -> np.ndarray:
    """Signed distance of points to the nearest of some faces, or `nearest` where that is less, m."""
    lowest = _rank(nearest)
    for face in some:
        gap = _gap(faces, face, x, y)
        rank = _rank(gap)
        nearest, lowest = np.where(rank < lowest, gap, nearest), np.minimum(rank, lowest)
    return nearest


def _rank(gap: np.ndarray) -> np.ndarray:
    """Distance by which faces are compared, m: of two at the same, but for round-off, the one in front counts."""
    return np.where(gap < 0, np.abs(gap) * (1 + 1e-9) + 1e-12, gap)


def _gap(faces: Faces, face: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Signed distance of points to one face, m.

    Beyond a convex joint or an open end every point is in front; beyond another joint, what is in front of both faces.
    """
    code, row = faces.codes[face], faces.shape[face]
    dx, dy, ex, ey = x - row[X0], y - row[Y0], x - row[X1], y - row[Y1]
    if code[KIND] == ARC:
        out = np.hypot(x - row[CX], y - row[CY])
        gap = row[RADIUS] - out if row[RADIUS] > 0 else out + row[RADIUS]
    else:
        gap = row[TX0] * dy - row[TY0] * dx
    for joined, ux, uy, tx, ty, side, other, ox, oy in (
        (code[AT_START], dx, dy, row[TX0], row[TY0], -1.0, code[BEFORE], TX1, TY1),
        (code[AT_END], ex, ey, row[TX1], row[TY1], 1.0, code[AFTER], TX0, TY0),
    ):
        if joined == ENDLESS:
            continue
        beyond = side * (tx * ux + ty * uy) > 0
        front = np.ones(x.shape, bool)
        if joined not in (CONVEX, FREE):
            neighbour = faces.shape[other]
            front = (tx * uy - ty * ux >= 0) & (neighbour[ox] * uy - neighbour[oy] * ux >= 0)
        away = np.hypot(ux, uy)
        gap = np.where(beyond, np.where(front, away, -away), gap)
    return gap


def grounds(faces: Faces, x: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Solids over x as pairs (underside, top), m, each of x's shape; NaN where there is none.

    An upright line at x goes through tops, where a face looks up, and undersides. A top without an underside below it
    rests on solid without end.
    """
    x = np.asarray(x, float)
    flat = x.ravel()
    tops, bottoms = (_stacked(len(flat), *crossed) for crossed in _crossings(faces, flat))
    solids = []
    below = np.full(flat.shape, -inf)
    corners = faces.shape[:, [X0, Y0, X1, Y1]]
    # the two faces of a sheet lie upon each other, but for round-off
    tiny = 1e-12 * abs(corners[np.isfinite(corners)]).max(initial=0.0)
    for top in tops:
        under = np.where((bottoms <= top + tiny) & (bottoms >= below), bottoms, -inf).max(axis=0, initial=-inf)
        under = np.minimum(under, top)
        solids.append((np.where(np.isnan(top), np.nan, under).reshape(x.shape), top.reshape(x.shape)))
        below = np.where(np.isnan(top), below, top)
    return solids


def _crossings(faces: Faces, x: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Crossings of upright lines at x with faces that look up, and such that look down: (index of x, height, m)."""
    shape, arc = faces.shape, faces.codes[:, KIND] == ARC
    wide = 1.001 * abs(shape[:, RADIUS])  # round-off must leave no point out
    endless = faces.codes[:, AT_START] == ENDLESS
    low = np.where(arc, shape[:, CX] - wide, np.minimum(shape[:, X0], shape[:, X1]))
    high = np.where(arc, shape[:, CX] + wide, np.maximum(shape[:, X0], shape[:, X1]))
    upright = ~arc & (abs(shape[:, TX0]) < 1e-12)
    order = np.argsort(x, kind="stable")
    begin = np.searchsorted(x[order], np.where(endless, -inf, low), "left")
    end = np.where(upright, begin, np.searchsorted(x[order], np.where(endless, inf, high), "right"))
    counts = end - begin
    face = np.repeat(np.arange(len(shape)), counts)
    index = order[np.arange(len(face)) + np.repeat(begin - np.cumsum(counts) + counts, counts)]
    place, (x0, y0, tx, ty) = x[index], (shape[face, column] for column in (X0, Y0, TX0, TY0))
    with np.errstate(invalid="ignore", divide="ignore"):
        line = y0 + np.where(ty == 0, 0.0, (place - x0) * (ty / tx))
    crossings, bent = [], np.flatnonzero(arc[face])
    for up in (True, False):
        met, y = (tx > 0) == up, line
        if len(bent):
            y = line.copy()
            met[bent], y[bent] = _on_arcs(shape[face[bent]].T, place[bent], up)
        crossings.append((index[met], y[met]))
    return crossings


def _on_arcs(row: np.ndarray, place: np.ndarray, up: bool) -> tuple[np.ndarray, np.ndarray]:
    """Tells whether an upright line at each place meets the half of its arc that looks up or down; its height, m."""
    out = place - row[CX]
    with np.errstate(invalid="ignore"):
        rise = np.sqrt(row[RADIUS] * row[RADIUS] - out * out)
        # the half of a circle that looks up is the upper one where the arc turns right
        y = row[CY] + np.where((row[RADIUS] < 0) == up, rise, -rise)
        on = (row[TX0] * (place - row[X0]) + row[TY0] * (y - row[Y0]) >= 0) & (
            row[TX1] * (place - row[X1]) + row[TY1] * (y - row[Y1]) <= 0
        )
    return on, y


def _stacked(count: int, index: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Heights by the index of their x, ascending, shape (most at one x, count), m; NaN after the last of each."""
    order = np.lexsort((height, index))
    index, height = index[order], height[order]
    number = np.arange(len(index)) - np.searchsorted(index, index)
    stacked = np.full((int(number.max(initial=-1)) + 1, count), np.nan)
    stacked[number, index] = height
    return stacked


ARC_STEPS = 12
"""Straight lines that draw a face that is an arc."""


def outline(chain: Chain) -> np.ndarray:
    """Closed polygon of a chain, shape (corners, 2), m; arcs as straight lines, an open chain there and back."""
    corners: list[Point] = []
    for face in faces_of_chain(chain):
        corners.append(face.start)
        if face.kind == ARC:
            begin = atan2(face.start[1] - face.centre[1], face.start[0] - face.centre[0])
            angles = (begin + face.sweep * i / ARC_STEPS for i in range(1, ARC_STEPS))
            corners += [_on(face.centre, face.radius, angle) for angle in angles]
    return np.array(corners if chain.closed else [*corners, chain.points[-1], *corners[:0:-1]])


def bed_over(solids: list[tuple[np.ndarray, np.ndarray]], x: ArrayLike, smallest: float) -> np.ndarray:
    """Height of the bed at x, m, over solids (`grounds`), as `walls.bed_height` says."""
    x = np.asarray(x, float)
    bed = np.full(x.shape, -np.inf)
    if solids:
        undersides, tops = (np.array(part) for part in zip(*solids, strict=True))
        order = np.argsort(undersides, axis=0, kind="stable")
        undersides, tops = (np.take_along_axis(part, order, 0) for part in (undersides, tops))
        for underside, top in zip(undersides, tops, strict=True):
            carried = np.isinf(bed) | (underside <= bed + smallest)
            bed = np.where(carried & (top > bed), top, bed)
    return np.where(np.isinf(bed), np.nan, bed)
