# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth and speed of the flow of a case, from which its Reynolds, Mach, Froude and inertial number follow."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.discs import Column
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import SUMMARY_FILE, read_json
from lammps_jump.foreign import foreign
from lammps_jump.physics import jump


@dataclass(frozen=True)
class FlowScales:
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


def flow_of(case: ReadCase, *, depth: float | None = None, speed: float | None = None) -> FlowScales:
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
    return FlowScales(h, u, u * (thinnest or h), thinnest or h, g)


def zones_of(case: ReadCase, flow: FlowScales, folder: Path | None = None) -> dict[str, FlowScales]:
    """Scales of the stream before a jump, of its middle and of its tail, by name; none without a jump.

    The depths are those of a run of this case, y1 and y2, or the inflow's and Belanger's. The speed is q/y; the middle
    has the mean of the two depths.

    Parameters
    ----------
    folder : Path, optional
        Run folder; one of another case, or without a jump, does not count.
    """
    thin, deep, measured = flow.thinnest, flow.depth, _measured_depths(case, folder)
    if measured is not None:
        thin, deep = measured
    if deep <= thin:
        return {}
    depths = {"stream": thin, "middle of the jump": 0.5 * (thin + deep), "tail": deep}
    return {name: FlowScales(h, flow.discharge / h, flow.discharge, thin, flow.gravity) for name, h in depths.items()}


def _measured_depths(case: ReadCase, folder: Path | None) -> tuple[float, float] | None:
    """y1 and y2 of a run of the case, m."""
    with suppress(DumpError), foreign(DumpError):
        summary = read_json((folder or Path("runs") / case.name) / SUMMARY_FILE)
        if summary["case_hash"].split("-")[0] == case.hash.split("-")[0]:
            return float(summary["jump"]["y1"]), float(summary["jump"]["y2"])
    return None


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
