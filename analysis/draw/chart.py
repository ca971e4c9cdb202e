# SPDX-License-Identifier: GPL-2.0-or-later
"""Description of a figure, drawn by the page (``report/curves.js``) or by matplotlib (`style.drawn`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.scene.walls import Interval, Wall

MOST_POINTS = 1000
"""Points of a line on the page: a screen has that many columns of pixels."""


class Trace(NamedTuple):
    """One curve.

    Attributes
    ----------
    label : str
        Empty: not in the legend.
    x, y : ndarray, shape (n,)
        Where y is NaN the line has a gap.
    look : str
        first, second, third or sum; theory and measured of others; fit, faint, dots.
    error : ndarray, shape (n,), or None
        Standard error of y; two either side are shaded.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    look: str = "first"
    error: np.ndarray | None = None


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    y : str
        Name and unit of the ordinate.
    lines : sequence of Trace
    x : str
        Of the abscissa, where it is not that of the chart.
    levels, marks : mapping of label to number
        Horizontal lines of a theory; vertical marks.
    solids : sequence of ndarray, shape (corners, 2)
        Walls.
    xlim, ylim : (float or None, float or None)
        None: as the lines ask.
    height : float
        Share of the height, relative to the other panels.
    """

    y: str
    lines: Sequence[Trace]
    x: str = ""
    levels: Mapping[str, float] = field(default_factory=dict)
    marks: Mapping[str, float] = field(default_factory=dict)
    solids: Sequence[np.ndarray] = ()
    xlim: tuple[float | None, float | None] = (None, None)
    ylim: tuple[float | None, float | None] = (None, None)
    height: float = 1.0


@dataclass(frozen=True)
class Described:
    """Base of what has a title.

    Attributes
    ----------
    title : str
    name : str
        Of the scene, for separate figures.
    """

    title: str
    name: str = field(default="", kw_only=True)

    @property
    def heading(self) -> str:
        """Name and title."""
        return ": ".join(filter(None, (self.name, self.title)))


@dataclass(frozen=True)
class Chart(Described):
    """Panels above each other, on one abscissa unless they name their own.

    Attributes
    ----------
    x : str
        Name and unit of the abscissa.
    panels : sequence of Panel
    window : (float, float) or None
        Stretch of the abscissa that is shaded: where means are taken.
    """

    x: str
    panels: Sequence[Panel]
    window: Interval | None = None

    @property
    def plain(self) -> dict[str, Any]:
        """Plain data for the page: text and numbers, five digits of each."""
        return {
            "title": self.title,
            "x": self.x,
            "time": self.x == TIME,
            "window": self.window,
            "panels": [_plain_panel(panel) for panel in self.panels],
        }


@dataclass(frozen=True)
class Bars(Described):
    """Numbers with a sign side by side, the last one their sum.

    Attributes
    ----------
    x : str
        Name and unit of the numbers.
    rows : mapping of label to number
    """

    x: str
    rows: Mapping[str, float]

    @property
    def plain(self) -> dict[str, Any]:
        """Plain data for the page."""
        return {"title": self.title, "x": self.x, "bars": [[label, value] for label, value in self.rows.items()]}


@dataclass(frozen=True)
class Map(Described):
    """Values over distance and time or height, in colours.

    Attributes
    ----------
    label : str
        Name and unit of the values.
    x : ndarray, shape (bins + 1,), m
        Edges of the bins.
    y : ndarray, shape (rows,)
        Times, s, or heights of the middles of cells, m.
    values : ndarray, shape (rows, bins)
    side : str
        Name and unit of y.
    signed : bool
        The colours do not begin at zero.
    lines : sequence of Trace
        On top, y over x.
    solids : sequence of ndarray, shape (corners, 2)
        Walls.
    to_scale : bool
        One scale for x and y, all of both shown; else lines of equal values are drawn.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    side: str
    signed: bool = False
    lines: Sequence[Trace] = ()
    solids: Sequence[np.ndarray] = ()
    to_scale: bool = False


Drawings = dict[str, Chart | Bars | Map | None]
"""By the name of the figure; None where there is nothing to draw."""
TIME, PLACE = "Time t [s]", "Distance x [m]"
"""Abscissas; a chart over time follows the time of the player."""


def edges_of(middles: np.ndarray) -> np.ndarray:
    """Edges of cells between their middles, shape (n + 1,); of a single one half a unit on either side."""
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    between = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([[2 * middles[0] - between[0]], between, [2 * middles[-1] - between[-1]]])


def stairs(label: str, values: np.ndarray, edges: np.ndarray, look: str = "first") -> Trace:
    """A line that is constant in each bin; values of shape (n,), edges of shape (n + 1,)."""
    return Trace(label, np.repeat(edges, 2)[1:-1], np.repeat(values, 2), look)


def _plain_panel(panel: Panel) -> dict[str, Any]:
    lines: list[dict[str, Any]] = []
    for line in panel.lines:
        shown = thinned(line)
        numbers = {"x": _digits(shown.x), "y": _digits(shown.y)}
        if shown.error is not None and np.isfinite(shown.error).any():
            numbers["error"] = _digits(shown.error)
        if lines and lines[0]["x"] == numbers["x"]:
            del numbers["x"]  # that of the first line
        lines.append({"label": line.label, "look": line.look, **numbers})
    pairs = {name: list(map(list, getattr(panel, name).items())) for name in ("levels", "marks")}
    return {**vars(panel), **pairs, "lines": lines, "solids": [np.round(solid, 4).tolist() for solid in panel.solids]}


def _digits(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:z.5g}") if value == value else None for value in np.asarray(values, float).tolist()]


def thinned(line: Trace, most: int = MOST_POINTS) -> Trace:
    """The least and the largest value of equal pieces of a long line: it looks the same where a piece is a pixel."""
    count = len(line.x)
    if count <= most:
        return line
    cuts = np.linspace(0, count, most // 2 + 1).astype(int)
    y = np.asarray(line.y, float)
    low, high = np.where(np.isnan(y), np.inf, y), np.where(np.isnan(y), -np.inf, y)
    pairs = [(a + low[a:b].argmin(), a + high[a:b].argmax()) for a, b in pairwise(cuts)]
    kept = np.unique(pairs)
    return line._replace(x=line.x[kept], y=y[kept], error=None if line.error is None else line.error[kept])


def shown_walls(walls: Sequence[Wall], x: Interval, y: Interval) -> list[np.ndarray]:
    """Outlines of the solid walls, cut to what is shown."""
    outlines = [outline for wall in walls if not wall.hollow for outline in wall.outline(x, y)]
    return [shown for outline in outlines if len(shown := _cut(outline, x, y))]


def _cut(polygon: np.ndarray, x: Interval, y: Interval) -> np.ndarray:
    """The part of a closed polygon within x and y (Sutherland and Hodgman, Comm. ACM 17 (1974) 32)."""
    for axis, at, sign in ((0, x[0], 1), (0, x[1], -1), (1, y[0], 1), (1, y[1], -1)):
        inside = sign * (polygon[:, axis] - at) >= 0
        kept = []
        for k, corner in enumerate(polygon):
            if inside[k] != inside[k - 1]:
                before = polygon[k - 1]
                crossing = before + (corner - before) * ((at - before[axis]) / (corner[axis] - before[axis]))
                crossing[axis] = at
                kept.append(crossing)
            if inside[k]:
                kept.append(corner)
        polygon = np.array(kept, float).reshape(-1, 2)
    return polygon
