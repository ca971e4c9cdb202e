# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts of a study that reads their runs itself: each run once, in a folder under its key."""

import pytest
from made_up import BOX

import lammps_jump as lj
from lammps_jump.sweeps import Pool, Start, members, run_starts


@pytest.fixture(scope="module")
def pool():
    with Pool(2) as pool:
        yield pool


def test_equal_starts_of_two_points_are_one_run(tmp_path, pool):
    said, starts = [], [Start(0, {}, 1), Start(1, {}, 1), Start(2, {}, 2)]
    found = run_starts(lj.load_case(BOX), starts, tmp_path, pool, said=said.append)
    assert [one.start for one in found] == starts and all(one.summary for one in found)
    assert found[0].folder == found[1].folder != found[2].folder and len(said) == 2


def test_what_is_there_is_run_again_only_where_that_is_asked_for(tmp_path, pool):
    case, said = lj.load_case(BOX), []
    # the fast disc leaves the domain through a box that is wider
    starts = [
        Start(0, {}, 1),
        Start(1, {"walls.box.x": [0, 20], "run.duration": 1}, 1),
        Start(2, {"run.duration": -1}, 1),
    ]
    first = run_starts(case, starts, tmp_path, pool, said=said.append)
    assert [bool(one.summary) for one in first] == [True, False, False]
    assert "domain" in first[1].message and "run.duration" in first[2].message and len(said) == 2
    assert run_starts(case, starts, tmp_path, pool, said=said.append) == first and len(said) == 2
    again = run_starts(case, starts, tmp_path, pool, fresh=True, said=said.append)
    assert len(said) == 4 and [one.message for one in again] == [one.message for one in first]


def test_the_setting_of_a_point_is_chosen_once(monkeypatch):
    chosen = []
    real = members.choose_setting
    monkeypatch.setattr(members, "choose_setting", lambda case: chosen.append(case.fields.run.seed) or real(case))
    starts = [Start(point, {"contact.friction": 0.1 * point}, seed) for point in range(2) for seed in (3, 4, 5)]
    found = members.plan(lj.load_case(BOX), starts, {})
    assert chosen == [3, 3] and len({member.key for member in found}) == len(starts)
    alone = [members.plan(lj.load_case(BOX), [start], {})[0].key for start in starts]
    assert [member.key for member in found] == alone
