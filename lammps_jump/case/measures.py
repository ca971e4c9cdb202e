# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of what is measured: probes at every step, and analyses of the frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, create_model

from lammps_jump import units
from lammps_jump.analysis.quantities import LISTED, ListedAnalysis
from lammps_jump.scene.walls import WallName

from .parts.base import Name, Strict


class StationPair(Strict):
    """Two upright planes that move along x at one speed, and the time between which their budget is kept."""

    x: units.Extent = Field(description="of the two planes, at the begin of the window")
    speed: units.Component = Field(default=0.0, description="of the planes")
    window: Annotated[tuple[units.Moment, units.Moment], AfterValidator(units.ordered)] = Field(
        description="from and to"
    )


class WeightOfWall(Strict):
    """Weight and strength of a wall that stands, as if it were a body."""

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
        default=None,
        title="width of the bins",
        description="width of the bins of profiles. Without it, five diameters",
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
    """Analyses of the dump: those of `LISTED`, and what some of them take beside true and false."""

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
