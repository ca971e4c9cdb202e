# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs killed at a step: whole after --resume. Runs on a disk that is full for some steps: never called complete."""

from __future__ import annotations

import json
import random
import signal

import pytest
from children import run_program
from fault_table import LONG
from made_up import INPUTS, call, plugin_or_skip

import lammps_jump as lj

pytestmark = [pytest.mark.lammps, pytest.mark.fault("killed")]

ENGINES = {
    "native": ("--engine", "native"),
    "stock": ("--kernel", "stock"),
    "compiled": ("--kernel", "compiled"),
    "two ranks": ("--kernel", "stock", "--ranks", "2"),
}
SCENES = {
    "inlets": ("quick_jump", 1700, "run.duration=0.3", "run.output_interval=0.02", "analysis.jump=false"),
    "gate": ("wave_structure", 300, "run.duration=0.05", "run.output_interval=0.01", "initial.0.settle=0.02"),
}
"""Case, a step before its end, changes."""


def command(scene: str, engine: str, folder, *more: str) -> list[object]:
    """The words that make a run."""
    name, _, *changes = SCENES[scene]
    sets = [word for change in (*changes, "analysis.figures=none") for word in ("--set", change)]
    return ["build-and-run", INPUTS / f"{name}.yaml", *ENGINES[engine], *sets, "--quiet", "--out", folder, *more]


def kills() -> list[tuple[str, str, str, int]]:
    """Scene, engine, which process is killed, and step."""
    if not LONG:  # tests/integration/test_checkpoints.py has others
        return [("gate", "stock", "first", 200)]
    dice = random.Random(6)
    return [
        (scene, engine, who, dice.randrange(1, SCENES[scene][1]))
        for scene in ("inlets", "gate")
        for engine in ENGINES
        for who in ("first", "all")
    ]


@pytest.mark.parametrize(("scene", "engine", "who", "step"), kills())
def test_a_killed_run_goes_on_to_the_same_end(scene, engine, who, step, monkeypatch, capsys, tmp_path):
    if engine == "compiled":
        plugin_or_skip()
    folder = tmp_path / "run"
    status, _ = run_program(*command(scene, engine, folder), signal_at=(signal.SIGKILL, step, who))
    assert status == -signal.SIGKILL
    status, _, said = call(monkeypatch, capsys, *command(scene, engine, folder, "--resume"))
    assert status == 0, said
    run = lj.open_run(folder)
    assert run.status == "complete" and run.summary["steps"] == run.scene.steps
    if engine == "native":
        assert call(monkeypatch, capsys, *command(scene, engine, tmp_path / "whole"))[0] == 0
        for name in ("dump.lammpstrj", "forces.csv"):
            assert (folder / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


FULL = [("native", "text"), ("stock", "text"), ("stock", "gz"), ("stock", "binary"), ("compiled", "text")]


@pytest.mark.long  # in the process, `test_files` fills a disk
@pytest.mark.fault("full disk")
@pytest.mark.parametrize(("engine", "dump_format"), FULL if LONG else FULL[:1])
@pytest.mark.parametrize("steps", [(500, 900), (500, 10**9)][: 1 + LONG], ids=["a while", "for good"][: 1 + LONG])
def test_a_disk_that_was_full_leaves_no_complete_run(engine, dump_format, steps, tmp_path):
    """A limit of the file size stands for the disk; LAMMPS looks at no error of its dump."""
    if engine == "compiled":
        plugin_or_skip()
    words = command("inlets", engine, tmp_path / "run", "--set", f"run.dump_format={dump_format}")
    status, said = run_program(*words, env={"JUMP_TEST_FULL": "{}-{}".format(*steps)})
    assert status == 1 and "Traceback" not in said
    path = tmp_path / "run" / "summary.json"
    assert not path.exists() or json.loads(path.read_text())["status"] == "failed"
