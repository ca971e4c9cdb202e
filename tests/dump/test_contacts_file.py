# SPDX-License-Identifier: GPL-2.0-or-later
"""contacts.py of `dump`: the file of contacts, by hand and from a run of the native engine."""

from dataclasses import replace

import numpy as np
import pytest

from lammps_jump.analysis.contacts import pair_sums, wall_sums
from lammps_jump.analysis.flow import from_scene
from lammps_jump.dump.contacts import HEAD, ROW, ContactFile, ContactWriter
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.native import run_native
from lammps_jump.engines.native.ledger import spin, velocities
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.errors import DumpError
from lammps_jump.files import CONTACTS_FILE
from lammps_jump.scene.motion import gate
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Box, Plane

WHO = np.array([[3, 7], [9, 3], [3, -2], [3, -2], [7, -1]])
FOUND = np.arange(25.0).reshape(5, 5)


@pytest.fixture
def path(tmp_path):
    """A file of two frames, the second one without contacts."""
    writer = ContactWriter(tmp_path / CONTACTS_FILE)
    writer.write(5, WHO, FOUND)
    writer.write(10, WHO[:0], FOUND[:0])
    writer.close()
    return tmp_path / CONTACTS_FILE


def test_what_is_written_is_read(path):
    file = ContactFile(path)
    rows = file.contacts(5)
    assert [rows[name].tolist() for name in ROW.names] == [*WHO.T.tolist(), *FOUND.T.tolist()]
    assert len(file.contacts(10)) == 0 and file.contacts(15) is None
    assert path.stat().st_size == 2 * HEAD.size + 5 * 28


def test_forces_are_found_by_the_ids(path):
    one, other = np.array([3, 3, 3, 3, 5]), np.array([7, 9, -2, -2, 3])
    fx, fy = ContactFile(path).forces(5, one, other)
    # of a pair the other way round it is the opposite; two contacts with a wall come in their order
    assert fx[:4].tolist() == [2.0, -7.0, 12.0, 17.0] and fy[:4].tolist() == [3.0, -8.0, 13.0, 18.0]
    assert np.isnan([fx[4], fy[4]]).all() and np.isnan(ContactFile(path).forces(10, one, other)).all()


def test_a_file_that_grows_is_read_on(path, tmp_path):
    data, growing = path.read_bytes(), tmp_path / "growing.bin"
    file = ContactFile(growing)
    assert file.contacts(5) is None
    for cut in (10, HEAD.size + 30, len(data) - 3):
        growing.write_bytes(data[:cut])
        assert (file.contacts(5) is not None) == (cut > 100) and file.contacts(10) is None
    growing.write_bytes(data)
    assert len(file.contacts(10)) == 0


def test_a_damaged_file_is_said(path):
    data = bytearray(path.read_bytes())
    data[HEAD.size + 5 * 28] ^= 1
    path.write_bytes(data)
    with pytest.raises(DumpError, match="byte 160: no frame of contacts"):
        ContactFile(path).contacts(10)


def heap(**law):
    """Discs that fall on each other and on a floor between walls, beside a gate, with friction 0.3."""
    rng = np.random.default_rng(4)
    places = [(0.104 + 0.202 * i + 0.002 * rng.random(), 0.12 + 0.21 * j) for j in range(6) for i in range(8)]
    walls = (gate(Plane("gate", "x", 3.0, "below"), 100), Box("box", (0.0, 1.63), (0.0, 9.0)),
             Plane("floor", "y", 0.01, "above"))  # fmt: skip
    given = {"diameter": 0.2, "friction": 0.3, "impact_speed": 4.0, "steps": 900, "output_steps": 300, **law}
    return handmade_scene(
        places, rng.normal(0.0, 1.0, (48, 2)), walls, domain=((-1, 4), (-1, 9)), contact_output=True, **given
    )


LAWS = {
    "equal": {},
    "sizes and spin": {"rotation": True, "sizes": Sizes((0.5, 0.5), (0.16, 0.18), (0.18, 0.2))},
    "thesis": {"friction_law": "sign", "integrator": "leapfrog_extrapolated"},
}


@pytest.mark.parametrize("law", LAWS)
def test_contacts_are_those_of_the_step(law):
    """Their forces sum up to the discs' own, their powers to what the energy balance books for the kick."""
    scene = heap(**LAWS[law])
    simulation, met = NativeSimulation(scene), set()
    for _ in range(3):
        simulation.run(300)
        d, n, (who, found) = simulation.discs, simulation.discs.n, simulation.contacts()
        met |= set(who[:, 1].tolist())
        total = np.zeros((int(d.ids.max()) + 1, 2))
        np.add.at(total, who[:, 0], found[:, 2:4])
        pair = who[:, 1] > 0
        np.add.at(total, who[pair, 1], -found[pair, 2:4])
        mass = scene.mass * (np.ones(n) if d.radius is None else (d.radius[:n] / scene.radius) ** 2)
        force = np.column_stack([d.fx[:n], d.fy[:n]]) - np.multiply.outer(mass, scene.gravity)
        np.testing.assert_allclose(total[d.ids[:n]], force, atol=1e-11 * np.abs(force).max())
        vx, vy = velocities(scene, d)
        power = (d.dashpot_x[:n] + d.friction_x[:n]) @ vx + (d.dashpot_y[:n] + d.friction_y[:n]) @ vy
        power += 0.0 if d.omega is None else d.torque[:n] @ spin(scene, d)
        assert found[:, 4].sum() == pytest.approx(-power, rel=1e-11) and power < 0
    assert {-2, -3} <= met and -1 not in met and max(met) > 40  # the gate has gone, and keeps its number


def test_contacts_at_the_start_are_those_of_the_first_forces():
    simulation = NativeSimulation(heap(diameter=0.208))
    d, n, (who, found) = simulation.discs, 48, simulation.contacts()
    total = np.zeros((49, 2))
    np.add.at(total, who[:, 0], found[:, 2:4])
    np.add.at(total, who[who[:, 1] > 0, 1], -found[who[:, 1] > 0, 2:4])
    force = np.column_stack([d.fx[:n], d.fy[:n] + simulation.scene.mass * 9.81])
    np.testing.assert_allclose(total[d.ids[:n]], force, atol=1e-11 * max(np.abs(force).max(), 1.0))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Scene and folder of a run."""
    folder, scene = tmp_path_factory.mktemp("heap"), heap(**LAWS["sizes and spin"])
    assert run_native(scene, folder, dump_format="binary").status == "complete"
    return scene, folder


def test_thrust_and_wall_forces_are_those_of_the_file(run):
    """With the velocities that the forces saw, the computed ones agree to the seven digits of the file."""
    scene, folder = run
    computed = from_scene(scene)
    written = replace(computed, written=ContactFile(folder / CONTACTS_FILE))
    edges, simulation = np.linspace(0.0, 1.63, 9), NativeSimulation(scene)
    for frame in open_dump(folder / "dump.lammpsbin"):
        if frame.step == 0:
            continue
        simulation.run(frame.step - simulation.step)
        d, n = simulation.discs, simulation.discs.n
        order = np.argsort(d.ids[:n])
        seen = {"vx": d.vx, "vy": d.vy, "omegaz": d.omega}
        columns = dict(frame.columns) | {name: values[:n][order] for name, values in seen.items()}
        half = make_frame(frame.step, frame.time, frame.box, columns)
        one, two = pair_sums(frame, written, edges).thrust, pair_sums(half, computed, edges).thrust
        scale = np.abs(two).max()
        assert scale > 10.0  # N/m, of discs that weigh 300
        np.testing.assert_allclose(one, two, atol=3e-7 * scale)
        # with those at the step it is another force: the kick of half a step
        assert np.abs(pair_sums(frame, computed, edges).thrust - two).max() > 1e-5 * scale
        for wall in scene.permanent:
            ours, theirs = (wall_sums(*of) for of in ((frame, wall, written), (half, wall, computed)))
            assert ours.force == pytest.approx(theirs.force, abs=1e-7 * np.hypot(theirs.fx, theirs.fy).sum())


def test_a_resumed_run_writes_the_same_file(run, tmp_path):
    scene, folder = run
    run_native(scene, tmp_path, dump_format="binary", stop_at=400)
    with (tmp_path / CONTACTS_FILE).open("ab") as file:
        file.write(b"what a killed part has written")
    run_native(scene, tmp_path, dump_format="binary", resume=read_checkpoint(tmp_path))
    assert (tmp_path / CONTACTS_FILE).read_bytes() == (folder / CONTACTS_FILE).read_bytes()


def test_a_scene_that_does_not_ask_writes_none(tmp_path):
    run_native(replace(heap(), contact_output=False, steps=300), tmp_path)
    assert not (tmp_path / CONTACTS_FILE).exists()


@pytest.mark.fault("wrong frames, discs or forces")
@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("i", 0, "ids i of discs begin at 1"),
        ("i", -7, "ids i of discs begin at 1"),
        ("j", 0, "ids j too, or are -1 to 0 for a wall"),
        ("j", -1, "ids j too, or are -1 to 0 for a wall"),
        ("x", np.nan, "x, y, fx and fy are finite numbers"),
        ("fy", np.inf, "x, y, fx and fy are finite numbers"),
    ],
)
def test_contacts_that_no_run_writes_are_refused(tmp_path, column, value, said):
    scene = handmade_scene([[1.0, 1.0]], [[0.0, 0.0]], domain=((0, 2), (0, 2)), steps=10, output_steps=5)
    rows = np.ones(2, ROW)
    rows["power"] = np.nan  # as the compiled kernel has it
    for damaged in (False, True):
        if damaged:
            rows[column][1] = value
        (tmp_path / CONTACTS_FILE).write_bytes(HEAD.pack(b"LJC1", 5, 2) + rows.tobytes())
        if not damaged:
            assert len(ContactFile(tmp_path / CONTACTS_FILE, scene).contacts(5)) == 2
    with pytest.raises(DumpError, match=f"byte 20: step 5: .*{said}"):
        ContactFile(tmp_path / CONTACTS_FILE, scene).contacts(5)


@pytest.mark.fault("wrong frames, discs or forces")
@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ((0, 5, 5), "does not follow step 5"),
        ((0, 10, 5), "does not follow step 10"),
        ((0, 5, 15), "does not follow step 5"),
        ((0, 1, 2, 3, 4), "more frames than the run"),
    ],
)
def test_frames_of_contacts_are_those_of_the_run(tmp_path, steps, said):
    scene = handmade_scene([[1.0, 1.0]], [[0.0, 0.0]], domain=((0, 2), (0, 2)), steps=10, output_steps=5)
    (tmp_path / CONTACTS_FILE).write_bytes(b"".join(HEAD.pack(b"LJC1", step, 0) for step in steps))
    with pytest.raises(DumpError, match=said):
        ContactFile(tmp_path / CONTACTS_FILE, scene).contacts(10)
