# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces of the discs as arrows on the outlines of structures, for films and pictures: resultant, and pressure.

The arrow of a resultant ends where its line of action enters the outline: its moment is that of the record. The arrows
of pressure are drawn on the stretches over which it was summed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from math import floor, hypot, log10
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.walls import StretchForces, read_pressure
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import MovingWall, reference
from lammps_jump.scene.walls import Interval, Wall, parts_of
from lammps_jump.units import KILO

from .painter import View, paint_arrow

FORCE, PRESSURE = (179, 38, 58), (214, 120, 20)
"""Colours; in grey the first is the darker one, and thick."""
LONGEST, DEEPEST = (1 / 3, 1 / 9), (1 / 5, 1 / 18)
"""Lengths of the largest force and pressure, in heights and in widths of the picture: the longer one."""
LARGE = 0.995
"""Quantile that is called the largest."""
SEEN = 0.01
"""Share of the largest below which there is no arrow."""
ROUND = (5.0, 2.0, 1.0)


class FaceArrow(NamedTuple):
    """An arrow that ends on an outline: its tip, m, and the force or pressure along x and y, N/m or Pa."""

    tip: tuple[float, float]
    size: tuple[float, float]


class ScaleArrow(NamedTuple):
    """An arrow of round size that tells the scale of others: in words, and metres of the picture."""

    text: str
    length: float
    colour: tuple[int, int, int]


class Rigid(NamedTuple):
    """Way of a wall from where the case has it: places z of the plane come to turn z + shift."""

    turn: complex
    shift: complex

    @classmethod
    def between(cls, before: np.ndarray, now: np.ndarray) -> Rigid:
        """The way of an outline, both of shape (corners, 2), m, by least squares."""
        a, b = (points @ np.array([1.0, 1j]) for points in (before, now))
        sum_ = np.vdot(a - a.mean(), b - b.mean())
        turn = complex(sum_ / abs(sum_)) if abs(sum_) > 0 else 1.0 + 0j
        return cls(turn, complex(b.mean() - turn * a.mean()))

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Place to which a point comes, m."""
        there = self.turn * complex(x, y) + self.shift
        return there.real, there.imag

    def way(self, x: float, y: float) -> tuple[float, float]:
        """A direction, turned."""
        there = self.turn * complex(x, y)
        return there.real, there.imag


def entry(
    ring: np.ndarray, point: tuple[float, float], force: tuple[float, float], moment: float, *, last: bool = False
) -> tuple[float, float]:
    """Place where the line of action of a force enters an outline.

    Parameters
    ----------
    ring : ndarray, shape (corners, 2), m
        Corners of a closed outline.
    point : (float, float), m
        Point of the moment.
    force : (float, float), N/m
    moment : float, N m/m
        Anticlockwise about that point.
    last : bool
        The place where it leaves, for walls with the discs inside.

    Returns
    -------
    (float, float)
        M = r x F holds for it; where the line passes by the outline, the corner next to the line.
    """
    size = hypot(*force)
    way = np.array(force) / size
    base = np.array(point) + moment / size**2 * np.array([force[1], -force[0]])
    off = ring - base
    along, across = off @ way, off @ np.array([-way[1], way[0]])
    other_along, other_across = np.roll(along, -1), np.roll(across, -1)
    crosses = (across <= 0) != (other_across <= 0)
    if not crosses.any():
        corner = ring[int(np.argmin(np.abs(across)))]
        return float(corner[0]), float(corner[1])
    share = across[crosses] / (across[crosses] - other_across[crosses])
    places = along[crosses] + share * (other_along[crosses] - along[crosses])
    at = base + (places.max() if last else places.min()) * way
    return float(at[0]), float(at[1])


@dataclass(frozen=True)
class ForceArrows:
    """Records of a flow that are drawn on its structures.

    Attributes
    ----------
    flow : Flow
    forces : mapping of str to ForceHistory
        By the names of walls and bodies; others are left out.
    pressure : StretchForces or None
        On the stretches of the scene.
    """

    flow: Flow
    forces: Mapping[str, ForceHistory]
    pressure: StretchForces | None = None

    @classmethod
    def recorded(cls, flow: Flow, forces: Mapping[str, ForceHistory], pressure: Path | None) -> ForceArrows | None:
        """Arrows of a run, by its record of forces and the file of its pressure; None without forces.

        A file of pressure that cannot be read gives none: the analysis says what is wrong with it.
        """
        if not forces:
            return None
        record = None
        if pressure is not None:
            with suppress(DumpError):
                record = read_pressure(pressure, flow.scene)
        return cls(flow, forces, record)

    @cached_property
    def _known(self) -> dict[str, ForceHistory]:
        walls = {wall.name for wall, _ in self.flow.scene.standing}
        return {name: one for name, one in self.forces.items() if name in walls and len(one.time)}

    @cached_property
    def _bins(self) -> list[int]:
        return [k for k, one in enumerate(self.flow.scene.pressure) if not one.gauge]

    @cached_property
    def largest(self) -> float:
        """Largest resultant, N/m; 0 without any."""
        return max((float(np.quantile(np.hypot(h.fx, h.fy), LARGE)) for h in self._known.values()), default=0.0)

    @cached_property
    def largest_pressure(self) -> float:
        """Largest pressure on a stretch, Pa; 0 without any."""
        if self.pressure is None or not self._bins or not len(self.pressure.time):
            return 0.0
        widths = np.array([self.flow.scene.pressure[k].width for k in self._bins])
        return float(max(np.quantile(self.pressure.across[:, self._bins] / widths, LARGE), 0.0))

    def resultants(self, time: float, walls: Sequence[Wall], x: Interval, y: Interval) -> list[FaceArrow]:
        """Forces at a time (s) on walls where they are, within a part of the plane, m."""
        arrows = []
        for wall in walls:
            if (history := self._known.get(wall.name)) is None:
                continue
            fx, fy, moment = (
                float(np.interp(time, history.time, part)) for part in (history.fx, history.fy, history.moment)
            )
            if hypot(fx, fy) <= SEEN * self.largest:
                continue
            rings, lines = parts_of(wall, x, y)
            ring = np.concatenate([*rings, *lines])
            point = self._way(wall).place(*reference(self._case_wall(wall.name)))
            arrows.append(FaceArrow(entry(ring, point, (fx, fy), moment, last=wall.hollow), (fx, fy)))
        return arrows

    def pressures(self, time: float, walls: Sequence[Wall]) -> list[FaceArrow]:
        """Pressure at a time (s) on the stretches of walls where they are."""
        if not self.largest_pressure > 0 or self.pressure is None:
            return []
        there = {wall.name: self._way(wall) for wall in walls}
        arrows = []
        for k in self._bins:
            one = self.flow.scene.pressure[k]
            value = float(np.interp(time, self.pressure.time, self.pressure.across[:, k])) / one.width
            if one.wall in there and value > SEEN * self.largest_pressure:
                tx, ty = there[one.wall].way(*one.along)  # the discs are left of it
                arrows.append(FaceArrow(there[one.wall].place(*one.place), (value * ty, -value * tx)))
        return arrows

    def _case_wall(self, name: str) -> MovingWall:
        return next(one for one in self.flow.scene.walls if one.wall.name == name)

    def _way(self, wall: Wall) -> Rigid:
        """Way of a wall from where the case has it."""
        case = self._case_wall(wall.name).wall
        if case == wall or not wall.finite:
            return Rigid(1.0 + 0j, 0j)
        rings = [np.concatenate(one.outline((0.0, 0.0), (0.0, 0.0))) for one in (case, wall)]
        return Rigid.between(*rings)

    def _kinds(self, view: View) -> list[tuple[float, float, str, tuple[int, int, int]]]:
        """Of pressure, then of forces: largest, metres of the picture for one unit, unit in kilo, colour."""
        high, wide = (end - begin for begin, end in (view.y, view.x))
        return [
            (largest, max(shares[0] * high, shares[1] * wide) / largest if largest > 0 else 0.0, unit, colour)
            for largest, shares, unit, colour in (
                (self.largest_pressure, DEEPEST, "kPa", PRESSURE), (self.largest, LONGEST, "kN/m", FORCE),
            )
        ]  # fmt: skip

    def scales(self, view: View) -> list[ScaleArrow]:
        """Arrows that tell the scales of a view: one of a round force, and one of a round pressure."""
        return [
            ScaleArrow(f"{size / KILO:zg} {unit}", size * metres, colour)
            for largest, metres, unit, colour in reversed(self._kinds(view))
            if largest > 0
            for size in [rounded(0.6 * largest)]
        ]

    def paint(self, picture: np.ndarray, view: View, time: float, walls: Sequence[Wall]) -> None:
        """Paint the arrows of a time (s) into a picture; their tips are on the outlines."""
        pressure, force = self._kinds(view)
        thick = max(3.0, view.height / 90)
        for arrows, metres, wide, colour in (
            (self.pressures(time, walls), pressure[1], max(0.4 * thick, 1.5), PRESSURE),
            (self.resultants(time, walls, view.x, view.y), force[1], thick, FORCE),
        ):
            for (x, y), size in arrows:
                start = x - metres * size[0], y - metres * size[1]
                ends = [(float(view.column(px)), float(view.row(py))) for px, py in (start, (x, y))]
                paint_arrow(picture, ends[0], ends[1], wide, colour)


def rounded(value: float) -> float:
    """Largest of 1, 2 and 5 times a power of ten that is not above a value."""
    power = 10.0 ** floor(log10(value))
    return next(power * first for first in ROUND if power * first <= value * (1 + 1e-9))
