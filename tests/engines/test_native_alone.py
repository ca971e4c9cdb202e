# SPDX-License-Identifier: GPL-2.0-or-later
"""The core steps a scene alone, with all that happens at its steps: bits of the driver, which goes event by event."""

from ctypes import byref, c_char_p, c_int64, c_void_p

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.core.columns import RunEnd, Traffic
from lammps_jump.core.library import copied, require_core
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.scene.scene import InletRow, handmade_scene
from lammps_jump.scene.walls import Plane

pytestmark = pytest.mark.usefixtures("compiled_core")

ARRAYS = ("ids", "x", "y", "vx", "vy", "fx", "fy", "x0", "y0")
SCENES = {
    "jet": ("tailgate", {"discs.diameter": 0.5}, 3000),
    "outlet": ("stable_jump", {"discs.diameter": 0.6}, 6000),
    "gate": ("column_collapse", {"discs.diameter": 0.3}, 6000),
    "body": ("caisson", {"discs.diameter": 0.5}, 9000),
    "stations": ("quick_jump", {"probes.stations": {"x": [8, 16], "speed": -0.5, "window": [0.05, 3]}}, 800),
    "periodic": ("inclined_flow", {}, 15000),
}
"""A source, changes and steps."""
AT_WORK = {
    "jet": lambda one: one.boundaries.inserted == one.boundaries.sized > 900 and one.gates.areas,
    "outlet": lambda one: one.boundaries.removed > 20,
    "gate": lambda one: one.walls.gone.tolist().count(1) == 1 and one.books.exchanged["released_by_gates"] > 0,
    "body": lambda one: one.walls.bodies.discs.partner.any() and one.windows.bodies[-1][2][0] > 17.5,
    "stations": lambda one: one.stations.sums[:4].all(),
    "periodic": lambda one: abs(one.books.exchanged["work_of_slope"]) > 0,
}
"""What each scene is there for, so that it happens."""


def scene_of(name):
    source, changes, steps = SCENES[name]
    return load_case(INPUTS / f"{source}.yaml", {"engine.name": "native", **changes}).scene(), steps


def by_driver(threads="1"):
    """Loops of the core whose events are the driver's."""
    loops = Core(threads)
    loops.runs_alone = False
    return loops


def same(one, other):
    """Whether two simulations are the same, to the last bit but for the ledger's order of sums."""
    for name in one.discs.columns:
        assert np.array_equal(getattr(one.discs, name)[: one.discs.n], getattr(other.discs, name)[: other.discs.n]), (
            name
        )
    assert one.step == other.step and one.disc_steps == other.disc_steps and one.windows.begin == other.windows.begin
    assert one.windows.forces == other.windows.forces and one.windows.bodies == other.windows.bodies
    assert np.array_equal(one.walls.sums, other.walls.sums) and np.array_equal(one.walls.gone, other.walls.gone)
    a, b = one.boundaries, other.boundaries
    assert (a.inserted, a.removed, a.sized) == (b.inserted, b.removed, b.sized)
    assert [row.entered for row in a.rows] == [row.entered for row in b.rows]
    scale = one.ledger["throughput"]
    assert list(one.ledger.values()) == pytest.approx(list(other.ledger.values()), rel=1e-9, abs=1e-9 * scale)
    for name, array in one.walls.listed.items():
        assert np.array_equal(array, other.walls.listed[name]), name


@pytest.mark.parametrize("name", SCENES)
def test_the_core_does_what_the_driver_does(name):
    scene, steps = scene_of(name)
    alone, driven = NativeSimulation(scene, loops=Core("2")), NativeSimulation(scene, loops=by_driver())
    for one in (alone, driven):
        one.run(steps)
    same(alone, driven)
    assert AT_WORK[name](alone)
    assert alone.gates.areas == pytest.approx(driven.gates.areas, rel=1e-12)
    assert alone.stations.sums == pytest.approx(driven.stations.sums, rel=1e-9)


@pytest.mark.parametrize(("name", "before"), [("stable_jump", 9000), ("caisson", 3000)])
def test_a_saved_state_goes_on_without_python(name, before, tmp_path):
    """1,000 steps by `jump_run` alone, with threads that have never seen the state: the bits of the native engine."""
    scene = load_case(INPUTS / f"{name}.yaml", {"engine.name": "native", "discs.diameter": 0.4}).scene()
    first = NativeSimulation(scene)
    first.run(before)
    save_state(first, tmp_path / "state.npz")
    whole, other = (load_state(scene, tmp_path / "state.npz") for _ in range(2))
    whole.run(1000)
    core = require_core("this test")
    core.jump_partition.argtypes, core.jump_partition.restype = [c_char_p], c_void_p
    core.jump_run.argtypes, core.jump_run.restype = [c_void_p, c_void_p, c_void_p, c_int64], c_int64
    core.jump_free_partition.argtypes = [c_void_p]
    threads = core.jump_partition(b"1")
    state, events = other.for_host(before + 1000)
    assert core.jump_run(byref(state), byref(events), threads, before + 1000) == RunEnd.AT_TARGET
    d, kinds = whole.discs, {"ids": np.int64}
    for key in ARRAYS:
        array = copied(getattr(state, key), kinds.get(key, np.float64), state.n)
        assert np.array_equal(array, getattr(d, key)[: d.n]), key
    inserted, removed, _ = copied(events.traffic, np.int64, len(Traffic)).tolist()
    assert (events.step, inserted, removed) == (whole.step, whole.boundaries.inserted, whole.boundaries.removed)
    if name == "stable_jump":
        assert inserted > first.boundaries.inserted and removed > first.boundaries.removed > 0
    core.jump_free_partition(threads)


def test_room_grows_inside():
    """Two hundred discs enter a scene that has room for 64, in one call."""
    row = [InletRow(0.0, 0.3 * k, 60.0, 0.0, 1, 40, 0.205) for k in range(8)]
    floor = Plane("floor", "y", -0.2, "above")
    scene = handmade_scene([], [], (floor,), inlets=tuple(row), domain=((-1, 400), (-2, 9)))
    alone, driven = NativeSimulation(scene), NativeSimulation(scene, loops=by_driver())
    room = alone.discs.room
    for one in (alone, driven):
        one.run(1000)
    assert alone.discs.n == 200 > room and alone.discs.room >= 200 and alone.discs.neighbours.size >= 200
    same(alone, driven)
    for one in (alone, driven):  # also where it stands in the middle of what has grown
        one.run(200)
    same(alone, driven)


def test_no_list_has_the_number_of_another():
    """A state may come from other threads: two lists with one number would lose contacts."""
    numbers = set()
    for _ in range(2):
        simulation = NativeSimulation(load_case(INPUTS / "quick_jump.yaml", {"discs.diameter": 0.5}).scene())
        for _ in range(5):
            simulation._rebuild()
            numbers.add(simulation.discs.listed_as)
    assert len(numbers) == 10
