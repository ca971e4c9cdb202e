# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth and speed of the flow of a case, from which its Reynolds, Mach, Froude and inertial number follow."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.fields import Column
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.errors import CaseError
from lammps_jump.physics import jump


@dataclass(frozen=True)
class Flow:
    """Scales of a flow.

    Attributes
    ----------
    depth : float
        h, m: behind a jump, of a stream without one, or of the highest column at the start.
    speed : float
        U, m/s: of the stream, or sqrt(g h).
    discharge : float
        m^2/s: of the inflow, or U h.
    thinnest : float
        m: depth of the stream, or h.
    gravity : float
        m/s^2.
    """

    depth: float
    speed: float
    discharge: float
    thinnest: float
    gravity: float

    def pressure(self, density: float) -> float:
        """Pressure at the depth, rho g h, Pa."""
        return density * self.gravity * self.depth

    @property
    def rate(self) -> float:
        """Rate of shear, U/h, 1/s."""
        return self.speed / self.depth

    @property
    def froude(self) -> float:
        """Froude number U/sqrt(g h) where the flow is thinnest."""
        return self.speed / sqrt(self.gravity * self.thinnest)


def flow_of(case: ReadCase, *, depth: float | None = None, speed: float | None = None) -> Flow:
    """Scales of the flow of a case; a depth (m) and a speed (m/s) that are given take the place of its own.

    Raises
    ------
    CaseError
        No gravity, or no depth.
    """
    fields, g = case.fields, case.fields.gravity
    if not g:
        raise CaseError("fluid: gravity is 0, so that no depth presses the discs; give a case with gravity")
    thinnest = own_speed = None
    if isinstance(fields.inflow, RowsInflow):
        thinnest, own_speed = fields.inflow.over(0.0, fields.run.duration)
    if thinnest and own_speed:
        own = jump.sequent_depth(own_speed, thinnest, g) if own_speed > sqrt(g * thinnest) else thinnest
    else:
        own = _height(case)
    h = depth or own
    if not h:
        raise CaseError("fluid: the case has no inflow and no column, so that its depth is not known; give --depth")
    u = speed or own_speed or sqrt(g * h)
    return Flow(h, u, u * (thinnest or h), thinnest or h, g)


def _height(case: ReadCase) -> float:
    """Height of the highest column, or of all discs at the start, m; 0 where there are none."""
    columns = [item.y[1] - item.y[0] for item in case.fields.initial if isinstance(item, Column)]
    if columns:
        return max(columns)
    scene = case.scene()
    y = scene.positions[:, 1]
    if scene.fixed is not None:
        y = y[~scene.fixed.holds(np.arange(1, y.size + 1))]
    return float(y.max() - y.min()) + scene.diameter if y.size else 0.0
