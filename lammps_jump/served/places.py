# SPDX-License-Identifier: GPL-2.0-or-later
"""Places of a case that can be dragged in the drawing, and where their numbers stand in the text.

Places are found by how they are written: sides ``x: [a, b]`` and ``y: [c, d]``, points, a centre and its radius, one
coordinate. So a new kind of wall that writes its place in such a way can be dragged too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

from lammps_jump.case.text import CaseSource, PathKey, dotted_path
from lammps_jump.units import to_si

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
class Written:
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
        self.numbers: list[Written] = []
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
        self.numbers.append(Written(start, end, digits * unit, unit))
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
                    told = f"{called}, point {index + 1}"
                    yield from self._point((*here, index), item, told)
                    yield from self._of(item, (*here, index), told)
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
