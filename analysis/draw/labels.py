# SPDX-License-Identifier: GPL-2.0-or-later
"""A drawing to scale whose labels find a place: none lies on another one."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.path import Path as Way
from matplotlib.patheffects import withStroke

from lammps_jump.quoting import figure_text
from lammps_jump.scene.walls import Interval

from .style import BLACK

WIDEST, NARROWEST, HIGHEST, DOTS = 1320, 640, 640, 120
"""Pixels of what is shown: most and least width, most height; and those of an inch."""
LEFT, RIGHT, BELOW, ABOVE = 70, 20, 60, 44
"""Pixels around the axes."""
LEFT, RIGHT, BELOW, ABOVE = 70, 20, 60, 44
"""Pixels around the axes."""
DIRECTIONS, RINGS, STEP, GAP = 24, 14, 9.0, 4.0
"""Places that are tried around a point: directions, distances, pixels from one to the next and before the first."""
ON_BUSY, CROSSED = 60.0, 20.0
"""Pixels by which a label that lies on what is busy counts as further away: wholly; for each thing that it touches."""
ROOM = 2.0
"""Pixels between two labels."""


class Label(NamedTuple):
    """A text of `wide` times `high` pixels for a point; with `inside` its middle may be there."""

    x: float
    y: float
    wide: float
    high: float
    inside: bool = False


def place_labels(
    labels: Sequence[Label], width: float, height: float, busy: Sequence[Sequence[float]] = ()
) -> list[tuple[float, float] | None]:
    """Lower left corner of each label within a picture; None where there is no room that is left.

    One label after the other takes the free place that is nearest to its point, where what is busy counts as far.

    Parameters
    ----------
    labels : sequence of Label
        The first ones choose first.
    width, height : float
        Of the picture, pixels.
    busy : sequence of (x low, x high, y low, y high)
        What labels had better not cover, pixels.
    """
    turns = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    aim = np.column_stack([np.cos(turns), np.sin(turns)])
    avoided = np.array(busy, float).reshape(-1, 4)
    taken = np.empty((0, 4))
    found: list[tuple[float, float] | None] = []
    for label in labels:
        half = 0.5 * np.array([label.wide, label.high])
        away = GAP + STEP * np.arange(RINGS)
        # the middle of a text whose edge is so far from the point
        edge = 1 / np.max(np.abs(aim) / half, axis=1)
        middles = ((away[:, None] + edge)[..., None] * aim).reshape(-1, 2) + np.array([label.x, label.y])
        cost = np.repeat(away, DIRECTIONS)
        if label.inside:
            middles, cost = np.vstack([middles, [label.x, label.y]]), np.append(cost, 0.0)
        boxes = np.column_stack(
            [middles[:, 0] - half[0], middles[:, 0] + half[0], middles[:, 1] - half[1], middles[:, 1] + half[1]]
        )
        shared = _shared(boxes, avoided)
        cost = cost + ON_BUSY * np.minimum(1.0, shared.sum(axis=1) / (label.wide * label.high))
        cost += CROSSED * (shared > 0).sum(axis=1)
        if label.inside:
            cost[-1] = 0.0
        free = (boxes[:, 0] >= 0) & (boxes[:, 1] <= width) & (boxes[:, 2] >= 0) & (boxes[:, 3] <= height)
        free &= ~(_shared(boxes, taken + ROOM * np.array([-1, 1, -1, 1])) > 0).any(axis=1)
        if not free.any():
            found.append(None)
            continue
        best = int(np.argmin(np.where(free, cost, np.inf)))
        taken = np.vstack([taken, boxes[best]])
        found.append((float(boxes[best, 0]), float(boxes[best, 2])))
    return found


def _shared(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Area that each box shares with each of others, of shape (n, 4) and (m, 4); shape (n, m)."""
    wide = np.minimum(boxes[:, None, 1], others[:, 1]) - np.maximum(boxes[:, None, 0], others[:, 0])
    high = np.minimum(boxes[:, None, 3], others[:, 3]) - np.maximum(boxes[:, None, 2], others[:, 2])
    return np.maximum(wide, 0.0) * np.maximum(high, 0.0)


class _Named(NamedTuple):
    """A label that waits for its place."""

    text: str
    place: tuple[float, float]
    colour: str
    on: tuple[Interval, Interval]


class Drawing:
    """A drawing to scale that grows: what is put in is drawn at once, but for labels, which are placed at the end."""

    def __init__(self, x: Interval, y: Interval):
        self.x, self.y = x, y
        self.scale = min(WIDEST / (x[1] - x[0]), HIGHEST / (y[1] - y[0]))
        wide, high = self.scale * (x[1] - x[0]), self.scale * (y[1] - y[0])
        size = wide + LEFT + RIGHT, high + ABOVE + BELOW
        self.figure = Figure(figsize=(size[0] / DOTS, size[1] / DOTS), dpi=DOTS)
        self.canvas = FigureCanvasAgg(self.figure)
        self.axes = self.figure.add_axes((LEFT / size[0], BELOW / size[1], wide / size[0], high / size[1]))
        self.axes.set(xlim=x, ylim=y, xlabel="x [m]", ylabel="y [m]")
        self.axes.grid(False)
        self.size = wide, high
        self.labels: list[_Named] = []
        self.busy: list[tuple[float, float, float, float]] = []

    def label(self, text: str, x: float, y: float, colour: str = BLACK, *, on: tuple[Interval, Interval] | None = None):
        """A text for a point, m; in the middle of the rectangle `on` instead, if it fits there."""
        place = float(np.clip(x, *self.x)), float(np.clip(y, *self.y))
        self.labels.append(_Named(figure_text(text), place, colour, on or ((0.0, 0.0), (0.0, 0.0))))

    def keep_free(self, x: Interval, y: Interval) -> None:
        """No label had better cover this rectangle, m."""
        ends = np.array([x[0] - self.x[0], x[1] - self.x[0], y[0] - self.y[0], y[1] - self.y[0]])
        self.busy.append(tuple((ends * self.scale).tolist()))

    def arrow(self, points: np.ndarray, colour: str, width: float = 1.6, head: float = 13.0) -> None:
        """An arrow along points, shape (n, 2), m."""
        look = {"arrowstyle": "-|>", "mutation_scale": head, "capstyle": "butt", "joinstyle": "miter"}
        self.axes.add_patch(FancyArrowPatch(path=Way(points), color=colour, lw=width, zorder=5, **look))
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        pad = 3 / self.scale
        self.keep_free((x0 - pad, x1 + pad), (y0 - pad, y1 + pad))

    def write_labels(self) -> None:
        """Place all labels; where one stands away from its point, a line leads there."""
        halo = [withStroke(linewidth=2.5, foreground="white")]
        look = {"fontsize": 8.5, "path_effects": halo, "va": "bottom", "zorder": 8}
        texts = [self.axes.text(0, 0, one.text, color=one.colour, **look) for one in self.labels]
        renderer = self.canvas.get_renderer()
        sizes = [text.get_window_extent(renderer) for text in texts]
        asked = []
        for one, size in zip(self.labels, sizes, strict=True):
            fits = bool((self.scale * np.ptp(one.on, axis=1) > (size.width + 4, size.height)).all())
            x, y = np.mean(one.on, axis=1) if fits else one.place
            asked.append(
                Label((x - self.x[0]) * self.scale, (y - self.y[0]) * self.scale, size.width, size.height, fits)
            )
        places = place_labels(asked, *self.size, self.busy)
        for text, label, place in zip(texts, asked, places, strict=True):
            if place is None:
                text.remove()  # the table of the page names it
                continue
            left, low = place
            text.set_position((self.x[0] + left / self.scale, self.y[0] + low / self.scale))
            near = np.clip(label.x, left, left + label.wide), np.clip(label.y, low, low + label.high)
            if hypot(near[0] - label.x, near[1] - label.y) > 10:
                ends = [np.array(self.x[:1]) + np.array([label.x, near[0]]) / self.scale,
                        np.array(self.y[:1]) + np.array([label.y, near[1]]) / self.scale]  # fmt: skip
                self.axes.plot(*ends, color=text.get_color(), lw=0.7, zorder=7, scalex=False, scaley=False)
