# SPDX-License-Identifier: GPL-2.0-or-later
"""The fields of a case file: pydantic models, frozen, unknown keys refused."""

from __future__ import annotations

from math import degrees, radians, sqrt
from operator import itemgetter
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field
from pydantic.functional_validators import field_validator, model_validator

from lammps_jump import units
from lammps_jump.physics.elementary import atan2, cos, hypot, sin
from lammps_jump.quoting import LONGEST, one_line
from lammps_jump.scene.walls import KINDS

from .bodies import BodyField
from .discs import Column, Discs, InitialField
from .measures import Analysis, Probes
from .parts.base import LEAST_GRAVITY, MOST_GRAVITY, Name, Strict
from .parts.beds import RoughBed
from .parts.contact import Contact
from .parts.inflow import InflowField
from .settings import FILM_INTERVAL, MOST_FILMED, STILL_INTERVAL, Engine, LiveSlider, RunFields


def _folded(value: Any) -> Any:
    return one_line(value) if isinstance(value, str) else value


def _downwards(value: Any) -> Any:
    """Gravity as it stands, refused as a vector with what is meant by it."""
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
