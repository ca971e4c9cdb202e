# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that move or carry, against closed forms, on the native engine and the compiled styles."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, degrees, radians, sin

import numpy as np
import pytest
from single_disc import Drawn, one_disc

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import Block, Box, Chain, Motion, MovingWall, Plane, handmade_scene
from lammps_jump.scene.tracks import Loaded, Oscillate, Rotate, Translate

D = 0.2
PLACES = np.array([[x, y] for x in np.arange(-1, 1.1, 0.25) for y in (0.42, 0.67)])
PLACES = PLACES + np.random.default_rng(1).normal(0, 0.01, PLACES.shape)
FALLS = np.array([1.0, -2.0])


def discs_at(wall, positions=PLACES, velocity=FALLS, kind=None, **others):
    """Discs that fall on a wall, which may move."""
    settings = {"friction": 0.3, "rotation": True, "impact_speed": 8.0, "skin": 0.06, "domain": ((-9, 9), (-9, 9))}
    scene = handmade_scene(positions, np.tile(velocity, (len(positions), 1)), (wall,), **(settings | others))
    scene = replace(scene, steps=10**6, output_steps=10**6)
    if kind is None:
        return scene
    return replace(scene, walls=(MovingWall(wall, Motion(kind=kind, ease=0.0, time_step=scene.time_step)),))


FLOOR = Block("floor", (-1.5, 1.5), (-0.2, 0.3))


def test_a_moving_frame_shows_the_same(started):
    """Galilei."""
    velocity = np.array([3.0, -1.0])
    still_scene = discs_at(FLOOR)
    still = started(still_scene)
    still.run(600)
    scene = discs_at(FLOOR, kind=Translate(velocity=tuple(velocity), begin=-1.0))
    pose = scene.walls[0].motion.pose
    moving = started(replace(scene, positions=PLACES + pose(0)[:2], velocities=still_scene.velocities + velocity))
    moving.run(600)
    assert np.abs(moving.positions - pose(600)[:2] - still.positions).max() < 1e-11 * D
    assert np.abs(still.spin).max() > 1.0 and np.abs(moving.spin - still.spin).max() < 1e-8


def test_a_block_at_an_angle_is_a_tilted_gravity(started):
    angle = radians(-25.0)
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    level = started(discs_at(FLOOR, gravity=tuple(turn.T @ (0.0, -9.81))))
    tilted = started(discs_at(replace(FLOOR, angle=-25.0, pivot=(0.0, 0.0)), PLACES @ turn.T, turn @ FALLS))
    for engine in (level, tilted):
        engine.run(600)
    assert np.abs(tilted.positions @ turn - level.positions).max() < 1e-11 * D
    assert np.abs(level.positions - PLACES).max() > 0.2 * D


@pytest.mark.parametrize(
    ("wall", "points", "closed"),
    [
        (Plane("wall", "y", 0.3, "above"), ((-8.0, 0.3), (8.0, 0.3)), False),
        (Box("wall", (-1.2, 1.2), (0.3, 3.0)), ((-1.2, 0.3), (1.2, 0.3), (1.2, 3.0), (-1.2, 3.0)), True),
        (Block("wall", (-0.5, 1.5), (-0.2, 0.3)), ((-0.5, -0.2), (-0.5, 0.3), (1.5, 0.3), (1.5, -0.2)), True),
    ],
    ids=["plane", "box", "block"],
)
def test_a_plane_a_box_and_a_block_are_the_lines_that_draw_them(started, wall, points, closed):
    found = []
    for one in (wall, Drawn((Chain(points, closed=closed),))):
        engine = started(discs_at(one))
        engine.run(600)
        found.append(engine.positions)
    assert np.abs(found[0] - found[1]).max() < 1e-11 * D
    assert np.abs(found[0] - PLACES).max() > 0.1 * D


def test_a_paddle_that_turns_hits_with_the_speed_of_the_point_of_contact(started):
    """A disc at rest leaves at (1 + e) w L; the way of the paddle in a contact, 0.01 rad, and its step make 2 %."""
    restitution, rate, arm = 0.5, 0.5, 2.0
    paddle, turn = Block("paddle", (0.0, 3.0), (-0.2, 0.0)), Rotate(rate=degrees(rate), ease=0.0)
    floating = {"gravity": (0.0, 0.0), "restitution": restitution}
    scene = discs_at(paddle, np.array([[arm, 0.101]]), np.zeros(2), turn, **floating)
    engine = started(scene)
    engine.run(round(0.1 / scene.time_step))
    assert engine.velocities[0, 1] == pytest.approx((1 + restitution) * rate * arm, rel=0.02)
    assert abs(engine.velocities[0, 0]) < 0.02 * rate * arm


WINDOW = 20


def piston(velocity, fraction, kind):
    """One disc between a wall at 0 and a piston at 6 d, without gravity."""
    walls = (Plane("back", "x", 0.0, "above"), Plane("piston", "x", 6.0, "below"))
    scene = one_disc((3.0, 0.0), velocity, walls=walls, fraction=fraction, gravity=(0.0, 0.0))
    back, front = walls
    moving = MovingWall(front, Motion(kind=kind, time_step=scene.time_step))
    return replace(scene, walls=(MovingWall(back), moving), probes=("piston",), probe_steps=WINDOW)


@pytest.mark.parametrize(("fraction", "tolerance"), [(0.05, 1e-3), (0.01, 1e-4)])
def test_a_piston_adds_twice_its_speed_at_each_bounce(started, fraction, tolerance):
    """Fermi: speed v + 2 V j after j bounces, and the work of the piston is the change of energy.

    Measured: 3e-4 and 3e-5. It is the step of the spring: with other speeds and numbers of bounces up to 2.4e-3 and
    3e-5.
    """
    speed, push, bounces = 0.3, 0.05, 8
    scene = piston((speed, 0.0), fraction, Translate(velocity=(-push, 0.0), begin=-1e-9, ease=0.0))
    engine, work, new = started(scene), 0.0, speed
    while bounces or new < 0:  # it ends at the left wall
        old = new
        engine.run(WINDOW)
        work += engine.wall("piston")[3] * WINDOW * scene.time_step
        new = engine.velocities[0, 0]
        bounces -= old > 0 > new
    engine.run(round(0.4 / scene.time_step))  # the left wall is left behind
    new = engine.velocities[0, 0]
    assert new == pytest.approx(speed + 2 * push * 8, rel=tolerance)
    assert work == pytest.approx(0.5 * (new**2 - speed**2), rel=tolerance)


@pytest.mark.parametrize(
    ("fraction", "tolerance"), [(0.05, 4e-2), (0.01, 1.7e-4), pytest.param(0.002, 2e-5, marks=pytest.mark.long)]
)
def test_the_ledger_of_an_oscillating_piston_closes(fraction, tolerance):
    """Energy less work of the wall, with the centred velocity: what is left is the step of the spring.

    Measured: 8e-3, 7e-5 and 6e-6 of 0.5 m (speed of 1)^2; the velocity of the step before gives 1.5e-3 at f = 0.002.
    """
    scene = piston((1.0, 0.0), fraction, Oscillate(amplitude=(0.4, 0.0), period=7.0))
    simulation, worst = NativeSimulation(scene), 0.0
    start = simulation.energy().total
    for _ in range(100):
        simulation.run(round(1.0 / scene.time_step))
        left = simulation.energy().total - start - simulation.ledger["work_of_walls"]
        worst = max(worst, abs(left))
    assert abs(simulation.ledger["work_of_walls"]) > 0.5
    assert worst < tolerance


def test_a_floor_carries_weights_and_load(started):
    """A stack one disc wide comes to rest under a lid."""
    lid, load = Block("lid", (-0.5, 0.5), (0.9, 1.1)), Loaded(mass=100.0, force=(0.0, -2000.0))
    places = np.array([(0.0, 0.1), (0.0, 0.31), (0.0, 0.52), (0.0, 0.73)])
    scene = handmade_scene(
        places, 0 * places, (Plane("floor", "y", 0.0, "above"),), restitution=0.1, impact_speed=8.0, skin=0.06,
        domain=((-5, 5), (-5, 5)), probes=("floor",), probe_steps=500, steps=10**6, output_steps=10**6,
    )  # fmt: skip
    moving = MovingWall(lid, Motion(kind=load, time_step=scene.time_step))
    scene = replace(scene, walls=(*scene.walls, moving))
    engine = started(scene)
    engine.run(20_000)
    weights = scene.mass * len(places) * 9.81
    assert engine.wall("floor")[1] == pytest.approx(-(weights + 2000.0), rel=1e-6)


def test_a_gate_at_sixty_degrees_is_pushed_along_its_normal(started):
    """Without friction: F along -30 degrees, F sin 60 is what the left wall takes, floor and gate carry the weight."""
    a = radians(60.0)
    gate = Drawn((Chain(((1.0, 0.0), (1.0 + 3 * cos(a), 3 * sin(a)))),), name="gate")
    left, floor = Plane("left", "x", 0.0, "above"), Plane("floor", "y", 0.0, "above")
    rows = [(0.11 + 0.2 * i, 0.11 + 0.2 * j) for j in range(5) for i in range(4 + j // 2)]
    scene = handmade_scene(
        rows, np.zeros((len(rows), 2)), (left, floor, gate), restitution=0.05, impact_speed=8.0, skin=0.06,
        domain=((-5, 5), (-5, 5)), probes=("left", "floor", "gate"), probe_steps=5000, steps=10**6, output_steps=10**6,
    )  # fmt: skip
    engine = started(scene)
    engine.run(60_000)
    (fx, fy, _), pushed, carried = engine.wall("gate"), -engine.wall("left")[0], -engine.wall("floor")[1]
    weight = scene.mass * len(rows) * 9.81
    assert fx > 0.1 * weight
    assert atan2(fy, fx) == pytest.approx(radians(-30.0), rel=1e-9)
    assert fx == pytest.approx(pushed, rel=1e-3)
    assert carried - fy == pytest.approx(weight, rel=1e-4)
