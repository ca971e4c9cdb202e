# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of the discs: their sizes, and where they are at the start."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag, ValidationError
from pydantic.functional_validators import model_validator

from lammps_jump import units
from lammps_jump.case.parts.grading import GradingCurve, LogNormalSizes, SieveSizes
from lammps_jump.scene.shapes import PlaceError

from .parts.base import EarlierRun, Jitter, Shift, Speed, Strict, Whole

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
            except ValidationError:  # told of the sizes themselves
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
    """Discs at random that fill a rectangle to a chosen packing, at rest and without overlaps."""

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
