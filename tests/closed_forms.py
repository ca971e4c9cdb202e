# SPDX-License-Identifier: GPL-2.0-or-later
"""Closed forms that tests compare engines with, and that the program itself does not need."""

from __future__ import annotations

from math import atan2, exp, log, pi, sqrt

from lammps_jump.physics.contact import damping_ratio


def clipped_restitution(xi: float) -> float:
    """Restitution where the contact ends at zero force (no tensile tail) instead of zero overlap.

    Schwager & Poeschel 2007 (cond-mat/0701278); xi is the damping ratio, below or above 1.
    """
    if xi < 1.0:
        s = sqrt(1.0 - xi**2)
        return exp(-(xi / s) * (pi - atan2(2 * xi * s, 1 - 2 * xi**2)))
    s = sqrt(xi**2 - 1.0)
    return exp(-(xi / s) * log((xi + s) / (xi - s))) if s > 0 else exp(-2.0)


def friction_impulse_factor(restitution: float) -> float:
    """Ratio of int |F_n| dt to m_eff (1+e) v0 with the tensile tail kept: (1 + 2 e_clip - e) / (1 + e)."""
    return (1.0 + 2.0 * clipped_restitution(damping_ratio(restitution)) - restitution) / (1.0 + restitution)
