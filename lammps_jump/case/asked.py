# SPDX-License-Identifier: GPL-2.0-or-later
"""Requests that a case cannot have: analyses without their subject, empty windows, times behind the end, odd names.

Angles may be like radians. Names may be of what is written on a drawing and is no wall: dimensions, texts, hatching,
centre lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import degrees

from lammps_jump.analysis.quantities import LISTED
from lammps_jump.scene import MovingWall
from lammps_jump.scene.tracks import Oscillate, each

from .discs import Column
from .fields import CaseFields
from .measures import Probes
from .parts.beds import RoughBed
from .parts.inflow import RowsInflow
from .speeds import LEAST_FRICTION

RIGHT_ANGLE = 0.1
"""Distance in degrees from a multiple of 90 at which a value times 180/pi is taken for a right angle: 3.14 is."""
LIGHT = 0.5, 23.0
"""Densities in kg/m^3 that are those of solids and liquids in g/cm^3."""
BIN = 2.0
"""Width of a bin that is advised, in diameters."""
OTHER_ANGLE = 0.01
"""The same for multiples of 15 degrees."""


def facts(case: CaseFields, walls: Sequence[MovingWall]) -> dict[str, tuple[bool, str]]:
    """Properties of a scene that analyses need, by the names in `LISTED`, and how their lack is said."""
    ends = [wall for wall in case.walls if not isinstance(wall, RoughBed) and wall.finite]
    rubs = case.contact.friction >= LEAST_FRICTION or any((wall.friction or 0) > 0 for wall in ends)
    return {
        "gravity": (bool(case.gravity), "gravity is 0"),
        "rows": (case.inflow is not None and case.inflow.kind == "rows", "no rows flow in (inflow: {kind: rows, …})"),
        "column": (any(isinstance(item, Column) for item in case.initial), "no column stands at the start"),
        "turning wall": (any(one.kind is not None and one.kind.turns for _, one in walls), "no wall turns"),
        "gap": (len(ends) > 1, "there are no two walls that could leave a gap between them"),
        "friction": (rubs, f"with a friction below {LEAST_FRICTION:zg}"),
    }


def in_vain(case: CaseFields, walls: Sequence[MovingWall]) -> list[str]:
    """Sentences on analyses for which the scene has nothing."""
    lacking = {name: said for name, (there, said) in facts(case, walls).items() if not there}
    asked = [(name, one.needs) for name, one in LISTED.items() if getattr(case.analysis, name, False)]
    whys = ((name, next((lacking[one] + follows for one, follows in needs.items() if one in lacking), ""))
            for name, needs in asked)  # fmt: skip
    return [f"analysis.{name}: {why}; drop it" for name, why in whys if why]


def empty_window(case: CaseFields) -> list[str]:
    """A sentence on a window that holds no frame."""
    window, duration = case.analysis.window, case.run.duration
    if not window:
        return []
    begin = 0.0 - case.settling[0]
    if window[0] >= duration * (1 + 1e-3) or window[1] < begin:
        return [
            f"analysis.window [{window[0]:zg}, {window[1]:zg}] s holds no frame of the run, which goes from "
            f"{begin:zg} to {duration:zg} s: no mean can be taken; take a window within, or none for the last quarter"
        ]
    if window[1] - window[0] < case.output_interval:
        return [
            f"analysis.window [{window[0]:zg}, {window[1]:zg}] s is shorter than the time between frames, "
            f"{case.output_interval:z.3g} s: it may hold none; widen it, or lower run.output_interval"
        ]
    return []


def small_bins(case: CaseFields, largest: float) -> list[str]:
    """A sentence on bins of profiles that are narrower than the largest disc (m)."""
    width = case.analysis.bin_width
    if width is None or width >= largest:
        return []
    return [
        f"analysis.bin_width: {width:zg} m is less than a disc, {largest:z.3g} m: a bin holds parts of single discs, "
        f"and so are its depth and velocity; take {BIN:zg} diameters, {BIN * largest:z.2g} m, or more"
    ]


def radians_given(case: CaseFields) -> list[str]:
    """Sentences on angles that look like radians: all are in degrees."""
    return [
        f"{field}: {value:zg} is in degrees; if radians are meant, write {round(degrees(value)):zg}"
        for field, value in _angles(case)
        if _like_radians(value)
    ]


def light(case: CaseFields) -> list[str]:
    """A sentence on a density that looks like one in g/cm3."""
    density = case.discs.density
    if not LIGHT[0] <= density <= LIGHT[1]:
        return []
    return [f"discs.density: {density:zg} is in kg/m^3; if g/cm^3 are meant, write {1000 * density:zg}"]


def _angles(case: CaseFields) -> Iterator[tuple[str, float]]:
    """Angles of a case with their fields."""
    yield "slope", case.slope
    for index, wall in enumerate(case.walls):
        if isinstance(wall, RoughBed):
            continue
        yield f"walls[{index}].angle", getattr(wall, "angle", 0.0)
        if isinstance(wall.motion, Oscillate):
            yield from ((f"walls[{index}].motion.phase", phase) for phase in dict.fromkeys(each(wall.motion.phase)))
            yield f"walls[{index}].motion.angle", wall.motion.angle


def _like_radians(value: float) -> bool:
    """Tells whether a number is nearly a right angle in radians, or, with more digits, a multiple of 15 degrees."""
    if not 0.2 < abs(value) < 6.5 or round(value, 1) == value:
        return False
    angle = abs(degrees(value))
    right, other = 90 * round(angle / 90), 15 * round(angle / 15)
    return (right > 0 and abs(angle - right) < RIGHT_ANGLE * right / 90) or abs(angle - other) < OTHER_ANGLE


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


SAME = 1e-3
"""Share by which a time may be longer than the run and still count as its end."""


def behind_the_end(case: CaseFields) -> list[str]:
    """Sentences on what is to begin behind the end of the run, and on intervals that are longer than the run."""
    end = case.run.duration
    held = [(f"bodies[{index}].from", f"body '{one.name}' is held", one.begin) for index, one in enumerate(case.bodies)]
    for index, wall in enumerate(case.walls):
        if not isinstance(wall, RoughBed) and wall.motion is not None:
            held.append((f"walls[{index}].motion.from", f"wall '{wall.name}' stands", wall.motion.begin))
    found = [
        f"{field}: {what} until {begin:zg} s, and the run ends at {end:zg} s: it never moves; let it go earlier, or "
        "run longer"
        for field, what, begin in held
        if begin >= end
    ]
    return found + _no_inflow(case) + _long_intervals(case)


def _no_inflow(case: CaseFields) -> list[str]:
    """A sentence on a table of an inflow that lets no disc in while the run lasts."""
    inflow, end = case.inflow, case.run.duration
    if not isinstance(inflow, RowsInflow) or not inflow.table or inflow.hydrograph.means(0.0, end)[1] > 0:
        return []
    return [
        f"the inflow.table lets no disc in before the run ends at {end:zg} s; begin its flow earlier, or run longer"
    ]


def _long_intervals(case: CaseFields) -> list[str]:
    """Sentences on intervals of frames and of forces that are longer than the run."""
    end, found = case.run.duration, []
    asked = case.run.output_interval
    if asked is not None and asked > end * (1 + SAME):
        found.append(
            f"run.output_interval: {asked:zg} s is longer than the run of {end:zg} s, which has a frame at its start "
            "and one at its end; take a part of it"
        )
    interval, probes = case.probes.interval, case.probes
    used = probes.recorded or case.bodies or interval != Probes().interval
    if used and interval > end * (1 + SAME):
        most = min(case.output_interval, end)
        found.append(
            f"probes.interval: {interval:zg} s is longer than the run of {end:zg} s; forces are means over the time "
            f"between frames then, {most:z.3g} s: take a part of it, for example {0.1 * most:z.2g} s"
        )
    return found
