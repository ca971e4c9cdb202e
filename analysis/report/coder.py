# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole numbers as text that a page may hold: a range coder with adaptive bits, in digits to the base 124.

A digit is one of `LETTERS`: all of ASCII but those that a browser changes or that may end a script. It holds 6.95 bits,
a letter of base64 6.

The coder keeps an interval: its low end, 0 at first, and its range, 124^4 at first. To put some of ``2^bits`` equal
parts is to make them the interval: ``step = floor(range / 2^bits)``, ``low += start step``, ``range = size step``.
While the range is below 124^3, the first digit of the low end is written, and both are multiplied by 124. The four
digits of the low end come last. (G. N. N. Martin, Range encoding, Video and Data Recording Conference, 1979.)

A number has a context, which holds the odds of `SLOTS` adaptive bits. First comes its bit length n in unary, n ones and
a zero: bits 0 to n of the context. Odds are 4096ths, 2048 at first, and ones lie at the low end. After a one they grow
by 1/32 of what they lack to 4096, after a zero they lose 1/32, both rounded down. Then come n bits as they are, in
parts of 8 and a last one of the rest: the bits below the highest, and the sign, 1 for minus.
"""

import numpy as np
from numba import njit

LETTERS = np.array([code for code in range(128) if code not in b"\0\n\r<"], "u1")
BASE = len(LETTERS)
TOP, LEAST = BASE**4, BASE**3
SLOTS = 32
WORST = 1.2
"""Digits of a number at most, over its bits and one: an adaptive bit takes 7.1 bits at odds of 31/4096."""


def encode(*parts: tuple[np.ndarray, np.ndarray]) -> str:
    """Text of whole numbers, one part after the other.

    Parameters
    ----------
    *parts : (ndarray of int64, ndarray of int64)
        Numbers of at most 31 bits and a sign, and the context of each, from 0, in a shape that goes with theirs.
    """
    sides = zip(*(np.broadcast_arrays(*part) for part in parts), strict=True)
    values, contexts = (np.concatenate([array.ravel() for array in side]) for side in sides)
    odds = np.full((contexts.max(initial=0) + 1) * SLOTS, 2048)
    return LETTERS[_digits(values, contexts, np.frexp(values)[1], odds)].tobytes().decode("ascii")


def digits_of(text: str) -> np.ndarray:
    """The digits of a text, shape (letters,).

    Raises
    ------
    ValueError
        A letter that is none of `LETTERS`.
    """
    codes = np.frombuffer(text.encode("utf-8", "replace"), np.uint8)
    digits = np.searchsorted(LETTERS, codes)
    if (LETTERS[np.minimum(digits, BASE - 1)] != codes).any():
        raise ValueError("the text holds a letter that packed numbers do not have")
    return digits


def _digits_py(values, contexts, lengths, odds):
    """Digits of numbers in their contexts, shape (digits,); `lengths` are their bits without the sign."""
    digits, written, low, span = np.zeros(int(WORST * (lengths + 1).sum()) + 5, np.uint8), 0, 0, TOP
    for number in range(values.size):
        value, slot, length = abs(values[number]), SLOTS * contexts[number], lengths[number]
        plain = (2 * value + (values[number] < 0)) ^ (1 << length)
        ahead, left = length + 1, length
        while ahead + left:
            if ahead:
                ones, bits = odds[slot], 12
                start, size = (0, ones) if ahead > 1 else (ones, 4096 - ones)
                odds[slot] += (4096 - ones) >> 5 if ahead > 1 else -(ones >> 5)
                ahead, slot = ahead - 1, slot + 1
            else:
                bits = min(left, 8)
                left -= bits
                start, size = (plain >> left) & ((1 << bits) - 1), 1
            step = span >> bits
            low, span = low + start * step, size * step
            while span < LEAST:
                digits[written] = low // LEAST  # below 2 BASE, what is above BASE - 1 is carried at the end
                low, span, written = low % LEAST * BASE, span * BASE, written + 1
    for _ in range(4):
        digits[written] = low // LEAST
        low, written = low % LEAST * BASE, written + 1
    for last in range(written - 1, 0, -1):
        digits[last - 1] += digits[last] // BASE
        digits[last] %= BASE
    return digits[:written]


_digits = njit(cache=True)(_digits_py)
