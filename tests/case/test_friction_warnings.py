# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction laws whose steep start cannot be followed at the chosen step: said before the run."""

from __future__ import annotations

import numpy as np
import pytest

from lammps_jump.case import parse_case
from lammps_jump.physics.slip import SLIP_MODES

CASE = """\
discs: {diameter: 0.2}
contact: {restitution: 0.2, friction: 0.1, impact_speed: 16}
initial: [{kind: lattice, nx: 2, ny: 2, spacing: 1, origin: [0, 0]}]
run: {duration: 0.1}
engine: {name: native}
"""


def warnings(*assignments):
    return parse_case(CASE, "small.yaml", assignments).scene().warnings


@pytest.mark.parametrize("law", ["sign", "viscous"])
def test_the_thesis_friction_and_step_are_fine(law):
    assert not warnings(f"contact.friction_law={law}")
    assert not warnings("contact.friction=0", f"contact.friction_law={law}", "run.time_step_fraction=0.12")


@pytest.mark.parametrize(
    "change", [("contact.friction=0.25",), ("contact.rotation=true",), ("run.time_step_fraction=0.12",)]
)
def test_a_sign_law_that_chatters_is_named(change):
    # 200 f μ of the peak force 2 xi = 0.912 at e = 0.2: 0.91 with f = 0.05 and μ = 0.1; thrice that with spin
    (text,) = (t for t in warnings("contact.friction_law=sign", *change) if "friction" in t)
    assert "hardest collisions" in text and "time_step_fraction" in text


@pytest.mark.parametrize("change", [("run.time_step_fraction=0.12",), ("contact.tangential_damping=20000",)])
def test_a_viscous_ramp_that_chatters_is_named(change):
    (text,) = (t for t in warnings(*change) if "friction" in t)
    assert "dense packings" in text and "tangential_damping" in text


@pytest.mark.parametrize("spin", [False, True])
def test_the_fastest_slip_mode_of_a_hexagonal_packing(spin):
    """Largest eigenvalue of slip damping over all waves in the packing, unit mass, radius and dashpot; I = 1/2."""
    fastest = 0.0
    angles = np.arange(6) * np.pi / 3
    for kx in np.linspace(-np.pi, np.pi, 61):
        for ky in np.linspace(-np.pi, np.pi, 61):
            matrix = np.zeros((3, 3), complex)
            for a in angles:
                phase = np.exp(2j * (kx * np.cos(a) + ky * np.sin(a)))
                row = np.array([-np.sin(a) * (1 - phase), np.cos(a) * (1 - phase), 1 + phase])
                matrix += np.outer([-np.sin(a), np.cos(a), 2.0], row)
            part = matrix if spin else matrix[:2, :2]
            fastest = max(fastest, abs(np.linalg.eigvals(part)).max())
    assert fastest / 2 == pytest.approx(SLIP_MODES[spin], rel=0.01)  # gamma_t = 2 c/m; grid of waves
