# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies without a case file, for tests."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lammps_jump.dump.walls import BodyHistory
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.physics.bodies import section_of_circle, section_of_polygon
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import Scene, handmade_scene
from lammps_jump.scene.walls import Block, Box, Circle, Line, Plane, Polygon, Wall

DENSITY = 1000.0
FAR = [(90.0, 90.0)]
"""A disc that meets nothing."""


def body(wall: Wall, gravity=(0.0, -9.81), density: float = DENSITY, **free: Any) -> MovingWall:
    """A wall as a body of its own area."""
    if isinstance(wall, Circle):
        section = section_of_circle(wall.centre, wall.radius)
    else:
        section = section_of_polygon(np.array(wall.outline((0.0, 0.0), (0.0, 0.0))[0]))
    mass = density * section.area
    weight = mass * gravity[0], mass * gravity[1]
    fields = {"mass": mass, "inertia": density * section.moment, "centre": section.centre, "weight": weight}
    kind = Free(**{**fields, "corner_radius": 0.05, **free})
    return MovingWall(wall, Motion(kind=kind, about=kind.point))


def crowd(**last: Any) -> tuple[Wall | MovingWall, ...]:
    """Walls of every kind and bodies of every shape among them; `last` are fields of the body that comes last."""
    return (
        Plane("floor", "y", 0.0, "above"), Block("step", (3.0, 4.0), (-1.0, 0.5)), Circle("pier", (5.0, 1.0), 0.5),
        Line("ramp", ((-3.0, 2.0), (-1.0, 0.2), (-0.6, 0.3))), Box("box", (-4.0, 7.0), (0.0, 5.0)),
        body(Block("a", (0.0, 1.0), (0.01, 0.8)), velocity=(3.0, -2.0), spin=1.0),
        body(Polygon("b", ((1.05, 0.5), (2.2, 0.7), (1.8, 1.4))), velocity=(-1.0, -1.0)),
        body(Circle("c", (3.2, 0.92), 0.4), spin=-5.0, velocity=(0.0, -1.0)),
        body(Block("d", (4.2, 4.4), (0.6, 2.6)), hinge=(4.3, 2.5), spin=3.0),
        body(Circle("e", (2.6, 1.33), 0.3), velocity=(1.0, -2.0), **last),
    )  # fmt: skip


def scene_of(*walls, positions=FAR, velocities=None, gravity=(0.0, -9.81), **fields: Any) -> Scene:
    """A scene of walls, bodies and discs; bodies keep the weight that they have."""
    fields = {"probe_steps": 100_000, **fields}  # a row of each body a window costs time
    velocities = np.zeros_like(positions, float) if velocities is None else velocities
    step = handmade_scene(positions, velocities, **fields).time_step
    walls = tuple(
        MovingWall(one.wall, Motion(kind=one.motion.kind, about=one.motion.about, time_step=step))
        if isinstance(one, MovingWall)
        else one
        for one in walls
    )
    return handmade_scene(positions, velocities, walls, gravity=gravity, **fields)


@dataclass
class State:
    """Where a body is (m, m, rad) and how fast at the step, with its numbers."""

    pose: np.ndarray
    velocity: np.ndarray
    free: Free

    @property
    def momentum(self) -> np.ndarray:
        """Along x and y, and angular about the origin; per metre of width."""
        x, y = np.add(self.free.centre, self.pose[:2])
        px, py = self.free.mass * self.velocity[:2]
        return np.array([px, py, x * py - y * px + self.free.inertia * self.velocity[2]])

    @property
    def kinetic(self) -> float:
        """J per metre of width."""
        return 0.5 * float(np.array([self.free.mass, self.free.mass, self.free.inertia]) @ self.velocity**2)


def state_of(simulation: NativeSimulation, name: str) -> State:
    """A body now."""
    walls = simulation.walls
    number = walls.names.index(name)
    free = {wall.name: motion.free for wall, motion in simulation.scene.walls}[name]
    return State(walls.moves.pushed[number, :3].copy(), walls.moves.now[number, 8:11].copy(), free)


TIME = np.linspace(0.0, 10.0, 401)
"""Rows of a history made up, s."""
WIDE = Block("box", (4.0, 6.0), (0.0, 1.0))
TALL = Block("post", (4.0, 4.7), (0.0, 3.5))


def ramp(begin, end, size=1.0):
    """From 0 to `size` between two times."""
    return size * np.clip((TIME - begin) / (end - begin), 0.0, 1.0)


def history_of(one, x=0.0, y=0.0, angle=0.0, about=None):
    """A body that comes so far (m) and turns so far (rad) about a point of its own, by default the centre of mass."""
    zero, free = np.zeros_like(TIME), one.motion.free
    angle, centre = zero + angle, np.array(free.centre)
    arm = centre - (centre if about is None else np.array(about))
    px = centre[0] - arm[0] + np.cos(angle) * arm[0] - np.sin(angle) * arm[1] + x
    py = centre[1] - arm[1] + np.sin(angle) * arm[0] + np.cos(angle) * arm[1] + y
    v = np.gradient(px, TIME), np.gradient(py, TIME)
    return BodyHistory(TIME, px, py, angle, *v, np.gradient(angle, TIME), zero, zero, zero)


def corner(wall, right):
    """The lower corner of a wall on one side."""
    points = np.asarray(wall.outline((0.0, 0.0), (0.0, 0.0))[0])
    low = points[points[:, 1] < points[:, 1].min() + 1e-9]
    return low[np.argmax(low[:, 0]) if right else np.argmin(low[:, 0])]
