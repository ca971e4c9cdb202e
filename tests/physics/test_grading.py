# SPDX-License-Identifier: GPL-2.0-or-later
"""Grading curves in pieces against closed forms, sums over many discs, and scipy's normal distribution."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from lammps_jump.physics.grading import diameter_at, mean_squares, normal_part, number_shares, passing, passing_error

PIECES = np.array([0.5, 0.2, 0.3]), np.array([0.1, 0.2, 0.3]), np.array([0.15, 0.2, 0.4])
"""Shares, least and largest diameters: two pieces with a width, and one of equal discs."""


def drawn(count, rng):
    shares, low, high = PIECES
    piece = rng.choice(3, count, p=shares)
    return low[piece] + (high - low)[piece] * rng.random(count)


def test_the_mean_square_of_a_piece_is_the_integral():
    d = np.linspace(0.1, 0.3, 200_001)
    assert mean_squares(np.array(0.1), np.array(0.3)) == pytest.approx(np.mean(d**2), rel=1e-5)
    assert mean_squares(np.array(0.2), np.array(0.2)) == pytest.approx(0.04, rel=1e-15)


def test_shares_by_number_have_the_mass_that_was_asked():
    low, high, mass = np.array([0.05, 0.1, 0.4]), np.array([0.1, 0.3, 0.4]), np.array([0.2, 0.5, 0.3])
    shares = number_shares(low, high, mass)
    assert shares.sum() == pytest.approx(1.0, abs=1e-15)
    assert passing(shares, low, high, high) == pytest.approx([0.2, 0.7, 1.0], abs=1e-15)


@pytest.mark.parametrize("power", [0, 2, 4])
def test_passing_is_that_of_many_discs(power):
    d = drawn(400_000, np.random.default_rng(1))
    at = np.array([0.05, 0.1, 0.12, 0.15, 0.199, 0.2, 0.25, 0.33, 0.4, 0.5])
    expected = [(d[d <= one] ** power).sum() / (d**power).sum() for one in at]
    assert passing(*PIECES, at, power) == pytest.approx(expected, abs=3e-3)  # four standard errors, at the largest
    assert passing(*PIECES, 0.25, power).shape == ()


@given(part=st.floats(0.0, 1.0), power=st.sampled_from([0, 2]))
def test_diameter_at_is_the_inverse(part, power):
    d = diameter_at(*PIECES, part, power)
    assert 0.1 <= d <= 0.4
    if abs(d - 0.2) > 1e-12:  # equal discs: a step
        assert passing(*PIECES, d, power) == pytest.approx(part, abs=1e-9)
    else:
        below, above = passing(*PIECES, [0.2 - 1e-9, 0.2], power)
        assert below - 1e-9 <= part <= above + 1e-9


def test_the_counting_error_is_the_scatter_of_many_draws():
    rng, at = np.random.default_rng(2), np.array([0.11, 0.15, 0.2, 0.35])
    found = []
    for _ in range(2000):
        d = drawn(200, rng)
        found.append([(d[d <= one] ** 2).sum() / (d**2).sum() for one in at])
    # of 2000 draws a standard deviation is known to 1.6 %; the formula is that of many discs, off by some 1/200
    assert passing_error(*PIECES, at, 200) == pytest.approx(np.std(found, axis=0), rel=0.07)
    assert passing_error(*PIECES, [0.4, 0.05], 200) == pytest.approx([0, 0], abs=1e-12)


@given(st.floats(-5.0, 5.0))
def test_the_normal_part_is_that_of_scipy(z):
    assert normal_part(z) == pytest.approx(norm.cdf(z), abs=1e-15)
