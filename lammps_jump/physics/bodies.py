# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies: what those of a layer are, by their masses and diameters, and rigid ones of an outline.

Those of a layer are spheres, cylinders, or discs of the thesis.

The mass of a sphere is rho pi d^3/6 (kg), that of a cylinder rho pi d^2/4 and that of a disc of the thesis rho d^2
(kg per metre of width). ``atom_style sphere`` of LAMMPS gives the first, ``set density/disc`` the second.

Checks of a gravity structure on a plane base, per metre of width: Y. Goda, "Random Seas and Design of Maritime
Structures" (2010), section 4.3. t is the unit vector along the base from its left to its right end, n = (-t_y, t_x)
points up from it, and the force Q is that of the discs and the weight together.
"""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import NamedTuple

import numpy as np

SHAPES = {"spheres": (3, pi / 6), "cylinders": (2, pi / 4), "discs": (2, 1.0)}
"""Power p and factor f of the mass, f rho d^p, by the kind of the bodies."""
SAME = 0.02
"""Largest spread of m/d^p for masses that go with that power of the diameter, as a share."""
FITS = 0.05
"""Deviation that the density of the masses may have from one that is given, as a share."""
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


def kinds_that_fit(masses: np.ndarray, diameters: np.ndarray, density: float | None = None) -> tuple[str, ...]:
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
    densities = {kind: density_of(kind, masses, diameters) for kind in SHAPES}
    if density is not None:
        return tuple(kind for kind, value in densities.items() if abs(value / density - 1.0) <= FITS)
    low, high = MATERIALS
    scaled = {kind: masses / diameters**power for kind, (power, _) in SHAPES.items()}
    alike = {kind for kind, values in scaled.items() if np.ptp(values) <= SAME * np.mean(values)}
    return tuple(kind for kind, value in densities.items() if kind in alike and low <= value <= high)


# --- rigid bodies of an outline ---------------------------------------------------------------------------------------


class BodySection(NamedTuple):
    """Area (m^2), centre (m) and second moment about the centre (m^4) of an outline."""

    area: float
    centre: tuple[float, float]
    moment: float


def section_of_polygon(corners: np.ndarray) -> BodySection:
    """Area, centre and polar second moment of a polygon, either way round, by Green's theorem; 0 of a line.

    Parameters
    ----------
    corners : ndarray, shape (n, 2), m
    """
    origin = corners.mean(axis=0)  # small numbers keep their digits
    x, y = (corners - origin).T
    u, v = np.roll(x, -1), np.roll(y, -1)
    cross = x * v - u * y
    area = 0.5 * cross.sum()
    if not area:  # a line has neither centre nor moment
        return BodySection(0.0, (float(origin[0]), float(origin[1])), 0.0)
    cx, cy = ((x + u) * cross).sum() / (6.0 * area), ((y + v) * cross).sum() / (6.0 * area)
    about_origin = ((x * x + x * u + u * u + y * y + y * v + v * v) * cross).sum() / 12.0
    moment = about_origin - area * (cx * cx + cy * cy)
    sense = 1.0 if area > 0 else -1.0
    return BodySection(float(sense * area), (float(origin[0] + cx), float(origin[1] + cy)), float(sense * moment))


def section_of_circle(centre: tuple[float, float], radius: float) -> BodySection:
    """The same of a circle: pi r^2 and pi r^4/2."""
    return BodySection(pi * radius * radius, centre, 0.5 * pi * (radius * radius) * (radius * radius))


def about_point(mass: float, inertia: float, distance: float) -> float:
    """Moment of inertia about a point at a distance (m) from the centre of mass, kg m: I + M r^2 (Steiner)."""
    return inertia + mass * distance * distance


def effective_mass(*inverse: float) -> float:
    """Mass that a contact feels, kg/m: 1 / (1/m_1 + 1/m_2 + b^2/I + ...), of these inverse parts (1/kg)."""
    return 1.0 / sum(inverse)


def tipping_speed(height: float, gravity: float) -> float:
    """Speed of the upper end of a thin upright rod where it meets the ground, m/s: sqrt(3 g h).

    The foot stays where it is: M g h/2 becomes I w^2/2 with I = M h^2/3, and the end has w h. A block of the width b
    has sqrt(3 g (d - b)), d its diagonal, from the balance on a corner, which is less.

    Parameters
    ----------
    height : float
        m.
    gravity : float
        m/s^2.
    """
    return sqrt(3.0 * gravity * height)


def pendulum_period(mass: float, inertia: float, distance: float, gravity: float, amplitude: float) -> float:
    """Period of a compound pendulum, s: 2 pi sqrt(I_h/(M g l)) (1 + a^2/16).

    Parameters
    ----------
    mass, inertia : float
        kg/m; kg m about the hinge.
    distance : float
        From the hinge to the centre of mass, m.
    gravity : float
        m/s^2.
    amplitude : float
        rad; the next term of the series is 11 a^4/3072.
    """
    return 2.0 * pi * sqrt(inertia / (mass * gravity * distance)) * (1.0 + amplitude**2 / 16.0)


def area_below(corners: np.ndarray, level: float) -> float:
    """Area of a polygon below a height y, m^2; either way round.

    Parameters
    ----------
    corners : ndarray, shape (n, 2), m
    level : float, m
    """
    kept: list[np.ndarray] = []
    for here, after in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if here[1] <= level:
            kept.append(here)
        if (here[1] - level) * (after[1] - level) < 0:
            kept.append(here + (level - here[1]) / (after[1] - here[1]) * (after - here))
    return section_of_polygon(np.array(kept)).area if len(kept) > 2 and np.ptp(np.array(kept)[:, 1]) > 0 else 0.0


def depth_of_area(corners: np.ndarray, area: float) -> float:
    """Height over the lowest corner below which a polygon has this area, m; NaN where it has less in all."""
    low, high = float(corners[:, 1].min()), float(corners[:, 1].max())
    if not 0 < area <= section_of_polygon(corners).area:
        return nan
    from scipy.optimize import brentq  # 0.23 s

    return float(brentq(lambda level: area_below(corners, level) - area, low, high)) - low


def along_and_up(force: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of forces along a base and up from it, N/m, shape (n,): Q t and Q n.

    Parameters
    ----------
    force : ndarray, shape (n, 2), N/m
    along : ndarray, shape (n, 2)
        Unit vectors along the base.
    """
    return np.sum(force * along, axis=1), force[:, 1] * along[:, 0] - force[:, 0] * along[:, 1]


def sliding_limit(friction: float, pressed: np.ndarray) -> np.ndarray:
    """Largest force along the base that its friction bears, N/m: mu N, and 0 where nothing presses (Coulomb).

    Parameters
    ----------
    friction : float
        Coefficient of friction of the base.
    pressed : ndarray, N/m
        Force down on the base: the part of the weight across it, less the uplift.
    """
    return friction * np.maximum(pressed, 0.0)


def moment_about(moment: np.ndarray, arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moment about another point, anticlockwise, N m/m: M + (r - r') x F.

    Parameters
    ----------
    moment : ndarray, shape (n,), N m/m
        About the first point r.
    arm : ndarray, shape (n, 2), m
        r - r'.
    force : ndarray, shape (n, 2), N/m
    """
    return moment + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]


def factor(bears: np.ndarray, drives: np.ndarray) -> np.ndarray:
    """Factor of safety: what is borne over what drives; infinite where nothing drives.

    Parameters
    ----------
    bears, drives : ndarray of one shape and unit
    """
    pushed = drives > 0
    return np.where(pushed, bears / np.where(pushed, drives, 1.0), np.inf)


def eccentricity(moment: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """Distance from the middle of a base to where the force goes through it, m, towards its right end: -M/N.

    NaN where nothing presses.

    Parameters
    ----------
    moment : ndarray, N m/m
        Of all forces about the middle, anticlockwise.
    pressed : ndarray, N/m
    """
    presses = pressed > 0
    return np.where(presses, -moment / np.where(presses, pressed, 1.0), np.nan)


def bearing_pressures(pressed: np.ndarray, off: np.ndarray, base: float) -> tuple[np.ndarray, np.ndarray]:
    """Pressure at the end that the force leans to, and at the other one, Pa: straight between them.

    ``N/b (1 +- 6 e/b)`` where the force is in the middle third. Beyond it the base gapes, as it bears no tension:
    ``2 N/(3 (b/2 - e))`` and 0. NaN where the force is outside the base: nothing balances it.

    Parameters
    ----------
    pressed : ndarray, N/m
    off : ndarray, m
        `eccentricity`.
    base : float
        Width of the base, m.
    """
    e = np.abs(off)
    inside, third = e < 0.5 * base, e <= base / 6.0
    left = np.where(inside, 0.5 * base - e, 1.0)
    toe = np.where(third, pressed / base * (1.0 + 6.0 * e / base), 2.0 * pressed / (3.0 * left))
    heel = np.where(third, pressed / base * (1.0 - 6.0 * e / base), 0.0)
    return np.where(inside, toe, np.nan), np.where(inside, heel, np.nan)
