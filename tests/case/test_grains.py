# SPDX-License-Identifier: GPL-2.0-or-later
"""What `check` says of heaps that cannot rest, and the fields of layers."""

from __future__ import annotations

import re
from math import radians, sin

import pytest
from made_up import INPUTS

from lammps_jump.case import load_case, speeds
from lammps_jump.errors import CaseError
from lammps_jump.physics.slip import FRICTION_LAWS, FrictionLaw

COLUMN = INPUTS / "column_collapse.yaml"


def told(*changes, path=COLUMN):
    """What is said of a column with viscous friction, unless another law is given."""
    case = load_case(path, ["contact.friction_law=viscous", *changes])
    return [text for text in case.scene().warnings if "tangential spring" in text]


def test_a_column_that_falls_creeps(monkeypatch):
    case = load_case(COLUMN, ["contact.friction_law=viscous"])
    (text,) = told()
    speed = 9.81 * sin(radians(20)) / case.scene().coefficients.gamma_tangential
    assert float(re.search(r"creeps at ([\d.e-]+) m/s on 20 degrees", text)[1]) == pytest.approx(speed, rel=0.05)
    laws = {"viscous": FRICTION_LAWS["viscous"], "springs": FrictionLaw(None, False, True)}
    monkeypatch.setattr(speeds, "FRICTION_LAWS", laws)
    assert told()[0].endswith("; friction_law: springs holds it")
    monkeypatch.setattr(speeds, "FRICTION_LAWS", {"viscous": laws["springs"]})
    assert not told()


def test_the_ramp_of_the_sign_law_has_no_speed():
    (text,) = told("contact.friction_law=sign")
    assert "m/s" not in text and "never rests" in text


@pytest.mark.parametrize(
    "change",
    ["contact.friction=0.01", "outflow=[{x_beyond: 15}]", "gravity=0",
     "walls.0={name: back, kind: plane, axis: x, at: 0, side: above, motion: {kind: translate, velocity: [0, 0]}}"],
)  # fmt: skip
def test_what_makes_no_heap_is_not_told(change):
    assert not told(change)


def test_a_column_between_two_walls_makes_no_heap_and_a_poured_one_does():
    bin_ = "{kind: box, name: bin, x: [0, 2], y: [0, 8]}"
    narrow = ("domain.x=[-1, 3]", "discs.sizes=null", f"walls=[{bin_}]", "probes.forces=[]")
    assert not told(*narrow)
    pour = "inflow={kind: pour, x: [0.2, 1.8], y: [5, 7.5], count: 20}"
    assert told(*narrow, pour)


def test_poured_discs_that_do_not_resist_rolling_make_a_flat_heap():
    heap = INPUTS / "heap.yaml"
    changes = [], ["contact.rolling=null"], ["contact.rolling=null", "analysis.hopper=false"]
    warnings = [load_case(heap, change).scene().warnings for change in changes]
    said = [any("contact.rolling" in text for text in one) for one in warnings]
    assert said == [False, True, False]


@pytest.mark.parametrize(("given", "kept"), [("true", True), ("false", False)])
def test_layers_as_a_word(given, kept):
    assert load_case(COLUMN, [f"analysis.layers={given}"]).fields.analysis.layers is kept


def test_layers_with_a_stretch():
    asked = load_case(COLUMN, ["analysis.layers={x: [0.5, 1.5], height: 20 cm}"]).fields.analysis.layers
    assert (asked.x, asked.height) == ((0.5, 1.5), 0.2)
    assert load_case(COLUMN, ["analysis.layers={}"]).fields.analysis.layers.x is None
    for wrong, said in (("{x: [2, 1]}", "analysis.layers.x"), ("{height: 0}", "analysis.layers.height")):
        with pytest.raises(CaseError, match=said):
            load_case(COLUMN, [f"analysis.layers={wrong}"])
