# SPDX-License-Identifier: GPL-2.0-or-later
"""Beds of discs: rough ones of fixed discs in rows, and those grown to a chosen packing, kept by key in the cache."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from math import floor, hypot, pi, sqrt
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.functional_validators import model_validator

from lammps_jump.compiling.cache import usual_folder
from lammps_jump.files import delete, read_arrays, whole, write_arrays
from lammps_jump.identity import short_hash
from lammps_jump.scene import Interval, Sizes, Wall
from lammps_jump.scene.scene import Fixed
from lammps_jump.scene.walls import Line, WallName
from lammps_jump.units import Length, Plain, Point

from .base import Strict
from .discs import PackedBed

MOST_FIXED = 1_000_000
"""Discs of rough beds."""
SAME_PLACE = 1e-6
"""Distance in diameters at which two discs of a bed count as one: those on the seam of a periodic channel."""


class RoughBed(Strict):
    """A row of fixed discs from one point to another; other discs collide with them as with discs."""

    model_config = ConfigDict(serialize_by_alias=True)
    kind: Literal["rough"]
    name: WallName
    begin: Point = Field(alias="from", description="[x, y]: centre of the first fixed disc")
    end: Point = Field(alias="to", description="[x, y]: the row ends here or before")
    diameter: Length = Field(title="disc diameter", description="of the fixed discs")
    spacing: Plain = Field(default=1.0, ge=1, le=10, description="from centre to centre, in these diameters")
    parts: ClassVar[tuple[str, ...]] = ()
    hollow: ClassVar[bool] = False

    @model_validator(mode="after")
    def _not_too_many(self) -> RoughBed:
        if self.begin == self.end:
            raise ValueError("from and to are one point; allowed are two")
        if self.count > MOST_FIXED:
            raise ValueError(
                f"the row holds {self.count} discs; allowed are {MOST_FIXED}: raise spacing or diameter, or shorten it"
            )
        return self

    @property
    def length(self) -> float:
        """From the first point to the last, m."""
        return hypot(self.end[0] - self.begin[0], self.end[1] - self.begin[1])

    @property
    def count(self) -> int:
        """Discs of the row."""
        return int(self.length / (self.spacing * self.diameter) + 1e-9) + 1

    def places(self, seam: Interval | None) -> np.ndarray:
        """Centres of its discs, m, shape (n, 2); in a periodic channel with this seam each place once."""
        (x, y), (right, top) = self.begin, self.end
        step = self.spacing * self.diameter / self.length * np.arange(self.count)[:, None]
        centres = np.array([[x, y]]) + step * [right - x, top - y]
        if seam is None:
            return centres
        low, period = seam[0], seam[1] - seam[0]
        centres[:, 0] = low + (centres[:, 0] - low) % period
        cells = np.round((centres - [low, 0.0]) / (SAME_PLACE * self.diameter))
        cells[:, 0] %= round(period / (SAME_PLACE * self.diameter))
        first = np.unique(cells, axis=0, return_index=True)[1]
        return centres[np.sort(first)]

    @property
    def surface(self) -> Line:
        """The line over the tops of its discs."""
        (x, y), (right, top) = self.begin, self.end
        up = 0.5 * self.diameter / self.length
        along, across = up * (y - top), up * (right - x)
        return Line(self.name, ((x + along, y + across), (right + along, top + across)))


@dataclass(frozen=True)
class Beds:
    """The fixed discs of a case: their places, shape (n, 2), m, ids, sizes with theirs, and the beds as lines."""

    positions: np.ndarray
    fixed: Fixed | None
    sizes: Sizes | None
    surfaces: tuple[Wall, ...]


def beds_of(
    rows: tuple[RoughBed, ...], seam: Interval | None, first: int, sizes: Sizes | None, diameter: float
) -> Beds:
    """Fixed discs of rough beds, with ids from `first` on.

    Parameters
    ----------
    rows : tuple of RoughBed
    seam : (float, float), optional
        Where a periodic channel begins and ends, m.
    first : int
    sizes : Sizes, optional
        Of the other discs; None: all have this `diameter` (m).
    diameter : float
    """
    places, own = [np.empty((0, 2))], []
    begin = first
    for row in rows:
        places.append(row.places(seam))
        own.append((begin, begin + len(places[-1]) - 1, row.diameter))
        begin += len(places[-1])
    if not rows:
        return Beds(places[0], None, sizes, ())
    known = sizes or Sizes((1.0,), (diameter,), (diameter,))
    surfaces = tuple(row.surface for row in rows)
    return Beds(np.concatenate(places), Fixed(first, begin - 1), replace(known, own=tuple(own)), surfaces)


KEPT, MOST_KEPT = "beds", 200
"""Folder of the cache, and beds that stay there: those used last."""
METHOD = 1
"""Part of the key; another number where the growth has changed."""
TOUCHING = 1e-3
"""Overlap over the smaller diameter of the two that is left: a fiftieth of what the fastest impact takes."""
MOST_STEPS, LOOK = 20_000, 500
"""Steps of the relaxation, and those between two looks at whether it still goes on."""
STUCK = 0.97
"""Ratio of the energies of two looks from which on the discs are jammed."""
MOST_DISCS = 20_000
"""Discs of a bed, times the square of the largest diameter over the root mean square: pairs that are near, minutes."""
SKIN = 0.3
"""Distance in mean diameters up to which pairs are listed beyond touching."""


class GrownPacking(NamedTuple):
    """Centres from the corner of the rectangle, m, shape (n, 2), and the largest overlap over a diameter."""

    positions: np.ndarray
    overlap: float


def bed_diameters(bed: PackedBed, diameter: float, sizes: Sizes | None, first: int) -> np.ndarray:
    """Diameters of the discs of a bed from the id `first` on, m, shape (n,): as many as come nearest to the packing."""
    wanted = bed.packing * bed.area / (pi / 4)
    if sizes is None:
        return np.full(round(wanted / diameter**2), diameter)
    most = int(2 * wanted / sizes.mean_square) + 10
    diameters = sizes.diameters(np.arange(first, first + most))
    below = np.concatenate([[0.0], np.cumsum(diameters**2)])
    return diameters[: int(np.argmin(np.abs(below - wanted)))]


def bed_positions(bed: PackedBed, diameters: np.ndarray, seed: int) -> np.ndarray:
    """Centres of the discs of a bed, m, shape (n, 2), from the cache, or grown and put there.

    Raises
    ------
    ValueError
        There is less than half a disc, so many are not grown, or they do not find room (the caller adds the place).
    """
    if not len(diameters):
        raise ValueError(
            f"packing {bed.packing:zg} of {bed.area:zg} m^2 is less than half a disc; make the bed larger, or take "
            "smaller discs"
        )
    size = bed.x[1] - bed.x[0], bed.y[1] - bed.y[0]
    wide = (diameters.max() / sqrt(np.mean(diameters**2))) ** 2
    if len(diameters) * wide > MOST_DISCS:
        raise ValueError(
            f"packing {bed.packing:zg} needs {len(diameters)} discs; at most {int(MOST_DISCS / wide)} of these sizes "
            "are grown at once: make the bed smaller and put several side by side, or take larger discs"
        )
    if min(size) < diameters.max():
        raise ValueError(
            f"a disc of {diameters.max():z.4g} m does not fit into a bed of {size[0]:z.4g} by {size[1]:z.4g} m; make "
            "the bed larger, or take smaller discs"
        )
    grown = _kept(SoftBed(size, tuple(diameters.tolist()), seed))
    if grown.overlap > TOUCHING:
        # rounded down: to the nearest, it could be the packing that is refused
        room = floor(100 * bed.packing * (1.0 - grown.overlap) ** 2) / 100
        raise ValueError(
            f"packing {bed.packing:zg} is not reached: {len(diameters)} discs are jammed in {size[0]:z.4g} by "
            f"{size[1]:z.4g} m with overlaps up to {100 * grown.overlap:z.2g} % of a diameter. Discs at random reach "
            f"0.82 to 0.84, less beside walls; {max(room, 0.1):z.2f} is sure to go here. A crystal of equal discs, "
            "0.9069, is `kind: column, packing: hexagonal`"
        )
    return grown.positions + np.array([bed.x[0], bed.y[0]])


@dataclass(frozen=True)
class SoftBed:
    """Discs of a bed, as far as their places depend on them: width and height (m), diameters (m), seed."""

    size: tuple[float, float]
    diameters: tuple[float, ...]
    seed: int

    @property
    def key(self) -> str:
        """Hash of all of it."""
        digest = hashlib.sha256(np.array([*self.size, *self.diameters]).tobytes()).hexdigest()
        return short_hash({"method": METHOD, "numbers": digest, "seed": self.seed})


@lru_cache(maxsize=8)  # of a case that changes most beds stay
def _kept(bed: SoftBed) -> GrownPacking:
    """A bed of the cache; grown and put there where it is not, or damaged. Without a cache it is grown each time."""
    path = usual_folder() / KEPT / f"{bed.key}.npz"
    with suppress(OSError, ValueError, KeyError):
        positions = _checked(read_arrays(path)["positions"], bed)
        path.touch()
        return positions
    grown = relaxed(bed)
    if grown.overlap <= TOUCHING:
        with suppress(OSError):
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            with whole(path) as new:
                write_arrays(new, positions=grown.positions)
            _forget_old(path.parent)
    return grown


def _forget_old(folder: Path) -> None:
    dated = sorted((one.stat().st_mtime, one) for one in folder.glob("*.npz"))
    delete(*(one for _, one in dated[: max(0, len(dated) - MOST_KEPT)]))


def _checked(positions: np.ndarray, bed: SoftBed) -> GrownPacking:
    """A kept bed, if it is one of these discs: as many, within the rectangle, without overlaps.

    Raises
    ------
    ValueError
        It is not.
    """
    soft = _Soft(bed)
    if positions.shape != soft.start.shape or positions.dtype != float or not np.isfinite(positions).all():
        raise ValueError("not a bed of these discs")
    overlap = soft.look(positions / soft.unit).overlap
    if overlap > TOUCHING:
        raise ValueError("its discs overlap")
    return _grown(positions, overlap)


def _grown(positions: np.ndarray, overlap: float) -> GrownPacking:
    positions.setflags(write=False)
    return GrownPacking(positions, overlap)


class _SoftForces(NamedTuple):
    """Forces of soft discs, shape (n, 2), their energy, and the largest overlap over the smaller diameter."""

    forces: np.ndarray
    energy: float
    overlap: float


class _Soft:
    """Soft discs between four walls; lengths over the mean diameter, stiffness and mass 1."""

    def __init__(self, bed: SoftBed) -> None:
        diameters = np.array(bed.diameters)
        self.unit = float(diameters.mean())
        self.radii = 0.5 * diameters / self.unit
        self.low = np.column_stack([self.radii, self.radii])
        self.high = np.array(bed.size) / self.unit - self.low
        random = np.random.default_rng(bed.seed)
        self.start = self.low + random.uniform(size=self.low.shape) * (self.high - self.low)
        self.listed = np.full_like(self.start, np.inf)
        self.pairs = np.empty((0, 2), np.intp)

    def _list(self, x: np.ndarray) -> None:
        from scipy.spatial import cKDTree  # 0.1 s, which other cases need not wait for

        near = cKDTree(x).query_pairs(2 * self.radii.max() + SKIN, output_type="ndarray")
        i, j = near[np.lexsort(near.T[::-1])].T
        gap = x[i] - x[j]
        kept = (gap * gap).sum(axis=1) < (self.radii[i] + self.radii[j] + SKIN) ** 2
        self.pairs, self.listed = np.stack([i[kept], j[kept]]), x.copy()

    def look(self, x: np.ndarray) -> _SoftForces:
        """Forces at these places, shape (n, 2)."""
        moved = x - self.listed
        if not (moved * moved).sum(axis=1).max() < (SKIN / 2) ** 2:
            self._list(x)
        i, j = self.pairs
        gap, reach = x[i] - x[j], self.radii[i] + self.radii[j]
        square = (gap * gap).sum(axis=1)
        near = square < reach * reach
        i, j, gap, distance = i[near], j[near], gap[near], np.sqrt(square[near])
        overlap = reach[near] - distance
        push = gap * (overlap / np.maximum(distance, 1e-12))[:, None]
        out = np.maximum(self.low - x, 0.0) - np.maximum(x - self.high, 0.0)
        forces = out.copy()
        for axis in (0, 1):
            forces[:, axis] += np.bincount(i, push[:, axis], len(x)) - np.bincount(j, push[:, axis], len(x))
        smaller = 2.0 * np.minimum(self.radii[i], self.radii[j])
        worst = max((overlap / smaller).max(initial=0.0), (np.abs(out).max(axis=1) / (2 * self.radii)).max())
        return _SoftForces(forces, float((overlap**2).sum() + (out**2).sum()), float(worst))


def relaxed(bed: SoftBed) -> GrownPacking:
    """Discs of a bed, from anywhere in the rectangle until none overlaps, or until they are jammed."""
    soft = _Soft(bed)
    x, v = soft.start.copy(), np.zeros_like(soft.start)
    step, mixing, downhill, before = 0.1, 0.1, 0, np.inf
    for count in range(MOST_STEPS):
        forces = soft.look(x)
        if forces.overlap <= TOUCHING:
            break
        if count % LOOK == 0:
            if forces.energy > STUCK * before:
                break
            before = forces.energy
        if (forces.forces * v).sum() > 0:
            along = sqrt((v * v).sum() / (forces.forces * forces.forces).sum())
            v = (1.0 - mixing) * v + mixing * along * forces.forces
            downhill += 1
            if downhill > 5:
                step, mixing = min(1.1 * step, 0.8), 0.99 * mixing
        else:
            v, step, mixing, downhill = np.zeros_like(v), 0.5 * step, 0.1, 0
        v = v + step * forces.forces
        x = x + step * v
    return _grown(x * soft.unit, forces.overlap)
