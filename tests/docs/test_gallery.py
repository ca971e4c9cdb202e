# SPDX-License-Identifier: GPL-2.0-or-later
"""Stored results of the gallery are of today's cases, and small."""

import html
import json
import re
import shutil
import sys
from pathlib import Path

import pytest
from PIL import Image

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from making import gallery  # noqa: E402

import lammps_jump as lj  # noqa: E402

pytestmark = pytest.mark.prose
LARGEST = 10_000_000
"""Bytes of all stored results: git keeps each form of them."""


def test_stored_results_are_of_todays_cases():
    assert not gallery.stale(), "make gallery makes them again"
    assert set(gallery.PLAYED) <= set(gallery.scenes())


def test_stored_results_are_whole_and_small():
    names = {f"{name}{kind}" for name in gallery.scenes() for kind in (".png", "_small.png", ".json")}
    wanted = names | {f"{name}.html" for name in gallery.PLAYED} | {"film.mp4", "film.json", "notebook.json"}
    kept = [path for path in gallery.FOLDER.iterdir() if path.suffix != ".html" or path.stem in gallery.PLAYED]
    assert {path.name for path in kept} == wanted
    assert sum(path.stat().st_size for path in kept) < LARGEST
    kept_by_git = (DOCS.parent / ".gitignore").read_text().split()
    assert [f"!/docs/stored/{name}.html" for name in gallery.PLAYED] == [one for one in kept_by_git if one[0] == "!"]


def test_each_scene_is_in_one_group_and_has_its_verdict():
    grouped = [name for titles in gallery.GROUPS.values() for name in titles]
    assert sorted(grouped) == sorted(gallery.scenes())
    assert all("verdict" in json.loads((gallery.FOLDER / f"{name}.json").read_text()) for name in grouped)


def test_the_picture_of_the_report_in_readme_is_of_the_report_that_is_kept():
    with Image.open(DOCS / "figures" / "report.png") as picture:
        seen = json.loads(picture.text["numbers"])
    page = (gallery.FOLDER / "quick_jump.html").read_text()
    title = html.unescape(re.search("<h1>(.*?)</h1>", page)[1])
    boxes = re.findall('<div><dt>(.*?)</dt><dd>(.*?)</dd>(?:<dd class="against".*?>(.*?)</dd>)?</div>', page, re.DOTALL)
    shown = [title, *("".join(map(html.unescape, filter(None, re.split("<.*?>", "\n".join(box))))) for box in boxes)]
    assert len(seen) >= 4 and [text.split() for text in seen] == [text.split() for text in shown]


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


def test_a_build_simulates_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(lj.Case, "run", None)
    gallery.make(tmp_path)
    page = (tmp_path / "_made" / "gallery.md").read_text()
    for name in gallery.scenes():
        assert f"inputs/{name}.yaml" in page and (tmp_path / "_made" / "gallery" / f"{name}_small.png").is_file()
    for name in gallery.PLAYED:
        assert f"reports/{name}.html" in page and (tmp_path / "_made" / "extra" / "reports" / f"{name}.html").is_file()
    cells = json.loads(gallery.NOTEBOOK.read_text())["cells"]
    assert all(cell["outputs"] for cell in cells[2:] if cell["cell_type"] == "code")


def test_live_pages_that_are_there_are_linked_and_others_are_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "live_scenes", list)
    gallery.make(tmp_path)
    assert "`make gallery X=live`" in (tmp_path / "_made" / "gallery.md").read_text()
    assert "howto/live.md" in (tmp_path / "_made" / "live.md").read_text()
    stored = shutil.copytree(gallery.FOLDER, tmp_path / "stored")
    (stored / "quick_jump_live.html").write_text("live")
    monkeypatch.undo()
    monkeypatch.setattr(gallery, "FOLDER", stored)
    gallery.make(tmp_path)
    assert 'href="reports/quick_jump_live.html"' in (tmp_path / "_made" / "gallery.md").read_text()
    assert 'href="reports/quick_jump_live.html"' in (tmp_path / "_made" / "live.md").read_text()
    assert (tmp_path / "_made" / "extra" / "reports" / "quick_jump_live.html").read_text() == "live"


def test_a_run_that_was_left_by_an_ended_build_is_made_anew(tmp_path):
    case = lj.load_case(gallery.INPUTS / "energy_box_7.yaml", {"run.duration": 0.02, "analysis.figures": "none"})
    other = lj.load_case(gallery.INPUTS / "energy_box_7.yaml", {"run.duration": 0.01, "analysis.figures": "none"})
    gallery.run(other, tmp_path / "run")
    assert gallery.run(case, tmp_path / "run").summary["simulated_time"] == pytest.approx(0.02, rel=1e-3)  # whole steps


def test_each_scene_has_a_card(tmp_path):
    assert all(f":link: scene-{name}\n" in gallery.contents() for name in gallery.scenes())
    Image.new("RGB", (100, 400)).save(tmp_path / "tall.png")
    gallery.fit(tmp_path / "tall.png", tmp_path / "card.png")
    with Image.open(tmp_path / "card.png") as card:
        assert card.size == gallery.CARD
