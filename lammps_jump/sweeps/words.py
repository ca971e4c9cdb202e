# SPDX-License-Identifier: GPL-2.0-or-later
"""Words and units of the fields of a case that a study varies."""

from __future__ import annotations

import re

from lammps_jump.units import POWERS

FIELDS = {
    "contact.friction": ("friction coefficient", ""),
    "contact.rolling.friction": ("rolling friction coefficient", ""),
    "contact.restitution": ("restitution coefficient", ""),
    "contact.largest_overlap": ("largest overlap over diameter", ""),
    "contact.stiffness": ("stiffness", "N/m"),
    "contact.from_material.young": ("modulus of elasticity", "Pa"),
    "contact.impact_speed": ("impact speed", "m/s"),
    "discs.diameter": ("disc diameter", "m"),
    "discs.density": ("density", "kg/m^3"),
    "discs.sizes.spread": ("spread of diameters", ""),
    "gravity": ("gravity", "m/s^2"),
    "slope": ("slope", "°"),
    "inflow.depth": ("depth of the inflow", "m"),
    "inflow.mean_speed": ("speed of the inflow", "m/s"),
    "inflow.discharge": ("discharge", "m^2/s"),
    "run.duration": ("simulated time", "s"),
    "run.time_step_fraction": ("time step over 2/ω", ""),
    "run.seed": ("seed", ""),
    "analysis.bin_width": ("width of the bins", "m"),
}
"""By the path of the field."""
SIDES = {"x.0": "start", "x.1": "end", "y.0": "underside", "y.1": "height", "at": "place"}
"""Of a wall, by the rest of its path."""


def _described(path: str) -> tuple[str, str]:
    wall = re.fullmatch(r"walls\.([^.]+)\.(x\.0|x\.1|y\.0|y\.1|at)", path)
    if wall:
        name = f"wall {wall[1]}" if wall[1].isdigit() else wall[1].replace("_", " ")
        return f"{SIDES[wall[2]]} of the {name}", "m"
    return FIELDS.get(path, (path, ""))


def words(path: str) -> str:
    """What a field is, in a few words; the path where it has none."""
    return _described(path)[0]


def unit(path: str) -> str:
    """Its SI unit, empty where there is none."""
    return _described(path)[1]


def heading(path: str) -> str:
    """Words and unit, for a table or an axis."""
    return f"{words(path)} [{unit(path).translate(POWERS)}]" if unit(path) else words(path)
