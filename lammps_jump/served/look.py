# SPDX-License-Identifier: GPL-2.0-or-later
"""Look at the text of a case for its page: errors at their lines, the drawing with its places, derived numbers.

Also the text with the walls of a drawing that is dropped on the page.

Places are recognized by how they are written: sides ``x: [a, b]`` and ``y: [c, d]``, points, centre and radius, one
coordinate. So a new kind of wall that writes its place in such a way can be dragged too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump import drawings, engines, live, runs
from lammps_jump.analysis.draw import svg
from lammps_jump.case.case import ReadCase
from lammps_jump.case.packing import disc_sizes, discs_at_start
from lammps_jump.case.text import CaseSource, PathKey, dotted_path
from lammps_jump.errors import CaseError, JumpError
from lammps_jump.files import plain
from lammps_jump.quoting import typed
from lammps_jump.units import shown, to_si

MOST = 400
"""Places of a case that are offered; a surveyed line of more is edited as text."""
NUMBER = re.compile(r"""(["']?)([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*([^"']*)\1""")
POINTS = {"centre", "origin", "arc_to", "about", "pivot", "hinge"}
"""Fields that hold one point."""
LISTS = {"points", "positions"}
"""Fields that hold a list of points."""
ALONG_X, ALONG_Y = {"x_beyond", "x_before", "front"}, {"y_below", "y_above"}
"""Fields that hold one coordinate."""
ROWS_OF_X = {"gauges", "stations"}
"""Fields that hold a list of places along x."""
SIDES = (("left", "right"), ("lower", "upper"))


@dataclass(frozen=True)
class WrittenLength:
    """A length as the text has it.

    Attributes
    ----------
    start, end : int
        Where its digits begin and end in the text, in letters of JavaScript (UTF-16).
    value : float
        m.
    unit : float
        Metres of one unit of the text.
    """

    start: int
    end: int
    value: float
    unit: float


@dataclass(frozen=True)
class Place:
    """A place that can be dragged.

    Attributes
    ----------
    name : str
    x, y : float or None
        m; None: it goes all across.
    along_x, along_y : tuple of int
        Numbers that change by as much as it moves along an axis.
    radius_of : (float, float) or None
        Its distance from this point is the number of `along_x`, m.
    """

    name: str
    x: float | None
    y: float | None
    along_x: tuple[int, ...] = ()
    along_y: tuple[int, ...] = ()
    radius_of: tuple[float, float] | None = None


class Places:
    """The places of a case.

    Parameters
    ----------
    source : CaseSource
        Of `text`.
    text : str

    Attributes
    ----------
    numbers : list of Written
    found : list of Place
    """

    def __init__(self, source: CaseSource, text: str):
        self._source, self._text = source, text
        self._plain = text.isascii() or max(map(ord, text)) < 0x10000  # one letter is one of JavaScript
        self._known: dict[PathKey, int] = {}
        self.numbers: list[WrittenLength] = []
        self.found = list(islice(self._of(source.data, (), ""), MOST))

    def _number(self, path: PathKey) -> int | None:
        """Index of a length in `numbers`; None where the text has no number there."""
        if path in self._known:
            return self._known[path]
        span = self._source.spans.get(path)
        hit = NUMBER.fullmatch(self._text[span[0] : span[1]]) if span else None
        if span is None or hit is None:
            return None
        digits = float(hit[2])
        try:
            unit = to_si(f"1 {hit[3]}", "m") if hit[3].strip() else 1.0
        except ValueError:
            return None
        self._known[path] = len(self.numbers)
        start, end = (self._letters(span[0] + hit.start(2)), self._letters(span[0] + hit.end(2)))
        self.numbers.append(WrittenLength(start, end, digits * unit, unit))
        return self._known[path]

    def _letters(self, index: int) -> int:
        """A place in the text as JavaScript counts it."""
        return index if self._plain else len(self._text[:index].encode("utf-16-le")) // 2

    def _pair(self, path: PathKey, value: Any) -> tuple[int, int] | None:
        """Indices of the two numbers of a list of two; None for all else."""
        if not isinstance(value, list) or len(value) != 2:
            return None
        first, second = self._number((*path, 0)), self._number((*path, 1))
        return None if first is None or second is None else (first, second)

    def _of(self, data: Any, path: PathKey, name: str) -> Iterator[Place]:
        """Places of all that lies below a path."""
        if isinstance(data, list):
            for index, value in enumerate(data):
                yield from self._of(value, (*path, index), f"{name} {index + 1}" if name else "")
        if not isinstance(data, Mapping):
            return
        name = str(data.get("name") or name or "") if path else ""
        yield from self._of_group(data, path, name)
        for key, value in data.items():
            here, called = (*path, key), name or str(key)
            if key in POINTS:
                yield from self._point(here, value, f"{called}, {key}" if key != "arc_to" else called)
            elif key in LISTS and isinstance(value, list):
                for index, item in enumerate(value):
                    label = f"{called}, point {index + 1}"
                    yield from self._point((*here, index), item, label)
                    yield from self._of(item, (*here, index), label)
            elif key in ROWS_OF_X and isinstance(value, list):
                for index, _ in enumerate(value):
                    yield from self._line((*here, index), f"{key} {index + 1}", "x")
            elif key in ALONG_X | ALONG_Y:
                yield from self._line(here, dotted_path(here), "x" if key in ALONG_X else "y")
            else:
                yield from self._of(value, here, called if isinstance(value, list | Mapping) else "")

    def _of_group(self, data: Mapping[str, Any], path: PathKey, name: str) -> Iterator[Place]:
        """Places that several fields of a group make together."""
        x, y = (self._pair((*path, axis), data.get(axis)) for axis in "xy")
        if x and y and not data.get("angle"):
            yield from self._rectangle(x, y, name)
        along, up = (self._number((*path, axis)) for axis in "xy")
        if along is not None and up is not None:
            yield self._at(name, along, up)
        if data.get("axis") in ("x", "y") and "at" in data:
            yield from self._line((*path, "at"), name, data["axis"])
        centre, radius = self._pair((*path, "centre"), data.get("centre")), self._number((*path, "radius"))
        if centre and radius is not None:
            cx, cy = (self.numbers[one].value for one in centre)
            yield Place(f"{name}, radius", cx + self.numbers[radius].value, cy, (radius,), (), (cx, cy))

    def _rectangle(self, x: tuple[int, int], y: tuple[int, int], name: str) -> Iterator[Place]:
        """Four corners of a rectangle and its middle."""
        for j, up in zip(y, SIDES[1], strict=True):
            for i, along in zip(x, SIDES[0], strict=True):
                yield Place(f"{name}, {up} {along}", self.numbers[i].value, self.numbers[j].value, (i,), (j,))
        if name != "domain":
            mx, my = (0.5 * (self.numbers[a].value + self.numbers[b].value) for a, b in (x, y))
            yield Place(f"{name}, whole", mx, my, x, y)

    def _point(self, path: PathKey, value: Any, name: str) -> Iterator[Place]:
        if pair := self._pair(path, value):
            yield self._at(name, *pair)

    def _at(self, name: str, along: int, up: int) -> Place:
        """A place of one number along each axis."""
        return Place(name, self.numbers[along].value, self.numbers[up].value, (along,), (up,))

    def _line(self, path: PathKey, name: str, axis: str) -> Iterator[Place]:
        """A place along one axis, which goes all across the other."""
        if (one := self._number(path)) is not None:
            value = self.numbers[one].value
            yield Place(name, value, None, (one,)) if axis == "x" else Place(name, None, value, (), (one,))


NARROWEST, WIDEST = 240, 2000
"""Pixels of a drawing."""
MOST_DISCS = 1_000_000
"""Discs of a case that a page draws; a few seconds."""
MOST_DRAWN = 12_000_000
"""Bytes of a drawing that a page sends: with a text of a case, it fits into a request."""


class DroppedFile(NamedTuple):
    """A drawing that a page sends: the name of its file, its bytes, and its unit or scale where one is given."""

    name: str
    data: bytes
    scale: str | None


def look(text: str, file: Path, wide: int) -> dict[str, Any]:
    """Findings of `check` and `preview` in the text of a case file, for a drawing of this width, pixels.

    Of a case that cannot be used it is ``error`` alone: line (or None) and message.
    """
    try:
        case = ReadCase.parse(text, str(file), folder=file.parent)
        many = discs_at_start(case.fields, disc_sizes(case.fields))
        if many > MOST_DISCS:
            raise CaseError(
                f"{file}: {many} discs at the start; this page draws up to {MOST_DISCS}, and `lammps-jump preview` more"
            )
        resolved, chosen = engines.accuracy.with_accuracy(case)
        derived = resolved.check()
        widest = min(max(wide, NARROWEST), WIDEST) - svg.LEFT - svg.RIGHT
        drawing = runs.view.drawing_of(resolved, widest)
    except JumpError as error:
        return {"error": located(str(error), str(file))}
    places = Places(case.source, text)
    groups = [
        (title, [(label, shown(value), unit) for _, label, value, unit in rows]) for title, rows in derived.tables
    ]
    return plain(
        {
            "name": case.name,
            "description": case.fields.description,
            "drawing": svg.svg_text(drawing),
            "view": {"left": svg.LEFT, "top": svg.ABOVE, "x": drawing.x, "y": drawing.y, "scale": drawing.scale},
            "numbers": [asdict(one) for one in places.numbers],
            "places": [asdict(one) for one in places.found],
            "derived": [group for group in groups if group[1]],
            "doubtful": [*derived.warnings, *chosen],
            "notes": [*derived.begins, *derived.slopes, *derived.skipped],
        }
    )


def flow_page(text: str, file: Path) -> str:
    """A live page of the text of a case file, without sliders of numbers: those take a set-up for each value.

    Raises
    ------
    JumpError
        A text that is no case, or one that a live page cannot have.
    """
    return live.live_page(live.prepare(ReadCase.parse(text, str(file), folder=file.parent), numbers=False))


def flow_of_run(folder: Path, time: float) -> str:
    """A live page of a run from a time on, s, next to the run as recorded; without sliders of numbers.

    Raises
    ------
    JumpError
        A run that goes on, or whose files cannot be read; a time outside it; a case that a live page cannot have.
    """
    starts = live.from_times(ReadCase.load(folder), folder, [time], numbers=False)
    return live.live_page(starts, "", live.recorded_run(folder))


def with_drawing(text: str, file: Path, dropped: DroppedFile) -> dict[str, Any]:
    """The text of a case with the walls of a drawing, as ``import --into`` adds them; the file is not touched.

    Returns
    -------
    dict
        ``text``; ``added``: what each wall is; ``notes``: what is left out of the drawing or doubtful in it.

    Raises
    ------
    CaseError
        A text that is no case, a drawing that is too large, and as `read_drawing`, `entries` and `with_walls`.
    """
    name, data, scale = dropped
    if len(data) > MOST_DRAWN:
        raise CaseError(
            f"{name}: has {len(data) / 1e6:.1f} MB; the page takes up to {MOST_DRAWN / 1e6:g} MB, and "
            f"`{typed('import', Path(name), '--into', Path(file.name))}` more"
        )
    ReadCase.parse(text, file.name, folder=file.parent)
    drawing = drawings.read_drawing(name, scale=scale, data=data)
    entries = drawings.entries(drawing)
    return {
        "text": drawings.with_walls(text, entries, file.name),
        "added": [f"{one.wall['name']}: {', '.join(one.facts)}" for one in entries],
        "notes": [*drawing.notes, *drawings.doubts(entries, max(drawing.extent()))],
    }


def with_shape(text: str, file: Path, what: str, points: list[tuple[float, float]]) -> dict[str, Any]:
    """The text of a case with a shape that was drawn in its picture; a body has the density of the discs.

    Raises
    ------
    CaseError
        A text that is no case, and as `drawings.with_drawn`.
    """
    case = ReadCase.parse(text, str(file), folder=file.parent)
    return {"text": drawings.with_drawn(text, what, points, case.fields.discs.density, file.name)}


def located(message: str, file: str) -> dict[str, Any]:
    """A message about a case, without the name of its file, and the line that it is about."""
    hit = re.match(rf"{re.escape(file)}(?::(\d+))?: (.*)", message, re.DOTALL)
    return {"line": int(hit[1]) if hit and hit[1] else None, "text": hit[2] if hit else message}
