# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs that come and go, gates, probes and guards of the native engine."""

import dataclasses
import signal
from math import floor

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.engines import interrupts
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.engines.native.events import OpenBoundaries, PourState
from lammps_jump.engines.native.simulation import CellSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.errors import CaseError, RunError
from lammps_jump.physics.inlet import Hydrograph, entries_of_rows
from lammps_jump.scene.motion import Motion, MovingWall, Pose, gate
from lammps_jump.scene.scene import InletRow, Outlet, Pour, Scene, handmade_scene
from lammps_jump.scene.tracks import Loaded
from lammps_jump.scene.walls import Block, Box, Plane

D = 0.2
FLOOR = Plane("floor", "y", 0.0, "above")
EMPTY = np.zeros((0, 2))


def test_free_inlet_counts_are_exact():
    rows = tuple(InletRow(0.0, (i + 0.5) * D, 10.0 + i, 0.0, 1 + i, 230 - 10 * i, 0.999 * D) for i in range(3))
    scene = handmade_scene(EMPTY, EMPTY, (FLOOR,), inlets=rows, friction=0.1)
    simulation = NativeSimulation(scene)
    simulation.run(2000)
    expected = sum(floor((2000 - r.first_step) / r.every_steps) + 1 for r in rows)
    assert simulation.boundaries.inserted == expected == simulation.discs.n
    assert np.array_equal(simulation.ids, np.arange(1, expected + 1))


def test_row_spacing_is_the_turn_times_the_speed():
    row = InletRow(0.0, 1.0, 12.0, 0.0, 1, 200, 0.999 * D)
    scene = handmade_scene(EMPTY, EMPTY, inlets=(row,), gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(1001)
    assert -np.diff(simulation.positions[:, 0]) == pytest.approx(np.full(5, 200 * 12.0 * scene.time_step), rel=1e-12)


def test_occupied_inlet_refuses_and_tries_again():
    row = InletRow(0.0, 0.0, 10.0, 0.0, 1, 10, 0.999 * D)
    scene = handmade_scene([[0.05, 0.0]], [[0.0, 0.0]], inlets=(row,), gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(500)
    assert simulation.boundaries.inserted == 1
    moving = handmade_scene([[0.05, 0.0]], [[10.0, 0.0]], inlets=(row,), gravity=(0.0, 0.0))
    simulation = NativeSimulation(moving)
    turns = int((0.999 * D - 0.05) / (10.0 * moving.time_step) / 10) + 1  # first turn after the way is clear
    simulation.run(turns * 10)
    assert simulation.boundaries.inserted == 1
    simulation.run(10)
    assert simulation.boundaries.inserted == 2


def test_inlet_limit():
    row = InletRow(0.0, 0.0, 10.0, 0.0, 1, 250, 0.999 * D, limit=3)
    simulation = NativeSimulation(handmade_scene(EMPTY, EMPTY, inlets=(row,), gravity=(0.0, 0.0)))
    simulation.run(3000)
    assert simulation.boundaries.inserted == 3


def channel(**kw):
    """Two rows onto a floor with a sill, free outfall: contacts at the inlet, the sill, and discs that leave."""
    rows = tuple(InletRow(0.0, (i + 0.5) * D, 8.0, 0.0, 1, 100, 0.999 * D) for i in range(3))
    walls = (Block("floor", (-2.0, 3.0), (-2.0, 0.0)), Block("sill", (2.0, 2.4), (-2.0, 0.3)))
    outlets = (Outlet("x", 6.0, "above", 50), Outlet("y", -2.5, "below", 50), Outlet("x", -0.5, "below", 50))
    kw = dict(steps=9000, output_steps=1000, probes=("sill",), probe_steps=100, friction=0.1) | kw
    return handmade_scene(EMPTY, EMPTY, walls, inlets=rows, outlets=outlets, **kw)


@pytest.mark.parametrize("cell_size", [None, 2 * D], ids=["lists", "cells"])
def test_discs_balance(cell_size):
    result = run_native(channel(), None, cell_size=cell_size)
    assert result.status == "complete"
    assert result.removed > 0 and result.present > 0
    assert result.inserted == result.present + result.removed
    assert result.lost == 0
    assert result.ledger["residual"] == pytest.approx(0.0, abs=1e-3 * result.ledger["throughput"])  # promised


@pytest.mark.parametrize("size", [0.5, *(pytest.param(size, marks=pytest.mark.long) for size in (1.0, 2.0)), 3.7])
@pytest.mark.parametrize(("law", "steps"), [("viscous", 3500), ("sign", 2850)])
def test_cell_search_finds_the_same_contacts(size, law, steps):
    scene = channel(rotation=True, friction_law=law, integrator="leapfrog_extrapolated")
    lists, cells = NativeSimulation(scene), CellSimulation(scene, cell_size=size * D)
    lists.run(steps)  # the front meets the sill at 2700
    cells.run(steps)
    assert sum(row[2] for row in lists.forces) > 0
    assert np.array_equal(lists.ids, cells.ids)
    # the same forces, summed in another order: round-off. The sign law's ramp is so steep in the impact (μ F_n dt /
    # (m_eff eps) > 2) that it chatters and blows round-off up 10^9 times in the next 150 steps.
    assert cells.positions == pytest.approx(lists.positions, abs=1e-9 * D)


def test_list_is_never_too_old():
    """Whatever the skin, the same trajectory: no contact is missed between two lists, nor at the inlet."""
    runs = []
    for skin in (0.02, 0.1, 0.6):
        simulation = NativeSimulation(channel(skin=skin * D))
        simulation.run(3500)
        runs.append(simulation.positions)
    assert runs[1] == pytest.approx(runs[0], abs=1e-9 * D)
    assert runs[2] == pytest.approx(runs[0], abs=1e-9 * D)


def test_a_pour_comes_again_when_the_batch_has_fallen_out_of_its_region():
    pour = Pour((0.0, 4.0), (3.0, 5.0), 9, 0.3, 1.5)
    scene = handmade_scene(EMPTY, EMPTY, (FLOOR,), pours=(pour,))
    fallen = PourState(pour, scene, np.random.default_rng(1)).every * scene.time_step
    assert 1.5 * fallen + 0.5 * 9.81 * fallen**2 == pytest.approx(2.0, abs=6 * scene.time_step)  # half a step at 6 m/s


def test_a_pour_keeps_off_a_lid_where_it_is_now():
    lid = MovingWall(Block("lid", (0.0, 4.0), (0.0, 1.0)), Motion(kind=Loaded(1.0, (0.0, 0.0))))
    pour = Pour((0.0, 4.0), (3.0, 5.0), 9, 0.3, 1.5)
    scene = handmade_scene(EMPTY, EMPTY, (lid,), pours=(pour,))
    boundaries, discs = OpenBoundaries(scene), NativeSimulation(scene).discs
    raised = {"lid": Pose(0.0, 3.0)}  # its top is at 4 m then
    assert all(new.y >= 4.0 + 0.5 * D for new in boundaries.arrivals(1, discs, raised))


def test_pour_fills_without_overlap():
    pour = Pour((0.2, 1.8), (2.0, 3.0), 30, 0.4, 1.0)
    scene = handmade_scene(EMPTY, EMPTY, (Box("tank", (0.0, 2.0), (0.0, 8.0)),), pours=(pour,), seed=3)
    simulation = NativeSimulation(scene)
    simulation.run(1)
    first = simulation.discs.n
    assert first == int(0.4 * 1.6 / (np.pi * 0.01))
    gaps = np.linalg.norm(simulation.positions[:, None] - simulation.positions[None], axis=2)
    assert gaps[np.triu_indices(first, 1)].min() >= D
    entry = simulation.velocities[:, 1] + 0.5 * 9.81 * scene.time_step  # the entry velocity had a last half kick
    assert entry == pytest.approx(-np.sqrt(1.0 + 2 * 9.81 * (3.0 - simulation.positions[:, 1])), rel=1e-9)
    simulation.run(round(2.0 / scene.time_step))
    assert simulation.discs.n == 30
    again = NativeSimulation(scene)
    again.run(simulation.step)
    assert np.array_equal(again.positions, simulation.positions)  # the same seed


@pytest.mark.parametrize(("release", "turned"), [(1, False), (3000, True)])
def test_gate_holds_until_its_release(release, turned):
    shut = gate(Plane("gate", "x", 1.0, "below"), release)
    scene = handmade_scene([[0.85, 0.0]], [[1.0, 0.0]], (shut,), gravity=(0.0, 0.0), restitution=1.0)
    simulation = NativeSimulation(scene)
    simulation.run(2000)  # touches after 0.05 m: 566 steps
    assert (simulation.velocities[0, 0] < 0) == turned


def test_floor_force_is_the_weight():
    scene = handmade_scene(
        [[0.1 + 0.21 * i, 0.1 + 0.2 * j] for j in range(8) for i in range(3)], np.zeros((24, 2)),
        (FLOOR, Plane("left", "x", -0.2, "above"), Plane("right", "x", 0.8, "below")),
        probes=("floor", "left"), probe_steps=500, impact_speed=6.0,
    )  # fmt: skip
    simulation = NativeSimulation(scene)
    simulation.run(500 * (round(4.0 / scene.time_step) // 500))
    assert len(simulation.forces) == 2 * (simulation.step // 500)
    step, name, _, fy, _ = simulation.forces[-2]
    assert (step, name) == (simulation.step, "floor")
    assert fy == pytest.approx(-24 * 40 * 9.81, rel=1e-3)  # an identity once at rest


def test_moment_on_a_block_about_its_lower_left_corner():
    rest = 1.0 + D / 2 - 40 * 9.81 / 2.56e7
    block = Block("sill", (2.0, 4.0), (0.0, 1.0))
    scene = handmade_scene([[3.5, rest]], [[0, 0]], (block,), probes=("sill",), probe_steps=10)
    simulation = NativeSimulation(scene)
    simulation.run(10)
    _, _, fx, fy, moment = simulation.forces[0]
    weight = 40 * 9.81
    assert (fx, fy) == pytest.approx((0.0, -weight), rel=1e-9)
    assert moment == pytest.approx(-1.5 * weight, rel=1e-9)


def test_probe_impulse_is_the_change_of_momentum():
    wall = Plane("wall", "x", 0.0, "above")
    scene = handmade_scene([[0.12, 0.3]], [[-4.0, 0.0]], (wall,), probes=("wall",), probe_steps=100, gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.run(300)
    impulse = sum(row[2] for row in simulation.forces) * 100 * scene.time_step
    assert simulation.velocities[0, 0] > 0
    assert impulse == pytest.approx(-40 * (simulation.velocities[0, 0] + 4.0), rel=1e-12)
    moment = sum(row[4] for row in simulation.forces) * 100 * scene.time_step
    assert moment == pytest.approx(-0.3 * impulse, rel=1e-12)  # force along x at height 0.3


def test_lost_disc_ends_the_run_with_a_reason():
    scene = handmade_scene([[0, 0]], [[50.0, 0.0]], domain=((-1, 1), (-1, 1)), steps=10000)
    result = run_native(scene, None)
    assert result.status == "failed"
    assert "disc 1 " in result.message and "left the domain" in result.message and "outflow" in result.message


def test_deep_overlap_ends_the_run_with_a_reason():
    with pytest.raises(RunError, match=r"overlap 0\.1 m of disc"):
        NativeSimulation(handmade_scene([[0, 0], [0.1, 0]], np.zeros((2, 2))))


def test_nan_ends_the_run_with_a_reason():
    scene = handmade_scene([[0, 0], [1, 0]], [[0, 0], [1, 0]], gravity=(0.0, 0.0))
    simulation = NativeSimulation(scene)
    simulation.discs.vy[1] = np.nan
    with pytest.raises(RunError, match="not a number"):
        simulation.run(5)


def test_stop_on_request_keeps_what_there_is():
    scene = handmade_scene([[0, 0]], [[0, 0]], gravity=(0.0, 0.0), steps=10**9, output_steps=10**9)
    result = run_native(scene, None, should_stop=lambda: True, report_every=0.0)
    assert result.status == "interrupted"
    assert 0 < result.steps < 10**9
    assert run_native(scene, None, stop_at=1234).steps == 1234


def test_keyboard_interrupt_is_an_interruption():
    def pressed(report):
        if report.step == 1000 and not seen:
            seen.append(report)
            raise KeyboardInterrupt

    seen = []
    scene = handmade_scene([[0, 0]], [[0, 0]], gravity=(0.0, 0.0), steps=5000, output_steps=1000)
    result = run_native(scene, None, progress=pressed, report_every=0.0)
    assert result.status == "interrupted"
    assert result.steps == 1000


def test_a_wrong_cell_size_is_refused():
    with pytest.raises(CaseError, match="a tenth of the disc diameter"):
        run_native(handmade_scene([[0, 0]], [[0, 0]]), None, cell_size=0.001)


def test_probe_on_a_gate_counts_until_its_release():
    """Two gates, the first of which goes in mid-window: each keeps its own sum."""
    gates = (gate(Plane("early", "x", 0.18, "below"), 51), gate(Plane("late", "y", 0.18, "below"), 10**6))
    corner = (Plane("left", "x", 0.0, "above"), Plane("low", "y", 0.0, "above"))
    scene = handmade_scene(
        [[0.09, 0.09]], [[0, 0]], (*corner, *gates), gravity=(0.0, 0.0), restitution=1.0,
        probes=("early", "late"), probe_steps=100,
    )  # fmt: skip
    simulation = NativeSimulation(scene)
    simulation.run(200)
    push = scene.coefficients.stiffness_wall * 0.01
    rows = {(step, name): (fx, fy) for step, name, fx, fy, _ in simulation.forces}
    assert rows[100, "early"] == pytest.approx((0.5 * push, 0.0), rel=1e-9)
    assert rows[200, "early"] == (0.0, 0.0)
    assert rows[100, "late"] == pytest.approx((0.0, push), rel=1e-9)


def test_few_discs_far_apart_need_no_large_grid():
    scene = handmade_scene(
        [[-90, -90], [90, 90], [90, 90.19]], np.zeros((3, 2)), diameter=0.2, gravity=(0.0, 0.0), restitution=1.0
    )
    simulation = NativeSimulation(scene)
    assert sum(array.nbytes for array in vars(simulation.discs).values() if isinstance(array, np.ndarray)) < 100_000
    simulation.run(50)
    assert simulation.velocities[2, 1] > 0  # the touching pair was found in the wide cells


def test_control_c_waits_for_a_whole_step(monkeypatch, ctrl_c_heard):
    """Status, step count and balance are those of a whole step."""
    scene = channel(steps=10**7, output_steps=10**7)
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(interrupts, "at_step", lambda step: step == 700 and signal.raise_signal(signal.SIGINT))
    result = run_native(scene, None)
    assert result.status == "interrupted"
    assert result.steps == 700
    assert result.inserted == result.present + result.removed
    assert abs(result.ledger["residual"]) < 1e-3 * result.ledger["throughput"]
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(("field", "value"), [("integrator", "euler"), ("friction_law", "rough"), ("touch", "soft")])
def test_unknown_choices_are_refused(field, value):
    scene = dataclasses.replace(handmade_scene([[0, 0]], [[0, 0]]), **{field: value})
    with pytest.raises(CaseError, match=value):
        NativeSimulation(scene)


def flood() -> Scene:
    """Three rows against time, whose last ones rest at first: the table of a case, on a floor with a sill."""
    graph = Hydrograph((0.0, 0.1, 0.25), (0.15, 0.55, 0.2), (8.0, 10.0, 7.0))
    scene, rows = channel(), []
    entries = entries_of_rows(graph, scene.steps * scene.time_step, mean_square=D * D, largest=D)
    for i, (times, relative) in enumerate(entries):
        if not len(times):
            continue
        steps = np.ceil(times / scene.time_step).astype(int)
        speeds = graph.speed(steps * scene.time_step) * relative
        rows.append(
            InletRow(
                0.0, (i + 0.5) * D, float(speeds.max()), 0.0, int(steps[0]), 1, 0.999 * D,
                turns=tuple(steps.tolist()), speeds=tuple(speeds.tolist()),
            )
        )  # fmt: skip
    return dataclasses.replace(scene, inlets=tuple(rows), hydrograph=graph)


def test_an_inflow_against_time_brings_the_integral_of_its_table():
    scene = flood()
    simulation = NativeSimulation(scene)
    before, seen = np.zeros(0, int), 0
    for step in sorted(turn for row in scene.inlets for turn in row.turns):
        if step > 3000:
            break
        simulation.run(step - simulation.step)
        for place in np.flatnonzero(~np.isin(simulation.ids, before)):
            (row,) = (row for row in scene.inlets if abs(row.y - simulation.positions[place, 1]) < 1e-3 * D)
            # the half kick of that step takes nothing off but at a contact; discs enter without one
            assert simulation.velocities[place, 0] == pytest.approx(row.speed_at(step), rel=1e-3)
            seen += 1
        before = simulation.ids.copy()
    time = 3000 * scene.time_step
    simulation.run(3000 - simulation.step)
    assert seen == simulation.boundaries.inserted == sum(len(row.turns_until(3000)) for row in scene.inlets)
    wanted = scene.hydrograph.means(0.0, time)[1] * time / D**2
    assert simulation.boundaries.inserted == pytest.approx(wanted, abs=0.5 * len(scene.inlets))


def test_an_inflow_against_time_goes_on_bit_for_bit(tmp_path):
    scene = flood()
    whole, part = NativeSimulation(scene), NativeSimulation(scene)
    whole.run(2400)
    part.run(1234)
    save_state(part, tmp_path / "state.npz")
    again = load_state(scene, tmp_path / "state.npz")
    again.run(2400 - 1234)
    assert again.boundaries.inserted == whole.boundaries.inserted > part.boundaries.inserted
    assert np.array_equal(again.ids, whole.ids)
    assert np.array_equal(again.positions, whole.positions)
    assert np.array_equal(again.velocities, whole.velocities)


def test_grains_that_hop_to_the_ends_of_the_bed_of_the_heap_stay_on_it():
    """The first grains out of the hopper may roll and hop that far, at 1.1 m/s: no start of the scene loses one."""
    ends = [(-1.1, 0.02), (1.1, 0.02)]
    hopping = {"kind": "list", "positions": ends, "velocities": [(-1.5, 0.5), (1.5, 0)]}
    scene = load_case(INPUTS / "heap.yaml", {"engine.name": "native", "initial": [hopping]}).scene()
    simulation = NativeSimulation(scene)
    simulation.run(2500)
    x, y = simulation.positions[:2].T
    assert (np.abs(x) < 1.112).all() and (y > 0).all()
