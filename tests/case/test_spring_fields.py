# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of springs with memory: what they make of a scene, and what is refused."""

from __future__ import annotations

import pytest

from lammps_jump.case import load_case
from lammps_jump.errors import CaseError
from lammps_jump.physics.contact import stable_fraction
from lammps_jump.physics.slip import Rolling, Springs, springs_stable_fraction

GRAINS = {
    "name": "grains",
    "discs": {"diameter": 0.1},
    "contact": {"restitution": 0.5, "impact_speed": 3, "friction": 0.5, "friction_law": "history", "rotation": True},
    "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "initial": [{"kind": "lattice", "nx": 3, "ny": 3, "spacing": 0.11, "origin": [0, 0.06]}],
    "run": {"duration": 0.1},
}


def scene(*changes):
    return load_case(GRAINS, list(changes)).scene()


def test_what_the_fields_make_of_a_scene():
    found = scene()
    c = found.coefficients
    assert found.springs == Springs(2 / 7, 1.0, None) and found.slots > 6 and not found.contact_output
    assert c.gamma_tangential == c.gamma_normal and c.gamma_tangential_wall == c.gamma_normal_wall
    assert not any("memory" in text for text in found.skipped)
    native = scene(
        "engine.name=native", "contact.rolling={friction: 0.1}", "contact.tangential_ratio=0.5",
        "walls.floor.rolling=0.3", "contact.tangential_damping_ratio=0",
    )  # fmt: skip
    assert native.springs == Springs(0.5, 0.0, Rolling(0.1, 0.1, 1.0))
    assert native.integrator == "velocity_verlet" and native.contact_output
    assert native.own_laws["floor"].rolling == 0.3 and native.coefficients.gamma_tangential == 0.0


def test_without_friction_nothing_is_remembered():
    found = scene("contact.friction=0")
    assert found.springs is None and found.slots == 0 and any("memory" in text for text in found.skipped)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (["contact.friction_law=viscous", "contact.rolling={friction: 0.1}"], "rolling has no meaning"),
        (["contact.friction_law=viscous", "contact.tangential_ratio=0.3"], "tangential_ratio has no meaning"),
        (["contact.tangential_damping=10"], "tangential_damping_ratio"),
        (["contact.touch=smooth"], "write touch: sharp"),
        (["contact.rolling={friction: 0.1}", "contact.rotation=false"], "rotation: true"),
        (["contact.rolling={friction: 0.1}", "contact.friction=0"], "friction above 0"),
        (["walls.floor.rolling=0.1"], "contact.rolling is null"),
        (["run.integrator=leapfrog_extrapolated", "engine.name=native"], "use auto or velocity_verlet"),
        (["contact.tangential_ratio=1.5"], "tangential_ratio"),
    ],
)
def test_refused(changes, says):
    with pytest.raises(CaseError) as raised:
        scene(*changes)
    assert says in str(raised.value)


def test_a_step_at_which_springs_tremble_is_told():
    limit = springs_stable_fraction(scene().coefficients.damping_ratio, Springs(), True)
    assert scene(f"run.time_step_fraction={0.9 * limit}").warnings == scene().warnings
    (told,) = set(scene(f"run.time_step_fraction={1.1 * limit}").warnings) - set(scene().warnings)
    assert told.startswith("friction_law history: tangential springs are stable up to time_step_fraction")
    # without springs the limit is that of the packing
    assert springs_stable_fraction(0.3, Springs(0.0, 0.0), False) == pytest.approx(
        stable_fraction(0.3, "velocity_verlet"), rel=1e-12
    )
