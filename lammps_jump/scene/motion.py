# SPDX-License-Identifier: GPL-2.0-or-later
"""Motion of a wall: its pose is a pure function of the step. A wall where it is at a step is a `WallAtStep` one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi
from typing import NamedTuple

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.physics.devices import Holding
from lammps_jump.physics.elementary import cos, sin

from .bodies import Free
from .chains import Chain, Faces, moved
from .tracks import ANGLE, COLUMNS, KINDS, WAVE, Held, Loaded, fastest, pose_py, poses, track_of
from .walls import Interval, Wall


class Pose(NamedTuple):
    """Displacement (m) and turn (rad, counter-clockwise) of a wall from where the case has it."""

    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0


STILL = Pose()


@dataclass(frozen=True)
class WallState:
    """State of a wall whose pose is state of the run, at the end of an earlier run.

    All numbers are of its point of turning, in the order of `Pose`; None where they are not known.

    Attributes
    ----------
    pose : Pose
        At the start of this run, from where the case has the wall.
    speed : Pose
        There, m/s and rad/s.
    half, before : Pose, optional
        Half a step earlier, and a step before that.
    force : Pose, optional
        Of what touched it (N/m), and its moment (N).
    listed : Pose, optional
        Where it was when the lists of the earlier run were made.
    area, since : float, optional
        Of the discs that a tailgate saw last (m^2), and the time since then (s).
    """

    pose: Pose
    speed: Pose = STILL
    half: Pose | None = None
    before: Pose | None = None
    force: Pose | None = None
    listed: Pose | None = None
    area: float | None = None
    since: float | None = None


@dataclass(frozen=True)
class Motion:
    """Pose of a wall at each step; without fields it is at rest.

    Attributes
    ----------
    gone : float
        First step whose forces no longer feel the wall; infinite: it stays.
    kind : Translate, Rotate, Oscillate, Table, Loaded, Held or Free, optional
        How it moves (`lammps_jump.scene.tracks`, `bodies`); None: it is at rest.
    about : (float, float)
        Point of the wall, where the case has it, m: it turns about it, and its moment is taken about it.
    ease : float
        Time that a change of velocity takes where `kind` gives none, s.
    start : int
        Step of t = 0.
    time_step : float
        s.
    holding : Holding, optional
        Of a tailgate: what it measures and how it answers.
    went : Went, optional
        Of a wall whose pose is state: where it is at the start, if it has moved in an earlier run.
    """

    gone: float = inf
    kind: KINDS | Free | None = None
    about: tuple[float, float] = (0.0, 0.0)
    ease: float = 0.0
    start: int = 0
    time_step: float = 1.0
    holding: Holding | None = None
    went: WallState | None = None

    @property
    def is_state(self) -> bool:
        """Tells whether the pose is state of the run, and no function of the step: of a load, a hold and a body."""
        return isinstance(self.kind, (Loaded, Held, Free))

    @property
    def load(self) -> Loaded | None:
        """Mass and force of a wall that the discs push; its pose is state of the run."""
        return self.kind if isinstance(self.kind, Loaded) else None

    @property
    def free(self) -> Free | None:
        """Mass, weight and the rest of a body."""
        return self.kind if isinstance(self.kind, Free) else None

    @property
    def is_pushed(self) -> bool:
        """Tells whether what touches it moves it: a load or a body."""
        return isinstance(self.kind, (Loaded, Free))

    @cached_property
    def track(self) -> np.ndarray:
        """The way as rows of polynomials and sines, shape (rows, 25), read-only."""
        if self.kind is None:
            return np.empty((0, COLUMNS))
        track = track_of(self.kind.corners(self.ease if self.kind.ease is None else self.kind.ease), self.kind.wave())
        track.setflags(write=False)
        return track

    def pose(self, step: float) -> Pose | None:
        """Pose at a step; None once the wall is gone. Where it is state, that of the start."""
        if step >= self.gone:
            return None
        if self.went is not None:
            return self.went.pose
        time = (step - self.start) * self.time_step
        x, y, angle = pose_py(self.track, 0, len(self.track), time)
        return Pose(float(x), float(y), float(angle))

    def next_change(self, step: int) -> float:
        """First step after `step` at which the wall is taken away; infinite if it stays."""
        return self.gone if self.gone > step else inf


STANDS = Motion()


class MovingWall(NamedTuple):
    """A wall and its motion."""

    wall: Wall
    motion: Motion = STANDS

    def at(self, step: float, pose: Pose | None = None, rate: Pose = STILL) -> Wall | None:
        """The wall where it is at a step; None once it is gone. `pose` and `rate`: those of one whose pose is state."""
        now = self.motion.pose(step)
        if now is None or self.motion.kind is None:
            return None if now is None else self.wall
        before = self.motion.pose(step - 1)
        own = [(b - a) / self.motion.time_step for a, b in zip(before or now, now, strict=True)]
        return WallAtStep(self.wall, pose or now, self.motion.about, Pose(*own) if pose is None else rate)

    @property
    def placed(self) -> WallAtStep:
        """The wall in the pose in which it begins."""
        return WallAtStep(self.wall, STILL if self.motion.went is None else self.motion.went.pose, self.motion.about)

    @property
    def first(self) -> Wall:
        """The wall where it is at the start."""
        return self.wall if self.motion.went is None else self.placed


@dataclass(frozen=True)
class WallAtStep(Wall):
    """A wall that moves, where it is at one step.

    Parameters
    ----------
    body : Wall
        Where the case has it.
    pose : Pose
    about : (float, float)
        Its point of turning where the case has it, m.
    rate : Pose
        Velocity (m/s, m/s, rad/s) over the step before.
    """

    body: Wall
    pose: Pose
    about: tuple[float, float]
    rate: Pose = STILL

    def __post_init__(self) -> None:
        for attribute in ("name", "kind", "hollow", "deep", "parts", "friction", "restitution", "stiffness"):
            object.__setattr__(self, attribute, getattr(self.body, attribute))

    def chains(self) -> tuple[Chain, ...]:
        """The chains of the body, moved."""
        return tuple(
            Chain(tuple(map(self._out, chain.points)), chain.bends, chain.closed, chain.endless)
            for chain in self.body.chains()
        )

    def _out(self, point: tuple[float, float]) -> tuple[float, float]:
        x, y = self.outward(np.array(point[0]), np.array(point[1]))
        return float(x), float(y)

    @cached_property
    def faces(self) -> Faces:
        """The faces of the body, moved."""
        return moved(self.body.faces, self.pose, self.about)

    @property
    def moment_point(self) -> tuple[float, float]:
        """The point of turning, moved, m."""
        return self.about[0] + self.pose.x, self.about[1] + self.pose.y

    def inward(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (m) in the frame in which the wall is at rest."""
        (ox, oy), (px, py, angle) = self.about, self.pose
        c, s, dx, dy = cos(angle), sin(angle), x - ox - px, y - oy - py
        return ox + c * dx + s * dy, oy - s * dx + c * dy

    def outward(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Actual places of points (m) of the frame in which the wall is at rest."""
        (ox, oy), (px, py, angle) = self.about, self.pose
        c, s, dx, dy = cos(angle), sin(angle), x - ox, y - oy
        return ox + px + c * dx - s * dy, oy + py + s * dx + c * dy

    def turned(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Actual directions, from the frame in which the wall is at rest."""
        c, s = cos(self.pose.angle), sin(self.pose.angle)
        return c * x - s * y, s * x + c * y

    def velocity(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of the wall at points, m/s."""
        mx, my = self.moment_point
        return self.rate.x - self.rate.angle * (y - my), self.rate.y + self.rate.angle * (x - mx)

    def room(self, axis: str) -> Interval:
        """As the body, of walls that are only shifted; no bound else."""
        if self.pose.angle:
            return -inf, inf
        low, high = self.body.room(axis)
        shift = self.pose["xy".index(axis)]
        return low + shift, high + shift

    def outline(self, x: Interval, y: Interval) -> tuple[np.ndarray, ...]:
        """Outlines of the body, moved."""
        return tuple(np.column_stack(self.outward(*corners.T)) for corners in self.body.outline(x, y))


def gate(wall: Wall, step: int) -> MovingWall:
    """A wall that is there until `step`, whose forces no longer feel it."""
    return MovingWall(wall, Motion(step))


def way(one: MovingWall, begin: float, end: float) -> tuple[Interval, Interval]:
    """Smallest rectangle (x, y) around a wall and its way between two times (s), m; of a pushed one where it begins."""
    wall, motion = one
    if motion.kind is None or motion.is_pushed:
        return one.first.extent
    if isinstance(motion.kind, Held):
        low, high = wall.extent[1]
        return wall.extent[0], (low + motion.kind.range[0], high + motion.kind.range[1])
    places = poses(motion.track, begin, end)
    low, high = places.min(axis=0), places.max(axis=0)
    if low[2] == high[2] == 0.0:
        (x0, x1), (y0, y1) = wall.extent
        return (x0 + float(low[0]), x1 + float(high[0])), (y0 + float(low[1]), y1 + float(high[1]))
    corners = np.concatenate(wall.outline(*wall.extent)) - motion.about
    if high[2] - low[2] >= 2 * pi:
        far = float(np.hypot(*corners.T).max())
        ends = [(at + float(a) - far, at + float(b) + far) for at, a, b in zip(motion.about, low, high, strict=False)]
        return ends[0], ends[1]
    c, s = (np.array([[of(turn)] for turn in places[:, 2].tolist()]) for of in (cos, sin))
    x = motion.about[0] + places[:, :1] + c * corners[:, 0] - s * corners[:, 1]
    y = motion.about[1] + places[:, 1:2] + s * corners[:, 0] + c * corners[:, 1]
    return (float(np.min(x)), float(np.max(x))), (float(np.min(y)), float(np.max(y)))


def at_seam(name: str, x: Interval, seam: Interval, margin: float) -> str:
    """Sentence on a moving wall that spans `x` (m) in a periodic channel; empty where it is off the seam.

    Walls do not repeat with the period: beyond the seam discs would not feel it.
    """
    low, high = seam[0] + margin, seam[1] - margin
    if x[0] >= low and x[1] <= high:
        return ""
    return (
        f"wall '{name}' comes to the seam of the periodic channel; allowed is a way between x = {low:zg} and "
        f"{high:zg} m"
    )


PUSHED_THERE = "discs have pushed it there: make the channel longer, or let it move along y alone (motion.axis: y)"
"""Remedy for a loaded wall `at_seam`."""


def largest_speed(one: MovingWall, begin: float, end: float) -> float:
    """Largest speed of a point of a wall between two times (s), m/s; 0 of one that the discs move."""
    wall, motion = one
    if motion.kind is None or motion.is_pushed:
        return 0.0
    if isinstance(motion.kind, Held):
        return motion.kind.speed
    speed, rate = fastest(motion.track, begin, end)
    if not rate:
        return speed
    corners = np.concatenate(wall.outline(*wall.extent)) - motion.about
    return speed + rate * float(np.hypot(*corners.T).max())


def reference(one: MovingWall) -> tuple[float, float]:
    """Point about which the moment on a wall is taken, where the case has the wall, m."""
    return one.motion.about if one.motion.kind else one.wall.moment_point


def arms(name: str, members: Sequence[MovingWall]) -> np.ndarray:
    """From the point of the first wall of a group to that of each one, m, shape (walls, 2); it never changes.

    Raises
    ------
    FieldError
        Walls that do not move as one body: the arms would change within a window of the force record.
    """
    first = members[0]
    track, turns = first.motion.track, bool(np.any(first.motion.track[:, [*range(ANGLE, ANGLE + 5), WAVE + 2]]))
    for one in members[1:]:
        same = np.array_equal(one.motion.track, track) and not (one.motion.is_state or first.motion.is_state)
        if not same or (turns and one.motion.about != first.motion.about):
            raise FieldError(
                f"probes.groups.{name}",
                f"'{one.wall.name}' does not move with '{first.wall.name}', so their moments "
                "have no common point; allowed are walls that stand, or that have the same motion (and about, if they "
                "turn): give each part that moves a group of its own",
            )
    x, y = reference(first)
    return np.array([(px - x, py - y) for px, py in map(reference, members)])
