# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact law: normal force, friction, stored energy (thesis 3.11, 4.18-4.21), and what a disc remembers of a contact.

Plain functions of one contact, which the twin calls. The core and the plugin have them in ``core/contact/law.h``;
tests compare the two.

`touch` is the width s (m) of a smooth touch, or None for a sharp one. With overlap delta and stiffness k, the spring of
a smooth touch is k delta^2/(2 s) below delta = s and k (delta - s/2) beyond. Its dashpot is c F / sqrt(2 k E), where F
is the spring's force and E its energy. The restitution is then that of the linear law at every speed and width (derived
in docs/kernels.md).

A partner is the id of a disc, above 0, or -1 - c for chain c of the scene's walls. A disc may touch one chain at
several places. There the arc length of the foot tells the contacts apart, and the nearest one goes on. So a contact
goes on over the joints of a wall, and turns with a wall that moves.
"""

from __future__ import annotations

from math import isnan, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.core.law import LawNumbers

Pair = tuple[float, float]
"""Along x and y."""


def normal_force(
    overlap: float, opening: float, stiffness: float, damping: float, touch: float | None, cohesion: float = 0.0
) -> tuple[float, float]:
    """Normal force and its dashpot part, N per m of width, positive where they push apart; tensile tail kept (3.11).

    Parameters
    ----------
    overlap : float
        m, above 0.
    opening : float
        Normal speed at which the two part, m/s.
    stiffness, damping : float
        N/m and N s/m, per m of width.
    touch : float or None
        Width of a smooth touch, m.
    cohesion : float
        Constant attraction of what touches, N per m of width.
    """
    if touch is None:
        dashpot = -damping * opening
        return stiffness * overlap - cohesion + dashpot, dashpot
    if overlap < touch:
        dashpot = -damping * opening * sqrt(0.75 * overlap / touch)
        return 0.5 * stiffness * overlap * overlap / touch - cohesion + dashpot, dashpot
    beyond = overlap - 0.5 * touch
    dashpot = -damping * opening * beyond / sqrt(beyond * beyond + touch * touch / 12.0)
    return stiffness * beyond - cohesion + dashpot, dashpot


def friction_force(normal: float, slip: float, friction: float, damping: float, slope: float | None) -> float:
    """Friction, N per m of width, against the slip; at most friction abs(normal) (Coulomb).

    Parameters
    ----------
    normal : float
        Normal force, N per m of width.
    slip : float
        Tangential speed at the contact, m/s.
    friction : float
        Coefficient of friction μ.
    damping : float
        Slope of LAMMPS' viscous ramp (gran/hooke), N s/m per m of width.
    slope : float or None
        1/eps (s/m) of the thesis' law μ abs(F_n) sat(v_t / eps) (4.18-4.21); None for the viscous ramp.
    """
    bound = friction * abs(normal)
    if slope is None:
        return min(max(-damping * slip, -bound), bound)
    return -bound * min(max(slip * slope, -1.0), 1.0)


def slider(stretch: float, slip: float, bound: float, stiffness: float, damping: float) -> tuple[float, float]:
    """Force of a spring and dashpot that slides at a bound, N per m of width, and the stretch that is left, m.

    The force is that of Cundall & Strack (1979); where it slides the spring keeps what the bound leaves of it (Luding
    2008, eq. 21).

    Parameters
    ----------
    stretch : float
        Elongation of the spring with the way of this step, m.
    slip : float
        m/s.
    bound : float
        Largest force, N per m of width.
    stiffness, damping : float
        N/m and N s/m, per m of width.
    """
    force = -stiffness * stretch - damping * slip
    if abs(force) > bound:
        force = bound if force > 0.0 else -bound
        stretch = -(force + damping * slip) / stiffness if stiffness > 0.0 else 0.0
    return force, stretch


def stored_energy(overlap: float, touch: float | None) -> float:
    """Elastic energy over stiffness, m^2: integral of the spring's force over the overlap (thesis 4.28).

    delta^2/2; with a smooth touch delta^3/(6 s) below delta = s and (delta^2 - s delta + s^2/3)/2 beyond.
    """
    if touch is None:
        return 0.5 * overlap * overlap
    if overlap < touch:
        return overlap**3 / (6.0 * touch)
    return 0.5 * (overlap * overlap - touch * overlap + touch * touch / 3.0)


def spring_of(of: LawNumbers) -> float:
    """Stiffness of the spring along the normal, N/m."""
    return of.stiffness


def contact_energy(overlap: float, of: LawNumbers) -> float:
    """Energy stored in a contact, J per m of width: that of its spring, less what the attraction has given."""
    return spring_of(of) * stored_energy(overlap, of.touch or None) - of.cohesion * overlap


def pressing(push: float, of: LawNumbers) -> float:
    """Part of a normal force that presses the two together, N per m of width: it bounds friction.

    The spring holds the attraction (Derjaguin, Muller & Toporov 1975).
    """
    return push + of.cohesion


def contact_force(
    overlap: float, normal: Pair, slip: Pair, rim: float, of: LawNumbers, slope: float | None
) -> tuple[float, float, float, float]:
    """The whole force of one contact on a disc: (fx, fy, tangential, dashpot), N per m of width.

    The tangential force acts along (-ny, nx); the dashpot is part of the normal force, along the normal.

    Parameters
    ----------
    overlap : float
        m, above 0.
    normal : (float, float)
        Unit vector towards the disc from what it touches.
    slip : (float, float)
        Velocity of the disc's centre against that of its partner, m/s.
    rim : float
        Speed of the rims, R_i omega_i + R_j omega_j, m/s; 0 without spin.
    of : LawNumbers
        `damping` and `tangential` are those of this contact. Friction NaN: there is none.
    slope : float or None
        As in `friction_force`. Friction is bounded by what presses the two together (`pressing`).
    """
    nx, ny = normal
    vx, vy = slip
    opening = vx * nx + vy * ny
    push, dashpot = normal_force(overlap, opening, spring_of(of), of.damping, of.touch or None, of.cohesion)
    fx = push * nx
    fy = push * ny
    tangential = 0.0
    if not isnan(of.friction):
        tangential = friction_force(pressing(push, of), vy * nx - vx * ny - rim, of.friction, of.tangential, slope)
        fx -= tangential * ny
        fy += tangential * nx
    return fx, fy, tangential, dashpot


FULL = -1
"""Number that `slot_of` returns where a disc has no slot left."""


class Slots(NamedTuple):
    """Contact history of discs, S contacts each.

    Attributes
    ----------
    partner : ndarray of int64, shape (n, S)
        0 in an empty slot.
    sigma, spring, roll : ndarray, shape (n, S)
        Arc length of the foot, elongation of the tangential spring and of the rolling spring, m.
    used : ndarray of int8, shape (n, S)
        1 where a contact of this step has the slot; `end_step` takes it to 0.
    """

    partner: np.ndarray
    sigma: np.ndarray
    spring: np.ndarray
    roll: np.ndarray
    used: np.ndarray


def slot_of(slots: Slots, i: int, partner: int, foot: float, limit: float, around: float) -> int:
    """Slot of a contact of disc i in this step: that of its partner, or an empty one with springs at 0.

    Returns `FULL` where there is neither; nothing is then changed.

    Parameters
    ----------
    slots : Slots
    i : int
    partner : int
    foot : float
        Arc length of the foot on a wall, m; of no meaning between discs.
    limit : float
        Largest way of the foot along a wall since the last step, m; a foot further off is another contact.
    around : float
        Length of a closed chain, m; 0 of an open one.
    """
    best, free, least = FULL, FULL, limit
    for s in range(slots.partner.shape[1]):
        held = slots.partner[i, s]
        if held == 0 and free == FULL:
            free = s
        if held != partner or slots.used[i, s] == 1:
            continue
        way = 0.0
        if partner < 0:
            way = abs(foot - slots.sigma[i, s])
            if around > 0.0:
                way = min(way % around, around - way % around)
        if way <= least:
            best, least = s, way
    if best == FULL:
        if free == FULL:
            return FULL
        best = free
        slots.partner[i, best] = partner
        slots.spring[i, best] = slots.roll[i, best] = 0.0
    slots.sigma[i, best] = foot
    slots.used[i, best] = 1
    return best


def held(slots: Slots, i: int, partner: int, foot: float, limit: float, around: float) -> int:
    """Slot in which disc i remembers a contact, as `slot_of` finds it, or `FULL`; nothing is changed."""
    best, least = FULL, limit
    for s in range(slots.partner.shape[1]):
        if slots.partner[i, s] != partner:
            continue
        way = 0.0
        if partner < 0:
            way = abs(foot - slots.sigma[i, s])
            if around > 0.0:
                way = min(way % around, around - way % around)
        if way <= least:
            best, least = s, way
    return best


def end_step(slots: Slots, n: int) -> None:
    """Empty the slots of the first n discs whose contacts have ended."""
    for i in range(n):
        for s in range(slots.partner.shape[1]):
            if slots.used[i, s] == 0:
                slots.partner[i, s] = 0
                slots.sigma[i, s] = slots.spring[i, s] = slots.roll[i, s] = 0.0
            slots.used[i, s] = 0
