# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines and outlines of GeoJSON (RFC 7946), drawn in a vertical section: x along it, y upwards."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from math import hypot
from typing import Any

from lammps_jump.errors import CaseError

from .strokes import GatheredStrokes, LayeredDrawing, Point

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
    try:
        tree = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise CaseError(f"{file}: is no GeoJSON ({error})") from None
    found = GatheredStrokes()
    for layer, geometry in _geometries(tree, file):
        depth = PARTS.get(geometry.get("type", ""))
        if depth is None:
            found.leave(str(geometry.get("type")))
            continue
        lines: Any = [geometry.get("coordinates")]
        for _ in range(depth):
            lines = [inner for outer in lines if isinstance(outer, list) for inner in outer]
        for line in lines:
            found.stroke(layer, _points(line, layer, file, along=along))
    told = "GeoJSON has no unit of a section: RFC 7946 means degrees of longitude and latitude"
    return LayeredDrawing(file, None, told, found.layers(), tuple(found.notes(0.0)))


def _geometries(tree: Any, file: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names of layers, and geometries."""
    if not isinstance(tree, dict):
        raise CaseError(f"{file}: is no GeoJSON: it holds a {type(tree).__name__}, expected is a FeatureCollection")
    kind = tree.get("type")
    if kind == "FeatureCollection":
        for feature in tree.get("features") or []:
            yield from _geometries(feature, file)
    elif kind == "Feature":
        properties = tree.get("properties") or {}
        named = [str(properties[key]) for key in NAMES if properties.get(key) not in (None, "")]
        for _, geometry in _geometries(tree.get("geometry") or {"type": "feature without geometry"}, file):
            yield (named or [str(tree.get("id") or "drawing")])[0], geometry
    elif kind == "GeometryCollection":
        for geometry in tree.get("geometries") or []:
            yield from _geometries(geometry, file)
    else:
        yield "drawing", tree


def _points(line: Any, layer: str, file: str, *, along: bool) -> list[Point]:
    """Points of a line, those that repeat the one before left out."""
    try:
        rows = [tuple(float(value) for value in place) for place in line]
        size = {len(row) for row in rows}
    except (TypeError, ValueError):
        raise CaseError(f"{file}: layer '{layer}': coordinates are no lists of numbers") from None
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
    return [row for number, row in enumerate(rows) if not number or row != rows[number - 1]]  # type: ignore[misc]
