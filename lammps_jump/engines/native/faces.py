# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a scene as the numbers that the wall loops read: one row a face."""

from __future__ import annotations

import numpy as np

from lammps_jump.scene.walls import Wall

from .loops import BLOCK, PLANE_X, PLANE_Y, Faces

CODES = {"plane_x": PLANE_X, "plane_y": PLANE_Y, "rectangle": BLOCK}


def faces_of(walls: tuple[Wall, ...]) -> tuple[Faces, list[str]]:
    """Faces of walls, no disc near them yet, and the name of the wall that each face belongs to.

    A row of data holds the four numbers of `primitive` and the wall's moment point: (at, sign, 0, 0, x, y) of a plane,
    (xlo, xhi, ylo, yhi, x, y) of a rectangle; m.
    """
    rows = [(wall, *face.primitive) for wall in walls for face in wall.faces()]
    kind = np.array([CODES[shape] for _, shape, _ in rows], np.int64)
    data = np.array([(*numbers, *wall.moment_point) for wall, _, numbers in rows], float).reshape(-1, 6)
    start, near, total = np.zeros(kind.size + 1, np.int64), np.empty(0, np.int32), np.zeros((kind.size, 3))
    return Faces(kind, data, start, near, total), [wall.name for wall, _, _ in rows]
