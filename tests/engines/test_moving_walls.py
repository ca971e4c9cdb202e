# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that move, on the native engine (docs/theory.md): frames, work, lids, resume."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pytest

from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.scene import Block, Box, Motion, MovingWall, handmade_scene
from lammps_jump.scene.motion import gate
from lammps_jump.scene.tracks import (
    Loaded,
    Oscillate,
    Rotate,
    TableMotion,
    Translate,
    VelocityChange,
    pose_py,
    track_of,
)

BLOCK = Block("block", (-1.5, 1.5), (-0.2, 0.3))
BOX = Box("box", (-2.0, 2.0), (-1.0, 2.0))
PLACES = np.array([[x, y] for x in np.arange(-1, 1.1, 0.25) for y in (0.6, 0.85, 1.1)])
PLACES = PLACES + np.random.default_rng(1).normal(0, 0.01, PLACES.shape)

UP = np.array([0.0, 2.0])


def scene_of(*walls, velocity=(0.0, 0.0), positions=PLACES, **others):
    """Discs above a block, or in a box; `walls` are (wall, kind of motion or None, point of turning)."""
    settings = {
        "friction": 0.3,
        "rotation": True,
        "impact_speed": 8.0,
        "probes": (walls[0][0].name,),
        "probe_steps": 50,
    }
    found = handmade_scene(positions, 0 * positions + velocity, (), **(settings | others))
    moving = (
        MovingWall(wall, Motion(kind=kind, about=about, time_step=found.time_step)) for wall, kind, about in walls
    )
    return replace(found, walls=tuple(moving))


def run(scene, steps=1500):
    simulation = NativeSimulation(scene)
    simulation.run(steps)
    return simulation


def test_a_moving_frame_shows_the_same():
    """Galilei: 5e-14 d were measured over 1,000 steps; positions of a few metres have round-off of 1e-15 d a step."""
    velocity = (3.0, -1.0)
    still = run(scene_of((BLOCK, None, (0.0, 0.0))))
    moving = scene_of((BLOCK, Translate(velocity=velocity, begin=-1.0), (0.0, 0.0)), velocity=velocity)
    motion = moving.walls[0].motion
    moving = run(replace(moving, positions=PLACES + motion.pose(0)[:2]))
    assert np.abs(moving.positions - motion.pose(1500)[:2] - still.positions).max() < 1e-11 * 0.2
    assert np.abs(moving.spin - still.spin).max() < 1e-8
    assert moving.forces[-1][2:4] == pytest.approx(still.forces[-1][2:4], rel=1e-8)
    assert still.forces[-1][3] < -1000.0


def test_a_turned_block_is_a_turned_gravity():
    angle = radians(20.0)
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    level = run(scene_of((BLOCK, None, (0.0, 0.0)), gravity=tuple(turn.T @ (0.0, -9.81))))
    kind = Rotate(rate=20.0, begin=-2.0, until=-1.0)
    turned = run(scene_of((BLOCK, kind, (0.0, 0.0)), positions=PLACES @ turn.T))
    assert np.abs(turned.positions @ turn - level.positions).max() < 1e-11 * 0.2


@pytest.mark.parametrize(
    "kind",
    [
        Oscillate(amplitude=(0.3, 0.1), period=1.3),
        Oscillate(amplitude=(0.3, 0.1), angle=15.0, period=(1.3, 0.7, 2.0), phase=(0.0, 50.0, 90.0)),
        Rotate(rate=90.0, ease=0.1),
        TableMotion(points=((0.5, 0.4, 0.0, 0.0), (1.0, 0.0, 0.3, 30.0)), ease=0.1),
    ],
    ids=lambda kind: kind.kind,
)
def test_the_work_of_a_shaken_box_closes_the_ledger(kind):
    """What is left falls with the square of the step: 1e-3 of the throughput at f = 0.05, 5e-5 at 0.01 (measured)."""
    left = {}
    for fraction in (0.05, 0.01):
        scene = scene_of((BOX, kind, (0.0, 0.5)), restitution=0.5, largest_overlap=0.05, time_step_fraction=fraction)
        simulation = NativeSimulation(scene)
        worst = 0.0
        for _ in range(10):
            simulation.run(int(0.12 / scene.time_step))
            found = simulation.ledger
            worst = max(worst, abs(found["residual"]) / found["throughput"])
        left[fraction] = worst
        assert abs(found["work_of_walls"]) > 0.01 * found["throughput"]
    assert left[0.05] < 5e-3
    assert left[0.01] < 2e-4


def test_a_lid_rests_on_its_discs():
    """The floor carries weights and load; all energies stand in the ledger."""
    lid, load = Block("lid", (-2.5, 2.5), (1.5, 1.8)), Loaded(mass=2000.0, force=(0.0, -20000.0))
    box = Box("box", (-2.0, 2.0), (-1.0, 5.0))
    scene = scene_of(
        (box, None, (0, 0)), (lid, load, (0, 0)), restitution=0.4, friction=0.0, rotation=False, probe_steps=2000
    )
    simulation = run(scene, 20000)
    (_, _, _, fy, _, power) = simulation.forces[-1]
    weights = scene.mass * len(PLACES) * 9.81
    assert fy == pytest.approx(-(weights + 20000.0), rel=1e-3)  # it still swings by some 1e-4
    assert abs(power) < 1e-3 * 20000.0  # it moves by less than 1 mm/s
    found = simulation.ledger
    assert abs(found["residual"]) < 5e-3 * found["throughput"]  # the error of the step of all springs
    assert simulation.walls.poses()["lid"].y < -1.0


def test_a_saved_moving_wall_goes_on_bit_for_bit(tmp_path):
    lid = Block("lid", (-2.5, 2.5), (1.5, 1.8)), Loaded(mass=500.0, force=(0.0, -20000.0)), (0.0, 0.0)
    scene = scene_of((BOX, Oscillate(amplitude=(0.3, 0.0), period=0.5), (0.0, 0.0)), lid)
    whole, first = run(scene, 900), run(scene, 433)
    save_state(first, tmp_path / "state.npz")
    second = load_state(scene, tmp_path / "state.npz")
    second.run(900 - 433)
    assert np.array_equal(second.positions, whole.positions)
    assert second.ledger == whole.ledger
    assert second.walls.poses() == whole.walls.poses()
    assert second.forces == whole.forces


def test_power_is_force_times_speed():
    velocity = (0.0, 2.0)
    simulation = run(scene_of((BLOCK, Translate(velocity=velocity, begin=-1.0), (0.0, 0.0)), positions=PLACES + UP))
    pushed = [row for row in simulation.forces if row[3]]
    assert pushed
    for _, _, _, fy, _, power in pushed:
        assert power == pytest.approx(-2.0 * fy, rel=1e-9)


def test_a_sine_begins_where_the_case_has_the_wall():
    motion = Motion(kind=Oscillate(amplitude=(0.5, 0.0), period=2.0, phase=30.0, begin=1.0, until=3.3), time_step=1e-3)
    exact = 0.5 * (sin(2 * pi * 0.7 / 2.0 + radians(30.0)) - sin(radians(30.0)))
    assert motion.pose(500) == (0.0, 0.0, 0.0)
    assert motion.pose(1700).x == pytest.approx(exact, abs=1e-12)
    assert motion.pose(3300) == motion.pose(9000)


def test_components_of_a_sine_have_periods_and_phases_of_their_own():
    kind = Oscillate(amplitude=(0.5, 0.2), angle=30.0, period=(2.0, 0.7, 3.0), phase=(30.0, 0.0, -90.0), begin=1.0)
    now, motion = 0.7, Motion(kind=kind, time_step=1e-3)
    parts = ((0.5, 2.0, 30.0), (0.2, 0.7, 0.0), (radians(30.0), 3.0, -90.0))
    exact = [a * (sin(2 * pi * now / period + radians(p)) - sin(radians(p))) for a, period, p in parts]
    assert motion.pose(1700) == pytest.approx(exact, abs=1e-12)


def test_ease_spreads_a_start_and_reaches_the_end():
    motion = Motion(kind=Translate(velocity=(2.0, 0.0), begin=0.5, until=1.5), ease=0.2, time_step=1e-3)
    speeds = np.diff([motion.pose(step).x for step in range(2001)]) / 1e-3
    assert motion.pose(2000).x == pytest.approx(2.0, abs=1e-12)
    assert speeds.max() == pytest.approx(2.0, rel=1e-9)
    # the ramp 3 u^2 - 2 u^3 rises by at most 1.5 dV a time of ease
    assert np.abs(np.diff(speeds)).max() <= 1.5 * 2.0 / 0.2 * 1e-3 * (1 + 1e-6)


def test_changes_of_velocity_that_follow_before_the_ease_is_over_add_up():
    both = [VelocityChange(0.0, (1.0, 0.0, 0.0), 1.0), VelocityChange(0.4, (0.0, -2.0, 0.5), 0.7)]
    track, alone = track_of(both, None), [track_of([one], None) for one in both]
    for time in np.linspace(-0.1, 1.5, 33):
        wanted = np.sum([pose_py(one, 0, len(one), time) for one in alone], axis=0)
        assert pose_py(track, 0, len(track), time) == pytest.approx(wanted, abs=1e-14)


def test_a_gate_is_gone_at_its_step():
    motion = gate(BLOCK, 7).motion
    assert motion.pose(6) is not None and motion.pose(7) is None
