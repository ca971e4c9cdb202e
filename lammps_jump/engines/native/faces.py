# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a scene as the numbers that the wall loops read: one row a face."""

from __future__ import annotations

import numpy as np

from lammps_jump.scene.walls import Wall

from .loops import BLOCK, PLANE_X, PLANE_Y

CODES = {"plane_x": PLANE_X, "plane_y": PLANE_Y, "rectangle": BLOCK}


def faces_of(walls: tuple[Wall, ...]) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Faces of walls as (kind, data, names): int64 (faces,), float64 (faces, 6), the wall each face belongs to.

    A row of data holds the four numbers of `primitive` and the wall's moment point: (at, sign, 0, 0, x, y) of a plane,
    (xlo, xhi, ylo, yhi, x, y) of a rectangle; m.
    """
    rows = [(wall, *face.primitive) for wall in walls for face in wall.faces()]
    data = np.array([(*numbers, *wall.moment_point) for wall, _, numbers in rows], float).reshape(-1, 6)
    return np.array([CODES[shape] for _, shape, _ in rows], np.int64), data, [wall.name for wall, _, _ in rows]
