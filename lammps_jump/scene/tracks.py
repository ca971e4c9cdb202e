# SPDX-License-Identifier: GPL-2.0-or-later
"""Kinds of motion of a wall, and the track that engines follow.

A new kind is a frozen dataclass with `kind`, fields and `corners` (or `wave`), named in `KINDS`. Engines and analysis
know none of the kinds: they take the rows of `track_of`, which `pose_py` evaluates.

A corner is a change of velocity dV. Eased over tau it is the ramp dV (3 u^2 - 2 u^3), u = (t - t_corner)/tau, so that
the pose is a polynomial of fourth degree there. A wave adds a sine.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import inf, isinf, pi, radians
from typing import Annotated, ClassVar, Literal, NamedTuple, TypeVar

import numpy as np
from pydantic import ConfigDict, Discriminator, Field, Tag

from lammps_jump import units
from lammps_jump.core.columns import TrackRowColumns
from lammps_jump.physics.elementary import cos, sin

Turn = Annotated[units.Degree, Field(ge=-1e6, le=1e6)]
Force = Annotated[units.NewtonPerMetre, Field(ge=-1e15, le=1e15)]
Row = tuple[units.Moment, units.Coordinate, units.Coordinate, Turn]
FileName = Annotated[str, Field(min_length=1, max_length=500)]
MOST_ROWS = 20_000
"""Rows of a table, and points of a wall."""
SAMPLES = 256
"""Times at which a whole way is looked at, besides those where the rows of its track begin."""

BEGIN = TrackRowColumns.BEGIN
X, Y, ANGLE, WAVE, RATE, PHASE = (
    there.start
    for there in (
        TrackRowColumns.X, TrackRowColumns.Y, TrackRowColumns.ANGLE, TrackRowColumns.WAVE, TrackRowColumns.RATE,
        TrackRowColumns.PHASE,
    )
)  # fmt: skip
"""First columns of a track: time at which the row begins (s); coefficients of three polynomials of the time since, of
degree 0 to 4 (m, m, rad); amplitudes of three sines (m, m, rad), their angular frequencies (rad/s) and phases (rad)."""
COLUMNS = TrackRowColumns.width()


class VelocityChange(NamedTuple):
    """A change of velocity (m/s, m/s, rad/s) at a time (s), spread over `ease` seconds."""

    time: float
    change: tuple[float, float, float]
    ease: float


class Wave(NamedTuple):
    """Amplitude (m, m, rad) times the sine of rate (time - begin) + phase, less its first value, until an end.

    Each component has an angular frequency (rad/s) and a phase (rad) of its own.
    """

    amplitude: tuple[float, float, float]
    rate: tuple[float, float, float]
    phase: tuple[float, float, float]
    begin: float
    end: float


@dataclass(frozen=True)
class Kind:
    """Fields that motions of a case file have in common; `begin` is ``from`` there."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", serialize_by_alias=True)
    turns: ClassVar[bool] = False
    eased: ClassVar[bool] = True
    """Says whether changes of velocity take time unless the case asks for others; a measured motion is not eased."""
    about: Annotated[
        units.Point | None,
        Field(
            description="[x, y] where the case has the wall: point that it turns about. Without it, `pivot` of a "
            "block, else the centre of the wall's extent"
        ),
    ] = field(default=None, kw_only=True)
    begin: Annotated[units.Moment, Field(alias="from", description="the wall stands before")] = field(
        default=0.0, kw_only=True
    )
    until: Annotated[
        units.Moment | None, Field(description="it stands from then on. Without it, the motion goes on")
    ] = field(default=None, kw_only=True)
    ease: Annotated[
        Annotated[units.Second, Field(ge=0, le=1e6)] | None,
        Field(
            description="time that each change of velocity takes; the wall then comes half of it late. Without it, 10 "
            "contact times π/ω of the wall, and 0 where the motion is followed as given, as oscillate and table are. "
            "0: at once"
        ),
    ] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.until is not None and self.until <= self.begin:
            raise ValueError(f"until is {self.until:zg} s; allowed is a time behind from ({self.begin:zg} s)")

    @property
    def end(self) -> float:
        """Time from which on the wall is at rest again, s, apart from ease; infinite: never."""
        return inf if self.until is None else self.until

    def corners(self, ease: float) -> list[VelocityChange]:
        """Changes of velocity, each spread over `ease` seconds."""
        return []

    def wave(self) -> Wave | None:
        """The sine, if there is one."""
        return None

    def _steady(self, velocity: tuple[float, float, float], ease: float) -> list[VelocityChange]:
        """One velocity from begin to end."""
        vx, vy, turn = velocity
        changes = [VelocityChange(self.begin, velocity, ease)]
        return changes if isinf(self.end) else [*changes, VelocityChange(self.end, (-vx, -vy, -turn), ease)]


@dataclass(frozen=True)
class Translate(Kind):
    """Steady motion along a straight line."""

    kind: Literal["translate"] = field(default="translate", kw_only=True, repr=False)
    velocity: Annotated[units.Vector, Field(description="steady velocity [vx, vy]")]

    def corners(self, ease: float) -> list[VelocityChange]:
        """Start and end."""
        return self._steady((*self.velocity, 0.0), ease)


@dataclass(frozen=True)
class Rotate(Kind):
    """Steady turning about a point; not of a plane."""

    kind: Literal["rotate"] = field(default="rotate", kw_only=True, repr=False)
    rate: Annotated[units.DegreePerSecond, Field(ge=-1e6, le=1e6, description="steady rate of turn, counter-clockwise")]

    turns = True

    def corners(self, ease: float) -> list[VelocityChange]:
        """Start and end."""
        return self._steady((0.0, 0.0, radians(self.rate)), ease)


Value = TypeVar("Value")
OneOrEach = Annotated[
    Annotated[Value, Tag("<one>")] | Annotated[tuple[Value, Value, Value], Tag("<each>")],
    Discriminator(lambda value: "<each>" if isinstance(value, list | tuple) else "<one>"),
]
"""A value of x, y and turn together, or one of each."""


def each(value: float | tuple[float, float, float]) -> tuple[float, float, float]:
    """The values of x, y and turn of a field that has one of all or one each."""
    return value if isinstance(value, tuple) else (value, value, value)


@dataclass(frozen=True)
class Oscillate(Kind):
    """Harmonic motion: amplitude · (sin(2π (t - from)/period + phase) - sin phase).

    It begins and ends suddenly unless `ease` is given. That moves what follows by the speed there times ease/2.
    """

    kind: Literal["oscillate"] = field(default="oscillate", kw_only=True, repr=False)
    period: Annotated[OneOrEach[units.Duration], Field(description="of all components, or one each of [x, y, turn]")]
    amplitude: Annotated[units.Point, Field(description="[x, y] of the displacement")] = (0.0, 0.0)
    angle: Annotated[Turn, Field(description="amplitude of the turn")] = 0.0
    phase: Annotated[
        OneOrEach[Turn],
        Field(description="where in the period the motion begins: of all components, or one each of [x, y, turn]"),
    ] = 0.0

    @property
    def turns(self) -> bool:  # type: ignore[override]  # depends on its fields
        """Tells whether its angle oscillates."""
        return self.angle != 0

    def wave(self) -> Wave:
        """The sine."""
        x, y, turn = (2 * pi / period for period in each(self.period))
        phases = each(self.phase)
        phase = radians(phases[0]), radians(phases[1]), radians(phases[2])
        return Wave((*self.amplitude, radians(self.angle)), (x, y, turn), phase, self.begin, self.end)

    def corners(self, ease: float) -> list[VelocityChange]:
        """Changes of velocity at both ends, where `ease` is given: sudden ones are taken away and come in slowly."""
        wave, changes = self.wave(), []
        for time, sign in ((self.begin, 1.0), (self.end, -1.0)) if self.ease else ():
            if not isinf(time):
                sines = zip(wave.amplitude, wave.rate, wave.phase, strict=True)
                x, y, angle = (
                    sign * rate * cos(rate * (time - wave.begin) + phase) * part for part, rate, phase in sines
                )
                changes += [
                    VelocityChange(time, (-x, -y, -angle), 0.0),
                    VelocityChange(time, (x, y, angle), self.ease or 0.0),
                ]
        return changes


@dataclass(frozen=True)
class TableMotion(Kind):
    """Straight lines from the start place through rows of time, displacement and turn.

    The wall is where a row says at its time. With `ease` it comes half of that time late.
    """

    eased = False
    kind: Literal["table"] = field(default="table", kw_only=True, repr=False)
    points: Annotated[
        tuple[Row, ...],
        Field(
            max_length=MOST_ROWS,
            description="rows [t, x, y, angle]: time, and how far the wall is then from where the case has it; "
            "straight lines between them",
        ),
    ] = ()
    file: Annotated[
        FileName | None,
        Field(
            description="CSV file with the columns t, x, y, angle, in place of `points`; in the folder of the case or "
            "below"
        ),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.file is not None:
            raise ValueError("file: is read with a case file; give points here")
        if not self.points:
            raise ValueError("needs points, rows [t, x, y, angle], or file: a table of them")
        first = self.points[0]
        if first[0] < self.begin:
            raise ValueError(f"points: the first t is {first[0]:zg} s; allowed is from ({self.begin:zg} s) or later")
        if first[0] == self.begin and any(first[1:]):
            raise ValueError(f"points: at t = from = {first[0]:zg} s the wall is where the case has it: write 0, 0, 0")
        for (before, *_), (after, *_) in pairwise(self._rows()):
            if after <= before:
                raise ValueError(f"points: t {after:zg} s follows {before:zg} s; times must grow")

    def _rows(self) -> list[Row]:
        there = self.points[0][0] == self.begin
        return list(self.points) if there else [(self.begin, 0.0, 0.0, 0.0), *self.points]

    @property
    def turns(self) -> bool:  # type: ignore[override]  # depends on its fields
        """Tells whether an angle is not 0."""
        return any(row[3] for row in self.points)

    def corners(self, ease: float) -> list[VelocityChange]:
        """A change of velocity at each row; the way ends at `until`."""
        changes, old, last = [], (0.0, 0.0, 0.0), self.begin
        for (t, *place), (later, *target) in pairwise(self._rows()):
            if t >= self.end:
                break
            x, y, turn = ((b - a) / (later - t) for a, b in zip(place, target, strict=True))
            new = x, y, radians(turn)
            changes.append(VelocityChange(t, (new[0] - old[0], new[1] - old[1], new[2] - old[2]), ease))
            old, last = new, min(later, self.end)
        return [*changes, VelocityChange(last, (-old[0], -old[1], -old[2]), ease)]


@dataclass(frozen=True)
class Loaded(Kind):
    """A lid: mass times acceleration is the force of the discs on it plus the force given; it has no weight else."""

    kind: Literal["load"] = field(default="load", kw_only=True, repr=False)
    mass: Annotated[
        units.Mass, Field(description="the lid moves by mass · acceleration = force of the discs + `force`")
    ]
    force: Annotated[tuple[Force, Force], Field(description="[Fx, Fy]; there is no other weight")]
    axis: Annotated[Literal["x", "y", "both"], Field(description="in which the lid moves")] = "y"

    def __post_init__(self) -> None:
        if self.until is not None or self.ease is not None or self.about is not None:
            raise ValueError("a load takes no until, ease or about: it is held until from, and free then")


@dataclass(frozen=True)
class Held(Kind):
    """A tailgate: it moves until the mass depth at a place, or the place of the front, is that of the case."""

    kind: Literal["hold"] = field(default="hold", kw_only=True, repr=False)
    speed: Annotated[units.MetrePerSecond, Field(ge=1e-9, le=1e6, description="largest speed of the gate, up and down")]
    range: Annotated[
        units.Point, Field(description="[low, high] of its way along y from where the case has it; low ≤ 0 ≤ high")
    ]
    depth: Annotated[
        Annotated[units.Metre, Field(ge=1e-9, le=1e6)] | None,
        Field(description="mass depth that it holds at `at`; or `front`"),
    ] = None
    at: Annotated[
        units.Coordinate | None, Field(description="x before the gate; the depth is taken over ten diameters around it")
    ] = None
    front: Annotated[
        units.Coordinate | None,
        Field(
            description="x at which it holds the front of a jump: where the mass depth first comes to the mean of y1 "
            "and its sequent depth"
        ),
    ] = None
    response: Annotated[
        units.Duration | None,
        Field(
            description="time constant of the controller. Without it, the time that a wave takes from the gate to the "
            "place and back"
        ),
    ] = None

    def __post_init__(self) -> None:
        if self.until is not None or self.ease is not None or self.about is not None:
            raise ValueError("a hold takes no until, ease or about: it stands until from, and holds from then on")
        if (self.depth is None) == (self.front is None):
            raise ValueError("needs depth (m) with at, or front (m), one of the two")
        if (self.depth is None) != (self.at is None):
            raise ValueError("depth and at belong together: the mass depth, m, and the place x where it is held, m")
        low, high = self.range
        if not low <= 0.0 <= high or low == high:
            raise ValueError(
                f"range: [{low:zg}, {high:zg}] is no way from where the case has the wall; allowed is [low, high] with "
                "low <= 0 <= high and low < high, m"
            )


KINDS = Translate | Rotate | Oscillate | TableMotion | Loaded | Held
"""Motions that a case file may name."""


def track_of(corners: list[VelocityChange], wave: Wave | None) -> np.ndarray:
    """Rows of a track, shape (rows, 25); before the first row a wall is where the case has it."""
    times = {corner.time + part for corner in corners for part in (0.0, corner.ease)}
    if wave is not None:
        times |= {wave.begin, wave.end} - {inf}
    track = np.zeros((len(times), COLUMNS))
    for row, begin in zip(track, sorted(times), strict=True):
        row[BEGIN] = begin
        for corner in corners:
            way = _way(begin, corner)
            for axis, change in zip((X, Y, ANGLE), corner.change, strict=True):
                row[axis : axis + 5] += change * way
        if wave is not None and begin >= wave.begin:
            over = begin >= wave.end
            since = (wave.end if over else begin) - wave.begin
            for k, axis in enumerate((X, Y, ANGLE)):
                amplitude, now = wave.amplitude[k], wave.rate[k] * since + wave.phase[k]
                row[axis] += amplitude * (sin(now) * over - sin(wave.phase[k]))
                if amplitude and not over:
                    row[WAVE + k], row[RATE + k], row[PHASE + k] = amplitude, wave.rate[k], now
    return track


def _way(begin: float, corner: VelocityChange) -> np.ndarray:
    """Coefficients, of the time since `begin`, of the way that a change of velocity of 1 makes; shape (5,).

    The way is s^3/tau^2 - s^4/(2 tau^3) up to s = tau after the corner, and s - tau/2 beyond.
    """
    s, tau = begin - corner.time, corner.ease
    if s < 0:
        return np.zeros(5)
    if begin >= corner.time + tau:
        return np.array([s - 0.5 * tau, 1.0, 0.0, 0.0, 0.0])
    a, b = 1 / tau**2, -0.5 / tau**3
    return np.array([a * s**3 + b * s**4, 3 * a * s**2 + 4 * b * s**3, 3 * a * s + 6 * b * s**2, a + 4 * b * s, b])


def pose_py(track: np.ndarray, first: int, last: int, time: float) -> tuple[float, float, float]:
    """Pose (m, m, rad) at a time (s), by the rows ``first … last - 1`` of a track; zero before the first row.

    The core does the same operations in the same order, `core/walls/motion.h`, and the plugin calls it.
    """
    row = first - 1
    while row + 1 < last and track[row + 1, BEGIN] <= time:
        row += 1
    if row < first:
        return 0.0, 0.0, 0.0
    s = time - track[row, BEGIN]
    x = y = angle = 0.0
    for power in range(4, -1, -1):
        x = x * s + track[row, X + power]
        y = y * s + track[row, Y + power]
        angle = angle * s + track[row, ANGLE + power]
    sines = [0.0, 0.0, 0.0]
    for k in range(3):
        if track[row, RATE + k] != 0.0:
            sines[k] = sin(track[row, RATE + k] * s + track[row, PHASE + k]) * track[row, WAVE + k]
    return x + sines[0], y + sines[1], angle + sines[2]


def times_of(track: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Times (s) from `begin` to `end` that show a whole way: equal steps, rows of the track, a period of its waves."""
    times_of_track = [np.linspace(begin, end, SAMPLES), track[:, BEGIN]]
    rates = ((row[BEGIN], rate) for row in track for rate in row[RATE : RATE + 3] if rate)
    times_of_track += [begins + np.linspace(0.0, 2 * pi / rate, 33) for begins, rate in rates]
    times = np.unique(np.concatenate(times_of_track))
    return times[(times >= begin) & (times <= end)]


def poses(track: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Poses (m, m, rad) at the times of `times_of`, shape (times, 3)."""
    return np.array([pose_py(track, 0, len(track), time) for time in times_of(track, begin, end)]).reshape(-1, 3)


def fastest(track: np.ndarray, begin: float, end: float) -> tuple[float, float]:
    """Largest speed (m/s) and rate of turning (rad/s) between two times, s; of a row, at nine places of it."""
    speed = rate = 0.0
    for row, until in zip(track, [*track[1:, BEGIN], inf], strict=True):
        low, high = max(row[BEGIN], begin), min(until, end)
        if low >= high:
            continue
        s = np.linspace(low, high, 9) - row[BEGIN]
        x, y, turn = (sum(p * row[axis + p] * s ** (p - 1) for p in range(1, 5)) for axis in (X, Y, ANGLE))
        waves = np.abs(row[RATE : RATE + 3] * row[WAVE : WAVE + 3])
        speed = max(speed, float(np.hypot(x, y).max()) + float(np.hypot(waves[0], waves[1])))
        rate = max(rate, float(np.abs(turn).max()) + float(waves[2]))
    return speed, rate
