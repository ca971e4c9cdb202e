# SPDX-License-Identifier: GPL-2.0-or-later
"""Processes that a command line will need, started before its case is read."""

import pytest
from made_up import INPUTS

from lammps_jump import engines
from lammps_jump.cli.app import start_early
from lammps_jump.sweeps import pool

CASE = str(INPUTS / "quick_jump.yaml")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["build-and-run", CASE], ["lammps"]),
        (["build-and-run", CASE, "--engine", "native"], ["native"]),
        (["build-and-run", CASE, "--members", "4"], ["workers"]),
        (["build-and-run", CASE, "--until=jump.y2 ± 1%"], ["workers"]),
        (["sweep", CASE, "--axis", "run.seed=1,2"], ["workers"]),
        (["build-and-run", CASE, "--members", "4", "--jobs", "1"], []),
        (["build-and-run", CASE, "--members=4", "--jobs=1"], []),
        (["sweep", "runs/study", "--member=3"], []),
        (["sweep", "study.yaml", "--slurm"], []),
        (["sweep", "runs/study", "--table"], []),
        (["build-and-run", "--help"], []),
        (["run", "no_such_folder"], []),
        (["check", CASE], []),
    ],
)
def test_what_a_command_line_starts(monkeypatch, words, expected):
    started = []
    monkeypatch.setattr(engines, "prepare_worker", started.append)
    monkeypatch.setattr(pool, "prepare_workers", lambda: started.append("workers"))
    start_early(words)
    assert started == expected
