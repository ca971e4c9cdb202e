# SPDX-License-Identifier: GPL-2.0-or-later
"""Sliders of a live page: `lammps-jump live`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic.functional_validators import model_validator

from lammps_jump import units

from .base import Speed, Strict

IN_TWO_SECONDS = 0.5
"""Share of its range that a wall goes in a second where no speed is given."""


class LiveSlider(Strict):
    """A slider of a live page: what it changes, and between which numbers."""

    path: str = Field(
        min_length=1,
        max_length=200,
        description="`walls.NAME`, a wall, with `move`; `inflow`, the discharge of its rows (m²/s); or a number of the "
        "case: `contact.friction`, `contact.restitution`, `gravity`, `slope`",
    )
    move: Literal["x", "y", "turn"] | None = Field(
        default=None, description="of a wall: along x or y (m), or its turn (degrees); it takes the place of its motion"
    )
    range: Annotated[tuple[units.Plain, units.Plain], AfterValidator(units.ordered)] = Field(
        description="lowest and highest number; of a wall, from where the case has it, with 0 among them"
    )
    speed: Speed | None = Field(
        default=None,
        description="of a wall: how far it goes in a second (m/s, or degrees/s). Without it, its range in two seconds",
    )

    @model_validator(mode="after")
    def _of_one_kind(self) -> LiveSlider:
        low, high = self.range
        if (self.move is not None) != self.path.startswith("walls."):
            raise ValueError("path and move: a wall, walls.NAME, needs move (x, y or turn), and nothing else has it")
        if self.move is None and self.speed is not None:
            raise ValueError("speed: is that of a wall; drop it")
        if self.move is not None and not low <= 0.0 <= high:
            raise ValueError(f"range: [{low:zg}, {high:zg}] leaves out where the case has the wall; 0 must be in it")
        if self.path == "inflow" and low <= 0.0:
            raise ValueError(f"range: the discharge {low:zg} m^2/s is out of range; allowed is above 0")
        return self

    @property
    def wall(self) -> str:
        """Name of the wall that it moves; empty where it moves none."""
        return self.path.removeprefix("walls.") if self.move else ""

    @property
    def rate(self) -> float:
        """Largest way of a wall in a second, m or degrees."""
        return self.speed or IN_TWO_SECONDS * (self.range[1] - self.range[0])
