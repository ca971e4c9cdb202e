# SPDX-License-Identifier: GPL-2.0-or-later
"""DXF drawings, read by ezdxf: lines, polylines with bulges, arcs, circles; other curves in straight pieces."""

from __future__ import annotations

import importlib
import io
import logging
import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise, product, repeat
from math import cos, hypot, isfinite, pi, radians, sin, sqrt
from typing import Any, NamedTuple

from lammps_jump.errors import CaseError
from lammps_jump.quoting import echoed, shortened

from .strokes import (
    MOST_PARTS,
    FileStroke,
    GatheredStrokes,
    LayeredDrawing,
    Measure,
    Point,
    arc,
    bulged,
    pieces_of_arc,
    sampled,
)

FLAT = 1e-9
"""Difference of a direction from the one across the drawing."""
FOOT, SURVEY_FOOT = 0.3048, 1200 / 3937
"""Metres of a foot, and of the foot of the US Coast and Geodetic Survey."""
UNITS = {
    1: ("inches", FOOT / 12), 2: ("feet", FOOT), 3: ("miles", 5280 * FOOT), 4: ("millimetres", 1e-3),
    5: ("centimetres", 1e-2), 6: ("metres", 1.0), 7: ("kilometres", 1e3), 8: ("microinches", 1e-6 * FOOT / 12),
    9: ("mils", 1e-3 * FOOT / 12), 10: ("yards", 3 * FOOT), 11: ("angstroms", 1e-10), 12: ("nanometres", 1e-9),
    13: ("microns", 1e-6), 14: ("decimetres", 0.1), 15: ("decametres", 10.0), 16: ("hectometres", 100.0),
    17: ("gigametres", 1e9), 18: ("astronomical units", 149_597_870_700.0), 19: ("light years", 9.4607304725808e15),
    20: ("parsecs", 149_597_870_700.0 * 648_000 / pi), 21: ("US survey feet", SURVEY_FOOT),
    22: ("US survey inches", SURVEY_FOOT / 12), 23: ("US survey yards", 3 * SURVEY_FOOT),
    24: ("US survey miles", 5280 * SURVEY_FOOT),
}  # fmt: skip
"""Name and metres of the units of ``$INSUNITS`` (DXF reference, header section)."""
NO_NUMBER = re.compile(
    rb"(?m)^[ \t]*(?:[1-7]\d|9\d|2[123]0)[ \t]*\r?\n"
    rb"(?![ \t]*[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?[ \t]*\r?$)([^\r\n]*)"
)
"""A group that holds a number, and does not. ezdxf makes numbers of 7,5 and 4_0. A value that is taken for a group here
does no harm: a number of a group follows it."""
BINARY = b"AutoCAD Binary DXF"
"""Begins a file without lines."""
PARTS, OBJECTS = (
    re.compile(rb"(?m)^[ \t]*2[ \t]*\r?\n[ \t]*(?:%s)[ \t]*\r?$" % name) for name in (b"BLOCKS|ENTITIES", b"OBJECTS")
)
"""Begin of the sections that are drawn, and of the one after them."""
CONTROL = 16
"""Flag of a vertex that a curve is drawn after, and does not run through."""
MOST_TURNS = 40
"""Halvings of a part of a spline, which then is a point."""
MOST_BULGE = 1e6
"""Largest bulge; that of a whole circle is infinite."""
BETWEEN = (0.25, 0.5, 0.75)
"""Places at which a piece of a spline is held against its chord."""
MOST_DEGREE = 10
"""Degree of a spline."""
MOST_FITTED = 10_000
"""Points that a spline runs through, where it has no control points: root of the sum of their squares over splines."""
DEEPEST = 100
"""Blocks inside blocks."""
READ = {"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "SPLINE", "ELLIPSE"}
"""Parts that are copied with their block."""


def read_dxf(data: bytes, file: str, measure: Measure) -> LayeredDrawing:
    """A DXF drawing, in its own unit.

    Raises
    ------
    CaseError
        Numbers that are none, blocks inside themselves, or more parts than are read.
    ImportError
        ezdxf is not installed.
    """
    recover = importlib.import_module("ezdxf.recover")
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())  # what it mends is reported as a note
    _require_numbers(data, file)
    document, audit = recover.read(io.BytesIO(data))
    unit_note, unit = _unit(document.header.get("$INSUNITS", 0))
    reader = _DxfReader(document, file, measure.tolerance_in(unit), _Tools.of_ezdxf())
    reader.count_copies()
    for entity in document.modelspace():
        reader.take(entity)
    notes = [*reader.found.notes(measure.tolerance), *reader.notes()]
    mended = [*audit.errors, *audit.fixes]
    if mended:
        notes.append(f"the file has {len(mended)} faults, the first: {shortened(str(mended[0].message))}")
    return LayeredDrawing(file, unit, unit_note, reader.found.layers(), tuple(notes))


def _require_numbers(data: bytes, file: str) -> None:
    """CaseError where a group of a part of the drawing holds no number, with its line, or where there are no lines."""
    begin, end = PARTS.search(data), OBJECTS.search(data)
    if data.startswith(BINARY):
        raise CaseError(f"{file}: is a binary DXF file; save it as text, which CAD programs call ASCII")
    if begin is None:
        return
    if wrong := NO_NUMBER.search(data, begin.end(), end.start() if end and end.start() > begin.end() else len(data)):
        line = data.count(b"\n", 0, wrong.start(1)) + 1
        raise CaseError(
            f"{file}:{line}: {echoed(wrong[1].decode(errors='replace').strip())} is no number; draw it anew"
        )


def _unit(code: object) -> tuple[str, float | None]:
    """Unit by `$INSUNITS`, and metres of a unit; None where it says none."""
    name, metres = UNITS.get(code, (None, None)) if isinstance(code, int) else (None, None)
    if metres is None:
        return f"$INSUNITS is {echoed(code)}: no unit", None
    return f"$INSUNITS is {code}, {name}", metres


class _Place(NamedTuple):
    """A point of a curve."""

    x: float
    y: float
    z: float


class _Tools(NamedTuple):
    """Parts of ezdxf in use: maps, ellipses, and the error of a part that a map makes another kind of."""

    matrix: Any
    ellipse: Any
    oblique: type[Exception]

    @classmethod
    def of_ezdxf(cls) -> _Tools:
        """Tools of the package that is installed."""
        math, parts = map(importlib.import_module, ("ezdxf.math", "ezdxf.entities"))
        oblique = importlib.import_module("ezdxf.math.transformtools").NonUniformScalingError
        return cls(math.Matrix44, parts.Ellipse, oblique)


class _DxfReader:
    """Takes entities of a drawing, blocks by their parts."""

    def __init__(self, document: Any, file: str, tolerance: float, tools: _Tools) -> None:
        self.document, self.file, self.tolerance, self.tools = document, file, tolerance, tools
        self.found, self.hidden, self.high, self.fitted = GatheredStrokes(file), set[str](), 0, 0
        layers = [(layer.dxf.name.lower(), layer) for layer in document.layers]
        self.frozen = {name for name, layer in layers if layer.is_frozen()}
        self.off = {name for name, layer in layers if layer.is_off()} | self.frozen

    def count_copies(self) -> None:
        """CaseError where blocks hold themselves, or what they hold is more than is read, before it is copied."""
        counts: dict[str, int | None] = {}

        def inside(entities: Any, depth: int) -> int:
            total = 0
            for entity in entities:
                if _is_insert(entity):
                    columns, rows = _grid(entity)
                    total += columns * rows * of_block(entity.dxf.name.lower(), depth)
                else:
                    total += 1
                if total > MOST_PARTS:
                    self.found.part(MOST_PARTS + 1)
            return total

        def of_block(name: str, depth: int) -> int:
            if counts.get(name, 0) is None or depth > DEEPEST:
                raise CaseError(f"{self.file}: block '{shortened(name)}' holds itself; draw it anew")
            if name not in counts:
                counts[name] = None
                block = self.document.blocks.get(name)
                counts[name] = 1 + (0 if block is None else inside(block, depth + 1))
            return counts[name] or 0

        inside(self.document.modelspace(), 0)

    def notes(self) -> Iterator[str]:
        """Further notes for the user."""
        yield from (
            f"layer '{shortened(name)}' is off or frozen in the drawing: left out" for name in sorted(self.hidden)
        )
        if self.high:
            yield f"heights (z): parts that have them are seen from above, {self.high} in all"
        outside = sum(
            entity.dxftype() != "VIEWPORT" for layout in self.document.layouts_and_blocks() for entity in layout
            if layout.is_any_paperspace
        )  # fmt: skip
        if outside:
            yield f"paper space: {outside} parts left out"

    def take(self, entity: Any, inserted: str | None = None, put: tuple[Any, ...] = ()) -> None:
        """Add an entity; one on layer 0 of a block lies on the layer where the block is inserted.

        `put` are the maps from the block to the drawing, the first one first. What is not read is not copied: a block
        of a large hatch may occur in a drawing many times.
        """
        kind, layer = entity.dxftype(), entity.dxf.get("layer", "0")
        if inserted is not None and layer == "0":
            layer = inserted
        if entity.dxf.get("invisible", 0):
            self.found.leave(f"invisible {kind}")
        elif layer.lower() in (self.frozen if kind == "INSERT" else self.off):  # of a block each part has its layer
            self.hidden.add(layer)
        elif kind == "INSERT":
            self._insert(entity, layer, put)
        elif put and kind in READ:
            for part in self._copies(entity, kind, put):
                self.take(part, layer)
        elif kind in ("SPLINE", "ELLIPSE"):
            points = (self._spline if kind == "SPLINE" else self._ellipse)(entity)
            if points:
                self._stroke(layer, FileStroke(tuple(points), (0.0,) * (len(points) - 1)), 1)
                self.found.flatten(kind)
        else:
            self._plain(entity, kind, layer)

    def _insert(self, entity: Any, layer: str, put: tuple[Any, ...]) -> None:
        """Add the parts of a block, of an array of them each copy."""
        if entity.dxf.name not in self.document.blocks:
            self.found.leave("INSERT of a block that is not there")
            return
        block, ocs, (columns, rows) = entity.block(), entity.ocs(), _grid(entity)
        turn = self.tools.matrix.z_rotate(radians(entity.dxf.rotation))
        for up, across in product(range(rows), range(columns)):
            self.found.part()
            way = ocs.to_wcs(turn.transform((across * entity.dxf.column_spacing, up * entity.dxf.row_spacing, 0.0)))
            onto = self._joined(entity.matrix44() * self.tools.matrix.translate(*way), put)
            for part in block:
                if part.dxftype() != "ATTDEF":  # a place for words, which each copy may fill
                    self.take(part, layer, onto)

    def _joined(self, onto: Any, put: tuple[Any, ...]) -> tuple[Any, ...]:
        """Maps one after the other, as one where it keeps right angles: ezdxf takes no other for what it is."""
        both = onto * put[0] if put else onto
        return (both, *put[1:]) if both.is_orthogonal else (onto, *put)

    def _copies(self, entity: Any, kind: str, put: tuple[Any, ...]) -> list[Any]:
        """Copies of a part of a block where it is put: arcs that are stretched become ellipses."""
        self.found.look(_size(entity, kind) * len(put))
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            self.found.leave(kind)
            return []
        copies = [entity.copy()]
        for matrix in put:
            copies = [piece for copy in copies for piece in self._mapped(copy, matrix)]
        return copies

    def _mapped(self, copy: Any, matrix: Any) -> list[Any]:
        """A part that is no other's where a map puts it."""
        kind = copy.dxftype()
        try:
            return [copy.transform(matrix)]
        except self.tools.oblique:
            if kind not in ("ARC", "CIRCLE"):
                return [piece for part in copy.virtual_entities() for piece in self._mapped(part, matrix)]
            if copy.dxf.radius > 0.0:
                return [self.tools.ellipse.from_arc(copy).transform(matrix)]
        except NotImplementedError:
            pass
        self.found.leave(f"{kind} of a block")
        return []

    def _plain(self, entity: Any, kind: str, layer: str) -> None:
        """Add an entity of lines and arcs; seen from behind, as CAD programs mirror parts, x runs the other way."""
        if kind == "LINE":  # in coordinates of the drawing, whatever it is seen from
            side = 1
        elif not (side := self._side(entity, kind)):
            return
        if kind == "LINE":
            start, end = entity.dxf.start, entity.dxf.end
            self._see_heights(start.z, end.z)
            self._stroke(layer, FileStroke(((start.x, start.y), (end.x, end.y)), (0.0,)), 1)
        elif kind == "LWPOLYLINE":
            rows = [(x, y, bulge) for x, y, bulge in entity.get_points("xyb")]
            self._rows(layer, rows, entity.closed, side)
        elif kind == "POLYLINE" and (entity.is_2d_polyline or entity.is_3d_polyline):
            kept = [v for v in entity.vertices if not v.dxf.get("flags", 0) & CONTROL]
            rows = [(v.dxf.location.x, v.dxf.location.y, v.dxf.get("bulge", 0.0)) for v in kept]
            if entity.is_3d_polyline:
                self._see_heights(*(v.dxf.location.z for v in kept))
            self._rows(layer, rows, entity.is_closed, side)
        elif kind == "ARC":
            begin, end, radius = entity.dxf.start_angle, entity.dxf.end_angle, entity.dxf.radius
            if not (isfinite(begin) and isfinite(end) and radius > 0.0):
                raise CaseError(
                    f"{self.file}: layer '{shortened(layer)}': an arc has no angles or radius; draw it anew"
                )
            sweep = (end - begin) % 360 or 360.0
            self._stroke(layer, arc(_xy(entity.dxf.center), radius, radians(begin), radians(sweep)), side)
        elif kind == "CIRCLE":
            x, y = _xy(entity.dxf.center)
            self.found.ring(layer, (side * x, y), float(entity.dxf.radius))
        else:
            self.found.leave(kind)

    def _rows(self, layer: str, rows: list[tuple[float, float, float]], closed: bool, side: int) -> None:
        if closed and rows:
            rows = [*rows, (*rows[0][:2], 0.0)]
        if len(rows) < 2:
            self.found.leave("polyline of one point")
            return
        if wrong := [bulge for _, _, bulge in rows if not abs(bulge) <= MOST_BULGE]:
            raise CaseError(f"{self.file}: layer '{shortened(layer)}': a bulge of {wrong[0]:g} is none; draw it anew")
        self._stroke(layer, bulged([row[:2] for row in rows], [row[2] for row in rows[:-1]]), side)

    def _stroke(self, layer: str, stroke: FileStroke, side: int) -> None:
        if len(set(stroke.points)) < 2:
            self.found.leave("piece without length")
            return
        points = [(side * x, y) for x, y in stroke.points]
        self.found.stroke(layer, points, [side * bend for bend in stroke.bends])

    def _see_heights(self, *heights: float) -> None:
        """Count parts whose points are not all as high."""
        self.high += len(set(heights)) > 1

    def _side(self, entity: Any, kind: str) -> int:
        """1 for an entity that is seen from above, -1 from behind; 0 for one that is upright and is left out."""
        across = entity.dxf.get("extrusion", (0, 0, 1))
        if max(abs(across[0]), abs(across[1])) > FLAT:
            self.found.leave(f"{kind} that does not lie in the plane of the drawing")
            return 0
        return 1 if across[2] > 0 else -1

    def _ellipse(self, entity: Any) -> list[Point]:
        """Points of an ellipse; none of one that is upright."""
        if not self._side(entity, "ELLIPSE"):
            return []
        major, minor, centre = entity.dxf.major_axis, entity.minor_axis, entity.dxf.center
        begin, end = entity.dxf.start_param, entity.dxf.end_param
        sweep = (end - begin) % (2 * pi) or 2 * pi
        longest = max(hypot(major.x, major.y), hypot(minor.x, minor.y))
        if not (isfinite(longest) and isfinite(begin) and isfinite(sweep)):
            raise CaseError(f"{self.file}: an ellipse has no axes or angles; draw it anew")
        count = self.found.pieces(pieces_of_arc(longest, sweep, self.tolerance))

        def at(way: float) -> Point:
            c, s = cos(begin + sweep * way), sin(begin + sweep * way)
            return centre.x + c * major.x + s * minor.x, centre.y + c * major.y + s * minor.y

        points = sampled(at, count)
        return [*points[:-1], points[0]] if sweep == 2 * pi else points

    def _spline(self, entity: Any) -> list[Point]:
        """Points of a spline: each part between its knots is halved until its chords lie within the tolerance."""
        self._require_short(entity)
        curve = entity.construction_tool()
        self.found.room(len(curve.control_points))
        points: list[_Place] = []
        for at, part in self._parts_of(curve):
            points += ([] if points else [at(part[0])]) + self._halved(at, part)
            self.found.room(len(points))
        if not points:
            self.found.leave("SPLINE without length")
            return []
        self._see_heights(*(point.z for point in points))
        corners = [_xy(point) for point in points]
        (x0, y0), (x1, y1) = corners[0], corners[-1]
        return [*corners[:-1], corners[0]] if hypot(x0 - x1, y0 - y1) <= self.tolerance else corners

    def _require_short(self, entity: Any) -> None:
        """CaseError for a spline whose points cost more than they number."""
        fitted = 0 if entity.control_point_count() else entity.fit_point_count()
        self.fitted += fitted * fitted
        if not 1 <= entity.dxf.degree <= MOST_DEGREE:
            raise CaseError(
                f"{self.file}: a spline of degree {entity.dxf.degree}; at most {MOST_DEGREE} is read: draw it anew"
            )
        if self.fitted > MOST_FITTED**2:
            raise CaseError(
                f"{self.file}: a spline without control points runs through {fitted:,} points, and at most "
                f"{MOST_FITTED:,} are read: draw it as a polyline"
            )

    def _parts_of(self, curve: Any) -> Iterator[tuple[Callable[[float], _Place], tuple[float, float]]]:
        """A spline between each two of its knots: the curve of the control points that count there.

        A point of the whole curve takes a time that grows with the control points.
        """
        order, knots, weights = curve.order, curve.knots(), curve.weights()
        corners = [
            (weight * x, weight * y, weight * z, weight)
            for (x, y, z), weight in zip(curve.control_points, weights or repeat(1.0), strict=False)
        ]
        for last in range(order - 1, len(corners)):
            first, part = last + 1 - order, (knots[last], knots[last + 1])
            if part[0] < part[1]:
                yield partial(_de_boor, corners[first : last + 1], knots[first + 1 : last + order]), part

    def _halved(self, at: Callable[[float], _Place], part: tuple[float, float]) -> list[_Place]:
        """Points after the first of a part of a curve."""
        halves: list[_Place] = []
        parts = [(*part, 0)]
        while parts:
            begin, end, turns = parts.pop()
            start, stop = at(begin), at(end)
            off = max(_off(at(begin + way * (end - begin)), start, stop) for way in BETWEEN)
            self.found.room(len(halves))
            self.found.pieces(sqrt(off / self.tolerance))  # a chord half as long is off by a quarter
            if (turns and off <= self.tolerance) or turns >= MOST_TURNS:
                halves.append(stop)
            else:
                middle = 0.5 * (begin + end)
                parts += [(middle, end, turns + 1), (begin, middle, turns + 1)]
        return halves


def _de_boor(corners: Sequence[tuple[float, ...]], knots: Sequence[float], at: float) -> _Place:
    """Point of a rational spline of degree p between two knots.

    Parameters
    ----------
    corners : sequence of tuple of float, shape (p + 1, 4)
        The control points that count there, times their weights, and the weights.
    knots : sequence of float, shape (2 p,)
        Those around, p on each side.
    at : float
        Between the two in the middle.

    Source: C. de Boor, On calculating with B-splines, J. Approx. Theory 6 (1972), of homogeneous coordinates.
    """
    degree = len(corners) - 1
    for turn in range(degree):
        shares = [(at - knots[i]) / (knots[i + degree - turn] - knots[i]) for i in range(turn, degree)]
        corners = [
            tuple(p + share * (q - p) for p, q in zip(one, two, strict=True))
            for share, (one, two) in zip(shares, pairwise(corners), strict=True)
        ]
    x, y, z, weight = corners[0]
    return _Place(x / weight, y / weight, z / weight)


def _off(point: _Place, start: _Place, end: _Place) -> float:
    """Distance of a point from the line through two others."""
    dx, dy = end.x - start.x, end.y - start.y
    length = hypot(dx, dy)
    aside = dx * (point.y - start.y) - dy * (point.x - start.x)
    return abs(aside) / length if length else hypot(point.x - start.x, point.y - start.y)


def _grid(entity: Any) -> tuple[int, int]:
    """Columns and rows of an insert; those that lie on each other count once."""
    columns, rows = entity.dxf.column_count, entity.dxf.row_count
    return (max(1, columns) if entity.dxf.column_spacing else 1, max(1, rows) if entity.dxf.row_spacing else 1)


def _size(entity: Any, kind: str) -> int:
    """Points of an entity."""
    if kind == "LWPOLYLINE":
        return 1 + len(entity)
    if kind == "POLYLINE":
        return 1 + len(entity.vertices)
    return 1 + entity.control_point_count() + entity.fit_point_count() if kind == "SPLINE" else 1


def _is_insert(entity: Any) -> bool:
    return bool(entity.dxftype() == "INSERT")


def _xy(point: Any) -> Point:
    return float(point[0]), float(point[1])
