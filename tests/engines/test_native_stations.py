# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy between two stations that move: every step counted, in parts as in the whole, and exact where it can be."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from made_up import INPUTS, call

from lammps_jump.case import load_case
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.ledger import (
    BEGAN,
    CARRIED,
    CONTACTS,
    DASHPOTS,
    FRICTION,
    HELD,
    MASS_LEFT,
    MASS_RIGHT,
    WALLS,
)
from lammps_jump.engines.native.simulation import CellSimulation
from lammps_jump.errors import CaseError
from lammps_jump.scene.scene import InletRow, Stations, handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Plane

D = 0.2
WIDE = Stations((-50.0, 50.0), 0.7, 0, 6000)


def column(**others):
    """A loose column that falls together and collapses, with friction and spin."""
    rng = np.random.default_rng(4)
    grid = np.array([(0.13 + 0.25 * i, 0.13 + 0.25 * j) for j in range(16) for i in range(6)])
    return handmade_scene(
        grid + rng.uniform(-0.004, 0.004, grid.shape),
        np.zeros_like(grid),
        (Plane("floor", "y", 0.0, "above"), Plane("back", "x", 0.0, "above")),
        friction=0.2,
        rotation=True,
        impact_speed=8.0,
        steps=6000,
        **others,
    )


def sums_of(scene, stations, make=NativeSimulation):
    simulation = make(replace(scene, stations=stations))
    simulation.run(6000)
    return simulation.stations.sums, simulation


def left_over(sums):
    gone = sums[HELD] - sums[BEGAN] + sums[DASHPOTS] + sums[FRICTION]
    return sums[CARRIED] + sums[CONTACTS] + sums[WALLS] - gone


SIZES = Sizes((1.0,), (0.16,), (0.24,), seed=3)
OFTEN = {
    ("velocity_verlet", "viscous", False),
    ("velocity_verlet", "sign", True),
    ("leapfrog_extrapolated", "viscous", True),
    ("leapfrog_extrapolated", "sign", False),
}
"""Each pair of two choices once; the others are long."""


@pytest.mark.parametrize(
    ("integrator", "law", "sizes"),
    [
        pytest.param(*one, SIZES if sized else None, marks=[] if (*one, sized) in OFTEN else pytest.mark.long)
        for one in product(("velocity_verlet", "leapfrog_extrapolated"), ("viscous", "sign"))
        for sized in (False, True)
    ],
)
def test_stations_around_all_discs_count_what_the_run_loses(integrator, law, sizes):
    """The speed of the stations is in no loss; the back wall works against it."""
    sums, simulation = sums_of(column(integrator=integrator, friction_law=law, sizes=sizes), WIDE)
    ledger = simulation.ledger
    assert ledger["dissipated_friction"] > 0.01 * ledger["throughput"]
    # the run's ledger ends at the step, amid its kick
    assert sums[DASHPOTS] == pytest.approx(ledger["dissipated_dashpots"], rel=1e-3)
    assert sums[FRICTION] == pytest.approx(ledger["dissipated_friction"], rel=1e-3)
    assert sums[CARRIED] == sums[CONTACTS] == 0.0 and abs(sums[WALLS]) > 0.01 * ledger["throughput"]
    assert left_over(sums) == pytest.approx(ledger["elastic"], abs=2e-3 * ledger["throughput"])


@pytest.mark.parametrize("make", [pytest.param(NativeSimulation, marks=pytest.mark.long), CellSimulation])
def test_two_stretches_make_up_the_whole(make):
    """At the station between them discs cross and contacts are cut, with friction and spin."""
    scene = column()
    stretches = (0.35, 1.1), (1.1, 1.95), (0.35, 1.95)
    one, two, both = (sums_of(scene, Stations(x, 0.3, 500, 6000), make)[0] for x in stretches)
    lost = both[DASHPOTS] + both[FRICTION]
    assert (one[MASS_LEFT], two[MASS_RIGHT]) == (both[MASS_LEFT], both[MASS_RIGHT]) and one[MASS_RIGHT] == two[
        MASS_LEFT
    ]
    assert one[CARRIED:] + two[CARRIED:] == pytest.approx(both[CARRIED:], abs=1e-9 * lost)
    for sums in (one, two, both):  # each closes up to the work of springs
        assert abs(left_over(sums)) < 0.02 * lost
    assert abs(one[CONTACTS]) > 0.05 * lost and one[MASS_RIGHT] > 0


def test_stations_leave_the_discs_alone():
    scene = column()
    assert np.array_equal(sums_of(scene, WIDE)[1].positions, sums_of(scene, None)[1].positions)


def test_free_discs_carry_what_is_stored():
    """Discs of a row fly through both stations, down a slope: in less out is what is stored, to round-off."""
    row = InletRow(0.0, 1.0, 5.0, 0.5, 1, 700, 0.999 * D)
    stations = Stations((0.5, 1.3), 0.4, 2000, 8000)
    scene = handmade_scene([], [], inlets=(row,), gravity=(1.5, -9.0), steps=8000, stations=stations)
    simulation = NativeSimulation(scene)
    simulation.run(8000)
    found, ledger = simulation.stations.sums, simulation.ledger
    assert found[CARRIED] == pytest.approx(found[HELD] - found[BEGAN], rel=1e-9)
    assert abs(found[CARRIED]) > 1.0
    assert ledger["stations_lost"] == ledger["stations_contacts"] == 0.0
    # a disc every 700 steps; one more or one less at the ends
    seconds = 6000 * scene.time_step
    discs = ledger["stations_discharge"] * scene.density * seconds / scene.mass
    assert discs == pytest.approx(6000 / 700 * (1 - 0.4 / 5.0), abs=1.01)


CASE = ["engine.name=native", "run.duration=2"]


def stations(text):
    return load_case(INPUTS / "quick_jump.yaml", [*CASE, f"probes.stations={text}"]).scene().stations


def test_a_case_names_stations():
    found = stations("{x: [10, 12 m], speed: -0.5, window: [0.5, 1.5]}")
    scene = load_case(INPUTS / "quick_jump.yaml", CASE).scene()
    assert found.x == (10.0, 12.0) and found.speed == -0.5 and scene.stations is None
    assert (found.first_step, found.last_step) == (5 * scene.output_steps, 15 * scene.output_steps)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{x: [10, 12], window: [0.5, 2.5]}", "allowed are times of two frames or more within"),
        ("{x: [10, 12], window: [0.5, 0.52]}", "allowed are times of two frames or more within"),
        ("{x: [10, 10.1], window: [0.5, 1.5]}", "two discs, or more"),
        ("{x: [3, 12], speed: -3, window: [0.5, 1.5]}", "discs come or go at 0 m"),
        ("{x: [10, 26], window: [0.5, 1.5]}", "discs come or go at 25 m"),
        ("{x: [12, 10], window: [0.5, 1.5]}", "runs backwards"),
        ("{x: [10, 12]}", "is required"),
    ],
)
def test_stations_that_cannot_be_are_refused(text, message):
    with pytest.raises(CaseError, match=rf"probes\.stations.*{message}"):
        stations(text)


def test_lammps_is_told_to_leave_stations_to_the_native_engine(monkeypatch, capsys):
    given = "probes.stations={x: [10, 12], window: [0.5, 1.5]}"
    status, _, error = call(monkeypatch, capsys, "check", INPUTS / "quick_jump.yaml", "--set", given)
    assert status == 2 and "probes.stations" in error and "use engine.name: native" in error
