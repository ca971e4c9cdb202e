# SPDX-License-Identifier: GPL-2.0-or-later
"""Players that were handed on: what a page of a study takes of the ``player.json`` of a member.

A page runs on what it holds, so the header is checked field by field. The frames are unpacked once as the page unpacks
them, see `frames` and `coder`: numbers beyond the text or its counts would keep the page busy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numba import njit
from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from lammps_jump.files import MOST_JSON, read_file

from .coder import BASE, LEAST, SLOTS, TOP, digits_of
from .frames import MOST_FRAMES, MOST_ROWS, OF_A_KIND, SHADES, UNREST
from .page import Player

COLUMNS = 8
"""Numbers of a disc in the table of discs."""
KINDS = 4 + COLUMNS + 1
"""Kinds of numbers: changes of a row, columns of the table, the map."""
MOST_BITS = 31
MOST_CELLS, MOST_BINS, MOST_SHAPES, MOST_POINTS = 100_000, 100_000, 10_000, 100_000
MOST_WIDTHS = 1000
"""Widths of a bin in the largest radius: the page adds the area of a disc bin by bin."""
Number = Annotated[FiniteFloat, Field(ge=-1e12, le=1e12)]
Above = Annotated[FiniteFloat, Field(gt=0, le=1e12)]
Name = Annotated[str, Field(max_length=500)]
_Outlet = tuple[Literal["x", "y"], Number, Literal["above", "below"]]


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


class _Shape(_Part):
    name: Name
    hollow: bool
    outlines: Annotated[list[_Points], Field(max_length=MOST_SHAPES)]
    lines: Annotated[list[_Points], Field(max_length=MOST_SHAPES)]
    about: tuple[Number, Number] | None = None
    x: _Way = None
    y: _Way = None
    angle: _Way = None

    def ways_fit(self, frames: int) -> bool:
        """Whether it stands, or has a pose for each frame."""
        ways = [self.x, self.y, self.angle]
        if self.about is None:
            return ways == [None] * 3
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
    bed: Number
    sequent: list[tuple[Number | None, Number | None, Number | None] | None]


class _Stored(_Part):
    header: _Header
    frames: str
    still: tuple[str, str] | None = None


def read_player(path: Path) -> Player:
    """The player in a file that was handed on; the picture beside it, which only the browser would check, is left out.

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
    odds = np.full(KINDS * OF_A_KIND * SLOTS, 2048)
    if not right or not _is_whole(digits_of(stored.frames), *counts, odds):
        raise ValueError(f"{path}: holds no packed frames")
    return Player(header.model_dump(exclude_unset=True), stored.frames)


def _shrink_py(digits, state, start, size, step):
    """Make a part of the interval the interval; `state` is the digits read, the place in the interval, its range."""
    state[1] -= start * step
    state[2] = size * step
    if not 0 <= state[1] < state[2]:
        state[0] = digits.size + 1
        return
    while state[2] < LEAST:
        digit = digits[state[0]] if state[0] < digits.size else 0
        state[0], state[1], state[2] = state[0] + 1, state[1] * BASE + digit, state[2] * BASE


def _take_py(digits, state, odds, context):
    """The next number; after one that is none, more digits than there are count as read."""
    slot, left, value = SLOTS * context, 0, 1
    while state[0] <= digits.size:
        ones, step = odds[slot], state[2] >> 12
        if state[1] >= ones * step:
            odds[slot] -= ones >> 5
            _shrink(digits, state, ones, 4096 - ones, step)
            break
        odds[slot] += (4096 - ones) >> 5
        _shrink(digits, state, 0, ones, step)
        left, slot = left + 1, slot + 1
        if left > MOST_BITS:
            state[0] = digits.size + 1
    if left == 0 or state[0] > digits.size:
        return 0
    while left:
        bits = min(left, 8)
        step = state[2] >> bits
        part = state[1] // step
        _shrink(digits, state, part, 1, step)
        value, left = (value << bits) + part, left - bits
    return -(value >> 1) if value % 2 else value >> 1


def _is_whole_py(digits, discs, rows, frames, shades, cells, odds):
    """Whether digits hold `discs` discs of `rows` rows in all in so many frames, a map, and nothing else."""
    state = np.array([4, 0, TOP])
    if digits.size < 4:
        return False
    for k in range(4):
        state[1] = state[1] * BASE + digits[k]
    first, life, column = np.zeros(discs, np.int64), np.zeros(discs, np.int64), np.zeros(COLUMNS, np.int64)
    for disc in range(discs):
        for k in range(COLUMNS):
            column[k] += _take(digits, state, odds, OF_A_KIND * (4 + k))
        first[disc], life[disc] = column[1], column[2]
        stays = column[1] >= 0 and column[2] > 0 and column[1] + column[2] <= frames
        if state[0] > digits.size or not stays or not 0 <= column[5] < shades:
            return False
    if life.sum() != rows:
        return False
    unrest = np.full(discs, UNREST)
    for frame in range(frames):
        for disc in range(discs):
            if not 0 < frame - first[disc] < life[disc]:
                continue
            felt = unrest[disc]
            for part in range(4):
                length = 0
                while felt >> length:
                    length += 1
                if length > MOST_BITS:
                    return False
                size = abs(_take(digits, state, odds, OF_A_KIND * part + length))
                felt += 2 * size if part < 2 else size >> 1
            unrest[disc] = (felt - unrest[disc]) >> 1
            if state[0] > digits.size:
                return False
    return _holds_map(digits, state, frames, cells, odds) and state[0] == digits.size


def _holds_map_py(digits, state, frames, cells, odds):
    """Whether the numbers of a map come next, each from 0 to 255."""
    levels = np.zeros(cells, np.int64)
    for _ in range(frames):
        for k in range(cells):
            length = 0
            while levels[k] >> length:
                length += 1
            levels[k] += _take(digits, state, odds, OF_A_KIND * (4 + COLUMNS) + length)
            if state[0] > digits.size or not 0 <= levels[k] < 256:
                return False
    return True


_shrink = njit(cache=True)(_shrink_py)
_take = njit(cache=True)(_take_py)
_holds_map = njit(cache=True)(_holds_map_py)
_is_whole = njit(cache=True)(_is_whole_py)
