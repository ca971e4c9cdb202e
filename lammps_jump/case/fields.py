# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of a case file: what is measured, how the case runs, and the whole of it.

They are pydantic models, frozen; unknown keys are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, radians, sqrt
from operator import itemgetter
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Discriminator, Field, Tag, create_model
from pydantic.functional_validators import field_validator, model_validator

from lammps_jump import units
from lammps_jump.analysis.quantities import LISTED, ListedAnalysis
from lammps_jump.physics.elementary import atan2, cos, hypot, sin
from lammps_jump.quoting import LONGEST, one_line
from lammps_jump.scene.walls import KINDS, WallName

from .base import LEAST_GRAVITY, MOST_GRAVITY, FineLength, Name, Speed, Strict, Whole, WholeOrAuto
from .beds import RoughBed
from .bodies import BodyField
from .contact import Contact
from .discs import Column, Discs, InitialField
from .inflow import InflowField


class StationPair(Strict):
    """Two upright planes that move along x at one speed, and the time between which their budget is kept."""

    x: units.Extent = Field(description="of the two planes, at the begin of the window")
    speed: units.Component = Field(default=0.0, description="of the planes")
    window: Annotated[tuple[units.Moment, units.Moment], AfterValidator(units.ordered)] = Field(
        description="from and to"
    )


class WeightOfWall(Strict):
    """Weight and strength of a wall that does not move, as if it were a body."""

    density: Annotated[units.Density, Field(ge=1e-3, le=1e6)] = Field(
        description="of the material of the wall, over the area of its outline"
    )
    friction: units.Friction = Field(description="coefficient of friction of its base")


class FacePressure(Strict):
    """Places at which the pressure of the discs on a wall or body is recorded."""

    bins: Annotated[int, Field(ge=1, le=500)] | None = Field(
        default=None,
        description="bins of about one width along the whole outline; none goes over a corner, so that there may be "
        "more of them",
    )
    points: tuple[units.Point, ...] = Field(
        default=(), max_length=100, description="`[[x, y]]`: gauges, each at the nearest point of the outline"
    )
    over: Annotated[units.Plain, Field(gt=0, le=1000)] = Field(
        default=3.0, description="width of a gauge, in diameters: the pressure is the mean over it. It ends at corners"
    )


class Probes(Strict):
    """Records of every step: forces on walls, and the energy between two stations."""

    forces: tuple[Name, ...] = Field(default=(), description="names of the walls; their forces are recorded")
    interval: units.Duration = Field(
        default=0.01,
        description="forces are means over this time, with every step counted. The window is the nearest that divides "
        "the frames; where it or another asked time differs by more than 0.1 %, `check` and the run say so",
    )
    stations: StationPair | None = Field(
        default=None,
        description="energy budget between two upright planes that move, every step counted (native engine; "
        "measuring.md#momentum-and-energy)",
    )
    groups: dict[WallName, tuple[Name, ...]] = Field(
        default_factory=dict,
        description="`{name: [walls]}`: sums of the forces on walls, which need not stand in `probes.forces`; their "
        "moment is about the point of the first wall",
    )
    stability: dict[Name, WeightOfWall] | None = Field(
        default=None,
        description="`{name: {density: 2400, friction: 0.6}}`: walls that stand and are looked at as if they had this "
        "weight: do they slide or tip? They need not stand in `probes.forces`. Bodies have their own weight and "
        "friction, and are looked at anyway",
    )
    stability_mean: units.Duration | None = Field(
        default=None,
        description="time of the moving mean of forces over which the least factors of safety are told beside those "
        "of single windows. Without it, 0.1 s",
    )
    pressure: dict[Name, FacePressure] | None = Field(
        default=None,
        description="`{name: {bins: 20, points: [[x, y]], over: 3}}`: pressure along the outlines of walls and bodies, "
        "every step counted (native engine)",
    )
    gauges: tuple[units.Coordinate, ...] = Field(
        default=(),
        max_length=100,
        description="places along x: depth there against time, and the height of a paddle's waves",
    )

    @property
    def recorded(self) -> bool:
        """Tells whether forces on walls or along them are recorded."""
        return bool(self.walls or self.pressure)

    @property
    def walls(self) -> tuple[str, ...]:
        """Names of the walls whose forces are recorded, each once."""
        members = (member for group in self.groups.values() for member in group)
        return tuple(dict.fromkeys((*self.forces, *members, *(self.stability or {}))))


class Layers(Strict):
    """Place of the profiles over y."""

    x: units.Extent | None = Field(
        default=None, description="from and to: the stretch; without it, the middle half of the channel"
    )
    height: units.Length | None = Field(default=None, description="of a layer; without it, two diameters")


def _layers(value: Any) -> str:
    return "<layers>" if isinstance(value, dict | Layers) else "<all>"


class Means(Strict):
    """Place and time of means."""

    bin_width: units.Length | None = Field(
        default=None, title="width of the bins", description="width of the bins of profiles. Without it, five diameters"
    )
    window: Annotated[tuple[units.Moment, units.Moment], AfterValidator(units.ordered)] | None = Field(
        default=None, description="`[from, to]`: time of the means. Without it, the last quarter of the run"
    )


def asked_for(base: type[Strict], listed: Mapping[str, ListedAnalysis]) -> Any:
    """A model with a field, true or false, for each analysis that a case may ask for."""
    fields: dict[str, Any] = {
        name: (bool, Field(default=False, description=one.asks)) for name, one in listed.items() if one.asks
    }
    return create_model("AskedFor", __base__=base, **fields)


class Analysis(asked_for(Means, LISTED)):  # type: ignore[misc]
    """Analyses of the dump: those of `LISTED`, and what some of them take other than true and false."""

    front: Literal[False, True, "water"] = Field(default=False, description=LISTED["front"].asks)
    layers: Annotated[Annotated[bool, Tag("<all>")] | Annotated[Layers, Tag("<layers>")], Discriminator(_layers)] = (
        Field(default=False, description=LISTED["layers"].asks)
    )
    stations: tuple[units.Metre, ...] = Field(
        default=(),
        description="places along x: the heads of the stream there, and what is lost from one to the next; without "
        "them, at the gauges, else at both ends of the stream",
    )
    fields: bool = Field(default=False, description="coarse-grained density, velocity and stress")
    animation: bool = Field(default=False, description="write a film")
    figures: Literal["default", "all", "player", "none"] = Field(
        default="default",
        description="PNG files in `figures/`. `default`: depth profile and ten pictures; the report draws its curves "
        "itself. `all`: every figure. `none`: no pictures and no report, only numbers and tables. `player`: as `none`, "
        "and the frames for the page of a study, `player.json`",
    )

    @property
    def looks_at_contacts(self) -> bool:
        """Tells whether an analysis needs the forces of contacts."""
        return self.fields or any(one.contacts and getattr(self, name) for name, one in LISTED.items())


FILM_INTERVAL = 0.4
"""Time between frames over sqrt(d/g): discs drawn between them by cubics are 0.01 d off, a few overlap (measured)."""
MOST_FILMED = 400
"""Frames of a run whose case asks for no interval: the report holds them."""
STILL_INTERVAL = 0.1
"""Time between frames without gravity, s."""


class RunFields(Strict):
    """Duration, time step and output."""

    duration: units.Duration = Field(
        title="simulated time", description="counted from the opening of the gates; whole frames within 0.1 % of it"
    )
    time_step_fraction: units.Plain = Field(
        default=0.05,
        ge=1e-6,
        le=2,
        title="time step over 2/ω",
        description="f: the time step over 2/ω (3.24), the largest stable step of an undamped contact. A bound: the "
        "step is up to 2 % finer where windows, frames and duration are whole steps then. An unstable step is refused",
    )
    output_interval: units.Duration | None = Field(
        default=None,
        description=f"time between frames. Without it, {FILM_INTERVAL:zg} √(d/g), at most {MOST_FILMED} frames, so "
        f"that the report plays; {STILL_INTERVAL:zg} s without gravity. Up to 2 % other, so that frames divide the "
        "duration and windows of the probes the frames",
    )
    seed: Whole = Field(
        default=1,
        ge=0,
        le=2_000_000_000,
        title="seed",
        description="seed of the random shifts, of the places of poured discs and of sizes. It also changes the speed "
        "of each inflow row by up to 1e-6 of itself, the same in every engine: runs with other seeds are other samples "
        "of one flow. 0 leaves the row speeds as they are",
    )
    accuracy: units.Share | None = Field(
        default=None,
        description="such as `1%`: use the cheapest setting shown to be that accurate (benchmark.md). Without it, the "
        "settings of the case",
    )
    members: Annotated[Whole, Field(ge=1, le=1000)] | None = Field(
        default=None,
        description="starts of the case, of seeds 1 to this number: `build-and-run` runs them all (sweeps.md)",
    )
    stop_when_steady: bool = Field(
        default=False,
        description="end when depth, discharge and toe of the jump are statistically steady (without a toe: depth and "
        "discharge), or when no disc has entered for 1.5 passages of the reach: the inlet is drowned. Without inflow "
        "rows: end when the discs rest (reference/numbers.md#rest)",
    )
    allow_unstable: bool = Field(default=False, description="run with a step that is refused otherwise")
    integrator: Literal["auto", "velocity_verlet", "leapfrog_extrapolated"] = Field(
        default="auto",
        description="`velocity_verlet` (LAMMPS) or `leapfrog_extrapolated` (thesis; native engine only). `auto`: that "
        "of the engine",
    )
    checkpoint_interval: units.Duration = Field(
        default=60.0, description="wall time between checkpoints; they come more rarely where one takes over 1 % of it"
    )
    dump_format: Literal["text", "gz", "binary"] = Field(
        default="text", description="how the frames are written: as `text`, packed (`gz`) or `binary`"
    )


MOST_THREADS = 64
"""Of one process; the plugin has as many parts."""


class Engine(Strict):
    """Engine, kernel, ranks and threads."""

    name: Literal["lammps", "native", "twin"] = Field(
        default="lammps",
        description="`lammps`: LAMMPS, with its own styles or compiled ones; `native`: the thesis step by step; "
        "`twin`: the same in plain Python, slow, without a compiler",
    )
    kernel: Literal["auto", "stock", "compiled"] = Field(
        default="auto",
        description="styles of LAMMPS: `stock` (its own) or `compiled` (this project's plugin). `auto`: compiled where "
        "there is a compiler",
    )
    ranks: WholeOrAuto = Field(default=1, description="number of MPI ranks, 1 or more, or `auto` (scaling.md)")
    threads: WholeOrAuto = Field(
        default="auto",
        description=f"threads of the compiled kernel and of the native engine, 1 to {MOST_THREADS}. `auto`: up to the "
        "cores that the process may use, as many as steps show to be the quickest; one with several ranks and in "
        "members. They change no bit of the results (scaling.md#threads)",
    )
    skin: FineLength | None = Field(default=None, description="skin of the neighbour lists. Without it, 0.3 diameters")

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


IN_TWO_SECONDS = 0.5
"""Share of its range that a wall goes in a second where no speed is given."""


class LiveSlider(Strict):
    """A slider of a live page: what it changes, and between which numbers."""

    path: str = Field(
        min_length=1,
        max_length=200,
        description="`walls.NAME`, a wall, with `move`; `inflow`, the discharge of its rows (m²/s); or a number of the "
        "case: `contact.friction`, `contact.restitution`, `gravity`, `slope`",
    )
    move: Literal["x", "y", "turn"] | None = Field(
        default=None, description="of a wall: along x or y (m), or its turn (degrees); it takes the place of its motion"
    )
    range: Annotated[tuple[units.Plain, units.Plain], AfterValidator(units.ordered)] = Field(
        description="lowest and highest number; of a wall, from where the case has it, with 0 among them"
    )
    speed: Speed | None = Field(
        default=None,
        description="of a wall: how far it goes in a second (m/s, or degrees/s). Without it, its range in two seconds",
    )

    @model_validator(mode="after")
    def _of_one_kind(self) -> LiveSlider:
        low, high = self.range
        if (self.move is not None) != self.path.startswith("walls."):
            raise ValueError("path and move: a wall, walls.NAME, needs move (x, y or turn), and nothing else has it")
        if self.move is None and self.speed is not None:
            raise ValueError("speed: is that of a wall; drop it")
        if self.move is not None and not low <= 0.0 <= high:
            raise ValueError(f"range: [{low:zg}, {high:zg}] leaves out where the case has the wall; 0 must be in it")
        if self.path == "inflow" and low <= 0.0:
            raise ValueError(f"range: the discharge {low:zg} m^2/s is out of range; allowed is above 0")
        return self

    @property
    def wall(self) -> str:
        """Name of the wall that it moves; empty where it moves none."""
        return self.path.removeprefix("walls.") if self.move else ""

    @property
    def rate(self) -> float:
        """Largest way of a wall in a second, m or degrees."""
        return self.speed or IN_TWO_SECONDS * (self.range[1] - self.range[0])


def _folded(value: Any) -> Any:
    return one_line(value) if isinstance(value, str) else value


def _downwards(value: Any) -> Any:
    """Gravity as given, refused as a vector with what is meant by it."""
    if not isinstance(value, list | tuple):
        return value
    if len(value) == 2 and all(isinstance(part, int | float) for part in value) and value[1] < 0:
        g, angle = hypot(*value), degrees(atan2(value[0], -value[1]))
        raise ValueError(
            f"is one number, downwards, and no vector; for {list(value)} write gravity: {g:z.4g} and slope: "
            f"{angle:z.4g} (degrees, which tilt gravity towards larger x)"
        )
    raise ValueError("is one number, downwards, and no vector; slope (degrees) tilts it towards larger x")


class Domain(Strict):
    """Room for the discs; a disc outside is lost, which ends the run."""

    x: units.Extent = Field(description="from and to along x")
    y: units.Rise = Field(description="from and to in height")
    periodic: Literal["x"] | None = Field(
        default=None, description="`x`: a disc that leaves at one end enters at the other"
    )


WallField = Annotated[KINDS | RoughBed, Field(discriminator="kind")]


class Outflow(Strict):
    """A line beyond which discs are taken out: one of the four."""

    x_beyond: units.Coordinate | None = Field(default=None, description="removes discs beyond this x")
    x_before: units.Coordinate | None = Field(default=None, description="removes discs before this x")
    y_below: units.Coordinate | None = Field(default=None, description="removes discs below this height")
    y_above: units.Coordinate | None = Field(default=None, description="removes discs above this height")

    @model_validator(mode="after")
    def _one(self) -> Outflow:
        if len(self.model_dump(exclude_none=True)) != 1:
            raise ValueError("needs exactly one of x_beyond, x_before, y_below, y_above in each item")
        return self


class CaseFields(Strict):
    """A whole case."""

    model_config = ConfigDict(title="Case")

    name: Name = Field(
        description="letters, digits, `_`, `.` and `-`; without it, the name of the file. Results go to "
        "`runs/<stem of the file>`"
    )
    description: Annotated[str, BeforeValidator(_folded)] = Field(
        default="",
        description=f"text for the report, at most {LONGEST} printable characters; line breaks become spaces. Values "
        "changed by `--set` or a study stand behind it; of a scene whose flow was edited it is left out",
    )
    gravity: Annotated[units.MetrePerSecond2, BeforeValidator(_downwards)] = Field(
        default=9.81, ge=0, le=MOST_GRAVITY, title="gravity", description="downwards; 0 for none"
    )
    slope: units.Degree = Field(default=0.0, gt=-90, lt=90, title="slope", description="tilts gravity towards larger x")
    discs: Discs = Field(description="what flows")
    contact: Contact = Field(description="what happens when discs touch")
    domain: Domain | None = Field(
        default=None,
        description="room for the discs: a disc that leaves it is lost, and the run ends. Without it, a size "
        "is chosen that the energy of the discs does not lead out of within 3 s",
    )
    walls: tuple[WallField, ...] = Field(
        default=(), description="each wall has a `name` and a `kind` with the fields below"
    )
    bodies: tuple[BodyField, ...] = Field(
        default=(),
        description="each body moves as its mass, its weight and what touches it let it. It has a `name` and a "
        "`kind` with the fields below",
    )
    initial: tuple[InitialField, ...] = Field(
        default=(), description="discs at the start; each item has a `kind` below"
    )
    inflow: InflowField | None = Field(
        default=None, description="one inflow, with a `kind` below; without it, no disc enters"
    )
    outflow: tuple[Outflow, ...] = Field(
        default=(), description="half-planes where discs are removed, each with one of the fields below"
    )
    run: RunFields = Field(description="how long, how finely and from which start")
    probes: Probes = Field(default=Probes(), description="what is recorded beside the frames")
    analysis: Analysis = Field(default=Analysis(), description="what is looked for")
    engine: Engine = Field(default=Engine(), description="what computes")
    live: dict[Name, LiveSlider] | None = Field(
        default=None,
        max_length=20,
        description="sliders of the page of `lammps-jump live`, by their names; `{}` for none. Without it, a sensible "
        "set. Domain and outlets allow for all that they may do",
    )

    @property
    def acceleration(self) -> tuple[float, float]:
        """Gravity along and across the slope, m/s^2."""
        if self.slope == 0:
            return 0.0, -self.gravity if self.gravity else 0.0
        angle = radians(self.slope)
        return self.gravity * sin(angle), -self.gravity * cos(angle)

    @property
    def seam(self) -> tuple[float, float] | None:
        """Ends of a periodic channel, m; None of another."""
        return self.domain.x if self.domain is not None and self.domain.periodic else None

    @property
    def rough(self) -> tuple[RoughBed, ...]:
        """Walls that are rows of fixed discs."""
        return tuple(wall for wall in self.walls if isinstance(wall, RoughBed))

    @property
    def output_interval(self) -> float:
        """Time between frames, s; where none is given, short enough for a film, or `STILL_INTERVAL`."""
        interval = self.run.output_interval
        if interval is not None or not self.gravity:
            return interval or STILL_INTERVAL
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
