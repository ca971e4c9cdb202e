# SPDX-License-Identifier: GPL-2.0-or-later
"""Sums of the twin over contacts: elastic energy, the list of contacts, energy between stations; and new sizes."""

from __future__ import annotations

from math import nan

import numpy as np

from lammps_jump.core.columns import PlacedColumns
from lammps_jump.engines.native.arrays import ContactVelocities, State, StationStep
from lammps_jump.engines.native.ledger import CARRIED, CONTACTS, DASHPOTS, FRICTION, HELD, MASS_LEFT, MASS_RIGHT, WALLS
from lammps_jump.physics.law import contact_energy

from . import bodies, contact


def elastic(state: State, chosen: np.ndarray | None = None) -> tuple[float, float, int, int]:
    """Elastic energy and the largest overlap; see `Loops.elastic`."""
    law = state.constants.law
    energy, worst = 0.0, (0.0, -1, -1)
    still = _stored(state)
    for i, j, acting in contact.pair_contacts(still, contact.seen_by(state), None):
        if chosen is not None and not chosen[i] and not chosen[j]:
            continue
        energy += contact_energy(acting.overlap, law)
        worst = max(worst, (acting.overlap, i, -1), key=lambda one: one[0])
    for wall, law in enumerate(state.walls.near.laws):
        for i, _, gap, _ in contact.touched_faces(state, wall):
            if chosen is not None and not chosen[i]:
                continue
            overlap = contact.radius_of(state, i) - gap
            energy += contact_energy(overlap, law)
            worst = max(worst, (overlap, i, wall), key=lambda one: one[0])
    if state.bodies is not None and chosen is None:
        energy += bodies.elastic(state)
    return float(energy), *worst


def _stored(state: State) -> State:
    """The same without friction and memory: what springs along the normal store."""
    constants = state.constants
    return state._replace(memory=None, constants=constants._replace(law=constants.law._replace(friction=nan)))


def contacts(
    state: State, at_step: ContactVelocities, seen: ContactVelocities, who: np.ndarray, table: np.ndarray
) -> int:
    """List the contacts with their forces; see `Loops.contacts`."""
    slope, (vx, vy, spins), ids = contact.slope_of(state, seen), at_step, state.discs.ids
    rows = []
    for i, j, of in contact.pair_contacts(state, seen, slope):
        turned = 0.0 if spins is None else of.torques[0] * spins[i] + of.torques[1] * spins[j]
        rows.append(((ids[i], ids[j]), of, (vx[i] - vx[j], vy[i] - vy[j]), turned))
    for wall in range(len(state.walls.faces.deep)):
        for touched in contact.touched_faces(state, wall):
            i, of = touched[0], contact.wall_contact(state, wall, touched, seen, slope)
            wx, wy = contact.wall_velocity(state.walls.moves, wall, PlacedColumns.CENTRED, *of.point)
            turned = 0.0 if spins is None else of.torques[0] * spins[i]
            rows.append(((ids[i], -1 - wall), of, (vx[i] - wx, vy[i] - wy), turned))
    if len(rows) > len(who):
        return -1
    for k, (pair, of, (sx, sy), turned) in enumerate(rows):
        nx, ny = of.normal
        power = -of.dashpot * (nx * sx + ny * sy) - of.tangential * (nx * sy - ny * sx) - turned
        who[k], table[k] = pair, (*of.point, *of.force, power)
    return len(rows)


def give_sizes(state: State, known: int, own: np.ndarray) -> float:
    """Own radii for discs after a step; see `Loops.give_sizes`.

    The energy it gives is kinetic and gravitational, the work that dashpots and friction take in the first half of the
    kick, and, in the second half, what the old weight does on the new mass.
    """
    d, motion = state.discs, state.constants.motion
    dt, weight = motion.time_step, np.array([motion.weight_x, motion.weight_y])
    gained = 0.0
    for i in range(d.n):
        if d.ids[i] <= known:
            continue
        radius = own[d.ids[i] - known - 1]
        old, new = d.radius[i] ** 2, radius**2
        d.radius[i] = radius
        before, after = 0.5 * dt / (motion.mass * old), 0.5 * dt / (motion.mass * new)
        force, place = np.array([d.fx[i], d.fy[i]]), np.array([d.x[i], d.y[i]])
        speed = np.array([d.vx[i], d.vy[i]]) + before * force
        d.vx[i], d.vy[i] = speed - after * force
        gained += 0.5 * motion.mass * (new - old) * speed @ speed - (new - old) * weight @ place
        push = 0.5 * dt * (old - new) * weight
        late = push / new + dt * weight
        gained += push @ (speed + after * force - 0.5 * late / motion.mass)
        if d.dashpot_x is not None:
            gained -= 0.25 * dt * (before - after) * (d.dashpot_x[i] * force[0] + d.dashpot_y[i] * force[1])
        if d.friction_x is not None:
            gained -= 0.25 * dt * (before - after) * (d.friction_x[i] * force[0] + d.friction_y[i] * force[1])
        if d.omega is not None:
            slow, fast = (0.5 * dt / (motion.inertia * mass**2) for mass in (old, new))
            turn = d.omega[i] + slow * d.torque[i]
            d.omega[i] += (slow - fast) * d.torque[i]
            gained += 0.5 * motion.inertia * (new**2 - old**2) * turn**2
            gained -= 0.25 * dt * (slow - fast) * d.torque[i] ** 2
    return float(gained)


def _at_step(state: State, i: int) -> tuple[float, float, float]:
    """Velocity and spin of a disc at the step."""
    d, motion = state.discs, state.constants.motion
    square = 1.0 if d.radius is None else d.radius[i] ** 2
    half = 0.5 * motion.time_step
    spin = 0.0 if d.omega is None else d.omega[i] + half / motion.inertia / square**2 * d.torque[i]
    kick = half / motion.mass / square
    return d.vx[i] + kick * d.fx[i], d.vy[i] + kick * d.fy[i], spin


def between(state: State, stations: StationStep, sums: np.ndarray) -> None:
    """Add a step to the sums between stations; see `Loops.between` and `StationLedger`.

    Forces on a disc, F . (v - c), make up what contacts hand on through the stations, F . [(v_i + v_j)/2 - c], half of
    what such a pair dissipates, all of that of pairs inside and of walls, and the power of walls, which move backwards
    at c (docs/theory.md).
    """
    dt, speed = state.constants.motion.time_step, stations.speed
    push, dashpots, friction = _between_discs(state, stations, sums)
    if not stations.pushed:
        return
    handed, seen, x = 0.0, contact.seen_by(state), state.discs.x
    slope = contact.slope_of(state, seen)
    for i, j, _ in contact.pair_contacts(_stored(state), seen, None):
        a, b = (i, j) if x[i] < x[j] else (j, i)
        # the stations between the two: 1 for that on the left, -1 for that on the right, 0 for both or none
        left, right = (x[a] < edge <= x[b] for edge in (stations.left, stations.left + stations.width))
        if left == right:
            continue
        way = int(left) - int(right)
        of = contact.pair_contact(state, b, a, 0.0, seen, slope)
        assert of is not None
        one, two = _at_step(state, a), _at_step(state, b)
        (nx, ny), (fx, fy) = of.normal, of.force
        mx, my = 0.5 * (one[0] + two[0]), 0.5 * (one[1] + two[1])
        turn = 0.5 * (of.torques[0] * two[2] - of.torques[1] * one[2])
        friction -= way * (of.tangential * (nx * my - ny * mx) + turn)
        handed += way * (fx * (mx - speed) + fy * my + turn)
        push -= way * fx
        dashpots -= way * of.dashpot * (nx * mx + ny * my)
    sums[CONTACTS] += dt * handed
    sums[WALLS] -= dt * speed * push
    sums[DASHPOTS] -= dt * dashpots
    sums[FRICTION] -= dt * friction


def _between_discs(state: State, stations: StationStep, sums: np.ndarray) -> tuple[float, float, float]:
    """Energy that crosses the stations and that is held between them; force and losses of the discs between."""
    d, motion, (left, width, speed, moved, _) = state.discs, state.constants.motion, stations
    dt = motion.time_step
    held = push = dashpots = friction = 0.0
    for i in range(d.n):
        place, w = d.x[i] - left, d.vx[i] - speed
        now = int(place >= 0.0) + int(place >= width)
        before = int(place - dt * w >= 0.0) + int(place - dt * w >= width)
        if now != 1 and before == now:
            continue
        square = 1.0 if d.radius is None else d.radius[i] ** 2
        height = motion.weight_x * (place - 0.5 * dt * w) + motion.weight_y * (d.y[i] - 0.5 * dt * d.vy[i])
        energy = 0.5 * motion.mass * square * (w * w + d.vy[i] ** 2) - square * height
        if d.omega is not None:
            energy += 0.5 * motion.inertia * square**2 * d.omega[i] ** 2
        if moved:
            sums[MASS_LEFT] += motion.mass * square * ((now > 0) - (before > 0))
            sums[MASS_RIGHT] += motion.mass * square * ((now > 1) - (before > 1))
            sums[CARRIED] += energy * ((now == 1) - (before == 1))
        if now == 1:
            vx, vy, spin = _at_step(state, i)
            held += energy
            push += d.fx[i] - motion.weight_x * square
            dashpots += d.dashpot_x[i] * vx + d.dashpot_y[i] * vy
            if d.friction_x is not None:
                friction += d.friction_x[i] * vx + d.friction_y[i] * vy
                if d.omega is not None:
                    friction += d.torque[i] * spin
    sums[HELD] = held
    return push, dashpots, friction
