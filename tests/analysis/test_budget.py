# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy between stations that move with a jump's front: what dashpots take, and whether the budget closes."""

# ruff: noqa: RUF001  (the minus sign of the page)
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from made_up import INPUTS, disc_frame, flow_context

from lammps_jump.analysis.budgets import head
from lammps_jump.analysis.budgets.head import (
    EnergyFluxes,
    budget_between,
    energy_budget,
    no_budget,
    why_none,
)
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.jump.found import MeasuredJump, TrackedJump
from lammps_jump.analysis.jump.frame import Moving
from lammps_jump.analysis.jump.result import analyse_jump
from lammps_jump.analysis.jump.section import section
from lammps_jump.analysis.jump.summary import summarise_jump
from lammps_jump.analysis.jump.track import FrontMotion
from lammps_jump.analysis.passes import feed
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.analysis.report.page import SideBySide
from lammps_jump.analysis.tables import main_numbers
from lammps_jump.case import load_case
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import Stations, handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.tracks import Held, Loaded, Oscillate
from lammps_jump.scene.walls import Block, Plane
from lammps_jump.units import ABSENT, as_summary

D = 0.2
FLOOR = Plane("floor", "y", 0.0, "above")
SEVERAL = Sizes((1.0,), (0.14,), (0.26,), seed=3)


@pytest.mark.parametrize(
    ("integrator", "error", "sizes"),
    [
        ("velocity_verlet", 1e-4, SEVERAL),
        pytest.param("leapfrog_extrapolated", 0.02, None, marks=pytest.mark.long),
        pytest.param("velocity_verlet", 1e-4, None, marks=pytest.mark.long),
        pytest.param("leapfrog_extrapolated", 0.02, SEVERAL, marks=pytest.mark.long),
    ],
)
def test_dashpots_of_frames_at_every_step_are_those_of_the_ledger(integrator, error, sizes):
    """A disc that falls onto the floor between two that lean on it: pairs and walls, both sides of a bin's edge."""
    places = [(-0.19, 0.13), (0.0, 0.4), (0.19, 0.13)]
    scene = handmade_scene(
        places, [(1.0, 0.0), (0.0, -8.0), (-1.0, 0.0)], (FLOOR,), diameter=D, integrator=integrator, sizes=sizes,
        steps=1200,
    )  # fmt: skip
    simulation = NativeSimulation(scene)
    flow = from_scene(scene, x_range=(-2.0, 2.0), bin_width=0.05)
    fluxes = EnergyFluxes(flow)
    for _ in range(scene.steps):
        simulation.run(1)
        fluxes.add(take_frame(simulation), 0.0)
    found = {name: values.values * 0.05 * scene.density for name, values in fluxes.result().sum("x").items()}
    ledger = simulation.ledger
    assert ledger["dissipated_dashpots"] > 0.1 * ledger["throughput"]
    taken = found["dashpots"].sum() - 0.5 * found["dashpots"][-1]  # the ledger stops at the step, amid its kick
    assert taken * scene.time_step == pytest.approx(ledger["dissipated_dashpots"], rel=error)
    assert found["mass"] == pytest.approx(scene.masses(scene.diameters([1, 2, 3])).sum(), rel=1e-12)
    energy = found["energy"][-1] + found["elastic"][-1]
    assert energy == pytest.approx(ledger["kinetic"] + ledger["gravitational"] + ledger["elastic"], rel=1e-9)


def jump_frames():
    """Frames of a small jump every 0.02 s, its flow, and the jump found."""
    changes = ["run.duration=4", "run.time_step_fraction=0.2", "run.output_interval=0.02", "probes.forces=[]",
               "run.integrator=velocity_verlet", "engine.name=native"]  # fmt: skip
    scene = load_case(INPUTS / "quick_jump.yaml", changes).scene()
    flow = from_scene(scene, bin_width=0.5, window=(2.0, 4.0), inflow_depth=0.6, inflow_speed=10.0)
    simulation = NativeSimulation(scene, ledger=False)
    simulation.run(round(2.0 / scene.time_step / scene.output_steps) * scene.output_steps)
    frames = []
    while simulation.step < scene.steps:
        frames.append(take_frame(simulation))
        simulation.run(scene.output_steps)
    return frames, flow


@pytest.fixture(scope="module")
def jump():
    frames, flow = jump_frames()
    fluxes = EnergyFluxes(flow)
    result = analyse_jump(compute_profiles(feed(frames, flow, [fluxes]), flow), flow)
    assert result.verdict == "jump"
    return fluxes.result(), result


def test_the_budget_of_a_jump_closes_within_its_error(jump):
    fields, result = jump
    found = energy_budget(fields, result)
    assert abs(found.residual) < 3 * found.residual_error
    assert abs(found.residual) < 0.12 * found.lost
    assert found.lost == pytest.approx(found.carried + found.contacts - found.storage, rel=1e-9)
    assert found.contacts < 0 < found.carried  # the deep side pushes back
    assert (found.start, found.stop) == pytest.approx(
        [np.mean(state.zone) - result.mass_toe for state in (result.upstream, result.downstream)]
    )


def test_the_loss_belongs_to_its_stations(jump):
    fields, result = jump
    near, far = (
        budget_between(fields, result, (result.mass_toe - a, result.mass_toe + b)) for a, b in ((1, 3), (3, 6))
    )
    assert near.dashpots < 0.9 * far.dashpots


def test_frames_have_a_budget_between_the_stations_of_the_case(jump):
    """The same stations, named once from the front and once by the case; those of the case may be anywhere."""
    fields, result = jump
    front, scene, times = result.motion, result.flow.scene, result.track.time
    first, last = (round(time / scene.time_step) for time in (times[0], times[-1]))
    at = front.start + front.speed * times[0]

    def asked(speed):
        head = Stations((at + result.mass_toe - 2, at + result.mass_toe + 4), speed, first, last)
        return energy_budget(fields, replace(result, flow=replace(result.flow, scene=replace(scene, stations=head))))

    alike, still = asked(front.speed), asked(0.0)
    expected = budget_between(fields, result, (result.mass_toe - 2, result.mass_toe + 4))
    assert (alike.start, alike.stop, alike.lost) == pytest.approx((-2.0, 4.0, expected.lost), rel=0.01)
    assert alike.x == pytest.approx((at + result.mass_toe - 2, at + result.mass_toe + 4), abs=1e-6)
    assert still.speed == 0.0 and still.discharge == pytest.approx(expected.discharge, rel=0.1)
    moved = front.speed * (times[-1] - times[0])
    assert still.start == pytest.approx(-2.0 - 0.5 * moved, abs=0.01)  # the toe moves between them


def test_ledger_and_frames_stand_side_by_side(jump):
    fields, result = jump
    budget = as_summary(energy_budget(fields, result))
    keys = ("carried", "contacts", "walls", "storage", "dashpots", "friction", "lost", "residual")
    ledger = {f"stations_{key}": -1e-17 for key in keys} | {"stations_lost": 2.3456, "stations_discharge": 6.6}
    ledger |= {"stations_left": 16.0, "stations_right": 23.0, "stations_speed": -1.0}
    summary = {"ledger": ledger | {"stations_begin": 6.0, "stations_end": 8.0}, "jump": {"budget": budget}}
    table, text = head.section(summary).blocks
    assert "x = 16.00 and 23.00 m at t = 6 s, which move at −1.000 m/s until 8 s" in text[0]
    (lost,) = (row for row in table.rows if row[0] == "Head lost [m]")
    assert lost[1] == "2.346" and lost[2] == f"{budget['lost']:.2f}"
    assert table.rows[2][1:] == ("0.000", ABSENT)
    assert any("stations: head lost 2.346 m" in line for line in main_numbers(summary))
    assert "friction takes energy" in head.section({"ledger": summary["ledger"]}).blocks[1][0]
    assert head.section({"ledger": {"residual": 1.0}}) is None and head.line({}) == ""


def test_gravity_along_the_bed_is_no_loss():
    """A row that slides faster and faster loses nothing, between stations that move too.

    Gravity gives 0.6 m of head there. A disc steps from bin to bin as a whole: a diameter over the row's 20 m.
    """
    pull, c, start = 0.6, -3.0, 30.0
    flow = flow_context(
        domain=((-20.0, 90.0), (-1.0, 9.0)), x_range=(0.0, 60.0), walls=(FLOOR,), stiffness=1e7, stiffness_wall=1e7,
        gravity=(pull, -9.81), time_step=1e-4,
    )  # fmt: skip
    times, fluxes = np.linspace(0.0, 2.0, 21), EnergyFluxes(flow)
    places = np.arange(-15.0, 75.0, D)
    for time in times:
        x, speed = places + 6.0 * time + 0.5 * pull * time**2, 6.0 + pull * time
        rest = 40.0 * 9.81 / 1e7
        fluxes.add(disc_frame(x, 0 * x + D / 2 - rest, speed, box=[[-20, 90], [-1, 9]], time=time), time)
    inside = np.ones(len(times), bool)
    motion = FrontMotion(c, 0.0, start, len(times))
    unused = "momentum_terms track moving mass_end surface_toe surface_end upstream downstream"
    known = {"flow": flow, "in_window": inside, "motion": motion, "mass_toe": 0.0}
    result = MeasuredJump("jump", "", window=(0.0, 2.0), **known, **dict.fromkeys(unused.split()))
    found = budget_between(fluxes.result(), result, (-10.0, 10.0), (start, c), inside)
    assert abs(found.carried) > 0.5
    assert abs(found.lost) < 0.02
    assert found.dashpots == pytest.approx(0.0, abs=1e-6)


def test_why_friction_has_no_budget_is_said():
    flow = from_scene(load_case(INPUTS / "quick_jump.yaml", ["contact.friction=0.01"]).scene())
    assert "friction is not counted" in no_budget(flow) and "probes.stations" in no_budget(flow)
    assert no_budget(from_scene(load_case(INPUTS / "quick_jump.yaml").scene())) == ""


def test_a_gate_that_moves_beyond_the_stations_takes_no_budget_away(jump):
    """A tailgate at x = 26 m, beyond the stations, and one between them; what discs push may be anywhere."""
    fields, result = jump
    scene, between = result.flow.scene, sum(energy_budget(fields, result).x) / 2

    def gated(x, kind):
        gate = MovingWall(Block("gate", (x, x + 0.5), (-1.0, 0.5)), Motion(kind=kind, time_step=scene.time_step))
        return replace(result, flow=replace(result.flow, scene=replace(scene, walls=(*scene.walls, gate))))

    hold = Held(depth=1.0, at=20.0, speed=0.3, range=(-0.2, 1.0))
    assert energy_budget(fields, gated(26.0, hold)) == energy_budget(fields, result)
    assert why_none(fields, gated(26.0, hold)) == ""
    assert energy_budget(fields, gated(between, hold)) is None
    assert "wall 'gate' moves between the stations" in why_none(fields, gated(between, hold))
    swings = Oscillate(amplitude=(between - 26.0, 0.0), period=1.0)
    assert energy_budget(fields, gated(26.0, swings)) is None
    pushed = gated(26.0, Loaded(mass=100.0, force=(0.0, -1.0)))
    assert EnergyFluxes(pushed.flow).result() is None and "what the discs push" in why_none(None, pushed)


def test_friction_has_no_budget(jump):
    fields, result = jump
    scene = load_case(INPUTS / "quick_jump.yaml", ["contact.friction=0.1"]).scene()
    assert EnergyFluxes(from_scene(scene)).result() is None
    assert energy_budget(None, result) is None
    nothing = TrackedJump("no jump found", "", flow=result.flow, in_window=result.in_window)
    assert energy_budget(fields, nothing) is None


def test_the_report_names_the_stations_beside_the_loss(jump):
    fields, result = jump
    found = energy_budget(fields, result)
    whole = replace(summarise_jump(result), budget=found, head_lost=found.lost)
    heads = [
        table.header[0] for block in section(whole).blocks if isinstance(block, SideBySide) for table in block.blocks
    ]
    (head,) = (head for head in heads if head.startswith("Energy from"))
    assert f"{found.start:+.1f} to {found.stop:+.1f} m from the toe".replace("-", "−") in head


def test_values_between_bins_are_those_of_xarray():
    """Bit for bit: at bins, between them, beyond the ends, beside cells that are not covered."""
    values = np.random.default_rng(1).normal(size=(7, 11))
    values[2, 3] = values[4, 9] = np.nan
    field = xr.DataArray(values, dims=("time", "xi"), coords={"xi": 0.5 * np.arange(-5, 6)})
    moving = Moving(np.arange(len(values)), field.xi.values, {})
    for place in (-2.5, -2.51, 2.5, 2.51, -1.0, 0.13, 1.77):
        assert np.array_equal(moving.at(place, values), field.interp(xi=place).values, equal_nan=True)
