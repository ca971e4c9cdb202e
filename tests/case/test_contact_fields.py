# SPDX-License-Identifier: GPL-2.0-or-later
"""No field of `contact` is accepted without an effect: each changes a number of the scene, and of that of `fluid`."""

import pytest

from lammps_jump.case.case import ReadCase
from lammps_jump.case.contact import Contact
from lammps_jump.studies.fluid.cell import discs_of

TEXT = """
discs: {diameter: 0.2}
contact: {restitution: 0.4, impact_speed: 6}
domain: {x: [-4, 4], y: [-1, 5]}
walls: [{name: bed, kind: plane, axis: y, at: 0, side: above}]
initial: [{kind: list, positions: [[0, 0.2], [0.5, 0.2]]}]
run: {duration: 0.5}
engine: {name: native}
"""
RUBS = {"contact.friction": 0.3}
SPRINGS = {**RUBS, "contact.friction_law": "history", "contact.rotation": True}
CHANGES: dict[str, tuple[dict[str, object], object]] = {
    "restitution": ({}, 0.5),
    "friction": ({}, 0.3),
    "friction_law": (RUBS, "sign"),
    "largest_overlap": ({}, 0.05),
    "impact_speed": ({}, 7),
    "stiffness": ({}, 3e6),
    "from_material": ({}, {"young": 5e6, "poisson": 0.3}),
    "stiffness_wall": ({}, 3e6),
    "cohesion": ({}, 10),
    "rotation": (RUBS, True),
    "correct_restitution": ({"run.integrator": "velocity_verlet"}, False),  # the other one is exact
    "tangential_damping": (RUBS, 50),
    "tangential_ratio": (SPRINGS, 0.5),
    "tangential_damping_ratio": (SPRINGS, 0.5),
    "rolling": (SPRINGS, {"friction": 0.1}),
    "touch": ({}, "smooth"),
    "touch_width": ({"contact.touch": "smooth"}, 0.001),
}
"""What else a case says for a field to have a meaning, and another value of it."""


def numbers(changes):
    """Numbers of the law of two discs and of the wall, of a scene and of `fluid`; NaN as a word."""
    case = ReadCase.parse(TEXT, changes=changes)
    scene, discs = case.scene(), discs_of(case)
    whole = scene.law_numbers(), scene.law_numbers("bed"), scene.rotation
    fluid = discs.scene.law_numbers(), discs.coefficients, discs.scene.rotation
    return repr(whole), repr(fluid)


@pytest.mark.parametrize("name", Contact.model_fields)
def test_a_field_of_the_contact_changes_a_number(name):
    with_it, value = CHANGES[name]
    before, after = numbers(with_it), numbers({**with_it, f"contact.{name}": value})
    assert before[0] != after[0] and before[1] != after[1]
