# SPDX-License-Identifier: GPL-2.0-or-later
"""Base of all models of a case: limits of numbers, and the model that refuses unknown keys."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from lammps_jump import units
from lammps_jump.quoting import LONGEST_NAME
from lammps_jump.written import whole

# Wider than any use, and narrow enough that squares and quotients stay finite; more of them are in `units.py`.
LEAST_GRAVITY, MOST_GRAVITY = 1e-6, 1e6
LEAST_SPEED, MOST_SPEED = 1e-6, 1e6
FineLength = Annotated[units.Metre, Field(ge=1e-12, le=1e6)]
Speed = Annotated[units.MetrePerSecond, Field(ge=LEAST_SPEED, le=MOST_SPEED)]


Name = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$",
        max_length=LONGEST_NAME,
        description="letters, digits, `_`, `.` and `-`",
    ),
]
Whole = Annotated[int, BeforeValidator(whole)]
WholeOrAuto = Annotated[
    int | Literal["auto"], BeforeValidator(lambda value: value if value == "auto" else whole(value))
]
Shift = Annotated[units.Plain, Field(description="random shift of each disc, in diameters")]
Jitter = Annotated[Shift, Field(ge=0, le=0.5)]

HOW_TO_CHANGE = "case.replace({'contact.friction': 0.1}) makes a changed case"


class Strict(BaseModel):
    """Frozen model that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change in place, with the way to make one."""
        raise AttributeError(f"{name}: the fields of a case do not change; {HOW_TO_CHANGE}")
