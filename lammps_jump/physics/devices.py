# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves of a paddle, discs through a slot, a drum that turns: closed forms that runs are compared with.

Pure functions, one equation each; SI, per metre of width.
"""

from __future__ import annotations

from math import cosh, pi, sinh, sqrt, tanh

BEVERLOO_K = 1.4
"""Diameters by which a slot is narrower for discs than it is (Beverloo, Leniger & van de Velde 1961)."""


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
