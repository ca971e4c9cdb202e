# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves of a page in Chromium: they show the numbers, follow the time, ask for another one, and leave as CSV."""

import numpy as np
import pytest
from chromium import PROGRAM, Page, chromium

from lammps_jump.analysis.draw.chart import PLACE, TIME, Bars, Chart, Panel, Trace
from lammps_jump.analysis.report.page import Curve, Section, render

pytestmark = [pytest.mark.browser, pytest.mark.skipif(not PROGRAM, reason="Chromium is not installed")]

T = np.linspace(0.0, 10.0, 41)
HELPERS = """
const svg = document.querySelector('figure.curve svg[role=img]'), area = svg.querySelector('clipPath rect');
const [left, width] = ['x', 'width'].map((key) => Number(area.getAttribute(key)));
const point = (type, share) => {
  const box = svg.getBoundingClientRect();
  svg.dispatchEvent(new PointerEvent(type, { clientX: box.left + left + share * width, clientY: box.top + 30 }));
};
const now = () => ['visibility', 'x1'].map((key) => svg.querySelector('.now').getAttribute(key));
const every = [...document.querySelectorAll('figure.curve svg[role=img]')];
"""
"""Of the first chart; `point` makes an event of the pointer at a share of the abscissa."""
HOSTILE = "</script><b>=1+1</b>"


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as running:
        yield running


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    depth = np.where((T > 4) & (T < 5), np.nan, 2 + np.sin(T))
    lines = (Trace("depth", T, depth, error=0.1 + 0 * T), Trace(HOSTILE, T, T / 5, "theory"))
    charts = (
        Chart("a flow", TIME, (Panel("Depth [m]", lines, levels={"y₁": 0.5}, marks={HOSTILE: 5.0}),), (6.0, 8.0)),
        Chart("beside", PLACE, (Panel("h", (Trace("h", T, T),), "τ"), Panel("u", (Trace("u", T, T),), "T"))),
        Bars("parts", "Share [%]", {"one": -1.25, "sum": 2.0}),
    )
    page = render("Curves", [Section("", [Curve(f"chart {i}", one.plain) for i, one in enumerate(charts)])])
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(page)
    return path


@pytest.fixture
def page(browser, path):
    page = Page(browser, path)
    page.run(HELPERS)
    yield page
    assert not page.troubles()


def test_curves_are_drawn(page):
    assert page.run("every.length") == 4
    assert page.run("svg.querySelectorAll('path.curve-line').length") == 2
    drawn = page.run("svg.querySelector('path.curve-line').getAttribute('d')")
    assert drawn.count("M") == 2 and drawn.count(",") == len(T) - 3  # a gap of three
    assert page.run("document.querySelector('.legend').textContent").endswith(HOSTILE)
    assert page.run("document.querySelectorAll('figure b').length") == 4  # of the values: no text is taken for a tag


def test_values_are_shown_under_the_pointer(page):
    page.run("point('pointermove', 0.25)")
    values = page.run("[...document.querySelectorAll('.legend b')].map((b) => b.textContent)")
    assert float(values[0]) == pytest.approx(2 + np.sin(2.5), abs=1e-3)
    assert values[1] == "0.5"
    page.run("point('pointerleave', 0.25)")
    assert not page.run("document.querySelector('.legend b').textContent")


def test_curves_follow_the_time_and_ask_for_another(page):
    assert page.run("now()")[0] == "hidden"
    seen = []
    for time in (2.0, 4.0, 99.0):
        page.run(f"document.dispatchEvent(new CustomEvent('time', {{detail: {time}}}))")
        seen.append(page.run("now()"))
    left, width = page.run("[left, width]")
    assert [shown for shown, _ in seen] == ["visible", "visible", "hidden"]
    assert [float(x) for _, x in seen[:2]] == pytest.approx([left + 0.2 * width, left + 0.4 * width])
    page.run("document.addEventListener('seek', (event) => { asked = event.detail; }); var asked = null")
    page.run("point('click', 0.75)")
    assert page.run("asked") == pytest.approx(7.5, abs=10 / width)  # the pointer stands on whole pixels


def test_data_leave_as_csv(page):
    page.run("var told; URL.createObjectURL = (blob) => { told = blob.text(); return 'data:,'; }")
    page.run("document.querySelector('figure.curve button').click()")
    head, *rows = page.run("told").splitlines()
    assert head == f'"{TIME}","Depth [m]: depth","depth: standard error","Depth [m]: {HOSTILE}"'
    table = [[float(cell) if cell else None for cell in row.split(",")] for row in rows]
    assert len(table) == 41 and table[17][1] is None
    np.testing.assert_allclose([row[0] for row in table], T, rtol=1e-4)
    assert table[10][1:] == pytest.approx([2 + np.sin(2.5), 0.1, 0.5], rel=1e-4)


@pytest.mark.parametrize("look", [{"phone": True, "width": 390, "height": 844}, {"dark": True}])
def test_curves_fit_the_screen(browser, path, look):
    page = Page(browser, path, **look)
    page.run(HELPERS)
    assert page.run("every.every((one) => one.clientWidth <= innerWidth && one.clientWidth > 300)")
    assert page.run("document.documentElement.scrollWidth <= innerWidth")
    colour = page.run("getComputedStyle(document.querySelector('path.curve-line')).stroke")
    assert (colour == "rgb(26, 78, 143)") is not look.get("dark", False)


def test_without_scripts_no_empty_frames_are_left(browser, path):
    """Nothing of a figure is laid out that only a script could fill."""
    page = Page(browser, path, scripts=False)
    root = page.call("DOM.getDocument")["root"]["nodeId"]
    figure = page.call("DOM.querySelector", nodeId=root, selector="figure.curve")["nodeId"]
    with pytest.raises(RuntimeError, match="box model"):
        page.call("DOM.getBoxModel", nodeId=figure)
