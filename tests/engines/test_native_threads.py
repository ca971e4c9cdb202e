# SPDX-License-Identifier: GPL-2.0-or-later
"""Threads of the native engine: how many there are changes no bit of any array, nor of the ledger."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from laws import LAWS
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.engines.native.bound import Core
from lammps_jump.scene import Block, Box, Motion, MovingWall, handmade_scene
from lammps_jump.scene.scene import Fixed, Stations
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.tracks import Loaded, Oscillate

STEPS = 60
SCENES = {
    "quick_jump": {},  # inlets, outlets, sizes
    "inclined_flow": {},  # periodic, a rough bed
    "drum": {},  # an arc that turns
    "column_collapse": {"initial.0.settle": 0.0},  # springs, spin, a gate
    "hydraulic_jump": {"run.integrator": "leapfrog_extrapolated"},
}


def box(law, *, sized):
    """Discs in a box with an arm that swings and a lid that they push, some of them fixed; several blocks of discs."""
    rng = np.random.default_rng(7)
    grid = np.array([(0.19 * i, 0.19 * j) for i in range(30) for j in range(17)])
    places = grid + rng.normal(0.0, 0.005, grid.shape)
    others = {"sizes": Sizes((1.0,), (0.17,), (0.21,), seed=3)} if sized else {}
    scene = handmade_scene(
        places, rng.normal(0.0, 1.0, places.shape), diameter=0.19, impact_speed=8.0, overlap_limit=0.0,
        fixed=Fixed(1, 40), stations=Stations((1.0, 4.0), 1.0, 0, STEPS - 5), **others, **law,
    )  # fmt: skip
    walls = (
        (Box("box", (-0.1, 5.7), (-0.1, 4.0)), None),
        (Block("arm", (2.0, 2.4), (-1.0, -0.05)), Oscillate(amplitude=(0.1, 0.05), period=0.1)),
        (Block("lid", (0.0, 5.6), (3.15, 3.4)), Loaded(mass=20.0, force=(0.0, -200.0))),
    )
    motion = partial(Motion, about=(0.0, 0.0), time_step=scene.time_step)
    return replace(scene, walls=tuple(MovingWall(wall, motion(kind=kind)) for wall, kind in walls))


def bits(simulation):
    """Hash of every array of the discs, of lists and walls, of the ledger and of the sums between stations."""
    found, d = hashlib.sha256(), simulation.discs
    for name in d.columns:
        found.update(getattr(d, name)[: d.n].tobytes())
    found.update(simulation.walls.sums.tobytes())
    if simulation.walls.moves is not None:
        found.update(simulation.walls.moves.pushed.tobytes())
    found.update(np.array(list(simulation.ledger.values())).tobytes())
    found.update(simulation.stations.sums.tobytes())
    return found.hexdigest()


def after(scene, threads, steps):
    simulation = NativeSimulation(scene, loops=Core(threads))
    simulation.run(steps)
    return simulation


def same_bits(scene, numbers=("2", "3"), steps=STEPS):
    alone = bits(after(scene, "1", steps))
    for threads in numbers:
        simulation = after(scene, threads, steps)
        assert simulation.loops.threads == int(threads)
        assert bits(simulation) == alone, f"{threads} threads"


@pytest.mark.parametrize("law", LAWS)
def test_threads_change_no_bit(law):
    same_bits(box(LAWS[law], sized=law in ("viscous, spin", "rolling", "smooth")))


@pytest.mark.parametrize("name", ["quick_jump", *(pytest.param(n, marks=pytest.mark.long) for n in [*SCENES][1:])])
def test_threads_change_no_bit_of_a_scene(name):
    scene = lj.load_case(INPUTS / f"{name}.yaml", {"engine.name": "native", **SCENES[name]}).scene()
    same_bits(scene, steps=300)


def test_a_run_goes_on_with_another_number_of_threads(tmp_path):
    """Stopped with one thread and continued with two: the files of a run without a stop, to the last byte."""
    scene = replace(box(LAWS["rolling"], sized=True), steps=STEPS, output_steps=STEPS // 3)
    found = []
    for first, second in (("1", "1"), ("1", "2"), ("3", "1")):
        folder = tmp_path / f"{first}-{second}"
        assert run_native(scene, folder, threads=first, stop_at=STEPS // 2).status == "interrupted"
        result = run_native(scene, folder, threads=second, resume=read_checkpoint(folder))
        assert result.status == "complete" and result.resumed
        left = (path for path in folder.iterdir() if not path.name.startswith("checkpoint"))
        found.append({path.name: path.read_bytes() for path in left})
    whole = tmp_path / "whole"
    run_native(scene, whole, threads="2")
    assert found[0] == found[1] == found[2] == {name: (whole / name).read_bytes() for name in found[0]}
    assert "dump.lammpstrj" in found[0] and "end.npz" in found[0]


def test_newcomers_and_images_are_added_in_the_order_of_the_list():
    """Rows behind the sorted ones, as of discs that came since the list was made: each sum as of one thread."""
    scene = box(LAWS["viscous, spin"], sized=False)
    found = []
    for threads in ("1", "2", "3"):
        simulation = after(scene, threads, 10)
        discs = simulation.discs
        start, pairs = discs.start, discs.neighbours
        late = [row for row in range(300, 500) if start[row + 1] > start[row]][::7]  # as if listed one by one
        assert discs.sorted_rows == discs.n
        discs.sorted_rows = late[0]
        discs.listed_as += 10**6
        assert (pairs[start[late[0]] : start[late[0] + 1]] > late[0]).all()
        simulation.run(1)
        found.append(bits(simulation))
    assert found[0] == found[1] == found[2]
