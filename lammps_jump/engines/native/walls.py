# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as the loops read them: flat faces, the cells that find them, and the list of discs near each wall."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.scene.chains import Faces, lay
from lammps_jump.scene.faces import MOST
from lammps_jump.scene.near import Grid, grid_of, list_near
from lammps_jump.scene.walls import Wall

from .loops import Near


class Walls:
    """Walls that are there now, and the discs near them.

    Parameters
    ----------
    walls : tuple of Wall
    cell : float
        Side of the cells that find faces, m.
    reach : float
        Distance from a face up to which discs are listed, m.

    Attributes
    ----------
    names : list of str
    faces : Faces
    near : Near
    sums : ndarray, shape (walls, 3)
        Force on each wall (N per m of width) and moment (N), summed over steps.
    """

    def __init__(self, walls: tuple[Wall, ...], cell: float, reach: float):
        self.names = [wall.name for wall in walls]
        self.faces: Faces = lay([(wall.chains(), wall.deep) for wall in walls])
        self._grid: Grid = grid_of(self.faces, cell, reach)
        self.sums = np.zeros((len(walls), 3))
        about = np.array([wall.moment_point for wall in walls]).reshape(-1, 2)
        rows, last = np.zeros(len(walls) + 1, np.int64), np.zeros(1, np.int64)
        none, found = np.empty(0, np.int64), np.empty((MOST, 4))
        self.near = Near(
            about, rows, np.empty(0, np.int32), np.empty(0, np.int8), last, none, found, np.empty(MOST, np.int64)
        )

    def list_discs(self, n: int, x: np.ndarray, y: np.ndarray) -> None:
        """List the discs near each wall; `x` and `y` (m) are of the first n discs."""
        row = count = 0
        for wall in range(len(self.names)):
            while True:
                found = list_near(
                    n, x, y, wall, self.faces.codes, self.faces.shape, self.faces.deep, self._grid, self.near.discs,
                    self.near.plain, self.near.last, self.near.faces, row, count,
                )  # fmt: skip
                if found[1] >= 0:
                    break
                self.make_room(
                    2 * len(self.near.discs) + 256, 2 * len(self.near.faces) + 4 * len(self._grid.faces) + 256
                )
            row, count = found
            self.near.rows[wall + 1] = row

    def list_all(self, n: int) -> None:
        """List every disc at every wall with all its faces."""
        first = self.faces.first
        parts = [np.tile(np.arange(*ends), n) for ends in pairwise(first)]
        counts = np.repeat(np.diff(first), n)
        last = np.concatenate([[0], np.cumsum(counts)])
        discs = np.tile(np.arange(n, dtype=np.int32), len(self.names))
        self.put(
            n * np.arange(len(self.names) + 1), discs, 0 * discs, last, np.concatenate([*parts, np.empty(0, np.int64)])
        )

    def make_room(self, rows: int, faces: int) -> None:
        """Longer lists for at least so many rows and faces."""
        near = self.near
        self.near = near._replace(
            discs=np.pad(near.discs, (0, max(0, rows - len(near.discs)))),
            plain=np.pad(near.plain, (0, max(0, rows - len(near.plain)))),
            last=np.pad(near.last, (0, max(0, rows + 1 - len(near.last)))),
            faces=np.pad(near.faces, (0, max(0, faces - len(near.faces)))),
        )

    @property
    def listed(self) -> dict[str, np.ndarray]:
        """The lists as they stand, without their room."""
        near, rows = self.near, self.near.rows[-1]
        last = near.last[: rows + 1]
        listed = {"rows": near.rows, "discs": near.discs[:rows], "plain": near.plain[:rows]}
        return {**listed, "last": last, "faces": near.faces[: last[-1]]}

    def put(self, rows: ArrayLike, discs: ArrayLike, plain: ArrayLike, last: ArrayLike, faces: ArrayLike) -> None:
        """Take lists such as `listed` gives."""
        self.near = self.near._replace(
            rows=np.array(rows, np.int64),
            discs=np.array(discs, np.int32),
            plain=np.array(plain, np.int8),
            last=np.array(last, np.int64),
            faces=np.array(faces, np.int64),
        )
