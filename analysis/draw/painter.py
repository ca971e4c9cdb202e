# SPDX-License-Identifier: GPL-2.0-or-later
"""A small software painter: anti-aliased discs, lines and arrows on an RGB picture; the part of the plane in it.

Pictures are arrays of shape (height, width, 3), uint8, first row on top. World coordinates are metres; a `View`
maps them. Discs are painted as true circles: coverage falls linearly over one pixel at the rim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, floor, hypot

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.analysis.flow import Flow
from lammps_jump.core.library import BYTES, INTEGER, REAL, REALS, core, entry
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.shapes import thin
from lammps_jump.scene.walls import Interval, Wall, parts_of

TALLEST = 20
"""Most height of what is shown, in its lengths."""


def disc_speeds(frame: Frame) -> np.ndarray:
    """Speeds for the colours of a picture, m/s; zero where they are not known."""
    if "vx" in frame.columns and "vy" in frame.columns:
        return np.nan_to_num(np.hypot(frame.vx, frame.vy))
    return np.zeros(frame.n)


def top_of(speeds: Sequence[np.ndarray], step: float = 0.5) -> float:
    """End of a colour scale: the 99.5 % quantile of all speeds, so that one fast disc does not darken all.

    It is rounded up to a multiple of `step` of its power of ten.
    """
    together = np.concatenate(list(speeds)) if speeds else np.zeros(0)
    together = together[np.isfinite(together)]
    high = float(np.quantile(together, 0.995)) if together.size else 0.0
    if not high > 0:
        return 1.0
    unit = step * 10.0 ** np.floor(np.log10(high))
    return float(np.ceil(high / unit) * unit)


def seen(frames: Sequence[Frame], flow: Flow) -> tuple[Interval, Interval]:
    """Part of the plane that is worth showing, m.

    Along x the studied stretch, cut short where the frames hold neither a disc nor a block; along y from just below the
    floor to just above nearly all discs there.
    """
    (low, high), diameter = flow.x_range, flow.scene.diameter
    standing = {wall for frame in frames for wall in flow.standing_at(flow.time(frame))}
    blocks = [wall.extent for wall in standing if wall.finite]
    parts = [frame.x[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    ends = [float(np.quantile(part, q)) for part in parts if part.size for q in (0.0, 0.999)]
    ends += [end for sides, _ in blocks for end in sides if low < end < high]
    if ends:
        margin = 0.02 * (max(ends) - min(ends)) + 2 * diameter
        low, high = max(low, min(ends) - margin), min(high, max(ends) + margin)
    floors = flow.bed_height(np.linspace(low, high, 200))
    bottom = float(np.min(floors[np.isfinite(floors)], initial=np.inf))
    bottom = bottom if np.isfinite(bottom) else flow.scene.domain[1][0]
    heights = [frame.y[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    tops = [float(np.quantile(part, 0.995)) for part in heights if part.size]
    tops += [highest for (start, end), (_, highest) in blocks if end > low and start < high]
    top = max([*tops, bottom + 5 * diameter])
    top = min(top, bottom + TALLEST * (high - low))  # a disc that flew away does not make the picture
    margin = 0.06 * (top - bottom) + diameter
    return (low, high), (bottom - margin, top + margin)


PAPER = (255, 255, 255)
SOLID = (196, 196, 196)
EDGE = (70, 70, 70)
BAR = 5.0
"""Width of what has no thickness, pixels."""

_paint_discs = entry(
    "jump_paint_discs", picture=BYTES, height=INTEGER, width=INTEGER, n=INTEGER, column=REALS, row=REALS, radius=REALS,
    scale=REAL, colours=BYTES,
)  # fmt: skip


@dataclass(frozen=True)
class View:
    """Part of the plane that a picture shows: the same scale on both axes.

    Parameters
    ----------
    x, y : (float, float)
        Extent, m.
    width, height : int
        Pixels.
    """

    x: Interval
    y: Interval
    width: int
    height: int

    @property
    def scale(self) -> float:
        """Pixels a metre."""
        return self.width / (self.x[1] - self.x[0])

    def column(self, x: ArrayLike) -> np.ndarray:
        """Pixel coordinate of x (pixel i covers i … i + 1)."""
        return (np.asarray(x, float) - self.x[0]) * self.scale

    def row(self, y: ArrayLike) -> np.ndarray:
        """Pixel coordinate of y, downwards."""
        return (self.y[1] - np.asarray(y, float)) * self.scale

    @classmethod
    def fitted(cls, x: Interval, y: Interval, width: int) -> View:
        """A view of these extents in even pixels, about `width` wide; its height follows (and y grows to them)."""
        height = max(2, ceil((y[1] - y[0]) * width / (x[1] - x[0])))
        width, height = width + width % 2, height + height % 2
        return cls(x, (y[0], y[0] + height * (x[1] - x[0]) / width), width, height)


def blank(view: View) -> np.ndarray:
    """A white picture, shape (height, width, 3), uint8."""
    return np.full((view.height, view.width, 3), PAPER, np.uint8)


def paint_walls(picture: np.ndarray, view: View, walls: tuple[Wall, ...], gates: tuple[Wall, ...] = ()) -> None:
    """Walls as grey solids, sheets as bars; of open lines and of gates without end a bar behind the faces."""
    solid = np.zeros(picture.shape[:2], bool)
    for wall in (*walls, *(gate for gate in gates if gate.finite)):
        solid |= _solid(wall, view)
    bar = BAR / view.scale
    for gate in gates:
        if not gate.finite:
            distance = gate.distance(*_centres(view, slice(None), slice(None)))
            solid |= (distance < 0) & (distance > -bar)
    picture[solid] = SOLID
    # the face of a wall is the first solid pixel next to an open one
    open_ = np.pad(~solid, 1, constant_values=False)
    is_next_to_open = open_[:-2, 1:-1] | open_[2:, 1:-1] | open_[1:-1, :-2] | open_[1:-1, 2:]
    picture[solid & is_next_to_open] = EDGE


def _centres(view: View, rows: slice, columns: slice) -> tuple[np.ndarray, np.ndarray]:
    """Centres of pixels, m: x of shape (1, columns), y of shape (rows, 1)."""
    x = view.x[0] + (np.arange(view.width)[columns] + 0.5) / view.scale
    y = view.y[1] - (np.arange(view.height)[rows] + 0.5) / view.scale
    return x[None, :], y[:, None]


def _solid(wall: Wall, view: View) -> np.ndarray:
    """Pixels whose centre is in the solid of a wall, or near one of its faces without thickness."""
    wide = tuple((low - (high - low), high + (high - low)) for low, high in (view.x, view.y))
    turns, bars = np.zeros((view.height, view.width + 1), bool), np.zeros((view.height, view.width), bool)
    outlines, lines = parts_of(wall, *wide)
    for polygon in outlines:
        if thin(polygon):
            _mark_near(polygon, view, bars)
        else:
            _mark_turns(polygon, view, turns)
    for line in lines:
        _mark_behind(line, view, bars)
    return bars | (np.logical_xor.accumulate(turns, axis=1)[:, :-1] ^ wall.hollow)


def _mark_turns(polygon: np.ndarray, view: View, turns: np.ndarray) -> None:
    """Turns over the first pixel after each crossing of a closed polygon with a row of pixels."""
    column, row = view.column(polygon[:, 0]), view.row(polygon[:, 1])
    first = np.clip(np.ceil(np.minimum(row, np.roll(row, -1)) - 0.5), 0, view.height).astype(int)
    last = np.clip(np.ceil(np.maximum(row, np.roll(row, -1)) - 0.5), 0, view.height).astype(int)
    for k in np.flatnonzero(last > first):
        end, rows = (k + 1) % len(row), np.arange(first[k], last[k])
        crossing = column[k] + (rows + 0.5 - row[k]) * ((column[end] - column[k]) / (row[end] - row[k]))
        turns[rows, np.clip(np.ceil(crossing - 0.5), 0, view.width).astype(int)] ^= True


def _mark_near(polygon: np.ndarray, view: View, bars: np.ndarray) -> None:
    """Mark the pixels within half a bar of a line."""
    for start, end in pairwise(polygon):
        rows, columns, along, across = _beside(start, end, view)
        off = np.hypot(across, along - np.clip(along, 0.0, np.hypot(*(end - start))))
        bars[rows, columns] |= off <= 0.5 * BAR / view.scale


def _mark_behind(line: np.ndarray, view: View, bars: np.ndarray) -> None:
    """Mark the pixels of a bar right of an open line, where it has no discs."""
    ways = np.diff(line, axis=0)
    left = np.append(np.append(False, ways[:-1, 0] * ways[1:, 1] > ways[:-1, 1] * ways[1:, 0]), False)
    for k, (start, end) in enumerate(pairwise(line)):
        rows, columns, along, across = _beside(start, end, view)
        over = along - np.clip(along, 0.0, np.hypot(*ways[k]))
        # behind a turn to the left the bars of both faces would leave a gap
        there = (over == 0) | ((over < 0) & left[k]) | ((over > 0) & left[k + 1])
        bars[rows, columns] |= there & (across <= 0) & (np.hypot(over, across) <= BAR / view.scale)


def _beside(start: np.ndarray, end: np.ndarray, view: View) -> tuple[slice, slice, np.ndarray, np.ndarray]:
    """Rows and columns of the pixels around a face, and how far they are along it and left of it, m."""
    columns = _pixels(view.column([start[0], end[0]]), view.width)
    rows = _pixels(view.row([start[1], end[1]]), view.height)
    x, y = _centres(view, rows, columns)
    long = np.hypot(*(end - start))
    tx, ty = (end - start) / long if long > 0 else (1.0, 0.0)
    dx, dy = x - start[0], y - start[1]
    return rows, columns, tx * dx + ty * dy, tx * dy - ty * dx


def _pixels(ends: np.ndarray, size: int) -> slice:
    """Pixels from end to end of a line (pixel coordinates) with half a bar around."""
    return slice(*np.clip((floor(ends.min() - BAR), ceil(ends.max() + BAR)), 0, size))


def paint_discs(
    picture: np.ndarray, view: View, x: np.ndarray, y: np.ndarray, radius: ArrayLike, colours: np.ndarray
) -> None:
    """Discs as anti-aliased circles.

    Parameters
    ----------
    picture : ndarray, shape (height, width, 3), uint8
        Painted in place.
    x, y : ndarray, shape (n,), m
    radius : float or ndarray of shape (n,), m
    colours : ndarray, shape (n, 3), uint8
    """
    column, row = (np.ascontiguousarray(place, float) for place in (view.column(x), view.row(y)))
    sizes = np.ascontiguousarray(np.broadcast_to(np.asarray(radius, float), column.shape))
    colours = np.ascontiguousarray(colours, np.uint8)
    if core() is None:
        _paint_each(picture, column, row, sizes, view.scale, colours)
    else:
        whole = np.ascontiguousarray(picture)
        _paint_discs(
            picture=whole, height=len(whole), width=whole.shape[1], n=len(column), column=column, row=row, radius=sizes,
            scale=view.scale, colours=colours,
        )  # fmt: skip
        if whole is not picture:  # a part of a larger one
            picture[...] = whole


def paint_frame(picture: np.ndarray, view: View, frame: Frame, flow: Flow, top_speed: float) -> None:
    """The discs of a frame, coloured by speed; the last colour is that of `top_speed`, m/s."""
    paint_discs(picture, view, frame.x, frame.y, flow.radii(frame), coloured(disc_speeds(frame), top_speed))


def paint_arrow(picture: np.ndarray, start: Interval, end: Interval, thickness: float, colour: ArrayLike) -> None:
    """An arrow from `start` to `end` (pixel column, row), its head four thicknesses wide."""
    (x0, y0), (x1, y1) = start, end
    length = hypot(x1 - x0, y1 - y0)
    if not length > 0:
        return
    thickness = min(thickness, 0.2 * length)  # a short arrow is thin, not stubby
    head, half = 4.0 * thickness, 2.0 * thickness + 1.0
    sides = zip((y0, x0), (y1, x1), picture.shape[:2], strict=True)
    box = tuple(slice(*np.clip((floor(min(a, b) - half), ceil(max(a, b) + half)), 0, size)) for a, b, size in sides)
    y, x = np.mgrid[box] + 0.5 - np.reshape((y0, x0), (2, 1, 1))
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    along, across = x * ux + y * uy, np.abs(y * ux - x * uy)
    shaft = np.minimum(0.5 * thickness + 0.5 - across, along + 0.5)
    point = np.where(along > length, 0.0, 2.0 * thickness * (length - along) / head + 0.5 - across)
    cover = np.clip(np.where(along < length - head, shaft, point), 0.0, 1.0)[..., None]
    picture[box] = picture[box] + cover * (np.array(colour) - picture[box]) + 0.5


@lru_cache
def colour_table() -> np.ndarray:
    """The colour map cividis as bytes, shape (256, 3)."""
    from matplotlib import colormaps

    return (colormaps["cividis"](np.arange(256))[:, :3] * 255 + 0.5).astype(np.uint8)


def coloured(values: np.ndarray, top: float) -> np.ndarray:
    """Colours of values from 0 to `top`, shape (n, 3), uint8; beyond it the last colour."""
    table = colour_table()
    scaled = np.nan_to_num(np.asarray(values, float) / (top if top > 0 else 1.0))
    return table[np.clip((scaled * len(table)).astype(int), 0, len(table) - 1)]


def _paint_each(
    picture: np.ndarray, column: np.ndarray, row: np.ndarray, radius: np.ndarray, scale: float, colours: np.ndarray
) -> None:
    """As the core does, disc by disc."""
    height, width = picture.shape[:2]
    for c, r, size, colour in zip(column.tolist(), row.tolist(), radius.tolist(), colours, strict=True):
        rim, ink = size * scale, 1.0
        if rim < 0.5:  # a disc below a pixel keeps its share of the pixel's ink
            rim, ink = 0.5, (rim / 0.5) ** 2
        if not (-rim - 1.0 <= c <= width + rim + 1.0 and -rim - 1.0 <= r <= height + rim + 1.0):
            continue
        rows = slice(max(floor(r - rim - 0.5), 0), min(ceil(r + rim + 0.5), height))
        columns = slice(max(floor(c - rim - 0.5), 0), min(ceil(c + rim + 0.5), width))
        dy, dx = (np.arange(part.start, part.stop) + 0.5 - at for part, at in ((rows, r), (columns, c)))
        cover = (rim + 0.5 - np.sqrt(dx * dx + (dy * dy)[:, None]))[..., None]
        shaded = np.where(cover >= 1.0, ink, cover * ink)
        old = picture[rows, columns]
        picture[rows, columns] = np.where(cover > 0.0, old + shaded * (colour.astype(float) - old) + 0.5, old)
