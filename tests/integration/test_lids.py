# SPDX-License-Identifier: GPL-2.0-or-later
"""A wall that discs push, from the case to its places beside the dump: both engines, and a run that goes on."""

from __future__ import annotations

import numpy as np
import pytest
from made_up import engine_setting

from lammps_jump.case import load_case
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile
from lammps_jump.engines import choice
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.launch import run
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import SetupError
from lammps_jump.files import POSES, POSES_HEADER

pytestmark = pytest.mark.lammps
CASE = {
    "name": "lid",
    "discs": {"diameter": 0.2, "density": 1000},
    "contact": {"restitution": 0.3, "stiffness": 1e6},
    "domain": {"x": [-1, 1.4], "y": [-1, 4]},
    "walls": [
        {"name": "box", "kind": "box", "x": [0, 1], "y": [0, 3]},
        {"name": "lid", "kind": "block", "x": [0.02, 0.98], "y": [0.65, 0.8],
         "motion": {"kind": "load", "mass": 500, "force": [0, -20000]}},
        {"name": "float", "kind": "block", "x": [0.3, 0.6], "y": [1.5, 1.6],
         "motion": {"kind": "load", "mass": 50, "force": [10, -100], "axis": "both", "from": 0.01}},
    ],
    "initial": [{"kind": "lattice", "nx": 4, "ny": 3, "spacing": 0.21, "origin": [0.15, 0.1]}],
    "run": {"duration": 0.06, "output_interval": 0.01},
}  # fmt: skip


@pytest.mark.parametrize("engine", ["native", "lammps"])
def test_places_of_lids_stand_beside_the_frames(engine, plugin, tmp_path):
    scene = load_case(CASE).scene()
    kernel = {"engine": "native", "kernel": "core"} if engine == "native" else {"kernel": "compiled", "plugin": plugin}
    setting = Setting(**kernel)
    assert run(scene, tmp_path / "whole", setting).status == "complete"
    first = run(scene, tmp_path / "parts", Setting(stop_at=scene.steps // 2 + 1, **kernel))
    assert first.status == "interrupted"
    with (tmp_path / "parts" / POSES).open("a") as file:
        file.write("99,lid,9,9,9\n")  # written behind the checkpoint by a part that was killed
    second = run(scene, tmp_path / "parts", setting, resume=read_checkpoint(tmp_path / "parts"))
    assert second.status == "complete"
    for part in ("whole", "parts"):  # one row a lid and frame, each once and none empty, also of a run that went on
        head, *rows = (tmp_path / part / POSES).read_text().splitlines()
        assert head == POSES_HEADER
        times = [f"{scene.time(step):.10g}" for step in range(0, scene.steps + 1, scene.output_steps)]
        told = [(f"{float(row.split(',')[0]):.10g}", row.split(",")[1]) for row in rows]
        assert told == [(time, name) for time in times for name in scene.lids]
    found = PoseFile(tmp_path / "parts" / POSES, scene.lids)
    frames = list(open_dump(next((tmp_path / "whole").glob("dump.*"))))
    assert len(frames) == 1 + scene.steps // scene.output_steps
    whole = PoseFile(tmp_path / "whole" / POSES, scene.lids)
    for frame in frames:
        for name in scene.lids:
            assert found.at(frame.time)[name] == pytest.approx(whole.at(frame.time)[name], abs=1e-12)
    end = whole.at(frames[-1].time)
    # nothing is in its way: x = F (t - from)^2/(2 m)
    assert end["float"].x == pytest.approx(10 * (frames[-1].time - 0.01) ** 2 / 100, rel=1e-2)
    assert end["lid"].y < -0.001 and end["lid"].x == 0.0
    top = max(np.asarray(frames[-1].y)) + 0.1
    assert 0.65 + end["lid"].y == pytest.approx(top, abs=0.02)


def test_without_a_compiler_the_native_engine_runs_and_the_scripts_are_there(tmp_path, monkeypatch):
    def no_plugin():
        raise SetupError("no compiler")

    monkeypatch.setattr(choice, "plugin_path", no_plugin)
    scene = load_case(CASE, {"run.duration": 0.02}).scene()
    setting, (note,) = choice.choose("lammps", "auto", 1, scene)
    assert setting.engine == "native" and "'lid', field motion" in note
    assert run(scene, tmp_path, setting).status == "complete"
    assert "`lid`" in (tmp_path / "in.lammps").read_text().splitlines()[1]
    assert (tmp_path / "in.plugin.lammps").exists()
    with pytest.raises(SetupError, match="stock LAMMPS has no wall that discs push"):
        choice.choose("lammps", "stock", 1, scene)


SEAM = {
    "name": "seam",
    "gravity": 0,
    "discs": {"diameter": 0.1},
    "contact": {"restitution": 1, "impact_speed": 4},
    "domain": {"x": [0, 2], "y": [-0.5, 0.5], "periodic": "x"},
    "walls": [{"name": "lid", "kind": "block", "x": [1.5, 1.6], "y": [-0.15, 0.15],
               "motion": {"kind": "load", "mass": 10, "force": [0, 0], "axis": "x"}}],
    "initial": [{"kind": "list", "positions": [[1.3, 0.0]], "velocities": [[2, 0]]}],
    "run": {"duration": 0.6, "output_interval": 0.05},
}  # fmt: skip
"""A disc of 10 kg gives its 2 m/s to a lid of 10 kg after 0.075 s. The lid is 0.1 m from the end after 0.225 s."""


@pytest.mark.parametrize("engine", ["native", "compiled"])
def test_a_lid_that_comes_to_the_seam_ends_the_run(engine, tmp_path):
    """Walls do not repeat with the period: beyond the seam it would not feel the discs, without a word."""
    scene = load_case(SEAM).scene()
    assert any("'lid' along x to the seam" in text and "0.1 to 1.9 m" in text for text in scene.warnings)
    result = run(scene, tmp_path, engine_setting(engine))
    assert result.status == "failed"
    assert "wall 'lid' comes to the seam" in result.message and "between x = 0.1 and 1.9 m" in result.message
    assert "motion.axis: y" in result.message
    last = PoseFile(tmp_path / POSES, scene.lids).at(scene.time(scene.steps))["lid"]
    assert 0.2 < last.x < 0.3  # of the last frame; 0.3 m is the way to where it ends


def test_a_lid_that_moves_across_the_channel_is_no_doubt():
    assert not any("seam" in text for text in load_case(SEAM, {"walls.lid.motion.axis": "y"}).scene().warnings)
