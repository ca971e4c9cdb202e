# SPDX-License-Identifier: GPL-2.0-or-later
"""A study and its folder: nothing is computed twice, what fails is told, what was ended goes on."""

import json
import signal
import sys
from collections import Counter

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from children import run_child, run_program
from made_up import BOX, STUDY, call

import lammps_jump as lj
from lammps_jump.folders import locked
from lammps_jump.sweeps import Sweep, held_study, open_sweep, prepare, read_study, slurm
from lammps_jump.sweeps.members import run_member

pytestmark = pytest.mark.usefixtures("kept_workers")

SMALL = {**STUDY, "axes": {"run.time_step_fraction": [0.05, 0.1]}, "members": 1}
"""Two points of one member, for studies that are ended on the way."""
OUT_OF_THE_BOX = {**STUDY, "axes": {"walls.box.x": [[0, 2], [0, 20]]}, "collect": ["discs.present"]}
"""The second box is wider than the domain: its fast disc leaves the domain, and the run fails."""


def written(folder):
    """Time of change of every file of the runs."""
    return {str(path): path.stat().st_mtime_ns for path in (folder / "runs").rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return lj.sweep(STUDY, tmp_path_factory.mktemp("study") / "box", jobs=1)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return lj.sweep(SMALL, tmp_path_factory.mktemp("small") / "box", jobs=1)


def test_the_table_holds_what_the_runs_say(done):
    table = done.table
    assert table["discs.present"].dims == ("run.time_step_fraction", "discs.density", "statistic")
    assert (table["members"] == 2).all() and (table["discs.present"].sel(statistic="mean") == 16).all()
    found = [
        run.summary["energy"]["max_deviation"]
        for run in done.runs
        if run.case.fields.run.time_step_fraction == 0.1 and run.case.fields.discs.density == 500
    ]
    cell = table["energy.max_deviation"].sel({"run.time_step_fraction": 0.1, "discs.density": 500})
    assert len(found) == 2 and found[0] != found[1]  # another start is another sample
    assert float(cell.sel(statistic="mean")) == pytest.approx(np.mean(found), rel=1e-14)
    assert float(cell.sel(statistic="se")) == pytest.approx(np.std(found, ddof=1) / np.sqrt(2), rel=1e-12)
    assert "8 done" in done.status() and not done.failed and "Largest |E" in done._repr_html_()


def test_the_folder_is_the_store(done):
    names = {path.name for path in done.folder.iterdir()} - {".lammps-jump", ".lock"}
    assert names == {
        "study.yaml",
        "points.json",
        "table.csv",
        "table.nc",
        "sweep.html",
        "summary.json",
        "figures",
        "runs",
    }
    frame = pd.read_csv(done.folder / "table.csv")
    assert len(frame) == 4 and frame["energy.max_deviation_n"].tolist() == [2] * 4
    with xr.open_dataset(done.folder / "table.nc") as stored:
        assert stored["energy.max_deviation"].equals(done.table["energy.max_deviation"])
    figures = {path.name for path in (done.folder / "figures").iterdir()}
    assert figures == {"sweep_run.time_step_fraction.png", "sweep_discs.density.png", "sweep_map.png"}
    members = json.loads((done.folder / "points.json").read_text())["members"]
    assert Counter(item["point"] for item in members) == dict.fromkeys(range(4), 2)
    for item in members:
        run = lj.open_run(done.folder / "runs" / item["key"])
        assert run.status == "complete" and run.case.fields.run.seed == item["seed"]
        assert not (run.folder / "report.html").exists()


def test_nothing_is_run_twice_and_a_wider_study_takes_what_is_there(tmp_path):
    study = {**STUDY, "axes": {"run.time_step_fraction": [0.05, 0.1], "discs.density": [500]}, "members": 1}
    first = lj.sweep(study, tmp_path / "out", jobs=1)
    before = written(first.folder)
    again = lj.sweep(first.folder, jobs=1)
    assert written(first.folder) == before and again.table.equals(first.table)
    heard = []
    wider = lj.sweep(first.folder, jobs=1, members=2, progress=heard.append)
    after = written(first.folder)
    assert {name: after[name] for name in before} == before and heard[-1].done == heard[-1].total == 4
    assert (wider.table["members"] == 2).all()
    narrow = lj.sweep(first.folder, jobs=1, axes={"discs.density": [500]}, set={"run.time_step_fraction": 0.05})
    assert written(first.folder) == after and narrow.table["members"].values.tolist() == [2]


@pytest.mark.long
def test_points_that_differ_in_their_analysis_alone_have_runs_of_their_own(tmp_path):
    study = {**STUDY, "axes": {"analysis.bin_width": [0.5, 1.0]}, "members": 1}
    found = lj.sweep(study, tmp_path / "out", jobs=1)
    assert sorted(run.profiles.sizes["x"] for run in found.runs) == [2, 4]


@pytest.mark.long
def test_another_collect_analyses_again_and_does_not_run_again(done, tmp_path):
    study = {**STUDY, "axes": {}, "members": 1, "collect": ["discs.present"]}
    first = lj.sweep(study, tmp_path / "out", jobs=1)
    seconds = first.runs[0].summary["wall_seconds"]["run"]
    second = lj.sweep({**study, "collect": ["energy.drift"]}, tmp_path / "out", jobs=1)
    assert second.runs[0].summary["wall_seconds"]["run"] == seconds
    assert np.isfinite(second.values["energy.drift"]).all() and second.table["energy.drift"].dims == ("statistic",)


def test_what_fails_is_told_left_out_and_run_again_when_asked(tmp_path, monkeypatch, capsys):
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump({**OUT_OF_THE_BOX, "case": {**BOX, "domain": {"x": [-1, 2.1], "y": [-1, 3]}}}))
    status, out, _ = call(monkeypatch, capsys, "sweep", path, "--out", tmp_path / "out", "--jobs", 1)
    assert status == 1 and "walls.box.x = [0, 20], member 1: " in out and "2 done, 2 failed" in out
    found = lj.sweep(path, tmp_path / "out", jobs=1)
    assert found.table["members"].values.tolist() == [2, 0]
    assert [(failure.point, failure.seed) for failure in found.failed] == [(1, 1), (1, 2)]
    assert "domain" in found.failed[0].message and found.failed[0].message.endswith("--retry runs it again.")
    assert "left out" in (tmp_path / "out/sweep.html").read_text()
    before = written(found.folder)
    lj.sweep(path, tmp_path / "out", jobs=1)
    assert written(found.folder) == before
    lj.sweep(path, tmp_path / "out", jobs=1, retry=True)
    changed = {name for name, moment in written(found.folder).items() if moment != before.get(name)}
    assert changed and all(failure.folder.name in " ".join(changed) for failure in found.failed)


@pytest.mark.long
def test_a_study_that_is_ended_goes_on_to_the_same_table(small, tmp_path, monkeypatch, capsys):
    path, out = tmp_path / "study.yaml", tmp_path / "out"
    path.write_text(yaml.safe_dump(SMALL, sort_keys=False))
    command = ["sweep", path, "--out", out, "--jobs", "1", "--quiet"]
    status, said = run_program(*command, signal_at=(signal.SIGINT, 100))
    assert status == lj.RunInterrupted.exit_status and "continues from there" in said
    assert not (out / "table.csv").exists()
    capsys.readouterr()
    assert call(monkeypatch, capsys, "sweep", out, "--status")[1].startswith("2 runs at 2 points: ")
    assert call(monkeypatch, capsys, *command)[0] == 0
    assert (out / "table.csv").read_bytes() == (small.folder / "table.csv").read_bytes()  # to the last digit


@pytest.mark.long
def test_a_member_whose_process_is_killed_is_run_by_the_same_command(small, tmp_path):
    path, out = tmp_path / "study.yaml", tmp_path / "out"
    path.write_text(yaml.safe_dump(SMALL, sort_keys=False))
    status, _ = run_program("sweep", path, "--out", out, "--jobs", "1", "--quiet", signal_at=(signal.SIGKILL, 100))
    assert status == -signal.SIGKILL
    assert run_program("sweep", path, "--out", out, "--quiet")[0] == 0
    assert (out / "table.csv").read_bytes() == (small.folder / "table.csv").read_bytes()


@pytest.mark.long
def test_a_full_disk_is_told_and_the_same_command_goes_on(small, tmp_path):
    """A limit of the file size stands for a full disk, as in tests/faults."""
    path, out = tmp_path / "study.yaml", tmp_path / "out"
    path.write_text(yaml.safe_dump(SMALL, sort_keys=False))
    command = [sys.executable, "-m", "lammps_jump", "sweep", path, "--out", out, "--jobs", "1", "--quiet"]
    for blocks in (1, 8):  # the study cannot be written; its runs cannot
        status, said = run_child(["bash", "-c", f'ulimit -f {blocks}; exec "$0" "$@"', *command])
        assert status in (1, 2) and "Traceback" not in said and "File too large" in said
    assert not any(state.stage == "done" for state in open_sweep(out).states.values())
    assert run_child(command)[0] == 0
    assert (out / "table.csv").read_bytes() == (small.folder / "table.csv").read_bytes()


def test_two_sweeps_on_one_folder_are_refused(done):
    with locked(done.folder), pytest.raises(lj.SetupError, match="writes to this folder"):
        lj.sweep(done.folder, jobs=1)


def test_a_member_that_another_process_runs_is_left_to_it(done):
    member = done.members[0]
    with locked(member.folder(done.folder)), pytest.raises(lj.SetupError, match="writes to this folder"):
        run_member(member, done.folder, False, True)


def test_folders_of_others_are_refused(tmp_path, done):
    run = done.runs[0].folder
    with pytest.raises(lj.SetupError, match="holds a run"):
        lj.sweep(STUDY, run, jobs=1)
    with pytest.raises(lj.SetupError, match="holds a study"):
        lj.load_case(BOX).run(done.folder)
    (tmp_path / "points.json").write_text("mine")
    with pytest.raises(lj.SetupError, match="nothing there is overwritten"):
        lj.sweep(STUDY, tmp_path, jobs=1)
    with pytest.raises(lj.CaseError, match="holds no study"):
        slurm.run_task(tmp_path, "0")


def test_a_task_of_a_batch_system_runs_one_member(small, tmp_path, monkeypatch, capsys):
    found = Sweep(small.study, tmp_path / "out")
    with held_study(found.folder):
        prepare(found)
    for number in range(len(found.members)):
        assert call(monkeypatch, capsys, "sweep", found.folder, "--member", number)[0] == 0
    status, out, _ = call(monkeypatch, capsys, "sweep", found.folder, "--status", "--table")
    assert status == 0 and "2 done" in out and "| 0.05 |" in out
    assert lj.sweep(found.folder, jobs=1).table.equals(small.table)
    assert call(monkeypatch, capsys, "sweep", found.folder, "--member", 2)[0] == 2


@pytest.mark.long
def test_members_are_added_until_the_interval_is_narrow(tmp_path):
    study = {**STUDY, "axes": {}, "members": 1, "until": {"force.box.impulse_x": "40%"}, "most_members": 6}
    found = lj.sweep(study, tmp_path / "out", jobs=1)
    cell = found.table["force.box.impulse_x"].sel(statistic=["mean", "high", "n"]).values
    narrow = cell[1] - cell[0] <= 0.4 * abs(cell[0])
    assert narrow or cell[2] == 6
    assert 4 <= cell[2] <= 6 and len(found.members) == cell[2]
    assert lj.sweep(study, tmp_path / "out", jobs=1).table.equals(found.table)
    assert narrow == ("would take" not in (tmp_path / "out" / "sweep.html").read_text())


def test_members_of_one_case(tmp_path, monkeypatch, capsys):
    path = tmp_path / "box.yaml"
    path.write_text(yaml.safe_dump({**BOX, "run": {**BOX["run"], "members": 2}, "analysis": {"energy": True}}))
    monkeypatch.chdir(tmp_path)
    status, out, _ = call(monkeypatch, capsys, "build-and-run", path, "--jobs", 1)
    folder = tmp_path / "runs" / "box,members"
    assert status == 0 and "2 runs: 2 done" in out and (folder / "figures/sweep_profiles.png").exists()
    point = json.loads((folder / "summary.json").read_text())["points"][0]
    peaks = [run.summary["force"]["box"]["peak"] for run in open_sweep(folder).runs]
    assert point["numbers"]["force.box.peak"]["mean"] == pytest.approx(np.mean(peaks)) and point["members"] == 2
    assert {run.case.fields.run.seed for run in open_sweep(folder).runs} == {1, 2}
    before = written(folder)
    assert call(monkeypatch, capsys, "build-and-run", path, "--members", "2", "--quiet") == (0, "", "")
    assert written(folder) == before
    assert "is for one run" in call(monkeypatch, capsys, "build-and-run", path, "--force")[2]


def test_points_with_starts_of_their_own_share_no_seed(tmp_path):
    def seeds(**fields):
        return [(one.point, one.seed) for one in Sweep(read_study({**STUDY, **fields}), tmp_path).starts]

    own = seeds(members="3-4", starts="own")
    assert own == [(0, 3), (0, 4), (1, 7), (1, 8), (2, 11), (2, 12), (3, 15), (3, 16)]
    assert seeds(members=1) == [(point, 1) for point in range(4)]
