# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of each frame with their forces, as the engine has them: ``contacts.bin`` next to the dump.

With a memory in the contact law, friction cannot be computed from a frame. A frame of the file is a mark, step and
number of contacts (`HEAD`), then a row of `ROW` for each contact: 28 bytes.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from lammps_jump.dump.walls import SideWriter
from lammps_jump.errors import DumpError
from lammps_jump.files import open_to_read
from lammps_jump.scene.scene import Scene

ROW = np.dtype([(name, "<i4") for name in ("i", "j")] + [(name, "<f4") for name in ("x", "y", "fx", "fy", "power")])
"""Id of the disc that the force acts on; that of the other, or -1 - w for wall w of the scene; the point (m), the force
(N/m), and the power that dashpot and friction take (W/m; NaN of the compiled kernel), each in seven digits."""
HEAD = struct.Struct("<4sqq")
MARK = b"LJC1"


class ContactWriter(SideWriter):
    """Writes the contacts of frames."""

    def write(self, step: int, who: np.ndarray, contact_rows: np.ndarray) -> None:
        """Write the contacts of a frame.

        Parameters
        ----------
        step : int
        who : ndarray of int, shape (n, 2)
            Ids, the columns i and j of `ROW`.
        contact_rows : ndarray, shape (n, 5)
            Its other columns.
        """
        rows = np.empty(len(who), ROW)
        for name, values in zip(ROW.names or (), (*who.T, *contact_rows.T), strict=True):
            rows[name] = values
        self.put(HEAD.pack(MARK, step, len(rows)) + rows.tobytes())


class ContactFile:
    """Reader of a file of contacts, which may still grow.

    Parameters
    ----------
    path : Path
        A file that is not there holds no frame.
    scene : Scene, optional
        That of the run: steps, discs and walls beyond it are refused.
    """

    def __init__(self, path: Path, scene: Scene | None = None):
        self.path, self.scene = path, scene
        self._places: dict[int, tuple[int, int]] = {}
        self._end, self._last = 0, -1

    def contacts(self, step: int) -> np.ndarray | None:
        """The contacts at a step, of `ROW`, shape (n,); None where the file does not hold the step whole.

        Raises
        ------
        DumpError
            The file is damaged, or holds what no run writes.
        """
        if step not in self._places:
            self._look_on()
        if step not in self._places:
            return None
        place, count = self._places[step]
        try:
            with open_to_read(self.path) as file:
                file.seek(place)
                rows = np.frombuffer(file.read(count * ROW.itemsize), ROW)
        except OSError as error:
            raise DumpError(f"{self.path}: cannot be read ({error.strerror or error})") from None
        wrong = self._wrong(rows, count)
        if wrong:
            raise DumpError(f"{self.path}: byte {place}: step {step}: {wrong}; the file is damaged")
        return rows

    def _wrong(self, rows: np.ndarray, count: int) -> str:
        """Fault of the rows of a frame, which no run writes; empty where all is well."""
        if len(rows) < count:
            return "the frame is cut off"
        walls = len(self.scene.walls) if self.scene is not None else np.iinfo(np.int32).max
        if (rows["i"] < 1).any() or (rows["j"] == 0).any() or (rows["j"] < -walls).any():
            return f"ids i of discs begin at 1, ids j too, or are -1 to {-walls} for a wall"
        if not all(np.isfinite(rows[name]).all() for name in ("x", "y", "fx", "fy")):
            return "x, y, fx and fy are finite numbers"
        return ""

    def _look_on(self) -> None:
        """Find the frames that were written since the last look."""
        if not self.path.is_file():
            return
        size = self.path.stat().st_size
        with open_to_read(self.path) as file:
            while self._end + HEAD.size <= size:
                file.seek(self._end)
                mark, step, count = HEAD.unpack(file.read(HEAD.size))
                place = self._end + HEAD.size
                most = self.scene.steps if self.scene is not None else step
                if mark != MARK or not self._last < step <= most or count < 0:
                    raise DumpError(
                        f"{self.path}: byte {self._end}: no frame of contacts, or one whose step does not follow "
                        f"step {self._last}; the file is damaged"
                    )
                if place + count * ROW.itemsize > size:
                    return
                self._places[step], self._last = (place, count), step
                if self.scene is not None and len(self._places) > self.scene.steps // self.scene.output_steps + 2:
                    raise DumpError(f"{self.path}: holds more frames than the run; the file is damaged")
                self._end = place + count * ROW.itemsize

    def forces(self, step: int, one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force (fx, fy) on discs in contacts that are known otherwise, N/m; NaN where the file does not have them.

        Parameters
        ----------
        step : int
        one, other : ndarray of int, shape (n,)
            Ids as of `ROW`, pairs in either order. Several contacts of a disc with a wall are taken in their order.

        Returns
        -------
        fx, fy : ndarray, shape (n,)
            On the discs `one`.
        """
        rows = self.contacts(step)
        if rows is None or not len(rows):
            return np.full(len(one), np.nan), np.full(len(one), np.nan)
        mine, wanted_keys = _keys(rows["i"], rows["j"]), _keys(one, other)
        _, number = np.unique(np.concatenate([mine, wanted_keys]), axis=0, return_inverse=True)
        number = number.ravel()
        place = np.full(int(number.max()) + 1, -1)
        place[number[: len(mine)]] = np.arange(len(mine))
        row_numbers = place[number[len(mine) :]]
        # the force on the other disc of a pair is the opposite
        sign = np.where((rows["i"][row_numbers] == one), 1.0, -1.0)
        sign[row_numbers < 0] = np.nan
        return sign * rows["fx"][row_numbers], sign * rows["fy"][row_numbers]


def _keys(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Keys of contacts, shape (n, 3): smaller and larger id, and which of those with the same wall."""
    pairs = np.sort(np.column_stack([one, other]).astype(np.int64), axis=1)
    order = np.lexsort(pairs.T)
    first = np.append(True, np.any(np.diff(pairs[order], axis=0) != 0, axis=1))
    begin = np.maximum.accumulate(np.where(first, np.arange(len(pairs)), 0))
    rank = np.empty(len(pairs), np.int64)
    rank[order] = np.arange(len(pairs)) - begin
    rank[pairs[:, 0] > 0] = 0  # two discs touch once; an image asks again
    return np.column_stack([pairs, rank])
