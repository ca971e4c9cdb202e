# SPDX-License-Identifier: GPL-2.0-or-later
"""What multiplies in a drawing is counted before it is worked on, and what is worked on is bounded: by counts."""

import re
import resource
import signal
from collections import Counter
from math import hypot
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from ezdxf.math import BSpline
from made_up import call

import lammps_jump
from lammps_jump import foreign
from lammps_jump.drawings import attributes, dxf, entries, read_drawing, survey, svg
from lammps_jump.errors import CaseError

PAGE = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">{}</svg>'
LINE = '<path id="bed" d="M0 0L9 9"/>'


@pytest.fixture
def put(tmp_path):
    """Writes a drawing: SVG of what it holds, a table of text, DXF of what a function adds to it."""

    def write(inside, kind="svg"):
        path = tmp_path / f"a.{kind}"
        if callable(inside):
            document = ezdxf.new("R2010")
            document.header["$INSUNITS"] = 6
            inside(document.modelspace(), document)
            path = tmp_path / "a.dxf"
            document.saveas(path)
        else:
            path.write_text(PAGE.format(inside) if kind == "svg" else inside)
        return path

    return write


@pytest.fixture
def calls(monkeypatch):
    """Counts the calls of methods of readers."""
    found = Counter()

    def watch(kind, *names):
        for name in names:
            before = getattr(kind, name)

            def counted(*given, name=name, before=before):
                found[name] += 1
                return before(*given)

            monkeypatch.setattr(kind, name, counted)

    watch(svg._SvgReader, "take", "_path")
    watch(attributes.Styles, "given")
    watch(dxf._DxfReader, "take", "_copies")
    return found


def refused(path, said, **options):
    with pytest.raises(CaseError, match=said) as caught:
        read_drawing(path, **options)
    assert len(str(caught.value)) < 600


# --- copies -----------------------------------------------------------------------------------------------------------


def groups(last, each, inside=LINE):
    """Groups that each use the one before ten times."""
    return f'<g id="u0">{inside}</g>' + "".join(
        f'<g id="u{n + 1}">' + 10 * each.format(f"u{n}") + "</g>" for n in range(last)
    )


def symbols(last):
    """The same of symbols, which draw by use alone."""
    found = '<symbol id="u0"><line x2="1"/></symbol>'
    for n in range(last):
        found += f'<symbol id="u{n + 1}">' + 10 * f'<use href="#u{n}"/>' + "</symbol>"
    return f'{found}<use href="#u{last}"/>'


BOMBS = {
    "groups": groups(9, '<use href="#{}"/>'),
    "of xlink": groups(9, '<use xmlns:x="http://www.w3.org/1999/xlink" x:href="#{}"/>'),
    "in groups": groups(9, '<g><a><use href="#{}" transform="scale(2)"/></a></g>'),
    "symbols": symbols(9),
}


@pytest.mark.parametrize("name", BOMBS)
def test_copies_of_svg_are_counted_before_one_is_drawn(put, calls, name):
    refused(put(BOMBS[name]), "more than 300,000 lines, circles and other parts, copies counted")
    assert calls["take"] == calls["_path"] == 0
    assert calls["given"] <= 300  # each element once, whatever it is used for


def test_copies_of_what_is_not_drawn_are_counted_too(put, calls):
    uses, other = 200 * '<use href="#a"/>', 2000 * '<o xmlns="http://other"/>'
    refused(put(f'<defs><g id="a">{other}</g></defs>{uses}{LINE}'), "more than 300,000")
    assert calls["take"] == 0


@pytest.mark.parametrize("hide", ['display="none"', 'opacity="0"', 'style="display:none"'])
def test_copies_that_are_hidden_do_not_count(put, hide):
    bomb = f"<g {hide}>{BOMBS['groups']}</g>{LINE}"
    assert len(entries(read_drawing(put(bomb)))) == 1
    itself = f'<g id="q" {hide}><use href="#q"/></g>{LINE}'
    assert len(entries(read_drawing(put(itself)))) == 1


def test_of_a_switch_one_part_counts(put):
    bomb = f"<switch>{LINE}<g>{BOMBS['groups']}</g></switch>"
    assert len(entries(read_drawing(put(bomb)))) == 1


def blocks(space, document):
    before = None
    for level in range(9):
        block = document.blocks.new(f"B{level}")
        for x in range(10):
            block.add_blockref(before, (x, 0)) if before else block.add_line((0, 0), (1, 1))
        before = f"B{level}"
    space.add_blockref(before, (0, 0))


def arrays(space, document):
    """Arrays inside arrays, one of them with rows that lie on each other, and one of fewer than none."""
    document.blocks.new("A").add_line((0, 0), (1, 1))
    inner = document.blocks.new("B").add_blockref("A", (0, 0)).grid((1000, 1000), (1, 1))
    document.blocks.get("B").add_blockref("A", (0, 0), {"row_count": -999_999, "row_spacing": 1})
    assert inner.mcount == 1_000_000
    space.add_blockref("B", (0, 0))


@pytest.mark.parametrize("draw", [blocks, arrays])
def test_copies_of_dxf_are_counted_before_one_is_made(put, calls, draw):
    refused(put(draw), "more than 300,000 lines, circles and other parts, copies counted")
    assert calls["take"] == calls["_copies"] == 0


def test_rows_that_lie_on_each_other_are_one(put):
    """ezdxf looks at all of them, and so does not end for such a file."""

    def draw(space, document):
        document.blocks.new("A").add_line((0, 0), (1, 1))
        space.add_blockref("A", (0, 0), {"row_count": 2**31 - 1, "column_count": 3, "column_spacing": 5})

    found = read_drawing(put(draw)).layers[0].strokes
    assert [stroke.points[0] for stroke in found] == [(0, 0), (5, 0), (10, 0)]


def test_what_is_left_out_is_not_copied(put, calls, monkeypatch):
    """A hatch, or a line on a layer that is off, in a block that stands in the drawing a hundred times."""

    def draw(space, document):
        document.layers.add("off").off()
        block = document.blocks.new("A")
        block.add_hatch(dxfattribs={"layer": "h"}).paths.add_polyline_path([(n, n % 7) for n in range(50)])
        block.add_lwpolyline([(n, n % 7) for n in range(50)])
        for x in range(100):
            space.add_blockref("A", (x, 0), {"layer": "off"})
        space.add_line((0, 0), (1, 1))

    drawing = read_drawing(put(draw))
    assert len(drawing.layers[0].strokes) == 1 and calls["_copies"] == 0
    assert "HATCH: 100 left out" in drawing.notes

    def meshes(space, document):
        block = document.blocks.new("A")
        block.add_polymesh((8, 8))
        for x in range(100):
            space.add_blockref("A", (x, 0))
        space.add_line((0, 0), (1, 1))

    path = put(meshes)
    assert "POLYLINE: 100 left out" in read_drawing(path).notes
    monkeypatch.setattr("lammps_jump.drawings.strokes.MOST_LOOKED", 6000)
    refused(path, "what is used again has more than 6,000 points, copies counted")


def test_an_array_in_a_block_that_is_stretched_is_whole(put):
    """Each copy of it, and a circle turned and then stretched, which is an ellipse with its axes between the two."""

    def draw(space, document):
        piles, turned = document.blocks.new("P"), document.blocks.new("Q")
        piles.add_circle((1, 0), 0.5, dxfattribs={"layer": "c"})
        piles.add_line((0, 0), (1, 0), dxfattribs={"layer": "l"})
        turned.add_blockref("P", (0, 0), {"rotation": 45}).grid((1, 3), (0, 10))
        document.blocks.new("R").add_blockref("Q", (0, 0), {"rotation": 30})
        space.add_blockref("R", (5, 6), {"xscale": 3, "yscale": 1})

    drawing = read_drawing(put(draw), tolerance=1e-5)
    found = {layer.name: layer.strokes for layer in drawing.layers}

    def at(x, y):
        """Where a point of the first block comes to lie."""
        c, s = np.cos(np.radians(75)), np.sin(np.radians(75))
        return 3 * (c * x - s * y) + 5, s * x + c * y + 6

    for number, line in enumerate(sorted(found["l"], key=lambda stroke: stroke.points[0][1])):
        assert line.points == pytest.approx(np.array([at(10 * number, 0), at(10 * number + 1, 0)]), abs=1e-12)
    assert len(found["l"]) == len(found["c"]) == 3
    circle = np.array(min(found["c"], key=lambda stroke: stroke.points[0][1]).points)
    c, s = np.cos(np.radians(75)), np.sin(np.radians(75))
    x, y = (circle[:, 0] - 5) / 3, circle[:, 1] - 6
    assert np.hypot(c * x + s * y - 1, c * y - s * x) == pytest.approx(0.5, abs=1e-9)


# --- splines ----------------------------------------------------------------------------------------------------------


def test_a_spline_costs_what_its_points_number(put, monkeypatch):
    """A point of it is made of the control points that count there; ezdxf goes through all of them for each."""
    whole, seen = dxf._de_boor, set()

    def counted(corners, knots, at):
        seen.add((len(corners), len(knots)))
        return whole(corners, knots, at)

    monkeypatch.setattr(dxf, "_de_boor", counted)
    read_drawing(put(lambda space, _: space.add_open_spline([(n, n % 7) for n in range(300)])))
    assert seen == {(4, 6)}


def test_points_of_splines_are_those_of_the_whole_curve():
    dice = np.random.default_rng(4)
    for _ in range(200):
        degree = int(dice.choice([1, 2, 3, 5, 9]))
        count = int(dice.integers(degree + 1, 14))
        inner = np.sort(dice.choice([0.25, 0.5, *dice.uniform(0.1, 0.9, 9)], count - degree - 1))
        weights = dice.uniform(0.3, 3, count).tolist() if dice.random() < 0.5 else None
        knots = [*(degree + 1) * [0.0], *inner.tolist(), *(degree + 1) * [1.0]]
        curve = BSpline(dice.uniform(0, 1, (count, 2)).tolist(), degree + 1, knots, weights)
        for at, (begin, end) in dxf._DxfReader._parts_of(None, curve):
            for way in (0.0, 0.3, 0.7):
                place, exact = at(begin + way * (end - begin)), curve.point(begin + way * (end - begin))
                assert hypot(place.x - exact.x, place.y - exact.y) < 1e-12


@pytest.mark.parametrize(
    ("draw", "said"),
    [
        (lambda space, _: space.add_spline([(n, n % 7) for n in range(10_001)]), "runs through 10,001 points"),
        (
            lambda space, _: [space.add_spline([(n, n % 7) for n in range(4000)]) for _ in range(7)],
            "runs through 4,000 points, and at most 10,000",
        ),
        (
            lambda space, _: space.add_open_spline([(n, n % 7) for n in range(20)], 11),
            "degree 11; at most 10",
        ),
    ],
)
def test_splines_have_bounds(put, draw, said, monkeypatch):
    monkeypatch.setattr("ezdxf.entities.Spline.construction_tool", lambda _: BSpline([(0, 0), (1, 1), (2, 0)], 3))
    refused(put(draw), said)


# --- texts ------------------------------------------------------------------------------------------------------------


def test_letters_of_copies_have_a_bound(put, monkeypatch):
    assert svg.MOST_LETTERS == 30_000_000
    monkeypatch.setattr(svg, "MOST_LETTERS", 10_000)
    long = f'<defs><path id="a" d="M0 0L1 1{3000 * " "}"/></defs>'
    assert read_drawing(put(long + 3 * '<use href="#a"/>'))
    refused(put(long + 4 * '<use href="#a"/>'), "have more than 10,000 letters, copies counted")
    refused(put(f"<style>.a {{fill: {4000 * 'x'}}}</style>" + 3 * '<path class="a" d="M0 0L1 1"/>'), "10,000 letters")


def test_rules_of_a_style_sheet_have_a_bound(put, monkeypatch):
    assert attributes.MOST_TRIED == 3_000_000
    monkeypatch.setattr(attributes, "MOST_TRIED", 1000)
    rules = f"<style>{50 * '.a {fill: red}'}</style>"
    assert read_drawing(put(rules + 19 * '<path class="a a a" d="M0 0L1 1"/>'))
    refused(put(rules + 21 * '<path class="a" d="M0 0L1 1"/>'), "more than 1,000 are to be held against them")


@pytest.mark.parametrize(
    ("text", "rules", "body"),
    [
        ("/* a /* b */ .c {d: e} /* open", [("  .c ", "d: e")], "  .c {d: e} /* open"),
        ("a{b}c{d", [("a", "b")], "a{b}c{d"),
        ("@media x {a{b:c} d{e:f}}", [("a", "b:c"), (" d", "e:f")], "@media x {a{b:c} d{e:f}}"),
        ("/*/ a{b} */c{d}/**/", [(" c", "d")], " c{d} "),
        ("}} {x}", [(" ", "x")], "}} {x}"),
        (20_000 * "/* ", [], 20_000 * "/* "),
        (20_000 * "a", [], 20_000 * "a"),
    ],
)
def test_rules_and_comments_of_a_style_sheet(text, rules, body):
    assert list(attributes._rules(text)) == rules and attributes._uncommented(text) == body


@pytest.mark.parametrize("text", [f"{3000 * '1'}!", f"1{3000 * ' '}!", f"{101 * '1'}"])
def test_a_length_of_too_many_letters_is_none(text):
    with pytest.raises(ValueError, match="is no length"):
        svg.length(text, 1.0)


@pytest.mark.parametrize("path", ["M0 0L1e 2 3", "M0 0L1 2e", "M0 0L1 2E L3 4"])
def test_an_exponent_without_digits_is_none(put, path):
    refused(put(f'<path d="{path}"/>'), "is no path")


def test_rows_and_cells_of_a_table_have_bounds(put, monkeypatch):
    assert (survey.MOST_LINES, survey.MOST_COLUMNS, survey.LONGEST_HEAD) == (2_000_000, 10_000, 60)
    rows = "chainage (m),level (m)\n" + "".join(f"{x},0\n" for x in range(40))
    for ends in ("\n", "\r\n", "\r"):
        assert read_drawing(put(rows.replace("\n", ends), "csv"))
    refused(put("x," * 10_001 + "\n1,2\n", "csv"), r"a\.csv:1: has 10,001 cells or blanks; at most 10,000")
    refused(put("chainage (m),level (m)\n1," + ";" * 10_001, "csv"), r"a\.csv:2: has 10,001 cells")
    refused(put(f"{61 * 'x'},y\n1,2\n", "csv"), "0 of them are a chainage")
    monkeypatch.setattr(survey, "MOST_LINES", 50)
    refused(put(rows + 10 * "\n", "csv"), "has 51 lines; at most 50 are read")
    seen = Counter()
    monkeypatch.setattr("lammps_jump.drawings.strokes.MOST_POINTS", 20)
    monkeypatch.setattr(survey, "number_of", lambda cell: seen.update(["cell"]) or float(cell))
    refused(put(rows, "csv"), "needs 21 points or more")
    assert seen["cell"] == 42  # no row behind the last one that has room


def test_no_pattern_takes_a_row_of_digits_in_two_ways():
    """Where a point may be missing between two rows of digits, a long number that ends wrongly takes its square."""
    package = Path(lammps_jump.__file__).parent
    wrong = [
        f"{path.relative_to(package)}: {line.strip()}"
        for folder in (package, package / "analysis") for path in sorted(folder.rglob("*.py"))
        for line in path.read_text().splitlines() if re.search(r"(\\d|\d|\[0-9\])[+*]\\\.\?(\\d|\d|\[0-9\])[+*]", line)
    ]  # fmt: skip
    assert wrong == []


# --- time and memory --------------------------------------------------------------------------------------------------

TABLE = "chainage (m),level (m)\n0,0\n1,1\n"


def rises(_data, _file):
    """A reader that is still at it when its time is over, and catches what it can."""
    try:
        signal.raise_signal(signal.SIGPROF)
    except Exception:
        pass
    return "goes on"


def asks(*_given):
    raise MemoryError


@pytest.mark.parametrize(
    ("where", "stand_in", "said"),
    [
        (
            "lammps_jump.drawings.read.read_survey",
            rises,
            "took more than 120 s and was left; draw what are walls alone",
        ),
        ("lammps_jump.drawings.read.read_survey", asks, "it asks for more memory than there is"),
        ("lammps_jump.drawings.doubts", asks, "takes more than 4 GB of memory and was left; draw what"),
    ],
)
def test_work_on_a_drawing_is_left_in_a_sentence(put, monkeypatch, capsys, where, stand_in, said):
    """What the clock would do is done by the reader itself, so that no time passes."""
    path = put(TABLE, "csv")
    before = signal.getsignal(signal.SIGPROF), resource.getrlimit(resource.RLIMIT_DATA)
    monkeypatch.setattr(where, stand_in)
    status, printed, error = call(monkeypatch, capsys, "import", path)
    assert status == 2 and f"{path}: " in error and said in error and not printed
    assert len(error.splitlines()) == 1
    assert (signal.getsignal(signal.SIGPROF), resource.getrlimit(resource.RLIMIT_DATA)) == before
    assert signal.getitimer(signal.ITIMER_PROF) == (0, 0)


def test_import_has_a_bound_of_processor_time_and_of_memory(put, monkeypatch, capsys):
    assert (foreign.MOST_SECONDS, foreign.MOST_MEMORY) == (120, 4_000_000_000)
    seen = []
    monkeypatch.setattr(signal, "setitimer", lambda *given: seen.append(given))
    monkeypatch.setattr(resource, "setrlimit", lambda *given: seen.append(given))
    assert call(monkeypatch, capsys, "import", put(TABLE, "csv"))[0] == 0
    whole = resource.getrlimit(resource.RLIMIT_DATA)
    assert (signal.ITIMER_PROF, 120, 1) in seen and seen[-2:] == [
        (signal.ITIMER_PROF, 0),
        (resource.RLIMIT_DATA, whole),
    ]
    assert (resource.RLIMIT_DATA, (4_000_000_000, whole[1])) in seen or 0 <= whole[0] <= 4_000_000_000
