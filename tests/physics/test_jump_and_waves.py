# SPDX-License-Identifier: GPL-2.0-or-later
"""jump.py, waves.py and measured.py against printed tables and their own conservation laws."""

import subprocess
import sys
from itertools import pairwise
from math import isnan, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lammps_jump.physics import jump as theory
from lammps_jump.physics import jump as waves
from lammps_jump.physics import measured as reference_data

G = 9.81
FR_THESIS = 16 / sqrt(G)  # Va = 16 m/s, y1 = 1 m


# --- the jump ---------------------------------------------------------------------------------------------------

JUMPS = [
    # Fr1, y2/y1, Fr2, dE/E1, Silvester L/y1, USBR
    (2, 2.3723, 0.5474, 0.0908, 9.75, 10.32),
    (3, 3.7720, 0.4095, 0.2567, 19.64, 19.35),
    (4, 5.1789, 0.3394, 0.3914, 29.57, 29.00),
    (5, 6.5887, 0.2956, 0.4906, 39.54, 38.68),
    (5.108, 6.7411, 0.2918, 0.4996, 40.62, 39.69),
    (6, 8.0000, 0.2652, 0.5641, 49.54, 48.16),
    (7, 9.4121, 0.2424, 0.6201, 59.56, 57.32),
    (9, 12.2377, 0.2102, 0.6986, 79.64, 75.14),
]


@pytest.mark.parametrize("row", JUMPS, ids=[f"Fr1={row[0]}" for row in JUMPS])
def test_jump_table(row):
    fr, ratio, fr2, loss, silvester, usbr = row
    four, two = 0.51e-4, 0.51e-2  # half a unit of the last printed digit
    assert theory.belanger(fr) == pytest.approx(ratio, abs=four)
    assert theory.downstream_froude(fr) == pytest.approx(fr2, abs=four)
    e1 = theory.specific_energy(1.0, fr * sqrt(G))
    assert e1 == pytest.approx(1 + fr**2 / 2, rel=1e-14)
    assert theory.energy_loss(1.0, theory.belanger(fr)) / e1 == pytest.approx(loss, abs=four)
    assert theory.silvester_jump_length(fr, 1.0) == pytest.approx(silvester, abs=two)
    assert theory.usbr_jump_length(fr, 1.0) == pytest.approx(usbr, abs=two)


def test_the_thesis_jump():
    assert theory.froude(16.0, 1.0) == pytest.approx(5.11, abs=0.005)
    assert theory.sequent_depth(16.0, 1.0) == pytest.approx(6.742, abs=0.0005)
    assert theory.silvester_jump_length(theory.froude(16.0, 1.0), 1.0) == pytest.approx(40.63, abs=0.005)
    assert theory.channel_length(theory.froude(16.0, 1.0), 1.0) == pytest.approx(60.9, abs=0.05)
    # thesis: 15.66 sqrt(y1) <= Va <= 28.19 sqrt(y1); the upper one prints as 28.19 for 28.1887
    assert theory.velocity_range(1.0) == pytest.approx((15.66, 28.19), abs=0.005)
    assert theory.velocity_range(4.0) == pytest.approx((31.32, 56.38), abs=0.01)
    assert theory.critical_depth(16.0) == pytest.approx(2.966, abs=0.0005)
    assert theory.sill_holding_height(16.0, 1.0) == pytest.approx(2.58, abs=0.005)


@given(fr=st.floats(1.01, 20.0), y1=st.floats(0.01, 50.0))
def test_jump_conserves_momentum_and_loses_energy(fr, y1):
    y2 = y1 * theory.belanger(fr)
    u1 = fr * sqrt(G * y1)
    u2 = u1 * y1 / y2
    upstream, downstream = (1000.0 * y * u**2 + waves.hydrostatic_force(y, 1000.0) for y, u in ((y1, u1), (y2, u2)))
    assert upstream == pytest.approx(downstream, rel=1e-10)
    lost = theory.specific_energy(y1, u1) - theory.specific_energy(y2, u2)
    # a difference of two heads: round-off is relative to the larger
    assert theory.energy_loss(y1, y2) == pytest.approx(lost, abs=1e-10 * theory.specific_energy(y1, u1))
    assert theory.froude(u2, y2) == pytest.approx(theory.downstream_froude(fr), rel=1e-10)


@given(fr=st.floats(1.01, 20.0))
def test_sequent_depths_are_conjugate(fr):
    # the jump's formula maps the downstream state back to the upstream depth
    assert theory.belanger(theory.downstream_froude(fr)) * theory.belanger(fr) == pytest.approx(1.0, rel=1e-10)


@pytest.mark.parametrize(
    ("fr", "kind"),
    [
        *((0.8, "none"), (1.0, "none"), (1.2, "undular"), (1.7, "undular"), (2.0, "weak")),
        *((3.0, "oscillating"), (5.11, "steady"), (9.0, "steady"), (9.5, "strong")),
    ],
)
def test_jump_class(fr, kind):
    assert theory.jump_class(fr) == kind


@pytest.mark.parametrize(
    ("density_ratio", "s", "h"), [(1.05, 6.924, 6.594), (1.10, 7.101, 6.456), (1.1547, 7.291, 6.314)]
)
def test_sequent_ratio_with_density_change(density_ratio, s, h):
    found = theory.sequent_ratio(FR_THESIS, density_ratio)
    assert found == pytest.approx(s, abs=0.51e-3)
    assert found / density_ratio == pytest.approx(h, abs=0.51e-3)


def test_sequent_ratio_with_profile_momentum():
    # 6.799 holds where the same momentum coefficient acts on both sides; on the inflow alone it is 6.808
    beta = 64 / 63  # mean(u^2) / mean(u)^2 of the one-seventh profile
    assert theory.sequent_ratio(FR_THESIS, beta_1=beta, beta_2=beta) == pytest.approx(6.799, abs=0.51e-3)
    assert theory.sequent_ratio(FR_THESIS, beta_1=beta) == pytest.approx(6.808, abs=0.6e-3)


@given(
    fr=st.floats(1.5, 12.0),
    density_ratio=st.floats(0.9, 1.3),
    resistance=st.floats(-0.5, 1.0),
    beta=st.floats(1.0, 1.1),
)
def test_sequent_ratio_closes_the_momentum_balance(fr, density_ratio, resistance, beta):
    try:
        s = theory.sequent_ratio(fr, density_ratio, resistance, beta_1=beta)
    except ValueError:
        assume(False)
    left = 2 * fr**2 * (beta - 1 / s) + 1 - s**2 / density_ratio
    assert left == pytest.approx(resistance * (1 + s), abs=1e-9 * fr**2)
    # the larger root: more depth than that and the downstream momentum exceeds the upstream one
    assert 2 * fr**2 * (beta - 1 / (1.01 * s)) + 1 - (1.01 * s) ** 2 / density_ratio < resistance * (1 + 1.01 * s)


@given(fr=st.floats(1.0, 20.0))
def test_sequent_ratio_reduces_to_belanger(fr):
    # at Fr1 = 1 the two roots meet, so round-off eps there becomes sqrt(eps) in the root
    assert theory.sequent_ratio(fr) == pytest.approx(theory.belanger(fr), rel=1e-10, abs=1e-7)


def test_bed_resistance_lowers_the_sequent_depth():
    free, rough, down = (theory.sequent_ratio(FR_THESIS, 1.0, k) for k in (0.0, 0.3, -0.3))
    assert rough < free < down


@pytest.mark.parametrize(
    ("fr", "density_ratio", "resistance"), [(0.5, 0.8, 0.0), (1.2, 1.0, 5.0), (0.0, 1.0, 0.0), (5.0, -1.0, 0.0)]
)
def test_sequent_ratio_refuses_what_cannot_jump(fr, density_ratio, resistance):
    with pytest.raises(ValueError, match="sequent_ratio"):
        theory.sequent_ratio(fr, density_ratio, resistance)


def test_usbr_points_are_met_and_nothing_outside():
    curve = reference_data.USBR_JUMP_LENGTH
    for fr, ratio in zip(curve.x, curve.y, strict=True):
        assert theory.usbr_jump_length(fr, 2.0) == pytest.approx(2.0 * ratio * theory.belanger(fr), rel=1e-14)
    assert isnan(theory.usbr_jump_length(1.59, 1.0)) and isnan(theory.usbr_jump_length(19.3, 1.0))
    assert isnan(theory.silvester_jump_length(0.9, 1.0))


# --- inflow -----------------------------------------------------------------------------------------------------


# --- sill -------------------------------------------------------------------------------------------------------


def test_force_on_a_sill_of_the_thesis():
    force = waves.hydrostatic_force(6.742, 1000.0, above=6.742 - 2.0)
    assert force == pytest.approx(112.6e3, abs=60)  # printed in kN to one digit


# --- moving shocks ----------------------------------------------------------------------------------------------


@given(s1=st.floats(0.05, 5.0), u1=st.floats(-5.0, 25.0), growth=st.floats(1.05, 15.0))
def test_moving_shock_is_a_jump_in_its_own_frame(s1, u1, growth):
    s2 = growth * s1
    c = u1 - sqrt(G * s2 * (s1 + s2) / (2.0 * s1))  # mass and momentum over the shock, hydrostatic pressure
    fr = waves.relative_froude(u1, s1, c)
    assert theory.belanger(fr) == pytest.approx(growth, rel=1e-9)
    u2 = c + s1 * (u1 - c) / s2
    assert waves.shock_speed_from_mass(s1, u1, s2, u2) == pytest.approx(c, rel=1e-8, abs=1e-8)


def test_probe_of_the_frictionless_jump():
    """Physics notes 2.3: toe at -2.0 m/s, s1 = 1.107 m, u1 = 13.6 m/s, Froude number 4.735, Bélanger 6.22."""
    fr = waves.relative_froude(13.6, 1.107, -2.0)
    assert fr == pytest.approx(4.735, abs=0.003)  # u1 and c are printed to 0.1 m/s
    assert theory.belanger(fr) == pytest.approx(6.22, abs=0.01)


@given(s=st.floats(0.1, 5.0), u=st.floats(0.5, 20.0))
def test_reflected_bore_stops_the_flow(s, u):
    s2, c = waves.reflected_bore(s, u)
    assert s2 > s and c < 0
    assert waves.shock_speed_from_mass(s, u, s2, 0.0) == pytest.approx(c, rel=1e-9)
    assert u - sqrt(G * s2 * (s + s2) / (2.0 * s)) == pytest.approx(c, rel=1e-6, abs=1e-9)


# --- dam break --------------------------------------------------------------------------------------------------


def test_ritter_numbers_at_the_dam():
    h0 = 12.0
    assert waves.ritter_front(1.0, h0) == pytest.approx(21.70, abs=0.005)
    assert waves.ritter_wall_time(4.0, h0) == pytest.approx(0.37, abs=0.005)


# --- columns and walls ------------------------------------------------------------------------------------------


def test_hydrostatic_load_of_the_thesis_column():
    assert waves.hydrostatic_force(12.0, 1000.0) == pytest.approx(706e3, abs=500)


# --- reference data ---------------------------------------------------------------------------------------------


MARTIN_MOYCE = (reference_data.MARTIN_MOYCE_FRONT, reference_data.MARTIN_MOYCE_HEIGHT)


@pytest.mark.parametrize("curve", [reference_data.USBR_JUMP_LENGTH, *MARTIN_MOYCE], ids=("USBR", "front", "height"))
def test_curves_are_whole(curve):
    assert len(curve.x) == len(curve.y) > 5
    assert all(b > a for a, b in pairwise(curve.x))


def test_martin_moyce_runs_the_right_way():
    for curve in MARTIN_MOYCE:
        falls = curve is reference_data.MARTIN_MOYCE_HEIGHT
        assert all((b < a) == falls for a, b in pairwise(curve.y))


def test_martin_moyce_slope():
    front = reference_data.MARTIN_MOYCE_FRONT
    t, z = np.array(front.x), np.array(front.y)
    late = t >= 1.43
    slope = np.polyfit(t[late], z[late], 1)[0]
    assert slope == pytest.approx(reference_data.MARTIN_MOYCE_FRONT_SLOPE[2], abs=0.51e-3)


# --- start-up ---------------------------------------------------------------------------------------------------


def test_theory_imports_nothing_heavy():
    """`check` has 0.7 s to start: theory must not pull in numpy, let alone the engines."""
    code = (
        "import sys; from lammps_jump.physics import jump, contact; "
        "print([m for m in ('numpy', 'scipy', 'lammps', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_formula_has_a_source_or_a_derivation():
    root = Path(theory.__file__).parents[2]
    for path in (*(root / "lammps_jump/physics").glob("*.py"), *(root / "docs").glob("*.md")):
        assert "from memory" not in path.read_text().lower(), path
