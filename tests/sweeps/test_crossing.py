# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a number that scatters comes to a value: exact functions, scatter, ranges that hold nothing."""

import numpy as np
import pytest

from lammps_jump.sweeps.crossing import CrossingSearch, all_on_one_side

ROOM = (0.2, 1.4)


def search(function, scatter, seed, *, number=1.2, members=4, budget=40, room=ROOM):
    """Rounds as `find` makes them; the answer, and the places tried."""
    rng = np.random.default_rng(seed)
    looked, tried = CrossingSearch(number, room, budget // members), {}
    while (place := looked.next_place(tried)) is not None:
        assert place not in tried and room[0] <= place <= room[1]
        tried[place] = function(place) + scatter * rng.standard_normal(members)
    return looked.answer(tried), tried


FUNCTIONS = {
    "line": (lambda x: 0.3 + x, 0.9),
    "falls": (lambda x: 2.0 - x, 0.8),
    "parabola": (lambda x: 0.9 + 0.3 * x**2, 1.0),
    "root": (lambda x: 1.2 * np.sqrt(x / 0.6), 0.6),
    "steep": (lambda x: 1.2 + np.tanh(6.0 * (x - 1.1)), 1.1),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("scatter", [0.02, 0.1, 0.3])
def test_the_range_holds_the_known_answer_in_nine_of_ten_seeds(name, scatter):
    """Of 40 seeds; 95 % of ranges should, and at least 90 % must. Of 40 with 95 % each, fewer than 35 is 1 in 1000."""
    function, known = FUNCTIONS[name]
    found = [search(function, scatter, seed)[0] for seed in range(40)]
    held = [one.low <= known <= one.high for one in found]
    assert sum(held) >= 35, f"{sum(held)} of 40"
    widths = np.array([one.high - one.low for one in found])
    assert np.nanmedian(widths) < 1.2 and (scatter > 0.1 or all(one.rises != (name == "falls") for one in found))


def test_more_runs_make_the_range_narrower():
    function, _ = FUNCTIONS["line"]
    few, many = (
        np.median([np.subtract(*search(function, 0.1, seed, budget=budget)[0][2:0:-1]) for seed in range(12)])
        for budget in (40, 160)
    )
    assert 0 < many < 0.7 * few


@pytest.mark.parametrize("name", FUNCTIONS)
def test_without_scatter_the_answer_is_exact(name):
    function, known = FUNCTIONS[name]
    found, places = search(function, 0.0, 1, members=2, budget=28)
    assert found.value == pytest.approx(known, abs=5e-4)
    assert found.low <= known + 1e-9 and found.high >= known - 1e-9 and len(places) == 14


def test_a_range_that_holds_nothing_has_no_answer():
    x = (0.2, 0.8, 1.4)
    tried = {place: place + np.array([0.0, 0.01, -0.01]) for place in x}
    assert np.isnan(CrossingSearch(2.0, ROOM, 3).answer(tried).value)
    assert all_on_one_side(tried, 2.0) and all_on_one_side(tried, 0.1)
    assert not all_on_one_side(tried, 1.0)  # they cross
    assert not all_on_one_side(tried, 1.401)  # the last is not sure
    assert all_on_one_side({0.2: np.array([1.0]), 1.4: np.array([1.1])}, 2.0)


def test_values_that_are_absent_are_left_out():
    tried = {0.2: np.array([0.5, np.nan]), 1.4: np.array([1.7, 1.7]), 0.8: np.array([np.nan, np.nan])}
    looked = CrossingSearch(1.2, ROOM, 10)
    assert looked.answer(tried).value == pytest.approx(0.2 + 1.2 * 0.7 / 1.2)
    assert looked.next_place(tried) not in tried
