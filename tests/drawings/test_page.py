# SPDX-License-Identifier: GPL-2.0-or-later
"""Each sentence of docs/howto/drawings.md is a test here, and each test names its sentences."""

import json
import re
from itertools import pairwise
from math import pi
from pathlib import Path
from time import process_time

import ezdxf
import numpy as np
import pytest
from ezdxf.math import BSpline
from made_up import INPUTS, call

import lammps_jump as lj
from lammps_jump.drawings import LayerChoice, doubts, entries, read_drawing, yaml_text
from lammps_jump.drawings.entries import MOST_WALLS
from lammps_jump.drawings.strokes import MOST_PARTS, MOST_POINTS
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.foreign import MOST_MEMORY, MOST_SECONDS
from lammps_jump.scene.tracks import MOST_ROWS

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "drawings.md").read_text()
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="{}" height="{}" viewBox="0 0 100 100">{}</svg>'
SAID: list[str] = []


def says(*begins):
    """Name the sentences of the page, by their first words, that a test proves."""
    SAID.extend(begins)
    return lambda test: test


def sentences():
    """All that the page says: sentences, rows of tables, lines of commands."""
    code = re.findall(r"```(\w+)\n(.*?)```", PAGE, re.S)
    found = [line for kind, text in code if kind == "sh" for line in text.splitlines()]
    text = re.sub(r"```.*?```", "\n\n", PAGE, flags=re.S)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    found += [row for row in rows if not re.match(r"\|[-|]+$|\| (file|the discs)", row)]
    plain = "\n".join(line for line in text.splitlines() if not line.startswith(("|", "#")))
    for part in re.split(r"\n\s*\n|\n- ", plain):
        found += re.split(r"(?<=[.:])\s+(?=[A-Z])", " ".join(part.split()).removeprefix("- "))
    return [one for one in found if one]


def test_each_sentence_has_a_test():
    every = sentences()
    assert [one for one in every if sum(one.startswith(begin) for begin in SAID) != 1] == []
    assert [begin for begin in SAID if not any(one.startswith(begin) for one in every)] == []


@pytest.fixture
def dxf(tmp_path):
    """Writes a DXF drawing in metres of what `draw` adds to its model space."""

    def write(draw, name="a.dxf", units=6):
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = units
        draw(document.modelspace(), document)
        document.saveas(tmp_path / name)
        return tmp_path / name

    return write


@pytest.fixture
def written(tmp_path):
    def write(name, text):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def svg(written, inside, width="100mm", height="100mm"):
    return written("a.svg", SVG.format(width, height, inside))


def walls(path, choice=None, **options):
    """Walls of a drawing by their names, and what is noted."""
    drawing = read_drawing(path, **options)
    found = entries(drawing, choice)
    return {entry.wall["name"]: entry.wall for entry in found}, "\n".join(drawing.notes)


def bed_level(space, _):
    space.add_lwpolyline(
        [(0, 0, 0), (10, 0, 0), (20, -1, 0), (25, -1, -0.4), (28, -1, 0), (30, -1, 0)], format="xyb",
        dxfattribs={"layer": "bed level"},
    )  # fmt: skip


# --- what it is for, and what is read ---------------------------------------------------------------------------------


@says(
    "A bed that was surveyed",
    "lammps-jump import weir.dxf  ",
    'lammps-jump import weir.dxf --layer "bed level=bed" --into my_case.yaml',
    "lammps-jump import river.csv --shift 0,-102.5",
    "lammps-jump import section.svg --scale 1:100",
    "`lammps-jump preview my_case.yaml` draws the result",
)
def test_the_commands_of_the_page(dxf, written, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    dxf(bed_level, "weir.dxf")
    written("river.csv", "chainage (m),level (m)\n0,102.5\n8,102\n")
    written("section.svg", SVG.format("100mm", "100mm", '<path id="bed" d="M0 90 L100 90"/>'))
    (tmp_path / "my_case.yaml").write_text((INPUTS / "dam_break.yaml").read_text())
    status, out, _ = call(monkeypatch, capsys, "import", "weir.dxf")
    assert status == 0 and out.startswith("walls:\n  # bed_level, layer 'bed level'")
    given = "import", "weir.dxf", "--layer", "bed level=bed", "--into", "my_case.yaml", "--shift", "0,-5"
    assert call(monkeypatch, capsys, *given)[0] == 0
    assert lj.load_case("my_case.yaml").fields.walls[-1].name == "bed"
    status, out, _ = call(monkeypatch, capsys, "import", "river.csv", "--shift", "0,-102.5")
    assert status == 0 and "points: [[0, 0], [8, -0.5]]" in out
    status, out, _ = call(monkeypatch, capsys, "import", "section.svg", "--scale", "1:100")
    assert status == 0 and "points: [[0, 1], [10, 1]]" in out
    assert call(monkeypatch, capsys, "preview", "my_case.yaml", "--out", "drawn")[0] == 0
    assert list((tmp_path / "drawn").iterdir())


@says("| DXF |")
def test_what_of_dxf_is_read(dxf):
    def draw(space, document):
        space.add_line((0, 0), (4, 0), dxfattribs={"layer": "line"})
        space.add_lwpolyline([(0, 1, 1), (2, 1, 0)], format="xyb", dxfattribs={"layer": "bulge"})
        space.add_polyline2d([(0, 2), (1, 2), (1, 3)], dxfattribs={"layer": "old"})
        space.add_arc((0, 0), 5, 0, 90, dxfattribs={"layer": "arc"})
        space.add_circle((9, 9), 1, dxfattribs={"layer": "circle"})
        space.add_spline([(0, 0), (1, 1), (3, 0)], dxfattribs={"layer": "spline"})
        space.add_ellipse((0, 0), (3, 0), 0.5, dxfattribs={"layer": "ellipse"})
        pile = document.blocks.new("pile")
        pile.add_lwpolyline([(0, 0), (0.5, 0), (0.5, 2), (0, 2)], close=True)
        space.add_blockref("pile", (0, 0), dxfattribs={"layer": "one"})
        space.add_blockref("pile", (0, 5), dxfattribs={"layer": "many"}).grid((2, 3), (4, 3))

    found, _ = walls(dxf(draw))
    assert found["line"]["points"] == [[0, 0], [4, 0]] and found["old"]["points"] == [[0, 2], [1, 2], [1, 3]]
    assert [point["radius"] for point in found["bulge"]["points"][1:]] == [1, 1]  # a half circle, in two parts
    assert found["arc"]["points"] == [[5, 0], {"arc_to": [0, 5], "radius": 5}]
    assert found["circle"] == {"name": "circle", "kind": "circle", "centre": [9, 9], "radius": 1}
    assert len(found["spline"]["points"]) > 10 and found["ellipse"]["kind"] == "polygon"
    assert found["one"]["points"] == [[0, 0], [0.5, 0], [0.5, 2], [0, 2]]
    lowest = [found[f"many_{number}"]["points"][0] for number in range(1, 7)]
    assert sorted(lowest) == [[x, y] for x in (0, 3, 6) for y in (5, 9)]


METRES = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 1e-3, 5: 1e-2, 6: 1, 7: 1e3, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144, 11: 1e-10,
    12: 1e-9, 13: 1e-6, 14: 0.1, 15: 10, 16: 100, 21: 1200 / 3937, 22: 100 / 3937, 23: 3600 / 3937,
    24: 6336000 / 3937,
}  # fmt: skip
"""Metres of the units of `$INSUNITS`; those of astronomy are too large for a wall."""


@pytest.mark.parametrize("code", METRES)
def test_each_unit_of_a_header(dxf, code):
    long = 1.0 / METRES[code]
    found, _ = walls(dxf(lambda space, _: space.add_line((0, 0), (3 * long, long)), units=code))
    assert found["layer_0"]["points"][1] == pytest.approx([3, 1], rel=1e-8)
    feet, note = walls(dxf(lambda space, _: space.add_line((0, 0), (30, 1)), units=code), scale="ft")
    assert feet["layer_0"]["points"][1] == pytest.approx([9.144, 0.3048])
    assert code == 2 or f"$INSUNITS is {code}" in note


@pytest.mark.parametrize("code", [0, 25, 99, -1, 17, 18, 19, 20])
def test_what_is_no_unit_of_a_wall_is_refused(dxf, code):
    with pytest.raises(CaseError, match=r"its unit is not known|is farther than 1e\+07 m"):
        read_drawing(dxf(lambda space, _: space.add_line((0, 0), (1, 1)), units=code))


@says("A binary DXF file is refused")
def test_a_binary_file_is_refused(dxf):
    path = dxf(bed_level)
    ezdxf.readfile(path).saveas(path, fmt="bin")
    with pytest.raises(CaseError, match="is a binary DXF file; save it as text"):
        read_drawing(path)


@says("| SVG |")
def test_what_of_svg_is_read(written):
    inside = """<line id="line" x1="0" y1="100" x2="40" y2="90"/><path id="arc" d="M50 50 A 10 10 0 0 1 60 60"/>
    <circle id="circle" cx="20" cy="20" r="5"/><rect id="rect" x="70" y="70" width="10" height="5"/>
    <polygon id="polygon" points="0,0 5,0 5,5"/><path id="curve" d="M0 60 Q 10 40 20 60"/>
    <use id="again" href="#rect" x="-10" y="-50"/>"""
    found, note = walls(svg(written, inside))
    assert found["line"]["points"] == [[0, 0], [0.04, 0.01]]  # y runs upwards
    assert found["arc"]["points"] == [[0.05, 0.05], {"arc_to": [0.06, 0.04], "radius": -0.01}]
    assert found["circle"]["radius"] == 0.005 and found["circle"]["centre"] == [0.02, 0.08]
    assert found["rect"]["points"][0] == [0.07, 0.03] and found["again"]["points"][0] == [0.06, 0.08]
    assert found["polygon"]["kind"] == "polygon" and "Bézier curve: 1 made into straight pieces" in note
    for width, height, size in (
        ("5cm", "5cm", 0.05), ("40Q", "40Q", 0.01), ("2in", "2in", 0.0508), ("72pt", "72pt", 0.0254),
        ("6pc", "6pc", 0.0254),
        ("10mm", "", 0.01), ("", "10mm", 0.01), ("100%", "10mm", 0.01), ("10mm", "100%", 0.01), ("10mm", "20mm", 0.01),
        ("20mm", "10mm", 0.01),
    ):  # fmt: skip
        page = SVG.format(width, height, inside).replace(' width=""', "").replace(' height=""', "", 1)
        found, _ = walls(written("b.svg", page))
        start, end = found["line"]["points"]
        assert end[0] - start[0] == pytest.approx(0.4 * size), (width, height)


WITHOUT_WIDTH = {
    "a stroke": '<svg xmlns="http://www.w3.org/2000/svg" stroke-width="3mm" viewBox="0 0 9 9">{}</svg>',
    "a comment": '<!-- <svg width="9mm"> --><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{}</svg>',
    "a share": '<svg xmlns="http://www.w3.org/2000/svg" width="100%" height="50%" viewBox="0 0 9 9">{}</svg>',
    "pixels": '<svg xmlns="http://www.w3.org/2000/svg" width="100" height="50px" viewBox="0 0 9 9">{}</svg>',
    "a part": '<svg xmlns="http://www.w3.org/2000/svg"><svg width="9mm" height="9mm">{}</svg></svg>',
}


@pytest.mark.parametrize("page", WITHOUT_WIDTH.values(), ids=WITHOUT_WIDTH)
def test_a_width_elsewhere_is_none_of_the_page(written, page):
    with pytest.raises(CaseError, match="its unit is not known"):
        read_drawing(written("a.svg", page.format('<path d="M0 0L1 1"/>')))


@says("| GeoJSON |")
def test_what_of_geojson_is_read(written):
    ring = [[0, 0], [1, 0], [1, 1], [0, 0]]
    parts = [{"type": "LineString", "coordinates": [[0, 1], [5, 2]]}, {"type": "Polygon", "coordinates": [ring]}]
    path = written("a.geojson", json.dumps({"type": "GeometryCollection", "geometries": parts}))
    with pytest.raises(CaseError, match="--scale m"):
        read_drawing(path)
    found, _ = walls(path, scale="m")
    assert found["drawing_1"]["points"] == [[0, 1], [5, 2]] and found["drawing_2"]["kind"] == "polygon"
    plan = {"type": "LineString", "coordinates": [[0, 0, 5], [3, 4, 6]]}
    found, _ = walls(written("b.geojson", json.dumps(plan)), scale="m", along=True)
    assert found["drawing"]["points"] == [[0, 5], [5, 6]]


@says("| CSV |")
def test_what_of_a_table_is_read(written):
    found, _ = walls(written("a.csv", "point,chainage (m),level (m)\nA,0,1\nB,10,2\n"))
    assert found["a"]["points"] == [[0, 1], [10, 2]]
    with pytest.raises(CaseError, match="the head of the table has no unit"):
        read_drawing(written("b.csv", "chainage,level\n0,1\n1,2\n"))


@says("DXF needs `ezdxf`")
@pytest.mark.parametrize(("name", "package"), [("a.dxf", "ezdxf"), ("a.svg", "svgelements")])
def test_a_package_that_is_needed_is_named(written, monkeypatch, name, package):
    def missing(name):
        raise ImportError(name=name)

    monkeypatch.setattr("importlib.import_module", missing)
    with pytest.raises(SetupError, match=rf"{package} reads such.*pip install 'lammps-jump\[drawings\]'"):
        read_drawing(written(name, "0"))


def apart(curve, points):
    """Largest distance of points of a curve from the straight pieces that stand for it."""
    starts, ways = points[:-1], np.diff(points, axis=0)
    square = np.maximum((ways**2).sum(axis=1), 1e-300)
    share = np.clip(((curve[:, None] - starts) * ways).sum(axis=2) / square, 0, 1)
    return np.hypot(*np.moveaxis(curve[:, None] - starts - share[..., None] * ways, 2, 0)).min(axis=1).max()


def spline_of(control, degree, weights):
    return BSpline(control, order=degree + 1, weights=weights)


@says("Straight pieces lie within 1 mm")
@pytest.mark.parametrize("size", [0.002, 1.0, *(pytest.param(size, marks=pytest.mark.long) for size in (50.0, 3000.0))])
def test_straight_pieces_lie_within_a_millimetre(dxf, written, size):
    """Splines of several degrees and with weights, ellipses; Bézier curves and arcs of SVG that are skewed."""
    dice, many = np.random.default_rng(3), np.linspace(0, 1, 1501)
    shapes = dice.uniform(0, size, (4, 6, 2))
    kinds = [(3, None), (2, None), (5, None), (3, [1, 5, 0.2, 3, 1, 1])]

    def draw(space, _):
        for number, (control, (degree, weights)) in enumerate(zip(shapes, kinds, strict=True)):
            space.add_spline(dxfattribs={"layer": f"s{number}"}).apply_construction_tool(
                spline_of(control, degree, weights)
            )
        space.add_ellipse((0, 0), (size, size / 3), 0.3, 0.5, 4, dxfattribs={"layer": "e"})

    found, _ = walls(dxf(draw))
    for number, (control, (degree, weights)) in enumerate(zip(shapes, kinds, strict=True)):
        curve = spline_of(control, degree, weights)
        exact = np.array([(p.x, p.y) for p in curve.points(many * curve.max_t)])
        assert apart(exact, np.array(found[f"s{number}"]["points"])) < 1.001e-3
    t = 0.5 + 3.5 * many
    exact = np.outer(np.cos(t), (size, size / 3)) + np.outer(np.sin(t), (-0.3 * size / 3, 0.3 * size))
    assert apart(exact, np.array(found["e"]["points"])) < 1.001e-3

    inside = f'<g transform="skewX(20)"><path id="c" d="M0 0C{size} 0 0 {size} {size} {size}"/>'
    inside += f'<path id="a" d="M0 0A{size} {size / 2} 0 0 1 {size} {size / 2}"/></g>'
    page = SVG.format(f"{1000 * size}mm", f"{1000 * size}mm", inside).replace("0 0 100 100", f"0 0 {size} {size}")
    found, _ = walls(written("a.svg", page))
    t, turn = many[:, None], 0.5 * pi * (many - 1)
    cubic = 3 * (1 - t) ** 2 * t * [size, 0] + 3 * (1 - t) * t**2 * [0, size] + t**3 * [size, size]
    quarter = np.column_stack([size * np.cos(turn), size / 2 * (1 + np.sin(turn))])
    for name, drawn in (("c", cubic), ("a", quarter)):
        exact = np.column_stack([drawn[:, 0] + np.tan(np.radians(20)) * drawn[:, 1], size - drawn[:, 1]])
        assert apart(exact, np.array(found[name]["points"])) < 1.001e-3


# --- what comes out ---------------------------------------------------------------------------------------------------


@says("Each layer is one wall.", "Pieces whose ends meet are joined.", "A layer of several")
def test_layers_and_outlines(dxf):
    def draw(space, _):
        space.add_line((0, 0), (1, 0), dxfattribs={"layer": "weir"})
        space.add_line((2, 1), (1, 0), dxfattribs={"layer": "weir"})
        space.add_line((0, 5), (1, 5), dxfattribs={"layer": "weir"})
        space.add_circle((9, 9), 1, dxfattribs={"layer": "weir"})
        space.add_line((0, 0), (0, 3), dxfattribs={"layer": "post"})

    found, _ = walls(dxf(draw))
    assert found["weir_1"]["points"] == [[0, 0], [1, 0], [2, 1]] and found["weir_2"]["points"] == [[0, 5], [1, 5]]
    assert found["weir_3"]["kind"] == "circle" and found["post"]["points"] == [[0, 0], [0, 3]]


def test_where_three_ends_meet_nothing_is_joined(dxf):
    ends = [(1, 0), (0, 1), (-1, -1)]
    found, _ = walls(dxf(lambda space, _: [space.add_line((0, 0), end) for end in ends]))
    assert len(found) == 3


@says("In SVG the outermost group")
def test_layers_of_svg(written):
    inside = '<g id="bed"><g id="inner"><path d="M0 0L9 9"/></g></g><path id="own" d="M0 9L9 0"/><path d="M1 0L2 0"/>'
    assert set(walls(svg(written, inside))[0]) == {"bed", "own", "drawing"}


@says("A name that YAML would read as a number")
@pytest.mark.parametrize(("layer", "name"), [
    ("0", "layer_0"), ("1", "layer_1"), ("true", "layer_true"), ("null", "layer_null"), ("1e5", "layer_1e5"),
    ("~", "wall"), ("yes", "layer_yes"), ("0x1", "layer_0x1"), ("2024_01_01", "layer_2024_01_01"), ("No 5", "No_5"),
    ("Sohle", "Sohle"), ("a\n  - {name: b}", "a_name_b"), ("\u200f", "drawing"), ("bed\u2028x: 1", "bed_x_1"),
    (300 * "b", 64 * "b"),
])  # fmt: skip
def test_names_that_yaml_and_cases_take(written, tmp_path, monkeypatch, capsys, layer, name):
    feature = {"type": "Feature", "properties": {"name": layer}}
    feature["geometry"] = {"type": "LineString", "coordinates": [[0, -3], [10, -2]]}
    path = written("a.geojson", json.dumps(feature))
    case = written("case.yaml", (INPUTS / "dam_break.yaml").read_text())
    status, _, said = call(monkeypatch, capsys, "import", path, "--scale", "m", "--into", case)
    assert status == 0, said
    assert lj.load_case(case).fields.walls[-1].name == name
    given = f"{read_drawing(path, scale='m').layers[0].name}=0"  # a user may call it what YAML takes for a number
    status, out, said = call(monkeypatch, capsys, "import", path, "--scale", "m", "--into", case, "--layer", given)
    assert status == 0, said
    assert "name: '0'" in out and lj.load_case(case).fields.walls[-1].name == "0"


@says("A comment before each wall", "It also tells where the discs are")
def test_the_example_of_the_page(dxf):
    found = entries(read_drawing(dxf(bed_level)), LayerChoice({"bed level": "bed"}))
    assert f"```yaml\nwalls:\n{yaml_text(found)}```" in PAGE


@says("| below a bed", "| outside of a tank", "| on one side of a thin plate")
def test_options_of_sides(dxf):
    def draw(space, _):
        space.add_line((9, 0), (0, 0), dxfattribs={"layer": "bed level"})
        space.add_lwpolyline([(0, 1), (1, 1), (1, 2)], close=True, dxfattribs={"layer": "tank"})
        space.add_line((5, 1), (5, 2), dxfattribs={"layer": "plate"})

    path = dxf(draw)
    before, _ = walls(path)
    assert (
        before["bed_level"]["points"][0] == [9, 0] and "discs" not in before["tank"] and "sheet" not in before["plate"]
    )
    after, _ = walls(path, LayerChoice(reverse=["bed level"], inside=["tank"], sheet=["plate"]))
    assert after["bed_level"]["points"][0] == [0, 0] and after["tank"]["discs"] == "inside" and after["plate"]["sheet"]


@says("Notes tell what was left out", "They also tell ends")
def test_notes_and_doubts(dxf):
    def draw(space, _):
        space.add_line((0, 0), (10, 0), dxfattribs={"layer": "bed"})
        space.add_line((10.05, 0), (20, 0), dxfattribs={"layer": "apron"})
        space.add_line((5, -1), (5, 1), dxfattribs={"layer": "pile"})
        space.add_lwpolyline([(0, 5), (4, 5), (4, 7), (2, 4)], dxfattribs={"layer": "loop"})
        space.add_text("words")
        space.add_lwpolyline([(0, 9), (4, 9), (4, 11), (0, 11)], close=True, dxfattribs={"layer": "tank"})
        space.add_line((3, 10), (6, 10), dxfattribs={"layer": "pipe"})

    drawing = read_drawing(dxf(draw))
    told = doubts(entries(drawing), max(drawing.extent()))
    assert drawing.notes == ("TEXT: 1 left out",)
    assert told[0].startswith("loop: the wall meets itself")
    assert told[1:] == [
        "ends of bed and apron nearly meet: its gap at (10, 0) m is 0.05 m",
        "bed and pile cross at (5, 0) m",
        "tank and pipe cross at (4, 10) m",
    ]


# --- nothing is guessed -----------------------------------------------------------------------------------------------


@says("A drawing without a unit", "The message tells how large it is")
def test_a_drawing_without_a_unit(dxf):
    path = dxf(lambda space, _: space.add_line((0, 0), (3000, 500)), units=0)
    with pytest.raises(CaseError, match=r"In metres it is 3000 m wide and 500 m high, in millimetres 3 m and 0\.5 m"):
        read_drawing(path)
    for scale, metres in (("mm", 1e-3), ("ft", 0.3048), ("0.5", 0.5)):
        assert walls(path, scale=scale)[0]["layer_0"]["points"][1] == pytest.approx([3000 * metres, 500 * metres])


@says("`--scale 1:100` is for a page")
def test_a_page_that_is_reduced(written):
    assert walls(svg(written, '<path id="a" d="M0 100L10 100"/>'), scale="1:100")[0]["a"]["points"] == [[0, 0], [1, 0]]


@says("Layers that are off or frozen", "Hidden parts are left out")
def test_what_is_off_frozen_or_hidden(dxf, written):
    def draw(space, document):
        document.layers.add("off").off()
        document.layers.add("frozen").freeze()
        part = document.blocks.new("part")
        part.add_line((0, 0), (1, 0), dxfattribs={"layer": "bed"})
        part.add_line((0, 0), (0, 1))  # on layer 0: on that of the insert
        for layer, y in (("off", 0), ("frozen", 5), ("on", 9)):
            space.add_line((3, y), (4, y), dxfattribs={"layer": layer})
            space.add_blockref("part", (0, y), dxfattribs={"layer": layer})
        space.add_line((7, 7), (8, 8), dxfattribs={"layer": "on", "invisible": 1})

    found, note = walls(dxf(draw))
    ends = sorted(tuple(map(tuple, wall["points"])) for wall in found.values())
    assert ends == [((0, 0), (1, 0)), ((0, 9), (0, 10)), ((0, 9), (1, 9)), ((3, 9), (4, 9))]
    assert "layer 'off' is off or frozen" in note and "layer 'frozen' is off" in note and "invisible LINE: 1" in note

    hidden = """<style>.gone {display: none} /* and */ #two, .x {visibility: hidden}</style>
    <g id="one" style="display:none"><path d="M0 0L9 9"/></g><g id="two"><path d="M0 0L9 9"/>
    <path visibility="visible" d="M0 5L9 5"/></g><path class="a gone" d="M1 1L2 2"/><path opacity="0" d="M1 1L2 2"/>
    <path fill="none" stroke="none" d="M1 1L2 2"/><g visibility="collapse"><path d="M1 1L2 2"/></g>"""
    found, note = walls(svg(written, hidden))
    assert [wall["points"] for wall in found.values()] == [[[0, 0.095], [0.009, 0.095]]]
    assert "neither line nor fill: 5 left out" in note and "layer 'one' is hidden in the drawing: left out" in note


@says("What SVG draws by use alone", "A part that a mask or a clip-path cuts")
def test_what_svg_draws_by_use_alone(written):
    drawn = '<path d="M0 0L9 9"/>'
    for kind in ("symbol", "marker", "mask", "clipPath", "pattern", "defs", "linearGradient"):
        found, _ = walls(svg(written, f'<{kind} id="s">{drawn}</{kind}><path id="bed" d="M0 0L5 0"/>'))
        assert list(found) == ["bed"], kind
    symbol = '<symbol id="s" viewBox="0 0 10 10"><rect width="10" height="10"/></symbol>'
    found, _ = walls(svg(written, f'{symbol}<use id="put" href="#s" x="10" y="20" width="20" height="30"/>'))
    assert found["put"]["points"] == [[0.01, 0.075], [0.03, 0.075], [0.03, 0.055], [0.01, 0.055]]
    found, note = walls(svg(written, '<g id="cut" clip-path="url(#c)"><path d="M0 0L5 0"/></g>'))
    assert list(found) == ["cut"] and "a clip-path or a mask cuts: 1 taken whole" in note


NO_NUMBERS = ["4_0", "nan", "inf", "1e999", "true", "\uff11\uff12", "0x10", "1 2", "ten", "", "90 deg", "50%", "'1"]


@says("A number is a number")
def test_a_number_is_a_number(written, dxf):
    for text in (*NO_NUMBERS, '"10,5"'):
        with pytest.raises(CaseError, match=r"a\.csv:3: |is no place"):
            read_drawing(written("a.csv", f"chainage (m),level (m)\n0,1\n7,{text}\n"))
    for value in (*NO_NUMBERS, True, None, [1], {"a": 1}, 10**400, float("nan"), float("inf"), "12"):
        line = {"type": "LineString", "coordinates": [[0, 1], [7, value]]}
        with pytest.raises(CaseError, match=r"layer 'drawing'|NaN is no number|Infinity is no number"):
            read_drawing(written("a.geojson", json.dumps(line)), scale="m")
    for place in ("ab", "12", 7, None, {"0": 1}):
        line = {"type": "LineString", "coordinates": [[0, 1], place]}
        with pytest.raises(CaseError, match="where a list of coordinates is expected"):
            read_drawing(written("a.geojson", json.dumps(line)), scale="m")
    for text in set(NO_NUMBERS) - {"1 2", ""}:
        with pytest.raises(CaseError, match=r"a\.svg"):
            read_drawing(svg(written, f'<path id="a" d="M0 1L7 {text}"/>'))
    for text in set(NO_NUMBERS) - {"", "50%"}:
        with pytest.raises(CaseError, match=r"a\.svg"):
            read_drawing(svg(written, f'<line id="a" x2="{text}"/>'))
    whole = dxf(lambda space, _: space.add_line((0, 1), (77.25, 1))).read_bytes()
    for text in set(NO_NUMBERS) - {"1 2", ""}:
        (whole_path := written("a.dxf", "")).write_bytes(whole.replace(b"77.25", text.encode()))
        with pytest.raises(CaseError, match=r"a\.dxf"):
            read_drawing(whole_path)


@says("Every row of a table has as many cells")
@pytest.mark.parametrize("row", ["0,1,1,5", "3", "1;2", "1,2,3"])
def test_rows_of_other_widths_are_refused(written, row):
    with pytest.raises(CaseError, match=r"a\.csv:3: "):
        read_drawing(written("a.csv", f"chainage (m),level (m)\n0,0\n{row}\n"))


@pytest.mark.parametrize(
    "text",
    [
        '"chainage (m)","level (m)"\n"0","1"\n"10","2"\n',
        "chainage (m);level (m);\n0;1;\n10;2;\n",
        "chainage_m level_m\n0 1\n10 2\n",
        "\ufeffchainage (m)\tlevel (m)\r\n0\t1\r\n10\t2\r\n",
        'level (m),chainage (m),note\n1,0,\n2,10,"a, b"\n',
    ],
)
def test_tables_as_programs_write_them(written, text):
    assert walls(written("a.csv", text))[0]["a"]["points"] == [[0, 1], [10, 2]]


@says("A part of a DXF drawing with heights", "One that stands upright")
def test_heights_of_dxf(dxf):
    def draw(space, _):
        space.add_line((0, 0, 1), (4, 1, 2), dxfattribs={"layer": "up"})
        space.add_polyline3d([(0, 5, 0), (1, 5, 0), (1, 6, 3)], dxfattribs={"layer": "up"})
        space.add_circle((0, 0), 1, dxfattribs={"extrusion": (1, 0, 0)})
        space.add_ellipse((0, 0), (0, 0, 1), 0.5, dxfattribs={"extrusion": (1, 0, 0)})

    found, note = walls(dxf(draw))
    assert found["up_1"]["points"] == [[0, 0], [4, 1]] and found["up_2"]["points"] == [[0, 5], [1, 5], [1, 6]]
    assert "seen from above, 2 in all" in note
    assert (
        "CIRCLE that does not lie in the plane of the drawing: 1 left out" in note and "ELLIPSE that does not" in note
    )


@says("Faults that ezdxf has mended")
def test_faults_that_were_mended_are_told(dxf):
    path = dxf(lambda space, _: space.add_line((0, 0), (4, 1), dxfattribs={"layer": "bed"}))
    text = path.read_text()
    path.write_text(text.replace("  8\nbed\n", "  8\nbed\n  6\nno such line type\n"))
    found, note = walls(path)
    assert list(found) == ["bed"] and re.search(r"the file has \d+ faults, the first: .*no such line type", note, re.I)


def test_parts_of_dxf_that_cannot_be_taken_are_told(dxf):
    def draw(space, document):
        space.add_line((0, 0), (4, 1))
        space.add_blockref("nowhere", (0, 0))
        document.layout("Layout1").add_line((0, 0), (1, 1))
        smooth = space.add_polyline2d([(0, 5), (1, 6), (2, 5)], dxfattribs={"layer": "smooth"})
        smooth.vertices[1].dxf.flags = 16

    found, note = walls(dxf(draw))
    assert "INSERT(#30) without required BLOCK definition" in note and "paper space: 1 parts left out" in note
    assert found["smooth"]["points"] == [[0, 5], [2, 5]]  # no point of the curve, but one that it is drawn after


@says("With `--into` the case is checked", "All else in the file stays")
def test_a_case_that_is_refused_stays(written, monkeypatch, capsys):
    case = written("case.yaml", "# mine\n" + (INPUTS / "dam_break.yaml").read_text())
    before = case.read_bytes()
    crossed = written("bed.csv", "chainage (m),level (m)\n0,0\n10,0\n5,5\n5,-5\n")
    status, _, said = call(monkeypatch, capsys, "import", crossed, "--into", case)
    assert status == 2 and "meets itself" in said and case.read_bytes() == before
    sound = written("bed.csv", "chainage (m),level (m)\n0,-2\n60,-2\n")
    assert call(monkeypatch, capsys, "import", sound, "--into", case)[0] == 0
    assert set(before.splitlines()) <= set(case.read_bytes().splitlines())


# --- how large a drawing may be ---------------------------------------------------------------------------------------


@says("At most 300,000 points", "Where a drawing is larger")
def test_points_have_a_bound(dxf, written, monkeypatch):
    assert MOST_POINTS == MOST_PARTS == 300_000
    monkeypatch.setattr("lammps_jump.drawings.strokes.MOST_POINTS", 3000)
    for path in (
        dxf(lambda space, _: space.add_ellipse((0, 0), (1e9, 0), 0.3)),
        svg(written, '<path d="M0 0C1e30 1e30 -1e30 1e30 9 9"/>'),
        svg(written, '<path d="M0 0' + 1510 * "L1 1L2 0" + '"/>'),
        written("a.csv", "chainage (m),level (m)\n" + "".join(f"{x},0\n" for x in range(3001))),
    ):
        with pytest.raises(CaseError, match=r"needs [\d,]+ points or more.*at most 3,000 are read: is its unit right"):
            read_drawing(path)
    with pytest.raises(CaseError, match=r"needs .* points or more"):
        read_drawing(dxf(lambda space, _: space.add_spline([(0, 0), (1e12, 0), (0, 1e12), (3e11, 2)])))


@says("Copies are counted before one is drawn.", "A table has at most 2,000,000 lines.", "The command takes at most")
def test_copies_have_a_bound(dxf, written, monkeypatch):
    def nested(space, document):
        before = None
        for level in range(9):
            block = document.blocks.new(f"B{level}")
            for x in range(10):
                block.add_blockref(before, (x, 0)) if before else block.add_line((0, 0), (1, 1))
            before = f"B{level}"
        space.add_blockref(before, (0, 0))

    def array(space, document):
        document.blocks.new("A").add_line((0, 0), (1, 1))
        space.add_blockref("A", (0, 0)).grid((30_000, 30_000), (1, 1))

    def itself(space, document):
        document.blocks.new("A").add_blockref("B", (0, 0))
        document.blocks.new("B").add_blockref("A", (0, 0))
        space.add_blockref("A", (0, 0))

    assert (MOST_SECONDS, MOST_MEMORY) == (120, 4_000_000_000)  # what happens then: test_bounds.py
    for draw, said in (
        (nested, "more than 300,000 lines"),
        (array, "more than 300,000 lines"),
        (itself, "holds itself"),
    ):
        with pytest.raises(CaseError, match=said):
            read_drawing(dxf(draw))
    monkeypatch.setattr("lammps_jump.drawings.strokes.MOST_PARTS", 3000)
    bomb = '<g id="u0"><path d="M0 0L9 9"/></g>'
    bomb += "".join(f'<g id="u{n + 1}">' + 10 * f'<use href="#u{n}"/>' + "</g>" for n in range(9))
    with pytest.raises(CaseError, match="more than 3,000 lines"):
        read_drawing(svg(written, bomb))
    for inside in ('<g id="q"><use href="#q"/></g>', 200 * "<g>" + 200 * "</g>"):
        with pytest.raises(CaseError, match="150 deep"):
            read_drawing(svg(written, inside))
    with pytest.raises(CaseError, match="has 2,000,001 lines; at most 2,000,000 are read"):
        read_drawing(written("a.csv", "x,y" + 2_000_001 * "\n"))


@says("A drawing gives at most 1,000 walls")
def test_walls_have_a_bound(dxf, written):
    assert MOST_WALLS == 1000 and MOST_ROWS == 20_000
    path = dxf(lambda space, _: [space.add_line((x, 0), (x + 0.5, 1)) for x in range(1001)])
    with pytest.raises(CaseError, match="has 1,001 lines and circles that do not meet; at most 1,000 become walls"):
        walls(path)
    long = written("a.csv", "chainage (m),level (m)\n" + "".join(f"{x},0\n" for x in range(20_001)))
    found = entries(read_drawing(long))
    assert doubts(found, 1.0) == [
        "a: 20,001 points; a wall of a case has at most 20,000: draw it with fewer, or in several layers"
    ]


@says("No place may be farther")
def test_places_have_a_bound(written):
    for x in (1.1e7, -1e12, 1e300):
        with pytest.raises(CaseError, match=r"is farther than|is no place"):
            read_drawing(written("a.csv", f"chainage (m),level (m)\n0,0\n{x},1\n"))
    near = read_drawing(written("a.csv", "chainage (m),level (m)\n3e7,0\n3e7,1\n"), shift=(-3e7, 0.0))
    assert near.extent() == (0.0, 1.0)


@pytest.mark.long
def test_a_large_drawing_is_read_in_time_that_grows_with_it(dxf, written):
    """Twice as many points take about twice as long, in processor time of this process."""

    def took(count):
        x = np.arange(count) * 0.1
        y = np.cumsum(np.random.default_rng(1).normal(0, 0.02, count))
        points = list(zip(x.tolist(), y.tolist(), strict=True))
        table = "chainage (m),level (m)\n" + "".join(f"{a:.3f},{b:.4f}\n" for a, b in points)
        path = "M" + " ".join(f"{a:.3f} {b:.4f}" for a, b in points)
        pairs = list(pairwise(points))
        files = [
            written("a.csv", table), written("a.geojson", json.dumps({"type": "LineString", "coordinates": points})),
            svg(written, f'<path d="{path}"/>'),
            dxf(lambda space, _: space.add_lwpolyline(points)),
            dxf(lambda space, _: [space.add_line(*pair) for pair in pairs], "b.dxf"),
        ]  # fmt: skip
        begun = process_time()
        for file in files:
            found = entries(read_drawing(file, scale="mm"))
            yaml_text(found)
            doubts(found, 1.0)
        return process_time() - begun

    took(1000)
    assert took(8000) < 6 * took(2000)
