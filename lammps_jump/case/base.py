# SPDX-License-Identifier: GPL-2.0-or-later
"""Base of the fields of a case, and those that name an earlier run: its end or a frame of its dump."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr

from lammps_jump import units
from lammps_jump.quoting import LONGEST_NAME
from lammps_jump.units import Extent, Moment, Point, Rise
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

    # built where it is first validated, by itself or within a case: each by itself takes 0.1 s
    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, defer_build=True)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change in place, with the way to make one."""
        raise AttributeError(f"{name}: the fields of a case do not change; {HOW_TO_CHANGE}")


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

    def read(self, earlier_discs: EarlierDiscs) -> EarlierRun:
        """The same field when the run has been read."""
        new = self.model_copy()
        BaseModel.__setattr__(new, "_found", earlier_discs)  # of this new field alone
        return new
