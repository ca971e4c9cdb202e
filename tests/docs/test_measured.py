# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured tables of the site are of today's cases, and each has a page that shows it."""

import json
import shutil
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from making import laws, measured  # noqa: E402

pytestmark = pytest.mark.prose
LAW = laws.find_laws(laws.TREE, ["starting_angle"])["starting_angle"]
FILES = sorted(path.stem for path in measured.FOLDER.glob("*.json"))


@pytest.mark.parametrize("name", FILES)
def test_measured_cases_are_those_of_today(name):
    assert not measured.stale(name), f"make measured X={name} measures them again"


@pytest.mark.parametrize("name", FILES)
def test_fragment_has_a_row_for_each_measurement(name):
    text = measured.fragment(name)
    assert text.count("|---") > 1
    assert "commit `" in text
    assert text.count("\n|") > 3


def test_a_stale_table_is_found(tmp_path):
    shutil.copy(measured.FOLDER / "sensitivity_restitution.json", tmp_path)
    path = tmp_path / "sensitivity_restitution.json"
    assert not measured.stale(path.stem, tmp_path)
    data = json.loads(path.read_text())
    first, *_, last = data["keys"]
    data["keys"] |= {first: "0" * 12}
    del data["keys"][last]
    data["keys"]["a case that is gone"] = "1" * 12
    path.write_text(json.dumps(data))
    assert measured.stale(path.stem, tmp_path) == sorted([first, last, "a case that is gone"])
    with pytest.raises(ValueError, match=r"a case that is gone.*make measured X=sensitivity_restitution"):
        measured.fragment(path.stem, tmp_path)


def test_a_law_that_has_changed_is_found(tmp_path):
    folder = Path(shutil.copytree(laws.TREE / "starting_angle", tmp_path / "starting_angle"))

    def key(name, old, new):
        path = folder / name
        before = path.read_text()
        path.write_text(before.replace(old, new))
        found = laws.key(folder, LAW)
        path.write_text(before)
        return found

    same = laws.keys()["starting_angle"]
    assert laws.key(folder, LAW) == key("law.py", "def figure(", "def figure(  ") == same
    assert key("law.py", "-0.5", "-0.6") != same
    assert key("measure.py", "import", "import  ") != same


def test_figures_are_drawn_from_the_stored_rows(tmp_path):
    text = measured.fragment("sensitivity_sill", place=tmp_path)
    assert "](_made/measured/sensitivity_sill.png)" in text
    assert (tmp_path / "sensitivity_sill.png").stat().st_size > 5000


def test_each_file_is_shown_on_a_page_and_known():
    shown = {line for page in DOCS.glob("*.md") for line in page.read_text().splitlines() if "_made/measured/" in line}
    assert {line.split("_made/measured/")[1].removesuffix(".md") for line in shown} == set(FILES)
    assert set(FILES) <= set(measured.MEASURES)
