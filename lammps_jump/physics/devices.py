# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves of a paddle, discs through a slot, a drum that turns, a column that falls: laws that runs are compared with.

Pure functions, one equation each; SI, per metre of width.
"""

from __future__ import annotations

from math import cosh, nan, pi, radians, sin, sinh, sqrt, tanh

BEVERLOO_K = 1.4
"""Diameters by which a slot is narrower for discs than it is (Beverloo, Leniger & van de Velde 1961)."""
BEVERLOO_FROM = 6.0
"""Narrowest slot in diameters for which the law is asked: below it discs form arches that stop the flow
(Mankoc et al. 2007, arXiv 0707.4550; validation/silo)."""


def wave_number(period: float, depth: float, gravity: float) -> float:
    """Wave number k of small waves, 1/m: w^2 = g k tanh(k h), w = 2 pi / period (Airy), by Newton's method."""
    w2 = (2.0 * pi / period) ** 2
    k = max(w2 / gravity, sqrt(w2 / (gravity * depth)))
    for _ in range(50):
        t = tanh(k * depth)
        off = gravity * k * t - w2
        k -= off / (gravity * (t + k * depth * (1.0 - t * t)))
    return k


def piston_wave_height(stroke: float, period: float, depth: float, gravity: float) -> float:
    """Height of the small waves of a piston paddle, m: S 2 (cosh 2kh - 1) / (sinh 2kh + 2kh); S its whole stroke, m.

    Ursell, Dean & Yu 1960, J. Fluid Mech. 7:33.
    """
    twice = 2.0 * wave_number(period, depth, gravity) * depth
    if twice > 100.0:
        return 2.0 * stroke
    return stroke * 2.0 * (cosh(twice) - 1.0) / (sinh(twice) + twice)


def beverloo_number(discharge: float, slot: float, diameter: float, density: float, gravity: float) -> float:
    """Discharge W (kg/s per m) through a slot D (m) over density sqrt(g) (D - k d)^1.5, k = `BEVERLOO_K`.

    The law of Beverloo, Leniger & van de Velde 1961 in two dimensions says that it does not depend on the slot.
    """
    return discharge / (density * sqrt(gravity) * (slot - BEVERLOO_K * diameter) ** 1.5)


def rotation_froude(rate: float, radius: float, gravity: float) -> float:
    """Froude number of a drum, w^2 R / g; rate w in rad/s. Discs roll down steadily from about 1e-4 to 1e-1."""
    return rate * rate * radius / gravity


def run_out_of_sand(aspect: float) -> float:
    """Run-out of a column of sand over its base, (L - L0)/L0: 1.2 a up to a = H0/L0 = 2.3, 1.9 a^(2/3) from 2.8 on.

    Lube, Huppert, Sparks & Freundt 2005, experiments in a channel, as quoted by Staron & Hinch (physics/0501022). NaN
    between the two.
    """
    if aspect < 2.3:
        return 1.2 * aspect
    return 1.9 * aspect ** (2.0 / 3.0) if aspect > 2.8 else nan


def run_out_of_discs(aspect: float) -> float:
    """Run-out of a low column of discs over its base: 2.5 a; NaN from a = 2 on.

    Staron & Hinch 2005, J. Fluid Mech. 545:1, contact dynamics in two dimensions, as quoted by others.
    """
    return 2.5 * aspect if aspect < 2.0 else nan


def run_out_of_rods(aspect: float) -> float:
    """Run-out of a column of aluminium rods over its base: 3.25 a^0.96 for 0.65 < a < 1.5, 3.80 a^0.73 above.

    "Failure mechanism of true 2D granular flows", arXiv 1512.05180; NaN below.
    """
    if aspect <= 0.65:
        return nan
    return 3.25 * aspect**0.96 if aspect < 1.5 else 3.80 * aspect**0.73


def height_of_rods(aspect: float) -> float:
    """Height of such rods at rest over the base of their column: H0/h = 1.42 a^(2/3), h = H0 below a = 0.65.

    The same source.
    """
    return aspect if aspect < 0.65 else aspect / (1.42 * aspect ** (2.0 / 3.0))


def creep_speed(gravity: float, slope: float, damping: float) -> float:
    """Speed at which a contact without a tangential spring creeps down a slope, m/s: g sin(theta) / gamma_t.

    Weight along the slope (degrees) in balance with the dashpot gamma_t (1/s) below sliding.
    """
    return gravity * sin(radians(slope)) / damping if damping > 0 else nan
