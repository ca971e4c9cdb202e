# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of a run, packed for the player of a page: about 2.5 bytes a disc and frame.

Positions are whole numbers of a quantum q, 1/128 of the smallest diameter; velocities are whole numbers from -127 to
127. A position is predicted from the one before and the mean of both velocities; what is left is small and is deflated.

The stream holds little-endian arrays, one after the other, of K discs in the order of their ids and N rows (a disc in a
frame). An id that comes back is a new disc.

1. per disc: id less the id before, u32; first frame and number of frames, u16 each; x and y there in q, i32 each; index
   of its radius, u8, where there are several radii
2. per row after the first of its disc, frame by frame: position less prediction, zigzag (0, -1, 1, -2 … are 0, 1, 2, 3
   …), of x the low bytes, the high bytes, then of y. The prediction is
   ``before + floor((u_before + u_now) s + 0.5)`` with ``s = qv dt / q / 2``, in 64 bits
3. per row: velocity u less the one before modulo 256, u8 (in the first row of a disc the velocity itself); then of v
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame, make_frame, ten_indices

PARTS = 128
"""Quanta of position in the smallest diameter: no place is wrong by more than 1/256 of it."""
FASTEST = 127
"""Quanta of velocity in the largest component."""
MOST_FRAMES = 400
MOST_DISCS = 25_000
"""Discs a frame; beyond it a share of the ids is shown."""
MOST_ROWS = 5_000_000
"""Discs times frames: 17 MB of page."""
FARTHEST = 1 << 30
"""Quanta; a disc beyond is shown there."""
LARGEST_RESIDUAL = 1 << 15
"""A disc that is further from its prediction, in quanta, counts as another disc."""
SHADES = 256
"""Radii that are told apart."""


@dataclass(frozen=True)
class Packed:
    """Frames for the player.

    Attributes
    ----------
    header : dict
        ``times`` (s), ``q`` (m), ``qv`` (m/s), ``discs`` and ``rows`` (K and N), ``radii`` (m) and ``share``: of the
        discs, those that are kept.
    text : str
        The stream, deflated, in base64.
    """

    header: dict[str, object]
    text: str


ROW = np.dtype([("id", "i8"), ("x", "i4"), ("y", "i4"), ("u", "f4"), ("v", "f4"), ("radius", "f4")])
"""A disc in a frame: whole quanta of position, velocity in m/s, radius in m."""


class FramePacker:
    """Takes in the frames of a run and keeps, as whole numbers, what the player needs.

    Of more than `MOST_FRAMES` every second is kept, every fourth, and so on. Discs beyond `MOST_DISCS` a frame or
    `MOST_ROWS` in all are thinned: a share of the ids is kept in every frame.

    Parameters
    ----------
    flow : Flow
    """

    def __init__(self, flow: Flow):
        self.flow = flow
        self.q = flow.scene.smallest / PARTS
        self._kept: list[tuple[float, np.ndarray]] = []
        self._radii: dict[str, np.ndarray] = {}
        self._every, self._seen, self._count, self._share = 1, 0, 0, 1.0

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        self._seen += 1
        if (self._seen - 1) % self._every:
            return
        if len(self._kept) == MOST_FRAMES:
            self._kept, self._every = self._kept[::2], 2 * self._every
            self._count = sum(len(rows) for _, rows in self._kept)
            if (self._seen - 1) % self._every:
                return
        self._kept.append((time, self._thinned(self._rows(frame))))
        self._count += len(self._kept[-1][1])
        while (over := max(len(self._kept[-1][1]) / MOST_DISCS, self._count / MOST_ROWS)) > 1:
            self._share *= 0.95 / over
            self._kept = [(time, self._thinned(rows)) for time, rows in self._kept]
            self._count = sum(len(rows) for _, rows in self._kept)

    def _rows(self, frame: Frame) -> np.ndarray:
        """A frame as rows in the order of the ids; of rows with the same id the first."""
        ids, order = np.unique(frame.ids, return_index=True)
        rows = np.empty(len(ids), ROW)
        rows["id"] = ids
        for name, value in (("x", frame.x), ("y", frame.y)):
            rows[name] = np.clip(np.rint(value[order] / self.q), -FARTHEST, FARTHEST)
        rows["u"], rows["v"] = (frame.vx[order], frame.vy[order]) if self.flow.timed else (0, 0)
        rows["radius"] = self.flow.radii(frame)[order]
        return rows

    def _thinned(self, rows: np.ndarray) -> np.ndarray:
        """The share of the rows that is kept, chosen by a hash of the id: a disc is kept in all frames or in none."""
        if self._share == 1:
            return rows
        mixed = rows["id"].astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)  # the golden ratio: well spread
        return rows[mixed < self._share * 2.0**64]

    def sample(self) -> list[Frame]:
        """Ten frames at equal times, of what is kept of them."""
        found = []
        for time, rows in (self._kept[index] for index in ten_indices(len(self._kept))):
            columns = {"x": rows["x"] * self.q, "y": rows["y"] * self.q, "vx": rows["u"], "vy": rows["v"]}
            found.append(make_frame(0, time, self.flow.scene.domain, columns))
        return found

    def result(self) -> Packed | None:
        """The packed frames; None where no frame holds a disc."""
        times = np.array([time for time, _ in self._kept])
        rows = np.concatenate([rows for _, rows in self._kept]) if self._kept else np.empty(0, ROW)
        if not len(rows):
            return None
        frame = np.repeat(np.arange(len(times)), [len(part) for _, part in self._kept])
        fastest = float(max(np.abs(rows["u"]).max(), np.abs(rows["v"]).max()))
        qv = fastest / FASTEST if fastest > 0 else 1.0
        speeds = [np.rint(rows[name] / qv).astype(np.int16) for name in "uv"]
        shares = np.append(0.0, qv * np.diff(times) / self.q / 2)[frame]
        order = np.lexsort((frame, rows["id"]))
        before = _before(rows["id"], frame, order)
        left = [_residual(rows[place], speed, before, shares) for place, speed in zip("xy", speeds, strict=True)]
        before[np.maximum(*np.abs(left)) >= LARGEST_RESIDUAL] = -1
        entry = before < 0
        starts = np.flatnonzero(entry[order])
        counts, discs = np.diff(starts, append=len(rows)), order[starts]
        radii, shade = _shades(rows["radius"][order[starts + counts - 1]])  # an inlet gives a disc its size in flight
        arrays = [
            np.diff(rows["id"][discs], prepend=0).astype("<u4"),
            frame[discs].astype("<u2"),
            counts.astype("<u2"),
            *(rows[place][discs].astype("<i4") for place in "xy"),
            *([shade] if len(radii) > 1 else []),
            *(part for residual in left for part in _bytes(residual[~entry])),
            *((speed - np.where(entry, 0, speed[before])).astype("u1") for speed in speeds),
        ]
        packer = zlib.compressobj(6, zlib.DEFLATED, -15, 9, zlib.Z_FILTERED)
        packed = b"".join([*(packer.compress(array.tobytes()) for array in arrays), packer.flush()])
        header = {"times": times, "q": self.q, "qv": qv, "discs": len(discs), "rows": len(rows), "radii": radii}
        return Packed({**header, "share": self._share}, base64.b64encode(packed).decode())


def _before(ids: np.ndarray, frame: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Row of the same disc in the frame before, shape (rows,); -1 where there is none. `order` is by id and frame."""
    before = np.full(len(ids), -1)
    goes_on = (np.diff(ids[order]) == 0) & (np.diff(frame[order]) == 1)
    before[order[1:][goes_on]] = order[:-1][goes_on]
    return before


def _residual(place: np.ndarray, speed: np.ndarray, before: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Place less its prediction, shape (rows,), quanta; 0 in the first row of a disc."""
    moved = np.floor((speed[before] + speed) * shares + 0.5).astype(np.int64)
    return np.where(before < 0, 0, place.astype(np.int64) - place[before] - moved)


def _bytes(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high bytes of residuals, zigzag."""
    zigzag = np.where(residual < 0, -2 * residual - 1, 2 * residual)
    return (zigzag & 255).astype("u1"), (zigzag >> 8).astype("u1")


def _shades(radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most `SHADES` radii, m, and the index among them of each disc."""
    found, index = np.unique(radii.astype(float), return_inverse=True)
    if len(found) > SHADES:
        found = np.linspace(found[0], found[-1], SHADES)
        index = np.rint((radii - found[0]) / (found[1] - found[0]))
    return found, index.astype("u1")
