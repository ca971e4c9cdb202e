# SPDX-License-Identifier: GPL-2.0-or-later
"""The first scene: a jump that stands, with a level tail of Bélanger's depth."""

from pathlib import Path

import pytest

import lammps_jump as lj

INPUTS = Path(__file__).parents[2] / "inputs"
STARTS = 2
MOST_DISC_STEPS = 6.4e8


@pytest.mark.long
def test_the_jump_stands(tmp_path):
    """Over eight starts: front 0.009 +- 0.025 m/s, -0.37 +- 0.33 % from Bélanger (mean and deviation)."""
    changes = {"engine.name": "native", "analysis.figures": "none"}
    case = lj.load_case(INPUTS / "stable_jump.yaml", changes)
    runs = [case.replace({"run.seed": seed}).run(tmp_path / str(seed)) for seed in range(1, STARTS + 1)]
    for run in runs:
        assert run.jump.verdict == "jump" and run.jump.frames_found == run.jump.frames_in_window == 121
        assert run.summary["inflow"]["refused"] == 0
        assert run.summary["disc_steps"] < MOST_DISC_STEPS
    assert abs(sum(run.jump.speed for run in runs) / STARTS) < 0.08  # four deviations of the mean
    assert abs(sum(run.jump.belanger_deviation for run in runs) / STARTS) < 0.013  # the same
