# SPDX-License-Identifier: GPL-2.0-or-later
"""Small cases, each with one feature of a scene or two that meet; tests run every one of them on every engine."""

from __future__ import annotations

from typing import Any

ENGINES = ("native", "compiled", "stock")
CONTACT = {"restitution": 0.4, "friction": 0.3, "rotation": True, "impact_speed": 3}
SPRINGS = {**CONTACT, "friction_law": "history"}
ROLLING = {**SPRINGS, "rolling": {"friction": 0.1}}
SIZES = {"diameter": 0.1, "sizes": {"kind": "uniform", "spread": 0.2}}
HEAP = {
    "kind": "lattice", "nx": 6, "ny": 4, "spacing": 0.11, "origin": [0.2, 0.12], "jitter": 0.02,
    "velocity": [0.5, -0.5],
}  # fmt: skip
BOX = {"name": "box", "kind": "box", "x": [0, 1], "y": [0, 1.9]}
FLOOR = {"name": "box", "kind": "block", "x": [-0.4, 1.2], "y": [-0.4, 0]}
SIDE = {"name": "left", "kind": "plane", "axis": "x", "at": 0, "side": "above"}
CHANNEL = {"x": [0, 1.2], "y": [-0.5, 2], "periodic": "x"}
BED = {"name": "bed", "kind": "rough", "from": [0, 0], "to": [1.1, 0], "diameter": 0.1, "spacing": 1.2}
COLUMN = {"kind": "column", "x": [0, 0.6], "y": [0, 0.8]}
JET = {"kind": "rows", "depth": 0.3, "mean_speed": 4}
POUR = {"kind": "pour", "x": [0.1, 0.9], "y": [1.2, 1.7], "count": 60}
BASE: dict[str, Any] = {
    "name": "feature", "discs": {"diameter": 0.1}, "contact": CONTACT,
    "domain": {"x": [-0.5, 2.5], "y": [-0.5, 2]}, "walls": [BOX], "initial": [HEAP],
    "probes": {"forces": ["box"], "interval": 0.002}, "run": {"duration": 0.16, "output_interval": 0.004},
}  # fmt: skip


def _moving(wall: dict, **motion) -> dict:
    return {**wall, "motion": motion}


BELT = _moving(FLOOR, kind="translate", velocity=[1, 0])
PADDLE = {"name": "paddle", "kind": "block", "x": [0, 0.1], "y": [0.02, 1]}
LID = {"name": "lid", "kind": "block", "x": [0.02, 0.98], "y": [0.61, 0.66]}
GATE = {"name": "gate", "kind": "block", "x": [0.7, 0.8], "y": [-0.3, 0.2]}
HOLDS = {"kind": "hold", "speed": 0.5, "range": [-0.15, 0.5], "response": 0.02}
PRESSED = _moving(LID, kind="load", mass=50, force=[5, -2000], axis="both")
DRUM = {"name": "box", "kind": "circle", "centre": [0.5, 0.5], "radius": 0.6, "discs": "inside"}
BOWL = {
    "name": "box", "kind": "line",
    "points": [[-0.4, 1.5], [-0.3, 0.3], [0.1, 0.05], [0.8, 0.05], [1.3, 0.4], [1.4, 1.5]],
}  # fmt: skip
JETS = {
    "initial": [], "domain": {"x": [-1, 4], "y": [-2, 2]}, "walls": [FLOOR], "inflow": JET,
    "outflow": [{"x_beyond": 2}], "run": {"duration": 0.7, "output_interval": 0.02},
}  # fmt: skip
POURS = {"initial": [], "inflow": POUR, "run": {"duration": 0.9, "output_interval": 0.02}}

FEATURES: dict[str, dict[str, Any]] = {
    "no friction": {"contact": {**CONTACT, "friction": 0}},
    "friction `viscous`, with spin": {},
    "friction `sign`": {"contact": {**CONTACT, "friction_law": "sign"}},
    "friction `history`": {"contact": SPRINGS, "analysis": {"layers": True}},
    "rolling resistance": {"contact": ROLLING},
    "smooth touch": {"contact": {**CONTACT, "touch": "smooth"}},
    "discs of several sizes": {"discs": SIZES, "contact": SPRINGS},
    "a rough bed": {"walls": [BED, BOX], "slope": 10},
    "a rough bed, `history`": {"walls": [BED, BOX], "slope": 10, "contact": SPRINGS},
    "a rough bed beside a belt, `history`": {"walls": [BED, BELT, SIDE], "contact": ROLLING},
    "a slope without ends": {"domain": CHANNEL, "slope": 20, "walls": [{**SIDE, "name": "box", "axis": "y"}]},
    "a rough bed without ends, `history`": {
        "domain": CHANNEL, "slope": 20, "walls": [{**BED, "to": [1.19, 0]}], "contact": SPRINGS, "probes": {},
    },
    "a belt": {"walls": [BELT]},
    "a belt, `history`": {"walls": [BELT], "contact": ROLLING},
    "a drum, `history`": {"walls": [_moving(DRUM, kind="rotate", rate=90)], "contact": SPRINGS},
    "a paddle that oscillates": {
        "walls": [FLOOR, _moving(PADDLE, kind="oscillate", period=0.1, amplitude=[0.02, 0], angle=2)],
    },
    "a wall that follows a table": {
        "walls": [FLOOR, _moving(PADDLE, kind="table", points=[[0, 0, 0, 0], [0.05, 0.05, 0, 0], [0.1, 0.03, 0, 2]])],
    },
    "a lid": {"walls": [BOX, PRESSED]},
    "a lid, `history`": {"walls": [BOX, PRESSED], "contact": SPRINGS},
    "a tailgate that holds a depth": {
        "walls": [FLOOR, SIDE, _moving(GATE, **HOLDS, depth=0.5, at=0.1)], "initial": [{**COLUMN, "gate": False}],
    },
    "a tailgate that holds a front": {
        **JETS, "walls": [FLOOR, _moving({**GATE, "x": [1.22, 1.3]}, **HOLDS, front=0.8)], "discs": SIZES,
    },
    "a gate that goes": {"walls": [FLOOR, SIDE], "initial": [{**COLUMN, "settle": 0.06}]},
    "a gate that rises": {"walls": [FLOOR, SIDE], "initial": [{**COLUMN, "gate": {"open_in": 0.1}}]},
    "a line of several faces": {"walls": [BOWL], "probes": {}},
    "a line of several faces, `history`": {"walls": [BOWL], "contact": SPRINGS},
    "a wall with a contact of its own": {"walls": [{**FLOOR, "friction": 0.8, "restitution": 0.1}, SIDE]},
    "energy between stations": {"probes": {"stations": {"x": [0.2, 0.8], "speed": 0.1, "window": [0.02, 0.15]}}},
    "inflow and outflow": JETS,
    "the same, several sizes, `history`": {**JETS, "discs": SIZES, "contact": SPRINGS},
    "inflow against time": {**JETS, "inflow": {"kind": "rows", "table": [[0, 0.3, 4], [0.5, 0.4, 3]]}},
    "a pour": POURS,
    "a pour of several sizes": {**POURS, "discs": SIZES},
}  # fmt: skip
"""Cases by what they have; fields in place of those of `BASE`."""
