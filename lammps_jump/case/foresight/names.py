# SPDX-License-Identifier: GPL-2.0-or-later
"""Names of what is written on a drawing and is no wall: dimensions, texts, hatching, centre lines."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lammps_jump.scene import MovingWall

WRITTEN = frozenset(
    """
    dim dims dimension dimensions dimensioning
    bemassung bemaßung bemassungen bemaßungen masse maße maß masslinien maßlinien
    cote cotes cotation cotations quota quote quotas quotatura cota cotas acotado acotacion acotación kote koten
    text texts texte txt label labels beschriftung annotation annotations anno notes
    hatch hatching schraffur hachures titleblock schriftfeld
    centerline centreline centerlines centrelines mittellinie defpoints viewport viewports
    """.split()
)
"""Words of layers in English, German, French, Italian and Spanish; AutoCAD never prints its layer Defpoints."""


def is_written(name: str) -> bool:
    """Tells whether a layer or wall is named like what is written on a drawing."""
    words = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name))
    return any(word.lower() in WRITTEN for word in (*words, "".join(words)))


def written_walls(walls: Sequence[MovingWall], own: Sequence[str]) -> list[str]:
    """A sentence on walls of the case, `own`, that are named like what is written on a drawing."""
    named = [one.wall.name for one in walls if one.wall.name in own and is_written(one.wall.name)]
    if not named:
        return []
    names = ", ".join(f"'{name}'" for name in named[:4]) + (f" and {len(named) - 4} more" if len(named) > 4 else "")
    several = len(named) > 1
    return [
        f"wall{'s' if several else ''} {names} {'are' if several else 'is'} named like dimensions, texts or axes of a "
        f"drawing, and discs collide with {'them' if several else 'it'}: drop what is no wall, or rename it"
    ]
