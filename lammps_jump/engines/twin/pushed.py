# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that are pushed, lids and bodies: kick and drift, where they are, how fast (`core/motion.h`)."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from lammps_jump.engines.native.arrays import Moves

HELD, RELEASED, MOVED = range(3)
Vector = Sequence[float] | np.ndarray


def wrench(force: Vector, point: Vector, about: Vector) -> np.ndarray:
    """A force and its moment about a point."""
    return np.array([*force, (point[0] - about[0]) * force[1] - (point[1] - about[1]) * force[0]])


def _resistance(moves: Moves, wall: int) -> np.ndarray:
    """Mass along x and y, and moment of inertia."""
    mass, inertia = moves.load[wall, :2]
    return np.array([mass, mass, inertia])


def _whole_force(moves: Moves, wall: int) -> np.ndarray:
    """Force of what touches the wall and its constant force, with their moment about the point of turning."""
    force, arm, angle = moves.load[wall, 2:4], moves.load[wall, 4:6], moves.pushed[wall, 2]
    c, s = cos(angle), sin(angle)
    turned = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
    return moves.pushed[wall, 9:12] + wrench(force, turned, (0.0, 0.0))


def drift(moves: Moves, step: int) -> None:
    """Kick and drift of the walls that are pushed, as of discs, to a step; a first kick is half a step long."""
    start, dt = moves.clock[1:3]
    for wall in np.flatnonzero(moves.moving >= 2).tolist():
        begin = moves.load[wall, 9]
        if not (step - start) * dt > begin:
            continue
        kick = 0.5 * dt if (step - 1 - start) * dt <= begin else dt
        free, row = moves.load[wall, 6:9] > 0.0, moves.pushed[wall]
        change = kick * _whole_force(moves, wall) / _resistance(moves, wall)
        row[6:9][free] = row[3:6][free]
        row[3:6][free] += change[free]
        row[0:3][free] += dt * row[3:6][free]


def follow(moves: Moves, wall: int, time: float) -> None:
    """Place a wall that is pushed at a time, s."""
    row, now, begin = moves.pushed[wall], moves.now[wall], moves.load[wall, 9]
    row[12] = MOVED if time > begin else HELD if time < begin else RELEASED
    now[:3] = row[:3]
    now[3:5] = cos(row[2]), sin(row[2])
    now[5:8] = 0.0 if row[12] == HELD else row[3:6]
    if moves.moving[wall] == 4 and moves.clock[4] > 0.0 and row[12] == MOVED:  # thesis (3.7)-(3.9)
        now[5:8] = 1.5 * row[3:6] - 0.5 * row[6:9]


def centre(moves: Moves, wall: int) -> None:
    """Velocity of a wall that is pushed at a step, with the force of that step."""
    row = moves.pushed[wall]
    free = (moves.load[wall, 6:9] > 0.0) & (row[12] != HELD)
    half = 0.5 * moves.clock[2] * _whole_force(moves, wall) / _resistance(moves, wall) if row[12] == MOVED else 0.0
    moves.now[wall, 8:11] = np.where(free, row[3:6] + half, 0.0)
