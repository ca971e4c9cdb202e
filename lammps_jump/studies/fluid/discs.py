# SPDX-License-Identifier: GPL-2.0-or-later
"""The discs of a case, without the flow they are in, and the friction law that is fitted to them.

I = rate d sqrt(rho/p) is the inertial number (GDR MiDi 2004), mu the shear stress over the pressure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.packing import disc_sizes
from lammps_jump.case.to_scene import TOUCH_STEPS, contact_of
from lammps_jump.physics.contact import Coefficients, derive
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.sizes import Sizes


@dataclass(frozen=True)
class FluidDiscs:
    """Discs of a case, without the flow they are in.

    Attributes
    ----------
    diameter, density : float
        m, kg/m^3.
    sizes : Sizes or None
        None: equal discs.
    coefficients : Coefficients
        For LAMMPS' order of operations.
    law : mapping of str to object
        What else a `Scene` has of the law, by its fields (`Contact.law_fields`).
    slip_speed : float
        m/s: eps of the thesis' sign law, 0.01 of the case's impact speed.
    impact_speed : float
        v0 of thesis (3.20), m/s.
    """

    diameter: float
    density: float
    sizes: Sizes | None
    coefficients: Coefficients
    law: Mapping[str, Any]
    slip_speed: float
    impact_speed: float

    @property
    def root_time(self) -> float:
        """Unit of time of a contact, sqrt(m/k), s."""
        return sqrt(self.coefficients.mass / self.coefficients.stiffness)

    @property
    def signal_speed(self) -> float:
        """Speed along a row of touching discs, d sqrt(k/m) = n v0, m/s."""
        return self.diameter / self.root_time

    @property
    def scene(self) -> Scene:
        """A scene without discs, in which such ones would be."""
        diameter, nothing = self.diameter, np.zeros((0, 2))
        return Scene(
            name="discs", description="", diameter=diameter, density=self.density, gravity=(0.0, 0.0),
            coefficients=self.coefficients, **self.law, integrator="velocity_verlet",
            domain=((0.0, diameter), (0.0, diameter)), positions=nothing, velocities=nothing, walls=(),
            sizes=self.sizes, overlap_limit=diameter,
        )  # fmt: skip

    def radii(self, count: int) -> np.ndarray:
        """Radii of a number of discs, m."""
        if self.sizes is None:
            return np.full(count, 0.5 * self.diameter)
        return 0.5 * self.sizes.diameters(np.arange(1, count + 1))


def discs_of(case: ReadCase) -> FluidDiscs:
    """The discs of a case; its step is the case's share of 2/omega."""
    fields = case.fields
    law, sizes = fields.contact, disc_sizes(fields)
    stated = contact_of(fields, "velocity_verlet", sizes)
    coefficients, impact_speed = derive(stated), stated.impact_speed
    width, weight = TOUCH_STEPS * impact_speed * coefficients.time_step, coefficients.mass * fields.gravity
    return FluidDiscs(
        diameter=fields.discs.diameter,
        density=fields.discs.density,
        sizes=sizes and replace(sizes, seed=1),
        coefficients=coefficients,
        law=law.law_fields(rubs=law.friction > 0, width=width, weight=weight),
        slip_speed=(FRICTION_LAWS[law.friction_law].ramp or 0.0) * impact_speed,
        impact_speed=impact_speed,
    )


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
