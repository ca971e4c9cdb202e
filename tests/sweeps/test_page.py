# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a study: the player of its members."""

import importlib
import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest
from made_up import INPUTS, STUDY, call

import lammps_jump as lj
from lammps_jump.analysis.draw.style import drawing
from lammps_jump.analysis.report.frames import LETTERS
from lammps_jump.analysis.report.handed_on import read_player
from lammps_jump.analysis.report.page import Player, PlayerChoice, Section, render
from lammps_jump.case import load_case
from lammps_jump.sweeps import Sweep, held_study, open_sweep, page, prepare, read_study, slurm
from lammps_jump.sweeps.page import by_member, by_point
from lammps_jump.sweeps.study import axis_heading, axis_words

pytestmark = pytest.mark.usefixtures("kept_workers")

MEMBERS = {
    **STUDY,
    "axes": {},
    "members": 4,
    "set": {"run.duration": 2},
    "collect": ["force.box.peak", "energy.max_deviation"],
}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return lj.sweep(MEMBERS, tmp_path_factory.mktemp("members") / "box", jobs=1)


def shown_seed(choice: PlayerChoice) -> int:
    return int(choice.names[choice.shown].removeprefix("Member "))


def test_the_page_has_one_player_and_a_list_of_all_members(done):
    text = (done.folder / "sweep.html").read_text()
    assert text.count('<div class="player"') == 1
    options = re.findall(r'<option value="(\d)"( selected)?>Member (\d)', text)
    assert [(number, seed) for number, _, seed in options] == [("0", "1"), ("1", "2"), ("2", "3"), ("3", "4")]
    assert sum(bool(chosen) for _, chosen, _ in options) == 1
    headers = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])["players"]
    stored = [json.loads((run.folder / "player.json").read_text()) for run in done.runs]
    for header in (*headers, *(one["header"] for one in stored)):  # rows of forces stand apart on the page
        felt = [wall.pop("force") for wall in header["walls"] if "force" in wall]
        rows = {
            (one["count"] if isinstance(one, dict) else len(one)) for force in felt for one in list(force.values())[:3]
        }
        assert len(felt) == 1 and len(rows) == 1
    assert headers == [one["header"] for one in stored] and len(headers[0]["times"]) == 41
    assert all(f'id="frames{k}">{one["frames"]}<' in text for k, one in enumerate(stored))
    assert len({one["frames"] for one in stored}) == 4  # each member has its own


def test_the_member_nearest_to_the_means_is_shown_first(done):
    paths = [item.path for item in done.study.collect]
    z = [(done.values[path] - done.values[path].mean()) / done.values[path].std() for path in paths]
    choice, text = by_member(done)
    assert shown_seed(choice) == 1 + int(np.argmin(sum(one**2 for one in z)))
    assert f"Member {shown_seed(choice)} is shown first" in text.text and "no room" not in text.text


def test_the_page_has_a_size_and_keeps_the_members_nearest_to_the_means(done, monkeypatch):
    choice = by_member(done)[0]
    first = shown_seed(choice)
    sizes = [len(one.frames) for one in choice.blocks]
    for room, count in ((1, 1), (2.5, 2)):
        monkeypatch.setattr(importlib.import_module("lammps_jump.sweeps.page"), "LARGEST", room * max(sizes))
        choice, text = by_member(done)
        assert len(choice.names) == len(choice.blocks) == count and shown_seed(choice) == first
        assert f"no room for {4 - count} of 4 members" in text.text
    monkeypatch.setattr(importlib.import_module("lammps_jump.sweeps.page"), "LARGEST", 0)
    assert by_member(done)[0].names == [f"Member {first}"]  # one always


def test_one_member_and_members_without_frames(done, tmp_path):
    folder = shutil.copytree(done.folder, tmp_path / "copy")
    two = Sweep(read_study({**MEMBERS, "members": 2}), folder, done.starts[:2])
    assert by_member(Sweep(two.study, folder, done.starts[:1]))[0].names == ["Member 1"]
    (two.runs[0].folder / "player.json").write_text("{")
    choice, text = by_member(two)
    assert choice.names == ["Member 2"] and "is damaged): 1." in text.text
    (two.runs[1].folder / "player.json").unlink()
    assert [block.text for block in by_member(two)] == ["Members without a player (player.json is damaged): 1."]
    (two.runs[0].folder / "player.json").unlink()
    assert by_member(two) == []


@pytest.mark.fault("values in JSON files")
def test_a_player_that_was_handed_on_is_checked(done, tmp_path, tried):
    """Frames that are markup or no packed data, and counts that do not fit them: the page would run on them."""
    path, whole = tmp_path / "player.json", json.loads((done.runs[0].folder / "player.json").read_text())
    header, frames = whole["header"], whole["frames"]
    path.write_text(json.dumps(whole))
    taken = read_player(path)
    assert taken.frames == frames and json.loads(json.dumps(taken.header)) == header
    refresh = '</script><meta http-equiv="refresh" content="0;url=http://127.0.0.1/">'
    random = np.random.default_rng(1)
    noise = LETTERS[random.integers(0, len(LETTERS), len(frames))].tobytes().decode()
    texts = ["", refresh, frames + refresh, frames[:-1], frames + "a", frames[: len(frames) // 2], noise, "é" + frames]
    wrong = [{"frames": text} for text in texts]
    changes = {
        "rows": [header["rows"] - 1, header["rows"] + 1, 10**9, -1, "3"], "discs": [header["discs"] + 1, 2**32, 0.5],
        "times": [[], header["times"][:-1], header["times"][::-1], [0.0] * 41, None], "radii": [[], [0.0], [1e12]],
        "bins": [{"low": 0, "width": 1e-300, "count": 5}, {"low": 0, "width": 1, "count": 10**9}, {}],
        "map": [{**header["map"], "counts": [10**5, 10**5]}, {**header["map"], "counts": [1, 1]}, {}],
        "seen": [[[0, 0], [0, 1]], [[0, 1e300], [0, 1]]], "sequent": [[]], "more": [1],
        "seam": [[1, 0], [0, 1e-9], [0, 1e300], "0"],
    }  # fmt: skip
    still, way = {"name": "a", "hollow": False, "outlines": [[[0, 0], [1, 0], [1, 1]]], "lines": []}, [0.0] * 10**4
    moving = {**still, "about": [0, 0], **dict.fromkeys(("x", "y", "angle"), way[: len(header["times"])])}
    known = {name: [None, *moving["x"][1:]] for name in ("vx", "vy", "fx", "fy")}
    body = {**moving, "body": {"mass": 2.0, "centre": [0, 0], **known}}
    force = {"time": [0.1, 0.2], "fx": [1.0, -2.0], "fy": [0.0, 3.0], "each": 0.1, "taken": 1}
    felt = {**still, "force": force}
    path.write_text(json.dumps({**whole, "header": {**header, "seam": [0, 1e6], "walls": [still, moving, body, felt]}}))
    assert json.loads(json.dumps(read_player(path).header["walls"])) == [still, moving, body, felt]
    bad_walls = [
        refresh, [{}], [{**moving, "x": way}], [{**moving, "angle": None}], [{**moving, "angle": [refresh]}],
        [{**still, "x": moving["x"]}], [{**still, "outlines": [[]]}], [{**still, "lines": [way]}],
        [{**still, "lines": [[[0, 0]] * 60_000] * 2}], [{**moving, "about": [0, 1e300]}],
        [{**still, "body": body["body"]}], [{**body, "body": {**body["body"], "vx": way}}],
        [{**body, "body": {**body["body"], "fy": None}}], [{**body, "body": {**body["body"], "mass": refresh}}],
        *([{**still, "force": {**force, **change}}] for change in (
            {"fx": [1.0]}, {"time": [0.2, 0.1]}, {"fy": [refresh, 1.0]}, {"taken": 0}, {"time": [], "fx": [], "fy": []},
            {"more": 1}, {"time": way * 3, "fx": way * 3, "fy": way * 3},
        )),
    ]  # fmt: skip
    wrong += [{"header": {**header, "walls": walls}} for walls in bad_walls]
    wrong += [{"header": {**header, name: value}} for name, values in changes.items() for value in values]
    for changed in wrong:
        path.write_text(json.dumps({**whole, **changed}))
        with pytest.raises(ValueError):
            read_player(path)
    path.write_text(json.dumps({**whole, "still": ["x", "http://127.0.0.1/"]}))
    assert read_player(path).still is None
    with pytest.raises(ValueError):
        render("page", [Section("", [Player(header, refresh)])])
    tried(len(wrong))


def test_members_of_many_points_keep_no_frames(tmp_path, monkeypatch):
    """The same run as the member of a case: its frames are then read from its dump."""
    monkeypatch.setattr(importlib.import_module("lammps_jump.sweeps.study"), "MOST_WATCHED", 1)
    two = {"axes": {"discs.density": [500, 1000]}}
    for changes, there in ((two, False), ({"set": {"discs.density": 500}}, True)):
        found = Sweep(read_study({**STUDY, "axes": {}, "members": 1, **changes}), tmp_path / "out")
        with held_study(found.folder):
            prepare(found)
        slurm.run_task(found.folder, "0")
        run = open_sweep(found.folder).runs[0]
        assert (run.folder / "player.json").exists() == there == bool(by_member(found))
    assert len(list((tmp_path / "out/runs").iterdir())) == 1


def made_up_study(tmp_path, values):
    """A study of three heights of a sill, with numbers put in by hand: two for each height."""
    case = {**load_case(INPUTS / "quick_jump.yaml").fields.model_dump(mode="json", exclude_none=True)}
    fields = {"case": case, "axes": {"walls.sill.y.1": [0.6, 0.8, 1.0]}, "members": 2}
    found = Sweep(read_study({**fields, "collect": ["jump.speed", "force.sill.peak"]}), tmp_path, starts=())
    numbers = [{"jump.speed": value, "force.sill.peak": 9e4 + value} for value in values]
    rows = [{"point": k // 2, "seed": 1 + k % 2, **pair} for k, pair in enumerate(numbers)]
    frame = pd.DataFrame(rows).assign(**{"jump.speed_error": np.nan, "force.sill.peak_error": np.nan})
    found.__dict__["values"] = frame
    return found


def test_axes_have_words_and_units_and_forces_are_in_kilonewtons(tmp_path):
    found = made_up_study(tmp_path, [1.0, 1.1, 2.0, 2.1, 3.0, 3.1])
    frame = page.summary_frame(found)
    assert list(frame.columns)[:3] == [
        "height of the sill [m]",
        "Velocity of the front [m/s]",
        "Peak force, sill [kN/m]",
    ]
    assert frame["Peak force, sill [kN/m]"][0].startswith("90.0")
    assert page.point_name(found.study, 1) == "height of the sill = 0.8 m"
    with drawing() as (_, axes):
        page.name_axis(axes, "walls.sill.y.1")
        assert axes.get_xlabel() == "height of the sill [m]" and axes.texts[0].get_text() == "walls.sill.y.1"
        assert axes.texts[0].get_fontsize() < axes.xaxis.label.get_fontsize()
    assert (
        axis_heading("probes.interval") == "probes.interval [s]" and axis_words("probes.interval") == "probes.interval"
    )
    assert axis_heading("run.nonsense") == "run.nonsense" and axis_heading("domain.x.1") == "domain.x.1 [m]"
    assert (
        axis_heading("slope") == "slope [°]"
        and axis_heading("walls.0.friction") == "friction coefficient of the wall 0"
    )


def test_an_interval_wider_than_the_mean_is_told(tmp_path):
    said = page.doubts(made_up_study(tmp_path, [1.0, 1.01, 1.0, -1.0, 3.0, 3.01]))
    wide = [text for text in said if "wider than the mean" in text]
    assert len(wide) == 1 and wide[0].startswith("height of the sill = 0.8 m: jump.speed: the interval over 2 members")


@pytest.mark.parametrize("ending", ["svg", pytest.param("pdf", marks=pytest.mark.long)])
def test_figures_of_a_study_in_another_format(done, tmp_path, ending, monkeypatch, capsys):
    folder = shutil.copytree(done.folder, tmp_path / "copy")
    status, out, _ = call(monkeypatch, capsys, "figures", folder, "--format", ending)
    assert (status, out) == (0, f"{folder}/figures/sweep_profiles.{ending}\n")
    assert (folder / f"figures/sweep_profiles.{ending}").read_bytes()[:5] in (b"%PDF-", b"<?xml")
    assert call(monkeypatch, capsys, "figures", folder, "--format", ending)[0] == 0  # replaces its own


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    """Two axes with two values each, two starts of each point."""
    study = {**STUDY, "set": {"run.duration": 1}}
    return lj.sweep(study, tmp_path_factory.mktemp("grid") / "box", jobs=1)


def test_a_study_has_a_slider_for_each_axis(grid):
    choice, text = by_point(grid)
    assert [(axis.label, axis.values) for axis in choice.axes] == [
        ("time step over 2/ω", ["0.05", "0.1"]), ("density", ["500 kg/m³", "1000 kg/m³"]),
    ]  # fmt: skip
    assert choice.places == [(0, 0), (0, 1), (1, 0), (1, 1)] and len(choice.blocks) == len(choice.sides) == 4
    assert choice.names[1] == "time step over 2/ω 0.05, density 1000 kg/m³"
    assert "the start whose numbers are nearest to its means" in text.text
    frame = grid.table.to_dataframe().unstack("statistic")
    for side, (_, row) in zip(choice.sides, frame.iterrows(), strict=True):
        values = [box.value for box in side[0].numbers]
        assert values == pytest.approx([item.scale * row[item.path, "mean"] for item in grid.study.collect])
        assert all(box.against == "n = 2" for box in side[0].numbers)
    html = (grid.folder / "sweep.html").read_text()
    assert html.count('class="axis"') == 2 and html.count('class="of-run"') == 4
    assert html.count('<div class="of-run" data-run="2">') == 1  # the others are hidden
    assert json.loads(re.search(r'data-places="([^"]*)"', html)[1]) == [[0, 0], [0, 1], [1, 0], [1, 1]]


def test_each_point_shows_the_start_nearest_to_its_means(grid):
    chosen = importlib.import_module("lammps_jump.sweeps.page")._nearest(grid)
    assert list(chosen) == [0, 1, 2, 3] and [grid.values["point"][row] for row in chosen.values()] == [0, 1, 2, 3]


def test_players_of_many_points_are_thinned_to_the_room_of_a_page(grid, monkeypatch):
    sizes = [len(block.frames) for block in by_point(grid)[0].blocks]
    monkeypatch.setattr(importlib.import_module("lammps_jump.sweeps.page"), "LARGEST", sum(sizes) // 2 + 1)
    thinner = by_point(grid)[0].blocks
    assert [len(block.header["times"]) for block in thinner] == [11] * 4  # of 21, every second
    assert sum(len(block.frames) for block in thinner) < sum(sizes)


def test_points_without_a_run_are_counted(grid, tmp_path):
    folder = tmp_path / "box"
    shutil.copytree(grid.folder, folder)
    for run in open_sweep(folder).runs[:2]:
        shutil.rmtree(run.folder)
    choice, text = by_point(open_sweep(folder))
    assert choice.places == [(0, 1), (1, 0), (1, 1)]
    assert "1 of 4 points have no finished run with frames" in text.text
    for run in open_sweep(folder).runs:
        shutil.rmtree(run.folder)
    assert by_point(open_sweep(folder)) == []
