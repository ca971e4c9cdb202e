"""Numbers of a case file: SI floats, or strings with a unit."""

from __future__ import annotations

import re
from functools import lru_cache
from math import inf, isfinite
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from lammps_jump.errors import CaseError

_FACTOR = r"(?:[^\W\d_]\w*|°|%)(?:(?:\^|\*\*)[+-]?[0-9]+)?"
_QUANTITY = re.compile(
    r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"  # one number
    rf"(?:\s*((?:1\s*/\s*)?{_FACTOR}(?:(?:\s*[*/·]\s*|\s+){_FACTOR})*))?\s*"  # factors of a unit, as 1/s, kg/m^3
)


@lru_cache(maxsize=1)
def _registry():
    import pint  # a quarter of a second, so only where a string with a unit is met

    return pint.UnitRegistry()


def to_si(value: Any, unit: str) -> Any:
    """`value` as a float in `unit`; strings like '20 cm' are converted.

    Raises
    ------
    ValueError
        For booleans, NaN, infinities, unknown units and units of another dimension (pydantic adds the place).
    """
    if isinstance(value, bool):
        raise ValueError(f"{str(value).lower()} is not a number; expected {_expected(unit)}")
    if isinstance(value, str):
        value = _from_text(value, unit)
    if isinstance(value, int | float):
        try:
            value = float(value)
        except OverflowError:  # a whole number of more than 308 digits
            value = inf
        if not isfinite(value):
            raise ValueError(f"{value} is not a finite number; expected {_expected(unit)}")
        return value
    if value is None:
        raise ValueError(f"is empty; expected {_expected(unit)}")
    return value


def _from_text(text: str, unit: str) -> float:
    # pint alone would reckon with what it gets: 0.1.2 is 0.02 to it, 1:30 is 30, 1 000 is 0
    found = _QUANTITY.fullmatch(text)
    if not found:
        raise ValueError(f"{text!r} is not one number with or without a unit; expected {_expected(unit)}")
    number, given = found.groups()
    if given is None:
        return float(number)
    import pint

    try:
        units = _registry().parse_units(given.replace("·", "*"))
        return float(_registry().Quantity(float(number), units).to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError as error:
        raise ValueError(f"{text!r} is in {error.units1}; expected {_expected(unit)}") from None
    except Exception:  # pint raises many kinds (also tokenizer errors) for text that is no quantity
        raise ValueError(f"{text!r} is not a number with a known unit; expected {_expected(unit)}") from None


def _expected(unit: str) -> str:
    return f"a number in {unit}, or a string such as '{_EXAMPLES.get(unit, '1 ' + unit)}'" if unit else "a plain number"


_EXAMPLES = {
    "m": "20 cm",
    "m/s": "16 m/s",
    "s": "100 ms",
    "kg/m^3": "1000 kg/m^3",
    "N/m": "2.56e7 N/m",
    "degree": "2 degree",
    "1/s": "100 1/s",
}


def number(unit: str) -> Any:
    """Annotated float type that accepts a number in `unit` or a string with a unit."""
    return Annotated[
        float,
        BeforeValidator(lambda value: to_si(value, unit)),
        WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string"}], "description": f"SI unit: {unit or '1'}"}),
    ]


Metre = number("m")
MetrePerSecond = number("m/s")
MetrePerSecond2 = number("m/s^2")
Second = number("s")
Density = number("kg/m^3")
Stiffness = number("N/m")
Degree = number("degree")
PerSecond = number("1/s")
Plain = number("")


def parse_accuracy(text: str | float) -> float:
    """A share from ``1%``, ``1 %`` or ``0.01``.

    Raises
    ------
    CaseError
        No number, or not between 0 and 1.
    """
    word = str(text).strip()
    try:
        value = float(word[:-1]) / 100 if word.endswith("%") else float(word)
    except ValueError:
        raise CaseError(f"accuracy {text!r} is no share; write 1% or 0.01") from None
    if not 0 < value < 1:
        raise CaseError(
            f"accuracy {text!r} is out of range; allowed is above 0 and below 1 (100 %), such as 1% or 0.01"
        )
    return value
