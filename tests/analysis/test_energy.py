# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy and contact sums on discs placed by hand."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import collected, disc_frame, examples, flow_context, numbers

from lammps_jump.analysis.budgets.energy import (
    EnergyLedger,
    analyse_energy,
    drift,
    energy_chart,
    section,
    tables,
    work_of_walls,
)
from lammps_jump.analysis.contacts import ContactCollector, find_contacts, pair_sums, wall_sums
from lammps_jump.analysis.flow import from_scene
from lammps_jump.dump.find import ForceHistory
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.tracks import Oscillate
from lammps_jump.scene.walls import Block, Box, Plane

D, K = 0.2, 1.0e6
BOX = [[-10, 10], [-10, 10]]


context = partial(
    flow_context, domain=((-10.0, 10.0), (-10.0, 10.0)), x_range=(-10.0, 10.0), stiffness=K, stiffness_wall=K,
    restitution=1.0, friction=0.0,
)  # fmt: skip


def frame(x, y, vx=0.0, vy=0.0, step=0, **more):
    return disc_frame(x, y, vx, vy, box=BOX, step=step, time=0.1 * step, **more)


def summed(frames, flow):
    return collected(EnergyLedger(flow), frames)


def test_two_overlapping_discs():
    sums = pair_sums(frame([0, 0.15], [0, 0]), context(), np.linspace(-1, 1, 21))
    assert sums.contacts == 1
    assert sums.energy == pytest.approx(0.5 * K * 0.05**2, rel=1e-12)
    # bins of 0.1 m: one and a half of them lie between the centres
    assert sums.thrust[10:12] == pytest.approx([K * 0.05, 0.5 * K * 0.05], rel=1e-9)
    assert np.delete(sums.thrust, [10, 11]) == pytest.approx(0, abs=1e-9)


def test_dashpot_adds_to_the_thrust():
    meeting = frame([0, 0.15], [0, 0], vx=np.array([1.0, -1.0]))
    sums = pair_sums(meeting, context(dashpot=100.0), np.array([0.0, 0.15]))
    assert sums.thrust[0] == pytest.approx(K * 0.05 + 200.0, rel=1e-12)


def test_smooth_touch_energy_is_the_integral_of_its_force():
    soft = context(touch="smooth", touch_width=0.02)
    for overlap in (0.01, 0.02, 0.05):
        grid = np.linspace(0, overlap, 20001)
        force = np.where(grid < 0.02, K * grid**2 / 0.04, K * (grid - 0.01))
        expected = np.trapezoid(force, grid)
        pair = pair_sums(frame([0, D - overlap], [0, 0]), soft).energy
        wall = wall_sums(frame([0], [D / 2 - overlap]), Plane("floor", "y", 0, "above"), soft)
        assert pair == pytest.approx(expected, rel=1e-6)  # trapezium with 20000 pieces
        assert wall.energy == pytest.approx(expected, rel=1e-6)
        assert wall.force[1] == pytest.approx(force[-1], rel=1e-9)


@pytest.mark.parametrize("scale", [0.6, 3.0, 40.0])
def test_pairs_of_a_cloud_against_all_pairs(scale):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0, scale, (2, 150))
    distance = np.hypot(x[:, None] - x, y[:, None] - y)[np.triu_indices(150, 1)]
    overlap = np.clip(D - distance, 0, None)
    sums = pair_sums(frame(x, y), context())
    assert sums.contacts == int((overlap > 0).sum())
    assert sums.energy == pytest.approx(0.5 * K * float((overlap**2).sum()), rel=1e-10, abs=1e-12)


@examples(40)
@given(seed=st.integers(0, 2**31), count=st.integers(0, 60))
def test_thrust_is_the_virial_and_mirrors(seed, count):
    """Over all bins, thrust times width is the sum of force times branch; mirrored, the bins turn round."""
    rng = np.random.default_rng(seed)
    x, y, vx, vy = rng.uniform(-1, 1, (4, count))
    edges = np.linspace(-2, 2, 17)
    flow = context(dashpot=50.0)
    sums = pair_sums(frame(x, y, vx, vy), flow, edges)
    i, j = np.triu_indices(count, 1)
    branch = np.column_stack([x[j] - x[i], y[j] - y[i]])
    length = np.hypot(*branch.T)
    touch = (length < D) & (length > 0)
    approach = -np.sum((np.column_stack([vx, vy])[j] - np.column_stack([vx, vy])[i]) * branch, axis=1)[touch]
    force = K * (D - length[touch]) + 50.0 * approach / length[touch]
    virial = np.sum(force * branch[touch, 0] ** 2 / length[touch])
    assert sums.thrust.sum() * 0.25 == pytest.approx(virial, rel=1e-9, abs=1e-6)
    turned = pair_sums(frame(-x, y, -vx, vy), flow, edges)
    assert turned.thrust[::-1] == pytest.approx(sums.thrust, rel=1e-9, abs=1e-6)
    assert turned.energy == pytest.approx(sums.energy, rel=1e-12, abs=1e-12)


def test_wall_contacts():
    floor = Plane("floor", "y", 0.0, "above")
    sums = wall_sums(frame([0, 1], [0.09, 0.3], vy=-1.0), floor, context(dashpot_wall=100.0))
    assert list(sums.index) == [0]
    assert sums.force == (0.0, pytest.approx(K * 0.01 + 100.0))
    assert not sums.sideways
    corner = wall_sums(frame([-0.05], [0.05]), Block("step", (0, 1), (-1, 0)), context())
    assert corner.force[0] < 0 < corner.force[1]
    assert corner.sideways
    inside = wall_sums(frame([0.5], [-0.01]), Block("step", (0, 1), (-1, 0)), context())
    assert inside.force == (0.0, pytest.approx(K * 0.11))  # a centre inside a block is pushed out, in the engines too
    assert wall_sums(frame([], []), floor, context()).force == (0.0, 0.0)


@pytest.mark.parametrize(
    ("law", "expected"),
    [("viscous", min(40.0 * 500.0 * 2.0, 0.3 * K * 0.01)), ("sign", 0.3 * K * 0.01)],
)
def test_wall_friction(law, expected):
    rough = context(friction=0.3, gamma_tangential_wall=500.0, friction_law=law)
    sums = wall_sums(frame([0], [0.09], vx=2.0), Plane("floor", "y", 0.0, "above"), rough)
    assert sums.force[0] == pytest.approx(-expected)
    slow = wall_sums(
        frame([0], [0.09], vx=1e-3), Plane("floor", "y", 0.0, "above"), context(friction=0.3, gamma_tangential_wall=5.0)
    )
    assert slow.force[0] == pytest.approx(-40.0 * 5.0 * 1e-3)  # below the slip speed the ramp holds


def test_energy_box_starts_with_5760_joules():
    """Thesis: 16 discs of 0.4 m, one at (6, -6) m/s."""
    grid = 0.25 + 0.5 * np.arange(4)
    x, y = np.repeat(grid, 4), np.tile(grid, 4)
    speed = np.zeros(16)
    speed[0] = 6.0
    box = context(diameter=0.4, mass=160.0, gravity=(0.0, 0.0), walls=(Box("box", (0, 2), (0, 2)),))
    history = summed([frame(x, y, speed, -speed, step=k) for k in range(3)], box)
    assert history.total == pytest.approx(5760.0, rel=1e-14)
    summary = numbers(analyse_energy(history, box))
    assert (summary["initial"], summary["max_deviation"], summary["closed"]) == (5760.0, 0.0, True)
    assert summary["drift"] == pytest.approx(0.0, abs=1e-14)
    assert summary["conservative"]


def test_parts_of_the_energy():
    flow = context(walls=(Plane("floor", "y", 0.0, "above"),))
    history = summed([frame([0.0], [0.08], vx=3.0, omegaz=[5.0])], flow)
    assert history.kinetic[0] == pytest.approx(0.5 * 40 * 9)
    assert history.rotational[0] == pytest.approx(0.25 * 40 * 0.01 * 25)  # I = m R^2 / 2
    assert history.potential[0] == pytest.approx(40 * 9.81 * 0.08)
    assert history.elastic[0] == pytest.approx(0.5 * K * 0.02**2)
    unknown = summed([frame([0.0], [0.08])], context(stiffness=None))
    assert np.isnan(unknown.elastic).all() and np.isfinite(unknown.total).all()


def test_falling_disc_keeps_its_energy():
    times = np.arange(6)
    frames = [frame([0.0], [5 - 0.5 * 9.81 * (0.1 * k) ** 2], vy=-9.81 * 0.1 * k, step=k) for k in times]
    summary = numbers(analyse_energy(summed(frames, context()), context()))
    assert summary["max_deviation"] < 1e-14
    assert summary["initial"] == pytest.approx(40 * 9.81 * 5)


def test_a_disc_that_comes_is_no_drift_of_the_engine():
    summary = numbers(analyse_energy(summed([frame([0], [1]), frame([0, 1], [1, 1], step=1)], context()), context()))
    assert summary["closed"] is False
    assert summary["conservative"] is False


def test_no_frame_and_empty_frame():
    assert numbers(analyse_energy(summed([], context()), context()))["initial"] is None
    summary = numbers(analyse_energy(summed([frame([], [])], context()), context()))
    assert summary["initial"] is summary["max_deviation"] is None and summary["reason"] == "no frame holds a disc"


def test_drift_is_the_straight_line():
    time = np.linspace(0, 10, 11)
    assert drift(time, 100 + 0.5 * time) == pytest.approx(0.05)
    assert np.isnan(drift(time[:1], time[:1]))


def test_ledger_shares_the_collectors_pairs():
    flow = context(walls=(Plane("floor", "y", 0.0, "above"),))
    collector = ContactCollector(flow, np.linspace(-1, 1, 5))
    shared, alone = EnergyLedger(flow, collector), EnergyLedger(flow)
    one = frame([0, 0.15, 0.4], [0.09, 0.1, 0.095])
    for taker in (collector, shared, alone):
        taker.add(one, 0.0)
    assert shared.result().elastic == pytest.approx(alone.result().elastic, rel=1e-14)
    assert collector.result().wall_fx.sum() == 0.0


def test_energy_of_two_unequal_discs():
    """Discs of 0.2 and 0.3 m (40 and 90 kg/m) that overlap by 10 mm, and touch the floor by 20 and 0 mm."""
    columns = {"vx": [1.0, -2.0], "vy": [0.0, 3.0], "omegaz": np.array([4.0, -2.0]), "radius": np.array([0.1, 0.15])}
    two = frame([0.0, np.sqrt(0.24**2 - 0.07**2)], [0.08, 0.15], **columns)
    flow = context(walls=(Plane("floor", "y", 0.0, "above"),), sized=True)
    ledger = EnergyLedger(flow)
    ledger.add(two, 0.0)
    found = ledger.result()
    assert found.kinetic[0] == pytest.approx(0.5 * 40 * 1 + 0.5 * 90 * 13)
    assert found.rotational[0] == pytest.approx(0.25 * 40 * 0.1**2 * 16 + 0.25 * 90 * 0.15**2 * 4)
    assert found.potential[0] == pytest.approx(9.81 * (40 * 0.08 + 90 * 0.15))
    assert found.elastic[0] == pytest.approx(0.5 * K * 0.01**2 + 0.5 * K * 0.02**2)


def test_dashpots_of_unequal_pairs_go_with_the_root_of_the_effective_mass():
    flow = context(dashpot=100.0, dashpot_wall=50.0, walls=(Plane("floor", "y", 0.0, "above"),), sized=True)
    radius = np.array([0.1, 0.2])
    meeting = frame([0.0, 0.29], [1.0, 1.0], vx=np.array([1.0, -1.0]), vy=[0.0, 0.0], radius=radius)
    # 40 and 160 kg: 32 kg, a nominal pair has 20
    expected = K * 0.01 + 100.0 * np.sqrt(32 / 20) * 2.0
    assert find_contacts(meeting, flow).force == pytest.approx([expected])
    # one bin between the centres: the force itself
    assert pair_sums(meeting, flow, np.array([0.0, 0.29])).thrust == pytest.approx([expected])
    falling = frame([0.0], [0.19], vx=[0.0], vy=[-1.0], radius=np.array([0.2]))
    assert wall_sums(falling, flow.scene.permanent[0], flow).force[1] == pytest.approx(K * 0.01 + 50.0 * 2.0)
    apart = frame([0.0, 0.21], [1.0, 1.0], radius=np.array([0.1, 0.1]))
    assert not find_contacts(apart, flow).force.size and pair_sums(apart, flow).contacts == 0


def test_the_work_of_moving_walls_explains_the_energy():
    """A box that is shaken without losses: what the discs gain is the work of its walls, but for the springs' step."""
    places = np.array([[x, y] for x in (-0.8, -0.3, 0.3, 0.8) for y in (-0.8, 0.0, 0.8)])
    scene = handmade_scene(
        places, 0 * places, (), gravity=(0.0, 0.0), friction=0.0, restitution=1.0, impact_speed=8.0, probes=("box",),
        probe_steps=50, steps=4000, time_step_fraction=0.02,
    )  # fmt: skip
    motion = Motion(kind=Oscillate(amplitude=(0.4, 0.1), period=0.3), time_step=scene.time_step)
    scene = replace(scene, walls=(MovingWall(Box("box", (-1.2, 1.2), (-1.2, 1.2)), motion),))
    run, flow = NativeSimulation(scene), from_scene(scene)
    ledger = EnergyLedger(flow)
    for _ in range(9):
        ledger.add(take_frame(run), scene.time(run.step))
        run.run(500)
    rows = np.array([[scene.time(row[0]), *row[2:]] for row in run.forces])
    history = ledger.result()
    work = work_of_walls({"box": ForceHistory(*rows.T)}, flow, history.time)
    assert work_of_walls({}, flow, history.time) is None
    found = analyse_energy(replace(history, work_of_walls=work), flow)
    assert found.conservative is False and found.work_of_walls == work[-1]
    assert work[-1] > 1000.0
    np.testing.assert_allclose(history.total - history.total[0], work, atol=2e-3 * work[-1])
    assert section(found).blocks[0].rows[-1][0].startswith("Work of moving walls")
    assert "work of the walls" in [line.label for line in energy_chart(found).panels[0].lines]
    assert "work_of_walls" in tables(found)["energy.csv"]
