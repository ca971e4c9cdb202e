# SPDX-License-Identifier: GPL-2.0-or-later
"""The core under the native engine: its state, bound to the arrays of Python, and its functions (``core/native.h``)."""

from __future__ import annotations

from ctypes import POINTER, byref, c_double, c_int64, c_void_p
from math import nan
from typing import Any, ClassVar

import numpy as np

from lammps_jump.core.library import INTEGER, INTEGERS, REAL, REALS, Struct, function
from lammps_jump.scene.chains import Faces
from lammps_jump.scene.near import Grid as NearGrid

from .arrays import Box, Cells, Constants, Memory, Moves, Near, Seen, State, Stations

ARRAY, MAYBE = c_void_p, c_void_p
FACE = np.dtype([("codes", np.int64, 8), ("shape", float, 15)])
"""A row of `Faces` as the core has it."""

DISCS = "ids x y vx vy fx fy x0 y0 ux uy omega torque uomega dash_x dash_y slide_x slide_y radius fixed"
MOVES = "track first moving centre now listed far lid pushed clock"
MEMORY = "chain around full"


def _fields(kind: Any, names: str) -> list[tuple[str, Any]]:
    return [(name, kind) for name in names.split()]


class jump_state(Struct):
    """State of the engine, in the order of ``native.h``."""

    _fields_: ClassVar = [
        *_fields(c_int64, "n"),
        *_fields(c_void_p, DISCS),
        *_fields(c_int64, "rows"),
        *_fields(c_void_p, "owner shift start neighbours"),
        *_fields(c_int64, "room"),
        *_fields(c_double, "grid_x grid_y grid_inverse"),
        *_fields(c_int64, "grid_columns grid_rows"),
        *_fields(c_void_p, "grid_first grid_used"),
        *_fields(c_int64, "walls"),
        *_fields(c_void_p, "faces deep numbers about near_rows near_discs near_plain near_last near_faces wall_sum"),
        *_fields(c_void_p, "track track_first moving centre placed listed far lid pushed clock"),
        *_fields(c_double, "diameter stiffness damping tangential"),
        *_fields(c_double, "time_step mass inertia weight_x weight_y reach2"),
        *_fields(c_double, "friction sign touch"),
        *_fields(c_int64, "slots"),
        *_fields(c_void_p, "partner sigma spring roll used chain around full"),
        *_fields(c_double, "memory_step spring_ratio spring_damping rolling_k rolling_damping rolling_friction"),
        *_fields(c_void_p, "rolling_at work"),
    ]


class jump_grid(Struct):
    """Cells that find the faces of one wall."""

    _fields_: ClassVar = [
        *_fields(c_void_p, "faces box start listed"),
        *_fields(c_int64, "deep columns rows first_cell"),
        *_fields(c_double, "xlo xhi ylo yhi left low inverse reach"),
    ]


class jump_stations(Struct):
    """As `Stations`."""

    _fields_: ClassVar = [*_fields(c_double, "left width speed"), *_fields(c_int64, "moved pushed")]


class jump_seen(Struct):
    """Velocities and spins."""

    _fields_: ClassVar = _fields(c_void_p, "vx vy spin")


STATE, GRID = POINTER(jump_state), POINTER(jump_grid)
_advance = function("jump_advance", STATE, INTEGER, INTEGER, POINTER(c_int64), result=INTEGER)
_place_walls = function("jump_place_walls", STATE, INTEGER)
_search_cells = function("jump_search_cells", STATE, result=INTEGER)
_elastic = function("jump_elastic", STATE, INTEGER, INTEGER, POINTER(c_double), INTEGERS, result=REAL)
_contacts = function(
    "jump_contacts", STATE, POINTER(jump_seen), POINTER(jump_seen), ARRAY, ARRAY, INTEGER, result=INTEGER
)
_give_sizes = function("jump_give_sizes", STATE, INTEGER, REALS, result=REAL)
_between = function("jump_between", STATE, POINTER(jump_stations), REALS)
_extent = function("jump_extent", INTEGER, REALS, REALS, REALS, REALS, result=INTEGER)
_sort = function("jump_sort", INTEGER, REALS, REALS, REALS, INTEGERS, INTEGERS, INTEGERS, INTEGERS)
_permute = function("jump_permute", INTEGER, INTEGER, ARRAY, INTEGERS, ARRAY)
_pair_list = function(
    "jump_pair_list", INTEGER, REALS, REALS, MAYBE, REAL, INTEGER, INTEGERS, INTEGERS, INTEGERS, ARRAY, INTEGER,
    result=INTEGER,
)  # fmt: skip
_image_rows = function(
    "jump_image_rows", INTEGER, REALS, REALS, MAYBE, REALS, INTEGERS, ARRAY, INTEGER, ARRAY, REALS, ARRAY,
    result=INTEGER,
)  # fmt: skip
_list_near = function(
    "jump_list_near", GRID, INTEGER, REALS, REALS, ARRAY, ARRAY, INTEGERS, INTEGERS, INTEGERS, INTEGERS
)
_mark_cells = function("jump_mark_cells", GRID, INTEGER, INTEGER, INTEGERS, MAYBE)


def _at(array: np.ndarray | None) -> int | None:
    """Address of an array, which must be contiguous."""
    if array is None:
        return None
    if not array.flags.c_contiguous:
        raise ValueError(f"the core reads contiguous arrays, not one of strides {array.strides}")
    return array.ctypes.data


def records_of(faces: Faces) -> np.ndarray:
    """Faces as the core has them."""
    found = np.empty(len(faces.codes), FACE)
    found["codes"], found["shape"] = faces.codes, faces.shape
    return found


class Core:
    """The loops of the core, for one simulation: arrays are bound once, and again where they are new ones."""

    def __init__(self) -> None:
        self._state = jump_state()
        self._held: dict[str, Any] = {}
        self._faces: tuple[Faces | None, np.ndarray | None] = (None, None)

    def _put(self, name: str, array: np.ndarray | None) -> None:
        """Bind an array; it is held as long as the core may read it."""
        if name not in self._held or self._held[name] is not array:
            setattr(self._state, name, _at(array))
            self._held[name] = array

    def _records(self, faces: Faces) -> np.ndarray:
        if self._faces[0] is not faces:
            self._faces = faces, records_of(faces)
        return self._faces[1]

    def _bind(self, state: State) -> Any:
        """The state of the core for this one."""
        bound, put, d, walls = self._state, self._put, state.discs, state.walls
        bound.n = d.n
        for name in DISCS.split():
            put(name, getattr(d, name))
        self._bind_pairs(state)
        bound.walls = len(walls.faces.deep)
        put("faces", self._records(walls.faces))
        near = walls.near
        for name, array in (
            ("deep", walls.faces.deep), ("numbers", near.numbers), ("about", near.about), ("near_rows", near.rows),
            ("near_discs", near.discs), ("near_plain", near.plain), ("near_last", near.last),
            ("near_faces", near.faces), ("wall_sum", walls.sums), ("work", state.work),
        ):  # fmt: skip
            put(name, array)
        self._bind_moves(walls.moves)
        if self._held.get("constants") is not state.constants:
            self._bind_constants(state.constants)
        self._bind_memory(state.memory)
        return byref(bound)

    def _bind_pairs(self, state: State) -> None:
        bound, pairs, grid = self._state, state.pairs, state.grid
        bound.rows, bound.room = pairs.rows, pairs.neighbours.size
        for name, array in zip(("owner", "start", "neighbours", "shift"), pairs[1:], strict=True):
            self._put(name, array)
        self._put("grid_first", None if grid is None else grid.first)
        self._put("grid_used", None if grid is None else grid.used)
        if grid is not None:
            bound.grid_x, bound.grid_y, bound.grid_inverse, bound.grid_columns, bound.grid_rows = grid[:5]

    def _bind_moves(self, moves: Moves | None) -> None:
        for name in MOVES.split():
            there = {"first": "track_first", "now": "placed"}.get(name, name)
            self._put(there, None if moves is None else getattr(moves, name))

    def _bind_constants(self, constants: Constants) -> None:
        law, motion, *terms = constants
        for of in (law, motion):
            for name, value in of._asdict().items():
                setattr(self._state, name, value)
        for name, term in zip(("friction", "sign", "touch"), terms, strict=True):
            setattr(self._state, name, nan if term is None else term)
        self._held["constants"] = constants

    def _bind_memory(self, memory: Memory | None) -> None:
        bound, put = self._state, self._put
        slots = ("partner", "sigma", "spring", "roll", "used")
        if memory is None:
            for name in (*slots, *MEMORY.split(), "rolling_at"):
                put(name, None)
            return
        for name, array in zip(slots, memory.slots, strict=True):
            put(name, array)
        for name in (*MEMORY.split(), "rolling_at"):
            put(name, getattr(memory, name))
        bound.slots = memory.slots.partner.shape[1]
        bound.memory_step, bound.spring_ratio, bound.spring_damping = memory.time_step, memory.ratio, memory.damping
        bound.rolling_k, bound.rolling_damping, bound.rolling_friction = memory.rolling

    # --- steps ------------------------------------------------------------------------------------------------------

    def advance(self, state: State, steps: int, owed: bool) -> tuple[int, bool]:
        """As `Loops.advance`."""
        old = c_int64()
        done = _advance(self._bind(state), steps, bool(owed), byref(old))
        return done, bool(old.value)

    def place_walls(self, moves: Moves, step: int) -> None:
        """As `Loops.place_walls`."""
        self._state.walls = moves.moving.size
        self._bind_moves(moves)
        _place_walls(byref(self._state), step)

    # --- sums -------------------------------------------------------------------------------------------------------

    def elastic(self, state: State, begin: int, known: int) -> tuple[float, float, int, int]:
        """As `Loops.elastic`."""
        worst, where = c_double(), np.empty(2, np.int64)
        energy = _elastic(self._bind(state), begin, known, byref(worst), where)
        return energy, worst.value, int(where[0]), int(where[1])

    def contacts(self, state: State, at_step: Seen, seen: Seen, who: np.ndarray, found: np.ndarray) -> int:
        """As `Loops.contacts`."""
        velocities = (jump_seen(*map(_at, one)) for one in (at_step, seen))
        return _contacts(self._bind(state), *map(byref, velocities), _at(who), _at(found), len(who))

    def give_sizes(self, state: State, known: int, own: np.ndarray) -> float:
        """As `Loops.give_sizes`."""
        return _give_sizes(self._bind(state), known, own)

    def between(self, state: State, stations: Stations, sums: np.ndarray) -> None:
        """As `Loops.between`."""
        _between(self._bind(state), byref(jump_stations(*stations)), sums)

    # --- lists ------------------------------------------------------------------------------------------------------

    def extent(self, n: int, x: np.ndarray, y: np.ndarray, domain: np.ndarray) -> Box:
        """As `Loops.extent`."""
        box = np.empty(4)
        lost = _extent(n, x, y, domain, box)
        a, b, c, d = box.tolist()
        return a, b, c, d, lost

    def sort(self, n: int, x: np.ndarray, y: np.ndarray, cells: Cells, discs: Any) -> None:
        """As `Loops.sort`."""
        start = discs.cell_start[: (cells.columns + 2) * (cells.rows + 2) + 2]
        counts = np.array([*cells[3:], start.size], np.int64)
        _sort(n, x, y, np.array(cells[:3]), counts, start, discs.cell, discs.order)

    def permute(self, n: int, source: np.ndarray, place: np.ndarray, scratch: np.ndarray) -> None:
        """As `Loops.permute`."""
        _permute(n, source.shape[1] if source.ndim == 2 else 1, _at(source), place, _at(scratch))

    def pair_list(self, discs: Any, reach: float, rows: int) -> int:
        """As `Loops.pair_list`."""
        d = discs
        return _pair_list(
            d.n, d.x, d.y, _at(d.radius), reach, rows, d.cell_start, d.cell, d.start, _at(d.neighbours),
            d.neighbours.size,
        )  # fmt: skip

    def image_rows(self, discs: Any, reach: tuple[float, float, float], owner: np.ndarray, shift: np.ndarray) -> int:
        """As `Loops.image_rows`."""
        d = discs
        right = np.empty(d.n + 1, np.int32)
        return _image_rows(
            d.n, d.x, d.y, _at(d.radius), np.array([*reach, d.period]), d.start, _at(d.neighbours), d.neighbours.size,
            _at(owner), shift, _at(right),
        )  # fmt: skip

    def cell_pairs(self, state: State) -> int:
        """As `Loops.cell_pairs`."""
        return _search_cells(self._bind(state))

    def list_near(
        self, seen: tuple[int, np.ndarray, np.ndarray], wall: int, faces: Faces, grid: NearGrid, near: Near,
        found: tuple[int, int],
    ) -> tuple[int, int]:  # fmt: skip
        """As `Loops.list_near`."""
        ends = np.array(found, np.int64)
        room = np.array([near.last.size, near.faces.size], np.int64)
        _list_near(
            byref(self._grid(wall, faces, grid)), *seen, _at(near.discs), _at(near.plain), near.last, near.faces, room,
            ends,
        )  # fmt: skip
        return int(ends[0]), int(ends[1])

    def _grid(self, wall: int, faces: Faces, grid: NearGrid) -> jump_grid:
        return jump_grid(
            _at(self._records(faces)), _at(grid.box), _at(grid.start), _at(grid.faces), faces.deep[wall],
            *grid.cells[wall], *grid.wall_box[wall], *grid.place[wall], grid.reach,
        )  # fmt: skip

    def mark_cells(
        self, faces: Faces, box: np.ndarray, ends: tuple[int, int], cells: tuple, reach: float, start: np.ndarray,
        listed: np.ndarray,
    ) -> None:  # fmt: skip
        """As `lammps_jump.scene.near.mark_cells`."""
        *place, columns, rows = cells
        grid = jump_grid(
            _at(self._records(faces)), _at(box), None, None, 0, columns, rows, 0, *[0.0] * 4, *place, reach
        )
        _mark_cells(byref(grid), *ends, start, _at(listed) if listed.size else None)
