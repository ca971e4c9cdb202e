# SPDX-License-Identifier: GPL-2.0-or-later
"""About what point a moment is, in numbers, figure and table; and moments of a body about both toes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from free_bodies import TALL, TIME, WIDE, body, corner, history_of, ramp
from made_up import disc_frame, flow_context

from lammps_jump.analysis.forces.figures import impulse_chart, section
from lammps_jump.analysis.forces.history import Forces, analyse_forces, point_of, toes_of
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.walls import PoseFile, write_bodies
from lammps_jump.scene.motion import Motion, MovingWall, Pose
from lammps_jump.scene.tracks import Held, Rotate, Translate
from lammps_jump.scene.walls import Block, Box, Circle, Line, Plane, Polygon

G = 9.81
FLOOR = Plane("floor", "y", 0.0, "above")
SILL = Block("sill", (5.0, 6.0), (-2.0, 1.0))
BACK = Plane("back", "x", -1.0, "above")


def record(fx=0.0, fy=0.0, moment=0.0, time=TIME):
    zero = np.zeros(len(time))
    return ForceHistory(time, zero + fx, zero + fy, zero + moment)


def flow_of(*walls, **more):
    given = {"domain": ((-20.0, 20.0), (-5.0, 20.0)), "x_range": (-1.0, 20.0), "walls": walls, "bin_width": 1.0}
    return flow_context(**given | more)


def about(flow, name, history=None, bodies=None):
    return point_of(name, history or record(1.0), flow, bodies or {})


@pytest.mark.parametrize(
    ("wall", "point"),
    [
        (SILL, (5.0, -2.0)), (FLOOR, (0.0, 0.0)), (BACK, (-1.0, 0.0)), (Box("box", (0.0, 4.0), (1.0, 3.0)), (0.0, 1.0)),
        (Circle("pier", (3.0, 1.0), 0.5), (3.0, 1.0)), (Line("ramp", ((1.0, 2.0), (4.0, 0.0))), (1.0, 2.0)),
        (Polygon("quay", ((1.0, 0.0), (3.0, 0.0), (2.0, 2.0))), (1.0, 0.0)),
        (Block("leans", (1.0, 3.0), (0.0, 1.0), angle=30.0), None),
    ],
)  # fmt: skip
def test_a_wall_that_stands_has_its_point(wall, point):
    found = about(flow_of(wall), wall.name)
    assert found.words == "its point"
    assert (found.x[0], found.y[-1]) == pytest.approx(point or wall.moment_point)


@pytest.mark.parametrize(
    ("kind", "words", "way"),
    [
        (Translate(velocity=(0.5, 0.0)), "the point that it turns about", (5.0, 0.0)),
        (Rotate(rate=30.0), "the point that it turns about", (0.0, 0.0)),
    ],
)
def test_the_point_of_a_wall_that_moves_goes_with_it(kind, words, way):
    flow = flow_of(MovingWall(SILL, Motion(kind=kind, about=(5.5, -0.5), time_step=1e-3)), time_step=1e-3)
    found = about(flow, "sill")
    assert found.words == words
    assert (found.x[0], found.y[0]) == (5.5, -0.5)
    assert (found.x[-1], found.y[-1]) == pytest.approx((5.5 + way[0], -0.5 + way[1]))


def test_the_point_of_a_tailgate_is_where_its_file_has_it(tmp_path):
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n0,sill,0,0,0\n10,sill,0,0.4,0\n")
    held = Held(front=3.0, speed=0.1, range=(-1.0, 1.0))
    walls = [MovingWall(SILL, Motion(kind=held, about=(5.5, -0.5), time_step=1e-3))]
    flow = flow_of(*walls, poses=PoseFile(tmp_path / "walls.csv", ["sill"]))
    assert about(flow, "sill").y[[0, 200, -1]] == pytest.approx([-0.5, -0.3, -0.1])


def test_a_group_and_what_the_scene_does_not_know():
    flow = flow_of(SILL, FLOOR, groups=(("basin", ("sill", "floor")),))
    found = about(flow, "basin")
    assert found.words == "the point of sill" and (found.x[0], found.y[0]) == (5.0, -2.0)
    assert about(flow, "elsewhere") is None


def test_a_body_has_its_centre_of_mass_or_its_hinge():
    one = body(WIDE)
    rows = history_of(one, x=ramp(2.0, 4.0, 1.0))
    found = about(flow_of(one), "box", bodies={"box": rows})
    assert found.words == "its centre of mass" and (found.x[0], found.x[-1]) == (5.0, 6.0)
    hinged = body(WIDE, hinge=(4.5, 0.5))
    found = about(flow_of(hinged), "box", bodies={"box": rows})
    assert found.words == "its hinge" and (found.x[-1], found.y[-1]) == (4.5, 0.5)
    assert toes_of(hinged, flow_of(hinged), record(1.0), found, rows) is None
    assert about(flow_of(one), "box") is None  # its file is not there


def found_of(one, rows, history, tmp_path, **more):
    """Forces on a body, and on the walls of a case."""
    scene = SimpleNamespace(time=lambda step: TIME[step])
    columns = np.column_stack(rows[1:])
    write_bodies(tmp_path / "bodies.csv", scene, ((k, one.wall.name, tuple(row)) for k, row in enumerate(columns)))
    flow = flow_of(FLOOR, one, poses=PoseFile(tmp_path / "walls.csv", []), time_step=1e-3, **more)
    frames = [disc_frame([1.0], [0.1], box=[[-20, 20], [-5, 20]], step=k, time=float(k)) for k in range(11)]
    return analyse_forces({one.wall.name: history}, flow, None, compute_profiles(frames, flow))


@pytest.mark.parametrize("wall", [WIDE, TALL, Polygon("quay", ((4.0, 0.0), (7.0, 0.0), (5.5, 3.0), (5.0, 3.0)))])
@pytest.mark.parametrize("height", [0.0, 0.4, 2.0])
@pytest.mark.parametrize("force", [(3000.0, 0.0), (-3000.0, -500.0), (0.0, -800.0)])
def test_moments_about_both_toes_are_those_of_the_force(wall, height, force, tmp_path):
    """A force that acts at x = 4.2 m and some height, whose moment the record has about the centre of mass."""
    one = body(wall)
    (cx, cy), (fx, fy) = one.motion.free.centre, force
    at = np.array([4.2, height])
    rows = history_of(one)
    history = record(fx, fy, (at[0] - cx) * fy - (at[1] - cy) * fx)
    (force,) = found_of(one, rows, history, tmp_path).structures.values()
    for side, sign in (("right", -1.0), ("left", 1.0)):
        toe = corner(wall, side == "right")
        exact = (at[0] - toe[0]) * fy - (at[1] - toe[1]) * fx
        np.testing.assert_allclose(force.table[f"moment_{side}_toe"], exact, atol=1e-6)
        over = sign * exact
        assert getattr(force, f"overturning_{side}") == pytest.approx(
            over if over > 1e-6 else np.nan, nan_ok=True, abs=1e-6
        )
        weight = one.motion.free.mass * G
        assert getattr(force, f"weight_{side}") == pytest.approx(weight * abs(cx - toe[0]))


def test_a_body_that_slides_takes_its_toes_along_and_one_that_topples_has_none(tmp_path):
    one = body(TALL)
    rows = history_of(one, x=ramp(1.0, 2.0, 0.8), angle=ramp(3.0, 4.0, -np.pi / 2), about=corner(TALL, True))
    history = record(0.0, -1000.0)  # through its centre of mass
    (force,) = found_of(one, rows, history, tmp_path).structures.values()
    upright = TIME < 3.0
    np.testing.assert_allclose(force.table["moment_right_toe"][upright], 1000.0 * 0.35, rtol=1e-9)
    np.testing.assert_allclose(force.table["moment_x"][upright], 4.35 + ramp(1.0, 2.0, 0.8)[upright], rtol=1e-9)
    gone = np.isnan(force.table["moment_right_toe"])
    assert TIME[gone][0] == pytest.approx(3.0 + 15 / 90, abs=0.03) and gone[-1]
    assert np.isnan(force.table["moment_right_toe_smooth"][gone]).all()
    # from 11.3 degrees on its centre of mass is beyond the toe: 0.115 m at 15 degrees
    assert 0 < force.overturning_right < 115.0 and np.isnan(force.overturning_left)
    assert np.isfinite(force.table["moment_smooth"][gone][:-1]).all()


def test_figure_and_table_say_about_what_point(tmp_path):
    one = body(TALL)
    found = found_of(one, history_of(one), record(3000.0, 0.0, 500.0), tmp_path)
    texts = [line.label for line in impulse_chart(found).panels[-1].lines]
    assert texts == [
        "post, about its right toe, anticlockwise", "post, about its left toe, anticlockwise",
        "what its weight holds over the right toe",
    ]  # fmt: skip
    tables = [block for block in section(found).blocks if getattr(block, "rows", ())]
    (moments,) = (one for one in tables if one.header[0] == "Moments, anticlockwise")
    assert moments.header[1] == "about" and moments.rows[0][:3] == ("post", "its centre of mass", 0.5)
    (over,) = (one for one in tables if one.header[0] == "Overturning")
    assert "clockwise" in over.header[1] and len(over.rows[0]) == 5
    assert {"moment_x", "moment_y", "moment_left_toe", "moment_right_toe"} <= set(found.tables()["force_post.csv"])
    again = Forces.of(found.summary()).structures["post"]
    assert again.moment_about == "its centre of mass" and again.weight_right == found.structures["post"].weight_right


@pytest.mark.parametrize(
    ("walls", "name", "foot"), [((FLOOR, SILL), "sill", (5.0, 0.0)), ((FLOOR, BACK), "back", (-1.0, 0.0))]
)
def test_the_moment_of_an_upright_face_is_about_its_foot_at_the_bed(walls, name, foot):
    """The record has that of the sill about its corner 2 m below the bed."""
    flow = flow_of(*walls)
    frames = [disc_frame([3.0, 4.5], [0.1, 0.1], box=[[-20, 20], [-5, 20]], step=k, time=float(k)) for k in range(11)]
    recorded = record(100.0, 0.0, -250.0)
    (force,) = analyse_forces({name: recorded}, flow, None, compute_profiles(frames, flow)).structures.values()
    assert force.moment_about == "its foot" and (force.moment_x, force.moment_y) == foot
    up = foot[1] - dict(sill=-2.0, back=0.0)[name]
    np.testing.assert_allclose(force.table["moment"], -250.0 + up * 100.0)
    (panel,) = impulse_chart(SimpleNamespace(shown={name: force})).panels[1:]
    assert panel.lines[0].label == f"{name}, about its foot, anticlockwise"


def test_of_a_wall_that_the_scene_does_not_know_no_point_is_told():
    flow = flow_of(FLOOR)
    frames = [disc_frame([3.0], [0.1], box=[[-20, 20], [-5, 20]], step=k, time=float(k)) for k in range(11)]
    found = analyse_forces({"other": record(100.0, 0.0, 5.0)}, flow, None, compute_profiles(frames, flow))
    force = found.structures["other"]
    assert force.moment_about is None and np.isnan(force.moment_x) and "moment_x" not in force.table
    assert impulse_chart(found).panels[1].lines[0].label == "other, about a point that is not known, anticlockwise"
    assert any(
        row[1] == "not known" for block in section(found).blocks if getattr(block, "rows", ()) for row in block.rows
    )
    assert replace(force, reason=None).component == "fx" and Pose() == Pose()
