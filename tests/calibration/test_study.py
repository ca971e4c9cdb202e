# SPDX-License-Identifier: GPL-2.0-or-later
"""Study files, options and measured files: what is read, and what is refused before any run."""

import sys

import numpy as np
import pytest
import yaml
from made_up import call
from stand_in_runs import CASE, DENSITY, FRICTION, VARY

import lammps_jump as lj
from lammps_jump.calibration import parse_target, parse_vary, read_calibration
from lammps_jump.errors import CaseError

ANGLE = "heap.angle=20 ± 1"


def read(**given):
    return read_calibration({"case": CASE, "vary": VARY, "targets": [ANGLE], **given})


@pytest.mark.parametrize("text", ["jump.y2=6.7 ± 0.1", "jump.y2 = 6.7+-0.1", "jump.y2=67e-1 +/- 1e-1"])
def test_a_target_is_a_key_a_value_and_an_error(text):
    assert parse_target(text) == {"key": "jump.y2", "value": 6.7, "error": 0.1}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("jump.y2=6.7", r'expected a key, a value and its error, for example --target "jump\.y2=6\.7 ± 0\.1"'),
        ("jump.y2=6.7 ± 0", "the error is 0; allowed is > 0"),
        ("6.7 ± 0.1", "expected a key"),
        ("jump.y2=nan ± 1", "expected a key"),
    ],
)
def test_another_text_is_no_target(text, said):
    with pytest.raises(CaseError, match=said):
        parse_target(text)


@pytest.mark.parametrize("text", ["contact.friction", "contact.friction=0.1", "=1:2", "a=1:2:3", "a=x:1", "a=0:inf"])
def test_another_text_is_no_range(text):
    assert parse_vary("contact.friction=0.1:0.9") == ("contact.friction", [0.1, 0.9])
    with pytest.raises(CaseError, match="expected a path and a range, for example --vary"):
        parse_vary(text)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"vary": {}}, "no vary: name what is to be found"),
        ({"targets": []}, "no targets: name what is measured"),
        ({"vary": {FRICTION: [0.9, 0.1]}}, "0.9 to 0.1 is no range"),
        ({"vary": {"contact.fiction": [0.1, 0.9]}}, "the middle of the ranges is refused: .*fiction"),
        ({"vary": {"contact.restitution": [2, 3]}}, "the middle of the ranges is refused: .*restitution"),
        ({"targets": ["heap.angel=20 ± 1"]}, "targets: .*heap has no number 'angel'; did you mean 'angle'"),
        ({"targets": ["heat.angle=20 ± 1"]}, "targets: .*no 'heat' in summary.json"),
        ({"targets": [ANGLE, ANGLE]}, "targets: heap.angle stands twice"),
        ({"targets": [{"key": "heap.angle", "value": 3}]}, "allowed is {key: jump.y2, value: 6.7, error: 0.1}"),
        ({"targets": {"heap.angle": 3}}, r"heap.angle: 3 does not fit; allowed is \[value, error\]"),
        ({"budget": 9}, "budget: 9 runs are too few for 2 varied numbers and 2 starts of each point; allowed is 12"),
        ({"members": 0}, "members: 0 is out of range; allowed is >= 1"),
        ({"rounds": 3}, "rounds: unknown field"),
        ({"kind": "sweep"}, "kind: .sweep. is not known; allowed is 'calibrate'"),
    ],
)
def test_what_cannot_be_used_is_refused_before_any_run(given, said):
    with pytest.raises(CaseError, match=said):
        read(**given)


def test_targets_are_a_list_or_a_mapping_and_turn_on_their_analysis():
    one, other = read(), read(targets={"heap.angle": (20, 1)})
    assert [t.as_field for t in one.targets] == [t.as_field for t in other.targets]
    assert one.case.fields.analysis.heap and not lj.load_case(CASE).fields.analysis.heap


def test_a_stored_study_is_whole(tmp_path):
    (tmp_path / "case.yaml").write_text(yaml.safe_dump(CASE))
    (tmp_path / "heap.csv").write_text("# mine\nx,h,dh\n1,0.2,0.01\n0,0.5,0.02\n")
    study = {"kind": "calibrate", "case": "case.yaml", "vary": VARY, "budget": 30,
             "targets": [ANGLE, {"data": "heap.csv", "columns": "x=x,heap.depth=h ± dh"}]}  # fmt: skip
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study))
    found = read_calibration(tmp_path / "study.yaml", members=3)
    curve = found.targets[1]
    assert (
        curve.at.tolist() == [0, 1] and curve.measured.tolist() == [0.5, 0.2] and curve.error.tolist() == [0.02, 0.01]
    )
    (tmp_path / "alone").mkdir()
    (tmp_path / "alone" / "study.yaml").write_text(found.to_yaml())
    again = read_calibration(tmp_path / "alone")
    assert again.to_yaml() == found.to_yaml() and (again.budget, again.members) == (30, 3)


def test_a_curve_without_an_error_is_kept_without_one(tmp_path):
    (tmp_path / "heap.csv").write_text("x,h\n" + "".join(f"{x},{1 - x}\n" for x in (0, 0.2, 0.4, 0.6, 0.8)))
    found = read(targets=[{"data": str(tmp_path / "heap.csv"), "columns": "x=x,heap.depth=h"}])
    (curve,) = found.targets
    assert not curve.stated and np.isnan(curve.error).all() and "errors" not in curve.as_field
    (tmp_path / "study.yaml").write_text(found.to_yaml())
    again = read_calibration(tmp_path / "study.yaml")
    assert again.to_yaml() == found.to_yaml() and not again.targets[0].stated


@pytest.mark.parametrize(
    ("field", "said"),
    [
        ({"errors": [0.1, 0.1, 0.1, 0.1, 0]}, r"targets\[0\].errors\[4\]: 0 is out of range; allowed is > 0"),
        ({"errors": [0.1]}, "at, values and errors need one length"),
        ({"at": [0, 1], "values": [1, 2]}, "2 points do not tell their error, and none is stated; 5 or more do"),
    ],
)
def test_points_of_a_curve_need_errors_or_enough_points(field, said):
    curve = {"curve": "heap.depth", "axis": "x", "at": [0, 1, 2, 3, 4], "values": [1, 1, 1, 1, 1]}
    with pytest.raises(CaseError, match=said):
        read(targets=[{**curve, **field}])
    assert not read(targets=[curve]).targets[0].stated


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ("x=x,heap.depth=h ± -1", "the error of heap.depth is -1; allowed is > 0. Leave ± away where"),
        ("x=x,heap.depth=h ± 0", "the error of heap.depth is 0; allowed is > 0"),
        ("x=x,heap.depth=h ± x", "the error of heap.depth is 0; allowed is > 0"),
        ("x=x,heap.depth=h", "2 points do not tell their error, and none is stated; 5 or more do. Else write it"),
        ("x=x,heap.depth=h ± dd", "has no column dd; there are x, h"),
        ("x=x,heap.depth=q", "has no column q; there are x, h"),
        ("x=x,heep.depth=h ± 1", "no run has a table heep; there are"),
        ("x=x", "expected AXIS=COLUMN,TABLE.COLUMN=COLUMN"),
    ],
)
def test_columns_that_are_not_there_are_refused(tmp_path, columns, said):
    (tmp_path / "heap.csv").write_text("x,h\n0,0.5\n1,0.2\n")
    with pytest.raises(CaseError, match=said):
        read(targets=[{"data": str(tmp_path / "heap.csv"), "columns": columns}])


def test_points_are_readable_numbers_inside_the_ranges():
    study = read()
    places = np.array([[0.0, 1.0], [1 / 3, 2 / 3]])
    points = study.points(places)
    assert points.tolist() == [[0.1, 2000.0], [0.366667, 1666.67]]
    assert np.abs(study.unit(points) - places).max() < 1e-5
    assert study.sweep(points.tolist()).points[1] == {FRICTION: 0.366667, DENSITY: 1666.67}


def test_a_sweep_and_show_name_the_command_of_a_calibration(tmp_path, monkeypatch, capsys):
    (tmp_path / "study.yaml").write_text(read().to_yaml())
    status, _, err = call(monkeypatch, capsys, "sweep", tmp_path / "study.yaml")
    assert (
        status == 2 and f"this study is a calibration; `lammps-jump calibrate {tmp_path / 'study.yaml'}` runs it" in err
    )
    (tmp_path / "rounds.json").write_text("{}")
    status, _, err = call(monkeypatch, capsys, "show", tmp_path)
    assert status == 2 and f"calibration.html: there is no page; `lammps-jump calibrate {tmp_path}` makes it" in err


def test_the_command_refuses_in_one_paragraph(tmp_path, monkeypatch, capsys):
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(CASE))
    words = ("calibrate", path, "--target", ANGLE, "--vary", "contact.friction=0.1:0.9", "--out", tmp_path / "out")
    for more, said in [
        (("--data", "heap.csv"), "1 --data and 0 --columns: each file needs its columns"),
        (("--budget", "2"), "--budget: 2 runs are too few"),
        (("--vary", "contact.friction"), "--vary contact.friction: expected a path and a range"),
    ]:
        status, _, err = call(monkeypatch, capsys, *words, *more)
        assert status == 2 and said in err and not (tmp_path / "out").exists()


def test_without_scikit_learn_it_says_what_to_install(tmp_path, monkeypatch, capsys):
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(CASE))
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    words = ("--target", ANGLE, "--vary", "contact.friction=0.1:0.9", "--out", tmp_path / "out")
    status, _, err = call(monkeypatch, capsys, "calibrate", path, *words)
    assert status == 2 and not (tmp_path / "out").exists()
    assert "calibrate needs scikit-learn, which is not installed; `pip install 'lammps-jump[calibrate]'`" in err
