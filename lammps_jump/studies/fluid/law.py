# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction of sheared discs against their inertial number, and the viscosity that follows.

I = rate d sqrt(rho/p) is the inertial number (GDR MiDi 2004), mu the shear stress over the pressure.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

EXPONENTS = np.linspace(0.2, 1.2, 101)


def shear_rate(inertial: float, diameter: float, density: float, pressure: float) -> float:
    """Rate of shear of an inertial number, 1/s: I sqrt(p/rho)/d (GDR MiDi 2004)."""
    return inertial * sqrt(pressure / density) / diameter


class Friction(NamedTuple):
    """The law mu = yield + slope I^exponent (power law of the inertial number)."""

    static: float
    slope: float
    exponent: float

    def at(self, inertial: float) -> float:
        """Friction at an inertial number."""
        return self.static + self.slope * inertial**self.exponent


def fit_friction(inertial: np.ndarray, friction: np.ndarray, exponent: float | None = None) -> Friction:
    """Least squares of mu = mu_s + b I^a; the exponent too, of 0.2 to 1.2, unless it is given."""

    def fit(power: float) -> tuple[float, Friction]:
        basis = np.stack([np.ones_like(inertial), inertial**power], axis=1)
        (static, slope), *_ = np.linalg.lstsq(basis, friction, rcond=None)
        misses = basis @ (static, slope) - friction
        return float(misses @ misses), Friction(float(static), float(slope), float(power))

    return min((fit(power) for power in (EXPONENTS if exponent is None else [exponent])), key=lambda one: one[0])[1]


def viscosity(law: Friction, pressure: float, rate: float, diameter: float, density: float) -> float:
    """Kinematic viscosity, m^2/s: nu = mu(I) p/(rho rate)."""
    return law.at(rate * diameter * sqrt(density / pressure)) * pressure / (density * rate)
