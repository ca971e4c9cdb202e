# SPDX-License-Identifier: GPL-2.0-or-later
"""Moving shocks, dam breaks and loads on walls: closed forms that runs are compared with.

Pure functions, one equation each; SI, per metre of width.
"""

from __future__ import annotations

from math import sqrt

GRAVITY = 9.81
"""m/s^2, where a caller has no case at hand."""


# --- moving shocks ----------------------------------------------------------------------------------------------


def relative_froude(velocity: float, depth: float, shock_speed: float, gravity: float = GRAVITY) -> float:
    """Froude number in the frame of a shock, (u - c) / sqrt(g s); s the mass depth, c the shock's velocity (m/s)."""
    return (velocity - shock_speed) / sqrt(gravity * depth)


def shock_speed_from_mass(depth_1: float, velocity_1: float, depth_2: float, velocity_2: float) -> float:
    """Velocity of a shock between two states, m/s: c = (s2 u2 - s1 u1) / (s2 - s1) (conservation of mass)."""
    return (depth_2 * velocity_2 - depth_1 * velocity_1) / (depth_2 - depth_1)


def reflected_bore(depth: float, velocity: float, gravity: float = GRAVITY) -> tuple[float, float]:
    """Bore thrown back by a wall that stops the flow: (depth at the wall in m, bore velocity in m/s, negative).

    Mass ``c = -s1 u1 / (s2 - s1)`` and momentum ``2 s1 s2 u1^2 = g (s1 + s2)(s2 - s1)^2``, solved by Brent's method.
    """
    from scipy.optimize import brentq  # 0.23 s

    def excess(s2: float) -> float:
        return gravity * (depth + s2) * (s2 - depth) ** 2 - 2.0 * depth * s2 * velocity**2

    high = 2.0 * depth
    while excess(high) < 0:
        high *= 2.0
    depth_2 = brentq(excess, depth, high, xtol=1e-300, rtol=1e-15)
    return depth_2, -depth * velocity / (depth_2 - depth)


# --- dam break --------------------------------------------------------------------------------------------------


def ritter_front(t: float, depth_0: float, gravity: float = GRAVITY) -> float:
    """Front of the dam break on a dry bed, m from the dam: 2 t sqrt(g h0) (Ritter 1892)."""
    return 2.0 * t * sqrt(gravity * depth_0)


def ritter_wall_time(reservoir_length: float, depth_0: float, gravity: float = GRAVITY) -> float:
    """Time when the rarefaction meets the back wall and Ritter ends to hold there, s: L0 / sqrt(g h0)."""
    return reservoir_length / sqrt(gravity * depth_0)


# --- loads on walls ---------------------------------------------------------------------------------------------


def hydrostatic_force(depth: float, density: float, gravity: float = GRAVITY, above: float = 0.0) -> float:
    """Force of water at rest on a vertical wall, N/m: rho g (H^2 - a^2) / 2; a is the depth of the wall's top, m."""
    return 0.5 * density * gravity * (depth**2 - above**2)
