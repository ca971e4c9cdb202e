# SPDX-License-Identifier: GPL-2.0-or-later
"""The inner loop of the text reader: rows of decimal numbers to float64, streaming and correctly rounded.

The core reads a number with at most 15 digits and a small exponent by one exact operation on two exact doubles; longer
ones (``%.17g``) go through a product in twice the precision, whose error (2^-100) changes the rounding in about one of
10^14 numbers. What neither can do (nan, 20 digits, subnormal) is handed back to Python's ``float``, and so is every
number where there is no core.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from lammps_jump.core.library import BYTES, INTEGER, INTEGERS, REALS, core, entry

ROWS_DONE, NEED_MORE, NOT_PLAIN, NEW_ITEM = range(4)
LARGEST_EXPONENT = 290
NEWLINE, I_OF_ITEM, COMMENT = b"\nI#"
BLANKS = tuple(b" \t")
MANY = 1000
"""Rows that are parsed at once without the core."""

Reached = tuple[int, int, int]
"""Rows done so far; where the next row starts, or the row at fault; one of the states above."""


def _powers_of_ten() -> tuple[np.ndarray, np.ndarray]:
    """10^e for e = -290 … 290 as an unevaluated sum of two doubles (high, low)."""
    exact = [Fraction(10) ** e for e in range(-LARGEST_EXPONENT, LARGEST_EXPONENT + 1)]
    high = [float(value) for value in exact]
    low = [float(value - Fraction(part)) for value, part in zip(exact, high, strict=True)]
    return np.array(high), np.array(low)


_POWERS = _powers_of_ten()
_parse_rows = entry(
    "jump_parse_rows", INTEGER, data=BYTES, end=INTEGER, at=INTEGERS, out=REALS, columns=INTEGER, rows=INTEGER,
    is_text=BYTES, high=REALS, low=REALS,
)  # fmt: skip


def parse_rows(data: np.ndarray, place: tuple[int, int], out: np.ndarray, row: int, is_text: np.ndarray) -> Reached:
    """Parse rows into ``out[column, row]`` from a part of `data` on.

    Parameters
    ----------
    data : ndarray of uint8
    place : (int, int)
        Begin and end of the part.
    out : ndarray of float64, contiguous, shape (columns, rows)
    row : int
        The first that is wanted.
    is_text : ndarray of bool, shape (columns,)
        Columns of words, which become NaN.

    Returns
    -------
    row, position, status : int
        A row counts only with its newline, so NEED_MORE leaves the position at the row's start.
    """
    if core() is None:
        return _parse_lines(data, place, out, row, is_text)
    reached = np.array([row, place[0]])
    (columns, rows), (high, low) = out.shape, _POWERS
    status = _parse_rows(
        data=data, end=place[1], at=reached, out=out, columns=columns, rows=rows, is_text=is_text.view(np.uint8),
        high=high, low=low,
    )  # fmt: skip
    return int(reached[0]), int(reached[1]), status


def skip_rows(data: np.ndarray, place: tuple[int, int], row: int, rows: int) -> Reached:
    """As `parse_rows`, but only counting lines, up to row `rows`; NOT_PLAIN before a comment."""
    starts, status = _lines(data, place, rows - row)
    return row + len(starts) - 1, int(starts[-1]), status


def _lines(data: np.ndarray, place: tuple[int, int], most: int) -> tuple[np.ndarray, int]:
    """Starts of at most so many whole lines, and where the last one ends; what stops the counting."""
    begin, end = place
    ends = np.flatnonzero(data[begin:end] == NEWLINE)[:most] + begin + 1
    starts = np.concatenate([[begin], ends])
    place_of = starts[starts < end]
    while (blank := np.isin(data[place_of], BLANKS) & (place_of < end - 1)).any():
        place_of = place_of + blank
    stops = np.flatnonzero(np.isin(data[place_of], (I_OF_ITEM, COMMENT)))
    if stops.size and stops[0] < most:
        return starts[: stops[0] + 1], NEW_ITEM if data[place_of[stops[0]]] == I_OF_ITEM else NOT_PLAIN
    return starts, ROWS_DONE if len(ends) == most else NEED_MORE


def _parse_lines(data: np.ndarray, place: tuple[int, int], out: np.ndarray, row: int, is_text: np.ndarray) -> Reached:
    """As `parse_rows`, by Python's ``float``, some rows at once."""
    starts, status = _lines(data, place, out.shape[1] - row)
    for first in range(0, len(starts) - 1, MANY):
        some = starts[first : first + MANY + 1]
        lines = data[some[0] : some[-1] - 1].tobytes().split(b"\n")
        for number, line in enumerate(lines):
            tokens = line.split()
            try:
                if len(tokens) != len(out) or b"_" in line:
                    raise ValueError
                out[:, row] = [np.nan if text else float(token) for text, token in zip(is_text, tokens, strict=True)]
            except ValueError:
                return row, int(some[number]), NOT_PLAIN
            row += 1
    return row, int(starts[-1]), status
