# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of bodies that move freely; checks of their step, places, hinges and supports, and of how hard they fall."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, inf, radians, sqrt
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from lammps_jump import units
from lammps_jump.errors import FieldError
from lammps_jump.physics.bodies import BodySection, section_of_circle, section_of_polygon, tipping_speed
from lammps_jump.physics.contact import WallLaw, damping_ratio, extrapolated_stable_h, lagged_stable_h, largest_overlap
from lammps_jump.scene import InitialState, Motion, MovingWall
from lammps_jump.scene.bodies import Free, corners_of, largest_radius, round_of
from lammps_jump.scene.meeting import LARGEST_OVERLAP, stiffness_between, yielding
from lammps_jump.scene.shapes import open_ends
from lammps_jump.scene.walls import Block, Circle, Polygon, Wall, WallName

from .base import Strict

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

    def moving(self, acceleration: tuple[float, float], begun: InitialState) -> MovingWall:
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


SAMPLES = 400
"""Points of an outline that are looked at, at most, in addition to its corners."""
AT_ONCE = 4
"""Contacts of two bodies that are taken to move as one: as many as two blocks have that meet face to face."""
TOUCHES = 0.05
"""Largest distance from a body to what supports it, in diameters of the smallest disc."""


def check_bodies(
    begun: InitialState, walls: Sequence[MovingWall], fields: Mapping[str, str],
    laws: Mapping[str, WallLaw], integrator: str, *, unstable: bool, ground: float,
) -> list[str]:  # fmt: skip
    """Refuse bodies too light for the step, and such in walls or each other; sentences on what else is doubtful.

    Parameters
    ----------
    source : CaseSource
    begun : Beginning
    walls : sequence of MovingWall
        All walls at the start, bodies and gates among them.
    fields : mapping of str to str
        Where in the case each is given.
    laws : mapping of str to WallLaw
        Contacts that are not those of the scene.
    integrator : str
    unstable : bool
        Whether the case allows a step that is too long.
    ground : float
        Lowest ground, m; infinite where there is none.
    """
    notes: list[str] = []
    bodies = [one for one in walls if one.motion.free]
    for one in bodies:
        free, field = one.motion.free, fields[one.wall.name]
        assert free is not None
        law = laws.get(one.wall.name, begun.coefficients.wall_law)
        if not unstable:
            _check_step(begun, one.wall, free, law, integrator, field)
            _check_corners(begun, one, walls, integrator, field)
        others = [
            other for other in walls if other is not one and not (other.motion.free and _later(other, one, walls))
        ]
        _check_free_of(begun, one, others, field)
        notes += [*_hinge(one.wall, free), *_support(begun, one, walls), *_soft(begun, one, walls, ground)]
    return notes


def _later(one: MovingWall, other: MovingWall, walls: Sequence[MovingWall]) -> bool:
    """Tells whether a wall comes after another in a list: each two bodies are looked at once."""
    return walls.index(one) > walls.index(other)


def points_of(wall: Wall) -> np.ndarray:
    """Corners of an outline and points between them, shape (n, 2), m."""
    corners = np.concatenate(wall.outline((0.0, 0.0), (0.0, 0.0)))
    after = np.roll(corners, -1, axis=0)
    length = np.hypot(*(after - corners).T)
    counts = 1 + np.floor((SAMPLES - 1) * length / max(length.sum(), 1e-300)).astype(int)
    parts = [
        a + (b - a) * np.linspace(0, 1, n, endpoint=False)[:, None]
        for a, b, n in zip(corners, after, counts, strict=True)
    ]
    return np.concatenate(parts)


def shaken(wall: Wall, free: Free, spacing: float) -> float:
    """Largest frequency of a body between springs of stiffness 1 all round it, squared, times its mass, 1.

    The springs push along the normals of the outline, one each `spacing` (m).
    """
    points = points_of(wall)
    after = np.roll(points, -1, axis=0)
    length = np.hypot(*(after - points).T)
    normal = (
        np.column_stack([points[:, 1] - after[:, 1], after[:, 0] - points[:, 0]]) / np.maximum(length, 1e-300)[:, None]
    )
    ways = free.ways(0.5 * (points + after) - free.point, normal)
    most = np.linalg.eigvalsh((ways * (length / spacing)[:, None]).T @ ways)[-1]
    return free.mass * float(most) + 2.0  # two more at its ends


def least_mass(begun: InitialState, wall: Wall, free: Free, law: WallLaw, integrator: str) -> float:
    """Least mass of a body of this shape that discs all round it carry in a stable step, kg/m.

    Bound: omega^2 <= (k_wall + 3 k)/m + k_wall a/M, with a as `shaken` gives it. A spring between a disc and the body
    stores no more than (1 + 1/s) k u^2/2 and (1 + s) k w^2/2 of the displacements u and w of the two, for any s.
    """
    c, least = begun.coefficients, begun.smallest / begun.diameter
    mass = c.mass * least**2
    stiff = (law.stiffness + 3.0 * c.stiffness) / mass
    rate = (law.gamma_normal * c.mass * least + 3.0 * c.correction * c.damping * least) / mass
    limit = lagged_stable_h if integrator == "velocity_verlet" else extrapolated_stable_h
    low, high = 0.0, 1e6  # of a m/M
    for _ in range(60):
        share = 0.5 * (low + high)
        omega = sqrt(stiff + share * law.stiffness / mass)
        xi = (rate + share * law.gamma_normal * c.mass * least / mass) / (2.0 * omega)
        low, high = (share, high) if omega * begun.time_step < limit(xi) else (low, share)
    return inf if low == 0.0 else shaken(wall, free, begun.smallest) * mass / low


def _check_step(begun: InitialState, wall: Wall, free: Free, law: WallLaw, integrator: str, field: str) -> None:
    least = least_mass(begun, wall, free, law, integrator)
    if free.mass < least:
        raise FieldError(
            field,
            f"body '{wall.name}' of {free.mass:z.3g} kg/m is lighter than discs around it carry in a stable "
            f"step; allowed is {least:z.3g} kg/m or more at run.time_step_fraction "
            f"{begun.coefficients.time_step_fraction:z.3g}: lower it, make the body heavier, or set "
            "run.allow_unstable: true",
        )


def _check_free_of(begun: InitialState, one: MovingWall, others: Sequence[MovingWall], field: str) -> None:
    """Refuse a body that lies in another wall or body at the start."""
    allowed = 0.5 * begun.overlap_limit
    body = one.first
    own = points_of(body)
    for other in others:
        wall = other.at(0)
        if wall is None:
            continue
        depth = _depth(wall, own, begun)
        if wall.finite:
            depth = max(depth, _depth(body, points_of(wall), begun) if not wall.hollow else -inf)
        if depth > allowed * (1 + 1e-9):
            what = "body" if other.motion.free else "wall"
            raise FieldError(
                field,
                f"body '{one.wall.name}' lies {depth:z.3g} m deep in {what} '{wall.name}' at the start; "
                f"allowed is d/n = {allowed:z.3g} m: move one of the two",
            )


def _depth(wall: Wall, points: np.ndarray, begun: InitialState) -> float:
    """Depth of the deepest of some points (m) in a wall, m; below 0 outside."""
    gap = wall.distance(*points.T)
    if open_ends(wall.faces):  # it pushes nothing that is far behind it
        gap = np.where(gap < -begun.largest, inf, gap)
    return -float(gap.min())


def _hinge(wall: Wall, free: Free) -> list[str]:
    """A hinge that is farther from its body than the body is large."""
    if free.hinge is None:
        return []
    (x0, x1), (y0, y1) = wall.extent
    size, apart = hypot(x1 - x0, y1 - y0), float(wall.distance(*np.array(free.hinge)))
    if apart <= size:
        return []
    return [
        f"the hinge of body '{wall.name}' is {apart:z.3g} m away from it, and the body is {size:z.3g} m large: it "
        "swings on an arm without mass, which pushes nothing"
    ]


def _support(begun: InitialState, one: MovingWall, walls: Sequence[MovingWall]) -> list[str]:
    """A body that rests on something, with its centre of mass outside what carries it."""
    free = one.motion.free
    assert free is not None
    weight, place = np.array(free.weight), np.array(free.centre)
    if free.hinge is not None or not weight.any() or not all(free.axes) or one.motion.went:
        return []
    down, across = weight / np.hypot(*weight), np.array([-weight[1], weight[0]]) / np.hypot(*weight)
    points = points_of(one.wall)
    points = points[(points - place) @ down > 0]
    near = np.zeros(len(points), bool)
    for other in walls:
        if other is not one and (wall := other.at(0)) is not None:
            near |= np.abs(wall.distance(*points.T)) < TOUCHES * begun.smallest
    if not near.any() or round_of(one.wall.faces, 0):
        return []
    places = (points[near] - place) @ across
    if places.min() <= 0 <= places.max():
        return []
    off = float(min(abs(places.min()), abs(places.max())))
    return [f"body '{one.wall.name}' stands with its centre of mass {off:z.3g} m beside its support: it tips at once"]


def _check_corners(
    begun: InitialState, one: MovingWall, walls: Sequence[MovingWall], integrator: str, field: str
) -> None:
    """Refuse a body whose corners are too stiff for the step, where `AT_ONCE` of them touch."""
    free, c = one.motion.free, begun.coefficients
    assert free is not None
    limit = lagged_stable_h if integrator == "velocity_verlet" else extrapolated_stable_h
    for other in walls:
        if other is one:
            continue
        stiffness, gives = stiffness_between(c, one, other), AT_ONCE * (yielding(one) + yielding(other))
        own = [value for wall, _ in (one, other) if (value := wall.restitution) is not None]
        allowed = (limit(damping_ratio(min(own, default=c.restitution))) / begun.time_step) ** 2 / gives
        if stiffness > allowed:
            raise FieldError(
                field,
                f"the contact of body '{one.wall.name}' of {free.mass:z.3g} kg/m with '{other.wall.name}' has "
                f"{stiffness:z.3g} N/m, too stiff for run.time_step_fraction {c.time_step_fraction:z.3g}; allowed is "
                f"{allowed:z.3g} N/m: lower one of the two, make the body heavier, or set run.allow_unstable: true",
            )


def tips_at(wall: Wall, free: Free) -> float:
    """Speed at which the top of a body that is taller than wide meets the ground where it tips over, m/s; else 0."""
    weight = np.array(free.weight)
    if free.hinge is not None or not all(free.axes) or not weight.any() or round_of(wall.faces, 0):
        return 0.0
    down = weight / np.hypot(*weight)
    points = points_of(wall)
    height, width = (float(np.ptp(points @ way)) for way in (down, [-down[1], down[0]]))
    return tipping_speed(height, hypot(*free.weight) / free.mass) if height > width else 0.0


def foreseen_blow(one: MovingWall, ground: float) -> tuple[float, str]:
    """Twice the energy of the hardest blow that is foreseen, J per m of width, and how it comes, in words."""
    wall, free, went = one.first, one.motion.free, one.motion.went
    assert free is not None
    velocity, (_, (low, _)) = free.velocity if went is None else went.speed[:2], wall.extent
    fall = max(0.0, low - ground) if np.isfinite(ground) and free.freedom[1] else 0.0
    speed, tip = sqrt(hypot(*velocity) ** 2 + 2.0 * hypot(*free.weight) / free.mass * fall), tips_at(wall, free)
    # what tips turns about its foot, so that its end has a third of the mass
    return max(
        (free.mass * speed**2, f"meet a wall at {speed:z.3g} m/s"),
        (free.mass * tip**2 / 3.0, f"tip over and meet the ground at {tip:z.3g} m/s"),
    )


def _soft(begun: InitialState, one: MovingWall, walls: Sequence[MovingWall], ground: float) -> list[str]:
    """A body that is so heavy, or may fall or tip so fast, that its contacts with walls are too soft."""
    wall, free, c = one.first, one.motion.free, begun.coefficients
    assert free is not None
    limit = begun.overlap_limit
    if not round_of(wall.faces, 0):
        there = corners_of(one.wall.faces, 0, free.corner_radius)
        limit = min(limit, LARGEST_OVERLAP * min(corner.radius for corner in there))
    k = min((stiffness_between(c, one, other) for other in walls if not other.motion.free), default=inf)
    weight, (energy, blow) = hypot(*free.weight), foreseen_blow(one, ground)
    energy *= largest_overlap(1.0, c.restitution if wall.restitution is None else wall.restitution, 1.0) ** 2
    rests = 0.5 * weight / k  # on two corners
    overlap = 0.5 * rests + sqrt((0.5 * rests) ** 2 + energy / k)
    if overlap <= limit:
        return []
    enough = (0.5 * weight * limit + energy) / limit**2
    return [
        f"body '{wall.name}' of {free.mass:z.3g} kg/m {f'may {blow}' if energy else 'stands on its corners'}, with an "
        f"overlap of {overlap:z.2g} m where no discs soften it; the run ends at {limit:z.2g} m: a stiffness of its own "
        f"of {enough:z.2g} N/m is enough"
    ]
