# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns of arrays that the core reads as structs, and numbers that represent something, by their names.

The core has the same names (``api.cpp``). They are compared where it is loaded: `require_columns`.
"""

from __future__ import annotations

from enum import IntEnum

from lammps_jump.errors import SetupError


class Columns:
    """Columns of an array: a child is named after a struct of the core, and has of each member the columns."""

    @classmethod
    def as_line(cls) -> str:
        """Its members in their order, as the core tells them."""
        there = [(name.lower(), where) for name, where in vars(cls).items() if name.isupper()]
        ends = [(name, at, at + 1) if isinstance(at, int) else (name, at.start, at.stop) for name, at in there]
        return " ".join(
            [cls.__name__.removesuffix("Columns"), *(f"{name}={begin}+{end - begin}" for name, begin, end in ends)]
        )

    @classmethod
    def width(cls) -> int:
        """Number of columns."""
        last = [where for name, where in vars(cls).items() if name.isupper()][-1]
        return last + 1 if isinstance(last, int) else int(last.stop)


class PlacedColumns(Columns):
    """Place of a wall at a step: pose (m, m, rad), cosine and sine of its angle, rates (m/s, rad/s)."""

    NOW = slice(0, 3)
    C = 3
    S = 4
    RATE = slice(5, 8)
    """Over the step before."""
    CENTRED = slice(8, 11)
    """Over two steps."""


class PushedColumns(Columns):
    """Of a wall that is pushed, along x, along y and as a turn."""

    PLACE = slice(0, 3)
    """Displacement, m and rad."""
    SPEED = slice(3, 6)
    """Of the half step, m/s and rad/s."""
    BEFORE = slice(6, 9)
    """Of the half step before."""
    FORCE = slice(9, 12)
    """Of what touches it at the step (N/m), and its moment about the point of turning (N)."""
    PHASE = 12
    """A `Phase`."""


class LoadColumns(Columns):
    """Of a wall that is pushed."""

    MASS = 0
    """kg/m."""
    INERTIA = 1
    """Moment of inertia about the point of turning, kg m."""
    FORCE = slice(2, 4)
    """Constant, N/m."""
    ARM = slice(4, 6)
    """To it from the point of turning, m."""
    FREE = slice(6, 9)
    """1 or 0 for freedom along x, along y and to turn."""
    BEGIN = 9
    """Time of the release, s."""


class WallLoadsColumns(Columns):
    """Load on a wall in a step, along x, along y (N/m) and as a moment about the point of turning (N)."""

    OF_DISCS = slice(0, 3)
    ALL = slice(3, 6)
    """Of discs and of bodies."""
    DASHPOTS = slice(6, 9)
    """Part of it that dashpots take."""
    FRICTION = slice(9, 12)
    """Part of it that friction takes."""


class SumsOnWallColumns(Columns):
    """Load of discs on a wall, summed over steps: force (N/m) with its moment (N), and its power on them (W/m)."""

    FORCE = slice(0, 3)
    POWER = 3


class StepClockColumns(Columns):
    """Time in the loops."""

    STEP = 0
    """At the call."""
    START = 1
    """Step of t = 0."""
    DT = 2
    """s."""
    HALF_SKIN = 3
    """m."""
    EXTRAPOLATES = 4
    """1 where contacts with bodies see the extrapolated velocity."""


class WorkColumns(Columns):
    """Work of dashpots, friction and walls (`WorkParts`), J per m of width."""

    WHOLE = slice(0, 3)
    """Since the start."""
    OF_WALLS = slice(3, 6)
    """The last step's part that is due to walls."""


class WorkPartsColumns(Columns):
    """Work that dashpots and friction have taken, and that walls have done."""

    DASHPOTS = 0
    FRICTION = 1
    WALLS = 2


class TrackRowColumns(Columns):
    """A stretch of a track: its begin (s), coefficients of the pose in powers of the time since, and a wave."""

    BEGIN = 0
    X = slice(1, 6)
    Y = slice(6, 11)
    ANGLE = slice(11, 16)
    WAVE = slice(16, 19)
    """Amplitudes along x, along y (m) and as a turn (rad)."""
    RATE = slice(19, 22)
    """rad/s."""
    PHASE = slice(22, 25)
    """rad."""


class WallMotion(IntEnum):
    """Kind of motion of a wall: at rest; along a track; pushed by discs; at the speed that it is given; as a body."""

    STANDS = 0
    FOLLOWS = 1
    LOADED = 2
    TAILGATE = 3
    BODY = 4


class Phase(IntEnum):
    """State of a wall that is pushed: held, released at this step, or has moved."""

    IS_HELD = 0
    IS_RELEASED = 1
    HAS_MOVED = 2


class StationSum(IntEnum):
    """Sums of a `StationLedger`: mass through the stations along x (kg/m), and energies (J/m)."""

    MASS_LEFT = 0
    MASS_RIGHT = 1
    CARRIED = 2
    CONTACTS = 3
    WALLS = 4
    DASHPOTS = 5
    FRICTION = 6
    BEGAN = 7
    HELD = 8


class RunEnd(IntEnum):
    """Why a run of the core ends: at its step; no lists could be made; discs overlap too much, or have no slot left."""

    AT_TARGET = 0
    NO_LISTS = 1
    TOO_DEEP = 2
    NO_SLOT = 3


class Exchange(IntEnum):
    """Energy that is exchanged: that of discs which come and go, and what gates release."""

    BROUGHT_IN = 0
    CARRIED_OUT = 1
    RELEASED_BY_GATES = 2


class Traffic(IntEnum):
    """Discs that have come, that have gone, and the last id of those that have their own size."""

    INSERTED = 0
    REMOVED = 1
    SIZED = 2


class FaceKind(IntEnum):
    """Kinds of faces."""

    SEGMENT = 0
    ARC = 1


class Joint(IntEnum):
    """Kinds of joints: a turn away from the discs; one towards them, smooth or not; open; none."""

    CONVEX = 0
    SMOOTH = 1
    CORNER = 2
    FREE = 3
    ENDLESS = 4


COLUMNS = (
    PlacedColumns, PushedColumns, LoadColumns, WallLoadsColumns, SumsOnWallColumns, StepClockColumns, WorkColumns,
    WorkPartsColumns, TrackRowColumns,
)  # fmt: skip
NUMBERS: tuple[type[IntEnum], ...] = (
    WallMotion, Phase, StationSum, RunEnd, Exchange, Traffic, FaceKind, Joint,
)  # fmt: skip


def lines() -> list[str]:
    """Columns and numbers, a line each, as the core tells them."""
    named = ((one.__name__, [f"{n.name}={n.value}" for n in one]) for one in NUMBERS)
    return [*(one.as_line() for one in COLUMNS), *(" ".join([name, *members]) for name, members in named)]


def require_columns(there: str) -> None:
    """Refuse a core with other columns or numbers.

    Raises
    ------
    SetupError
        What the core tells, `there`, is not what Python has.
    """
    core, here = there.splitlines(), lines()
    if core != here:
        apart = sorted(set(core) ^ set(here)) or ["their order"]
        raise SetupError(f"columns are not the same in the core and in Python: {'; '.join(apart)}")
