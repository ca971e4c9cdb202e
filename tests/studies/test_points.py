# SPDX-License-Identifier: GPL-2.0-or-later
"""A study of points: what is kept, told, tried again and run in turn; its folder outside the wheel."""

import json

import pytest
from made_up import BOX, Here

from lammps_jump import load_case
from lammps_jump.errors import CaseError, RunError, SetupError
from lammps_jump.studies import points as points_study
from lammps_jump.studies import points as studies_folder
from lammps_jump.studies.points import FAILED, Point, PointStudy, pieces_of, run_study, study_named

calls = []


def double(value):
    calls.append(value)
    if value < 0:
        raise RunError("below 0")
    return {"twice": 2 * value}


def ended(run):
    return {"discs": run.summary["discs"]["present"]}


def study_of(*points, **more):
    def results(found, stored):
        return {"rows": [found[point.name] for point in points], "before": stored.get("rows")}

    return PointStudy("made", points, results, lambda data: ["## Made", "", str(data["rows"])], **more)


def number(value, **more):
    return Point(f"number {value}", double, options={"value": value}, **more)


@pytest.fixture(autouse=True)
def here(monkeypatch):
    monkeypatch.setattr(points_study, "Pool", Here)
    calls.clear()


def test_points_are_kept_and_told_and_the_page_is_made(tmp_path):
    said = []
    made = study_of(number(1), number(2), told=lambda p, start, found: f"{p.name}: {found['twice']}", opening=["two"])
    data, text = run_study(made, tmp_path / "out", say=said.append)
    assert said == ["two", "  number 1: 2", "  number 2: 4"] and calls == [1, 2]
    assert text == "## Made\n\n[[{'twice': 2}], [{'twice': 4}]]\n" == (tmp_path / "out" / "made.md").read_text()
    stored = json.loads((tmp_path / "out" / "made.json").read_text())
    assert stored == data and set(data) == {"pieces", "rows", "before", "versions", "machine"}
    again, _ = run_study(made, tmp_path / "out", say=said.append)
    assert calls == [1, 2] and again["before"] == data["rows"], "nothing is made again"
    run_study(made, tmp_path / "out", fresh=True, say=said.append)
    assert calls == [1, 2, 1, 2]


def test_what_fails_is_a_finding_of_a_judged_point_alone(tmp_path):
    data, _ = run_study(study_of(number(-1, judged=True)), tmp_path, say=calls.append)
    assert data["rows"] == [[{FAILED: "below 0"}]] and calls == [-1]
    run_study(study_of(number(-1, judged=True)), tmp_path, say=calls.append)
    assert calls == [-1], "a finding is kept"
    with pytest.raises(RunError, match="number -2: below 0"):
        run_study(study_of(number(3), number(-2)), tmp_path, say=calls.append)
    assert calls == [-1, 3, -2, "  below 0"]
    with pytest.raises(RunError, match="below 0"):
        run_study(study_of(number(3), number(-2)), tmp_path, say=calls.append)
    assert calls[4:] == [-2, "  below 0"], "what failed is tried again, the other one is kept"


def test_starts_that_are_timed_take_turns(tmp_path):
    case = load_case(BOX)
    pieces = pieces_of("s", [Point("a", ended, case, starts=3, seed=7), Point("b", ended, case, starts=3)], tmp_path)
    turns = [(piece.point.name, piece.start) for piece in points_study.by_turns(pieces)]
    assert turns == [("a", 1), ("b", 1), ("b", 2), ("a", 2), ("a", 3), ("b", 3)]
    assert [piece.member.seed for piece in pieces] == [7, 8, 9, 1, 2, 3] and len({piece.key for piece in pieces}) == 6


def test_a_case_that_is_refused_stops_the_study_unless_it_is_judged(tmp_path):
    case, wrong = load_case(BOX), {"run.time_step_fraction": 0.9}
    with pytest.raises(CaseError, match="time_step_fraction"):
        run_study(study_of(Point("far", ended, case, wrong)), tmp_path / "new")
    assert not (tmp_path / "new").exists()
    (rows,) = run_study(study_of(Point("far", ended, case, wrong, 2, judged=True)), tmp_path, say=calls.append)[0][
        "rows"
    ]
    assert len(rows) == 2 and "time_step_fraction" in rows[0][FAILED]


def test_a_run_is_made_once_and_again_where_that_is_asked_for(tmp_path, monkeypatch):
    case = load_case(BOX)
    made = study_of(Point("box", ended, case, {"run.duration": 0.01}, dump=False))
    run_study(made, tmp_path, say=calls.append)
    (folder,) = (tmp_path / "runs").iterdir()
    assert not [*folder.glob("dump*")]
    first = (folder / "summary.json").stat().st_mtime_ns
    (tmp_path / "made.json").unlink()
    data, _ = run_study(made, tmp_path, say=calls.append)
    assert data["rows"] == [[{"discs": 16}]] and (folder / "summary.json").stat().st_mtime_ns == first
    monkeypatch.setattr(points_study, "run_member", lambda member, store, again, keep: calls.append(again))
    run_study(made, tmp_path, fresh=True, say=calls.append)
    assert calls[-1] is True, "it would be run anew"


def test_a_wheel_says_where_its_studies_are(tmp_path, monkeypatch):
    name = "stress"
    with pytest.raises(CaseError, match=f"--laws .*: holds nothing of .*{name}.*study.py"):
        study_named(name, tmp_path)
    monkeypatch.setattr(studies_folder, "TREE", tmp_path / "site" / "validation")
    with pytest.raises(SetupError, match=f"lammps-jump {name}.* validation/ of the source .*--laws DIR"):
        study_named(name)
    (tmp_path / name).mkdir()
    (tmp_path / name / "study.py").write_text("study = 3\n")
    with pytest.raises(CaseError, match="has no function study"):
        study_named(name, tmp_path)
