# SPDX-License-Identifier: GPL-2.0-or-later
"""`find`: a known answer, ranges that do not hold it, what is refused before anything is run, and going on."""

import json

import pytest
import yaml
from made_up import BOX, call

import lammps_jump as lj
from lammps_jump.errors import CaseError
from lammps_jump.sweeps.find import parse_condition, read_find

QUICK = {**BOX, "run": {**BOX["run"], "duration": 0.05, "output_interval": 0.01}}
ENERGY = "energy.initial"
"""Of discs in a box, before any contact stores some: one of them moves at (6, 5) m/s, rho d^2 v^2/2 = 1.22 rho J/m."""
KNOWN = {"vary": {"discs.density": (400.0, 1600.0)}, "until": f"{ENERGY} >= 1220", "members": 2, "budget": 12}


def written(folder):
    return {str(path): path.stat().st_mtime_ns for path in (folder / "points" / "runs").rglob("dump*")}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("find") / "box"
    return folder, lj.find(QUICK, out=folder, jobs=1, **KNOWN)


def test_a_known_answer_is_found_and_told(done):
    folder, found = done
    assert found["held"] and found["value"] == pytest.approx(1000.0, rel=1e-3) and found["holds"] == "above"
    assert found["low"] <= 1000.0 <= found["high"] and found["reason"] is None
    assert found["runs"] == 12 and len(found["points"]) == 6 and not found["failures"]
    page = (folder / "find.html").read_text()
    assert found["verdict"] in page.replace("&gt;", ">") and (folder / "figures" / "find.png").is_file()
    assert json.loads((folder / "find.json").read_text()) == found


def test_the_same_command_runs_nothing_again_and_a_larger_budget_goes_on(done):
    folder, found = done
    before = written(folder)
    assert lj.find(folder, jobs=1) == found and written(folder) == before
    more = lj.find(folder, jobs=1, budget=14)
    assert more["runs"] == 14 and before.items() <= written(folder).items()


def test_a_seed_gives_other_starts_and_one_leads_to_other_starts_at_each_point():
    """Ten searches of a case differ; no start of a search is used at two of its places."""
    seeds = []
    for seed in (1, 1001):
        study = read_find(QUICK, vary=KNOWN["vary"], until=KNOWN["until"], members=3, seed=seed).study([400.0, 700.0])
        seeds.append(set(study.fields.members))
    assert seeds == [{1, 2, 3}, {1001, 1002, 1003}]
    with pytest.raises(CaseError, match="seed"):
        read_find(QUICK, vary=KNOWN["vary"], until=KNOWN["until"], seed=-1)


def test_a_range_that_does_not_hold_it_ends_after_three_points(tmp_path, monkeypatch, capsys):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(QUICK))
    asked = ("--vary", "discs.density=400:800", "--until", f"{ENERGY} >= 1220", "--members", "1", "--jobs", "1")
    status, out, _ = call(monkeypatch, capsys, "find", tmp_path / "box.yaml", *asked, "--out", tmp_path / "o", "-q")
    assert status == 1 and "does not hold it" in out and "488" in out and "976" in out
    found = json.loads((tmp_path / "o" / "find.json").read_text())
    assert not found["held"] and found["value"] is None and found["runs"] == 3


def test_a_study_file_says_the_same(tmp_path):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(QUICK))
    study = {"case": "box.yaml", "find": {"vary": {"discs.density": [400, 1600]}, "until": KNOWN["until"]}}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study))
    read = read_find(tmp_path / "study.yaml", budget=9)
    assert (read.path, read.room, read.key, read.sign, read.number) == (
        "discs.density", (400.0, 1600.0), ENERGY, ">=", 1220.0,
    )  # fmt: skip
    assert (read.members, read.budget) == (3, 9) and read.rounded(712.34567891) == pytest.approx(712.35, abs=0.01)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("jump.y2 >= 6.7", ("jump.y2", ">=", 6.7)), ("jump.y2>=6.7", ("jump.y2", ">=", 6.7)),
        ("jump.y2 ≤ 1e3", ("jump.y2", "<=", 1e3)), ("force.sill.peak < 2", ("force.sill.peak", "<=", 2.0)),
    ],
)  # fmt: skip
def test_conditions(text, found):
    assert parse_condition(text) == found


@pytest.mark.parametrize("text", ["jump.y2", "jump.y2 = 3", "jump.y2 >= much", "jump.y2 >= nan", ">= 3", ""])
def test_other_conditions_are_refused(text):
    with pytest.raises(CaseError, match=r"--until .*: expected a number of summary\.json, >= or <=, and a value"):
        parse_condition(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vary": None}, "no vary"),
        ({"until": None}, "no until"),
        ({"vary": {"discs.density": (800.0, 400.0)}}, "800 to 400 is no range"),
        ({"vary": {"discs.densty": (400.0, 800.0)}}, "densty"),
        ({"vary": {"discs.density": (-1.0, 800.0)}}, "discs.density"),
        ({"until": "energy.initail >= 3"}, "energy has no number 'initail'"),
        ({"until": "stability.tower.sliding_factor >= 3"}, "'tower' is no structure of the case"),
        ({"budget": 2}, "budget"),
    ],
)
def test_what_cannot_be_found_is_refused_before_anything_is_made(tmp_path, change, message):
    with pytest.raises(CaseError, match=message):
        lj.find(QUICK, out=tmp_path / "out", **{**KNOWN, **change})
    assert not (tmp_path / "out").exists()
