# SPDX-License-Identifier: GPL-2.0-or-later
"""Crossings of walls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import hypot, sqrt

import numpy as np

from lammps_jump.scene.chains import Chain, Face, faces_of_chain
from lammps_jump.scene.shapes import common

from .strokes import Point

MOST_COMPARED = 20_000_000
"""Pairs of faces, beside each other along one axis, that are looked through."""
MOST_CLOSE = 300_000
"""Pairs of faces whose boxes meet, that are held against each other."""


class TooManyFaces(ValueError):
    """Too many faces lie beside each other."""


def crossings(walls: Sequence[Sequence[Chain]], near: float) -> Iterator[tuple[int, int, Point]]:
    """Numbers of two walls that cross, and a place, m; each two once, in their order.

    Ends and corners of both that lie on each other are no crossing.

    Raises
    ------
    TooManyFaces
        More pairs of faces than can be looked at in seconds.
    """
    if len(walls) < 2:
        return
    faces = [(wall, face) for wall, chains in enumerate(walls) for chain in chains for face in faces_of_chain(chain)]
    crossed: dict[tuple[int, int], Point] = {}
    for i, j in _close(faces, near):
        (one, a), (two, b) = faces[i], faces[j]
        if (one, two) not in crossed and (found := _cross(a, b, near)):
            crossed[one, two] = found
    yield from ((one, two, crossed[one, two]) for one, two in sorted(crossed))


def _cross(a: Face, b: Face, near: float) -> Point | None:
    """A place where two faces cross, m."""
    for point in common(a, b, near):
        if not (_at(point, a.start, a.end, near) and _at(point, b.start, b.end, near)):
            return point
    return None


def _close(faces: Sequence[tuple[int, Face]], near: float) -> Iterator[tuple[int, int]]:
    """Pairs of faces of different walls whose boxes meet, by their numbers, that of the earlier wall first."""
    wall = np.array([number for number, _ in faces])
    box = np.array([_box(face) for _, face in faces])
    box[:, [0, 2]] -= near
    box[:, [1, 3]] += near
    orders = []
    for low in (0, 2):  # along x and along y: that in which fewer lie beside each other
        order = np.argsort(box[:, low], kind="stable")
        ends = np.searchsorted(box[order, low], box[order, low + 1], side="right")
        orders.append((int((ends - np.arange(len(order)) - 1).sum()), low, order, ends))
    beside, low, order, ends = min(orders, key=lambda item: item[0])
    if beside > MOST_COMPARED:
        raise TooManyFaces(f"{beside:,} pairs of faces lie beside each other")
    other, count = 2 - low, 0
    for rank, i in enumerate(order):
        later = order[rank + 1 : ends[rank]]
        meet = (box[later, other] <= box[i, other + 1]) & (box[later, other + 1] >= box[i, other])
        found = later[meet & (wall[later] != wall[i])]
        count += len(found)
        if count > MOST_CLOSE:
            raise TooManyFaces(f"more than {MOST_CLOSE:,} pairs of faces lie close to each other")
        for j in found.tolist():
            yield (int(i), j) if wall[i] < wall[j] else (j, int(i))


def _box(face: Face) -> tuple[float, float, float, float]:
    """A box around a face, m: of an arc that of its chord, wider by its sagitta."""
    (x0, y0), (x1, y1) = face.start, face.end
    half, radius = 0.5 * hypot(x1 - x0, y1 - y0), abs(face.radius)
    wider = radius - sqrt(max(radius * radius - half * half, 0.0)) if radius else 0.0
    return min(x0, x1) - wider, max(x0, x1) + wider, min(y0, y1) - wider, max(y0, y1) + wider


def _at(point: Point, start: Point, end: Point, near: float) -> bool:
    """Tells whether a point is one of two ends."""
    return any(hypot(point[0] - x, point[1] - y) <= 1e3 * near for x, y in (start, end))
