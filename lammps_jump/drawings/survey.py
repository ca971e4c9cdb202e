# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines of a survey: tables of chainage and level, and GeoJSON."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from math import hypot, isfinite
from pathlib import Path
from typing import Any

from lammps_jump.errors import CaseError
from lammps_jump.foreign import foreign, number_of
from lammps_jump.quoting import echoed, shortened
from lammps_jump.units import to_si

from .strokes import FARTHEST_DRAWN, GatheredStrokes, LayeredDrawing, Point

COLUMNS = {"chainage": ("chainage", "station", "distance", "x"), "level": ("level", "elevation", "height", "z", "y")}
"""Words of the head of a table, for each of its two columns."""
MOST_LINES = 2_000_000
"""Lines of a table, empty ones among them."""
MOST_COLUMNS = 10_000
"""Cells of a row."""
LONGEST_HEAD = 60
"""Letters of the head of a column."""
HEAD = re.compile(r"\s*([A-Za-z]+)[\s_]*[\[(]?\s*([A-Za-z]*)\s*[\])]?\s*")
"""A word, and perhaps a unit in brackets or after a line: chainage (m), level [ft], x_mm."""


def read_survey(data: bytes, file: str) -> LayeredDrawing:
    """A table of chainage and level, by comma, semicolon, tab or blanks.

    Raises
    ------
    CaseError
        No such columns, two units, cells that are no numbers; with the line.
    """
    rows = _rows(_lines(data, file), file)
    head_line, head = next(rows, (0, []))
    if not head:
        raise CaseError(f"{file}: is empty; a survey has a head such as `chainage (m),level (m)`, and rows of numbers")
    order, unit = _columns(head, f"{file}:{head_line}")
    points: list[tuple[float, float]] = []
    strokes = GatheredStrokes(file)
    for number, cells in rows:
        strokes.room(len(points))
        x, y = (_number(cells, index, head, f"{file}:{number}") for index in order)
        if not points or (x, y) != points[-1]:
            points.append((x, y))
    if len(points) < 2:
        raise CaseError(f"{file}: {len(points)} row of numbers; a line needs two different ones or more")
    strokes.stroke(Path(file).stem, points)
    return LayeredDrawing(file, unit[1], unit[0], strokes.layers())


def _lines(data: bytes, file: str) -> Iterator[str]:
    """Lines of a text; CaseError where it is none, or has too many."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaseError(f"{file}: is not text (byte {error.start} is not UTF-8); a survey is a CSV file") from None
    count = sum(map(text.count, "\n\r"))
    if count > MOST_LINES:
        raise CaseError(f"{file}: has {count:,} lines; at most {MOST_LINES:,} are read, and a wall needs far fewer")
    return iter(text.splitlines())


def _rows(lines: Iterator[str], file: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each row, as many as the head has; empty ones at the end and lines of `#` are left out.

    The head says what is between cells: a semicolon, a tab, a comma or blanks. A cell may be in quotes.
    """
    sign, width = "", 0
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        if (longest := max(map(line.count, ";\t, "))) > MOST_COLUMNS:
            raise CaseError(
                f"{file}:{number}: has {longest:,} cells or blanks; at most {MOST_COLUMNS:,} are read in a row"
            )
        if not width:
            sign = next((sign for sign in (";", "\t", ",") if sign in line), " ")
        cells = [cell.strip() for cell in (line.split() if sign == " " else line.split(sign))]
        if '"' in line and sign != " ":
            with foreign(CaseError, f"{file}:{number}: is no row of a table", "mend the row"):
                cells = [cell.strip() for cell in next(csv.reader([line], delimiter=sign, strict=True))]
        while len(cells) > max(width, 1) and not cells[-1]:
            cells.pop()
        width = width or len(cells)
        if len(cells) != width:
            raise CaseError(
                f"{file}:{number}: has {len(cells)} cells where the head has {width}; a number has a point, not a "
                "comma, and what stands between the cells is the same in all rows"
            )
        yield number, cells


def _number(cells: list[str], index: int, head: list[str], place: str) -> float:
    """The number of a cell; CaseError where it is no number, or has a unit."""
    with suppress(ValueError):
        if isfinite(value := number_of(cells[index])):
            return value
    raise CaseError(
        f"{place}: {echoed(cells[index])} under {head[index]} is no number; expected is one such as 10.5, in the unit "
        "of the head: mend the row, or take it out"
    )


def _columns(head: list[str], place: str) -> tuple[list[int], tuple[str, float | None]]:
    """Columns of chainage and level, and the unit: what tells it, and in metres."""
    words = [HEAD.fullmatch(cell) if len(cell) <= LONGEST_HEAD else None for cell in head]
    order: list[int] = []
    for wanted, known in COLUMNS.items():
        indices = [i for i, word in enumerate(words) if word and word[1].lower() in known]
        if len(indices) != 1:
            raise CaseError(
                f"{place}: columns {echoed(', '.join(head))}: {len(indices)} of them are a {wanted} "
                f"({', '.join(known)}); expected is one of each, such as `chainage (m),level (m)`"
            )
        order += indices
    names = [word[2] if (word := words[i]) else "" for i in order]
    if names[0] != names[1]:
        raise CaseError(
            f"{place}: chainage is in {names[0] or 'no unit'} and level in {names[1] or 'no unit'}; give both one unit"
        )
    if not names[0]:
        return order, ("the head of the table has no unit", None)
    try:
        return order, (f"the head of the table says {names[0]}", float(to_si(f"1 {names[0]}", "m")))
    except ValueError as error:
        raise CaseError(f"{place}: {error}") from None


PARTS = {"LineString": 0, "MultiLineString": 1, "Polygon": 1, "MultiPolygon": 2}
"""Lists that are between a geometry and its lines."""
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
    strokes = GatheredStrokes(file)
    for layer, geometry in _geometries(tree, file):
        kind = geometry.get("type")
        if not isinstance(kind, str) or kind not in PARTS:
            strokes.leave(kind if isinstance(kind, str) else f"geometry of type {echoed(kind)}")
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
                strokes.stroke(layer, points)
            else:
                strokes.leave(f"{kind} without length")
    unit_note = "GeoJSON has no unit of a section: RFC 7946 means degrees of longitude and latitude"
    return LayeredDrawing(file, None, unit_note, strokes.layers(), tuple(strokes.notes(0.0)))


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
