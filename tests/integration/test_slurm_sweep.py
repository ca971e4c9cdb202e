# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies under a Slurm of one node: the table is that of the same study run here, to the last digit."""

from __future__ import annotations

import sys

import pytest
import yaml
from children import HOOK, run_program
from made_up import INPUTS
from one_node_slurm import missing, one_node_slurm, wait_for

import lammps_jump as lj
from lammps_jump.sweeps import open_sweep

pytestmark = [pytest.mark.slurm, pytest.mark.skipif(bool(missing()), reason=missing())]

STUDY = {
    "case": str(INPUTS / "quick_jump.yaml"),
    "set": {"run.duration": 3, "analysis.window": [2, 3]},
    "axes": {"contact.friction": [0, 0.05, 0.1]},
    "members": 2,
    "collect": ["jump.y2", "jump.speed", "jump.froude", "force.sill.impulse"],
}
STEP = 1500
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")


@pytest.fixture(scope="module")
def slurm():
    with one_node_slurm() as slurm:
        yield slurm


def written(place, **changes):
    """A study file."""
    place.mkdir(exist_ok=True)
    path = place / "friction.yaml"
    path.write_text(yaml.safe_dump({**STUDY, **changes, "set": STUDY["set"] | changes.get("set", {})}))
    return path


def sweep(slurm, *words) -> str:
    """What the command says where Slurm is."""
    status, said = run_program("sweep", *words, env=slurm.environment)
    assert status == 0, said
    return said


def submit(slurm, path, folder, *words) -> str:
    """Submit a study; the number of its array job."""
    return sweep(slurm, path, "--out", folder, "--slurm", "--jobs", "2", *words).split()[-1]


def printed(folder) -> str:
    return "\n".join(path.read_text() for path in sorted((folder / "slurm").glob("*.out")))


def end(slurm, folder, count: int):
    """Wait until no task is left; the study is then done."""
    wait_for(lambda: not slurm.ask("squeue", "-h"), "the end of the tasks")
    said = sweep(slurm, folder, "--status")
    assert said.splitlines()[0].endswith(f": {count} done"), said + printed(folder)


def table(folder) -> bytes:
    """The table that the same command writes once all is there."""
    assert run_program("sweep", folder, "--quiet")[0] == 0
    return (folder / "table.csv").read_bytes()


def here(path, folder) -> bytes:
    """The table of a study run here."""
    assert run_program("sweep", path, "--out", folder, "--jobs", "2", "--quiet")[0] == 0
    return (folder / "table.csv").read_bytes()


@pytest.mark.parametrize("engine", ["native", "lammps"])
def test_the_table_is_the_same_here_and_under_slurm(slurm, tmp_path, engine):
    path = written(tmp_path, set={"engine.name": engine})
    submit(slurm, path, tmp_path / "there")
    end(slurm, tmp_path / "there", 6)
    assert table(tmp_path / "there") == here(path, tmp_path / "here")
    verdicts = (tmp_path / "here/table.csv").read_text()
    assert "jump 2" in verdicts or "jump 1" in verdicts  # the collected numbers are there


def site(place, task: int, variables: str):
    """A site file, whose program gets variables of the test hook in one task, until that is started again."""
    program = place / "bin/lammps-jump"
    program.parent.mkdir()
    program.write_text(
        f'#!/bin/bash\n[ -n "$SLURM_RESTART_COUNT" ] || [ "$SLURM_ARRAY_TASK_ID" != {task} ] || '
        f'export PYTHONPATH={HOOK} {variables}\nexec {sys.prefix}/bin/lammps-jump "$@"\n'
    )
    program.chmod(0o755)
    (place / "site.yaml").write_text(f"environment: {place}")
    return place / "site.yaml"


@pytest.mark.parametrize("engine", ["native", "lammps"])
def test_a_task_out_of_time_goes_on(slurm, tmp_path, engine):
    """The engine sends the shell of the job USR1 at a step, as Slurm does before the time limit."""
    path, folder = written(tmp_path, set={"engine.name": engine}), tmp_path / "there"
    stop = f"JUMP_TEST_SIGNAL=10@{STEP}@first JUMP_TEST_PROCESS=$PPID"
    task = f"{submit(slurm, path, folder, site(tmp_path, 1, stop))}_1"
    assert slurm.wait(task, "PENDING", *ENDED)["Restarts"] == "1", printed(folder)
    slurm.start_soon(task)
    assert slurm.wait(task, *ENDED)["JobState"] == "COMPLETED", printed(folder)
    end(slurm, folder, 6)
    assert "goes on at" in printed(folder)
    found = table(folder)
    if engine == "native":  # a LAMMPS member that goes on differs in chaos
        assert found == here(path, tmp_path / "here")


def submitted_again(slurm, path, folder, here_folder):
    """End of a study of which one member was broken off, by the same command; its table is that of a local study."""
    wait_for(lambda: not slurm.ask("squeue", "-h"), "the end of the tasks")
    assert "3 done, 1 interrupted, 2 waiting\n" in sweep(slurm, folder, "--status")
    sweep(slurm, folder, "--slurm")
    end(slurm, folder, 6)
    assert table(folder) == here(path, here_folder)


def test_a_study_at_work_is_seen_cancelled_and_submitted_again(slurm, tmp_path):
    path, folder = written(tmp_path, set={"engine.name": "native"}), tmp_path / "there"
    number = submit(slurm, path, folder, site(tmp_path, 1, "JUMP_TEST_SLEEP=0.02"))  # minutes: it never ends by itself
    wait_for(lambda: "3 done, 1 running, 2 waiting" in open_sweep(folder).status(), "the end of the first task")
    wait_for(lambda: slurm.job(f"{number}_0")["JobState"] == "COMPLETED", "the end of the first task in the queue")
    said = sweep(slurm, folder, "--status", "--table")
    assert "3 done, 1 running, 2 waiting; tasks of Slurm: 1 running" in said and "| 0.05 |" in said
    assert run_program("sweep", folder, "--slurm", env=slurm.environment)[0] == 2  # not twice
    slurm.ask("scancel", number)
    submitted_again(slurm, path, folder, tmp_path / "here")


def test_a_task_that_is_killed_is_submitted_again(slurm, tmp_path):
    path, folder = written(tmp_path, set={"engine.name": "native"}), tmp_path / "there"
    task = f"{submit(slurm, path, folder, site(tmp_path, 0, f'JUMP_TEST_SIGNAL=9@{STEP}@first'))}_0"
    assert slurm.wait(task, *ENDED)["JobState"] == "FAILED"
    submitted_again(slurm, path, folder, tmp_path / "here")


def test_members_of_a_case_are_submitted(slurm, tmp_path):
    """One task of the three is out of time; the page has the players that the tasks packed."""
    words = "build-and-run", STUDY["case"], "--members", "3", "--jobs", "3"
    words = *words, "--set", "engine.name=native", *(f"--set={path}={value}" for path, value in STUDY["set"].items())
    stop = f"JUMP_TEST_SIGNAL=10@{STEP}@first JUMP_TEST_PROCESS=$PPID"
    there = tmp_path / "there"
    at = site(tmp_path, 1, stop)
    status, said = run_program(*words, "--out", there, "--slurm", at, env=slurm.environment)
    assert status == 0, said
    task = f"{said.split()[-1]}_1"
    assert slurm.wait(task, "PENDING", *ENDED)["Restarts"] == "1", printed(there)
    slurm.start_soon(task)
    assert slurm.wait(task, *ENDED)["JobState"] == "COMPLETED", printed(there)
    end(slurm, there, 3)
    assert run_program(*words, "--out", tmp_path / "here", "--quiet")[0] == 0
    assert table(there) == (tmp_path / "here/table.csv").read_bytes()
    assert "Member 3</option>" in (there / "sweep.html").read_text()


def test_members_of_two_ranks(slurm, tmp_path):
    path = written(tmp_path, axes={}, collect=["discs.present"], set={"run.duration": 0.5, "analysis.window": None})
    submit(slurm, path, tmp_path / "there", "--ranks", "2")
    end(slurm, tmp_path / "there", 2)
    runs = open_sweep(tmp_path / "there").runs
    assert [lj.open_run(run.folder).summary["ranks"] for run in runs] == [2, 2]
