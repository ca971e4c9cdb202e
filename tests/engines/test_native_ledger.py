# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy ledger of the native engine: it closes, and better with a smaller step; the elastic energy fits the force."""

from types import SimpleNamespace

import numpy as np
import pytest

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.ledger import half_work
from lammps_jump.scene.motion import gate
from lammps_jump.scene.scene import InletRow, Outlet, handmade_scene
from lammps_jump.scene.walls import Box, Plane

D = 0.2


def column(f, **kw):
    """A loose column that falls together, collapses and loses discs through an outlet."""
    rng = np.random.default_rng(4)
    grid = np.array([(0.11 + 0.21 * i, 0.11 + 0.21 * j) for j in range(16) for i in range(6)])
    kw = dict(friction=0.2, rotation=True, impact_speed=8.0) | kw
    return handmade_scene(
        grid + rng.uniform(-0.004, 0.004, grid.shape),
        np.zeros_like(grid),
        (Plane("floor", "y", 0.0, "above"), Plane("back", "x", 0.0, "above")),
        time_step_fraction=f,
        outlets=(Outlet("x", 3.0, "above", 50),),
        **kw,
    )


def relative_residual(scene, duration):
    simulation = NativeSimulation(scene)
    simulation.run(round(duration / scene.time_step))
    ledger = simulation.ledger
    return ledger, abs(ledger["residual"]) / ledger["throughput"]


@pytest.mark.parametrize("integrator", ["velocity_verlet", "leapfrog_extrapolated"])
@pytest.mark.parametrize("law", ["viscous", "sign"])
def test_ledger_closes_and_improves_with_the_step(integrator, law):
    errors = {}
    for f in (0.05, 0.0125):
        ledger, errors[f] = relative_residual(column(f, integrator=integrator, friction_law=law), 1.2)
    assert ledger["carried_out"] > 0 and ledger["dissipated_friction"] > 0 and ledger["dissipated_dashpots"] > 0
    assert errors[0.05] < 1e-3  # promised
    # each contact's error is of order f^2 with a random sign: a quarter of the step leaves at most a third of it
    assert errors[0.0125] < errors[0.05] / 3


def test_ledger_with_smooth_touch_closes_better():
    """The kink at first touch makes most of the error: a ramp of v dt takes it away."""
    _, sharp = relative_residual(column(0.1), 1.0)
    dt = column(0.1).time_step
    _, smooth = relative_residual(column(0.1, touch="smooth", touch_width=8.0 * dt), 1.0)
    assert smooth < 0.7 * sharp


def test_books_of_the_inlet_and_of_free_flight_are_exact():
    """Discs that enter, fly and leave untouched: brought in = carried out + present, to round-off."""
    row = InletRow(0.0, 1.0, 5.0, 0.5, 1, 700, 0.999 * D)
    scene = handmade_scene([], [], inlets=(row,), outlets=(Outlet("x", 2.0, "above", 10),), steps=8000)
    simulation = NativeSimulation(scene)
    simulation.run(8000)
    ledger = simulation.ledger
    assert simulation.boundaries.removed > 0
    assert abs(ledger["residual"]) < 1e-9 * ledger["brought_in"]


def test_released_gate_takes_its_elastic_energy():
    """A disc squeezed between wall and gate: half its elastic energy goes with the gate, half becomes motion."""
    shut = gate(Plane("gate", "x", D - 0.02, "below"), 10)
    wall = Plane("wall", "x", 0.0, "above")
    scene = handmade_scene([[D / 2 - 0.01, 0]], [[0, 0]], (wall, shut), gravity=(0.0, 0.0), restitution=1.0)
    simulation = NativeSimulation(scene)
    simulation.run(200)
    ledger = simulation.ledger
    assert ledger["released_by_gates"] == pytest.approx(ledger["initial"] / 2, rel=1e-12)
    assert ledger["kinetic"] == pytest.approx(ledger["initial"] / 2, rel=5e-3)  # entry-phase error of one collision


@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize("touch", ["sharp", "smooth"])
def test_force_is_the_slope_of_the_elastic_energy(touch, wall):
    def state(overlap):
        kw = dict(restitution=1.0, gravity=(0.0, 0.0), touch=touch, touch_width=0.004)
        if wall:
            args = [[D / 2 - overlap, 0]], [[0, 0]], (Plane("w", "x", 0.0, "above"),)
        else:
            args = [[0, 0], [D - overlap, 0]], [[0, 0], [0, 0]], ()
        simulation = NativeSimulation(handmade_scene(*args, **kw))
        return simulation.energy().elastic, abs(simulation.discs.fx[0])

    for overlap in (0.001, 0.0039, 0.0041, 0.015):
        step = 1e-6
        slope = (state(overlap + step)[0] - state(overlap - step)[0]) / (2 * step)
        assert slope == pytest.approx(state(overlap)[1], rel=1e-6)  # central difference of a cubic


def box_16(f, **kw):
    """The thesis' energy box: 16 discs of 0.4 m, one at (6, -6) m/s, 5760 J, no losses."""
    grid = np.array([(0.25 + 0.5 * i, 0.25 + 0.5 * j) for j in range(4) for i in range(4)])
    velocities = np.zeros_like(grid)
    velocities[0] = (6.0, -6.0)
    return handmade_scene(
        grid, velocities, (Box("box", (0, 2), (0, 2)),), diameter=0.4, restitution=1.0, impact_speed=72**0.5,
        gravity=(0.0, 0.0), time_step_fraction=f, domain=((-1, 3), (-1, 3)), **kw,
    )  # fmt: skip


def test_energy_box_keeps_its_energy():
    deviations = {}
    for f in (0.05, 0.0125):
        scene = box_16(f)
        simulation = NativeSimulation(scene)
        assert simulation.energy().total == pytest.approx(5760.0, rel=1e-12)
        worst = 0.0
        for _ in range(40):
            simulation.run(round(0.5 / scene.time_step))
            worst = max(worst, abs(simulation.energy().total / 5760.0 - 1))
        assert simulation.ledger["dissipated_dashpots"] == 0.0
        deviations[f] = worst
    assert deviations[0.05] < 0.03  # promised: below 3 % in 120 s
    assert deviations[0.0125] < 0.003


def test_ledger_can_be_left_out_without_changing_the_run():
    with_books, without = NativeSimulation(column(0.05)), NativeSimulation(column(0.05), ledger=False)
    with_books.run(800)
    without.run(800)
    assert without.ledger is None
    assert np.array_equal(with_books.positions, without.positions)


def test_half_a_step_takes_half_the_work_of_a_dashpot():
    """The dashpots push with (-3, 1) N/m a disc that an equal and opposite force keeps at (2, 0.5) m/s."""
    scene = handmade_scene(np.zeros((0, 2)), np.zeros((0, 2)), (Plane("floor", "y", 0.0, "above"),))
    zero = np.zeros(1)
    discs = SimpleNamespace(
        n=1, radius=None, omega=None, friction_x=None, fx=zero, fy=zero, vx=zero + 2.0, vy=zero + 0.5,
        dashpot_x=zero - 3.0, dashpot_y=zero + 1.0,
    )  # fmt: skip
    work = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.4])  # moving walls did 0.4 J/m in this step
    np.testing.assert_allclose(half_work(scene, discs, work), [5.5 * 0.5 * scene.time_step, 0.0, -0.2], rtol=1e-14)
