# SPDX-License-Identifier: GPL-2.0-or-later
"""The job file run by bash, with stand-ins for the programs that it calls; the options of a site."""

from __future__ import annotations

import os
import subprocess

import pytest
from children import LIMIT
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.cli.run import build
from lammps_jump.engines.choice import choose_ranks
from lammps_jump.errors import CaseError
from lammps_jump.script.job import job_text, read_site, write_job

SIGNALLED = """#!/bin/bash
echo lammps-jump "$@"
trap 'echo heard {0}; exit 75' {0}
kill -{0} $PPID
while :; do sleep 0.05; done
"""


@pytest.fixture(scope="module")
def scene():
    return lj.load_case(INPUTS / "quick_jump.yaml").scene()


@pytest.fixture
def folder(scene, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    write_job(scene, folder, 4)
    (folder / "case.yaml").touch()
    return folder


def start(job, submitted_in, program='#!/bin/bash\necho lammps-jump "$@"\n', **names):
    """Status and output of the job file; `program` stands for lammps-jump, and scontrol prints what it gets."""
    programs = job.parent.parent / "bin"
    programs.mkdir(exist_ok=True)
    for name, text in (("lammps-jump", program), ("scontrol", '#!/bin/bash\necho scontrol "$@"\n')):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    environment = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}", "SLURM_JOB_ID": "7"}
    environment |= {"SLURM_SUBMIT_DIR": str(submitted_in), **names}
    done = subprocess.run(["bash", job], env=environment, cwd="/", capture_output=True, text=True, timeout=LIMIT)
    return done.returncode, done.stdout + done.stderr


def test_it_runs_the_folder_it_was_submitted_in(folder, tmp_path_factory):
    # Slurm runs a copy that lies somewhere else
    copy = tmp_path_factory.mktemp("spool") / "slurm_script"
    copy.write_text((folder / "job.slurm").read_text())
    assert start(copy, folder) == (0, "lammps-jump run . --resume\n")
    assert "#SBATCH --ntasks=4" in copy.read_text().splitlines()


def test_another_folder_is_an_error(folder, tmp_path_factory):
    status, said = start(folder / "job.slurm", tmp_path_factory.mktemp("elsewhere"))
    assert status == 2 and "submit the job from the run folder" in said


@pytest.mark.parametrize("status", [0, 1, 2, 75])
def test_the_status_is_that_of_the_run(folder, status):
    assert start(folder / "job.slurm", folder, f"#!/bin/bash\nexit {status}\n") == (status, "")


def test_a_run_out_of_time_goes_back_into_the_queue(folder):
    status, said = start(folder / "job.slurm", folder, SIGNALLED.format("USR1"))
    assert status == 75 and said.splitlines()[1:] == ["heard USR1", "scontrol requeue 7"]
    array = {"SLURM_ARRAY_JOB_ID": "3", "SLURM_ARRAY_TASK_ID": "2"}
    assert start(folder / "job.slurm", folder, SIGNALLED.format("USR1"), **array)[1].endswith("requeue 3_2\n")


@pytest.mark.parametrize("number, status", [("USR1", 138), ("TERM", 143)])
def test_a_signal_before_the_program_listens_is_not_lost(folder, number, status):
    """The signal ends a program that does not listen yet: with USR1 the job goes back into the queue all the same."""
    deaf = "#!/bin/bash\nwhile :; do sleep 0.05; done\n"
    requeued = "scontrol requeue 7\n" * (number == "USR1")
    at_once = deaf.replace("\n", f"\nkill -{number} $PPID\n", 1)
    assert start(folder / "job.slurm", folder, at_once) == (status, requeued)
    job = folder / "job.slurm"  # the signal comes while modules are loaded
    job.write_text(job.read_text().replace("\nif [ -z", f"\nkill -{number} $$\nif [ -z", 1))
    ended, said = start(job, folder, deaf)
    assert ended in (75, status) and said == requeued


def test_a_cancelled_run_does_not(folder):
    status, said = start(folder / "job.slurm", folder, SIGNALLED.format("TERM"))
    assert status == 75 and said.splitlines()[1:] == ["heard TERM"]


def test_a_site_has_options(scene, tmp_path):
    path = tmp_path / "site.yaml"
    path.write_text(
        "partition: short\naccount: 17\ntime: 12:00:00\noptions: [--qos=long, --exclusive]\n"
        "modules: [gcc/12.2, python]\nenvironment: /home/o'neil/a venv\n"
    )
    text = job_text(scene, 1, read_site(path))
    lines = text.splitlines()
    end = next(number for number, line in enumerate(lines) if not line.startswith("#"))
    options = [line.removeprefix("#SBATCH ") for line in lines[:end]]
    for option in ("--partition=short", "--account=17", "--qos=long", "--exclusive", "--requeue"):
        assert option in options
    times = [option for option in options if option.startswith("--time=")]
    assert times[-1] == "--time=12:00:00"  # the last one holds
    assert lines.index("module load gcc/12.2") < lines.index("module load python") < lines.index("child=$!")
    path = tmp_path / "job.slurm"
    path.write_text(text.replace("module load", "echo").replace("lammps-jump run . --resume", 'echo "${PATH%%:*}"'))
    (tmp_path / "case.yaml").touch()
    assert start(path, tmp_path) == (0, "gcc/12.2\npython\n/home/o'neil/a venv/bin\n")


@pytest.mark.parametrize(
    "text, said",
    [
        ("partitoin: short", "unknown field; did you mean 'partition'"),
        ("account: x; touch PWNED", "is not allowed; one word of letters"),
        ("account: 'x\n\n  touch PWNED'", "is not allowed"),
        ("options: ['--wrap=a b']", "is not allowed"),
        ("options: [-J]", "is not allowed"),
        ("modules: gcc", "valid list"),
        ('environment: "a\\u2028b"', "cannot be printed"),
    ],
)
def test_a_site_file_is_checked(text, said, tmp_path):
    path = tmp_path / "site.yaml"
    path.write_text(text)
    with pytest.raises(CaseError, match=said) as error:
        read_site(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


def test_a_site_makes_a_job_file_that_stays(tmp_path, blank_pictures_here):
    (tmp_path / "site.yaml").write_text("partition: short")
    build(INPUTS / "quick_jump.yaml", out=tmp_path / "run", site=tmp_path / "site.yaml", set_=["run.duration=0.1"])
    job = (tmp_path / "run/job.slurm").read_text()
    assert "#SBATCH --partition=short" in job
    lj.run(lj.open_run(tmp_path / "run").case, tmp_path / "run")
    assert (tmp_path / "run/job.slurm").read_text() == job  # a job that is requeued submits nothing anew


def test_ranks_of_a_job_are_its_tasks(monkeypatch):
    many = lj.load_case(INPUTS / "dam_break.yaml", ["discs.diameter=0.02"]).scene()
    monkeypatch.setenv("SLURM_NTASKS", "13")
    some = lj.load_case(INPUTS / "quick_jump.yaml", ["run.duration=15"]).scene()
    assert choose_ranks("auto", many)[0] == 13 and choose_ranks("auto", some)[0] == 2
