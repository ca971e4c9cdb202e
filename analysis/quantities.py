# SPDX-License-Identifier: GPL-2.0-or-later
"""The list of analyses: the module of each, and the fields and options that choose it.

What is needed before an analysis is loaded is here, because cases and commands load none. All else is given by the
`QUANTITY` of its file (`quantity.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from lammps_jump.files import PICTURES, RESULT_FILES

if TYPE_CHECKING:
    from .quantity import Quantity


class ListedAnalysis(NamedTuple):
    """Facts of an analysis before its module is loaded.

    Attributes
    ----------
    file : str
        Its module.
    asks : str
        What its field of ``analysis`` in a case means; empty where a case cannot ask for it.
    contacts : bool
        It needs the forces of contacts.
    look : str
        Help of the option of ``analyze`` that looks for it in a bare dump; empty where there is none.
    option : str
        That option, where it has another name.
    bare : bool
        It is looked for in a bare dump where no option names anything.
    needs : mapping of str to str
        What a scene must have, by the names of `lammps_jump.case.doubts.facts`, and what follows where it
        lacks that; ``check`` says so.
    makes : tuple of str
        Names of its tables, and those of its figures without an ending; ``*`` means its own.
    """

    file: str
    asks: str = ""
    look: str = ""
    option: str = ""
    contacts: bool = False
    bare: bool = False
    needs: Mapping[str, str] = MappingProxyType({})
    makes: tuple[str, ...] = ("*.csv", "*")


LISTED = {
    "inflow": ListedAnalysis("lammps_jump.analysis.budgets.inflow", makes=()),
    "jump": ListedAnalysis(
        "lammps_jump.analysis.jump.section",
        "hydraulic jump",
        "Find a hydraulic jump",
        contacts=True,
        bare=True,
        needs={"gravity": "", "rows": ", so that no jump can stand"},
        makes=(
            *("jump_track.csv", "jump_frame.csv", "jump_stream.csv"),
            *("jump_track", "jump_stream", "jump_frame", "jump_balance"),
        ),
    ),
    "grade": ListedAnalysis("lammps_jump.analysis.budgets.grade", makes=("*.csv", "energy_head")),
    "front": ListedAnalysis(
        "lammps_jump.analysis.devices.front",
        "front of a collapsing column. `water`: also against water, Ritter and the columns of Martin & Moyce",
        "Follow the front",
        bare=True,
        needs={"gravity": "", "column": ", so that none collapses"},
        makes=("*.csv", "*", "martin_moyce"),
    ),
    "force": ListedAnalysis(
        "lammps_jump.analysis.forces.figures", makes=("reflected_wave.csv", "forces", "impulse", "reflected_wave")
    ),
    "pressure": ListedAnalysis("lammps_jump.analysis.forces.pressure", makes=("*.nc", "*", "pressure_gauges")),
    "energy": ListedAnalysis("lammps_jump.analysis.budgets.energy", "energy against time", contacts=True),
    "waves": ListedAnalysis("lammps_jump.analysis.devices.waves", makes=("gauges.csv", "gauges")),
    "runup": ListedAnalysis("lammps_jump.analysis.devices.runup"),
    "drum": ListedAnalysis(
        "lammps_jump.analysis.devices.drum",
        "angle of the surface in a drum that turns",
        needs={"turning wall": ", so that there is no drum"},
    ),
    "hopper": ListedAnalysis(
        "lammps_jump.analysis.devices.hopper",
        "discharge of a hopper",
        "Measure a discharge",
        "outlet",
        needs={"gravity": "", "gap": ""},
    ),
    "layers": ListedAnalysis(
        "lammps_jump.analysis.grains.layers",
        "profiles over y: velocity, solid fraction, temperature, stress, inertial number. `true`: in the middle half "
        "of the channel, layers of two diameters. `{x: [10, 20], height: 0.4}`: in this stretch, with layers of this "
        "height (m); either may be left out",
        "Profiles over the height",
        contacts=True,
    ),
    "heap": ListedAnalysis(
        "lammps_jump.analysis.grains.heap",
        "shape of the discs at the end, slopes of its flanks, run-out of a column",
        "Measure the heap at the end",
        needs={"gravity": "", "friction": " discs make no heap"},
    ),
    "rest": ListedAnalysis("lammps_jump.analysis.grains.rest", "when the discs come to rest", "Tell when discs rest"),
    "sizes": ListedAnalysis("lammps_jump.analysis.grains.sizes"),
    "tailgate": ListedAnalysis("lammps_jump.analysis.devices.tailgate"),
    "bodies": ListedAnalysis("lammps_jump.analysis.devices.bodies", makes=("*",)),
    "stability": ListedAnalysis("lammps_jump.analysis.devices.stability"),
    "overtopping": ListedAnalysis(
        "lammps_jump.analysis.devices.overtopping",
        "what goes over bodies and probed walls: volume, discharge, depth and head",
        needs={"gravity": ""},
    ),
    "depth": ListedAnalysis("lammps_jump.analysis.budgets.depths", makes=()),
    "state": ListedAnalysis("lammps_jump.analysis.grains.state", makes=()),
}
"""By the key in ``summary.json``, in the order of the report."""


class ListedQuantities(Mapping[str, "Quantity"]):
    """The analyses by their names, in the order of the report; each is loaded when it is needed."""

    def __getitem__(self, name: str) -> Quantity:
        quantity: Quantity = import_module(LISTED[name].file).QUANTITY
        return quantity

    def __contains__(self, name: object) -> bool:
        return name in LISTED

    def __iter__(self) -> Iterator[str]:
        return iter(LISTED)

    def __len__(self) -> int:
        return len(LISTED)


QUANTITIES = ListedQuantities()
"""By the key in ``summary.json``."""
FIRST = {
    "depth_profile": "Depth and velocity along the channel, mean of the window",
    "depth_map": "Depth of the free surface over distance and time",
}
"""Figures that every flow has, with their captions; they come before those of the analyses."""
LAST = {
    "snapshots": "Ten equal times, discs coloured by speed",
    "field_density": "Density of the flow",
    "field_pressure": "Pressure",
    "bed_pressure": "Pressure at the bed against the weight above",
}
"""The discs, and what fields show; after them."""


def captions() -> dict[str, str]:
    """Captions of all figures by their names, in the order of the report."""
    own = (quantity.captions for quantity in QUANTITIES.values())
    return {**FIRST, **{name: text for some in own for name, text in some.items()}, **LAST}


def tables() -> dict[str, str]:
    """Content of each CSV table of an analysis, by the name of its file."""
    return {name: text for quantity in QUANTITIES.values() for name, text in quantity.files.items()}


def result_files() -> tuple[str, ...]:
    """Names and patterns of all that analyses make in a run folder, ``force_<structure>.csv`` of each probe besides."""
    makes = [made.replace("*", name) for name, one in LISTED.items() for made in one.makes]
    figures = (*FIRST, *(made for made in makes if "." not in made), *LAST)
    pictures = (f"figures/{name}.{ending}" for name in figures for ending in PICTURES)
    return (*RESULT_FILES, *(made for made in makes if "." in made), *pictures)
