# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a study: the player of its members."""

import json
import re
import shutil

import numpy as np
import pytest
from made_up import STUDY

import lammps_jump as lj
from lammps_jump.analysis.report.coder import LETTERS
from lammps_jump.analysis.report.page import Choice, Player, Section, render
from lammps_jump.analysis.report.received import read_player
from lammps_jump.sweeps import Sweep, open_sweep, page, prepare, read_study, slurm, study_folder

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


def shown_seed(choice: Choice) -> int:
    return int(choice.names[choice.shown].removeprefix("Member "))


def test_the_page_has_one_player_and_a_list_of_all_members(done):
    text = (done.folder / "sweep.html").read_text()
    assert text.count('<div class="player"') == 1
    options = re.findall(r'<option value="(\d)"( selected)?>Member (\d)', text)
    assert [(number, seed) for number, _, seed in options] == [("0", "1"), ("1", "2"), ("2", "3"), ("3", "4")]
    assert sum(bool(chosen) for _, chosen, _ in options) == 1
    headers = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])["players"]
    stored = [json.loads((run.folder / "player.json").read_text()) for run in done.runs]
    assert headers == [one["header"] for one in stored] and len(headers[0]["times"]) == 41
    assert all(f'id="frames{k}">{one["frames"]}<' in text for k, one in enumerate(stored))
    assert len({one["frames"] for one in stored}) == 4  # each member has its own


def test_the_member_nearest_to_the_means_is_shown_first(done):
    paths = [item.path for item in done.study.collect]
    z = [(done.values[path] - done.values[path].mean()) / done.values[path].std() for path in paths]
    choice, text = page.players(done)
    assert shown_seed(choice) == 1 + int(np.argmin(sum(one**2 for one in z)))
    assert f"Member {shown_seed(choice)} is shown first" in text.text and "no room" not in text.text


def test_the_page_has_a_size_and_keeps_the_members_nearest_to_the_means(done, monkeypatch):
    choice = page.players(done)[0]
    first = shown_seed(choice)
    sizes = [len(one.frames) for one in choice.blocks]
    for room, count in ((1, 1), (2.5, 2)):
        monkeypatch.setattr(page, "LARGEST", room * max(sizes))
        choice, text = page.players(done)
        assert len(choice.names) == len(choice.blocks) == count and shown_seed(choice) == first
        assert f"no room for {4 - count} of 4 members" in text.text
    monkeypatch.setattr(page, "LARGEST", 0)
    assert page.players(done)[0].names == [f"Member {first}"]  # one always


def test_one_member_and_members_without_frames(done, tmp_path):
    folder = shutil.copytree(done.folder, tmp_path / "copy")
    two = Sweep(read_study({**MEMBERS, "members": 2}), folder, done.starts[:2])
    assert page.players(Sweep(two.study, folder, done.starts[:1]))[0].names == ["Member 1"]
    (two.runs[0].folder / "player.json").write_text("{")
    choice, text = page.players(two)
    assert choice.names == ["Member 2"] and "is damaged): 1." in text.text
    (two.runs[1].folder / "player.json").unlink()
    assert [block.text for block in page.players(two)] == ["Members without a player (player.json is damaged): 1."]
    (two.runs[0].folder / "player.json").unlink()
    assert page.players(two) == []


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
        "seen": [[[0, 0], [0, 1]], [[0, 1e300], [0, 1]]], "walls": [refresh, [{}]], "sequent": [[]], "more": [1],
    }  # fmt: skip
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


def test_members_of_points_keep_no_frames(tmp_path):
    """The same run as the member of a case: its frames are then read from its dump."""
    for changes, there in (({"axes": {"discs.density": [500]}}, False), ({"set": {"discs.density": 500}}, True)):
        found = Sweep(read_study({**STUDY, "axes": {}, "members": 1, **changes}), tmp_path / "out")
        with study_folder(found.folder):
            prepare(found)
        slurm.run_task(found.folder, "0")
        (run,) = open_sweep(found.folder).runs
        assert (run.folder / "player.json").exists() == there == bool(page.players(found))
    assert len(list((tmp_path / "out/runs").iterdir())) == 1
