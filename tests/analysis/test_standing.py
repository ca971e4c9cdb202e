# SPDX-License-Identifier: GPL-2.0-or-later
"""How a structure stands at the end, by histories made up and by a block that a run topples."""

from dataclasses import replace
from math import cos, hypot, nan, pi, radians, sin

import numpy as np
import pytest
from free_bodies import TALL, TIME, WIDE, body, corner, history_of, ramp, scene_of
from made_up import flow_context

from lammps_jump.analysis.devices import bodies
from lammps_jump.analysis.devices.standing import faces_of, standing_of
from lammps_jump.analysis.flow import from_scene
from lammps_jump.dump.walls import BodyHistory
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene.scene import Outlet, Springs
from lammps_jump.scene.walls import Block, Circle, Plane, Polygon

G = 9.81
WALL = Polygon("quay", ((4.0, 0.0), (7.0, 0.0), (5.5, 3.0), (5.0, 3.0)))
"""A gravity wall with a face that leans."""
SHAPES = [WIDE, TALL, WALL]


def flow_of(**more):
    return flow_context(**{"domain": ((-50.0, 50.0), (-20.0, 20.0)), "x_range": (-50.0, 50.0), "walls": ()} | more)


def stands(wall, flow=None, free=None, **moved):
    one = body(wall, **(free or {}))
    return standing_of(flow or flow_of(), one, history_of(one, **moved))


@pytest.mark.parametrize("wall", SHAPES)
def test_what_does_not_move_stands(wall):
    found = stands(wall)
    assert (found.state, found.side, found.slid_by, found.turn) == ("stands", None, 0.0, 0.0)
    assert np.isnan([found.slides_at, found.tips_at, found.falls_at, found.since]).all()


@pytest.mark.parametrize("wall", SHAPES)
@pytest.mark.parametrize("way", [0.5, -0.5, 8.0])
def test_what_slides_has_slid(wall, way):
    found = stands(wall, x=ramp(2.0, 5.0, way))
    width = np.ptp(wall.extent[0])
    assert found.state == "slid" and found.slid_by == pytest.approx(way, rel=1e-9) and np.isnan(found.tips_at)
    assert found.slides_at == pytest.approx(2.0 + 3.0 * 0.01 * width / abs(way), abs=0.03)
    assert found.base[-1] == pytest.approx(abs(way))


@pytest.mark.parametrize("wall", SHAPES)
def test_what_slides_less_than_a_hundredth_of_its_width_stands(wall):
    way = 0.009 * np.ptp(wall.extent[0])
    assert stands(wall, x=ramp(2.0, 5.0, way)).state == "stands"
    assert stands(wall, x=ramp(2.0, 5.0, 1.2 * way)).state == "slid"
    back = stands(wall, x=ramp(2.0, 3.0, 1.0) - ramp(4.0, 5.0, 1.0))
    assert back.state == "stands" and back.slides_at == pytest.approx(2.0, abs=0.1)  # it slid, and came back


@pytest.mark.parametrize("wall", [WIDE, TALL])
@pytest.mark.parametrize("right", [True, False])
def test_a_block_that_topples_lies_on_its_side(wall, right):
    """About its toe, after it has slid by 0.5 m: the title of before told 0.5 m and more of sliding alone."""
    turn, way = (-1 if right else 1) * pi / 2, 0.5 if right else -0.5
    found = stands(wall, x=ramp(1.0, 2.0, way), angle=ramp(3.0, 4.0, turn), about=corner(wall, right))
    assert (found.state, found.side) == ("lies", "right" if right else "left")
    assert found.turn == pytest.approx(turn) and 1.0 < found.slides_at < 2.0 < found.tips_at < 3.1
    assert found.since == pytest.approx(3.0 + 75 / 90, abs=0.03)  # within 15 degrees of its side
    width = np.ptp(wall.extent[0])
    # the middle of the base comes to stand half a width above the toe
    assert found.slid_by == pytest.approx(way + np.sign(way) * 0.5 * width, rel=1e-9)
    assert found.base[-1] == pytest.approx(hypot(abs(way) + 0.5 * width, 0.5 * width))


@pytest.mark.parametrize("right", [True, False])
def test_a_block_that_tips_without_sliding_has_not_slid(right):
    """The middle of its base moves, its toe does not."""
    found = stands(TALL, angle=ramp(3.0, 4.0, -pi / 2 if right else pi / 2), about=corner(TALL, right))
    assert np.isnan(found.slides_at) and found.state == "lies" and abs(found.slid_by) == pytest.approx(0.35)


@pytest.mark.parametrize(
    ("degrees", "state", "side"),
    [
        (-1.9, "stands", None), (2.1, "leans", "left"), (-2.1, "leans", "right"), (-30, "leans", "right"),
        (-74, "leans", "right"), (-76, "lies", "right"), (-104, "lies", "right"), (104, "lies", "left"),
        (-135, "leans", "right"), (-180, "lies", "top"), (180, "lies", "top"), (-270, "lies", "left"),
        (-359, "stands", None),
    ],
)  # fmt: skip
def test_the_turn_decides_how_a_block_is_at_the_end(degrees, state, side):
    found = stands(TALL, angle=ramp(2.0, 4.0, radians(degrees)), about=corner(TALL, degrees < 0))
    assert (found.state, found.side) == (state, side)
    assert found.turn == pytest.approx(radians(degrees))


@pytest.mark.parametrize(("degrees", "side"), [(-116.565, "right"), (108.435, "left")])
def test_a_wall_with_leaning_faces_lies_on_them(degrees, side):
    """Its faces lean by 26.57 and 18.43 degrees."""
    found = stands(WALL, angle=ramp(2.0, 4.0, radians(degrees)), about=corner(WALL, degrees < 0))
    assert (found.state, found.side) == ("lies", side)


@pytest.mark.parametrize("slope", [-25.0, 0.0, 20.0])
@pytest.mark.parametrize("begun", [0.0, 0.7])
def test_a_block_on_a_slope_stands_slides_and_topples_there(slope, begun):
    """Its base is the face that looks most downward; ways are along it. A body may begin turned, from another run."""
    angle = radians(slope)
    wall = Block("box", (4.0, 6.0), (0.0, 1.0), angle=slope - np.degrees(begun))
    c, s = cos(angle), sin(angle)
    moved = {"x": ramp(2.0, 4.0, 1.5 * c), "y": ramp(2.0, 4.0, 1.5 * s)}
    found = stands(wall, angle=begun, **moved)
    assert found.state == "slid" and found.slid_by == pytest.approx(1.5, rel=1e-6)
    assert stands(wall, angle=begun).state == "stands"
    assert stands(wall, angle=begun + ramp(2.0, 4.0, -pi / 2)).state == "lies"
    # on level ground below the slope, turned by what is left to a side
    level = stands(wall, angle=begun + ramp(2.0, 4.0, -pi / 2 - angle))
    assert (level.state, level.side) == ("lies", "right")


def test_gravity_that_leans_is_down():
    a = radians(30.0)
    flow = flow_of(gravity=(G * sin(a), -G * cos(a)))
    assert stands(WIDE, flow).state == "stands"
    assert stands(WIDE, flow, x=ramp(2.0, 4.0, 1.0)).slid_by == pytest.approx(1.0)
    assert stands(WIDE, flow_of(gravity=(0.0, 0.0))).reason == "there is no gravity"


def test_what_sinks_is_carried_and_what_falls_is_not():
    """A tenth of its width in 5 s into soft ground, and over an edge at 9.81 m/s2."""
    sunk = stands(WIDE, x=ramp(6.0, 8.0, 0.5), y=-ramp(0.0, 5.0, 0.2))
    assert sunk.state == "slid" and np.isnan(sunk.falls_at) and sunk.slides_at == pytest.approx(6.1, abs=0.05)
    fall = -np.clip(0.5 * G * np.clip(TIME - 5.0, 0.0, None) ** 2, 0.0, 3.0)
    off = stands(WIDE, x=ramp(2.0, 5.0, 2.0) + ramp(5.0, 6.0, 1.0), y=fall)
    assert off.state == "slid" and off.slides_at < off.falls_at == pytest.approx(5.0, abs=0.1)
    below = stands(WIDE, y=fall)
    assert below.state == "stands" and np.isnan(below.slides_at) and below.falls_at == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("begin", [0.0, 4.0])
def test_of_what_stands_on_nothing_no_state_is_told(begin):
    held = np.clip(TIME - begin, 0.0, None)
    fall = -np.clip(0.5 * G * held**2, 0.0, 5.0)
    found = stands(WIDE, free={"begin": begin}, x=0.3 * held, y=fall, angle=0.2 * held)
    assert found.state is None and found.reason == "it stood on nothing at the start"
    thrown = 5.0 * held - 0.5 * G * held**2
    thrown = np.where(thrown < 0, 0.0, thrown)
    assert stands(WIDE, free={"begin": begin}, y=thrown).reason == "it stood on nothing at the start"


def test_what_is_in_the_air_at_the_end_has_no_state():
    fall = -0.5 * G * np.clip(TIME - 9.0, 0.0, None) ** 2
    assert stands(WIDE, y=fall).reason == "it is in the air at the end"


@pytest.mark.parametrize(
    ("free", "wall", "reason"),
    [
        ({"hinge": (5.0, 1.0)}, WIDE, "it turns about a hinge"),
        ({"begin": 20.0}, WIDE, "it is held to the end"),
        ({}, Circle("boulder", (5.0, 1.0), 1.0), "it has no base to stand on"),
        ({}, Block("edge", (4.0, 5.0), (0.0, 1.0), angle=45.0), None),
    ],
)
def test_why_there_is_no_state(free, wall, reason):
    found = stands(wall, free=free)
    assert found.reason == reason and (found.state is None) == (reason is not None)


@pytest.mark.parametrize("wall", [*SHAPES, Circle("boulder", (5.0, 1.0), 1.0)])
def test_what_is_beyond_an_outlet_or_the_domain_has_left(wall):
    flow = flow_of(outlets=(Outlet("x", 20.0, "above", 1), Outlet("y", -9.0, "below", 1)))
    centre = body(wall).motion.free.centre
    found = stands(wall, flow, x=ramp(2.0, 4.0, 20.1 - centre[0]))
    assert found.state == "left" and found.since == pytest.approx(4.0, abs=0.05)
    assert stands(wall, flow, y=ramp(2.0, 4.0, -12.0)).state == "left"
    assert stands(wall, x=ramp(2.0, 4.0, -60.0)).state == "left"  # the domain
    back = stands(wall, flow, x=ramp(2.0, 4.0, 17.0) - ramp(5.0, 6.0, 10.0))
    assert back.state != "left"


@pytest.mark.parametrize("wall", SHAPES)
@pytest.mark.parametrize("degrees", [0.0, 5.0, 92.0])
def test_left_and_right_are_alike(wall, degrees):
    points = np.asarray(wall.outline((0.0, 0.0), (0.0, 0.0))[0])
    mirrored = Polygon("mirrored", tuple((10.0 - x, y) for x, y in points))
    one = stands(wall, x=ramp(1.0, 2.0, 0.7), angle=ramp(3.0, 4.0, -radians(degrees)), about=corner(wall, True))
    two = stands(
        mirrored, x=ramp(1.0, 2.0, -0.7), angle=ramp(3.0, 4.0, radians(degrees)), about=corner(mirrored, False)
    )
    other = {"right": "left", "left": "right"}
    assert one.state == two.state and other.get(one.side, one.side) == two.side
    assert two.slid_by == pytest.approx(-one.slid_by)
    for name in ("slides_at", "tips_at", "falls_at", "since"):
        assert getattr(one, name) == pytest.approx(getattr(two, name), nan_ok=True)


def test_faces_of_a_hull_have_no_joints_on_a_line():
    corners = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (1, 0.5), (0, 1)], float)
    faces = faces_of(corners)
    assert sorted(face.length for face in faces) == pytest.approx([1.0, 1.0, 2.0, 2.0])
    assert all(abs(hypot(*face.normal) - 1) < 1e-12 for face in faces)
    assert sum((face.normal * face.length for face in faces), np.zeros(2)) == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("way", [1, pytest.param(-1, marks=pytest.mark.long)])
def test_a_post_that_a_run_topples_lies_on_its_side(way):
    """A block of 0.4 x 1.6 m that turns at 2.2 rad/s about its toe: past its point of no return."""
    post = Block("post", (-0.2, 0.2), (0.0, 1.6))
    free = body(post, spin=-way * 2.2, velocity=(way * 2.2 * 0.8, way * 0.0))
    scene = scene_of(
        Plane("floor", "y", 0.0, "above"), free, steps=10, probe_steps=50, friction=0.9, friction_law="history",
        springs=Springs(2 / 7, 1.0, None), restitution=0.2, impact_speed=60.0,
    )  # fmt: skip
    scene = replace(scene, steps=round(1.5 / scene.time_step))
    simulation = NativeSimulation(scene, ledger=False)
    simulation.run(scene.steps)
    rows = [(scene.time(step), *numbers) for step, _, numbers in simulation.windows.bodies]
    found = standing_of(from_scene(scene), free, BodyHistory(*np.array(rows).T))
    assert (found.state, found.side) == ("lies", "right" if way > 0 else "left")
    assert found.turn == pytest.approx(-way * pi / 2, abs=0.02)
    assert found.tips_at < found.since


def test_the_table_of_a_body_has_the_way_of_its_base_beside_that_of_its_centre():
    one = body(TALL)
    rows = history_of(one, x=ramp(1.0, 2.0, 0.5), angle=ramp(3.0, 4.0, -pi / 2), about=corner(TALL, True))
    found = bodies._found(flow_of(), one, rows, np.empty((0, 4)))
    assert (found.state, found.side, found.lean) == ("lies", "right", pytest.approx(-90.0))
    assert found.base_way == pytest.approx(hypot(0.85, 0.35)) and found.centre_way == pytest.approx(hypot(2.6, 1.4))
    (panel, *_) = bodies.figures({"post": found}, None)["bodies"].panels
    assert {line.label for line in panel.lines} == {"centre of mass", "middle of the base"}
    text = [row[0] for row in bodies.section({"post": found}).blocks[0].rows]
    assert any("middle of its base" in str(one) for one in text)
    assert nan != found.state_since
