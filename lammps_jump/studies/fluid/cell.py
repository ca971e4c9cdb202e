# SPDX-License-Identifier: GPL-2.0-or-later
"""A box of discs without walls, periodic along x and y: sheared, compressed, or left to itself."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lammps_jump.engines.native.arrays import Memory
from lammps_jump.errors import RunError
from lammps_jump.physics.slip import slots_of
from lammps_jump.physics.slots import Slots

from . import loops
from .discs import FluidDiscs

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
"""How much faster a loose box closes than a closed one follows its pressure, and what a steady one may miss of it."""
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
        self.swarm = loops.Swarm(x, y, vx, vy, omega, fx, fy, torque, radius, np.zeros((count, 2)))
        self.stop()
        self._pairs = np.empty((ROOM * count + count, 4), np.int32)
        self._memory = self._springs(count)

    @property
    def packing(self) -> float:
        """Share of the area that the discs cover."""
        return self.covered / (self.box[loops.LX] * self.box[loops.LY])

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
        self.swarm.vx[:] += (new - old) * (self.swarm.y - 0.5 * self.box[loops.LY])

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
        control = loops.Control(
            rate, pressure or 0.0, gain, CAP / unit, c.time_step, SKIN * discs.diameter,
            1.0 / discs.slip_speed if discs.slip_speed else 0.0, c.mass / square,
            square**2 / (c.inertia * square) if spins else 0.0,
        )  # fmt: skip
        record = np.empty((rows, 6))
        every = max(1, round(time / rows / c.time_step))
        law = discs.scene.law_numbers(sized=True)
        fits = loops.advance(self.swarm, self.box, control, self._pairs, record, every, law, self._memory)
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
