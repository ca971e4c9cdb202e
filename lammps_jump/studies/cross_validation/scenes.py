# SPDX-License-Identifier: GPL-2.0-or-later
"""Small scenes, each of which tests one part of the model on both engines."""

from __future__ import annotations

import numpy as np

from lammps_jump.scene import Block, Box, Gate, InletRow, Outlet, Plane, Scene, handmade_scene

DIAMETER = 0.2
DOMAIN = ((-5.0, 10.0), (-5.0, 10.0))
FLOOR = Plane("floor", "y", 0.0, "above")


def _scene(name: str, description: str, positions, velocities, walls=(), **others) -> Scene:
    settings = {"diameter": DIAMETER, "restitution": 0.5, "impact_speed": 6.0, "domain": DOMAIN, "steps": 3_000}
    settings |= {"skin": 0.3 * DIAMETER, "correct_restitution": True, "name": name, "description": description}
    return handmade_scene(positions, velocities, walls, **{**settings, **others})


def _heap(seed: int, rows: int, x0: float = 0.4) -> np.ndarray:
    """Return places of a heap of four columns, slightly moved by random numbers."""
    i, j = np.meshgrid(np.arange(4), np.arange(rows))
    grid = np.column_stack([x0 + 0.21 * i.ravel(), 0.11 + 0.21 * j.ravel()])
    return grid + np.random.default_rng(seed).uniform(-0.004, 0.004, grid.shape)


def pair_scene() -> Scene:
    """Return a ring of twelve discs thrown at one in the middle: oblique contacts, no wall, no gravity."""
    angle = 2 * np.pi * np.arange(12) / 12 + 0.05 * np.sin(np.arange(12) * 2.3)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = np.column_stack([-out[:, 1], out[:, 0]])
    positions = np.vstack([[0.0, 0.0], 0.62 * out])
    velocities = np.vstack([[0.3, -0.2], -2.5 * out + 0.4 * along])
    text = "ring of discs thrown at one in the middle: pair contacts only"
    return _scene("pair", text, positions, velocities, gravity=(0.0, 0.0))


def wall_scene() -> Scene:
    """Return discs far from each other in a box over a plane: they bounce and rest, and never meet."""
    walls = (FLOOR, Box("box", (-0.3, 3.3), (-1.0, 1.2)))
    positions = [[0.0, 0.115], [1.0, 0.2], [2.0, 0.6], [3.19, 1.0]]
    velocities = [[-1.0, 0.0], [0.0, -2.0], [0.3, 3.0], [1.0, 2.5]]
    return _scene("wall", "discs that bounce and rest on planes and box faces", positions, velocities, walls)


def corner_scene() -> Scene:
    """Return discs that hit the corners of a block and slide off: normals that turn."""
    walls = (Block("step", (0.0, 1.0), (-1.0, 0.5)), FLOOR)
    positions = [[-0.03, 0.61], [1.05, 0.62], [0.5, 0.61], [-0.8, 0.55], [1.9, 0.52]]
    velocities = [[0.0, -1.0], [-0.4, -1.5], [3.0, 0.0], [4.0, 0.4], [-5.0, 0.6]]
    return _scene("corner", "discs against the corners of a block", positions, velocities, walls)


def _sliding_heap(name: str, text: str, seed: int, slow: float, range_: float, **contact) -> Scene:
    """Return a heap of twenty discs that slides against a step; speeds (m/s) rise from `slow` by `range_`."""
    velocities = np.column_stack([slow + range_ * np.arange(20) / 20, np.zeros(20)])
    return _scene(name, text, _heap(seed, 5), velocities, (FLOOR, Block("step", (2.0, 2.5), (-1.0, 0.3))), **contact)


def friction_scene(law: str = "hooke") -> Scene:
    """Return a heap that slides and topples with friction, without spin."""
    name = "friction" if law == "hooke" else f"friction ({law} law)"
    text = "a heap that slides and topples against a step, ks = 0.3"
    return _sliding_heap(name, text, 7, 1.5, 0.3, friction=0.3, friction_law=law)


def spin_scene() -> Scene:
    """Return the same heap with spin and higher friction."""
    return _sliding_heap("spin", "the heap with turning discs, ks = 0.5", 8, 1.2, 0.6, friction=0.5, rotation=True)


def gate_scene() -> Scene:
    """Return a column that settles behind a gate until the gate opens."""
    text, walls = "a column behind a gate that opens after 600 steps", (Plane("back", "x", 0.0, "above"), FLOOR)
    gates = (Gate(Plane("gate", "x", 0.86, "below"), 600),)
    return _scene("gate", text, _heap(9, 6, 0.11), np.zeros((24, 2)), walls, gates=gates, settle_steps=600)


def inlet_scene() -> Scene:
    """Return two rows of inflow over a floor into an outlet, so that discs leave while others enter."""
    text, none = "two rows of inflow over a sill into an outlet", np.empty((0, 2))
    rows = tuple(InletRow(0.0, 0.1 + 0.2 * i, 4.0 + 0.7 * i, 0.0, 1, 260 - 35 * i, 0.999 * DIAMETER) for i in range(2))
    walls = (Block("floor", (-4.0, 3.0), (-4.0, 0.0)), Block("sill", (1.2, 1.4), (-4.0, 0.15)))
    outlets = (Outlet("x", 1.9, "above", 40), Outlet("y", -1.0, "below", 40))
    return _scene("inlet and outlet", text, none, none, walls, inlets=rows, outlets=outlets)


def elastic_scene() -> Scene:
    """Return discs of restitution 1 in a closed box: without damping, errors grow fastest."""
    positions = [[0.3, 0.3], [0.7, 0.35], [0.4, 0.75], [0.8, 0.8], [0.55, 0.5]]
    velocities = [[4.0, -3.0], [0.0, 0.0], [0.0, 0.0], [-2.0, 1.0], [0.0, 0.0]]
    text, walls = "five discs, restitution 1, closed box", (Box("box", (0.0, 1.0), (0.0, 1.0)),)
    return _scene("elastic box", text, positions, velocities, walls, restitution=1.0, gravity=(0.0, 0.0))


def micro_scenes() -> tuple[Scene, ...]:
    """Return the scenes that both LAMMPS kernels can run, in the order of the report."""
    makers = (pair_scene, wall_scene, corner_scene, friction_scene, spin_scene, elastic_scene, gate_scene, inlet_scene)
    return tuple(make() for make in makers)
