# SPDX-License-Identifier: GPL-2.0-or-later
"""The thesis' own contact search, for its plot of CPU time against cell size (section 6.4, recommendation 2)."""

from __future__ import annotations

from math import ceil
from time import perf_counter

import numpy as np

from lammps_jump.errors import CaseError
from lammps_jump.scene.scene import Scene

from .arrays import Grid, Loops, Pairs
from .simulation import NativeSimulation


class CellSimulation(NativeSimulation):
    """A scene stepped with cell lists made anew every step, and every disc tried against every wall.

    Same forces as `NativeSimulation`; only the order in which they are summed differs.

    Parameters
    ----------
    scene : Scene
    cell_size : float, optional
        Width of the square cells, m; 2 d by default, as the thesis has it.
    ledger : bool
    loops : Loops, optional
        As of `NativeSimulation`.
    """

    def __init__(
        self, scene: Scene, *, cell_size: float | None = None, ledger: bool = True, loops: Loops | None = None
    ):
        self.cell_size = 2.0 * scene.diameter if cell_size is None else float(cell_size)
        if not (0.1 * scene.diameter <= self.cell_size < float("inf")):
            raise CaseError(
                f"cell size {self.cell_size:zg} m: use at least a tenth of the disc diameter "
                f"({0.1 * scene.diameter:zg} m); the thesis used two diameters"
            )
        (x_low, x_high), (y_low, y_high) = scene.domain
        inverse = 1.0 / self.cell_size
        columns = int((x_high - x_low) * inverse) + 1
        rows = int((y_high - y_low) * inverse) + 1
        first = np.zeros(columns * rows + 2, np.int64)
        self._grid = Grid(x_low, y_low, inverse, columns, rows, first, np.zeros(1, np.int64))
        self._slots = (ceil(scene.largest * inverse) + 1) ** 2
        self._owner = np.empty(0, np.int32)
        self._neighbours = np.empty(256, np.int32)
        super().__init__(scene, ledger=ledger, loops=loops)
        motion = self._constants.motion._replace(reach2=float("inf"))
        self._constants = self._constants._replace(motion=motion)

    def listed_pairs(self) -> Pairs:
        """The list that stands."""
        assert self._grid is not None  # `__init__` has made it
        return Pairs(int(self._grid.used[0]), self._owner, self._first, self._neighbours)

    def _rebuild(self) -> None:
        started = perf_counter()
        d = self.discs
        self._require_inside()
        if self._owner.size < self._slots * d.room:
            self._owner = np.empty(self._slots * d.room, np.int32)
            self._first = np.zeros(self._slots * d.room + 1, np.int64)
        while self.loops.cell_pairs(self._state()) < 0:
            self._neighbours = np.empty(2 * self._neighbours.size, np.int32)
        self._list_walls()
        self.rebuilds += 1
        self.rebuild_seconds += perf_counter() - started

    def _drift(self, stop: int) -> None:
        super()._drift(stop)
        if self._between.next_after(stop - 1) == stop:
            self._rebuild()

    def _list_newcomers(self) -> None:
        self._rebuild()

    def _list_walls(self) -> None:
        self.walls.list_all(self.discs.n)
