# SPDX-License-Identifier: GPL-2.0-or-later
"""Every number of a case is held to the dimension of its field; walked over the models, so that new fields are met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import is_dataclass
from functools import cache
from typing import Annotated, Any, Literal, get_args, get_origin

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from lammps_jump.case.case import parse_case
from lammps_jump.case.field_words import fields_of, models_in, notes_of
from lammps_jump.case.fields import CaseFields
from lammps_jump.errors import CaseError
from lammps_jump.units import InUnit

UNITS = {
    "length": ("m", "cm", "um", "ft"),
    "speed": ("m/s", "km/h"),
    "acceleration": ("m/s^2", "N/kg"),
    "discharge": ("m^2/s",),
    "time": ("s", "ms", "h"),
    "density": ("kg/m^3", "g/cm3"),
    "angle": ("degree", "rad", "turn"),
    "rate of turn": ("degree/s", "rpm"),
    "mass": ("kg/m",),
    "inertia": ("kg*m",),
    "pressure": ("Pa", "bar"),
    "stiffness": ("N/m",),
    "rate": ("1/s", "Hz"),
    "share": ("%", "ppm"),
    "count": ("count", "count/s"),
    "step of a logarithm": ("dB", "Np"),
    "information": ("bit",),
    "solid angle": ("sr",),
    "constant": ("pi",),
    "temperature": ("K", "degC"),
    "mass itself": ("kg",),
    "substance": ("mol", "M"),
    "current": ("A",),
}
"""Units of each dimension; those of fields and others."""
DIMENSION = {"m^2/s": "discharge", "m/s^2": "acceleration", "": "share"} | {
    units[0]: name for name, units in UNITS.items()
}
"""Of the SI units of fields."""
OTHERS = {
    "share": ("%", "ppm", "permille", "mm/m", "1/m*m"),
    "angle": ("degree", "deg", "rad", "mrad", "turn", "\u00b0"),
    "length": ("m", "mm", "\u00b5m", "\u03bcm", "km", "inch", "yd"),
}
"""More units that a field of the dimension takes."""


def scalars(kind: Any, path: str, notes: tuple[Any, ...] = ()) -> Iterator[tuple[str, Any, tuple[Any, ...]]]:
    """Single values below a type, and in its groups, lists and alternatives: path, type, and what annotates it."""
    if get_origin(kind) is Annotated:
        inner, *own = get_args(kind)
        yield from scalars(inner, path, (*own, *notes))
    elif isinstance(kind, type) and (issubclass(kind, BaseModel) or is_dataclass(kind)):
        for name, field in fields_of(kind).items():
            yield from scalars(field.annotation, f"{path}.{name}", tuple(field.metadata))
    elif models_in(kind) or any(_is_list(part) for part in get_args(kind)) or _is_list(kind):
        for part in get_args(kind):
            if part is not Ellipsis:
                yield from scalars(part, path)
    else:
        yield path.lstrip("."), kind, notes


def _is_list(kind: Any) -> bool:
    return get_origin(kind) in (tuple, list, dict) or any(map(_is_list, get_args(kind)))


def parts_of(kind: Any) -> set[Any]:
    """Plain types and words that a type is made of."""
    found = get_args(kind)
    return (
        set().union(*map(parts_of, found)) if found and get_origin(kind) is not Literal else {get_origin(kind) or kind}
    )


@cache
def fields() -> dict[tuple[str, str], tuple[TypeAdapter[Any], str | None]]:
    """What checks each value of a case that is no text, by path and type, and its dimension; None: no unit is taken."""
    found = {}
    for path, kind, notes in scalars(CaseFields, ""):
        if kind is type(None):
            continue
        if str in parts_of(kind):
            assert not {int, float} & parts_of(kind), path  # a text that may be a number would hide its unit
            continue
        checked = Annotated[kind, *notes] if notes else kind
        info = FieldInfo.from_annotation(checked)
        unit = next((note.unit for note in notes_of(info) if isinstance(note, InUnit)), None)
        dimension = None if unit is None else DIMENSION[unit]
        if float in parts_of(kind) and unit is None:
            dimension = "share"
            assert path in PLAIN, f"{path} is a float that knows no unit: take a type of units.py"
        found[path, str(checked)] = TypeAdapter(checked), dimension
    return found


PLAIN = ("run.accuracy",)
"""Numbers without a type of `units.py`, which have a check of their own."""


def test_all_numbers_of_a_case_are_met():
    paths = {path for path, _ in fields()}
    assert {
        "contact.friction", "contact.rolling.friction", "contact.cohesion", "contact.cohesion.weight", "walls.friction",
        "walls.rolling", "walls.points", "walls.motion.rate", "walls.motion.period", "bodies.friction",
        "bodies.velocity",
        "bodies.inertia", "initial.velocities", "initial.gate.open_in", "initial.time", "inflow.table", "inflow.count",
        "discs.sizes.passing", "discs.sizes.shares", "analysis.window", "probes.gauges", "run.seed", "run.accuracy",
        "engine.ranks", "outflow.x_beyond", "domain.x", "gravity", "slope",
    } <= paths  # fmt: skip
    dimensions = list(UNITS)
    assert {dimension for _, dimension in fields().values()} == {*dimensions[: dimensions.index("count")], None}


@pytest.mark.parametrize("dimension", sorted(UNITS))
def test_no_field_takes_a_unit_of_another_dimension(dimension):
    """Each against a number of its range in each unit; a friction coefficient alone takes an angle beside."""
    taken = [
        f"{path}: {unit}"
        for (path, _), (adapter, own) in fields().items()
        if own != dimension and not (dimension == "angle" and path.rpartition(".")[2] in SLOPES)
        for unit in UNITS[dimension]
        if _takes(adapter, f"{_number_of(adapter)} {unit}")
    ]
    assert taken == []


SLOPES = ("friction", "rolling")
"""Fields that are coefficients of friction."""


NUMBERS = ("1", "0.3", "20", "1e-3", "1e6", "1e-9", "1e12", "1.4", "140", "1400", "1.4e6", "4e5", "400")


@cache
def _number_of(adapter: TypeAdapter[Any]) -> str:
    """A number that a field takes; 1 where it takes none."""
    return next((number for number in NUMBERS if _takes(adapter, number)), "1")


def _takes(adapter: TypeAdapter[Any], text: str) -> bool:
    try:
        adapter.validate_python(text)
    except ValidationError:
        return False
    return True


def test_every_field_takes_the_units_of_its_own_dimension():
    """Some number of each unit lies in the range of the field."""
    refused = [
        f"{path}: {unit}"
        for (path, _), (adapter, own) in fields().items()
        if own is not None
        for unit in (("%",) if path in PLAIN else (*UNITS[own], *OTHERS.get(own, ())))
        if not any(_takes(adapter, f"{number} {unit}") for number in NUMBERS)
    ]
    assert refused == []


def test_every_coefficient_of_friction_takes_an_angle_by_its_tangent():
    met = {}
    for (path, _), (adapter, _) in fields().items():
        if path.rpartition(".")[2] in SLOPES:
            met[path] = adapter.validate_python("22 deg")
            for text in ("90 deg", "-1 deg", "91 degree", "1.6 rad"):
                assert not _takes(adapter, text), path
    known = {"contact.friction", "contact.rolling.friction", "probes.stability.friction"}
    assert known | {f"{group}.{name}" for group in ("walls", "bodies") for name in SLOPES} <= set(met)
    assert set(met.values()) == {0.404026225835}


CASE = """\
name: box
gravity: 9.81
slope: 1
discs: {diameter: 0.2, density: 1000}
contact: {restitution: 0.5, friction: 0.3, stiffness: 1e7}
walls:
  - {name: bed, kind: plane, axis: y, at: 0, side: above, friction: 0.2}
  - {name: gate, kind: block, x: [3, 4], y: [0, 1], motion: {kind: rotate, rate: 5}}
bodies:
  - {name: raft, kind: block, x: [6, 8], y: [0, 1], density: 500, friction: 0.1}
initial:
  - {kind: column, x: [0, 2], y: [0, 2], velocity: [1, 0]}
run: {duration: 1, seed: 3}
"""


V, TAB, NO_BREAK = "velocity: [1, 0]", "a tab (U+0009)", "a no-break space (U+00A0)"
NO_BLANK = "which is no blank to YAML); write blanks alone"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("friction: 0.3", "friction: 5 m", "yaml:5: contact.friction: '5 m' is in meter; expected a plain number, or"),
        ("friction: 0.3", "friction: 90 deg", "yaml:5: contact.friction: '90 deg' is out of range; expected a"),
        ("restitution: 0.5", "restitution: 11 deg", "yaml:5: contact.restitution: '11 deg' is in degree; expected"),
        ("x: [6, 8]", "x: [6, 8 s]", "yaml:10: bodies[0].x[1]: '8 s' is in second; expected a number in m, or"),
        ("rate: 5", "rate: 5 Hz", "yaml:8: walls[1].motion.rate: '5 Hz' is in hertz; expected a number in"),
        ("seed: 3", "seed: 3 count", "yaml:13: run.seed: '3 count' is not a whole number; a count has no unit"),
        (V, "velocity: 8", "yaml:12: initial[0].velocity: 8 does not fit: needs two numbers, for example [8, 0]"),
        (V, "velocity: [8]", "velocity: [8] does not fit: needs two numbers, for example [8, 0]"),
        (V, "velocity: 8 m/s", "needs two numbers, for example [8 m/s, 0]"),
        (V, "velocity: '8, 2'", "needs two numbers, for example [8, 2]"),
        (V, "velocity: [0,5, 1]", "needs two numbers, for example [0, 5] (decimals have a point"),
        (V, "velocity:", "is empty; needs two numbers, for example [1, 0]"),
        ("x: [0, 2]", "x: 4", "initial[0].x: 4 does not fit: needs two numbers, for example [0, 4]"),
        ("diameter: 0.2", "diameter: 0,2", "a decimal comma ends a number in braces: decimals have a point, such as"),
        ("gravity: 9.81", "gravity: 9,81", "gravity: '9,81' has a decimal comma; decimals have a point: write 9.81"),
        ("gravity: 9.81", "gravity:\u00a09.81", f"case.yaml:2: is not YAML (it has {NO_BREAK}, {NO_BLANK}"),
        ("gravity: 9.81", "\u00a0gravity: 9.81", f"unknown field, with {NO_BREAK} in its name"),
        ("gravity: 9.81", "gravity:\t9.81", f"case.yaml:2: is not YAML (it has {TAB}, {NO_BLANK}"),
        ("  - {name: raft", "\t- {name: raft", f"case.yaml:10: is not YAML (it has {TAB}, {NO_BLANK}"),
    ],
)  # fmt: skip
def test_a_refusal_names_value_field_line_and_what_is_allowed(old, new, said):
    assert old in CASE
    with pytest.raises(CaseError) as error:
        parse_case(CASE.replace(old, new, 1), "case.yaml")
    assert said in str(error.value)


def test_check_tells_what_is_the_tangent_of_an_angle():
    text = CASE.replace("friction: 0.3", "friction: 22 deg").replace("friction: 0.2", "friction: 0.3 rad")
    case = parse_case(text.replace("friction: 0.1", "friction: '10\u00b0'"), "case.yaml")
    assert case.contact.friction == 0.404026225835
    assert case.check().slopes == (
        "contact.friction: 0.404, the tangent of '22 deg'",
        "walls.bed.friction: 0.309, the tangent of '0.3 rad'",
        "bodies.raft.friction: 0.176, the tangent of '10\u00b0'",
    )
    assert "\ntaken from angles\n  contact.friction: 0.404, the tangent of '22 deg'\n" in str(case.check())
    assert case.check().as_data()["slopes"] == list(case.check().slopes)
    assert parse_case(CASE).check().slopes == ()
    changed = parse_case(CASE).replace(["contact.friction=22deg", "walls.bed.friction=0.2"])
    assert changed.check().slopes == ("contact.friction: 0.404, the tangent of '22deg'",)
