# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a case: tables, joined lines, motions, contacts of their own, gates that rise, groups; and doubts."""

from math import pi, radians, sqrt

import numpy as np
import pytest

from lammps_jump.case import load_case, parse_case
from lammps_jump.case.fields import CaseFields
from lammps_jump.errors import CaseError
from lammps_jump.scene.motion import largest_speed, way
from lammps_jump.scene.shapes import ArcTo, flush, over_each_other, pairs_that_may_touch
from lammps_jump.scene.walls import Circle, Line, Plane

CASE = """\
name: walls
discs: {diameter: 0.2}
contact: {restitution: 0.3, friction: 0.3, impact_speed: 10}
walls:
  - {name: floor, kind: block, x: [-20, 30], y: [-5, -4]}
WALLS
initial:
  - {kind: column, x: [-2, -1], y: [6, 7], gate: GATE}
run: {duration: 3}
"""


def case(*walls, gate="true", changes=()):
    text = CASE.replace("WALLS", "\n".join(f"  - {wall}" for wall in walls)).replace("GATE", gate)
    return parse_case(text, "walls.yaml", changes)


def wall(motion, at="x: [4, 4.2], y: [0, 2]", **more):
    extra = "".join(f", {key}: {value}" for key, value in more.items())
    return f"{{name: a, kind: block, {at}, motion: {motion}{extra}}}"


def doubts(*walls):
    return [text for text in case(*walls).scene().warnings if "'a'" in text]


# --- mistakes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "place", "words"),
    [
        ("{name: a, kind: line, points: [[0, 0], [1, 0], [1, 0]]}", "points[2]", "stands where"),
        ("{name: a, kind: line, points: [[0, 0], {arc_to: [3, 0], radius: 1}]}", "points[1]", "1.5 m or more"),
        ("{name: a, kind: line, points: [[0, 0], {arc_to: [3, 0], radius: 0}]}", "points[1].radius", "no radius"),
        ("{name: a, kind: line, points: [[0, 0], {arc_to: [3, 0]}]}", "points[1].radius", "required"),
        ("{name: a, kind: line, points: [[0, 0], [1, 3 kg]]}", "points[1][1]", "number in m"),
        ("{name: a, kind: line, points: [[0, 0], [1, 2, 3]]}", "points[1]", "[x, y]"),
        ("{name: a, kind: line, points: [[0, 0], {arc_to: [0.1, 0.1], radius: 0.1}]}", "points[1]", "0.105 m or more"),
        ("{name: a, kind: polygon, points: [[-1, 0], [0, 0], {arc_to: [0.2, 0], radius: -0.1}, [1, 0], [0, 1]]}",
         "points[2]", "0.105 m or more"),
        ("{name: a, kind: line, discs: outside, points: [[0, 0], [1, 0]]}", "discs", "on its left"),
        ("{name: a, kind: line}", "points", "or file"),
        ("{name: a, kind: circle, centre: [0, 0], radius: 0.1, discs: inside}", "radius", "0.105 m or more"),
        ("{name: a, kind: block, x: [0, 0], y: [1, 1]}", "", "one point"),
        ("{name: a, kind: line, points: [[0, 0], [1, 0]], join: b}", "join", "no other line"),
        ("{name: a, kind: line, file: bed.csv}", "file", "no folder"),
        ("{name: a, kind: plane, axis: x, at: -9, side: above, motion: {kind: rotate, rate: 1}}", "motion", "no end"),
        (wall("{kind: table}"), "motion", "needs points"),
        (wall("{kind: rotate, rate: 1, form: 2}"), "motion.form", "'from'"),
        (wall("{kind: spin}"), "motion.kind", "'oscillate'"),
        (wall("null", stiffness="1e10"), "stiffness", "too stiff"),
    ],
)  # fmt: skip
def test_mistakes_name_line_and_field(given, place, words):
    with pytest.raises(CaseError) as error:
        case(given).scene()
    assert str(error.value).startswith(f"walls.yaml:6: walls[1]{'.' + place if place else ''}: ")
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("walls", "words"),
    [
        (["{name: a, kind: line, points: [[0, 0], [3, 0], [3, 7], [-3, 7.5], [-3, 0], [-0.1, 0]]}"],
         "0.1 m from its other end"),
        (["{name: a, kind: line, points: [[0, 0], [3, 0]]}", "{name: b, kind: line, points: [[3.1, 0], [5, 0]]}"],
         "a corner of 'b'"),
        (["{name: a, kind: line, points: [[0, 0], [3, -1]]}", "{name: b, kind: line, points: [[3, -1], [6, -2]]}"],
         "meet flush at (3, -1) m: a disc there feels both, up to twice the force; make them one wall, or give both"),
        (["{name: a, kind: line, points: [[3, 3], [-5, 3]]}"], "all discs start behind line 'a'"),
        ([wall("{kind: translate, velocity: [30, 0]}")], "at 100 m/s passes through"),
        ([wall("{kind: rotate, rate: 1800}", at="x: [4, 4], y: [0, 2]")], "at 50 m/s passes through"),
    ],
)  # fmt: skip
def test_doubts(walls, words):
    (text,) = doubts(*walls)
    assert words in text


def test_a_bend_of_short_pieces_is_doubtful():
    angles = np.linspace(pi, 2 * pi, 60)
    points = [[float(4 + 0.14 * np.cos(a)), float(0.14 * np.sin(a))] for a in angles]
    assert "with a radius of about 0.14 m" in doubts(f"{{name: a, kind: line, points: {points}}}")[0]
    points = [[float(4 + 0.16 * np.cos(a)), float(0.16 * np.sin(a))] for a in angles]
    assert doubts(f"{{name: a, kind: line, points: {points}}}") == []


# --- tables -----------------------------------------------------------------------------------------------------------


def with_file(folder, text, given="{name: a, kind: line, file: bed.csv}", name="bed.csv"):
    (folder / name).write_text(text)
    (folder / "case.yaml").write_text(CASE.replace("WALLS", f"  - {given}").replace("GATE", "true"))
    return load_case(folder / "case.yaml")


@pytest.mark.parametrize(
    "text",
    ["x,y\n0,0\n2,1\n", "0, 0\n2, 1\n", "# survey\n\nY; n; X\n0; 7; 0\n1; 8; 2\n", "\ufeffx y\n0 0\n200cm 1\n"],
)
def test_a_line_of_a_table_holds_its_points(text, tmp_path):
    read = with_file(tmp_path, text)
    assert read.fields.walls[1].points == ((0.0, 0.0), (2.0, 1.0))
    (tmp_path / "bed.csv").unlink()
    again = read.replace({"contact.friction": 0.1})  # the file is read once
    assert again.fields.walls[1].points == read.fields.walls[1].points
    assert parse_case(read.to_yaml()) == read and "file" not in read.to_yaml()


def test_a_motion_of_a_table(tmp_path):
    given = wall("{kind: table, file: motion.csv}")
    read = with_file(tmp_path, "t,x,y,angle\n1,0,2,90\n", given, "motion.csv")
    assert read.fields.walls[1].motion.points == ((1.0, 0.0, 2.0, 90.0),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y\n0,0\n1,one\n", "bed.csv:3: walls[1]: column y: 'one' is not one number"),
        ("x,y\n0,0\n1\n", "bed.csv:3: walls[1]: has 1 cells; the columns are x, y"),
        ("x,y\n0,0\n\n1,0\n1,0\n", "bed.csv:5: walls[1].points[2]: (1, 0) m stands where"),
        ("x,y\n0,0\n1,nan\n", "bed.csv:3: walls[1]: column y: 'nan'"),
        ("x,y\n0,0\n1,1e7\n", "bed.csv:3: walls[1].points[1][1]: 10000000.0 is out of range"),
        ("x,y\n", "bed.csv: walls[1]: holds no row"),
        ("x,y\n" + "1,1\n" * 20_001, "bed.csv:20002: walls[1]: more than 20000 rows"),
    ],
)
def test_mistakes_in_a_table_name_its_line(text, message, tmp_path):
    with pytest.raises(CaseError) as error:
        with_file(tmp_path, text)
    assert str(error.value).startswith(f"{tmp_path}/{message}")


@pytest.mark.parametrize("name", ["../bed.csv", "/etc/passwd", "link.csv", "below/../../bed.csv", "."])
def test_tables_lie_beside_the_case(name, tmp_path):
    folder = tmp_path / "case"
    (folder / "below").mkdir(parents=True)
    (tmp_path / "bed.csv").write_text("0,0\n1,1\n")
    (folder / "link.csv").symlink_to(tmp_path / "bed.csv")
    (folder / "below" / "bed.csv").write_text("0,0\n1,1\n")
    assert with_file(folder, "", "{name: a, kind: line, file: below/bed.csv}", "unused.csv").fields.walls[1].points
    with pytest.raises(CaseError, match=r"case.yaml:6: walls\[1\].file: "):
        with_file(folder, "", f"{{name: a, kind: line, file: {name}}}", "unused.csv")


def test_points_and_file_are_not_both_given(tmp_path):
    with pytest.raises(CaseError, match="keep one"):
        with_file(tmp_path, "0,0\n1,1\n", "{name: a, kind: line, file: bed.csv, points: [[0, 0], [1, 1]]}")


def test_another_table_by_set(tmp_path):
    (tmp_path / "other.csv").write_text("0,0\n5,1\n")
    read = with_file(tmp_path, "0,0\n1,1\n").replace({"walls.a.file": "other.csv"})
    assert read.fields.walls[1].points[1] == (5.0, 1.0)
    assert read.fields.description == "changed: walls.a.file = other.csv"


# --- joined lines -----------------------------------------------------------------------------------------------------

LEFT = "{name: left, kind: line, points: [[0, 0], [2, 0]], join: bed, friction: 0.1}"
RIGHT = "{name: right, kind: line, points: [[2, 0], {arc_to: [4, -1], radius: -4}], join: bed, friction: 0.1}"


@pytest.mark.parametrize("lines", [(LEFT, RIGHT), (RIGHT, LEFT)])
def test_lines_that_meet_are_joined(lines):
    scene = case(*lines, changes=["probes.forces=[bed]"]).scene()
    assert [one.wall.name for one in scene.walls] == ["floor", "bed"] and scene.probes == ("bed",)
    assert scene.wall("bed").points == ((0, 0), (2, 0), ArcTo((4, -1), -4)) and scene.own_laws["bed"].friction == 0.1
    assert not [text for text in scene.warnings if "tangential spring" not in text]


def test_lines_may_join_to_a_ring():
    scene = case(LEFT, "{name: b, kind: line, points: [[2, 0], [1, -2], [0, 0]], join: bed, friction: 0.1}").scene()
    assert scene.wall("bed").path.closed and scene.wall("bed").path.area == -2.0


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (RIGHT.replace("[2, 0]", "[2.3, 0]"), "walls[2].join: no line of join 'bed' begins at (2, 0) m, where 'left'"),
        (RIGHT.replace("[[2, 0], {arc_to: [4, -1], radius: -4}]", "[[4, -1], [2, 0]]"), "runs the other way"),
        (RIGHT.replace("friction: 0.1", "friction: 0.2"), "walls[2].friction: differs from that of 'left'"),
    ],
)
def test_lines_that_cannot_be_joined(other, words):
    with pytest.raises(CaseError) as error:
        case(LEFT, other).scene()
    assert words in str(error.value)


def test_a_part_of_a_joined_wall_is_no_wall():
    with pytest.raises(CaseError, match="'left' is a part of the joined wall 'bed'"):
        case(LEFT, RIGHT, changes=["probes.forces=[left]"]).scene()


# --- motions, contacts, gates, groups ---------------------------------------------------------------------------------


def test_motions_reach_the_scene():
    given = wall("{kind: rotate, rate: 30, until: 2}", stiffness="4e7", restitution=0.5)
    scene = case(given, changes=["initial.0.settle=0.5", "contact.friction=0"]).scene()
    motion = scene.walls[1].motion
    assert motion.about == pytest.approx((4.1, 1.0)) and motion.start == scene.settle_steps > 0
    assert motion.ease == pytest.approx(10 * pi / sqrt(4e7 / scene.mass)) and motion.time_step == scene.time_step
    assert motion.pose(scene.settle_steps).angle == 0 and not scene.rubs
    assert motion.pose(scene.steps).angle == pytest.approx(pi / 3)
    law = scene.own_laws["a"]
    assert law.stiffness == 4e7 and 0 < law.gamma_normal != scene.coefficients.gamma_normal_wall
    assert list(scene.own_laws) == ["a"]


def test_a_table_is_followed_as_it_is_given():
    """A measured motion of 0.25 m/s came 0.0125 m late: half of the default time of ease, 0.1 s there."""
    rows = [[0.0, 0, 0, 0], [0.4, 0.1, 0, 0], [0.8, 0.2, 0.3, 0], [1.2, 0.2, 0.3, 40]]
    motion = case(wall(f"{{kind: table, points: {rows}}}")).scene().walls[1].motion
    for t, *place in rows:
        assert motion.pose(motion.start + t / motion.time_step) == pytest.approx((*place[:2], radians(place[2])))
    assert motion.pose(motion.start + 0.2 / motion.time_step).x == pytest.approx(0.05)
    eased = case(wall(f"{{kind: table, ease: 0.1, points: {rows}}}")).scene().walls[1].motion
    lag = motion.pose(motion.start + 0.3 / motion.time_step).x - eased.pose(eased.start + 0.3 / eased.time_step).x
    assert lag == pytest.approx(0.25 * 0.1 / 2)


def test_about_is_what_the_motion_says_else_the_pivot():
    for motion, more, about in (
        ("{kind: rotate, rate: 1, about: [1, 2]}", {"pivot": "[5, 5]"}, (1, 2)),
        ("{kind: rotate, rate: 1}", {"pivot": "[5, 5]"}, (5, 5)),
    ):
        assert case(wall(motion, **more)).scene().walls[1].motion.about == about


def test_friction_of_one_wall_turns_discs():
    changes = ["contact.friction=0", "contact.rotation=true"]
    assert not case(changes=changes).scene().rotation
    scene = case("{name: a, kind: block, x: [4, 5], y: [0, 1], friction: 0.2}", changes=changes).scene()
    assert scene.rotation and scene.rubs and not any("friction" in text for text in scene.skipped)


def test_the_domain_holds_the_whole_way():
    low = case(wall("null")).scene().domain[0][1]
    assert case(wall("{kind: translate, velocity: [5, 0]}")).scene().domain[0][1] == low  # the floor is longer
    scene = case(wall("{kind: translate, velocity: [20, 0]}")).scene()
    assert scene.domain[0][1] > 64.2
    whole = way(scene.walls[1], 0.0, 3.0)
    assert whole[0] == pytest.approx((4.0, 64.2 - 10 * scene.walls[1].motion.ease), abs=1.0)
    turning = case(wall("{kind: rotate, rate: 360, about: [4, 0]}")).scene().walls[1]
    assert np.allclose(way(turning, 0.0, 3.0), 2 * [[-sqrt(4.04), sqrt(4.04)]] + np.array([[4.0], [0.0]]), atol=1e-12)
    assert largest_speed(turning, 0.0, 3.0) == pytest.approx(2 * pi * sqrt(4.04))


def test_walls_count_where_they_come_to_be():
    domain = "domain={x: [-20, 3], y: [-6, 19]}"
    assert len(case(wall("{kind: translate, velocity: [1, 0]}"), changes=[domain]).scene().walls) == 1
    assert len(case(wall("{kind: translate, velocity: [-1, 0]}"), changes=[domain]).scene().walls) == 2


@pytest.mark.parametrize(("gate", "speed"), [("{open_in: 2 s}", 0.5), ("{speed: 4 m/s}", 4.0)])
@pytest.mark.parametrize("settle", [0, 0.5])
def test_a_gate_rises_by_its_height(gate, speed, settle):
    scene = case(gate=gate, changes=[f"initial.0.settle={settle}", "probes.forces=[gate]"]).scene()
    one = scene.walls[1]
    assert one.wall.chains()[0].points == ((-1.0, 6.0), (-1.0, 7.0)) and scene.probes == ("gate",)
    assert one.at(scene.settle_steps).extent == ((-1.0, -1.0), (6.0, 7.0))
    assert one.at(scene.steps).extent[1] == pytest.approx((7.0, 8.0))
    assert largest_speed(one, 0.0, 3.0) == pytest.approx(speed)
    assert scene.gates == () and not any("'gate'" in text for text in scene.warnings)


@pytest.mark.parametrize("gate", ["{}", "{open_in: 2, speed: 3}", "{open_in: 0}", "soon"])
def test_gates_that_cannot_be(gate):
    with pytest.raises(CaseError, match=r"initial\[0\].gate"):
        case(gate=gate)


def test_groups_reach_the_scene():
    scene = case(
        "{name: a, kind: circle, centre: [4, 4], radius: 1}", changes=["probes.groups={both: [floor, a]}"]
    ).scene()
    assert scene.groups == (("both", ("floor", "a")),) and scene.probes == ("floor", "a")


@pytest.mark.parametrize(
    ("groups", "words"),
    [
        ("{both: [flor]}", "did you mean 'floor'"),
        ("{floor: [floor]}", "name of a wall"),
        ("{both: []}", "no wall"),
        ("{both: [floor, floor]}", "twice"),
        ("{a b: [floor]}", "not a usable name"),
    ],
)
def test_groups_that_cannot_be(groups, words):
    with pytest.raises(CaseError, match=words):
        case(changes=[f"probes.groups={groups}"]).scene()


def test_check_tells_motions_and_contacts():
    found = case(wall("{kind: translate, velocity: [0, 2], until: 3}", friction=0.1)).check()
    assert found.walls == {"a": "friction 0.1; motion translate from 0 s until 3 s, at up to 2 m/s"}
    assert "  a  friction 0.1; motion translate" in str(found) and found.as_data()["walls"] == found.walls


def test_a_wall_begins_with_kind_and_name():
    text = case("{name: a, kind: line, friction: 0.1, points: [[0, 0], {arc_to: [1, 0], radius: 2}]}").to_yaml()
    assert "- kind: line\n  name: a\n  friction: 0.1\n" in text and parse_case(text).to_yaml() == text


def test_the_schema_has_all_kinds():
    known = CaseFields.model_json_schema()["$defs"]
    assert list(known["Line"]["properties"])[:5] == ["kind", "name", "points", "sheet", "join"]
    assert {"Polygon", "Circle", "ArcTo", "Translate", "Lift"} <= known.keys()
    assert "from" in known["Translate"]["properties"] and known["Line"]["required"] == ["kind", "name"]


def test_walls_apart_are_not_held_against_each_other(monkeypatch):
    """Of a thousand walls of a drawing half a million pairs; those whose corners are apart are left out."""
    dice, seen = np.random.default_rng(5), []
    wall = [
        Line(f"w{n}", ((float(x), float(y)), (x + 2.0, float(y))))
        for n, (x, y) in enumerate(dice.integers(0, 12, (60, 2)))
    ]
    wall += [Plane("floor", "y", 0.0, "above"), Circle("pipe", (5.0, 5.0), 1.0)]
    faces = [one.faces for one in wall]
    every = [(i, j) for i in range(len(faces)) for j in range(i + 1, len(faces))]
    found = {pair for pair in every if flush(*(faces[n] for n in pair)) or over_each_other(*(faces[n] for n in pair))}
    near = pairs_that_may_touch(faces)
    assert found and found <= set(near) and near == sorted(near) and len(near) < len(every) / 3
    assert pairs_that_may_touch([]) == []

    monkeypatch.setattr("lammps_jump.case.walls.flush", lambda *pair: seen.append(pair))
    case(*(f"{{name: w{n}, kind: line, points: [[{n - 18}, 0], [{n - 17.5}, 0.5]]}}" for n in range(40))).check()
    assert seen == []
