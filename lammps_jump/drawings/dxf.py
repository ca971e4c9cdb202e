# SPDX-License-Identifier: GPL-2.0-or-later
"""DXF drawings, read by ezdxf: lines, polylines with bulges, arcs, circles; other curves in straight pieces."""

from __future__ import annotations

import importlib
import io
from math import radians
from typing import Any

from lammps_jump.errors import CaseError

from .strokes import FileStroke, GatheredStrokes, LayeredDrawing, Measure, Point, arc, bulged

CURVES = ("SPLINE", "ELLIPSE")
FLAT = 1e-9
"""Difference of a direction from the one across the drawing."""


def read_dxf(data: bytes, file: str, measure: Measure) -> LayeredDrawing:
    """A DXF drawing, in its own unit.

    Raises
    ------
    CaseError
        Bytes that are no DXF drawing.
    ImportError
        ezdxf is not installed.
    """
    ezdxf, recover, units = (importlib.import_module(name) for name in ("ezdxf", "ezdxf.recover", "ezdxf.units"))
    try:
        document, _ = recover.read(io.BytesIO(data))
    except (ezdxf.DXFError, OSError, ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise CaseError(f"{file}: is no DXF drawing ({error}); save it as DXF R2000 or later") from None
    code = int(document.header.get("$INSUNITS", 0))
    unit = float(units.conversion_factor(code, units.M)) if code else None
    told = f"$INSUNITS is {code}" + (f", {units.unit_name(code)}" if code else ": no unit")
    reader = _DxfReader(document, measure.tolerance_in(unit))
    for entity in document.modelspace():
        reader.take(entity)
    hidden = [f"layer '{name}' is off or frozen in the drawing: left out" for name in sorted(reader.hidden)]
    return LayeredDrawing(file, unit, told, reader.found.layers(), (*reader.found.notes(measure.tolerance), *hidden))


class _DxfReader:
    """Takes entities of a drawing, blocks by their parts."""

    def __init__(self, document: Any, tolerance: float) -> None:
        self.found, self.tolerance, self.hidden = GatheredStrokes(), tolerance, set[str]()
        self.off = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}

    def take(self, entity: Any, inserted: str | None = None) -> None:
        """Add an entity; one on layer 0 of a block lies on the layer where the block is inserted."""
        kind, layer = entity.dxftype(), entity.dxf.get("layer", "0")
        if inserted is not None and layer == "0":
            layer = inserted
        if layer.lower() in self.off:
            self.hidden.add(layer)
        elif kind == "INSERT":
            for part in entity.virtual_entities():
                self.take(part, layer)
        elif kind in CURVES:
            path = importlib.import_module("ezdxf.path").make_path(entity)
            self.found.stroke(layer, _distinct([(p.x, p.y) for p in path.flattening(self.tolerance)]))
            self.found.flatten(kind)
        else:
            self._plain(entity, kind, layer)

    def _plain(self, entity: Any, kind: str, layer: str) -> None:
        """Add an entity of lines and arcs; seen from behind, as CAD programs mirror parts, x runs the other way."""
        across = entity.dxf.get("extrusion", (0, 0, 1))
        if kind in ("LINE", "POINT"):  # in coordinates of the drawing, whatever they are seen from
            side = 1
        elif max(abs(across[0]), abs(across[1])) > FLAT:
            self.found.leave(f"{kind} that does not lie in the plane of the drawing")
            return
        else:
            side = 1 if across[2] > 0 else -1
        if kind == "LINE":
            start, end = entity.dxf.start, entity.dxf.end
            self._stroke(layer, FileStroke(((start.x, start.y), (end.x, end.y)), (0.0,)), 1)
        elif kind == "LWPOLYLINE":
            rows = [(x, y, bulge) for x, y, bulge in entity.get_points("xyb")]
            self._rows(layer, rows, entity.closed, side)
        elif kind == "POLYLINE" and (entity.is_2d_polyline or entity.is_3d_polyline):
            rows = [(v.dxf.location.x, v.dxf.location.y, v.dxf.get("bulge", 0.0)) for v in entity.vertices]
            self._rows(layer, rows, entity.is_closed, side)
        elif kind == "ARC":
            begin, end = entity.dxf.start_angle, entity.dxf.end_angle
            sweep = (end - begin) % 360 or 360.0
            drawn = arc(_xy(entity.dxf.center), entity.dxf.radius, radians(begin), radians(sweep))
            self._stroke(layer, drawn, side)
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
        self._stroke(layer, bulged([row[:2] for row in rows], [row[2] for row in rows[:-1]]), side)

    def _stroke(self, layer: str, stroke: FileStroke, side: int) -> None:
        if len(_distinct(stroke.points)) < 2:
            self.found.leave("piece without length")
            return
        points = [(side * x, y) for x, y in stroke.points]
        self.found.stroke(layer, points, [side * bend for bend in stroke.bends])


def _xy(point: Any) -> Point:
    return float(point[0]), float(point[1])


def _distinct(points: Any) -> list[Point]:
    """The points without those that repeat the one before."""
    found: list[Point] = []
    for point in points:
        if not found or point != found[-1]:
            found.append(point)
    return found
