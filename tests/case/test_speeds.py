# SPDX-License-Identifier: GPL-2.0-or-later
"""The speed that a case leads to, the overlap at it, contacts that are too soft for it, and the domain that follows."""

import re
from math import sqrt

import pytest

from lammps_jump.case import load_case
from lammps_jump.engines.lammps.outputs import explain
from lammps_jump.errors import CaseError

BASE = {
    "name": "fall",
    "discs": {"diameter": 0.1, "density": 2500},
    "contact": {"restitution": 0.5, "from_material": {"young": 1e7, "poisson": 0.3}},
    "walls": [
        {"name": "shelf", "kind": "block", "x": [0, 2], "y": [3, 3.2]},
        {"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"},
    ],
    "initial": [{"kind": "column", "x": [0.5, 1.5], "y": [4, 5], "hydrostatic": False, "gate": False}],
    "run": {"duration": 1, "time_step_fraction": 0.1},
}
G = 9.81
STIFF = {
    "contact.from_material.young": {"restitution": 0.5, "from_material": {"young": 1e5, "poisson": 0.3}},
    "contact.stiffness": {"restitution": 0.5, "stiffness": 4e4},
    "contact.impact_speed": {"restitution": 0.5, "impact_speed": 1.5},
}
"""The field that fixes the stiffness, and a contact that is too soft."""


def case(**changes):
    return load_case({**BASE, **changes})


def softness(one):
    return [text for text in one.scene().warnings if text.startswith("contacts are soft")]


def test_the_speed_is_that_of_the_fall_to_the_lowest_ground():
    assert case().check().numbers["expected_speed"] == pytest.approx(sqrt(2 * G * 5))
    held = [BASE["walls"][0] | {"x": [-50, 50]}]
    assert case(walls=held).check().numbers["expected_speed"] == pytest.approx(sqrt(2 * G * (5 - 3.2)))
    out = case(outflow=[{"y_below": 1}])  # the floor is beyond the outlet: nothing falls upon it
    assert out.check().numbers["expected_speed"] == pytest.approx(sqrt(2 * G * (5 - 3.2)))


@pytest.mark.parametrize(
    ("changes", "speed"),
    [
        ({"gravity": 0}, 0.0),
        ({"initial": [BASE["initial"][0] | {"velocity": [3, 4]}]}, sqrt(25 + 2 * G * 5)),
        ({"initial": [{"kind": "list", "positions": [[1, 2.0]], "velocities": [[0, 9]]}]}, sqrt(81 + 2 * G * 2)),
        ({"initial": [],
          "inflow": {"kind": "rows", "x": 3, "y": 1, "depth": 0.5, "mean_speed": 20, "profile": "uniform"}},
         sqrt(400 + 2 * G * 1.5)),
        ({"inflow": {"kind": "pour", "x": [3, 4], "y": [6, 7], "count": 5, "speed_down": 2}}, sqrt(4 + 2 * G * 7)),
        ({"walls": [BASE["walls"][1], {"name": "ram", "kind": "block", "x": [7, 8], "y": [0, 1],
                                       "motion": {"kind": "translate", "velocity": [-20, 0]}}]}, 20.0),
    ],
)  # fmt: skip
def test_start_inflow_and_motions_count(changes, speed):
    assert case(**changes).check().numbers["expected_speed"] == pytest.approx(speed, rel=1e-6)


def test_the_overlap_depends_on_the_modulus():
    numbers = [case().replace({"contact.from_material.young": young}).check().numbers for young in (1e7, 4e7)]
    assert numbers[0]["expected_speed"] == numbers[1]["expected_speed"]
    assert numbers[0]["expected_overlap"] == pytest.approx(2 * numbers[1]["expected_overlap"])
    assert numbers[0]["largest_overlap"] == pytest.approx(2 * numbers[1]["largest_overlap"])  # v0 is that speed


@pytest.mark.parametrize("contact", [BASE["contact"], {"restitution": 0.5, "stiffness": 4e6}])
def test_a_domain_that_is_not_given_depends_on_the_energy_alone(contact):
    one = case(contact=contact)
    field = "contact.stiffness" if "stiffness" in contact else "contact.from_material.young"
    stiff = one.replace({field: 2e11})
    assert stiff.scene().domain == one.scene().domain
    (low, high), _ = one.scene().domain
    assert low == pytest.approx(0 - 10 * 0.1 - sqrt(2 * G * 5), abs=1e-6) and high > 2
    assert one.replace({"run.duration": 2}).scene().domain != one.scene().domain


@pytest.mark.parametrize("field", STIFF)
def test_soft_contacts_are_doubted_with_the_value_that_suits(field):
    soft = case(contact=STIFF[field])
    (said,) = softness(soft)
    assert "fall by up to 5 m to the lowest ground" in said and "9.9 m/s" in said
    name, value = re.search(r"take (\S+): (\S+)", said).groups()
    assert name == field
    assert not softness(soft.replace({name: float(value) * 1.05}))  # two digits are told
    assert soft.replace({name: float(value) * 1.05}).check().numbers["expected_overlap"] < 0.11


@pytest.mark.parametrize("field", STIFF)
def test_advice_names_fields_that_the_case_takes(field, tmp_path):
    one = case(contact=STIFF[field])
    scene = one.scene()
    failed = explain("ERROR: Fix halt condition for fix-id guard_overlap met on step 5", scene, tmp_path, None)
    with pytest.raises(CaseError) as refused:
        case(
            contact=STIFF[field],
            initial=[BASE["initial"][0] | {"y": [0, 60], "hydrostatic": True}],
        ).scene()
    ram = {
        "name": "ram",
        "kind": "block",
        "x": [7, 7],
        "y": [0, 1],
        "motion": {"kind": "translate", "velocity": [-80, 0]},
    }
    doubts = " ".join(case(contact=STIFF[field], walls=[BASE["walls"][1], ram]).scene().warnings)
    assert "moves at up to 80 m/s" in doubts
    for text in (failed, str(refused.value), doubts):
        named = set(re.findall(r"contact\.\w+(?:\.\w+)?", text))
        assert field in named
        for name in named - {field}:  # another field may be named where it stands beside the one that fixes it
            one.replace({name: 0.05})
