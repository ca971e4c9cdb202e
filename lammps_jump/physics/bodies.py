# SPDX-License-Identifier: GPL-2.0-or-later
"""What the bodies of a layer are, by their masses and diameters: spheres, cylinders, or discs of the thesis.

The mass of a sphere is rho pi d^3/6 (kg), that of a cylinder rho pi d^2/4 and that of a disc of the thesis rho d^2
(kg per metre of width). ``atom_style sphere`` of LAMMPS gives the first, ``set density/disc`` the second.
"""

from __future__ import annotations

from math import pi

import numpy as np

SHAPES = {"spheres": (3, pi / 6), "cylinders": (2, pi / 4), "discs": (2, 1.0)}
"""Power p and factor f of the mass, f rho d^p, by the kind of the bodies."""
SAME = 0.02
"""Largest spread of m/d^p for masses that go with that power of the diameter, as a share."""
FITS = 0.05
"""How far the density of the masses may lie off one that is given, as a share."""
MATERIALS = (400.0, 12000.0)
"""Densities of what bodies are made of, from light wood to lead, kg/m^3."""


def mass_of(kind: str, diameter: float, density: float) -> float:
    """Mass of a body, kg of a sphere, else kg per metre of width; diameter in m, density in kg/m^3."""
    power, factor = SHAPES[kind]
    return factor * density * diameter**power


def per_width(kind: str, mass: float, diameter: float) -> float:
    """Mass per metre of width, kg/m: a layer of spheres is a diameter (m) wide."""
    return mass / diameter if kind == "spheres" else mass


def density_of(kind: str, masses: np.ndarray, diameters: np.ndarray) -> float:
    """Density of the material of bodies of this kind, kg/m^3: their mass over their volume."""
    power, factor = SHAPES[kind]
    return float(np.sum(masses) / np.sum(factor * diameters**power))


def told(masses: np.ndarray, diameters: np.ndarray, density: float | None = None) -> tuple[str, ...]:
    """The kinds of bodies that masses and diameters agree with; none where they fit nothing.

    Parameters
    ----------
    masses : ndarray, shape (n,)
        kg, or kg per metre of width.
    diameters : ndarray, shape (n,), m
    density : float, optional
        Of the material, kg/m^3. A kind whose density lies within `FITS` of it fits. Without it, one does whose masses
        go with its power of the diameter, and whose density is that of a material.
    """
    found = {kind: density_of(kind, masses, diameters) for kind in SHAPES}
    if density is not None:
        return tuple(kind for kind, value in found.items() if abs(value / density - 1.0) <= FITS)
    low, high = MATERIALS
    scaled = {kind: masses / diameters**power for kind, (power, _) in SHAPES.items()}
    alike = {kind for kind, values in scaled.items() if np.ptp(values) <= SAME * np.mean(values)}
    return tuple(kind for kind, value in found.items() if kind in alike and low <= value <= high)
