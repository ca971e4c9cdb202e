# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers in: SI floats, or strings with a unit. Numbers out: each described once, and one formatter for all.

A result is a frozen dataclass whose numbers are made with `number`. The key of ``summary.json``, the row of the report
and the line on the screen come from that description.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Hashable, Mapping
from functools import lru_cache, partial
from math import floor, isfinite, log10, nan
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar, cast, get_args, get_type_hints

from pydantic import AfterValidator, BeforeValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, WithJsonSchema
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_before_validator_function

from lammps_jump.errors import CaseError
from lammps_jump.quoting import echoed
from lammps_jump.written import FieldUnit, to_number

ABSENT = "–"  # noqa: RUF001  (a dash for readers)
"""Shown in place of a number that was not measured."""


class Number(NamedTuple):
    """Description of one number of a result.

    Attributes
    ----------
    key : str
        Name of the field, and key of ``summary.json``.
    unit : str
        SI unit, empty where there is none.
    meaning : str
        What the number is, in a few words.
    label : str
        Short name for the screen and for boxes; the meaning where none was given.
    """

    key: str
    unit: str
    meaning: str
    label: str


def number(unit: str, meaning: str, *, default: Any = dataclasses.MISSING, label: str = "") -> Any:
    """Field of a frozen dataclass that carries its description.

    Parameters
    ----------
    unit : str
        SI unit, empty for a number without one.
    meaning : str
    default : optional
        NaN means not measured, None absent.
    label : str
        Short name, default the meaning.
    """
    return dataclasses.field(default=default, metadata={"number": (unit, meaning, label or meaning)})


def estimate(unit: str, meaning: str, *, label: str = "", interval: str = "") -> Any:
    """`number` of one of `Estimates`, with how sure it is; both are NaN where not measured.

    Parameters
    ----------
    unit, meaning, label : str
        As of `number`.
    interval : str
        What half of its 95 % interval is; without it the number has a standard error.
    """
    described = {"number": (unit, meaning, label or meaning)}
    sure = ("_interval", interval) if interval else ("_error", f"standard error of {meaning}")
    return dataclasses.field(default=nan, metadata=described | {"sure": (sure[0], unit, sure[1])})


class Estimates:
    """Base of results: each `estimate` is followed by its standard error ``<name>_error``, or ``<name>_interval``.

    Names in ``lower_bounds`` are of numbers whose error one run cannot tell: it is a lower bound.
    """

    def __init_subclass__(cls) -> None:
        fields: dict[str, Any] = {}
        for name, kind in inspect.get_annotations(cls).items():
            fields[name] = kind
            if sure := getattr(cls.__dict__.get(name), "metadata", {}).get("sure"):
                ending, *described = sure
                fields[f"{name}{ending}"] = "float"
                setattr(cls, f"{name}{ending}", number(*described, default=nan))
        cls.__annotations__ = fields

    if TYPE_CHECKING:  # the errors

        def __getattr__(self, name: str) -> float: ...


class Sure(NamedTuple):
    """Certainty of a number: its standard error within one run or half of its 95 % interval; None where not known.

    `bound` says that it is a lower bound.
    """

    value: float | None
    bound: bool = False


def sure_of(result: object, key: str) -> Sure:
    """Certainty of a number of a result."""
    values = (getattr(result, f"{key}{ending}", None) for ending in ("_error", "_interval"))
    known = next((value for value in values if value is not None and value == value), None)
    return Sure(known, key in getattr(result, "lower_bounds", ()))


def known(value: object) -> bool:
    """Tells whether a number was measured: neither None nor NaN."""
    return value is not None and value == value


def numbers_of(result: object) -> dict[str, Number]:
    """Descriptions of the numbers of a dataclass or of an instance of one, by key, in the order of its fields."""
    fields = dataclasses.fields(result)  # type: ignore[arg-type]
    return {f.name: Number(f.name, *f.metadata["number"]) for f in fields if "number" in f.metadata}


def as_summary(result: object) -> dict[str, object]:
    """Fields of a result as they are in ``summary.json``, results inside it as mappings.

    Fields with ``metadata={"summary": False}`` (arrays, inputs of figures) are left out; ``metadata={"key": …}`` names
    a field that Python cannot name.
    """
    data: dict[str, object] = {}
    for field in dataclasses.fields(result):  # type: ignore[arg-type]
        if field.metadata.get("summary", True):
            value = getattr(result, field.name)
            data[field.metadata.get("key", field.name)] = (
                as_summary(value) if dataclasses.is_dataclass(value) else value
            )
    return data


Result = TypeVar("Result")


def from_summary(result: type[Result], data: Mapping[str, Any]) -> Result:
    """A result as it is in ``summary.json``: what `as_summary` was made of.

    Where null replaces a number it is NaN, for all else the default. What is in no summary has its default, None
    without one.
    """
    given: dict[str, Any] = {}
    kinds = _kinds(cast(Hashable, result))
    for field in dataclasses.fields(result):  # type: ignore[arg-type]
        kind, value = kinds[field.name], data.get(field.metadata.get("key", field.name))
        is_stored = field.metadata.get("summary", True) and (value is not None or kind is float)
        lacks = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if is_stored or lacks:
            given[field.name] = _as(kind, value)
    return result(**given)


@lru_cache
def _kinds(result: Any) -> dict[str, Any]:
    return get_type_hints(result)


def _as(kind: Any, value: Any) -> Any:
    """A value of ``summary.json`` as one of this type."""
    if value is None:
        return nan if kind is float else None
    parts = get_args(kind)
    if type(None) in parts:
        return _as(next(part for part in parts if part is not type(None)), value)
    if isinstance(value, Mapping):
        if dataclasses.is_dataclass(kind):
            return from_summary(kind, value)  # type: ignore[arg-type]
        return {key: _as(parts[1], one) for key, one in value.items()} if parts else value
    if isinstance(value, list | tuple):
        if parts:
            return tuple(_as(parts[0], one) for one in value)
        import numpy as np  # not for a command that shows no result

        return np.array(value, float) if kind is np.ndarray else value
    return value


POWERS = str.maketrans({"^": None, "2": "²", "3": "³", "4": "⁴"})
"""Powers in units, as they are shown."""


def unit_in_words(unit: str) -> str:
    """A unit as sentences and tables show it."""
    return unit.translate(POWERS).replace("degree", "degrees").replace("*", " ")


KILO = 1e3


def in_kilo(unit: str) -> tuple[float, str]:
    """Factor and unit in which pages show a number: forces, their moments and impulses in kN, pressure in kPa."""
    return (KILO, f"k{unit}") if re.match(r"(N|Pa)(?![a-z])", unit) else (1.0, unit)


AT_LEAST = "at least "
"""Stands before an error that is a lower bound."""
ROUND_OFF = 1e-12
"""Errors below this share of a number are those of arithmetic and are not shown."""


def shown(
    value: object,
    unit: str = "",
    error: float | None = None,
    *,
    digits: int = 4,
    bound: bool = False,
    alone: bool = False,
) -> str:
    """A value as text, for the screen, the report, ``check`` and the docs.

    Parameters
    ----------
    value : float, int, bool, str or None
        None and NaN become a dash, booleans yes and no.
    unit : str
        Put after the number.
    error : float, optional
        In the same unit. It has two digits, and the value is rounded to the second of them.
    digits : int
        Significant digits of a number without an error.
    bound : bool
        The error is a lower bound; "at least" is put before it.
    alone : bool
        The error only rounds the value.
    """
    if value is None or (isinstance(value, float) and value != value):
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, int | float):
        return str(value)
    if error is not None and isfinite(error) and error > ROUND_OFF * abs(value):
        text = _to_digit_of(error, value) + ("" if alone else f" ± {AT_LEAST * bound}{two_digits(error)}")
    else:
        text = f"{value:z.{digits}g}" if isinstance(value, float) else str(value)
    return f"{text} {unit.translate(POWERS)}" if unit else text


def two_digits(error: float) -> str:
    """An error as text."""
    return _to_digit_of(error, error)


def _to_digit_of(error: float, value: float) -> str:
    """A value rounded to the second digit of an error."""
    last = 1 - floor(log10(float(f"{error:z.1e}")))
    return f"{round(value, last) + 0.0:z.{max(0, last)}f}"


def to_si(value: Any, unit: str) -> Any:
    """`value` as a float in `unit`; strings like '20 cm' are converted, as `to_number` of ``written.py`` does."""
    return to_number(value, _FIELD_UNITS.get(unit) or FieldUnit(unit))


_FIELD_UNITS: dict[str, FieldUnit] = {}
"""Quantity of a number in a unit, of the types below."""
BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}
"""Bounds as pydantic calls them, and as a JSON schema does."""


@dataclasses.dataclass(frozen=True)
class InUnit(FieldUnit):
    """Annotation of a float that is given as a number in `unit`, or as text with a unit such as the example.

    The JSON schema of a field tells the unit, and the range of the number.
    """

    def __post_init__(self) -> None:
        if not self.slope:
            _FIELD_UNITS[self.unit] = self

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Schema by which pydantic checks a value."""
        return no_info_before_validator_function(partial(to_number, wanted=self), handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """For editors: a number within its range, or text."""
        known = handler(schema)
        bounds = {other: known[key] for name, other in BOUNDS.items() for key in (name, other) if key in known}
        titled = {"title": known["title"]} if "title" in known else {}
        return {"anyOf": [{"type": "number", **bounds}, {"type": "string"}], "unit": self.unit or "1", **titled}


Metre = Annotated[float, InUnit("m", "20 cm", "mm, um, km, ft, in")]
MetrePerSecond = Annotated[float, InUnit("m/s", "16 m/s", "cm/s, mm/s, km/h")]
MetrePerSecond2 = Annotated[float, InUnit("m/s^2", "9.81 m/s^2", "cm/s^2, N/kg")]
MetrePerSecondMetre = Annotated[float, InUnit("m^2/s", "16 m^2/s", "m^3/s/m, cm^2/s, l/s/m")]
Second = Annotated[float, InUnit("s", "100 ms", "us, min, h")]
Density = Annotated[float, InUnit("kg/m^3", "1000 kg/m^3", "g/cm^3, t/m^3")]
Degree = Annotated[float, InUnit("degree", "2 degree", "rad, mrad, turn")]
DegreePerSecond = Annotated[float, InUnit("degree/s", "30 degree/s", "rad/s, rpm")]
KilogramPerMetre = Annotated[float, InUnit("kg/m", "500 kg/m", "t/m, g/cm")]
KilogramMetre = Annotated[float, InUnit("kg*m", "60 kg*m", "t*m, kg*m^2/m")]
Pascal = Annotated[float, InUnit("Pa", "5 MPa", "kPa, GPa, N/mm^2, bar")]
NewtonPerMetre = Annotated[float, InUnit("N/m", "2.56e7 N/m", "kN/m, MN/m, N/mm")]
PerSecond = Annotated[float, InUnit("1/s", "100 1/s", "1/ms, Hz")]
Plain = Annotated[float, InUnit("")]
Slope = Annotated[float, InUnit("", slope=True)]
"""A plain number that is the tangent of an angle, which may be given in its place: a friction coefficient."""

# Ranges that several fields have: wider than any use, and narrow enough that squares and quotients stay finite.
Length = Annotated[Metre, Field(ge=1e-6, le=1e6)]
Coordinate = Annotated[Metre, Field(ge=-1e6, le=1e6)]
Component = Annotated[MetrePerSecond, Field(ge=-1e6, le=1e6)]
Moment = Annotated[Second, Field(ge=-1e9, le=1e9)]
Duration = Annotated[Second, Field(ge=1e-9, le=1e9)]
Mass = Annotated[KilogramPerMetre, Field(ge=1e-9, le=1e15)]
Stiffness = Annotated[NewtonPerMetre, Field(ge=1e-6, le=1e24)]
Friction = Annotated[Slope, Field(ge=0, le=1000)]
Restitution = Annotated[Plain, Field(ge=1e-6, le=1)]
Point = tuple[Coordinate, Coordinate]
Vector = tuple[Component, Component]


def ordered(value: tuple[float, float]) -> tuple[float, float]:
    """The interval itself; ValueError where its ends are not in order."""
    if value[0] >= value[1]:
        raise ValueError(f"[{value[0]:zg}, {value[1]:zg}] runs backwards; expected [low, high] with low < high")
    return value


def not_backwards(value: tuple[float, float]) -> tuple[float, float]:
    """The interval itself, which may be a point; ValueError where its ends are not in order."""
    return value if value[0] == value[1] else ordered(value)


Start = Annotated[Coordinate, Field(title="start")]
End = Annotated[Coordinate, Field(title="end")]
Underside = Annotated[Coordinate, Field(title="underside")]
Height = Annotated[Coordinate, Field(title="height")]
Extent = Annotated[tuple[Start, End], AfterValidator(ordered)]
"""From and to along x."""
Rise = Annotated[tuple[Underside, Height], AfterValidator(ordered)]
"""From and to in height."""


def parse_accuracy(text: str | float) -> float:
    """A share from ``1%``, ``1 %`` or ``0.01``.

    Raises
    ------
    CaseError
        No number, or not between 0 and 1.
    """
    word = str(text).strip()
    try:
        value = to_si(word[:-1], "") / 100 if word.endswith("%") else to_si(word, "")
    except ValueError:
        raise CaseError(f"accuracy {echoed(text)} is no share; write 1% or 0.01") from None
    if not 0 < value < 1:
        raise CaseError(
            f"accuracy {echoed(text)} is out of range; allowed is above 0 and below 1 (100 %), such as 1% or 0.01"
        )
    return value


Share = Annotated[
    float,
    BeforeValidator(parse_accuracy),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}, {"type": "string"}]}),
]
"""Annotated float type that accepts a share, also in per cent."""
