# SPDX-License-Identifier: GPL-2.0-or-later
"""Store of what has been measured of discs, by their key in the cache, and the numbers of a flow that follow."""

from __future__ import annotations

from contextlib import suppress
from math import sqrt
from pathlib import Path
from typing import Any

from lammps_jump.case import ReadCase
from lammps_jump.compiling.cache import usual_folder
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import plain, read_json
from lammps_jump.foreign import foreign
from lammps_jump.identity import DEFAULTS_SINCE_V1, short_hash

from .discs import FluidDiscs, Friction, discs_of, viscosity
from .flow import FlowScales, flow_of

METHOD = 1
"""Of the measurement; another number measures again what is stored."""
SLOSH_DEPTHS = 20.0
"""Largest depth of the box that sloshes, diameters."""
Numbers = dict[str, Any]


def measured_key(discs: FluidDiscs, flow: FlowScales) -> str:
    """Key of what is measured: the discs, and pressure and depth in three digits."""
    scales = [f"{value:z.3g}" for value in (flow.pressure(discs.density), slosh_depth(discs, flow), flow.gravity)]
    numbers = plain(discs)
    numbers |= {
        name: value
        for name, value in numbers.pop("law").items()
        if name not in DEFAULTS_SINCE_V1 or value != DEFAULTS_SINCE_V1[name]
    }
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
        found = read_json(store_of(measured_key(discs, flow)))["summary"]
        return numbers_at(found, discs, flow)
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
