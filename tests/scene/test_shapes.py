# SPDX-License-Identifier: GPL-2.0-or-later
"""shapes.py and the walls that points draw: sides, answers, and mistakes that name the point."""

from itertools import pairwise
from math import cos, hypot, pi, radians, sin

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from made_up import examples

from lammps_jump.scene.faces import MOST, touching
from lammps_jump.scene.shapes import ArcTo, PlaceError, drawn, flush, open_ends, tight_bend
from lammps_jump.scene.walls import Block, Box, Circle, Line, Plane, Polygon

COORDINATE = st.floats(-5.0, 5.0)
SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))


def at(wall, x, y):
    return float(wall.distance(np.array([x]), np.array([y]))[0])


@given(x=COORDINATE, y=COORDINATE, turned=st.booleans())
@example(x=1e-300, y=1e-179, turned=True)
def test_a_polygon_of_a_rectangle_is_a_block_or_its_hole(x, y, turned):
    points = SQUARE[::-1] if turned else SQUARE

    def same(one, other):  # of two faces at the same distance but for round-off, the first counts
        assert at(one, x, y) == pytest.approx(at(other, x, y), rel=1e-15, abs=1e-15)

    same(Polygon("p", points), Block("b", (0, 2), (0, 1)))
    # a box has its sign from the nearest face, and outside of it a corner is in front of none: the same inside
    if 0 < x < 2 and 0 < y < 1:
        same(Polygon("p", points, discs="inside"), Box("b", (0, 2), (0, 1)))


@given(x=COORDINATE, y=COORDINATE, inside=st.booleans())
def test_a_circle_and_a_polygon_of_two_arcs_are_the_same(x, y, inside):
    discs = "inside" if inside else "outside"
    circle = Circle("c", (0.5, 0.0), 1.5, discs)
    arcs = Polygon("p", ((-1.0, 0.0), ArcTo((2.0, 0.0), 1.5), ArcTo((-1.0, 0.0), 1.5)), discs=discs)
    exact = (hypot(x - 0.5, y) - 1.5) * (-1 if inside else 1)
    assert at(circle, x, y) == pytest.approx(exact, abs=1e-12)
    assert at(arcs, x, y) == pytest.approx(exact, abs=1e-12)


@given(x=COORDINATE, y=COORDINATE, angle=st.floats(-360, 360), pivot=st.none() | st.tuples(COORDINATE, COORDINATE))
def test_a_turned_block_is_a_block_in_a_turned_frame(x, y, angle, pivot):
    block = Block("b", (-1.0, 2.0), (0.0, 0.5), angle, pivot)
    (ox, oy), c, s = pivot or (0.5, 0.25), cos(radians(angle)), sin(radians(angle))
    back = ox + c * (x - ox) + s * (y - oy), oy - s * (x - ox) + c * (y - oy)
    assert at(block, x, y) == pytest.approx(at(Block("b", (-1.0, 2.0), (0.0, 0.5)), *back), abs=1e-12)
    assert block.pivot_point == (ox, oy)


def test_a_block_at_no_angle_is_as_it_was():
    block = Block("b", (-1.0, 2.0), (0.0, 0.5))
    assert block.extent == ((-1.0, 2.0), (0.0, 0.5)) and block.moment_point == (-1.0, 0.0)
    assert block.chains()[0].points == ((-1.0, 0.0), (-1.0, 0.5), (2.0, 0.5), (2.0, 0.0))


@pytest.mark.parametrize(
    "leaf", [Block("b", (1, 1), (0, 2)), Block("b", (0, 2), (1, 1)), Block("b", (0, 2), (1, 1), 30)]
)
def test_a_leaf_is_felt_from_both_sides(leaf):
    (x0, y0), (x1, y1) = leaf.chains()[0].points
    nx, ny = -(y1 - y0) / 2, (x1 - x0) / 2
    for side in (-0.3, 0.3):
        assert at(leaf, (x0 + x1) / 2 + side * nx, (y0 + y1) / 2 + side * ny) == pytest.approx(0.3)


def test_a_sheet_of_two_points_is_a_leaf():
    assert Line("l", ((1, 0), (1, 2)), sheet=True).chains() == Block("b", (1, 1), (0, 2)).chains()


def test_a_line_has_its_discs_on_the_left():
    line = Line("l", ((0, 0), (2, 0), ArcTo((3, 1), 1.0), (3, 4)))
    assert at(line, 1, 0.5) == 0.5 and at(line, 1, -0.5) == -0.5
    assert at(line, 2 + 0.5 * sin(0.7), 1 - 0.5 * cos(0.7)) == pytest.approx(0.5)
    assert not line.hollow and open_ends(line.faces) == [(0, 0), (3, 4)]
    sheet = Line("s", line.points, sheet=True)
    assert at(sheet, 1, -0.5) == 0.5 and at(sheet, 2 + 1.5 * sin(0.7), 1 - 1.5 * cos(0.7)) == pytest.approx(0.5)
    assert sheet.extent == line.extent == ((0, 3), (0, 4))


def test_a_line_may_close():
    ring = Line("r", (*SQUARE, SQUARE[0]))
    assert ring.hollow and open_ends(ring.faces) == [] and at(ring, 1.0, 0.4) == 0.4
    both = Line("r", (*SQUARE, SQUARE[0]), sheet=True)
    assert not both.hollow and at(both, 1.0, 0.4) == 0.4 and at(both, 1.0, -0.4) == 0.4


@pytest.mark.parametrize(
    ("wall", "extent", "moment_point", "room", "top"),
    [
        (Polygon("p", ((2, 0), (1, 1), (0, 0))), ((0, 2), (0, 1)), (2, 0), (-np.inf, np.inf), 0.5),
        (Polygon("p", SQUARE, discs="inside"), ((0, 2), (0, 1)), (0, 0), (0, 2), 0.0),
        (Line("l", ((0, 1), (1, 0), (2, 0))), ((0, 2), (0, 1)), (0, 1), (-np.inf, np.inf), 0.5),
        (Circle("c", (1, 0), 1), ((0, 2), (-1, 1)), (1, 0), (-np.inf, np.inf), 3**0.5 / 2),
        (Block("b", (0, 2), (0, 1), 90, (0, 0)), ((-1, 0), (0, 2)), (0, 0), (-np.inf, np.inf), None),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_what_drawn_walls_answer(wall, extent, moment_point, room, top):
    assert np.allclose(wall.extent, extent, atol=1e-12) and wall.moment_point == moment_point
    assert wall.room("x") == room and wall.finite
    if top is not None:
        assert np.nanmax([tops[0] for _, tops in wall.grounds(np.array([0.5]))]) == pytest.approx(top)
    corners = np.concatenate(wall.outline((-9, 9), (-9, 9)))
    assert np.abs(wall.distance(*corners.T)).max() < 1e-12


@pytest.mark.parametrize(
    ("points", "index", "words"),
    [
        (((0, 0), (1, 0), (1, 0), (2, 0)), 2, "stands where the point before"),
        (((0, 0), (2, 2), (2, 0), (0, 2)), 3, r"meets itself at \(1, 1\) m: here and between points 0 and 1"),
        (((0, 0), (2, 0), (1, 1), (1, 0)), 3, "meets itself"),
        (((0, 0), (2, 0), (2, 1), (0, 0), (-1, -1)), 4, "meets itself"),
        (((0, 0), (2, 0), (1, 0)), 1, "turns right back"),
        (((0, 0), ArcTo((3, 0), 1)), 1, "radius of 1.5 m or more"),
        ((ArcTo((1, 0), 1), (2, 0)), 0, r"as \[x, y\]"),
        (((0, 0), ArcTo((2, 0), 1), (2, 1), (0, -0.5)), 3, "meets itself"),
        (((0, 0), ArcTo((2, 0), 1), (2, 1), ArcTo((1, -2), 2)), 3, "meets itself"),
        (((0, 0),), None, "2 or more"),
    ],
)
def test_mistakes_name_their_point(points, index, words):
    with pytest.raises(PlaceError, match=words) as error:
        Line("l", points)
    assert error.value.path == (("points",) if index is None else ("points", index))


@pytest.mark.parametrize("points", [SQUARE[:2], ((0, 0), (1, 1), (2, 2)), ((0, 0), (1, 0), (0, 0))])
def test_a_polygon_needs_an_area(points):
    with pytest.raises(PlaceError):
        Polygon("p", points)


@examples(30)
@given(radii=st.lists(st.floats(0.5, 2.0), min_size=3, max_size=8), turned=st.booleans(), solid=st.booleans())
def test_a_star_is_taken_either_way_round(radii, turned, solid):
    angles = np.arange(len(radii)) * 2 * pi / len(radii)
    points = [(r * cos(a), r * sin(a)) for r, a in zip(radii, angles.tolist(), strict=True)]
    wall = Polygon("p", tuple(points[::-1] if turned else points), discs="outside" if solid else "inside")
    assert (at(wall, 0.0, 0.0) < 0) == solid and (at(wall, 4.0, 0.0) > 0) == solid
    assert wall.moment_point == (points[-1] if turned else points[0])


@examples(20)
@given(steps=st.lists(st.tuples(st.floats(0.1, 2), st.floats(-3, 3)), min_size=2, max_size=8))
def test_a_bed_of_any_heights_is_a_line(steps):
    x = np.cumsum([dx for dx, _ in steps])
    line = Line("bed", tuple(zip(x.tolist(), (y for _, y in steps), strict=True)))
    for (x0, y0), (x1, y1) in pairwise(line.path.points):
        assert at(line, (x0 + x1) / 2, (y0 + y1) / 2 + 10) > 0
        ((_, top), *_) = line.grounds(np.array([(x0 + x1) / 2]))
        assert top[0] == pytest.approx((y0 + y1) / 2)


RING = [(cos(2 * pi * i / 100), sin(2 * pi * i / 100)) for i in range(100)]


def test_bends_of_short_pieces():
    assert tight_bend(Polygon("p", tuple(RING), discs="inside").faces)[0] == pytest.approx(1.0, rel=1e-3)
    assert tight_bend(Line("l", tuple(RING[50:])).faces)[0] == pytest.approx(1.0, rel=1e-3)
    assert tight_bend(Polygon("p", tuple(RING)).faces) is None  # convex for the discs outside
    assert tight_bend(Polygon("p", tuple(RING[::4]), discs="inside").faces) is None  # corners


def test_a_long_wall_is_its_parts():
    x = np.linspace(0.0, 9.0, 200)
    points = list(zip(x.tolist(), np.sin(3 * x).tolist(), strict=True))
    px, py = np.meshgrid(np.linspace(-2, 11, 27), np.linspace(-3, 3, 13))
    parts = np.array([Line("p", pair, sheet=True).distance(px, py) for pair in pairwise(points)]).min(axis=0)
    whole = np.abs(Line("l", tuple(points)).distance(px, py))
    assert np.allclose(whole, parts, rtol=0, atol=1e-12)


def test_lines_that_go_on_are_flush():
    slope = Line("a", ((0, 0), (2, -1)))
    assert flush(slope.faces, Line("b", ((2, -1), (4, -2))).faces) == (2, -1)
    assert flush(slope.faces, Line("b", ((2, -1), (4, -4))).faces) == (2, -1)  # over the edge, discs feel both ends
    assert flush(slope.faces, Line("b", ((2, -1), (4, 0))).faces) is None  # a corner towards the discs
    assert flush(slope.faces, Plane("c", "y", -1.0, "above").faces) is None
    down = Block("chute", (0.0, 2.0), (-1.0, 0.0), -30, (2.0, 0.0))
    assert flush(down.faces, Line("b", ((2, 0), (2 + 3**0.5, -1))).faces) == pytest.approx((2, 0))


def test_a_sheet_at_any_angle_pushes_to_the_side_of_the_disc():
    """The two faces of a sheet are at one distance but for round-off: the one in front counts."""
    found, which = np.empty((MOST, 4)), np.empty(MOST, np.int64)
    near, wrong = np.arange(2), 0
    random = np.random.default_rng(1)
    for angle, along, off in random.uniform((0, -0.9, 1e-6), (2 * pi, 0.9, 0.0999), (2000, 3)).tolist():
        c, s = cos(angle), sin(angle)
        sheet = Line("s", ((3 - c, 4 - s), (3 + c, 4 + s)), sheet=True)
        x, y = 3 + along * c - off * s, 4 + along * s + off * c
        count = touching(sheet.faces, 0, near, (x, y, 0.1), found, which)
        wrong += count != 1 or found[0, 1] * -s + found[0, 2] * c < 0.999 or at(sheet, x, y) < 0
    assert wrong == 0


@pytest.mark.parametrize("way", [1, -1])
def test_a_sheet_that_leans_is_no_ground(way):
    """Its faces lie upon each other, but for round-off: it is as thick as nothing, and hangs in the air."""
    points = tuple((way * x, y) for x, y in ((0.3, 1.65), (0.3, 0.6715), (0.035, 0.35)))
    x = way * np.linspace(0.036, 0.299, 501)
    ((underside, top),) = Line("side", points=points, sheet=True).grounds(x)
    np.testing.assert_allclose(underside, top, atol=1e-12)


def test_faces_side_by_side_have_a_bound(monkeypatch):
    """A fan of long faces kept the check busy: each of its boxes meets all others."""
    fan = [(0.01 * k + 100 * (k % 2), 100.0 * (k % 2)) for k in range(200)]
    assert drawn(fan, least=2).size > 100
    monkeypatch.setattr("lammps_jump.scene.shapes.MOST_CLOSE", 1000)
    with pytest.raises(PlaceError, match="pairs of its faces lie side by side"):
        drawn(fan, least=2)
