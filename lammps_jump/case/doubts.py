# SPDX-License-Identifier: GPL-2.0-or-later
"""Doubts about what a case asks for: analyses without their subject, empty windows, a jump's channel and sill, names.

Angles may be like radians. Walls may be such that a flow never meets them. Names may be of what is written on a drawing
and is no wall: dimensions, texts, hatching, centre lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import degrees, inf
from operator import itemgetter
from typing import NamedTuple, TypeGuard

import numpy as np

from lammps_jump.analysis.quantities import LISTED
from lammps_jump.physics import jump
from lammps_jump.scene import InitialState, InletRow, MovingWall, Outlet, Scene, Wall
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.shapes import open_ends
from lammps_jump.scene.tracks import Held, Oscillate, each
from lammps_jump.scene.walls import bed_height

from .beds import RoughBed
from .derived import foot_of, studied
from .discs import Column
from .fields import CaseFields, Probes
from .inflow import RowsInflow
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
    requested = [(name, one.needs) for name, one in LISTED.items() if getattr(case.analysis, name, False)]
    whys = ((name, next((lacking[one] + follows for one, follows in needs.items() if one in lacking), ""))
            for name, needs in requested)  # fmt: skip
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
    """Sentences on what is to begin after the end of the run, and on intervals that are longer than the run."""
    end = case.run.duration
    held = [(f"bodies[{index}].from", f"body '{one.name}' is held", one.begin) for index, one in enumerate(case.bodies)]
    for index, wall in enumerate(case.walls):
        if not isinstance(wall, RoughBed) and wall.motion is not None:
            held.append((f"walls[{index}].motion.from", f"wall '{wall.name}' stands", wall.motion.begin))
    sentences = [
        f"{field}: {what} until {begin:zg} s, and the run ends at {end:zg} s: it never moves; let it go earlier, or "
        "run longer"
        for field, what, begin in held
        if begin >= end
    ]
    return sentences + _no_inflow(case) + _long_intervals(case)


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
    end, sentences = case.run.duration, []
    every = case.run.output_interval
    if every is not None and every > end * (1 + SAME):
        sentences.append(
            f"run.output_interval: {every:zg} s is longer than the run of {end:zg} s, which has a frame at its start "
            "and one at its end; take a part of it"
        )
    interval, probes = case.probes.interval, case.probes
    used = probes.recorded or case.bodies or interval != Probes().interval
    if used and interval > end * (1 + SAME):
        most = min(case.output_interval, end)
        sentences.append(
            f"probes.interval: {interval:zg} s is longer than the run of {end:zg} s; forces are means over the time "
            f"between frames then, {most:z.3g} s: take a part of it, for example {0.1 * most:z.2g} s"
        )
    return sentences


DROWNED = 1.25
"""Depth over the sequent depth from which on a jump is drowned for sure; discs hold up to 1.1 (measured)."""
FASTEST = 1.25
"""Fastest row over the impact speed above which overlaps are doubtful; the 1/7 profile has 1.12."""
UPSTREAM, DOWNSTREAM = 5.0, 3.5
"""Room for a jump: the stream before it in y1; the jump (1.5) and steady tail water (2) in y2 (measured)."""
LOWEST_SILL = 0.55
"""Height of a sill over that of a broad crest that holds the jump of water. In a dry channel discs of `quick_jump` run
over 0.46 of it without a jump, and make one at 0.65 (measured)."""


DEEP = 0.05
"""Overlap over the diameter that an attraction alone may hold: half of what a collision at v0 reaches by default."""


def held_deep(scene: Scene) -> list[str]:
    """A sentence on an attraction that holds discs deep in each other, or none."""
    share = scene.cohesion / scene.coefficients.stiffness / scene.diameter
    if share <= DEEP:
        return []
    return [
        f"contact.cohesion of {scene.cohesion:z.3g} N/m alone holds discs {share:z.2g} diameters deep in each other; "
        f"lower it, or {scene.stiffer}"
    ]


def doubts(case: CaseFields, impact_speed: float, inlets: tuple[InletRow, ...]) -> list[str]:
    """Sentences on what will probably not come out as requested: window and stiffness.

    Parameters
    ----------
    case : CaseFields
    impact_speed : float
        v0 of (3.20), m/s.
    inlets : tuple of InletRow
    """
    sentences, window, duration = [], case.analysis.window, case.run.duration
    if empty := empty_window(case):
        sentences += empty
    elif window and window[1] > duration * (1 + 1e-3):
        sentences.append(
            f"analysis.window ends at {window[1]:zg} s, the run at {duration:zg} s; take a window within the run, or "
            "none for its last quarter"
        )
    elif window and window[1] < 0.5 * duration:
        sentences.append(
            f"analysis.window ends at {window[1]:zg} s and misses the last half of the {duration:zg} s; take a later "
            "one, or none for the last quarter"
        )
    fastest = max((row.vx for row in inlets), default=0.0)
    if case.contact.own_stiffness is None and fastest > FASTEST * impact_speed:
        sentences.append(
            f"the fastest row has {fastest:z.3g} m/s, contact.impact_speed is {impact_speed:z.3g} m/s: discs press "
            f"{fastest / impact_speed:z.2g} times deeper into each other than largest_overlap says; take "
            f"impact_speed: {fastest:z.3g}"
        )
    return sentences


class JumpPlace(NamedTuple):
    """Place of a jump, and the stream there.

    Attributes
    ----------
    x, level : float
        The inlet or the foot of the bed, and the height of the bed there, m.
    words : str
    stream : Inflow
    """

    x: float
    level: float
    words: str
    stream: jump.Inflow


def jump_doubts(case: CaseFields, scene: Scene) -> list[str]:
    """Sentences on a jump that cannot form, has no room, is drowned, or is not held by its sill.

    The stream is that at the foot of the bed or, on a level bed, that of the inlet.
    """
    inflow = case.inflow
    if not isinstance(inflow, RowsInflow) or not (case.analysis.jump and case.gravity):
        return []
    y1, speed = inflow.over(*studied(case))
    if not y1:
        return ["no disc flows in during the window of the analysis, so that it finds no jump; take another window"]
    foot = foot_of(scene, y1, speed, case.gravity)
    if foot is None:
        place = JumpPlace(inflow.x, inflow.y, "inlet", jump.inflow_theory(y1, speed, case.gravity))
    elif foot.stream is None:
        return []
    else:
        place = JumpPlace(foot.x, inflow.y - foot.fall, f"foot of the bed, x = {foot.x:z.3g} m,", foot.stream)
    if place.stream.froude <= 1:
        return [
            f"the inflow is subcritical (Fr = {place.stream.froude:z.3g}), so that no jump forms; Fr must be above 1"
        ]
    sills = [
        (x[0], y[1] - place.level)
        for x, y in (wall.extent for wall in case.walls if not isinstance(wall, RoughBed) and _stands(wall))
        if x[0] > place.x and y[1] > place.level
    ]
    return _room(case, place, sills) + _drowned(case, place, [height for _, height in sills])


def _room(case: CaseFields, place: JumpPlace, sills: list[tuple[float, float]]) -> list[str]:
    """Sentences on a channel that is too short, and on the highest of sills (x and height, m), if it is too low.

    A basin that is full at the start has its jump at once: baffles and a low sill may hold it.
    """
    stream, sentences = place.stream, []
    outlets = [(item.x_beyond, 0.0) for item in case.outflow if item.x_beyond is not None and item.x_beyond > place.x]
    end, sill = max(sills, key=itemgetter(1)) if sills else min(outlets, default=(inf, 0.0))  # baffles are lower
    filled = place.words != "inlet" and any(_lies_behind(item, place) for item in case.initial)
    room = UPSTREAM * stream.depth + DOWNSTREAM * stream.belanger_y2
    if end - place.x < room:
        water = jump.channel_length(stream.froude, stream.depth)
        sentences.append(
            f"the channel is {end - place.x:z.3g} m long from the {place.words} to the sill or outlet; stream, "
            f"jump and tail water need {room:z.3g} m (5 y1 + 3.5 y2; 1.5 Lj of water are {water:z.3g} m)"
        )
    if sills and not filled and sill < LOWEST_SILL * stream.sill:
        sentences.append(
            f"the jet will run over the sill of {sill:z.3g} m without a jump: a broad crest that holds it has "
            f"{stream.sill:z.3g} m, and discs need {LOWEST_SILL * stream.sill:z.3g} m or more"
        )
    return sentences


def _drowned(case: CaseFields, place: JumpPlace, sills: list[float]) -> list[str]:
    """A sentence on a basin whose water is deeper than its stream holds: 1.25 times the sequent depth.

    The water is that at the start beyond the foot, or what the sills (heights, m) dam: the slow depth with the energy
    of the sill and of a critical depth upon it.
    """
    stream, at, near = place.stream, place.x, 0.5 * place.stream.length
    sentence = (
        f"the stream at the {place.words} has {stream.velocity:z.3g} m/s and {stream.depth:z.3g} m and holds "
        f"{stream.belanger_y2:z.3g} m"
    )
    most = DROWNED * stream.belanger_y2
    filled = max(
        (item.y[1] - place.level for item in case.initial if _lies_behind(item, place) and item.x[0] < at + near),
        default=0.0,
    )
    if place.words != "inlet" and filled > most:
        return [f"the basin is drowned at the start: {sentence}, the water is {filled:z.3g} m deep; start with less"]
    crest = max(sills, default=0.0) + 1.5 * jump.critical_depth(stream.velocity * stream.depth, case.gravity)
    if sills and crest > jump.specific_energy(most, stream.velocity * stream.depth / most, case.gravity):
        return [
            f"the sill of {max(sills):z.3g} m will drown the jump: {sentence}, the sill dams more than {most:z.3g} "
            f"m; a sill of {stream.sill:z.3g} m holds it"
        ]
    return []


def _lies_behind(item: object, place: JumpPlace) -> TypeGuard[Column]:
    """Tells whether an item of `initial` is water that reaches over the length of the jump."""
    return isinstance(item, Column) and item.x[1] > place.x + place.stream.length


def _stands(wall: Wall) -> bool:
    """Tells whether a wall is a solid that may be a sill: it ends, discs are around it, and its height is given."""
    return wall.finite and not wall.hollow and not open_ends(wall.faces) and not isinstance(wall.motion, Held)


SAMPLES = 400
"""Places along the ground before a wall that are looked at."""
WIDE = 1.0
"""Width of a gap in the ground from which on it is named, in diameters of the largest disc."""


class Barrier(NamedTuple):
    """A wall that stands on the ground in the way of the flow.

    `side` is 1 where the flow comes to it along x, and -1 against it; `face` is where they meet, m. `x` are places from
    the far end of the flow to the face, and `bed` the height of the ground there without the wall, NaN without any, m.
    """

    wall: Wall
    side: int
    face: float
    x: np.ndarray
    bed: np.ndarray


def never_met(
    case: CaseFields, begun: InitialState, inlets: Sequence[InletRow], walls: Sequence[MovingWall],
    outlets: Sequence[Outlet],
) -> list[str]:  # fmt: skip
    """Sentences on outlets in the flow, and on ground that ends before a wall that stands in its way.

    Parameters
    ----------
    case : CaseFields
    begun : Beginning
    inlets : sequence of InletRow
    walls : sequence of MovingWall
        Without gates that vanish at t = 0.
    outlets : sequence of Outlet
    """
    loose = begun.positions if begun.fixed is None else begun.positions[: begun.fixed.first - 1]
    sentences = _in_the_flow(case, loose, inlets, outlets)
    xs = [*loose[:, 0], *(row.x for row in inlets)]
    if not case.gravity or not xs or case.seam:
        return sentences
    by_reason: dict[object, str] = {}  # an outlet or a gap before several walls is named once
    for barrier in _barriers(walls, begun, (float(min(xs)), float(max(xs)))):
        place = f"wall '{barrier.wall.name}' at x = {barrier.face:zg} m"
        drained = [one for one in outlets if _drains(one, barrier, begun)]
        for one in drained:
            by_reason.setdefault(
                one,
                f"{_field(case, outlets, one)} lies before {place}, in its tail water: it takes out what the wall is "
                "to hold back; move the outlet behind the wall, or below the ground",
            )
        if not drained and (gap := _gap(barrier, begun)):
            near, far = gap
            by_reason.setdefault(
                near,
                f"the ground ends at x = {near:z.4g} m, and {abs(far - near):z.3g} m are without any before {place}: "
                "discs fall through; let the floor reach to the wall",
            )
    return sentences + list(by_reason.values())


def _field(case: CaseFields, outlets: Sequence[Outlet], one: Outlet) -> str:
    """Name of an outlet in the case."""
    index = list(outlets).index(one)
    ((name, at),) = case.outflow[index].model_dump(exclude_none=True).items()
    return f"outflow[{index}].{name}: {at:zg} m"


def _beyond(one: Outlet, places: np.ndarray) -> np.ndarray:
    """Tells whether places, shape (n, 2), lie where an outlet takes discs out."""
    values = places[:, "xy".index(one.axis)]
    return values > one.at if one.side == "above" else values < one.at


def _in_the_flow(
    case: CaseFields, loose: np.ndarray, inlets: Sequence[InletRow], outlets: Sequence[Outlet]
) -> list[str]:
    """Sentences on outlets that discs are beyond at the start, or that an inflow enters beyond."""
    sentences, rows = [], np.array([(row.x, row.y) for row in inlets]).reshape(-1, 2)
    for one in outlets:
        gone, entering = int(_beyond(one, loose).sum()), int(_beyond(one, rows).sum())
        if gone:
            sentences.append(
                f"{_field(case, outlets, one)} takes {gone} of the {len(loose)} discs out at once that are there at "
                "the start, as they stand beyond it; move it out of the flow"
            )
        if entering:
            sentences.append(
                f"{_field(case, outlets, one)} takes discs out as they enter: {entering} of the {len(rows)} rows of "
                "the inflow lie beyond it; move it out of the flow"
            )
    return sentences


def _barriers(walls: Sequence[MovingWall], begun: InitialState, ends: tuple[float, float]) -> Iterator[Barrier]:
    """Solids that rest on the level of the ground before them and rise above it, next to discs that lie there.

    `ends`: least and largest x of the discs and inlets, m.
    """
    for one in walls:
        wall, kind = one.wall, one.motion.kind
        if not (_stays(one) or isinstance(kind, Free)) or not wall.finite or wall.hollow or open_ends(wall.faces):
            continue
        (left, right), (low, top) = one.first.extent
        others = [other.wall for other in walls if other is not one and _stays(other)] + list(begun.beds)
        for side, begin, face in ((1, ends[0], left), (-1, ends[1], right)):
            if side * (face - begin) <= 0:
                continue
            x = np.linspace(begin, face, SAMPLES + 1)[:-1]
            bed = bed_height(others, x, begun.smallest)
            known = bed[np.isfinite(bed)]
            if known.size and low <= known[-1] + begun.smallest and top > known[-1] + begun.largest:
                yield Barrier(wall, side, face, x, bed)


def _stays(one: MovingWall) -> bool:
    """Tells whether a wall stays where it is, but for a gate that holds a flow."""
    return one.motion.kind is None or isinstance(one.motion.kind, Held)


def _drains(one: Outlet, barrier: Barrier, begun: InitialState) -> bool:
    """Tells whether an outlet lies in the flow before a wall: across its way, or above the ground there."""
    if one.axis == "x":
        room = barrier.side * (barrier.face - one.at)
        return (one.side == "above") == (barrier.side > 0) and room > begun.largest
    low = one.side == "below" and np.isfinite(barrier.bed) & (barrier.bed + 0.5 * begun.smallest < one.at)
    return bool(np.any(low))


def _gap(barrier: Barrier, begun: InitialState) -> tuple[float, float] | None:
    """Begin and end of a gap in the ground before a wall, from the side of the flow, m; None where there is none."""
    x, bare = np.append(barrier.x, barrier.face), np.append(np.isnan(barrier.bed), False)
    known = int(np.argmin(bare))  # the first place with ground
    if not bare[known:].any():
        return None
    first = known + int(np.argmax(bare[known:]))
    last = first + int(np.argmin(bare[first:]))
    near, far = float(x[first - 1]), float(x[last])
    return (near, far) if abs(far - near) > WIDE * begun.largest else None
