# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed that the discs of a case lead to by fall heights, inflow and motions; and whether contacts bear it."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, inf, isfinite, radians, sqrt
from typing import NamedTuple

import numpy as np

from lammps_jump.case.discs import Column, DiscList, Lattice
from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.beds import RoughBed
from lammps_jump.case.parts.earlier import EarlierRun
from lammps_jump.case.parts.inflow import PourInflow, RowsInflow
from lammps_jump.physics.contact import Coefficients, largest_overlap
from lammps_jump.scene import Beginning, MovingWall
from lammps_jump.scene.motion import Motion, largest_speed

DESIGN = 0.1
"""Largest overlap that contacts are designed for, over the diameter: thesis (3.20) with n = 10."""
SOFT = 1.25
"""Overlap over `DESIGN` from which contacts of a given stiffness are doubted."""
TOP_ROW = 8 / 7
"""Fastest speed of the 1/7 profile over its mean."""
PLACES = 2000
"""Places along x where the ground is looked for."""
ASIDE = 3.0
"""How far beside all that a case names discs may fall, in diameters."""


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
    found = np.full(x.shape, -inf)
    for wall in case.walls:
        for _, top in (wall.surface if isinstance(wall, RoughBed) else wall).grounds(x):
            found = np.where(np.isfinite(top) & (top < highest) & (top > found), top, found)
    return found


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
    found = [Expected(0.0, "nothing moves at the start")]
    for start in starts(case):
        fall = max(0.0, start.top - low)
        speed = sqrt(start.speed**2 + 2 * gravity * fall)
        told = [f"discs {start.said} at {start.speed:z.3g} m/s"] if start.speed else []
        told += [f"{'' if told else 'discs '}fall by up to {fall:z.3g} m to the lowest ground"] if fall else []
        found.append(Expected(speed, " and ".join(told) or "discs start at rest"))
    for wall in case.walls:
        if not isinstance(wall, RoughBed) and wall.motion is not None:
            moving = MovingWall(wall, Motion(inf, wall.motion, wall.motion.about or wall.pivot_point))
            speed = largest_speed(moving, 0.0, case.run.duration) if wall.finite else 0.0
            found.append(Expected(speed, f"wall '{wall.name}' moves at up to {speed:z.3g} m/s"))
    return max(found, key=lambda one: one.speed)


def overlap_at(speed: float, c: Coefficients, diameter: float) -> float:
    """Largest overlap of a disc that hits a wall at a speed (m/s), over its diameter (m)."""
    return largest_overlap(speed, c.restitution, c.omega_wall) / diameter


def softness(case: CaseFields, begun: Beginning) -> list[str]:
    """A sentence on contacts that are too soft for the speed that is expected.

    A stiffness that is given is doubted from `SOFT` times `DESIGN` on; one that follows from ``impact_speed`` where
    the overlap ends the run.
    """
    c, law, found = begun.coefficients, case.contact, expected(case)
    share, limit = overlap_at(found.speed, c, begun.diameter), begun.overlap_limit / begun.diameter
    if share <= (limit if law.own_stiffness is None else min(limit, SOFT * DESIGN)):
        return []
    ends = f"the run ends at {limit:z.2g}" if share > limit else f"{DESIGN:zg} is usual"
    return [
        f"contacts are soft: {found.reason}, so that discs may meet a wall at {found.speed:z.3g} m/s and overlap it by "
        f"{share:z.2g} of a diameter ({ends}); {law.stiff_for(found.speed, share / DESIGN)}"
    ]
