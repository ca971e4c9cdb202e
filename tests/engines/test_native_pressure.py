# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces on stretches of outlines: they sum to the force on the wall, on the core and on the twin, for any threads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laws import LAWS

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.engines.twin import Twin
from lammps_jump.scene import Block, Box, Motion, MovingWall, Plane, handmade_scene
from lammps_jump.scene.pressed import bins_of, foot_of, gauge_of, runs_of
from lammps_jump.scene.tracks import Loaded, Oscillate
from lammps_jump.scene.walls import Circle, Polygon

WINDOW, STEPS = 7, 24


def scene_of(law, *, sized=False, many=1):
    """Discs in a box with an arm that swings and a lid that they push; bins of all three, and a gauge of the box."""
    rng = np.random.default_rng(5)
    grid = np.array([(0.19 * i, 0.19 * j) for i in range(-2, 3) for j in range(-1, 1 + many)])
    places = grid + rng.normal(0.0, 0.005, grid.shape)
    scene = handmade_scene(
        places, rng.normal(0.0, 1.0, places.shape), diameter=0.19, impact_speed=8.0, overlap_limit=0.0,
        probes=("box", "arm", "lid"), probe_steps=WINDOW, steps=STEPS, **LAWS[law],
    )  # fmt: skip
    box = Box("box", (-0.47, 0.47), (-0.28, 0.19 * many + 0.28))
    walls = (
        (box, None),
        (Block("arm", (-0.3, 0.2), (-0.8, -0.27)), Oscillate(amplitude=(0.1, 0.05), period=0.1)),
        (Block("lid", (-0.46, 0.46), (0.19 * many + 0.08, 2.0)), Loaded(mass=20.0, force=(0.0, -200.0))),
    )
    motion = lambda kind: Motion(kind=kind, about=(0.0, 0.0), time_step=scene.time_step)  # noqa: E731
    stretches = [one for wall, _ in walls for one in bins_of(wall, 9)]
    stretches.insert(12, gauge_of(box, (-0.47, 0.0), 0.2))
    stretches.sort(key=lambda one: ("box", "arm", "lid").index(one.wall))
    return replace(
        scene, walls=tuple(MovingWall(wall, motion(kind)) for wall, kind in walls), pressure=tuple(stretches)
    )


def run(scene, loops, steps=STEPS):
    simulation = NativeSimulation(scene, loops=loops)
    simulation.run(steps)
    return simulation


def bins(scene, name):
    return [k for k, one in enumerate(scene.pressure) if one.wall == name and not one.gauge]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("loops", [Core, Twin])
def test_bins_sum_to_the_force_of_their_wall(law, loops):
    scene = scene_of(law)
    found = run(scene, loops())
    rows = dict(found.windows.pressed)
    assert sorted(rows) == [7, 14, 21]
    touched = 0
    for step, name, fx, fy, *_ in found.windows.forces:
        if name == "lid" or name == "arm":  # they turn and move: only their sizes are compared
            continue
        parts = rows[step].reshape(-1, 3)[bins(scene, name)]
        along = np.array([scene.pressure[k].along for k in bins(scene, name)])
        normal = np.column_stack([-along[:, 1], along[:, 0]])  # to the discs
        force = -(parts[:, :1] * normal) + parts[:, 1:2] * along
        assert force.sum(axis=0) == pytest.approx([fx, fy], rel=1e-9, abs=1e-9)
        touched += np.count_nonzero(parts[:, 0])
    assert touched > 5
    gauge = next(k for k, one in enumerate(scene.pressure) if one.gauge)
    assert scene.pressure[gauge].wall == "box" and scene.pressure[gauge].place == pytest.approx((-0.47, 0.0))


@pytest.mark.parametrize("law", LAWS)
def test_core_and_twin_find_the_same(law):
    scene = scene_of(law)
    core, twin = (np.array([row for _, row in run(scene, one()).windows.pressed]) for one in (Core, Twin))
    assert core == pytest.approx(twin, rel=1e-9, abs=1e-9 * np.abs(core).max())
    assert np.abs(core).max() > 0 and np.count_nonzero(core.reshape(3, -1, 3)[0, bins(scene, "arm")]) > 0


def test_the_number_of_threads_changes_no_bit():
    scene = scene_of("springs" if "springs" in LAWS else next(iter(LAWS)), many=400)
    one, three = (run(scene, Core(threads)).windows.pressed for threads in ("1", "3"))
    assert all(a[0] == b[0] and a[1].tobytes() == b[1].tobytes() for a, b in zip(one, three, strict=True))


def test_pressure_changes_no_bit_of_the_discs():
    scene = scene_of(next(iter(LAWS)))
    with_it, without = run(scene, Core()), run(replace(scene, pressure=()), Core())
    for name in with_it.discs.columns:
        assert np.array_equal(getattr(with_it.discs, name), getattr(without.discs, name), equal_nan=True)
    assert with_it.windows.forces == without.windows.forces


def test_a_run_that_goes_on_has_the_same_windows(tmp_path):
    """It is saved within a window: what that has summed goes on."""
    scene = scene_of(next(iter(LAWS)))
    whole, part = run(scene, Core()), run(scene, Core(), 10)
    save_state(part, tmp_path / "state.npz")
    again = load_state(scene, tmp_path / "state.npz", loops=Core())
    again.run(STEPS - 10)
    assert [step for step, _ in again.windows.pressed] == [7, 14, 21]
    for one, other in zip(whole.windows.pressed, again.windows.pressed, strict=True):
        assert one[1].tobytes() == other[1].tobytes()


def test_bins_go_over_no_corner_and_cover_the_outline():
    """Of a block of 2 m x 0.5 m ten bins of 0.5 m; of a circle one run; of a wall of short pieces their smooth runs."""
    block = bins_of(Block("sill", (3.0, 5.0), (0.0, 0.5)), 10)
    assert len(block) == 10 and all(one.width == pytest.approx(0.5) for one in block)
    assert sum(one.width for one in bins_of(Circle("pier", (0.0, 0.0), 1.0), 7)) == pytest.approx(2 * np.pi)
    places = np.array([one.place for one in bins_of(Circle("pier", (1.0, 2.0), 1.0), 7)])
    assert np.hypot(*(places - [1.0, 2.0]).T) == pytest.approx(1.0)
    slim = bins_of(Polygon("wedge", ((0.0, 0.0), (6.0, 0.0), (0.0, 0.1))), 4)
    assert {round(one.along[0], 3) for one in slim} >= {-1.0, 0.0, 1.0} and len(slim) >= 4


@pytest.mark.parametrize(("side", "sign"), [("above", -1.0), ("below", 1.0)])
def test_an_endless_plane_has_bins_where_it_is_looked_at(side, sign):
    wall = Plane("back", "x", 2.0, side)
    found = bins_of(wall, 4, (-3.0, 0.0) if sign < 0 else (0.0, 3.0))
    assert sorted(one.place[1] for one in found) == pytest.approx([0.375, 1.125, 1.875, 2.625])
    gauge = gauge_of(wall, (2.3, 1.0), 0.4, (-3.0, 0.0) if sign < 0 else (0.0, 3.0))
    assert gauge.place == pytest.approx((2.0, 1.0)) and gauge.width == pytest.approx(0.4)
    assert gauge.along == pytest.approx((0.0, sign))


def test_a_gauge_ends_at_a_corner():
    wall = Block("sill", (3.0, 5.0), (0.0, 0.5))
    gauge = gauge_of(wall, (2.9, 0.45), 0.3)
    assert gauge.place == pytest.approx((3.0, 0.4)) and gauge.width == pytest.approx(0.2)
    assert foot_of(wall.faces, (2.9, 0.45))[0] == pytest.approx(0.45) and len(runs_of(wall)) == 4
