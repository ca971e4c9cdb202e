"""Walls that discs meet: immutable, shared by the script generator, both engines and the analysis.

Every wall answers one question: how far is a point from the surface, and in which direction does the surface
push? The distance is measured for disc centres; a disc of radius R touches where the distance is below R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Plane:
    """An endless straight wall.

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

    name: str
    axis: str
    at: float
    side: str

    @property
    def sign(self) -> float:
        """+1 where the discs are above the plane, -1 below."""
        return 1.0 if self.side == "above" else -1.0

    def contacts(self, x: np.ndarray, y: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Distances and unit normals of every face: one tuple (distance, nx, ny), each of x's shape."""
        coordinate = x if self.axis == "x" else y
        distance = self.sign * (np.asarray(coordinate, float) - self.at)
        normal = np.full_like(distance, self.sign)
        zero = np.zeros_like(distance)
        return [(distance, normal, zero) if self.axis == "x" else (distance, zero, normal)]

    def signed_distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance (m) of points to the surface, negative inside the wall."""
        return self.contacts(x, y)[0][0]


@dataclass(frozen=True, slots=True)
class Block:
    """A solid axis-parallel rectangle with discs outside it.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        Its extent, m.

    Notes
    -----
    Signed distance: with q = (max(xlo-x, x-xhi), max(ylo-y, y-yhi)), ``|max(q, 0)| + min(max(qx, qy), 0)``.
    A disc touches the block at one point, the nearest (a corner rounds the distance), as LAMMPS' ``region block
    … side out`` does; a centre inside the block feels no force at all, there and here.
    """

    name: str
    x: Interval
    y: Interval

    def contacts(self, x: np.ndarray, y: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Distance and outward unit normal at the nearest point: one tuple (distance, nx, ny)."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        dx = x - np.clip(x, *self.x)
        dy = y - np.clip(y, *self.y)
        outside = np.hypot(dx, dy)
        inner_x = np.maximum(self.x[0] - x, x - self.x[1])
        inner_y = np.maximum(self.y[0] - y, y - self.y[1])
        distance = np.where(outside > 0, outside, np.maximum(inner_x, inner_y))
        safe = np.where(outside > 0, outside, 1.0)
        return [(distance, dx / safe, dy / safe)]

    def signed_distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance (m) of points to the surface, negative inside the block."""
        return self.contacts(x, y)[0][0]


@dataclass(frozen=True, slots=True)
class Box:
    """A hollow axis-parallel rectangle with discs inside it: four faces, each pushing on its own.

    Parameters
    ----------
    name : str
    x, y : (float, float)
        The inner extent, m.

    Notes
    -----
    Signed distance: the least of the distances to the four faces.
    """

    name: str
    x: Interval
    y: Interval

    def faces(self) -> tuple[Plane, Plane, Plane, Plane]:
        """The four planes, in the order left, right, bottom, top."""
        return (
            Plane(f"{self.name}_left", "x", self.x[0], "above"),
            Plane(f"{self.name}_right", "x", self.x[1], "below"),
            Plane(f"{self.name}_bottom", "y", self.y[0], "above"),
            Plane(f"{self.name}_top", "y", self.y[1], "below"),
        )

    def contacts(self, x: np.ndarray, y: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Distances and unit normals of the four faces, in the order of `faces`."""
        return [face.contacts(x, y)[0] for face in self.faces()]

    def signed_distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Distance (m) of points to the nearest face, negative outside the box."""
        return np.min([distance for distance, _, _ in self.contacts(x, y)], axis=0)


Wall = Plane | Block | Box
