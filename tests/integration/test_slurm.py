# SPDX-License-Identifier: GPL-2.0-or-later
"""Job files under a Slurm of one node: one run of all ranks; back into the queue on USR1, not after scancel."""

from __future__ import annotations

import sys

import pytest
from children import HOOK
from made_up import INPUTS
from one_node_slurm import missing, one_node_slurm, wait_for

import lammps_jump as lj
from lammps_jump.engines.lammps.outputs import read_log
from lammps_jump.runs.start import build
from lammps_jump.script.job import Site

pytestmark = [pytest.mark.slurm, pytest.mark.skipif(bool(missing()), reason=missing())]

CHANGES = {"run.duration": 0.5, "run.output_interval": 0.05, "engine.kernel": "stock", "analysis.jump": False}
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")
STEP = 1500


@pytest.fixture(scope="module")
def slurm():
    with one_node_slurm() as slurm:
        yield slurm


def make(folder, *, add: str = "", **changes):
    """A run folder with its job file; `add` stands before its commands."""
    case = lj.load_case(INPUTS / "quick_jump.yaml", CHANGES | changes)
    build(case, folder, job=Site(time="10", environment=sys.prefix))
    job = folder / "job.slurm"
    job.write_text(job.read_text().replace("\ncd ", f"\n{add}\ncd ", 1))
    return case


def frames(folder):
    return (folder / "dump.lammpstrj").read_bytes()


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_job_is_one_run_of_its_ranks(slurm, tmp_path, ranks):
    case = make(tmp_path / "job", **{"engine.ranks": ranks})
    number = slurm.submit(tmp_path / "job")
    assert slurm.wait(number, *ENDED)["JobState"] == "COMPLETED", (tmp_path / f"job/slurm-{number}.out").read_text()
    run = lj.open_run(tmp_path / "job")
    assert run.status == "complete" and run.summary["ranks"] == ranks
    assert (tmp_path / "job/report.html").exists()
    if ranks == 1:
        case.run(tmp_path / "here")
        assert frames(tmp_path / "job") == frames(tmp_path / "here")


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_job_out_of_time_goes_on(slurm, tmp_path, ranks):
    """The engine sends the shell of the job USR1 at a step, as Slurm does before the time limit."""
    hook = f"PYTHONPATH={HOOK} JUMP_TEST_SIGNAL=10@{STEP}@first JUMP_TEST_PROCESS=$$"
    add = f'[ -n "${{SLURM_RESTART_COUNT:-}}" ] || export {hook}'
    case = make(tmp_path / "job", add=add, **{"engine.ranks": ranks})
    number = slurm.submit(tmp_path / "job")
    said = tmp_path / f"job/slurm-{number}.out"
    assert slurm.wait(number, "PENDING", *ENDED)["Restarts"] == "1", said.read_text()
    slurm.start_soon(number)
    assert slurm.wait(number, *ENDED)["JobState"] == "COMPLETED", said.read_text()
    run = lj.open_run(tmp_path / "job")
    assert run.status == "complete" and run.summary["steps"] == case.scene().steps
    (resumed,) = run.summary["resumed_at"]
    assert resumed >= case.scene().time(STEP)
    assert "goes on at" in said.read_text() and "lammps" in said.read_text()  # both parts wrote there


def test_a_cancelled_job_is_saved_and_stays_away(slurm, tmp_path):
    add = f"export PYTHONPATH={HOOK} JUMP_TEST_SLEEP=0.02"  # minutes, so that it never ends by itself
    make(tmp_path / "job", add=add)
    number = slurm.submit(tmp_path / "job")
    log = tmp_path / "job/log.lammps"
    wait_for(lambda: read_log(log).step > 100, "a step behind the first")
    slurm.ask("scancel", number)
    assert slurm.wait(number, *ENDED)["JobState"] == "CANCELLED"
    wait_for(lambda: not slurm.ask("squeue", "-h"), "the end of the job")
    assert slurm.job(number)["Restarts"] == "0"
    assert lj.open_run(tmp_path / "job").status == "interrupted"
    assert (tmp_path / "job/checkpoint.json").exists()
