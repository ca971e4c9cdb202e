# SPDX-License-Identifier: GPL-2.0-or-later
"""Diameters as a function of the id and the seed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.scene import handmade_scene
from lammps_jump.scene.sizes import Sizes

UNIFORM = Sizes((1.0,), (0.16,), (0.24,))
TWO = Sizes((0.7, 0.3), (0.16, 0.24), (0.16, 0.24))
THREE = Sizes((0.5, 0.2, 0.3), (0.1, 0.2, 0.3), (0.15, 0.2, 0.4), seed=7)
IDS = np.arange(1, 100_001)


@pytest.mark.parametrize("sizes", [UNIFORM, TWO, THREE], ids=["uniform", "two", "three"])
def test_shares_are_by_number(sizes):
    d = sizes.diameters(IDS)
    assert d.min() >= sizes.smallest and d.max() <= sizes.largest
    for share, low, high in zip(sizes.shares, sizes.low, sizes.high, strict=True):
        # steps of the golden section fill [0, 1) within some 1/n: no share is further off
        assert np.mean((d >= low) & (d <= high)) == pytest.approx(share, abs=5e-5)
    assert np.mean(d**2) == pytest.approx(sizes.mean_square, rel=1e-4)


def test_any_few_ids_in_turn_have_the_mean_mass():
    # as an inlet inserts them: thirty in turn are within 4 % of the mean mass; chance would give 4 % rms
    squares = UNIFORM.diameters(IDS) ** 2
    means = np.convolve(squares, np.full(30, 1 / 30), "valid")
    assert np.abs(means / UNIFORM.mean_square - 1).max() < 0.04


@pytest.mark.parametrize("sizes", [UNIFORM, TWO, THREE], ids=["uniform", "two", "three"])
def test_one_id_at_a_time_is_the_same(sizes):
    assert [float(sizes.diameters(i)) for i in range(1, 200)] == sizes.diameters(np.arange(1, 200)).tolist()
    assert sizes.diameters(np.empty((0,), int)).shape == (0,)


def test_quantiles_are_the_published_function():
    u = Sizes((1.0,), (0.0,), (1.0,), seed=3)
    expected = [((i + 0.7548776662466927 * 3) * 0.6180339887498949) % 1.0 for i in range(1, 50)]
    assert u.quantiles(np.arange(1, 50)) == pytest.approx(expected, abs=1e-14)
    assert u.diameters(np.arange(1, 50)) == pytest.approx(expected, abs=1e-14)


def test_another_seed_gives_other_diameters():
    d = [Sizes((1.0,), (0.16,), (0.24,), seed).diameters(IDS[:100]) for seed in (1, 2, 3)]
    assert min(np.abs(a - b).min() for a, b in ((d[0], d[1]), (d[0], d[2]), (d[1], d[2]))) > 1e-4


@given(shares=st.lists(st.floats(0.01, 1.0), min_size=1, max_size=10), seed=st.integers(1, 2_000_000_000))
def test_pieces_cover_all_quantiles(shares, seed):
    total = sum(shares)
    n = len(shares)
    sizes = Sizes(tuple(s / total for s in shares), tuple(range(1, n + 1)), tuple(range(2, n + 2)), seed)
    pieces = sizes.pieces
    assert pieces[0, 0] == 0.0 and pieces[-1, 1] == 1.0
    assert (pieces[1:, 0] == pieces[:-1, 1]).all()
    u, d = sizes.quantiles(IDS[:1000]), sizes.diameters(IDS[:1000])
    assert (0 <= u).all() and (u < 1).all()
    for begin, end, low, slope in pieces:
        mine = (u >= begin) & (u < end)
        assert d[mine] == pytest.approx(low + slope * (u[mine] - begin), rel=1e-14)


def test_a_scene_knows_its_sizes_and_takes_the_step_of_the_smallest():
    nothing = np.zeros((3, 2))
    equal, graded = (handmade_scene(nothing, nothing, sizes=sizes) for sizes in (None, UNIFORM))
    ids = np.arange(1, 4)
    assert equal.diameters(ids).tolist() == [0.2, 0.2, 0.2]
    assert (equal.smallest, equal.largest, equal.mean_mass) == (0.2, 0.2, equal.mass)
    assert graded.diameters(ids).tolist() == UNIFORM.diameters(ids).tolist()
    assert (graded.smallest, graded.largest) == (0.16, 0.24)
    assert graded.masses(graded.diameters(ids)) == pytest.approx(1000 * UNIFORM.diameters(ids) ** 2, rel=1e-15)
    assert graded.mean_mass == pytest.approx(1000 * UNIFORM.mean_square, rel=1e-15)
    assert graded.time_step == pytest.approx(0.8 * equal.time_step, rel=1e-14)  # proportional to sqrt(m)
    assert graded.mass == equal.mass == pytest.approx(40, rel=1e-15)
