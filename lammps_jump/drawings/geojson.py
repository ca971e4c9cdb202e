# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines and outlines of GeoJSON (RFC 7946), drawn in a vertical section: x along it, y upwards."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from math import hypot
from typing import Any

from lammps_jump.errors import CaseError
from lammps_jump.foreign import foreign
from lammps_jump.quoting import echoed, shortened

from .strokes import FARTHEST_DRAWN, GatheredStrokes, LayeredDrawing, Point

PARTS = {"LineString": 0, "MultiLineString": 1, "Polygon": 1, "MultiPolygon": 2}
"""Lists that stand between a geometry and its lines."""
NAMES = ("layer", "name", "id")
"""Properties of a feature that name its layer, the first that is there."""


def read_geojson(data: bytes, file: str, *, along: bool) -> LayeredDrawing:
    """Lines of GeoJSON; `along`: drawn in plan with heights, and x becomes the distance along each.

    Raises
    ------
    CaseError
        No GeoJSON, coordinates that are no numbers, and heights that could be meant in two ways.
    """
    with foreign(CaseError, f"{file}: is no GeoJSON"):
        tree = json.loads(data.decode("utf-8-sig"), parse_constant=_no_number)
    found = GatheredStrokes(file)
    for layer, geometry in _geometries(tree, file):
        kind = geometry.get("type")
        if not isinstance(kind, str) or kind not in PARTS:
            found.leave(kind if isinstance(kind, str) else f"geometry of type {echoed(kind)}")
            continue
        lines: list[Any] = [geometry.get("coordinates")]
        for _ in range(PARTS[kind]):
            lines = [inner for outer in lines for inner in _list(outer, layer, file)]
        for line in lines:
            points = _points(line, layer, file, along=along)
            if "Polygon" in kind and points[0] != points[-1]:
                raise CaseError(
                    f"{file}: layer '{layer}': the ring of a {kind} does not end where it begins; let its last place "
                    "be its first, or draw a LineString"
                )
            if len(points) > 1:
                found.stroke(layer, points)
            else:
                found.leave(f"{kind} without length")
    told = "GeoJSON has no unit of a section: RFC 7946 means degrees of longitude and latitude"
    return LayeredDrawing(file, None, told, found.layers(), tuple(found.notes(0.0)))


def _no_number(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _list(value: Any, layer: str, file: str) -> list[Any]:
    """A list; CaseError for something else."""
    if not isinstance(value, list):
        raise CaseError(f"{file}: layer '{layer}': {echoed(value)} stands where a list of coordinates is expected")
    return value


def _geometries(tree: Any, file: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names of layers, and geometries."""
    if not isinstance(tree, dict):
        raise CaseError(f"{file}: is no GeoJSON: it holds a {type(tree).__name__}, expected is a FeatureCollection")
    kind = tree.get("type")
    if kind == "FeatureCollection":
        for feature in _list(tree.get("features") or [], "features", file):
            yield from _geometries(feature, file)
    elif kind == "Feature":
        properties = tree.get("properties") or {}
        if not isinstance(properties, dict):
            raise CaseError(
                f"{file}: the properties of a feature are {echoed(properties)}; expected are keys and values"
            )
        named = [name for name in (*map(properties.get, NAMES), tree.get("id")) if name not in (None, "")]
        name = named[0] if named else "drawing"
        if isinstance(name, dict | list):
            raise CaseError(f"{file}: a feature has the name {echoed(name)}; expected is a text or a number")
        words = name if isinstance(name, str) else json.dumps(name)
        for _, geometry in _geometries(tree.get("geometry") or {"type": "feature without geometry"}, file):
            yield shortened(words), geometry
    elif kind == "GeometryCollection":
        for geometry in _list(tree.get("geometries") or [], "geometries", file):
            yield from _geometries(geometry, file)
    else:
        yield "drawing", tree


def _points(line: Any, layer: str, file: str, *, along: bool) -> list[Point]:
    """Points of a line, those that repeat the one before left out."""
    rows = [tuple(_list(place, layer, file)) for place in _list(line, layer, file)]
    wrong = next((value for row in rows for value in row if type(value) not in (int, float)), None)
    if wrong is not None or any(None in row for row in rows):
        raise CaseError(f"{file}: layer '{layer}': {echoed(wrong)} among coordinates; numbers are expected")
    if any(abs(value) > FARTHEST_DRAWN for row in rows for value in row):
        raise CaseError(f"{file}: layer '{layer}': a coordinate is beyond {FARTHEST_DRAWN:g}; no drawing is so large")
    rows = [tuple(map(float, row)) for row in rows]
    size = {len(row) for row in rows}
    if len(rows) < 2 or not size <= {2, 3} or len(size) != 1:
        raise CaseError(f"{file}: layer '{layer}': a line needs two places or more, all [x, y] or all [x, y, height]")
    if size == {3} and not along:
        raise CaseError(
            f"{file}: layer '{layer}' has heights: is it drawn in plan, so that x is the way along it and y the "
            "height? Then give --along. Or is [x, y] the section itself? Then take the third numbers out"
        )
    if size == {2} and along:
        raise CaseError(f"{file}: --along: layer '{layer}' has no heights; it needs places [x, y, height]")
    if along:
        way = [0.0]
        for (x0, y0, _), (x1, y1, _) in pairwise(rows):
            way.append(way[-1] + hypot(x1 - x0, y1 - y0))
        rows = [(x, row[2]) for x, row in zip(way, rows, strict=True)]
    return [row for number, row in enumerate(rows) if not number or row != rows[number - 1]]
