# SPDX-License-Identifier: GPL-2.0-or-later
"""What `check` says first: this case is fine, or what is doubtful in it."""

import json

import pytest
from made_up import INPUTS

from lammps_jump.case import load_case

QUICK = INPUTS / "quick_jump.yaml"


def first_lines(*changes):
    return str(load_case(QUICK, changes).check()).splitlines()


@pytest.mark.parametrize("name", ["quick_jump", "hydraulic_jump_graded", "stable_jump", "dam_break", "energy_box_7"])
def test_these_scenes_are_fine(name):
    found = load_case(INPUTS / f"{name}.yaml").check()
    assert str(found).startswith("this case is fine\n")
    assert json.loads(json.dumps(found.as_data()))["verdict"] == "fine"


@pytest.mark.parametrize(
    ("changes", "doubt"),
    [
        (["run.duration=30", "analysis.window=[6, 9]"], "misses the last half of the 30 s"),
        (["run.duration=5"], "s, the run at 5 s; take a window within the run"),
        (["contact.impact_speed=6"], "the fastest row has 11.2 m/s, contact.impact_speed is 6 m/s"),
        (["initial=[]", "walls.sill.x=[10, 11]"], "the channel is 10 m long"),
        (["walls.sill.y=[-5, 0.5]"], "run over the sill of 0.5 m without a jump"),
        (["inflow.mean_speed=2"], "subcritical (Fr = 0.824)"),
        (["contact.friction=0.2"], "makes a heap"),
    ],
)
def test_a_doubt_stands_first(changes, doubt):
    case = load_case(QUICK, changes).check()
    lines = str(case).splitlines()
    assert lines[0] == "doubtful in this case:"
    assert [line for line in lines if doubt in line] == [f"  - {text}" for text in case.warnings if doubt in text] != []
    assert case.as_data()["verdict"] == "doubtful"


def test_the_sill_that_energy_asks_for_is_printed():
    stable = load_case(INPUTS / "stable_jump.yaml")
    assert stable.check().numbers["sill"] == pytest.approx(2.58, abs=0.005)
    assert "sill that holds the jump, E2 - 1.5 yc" in str(stable.check())
    assert "sill" not in stable.replace({"inflow.mean_speed": 3}).check().numbers  # subcritical


def test_a_case_without_a_jump_asked_for_is_not_judged_as_one():
    assert first_lines("analysis.jump=false", "walls.sill.y=[-5, 0.5]")[0] == "this case is fine"


def test_a_column_at_the_inlet_that_contradicts_the_inflow_is_named():
    case = load_case(QUICK)
    assert not any("column at the inlet" in note for note in case.scene().warnings)
    for change, said in (
        ({"initial.0.velocity": [4, 0]}, "0.6 m deep at 4 m/s, the inflow 0.6 m at 10 m/s"),
        ({"inflow.depth": 0.9}, "0.6 m deep at 10 m/s, the inflow 0.9 m at 10 m/s"),
    ):
        (note,) = (note for note in case.replace(change).scene().warnings if "column at the inlet" in note)
        assert note.startswith("initial.0: ") and said in note
