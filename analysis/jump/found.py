# SPDX-License-Identifier: GPL-2.0-or-later
"""Result of a jump, from the measurement to the page, and how sure it is; docs/measuring.md explains its numbers."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import ceil, isfinite, nan
from typing import Any, ClassVar

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.statistics import piece_error
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number, numbers_of

from .frame import Balance, FlowState, Mass, Moving, Roller
from .stream import Stream, Tail
from .track import AlongStream, FrontMotion, JumpTrack

GOAL = 0.03
"""Relative standard error of the mean of several starts that `Members` aims at."""
MISSED = {"y2": 0.60, "speed": 0.52, "froude": 0.44}
"""Largest share of the variance between starts that the window of one run missed (16 starts of a jump, windows of 3, 6
and 13 s, each share to 0.15; docs/measuring.md)."""

UNTOLD = (
    "y2", "speed", "length_mass", "local.y2", "local.u2", "local.h2", "local.packing_2",
)  # fmt: skip
"""Numbers measured in the frames whose error one run cannot tell: it misses part of the variance between starts, or
its 95 % intervals held less than 90 % of fresh starts (benchmarks/error_bars.py; docs/measuring.md)."""
STATES = ("local.y1", "local.u1", "local.y2", "local.u2", "speed")
MADE_OF = {
    "froude": ("speed",), "belanger_y2": ("speed",), "belanger_deviation": ("y2", "belanger_y2"),
    "head_lost_theory": ("speed",), "length_theory": ("speed",), "length_usbr": ("speed",), "length_over_y2": ("y2",),
    "local.froude": ("local.u1", "local.y1", "speed"), "local.froude_lab": ("local.u1", "local.y1"),
    "local.froude_downstream": ("local.u2", "local.y2", "speed"),
    "local.beta_1": ("local.u1", "speed"), "local.beta_2": ("local.u2", "speed"),
    "local.sequent_ratio": ("local.y1", "local.y2"),
    "sloping_y2": ("speed",), "sloping_deviation": ("y2", "sloping_y2"), "local.sloping_ratio": ("local.froude",),
    "local.belanger_ratio": ("local.froude",), "local.belanger_y2": ("local.froude", "local.y1"),
    "local.belanger_deviation": ("local.sequent_ratio", "local.belanger_ratio"),
    "local.density_ratio": ("local.y1", "local.y2", "local.h2"),
    "local.density_relation_ratio": ("local.froude", "local.density_ratio"),
    "local.density_relation_deviation": ("local.sequent_ratio", "local.density_relation_ratio"),
    "local.full_relation_ratio": ("local.froude", "local.density_ratio"), "local.pressure_relation_ratio": STATES,
    "local.pressure_relation_deviation": STATES,
    "local.pressure_coefficient_1": ("local.y1",), "local.pressure_coefficient_2": ("local.y2", "local.h2"),
    "local.head_upstream": ("local.froude", "local.y1"), "local.head_downstream": ("local.y2", "local.u2", "speed"),
    "local.energy_loss": ("local.head_upstream", "local.head_downstream"),
    "local.energy_loss_theory": ("local.froude", "local.y1"),
    "local.momentum_upstream": ("local.froude",), "local.momentum_downstream": ("local.y2",),
    "local.momentum_residual": ("local.momentum_upstream", "local.momentum_downstream"),
}  # fmt: skip
"""Numbers that a number is made of. One that is made of a number that one run cannot tell is one of these itself."""


def inherited(untold: Sequence[str], made_of: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """These numbers and all that are made of them, however far."""
    keys = dict.fromkeys(untold)
    while more := [key for key, parts in made_of.items() if key not in keys and keys.keys() & set(parts)]:
        keys |= dict.fromkeys(more)
    return tuple(keys)


BOUNDS = inherited(UNTOLD, MADE_OF)
LOWER_BOUNDS = tuple(key for key in BOUNDS if not key.startswith("local."))
"""Numbers of a `Jump` whose error is a lower bound."""
LOCAL_BOUNDS = tuple(key.removeprefix("local.") for key in BOUNDS if key.startswith("local."))
"""The same of the state next to the jump."""


@dataclass(frozen=True)
class Drift:
    """Mean of the second half of the window less that of the first; NaN where the window has no pieces."""

    y2: float = number("m", "drift of y2 within the window", default=nan)
    speed: float = number("m/s", "drift of the velocity of the front within the window", default=nan)
    length: float = number("m", "drift of the length within the window", default=nan)


@dataclass(frozen=True)
class Members:
    """Runs from slightly moved starts whose mean has a standard error of 3 %, at least; None: not known."""

    y2: int | None = number("", "runs for y2 to 3 %, at least", default=None)
    speed: int | None = number("", "runs for the velocity of the front to 3 %, at least", default=None)
    froude: int | None = number("", "runs for the Froude number to 3 %, at least", default=None)


def errors(jump: Estimates, pieces: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Standard error within this run of each number of a `Jump` that has one, by its key ``<number>_error``."""
    names = [key for key in numbers_of(jump) if key.endswith("_error")]
    return {name: piece_error(_values(pieces, name.removesuffix("_error"))) for name in names}


def drift(pieces: Sequence[Mapping[str, Any]]) -> Drift:
    """Drift of the main numbers within the window."""
    if not pieces:
        return Drift()
    half = len(pieces) // 2
    series = {field.name: _values(pieces, field.name) for field in fields(Drift)}
    return Drift(**{name: float(values[half:].mean() - values[:half].mean()) for name, values in series.items()})


def members(jump: Estimates) -> Members:
    """Number of starts needed, with the variance that one run misses added to its own errors."""

    def needed(key: str) -> int | None:
        value, error = getattr(jump, key), getattr(jump, f"{key}_error")
        if not isfinite(error) or abs(value) <= 2 * error:  # no share of a number that may be zero
            return None
        return max(1, ceil(error**2 / (1.0 - MISSED[key]) / (GOAL * value) ** 2))

    return Members(**{key: needed(key) for key in MISSED})


def starts_needed(members: Members | None) -> str:
    """Number of runs for each number that has one, in words; empty where none has."""
    names = {"y2": "y2", "speed": "the velocity of the front", "froude": "the Froude number"}
    counts = {name: getattr(members, key, None) for key, name in names.items()}
    texts = [f"{count} {'run' if count == 1 else 'runs'} for {name}" for name, count in counts.items() if count]
    return ", ".join([*texts[:-2], " and ".join(texts[-2:])]) if texts else ""


def _values(pieces: Sequence[Mapping[str, Any]], key: str) -> np.ndarray:
    return np.array([piece.get(key, nan) for piece in pieces], float)


HEAP_SLOPE = 0.02
"""A standing surface steeper than this is a heap: water at rest is level."""
ASIDE = {"summary": False}
"""Of what is in no summary."""


@dataclass(frozen=True)
class StandingHeap:
    """Discs downstream of the jump that stand still."""

    standing_share: float = number("", "share of the discs behind the toe that stand still", default=nan)
    surface_slope: float = number("", "slope of the surface behind the crest", default=nan)

    @property
    def locked(self) -> bool:
        """Most discs stand still under a sloping surface: friction has locked them."""
        return self.standing_share > 0.5 and abs(self.surface_slope) > HEAP_SLOPE


@dataclass(frozen=True)
class Local(Estimates):
    """The flow next to the jump and theory for it, frame of the front; 1 is before the toe, 2 after the end.

    Depths s are by mass, h by the free surface. The comparison of a `Jump` is another one: with the delivered inflow.
    """

    froude: float = estimate("", "Froude number before the toe, front's frame")
    froude_lab: float = estimate("", "Froude number before the toe, laboratory")
    froude_downstream: float = estimate("", "Froude number behind the end, front's frame")
    y1: float = estimate("m", "mass depth s before the toe")
    y2: float = estimate("m", "mass depth s behind the end")
    h1: float = estimate("m", "surface depth h before the toe")
    h2: float = estimate("m", "surface depth h behind the end")
    u1: float = estimate("m/s", "mean velocity u before the toe")
    u2: float = estimate("m/s", "mean velocity u behind the end")
    packing_1: float = estimate("", "packing before the toe")
    packing_2: float = estimate("", "packing behind the end")
    beta_1: float = estimate("", "momentum coefficient β before the toe")
    beta_2: float = estimate("", "momentum coefficient β behind the end")
    sequent_ratio: float = estimate("", "s₂/s₁ beside the jump")
    pressure_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the measured thrust")
    pressure_relation_deviation: float = estimate("", "s₂/s₁ over that ratio, less one")
    belanger_ratio: float = estimate("", "s₂/s₁ by Bélanger")
    belanger_y2: float = estimate("m", "sequent depth by Bélanger of the state before the toe")
    belanger_deviation: float = estimate("", "s₂/s₁ over Bélanger's ratio, less one")
    density_ratio: float = estimate("", "bulk density downstream over upstream")
    density_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with the density ratio")
    density_relation_deviation: float = estimate("", "s₂/s₁ over that ratio, less one")
    sloping_ratio: float = estimate("", "s₂/s₁ by Bélanger with the weight of the jump along the bed")
    full_relation_ratio: float = estimate("", "s₂/s₁ by momentum, with density, bed force, slope and β")
    pressure_coefficient_1: float = estimate("", "contact pressure over hydrostatic, before the toe")
    pressure_coefficient_2: float = estimate("", "contact pressure over hydrostatic, behind the end")
    head_upstream: float = estimate("m", "head s + (u − c)²/2g before the toe")
    head_downstream: float = estimate("m", "head s + (u − c)²/2g behind the end")
    energy_loss: float = estimate("m", "difference of s + (u − c)²/2g")
    energy_loss_theory: float = estimate("m", "head lost by Bélanger, of the state before the toe")
    energy_loss_depths: float = number("m", "head lost by the two depths", default=nan)
    momentum_upstream: float = estimate("N/m", "momentum function before the toe")
    momentum_downstream: float = estimate("N/m", "momentum function behind the end")
    momentum_residual: float = estimate("", "momentum function 1 − 2 over 2")
    moved_y1: float = number("m", "change of y1 where its stretch lies one depth further upstream", default=nan)
    moved_froude: float = number("", "change of the Froude number, the same", default=nan)
    moved_belanger_y2: float = number("m", "change of Bélanger's depth, the same", default=nan)
    moved_y2: float = number("m", "change of y2 where its stretch lies as far further down", default=nan)
    lower_bounds: tuple[str, ...] = LOCAL_BOUNDS


@dataclass(frozen=True)
class Budget(Estimates):
    """Energy between two stations that move with the front, as heads: powers over ρ g and the discharge through it.

    `x` are the places of the two at the begin of `window` (m, s), the smaller one first.
    """

    start: float = number("m", "station upstream, from the toe", default=nan)
    stop: float = number("m", "station downstream, from the toe", default=nan)
    x: tuple[float, float] = (nan, nan)
    speed: float = number("m/s", "velocity of the stations", default=nan)
    window: tuple[float, float] = (nan, nan)
    discharge: float = number("m^2/s", "discharge through the station upstream, front's frame", default=nan)
    carried: float = number("m", "head that discs carry in, less out", default=nan)
    contacts: float = number("m", "head that contacts hand on, in less out", default=nan)
    inflow: float = estimate("m", "both: in less out")
    storage: float = number("m", "head stored between the stations", default=nan)
    dashpots: float = estimate("m", "head that dashpots take")
    lost: float = number("m", "head lost between the stations: in less out, less stored", default=nan)
    residual: float = estimate("m", "that less what dashpots take")
    frames: int = 0


@dataclass(frozen=True)
class Jump(Estimates):
    """Hydraulic jump: its numbers and theory, as in ``summary.json``; NaN or None where not measured.

    `y1`, `froude`, `y2`, `belanger_y2` and `belanger_deviation` are the one comparison with theory: the depth `at`
    against Bélanger's for the stream `of`, in the frame of the front; `left_out` of the relation. ``_error`` is the
    standard error within this run in the same unit, NaN where one run cannot tell. The front is where a sharp step
    would hold the same mass.

    Attributes
    ----------
    verdict : {'jump', 'marginal jump', 'jump at the sill', 'no jump found', 'drowned inlet', 'locked heap'}
    reason : str
        One sentence that explains the verdict.
    window : (float, float)
        s.
    developed : bool or None
        A level stretch after the end was there to be measured.
    """

    verdict: str
    reason: str
    headline: str = ""
    notes: tuple[str, ...] = field(default=(), metadata=ASIDE)
    inflow: theory.Inflow | None = None
    window: tuple[float, float] = (nan, nan)
    frames_found: int | None = None
    frames_in_window: int | None = None
    share_found: float = number("", "share of the window's frames that have a jump", default=nan)
    heap: StandingHeap | None = None
    filling: bool | None = None
    time: float = number("s", "time of the last frame used", default=nan)
    position: float = number("m", "front at that time", default=nan)
    toe: float = number("m", "toe at that time", default=nan)
    end: float = number("m", "end at that time", default=nan)
    of: str = ""
    at: str = ""
    left_out: tuple[str, ...] = ()
    froude: float = estimate("", "Froude number, front's frame", label="Fr1")
    y1: float = estimate("m", "mass depth of the stream", label="y1")
    y2: float = estimate("m", "sequent depth, by mass", label="y2")
    belanger_y2: float = estimate("m", "sequent depth by Bélanger, front's frame", label="Bélanger")
    belanger_deviation: float = estimate("", "sequent depth over Bélanger's, less one", label="deviation")
    bed_slope: float = number("", "fall of the bed along the stream, per length along the level", default=nan)
    sloping_y2: float = estimate("m", "sequent depth by Bélanger with the weight of the jump along the bed")
    sloping_deviation: float = estimate("", "sequent depth over that, less one")
    speed: float = estimate("m/s", "velocity of the front", label="shock speed")
    length: float = estimate("m", "length of the jump", label="length")
    toe_speed: float = estimate("m/s", "velocity of the toe")
    end_speed: float = estimate("m/s", "velocity of the end")
    developed: bool | None = None
    jump_class: str | None = field(default=None, metadata={"key": "class"})
    length_mass: float = estimate("m", "length by the mass depth")
    length_ramp: float = estimate("m", "length by the fitted ramps")
    length_over_y2: float = estimate("", "length over y2")
    length_theory: float = estimate("m", "length by thesis (4.27)")
    length_usbr: float = estimate("m", "length by the USBR curve")
    head_lost: float = estimate("m", "head lost, energy budget", label="head lost in the jump")
    head_lost_theory: float = estimate("m", "head lost by Bélanger")
    budget: Budget | None = None
    local: Local | None = None
    momentum_terms: Balance | None = None
    mass: Mass | None = None
    roller: Roller | None = None
    tail: Tail | None = None
    stream: Stream | None = None
    drift: Drift | None = None
    members: Members | None = None
    lower_bounds: tuple[str, ...] = LOWER_BOUNDS


@dataclass(frozen=True, kw_only=True)
class TrackedJump(Jump, AlongStream):
    """A jump as it is looked for in profiles. What it has more than a `Jump` is in no summary.

    Attributes
    ----------
    flow : Flow
    direction : int
        +1 for a stream towards larger x, -1 towards smaller.
    in_window : ndarray of bool, shape (frames,)
    track : JumpTrack or None
        None where nothing was looked at.
    """

    ALONG: ClassVar[tuple[str, ...]] = ("track", "toe_speed", "end_speed", "stream")
    flow: Flow = field(metadata=ASIDE)
    direction: int = field(default=1, metadata=ASIDE)
    in_window: np.ndarray = field(metadata=ASIDE)
    track: JumpTrack | None = field(default=None, metadata=ASIDE)


@dataclass(frozen=True, kw_only=True)
class MeasuredJump(TrackedJump):
    """A jump that was detected and measured in its own frame, or that of a piece of the window.

    Attributes
    ----------
    motion : FrontMotion
        Of the front of equal mass.
    moving : Moving
    mass_toe, mass_end, surface_toe, surface_end : float
        In the moving frame, m along the stream from the front: of the mean mass depth, and of the surface.
    upstream, downstream : FlowState
    pieces : tuple of MeasuredJump
        Of each piece of the window.
    """

    ALONG = (*TrackedJump.ALONG, "motion")
    momentum_terms: Balance
    track: JumpTrack = field(repr=False, metadata=ASIDE)
    motion: FrontMotion = field(repr=False, metadata=ASIDE)
    moving: Moving = field(repr=False, metadata=ASIDE)
    mass_toe: float = field(repr=False, metadata=ASIDE)
    mass_end: float = field(repr=False, metadata=ASIDE)
    surface_toe: float = field(repr=False, metadata=ASIDE)
    surface_end: float = field(repr=False, metadata=ASIDE)
    upstream: FlowState = field(repr=False, metadata=ASIDE)
    downstream: FlowState = field(repr=False, metadata=ASIDE)
    pieces: tuple[MeasuredJump, ...] = field(default=(), repr=False, metadata=ASIDE)

    @property
    def used(self) -> np.ndarray:
        """Mask of the frames of the window that have a jump, shape (frames,)."""
        return self.track.found & self.in_window
