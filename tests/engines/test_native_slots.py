# SPDX-License-Identifier: GPL-2.0-or-later
"""What lies in the slots of a disc stays with it: sorts, removal, insertion, and the file of the state."""

from dataclasses import replace

import numpy as np
import pytest

from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.native.discs import DiscArrays
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.errors import ResumeError
from lammps_jump.scene.scene import InletRow, Outlet, handmade_scene
from lammps_jump.scene.walls import Plane

S = 3
NAMES = ("partner", "sigma", "spring", "roll")


def scene(slots=S):
    """Thirty discs that fall, come by a row and leave on the right."""
    places = np.random.default_rng(5).permutation([(0.3 * i, 0.3 * j) for i in range(6) for j in range(5)])
    row = InletRow(-1.0, 2.0, 3.0, 0.0, 200, 400, 0.21)
    return handmade_scene(
        places, np.tile([2.0, 0.0], (30, 1)), walls=(Plane("floor", "y", -0.15, "above"),), inlets=(row,),
        outlets=(Outlet("x", 2.0, "above", 100),), domain=((-3, 4), (-1, 5)), slots=slots,
    )  # fmt: skip


def mark(discs):
    """Fill the slots with numbers that tell the disc's id and the slot."""
    ids = discs.ids[: discs.n, None]
    for k, name in enumerate(NAMES):
        getattr(discs, name)[: discs.n] = 1000 * ids + 10 * np.arange(S) + k


def rows(discs):
    """What the slots hold, by id."""
    kept = zip(discs.ids[: discs.n], *(getattr(discs, name)[: discs.n] for name in NAMES), strict=True)
    return {int(identity): np.array(parts) for identity, *parts in kept}


def expected(identity):
    return 1000 * identity + 10 * np.arange(S) + np.arange(4)[:, None]


def test_slots_follow_the_discs_of_a_run(tmp_path):
    simulation = NativeSimulation(scene())
    mark(simulation.discs)
    order = simulation.discs.ids[:30].tolist()
    simulation.run(3000)
    d, b = simulation.discs, simulation.boundaries
    assert b.removed > 3 and b.inserted > 33 and d.ids[: d.n].tolist() != [k for k in order if k in d.ids[: d.n]]
    found = rows(d)
    for identity, held in found.items():
        assert np.array_equal(held, expected(identity) if identity <= 30 else np.zeros((4, S)))
    save_state(simulation, tmp_path / "state.npz")
    other = load_state(scene(), tmp_path / "state.npz")
    for one in (simulation, other):
        one.run(1500)
    again, left = rows(simulation.discs), rows(other.discs)
    assert again.keys() == left.keys() != found.keys()
    assert all(np.array_equal(again[identity], left[identity]) for identity in again)
    assert np.array_equal(simulation.positions, other.positions)


def test_room_grows_with_what_lies_in_the_slots():
    discs = DiscArrays(scene(), Core(), ledger=False)
    mark(discs)
    before, room = rows(discs), discs.room
    discs.grow()
    assert discs.room > room and all(np.array_equal(held, before[k]) for k, held in rows(discs).items())
    assert discs.partner.shape == discs.roll.shape == (discs.room, S)


def test_slots_change_no_bit_of_the_motion_and_cost_nothing_without(tmp_path):
    with_slots, without = NativeSimulation(scene()), NativeSimulation(scene(slots=0))
    for simulation in (with_slots, without):
        simulation.run(800)
        save_state(simulation, tmp_path / f"{len(simulation.discs.columns)}.npz")
    assert np.array_equal(with_slots.positions, without.positions)
    assert all(getattr(without.discs, name) is None for name in NAMES)
    sizes = [np.load(path).files for path in sorted(tmp_path.glob("*.npz"), key=lambda path: len(np.load(path).files))]
    assert set(sizes[1]) - set(sizes[0]) == set(NAMES) and set(sizes[0]) < set(sizes[1])


@pytest.mark.parametrize("slots", [0, 1])
def test_a_state_of_other_slots_is_refused(slots, tmp_path):
    save_state(NativeSimulation(scene(slots)), tmp_path / "state.npz")
    with pytest.raises(ResumeError, match="is no state"):
        load_state(replace(scene(), slots=S), tmp_path / "state.npz")
