# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of bodies that move freely."""

from __future__ import annotations

from math import inf, radians
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from lammps_jump import units
from lammps_jump.case.parts.base import Moment, Point, Strict, Vector
from lammps_jump.physics.bodies import BodySection, section_of_circle, section_of_polygon
from lammps_jump.scene.bodies.free import Free
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import Beginning
from lammps_jump.scene.walls import Block, Circle, Extent, Polygon, Wall, WallName

Axis = Literal["x", "y", "turn"]
AXES: tuple[Axis, ...] = ("x", "y", "turn")
Mass = Annotated[units.KilogramPerMetre, Field(ge=1e-9, le=1e15)]
Inertia = Annotated[units.KilogramMetre, Field(ge=1e-9, le=1e15)]
Length = Annotated[units.Metre, Field(ge=1e-6, le=1e6)]


def _each_once(value: tuple[Axis, ...]) -> tuple[Axis, ...]:
    if not value:
        raise ValueError("is empty, so that the body never moves: take a wall, or name one or more of x, y and turn")
    return tuple(axis for axis in AXES if axis in value)


class Body(Strict):
    """What every body has: how heavy it is, how it moves, and its material."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_default=True, serialize_by_alias=True, validate_by_alias=True,
        validate_by_name=True,
    )  # fmt: skip

    name: WallName
    density: units.Density | None = Field(default=None, ge=1e-3, le=1e6, description="of the area of its outline")
    mass: Mass | None = Field(default=None, description="per metre of width")
    inertia: Inertia | None = Field(
        default=None, description="about the centre of mass; default that of an even body of this mass"
    )
    free: Annotated[tuple[Axis, ...], AfterValidator(_each_once)] = Field(default=AXES, description="how it can move")
    hinge: Point | None = Field(default=None, description="it turns about this point only")
    begin: Moment = Field(default=0.0, alias="from", description="it is held before")
    velocity: Vector = Field(default=(0.0, 0.0), description="of the centre of mass, where it is released")
    spin: units.DegreePerSecond = Field(default=0.0, ge=-1e6, le=1e6, description="counter-clockwise")
    friction: units.Plain | None = Field(default=None, ge=0, le=1000, description="default: of contact")
    restitution: units.Plain | None = Field(default=None, ge=1e-6, le=1, description="default: of contact")
    stiffness: units.Stiffness | None = Field(
        default=None, ge=1e-6, le=1e24, description="default: contact.stiffness_wall"
    )
    rolling: units.Plain | None = Field(
        default=None, ge=0, le=1000, description="default: contact.rolling.friction; of discs on it"
    )
    corner_radius: Length | None = Field(default=None, description="default: a quarter of the smallest disc")

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
        self.wall()  # raises what is wrong with the outline
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
    x: Extent
    y: Extent
    angle: units.Degree = Field(default=0.0, ge=-360, le=360, description="turn about the centre, counter-clockwise")

    def wall(self) -> Wall:
        """The outline."""
        return Block(self.name, self.x, self.y, self.angle, **self.own)


class PolygonBody(Body):
    """A closed outline of straight lines."""

    kind: Literal["polygon"]
    points: tuple[Point, ...] = Field(min_length=3, max_length=1000)

    def wall(self) -> Wall:
        """The outline."""
        return Polygon(self.name, self.points, **self.own)


class CircleBody(Body):
    """A circle."""

    kind: Literal["circle"]
    centre: Point
    radius: Length

    def wall(self) -> Wall:
        """The outline."""
        return Circle(self.name, self.centre, self.radius, **self.own)

    @property
    def section(self) -> BodySection:
        """Area, centre and second moment of the circle."""
        return section_of_circle(self.centre, self.radius)


BodyField = Annotated[BlockBody | PolygonBody | CircleBody, Field(discriminator="kind")]
