# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole steps of a run: the duration is the user's, windows and frames adapt, and what has changed is told."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import INPUTS, SCENES

from lammps_jump.case import load_case
from lammps_jump.scene.schedule import MOST_FINER, TOLD, fitted_step, plan_steps, rounding_notes, told_of_window


@given(
    duration=st.floats(0.5, 100),
    frames=st.integers(1, 500),
    probe=st.floats(1e-6, 10),
    step=st.floats(1e-5, 2e-4),
)
def test_windows_of_the_probes_leave_the_duration_alone(duration, frames, probe, step):
    interval = duration / frames
    plan, plain = plan_steps(duration, interval, probe, step), plan_steps(duration, interval, None, step)
    assert plan.run % plan.output == 0 == plan.output % plan.probe
    late, before = (abs(steps.run * step / duration - 1) for steps in (plan, plain))
    assert late <= max(TOLD, before) * (1 + 1e-9)
    assert plan.output == pytest.approx(plain.output, rel=0.02, abs=1)
    assert plain.probe == plain.output


@pytest.mark.parametrize("interval", [1.35e-4, 1e-3, 0.01, 0.013, 0.5])
def test_a_dam_break_lasts_as_long_as_asked(interval):
    scene = load_case(INPUTS / "dam_break.yaml", {"probes.interval": interval}).scene()
    assert scene.time(scene.steps) == pytest.approx(5.0, rel=TOLD)
    window = scene.probe_steps * scene.time_step
    assert any("probes.interval" in text for text in scene.adapted) == (abs(window / interval - 1) > TOLD)


def test_a_window_that_is_changed_tells_why():
    assert told_of_window(0.01, 0.01, 0.01) == ()
    (longer,) = told_of_window(0.5, 0.1, 0.1)
    assert longer.startswith("probes.interval: 0.1 s in place of 0.5 s, because a window is at most the time between")
    assert "set run.output_interval to 0.5 s" in longer
    (other,) = told_of_window(0.0005, 0.00099, 0.001)
    assert "whole numbers of them make the time between frames" in other

    def adapted(interval, frames):
        changes = {"probes.interval": interval, "run.output_interval": frames}
        return [text for text in load_case(INPUTS / "dam_break.yaml", changes).scene().adapted if "probes" in text]

    assert "set run.output_interval to 0.5 s" in adapted(0.5, 0.05)[0]
    assert adapted(0.5, 0.5) == []  # the remedy helps


def test_what_whole_steps_change_is_told():
    assert rounding_notes({"a": (1.0, 1.0009), "b": (2.0, 2.1)}) == (
        "b: 2.1 s in place of 2 s, because time goes in whole steps",
    )
    case = load_case(INPUTS / "hydraulic_jump.yaml")
    assert any(text.startswith("discharge of the inflow: 15.") for text in case.scene().adapted)  # rows of the thesis
    assert "changed to whole steps" in str(case.check())
    assert not set(case.scene().adapted) & set(case.check().warnings)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_shipped_scenes_keep_the_times_that_they_ask_for(path):
    scene = load_case(path).scene()
    # the rows of the thesis carry less than its discharge; everything else is as asked
    told_of = {text.split(":")[0] for text in scene.adapted}
    other = {"hydraulic_jump": {"discharge of the inflow"}, "crown_wall": {"probes.interval", "run.output_interval"}}
    assert told_of == other.get(path.stem, set())


@given(
    duration=st.floats(0.5, 100),
    frames=st.integers(1, 500),
    windows=st.integers(1, 20),
    step=st.floats(1e-5, 1e-2),
)
def test_a_fitted_step_divides_the_times_and_is_hardly_finer(duration, frames, windows, step):
    frame = duration / frames
    fitted = fitted_step(duration, frame, frame / windows, step)
    assert (1 - MOST_FINER) * step <= fitted <= step
    whole = [abs(time / fitted - round(time / fitted)) < 1e-6 for time in (duration, frame, frame / windows)]
    assert whole[:2] == [True, True] or (frame < step / MOST_FINER and fitted == step)
    # one of fifty steps or more, at most, is added
    assert all(whole) or frame / windows < step / MOST_FINER


def test_times_that_are_no_multiples_leave_the_step():
    assert fitted_step(10.0, 0.3, None, 1e-3) == pytest.approx(10 / 33 / 304, rel=1e-12)  # whole frames all the same
    assert fitted_step(1.0, 0.5, 0.1, 0.3) == 0.3
