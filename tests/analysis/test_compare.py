# SPDX-License-Identifier: GPL-2.0-or-later
"""Two runs on one page: numbers with their difference, curves on the same axes."""

import copy
import json
import re

import numpy as np
import pytest

from lammps_jump.analysis.draw.chart import TIME, Bars, Chart, Panel, Trace
from lammps_jump.analysis.report.handed_on import read_curves
from lammps_jump.analysis.report.page import Curve
from lammps_jump.analysis.report.run import Side, comparison
from lammps_jump.errors import DumpError
from lammps_jump.files import CURVES, write_json

T = np.linspace(0.0, 2.0, 5)
HOSTILE = "</script><b>run</b>"


def side(name, top, *, y2, error=None, more=None):
    lines = (Trace("front", T, top * T), Trace("", T, 100 * T, "faint"))
    chart = Chart("front", TIME, (Panel("Distance x [m]", lines, levels={"free": 0.5}),))
    curves = {"front.png": Curve("Front", chart.plain)} | (more or {})
    jump = {"verdict": "jump", "y2": y2, "y2_error": error, "speed": None}
    force = {"sill": {"peak": 1000.0, "peak_error": 30.0}, "notes": []}
    return Side(name, {"jump": jump, "force": force}, curves, None)


@pytest.fixture
def page():
    left = side(HOSTILE, 1.0, y2=3.0, error=0.03, more={"energy.png": Curve("Energy", {"title": "", "bars": []})})
    return comparison(left, side("other", 4.0, y2=3.5, error=0.04))


def test_numbers_stand_beside_each_other_with_their_difference(page):
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", page, re.S)]
    found = {row[0]: row[1:] for row in rows if row}
    (depth,) = (cells for label, cells in found.items() if label.startswith("Sequent depth, by mass"))
    assert depth == ["3.000", "3.500", "0.500"]
    assert found["sill: Peak force [kN/m]"] == ["1.000", "1.000", "0.000"]
    assert not any("elocity of the front" in label for label in found)  # neither has it


def test_curves_of_both_have_the_same_axes(page):
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page)[1])
    assert len(data["curves"]) == 2 and page.count('<figure class="curve"') == 2
    for curve in data["curves"]:
        (panel,) = curve["panels"]
        assert panel["xlim"] == [0, 2] and panel["ylim"] == [0, 8]  # what is drawn faintly does not set the scale
    assert "Of one run alone" in page and "Energy" in page


def test_names_are_text(page):
    assert HOSTILE not in page and "&lt;b&gt;run" in page


CHARTS = {
    "front": Chart(
        "front",
        TIME,
        (
            Panel(
                "Distance x [m]",
                (Trace("front", T, T, error=0 * T), Trace("b", T, -T)),
                "",
                {"free": 0.5},
                {"toe": 1.0},
            ),
        ),
        window=(0.0, 1.0),
    ).plain,
    "jump_balance": Bars("balance", "m2/s", {"in": 1.0, "out": float("nan")}).plain,
}


def places(data, path=()):
    """Every place in plain data."""
    yield path
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    for key, item in items:
        yield from places(item, (*path, key))


def test_curves_are_read_as_they_were_written(tmp_path):
    assert read_curves(tmp_path) == {}
    write_json(tmp_path / CURVES, CHARTS)
    found = read_curves(tmp_path)
    assert list(found) == list(CHARTS)
    assert json.loads(json.dumps(found)) == json.loads((tmp_path / CURVES).read_text())


@pytest.mark.fault("values in JSON files")
def test_curves_that_were_handed_on_are_checked_by_field(tmp_path, tried):
    """A value of another kind at any place is refused, or is one that the page can draw."""
    write_json(tmp_path / CURVES, CHARTS)
    whole, number = json.loads((tmp_path / CURVES).read_text()), 0
    for path in places(whole):
        for odd in (True, "t", -1e308, {}, [], [None], {"x": [1]}, None):
            data = copy.deepcopy(whole)
            if path:
                place = data
                for key in path[:-1]:
                    place = place[key]
                place[path[-1]] = odd
            else:
                data = odd
            write_json(tmp_path / CURVES, data)
            number += 1
            try:
                curves = {name: Curve("", one) for name, one in read_curves(tmp_path).items()}
            except DumpError as error:
                assert CURVES in str(error) and "makes it again" in str(error)
                continue
            comparison(Side("a", {}, curves, None), Side("b", {}, curves, None))
    tried(number)
    for text in ("", "{", 100_000 * "[", "\x00"):
        (tmp_path / CURVES).write_text(text)
        with pytest.raises(DumpError, match=CURVES):
            read_curves(tmp_path)
