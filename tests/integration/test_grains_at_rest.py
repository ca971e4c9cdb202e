# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains at rest and in steady flow: what springs with memory are for."""

from __future__ import annotations

import json
from math import radians, tan

import numpy as np
import pytest
from made_up import INPUTS, run_case

from lammps_jump.dump import read_dump

pytestmark = [pytest.mark.lammps, pytest.mark.long]


def test_a_heap_at_rest_stays_where_it_is(tmp_path):
    """No disc moves by 1e-6 d in 5 s: 2e-7 d in 25 s measured, in the first three of them."""
    changes = ["run.stop_when_steady=false", "run.duration=8", "run.output_interval=1", "initial.0.y=[0.75, 0.9]",
               "analysis.figures=none"]  # fmt: skip
    found = run_case(INPUTS / "heap.yaml", tmp_path, changes)
    assert found["discs"]["lost"] == 0 and found["heap"]["height"] > 5 * 0.02
    frames = {round(frame.time): frame for frame in read_dump(tmp_path)}
    way = np.hypot(frames[8].x - frames[3].x, frames[8].y - frames[3].y)
    assert way.max() < 1e-6 * 0.02


def test_the_slope_is_the_ratio_of_the_stresses(tmp_path):
    """Shear over normal stress is tan(slope) in every layer of a steady flow; contacts of the compiled kernel."""
    run_case(INPUTS / "inclined_flow.yaml", tmp_path, ["analysis.figures=none"])
    found = json.loads((tmp_path / "summary.json").read_text())["layers"]
    assert found["friction"] == pytest.approx(tan(radians(20)), rel=0.03)  # 600 frames know it within 1 %
