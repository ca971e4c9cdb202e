# SPDX-License-Identifier: GPL-2.0-or-later
"""A drawing of any kind, in metres."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from lammps_jump.errors import CaseError, ScaleError, SetupError
from lammps_jump.files import read_file
from lammps_jump.foreign import foreign, reason
from lammps_jump.quoting import shortened
from lammps_jump.units import to_si

from .dxf import read_dxf
from .strokes import LayeredDrawing, Measure, Point
from .survey import read_geojson, read_survey
from .svg import read_svg

MOST_DRAWING = 100_000_000
"""Bytes of a drawing."""
FARTHEST = 1e7
"""Largest coordinate of a wall, m."""
SCALES = 1e-12, 1e12
"""Least and largest metres of a unit of a drawing, and what it may be reduced by."""
WORDS = {
    ".dxf": "DXF drawing", ".svg": "SVG drawing", ".geojson": "GeoJSON", ".json": "GeoJSON",
    ".csv": "table of a survey", ".txt": "table of a survey",
}  # fmt: skip
"""Name of a file, by its ending."""
TOLERANCE = 1e-3
"""Distance that straight pieces may lie from the curve that they stand for, m."""


def read_drawing(
    path: str | Path,
    *,
    scale: str | None = None,
    shift: Point = (0.0, 0.0),
    along: bool = False,
    tolerance: float = TOLERANCE,
    data: bytes | None = None,
) -> LayeredDrawing:
    """A drawing in metres.

    Parameters
    ----------
    path : path
        Its ending names the kind: DXF, SVG, GeoJSON, or a table of a survey (CSV).
    scale : str, optional
        Unit of the drawing (``mm``), or metres of one of its units (``0.5``): goes before what the file says. Or what
        the drawing is reduced by (``1:100``), in addition to the unit of the file.
    shift : (float, float)
        Where the origin of the drawing comes to lie, m.
    along : bool
        Lines of GeoJSON are drawn in plan, with heights.
    tolerance : float
        How far straight pieces may lie from a curve, m.
    data : bytes, optional
        What the file holds, where it has been read already.

    Raises
    ------
    CaseError
        A file that cannot be read, another kind, nothing in it.
    ScaleError
        No unit (both readings are named), a wrong scale.
    SetupError
        The package that reads this kind is not installed.
    """
    path = Path(path)
    measure = _measure(scale, tolerance)
    reader = _reader(path, measure, along=along)
    try:
        data_read = read_file(path, MOST_DRAWING) if data is None else data
    except FileNotFoundError:
        raise CaseError(f"{path}: no such drawing") from None
    except (OSError, ValueError) as error:
        raise CaseError(f"{path}: cannot be read ({reason(error)})") from None
    try:
        kind = WORDS[path.suffix.lower()]
        with foreign(CaseError, f"{path}: is no {kind} that can be read", "draw or export it anew"):
            drawing = reader(data_read, str(path))
    except ImportError as error:
        package = (error.name or "").partition(".")[0]
        raise SetupError(
            f"{path}: {package} reads such drawings and is not installed: pip install 'lammps-jump[drawings]'"
        ) from None
    if not any(layer.points() for layer in drawing.layers):
        left = "; ".join(drawing.notes)
        raise CaseError(f"{path}: holds no line, arc or circle" + (f" ({left})" if left else ""))
    factor = measure.per_unit(drawing.unit)
    if factor is None:
        raise ScaleError(_two_readings(drawing))
    notes = list(drawing.notes)
    if measure.metres is not None and drawing.unit is not None and abs(factor / drawing.unit - 1) > 1e-9:
        notes.append(f"{drawing.unit_told}; --scale {scale} is taken instead")
    mapped = replace(drawing, layers=tuple(layer.mapped(factor, shift) for layer in drawing.layers), notes=tuple(notes))
    _require_near(mapped)
    return mapped


def _require_near(drawing: LayeredDrawing) -> None:
    """CaseError where a place is farther away than any flow, m."""
    for layer in drawing.layers:
        far = next((point for point in layer.points() if not max(map(abs, point)) <= FARTHEST), None)
        if far is not None:
            raise CaseError(
                f"{drawing.file}: layer '{layer.name}': ({far[0]:.4g}, {far[1]:.4g}) m is farther than {FARTHEST:g} m "
                "from the origin: is its unit right (--scale)? --shift X,Y moves a drawing"
            )


def _reader(path: Path, measure: Measure, *, along: bool) -> Callable[[bytes, str], LayeredDrawing]:
    kinds: dict[str, Callable[[bytes, str], LayeredDrawing]] = {
        ".dxf": partial(read_dxf, measure=measure),
        ".svg": partial(read_svg, measure=measure),
        ".geojson": partial(read_geojson, along=along),
        ".json": partial(read_geojson, along=along),
        ".csv": read_survey,
        ".txt": read_survey,
    }
    ending = path.suffix.lower()
    if ending not in kinds:
        raise CaseError(f"{path}: ends in '{ending}'; drawings that are read end in {', '.join(WORDS)}")
    if along and WORDS[ending] != "GeoJSON":
        raise CaseError(f"{path}: --along is for GeoJSON, whose lines are drawn in plan with heights; leave it out")
    return kinds[ending]


def _measure(scale: str | None, tolerance: float) -> Measure:
    """Unit of ``--scale``: a unit, metres of one, or 1:100."""
    if scale is None:
        return Measure(tolerance=tolerance)
    low, high = SCALES
    reduced = re.fullmatch(r"1\s*:\s*(\d+(?:\.\d*)?)", scale, re.ASCII)
    if reduced and low <= float(reduced[1]) <= high:
        return Measure(None, float(reduced[1]), tolerance)
    for text in (scale, f"1 {scale or 'unit'}"):
        try:
            metres = float(to_si(text, "m"))
        except ValueError as error:
            problem = error
            continue
        if low <= metres <= high:
            return Measure(metres, tolerance=tolerance)
        problem = ValueError(f"is out of range; allowed is {low:g} to {high:g} m")
        break
    raise ScaleError(
        f"--scale {shortened(scale)}: {problem}; write a unit such as mm, metres of one unit such as 0.01, or 1:100"
    )


def _two_readings(drawing: LayeredDrawing) -> str:
    wide, high = drawing.extent()
    return (
        f"{drawing.file}: its unit is not known ({drawing.unit_told}). In metres it is {wide:z.4g} m wide and "
        f"{high:z.4g} m high, in millimetres {wide / 1e3:z.4g} m and {high / 1e3:z.4g} m: say which by --scale m or "
        "--scale mm (any unit, or the metres of one unit)"
    )
