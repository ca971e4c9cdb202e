# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth and speed of the flow of a case, its numbers, and the store of what has been measured of its discs."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.discs import Column
from lammps_jump.case.inflow import RowsInflow
from lammps_jump.compiling.cache import usual_folder
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import SUMMARY_FILE, plain, read_json
from lammps_jump.foreign import foreign
from lammps_jump.identity import short_hash, without_later
from lammps_jump.physics import jump
from lammps_jump.scene import Scene

from .cell import FluidDiscs, Friction, discs_of, viscosity


@dataclass(frozen=True)
class FlowScales:
    """Scales of a flow.

    Attributes
    ----------
    depth : float
        h, m: downstream of a jump, of a stream without one, or of the highest column at the start.
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


# --- store of what has been measured of discs, by their key in the cache, and the numbers of a flow that follow -------


METHOD = 1
"""Of the measurement; another number measures again what is stored."""
SLOSH_DEPTHS = 20.0
"""Largest depth of the box that sloshes, diameters."""
Numbers = dict[str, Any]


def measured_key(discs: FluidDiscs, flow: FlowScales) -> str:
    """Key of what is measured: the discs, and pressure and depth in three digits."""
    scales = [f"{value:z.3g}" for value in (flow.pressure(discs.density), slosh_depth(discs, flow), flow.gravity)]
    numbers = plain(discs)
    numbers |= without_later(Scene, numbers.pop("law"))
    return short_hash({"method": METHOD, "discs": numbers, "scales": scales})


def store_of(key: str) -> Path:
    """File of what is measured, in the cache (LAMMPS_JUMP_CACHE)."""
    return usual_folder() / "fluid" / f"{key}.json"


def slosh_depth(discs: FluidDiscs, flow: FlowScales) -> float:
    """Depth of the box that sloshes: that of the flow, at most 20 diameters, m."""
    return min(flow.depth, SLOSH_DEPTHS * discs.diameter)


def numbers_at(found: Numbers, discs: FluidDiscs, flow: FlowScales) -> Numbers:
    """Numbers of a flow of measured discs: at half its depth, p = rho g h/2, and the rate U/h.

    Re = q/nu, Ma = U/c, Fr = U/sqrt(g h1), and the swing 2.5 mu_s h below which a wave dies in one swing (measured;
    `slosh.coulomb_friction` gives (8/pi) mu h).
    """
    law = Friction(found["static"][0], found["slope"][0], found["exponent"])
    pressure, d, rho = 0.5 * flow.pressure(discs.density), discs.diameter, discs.density
    nu = viscosity(law, pressure, flow.rate, d, rho)
    inertial = flow.rate * d * sqrt(rho / pressure)
    return {
        "depth": flow.depth,
        "speed": flow.speed,
        "rate": flow.rate,
        "inertial": inertial,
        "friction": law.at(inertial),
        "viscosity": nu,
        "reynolds": flow.discharge / nu,
        "mach": flow.speed / found["sound"]["speed"][0],
        "froude": flow.froude,
        "discs_deep": flow.depth / d,
        "least_swing": 2.5 * law.at(inertial) * flow.depth,
    }


def stored(case: ReadCase) -> Numbers | None:
    """Numbers of the flow of a case (`numbers_at`) where its discs have been measured; None elsewhere."""
    with suppress(CaseError, DumpError), foreign(DumpError):
        flow, discs = flow_of(case), discs_of(case)
        summary = read_json(store_of(measured_key(discs, flow)))["summary"]
        return numbers_at(summary, discs, flow)
    return None


def flow_numbers_in_words(at: Numbers) -> str:
    """The numbers of a flow (`numbers_at`) as a group of `check`."""
    rows = [
        ("Reynolds number q/nu", at["reynolds"], ""),
        ("Mach number U/c", at["mach"], ""),
        ("viscosity nu", at["viscosity"], "m^2/s"),
        ("inertial number I", at["inertial"], ""),
    ]
    width = max(len(label) for label, _, _ in rows)
    lines = [f"  {label:<{width}}  {value:>z12.3g} {unit}".rstrip() for label, value, unit in rows]
    return "\n".join(["fluid (of its discs, measured by `lammps-jump fluid`)", *lines])
