# SPDX-License-Identifier: GPL-2.0-or-later
"""Places for the labels of a drawing: none lies on another one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
