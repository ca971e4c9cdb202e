# SPDX-License-Identifier: GPL-2.0-or-later
"""The array job of a study: its file, its submission to a stand-in of Slurm, its tasks."""

from __future__ import annotations

import os
import signal
import subprocess

import pytest
import yaml
from children import LIMIT, run_program
from made_up import BOX, STUDY, call

import lammps_jump as lj
from lammps_jump.script.job import Site
from lammps_jump.sweeps import Sweep, held_study, prepare, read_study, slurm

SBATCH = '#!/bin/bash\necho "$@" >> asked\necho "${SBATCH_SAYS:-17;cluster}"\nexit "${SBATCH_ENDS:-0}"\n'
SQUEUE = '#!/bin/bash\ncat "$SQUEUE_SAYS" 2>/dev/null\n'
PROGRAM = '#!/bin/bash\necho "$PWD $*"\nexit "${ENDS:-0}"\n'


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """A folder of stand-ins, first on the path."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, text in (("sbatch", SBATCH), ("squeue", SQUEUE), ("lammps-jump", PROGRAM)):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    return folder


@pytest.fixture
def study(tmp_path):
    """A study file of eight members."""
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump(STUDY, sort_keys=False))
    return path


def prepared(folder, **changes) -> Sweep:
    """A study of eight members that is written and not run."""
    found = Sweep(read_study({**STUDY, **changes}), folder)
    with held_study(folder):
        prepare(found)
    return found


def options(text: str) -> list[str]:
    return [line.removeprefix("#SBATCH ") for line in text.splitlines() if line.startswith("#SBATCH ")]


def test_the_file_is_one_array_that_is_requeued(tmp_path):
    found = Sweep(read_study(STUDY), tmp_path)
    site = Site(partition="short", time="1:00:00", modules=["gcc"])
    text = slurm.array_text(found, range(8), site, at_once=3)
    asked = options(text)
    for option in ("--array=0,1,2%3", "--requeue", "--open-mode=append", "--ntasks=1", "--output=slurm/%A_%a.out"):
        assert option in asked
    assert any(option.startswith("--signal=B:USR1@") for option in asked) and "module load gcc" in text
    assert asked[-2:] == ["--partition=short", "--time=1:00:00"]  # the last one holds


@pytest.mark.parametrize(
    ("numbers", "at_once", "array", "each"),
    [(range(8), 32, "0,1,2,3,4,5,6,7", 1), (range(8), 3, "0,1,2", 3), ([5, 6], 1, "2,3", 2), ([7], 4, "7", 1)],
)
def test_short_members_share_a_task(tmp_path, numbers, at_once, array, each):
    text = slurm.array_text(Sweep(read_study(STUDY), tmp_path), numbers, Site(), at_once=at_once)
    assert f"--array={array}%{at_once}" in options(text) and f"SLURM_ARRAY_TASK_ID * {each}))" in text


def test_long_members_have_tasks_of_their_own_and_many_fit_the_largest_array(tmp_path, monkeypatch):
    found = Sweep(read_study(STUDY), tmp_path)
    monkeypatch.setattr(slurm, "TASK_SECONDS", 0)
    assert "--array=0,1,2,3,4,5,6,7%1" in options(slurm.array_text(found, range(8), Site(), at_once=1))
    monkeypatch.setattr(slurm, "MOST_TASKS", 4)
    assert "--array=0,1,2,3%32" in options(slurm.array_text(found, range(8), Site()))


def test_ranks_are_tasks_of_the_job(tmp_path):
    case = {**BOX, "engine": {"name": "lammps", "kernel": "stock"}}
    found = Sweep(read_study({**STUDY, "case": case, "set": {"engine.ranks": 2}}), tmp_path)
    assert "--ntasks=2" in options(slurm.array_text(found, range(8), Site()))


def test_a_task_asks_for_its_members(tmp_path, programs):
    found = prepared(tmp_path / "out")
    job = tmp_path / "job"  # Slurm runs a copy that lies somewhere else
    job.write_text(slurm.array_text(found, range(8), Site(), at_once=3, retry=True))
    names = {"SLURM_SUBMIT_DIR": str(found.folder), "SLURM_ARRAY_TASK_ID": "2", "SLURM_JOB_ID": "9", "ENDS": "75"}
    done = subprocess.run(["bash", job], env=os.environ | names, cwd="/", capture_output=True, text=True, timeout=LIMIT)
    assert (done.returncode, done.stdout) == (75, f"{found.folder} sweep . --member 6-8 --retry\n")


@pytest.mark.long
def test_it_is_submitted_from_its_folder(tmp_path, programs, study, monkeypatch, capsys):
    (tmp_path / "site.yaml").write_text("account: water\nenvironment: /opt/py\n")
    command = ["sweep", study, "--slurm", tmp_path / "site.yaml", "--out", tmp_path / "out", "--jobs", 2]
    status, out, _ = call(monkeypatch, capsys, *command)
    assert status == 0 and out == f"{tmp_path / 'out'}: array job 17\n"
    assert (tmp_path / "out/asked").read_text() == f"--parsable --chdir={tmp_path / 'out'} sweep.slurm\n"
    text = (tmp_path / "out/sweep.slurm").read_text()
    assert "--account=water" in options(text) and "--array=0,1%2" in options(text) and "PATH=/opt/py/bin" in text
    assert (tmp_path / "out/slurm").is_dir() and len(slurm.open_sweep(tmp_path / "out").members) == 8
    lj.sweep(tmp_path / "out", jobs=1)
    assert "nothing to submit" in call(monkeypatch, capsys, "sweep", tmp_path / "out", "--slurm")[1]


def test_members_of_a_case_are_submitted_as_a_study(tmp_path, programs, monkeypatch, capsys):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(BOX))
    (tmp_path / "site.yaml").write_text("account: water\n")
    command = ["build-and-run", tmp_path / "box.yaml", "--members", 4, "--out", tmp_path / "out", "--jobs", 2]
    status, out, _ = call(monkeypatch, capsys, *command, "--slurm", tmp_path / "site.yaml")
    assert status == 0 and out == f"{tmp_path / 'out'}: array job 17\n"
    text = (tmp_path / "out/sweep.slurm").read_text()
    assert "--account=water" in options(text) and "--array=0,1%2" in options(text)
    slurm.run_task(tmp_path / "out", "0-3")
    assert "nothing to submit" in call(monkeypatch, capsys, *command, "--slurm")[1]
    assert all((run.folder / "player.json").exists() for run in slurm.open_sweep(tmp_path / "out").runs)
    status, _, said = call(monkeypatch, capsys, "build-and-run", tmp_path / "box.yaml", "--slurm")
    assert status == 2 and "--slurm: is for --members" in said and f"build {tmp_path / 'box.yaml'} --slurm" in said
    status, _, said = call(monkeypatch, capsys, *command, tmp_path / "site.yaml")
    assert status == 2 and "a site file is for --slurm" in said
    assert call(monkeypatch, capsys, *command, "--slurm", "--force")[0] == 2


def test_the_queue_is_told_and_nothing_is_submitted_twice(tmp_path, programs, study, monkeypatch, capsys):
    out = prepared(tmp_path / "out").folder
    said = tmp_path / "said"
    monkeypatch.setenv("SQUEUE_SAYS", str(said))
    said.write_text(f"PENDING {out}\nRUNNING {out}\nPENDING {out}\nRUNNING {out}-2\n")
    status, text, _ = call(monkeypatch, capsys, "sweep", out, "--status")
    assert status == 0 and text == "8 runs at 4 points: 8 waiting; tasks of Slurm: 2 pending, 1 running\n"
    status, _, text = call(monkeypatch, capsys, "sweep", out, "--slurm")
    assert status == 2 and "3 tasks in Slurm's queue" in text and not (out / "asked").exists()


def test_a_refusal_is_told(tmp_path, programs, study, monkeypatch, capsys):
    monkeypatch.setenv("SBATCH_ENDS", "1")
    command = ["sweep", study, "--slurm", "--out", tmp_path / "out"]
    status, _, text = call(monkeypatch, capsys, *command)
    assert status == 2 and "sbatch refuses" in text
    monkeypatch.setenv("PATH", str(tmp_path))
    status, _, text = call(monkeypatch, capsys, *command)
    assert status == 2 and "sbatch is not installed" in text
    assert call(monkeypatch, capsys, "sweep", tmp_path / "out", "--status")[1] == "8 runs at 4 points: 8 waiting\n"
    status, _, text = call(monkeypatch, capsys, "sweep", study, tmp_path / "site.yaml")
    assert status == 2 and "a site file is for --slurm" in text


def test_tasks_run_ranges_of_members(tmp_path):
    found = prepared(tmp_path / "out")
    slurm.run_task(found.folder, "6-8")
    stages = [state.stage for state in slurm.open_sweep(found.folder).states.values()]
    assert stages == ["waiting"] * 6 + ["done"] * 2
    for wrong in ("8", "5-4", "a", "-1", ""):
        with pytest.raises(lj.CaseError, match="has members 0 to 7; a range is 4-7"):
            slurm.run_task(found.folder, wrong)


def test_a_member_that_fails_does_not_keep_the_next_from_being_run(tmp_path):
    case = {**BOX, "domain": {"x": [-1, 2.1], "y": [-1, 3]}}
    found = prepared(tmp_path / "out", case=case, axes={"walls.box.x": [[0, 20], [0, 2]]}, members=1)
    for retry in (False, True):
        with pytest.raises(lj.RunError, match=r"^member 0: .*domain"):
            slurm.run_task(found.folder, "0-1", retry=retry)
    (failure,) = slurm.open_sweep(found.folder).failed
    assert failure.point == 0 and len(slurm.open_sweep(found.folder).runs) == 1


def test_members_that_until_asks_for_are_submitted(tmp_path, programs):
    fields = {**STUDY, "axes": {}, "members": 1, "until": {"force.box.impulse_x": "1e-6%"}, "most_members": 6}
    for members in (1, 4, 6):
        found = Sweep(read_study(fields), tmp_path / "out")
        assert slurm.submit(found, Site()) == "17"
        assert len(slurm.open_sweep(found.folder).members) == members
        slurm.run_task(found.folder, f"0-{members - 1}")
    assert slurm.submit(Sweep(read_study(fields), tmp_path / "out"), Site()) == ""


@pytest.mark.long
def test_a_signal_ends_a_task_and_the_same_call_goes_on(tmp_path):
    found = prepared(tmp_path / "out")
    words = "sweep", found.folder, "--member", "0-2"
    status, said = run_program(*words, signal_at=(signal.SIGUSR1, 100))
    assert status == 75 and "the same command goes on" in said
    stages = [state.stage for state in slurm.open_sweep(found.folder).states.values()]
    assert stages == ["interrupted"] + ["waiting"] * 7
    assert run_program(*words)[0] == 0
    assert len(slurm.open_sweep(found.folder).runs) == 3


def test_members_of_another_program_are_refused(tmp_path):
    found = prepared(tmp_path / "out")
    listed = (found.folder / "points.json").read_text()
    (found.folder / "points.json").write_text(listed.replace(found.members[0].key, "0123456789ab"))
    with pytest.raises(lj.SetupError, match="prepared with another version"):
        slurm.run_task(found.folder, "0")
