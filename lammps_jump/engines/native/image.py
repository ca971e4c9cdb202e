# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene as an image of memory: what `jump_run` takes, for a host of the core that has no Python.

The image holds state and events of a simulation with everything that their pointers lead to. A pointer is stored as a
place in the image. The host adds to each where the image lies. Pointers have the width of the system that is meant: 8
bytes, or 4 for WebAssembly.
"""

from __future__ import annotations

import ctypes
import struct
from ctypes import addressof, c_uint32, c_uint64, c_void_p, sizeof
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.core.library import VERSION
from lammps_jump.scene.scene import Scene

from .arrays import State
from .bound import Core, jump_events, jump_state
from .discs import DiscArrays
from .events import OpenBoundaries, SceneEvents, Tailgates, Windows
from .ledger import EnergyBalance, StationLedger
from .simulation import DEFAULT_SKIN, Memories, constants_of, lists_of
from .walls import Walls

if TYPE_CHECKING:
    from .simulation import NativeSimulation

MAGIC = b"JLMIMG1\0"
LINE = 64
"""Bytes to which every array is aligned."""


def narrowed(kind: Any, word: int) -> Any:
    """A kind of ctypes whose pointers have `word` bytes."""
    if kind is c_void_p:
        return c_uint64 if word == 8 else c_uint32
    if isinstance(kind, type) and issubclass(kind, ctypes.Structure):
        fields = [(field[0], narrowed(field[1], word)) for field in kind._fields_]
        return type(kind.__name__, (ctypes.Structure,), {"_fields_": fields})
    return kind


def held_by(*owners: Any) -> dict[int, Any]:
    """Arrays of numpy and ctypes that objects of this package hold, by their address."""
    kept: dict[int, Any] = {}
    sizes: dict[int, int] = {}
    seen: set[int] = set()
    left = list(owners)
    while left:
        one = left.pop()
        if id(one) in seen:
            continue
        seen.add(id(one))
        if isinstance(one, np.ndarray):
            place, size = one.ctypes.data, one.nbytes
        elif isinstance(one, ctypes.Structure | ctypes.Array):
            place, size = addressof(one), sizeof(one)
        else:
            place, size = 0, -1
        if size >= sizes.get(place, 0):  # a view of the first rows begins where the whole does
            kept[place], sizes[place] = one, size
        if isinstance(one, dict):
            left += one.values()
        elif isinstance(one, tuple | list):
            left += one
        elif type(one).__module__.startswith("lammps_jump"):
            left += list(getattr(one, "__dict__", {}).values())
    return kept


class Image:
    """An image that grows by what is put into it.

    Parameters
    ----------
    known : dict
        Arrays by their address, as of `held_by`.
    word : int
        Bytes of a pointer: 4 or 8.
    """

    def __init__(self, known: dict[int, Any], word: int):
        self.known, self.word = known, word
        self.parts: list[tuple[int, bytearray]] = []
        self.size = 0
        self.places: dict[int, int] = {}
        self.pointers: list[int] = []

    def _room(self, address: int, count: int) -> tuple[int, bytearray]:
        """Place and bytes of a new part."""
        place, data = self.size, bytearray(count)
        self.size += -(-max(count, 1) // LINE) * LINE
        self.parts.append((place, data))
        self.places[address] = place
        return place, data

    def put(self, address: int) -> int:
        """Place of what lies at an address.

        Raises
        ------
        KeyError
            An address that is not known.
        """
        if address in self.places:
            return self.places[address]
        what = self.known[address]
        if isinstance(what, np.ndarray):
            data = what.tobytes()
            place, room = self._room(address, len(data))
            room[:] = data
            return place
        if isinstance(what, ctypes.Structure):
            return self._structs(address, [what])
        if issubclass(what._type_, ctypes.Structure):
            return self._structs(address, list(what))
        if what._type_ is c_void_p:
            place, room = self._room(address, self.word * len(what))
            for number, there in enumerate(what):
                self._pointer(place, room, self.word * number, there)
            return place
        place, room = self._room(address, sizeof(what))
        room[:] = bytes(what)
        return place

    def _pointer(self, place: int, room: bytearray, offset: int, address: int | None) -> None:
        if address:
            room[offset : offset + self.word] = self.put(address).to_bytes(self.word, "little")
            self.pointers.append(place + offset)

    def _structs(self, address: int, structs: list[ctypes.Structure]) -> int:
        if not structs:
            return self._room(address, 0)[0]
        kind = type(structs[0])
        narrow = narrowed(kind, self.word)
        place, room = self._room(address, sizeof(narrow) * len(structs))
        for number, one in enumerate(structs):
            self._fields(place, room, sizeof(narrow) * number, one, narrow)
        return place

    def _fields(self, place: int, room: bytearray, begin: int, one: ctypes.Structure, narrow: Any) -> None:
        for name, kind, *_ in type(one)._fields_:
            offset, value = begin + getattr(narrow, name).offset, getattr(one, name)
            if kind is c_void_p:
                self._pointer(place, room, offset, value)
            else:
                raw = bytes(value) if isinstance(value, ctypes.Structure) else bytes(kind(value))
                room[offset : offset + len(raw)] = raw

    def file(self, state: int, events: int) -> bytes:
        """Bytes of a file: head, image, and the version of the interface with the sizes of both structs.

        The head has magic, width of a pointer, size, number of pointers, places of state and events.
        """
        whole = bytearray(self.size)
        for place, data in self.parts:
            whole[place : place + len(data)] = data
        head = struct.pack("<8s5q", MAGIC, self.word, self.size, len(self.pointers), state, events)
        sizes = (sizeof(narrowed(kind, self.word)) for kind in (jump_state, jump_events))
        return head + np.array(self.pointers, "<i8").tobytes() + bytes(whole) + struct.pack("<3q", VERSION, *sizes)


def image_of(simulation: NativeSimulation, target: int, word: int = 8, discs: int = 0) -> bytes:
    """The file of a scene from which a host goes on up to step `target`.

    Parameters
    ----------
    simulation : NativeSimulation
        One that has been set up; its loops are those of the core.
    target : int
        Last step that the host may go to: radii of the discs that enter until then come along.
    word : int
        Bytes of a pointer of the host: 4 or 8.
    discs : int
        Discs whose radii come along, at least: of a host that lets more in than the scene.

    Raises
    ------
    ValueError
        A pour, whose places are drawn by the host itself.
    """
    image, state, events = placed_image(simulation, target, word, discs)
    return image.file(image.places[addressof(state)], image.places[addressof(events)])


def placed_image(
    simulation: NativeSimulation, target: int, word: int, discs: int = 0
) -> tuple[Image, jump_state, jump_events]:
    """The image that `image_of` writes, and the state and the events that it holds; arguments as there."""
    if simulation.scene.pours:
        raise ValueError("a pour is drawn by the engine; a host without Python cannot go on with it")
    state, events = simulation.for_host(target, discs)
    listed = simulation.discs
    listed.neighbours[listed.start[state.rows] :] = 0  # room that nobody has written: memory of this process stays here
    image = Image(held_by(simulation) | {addressof(state): state, addressof(events): events}, word)
    for struct_ in (state, events):
        image.put(addressof(struct_))
    return image, state, events


FEW_FACES, NEAR, NEAR_OF_MANY = 8, 1.0, 0.3
"""Skin of the lists of discs near walls over the diameter, of a host that lists them apart from its pairs: 1.0 where no
wall has more faces than 8. Each further face near a disc costs time."""


class WithoutDiscs:
    """A scene as a host takes it that has the discs itself: law, walls, bodies, and what happens at certain steps.

    Parameters
    ----------
    scene : Scene

    Attributes
    ----------
    state : jump_state
    events : jump_events
    """

    step, ledger_on = 0, False

    def __init__(self, scene: Scene):
        self.scene, self.loops, self._full = scene, Core(), np.zeros(1, np.int64)
        faces = max((len(one.wall.faces.codes) for one in scene.walls), default=0)
        near = scene.diameter * (NEAR if faces <= FEW_FACES else NEAR_OF_MANY)
        self.walls = Walls(scene, self.loops, self.step, near)
        self.boundaries, self.gates, self.windows = OpenBoundaries(scene), Tailgates(scene), Windows(scene)
        self.books, self.stations = EnergyBalance(periodic=False), StationLedger(scene, self.loops, self.ledger_on)
        none = np.empty((0, 2))
        self.discs = DiscArrays(
            replace(scene, positions=none, velocities=none, earlier=None), self.loops, ledger=self.ledger_on
        )
        self.discs.neighbours[:] = 0
        skin = scene.skin if scene.skin > 0 else DEFAULT_SKIN * scene.diameter
        constants = constants_of(scene, skin)
        memory = Memories(scene).of(self.discs, self.walls, self._full, scene.time_step)
        self.weight = constants.motion.weight_x, constants.motion.weight_y
        self.lists = lists_of(scene, skin, inside=True)
        self._all = State(
            self.discs, self.discs.pairs, self.walls, constants, memory, self.books.work,
            bodies=self.walls.body_state(constants, memory), lists=self.lists,
        )  # fmt: skip
        self.state = self.loops.struct(self._all)
        self._events = SceneEvents(self)
        self.events = self._events.put(scene.steps, scene.most_discs)

    def file(self) -> bytes:
        """The file of the image."""
        image = Image(held_by(self) | {addressof(self.state): self.state, addressof(self.events): self.events}, 8)
        return image.file(*(image.put(addressof(one)) for one in (self.state, self.events)))
