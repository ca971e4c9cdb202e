# SPDX-License-Identifier: GPL-2.0-or-later
"""The contact law of sharp and smooth touches: potential, dashpot, friction, restitution in discrete time."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.physics import law
from lammps_jump.physics.contact import SMOOTH_SHARE, damping_ratio, lagged_correction, lagged_restitution

PACKAGE = Path(law.__file__).parents[1]
SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0)
PHASES = 64
LIMIT = 1_000_000
widths = st.floats(1e-3, 1e3)


def spring(overlap, width):
    return law.normal_force(overlap, 0.0, 1.0, 0.0, width)[0]


def energy(overlap, width):
    return law.stored_energy(overlap, width)


def dashpot_share(overlap, width):
    return -law.normal_force(overlap, 1.0, 1.0, 1.0, width)[1]


def restitution(xi, h, width, speed, phase):
    """Restitution of one collision, velocity Verlet with the dashpot fed by the half-step velocity as in LAMMPS.

    m_eff = k = 1, so that omega = 1, times count in 1/omega and the step is h = omega dt = 2 f. `phase`: share of a
    step between the last free position and touch.
    """
    overlap, v, force = -phase * h * speed, speed, 0.0
    for _ in range(LIMIT):
        half = v + 0.5 * h * force
        overlap += h * half
        force = -law.normal_force(overlap, -half, 1.0, 2.0 * xi, width)[0] if overlap > 0.0 else 0.0
        v = half + 0.5 * h * force
        if overlap <= 0.0 and v < 0.0:
            return -v / speed
    raise ArithmeticError(f"the contact has not ended after {LIMIT} steps (xi {xi}, h {h}, width {width})")


def mean_restitution(xi, h, width, speed):
    """Mean and standard deviation over evenly spread phases of entry."""
    found = [restitution(xi, h, width, speed, (i + 0.5) / PHASES) for i in range(PHASES)]
    mean = sum(found) / PHASES
    return mean, sqrt(max(sum(e * e for e in found) / PHASES - mean * mean, 0.0))


@given(widths, st.floats(1e-3, 10.0))
def test_the_force_is_the_slope_of_the_energy(width, share):
    overlap = share * width
    step = 1e-5 * overlap
    slope = (energy(overlap + step, width) - energy(overlap - step, width)) / (2 * step)
    assert spring(overlap, width) == pytest.approx(slope, rel=1e-5)  # central difference, second order


@given(widths)
def test_force_energy_and_dashpot_are_continuous_at_the_width(width):
    below, above = width * (1 - 1e-9), width * (1 + 1e-9)
    for part in (spring, energy):
        assert part(below, width) == pytest.approx(part(above, width), rel=1e-7)
    assert dashpot_share(below, width) == pytest.approx(sqrt(0.75), rel=1e-7)
    assert dashpot_share(above, width) == pytest.approx(sqrt(0.75), rel=1e-7)


@given(widths, st.floats(1e-6, 1e3))
def test_the_dashpot_never_exceeds_the_sharp_one(width, share):
    assert 0 < dashpot_share(share * width, width) < 1 + 1e-12


def test_the_cores_form_of_the_dashpot():
    # core/contact/law.h: sqrt(3 delta/(4 s)) below, q / sqrt(q^2 + s^2/12) beyond
    assert dashpot_share(0.3, 1.0) == pytest.approx(sqrt(0.75 * 0.3), rel=1e-14)
    assert dashpot_share(2.0, 1.0) == pytest.approx(1.5 / sqrt(1.5**2 + 1 / 12), rel=1e-14)


def test_a_sharp_touch_is_linear():
    assert law.normal_force(0.2, 3.0, 10.0, 0.5, None) == (2.0 - 1.5, -1.5)
    assert law.stored_energy(0.2, None) == pytest.approx(0.02)


def test_friction_is_bounded_by_coulomb_and_opposes_the_slip():
    assert law.friction_force(-4.0, 0.1, 0.5, 3.0, None) == pytest.approx(-0.3)
    assert law.friction_force(-4.0, -10.0, 0.5, 3.0, None) == 2.0
    assert law.friction_force(4.0, 0.1, 0.5, 3.0, 2.0) == pytest.approx(-0.4)  # μ F v/eps
    assert law.friction_force(4.0, 10.0, 0.5, 3.0, 2.0) == -2.0


@pytest.mark.parametrize("e", [0.05, 0.2, 0.6, 0.9])
@pytest.mark.parametrize("width", [0.01, 1.0, 100.0])
def test_restitution_is_that_of_the_linear_law_at_any_width(e, width):
    # the lagged dashpot makes it low by about 2 xi h: h = 0.002
    assert restitution(damping_ratio(e), 0.002, width, 1.0, 0.5) == pytest.approx(e, rel=0.004)


def test_only_speed_over_width_matters():
    assert restitution(0.3, 0.1, 0.2, 1.0, 0.3) == pytest.approx(restitution(0.3, 0.1, 0.4, 2.0, 0.3), rel=1e-12)


def test_the_sharp_contact_follows_the_closed_form():
    xi, h = damping_ratio(0.2), 0.1
    assert mean_restitution(xi, h, None, 1.0)[0] == pytest.approx(lagged_restitution(xi, h), rel=0.005)


def test_the_touch_takes_the_scatter_of_the_entry_phase_away():
    sharp, smooth = mean_restitution(0.0, 0.4, None, 1.0)[1], mean_restitution(0.0, 0.4, 0.8, 1.0)[1]
    assert smooth < 0.05 * sharp


@pytest.mark.parametrize("e", [0.2, 0.6])
@pytest.mark.parametrize("f", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("w", [1.0, 2.0])
def test_the_table_of_the_documentation(e, f, w):
    h = 2.0 * f
    factor = lagged_correction(e, h)
    softer = damping_ratio(e) * (1.0 - SMOOTH_SHARE * (1.0 - factor))
    sharp = mean_restitution(damping_ratio(e) * factor, h, None, 1.0)
    smooth = [mean_restitution(softer, h, w * h, u) for u in SPEEDS]
    means = [mean for mean, _ in smooth]
    begin = f"| {e} | {f} | {w:g} | {sharp[0]:.3f} ± {sharp[1]:.3f} | "
    end = f" | {min(means):.3f} to {max(means):.3f} | {smooth[SPEEDS.index(1.0)][1]:.4f} |"
    rows = (PACKAGE.parent / "docs" / "kernels.md").read_text().splitlines()
    assert any(row.startswith(begin) and row.endswith(end) for row in rows)
