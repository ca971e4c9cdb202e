# SPDX-License-Identifier: GPL-2.0-or-later
"""Strokes of a drawing, whatever file it comes from: straight pieces and arcs, and circles, by layer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import asin, atan, atan2, ceil, cos, hypot, inf, isfinite, pi, sin, sqrt
from typing import NamedTuple

from lammps_jump.errors import CaseError
from lammps_jump.quoting import shortened

Point = tuple[float, float]

WIDEST_ARC = 0.95 * pi
"""Widest arc that is kept whole, rad: of two arcs to a point the shorter one is meant, which a half circle is not."""
FLATTEST = 1e9
"""Radius over chord from which an arc counts as a straight line."""
MOST_POINTS = 300_000
"""Points of a drawing, those of curves in straight pieces among them."""
MOST_PARTS = 300_000
"""Lines, circles and other parts of a drawing; of blocks and of what SVG uses again each copy."""
MOST_LOOKED = 3_000_000
"""Points of copies that are made, those among them of which nothing is taken."""
FARTHEST_DRAWN = 1e30
"""Largest coordinate in a unit of the drawing."""
MOST_KINDS = 30
"""Kinds of parts that notes name one by one."""


class Measure(NamedTuple):
    """Lengths as the user says them.

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
    """Content of one layer of a drawing, in its own unit.

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
        points_of_layer = [point for stroke in self.strokes for point in stroke.points]
        for (x, y), radius in self.rings:
            points_of_layer += [(x - radius, y - radius), (x + radius, y + radius)]
        return points_of_layer

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
    """Strokes and circles as a reader finds them, by layer in the order in which layers are met.

    Each place is looked at, and points and parts are counted, so that a small file cannot keep the program busy.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self.strokes: dict[str, list[FileStroke]] = {}
        self.rings: dict[str, list[Ring]] = {}
        self.left_out: dict[str, int] = {}
        self.flattened: dict[str, int] = {}
        self.points = self.parts = self.looked = 0

    def stroke(self, layer: str, points: Sequence[Point], bends: Sequence[float] = ()) -> None:
        """Add a stroke; without bends a straight one.

        Raises
        ------
        CaseError
            A place that is none, too many points or parts.
        """
        name = self._layer(layer)
        self.part()
        self.room(len(points))
        bends = tuple(bends) or (0.0,) * (len(points) - 1)
        for x, y in points:
            if not (abs(x) <= FARTHEST_DRAWN and abs(y) <= FARTHEST_DRAWN):
                raise CaseError(f"{self.file}: layer '{name}': ({x:g}, {y:g}) is no place in a drawing; draw it anew")
        if not all(map(isfinite, bends)):
            raise CaseError(f"{self.file}: layer '{name}': an arc has no radius; draw it anew")
        self.strokes[name].append(FileStroke(tuple(points), bends))
        self.points += len(points)

    def ring(self, layer: str, centre: Point, radius: float) -> None:
        """Add a circle; CaseError as `stroke`."""
        name = self._layer(layer)
        self.part()
        if not (radius > 0.0 and all(abs(value) <= FARTHEST_DRAWN for value in (*centre, radius))):
            where = f"({centre[0]:g}, {centre[1]:g})"
            raise CaseError(
                f"{self.file}: layer '{name}': a circle of radius {radius:g} about {where} is none; draw it anew"
            )
        self.rings[name].append(Ring(centre, radius))

    def part(self, count: int = 1) -> None:
        """Count parts that are looked at; CaseError where there are too many."""
        self.parts += count
        if self.parts > MOST_PARTS:
            raise CaseError(
                f"{self.file}: more than {MOST_PARTS:,} lines, circles and other parts, copies counted; draw what are "
                "walls alone, in polylines"
            )

    def look(self, count: int) -> None:
        """Count points of copies; CaseError where there are too many."""
        self.looked += count
        if self.looked > MOST_LOOKED:
            raise CaseError(
                f"{self.file}: what is used again has more than {MOST_LOOKED:,} points, copies counted; draw what are "
                "walls alone"
            )

    def room(self, count: int) -> None:
        """CaseError where so many further points are too many."""
        if self.points + count > MOST_POINTS:
            raise CaseError(
                f"{self.file}: needs {self.points + count:,} points or more, straight pieces of curves counted; at "
                f"most {MOST_POINTS:,} are read: is its unit right (--scale)? Else draw what are walls alone"
            )

    def pieces(self, count: float) -> int:
        """So many straight pieces; CaseError where they are too many, or no number."""
        self.room(int(min(count, 1e18)) if count < inf else MOST_POINTS + 1)
        return max(1, ceil(count))

    def leave(self, what: str) -> None:
        """Count what is not read."""
        self._count(self.left_out, what)

    def flatten(self, what: str) -> None:
        """Count what became straight pieces."""
        self._count(self.flattened, what)

    def _count(self, among: dict[str, int], what: str) -> None:
        self.part()
        name = shortened(what) if len(among) < MOST_KINDS or what in among else "other parts"
        among[name] = among.get(name, 0) + 1

    def _layer(self, layer: str) -> str:
        """The name of a layer on one line, known from now on."""
        name = shortened(layer).strip() or "drawing"
        self.strokes.setdefault(name, [])
        self.rings.setdefault(name, [])
        return name

    def layers(self) -> tuple[Layer, ...]:
        """All layers that hold something."""
        return tuple(
            Layer(name, tuple(file_strokes), tuple(self.rings[name])) for name, file_strokes in self.strokes.items()
        )

    def notes(self, tolerance: float) -> list[str]:
        """Sentences on what was left out or flattened."""
        sentences = [f"{what}: {count} left out" for what, count in self.left_out.items()]
        flat = self.flattened.items()
        return sentences + [
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


def pieces_of_cubic(corners: Sequence[Point], tolerance: float) -> float:
    """Straight pieces of a cubic Bézier curve that stay within `tolerance` of it; those of other degrees alike.

    A chord of parameter length h lies within h^2/8 max|B''| of the curve; |B''| <= p (p - 1) max|P_i - 2 P_(i+1) +
    P_(i+2)| of a curve of degree p.
    """
    bends = [
        hypot(a[0] - 2 * b[0] + c[0], a[1] - 2 * b[1] + c[1])
        for a, b, c in zip(corners, corners[1:], corners[2:], strict=False)
    ]
    degree = len(corners) - 1
    return max(1.0, sqrt(degree * (degree - 1) * max(bends, default=0.0) / (8 * tolerance)))


def pieces_of_arc(radius: float, sweep: float, tolerance: float) -> float:
    """Chords of an arc that stay within `tolerance` of it: the sagitta of each is r (1 - cos(sweep/2n)).

    Of an arc of an ellipse with its larger radius, of which a circle is stretched to none of its lengths but shorter.
    """
    share = min(1.0, tolerance / radius) if radius > 0.0 else 1.0
    half = 2 * asin(sqrt(0.5 * share))  # acos(1 - share), which would round to 0
    return max(1.0, abs(sweep) / (2 * half))


def sampled(curve: Callable[[float], Point], count: int) -> list[Point]:
    """Points of a curve at equal steps of its parameter, from 0 to 1."""
    return [curve(number / count) for number in range(count + 1)]
