# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of a run, packed for the player of a page: 1 to 3 bytes a disc and frame, more the further frames lie apart.

Positions are whole numbers of a quantum q, 1/64 of the smallest diameter; velocities are whole numbers from -63 to 63.
A position is predicted from the one before and the mean of both velocities; what is left is small, and the coder
makes text of it.

The text holds whole numbers, of K discs in the order of their ids and N rows (a disc in a frame). An id that comes back
is a new disc.

1. disc by disc, each less that of the disc before: id; first frame and number of frames; x and y there in q; index of
   its radius; velocity u and v there. Their contexts are 32 times 4 to 11
2. row by row after the first of its disc, frame by frame: velocity less the one before, u and v, then position less
   prediction, x and y. The prediction is ``before + floor((u_before + u_now) s + 0.5)`` with ``s = qv dt / q / 2``, in
   64 bits. Their contexts are 32 times 0 to 3, plus the bit length of the disc's unrest. At the second row of a disc it
   is `UNREST`, later half of what the row before added. A change of velocity adds its double, the rest of a position
   its half, before the next number of the row
3. frame by frame and cell by cell of the map, where there is one: its number less that of the frame before, 0 before
   the first. Their contexts are 32 times 12, plus the bit length of the number before

Maps of a frame for the page: packing and contact pressure on a grid over the domain, as small whole numbers.

The coder makes text of whole numbers: a range coder with adaptive bits, in digits to the base 124.
A digit is one of `LETTERS`: all of ASCII but those that a browser changes or that may end a script. It holds 6.95 bits,
a letter of base64 6.

The coder keeps an interval: its low end, 0 at first, and its range, 124^4 at first. To put some of ``2^bits`` equal
parts is to make them the interval: ``step = floor(range / 2^bits)``, ``low += start step``, ``range = size step``.
While the range is below 124^3, the first digit of the low end is written, and both are multiplied by 124. The four
digits of the low end come last. (G. N. N. Martin, Range encoding, Video and Data Recording Conference, 1979.)

A number has a context, which holds the odds of `SLOTS` adaptive bits. First comes its bit length n in unary, n ones and
a zero: bits 0 to n of the context. Odds are 4096ths, 2048 at first, and ones lie at the low end. After a one they grow
by 1/32 of what they lack to 4096, after a zero they lose 1/32, both rounded down. Then come n bits as they are, in
parts of 8 and a last one of the rest: the bits below the highest, and the sign, 1 for minus.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import find_contacts
from lammps_jump.analysis.flow import Flow
from lammps_jump.core.library import BYTES, INTEGER, INTEGERS, core, function
from lammps_jump.dump.frame import Frame, make_frame, ten_indices
from lammps_jump.physics.jump import GRAVITY

LETTERS = np.array([code for code in range(128) if code not in b"\0\n\r<"], "u1")
BASE = len(LETTERS)
TOP, LEAST = BASE**4, BASE**3
SLOTS = 32
WORST = 1.2
"""Digits of a number at most, over its bits and one: an adaptive bit takes 7.1 bits at odds of 31/4096."""

_digits = function("jump_digits", INTEGER, INTEGERS, INTEGERS, INTEGERS, INTEGERS, BYTES, result=INTEGER)


def encode(*parts: tuple[np.ndarray, np.ndarray]) -> str:
    """Text of whole numbers, one part after the other.

    Parameters
    ----------
    *parts : (ndarray of int, ndarray of int)
        Numbers of at most 31 bits and a sign, and the context of each, from 0, in a shape that goes with theirs.
    """
    pairs = [[array.ravel() for array in np.broadcast_arrays(*part)] for part in parts]
    sides = zip(*((one, context, np.frexp(one)[1]) for one, context in pairs), strict=True)
    values, contexts, lengths = (np.concatenate(side, dtype=np.int64) for side in sides)
    if core() is None:
        digits = _digits_of_each(values.tolist(), contexts.tolist(), lengths.tolist())
    else:
        odds = np.full((contexts.max(initial=0) + 1) * SLOTS, 2048)
        digits = np.zeros(int(WORST * (lengths + 1).sum()) + 5, np.uint8)
        digits = digits[: _digits(len(values), values, contexts, lengths, odds, digits)]
    return LETTERS[digits].tobytes().decode("ascii")


def digits_of(text: str) -> np.ndarray:
    """The digits of a text, shape (letters,).

    Raises
    ------
    ValueError
        A letter that is none of `LETTERS`.
    """
    codes = np.frombuffer(text.encode("utf-8", "replace"), np.uint8)
    digits = np.searchsorted(LETTERS, codes)
    if (LETTERS[np.minimum(digits, BASE - 1)] != codes).any():
        raise ValueError("the text holds a letter that packed numbers do not have")
    return digits


def _digits_of_each(values: list[int], contexts: list[int], lengths: list[int]) -> np.ndarray:
    """Digits of numbers in their contexts, as the core makes them; `lengths` are their bits without the sign."""
    odds, digits, low, span = [2048] * ((max(contexts, default=0) + 1) * SLOTS), [], 0, TOP
    for value, context, length in zip(values, contexts, lengths, strict=True):
        plain = (2 * abs(value) + (value < 0)) ^ (1 << length)
        slot, left, ahead = SLOTS * context, length, length + 1
        while ahead + left:
            if ahead:
                ones, bits = odds[slot], 12
                start, size = (0, ones) if ahead > 1 else (ones, 4096 - ones)
                odds[slot] += (4096 - ones) >> 5 if ahead > 1 else -(ones >> 5)
                ahead, slot = ahead - 1, slot + 1
            else:
                bits = min(left, 8)
                left -= bits
                start, size = (plain >> left) & ((1 << bits) - 1), 1
            step = span >> bits
            low, span = low + start * step, size * step
            while span < LEAST:
                digits.append(low // LEAST)  # below 2 BASE, what is above BASE - 1 is carried at the end
                low, span = low % LEAST * BASE, span * BASE
    for _ in range(4):
        digits.append(low // LEAST)
        low = low % LEAST * BASE
    for last in range(len(digits) - 1, 0, -1):
        digits[last - 1] += digits[last] // BASE
        digits[last] %= BASE
    return np.array(digits, np.uint8)


PARTS = 64
"""Quanta of position in the smallest diameter: no place is wrong by more than 1/128 of it, less than a pixel."""
FASTEST = 63
"""Quanta of velocity in the largest component: as many as there are shades of a colour."""
MOST_FRAMES = 400
MOST_DISCS = 25_000
"""Discs a frame; beyond it a share of the ids is shown."""
MOST_ROWS = 5_000_000
"""Discs times frames: 7 to 15 MB of page."""
FARTHEST = (1 << 30) - 1
"""Quanta; a disc beyond is shown there."""
LARGEST_RESIDUAL = 1 << 15
"""A disc that is further from its prediction, in quanta, counts as another disc."""
MANY = 200_000
"""Discs of a frame from which on the page shows the packing: a disc of those that it holds would represent eight."""
SHADES = 256
"""Radii that are distinguished."""


@dataclass(frozen=True)
class PackedFrames:
    """Frames for the player.

    Attributes
    ----------
    header : dict
        ``times`` (s), ``q`` (m), ``qv`` (m/s), ``discs`` and ``rows`` (K and N), ``radii`` (m), ``share``: of the
        discs, those that are kept, and ``map``: name, unit and grid of the map, or None.
    text : str
        Of `encode`.
    """

    header: dict[str, Any]
    text: str


UNREST = 8
"""Unrest of a disc that came in one frame ago."""
OF_A_KIND = 32
"""Contexts of a kind of numbers."""

ROW = np.dtype([("id", "i8"), ("x", "i4"), ("y", "i4"), ("u", "f4"), ("v", "f4"), ("radius", "f4")])
"""A disc in a frame: whole quanta of position, velocity in m/s, radius in m."""


class FramePacker:
    """Takes in the frames of a run and keeps, as whole numbers, what the player needs.

    Of more than `MOST_FRAMES` every second is kept, every fourth, and so on. Discs beyond `MOST_DISCS` a frame or
    `MOST_ROWS` in all are thinned: a share of the ids is kept in every frame.

    Parameters
    ----------
    flow : Flow
    every : int
        Of the frames that are taken in, the first and every n-th after it are kept.
    maps : bool
        Also make the map of each frame.

    Attributes
    ----------
    thinned : int
        How often what was kept before has become less.
    """

    sees = "all"

    def __init__(self, flow: Flow, every: int = 1, *, maps: bool = True):
        self.flow, self.maps, self.thinned = flow, maps, 0
        self.q = flow.scene.smallest / PARTS
        self._kept: list[tuple[float, np.ndarray]] = []
        self._maps: dict[float, list[np.ndarray]] = {}
        self._every, self._seen, self._most, self._share = every, 0, 0, 1.0

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        self._seen += 1
        if (self._seen - 1) % self._every == 0 and len(self._kept) == MOST_FRAMES:
            self._kept, self._every, self.thinned = self._kept[::2], 2 * self._every, self.thinned + 1
        if (self._seen - 1) % self._every:
            return
        self._kept.append((time, self._thinned(self._rows(frame))))
        self._most = max(self._most, frame.n)
        contacts = self.flow.knows_contacts and self._most < MANY
        kinds = (packing, pressure)[: 1 + contacts] if self.maps else ()
        self._maps[time] = [made(frame, self.flow) for made in kinds]
        while (over := max(len(self._kept[-1][1]) / MOST_DISCS, sum(len(r) for _, r in self._kept) / MOST_ROWS)) > 1:
            self._share, self.thinned = self._share * 0.95 / over, self.thinned + 1
            self._kept = [(time, self._thinned(rows)) for time, rows in self._kept]

    def _rows(self, frame: Frame) -> np.ndarray:
        """A frame as rows in the order of the ids; of rows with the same id the first."""
        ids, order = np.unique(frame.ids, return_index=True)
        rows = np.empty(len(ids), ROW)
        rows["id"] = ids
        for name, value in (("x", frame.x), ("y", frame.y)):
            rows[name] = np.clip(np.rint(value[order] / self.q), -FARTHEST, FARTHEST)
        rows["u"], rows["v"] = (np.nan_to_num(speed[order]) for speed in (frame.vx, frame.vy))
        rows["radius"] = self.flow.radii(frame)[order]
        return rows

    def _thinned(self, rows: np.ndarray) -> np.ndarray:
        """The share of the rows that is kept, chosen by a hash of the id: a disc is kept in all frames or in none."""
        if self._share == 1:
            return rows
        mixed = rows["id"].astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)  # the golden ratio: well spread
        return rows[mixed < self._share * 2.0**64]

    @property
    def kept(self) -> Sequence[tuple[float, np.ndarray]]:
        """Time (s) and rows (`ROW`, in the order of the ids) of each frame that is kept."""
        return self._kept

    @property
    def share(self) -> float:
        """Of the discs, those that are kept."""
        return self._share

    @property
    def times(self) -> list[float]:
        """Times of the frames that are kept, s."""
        return [time for time, _ in self._kept]

    def sample(self) -> list[Frame]:
        """Ten frames at equal times, of what is kept of them."""
        frames = []
        for time, rows in (self._kept[index] for index in ten_indices(len(self._kept))):
            columns = {"x": rows["x"] * self.q, "y": rows["y"] * self.q, "vx": rows["u"], "vy": rows["v"]}
            frames.append(make_frame(0, time, self.flow.scene.domain, columns))
        return frames

    def result(self) -> PackedFrames | None:
        """The packed frames; None where no frame holds a disc."""
        total = sum(len(rows) for _, rows in self._kept)
        if not total:
            return None
        times = np.array(self.times)
        fastest = max(float(np.abs(rows[name]).max(initial=0.0)) for _, rows in self._kept for name in "uv")
        qv = fastest / FASTEST if fastest > 0 else 1.0
        shares = np.append(0.0, qv * np.diff(times) / self.q / 2)
        discs, steps, before = _Entries(total), [], _Instant.empty()
        for frame, (_, rows) in enumerate(self._kept):  # one by one: all at once would not stay in the caches
            before = _step(rows, qv, shares[frame], before)
            discs.take(frame, rows, before)
            steps.append(before.told)
        table, radii = discs.table()
        many = self._most >= MANY
        maps = [self._maps[time][slice(1) if many else slice(1, 2)] for time in times.tolist()]
        levels = np.array(maps, int).reshape(len(times), -1)
        turned = np.diff(levels, axis=0, prepend=0)
        text = encode(
            (np.diff(table, axis=0, prepend=0), OF_A_KIND * np.arange(4, 12)),
            *steps,
            (turned, OF_A_KIND * 12 + np.frexp(levels - turned)[1]),
        )
        header = {"times": times, "q": self.q, "qv": qv, "discs": len(table), "rows": total, "radii": radii}
        about = about_map(self.flow, many) if levels.size else None
        return PackedFrames({**header, "share": self._share, "map": about}, text)


class _Instant(NamedTuple):
    """A frame as the next one needs it, in the order of the ids, and what the text tells of it.

    Attributes
    ----------
    ids, places, speeds, unrest : ndarray
        Of each disc; places and speeds, shape (2, discs), in quanta.
    entry : ndarray of bool
        The disc was not in the frame before.
    at : ndarray
        Where the disc is in the frame before.
    told : (ndarray, ndarray)
        Numbers of the rows that are no entries, and their contexts.
    """

    ids: np.ndarray
    places: np.ndarray
    speeds: np.ndarray
    unrest: np.ndarray
    entry: np.ndarray
    at: np.ndarray
    told: tuple[np.ndarray, np.ndarray]

    @classmethod
    def empty(cls) -> _Instant:
        """Before the first frame."""
        none, pairs = np.empty(0, np.int64), np.empty((2, 0), np.int64)
        return cls(none, pairs, pairs, none, none > 0, none, (none, none))


def _step(rows: np.ndarray, qv: float, share: float, before: _Instant) -> _Instant:
    """The next frame of rows (`ROW`); `share` is the s of the prediction, see the text at the top."""
    places = np.array([rows["x"], rows["y"]], np.int64)
    speeds = np.array([np.rint(rows[name] / qv) for name in "uv"]).astype(np.int64)
    at = np.minimum(np.searchsorted(before.ids, rows["id"]), max(len(before.ids) - 1, 0))
    entry = before.ids[at] != rows["id"] if len(before.ids) else np.ones(len(rows), bool)
    changes = np.zeros((4, len(rows)), np.int64)
    unrest = np.full(len(rows), UNREST)
    if len(before.ids):
        were = before.speeds[:, at]
        moved = np.floor((were + speeds) * share + 0.5).astype(np.int64)
        changes = np.concatenate([speeds - were, places - before.places[:, at] - moved])
        entry |= np.abs(changes[2:]).max(axis=0) >= LARGEST_RESIDUAL
        unrest = before.unrest[at]
    sizes = np.concatenate([np.abs(changes[:2]) * 2, np.abs(changes[2:]) // 2])
    felt = np.cumsum([unrest, *sizes[:3]], axis=0)
    contexts = np.frexp(felt)[1] + OF_A_KIND * np.arange(4)[:, None]
    left = np.where(entry, UNREST, sizes.sum(axis=0) // 2)
    entry_changes = changes.T[~entry].astype(np.int32), contexts.T[~entry].astype(np.int16)
    return _Instant(rows["id"], places, speeds, left, entry, at, entry_changes)


class _Entries:
    """Entries of the text for each disc where it comes in; `rows` is the number of rows of all frames."""

    def __init__(self, rows: int):
        self._counts, self._radii, self._known = np.zeros(rows, np.int64), np.empty(rows, "f4"), 0
        self._numbers = np.empty(0, np.int64)
        self._entries: list[np.ndarray] = []

    def take(self, frame: int, rows: np.ndarray, now: _Instant) -> None:
        """Take in a frame and what came of it."""
        new, entered = int(now.entry.sum()), rows[now.entry]
        numbers = self._numbers[now.at] if len(self._numbers) else np.empty(len(rows), np.int64)
        numbers[now.entry] = self._known + np.arange(new)
        self._known, self._numbers = self._known + new, numbers
        self._counts[numbers] += 1
        self._radii[numbers] = rows["radius"]  # the last one: an inlet gives a disc its size in flight
        columns = (entered["id"], np.full(new, frame), entered["x"], entered["y"], *now.speeds[:, now.entry])
        self._entries.append(np.column_stack(columns))

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the discs in the order of their ids and frames; and their radii, m."""
        entries = np.concatenate(self._entries)
        order = np.lexsort((entries[:, 1], entries[:, 0]))
        radii, shade = _shades(self._radii[order])
        ids, first, x, y, u, v = entries[order].T
        return np.column_stack([ids, first, self._counts[order], x, y, shade, u, v]), radii


def _shades(radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most `SHADES` radii, m, and the index among them of each disc."""
    shades, index = np.unique(radii.astype(float), return_inverse=True)
    if len(shades) > SHADES:
        shades = np.linspace(shades[0], shades[-1], SHADES)
        index = np.rint((radii - shades[0]) / (shades[1] - shades[0])).astype(int)
    return shades, index


CELL = 4
"""Diameters of a cell: a mean over some 14 discs, in which a single collision has little effect."""
FINEST = 200
"""Cells along a side at most: five pixels of a page each."""
PACKING_STEP = 1 / 32
"""Of the share of area that discs cover."""
PRESSURE_STEP = 1 / 8
"""Of the pressure under one diameter of the discs' material."""


def packing(frame: Frame, flow: Flow) -> np.ndarray:
    """Share of area that discs cover over `PACKING_STEP`, shape (cells,), row by row from below."""
    return _numbers(flow, frame.x, frame.y, np.pi * flow.radii(frame) ** 2 / PACKING_STEP)


def pressure(frame: Frame, flow: Flow) -> np.ndarray:
    """Root of the contact pressure over its unit, shape (cells,): low pressures are distinguished.

    The pressure is the mean of both normal stresses: over the contacts of a cell the sum of force times length between
    the centres, or from centre to wall, over twice the area (Love, 1927; Weber, 1966).
    """
    contacts = find_contacts(frame, flow)
    moment = contacts.force * np.hypot(*(contacts.end - contacts.start).T) / 2
    x, y = (contacts.start + contacts.end).T / 2
    return _numbers(flow, x, y, moment / pressure_unit(flow), 0.5)


def about_map(flow: Flow, many: bool) -> dict[str, Any]:
    """Name and grid of the packing, of many discs, or the pressure; a value is unit times number to the power."""
    counts, sides = grid(flow)
    name, unit, power = ("packing", PACKING_STEP, 1) if many else ("pressure", pressure_unit(flow), 2)
    low = [low for low, _ in flow.scene.domain]
    return {"name": name, "unit": unit, "power": power, "low": low, "counts": counts, "sides": sides}


def pressure_unit(flow: Flow) -> float:
    """Pressure of the number 1, Pa."""
    return PRESSURE_STEP * flow.scene.density * (flow.g or GRAVITY) * flow.scene.diameter


def grid(flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of cells; their width and height, m."""
    sides = np.ptp(flow.scene.domain, axis=1)
    counts = np.clip(np.ceil(sides / (CELL * flow.scene.diameter)), 1, FINEST).astype(int)
    return counts, sides / counts


def _numbers(flow: Flow, x: np.ndarray, y: np.ndarray, values: np.ndarray, power: float = 1.0) -> np.ndarray:
    """Power of the sum of values at places (m) over the area of their cells, as whole numbers up to 255."""
    counts, sides = grid(flow)
    low = np.array(flow.scene.domain)[:, 0]
    column, row = np.floor((np.column_stack([x, y]) - low) / sides).T
    inside = (column >= 0) & (column < counts[0]) & (row >= 0) & (row < counts[1])
    cell = (row * counts[0] + column)[inside].astype(int)
    sums = np.bincount(cell, values[inside], counts.prod()) / sides.prod()
    return np.rint(np.clip(sums, 0, None) ** power).clip(max=255).astype("u1")
