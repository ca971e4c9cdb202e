# SPDX-License-Identifier: GPL-2.0-or-later
"""The field ``initial`` of kind ``run``: discs of an earlier run, at its end or at a frame of its dump."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, Field, PrivateAttr

from lammps_jump import units
from lammps_jump.scene.walls import Coordinate, Extent

from .base import Moment, Strict


def _last(value: Any) -> Any:
    return None if value == "last" else value


class Region(Strict):
    """A rectangle along x, along y, or both."""

    x: Extent | None = None
    y: Extent | None = None


class EarlierDiscs(NamedTuple):
    """What the run holds of the discs that the case takes: number, ends along x, top (m), largest speed (m/s)."""

    count: int  # type: ignore[assignment]  # nobody counts in this tuple
    x: tuple[float, float]
    top: float
    speed: float


class EarlierRun(Strict):
    """Discs of an earlier run."""

    kind: Literal["run"]
    folder: Annotated[str, Field(min_length=1, max_length=1000)] = Field(description="run folder, from the case file")
    time: Annotated[Moment | None, BeforeValidator(_last)] = Field(
        default=None, description="last, its end with all digits, or a time: the nearest frame of its dump"
    )
    within: Region | None = Field(default=None, description="takes discs whose centres lie there, before shift")
    shift: tuple[Coordinate, Coordinate] = Field(default=(0.0, 0.0), description="[x, y], of all its discs")
    velocities: Literal["keep", "rest"] = "keep"
    in_walls: Literal["refuse", "drop"] = Field(default="refuse", description="discs deep in a wall of this case")
    jitter: units.Plain = Field(default=0.0, ge=0, le=0.5, description="random shift, in diameters")
    key: Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")] | None = Field(
        default=None, description="hash of its discs; written by the program"
    )
    _found: EarlierDiscs = PrivateAttr(default=EarlierDiscs(0, (0.0, 0.0), 0.0, 0.0))

    @property
    def found(self) -> EarlierDiscs:
        """What the run holds of its discs, once it has been read."""
        return self._found

    def read(self, found: EarlierDiscs) -> EarlierRun:
        """The same field when the run has been read."""
        new = self.model_copy()
        BaseModel.__setattr__(new, "_found", found)  # of this new field alone
        return new
