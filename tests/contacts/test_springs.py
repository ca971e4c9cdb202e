# SPDX-License-Identifier: GPL-2.0-or-later
"""Springs with memory against closed forms, on all engines; one disc, with d, m and g = 1."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from single_disc import R, one_disc

from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Block, Motion, MovingWall, Plane, handmade_scene
from lammps_jump.scene.tracks import Rotate
from lammps_jump.scene.walls import Circle

NATIVE, LAMMPS = "native_verlet", (pytest.param(name, marks=pytest.mark.lammps) for name in ("compiled", "stock"))
COMPILED, STOCK = LAMMPS
ENGINES = [NATIVE, COMPILED, STOCK]
WITHOUT_SPIN = [pytest.param(NATIVE, marks=pytest.mark.long), COMPILED, STOCK]
"""The native engine has the law without spin in the default run from `test_hosts.py`."""
FLOOR = Plane("floor", "y", 0.0, "above")
RATIO = 2.0 / 7.0


@pytest.fixture
def started(rig, tmp_path):
    """A function that starts a scene on an engine."""
    running = []

    def start(engine, scene, spins=()):
        running.append(rig.start(engine, scene, list(spins), tmp_path))
        return running[-1]

    yield start
    for engine in running:
        engine.close()


def disc(place, velocity, walls=(FLOOR,), *, springs=None, **more):
    """One disc, with springs."""
    given = {"friction": 0.5, "rotation": True, "friction_law": "history", "springs": springs or Springs()}
    return one_disc(place, velocity, walls=tuple(walls), **(given | more))


def steps_of(scene, time):
    return round(time / scene.time_step)


BARE = Springs(RATIO, 0.0)
SLOW = 0.003
"""Speed at which a contact turns by less than a thousandth of a diameter."""


def rebound(spin):
    """What is left of slip, and the energy that is lost over that of slip, after a collision without damping.

    Tangential motion is an oscillation of the frequency sqrt(S kt/k) of the normal one, S = 3 with spin (a disc), else
    1; the collision ends after half a period of the normal one.
    """
    share = 3.0 if spin else 1.0
    phase = pi * sqrt(share * RATIO)
    return (cos(phase) - 1.0) / share, sin(phase) ** 2 / share


def hits_a_wall(started, engine, spin):
    """One disc against a wall, at 45 degrees."""
    zero = {"gravity": (0.0, 0.0), "friction": 1e3}
    scene = disc((0.0, R), (SLOW, -SLOW), rotation=spin, springs=BARE, fraction=0.005, **zero)
    run = started(engine, scene)
    run.run(steps_of(scene, 1.3 * pi / sqrt(scene.coefficients.stiffness_wall)))
    gained, lost = rebound(spin)
    ((u, v),) = run.velocities
    assert v == pytest.approx(SLOW, rel=1e-3)
    assert u / SLOW - 1.0 == pytest.approx(gained, abs=3e-3)  # 1.8e-3 without spin, less with: f = 0.005
    turning = 0.25 * (R * run.spin[0]) ** 2 if spin else 0.0
    energy = 0.5 * (u * u + v * v) + turning
    assert energy / SLOW**2 == pytest.approx(1.0 - 0.5 * lost, abs=2e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_oblique_impact_on_a_wall(started, engine):
    hits_a_wall(started, engine, True)


@pytest.mark.parametrize("engine", WITHOUT_SPIN)
def test_oblique_impact_without_spin(started, engine):
    hits_a_wall(started, engine, False)


@pytest.mark.parametrize("engine", ENGINES)
def test_oblique_impact_of_two_discs(started, engine):
    """Each gets half of what is left of slip, and the same spin: m_eff = m/2."""
    scene = handmade_scene(
        [(0.0, 0.0), (1.0, 0.0)], [(SLOW, SLOW), (0.0, 0.0)], diameter=1.0, density=1.0, impact_speed=1.0,
        restitution=1.0, friction=1e3, friction_law="history", springs=BARE, rotation=True, gravity=(0.0, 0.0),
        time_step_fraction=0.002, steps=10**8, output_steps=10**7, skin=0.3,
    )  # fmt: skip
    run = started(engine, scene)
    run.run(steps_of(scene, 1.3 * pi / scene.coefficients.omega))
    gained = rebound(True)[0]
    (_, one), (_, other) = run.velocities
    assert (one / SLOW - 1.0, other / SLOW) == pytest.approx((0.5 * gained, -0.5 * gained), abs=5e-4)
    assert run.spin[0] == pytest.approx(run.spin[1], rel=1e-9)


@pytest.mark.parametrize("engine", ENGINES)
def test_from_sliding_to_rolling(started, engine):
    """u = u0 - mu g t until R w = u = 2/3 u0."""
    friction = 0.3
    scene = disc((0.0, R - 0.01), (1.0, 0.0), friction=friction, restitution=0.5)
    run = started(engine, scene)
    half, end = steps_of(scene, 0.5 / (3 * friction)), steps_of(scene, 3.0)
    run.run(half)
    # LAMMPS' springs give no force before the first step: half a kick
    late = 0.5 * friction * scene.time_step if engine == "stock" else 0.0
    assert run.velocities[0, 0] == pytest.approx(1.0 - friction * half * scene.time_step + late, rel=1e-3)
    run.run(end - half)
    assert run.velocities[0, 0] == pytest.approx(2 / 3, rel=1e-3)
    assert -R * run.spin[0] == pytest.approx(2 / 3, rel=1e-3)


TILT = radians(20.0)
SLOPES = {
    "gravity": ((0.0, R), (FLOOR,), (sin(TILT), -cos(TILT)), 0.0),
    "block": ((R * sin(TILT), R * cos(TILT)), (Block("b", (-4, 4), (-1, 0), angle=-20.0, pivot=(0.0, 0.0)),),
              (0.0, -1.0), TILT),
}  # fmt: skip


@pytest.mark.parametrize("engine", WITHOUT_SPIN)
@pytest.mark.parametrize("slope", SLOPES)
def test_rest_on_a_slope_for_a_hundred_seconds(started, engine, slope):
    """Only the spring stretches, by m g sin/kt."""
    place, walls, gravity, turned = SLOPES[slope]
    scene = disc(place, (0.0, 0.0), walls, rotation=False, gravity=gravity, restitution=0.2, fraction=0.1)
    run = started(engine, scene)
    run.run(steps_of(scene, 100.0))
    (moved,) = run.positions - place
    stretch = sin(TILT) / (RATIO * scene.coefficients.stiffness_wall)
    along = np.array([cos(turned), -sin(turned)])
    assert moved @ along == pytest.approx(stretch, abs=1e-6)
    assert np.abs(run.velocities).max() < 1e-12


STIFF = {"largest_overlap": 0.01}
"""The spring against rolling stretches by mur m g/kr: small against the way."""


@pytest.mark.parametrize("engine", ENGINES)
def test_rolling_stops(started, engine):
    """A disc that rolls loses mur g a second of 3/2 of its momentum: x = 3 u0^2/(4 mur g)."""
    speed, friction = 0.3, 0.1
    springs = Springs(rolling=Rolling(friction, 1.0, 1.0))
    scene = disc((0.0, R - 1e-4), (speed, 0.0), springs=springs, restitution=0.5, fraction=0.05, **STIFF)
    run = started(engine, scene, [-speed / R])
    run.run(steps_of(scene, 1.2 * 1.5 * speed / friction))
    assert run.positions[0, 0] == pytest.approx(3 * speed**2 / (4 * friction), rel=1e-3)
    assert abs(run.velocities[0, 0]) < 1e-6


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("angle", "rolls"), [(2.8, False), (2.9, True)])
def test_rolling_begins_at_the_angle_of_rolling_friction(started, engine, angle, rolls):
    slope = radians(angle)
    assert (tan(slope) > 0.05) == rolls
    springs = Springs(rolling=Rolling(0.05, 1.0, 1.0))
    gravity = (sin(slope), -cos(slope))
    scene = disc((0.0, R - 1e-4), (0.0, 0.0), springs=springs, restitution=0.2, gravity=gravity, fraction=0.1, **STIFF)
    run = started(engine, scene)
    run.run(steps_of(scene, 10.0))
    speed = 2 / 3 * (sin(slope) - 0.05 * cos(slope)) * 10.0
    # until the spring is stretched, pi/2 sqrt(3 m/2 kr) at most, nothing holds the disc
    assert run.velocities[0, 0] == pytest.approx(speed if rolls else 0.0, abs=2 / 3 * sin(slope) * 0.02)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_disc_turns_with_its_drum(started, engine):
    """Pressed to a drum that turns, it stays where it is on it: contacts turn with their wall."""
    rate, radius = 0.1, 3.0
    inner = (radius - R) / (1.0 - rate**2 / 1e4)  # pressed in as far as carries it
    drum = Circle("drum", (0.0, 0.0), radius, discs="inside")
    walls = (MovingWall(drum, Motion(kind=Rotate(rate=np.degrees(rate)), about=(0.0, 0.0), ease=0.0, time_step=1.0)),)
    still = disc((inner, 0.0), (0.0, rate * inner), (drum,), gravity=(0.0, 0.0), restitution=0.2, fraction=0.2, **STIFF)
    motion = replace(walls[0].motion, time_step=still.time_step)
    scene = replace(still, walls=(MovingWall(drum, motion),))
    run = started(engine, scene, [rate])
    steps = steps_of(scene, 2 * pi / rate)
    run.run(steps)
    turned = rate * steps * scene.time_step - 2 * pi
    ((x, y),) = run.positions
    assert np.arctan2(y, x) == pytest.approx(turned, abs=1e-5)
