# SPDX-License-Identifier: GPL-2.0-or-later
"""Inner loops of the native engine: kick and drift, pair and wall forces, elastic energy.

Plain loops over contiguous float64 arrays, compiled at the end of the file; the uncompiled functions keep the
suffix ``_py``, and every compiled one has them as ``.py_func``. Loops that call each other stand in this one file,
because the compiler's cache watches a function's own file only; for the contact law, `law.watching_law` adds its file.

What a scene lacks is passed as None, and the compiler drops the branch: ``omega`` (no spin), ``friction`` (μ = 0),
``sign`` (LAMMPS' viscous ramp rather than the thesis' sign law), ``touch`` (sharp contact), ``dash_x`` (no energy
ledger), ``ux`` (damping with the half-step velocity rather than the extrapolated one), ``grid`` and ``owner``
(neighbour list rather than the thesis' cells), ``radius`` (equal discs), ``shift`` (no periodic x), ``fixed`` (all
discs move).

Where discs have radii of their own, the constants of `Law` and `Motion` are those of a radius of 1 m: mass and weight
grow as R^2, the moment of inertia as R^4, the dashpot of a wall as R and that of a pair as `_pair_size`. Factors of 1
stand for all of them where discs are equal, and the compiler drops those.

Time levels. Between steps the arrays hold x_n, v_(n-1/2) and F_n, so that velocity Verlet and the thesis'
leap-frog are the same loop: they differ in the velocity that dashpot and friction see, v_(n-1/2) in LAMMPS' order
of operations, 1.5 v_(n-1/2) - 0.5 v_(n-3/2) in thesis (3.7)-(3.9). The velocity at the step is
v_n = v_(n-1/2) + dt F_n / (2 m).
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from lammps_jump.physics.law import contact_force, slider, stored_energy, watching_law
from lammps_jump.physics.slots import FULL, Slots, end_step, held, slot_of
from lammps_jump.scene.chains import TX0, TY0, X0, Y0
from lammps_jump.scene.faces import foot_at, touching, touching_inline
from lammps_jump.scene.tracks import pose_py

HUGE = 1e150
"""Radius that stands for the mass of a fixed disc, m: its square is still a number."""


class Law(NamedTuple):
    """Contact law in the engines' units: force = stiffness overlap + damping (m_eff gamma) velocity.

    `diameter` is that of equal discs. `damping` and `tangential` are of a pair, or of a size of 1 m. Those of walls
    stand in `Near.numbers`.
    """

    diameter: float
    stiffness: float
    damping: float
    tangential: float


class Motion(NamedTuple):
    """Constants of the kick and the drift, of a disc or of a radius of 1 m; `reach2`: the square of half the skin."""

    time_step: float
    mass: float
    inertia: float
    weight_x: float
    weight_y: float
    reach2: float


class Pairs(NamedTuple):
    """Half list of pairs: rows in use; disc of each row, None if it is the row's number; neighbours by row.

    In a periodic channel `shift` (m) is what a row adds to x of its disc: rows of images stand behind the others.
    """

    rows: int
    owner: np.ndarray | None
    start: np.ndarray
    neighbours: np.ndarray
    shift: np.ndarray | None = None


class Grid(NamedTuple):
    """Fixed cells of the thesis' contact search; `first`: first list entry of each cell, `used`: rows in use."""

    x_low: float
    y_low: float
    inverse: float
    columns: int
    rows: int
    first: np.ndarray
    used: np.ndarray


class Near(NamedTuple):
    """Discs near walls, a wall at a time.

    Attributes
    ----------
    numbers : ndarray, shape (walls, 4)
        Stiffness, dashpot, slope of the viscous ramp (as in `Law`) and friction coefficient of each wall.
    about : ndarray, shape (walls, 2)
        Point that the moment on each wall is taken about, m.
    rows : ndarray of int64, shape (walls + 1,)
        First row of each wall.
    discs : ndarray of int32
        Disc of each row.
    plain : ndarray of int8
        1 where the row has one straight face whose ends are out of reach.
    last : ndarray of int64
        The faces of row r are ``faces[last[r]:last[r + 1]]``.
    faces : ndarray of int64
    found, which : ndarray
        Room for the contacts of one disc (`scene.faces.touching`).
    """

    numbers: np.ndarray
    about: np.ndarray
    rows: np.ndarray
    discs: np.ndarray
    plain: np.ndarray
    last: np.ndarray
    faces: np.ndarray
    found: np.ndarray
    which: np.ndarray


class Moves(NamedTuple):
    """Walls that move: their tracks, and where they are.

    Attributes
    ----------
    track, first : ndarray
        Rows of wall w: ``track[first[w]:first[w + 1]]`` (`lammps_jump.scene.tracks`); none of a wall that stands.
    moving : ndarray of int64, shape (walls,)
        0 stands, 1 follows its track, 2 is pushed by the discs.
    centre : ndarray, shape (walls, 2)
        Point of turning where the case has it, m.
    now : ndarray, shape (walls, 11)
        Pose at the step (m, m, rad), cosine and sine of its angle, velocity over the step before and centred over two.
    listed : ndarray, shape (walls, 3)
        Pose for which the discs near it were listed.
    far : ndarray, shape (walls,)
        Largest distance of a face from the centre, m.
    lid : ndarray, shape (walls, 6)
        Of pushed walls: mass (kg/m), force (N/m) along x and y, 1 or 0 for the axes free to move, time of the release.
    pushed : ndarray, shape (walls, 6)
        Of pushed walls: displacement (m), velocity of the half step (m/s), force of the discs at the step (N/m).
    clock : ndarray, shape (4,)
        Step at the call, step of t = 0, time step (s), and half the skin (m).
    """

    track: np.ndarray
    first: np.ndarray
    moving: np.ndarray
    centre: np.ndarray
    now: np.ndarray
    listed: np.ndarray
    far: np.ndarray
    lid: np.ndarray
    pushed: np.ndarray
    clock: np.ndarray


class Memory(NamedTuple):
    """What contacts with springs need besides the law; of two discs the one with the larger id remembers.

    Attributes
    ----------
    slots : Slots
    ids : ndarray of int64
        Of the discs.
    chain : ndarray of int64, shape (faces,)
        What stands for the chain of a face in the slots (`lammps_jump.physics.slots`).
    around : ndarray, shape (faces,)
        Length of the chain of a face where it is closed, else 0, m.
    full : ndarray of int64, shape (1,)
        Takes the id of a disc that has no slot left.
    time_step : float
        s; 0 where springs stay as they are.
    ratio, damping : float
        Stiffness and dashpot of the tangential spring over those of the contact.
    rolling : tuple of float
        Stiffness (N/m), dashpot (N s/m) and friction coefficient of the rolling spring of pairs; stiffness 0: none.
    rolling_at : ndarray, shape (walls, 3)
        The same of walls.
    """

    slots: Slots
    ids: np.ndarray
    chain: np.ndarray
    around: np.ndarray
    full: np.ndarray
    time_step: float
    ratio: float
    damping: float
    rolling: tuple[float, float, float]
    rolling_at: np.ndarray


def _spring_forces_py(memory, i, where, radius, slips, push, numbers, rolling):
    """Tangential and rolling force of a contact of disc i, N per m of width; its springs go on by a step.

    `where` holds the partner, the arc length of the foot on its chain and the chain's length (m); `slips` the
    tangential speed and that of rolling (m/s); `push` is the normal force; `numbers` are stiffness and dashpot of the
    tangential spring and the friction coefficient, `rolling` those of the rolling spring.
    """
    partner, foot, around = where
    slip, turn = slips
    dt, slots = memory.time_step, memory.slots
    limit = 0.5 * radius + abs(slip) * dt
    stretch = bent = 0.0
    if dt > 0.0:
        slot = slot_of(slots, i, partner, foot, limit, around)
        if slot == FULL:
            memory.full[0] = memory.ids[i]
    else:
        slot = held(slots, i, partner, foot, limit, around)
    if slot != FULL:
        stretch, bent = slots.spring[i, slot], slots.roll[i, slot]
    force, stretch = slider(stretch + slip * dt, slip, numbers[2] * abs(push), numbers[0], numbers[1])
    resists = 0.0
    if rolling[0] > 0.0:
        resists, bent = slider(bent + turn * dt, turn, rolling[2] * abs(push), rolling[0], rolling[1])
    if slot != FULL and dt > 0.0:
        slots.spring[i, slot], slots.roll[i, slot] = stretch, bent
    return force, resists


def _pair_springs_py(memory, pair, radii, overlap, slip, spins, push, numbers):
    """Tangential force of two discs along (-ny, nx) of the first, and the torques on both (N, N m per m of width).

    `numbers` are stiffness, dashpot and friction coefficient of the contact.
    """
    i, j = pair
    one, other = (i, j) if memory.ids[i] > memory.ids[j] else (j, i)
    a, b = radii
    k, c, friction = numbers
    arm = a * b / (a + b)
    turn = arm * (spins[0] - spins[1]) if one == i else arm * (spins[1] - spins[0])
    springs = memory.ratio * k, memory.damping * c, friction
    where = memory.ids[other], 0.0, 0.0
    force, resists = _spring_forces(memory, one, where, a, (slip, turn), push, springs, memory.rolling)
    resists *= arm if one == i else -arm
    return force, -(a - 0.5 * overlap) * force + resists, -(b - 0.5 * overlap) * force - resists


def _wall_springs_py(memory, i, at, radius, slip, spin, push, numbers):
    """Tangential force of a disc at a wall along (-ny, nx), and the torque on it (N, N m per m of width).

    `at` holds the wall, the face and the arc length of the foot; `numbers` are as of two discs.
    """
    wall, face, foot = at
    k, c, friction = numbers
    rolls = memory.rolling_at
    rolling = rolls[wall, 0], rolls[wall, 1], rolls[wall, 2]
    springs = memory.ratio * k, memory.damping * c, friction
    where = memory.chain[face], foot, memory.around[face]
    force, resists = _spring_forces(memory, i, where, radius, (slip, radius * spin), push, springs, rolling)
    return force, radius * (resists - force)


def _place_walls_py(moves, step):
    """Put the moving walls where they are at a step; True where one has gone over half the skin since it was listed."""
    old = False
    now, dt = moves.now, moves.clock[2]
    for w in range(moves.moving.size):
        if moves.moving[w] == 0:
            continue
        if moves.moving[w] == 1:
            time = (step - moves.clock[1]) * dt
            a, b = moves.first[w], moves.first[w + 1]
            before, here = pose(moves.track, a, b, time - dt), pose(moves.track, a, b, time)
            behind = pose(moves.track, a, b, time + dt)
            for c in range(3):
                now[w, c] = here[c]
                now[w, 5 + c] = (here[c] - before[c]) / dt
                now[w, 8 + c] = 0.5 * (behind[c] - before[c]) / dt
            now[w, 3], now[w, 4] = cos(here[2]), sin(here[2])
        else:
            for c in range(2):
                now[w, c] = moves.pushed[w, c]
                now[w, 5 + c] = moves.pushed[w, 2 + c]
        dx, dy = now[w, 0] - moves.listed[w, 0], now[w, 1] - moves.listed[w, 1]
        turned = moves.far[w] * abs(now[w, 2] - moves.listed[w, 2]) if now[w, 2] != moves.listed[w, 2] else 0.0
        if not (sqrt(dx * dx + dy * dy) + turned <= moves.clock[3]):
            old = True
    return old


def _inward_py(moves, wall, x, y):
    """A point as the frame has it in which a wall stands."""
    if moves is None or moves.moving[wall] == 0:
        return x, y
    now, cx, cy = moves.now[wall], moves.centre[wall, 0], moves.centre[wall, 1]
    dx, dy = x - cx - now[0], y - cy - now[1]
    return cx + now[3] * dx + now[4] * dy, cy - now[4] * dx + now[3] * dy


def _outward_py(moves, wall, nx, ny):
    """A direction of the frame in which a wall stands as it is."""
    if moves is None or moves.moving[wall] == 0:
        return nx, ny
    c, s = moves.now[wall, 3], moves.now[wall, 4]
    return c * nx - s * ny, s * nx + c * ny


def _wall_velocity_py(moves, wall, column, x, y):
    """Velocity of a wall at a point: over the step before (column 5 of `Moves.now`), or centred over two (8)."""
    if moves is None or moves.moving[wall] == 0:
        return 0.0, 0.0
    now = moves.now[wall]
    turn = now[column + 2]
    return (
        now[column] - turn * (y - moves.centre[wall, 1] - now[1]),
        now[column + 1] + turn * (x - moves.centre[wall, 0] - now[0]),
    )


def _drift_lids_py(moves, step):
    """Kick and drift of the walls that discs push, as of discs, to a step; a first kick is half a step long."""
    dt = moves.clock[2]
    for w in range(moves.moving.size):
        if moves.moving[w] == 2 and (step - moves.clock[1]) * dt > moves.lid[w, 5]:
            first = (step - 1 - moves.clock[1]) * dt <= moves.lid[w, 5]
            for c in range(2):
                if moves.lid[w, 3 + c] > 0.0:
                    force = moves.pushed[w, 4 + c] + moves.lid[w, 1 + c]
                    moves.pushed[w, 2 + c] += (0.5 * dt if first else dt) * force / moves.lid[w, 0]
                    moves.pushed[w, c] += dt * moves.pushed[w, 2 + c]


def _see_lid_py(moves, wall):
    """Velocity of a wall that discs push at a step, with the force of that step."""
    free = moves.now[wall, 5] != 0.0 or moves.now[wall, 6] != 0.0
    for c in range(2):
        force = moves.pushed[wall, 4 + c] + moves.lid[wall, 1 + c]
        half = 0.5 * moves.clock[2] * force / moves.lid[wall, 0]
        moves.now[wall, 8 + c] = moves.pushed[wall, 2 + c] + half if free and moves.lid[wall, 3 + c] > 0.0 else 0.0


def _slope_py(n, ux, uy, sign):
    """1 / eps of the thesis' friction, eps = 0.01 v_max (4.20) of this step; None where `sign` does not ask for it."""
    if sign is None:
        return None
    a = b = 0.0  # two chains, half the waiting
    for i in range(0, n - 1, 2):
        p = ux[i] * ux[i] + uy[i] * uy[i]
        q = ux[i + 1] * ux[i + 1] + uy[i + 1] * uy[i + 1]
        a = p if p > a else a
        b = q if q > b else b
    if n % 2:
        p = ux[n - 1] * ux[n - 1] + uy[n - 1] * uy[n - 1]
        a = p if p > a else a
    eps = sign * sqrt(max(a, b))
    return 1.0 / eps if eps > 1e-300 else 1e300  # nothing moves: the limit of the law, sat -> sign


def _power_py(n, px, py, vx, vy, fx, fy, radius, half):
    """Sum of p . (v + half f / R^2) over the discs; takes p to zero for the next step."""
    power = 0.0
    for i in range(n):
        kick = half if radius is None else half / (radius[i] * radius[i])
        power += px[i] * (vx[i] + kick * fx[i]) + py[i] * (vy[i] + kick * fy[i])
        px[i] = 0.0
        py[i] = 0.0
    return power


def _power_of_torque_py(n, torque, omega, radius, half):
    """Sum of torque (omega + half torque / R^4) over the discs."""
    power = 0.0
    for i in range(n):
        kick = half if radius is None else half / radius[i] ** 4
        power += torque[i] * (omega[i] + kick * torque[i])
    return power


def _kick_drift_py(
    n, x, y, radius, vx, vy, fx, fy, x0, y0, motion, ux, uy, omega, torque, uomega,
    dash_x, dash_y, slide_x, slide_y, work,
):  # fmt: skip
    """v += dt F/m, x += dt v, F = weight; the number of discs further than half the skin from their place in the list.

    A NaN counts as moved. With a ledger the work of dashpots and friction over the whole kick, dt F . v_n, is taken
    off ``work[0]`` and ``work[1]``: exact, because v_n is the mean of the velocities before and after the kick.
    """
    dt = motion.time_step
    kick = dt / motion.mass
    weight_x, weight_y, reach2 = motion.weight_x, motion.weight_y, motion.reach2
    if dash_x is not None:
        work[0] -= dt * _power(n, dash_x, dash_y, vx, vy, fx, fy, radius, 0.5 * kick)
        if slide_x is not None:
            work[1] -= dt * _power(n, slide_x, slide_y, vx, vy, fx, fy, radius, 0.5 * kick)
            if omega is not None:
                work[1] -= dt * _power_of_torque(n, torque, omega, radius, 0.5 * dt / motion.inertia)
    if omega is not None:
        turn = dt / motion.inertia
        for i in range(n):
            old = omega[i]
            new = old + (turn if radius is None else turn / radius[i] ** 4) * torque[i]
            omega[i] = new
            torque[i] = 0.0
            if uomega is not None:
                uomega[i] = 1.5 * new - 0.5 * old
    moved = 0
    for i in range(n):
        old_x = vx[i]
        old_y = vy[i]
        square = 1.0 if radius is None else radius[i] * radius[i]
        new_x = old_x + kick / square * fx[i]
        new_y = old_y + kick / square * fy[i]
        vx[i] = new_x
        vy[i] = new_y
        if ux is not None:
            ux[i] = 1.5 * new_x - 0.5 * old_x
            uy[i] = 1.5 * new_y - 0.5 * old_y
        px = x[i] + dt * new_x
        py = y[i] + dt * new_y
        x[i] = px
        y[i] = py
        fx[i] = weight_x * square
        fy[i] = weight_y * square
        dx = px - x0[i]
        dy = py - y0[i]
        moved += not (dx * dx + dy * dy <= reach2)
    return moved


def _pair_size_py(a, b):
    """Root of the effective mass of two discs of radii a, b over the root of the mass of a radius of 1 m (m)."""
    return a * b / sqrt(a * a + b * b)


def _bulk_py(radius, fixed, i):
    """Radius that stands for the mass of a disc, m: a huge one for a fixed disc, so that its partner's mass counts."""
    return radius[i] if fixed is None or fixed[i] == 0 else HUGE


def _hold_py(n, fixed, fx, fy, torque, dash_x, dash_y, slide_x, slide_y):
    """Take the forces off fixed discs: they stay, and nothing is dissipated on their side."""
    for i in range(n):
        if fixed[i] == 0:
            continue
        fx[i] = fy[i] = 0.0
        if torque is not None:
            torque[i] = 0.0
        if dash_x is not None:
            dash_x[i] = dash_y[i] = 0.0
        if slide_x is not None:
            slide_x[i] = slide_y[i] = 0.0


def _pair_forces_py(
    rows, owner, x, y, radius, ux, uy, omega, fx, fy, torque, start, neighbours, shift, fixed, law, friction, sign,
    touch, memory, dash_x, dash_y, slide_x, slide_y,
):  # fmt: skip
    """Add the forces of all touching pairs of the half list to fx, fy, torque.

    Row r of the list belongs to disc r, or to disc ``owner[r]`` (see `Pairs`); `fixed` is 1 for discs that stay.

    The forces are those of `lammps_jump.physics.law`; `sign` is 1 / eps of the thesis' friction. The arm of friction is
    R of equal discs, and R less half the overlap of others and of contacts with memory, as in LAMMPS' styles for each.
    """
    k, c, ct = law.stiffness, law.damping, law.tangential
    rub = friction if memory is None else None
    for row in range(rows):
        i = row if owner is None else owner[row]
        xi, yi, uxi, uyi = x[i], y[i], ux[i], uy[i]
        if shift is not None:
            xi += shift[row]
        a = 0.5 * law.diameter if radius is None else radius[i]
        sum_x = sum_y = lost_x = lost_y = slid_x = slid_y = turn = 0.0
        first = start[row]
        last = start[row + 1]
        for p in range(first, last):
            j = neighbours[p]
            dx = xi - x[j]
            dy = yi - y[j]
            r2 = dx * dx + dy * dy
            b = a if radius is None else radius[j]
            reach = a + b
            if r2 < reach * reach:
                r = sqrt(r2)
                inverse = 1.0 / r
                nx = dx * inverse
                ny = dy * inverse
                overlap = reach - r
                size = 1.0
                if radius is not None:
                    size = _pair_size(_bulk(radius, fixed, i), _bulk(radius, fixed, j))
                rim = 0.0
                if omega is not None:
                    rim = a * (omega[i] + omega[j]) if radius is None else a * omega[i] + b * omega[j]
                slip = (uxi - ux[j], uyi - uy[j])
                numbers = (k, c * size, ct * size)
                px, py, ft, dashpot = contact_force(overlap, (nx, ny), slip, rim, numbers, rub, sign, touch)
                if memory is not None:
                    spins = (0.0, 0.0) if omega is None else (omega[i], omega[j])
                    ft, on_one, on_two = _pair_springs(
                        memory, (i, j), (a, b), overlap, slip[1] * nx - slip[0] * ny - rim, spins, px * nx + py * ny,
                        (k, c * size, friction),
                    )  # fmt: skip
                    px -= ft * ny
                    py += ft * nx
                    if omega is not None:
                        turn += on_one
                        torque[j] += on_two
                if friction is not None:
                    if omega is not None and memory is None:
                        dent = 0.0 if radius is None else 0.5 * overlap
                        turn -= (a - dent) * ft
                        torque[j] -= (b - dent) * ft
                    if slide_x is not None:
                        slid_x -= ft * ny
                        slid_y += ft * nx
                        slide_x[j] += ft * ny
                        slide_y[j] -= ft * nx
                if dash_x is not None:
                    ex = dashpot * nx
                    ey = dashpot * ny
                    lost_x += ex
                    lost_y += ey
                    dash_x[j] -= ex
                    dash_y[j] -= ey
                sum_x += px
                sum_y += py
                fx[j] -= px
                fy[j] -= py
        fx[i] += sum_x
        fy[i] += sum_y
        if omega is not None:
            torque[i] += turn
        if dash_x is not None:
            dash_x[i] += lost_x
            dash_y[i] += lost_y
        if slide_x is not None:
            slide_x[i] += slid_x
            slide_y[i] += slid_y


def _wall_forces_py(
    x, y, radius, ux, uy, omega, fx, fy, torque, fixed, faces, near, law, friction, sign, touch, memory,
    dash_x, dash_y, slide_x, slide_y, moves, work, wall_sum,
):  # fmt: skip
    """Add the forces of walls to the discs that `near` lists a wall at a time; the opposite to ``wall_sum``.

    Fixed discs feel no wall, and no wall feels them.

    ``wall_sum[wall]`` collects the force on the wall, its moment about ``near.about[wall]`` (where the wall is now),
    counter-clockwise positive, acting at the contact point, and the power of the wall on the discs (fx, fy, moment,
    power). Power is that of the velocity centred on the step, so that its sum over steps is the energy that discs gain.
    ``work[2]`` takes that sum times the step. Dashpots and friction dissipate at the velocity against the wall, so that
    ``work[0]`` and ``work[1]`` take what they do on it. ``work[3:6]`` holds this step's part of the three.
    """
    codes, shape, deep = faces.codes, faces.shape, faces.deep
    found, which = near.found, near.which
    discs, plain, last, listed = near.discs, near.plain, near.last, near.faces
    rub = None if friction is None or memory is not None else 0.0
    centre_x = centre_y = 0.0
    now = near.found[0]
    if moves is not None:
        work[3] = work[4] = work[5] = 0.0
    for wall in range(deep.size):
        k, damping, ct = near.numbers[wall, 0], near.numbers[wall, 1], near.numbers[wall, 2]
        if friction is not None and memory is None:
            rub = near.numbers[wall, 3]
        x_ref, y_ref = near.about[wall, 0], near.about[wall, 1]
        wall_x = wall_y = moment = 0.0
        lost_x = lost_y = lost_turn = slid_x = slid_y = slid_turn = 0.0
        moving = False
        if moves is not None:
            moving = moves.moving[wall] > 0
        if moving:
            centre_x, centre_y = moves.centre[wall, 0], moves.centre[wall, 1]
            now = moves.now[wall]
            x_ref, y_ref = x_ref + now[0], y_ref + now[1]
        for row in range(near.rows[wall], near.rows[wall + 1]):
            i = discs[row]
            if fixed is not None:
                if fixed[i] != 0:
                    continue
            own = 0.5 * law.diameter if radius is None else radius[i]
            count, gap, nx, ny = 1, 0.0, 0.0, 0.0
            px, py = x[i], y[i]
            if moving:  # into the frame in which the wall stands
                dx, dy = px - centre_x - now[0], py - centre_y - now[1]
                px, py = centre_x + now[3] * dx + now[4] * dy, centre_y - now[4] * dx + now[3] * dy
            several = plain[row] == 0
            inner_x, inner_y, face = px, py, listed[last[row]]
            if several:
                count = touching_inline(
                    codes, shape, deep[wall], listed, last[row], last[row + 1], px, py, own, found, which
                )
            else:
                nx, ny = -shape[face, TY0], shape[face, TX0]
                gap = ny * (py - shape[face, Y0]) + nx * (px - shape[face, X0])
                if gap >= own or (gap <= -own and deep[wall] == 0):
                    continue
            for contact in range(count):
                if several:
                    gap, nx, ny = found[contact, 0], found[contact, 1], found[contact, 2]
                size = 1.0 if radius is None else own
                rim = 0.0 if omega is None else own * omega[i]
                numbers = (k, damping * size, ct * size)
                slip_x, slip_y = ux[i], uy[i]
                if moving:
                    nx, ny = now[3] * nx - now[4] * ny, now[4] * nx + now[3] * ny
                    slip_x -= now[5] - now[7] * (y[i] - gap * ny - centre_y - now[1])
                    slip_y -= now[6] + now[7] * (x[i] - gap * nx - centre_x - now[0])
                px, py, ft, dashpot = contact_force(
                    own - gap, (nx, ny), (slip_x, slip_y), rim, numbers, rub, sign, touch
                )
                if memory is not None:
                    if several:
                        face = which[contact]
                    ft, turn = _wall_springs(
                        memory, i, (wall, face, foot_at(codes, shape, face, inner_x, inner_y)), own,
                        slip_y * nx - slip_x * ny - rim, 0.0 if omega is None else omega[i], px * nx + py * ny,
                        (numbers[0], numbers[1], near.numbers[wall, 3]),
                    )  # fmt: skip
                    px -= ft * ny
                    py += ft * nx
                    if omega is not None:
                        torque[i] += turn
                if friction is not None:
                    if omega is not None and memory is None:
                        torque[i] -= own * ft
                    if slide_x is not None:
                        slide_x[i] -= ft * ny
                        slide_y[i] += ft * nx
                if dash_x is not None:
                    dash_x[i] += dashpot * nx
                    dash_y[i] += dashpot * ny
                    if moving:
                        arm_x, arm_y = x[i] - gap * nx - centre_x - now[0], y[i] - gap * ny - centre_y - now[1]
                        lost_x += dashpot * nx
                        lost_y += dashpot * ny
                        lost_turn += dashpot * (arm_x * ny - arm_y * nx)
                        slid_x -= ft * ny
                        slid_y += ft * nx
                        slid_turn += ft * (arm_x * nx + arm_y * ny)
                fx[i] += px
                fy[i] += py
                wall_x -= px
                wall_y -= py
                moment += (y[i] - gap * ny - y_ref) * px - (x[i] - gap * nx - x_ref) * py
        wall_sum[wall, 0] += wall_x
        wall_sum[wall, 1] += wall_y
        wall_sum[wall, 2] += moment
        if moving:
            moves.pushed[wall, 4], moves.pushed[wall, 5] = wall_x, wall_y
            if moves.moving[wall] == 2:
                _see_lid(moves, wall)
            dt, vx, vy, turn = moves.clock[2], now[8], now[9], now[10]
            power = -(wall_x * vx + wall_y * vy + moment * turn)
            wall_sum[wall, 3] += power
            work[3] += dt * (lost_x * vx + lost_y * vy + lost_turn * turn)
            work[4] += dt * (slid_x * vx + slid_y * vy + slid_turn * turn)
            if moves.moving[wall] == 1:  # the energy of a lid is part of the whole
                work[5] += dt * power
    if moves is not None:
        for c in range(3):
            work[c] += work[3 + c]


def _advance_py(
    steps, owed, n, x, y, radius, vx, vy, fx, fy, x0, y0, ux, uy, omega, torque, uomega,
    owner, start, neighbours, shift, fixed, grid, faces, near, law, motion, friction, sign, touch, memory,
    dash_x, dash_y, slide_x, slide_y, moves, work, wall_sum,
):  # fmt: skip
    """Up to `steps` drifts with forces between them, and before them where these are `owed`; without steps these alone.

    The forces after the last drift are left to the caller: what happens at a step happens between its drift and its
    forces. Returns (drifts done, whether the list has become too old for the forces). With a `grid` the pairs are
    searched anew every step (`_cell_pairs`); the list is then too old where a disc is outside the grid or `neighbours`
    is short.
    """
    done = 0
    while True:
        if owed:
            rows = n if shift is None else shift.size
            if grid is not None:
                rows = _cell_pairs(n, x, y, radius, law.diameter, grid, owner, start, neighbours)
                if rows < 0:
                    return done, True
            if ux is None:
                seen_x, seen_y, turned = vx, vy, omega
            else:
                seen_x, seen_y, turned = ux, uy, uomega
            inverse_eps = slope(n, seen_x, seen_y, sign)
            _pair_forces(
                rows, owner, x, y, radius, seen_x, seen_y, turned, fx, fy, torque, start, neighbours, shift, fixed, law,
                friction, inverse_eps, touch, memory, dash_x, dash_y, slide_x, slide_y,
            )  # fmt: skip
            _wall_forces(
                x, y, radius, seen_x, seen_y, turned, fx, fy, torque, fixed, faces, near, law,
                friction, inverse_eps, touch, memory, dash_x, dash_y, slide_x, slide_y, moves, work, wall_sum,
            )  # fmt: skip
            if fixed is not None:
                _hold(n, fixed, fx, fy, torque, dash_x, dash_y, slide_x, slide_y)
            if memory is not None and memory.time_step > 0.0:
                end_step(memory.slots, n)
        if steps == 0:
            return 0, False
        moved = _kick_drift(
            n, x, y, radius, vx, vy, fx, fy, x0, y0, motion, ux, uy, omega, torque, uomega,
            dash_x, dash_y, slide_x, slide_y, work,
        )  # fmt: skip
        done, owed = done + 1, True
        if moves is not None:
            _drift_lids(moves, moves.clock[0] + done)
            if _place_walls(moves, moves.clock[0] + done):
                moved += 1
        if moved > 0 or done == steps:
            return done, moved > 0


def _cell_pairs_py(n, x, y, radius, diameter, grid, owner, start, neighbours):
    """Touching pairs by the thesis' contact search (its chapter 3); the number of rows, or -1.

    Every disc is entered in each cell that its square overlaps; within a cell every two discs are tried, and a
    touching pair counts only in the cell that holds its contact point, which divides the line of centres as the radii.
    Row r of the list belongs to disc ``owner[r]``. Only the window of cells that discs occupy is looked at. -1: a disc
    is outside the grid, or `neighbours` is short.
    """
    inverse = grid.inverse
    half = 0.5 * diameter
    first = grid.first
    left, right, low, high = grid.columns, -1, grid.rows, -1
    for i in range(n):
        px = (x[i] - grid.x_low) * inverse
        py = (y[i] - grid.y_low) * inverse
        if not (px >= 0.0 and px < grid.columns and py >= 0.0 and py < grid.rows):
            return -1
        reach = (half if radius is None else radius[i]) * inverse
        left = min(left, int(max(px - reach, 0.0)))
        right = max(right, min(int(px + reach), grid.columns - 1))
        low = min(low, int(max(py - reach, 0.0)))
        high = max(high, min(int(py + reach), grid.rows - 1))
    rows = max(high - low + 1, 0)
    cells = rows * max(right - left + 1, 0)
    for c in range(cells + 2):
        first[c] = 0
    for i in range(n):
        px = (x[i] - grid.x_low) * inverse
        py = (y[i] - grid.y_low) * inverse
        reach = (half if radius is None else radius[i]) * inverse
        for cx in range(int(max(px - reach, 0.0)) - left, min(int(px + reach), right) - left + 1):
            for cy in range(int(max(py - reach, 0.0)) - low, min(int(py + reach), high) - low + 1):
                first[cx * rows + cy + 2] += 1
    for c in range(2, cells + 2):
        first[c] += first[c - 1]
    for i in range(n):
        px = (x[i] - grid.x_low) * inverse
        py = (y[i] - grid.y_low) * inverse
        reach = (half if radius is None else radius[i]) * inverse
        for cx in range(int(max(px - reach, 0.0)) - left, min(int(px + reach), right) - left + 1):
            for cy in range(int(max(py - reach, 0.0)) - low, min(int(py + reach), high) - low + 1):
                place = first[cx * rows + cy + 1]
                owner[place] = i
                first[cx * rows + cy + 1] = place + 1
    count = 0
    start[0] = 0
    for c in range(cells):
        last = first[c + 1]
        for a in range(first[c], last):
            i = owner[a]
            xi, yi = x[i], y[i]
            ri = half if radius is None else radius[i]
            if count + last - a > neighbours.size:
                return -1
            for b in range(a + 1, last):
                j = owner[b]
                dx = xi - x[j]
                dy = yi - y[j]
                rj = half if radius is None else radius[j]
                if dx * dx + dy * dy < (ri + rj) * (ri + rj):
                    share = 0.5 if radius is None else rj / (ri + rj)
                    cx = int((share * xi + (1.0 - share) * x[j] - grid.x_low) * inverse) - left
                    cy = int((share * yi + (1.0 - share) * y[j] - grid.y_low) * inverse) - low
                    if cx * rows + cy == c:
                        neighbours[count] = j
                        count += 1
            start[a + 1] = count
    grid.used[0] = first[cells]
    return first[cells]


def _elastic_py(
    begin, rows, owner, start, neighbours, shift, fixed, x, y, radius, faces, near, law, touch, ids, known, moves
):  # fmt: skip
    """Elastic energy (J per m of width), largest overlap (m), its disc and wall; with `ids`, of ids above `known`.

    Rows of the list before `begin` are left out. Each contact stores stiffness times
    `lammps_jump.physics.law.stored_energy`. The wall is -1 where the largest overlap is that of two discs.
    """
    pairs = walls = 0.0
    worst = 0.0
    where = met = -1
    half = 0.5 * law.diameter
    for row in range(begin, rows):
        i = row if owner is None else owner[row]
        for p in range(start[row], start[row + 1]):
            j = neighbours[p]
            if ids is not None and ids[i] <= known and ids[j] <= known:
                continue
            reach = law.diameter if radius is None else radius[i] + radius[j]
            dx = x[i] - x[j] + (0.0 if shift is None else shift[row])
            overlap = reach - sqrt(dx**2 + (y[i] - y[j]) ** 2)
            if overlap > 0.0:
                pairs += law.stiffness * stored_energy(overlap, touch)
                if overlap > worst:
                    worst, where = overlap, i
    for wall in range(faces.deep.size):
        for row in range(near.rows[wall], near.rows[wall + 1]):
            i = near.discs[row]
            if ids is not None and ids[i] <= known:
                continue
            if fixed is not None:
                if fixed[i] != 0:
                    continue
            own = half if radius is None else radius[i]
            px, py = _inward(moves, wall, x[i], y[i])
            count = touching(
                faces.codes, faces.shape, faces.deep[wall], near.faces, near.last[row], near.last[row + 1], px, py,
                own, near.found, near.which,
            )  # fmt: skip
            for contact in range(count):
                overlap = own - near.found[contact, 0]
                walls += near.numbers[wall, 0] * stored_energy(overlap, touch)
                if overlap > worst:
                    worst, where, met = overlap, i, wall
    return pairs + walls, worst, where, met


def _contacts_py(
    ids, rows, owner, start, neighbours, shift, fixed, x, y, radius, ux, uy, turned, vx, vy, omega, faces, near, law,
    friction, inverse_eps, touch, memory, moves, who, found,
):  # fmt: skip
    """List the contacts with their forces: the number of contacts, or -1 where `who` and `found` are too short.

    Forces are those of the step: with the velocities ux, uy (m/s) and `turned` (rad/s) that they saw. The power that
    dashpots and friction take is with those at the step, vx, vy and `omega`: dt times their sum is what the energy
    balance books for the kick. ``who[k]`` takes the id of the disc that the force acts on and that of the other, or
    -1 - wall; ``found[k]`` the point (m), the force (N per m of width) and the power (W per m of width).
    """
    count = 0
    own = friction if memory is None else None
    for row in range(rows):
        i = row if owner is None else owner[row]
        a = 0.5 * law.diameter if radius is None else radius[i]
        for p in range(start[row], start[row + 1]):
            j = neighbours[p]
            b = a if radius is None else radius[j]
            xi = x[i] if shift is None else x[i] + shift[row]
            dx, dy = xi - x[j], y[i] - y[j]
            r2 = dx * dx + dy * dy
            if r2 >= (a + b) * (a + b):
                continue
            if count == who.shape[0]:
                return -1
            r = sqrt(r2)
            nx, ny, overlap = dx / r, dy / r, a + b - r
            size = 1.0
            if radius is not None:
                size = _pair_size(_bulk(radius, fixed, i), _bulk(radius, fixed, j))
            numbers = (law.stiffness, law.damping * size, law.tangential * size)
            rim = turn = 0.0
            if omega is not None:
                dent = 0.0 if radius is None else 0.5 * overlap
                rim = a * turned[i] + b * turned[j]
                turn = (a - dent) * omega[i] + (b - dent) * omega[j]
            slip = (ux[i] - ux[j], uy[i] - uy[j])
            px, py, rub, dash = contact_force(overlap, (nx, ny), slip, rim, numbers, own, inverse_eps, touch)
            if memory is not None:
                spins = (0.0, 0.0) if omega is None else (turned[i], turned[j])
                rub, on_one, on_two = _pair_springs(
                    memory, (i, j), (a, b), overlap, slip[1] * nx - slip[0] * ny - rim, spins, px * nx + py * ny,
                    (law.stiffness, law.damping * size, friction),
                )  # fmt: skip
                px, py = px - rub * ny, py + rub * nx
                if omega is not None and rub != 0.0:
                    turn = -(on_one * omega[i] + on_two * omega[j]) / rub
            sx, sy = vx[i] - vx[j], vy[i] - vy[j]
            who[count, 0], who[count, 1] = ids[i], ids[j]
            way = a - 0.5 * overlap
            _put(found[count], xi - way * nx, y[i] - way * ny, px, py, nx, ny, sx, sy, dash, rub, turn)
            count += 1
    for wall in range(faces.deep.size):
        for row in range(near.rows[wall], near.rows[wall + 1]):
            i = near.discs[row]
            if fixed is not None:
                if fixed[i] != 0:
                    continue
            a = 0.5 * law.diameter if radius is None else radius[i]
            px, py = _inward(moves, wall, x[i], y[i])
            several = touching(
                faces.codes, faces.shape, faces.deep[wall], near.faces, near.last[row], near.last[row + 1], px, py,
                a, near.found, near.which,
            )  # fmt: skip
            if count + several > who.shape[0]:
                return -1
            size = 1.0 if radius is None else a
            numbers = (near.numbers[wall, 0], near.numbers[wall, 1] * size, near.numbers[wall, 2] * size)
            rub_here = None if own is None else near.numbers[wall, 3]
            rim = turn = 0.0
            if omega is not None:
                rim, turn = a * turned[i], a * omega[i]
            for contact in range(several):
                gap = near.found[contact, 0]
                nx, ny = _outward(moves, wall, near.found[contact, 1], near.found[contact, 2])
                at_x, at_y = x[i] - gap * nx, y[i] - gap * ny
                wx, wy = _wall_velocity(moves, wall, 5, at_x, at_y)
                slip = ux[i] - wx, uy[i] - wy
                face = near.which[contact]
                foot = foot_at(faces.codes, faces.shape, face, px, py)
                qx, qy, rub, dash = contact_force(a - gap, (nx, ny), slip, rim, numbers, rub_here, inverse_eps, touch)
                if memory is not None:
                    rub, on_it = _wall_springs(
                        memory, i, (wall, face, foot), a, slip[1] * nx - slip[0] * ny - rim,
                        0.0 if omega is None else turned[i], qx * nx + qy * ny,
                        (numbers[0], numbers[1], near.numbers[wall, 3]),
                    )  # fmt: skip
                    qx, qy = qx - rub * ny, qy + rub * nx
                    if omega is not None and rub != 0.0:
                        turn = -on_it * omega[i] / rub
                wx, wy = _wall_velocity(moves, wall, 8, at_x, at_y)
                who[count, 0], who[count, 1] = ids[i], -1 - wall
                _put(found[count], at_x, at_y, qx, qy, nx, ny, vx[i] - wx, vy[i] - wy, dash, rub, turn)
                count += 1
    return count


def _put_py(row, x, y, px, py, nx, ny, sx, sy, dash, rub, turn):
    """A row of `found`: point, force, and the power of dashpot and friction at this slip and turn of the rims, m/s."""
    row[0], row[1], row[2], row[3] = x, y, px, py
    row[4] = -dash * (nx * sx + ny * sy) - rub * (nx * sy - ny * sx - turn)


def _give_sizes_py(
    known, new, n, ids, x, y, radius, vx, vy, fx, fy, omega, torque, motion, dash_x, dash_y, slide_x, slide_y,
):  # fmt: skip
    """Radii ``new[id - known - 1]`` (m) for the discs with ids above `known`, behind a step and with its forces.

    The velocities of the step stay: the first half of the step's kick is that of the old mass, the second half that of
    the new one. Returns what this gives to the energy (J per m of width): to kinetic and gravitational energy, to the
    work that dashpots and friction take in the first half, and, in the second, by the old weight on the new mass.
    """
    gained = 0.0
    dt = motion.time_step
    for i in range(n):
        if ids[i] <= known:
            continue
        old, own = radius[i] ** 2, new[ids[i] - known - 1] ** 2
        radius[i] = new[ids[i] - known - 1]
        before, after = 0.5 * dt / (motion.mass * old), 0.5 * dt / (motion.mass * own)
        wx, wy = vx[i] + before * fx[i], vy[i] + before * fy[i]
        vx[i] += (before - after) * fx[i]
        vy[i] += (before - after) * fy[i]
        gained += 0.5 * motion.mass * (own - old) * (wx * wx + wy * wy)
        gained -= (own - old) * (motion.weight_x * x[i] + motion.weight_y * y[i])
        push_x, push_y = 0.5 * dt * (old - own) * motion.weight_x, 0.5 * dt * (old - own) * motion.weight_y
        late_x, late_y = push_x / own + dt * motion.weight_x, push_y / own + dt * motion.weight_y
        gained += push_x * (wx + after * fx[i] - 0.5 * late_x / motion.mass)
        gained += push_y * (wy + after * fy[i] - 0.5 * late_y / motion.mass)
        if dash_x is not None:
            gained -= 0.25 * dt * (before - after) * (dash_x[i] * fx[i] + dash_y[i] * fy[i])
        if slide_x is not None:
            gained -= 0.25 * dt * (before - after) * (slide_x[i] * fx[i] + slide_y[i] * fy[i])
        if omega is not None:
            before, after = 0.5 * dt / (motion.inertia * old * old), 0.5 * dt / (motion.inertia * own * own)
            turn = omega[i] + before * torque[i]
            omega[i] += (before - after) * torque[i]
            gained += 0.5 * motion.inertia * (own * own - old * old) * turn * turn
            gained -= 0.25 * dt * (before - after) * torque[i] * torque[i]
    return gained


# a division by zero, which cannot be, gives inf rather than an exception: else loops do not run on vector units
_pair_size = njit(cache=True, error_model="numpy")(_pair_size_py)
_bulk = njit(cache=True)(_bulk_py)
_hold = njit(cache=True)(_hold_py)
slope = njit(cache=True)(_slope_py)
# a sum in any order runs on vector units: the ledger changes in its last digits, the trajectory does not
_power = njit(cache=True, error_model="numpy", fastmath={"reassoc", "nsz"})(_power_py)
_power_of_torque = njit(cache=True, error_model="numpy", fastmath={"reassoc", "nsz"})(_power_of_torque_py)
_kick_drift = njit(cache=True, error_model="numpy")(_kick_drift_py)
# springs: numba would count references to the arrays at every contact, atomically, which takes ten times the contact;
# nothing is allocated there, so that there is nothing to count
_spring_forces = watching_law(njit(cache=True, inline="always")(_spring_forces_py), slot_of)
_pair_springs = watching_law(njit(cache=True, inline="always")(_pair_springs_py), slot_of)
_wall_springs = watching_law(njit(cache=True, inline="always")(_wall_springs_py), slot_of)
_pair_forces = watching_law(njit(cache=True, _nrt=False)(_pair_forces_py), slot_of)
pose = njit(cache=True)(pose_py)
_place_walls = watching_law(njit(cache=True)(_place_walls_py), pose)
_inward = njit(cache=True)(_inward_py)
_outward = njit(cache=True)(_outward_py)
_wall_velocity = njit(cache=True)(_wall_velocity_py)
_see_lid = njit(cache=True)(_see_lid_py)
_drift_lids = njit(cache=True)(_drift_lids_py)
_wall_forces = watching_law(njit(cache=True, _nrt=False)(_wall_forces_py), touching, slot_of)
_cell_pairs = njit(cache=True)(_cell_pairs_py)
advance = watching_law(njit(cache=True)(_advance_py), touching, pose, slot_of)
cell_pairs = _cell_pairs
pair_size, pair_springs = _pair_size, _pair_springs
place_walls = _place_walls
elastic = watching_law(njit(cache=True)(_elastic_py), touching)
_put = njit(cache=True)(_put_py)
contacts = watching_law(njit(cache=True)(_contacts_py), touching, slot_of)
give_sizes = njit(cache=True)(_give_sizes_py)
