# SPDX-License-Identifier: GPL-2.0-or-later
"""The time around the engine: its phases are all that a whole command consists of."""

from pathlib import Path

import command_overhead as overhead
import pytest
from made_up import INPUTS
from taking_turns import run_part

from lammps_jump import load_case
from lammps_jump.errors import RunError

SHORT = {"run.duration": 0.3, "run.output_interval": 0.02, "engine.name": "native"}


@pytest.mark.long
def test_phases_add_up_to_the_whole_command():
    found = overhead.command_time(load_case(INPUTS / "quick_jump.yaml", SHORT))
    whole, cpu, engine = (found.pop(name) for name in ("whole", "cpu", "engine_cpu"))
    assert cpu > engine > 0
    assert set(found) == set(overhead.PHASES) and sum(found.values()) == pytest.approx(whole)
    assert all(seconds > 0 for seconds in found.values())


def test_the_table_holds_medians_and_shares_of_the_engine(tmp_path, monkeypatch):
    all_cores, one_core = (iter([0.0, 1.0, 2.0, 9.0, 2.0, 3.0, 2.0, 1.0]) for _ in range(2))  # the first is not counted

    def timed(case, cores=()):
        more = next(one_core) + 1.0 if cores else next(all_cores)
        known = {**dict.fromkeys(overhead.PHASES, 0.5), "engine": 2.0, "report": more}
        return {**known, "whole": 5.0 + more, "cpu": 6.0, "engine_cpu": 1.5}

    monkeypatch.setattr(overhead, "command_time", timed)
    case = load_case(INPUTS / "quick_jump.yaml")
    part = ("overhead", overhead.time_commands, overhead.overhead_page)
    text = run_part(case, *part, out=tmp_path, say=lambda line: None)
    assert "| report | 2.00 | 1.00 | 3.00 | 1.50 |" in text
    assert "| **whole command** | 7.00 | 3.50 | 8.00 | 4.00 |" in text
    assert (
        "Medians of 7" in text
        and "all cores 3.50 (processor time 4.00)" in text
        and (Path(tmp_path) / "overhead.json").exists()
    )
    assert run_part(case, *part, out=tmp_path, say=lambda line: None) == text  # stored


def test_a_command_that_fails_is_told(monkeypatch):
    monkeypatch.setattr(overhead.sys, "executable", "/bin/false")
    with pytest.raises(RunError, match="the command failed"):
        overhead.command_time(load_case(INPUTS / "quick_jump.yaml", SHORT))
