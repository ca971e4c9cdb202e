# SPDX-License-Identifier: GPL-2.0-or-later
"""What is described is what is drawn, by matplotlib and by the page."""

import json
import os
import threading

import numpy as np
import pytest

from lammps_jump.analysis.draw.chart import MOST_POINTS, PLACE, TIME, Bars, Chart, Panel, Trace, stairs, thinned
from lammps_jump.analysis.draw.style import drawn
from lammps_jump.analysis.pipeline import aside
from lammps_jump.errors import DumpError
from lammps_jump.files import plain

T = np.linspace(0.0, 2.0, 11)


def chart():
    depth = np.where(T == 1.0, np.nan, T**2 / 3)
    lines = (
        Trace("depth", T, depth, error=0.1 + 0 * T),
        Trace("theory", T, T / 3, "theory"),
        stairs("bins", T[1:], T),
    )
    return Chart("A flow", TIME, (Panel("Depth [m]", lines, levels={"y₁": 0.5}, marks={"toe": 1.5}),), (1.0, 2.0))


def test_the_page_gets_the_numbers_of_the_figure():
    found = json.loads(json.dumps(plain(chart().plain), allow_nan=False))
    assert found["time"] and found["window"] == [1.0, 2.0]
    (panel,) = found["panels"]
    depth, theory, bins = panel["lines"]
    axes = drawn(chart()).axes[0]
    for line, other in zip(panel["lines"], axes.lines, strict=False):
        x, y = (np.array(line.get(key, depth["x"]), float) for key in "xy")
        np.testing.assert_allclose(x, other.get_xdata(), rtol=1e-4)
        np.testing.assert_allclose(y, other.get_ydata(), rtol=1e-4)
    assert depth["y"][5] is None and depth["error"] == [0.1] * 11
    assert "x" not in theory and len(bins["x"]) == 20  # one abscissa is written once
    assert panel["levels"] == [["y₁", 0.5]] and panel["marks"] == [["toe", 1.5]]
    assert axes.get_ylabel() == panel["y"] and axes.get_xlabel() == found["x"] == TIME
    assert not Chart("", PLACE, ()).plain["time"]


def test_bars():
    bars = Bars("Balance", "Share [%]", {"one": -1.25, "sum": 2.0})
    assert bars.plain["bars"] == [["one", -1.25], ["sum", 2.0]]
    (axes,) = drawn(bars).axes
    assert [bar.get_width() for bar in axes.patches] == [-1.25, 2.0]


def test_a_long_line_keeps_its_peaks():
    x = np.arange(100_000.0)
    y = np.random.default_rng(1).normal(size=len(x))
    y[[17, 44_444, 99_998]] = 50.0, -60.0, np.nan
    found = thinned(Trace("force", x, y, error=x))
    assert len(found.x) <= MOST_POINTS and np.all(np.diff(found.x) > 0)
    assert np.nanmax(found.y) == 50.0 and np.nanmin(found.y) == -60.0
    np.testing.assert_array_equal(found.y, y[found.x.astype(int)])
    np.testing.assert_array_equal(found.error, found.x)


@pytest.mark.parametrize("threads", [1, 2])
def test_work_aside_is_done_when_the_block_is_left(tmp_path, monkeypatch, threads):
    """By another process, but for threads: a copy could wait forever for a lock that one of them holds."""
    monkeypatch.setattr(threading, "active_count", lambda: threads)
    with aside(lambda path: path.write_text(str(os.getpid())), tmp_path / "done") as later:
        assert not hasattr(later, "value")
    assert later.value == len((tmp_path / "done").read_text())
    assert ((tmp_path / "done").read_text() == str(os.getpid())) is (threads > 1)


def test_what_fails_aside_is_told_here(tmp_path):
    def work():
        raise DumpError("it cannot be drawn")

    with pytest.raises(DumpError, match="cannot be drawn"), aside(work):
        pass


def test_an_error_of_the_block_ends_the_work(tmp_path):
    def work():
        while True:
            (tmp_path / "here").touch()

    with pytest.raises(KeyboardInterrupt), aside(work):
        raise KeyboardInterrupt
