# SPDX-License-Identifier: GPL-2.0-or-later
"""Slots: what a disc remembers of each of its contacts, found again by the partner.

A partner is the id of a disc, above 0, or -1 - c for chain c of the scene's walls. A disc may touch one chain at
several places. There the arc length of the foot tells the contacts apart, and the nearest one goes on. So a contact
goes on over the joints of a wall, and turns with a wall that moves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

FULL = -1
"""What `slot_of` returns where a disc has no slot left."""


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
