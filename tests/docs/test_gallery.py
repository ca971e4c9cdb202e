# SPDX-License-Identifier: GPL-2.0-or-later
"""Stored results of the gallery are of today's cases, and small."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from PIL import Image

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from making import gallery  # noqa: E402

import lammps_jump as lj  # noqa: E402
from lammps_jump.case.templates import scene_names  # noqa: E402

LARGEST = 4_500_000
"""Bytes of all stored results: git keeps each form of them."""


def test_stored_results_are_of_todays_cases():
    assert not gallery.stale(), "make gallery makes them again"
    assert set(gallery.STORED) <= set(scene_names())


def test_stored_results_are_whole_and_small():
    wanted = {f"{name}.{kind}" for name in gallery.STORED for kind in ("png", "html", "json")}
    assert {path.name for path in gallery.FOLDER.iterdir()} == wanted
    assert sum(path.stat().st_size for path in gallery.FOLDER.iterdir()) < LARGEST


def test_a_stale_or_missing_result_stops_the_build(tmp_path, monkeypatch):
    stored = shutil.copytree(gallery.FOLDER, tmp_path / "stored")
    path = stored / "spillway.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"key": "0" * 12}))
    assert gallery.stale(stored) == ["spillway"]
    path.unlink()
    assert gallery.stale(stored) == ["spillway"]
    monkeypatch.setattr(gallery, "stale", lambda: ["spillway"])
    with pytest.raises(ValueError, match="spillway; make gallery"):
        gallery.make(tmp_path)


def test_a_run_that_was_left_by_an_ended_build_is_made_anew(tmp_path):
    case = lj.load_case(gallery.INPUTS / "energy_box_7.yaml", {"run.duration": 0.02, "analysis.figures": "none"})
    other = lj.load_case(gallery.INPUTS / "energy_box_7.yaml", {"run.duration": 0.01, "analysis.figures": "none"})
    gallery.run(other, tmp_path / "run")
    assert gallery.run(case, tmp_path / "run").summary["simulated_time"] == pytest.approx(0.02, rel=1e-3)  # whole steps


def test_each_scene_has_a_card(tmp_path):
    assert all(f":link: scene-{name}\n" in gallery.contents() for name in scene_names())
    Image.new("RGB", (100, 400)).save(tmp_path / "tall.png")
    gallery.fit(tmp_path / "tall.png", tmp_path / "card.png")
    with Image.open(tmp_path / "card.png") as card:
        assert card.size == gallery.CARD
