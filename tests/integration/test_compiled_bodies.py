# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies with the plugin's fix, against the native engine; on several ranks, and stopped and gone on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from free_bodies import crowd, scene_of

from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import read_bodies
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.launch import run
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.engines.setting import Setting
from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Sizes

D, STEPS = 0.2, 1000
SPRINGS = Springs(2 / 7, 1.0, Rolling(0.1, 0.3, 1.0))
LAWS = {
    "history": {"friction": 0.4, "friction_law": "history", "rotation": True, "springs": SPRINGS},
    "frictionless": {"friction": 0.0},
    "viscous": {"friction": 0.3, "rotation": True},
    "sign": {"friction": 0.3, "friction_law": "sign"},
    "smooth": {"friction": 0.3, "touch": "smooth", "touch_width": 1e-3},
    "sizes": {"friction": 0.3, "sizes": Sizes((1.0,), (0.16,), (0.24,), 1)},
}
LONG = [pytest.param(name, marks=pytest.mark.long) for name in LAWS if name != "history"]

pytestmark = pytest.mark.lammps


def scene(**law):
    """Bodies of every shape among walls of every kind, on and under discs that fall and lie."""
    rows = (np.arange(0.1, 1.0, 0.25), 0.95), (np.arange(1.3, 2.2, 0.25), 1.6), (np.arange(2.5, 3.5, 0.25), 1.8)
    places = np.array([*((x, y) for xs, y in rows for x in xs), (4.07, 1.2), (4.07, 1.5)])
    speeds = np.random.default_rng(3).normal([0.0, -5.0], 1.0, places.shape)
    fields = {
        "skin": 0.06,
        "domain": ((-5.0, 8.0), (-2.0, 6.0)),
        "steps": STEPS,
        "output_steps": 100,
        "probe_steps": 50,
    }
    return scene_of(
        *crowd(begin=0.01), positions=places, velocities=speeds, restitution=0.4, probes=("floor", "a"),
        **(fields | {"time_step_fraction": 0.1, "correct_restitution": True, "overlap_limit": 0.06} | law),
    )  # fmt: skip


def compiled(plugin, ranks: int = 1, **setting) -> Setting:
    return Setting(kernel="compiled", plugin=plugin, ranks=ranks, **setting)


def same(folder, other, digits: float):
    """Bodies and discs of two runs agree."""
    one, two = (read_bodies(place / "bodies.csv") for place in (folder, other))
    assert one.keys() == two.keys() and len(one["a"].time) == STEPS // 50 + 1
    for name, found in one.items():
        for column, own, theirs in zip(found._fields, found, two[name], strict=True):
            scale = {"fx": 1e7, "fy": 1e7, "moment": 1e7, "spin": 1e3, "vx": 1e3, "vy": 1e3}.get(column, 1.0)
            assert own == pytest.approx(theirs, abs=digits * scale), (name, column)
    a, b = ([frame for frame in open_dump(place / "dump.lammpstrj")] for place in (folder, other))
    assert len(a) == len(b) == STEPS // 100 + 1
    for mine, theirs in zip(a, b, strict=True):
        assert np.asarray(mine.x) == pytest.approx(np.asarray(theirs.x), abs=max(digits, 1e-9))


@pytest.mark.parametrize("law", ["history", *LONG])
def test_native_and_plugin_agree(law, plugin, tmp_path):
    found = scene(**LAWS[law])
    assert run_native(found, tmp_path / "native").status == "complete"
    result = run(found, tmp_path / "compiled", compiled(plugin))
    assert result.status == "complete", result.message
    same(tmp_path / "compiled", tmp_path / "native", 1e-9 * D)
    moved = read_bodies(tmp_path / "native" / "bodies.csv")
    assert all(np.ptp(one.angle) + np.ptp(one.x) > 0.02 for one in moved.values())
    texts = [(tmp_path / name / "walls.csv").read_text().splitlines() for name in ("native", "compiled")]
    assert [line.split(",")[1] for line in texts[0]] == [line.split(",")[1] for line in texts[1]]
    rows = [np.array([line.split(",")[2:] for line in text[1:]], float) for text in texts]
    assert len(rows[0]) == 5 * (STEPS // 100 + 1) and rows[0] == pytest.approx(rows[1], abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("law", ["history", "sizes"])
def test_ranks_agree_and_a_stopped_run_goes_on(law, plugin, tmp_path):
    found = scene(**LAWS[law])
    one = run(found, tmp_path / "one", compiled(plugin))
    assert one.status == "complete", one.message
    two = run(found, tmp_path / "two", compiled(plugin, 2))
    assert two.status == "complete", two.message
    same(tmp_path / "two", tmp_path / "one", 1e-9 * D)
    stopped = run(found, tmp_path / "part", compiled(plugin, stop_at=STEPS // 2))
    assert stopped.status == "interrupted", stopped.message
    again = run(found, tmp_path / "part", compiled(plugin), resume=read_checkpoint(tmp_path / "part"))
    assert again.status == "complete", again.message
    same(tmp_path / "part", tmp_path / "one", 1e-9 * D)


@pytest.mark.long
def test_a_body_that_leaves_the_domain_ends_the_run(plugin, tmp_path):
    gone = replace(scene(), domain=((-5.0, 8.0), (0.35, 6.0)), walls=scene().walls[1:2] + scene().walls[5:6])
    result = run(replace(gone, probes=()), tmp_path / "run", compiled(plugin))
    assert result.status == "failed" and "body 'a' has left the domain" in result.message
    simulation = NativeSimulation(replace(gone, probes=()))
    with pytest.raises(Exception, match="body 'a' has left the domain"):
        simulation.run(STEPS)
