# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of how a case runs: duration, time step, output, engine, and the sliders of its live page."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic.functional_validators import field_validator, model_validator

from lammps_jump import units

from .parts.base import FineLength, Speed, Strict, Whole, WholeOrAuto

FILM_INTERVAL = 0.4
"""Time between frames over sqrt(d/g): discs drawn between them by cubics are 0.01 d off, a few overlap (measured)."""
MOST_FILMED = 400
"""Frames of a run whose case asks for no interval: the report holds them."""
STILL_INTERVAL = 0.1
"""Time between frames without gravity, s."""


class RunFields(Strict):
    """Duration, time step and output."""

    duration: units.Duration = Field(
        title="simulated time",
        description="counted from the opening of the gates; whole frames within 0.1 % of it",
    )
    time_step_fraction: units.Plain = Field(
        default=0.05,
        ge=1e-6,
        le=2,
        title="time step over 2/ω",
        description="f: the time step over 2/ω (3.24), the largest stable step of an undamped contact. A bound: the "
        "step is up to 2 % finer where windows, frames and duration are whole steps then. An unstable step is refused",
    )
    output_interval: units.Duration | None = Field(
        default=None,
        description=f"time between frames. Without it, {FILM_INTERVAL:zg} √(d/g), at most {MOST_FILMED} frames, so "
        f"that the report plays; {STILL_INTERVAL:zg} s without gravity. Up to 2 % other, so that frames divide the "
        "duration and windows of the probes the frames",
    )
    seed: Whole = Field(
        default=1,
        ge=0,
        le=2_000_000_000,
        title="seed",
        description="seed of the random shifts, of the places of poured discs and of sizes. It also changes the speed "
        "of each inflow row by up to 1e-6 of itself, the same in every engine: runs with other seeds are other samples "
        "of one flow. 0 leaves the row speeds as they are",
    )
    accuracy: units.Share | None = Field(
        default=None,
        description="such as `1%`: use the cheapest setting shown to be that accurate (benchmark.md). Without it, the "
        "settings of the case",
    )
    members: Annotated[Whole, Field(ge=1, le=1000)] | None = Field(
        default=None,
        description="starts of the case, of seeds 1 to this number: `build-and-run` runs them all (sweeps.md)",
    )
    stop_when_steady: bool = Field(
        default=False,
        description="end when depth, discharge and toe of the jump are statistically steady (without a toe: depth and "
        "discharge), or when no disc has entered for 1.5 passages of the reach: the inlet is drowned. Without inflow "
        "rows: end when the discs rest (reference/numbers.md#rest)",
    )
    allow_unstable: bool = Field(default=False, description="run with a step that is refused otherwise")
    integrator: Literal["auto", "velocity_verlet", "leapfrog_extrapolated"] = Field(
        default="auto",
        description="`velocity_verlet` (LAMMPS) or `leapfrog_extrapolated` (thesis; native engine only). `auto`: that "
        "of the engine",
    )
    checkpoint_interval: units.Duration = Field(
        default=60.0,
        description="wall time between checkpoints; they come more rarely where one takes over 1 % of it",
    )
    dump_format: Literal["text", "gz", "binary"] = Field(
        default="text", description="how the frames are written: as `text`, packed (`gz`) or `binary`"
    )


MOST_THREADS = 64
"""Of one process; the plugin has as many parts."""


class Engine(Strict):
    """Engine, kernel, ranks and threads."""

    name: Literal["lammps", "native", "twin"] = Field(
        default="lammps",
        description="`lammps`: LAMMPS, with its own styles or compiled ones; `native`: the thesis step by step; "
        "`twin`: the same in plain Python, slow, without a compiler",
    )
    kernel: Literal["auto", "stock", "compiled"] = Field(
        default="auto",
        description="styles of LAMMPS: `stock` (its own) or `compiled` (this project's plugin). `auto`: compiled where "
        "there is a compiler",
    )
    ranks: WholeOrAuto = Field(default=1, description="number of MPI ranks, 1 or more, or `auto` (scaling.md)")
    threads: WholeOrAuto = Field(
        default="auto",
        description=f"threads of the compiled kernel and of the native engine, 1 to {MOST_THREADS}. `auto`: up to the "
        "cores that the process may use, as many as steps show to be the quickest; one with several ranks and in "
        "members. They change no bit of the results (scaling.md#threads)",
    )
    skin: FineLength | None = Field(default=None, description="skin of the neighbour lists. Without it, 0.3 diameters")

    @field_validator("ranks")
    @classmethod
    def _ranks(cls, value: int | str) -> int | str:
        if isinstance(value, int) and value < 1:
            raise ValueError(f"{value} ranks; expected 1 or more, or auto")
        return value

    @field_validator("threads")
    @classmethod
    def _threads(cls, value: int | str) -> int | str:
        if isinstance(value, int) and not 1 <= value <= MOST_THREADS:
            raise ValueError(f"{value} threads; expected 1 to {MOST_THREADS}, or auto")
        return value


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
