# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs in a box without walls: speed of sound from a standing wave; friction and packing sheared under a pressure."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from .cell import AREA, LX, SXX, SXY, SYY, WAVE, Cell
from .discs import FluidDiscs, shear_rate

LENGTH, HEIGHT = 104, 10
"""Discs along the wave and across it."""
SETTLE = 1500.0
"""Time for which the box is held at its pressure before, sqrt(m/k)."""
STRAIN = 0.02
"""Speed of the wave over that of sound, as a share of pressure over stiffness: no contact opens."""
EXPECTED = 0.6
"""Speed of sound over d sqrt(k/m), measured in packed discs of several sizes; sets how long is recorded."""
PERIODS, SAMPLES = 3.0, 300


class Swing(NamedTuple):
    """A damped cosine, a exp(-decay t) cos(frequency t + phase) + rest: frequency (rad/s), decay (1/s)."""

    frequency: float
    decay: float
    rest: float

    @property
    def undamped(self) -> float:
        """Frequency without damping, rad/s: sqrt(frequency^2 + decay^2)."""
        return hypot(self.frequency, self.decay)

    @property
    def damping(self) -> float:
        """Damping over the critical one."""
        return self.decay / self.undamped


def damped_cosine(times: np.ndarray, values: np.ndarray, expected: float) -> Swing:
    """Fit of a damped cosine.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        s, and any unit.
    expected : float
        Frequency to begin with, rad/s.
    """
    from scipy.optimize import least_squares  # 0.2 s

    def parts(shape: np.ndarray) -> np.ndarray:
        wave = np.exp(-shape[1] * times)
        phase = shape[0] * times
        return np.stack([wave * np.cos(phase), wave * np.sin(phase), np.ones_like(times)], axis=1)

    def misses(shape: np.ndarray) -> np.ndarray:
        basis = parts(shape)
        return basis @ np.linalg.lstsq(basis, values, rcond=None)[0] - values

    tries = [least_squares(misses, [factor * expected, 0.1 * expected]) for factor in (0.8, 1.0, 1.25)]
    best = min(tries, key=lambda one: one.cost).x
    rest = np.linalg.lstsq(parts(best), values, rcond=None)[0][2]
    return Swing(abs(float(best[0])), float(best[1]), float(rest))


class Sound(NamedTuple):
    """Of discs at rest: speed of sound (m/s), the same over d sqrt(k/m) = n v0, and packing."""

    speed: float
    ratio: float
    packing: float


def sound_speed(discs: FluidDiscs, pressure: float, seed: int, *, length: int = LENGTH) -> Sound:
    """Speed of a standing longitudinal wave, c = omega length/(2 pi).

    Parameters
    ----------
    discs : FluidDiscs
    pressure : float
        At which they are packed, Pa.
    seed : int
    length : int
        Of the wave, discs.
    """
    cell = Cell(discs, length * HEIGHT, seed, aspect=length / HEIGHT)
    cell.close(pressure)
    cell.advance(SETTLE * discs.root_time, 1, pressure=pressure)
    cell.stop()
    long, guess = cell.box[LX], EXPECTED * discs.signal_speed
    speed = STRAIN * guess * pressure / (EXPECTED**2 * discs.coefficients.stiffness)
    cell.swarm.vx[:] = speed * np.sin(2.0 * pi * cell.swarm.x / long)
    cell.swarm.vy[:] = 0.0
    time = PERIODS * long / guess
    mode = cell.advance(time, SAMPLES)[:, WAVE]
    every = max(1, round(time / SAMPLES / discs.coefficients.time_step)) * discs.coefficients.time_step
    swing = damped_cosine(every * np.arange(1, SAMPLES + 1), mode / speed, 2.0 * pi * guess / long)
    found = swing.undamped * long / (2.0 * pi)
    return Sound(found, found / discs.signal_speed, cell.packing)


INERTIAL = (0.3, 0.1, 0.03, 0.01, 0.003)
"""Inertial numbers, from quick to slow: each begins where the one before has ended."""
COUNT = 600
APART = {0.3: (3.0, 8.0), 0.1: (2.0, 6.0), 0.03: (1.0, 4.0), 0.01: (0.7, 2.5), 0.003: (0.4, 1.2)}
"""Strain before and while the means are taken, by inertial number."""
ROWS = 20
EXPANDED = 0.4
"""Packing below which discs are a gas, which expands for ever."""


class Sheared(NamedTuple):
    """Means of a sheared box: inertial number, friction mu, packing phi, pressure (Pa)."""

    inertial: float
    friction: float
    packing: float
    pressure: float


def sheared(
    discs: FluidDiscs, pressure: float, seed: int, *, numbers: Sequence[float] = INERTIAL, count: int = COUNT
) -> list[Sheared]:
    """Shear one start at each inertial number, from quick to slow; those at which discs expand are left out.

    Parameters
    ----------
    discs : FluidDiscs
    pressure : float
        Held, Pa.
    seed : int
    numbers : sequence of float
    count : int
        Discs of the box.
    """
    cell, rate, found = Cell(discs, count, seed), 0.0, []
    cell.close(pressure)
    for number in sorted(numbers, reverse=True):
        before, during = APART.get(number, (1.0, 3.0))
        old, rate = rate, shear_rate(number, discs.diameter, discs.density, pressure)
        cell.shear(old, rate)
        cell.advance(before / rate, 1, rate=rate, pressure=pressure)
        record = cell.advance(during / rate, ROWS, rate=rate, pressure=pressure)
        one = of_record(record, rate, cell)
        if one.packing > EXPANDED:
            found.append(one)
    return found


def of_record(record: np.ndarray, rate: float, cell: Cell) -> Sheared:
    """Means of a record of `Cell.advance` at a rate (1/s)."""
    means = record.mean(axis=0)
    pressure = 0.5 * float(means[SXX] + means[SYY])
    inertial = rate * cell.discs.diameter * sqrt(cell.discs.density / pressure)
    packing = cell.covered / float(means[AREA])
    return Sheared(inertial, -float(means[SXY]) / pressure, packing, pressure)
