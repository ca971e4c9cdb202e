# SPDX-License-Identifier: GPL-2.0-or-later
"""Small scenes, each of which tests one part of the model on both engines."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Block, Box, InletRow, MovingWall, Outlet, Plane, Scene, Sizes, gate, handmade_scene
from lammps_jump.scene.scene import Fixed
from lammps_jump.scene.walls import Wall

DIAMETER = 0.2
DOMAIN = ((-5.0, 10.0), (-5.0, 10.0))
FLOOR = Plane("floor", "y", 0.0, "above")


def _scene(
    name: str,
    description: str,
    positions: ArrayLike,
    velocities: ArrayLike,
    walls: tuple[Wall | MovingWall, ...] = (),
    **others: Any,
) -> Scene:
    settings = {"diameter": DIAMETER, "restitution": 0.5, "impact_speed": 6.0, "domain": DOMAIN, "steps": 3_000}
    settings |= {"skin": 0.3 * DIAMETER, "correct_restitution": True, "name": name, "description": description}
    return handmade_scene(positions, velocities, walls, **{**settings, **others})


def _heap(seed: int, rows: int, x0: float = 0.4) -> np.ndarray:
    """Return places of a heap of four columns, slightly moved by random numbers."""
    i, j = np.meshgrid(np.arange(4), np.arange(rows))
    grid = np.column_stack([x0 + 0.21 * i.ravel(), 0.11 + 0.21 * j.ravel()])
    return grid + np.random.default_rng(seed).uniform(-0.004, 0.004, grid.shape)


def _ring() -> tuple[np.ndarray, np.ndarray]:
    """Return places and velocities of a disc and twelve others around it that are thrown at it."""
    angle = 2 * np.pi * np.arange(12) / 12 + 0.05 * np.sin(np.arange(12) * 2.3)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = np.column_stack([-out[:, 1], out[:, 0]])
    return np.vstack([[0.0, 0.0], 0.62 * out]), np.vstack([[0.3, -0.2], -2.5 * out + 0.4 * along])


def _sliding_heap(name: str, text: str, seed: int, slow: float, range_: float, **contact: Any) -> Scene:
    """Return a heap of twenty discs that slides against a step; speeds (m/s) rise from `slow` by `range_`."""
    velocities = np.column_stack([slow + range_ * np.arange(20) / 20, np.zeros(20)])
    return _scene(name, text, _heap(seed, 5), velocities, (FLOOR, Block("step", (2.0, 2.5), (-1.0, 0.3))), **contact)


def friction_scene(law: str = "viscous") -> Scene:
    """Return a heap that slides and topples with friction, without spin."""
    name = "friction" if law == "viscous" else f"friction ({law} law)"
    text = "a heap that slides and topples against a step, μ = 0.3"
    return _sliding_heap(name, text, 7, 1.5, 0.3, friction=0.3, friction_law=law)


def _channel() -> Scene:
    """Return a layer of discs that slides over a row of fixed ones, in a periodic channel."""
    places = _heap(10, 3, 0.15)
    places[:, 1] += 0.05
    row = np.column_stack([0.11 * np.arange(10), np.zeros(10)])
    n, m = len(places), len(row)
    speeds = np.vstack([np.tile([1.5, 0.0], (n, 1)), 0 * row])
    return _scene(
        "channel", "a layer that slides over fixed discs, periodic, with springs", np.vstack([places, row]), speeds,
        friction=0.5, rotation=True, friction_law="history", springs=Springs(), gravity=(3.0, -9.0),
        domain=((0.0, 1.1), (-5.0, 10.0)), periodic=True, fixed=Fixed(n + 1, n + m),
        sizes=Sizes((1.0,), (DIAMETER,), (DIAMETER,), 1, ((n + 1, n + m, 0.1),)),
    )  # fmt: skip


def micro_scenes() -> tuple[Scene, ...]:
    """Return the scenes that both LAMMPS kernels can run, in the order of the report."""
    none, shut = np.empty((0, 2)), gate(Plane("gate", "x", 0.86, "below"), 600)
    rows = tuple(InletRow(0.0, 0.1 + 0.2 * i, 4.0 + 0.7 * i, 0.0, 1, 260 - 35 * i, 0.999 * DIAMETER) for i in range(2))
    outlets = (Outlet("x", 1.9, "above", 40), Outlet("y", -1.0, "below", 40))
    return (
        _scene("pair", "ring of discs thrown at one in the middle: pair contacts only", *_ring(), gravity=(0.0, 0.0)),
        _scene("wall", "discs that bounce and rest on planes and box faces",
               [[0.0, 0.115], [1.0, 0.2], [2.0, 0.6], [3.19, 1.0]], [[-1.0, 0.0], [0.0, -2.0], [0.3, 3.0], [1.0, 2.5]],
               (FLOOR, Box("box", (-0.3, 3.3), (-1.0, 1.2)))),
        _scene("corner", "discs against the corners of a block",  # normals that turn
               [[-0.03, 0.61], [1.05, 0.62], [0.5, 0.61], [-0.8, 0.55], [1.9, 0.52]],
               [[0.0, -1.0], [-0.4, -1.5], [3.0, 0.0], [4.0, 0.4], [-5.0, 0.6]],
               (Block("step", (0.0, 1.0), (-1.0, 0.5)), FLOOR)),
        friction_scene(),
        _sliding_heap("spin", "the heap with turning discs, μ = 0.5", 8, 1.2, 0.6, friction=0.5, rotation=True),
        _sliding_heap("springs", "the same with tangential and rolling springs", 8, 1.2, 0.6, friction=0.5,
                      rotation=True, friction_law="history", springs=Springs(rolling=Rolling(0.1, 0.1, 1.0))),
        _channel(),
        _scene("elastic box", "five discs, restitution 1, closed box",  # without damping, errors grow fastest
               [[0.3, 0.3], [0.7, 0.35], [0.4, 0.75], [0.8, 0.8], [0.55, 0.5]],
               [[4.0, -3.0], [0.0, 0.0], [0.0, 0.0], [-2.0, 1.0], [0.0, 0.0]],
               (Box("box", (0.0, 1.0), (0.0, 1.0)),), restitution=1.0, gravity=(0.0, 0.0)),
        _scene("gate", "a column behind a gate that opens after 600 steps", _heap(9, 6, 0.11), np.zeros((24, 2)),
               (Plane("back", "x", 0.0, "above"), FLOOR, shut), settle_steps=600),
        _scene("inlet and outlet", "two rows of inflow over a sill into an outlet", none, none,
               (Block("floor", (-4.0, 3.0), (-4.0, 0.0)), Block("sill", (1.2, 1.4), (-4.0, 0.15))),
               inlets=rows, outlets=outlets),
    )  # fmt: skip
