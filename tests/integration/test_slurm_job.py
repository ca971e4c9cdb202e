# SPDX-License-Identifier: GPL-2.0-or-later
"""The job file run by bash, with a stand-in for LAMMPS: from the folder it was submitted in, with what it names."""

from __future__ import annotations

import os
import subprocess

import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.case.to_scene import build_scene
from lammps_jump.engines.lammps.job import write_job


@pytest.fixture
def folder(tmp_path):
    scene = build_scene(load_case(INPUTS / "quick_jump.yaml"))
    write_job(scene, tmp_path, 4)
    (tmp_path / "in.lammps").write_text("# a script\n")
    return tmp_path


def start(job, submitted_in, **names):
    environment = {**os.environ, "SLURM_SUBMIT_DIR": str(submitted_in), "LAUNCH": "echo", **names}
    return subprocess.run(["bash", str(job)], env=environment, cwd="/", capture_output=True, text=True, timeout=30)


def test_it_runs_the_script_of_the_folder_it_was_submitted_in(folder, tmp_path_factory):
    # SLURM runs a copy that lies somewhere else
    copy = tmp_path_factory.mktemp("spool") / "slurm_script"
    copy.write_text((folder / "job.slurm").read_text())
    done = start(copy, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["lmp", "-in", "in.lammps", "-log", "log.lammps", "-screen", "none"]
    assert "#SBATCH --ntasks=4" in copy.read_text()


def test_plugin_and_program_can_be_named(folder):
    done = start(folder / "job.slurm", folder, LMP="lmp_mpi", PLUGIN="/some where/jumpplugin.so")
    assert done.stdout.startswith("lmp_mpi -in in.lammps")
    assert done.stdout.rstrip().endswith("-var plugin /some where/jumpplugin.so")


def test_another_folder_is_an_error(folder, tmp_path_factory):
    done = start(folder / "job.slurm", tmp_path_factory.mktemp("elsewhere"))
    assert done.returncode == 2 and "submit the job from the run folder" in done.stderr
