# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth by mass compared with that of the surface: of touching discs they are alike, whatever the discs are.

Discs in squares have the same of both, dense random ones 4 % more by mass, a crystal 15 %. Where the depth by mass is
half as much again, the diameter is too large, or discs lie behind each other. Where it is half, there is air below.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.errors import DumpError
from lammps_jump.units import known, number, shown

if TYPE_CHECKING:
    import xarray as xr

PILED = 2.0
"""Depth of the surface from which on a bin counts, in largest diameters."""
FAR = 0.5
"""Share by which the two depths may differ."""


@dataclass(frozen=True)
class Depths:
    """Depths of the window, means over the bins where discs lie two diameters deep or more."""

    mass: float = number("m", "mean depth by mass, Σ d²/L", default=nan, label="depth by mass")
    surface: float = number("m", "mean depth of the surface over the bed", default=nan, label="depth of the surface")
    ratio: float = number("", "depth by mass over that of the surface", default=nan)
    deepest: float = number("m", "largest depth of the surface", default=nan)
    length: float = number("m", "length of the bed where discs lie that deep", default=nan)
    reason: str | None = None


def depths_of(profiles: xr.Dataset, flow: Flow, largest: float) -> Depths:
    """Depths of the means of profiles; `largest` is the largest diameter, m."""
    surface, mass = (profiles[f"{name}_depth_mean"].values for name in ("surface", "mass"))
    piled = np.nan_to_num(surface) >= PILED * largest
    if not piled.any():
        return Depths(reason=f"discs lie nowhere {PILED:zg} diameters deep on the bed in the mean of the window")
    means = float(mass[piled].mean()), float(surface[piled].mean())
    length = float(piled.sum() * flow.bin_width)
    return Depths(*means, means[0] / means[1], float(surface[piled].max()), length)


def analyse(gathered: Gathered) -> Depths:
    """Depths of a flow."""
    return depths_of(gathered.profiles, gathered.flow, gathered.flow.scene.largest)


def require_agreement(gathered: Gathered) -> str:
    """A note where there is air below the surface; empty where the depths agree.

    Raises
    ------
    DumpError
        The depth by mass is too large: discs overlap, or lie behind each other.
    """
    depths, flow = analyse(gathered), gathered.flow
    if not abs(depths.ratio - 1.0) > FAR:
        return ""
    said = (
        f"the depth by mass is {shown(depths.mass)} m, that of the surface {shown(depths.surface)} m: "
        f"{shown(depths.ratio, digits=2)} times, where touching discs have 0.8 to 1.2"
    )
    if depths.ratio > 1:
        raise DumpError(
            f"{flow.scene.name}: {said}. Discs of {flow.scene.diameter:z.4g} m overlap, or lie behind each other. Give "
            "the right diameter (--diameter), or write a dump of one layer of discs."
        )
    return f"There is air below the surface: {said}. Depths by mass hold, those of the surface do not."


def section(depths: Depths) -> Section:
    """Both depths."""
    if not known(depths.mass):
        return Section("Depth", [Text(depths.reason or "", "small")])
    return Section("Depth", [Table(described(depths, "surface", "mass", "ratio", "deepest", "length"))])


QUANTITY = Quantity(
    name="depth",
    title="Depths of a foreign dump",
    result=Depths,
    definitions="""\
by mass       Σ d² of the discs over the length: as deep as the same discs would stand in squares
surface       free surface over the bed; both are means of the window, where that is two diameters or more
over          touching discs have 0.8 to 1.2; a dump beyond 1.5 is refused: its discs overlap
""",
    analyse=analyse,
    section=section,
    headline=(HeadlineNumber("mass", "surface", "surface"),),
    rank=140,
)
