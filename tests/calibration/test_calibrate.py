# SPDX-License-Identifier: GPL-2.0-or-later
"""A calibration and its folder: rounds, answers with their sentences, points that are out, interruptions."""

import json
import random
import shutil
from collections import Counter
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up import BOX, call
from stand_in_runs import CASE, DENSITY, FRICTION, RESTITUTION, VARY, StandIn, angle_and_run_out, calibrated

import lammps_jump as lj
from lammps_jump.calibration import page, search
from lammps_jump.calibration.model import model_of
from lammps_jump.calibration.posterior import sample, sobol
from lammps_jump.calibration.targets import Target
from lammps_jump.errors import CaseError, RunInterrupted

pytestmark = pytest.mark.usefixtures("kept_workers")

BOTH = ["heap.angle=20 ± 0.3", "heap.run_out=3 ± 0.05"]
"""At friction 0.5 and density 1500."""


def test_two_targets_find_two_numbers(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", BOTH)
    for path, truth in ((FRICTION, 0.5), (DENSITY, 1500)):
        one = found.parameters[path]
        assert one["low"] <= truth <= one["high"] and one["low"] <= one["best"] <= one["high"]
        assert one["identified"] and not one["at_edge"] and tuple(one["prior"]) == tuple(VARY[path])
        # half a straight model's range, by its inverse: 2 x 1.96 sqrt((0.3^2 + 0.3^2)/100/2 + (0.05^2 + 0.05^2)/4/2)
        assert 0.1 < (one["high"] - one["low"]) / np.ptp(VARY[path]) < 0.25
    assert found.verdict.startswith("The measurements give: friction coefficient 0.4") and not found.notes
    assert found.data["failed"] == 0 and found.data["runs"] <= found.data["budget"] == 40
    target = found.data["targets"]["heap.angle"]
    assert target["measured"] == 20 and target["error"] == 0.3 and abs(target["at_best"] - 20) < 0.3
    assert 0.2 < target["spread"] < 0.4  # 0.3 by some 18 degrees of freedom
    assert found.samples.sizes == {"sample": 2000} and set(found.samples) == {
        FRICTION,
        DENSITY,
        *("heap.angle", "heap.run_out"),
    }
    assert float(found.samples[FRICTION].mean()) == pytest.approx(0.5, abs=0.05)
    assert found.best.fields.contact.friction == found.parameters[FRICTION]["best"]
    rounds = [one["of"] for one in found.data["rounds"]]
    assert rounds[0] == "ranges" and rounds[1] == "posterior" and rounds[-1] == "best"


def test_one_target_leaves_a_ridge_and_the_advice_that_breaks_it(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", BOTH[:1])
    assert found.correlation[FRICTION][DENSITY] == found.correlation[DENSITY][FRICTION] < -0.5
    for path in VARY:
        assert not found.parameters[path]["identified"]
        assert found.parameters[path]["measure"][0]["key"] == "heap.run_out"
    said = " ".join(found.notes)
    assert "friction coefficient is not identified: its 95 % range" in found.verdict
    assert "friction coefficient and the density hide each other (correlation -0." in said
    assert "Measure heap.run_out too: it is expected to take" in said
    # the two places that it names lie on the ridge, x + y = 1, far from each other: one standard deviation of its
    # width is 0.3 sqrt(2)/10, and the emulator's part
    ridge = [
        [(friction - 0.1) / 0.8, (density - 1000) / 1000] for friction, density in found.parameters[FRICTION]["ridge"]
    ]
    assert np.sum(ridge, axis=1) == pytest.approx([1.0, 1.0], abs=0.08)
    assert ridge[1][0] - ridge[0][0] > 0.5


def test_what_the_targets_do_not_depend_on_is_not_identified(monkeypatch, tmp_path):
    vary = {FRICTION: VARY[FRICTION], RESTITUTION: [0.2, 0.9]}
    found = calibrated(monkeypatch, tmp_path / "out", BOTH[:1], vary=vary)
    assert found.parameters[FRICTION]["identified"] and not found.parameters[RESTITUTION]["identified"]
    assert any("The targets tell little of the restitution coefficient." in one for one in found.notes)
    assert any(
        "No other number of these runs would tell the restitution coefficient apart." in one for one in found.notes
    )


def with_restitution(values):
    """The angle also moves with the restitution, which is 1 in the case and not varied: 20 degrees from 0 to 1."""
    found = angle_and_run_out(values)
    return {**found, "heap.angle": found["heap.angle"] + 20 * (1 - values.get(RESTITUTION, 1.0))}


def test_data_that_no_run_reaches_are_told_with_what_moves_them(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", ["heap.angle=45 ± 0.3", BOTH[1]], numbers=with_restitution)
    said = "The model cannot meet the data: heap.angle was measured as 45 ± 0.3, and no run of the ranges reaches it"
    assert found.verdict.startswith(f"{said}: they have 1")
    assert ". heap.angle is moved by the restitution coefficient. " in found.verdict
    (one,) = found.data["unmet"]
    assert (one["name"], one["points"], one["above"], one["below"]) == ("heap.angle", 1, 1, 0)
    assert 25 < one["runs"][1] < 31  # the largest of the ranges is 30, with a scatter of 0.3; no run is at that corner
    (moved,) = one["moved_by"]  # nothing else moves it
    # from 1 half of the way to 0.05: 9.5 degrees, with the scatter of two starts on either side
    assert moved["path"] == RESTITUTION and (moved["before"], moved["after"]) == (1.0, 0.525)
    change = moved["to_value"] - moved["from_value"]
    assert change == pytest.approx(9.5, abs=4 * 0.3)
    assert moved["closes"] == pytest.approx(change / (45 - moved["from_value"]), rel=1e-9)
    said = " ".join(found.notes)
    assert "What moves heap.angle, at the nearest point: restitution coefficient 1 to 0.525" in said
    assert f"Vary such a number too, for example --vary {RESTITUTION}=0.05:1." in said
    # rounds end when nothing meets the data: they would use the runs that look besides
    assert [one["of"] for one in found.data["rounds"]] == ["ranges", "posterior", "best"]
    assert found.data["runs"] <= found.data["budget"]


def test_changes_stay_within_the_budget_and_name_what_was_left(monkeypatch, tmp_path):
    vary = {FRICTION: VARY[FRICTION]}
    found = calibrated(monkeypatch, tmp_path / "out", ["heap.angle=45 ± 0.3"], vary=vary, budget=10)
    assert found.data["runs"] <= 10
    assert found.data["besides"]["left"], found.data["besides"]
    assert any(note.startswith("The budget had no runs left to try whether it is moved by: ") for note in found.notes)


def test_targets_that_are_reached_alone_and_not_together_are_told_so(monkeypatch, tmp_path):
    """Angle and run-out at one number: 10 to 20 degrees and 3 to 1 m, but never 19 degrees with 2.9 m."""
    vary = {FRICTION: VARY[FRICTION]}
    numbers = lambda values: {key: one for key, one in angle_and_run_out({**values, DENSITY: 1000}).items()}  # noqa: E731
    found = calibrated(monkeypatch, tmp_path / "out", ["heap.angle=19 ± 0.3", "heap.run_out=2.9 ± 0.05"],
                       vary=vary, numbers=numbers)  # fmt: skip
    assert "no run of the ranges reaches it" not in found.verdict
    assert "there are runs that reach it (10." in found.verdict and "and miss another target" in found.verdict


def test_a_best_value_at_the_edge_asks_for_a_wider_range(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", ["heap.angle=20.2 ± 0.3"], vary={FRICTION: [0.1, 0.5]})
    one = found.parameters[FRICTION]
    assert one["at_edge"] and one["edge"] == "high"
    assert any(
        "reaches the upper edge of its range, 0.5: values behind it may be as likely. Widen" in note
        for note in found.notes
    )


def test_one_start_says_that_the_scatter_is_not_known(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", BOTH[:1], vary={FRICTION: VARY[FRICTION]}, members=1, budget=16)
    assert found.data["scatter_known"] is False and found.data["targets"]["heap.angle"]["spread"] is None
    assert any("The scatter over starts is not known: every point has one start" in one for one in found.notes)


def test_an_emulator_that_is_worse_than_the_target_warns(monkeypatch, tmp_path):
    def rough(values):
        return {"heap.angle": 20 + 5 * np.sign(np.sin(40 * values[FRICTION]))}

    given = {"vary": {FRICTION: VARY[FRICTION]}, "scatter": {"heap.angle": 0.1}, "budget": 20}
    found = calibrated(monkeypatch, tmp_path / "out", ["heap.angle=20 ± 0.2"], numbers=rough, **given)
    assert any("heap.angle: the emulator is off by" in one and "more than the error" in one for one in found.notes)


def test_points_without_the_number_are_counted_and_named(monkeypatch, tmp_path):
    def partly(values):
        found = angle_and_run_out(values)
        return found if values[FRICTION] < 0.7 else {**found, "heap.angle": np.nan}

    found = calibrated(monkeypatch, tmp_path / "out", BOTH, numbers=partly)
    out = found.data["failures"]
    assert found.data["failed"] == len(out) > 0 and all(one["values"][FRICTION] >= 0.7 for one in out)
    assert f"{len(out)} runs are left out:" in found.notes
    assert any(one.startswith("friction coefficient = 0.") and one.endswith("no heap.angle") for one in found.notes)
    assert found.parameters[FRICTION]["low"] <= 0.5 <= found.parameters[FRICTION]["high"]


def test_where_too_few_points_have_the_number_there_is_no_answer(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", BOTH[:1], numbers=lambda values: {"heap.angle": np.nan})
    assert found.verdict == "No answer: 0 of 19 points have all the targets, and 5 are needed."
    assert found.parameters[FRICTION]["best"] is None and found.samples.sizes == {"sample": 0} and not found.runs


def content(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


@pytest.mark.long
def test_a_study_that_is_killed_five_times_ends_with_the_same_answer(monkeypatch, tmp_path):
    """At runs drawn at random; no run is made twice: the stand-in refuses to."""
    given = {"budget": 60, "members": 2}
    whole = calibrated(monkeypatch, tmp_path / "whole", BOTH, **given)
    stops = random.Random(4).sample(range(1, whole.data["runs"]), 5)
    runs = StandIn(angle_and_run_out, {"heap.angle": 0.3, "heap.run_out": 0.05}, stops)
    monkeypatch.setattr(search.Search, "run", lambda search, pool: runs(search, pool))  # the figures: as before
    killed = 0
    for _ in count():
        try:
            found = lj.calibrate(CASE, BOTH, VARY, tmp_path / "killed", **given)
            break
        except RunInterrupted:
            killed += 1
            assert not (tmp_path / "killed" / "calibration.json").exists()
    assert killed == 5 and len(runs.made) == whole.data["runs"]
    assert found.data == whole.data
    assert content(tmp_path / "killed")["best.yaml"] == content(tmp_path / "whole")["best.yaml"]


def test_the_same_command_does_nothing_and_a_larger_budget_goes_on(monkeypatch, tmp_path):
    found = calibrated(monkeypatch, tmp_path / "out", BOTH[:1], budget=24)
    before = content(tmp_path / "out")
    again = calibrated(monkeypatch, tmp_path / "out", BOTH[:1], budget=24)
    assert content(tmp_path / "out")["calibration.json"] == before["calibration.json"] and again.data == found.data
    more = calibrated(monkeypatch, tmp_path / "out", BOTH, budget=60)
    first = [one["values"] for one in found.data["points"]]
    assert [one["values"] for one in more.data["points"]][: len(first)] == first and more.data["runs"] > found.data[
        "runs"
    ]


def test_rounds_stop_when_no_range_shrinks_by_a_tenth():
    assert search.has_settled([(0.1, 0.5), (0, 1)], [(0.1, 0.47), (0, 0.95)])
    assert not search.has_settled([(0.1, 0.5), (0, 1)], [(0.1, 0.45), (0, 0.95)])


def test_a_folder_without_an_answer_says_so(tmp_path):
    with pytest.raises(CaseError, match="holds no answer"):
        lj.Calibrated(tmp_path)


REAL = {**BOX, "gravity": 9.81, "domain": {"x": [-1, 3], "y": [-1, 3]}, "run": {**BOX["run"], "duration": 0.2}}
"""Sixteen discs in a box, which lose energy by their restitution; a tenth of a second a run."""
ENERGY = "energy.drift"
RANGE = {RESTITUTION: [0.3, 1.0]}


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """A calibration of six native runs, one of which fails."""
    place = tmp_path_factory.mktemp("real")
    (place / "box.yaml").write_text(yaml.safe_dump(REAL))
    heard = []
    found = lj.calibrate(place / "box.yaml", [f"{ENERGY}=-0.2 ± 0.1"], RANGE, place / "out", budget=6, members=1,
                         jobs=1, progress=heard.append)  # fmt: skip
    return found, heard


def test_real_runs_are_made_kept_and_told(real, monkeypatch, capsys):
    found, heard = real
    assert found.data["runs"] == 6 and found.data["failed"] == 0
    assert (
        heard[-1].done == 6
        and heard[-1].share == 1.0
        and any(one.best.startswith("nearest run: restitution 0.") for one in heard)
    )
    assert heard[-1].best.startswith("restitution 0.") and " to " in heard[-1].best
    names = {path.name for path in found.folder.iterdir()}
    assert {
        "study.yaml",
        "rounds.json",
        "calibration.json",
        "calibration.html",
        "best.yaml",
        "samples.nc",
        "points",
    } < names
    # each point has a start of its own: common ones would be off together
    assert sorted(run.case.fields.run.seed for run in found.sweep.runs) == [1, 2, 3, 4, 5, 6]
    values = {run.case.fields.contact.restitution for run in found.sweep.runs}
    assert values == {one["values"][RESTITUTION] for one in found.data["points"]}
    before = {path: path.stat().st_mtime_ns for path in (found.folder / "points" / "runs").rglob("*")}
    status, out, _ = call(monkeypatch, capsys, "calibrate", found.folder, "--quiet")
    assert status == 0 and out.startswith(found.verdict) and f"page: {found.folder / 'calibration.html'}" in out
    assert before == {path: path.stat().st_mtime_ns for path in (found.folder / "points" / "runs").rglob("*")}


def test_the_page_opens_with_the_verdict_and_plays_the_runs(real):
    found, _ = real
    text = (found.folder / "calibration.html").read_text()
    assert text.index(found.verdict[:40]) < text.index("What to know") < text.index("Measured, and runs")
    assert text.count("data:image/png") == 2 and text.count("restitution coefficient = ") >= 6
    assert {path.name for path in (found.folder / "figures").iterdir()} == {
        "calibration_posterior.png", "calibration_targets.png"
    }  # fmt: skip
    assert '"players":[{' in text
    nearest = min(found.data["points"], key=lambda one: one["distance"])
    assert f"restitution coefficient = {nearest['values'][RESTITUTION]:.4g}, start 1" in text


def test_a_measured_curve_is_drawn_with_the_runs(tmp_path):
    """In one figure, from values made up: the runs of the real study have tables of their own, which are read."""
    at, places = np.linspace(0, 1, 20), sobol(8, 1, 1)
    values = places[:, None] * np.exp(-at) + 1e-3 * np.random.default_rng(1).normal(size=(8, 2, 20))
    target = Target("heap.depth", 0.4 * np.exp(-at), np.full(20, 0.01), "x", at)
    model = model_of(places, [target], {"heap.depth": values})
    posterior = sample(model.log_likelihood, 1)
    path = page.draw_curves(model, posterior, [values[0]], tmp_path / "calibration_curves.png")
    assert path.stat().st_size > 5000


def test_a_run_that_fails_is_counted_and_named(real, tmp_path):
    found, _ = real
    shutil.copytree(found.folder, tmp_path / "out")
    run = tmp_path / "out" / found.data["points"][1]["runs"][0]
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps({**summary, "status": "failed", "message": "a disc left the domain."}))
    again = lj.calibrate(tmp_path / "out", jobs=1)
    assert again.data["failed"] == 1 and again.data["runs"] == 6
    (failure,) = again.data["failures"]
    assert failure["values"] == found.data["points"][1]["values"]
    assert failure["message"] == "a disc left the domain. --retry runs it again."


def test_a_column_that_no_table_has_is_refused(real, tmp_path):
    shutil.copytree(real[0].folder, tmp_path / "out")
    (tmp_path / "mine.csv").write_text("t,e\n0,1\n0.1,2\n")
    curve = {"data": str(tmp_path / "mine.csv"), "columns": "time=t,energy.totl=e ± 1"}
    with pytest.raises(CaseError, match=r"energy\.csv has no column totl; there are time, "):
        lj.calibrate(tmp_path / "out", [curve], jobs=1)


def test_slurm_gets_the_runs_that_the_round_lacks(tmp_path, monkeypatch, capsys):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(REAL))
    asked = []

    def submit(found, site, at_once):
        asked.append((found.folder, len(found.left(False)), at_once))
        return "4711"

    monkeypatch.setattr("lammps_jump.sweeps.slurm.submit", submit)
    words = ("--target", f"{ENERGY}=-0.2 ± 0.1", "--vary", f"{RESTITUTION}=0.3:1", "--budget", 12)
    out = tmp_path / "out"
    status, said, _ = call(monkeypatch, capsys, "calibrate", tmp_path / "box.yaml", *words, "--slurm", "--out", out)
    assert status == 0 and said == "array job 4711\n" and asked == [(out / "points", 8, 32)]
    assert [one["of"] for one in json.loads((out / "rounds.json").read_text())["rounds"]] == ["ranges"]


@pytest.mark.long
def test_real_runs_that_are_killed_five_times_end_with_the_same_answer(tmp_path):
    """Sixty native runs; the study is ended in this process at runs drawn at random."""
    given = {"budget": 60, "members": 2, "jobs": 2, "out": tmp_path / "whole"}
    targets, vary = [f"{ENERGY}=-0.2 ± 0.1"], {**RANGE, "discs.density": [500, 2000]}
    whole = lj.calibrate(REAL, targets, vary, **given)
    stops = random.Random(1).sample(range(1, whole.data["runs"]), 5)

    def end(progress):
        if progress.done in stops:
            stops.remove(progress.done)
            raise RunInterrupted("ended here")

    made = Counter()
    while True:
        try:
            found = lj.calibrate(REAL, targets, vary, **{**given, "out": tmp_path / "killed"}, progress=end)
            break
        except RunInterrupted:
            made["ended"] += 1
    assert made["ended"] == 5 and found.data == whole.data


HEAP = Path(__file__).parents[2] / "benchmarks" / "twins" / "heap.yaml"


@pytest.mark.long
def test_one_repose_angle_of_a_real_heap_leaves_a_ridge(tmp_path):
    vary = {FRICTION: (0.1, 0.9), "contact.rolling.friction": (0.0, 0.4)}
    found = lj.calibrate(HEAP, {"heap.angle": (17, 1)}, vary, tmp_path / "out", budget=40)
    assert found.correlation[FRICTION]["contact.rolling.friction"] < -0.5
    assert not any(one["identified"] for one in found.parameters.values())
    assert any("hide each other (correlation -0." in one for one in found.notes)


@pytest.mark.long
def test_the_restitution_of_a_real_heap_is_not_identified(tmp_path):
    vary = {RESTITUTION: (0.1, 0.9)}
    found = lj.calibrate(HEAP, {"heap.angle": (18, 1)}, vary, tmp_path / "out", budget=24)
    assert not found.parameters[RESTITUTION]["identified"]
    assert found.verdict.startswith("The restitution coefficient is not identified: its 95 % range")
