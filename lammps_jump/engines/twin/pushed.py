# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that are pushed, lids and bodies: kick, drift, and the effective masses of their contacts."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.core.columns import LoadColumns, Phase, PlacedColumns, PushedColumns, StepClockColumns, WallMotion
from lammps_jump.core.law import LawNumbers
from lammps_jump.engines.native.arrays import Moves
from lammps_jump.physics.elementary import cos, sin

Vector = Sequence[float] | np.ndarray


def wrench(force: Vector, point: Vector, about: Vector) -> np.ndarray:
    """A force and its moment about a point."""
    return np.array([*force, (point[0] - about[0]) * force[1] - (point[1] - about[1]) * force[0]])


def _resistance(moves: Moves, wall: int) -> np.ndarray:
    """Mass along x and y, and moment of inertia."""
    mass = moves.load[wall, LoadColumns.MASS]
    return np.array([mass, mass, moves.load[wall, LoadColumns.INERTIA]])


def _whole_force(moves: Moves, wall: int) -> np.ndarray:
    """Force of what touches the wall and its constant force, with their moment about the point of turning."""
    force, arm = moves.load[wall, LoadColumns.FORCE], moves.load[wall, LoadColumns.ARM]
    angle = moves.pushed[wall, PushedColumns.PLACE][2]
    c, s = cos(angle), sin(angle)
    turned = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
    return moves.pushed[wall, PushedColumns.FORCE] + wrench(force, turned, (0.0, 0.0))


def drift(moves: Moves, step: int) -> None:
    """Kick and drift of the walls that are pushed, as of discs, to a step; a first kick is half a step long."""
    start, dt = moves.clock[StepClockColumns.START], moves.clock[StepClockColumns.DT]
    for wall in np.flatnonzero(moves.moving >= WallMotion.LOADED).tolist():
        begin = moves.load[wall, LoadColumns.BEGIN]
        if not (step - start) * dt > begin:
            continue
        kick = 0.5 * dt if (step - 1 - start) * dt <= begin else dt
        free, row = moves.load[wall, LoadColumns.FREE] > 0.0, moves.pushed[wall]
        change = kick * _whole_force(moves, wall) / _resistance(moves, wall)
        speed = row[PushedColumns.SPEED]
        row[PushedColumns.BEFORE][free] = speed[free]
        speed[free] += change[free]
        row[PushedColumns.PLACE][free] += dt * speed[free]


def follow(moves: Moves, wall: int, time: float) -> None:
    """Place a wall that is pushed at a time, s."""
    row, now, begin = moves.pushed[wall], moves.now[wall], moves.load[wall, LoadColumns.BEGIN]
    phase = Phase.HAS_MOVED if time > begin else Phase.IS_HELD if time < begin else Phase.IS_RELEASED
    row[PushedColumns.PHASE] = phase
    now[PlacedColumns.NOW] = row[PushedColumns.PLACE]
    angle, speed = row[PushedColumns.PLACE][2], row[PushedColumns.SPEED]
    now[PlacedColumns.C], now[PlacedColumns.S] = cos(angle), sin(angle)
    now[PlacedColumns.RATE] = 0.0 if phase == Phase.IS_HELD else speed
    extrapolates = moves.moving[wall] == WallMotion.BODY and moves.clock[StepClockColumns.EXTRAPOLATES] > 0.0
    if extrapolates and phase == Phase.HAS_MOVED:  # thesis (3.7)-(3.9)
        now[PlacedColumns.RATE] = 1.5 * speed - 0.5 * row[PushedColumns.BEFORE]


def centre(moves: Moves, wall: int) -> None:
    """Velocity of a wall that is pushed at a step, with the force of that step."""
    row, half = moves.pushed[wall], 0.0
    free = (moves.load[wall, LoadColumns.FREE] > 0.0) & (row[PushedColumns.PHASE] != Phase.IS_HELD)
    if row[PushedColumns.PHASE] == Phase.HAS_MOVED:
        half = 0.5 * moves.clock[StepClockColumns.DT] * _whole_force(moves, wall) / _resistance(moves, wall)
    moves.now[wall, PlacedColumns.CENTRED] = np.where(free, row[PushedColumns.SPEED] + half, 0.0)


LEAST = 0.25
"""Least share of what a contact gives way alone: a corner of an even convex outline has a half or more."""


def gives_way(moves: Moves | None, wall: int) -> bool:
    """Tell whether forces move a wall now: not while it is held, nor a tailgate, whose mass is infinite."""
    if moves is None or moves.moving[wall] < WallMotion.LOADED:
        return False
    held = moves.pushed[wall, PushedColumns.PHASE] == Phase.IS_HELD
    return not held and isfinite(moves.load[wall, LoadColumns.MASS])


def about(moves: Moves, wall: int) -> np.ndarray:
    """Point of turning of a wall, where it is, m."""
    return moves.centre[wall] + moves.now[wall, PlacedColumns.NOW][:2]


def yielding(moves: Moves | None, wall: int, push: np.ndarray) -> float:
    """Twice the kinetic energy that an impulse along x and y and of its moment gives to a wall.

    Of a force of 1 N along a normal it is what the wall gives way there, 1/kg.
    """
    if moves is None or not gives_way(moves, wall):
        return 0.0
    load = moves.load[wall]
    mass, inertia, free = load[LoadColumns.MASS], load[LoadColumns.INERTIA], load[LoadColumns.FREE]
    return float((free[0] * push[0] ** 2 + free[1] * push[1] ** 2) / mass + free[2] * push[2] ** 2 / inertia)


def yielding_at(moves: Moves | None, wall: int, point: Vector, way: Vector) -> float:
    """Acceleration of a wall by a force of 1 N at a point along a direction, 1/kg."""
    if moves is None or not gives_way(moves, wall):
        return 0.0
    return yielding(moves, wall, wrench(way, point, about(moves, wall)))


class DiscMass(NamedTuple):
    """Mass and inertia of a disc in its contact with a body: kg and kg m^2, per m of width."""

    mass: float
    inertia: float
    fixed: bool

    def size(self, yields: float, unit: float) -> float:
        """Root of an effective mass over `unit` (kg), where the body gives way by `yields` (1/kg)."""
        inverse = (0.0 if self.fixed else 1.0 / self.mass) + yields
        return sqrt(1.0 / (inverse * unit)) if inverse > 0.0 else sqrt(self.mass / unit)

    def rolls(self, turns: float) -> float:
        """Root of what resists rolling over the same at a wall; `turns`: rad/s of the body for 1 N m s, 1/(kg m)."""
        at_wall = 1.0 / self.inertia
        inverse = (0.0 if self.fixed else at_wall) + turns
        return sqrt(at_wall / inverse) if inverse > 0.0 else 1.0


def law_at_body(
    law: LawNumbers, unit: float, disc: DiscMass, moves: Moves, wall: int, point: Vector, normal: Vector
) -> LawNumbers:
    """Numbers of a contact of a disc with a body, from those of a disc of the mass `unit` (kg/m) with a wall."""
    along = disc.size(yielding_at(moves, wall, point, normal), unit)
    across = disc.size(yielding_at(moves, wall, point, (-normal[1], normal[0])), unit)
    turns = yielding(moves, wall, np.array([0.0, 0.0, 1.0]))
    return law._replace(
        damping=law.damping * along,
        tangential=law.tangential * across,
        spring_damping=law.spring_damping * across / along,
        rolling_damping=law.rolling_damping * disc.rolls(turns),
    )


def law_between(law: LawNumbers, lag: float, along: float, across: float) -> LawNumbers:
    """Numbers of a contact whose two give way by this much along the normal and across it, 1/kg."""
    slips = across if across > 0.0 else along  # the latter: no force moves the two that way
    dashpot, other = (max(law.damping / sqrt(yields) - lag, 0.0) for yields in (along, slips))
    ratio = law.spring_damping * other / dashpot if dashpot > 0.0 else 0.0
    return law._replace(damping=dashpot, tangential=law.tangential / sqrt(slips), spring_damping=ratio)


class SharedContact(NamedTuple):
    """A contact along its normal or across it.

    Attributes
    ----------
    walls : (int, int)
        Of its corner and of its face.
    point, direction : (float, float)
        Where the two feel each other, m, and a unit vector.
    speed : float
        Of the first against the second along it, m/s.
    alone : float
        What the two give way to a force of 1 N there, 1/kg.
    """

    walls: tuple[int, int]
    point: Vector
    direction: Vector
    speed: float
    alone: float


def shared(moves: Moves, ways: Sequence[SharedContact]) -> list[float]:
    """Acceleration of two walls by all contacts between them at once, as these move, for each of the contacts, 1/kg.

    The sum of v_i A_ij v_j over that of v_i^2, with the velocity that contact i has from 1 N at contact j as A_ij. It
    is exact where all contacts move as one mode does, as where a block falls flat.
    """
    squares = sum(way.speed**2 for way in ways)
    if not squares > sys.float_info.min:
        return [way.alone for way in ways]
    total = 0.0
    for wall in {wall for way in ways for wall in way.walls if gives_way(moves, wall)}:
        here = about(moves, wall)
        push = np.zeros(3)
        for way in ways:
            sense = (wall == way.walls[0]) - (wall == way.walls[1])
            push += sense * way.speed * wrench(way.direction, way.point, here)
        total += yielding(moves, wall, push)
    return [max(total / squares, LEAST * way.alone) for way in ways]


def partners(moves: Moves, walls: tuple[int, int]) -> tuple[int, int]:
    """The two that share the mass of a contact, the smaller number first; all that is at rest is one, -1."""
    alone = [wall if gives_way(moves, wall) or moves.moving[wall] == WallMotion.FOLLOWS else -1 for wall in walls]
    return min(alone), max(alone)
