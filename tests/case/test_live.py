# SPDX-License-Identifier: GPL-2.0-or-later
"""Sliders of a case: what they name is there, and domain and outlets do not depend on what they did."""

from __future__ import annotations

import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.errors import CaseError

JUMP = INPUTS / "quick_jump.yaml"
SILL = {"path": "walls.sill", "move": "y", "range": [-0.5, 2]}


def scene_with(sliders, **more):
    return load_case(JUMP, {"discs.diameter": 0.3, "live": sliders, **more}).scene()


@pytest.mark.parametrize(
    ("one", "said"),
    [
        ({"path": "walls.sil", "move": "y", "range": [0, 1]}, "live.a.path: 'sil' is no wall .* did you mean 'sill'"),
        ({"path": "walls.sill", "range": [0, 1]}, "needs move"),
        ({"path": "inflow", "move": "y", "range": [4, 8]}, "needs move"),
        ({"path": "walls.sill", "move": "y", "range": [1, 2]}, "0 must be in it"),
        ({"path": "walls.sill", "move": "y", "range": [2, -1]}, "runs backwards"),
        ({"path": "inflow", "range": [0, 8]}, "allowed is above 0"),
        ({"path": "discs.diameter", "range": [0.1, 0.2]}, "'discs.diameter' is not known"),
        ({"path": "slope", "range": [0, 1], "speed": 2}, "is that of a wall"),
    ],
)
def test_a_slider_that_cannot_be_is_refused_with_its_place(one, said):
    with pytest.raises(CaseError, match=said):
        scene_with({"a": one})


def test_two_sliders_of_one_thing_are_refused():
    with pytest.raises(CaseError, match="moved by the slider 'a' already"):
        scene_with({"a": SILL, "b": SILL})


def test_a_slider_of_an_inflow_needs_one_by_rows():
    with pytest.raises(CaseError, match="no inflow by rows"):
        load_case(INPUTS / "dam_break.yaml", {"live": {"q": {"path": "inflow", "range": [1, 2]}}}).scene()


def test_a_plane_does_not_turn():
    with pytest.raises(CaseError, match="has no end"):
        sliders = {"a": {"path": "walls.floor", "move": "turn", "range": [-1, 1]}}
        load_case(INPUTS / "dam_break.yaml", {"live": sliders}).scene()


def test_domain_and_outlets_allow_for_what_sliders_may_do_and_not_for_what_they_did():
    """Without this a run of the moves would take discs out at other steps than the page, and sort others together."""
    asked = {"a": SILL, "q": {"path": "inflow", "range": [4, 12]}}
    free = {"domain": None}
    still, plain = scene_with(asked, **free), scene_with({}, **free)
    table = {"kind": "table", "points": [[0, 0, 0, 0], [1, 0, 1, 0], [1.5, 0, 0.5, 0]]}
    moved = scene_with(asked, **free, **{"walls.sill.motion": table})
    (_, (low, high)), (_, (plain_low, plain_high)) = still.domain, plain.domain
    assert moved.domain == still.domain and moved.outlets == still.outlets
    assert low < plain_low and high > plain_high
    fast = scene_with(asked)
    assert [one.every_steps for one in fast.outlets] < [one.every_steps for one in scene_with({}).outlets]
