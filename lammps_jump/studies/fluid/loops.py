# SPDX-License-Identifier: GPL-2.0-or-later
"""Inner loops of a box without walls: periodic along x and y, sheared as Lees & Edwards (1972) do, at a held pressure.

The contact is that of `lammps_jump.physics.law`, springs are those of the native engine. Time levels are those of
LAMMPS: x_n, v_(n-1/2), F_n between steps, and the dashpot sees v_(n-1/2).

The image of a disc one height further up stands `offset` further along x and is faster by rate times height. The box
keeps its shape; where a pressure is held, it and the places in it grow by

    d(ln length)/dt = gain (P - P0)/k,   at most `cap`                                                          (1)

while velocities stay. The stress is, over the area A of the box (Irving & Kirkwood 1950; positive in compression),

    s_ab = (sum of contacts F_a r_b + sum of discs m u_a u_b) / A,   u = v - rate y                             (2)
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from lammps_jump.physics.law import contact_force, slider, watching_law
from lammps_jump.physics.slots import FULL, end_step, held, slot_of

LX, LY, OFFSET, STRAIN, PRESSURE = range(5)
"""Numbers of the box: length, height and shift of the images above (m), strain since the start, pressure (Pa)."""
SXX, SYY, SXY, AREA, KINETIC, WAVE = range(6)
"""A row of the record: means of stress (Pa), area (m^2), energy of u (J per m); the first mode at its end (m/s)."""


class Swarm(NamedTuple):
    """The discs of a box: place, velocity, spin, force, torque, radius; way against the shear since the list (m)."""

    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    torque: np.ndarray
    radius: np.ndarray
    way: np.ndarray


class Control(NamedTuple):
    """What is imposed and what does not change in a run.

    Attributes
    ----------
    rate : float
        Of shear, 1/s.
    pressure, gain, cap : float
        Of (1), Pa and 1/s; gain 0: the box stays.
    time_step, skin : float
        s, m.
    stiffness, damping, tangential : float
        N/m, and N s/m of a size of 1 m (`pair_size`).
    mass, turn : float
        Mass of a radius of 1 m (kg/m), and 1/inertia of one; `turn` is 0 where discs do not spin.
    """

    rate: float
    pressure: float
    gain: float
    cap: float
    time_step: float
    skin: float
    stiffness: float
    damping: float
    tangential: float
    mass: float
    turn: float


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


def _pair_size_py(a, b):
    """Root of the effective mass of two discs of radii a, b over the root of the mass of a radius of 1 m (m)."""
    return a * b / sqrt(a * a + b * b)


def _wrap_py(swarm, box, rate):
    """Put every disc into the box, with the velocity of its image there; no way since the list."""
    lx, ly = box[LX], box[LY]
    for i in range(swarm.x.size):
        level = np.floor(swarm.y[i] / ly)
        swarm.y[i] -= level * ly
        swarm.vx[i] -= level * rate * ly
        swarm.x[i] -= level * box[OFFSET]
        swarm.x[i] -= lx * np.floor(swarm.x[i] / lx)
        swarm.way[i, 0] = swarm.way[i, 1] = 0.0
    box[OFFSET] -= lx * np.floor(box[OFFSET] / lx)


def _list_py(swarm, box, skin, pairs):
    """List all pairs closer than the skin, surface to surface; their number, or -1 where `pairs` is short.

    A row has both discs and the image of the second: boxes up, and along. Discs are taken by their height, each with
    those above it, so that the box must be higher than twice the reach.
    """
    lx, ly, offset = box[LX], box[LY], box[OFFSET]
    x, y, radius = swarm.x, swarm.y, swarm.radius
    widest, order, number = radius.max() + skin, np.argsort(y), x.size
    count = 0
    for first in range(number):
        i = order[first]
        reach = radius[i] + skin
        if count + number > pairs.shape[0]:
            return -1
        for further in range(first + 1, first + number):
            level = further // number
            j = order[further - level * number]
            dy = y[i] - y[j] - level * ly
            if dy < -(radius[i] + widest):
                break
            dx = x[i] - x[j] - level * offset
            column = np.rint(dx / lx)
            dx -= column * lx
            far = reach + radius[j]
            pairs[count, 0], pairs[count, 1], pairs[count, 2], pairs[count, 3] = i, j, level, column
            count += dx * dx + dy * dy < far * far
    return count


def _forces_py(swarm, box, control, pairs, count, sums, friction, slope, touch, memory):
    """Forces and torques of all listed pairs; adds the contacts' part of (2), times the area, to `sums`."""
    lx, ly, offset = box[LX], box[LY], box[OFFSET]
    speed = control.rate * ly
    own = friction if memory is None else None
    for i in range(swarm.x.size):
        swarm.fx[i] = swarm.fy[i] = swarm.torque[i] = 0.0
    for p in range(count):
        i, j, level, column = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
        dx = swarm.x[i] - swarm.x[j] - level * offset - column * lx
        dy = swarm.y[i] - swarm.y[j] - level * ly
        a, b = swarm.radius[i], swarm.radius[j]
        r2 = dx * dx + dy * dy
        if r2 >= (a + b) * (a + b):
            continue
        r = sqrt(r2)
        nx, ny, overlap = dx / r, dy / r, a + b - r
        size = pair_size(a, b)
        numbers = (control.stiffness, control.damping * size, control.tangential * size)
        slip = (swarm.vx[i] - swarm.vx[j] - level * speed, swarm.vy[i] - swarm.vy[j])
        rim = a * swarm.omega[i] + b * swarm.omega[j]
        px, py, rub, _ = contact_force(overlap, (nx, ny), slip, rim, numbers, own, slope, touch)
        if memory is None:
            on_one, on_two = -(a - 0.5 * overlap) * rub, -(b - 0.5 * overlap) * rub
        else:
            rub, on_one, on_two = pair_springs(
                memory, (i, j), (a, b), overlap, slip[1] * nx - slip[0] * ny - rim, (swarm.omega[i], swarm.omega[j]),
                px * nx + py * ny, (numbers[0], numbers[1], friction),
            )  # fmt: skip
            px, py = px - rub * ny, py + rub * nx
        swarm.fx[i] += px
        swarm.fy[i] += py
        swarm.fx[j] -= px
        swarm.fy[j] -= py
        swarm.torque[i] += on_one
        swarm.torque[j] += on_two
        sums[SXX] += px * dx
        sums[SYY] += py * dy
        sums[SXY] += px * dy


def _mode_py(swarm, box):
    """Twice the mean, by mass, of vx sin(2 pi x / length), m/s: the height of a standing wave."""
    wave, total, mass = 2.0 * np.pi / box[LX], 0.0, 0.0
    for i in range(swarm.x.size):
        square = swarm.radius[i] * swarm.radius[i]
        total += square * swarm.vx[i] * np.sin(wave * swarm.x[i])
        mass += square
    return 2.0 * total / mass


def _advance_py(swarm, box, control, pairs, record, every, friction, slope, touch, memory):
    """Steps of kick, drift and forces, `every` for each row of `record`, which takes their means.

    Returns False where `pairs` is short.
    """
    dt, rate = control.time_step, control.rate
    kick, count = dt / control.mass, 0
    widest = 2.0 * swarm.radius.max() + control.skin
    sums = np.zeros(3)
    bent, grown = np.inf, 0.0  # the first step lists
    for row in range(record.shape[0]):
        for c in range(6):
            record[row, c] = 0.0
        for _ in range(every):
            ly = box[LY]
            middle = 0.5 * ly
            far = kxx = kyy = kxy = grow = 0.0
            if control.gain > 0.0:
                grow = control.gain * (box[PRESSURE] - control.pressure) / control.stiffness
                grow = min(max(grow, -control.cap), control.cap) * dt
            for i in range(swarm.x.size):
                square = swarm.radius[i] * swarm.radius[i]
                swarm.vx[i] += kick / square * swarm.fx[i]
                swarm.vy[i] += kick / square * swarm.fy[i]
                swarm.omega[i] += dt * control.turn / (square * square) * swarm.torque[i]
                ux, uy = swarm.vx[i] - rate * (swarm.y[i] - middle), swarm.vy[i]
                mass = control.mass * square
                kxx += mass * ux * ux
                kyy += mass * uy * uy
                kxy += mass * ux * uy
                swarm.x[i] += dt * swarm.vx[i]
                swarm.y[i] += dt * swarm.vy[i]
                swarm.way[i, 0] += dt * ux
                swarm.way[i, 1] += dt * uy
                far = max(far, swarm.way[i, 0] ** 2 + swarm.way[i, 1] ** 2)
            box[STRAIN] += rate * dt
            box[OFFSET] += rate * ly * dt
            bent += rate * dt
            grown += grow
            if grow != 0.0:
                for i in range(swarm.x.size):
                    swarm.x[i] *= 1.0 + grow
                    swarm.y[i] *= 1.0 + grow
                for c in range(3):
                    box[c] *= 1.0 + grow
            if not (2.0 * sqrt(far) + (abs(bent) + abs(grown)) * widest <= control.skin):
                _wrap(swarm, box, rate)
                count = _list(swarm, box, control.skin, pairs)
                if count < 0:
                    return False
                bent = grown = 0.0
            sums[SXX], sums[SYY], sums[SXY] = kxx, kyy, kxy
            _forces(swarm, box, control, pairs, count, sums, friction, slope, touch, memory)
            if memory is not None:
                end_step(memory.slots, swarm.x.size)
            area = box[LX] * box[LY]
            box[PRESSURE] = 0.5 * (sums[SXX] + sums[SYY]) / area
            for c in range(3):
                record[row, c] += sums[c] / (area * every)
            record[row, AREA] += area / every
            record[row, KINETIC] += 0.5 * (kxx + kyy) / every
        record[row, WAVE] = _mode(swarm, box)
    return True


# numba would count references to the arrays at every contact, atomically, which takes ten times the contact
_spring_forces = watching_law(njit(cache=True, inline="always")(_spring_forces_py), slot_of)
pair_springs = watching_law(njit(cache=True, inline="always")(_pair_springs_py), slot_of)
pair_size = njit(cache=True, error_model="numpy")(_pair_size_py)
_wrap = njit(cache=True)(_wrap_py)
_mode = njit(cache=True)(_mode_py)
# a division by zero, which cannot be, gives inf rather than an exception
_list = njit(cache=True, error_model="numpy")(_list_py)
_forces = watching_law(njit(cache=True, error_model="numpy")(_forces_py), pair_springs)
advance = watching_law(njit(cache=True, error_model="numpy")(_advance_py), pair_springs)
