# SPDX-License-Identifier: GPL-2.0-or-later
"""`show` and `compare` print the path of a page, and open it where there is a display; `figures` draws all."""

import shutil
import webbrowser
from pathlib import Path

import pytest
from made_up import INPUTS, call

import lammps_jump as lj
from lammps_jump.analysis import pipeline
from lammps_jump.files import STUDY_FILES
from lammps_jump.folders import Marker, write_marker
from lammps_jump.runs import start

SHORT = {"run.duration": 0.3, "run.output_interval": 0.05, "engine.name": "native"}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    place, case = tmp_path_factory.mktemp("shown"), lj.load_case(INPUTS / "quick_jump.yaml", SHORT)
    first = case.run(place / "seed1").folder
    return [first, Path(shutil.copytree(first, place / "seed2"))]


@pytest.fixture
def opened(monkeypatch):
    pages = []
    monkeypatch.setattr(webbrowser, "open", pages.append)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)
    return pages


def test_the_report_is_opened_where_there_is_a_display(folders, opened, monkeypatch, capsys):
    path = folders[0] / "report.html"
    assert call(monkeypatch, capsys, "show", folders[0]) == (0, f"{path}\n", "") and not opened
    monkeypatch.setenv("DISPLAY", ":7")
    assert call(monkeypatch, capsys, "show", folders[0])[1] == f"{path}\n" and opened == [path.as_uri()]


def test_a_folder_without_a_report_is_refused(tmp_path, opened, monkeypatch, capsys):
    status, out, error = call(monkeypatch, capsys, "show", tmp_path)
    assert status == 2 and not out and "there is no report; `lammps-jump analyze" in error


def test_the_page_of_a_study_is_opened(tmp_path, opened, monkeypatch, capsys):
    (tmp_path / "study.yaml").touch()
    status, _, error = call(monkeypatch, capsys, "show", tmp_path)
    assert status == 2 and f"`lammps-jump sweep {tmp_path}` makes it" in error
    (tmp_path / "sweep.html").touch()
    assert call(monkeypatch, capsys, "show", tmp_path) == (0, f"{tmp_path / 'sweep.html'}\n", "")


def test_the_page_of_each_command_is_opened(tmp_path, opened, monkeypatch, capsys):
    """A search was told to `sweep`, a budget to `analyze`, beside their pages."""
    for kind, page in (("find", "find.html"), ("budget", "budget.html"), ("validate", "report.html")):
        folder = tmp_path / kind
        folder.mkdir()
        write_marker(folder, Marker(kind, STUDY_FILES[kind], {}))
        (folder / "study.yaml").touch()
        status, _, error = call(monkeypatch, capsys, "show", folder)
        assert status == 2 and f"`lammps-jump {kind}`" in error and page in error
        (folder / page).touch()
        assert call(monkeypatch, capsys, "show", folder) == (0, f"{folder / page}\n", "")
    with pytest.raises(lj.CaseError, match=r"folder of `lammps-jump budget`.* budget.json and budget.html"):
        lj.open(tmp_path / "budget")


def test_two_runs_share_a_page(folders, opened, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, capsys, "compare", *folders) == (0, "seed1_and_seed2.html\n", "")
    page = (tmp_path / "seed1_and_seed2.html").read_text()
    assert page.count('class="player"') == 2 and page.count('<figure class="curve"') >= 4
    status, _, error = call(monkeypatch, capsys, "compare", *folders)
    assert status == 2 and "stands there already" in error
    assert call(monkeypatch, capsys, "compare", *folders, "--out", "other.html")[1] == "other.html\n"


@pytest.mark.long
def test_every_figure_is_drawn_when_asked(folders, opened, monkeypatch, capsys):
    assert {path.name for path in (folders[1] / "figures").iterdir()} == {"depth_profile.png", "snapshots.png"}
    status, out, _ = call(monkeypatch, capsys, "figures", folders[1])
    drawn = {path.name for path in (folders[1] / "figures").iterdir()}
    assert status == 0 and {"depth_map.png", "forces.png", "energy.png", "snapshots.png"} <= drawn
    assert len(out.splitlines()) == len(drawn)


def test_figures_are_drawn_as_vectors_when_asked(folders, opened, monkeypatch, capsys):
    monkeypatch.setattr(pipeline, "drawings", lambda gathered, results: {})  # the ten pictures alone
    status, out, _ = call(monkeypatch, capsys, "figures", folders[0], "--format", "pdf")
    assert (status, out) == (0, f"{folders[0]}/figures/snapshots.pdf\n")
    assert (folders[0] / "figures/snapshots.pdf").read_bytes()[:5] == b"%PDF-"
    status, _, error = call(monkeypatch, capsys, "figures", folders[0], "--format", "tiff")
    assert status == 2 and "tiff" in error


def test_a_run_folder_is_analysed_again_with_and_without_options(monkeypatch, capsys, tmp_path):
    (tmp_path / "case.yaml").write_text("")
    asked = []
    monkeypatch.setattr(start, "reanalyse", lambda folder, sets: asked.append((folder, sets)))
    for options in ((), ("--stations", "3,9"), ("--heap", "--bin-width", "0.5")):
        assert call(monkeypatch, capsys, "analyze", tmp_path, "--quiet", *options) == (0, "", "")
    assert asked == [
        (tmp_path, []),
        (tmp_path, ["analysis.stations=[3.0,9.0]"]),
        (tmp_path, ["analysis.bin_width=0.5", "analysis.heap=true"]),
    ]
