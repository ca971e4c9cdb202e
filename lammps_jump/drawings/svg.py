# SPDX-License-Identifier: GPL-2.0-or-later
"""SVG drawings, read by svgelements: straight lines, arcs of circles, circles; other curves in straight pieces."""

from __future__ import annotations

import importlib
import io
import re
from math import atan2
from typing import Any

from lammps_jump.errors import CaseError
from lammps_jump.units import to_si

from .strokes import GatheredStrokes, LayeredDrawing, Measure, Point, arc, pieces_of_arc, pieces_of_cubic, sampled

UNITS = {"mm": "mm", "cm": "cm", "in": "inch", "pt": "point", "pc": "pica"}
"""Units of length of a page, as pint calls them."""
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
ROUND = 1e-6
"""Difference of the two radii of an ellipse over the larger, up to which it is a circle."""
SVG_TAG = re.compile(rb"<(?:\w+:)?svg\b[^>]*>", re.S)


def read_svg(data: bytes, file: str, measure: Measure) -> LayeredDrawing:
    """An SVG drawing in pixels, with y upwards from the bottom of its page.

    Raises
    ------
    CaseError
        Bytes that are no SVG drawing.
    ImportError
        svgelements is not installed.
    """
    svg = importlib.import_module("svgelements")
    head = SVG_TAG.search(data)
    try:
        if head is None:
            raise ValueError("it has no <svg>")
        page = svg.SVG.parse(io.BytesIO(data), ppi=96, reify=True)
        height = float(page.height or 0.0)
    except (ValueError, SyntaxError, LookupError, TypeError, AttributeError, ArithmeticError) as error:
        raise CaseError(f"{file}: is no SVG drawing that can be read ({error}); save it as plain SVG") from None
    width = re.search(rb"""\bwidth\s*=\s*["']\s*([-+.\deE]+?)\s*([a-zA-Z%]*)\s*["']""", head[0])
    name = width[2].decode() if width else ""
    unit = (
        float(to_si(f"{width[1].decode()} {UNITS[name]}", "m")) / float(page.width) if width and name in UNITS else None
    )
    told = f"its width is in {name}" if unit else f"its width is in {name or 'pixels'}, which is no length"
    reader = _SvgReader(svg, height, measure.tolerance_in(unit))
    reader.walk(page, "")
    return LayeredDrawing(file, unit, told, reader.found.layers(), tuple(reader.found.notes(measure.tolerance)))


class _SvgReader:
    """Takes shapes of a page; the outermost group that has a name is their layer."""

    def __init__(self, svg: Any, height: float, tolerance: float) -> None:
        self.svg, self.height, self.tolerance, self.found = svg, height, tolerance, GatheredStrokes()

    def walk(self, group: Any, layer: str) -> None:
        """Take what a group holds."""
        for part in group:
            values = getattr(part, "values", {})
            name = layer or str(values.get(LABEL) or getattr(part, "id", None) or "")
            if isinstance(part, self.svg.Group):
                self.walk(part, name)
            elif isinstance(part, self.svg.Shape):
                self._shape(part, name or "drawing")
            else:
                self.found.leave(type(part).__name__.lower())

    def _up(self, point: Any) -> Point:
        return float(point.x), self.height - float(point.y)

    def _shape(self, shape: Any, layer: str) -> None:
        """Add a shape: a circle whole, others by the parts of their path."""
        svg = self.svg
        if isinstance(shape, svg.Circle | svg.Ellipse) and (radius := _radius(shape.implicit_rx, shape.implicit_ry)):
            self.found.ring(layer, self._up(shape.implicit_center), radius)
            return
        points: list[Point] = []
        bends: list[float] = []
        for part in svg.Path(shape):
            if isinstance(part, svg.Move):
                self._end(layer, points, bends)
                points, bends = ([self._up(part.end)] if part.end is not None else []), []
                continue
            ends, radii = self._part(part)
            for end, radius in zip(ends, radii, strict=True):
                if points and end != points[-1]:
                    points.append(end)
                    bends.append(radius)
        self._end(layer, points, bends)

    def _end(self, layer: str, points: list[Point], bends: list[float]) -> None:
        if len(points) > 1:
            self.found.stroke(layer, points, bends)

    def _part(self, part: Any) -> tuple[list[Point], list[float]]:
        """Points after the first one of a part of a path, and the radius of the way to each."""
        svg = self.svg
        if isinstance(part, svg.Close | svg.Line):
            return ([self._up(part.end)], [0.0]) if part.end is not None else ([], [])
        if isinstance(part, svg.Arc):
            sweep = -float(part.sweep)  # y of a page runs downwards
            radius = _radius(part.rx, part.ry)
            if radius:
                (x, y), (cx, cy) = self._up(part.start), self._up(part.center)
                whole = arc((cx, cy), radius, atan2(y - cy, x - cx), sweep)
                return [*whole.points[1:-1], self._up(part.end)], list(whole.bends)
            self.found.flatten("arc of an ellipse")
            count = pieces_of_arc(max(part.rx, part.ry), sweep, self.tolerance)
        else:
            corners = [(p.x, p.y) for p in (part.start, *_controls(part), part.end)]
            self.found.flatten("Bézier curve")
            count = pieces_of_cubic(corners, self.tolerance)
        points = sampled(lambda way: self._up(part.point(way)), count)[1:]
        return points, [0.0] * len(points)


def _controls(part: Any) -> list[Any]:
    """Control points of a Bézier curve."""
    return [part.control] if hasattr(part, "control") else [part.control1, part.control2]


def _radius(rx: float, ry: float) -> float:
    """The radius of a circle; 0 of an ellipse."""
    rx, ry = abs(float(rx)), abs(float(ry))
    return rx if rx and abs(rx - ry) <= ROUND * max(rx, ry) else 0.0
