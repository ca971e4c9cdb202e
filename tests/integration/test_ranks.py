# SPDX-License-Identifier: GPL-2.0-or-later
"""The compiled kernel on two ranks of the wheel's MPI: same motion, same balance, and an end that leaves nothing."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from children import run_program
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.dump.read import open_dump
from lammps_jump.engines.lammps.loader import program
from lammps_jump.engines.lammps.outputs import read_log
from lammps_jump.engines.launch import Setting
from lammps_jump.engines.launch import run as run_scene

pytestmark = pytest.mark.lammps
MANY = ("run.duration=0.2125", "run.output_interval=0.2125", "discs.diameter=0.05", "initial=[]")
SPRINGS = (
    "run.duration=0.0935", "run.output_interval=0.0935", "contact.friction_law=history", "contact.friction=0.5",
    "contact.rotation=true", "contact.rolling={friction: 0.1}",
)  # fmt: skip
SIGN = (
    "run.duration=0.0935", "run.output_interval=0.0935", "contact.friction_law=sign", "contact.friction=0.05",
)  # fmt: skip
CHANNEL = ("run.duration=0.06", "run.output_interval=0.06", "contact.rolling={friction: 0.1}", "engine.name=lammps")


@pytest.fixture(autouse=True)
def mpiexec():
    if program("mpiexec") is None:
        pytest.skip("the mpich wheel brings no mpiexec")


LONG = pytest.mark.long
SIGNALLED = [
    pytest.param(1, signal.SIGINT, marks=LONG),
    pytest.param(1, signal.SIGTERM, marks=LONG),
    pytest.param(2, signal.SIGTERM, marks=LONG),
]


def run(name, folder, plugin, ranks, *changes, **options):
    scene = load_case(INPUTS / f"{name}.yaml", list(changes)).scene()
    setting = Setting(kernel="compiled", ranks=ranks, dump_format="binary", plugin=plugin, **options)
    return scene, run_scene(scene, folder, setting)


def frames(folder):
    return [frame.sorted() for frame in open_dump(folder / "dump.lammpsbin")]


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("dam_break", SIGN),  # of all ranks: the largest speed
        pytest.param("quick_jump", MANY, marks=pytest.mark.long),
        pytest.param("dam_break", SPRINGS, marks=pytest.mark.long),
        pytest.param("inclined_flow", CHANNEL, marks=pytest.mark.long),
    ],
)
def test_a_thousand_steps_are_those_of_one_rank(plugin, tmp_path, name, changes):
    last = {}
    for ranks in (1, 2):
        scene, result = run(name, tmp_path / str(ranks), plugin, ranks, *changes)
        assert result.status == "complete" and result.steps == scene.steps >= 1000
        last[ranks] = frames(tmp_path / str(ranks))[-1]
    one, two = last[1], last[2]
    assert np.array_equal(one.ids, two.ids) and len(one.ids) > 400
    # sums in another order, amplified by the collisions of a thousand steps
    assert max(np.abs(one.x - two.x).max(), np.abs(one.y - two.y).max()) < 1e-9 * scene.diameter


@pytest.mark.long
def test_discs_balance_while_they_come_go_and_change_ranks(plugin, tmp_path):
    changes = ("run.duration=4", "initial=[]", "domain.x=[-1, 16]", "walls.floor.x=[-5, 9]", "walls.sill.x=[8, 9]")
    _, result = run("quick_jump", tmp_path, plugin, 2, *changes, "outflow=[{x_beyond: 13}, {y_below: -3}]")
    assert result.status == "complete", result.message
    assert result.removed > 20 and result.lost == 0
    assert result.inserted == result.present + result.removed
    assert (tmp_path / "forces.csv").read_text().count("sill") > 100
    script = (tmp_path / "in.plugin.lammps").read_text()
    assert "processors      * 1 1" in script and "shift x" in script


@pytest.mark.long
def test_stock_discs_of_several_sizes_stay_in_the_plane(tmp_path):
    """Sharing the discs anew moved them by 1e-17 m in z, which ended the run."""
    scene = load_case(INPUTS / "quick_jump.yaml", ["run.duration=0.16"]).scene()
    result = run_scene(scene, tmp_path, Setting(ranks=2))
    assert result.status == "complete", result.message
    assert result.steps == scene.steps > 900 and result.present > 30


@pytest.mark.long
def test_a_stopped_run_on_two_ranks_keeps_its_frames(plugin, tmp_path):
    scene, result = run("energy_box_16", tmp_path, plugin, 2, stop_at=2000)
    assert result.status == "interrupted" and "kept" in result.message
    assert 2000 <= result.steps < scene.steps
    assert result.present == 16 and result.lost == 0
    assert frames(tmp_path)


@pytest.mark.parametrize(("ranks", "number"), SIGNALLED)
def test_a_signal_ends_a_run_and_leaves_no_rank(plugin, tmp_path, ranks, number):
    """Ctrl-C, and SIGTERM of a batch system whose time is up: status 75, what there is is kept, nothing runs on."""
    options = ["--kernel", "compiled", "--ranks", ranks, "--set", "run.duration=20000", "--quiet"]
    status, output = run_program(
        "build-and-run", INPUTS / "energy_box_16.yaml", "--out", tmp_path, *options, signal_at=(number, 1000)
    )
    assert status == 75
    assert "the run was ended at t =" in output and "kept" in output
    assert read_log(tmp_path / "log.lammps").step >= 1000
    assert not running_in(tmp_path)
    assert not [name for name in os.listdir(tmp_path) if name.endswith(".raw")]


def running_in(folder) -> list[str]:
    """Processes whose working folder this is: ranks run there."""
    places = {path.parent.name: path for path in Path("/proc").glob("[0-9]*/cwd")}
    found = []
    for number, place in places.items():
        try:
            if place.readlink() == folder:
                found.append(number)
        except OSError:  # it has ended, or is not ours to look at
            continue
    return found
