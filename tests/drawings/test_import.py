# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawings become walls: closed forms of arcs, units, sides, and cases that keep their comments."""

import importlib
import json
from math import atan, ceil, cos, hypot, pi, sin

import ezdxf
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from made_up import INPUTS, call, examples

import lammps_jump as lj
from lammps_jump.drawings import LayerChoice, doubts, entries, into, read_drawing, with_walls, write_into
from lammps_jump.drawings.strokes import arc, bulged, pieces_of_arc, pieces_of_cubic
from lammps_jump.errors import CaseError, DumpError, SetupError
from lammps_jump.scene.shapes import ArcTo
from lammps_jump.scene.walls import Line

SVG = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
 width="200mm" height="100mm" viewBox="0 0 200 100">
<g inkscape:label="bed" id="g1"><path d="M 0 90 L 50 90 A 20 20 0 0 1 90 90 L 200 95"/></g>
<g id="pier" transform="translate(10,0)">
<circle cx="100" cy="50" r="5"/><rect x="10" y="10" width="20" height="10"/></g>
<path id="wave" d="M0 20 C 20 0 40 40 60 20"/><text x="1" y="2">a</text>
</svg>"""


@pytest.fixture
def dxf(tmp_path):
    """Writes a DXF drawing, in millimetres or in another unit of ezdxf's list, from what `draw` adds to it."""

    def write(draw, units=4):
        document = ezdxf.new("R2010")
        document.units = units
        draw(document.modelspace(), document)
        document.saveas(tmp_path / "a.dxf")
        return tmp_path / "a.dxf"

    return write


def written(path, name, text):
    (path / name).write_text(text)
    return path / name


def wall_of(entry):
    return yaml.safe_load(json.dumps(entry.wall))


@examples(60)
@given(
    st.floats(0.02, 3.9).map(lambda angle: np.tan(angle / 4)),
    st.sampled_from([1, -1]),
    st.floats(-pi, pi),
    st.floats(0.1, 1e3),
)
def test_a_bulge_is_the_arc_of_its_sagitta(bulge, side, direction, chord):
    """DXF reference: bulge = tan(angle/4) = sagitta over half a chord; above 0 it turns left."""
    end = chord * cos(direction), chord * sin(direction)
    stroke = bulged([(0.0, 0.0), end], [side * bulge])
    angle = 4 * atan(bulge)
    radius = chord / (2 * sin(angle / 2))
    assert stroke.points[0] == (0.0, 0.0) and stroke.points[-1] == end
    assert np.allclose(stroke.bends, side * radius, rtol=1e-9)
    top = end[0] / 2 + side * bulge * end[1] / 2, end[1] / 2 - side * bulge * end[0] / 2
    line = Line("a", (stroke.points[0], *(ArcTo(p, r) for p, r in zip(stroke.points[1:], stroke.bends, strict=True))))
    assert abs(line.distance(np.array([top[0]]), np.array([top[1]]))[0]) < 1e-7 * chord


@examples(60)
@given(st.floats(0.01, 2 * pi), st.floats(-pi, pi), st.sampled_from([1, -1]))
def test_arcs_are_cut_so_that_each_is_the_shorter_way(sweep, begin, side):
    stroke = arc((1.0, 2.0), 3.0, begin, side * sweep)
    chords = [hypot(*np.subtract(a, b)) for a, b in zip(stroke.points, stroke.points[1:], strict=False)]
    assert max(chords) < 2 * 3.0 * sin(0.475 * pi) * (1 + 1e-12)
    assert np.isclose(sum(2 * np.arcsin(np.array(chords) / 6)), sweep, rtol=1e-9)
    assert set(stroke.bends) == {side * 3.0}


@examples(40)
@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=4, max_size=4), st.floats(1e-3, 1e-1))
def test_straight_pieces_stay_within_the_tolerance(corners, tolerance):
    p = np.array(corners)

    def at(t):
        t = np.asarray(t)[..., None]
        return (1 - t) ** 3 * p[0] + 3 * (1 - t) ** 2 * t * p[1] + 3 * (1 - t) * t * t * p[2] + t**3 * p[3]

    count = ceil(pieces_of_cubic(corners, tolerance))
    ends = at(np.arange(count + 1) / count)
    middle = at((np.arange(count) + 0.5) / count)
    assert np.hypot(*(middle - (ends[:-1] + ends[1:]) / 2).T).max() <= tolerance * (1 + 1e-9)
    pieces = ceil(pieces_of_arc(2.0, 1.5, tolerance))
    assert 2.0 * (1 - cos(1.5 / (2 * pieces))) <= tolerance * (1 + 1e-9)


def test_layers_of_dxf_become_walls(dxf):
    def draw(space, document):
        document.layers.add("off").off()
        space.add_line((0, 0), (10000, 0), dxfattribs={"layer": "bed"})
        space.add_line((20000, -1000), (10000, 0), dxfattribs={"layer": "bed"})  # the other way round
        space.add_lwpolyline([(20000, -1000), (25000, -1000)], dxfattribs={"layer": "bed"})
        space.add_circle((12000, 3000), 500, dxfattribs={"layer": "pier"})
        space.add_lwpolyline([(5000, 1000), (6000, 1000), (6000, 2000)], close=True, dxfattribs={"layer": "weir crest"})
        space.add_spline([(0, 5000), (1000, 6000), (3000, 5000)], dxfattribs={"layer": "top"})
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": "off"})
        space.add_text("words")
        document.blocks.new("part").add_line((0, 0), (1000, 0))
        space.add_blockref("part", (2000, 8000), dxfattribs={"layer": "mirrored", "xscale": -1})

    drawing = read_drawing(dxf(draw))
    found = {entry.wall["name"]: entry for entry in entries(drawing)}
    assert wall_of(found["bed"])["points"] == [[0, 0], [10, 0], [20, -1], [25, -1]]
    assert "turned round" in found["bed"].facts[-1]
    assert "open, discs on its left: above it" in found["bed"].facts[2]
    assert found["pier"].wall == {"name": "pier", "kind": "circle", "centre": [12, 3], "radius": 0.5}
    assert found["weir_crest"].wall["kind"] == "polygon" and "closed, discs outside" in found["weir_crest"].facts[2]
    assert wall_of(found["mirrored"])["points"] == [[2, 8], [1, 8]]
    assert "off" not in found and "TEXT: 1 left out" in drawing.notes
    assert "layer 'off' is off or frozen in the drawing: left out" in drawing.notes
    assert any(note.startswith("SPLINE: 1 made into straight pieces, to within 0.001 m") for note in drawing.notes)


def test_the_user_says_side_names_and_layers(dxf):
    def draw(space, _):
        space.add_line((0, 0), (10000, 0), dxfattribs={"layer": "bed"})
        space.add_lwpolyline([(0, 0), (1000, 0), (1000, 1000)], close=True, dxfattribs={"layer": "tank"})

    drawing = read_drawing(dxf(draw), shift=(2.0, -1.0))
    choice = LayerChoice({"bed": "floor", "tank": "tank"}, reverse=["bed"], inside=["tank"])
    floor, tank = entries(drawing, choice)
    assert floor.wall == {"name": "floor", "kind": "line", "points": [[12, -1], [2, -1]]}
    assert "below it" in floor.facts[2] and tank.wall["discs"] == "inside"
    assert entries(drawing, LayerChoice({"bed": "bed"}, sheet=["bed"]))[0].wall["sheet"] is True
    with pytest.raises(CaseError, match="there is no layer 'wall'; it has 'bed', 'tank'"):
        entries(drawing, LayerChoice({"wall": "a"}))
    with pytest.raises(CaseError, match="two walls would be called 'a'"):
        entries(drawing, LayerChoice({"bed": "a", "tank": "a"}))
    with pytest.raises(CaseError, match="is no name of a wall"):
        entries(drawing, LayerChoice({"bed": "a b"}))


@pytest.mark.parametrize(("scale", "length"), [("mm", 10.0), ("m", 10000.0), ("0.5", 5000.0), ("ft", 3048.0)])
def test_a_drawing_without_a_unit_needs_one(dxf, scale, length):
    path = dxf(lambda space, _: space.add_line((0, 0), (10000, 2000)), units=0)
    with pytest.raises(CaseError, match=r"In metres it is 1e\+04 m wide and 2000 m high, in millimetres 10 m and 2 m"):
        read_drawing(path)
    assert read_drawing(path, scale=scale).extent()[0] == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("scale", ["", "parsec second", "-1", "1:0"])
def test_a_wrong_scale_is_refused(dxf, scale):
    with pytest.raises(CaseError, match=r"^--scale"):
        read_drawing(dxf(lambda space, _: space.add_line((0, 0), (1, 0))), scale=scale)


def test_a_scale_beside_the_unit_of_the_file(dxf):
    path = dxf(lambda space, _: space.add_line((0, 0), (100, 0)))
    assert read_drawing(path, scale="1:50").extent()[0] == pytest.approx(5.0)
    assert read_drawing(path, scale="cm").notes == ("$INSUNITS is 4, millimetres; --scale cm is taken instead",)


def test_an_svg_page_has_y_upwards_in_its_own_unit(tmp_path):
    path = written(tmp_path, "a.svg", SVG)
    drawing = read_drawing(path, scale="1:100")
    found = {entry.wall["name"]: entry for entry in entries(drawing)}
    assert wall_of(found["bed"])["points"] == [
        [0, 1], [5, 1], {"arc_to": [7, 3], "radius": -2}, {"arc_to": [9, 1], "radius": -2}, [20, 0.5],
    ]  # fmt: skip
    assert wall_of(found["pier_1"])["points"] == [[2, 9], [4, 9], [4, 8], [2, 8]]
    assert found["pier_2"].wall == {"name": "pier_2", "kind": "circle", "centre": [11, 5], "radius": 0.5}
    wave = np.array(found["wave"].wall["points"])
    t = np.linspace(0, 1, 2001)
    curve = np.stack([6 * t, 8 + 3 * 2 * (1 - t) ** 2 * t - 3 * 2 * (1 - t) * t * t]).T  # control points 2 m off
    on_line = np.interp(curve[:, 0], wave[:, 0], wave[:, 1])
    assert np.abs(on_line - curve[:, 1]).max() <= 1e-3 and 20 < len(wave) < 200
    assert doubts(list(found.values()), 20.0) == ["pier_1 and wave cross at (2, 8.444) m"]
    with pytest.raises(CaseError, match="its width is in pixels, which is no length"):
        read_drawing(written(tmp_path, "b.svg", SVG.replace("200mm", "200").replace("100mm", "100")))


@pytest.mark.parametrize("text", ["", "<html/>", "<svg", "<svg><path d='M'/></svg>"])
def test_what_is_no_drawing_is_refused(tmp_path, text):
    for ending in ("svg", "dxf", "geojson", "csv"):
        with pytest.raises(CaseError, match=f"a.{ending}"):
            read_drawing(written(tmp_path, f"a.{ending}", text), scale="m")


def geojson(*places):
    lines = [
        {"type": "Feature", "properties": {"name": f"line {n}"}, "geometry": {"type": "LineString", "coordinates": one}}
        for n, one in enumerate(places)
    ]
    point = {"type": "Feature", "properties": None, "geometry": {"type": "Point", "coordinates": [0, 0]}}
    return json.dumps({"type": "FeatureCollection", "features": [*lines, point]})


def test_lines_of_geojson(tmp_path):
    flat = written(tmp_path, "a.geojson", geojson([[0, 1], [4, 1]], [[4, 1.01], [8, 2]]))
    with pytest.raises(CaseError, match=r"degrees of longitude and latitude.* In metres it is 8 m wide"):
        read_drawing(flat)
    drawing = read_drawing(flat, scale="m")
    found = entries(drawing)
    assert [entry.wall["name"] for entry in found] == ["line_0", "line_1"] and "Point: 1 left out" in drawing.notes
    assert doubts(found, 8.0) == ["ends of line_0 and line_1 nearly meet: its gap at (4, 1) m is 0.01 m"]
    high = written(tmp_path, "b.geojson", geojson([[0, 0, 5], [3, 4, 6], [3, 10, 5]]))
    with pytest.raises(CaseError, match="is it drawn in plan, so that x is the way along it and y the height"):
        read_drawing(high, scale="m")
    assert wall_of(entries(read_drawing(high, scale="m", along=True))[0])["points"] == [[0, 5], [5, 6], [11, 5]]
    with pytest.raises(CaseError, match="has no heights"):
        read_drawing(flat, scale="m", along=True)
    with pytest.raises(CaseError, match="--along is for GeoJSON"):
        read_drawing(written(tmp_path, "a.svg", SVG), along=True)


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("chainage (m),level (m)\n0,1\n# a remark\n10,2\n10,2\n", [[0, 1], [10, 2]]),
        ("level_ft;point;chainage_ft\n10;a;0\n20;b;100\n", [[0, 3.048], [30.48, 6.096]]),
        ("Station [km]\tElevation [km]\n0\t0.001\n0.01\t0.002\n", [[0, 1], [10, 2]]),
    ],
)
def test_a_survey_is_a_line(tmp_path, text, points):
    (entry,) = entries(read_drawing(written(tmp_path, "river bed.csv", text)))
    assert wall_of(entry) == {"name": "river_bed", "kind": "line", "points": points}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("chainage,level\n0,1\n1,2\n", "its unit is not known.*the head of the table has no unit"),
        ("chainage (m),level (ft)\n0,1\n1,2\n", r":1: chainage is in m and level in ft; give both one unit"),
        ("chainage (m),depth (m)\n0,1\n1,2\n", r":1: columns .*: 0 of them are a level"),
        ("chainage (s),level (s)\n0,1\n1,2\n", r":1: .*expected"),
        ("chainage (m),level (m)\n0,1\n1,two\n", r":3: 'two' under level \(m\) is no number"),
        ("chainage (m),level (m)\n0,1\n", "1 row of numbers"),
    ],
)
def test_a_survey_that_could_be_meant_in_two_ways_is_refused(tmp_path, text, said):
    with pytest.raises(CaseError, match=said):
        read_drawing(written(tmp_path, "bed.csv", text))


BED = "chainage (m),level (m)\n0,-2\n60,-2\n"


def test_walls_are_added_to_a_case_and_comments_stay(monkeypatch, capsys, tmp_path):
    case = tmp_path / "case.yaml"
    before = (INPUTS / "dam_break.yaml").read_text()
    case.write_text(before)
    bed = written(tmp_path, "bed.csv", BED)
    status, out, err = call(monkeypatch, capsys, "import", bed, "--into", case)
    assert status == 0 and "{name: bed, kind: line, points: [[0, -2], [60, -2]]}" in out and "added to" in err
    after = case.read_text()
    assert set(before.splitlines()) <= set(after.splitlines())
    assert len(after.splitlines()) == len(before.splitlines()) + 2
    assert lj.load_case(case).fields.walls[-1].name == "bed"
    status, _, err = call(monkeypatch, capsys, "import", bed, "--into", case)
    assert status == 2 and "there is a wall 'bed' already" in err and case.read_text() == after


@pytest.fixture
def bed(tmp_path):
    """Walls of a surveyed bed."""
    return entries(read_drawing(written(tmp_path, "bed.csv", BED)))


def test_a_link_is_followed_and_stays(tmp_path, bed):
    case = written(tmp_path, "case.yaml", (INPUTS / "dam_break.yaml").read_text())
    case.chmod(0o600)
    (tmp_path / "link.yaml").symlink_to("case.yaml")
    write_into(tmp_path / "link.yaml", bed)
    assert (tmp_path / "link.yaml").is_symlink() and "name: bed" in case.read_text()
    assert case.stat().st_mode & 0o777 == 0o600


def test_ends_of_lines_stay(tmp_path, bed):
    rows = (INPUTS / "dam_break.yaml").read_text().splitlines()
    before = "".join(row + ("\n" if number % 3 else "\r\n") for number, row in enumerate(rows))
    case = tmp_path / "case.yaml"
    case.write_bytes(before.encode())
    write_into(case, bed)
    after = case.read_bytes().decode().splitlines(keepends=True)
    assert [row for row in after if "bed" not in row] == before.splitlines(keepends=True)


@pytest.mark.fault("other programs that write the same file")
def test_what_another_program_writes_meanwhile_stays(tmp_path, monkeypatch, bed):
    case = written(tmp_path, "case.yaml", (INPUTS / "dam_break.yaml").read_text())
    real, times = into.with_walls, []

    def slow(*given):
        if len(times) < 2:
            times.append(1)
            case.write_text(f"{case.read_text()}# mine {len(times)}\n")
        return real(*given)

    monkeypatch.setattr(into, "with_walls", slow)
    write_into(case, bed)
    assert case.read_text().endswith("# mine 1\n# mine 2\n") and "name: bed" in case.read_text()


@pytest.mark.fault("other programs that write the same file")
def test_a_case_that_changes_all_the_time_is_left(tmp_path, monkeypatch, bed):
    case = written(tmp_path, "case.yaml", (INPUTS / "dam_break.yaml").read_text())
    monkeypatch.setattr(into, "change_text", lambda *_: None)
    with pytest.raises(DumpError, match="another program changes it all the time; nothing was added"):
        write_into(case, bed)


def test_a_case_that_is_read_only_is_left(monkeypatch, capsys, tmp_path):
    case = written(tmp_path, "case.yaml", (INPUTS / "dam_break.yaml").read_text())
    case.chmod(0o444)
    status, _, err = call(monkeypatch, capsys, "import", written(tmp_path, "bed.csv", BED), "--into", case)
    assert status == 2 and "case.yaml: cannot be written (it is read-only); correct the permissions" in err
    assert "name: bed" not in case.read_text() and case.stat().st_mode & 0o777 == 0o444


@pytest.mark.parametrize(
    "walls",
    [
        "walls: []  # none yet\n",
        "walls:\n",
        "",
        "walls:\n- {name: a, kind: line, points: [[0, 0], [1, 0]]}  # one\n# end",
        "walls: [\n  # none yet\n]  # end\n",
        "'walls'  :   # those of the channel\n",
        "walls: &all   # those of the channel\n    - {name: a, kind: line, points: [[0, 0], [1, 0]]}  # one\n",
        "walls: !!seq\n  -\n    name: a\n    kind: line\n    points:\n    - [0, 0]\n    - - 1\n      - -0.5\n",
    ],
)
@pytest.mark.parametrize(
    "around", ["name: a\n{}\nrun: {{duration: 1 s}}\n", "---\nname: a\nrun: {{duration: 1 s}}\n{}...\n# z"]
)
def test_walls_are_put_in_wherever_there_is_a_place(tmp_path, walls, around):
    found = entries(read_drawing(written(tmp_path, "bed.csv", BED)))
    before = around.format(walls)
    text = with_walls(before, found)
    data = yaml.safe_load(text)
    words = ("# one", "# end", "# none yet", "# those of the channel", "# z")
    assert [text.count(one) for one in words] == [before.count(one) for one in words]
    assert data["walls"][-1]["name"] == "bed" and data["run"] == {"duration": "1 s"} and data["name"] == "a"


def test_a_case_that_would_be_refused_stays_as_it_is(tmp_path):
    case = written(tmp_path, "case.yaml", (INPUTS / "dam_break.yaml").read_text())
    crossed = "chainage (m),level (m)\n0,0\n10,0\n5,5\n5,-5\n"
    drawing = read_drawing(written(tmp_path, "bed.csv", crossed))
    found = entries(drawing)
    assert "the wall meets itself" in doubts(found, 10.0)[0]
    before = case.read_text()
    with pytest.raises(CaseError, match="meets itself"):
        write_into(case, found)
    assert case.read_text() == before
    with pytest.raises(CaseError, match=":1: the fields stand in braces"):
        with_walls("{name: a}\n", entries(read_drawing(written(tmp_path, "bed.csv", BED))))
    with pytest.raises(CaseError, match=":2: walls: stand in brackets"):
        with_walls("name: a\nwalls: [{name: b}]\n", entries(read_drawing(written(tmp_path, "bed.csv", BED))))


def test_a_package_that_is_missing_is_named(monkeypatch, capsys, tmp_path):
    def missing(name):
        raise ImportError(f"No module named '{name}'", name=name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(SetupError, match=r"ezdxf reads such drawings.*pip install 'lammps-jump\[drawings\]'"):
        read_drawing(written(tmp_path, "a.dxf", "0"))


def test_another_kind_of_file_is_refused(monkeypatch, capsys, tmp_path):
    for name in ("a.dwg", "gone.dxf"):
        status, _, err = call(monkeypatch, capsys, "import", tmp_path / name)
        assert status == 2 and name in err and "Traceback" not in err
