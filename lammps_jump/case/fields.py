# SPDX-License-Identifier: GPL-2.0-or-later
"""The fields of a case file: pydantic models, frozen, unknown keys refused."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, radians, sin, sqrt
from operator import itemgetter
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Discriminator, Field, Tag, create_model
from pydantic.functional_validators import field_validator, model_validator

from lammps_jump import units
from lammps_jump.analysis.quantities import LISTED, ListedAnalysis
from lammps_jump.quoting import LONGEST_NAME, one_line
from lammps_jump.scene.walls import KINDS, Coordinate, Extent, WallName, ordered

from .bodies.fields import BodyField
from .parts.base import (
    FINE_LENGTH,
    LEAST_GRAVITY,
    LENGTH,
    MOST_GRAVITY,
    SPEED,
    TIME,
    Component,
    Moment,
    Point,
    Strict,
    Vector,
    Whole,
    no_truth,
)
from .parts.beds import RoughBed
from .parts.contact import Contact
from .parts.earlier import EarlierRun
from .parts.inflow import InflowField

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=LONGEST_NAME)]


def _folded(value: Any) -> Any:
    return one_line(value) if isinstance(value, str) else value


Spread = Annotated[units.Plain, Field(ge=0, le=0.5, description="half the range of diameters, in nominal diameters")]


class UniformSizes(Strict):
    """Diameters d(1 - s) to d(1 + s), all equally frequent by number."""

    kind: Literal["uniform"]
    spread: Spread


class BidisperseSizes(Strict):
    """Diameters d(1 - s) and d(1 + s)."""

    kind: Literal["bidisperse"]
    spread: Spread
    share: units.Plain = Field(default=0.5, gt=0, lt=1, description="share of the large discs, by number")


class ListSizes(Strict):
    """Diameters one by one, with their shares by number."""

    kind: Literal["list"]
    diameters: tuple[Annotated[units.Metre, Field(**LENGTH)], ...] = Field(min_length=1, max_length=100)
    shares: tuple[Annotated[units.Plain, Field(gt=0, le=1)], ...]

    @model_validator(mode="after")
    def _shares(self) -> ListSizes:
        if len(self.shares) != len(self.diameters):
            raise ValueError(
                f"shares has {len(self.shares)} values, diameters {len(self.diameters)}; give one for each"
            )
        if abs(sum(self.shares) - 1.0) > 1e-6:
            raise ValueError(f"shares add up to {sum(self.shares):zg}; their sum must be 1")
        return self


SizesField = Annotated[UniformSizes | BidisperseSizes | ListSizes, Field(discriminator="kind")]
WIDEST_SIZES = 4.0
"""Largest ratio of a listed diameter and the nominal one."""


class Discs(Strict):
    """Discs; mass per metre of width = density * diameter^2."""

    diameter: units.Metre = Field(**LENGTH, description="nominal diameter; of all discs without sizes")
    density: units.Density = Field(default=1000.0, ge=1e-3, le=1e6)
    sizes: SizesField | None = Field(default=None, description="distribution of diameters; null: all equal")

    @model_validator(mode="after")
    def _near_nominal(self) -> Discs:
        for value in self.sizes.diameters if isinstance(self.sizes, ListSizes) else ():
            if not 1 / WIDEST_SIZES <= value / self.diameter <= WIDEST_SIZES:
                raise ValueError(
                    f"sizes.diameters holds {value:zg} m; allowed are {self.diameter / WIDEST_SIZES:zg} to "
                    f"{self.diameter * WIDEST_SIZES:zg} m, a quarter to four times the nominal diameter"
                )
        return self


class Domain(Strict):
    """Room for the discs; a disc outside is lost, which ends the run."""

    x: Extent
    y: Extent
    periodic: Literal["x"] | None = Field(default=None, description="x: what leaves at one end enters at the other")


WallField = Annotated[KINDS | RoughBed, Field(discriminator="kind")]


class Lift(Strict):
    """A gate that rises by the height of its column: in a time, or at a speed."""

    open_in: units.Second | None = Field(default=None, **TIME)
    speed: units.MetrePerSecond | None = Field(default=None, **SPEED)

    @model_validator(mode="after")
    def _one(self) -> Lift:
        if (self.open_in is None) == (self.speed is None):
            raise ValueError("needs open_in (s) or speed (m/s), one of the two; true opens at once")
        return self

    def time(self, height: float) -> float:
        """Time that it takes to rise by a height (m), s."""
        return self.open_in if self.speed is None else height / self.speed  # type: ignore[return-value]


def _lift(value: Any) -> str:
    return "<lift>" if isinstance(value, dict | Lift) else "<gate>"


Gate = Annotated[Annotated[bool, Tag("<gate>")] | Annotated[Lift, Tag("<lift>")], Discriminator(_lift)]


class Column(Strict):
    """Discs packed in a rectangle, as before a dam breaks."""

    kind: Literal["column"]
    x: Extent
    y: Extent
    packing: Literal["square", "hexagonal"] = "square"
    hydrostatic: bool = Field(default=True, description="overlaps of thesis figure 6.2 that carry the weight")
    jitter: units.Plain = Field(default=0.0, ge=0, le=0.2, description="random shift, in diameters")
    gate: Gate = Field(
        default=True, description="held at its right side until t = 0; {open_in: 2 s} or {speed: 4 m/s}: it rises then"
    )
    settle: units.Second = Field(default=0.0, ge=0, le=1e9, description="time behind the gate before t = 0")
    velocity: Vector = (0.0, 0.0)

    @model_validator(mode="after")
    def _still_behind_the_gate(self) -> Column:
        if self.settle and any(self.velocity):
            raise ValueError("a column that settles starts at rest; drop velocity or settle")
        return self


class Lattice(Strict):
    """Discs on a rectangular grid; single discs may have a velocity."""

    kind: Literal["lattice"]
    nx: Whole = Field(gt=0)
    ny: Whole = Field(gt=0)
    spacing: units.Metre = Field(**LENGTH)
    origin: Point
    jitter: units.Plain = Field(default=0.0, ge=0, le=0.5, description="random shift, in diameters")
    velocity: Vector = (0.0, 0.0)
    velocities: dict[int, Vector] = Field(
        default_factory=dict, description="disc number (from 1, along x first): [vx, vy]"
    )


class DiscList(Strict):
    """Discs one by one."""

    kind: Literal["list"]
    positions: tuple[Point, ...] = Field(min_length=1)
    velocities: tuple[Vector, ...] = ()
    jitter: units.Plain = Field(default=0.0, ge=0, le=0.5, description="random shift, in diameters")


InitialField = Annotated[Column | Lattice | DiscList | EarlierRun, Field(discriminator="kind")]


class Outflow(Strict):
    """A line beyond which discs are taken out: one of the four."""

    x_beyond: Coordinate | None = None
    x_before: Coordinate | None = None
    y_below: Coordinate | None = None
    y_above: Coordinate | None = None

    @model_validator(mode="after")
    def _one(self) -> Outflow:
        if len(self.model_dump(exclude_none=True)) != 1:
            raise ValueError("needs exactly one of x_beyond, x_before, y_below, y_above in each item")
        return self


FILM_INTERVAL = 0.4
"""Time between frames over sqrt(d/g): discs drawn between them by cubics are 0.01 d off, a few overlap (measured)."""
MOST_FILMED = 400
"""Frames of a run whose case asks for no interval: the report holds them."""
STILL_INTERVAL = 0.1
"""Time between frames without gravity, s."""


class RunFields(Strict):
    """Duration, time step and output."""

    duration: units.Second = Field(**TIME)
    time_step_fraction: units.Plain = Field(
        default=0.05, ge=1e-6, le=2, description="f of the critical step 2/omega (3.24)"
    )
    output_interval: units.Second | None = Field(
        default=None, **TIME, description="default 0.4 sqrt(d/g), at most 400 frames"
    )
    seed: Whole = Field(
        default=1,
        ge=0,
        le=2_000_000_000,
        description="of sizes, shifts and row speeds; 0 leaves row speeds as they are",
    )
    accuracy: units.Share | None = Field(
        default=None, description="picks the cheapest setting that the stored calibration shows to meet it: 0.01 or 1%"
    )
    members: Whole | None = Field(default=None, ge=1, le=1000, description="starts, of seeds 1 to this number")
    stop_when_steady: bool = False
    allow_unstable: bool = False
    integrator: Literal["auto", "velocity_verlet", "leapfrog_extrapolated"] = "auto"
    checkpoint_interval: units.Second = Field(default=60.0, **TIME, description="wall time between checkpoints")
    dump_format: Literal["text", "gz", "binary"] = "text"


class StationPair(Strict):
    """Two upright planes that move along x at one speed, and the time between which their budget is kept."""

    x: Extent = Field(description="places of the two at the beginning of the window")
    speed: Component = 0.0
    window: Annotated[tuple[Moment, Moment], AfterValidator(ordered)]


class Probes(Strict):
    """What is recorded at every step: forces on walls, and the energy between two stations."""

    forces: tuple[Name, ...] = ()
    interval: units.Second = Field(default=0.01, **TIME, description="forces are means over it, every step counted")
    stations: StationPair | None = Field(default=None, description="energy budget between them; native engine only")
    groups: dict[WallName, tuple[Name, ...]] = Field(
        default_factory=dict, description="name: walls whose forces are summed"
    )
    gauges: tuple[Coordinate, ...] = Field(default=(), max_length=100, description="x where the depth is followed")


class Layers(Strict):
    """Where profiles over y are made."""

    x: Extent | None = Field(default=None, description="stretch of x; default the middle half of the channel")
    height: units.Metre | None = Field(default=None, **LENGTH, description="height of a layer; default 2 d")


def _layers(value: Any) -> str:
    return "<layers>" if isinstance(value, dict | Layers) else "<all>"


class Means(Strict):
    """Where and when means are taken."""

    bin_width: units.Metre | None = Field(default=None, **LENGTH)
    window: Annotated[tuple[Moment, Moment], AfterValidator(ordered)] | None = None


def asked_for(base: type[Strict], listed: Mapping[str, ListedAnalysis]) -> Any:
    """A model with a field, true or false, for each analysis that a case may ask for."""
    fields: dict[str, Any] = {
        name: (bool, Field(default=False, description=one.asks)) for name, one in listed.items() if one.asks
    }
    return create_model("AskedFor", __base__=base, **fields)


class Analysis(asked_for(Means, LISTED)):  # type: ignore[misc]
    """Analyses of the dump: those of `LISTED`, and what some of them take beside true and false."""

    front: Literal[False, True, "water"] = Field(default=False, description=LISTED["front"].asks)
    layers: Annotated[Annotated[bool, Tag("<all>")] | Annotated[Layers, Tag("<layers>")], Discriminator(_layers)] = (
        Field(default=False, description=LISTED["layers"].asks)
    )
    stations: tuple[units.Metre, ...] = Field(default=(), description="places between which the head lost is told")
    fields: bool = False
    animation: bool = False
    figures: Literal["default", "all", "player", "none"] = Field(default="default", description="none: no report")

    @property
    def looks_at_contacts(self) -> bool:
        """Whether an analysis needs the forces of contacts."""
        return self.fields or any(one.contacts and getattr(self, name) for name, one in LISTED.items())


MOST_THREADS = 64
"""Of one process; the plugin has as many parts."""


class Engine(Strict):
    """Engine, kernel, ranks and threads."""

    name: Literal["lammps", "native", "twin"] = "lammps"
    kernel: Literal["auto", "stock", "compiled"] = "auto"
    ranks: Annotated[int | Literal["auto"], BeforeValidator(no_truth)] = 1
    threads: Annotated[int | Literal["auto"], BeforeValidator(no_truth)] = "auto"
    skin: units.Metre | None = Field(default=None, **FINE_LENGTH, description="neighbour skin; default 0.3 d")

    @field_validator("ranks")
    @classmethod
    def _ranks(cls, value: int | str) -> int | str:
        if isinstance(value, int) and value < 1:
            raise ValueError(f"{value} ranks; expected 1 or more, or auto")
        return value

    @field_validator("threads")
    @classmethod
    def _threads(cls, value: int | str) -> int | str:
        if isinstance(value, int) and not 1 <= value <= MOST_THREADS:
            raise ValueError(f"{value} threads; expected 1 to {MOST_THREADS}, or auto")
        return value


class CaseFields(Strict):
    """A whole case."""

    model_config = ConfigDict(title="Case")

    name: Name
    description: Annotated[str, BeforeValidator(_folded)] = Field(default="", description="one line, for readers")
    gravity: units.MetrePerSecond2 = Field(default=9.81, ge=0, le=MOST_GRAVITY)
    slope: units.Degree = Field(default=0.0, gt=-90, lt=90, description="tilts gravity along +x")
    discs: Discs
    contact: Contact
    domain: Domain | None = None
    walls: tuple[WallField, ...] = ()
    bodies: tuple[BodyField, ...] = ()
    initial: tuple[InitialField, ...] = ()
    inflow: InflowField | None = None
    outflow: tuple[Outflow, ...] = ()
    run: RunFields
    probes: Probes = Probes()
    analysis: Analysis = Analysis()
    engine: Engine = Engine()

    @property
    def acceleration(self) -> tuple[float, float]:
        """Gravity along and across the slope, m/s^2."""
        if self.slope == 0:
            return 0.0, -self.gravity if self.gravity else 0.0
        angle = radians(self.slope)
        return self.gravity * sin(angle), -self.gravity * cos(angle)

    @property
    def seam(self) -> tuple[float, float] | None:
        """Where a periodic channel begins and ends, m; None of another."""
        return self.domain.x if self.domain is not None and self.domain.periodic else None

    @property
    def rough(self) -> tuple[RoughBed, ...]:
        """Walls that are rows of fixed discs."""
        return tuple(wall for wall in self.walls if isinstance(wall, RoughBed))

    @property
    def output_interval(self) -> float:
        """Time between frames, s; where none is asked for, close enough for a film, or `STILL_INTERVAL`."""
        asked = self.run.output_interval
        if asked is not None or not self.gravity:
            return asked or STILL_INTERVAL
        return max(FILM_INTERVAL * sqrt(self.discs.diameter / self.gravity), self.run.duration / MOST_FILMED)

    @property
    def settling(self) -> tuple[float, int]:
        """Longest time that a column settles behind its gate, s, and the place of the column in `initial`."""
        columns = ((item.settle, i) for i, item in enumerate(self.initial) if isinstance(item, Column) and item.gate)
        return max(columns, key=itemgetter(0), default=(0.0, 0))

    @field_validator("gravity")
    @classmethod
    def _some_or_none(cls, value: float) -> float:
        if 0 < value < LEAST_GRAVITY:
            raise ValueError(
                f"{value:zg} is out of range; allowed is 0 for none, or {LEAST_GRAVITY:zg} to {MOST_GRAVITY:zg} m/s^2"
            )
        return value
