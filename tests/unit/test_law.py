"""The smooth touch in closed form: potential, dashpot, restitution."""

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.engines.plugin.touch_study import (
    dashpot_share,
    energy,
    fitted_factor,
    mean_restitution,
    restitution,
    spring,
    table,
)
from lammps_jump.physics.contact import damping_ratio, lagged_restitution

widths = st.floats(1e-3, 1e3)


@given(widths, st.floats(1e-3, 10.0))
def test_the_force_is_the_slope_of_the_energy(width, share):
    overlap = share * width
    step = 1e-5 * overlap
    slope = (energy(overlap + step, width) - energy(overlap - step, width)) / (2 * step)
    assert spring(overlap, width) == pytest.approx(slope, rel=1e-5)  # central difference, second order


@given(widths)
def test_force_energy_and_dashpot_are_continuous_at_the_width(width):
    below, above = width * (1 - 1e-9), width * (1 + 1e-9)
    for law in (spring, energy):
        assert law(below, width) == pytest.approx(law(above, width), rel=1e-7)
    assert dashpot_share(below, width, "even") == pytest.approx(sqrt(0.75), rel=1e-7)
    assert dashpot_share(above, width, "even") == pytest.approx(sqrt(0.75), rel=1e-7)


@given(widths, st.floats(1e-6, 1e3))
def test_the_even_dashpot_never_exceeds_the_sharp_one(width, share):
    assert 0 < dashpot_share(share * width, width, "even") < 1 + 1e-12


def test_the_kernels_form_of_the_even_dashpot():
    # contact_law.h: sqrt(3 delta/(4 s)) below, q / sqrt(q^2 + s^2/12) beyond
    assert dashpot_share(0.3, 1.0, "even") == pytest.approx(sqrt(0.75 * 0.3), rel=1e-14)
    assert dashpot_share(2.0, 1.0, "even") == pytest.approx(1.5 / sqrt(1.5**2 + 1 / 12), rel=1e-14)


@pytest.mark.parametrize("e", [0.05, 0.2, 0.6, 0.9])
@pytest.mark.parametrize("width", [0.01, 1.0, 100.0])
def test_even_restitution_is_that_of_the_linear_law_at_any_width(e, width):
    # the lagged dashpot makes it low by about 2 xi h: h = 0.002
    assert restitution(damping_ratio(e), 0.002, width, 1.0, 0.5) == pytest.approx(e, rel=0.004)


def test_ramp_restitution_depends_on_the_width():
    xi = damping_ratio(0.2)
    assert restitution(xi, 0.002, 0.01, 1.0, 0.5, "ramp") == pytest.approx(0.2, rel=0.02)
    assert restitution(xi, 0.002, 100.0, 1.0, 0.5, "ramp") > 0.5


def test_only_speed_over_width_matters():
    assert restitution(0.3, 0.1, 0.2, 1.0, 0.3) == pytest.approx(restitution(0.3, 0.1, 0.4, 2.0, 0.3), rel=1e-12)


def test_the_sharp_contact_follows_the_closed_form():
    xi, h = damping_ratio(0.2), 0.1
    assert mean_restitution(xi, h, 0.0, 1.0)[0] == pytest.approx(lagged_restitution(xi, h), rel=0.005)


def test_the_touch_takes_the_scatter_of_the_entry_phase_away():
    sharp, smooth = mean_restitution(0.0, 0.4, 0.0, 1.0)[1], mean_restitution(0.0, 0.4, 0.8, 1.0)[1]
    assert smooth < 0.05 * sharp


def test_a_fitted_dashpot_gives_what_is_wanted():
    factor = fitted_factor(0.2, 0.2, 0.2, "ramp")
    assert mean_restitution(factor * damping_ratio(0.2), 0.2, 0.2, 1.0, "ramp")[0] == pytest.approx(0.2, rel=0.005)


def test_the_table_of_the_documentation():
    rows = table(restitutions=(0.6,), fractions=(0.2,), widths=(2.0,))
    assert len(rows) == 3
    assert rows[2] in open_documentation()


def open_documentation():
    from pathlib import Path

    return (Path(__file__).parents[2] / "docs" / "kernels.md").read_text()


def test_a_contact_that_never_ends_is_an_error(monkeypatch):
    monkeypatch.setattr("lammps_jump.engines.plugin.touch_study.LIMIT", 3)
    with pytest.raises(ArithmeticError, match="not ended"):
        restitution(0.3, 0.1, 0.2, 1.0, 0.3)
