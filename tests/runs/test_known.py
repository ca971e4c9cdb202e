# SPDX-License-Identifier: GPL-2.0-or-later
"""What a machine knows of runs: their speed by kind and case, the scatter of starts, and what follows before a run."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from made_up import BOX, INPUTS, call

from lammps_jump import load_case
from lammps_jump.engines import Setting
from lammps_jump.runs import known

NATIVE = Setting("native", "core")


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    monkeypatch.setattr(known, "usual_folder", lambda: tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture(scope="module")
def box():
    return load_case(BOX)


def result(seconds, disc_steps=1e9, **more):
    given = {"status": "complete", "cpu_seconds": seconds, "disc_steps": disc_steps, "resumed": ()}
    return SimpleNamespace(**given | more)


def test_time_of_a_case_is_that_of_its_runs_else_of_runs_of_its_kind(box, kept):
    assert known.time_of(box, NATIVE).seconds is None and "has taken 1 s or more" in str(known.time_of(box, NATIVE))
    for seconds in (2.0, 4.0, 3.0):
        known.remember_run(box.replace({"run.seed": int(seconds)}), NATIVE, result(seconds))
    own = known.time_of(box.replace({"run.seed": 9}), NATIVE)
    assert (own.seconds, own.low, own.high, own.runs) == (3.0, 2.0, 4.0, 3) and "of this case" in own.source
    longer = box.replace({"run.duration": 10 * box.fields.run.duration})
    like, scene = known.time_of(longer, NATIVE), longer.scene()
    assert like.seconds == pytest.approx(3e-9 * scene.steps * len(scene.positions)) and "of this kind" in like.source
    assert known.time_of(box, Setting("lammps", "stock")).seconds is None, "another engine is another kind"


@pytest.mark.parametrize(
    "bad",
    [{"status": "failed"}, {"status": "interrupted"}, {"resumed": (1.0,)}, {"disc_steps": 0.0}, {"cpu_seconds": 0.9}],
)
def test_runs_that_tell_no_speed_are_not_kept(bad, box, kept):
    known.remember_run(box, NATIVE, result(5.0, **bad) if "cpu_seconds" not in bad else result(0.9))
    assert not kept.exists()


def test_files_are_bounded_and_checked_by_meaning(box, kept):
    for number in range(known.KEPT + 4):
        known.remember_run(box, NATIVE, result(2.0 + number))
    (kind, case) = json.loads((kept / known.SPEEDS).read_text())
    stored = json.loads((kept / known.SPEEDS).read_text())
    assert len(stored[kind]) == len(stored[case]) == known.KEPT and stored[case][-1] == 2.0 + known.KEPT + 3
    for bad in ("[1]", "{", '{"a": [null]}', json.dumps({case: [-1.0]}), json.dumps({case: [True]}),
                json.dumps({case: ["9"]}), json.dumps({case: [1.0] * 99}), json.dumps({case: {"x": 1}})):  # fmt: skip
        (kept / known.SPEEDS).write_text(bad)
        assert known.time_of(box, NATIVE).seconds is None, bad
    (kept / known.SPEEDS).write_text(json.dumps({f"{n}": [1.0] for n in range(3 * known.MOST_CASES)}))
    known.remember_run(box, NATIVE, result(5.0))
    assert len(json.loads((kept / known.SPEEDS).read_text())) == known.MOST_CASES
    for bad in ({"name": 3}, {"name": "x", "numbers": {"a": [1, -1, 4]}}, {"name": "x", "numbers": {"a": [1, 1]}}):
        (kept / known.SCATTER).write_text(json.dumps({known.scatter_key(box): bad}))
        assert known.scatter_of(box, "a") is None


def test_a_folder_that_cannot_be_written_changes_nothing(box, kept):
    kept.write_text("a file in its place")
    known.remember_run(box, NATIVE, result(5.0))
    assert kept.read_text() == "a file in its place" and known.time_of(box, NATIVE).seconds is None


@pytest.mark.parametrize(("scatter", "within"), [(0.01, 0.02), (0.02, 0.02), (0.1, 0.02), (0.3, 0.05), (2.0, 0.5)])
def test_starts_are_the_fewest_whose_interval_is_narrow_enough(scatter, within):
    """The interval of Student's t by scipy.stats, for n and n - 1."""
    from scipy.stats import t

    n = known.starts_for(scatter, within)
    half = [t.ppf(0.975, k - 1) * scatter / np.sqrt(k) if k > 1 else np.inf for k in (n - 1, n)]
    assert half[1] <= within < half[0]


def test_no_number_of_starts_above_the_most():
    assert known.starts_for(10.0, 1e-4) is None
    assert known.starts_for(0.0, 0.01) == 2


def test_the_range_of_a_scatter_holds_the_true_one_as_often_as_it_says():
    """Normal draws: nine in ten ranges of four starts hold the true scatter, within four standard errors of 2,000."""
    draws = np.random.default_rng(3).normal(1, 0.05, (2000, 4))
    found = [known.scatter_of_starts(1.0, sd, 4, "") for sd in draws.std(1, ddof=1)]
    held = np.mean([one.low <= 0.05 <= one.high for one in found])
    assert held == pytest.approx(known.SURE, abs=4 * np.sqrt(known.SURE * (1 - known.SURE) / 2000))


def test_power_is_told_with_its_source(box):
    time = known.RunTime(3.0, 2.0, 4.0, 3, "3 runs")
    none = known.power_of(box, "energy.max_deviation", 0.02, time)
    assert none.starts is None and "--pilot" in str(none)
    other = box.replace({"run.duration": 2 * box.fields.run.duration, "name": "another"})
    known.remember_scatter(other, {"energy.max_deviation": (1.0, 0.1, 8)})
    like = known.power_of(box, "energy.max_deviation", 0.02, time)
    assert "other cases (another)" in like.source and like.starts == known.starts_for(0.1, 0.02)
    known.remember_scatter(box, {"energy.max_deviation": (2.0, 0.1, 5)})
    known.remember_scatter(box, {"energy.max_deviation": (2.0, 0.9, 4)})
    own = known.power_of(box, "energy.max_deviation", 0.02, time)
    assert own.source == "5 starts of this case", "fewer starts do not take the place of more"
    assert own.starts == known.starts_for(0.05, 0.02) and own.low < own.starts < own.high
    assert own.seconds == 3.0 * own.starts and f"about {own.starts} starts" in str(own) and "estimate" in str(own)
    known.remember_scatter(box, {"x.y": (2.0, 0.9, 2), "x.z": (float("nan"), 1.0, 5)})
    assert known.scatter_of(box, "x.y") is None and known.scatter_of(box, "x.z") is None


@pytest.mark.parametrize("scene", ["stable_jump", "dam_break"])
def test_steps_of_discs_that_are_foreseen(scene):
    """Within a tenth of what runs counted: 5.53e8 of `stable_jump`, whose channel is full; 1,200 discs that stay."""
    case = load_case(INPUTS / f"{scene}.yaml")
    counted = 552577756 if scene == "stable_jump" else 1200 * case.scene().steps
    assert known.expected_disc_steps(case.scene()) == pytest.approx(counted, rel=0.1)


def test_check_tells_both_and_refuses_what_is_no_number(monkeypatch, capsys, tmp_path, box):
    path = tmp_path / "box.yaml"
    path.write_text(box.to_yaml())
    known.remember_scatter(box, {"energy.max_deviation": (2.0, 0.1, 5)})
    monkeypatch.chdir(tmp_path)
    status, out, _ = call(monkeypatch, capsys, "check", path, "--of", "energy.max_deviation", "--within", "2 %")
    assert status == 0 and "time of a run: not known" in out and "energy.max_deviation within ± 2 % takes about" in out
    status, out, _ = call(monkeypatch, capsys, "check", path, "--json", "--of", "energy.max_deviation")
    assert json.loads(out)["power"][0]["starts"] >= 2 and json.loads(out)["run_time"]["seconds"] is None
    for words, said in (
        (("--of", "energy.none"), "no number 'none'"), (("--pilot", "4"), "name it with --of"),
        (("--of", "energy.max_deviation", "--within", "0"), "out of range"),
    ):  # fmt: skip
        status, _, told = call(monkeypatch, capsys, "check", path, *words)
        assert status == 2 and said in told
    assert [one.name for one in tmp_path.iterdir() if one.name not in ("cache", "box.yaml")] == []


@pytest.mark.long
def test_a_pilot_runs_starts_that_a_study_goes_on_with(monkeypatch, capsys, tmp_path, box):
    path = tmp_path / "box.yaml"
    path.write_text(box.to_yaml())
    monkeypatch.chdir(tmp_path)
    words = ("check", path, "--of", "energy.max_deviation", "--pilot", "3")
    status, out, _ = call(monkeypatch, capsys, *words)
    assert status == 0 and "3 starts of this case" in out and (tmp_path / "runs" / "box_sweep" / "sweep.html").is_file()
