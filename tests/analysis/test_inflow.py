# SPDX-License-Identifier: GPL-2.0-or-later
"""What the rows of an inflow delivered: discs counted row by row, also where some were refused."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.analysis.budgets.inflow import Arrivals, InflowCounter, analyse, deliver, in_order, section
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.forces.impulse import MomentumLedger, identity_sentence, impulse_identity, with_inflow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.case import load_case
from lammps_jump.dump.find import ForceHistory
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.runs.results import flow_of

QUICK = ("run.duration=3", "run.time_step_fraction=0.2", "initial=[]")


def delivered(*changes):
    """Numbers of the inflow of a short jet, and the simulation."""
    case = load_case(INPUTS / "quick_jump.yaml", [*QUICK, *changes])
    scene = case.scene()
    flow = flow_of(case)
    flow = from_scene(scene, inflow_depth=flow.inflow_depth, inflow_speed=flow.inflow_speed, window=(1.0, 3.0))
    counter, simulation = InflowCounter(flow), NativeSimulation(scene, ledger=False)
    while True:
        frame = take_frame(simulation)
        counter.add(frame, flow.time(frame))
        if simulation.step >= scene.steps:
            return deliver(counter.result(), flow, flow.window), simulation
        simulation.run(scene.output_steps)


@pytest.mark.parametrize("changes", [(), ("discs.sizes=null",), ("inflow.profile=uniform",)])
def test_the_exact_schedule_delivers_what_is_asked_and_refuses_none(changes):
    found, _ = delivered(*changes)
    assert found.refused == 0 and all(row.refused == 0 for row in found.rows)
    assert found.delivered == pytest.approx(6.0, rel=5e-3) == found.asked
    assert not found.notes
    assert found.speed * found.depth == pytest.approx(found.delivered, rel=5e-3)
    assert found.momentum == pytest.approx(found.momentum_planned, rel=0.03)


def test_an_inflow_against_time_is_held_against_its_table_over_the_window():
    table = "inflow.table=[[0, 0.2, 6], [1.5, 0.6, 10], [2.5, 0.6, 10], [3, 0.3, 8]]"
    found, simulation = delivered("inflow.depth=null", "inflow.mean_speed=null", table)
    graph = simulation.scene.hydrograph
    depth, discharge = graph.means(1.0, 3.0)
    assert (found.asked, found.depth_asked) == pytest.approx((discharge, depth), rel=1e-3)  # the window in whole frames
    # half a disc of each row at both ends of the window: the area of 3 discs in 2 s at most, mostly one
    assert found.delivered == pytest.approx(found.asked, abs=0.5 * 0.0228 * 6)
    assert found.planned == pytest.approx(found.asked, abs=0.5 * 0.0228 * 6)
    assert found.refused == 0 and not found.notes
    assert found.speed_asked == pytest.approx(discharge / depth, rel=1e-3)
    dry, _ = delivered("inflow.depth=null", "inflow.mean_speed=null", "inflow.table=[[0, 0.6, 10], [0.9, 0, 10]]")
    assert dry.asked == dry.delivered == 0.0 and not dry.notes


def test_refused_turns_are_told_row_by_row():
    found, simulation = delivered("discs.sizes=null", "inflow.schedule=thesis")
    rows = simulation.boundaries.rows
    last = simulation.step
    turns = [(last - state.first) // state.every + 1 for state in rows]
    assert [row.turns for row in found.rows] == turns
    assert [row.refused for row in found.rows] == [n - state.entered for n, state in zip(turns, rows, strict=True)]
    assert found.refused == sum(turns) - simulation.boundaries.inserted > 0
    assert found.deviation < -0.03
    assert "refused" in found.notes[0] and "6 m2/s asked for" in found.notes[0]


def test_a_drowned_inlet_is_told_with_the_time_of_its_last_disc():
    case = load_case(INPUTS / "quick_jump.yaml")
    flow = from_scene(case.scene(), inflow_depth=0.6, inflow_speed=10.0, window=(10.0, 20.0))
    time, rows = np.arange(0.0, 20.0), len(flow.scene.inlets)
    turns = np.full((20, rows), 50)
    entered = np.where(time[:, None] <= 12, turns, 0)
    arrivals = Arrivals(
        time, turns, entered, entered.sum(axis=1), 0.15**2 * entered, 0 * time, np.ones((20, 3)), np.ones((20, 2))
    )
    assert deliver(arrivals, flow, flow.window).notes[0].endswith("no disc has entered since t = 12 s")
    some = replace(arrivals, discs=np.maximum(arrivals.discs, 1))
    assert "since" not in deliver(some, flow, flow.window).notes[0]


def test_discs_are_matched_with_turns_in_order():
    rng = np.random.default_rng(3)
    rows = rng.integers(0, 5, 40)
    wanted = 0.2 * rows
    kept = np.sort(rng.permutation(40)[:33])
    places = in_order(wanted[kept] + rng.normal(0, 0.01, 33), wanted)
    assert np.all(np.diff(places) > 0)
    assert np.array_equal(rows[places], rows[kept])
    heights = np.where(np.arange(33) == 7, np.nan, wanted[kept])
    assert np.array_equal(np.delete(rows[in_order(heights, wanted)], 7), np.delete(rows[kept], 7))


def test_a_flow_without_rows_has_no_inflow():
    assert analyse(Gathered(None, None, None, {}, {})) is None


def test_the_section_says_what_came_of_the_discharge():
    found, _ = delivered()
    blocks = section(found).blocks
    assert blocks[0].rows[0] == ("Discharge [m²/s]", 6.0, found.delivered)
    assert blocks[0].rows[-1][-1] == f"0 of {found.turns}"
    assert len(blocks[1].rows) == 6


AGAINST_TIME = (
    "inflow.depth=null", "inflow.mean_speed=null", "inflow.table=[[0, 0.6, 12], [4, 0.6, 12], [6, 0.3, 10]]"
)  # fmt: skip


@pytest.mark.parametrize(
    "changes",
    [
        (),
        pytest.param(("discs.sizes=null",), marks=pytest.mark.long),
        pytest.param(("discs.sizes=null", "inflow.schedule=thesis"), marks=pytest.mark.long),
        pytest.param(AGAINST_TIME, marks=pytest.mark.long),
    ],
)
def test_momentum_of_a_jet_that_leaves_at_an_outlet_is_accounted_for(changes):
    """Over a low sill and out in free flight: what walls gave, and what discs brought in and carried out, adds up."""
    near = ("walls.floor.x=[-5, 20.2]", "walls.sill.x=[20, 20.6]")
    # far from the sill: what hits a disc between its last frame and the outlet is not in the record, 1e-5 near it
    near += ("domain={x: [-1, 45], y: [-16, 20]}", "outflow=[{x_beyond: 36}, {y_below: -14}]")
    more = ("run.duration=6", "walls.sill.y=[-5, 0.4]", *near, *changes)
    scene = load_case(INPUTS / "quick_jump.yaml", [*QUICK, *more]).scene()
    flow, simulation = from_scene(scene), NativeSimulation(scene, ledger=False)
    ledger, counter = MomentumLedger(flow), InflowCounter(flow)
    while True:
        frame = take_frame(simulation)
        for collector in (ledger, counter):
            collector.add(frame, flow.time(frame))
        if simulation.step >= scene.steps:
            break
        simulation.run(scene.output_steps)
    time, _, fx, fy, moment = zip(*simulation.forces, strict=True)
    record = ForceHistory(*(np.array(column, float) for column in (time, fx, fy, moment)))
    record = replace(record, time=np.array([scene.time(step) for step in time]))
    identity = impulse_identity({"sill": record}, with_inflow(ledger.result(), counter.result(), scene), flow, "x")
    assert identity.complete and (identity.start, identity.end) == (0.0, pytest.approx(6.0, rel=2e-3))
    assert identity.carried_out > 0.1 * identity.brought_in > 0
    assert identity.relative < 1e-5
    assert "discs that came and went" in identity_sentence(identity)
