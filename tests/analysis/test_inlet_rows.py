# SPDX-License-Identifier: GPL-2.0-or-later
"""Sums over bins beside inlets and outlets: what a bin reads is the mean of the stream, whenever frames are taken."""

from math import cos, inf, isnan, nan, sin

import numpy as np
import pytest
from made_up import disc_frame, flow_context

import lammps_jump as lj
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.profiles import OpenEnds, compute_profiles, intervals_of, running_rows
from lammps_jump.analysis.slope import AlongBed, BedStretch
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.scene.scene import InletRow, Outlet
from lammps_jump.scene.walls import Plane

D, DT, EVERY = 0.2, 1e-3, 60
SPEEDS = 6.0, 5.0
"""Of two rows whose discs follow each other at 0.36 and 0.30 m."""
FLOOR = Plane("floor", "y", 0.0, "above")
WANTED = {
    "mass_depth": sum(D**2 / (v * EVERY * DT) for v in SPEEDS),
    "discharge": 2 * D**2 / (EVERY * DT),
    "momentum_flux": sum(SPEEDS) * D**2 / (EVERY * DT),
    "energy_flux": 0.5 * sum(v**2 for v in SPEEDS) * D**2 / (EVERY * DT),
}
"""Of the two rows, by time: depth (m), discharge (m^2/s), momentum flux (m^3/s^2), energy flux (m^4/s^3)."""
PHASES = (0, 11, 30, 44, 59)
"""Steps since a turn."""


def rows(towards=1, table=False):
    """Two rows at x = 0 that let discs in every 60 steps, the second one 17 steps later; `table`: turn by turn."""
    found = []
    for k, speed in enumerate(SPEEDS):
        turns = tuple(range(7 + 17 * k, 4000, EVERY)) if table else ()
        more = {"turns": turns, "speeds": (towards * speed,) * len(turns)} if table else {}
        row = InletRow(0.0, (k + 0.5) * D, towards * speed, 0.0, 7 + 17 * k, EVERY, 0.999 * D, **more)
        found.append(row)
    return tuple(found)


def streams(steps, towards=1, **more):
    """Frames at these steps of what the rows have brought within 10 m."""
    found = []
    for step in steps:
        went = [(step - np.array(row.turns_until(step))) * DT * row.vx for row in rows(towards)]
        here = [np.abs(way) <= 10.0 for way in went]
        x = np.concatenate([way[near] for way, near in zip(went, here, strict=True)])
        y, u = (
            np.repeat([getattr(row, name) for row in rows(towards)], [near.sum() for near in here])
            for name in ("y", "vx")
        )
        found.append(disc_frame(x, y, u, box=[[-20, 20], [-1, 4]], step=step, time=step * DT, **more))
    return found


def flow_of(width, towards=1, **more):
    low, high = sorted((0.0, towards * 10.0))
    outlet = Outlet("x", towards * 10.0, "above" if towards > 0 else "below", 1)
    given = {"inlets": rows(towards), "outlets": (outlet,), "domain": ((-12.0, 12.0), (-1.0, 4.0)), "time_step": DT}
    return flow_context(**given | {"walls": (FLOOR,), "x_range": (low, high), "bin_width": width, "diameter": D} | more)


@pytest.mark.parametrize("width", [0.1, 0.25, 0.5, 1.0, 2.5])
@pytest.mark.parametrize("towards", [1, -1])
@pytest.mark.parametrize("table", [False, True])
def test_every_bin_reads_the_mean_of_the_stream_at_any_instant(width, towards, table):
    """A frame shows one phase of the rows, and so do all of them where they come in step with the rows."""
    flow = flow_of(width, towards, inlets=rows(towards, table))
    found = compute_profiles(streams([3000 + phase for phase in PHASES], towards), flow)
    inner = np.abs(found.x.values) < 9.5 - width  # an outlet has no turns: the test after the next
    for name, wanted in WANTED.items():
        sign = towards if name in ("discharge", "energy_flux") else 1
        np.testing.assert_allclose(sign * found[name].values[:, inner], wanted, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(found["count"].values[:, inner], WANTED["mass_depth"] * width / D**2, rtol=1e-9)


@pytest.mark.parametrize("phase", PHASES)
def test_what_is_outside_makes_up_for_the_discs_that_come_next(phase):
    (frame,) = streams([3000 + phase])
    found = compute_profiles([frame], flow_of(0.5))
    binned = float(found.mass_depth.sum()) * 0.5 * 1000 + float(found.mass_left[0] + found.mass_right[0])
    assert binned == pytest.approx(frame.n * 40.0, rel=1e-12) == float(found.mass_total[0])
    assert abs(float(found.mass_left[0])) <= 2 * 0.5 * 40.0 + 1e-9  # half a disc of each row


@pytest.mark.parametrize("width", [0.1, 0.5, 2.5])
def test_a_bin_at_an_outlet_reads_the_mean_over_all_phases(width):
    """Discs leave with their centres; what lies behind the outlet before is folded back."""
    found = compute_profiles(streams(range(3000, 3000 + EVERY)), flow_of(width, window=(3.0, 3.06)))
    one = 2 * D**2 / EVERY / width  # a disc of each row steps over the outlet once in 60 frames
    np.testing.assert_allclose(found.mass_depth_mean, WANTED["mass_depth"], atol=one)
    np.testing.assert_allclose(found.discharge_mean, WANTED["discharge"], atol=one * SPEEDS[0])


def test_the_surface_at_an_inlet_is_that_of_the_lines_with_discs_on_both_sides():
    """Discs at 0.2 m in a row from the inlet on: lines before the first centre see half of what others see."""
    x = np.arange(0.05, 10.0, D)
    flow = flow_of(0.5, inlets=(InletRow(0.0, 0.1, 5.0, 0.0, 7, 40, 0.999 * D),))
    found = compute_profiles([disc_frame(x, 0 * x + 0.1, 5.0, box=[[-1, 20], [-1, 4]], step=7)], flow)
    np.testing.assert_allclose(found.surface_depth, 0.2, rtol=1e-12)


def test_rows_that_do_not_run_change_nothing():
    """Of a drowned inlet, of another dump, with all their discs in, far apart, before the first turn."""
    flow, (frame,) = flow_of(0.5), streams([3000])
    assert len(running_rows(flow, frame).x) == 2
    moved = disc_frame(frame.x + 0.15, frame.y, frame.vx, box=[[-20, 20], [-1, 4]], step=3000)
    assert not len(running_rows(flow, moved).x)
    assert not len(running_rows(flow, disc_frame([], [], box=[[-20, 20], [-1, 4]], step=3000)).x)
    assert not len(running_rows(flow, disc_frame(frame.x, frame.y, frame.vx, box=[[-20, 20], [-1, 4]], step=5)).x)
    done = tuple(InletRow(0.0, row.y, row.vx, 0.0, row.first_step, EVERY, D, limit=50) for row in rows())
    assert not len(running_rows(flow_of(0.5, inlets=done), frame).x)
    apart = tuple(InletRow(0.0, row.y, row.vx, 0.0, row.first_step, 600, D) for row in rows())
    assert not len(running_rows(flow_of(0.5, inlets=apart), frame).x)
    np.testing.assert_array_equal(intervals_of(np.zeros(3), running_rows(flow, moved)), np.zeros(3))


def test_ends_where_discs_come_and_go():
    assert OpenEnds.of(flow_of(0.5)) == (0.0, 10.0, 0.0)
    assert OpenEnds.of(flow_of(0.5, towards=-1)) == (-10.0, 0.0, 0.0)
    begin, end, inlet = OpenEnds.of(flow_of(0.5, inlets=(), outlets=()))
    assert (begin, end) == (-inf, inf) and isnan(inlet)
    inside = OpenEnds.of(flow_of(0.5, x_range=(1.0, 9.0)))
    assert inside[:2] == (-inf, inf)
    ways = OpenEnds(0.0, 10.0, 0.0).ways(
        np.array([-1.0, -0.1, 0.1, 5.0, 9.9, 10.1]), np.array([0.0, 0.2, 0.2, 0.0, 0.2, 0.2])
    )
    np.testing.assert_allclose(ways.weight, [0.0, 0.25, 0.75, 1.0, 1.0, 0.0])
    assert OpenEnds(-inf, inf, nan).ways(np.array([-1.0]), np.array([0.0])).weight == [1.0]


@pytest.mark.parametrize("phase", PHASES)
def test_a_stream_along_a_sloping_bed_reads_its_mean_too(phase):
    """Rows that run down 20 degrees: in the frame of the bed their places are in step with the frames as well."""
    angle, (level,) = -0.35, streams([3000 + phase])
    c, s = cos(angle), sin(angle)
    x, y = c * level.x - s * level.y, s * level.x + c * level.y
    down = disc_frame(x, y, c * level.vx, s * level.vx, box=[[-20, 20], [-9, 4]], step=level.step)
    tilted = tuple(
        InletRow(-s * row.y, c * row.y, c * row.vx, s * row.vx, row.first_step, EVERY, row.clearance) for row in rows()
    )
    whole = flow_context(
        inlets=tilted, domain=((-12.0, 12.0), (-9.0, 4.0)), time_step=DT, walls=(FLOOR,), x_range=(0.0, 9.0),
        bin_width=0.5, diameter=D, stiffness=1e6,
    )  # fmt: skip
    along = AlongBed(whole, BedStretch(1.0, s / c, 7.0, angle))
    along.add(down, 0.0)
    found = along.result().profiles
    np.testing.assert_allclose(found.discharge[0], WANTED["discharge"], rtol=1e-9)


D_JET = 0.14
JET = {
    "name": "jet", "discs": {"diameter": D_JET}, "contact": {"restitution": 0.2, "friction": 0, "impact_speed": 8.86},
    "domain": {"x": [-4, 4], "y": [-1, 4]},
    "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "inflow": {"kind": "rows", "depth": 0.5, "mean_speed": 8.86},
    "outflow": [{"x_beyond": 2.5}],
    "run": {"duration": 1.6, "output_interval": 0.1, "time_step_fraction": 0.1},
    "engine": {"name": "native"},
}  # fmt: skip
"""Jet of 0.5 m over 2.5 m of floor."""
SIZED = {"discs.sizes": {"kind": "uniform", "spread": 0.2}}


@pytest.mark.parametrize(
    "changes",
    [
        SIZED | {"run.output_interval": 0.2},
        {},
        pytest.param({"inflow.profile": "uniform"}, marks=pytest.mark.long),
        pytest.param(SIZED | {"inflow.profile": "uniform"}, marks=pytest.mark.long),
        pytest.param({"inflow.schedule": "thesis"}, marks=pytest.mark.long),
        pytest.param({"run.output_interval": 0.02}, marks=pytest.mark.long),
    ],
)
def test_the_first_bins_of_a_jet_have_its_discharge(changes):
    """Bins of 2.5 diameters, from 0.4 s on; the thesis' rows are refused some turns, and carry what has entered."""
    scene = lj.load_case(JET, changes).scene()
    flow = from_scene(scene, bin_width=0.35, window=(0.4, 1.6))
    simulation, frames = NativeSimulation(scene, ledger=False), []
    while simulation.step < scene.steps:
        simulation.run(scene.output_steps)
        frames.append(take_frame(simulation))
    asked = sum(scene.discharges)
    if "inflow.schedule" in changes:
        begin = frames[round(0.4 / scene.time_step / scene.output_steps) - 1]
        entered = frames[-1].ids.max() - begin.ids.max()
        asked = entered * D_JET**2 / ((frames[-1].step - begin.step) * scene.time_step)
    found = compute_profiles(frames, flow)
    np.testing.assert_allclose(found.discharge_mean.values[:4], asked, rtol=0.02)  # sizes differ from bin to bin: 1 %
