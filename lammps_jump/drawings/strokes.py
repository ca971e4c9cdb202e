# SPDX-License-Identifier: GPL-2.0-or-later
"""What a drawing holds, whatever file it comes from: strokes of straight pieces and arcs, and circles, by layer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import acos, atan, atan2, ceil, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

Point = tuple[float, float]

WIDEST_ARC = 0.95 * pi
"""Widest arc that is kept whole, rad: of two arcs to a point the shorter one is meant, which a half circle is not."""
FLATTEST = 1e9
"""Radius over chord from which an arc counts as a straight line."""


class Measure(NamedTuple):
    """What the user says of lengths.

    `metres`: of a unit of the drawing, in place of what the file says; `reduced`: true length over drawn length, where
    the file says its unit; `tolerance`: how far straight pieces may lie from a curve, m.
    """

    metres: float | None = None
    reduced: float = 1.0
    tolerance: float = 1e-3

    def per_unit(self, unit: float | None) -> float | None:
        """Metres of one unit of a drawing whose file says `unit`, m; None: nobody says it."""
        if self.metres is not None:
            return self.metres
        return None if unit is None else unit * self.reduced

    def tolerance_in(self, unit: float | None) -> float:
        """The tolerance in units of the drawing."""
        return self.tolerance / (self.per_unit(unit) or 1.0)


class FileStroke(NamedTuple):
    """Points in order, and the radius of the arc to each following one (above 0: it turns left; 0: straight)."""

    points: tuple[Point, ...]
    bends: tuple[float, ...]


class Ring(NamedTuple):
    """A whole circle."""

    centre: Point
    radius: float


@dataclass(frozen=True)
class Layer:
    """What one layer of a drawing holds, in its own unit.

    Attributes
    ----------
    name : str
    strokes : tuple of FileStroke
        In the order of the file.
    rings : tuple of Ring
    """

    name: str
    strokes: tuple[FileStroke, ...]
    rings: tuple[Ring, ...]

    def points(self) -> list[Point]:
        """All points, and those of the circles that reach farthest."""
        found = [point for stroke in self.strokes for point in stroke.points]
        for (x, y), radius in self.rings:
            found += [(x - radius, y - radius), (x + radius, y + radius)]
        return found

    def mapped(self, scale: float, shift: Point) -> Layer:
        """The layer times `scale`, then moved."""

        def put(point: Point) -> Point:
            return scale * point[0] + shift[0], scale * point[1] + shift[1]

        strokes = (FileStroke(tuple(map(put, s.points)), tuple(scale * bend for bend in s.bends)) for s in self.strokes)
        return Layer(self.name, tuple(strokes), tuple(Ring(put(r.centre), scale * r.radius) for r in self.rings))


@dataclass(frozen=True)
class LayeredDrawing:
    """Layers of a file.

    Attributes
    ----------
    file : str
    unit : float or None
        Metres of one unit of the drawing; None: the file does not say.
    unit_told : str
        Where the file says its unit, or that it does not.
    layers : tuple of Layer
    notes : tuple of str
        What was left out, or made into straight pieces.
    """

    file: str
    unit: float | None
    unit_told: str
    layers: tuple[Layer, ...]
    notes: tuple[str, ...] = ()

    def extent(self) -> tuple[float, float]:
        """Width and height in units of the drawing."""
        points = [point for layer in self.layers for point in layer.points()]
        xs, ys = [x for x, _ in points], [y for _, y in points]
        return max(xs) - min(xs), max(ys) - min(ys)


class GatheredStrokes:
    """Strokes and circles as a reader finds them, by layer in the order in which layers are met."""

    def __init__(self) -> None:
        self.strokes: dict[str, list[FileStroke]] = {}
        self.rings: dict[str, list[Ring]] = {}
        self.left_out: dict[str, int] = {}
        self.flattened: dict[str, int] = {}

    def stroke(self, layer: str, points: Sequence[Point], bends: Sequence[float] = ()) -> None:
        """Add a stroke; without bends a straight one."""
        self.rings.setdefault(layer, [])
        self.strokes.setdefault(layer, []).append(FileStroke(tuple(points), tuple(bends) or (0.0,) * (len(points) - 1)))

    def ring(self, layer: str, centre: Point, radius: float) -> None:
        """Add a circle."""
        self.strokes.setdefault(layer, [])
        self.rings.setdefault(layer, []).append(Ring(centre, radius))

    def leave(self, what: str) -> None:
        """Count what is not read."""
        self.left_out[what] = self.left_out.get(what, 0) + 1

    def flatten(self, what: str) -> None:
        """Count what became straight pieces."""
        self.flattened[what] = self.flattened.get(what, 0) + 1

    def layers(self) -> tuple[Layer, ...]:
        """All layers that hold something."""
        return tuple(Layer(name, tuple(found), tuple(self.rings[name])) for name, found in self.strokes.items())

    def notes(self, tolerance: float) -> list[str]:
        """Sentences on what was left out or flattened."""
        found = [f"{what}: {count} left out" for what, count in self.left_out.items()]
        flat = self.flattened.items()
        return found + [
            f"{what}: {count} made into straight pieces, to within {tolerance:zg} m" for what, count in flat
        ]


def arc(centre: Point, radius: float, begin: float, sweep: float) -> FileStroke:
    """An arc by angles (rad, `sweep` above 0: counter-clockwise), in parts that are each clearly the shorter way."""
    parts = max(1, ceil(abs(sweep) / WIDEST_ARC))
    angles = [begin + sweep * part / parts for part in range(parts + 1)]
    points = tuple((centre[0] + radius * cos(angle), centre[1] + radius * sin(angle)) for angle in angles)
    return FileStroke(points, (radius if sweep > 0 else -radius,) * parts)


def bulged(points: Sequence[Point], bulges: Sequence[float]) -> FileStroke:
    """A polyline of DXF: a bulge is the tangent of a quarter of the angle of the arc that begins there.

    Source: DXF reference, group code 42 of LWPOLYLINE.
    """
    out: list[Point] = [points[0]]
    bends: list[float] = []
    for (start, end), bulge in zip(pairwise(points), bulges, strict=False):
        chord = hypot(end[0] - start[0], end[1] - start[1])
        if chord == 0.0:
            continue
        radius = chord * (1 + bulge * bulge) / (4 * abs(bulge)) if bulge else 0.0
        if not bulge or radius > FLATTEST * chord:
            out.append(end)
            bends.append(0.0)
            continue
        aside = chord * (1 - bulge * bulge) / (4 * bulge)  # from the middle of the chord to the centre, to the left
        ux, uy = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
        centre = 0.5 * (start[0] + end[0]) - aside * uy, 0.5 * (start[1] + end[1]) + aside * ux
        part = arc(centre, radius, atan2(start[1] - centre[1], start[0] - centre[0]), 4 * atan(bulge))
        out += [*part.points[1:-1], end]
        bends += part.bends
    return FileStroke(tuple(out), tuple(bends))


def pieces_of_cubic(corners: Sequence[Point], tolerance: float) -> int:
    """Straight pieces of a cubic Bézier curve that stay within `tolerance` of it.

    A chord of parameter length h lies within h^2/8 max|B''| of the curve; |B''| <= 6 max|P_i - 2 P_(i+1) + P_(i+2)|.
    """
    bends = [
        hypot(a[0] - 2 * b[0] + c[0], a[1] - 2 * b[1] + c[1])
        for a, b, c in zip(corners, corners[1:], corners[2:], strict=False)
    ]
    return max(1, ceil(sqrt(6 * max(bends) / (8 * tolerance))))


def pieces_of_arc(radius: float, sweep: float, tolerance: float) -> int:
    """Chords of an arc that stay within `tolerance` of it: the sagitta of each is r (1 - cos(sweep/2n))."""
    return max(1, ceil(abs(sweep) / (2 * acos(max(0.0, 1 - tolerance / radius)))))


def sampled(curve: Callable[[float], Point], count: int) -> list[Point]:
    """Points of a curve at equal steps of its parameter, from 0 to 1."""
    return [curve(number / count) for number in range(count + 1)]
