# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of bodies that move freely."""

from __future__ import annotations

from math import inf, radians
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from lammps_jump import units
from lammps_jump.case.parts.base import Strict
from lammps_jump.physics.bodies import BodySection, section_of_circle, section_of_polygon
from lammps_jump.scene.corners import largest_radius, round_of
from lammps_jump.scene.free import Free
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import Beginning
from lammps_jump.scene.walls import Block, Circle, Polygon, Wall, WallName

Axis = Literal["x", "y", "turn"]
AXES: tuple[Axis, ...] = ("x", "y", "turn")


def _each_once(value: tuple[Axis, ...]) -> tuple[Axis, ...]:
    if not value:
        raise ValueError("is empty, so that the body never moves: take a wall, or name one or more of x, y and turn")
    return tuple(axis for axis in AXES if axis in value)


class Body(Strict):
    """Fields of every body: how heavy it is, how it moves, and its material."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_default=True, serialize_by_alias=True, validate_by_alias=True,
        validate_by_name=True,
    )  # fmt: skip

    name: WallName = Field(description="letters, digits and `_`; no wall has it too")
    density: Annotated[units.Density, Field(ge=1e-3, le=1e6)] | None = Field(
        default=None,
        title="density",
        description="of the area of the outline (a disc has density · diameter² instead); or give `mass`",
    )
    mass: units.Mass | None = Field(default=None, title="mass", description="per metre of width, in place of `density`")
    inertia: Annotated[units.KilogramMetre, Field(ge=1e-9, le=1e15)] | None = Field(
        default=None,
        description="moment of inertia per metre of width about the centre of mass, beside `mass`. Without it, that of "
        "an even body of this mass",
    )
    free: Annotated[tuple[Axis, ...], AfterValidator(_each_once)] = Field(
        default=AXES, description="how it can move, of `x`, `y` and `turn`"
    )
    hinge: units.Point | None = Field(
        default=None, description="[x, y]: it turns about this point and moves no other way"
    )
    begin: units.Moment = Field(
        default=0.0, alias="from", description="it is held before, and pushes as a wall that stands"
    )
    velocity: units.Vector = Field(
        default=(0.0, 0.0), description="[vx, vy] of the centre of mass where it is released"
    )
    spin: units.DegreePerSecond = Field(
        default=0.0, ge=-1e6, le=1e6, description="counter-clockwise, where it is released"
    )
    friction: units.Friction | None = Field(
        default=None,
        title="friction coefficient",
        description="friction coefficient of discs, walls and bodies on it. Without it, that of the wall, else that of "
        "`contact`; of two, the smaller one counts",
    )
    restitution: units.Restitution | None = Field(
        default=None, title="restitution coefficient", description="restitution coefficient, as `friction`"
    )
    stiffness: units.Stiffness | None = Field(
        default=None,
        title="stiffness",
        description="of the spring of what touches it, as `friction`. Without any, discs have "
        "`contact.stiffness_wall`, and walls and bodies as much more as the effective mass is larger than a disc's, "
        "which needs no shorter step",
    )
    rolling: units.Friction | None = Field(
        default=None,
        title="rolling friction coefficient",
        description="coefficient of rolling friction of discs on it. Without it, that of `contact.rolling`, which must "
        "be there",
    )
    corner_radius: units.Length | None = Field(
        default=None,
        description="by which its corners are rounded where they meet walls and bodies, up to half of a side; discs "
        "feel them sharp. Without it, a quarter of the smallest disc",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Body:
        if (self.density is None) == (self.mass is None):
            raise ValueError("needs density (kg/m^3) or mass (kg per m of width), one of the two")
        if self.inertia is not None and self.mass is None:
            raise ValueError("inertia: goes with mass; density gives mass and inertia of an even body")
        if self.hinge is not None and ("turn" not in self.free or any(self.velocity)):
            raise ValueError("hinge: the body turns about it only; drop velocity, and leave turn in free")
        for axis, speed in zip(AXES, (*self.velocity, self.spin), strict=True):
            if speed and axis not in self.free and self.hinge is None:
                raise ValueError(f"free: [{', '.join(self.free)}] is without {axis}, and the body has a speed there")
        wall = self.wall()  # raises what is wrong with the outline
        largest = largest_radius(wall.faces, 0)
        if self.corner_radius is not None and not round_of(wall.faces, 0) and self.corner_radius > largest * (1 + 1e-9):
            raise ValueError(
                f"corner_radius: {self.corner_radius:zg} m rounds more than half of a side away, so that the body "
                f"would have another shape; allowed is up to {largest:z.4g} m"
            )
        return self

    def wall(self) -> Wall:
        """The outline, as a wall with the material of the body."""
        raise NotImplementedError

    @property
    def section(self) -> BodySection:
        """Area, centre and second moment of the outline."""
        return section_of_polygon(np.array(self.wall().outline((0.0, 0.0), (0.0, 0.0))[0]))

    @property
    def own(self) -> dict[str, Any]:
        """Its material."""
        return {name: getattr(self, name) for name in ("friction", "restitution", "stiffness", "rolling")}

    def motion(self, acceleration: tuple[float, float], smallest: float) -> Free:
        """Mass, weight and the rest, under gravity (m/s^2) and with corners for the smallest disc (m)."""
        section = self.section
        mass = self.mass if self.density is None else self.density * section.area
        assert mass is not None
        inertia = mass * section.moment / section.area if self.inertia is None else self.inertia
        return Free(
            mass=mass,
            inertia=inertia,
            centre=section.centre,
            weight=(mass * acceleration[0], mass * acceleration[1]),
            hinge=self.hinge,
            axes=("x" in self.free, "y" in self.free, "turn" in self.free),
            velocity=self.velocity,
            spin=radians(self.spin),
            corner_radius=self.corner_radius or 0.25 * smallest,
            begin=self.begin,
        )

    def moving(self, acceleration: tuple[float, float], begun: Beginning) -> MovingWall:
        """The body as a wall with its motion, among discs and their steps."""
        free = self.motion(acceleration, begun.smallest)
        return MovingWall(self.wall(), Motion(inf, free, free.point, 0.0, begun.settle_steps, begun.time_step))


class BlockBody(Body):
    """A solid rectangle."""

    kind: Literal["block"]
    x: units.Extent = Field(description="[left, right]")
    y: units.Rise = Field(description="[low, high]")
    angle: units.Degree = Field(default=0.0, ge=-360, le=360, description="counter-clockwise, about the centre")

    def wall(self) -> Wall:
        """The outline."""
        return Block(self.name, self.x, self.y, self.angle, **self.own)


class PolygonBody(Body):
    """A closed outline of straight lines."""

    kind: Literal["polygon"]
    points: tuple[units.Point, ...] = Field(
        min_length=3,
        max_length=1000,
        description="corners [x, y] in order, either way round; the last is joined to the first. Arcs are not there",
    )

    def wall(self) -> Wall:
        """The outline."""
        return Polygon(self.name, self.points, **self.own)


class CircleBody(Body):
    """A circle."""

    kind: Literal["circle"]
    centre: units.Point = Field(description="middle of the circle, [x, y]")
    radius: units.Length = Field(description="of the circle")

    def wall(self) -> Wall:
        """The outline."""
        return Circle(self.name, self.centre, self.radius, **self.own)

    @property
    def section(self) -> BodySection:
        """Area, centre and second moment of the circle."""
        return section_of_circle(self.centre, self.radius)


BodyField = Annotated[BlockBody | PolygonBody | CircleBody, Field(discriminator="kind")]
