# SPDX-License-Identifier: GPL-2.0-or-later
"""Elementary functions with the same bits on every system.

The libraries of systems differ in the last bit of sine, cosine, logarithm and powers. Sums, products, quotients and
roots do not: IEEE 754 rounds them in one way. What a state of discs depends on is computed here from these alone.
``core/contact/elementary.h`` has `sin`, `cos` and `atan2` with the same operations in the same order. Tests compare
the bits.

`sin`, `cos` and `atan2` are within 1 unit in the last place. The argument of the first two is reduced by pi/2 with 192
bits of 2/pi (Payne and Hanek 1983, SIGNUM Newsletter 18:19), so that a turn of 1e9 rad is as good as one of 1 rad. Sums
of two numbers and their error are those of Knuth and Dekker (Muller et al. 2018, Handbook of Floating-Point Arithmetic,
4.3 and 4.4). `log`, `exp` and `power` are computed with 40 decimal digits, and rounded once.
"""

from __future__ import annotations

from decimal import Context, Decimal
from math import copysign, frexp, inf, isfinite, isinf, isnan, ldexp, nan, sqrt

TWO_OVER_PI = int(
    "a2f9836e4e441529fc2757d1f534ddc0db6295993c439041fe5163abdebbc561b7246e3a424dd2e006492eea09d1921cfe1deb1cb129a73e"
    "e88235f52ebb4484e99c7026b45f7e413991d639835339f49c845f8bbdf9283b1ff897ffde05980fef2f118b5a0a6d1f6d367ecf27cb09b7"
    "4f463f669e5fea2d7527bac7ebe5f17b3d0739f78a5292ea6bfb5fb11f8d5d0856033046",
    16,
)
"""Binary digits of 2/pi after the point: 1184 of them, enough for the largest double."""
DIGITS, WINDOW = 1184, 192
QUARTER_TURN = (1.5707963267948966, 6.123233995736766e-17)
"""pi/2, and what this double lacks of it."""
SINE = [1 / 6, 1 / 120, 1 / 5040, 1 / 362880, 1 / 39916800, 1 / 6227020800, 1 / 1307674368000, 1 / 355687428096000]
"""1/3!, 1/5!, … of the Taylor series; the next term is below 1e-19 within pi/4."""
COSINE = [
    1 / 24,
    1 / 720,
    1 / 40320,
    1 / 3628800,
    1 / 479001600,
    1 / 87178291200,
    1 / 20922789888000,
    1 / 6402373705728000,
]
"""1/4!, 1/6!, … of the Taylor series."""
ARCTANGENT = [1 / 3, 1 / 5, 1 / 7, 1 / 9, 1 / 11, 1 / 13]
"""1/3, 1/5, … of the series of the arctangent; the next term is below 2e-18 of the first within 1/16."""
EIGHTHS = [
    (0.0, 0.0),
    (0.12435499454676144, -3.1253241424539383e-18),
    (0.24497866312686414, 1.0698755618734451e-17),
    (0.35877067027057225, -2.4623815582638635e-17),
    (0.4636476090008061, 2.2698777452961687e-17),
    (0.5585993153435624, -5.4556305485916264e-18),
    (0.6435011087932844, 1.5834785051444286e-17),
    (0.7188299996216245, -2.1478388444456983e-17),
    (0.7853981633974483, 3.061616997868383e-17),
]
"""Arctangents of 0, 1/8, … 1, and what these doubles lack of them."""
EXACT = Context(prec=40)


def _product(a: float, b: float) -> tuple[float, float]:
    """Rounded product, and its error."""
    high = a * b
    t = 134217729.0 * a
    a1 = t - (t - a)
    a2 = a - a1
    t = 134217729.0 * b
    b1 = t - (t - b)
    b2 = b - b1
    return high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2


def _sum(a: float, b: float) -> tuple[float, float]:
    """Rounded sum, and its error."""
    high = a + b
    c = high - a
    return high, (a - (high - c)) + (b - c)


def _reduced(x: float) -> tuple[int, float, float]:
    """Quadrant of a finite x > pi/4, and what is left of it, within ± pi/4, with the error of that double."""
    fraction, exponent = frexp(x)
    mantissa, begin = int(ldexp(fraction, 53)), exponent - 53 - 2 + 64  # 64 digits 0 precede the point
    window = (TWO_OVER_PI >> (DIGITS + 64 - begin - WINDOW)) & ((1 << WINDOW) - 1)
    turned = (mantissa * window) & ((1 << WINDOW) - 1)  # 4 quadrants are 2^192
    quadrant = (turned >> (WINDOW - 2)) + (turned >> (WINDOW - 3) & 1) & 3
    left = turned & ((1 << (WINDOW - 2)) - 1)
    below = left >> (WINDOW - 3)
    if below:
        left = (1 << (WINDOW - 2)) - left
    places = WINDOW - left.bit_length()
    left <<= places
    high = ldexp(float(left >> (WINDOW - 53)), 11 - 62 - places)
    low = ldexp(float(left >> (WINDOW - 106) & ((1 << 53) - 1)), -42 - 62 - places)
    rest, error = _product(high, QUARTER_TURN[0])
    error += high * QUARTER_TURN[1] + low * QUARTER_TURN[0]
    rest, error = _sum(rest, error)
    return (quadrant, -rest, -error) if below else (quadrant, rest, error)


def _near_sine(x: float, error: float) -> float:
    """Sine of x + error, x within ± pi/4."""
    z, series = x * x, SINE[7]
    for k in (6, 5, 4, 3, 2, 1, 0):
        series = SINE[k] - z * series
    return x - (x * (z * series) - (error - 0.5 * z * error))


def _near_cosine(x: float, error: float) -> float:
    """Cosine of x + error, x within ± pi/4."""
    z, series = x * x, COSINE[7]
    for k in (6, 5, 4, 3, 2, 1, 0):
        series = COSINE[k] - z * series
    half = 0.5 * z
    whole = 1.0 - half
    return whole + (((1.0 - whole) - half) + (z * (z * series) - x * error))


def sin(x: float) -> float:
    """Sine of x (rad); NaN of an infinite x."""
    if not isfinite(x):
        return nan
    size = abs(x)
    if size < 1e-8:
        return x
    if size <= 0.7853981633974483:
        return _near_sine(x, 0.0)
    quadrant, rest, error = _reduced(size)
    value = _near_cosine(rest, error) if quadrant & 1 else _near_sine(rest, error)
    return -value if (quadrant > 1) != (x < 0.0) else value


def cos(x: float) -> float:
    """Cosine of x (rad); NaN of an infinite x."""
    if not isfinite(x):
        return nan
    size = abs(x)
    if size <= 0.7853981633974483:
        return _near_cosine(size, 0.0)
    quadrant, rest, error = _reduced(size)
    value = _near_sine(rest, error) if quadrant & 1 else _near_cosine(rest, error)
    return -value if quadrant in (1, 2) else value


def tan(x: float) -> float:
    """Tangent of x (rad): sine over cosine, within 2 units in the last place."""
    return sin(x) / cos(x)


def _near_arctangent(a: float, b: float) -> tuple[float, float]:
    """Arctangent of a/b, 0 < a <= b, both of moderate size, and the error of that double."""
    eighth = int(8.0 * (a / b) + 0.5)
    c = 0.125 * eighth
    high, low = _product(c, b)
    top, top_error = _sum(a, -high)
    top_error -= low
    high, low = _product(c, a)
    under, under_error = _sum(b, high)
    under_error += low
    u = top / under
    high, low = _product(u, under)
    error = ((((top - high) - low) + top_error) - u * under_error) / under
    z, series = u * u, ARCTANGENT[5]
    for k in (4, 3, 2, 1, 0):
        series = ARCTANGENT[k] - z * series
    turn, rest = _sum(EIGHTHS[eighth][0], u)
    return _sum(turn, rest + ((EIGHTHS[eighth][1] + error) - u * (z * series)))


def atan2(y: float, x: float) -> float:
    """Angle of the point (x, y), rad, from -pi to pi; zeros, infinities and NaN as in C."""
    if isnan(x) or isnan(y):
        return nan
    if isinf(x) or isinf(y):
        x, y = (copysign(1.0 if isinf(one) else 0.0, one) for one in (x, y))
    a, b = abs(y), abs(x)
    if a == 0.0:
        return y if copysign(1.0, x) > 0.0 else copysign(2.0 * QUARTER_TURN[0], y)
    if b == 0.0:
        return copysign(QUARTER_TURN[0], y)
    steep = a > b
    if steep:
        a, b = b, a
    over, under = frexp(a)[1], frexp(b)[1]
    if over - under < -80:  # what the quotient adds to a right angle is below its last bit
        if steep:
            return copysign(QUARTER_TURN[0], y)
        return y / x if x > 0.0 else copysign(2.0 * QUARTER_TURN[0], y)
    angle, error = _near_arctangent(ldexp(a, -under), ldexp(b, -under))
    if steep:
        angle, rest = _sum(QUARTER_TURN[0], -angle)
        angle, error = _sum(angle, rest + (QUARTER_TURN[1] - error))
    if x < 0.0:
        angle, rest = _sum(2.0 * QUARTER_TURN[0], -angle)
        angle = angle + (rest + (2.0 * QUARTER_TURN[1] - error))
    else:
        angle = angle + error
    return copysign(angle, y)


def asin(x: float) -> float:
    """Angle whose sine is x, rad, from -pi/2 to pi/2; within 2 units in the last place.

    Raises
    ------
    ValueError
        x is not from -1 to 1.
    """
    return atan2(x, sqrt((1.0 - x) * (1.0 + x)))


def acos(x: float) -> float:
    """Angle whose cosine is x, rad, from 0 to pi; within 2 units in the last place.

    Raises
    ------
    ValueError
        x is not from -1 to 1.
    """
    return atan2(sqrt((1.0 - x) * (1.0 + x)), x)


def hypot(x: float, y: float) -> float:
    """Length of (x, y), from its squares: for lengths of a scene, from 1e-150 to 1e150."""
    return sqrt(x * x + y * y)


def log(x: float) -> float:
    """Natural logarithm, rounded once.

    Raises
    ------
    ValueError
        x is 0 or less.
    """
    if not x > 0.0:
        raise ValueError(f"the logarithm of {x} is not a number")
    return x if x == inf else float(Decimal(x).ln(EXACT))


def exp(x: float) -> float:
    """Exponential function of a finite x, rounded once."""
    return float(EXACT.exp(Decimal(x)))


def power(x: float, exponent: float) -> float:
    """The power of x >= 0, rounded once.

    Raises
    ------
    ValueError
        x is negative.
    """
    if x < 0.0:
        raise ValueError(f"powers of {x} are not computed")
    if x == 0.0 or exponent == 0.0:
        return float(exponent == 0.0)
    return float(EXACT.power(Decimal(x), Decimal(exponent)))
