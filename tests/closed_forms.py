# SPDX-License-Identifier: GPL-2.0-or-later
"""Closed forms that tests compare engines with, and that the program itself does not need."""

from __future__ import annotations

from lammps_jump.physics.contact import clipped_restitution, damping_ratio


def friction_impulse_factor(restitution: float) -> float:
    """Ratio of int |F_n| dt to m_eff (1+e) v0 with the tensile tail kept: (1 + 2 e_clip - e) / (1 + e)."""
    return (1.0 + 2.0 * clipped_restitution(damping_ratio(restitution)) - restitution) / (1.0 + restitution)
