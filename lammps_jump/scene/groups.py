# SPDX-License-Identifier: GPL-2.0-or-later
"""Groups of walls: what their forces add up to, from the rows of the walls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from lammps_jump.errors import CaseError

from .motion import MovingWall
from .tracks import ANGLE, WAVE_ANGLE

Groups = Sequence[tuple[str, Sequence[str]]]
Row = tuple[Any, ...]
"""Step, name, fx, fy (N/m), moment (N) and, where walls move, power (W/m): means over the window that ends there."""


def reference(one: MovingWall) -> tuple[float, float]:
    """Point about which the moment on a wall is taken, where the case has the wall, m."""
    return one.motion.about if one.motion.kind else one.wall.moment_point


def arms(name: str, members: Sequence[MovingWall]) -> np.ndarray:
    """From the point of the first wall of a group to that of each one, m, shape (walls, 2); it never changes.

    Raises
    ------
    CaseError
        Walls that do not move as one body: the arms would change within a window of the force record.
    """
    first = members[0]
    track, turns = first.motion.track, bool(np.any(first.motion.track[:, [*range(ANGLE, ANGLE + 5), WAVE_ANGLE]]))
    for one in members[1:]:
        same = np.array_equal(one.motion.track, track) and not (one.motion.load or first.motion.load)
        if not same or (turns and one.motion.about != first.motion.about):
            raise CaseError(
                f"probes.groups.{name}: '{one.wall.name}' does not move with '{first.wall.name}', so their moments "
                "have no common point; allowed are walls that stand, or that have the same motion (and about, if they "
                "turn): give each part that moves a group of its own"
            )
    x, y = reference(first)
    return np.array([(px - x, py - y) for px, py in map(reference, members)])


def with_groups(rows: Iterable[Row], groups: Groups, walls: Sequence[MovingWall]) -> Iterator[Row]:
    """Rows of walls, and behind those of each step a row a group.

    Force and power are sums. The moment is about the point of the group's first wall: each wall's own, and its force at
    its arm. Arms are constant, so that this is exact for means over a window.
    """
    by_name = {one.wall.name: one for one in walls}
    leads = {name: arms(name, [by_name[member] for member in members]) for name, members in groups}
    for step, found in groupby(rows, key=lambda row: row[0]):
        own = list(found)
        yield from own
        values = {name: np.array(numbers, float) for _, name, *numbers in own}
        for name, members in groups:
            if not all(member in values for member in members):
                continue  # the last window of a run that was torn
            total = np.sum([values[member] for member in members], axis=0)
            forces = np.array([values[member][:2] for member in members])
            total[2] += float(np.sum(leads[name][:, 0] * forces[:, 1] - leads[name][:, 1] * forces[:, 0]))
            yield step, name, *map(float, total)
