# SPDX-License-Identifier: GPL-2.0-or-later
"""Allowance of a case for the sliders of a live page: ways of walls, speeds, and what is refused.

The moves of a live page become tables of the case. So that a run of that case has the numbers of the page to the last
bit, domain and outlets must not depend on which moves were made: they allow for all that the sliders may do.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.scene import Interval, MovingWall, Wall

from .fields import CaseFields, LiveSlider
from .inflow import RowsInflow
from .text import nearest

NUMBERS = ("contact.friction", "contact.restitution", "gravity", "slope")
"""Numbers of a case that a flow can do without being made anew."""


def check_live(case: CaseFields) -> None:
    """FieldError where a slider names what is not there, or what two of them would change."""
    taken: dict[tuple[str, str | None], str] = {}
    for name, one in (case.live or {}).items():
        field = f"live.{name}.path"
        if one.wall:
            _require_wall(case, one, field)
        elif one.path == "inflow":
            _require_rows(case, field)
        elif one.path not in NUMBERS:
            raise FieldError(field, f"'{one.path}' is not known; allowed are walls.NAME, inflow, {', '.join(NUMBERS)}")
        if other := taken.get((one.path, one.move)):
            raise FieldError(field, f"'{one.path}' is moved by the slider '{other}' already; keep one of the two")
        taken[one.path, one.move] = name


def _require_wall(case: CaseFields, one: LiveSlider, field: str) -> None:
    walls = {wall.name: wall for wall in case.walls if isinstance(wall, Wall) and getattr(wall, "join", None) is None}
    if one.wall not in walls:
        hint = nearest(one.wall, list(walls))
        raise FieldError(field, f"'{one.wall}' is no wall of the case that a slider can move; {hint}")
    if one.move == "turn" and not walls[one.wall].finite:
        raise FieldError(field, f"'{one.wall}' has no end, so that it cannot turn; allowed are x and y")


def _require_rows(case: CaseFields, field: str) -> None:
    if not isinstance(case.inflow, RowsInflow):
        raise FieldError(field, "inflow: the case has no inflow by rows; drop the slider")
    if case.inflow.schedule == "thesis":
        raise FieldError(field, "inflow: schedule 'thesis' has no table; allowed is exact")


def is_live(case: CaseFields, name: str) -> bool:
    """Tells whether a slider moves a wall."""
    return any(one.wall == name for one in (case.live or {}).values())


def ways(case: CaseFields, moving: Sequence[MovingWall]) -> list[tuple[Interval, Interval]]:
    """Rectangles (x, y) around walls that sliders move, wherever they move them, m."""
    return [_way(wall, _sliders(case, wall.name)) for wall, _ in moving if is_live(case, wall.name)]


def _sliders(case: CaseFields, name: str) -> list[LiveSlider]:
    return [one for one in (case.live or {}).values() if one.wall == name]


def _far(wall: Wall, about: tuple[float, float]) -> float:
    """Largest distance of a point of a wall from that about which it turns, m; infinite where the wall has no end."""
    if not wall.finite:
        return inf
    return float(np.hypot(*(np.concatenate(wall.outline(*wall.extent)) - about).T).max())


def _way(wall: Wall, sliders: Sequence[LiveSlider]) -> tuple[Interval, Interval]:
    ends = [list(side) for side in wall.extent]
    for one in sliders:
        if one.move == "turn":
            far = _far(wall, wall.pivot_point)
            for side in ends:
                side[:] = side[0] - far, side[1] + far
        else:
            side = ends["xy".index(one.move or "x")]
            side[:] = side[0] + one.range[0], side[1] + one.range[1]
    return (ends[0][0], ends[0][1]), (ends[1][0], ends[1][1])


FASTEST_ROW = 1.25
"""Speed of the fastest row of an inlet over the mean, at most: it is 8/7 by the power law."""
ROUNDED = 1.01
"""Speed of a wall over what its slider asks for, at most: places are rounded to 1e-6 m."""


def speeds(case: CaseFields, moving: Sequence[MovingWall]) -> list[float]:
    """Largest speeds that sliders give to walls and to the inflow, m/s; the same whatever they have done."""
    speeds_of_sliders = []
    for wall, _ in moving:
        arms = {"turn": np.radians(1.0) * _far(wall, wall.pivot_point)} if is_live(case, wall.name) else {}
        rates = [one.rate * float(arms.get(one.move or "", 1.0)) for one in _sliders(case, wall.name)]
        speeds_of_sliders += [ROUNDED * sum(rates)] if rates else []
    for one in (case.live or {}).values():
        if one.path == "inflow" and isinstance(case.inflow, RowsInflow):
            depths = [depth for depth in case.inflow.hydrograph.depths if depth]
            speeds_of_sliders.append(FASTEST_ROW * one.range[1] / min(depths))
    return [speed for speed in speeds_of_sliders if isfinite(speed)]
