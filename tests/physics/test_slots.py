# SPDX-License-Identifier: GPL-2.0-or-later
"""slots.py: a contact finds what it left behind, another one does not."""

import numpy as np
import pytest

from lammps_jump.physics.law import FULL, Slots, end_step, slot_of

WALL = -1


@pytest.fixture
def slots():
    """Of two discs with three slots each."""
    numbers = (np.zeros((2, 3)) for _ in range(3))
    return Slots(np.zeros((2, 3), np.int64), *numbers, np.zeros((2, 3), np.int8))


def pair(slots, i, other):
    return slot_of(slots, i, other, 0.0, 0.1, 0.0)


def wall(slots, i, foot, around=0.0):
    return slot_of(slots, i, WALL, foot, 0.1, around)


def test_a_partner_is_found_again_with_its_springs(slots):
    slots.spring[1, pair(slots, 1, 7)], slots.roll[1, pair(slots, 1, 9)] = 0.25, 0.5
    end_step(slots, 2)
    assert slots.roll[1, pair(slots, 1, 9)] == 0.5 and slots.spring[1, pair(slots, 1, 7)] == 0.25
    assert slots.partner.tolist() == [[0, 0, 0], [7, 9, 0]] and not slots.used[0].any()


def test_a_contact_that_has_ended_is_forgotten(slots):
    slots.spring[0, pair(slots, 0, 7)] = 0.25
    end_step(slots, 2)
    end_step(slots, 2)  # a step without it
    assert slots.partner[0].tolist() == [0, 0, 0]
    assert slots.spring[0, pair(slots, 0, 7)] == 0.0


def test_the_nearest_foot_on_a_wall_goes_on(slots):
    for foot in (2.0, 2.15):
        slots.spring[0, wall(slots, 0, foot)] = foot
    end_step(slots, 2)
    assert slots.spring[0, wall(slots, 0, 2.09)] == 2.15
    assert slots.spring[0, wall(slots, 0, 2.06)] == 2.0  # the nearer one has its contact already
    end_step(slots, 2)
    assert sorted(slots.sigma[0]) == [0.0, 2.06, 2.09]
    assert slots.spring[0, wall(slots, 0, 2.25)] == 0.0  # further off than the limit: another contact


def test_a_closed_chain_goes_on_over_its_beginning(slots):
    slots.spring[0, wall(slots, 0, 0.02, around=5.0)] = 0.25
    end_step(slots, 2)
    assert slots.spring[0, wall(slots, 0, 4.97, around=5.0)] == 0.25
    end_step(slots, 2)
    assert slots.spring[0, wall(slots, 0, 0.03)] == 0.0  # an open chain does not


def test_a_disc_without_an_empty_slot_says_so_and_keeps_what_it_has(slots):
    assert [pair(slots, 0, other) for other in (4, 5, 6)] == [0, 1, 2]
    assert pair(slots, 0, 7) == FULL and wall(slots, 0, 1.0) == FULL
    assert slots.partner[0].tolist() == [4, 5, 6] and pair(slots, 1, 7) == 0
