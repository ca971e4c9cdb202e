# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies are as much stiffer as they are heavier, at the same time step."""

from itertools import product
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from free_bodies import body, scene_of, state_of

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.errors import RunError
from lammps_jump.physics.bodies import tipping_speed
from lammps_jump.physics.slip import Springs
from lammps_jump.scene.meeting import laws_between, stiffness_between
from lammps_jump.scene.walls import Block, Circle, Plane

G = 9.81
FLOOR = Plane("floor", "y", 0.0, "above")
NOTHING: dict[str, Any] = {"gravity": (0.0, 0.0)}
STICKS: dict[str, Any] = {"friction": 0.6, "friction_law": "history", "springs": Springs(2 / 7, 1.0)}


@pytest.mark.parametrize("density", [1e3, 1e4, 1e5])
@pytest.mark.parametrize(("wide", "high"), [(1.0, 1.0), (0.5, 3.0), (3.0, 0.5)])
def test_the_stiffness_is_that_of_the_corner_that_gives_way_most(wide, high, density):
    """k = omega^2 m_eff with 1/m_eff = 1/M + r^2/I: four of M at a sharp corner; two such blocks have half of it."""
    one, two = (body(Block(f"b{k}", (4.0 * k, 4.0 * k + wide), (0.0, high)), density=density) for k in (0, 1))
    scene = scene_of(FLOOR, one, two)
    c, free = scene.coefficients, one.motion.free
    sharp = c.omega_wall**2 * free.mass / 4
    rounded = max(wide, high) / (max(wide, high) - 2 * free.corner_radius)
    found = laws_between(scene, scene.walls)[:, :, 0]
    assert sharp <= found[0, 1] <= sharp * rounded**2
    assert found[1, 2] == pytest.approx(0.5 * found[0, 1]) and found[1, 0] == found[0, 1] and not found[0, 0]


def test_rails_hinges_and_circles_have_their_own():
    fields = {
        "rail": {"axes": (True, False, False)},
        "pinned": {"axes": (False, False, True)},
        "hinged": {"hinge": (0.0, 0.0)},
    }
    blocks = {
        name: body(Block(name, (0.0, 1.0), (0.0, 2.0)), corner_radius=1e-6, **own) for name, own in fields.items()
    }
    circle = body(Circle("circle", (0.0, 1.0), 0.5))
    c = scene_of(FLOOR).coefficients
    masses = {name: stiffness_between(c, one) / c.omega_wall**2 for name, one in (blocks | {"circle": circle}).items()}
    free = blocks["hinged"].motion.free
    assert masses["circle"] == pytest.approx(circle.motion.free.mass)  # its normals go through the centre
    assert masses["rail"] == pytest.approx(free.mass)
    assert masses["pinned"] == pytest.approx(free.inertia / (0.5**2 + 1.0**2), rel=1e-5)
    assert masses["hinged"] == pytest.approx(free.inertia_there / (1.0**2 + 2.0**2), rel=1e-5)


def test_a_stiffness_of_its_own_counts_and_light_bodies_have_that_of_discs():
    c = scene_of(FLOOR).coefficients
    own, plain = (body(Block("b", (0.0, 1.0), (0.0, 1.0), stiffness=k)) for k in (3e7, None))
    soft = scene_of(Plane("soft", "y", 0.0, "above", stiffness=1e6), own).walls[0]
    light = body(Block("light", (0.0, 0.2), (0.0, 0.2)), density=100.0)
    assert stiffness_between(c, own) == 3e7 and stiffness_between(c, own, plain) == 3e7
    assert stiffness_between(c, plain, soft) == stiffness_between(c, own, soft) == 1e6
    assert stiffness_between(c, light) == c.stiffness_wall


def rested(density: float, **fields: Any):
    """A block of 1 m x 2 m on a floor after half a second."""
    block = body(Block("block", (0.0, 1.0), (0.0, 2.0)), density=density, **fields)
    simulation = NativeSimulation(scene_of(FLOOR, block, time_step_fraction=0.1, **STICKS))
    simulation.run(round(0.5 / simulation.scene.time_step))
    return simulation


@pytest.mark.parametrize("density", [1e3, 1e4, 1e5, 1e6])
def test_a_body_sinks_as_little_as_a_disc_however_heavy_it_is(density):
    """On two corners by M g/(2 k) with k = m_eff omega^2, and m_eff of a sharp block M/4: 2 g/omega^2."""
    simulation = rested(density)
    assert simulation.scene.time_step == rested(1e3).scene.time_step
    sunk, omega = -state_of(simulation, "block").pose[1], simulation.scene.coefficients.omega_wall
    k = stiffness_between(simulation.scene.coefficients, simulation.scene.bodies[0])
    assert sunk == pytest.approx(0.5 * 2.0 * density * G / k, rel=1e-6)
    assert sunk == pytest.approx(2 * G / omega**2, rel=0.12)  # a rounded corner gives way less


@pytest.mark.parametrize("density", [1e3, 1e5])
def test_friction_needs_little_way_however_heavy_a_body_is(density):
    """Under half of mu W it is held by the tangential springs: F/(2 k_t), and the turn of the block about its base."""
    weight = 2.0 * density * G
    simulation = rested(density, weight=(0.15 * weight, -weight))
    assert 0 < state_of(simulation, "block").pose[0] < 2e-4


def toppled(wide: float, high: float, stiffness: float | None = None):
    """A tall block that is pushed over, on a floor without discs, with v0 a third of the speed of its end."""
    speed = tipping_speed(high, G)
    spin = -1.5 * sqrt(3 * G * (np.hypot(wide, high) - high)) / np.hypot(wide, high)
    outline = Block("block", (0.0, wide), (0.0, high), stiffness=stiffness)
    block = body(outline, density=2400.0, spin=spin, velocity=(-spin * high / 2, 0.0))
    law = {"time_step_fraction": 0.1, "restitution": 0.2, "impact_speed": 0.35 * speed}
    simulation = NativeSimulation(scene_of(FLOOR, block, positions=[(50.0, 0.1)], **STICKS, **law))
    simulation.run(round(6.0 / simulation.scene.time_step))
    return simulation


@pytest.mark.parametrize(
    ("wide", "high"),
    [(0.7, 3.5), *(pytest.param(*one, marks=pytest.mark.long) for one in product((0.3, 1.0), (2.5, 8.0)))],
)
def test_a_body_that_topples_comes_to_lie_and_ends_no_run(wide, high):
    found = state_of(toppled(wide, high), "block")
    assert found.pose[2] == pytest.approx(-pi / 2, abs=1e-3) and found.velocity == pytest.approx([0, 0, 0], abs=1e-3)


def test_with_the_stiffness_of_discs_it_ends_the_run():
    c = scene_of(FLOOR, impact_speed=0.35 * tipping_speed(3.5, G)).coefficients
    with pytest.raises(RunError, match="'block' and 'floor' overlap by"):
        toppled(0.7, 3.5, c.stiffness_wall)
