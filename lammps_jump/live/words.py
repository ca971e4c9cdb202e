# SPDX-License-Identifier: GPL-2.0-or-later
"""Words of law and weight that differ in the image of a scene where a number of the case has another value.

Two simulations of one scene are set up, with the two values. What the core takes of them is compared, number by number.
"""

from __future__ import annotations

import ctypes
from ctypes import addressof, c_double, c_void_p
from typing import Any

import numpy as np

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import Image, image_of, narrowed, placed_image
from lammps_jump.errors import CaseError

WORD = 4
"""Bytes of a pointer in a browser."""
TABLES = ("at_wall", "between", "load")
"""Arrays of numbers of the state that follow from the case alone."""
MOST_START = 1_500
"""Words of a start that differ, at most; a flow begins with fewer."""

Words = list[tuple[int, float]]


class PlacedWords:
    """Numbers of a simulation with their places in its image.

    Parameters
    ----------
    base : NativeSimulation
        At its start.
    """

    def __init__(self, base: NativeSimulation):
        self.time_step = base.scene.time_step
        self._found = _numbers_of(base)
        self._image = image_of(base, 0, WORD)

    def against(self, other: NativeSimulation) -> tuple[Words, Words | None]:
        """Words that another value changes in a running flow, and at its start; None where that is not laid out alike.

        Raises
        ------
        CaseError
            The other has another time step, or is made of other parts.
        """
        if other.scene.time_step != self.time_step:
            raise CaseError("it changes the time step, so that a flow cannot go on with it; drop the slider")
        there = _numbers_of(other)
        if [place for place, _ in there] != [place for place, _ in self._found]:
            raise CaseError("the flow is made of other parts with it; take values that are all above 0")
        words = [two for one, two in zip(self._found, there, strict=True) if _bits(one[1]) != _bits(two[1])]
        if not all(np.isfinite(number) for _, number in words):
            raise CaseError("nothing rubs with one of its values; take values above 0")
        return words, self._start(image_of(other, 0, WORD))

    def _start(self, image: bytes) -> Words | None:
        """Words of the start of another image that differ from this one."""
        if len(image) != len(self._image):
            return None
        begin = _begin(image)
        if image[:begin] != self._image[:begin]:
            return None
        count = (len(image) - begin) // 8
        own, other = (np.frombuffer(one, "<i8", count, begin) for one in (self._image, image))
        differ = np.nonzero(own != other)[0]
        numbers = other.view("<f8")[differ]
        if not np.isfinite(numbers).all() or len(numbers) > MOST_START:
            return None
        return list(zip((8 * differ).tolist(), numbers.tolist(), strict=True))


def _bits(number: float) -> bytes:
    return bytes(c_double(number))


def _begin(image: bytes) -> int:
    """Begin of the memory of an image in its file."""
    pointers = int.from_bytes(image[24:32], "little")
    return 48 + 8 * pointers


def _numbers_of(simulation: NativeSimulation) -> Words:
    """Numbers of law and weight, with their places in the image."""
    image, state, events = placed_image(simulation, 0, WORD)
    found = [*_of_struct(image, state), *_of_struct(image, events)]
    for name in TABLES:
        found += _of_table(image, getattr(state, name))
    if state.corners:
        corners = image.known[state.corners]
        found += [*_of_struct(image, corners), *_of_table(image, corners.at_wall)]
    return found


def _of_struct(image: Image, struct: ctypes.Structure) -> Words:
    """Its numbers, and those of structs in it."""
    begin, narrow, found = image.places[addressof(struct)], narrowed(type(struct), WORD), []
    for name, kind, *_ in type(struct)._fields_:
        place = begin + getattr(narrow, name).offset
        if kind is c_double:
            found.append((place, float(getattr(struct, name))))
        elif kind is not c_void_p and issubclass(kind, ctypes.Structure):
            raw = np.frombuffer(bytes(getattr(struct, name)), "<f8")
            found += [(place + 8 * k, float(number)) for k, number in enumerate(raw)]
    return found


def _of_table(image: Image, address: int | None) -> Words:
    if not address:
        return []
    what: Any = image.known[address]
    raw = np.frombuffer(what.tobytes() if isinstance(what, np.ndarray) else bytes(what), "<f8")
    return [(image.places[address] + 8 * k, float(number)) for k, number in enumerate(raw)]
