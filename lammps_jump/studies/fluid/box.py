# SPDX-License-Identifier: GPL-2.0-or-later
"""Two flows of discs in a box: sound and shear without walls, and a sloshing basin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import atan, ceil, cos, hypot, nan, pi, sin, sqrt, tanh
from typing import NamedTuple

import numpy as np

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import MovingWall, Plane, Scene

from .cell import AREA, LX, SKIN, SXX, SXY, SYY, WAVE, Cell, FluidDiscs, shear_rate

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


class SoundSpeed(NamedTuple):
    """Of discs at rest: speed of sound (m/s), the same over d sqrt(k/m) = n v0, and packing."""

    speed: float
    ratio: float
    packing: float


def sound_speed(discs: FluidDiscs, pressure: float, seed: int, *, length: int = LENGTH) -> SoundSpeed:
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
    frequency = swing.undamped * long / (2.0 * pi)
    return SoundSpeed(frequency, frequency / discs.signal_speed, cell.packing)


INERTIAL = (0.3, 0.1, 0.03, 0.01, 0.003)
"""Inertial numbers, from quick to slow: each begins where the one before has ended."""
COUNT = 600
APART = {0.3: (3.0, 8.0), 0.1: (2.0, 6.0), 0.03: (1.0, 4.0), 0.01: (0.7, 2.5), 0.003: (0.4, 1.2)}
"""Strain before and while the means are taken, by inertial number."""
ROWS = 20
EXPANDED = 0.4
"""Packing below which discs are a gas, which expands for ever."""


class ShearMeans(NamedTuple):
    """Means of a sheared box: inertial number, friction mu, packing phi, pressure (Pa)."""

    inertial: float
    friction: float
    packing: float
    pressure: float


def sheared(
    discs: FluidDiscs, pressure: float, seed: int, *, numbers: Sequence[float] = INERTIAL, count: int = COUNT
) -> list[ShearMeans]:
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
    cell, rate, sheareds = Cell(discs, count, seed), 0.0, []
    cell.close(pressure)
    for number in sorted(numbers, reverse=True):
        before, during = APART.get(number, (1.0, 3.0))
        old, rate = rate, shear_rate(number, discs.diameter, discs.density, pressure)
        cell.shear(old, rate)
        cell.advance(before / rate, 1, rate=rate, pressure=pressure)
        record = cell.advance(during / rate, ROWS, rate=rate, pressure=pressure)
        one = of_record(record, rate, cell)
        if one.packing > EXPANDED:
            sheareds.append(one)
    return sheareds


def of_record(record: np.ndarray, rate: float, cell: Cell) -> ShearMeans:
    """Means of a record of `Cell.advance` at a rate (1/s)."""
    means = record.mean(axis=0)
    pressure = 0.5 * float(means[SXX] + means[SYY])
    inertial = rate * cell.discs.diameter * sqrt(cell.discs.density / pressure)
    packing = cell.covered / float(means[AREA])
    return ShearMeans(inertial, -float(means[SXY]) / pressure, packing, pressure)


# --- sloshing of discs in a box: frequency against water's, damping, and where the surface comes to rest --------------


SLOPE = 0.37
"""Slope of the surface at the start."""
ASPECT = 5.0
"""Length of the box over the depth."""
PACKED = 0.84
"""Packing at rest, from which the number of discs follows."""
SETTLE, SWINGS = 1.0, 1.6
"""Time before the release, and time that is recorded, periods of water."""
SAMPLES = 160


class Slosh(NamedTuple):
    """Result of a box of sloshing discs; NaN where the surface does not swing.

    Attributes
    ----------
    frequency : float
        As it is seen, with its damping, over that of water (`water_frequency`).
    damping : float
        Over the critical one, of a damped cosine.
    opposite : float
        First opposite swing over the start; -1 without loss.
    rest : float
        Height of the surface after the recorded time, over the start.
    amplitude : float
        Of the first mode at the wall at the start, m.
    friction : float
        mu h of `coulomb_friction` over the depth.
    """

    frequency: float
    damping: float
    opposite: float
    rest: float
    amplitude: float
    friction: float


def water_frequency(depth: float, length: float, gravity: float) -> float:
    """Frequency of the first mode of water in a box, rad/s: sqrt(g k tanh(k h)), k = pi/length (Airy 1845)."""
    k = pi / length
    return sqrt(gravity * k * tanh(k * depth))


def coulomb_friction(amplitude: float, opposite: float, depth: float) -> float:
    """Friction mu that takes (8/pi) mu h off the swing in half a period: mu = a (1 + x1) pi / (8 h).

    A layer that slides with the force mu rho g h on its area loses energy in proportion to the swing (derived).

    Parameters
    ----------
    amplitude, depth : float
        Swing a at the wall and depth h, m.
    opposite : float
        x1, first opposite swing over the start.
    """
    return amplitude * (1.0 + opposite) * pi / (8.0 * depth)


def box_of(discs: FluidDiscs, depth: float, gravity: float, seed: int) -> Scene:
    """A box of discs above each other, from which they fall into its lower corner: gravity is askew."""
    length = ASPECT * depth
    sizes = discs.sizes and replace(discs.sizes, seed=seed)
    area = np.pi / 4.0 * (sizes.mean_square if sizes else discs.diameter**2)
    count = round(PACKED * length * depth / area)
    pitch = 1.02 * (sizes.largest if sizes else discs.diameter)
    columns = int(length / pitch)
    row, column = np.divmod(np.arange(count), columns)
    random = np.random.default_rng(seed)
    x = (column + 0.5) * length / columns + random.uniform(-0.009, 0.009, count) * pitch
    y = (row + 0.5) * pitch + random.uniform(-0.009, 0.009, count) * pitch
    tilt = atan(SLOPE)
    walls = (Plane("floor", "y", 0.0, "above"), Plane("left", "x", 0.0, "above"), Plane("right", "x", length, "below"))
    return replace(
        discs.scene,
        name="slosh",
        gravity=(-gravity * sin(tilt), -gravity * cos(tilt)),
        domain=((-1.0 * discs.diameter, length + discs.diameter), (-discs.diameter, 4.0 * float(y.max()) + depth)),
        positions=np.column_stack([x, y]),
        velocities=np.zeros((count, 2)),
        walls=tuple(map(MovingWall, walls)),
        sizes=sizes,
        skin=2.0 * SKIN * discs.diameter,
    )


def swing_of(discs: FluidDiscs, depth: float, gravity: float, seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Swing of the surface: times in periods of water, the swing over its start, and that start at the wall, m.

    The swing is the mean, by mass, of cos(pi x/length) over the discs. A surface a cos(pi x/length) has a/(2 h).
    """
    scene = box_of(discs, depth, gravity, seed)
    length, dt = ASPECT * depth, scene.time_step
    period = 2.0 * pi / water_frequency(depth, length, gravity)
    simulation = NativeSimulation(scene, ledger=False)
    simulation.run(ceil(SETTLE * period / dt))
    order = np.argsort(simulation.ids)
    level = replace(
        scene, gravity=(0.0, -gravity), positions=simulation.positions[order],
        velocities=np.zeros_like(scene.velocities),
    )  # fmt: skip
    simulation = NativeSimulation(level, ledger=False)
    every = ceil(SWINGS * period / SAMPLES / dt)
    times, swing = dt * every / period * np.arange(SAMPLES + 1), np.empty(SAMPLES + 1)
    for sample in range(SAMPLES + 1):
        x = simulation.positions[:, 0]
        mass = simulation.radii**2 if scene.sizes else np.ones(x.size)
        swing[sample] = np.average(np.cos(pi * x / length), weights=mass)
        if sample < SAMPLES:
            simulation.run(every)
    return times, swing / swing[0], 2.0 * depth * float(swing[0])


def slosh_of(times: np.ndarray, swing: np.ndarray, amplitude: float, depth: float) -> Slosh:
    """Numbers of a recorded swing (`swing_of`) of discs of a depth (m)."""
    crossed = np.flatnonzero(swing <= 0.0)
    rest = float(swing[-len(swing) // 10 :].mean())
    if not crossed.size or swing.min() > -0.02:
        return Slosh(nan, nan, nan, rest, amplitude, nan)
    swing_fit, opposite = damped_cosine(times, swing, 2.0 * pi), float(swing.min())
    friction = coulomb_friction(amplitude, opposite, depth)
    return Slosh(swing_fit.frequency / (2.0 * pi), swing_fit.damping, opposite, rest, amplitude, friction)
