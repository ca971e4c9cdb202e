# SPDX-License-Identifier: GPL-2.0-or-later
"""A drawing to scale, described: shapes in metres by what they are, and labels that have been placed.

`style.figure` draws it with matplotlib, `svg.svg_text` as text of a page. Neither knows what is drawn.

Places for the labels of a drawing: none lies on another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lammps_jump.scene.walls import Interval

if TYPE_CHECKING:
    from matplotlib.ft2font import FT2Font


WIDEST, NARROWEST, HIGHEST, DOTS = 1320, 640, 640, 120
"""Pixels of what is shown: most and least width, most height; and those of an inch."""
BAND = 6.0
"""Width of the band behind an open line, pixels."""
TEXT = 8.5
"""Size of labels, points."""
HEIGHTS = {
    "domain": 0.0, "outside": 0.5, "outlet": 1.5, "discs": 2.0, "pour": 2.0, "ghost": 2.5, "solid": 3.0, "sheet": 3.0,
    "band": 3.0, "edge": 3.0, "mark": 4.0, "level": 4.0, "arrow": 5.0, "leader": 7.0, "label": 8.0,
}  # fmt: skip
"""Heights of what is drawn: the larger covers the smaller."""


class Area(NamedTuple):
    """Closed rings, shape (n, 2) each, m; a ring within another one is a hole."""

    look: str
    rings: tuple[np.ndarray, ...]


class Stroke(NamedTuple):
    """A line through points, shape (n, 2), m."""

    look: str
    points: np.ndarray
    tone: str = "plain"


class DrawnDiscs(NamedTuple):
    """Discs at places, shape (n, 2), with their diameters, shape (n,), m; the width of their rims, pixels."""

    places: np.ndarray
    diameters: np.ndarray
    rim: float
    look: str = "discs"


class Arrow(NamedTuple):
    """A line through points, shape (n, 2), m, with a head at its end; width and size of the head, points."""

    points: np.ndarray
    tone: str
    width: float
    head: float
    look: str = "arrow"


class LabelText(NamedTuple):
    """A label with its lower left corner, m."""

    text: str
    x: float
    y: float
    tone: str
    look: str = "label"


class _Named(NamedTuple):
    """A label that waits for its place."""

    text: str
    place: tuple[float, float]
    tone: str
    on: tuple[Interval, Interval]


Shape = Area | Stroke | DrawnDiscs | Arrow | LabelText


class Drawing:
    """A drawing that grows.

    Parameters
    ----------
    x, y : (float, float)
        What is shown, m.
    widest : float
        Pixels of its width at most.

    Attributes
    ----------
    scale : float
        Pixels of a metre.
    size : (float, float)
        Pixels.
    shapes : list of Shape
        In the order in which they came; see `HEIGHTS`.
    title, aside : str
        Above it: on the left, and small on the right.
    """

    def __init__(self, x: Interval, y: Interval, widest: float = WIDEST):
        self.x, self.y = x, y
        self.scale = min(widest / (x[1] - x[0]), HIGHEST / (y[1] - y[0]))
        self.size = self.scale * (x[1] - x[0]), self.scale * (y[1] - y[0])
        self.shapes: list[Shape] = []
        self.title = self.aside = ""
        self.labels: list[_Named] = []
        self.busy: list[tuple[float, float, float, float]] = []

    def add(self, shape: Shape) -> None:
        """Put a shape in."""
        self.shapes.append(shape)

    def label(
        self, text: str, x: float, y: float, tone: str = "plain", *, on: tuple[Interval, Interval] | None = None
    ) -> None:
        """A text for a point, m; in the middle of the rectangle `on` instead, if it fits there."""
        place = float(np.clip(x, *self.x)), float(np.clip(y, *self.y))
        self.labels.append(_Named(text, place, tone, on or ((0.0, 0.0), (0.0, 0.0))))

    def keep_free(self, x: Interval, y: Interval) -> None:
        """No label had better cover this rectangle, m."""
        ends = np.array([x[0] - self.x[0], x[1] - self.x[0], y[0] - self.y[0], y[1] - self.y[0]])
        self.busy.append(tuple((ends * self.scale).tolist()))

    def arrow(self, points: np.ndarray, tone: str, width: float = 1.6, head: float = 13.0) -> None:
        """An arrow along points, shape (n, 2), m."""
        self.add(Arrow(points, tone, width, head))
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        pad = 3 / self.scale
        self.keep_free((x0 - pad, x1 + pad), (y0 - pad, y1 + pad))

    def place_labels(self) -> None:
        """Places all labels; where one is away from its point, a line leads there. One without room is left out."""
        labels = []
        for one in self.labels:
            wide, high = size_of(one.text)
            fits = bool((self.scale * np.ptp(one.on, axis=1) > (wide + 4, high)).all())
            x, y = np.mean(one.on, axis=1) if fits else one.place
            labels.append(Label((x - self.x[0]) * self.scale, (y - self.y[0]) * self.scale, wide, high, fits))
        places = place_labels(labels, *self.size, self.busy)
        for one, label, place in zip(self.labels, labels, places, strict=True):
            if place is None:
                continue  # the table of the page names it
            left, low = place
            self.add(LabelText(one.text, self.x[0] + left / self.scale, self.y[0] + low / self.scale, one.tone))
            near = np.clip(label.x, left, left + label.wide), np.clip(label.y, low, low + label.high)
            if hypot(near[0] - label.x, near[1] - label.y) > 10:
                ends = np.array([(label.x, label.y), near]) / self.scale
                self.add(Stroke("leader", ends + np.array([self.x[0], self.y[0]]), one.tone))


@lru_cache(maxsize=1000)
def size_of(text: str) -> tuple[float, float]:
    """Width and height of a label, pixels."""
    font = _font()
    font.set_text(text, 0.0)
    wide = font.get_width_height()[0]
    font.set_text("lp", 0.0)
    return wide / 64, font.get_width_height()[1] / 64


@lru_cache(maxsize=1)
def _font() -> FT2Font:
    """The font of figures; matplotlib alone knows where it is."""
    from matplotlib.font_manager import findfont
    from matplotlib.ft2font import FT2Font

    font = FT2Font(findfont("DejaVu Sans"))
    font.set_size(TEXT, DOTS)
    return font


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
    places_of_labels: list[tuple[float, float] | None] = []
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
            places_of_labels.append(None)
            continue
        best = int(np.argmin(np.where(free, cost, np.inf)))
        taken = np.vstack([taken, boxes[best]])
        places_of_labels.append((float(boxes[best, 0]), float(boxes[best, 2])))
    return places_of_labels


def _shared(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Area that each box shares with each of others, of shape (n, 4) and (m, 4); shape (n, m)."""
    wide = np.minimum(boxes[:, None, 1], others[:, 1]) - np.maximum(boxes[:, None, 0], others[:, 0])
    high = np.minimum(boxes[:, None, 3], others[:, 3]) - np.maximum(boxes[:, None, 2], others[:, 2])
    return np.maximum(wide, 0.0) * np.maximum(high, 0.0)
