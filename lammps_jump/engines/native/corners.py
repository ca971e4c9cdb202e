# SPDX-License-Identifier: GPL-2.0-or-later
"""Corners of walls as discs that meet the faces of bodies, and corners of bodies that meet those of walls."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lammps_jump.core.law import LawNumbers
from lammps_jump.engines.native.arrays import (
    CORNER,
    BodyState,
    Constants,
    Loops,
    Memory,
    Near,
    Pairs,
    PressedSums,
    State,
)
from lammps_jump.physics.law import Slots
from lammps_jump.scene.chains import Faces
from lammps_jump.scene.faces import MOST, grid_of
from lammps_jump.scene.meeting import LARGEST_OVERLAP, SLOTS, corners, laws_between, meets
from lammps_jump.scene.scene import Scene


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
            beside = CornersBeside(
                self._faces, self._gone, self.near, walls.moves, walls.chain, walls.around, self._sums
            )
            corners = State(d, self._pairs, beside, constants, own, self._work)
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
