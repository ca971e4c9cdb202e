# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs in a notebook: a player where anywidget is installed, pictures where it is not."""

import sys

import pytest
from made_up import BOX

import lammps_jump as lj
from lammps_jump.errors import DumpError, SetupError


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return lj.load_case(BOX).run(tmp_path_factory.mktemp("notebook") / "box")


def test_a_run_shows_its_player(run):
    bundle = run._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "application/vnd.jupyter.widget-view+json" in data
    widget = run.widget()
    assert widget.time == 0.0 and widget.title == "box" and widget.page.count('<div class="player"') == 1
    assert "parent.postMessage" in widget.page and "<h1>" not in widget.page
    sent = []
    widget.send = sent.append
    widget.seek(0.2)
    assert sent == [{"seek": 0.2}]


def test_reports_tell_no_frame_their_time(run):
    assert "parent.postMessage" not in run.report().read_text()


def test_without_anywidget_a_run_shows_pictures(run, monkeypatch):
    from lammps_jump.analysis.report import player

    monkeypatch.setattr(player.importlib.util, "find_spec", lambda name: None)
    assert run._repr_mimebundle_() == {}
    assert "<img alt=" in run._repr_html_()
    player._widget_class.cache_clear()
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(SetupError, match=r"pip install 'lammps-jump\[notebook\]'"):
        run.widget()
    player._widget_class.cache_clear()


def test_a_run_without_frames_has_nothing_to_play(run, monkeypatch):
    monkeypatch.setattr(lj.runs.results, "player_of", lambda case, folder: None)
    with pytest.raises(DumpError, match="nothing to play"):
        run.widget()
    assert run._repr_mimebundle_() == {}


def test_a_case_shows_its_drawing():
    assert "<svg" in lj.load_case(BOX)._repr_html_()
