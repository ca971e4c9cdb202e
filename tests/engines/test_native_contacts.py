# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts on the native engine against closed forms (docs/theory.md)."""

from math import atan2, cos, exp, log, pi, sin, sqrt

import numpy as np
import pytest
from closed_forms import friction_impulse_factor

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.physics.contact import lagged_restitution
from lammps_jump.scene.build import handmade_scene
from lammps_jump.scene.walls import Block, Plane

D = 0.2
FLOOR = Plane("floor", "y", 0.0, "above")


def extrapolated_restitution(xi, h):
    """Restitution of thesis (3.7)-(3.9): dominant complex pair of the 3 x 3 map of one step in contact."""
    # state (v, v of the step before, x): v+ = v - h (x + 2 xi (1.5 v - 0.5 v-)), x+ = x + h v+
    row = np.array([1 - 3 * xi * h, xi * h, -h])
    step = np.array([row, [1, 0, 0], [*(h * row[:2]), 1 + h * row[2]]])
    values = np.linalg.eigvals(step)
    value = max(values[values.imag > 1e-9], key=abs)
    return exp(pi / np.angle(value) * log(abs(value)))


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


@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
@pytest.mark.parametrize(("e", "f"), [(0.2, 0.02), (0.2, 0.05), (0.2, 0.1), (0.6, 0.05), (0.9, 0.05)])
def test_head_on_restitution_is_the_closed_form_of_the_discrete_map(e, f, integrator, wall):
    kw = dict(restitution=e, time_step_fraction=f, integrator=integrator, gravity=(0.0, 0.0))
    c = handmade_scene([], [], **kw).coefficients
    h = (c.omega_wall if wall else c.omega) * c.time_step
    closed = lagged_restitution if integrator == "velocity_verlet" else extrapolated_restitution
    measured = head_on_speeds(kw, 3.0, wall).mean()
    # the closed form follows the complex pair alone; the third root of the thesis' map adds 1 % at 18 steps a contact
    tolerance = 0.015 if integrator == "leapfrog_extrapolated" and f == 0.1 else 0.005
    assert measured == pytest.approx(closed(c.damping_ratio, h), rel=tolerance)


def test_extrapolated_map_has_the_value_of_the_derivation():
    c = handmade_scene([], [], integrator="leapfrog_extrapolated").coefficients
    assert extrapolated_restitution(c.damping_ratio, c.omega * c.time_step) == pytest.approx(0.19875, abs=1e-5)


def test_corrected_damping_gives_the_wanted_restitution():
    kw = dict(restitution=0.2, correct_restitution=True, gravity=(0.0, 0.0))
    assert head_on_speeds(kw, 3.0, False).mean() == pytest.approx(0.2, rel=0.005)  # scatter of the entry phase


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


@pytest.mark.parametrize("pair", [False, True], ids=["wall", "pair"])
def test_gross_sliding_impulse(pair):
    """v_t' = v_t - mu A (1+e) v_n and R w' = 2 mu A (1+e) v_n for a spinning disc, A with the tail."""
    e, mu, vn, vt = 0.6, 0.3, 3.0, 9.0
    kw = dict(restitution=e, friction=mu, rotation=True, time_step_fraction=0.005, gravity=(0.0, 0.0))
    kw["largest_overlap"] = 0.005  # stiff, so that the pair does not turn while it touches
    c = handmade_scene([], [], **kw).coefficients
    kw["tangential_damping"] = 200 * c.omega  # Coulomb throughout; still 2 gamma dt < 2
    if pair:
        positions, velocities, walls = [[0, 0], [0, 1.00001 * D]], [[0, 0], [vt, -vn]], ()
    else:
        positions, velocities, walls = [[0, 0.50001 * D]], [[vt, -vn]], (FLOOR,)
    simulation = NativeSimulation(handmade_scene(positions, velocities, walls, **kw))
    simulation.run(int((1e-5 * D / vn + 1.6 * c.contact_duration) / c.time_step))
    change = mu * friction_impulse_factor(e) * (1 + e) * vn
    if pair:
        relative = simulation.velocities[1] - simulation.velocities[0]
        # the line of centres turns by v_t t_c / d = 0.6 % while they touch
        assert relative[0] == pytest.approx(vt - change, rel=0.01)
        assert simulation.spin == pytest.approx(np.full(2, -change / (D / 2)), rel=0.02)
    else:
        assert simulation.velocities[0, 0] == pytest.approx(vt - change, rel=0.003)  # e is 0.1 % off at f = 0.005
        assert simulation.spin[0] == pytest.approx(-2 * change / (D / 2), rel=0.005)


@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
def test_sliding_disc_comes_to_roll_at_two_thirds_of_its_speed(integrator):
    u0, mu = 2.0, 0.3
    rest = D / 2 - 40 * 9.81 / 2.56e7
    scene = handmade_scene([[0, rest]], [[u0, 0]], (FLOOR,), friction=mu, rotation=True, integrator=integrator)
    simulation = NativeSimulation(scene)
    ts = u0 / (3 * mu * 9.81)
    half = round(0.5 * ts / scene.time_step)
    simulation.run(half)
    t = half * scene.time_step
    assert simulation.velocities[0, 0] == pytest.approx(u0 - mu * 9.81 * t, rel=1e-4)
    assert simulation.spin[0] * D / 2 == pytest.approx(-2 * mu * 9.81 * t, rel=1e-4)
    simulation.run(round(1.5 * ts / scene.time_step))
    assert simulation.velocities[0, 0] == pytest.approx(2 * u0 / 3, rel=1e-3)


@pytest.mark.parametrize("law", ["viscous", "sign"])
def test_disc_without_spin_stops_where_coulomb_says(law):
    u0, mu = 2.0, 0.3
    rest = D / 2 - 40 * 9.81 / 2.56e7
    scene = handmade_scene([[0, rest]], [[u0, 0]], (FLOOR,), friction=mu, friction_law=law)
    simulation = NativeSimulation(scene)
    simulation.run(round(1.2 * u0 / (mu * 9.81) / scene.time_step))
    # alone it is always the fastest disc, so v_t / eps = 100: the sign law saturates until the very end
    assert simulation.positions[0, 0] == pytest.approx(u0**2 / (2 * mu * 9.81), rel=1e-3)


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


def test_counter_rotating_discs_do_not_feel_friction():
    scene = handmade_scene(
        [[0, 0], [1.001 * D, 0]], [[0.1, 0], [-0.1, 0]], friction=0.4, rotation=True, gravity=(0.0, 0.0)
    )
    simulation = NativeSimulation(scene)
    simulation.discs.omega[:2] = [5.0, -5.0]
    simulation.run(400)
    assert simulation.spin == pytest.approx([5.0, -5.0], abs=1e-12)
    assert simulation.velocities[:, 1] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_corner_pushes_along_the_line_to_it():
    """Elastic bounce off a block's corner: the angular momentum about the corner stays, to round-off."""
    block = Block("sill", (-3.0, 0.0), (-3.0, 0.0))
    angle = 0.6
    start = np.array([cos(angle), sin(angle)]) * (D / 2 + 0.002) + np.array([0.004, -0.003])
    velocity = np.array([-2.0, -1.5])
    scene = handmade_scene([start], [velocity], (block,), restitution=1.0, gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    before = start[0] * velocity[1] - start[1] * velocity[0]
    simulation.run(200)
    (x, y), (vx, vy) = simulation.positions[0], simulation.velocities[0]
    assert x * vy - y * vx == pytest.approx(before, abs=1e-12)
    assert vx > 0  # it did bounce
    assert vx**2 + vy**2 == pytest.approx(velocity @ velocity, rel=3e-3)  # e scatters by 0.0012


def test_centre_inside_a_block_feels_nothing():
    scene = handmade_scene([[0, 0]], [[1, 0]], (Block("b", (-1, 1), (-1, 1)),), gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(50)
    assert simulation.velocities[0] == pytest.approx([1.0, 0.0], abs=0)


def test_free_fall_is_exact():
    scene = handmade_scene([[0, 10.0]], [[1.0, 2.0]])
    simulation = NativeSimulation(scene)
    simulation.run(1000)
    t = 1000 * scene.time_step
    assert simulation.positions[0] == pytest.approx([t, 10 + 2 * t - 9.81 * t**2 / 2], abs=1e-12)
    assert simulation.velocities[0] == pytest.approx([1.0, 2 - 9.81 * t], abs=1e-12)


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
