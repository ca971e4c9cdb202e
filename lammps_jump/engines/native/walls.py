# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as the loops read them: flat faces, the cells that find them, and the list of discs near each wall."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.scene.chains import BEFORE, LENGTH, Faces, boxes, lay
from lammps_jump.scene.faces import MOST
from lammps_jump.scene.motion import Motion, MovingWall, Pose, at_seam
from lammps_jump.scene.near import Grid, grid_of
from lammps_jump.scene.scene import Scene

from .arrays import Loops, Moves, Near
from .constants import wall_numbers

FOLLOWS, LID, HELD = 1, 2, 3
"""How a wall moves: along its track, pushed by the discs, or at a speed that is set from time to time (`Moves.moving`).
The last is a lid of infinite mass."""


def _way_of(motion: Motion) -> int:
    """Number of how a wall moves; 0: it stands."""
    if motion.kind is None:
        return 0
    return HELD if motion.holding else LID if motion.load else FOLLOWS


def _moves(walls: list[MovingWall], faces: Faces, scene: Scene, skin: float) -> Moves:
    """The tracks of walls, some of which move."""
    count = len(walls)
    track = [one.motion.track for one in walls]
    moving = [_way_of(one.motion) for one in walls]
    lid = np.zeros((count, 6))
    for row, (_, motion) in zip(lid, walls, strict=True):
        if load := motion.load:
            row[:] = load.mass, *load.force, load.axis != "y", load.axis != "x", load.begin
        elif motion.holding:
            row[:] = inf, 0.0, 0.0, 0.0, 1.0, scene.time(motion.holding.first)
    centre = np.array([one.motion.about for one in walls], float).reshape(-1, 2)
    clock = np.array([0.0, scene.settle_steps, scene.time_step, 0.5 * skin])
    return Moves(
        np.concatenate(track), np.cumsum([0, *map(len, track)]), np.array(moving), centre,
        np.zeros((count, 11)) + np.eye(11)[3], np.zeros((count, 3)),
        np.array([_far(faces, wall, *centre[wall]) for wall in range(count)]), lid, np.zeros((count, 6)), clock,
    )  # fmt: skip


def _far(faces: Faces, wall: int, x: float, y: float) -> float:
    """Largest distance of a wall's faces from a point, m; infinite of a wall without end."""
    own = boxes(faces, deep=False)[faces.first[wall] : faces.first[wall + 1]]
    corners = np.abs(own - [x, x, y, y]).max(axis=0, initial=0.0)
    return float(np.hypot(corners[:2].max(), corners[2:].max())) if np.isfinite(corners).all() else inf


def _chains(scene: Scene, names: list[str], faces: Faces) -> tuple[np.ndarray, np.ndarray]:
    """What stands for the chain of each face in the slots of discs, and its length where it is closed, else 0, m.

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
    """Walls that are there now, and the discs near them.

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
    faces : Faces
    near : Near
    moves : Moves or None
        None where all walls stand.
    chain, around : ndarray, shape (faces,)
        As in `Memory`.
    sums : ndarray, shape (walls, 4)
        Force on each wall (N per m of width), moment (N) and power on the discs (W/m), summed over steps.
    """

    def __init__(self, scene: Scene, loops: Loops, step: int, skin: float):
        self._loops = loops
        there = [one for one in scene.walls if one.motion.pose(step) is not None]
        walls = [one.wall for one in there]
        self.names = [wall.name for wall in walls]
        self.faces: Faces = lay([(wall.chains(), wall.deep) for wall in walls])
        self.moves = _moves(there, self.faces, scene, skin) if any(one.motion.kind for one in there) else None
        # from where the discs were when their list was made, they have moved by half a skin at most; and so has a wall
        reach = 0.5 * scene.largest + (0.5 if self.moves is None else 1.0) * skin
        self._grid: Grid = grid_of(self.faces, scene.largest, reach, loops.mark_cells)
        self.sums = np.zeros((len(walls), 4))
        about = [one.motion.about if one.motion.kind else one.wall.moment_point for one in there]
        rows, last = np.zeros(len(walls) + 1, np.int64), np.zeros(1, np.int64)
        self.near = Near(
            np.array([wall_numbers(scene, name) for name in self.names]).reshape(-1, 4),
            np.array(about, float).reshape(-1, 2), rows, np.empty(0, np.int32), np.empty(0, np.int8), last,
            np.empty(0, np.int64), np.empty((MOST, 4)), np.empty(MOST, np.int64),
        )  # fmt: skip
        self.chain, self.around = _chains(scene, self.names, self.faces)
        self.place(step)

    def go_on(self, before: Walls) -> None:
        """Take over the walls that discs push, where they are and as fast."""
        if self.moves is None or before.moves is None:
            return
        for row, name in zip(self.moves.pushed, self.names, strict=True):
            row[:] = before.moves.pushed[before.names.index(name)]
        self.place(int(before.moves.clock[0]))

    def place(self, step: int) -> None:
        """Put the walls where they are at a step."""
        if self.moves is not None:
            self.moves.clock[0] = step
            self._loops.place_walls(self.moves, step)

    def poses(self) -> dict[str, Pose]:
        """Poses of the walls whose pose is state of the run, by name."""
        if self.moves is None:
            return {}
        walls = zip(self.names, self.moves.moving, self.moves.pushed, strict=True)
        return {name: Pose(float(row[0]), float(row[1])) for name, moving, row in walls if moving >= LID}

    def set_speeds(self, speeds: Mapping[str, float]) -> None:
        """Let tailgates go up at these speeds, m/s, by name."""
        for name, speed in speeds.items() if self.moves is not None else ():
            self.moves.pushed[self.names.index(name), 3] = speed

    def trouble_at_seam(self, scene: Scene) -> str:
        """What is wrong with a wall that discs have pushed to the seam of a periodic channel; empty for nothing.

        Until the walls are listed again it may go on by half a skin.
        """
        if scene.period is None:
            return ""
        margin = max(scene.largest, 0.5 * scene.largest + (0.0 if self.moves is None else float(self.moves.clock[3])))
        for name, pose in self.poses().items():
            low, high = scene.wall(name).extent[0]
            if wrong := at_seam(name, (low + pose.x, high + pose.x), scene.domain[0], margin):
                return wrong
        return ""

    def lid_energy(self) -> tuple[float, float]:
        """Kinetic energy of the walls that discs push, and that of their place in the force on them, J/m."""
        kinetic = place = 0.0
        if self.moves is None:
            return kinetic, place
        step, start, dt, _ = self.moves.clock
        for row, (mass, fx, fy, free_x, free_y, begin), moving in zip(
            self.moves.pushed, self.moves.lid, self.moves.moving, strict=True
        ):
            if moving != LID or (step - start) * dt <= begin:
                continue
            for free, load, displacement, speed, push in zip(
                (free_x, free_y), (fx, fy), row[:2], row[2:4], row[4:], strict=True
            ):
                kinetic += free * 0.5 * mass * (speed + 0.5 * dt * (push + load) / mass) ** 2
                place -= free * load * displacement
        return float(kinetic), float(place)

    def _inward(self, wall: int, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Discs as the frame has them in which a wall stands; its pose is then that of the list."""
        if self.moves is None or not self.moves.moving[wall]:
            return x, y
        (cx, cy), now = self.moves.centre[wall], self.moves.now[wall]
        self.moves.listed[wall] = now[:3]
        dx, dy = x - cx - now[0], y - cy - now[1]
        return cx + now[3] * dx + now[4] * dy, cy - now[4] * dx + now[3] * dy

    def list_discs(self, n: int, x: np.ndarray, y: np.ndarray) -> None:
        """List the discs near each wall; `x` and `y` (m) are of the first n discs."""
        row = count = 0
        for wall in range(len(self.names)):
            seen_x, seen_y = self._inward(wall, x, y)
            while True:
                seen = n, seen_x, seen_y
                found = self._loops.list_near(seen, wall, self.faces, self._grid, self.near, (row, count))
                if found[1] >= 0:
                    break
                self.make_room(
                    2 * len(self.near.discs) + 256, 2 * len(self.near.faces) + 4 * len(self._grid.faces) + 256
                )
            row, count = found
            self.near.rows[wall + 1] = row

    def list_all(self, n: int) -> None:
        """List every disc at every wall with all its faces."""
        first = self.faces.first
        parts = [np.tile(np.arange(*ends), n) for ends in pairwise(first)]
        counts = np.repeat(np.diff(first), n)
        last = np.concatenate([[0], np.cumsum(counts)])
        discs = np.tile(np.arange(n, dtype=np.int32), len(self.names))
        self.put(
            n * np.arange(len(self.names) + 1), discs, 0 * discs, last, np.concatenate([*parts, np.empty(0, np.int64)])
        )

    def make_room(self, rows: int, faces: int) -> None:
        """Longer lists for at least so many rows and faces."""
        near = self.near
        self.near = near._replace(
            discs=np.pad(near.discs, (0, max(0, rows - len(near.discs)))),
            plain=np.pad(near.plain, (0, max(0, rows - len(near.plain)))),
            last=np.pad(near.last, (0, max(0, rows + 1 - len(near.last)))),
            faces=np.pad(near.faces, (0, max(0, faces - len(near.faces)))),
        )

    @property
    def listed(self) -> dict[str, np.ndarray]:
        """The lists as they stand, without their room."""
        near, rows = self.near, self.near.rows[-1]
        last = near.last[: rows + 1]
        listed = {"rows": near.rows, "discs": near.discs[:rows], "plain": near.plain[:rows]}
        return {**listed, "last": last, "faces": near.faces[: last[-1]]}

    def put(self, rows: ArrayLike, discs: ArrayLike, plain: ArrayLike, last: ArrayLike, faces: ArrayLike) -> None:
        """Take lists such as `listed` gives."""
        self.near = self.near._replace(
            rows=np.array(rows, np.int64),
            discs=np.array(discs, np.int32),
            plain=np.array(plain, np.int8),
            last=np.array(last, np.int64),
            faces=np.array(faces, np.int64),
        )
