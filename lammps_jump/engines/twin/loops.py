# SPDX-License-Identifier: GPL-2.0-or-later
"""The loops of the twin: kick and drift, forces, and what belongs to them (`lammps_jump.engines.native.arrays`)."""

from __future__ import annotations

import numpy as np

from lammps_jump.core.columns import (
    PlacedColumns,
    PushedColumns,
    StepClockColumns,
    SumsOnWallColumns,
    WallMotion,
    WorkColumns,
    WorkPartsColumns,
)
from lammps_jump.engines.native.arrays import ContactVelocities, Moves, PressedSums, State, StepConstants
from lammps_jump.engines.native.discs import DiscArrays
from lammps_jump.physics.law import end_step
from lammps_jump.scene.faces import foot_at, mark_cells

from . import bodies, contact, lists, pushed, sums
from .pushed import wrench


class Twin:
    """The loops of the twin; each is described in `Loops`."""

    threads = 1
    runs_alone = False
    outside = staticmethod(lists.outside)
    list_pairs = staticmethod(lists.list_pairs)
    closest = staticmethod(lists.closest)
    append_row = staticmethod(lists.append_row)
    image_rows = staticmethod(lists.image_rows)
    cell_pairs = staticmethod(lists.cell_pairs)
    list_near = staticmethod(lists.near_walls)
    mark_cells = staticmethod(mark_cells)
    elastic = staticmethod(sums.elastic)
    contacts = staticmethod(sums.contacts)
    give_sizes = staticmethod(sums.give_sizes)
    between = staticmethod(sums.between)

    def place_walls(self, moves: Moves, step: int) -> None:
        """Put the moving walls where they are at a step."""
        contact.place_walls(moves, step)

    def advance(self, state: State, steps: int, forces_pending: bool) -> tuple[int, bool]:
        """Drifts and forces; see `Loops.advance`."""
        done, moves = 0, state.walls.moves
        while True:
            if forces_pending:
                if state.grid is not None:
                    rows = lists.cell_pairs(state)
                    if rows < 0:
                        return done, True
                    state = state._replace(pairs=state.pairs._replace(rows=rows))
                forces(state)
            if steps == 0:
                return 0, False
            old = kick_drift(state)
            done, forces_pending = done + 1, True
            if moves is not None:
                step = int(moves.clock[StepClockColumns.STEP]) + done
                pushed.drift(moves, step)
                old = contact.place_walls(moves, step) or old
            if old or done == steps:
                return done, old


def forces(state: State) -> None:
    """Add the forces of all contacts to those of the discs, and the opposite to walls."""
    d, memory = state.discs, state.memory
    seen = contact.seen_by(state)
    slope = contact.slope_of(state, seen)
    _pair_forces(state, seen, slope)
    if state.walls.moves is not None:
        state.work[WorkColumns.OF_WALLS] = 0.0
    for wall in range(len(state.walls.faces.deep)):
        _wall_forces(state, wall, seen, slope)
    if state.bodies is not None:
        bodies.forces(state, slope)
    if state.walls.moves is not None:
        _end_walls(state)
        state.work[WorkColumns.WHOLE] += state.work[WorkColumns.OF_WALLS]
    if d.fixed is not None:  # they stay, and nothing is dissipated on their side
        held = d.fixed[: d.n] != 0
        for array in (d.fx, d.fy, d.torque, d.dashpot_x, d.dashpot_y, d.friction_x, d.friction_y):
            if array is not None:
                array[: d.n][held] = 0.0
    if memory is not None and memory.time_step > 0.0:
        end_step(memory.slots, d.n)
        if state.bodies is not None and (corners := state.bodies.corners).memory is not None:
            end_step(corners.memory.slots, corners.discs.n)


def _add(d: DiscArrays, i: int, acting: contact.ActingContact, sense: float, torque: float) -> None:
    """Add a contact to a disc: to the first with sense 1, to the second with -1."""
    (nx, ny), (fx, fy) = acting.normal, acting.force
    d.fx[i] += sense * fx
    d.fy[i] += sense * fy
    if d.torque is not None:
        d.torque[i] += torque
    if d.dashpot_x is not None:
        d.dashpot_x[i] += sense * acting.dashpot * nx
        d.dashpot_y[i] += sense * acting.dashpot * ny
    if d.friction_x is not None:
        d.friction_x[i] -= sense * acting.tangential * ny
        d.friction_y[i] += sense * acting.tangential * nx


def _pair_forces(state: State, seen: ContactVelocities, slope: float | None) -> None:
    for i, j, acting in contact.pair_contacts(state, seen, slope):
        _add(state.discs, i, acting, 1.0, acting.torques[0])
        _add(state.discs, j, acting, -1.0, acting.torques[1])


def _wall_forces(state: State, wall: int, seen: ContactVelocities, slope: float | None) -> None:
    """Forces of one wall: `Walls.sums` gets the force on it, `Moves.wall_loads` also what is dissipated there."""
    walls, moves = state.walls, state.walls.moves
    moving = contact.is_moving(moves, wall)
    about, centre = walls.near.about[wall].copy(), np.zeros(2)
    if moving:
        here = moves.now[wall, PlacedColumns.NOW][:2]
        about += here
        centre = moves.centre[wall] + here
    push, dashpots, friction = np.zeros(3), np.zeros(3), np.zeros(3)  # of the wall: along x and y, and the moment
    for touched in contact.touched_faces(state, wall):
        acting = contact.wall_contact(state, wall, touched, seen, slope)
        _add(state.discs, touched[0], acting, 1.0, acting.torques[0])
        (nx, ny), tangential, dashpot = acting.normal, acting.tangential, acting.dashpot
        push -= wrench(acting.force, acting.point, about)
        if walls.pressed is not None:
            inner = contact.inward(moves, wall, float(state.discs.x[touched[0]]), float(state.discs.y[touched[0]]))
            fx, fy = acting.force
            _press(
                walls.pressed, wall, foot_at(walls.faces, touched[1], *inner), (fx * nx + fy * ny, fy * nx - fx * ny)
            )
        push[2] += acting.torques[1]
        dashpots += wrench((dashpot * nx, dashpot * ny), acting.point, centre)
        friction += wrench((-tangential * ny, tangential * nx), acting.point, centre)
        friction[2] -= acting.torques[1]
    walls.sums[wall, SumsOnWallColumns.FORCE] += push
    if moving:
        moves.wall_loads[wall] = [*push, *push, *dashpots, *friction]


def _press(pressed: PressedSums, wall: int, foot: float, force: tuple[float, float]) -> None:
    """Add the force of a contact, across and along the outline (N/m), to the stretches that its foot (m) lies in."""
    for k in range(pressed.first[wall], pressed.first[wall + 1]):
        low, high = pressed.ends[k]
        if low <= foot < high:
            pressed.sums[k] += (*force, force[0] * foot)


def _end_walls(state: State) -> None:
    """Work of the forces of a step on walls that move.

    Power is that of the velocity centred on the step, so that its sum over steps is the energy that discs gain.
    `WorkColumns.OF_WALLS` takes the step's part of what dashpots and friction do on the walls, and of that power.
    """
    walls, moves = state.walls, state.walls.moves
    dt, work = moves.clock[StepClockColumns.DT], state.work[WorkColumns.OF_WALLS]
    for wall in np.flatnonzero(moves.moving).tolist():
        of_discs, push, dashpots, friction = moves.wall_loads[wall].reshape(4, 3)
        moves.pushed[wall, PushedColumns.FORCE] = push
        if moves.moving[wall] >= WallMotion.LOADED:
            pushed.centre(moves, wall)
        rate = moves.now[wall, PlacedColumns.CENTRED]
        walls.sums[wall, SumsOnWallColumns.POWER] -= of_discs @ rate
        if state.discs.dashpot_x is not None:
            work[WorkPartsColumns.DASHPOTS] += dt * dashpots @ rate
            work[WorkPartsColumns.FRICTION] += dt * friction @ rate
        if moves.moving[wall] not in (WallMotion.LOADED, WallMotion.BODY):  # their energy is part of the whole
            work[WorkPartsColumns.WALLS] -= dt * push @ rate


def _square_of(state: State) -> float | np.ndarray:
    """Mass over that of the constants in `StepConstants`."""
    d = state.discs
    return 1.0 if d.radius is None else d.radius[: d.n] ** 2


def _book(state: State, motion: StepConstants) -> None:
    """Take the work of dashpots and friction over the whole kick, dt F . v_n, off the ledger, and begin anew.

    It is exact, because v_n is the mean of the velocities before and after the kick.
    """
    d, n, square, dt = state.discs, state.discs.n, _square_of(state), motion.time_step
    half = 0.5 * dt / motion.mass / square
    at_step = d.vx[:n] + half * d.fx[:n], d.vy[:n] + half * d.fy[:n]
    work = state.work[WorkColumns.WHOLE]
    work[WorkPartsColumns.DASHPOTS] -= dt * (d.dashpot_x[:n] @ at_step[0] + d.dashpot_y[:n] @ at_step[1])
    d.dashpot_x[:n] = d.dashpot_y[:n] = 0.0
    if d.friction_x is None:
        return
    work[WorkPartsColumns.FRICTION] -= dt * (d.friction_x[:n] @ at_step[0] + d.friction_y[:n] @ at_step[1])
    d.friction_x[:n] = d.friction_y[:n] = 0.0
    if d.omega is not None:
        turn = d.omega[:n] + 0.5 * dt / motion.inertia / square**2 * d.torque[:n]
        work[WorkPartsColumns.FRICTION] -= dt * (d.torque[:n] @ turn)


def kick_drift(state: State) -> bool:
    """v += dt F/m, x += dt v, F = weight; whether a disc has gone over half the skin, or is nowhere, since its list."""
    d, n, motion, square = state.discs, state.discs.n, state.constants.motion, _square_of(state)
    dt = motion.time_step
    if d.dashpot_x is not None:
        _book(state, motion)
    if d.omega is not None:
        old = d.omega[:n].copy()
        d.omega[:n] += dt / motion.inertia / square**2 * d.torque[:n]
        d.torque[:n] = 0.0
        if d.uomega is not None:
            d.uomega[:n] = 1.5 * d.omega[:n] - 0.5 * old
    for v, f, u, x, weight in ((d.vx, d.fx, d.ux, d.x, motion.weight_x), (d.vy, d.fy, d.uy, d.y, motion.weight_y)):
        old = v[:n].copy()
        v[:n] += dt / motion.mass / square * f[:n]
        if u is not None:
            u[:n] = 1.5 * v[:n] - 0.5 * old
        x[:n] += dt * v[:n]
        f[:n] = weight * square
    way2 = (d.x[:n] - d.x0[:n]) ** 2 + (d.y[:n] - d.y0[:n]) ** 2
    return not bool((way2 <= motion.reach2).all())
