# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers in words: rounded to their error, one or several runs, units with their powers."""

# ruff: noqa: RUF001  (quotation marks are meant for readers)

import io
import re

import pytest

from lammps_jump.analysis.jump.found import Members, starts_needed
from lammps_jump.analysis.tables import with_error
from lammps_jump.analysis.verdicts import verdict
from lammps_jump.cli.progress import StudyLine
from lammps_jump.sweeps.sweep import SweepProgress
from lammps_jump.units import shown


@pytest.mark.parametrize(
    ("off", "error", "said"),
    [
        (0.000074, 0.018, "Its sequent depth equals Bélanger’s within 2 %"),
        (-0.034, 0.018, "Its sequent depth is 3 % below Bélanger’s"),
        (-0.0104, 0.0021, "Its sequent depth is 1.0 % below Bélanger’s"),
        (0.123, None, "Its sequent depth is 12 % above Bélanger’s"),
    ],
)
def test_a_difference_is_rounded_to_its_error(off, error, said):
    jump = {"verdict": "jump", "at": "tail water", "belanger_deviation": off, "belanger_deviation_error": error}
    assert said in verdict({"jump": jump})


def test_two_digits_end_without_a_point():
    front = {"position": 12.0, "speed": 12.04, "ritter": {"front_speed": 9.0, "valid_until": 2.0}}
    front |= {"time": 1.0, "column_base": 1.0}
    front["martin_moyce"] = {"aspect": 2.0}
    assert "runs at 12 m/s; Ritter’s would run at 9.0 m/s" in verdict({"front": front})


def test_runs_are_counted_in_words():
    assert starts_needed(Members(1, 2, None)) == "1 run for y2 and 2 runs for the velocity of the front"
    three = starts_needed(Members(3, 12, 1))
    assert re.fullmatch(r"3 runs for y2, 12 runs for .* and 1 run for the Froude number", three)
    assert starts_needed(Members()) == starts_needed(None) == ""


def test_units_have_their_powers_and_errors_are_not_zero():
    assert shown(16.0, "m^2/s") == "16 m²/s" and shown(1.0, "kg/m^3") == "1 kg/m³" and shown(1.0, "1/s") == "1 1/s"
    assert with_error("y2")({"y2": 1.0, "y2_error": 0.0012}) == "1.00 ± 0.001"
    assert with_error("y2")({"y2": 1.0, "y2_error": 0.012}) == "1.00 ± 0.01"


def test_the_speed_of_a_study_that_grows_is_not_negative():
    lines, clock = io.StringIO(), iter([0.0, 20.0, 40.0])
    line = StudyLine(stream=lines, clock=lambda: next(clock))
    for done, total, steps in ((3, 4, 4e8), (4, 8, 1e8)):
        line(SweepProgress(done=done, total=total, failed=0, share=0.5, disc_steps=steps))
    assert [text.split("done")[1].split(" M ")[0].strip() for text in lines.getvalue().splitlines()] == ["20.0", "5.0"]
