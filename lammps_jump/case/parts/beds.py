# SPDX-License-Identifier: GPL-2.0-or-later
"""Rough beds: rows of fixed discs, from the case to places, ids and what the analysis sees as the bed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot
from typing import ClassVar, Literal

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.functional_validators import model_validator

from lammps_jump.scene import Interval, Sizes, Wall
from lammps_jump.scene.scene import Fixed
from lammps_jump.scene.walls import Line, WallName
from lammps_jump.units import Length, Plain, Point

from .base import Strict

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
        found = np.array([[x, y]]) + step * [right - x, top - y]
        if seam is None:
            return found
        low, period = seam[0], seam[1] - seam[0]
        found[:, 0] = low + (found[:, 0] - low) % period
        cells = np.round((found - [low, 0.0]) / (SAME_PLACE * self.diameter))
        cells[:, 0] %= round(period / (SAME_PLACE * self.diameter))
        first = np.unique(cells, axis=0, return_index=True)[1]
        return found[np.sort(first)]

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
        Of the other discs; None where all have this `diameter` (m).
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
