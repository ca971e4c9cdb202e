# SPDX-License-Identifier: GPL-2.0-or-later
"""Threads of the compiled kernel: how many there are changes no bit, and who asks for them is heard."""

from __future__ import annotations

import pytest
from made_up import INPUTS, plugin_or_skip

import lammps_jump as lj
from lammps_jump.engines import Setting, run
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.choice import THREADS, choose_threads
from lammps_jump.provenance import usable_cores

FLOOR = [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}]
SCENES = {
    "quick_jump": {"run.duration": 0.2},  # inlets, outlets, discs of two sizes
    "column_collapse": {"run.duration": 0.05},  # springs, spin, sizes, a gate
    "inclined_flow": {"run.duration": 0.1},  # periodic, a rough bed
    "hydraulic_jump_graded": {"run.duration": 1.5},
    "hydraulic_jump": {"run.duration": 1.5},  # friction
    "drum": {"run.duration": 0.1},
    "sign": {"run.duration": 0.05, "contact.friction_law": "sign", "contact.friction": 0.3, "contact.rotation": True},
    "smooth": {"run.duration": 0.05, "contact.touch": "smooth"},
    # parts are of columns there
    "flat": {"run.duration": 0.1, "initial.0.x": [0, 60], "initial.0.y": [0, 0.8], "walls": FLOOR, "probes": {}},
    "flat, springs": {
        "run.duration": 0.1, "initial.0.x": [0, 60], "initial.0.y": [0, 0.8], "walls": FLOOR, "probes": {},
        "contact.friction_law": "history", "contact.friction": 0.5, "contact.rotation": True,
    },
}  # fmt: skip
SHORT = ("quick_jump", "column_collapse", "flat")


def frames_of(scene, folder, threads, **more):
    setting = Setting(kernel="compiled", plugin=plugin_or_skip(), threads=threads, **more)
    result = run(scene, folder, setting)
    return result, (folder / "dump.lammpstrj").read_bytes()


@pytest.mark.lammps
@pytest.mark.parametrize(
    ("name", "numbers"),
    [(name, "3") for name in SHORT] + [pytest.param(name, "2 3 8 auto:3", marks=pytest.mark.long) for name in SCENES],
)
def test_threads_change_no_bit(name, numbers, tmp_path):
    changes = SCENES[name]
    base = name if (INPUTS / f"{name}.yaml").exists() else "dam_break"
    scene = lj.load_case(
        INPUTS / f"{base}.yaml", {**changes, "run.output_interval": changes["run.duration"] / 5}
    ).scene()
    _, alone = frames_of(scene, tmp_path / "1", "1")
    for threads in numbers.split():
        result, found = frames_of(scene, tmp_path / threads.replace(":", "_"), threads)
        assert result.status == "complete" and found == alone


@pytest.mark.lammps
@pytest.mark.parametrize("name", ["quick_jump", pytest.param("column_collapse", marks=pytest.mark.long)])
def test_a_run_goes_on_with_another_number_of_threads(name, tmp_path):
    changes = SCENES[name]
    scene = lj.load_case(
        INPUTS / f"{name}.yaml", {**changes, "run.output_interval": changes["run.duration"] / 5}
    ).scene()
    found = []
    for first, second in (("1", "1"), ("3", "2")):
        folder = tmp_path / first
        assert frames_of(scene, folder, first, stop_at=scene.steps // 2)[0].status == "interrupted"
        setting = Setting(kernel="compiled", plugin=plugin_or_skip(), threads=second)
        result = run(scene, folder, setting, resume=read_checkpoint(folder))
        assert result.status == "complete" and result.resumed
        found.append((folder / "dump.lammpstrj").read_bytes())
    assert found[0] == found[1]


def test_who_asks_for_threads_is_heard(monkeypatch):
    compiled, native = Setting(kernel="compiled"), Setting("native", "core")
    monkeypatch.delenv(THREADS, raising=False)
    for setting in (compiled, native):
        assert choose_threads("auto", setting)[0].threads == f"auto:{usable_cores()}"
        assert choose_threads(2, setting)[0].threads == "2"
    assert choose_threads("auto", Setting(kernel="compiled", ranks=2))[0].threads == "1"
    assert choose_threads(50, compiled) == (Setting(kernel="compiled", threads="50"), [])
    monkeypatch.setenv(THREADS, "1")  # as in a member of a study
    assert choose_threads("auto", compiled)[0].threads == "auto:1"
    for setting, words in ((Setting(), "kernel stock"), (Setting("twin", "python"), "twin")):
        assert choose_threads("auto", setting) == (setting, [])
        assert choose_threads(4, setting) == (setting, [f"engine.threads: {words} runs on one thread"])


def test_threads_are_no_part_of_the_key():
    case = lj.load_case(INPUTS / "dam_break.yaml")
    assert case.replace({"engine.threads": 3}).hash == case.hash
    for wrong in (0, 65, "many", True):
        with pytest.raises(lj.CaseError, match=r"engine\.threads"):
            case.replace({"engine.threads": wrong})
