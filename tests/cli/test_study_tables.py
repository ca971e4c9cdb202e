# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of studies on a terminal are drawn there: no code of the terminal stands among their text."""

from __future__ import annotations

import os
import re
import sys
from types import SimpleNamespace

import pytest
import yaml
from made_up import BOX, STUDY

import lammps_jump as lj
from lammps_jump import studies, sweeps
from lammps_jump.cli.app import main

TABLE = "# A study\n\n| scene | y2 \x1b[31m |\n|---|---:|\n| quick_jump | 3.36 ± 0.02 |"
"""A table whose text holds a command for the terminal."""
COMMANDS = {
    "sweep": ("sweep", "study.yaml", "--out", "study"),
    "sweep --table": ("sweep", "study.yaml", "--out", "study", "--table"),
    "build-and-run --members": ("build-and-run", "box.yaml", "--out", "study", "--members", "2"),
    "bench": ("bench", "box.yaml"),
    "bench --table": ("bench", "box.yaml", "--table"),
    "sensitivity": ("sensitivity",),
    "calibrate": ("calibrate",),
}


@pytest.fixture
def on_a_terminal(tmp_path, monkeypatch):
    """What a command writes to a pseudo-terminal, no study being run."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(STUDY))
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(BOX))
    for place, name in (
        (studies.bench, "run_bench"), (studies.bench, "stored_table"), (studies, "run_sensitivity"),
        (studies, "run_calibration"), (sweeps.page, "table_text"),
    ):  # fmt: skip
        monkeypatch.setattr(place, name, lambda *_, **__: TABLE)
    monkeypatch.setattr(sweeps.page, "doubts", lambda _: [])
    unrun = SimpleNamespace(
        failed=(), runs=[], study=SimpleNamespace(axes=[]), folder=tmp_path, status=lambda: "nothing was run"
    )
    monkeypatch.setattr(lj, "sweep", lambda *_, **__: unrun)

    def written(*arguments: str) -> str:
        ours, its = os.openpty()
        with os.fdopen(its, "w") as terminal:
            monkeypatch.setattr(sys, "stdout", terminal)
            monkeypatch.setattr(sys, "argv", ["lammps-jump", *arguments])
            with pytest.raises(SystemExit) as stop:
                main()
            assert not stop.value.code
            text = os.read(ours, 100_000).decode()
        os.close(ours)
        return text

    return written


@pytest.mark.parametrize("arguments", COMMANDS.values(), ids=COMMANDS)
def test_a_table_is_drawn_and_its_own_codes_are_shown(on_a_terminal, arguments):
    screen = on_a_terminal(*arguments)
    drawn = re.sub(r"\x1b\[[0-9;]*m", "", screen)
    assert "\x1b[" in screen and "\x1b" not in drawn, "codes of rich, and no others"
    assert "──" in drawn and "|---" not in drawn, "a table, not its Markdown"
    # the command in the table is text, and it is the only one
    assert re.findall(r"\\x\w\w", drawn) == [r"\x1b"], drawn


def test_members_of_a_case_collect_what_is_named(on_a_terminal, monkeypatch):
    asked = {}
    nothing = lj.sweep()
    monkeypatch.setattr(lj, "sweep", lambda *_, **fields: asked.update(fields) or nothing)
    on_a_terminal("build-and-run", "box.yaml", "--members", "2", "--collect", "energy.drift, energy.final")
    assert (asked["members"], asked["collect"]) == ("2", ["energy.drift", "energy.final"])
