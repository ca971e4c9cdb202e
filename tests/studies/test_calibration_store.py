# SPDX-License-Identifier: GPL-2.0-or-later
"""Choice of a setting by accuracy."""

import json
from dataclasses import replace

import pytest
from accuracy_store import make_store

from lammps_jump.case import parse_case
from lammps_jump.engines import accuracy
from lammps_jump.engines.accuracy import CalibratedSetting
from lammps_jump.errors import CaseError
from lammps_jump.units import parse_accuracy

BOX = """
name: box
gravity: 0
discs: {diameter: 0.4}
contact: {restitution: 1, impact_speed: 8}
walls: [{name: box, kind: box, x: [0, 2], y: [0, 2]}]
initial: [{kind: lattice, nx: 2, ny: 2, spacing: 0.8, origin: [0.5, 0.5]}]
run: {duration: 1}
"""


def entry(label, kernel, fraction, seconds, error, floor=0.0):
    texts = [f"engine.kernel={kernel}", f"run.time_step_fraction={fraction}"]
    return {
        "label": label, "kernel": kernel, "fraction": fraction, "assignments": texts, "seconds": seconds,
        "error": error, "floor": floor,
    }  # fmt: skip


@pytest.fixture
def file(tmp_path):
    rows = [
        entry("compiled f=0.4", "compiled", 0.4, 0.1, 0.2),
        entry("compiled smooth f=0.1", "compiled", 0.1, 0.2, 0.004),
        entry("compiled lucky", "compiled", 0.2, 0.15, 0.001, floor=0.05),
        entry("native f=0.05", "native", 0.05, 0.4, 0.009),
        entry("stock f=0.05", "stock", 0.05, 1.0, 0.008),
    ]
    path = tmp_path / "calibration.json"
    box = {"case": "energy_box_16", "restitution": 1.0, "friction": 0.0, "rows": rows}
    path.write_text(json.dumps({"kinds": {"box": box}}))
    return path


def case(text=BOX, *assignments):
    return parse_case(text, "box.yaml", assignments).fields


def test_cheapest_shown_is_chosen(file):
    choice, reason = accuracy.choose_setting(case(), 0.01, path=file)
    assert choice.assignments == ["engine.kernel=compiled", "run.time_step_fraction=0.1"]
    assert "energy_box_16" in reason and "5.0 times quicker than stock" in reason
    assert choice.error == 0.004


def test_what_cannot_run_here_is_left_out(file):
    assert accuracy.choose_setting(case(), 0.01, usable=("stock", "native"), path=file)[1].startswith("stock f=0.05")
    native = case(BOX, "engine.name=native")
    assert accuracy.choose_setting(native, 0.01, path=file)[1].startswith("native f=0.05")
    assert accuracy.choose_setting(case(BOX, "engine.kernel=stock"), 0.01, path=file)[1].startswith("stock")


def test_unstable_steps_are_left_out(file):
    _, loose = accuracy.choose_setting(case(), 0.3, path=file)
    assert loose.startswith("compiled f=0.4")  # stable in an elastic packing: 0.577
    rows = [CalibratedSetting(**row) for row in json.loads(file.read_text())["kinds"]["box"]["rows"]]
    damped = case(BOX, "contact.restitution=0.995")
    assert accuracy.fits(rows[0], damped, {"compiled"})
    assert not accuracy.fits(replace(rows[0], fraction=0.58), damped, {"compiled"})


def test_steps_that_turn_the_slip_round_are_left_out(file):
    """gamma_t = 3 omega damps slip by 18 f a step in dense packings (slip_check): 1.8 at f = 0.1, 7.2 at f = 0.4."""
    stored = (CalibratedSetting(**row) for row in json.loads(file.read_text())["kinds"]["box"]["rows"])
    rows = {row.label: row for row in stored}
    rough = case(BOX, "contact.friction=0.1")
    assert accuracy.fits(rows["compiled smooth f=0.1"], rough, {"compiled"})
    assert not accuracy.fits(rows["compiled f=0.4"], rough, {"compiled"})
    assert accuracy.fits(
        rows["compiled f=0.4"], case(BOX, "contact.friction=0.1", "contact.tangential_damping=1"), {"compiled"}
    )
    assert accuracy.choose_setting(rough, 0.3, path=file)[1].startswith("compiled smooth f=0.1")


def test_what_is_not_shown_is_refused(file):
    with pytest.raises(CaseError, match=r"0\.1 % in energy deviation .* the best shown is 0\.4 %"):
        accuracy.choose_setting(case(), 0.001, path=file)
    flow = BOX.replace("restitution: 1,", "restitution: 0.5,").replace("gravity: 0", "gravity: 9.81")
    with pytest.raises(CaseError, match="no calibration speaks for"):
        accuracy.choose_setting(case(flow), 0.01, path=file)
    with pytest.raises(CaseError, match="cannot be read"):
        accuracy.choose_setting(case(), 0.01, path=file.with_name("none.json"))


@pytest.mark.parametrize(("text", "value"), [("1%", 0.01), ("1 %", 0.01), ("0.05", 0.05), (0.02, 0.02)])
def test_accuracy_is_read(text, value):
    assert parse_accuracy(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["", "x", "0", "100%", "-1%", "nan"])
def test_wrong_accuracy_is_refused(text):
    with pytest.raises(CaseError):
        parse_accuracy(text)


def test_store_is_made_from_benchmarks():
    setting = {
        "kernel": "compiled", "fraction": 0.1, "touch": "smooth", "penetration": None, "correction": True,
        "skin": None, "diameter": None, "ranks": 1,
    }  # fmt: skip
    errors = {"energy deviation": {"error": 0.0031, "floor": 0.0}}
    rows = [
        {"label": "a", "setting": setting, "seconds": 0.2, "errors": errors},
        {"label": "n", "setting": {**setting, "penetration": 5.0}, "seconds": 0.1, "errors": errors},
    ]
    data = {"case": "box", "restitution": 1.0, "friction": 0.0, "members": 5, "reference": "r", "versions": {}}
    made = make_store([{**data, "machine": {}, "rows": rows, "quantities": {"energy deviation": {}}}])
    found = made["kinds"]["box"]["rows"]
    assert [row["label"] for row in found] == ["a"]  # another stiffness is another case, not another accuracy
    assert "contact.touch=smooth" in found[0]["assignments"]
    assert "run.time_step_fraction=0.1" in found[0]["assignments"]


def test_stored_calibration_is_usable():
    for kind, stored in accuracy.read_store().items():
        assert kind in accuracy.KINDS
        assert stored["rows"] and all(row["error"] >= 0 and row["floor"] >= 0 for row in stored["rows"])
