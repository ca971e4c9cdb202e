# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as the loops read them: flat faces, the cells that find them, and the list of discs near each wall.

Corners of walls are discs that meet the faces of bodies, and corners of bodies meet those of walls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.core.columns import (
    LoadColumns,
    Phase,
    PlacedColumns,
    PushedColumns,
    StepClockColumns,
    SumsOnWallColumns,
    WallLoadsColumns,
    WallMotion,
)
from lammps_jump.core.law import LawNumbers
from lammps_jump.physics.law import Slots
from lammps_jump.scene.chains import BEFORE, LENGTH, Faces, boxes, lay
from lammps_jump.scene.faces import MOST, FaceGrid, grid_of
from lammps_jump.scene.meeting import LARGEST_OVERLAP, SLOTS, corners, laws_between, meets
from lammps_jump.scene.motion import Motion, MovingWall, Pose, WallState, at_seam
from lammps_jump.scene.scene import Scene

from .arrays import CORNER, BodyState, Constants, Loops, Memory, Moves, Near, Pairs, PressedSums, State


class CornerDiscs:
    """Corners in the place of discs, as the loops take these; what corners lack is None."""

    def __init__(self, radius: np.ndarray):
        self.n = self.room = len(radius)
        self.radius = radius
        self.ids = np.arange(1, self.n + 1)
        self.x, self.y = np.zeros(self.n), np.zeros(self.n)
        self.partner = np.zeros((self.n, SLOTS), np.int64)
        self.sigma, self.spring, self.roll = (np.zeros((self.n, SLOTS)) for _ in range(3))
        self.touched = np.zeros((self.n, SLOTS), np.int8)

    vx = vy = fx = fy = x0 = y0 = ux = uy = omega = torque = uomega = fixed = None
    dashpot_x = dashpot_y = friction_x = friction_y = None


class CornersBeside(NamedTuple):
    """Walls as the loops take them, with the corners near them in place of discs."""

    faces: Faces
    gone: np.ndarray
    near: Near
    moves: Any
    chain: np.ndarray
    around: np.ndarray
    sums: np.ndarray
    pressed: PressedSums | None = None


class Bodies:
    """Bodies of a scene among its walls.

    Parameters
    ----------
    scene : Scene
    faces : Faces
        Of all walls.
    gone : ndarray of int8, shape (walls,)
        1 of walls that have been taken away.
    loops : Loops
    skin : float
        m.

    Attributes
    ----------
    numbers : list of int
        Of the bodies, among the walls.
    discs : CornerDiscs
        Corners of all walls of the scene, in its order.
    near : Near
        Corners near each wall, and the faces near each corner.
    """

    def __init__(self, scene: Scene, faces: Faces, gone: np.ndarray, loops: Loops, skin: float):
        self.scene, self._faces, self._gone, self.loops = scene, faces, gone, type(loops)()
        there = scene.walls
        self.numbers = [number for number, one in enumerate(there) if one.motion.free]
        self.corner = np.array([(*corner, number) for number, corner in corners(scene)], CORNER)
        self.discs = CornerDiscs(self.corner["radius"].copy())
        if scene.earlier is not None:
            for name, rows in scene.earlier.corner_slots(SLOTS).items():
                getattr(self.discs, name)[:] = rows
        self.meets = meets(there).astype(np.int8)
        largest = float(self.discs.radius.max(initial=0.0))
        # a corner and a face have moved by half a skin each at most since they were listed
        self.grid = grid_of(faces, max(scene.largest, 2.0 * largest), largest + skin, self.loops.mark_cells)
        rows, last = np.zeros(len(there) + 1, np.int64), np.zeros(1, np.int64)
        empty = np.empty(0, np.int64)
        self.near = Near(
            (LawNumbers(*[0.0] * 4),) * len(there), np.zeros((len(there), 2)), rows, np.empty(0, np.int32),
            np.empty(0, np.int8), last, empty, np.empty((MOST, 4)), np.empty(MOST, np.int64),
        )  # fmt: skip
        self.between, self.deepest = laws_between(scene, there), np.zeros(3)
        self._pairs = Pairs(0, None, np.zeros(1, np.int64), np.empty(0, np.int32))
        self._full, self._sums, self._work = np.zeros(1, np.int64), np.zeros((len(there), 4)), np.zeros(6)
        self._held: tuple[Any, ...] = ()

    def seen_from(self, wall: int, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places of corners (m), without those that a wall does not meet."""
        own = self.corner["wall"]
        return np.where((self.meets[own, wall] == 1) & (self._gone[own] == 0), x, np.nan), y

    def state(self, constants: Constants, memory: Memory | None, walls: Any) -> BodyState:
        """Arguments of the loops; springs go on as those of `memory` do."""
        held = self._held
        if not held or held[0] is not constants or held[1] is not memory or held[2] is not self.near:
            own, d = None, self.discs
            if memory is not None:
                slots = Slots(d.partner, d.sigma, d.spring, d.roll, d.touched)
                own = memory._replace(slots=slots, ids=d.ids, full=self._full)
            corners_beside = CornersBeside(
                self._faces, self._gone, self.near, walls.moves, walls.chain, walls.around, self._sums
            )
            corners = State(d, self._pairs, corners_beside, constants, own, self._work)
            bodies = BodyState(self.corner, self.between, self.deepest, corners, self.grid, self.meets)
            self._held = held = constants, memory, self.near, bodies
        return held[3]

    def trouble(self, walls: Any) -> str:
        """Fault of bodies, in words; empty for nothing."""
        overlap, corner, face = self.deepest.tolist()
        self.deepest[:] = 0.0
        own = self.corner["radius"][self.corner["wall"] == int(corner)]
        limit = min(LARGEST_OVERLAP * float(own.min(initial=np.inf)), self.scene.overlap_limit or np.inf)
        if overlap > limit:
            return (
                f"'{walls.names[int(corner)]}' and '{walls.names[int(face)]}' overlap by {overlap:z.4g} m, beyond the "
                f"limit of {limit:z.4g} m: the contact is too soft for a body of this mass and speed; give the body or "
                "the wall a stiffness of its own, or a larger corner_radius"
            )
        if self._full[0]:
            return f"a corner touches more than the {SLOTS} faces that it can remember; give it a larger corner_radius"
        (xlo, xhi), (ylo, yhi) = self.scene.domain
        for number in self.numbers:
            x, y = walls.centre_of(number)
            if not (xlo <= x <= xhi and ylo <= y <= yhi):
                return (
                    f"body '{walls.names[number]}' has left the domain at ({x:z.4g}, {y:z.4g}) m: widen domain, or put "
                    "a wall there"
                )
        return ""


FOR_EVER = np.iinfo(np.int64).max
"""Step at which a wall goes that stays."""
UPWARDS = 1
"""The axis along which a tailgate goes."""


def _way_of(motion: Motion) -> WallMotion:
    """Kind of motion of a wall."""
    if motion.kind is None:
        return WallMotion.STANDS
    if motion.holding:
        return WallMotion.TAILGATE
    return WallMotion.LOADED if motion.load else WallMotion.BODY if motion.free else WallMotion.FOLLOWS


def _load(
    mass: float, inertia: float, force: Sequence[float], arm: Sequence[float], free: Sequence[float], begin: float
) -> np.ndarray:
    """A row of `Moves.load`."""
    row = np.empty(LoadColumns.width())
    row[LoadColumns.MASS], row[LoadColumns.INERTIA], row[LoadColumns.BEGIN] = mass, inertia, begin
    row[LoadColumns.FORCE], row[LoadColumns.ARM], row[LoadColumns.FREE] = force, arm, free
    return row


def _pressed(scene: Scene, names: list[str]) -> PressedSums | None:
    """Sums of the stretches whose pressure a scene asks for, wall by wall."""
    if not scene.pressure:
        return None
    numbers = [names.index(one.wall) for one in scene.pressure]
    first = np.searchsorted(numbers, np.arange(len(names) + 1)).astype(np.int64)
    ends = np.array([(one.begin, one.end) for one in scene.pressure])
    return PressedSums(first, ends, np.zeros((len(ends), 3)))


def _moves(walls: Sequence[MovingWall], faces: Faces, scene: Scene, skin: float) -> Moves:
    """The tracks of walls, some of which move."""
    count = len(walls)
    track = [one.motion.track for one in walls]
    moving = [_way_of(one.motion) for one in walls]
    rows, pushed = np.zeros((count, LoadColumns.width())), np.zeros((count, PushedColumns.width()))
    for row, state, (_, motion) in zip(rows, pushed, walls, strict=True):
        begun = motion.went
        if load := motion.load:
            axes = load.axis != "y", load.axis != "x", False
            row[:] = _load(load.mass, load.mass, load.force, (0.0, 0.0), axes, load.begin)
        elif free := motion.free:
            row[:] = _load(free.mass, free.inertia_there, free.weight, free.arm, free.freedom, free.begin)
            velocity = np.multiply((*free.velocity, free.spin), free.freedom)
            state[PushedColumns.SPEED] = state[PushedColumns.BEFORE] = velocity
        elif motion.holding:
            begin = scene.time(motion.holding.first) if begun is None else -inf
            row[:] = _load(inf, inf, (0.0, 0.0), (0.0, 0.0), (0.0, 1.0, 0.0), begin)
        if begun is not None:
            free_there, half = row[LoadColumns.FREE], begun.half or begun.speed
            state[PushedColumns.PLACE] = begun.pose
            state[PushedColumns.SPEED] = np.multiply(half, free_there)
            state[PushedColumns.BEFORE] = np.multiply(begun.before or half, free_there)
    centre = np.array([one.motion.about for one in walls], float).reshape(-1, 2)
    extrapolated = scene.integrator == "leapfrog_extrapolated"
    clock, now = np.zeros(StepClockColumns.width()), np.zeros((count, PlacedColumns.width()))
    clock[StepClockColumns.START], clock[StepClockColumns.DT] = scene.settle_steps, scene.time_step
    clock[StepClockColumns.HALF_SKIN], clock[StepClockColumns.EXTRAPOLATES] = 0.5 * skin, extrapolated
    now[:, PlacedColumns.C] = 1.0
    return Moves(
        np.concatenate(track), np.cumsum([0, *map(len, track)]), np.array(moving), centre,
        now, np.zeros((count, 3)),
        np.array([_far(faces, wall, *centre[wall]) for wall in range(count)]), rows, pushed,
        np.zeros((count, WallLoadsColumns.width())), clock,
    )  # fmt: skip


def _resistance(load: np.ndarray) -> np.ndarray:
    """Mass along x and y, and moment of inertia, of a row of `Moves.load`."""
    mass = load[LoadColumns.MASS]
    return np.array([mass, mass, load[LoadColumns.INERTIA]])


def _far(faces: Faces, wall: int, x: float, y: float) -> float:
    """Largest distance of a wall's faces from a point, m; infinite of a wall without end."""
    own = boxes(faces, deep=False)[faces.first[wall] : faces.first[wall + 1]]
    corners = np.abs(own - [x, x, y, y]).max(axis=0, initial=0.0)
    return float(np.hypot(corners[:2].max(), corners[2:].max())) if np.isfinite(corners).all() else inf


def _chains(scene: Scene, names: list[str], faces: Faces) -> tuple[np.ndarray, np.ndarray]:
    """Number of the chain of each face in the slots of discs, and its length where it is closed, else 0, m.

    Chains count over all walls of the scene, so that a wall that goes changes no other's. Along a wall across the seam
    of a periodic channel the foot of a disc repeats with the period.
    """
    begins, count = {}, 0
    walls = {wall.name: wall for wall, _ in scene.walls}
    for wall in walls.values():
        begins[wall.name] = count
        count += len(wall.chains())
    chain, around = np.empty(len(faces.codes), np.int64), np.zeros(len(faces.codes))
    for index, name in enumerate(names):
        number = begins[name]
        first, last = faces.first[index], faces.first[index + 1]
        while first < last:
            end = first + 1
            while end < last and faces.codes[end, BEFORE] == end - 1:
                end += 1
            chain[first:end] = -1 - number
            if scene.period is not None and scene.crosses(walls[name]):
                around[first:end] = scene.period
            elif faces.codes[first, BEFORE] >= 0:
                around[first:end] = faces.shape[first:end, LENGTH].sum()
            first, number = end, number + 1
    return chain, around


class Walls:
    """Walls of a scene, and the discs near those that are there.

    Parameters
    ----------
    scene : Scene
    loops : Loops
    step : int
        Step at which they are looked at.
    skin : float
        Of the neighbour list, m.

    Attributes
    ----------
    names : list of str
    until, gone : ndarray, shape (walls,)
        Step from which each wall is gone, and whether it is now: 1 or 0.
    faces : Faces
    near : Near
    moves : Moves or None
        None where all walls are at rest.
    chain, around : ndarray, shape (faces,)
        As in `Memory`.
    bodies : Bodies or None
    grid : FaceGrid
    sums : ndarray, shape (walls, 4)
        `SumsOnWallColumns`, per m of width.
    pressed : PressedSums or None
        None where no pressure is requested.
    """

    def __init__(self, scene: Scene, loops: Loops, step: int, skin: float):
        self._loops = loops
        self._there = there = scene.walls
        walls = [one.wall for one in there]
        self.until = np.array([min(one.motion.gone, FOR_EVER) for one in there], np.int64)
        self.gone = np.zeros(len(there), np.int8)
        self.names = [wall.name for wall in walls]
        self.faces: Faces = lay([(wall.chains(), wall.deep) for wall in walls])
        self.moves = _moves(there, self.faces, scene, skin) if any(one.motion.kind for one in there) else None
        # from where the discs were when their list was made, they have moved by half a skin at most; and so has a wall
        reach = 0.5 * scene.largest + (0.5 if self.moves is None else 1.0) * skin
        self.grid: FaceGrid = grid_of(self.faces, scene.largest, reach, loops.mark_cells)
        self.sums = np.zeros((len(walls), SumsOnWallColumns.width()))
        self.pressed = _pressed(scene, self.names)
        about = [one.motion.about if one.motion.kind else one.wall.moment_point for one in there]
        rows, last = np.zeros(len(walls) + 1, np.int64), np.zeros(1, np.int64)
        self.near = Near(
            tuple(scene.law_numbers(one.wall.name) for one in there), np.array(about, float).reshape(-1, 2), rows,
            np.empty(0, np.int32), np.empty(0, np.int8), last, np.empty(0, np.int64), np.empty((MOST, 4)),
            np.empty(MOST, np.int64),
        )  # fmt: skip
        self.chain, self.around = _chains(scene, self.names, self.faces)
        free = any(one.motion.free for one in there)
        self.bodies = Bodies(scene, self.faces, self.gone, loops, skin) if free else None
        self.take_away(step)
        self.place(step)

    def take_away(self, step: int) -> None:
        """Take away the walls that are gone at a step; what they have felt stays."""
        self.gone[:] = self.until <= step
        if self.moves is not None:
            self.moves.moving[self.gone == 1] = WallMotion.STANDS

    def end_start(self, begun: Mapping[str, WallState], limit: float) -> None:
        """Speeds of the half step before the start of walls that go on, from that of the step and the force there.

        Where both are those of the earlier run but for round-off, `limit` (m/s), it takes the bits of that.
        """
        if self.moves is None:
            return
        dt = self.moves.clock[StepClockColumns.DT]
        for name, one in begun.items():
            wall = self.names.index(name)
            row, load = self.moves.pushed[wall], self.moves.load[wall]
            free, speed = load[LoadColumns.FREE], np.array(one.speed)
            kick = 0.5 * dt * free / _resistance(load)
            row[PushedColumns.SPEED] = free * speed - kick * self._pull(wall)
            if one.half is not None and one.force is not None:
                off = row[PushedColumns.SPEED] - one.half, kick * (row[PushedColumns.FORCE] - one.force)
                if (np.abs(off) * [1.0, 1.0, self.moves.far[wall]] <= limit).all():
                    row[PushedColumns.SPEED], row[PushedColumns.FORCE] = one.half, one.force
            self.moves.now[wall, PlacedColumns.CENTRED] = free * speed

    def _pull(self, wall: int) -> np.ndarray:
        """Force on a wall that is pushed (N/m), its constant one included, and moment (N)."""
        assert self.moves is not None
        load, now = self.moves.load[wall], self.moves.now[wall]
        arm, force = load[LoadColumns.ARM], load[LoadColumns.FORCE]
        c, s = now[PlacedColumns.C], now[PlacedColumns.S]
        moment = (c * arm[0] - s * arm[1]) * force[1] - (s * arm[0] + c * arm[1]) * force[0]
        return self.moves.pushed[wall, PushedColumns.FORCE] + np.array([*force, moment])

    def place(self, step: int) -> None:
        """Put the walls where they are at a step."""
        if self.moves is not None:
            self.moves.clock[StepClockColumns.STEP] = step
            self._loops.place_walls(self.moves, step)

    def poses(self) -> dict[str, Pose]:
        """Poses of the walls whose pose is state of the run, by name."""
        if self.moves is None:
            return {}
        walls = zip(self.names, self.moves.moving, self.moves.pushed, strict=True)
        return {
            name: Pose(*row[PushedColumns.PLACE].tolist()) for name, moving, row in walls if moving >= WallMotion.LOADED
        }

    def centre_of(self, wall: int, placed: np.ndarray | None = None) -> tuple[float, float]:
        """Centre of mass of a body, m; where it is `placed` as of `Moves.now`, or now."""
        assert self.moves is not None  # a body moves
        now = (self.moves.now if placed is None else placed)[wall]
        (x, y, _), c, s = now[PlacedColumns.NOW].tolist(), float(now[PlacedColumns.C]), float(now[PlacedColumns.S])
        arm, about = self.moves.load[wall, LoadColumns.ARM].tolist(), self.moves.centre[wall].tolist()
        return about[0] + x + c * arm[0] - s * arm[1], about[1] + y + s * arm[0] + c * arm[1]

    def body_rows(
        self, forces: Mapping[str, np.ndarray], placed: np.ndarray
    ) -> Iterator[tuple[str, tuple[float, ...]]]:
        """Name of each body; centre of mass (m), turn (rad), velocities (m/s, rad/s), and the force given with it."""
        if self.bodies is None or self.moves is None:
            return
        for wall in self.bodies.numbers:
            name, now = self.names[wall], placed[wall]
            here_x, here_y, angle = now[PlacedColumns.NOW].tolist()
            x, y = self.centre_of(wall, placed)
            ax, ay = x - self.moves.centre[wall, 0] - here_x, y - self.moves.centre[wall, 1] - here_y
            vx, vy, spin = now[PlacedColumns.CENTRED].tolist()
            yield name, (x, y, angle, vx - spin * float(ay), vy + spin * float(ax), spin, *forces[name].tolist())

    def body_state(self, constants: Constants, memory: Memory | None) -> BodyState | None:
        """Bodies as the loops take them; None where there are none."""
        return None if self.bodies is None else self.bodies.state(constants, memory, self)

    def trouble_of_bodies(self) -> str:
        """Fault of bodies, in words; empty for nothing."""
        return "" if self.bodies is None else self.bodies.trouble(self)

    def set_speeds(self, speeds: Mapping[str, float]) -> None:
        """Let tailgates go up at these speeds, m/s, by name."""
        if self.moves is None:
            return
        for name, speed in speeds.items():
            self.moves.pushed[self.names.index(name), PushedColumns.SPEED][UPWARDS] = speed

    def trouble_at_seam(self, scene: Scene) -> str:
        """Fault of a wall that discs have pushed to the seam of a periodic channel; empty for nothing.

        Until the walls are listed again it may go on by half a skin.
        """
        if scene.period is None:
            return ""
        half_skin = 0.0 if self.moves is None else float(self.moves.clock[StepClockColumns.HALF_SKIN])
        margin = max(scene.largest, 0.5 * scene.largest + half_skin)
        for name, pose in self.poses().items():
            low, high = scene.wall(name).extent[0]
            if wrong := at_seam(name, (low + pose.x, high + pose.x), scene.domain[0], margin):
                return wrong
        return ""

    def lid_energy(self) -> tuple[float, float]:
        """Kinetic energy of the walls that discs push, and that of their place in the force on them, J/m.

        That of a body begins with its velocity where it is held first.
        """
        kinetic = place = 0.0
        if self.moves is None:
            return kinetic, place
        dt, now = self.moves.clock[StepClockColumns.DT], self.moves.now
        for wall, (row, load) in enumerate(zip(self.moves.pushed, self.moves.load, strict=True)):
            if self.moves.moving[wall] not in (WallMotion.LOADED, WallMotion.BODY):
                continue
            force, arm, free = load[LoadColumns.FORCE], load[LoadColumns.ARM], load[LoadColumns.FREE]
            c, s = now[wall, PlacedColumns.C], now[wall, PlacedColumns.S]
            turned = np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])
            resist = _resistance(load)
            half = 0.5 * dt * self._pull(wall) / resist if row[PushedColumns.PHASE] == Phase.HAS_MOVED else 0.0
            kinetic += 0.5 * float((free * resist) @ (row[PushedColumns.SPEED] + half) ** 2)
            place -= float(force @ (free[:2] * row[PushedColumns.PLACE][:2] + turned - arm))
        return kinetic, place

    def _inward(self, wall: int, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Discs in the frame in which a wall is at rest; its pose is then that of the list."""
        if self.moves is None or not self.moves.moving[wall]:
            return x, y
        (cx, cy), now = self.moves.centre[wall], self.moves.now[wall]
        here_x, here_y, _ = self.moves.listed[wall] = now[PlacedColumns.NOW]
        c, s = now[PlacedColumns.C], now[PlacedColumns.S]
        dx, dy = x - cx - here_x, y - cy - here_y
        return cx + c * dx + s * dy, cy - s * dx + c * dy

    def list_discs(self, n: int, x: np.ndarray, y: np.ndarray) -> None:
        """List the discs near each wall, and the corners of bodies; `x` and `y` (m) are of the first n discs."""
        self.near = _list_near(self._loops, self, self.grid, self.near, lambda wall: (n, *self._inward(wall, x, y)))
        self.list_corners()

    def list_discs_again(self, n: int, x: np.ndarray, y: np.ndarray, step: int) -> None:
        """The same as lists of an earlier run were made: its walls where they were then."""
        went = [one.motion.went for one in self._there]
        if self.moves is None or not any(went):
            self.list_discs(n, x, y)
            return
        places = self.moves.pushed[:, PushedColumns.PLACE]
        now = places.copy()
        half_skin, far = float(self.moves.clock[StepClockColumns.HALF_SKIN]), self.moves.far
        for place, one, size in zip(places, went, far, strict=True):
            if one is not None and one.listed is not None:
                dx, dy, turn = place - one.listed
                if np.hypot(dx, dy) + (size * abs(turn) if turn else 0.0) <= half_skin:  # else it is of no list
                    place[:] = one.listed
        self.place(step)
        self.list_discs(n, x, y)
        places[:] = now
        self.place(step)

    def list_corners(self) -> None:
        """List the corners near each wall, where there are bodies."""
        bodies, moves = self.bodies, self.moves
        if bodies is None or moves is None:
            return
        own, (x, y) = bodies.corner["wall"], (bodies.corner["x"], bodies.corner["y"])
        (cx, cy), now = moves.centre[own].T, moves.now[own].T
        dx, dy = x - cx, y - cy
        (here_x, here_y, _), c, s = now[PlacedColumns.NOW], now[PlacedColumns.C], now[PlacedColumns.S]
        places = cx + here_x + c * dx - s * dy, cy + here_y + s * dx + c * dy
        bodies.near = _list_near(
            bodies.loops, self, bodies.grid, bodies.near,
            lambda wall: (bodies.discs.n, *self._inward(wall, *bodies.seen_from(wall, *places))),
        )  # fmt: skip

    def list_all(self, n: int) -> None:
        """List every disc at every wall with all its faces."""
        first, there = self.faces.first, self.gone == 0
        parts = [np.tile(np.arange(*ends), n) for ends, here in zip(pairwise(first), there, strict=True) if here]
        counts = np.repeat(np.diff(first)[there], n)
        last = np.concatenate([[0], np.cumsum(counts)])
        discs = np.tile(np.arange(n, dtype=np.int32), int(there.sum()))
        rows = n * np.concatenate([[0], np.cumsum(there)])
        self.put(rows, discs, 0 * discs, last, np.concatenate([*parts, np.empty(0, np.int64)]))
        self.list_corners()

    @property
    def listed(self) -> dict[str, np.ndarray]:
        """The present lists, without their room."""
        return _lists_of(self.near)

    def put(self, rows: ArrayLike, discs: ArrayLike, plain: ArrayLike, last: ArrayLike, faces: ArrayLike) -> None:
        """Take lists such as `listed` gives."""
        self.near = _with_lists(self.near, rows, discs, plain, last, faces)

    def require_lists(self, n: int) -> None:
        """Raise ValueError where lists name other discs than the first n, other faces than those of their walls."""
        _require_lists(self.near, self.faces, n)
        if self.bodies is not None:
            _require_lists(self.bodies.near, self.faces, self.bodies.discs.n)

    @property
    def listed_corners(self) -> dict[str, np.ndarray]:
        """The present lists of corners; empty without bodies."""
        return {} if self.bodies is None else _lists_of(self.bodies.near)

    def put_corners(self, lists: Mapping[str, ArrayLike]) -> None:
        """Take lists such as `listed_corners` gives."""
        if self.bodies is not None:
            self.bodies.near = _with_lists(self.bodies.near, **lists)


def _list_near(
    loops: Loops, walls: Walls, grid: FaceGrid, near: Near, seen: Callable[[int], tuple[int, np.ndarray, np.ndarray]]
) -> Near:
    """Lists of what is near each wall; `seen` gives number and places (m) as the frame of a wall has them."""
    row = count = 0
    for wall, gone in enumerate(walls.gone.tolist()):
        near.rows[wall + 1] = row
        if gone:
            continue
        places = seen(wall)
        while True:
            counts = loops.list_near(places, wall, walls.faces, grid, near, (row, count))
            if counts[1] >= 0:
                break
            near = _with_room(near, 2 * len(near.discs) + 256, 2 * len(near.faces) + 4 * len(grid.faces) + 256)
        row, count = counts
        near.rows[wall + 1] = row
    return near


def _with_room(near: Near, rows: int, faces: int) -> Near:
    """Longer lists for at least so many rows and faces."""
    return near._replace(
        discs=np.pad(near.discs, (0, max(0, rows - len(near.discs)))),
        plain=np.pad(near.plain, (0, max(0, rows - len(near.plain)))),
        last=np.pad(near.last, (0, max(0, rows + 1 - len(near.last)))),
        faces=np.pad(near.faces, (0, max(0, faces - len(near.faces)))),
    )


def _lists_of(near: Near) -> dict[str, np.ndarray]:
    """The present lists, without their room."""
    rows = near.rows[-1]
    last = near.last[: rows + 1]
    listed = {"rows": near.rows, "discs": near.discs[:rows], "plain": near.plain[:rows]}
    return {**listed, "last": last, "faces": near.faces[: last[-1]]}


def _with_lists(
    near: Near, rows: ArrayLike, discs: ArrayLike, plain: ArrayLike, last: ArrayLike, faces: ArrayLike
) -> Near:
    """Lists such as `_lists_of` gives."""
    return near._replace(
        rows=np.array(rows, np.int64),
        discs=np.array(discs, np.int32),
        plain=np.array(plain, np.int8),
        last=np.array(last, np.int64),
        faces=np.array(faces, np.int64),
    )


def _require_lists(near: Near, faces: Faces, n: int) -> None:
    """Raise ValueError where lists of what is near walls would lead the core beyond n discs or the faces."""
    walls = len(faces.first) - 1
    rows, discs, plain, last, listed = near.rows, near.discs, near.plain, near.last, near.faces
    if rows.shape != (walls + 1,) or rows[0] or (np.diff(rows) < 0).any() or not discs.ndim == plain.ndim == 1:
        raise ValueError("its list of discs near walls is of other walls")
    count = int(rows[-1])
    if discs.size != count or plain.size != count or last.shape != (count + 1,) or listed.ndim != 1:
        raise ValueError("its list of discs near walls has other rows")
    if last[0] or (np.diff(last) < 1).any() or last[-1] != listed.size:
        raise ValueError("its list of discs near walls names no faces")
    wall = np.repeat(np.arange(walls), np.diff(rows))
    of_face = np.repeat(wall, np.diff(last))
    if discs.size and not 0 <= discs.min() <= discs.max() < n:
        raise ValueError(f"its list of discs near walls names disc {discs.max()} of {n}")
    if ((listed < faces.first[of_face]) | (listed >= faces.first[of_face + 1])).any():
        raise ValueError("its list of discs near walls names faces of others")
    if ((np.diff(discs) <= 0) & (np.diff(wall) == 0)).any() or ((plain != 0) & (np.diff(last) > 1)).any():
        raise ValueError("its list of discs near walls is not in order")
