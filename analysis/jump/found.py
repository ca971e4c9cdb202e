# SPDX-License-Identifier: GPL-2.0-or-later
"""Result of a jump, one from the measurement to the page; docs/measuring.md explains its numbers."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import ClassVar

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

from .certainty import LOCAL_BOUNDS, LOWER_BOUNDS, Drift, Members
from .frame import Balance, FlowState, Mass, Moving, Roller
from .stream import Stream
from .tail import Tail
from .track import AlongStream, FrontMotion, JumpTrack

HEAP_SLOPE = 0.02
"""A standing surface steeper than this is a heap: water at rest is level."""
ASIDE = {"summary": False}
"""Of what stands in no summary."""


@dataclass(frozen=True)
class StandingHeap:
    """Discs behind the jump that stand still."""

    standing_share: float = number("", "share of the discs behind the toe that stand still", default=nan)
    surface_slope: float = number("", "slope of the surface behind the crest", default=nan)

    @property
    def locked(self) -> bool:
        """Most discs stand still under a sloping surface: friction has locked them."""
        return self.standing_share > 0.5 and abs(self.surface_slope) > HEAP_SLOPE


@dataclass(frozen=True)
class Local(Estimates):
    """The flow beside the jump and theory for it, frame of the front; 1 is before the toe, 2 behind the end.

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
    """Hydraulic jump: its numbers and theory, as they stand in ``summary.json``; NaN and None where not measured.

    `y1`, `froude`, `y2`, `belanger_y2` and `belanger_deviation` are the one comparison with theory: the depth `at`
    against Bélanger's for the stream `of`, in the frame of the front; `left_out` of the relation. ``_error`` is the
    standard error within this run in the same unit, NaN where one run cannot tell. The front is where a sharp step
    would hold the same mass.

    Attributes
    ----------
    verdict : {'jump', 'marginal jump', 'jump at the sill', 'no jump found', 'drowned inlet', 'locked heap'}
    reason : str
        One sentence behind the verdict.
    window : (float, float)
        s.
    developed : bool or None
        A level stretch behind the end was there to be measured.
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
    """A jump as it is looked for in profiles. What it has more than a `Jump` stands in no summary.

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
    """A jump that was found and measured in its own frame, or that of a piece of the window.

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
    track: JumpTrack = field(metadata=ASIDE)
    motion: FrontMotion = field(metadata=ASIDE)
    moving: Moving = field(metadata=ASIDE)
    mass_toe: float = field(metadata=ASIDE)
    mass_end: float = field(metadata=ASIDE)
    surface_toe: float = field(metadata=ASIDE)
    surface_end: float = field(metadata=ASIDE)
    upstream: FlowState = field(metadata=ASIDE)
    downstream: FlowState = field(metadata=ASIDE)
    pieces: tuple[MeasuredJump, ...] = field(default=(), metadata=ASIDE)

    @property
    def used(self) -> np.ndarray:
        """Mask of the frames of the window that have a jump, shape (frames,)."""
        return self.track.found & self.in_window
