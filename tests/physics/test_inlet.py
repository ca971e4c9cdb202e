# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of an inflow: the discharge asked for, in whole steps."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.physics.contact import critical_time_step, disc_mass, stiffness
from lammps_jump.physics.inlet import (
    COARSEST_RASTER,
    LEAST_GAP,
    plan_rows,
    row_count,
    row_speeds,
    thesis_rows,
    whole_intervals,
)

THESIS = {"depth": 1.0, "mean_speed": 16.0, "time_step": 8.8388e-5}


def graded(diameter: float, spread: float) -> dict[str, float]:
    """Mean square and largest diameter of discs of d(1 - s) to d(1 + s)."""
    return {"mean_square": diameter**2 * (1 + spread**2 / 3), "largest": diameter * (1 + spread)}


def time_step(fraction: float, diameter: float, speed: float) -> float:
    """Step of discs that the inflow's own speed presses d/10 into each other."""
    return fraction * critical_time_step(stiffness(1000, 0.1, speed), disc_mass(1000, diameter))


def test_six_rows_of_the_thesis_jump():
    plan = plan_rows(**THESIS, mean_square=0.04, largest=0.2)
    assert plan.steps == (213, 182, 169, 161, 156, 151)
    assert plan.speeds == pytest.approx((12.755, 14.923, 16.053, 16.843, 17.459, 17.967), abs=0.51e-3)
    assert plan.heights == pytest.approx((0.1, 0.3, 0.5, 0.7, 0.9, 1.1), rel=1e-14)
    assert plan.raster == 1
    assert plan.discharge == pytest.approx(16, rel=2e-4)
    assert plan.discharge == pytest.approx(sum(0.04 / (n * THESIS["time_step"]) for n in plan.steps), rel=1e-14)


def test_seven_rows_of_discs_of_several_sizes():
    step = {**THESIS, "time_step": time_step(0.1, 0.16, 16)}
    plan = plan_rows(**step, **graded(0.2, 0.2), coarsest=COARSEST_RASTER)
    assert len(plan.steps) == 7
    assert plan.heights == pytest.approx(tuple(0.24 * (i + 0.5) for i in range(7)), rel=1e-14)
    assert plan.raster in (1, 2, 4, 8) and all(n % plan.raster == 0 for n in plan.steps)
    assert plan.discharge == pytest.approx(16, rel=2e-3)


PLANS = {
    "diameter": st.floats(0.01, 1.0),
    "discs_deep": st.floats(3.0, 12.0),
    "speed": st.floats(1.0, 30.0),
    "spread": st.sampled_from((0.0, 0.1, 0.2, 0.5)),
    "fraction": st.floats(0.01, 0.1),
    "profile": st.sampled_from(("power_law", "uniform")),
    "coarsest": st.sampled_from((1, COARSEST_RASTER)),
}


@given(**PLANS)
def test_any_plan_carries_its_discharge(diameter, discs_deep, speed, spread, fraction, profile, coarsest):
    depth, sizes = discs_deep * diameter, graded(diameter, spread)
    dt = time_step(fraction, diameter * (1 - spread), speed)
    plan = plan_rows(depth, speed, dt, **sizes, profile=profile, coarsest=coarsest)
    rows = len(plan.steps)
    assert rows == row_count(depth, **sizes) == len(plan.speeds) == len(plan.heights)
    # fewer rows would be closer than the least gap
    gap = rows * sizes["mean_square"] / depth
    assert gap >= LEAST_GAP * sizes["largest"] * (1 - 1e-8)
    assert (rows - 1) * sizes["mean_square"] / depth < LEAST_GAP * sizes["largest"]
    assert plan.discharge == pytest.approx(speed * depth, rel=2e-3)
    assert sum(plan.speeds) / rows == pytest.approx(speed, rel=1e-13)
    assert all(b >= a for a, b in pairwise(plan.speeds))
    # each interval within a tick of the ideal one, and no two discs of a row closer than 1.05 largest diameters
    ticks = np.array(plan.steps) / plan.raster
    assert (np.abs(ticks - gap / (np.array(plan.speeds) * plan.raster * dt)) <= 1).all()
    if plan.raster > 1:
        assert (np.array(plan.steps) * dt * plan.speeds > 1.05 * sizes["largest"]).all()


def test_row_speeds_follow_the_profile():
    speeds = row_speeds(5, 16.0)
    assert sum(speeds) / 5 == pytest.approx(16, rel=1e-14)
    assert speeds[4] / speeds[0] == pytest.approx(9 ** (1 / 7), rel=1e-14)
    assert row_speeds(3, 16.0, "uniform") == (16.0, 16.0, 16.0)


def test_rows_of_touching_discs_fill_the_depth():
    assert row_count(0.6, 0.04, 0.2, 1.0) == 3  # 0.6 / 0.2 rounds below 3
    assert row_count(0.61, 0.04, 0.2, 1.0) == 4
    assert row_count(0.1, 0.04, 0.2, 1.0) == 1


def test_unknown_profile_is_refused():
    with pytest.raises(ValueError, match="parabola"):
        row_speeds(5, 16.0, profile="parabola")


@given(ideal=st.lists(st.floats(0.6, 300.0), min_size=1, max_size=12), share=st.floats(0.98, 1.02))
def test_whole_intervals_are_near_and_better_than_rounding(ideal, share):
    ideal = np.array(ideal)
    wanted = share * float(np.sum(1 / ideal))
    found, rounded = whole_intervals(ideal, wanted), np.maximum(1, np.rint(ideal))
    assert (np.abs(found - ideal) <= 1).all() and (found >= 1).all()
    assert abs(np.sum(1 / found) - wanted) <= abs(np.sum(1 / rounded) - wanted) + 1e-12


def test_rows_of_the_thesis():
    plan = thesis_rows(1.0, 0.2, 16.0, 1e-4)
    assert plan.speeds == pytest.approx((13.160, 15.396, 16.562, 17.377, 18.013), abs=0.51e-3)
    assert plan.heights == pytest.approx((0.1, 0.3, 0.5, 0.7, 0.9), rel=1e-14)
    mean = sum(plan.speeds) / 5
    assert sum(u**2 for u in plan.speeds) / 5 / mean**2 == pytest.approx(1.01129, abs=0.51e-5)
    # touching discs would carry 402.5 discs a second; the gap takes 2 %, whole steps some more
    assert 0.97 * 402.54 / 1.02 < plan.discharge / 0.04 <= 402.54 / 1.02
    assert len(thesis_rows(0.6, 0.2, 1.0, 1e-4).steps) == 3  # 0.6 / 0.2 rounds below 3
    assert set(thesis_rows(1.0, 0.2, 16.0, 1e-4, profile="uniform").speeds) == {16.0}
