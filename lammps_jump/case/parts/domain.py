# SPDX-License-Identifier: GPL-2.0-or-later
"""The domain of a scene and the outlets at its edges, with the largest speed that its case implies."""

from __future__ import annotations

from math import isfinite, sqrt

import numpy as np

from lammps_jump.case import checks, live, walls
from lammps_jump.case.discs import Column
from lammps_jump.case.fields import CaseFields
from lammps_jump.errors import FieldError
from lammps_jump.scene import Beginning, InletRow, Interval, MovingWall, Outlet
from lammps_jump.scene.motion import largest_speed, way

from .inflow import PourInflow

MAX_SPEED_MARGIN = 2.0
"""Ratio of the speed at which a disc could jump over an outlet to the largest speed that the case implies."""
Rectangle = tuple[Interval, Interval]
"""Lowest and highest x and y, m."""


def implied_speed(
    case: CaseFields, begun: Beginning, inlets: tuple[InletRow, ...], moving: list[MovingWall], impact: float
) -> float:
    """Largest speed that the case implies, m/s: at the start, at the inlet, of an impact, of a column's fall, of walls.

    `impact` is that for which the contact is made.
    """
    columns = [item.y[1] - item.y[0] for item in case.initial if isinstance(item, Column)]
    falls = [sqrt(2 * case.gravity * height) for height in columns]
    start = float(np.hypot(*begun.velocities.T).max(initial=0.0))
    driven = [largest_speed(one, *walls.span(begun)) for one in moving]
    driven += live.speeds(case, moving)
    return max([*(row.vx for row in inlets), impact, start, *falls, *driven])


def domain_of(
    case: CaseFields, begun: Beginning, inlets: tuple[InletRow, ...], moving: list[MovingWall], speed: float
) -> Rectangle:
    """The given domain, or one around all that the case names, and the ways of walls."""
    if case.domain is not None:
        domain = case.domain.x, case.domain.y
    else:
        ways = [*(way(one, *walls.span(begun)) for one in moving), *live.ways(case, moving)]
        closed = any(wall.hollow for wall in case.walls)
        margin = 2 * begun.largest if closed else 10 * begun.largest + speed * min(case.run.duration, 3.0)
        x, y = ((min(e) - margin, max(e) + margin) for e in (_ends(case, axis, begun, inlets, ways) for axis in "xy"))
        domain = x, y
    checks.check_domain(case, domain)
    return domain


def _ends(
    case: CaseFields, axis: str, begun: Beginning, inlets: tuple[InletRow, ...], ways: list[Rectangle]
) -> list[float]:
    """Coordinates that a domain must hold, m."""
    index = "xy".index(axis)
    values = [*begun.positions[:, index], *(getattr(row, axis) for row in inlets)]
    if isinstance(case.inflow, PourInflow):
        values += getattr(case.inflow, axis)
    values += [end for box in ways for end in box[index] if isfinite(end)]
    outlets = (pair for item in case.outflow for pair in item.model_dump(exclude_none=True).items())
    return values + [at for name, at in outlets if name.startswith(axis)]


def outlets_of(case: CaseFields, begun: Beginning, domain: Rectangle, speed: float) -> tuple[Outlet, ...]:
    """The lines behind which discs are taken out, each looked at before a disc can jump to the edge of the domain.

    Raises
    ------
    FieldError
        A line without room before the edge.
    """
    outlets = []
    for index, item in enumerate(case.outflow):
        ((field, at),) = item.model_dump(exclude_none=True).items()
        axis = field[0]
        side = "above" if field in ("x_beyond", "y_above") else "below"
        low, high = domain[0 if axis == "x" else 1]
        room = high - at if side == "above" else at - low
        if room <= begun.largest:
            raise FieldError(
                f"outflow.{index}.{field}",
                f"{at:zg} m leaves no room before the edge of the domain ([{low:zg}, "
                f"{high:zg}]); discs need a few metres to be taken out in: widen domain or move the outlet",
            )
        every = max(1, min(begun.output_steps, int(room / (MAX_SPEED_MARGIN * speed * begun.time_step))))
        outlets.append(Outlet(axis, at, side, every))
    return tuple(outlets)
