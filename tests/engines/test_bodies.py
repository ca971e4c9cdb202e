# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies on the native engine, against closed forms; the twin does the same."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
from free_bodies import DENSITY, body, crowd, scene_of, state_of

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.engines.twin import Twin
from lammps_jump.errors import RunError
from lammps_jump.physics.bodies import effective_mass, pendulum_period, section_of_circle, section_of_polygon
from lammps_jump.physics.slip import Springs
from lammps_jump.scene.walls import Block, Box, Circle, Plane, Polygon

G = 9.81
SPRINGS = Springs(2 / 7, 1.0)
FLOOR = Plane("floor", "y", 0.0, "above")
NOTHING = {"gravity": (0.0, 0.0)}


def flat(section):
    area, centre, moment = section
    return [area, *centre, moment]


@pytest.mark.parametrize("way", [1, -1])
def test_sections_of_outlines(way):
    square = np.array([(1.0, 2.0), (4.0, 2.0), (4.0, 4.0), (1.0, 4.0)])[::way]
    assert flat(section_of_polygon(square)) == pytest.approx([6.0, 2.5, 3.0, 6.0 * (9 + 4) / 12])
    triangle = np.array([(100.0, 0.0), (103.0, 0.0), (100.0, 3.0)])[::way]
    # a right angle between a and b: M (a^2 + b^2)/18 about the centre
    assert flat(section_of_polygon(triangle)) == pytest.approx([4.5, 101.0, 1.0, 4.5 * (3**2 + 3**2) / 18])
    many = 2 * pi * np.arange(2000) / 2000
    found = section_of_polygon(np.column_stack([2 + 3 * np.cos(many), 1 + 3 * np.sin(many)]))
    assert flat(found) == pytest.approx(flat(section_of_circle((2.0, 1.0), 3.0)), rel=1e-5)


@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
def test_a_throw_is_a_parabola_with_steady_spin(integrator):
    thrown = body(Polygon("stone", ((3.0, 8.0), (4.0, 8.2), (3.6, 9.0))), velocity=(1.0, 2.0), spin=3.0)
    simulation = NativeSimulation(scene_of(thrown, integrator=integrator))
    simulation.run(3000)
    found, t = state_of(simulation, "stone"), simulation.scene.time(3000)
    assert found.pose == pytest.approx([t, 2 * t - 0.5 * G * t * t, 3 * t], abs=1e-12)
    assert found.velocity == pytest.approx([1.0, 2 - G * t, 3.0], abs=1e-11)
    assert simulation.ledger["residual"] == pytest.approx(0.0, abs=1e-12 * simulation.ledger["throughput"])


def test_a_body_is_held_until_it_is_released_and_moves_along_its_axes_alone():
    begin = 0.02
    held = body(Block("held", (0.0, 1.0), (5.0, 6.0)), begin=begin, velocity=(1.0, 0.0))
    slide = body(Block("slide", (3.0, 4.0), (5.0, 6.0)), axes=(True, False, False), velocity=(2.0, 0.0))
    simulation = NativeSimulation(scene_of(held, slide))
    steps = int(begin / simulation.scene.time_step)
    simulation.run(steps)
    assert not state_of(simulation, "held").pose.any() and not state_of(simulation, "held").velocity.any()
    simulation.run(1000)
    first = steps * simulation.scene.time_step  # the step before the release has the first half of the kick
    t = simulation.scene.time(simulation.step)
    assert state_of(simulation, "held").pose == pytest.approx([t - first, -0.5 * G * (t - first) ** 2, 0.0], abs=1e-12)
    assert state_of(simulation, "slide").pose == pytest.approx([2 * t, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    ("friction", "law"), [(0.2, {"friction_law": "viscous"}), (0.2, {"friction_law": "history", "springs": SPRINGS}),
                          (0.5, {"friction_law": "history", "springs": SPRINGS})],
)  # fmt: skip
def test_a_block_on_a_slope_slides_or_rests(friction, law):
    slope = radians(20.0)
    gravity = G * sin(slope), -G * cos(slope)
    block = body(Block("block", (0.0, 2.0), (0.0, 1.0)), gravity)
    simulation = NativeSimulation(scene_of(FLOOR, block, friction=friction, gravity=(0.0, 0.0), **law))
    half = round(0.7 / simulation.scene.time_step)
    simulation.run(half)
    before = state_of(simulation, "block")
    simulation.run(half)
    found = state_of(simulation, "block")
    if friction < 0.3:
        rate = (found.velocity[0] - before.velocity[0]) / (half * simulation.scene.time_step)
        assert rate == pytest.approx(G * (sin(slope) - friction * cos(slope)), rel=5e-3)
    else:
        assert abs(found.pose - before.pose).max() < 1e-6 and found.pose[0] < 1e-3
    weight = 2000.0 * G * cos(slope)
    assert simulation.walls.moves.pushed[1, 10] == pytest.approx(weight, rel=1e-3)


def test_a_pendulum_has_its_period():
    amplitude = radians(5.0)
    bar = body(Block("bar", (-0.1, 0.1), (-1.2, 0.0), angle=5.0, pivot=(0.0, -0.1)), hinge=(0.0, -0.1))
    free, rows = bar.motion.free, []
    simulation = NativeSimulation(scene_of(bar, time_step_fraction=0.2, **NOTHING))
    while simulation.scene.time(simulation.step) < 3.6:
        simulation.run(20)
        rows.append((simulation.scene.time(simulation.step), state_of(simulation, "bar").pose[2] + amplitude))
    time, angle = np.array(rows).T
    at = np.flatnonzero((angle[:-1] > 0) != (angle[1:] > 0))
    zeros = time[at] - angle[at] * (time[at + 1] - time[at]) / (angle[at + 1] - angle[at])
    arm = np.hypot(*free.arm)
    period = pendulum_period(free.mass, free.inertia_there, arm, G, amplitude)
    assert zeros[2] - zeros[0] == pytest.approx(period, rel=1e-5)
    assert abs(angle).max() == pytest.approx(amplitude, rel=1e-5)


@pytest.mark.parametrize("spin", [False, True])
def test_a_disc_meets_a_body_at_rest_off_its_centre(spin):
    block = body(Block("block", (0.0, 1.0), (0.0, 2.0)), (0.0, 0.0))
    law = {"friction": 0.3, "rotation": True, "friction_law": "history", "springs": SPRINGS} if spin else {}
    velocity = (2.0, 0.5 if spin else 0.0)
    scene = scene_of(
        block,
        positions=[(-0.12, 1.7)],
        velocities=[velocity],
        restitution=1.0,
        time_step_fraction=0.01,
        **NOTHING,
        **law,
    )
    simulation = NativeSimulation(scene)
    simulation.run(round(0.04 / scene.time_step))
    free, mass, arm = block.motion.free, scene.mass, 0.7
    found, (vx, vy), (x, y) = state_of(simulation, "block"), simulation.velocities[0], simulation.positions[0]
    turning = 0.5 * mass * scene.radius**2 * float(simulation.spin[0])
    start = mass * np.array([*velocity, -0.12 * velocity[1] - 1.7 * velocity[0]])
    end = found.momentum + np.array([mass * vx, mass * vy, mass * (x * vy - y * vx) + turning])
    assert end == pytest.approx(start, abs=1e-12 * abs(start).max())
    if not spin:
        impulse = 2.0 * effective_mass(1 / mass, 1 / free.mass, arm**2 / free.inertia) * velocity[0]
        assert velocity[0] - vx == pytest.approx(impulse / mass, rel=1e-3)
        energy = found.kinetic + 0.5 * mass * (vx**2 + vy**2)
        assert energy == pytest.approx(0.5 * mass * velocity[0] ** 2, rel=1e-4)


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_a_corner_meets_a_face_of_another_body(restitution):
    """The corner's rim moves along the face while they touch: its arm changes by some thousandths."""
    tilted = Block("tilted", (0.0, 1.0), (0.0, 1.0), angle=30.0)
    lowest = min(y for _, y in tilted.corners())
    one, two = (
        body(tilted, (0.0, 0.0), velocity=(0.0, -1.0)),
        body(Block("slab", (-3.0, 4.0), (-3.0, lowest - 0.03)), (0.0, 0.0)),
    )
    # at f = 0.05 the first and last steps of a contact alone are 0.2 % of what is lost
    law = {"restitution": restitution, "correct_restitution": True, "time_step_fraction": 0.004}
    simulation = NativeSimulation(scene_of(one, two, **NOTHING, **law))
    simulation.run(round(0.07 / simulation.scene.time_step))
    corner = min(simulation.walls.bodies.corner[:4], key=lambda one: one["y"])
    free, slab = one.motion.free, two.motion.free
    parts = 1 / free.mass, 1 / slab.mass, *((corner["x"] - b.centre[0]) ** 2 / b.inertia for b in (free, slab))
    impulse = (1 + restitution) * effective_mass(*parts)
    found, other = state_of(simulation, "tilted"), state_of(simulation, "slab")
    assert free.mass * (found.velocity[1] + 1.0) == pytest.approx(impulse, rel=5e-3)
    before = np.array([0.0, -free.mass, -free.mass * free.centre[0]])
    assert found.momentum + other.momentum == pytest.approx(before, abs=1e-11 * free.mass)
    lost = 0.5 * effective_mass(*parts) * (1 - restitution**2)
    assert found.kinetic + other.kinetic == pytest.approx(0.5 * free.mass - lost, rel=1e-3)


def test_corner_on_corner_gains_no_energy():
    one = body(Block("one", (0.0, 1.0), (0.0, 1.0), angle=45.0), (0.0, 0.0), velocity=(0.0, -2.0), spin=1.0)
    two = body(Block("two", (0.03, 1.03), (-1.5, -0.5), angle=45.0), (0.0, 0.0))
    simulation = NativeSimulation(scene_of(one, two, restitution=1.0, time_step_fraction=0.01, **NOTHING))
    start, touched = simulation.energy().total, False
    for _ in range(60):
        simulation.run(100)
        touched |= simulation.energy().elastic > 0
        assert simulation.energy().total == pytest.approx(start, rel=2e-4)
    assert touched


FAST = {"time_step_fraction": 0.1, "probe_steps": 100_000}
LAWS = {
    "frictionless": {"friction": 0.0},
    "viscous": {"friction": 0.3, "rotation": True},
    "sign": {"friction": 0.3, "friction_law": "sign", "integrator": "leapfrog_extrapolated"},
    "history": {"friction": 0.4, "friction_law": "history", "rotation": True, "springs": SPRINGS},
    "smooth": {"friction": 0.3, "touch": "smooth", "touch_width": 1e-3},
}


def crowded(**law):
    """Bodies of every shape among walls and discs."""
    rows = (np.arange(0.1, 1.0, 0.21), 0.92), (np.arange(1.3, 2.2, 0.21), 1.55), (np.arange(2.5, 3.5, 0.21), 1.75)
    places = np.array([*((x, y) for xs, y in rows for x in xs), (4.08, 1.2), (4.08, 1.5)])
    speeds = np.random.default_rng(3).normal([0.0, -5.0], 1.0, places.shape)
    return scene_of(*crowd(), positions=places, velocities=speeds, restitution=0.4, overlap_limit=0.0, **(FAST | law))


@pytest.mark.parametrize(
    "law",
    ["viscous", "history", *(pytest.param(law, marks=pytest.mark.long) for law in ("frictionless", "sign", "smooth"))],
)
def test_the_twin_does_the_same(law):
    scene = crowded(**LAWS[law])
    core, twin = NativeSimulation(scene), NativeSimulation(scene, loops=Twin())
    for simulation in (core, twin):
        simulation.run(350)
    moves, own = core.walls.moves, twin.walls.moves
    assert core.walls.sums[:, :2].any(axis=1)[[0, 1, 4, 5, 6, 9]].all()  # walls by bodies, bodies by discs
    close = {"abs": 1e-9}
    assert core.positions == pytest.approx(twin.positions, **close)
    assert moves.pushed[:, :9] == pytest.approx(own.pushed[:, :9], **close)
    assert moves.pushed[:, 9:] == pytest.approx(own.pushed[:, 9:], rel=1e-6, abs=1e-2)
    assert core.walls.sums == pytest.approx(twin.walls.sums, rel=1e-6, abs=1e-2)
    throughput = core.ledger["throughput"]
    for name, value in core.ledger.items():
        assert value == pytest.approx(twin.ledger[name], abs=1e-9 * throughput), name
    assert abs(core.ledger["residual"]) < 2e-3 * throughput


def test_a_run_goes_on_bit_for_bit(tmp_path):
    scene = crowded(**LAWS["history"])
    whole, part = NativeSimulation(scene), NativeSimulation(scene)
    part.run(400)
    save_state(part, tmp_path / "state.npz")
    again = load_state(scene, tmp_path / "state.npz")
    for simulation in (whole, again):
        simulation.run(900 - simulation.step)
    assert np.array_equal(whole.walls.moves.pushed, again.walls.moves.pushed)
    assert np.array_equal(whole.positions, again.positions)
    assert np.array_equal(whole.walls.bodies.discs.spring, again.walls.bodies.discs.spring)


def test_a_body_that_leaves_the_domain_or_is_too_heavy_for_its_contact_ends_the_run():
    gone = scene_of(body(Block("stone", (0.0, 1.0), (0.0, 1.0))), domain=((-99, 99), (-0.2, 99)))
    with pytest.raises(RunError, match=r"body 'stone' has left the domain at .*widen domain"):
        NativeSimulation(gone).run(10_000)
    fast = scene_of(FLOOR, body(Block("stone", (0.0, 1.0), (0.0, 1.0)), velocity=(0.0, -60.0)))
    with pytest.raises(RunError, match=r"'stone' and 'floor' overlap by .*stiffness of its own"):
        NativeSimulation(fast).run(10_000)


def heaped(seed: int, count: int, **law):
    """Bodies of random shapes and places in a box above discs that lie there: a scene whose energy can only fall."""
    rng = np.random.default_rng(seed)
    spots = [(x, y) for y in np.arange(1.6, 9.0, 1.3) for x in np.arange(-3.2, 3.3, 1.3)]
    chosen = rng.permutation(len(spots))[:count]
    bodies = []
    for number, (x, y) in enumerate(np.array(spots)[chosen] + rng.uniform(-0.05, 0.05, (count, 2))):
        name, size = f"b{number}", rng.uniform(0.25, 0.55)
        speed = {"velocity": tuple(rng.uniform(-2, 2, 2)), "spin": rng.uniform(-4, 4)}
        if number % 3 == 0:
            wall = Circle(name, (x, y), size)
        elif number % 3 == 1:
            wide = rng.uniform(0.5, 1.0) * size
            wall = Block(name, (x - wide, x + wide), (y - 0.6 * size, y + 0.6 * size), angle=rng.uniform(0, 45))
        else:
            turns = 2 * pi * (np.arange(5) + rng.uniform(-0.3, 0.3, 5)) / 5
            wall = Polygon(name, tuple((x + size * cos(a), y + size * sin(a)) for a in turns))
        bodies.append(body(wall, density=rng.uniform(500.0, 3000.0), corner_radius=0.1, **speed))
    bed = [(x, y) for y in np.arange(0.1, 0.9, 0.2) for x in np.arange(-3.9, 4.0, 0.2)]
    places = np.array(bed) + rng.uniform(-0.005, 0.005, (len(bed), 2))
    fields = {
        "impact_speed": 40.0,
        "largest_overlap": 0.1,
        "overlap_limit": 0.15,
        "probe_steps": 100_000,
        "restitution": 0.4,
    }
    return scene_of(Box("box", (-4.0, 4.0), (0.0, 12.0)), *bodies, positions=places, **(fields | law))


RANDOM_LAWS = (
    {"friction": 0.4, "friction_law": "history", "rotation": True, "springs": SPRINGS},
    {"friction": 0.3, "rotation": True},
    {"friction": 0.0},
    {"friction": 0.3, "friction_law": "sign", "integrator": "leapfrog_extrapolated"},
)


def run_heap(seed: int, steps: int, tmp_path) -> None:
    """No body is lost, no energy gained, and a run that was stopped goes on bit for bit."""
    scene = heaped(seed, 5 + seed % 11, **RANDOM_LAWS[seed % 4])
    simulation = NativeSimulation(scene)
    start = simulation.energy()
    scale = start.total
    lowest = start.total
    for part in range(10):
        simulation.run(steps // 10)
        now = simulation.energy().total
        assert now < lowest + 2e-3 * scale, part
        lowest = min(lowest, now)
        if part == 4:
            save_state(simulation, tmp_path / "state.npz")
    assert abs(simulation.ledger["residual"]) < 5e-3 * simulation.ledger["throughput"]
    for wall, _ in scene.bodies:
        x, y = simulation.walls.centre_of(simulation.walls.names.index(wall.name))
        assert -4.0 < x < 4.0 and 0.0 < y < 12.0
    again = load_state(scene, tmp_path / "state.npz")
    again.run(simulation.step - again.step)
    assert np.array_equal(simulation.walls.moves.pushed, again.walls.moves.pushed)
    assert np.array_equal(simulation.positions, again.positions)


def test_random_bodies_among_discs_lose_energy_alone(tmp_path):
    run_heap(0, 3000, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_twenty_random_scenes_of_bodies(seed, tmp_path):
    run_heap(seed, 40_000, tmp_path)


def test_a_moving_frame_changes_nothing():
    """Discs and bodies without walls and weight, seen from a frame that passes at 3 m/s."""
    boost = np.array([3.0, -1.0])
    positions, states = [], []
    for frame in (0.0, 1.0):
        speed = tuple((np.array([0.0, -2.0]) + frame * boost).tolist())
        walls = (
            body(Block("a", (0.0, 1.0), (0.0, 0.6)), (0.0, 0.0), velocity=tuple((frame * boost).tolist()), spin=1.0),
            body(Polygon("b", ((0.2, 0.65), (1.2, 0.7), (0.7, 1.4))), (0.0, 0.0), velocity=speed),
        )
        places = [(0.1, 0.75), (1.3, 0.8), (-0.15, 0.3)]
        velocities = np.array([(0.0, -4.0), (-3.0, -3.0), (4.0, 0.0)]) + frame * boost
        law = {"friction": 0.4, "friction_law": "history", "rotation": True, "springs": SPRINGS, "restitution": 0.5}
        simulation = NativeSimulation(scene_of(*walls, positions=places, velocities=velocities, **NOTHING, **law))
        simulation.run(1000)
        way = frame * boost * simulation.scene.time(1000)
        positions.append(simulation.positions - way)
        states.append(np.concatenate([state_of(simulation, name).pose - [*way, 0.0] for name in "ab"]))
    assert np.abs(positions[0] - positions[1]).max() < 1e-10
    assert np.abs(states[0] - states[1]).max() < 1e-10 and abs(states[0]).max() > 0.02


@pytest.mark.parametrize(
    ("size", "friction", "share", "found"),
    [
        # a sudden push; at rest it tips from 0.23 on, (b/2 - r)/(h/2): the corner rolls on its rounding r
        ((0.5, 2.0), 0.5, 0.17, "rests"),
        ((0.5, 2.0), 0.5, 0.25, "tips"),
        ((2.0, 1.0), 0.3, 0.29, "rests"),
        ((2.0, 1.0), 0.3, 0.31, "slides"),
    ],
)
def test_a_block_that_is_pushed_slides_or_tips_first_where_it_should(size, friction, share, found):
    weight = DENSITY * size[0] * size[1] * G
    block = body(Block("block", (0.0, size[0]), (0.0, size[1])), corner_radius=0.02, weight=(share * weight, -weight))
    law = {"friction": friction, "friction_law": "history", "springs": SPRINGS, **FAST}
    simulation = NativeSimulation(scene_of(FLOOR, block, **NOTHING, **law))
    simulation.run(round(1.0 / simulation.scene.time_step))
    x, _, angle = state_of(simulation, "block").pose
    assert {
        "rests": abs(x) < 0.01 and abs(angle) < 0.005,
        "tips": angle < -0.01,
        "slides": x > 0.01 and abs(angle) < 0.005,
    }[found], (x, angle)


def tower(seconds: float):
    """Three blocks on each other, after some seconds."""
    blocks = [body(Block(f"b{k}", (0.0, 1.0), (0.8 * k, 0.8 * k + 0.8))) for k in range(3)]
    law = {
        "friction": 0.5,
        "friction_law": "history",
        "springs": SPRINGS,
        "time_step_fraction": 0.1,
        "probe_steps": 100_000,
    }
    simulation = NativeSimulation(scene_of(FLOOR, *blocks, **NOTHING, **law))
    settled = round(0.5 / simulation.scene.time_step)
    simulation.run(settled)
    before = [state_of(simulation, f"b{k}").pose for k in range(3)]
    simulation.run(round(seconds / simulation.scene.time_step) - settled)
    return np.abs(np.array(before) - [state_of(simulation, f"b{k}").pose for k in range(3)])


def test_a_tower_rests():
    assert tower(1.0).max() < 1e-6


@pytest.mark.long
def test_a_tower_rests_for_twenty_seconds():
    assert tower(20.0).max() < 1e-6
