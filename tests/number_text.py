# SPDX-License-Identifier: GPL-2.0-or-later
"""What a page does with the text of `lammps_jump.analysis.report.frames`, in whole numbers of Python."""

from collections.abc import Callable


def numbers_in(text: str) -> Callable[[int], int]:
    """What takes the next number of a text, in its context: `report.frames` backwards."""
    letters = "".join(chr(code) for code in range(128) if chr(code) not in "\0\n\r<")
    digits, base = [letters.index(letter) for letter in text], len(letters)
    code, span, at = sum(digit * base ** (3 - k) for k, digit in enumerate(digits[:4])), base**4, 4
    odds: dict[tuple[int, int], int] = {}

    def shrink(start: int, size: int, step: int) -> None:
        nonlocal code, span, at
        code, span = code - start * step, size * step
        while span < base**3:
            code, span, at = code * base + digits[at], span * base, at + 1

    def number(context: int) -> int:
        left, more = 0, True
        while more:
            slot, step = (context, left), span // 4096
            ones = odds.get(slot, 2048)
            more = code < ones * step
            odds[slot] = ones + (4096 - ones) // 32 if more else ones - ones // 32
            shrink(*((0, ones) if more else (ones, 4096 - ones)), step)
            left += more
        value = int(left > 0)
        while left:
            bits = min(left, 8)
            part, step = code // (span >> bits), span >> bits
            shrink(part, 1, step)
            value, left = value * 2**bits + part, left - bits
        return -(value // 2) if value % 2 else value // 2

    return number
