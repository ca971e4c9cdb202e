# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that discs meet. The class that checks a wall of a case file is the wall.

A wall answers what engines, drawing and analysis ask. Each answer follows from `Wall.chains`, the faces that push,
unless a wall knows better. Distances are of disc centres: a disc of radius R touches below R.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from math import inf, radians
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from lammps_jump import units
from lammps_jump.physics.elementary import cos, sin
from lammps_jump.quoting import LONGEST_NAME

from .chains import Chain, Faces, Point, bed_over, boxes, circle, distance, grounds, lay, outline
from .shapes import ArcTo, Path, Points, closed_path, drawn, rectangle, thin
from .tracks import KINDS as KINDS_OF_MOTION
from .tracks import FileName

Interval = tuple[float, float]


SIDES = {"right": "above", "left": "below", "high": "above", "low": "below", "+": "above", "-": "below"}
"""Other words for the side of a plane."""

Side = Annotated[
    Literal["above", "below"],
    BeforeValidator(lambda value: SIDES.get(value, value) if isinstance(value, str) else value),
]
WallName = Annotated[
    str, Field(pattern=r"^[A-Za-z0-9_]+$", max_length=LONGEST_NAME, description="letters, digits and `_`")
]
"""Part of the names of LAMMPS fixes, regions and variables, which take no other letters."""


def _in_a_file(schema: dict[str, Any], wall: type) -> None:
    """JSON schema of a wall in a case file: its kind comes first and must be given."""
    kind = schema["properties"].pop("kind")
    del kind["default"]
    own = {name: schema["properties"].pop(name) for name in (part.name for part in fields(_WallOwnFields))}
    schema["properties"] = {"kind": kind, **schema["properties"], **own}
    schema["required"] = ["kind", *schema["required"]]
    schema["description"] = (wall.__doc__ or "").splitlines()[0]


Motions = Annotated[KINDS_OF_MOTION, Field(discriminator="kind")]


@dataclass(frozen=True, kw_only=True)
class _WallOwnFields:
    """Fields that any wall may have of its own: numbers of its contacts, and a motion."""

    friction: Annotated[
        units.Friction | None,
        Field(
            title="friction coefficient",
            description="friction coefficient of discs on this wall. Without it, that of `contact`",
        ),
    ] = field(default=None, repr=False)
    restitution: Annotated[
        units.Restitution | None,
        Field(
            title="restitution coefficient",
            description="restitution coefficient of discs on this wall. Without it, that of `contact`",
        ),
    ] = field(default=None, repr=False)
    stiffness: Annotated[
        units.Stiffness | None,
        Field(
            title="stiffness",
            description="spring of discs on this wall. Without it, `contact.stiffness_wall`. A stiffer wall may need a "
            "smaller step, which `check` says",
        ),
    ] = field(default=None, repr=False)
    rolling: Annotated[
        units.Friction | None,
        Field(
            title="rolling friction coefficient",
            description="coefficient of rolling friction on this wall. Without it, that of `contact.rolling`, which "
            "must be there",
        ),
    ] = field(default=None, repr=False)
    motion: Annotated[
        Motions | None, Field(description="a motion with a `kind` below; without it, the wall stands")
    ] = field(default=None, repr=False)


class Wall(_WallOwnFields):
    """Answers of every wall. A new wall is a frozen dataclass with `kind`, `name` and fields, and `chains`."""

    __pydantic_config__ = ConfigDict(extra="forbid", serialize_by_alias=True, json_schema_extra=_in_a_file)
    kind: str
    name: str
    hollow: ClassVar[bool] = False
    """Says whether the discs are inside the outline."""
    deep: ClassVar[bool] = False
    """Says whether discs behind a face are pushed back from any depth, and not from their radius alone."""
    parts: tuple[str, ...] = ()
    """Endings after the name that scripts use for parts of the wall; no other wall may have such a name."""

    def chains(self) -> tuple[Chain, ...]:
        """Chains of faces that push, drawn with the discs on their left."""
        raise NotImplementedError

    @cached_property
    def faces(self) -> Faces:
        """The chains as flat arrays."""
        return lay([(self.chains(), self.deep)])

    def distance(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Distance of points to the nearest face, m; negative inside the solid."""
        return distance(self.faces, x, y)

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """Smallest rectangle (x, y) around the faces, m; infinite where they have no end."""
        box = boxes(self.faces, deep=False)
        (x_low, y_low), (x_high, y_high) = box[:, 0::2].min(axis=0), box[:, 1::2].max(axis=0)
        return (float(x_low), float(x_high)), (float(y_low), float(y_high))

    @property
    def finite(self) -> bool:
        """Tells whether the wall ends in every direction."""
        return bool(np.isfinite(self.extent).all())

    @property
    def own_law(self) -> tuple[float | None, float | None, float | None, float | None]:
        """Stiffness (N/m), restitution, friction and rolling friction of its own; all None: those of the scene."""
        return self.stiffness, self.restitution, self.friction, self.rolling

    @property
    def pivot_point(self) -> tuple[float, float]:
        """Point that it turns about where its motion names none, m: the centre; 0 where the wall has no end."""
        x, y = (0.5 * (low + high) if np.isfinite(low + high) else 0.0 for low, high in self.extent)
        return x, y

    @property
    def moment_point(self) -> tuple[float, float]:
        """Point about which the moment on the wall is taken, m: the lower left corner; 0 where the wall has no end."""
        x, y = (low if np.isfinite(low) else 0.0 for low, _ in self.extent)
        return x, y

    @property
    def thickness(self) -> float:
        """Thickness of the solid, m; 0 where it may be thin, infinite where discs are on one side alone."""
        return inf if self.hollow else 0.0

    def bends_given(self) -> list[tuple[str, float]]:
        """Fields that give an arc which bends towards the discs, and its radius, m."""
        return []

    def room(self, axis: str) -> Interval:
        """Interval of a coordinate that the wall leaves to the discs, m; infinite where it sets no bound."""
        return self.extent["xy".index(axis)] if self.hollow else (-inf, inf)

    def grounds(self, x: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Solids over x: the height of the underside and of the top of each, m, of x's shape; NaN where there is none.

        The underside is minus infinity where nothing fits below.
        """
        return grounds(self.faces, x)

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """Closed polygons of the solid within x and y, each of shape (corners, 2), m; of the hole if `hollow`."""
        return tuple(outline(chain) for chain in self.chains())


def parts_of(wall: Wall, x: Interval, y: Interval) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Drawing of a wall: closed polygons (even-odd; sheets have no area), and open lines with the discs on their left.

    Each of shape (corners, 2), m, within x and y where the wall has no end.
    """
    outlines, chains = list(wall.outline(x, y)), wall.chains()
    if not wall.finite or len(outlines) != len(chains):
        return outlines, []
    # the outline of an open chain goes there and back
    lines = [line[: len(line) // 2 + 1] for line, chain in zip(outlines, chains, strict=True) if not chain.closed]
    rings = [ring for ring, chain in zip(outlines, chains, strict=True) if chain.closed]
    if len(rings) == 2 and thin(both := np.vstack([rings[0], rings[0][:1], rings[1], rings[1][:1]])):
        rings = [both]  # a closed sheet
    return rings, lines


@dataclass(frozen=True)
class Plane(Wall):
    """An endless straight wall; discs on one side of it.

    Parameters
    ----------
    name : str
    axis : {'x', 'y'}
        The coordinate that is constant on the wall.
    at : float
        Its value there, m.
    side : {'above', 'below'}
        Where the discs are: at larger ('above') or smaller ('below') coordinates.

    Notes
    -----
    Signed distance: ``s (r_axis - at)`` with s = +1 above, -1 below.
    """

    kind: Literal["plane"] = field(default="plane", kw_only=True, repr=False)
    deep = True
    name: WallName
    axis: Annotated[Literal["x", "y"], Field(description="direction that the plane is upright to")]
    at: Annotated[units.Coordinate, Field(title="place", description="where it stands on this axis")]
    side: Annotated[Side, Field(description="side of it on which the discs are: at larger or smaller coordinates")]

    @property
    def sign(self) -> float:
        """+1 where the discs are above the plane, -1 below."""
        return 1.0 if self.side == "above" else -1.0

    def chains(self) -> tuple[Chain]:
        """A line without ends; it runs so that the discs are on its left."""
        if self.axis == "x":
            return (Chain(((self.at, 0.0), (self.at, -self.sign)), endless=True),)
        return (Chain(((0.0, self.at), (self.sign, self.at)), endless=True),)

    def room(self, axis: str) -> Interval:
        """One side of the plane, along its own axis, m."""
        if axis != self.axis:
            return -inf, inf
        return (self.at, inf) if self.side == "above" else (-inf, self.at)

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """The half-plane without discs, within x and y."""
        low, high = x if self.axis == "x" else y
        solid = (min(low, self.at), self.at) if self.side == "above" else (self.at, max(high, self.at))
        return (rectangle(solid, y) if self.axis == "x" else rectangle(x, solid),)


DiscsWhere = Annotated[Literal["outside", "inside"], Field(description="where the discs are: around it or in it")]
LEAF = "from and to; no width makes a leaf, which discs feel from both sides"


@dataclass(frozen=True)
class Block(Wall):
    """A solid rectangle, or a leaf without thickness; discs outside it.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        Its extent before it is turned, m. One of the two may have no width: a leaf, which both sides feel.
    angle : float
        Turn about the pivot, degrees, counter-clockwise.
    pivot : (float, float), optional
        Point of turning, also of its motion, m; default the centre.

    Notes
    -----
    A disc touches the block at one point, the nearest, as at LAMMPS' ``region block … side out``; a corner rounds the
    distance. A centre inside the block, less than a radius deep, is pushed out along the nearest face. (LAMMPS' region
    has no force there.) The moment is taken about the corner that is the lower left one at angle 0.
    """

    kind: Literal["block"] = field(default="block", kw_only=True, repr=False)
    name: WallName
    x: Annotated[tuple[units.Start, units.End], AfterValidator(units.not_backwards), Field(description=LEAF)]
    y: Annotated[tuple[units.Underside, units.Height], AfterValidator(units.not_backwards), Field(description=LEAF)]
    angle: Annotated[units.Degree, Field(ge=-360, le=360, description="counter-clockwise, about `pivot`")] = 0.0
    pivot: Annotated[units.Point | None, Field(description="[x, y]; without it, the centre")] = None

    def __post_init__(self) -> None:
        if self.x[0] == self.x[1] and self.y[0] == self.y[1]:
            raise ValueError(f"x and y are one point, ({self.x[0]:zg}, {self.y[0]:zg}) m; give one of them a width")

    @property
    def leaf(self) -> bool:
        """Tells whether it has no thickness."""
        return self.x[0] == self.x[1] or self.y[0] == self.y[1]

    @property
    def parts(self) -> tuple[str, ...]:  # type: ignore[override]  # depends on its extent
        """The far face of a block without thickness: of a gate that both sides feel."""
        return ("far_side",) if self.leaf else ()

    @property
    def pivot_point(self) -> Point:
        """Point of turning, m."""
        return self.pivot or (0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1]))

    @property
    def thickness(self) -> float:
        """The shorter side, m."""
        return min(self.x[1] - self.x[0], self.y[1] - self.y[0])

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """Smallest rectangle around it, m."""
        return super().extent if self.angle else (self.x, self.y)

    @property
    def moment_point(self) -> Point:
        """The corner that is the lower left one before it is turned, m."""
        return self._turned((self.x[0], self.y[0]))

    def corners(self) -> tuple[Point, ...]:
        """Lower left, lower right, upper right and upper left corner, turned, m."""
        (left, right), (low, high) = self.x, self.y
        return tuple(map(self._turned, ((left, low), (right, low), (right, high), (left, high))))

    def _turned(self, point: Point) -> Point:
        if not self.angle:
            return point
        (ox, oy), c, s = self.pivot_point, cos(radians(self.angle)), sin(radians(self.angle))
        dx, dy = point[0] - ox, point[1] - oy
        return ox + c * dx - s * dy, oy + s * dx + c * dy

    def chains(self) -> tuple[Chain]:
        """The outline, clockwise; of a block without thickness there and back."""
        lower_left, lower_right, upper_right, upper_left = self.corners()
        if self.leaf:
            return (Chain((lower_left, upper_right), closed=True),)
        return (Chain((lower_left, upper_left, upper_right, lower_right), closed=True),)

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """The rectangle."""
        return (np.array(self.corners()),)


@dataclass(frozen=True)
class Box(Wall):
    """A hollow axis-parallel rectangle with discs inside it: four faces, each pushing on its own.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        The inner extent, m.
    """

    kind: Literal["box"] = field(default="box", kw_only=True, repr=False)
    name: WallName
    x: Annotated[units.Extent, Field(description="from and to")]
    y: Annotated[units.Rise, Field(description="from and to")]
    hollow = True
    parts = ("x", "y", "left", "right", "bottom", "top")
    deep = True

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """x and y of the hole, m."""
        return self.x, self.y

    def chains(self) -> tuple[Chain]:
        """The outline, counter-clockwise."""
        (left, right), (low, high) = self.x, self.y
        return (Chain(((left, low), (right, low), (right, high), (left, high)), closed=True),)

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """The rectangle."""
        return (rectangle(self.x, self.y),)


@dataclass(frozen=True)
class _Drawn(Wall):
    """Fields that walls drawn by points have in common."""

    kind: str = field(kw_only=True, repr=False)
    name: WallName
    points: Points = ()
    sheet = False
    file: Annotated[
        FileName | None,
        Field(
            description="CSV file with the corners, columns x and y, in place of `points`; in the folder of the case "
            "or below. A first row may hold their names, and lines that begin with `#` are left out"
        ),
    ] = field(default=None, kw_only=True, repr=False)

    def __post_init__(self) -> None:
        if self.file is not None:
            raise ValueError("file: is read with a case file; give points here")
        _ = self.path

    @cached_property
    def path(self) -> Path:
        """The drawing, with the discs on its left."""
        raise NotImplementedError

    @property
    def moment_point(self) -> Point:
        """The first point, m."""
        return self.path.points[0]

    def bends_given(self) -> list[tuple[str, float]]:
        """Arcs among the points that turn to the side of the discs."""
        side = -1 if self.path.turned else 1
        arcs = ((i, point.radius) for i, point in enumerate(self.points) if isinstance(point, ArcTo))
        return [(f"points.{i}", abs(radius)) for i, radius in arcs if radius * side > 0 or self.sheet]


@dataclass(frozen=True)
class Polygon(_Drawn):
    """A closed outline of straight lines and arcs, solid or hollow.

    Parameters
    ----------
    name : str
    points : tuple of (float, float) or ArcTo
        Corners in order, either way round, m. The last is joined to the first.
    discs : {'outside', 'inside'}
        Where the discs are.

    Notes
    -----
    The moment is taken about the first point.
    """

    kind: Literal["polygon"] = field(default="polygon", kw_only=True, repr=False)
    discs: DiscsWhere = "outside"

    @cached_property
    def path(self) -> Path:
        """The outline: clockwise round a solid, else counter-clockwise."""
        return closed_path(self.points, clockwise=self.discs == "outside")

    @property
    def hollow(self) -> bool:  # type: ignore[override]  # depends on its fields
        """Tells whether the discs are inside."""
        return self.discs == "inside"

    def chains(self) -> tuple[Chain]:
        """The outline."""
        return (self.path.chain(),)


@dataclass(frozen=True)
class Line(_Drawn):
    """A line of straight pieces and arcs, with discs on its left or on both sides. A last point at the first closes it.

    Parameters
    ----------
    name : str
    points : tuple of (float, float) or ArcTo
        In order, m.
    sheet : bool
        Discs feel it from both sides.
    join : str, optional
        Lines of one such name whose ends meet are one wall, which has this name.

    Notes
    -----
    The moment is taken about the first point.
    """

    NO_FIELDS: ClassVar[dict[str, str]] = {
        "discs": "the discs of a line are on its left; reverse its points, or take sheet: true for both sides"
    }
    kind: Literal["line"] = field(default="line", kw_only=True, repr=False)
    sheet: Annotated[bool, Field(description="discs feel it from both sides")] = False
    join: Annotated[
        WallName | None,
        Field(
            description="lines with the same `join` whose ends meet are one wall, with the name of the join. Without "
            "it, discs at a common end feel both walls"
        ),
    ] = None

    @cached_property
    def path(self) -> Path:
        """The line as given."""
        return drawn(self.points, least=2)

    @property
    def hollow(self) -> bool:  # type: ignore[override]  # depends on its fields
        """Tells whether it closes round the discs."""
        return self.path.closed and not self.sheet and self.path.area > 0

    @property
    def thickness(self) -> float:
        """0 of a sheet."""
        return 0.0 if self.sheet else inf

    def chains(self) -> tuple[Chain, ...]:
        """The line; of a sheet there and back."""
        if not self.sheet:
            return (self.path.chain(),)
        back = self.path.reversed()
        if self.path.closed:
            return self.path.chain(), back.chain()
        return (Path(self.path.points + back.points[1:-1], self.path.bends + back.bends, closed=True).chain(),)


@dataclass(frozen=True)
class Circle(Wall):
    """A circle with discs outside or inside.

    Parameters
    ----------
    name : str
    centre : (float, float)
        m.
    radius : float
        m.
    discs : {'outside', 'inside'}
        Where the discs are.

    Notes
    -----
    The moment is taken about the centre.
    """

    kind: Literal["circle"] = field(default="circle", kw_only=True, repr=False)
    name: WallName
    centre: Annotated[units.Point, Field(description="[x, y]")]
    radius: Annotated[units.Length, Field(description="of the circle")]
    discs: DiscsWhere = "outside"

    @property
    def hollow(self) -> bool:  # type: ignore[override]  # depends on its fields
        """Tells whether the discs are inside."""
        return self.discs == "inside"

    @property
    def moment_point(self) -> Point:
        """The centre, m."""
        return self.centre

    @property
    def thickness(self) -> float:
        """The diameter of a solid one, m."""
        return inf if self.hollow else 2 * self.radius

    def bends_given(self) -> list[tuple[str, float]]:
        """The radius of a hollow one."""
        return [("radius", self.radius)] if self.hollow else []

    def chains(self) -> tuple[Chain]:
        """Four quarters."""
        return (circle(self.centre, self.radius, inside=self.hollow),)


KINDS = Plane | Block | Box | Polygon | Line | Circle
"""Walls that a case file may name."""


def bed_height(walls: Sequence[Wall], x: ArrayLike, smallest: float) -> np.ndarray:
    """Height of the bed at x, m, of shape of `x`; NaN where nothing lies below.

    It is the highest top of the walls, of those that solids below carry without a gap that the smallest disc (m) could
    pass, tried from the lowest underside up. A solid above such a gap (a sluice gate) is no bed.
    """
    return bed_over([solid for wall in walls for solid in wall.grounds(np.asarray(x, float))], x, smallest)
