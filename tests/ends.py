# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases at the ends of what a case file allows: bounds of fields, one or none of a thing, nothing asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from features import BED, BELT, BOX, CHANNEL, COLUMN, CONTACT, FLOOR, JET, JETS, LID, PADDLE, POUR, SIDE, SIZES
from pydantic import BaseModel

from lammps_jump.case.contact import Contact, RollingResistance
from lammps_jump.case.discs import UniformSizes

LAWS = ("viscous", "sign", "history")
SCALES = {"largest_overlap", "impact_speed", "stiffness", "stiffness_wall", "touch_width", "tangential_damping"}
"""Fields with a unit, or that choose one: their ends are other scenes, of other steps."""
SHORT = {
    "run.duration": 0.06, "run.output_interval": 0.01, "run.integrator": "velocity_verlet", "run.allow_unstable": True,
    "initial.0.origin": [0.2, 0.055],
}  # fmt: skip
"""Engines differ by round-off that collisions amplify: so a few of them, with one integrator."""
FRICTION = {"viscous": 0.3, "sign": 0.03, "history": 0.3}
"""More of `sign` than this turns the slip round every step, which amplifies round-off to 1e-3 d at once."""


def bounds(model: type[BaseModel]) -> Iterator[tuple[str, Any]]:
    """Each field of a model with each bound that it may take."""
    for name, field in model.model_fields.items():
        for bound in field.metadata:
            for value in (getattr(bound, "ge", None), getattr(bound, "le", None)):
                if value is not None and name not in SCALES:
                    yield name, value


def _generated() -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {
        f"contact.{name}={value:g}": {f"contact.{name}": value} for name, value in bounds(Contact)
    }
    for name, value in bounds(RollingResistance):
        found[f"contact.rolling.{name}={value:g}"] = {"contact.rolling": {"friction": 0.1, name: value}}
    for name, value in bounds(UniformSizes):
        found[f"discs.sizes.{name}={value:g}"] = {
            "discs.sizes": {"kind": "uniform", name: value},
            "initial": [{"kind": "lattice", "nx": 5, "ny": 4, "spacing": 0.16, "origin": [0.2, 0.08],
                         "velocity": [0.5, -0.5]}],
        }  # fmt: skip
    return found


def _disc(x: float, y: float, *velocity: float) -> dict[str, Any]:
    return {"initial": [{"kind": "list", "positions": [[x, y]], "velocities": [list(velocity or (0, 0))]}]}


def _moving(wall: dict, **motion) -> dict[str, Any]:
    return {"walls": [{**wall, "motion": motion}]}


NO_FRICTION = {"contact.friction": 0}
JETS_SHORT = {**{name: value for name, value in JETS.items() if name != "run"}, "run.duration": 0.3}
PILE_LID = {**LID, "y": [0.45, 0.5]}


def _loaded(mass: float, *force: float) -> dict[str, Any]:
    motion = {"kind": "load", "mass": mass, "force": list(force)}
    return {"walls": [BOX, {**PILE_LID, "motion": motion}], "probes": {"forces": ["lid"]}, "run.duration": 0.1}


ENDS: dict[str, dict[str, Any]] = {
    **_generated(),
    "restitution 1, several sizes": {"contact.restitution": 1, "discs": SIZES},
    "restitution 1, no friction, several sizes": {"contact.restitution": 1, "discs": SIZES, **NO_FRICTION},
    "restitution 1, rolling": {"contact.restitution": 1, "contact.rolling": {"friction": 0.1}},
    "no spring and no dashpot": {"contact.tangential_ratio": 0, "contact.tangential_damping_ratio": 0},
    "walls without friction": {"walls.box.friction": 0},
    "walls without friction, rolling": {"walls.box.friction": 0, "contact.rolling": {"friction": 0.1}},
    "walls without rolling friction": {"walls.box.rolling": 0, "contact.rolling": {"friction": 0.1}},
    "friction at walls alone": {"walls.box.friction": 0.03, **NO_FRICTION},
    "walls of restitution 1": {"walls.box.restitution": 1},
    "no spin": {"contact.rotation": False},
    "smooth touch": {"contact.touch": "smooth"},
    "smooth touch, no friction": {"contact.touch": "smooth", **NO_FRICTION},
    "no correction": {"contact.correct_restitution": False},
    "no gravity": {"gravity": 0},
    "no gravity, no friction": {"gravity": 0, **NO_FRICTION},
    "slope 89": {"slope": 89},
    "seed 0": {"run.seed": 0},
    "one size of a list": {"discs.sizes": {"kind": "list", "diameters": [0.08], "shares": [1]}},
    "one disc": _disc(0.3, 0.05, 1, 0),
    "one disc without a contact": _disc(0.3, 0.5),
    "one disc without walls and gravity": {**_disc(0.3, 0.5), "walls": [], "probes": {}, "gravity": 0},
    "no disc": {"initial": []},
    "no wall": {"walls": [], "probes": {}},
    "no probe": {"probes": {}},
    "one frame": {"run.output_interval": 0.06},
    "frames further apart than the run is long": {"run.output_interval": 1},
    "one step": {"run.duration": 1e-5, "run.output_interval": 1e-5},
    "one window of the probes": {"probes.interval": 1},
    "a window a step": {"probes.interval": 1e-9},
    "one fixed disc": {"walls": [{**BED, "from": [0.5, 0], "to": [0.55, 0]}], "probes": {}, **_disc(0.52, 0.098)},
    "fixed discs alone": {"walls": [BED], "probes": {}, "initial": []},
    "a rough bed without friction": {"walls": [BED, BOX], "initial.0.origin": [0.2, 0.11], **NO_FRICTION},
    "velocity 0": _moving(FLOOR, kind="translate", velocity=[0, 0]),
    "rate 0": _moving(FLOOR, kind="rotate", rate=0),
    "amplitude 0": _moving(FLOOR, kind="oscillate", period=0.1),
    "a table of one row": _moving(FLOOR, kind="table", points=[[0, 0, 0, 0]]),
    "a sudden belt": _moving(FLOOR, kind="translate", velocity=[1, 0], ease=0),
    "a belt without friction": {"walls": [BELT], **NO_FRICTION},
    "a paddle that stands": {"walls": [FLOOR, {**PADDLE, "motion": {"kind": "rotate", "rate": 0}}]},
    "a lid without force": _loaded(50, 0, 0),
    "a lid without friction": {**_loaded(50, 0, -2000), **NO_FRICTION},
    "a light lid": _loaded(1e-3, 0, -0.1),
    "a heavy lid": _loaded(1e15, 0, 0),
    "a lid, contacts asked for": {**_loaded(50, 0, -2000), "analysis.layers": True},
    "contacts asked for, no friction": {"analysis.layers": True, **NO_FRICTION},
    "no discs yet, contacts asked for": {**JETS_SHORT, "run.duration": 0.01, "analysis.layers": True},
    "a pour of one disc": {"initial": [], "inflow": {**POUR, "count": 1}},
    "a pour without friction": {"initial": [], "inflow": POUR, **NO_FRICTION},
    "inflow without friction": {**JETS_SHORT, **NO_FRICTION},
    "inflow of one row": {**JETS_SHORT, "inflow": {**JET, "depth": 0.1}},
    "inflow of no row": {**JETS_SHORT, "inflow": {**JET, "depth": 0.05}},
    "inflow far apart": {**JETS_SHORT, "inflow": {**JET, "spacing": 5}},
    "inflow open at the back": {**JETS_SHORT, "inflow": {**JET, "back": "open"}},
    "inflow against time that is steady": {**JETS_SHORT, "inflow": {"kind": "rows", "table": [[0, 0.3, 4]]}},
    "a channel without ends and friction": {
        "domain": CHANNEL, "slope": 20, "walls": [{**SIDE, "name": "box", "axis": "y"}], **NO_FRICTION,
    },
    "a gate without friction": {"walls": [FLOOR, SIDE], "initial": [{**COLUMN, "settle": 0.02}], **NO_FRICTION},
    "a column of one disc": {"walls": [FLOOR, SIDE], "initial": [{**COLUMN, "x": [0, 0.1], "y": [0, 0.1]}]},
}  # fmt: skip
"""Changes of `features.BASE` by what is at its end: whole fields, and dotted ones."""


def case_at(end: str, law: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Whole fields and dotted changes of a case at an end, with a friction law."""
    changes = {**SHORT, **ENDS[end]}
    if "initial" in changes:
        del changes["initial.0.origin"]
    contact = {**CONTACT, "friction_law": law, "friction": FRICTION[law]}
    whole = {"contact": contact, **{name: value for name, value in changes.items() if "." not in name}}
    return whole, {name: value for name, value in changes.items() if "." in name}
