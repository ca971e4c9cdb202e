# SPDX-License-Identifier: GPL-2.0-or-later
"""The inner loop of the text reader: rows of decimal numbers to float64, streaming and correctly rounded.

A number with at most 15 digits and a small exponent is one exact operation on two exact doubles; longer ones
(``%.17g``) go through a product in twice the precision, whose error (2^-100) changes the rounding in about one of
10^14 numbers. What neither can do (nan, 20 digits, subnormal) is handed back to Python's ``float``.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numba import njit

ROWS_DONE, NEED_MORE, NOT_PLAIN, NEW_ITEM = range(4)
LARGEST_EXPONENT = 290


def _powers_of_ten() -> tuple[np.ndarray, np.ndarray]:
    """10^e for e = -290 … 290 as an unevaluated sum of two doubles (high, low)."""
    exact = [Fraction(10) ** e for e in range(-LARGEST_EXPONENT, LARGEST_EXPONENT + 1)]
    high = [float(value) for value in exact]
    low = [float(value - Fraction(part)) for value, part in zip(exact, high, strict=True)]
    return np.array(high), np.array(low)


POWER_HIGH, POWER_LOW = _powers_of_ten()


def _scaled_py(mantissa, exponent, high, low):
    """mantissa * 10^exponent for |mantissa| < 10^18, |exponent| <= 290, rounded once (Dekker's product)."""
    if mantissa < 9007199254740992 and -22 <= exponent <= 22:
        if exponent < 0:
            return mantissa / high[290 - exponent]
        return mantissa * high[290 + exponent]
    a = float(mantissa)
    a_low = float(mantissa - int(a))
    b = high[290 + exponent]
    product = a * b
    t = 134217729.0 * a
    a1 = t - (t - a)
    a2 = a - a1
    t = 134217729.0 * b
    b1 = t - (t - b)
    b2 = b - b1
    error = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2
    return product + (error + (a * low[290 + exponent] + a_low * b))


def _parse_rows_py(data, position, end, out, row, rows, is_text, high, low):
    """Parse rows into ``out[column, row]`` from ``data[position:end]``.

    Returns (row, position, status): rows done so far; where the next row starts (or the row at fault); one of
    the states above. A row counts only with its newline, so NEED_MORE leaves the position at the row's start.
    """
    columns = out.shape[0]
    while row < rows:
        i = position
        for column in range(columns):
            while i < end and (data[i] == 32 or data[i] == 9):
                i += 1
            if i >= end:
                return row, position, NEED_MORE
            if is_text[column] and data[i] > 32:
                while i < end and data[i] > 32:
                    i += 1
                out[column, row] = np.nan
                if i >= end:
                    return row, position, NEED_MORE
                continue
            if column == 0 and data[i] == 73:  # 'I' of ITEM:
                return row, position, NEW_ITEM
            negative = data[i] == 45
            if negative or data[i] == 43:
                i += 1
            mantissa = 0
            significant = 0
            digits = 0
            exponent = 0
            after_point = False
            while i < end:
                c = np.int64(data[i])
                if 48 <= c <= 57:
                    mantissa = mantissa * 10 + (c - 48)
                    digits += 1
                    if mantissa > 0:
                        significant += 1
                        if significant > 18:
                            return row, position, NOT_PLAIN
                    if after_point:
                        exponent -= 1
                elif c == 46 and not after_point:
                    after_point = True
                else:
                    break
                i += 1
            if i < end and digits > 0 and (data[i] == 101 or data[i] == 69):
                i += 1
                minus = False
                if i < end and (data[i] == 45 or data[i] == 43):
                    minus = data[i] == 45
                    i += 1
                power = 0
                power_digits = 0
                while i < end and 48 <= data[i] <= 57:
                    power = power * 10 + (np.int64(data[i]) - 48)
                    power_digits += 1
                    i += 1
                if i < end and (power_digits == 0 or power_digits > 4):
                    return row, position, NOT_PLAIN
                exponent += -power if minus else power
            if i >= end:
                return row, position, NEED_MORE
            if digits == 0 or data[i] > 32:
                return row, position, NOT_PLAIN
            if mantissa == 0:
                value = 0.0
            elif -LARGEST_EXPONENT <= exponent <= LARGEST_EXPONENT - 20:
                value = _scaled(mantissa, exponent, high, low)
            else:
                return row, position, NOT_PLAIN
            out[column, row] = -value if negative else value
        while i < end and (data[i] == 32 or data[i] == 9 or data[i] == 13):
            i += 1
        if i >= end:
            return row, position, NEED_MORE
        if data[i] != 10:
            return row, position, NOT_PLAIN
        position = i + 1
        row += 1
    return row, position, ROWS_DONE


def _skip_rows_py(data, position, end, row, rows):
    """As `_parse_rows_py`, but only counting lines; NOT_PLAIN before a comment."""
    while row < rows:
        i = position
        while i < end and (data[i] == 32 or data[i] == 9):
            i += 1
        if i < end and data[i] == 73:
            return row, position, NEW_ITEM
        if i < end and data[i] == 35:  # '#'
            return row, position, NOT_PLAIN
        while i < end and data[i] != 10:
            i += 1
        if i >= end:
            return row, position, NEED_MORE
        position = i + 1
        row += 1
    return row, position, ROWS_DONE


_scaled = njit(cache=True, inline="always")(_scaled_py)
parse_rows = njit(cache=True)(_parse_rows_py)
skip_rows = njit(cache=True)(_skip_rows_py)
