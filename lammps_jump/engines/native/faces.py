"""Walls of a scene as the numbers that the wall kernel reads: one row a face."""

from __future__ import annotations

import numpy as np

from lammps_jump.scene.walls import Block, Box, Plane, Wall

from .loops import BLOCK, PLANE_X, PLANE_Y


def reference_point(wall: Wall) -> tuple[float, float]:
    """Point (m) about which the moment on a wall is taken: lower-left corner, or a plane's point nearest the origin."""
    if isinstance(wall, Plane):
        return (wall.at, 0.0) if wall.axis == "x" else (0.0, wall.at)
    return wall.x[0], wall.y[0]


def faces_of(walls: tuple[Wall, ...]) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Faces of walls as (kind, data, names): int64 (faces,), float64 (faces, 6), the wall each face belongs to.

    A plane is (at, side, 0, 0, x_ref, y_ref), a block (xlo, xhi, ylo, yhi, x_ref, y_ref); a box is its four planes
    with its own reference point.
    """
    kinds, rows, names = [], [], []
    for wall in walls:
        reference = reference_point(wall)
        if isinstance(wall, Block):
            kinds.append(BLOCK)
            rows.append((*wall.x, *wall.y, *reference))
            names.append(wall.name)
            continue
        for plane in wall.faces() if isinstance(wall, Box) else (wall,):
            kinds.append(PLANE_X if plane.axis == "x" else PLANE_Y)
            rows.append((plane.at, plane.sign, 0.0, 0.0, *reference))
            names.append(wall.name)
    return np.array(kinds, np.int64), np.array(rows, float).reshape(-1, 6), names
