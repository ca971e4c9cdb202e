# SPDX-License-Identifier: GPL-2.0-or-later
"""Sloshing of discs in a box: frequency against water's, damping, and where the surface comes to rest."""

from __future__ import annotations

from dataclasses import replace
from math import atan, ceil, cos, nan, pi, sin, sqrt, tanh
from typing import NamedTuple

import numpy as np

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import MovingWall, Plane, Scene

from .cell import SKIN
from .discs import FluidDiscs
from .sound import damped_cosine

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
        Where the surface stands after the recorded time, over the start.
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
    found, opposite = damped_cosine(times, swing, 2.0 * pi), float(swing.min())
    friction = coulomb_friction(amplitude, opposite, depth)
    return Slosh(found.frequency / (2.0 * pi), found.damping, opposite, rest, amplitude, friction)
