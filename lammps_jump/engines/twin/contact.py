# SPDX-License-Identifier: GPL-2.0-or-later
"""One contact of two discs and one of a disc with a wall: lever, slip, force, torque, what is lost, memory.

Every sum of the twin takes its contacts from here.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import nan, sqrt
from typing import NamedTuple, TypeGuard

import numpy as np

from lammps_jump.core.columns import PlacedColumns, StepClockColumns, WallMotion
from lammps_jump.core.law import LawNumbers
from lammps_jump.engines.native.arrays import ContactVelocities, Memory, Moves, State
from lammps_jump.physics.elementary import cos, sin
from lammps_jump.physics.law import FULL, Pair, contact_force, held, pressing, slider, slot_of
from lammps_jump.scene.faces import foot_at, touching
from lammps_jump.scene.tracks import pose_py

from . import pushed

Three = tuple[float, float, float]
HUGE = 1e150
"""Radius that represents the mass of a fixed disc, m: its square is still a number."""


class ActingContact(NamedTuple):
    """A contact as it acts on its first disc.

    Attributes
    ----------
    normal : (float, float)
        Unit vector to the disc.
    point : (float, float)
        Where the two touch, m.
    overlap : float
        m.
    force : (float, float)
        N per m of width.
    tangential, dashpot : float
        Its tangential part, along (-ny, nx), and the lost part along the normal, N per m of width.
    torques : (float, float)
        On the two discs; of a wall, on the disc and 0; of a body, what rolling adds to its moment. N m per m of width.
    """

    normal: tuple[float, float]
    point: tuple[float, float]
    overlap: float
    force: tuple[float, float]
    tangential: float
    dashpot: float
    torques: tuple[float, float]


def seen_by(state: State) -> ContactVelocities:
    """Velocities that dashpots and friction see: of the half step, or extrapolated."""
    d = state.discs
    return (d.vx, d.vy, d.omega) if d.ux is None else (d.ux, d.uy, d.uomega)


def slope_of(state: State, seen: ContactVelocities) -> float | None:
    """1 / eps of the thesis' friction, eps = 0.01 v_max (4.20) of this step; None for another law."""
    sign, n = state.constants.law.sign_ramp, state.discs.n
    if not sign:
        return None
    eps = sign * sqrt(np.max(seen[0][:n] ** 2 + seen[1][:n] ** 2, initial=0.0))
    return 1.0 / eps if eps > 1e-300 else 1e300  # nothing moves: the limit of the law, sat -> sign


def radius_of(state: State, i: int) -> float:
    """Radius of a disc, m."""
    return 0.5 * state.constants.diameter if state.discs.radius is None else float(state.discs.radius[i])


def is_fixed(state: State, i: int) -> bool:
    """Tell whether a disc stays where it is."""
    return state.discs.fixed is not None and state.discs.fixed[i] != 0


def pair_size(state: State, i: int, j: int) -> float:
    """Root of the effective mass of two discs over the root of the mass of a radius of 1 m; 1 of equal discs."""
    if state.discs.radius is None:
        return 1.0
    a, b = (HUGE if is_fixed(state, k) else radius_of(state, k) for k in (i, j))
    return a * b / sqrt(a * a + b * b)


def spring_forces(
    memory: Memory, i: int, where: tuple[int, float, float], radius: float, slips: Pair, push: float, of: LawNumbers
) -> Pair:
    """Tangential and rolling force of a contact of disc i, N per m of width; its springs go on by a step.

    `where` holds the partner, the arc length of the foot on its chain and the chain's length (m); `slips` the
    tangential speed and that of rolling (m/s); `push` is what presses the two together; `of` has the dashpot of this
    contact.
    """
    partner, foot, around = where
    slip, turn = slips
    dt, slots = memory.time_step, memory.slots
    find = slot_of if dt > 0.0 else held
    slot = find(slots, i, partner, foot, 0.5 * radius + abs(slip) * dt, around)
    stretch = bent = resists = 0.0
    if slot != FULL:
        stretch, bent = slots.spring[i, slot], slots.roll[i, slot]
    elif dt > 0.0:
        memory.full[0] = memory.ids[i]
    spring, dashpot = of.spring_ratio * of.stiffness, of.spring_damping * of.damping
    force, stretch = slider(stretch + slip * dt, slip, of.friction * abs(push), spring, dashpot)
    if of.rolling > 0.0:
        bound = of.rolling_friction * abs(push)
        resists, bent = slider(bent + turn * dt, turn, bound, of.rolling, of.rolling_damping)
    if slot != FULL and dt > 0.0:
        slots.spring[i, slot], slots.roll[i, slot] = stretch, bent
    return force, resists


def _of_size(law: LawNumbers, size: float) -> LawNumbers:
    """The law with the dashpots of a contact of this size; 1 where discs are equal."""
    return law._replace(damping=law.damping * size, tangential=law.tangential * size)


def _with_friction(force: Pair, normal: Pair, tangential: float) -> Pair:
    (fx, fy), (nx, ny) = force, normal
    return fx - tangential * ny, fy + tangential * nx


def pair_contact(
    state: State, i: int, j: int, shift: float, seen: ContactVelocities, slope: float | None
) -> ActingContact | None:
    """The contact of disc i, `shift` (m) further along x, with disc j; None where they do not touch.

    `seen` are the velocities that dashpots and friction see. The lever of friction is R of equal discs. It is R less
    half the overlap of others and of contacts with memory, as in LAMMPS' styles for each.
    """
    d, memory = state.discs, state.memory
    a, b = radius_of(state, i), radius_of(state, j)
    dx, dy = d.x[i] + shift - d.x[j], d.y[i] - d.y[j]
    apart = sqrt(dx * dx + dy * dy)
    if not dx * dx + dy * dy < (a + b) * (a + b):
        return None
    nx, ny, overlap = dx / apart, dy / apart, a + b - apart
    vx, vy, spin = seen
    spins = (0.0, 0.0) if spin is None else (spin[i], spin[j])
    slip, rim = (vx[i] - vx[j], vy[i] - vy[j]), a * spins[0] + b * spins[1]
    of = _of_size(state.constants.law, pair_size(state, i, j))
    plain = of if memory is None else of._replace(friction=nan)
    fx, fy, tangential, dashpot = contact_force(overlap, (nx, ny), slip, rim, plain, slope)
    rolls = 0.0
    if memory is not None:
        one, other, sense = (i, j, 1.0) if memory.ids[i] > memory.ids[j] else (j, i, -1.0)
        arm = a * b / (a + b)
        slips = slip[1] * nx - slip[0] * ny - rim, sense * arm * (spins[0] - spins[1])
        where = int(memory.ids[other]), 0.0, 0.0
        tangential, resists = spring_forces(memory, one, where, a, slips, pressing(fx * nx + fy * ny, of), of)
        fx, fy = _with_friction((fx, fy), (nx, ny), tangential)
        rolls = sense * arm * resists
    dent = 0.5 * overlap if d.radius is not None or memory is not None else 0.0
    torques = -(a - dent) * tangential + rolls, -(b - dent) * tangential - rolls
    point = d.x[i] + shift - (a - 0.5 * overlap) * nx, d.y[i] - (a - 0.5 * overlap) * ny
    return ActingContact((nx, ny), point, overlap, (fx, fy), tangential, dashpot, torques)


def pair_contacts(
    state: State, seen: ContactVelocities, slope: float | None
) -> Iterator[tuple[int, int, ActingContact]]:
    """Two discs and their contact, for all that touch."""
    pairs = state.pairs
    for row in range(pairs.rows):
        i = row if pairs.owner is None else int(pairs.owner[row])
        shift = 0.0 if pairs.shift is None else float(pairs.shift[row])
        for j in pairs.neighbours[pairs.start[row] : pairs.start[row + 1]].tolist():
            contact = pair_contact(state, i, j, shift, seen, slope)
            if contact is not None:
                yield i, j, contact


# --- walls ------------------------------------------------------------------------------------------------------------


def is_body(state: State, wall: int) -> bool:
    """Tell whether a wall is a body."""
    return state.walls.moves is not None and state.walls.moves.moving[wall] == WallMotion.BODY


def law_at(state: State, i: int, wall: int, point: Pair, normal: Pair) -> LawNumbers:
    """Numbers of the contact of a disc with a wall; those of a body are of the effective mass at this point (m)."""
    law, moves, radius = state.walls.near.laws[wall], state.walls.moves, radius_of(state, i)
    unit, sized = state.constants.motion.mass, state.discs.radius is not None
    if not is_moving(moves, wall) or not is_body(state, wall):
        return _of_size(law, radius if sized else 1.0)
    mass = unit * radius**2 if sized else unit
    disc = pushed.DiscMass(mass, 0.5 * mass * radius**2, is_fixed(state, i))
    return pushed.law_at_body(law, unit, disc, moves, wall, point, normal)


def is_moving(moves: Moves | None, wall: int) -> TypeGuard[Moves]:
    """Tell whether a wall has a motion."""
    return moves is not None and moves.moving[wall] > 0


def inward(moves: Moves | None, wall: int, x: float, y: float) -> tuple[float, float]:
    """A point in the frame in which a wall is at rest."""
    if not is_moving(moves, wall):
        return x, y
    now, (cx, cy) = moves.now[wall], moves.centre[wall]
    (here_x, here_y, _), c, s = now[PlacedColumns.NOW], now[PlacedColumns.C], now[PlacedColumns.S]
    dx, dy = x - cx - here_x, y - cy - here_y
    return cx + c * dx + s * dy, cy - s * dx + c * dy


def outward(moves: Moves | None, wall: int, nx: float, ny: float) -> tuple[float, float]:
    """The actual direction, from the frame in which a wall is at rest."""
    if not is_moving(moves, wall):
        return nx, ny
    c, s = moves.now[wall, PlacedColumns.C], moves.now[wall, PlacedColumns.S]
    return c * nx - s * ny, s * nx + c * ny


def wall_velocity(moves: Moves | None, wall: int, columns: slice, x: float, y: float) -> tuple[float, float]:
    """Velocity of a wall at a point, of one of its rates in `PlacedColumns`."""
    if not is_moving(moves, wall):
        return 0.0, 0.0
    now, (cx, cy) = moves.now[wall], moves.centre[wall]
    (here_x, here_y, _), (vx, vy, turn) = now[PlacedColumns.NOW], now[columns]
    return vx - turn * (y - cy - here_y), vy + turn * (x - cx - here_x)


def place_walls(moves: Moves, step: int) -> bool:
    """Put the moving walls where they are at a step; True where one has gone over half the skin since it was listed."""
    old = False
    start, dt = moves.clock[StepClockColumns.START], moves.clock[StepClockColumns.DT]
    half_skin = moves.clock[StepClockColumns.HALF_SKIN]
    for wall, now in enumerate(moves.now):
        if moves.moving[wall] == WallMotion.STANDS:
            continue
        if moves.moving[wall] == WallMotion.FOLLOWS:
            (first, last), time = moves.first[wall : wall + 2], (step - start) * dt
            before, here, later_pose = (pose_py(moves.track, first, last, time + later) for later in (-dt, 0.0, dt))
            now[PlacedColumns.NOW] = here
            now[PlacedColumns.C], now[PlacedColumns.S] = cos(here[2]), sin(here[2])
            now[PlacedColumns.RATE] = [(b - a) / dt for a, b in zip(before, here, strict=True)]
            now[PlacedColumns.CENTRED] = [0.5 * (b - a) / dt for a, b in zip(before, later_pose, strict=True)]
        else:
            pushed.follow(moves, wall, (step - start) * dt)
        dx, dy, turn = now[PlacedColumns.NOW] - moves.listed[wall]
        turned = moves.far[wall] * abs(turn) if turn != 0.0 else 0.0
        old = old or not sqrt(dx * dx + dy * dy) + turned <= half_skin
    return old


def touched_faces(state: State, wall: int) -> Iterator[tuple[int, int, float, tuple[float, float]]]:
    """Disc, face, signed distance (m) and outward normal of each contact of a wall with the discs listed near it.

    Fixed discs feel no wall, and no wall feels them; bodies and they do.
    """
    d, near, faces, moves = state.discs, state.walls.near, state.walls.faces, state.walls.moves
    for row in range(near.rows[wall], near.rows[wall + 1]):
        i = int(near.discs[row])
        if is_fixed(state, i) and not is_body(state, wall):
            continue
        px, py = inward(moves, wall, float(d.x[i]), float(d.y[i]))
        around = near.faces[near.last[row] : near.last[row + 1]]
        count = touching(faces, faces.deep[wall], around, (px, py, radius_of(state, i)), near.found, near.which)
        for contact in range(count):
            gap, nx, ny, _ = near.found[contact].tolist()
            yield i, int(near.which[contact]), gap, outward(moves, wall, nx, ny)


def wall_contact(
    state: State,
    wall: int,
    touched: tuple[int, int, float, tuple[float, float]],
    seen: ContactVelocities,
    slope: float | None,
) -> ActingContact:
    """The contact of a disc with a wall, of `touched_faces`; the lever of friction is R.

    A body feels it at the rim of the disc, and turns with it where the disc rolls.
    """
    d, memory, walls = state.discs, state.memory, state.walls
    i, face, gap, (nx, ny) = touched
    own = radius_of(state, i)
    body = is_body(state, wall)
    to = own if body else gap
    at = d.x[i] - to * nx, d.y[i] - to * ny
    of = law_at(state, i, wall, at, (nx, ny))
    wx, wy = wall_velocity(walls.moves, wall, PlacedColumns.RATE, *at)
    vx, vy, spins = seen
    slip, spin = (vx[i] - wx, vy[i] - wy), 0.0 if spins is None else spins[i]
    rim = own * spin
    plain = of if memory is None else of._replace(friction=nan)
    fx, fy, tangential, dashpot = contact_force(own - gap, (nx, ny), slip, rim, plain, slope)
    resists = 0.0
    if memory is not None:
        inner = inward(walls.moves, wall, float(d.x[i]), float(d.y[i]))
        foot = foot_at(walls.faces, face, *inner)
        where = int(walls.chain[face]), foot, float(walls.around[face])
        turn = own * (spin - walls.moves.now[wall, PlacedColumns.RATE][2]) if body and spins is not None else rim
        slips = slip[1] * nx - slip[0] * ny - rim, turn
        tangential, resists = spring_forces(memory, i, where, own, slips, pressing(fx * nx + fy * ny, of), of)
        fx, fy = _with_friction((fx, fy), (nx, ny), tangential)
    rolls = own * resists if body else 0.0
    return ActingContact((nx, ny), at, own - gap, (fx, fy), tangential, dashpot, (own * (resists - tangential), -rolls))
