# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves and players that were handed on: what a page takes of the files of a folder, field by field.

A page draws what it holds, so that a number in the place of a text, or a line without its points, would end its script.

A page runs on what it holds, so the header is checked field by field. The frames are unpacked once as the page unpacks
them, see `frames`: numbers beyond the text or its counts would keep the page busy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, RootModel, ValidationError, model_validator

from lammps_jump.analysis.quantities import captions
from lammps_jump.core.library import BYTES, INTEGER, core, function
from lammps_jump.errors import DumpError
from lammps_jump.files import CURVES, MOST_JSON, read_file
from lammps_jump.quoting import shortened, typed

from .frames import BASE, LEAST, MOST_FRAMES, MOST_ROWS, OF_A_KIND, SHADES, SLOTS, TOP, UNREST, digits_of
from .page import Player

MOST_LINES, MOST_VALUES, MOST_PANELS = 1_000, 10_000, 100
Value = Annotated[FiniteFloat, Field(ge=-1e300, le=1e300)]
Text = Annotated[str, Field(max_length=500)]
Values = Annotated[list[Value | None], Field(max_length=MOST_VALUES)]
Ends = tuple[Value | None, Value | None]
Labelled = Annotated[list[tuple[Text, Value | None]], Field(max_length=MOST_LINES)]


class _CurvePart(BaseModel, strict=True, extra="forbid"):
    pass


class _Line(_CurvePart):
    label: Text
    look: Literal["first", "second", "third", "sum", "theory", "measured", "fit", "faint", "dots"]
    x: Values | None = None
    y: Values
    error: Values | None = None


class _Panel(_CurvePart):
    y: Text
    x: Text
    lines: Annotated[list[_Line], Field(max_length=MOST_LINES)]
    levels: Labelled
    marks: Labelled
    solids: Annotated[
        list[Annotated[list[tuple[Value, Value]], Field(max_length=MOST_VALUES)]], Field(max_length=MOST_LINES)
    ]
    xlim: Ends
    ylim: Ends
    height: Annotated[FiniteFloat, Field(gt=0, le=100)]

    @model_validator(mode="after")
    def lines_are_whole(self) -> _Panel:
        """Each line has as many places as values, its own or those of the first one."""
        for line in self.lines:
            places = line.x if line.x is not None else self.lines[0].x
            if places is None or len(places) != len(line.y) or len(line.error or line.y) != len(line.y):
                raise ValueError("a line needs as many values as places")
        return self


class _Chart(_CurvePart):
    title: Text
    x: Text
    time: bool
    window: tuple[Value, Value] | None
    panels: Annotated[list[_Panel], Field(max_length=MOST_PANELS)]


class _Bars(_CurvePart):
    title: Text
    x: Text
    bars: Labelled


class _StoredCurves(RootModel[dict[Text, _Chart | _Bars]]):
    pass


def read_curves(folder: Path) -> dict[str, dict[str, Any]]:
    """Figures that a page draws of a folder, by their names; empty where there is no such file.

    Raises
    ------
    DumpError
        It is none that this program has written; with the field.
    """
    path = folder / CURVES
    try:
        stored = _StoredCurves.model_validate_json(read_file(path, MOST_JSON))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error})") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise DumpError(
            f"{path}: {shortened(place)}: {shortened(first['msg'])}; `{typed('analyze', folder)}` makes it again"
        ) from None
    known = captions()
    return {name: one.model_dump(exclude_unset=True) for name, one in stored.root.items() if name in known}


# --- players that were handed on: what a page of a study takes of the ``player.json`` of a member ---------------------


COLUMNS = 8
"""Numbers of a disc in the table of discs."""
KINDS = 4 + COLUMNS + 1
"""Kinds of numbers: changes of a row, columns of the table, the map."""
MOST_BITS = 31
MOST_FORCES = 20_000
MOST_CELLS, MOST_BINS, MOST_SHAPES, MOST_POINTS = 100_000, 100_000, 10_000, 100_000
MOST_WIDTHS = 1000
"""Widths of a bin in the largest radius: the page adds the area of a disc bin by bin."""
Number = Annotated[FiniteFloat, Field(ge=-1e12, le=1e12)]
Above = Annotated[FiniteFloat, Field(gt=0, le=1e12)]
Name = Annotated[str, Field(max_length=500)]
_Outlet = tuple[Literal["x", "y"], Number, Literal["above", "below"]]


_holds_frames = function(
    "jump_holds_frames", BYTES, INTEGER, INTEGER, INTEGER, INTEGER, INTEGER, INTEGER, result=INTEGER
)


class _Part(BaseModel, strict=True, extra="forbid"):
    pass


class _Map(_Part):
    name: Literal["packing", "pressure"]
    unit: Above
    power: Above
    low: tuple[Number, Number]
    counts: tuple[Annotated[int, Field(ge=1, le=MOST_CELLS)], Annotated[int, Field(ge=1, le=MOST_CELLS)]]
    sides: tuple[Above, Above]


_Points = Annotated[list[tuple[Number, Number]], Field(min_length=1, max_length=MOST_POINTS)]
_Way = Annotated[list[Number], Field(max_length=MOST_FRAMES)] | None


_Known = Annotated[list[Number | None], Field(max_length=MOST_FRAMES)] | None


class _Body(_Part):
    mass: Above
    centre: tuple[Number, Number]
    vx: _Known = None
    vy: _Known = None
    fx: _Known = None
    fy: _Known = None

    def ways_fit(self, frames: int) -> bool:
        """Tells whether it has velocity and force for each frame, or neither."""
        ways = [self.vx, self.vy, self.fx, self.fy]
        return ways == [None] * 4 or all(way is not None and len(way) == frames for way in ways)


class _Force(_Part):
    time: Annotated[list[Number], Field(min_length=1, max_length=MOST_FORCES)]
    fx: Annotated[list[Number], Field(max_length=MOST_FORCES)]
    fy: Annotated[list[Number], Field(max_length=MOST_FORCES)]
    each: Number
    taken: Annotated[int, Field(ge=1)]

    def fits(self) -> bool:
        """Tells whether its columns have one length and its times grow."""
        return len(self.time) == len(self.fx) == len(self.fy) and bool((np.diff(self.time) > 0).all())


class _Shape(_Part):
    name: Name
    hollow: bool
    outlines: Annotated[list[_Points], Field(max_length=MOST_SHAPES)]
    lines: Annotated[list[_Points], Field(max_length=MOST_SHAPES)]
    about: tuple[Number, Number] | None = None
    x: _Way = None
    y: _Way = None
    angle: _Way = None
    body: _Body | None = None
    force: _Force | None = None

    def ways_fit(self, frames: int) -> bool:
        """Tells whether it is at rest, or has a pose for each frame, as a body always has; and its forces fit."""
        ways = [self.x, self.y, self.angle]
        if self.force is not None and not self.force.fits():
            return False
        if self.about is None:
            return ways == [None] * 3 and self.body is None
        if self.body is not None and not self.body.ways_fit(frames):
            return False
        return all(way is not None and len(way) == frames for way in ways)


class _Gate(_Shape):
    until: Number


class _Bins(_Part):
    low: Number
    width: Above
    count: Annotated[int, Field(ge=1, le=MOST_BINS)]


class _Header(_Part):
    times: Annotated[list[Number], Field(min_length=1, max_length=MOST_FRAMES)]
    q: Above
    qv: Above
    discs: Annotated[int, Field(ge=1, le=MOST_ROWS)]
    rows: Annotated[int, Field(ge=1, le=MOST_ROWS)]
    radii: Annotated[list[Above], Field(min_length=1, max_length=SHADES)]
    share: Annotated[FiniteFloat, Field(gt=0, le=1)]
    map: _Map | None
    name: Name
    unit: Literal["s", "steps"]
    gravity: tuple[Number, Number]
    seen: tuple[tuple[Number, Number], tuple[Number, Number]]
    fastest: Number | None
    walls: Annotated[list[_Shape], Field(max_length=MOST_SHAPES)]
    gates: Annotated[list[_Gate], Field(max_length=MOST_SHAPES)]
    inlets: Annotated[list[tuple[Number, Number]], Field(max_length=MOST_SHAPES)]
    outlets: Annotated[list[tuple[Literal["x", "y"], Number, Literal["above", "below"]]], Field(max_length=MOST_SHAPES)]
    bins: _Bins
    seam: tuple[Number, Number] | None = None
    fixed: tuple[Number, Number] | None = None
    area: Above
    density: Above | None = None
    bed: Number
    sequent: list[tuple[Number | None, Number | None, Number | None] | None]


class _Stored(_Part):
    header: _Header
    frames: str
    still: tuple[str, str] | None = None


def read_player(path: Path) -> Player:
    """The player in a file that was handed on; the picture next to it, which only the browser would check, is left out.

    Raises
    ------
    OSError
        No such file.
    ValueError
        It is none that this program has written.
    """
    try:
        stored = _Stored.model_validate_json(read_file(path, MOST_JSON))
    except ValidationError as error:
        raise ValueError(f"{path}: {error.errors(include_url=False)[0]['msg']}") from None
    header = stored.header
    cells = int(np.prod(header.map.counts)) if header.map else 0
    right = (
        len(header.sequent) == len(header.times)
        and (np.diff(header.times) > 0).all()
        and all(low < high for low, high in header.seen)
        and (header.seam is None or header.seam[1] - header.seam[0] > 2.0 * max(header.radii))
        and max(header.radii) <= MOST_WIDTHS * header.bins.width
        and cells <= MOST_CELLS
        and all(wall.ways_fit(len(header.times)) for wall in (*header.walls, *header.gates))
        and sum(len(part) for wall in (*header.walls, *header.gates) for part in (*wall.outlines, *wall.lines))
        <= MOST_POINTS
    )
    counts = (header.discs, header.rows, len(header.times), len(header.radii), cells)
    if not right or not holds_frames(stored.frames, *counts):
        raise ValueError(f"{path}: holds no packed frames")
    return Player(header.model_dump(exclude_unset=True), stored.frames)


def holds_frames(text: str, discs: int, rows: int, frames: int, shades: int, cells: int) -> bool:
    """Tells whether a text holds `discs` discs of `rows` rows in all in so many frames, a map, and nothing else.

    Raises
    ------
    ValueError
        A letter that packed numbers do not have.
    """
    digits, counts = digits_of(text), (discs, rows, frames, shades, cells)
    if len(digits) < 4:
        return False
    if core() is None:
        return _holds_each(digits.tolist(), *counts)
    return bool(_holds_frames(digits.astype(np.uint8), len(digits), *counts))


class _MissingDigits(Exception):
    """Digits that the coder has not written."""


class _Reader:
    """The numbers that digits hold, one after the other, as the core reads them."""

    def __init__(self, digits: list[int]):
        self.digits, self.read, self.span, self.place = digits, 4, TOP, 0
        for digit in digits[:4]:
            self.place = self.place * BASE + digit
        self.odds = [2048] * (KINDS * OF_A_KIND * SLOTS)

    def shrink(self, start: int, size: int, step: int) -> None:
        """Make a part of the interval the interval."""
        self.place -= start * step
        self.span = size * step
        if not 0 <= self.place < self.span:
            raise _MissingDigits
        while self.span < LEAST:
            digit = self.digits[self.read] if self.read < len(self.digits) else 0
            self.read, self.place, self.span = self.read + 1, self.place * BASE + digit, self.span * BASE

    def take(self, context: int) -> int:
        """The next number."""
        slot, left, value = SLOTS * context, 0, 1
        while True:
            ones, step = self.odds[slot], self.span >> 12
            if self.place >= ones * step:
                self.odds[slot] -= ones >> 5
                self.shrink(ones, 4096 - ones, step)
                break
            self.odds[slot] += (4096 - ones) >> 5
            self.shrink(0, ones, step)
            left, slot = left + 1, slot + 1
            if left > MOST_BITS:
                raise _MissingDigits
        while left:
            bits = min(left, 8)
            step = self.span >> bits
            part = self.place // step
            self.shrink(part, 1, step)
            value, left = (value << bits) + part, left - bits
        if self.read > len(self.digits):
            raise _MissingDigits
        return -(value >> 1) if value % 2 else value >> 1


def _holds_each(digits: list[int], discs: int, rows: int, frames: int, shades: int, cells: int) -> bool:
    """Tells whether digits hold `discs` discs of `rows` rows in all in so many frames, a map, and nothing else."""
    reader = _Reader(digits)
    column, stays = [0] * COLUMNS, []
    try:
        for _ in range(discs):
            column = [value + reader.take(OF_A_KIND * (4 + k)) for k, value in enumerate(column)]
            if not (column[1] >= 0 and column[2] > 0 and column[1] + column[2] <= frames and 0 <= column[5] < shades):
                return False
            stays.append(range(column[1] + 1, column[1] + column[2]))
        if sum(len(stay) + 1 for stay in stays) != rows:
            return False
        unrest = [UNREST] * discs
        for frame in range(frames):
            for disc, stay in enumerate(stays):
                if frame in stay:
                    unrest[disc] = _unrest_after(reader, unrest[disc])
        levels = [0] * cells
        for _ in range(frames):
            levels = [level + reader.take(OF_A_KIND * (4 + COLUMNS) + level.bit_length()) for level in levels]
            if not all(0 <= level < 256 for level in levels):
                return False
    except _MissingDigits:
        return False
    return reader.read == len(digits)


def _unrest_after(reader: _Reader, unrest: int) -> int:
    """Change of the unrest of a disc by a row."""
    felt = unrest
    for part in range(4):
        if felt.bit_length() > MOST_BITS:
            raise _MissingDigits
        size = abs(reader.take(OF_A_KIND * part + felt.bit_length()))
        felt += 2 * size if part < 2 else size >> 1
    return (felt - unrest) >> 1
