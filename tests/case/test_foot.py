# SPDX-License-Identifier: GPL-2.0-or-later
"""Design numbers of ``check`` say where they hold: at the inlet, and at the foot of a bed that falls."""

from math import radians, tan

import pytest

import lammps_jump as lj
from lammps_jump.physics import jump

STEPS = {
    "name": "steps", "discs": {"diameter": 0.15}, "contact": {"restitution": 0.2, "impact_speed": 12},
    "walls": [{"name": "steps", "kind": "line", "points": [[-1, 5], [1, 5], [1, 2.5], [3, 2.5], [3, 0], [31, 0]]}],
    "inflow": {"kind": "rows", "x": 0, "y": 5, "depth": 0.8, "mean_speed": 6.25, "profile": "uniform"},
    "outflow": [{"x_beyond": 30}, {"y_below": -1.5}],
    "run": {"duration": 1},
}  # fmt: skip


def test_the_fast_stream_has_the_energy_that_was_asked_for():
    for discharge, energy in ((5.0, 7.79), (1.0, 2.0), (10.0, 4.0)):
        y = jump.fast_depth(discharge, energy)
        assert jump.specific_energy(y, discharge / y) == pytest.approx(energy, rel=1e-9)
        assert jump.froude(discharge / y, y) > 1
    critical = jump.critical_depth(5.0)
    assert jump.fast_depth(5.0, 1.5 * critical * (1 + 1e-9)) == pytest.approx(critical, rel=1e-3)
    assert jump.fast_depth(5.0, 1.4 * critical) != jump.fast_depth(5.0, 1.4 * critical), "no stream has less"
    assert jump.fast_depth(5.0, -1.0) != jump.fast_depth(5.0, -1.0)


def test_the_stream_at_the_foot_has_the_fall_of_the_bed():
    found = lj.load_case(STEPS).check()
    numbers, text = found.numbers, str(found)
    assert numbers["foot_x"] == pytest.approx(3, abs=0.02) and numbers["foot_fall"] == pytest.approx(5)
    assert numbers["foot_length"] == pytest.approx(27, abs=0.05)
    energy = 0.8 + 6.25**2 / (2 * 9.81) + 5
    assert numbers["foot_depth"] + numbers["foot_speed"] ** 2 / (2 * 9.81) == pytest.approx(energy, rel=1e-9)
    y2 = jump.sequent_depth(numbers["foot_speed"], numbers["foot_depth"])
    assert numbers["foot_belanger_y2"] == pytest.approx(y2) and numbers["froude"] == pytest.approx(2.231, abs=1e-3)
    for label in ("Froude number Fr1, at the inlet", "Froude number at the foot", "sill that holds the jump, E2"):
        assert label in text
    assert "\n  sequent depth y2 (Bélanger, 4.26), at the foot " in text


def test_a_level_bed_has_no_foot():
    level = STEPS | {"walls": [{"name": "bed", "kind": "line", "points": [[-1, 5], [31, 5]]}]}
    found = lj.load_case(level).check()
    assert not [key for key in found.numbers if key.startswith("foot")]
    assert "\n  Froude number Fr1  " in str(found) and "at the inlet" not in str(found)


def chute(angle, **changes):
    """A bed that falls by 5 m at an angle, degrees, from x = 1 m, and 27 m of level bed behind it."""
    foot = 1 + 5 / tan(radians(angle))
    bed = {"name": "bed", "kind": "line", "points": [[-1, 5], [1, 5], [foot, 0], [foot + 28, 0]]}
    return foot, STEPS | {"walls": [bed], "outflow": [{"x_beyond": foot + 27}, {"y_below": -1.5}]} | changes


@pytest.mark.parametrize("angle", [10, 38, 60])
def test_a_chute_is_not_level(angle):
    """Points of the bed stand millimetres apart: what counts is its slope."""
    foot, case = chute(angle)
    numbers = lj.load_case(case).check().numbers
    assert numbers["foot_x"] == pytest.approx(foot, abs=0.03) and numbers["foot_fall"] == pytest.approx(5, abs=1e-3)
    assert numbers["foot_length"] == pytest.approx(27, abs=0.05)


def test_a_chute_to_the_end_has_no_foot():
    bed = {"name": "bed", "kind": "line", "points": [[-1, 5], [31, -20]]}
    found = lj.load_case(STEPS | {"walls": [bed], "inflow": STEPS["inflow"] | {"y": 5}}).check()
    assert "foot_x" not in found.numbers


def test_doubts_on_sill_and_room_are_of_the_stream_at_the_foot():
    """At the foot a jump needs 5 y1 + 3.5 y2 = 13.5 m and a sill of 1.2 m; at the inlet 11.7 m and 0.7 m."""
    foot, case = chute(38, analysis={"jump": True})

    def said(sill_at, height):
        sill = {"name": "sill", "kind": "block", "x": [foot + sill_at, foot + sill_at + 0.5], "y": [-1, height]}
        return " ".join(lj.load_case(case | {"walls": [*case["walls"], sill]}).scene().warnings)

    numbers = lj.load_case(case).check().numbers
    room = 5 * numbers["foot_depth"] + 3.5 * numbers["foot_belanger_y2"]
    low = 0.55 * numbers["foot_sill"]
    assert "m long from the foot of the bed, x = 7.41 m, to the sill" in said(0.98 * room, 1.2 * low)
    assert "m long" not in said(1.02 * room, 1.2 * low) and "run over" not in said(1.02 * room, 1.2 * low)
    assert 0.55 * numbers["sill"] < 0.95 * low and "run over the sill" in said(1.02 * room, 0.95 * low)
    filled = {"initial": [{"kind": "column", "x": [foot + 5, foot + 26], "y": [0, 2], "hydrostatic": False}]}
    case |= filled  # the jump is there at once: what was measured in a dry channel says nothing
    assert "run over the sill" not in said(26.3, 0.5 * low)
    slow = lj.load_case(case | {"inflow": STEPS["inflow"] | {"mean_speed": 2.5}})
    assert slow.check().numbers["froude"] < 1 and "subcritical" not in " ".join(slow.scene().warnings)
