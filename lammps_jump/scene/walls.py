# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that discs meet. The class that checks a wall of a case file is the wall.

A wall answers what engines, drawing and analysis ask. Each answer follows from `Wall.chains`, the faces that push,
unless a wall knows better. Distances are of disc centres: a disc of radius R touches below R.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from math import inf
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from lammps_jump.quoting import LONGEST_NAME
from lammps_jump.units import Metre, Plain, Stiffness

from .chains import Chain, Faces, boxes, distance, grounds, lay, outline
from .tracks import KINDS as KINDS_OF_MOTION

Interval = tuple[float, float]


def ordered(value: Interval) -> Interval:
    """The interval itself; ValueError where its ends are not in order."""
    if value[0] >= value[1]:
        raise ValueError(f"[{value[0]:g}, {value[1]:g}] runs backwards; expected [low, high] with low < high")
    return value


SIDES = {"right": "above", "left": "below", "high": "above", "low": "below", "+": "above", "-": "below"}
"""Other words for the side of a plane."""

Coordinate = Annotated[Metre, Field(ge=-1e6, le=1e6)]
Extent = Annotated[tuple[Coordinate, Coordinate], AfterValidator(ordered)]
Side = Annotated[
    Literal["above", "below"],
    BeforeValidator(lambda value: SIDES.get(value, value) if isinstance(value, str) else value),
    Field(description="where the discs are: at larger or smaller coordinates"),
]
WallName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_]+$", max_length=LONGEST_NAME)]
"""Part of the names of LAMMPS fixes, regions and variables, which take no other letters."""


def _in_a_file(schema: dict[str, Any], wall: type) -> None:
    """JSON schema of a wall in a case file: its kind comes first and must be given."""
    kind = schema["properties"].pop("kind")
    del kind["default"]
    own = {name: schema["properties"].pop(name) for name in (part.name for part in fields(_Own))}
    schema["properties"] = {"kind": kind, **schema["properties"], **own}
    schema["required"] = ["kind", *schema["required"]]
    schema["description"] = (wall.__doc__ or "").splitlines()[0]


Motions = Annotated[KINDS_OF_MOTION, Field(discriminator="kind")]


@dataclass(frozen=True, kw_only=True)
class _Own:
    """What any wall may have of its own: numbers of its contacts, and a motion."""

    friction: Annotated[Annotated[Plain, Field(ge=0, le=1000)] | None, Field(description="default: of contact")] = (
        field(default=None, repr=False)
    )
    restitution: Annotated[Annotated[Plain, Field(ge=1e-6, le=1)] | None, Field(description="default: of contact")] = (
        field(default=None, repr=False)
    )
    stiffness: Annotated[
        Annotated[Stiffness, Field(ge=1e-6, le=1e24)] | None, Field(description="default: contact.stiffness_wall")
    ] = field(default=None, repr=False)
    motion: Annotated[Motions | None, Field(description="how it moves; null: it stands")] = field(
        default=None, repr=False
    )


class Wall(_Own):
    """What every wall answers. A new wall is a frozen dataclass with `kind`, `name` and fields, and `chains`."""

    __pydantic_config__ = ConfigDict(extra="forbid", serialize_by_alias=True, json_schema_extra=_in_a_file)
    kind: str
    name: str
    hollow: ClassVar[bool] = False
    """Whether the discs are inside the outline."""
    deep: ClassVar[bool] = False
    """Whether discs behind a face are pushed back from any depth, and not from their radius alone."""
    parts: tuple[str, ...] = ()
    """Endings behind the name that scripts use for parts of the wall; no other wall may have such a name."""

    def chains(self) -> tuple[Chain, ...]:
        """Chains of faces that push, drawn with the discs on their left."""
        raise NotImplementedError

    @cached_property
    def faces(self) -> Faces:
        """The chains as flat arrays."""
        return lay([(self.chains(), self.deep)])

    def distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
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
        """Whether the wall ends in every direction."""
        return bool(np.isfinite(self.extent).all())

    @property
    def own_law(self) -> tuple[float | None, float | None, float | None]:
        """Stiffness (N/m), restitution and friction coefficient of its own; all None: those of the scene."""
        return self.stiffness, self.restitution, self.friction

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


def rectangle(x: Interval, y: Interval) -> np.ndarray:
    """Corners of a rectangle, shape (4, 2), m."""
    return np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])


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
    axis: Literal["x", "y"]
    at: Coordinate
    side: Side

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


@dataclass(frozen=True)
class _Rectangle(Wall):
    """What solid and hollow rectangles have in common."""

    kind: str = field(kw_only=True, repr=False)
    name: WallName
    x: Extent
    y: Extent

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """The rectangle's x and y, m; of the hole if `hollow`."""
        return self.x, self.y

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """The rectangle."""
        return (rectangle(self.x, self.y),)


@dataclass(frozen=True)
class Block(_Rectangle):
    """A solid axis-parallel rectangle; discs outside it.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        Its extent, m.

    Notes
    -----
    A disc touches the block at one point, the nearest, as at LAMMPS' ``region block … side out``; a corner rounds the
    distance. A centre inside the block, less than a radius deep, is pushed out along the nearest face. (LAMMPS' region
    has no force there.)
    """

    kind: Literal["block"] = field(default="block", kw_only=True, repr=False)

    @property
    def parts(self) -> tuple[str, ...]:  # type: ignore[override]  # depends on its extent
        """The far face of a block without thickness: of a gate that both sides feel."""
        return ("far_side",) if self.x[0] == self.x[1] else ()

    def chains(self) -> tuple[Chain]:
        """The outline, clockwise; of a block without thickness there and back."""
        (left, right), (low, high) = self.x, self.y
        if left == right:
            return (Chain(((left, low), (left, high)), closed=True),)
        return (Chain(((left, low), (left, high), (right, high), (right, low)), closed=True),)


@dataclass(frozen=True)
class Box(_Rectangle):
    """A hollow axis-parallel rectangle with discs inside it: four faces, each pushing on its own.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        The inner extent, m.
    """

    kind: Literal["box"] = field(default="box", kw_only=True, repr=False)
    hollow = True
    parts = ("x", "y", "left", "right", "bottom", "top")

    deep = True

    def chains(self) -> tuple[Chain]:
        """The outline, counter-clockwise."""
        (left, right), (low, high) = self.x, self.y
        return (Chain(((left, low), (right, low), (right, high), (left, high)), closed=True),)


KINDS = Plane | Block | Box
"""Walls that a case file may name."""
