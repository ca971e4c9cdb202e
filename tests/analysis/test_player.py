# SPDX-License-Identifier: GPL-2.0-or-later
"""What the player is told of a run: what to show, walls and gates, and Bélanger's depth of each instant."""

from pathlib import Path

import numpy as np
import pytest
from free_bodies import body
from made_up import disc_frame, flow_context

from lammps_jump.analysis.report import player
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.player import make_player, pack_player
from lammps_jump.dump.exports import write_table
from lammps_jump.dump.find import ForceHistory, forces_in
from lammps_jump.dump.walls import PoseFile
from lammps_jump.files import BODIES_HEADER
from lammps_jump.physics.jump import sequent_depth
from lammps_jump.scene.chains import Chain
from lammps_jump.scene.motion import Motion, MovingWall, gate
from lammps_jump.scene.shapes import ArcTo, rectangle, thin
from lammps_jump.scene.tracks import Loaded, Rotate, Translate
from lammps_jump.scene.walls import Block, Box, Line, Plane, Wall

WALLS = (Block("floor", (-5, 30), (-2, 0)), Block("sill", (20, 21), (-2, 1)))


def header(tmp_path, *, track=None, **given):
    """The header of a run of five frames, 0.5 s apart, with a track of the jump."""
    flow = flow_context(**{"domain": ((0, 30), (-5, 10)), "x_range": (0, 30), "walls": WALLS, "sized": False} | given)
    packer = FramePacker(flow)
    for k in range(5):
        frame = disc_frame([1.0, 12.0], [0.1, 2.0], [3.0, -4.0], box=[[0, 30], [-5, 10]], time=0.5 * k)
        packer.add(frame, frame.time)
    if track is not None:
        write_table(track, tmp_path / "jump_track.csv")
    return make_player(packer, tmp_path).header


def motion(kind, *, about=(0.0, 0.0), gone=np.inf):
    return Motion(gone, kind, about, time_step=1e-3)


def track(**changes):
    """A front that moves upstream at 1 m/s from x = 18 m, before it 0.6 m of depth at 10 m/s."""
    time = 0.5 * np.arange(5)
    columns = {"time": time, "position": 18 - time, "mass_depth_1": np.full(5, 0.6), "velocity_1": np.full(5, 10.0)}
    return columns | {"found": np.array([0, 1, 1, 1, 1])} | changes


def test_line_of_belanger_belongs_to_the_stream_as_seen_from_the_front(tmp_path):
    lines = header(tmp_path, track=track())["sequent"]
    assert lines[0] is None
    start, end, depth = lines[3]
    assert start == pytest.approx(16.5) and end == pytest.approx(20, abs=0.1)  # as far as the sill
    assert depth == pytest.approx(sequent_depth(11.0, 0.6, 9.81))


def test_a_stream_to_the_left_has_its_line_to_the_left(tmp_path):
    walls = (Block("floor", (0, 30), (-2, 0)), Block("sill", (4, 5), (-2, 1)))
    mirrored = track(position=10 + 0.5 * np.arange(5), velocity_1=np.full(5, -10.0))
    start, end, depth = header(tmp_path, track=mirrored, walls=walls)["sequent"][2]
    assert (start, end) == (pytest.approx(11.0), pytest.approx(5, abs=0.1))
    assert depth == pytest.approx(sequent_depth(11.0, 0.6, 9.81))


def test_without_a_track_or_with_a_damaged_one_there_is_no_line(tmp_path):
    assert header(tmp_path)["sequent"] == [None] * 5
    (tmp_path / "jump_track.csv").write_text("time,position\n1,2\n")
    assert header(tmp_path)["sequent"] == [None] * 5
    nan = np.full(5, np.nan)
    assert header(tmp_path, track=track(position=nan, mass_depth_1=nan))["sequent"] == [None] * 5
    assert header(tmp_path, track=track(), timed=False)["sequent"] == [None] * 5


def test_walls_and_gates_are_closed_polygons(tmp_path):
    shut = gate(Block("gate", (5, 5), (0, 3)), 2000)
    walls = (*WALLS, Box("box", (0, 29), (-3, 9)), Plane("lid", "y", 9, "below"), shut)
    found = header(tmp_path, walls=walls, time_step=1e-3)
    assert [(wall["name"], wall["hollow"], *map(len, wall["outlines"])) for wall in found["walls"]] == [
        ("floor", False, 4), ("sill", False, 4), ("box", True, 4), ("lid", False, 4),
    ]  # fmt: skip
    assert [(gate["name"], gate["until"]) for gate in found["gates"]] == [("gate", pytest.approx(2.0))]


def test_a_gate_without_end_hides_nothing_behind_it(tmp_path):
    shut = gate(Plane("gate", "x", 5, "below"), 2000)
    (found,) = header(tmp_path, walls=(*WALLS, shut), time_step=1e-3)["gates"]
    ((start, end),) = found["lines"]
    assert found["outlines"] == [] and start[0] == end[0] == 5 and end[1] > start[1]  # upwards: discs on its left


def chained(*chains, name="made", hollow=False):
    """A wall of any chains."""
    return type("Chained", (Wall,), {"chains": lambda self: chains, "hollow": hollow, "name": name, "kind": "made"})()


def test_parts_of_a_wall_are_one_shape_and_open_lines_stand_apart(tmp_path):
    hole = rectangle((2, 3), (1, 2))
    two = chained(*(Chain(tuple(map(tuple, hole + shift)), closed=True) for shift in ((0, 0), (5, 0))), hollow=True)
    bed = Line("bed", points=((0, 1), (4, 0), ArcTo((6, 0.5), 3.0), (30, 0.5)))
    leaf = Line("leaf", points=((8, 0), (9, 1), (9, 2)), sheet=True)
    ring = Line("ring", points=((10, 3), (11, 3), (11, 4), (10, 3)), sheet=True)
    shapes = {wall["name"]: wall for wall in header(tmp_path, walls=(*WALLS, two, bed, leaf, ring))["walls"]}
    assert shapes["made"]["hollow"] and len(shapes["made"]["outlines"]) == 2 and shapes["made"]["lines"] == []
    (line,) = shapes["bed"]["lines"]
    assert shapes["bed"]["outlines"] == [] and len(line) == 3 + 12
    assert line[0] == pytest.approx((0, 1)) and line[-1] == pytest.approx((30, 0.5))
    assert all(thin(*shapes[name]["outlines"]) for name in ("leaf", "ring"))


def test_a_wall_that_moves_has_a_pose_for_each_frame(tmp_path):
    paddle = MovingWall(Block("paddle", (10, 11), (0, 2)), motion(Rotate(rate=90.0, until=1.0), about=(10.0, 0.0)))
    lid = MovingWall(Block("lid", (12, 13), (3, 4)), motion(Loaded(mass=1.0, force=(0.0, -1.0))))
    lift = MovingWall(Block("gate", (5, 5), (0, 3)), motion(Translate(velocity=(0.0, 2.0)), gone=1600))
    rows = [f"{0.5 * k:g},lid,0,{-0.1 * k:g},{0.01 * k:g}" for k in range(5)]
    (tmp_path / "walls.csv").write_text("\n".join(["time,wall,x,y,angle", *rows, ""]))
    poses = PoseFile(tmp_path / "walls.csv", ["lid"])
    found = header(tmp_path, walls=(*WALLS, paddle, lid, lift), time_step=1e-3, poses=poses)
    shapes = {wall["name"]: wall for wall in (*found["walls"], *found["gates"])}
    assert "about" not in shapes["sill"] and shapes["paddle"]["about"] == (10.0, 0.0)
    assert shapes["paddle"]["angle"] == pytest.approx(np.radians([0, 45, 90, 90, 90]), abs=1e-6)
    assert shapes["lid"]["y"] == pytest.approx([0, -0.1, -0.2, -0.3, -0.4])
    assert shapes["lid"]["angle"] == pytest.approx([0, 0.01, 0.02, 0.03, 0.04])
    assert shapes["gate"]["y"] == pytest.approx([0, 1, 2, 3, 0])  # gone at the last frame
    assert shapes["gate"]["until"] == pytest.approx(1.6)


def floated(tmp_path, rows):
    """The shape of a block that is a body, 5 m along x and 1 m high, of a run with these rows in ``bodies.csv``."""
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n0,block,0,0,0\n2,block,1,0,0.5\n")
    if rows is not None:
        (tmp_path / "bodies.csv").write_text("\n".join([BODIES_HEADER, *rows, ""]))
    poses = PoseFile(tmp_path / "walls.csv", ["block"])
    block = body(Block("block", (5, 10), (1, 2)))
    return next(one for one in header(tmp_path, walls=(*WALLS, block), poses=poses)["walls"] if one["name"] == "block")


def test_a_body_has_mass_velocity_and_force_of_each_frame(tmp_path):
    """Rows at other times than the frames; the last frame, at 2 s, is behind them."""
    rows = [f"{t:g},block,{7.5 + t:g},1.5,0,{2 * t:g},{-t:g},0,{100 * t:g},50,7" for t in (0.0, 0.3, 0.9, 1.5)]
    shape = floated(tmp_path, rows)
    found = shape["body"]
    assert found["mass"] == 5000.0 and found["centre"] == (7.5, 1.5) == shape["about"]
    assert found["vx"] == pytest.approx([0, 1, 2, 3, None]) and found["vy"] == pytest.approx([0, -0.5, -1, -1.5, None])
    assert found["fx"] == pytest.approx([0, 50, 100, 150, None]) and found["fy"] == pytest.approx([50] * 4 + [None])
    assert shape["x"] == pytest.approx([0, 0.25, 0.5, 0.75, 1])


@pytest.mark.parametrize("rows", [None, ["0,block,7.5"], ["0,other,7.5,1.5,0,0,0,0,0,0,0"]])
def test_a_body_without_its_rows_has_its_mass_alone(tmp_path, rows):
    assert floated(tmp_path, rows)["body"] == {"mass": 5000.0, "centre": (7.5, 1.5)}


def with_forces(rows, names=("sill",), **given):
    """Shapes of a header by name, of a run with these rows of time, fx and fy for each name."""
    history = ForceHistory(*np.array([(*row, 0.0) for row in rows], float).T)
    packer = FramePacker(flow_context(domain=((0, 30), (-5, 10)), x_range=(0, 30), walls=WALLS, sized=False, **given))
    frame = disc_frame([1.0], [0.1], [3.0], box=[[0, 30], [-5, 10]], time=0.0)
    packer.add(frame, 0.0)
    found = pack_player(packer, Path("none"), dict.fromkeys(names, history)).header
    return {shape["name"]: shape for key in ("walls", "gates") for shape in found[key]}


def test_a_wall_has_the_force_of_each_row_of_its_record():
    shapes = with_forces([(0.1, 5, 1), (0.2, 7, -1), (0.3, 0, 0)])
    assert "force" not in shapes["floor"]
    force = {key: np.asarray(value).tolist() for key, value in shapes["sill"]["force"].items()}
    assert force == {"time": [0.1, 0.2, 0.3], "fx": [5, 7, 0], "fy": [1, -1, 0], "each": 0.1, "taken": 1}


@pytest.mark.parametrize(("rows", "most", "ends"), [(7, 3, [3, 6, 7]), (6, 3, [2, 4, 6]), (5, 1, [5])])
def test_a_long_record_is_shown_as_means_that_keep_its_impulse(monkeypatch, rows, most, ends):
    """Of two walls each has half of the rows; the last mean may be of fewer."""
    monkeypatch.setattr(player, "MOST_ROWS", 2 * most)
    monkeypatch.setattr(player, "FEWEST_ROWS", 1)
    values = np.random.default_rng(4).normal(size=(rows, 2))
    record = [(k + 1.0, *value) for k, value in enumerate(values)]
    force = with_forces(record, ("sill", "floor"))["sill"]["force"]
    assert force["time"].tolist() == ends and force["taken"] == force["each"] == ends[0]
    for way, column in zip(("fx", "fy"), values.T, strict=True):
        assert np.dot(force[way], np.diff(ends, prepend=0)) == pytest.approx(column.sum(), rel=1e-12)


def test_a_body_without_a_record_of_its_own_has_that_of_all_bodies(tmp_path):
    rows = [f"{t:g},block,{7.5 + t:g},1.5,0,0,0,0,{100 * t:g},50,7" for t in (0.0, 0.5, 1.0)]
    force = floated(tmp_path, rows)["force"]
    assert force["time"].tolist() == [0, 0.5, 1] and force["fx"].tolist() == [0, 50, 100] and force["each"] == 0.5


def test_what_is_shown_reaches_over_discs_and_blocks(tmp_path):
    found = header(tmp_path)
    (x0, x1), (y0, y1) = found["seen"]
    assert x0 <= 1 and x1 >= 21 and y0 < 0 and y1 > 2.1
    assert found["fastest"] == pytest.approx(4.0, rel=0.03) and found["bed"] == 0.0
    assert found["area"] == pytest.approx(40 / 1000 / 0.1**2) and found["unit"] == "s"


def test_a_run_without_discs_has_no_player(tmp_path):
    packer = FramePacker(flow_context(domain=((0, 1), (0, 1)), x_range=(0, 1)))
    assert make_player(packer, tmp_path) is None


@pytest.mark.parametrize("frames, kept", [(3, [0, 1, 2]), (7, [0, 2, 4, 6])])
def test_frames_of_a_member_are_thinned_in_time(monkeypatch, frames, kept):
    monkeypatch.setattr(player, "MEMBER_ROWS", 7)
    positions = np.array([[1.0, 0.1], [12.0, 2.0]])
    flow = flow_context(domain=((0, 30), (-5, 10)), x_range=(0, 30), sized=False, positions=positions)
    packer = player.member_packer(flow, frames)
    for k in range(frames):
        packer.add(disc_frame(*positions.T, box=[[0, 30], [-5, 10]], time=float(k)), float(k))
    packed = packer.result()
    assert packed.header["times"].tolist() == kept and packed.header["rows"] == 2 * len(kept)


def test_pages_do_without_forces_that_cannot_be_read(tmp_path):
    """Player and live page read them by one function: none, or a damaged file, is no force and no error."""
    assert forces_in(tmp_path) == {}
    (tmp_path / "forces.csv").write_text("time,structure,fx,fy,moment\n0.1,sill,1,2,3\n")
    assert list(forces_in(tmp_path)) == ["sill"]
    (tmp_path / "forces.csv").write_text("time,structure,fx,fy,moment\n0.1,sill,1,2\n0.2,sill,1,2,3\n")
    assert forces_in(tmp_path) == {}
