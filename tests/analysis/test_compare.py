# SPDX-License-Identifier: GPL-2.0-or-later
"""Two runs on one page: numbers with their difference, curves on the same axes."""

import json
import re

import numpy as np
import pytest

from lammps_jump.analysis.draw.chart import TIME, Chart, Line, Panel
from lammps_jump.analysis.report.compare import Side, comparison
from lammps_jump.analysis.report.page import Curve

T = np.linspace(0.0, 2.0, 5)
HOSTILE = "</script><b>run</b>"


def side(name, top, *, y2, error=None, more=None):
    lines = (Line("front", T, top * T), Line("", T, 100 * T, "faint"))
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
    assert found["sill: Peak force [N/m]"] == ["1000", "1000", "0"]
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
