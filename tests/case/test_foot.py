# SPDX-License-Identifier: GPL-2.0-or-later
"""Design numbers of ``check`` say where they hold: at the inlet, and at the foot of a bed that falls."""

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
