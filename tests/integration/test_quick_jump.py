# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene for a first look: a jump with level tail water, in few steps and few discs."""

from pathlib import Path

import pytest

import lammps_jump as lj

INPUTS = Path(__file__).parents[2] / "inputs"


pytestmark = pytest.mark.long  # the golden page of this scene and the budget of a jump see its kinds of fault


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    changes = {"engine.name": "native", "analysis.figures": "none"}
    return lj.load_case(INPUTS / "quick_jump.yaml", changes).run(tmp_path_factory.mktemp("quick") / "run")


def test_every_frame_of_the_window_has_a_jump_with_level_tail_water(run):
    """Over 96 starts: slope 0.0056 +- 0.0064, -2.0 +- 0.6 % from Bélanger (mean and deviation)."""
    jump, inflow = run.jump, run.summary["inflow"]
    assert jump.verdict == "jump" and jump.frames_found == jump.frames_in_window == 41
    assert abs(jump.tail.slope) < 0.03 and jump.tail.length > 5.0
    assert abs(jump.belanger_deviation) < 0.05
    assert -0.75 < jump.speed < -0.45
    assert inflow["refused"] == 0 and inflow["delivered"] == pytest.approx(6.0, rel=2e-3)


def test_it_is_quick(run):
    """The engine's time goes with the disc-steps, the page with discs times frames."""
    assert run.summary["disc_steps"] < 80e6
    assert sum(frame.n for frame in run.frames()) < 150_000


def test_it_starts_full_without_a_crystal(run):
    """The front is there at once and moves as it does later; discs in the tail water have no lattice's packing."""
    track = run.jump.track
    assert track.found.all()
    assert 0.80 < run.jump.local.packing_2 < 0.86  # hexagonal 0.907
