# SPDX-License-Identifier: GPL-2.0-or-later
"""The laws of validation/: each can be loaded and planned; what measures a run is right on made-up numbers."""

import json

import numpy as np
import pytest
from closed_forms import friction_impulse_factor
from made_up import INPUTS

from lammps_jump import load_case
from lammps_jump.studies import validation
from lammps_jump.studies.points import load_module

LAWS = INPUTS.parent / "validation"
NAMES = sorted(path.parent.name for path in LAWS.glob("*/law.py"))


def measure(name):
    return load_module(LAWS / name, "measure")


def test_the_laws_are_found():
    assert validation.laws_folder().resolve() == LAWS.resolve()
    assert {"columns", "contacts", "inclined_flow", "janssen", "repose", "silo"} <= set(NAMES)
    assert validation.listing().count("\n") + 1 == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_point_has_a_name_a_case_and_a_measure(name):
    law = validation.load_law(LAWS / name)
    assert law.question.endswith("?") and law.title
    for quick in (True, False):
        points = law.points(quick)
        assert len({point.name for point in points}) == len(points) > 0
        for point in points:
            assert callable(getattr(measure(name), point.measure)) and point.starts >= 1
            json.dumps([point.changes, point.options])
        cased = [point for point in points if point.case is not None]
        for point in cased[:1] + cased[-1:]:
            load_case(LAWS / name / point.case).replace(point.changes)


@pytest.mark.long
@pytest.mark.lammps
def test_the_short_form_of_every_law_runs(tmp_path):
    report = validation.validate(out=tmp_path, quick=True)
    assert [law["failures"] for law in report["laws"].values()] == [[]] * len(NAMES)
    assert all(law["rows"] and (tmp_path / law["figure"]).stat().st_size > 0 for law in report["laws"].values())


def test_front_of_a_heap():
    x = np.arange(0.5, 10.0)
    depth = np.clip(6.0 - x, 0.0, None)
    assert measure("columns").front_of(x, depth, 1.5) == pytest.approx(4.5)
    assert measure("columns").front_of(x, np.full(10, 2.0), 1.5) == 9.5  # it leans on the end
    depth[-1] = 3.0  # behind a gap
    assert measure("columns").front_of(x, depth, 1.5) == pytest.approx(4.5)


def test_outflow_is_the_fall_of_mass():
    time = np.linspace(0, 4, 401)
    mass = 100.0 - 5.0 * np.maximum(time - 1.0, 0.0)
    assert measure("silo").discharge(time, mass, 2.0, 4.0) == pytest.approx(5.0)
    law = load_module(LAWS / "silo", "law")
    even = {"time": time, "level": np.linspace(2.5, 1.0, 401), "mass": mass}
    assert law.change_with_fill(even) == pytest.approx(0.0, abs=1e-9)
    slower = even | {"mass": 100.0 - 5.0 * time + 0.3 * time**2}
    assert law.change_with_fill(slower) < -0.05
    found = {f"slot {slot:g}": [{"outflow": 1.1 * (slot - 1.4) ** 1.5}] * 3 for slot in law.SLOTS}
    assert law.exponents(found, 1.4) == pytest.approx([1.5] * 3) and law.numbers(found) == pytest.approx([1.1] * 12)


def test_surface_of_a_layer():
    y, packing = np.arange(0.5, 6.0), np.array([0.7, 0.8, 0.8, 0.75, 0.25, 0.0])
    assert measure("inclined_flow").surface_of(y, packing) == pytest.approx(4.0)


def test_bagnolds_exponent_and_the_curve_are_found():
    law = load_module(LAWS / "inclined_flow", "law")
    inertial = np.array([0.05, 0.1, 0.2, 0.3])
    slopes = np.degrees(np.arctan(law.friction_of(inertial, 0.3, 0.6, 0.25)))
    found = {
        f"{angle:.9g} degrees": [{"velocity": 1.0, "inertial": i, "friction": 0.3, "packing": 0.8}]
        for angle, i in zip(slopes, inertial, strict=True)
    }
    assert law.fit_of(law.by_start(found)[0]) == pytest.approx((0.3, 0.6, 0.25), rel=1e-3)
    still = {"velocity": 0.0, "inertial": None}
    assert law.stops_at(found | {"14 degrees": [still], "16 degrees": [still]}) == pytest.approx(
        (0.5 * (16 + slopes[0]), 0.5 * (slopes[0] - 16)), rel=1e-6
    )
    thick = {f"22 degrees, {h} d": [{"thickness": h, "velocity": 0.1 * h**1.5}] for h in (10, 20)}
    assert law.bagnold(thick) == pytest.approx([1.5])


def test_janssens_length_is_found():
    depth = np.linspace(0.1, 6.0, 30)
    janssen = measure("janssen")
    assert janssen.length_of(depth, janssen.janssen(depth, 0.8)) == pytest.approx(0.8, rel=1e-3)


def test_exponents_of_columns_are_found():
    law = load_module(LAWS / "columns", "law")
    columns = {a: [{"aspect": a, "bulk": 3.0 * a**0.7}] * 2 for a in (4.0, 6.0, 9.0)}
    mean, half = law.exponent(columns)
    assert mean == pytest.approx(0.7) and half == pytest.approx(0.0, abs=1e-9)
    theirs = next(heap.shape for heap in law.DISC_HEAPS if heap.aspect == 1.39)
    assert law.shape_off({"x": theirs.x, "h": theirs.y}, 1.39) == 0


def test_closed_forms_of_contacts():
    law = load_module(LAWS / "contacts", "law")
    assert law.tail_factor(0.6) == pytest.approx(friction_impulse_factor(0.6), rel=1e-12)
    along, rim = law.after(np.array([3 * law.KICK * (1 - 1e-9), 3 * law.KICK * (1 + 1e-9)]))
    assert along[0] == pytest.approx(along[1]) and rim[0] == pytest.approx(rim[1])  # it is continuous
    assert law.onset_of([1.0, 2.0, 3.0], [0.0, 1.0, 3.0]) == pytest.approx(1.5)
    assert np.isnan(law.onset_of([1.0, 2.0, 3.0], [0.5, 1.0, 3.0]))


def test_least_rise_of_repose():
    law = load_module(LAWS / "repose", "law")
    assert law.least_rise([(10.0, 3.0), (15.0, 4.0), (16.0, 0.0)]) == (1.0, 4.0)


def test_impulse_of_a_steady_force_and_of_ritters_wave():
    water, law = measure("water"), load_module(LAWS / "water", "law")
    time = np.arange(1, 101) * 0.01
    force = np.where(time > 0.3, 5.0, 0.0)
    assert water.arrives(time, force, 1.0) == pytest.approx(0.31)
    assert water.impulse_since(time, force, 0.3, 0.5) == pytest.approx(2.5)
    # far behind the front, s = 0: the flux is 4/81 2² 1² = 16/81; the first of 2000 trapezoids holds the front itself
    assert law.ritter_impulse(1e-6, 3.0) == pytest.approx(3.0 * 16 / 81, rel=1e-3)
    own = {"T": [0.0, 4.0], "Z": [1.0, 1.0 + 4.0]}
    theirs = law.KOSHIZUKA_OKA_FRONT
    off = [(1 + t) / z - 1 for t, z in zip(theirs.x, theirs.y, strict=True) if t > law.BEGIN]
    assert law.off_oka(own) == pytest.approx(off)


def test_impacts_with_spin_by_hand():
    law = load_module(LAWS / "contacts", "law")
    change, slip = law.kick(np.array([0.3, -0.3, 90.0]), np.array([1.0, 1.0, 1.0]))
    assert change == pytest.approx([-0.1, 0.1, -0.3 * law.KICK]) and slip == pytest.approx([1.0, 1.0, 300.0])
    # the one below runs along x at 0.3 and up at 0.5; they stick, and a sixth of the slip goes to each
    a = {"x": [0.0], "y": [0.0], "u": [0.3], "v": [0.5], "rim": [0.0]}
    b = {"x": [0.3], "y": [2.0], "u": [0.0], "v": [-0.5], "rim": [0.0]}
    left, right = a | {"u": [0.25], "rim": [0.1]}, b | {"u": [0.05], "rim": [0.1]}
    assert law.pair_off({"before": [a, b], "after": [left, right]}) == pytest.approx(0.0, abs=1e-12)
    assert law.pair_off({"before": [a, b], "after": [a, b]}) == pytest.approx(0.1 / 0.3)
