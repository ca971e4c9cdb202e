# SPDX-License-Identifier: GPL-2.0-or-later
"""The discs in play as a structure of arrays with room to grow, and the neighbour list that belongs to them."""

from __future__ import annotations

from itertools import count
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.core.library import copied
from lammps_jump.dump.ended import check_list
from lammps_jump.scene.scene import EarlierState, Scene

from .arrays import LISTED, Loops, Pairs, State

LISTS = count(1)
"""Numbers of lists, which no two have."""
NOTHING = np.empty(0, [("order", np.int64)])
ROUND = 1e-13
"""Difference of velocities that is round-off, over d/dt."""


def starting(scene: Scene, earlier: EarlierState) -> np.ndarray:
    """Velocity (m/s) and spin (rad/s) at the start of discs that come from an earlier run, by id, shape (n, 3)."""
    return np.column_stack([scene.velocities, earlier.spins])


class DiscArray(NamedTuple):
    """An array of the discs: its kind, whether a sort takes it along, numbers of a disc (0: one, without an axis)."""

    kind: type = float
    sorted: bool = True
    width: int = 0


def columns_of(scene: Scene, *, ledger: bool) -> dict[str, DiscArray | None]:
    """Every array of the discs by its name; None for one that the scene does not need.

    What a sort does not take along is zero or equal then, or made anew.
    """
    extrapolated, sized, slots = scene.integrator == "leapfrog_extrapolated", scene.sizes is not None, scene.slots
    moved, left = DiscArray(), DiscArray(sorted=False)
    groups = (
        ("ids", DiscArray(np.int64), True),
        ("x y vx vy", moved, True),
        ("fx fy", DiscArray(sorted=sized), True),  # they hold the weight when discs are sorted
        ("x0 y0", left, True),
        ("ux uy", moved, extrapolated),
        ("omega", moved, scene.rotation),
        ("torque", left, scene.rotation),
        ("uomega", moved, scene.rotation and extrapolated),
        ("dashpot_x dashpot_y", left, ledger),
        ("friction_x friction_y", left, ledger and scene.rubs),
        ("radius", moved, sized),
        ("partner", DiscArray(np.int64, width=slots), slots > 0),
        ("sigma spring roll", DiscArray(width=slots), slots > 0),
        ("fixed", DiscArray(np.int64), scene.fixed is not None),
    )
    return {name: column if there else None for names, column, there in groups for name in names.split()}


class EnteringDisc(NamedTuple):
    """A disc that enters: its id, place (m) and velocity (m/s)."""

    id: int
    x: float
    y: float
    vx: float
    vy: float


class DiscArrays:
    """Arrays of the discs, sorted in memory by cell; only the first `n` entries count.

    They begin as the scene has them. The older velocity of the extrapolation is that of the start. Sorting, removal,
    insertion and the file of the state go through `columns` alone: what lies in them stays with its disc.

    Attributes
    ----------
    columns : dict of DiscArray
        The arrays that the scene needs; each is an attribute, and None is in the place of the others.
    ids : ndarray of int64, shape (room,)
    x, y, vx, vy, fx, fy : ndarray, shape (room,)
        Position (m), velocity v_(n-1/2) (m/s) and force F_n (N per m of width).
    x0, y0 : ndarray
        Where each disc was when the list was made.
    ux, uy, uomega : ndarray or None
        Extrapolated velocities of the thesis' leap-frog.
    omega, torque : ndarray or None
        Spin (rad/s) and torque where discs spin.
    dashpot_x … friction_y : ndarray or None
        Dashpot and friction force on each disc, for the energy ledger.
    radius : ndarray or None
        m, where discs are not equal.
    partner : ndarray of int64, shape (room, slots), or None
        What each slot of a disc remembers: the id of a disc, or -1 - c for chain c of its walls; 0 in an empty slot.
    sigma, spring, roll : ndarray, shape (room, slots), or None
        Arc length of the foot on a wall, elongation of the tangential spring and of the rolling spring, m.
    fixed : ndarray of int64 or None
        1 for discs that stay where they are.
    owner, shift : ndarray or None
        Of the rows of the list in a periodic channel (`loops.Pairs`).
    sorted_rows, listed_as : int
        As `Pairs.sorted` and `Pairs.listed_as`.
    before : ndarray
        What an earlier run had of `lists.BITS`, in this order of the discs; empty where its lists were not taken.
    touched : ndarray of int8, shape (room, slots)
        Whether a contact of this step has the slot; 0 between steps.
    """

    ids: np.ndarray
    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    x0: np.ndarray
    y0: np.ndarray
    ux: np.ndarray | None
    omega: np.ndarray | None
    dashpot_x: np.ndarray | None
    friction_x: np.ndarray | None
    radius: np.ndarray | None
    partner: np.ndarray | None
    fixed: np.ndarray | None
    uy: Any  # from here on an array where the one that it belongs to is there, else None
    uomega: Any
    torque: Any
    dashpot_y: Any
    friction_y: Any
    sigma: Any
    spring: Any
    roll: Any

    def __init__(self, scene: Scene, loops: Loops, *, ledger: bool):
        self._loops = loops
        self.n = n = len(scene.positions)
        self.room = max(64, int(1.25 * n))
        self.slots = scene.slots
        every = columns_of(scene, ledger=ledger)
        self.columns = {name: column for name, column in every.items() if column}
        for name, column in every.items():
            shape = (self.room, column.width) if column and column.width else self.room
            setattr(self, name, np.zeros(shape, column.kind) if column else None)
        self.ids[:n] = np.arange(1, n + 1)
        if self.radius is not None:
            self.radius[:n] = 0.5 * scene.diameters(self.ids[:n])
        self.x[:n], self.y[:n] = scene.positions.T
        self.vx[:n], self.vy[:n] = scene.velocities.T
        if self.ux is not None:
            self.ux[:n], self.uy[:n] = scene.velocities.T
        if scene.fixed is not None and self.fixed is not None:
            self.fixed[:n] = scene.fixed.holds(self.ids[:n])
        if scene.earlier is not None and self.slots:
            for name, rows in scene.earlier.slots(self.slots).items():
                getattr(self, name)[:n] = rows
        self.period = scene.period
        self.before = NOTHING
        self.sorted_rows = self.listed_as = 0
        self.owner: np.ndarray | None = None
        self.shift: np.ndarray | None = None
        self.start = np.zeros(self._rows + 1, np.int64)
        self.neighbours = np.empty(6 * self.room + 256, np.int32)
        self._make_work_arrays()

    @property
    def _rows(self) -> int:
        """Room for rows of the list: each disc may have an image."""
        return self.room if self.period is None else 2 * self.room

    @property
    def pairs(self) -> Pairs:
        """The list as the loops read it."""
        rows = self.n if self.shift is None else self.shift.size
        return Pairs(rows, self.owner, self.start, self.neighbours, self.shift, self.sorted_rows, self.listed_as)

    def set_velocities(self, rows: np.ndarray) -> None:
        """Velocity (m/s) and spin (rad/s) of each disc, shape (n, 3), by id; the older ones of the thesis too."""
        rows = rows[self.ids[: self.n] - 1].T
        for names in (("vx", "vy", "omega"), ("ux", "uy", "uomega")):
            for name, values in zip(names, rows, strict=True):
                if name in self.columns:
                    getattr(self, name)[: self.n] = values

    def listed(self, pairs: Pairs) -> dict[str, np.ndarray]:
        """The present neighbour list, by the names of `put_list`."""
        images = {} if self.owner is None or self.shift is None else {"owner": self.owner, "shift": self.shift}
        return {"start": pairs.start[: pairs.rows + 1], "discs": pairs.neighbours[: pairs.start[pairs.rows]], **images}

    def put_list(
        self, start: np.ndarray, discs: np.ndarray, owner: np.ndarray | None = None, shift: np.ndarray | None = None
    ) -> None:
        """Take a neighbour list such as `listed` gives; ValueError where it is none of these discs."""
        self.sorted_rows = check_list(self.n, self.period or 0.0, start, discs, owner, shift)
        self.owner, self.shift = owner, shift
        self.start[: len(start)] = start
        if self.neighbours.size < discs.size:
            self.neighbours = np.empty(2 * discs.size, np.int32)
        self.neighbours[: discs.size] = discs
        self.listed_as = next(LISTS)

    def take_lists(self, scene: Scene, skin: float) -> bool:
        """Take order in memory and list of an earlier run whose discs these all are; False where that does not suit."""
        exact = {} if scene.earlier is None else scene.earlier.exact
        if not exact or exact["skin"] != skin or len(exact["discs"]) != self.n:
            return False
        own = exact["discs"]
        moving = self.n - len(exact["fixed"])
        fixed = scene.diameters(np.arange(moving + 1, self.n + 1))
        if exact["period"] != (self.period or 0.0) or (exact["fixed"] != scene.positions[moving:]).any():
            return False
        if (exact["fixed_diameters"] != fixed).any():
            return False
        for name in self.columns:
            held = getattr(self, name)[: self.n]
            held[:] = held[own["order"]]
        self.x0[: self.n], self.y0[: self.n] = own["x0"], own["y0"]
        self.before = own
        self.put_list(**{name[5:]: array for name, array in exact.items() if name.startswith("list_")})
        return True

    def see_half_step(self, scene: Scene, earlier: EarlierState) -> None:
        """Take the velocities that the last forces of the earlier run saw."""
        self.set_velocities(np.where(np.isnan(earlier.half), starting(scene, earlier), earlier.half))
        for name in ("ux", "uy", "uomega"):
            if name in (self.before.dtype.names or ()) and name in self.columns:
                getattr(self, name)[: self.n] = self.before[name]

    def keep_bits(self, scene: Scene, earlier: EarlierState, kicks: tuple[Any, Any]) -> None:
        """Take the bits of the run whose lists were taken, where half step and force are its own but for round-off.

        `kicks` are `half_kicks`, by which a force is held against a velocity.
        """
        own, small = self.before, ROUND * scene.diameter / scene.time_step
        if not len(own):
            return
        half = earlier.half[self.ids[: self.n] - 1].T
        units = (small, small, small / scene.radius)
        moves = ("vx", "vy", "omega"), ("fx", "fy", "torque"), (kicks[0], *kicks), half, units
        for name, force, kick, before, limit in zip(*moves, strict=True):
            if name in self.columns and force in (own.dtype.names or ()):
                now, pushed = getattr(self, name)[: self.n], getattr(self, force)[: self.n]
                same = (np.abs(now - before) <= limit) & (np.abs(kick * (pushed - own[force])) <= limit)
                now[same], pushed[same] = before[same], own[force][same]

    def _make_work_arrays(self) -> None:
        self.touched = np.zeros((self.room, self.slots), np.int8)

    def grow(self) -> None:
        """Half as much room again."""
        more = self.room // 2
        self.room += more
        for name in self.columns:
            array = getattr(self, name)
            setattr(self, name, np.concatenate([array, np.zeros((more, *array.shape[1:]), array.dtype)]))
        self.start = np.concatenate([self.start, np.zeros(self._rows + 1 - len(self.start), np.int64)])
        self._make_work_arrays()

    def take_room(self, room: int, places: dict[str, int]) -> None:
        """Take arrays with more room from these addresses."""
        self.room = room
        for name, place in places.items():
            before = getattr(self, name)
            shape = (room, *before.shape[1:])
            setattr(self, name, copied(place, before.dtype.type, int(np.prod(shape))).reshape(shape))
        self._make_work_arrays()

    def outside(self, scene: Scene, skin: float) -> int:
        """Index of a disc outside the domain, or -1; of a periodic one discs may leave by a skin (m) between lists."""
        (a, b), (c, e) = scene.domain
        beyond = 0.0 if self.period is None else skin
        return self._loops.outside(self.n, self.x, self.y, (a - beyond, b + beyond, c, e))

    def place(self, i: int, scene: Scene, step: int) -> str:
        """Place of a disc, in words."""
        return f"{self.ids[i]} at ({self.x[i]:z.6g}, {self.y[i]:z.6g}) m, time {scene.time(step):z.6g} s (step {step}),"

    def lost(self, i: int, scene: Scene, step: int) -> str:
        """Message about a disc outside the domain."""
        (a, b), (c, e) = scene.domain
        if not (np.isfinite(self.x[i]) and np.isfinite(self.y[i])):
            return (
                f"the position of disc {self.place(i, scene, step)} is not a number: the run has blown up. Lower "
                "run.time_step_fraction and look for discs that overlap at the start."
            )
        return (
            f"disc {self.place(i, scene, step)} has left the domain x {a:zg} … {b:zg} m, y {c:zg} … {e:zg} m. Put an "
            "outflow where discs leave, close the gap between the walls, or enlarge the domain; where nothing should "
            "leave, lower run.time_step_fraction."
        )

    def wrap(self, low: float, period: float) -> None:
        """Put discs that have left a periodic channel, `period` long from `low` on (m), in at its other end."""
        x = self.x[: self.n]
        x -= period * np.floor((x - low) / period)

    def list_pairs(self, state: State) -> int:
        """Sort by cell and list all pairs as `Loops.list_pairs` does, with those across the seam of a periodic channel.

        Returns the index of a disc outside the domain, or -1.
        """
        lists = state.lists
        assert lists is not None
        while True:
            lost = self._loops.list_pairs(state._replace(pairs=self.pairs))
            if lost >= 0:
                return lost
            if lost == LISTED and self._list_images(lists.skin, lists.widest, lists.domain[0]):
                return -1
            self.neighbours = np.empty(2 * self.neighbours.size, np.int32)

    def _list_images(self, skin: float, diameter: float, low: float) -> bool:
        """Rows of the list for pairs across the seam of a periodic channel; False where there is no room for them.

        `diameter` (m) is that of equal discs, or the largest.
        """
        if self.period is None:
            return True
        owner, shift = np.empty(self._rows, np.int32), np.empty(self._rows)
        reach = diameter + skin
        rows = self._loops.image_rows(self, (reach if self.radius is None else skin, reach, low), owner, shift)
        self.owner, self.shift = owner[:rows], shift[:rows]
        return rows >= 0

    def append(self, new: EnteringDisc, weight: tuple[float, float], skin: float, diameter: float) -> None:
        """Adds an `EnteringDisc` after the others, with its row of the list up to a skin (m).

        `weight` (N) begins its force.

        It has this diameter (m).
        """
        if self.n == self.room:
            self.grow()
        i = self.n
        for name in self.columns:
            getattr(self, name)[i] = 0
        self.ids[i] = new.id
        self.x[i] = self.x0[i] = new.x
        self.y[i] = self.y0[i] = new.y
        self.vx[i], self.vy[i] = new.vx, new.vy
        self.fx[i], self.fy[i] = weight
        if self.ux is not None:
            self.ux[i], self.uy[i] = new.vx, new.vy
        reach = diameter + skin
        if self.radius is not None:
            self.radius[i], reach = 0.5 * diameter, skin
        while not self._loops.append_row(self, i, reach):
            self.neighbours = np.pad(self.neighbours, (0, self.neighbours.size))
        self.n = i + 1

    def is_free(self, x: float, y: float, clearance: float) -> bool:
        """Tell whether no disc is closer to a point than this (m)."""
        return self._loops.closest(self, x, y) >= clearance * clearance

    def keep(self, mask: np.ndarray) -> None:
        """Drop the discs where mask, shape (n,), is False; the list is then out of date."""
        left = int(mask.sum())
        for name in self.columns:
            array = getattr(self, name)
            array[:left] = array[: self.n][mask]
        self.n = left
