# SPDX-License-Identifier: GPL-2.0-or-later
"""The controller of a tailgate, on a channel of two volumes: no discs, so that what it finds is known."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from lammps_jump.physics import jump
from lammps_jump.physics.devices import (
    Holding,
    gate_areas,
    gate_gains,
    gate_sees,
    gate_speed,
    wave_travel,
)

G = 9.81
STEP = 0.4
"""Time between two looks of the gate, s."""


def crest_over(discharge):
    """Head over a broad crest, m: 1.5 yc."""
    return 1.5 * jump.critical_depth(discharge, G)


def flows_over(head):
    """Discharge over a broad crest, m^2/s: the inverse."""
    return sqrt(G) * max(head / 1.5, 0.0) ** 1.5


class Channel:
    """A jet of depth y1 (m) and speed u1 (m/s), a front that is a bore, and level water up to a gate at x = 60 m."""

    def __init__(self, u1, y1, front, crest):
        self.u1, self.y1, self.x, self.z = u1, y1, front, crest
        self.h = jump.sequent_depth(u1, y1, G)

    def front_speed(self):
        """Speed of the bore into the jet for which the depth behind is sequent (its Froude number is relative), m/s."""
        ratio = max(self.h / self.y1, 1.0)
        return self.u1 - sqrt(G * self.y1 * ratio * (ratio + 1.0) / 2.0)

    def advance(self, duration, pieces=40):
        dt = duration / pieces
        for _ in range(pieces):
            s = self.front_speed()
            length = max(60.0 - self.x, 1.0)
            gain = self.u1 * self.y1 - flows_over(self.h - self.z)
            self.h += dt * (gain + s * (self.h - self.y1)) / length
            self.x = min(max(self.x + dt * s, 0.0), 59.0)

    def areas(self, bins=600):
        middle = (np.arange(bins) + 0.5) * 60.0 / bins
        return np.where(middle < self.x, self.y1, self.h) * 60.0 / bins


def holding_of(u1, y1, front, way=(-5.0, 6.0), speed=0.3):
    y2 = jump.sequent_depth(u1, y1, G)
    length = 60.0 - front
    travel = wave_travel(length, y2, u1 * y1 / y2, G)
    gains = gate_gains(travel, travel, length, (y2 - y1) / length)
    return Holding(0.0, 60.0, 600, front, 0.5 * (y1 + y2), *gains, speed, *way, 1, 1)


def hold(channel, holding, duration):
    """Crest and front at each look."""
    start, before, rows = channel.z, None, []
    for _ in range(int(duration / STEP)):
        seen, area = gate_sees(holding, channel.areas())
        lost = 0.0 if before is None else (before - area) / STEP
        before = area
        speed = gate_speed(holding, channel.z - start, seen, lost, STEP)
        channel.z += speed * STEP
        channel.advance(STEP)
        rows.append((channel.z, channel.x))
    return np.array(rows)


@pytest.mark.parametrize("froude", [3.0, 5.11, 8.0])
@pytest.mark.parametrize("off", [-1.5, -0.8, 0.7, 1.5])
def test_the_gate_finds_the_crest_that_energy_asks_for(froude, off):
    """Water over a broad crest: z = y2 - 1.5 yc, whatever it begins from; within 60 s where it is steep."""
    y1, u1 = 1.0, froude * sqrt(G)
    wanted = jump.sequent_depth(u1, y1, G) - crest_over(u1 * y1)
    rows = hold(Channel(u1, y1, 30.0, wanted + off), holding_of(u1, y1, 30.0), 140.0)
    assert np.abs(rows[int((60.0 if froude > 4 else 100.0) / STEP) :, 0] - wanted).max() < 0.1
    assert abs(rows[-1, 1] - 30.0) < 0.6
    if froude > 4:  # with twice the reset time the front is off by more up to 56 s
        assert np.abs(rows[int(45.0 / STEP) :, 1] - 30.0).max() < 0.5


def test_a_front_without_its_change_of_area_swings():
    """Why the gate also needs A': with the integral alone the front swings to the ends of the channel."""
    u1, y1 = 16.0, 1.0
    wanted = jump.sequent_depth(u1, y1, G) - crest_over(u1 * y1)
    holding = holding_of(u1, y1, 30.0)._replace(proportional=0.0)
    rows = hold(Channel(u1, y1, 30.0, wanted - 0.8), holding, 240.0)
    assert np.ptp(rows[300:, 1]) > 10.0


def test_an_end_of_the_way_does_not_wind_up():
    """It has stood at its end for 60 s, and leaves it as soon as the front comes back."""
    holding = holding_of(16.0, 1.0, 30.0, way=(0.0, 1.0))
    assert gate_speed(holding, 1.0, 55.0, 5.0, STEP) == 0.0
    assert gate_speed(holding, 1.0, 20.0, 0.0, STEP) < 0.0
    # it does not go beyond the end between two looks
    assert gate_speed(holding, 0.99, 55.0, 50.0, STEP) == pytest.approx(0.01 / STEP)


def test_a_depth_is_held_by_its_difference_over_the_response():
    holding = Holding(54.0, 56.0, 1, 6.7, 0.0, *gate_gains(5.0, 2.0, 4.0), 0.3, -2.0, 2.0, 1, 1)
    seen, area = gate_sees(holding, np.array([12.4]))
    assert (seen, area) == (pytest.approx(6.2), 12.4)
    assert gate_speed(holding, 0.0, seen, 1e3, STEP) == pytest.approx(0.1)
    assert gate_speed(holding, 0.0, 0.0, 0.0, STEP) == 0.3


def test_the_front_lies_where_the_depth_first_comes_to_the_level():
    holding = holding_of(16.0, 1.0, 3.0)._replace(low=0.0, high=6.0, bins=6, level=3.0)
    assert gate_sees(holding, np.array([1.0, 1.0, 2.0, 4.0, 2.0, 6.0]))[0] == pytest.approx(3.0)
    assert gate_sees(holding, np.array([1.0, 1.0, 5.0, 4.0, 2.0, 6.0]))[0] == pytest.approx(2.0)
    assert gate_sees(holding, np.ones(6))[0] == 6.0  # swept out
    assert gate_sees(holding, np.full(6, 5.0))[0] == 0.0  # drowned


def test_discs_are_summed_by_the_part_in_which_their_centres_lie():
    holding = holding_of(16.0, 1.0, 3.0)._replace(low=1.0, high=3.0, bins=2)
    x = np.array([0.999, 1.0, 1.5, 2.0, 2.999, 3.0])
    assert gate_areas(holding, x, np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])).tolist() == [6.0, 24.0]


def test_a_wave_goes_up_slower_than_down():
    c, u = sqrt(G * 6.7), 16 / 6.7
    assert wave_travel(30.0, 6.7, u, G) == pytest.approx(30 / (c - u) + 30 / (c + u))
    assert wave_travel(30.0, 6.7, 20.0, G) == pytest.approx(60 / c)  # none comes up
