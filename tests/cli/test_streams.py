# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line where standard output is closed, full or ASCII only, or where its folder is gone."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest
from made_up import INPUTS

from lammps_jump.cli.app import PatientStream, main, patient_output

COMMAND = [sys.executable, "-m", "lammps_jump"]
SHORT = ["--engine", "native", "--set", "run.duration=0.05", "--set", "analysis.figures=none"]


def status_of(monkeypatch, *words) -> int:
    """Exit status of the command line, in this process."""
    monkeypatch.setattr(sys, "argv", ["lammps-jump", *map(str, words)])
    with pytest.raises(SystemExit) as stop:
        main()
    return int(stop.value.code or 0)


def test_run_goes_on_where_nobody_reads(tmp_path, monkeypatch, capsys):
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        status = status_of(
            monkeypatch, "build-and-run", INPUTS / "energy_box_7.yaml", "--out", tmp_path / "run", *SHORT
        )
    errors = capsys.readouterr().err
    assert status == 0 and "Traceback" not in errors and "BrokenPipe" not in errors
    assert (tmp_path / "run" / "profiles.nc").exists()


def test_full_device_is_an_error_without_a_traceback():
    """In a process of its own: what is left in the buffer at its end must not become a traceback."""
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:
        done = subprocess.run([*COMMAND, "schema"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1 and done.stderr.startswith("error: standard output cannot be written")
    assert done.stderr.count("\n") == 1


def test_ascii_output_and_a_name_with_an_accent(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written = {}
    for name in ("stdout", "stderr"):
        written[name] = io.BytesIO()
        monkeypatch.setattr(sys, name, io.TextIOWrapper(written[name], encoding="ascii"))
    (tmp_path / "été.yaml").write_text((INPUTS / "quick_jump.yaml").read_text())
    assert status_of(monkeypatch, "build", "été.yaml", "--out", "dépôt") == 0
    assert b"d?p?t: run it with" in written["stdout"].getvalue()
    assert status_of(monkeypatch, "check", "à.yaml") == 2
    assert b"no such case file" in written["stderr"].getvalue() and b"?.yaml" in written["stderr"].getvalue()


def test_folder_that_is_gone(tmp_path, monkeypatch, capsys):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert status_of(monkeypatch, "doctor") == 2
    assert capsys.readouterr().err.startswith("error: the current folder was deleted")


def test_streams_are_given_back():
    before = sys.stdout, sys.stderr
    with patient_output() as output:
        assert sys.stdout is output and isinstance(sys.stderr, PatientStream)
        assert output.encoding == before[0].encoding
    assert (sys.stdout, sys.stderr) == before
