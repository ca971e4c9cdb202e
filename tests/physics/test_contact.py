# SPDX-License-Identifier: GPL-2.0-or-later
"""contact.py against the closed forms and tables of the physics notes; tolerances are half the last printed digit."""

from math import exp, log, pi, sqrt

import pytest
from closed_forms import clipped_restitution, friction_impulse_factor
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.physics import contact

VELOCITY = 16.0
DENSITY = 1000.0
DIAMETER = 0.2


def derive(**changes):
    """The thesis' jump contact (Va = 16 m/s, n = 10, e = 0.2) with changes."""
    values = {
        "density": DENSITY,
        "diameter": DIAMETER,
        "restitution": 0.2,
        "friction": 0.1,
        "stiffness": 2.56e7,
        "stiffness_wall": 2.56e7,
        "impact_speed": VELOCITY,
        "time_step_fraction": 0.05,
        "integrator": "velocity_verlet",
        "correct_restitution": False,
        "rotation": False,
    }
    return contact.derive(contact.ContactNumbers(**values | changes))


def test_mass_is_density_times_diameter_squared():
    # thesis energy box: one disc of 0.4 m at (6, -6) m/s carries exactly 5760 J
    assert 0.5 * contact.disc_mass(1000.0, 0.4) * (6**2 + 6**2) == pytest.approx(5760.0, rel=1e-15)
    assert contact.disc_mass(DENSITY, DIAMETER) == pytest.approx(40.0, rel=1e-15)


@pytest.mark.parametrize(
    ("n", "k", "omega", "dt", "c_pair", "c_wall", "gamma_pair", "gamma_wall"),
    [
        (5, 6.40e6, 565.7, 1.768e-4, 10317, 14590, 515.85, 364.76),
        (10, 2.56e7, 1131.4, 8.839e-5, 20634, 29181, 1031.7, 729.52),
        (20, 1.024e8, 2262.7, 4.419e-5, 41268, 58362, 2063.4, 1459.0),
        (30, 2.304e8, 3394.1, 2.946e-5, 61902, 87542, 3095.1, 2188.6),
    ],
)
def test_coefficients_of_the_thesis_jump(n, k, omega, dt, c_pair, c_wall, gamma_pair, gamma_wall):
    stiffness = contact.stiffness(DENSITY, 1 / n, VELOCITY)
    assert stiffness == pytest.approx(k, rel=1e-12)  # exact product of round numbers
    c = derive(stiffness=stiffness, stiffness_wall=stiffness)
    assert c.omega == pytest.approx(omega, abs=0.05)
    assert c.time_step == pytest.approx(dt, rel=0.5e-3 / 1.768)
    assert c.damping == pytest.approx(c_pair, abs=0.5)
    assert c.damping_wall == pytest.approx(c_wall, abs=0.5)
    assert c.gamma_normal == pytest.approx(gamma_pair, abs=0.051)
    assert c.gamma_normal_wall == pytest.approx(gamma_wall, abs=0.051)
    assert c.damping_wall / c.damping == pytest.approx(sqrt(2), rel=1e-14)  # same k, twice the effective mass


COLLISIONS = [
    # e, xi, t_c w0, t_max w0, delta_max w0/v0, t0 w0, e_clip, F_max/(m* w0 v0), A
    (0.1, 0.591155, 3.895061, 1.163346, 0.502722, 2.326693, 0.252729, 1.182310, 1.27769),
    (0.2, 0.455950, 3.529858, 1.232978, 0.569967, 2.465956, 0.324863, 0.925806, 1.20811),
    (0.3, 0.357857, 3.364395, 1.290271, 0.630191, 2.580541, 0.397140, 0.834248, 1.14945),
    (0.5, 0.215454, 3.217151, 1.386196, 0.741811, 2.772392, 0.550283, 0.816412, 1.06704),
    (0.6, 0.160493, 3.182852, 1.428119, 0.795167, 2.856238, 0.632291, 0.837961, 1.04036),
    (0.8, 0.070850, 3.149507, 1.503665, 0.898943, 3.007331, 0.808099, 0.908045, 1.00900),
    (0.9, 0.033518, 3.143359, 1.538136, 0.949751, 3.076272, 0.902026, 0.951889, 1.00213),
]


@pytest.mark.parametrize("row", COLLISIONS, ids=[f"e={row[0]}" for row in COLLISIONS])
def test_collision_table(row):
    e, xi, duration, _, overlap, _, clipped, force, factor = row
    digit = 0.51e-6
    assert contact.damping_ratio(e) == pytest.approx(xi, abs=digit)
    assert contact.contact_duration(e, 1.0) == pytest.approx(duration, abs=digit)
    assert contact.largest_overlap(1.0, e, 1.0) == pytest.approx(overlap, abs=digit)
    assert clipped_restitution(contact.damping_ratio(e)) == pytest.approx(clipped, abs=digit)
    assert contact.peak_force(1.0, contact.damping_ratio(e), 1.0, 1.0) == pytest.approx(force, abs=digit)
    # 1.208105 was printed 1.20811, from the six printed digits of e_clip: a whole last digit in doubt
    assert friction_impulse_factor(e) == pytest.approx(factor, abs=0.6e-5)


@pytest.mark.parametrize(
    ("e", "xi"),
    [(0.1, 1.243188), (0.2, 0.731247), (0.3, 0.497239), (0.5, 0.255276), (0.6, 0.180858), (0.8, 0.074355)],
)
def test_clipped_restitution_inverts_to_the_tabled_ratio(e, xi):
    # the sixth digit of xi changes e_clip by less than 1e-6
    assert clipped_restitution(xi) == pytest.approx(e, abs=1e-6)


def test_clipped_restitution_is_continuous_at_critical_damping():
    # one-sided values 1e-6 away from xi = 1 differ from the limit by terms of first order in the distance
    for xi in (1 - 1e-6, 1.0, 1 + 1e-6):
        assert clipped_restitution(xi) == pytest.approx(exp(-2.0), abs=1e-6)


@given(e=st.floats(0.02, 1.0))
def test_closed_forms_solve_the_equation_of_motion(e):
    """The damped oscillator, integrated by a fine independent scheme, gives duration, overlap, force, restitution."""
    xi = contact.damping_ratio(e)
    steps = 4000
    dt = contact.contact_duration(e, 1.0) / steps
    x, v = 0.0, 1.0
    peak_x, peak_f = 0.0, 2 * xi
    for _ in range(steps):  # classical Runge-Kutta: error far below the tolerance at this step

        def rate(x, v):
            return v, -x - 2 * xi * v

        a1, b1 = rate(x, v)
        a2, b2 = rate(x + dt / 2 * a1, v + dt / 2 * b1)
        a3, b3 = rate(x + dt / 2 * a2, v + dt / 2 * b2)
        a4, b4 = rate(x + dt * a3, v + dt * b3)
        x += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        v += dt / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        peak_x, peak_f = max(peak_x, x), max(peak_f, x + 2 * xi * v)
    assert x == pytest.approx(0.0, abs=1e-9)
    assert -v == pytest.approx(e, abs=1e-9)
    # a maximum sampled every dt is low by at most its curvature times dt^2/8, below 1e-6 here
    assert peak_x == pytest.approx(contact.largest_overlap(1.0, e, 1.0), abs=1e-6)
    assert peak_f == pytest.approx(contact.peak_force(1.0, xi, 1.0, 1.0), abs=2e-6)


DISCRETE = [
    # e, f, LAMMPS, thesis scheme, factor that cancels the LAMMPS bias
    (0.2, 0.01, 0.19814, 0.19995, 0.9955),
    (0.2, 0.05, 0.19057, 0.19875, 0.9775),
    (0.2, 0.10, 0.18076, 0.19471, 0.9557),
    (0.2, 0.20, 0.15968, 0.17770, 0.9142),
    (0.6, 0.05, 0.59757, 0.59859, 0.9924),
    (0.6, 0.10, 0.59534, 0.59425, 0.9856),
    (0.9, 0.05, 0.89988, 0.89956, 0.9987),
]


@pytest.mark.parametrize("row", DISCRETE, ids=[f"e={row[0]} f={row[1]}" for row in DISCRETE])
def test_discrete_restitution_table(row):
    e, f, lagged, extrapolated, factor = row
    xi, h = contact.damping_ratio(e), 2 * f
    assert contact.lagged_restitution(xi, h) == pytest.approx(lagged, abs=0.51e-5)
    assert contact.extrapolated_restitution(xi, h) == pytest.approx(extrapolated, abs=0.51e-5)
    assert contact.lagged_correction(e, h) == pytest.approx(factor, abs=0.51e-4)


@given(e=st.floats(0.02, 1.0), f=st.floats(0.001, 0.2))
def test_correction_restores_the_restitution(e, f):
    factor = contact.lagged_correction(e, 2 * f)
    # the bisection leaves 2^-80; what remains is the round-off of exp and acos
    assert contact.lagged_restitution(factor * contact.damping_ratio(e), 2 * f) == pytest.approx(e, rel=1e-9)


@pytest.mark.parametrize("discrete", [contact.lagged_restitution, contact.extrapolated_restitution])
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_discrete_restitution_tends_to_the_exact_one(discrete, e):
    xi = contact.damping_ratio(e)
    coarse, fine = (abs(discrete(xi, h) - e) for h in (2e-3, 1e-3))
    assert fine < coarse < 2e-3
    order = 1 if discrete is contact.lagged_restitution else 2
    # observed order between two small steps: the next term of the series is of relative size h
    assert coarse / fine == pytest.approx(2**order, rel=0.02)


STABLE = [
    (0.0, 2.0, 2.0),
    (0.1, 1.810, 1.640),
    (0.2, 1.640, 1.354),
    (0.455950, 1.286, 0.883),
    (0.8, 0.961, 0.574),
]


@pytest.mark.parametrize(("xi", "lagged", "extrapolated"), STABLE)
def test_stability_limits(xi, lagged, extrapolated):
    assert contact.lagged_stable_h(xi) == pytest.approx(lagged, abs=0.51e-3)
    assert contact.extrapolated_stable_h(xi) == pytest.approx(extrapolated, abs=0.51e-3)


def largest_multiplier(integrator: str, xi: float, h: float) -> float:
    """Growth per step of the scheme itself, iterated: no use of the closed forms."""
    x, v, older = 1.0, 0.3, 0.3
    size = 0.0
    for step in range(4000):
        seen = v if integrator == "velocity_verlet" else 1.5 * v - 0.5 * older
        v, older = v - h * (x + 2 * xi * seen), v
        x += h * v
        scale = abs(x) + abs(v) + abs(older)
        x, v, older = x / scale, v / scale, older / scale
        size += 0.0 if step < 2000 else log(scale)
    return size / 2000


@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
@pytest.mark.parametrize("xi", [0.1, 0.2, 0.45595, 0.8])
def test_stability_limit_of_the_scheme_itself(integrator, xi):
    limit = contact.lagged_stable_h(xi) if integrator == "velocity_verlet" else contact.extrapolated_stable_h(xi)
    # 0.5 % on either side of the limit the growth rate is of order 1e-3 a step, seen over 2000 steps
    assert largest_multiplier(integrator, xi, 0.995 * limit) < 0
    assert largest_multiplier(integrator, xi, 1.005 * limit) > 0


@pytest.mark.parametrize(
    ("e", "integrator", "packing", "fraction"),
    [
        (1.0, "velocity_verlet", "hexagonal", 0.577),
        (0.2, "velocity_verlet", "hexagonal", 0.280),
        (0.2, "leapfrog_extrapolated", "hexagonal", 0.167),
        (0.2, "leapfrog_extrapolated", "square", 0.242),
        (0.2, "velocity_verlet", "pair", 0.643),
        (0.2, "leapfrog_extrapolated", "pair", 0.4415),
    ],
)
def test_stable_fraction_in_packings(e, integrator, packing, fraction):
    assert contact.stable_fraction(contact.damping_ratio(e), integrator, packing) == pytest.approx(fraction, abs=6e-4)


def test_correction_reaches_the_engine_coefficients_of_verlet_only():
    plain, corrected = derive(), derive(correct_restitution=True)
    assert corrected.gamma_normal / plain.gamma_normal == pytest.approx(0.9775, abs=0.51e-4)
    assert corrected.damping == plain.damping  # the nominal dashpot is what the case asked for
    # at a wall omega dt is smaller by sqrt 2, and so is the bias
    assert 0.9775 < corrected.gamma_normal_wall / plain.gamma_normal_wall < 1
    thesis = derive(correct_restitution=True, integrator="leapfrog_extrapolated")
    assert thesis.correction == thesis.correction_wall == 1.0


def test_smooth_touch_takes_half_the_correction():
    sharp, smooth = derive(correct_restitution=True), derive(correct_restitution=True, touch="smooth")
    assert 1 - smooth.correction == pytest.approx(0.5 * (1 - sharp.correction), rel=1e-12)
    assert 1 - smooth.correction_wall == pytest.approx(0.5 * (1 - sharp.correction_wall), rel=1e-12)
    assert derive(touch="smooth").correction == 1


def test_perfectly_elastic_contact_has_no_dashpot():
    c = derive(restitution=1.0, correct_restitution=True)
    assert (c.damping, c.damping_wall, c.gamma_normal, c.gamma_normal_wall, c.correction) == (0, 0, 0, 0, 1)
    assert c.contact_duration == pytest.approx(pi / c.omega, rel=1e-14)
    assert c.largest_overlap == pytest.approx(VELOCITY / c.omega, rel=1e-14)


def test_overlaps_of_the_undamped_contact():
    """Physics notes, section 0: d/n at a wall, d/(n sqrt 2) in a pair at the relative speed v0."""
    c = derive(restitution=1.0)
    assert contact.largest_overlap(VELOCITY, 1.0, c.omega_wall) == pytest.approx(DIAMETER / 10, rel=1e-12)
    assert c.largest_overlap == pytest.approx(DIAMETER / 10 / sqrt(2), rel=1e-12)


@pytest.mark.parametrize("restitution", [0.1, 0.2, 0.6, 1.0])
@pytest.mark.parametrize("rotation", [False, True])
def test_slip_speed_is_where_the_ramp_meets_coulomb_at_the_peak_load(restitution, rotation):
    c = derive(restitution=restitution, rotation=rotation)
    peak = contact.peak_force(VELOCITY, c.damping_ratio, c.omega, c.mass / 2)
    assert c.mass / 2 * c.gamma_tangential * c.slip_speed == pytest.approx(c.friction * peak, rel=1e-14)


def test_frictionless_contact_has_no_ramp():
    c = derive(friction=0.0)
    assert (c.gamma_tangential, c.gamma_tangential_wall, c.slip_speed) == (0, 0, 0)


def test_tangential_rate_of_the_case_is_taken_as_it_is():
    c = derive(tangential_damping=1234.5)
    assert (c.gamma_tangential, c.gamma_tangential_wall) == (1234.5, 1234.5)


@pytest.mark.parametrize("rotation", [False, True])
def test_default_ramp_decays_without_ringing_in_the_densest_packing(rotation):
    # lagged viscous law: monotone below 1; a hexagonal packing is three times as stiff as a pair, spin three more
    c = derive(rotation=rotation)
    assert 3 * (3 if rotation else 1) * c.gamma_tangential * c.time_step < 1


@given(e=st.floats(0.01, 1.0), k=st.floats(1e4, 1e9), n_mass=st.floats(0.1, 1e3))
def test_damping_gives_the_restitution_back(e, k, n_mass):
    xi = contact.damping(e, k, n_mass) / (2 * sqrt(k * n_mass))
    assert exp(-pi * xi / sqrt(1 - xi**2)) == pytest.approx(e, rel=1e-10)
