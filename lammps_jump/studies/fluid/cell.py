# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs of a case without their flow, and a periodic box of them: sheared, compressed, or left to itself.

I = rate d sqrt(rho/p) is the inertial number (GDR MiDi 2004), mu the shear stress over the pressure.

The core moves it (``shear.cpp``), with the contact and the springs of the native engine. Time levels are those of
LAMMPS: x_n, v_(n-1/2), F_n between steps, and the dashpot sees v_(n-1/2).

The image of a disc one height further up is `offset` further along x and is faster by rate times height. The box
keeps its shape; where a pressure is held, it and the places in it grow by

    d(ln length)/dt = gain (P - P0)/k,   at most `cap`                                                          (1)

while velocities stay. The stress is, over the area A of the box (Irving & Kirkwood 1950; positive in compression),

    s_ab = (sum of contacts F_a r_b + sum of discs m u_a u_b) / A,   u = v - rate y                             (2)
"""

from __future__ import annotations

from collections.abc import Mapping
from ctypes import POINTER, c_double, c_int64, c_void_p, pointer
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.packing import disc_sizes
from lammps_jump.case.to_scene import TOUCH_STEPS, contact_of
from lammps_jump.core.law import LawNumbers, jump_law
from lammps_jump.core.library import INTEGER, REALS, SHORTS, Struct, entry
from lammps_jump.engines.native.arrays import Memory
from lammps_jump.errors import RunError
from lammps_jump.physics.contact import Coefficients, derive
from lammps_jump.physics.law import Slots
from lammps_jump.physics.slip import FRICTION_LAWS, slots_of
from lammps_jump.scene import Scene, Sizes


@dataclass(frozen=True)
class FluidDiscs:
    """Discs of a case, without the flow they are in.

    Attributes
    ----------
    diameter, density : float
        m, kg/m^3.
    sizes : Sizes or None
        None: equal discs.
    coefficients : Coefficients
        For LAMMPS' order of operations.
    law : mapping of str to object
        What else a `Scene` has of the law, by its fields (`Contact.law_fields`).
    slip_speed : float
        m/s: eps of the thesis' sign law, 0.01 of the case's impact speed.
    impact_speed : float
        v0 of thesis (3.20), m/s.
    """

    diameter: float
    density: float
    sizes: Sizes | None
    coefficients: Coefficients
    law: Mapping[str, Any]
    slip_speed: float
    impact_speed: float

    @property
    def root_time(self) -> float:
        """Unit of time of a contact, sqrt(m/k), s."""
        return sqrt(self.coefficients.mass / self.coefficients.stiffness)

    @property
    def signal_speed(self) -> float:
        """Speed along a row of touching discs, d sqrt(k/m) = n v0, m/s."""
        return self.diameter / self.root_time

    @property
    def scene(self) -> Scene:
        """A scene without discs, in which such ones would be."""
        diameter, nothing = self.diameter, np.zeros((0, 2))
        return Scene(
            name="discs", description="", diameter=diameter, density=self.density, gravity=(0.0, 0.0),
            coefficients=self.coefficients, **self.law, integrator="velocity_verlet",
            domain=((0.0, diameter), (0.0, diameter)), positions=nothing, velocities=nothing, walls=(),
            sizes=self.sizes, overlap_limit=diameter,
        )  # fmt: skip

    def radii(self, count: int) -> np.ndarray:
        """Radii of a number of discs, m."""
        if self.sizes is None:
            return np.full(count, 0.5 * self.diameter)
        return 0.5 * self.sizes.diameters(np.arange(1, count + 1))


def discs_of(case: ReadCase) -> FluidDiscs:
    """The discs of a case; its step is the case's share of 2/omega."""
    fields = case.fields
    law, sizes = fields.contact, disc_sizes(fields)
    stated = contact_of(fields, "velocity_verlet", sizes)
    coefficients, impact_speed = derive(stated), stated.impact_speed
    width, weight = TOUCH_STEPS * impact_speed * coefficients.time_step, coefficients.mass * fields.gravity
    return FluidDiscs(
        diameter=fields.discs.diameter,
        density=fields.discs.density,
        sizes=sizes and replace(sizes, seed=1),
        coefficients=coefficients,
        law=law.law_fields(rubs=law.friction > 0, width=width, weight=weight),
        slip_speed=(FRICTION_LAWS[law.friction_law].ramp or 0.0) * impact_speed,
        impact_speed=impact_speed,
    )


EXPONENTS = np.linspace(0.2, 1.2, 101)


def shear_rate(inertial: float, diameter: float, density: float, pressure: float) -> float:
    """Rate of shear of an inertial number, 1/s: I sqrt(p/rho)/d (GDR MiDi 2004)."""
    return inertial * sqrt(pressure / density) / diameter


class Friction(NamedTuple):
    """The law mu = yield + slope I^exponent (power law of the inertial number)."""

    static: float
    slope: float
    exponent: float

    def at(self, inertial: float) -> float:
        """Friction at an inertial number."""
        return self.static + self.slope * inertial**self.exponent


def fit_friction(inertial: np.ndarray, friction: np.ndarray, exponent: float | None = None) -> Friction:
    """Least squares of mu = mu_s + b I^a; the exponent too, of 0.2 to 1.2, unless it is given."""

    def fit(power: float) -> tuple[float, Friction]:
        basis = np.stack([np.ones_like(inertial), inertial**power], axis=1)
        (static, slope), *_ = np.linalg.lstsq(basis, friction, rcond=None)
        misses = basis @ (static, slope) - friction
        return float(misses @ misses), Friction(float(static), float(slope), float(power))

    return min((fit(power) for power in (EXPONENTS if exponent is None else [exponent])), key=lambda one: one[0])[1]


def viscosity(law: Friction, pressure: float, rate: float, diameter: float, density: float) -> float:
    """Kinematic viscosity, m^2/s: nu = mu(I) p/(rho rate)."""
    return law.at(rate * diameter * sqrt(density / pressure)) * pressure / (density * rate)


# --- A box of discs without walls, periodic along x and y: sheared, compressed, or left to itself ---------------------


LX, LY, OFFSET, STRAIN, PRESSURE = range(5)
"""Numbers of the box: length, height and shift of the images above (m), strain since the start, pressure (Pa)."""
SXX, SYY, SXY, AREA, KINETIC, WAVE = range(6)
"""A row of the record: means of stress (Pa), area (m^2), energy of u (J per m); the first mode at its end (m/s)."""


class BoxDiscs(NamedTuple):
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
    swarm: BoxDiscs, box: np.ndarray, control: Control, pairs: np.ndarray, record: np.ndarray, every: int,
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


SKIN = 0.15
"""Skin of the list, mean diameters."""
SLOWNESS, CAP = 50.0, 1e-3
"""Time in which the box follows its pressure, and largest rate at which it grows, in sqrt(m/k) and its inverse."""
LOOSE = 0.6
"""Packing at the start, before the pressure closes the box."""
FOLLOW = 0.02
"""Of a sheared box: rate at which it grows at twice its pressure, over the rate of shear. It then follows its pressure
within a strain of 1, and slower than sound crosses it (measured)."""
HASTE, STEADY = 50.0, 0.02
"""Factor by which a loose box closes faster than a closed one follows its pressure, and what a steady one may miss."""
CLOSING = 1000
"""Parts of 20 sqrt(m/k) in which a loose box closes."""
AGITATED = 1e-3
"""Speed of the discs at the start over d sqrt(k/m)."""
ROOM = 12
"""Listed pairs a disc at most."""


class Cell:
    """A box of discs: where they are, how they move, how the box is sheared and pressed.

    Parameters
    ----------
    discs : FluidDiscs
    count : int
    seed : int
        Of the start: places on a grid, moved by chance, with small velocities.
    packing : float
        Share of the area that the discs cover at the start.
    aspect : float
        Length over height of the box.
    """

    def __init__(self, discs: FluidDiscs, count: int, seed: int, *, packing: float = LOOSE, aspect: float = 1.0):
        self.discs = discs
        random = np.random.default_rng(seed)
        radius = random.permutation(discs.radii(count))
        self.covered = float(np.pi * np.sum(radius**2))
        height = sqrt(self.covered / packing / aspect)
        self.box = np.array([aspect * height, height, 0.0, 0.0, 0.0])
        rows = max(1, round(sqrt(count / aspect)))
        columns = -(-count // rows)
        cells = random.permutation(rows * columns)[:count]
        shape = self.box[:2] / (columns, rows)
        x, y = ((np.stack([cells % columns, cells // columns]) + 0.5).T * shape).T
        speed = AGITATED * discs.signal_speed
        vx, vy = random.normal(0.0, speed, (2, count))
        omega, fx, fy, torque = (np.zeros(count) for _ in range(4))
        self.swarm = BoxDiscs(x, y, vx, vy, omega, fx, fy, torque, radius, np.zeros((count, 2)))
        self.stop()
        self._pairs = np.empty((ROOM * count + count, 4), np.int32)
        self._memory = self._springs(count)

    @property
    def packing(self) -> float:
        """Share of the area that the discs cover."""
        return self.covered / (self.box[LX] * self.box[LY])

    @property
    def mass(self) -> np.ndarray:
        """Masses, kg/m."""
        return 4.0 * self.discs.density * self.swarm.radius**2

    def stop(self) -> None:
        """Take away the mean velocity."""
        mass = self.mass
        for v in (self.swarm.vx, self.swarm.vy):
            v -= np.sum(mass * v) / np.sum(mass)

    def shear(self, old: float, new: float) -> None:
        """Go over from one rate of shear to another (1/s), with the velocities against the shear as they are."""
        self.swarm.vx[:] += (new - old) * (self.swarm.y - 0.5 * self.box[LY])

    def close(self, pressure: float) -> None:
        """Press the loose box together until its discs carry a pressure (Pa), and go on until it is steady."""
        part = 20.0 * self.discs.root_time
        for _ in range(CLOSING):
            if self.advance(part, 1, pressure=pressure, haste=HASTE)[0, :2].mean() > pressure:
                break
        for _ in range(CLOSING):
            held = self.advance(10.0 * part, 1, pressure=pressure)[0, :2].mean()
            if abs(held - pressure) < STEADY * pressure:
                return
        raise RunError(f"the box of {self.swarm.x.size} discs does not come to {pressure:z.3g} Pa")

    def advance(
        self, time: float, rows: int, *, rate: float = 0.0, pressure: float | None = None, haste: float = 1.0
    ) -> np.ndarray:
        """Go on for a time (s); the means of each of a number of equal parts, shape (rows, 6) (`loops.SXX` …).

        Parameters
        ----------
        time : float
            s; rounded to whole steps of each part.
        rows : int
        rate : float
            Of shear, 1/s.
        pressure : float, optional
            Held by the box, Pa; without it the box stays.
        haste : float
            How much faster than `SLOWNESS` the box follows its pressure.

        Raises
        ------
        RunError
            Discs so deep in each other that the list has no room.
        """
        discs, c = self.discs, self.discs.coefficients
        unit = discs.root_time
        square = (0.5 * discs.diameter) ** 2
        spins = discs.law["rotation"] and c.friction > 0
        gain = 0.0
        if pressure is not None:
            gain = FOLLOW * abs(rate) * c.stiffness / pressure if rate else haste / (SLOWNESS * unit)
        control = Control(
            rate, pressure or 0.0, gain, CAP / unit, c.time_step, SKIN * discs.diameter,
            1.0 / discs.slip_speed if discs.slip_speed else 0.0, c.mass / square,
            square**2 / (c.inertia * square) if spins else 0.0,
        )  # fmt: skip
        record = np.empty((rows, 6))
        every = max(1, round(time / rows / c.time_step))
        law = discs.scene.law_numbers(sized=True)
        fits = advance(self.swarm, self.box, control, self._pairs, record, every, law, self._memory)
        if not fits or not np.isfinite(record).all():
            raise RunError(
                f"the box of {self.swarm.x.size} discs at {pressure or 0.0:z.3g} Pa has blown up: lower "
                "run.time_step_fraction"
            )
        return record

    def _springs(self, count: int) -> Memory | None:
        if self.discs.law["springs"] is None:
            return None
        room = slots_of(2.0 * self.swarm.radius.min(), 2.0 * self.swarm.radius.max())
        partner, used = np.zeros((count, room), np.int64), np.zeros((count, room), np.int8)
        sigma, spring, roll = np.zeros((3, count, room))
        slots = Slots(partner, sigma, spring, roll, used)
        none, full = (np.zeros(0, np.int64), np.zeros(0)), np.zeros(1, np.int64)
        return Memory(slots, np.arange(1, count + 1), *none, full, self.discs.coefficients.time_step)
