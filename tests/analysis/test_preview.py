# SPDX-License-Identifier: GPL-2.0-or-later
"""The picture of a case before it is run: labels apart, everything that moves drawn where it goes."""

import errno
from itertools import combinations
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import yaml
from made_up import call

import lammps_jump as lj
from lammps_jump.analysis.draw.drawing import ROOM, Area, Label, place_labels
from lammps_jump.analysis.draw.preview import NamedRegion, scene_drawing
from lammps_jump.analysis.draw.style import drawing, figure, save
from lammps_jump.analysis.draw.svg import svg_text
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import Motion, MovingWall, gate
from lammps_jump.scene.scene import InletRow, Outlet, handmade_scene
from lammps_jump.scene.shapes import ArcTo
from lammps_jump.scene.tracks import Loaded, Oscillate, Rotate
from lammps_jump.scene.walls import Block, Circle, Line, Plane, Polygon

CASE = """
name: shapes
gravity: 9.81
discs: {diameter: 0.2}
contact: {restitution: 0.2, friction: 0, largest_overlap: 0.1, impact_speed: 8}
domain: {x: [-1, 12], y: [-2, 6]}
walls:
  - {name: bed, kind: line, points: [[-1, 0], [6, 0], {arc_to: [8, -1], radius: -2}, [12, -1]]}
  - {name: paddle, kind: block, x: [2, 2.3], y: [0, 2], motion: {kind: oscillate, angle: 20, period: 2, about: [2, 0]}}
initial: [{kind: column, x: [3, 4], y: [0.1, 1], gate: false, hydrostatic: false}]
run: {duration: 2, time_step_fraction: 0.1, output_interval: 0.1}
"""


def boxes(labels, places):
    """(x low, x high, y low, y high) of each label that has a place."""
    found = [(place, label) for place, label in zip(places, labels, strict=True) if place is not None]
    return [(x, x + label.wide, y, y + label.high) for (x, y), label in found]


def apart(one, two):
    return one[1] <= two[0] or two[1] <= one[0] or one[3] <= two[2] or two[3] <= one[2]


@pytest.mark.parametrize("seed", range(3))
def test_labels_never_lie_on_each_other_and_stay_in_the_picture(seed):
    random = np.random.default_rng(seed)
    labels = [Label(*random.uniform((0, 0), (400, 200)), random.uniform(20, 90), 12.0, bool(k % 2)) for k in range(30)]
    placed = boxes(labels, place_labels(labels, 400, 200, [(0, 400, 90, 110)]))
    assert len(placed) > 20
    assert all(apart(one, two) for one, two in combinations(placed, 2))
    assert all(box[0] >= 0 and box[1] <= 400 and box[2] >= 0 and box[3] <= 200 for box in placed)


def test_a_label_takes_the_nearest_place_that_is_free():
    first, second = Label(100, 50, 40, 10, True), Label(100, 50, 40, 10, True)
    (x, y), other = place_labels([first, second], 200, 100)
    assert (x, y) == (80, 45)
    assert apart(*boxes([first, second], [(x, y), other])) and np.hypot(other[0] - x, other[1] - y) < 60
    assert place_labels([Label(22, 20, 40, 10)] * 3, 45, 40).count(None) == 1  # no room for more
    around = (85.0, 115.0, 35.0, 65.0)
    (place,) = place_labels([first._replace(inside=False)], 200, 100, [around])
    assert apart(boxes([first], [place])[0], around) and ROOM > 0


def drawn(**more):
    """A picture with one of everything, and its texts."""
    moves = {"time_step": 1e-4}
    walls = (
        Plane("left", "x", 0, "above"),
        Line("bed", points=((0, 0), (6, 0), ArcTo((8, -1), -2.0), (12, -1))),
        Polygon("weir", points=((4, 0), (5, 0), (4.5, 1))),
        Circle("pier", centre=(7, 2), radius=0.4),
        Block("chute", (1, 3), (2, 2.4), angle=-20.0),
        Line("leaf", points=((5.5, 1), (6, 2)), sheet=True),
        MovingWall(Block("paddle", (9, 9.2), (-1, 1)), Motion(kind=Oscillate(period=1e-2, angle=20), **moves)),
        MovingWall(Block("arm", (10, 11), (3, 3.1)), Motion(kind=Rotate(rate=9000), about=(10, 3), **moves)),
        MovingWall(Block("lid", (10, 11), (0, 0.3)), Motion(kind=Loaded(mass=1, force=(0, -1)), **moves)),
        gate(Block("sluice", (8, 8), (-1, 1)), 50),
    )
    rows = tuple(InletRow(0.1, 0.1 + 0.2 * k, 3.0, 0.0, 1, 100, 0.2) for k in range(3))
    x, y = np.meshgrid(np.arange(3.6, 4, 0.2), np.arange(3, 4, 0.2))
    scene = handmade_scene(
        np.column_stack([x.ravel(), y.ravel()]), np.tile([1.0, 0.0], (x.size, 1)), walls, domain=((-1, 13), (-2, 6)),
        steps=400, inlets=rows, outlets=(Outlet("x", 12.0, "above", 10),), **more,
    )  # fmt: skip
    return scene_drawing(scene, [NamedRegion("column", (3.5, 4.1), (2.9, 4.1))], sequent=1.5)


def test_everything_that_the_case_names_is_named_and_no_two_labels_touch():
    picture = figure(drawn())
    texts = [text for text in picture.axes[0].texts if text.get_text()]
    told = [text.get_text() for text in texts]
    names = ["left", "bed", "weir", "pier", "chute", "leaf", "paddle (oscillate)", "arm (rotate)", "lid (load)"]
    assert set(names) < set(told) and any(text.startswith("sluice, opens at t = ") for text in told)
    assert {"column, 10 discs, 1 m/s", "inlet: 3 rows, mean 3 m/s", "outlet x = 12 m"} < set(told)
    assert any(text.endswith("(Bélanger): 1.5 m") for text in told)
    renderer = picture.canvas.get_renderer()
    seen = [text.get_window_extent(renderer) for text in texts]
    assert not [pair for pair in combinations(seen, 2) if pair[0].overlaps(pair[1])]
    place = picture.axes[0].get_window_extent(renderer)
    assert all(place.x0 <= box.x0 and box.x1 <= place.x1 and place.y0 <= box.y0 and box.y1 <= place.y1 for box in seen)


def test_a_dotted_edge_is_spoken_of_where_it_is_in_the_picture():
    walls = [Plane("floor", "y", 0, "above")]
    for domain, dotted in ((((-0.3, 1.3), (-0.1, 2)), True), (((-900, 900), (-900, 900)), False)):
        scene = handmade_scene([[0.0, 1.0], [1.0, 1.0]], [[0.0, 0.0]] * 2, walls, domain=domain)
        assert ("(dotted)" in figure(scene_drawing(scene, [])).axes[0].get_title(loc="right")) is dotted


def test_ghosts_and_arrows_are_where_walls_go():
    shapes = drawn().shapes
    ghosts = [shape.rings[0] for shape in shapes if shape.look == "ghost" and isinstance(shape, Area)]
    of_arm = [ghost for ghost in ghosts if np.hypot(*(ghost - (10, 3)).T).max() < 1.01]
    assert len(of_arm) == 4 and min(ghost[:, 0].min() for ghost in of_arm) < 9.2  # it turns right round
    ways = [shape.points for shape in shapes if shape.look == "arrow"]
    assert all(np.isfinite(way).all() for way in ways) and len(ways) >= 3 + 1 + 1 + 1 + 2


def test_command_writes_a_page_and_a_picture_and_nothing_else(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(CASE)
    status, out, err = call(monkeypatch, capsys, "preview", "mine.yaml")
    assert (status, err) == (0, "") and out.splitlines() == ["mine.preview.html", "mine.preview.png"]
    assert {path.name for path in tmp_path.iterdir()} == {"mine.yaml", "mine.preview.html", "mine.preview.png"}
    page = (tmp_path / "mine.preview.html").read_text()
    assert (
        "data:image/png;base64," in page
        and "oscillate: about (2, 0), period 2, angle 20" in page
        and "http" not in page.split("</head>")[1]
    )
    assert (tmp_path / "mine.preview.png").read_bytes().startswith(b"\x89PNG")
    status, out, _ = call(monkeypatch, capsys, "check", "mine.yaml", "--picture", "--set", "discs.density=900")
    assert status == 0 and out.splitlines()[-1] == "mine,discs.density=900.preview.png"
    assert lj.load_case("mine.yaml").preview("there")[0].parent.name == "there"
    (tmp_path / "file").write_text("")
    status, _, err = call(monkeypatch, capsys, "preview", "mine.yaml", "--out", "file")
    assert status == 2 and "file" in err


@pytest.mark.fault("folders")
def test_no_picture_goes_through_a_link(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(CASE)
    (tmp_path / "thesis.txt").write_text("precious")
    for ending in ("png", "html"):
        (tmp_path / f"mine.preview.{ending}").symlink_to("thesis.txt")
    assert call(monkeypatch, capsys, "preview", "mine.yaml")[0] == 0
    assert (tmp_path / "thesis.txt").read_text() == "precious"
    assert (tmp_path / "mine.preview.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.fault("files that cannot be written")
def test_the_old_picture_stays_where_the_new_one_cannot_be_written(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    with drawing() as (figure, _):
        save(figure, path)
    whole = path.read_bytes()

    def full(place):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("lammps_jump.files.flush", full)
    for ending in ("png", "svg"):
        with pytest.raises(DumpError, match="No space left"):
            save(figure, path.with_suffix(f".{ending}"))
    assert path.read_bytes() == whole and [one.name for one in tmp_path.iterdir()] == ["a.png"]


def test_a_case_in_a_notebook_shows_walls_of_several_parts_as_one_shape():
    case = lj.load_case(yaml.safe_load(CASE))
    drawing = case._repr_html_().partition("<svg")[2].rpartition("</svg>")[0]
    looks = [shape.get("class") for shape in ET.fromstring(f"<svg{drawing}</svg>").iter(f"{SVG}path")]
    assert looks.count("solid") == 1 and looks.count("edge plain") == 1


SVG = "{http://www.w3.org/2000/svg}"


def test_the_svg_shows_what_the_figure_shows():
    """Each shape of the description, each label where it is, discs at their places; nothing in it acts."""
    found = drawn(name="a")
    tree = ET.fromstring(svg_text(found))
    looks = [one.get("class") for one in tree.iter()]
    told = [shape for shape in found.shapes if shape.look not in ("discs", "arrow", "label")]
    for look in {shape.look for shape in told}:
        assert sum((one or "").split(" ")[0] == look for one in looks) == sum(one.look == look for one in told)
    labels = {one.text: one for one in tree.iter(f"{SVG}text") if (one.get("class") or "").startswith("label")}
    for shape in found.shapes:
        if shape.look == "label":
            at = float(labels[shape.text].get("x")), float(labels[shape.text].get("y"))
            asked = (shape.x - found.x[0]) * found.scale, (found.y[1] - shape.y) * found.scale - 4
            assert at == pytest.approx(asked, abs=0.06)
    discs = next(one for one in tree.iter() if one.get("class") == "disc")
    (places,) = (shape.places for shape in found.shapes if shape.look == "discs")
    seen = [part.removesuffix("h0").split(" ") for part in discs.get("d").split("M")[1:]]
    assert np.allclose(np.array(seen, float)[:, 0], (places[:, 0] - found.x[0]) * found.scale, atol=0.06)
    assert float(tree.get("width")) <= 1320 + 60
    narrow = scene_drawing(
        handmade_scene([[0.0, 1.0]], [[0.0, 0.0]], [Plane("floor", "y", 0, "above")]), [], widest=320
    )
    assert narrow.size[0] == pytest.approx(320) and float(ET.fromstring(svg_text(narrow)).get("width")) < 390


def test_text_of_a_case_is_no_markup_in_the_svg():
    attack = '<script>alert(1)</script>&" onload=x'
    found = drawn(name=attack)
    found.label(attack, 3.0, 3.0)
    found.place_labels()
    tree = ET.fromstring(svg_text(found))
    assert {one.tag for one in tree.iter()} == {f"{SVG}{name}" for name in ("svg", "g", "path", "text")}
    assert attack in tree.get("aria-label") and not [one for one in tree.iter() if one.get("onload")]
