# SPDX-License-Identifier: GPL-2.0-or-later
"""How a wall moves: its pose is a pure function of the step."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from .walls import Wall


class Pose(NamedTuple):
    """Displacement (m) and turn (rad, counter-clockwise) of a wall from where the case has it."""

    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0


@dataclass(frozen=True)
class Motion:
    """A wall that stands, until it is taken away.

    Attributes
    ----------
    gone : float
        First step whose forces no longer feel the wall; infinite: it stays.
    """

    gone: float = inf

    def pose(self, step: float) -> Pose | None:
        """Pose at a step; None once the wall is gone."""
        return Pose() if step < self.gone else None

    def next_change(self, step: int) -> float:
        """First step after `step` at which the wall is taken away; infinite if it stays."""
        return self.gone if self.gone > step else inf


STANDS = Motion()


class MovingWall(NamedTuple):
    """A wall and its motion."""

    wall: Wall
    motion: Motion = STANDS


def gate(wall: Wall, step: int) -> MovingWall:
    """A wall that is there until `step`, whose forces no longer feel it."""
    return MovingWall(wall, Motion(step))
