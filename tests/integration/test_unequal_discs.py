# SPDX-License-Identifier: GPL-2.0-or-later
"""The analysis of discs of several sizes, on runs of LAMMPS' own styles."""

import numpy as np
import pytest

import lammps_jump as lj
from lammps_jump.analysis.contacts import find_contacts, wall_sums
from lammps_jump.analysis.fields import compute_fields
from lammps_jump.analysis.flow import from_scene
from lammps_jump.dump.find import read_forces
from lammps_jump.dump.read import open_dump

pytestmark = pytest.mark.lammps

HEAP = {
    "name": "heap",
    "gravity": 9.81,
    "discs": {"diameter": 0.2, "density": 1000, "sizes": {"kind": "uniform", "spread": 0.2}},
    "contact": {"restitution": 0.2, "friction": 0, "largest_overlap": 0.1, "impact_speed": 8},
    "domain": {"x": [-1, 3], "y": [-1, 9]},
    "walls": [{"name": "box", "kind": "box", "x": [0, 2], "y": [0, 8]}],
    "initial": [{"kind": "lattice", "nx": 7, "ny": 8, "spacing": 0.26, "origin": [0.2, 0.2], "jitter": 0.01}],
    "run": {"duration": 6, "time_step_fraction": 0.2, "output_interval": 0.5, "seed": 1},
    "probes": {"forces": ["box"]},
    "analysis": {"bin_width": 0.5, "energy": True},
    "engine": {"kernel": "stock"},
}


@pytest.fixture(scope="module")
def heap(tmp_path_factory):
    """Flow, dump and folder of a heap that has come to rest."""
    folder = tmp_path_factory.mktemp("heap") / "run"
    case = lj.load_case(HEAP)
    case.run(folder)
    return from_scene(case.scene(), bin_width=0.5), open_dump(folder / "dump.lammpstrj"), folder


def test_a_heap_weighs_what_its_discs_weigh(heap):
    flow, dump, folder = heap
    frame = dump[-1]
    radius = flow.radii(frame)
    np.testing.assert_allclose(2 * radius, flow.scene.diameters(frame.ids), rtol=1e-9)
    assert 0.16 <= 2 * radius.min() < 2 * radius.max() <= 0.24
    weight = 9.81 * 1000 * np.sum((2 * radius) ** 2)
    (wall,) = flow.scene.permanent
    fx, fy = wall_sums(frame, wall, flow).force
    assert fy == pytest.approx(weight, rel=1e-3) and abs(fx) < 1e-3 * weight
    # the engine's own record: the last window against the frame at its end
    probe = read_forces(folder / "forces.csv")["box"]
    assert -probe.fy[-1] == pytest.approx(fy, rel=1e-3)
    fields = compute_fields(frame, flow, x=flow.x_range, y=(-0.5, 4.0))
    cell = fields.attrs["spacing"] ** 2
    assert float(fields.density.sum()) * cell == pytest.approx(weight / 9.81, rel=1e-9)


def test_each_disc_of_a_heap_is_carried(heap):
    """Contact forces from positions, disc by disc, against its weight."""
    flow, dump, _ = heap
    frame = dump[-1]
    found = find_contacts(frame, flow)
    push, total = found.force[:, None] * found.normal, np.zeros((frame.n, 2))
    at = {place: index for index, place in enumerate(zip(frame.x, frame.y, strict=True))}
    np.add.at(total, [at[tuple(place)] for place in found.start], push)
    pairs = ~found.is_wall
    np.subtract.at(total, [at[tuple(place)] for place in found.end[pairs]], push[pairs])
    weight = 9.81 * flow.scene.masses(2 * flow.radii(frame))
    assert np.abs(total - np.column_stack([0 * weight, weight])).max() < 0.02 * flow.scene.mass * 9.81


def test_walls_and_weight_give_the_discs_their_momentum(heap):
    summary = lj.open_run(heap[2]).summary
    for axis in ("x", "y"):
        identity = summary["force"]["identity"][axis]
        assert identity["complete"] and identity["relative"] < 1e-7


def test_profiles_of_a_heap(heap):
    profiles = lj.open_run(heap[2]).profiles
    flow, dump, _ = heap
    mass = np.sum(flow.scene.masses(2 * flow.radii(dump[-1])))
    assert float(profiles.mass_total[-1]) == pytest.approx(mass, rel=1e-9)
    # slivers of discs lie behind the walls
    outside = float(profiles.mass_left[-1] + profiles.mass_right[-1])
    assert float(profiles.mass_depth[-1].sum()) * 0.5 * 1000 + outside == pytest.approx(mass, rel=1e-9)
    assert 0 < outside < 1e-4 * mass
    assert 0.7 < float(profiles.packing[-1].mean()) < 0.9
