# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of a periodic channel and of rough beds, as analyses look at them: the discs that move, and their images."""

from __future__ import annotations

import numpy as np

from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.scene.scene import Scene


def placed(frame: Frame, scene: Scene) -> Frame:
    """The frame with all discs inside a periodic channel: engines let them run on until their next list."""
    if scene.period is None or not frame.n:
        return frame
    low = scene.domain[0][0]
    x = low + (frame.x - low) % scene.period
    return make_frame(frame.step, frame.time, frame.box, {**frame.columns, "x": x})


def moving(frame: Frame, scene: Scene) -> Frame:
    """The frame without the fixed discs of rough beds."""
    if scene.fixed is None:
        return frame
    return _taken(frame, ~scene.fixed.holds(frame.ids))


def with_images(frame: Frame, scene: Scene) -> Frame:
    """The frame with images of the discs near the ends of a periodic channel, beyond the other end.

    Sums over a part of the channel are then whole at its ends. Ids of images are those of their discs.
    """
    if scene.period is None or not frame.n:
        return frame
    (low, high), d = scene.domain[0], scene.largest
    first, last = frame.x < low + d, frame.x > high - d
    parts = [_taken(frame, where).columns for where in (first, last)]
    shifted = [
        {**columns, "x": columns["x"] + way} for columns, way in zip(parts, (scene.period, -scene.period), strict=True)
    ]
    joined = {
        name: np.concatenate([values, *(part[name] for part in shifted)]) for name, values in frame.columns.items()
    }
    return make_frame(frame.step, frame.time, frame.box, joined)


def fixed_discs(frame: Frame, scene: Scene) -> Frame:
    """The fixed discs of a frame's scene alone, with images, at rest."""
    if scene.fixed is None:
        return _taken(frame, np.zeros(frame.n, bool))
    ids = np.arange(scene.fixed.first, scene.fixed.last + 1)
    x, y = scene.positions[ids - 1].T
    radius = 0.5 * scene.diameters(ids)
    columns = {"id": ids, "x": x, "y": y, "vx": 0 * x, "vy": 0 * x, "radius": radius}
    return with_images(make_frame(frame.step, frame.time, frame.box, columns), scene)


def _taken(frame: Frame, mask: np.ndarray) -> Frame:
    return make_frame(frame.step, frame.time, frame.box, {name: values[mask] for name, values in frame.columns.items()})
