# SPDX-License-Identifier: GPL-2.0-or-later
"""Places of the drawing that can be dragged: their numbers stand where the text has them, and all else stays."""

import pytest
import yaml

from lammps_jump.case.text import parse_source
from lammps_jump.drawings import DRAWN, with_drawn
from lammps_jump.errors import CaseError
from lammps_jump.served.look import Places

TEXT = """\
# \N{MULTIPLICATION SIGN} and \N{WAVE DASH}, in a comment
name: all
domain: {x: [-3, 70], y: [-8, 20]}
walls:
  - name: bed   # falls
    kind: line
    points:
      - [-2, 6.5]          # crest
      - {arc_to: ["15 m", 654 mm], radius: -12}
  - {name: sill, kind: block, x: [52, 52.5], y: [-2, +.35]}
  - {name: turned, kind: block, x: [1, 2], y: [3, 4], angle: 20}
  - {name: pier, kind: circle, centre: [7, 2], radius: 4e-1}
  - {name: left, kind: plane, axis: x, at: 0, side: above}
initial:
  - {kind: column, x: [25, 36], y: [0, 3.9]}
inflow: {kind: rows, x: 0, y: '6.5', depth: 1.0}
outflow: [{x_beyond: 60}, {y_below: -3}]
probes: {gauges: [10, 20]}
"""


def places(text=TEXT):
    return Places(parse_source(text), text)


def moved(found, text, name, dx=0.0, dy=0.0):
    """The text with a place moved, as the page does it."""
    (place,) = (one for one in found.found if one.name == name)
    changes = {k: found.numbers[k].value + dx for k in place.along_x}
    changes |= {k: found.numbers[k].value + dy for k in place.along_y}
    for k in sorted(changes, key=lambda k: -found.numbers[k].start):
        one = found.numbers[k]
        text = text[: one.start] + f"{changes[k] / one.unit:.6g}" + text[one.end :]
    return text


@pytest.mark.parametrize(
    ("name", "by", "line", "wanted"),
    [
        ("bed, point 1", (1, 0.5), 8, "      - [-1, 7]          # crest"),
        ("bed, point 2", (1, 0.1), 9, '      - {arc_to: ["16 m", 754 mm], radius: -12}'),
        ("sill, upper left", (1, 0.1), 10, "  - {name: sill, kind: block, x: [53, 52.5], y: [-2, 0.45]}"),
        ("sill, whole", (1, 1), 10, "  - {name: sill, kind: block, x: [53, 53.5], y: [-1, 1.35]}"),
        ("pier, centre", (-1, 0), 12, "  - {name: pier, kind: circle, centre: [6, 2], radius: 4e-1}"),
        ("pier, radius", (0.1, 0), 12, "  - {name: pier, kind: circle, centre: [7, 2], radius: 0.5}"),
        ("left", (-1, 5), 13, "  - {name: left, kind: plane, axis: x, at: -1, side: above}"),
        ("initial 1, upper right", (1, 1), 15, "  - {kind: column, x: [25, 37], y: [0, 4.9]}"),
        ("inflow", (0, 1), 16, "inflow: {kind: rows, x: 0, y: '7.5', depth: 1.0}"),
        ("outflow[0].x_beyond", (5, 9), 17, "outflow: [{x_beyond: 65}, {y_below: -3}]"),
        ("gauges 2", (1, 9), 18, "probes: {gauges: [10, 21]}"),
    ],
)
def test_a_place_changes_its_numbers_and_nothing_else(name, by, line, wanted):
    changed = moved(places(), TEXT, name, *by).splitlines()
    before = TEXT.splitlines()
    assert changed[line - 1] == wanted
    assert changed[: line - 1] + changed[line:] == before[: line - 1] + before[line:]
    yaml.safe_load("\n".join(changed))


def test_places_are_where_the_case_has_them():
    found = {one.name: (one.x, one.y) for one in places().found}
    assert found["bed, point 2"] == pytest.approx((15, 0.654)) and found["pier, radius"] == pytest.approx((7.4, 2))
    assert found["left"] == (0, None) and found["outflow[1].y_below"] == (None, -3) and found["gauges 1"] == (10, None)
    assert not any(name.startswith("turned") for name in found)  # its corners are not where its numbers are
    assert "domain, whole" not in found and len(found) == len(places().found)


def test_letters_are_counted_as_a_page_counts_them():
    text = TEXT.replace("crest", "crest \N{WATER WAVE}").replace("falls", "\N{WATER WAVE}\N{WATER WAVE}")
    found, units = places(text), text.encode("utf-16-le")
    for one, plain in zip(found.numbers, places().numbers, strict=True):
        assert units[2 * one.start : 2 * one.end].decode("utf-16-le") == TEXT[plain.start : plain.end]


def test_an_alias_moves_what_it_stands_for():
    text = "a: {centre: &here [1, 2]}\nb: {centre: *here}\n"
    found = places(text)
    assert moved(found, text, "b, centre", 1, 1) == "a: {centre: &here [2, 3]}\nb: {centre: *here}\n"


def test_what_is_no_length_is_no_place():
    text = "walls: [{x: [a, 1], y: [0, 1]}, {centre: [1 kg, 2]}, {points: [[1], 2, {arc_to: x}]}]\ngauges: 3\n"
    assert places(text).found == []


@pytest.mark.parametrize(
    ("what", "points", "line"),
    [
        ("wall line", [(1, 2), (3, 2.5)], "  - {name: wall_1, kind: line, points: [[1, 2], [3, 2.5]], sheet: true}"),
        ("wall block", [(3, 2), (1, 4)], "  - {name: wall_1, kind: block, x: [1, 3], y: [2, 4]}"),
        ("wall circle", [(1, 2), (4, 6)], "  - {name: wall_1, kind: circle, centre: [1, 2], radius: 5}"),
        ("body block", [(1, 2), (3, 1)], "  - {name: body_1, kind: block, x: [1, 3], y: [1, 2], density: 900}"),
        ("body circle", [(1, 2), (1, 3)], "  - {name: body_1, kind: circle, centre: [1, 2], radius: 1, density: 900}"),
        ("column", [(1, 2), (3, 1)], "  - {kind: column, x: [1, 3], y: [1, 2], gate: false}"),
    ],
)
def test_a_shape_that_is_drawn_is_one_line_of_the_text(what, points, line):
    text = with_drawn(TEXT, what, points, 900.0)
    rows = text.split("\n")
    assert line in rows and "\n".join(row for row in rows if row not in (line, "bodies:")) == TEXT
    part = DRAWN[what][0]
    assert len(yaml.safe_load(text)[part]) == len(yaml.safe_load(TEXT).get(part, [])) + 1
    again = with_drawn(text, what, points, 900.0)
    assert part == "initial" or line.replace("_1", "_2") in again.split("\n")


def test_a_shape_without_size_or_without_a_place_in_the_text_is_refused():
    with pytest.raises(CaseError, match="the column has no size"):
        with_drawn(TEXT, "column", [(1, 2), (1, 3)], 900.0)
    with pytest.raises(CaseError, match="walls: stand in brackets"):
        with_drawn("walls: [{name: a, kind: block, x: [0, 1], y: [0, 1]}]", "wall block", [(1, 2), (2, 3)], 900.0)
