# SPDX-License-Identifier: GPL-2.0-or-later
"""Arrays and numbers as the loops of the native engine take them, those of the core (`bound`) and of the twin.

What a scene lacks is None: `omega` (no spin), `dashpot_x` (no energy ledger), `ux` (damping with the half-step velocity
rather than the extrapolated one), `grid` and `owner` (neighbour list rather than the thesis' cells), `radius` (equal
discs), `shift` (no periodic x), `fixed` (all discs move).

Where discs have radii of their own, the constants of `LawNumbers` are those of a size of 1 m, and those of
`StepConstants` of a radius of 1 m: mass and weight grow as R^2, the moment of inertia as R^4.

Time levels. Between steps the arrays hold x_n, v_(n-1/2) and F_n, so that velocity Verlet and the thesis'
leap-frog are the same loop: they differ in the velocity that dashpot and friction see, v_(n-1/2) in LAMMPS' order
of operations, 1.5 v_(n-1/2) - 0.5 v_(n-3/2) in thesis (3.7)-(3.9). The velocity at the step is
v_n = v_(n-1/2) + dt F_n / (2 m).
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from lammps_jump.core.law import LawNumbers
from lammps_jump.physics.law import Slots
from lammps_jump.scene.chains import Faces
from lammps_jump.scene.faces import FaceGrid


class StepConstants(NamedTuple):
    """Constants of the kick and the drift, of a disc or of a radius of 1 m; `reach2`: the square of half the skin."""

    time_step: float
    mass: float
    inertia: float
    weight_x: float
    weight_y: float
    reach2: float


class Pairs(NamedTuple):
    """Half list of pairs: rows in use; disc of each row, None if it is the row's number; neighbours by row.

    In a periodic channel `shift` (m) is what a row adds to x of its disc: rows of images follow the others.
    The first `sorted` rows are those of their numbers, with neighbours of higher numbers, which ascend. They change
    where `listed_as` does.
    """

    rows: int
    owner: np.ndarray | None
    start: np.ndarray
    neighbours: np.ndarray
    shift: np.ndarray | None = None
    sorted: int = 0
    listed_as: int = 0


class Grid(NamedTuple):
    """Fixed cells of the thesis' contact search; `first`: first list entry of each cell, `used`: rows in use."""

    x_low: float
    y_low: float
    inverse: float
    columns: int
    rows: int
    first: np.ndarray
    used: np.ndarray


class Near(NamedTuple):
    """Discs near walls, a wall at a time.

    Attributes
    ----------
    laws : tuple of LawNumbers
        Of each wall.
    about : ndarray, shape (walls, 2)
        Point that the moment on each wall is taken about, m.
    rows : ndarray of int64, shape (walls + 1,)
        First row of each wall.
    discs : ndarray of int32
        Disc of each row.
    plain : ndarray of int8
        1 where the row has one straight face whose ends are out of reach.
    last : ndarray of int64
        The faces of row r are ``faces[last[r]:last[r + 1]]``.
    faces : ndarray of int64
    found, which : ndarray
        Room for the contacts of one disc (`scene.faces.touching`).
    """

    laws: tuple[LawNumbers, ...]
    about: np.ndarray
    rows: np.ndarray
    discs: np.ndarray
    plain: np.ndarray
    last: np.ndarray
    faces: np.ndarray
    found: np.ndarray
    which: np.ndarray


class Moves(NamedTuple):
    """Walls that move: their tracks, and where they are; columns are those of `lammps_jump.core.columns`.

    Attributes
    ----------
    track, first : ndarray
        Rows of wall w: ``track[first[w]:first[w + 1]]`` (`lammps_jump.scene.tracks`); none of a wall at rest.
    moving : ndarray of int64, shape (walls,)
        A `WallMotion`.
    centre : ndarray, shape (walls, 2)
        Point of turning where the case has it, m.
    now : ndarray, shape (walls, 11)
        `PlacedColumns`.
    listed : ndarray, shape (walls, 3)
        Pose for which the discs near it were listed.
    far : ndarray, shape (walls,)
        Largest distance of a face from the centre, m.
    load : ndarray, shape (walls, 10)
        `LoadColumns`, of pushed walls.
    pushed : ndarray, shape (walls, 13)
        `PushedColumns`, of pushed walls.
    wall_loads : ndarray, shape (walls, 12)
        `WallLoadsColumns`.
    clock : ndarray, shape (5,)
        `StepClockColumns`.
    """

    track: np.ndarray
    first: np.ndarray
    moving: np.ndarray
    centre: np.ndarray
    now: np.ndarray
    listed: np.ndarray
    far: np.ndarray
    load: np.ndarray
    pushed: np.ndarray
    wall_loads: np.ndarray
    clock: np.ndarray


class Memory(NamedTuple):
    """Memory of contacts with springs; of two discs the one with the larger id does.

    Attributes
    ----------
    slots : Slots
    ids : ndarray of int64
        Of the discs.
    chain : ndarray of int64, shape (faces,)
        What represents the chain of a face in the slots (`lammps_jump.physics.law`).
    around : ndarray, shape (faces,)
        Length of the chain of a face where it is closed, else 0, m.
    full : ndarray of int64, shape (1,)
        Takes the id of a disc that has no slot left.
    time_step : float
        s; 0 where springs stay as they are.
    """

    slots: Slots
    ids: np.ndarray
    chain: np.ndarray
    around: np.ndarray
    full: np.ndarray
    time_step: float


class BodyState(NamedTuple):
    """Bodies, and the corners with which they meet walls and each other.

    Attributes
    ----------
    corner : ndarray, shape (corners,)
        Records `CORNER`, each in the frame in which its wall is at rest.
    between : ndarray, shape (walls, walls, numbers + 1)
        Contact of a corner of the first wall with a face of the second: `LawNumbers` with dashpot and slope of the
        viscous ramp over the root of the effective mass; what the dashpot is less, as it sees the half step.
    deepest : ndarray, shape (3,)
        Largest overlap since it was looked at (m), and the walls of its corner and of its face.
    corners : State
        Corners as discs: the faces near them, and what they remember.
    grid : FaceGrid
        Cells that find the faces near corners.
    meets : ndarray of int8, shape (walls, walls)
        1 where corners of the first wall meet faces of the second.
    """

    corner: np.ndarray
    between: np.ndarray
    deepest: np.ndarray
    corners: State
    grid: FaceGrid
    meets: np.ndarray


CORNER = np.dtype([*((name, float) for name in ("x", "y", "radius", "tx0", "ty0", "tx1", "ty1")), ("wall", np.int64)])
"""A corner (`lammps_jump.scene.bodies`) and its wall."""


class Constants(NamedTuple):
    """Constants of a scene: diameter of equal discs (m), law of two discs, motion. `Near.laws` has those of walls."""

    diameter: float
    law: LawNumbers
    motion: StepConstants


class Lists(NamedTuple):
    """Arguments of making lists anew.

    Attributes
    ----------
    domain : (float, float, float, float)
        xlo, xhi, ylo, yhi, m.
    skin, widest : float
        Pairs are listed whose surfaces are closer than the skin; diameter of the largest disc, m.
    inside : bool
        Whether loops may make them within `Loops.advance`.
    made : ndarray, shape (2,)
        Takes the number of lists that were made there, and the wall time that they took, s.
    period : float
        Length of a periodic channel, m; 0 of another.
    slope_work : ndarray, shape (1,)
        Takes the work of weight on discs that go round it, J per m of width.
    ends : ndarray, shape (walls, 2)
        Of a periodic channel: ends along x of each wall where the case has it, m.
    """

    domain: tuple[float, float, float, float]
    skin: float
    widest: float
    inside: bool
    made: np.ndarray
    period: float
    slope_work: np.ndarray
    ends: np.ndarray


class PressedSums(NamedTuple):
    """Forces of the discs on stretches of outlines, summed over the steps of a window.

    Attributes
    ----------
    first : ndarray of int64, shape (walls + 1,)
        First stretch of each wall.
    ends : ndarray, shape (stretches, 2), m
        Along the outline of its wall.
    sums : ndarray, shape (stretches, 3)
        Force across and along the outline, N/m, and the first times the place, N.
    """

    first: np.ndarray
    ends: np.ndarray
    sums: np.ndarray


class State(NamedTuple):
    """All that the loops take.

    Attributes
    ----------
    discs : discs.Discs
    pairs : Pairs
    walls : walls.Walls
    constants : Constants
    memory : Memory or None
    work : ndarray, shape (6,)
        `EnergyBalance.work`.
    grid : Grid or None
        Pairs are then searched anew every step.
    bodies : BodyState or None
    lists : Lists or None
        None where lists are not made by the loops.
    """

    discs: Any
    pairs: Pairs
    walls: Any
    constants: Constants
    memory: Memory | None
    work: np.ndarray
    grid: Grid | None = None
    bodies: BodyState | None = None
    lists: Lists | None = None


class StationStep(NamedTuple):
    """Two planes at `left` and `width` further on (m), which move at `speed` (m/s), at one step.

    `moved`: count the discs that crossed one in the drift before; `pushed`: count the forces of this step.
    """

    left: float
    width: float
    speed: float
    moved: bool
    pushed: bool


ContactVelocities = tuple[np.ndarray, np.ndarray, np.ndarray | None]
"""Velocities of discs (m/s) and spins (rad/s)."""


DONE, LIST_STALE, CHECK_OVERLAP = range(3)
"""Tasks that `Loops.advance` leaves to its caller: forces alone, a list that is too old, or a look for overlaps."""
LISTED, NO_ROOM = -1, -2
"""Numbers that `Loops.list_pairs` returns in place of a disc outside the domain."""


class Loops(Protocol):
    """The loops under `NativeSimulation`: those of the core, or of the twin."""

    runs_alone: bool
    """Says whether they step a scene with all that happens at its steps: `Core.run`."""

    @property
    def threads(self) -> int:
        """Threads that take part now; they change no bit of what the loops do."""

    def advance(self, state: State, steps: int, forces_pending: bool) -> tuple[int, int]:
        """Up to `steps` drifts with forces between them, and before them where `forces_pending`; without steps these.

        The forces after the last drift are left to the caller: what happens at a step happens between its drift and its
        forces. Returns the drifts done and why it stopped (`DONE`, `LIST_STALE`, `CHECK_OVERLAP`). With a `grid` the
        list is too old where a disc is outside the grid or there is no room for neighbours.
        """

    def place_walls(self, moves: Moves, step: int) -> None:
        """Put the moving walls where they are at a step."""

    def elastic(self, state: State, chosen: np.ndarray | None = None) -> tuple[float, float, int, int]:
        """Elastic energy (J per m of width), largest overlap (m), its disc, and its wall or -1 (two discs).

        With `chosen`, a mask of shape (n,), it is that of the contacts of these discs alone.
        """

    def contacts(
        self, state: State, at_step: ContactVelocities, seen: ContactVelocities, who: np.ndarray, rows: np.ndarray
    ) -> int:
        """List the contacts with the forces of the velocities that they have `seen`; -1 where the arrays are too short.

        ``who[k]`` takes the id of the disc that the force acts on and that of the other, or -1 - wall; ``found[k]`` the
        point (m), the force (N per m of width) and the power of dashpots and friction (W per m of width). The power is
        with the velocities at the step: dt times its sum is what the energy balance books for the kick.
        """

    def give_sizes(self, state: State, known: int, own: np.ndarray) -> float:
        """Radii ``own[id - known - 1]`` (m) for the discs with ids above `known`, after a step and with its forces.

        The velocities of the step stay: the first half of the step's kick is that of the old mass, the second half
        that of the new one. Returns what this gives to the energy (J per m of width).
        """

    def between(self, state: State, stations: StationStep, sums: np.ndarray) -> None:
        """Add a step to the sums between stations (`ledger.StationLedger`)."""

    def outside(self, n: int, x: np.ndarray, y: np.ndarray, domain: tuple[float, ...]) -> int:
        """Index of one of n discs outside the domain or not a number, or -1."""

    def list_pairs(self, state: State) -> int:
        """Sort the discs by cell and list all pairs closer than the skin; a disc outside, `LISTED` or `NO_ROOM`.

        Where a disc is outside the domain (or its position is NaN), its index is returned and nothing else is done.
        """

    def closest(self, discs: Any, x: float, y: float) -> float:
        """Square of the distance from a point to the closest disc (m^2); infinite where there is none."""

    def append_row(self, discs: Any, i: int, reach: float) -> bool:
        """List row of disc i, the newest: every older disc within the reach (m); False where there is no room.

        The reach is of centres, and of surfaces where discs have radii of their own.
        """

    def image_rows(self, discs: Any, reach: tuple[float, float, float], owner: np.ndarray, shift: np.ndarray) -> int:
        """List pairs across the seam of a periodic channel; the number of rows, or -1 where `neighbours` is short.

        `reach` holds that of the list (of centres; of surfaces where discs have radii of their own), the largest of
        centres, and the left end of the channel (m).
        """

    def cell_pairs(self, state: State) -> int:
        """Touching pairs by the thesis' contact search (its chapter 3); the number of rows, or -1.

        -1: a disc is outside the grid, or `neighbours` is short.
        """

    def list_near(
        self, seen: tuple[int, np.ndarray, np.ndarray], wall: int, faces: Faces, grid: FaceGrid, near: Near,
        found: tuple[int, int],
    ) -> tuple[int, int]:  # fmt: skip
        """List the discs near one wall, in its own frame, and the faces near each; faces -1: there is no room.

        `seen` holds the number of discs and their places (m), `found` the rows and faces to go on from.
        """

    def mark_cells(
        self, faces: Faces, box: np.ndarray, ends: tuple[int, int], cells: tuple[float, float, float, int, int],
        reach: float, start: np.ndarray, listed: np.ndarray,
    ) -> None:  # fmt: skip
        """As `lammps_jump.scene.faces.mark_cells`."""
