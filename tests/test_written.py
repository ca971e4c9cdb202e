# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers as people write them: their values, and what is said of text that is none."""

import re
from math import radians, tan

import pytest

from lammps_jump.written import FieldUnit, angle_of, odd_blank, problem_of, tangent, to_number, whole

SLOPE = FieldUnit("", slope=True)


@pytest.mark.parametrize(
    ("unit", "text", "value"),
    [
        ("m", "20 cm", 0.2), ("m", "5mm", 0.005), ("m", ".5 m", 0.5), ("m", "5e-3 m", 0.005), ("m", "20\u00a0cm", 0.2),
        ("m", "5 \u00b5m", 5e-6), ("m", "5 \u03bcm", 5e-6), ("m", "1.000", 1.0), ("m", " 5 m ", 5.0),
        ("m", "-0 m", 0.0), ("kg/m^3", "2.65 g/cm3", 2650), ("kg/m^3", "2.65 g/cm^3", 2650), ("kg/m^3", "1 t/m3", 1000),
        ("kg/m^3", "1000 kg/m\u00b3", 1000), ("kg/m^3", "1000 kg m-3", 1000),
        ("kg/m^3", "1000 kg\u00b7m\u207b\u00b3", 1000),
        ("m/s^2", "9.81 m/s2", 9.81), ("m/s^2", "9.81 m s-2", 9.81), ("m/s^2", "9.81 N/kg", 9.81),
        ("m^2/s", "4 m3/s/m", 4), ("Pa", "5 N/mm2", 5e6), ("kg*m", "3 kg*m2/m", 3), ("degree/s", "1 rpm", 6),
        ("1/s", "5 Hz", 5), ("1/s", "2 s-1", 2), ("", "40 %", 0.4), ("", "5 ppm", 5e-6), ("", "1 mm/m", 0.001),
    ],
)  # fmt: skip
def test_numbers_with_their_units(unit, text, value):
    found = to_number(text, FieldUnit(unit))
    assert found == pytest.approx(value, rel=1e-15) and str(found) != "-0.0"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0,5 m", "a decimal comma; decimals have a point: write 0.5 m"),
        ("0,5", "write 0.5"),
        ("0,500", "a decimal comma; decimals have a point: write 0.500"),
        ("-1,25e3", "write -1.25e3"),
        ("1,000", "groups digits or stands for the point of decimals; write 1000 or 1.000"),
        ("1,234,567 m", "grouped by a comma; write 1234567 m"),
        ("1,000.5", "grouped by a comma; write 1000.5"),
        ("1.000,5", "grouped by a point; write 1000.5"),
        ("1 000", "grouped by a blank; write 1000"),
        ("1'000", "grouped by an apostrophe; write 1000"),
        ("1\u2019000", "grouped by an apostrophe (U+2019); write 1000"),
        ("1_000", "grouped by a line below (_); write 1000"),
        ("1\u00a0000 mm", "grouped by a no-break space (U+00A0); write 1000 mm"),
        ("1\u2009000", "grouped by a thin space (U+2009); write 1000"),
        ("1\u202f000", "grouped by a narrow no-break space (U+202F); write 1000"),
        ("1\t000", "grouped by a tab (U+0009); write 1000"),
        ("\u0663 m", "a digit of another script (U+0663); write 3 m"),
        ("\uff15 m", "a digit of another script (U+FF15); write 5 m"),
        ("\u22125 m", "a sign or dash (U+2212) that is no minus of a number; write - (U+002D)"),
        ("5 m\u200b", "a letter that cannot be seen (U+200B); write 5 m"),
        ("1.5 e-3 m", "write 1.5e-3 m"),
        ("1.5 x 10^-3 m", "write 1.5e-3 m"),
        ("1.5\u00b710-3 m", "write 1.5e-3 m"),
        ("1e400 m", "'1e400 m' is not a finite number"),
        ("5 MM", "capitals count in units; is mm meant?"),
        ("5 CM", "capitals count in units; is cm meant?"),
        ("5\u00b2 m", "is not one number"),
        ("1 0000", "is not one number"),
        ("0.1.2", "is not one number"),
        ("1:30", "is not one number"),
        ("5 florps", "known unit"),
        ("5 %", "is in percent; expected a number in m, or a string such as '20 cm' (also mm, um, km, ft, in)"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_what_to_write(text, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        to_number(text, FieldUnit("m", "20 cm", "mm, um, km, ft, in"))


@pytest.mark.parametrize("text", ["1.000", "20 cm", "9.81 m/s2", "1e-3", "-5", "5 m s-1", "1000 kg m-3"])
def test_nothing_is_wrong_with_numbers(text):
    assert problem_of(text) == ""


@pytest.mark.parametrize(
    "text",
    ["0 deg", "-0 deg", "22 deg", "22deg", "22\u00b0", "45 degree", "1.5 rad", "0.2 turn", "89.9 deg", "30 mrad"],
)
def test_a_coefficient_of_friction_may_be_an_angle(text):
    """Its tangent to twelve digits, which all systems share."""
    angle = angle_of(text)
    found = to_number(text, SLOPE)
    assert found == float(f"{tan(radians(angle)):.12g}") and str(found) != "-0.0"
    assert found == tangent(angle)


@pytest.mark.parametrize(
    "text", ["90 deg", "90.0001 deg", "-1 deg", "100 grade", "1.6 rad", "1 turn", "-45 deg", "1e300 deg"]
)
def test_no_friction_from_other_angles(text):
    with pytest.raises(
        ValueError, match="is out of range; expected a plain number, or an angle from 0 to below 90 degree"
    ):
        to_number(text, SLOPE)


def test_a_share_is_no_angle_and_an_angle_no_share():
    with pytest.raises(
        ValueError, match=r"is in percent, which is no angle \(a slope with this tangent has 2.86241 degree"
    ):
        to_number("5 %", FieldUnit("degree"))
    with pytest.raises(ValueError, match="is in degree; expected a plain number without a unit, or a share in %"):
        to_number("11 deg", FieldUnit(""))
    assert to_number("40 %", SLOPE) == 0.4


@pytest.mark.parametrize(("given", "value"), [("5", 5), (" -3 ", -3), ("010", 10), (7, 7), (5.0, 5.0)])
def test_counts(given, value):
    assert whole(given) == value


@pytest.mark.parametrize("given", ["5 m", "5 count", "1_000", "1 000", "5.0", "", "\u0663", True])
def test_no_counts(given):
    with pytest.raises(ValueError, match=r"whole number|write"):
        whole(given)


def test_blanks_that_yaml_does_not_know_are_named():
    assert odd_blank("a: 1\n  b: 2") == ""
    assert odd_blank("\tx") == "a tab (U+0009)" and odd_blank("x\u00a0y") == "a no-break space (U+00A0)"
    assert odd_blank("\ufeffx") == "a letter that cannot be seen (U+FEFF)"
