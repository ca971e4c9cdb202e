# SPDX-License-Identifier: GPL-2.0-or-later
"""Every feature on every engine: a run that is ended twice and goes on is the run without an end.

Each pair of a feature and an engine is a cell of the table in docs/reliability.md, which ``make faults`` writes.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from fault_table import NONE
from features import ENGINES, FEATURES
from made_up import engine_setting, scene_of_feature

from lammps_jump.dump.find import read_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.lammps.loader import program
from lammps_jump.engines.launch import run
from lammps_jump.files import CONTACTS_FILE, POSES

pytestmark = [pytest.mark.lammps, pytest.mark.fault("ended and continued")]
STOPS = 0.3, 0.7
"""Where a run is ended, as shares of its steps."""
NEAR = 1e-9
"""Largest difference of a place in diameters: round-off that collisions amplify, to 1e-11 when measured."""
CHEAP = {
    ("friction `sign`", "compiled"), ("a rough bed, `history`", "compiled"), ("a lid, `history`", "compiled"),
    ("a rough bed beside a belt, `history`", "stock"), ("a pour of several sizes", "stock"),
    ("friction `history`", "native"),
}  # fmt: skip
"""Those that the default run tries: each engine, and what once went wrong."""
PAIRS = [
    pytest.param(
        feature, engine, id=f"{feature}-{engine}", marks=[] if (feature, engine) in CHEAP else pytest.mark.long
    )
    for feature in FEATURES
    for engine in ENGINES
]


def frames(folder):
    return [frame.sorted() for frame in open_dump(next(folder.glob("dump.*")))]


@pytest.mark.parametrize(("feature", "engine"), PAIRS)
def test_a_run_that_is_ended_twice_is_the_run_without_an_end(feature, engine, tmp_path, tried, record_property):
    scene = scene_of_feature(feature, engine)
    if scene is None:
        tried(0)
        record_property("cell", (feature, engine, NONE))
        return
    setting, whole, parts = engine_setting(engine, checkpoint_interval=inf), tmp_path / "whole", tmp_path / "parts"
    assert run(scene, whole, setting).status == "complete"
    first, *others = [*(round(share * scene.steps) for share in STOPS), None]
    assert run(scene, parts, replace(setting, stop_at=first)).status == "interrupted"
    joined = read_checkpoint(parts).step
    for stop in others:
        last = run(scene, parts, replace(setting, stop_at=stop), resume=read_checkpoint(parts))
    assert last.status == "complete" and last.lost == 0 and len(last.resumed) == len(STOPS)
    if engine == "native":
        for file in whole.iterdir():
            assert file.read_bytes() == (parts / file.name).read_bytes(), file.name
    found = "0, then at other places" if scene.pours and engine != "native" else None
    one, two = frames(whole), frames(parts)
    if found:  # LAMMPS' fix pour keeps no state: its clock goes on, its places are new
        (turns,) = map(scene.pour_turns, scene.pours)
        turn = next(turn for turn in turns if turn > joined)
        for place in (one, two):
            number = {frame.step: frame.ids.max(initial=0) for frame in place}
            begun = [step for step in number if joined < step < turn], [step for step in number if step >= turn]
            assert number[begun[0][-1]] == number[max(step for step in number if step <= joined)] < number[begun[1][0]]
        one, two = ([frame for frame in place if frame.step < turn] for place in (one, two))
    assert [frame.step for frame in one] == [frame.step for frame in two] and one[-1].step > joined
    apart = 0.0
    for before, after in zip(one, two, strict=True):
        assert np.array_equal(before.ids, after.ids)
        way = np.hypot(before.x - after.x, before.y - after.y).max(initial=0.0) / scene.diameter
        apart = max(apart, float(way))
    assert apart < NEAR
    if not found:
        compare_beside(scene, whole, parts)
    record_property("cell", (feature, engine, found or (f"{apart:.0e}" if apart else "0")))


@pytest.mark.long
@pytest.mark.parametrize(("before", "after"), [(1, 2), (2, 1)])
def test_springs_go_on_on_another_number_of_ranks(before, after, tmp_path):
    """On one rank the disc with the larger id remembers a contact, on several both do."""
    if program("mpiexec") is None:
        pytest.skip("the mpich wheel brings no mpiexec")
    scene = scene_of_feature("a rough bed, `history`", "compiled")
    setting, parts = engine_setting("compiled", checkpoint_interval=inf), tmp_path / "parts"
    assert run(scene, tmp_path / "whole", setting).status == "complete"
    run(scene, parts, replace(setting, ranks=before, stop_at=scene.steps // 3))
    assert run(scene, parts, replace(setting, ranks=after), resume=read_checkpoint(parts)).status == "complete"
    for one, two in zip(frames(tmp_path / "whole"), frames(parts), strict=True):
        assert np.hypot(one.x - two.x, one.y - two.y).max() < NEAR * scene.diameter


def compare_beside(scene, whole, parts) -> None:
    """Forces on walls, places of lids and contacts have the same rows, and the same numbers but for round-off."""
    force = scene.coefficients.stiffness * NEAR * scene.diameter
    if scene.probes:
        one, two = (read_forces(place / "forces.csv") for place in (whole, parts))
        for wall, history in one.items():
            assert history.time == pytest.approx(two[wall].time, abs=1e-12)
            for column in ("fx", "fy"):
                assert np.abs(getattr(history, column) - getattr(two[wall], column)).max() < force
    if scene.lids:
        one, two = (PoseFile(place / POSES, scene.lids) for place in (whole, parts))
        for frame in frames(whole):
            for name, pose in one.at(frame.time).items():
                assert pose == pytest.approx(two.at(frame.time)[name], abs=NEAR * scene.diameter)
    if (whole / CONTACTS_FILE).exists():  # stock styles write none
        assert (whole / CONTACTS_FILE).stat().st_size == (parts / CONTACTS_FILE).stat().st_size
