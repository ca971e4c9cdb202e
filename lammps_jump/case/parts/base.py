# SPDX-License-Identifier: GPL-2.0-or-later
"""What all models of a case share: limits of numbers, and the model that refuses unknown keys."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from lammps_jump import units
from lammps_jump.scene.walls import Coordinate

# Wider than any use, and narrow enough that squares and quotients stay finite.
LENGTH = {"ge": 1e-6, "le": 1e6}
FINE_LENGTH = {"ge": 1e-12, "le": 1e6}
SPEED = {"ge": 1e-6, "le": 1e6}
TIME = {"ge": 1e-9, "le": 1e9}
STIFFNESS = {"ge": 1e-6, "le": 1e24}
LEAST_GRAVITY, MOST_GRAVITY = 1e-6, 1e6

Component = Annotated[units.MetrePerSecond, Field(ge=-1e6, le=1e6)]
Moment = Annotated[units.Second, Field(ge=-1e9, le=1e9)]
Point = tuple[Coordinate, Coordinate]
Vector = tuple[Component, Component]


def no_truth(value: Any) -> Any:
    """The value, unless it is true or false."""
    if isinstance(value, bool):
        raise ValueError(f"{str(value).lower()} is not a number; expected a whole number")
    return value


Whole = Annotated[int, BeforeValidator(no_truth)]

HOW_TO_CHANGE = "case.replace({'contact.friction': 0.1}) makes a changed case"


class Strict(BaseModel):
    """Frozen model that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change in place, with the way to make one."""
        raise AttributeError(f"{name}: the fields of a case do not change; {HOW_TO_CHANGE}")
