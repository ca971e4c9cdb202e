# SPDX-License-Identifier: GPL-2.0-or-later
"""Where two walls cross."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

import numpy as np

from lammps_jump.scene.chains import Chain, boxes, faces_of_chain, lay
from lammps_jump.scene.shapes import common

from .strokes import Point


def crossing(one: Sequence[Chain], two: Sequence[Chain], near: float) -> Point | None:
    """A place where chains cross, m; ends and corners of both that lie on each other are none. None: they do not."""
    faces = [[face for chain in chains for face in faces_of_chain(chain)] for chains in (one, two)]
    box, other = (boxes(lay([(tuple(chains), False)]), deep=False) for chains in (one, two))
    for face, (xlo, xhi, ylo, yhi) in zip(faces[0], box, strict=True):
        over = (other[:, 0] - near <= xhi) & (other[:, 1] + near >= xlo)
        over &= (other[:, 2] - near <= yhi) & (other[:, 3] + near >= ylo)
        for index in np.flatnonzero(over):
            second = faces[1][index]
            for point in common(face, second, near):
                if not (_at(point, face.start, face.end, near) and _at(point, second.start, second.end, near)):
                    return point
    return None


def _at(point: Point, start: Point, end: Point, near: float) -> bool:
    """Whether a point is one of two ends."""
    return any(hypot(point[0] - x, point[1] - y) <= 1e3 * near for x, y in (start, end))
