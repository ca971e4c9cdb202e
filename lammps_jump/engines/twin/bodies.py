# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies against walls and against each other: corners, as discs, against faces (`core/walls/bodies.h`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import nan
from typing import NamedTuple

import numpy as np

from lammps_jump.core.columns import PlacedColumns, SumsOnWallColumns, WallLoadsColumns
from lammps_jump.core.law import LawNumbers
from lammps_jump.engines.native.arrays import State
from lammps_jump.physics.law import contact_energy, contact_force, pressing
from lammps_jump.scene.faces import foot_at, touching

from . import contact, pushed
from .pushed import Vector, wrench


class Touch(NamedTuple):
    """A corner that touches a face.

    Attributes
    ----------
    corner, face : int
    walls : (int, int)
        Of the corner and of the face.
    overlap : float
        m.
    normal : (float, float)
        From the face to the corner.
    inner : (float, float)
        Centre of the corner in the frame of the face's wall, m.
    point : (float, float)
        Where both feel the contact, m: on the rim of the corner.
    slip : (float, float)
        Velocity of the corner against the face, m/s.
    """

    corner: int
    face: int
    walls: tuple[int, int]
    overlap: float
    normal: tuple[float, float]
    inner: tuple[float, float]
    point: tuple[float, float]
    slip: tuple[float, float]


def _shown(state: State, wall: int, x: float, y: float) -> tuple[float, float]:
    """The actual place of a point of the frame in which a wall is at rest."""
    moves = state.walls.moves
    if not contact.is_moving(moves, wall):
        return x, y
    cx, cy = moves.centre[wall]
    dx, dy = contact.outward(moves, wall, x - cx, y - cy)
    here_x, here_y, _ = moves.now[wall, PlacedColumns.NOW]
    return cx + here_x + dx, cy + here_y + dy


def _is_there(record: np.void, dx: float, dy: float) -> bool:
    """Tell whether a corner is there in a direction from its centre: an arc is in some alone."""
    if record["tx0"] == 0.0 and record["ty0"] == 0.0:
        return True
    return record["tx0"] * dx + record["ty0"] * dy >= 0.0 > record["tx1"] * dx + record["ty1"] * dy


def touches(state: State) -> Iterator[Touch]:
    """All contacts of corners with faces."""
    own, moves, faces = state.bodies, state.walls.moves, state.walls.faces
    assert own is not None
    near = own.corners.walls.near
    for wall in range(len(faces.deep)):
        for row in range(near.rows[wall], near.rows[wall + 1]):
            i = int(near.discs[row])
            record = own.corner[i]
            theirs, radius = int(record["wall"]), float(record["radius"])
            x, y = _shown(state, theirs, float(record["x"]), float(record["y"]))
            inner = contact.inward(moves, wall, x, y)
            around = near.faces[near.last[row] : near.last[row + 1]]
            count = touching(faces, faces.deep[wall], around, (*inner, radius), near.found, near.which)
            for k in range(count):
                gap, nx, ny, _ = near.found[k].tolist()
                nx, ny = contact.outward(moves, wall, nx, ny)
                if not _is_there(record, *_turned_back(state, theirs, -nx, -ny)):
                    continue
                point = x - radius * nx, y - radius * ny
                if not sum(pushed.yielding_at(moves, one, point, (nx, ny)) for one in (theirs, wall)) > 0.0:
                    continue  # both are held
                rate = PlacedColumns.RATE
                (ax, ay), (bx, by) = (contact.wall_velocity(moves, one, rate, *point) for one in (theirs, wall))
                where = i, int(near.which[k]), (theirs, wall)
                yield Touch(*where, radius - gap, (nx, ny), inner, point, (ax - bx, ay - by))


def _turned_back(state: State, wall: int, dx: float, dy: float) -> tuple[float, float]:
    """A direction in the frame in which a wall is at rest."""
    moves = state.walls.moves
    if not contact.is_moving(moves, wall):
        return dx, dy
    c, s = moves.now[wall, PlacedColumns.C], moves.now[wall, PlacedColumns.S]
    return c * dx + s * dy, c * dy - s * dx


def _ways(state: State, touch: Touch) -> tuple[pushed.SharedContact, pushed.SharedContact]:
    """A contact along its normal and across it."""
    moves, (nx, ny), (vx, vy) = state.walls.moves, touch.normal, touch.slip
    along, across = ((nx, ny), vx * nx + vy * ny), ((-ny, nx), vy * nx - vx * ny)

    def way(direction: tuple[float, float], speed: float) -> pushed.SharedContact:
        alone = sum(pushed.yielding_at(moves, wall, touch.point, direction) for wall in touch.walls)
        return pushed.SharedContact(touch.walls, touch.point, direction, speed, alone)

    return way(*along), way(*across)


def _laws(state: State, touches: Sequence[Touch]) -> list[LawNumbers]:
    """Numbers of each contact; those between the same two share the effective mass."""
    own, moves = state.bodies, state.walls.moves
    assert own is not None
    groups: dict[tuple[int, int], list[int]] = {}
    for k, one in enumerate(touches):
        groups.setdefault(pushed.partners(moves, one.walls), []).append(k)
    ways, laws = [_ways(state, one) for one in touches], [LawNumbers(0, 0, 0, 0)] * len(touches)
    for group in groups.values():
        both = [pushed.shared(moves, [ways[k][side] for k in group]) for side in (0, 1)]
        for k, along, across in zip(group, *both, strict=True):
            *numbers, lag = own.between[touches[k].walls].tolist()
            laws[k] = pushed.law_between(LawNumbers(*numbers), lag, along, across)
    return laws


def forces(state: State, slope: float | None) -> None:
    """Add the forces of all contacts to the walls that feel them."""
    own = state.bodies
    assert own is not None
    memory, there = own.corners.memory, list(touches(state))
    for touch, of in zip(there, _laws(state, there), strict=True):
        radius, slip, (nx, ny) = float(own.corner["radius"][touch.corner]), touch.slip, touch.normal
        plain = of if memory is None else of._replace(friction=nan)
        fx, fy, tangential, dashpot = contact_force(touch.overlap, touch.normal, slip, 0.0, plain, slope)
        if memory is not None:
            walls = own.corners.walls
            foot = foot_at(state.walls.faces, touch.face, *touch.inner)
            where = int(walls.chain[touch.face]), foot, float(walls.around[touch.face])
            slips, push = (slip[1] * nx - slip[0] * ny, 0.0), pressing(fx * nx + fy * ny, of)
            tangential, _ = contact.spring_forces(memory, touch.corner, where, radius, slips, push, of)
            fx, fy = fx - tangential * ny, fy + tangential * nx
        for wall, sense in zip(touch.walls, (1.0, -1.0), strict=True):
            parts = (fx, fy), (-dashpot * nx, -dashpot * ny), (tangential * ny, -tangential * nx)
            _add(state, wall, touch.point, [np.multiply(sense, part) for part in parts])
        if touch.overlap > own.deepest[0]:
            own.deepest[:] = touch.overlap, *touch.walls


def _add(state: State, wall: int, point: Vector, parts: Sequence[np.ndarray]) -> None:
    """Add a force, and what of it dashpots and friction take, to a wall; a probe of a body is of discs alone."""
    walls, moves = state.walls, state.walls.moves
    moving = contact.is_moving(moves, wall)
    if moving:
        columns = WallLoadsColumns.ALL, WallLoadsColumns.DASHPOTS, WallLoadsColumns.FRICTION
        for there, part in zip(columns, parts, strict=True):
            moves.wall_loads[wall, there] += wrench(part, point, pushed.about(moves, wall))
    if not contact.is_body(state, wall):
        about = walls.near.about[wall] + (moves.now[wall, PlacedColumns.NOW][:2] if moving else 0.0)
        walls.sums[wall, SumsOnWallColumns.FORCE] += wrench(parts[0], point, about)


def elastic(state: State) -> float:
    """Elastic energy of the contacts of bodies, J per m of width."""
    assert state.bodies is not None
    between = state.bodies.between
    laws = ((touch.overlap, LawNumbers(*between[touch.walls][:-1].tolist())) for touch in touches(state))
    return float(sum(contact_energy(*one) for one in laws))
