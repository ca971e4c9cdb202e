# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed that the discs of a case lead to and whether contacts bear it; what walls and tables ask of grains."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import cos, inf, isfinite, radians, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.physics.contact import Coefficients, largest_overlap
from lammps_jump.physics.devices import creep_speed
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene import InitialState, MovingWall, Scene
from lammps_jump.scene.motion import Motion, largest_speed

from .base import EarlierRun
from .beds import RoughBed
from .discs import Column, DiscList, GradingCurve, Lattice, PackedBed, SieveSizes
from .fields import CaseFields
from .inflow import PourInflow, RowsInflow

DESIGN = 0.1
"""Largest overlap that contacts are designed for, over the diameter: thesis (3.20) with n = 10."""
SOFT = 1.25
"""Overlap over `DESIGN` from which contacts of a given stiffness are doubted."""
TOP_ROW = 8 / 7
"""Fastest speed of the 1/7 profile over its mean."""
PLACES = 2000
"""Places along x where the ground is looked for."""
ASIDE = 3.0
"""Distance that discs may fall beside all that a case names, in diameters."""


class Expected(NamedTuple):
    """The fastest collision that is foreseen: its speed (m/s), and why, as a sentence without its end."""

    speed: float
    reason: str


class DiscsAtStart(NamedTuple):
    """Discs at the start or at an inlet: ends along x, top (m), speed (m/s), and what they do, in words."""

    x: tuple[float, float]
    top: float
    speed: float
    said: str


def starts(case: CaseFields) -> Iterator[DiscsAtStart]:
    """Origin of the discs of a case."""
    for item in case.initial:
        if isinstance(item, Column):
            yield DiscsAtStart(item.x, item.y[1], float(np.hypot(*item.velocity)), "start")
        elif isinstance(item, PackedBed):
            yield DiscsAtStart(item.x, item.y[1], 0.0, "start")
        elif isinstance(item, Lattice):
            (x, y), wide, high = item.origin, (item.nx - 1) * item.spacing, (item.ny - 1) * item.spacing
            fastest = max(float(np.hypot(*v)) for v in (item.velocity, *item.velocities.values()))
            yield DiscsAtStart((x, x + wide), y + high, fastest, "start")
        elif isinstance(item, EarlierRun):
            yield DiscsAtStart(item.found.x, item.found.top, item.found.speed, "start")
        elif isinstance(item, DiscList):
            xs, ys = zip(*item.positions, strict=True)
            fastest = max((float(np.hypot(*v)) for v in item.velocities), default=0.0)
            yield DiscsAtStart((min(xs), max(xs)), max(ys), fastest,
                        "start")  # fmt: skip
    rows = case.inflow
    if isinstance(rows, RowsInflow):
        graph = rows.hydrograph
        factor = TOP_ROW if rows.profile == "power_law" else 1.0
        yield DiscsAtStart((rows.x, rows.x), rows.y + max(graph.depths), factor * max(graph.speeds), "enter")
    elif isinstance(rows, PourInflow):
        yield DiscsAtStart(rows.x, rows.y[1], rows.speed_down, "are poured")


def ground(case: CaseFields, x: np.ndarray) -> np.ndarray:
    """Height of the uppermost wall or rough bed that looks up at each x, m; minus infinity where there is none.

    Walls that end above all discs are left out.
    """
    highest = max((start.top for start in starts(case)), default=inf)
    heights = np.full(x.shape, -inf)
    for wall in case.walls:
        for _, top in (wall.surface if isinstance(wall, RoughBed) else wall).grounds(x):
            heights = np.where(np.isfinite(top) & (top < highest) & (top > heights), top, heights)
    return heights


def stretch(case: CaseFields) -> tuple[float, float]:
    """Ends along x of discs, walls that end, and outlets, and a little aside, m; within a domain that is given."""
    ends = [end for start in starts(case) for end in start.x]
    for wall in case.walls:
        places = wall.surface.extent[0] if isinstance(wall, RoughBed) else wall.extent[0]
        ends += [end for end in places if isfinite(end)]
    ends += [at for item in case.outflow for at in (item.x_beyond, item.x_before) if at is not None]
    aside = ASIDE * case.discs.diameter
    low, high = min(ends, default=0.0) - aside, max(ends, default=0.0) + aside
    return (low, high) if case.domain is None else (max(low, case.domain.x[0]), min(high, case.domain.x[1]))


def lowest_ground(case: CaseFields) -> float:
    """Lowest ground above the outlets and the lower end of a domain, m; infinite where there is none."""
    out = max((item.y_below for item in case.outflow if item.y_below is not None), default=-inf)
    out = out if case.domain is None else max(out, case.domain.y[0])
    heights = ground(case, np.linspace(*stretch(case), PLACES))
    return float(np.min(heights[heights > out], initial=inf))


def expected(case: CaseFields) -> Expected:
    """The fastest collision that a case leads to: start or inflow, a fall to the lowest ground, or a wall that moves.

    Where nothing moves, the speed is 0. A slope adds nothing: friction decides what it does.
    """
    low, gravity = lowest_ground(case), case.gravity * cos(radians(case.slope))
    expected_speeds = [Expected(0.0, "nothing moves at the start")]
    for start in starts(case):
        fall = max(0.0, start.top - low)
        speed = sqrt(start.speed**2 + 2 * gravity * fall)
        sources = [f"discs {start.said} at {start.speed:z.3g} m/s"] if start.speed else []
        sources += [f"{'' if sources else 'discs '}fall by up to {fall:z.3g} m to the lowest ground"] if fall else []
        expected_speeds.append(Expected(speed, " and ".join(sources) or "discs start at rest"))
    for wall in case.walls:
        if not isinstance(wall, RoughBed) and wall.motion is not None:
            moving = MovingWall(wall, Motion(inf, wall.motion, wall.motion.about or wall.pivot_point))
            speed = largest_speed(moving, 0.0, case.run.duration) if wall.finite else 0.0
            expected_speeds.append(Expected(speed, f"wall '{wall.name}' moves at up to {speed:z.3g} m/s"))
    return max(expected_speeds, key=lambda one: one.speed)


def overlap_at(speed: float, c: Coefficients, diameter: float) -> float:
    """Largest overlap of a disc that hits a wall at a speed (m/s), over its diameter (m)."""
    return largest_overlap(speed, c.restitution, c.omega_wall) / diameter


def softness(case: CaseFields, begun: InitialState) -> list[str]:
    """A sentence on contacts that are too soft for the speed that is expected.

    A stiffness that is given is doubted from `SOFT` times `DESIGN` on; one that follows from ``impact_speed`` where
    the overlap ends the run.
    """
    c, law, peak = begun.coefficients, case.contact, expected(case)
    share, limit = overlap_at(peak.speed, c, begun.diameter), begun.overlap_limit / begun.diameter
    if share <= (limit if law.own_stiffness is None else min(limit, SOFT * DESIGN)):
        return []
    ends = f"the run ends at {limit:z.2g}" if share > limit else f"{DESIGN:zg} is usual"
    return [
        f"contacts are soft: {peak.reason}, so that discs may meet a wall at {peak.speed:z.3g} m/s and overlap it by "
        f"{share:z.2g} of a diameter ({ends}); {law.stiff_for(peak.speed, share / DESIGN)}"
    ]


STATED_SLOPE = 20.0
"""Slope from which on `check` tells that a heap creeps, degrees."""
FLAT = (
    "discs without contact.rolling roll off each other, so that their heap is flat: 10 degrees in column_collapse, 31 "
    "with rolling friction 0.3 in heap; give contact.rolling for an angle of repose as of grains with corners"
)
"""Of poured discs that only slide."""
LEAST_FRICTION = 0.05
"""Friction below which no heap is meant: discs that flow as water."""


def makes_heap(case: CaseFields, diameter: float, walls: Iterable[MovingWall]) -> bool:
    """Tells whether the discs of a case end as a heap: a column falls, or discs are poured; nothing takes them away.

    Parameters
    ----------
    case : CaseFields
    diameter : float
        Of a nominal disc, m.
    walls : iterable of MovingWall
        Gates that are taken away are not among them.
    """
    walls = list(walls)
    if not case.gravity or case.outflow or any(motion.kind is not None for _, motion in walls):
        return False
    lows, highs = zip(*(wall.room("x") for wall, _ in walls), strict=True) if walls else ((), ())
    columns = (item.x for item in case.initial if isinstance(item, Column))
    falls = any(left - max(lows, default=-inf) > diameter or min(highs, default=inf) - right > diameter
                for left, right in columns)  # fmt: skip
    return (falls and case.inflow is None) or isinstance(case.inflow, PourInflow)


def heap_doubts(case: CaseFields, begun: InitialState, walls: Iterable[MovingWall]) -> list[str]:
    """A sentence on a heap whose contacts have no tangential spring: it creeps; or no rolling spring: it is flat."""
    law, c = FRICTION_LAWS[case.contact.friction_law], begun.coefficients
    if law.remembers:
        poured = isinstance(case.inflow, PourInflow) or case.analysis.hopper
        return [FLAT] if poured and case.contact.rolling is None and makes_heap(case, begun.diameter, walls) else []
    if c.friction < LEAST_FRICTION or not makes_heap(case, begun.diameter, walls):
        return []
    speed = creep_speed(case.gravity, STATED_SLOPE, c.gamma_tangential)
    sentence = (
        f"at {speed:z.2g} m/s on {STATED_SLOPE:zg} degrees ({speed / sqrt(case.gravity * begun.diameter):z.2g} √(g d))"
    )
    holds = [name for name, one in FRICTION_LAWS.items() if one.remembers]
    return [
        f"friction_law {case.contact.friction_law} has no tangential spring: a heap never rests, it creeps"
        + (f" {sentence}" if law.ramp is None and speed > 0 else "")
        + (f"; friction_law: {holds[0]} holds it" if holds else "")
    ]


TENTHS = 0.1, 0.9
"""Parts of the mass below which its finest tenth is, and above which its coarsest."""
FEWEST = 10.0
"""Discs of the coarsest tenth below which chance makes the curve there: their number is known to a third."""


def curve_doubts(case: CaseFields, scene: Scene) -> list[str]:
    """Sentences on a curve of sizes: its largest discs are too few, its finest part has no lower end."""
    sizes, curve = scene.sizes, case.discs.sizes
    if sizes is None or not isinstance(curve, GradingCurve):
        return []
    sentences = [curve.open_end] if isinstance(curve, SieveSizes) and curve.open_end else []
    coarse = sizes.diameter_at(TENTHS[1])
    share = 1.0 - float(sizes.passing(coarse, 0))
    count = scene.drawn_discs
    if count and count * share < FEWEST:
        sentences.append(
            f"discs.sizes: the coarsest tenth of the mass, above {coarse:z.3g} m, is {count * share:z.2g} of {count} "
            f"discs: too few for the curve to be met there; {FEWEST / share:z.2g} discs hold {FEWEST:zg} of them: take "
            "a larger bed, or a curve that is not so wide"
        )
    return sentences
