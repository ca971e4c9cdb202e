# SPDX-License-Identifier: GPL-2.0-or-later
"""A box without walls: periodic along x and y, sheared as Lees & Edwards (1972) do, at a held pressure.

The core moves it (``shear.cpp``), with the contact and the springs of the native engine. Time levels are those of
LAMMPS: x_n, v_(n-1/2), F_n between steps, and the dashpot sees v_(n-1/2).

The image of a disc one height further up stands `offset` further along x and is faster by rate times height. The box
keeps its shape; where a pressure is held, it and the places in it grow by

    d(ln length)/dt = gain (P - P0)/k,   at most `cap`                                                          (1)

while velocities stay. The stress is, over the area A of the box (Irving & Kirkwood 1950; positive in compression),

    s_ab = (sum of contacts F_a r_b + sum of discs m u_a u_b) / A,   u = v - rate y                             (2)
"""

from __future__ import annotations

from ctypes import POINTER, c_double, c_int64, c_void_p, pointer
from typing import ClassVar, NamedTuple

import numpy as np

from lammps_jump.core.law import LawNumbers, jump_law
from lammps_jump.core.library import INTEGER, REALS, SHORTS, Struct, entry
from lammps_jump.engines.native.arrays import Memory

LX, LY, OFFSET, STRAIN, PRESSURE = range(5)
"""Numbers of the box: length, height and shift of the images above (m), strain since the start, pressure (Pa)."""
SXX, SYY, SXY, AREA, KINETIC, WAVE = range(6)
"""A row of the record: means of stress (Pa), area (m^2), energy of u (J per m); the first mode at its end (m/s)."""


class Swarm(NamedTuple):
    """The discs of a box: place, velocity, spin, force, torque, radius; way against the shear since the list (m)."""

    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    torque: np.ndarray
    radius: np.ndarray
    way: np.ndarray


class Control(NamedTuple):
    """Settings that are imposed and do not change in a run.

    Attributes
    ----------
    rate : float
        Of shear, 1/s.
    pressure, gain, cap : float
        Of (1), Pa and 1/s; gain 0: the box stays.
    time_step, skin : float
        s, m.
    slope : float
        1/eps of the thesis' friction, s/m; 0 of another.
    mass, turn : float
        Mass of a radius of 1 m (kg/m), and 1/inertia of one; `turn` is 0 where discs do not spin.
    """

    rate: float
    pressure: float
    gain: float
    cap: float
    time_step: float
    skin: float
    slope: float
    mass: float
    turn: float


class jump_springs(Struct):
    """Slots of the discs (``core/sums/shear.cpp``)."""

    _fields_: ClassVar = [
        ("slots", c_int64),
        *((name, c_void_p) for name in ("ids", "partner", "full", "sigma", "spring", "roll", "used")),
        ("time_step", c_double),
    ]


_shear = entry(
    "jump_shear", INTEGER, n=INTEGER, discs=POINTER(c_void_p), box_numbers=REALS, control=REALS, law=POINTER(jump_law),
    springs=POINTER(jump_springs), listed=SHORTS, room=INTEGER, record=REALS, rows=INTEGER, every=INTEGER,
)  # fmt: skip


def _at(array: np.ndarray) -> int:
    """Address of an array, which must be contiguous."""
    if not array.flags.c_contiguous:
        raise ValueError(f"the core reads contiguous arrays, not one of strides {array.strides}")
    return array.ctypes.data


def _springs(memory: Memory) -> jump_springs:
    slots, m = memory.slots, memory
    arrays = (m.ids, slots.partner, m.full, slots.sigma, slots.spring, slots.roll, slots.used)
    return jump_springs(slots.partner.shape[1], *map(_at, arrays), m.time_step)


def advance(
    swarm: Swarm, box: np.ndarray, control: Control, pairs: np.ndarray, record: np.ndarray, every: int,
    law: LawNumbers, memory: Memory | None,
) -> bool:  # fmt: skip
    """Steps of kick, drift and forces, `every` for each row of `record`, which takes their means; needs the core.

    Parameters
    ----------
    swarm : Swarm
        Changed in place, as is `box`.
    box : ndarray, shape (5,)
    control : Control
    pairs : ndarray of int32, shape (room, 4)
        Room for the list.
    record : ndarray, shape (rows, 6)
    every : int
    law : LawNumbers
        Of two discs, of a size of 1 m.
    memory : Memory or None
        Of contacts with springs.

    Returns
    -------
    bool
        False where `pairs` is short.
    """
    discs = (c_void_p * len(swarm))(*map(_at, swarm))
    room_left = _shear(
        n=len(swarm.x), discs=discs, box_numbers=box, control=np.array(control, float), law=pointer(jump_law(*law)),
        springs=None if memory is None else pointer(_springs(memory)), listed=pairs, room=len(pairs), record=record,
        rows=len(record), every=every,
    )  # fmt: skip
    return bool(room_left)
