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
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .bound import jump_events, jump_state
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
    found: dict[int, Any] = {}
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
            found[place], sizes[place] = one, size
        if isinstance(one, dict):
            left += one.values()
        elif isinstance(one, tuple | list):
            left += one
        elif type(one).__module__.startswith("lammps_jump"):
            left += list(getattr(one, "__dict__", {}).values())
    return found


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
        """Bytes of the image behind its head: magic, width of a pointer, size, pointers, places of state and events."""
        whole = bytearray(self.size)
        for place, data in self.parts:
            whole[place : place + len(data)] = data
        head = struct.pack("<8s5q", MAGIC, self.word, self.size, len(self.pointers), state, events)
        return head + np.array(self.pointers, "<i8").tobytes() + bytes(whole)


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
