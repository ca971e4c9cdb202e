# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts on the native engine against closed forms (docs/theory.md)."""

from math import atan2, cos, exp, log, pi, sin, sqrt

import numpy as np
import pytest

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.walls import Block, Plane

D = 0.2
FLOOR = Plane("floor", "y", 0.0, "above")


def head_on_speeds(scene_kw, speed, wall):
    """Rebound over approach speed of 32 collisions that differ in the phase of entry."""
    n = 32
    probe = handmade_scene([], [], **scene_kw)
    dt = probe.time_step
    phases = (np.arange(n) + 0.5) / n
    y = 1.0 + np.arange(n)
    walls = ()
    if wall:
        x = D / 2 + 1e-3 + phases * speed * dt
        positions, velocities = np.column_stack([x, y]), np.tile([-speed, 0.0], (n, 1))
        walls = (Plane("wall", "x", 0.0, "above"),)
    else:
        gap = D + 1e-3 + phases * speed * dt
        positions = np.vstack([np.column_stack([np.zeros(n), y]), np.column_stack([gap, y])])
        velocities = np.vstack([np.tile([speed / 2, 0.0], (n, 1)), np.tile([-speed / 2, 0.0], (n, 1))])
    simulation = NativeSimulation(handmade_scene(positions, velocities, walls, **scene_kw))
    # a slow contact deep inside a smooth touch of width s lasts longer by about sqrt(s omega / v)
    softness = (1.0 + scene_kw.get("touch_width", 0.0) * probe.coefficients.omega / speed) ** 0.5
    simulation.run(int((1e-3 / speed + 1.6 * softness * probe.coefficients.contact_duration) / dt) + 3)
    v = simulation.velocities[:, 0]
    return v / speed if wall else (v[n:] - v[:n]) / speed


@pytest.mark.parametrize(
    ("integrator", "e", "order"),
    [("velocity_verlet", 1.0, 2.0), ("velocity_verlet", 0.2, 1.0), ("leapfrog_extrapolated", 0.2, 2.0)],
)
def test_order_of_convergence_inside_a_contact(integrator, e, order):
    """From a small overlap, against the damped oscillation; LAMMPS' lagged dashpot costs one order."""
    errors = []
    start = 0.002
    for steps in (16, 32, 64):
        kw = dict(restitution=e, integrator=integrator, gravity=(0.0, 0.0))
        c = handmade_scene([], [], **kw).coefficients
        duration = pi / (c.omega_wall * sqrt(1 - c.damping_ratio**2))
        fraction = 0.4 * duration / steps / c.critical_time_step
        scene = handmade_scene([[0, D / 2 - start]], [[0, -3.0]], (FLOOR,), time_step_fraction=fraction, **kw)
        simulation = NativeSimulation(scene)
        simulation.run(steps)
        t, xi, w = 0.4 * duration, c.damping_ratio, c.omega_wall
        s = w * sqrt(1 - xi**2)
        overlap = exp(-xi * w * t) * (start * cos(s * t) + (3.0 + xi * w * start) / s * sin(s * t))
        errors.append(abs(D / 2 - simulation.positions[0, 1] - overlap))
    observed = log(errors[1] / errors[2]) / log(2)
    assert observed == pytest.approx(order, abs=0.15)  # next term of the expansion at 40 steps a contact


def test_sign_law_is_a_ramp_below_a_hundredth_of_the_fastest_disc():
    """A slow disc beside a fast one decays as exp(-μ g t / eps), eps = 0.01 v_max (thesis 4.19-4.20)."""
    mu, fast, slow = 0.1, 10.0, 0.05
    rest = D / 2 - 40 * 9.81 / 2.56e7
    scene = handmade_scene([[0, rest], [5, 50]], [[slow, 0], [fast, 0]], (FLOOR,), friction=mu, friction_law="sign")
    simulation = NativeSimulation(scene)
    steps = 200
    simulation.run(steps)
    t = steps * scene.time_step
    # the fast disc gains (g t)^2 / 2 fast of speed as it falls: 1.5e-4 of eps at the end
    assert simulation.velocities[0, 0] == pytest.approx(slow * exp(-mu * 9.81 * t / (0.01 * fast)), rel=2e-4)


def test_sign_law_bears_a_scene_at_rest():
    scene = handmade_scene(
        [[0, D / 2 - 1e-4]], [[0, 0]], (FLOOR,), friction=0.3, friction_law="sign", gravity=(0.0, 0.0), rotation=True
    )
    simulation = NativeSimulation(scene)
    assert np.isfinite(simulation.velocities).all()
    assert simulation.velocities[0, 0] == 0.0


def test_centre_inside_a_block_feels_nothing():
    scene = handmade_scene([[0, 0]], [[1, 0]], (Block("b", (-1, 1), (-1, 1)),), gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(50)
    assert simulation.velocities[0] == pytest.approx([1.0, 0.0], abs=0)


def cloud(seed, n=8):
    rng = np.random.default_rng(seed)
    grid = np.array([(0.22 * i, 0.22 * j) for j in range(n) for i in range(n)])
    return grid + rng.uniform(-0.01, 0.01, grid.shape), rng.normal(0, 3.0, grid.shape)


@pytest.mark.parametrize("law", ["viscous", "sign"])
def test_momentum_is_conserved_without_walls(law):
    positions, velocities = cloud(1)
    scene = handmade_scene(positions, velocities, friction=0.3, friction_law=law, rotation=True, gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(2000)
    assert simulation.velocities.sum(axis=0) == pytest.approx(velocities.sum(axis=0), abs=1e-10)
    # forces act at the surface, arm R on both sides: angular momentum is kept but for the overlap (LAMMPS' convention)
    assert simulation.energy().kinetic < 0.5 * 40 * (velocities**2).sum()


@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
def test_mirrored_scene_runs_mirrored(integrator):
    positions, velocities = cloud(2)
    kw = dict(friction=0.2, rotation=True, integrator=integrator)
    right = NativeSimulation(handmade_scene(positions, velocities, (Plane("w", "x", -0.12, "above"), FLOOR_LOW), **kw))
    flip = np.array([-1.0, 1.0])
    left = NativeSimulation(
        handmade_scene(positions * flip, velocities * flip, (Plane("w", "x", 0.12, "below"), FLOOR_LOW), **kw)
    )
    right.run(600)
    left.run(600)
    # the sums run in another order: round-off, grown by a few collisions
    assert left.positions * flip == pytest.approx(right.positions, abs=1e-9 * D)
    assert -left.spin == pytest.approx(right.spin, abs=1e-7)


FLOOR_LOW = Plane("floor", "y", -0.12, "above")


@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize(("f", "off"), [(0.01, 0.001), (0.05, 0.004), (0.2, 0.012)])
def test_smooth_touch_restitution_at_every_speed(f, off, wall):
    """The linear law's restitution, exact in continuous time; tolerance: what the lag leaves at f (docs/kernels.md)."""
    kw = dict(restitution=0.2, time_step_fraction=f, gravity=(0.0, 0.0), correct_restitution=True)
    dt = handmade_scene([], [], **kw).time_step
    speeds = (1.6, 8.0, 16.0, 32.0)
    smooth = dict(**kw, touch="smooth", touch_width=2 * 16.0 * dt)
    found = [head_on_speeds(smooth, speed, wall).mean() for speed in speeds]
    assert found == pytest.approx([0.2] * len(speeds), abs=off)


def test_smooth_touch_does_not_see_the_entry_phase():
    """Scatter over the phases at f = 0.2, e = 0.2 and v0: sharp 0.015, width of two steps 0.004."""
    kw = dict(restitution=0.2, time_step_fraction=0.2, gravity=(0.0, 0.0))
    dt = handmade_scene([], [], **kw).time_step
    smooth = head_on_speeds(dict(**kw, touch="smooth", touch_width=32.0 * dt), 16.0, False)
    assert smooth.std() < 0.4 * head_on_speeds(kw, 16.0, False).std()


def test_largest_overlap_of_a_collision():
    scene = handmade_scene([[0, D / 2]], [[0, -3.0]], (FLOOR,), time_step_fraction=0.002, gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    c = scene.coefficients
    xi = c.damping_ratio
    deepest = 0.0
    for _ in range(int(1.2 * pi / c.omega_wall / c.time_step)):
        simulation.run(1)
        deepest = max(deepest, D / 2 - simulation.positions[0, 1])
    s = sqrt(1 - xi**2)
    assert deepest == pytest.approx(3.0 / c.omega_wall * exp(-xi / s * atan2(s, xi)), rel=0.005)
