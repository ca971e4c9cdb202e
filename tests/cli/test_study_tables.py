# SPDX-License-Identifier: GPL-2.0-or-later
"""What commands print on a terminal: tables are drawn there, and no text of a user commands the terminal."""

from __future__ import annotations

import os
import re
import sys
from types import SimpleNamespace

import pytest
import yaml
from made_up import BOX, STUDY

import lammps_jump as lj
from lammps_jump import runs, studies, sweeps
from lammps_jump.cli.app import main

pytestmark = pytest.mark.usefixtures("kept_workers")

TABLE = "# A study\n\n| scene | y2 \x1b[31m |\n|---|---:|\n| quick_jump | 3.36 ± 0.02 |"
"""A table whose text holds a command for the terminal."""
COMMANDS = {
    "sweep": ("sweep", "study.yaml", "--out", "study"),
    "sweep --table": ("sweep", "study.yaml", "--out", "study", "--table"),
    "build-and-run --members": ("build-and-run", "box.yaml", "--out", "study", "--members", "2"),
    "bench": ("bench", "box.yaml"),
    "bench --table": ("bench", "box.yaml", "--table"),
    "sensitivity": ("sensitivity",),
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
        (studies.bench, "run_bench"), (studies.bench, "stored_table"), (sweeps.page, "table_text"),
    ):  # fmt: skip
        monkeypatch.setattr(place, name, lambda *_, **__: TABLE)
    monkeypatch.setattr(studies.points, "run_named", lambda *_, **__: ({"bad": []}, TABLE))
    monkeypatch.setattr(studies.points, "run_study", lambda *_, **__: ({"bad": []}, TABLE))
    monkeypatch.setattr(sweeps.page, "doubts", lambda _: [])
    monkeypatch.setattr(sweeps.pool, "prepare_workers", lambda: None)
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


PLAIN = {
    "new": (("new",), "quick_jump"),
    "check": (("check", "box.yaml"), "discs at the start"),
    "status": (("sweep", "study.yaml", "--out", "study", "--status"), "8 runs at 4 points: 8 waiting"),
    "stress": (("stress", "--out", "a\x1b[31m"), r"see a\x1b[31m/stress.md"),
    "show": (("show", "a\x1b[31m"), r"a\x1b[31m/report.html"),
    "compare": (("compare", "one", "two", "--out", "a\x1b[31m"), r"a\x1b[31m"),
    "cross-validate": (("cross-validate", "box.yaml", "--out", "a\x1b[31m"), r"| y2 \x1b[31m |"),
}
"""Words of a command, and what its screen holds; it prints neither Markdown that is drawn nor a bar."""


@pytest.mark.parametrize(("arguments", "held"), PLAIN.values(), ids=PLAIN)
def test_other_commands_send_no_code_to_the_terminal(on_a_terminal, tmp_path, monkeypatch, arguments, held):
    (tmp_path / "a\x1b[31m").mkdir()
    (tmp_path / "a\x1b[31m" / "report.html").touch()
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    study = studies.cross_validation
    monkeypatch.setattr(study, "cross_validate", lambda *_, **__: {"passed": True, "name": "box"})
    monkeypatch.setattr(study, "verdict_text", lambda _: TABLE)
    monkeypatch.setattr(runs, "compare_folders", lambda first, second, path: path)
    screen = on_a_terminal(*arguments)
    assert "\x1b" not in screen and held in screen, screen


def test_the_end_of_a_run_is_a_table_of_the_width_of_the_terminal(on_a_terminal, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    case = {**BOX, "analysis": {"figures": "none", "energy": True}}
    lj.load_case(case).run(tmp_path / "run")
    lines = on_a_terminal("analyze", "run").replace("\r", "").splitlines()
    assert "\x1b" not in "".join(lines) and len(lines) <= 12 and max(map(len, lines)) <= 80, lines
    assert "measured" in lines[1] and any(line.startswith("energy at the end") for line in lines), lines


def test_members_of_a_case_collect_what_is_named(on_a_terminal, monkeypatch):
    asked = {}
    nothing = lj.sweep()
    monkeypatch.setattr(lj, "sweep", lambda *_, **fields: asked.update(fields) or nothing)
    on_a_terminal("build-and-run", "box.yaml", "--members", "2", "--collect", "energy.drift, energy.final")
    assert (asked["members"], asked["collect"]) == ("2", ["energy.drift", "energy.final"])
