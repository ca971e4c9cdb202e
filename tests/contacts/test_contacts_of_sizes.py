# SPDX-License-Identifier: GPL-2.0-or-later
"""Restitution of discs of unequal mass: every pair and every wall at the closed form of its own contact frequency."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hosts import start

from lammps_jump.physics.contact import damping_ratio, extrapolated_restitution, lagged_restitution
from lammps_jump.scene import Block, Plane, Sizes, handmade_scene

CLOSED = {"velocity_verlet": lagged_restitution, "leapfrog_extrapolated": extrapolated_restitution}
ENGINES = ("lammps", "compiled", "native_verlet", "native_leapfrog")
D, SPEED, PHASES = 0.2, 3.0, 15
LARGE = {1: D, 2: D * sqrt(2), 10: D * sqrt(10)}
"""Diameter by mass over that of the smallest."""
SIZES = Sizes((1 / 3, 1 / 3, 1 / 3), tuple(LARGE.values()), tuple(LARGE.values()))


def ids_by_size(count: int) -> dict[int, list[int]]:
    """Ids 1 … count of each mass ratio."""
    d = SIZES.diameters(np.arange(1, count + 1))
    return {ratio: (np.flatnonzero(d == size) + 1).tolist() for ratio, size in LARGE.items()}


def scheme_of(engine: str) -> str:
    """The integrator of an engine."""
    return "leapfrog_extrapolated" if engine == "native_leapfrog" else "velocity_verlet"


def scene(positions, velocities, walls=(), **others):
    others = {"time_step_fraction": 0.05, "restitution": 0.2, "gravity": (0.0, 0.0), "skin": 0.05} | others
    return handmade_scene(positions, velocities, walls, sizes=SIZES, domain=((-10, 500), (-10, 500)), **others)


def after(engine, made, folder, steps):
    """Velocities after the collisions, shape (n, 2)."""
    running = start(engine, made, [], folder)
    try:
        running.run(steps)
        return running.velocities
    finally:
        running.close()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_head_on_pairs(engine, restitution, tmp_path):
    n = 240
    by_size = ids_by_size(n)
    positions = np.array([[2.0 * i, 100.0] for i in range(n)])  # those without a partner stay there
    velocities = np.zeros((n, 2))
    step = scene(positions, velocities).time_step
    pairs = {}
    row = 0
    for a, b in ((1, 1), (1, 2), (1, 10), (2, 10), (10, 10)):
        pairs[a, b] = []
        for phase in range(PHASES):
            i, j = by_size[a].pop() - 1, by_size[b].pop() - 1
            row += 1
            reach = (LARGE[a] + LARGE[b]) / 2
            gap = (phase + 0.5) / PHASES * SPEED * step
            positions[i], positions[j] = (0, row), (reach + gap, row)
            velocities[i], velocities[j] = (SPEED * LARGE[b] ** 2 / (LARGE[a] ** 2 + LARGE[b] ** 2), 0), (0, 0)
            velocities[j, 0] = velocities[i, 0] - SPEED
            pairs[a, b].append((i, j))
    made = scene(positions, velocities, restitution=restitution, integrator=scheme_of(engine))
    found = after(engine, made, tmp_path, 800)
    k, xi = made.coefficients.stiffness, damping_ratio(restitution)
    for (a, b), discs in pairs.items():
        measured = [(found[j, 0] - found[i, 0]) / SPEED for i, j in discs]
        masses = made.masses([LARGE[a], LARGE[b]])
        effective = masses.prod() / masses.sum()
        expected = CLOSED[made.integrator](xi, sqrt(k / effective) * made.time_step)
        assert np.mean(measured) == pytest.approx(expected, rel=0.005), (a, b)
        for i, j in discs:  # momentum
            before, now = velocities[[i, j], 0], found[[i, j], 0]
            assert masses @ now == pytest.approx(masses @ before, abs=1e-9 * masses.sum() * SPEED)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "wall", [Plane("floor", "y", 0.0, "above"), Block("floor", (-5.0, 400.0), (-5.0, 0.0))], ids=["plane", "block"]
)
def test_walls(engine, wall, tmp_path):
    n = 60
    by_size = ids_by_size(n)
    step = scene(np.zeros((1, 2)), np.zeros((1, 2))).time_step
    positions = np.array([[2.0 * i, 100.0] for i in range(n)])
    velocities = np.zeros((n, 2))
    fallen = {ratio: [by_size[ratio].pop() - 1 for _ in range(PHASES)] for ratio in LARGE}
    for ratio, discs in fallen.items():
        for phase, i in enumerate(discs):
            positions[i, 1] = LARGE[ratio] / 2 + (phase + 0.5) / PHASES * SPEED * step
            velocities[i, 1] = -SPEED
    made = scene(positions, velocities, (wall,), integrator=scheme_of(engine))
    found = after(engine, made, tmp_path, 800)
    for ratio, discs in fallen.items():
        h = sqrt(made.coefficients.stiffness_wall / made.masses(LARGE[ratio])) * made.time_step
        expected = CLOSED[made.integrator](damping_ratio(0.2), h)
        assert np.mean(found[discs, 1]) / SPEED == pytest.approx(expected, rel=0.005), ratio
