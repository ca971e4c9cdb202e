# SPDX-License-Identifier: GPL-2.0-or-later
"""What bodies are, told by masses and diameters: a sphere of LAMMPS' ``atom_style sphere`` and others."""

from math import pi

import numpy as np
import pytest

from lammps_jump.physics import bodies

SIZES = np.array([0.012, 0.014, 0.018])


@pytest.mark.parametrize(
    ("kind", "power", "factor"), [("spheres", 3, pi / 6), ("cylinders", 2, pi / 4), ("discs", 2, 1.0)]
)
def test_a_given_density_tells_the_bodies(kind, power, factor):
    masses = factor * 2500.0 * SIZES**power
    assert bodies.kinds_that_fit(masses, SIZES, 2500.0) == (kind,)
    assert bodies.density_of(kind, masses, SIZES) == pytest.approx(2500.0)
    assert bodies.mass_of(kind, 0.012, 2500.0) == pytest.approx(masses[0])
    assert bodies.kinds_that_fit(masses, SIZES, 1234.0) == ()


def test_masses_of_unequal_bodies_tell_spheres_by_their_power():
    spheres = bodies.mass_of("spheres", 1.0, 2500.0) * SIZES**3
    assert bodies.kinds_that_fit(spheres, SIZES) == ("spheres",)
    # cylinders and discs differ by a factor that a density could have: both count per metre of width
    assert bodies.kinds_that_fit(2500.0 * SIZES**2, SIZES) == ("cylinders", "discs")


def test_masses_of_equal_bodies_are_told_by_the_density_of_a_material():
    d = np.full(3, 0.015)
    assert bodies.kinds_that_fit(bodies.mass_of("spheres", d, 2500.0), d) == ("spheres",)
    assert bodies.kinds_that_fit(bodies.mass_of("cylinders", d, 2650.0), d) == ("cylinders", "discs")
    large = np.full(3, 0.5)  # spheres of 2500 are discs of 654
    assert bodies.kinds_that_fit(bodies.mass_of("spheres", large, 2500.0), large) == ("spheres", "cylinders", "discs")
    assert bodies.kinds_that_fit(np.full(3, 1e-9), d) == (), "no material is so light"


def test_a_layer_of_spheres_is_a_diameter_wide():
    assert bodies.per_width("spheres", 0.3, 0.1) == pytest.approx(3.0)
    assert bodies.per_width("cylinders", 0.3, 0.1) == 0.3


def test_a_line_has_no_area_and_warns_of_nothing():
    assert bodies.section_of_polygon(np.array([[24.0, 0.0], [24.0, 2.0]])) == (0.0, (24.0, 1.0), 0.0)
