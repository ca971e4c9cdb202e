# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of the discs: their sizes, by a sieve curve or a log-normal law too, and where they are at the start."""

from __future__ import annotations

from itertools import pairwise
from math import ceil, sqrt
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict, Discriminator, Field, Tag, ValidationError
from pydantic.functional_validators import field_validator, model_validator

from lammps_jump import units
from lammps_jump.physics.elementary import exp, log
from lammps_jump.physics.grading import normal_part, number_shares
from lammps_jump.scene.shapes import PlaceError

from .base import EarlierRun, Jitter, Shift, Speed, Strict, Whole

WIDEST = 16.0
"""Largest ratio of the largest and the smallest diameter of a curve: cells are those of the largest."""
OFF = 1e-3
"""Part of the whole by which a curve in pieces may be off between their ends: there discs are uniform by number."""
FINE_RATIO, FINE_SPREAD = 1.055, 0.12
"""Largest ratio of the ends of a piece of a log-normal curve, and its largest width in spreads: `OFF` is kept."""
FINER = 2.0
"""Part of the finest sieve that what passes it is taken to reach down to, as an inverse: sieves halve."""
DIGITS = 6
"""Significant digits of a nominal diameter that is d50."""
By = Literal["mass", "number"]
Passing = tuple[units.Length, Annotated[units.Plain, Field(ge=0, le=1)]]


class Pieces(NamedTuple):
    """A curve in pieces: shares in the number of discs, least and largest diameter (m), each of shape (n,)."""

    shares: np.ndarray
    low: np.ndarray
    high: np.ndarray


class GradingCurve(Strict):
    """A distribution that says all of the diameters, so that no nominal one is needed."""

    by: By = Field(
        default="mass",
        description="what the shares are of: `mass` (as of sieves; that of a disc goes with d²) or `number`",
    )

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Diameters (m) and the share that is not larger, at the ends of pieces; both rise from 0 to 1."""
        raise NotImplementedError

    @property
    def pieces(self) -> Pieces:
        """The curve by number, with the mass (or number) of each piece as requested."""
        sizes, below = self.ends()
        shares, low, high = np.diff(below), sizes[:-1], sizes[1:]
        low, high, shares = low[shares > 0], high[shares > 0], shares[shares > 0]
        return Pieces(number_shares(low, high, shares) if self.by == "mass" else shares, low, high)

    @property
    def nominal(self) -> float:
        """The size d50, m: half of the mass, or of the number where the curve is by number, is not larger."""
        return float(f"{self.size_at(0.5):z.{DIGITS}g}")

    def size_at(self, part: float) -> float:
        """Size that this part is not larger than, as the curve was given: by mass or by number, m."""
        sizes, below = self.ends()
        return float(np.interp(part, below, sizes))


def _within_bounds(low: float, high: float, remedy: str) -> None:
    if high / low > WIDEST * (1 + 1e-9):
        raise ValueError(
            f"reaches from {low:z.4g} to {high:z.4g} m, a ratio of {high / low:z.3g}; allowed is {WIDEST:zg}: {remedy}"
        )


class SieveSizes(GradingCurve):
    """A sieve curve: which share passes sieves of these openings; straight lines between them."""

    kind: Literal["sieve"]
    passing: tuple[Passing, ...] = Field(
        min_length=2,
        max_length=50,
        description="pairs [opening, share that passes], rising: `[[0.06 m, 0 %], [0.1 m, 40 %], [0.2 m, 100 %]]`. The "
        "last one is 100 %. Where the first is above 0 %, that share lies between it and half of its opening",
    )
    axis: Literal["linear", "log"] = Field(
        default="linear", description="of the sizes, along which the lines between the openings are straight"
    )

    @field_validator("passing", mode="before")
    @classmethod
    def _no_bare_percent(cls, given: Any) -> Any:
        """Refuse 40 where 40 % or 0.4 is meant: one of the two would be a guess."""
        for pair in given if isinstance(given, list | tuple) else ():
            share = pair[1] if isinstance(pair, list | tuple) and len(pair) == 2 else 0
            if isinstance(share, int | float) and not isinstance(share, bool) and share > 1:
                raise ValueError(f"{share:zg} is no share; write {share:zg} % or {share / 100:zg}")
        return given

    @model_validator(mode="after")
    def _rises(self) -> SieveSizes:
        for (size, share), (above, more) in pairwise(self.passing):
            if above <= size or more < share:
                raise ValueError(
                    f"passing: [{above:zg} m, {100 * more:zg} %] follows [{size:zg} m, {100 * share:zg} %]; openings "
                    "must grow, and what passes must not fall"
                )
        size, share = self.passing[-1]
        if abs(share - 1.0) > 1e-9:
            raise ValueError(
                f"passing: {100 * share:zg} % pass the coarsest sieve, {size:zg} m, and nothing says how large the "
                "rest is; add a last pair [largest size, 100 %]"
            )
        _within_bounds(self.openings[0][0], size, "leave out the finest part, which is most of the discs by number")
        return self

    @property
    def openings(self) -> tuple[tuple[float, float], ...]:
        """The pairs, from 0 % on, and from the last opening that nothing passes."""
        pairs = self.passing
        while len(pairs) > 2 and pairs[1][1] == 0:
            pairs = pairs[1:]
        size, share = pairs[0]
        return ((size / FINER, 0.0), *pairs) if share > 0 else pairs

    @property
    def open_end(self) -> str:
        """A sentence on a curve that does not say where its finest part ends; empty where it does."""
        size, share = self.passing[0]
        if share == 0:
            return ""
        return (
            f"discs.sizes.passing: {100 * share:z.3g} % pass the finest sieve, {size:zg} m; they are taken to lie "
            f"between {size / FINER:zg} and {size:zg} m: add a first pair [smallest size, 0 %] if that is not so"
        )

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """As of `GradingCurve`: between two openings as many pieces as `OFF` needs."""
        sizes, below = [self.openings[0][0]], [0.0]
        for (size, share), (above, more) in pairwise(self.openings):
            wide = log(above / size)
            # a uniform density by number is off by 0.375 of the logarithm of the ends' ratio, times the share, at most
            count = max(2, ceil(sqrt(0.375 * wide * (more - share) / OFF)))
            along = [*(size * exp(wide * (k / count)) for k in range(1, count)), above]
            parts = [(one - size) / (above - size) if self.axis == "linear" else (k + 1) / count
                     for k, one in enumerate(along)]  # fmt: skip
            sizes += along
            below += [*(share + (more - share) * part for part in parts[:-1]), more]
        return np.array(sizes), np.array(below)


class LogNormalSizes(GradingCurve):
    """Diameters whose logarithm is normal, by mass or by number, cut off at both ends."""

    kind: Literal["log_normal"]
    median: units.Length = Field(title="median diameter", description="half of the mass, or of the number, is smaller")
    spread: Annotated[
        units.Plain,
        Field(gt=1, le=4, title="geometric spread", description="geometric standard deviation: median times or over "
              "it holds 68 %"),
    ]  # fmt: skip
    cut: units.Plain = Field(
        default=2.5, gt=0, le=5, description="spreads at which both ends are cut off; 2.5 keeps 98.8 %"
    )

    @model_validator(mode="after")
    def _not_too_wide(self) -> LogNormalSizes:
        ends = [self.median * exp(sign * self.cut * log(self.spread)) for sign in (-1, 1)]
        most = log(WIDEST) / (2 * log(self.spread))
        _within_bounds(ends[0], ends[1], f"lower cut to {int(100 * most) / 100:zg} or less, or the spread")
        return self

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """As of `GradingCurve`: the integral of the normal density of (ln d - ln median)/ln spread."""
        wide = log(self.spread)
        count = max(ceil(2 * self.cut / FINE_SPREAD), ceil(2 * self.cut * wide / log(FINE_RATIO)))
        z = [self.cut * (2 * k / count - 1) for k in range(count + 1)]
        below = np.array([normal_part(one) for one in z])
        return np.array([self.median * exp(one * wide) for one in z]), (below - below[0]) / (below[-1] - below[0])


Spread = Annotated[
    units.Plain, Field(ge=0, le=0.5, title="spread of diameters", description="half width s, over the nominal diameter")
]
WIDEST_SIZES = 4.0
"""Largest ratio of a listed diameter and the nominal one."""


class UniformSizes(Strict):
    """Diameters d(1 - s) to d(1 + s), all equally frequent by number."""

    kind: Literal["uniform"]
    spread: Spread


class BidisperseSizes(Strict):
    """Diameters d(1 - s) and d(1 + s)."""

    kind: Literal["bidisperse"]
    spread: Spread
    share: units.Plain = Field(default=0.5, gt=0, lt=1, description="of the large discs, by number")


class ListSizes(Strict):
    """Diameters one by one, with their shares by number."""

    kind: Literal["list"]
    diameters: tuple[units.Length, ...] = Field(
        min_length=1, max_length=100, description="those that there are, from d/4 to 4d"
    )
    shares: tuple[Annotated[units.Plain, Field(gt=0, le=1)], ...] = Field(
        description="of each diameter by number; their sum is 1"
    )

    @model_validator(mode="after")
    def _shares(self) -> ListSizes:
        if len(self.shares) != len(self.diameters):
            raise ValueError(
                f"shares has {len(self.shares)} values, diameters {len(self.diameters)}; give one for each"
            )
        if abs(sum(self.shares) - 1.0) > 1e-6:
            raise ValueError(f"shares add up to {sum(self.shares):zg}; their sum must be 1")
        return self


SizesField = Annotated[
    UniformSizes | BidisperseSizes | ListSizes | SieveSizes | LogNormalSizes, Field(discriminator="kind")
]
CURVES: dict[str, type[GradingCurve]] = {"sieve": SieveSizes, "log_normal": LogNormalSizes}


def _diameter_not_needed(schema: dict[str, Any]) -> None:
    """A curve of sizes says the nominal diameter."""
    schema["required"] = [name for name in schema.get("required", ()) if name != "diameter"]


class Discs(Strict):
    """Discs; mass per metre of width = density * diameter^2."""

    model_config = ConfigDict(json_schema_extra=_diameter_not_needed)

    diameter: units.Length = Field(
        title="disc diameter",
        description="nominal where discs have `sizes`. A curve (`sieve`, `log_normal`) needs none: it is d50 then",
    )
    density: units.Density = Field(
        default=1000.0,
        ge=1e-3,
        le=1e6,
        title="density",
        description="mass per metre of width = density · diameter² (thesis 3.3)",
    )
    sizes: SizesField | None = Field(
        default=None, description="distribution of diameters, with a `kind` below; without it, all discs are equal"
    )

    @model_validator(mode="before")
    @classmethod
    def _nominal_of_a_curve(cls, data: Any) -> Any:
        """Take d50 of a curve where no diameter is given."""
        if not isinstance(data, dict) or data.get("diameter") is not None:
            return data
        given = data.get("sizes")
        if isinstance(given, dict) and (kind := CURVES.get(str(given.get("kind")))):
            try:
                given = kind.model_validate(given)
            except ValidationError:  # reported for the sizes themselves
                return {**data, "diameter": 1.0}
        return {**data, "diameter": given.nominal} if isinstance(given, GradingCurve) else data

    @model_validator(mode="after")
    def _within_curve(self) -> Discs:
        if isinstance(self.sizes, GradingCurve):
            (low, *_), (*_, high) = self.sizes.pieces[1:]
            if not low <= self.diameter <= high:
                raise PlaceError(
                    ("diameter",),
                    f"{self.diameter:zg} m is not in the curve of discs.sizes; allowed are {low:z.4g} to {high:z.4g} "
                    f"m. Drop it: the nominal diameter is d50 then, {self.sizes.nominal:zg} m",
                )
        return self

    @model_validator(mode="after")
    def _near_nominal(self) -> Discs:
        for value in self.sizes.diameters if isinstance(self.sizes, ListSizes) else ():
            if not 1 / WIDEST_SIZES <= value / self.diameter <= WIDEST_SIZES:
                raise ValueError(
                    f"sizes.diameters holds {value:zg} m; allowed are {self.diameter / WIDEST_SIZES:zg} to "
                    f"{self.diameter * WIDEST_SIZES:zg} m, a quarter to four times the nominal diameter"
                )
        return self


class Lift(Strict):
    """A gate that rises by the height of its column: in a time, or at a speed."""

    open_in: units.Duration | None = Field(
        default=None, description="time in which the gate rises by its height, from t = 0 on"
    )
    speed: Speed | None = Field(default=None, description="or the speed at which it rises")

    @model_validator(mode="after")
    def _one(self) -> Lift:
        if (self.open_in is None) == (self.speed is None):
            raise ValueError("needs open_in (s) or speed (m/s), one of the two; true opens at once")
        return self

    def time(self, height: float) -> float:
        """Time that it takes to rise by a height (m), s."""
        if self.speed is not None:
            return height / self.speed
        assert self.open_in is not None  # one of the two is given
        return self.open_in


def _lift(value: Any) -> str:
    return "<lift>" if isinstance(value, dict | Lift) else "<gate>"


Gate = Annotated[Annotated[bool, Tag("<gate>")] | Annotated[Lift, Tag("<lift>")], Discriminator(_lift)]


class Column(Strict):
    """Discs packed in a rectangle, as before a dam breaks."""

    kind: Literal["column"]
    x: units.Extent = Field(description="from and to")
    y: units.Rise = Field(description="from and to")
    packing: Literal["square", "hexagonal"] = Field(
        default="square", description="pattern of equal discs; with `discs.sizes` one by one, into the lowest notch"
    )
    hydrostatic: bool = Field(
        default=True,
        description="equal discs in square packing start with overlaps that carry the weight (thesis figure 6.2)",
    )
    jitter: Shift = Field(default=0.0, ge=0, le=0.2)
    gate: Gate = Field(
        default=True, description="holds the column at its right side until t = 0; with fields, a sheet that rises"
    )
    settle: units.Second = Field(default=0.0, ge=0, le=1e9, description="time behind the gate before t = 0")
    velocity: units.Vector = Field(
        default=(0.0, 0.0), description="[vx, vy] of all its discs at the start; not with `settle`"
    )

    @model_validator(mode="after")
    def _still_behind_the_gate(self) -> Column:
        if self.settle and any(self.velocity):
            raise ValueError("a column that settles starts at rest; drop velocity or settle")
        return self


class Lattice(Strict):
    """Discs on a rectangular grid; single discs may have a velocity."""

    kind: Literal["lattice"]
    nx: Whole = Field(gt=0, description="discs along x")
    ny: Whole = Field(gt=0, description="discs in height")
    spacing: units.Length = Field(description="from centre to centre")
    origin: units.Point = Field(description="[x, y] of the first disc")
    jitter: Jitter = 0.0
    velocity: units.Vector = Field(default=(0.0, 0.0), description="[vx, vy] of all its discs at the start")
    velocities: dict[int, units.Vector] = Field(
        default_factory=dict, description="disc number (from 1, along x first): [vx, vy]"
    )


class DiscList(Strict):
    """Discs one by one."""

    kind: Literal["list"]
    positions: tuple[units.Point, ...] = Field(min_length=1, description="[x, y] of each disc")
    velocities: tuple[units.Vector, ...] = Field(default=(), description="[vx, vy] of each disc")
    jitter: Jitter = 0.0


class PackedBed(Strict):
    """Discs at random that fill a rectangle to a chosen packing, at rest; without `jitter` none overlap."""

    kind: Literal["packed_bed"]
    x: units.Extent = Field(description="from and to; the sides are as walls")
    y: units.Rise = Field(description="from and to")
    packing: units.Plain = Field(
        gt=0.1,
        le=0.84,
        description="area of the discs over that of the rectangle, 0.1 to 0.84. Discs at random reach 0.82 to 0.84, "
        "less in a narrow bed; below 0.8 they sink under their weight",
    )
    seed: Whole | None = Field(
        default=None,
        ge=0,
        le=2**31 - 1,
        description="of the places; without it `run.seed`: starts draw anew, and points with one seed share a bed",
    )
    jitter: Shift = Field(default=0.0, ge=0, le=0.2)

    @property
    def area(self) -> float:
        """Area of the rectangle, m^2."""
        return (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])


InitialField = Annotated[Column | Lattice | DiscList | PackedBed | EarlierRun, Field(discriminator="kind")]
