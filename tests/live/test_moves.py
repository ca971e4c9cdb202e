# SPDX-License-Identifier: GPL-2.0-or-later
"""What sliders of a live page do is a case whose native run has the bits of the page: in node."""

from __future__ import annotations

import numpy as np
import pytest
from live_flows import lacking, native, stepped
from made_up import INPUTS

from lammps_jump.case import ReadCase, load_case

pytestmark = [
    pytest.mark.usefixtures("compiled_core"),
    pytest.mark.skipif(bool(lacking()), reason=lacking() or "all is there"),
]
SILL = {"path": "walls.sill", "move": "y", "range": [-0.5, 2]}
COARSE = {"quick_jump": 0.3, "stable_jump": 0.5, "tailgate": 0.5, "dam_break": 0.5, "wave_paddle": 0.25, "caisson": 0.5}
"""Diameters with which a scene takes a moment, m."""
TURNED = {"path": "walls.sill", "move": "turn", "range": [-20, 20]}
RATE = {"path": "inflow", "range": [4, 8]}
GATE = {"name": "gate", "kind": "block", "x": [6, 6.3], "y": [0, 6]}
MOVED = {
    "sill": ("quick_jump", {"s": SILL}, [(300, "s", 1.3), (1200, "s", -0.4), (1210, "s", 0.2)]),
    "discharge": ("quick_jump", {"q": RATE}, [(300, "q", 7.5), (900, "q", 4.5), (2000, "q", 6.0)]),
    "both, and a turn": (
        "quick_jump",
        {"s": SILL, "t": TURNED, "q": RATE},
        [(100, "q", 8), (150, "t", 15), (155, "s", 2), (500, "t", -10), (550, "q", 4), (700, "s", -0.5)],
    ),
    "paddle": (
        "wave_paddle",
        {"p": {"path": "walls.paddle", "move": "x", "range": [-1, 1]}},
        [(100, "p", 0.7), (900, "p", -0.6)],
    ),
    "gate": (
        "dam_break",
        {"g": {"path": "walls.gate", "move": "y", "range": [0, 5], "speed": 4}},
        [(200, "g", 2.5), (1500, "g", 0.5)],
    ),
}


SHORT = "both, and a turn"


def case_of(name: str, sliders: dict, **more: object) -> ReadCase:
    changes = {"discs.diameter": COARSE[name]} if name in COARSE else {}
    if any(one["path"] == "walls.gate" for one in sliders.values()):
        walls = load_case(INPUTS / f"{name}.yaml").fields.model_dump(mode="json", exclude_none=True)["walls"]
        column = {"kind": "column", "x": [0, 6], "y": [0, 5], "gate": False}
        changes |= {"walls": [*walls, GATE], "initial": [column]}
    return load_case(INPUTS / f"{name}.yaml", {**changes, **more, "live": sliders})


def differing(one: bytes, two: bytes) -> int:
    """Bytes that differ; all of them where the lengths do."""
    if len(one) != len(two):
        return max(len(one), len(two))
    return int((np.frombuffer(one, "u1") != np.frombuffer(two, "u1")).sum())


@pytest.mark.parametrize("what", [SHORT, *(pytest.param(one, marks=pytest.mark.long) for one in MOVED if one != SHORT)])
def test_the_case_of_what_sliders_did_has_the_bits_of_the_page(tmp_path, what):
    name, sliders, moves = MOVED[what]
    steps = 1000 if what == SHORT else 3000
    state, text, told = stepped(case_of(name, sliders), tmp_path, steps, moves)
    assert not told["wrong"]
    assert f"# A flow of a live page up to step {steps}" in text
    assert differing(state, native(text, steps)) == 0
    still, _, _ = stepped(case_of(name, sliders), tmp_path, steps, [])
    assert differing(state, still) > 1000  # they did something


@pytest.mark.long
@pytest.mark.parametrize("name", ["quick_jump", "dam_break", "drum", "caisson", "tailgate"])
def test_without_moves_a_page_has_the_bits_of_its_case(tmp_path, name):
    """1,000 steps: jets, a gate, a turning drum, a body, a tailgate."""
    state, text, _ = stepped(case_of(name, {}), tmp_path, 1000, [])
    assert differing(state, native(text, 1000)) == 0


@pytest.mark.long
def test_numbers_that_a_flow_begins_with_are_in_its_case_and_later_changes_are_not(tmp_path):
    friction = {"path": "contact.friction", "range": [0.1, 0.9]}
    asked = {"f": friction, "e": {"path": "contact.restitution", "range": [0.1, 0.9]}}
    case = case_of("drum", asked, **{"discs.diameter": 0.2})
    begun, text, told = stepped(case, tmp_path, 800, [], {"f": 0.9, "e": 0.5})
    assert ReadCase.parse(text).fields.contact.friction == 0.9 and told["tables"]["changed"] == []
    assert differing(begun, native(text, 800)) == 0
    changed, text, told = stepped(case, tmp_path, 800, [(200, "f", 0.9)])
    assert ReadCase.parse(text).fields.contact.friction == 0.5
    assert told["tables"]["changed"] == ["f"] and "# Not in it: f, changed while the flow ran." in text
    assert differing(changed, native(text, 800)) > 1000 and differing(changed, begun) > 1000
