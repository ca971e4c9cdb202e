# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that are pushed, lids and bodies: kick and drift, where they are, how fast (`core/walls/motion.h`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lammps_jump.core.columns import LoadColumns, Phase, PlacedColumns, PushedColumns, StepClockColumns, WallMotion
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
