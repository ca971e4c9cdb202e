# SPDX-License-Identifier: GPL-2.0-or-later
"""An image of a scene: a host that reads it goes on with the bits of the native engine."""

import ctypes
import struct
from ctypes import c_char_p, c_int64, c_void_p, sizeof

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.core.columns import RunEnd
from lammps_jump.core.library import copied, require_core
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import jump_events, jump_state
from lammps_jump.engines.native.image import MAGIC, image_of, narrowed

pytestmark = pytest.mark.usefixtures("compiled_core")

SCENES = {
    "stable_jump": {"discs.diameter": 0.5},
    "caisson": {"discs.diameter": 0.5},
    "drum": {},
    "tailgate": {"discs.diameter": 0.5},
}


def loaded(file: bytes) -> tuple[np.ndarray, int, int]:
    """The image in memory with its pointers moved there, and addresses of state and events."""
    magic, word, size, pointers, state, events = struct.unpack_from("<8s5q", file)
    assert (magic, word) == (MAGIC, 8)
    begin = struct.calcsize("<8s5q")
    places = np.frombuffer(file, "<i8", pointers, begin)
    memory = np.frombuffer(file[begin + 8 * pointers :], np.uint8).copy()
    assert memory.size == size + 24  # the version and two sizes are behind it
    base = memory.ctypes.data
    for place in places.tolist():
        memory[place : place + 8].view(np.uint64)[0] += np.uint64(base)
    return memory, base + state, base + events


@pytest.mark.parametrize("name", SCENES)
def test_a_host_goes_on_from_an_image_with_the_same_bits(name):
    scene = load_case(INPUTS / f"{name}.yaml", {"engine.name": "native", **SCENES[name]}).scene()
    simulation = NativeSimulation(scene)
    simulation.run(300)
    held, state, events = loaded(image_of(simulation, 900))
    simulation.run(600)
    core = require_core("this test")
    core.jump_partition.argtypes, core.jump_partition.restype = [c_char_p], c_void_p
    core.jump_run.argtypes, core.jump_run.restype = [c_void_p, c_void_p, c_void_p, c_int64], c_int64
    core.jump_free_partition.argtypes = [c_void_p]
    threads = core.jump_partition(b"1")
    assert core.jump_run(state, events, threads, 900) == RunEnd.AT_TARGET
    there, d = jump_state.from_address(state), simulation.discs
    assert jump_events.from_address(events).step == simulation.step and there.n == d.n
    for key in ("ids", "x", "y", "vx", "vy", "fx", "fy"):
        kind = np.int64 if key == "ids" else np.float64
        assert np.array_equal(copied(getattr(there, key), kind, there.n), getattr(d, key)[: d.n]), key
    core.jump_free_partition(threads)
    assert held.size


def test_pointers_have_the_width_of_the_host():
    scene = load_case(INPUTS / "dam_break.yaml", {"engine.name": "native", "discs.diameter": 0.5}).scene()
    simulation = NativeSimulation(scene)
    wide, narrow = image_of(simulation, 10), image_of(simulation, 10, word=4)
    heads = [struct.unpack_from("<8s5q", one) for one in (wide, narrow)]
    assert [head[1] for head in heads] == [8, 4] and heads[0][3] == heads[1][3]
    assert sizeof(narrowed(jump_state, 4)) < sizeof(narrowed(jump_state, 8)) == sizeof(jump_state)
    assert issubclass(narrowed(jump_state, 4), ctypes.Structure)


def test_a_pour_is_refused():
    pour = {"kind": "pour", "x": [6, 9], "y": [4, 6], "count": 3}
    changes = {"engine.name": "native", "discs.diameter": 0.5, "inflow": pour}
    simulation = NativeSimulation(load_case(INPUTS / "dam_break.yaml", changes).scene())
    with pytest.raises(ValueError, match="a pour is drawn by the engine"):
        image_of(simulation, 10)
