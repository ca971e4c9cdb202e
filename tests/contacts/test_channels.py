# SPDX-License-Identifier: GPL-2.0-or-later
"""Periodic channels and rough beds, on all engines; with sizes, spin, tangential and rolling springs at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from features import BASE, BELT, JETS, SPRINGS

from lammps_jump.case import load_case
from lammps_jump.dump.contacts import ContactFile
from lammps_jump.physics.contact import lagged_restitution
from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Plane, Sizes, handmade_scene
from lammps_jump.scene.scene import Fixed
from lammps_jump.script.stock import lacking, neighbours

NATIVE = "native_verlet"
PERIOD, BED, D = 4.0, 0.1, 0.2
STEPS = 600
FLOOR = Plane("floor", "y", 0.0, "above")
"""The fixed discs stand in it: they and walls do not feel each other."""


def beside(one, other):
    """Largest distance of discs in two states, in diameters, along x by the shorter way."""
    way = np.array(one) - other
    way[:, 0] = (way[:, 0] + PERIOD / 2) % PERIOD - PERIOD / 2
    return np.abs(way).max() / D


def flow(shift=0.0, rolling=True, free=None, **more):
    """Discs of several sizes that run over a row of fixed ones; `free` gives places and velocities of other ones."""
    random = np.random.default_rng(3)
    places = np.array([(0.25 * i + 0.1, 0.22 * j + 0.18) for i in range(16) for j in range(4)])
    speeds = random.normal((3.0, 0.0), 1.0, places.shape)
    if free is not None:
        places, speeds = (np.array(part, float).reshape(-1, 2) for part in free)
    row = np.array([(BED * i, 0.0) for i in range(40)])
    n, m = len(places), len(row)
    positions = np.concatenate([places, row])
    positions[:, 0] += shift
    positions[:, 0] %= PERIOD
    return handmade_scene(
        positions, np.concatenate([speeds, 0 * row]), rotation=True, friction=0.3, friction_law="history",
        springs=Springs(rolling=Rolling(0.1, 0.1, 0.2) if rolling else None), skin=0.06, periodic=True,
        sizes=Sizes((1.0,), (0.16,), (D,), 1, ((n + 1, n + m, BED),)), fixed=Fixed(n + 1, n + m),
        domain=((0.0, PERIOD), (-1.0, 8.0)), steps=4000,
        **{"gravity": (3.0, -9.0), "output_steps": 4000, "walls": (FLOOR,), **more},
    )  # fmt: skip


@pytest.fixture
def started(rig, tmp_path):
    """A function that starts a scene on an engine."""
    running = []

    def start(engine, scene):
        running.append(rig.start(engine, scene, [], tmp_path / str(len(running))))
        return running[-1]

    yield start
    for engine in running:
        engine.close()


@pytest.mark.parametrize("engine", [NATIVE, pytest.param("compiled", marks=pytest.mark.lammps)])
def test_the_seam_is_nowhere(started, engine):
    """A flow that begins half a period further on is the same flow there; springs go round with their discs."""
    here, there = started(engine, flow()), started(engine, flow(shift=PERIOD / 2))
    for one in (here, there):
        one.run(STEPS)
    # sums in another order, amplified by 600 steps of collisions: 1e-13 d measured
    assert beside(there.positions - [PERIOD / 2, 0.0], here.positions) < 1e-9


@pytest.mark.lammps
def test_contacts_of_a_frame_are_those_of_the_native_engine(started, tmp_path):
    """Ids, points and forces, across the seam, with fixed discs and with the wall."""
    places = [(0.19 * i + 0.1, 0.18 * j + 0.13) for i in range(21) for j in range(4)]
    speeds = np.random.default_rng(4).normal((2.0, 0.0), 0.5, (len(places), 2))
    lid, every = (Plane("lid", "y", 0.76, "below"),), 40
    scene = flow(free=(places, speeds), walls=lid, contact_output=True, output_steps=every)
    native, other = started(NATIVE, scene), started("compiled", scene)
    for engine in (native, other):
        engine.run(2 * every)
    who, found = native.simulation.contacts()
    rows = next(tmp_path.glob("*/contacts.bin"))
    written = ContactFile(rows).contacts(2 * every)
    assert len(written) == len(who) > 20 and (who[:, 1] < 0).any() and (who.max(axis=1) > len(places)).any()
    # two discs in either order: then the force is that on the other one
    turned = {(int(j), int(i)): -values[2:4] for (i, j), values in zip(who, found, strict=True) if j > 0}
    known = {(int(i), int(j)): values[2:4] for (i, j), values in zip(who, found, strict=True)} | turned
    for row in written:
        force = known[int(row["i"]), int(row["j"])]
        assert (row["fx"], row["fy"]) == pytest.approx(force, rel=1e-5, abs=1e-5 * np.abs(found[:, 2:4]).max())
    assert np.sort(written["x"] % PERIOD) == pytest.approx(np.sort(found[:, 0] % PERIOD), abs=1e-5)


def test_energy_of_a_driven_channel(started):
    run = started(NATIVE, flow())
    run.run(STEPS)
    ledger = run.simulation.ledger
    # of second order in the step; 4e-5 measured at f = 0.05
    assert abs(ledger["residual"]) < 2e-4 * ledger["throughput"]
    assert ledger["dissipated_friction"] > 0 and ledger["dissipated_dashpots"] > 0


def test_work_of_the_slope_on_a_disc_that_goes_round_twice(started):
    """m g_x times its whole way, which is u t + g_x t^2/2."""
    scene = flow(free=([[3.5, 6.0]], [[8.0, 0.0]]), gravity=(3.0, 0.0))
    run = started(NATIVE, scene)
    steps = round(1.2 / scene.time_step)
    run.run(steps)
    time = steps * scene.time_step
    way = 8.0 * time + 1.5 * time**2
    mass = scene.density * scene.diameters([1])[0] ** 2
    assert way > 2 * PERIOD
    assert run.simulation.ledger["work_of_slope"] == pytest.approx(mass * 3.0 * way, rel=1e-9)


@pytest.mark.parametrize(
    "engine", [NATIVE, *(pytest.param(k, marks=pytest.mark.lammps) for k in ("compiled", "stock"))]
)
def test_restitution_at_a_fixed_disc(started, engine):
    """The effective mass is that of the disc that moves: else its restitution would be 0.33, not 0.2."""
    found = []
    for height in np.linspace(0.16, 0.17, 5):  # phases of the first step of the contact
        scene = flow(free=([[2.0, height]], [[0.0, -1.0]]), gravity=(0.0, 0.0), rolling=engine != "stock")
        scene = replace(scene, sizes=replace(scene.sizes, low=(D,), high=(D,)))
        run = started(engine, scene)
        run.run(round((0.03 + 6.0 / scene.coefficients.omega_wall) / scene.time_step))
        found.append(run.velocities[0, 1])
    c = scene.coefficients
    exact = lagged_restitution(c.damping_ratio * c.correction_wall, c.time_step * c.omega_wall)
    assert np.mean(found) == pytest.approx(exact, rel=0.02)  # the phases of five heights are not all phases


def test_stock_styles_keep_the_order_of_discs_that_roll():
    """Their rolling spring changes its sign with the order of two discs: none is sorted, none goes round."""
    open_ends = replace(flow(), periodic=False)
    assert any("sort 0 0" in line for line in neighbours(open_ends)) and not lacking(open_ends)
    assert not any("sort" in line for line in neighbours(flow(rolling=False))) and not lacking(flow(rolling=False))
    assert "contact.rolling" in lacking(flow())


def test_stock_styles_would_cut_springs_at_walls_that_move_where_inlets_wait():
    """Between the two runs of such a script LAMMPS looks at the walls of the step before, and at their contacts."""
    case = {**BASE, **JETS, "walls": [BELT], "contact": SPRINGS}
    scene = load_case(case).scene()
    waits = replace(scene, inlets=tuple(replace(row, first_step=row.first_step + 3000) for row in scene.inlets))
    assert "inlets that wait" in lacking(waits)
    assert not lacking(replace(waits, springs=None, friction_law="viscous"))
    assert not lacking(replace(scene, inlets=()))
