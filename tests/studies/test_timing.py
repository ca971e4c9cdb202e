# SPDX-License-Identifier: GPL-2.0-or-later
"""The time around the engine: its phases are all that a whole command consists of."""

from pathlib import Path

import pytest
from made_up import INPUTS

from lammps_jump import load_case
from lammps_jump.errors import RunError
from lammps_jump.studies.bench import timing
from lammps_jump.studies.bench.command import run_bench

SHORT = {"run.duration": 0.3, "run.output_interval": 0.02, "engine.name": "native"}


@pytest.mark.long
def test_phases_add_up_to_the_whole_command():
    found = timing.command_time(load_case(INPUTS / "quick_jump.yaml", SHORT))
    whole = found.pop("whole")
    assert set(found) == set(timing.PHASES) and sum(found.values()) == pytest.approx(whole)
    assert all(seconds > 0 for seconds in found.values())


def test_the_table_holds_medians_and_shares_of_the_engine(tmp_path, monkeypatch):
    turns = iter([0.0, 1.0, 2.0, 9.0, 2.0, 3.0])  # the first one is not counted

    def timed(case):
        more = next(turns)
        return {**dict.fromkeys(timing.PHASES, 0.5), "engine": 2.0, "report": more, "whole": 5.0 + more}

    monkeypatch.setattr(timing, "command_time", timed)
    case = load_case(INPUTS / "quick_jump.yaml")
    text = run_bench(case, out=tmp_path, part="overhead", say=lambda line: None)
    assert "| report | 2.00 | 1.00 |" in text and "| **whole command** | 7.00 | 3.50 |" in text
    assert "Medians of 5" in text and (Path(tmp_path) / "overhead.json").exists()
    assert run_bench(case, out=tmp_path, part="overhead", say=lambda line: None) == text  # stored


def test_a_command_that_fails_is_told(monkeypatch):
    monkeypatch.setattr(timing.sys, "executable", "/bin/false")
    with pytest.raises(RunError, match="the command failed"):
        timing.command_time(load_case(INPUTS / "quick_jump.yaml", SHORT))
