# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs of several sizes on the native engine: contacts, motion, energy, lists, inlets, pours, output, resume."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np
import pytest
from closed_forms import friction_impulse_factor

from lammps_jump.dump.read import open_dump
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.native.simulation import CellSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.errors import RunError
from lammps_jump.physics.contact import extrapolated_restitution, lagged_restitution
from lammps_jump.scene.scene import InletRow, Outlet, Pour, handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Block, Box, Plane

CLOSED = {"velocity_verlet": lagged_restitution, "leapfrog_extrapolated": extrapolated_restitution}
FLOOR = Plane("floor", "y", 0.0, "above")
GRADED = Sizes((1.0,), (0.14,), (0.26,), seed=3)
FREE = dict(gravity=(0.0, 0.0))


@dataclass(frozen=True)
class AnalysisInputs(Sizes):
    """Diameters of discs 1, 2, … as given."""

    def diameters(self, ids):
        return np.array(self.low)[np.asarray(ids) - 1]


def given(diameters):
    diameters = tuple(float(d) for d in diameters)
    return AnalysisInputs((1 / len(diameters),) * len(diameters), diameters, diameters)


def test_equal_sizes_run_as_equal_discs():
    """The law differs in the arm of friction alone: the same without spin, to round-off."""
    positions, velocities = cloud(4)
    kw = dict(walls=(Box("box", (-0.2, 3), (-0.2, 3)),), friction=0.3)
    plain = NativeSimulation(handmade_scene(positions, velocities, **kw))
    sized = NativeSimulation(handmade_scene(positions, velocities, sizes=given([0.2] * len(positions)), **kw))
    plain.run(500)
    sized.run(500)
    assert plain.energy().elastic > 0
    assert sized.positions == pytest.approx(plain.positions, abs=1e-9 * 0.2)
    assert sized.ledger == pytest.approx(plain.ledger, rel=1e-6, abs=1e-6)


def cloud(seed, n=8):
    rng = np.random.default_rng(seed)
    grid = np.array([(0.27 * i, 0.27 * j) for j in range(n) for i in range(n)])
    return grid, rng.normal(0, 3.0, grid.shape)


@pytest.mark.parametrize("integrator", CLOSED)
@pytest.mark.parametrize("law", ["viscous", "sign"])
def test_momentum_and_angular_momentum_are_kept(law, integrator):
    """Friction acts at the contact point of both discs: the arms of unequal discs add up to their distance."""
    kw = dict(friction=0.3, friction_law=law, rotation=True, integrator=integrator)
    simulation = NativeSimulation(handmade_scene(*cloud(1), sizes=GRADED, **FREE, **kw))

    def momenta():
        (x, y), (vx, vy), m = simulation.positions.T, simulation.velocities.T, 4000.0 * simulation.radii**2
        spin = 0.5 * m * simulation.radii**2 * simulation.spin
        return np.array([(m * vx).sum(), (m * vy).sum(), (m * (x * vy - y * vx) + spin).sum()])

    before, energy = momenta(), simulation.energy().kinetic
    simulation.run(2000)
    assert np.abs(simulation.spin).max() > 1.0 and simulation.energy().kinetic < energy
    assert momenta() == pytest.approx(before, abs=1e-8)


def test_gross_sliding_impulse_of_an_unequal_pair():
    """Friction takes J = mu A (1+e) m_eff v_n: J/m from each speed, and 2 J/(m R) from each spin."""
    e, mu, vn, vt = 0.6, 0.3, 3.0, 9.0
    radii = np.array([0.06, 0.12])
    kw = dict(restitution=e, friction=mu, rotation=True, time_step_fraction=0.005, largest_overlap=0.005)
    kw |= dict(tangential_damping=200 * handmade_scene([], [], **kw).coefficients.omega)  # Coulomb throughout
    place, speed = [[0, 0], [0, 1.00001 * radii.sum()]], [[0, 0], [vt, -vn]]
    simulation = NativeSimulation(handmade_scene(place, speed, sizes=given(2 * radii), **FREE, **kw))
    c, m = simulation.scene.coefficients, 4000.0 * radii**2
    simulation.run(int((2e-6 / vn + 1.6 * c.contact_duration) / c.time_step))
    impulse = mu * friction_impulse_factor(e) * (1 + e) * m.prod() / m.sum() * vn
    # the line of centres turns by v_t t_c / d = 0.6 % while they touch
    assert simulation.velocities[:, 0] - (0, vt) == pytest.approx([impulse / m[0], -impulse / m[1]], rel=0.03)
    assert simulation.spin == pytest.approx(-2 * impulse / (m * radii), rel=0.02)


@pytest.mark.parametrize("diameter", [0.14, 0.26])
def test_sliding_disc_of_any_size_comes_to_roll_at_two_thirds_of_its_speed(diameter):
    u0, mu = 2.0, 0.3
    rest = diameter / 2 - 1000.0 * diameter**2 * 9.81 / 2.56e7
    kw = dict(friction=mu, rotation=True, sizes=given([diameter]))
    simulation = NativeSimulation(handmade_scene([[0, rest]], [[u0, 0]], (FLOOR,), **kw))
    simulation.run(round(2 * u0 / (3 * mu * 9.81) / simulation.scene.time_step))
    assert simulation.velocities[0, 0] == pytest.approx(2 * u0 / 3, rel=1e-3)
    assert simulation.spin[0] * diameter / 2 == pytest.approx(-2 * u0 / 3, rel=1e-3)


def test_free_fall_is_exact_across_new_lists():
    positions, velocities = cloud(2)
    scene = handmade_scene(positions + 40, velocities * 0 + (9.0, 0.0), sizes=GRADED, skin=0.01)
    simulation = NativeSimulation(scene)
    simulation.run(1000)
    t = 1000 * scene.time_step
    assert simulation.rebuilds > 50
    assert simulation.positions == pytest.approx(positions + 40 + [9 * t, -9.81 * t**2 / 2], abs=1e-11)
    assert 2 * simulation.radii == pytest.approx(GRADED.diameters(simulation.ids), abs=0)


@pytest.mark.parametrize("integrator", CLOSED)
def test_ledger_closes(integrator):
    """A loose column falls together, collapses and loses discs through an outlet."""
    grid = np.array([(0.14 + 0.27 * i, 0.14 + 0.27 * j) for j in range(16) for i in range(6)])
    grid += np.random.default_rng(4).uniform(-0.004, 0.004, grid.shape)
    errors = {}
    for f in (0.05, 0.0125):
        scene = handmade_scene(
            grid, np.zeros_like(grid), (FLOOR, Plane("back", "x", 0.0, "above")), sizes=GRADED, friction=0.2,
            rotation=True, impact_speed=8.0, time_step_fraction=f, integrator=integrator,
            outlets=(Outlet("x", 3.0, "above", 50),),
        )  # fmt: skip
        simulation = NativeSimulation(scene)
        simulation.run(round(1.2 / scene.time_step))
        ledger = simulation.ledger
        errors[f] = abs(ledger["residual"]) / ledger["throughput"]
    assert ledger["carried_out"] > 0 and ledger["dissipated_friction"] > 0 and ledger["dissipated_dashpots"] > 0
    assert errors[0.05] < 1e-3 and errors[0.0125] < errors[0.05] / 3


def test_energy_box_keeps_its_energy():
    rng = np.random.default_rng(3)
    grid = np.array([(0.25 + 0.5 * i, 0.25 + 0.5 * j) for j in range(4) for i in range(4)])
    velocities = np.zeros_like(grid)
    velocities[0] = (6.0, -6.0)
    scene = handmade_scene(
        grid, velocities, (Box("box", (0, 2), (0, 2)),), diameter=0.4, restitution=1.0, impact_speed=72**0.5,
        time_step_fraction=0.0125, domain=((-1, 3), (-1, 3)), sizes=given(rng.uniform(0.32, 0.48, 16)), **FREE,
    )  # fmt: skip
    simulation = NativeSimulation(scene)
    start = simulation.energy().total
    assert start == pytest.approx(1000 * (2 * simulation.radii[0]) ** 2 * 36.0, rel=1e-12)
    for _ in range(20):
        simulation.run(round(0.5 / scene.time_step))
        assert simulation.energy().total == pytest.approx(start, rel=0.005)


def test_overlap_limit_knows_the_sizes():
    place = [[0, 0], [0.17, 0]]
    NativeSimulation(handmade_scene(place, np.zeros((2, 2)), sizes=given([0.16, 0.16])))
    with pytest.raises(RunError, match=r"overlap 0\.07 m of disc"):
        NativeSimulation(handmade_scene(place, np.zeros((2, 2)), sizes=given([0.24, 0.24])))


# --- discs that come and go --------------------------------------------------------------------------------------


def channel(**kw):
    """Three rows onto a floor with a sill, free outfall."""
    rows = tuple(InletRow(0.0, (i + 0.5) * 0.26, 8.0, 0.0, 8, 104 + 8 * i, 0.999 * 0.26) for i in range(3))
    walls = (Block("floor", (-2.0, 3.0), (-2.0, 0.0)), Block("sill", (2.0, 2.4), (-2.0, 0.3)))
    outlets = (Outlet("x", 6.0, "above", 50), Outlet("y", -2.5, "below", 50), Outlet("x", -0.5, "below", 50))
    kw = dict(steps=13_000, output_steps=1000, probes=("sill",), probe_steps=100, friction=0.1) | kw
    return handmade_scene([], [], walls, inlets=rows, outlets=outlets, sizes=GRADED, size_steps=8, **kw)


def test_a_disc_enters_with_the_largest_diameter_and_its_weight():
    """The half kick behind the entry is that of the largest disc, with its own mass: g dt/2 (D/d)^2."""
    row = InletRow(0.0, 0.0, 5.0, 0.0, 8, 800, 0.25)
    scene = handmade_scene([], [], inlets=(row,), sizes=GRADED, size_steps=8)
    simulation = NativeSimulation(scene)
    simulation.run(8)
    d, dt, g = GRADED.diameters(1), scene.time_step, 9.81
    assert 2 * simulation.radii == pytest.approx([d], abs=0)
    assert simulation.velocities[0, 1] == pytest.approx(-0.5 * g * dt, rel=1e-12)
    simulation.run(1)
    half = -0.5 * g * dt * (1 + (0.26 / d) ** 2)
    assert simulation.velocities[0, 1] == pytest.approx(half - 0.5 * g * dt, rel=1e-12)
    assert simulation.positions[0] == pytest.approx([5 * dt, half * dt], rel=1e-12)


@pytest.mark.parametrize("spin", [False, True])
def test_energy_of_free_flight_from_inlet_to_outlet_is_exact(spin):
    row = InletRow(0.0, 1.0, 5.0, 0.5, 8, 704, 0.999 * 0.26)
    kw = dict(friction=0.3, rotation=True) if spin else {}
    scene = handmade_scene(
        [], [], inlets=(row,), outlets=(Outlet("x", 2.0, "above", 10),), sizes=GRADED, size_steps=8, **kw
    )
    simulation = NativeSimulation(scene)
    simulation.run(8000)
    ledger = simulation.ledger
    assert simulation.boundaries.removed > 0
    assert abs(ledger["residual"]) < 1e-9 * ledger["brought_in"]


def test_energy_of_a_disc_that_gets_its_size_in_a_contact_is_booked(monkeypatch):
    """Against a floor and another disc, with spin: the ledger has the same residual before and behind the change."""
    rub = dict(friction=0.3, rotation=True)
    row = InletRow(0.0, 0.095, 3.0, -1.0, 1, 10**6, 0.1)
    sizes = given([0.24, 0.2, 0.26])
    scene = handmade_scene([[0.2, 0.12]], [[0, 0]], (FLOOR,), inlets=(row,), sizes=sizes, size_steps=5, **FREE, **rub)
    loops = Core()
    loops.runs_alone = False  # the driver gives the sizes, and the test looks before it
    simulation = NativeSimulation(scene, loops=loops)
    simulation.run(4)
    residuals = [simulation.ledger["residual"]]
    give = simulation.loops.give_sizes
    see = lambda *of: residuals.append(simulation.ledger["residual"]) or give(*of)  # noqa: E731
    monkeypatch.setattr(simulation.loops, "give_sizes", see)
    simulation.run(1)
    residuals.append(simulation.ledger["residual"])
    assert simulation.boundaries.sized == 2 and simulation.energy().elastic > 0
    assert residuals[2] == pytest.approx(residuals[1], abs=1e-9)


@pytest.mark.parametrize("cell_size", [None, 0.4], ids=["lists", "cells"])
def test_discs_balance(cell_size):
    result = run_native(channel(), None, cell_size=cell_size)
    assert result.status == "complete" and result.removed > 0
    assert result.inserted == result.present + result.removed and result.lost == 0
    assert result.ledger["residual"] == pytest.approx(0.0, abs=1e-3 * result.ledger["throughput"])


@pytest.mark.parametrize("size", [0.1, 0.2, 0.4, 0.74])
def test_cell_search_finds_the_same_contacts(size):
    scene = channel(rotation=True)
    lists, cells = NativeSimulation(scene), CellSimulation(scene, cell_size=size)
    lists.run(4700)
    cells.run(4700)
    assert sum(row[2] for row in lists.forces) > 0
    assert np.array_equal(lists.ids, cells.ids)
    assert cells.positions == pytest.approx(lists.positions, abs=1e-9 * 0.2)


def test_list_is_never_too_old():
    runs = []
    for skin in (0.004, 0.02, 0.12):
        simulation = NativeSimulation(channel(skin=skin))
        simulation.run(4700)
        runs.append(simulation.positions)
    assert runs[1] == pytest.approx(runs[0], abs=1e-9 * 0.2)
    assert runs[2] == pytest.approx(runs[0], abs=1e-9 * 0.2)


def poured(**kw):
    pour = Pour(x=(0.3, 1.7), y=(1.0, 1.5), count=20, volume_fraction=0.3, speed_down=5.0)
    box = Box("box", (0.0, 2.0), (0.0, 3.0))
    return handmade_scene(
        [], [], [box], pours=(pour,), domain=((-1, 3), (-1, 4)), steps=9000, output_steps=500, probes=("box",),
        probe_steps=70, sizes=GRADED, size_steps=100, **kw,
    )  # fmt: skip


def test_poured_discs_get_their_sizes_by_id():
    simulation = NativeSimulation(poured(friction=0.2, rotation=True))
    simulation.run(99)
    first = simulation.discs.n
    assert first == int(0.3 * 0.7 / (pi * 0.13**2))
    gaps = np.linalg.norm(simulation.positions[:, None] - simulation.positions[None], axis=2)
    assert gaps[np.triu_indices(first, 1)].min() >= 0.26 - 0.01
    assert np.all(simulation.radii == 0.13)
    simulation.run(1)
    assert 2 * simulation.radii == pytest.approx(GRADED.diameters(np.arange(1, first + 1)), abs=0)
    simulation.run(8900)
    assert 2 * simulation.radii == pytest.approx(GRADED.diameters(np.arange(1, 21)), abs=0)
    assert abs(simulation.ledger["residual"]) < 1e-3 * simulation.ledger["throughput"]


# --- output and resume -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dump_format", ["text", "binary"])
def test_dump_has_radii(tmp_path, dump_format):
    run_native(replace(channel(), steps=4000), tmp_path, dump_format=dump_format)
    frames = list(open_dump(next(tmp_path.glob("dump.lammps*"))))
    assert len(frames) == 5 and frames[-1].n > 20
    for frame in frames:
        assert list(frame.columns)[-1] == "radius"
        assert frame.column("radius") == pytest.approx(0.5 * GRADED.diameters(frame.ids), rel=1e-9)


@pytest.mark.parametrize("name", ["channel", "channel, leap-frog, spin", "pour"])
def test_continued_is_the_same_bit_for_bit(tmp_path, name):
    leap = dict(rotation=True, integrator="leapfrog_extrapolated")
    scene = {"channel": channel, "pour": poured}.get(name, lambda: channel(**leap))()
    whole = run_native(scene, tmp_path / "whole", dump_format="binary")
    checkpoint = None
    for stop in (50, 2500, 2521, 5117, scene.steps):  # at 50 poured discs still wait for their sizes
        parts = run_native(scene, tmp_path / "parts", dump_format="binary", stop_at=stop, resume=checkpoint)
        checkpoint = read_checkpoint(tmp_path / "parts")
    assert parts.status == whole.status == "complete" and parts.ledger == whole.ledger
    for file in ("dump.lammpsbin", "forces.csv"):
        assert (tmp_path / "parts" / file).read_bytes() == (tmp_path / "whole" / file).read_bytes()


def test_state_holds_every_bit(tmp_path):
    scene = channel(rotation=True)
    whole = NativeSimulation(scene)
    whole.run(4321)
    save_state(whole, tmp_path / "state.npz")
    other = load_state(scene, tmp_path / "state.npz")
    for simulation in (whole, other):
        simulation.run(1500)
    for name in ("ids", "positions", "velocities", "spin", "radii"):
        assert np.array_equal(getattr(other, name), getattr(whole, name))
    assert other.forces == whole.forces and other.ledger == whole.ledger
