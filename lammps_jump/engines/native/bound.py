# SPDX-License-Identifier: GPL-2.0-or-later
"""The core under the native engine: its state, bound to arrays of Python, and its functions (``step/native.h``)."""

from __future__ import annotations

import weakref
from ctypes import POINTER, Array, addressof, byref, c_char_p, c_double, c_int64, c_void_p, pointer
from typing import Any, ClassVar

import numpy as np

from lammps_jump.core.columns import PlacedColumns, RunEnd, SumsOnWallColumns
from lammps_jump.core.law import jump_law, laws_of
from lammps_jump.core.library import INTEGER, INTEGERS, REAL, REALS, Struct, copied, entry, function
from lammps_jump.scene.chains import Faces, records_of
from lammps_jump.scene.faces import FaceGrid

from .arrays import BodyState, Constants, ContactVelocities, Lists, Memory, Moves, Near, PressedSums, State, StationStep

ARRAY = c_void_p
DISCS = "ids x y vx vy fx fy x0 y0 ux uy omega torque uomega dashpot_x dashpot_y friction_x friction_y radius fixed"
MOVES = "track first moving centre now listed far load pushed wall_loads clock"
MEMORY = "chain around full"
WINDOW_WIDTH = SumsOnWallColumns.width() + PlacedColumns.width()
"""Numbers of a wall in a window of the probes."""


def fields(kind: Any, names: str) -> list[tuple[str, Any]]:
    """Fields of a struct that have one kind."""
    return [(name, kind) for name in names.split()]


class jump_state(Struct):
    """State of the engine, in the order of ``native.h``."""

    _fields_: ClassVar = [
        *fields(c_int64, "n disc_room"),
        *fields(c_void_p, DISCS),
        *fields(c_int64, "rows sorted listed_as"),
        *fields(c_void_p, "owner shift start neighbours"),
        *fields(c_int64, "room"),
        *fields(c_double, "grid_x grid_y grid_inverse"),
        *fields(c_int64, "grid_columns grid_rows"),
        *fields(c_void_p, "grid_first grid_used"),
        *fields(c_int64, "walls"),
        *fields(
            c_void_p, "faces deep gone at_wall about near_rows near_discs near_plain near_last near_faces wall_sum"
        ),
        *fields(c_void_p, "track track_first moving centre placed listed far load pushed wall_loads clock"),
        *fields(c_double, "diameter"),
        ("pair", jump_law),
        *fields(c_double, "time_step mass inertia weight_x weight_y reach2"),
        *fields(c_int64, "slots slot_row"),
        *fields(c_void_p, "partner sigma spring roll used chain around full"),
        *fields(c_double, "memory_step"),
        *fields(c_void_p, "work corners corner between deepest lists pressed"),
    ]


class jump_grid(Struct):
    """Cells that find the faces of one wall."""

    _fields_: ClassVar = [
        *fields(c_void_p, "faces box start listed"),
        *fields(c_int64, "deep columns rows first_cell"),
        *fields(c_double, "xlo xhi ylo yhi left low inverse reach"),
    ]


class jump_lists(Struct):
    """As `Lists`, with the arrays that a sort takes along, and the room for discs near walls."""

    _fields_: ClassVar = [
        *fields(c_double, "xlo xhi ylo yhi skin widest"),
        *fields(c_int64, "columns all_columns"),
        *fields(c_void_p, "column width grids"),
        *fields(c_int64, "rows_room faces_room"),
        *fields(c_void_p, "made"),
        *fields(c_double, "period"),
        *fields(c_void_p, "slope_work ends corner_grids"),
        *fields(c_int64, "corner_rows_room corner_faces_room"),
        *fields(c_void_p, "meets"),
    ]


class jump_pressed(Struct):
    """As `PressedSums`."""

    _fields_: ClassVar = [*fields(c_int64, "stretches"), *fields(c_void_p, "first ends sums")]


class jump_stations(Struct):
    """As `StationStep`."""

    _fields_: ClassVar = [*fields(c_double, "left width speed"), *fields(c_int64, "moved pushed")]


class jump_inlet(Struct):
    """A row of an inlet."""

    _fields_: ClassVar = [
        *fields(c_double, "x y vx vy clearance"),
        *fields(c_int64, "first every limit first_turn turns"),
    ]


class jump_outlet(Struct):
    """An outlet."""

    _fields_: ClassVar = [*fields(c_double, "at"), *fields(c_int64, "axis above every")]


class jump_tailgate(Struct):
    """A tailgate (``walls/tailgate_controller.h``)."""

    _fields_: ClassVar = [
        *fields(c_int64, "first every"),
        *fields(c_double, "low high"),
        *fields(c_int64, "bins"),
        *fields(c_double, "target level proportional integral speed lowest highest area"),
    ]


class jump_events(Struct):
    """Events at certain steps (``step/events.h``)."""

    _fields_: ClassVar = [
        *fields(c_int64, "step"),
        *fields(c_double, "disc_steps"),
        *fields(c_int64, "inlets"),
        *fields(c_void_p, "inlet turn_step turn_speed entered"),
        *fields(c_double, "weight_x weight_y"),
        *fields(c_int64, "outlets"),
        *fields(c_void_p, "outlet traffic own_radius"),
        *fields(c_int64, "size_every"),
        *fields(c_void_p, "until"),
        *fields(c_int64, "tailgates"),
        *fields(c_void_p, "tailgate tailgate_wall"),
        *fields(c_int64, "window_steps window_begin"),
        *fields(c_void_p, "window_sum"),
        *fields(c_double, "station_left station_width station_speed"),
        *fields(c_int64, "station_first station_last"),
        *fields(c_void_p, "station_sums"),
        *fields(c_int64, "ledger"),
        *fields(c_double, "gravity_x gravity_y"),
        *fields(c_void_p, "exchanged"),
        *fields(c_double, "overlap_limit"),
    ]


class jump_velocities(Struct):
    """Velocities and spins."""

    _fields_: ClassVar = fields(c_void_p, "vx vy spin")


STATE, GRID = POINTER(jump_state), POINTER(jump_grid)
_partition = function("jump_partition", c_char_p, result=c_void_p)
_free_partition = function("jump_free_partition", c_void_p)
_threads = function("jump_partition_threads", c_void_p, result=INTEGER)
_advance = function("jump_advance", STATE, c_void_p, INTEGER, INTEGER, POINTER(c_int64), result=INTEGER)
_place_walls = function("jump_place_walls", STATE, INTEGER)
_run = function("jump_run", STATE, POINTER(jump_events), c_void_p, INTEGER, result=INTEGER)
_windows = function("jump_windows", c_void_p, POINTER(c_int64), result=c_void_p)
_forget_windows = function("jump_forget_windows", c_void_p)
_forget_rooms = function("jump_forget_rooms", c_void_p)
_search_cells = function("jump_search_cells", STATE, result=INTEGER)
_elastic = function("jump_elastic", STATE, c_void_p, ARRAY, POINTER(c_double), ARRAY, result=REAL)
_contacts = function(
    "jump_contacts", STATE, POINTER(jump_velocities), POINTER(jump_velocities), ARRAY, ARRAY, INTEGER, result=INTEGER
)
_give_sizes = function("jump_give_sizes", STATE, INTEGER, REALS, result=REAL)
_between = function("jump_between", STATE, POINTER(jump_stations), REALS)
_outside = function("jump_outside", INTEGER, *[ARRAY] * 3, result=INTEGER)
_list_pairs = function("jump_list_pairs", STATE, c_void_p, result=INTEGER)
_closest = function("jump_closest", INTEGER, ARRAY, ARRAY, REAL, REAL, result=REAL)
_append_row = function("jump_append_row", INTEGER, *[ARRAY] * 3, REAL, *[ARRAY] * 2, INTEGER, result=INTEGER)
_image_rows = entry(
    "jump_image_rows", INTEGER, n=INTEGER, x=ARRAY, y=ARRAY, radius=ARRAY, reach=ARRAY, start=ARRAY, neighbours=ARRAY,
    room=INTEGER, owner=ARRAY, shift=ARRAY, right=ARRAY,
)  # fmt: skip
_list_near = entry(
    "jump_list_near", grid=GRID, n=INTEGER, x=ARRAY, y=ARRAY, discs=ARRAY, plain=ARRAY, last=ARRAY, near=ARRAY,
    room=ARRAY, found=ARRAY,
)  # fmt: skip
_mark_cells = function("jump_mark_cells", GRID, INTEGER, INTEGER, INTEGERS, ARRAY)


def address(array: np.ndarray | None) -> int | None:
    """Address of an array, which must be contiguous."""
    if array is None:
        return None
    if not array.flags.c_contiguous:
        raise ValueError(f"the core reads contiguous arrays, not one of strides {array.strides}")
    return array.ctypes.data


class Core:
    """The loops of the core, for one simulation: arrays are bound once, and again where they are new ones.

    Parameters
    ----------
    threads : str
        As of `Setting.threads`.
    """

    runs_alone = True

    def __init__(self, threads: str = "1") -> None:
        self._partition = _partition(threads.encode())
        weakref.finalize(self, _free_partition, self._partition)
        self._state, self._lists = jump_state(), jump_lists()
        self._held: dict[str, Any] = {}
        self._faces: tuple[Faces, np.ndarray] | None = None
        self._pointers: dict[str, tuple[np.ndarray | None, int | None]] = {}
        self._grids: tuple[FaceGrid | None, dict[int, jump_grid]] = (None, {})
        self._corners: Core | None = None

    def _put(self, name: str, array: np.ndarray | None) -> None:
        """Bind an array; it is held as long as the core may read it."""
        if name not in self._held or self._held[name] is not array:
            setattr(self._state, name, address(array))
            self._held[name] = array

    def _records(self, faces: Faces) -> np.ndarray:
        if self._faces is None or self._faces[0] is not faces:
            self._faces = faces, records_of(faces)
        return self._faces[1]

    def _bind(self, state: State) -> Any:
        """The state of the core for this one; what is bound already is looked at as a whole."""
        bound, put, d, walls = self._state, self._put, state.discs, state.walls
        bound.n, bound.disc_room = d.n, d.room
        if self._held.get("x") is not d.x:  # room grows for all of them together
            for name in DISCS.split():
                put(name, getattr(d, name))
            self._held["columns"] = None
        self._bind_pairs(state)
        if self._held.get("near") is not walls.near:
            self._bind_walls(walls)
            self._held["grids"] = None
        if state.bodies is not None:
            self._bind_bodies(state.bodies)
        if state.lists is not None:
            self._bind_lists(state.lists, d, walls)
        put("wall_sum", walls.sums)
        self._bind_pressed(walls.pressed)
        put("work", state.work)
        if self._held.get("constants") is not state.constants:
            self._bind_constants(state.constants)
        if self._held.get("memory", False) is not state.memory:
            self._bind_memory(state.memory)
        return byref(bound)

    def _bind_pressed(self, pressed: PressedSums | None) -> None:
        if self._held.get("pressed") is pressed:
            return
        self._held["pressed"], self._state.pressed = pressed, None
        if pressed is not None:
            first, ends, sums = (address(array) for array in pressed)
            self._held["pressed struct"] = bound = jump_pressed(len(pressed.ends), first, ends, sums)
            self._state.pressed = addressof(bound)

    def _bind_bodies(self, bodies: BodyState) -> None:
        for name in ("corner", "between", "deepest"):
            self._put(name, getattr(bodies, name))
        if self._corners is None:
            self._corners = Core()
        corners, near, lists = self._corners, bodies.corners.walls.near, self._lists
        if corners._held.get("near") is not near:
            faces = bodies.corners.walls.faces
            self._held["corner grids"] = grids = corners._grids_of(faces, bodies.grid)
            lists.corner_grids, lists.meets = addressof(grids), address(bodies.meets)
            lists.corner_rows_room, lists.corner_faces_room = near.last.size, near.faces.size
        corners._bind(bodies.corners)
        self._state.corners = addressof(corners._state)

    def _grids_of(self, faces: Faces, grid: FaceGrid) -> Array[jump_grid]:
        grids = [self._grid(wall, faces, grid) for wall in range(len(faces.deep))]
        return (jump_grid * len(grids))(*grids)

    def _bind_lists(self, lists: Lists, discs: Any, walls: Any) -> None:
        """Bind what making lists takes: the arrays that a sort takes along, and the cells of walls."""
        bound, held = self._lists, self._held
        if held.get("lists") is not lists:
            bound.xlo, bound.xhi, bound.ylo, bound.yhi = lists.domain
            bound.skin, bound.widest, bound.made = lists.skin, lists.widest, address(lists.made)
            bound.period, bound.slope_work, bound.ends = lists.period, address(lists.slope_work), address(lists.ends)
            held["lists"] = lists
        if held["columns"] is None:
            kept = sorted(discs.columns.items(), key=lambda item: not item[1].sorted)
            columns = (c_void_p * len(kept))(*(address(getattr(discs, name)) for name, _ in kept))
            widths = (c_int64 * len(kept))(*(max(1, column.width) for _, column in kept))
            bound.columns, bound.all_columns = sum(column.sorted for _, column in kept), len(kept)
            bound.column, bound.width = addressof(columns), addressof(widths)
            held["columns"] = columns, widths
        if held["grids"] is None:
            bound.rows_room, bound.faces_room = walls.near.last.size, walls.near.faces.size
            held["grids"] = grids = self._grids_of(walls.faces, walls.grid)
            bound.grids = addressof(grids)

    def _bind_walls(self, walls: Any) -> None:
        put, near = self._put, walls.near
        self._state.walls = len(walls.faces.deep)
        put("faces", self._records(walls.faces))
        self._held["at_wall"] = laws = laws_of(*near.laws)
        self._state.at_wall = addressof(laws)
        for name, array in (
            ("deep", walls.faces.deep), ("gone", walls.gone), ("about", near.about), ("near_rows", near.rows),
            ("near_discs", near.discs), ("near_plain", near.plain), ("near_last", near.last),
            ("near_faces", near.faces),
        ):  # fmt: skip
            put(name, array)
        self._bind_moves(walls.moves)
        self._held["near"] = near

    def _bind_pairs(self, state: State) -> None:
        bound, pairs, grid = self._state, state.pairs, state.grid
        bound.rows, bound.sorted, bound.room = pairs.rows, pairs.sorted, pairs.neighbours.size
        bound.listed_as = pairs.listed_as
        for name in ("owner", "start", "neighbours", "shift"):
            self._put(name, getattr(pairs, name))
        self._put("grid_first", None if grid is None else grid.first)
        self._put("grid_used", None if grid is None else grid.used)
        if grid is not None:
            bound.grid_x, bound.grid_y, bound.grid_inverse, bound.grid_columns, bound.grid_rows = grid[:5]

    def _bind_moves(self, moves: Moves | None) -> None:
        for name in MOVES.split():
            there = {"first": "track_first", "now": "placed"}.get(name, name)
            self._put(there, None if moves is None else getattr(moves, name))

    def _bind_constants(self, constants: Constants) -> None:
        self._state.diameter, self._state.pair = constants.diameter, jump_law(*constants.law)
        for name, value in constants.motion._asdict().items():
            setattr(self._state, name, value)
        self._held["constants"] = constants

    def _bind_memory(self, memory: Memory | None) -> None:
        bound, put = self._state, self._put
        slots = ("partner", "sigma", "spring", "roll", "used")
        self._held["memory"] = memory
        if memory is None:
            for name in (*slots, *MEMORY.split()):
                put(name, None)
            return
        for name, array in zip(slots, memory.slots, strict=True):
            put(name, array)
        for name in MEMORY.split():
            put(name, getattr(memory, name))
        bound.slots = bound.slot_row = memory.slots.partner.shape[1]
        bound.memory_step = memory.time_step

    # --- steps ------------------------------------------------------------------------------------------------------

    def advance(self, state: State, steps: int, forces_pending: bool) -> tuple[int, int]:
        """As `Loops.advance`."""
        left, bound = c_int64(), self._bind(state)
        self._state.lists = addressof(self._lists) if state.lists and state.lists.inside else None
        done = _advance(bound, self._partition, steps, bool(forces_pending), byref(left))
        self._take_rooms(state)
        return done, left.value

    def struct(self, state: State) -> jump_state:
        """A state as the core has it; its arrays are those of Python."""
        self._bind(state)
        self._state.lists = addressof(self._lists)
        return self._state

    def run(self, state: State, events: jump_events, target: int) -> tuple[RunEnd, np.ndarray]:
        """Steps up to `target` with all that happens at them; why they end, and the windows of probes that have ended.

        A window has its step, the steps in it, of each wall the sums that it felt and where it is, and those of the
        stretches of outlines.
        """
        end = RunEnd(_run(byref(self.struct(state)), byref(events), self._partition, target))
        state.discs.n = self._state.n
        self._take_rooms(state)
        count = c_int64()
        windows = copied(_windows(self._partition, byref(count)), np.float64, count.value)
        _forget_windows(self._partition)
        pressed = 0 if state.walls.pressed is None else state.walls.pressed.sums.size
        return end, windows.reshape(-1, 2 + len(state.walls.sums) * WINDOW_WIDTH + pressed)

    def _take_rooms(self, state: State) -> None:
        """Take the list that the core has made, and arrays that have grown there into those of Python."""
        bound, lists, d, walls = self._state, self._lists, state.discs, state.walls
        d.sorted_rows, d.listed_as = bound.sorted, bound.listed_as
        grown = False
        if bound.disc_room > d.room:
            names = sorted(d.columns, key=lambda name: not d.columns[name].sorted)
            d.take_room(bound.disc_room, dict(zip(names, self._held["columns"][0], strict=True)))
            d.start, grown = copied(bound.start, np.int64, d.room + 1), True
        if bound.room > d.neighbours.size:
            d.neighbours, grown = copied(bound.neighbours, np.int32, bound.room), True
        if d.period is not None and bound.owner != address(d.owner):
            d.owner, d.shift = copied(bound.owner, np.int32, bound.rows), copied(bound.shift, np.float64, bound.rows)
        if lists.rows_room > walls.near.last.size:
            walls.near, grown = self._near_of(walls.near, lists.rows_room, lists.faces_room), True
        if self._corners is not None and lists.corner_rows_room > walls.bodies.near.last.size:
            rooms = lists.corner_rows_room, lists.corner_faces_room
            walls.bodies.near, grown = self._corners._near_of(walls.bodies.near, *rooms), True
        if grown:
            _forget_rooms(self._partition)

    def _near_of(self, near: Near, rows: int, faces: int) -> Near:
        """Lists of what is near walls from arrays of the core with room for so many rows and faces."""
        of = self._state
        return near._replace(
            discs=copied(of.near_discs, np.int32, rows), plain=copied(of.near_plain, np.int8, rows),
            last=copied(of.near_last, np.int64, rows), faces=copied(of.near_faces, np.int64, faces),
        )  # fmt: skip

    @property
    def threads(self) -> int:
        """Threads that take part now."""
        return _threads(self._partition)

    def place_walls(self, moves: Moves, step: int) -> None:
        """As `Loops.place_walls`."""
        if self._held.get("placed") is not moves.now:  # walls that are being made
            self._state.walls = moves.moving.size
            self._bind_moves(moves)
            self._held["near"] = None
        _place_walls(byref(self._state), step)

    # --- sums -------------------------------------------------------------------------------------------------------

    def elastic(self, state: State, chosen: np.ndarray | None = None) -> tuple[float, float, int, int]:
        """As `Loops.elastic`."""
        worst, where = c_double(), (c_int64 * 2)()
        energy = _elastic(self._bind(state), self._partition, address(chosen), byref(worst), where)
        return energy, worst.value, where[0], where[1]

    def contacts(
        self, state: State, at_step: ContactVelocities, seen: ContactVelocities, who: np.ndarray, rows: np.ndarray
    ) -> int:
        """As `Loops.contacts`."""
        velocities = (jump_velocities(*map(address, one)) for one in (at_step, seen))
        return _contacts(self._bind(state), *map(byref, velocities), address(who), address(rows), len(who))

    def give_sizes(self, state: State, known: int, own: np.ndarray) -> float:
        """As `Loops.give_sizes`."""
        return _give_sizes(self._bind(state), known, own)

    def between(self, state: State, stations: StationStep, sums: np.ndarray) -> None:
        """As `Loops.between`."""
        _between(self._bind(state), byref(jump_stations(*stations)), sums)

    # --- lists ------------------------------------------------------------------------------------------------------

    def _pointer(self, name: str, array: np.ndarray | None) -> int | None:
        """Address of an array that mostly is the one of the call before."""
        held = self._pointers.get(name)
        if held is None or held[0] is not array:
            held = self._pointers[name] = array, address(array)
        return held[1]

    def outside(self, n: int, x: np.ndarray, y: np.ndarray, domain: tuple[float, ...]) -> int:
        """As `Loops.outside`."""
        return _outside(n, self._pointer("x", x), self._pointer("y", y), (c_double * 4)(*domain))

    def list_pairs(self, state: State) -> int:
        """As `Loops.list_pairs`."""
        bound = self._bind(state)
        self._state.lists = addressof(self._lists)
        is_complete = _list_pairs(bound, self._partition)
        state.discs.sorted_rows, state.discs.listed_as = self._state.sorted, self._state.listed_as
        return is_complete

    def closest(self, discs: Any, x: float, y: float) -> float:
        """As `Loops.closest`."""
        return _closest(discs.n, self._pointer("x", discs.x), self._pointer("y", discs.y), x, y)

    def append_row(self, discs: Any, i: int, reach: float) -> bool:
        """As `Loops.append_row`."""
        d, of = discs, self._pointer
        lists = of("start", d.start), of("neighbours", d.neighbours), d.neighbours.size
        return bool(_append_row(i, of("x", d.x), of("y", d.y), of("radius", d.radius), reach, *lists))

    def image_rows(self, discs: Any, reach: tuple[float, float, float], owner: np.ndarray, shift: np.ndarray) -> int:
        """As `Loops.image_rows`."""
        d, of, right = discs, self._pointer, np.empty(discs.n + 1, np.int32)
        seam = (c_double * 4)(*reach, discs.period)
        return _image_rows(
            n=d.n, x=of("x", d.x), y=of("y", d.y), radius=of("radius", d.radius),
            reach=addressof(seam), start=of("start", d.start), neighbours=of("neighbours", d.neighbours),
            room=d.neighbours.size, owner=address(owner), shift=address(shift), right=address(right),
        )  # fmt: skip

    def cell_pairs(self, state: State) -> int:
        """As `Loops.cell_pairs`."""
        return _search_cells(self._bind(state))

    def list_near(
        self, seen: tuple[int, np.ndarray, np.ndarray], wall: int, faces: Faces, grid: FaceGrid, near: Near,
        found: tuple[int, int],
    ) -> tuple[int, int]:  # fmt: skip
        """As `Loops.list_near`."""
        ends, of = (c_int64 * 2)(*found), self._pointer
        (n, x, y), room = seen, (c_int64 * 2)(near.last.size, near.faces.size)
        _list_near(
            grid=pointer(self._grid(wall, faces, grid)), n=n, x=of("seen x", x), y=of("seen y", y),
            discs=of("discs", near.discs), plain=of("plain", near.plain), last=of("last", near.last),
            near=of("faces", near.faces), room=addressof(room), found=addressof(ends),
        )  # fmt: skip
        return ends[0], ends[1]

    def _grid(self, wall: int, faces: Faces, grid: FaceGrid) -> jump_grid:
        of_all, grids = self._grids
        if of_all is not grid:
            self._grids = grid, grids = grid, {}
        if wall not in grids:
            arrays = (self._records(faces), grid.box, grid.start, grid.faces)
            grids[wall] = jump_grid(
                *map(address, arrays), faces.deep[wall], *grid.cells[wall], *grid.wall_box[wall], *grid.place[wall],
                grid.reach,
            )  # fmt: skip
        return grids[wall]

    def mark_cells(
        self, faces: Faces, box: np.ndarray, ends: tuple[int, int], cells: tuple[float, float, float, int, int],
        reach: float, start: np.ndarray, listed: np.ndarray,
    ) -> None:  # fmt: skip
        """As `lammps_jump.scene.faces.mark_cells`."""
        *place, columns, rows = cells
        grid = jump_grid(
            address(self._records(faces)), address(box), None, None, 0, columns, rows, 0, *[0.0] * 4, *place, reach
        )
        _mark_cells(byref(grid), *ends, start, address(listed) if listed.size else None)
