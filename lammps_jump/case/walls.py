# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a case: lines that are joined, motions, contacts of their own, gates, groups; and doubts about them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, isinf, pi, sqrt
from typing import Any, Literal, cast

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.physics import contact
from lammps_jump.physics.bodies import section_of_polygon
from lammps_jump.scene import Block, InitialState, InletRow, Interval, MovingWall, Plane, Scene, Wall, gate
from lammps_jump.scene.chains import TX0, TY0, Point, boxes
from lammps_jump.scene.meeting import stiffness_between
from lammps_jump.scene.motion import Motion, arms, largest_speed, way
from lammps_jump.scene.pressed import MOST_INTERVALS, FaceStretch, bins_of, gauge_of
from lammps_jump.scene.scene import WallWeight
from lammps_jump.scene.shapes import (
    ArcTo,
    PlaceError,
    flush,
    open_ends,
    over_each_other,
    pairs_that_may_touch,
    tight_bend,
    vertices,
)
from lammps_jump.scene.tracks import Held, Loaded, Translate
from lammps_jump.scene.walls import Line

from .beds import RoughBed
from .bodies import Body
from .discs import Column
from .earlier import Pushable
from .fields import CaseFields
from .text import nearest

EASE = 10.0
"""Time that a change of velocity takes by default, in contact times pi/omega of the wall."""
SAME_END = 1e-6
"""Distance of two ends over which lines are joined, m; also a share of their coordinates."""
TIGHTEST_ARC, TIGHTEST_LINE = 1.05, 1.5
"""Radius of a bend towards the discs over that of the largest disc: of an arc, at least; of a line of short pieces,
below which a disc loses energy at its joints (measured)."""
SLOW = 0.5
"""Speed of a wall over R omega above which a disc may pass through it."""


Laws = Mapping[str, contact.WallLaw]
"""Contacts of walls that have their own, by name."""


@dataclass(frozen=True)
class CaseWall:
    """A wall, the field of the case that it comes from, and what it is as a body."""

    wall: Wall
    field: str
    body: Body | None = None


def joined(case: CaseFields) -> tuple[CaseWall, ...]:
    """The walls of a case, followed by its bodies; lines of one join are one wall, in the place of the first."""
    walls: list[CaseWall] = []
    done: set[str] = set()
    for index, wall in enumerate(case.walls):
        if isinstance(wall, RoughBed):
            continue
        join = getattr(wall, "join", None)
        if join is None:
            walls.append(CaseWall(wall, f"walls.{index}"))
        elif join not in done:
            done.add(join)
            walls.append(CaseWall(_joined(case, join), f"walls.{index}"))
    walls += [CaseWall(body.wall(), f"bodies.{index}", body) for index, body in enumerate(case.bodies)]
    for index, item in enumerate(walls):
        if item.wall.name in [other.wall.name for other in walls[:index]]:
            raise FieldError(
                f"{item.field}.join", f"another wall is called '{item.wall.name}'; give the join another name"
            )
    return tuple(walls)


def _joined(case: CaseFields, join: str) -> Line:
    """Lines of one join as one line, which goes from one to the next where ends meet."""
    lines = {i: cast(Line, wall) for i, wall in enumerate(case.walls) if getattr(wall, "join", None) == join}
    first, *others = lines
    if not others:
        raise FieldError(f"walls.{first}.join", f"no other line has join: {join}; drop it, or name the others too")
    for index in others:
        for name in ("sheet", "friction", "restitution", "stiffness", "rolling", "motion"):
            if getattr(lines[index], name) != getattr(lines[first], name):
                raise FieldError(
                    f"walls.{index}.{name}",
                    f"differs from that of '{lines[first].name}'; lines of one join have one {name}",
                )
    ends = {i: (line.path.points[0], line.path.points[-1]) for i, line in lines.items()}
    for index, line in lines.items():
        if line.path.closed:
            raise FieldError(f"walls.{index}.join", f"'{line.name}' is closed and has no ends; drop join")
    starts = [i for i in lines if not any(_meet(ends[i][0], ends[j][1]) for j in lines if j != i)]
    order = [starts[0] if starts else first]
    while len(order) < len(lines):
        here = ends[order[-1]][1]
        left = [i for i in lines if i not in order]
        after = next((i for i in left if _meet(here, ends[i][0])), None)
        if after is None:
            raise _unjoined(lines, ends, order, left)
        order.append(after)
    points: list[Any] = list(lines[order[0]].points)
    for index in order[1:]:
        points += lines[index].points[1:]
    if _meet(ends[order[0]][0], ends[order[-1]][1]):  # one ring
        begin, last = lines[order[0]].path.points[0], points[-1]
        points[-1] = ArcTo(begin, last.radius) if isinstance(last, ArcTo) else begin
    try:
        return replace(lines[order[0]], name=join, points=tuple(points), join=None)
    except PlaceError as error:
        raise FieldError(f"walls.{first}.join", f"lines of '{join}': {error}") from None


def _meet(one: Sequence[float], two: Sequence[float]) -> bool:
    return all(abs(a - b) <= SAME_END * max(1.0, abs(a)) for a, b in zip(one, two, strict=True))


def _unjoined(
    lines: dict[int, Line], ends: Mapping[int, tuple[Point, Point]], order: list[int], left: list[int]
) -> FieldError:
    """Sentence on what is wrong with lines of a join that have no order."""
    last, here = lines[order[-1]], ends[order[-1]][1]
    for index in left:
        if _meet(here, ends[index][1]) or _meet(ends[order[0]][0], ends[index][0]):
            return FieldError(
                f"walls.{index}.points",
                f"'{lines[index].name}' runs the other way than '{last.name}'; reverse its "
                "points, so that the discs are on the left of both",
            )
    gap, index = min((hypot(*np.subtract(here, ends[i][0])), i) for i in left)
    return FieldError(
        f"walls.{index}.join",
        f"no line of join '{lines[index].join}' begins at ({here[0]:zg}, {here[1]:zg}) m, where '{last.name}' "
        f"ends; '{lines[index].name}' begins {gap:z.3g} m away: give both the same point",
    )


def lifted(case: CaseFields) -> tuple[CaseWall, ...]:
    """Gates that rise from t = 0 on: sheets over the height of their columns."""
    walls = []
    for index, item in enumerate(case.initial):
        if isinstance(item, Column) and not isinstance(item.gate, bool):
            height = item.y[1] - item.y[0]
            time = item.gate.time(height)
            wall = Block(gate_name(index), (item.x[1], item.x[1]), item.y)
            walls.append(
                CaseWall(replace(wall, motion=Translate((0.0, height / time), until=time)), f"initial.{index}.gate")
            )
    return tuple(walls)


def gate_name(index: int) -> str:
    """Name of the gate before a column."""
    return f"gate_{index}" if index else "gate"


def shut_gates(case: CaseFields, begun: InitialState, domain: tuple[Interval, Interval]) -> tuple[MovingWall, ...]:
    """Gates that vanish at t = 0. A gate with discs beyond it is a block without thickness, which both sides feel."""
    gates = []
    for index, item in enumerate(case.initial):
        if not (isinstance(item, Column) and item.gate is True and begun.settle_steps):
            continue
        name, x = gate_name(index), item.x[1]
        if begun.positions[:, 0].max(initial=x) > x:
            gates.append(gate(Block(name, (x, x), domain[1]), begun.settle_steps))
        else:
            gates.append(gate(Plane(name, "x", x, "below"), begun.settle_steps))
    return tuple(gates)


def law_of(name: str, begun: InitialState, laws: Laws) -> contact.WallLaw:
    """Contact with the wall of that name."""
    return laws.get(name, begun.coefficients.wall_law)


def check_own_laws(
    case: CaseFields, begun: InitialState, laws: Laws, walls: tuple[CaseWall, ...], integrator: str
) -> list[str]:
    """Refuse a wall that is too stiff for the step, and friction without damping for discs of several sizes."""
    fraction, notes = case.run.time_step_fraction, []
    for item in walls:
        law = laws.get(item.wall.name)
        if law is None:
            continue
        if law.rolling is not None and case.contact.rolling is None:
            raise FieldError(
                f"{item.field}.rolling",
                f"wall '{item.wall.name}' has rolling friction, but contact.rolling is null; "
                "give contact.rolling too, with friction 0 if discs alone do not resist rolling",
            )
        if begun.sizes and law.friction and not law.gamma_normal and not case.contact.springs:
            raise FieldError(
                f"{item.field}",
                f"wall '{item.wall.name}' has friction {law.friction:zg} and restitution 1; with "
                "discs.sizes the tangential dashpot is a multiple of the normal one, which is 0 then: allowed is "
                "friction 0, restitution below 1, or equal discs",
            )
        limit = contact.own_stable_fraction(begun.coefficients, law, begun.smallest / begun.diameter, integrator)
        if fraction > limit and not case.run.allow_unstable:
            raise FieldError(
                f"{item.field}.stiffness",
                f"{law.stiffness:zg} N/m is too stiff for run.time_step_fraction {fraction:zg}; at this wall allowed "
                f"is a fraction up to {limit:z.3f}: lower one of the two, or set run.allow_unstable: true",
            )
        if fraction > 0.8 * limit:
            notes.append(
                f"time_step_fraction {fraction:zg} is close to the limit of stability {limit:z.3f} at wall "
                f"'{item.wall.name}'"
            )
    return notes


def moving(item: CaseWall, case: CaseFields, begun: InitialState, laws: Laws) -> MovingWall:
    """A wall with its motion."""
    wall, kind = item.wall, item.wall.motion
    if item.body is not None:
        return _gone_on(item.body.moving(case.acceleration, begun), begun)
    if kind is None:
        return MovingWall(wall)
    if kind.turns and not wall.finite:
        raise FieldError(
            f"{item.field}.motion", f"wall '{wall.name}' has no end, so that it cannot turn; take a block or a line"
        )
    rate = contact.angular_frequency(law_of(wall.name, begun, laws).stiffness, begun.coefficients.mass)
    ease = EASE * pi / rate if kind.eased else 0.0
    about = kind.about or wall.pivot_point
    return _gone_on(MovingWall(wall, Motion(inf, kind, about, ease, begun.settle_steps, begun.time_step)), begun)


def _gone_on(one: MovingWall, begun: InitialState) -> MovingWall:
    """A wall with what it has of an earlier run, in which it was released."""
    went = begun.earlier.walls.get(one.wall.name) if begun.earlier else None
    if went is None or one.motion.kind is None:
        return one
    kind = replace(one.motion.kind, begin=-inf)
    return MovingWall(one.wall, replace(one.motion, kind=kind, went=went))


def pushed(case: CaseFields) -> list[Pushable]:
    """Walls of a case whose pose is state: bodies, lids and tailgates."""
    pushables = []
    for item in joined(case):
        body, motion = item.body, item.wall.motion
        if body is not None:
            pushables.append(Pushable(item.wall, "free", body.hinge or body.section.centre, body.begin))
        elif isinstance(motion, (Loaded, Held)):
            pushables.append(Pushable(item.wall, motion.kind, motion.about or item.wall.pivot_point, motion.begin))
    return pushables


def span(begun: InitialState | Scene) -> Interval:
    """Times of the first and the last step, s."""
    return begun.time(0), begun.time(begun.steps)


def reachable(one: MovingWall, begun: InitialState, domain: tuple[Interval, Interval]) -> bool:
    """Tells whether any centre inside the domain can touch the wall, wherever it is on its way."""
    if one.motion.is_state:
        return True
    ((xlo, xhi), (ylo, yhi)), reach = domain, begun.largest / 2
    if one.motion.kind is None:
        box = boxes(one.wall.faces, deep=False)
    else:
        box = np.array([[end for pair in way(one, *span(begun)) for end in pair]])
    near = (box[:, 0] - reach < xhi) & (box[:, 1] + reach > xlo) & (box[:, 2] - reach < yhi) & (box[:, 3] + reach > ylo)
    return bool(near.any())


def groups(case: CaseFields, moving: Sequence[MovingWall], taken: set[str]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Groups of walls whose forces are summed; `taken`: further names that a group must not have."""
    by_name = {one.wall.name: one for one in moving}
    for name, members in case.probes.groups.items():
        place = f"probes.groups.{name}"
        if name in taken or name in by_name:
            raise FieldError(place, "is the name of a wall or of a part of one; give the group another name")
        if not members:
            raise FieldError(place, "holds no wall; name one or more")
        for index, member in enumerate(members):
            require_wall(case, f"{place}.{index}", member, list(by_name))
            if member in members[:index]:
                raise FieldError(f"{place}.{index}", f"'{member}' stands twice, so that its force would count twice")
        arms(name, [by_name[member] for member in members])
    return tuple(case.probes.groups.items())


def weighed(case: CaseFields, moving: Sequence[MovingWall]) -> tuple[tuple[str, WallWeight], ...]:
    """Walls that are looked at as if they had a weight: those at rest, with an outline of some area."""
    by_name = {one.wall.name: one for one in moving}
    for name in case.probes.stability or {}:
        place = f"probes.stability.{name}"
        require_wall(case, place, name, list(by_name))
        wall, motion = by_name[name]
        if motion.free:
            raise FieldError(place, f"'{name}' is a body: it has its own weight and friction; leave the entry out")
        if motion.kind:
            raise FieldError(place, f"wall '{name}' moves; only a wall that stands can be given a weight")
        if not wall.finite or wall.hollow or len(chains := wall.chains()) != 1 or not chains[0].closed:
            raise FieldError(place, f"wall '{name}' has no outline with an area; give a block or a polygon a weight")
        if not section_of_polygon(wall.outline((0.0, 0.0), (0.0, 0.0))[0]).area > 0:
            raise FieldError(place, f"wall '{name}' has no thickness, so that it weighs nothing; give it one")
    weights = (case.probes.stability or {}).items()
    return tuple((name, WallWeight(one.density, one.friction)) for name, one in weights)


SUNK, LIFTED = 0.5, 1.0
"""Diameters by which the lowest corner of a wall with a weight may lie in or above its support."""


def weight_doubts(case: CaseFields, moving: Sequence[MovingWall], begun: InitialState) -> list[str]:
    """Walls with a weight that are drawn into their floor or above it, and a moving mean that no run has."""
    notes, mean = [], case.probes.stability_mean
    if mean is not None and mean > case.run.duration:
        notes.append(
            f"probes.stability_mean: {mean:zg} s is longer than the run ({case.run.duration:zg} s), which has no mean "
            "over it; the least factors of means will be absent"
        )
    down = np.array(case.acceleration)
    for name in (case.probes.stability or {}) if down.any() else ():
        wall = next(one.wall for one in moving if one.wall.name == name)
        corners = wall.outline((0.0, 0.0), (0.0, 0.0))[0]
        corner = corners[int(np.argmax(corners @ down))]
        others = [other for one in moving if one.wall.name != name and (other := one.at(0)) is not None]
        apart = {other.name: float(other.distance(*corner)) for other in others}
        nearest_wall = min(apart, key=lambda other: apart[other], default="")
        off = apart.get(nearest_wall, inf)
        if off < -SUNK * begun.smallest:
            notes.append(
                f"probes.stability.{name}: its base lies {-off:z.3g} m inside '{nearest_wall}'; weight and toes are "
                "those of the whole outline, so draw it from where it stands"
            )
        elif off > LIFTED * begun.smallest:
            where = f"{off:z.3g} m above '{nearest_wall}'" if isfinite(off) else "on no wall"
            notes.append(
                f"probes.stability.{name}: its base lies {where}; factors of safety are those of a structure that "
                "stands"
            )
    return notes


def pressed(
    case: CaseFields, moving: Sequence[MovingWall], domain: tuple[Interval, Interval]
) -> tuple[FaceStretch, ...]:
    """Stretches of outlines whose pressure is requested, in the order of the walls."""
    by_name, face_pressures = {one.wall.name: one.wall for one in moving}, case.probes.pressure or {}
    for name, one in face_pressures.items():
        place = f"probes.pressure.{name}"
        require_wall(case, place, name, list(by_name))
        if one.bins is None and not one.points:
            raise FieldError(place, "asks for nothing; give it bins, or points")
        if len(by_name[name].chains()) != 1:
            raise FieldError(place, f"the outline of wall '{name}' has several parts; pressure is along one alone")
    stretches = []
    for name, wall in by_name.items():
        if name in face_pressures:
            one, room = face_pressures[name], _room_along(wall, list(by_name.values()), domain)
            stretches += bins_of(wall, one.bins, room) if one.bins else []
            stretches += [gauge_of(wall, point, one.over * case.discs.diameter, room) for point in one.points]
    if len(stretches) > MOST_INTERVALS:
        raise FieldError(
            "probes.pressure",
            f"{len(stretches)} bins and gauges are asked for; allowed are {MOST_INTERVALS}: take fewer",
        )
    return tuple(stretches)


def _room_along(wall: Wall, walls: Sequence[Wall], domain: tuple[Interval, Interval]) -> Interval | None:
    """Stretch of an endless wall along its outline, m: in the domain, between planes; None of others."""
    if wall.finite:
        return None
    along = _runs_along(wall)
    low, high = domain["xy".index(along)]
    for one in walls:
        if not one.finite and _runs_along(one) != along:
            low, high = max(low, one.room(along)[0]), min(high, one.room(along)[1])
    way = wall.faces.shape[0, TX0 if along == "x" else TY0]
    ends = sorted((float(low * way), float(high * way)))
    return ends[0], ends[1]


def _runs_along(wall: Wall) -> Literal["x", "y"]:
    """Axis that an endless wall runs along."""
    tangent = wall.faces.shape[0]
    return "x" if abs(tangent[TX0]) > abs(tangent[TY0]) else "y"


def require_wall(case: CaseFields, place: str, name: str, walls: Sequence[str]) -> None:
    """FieldError where there is no wall of this name."""
    if name in walls:
        return
    parts = [join for wall in case.walls if wall.name == name and (join := getattr(wall, "join", None))]
    if parts:
        raise FieldError(place, f"line '{name}' is a part of the joined wall '{parts[0]}'; name that one")
    hint = nearest(name, list(walls)) if walls else "this case has no walls"
    raise FieldError(place, f"there is no wall '{name}'; {hint}")


def check_bends(walls: tuple[CaseWall, ...], largest: float) -> None:
    """Refuse arcs that bend so tightly towards the discs that the largest one does not fit."""
    least = TIGHTEST_ARC * largest / 2
    for item in walls:
        for field, radius in item.wall.bends_given():
            if radius < least:
                raise FieldError(
                    f"{item.field}.{field}",
                    f"the arc of radius {radius:zg} m bends towards the discs, and the largest "
                    f"one of {largest / 2:zg} m does not fit; allowed is {least:z.4g} m or more: widen the arc",
                )


def wall_doubts(walls: Sequence[MovingWall], begun: InitialState, laws: Laws, inlets: Sequence[InletRow]) -> list[str]:
    """Sentences on walls: too fast for the discs, bent too tightly, ends that meet or nearly meet."""
    sentences = [text for one in walls for text in _doubts_of(one, begun, laws, inlets)]
    for first, second in pairs_that_may_touch([one.wall.faces for one in walls]):
        one, two = walls[first].wall, walls[second].wall
        if one.motion != two.motion:
            continue
        if at := flush(one.faces, two.faces):
            sentences.append(
                f"walls '{one.name}' and '{two.name}' meet flush at ({at[0]:zg}, {at[1]:zg}) m: a disc there "
                "feels both, up to twice the force; make them one wall"
                + (", or give both the same join" if open_ends(one.faces) and open_ends(two.faces) else "")
            )
        elif at := over_each_other(one.faces, two.faces):
            sentences.append(
                f"walls '{one.name}' and '{two.name}' lie flush on each other at ({at[0]:zg}, {at[1]:zg}) m: a disc "
                "there feels both, twice the force; let one of them end there, or make them one wall"
            )
    return sentences + _gap_doubts([one.wall for one in walls], begun.smallest)


def _doubts_of(one: MovingWall, begun: InitialState, laws: Laws, inlets: Sequence[InletRow]) -> list[str]:
    """Sentences on one wall."""
    sentences = _speed_doubt(one, begun, laws) + _bend_doubt(one.wall, begun.largest)
    return sentences + _behind_doubt(one.wall, begun, inlets)


def _behind_doubt(wall: Wall, begun: InitialState, inlets: Sequence[InletRow]) -> list[str]:
    """A line that pushes no disc, because all start behind it: it may run the wrong way."""
    places = np.array([*begun.positions, *((row.x, row.y) for row in inlets)]).reshape(-1, 2)
    if not len(places) or not open_ends(wall.faces) or (wall.distance(*places.T) > -begun.smallest / 2).any():
        return []
    return [
        f"all discs start behind line '{wall.name}', which pushes discs on its left alone: if they should feel it, "
        "reverse its points, or take sheet: true"
    ]


def _speed_doubt(one: MovingWall, begun: InitialState, laws: Laws) -> list[str]:
    """Speed at which discs may pass through a moving wall."""
    wall, speed = one.wall, largest_speed(one, *span(begun))
    omega = contact.angular_frequency(law_of(wall.name, begun, laws).stiffness, begun.coefficients.mass)
    limit = 0.5 * begun.diameter * omega
    if wall.deep or speed <= SLOW * limit:
        return []
    thickness = begun.smallest if isinf(wall.thickness) else wall.thickness  # from one side it is pushed twice as far
    through = limit * (1 + thickness / begun.smallest)
    return [
        f"wall '{wall.name}' moves at up to {speed:z.3g} m/s: a disc that it meets at {through:z.3g} m/s passes "
        f"through it, and overlaps end the run before; move it more slowly, or {begun.stiffer}"
    ]


def _bend_doubt(wall: Wall, largest: float) -> list[str]:
    """A line of short pieces that bends towards the discs nearly as tightly as the largest of them."""
    tightest = tight_bend(wall.faces)
    if tightest is None or tightest[0] >= TIGHTEST_LINE * largest / 2:
        return []
    radius, (x, y) = tightest
    return [
        f"wall '{wall.name}' bends towards the discs with a radius of about {radius:z.3g} m at ({x:zg}, {y:zg}) "
        f"m; below {TIGHTEST_LINE:zg} radii of the largest disc ({TIGHTEST_LINE * largest / 2:z.3g} m) discs "
        "lose or gain energy there: take an arc, or fewer points"
    ]


def _gap_doubts(walls: Sequence[Wall], smallest: float) -> list[str]:
    """Ends that nearly meet: no disc fits between them, and they are not joined."""
    sentences, ends = [], [open_ends(wall.faces) for wall in walls]
    corners = [vertices(wall.faces) for wall in walls]
    low = np.array([points.min(axis=0, initial=inf) for points in corners]).reshape(-1, 2) - smallest
    high = np.array([points.max(axis=0, initial=-inf) for points in corners]).reshape(-1, 2) + smallest
    for index, wall in enumerate(walls):
        for number, (x, y) in enumerate(ends[index]):
            places = [("its other end", np.array(ends[index][:number]))]
            for i in np.flatnonzero(((low <= (x, y)) & (high >= (x, y))).all(axis=1)).tolist():
                other = walls[i]
                if i != index and other.motion == wall.motion and not (i < index and ends[i]):
                    places.append((f"a corner of '{other.name}'", corners[i]))
            for what, points in places:
                gap = np.hypot(*(points - (x, y)).T).min() if len(points) else inf
                if SAME_END * max(1.0, abs(x), abs(y)) < gap < smallest:
                    sentences.append(
                        f"an end of wall '{wall.name}' at ({x:zg}, {y:zg}) m is {gap:z.3g} m from {what}: too "
                        "little for a disc, and not closed; let them meet, or move them apart"
                    )
    return sentences


def words_of_wall(one: MovingWall, scene: Scene) -> str:
    """Contact numbers and motion of a wall in words; empty where it has none of its own."""
    wall = one.wall
    names = {"friction": "", "restitution": "", "stiffness": " N/m", "rolling": ""}
    parts = [
        f"{name} {getattr(wall, name):zg}{unit}" for name, unit in names.items() if getattr(wall, name) is not None
    ]
    kind = one.motion.kind
    if one.motion.free and wall.stiffness is None:
        stiffness = stiffness_between(scene.coefficients, one)
        times = stiffness / scene.coefficients.stiffness_wall
        parts.append(f"stiffness {stiffness:z.3g} N/m with walls and bodies, {times:z.3g} times that of discs")
    if kind is not None:
        end = "" if kind.until is None else f" until {kind.until:zg} s"
        speed = largest_speed(one, *span(scene))
        pace = f", at up to {speed:z.3g} m/s" if speed else ""
        begin = f"from {kind.begin:zg} s" if isfinite(kind.begin) else "goes on"
        parts.append(f"motion {kind.kind} {begin}{end}{pace}")
    return "; ".join(parts)


def own_overlap(begun: InitialState, laws: Laws) -> float:
    """Factor on the limit of overlaps: a softer wall lets discs in deeper, by the root of the stiffnesses."""
    softest = min((law.stiffness for law in laws.values()), default=inf)
    return max(1.0, sqrt(begun.coefficients.stiffness / softest))
