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

from lammps_jump.core.library import BYTES, INTEGER, INTEGERS, core, function

LETTERS = np.array([code for code in range(128) if code not in b"\0\n\r<"], "u1")
BASE = len(LETTERS)
TOP, LEAST = BASE**4, BASE**3
SLOTS = 32
WORST = 1.2
"""Digits of a number at most, over its bits and one: an adaptive bit takes 7.1 bits at odds of 31/4096."""

_digits = function("jump_digits", INTEGER, INTEGERS, INTEGERS, INTEGERS, INTEGERS, BYTES, result=INTEGER)


def encode(*parts: tuple[np.ndarray, np.ndarray]) -> str:
    """Text of whole numbers, one part after the other.

    Parameters
    ----------
    *parts : (ndarray of int, ndarray of int)
        Numbers of at most 31 bits and a sign, and the context of each, from 0, in a shape that goes with theirs.
    """
    pairs = [[array.ravel() for array in np.broadcast_arrays(*part)] for part in parts]
    sides = zip(*((one, context, np.frexp(one)[1]) for one, context in pairs), strict=True)
    values, contexts, lengths = (np.concatenate(side, dtype=np.int64) for side in sides)
    if core() is None:
        digits = _digits_of_each(values.tolist(), contexts.tolist(), lengths.tolist())
    else:
        odds = np.full((contexts.max(initial=0) + 1) * SLOTS, 2048)
        digits = np.zeros(int(WORST * (lengths + 1).sum()) + 5, np.uint8)
        digits = digits[: _digits(len(values), values, contexts, lengths, odds, digits)]
    return LETTERS[digits].tobytes().decode("ascii")


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


def _digits_of_each(values: list[int], contexts: list[int], lengths: list[int]) -> np.ndarray:
    """Digits of numbers in their contexts, as the core makes them; `lengths` are their bits without the sign."""
    odds, digits, low, span = [2048] * ((max(contexts, default=0) + 1) * SLOTS), [], 0, TOP
    for value, context, length in zip(values, contexts, lengths, strict=True):
        plain = (2 * abs(value) + (value < 0)) ^ (1 << length)
        slot, left, ahead = SLOTS * context, length, length + 1
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
                digits.append(low // LEAST)  # below 2 BASE, what is above BASE - 1 is carried at the end
                low, span = low % LEAST * BASE, span * BASE
    for _ in range(4):
        digits.append(low // LEAST)
        low = low % LEAST * BASE
    for last in range(len(digits) - 1, 0, -1):
        digits[last - 1] += digits[last] // BASE
        digits[last] %= BASE
    return np.array(digits, np.uint8)
