# SPDX-License-Identifier: GPL-2.0-or-later
"""Files changed at random, the same for a seed each time."""

from __future__ import annotations

import json
import random

WORDS = [
    b"0", b"-1", b"1e300", b"-1e300", b"nan", b"inf", b"NaN", b"99999999999999999999", b"", b"x", b"1e-320", b"\x00",
    b"2", b"true", b"null", b"[]", b"{}", b'"12"', b"4_0", b"[[[1]]]", b"\xff", "\uff11\uff12".encode(), b"1,5", b"<g>",
    b"\n",
]  # fmt: skip
"""What takes the place of a word."""
VALUES = [
    None,
    -5,
    0,
    1.5,
    float("nan"),
    float("inf"),
    10**400,
    "x",
    "../../etc",
    "a\nb",
    [],
    {},
    [[[[]]]],
    True,
    [1, "2"],
]
"""What takes the place of a value of JSON."""
LONGEST = 1500
"""Letters of a message: a sentence or two, with places of a temporary folder."""


def mutant(data: bytes, dice: random.Random) -> bytes:
    """A file with bits flipped, parts cut, doubled or moved, or words replaced."""
    changed = bytearray(data)
    for _ in range(dice.choice((1, 1, 2, 3, 20))):
        if not changed:
            break
        place, kind = dice.randrange(len(changed)), dice.randrange(7)
        if kind == 0:
            changed[place] ^= 1 << dice.randrange(8)
        elif kind == 1:
            del changed[place : place + dice.choice((1, 10, 200, len(changed)))]
        elif kind == 2:
            changed[place:place] = changed[place : place + dice.choice((1, 30, 500))]
        elif kind == 3:
            other = dice.randrange(len(changed))
            changed[place:place] = changed[other : other + dice.choice((5, 50))]
        else:
            start = stop = place
            while stop < len(changed) and changed[stop] not in b" \n,;:\"<>[]{}='":
                stop += 1
            while start > 0 and changed[start - 1] not in b" \n,;:\"<>[]{}='":
                start -= 1
            changed[start:stop] = dice.choice(WORDS)
    return bytes(changed)


def tree_mutant(data: bytes, dice: random.Random) -> bytes:
    """A file of JSON that stays one, with a value changed, taken out or put in."""
    whole = json.loads(data)
    for _ in range(dice.choice((1, 1, 2))):
        here = whole
        while isinstance(here, dict | list) and here:
            key = dice.choice(list(here) if isinstance(here, dict) else range(len(here)))
            if not isinstance(here[key], dict | list) or not here[key] or dice.random() < 0.3:
                break
            here = here[key]
        else:
            break
        kind = dice.randrange(5)
        if kind == 0:
            del here[key]
        elif kind == 1 and isinstance(here, list):
            here.append(here[key])
        else:
            here[key] = dice.choice(VALUES)
    return json.dumps(whole).encode()
