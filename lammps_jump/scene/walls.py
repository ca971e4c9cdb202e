# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that discs meet. The class that checks a wall of a case file is the wall.

A wall answers what engines, drawing and analysis ask. Each answer follows from `Wall.faces`, the planes and rectangles
that push, unless a wall knows better. Distances are of disc centres: a disc of radius R touches below R.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from lammps_jump.quoting import LONGEST_NAME
from lammps_jump.units import Metre

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


class Contact(NamedTuple):
    """Distance (m) of points to a face, and the unit normal of its push; a zero normal where it does not push."""

    distance: np.ndarray
    nx: np.ndarray
    ny: np.ndarray


class Floor(NamedTuple):
    """A level floor: its interval of x, underside and top, m. The underside is minus infinity if nothing fits below."""

    x: Interval
    underside: float
    top: float


def _in_a_file(schema: dict[str, Any], wall: type) -> None:
    """JSON schema of a wall in a case file: its kind comes first and must be given."""
    kind = schema["properties"].pop("kind")
    del kind["default"]
    schema["properties"] = {"kind": kind, **schema["properties"]}
    schema["required"] = ["kind", *schema["required"]]
    schema["description"] = (wall.__doc__ or "").splitlines()[0]


class Wall:
    """What every wall answers. A new wall is a frozen dataclass with `kind`, `name` and fields, and `faces`."""

    __pydantic_config__ = ConfigDict(extra="forbid", json_schema_extra=_in_a_file)
    name: str
    hollow: ClassVar[bool] = False
    """Whether the discs are inside the outline."""
    parts: tuple[str, ...] = ()
    """Endings behind the name that scripts use for parts of the wall; no other wall may have such a name."""

    def faces(self) -> tuple[Plane | Block, ...]:
        """Planes and rectangles that push, each on its own."""
        raise NotImplementedError

    def contacts(self, x: np.ndarray, y: np.ndarray) -> list[Contact]:
        """Contact of points with each face; arrays of x's shape."""
        return [face.contact(x, y) for face in self.faces()]

    def distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance of points to the nearest face, m; negative inside the solid."""
        return reduce(np.minimum, [contact.distance for contact in self.contacts(x, y)])

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """Smallest rectangle (x, y) around the faces, m; infinite where they have no end."""
        (x_low, x_high), (y_low, y_high) = np.transpose([face.extent for face in self.faces()], (1, 2, 0))
        return (float(min(x_low)), float(max(x_high))), (float(min(y_low)), float(max(y_high)))

    @property
    def finite(self) -> bool:
        """Whether the wall ends in every direction."""
        return bool(np.isfinite(self.extent).all())

    @property
    def moment_point(self) -> tuple[float, float]:
        """Point about which the moment on the wall is taken, m: the lower left corner; 0 where the wall has no end."""
        x, y = (low if np.isfinite(low) else 0.0 for low, _ in self.extent)
        return x, y

    def room(self, axis: str) -> Interval:
        """Interval of a coordinate that the wall leaves to the discs, m; infinite where it sets no bound."""
        low, high = zip(*(face.room(axis) for face in self.faces()), strict=True)
        return max(low), min(high)

    def floors(self) -> tuple[Floor, ...]:
        """Floors that discs may flow on."""
        return tuple(floor for face in self.faces() for floor in face.floors())

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """Closed polygons of the solid within x and y, each of shape (corners, 2), m; of the hole if `hollow`."""
        return tuple(polygon for face in self.faces() for polygon in face.outline(x, y))


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
    name: WallName
    axis: Literal["x", "y"]
    at: Coordinate
    side: Side

    @property
    def sign(self) -> float:
        """+1 where the discs are above the plane, -1 below."""
        return 1.0 if self.side == "above" else -1.0

    @property
    def primitive(self) -> tuple[str, tuple[float, float, float, float]]:
        """Name of the shape and its numbers, for engines: at (m), sign, 0, 0."""
        return f"plane_{self.axis}", (self.at, self.sign, 0.0, 0.0)

    def faces(self) -> tuple[Plane]:
        """The plane itself."""
        return (self,)

    def contact(self, x: np.ndarray, y: np.ndarray) -> Contact:
        """Distance (m) and normal at each point."""
        distance = self.sign * (np.asarray(x if self.axis == "x" else y, float) - self.at)
        normal, zero = np.full_like(distance, self.sign), np.zeros_like(distance)
        return Contact(distance, *((normal, zero) if self.axis == "x" else (zero, normal)))

    @property
    def extent(self) -> tuple[Interval, Interval]:
        """A line: one coordinate fixed, the other from minus infinity to infinity, m."""
        here, endless = (self.at, self.at), (-inf, inf)
        return (here, endless) if self.axis == "x" else (endless, here)

    def room(self, axis: str) -> Interval:
        """One side of the plane, along its own axis, m."""
        if axis != self.axis:
            return -inf, inf
        return (self.at, inf) if self.side == "above" else (-inf, self.at)

    def floors(self) -> tuple[Floor, ...]:
        """An endless floor, where the discs are above a level plane."""
        return (Floor((-inf, inf), -inf, self.at),) if (self.axis, self.side) == ("y", "above") else ()

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
    Signed distance: with q = (max(xlo-x, x-xhi), max(ylo-y, y-yhi)), ``|max(q, 0)| + min(max(qx, qy), 0)``.
    A disc touches the block at one point, the nearest, as at LAMMPS' ``region block … side out``; a corner rounds the
    distance. A centre inside the block feels no force.
    """

    kind: Literal["block"] = field(default="block", kw_only=True, repr=False)

    @property
    def parts(self) -> tuple[str, ...]:  # type: ignore[override]  # depends on its extent
        """The far face of a block without thickness: of a gate that both sides feel."""
        return ("far_side",) if self.x[0] == self.x[1] else ()

    @property
    def primitive(self) -> tuple[str, tuple[float, float, float, float]]:
        """Name of the shape and its numbers, for engines: xlo, xhi, ylo, yhi (m)."""
        return "rectangle", (*self.x, *self.y)

    def faces(self) -> tuple[Block]:
        """The rectangle itself."""
        return (self,)

    def contact(self, x: np.ndarray, y: np.ndarray) -> Contact:
        """Distance (m) and outward normal at the nearest point of the surface."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        dx, dy = x - np.clip(x, *self.x), y - np.clip(y, *self.y)
        outside = np.hypot(dx, dy)
        inner_x = np.maximum(self.x[0] - x, x - self.x[1])
        inner_y = np.maximum(self.y[0] - y, y - self.y[1])
        safe = np.where(outside > 0, outside, 1.0)
        return Contact(np.where(outside > 0, outside, np.maximum(inner_x, inner_y)), dx / safe, dy / safe)

    def room(self, axis: str) -> Interval:
        """No bound: discs may be on every side."""
        return -inf, inf

    def floors(self) -> tuple[Floor, ...]:
        """The top of the rectangle."""
        return (Floor(self.x, *self.y),)


@dataclass(frozen=True)
class Box(_Rectangle):
    """A hollow axis-parallel rectangle with discs inside it: four planes, each pushing on its own.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        The inner extent, m.
    """

    kind: Literal["box"] = field(default="box", kw_only=True, repr=False)
    hollow = True
    parts = ("x", "y", "left", "right", "bottom", "top")

    def faces(self) -> tuple[Plane, Plane, Plane, Plane]:
        """The four planes, in the order left, right, bottom, top."""
        return (
            Plane(f"{self.name}_left", "x", self.x[0], "above"),
            Plane(f"{self.name}_right", "x", self.x[1], "below"),
            Plane(f"{self.name}_bottom", "y", self.y[0], "above"),
            Plane(f"{self.name}_top", "y", self.y[1], "below"),
        )

    def floors(self) -> tuple[Floor, ...]:
        """The bottom, within the box."""
        return (Floor(self.x, -inf, self.y[0]),)


KINDS = Plane | Block | Box
"""Walls that a case file may name."""
