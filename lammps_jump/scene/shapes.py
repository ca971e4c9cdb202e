# SPDX-License-Identifier: GPL-2.0-or-later
"""Chains that a case file draws by points, straight lines and arcs; what they must not do, and what is doubtful."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, pi, radians, sqrt
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag

from lammps_jump.physics.elementary import asin, atan2, hypot, sin
from lammps_jump.units import Metre
from lammps_jump.units import Point as GivenPoint

from .chains import (
    AFTER,
    ARC,
    AT_END,
    AT_START,
    ENDLESS,
    FREE,
    KIND,
    LENGTH,
    LOOP,
    RUN,
    SEGMENT,
    SMOOTH,
    SMOOTH_TURN,
    TX0,
    TX1,
    TY0,
    TY1,
    X0,
    X1,
    Y0,
    Y1,
    Chain,
    Face,
    Faces,
    Point,
    boxes,
    faces_of_chain,
    lay,
    turn,
)  # fmt: skip
from .tracks import MOST_ROWS

LEAST_RADIUS = 1e-6
"""Smallest radius of an arc, m."""
SAME = 1e-9
"""Distance over the size of a drawing up to which two points are one."""
MOST_CLOSE = 300_000
"""Pairs of faces of a wall whose boxes meet, that are held against each other: a second or two."""


class PlaceError(ValueError):
    """A mistake in one part of a field; `path` leads there from the whole."""

    def __init__(self, path: tuple[str | int, ...], text: str) -> None:
        super().__init__(text)
        self.path = path


def _some_radius(value: float) -> float:
    if abs(value) < LEAST_RADIUS:
        raise ValueError(
            f"{value:zg} m is no radius; allowed is {LEAST_RADIUS:zg} m or more (turns left) or "
            f"{-LEAST_RADIUS:zg} m or less (turns right): for a straight line write the point alone, [x, y]"
        )
    return value


Radius = Annotated[
    Metre,
    Field(
        ge=-1e6,
        le=1e6,
        description="above 0 where the arc turns left, below 0 where it turns right; the shorter arc is meant",
    ),
    AfterValidator(_some_radius),
]


@dataclass(frozen=True)
class ArcTo:
    """End of an arc that begins at the point before; of the two arcs, the shorter one."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")
    arc_to: Annotated[GivenPoint, Field(description="end of an arc from the point before")]
    radius: Radius


def _form(value: Any) -> str:
    return "<arc>" if isinstance(value, dict | ArcTo) else "<point>"


Vertex = Annotated[Annotated[GivenPoint, Tag("<point>")] | Annotated[ArcTo, Tag("<arc>")], Discriminator(_form)]
"""A point, or the end of an arc."""
Points = Annotated[
    tuple[Vertex, ...],
    Field(
        max_length=MOST_ROWS,
        description="corner after corner; a point is [x, y] or an arc, `{arc_to: [x, y], radius: r}`",
    ),
]


class Path(NamedTuple):
    """A drawing: its points (m), the bend to each following one (m; `Chain`), and whether it ends where it began.

    `turned`: it runs the other way than the points of the case.
    """

    points: tuple[Point, ...]
    bends: tuple[float, ...]
    closed: bool
    turned: bool = False

    @property
    def size(self) -> float:
        """Largest extent of the points, m."""
        return float(np.ptp(np.array(self.points), axis=0).max())

    @property
    def area(self) -> float:
        """Area inside a closed path, m^2; negative where it runs clockwise."""
        total = 0.0
        for (x0, y0), (x1, y1), bend in zip(self.points, (*self.points[1:], self.points[0]), self.bends, strict=True):
            total += 0.5 * (x0 * y1 - x1 * y0)
            if bend:
                sweep = 2 * asin(min(1.0, hypot(x1 - x0, y1 - y0) / (2 * abs(bend))))
                total += (1 if bend > 0 else -1) * 0.5 * bend * bend * (sweep - sin(sweep))
        return total

    def reversed(self) -> Path:
        """The same the other way round; a closed one begins at the same point."""
        points, bends = self.points[::-1], tuple(0.0 - bend for bend in self.bends[::-1])
        return Path((points[-1], *points[:-1]) if self.closed else points, bends, self.closed, not self.turned)

    def chain(self) -> Chain:
        """The chain of faces along it."""
        return Chain(self.points, self.bends if any(self.bends) else (), self.closed)


def drawn(given: Sequence[Point | ArcTo], *, least: int, ring: bool = False) -> Path:
    """The path through points and arcs; a last point at the first one closes it, and `ring` closes it in any case.

    Raises
    ------
    PlaceError
        Too few points, an arc at first, points that repeat, arcs wider than their circle, a path that turns right back
        or meets itself; with the index of the point.
    """
    if len(given) < least:
        raise PlaceError(("points",), f"{len(given)} given; needed are {least} or more, or file: a table of x and y")
    if isinstance(given[0], ArcTo):
        raise PlaceError(("points", 0), "an arc needs a point where it begins; write the first one as [x, y]")
    corners = [item.arc_to if isinstance(item, ArcTo) else item for item in given]
    bends = [item.radius if isinstance(item, ArcTo) else 0.0 for item in given[1:]]
    same = SAME * float(np.ptp(np.array(corners), axis=0).max())
    for i, ((x0, y0), (x1, y1)) in enumerate(pairwise(corners), 1):
        chord, bend = hypot(x1 - x0, y1 - y0), bends[i - 1]
        if chord <= same:
            raise PlaceError(
                ("points", i), f"({x1:zg}, {y1:zg}) m stands where the point before it stands; leave it out"
            )
        if bend and chord > 2 * abs(bend) * (1 + SAME):
            raise PlaceError(
                ("points", i),
                f"the arc from ({x0:zg}, {y0:zg}) to ({x1:zg}, {y1:zg}) spans {chord:z.6g} m, which is more than its "
                f"diameter; allowed is a radius of {chord / 2:z.6g} m or more",
            )
    ends_meet = len(corners) > 2 and hypot(*np.subtract(corners[0], corners[-1])) <= same
    if ends_meet:
        corners.pop()
    elif ring:
        bends.append(0.0)
    path = Path(tuple(corners), tuple(bends), ends_meet or ring)
    _check(path, len(given))
    return path


def closed_path(given: Sequence[Point | ArcTo], *, clockwise: bool) -> Path:
    """The outline of a polygon, in the requested turning, whichever was given.

    Raises
    ------
    PlaceError
        As `drawn`, and for an outline without area.
    """
    path = drawn(given, least=3, ring=True)
    if abs(path.area) <= SAME * path.size**2:
        raise PlaceError(("points",), f"hold an area of {abs(path.area):z.3g} m^2; a polygon needs one")
    return path if (path.area < 0) == clockwise else path.reversed()


def _check(path: Path, given: int) -> None:
    """PlaceError where a path turns right back or meets itself; `given`: number of points of the case."""
    ends = (*path.points, path.points[0]) if path.closed else path.points
    parts = [
        faces_of_chain(Chain(pair, (bend,) if bend else ()))
        for pair, bend in zip(pairwise(ends), path.bends, strict=True)
    ]
    for i, (before, after) in enumerate(zip(parts, (*parts[1:], parts[0]), strict=True), 1):
        if (path.closed or i < len(parts)) and abs(turn(before[-1], after[0])) > pi - 1e-6:
            x, y = ends[i]
            raise PlaceError(
                ("points", i % given),
                f"the wall turns right back at ({x:zg}, {y:zg}) m; move the point, or take a line with sheet: "
                "true, felt from both sides",
            )
    if meeting := _meeting(ends, parts, SAME * path.size):
        (first, second), (x, y) = meeting
        raise PlaceError(
            ("points", (second + 1) % given),
            f"the wall meets itself at ({x:z.6g}, {y:z.6g}) m: here and between points {first} and {first + 1}; "
            "move the points apart",
        )


def _meeting(
    ends: tuple[Point, ...], parts: list[list[Face]], near: float
) -> tuple[tuple[int, int], tuple[float, float]] | None:
    """Numbers of the first two parts of a path that meet, and where, m; joints of neighbours are left out.

    PlaceError where too many lie side by side.
    """
    faces = [(owner, face) for owner, part in enumerate(parts) for face in part]
    whole = Chain(tuple([face.start for _, face in faces] + [ends[-1]]), tuple(face.radius for _, face in faces))
    box = boxes(lay([((whole,), False)]), deep=False)
    order = np.argsort(box[:, 0], kind="stable")
    low, count, close = box[order, 0] - near, len(parts), 0
    for rank, i in enumerate(order):
        later = order[rank + 1 : np.searchsorted(low, box[i, 1], side="right")]
        over = (box[later, 2] - near <= box[i, 3]) & (box[later, 3] + near >= box[i, 2])
        close += int(over.sum())
        if close > MOST_CLOSE:
            raise PlaceError(
                ("points",),
                f"more than {MOST_CLOSE:,} pairs of its faces lie side by side, too many to see whether the wall meets "
                "itself; draw it with fewer points, or as several walls",
            )
        for j in later[over]:
            (one, a), (two, b) = faces[min(i, j)], faces[max(i, j)]
            is_next = two - one == 1 or (one == 0 and two == count - 1 and ends[0] == ends[-1])
            if one == two or (is_next and a.kind == b.kind == SEGMENT):
                continue
            joints = {ends[one], ends[one + 1]} & {ends[two], ends[two + 1]} if is_next else set()
            for point in common(a, b, near):
                if all(hypot(*np.subtract(point, joint)) > 1e3 * near for joint in joints):
                    return (one, two), point
    return None


def common(a: Face, b: Face, near: float) -> list[Point]:
    """Points that two faces have in common, m; faces that are closer than `near` meet."""
    if a.kind == SEGMENT and b.kind == SEGMENT:
        points = _of_lines(a, b, near)
    elif a.kind == ARC and b.kind == ARC:
        points = _of_circles(a, b, near)
    else:
        line, arc = (a, b) if a.kind == SEGMENT else (b, a)
        along = _along(line, arc.centre)
        fx, fy = line.start[0] + along * line.first[0], line.start[1] + along * line.first[1]
        off = hypot(fx - arc.centre[0], fy - arc.centre[1])
        half = sqrt(max(arc.radius**2 - off**2, 0.0))
        points = [(fx + side * line.first[0], fy + side * line.first[1]) for side in (-half, half)]
        points = points if off <= abs(arc.radius) + near else []
    return [point for point in points if _holds(a, point, near) and _holds(b, point, near)]


def _along(face: Face, point: Point) -> float:
    """Way along the line of a segment to the foot of a point, m."""
    return (point[0] - face.start[0]) * face.first[0] + (point[1] - face.start[1]) * face.first[1]


def _holds(face: Face, point: Point, near: float) -> bool:
    """Tells whether a point of the line or circle of a face lies on the face itself."""
    (ax, ay), (bx, by) = face.start, face.end
    begun = (point[0] - ax) * face.first[0] + (point[1] - ay) * face.first[1]
    left = (bx - point[0]) * face.last[0] + (by - point[1]) * face.last[1]
    return begun >= -near and left >= -near


def _of_lines(a: Face, b: Face, near: float) -> list[Point]:
    (ux, uy), (vx, vy) = a.first, b.first
    cross = ux * vy - uy * vx
    dx, dy = b.start[0] - a.start[0], b.start[1] - a.start[1]
    if abs(cross) < 1e-12:
        return [a.start, a.end, b.start, b.end] if abs(ux * dy - uy * dx) <= near else []
    way = (dx * vy - dy * vx) / cross
    return [(a.start[0] + way * ux, a.start[1] + way * uy)]


def _of_circles(a: Face, b: Face, near: float) -> list[Point]:
    (ax, ay), (bx, by), p, q = a.centre, b.centre, abs(a.radius), abs(b.radius)
    apart = hypot(bx - ax, by - ay)
    if apart <= near:
        return [a.start, a.end, b.start, b.end] if abs(p - q) <= near else []
    if apart > p + q + near or apart < abs(p - q) - near:
        return []
    ux, uy = (bx - ax) / apart, (by - ay) / apart
    along = (apart * apart + p * p - q * q) / (2 * apart)
    half = sqrt(max(p * p - along * along, 0.0))
    return [(ax + along * ux - side * uy, ay + along * uy + side * ux) for side in (half, -half)]


FLUSH = 1e-6
"""Distance of two ends over which they count as one, m; also a share of their coordinates."""


SHARPEST = -0.75 * pi
"""Turn away from the discs, rad, beyond which two walls that meet leave discs no room between them."""


def flush(one: Faces, two: Faces) -> Point | None:
    """Place where a face of one wall ends at the begin of a face of another, m: discs there feel both.

    Both lie in one line or turn away from the discs. Corners towards the discs do no harm. Closed outlines whose faces
    look down there are left out. None: there is no such place.
    """
    for before, after in ((one, two), (two, one)):
        if ENDLESS in (before.codes[0, AT_START], after.codes[0, AT_START]):
            continue
        free, begins = before.codes[:, AT_END] == FREE, after.codes[:, AT_START] == FREE
        up = (before.shape[:, TX1] > -0.5) | free
        (x0, y0), (x1, y1) = (vertices(after).min(axis=0), vertices(after).max(axis=0))
        x, y = before.shape[:, X1], before.shape[:, Y1]
        room = FLUSH * max(1.0, *map(abs, (x0, y0, x1, y1)))
        inside = (x >= x0 - room) & (x <= x1 + room) & (y >= y0 - room) & (y <= y1 + room)
        for face in np.flatnonzero(up & inside):
            place, along = before.shape[face, [X1, Y1]], before.shape[face, [TX1, TY1]]
            near = np.abs(after.shape[:, [X0, Y0]] - place).max(axis=1) <= FLUSH * max(1.0, *np.abs(place))
            for (tx, ty), begin in zip(after.shape[near][:, [TX0, TY0]], begins[near], strict=True):
                angle = atan2(along[0] * ty - along[1] * tx, along[0] * tx + along[1] * ty)
                least = SHARPEST if free[face] or begin else -SMOOTH_TURN
                if least < angle <= SMOOTH_TURN:
                    return float(place[0]), float(place[1])
    return None


def over_each_other(one: Faces, two: Faces) -> Point | None:
    """Place where straight faces of two walls lie on each other and push the same way, m: discs there feel both.

    Closed outlines whose faces look down there are left out, as in `flush`. None: there is no such place.
    """
    own, other = _straight_boxes(one), _straight_boxes(two)
    low, high = other[:, 0].min(axis=0), other[:, 1].max(axis=0)
    room = FLUSH * max(1.0, float(np.abs(own[np.isfinite(own)]).max(initial=0.0)))
    near = ((own[:, 0] <= high + room) & (own[:, 1] >= low - room)).all(axis=1)
    for face in np.flatnonzero(_looked_at(one) & near):
        x0, y0, tx, ty = one.shape[face, [X0, Y0, TX0, TY0]].tolist()
        begin, end = _span(one, (x0, y0), (tx, ty))[face]
        other = _span(two, (x0, y0), (tx, ty))
        room = FLUSH * max(1.0, abs(x0), abs(y0))
        dx, dy = two.shape[:, X0] - x0, two.shape[:, Y0] - y0
        same = _looked_at(two) & (two.shape[:, TX0] * tx + two.shape[:, TY0] * ty > 1.0 - FLUSH**2)
        same &= np.abs(tx * dy - ty * dx) <= room
        first, last = np.maximum(other[:, 0], begin), np.minimum(other[:, 1], end)
        crossing = np.flatnonzero(same & (last - first > room))
        if crossing.size:
            way = next((float(at) for at in (first[crossing[0]], last[crossing[0]]) if np.isfinite(at)), 0.0)
            return x0 + way * tx, y0 + way * ty
    return None


def pairs_that_may_touch(walls: Sequence[Faces]) -> list[tuple[int, int]]:
    """Pairs of walls, by number, whose boxes of corners meet: `flush` and `over_each_other` find nothing in others."""
    if not walls:
        return []
    boxes = np.array([(ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)) for ends in map(_straight_boxes, walls)])
    room = 2 * FLUSH * max(1.0, float(np.abs(boxes[np.isfinite(boxes)]).max(initial=0.0)))
    low, high = boxes[:, 0] - room, boxes[:, 1]
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    return [(int(one), int(two)) for one, two in np.argwhere(np.triu(meet, 1))]


def _straight_boxes(faces: Faces) -> np.ndarray:
    """Low and high corner of each face as if it were straight, shape (faces, 2, 2), m; infinite without end."""
    ends = np.sort(faces.shape[:, [X0, Y0, X1, Y1]].reshape(-1, 2, 2), axis=1)
    ends[faces.codes[:, AT_START] == ENDLESS] = [[-inf, -inf], [inf, inf]]
    return ends


def _looked_at(faces: Faces) -> np.ndarray:
    """Straight faces, without those of closed outlines that look down."""
    line = (faces.codes[:, AT_START] == FREE) | (faces.codes[:, AT_END] == FREE)
    return (faces.codes[:, KIND] == SEGMENT) & ((faces.shape[:, TX1] > -0.5) | line)


def _span(faces: Faces, start: Point, along: Point) -> np.ndarray:
    """Begin and end of faces along a line from a point, m, shape (faces, 2); of those without end infinite."""
    places = faces.shape[:, [X0, Y0, X1, Y1]] - [*start, *start]
    ways = np.sort(places.reshape(-1, 2, 2) @ np.array(along), axis=1)
    ways[faces.codes[:, AT_START] == ENDLESS] = -inf, inf
    return ways


def vertices(faces: Faces) -> np.ndarray:
    """Both ends of all faces, shape (2 faces, 2), m; none of a wall without end."""
    corners = faces.shape[faces.codes[:, AT_START] != ENDLESS]
    return np.concatenate([corners[:, [X0, Y0]], corners[:, [X1, Y1]]])


def open_ends(faces: Faces) -> list[Point]:
    """Ends of chains that are open, m."""
    starts = faces.shape[faces.codes[:, AT_START] == FREE][:, [X0, Y0]]
    ends = faces.shape[faces.codes[:, AT_END] == FREE][:, [X1, Y1]]
    return [(float(x), float(y)) for x, y in (*starts, *ends)]


LONG_BEND = radians(30.0)
"""Turn of a row of small turns, rad, up to which it counts as a corner and not as a bend."""


def tight_bend(faces: Faces) -> tuple[float, Point] | None:
    """Smallest radius (m) with which straight faces bend towards the discs in small turns, and where it begins, m.

    A bend is a row of smooth joints that turn by more than `LONG_BEND` together. None: there is none.
    """
    tightest: tuple[float, Point] | None = None
    codes, shape = faces.codes, faces.shape
    smooth = codes[:, AT_END] == SMOOTH
    begins = set(np.flatnonzero(smooth & (codes[:, AT_START] != SMOOTH)).tolist())
    runs = {int(codes[i, RUN]) for i in begins}
    begins |= {i for i in np.flatnonzero(smooth & (codes[:, LOOP] == 1)).tolist() if codes[i, RUN] not in runs}
    for begin in sorted(begins):
        face, length, turned, turns = begin, 0.0, 0.0, [_turn_behind(faces, begin)]
        while smooth[face := int(codes[face, AFTER])] and face != begin and codes[face, KIND] == SEGMENT:
            turns.append(_turn_behind(faces, face))
            length += shape[face, LENGTH]
            turned += 0.5 * (turns[-2] + turns[-1])
        if sum(turns) > LONG_BEND and turned and (tightest is None or length / turned < tightest[0]):
            tightest = length / turned, (float(shape[begin, X1]), float(shape[begin, Y1]))
    return tightest


def _turn_behind(faces: Faces, face: int) -> float:
    """Turn from a face to the next one, rad."""
    one, two = faces.shape[face], faces.shape[faces.codes[face, AFTER]]
    return atan2(one[TX1] * two[TY0] - one[TY1] * two[TX0], one[TX1] * two[TX0] + one[TY1] * two[TY0])


def thin(polygon: np.ndarray) -> bool:
    """Tells whether a closed polygon has no area: an open chain of faces, or a sheet."""
    x, y = (polygon - polygon[0]).T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    return area <= 1e-9 * float(np.ptp(x) ** 2 + np.ptp(y) ** 2)


def rectangle(x: tuple[float, float], y: tuple[float, float]) -> np.ndarray:
    """Corners of a rectangle, shape (4, 2), m."""
    return np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])
