# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line where standard output is closed, full or ASCII only, or where its folder is gone."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from made_up import INPUTS

from lammps_jump.cli.app import PatientStream, patient_output

COMMAND = [sys.executable, "-m", "lammps_jump"]
SHORT = ["--engine", "native", "--set", "run.duration=0.05", "--set", "analysis.figures=none"]


def environment(**more):
    paths = [*sys.path, os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path), **more}


def test_run_goes_on_where_nobody_reads(tmp_path):
    read, write = os.pipe()
    os.close(read)
    command = [*COMMAND, "build-and-run", str(INPUTS / "energy_box_7.yaml"), "--out", str(tmp_path / "run"), *SHORT]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, env=environment())
    os.close(write)
    assert done.returncode == 0 and "Traceback" not in done.stderr and "BrokenPipe" not in done.stderr
    assert (tmp_path / "run" / "profiles.nc").exists()


def test_full_device_is_an_error_without_a_traceback():
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:
        done = subprocess.run([*COMMAND, "schema"], stdout=full, stderr=subprocess.PIPE, text=True, env=environment())
    assert done.returncode == 1 and done.stderr.startswith("error: standard output cannot be written")
    assert done.stderr.count("\n") == 1


def test_ascii_output_and_a_name_with_an_accent(tmp_path):
    options = {"cwd": tmp_path, "capture_output": True, "env": environment(PYTHONIOENCODING="ascii")}
    case = tmp_path / "été.yaml"
    case.write_text((INPUTS / "quick_jump.yaml").read_text())
    done = subprocess.run([*COMMAND, "build", "été.yaml", "--out", "dépôt"], **options)
    assert done.returncode == 0 and b"d?p?t: run it with" in done.stdout, done.stderr
    done = subprocess.run([*COMMAND, "check", "à.yaml"], **options)
    assert done.returncode == 2 and b"no such case file" in done.stderr and b"Traceback" not in done.stderr


def test_folder_that_is_gone(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    script = f"import os; os.rmdir({str(gone)!r}); import sys; sys.argv = ['lammps-jump', 'doctor']\n"
    script += "from lammps_jump.cli.app import main; main()"
    done = subprocess.run([sys.executable, "-c", script], cwd=gone, capture_output=True, text=True, env=environment())
    assert done.returncode == 2 and done.stderr.startswith("error: the current folder was deleted")


def test_streams_are_given_back():
    before = sys.stdout, sys.stderr
    with patient_output() as output:
        assert sys.stdout is output and isinstance(sys.stderr, PatientStream)
        assert output.encoding == before[0].encoding
    assert (sys.stdout, sys.stderr) == before
