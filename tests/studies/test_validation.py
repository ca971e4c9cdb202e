# SPDX-License-Identifier: GPL-2.0-or-later
"""The framework of `lammps-jump validate`, on laws that are made here: rows, verdicts, keys, page, errors."""

import json
import shutil
import sys
from math import inf, nan

import pytest
from made_up import Here

from lammps_jump.case import parse_case
from lammps_jump.cli.app import main
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.files import plain
from lammps_jump.studies import points, validation
from lammps_jump.studies.validation import LOOKED_UP, Row, around, explained, mean_of
from lammps_jump.sweeps.members import Member, drop_dumps

MEASURE = """
import numpy as np

def fall(run):
    frames = list(run.frames())
    y = [float(frame.y[0]) for frame in frames]
    return {"time": [frame.time for frame in frames], "depth": [y[0] - value for value in y]}

def twice(value):
    return {"value": 2 * value}

def broken():
    raise RuntimeError("as it must")
"""
LAW = """
from lammps_jump.analysis.draw.style import drawing
from lammps_jump.studies.validation import DERIVED, Law, Point, Row, around, mean_of

def points(quick):
    case = Point("disc", "fall", "case.yaml", {"run.duration": 0.1 if quick else 0.2}, starts=2, seconds=0.1)
    return [case, Point("number", "twice", options={"value": 4})]

def rows(found):
    mean, half = mean_of([one["depth"][-1] for one in found["disc"]])
    t = found["disc"][0]["time"][-1]
    fall = 0.5 * 9.81 * t**2
    return [
        Row("fall, m", fall, DERIVED, "g t^2/2", mean, half, around(fall, 0.01), "the step is 1 % of t"),
        Row("twice 4", None, "", "", found["number"][0]["value"], reason="no number was found"),
    ]

def figure(found):
    with drawing() as (made, axes):
        axes.plot(found["disc"][0]["time"], found["disc"][0]["depth"])
        axes.set(xlabel="time [s]", ylabel="depth [m]")
    return made

LAW = Law("Free fall", "Does a disc fall as it must?", points, rows, figure, ("A note.",))
"""
CASE = """
name: falls
discs: {diameter: 0.1}
contact: {restitution: 0.5, impact_speed: 5}
domain: {x: [-1, 1], y: [-1, 3]}
walls: [{name: bed, kind: plane, axis: y, at: 0, side: above}]
initial: [{kind: list, positions: [[0, 2]]}]
run: {duration: 0.2, output_interval: 0.05}
engine: {name: native}
"""


@pytest.fixture
def laws(tmp_path):
    folder = tmp_path / "laws" / "fall"
    folder.mkdir(parents=True)
    for name, text in (("measure.py", MEASURE), ("law.py", LAW), ("case.yaml", CASE)):
        (folder / name).write_text(text)
    return tmp_path / "laws"


def command(monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["lammps-jump", "validate", *map(str, words)])
    with pytest.raises(SystemExit) as stop:
        main()
    return stop.value.code or 0


NUMBERS = LAW.replace("[case, ", "[").replace(
    'found["disc"]', '[{"depth": [0.0, 4.905], "time": [0.0, 1.0]}, {"depth": [0.0, 4.91], "time": [0.0, 1.0]}]'
)
"""The law without its case: what a run would have given stands there."""


def test_what_was_measured_is_kept_and_shown(laws, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("lammps_jump.studies.validation.Pool", Here)
    (laws / "fall" / "law.py").write_text(NUMBERS)
    words = ("fall", "--laws", laws, "--out", tmp_path / "out", "--quiet")
    assert command(monkeypatch, *words) == 0
    text = capsys.readouterr().out
    assert "| fall | fall, m | 4.905 (derived here) |" in text and "1 met, 1 fit" in text
    monkeypatch.setattr(Here, "run", lambda self, calls, **_: calls and pytest.fail("it was measured again"))
    assert command(monkeypatch, *words) == 0


@pytest.mark.long
def test_a_law_is_run_once_and_shown(laws, tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    words = ("fall", "--laws", laws, "--out", out, "--quick", "--jobs", "1")
    assert command(monkeypatch, *words) == 0
    text = capsys.readouterr().out
    assert "| fall | fall, m |" in text and "1 met, 1 fit" in text and f"page: {out / 'report.html'}" in text
    stored = json.loads((out / "validation.json").read_text())
    assert set(stored) == {"pieces", "quick", "commit", "versions", "machine", "laws"}
    met, fit = stored["laws"]["fall"]["rows"]
    assert met["verdict"] == "met" and met["interval"] < 1e-3 and fit["verdict"] == "fit" and fit["ours"] == 8
    assert len(stored["laws"]["fall"]["measured"]["disc"]["runs"]) == 2
    assert not [*out.glob("runs/*/dump.*")]
    page = (out / "report.html").read_text()
    assert "Free fall" in page and "A note." in page and "data:image/png" in page
    monkeypatch.setattr("lammps_jump.studies.points.run_member", None)  # nothing is run again
    assert validation.validate(["fall"], out, laws=laws, quick=True)["laws"] == stored["laws"]
    (tmp_path / "mine").mkdir()
    shutil.rmtree(out / "figures")
    (out / "figures").symlink_to(tmp_path / "mine")
    with pytest.raises(SetupError, match="figures: is a link"):
        validation.validate(["fall"], out, laws=laws, quick=True)
    assert not [*(tmp_path / "mine").iterdir()]


def test_what_fails_is_told_and_tried_again(laws, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("lammps_jump.studies.validation.Pool", Here)
    law = laws / "fall" / "law.py"
    law.write_text(LAW.replace('[case, Point("number", "twice", options={"value": 4})]', '[Point("number", "broken")]'))
    words = ("--laws", laws, "--out", tmp_path / "out", "--jobs", "1", "--quiet")
    assert command(monkeypatch, *words) == 1
    assert "fall: number: bug: RuntimeError: as it must" in capsys.readouterr().out
    assert not (tmp_path / "out" / "figures").exists()
    assert command(monkeypatch, *words) == 1
    assert capsys.readouterr().out.count("as it must") == 1


def test_laws_are_listed_and_what_is_not_there_is_named(laws, tmp_path, monkeypatch, capsys):
    assert command(monkeypatch, "--list", "--laws", laws) == 0
    assert capsys.readouterr().out == "fall  Does a disc fall as it must?\n"
    with pytest.raises(CaseError, match=r"there is no law 'rise'; laws in .*: fall"):
        validation.find_laws(laws, ["rise"])
    with pytest.raises(CaseError, match="holds no law"):
        validation.laws_folder(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(points, "TREE", tmp_path / "site" / "validation")
    with pytest.raises(SetupError, match="validation/ of the source of lammps-jump"):
        validation.laws_folder()
    assert command(monkeypatch) == 2


@pytest.mark.fault("text as a command")
@pytest.mark.parametrize("tree", ["no tree", "a folder beside an installed package"])
def test_no_law_of_the_current_folder_is_run(tmp_path, monkeypatch, tree):
    for place in (tmp_path, tmp_path / "site"):
        (place / "validation" / "x").mkdir(parents=True)
        (place / "validation" / "x" / "law.py").write_text("open('PWNED', 'w')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(points, "TREE", tmp_path / ("none" if tree == "no tree" else "site") / "validation")
    with pytest.raises(SetupError, match="validation/ of the source of lammps-jump"):
        validation.listing()
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.fault("folders")
def test_no_dump_behind_a_link_is_deleted(tmp_path):
    case = parse_case(CASE, "case.yaml")
    member = Member(0, 1, case, "k", "key")
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "dump.lammpstrj").write_text("mine")
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "k").symlink_to(mine)
    with pytest.raises(SetupError, match="is a link"):
        drop_dumps(member, tmp_path)
    with pytest.raises(SetupError, match="is a link"):
        points._measured(points.Task(tmp_path, "x", {}, member, tmp_path), member, lambda run: {})
    assert (mine / "dump.lammpstrj").read_text() == "mine"


@pytest.mark.parametrize(
    ("ours", "half", "limits", "verdict"),
    [
        (1.0, nan, (0.9, 1.1), "met"), (1.2, 0.05, (0.9, 1.1), "not met"), (1.2, 0.15, (0.9, 1.1), "near"),
        (0.8, 0.15, (0.9, 1.1), "near"), (nan, nan, (0.9, 1.1), "not met"), (7.0, nan, None, "fit"),
        (0.2, 0.1, (0.0, inf), "met"),
    ],
)  # fmt: skip
def test_verdicts(ours, half, limits, verdict):
    assert Row("q", 1.0, LOOKED_UP, "here", ours, half, limits, "because").verdict == verdict


@pytest.mark.parametrize(
    ("ours", "half", "limits", "text"),
    [
        (4.3e-17, nan, (-1e-9, 1e-9), "below 1e-10"), (5.237e-5, nan, (-5e-4, 5e-4), "5e-5"),
        (3.5e-4, nan, (-0.05, 0.05), "0.000"), (0.666671, nan, (0.6663, 0.6671), "0.66667"),
        (-0.109037, nan, (-0.1112, -0.1052), "-0.1090"), (0.0834, 0.011, (-0.2, 0.0), "0.083 ± 0.011"),
        (1234.5, nan, (500.0, 3000.0), "1234"), (2.5431, nan, (0.0, inf), "2.543"), (2.5431, nan, None, "2.543"),
    ],
)  # fmt: skip
def test_digits_that_decide_nothing_are_not_shown(ours, half, limits, text):
    row = vars(Row("q", 0.0, LOOKED_UP, "here", ours, half, limits, "because"))
    for one in (row, plain(row)):
        assert validation.ours_text(one).replace("\N{MINUS SIGN}", "-") == text


def test_reasons_that_rows_share_stand_once_and_what_is_outside_is_explained():
    rows = [
        Row("one", 0.0, LOOKED_UP, "book", 0.5, nan, (0.0, 1.0), "so"), Row("two", 0.0, LOOKED_UP, "book", 2.0, nan,
        (0.0, 1.0), "so"), Row("three", 0.0, LOOKED_UP, "book", 2.0, 1.5, (0.0, 1.0), "so", "it is soft"),
        Row("four", None, "", "", 2.0, reason="no number was found"),
    ]  # fmt: skip
    assert explained([vars(row) | {"verdict": row.verdict} for row in rows]) == [
        "one; two; three. Source: book. Accepted: so.",
        "four. No gate: no number was found.",
        "Why outside: two (not met): not known.",
        "Why outside: three (near): it is soft.",
    ]


def test_rows_say_where_they_come_from():
    for wrong in ({"kind": "hearsay"}, {"published": None}, {"reason": ""}):
        given = {"published": 1.0, "kind": LOOKED_UP, "limits": (0.0, 1.0), "reason": "so"} | wrong
        with pytest.raises(ValueError, match="q: "):
            Row("q", source="here", ours=1.0, **given)
    assert Row("q", 2.0, LOOKED_UP, "here", 3.0, reason="so").distance == 0.5
    assert around(2.0, 0.1, by=0.3) == (1.5, 2.5)
    assert mean_of([1.0, 3.0, None]) == pytest.approx((2.0, 12.706), rel=1e-3)
