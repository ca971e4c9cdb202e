# SPDX-License-Identifier: GPL-2.0-or-later
"""Words of the field: old ones are refused and translated, and the stiffness is that of the old words, bit for bit."""

from __future__ import annotations

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.case import load_case, parse_case
from lammps_jump.case.parts import old_words
from lammps_jump.errors import CaseError
from lammps_jump.physics import contact

GOOD = """\
gravity: 9.81
discs: {diameter: 0.2}
contact: {restitution: 0.2, friction: 0.1, impact_speed: 8, largest_overlap: 0.1}
walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}]
initial: [{kind: lattice, nx: 2, ny: 2, spacing: 0.3, origin: [0.2, 0.2]}]
run: {duration: 0.1}
"""
NUMBERS = st.floats(1, 1e6, allow_nan=False)
WORDS = st.sampled_from(["hooke", "sign", "history"])


@pytest.mark.parametrize("n", [5, 10, 20, 30, 40, 50, 100, 200])
def test_the_stiffness_is_that_of_the_reciprocal(n):
    share = float(repr(1 / n))
    assert 1 / share == n
    for density, speed in ((1000.0, 8.86), (2650.0, 15.34), (1000.0, 8.48528137423857)):
        assert contact.stiffness(density, share, speed) == density * float(n) ** 2 * speed**2  # bit for bit


@given(NUMBERS, WORDS)
def test_what_was_written_comes_back(n, law):
    """Old words -> new ones -> old ones, and nothing else is touched."""
    old = {
        "name": "t",
        "contact": {"friction": 0.1, "penetration_fraction": n, "friction_law": law},
        "run": {"seed": 1},
    }
    new = old_words.in_case(old)
    assert new["contact"] == {
        "friction": 0.1, "largest_overlap": 1 / n, "friction_law": {"hooke": "viscous"}.get(law, law)
    }  # fmt: skip
    assert list(new["contact"]) == ["friction", "largest_overlap", "friction_law"]
    assert old_words.in_case(new) == new  # new words stay
    back = old_words.as_written(new)
    assert back["contact"].pop("penetration_fraction") == pytest.approx(n, rel=1e-15 * 4)  # two roundings
    assert back["contact"] == {"friction": 0.1, "friction_law": law} and back["run"] == old["run"]
    assert "penetration_fraction" in old["contact"]  # a copy


@given(st.integers(1, 1000))
def test_whole_numbers_come_back_exactly(n):
    old = {"contact": {"penetration_fraction": float(n)}}
    assert old_words.as_written(old_words.in_case(old)) == old


OLD = [
    ("friction: 0.1,", "friction: 0.1, friction_law: hooke,", "t.yaml:3: contact.friction_law: hooke is now viscous"),
    (
        "largest_overlap: 0.1",
        "penetration_fraction: 10",
        "t.yaml:3: contact.penetration_fraction: 10 is now largest_overlap: 0.1",
    ),
    (
        "largest_overlap: 0.1",
        "penetration_fraction: much",
        "penetration_fraction: is now largest_overlap, its reciprocal",
    ),
    ("largest_overlap: 0.1", "penetration_fraction: 0", "penetration_fraction: is now largest_overlap, its reciprocal"),
]


@pytest.mark.parametrize(("good", "old", "said"), OLD)
def test_an_old_word_names_the_new_one(good, old, said):
    assert good in GOOD
    parse_case(GOOD, "t.yaml")
    with pytest.raises(CaseError) as error:
        parse_case(GOOD.replace(good, old), "t.yaml")
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_changed_value_with_an_old_word():
    case = parse_case(GOOD)
    for changes in ({"contact.friction_law": "hooke"}, ["contact.friction_law=hooke"]):
        with pytest.raises(CaseError, match=r"--set contact.friction_law=.*: hooke is now viscous"):
            case.replace(changes)
    with pytest.raises(CaseError, match=r"20 is now largest_overlap: 0.05"):
        case.replace({"contact.penetration_fraction": 20})
    with pytest.raises(CaseError, match="hooke is now viscous"):
        load_case({"discs": {"diameter": 1}, "contact": {"friction_law": "hooke"}, "run": {"duration": 1}})


@given(st.floats(1e-3, 1e15), st.floats(0, 0.5))
def test_the_stiffness_of_a_material(young, poisson):
    """k = (pi/4) E*, with the E* of two equal discs in plane strain."""
    effective = 1 / (2 * (1 - poisson**2) / young)
    assert contact.material_stiffness(young, poisson) == pytest.approx(pi / 4 * effective, rel=1e-14)  # round-off


def test_a_case_of_a_material():
    material = GOOD.replace("largest_overlap: 0.1", "from_material: {young: 5 MPa, poisson: 0.3}")
    scene = parse_case(material).scene()
    k = pi * 5e6 / (8 * (1 - 0.3**2))
    assert scene.coefficients.stiffness == scene.coefficients.stiffness_wall == k
    assert scene.coefficients.largest_overlap == contact.largest_overlap(8.0, 0.2, scene.coefficients.omega)
    silent = parse_case(material.replace("impact_speed: 8, ", "")).scene()  # v0 is that of an overlap of 0.1
    assert silent.coefficients.stiffness == k
    assert silent.overlap_limit == pytest.approx(2 * 0.1 * 0.2, rel=1e-12)
    assert silent.springs is None


@pytest.mark.parametrize(
    ("field", "said"),
    [
        ("stiffness: 1e7", "stiffness and from_material both fix the stiffness"),
        ("largest_overlap: 0.1", "from_material and largest_overlap both fix the stiffness"),
    ],
)
def test_a_material_excludes_another_stiffness(field, said):
    with pytest.raises(CaseError, match=said):
        parse_case(GOOD.replace("largest_overlap: 0.1", f"{field}, from_material: {{young: 1e7, poisson: 0.3}}"))
    with pytest.raises(CaseError, match=r"from_material.poisson: 0.6 is out of range; allowed is >= 0 and <= 0.5"):
        parse_case(GOOD.replace("largest_overlap: 0.1", "from_material: {young: 1e7, poisson: 0.6}"))
