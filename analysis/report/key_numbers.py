# SPDX-License-Identifier: GPL-2.0-or-later
"""The five numbers at the top of a report, each with its standard error and with what it is compared with."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from lammps_jump.analysis.budgets.inflow import Delivery
from lammps_jump.analysis.energy import Energy
from lammps_jump.analysis.forces.history import Force
from lammps_jump.analysis.front import Front, MartinMoyce
from lammps_jump.analysis.jump.summary import Jump
from lammps_jump.units import AT_LEAST, numbers_of, shown

from .headline import A_JUMP, COMPARED, against_water, belongs
from .page import Box, heading, with_error

MOST = 5
WITHIN = "± is one standard error within this run."
EXACT = ("energy", "inflow.delivered")
"""Numbers that are counted, or exact for this run."""
MORE = "†"
BOUND = "† At least: one run cannot tell."
UNSURE = "Without ±: no error from one run; repeat it from other starts."


class Wanted(NamedTuple):
    """A number of ``summary.json`` by its path, as described by `result`; compared with the number at `other`.

    Without a path to compare with, `words` stand alone; `without` stands where that number is not known. `scale` and
    `unit` replace those of the description; `beside` is the unit of the other number where it is not the same.
    """

    path: str
    result: type
    words: str = ""
    other: str = ""
    label: str = ""
    scale: float = 1.0
    unit: str | None = None
    beside: str | None = None
    without: str = ""


WETTED = "hydrostatic on its wetted face"
WATER = "front.ritter.front_speed"
PERCENT = {"scale": 0.01, "unit": "%"}
FOUND = (
    *(
        Wanted(f"jump.{row.key}", Jump, row.words.partition(",")[0], f"jump.{row.theory}")
        for row in COMPARED
        if row.theory != "length_usbr"
    ),
    Wanted("jump.froude", Jump),
    Wanted("front.position", Front, "at t =", "front.time", beside="s", without="at the last frame"),
    Wanted("front.speed", Front, "Ritter’s front, 2 √(g H)", WATER),
    Wanted("front.speed", Front),
    Wanted(
        "front.martin_moyce.mean_bulk", MartinMoyce, "discs: −20 to 0 %", label="off Martin & Moyce’s water", **PERCENT
    ),
    Wanted("force.*.mean_fx", Force, WETTED, "force.*.mean_hydrostatic", "mean force on the {name}", 1e3, "kN/m"),
    Wanted("force.*.peak", Force, WETTED, "force.*.hydrostatic", "peak force on the {name}", 1e3, "kN/m"),
    Wanted("energy.max_deviation", Energy, "exact integration: 0", label="largest change of the energy", **PERCENT),
    Wanted("energy.drift", Energy, "exact integration: 0", label="drift of the energy", **PERCENT),
    Wanted("energy.final", Energy, "at the start", "energy.initial"),
    Wanted("inflow.delivered", Delivery, "asked", "inflow.asked"),
    Wanted("inflow.froude", Delivery),
)
"""In the order of the page; those that a summary holds and that go with its verdict are shown, at most `MOST`."""


def key_numbers(summary: Mapping) -> tuple[list[Box], str]:
    """The numbers that readers look for first, and a sentence on how sure they are."""
    found = [(wanted, box) for wanted in FOUND for box in _boxes(wanted, summary)][:MOST]
    measured = [(wanted, box) for wanted, box in found if not wanted.path.startswith(EXACT)]
    errors = {bool(box.error) for _, box in measured} | {"±" in box.against for wanted, box in measured if wanted.other}
    boxes = [box for _, box in found]
    discs = summary.get("discs") or {}
    if len(boxes) < MOST and discs.get("inserted") is not None:
        boxes.append(Box("Discs", discs["inserted"], against=f"{shown(discs.get('present'))} at the end"))
    said = {WITHIN: True in errors, BOUND: any(MORE in box.error for box in boxes), UNSURE: False in errors}
    return boxes, " ".join(text for text, goes in said.items() if goes)


def _boxes(wanted: Wanted, summary: Mapping) -> Iterator[Box]:
    part, _, key = wanted.path.rpartition(".")
    steady = bool(summary.get("inflow"))
    names = [name for name, values in (summary.get("force") or {}).items() if isinstance(values, Mapping)]
    if part == "force.*" and (key == "mean_fx") != steady:  # a steady stream has a mean, an impact a peak
        return
    for name in names if "*" in part else [""]:
        found = _at(summary, part.replace("*", name))
        if isinstance(found, Mapping) and found.get(key) is not None and _goes(wanted, summary):
            other = wanted.other.replace("*", name)
            yield _box(wanted, key, found, (_at(summary, other), _at(summary, f"{other}_error")), name)


def _goes(wanted: Wanted, summary: Mapping) -> bool:
    quantity, _, key = wanted.path.partition(".")
    if quantity == "energy":
        return bool(_at(summary, "energy.conservative"))
    if quantity == "front":
        found, water = summary["front"], wanted.other == WATER
        return _at(summary, "jump.verdict") not in A_JUMP and (key != "speed" or water == against_water(found))
    return quantity != "jump" or belongs(key, _at(summary, "jump"))


def _at(summary: Mapping, path: str) -> object:
    """What stands at a path of keys; None where there is nothing."""
    found: object = summary
    for key in path.split("."):
        found = found.get(key) if isinstance(found, Mapping) else None
    return found


def _box(wanted: Wanted, key: str, found: Mapping, other: tuple[object, object], name: str) -> Box:
    """A box; `other` is the number it is compared with, and the error of that."""
    number = numbers_of(wanted.result)[key]
    unit = number.unit if wanted.unit is None else wanted.unit
    value, _, sure = with_error(found, key, wanted.scale).partition(" ± ")
    told, (beside, off) = wanted.words if not wanted.other else wanted.without, other
    if isinstance(beside, float | int):
        off = off / wanted.scale if isinstance(off, float | int) else None
        told = f"{wanted.words} {shown(beside / wanted.scale, wanted.beside or unit, off)}".replace("-", "−")
    label = heading((wanted.label or number.meaning).format(name=name), "")
    sure = sure.removeprefix(AT_LEAST) + MORE * sure.startswith(AT_LEAST)
    return Box(label, value, unit, sure, told)
