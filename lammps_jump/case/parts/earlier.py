# SPDX-License-Identifier: GPL-2.0-or-later
"""The field ``initial`` of kind ``run``: discs of an earlier run, at its end or at a frame of its dump."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, Field, PrivateAttr

from lammps_jump.units import Extent, Moment, Point, Rise

from .base import Jitter, Strict


def _last(value: Any) -> Any:
    return None if value == "last" else value


class Region(Strict):
    """A rectangle along x, along y, or both."""

    x: Extent | None = Field(default=None, description="from and to")
    y: Rise | None = Field(default=None, description="from and to")


class EarlierDiscs(NamedTuple):
    """Discs of an earlier run that the case takes: number, ends along x, top (m), largest speed (m/s)."""

    count: int  # type: ignore[assignment]  # nobody counts in this tuple
    x: tuple[float, float]
    top: float
    speed: float


class EarlierRun(Strict):
    """Discs of an earlier run, and its bodies, lids and tailgates that the case names too."""

    kind: Literal["run"]
    folder: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="run folder, from the folder of the case file; in that folder or the working directory. Its run "
        "has ended or was stopped"
    )
    time: Annotated[Moment | None, BeforeValidator(_last)] = Field(
        default=None,
        description="`last`: its end, with all digits. Or a time: the nearest frame of its dump. Without it, `last`",
    )
    within: Region | None = Field(
        default=None, description="takes what has its centre there, before `shift`; without it, all"
    )
    shift: Point = Field(default=(0.0, 0.0), description="[x, y] that its discs and bodies are moved by")
    velocities: Literal["keep", "rest"] = Field(
        default="keep", description="`keep`: velocities and spins of the run; `rest`: none"
    )
    in_walls: Literal["refuse", "drop"] = Field(
        default="refuse",
        description="discs deeper in a wall of this case than d/n: `refuse` the case, or `drop` the discs",
    )
    jitter: Jitter = 0.0
    key: Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")] | None = Field(
        default=None,
        description="hash of its discs, twelve digits and letters a to f. The program writes it into `case.yaml` of "
        "the run folder; a case that gives it begins from these discs alone",
    )
    _found: EarlierDiscs = PrivateAttr(default=EarlierDiscs(0, (0.0, 0.0), 0.0, 0.0))

    @property
    def found(self) -> EarlierDiscs:
        """Discs of the earlier run, once it has been read."""
        return self._found

    def read(self, found: EarlierDiscs) -> EarlierRun:
        """The same field when the run has been read."""
        new = self.model_copy()
        BaseModel.__setattr__(new, "_found", found)  # of this new field alone
        return new
