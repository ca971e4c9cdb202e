# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers as people write them: text with a unit to an SI float, and in words what is wrong with other text.

A unit is held to the dimension that its field has. Angles, counts and steps of a logarithm (decibel) are dimensions
of their own. A share (%) is a plain number.
"""

from __future__ import annotations

import dataclasses
import re
import unicodedata
from functools import lru_cache
from math import atan, degrees, inf, isfinite, radians, tan
from typing import Any

from lammps_jump.quoting import echoed, is_hidden

NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_WORD = r"[^\W\d_⁰¹²³⁴⁵⁶⁷⁸⁹]\w*|°|%|‰"
_FACTOR = rf"(?:{_WORD})(?:(?:\^|\*\*)?[+-]?[0-9]+|⁻[¹²³⁴])?"
_QUANTITY = re.compile(
    rf"\s*({NUMBER})"  # one number
    rf"(?:\s*((?:1\s*/\s*)?{_FACTOR}(?:(?:\s*[*/·⋅]\s*|\s+){_FACTOR})*))?\s*"  # factors of a unit, as 1/s, kg/m^3
)
_BARE_POWER = re.compile(r"([^\W\d_]+)([+-]?[2-9]|-1)")
_SHARES = frozenset({"percent", "permille", "ppm"})
"""Units without a dimension that a plain number may have; others are constants, such as pi."""
DIGITS_OF_A_TANGENT = 12


@dataclasses.dataclass(frozen=True)
class FieldUnit:
    """Unit of a field, and what else text may give its number in.

    Attributes
    ----------
    unit : str
        SI unit, empty for a plain number.
    example : str
        Text of such a number.
    others : str
        More units of the dimension, with commas.
    slope : bool
        A plain number that is the tangent of an angle; the angle may be given.
    """

    unit: str
    example: str = ""
    others: str = ""
    slope: bool = False

    @property
    def expected(self) -> str:
        """Allowed values, for a message."""
        if self.slope:
            return "a plain number, or an angle from 0 to below 90 degree, whose tangent is taken"
        if not self.unit:
            return "a plain number without a unit, or a share in %"
        text = f"a number in {self.unit}, or a string such as '{self.example or '1 ' + self.unit}'"
        return f"{text} (also {self.others})" if self.others else text


def to_number(value: Any, wanted: FieldUnit) -> Any:
    """`value` as a float in the unit of its field; text such as '20 cm' is converted. What is no number comes back.

    Raises
    ------
    ValueError
        For booleans, NaN, infinities, unknown units, units of another dimension, and text that is no number (pydantic
        adds the place).
    """
    if isinstance(value, bool):
        raise ValueError(f"{str(value).lower()} is not a number; expected {wanted.expected}")
    said = value
    if isinstance(value, str):
        value = _from_text(value, wanted)
    if isinstance(value, int | float):
        try:
            value = float(value)
        except OverflowError:  # a whole number of more than 308 digits
            value = inf
        if not isfinite(value):
            what = echoed(said) if isinstance(said, str) else f"{value}"
            raise ValueError(f"{what} is not a finite number; expected {wanted.expected}")
        return value + 0.0  # never -0
    if value is None:
        raise ValueError(f"is empty; expected {wanted.expected}")
    return value


def whole(value: Any) -> Any:
    """A count as given, or of text.

    Raises
    ------
    ValueError
        For booleans, and text that is no whole number.
    """
    if isinstance(value, bool):
        raise ValueError(f"{str(value).lower()} is not a number; expected a whole number")
    if isinstance(value, str):
        if not re.fullmatch(r"\s*[+-]?[0-9]{1,300}\s*", value):
            said = problem_of(value) or "is not a whole number; a count has no unit: write digits alone"
            raise ValueError(f"{echoed(value)} {said}")
        return int(value)
    return value


def is_quantity(text: str) -> bool:
    """Tells whether a text is one number, with or without what may be a unit."""
    return _QUANTITY.fullmatch(text) is not None


def angle_of(value: object) -> float | None:
    """The angle that a text gives, degrees; None for other text and all else."""
    if not isinstance(value, str) or not (match := _QUANTITY.fullmatch(value)) or match[2] is None:
        return None
    try:
        return _converted(value, float(match[1]), match[2], FieldUnit("degree"))
    except ValueError:
        return None


def tangent(angle: float) -> float:
    """Tangent of an angle in degrees, with so many digits that it is the same on all systems."""
    return float(f"{tan(radians(angle)):.{DIGITS_OF_A_TANGENT}g}") + 0.0


def _from_text(text: str, wanted: FieldUnit) -> float:
    # pint evaluates malformed numbers instead of refusing them: 0.1.2 gives 0.02, 1:30 gives 30, 1 000 gives 0
    if problem := problem_of(text):
        raise ValueError(f"{echoed(text)} {problem}; expected {wanted.expected}")
    match = _QUANTITY.fullmatch(text)
    if not match:
        raise ValueError(f"{echoed(text)} is not one number with or without a unit; expected {wanted.expected}")
    number, unit = float(match[1]), match[2]
    if unit is None or not isfinite(number):
        return number
    if wanted.slope and (angle := angle_of(text)) is not None:
        if not 0 <= angle < 90:
            raise ValueError(f"{echoed(text)} is out of range; expected {wanted.expected}")
        return tangent(angle)
    return _converted(text, number, unit, wanted)


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # 0.14 s, so only where a string with a unit is met

    return pint.UnitRegistry()


def _converted(text: str, number: float, unit: str, wanted: FieldUnit) -> float:
    """A number in a unit of the field."""
    try:
        given = _parsed(unit)
        fits = _dimension(given) == _dimension(_parsed(wanted.unit))
    except Exception:  # pint raises many kinds (also tokenizer errors) for text that is no unit
        hint = _other_letters(unit, wanted)
        raise ValueError(
            f"{echoed(text)} is not a number with a known unit{hint}; expected {wanted.expected}"
        ) from None
    if not fits:
        hint = _other_letters(unit, wanted) or _as_slope(number, given, wanted)
        raise ValueError(f"{echoed(text)} is in {given}{hint}; expected {wanted.expected}")
    return float(_registry().Quantity(number, given).to(wanted.unit or "dimensionless").magnitude)


@lru_cache(maxsize=1000)
def _parsed(unit: str) -> Any:
    """A unit of pint; powers may be without their sign: cm3, s-1."""
    registry = _registry()

    def power(part: str) -> str:
        match = _BARE_POWER.fullmatch(part)
        if match is None or (match[0].isalnum() and match[0] in registry):  # a sign would be calculated
            return part
        return f"{match[1]}**{match[2]}"

    text = re.sub("⁻([¹²³⁴])", lambda match: f"-{unicodedata.digit(match[1])}", re.sub("[·⋅]", "*", unit))
    return registry.parse_units("".join(map(power, re.split(r"(\s*[*/]\s*|\s+)", text))))


def _powers(unit: Any) -> list[tuple[str, float]]:
    """Names in a unit with their powers."""
    from pint.util import to_units_container

    container: Any = to_units_container(unit, _registry())
    return [(name, float(power)) for name, power in container.items()]


def _dimension(unit: Any) -> tuple[tuple[str, float], ...]:
    """Base units of a unit with their powers. To pint radian and count are base units, though without a dimension."""
    registry, powers = _registry(), dict[str, float]()
    for name, power in _powers(unit):
        root = _powers(registry.get_root_units(name)[1])
        if not root and name not in _SHARES:  # a constant, or a step of a logarithm
            powers[f"{name} itself"] = power
        for base, exponent in root:
            powers[base] = powers.get(base, 0.0) + power * exponent
    return tuple(sorted((base, round(power, 9)) for base, power in powers.items() if power))


def _other_letters(unit: str, wanted: FieldUnit) -> str:
    """A unit that differs by capitals alone and fits the field, for a message; empty where there is none."""
    own = _dimension(_parsed("degree" if wanted.slope else wanted.unit))
    for other in (unit.lower(), unit[:1] + unit[1:].lower()):
        try:
            if other != unit and _dimension(_parsed(other)) == own:
                return f" (capitals count in units; is {other} meant?)"
        except Exception:  # as above
            continue
    return ""


def _as_slope(number: float, given: Any, wanted: FieldUnit) -> str:
    """The angle of a slope that is given as a share, for a message."""
    if wanted.unit != "degree" or _dimension(given):
        return ""
    rise = float(_registry().Quantity(number, given).to("dimensionless").magnitude)
    return f", which is no angle (a slope with this tangent has {degrees(atan(rise)):zg} degree)"


_DIGITS = "[0-9]+"
_GROUPED = re.compile(
    r"([+-]?[0-9]{1,3}(?:([ '\u2019_,.\t\u00a0\u2007\u2009\u202f])[0-9]{3})(?:\2[0-9]{3})*)(?:([.,])([0-9]+))?(?![0-9])"
)
_COMMA = re.compile(rf"([+-]?{_DIGITS}),({_DIGITS})(?![0-9,.;])")
_POWER_OF_TEN = re.compile(rf"({NUMBER})\s*(?:[x\u00d7*·⋅]\s*10\s*(?:\^|\*\*)?|\s[eE])\s*([+-]?[0-9]+)(?![0-9])")


def problem_of(text: str) -> str:
    """Problem of a text that is to be a number, and what to write; empty where nothing is seen.

    It knows decimal commas, grouped digits, digits and signs of other scripts, letters that cannot be seen, and powers
    of ten.
    """
    bare = text.strip()
    if strange := next((letter for letter in bare if _is_strange(letter)), None):
        return _of_strange(strange, bare)
    if match := _GROUPED.match(bare):
        return _of_groups(match)
    if match := _COMMA.match(bare):
        return f"has a decimal comma; decimals have a point: write {match[1]}.{match[2]}{bare[match.end() :]}"
    if match := _POWER_OF_TEN.match(bare):
        return f"has a power of ten beside its number; write {match[1]}e{int(match[2])}{bare[match.end() :]}"
    return ""


def _is_strange(letter: str) -> bool:
    """Tells whether a letter looks like part of a number and is none, or cannot be seen."""
    other_digit = letter.isdecimal() and not letter.isascii()
    return other_digit or letter in "\u2212\u2013\u2014\uff0b\uff0d" or (is_hidden(letter) and letter != "\t")


def _of_strange(letter: str, text: str) -> str:
    letter_name = f"U+{ord(letter):04X}"
    if letter.isdecimal():
        plain = "".join(str(unicodedata.decimal(one)) if one.isdecimal() else one for one in text)
        return f"has a digit of another script ({letter_name}); write {plain}"
    if is_hidden(letter):
        return f"has a letter that cannot be seen ({letter_name}); write {text.replace(letter, '')}"
    sign, name = ("+", "plus") if letter == "\uff0b" else ("-", "minus")
    return f"has a sign or dash ({letter_name}) that is no {name} of a number; write {sign} (U+{ord(sign):04X})"


def _of_groups(match: re.Match[str]) -> str:
    """Digits in groups of three, which a comma and a point may also be of a decimal fraction."""
    whole, sign, point, more = match.groups()
    rest = match.string[match.end() :]
    joined = whole.replace(sign, "") + (f".{more}" if more else "") + rest
    if sign == "." and not (point or whole.count(sign) > 1):
        return ""  # 1.000 is one
    if sign == "," and not point and whole.count(",") == 1:
        if whole.lstrip("+-").startswith("0"):
            return f"has a decimal comma; decimals have a point: write {whole.replace(',', '.')}{rest}"
        decimal = whole.replace(",", ".") + rest
        return f"has a comma, which groups digits or stands for the point of decimals; write {joined} or {decimal}"
    return f"has digits grouped by {name_of(sign)}; write {joined}"


_NAMES = {
    " ": "a blank", "\t": "a tab", "'": "an apostrophe", "\u2019": "an apostrophe", "_": "a line below (_)",
    ",": "a comma", ".": "a point", "\u00a0": "a no-break space", "\u2007": "a figure space", "\u2009": "a thin space",
    "\u202f": "a narrow no-break space",
}  # fmt: skip


def name_of(letter: str) -> str:
    """A blank or sign in words, with its code where it looks the same as another: a no-break space (U+00A0)."""
    known = _NAMES.get(letter) or ("a space" if letter.isspace() else "a letter that cannot be seen")
    return known if letter.isascii() and letter != "\t" else f"{known} (U+{ord(letter):04X})"


def odd_blank(text: str) -> str:
    """The first blank of a text that YAML does not take for one, or letter that cannot be seen, in words; or empty."""
    letters = (letter for letter in text if letter not in " \r\n" and (letter.isspace() or is_hidden(letter)))
    return next(map(name_of, letters), "")
