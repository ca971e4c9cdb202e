# SPDX-License-Identifier: GPL-2.0-or-later
"""The bridge, tested with MDAnalysis itself: selections, RDF, a transformation, copies."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter

mda = pytest.importorskip("MDAnalysis")

from MDAnalysis import transformations  # noqa: E402
from MDAnalysis.analysis.rdf import InterRDF  # noqa: E402

from lammps_jump.dump import mdanalysis as mda_reader  # noqa: E402

BOX = [[-1.0, 19.0], [-5.0, 15.0], [-0.1, 0.1]]


def write(path, sizes, seed=4, fmt="binary"):
    """Frames whose ids enter and leave, unsorted."""
    rng = np.random.default_rng(seed)
    with DumpWriter(path, ("id", "x", "y", "vx", "vy"), fmt, precision="%.17g") as writer:
        for step, (first, last) in enumerate(sizes):
            ids = rng.permutation(np.arange(first, last))
            x, y = rng.uniform(0, 18, len(ids)), rng.uniform(-4, 14, len(ids))
            columns = {"id": ids, "x": x, "y": y, "vx": x / 3, "vy": -y}
            writer.write_frame(make_frame(100 * step, 0.25 * step, BOX, columns))
    return path


@pytest.fixture
def varying(tmp_path):
    return write(tmp_path / "dump", [(1, 6), (3, 12), (5, 5), (9, 40)])


@pytest.fixture
def fixed(tmp_path):
    return write(tmp_path / "dump.lammpstrj", [(1, 301)] * 5, fmt="text")


def test_absent_discs_are_masked(varying):
    u = mda_reader.universe(varying, diameter=0.2, mass=40.0)
    # not all are there at one time, but all have a place
    assert len(u.atoms) == 39 and list(u.atoms.ids) == list(range(1, 40))
    assert u.trajectory.n_frames == 4 and u.trajectory.dt == 0.25
    assert u.atoms.masses[0] == 40.0 and u.atoms.radii[0] == pytest.approx(0.1)
    for ts, frame in zip(u.trajectory, open_dump(varying), strict=True):
        assert ts.time == frame.time and ts.data["step"] == frame.step
        mask = ts.data["present"]
        frame = frame.sorted()
        assert list(u.atoms.ids[mask]) == list(frame.ids)
        np.testing.assert_array_equal(ts.data["positions"][mask, 0], frame.x)  # float64, bit by bit
        np.testing.assert_array_equal(ts.data["velocities"][mask, 1], frame.vy)
        np.testing.assert_array_equal(ts.positions[mask, 1], frame.y.astype(np.float32))
        assert np.isnan(ts.positions[~mask]).all()
        group = mda_reader.present(u)
        assert list(group.ids) == list(frame.ids)
        np.testing.assert_array_equal(ts.data["box_low"], [-1, -5, -0.1])
        np.testing.assert_allclose(ts.dimensions, [20, 20, 0.2, 90, 90, 90], rtol=1e-6)


def test_random_access_and_rewind(varying):
    u = mda_reader.universe(varying)
    frames = list(open_dump(varying))
    for i in (3, 0, 2, 1, 3, -1):
        assert u.trajectory[i].data["present"].sum() == frames[i].n
    assert [ts.data["step"] for ts in u.trajectory[1:4:2]] == [100, 300]
    assert u.trajectory.ts.frame == 0  # rewound
    with pytest.raises(IndexError):
        u.trajectory[4]


def test_identical_to_our_reader_where_the_number_is_fixed(fixed):
    u = mda_reader.universe(fixed)
    for ts, frame in zip(u.trajectory, open_dump(fixed), strict=True):
        frame = frame.sorted()
        assert ts.data["present"].all()
        np.testing.assert_array_equal(ts.data["positions"][:, :2], np.column_stack([frame.x, frame.y]))
        np.testing.assert_array_equal(ts.velocities[:, 0], frame.vx.astype(np.float32))


def test_selections(fixed):
    u = mda_reader.universe(fixed)
    frame = open_dump(fixed).__iter__().__next__().sorted()
    right = u.select_atoms("prop x > 9.0")
    assert set(right.ids) == set(frame.ids[frame.x.astype(np.float32) > 9.0])
    near = u.select_atoms("around 1.0 index 0")
    distance = np.hypot(frame.x - frame.x[0], frame.y - frame.y[0])
    # no periodic image comes within 1 m: there is a free metre on every side
    assert set(near.ids) == set(frame.ids[(distance < 1.0) & (distance > 0)])


def test_radial_distribution_counts_pairs(fixed):
    u = mda_reader.universe(fixed)
    rdf = InterRDF(u.atoms, u.atoms, nbins=8, range=(0.0, 2.0), exclusion_block=(1, 1), norm="none").run()
    expected = np.zeros(8)
    for frame in open_dump(fixed):
        d = np.hypot(frame.x[:, None] - frame.x, frame.y[:, None] - frame.y)
        expected += np.histogram(d[~np.eye(frame.n, dtype=bool)], 8, (0.0, 2.0))[0]
    # both directions of a pair; MDAnalysis rounds to float32, a pair at a bin's edge may change sides
    np.testing.assert_allclose(
        rdf.results.count, expected / (5 if rdf.results.count.sum() < 0.5 * expected.sum() else 1), atol=2
    )


def test_radial_distribution_of_a_varying_number(varying):
    u = mda_reader.universe(varying)
    group = mda_reader.present(u, updating=True)
    u.trajectory[3]
    rdf = InterRDF(group, group, nbins=4, range=(0.0, 2.0), exclusion_block=(1, 1), norm="none").run(start=3)
    frame = list(open_dump(varying))[3]
    d = np.hypot(frame.x[:, None] - frame.x, frame.y[:, None] - frame.y)
    np.testing.assert_allclose(rdf.results.count, np.histogram(d[~np.eye(frame.n, dtype=bool)], 4, (0, 2))[0], atol=2)


def test_a_transformation(fixed):
    u = mda_reader.universe(fixed)
    before = u.atoms.positions.copy()
    u.trajectory.add_transformations(transformations.translate([1.0, 5.0, 0.0]))
    np.testing.assert_allclose(u.atoms.positions, before + np.array([1, 5, 0], np.float32), rtol=1e-6)
    # the originals stay as they were read
    np.testing.assert_allclose(u.trajectory.ts.data["positions"], before, rtol=1e-6)


def test_without_dimensions_and_copies(varying):
    u = mda_reader.universe(varying, dimensions=False)
    assert u.dimensions is None
    u.trajectory[1]
    for other in (u.copy(), pickle.loads(pickle.dumps(u))):
        assert other.trajectory.n_frames == 4
        assert other.trajectory[3].data["present"].sum() == 31
    assert mda_reader.JumpDumpReader.parse_n_atoms(varying) == 39


def test_the_example_of_the_page_runs(tmp_path, capsys):
    page = (Path(__file__).parents[2] / "docs" / "mdanalysis.md").read_text()
    example = page.split("```python\n")[1].split("```")[0]
    path = tmp_path / "dump.lammpstrj"
    with DumpWriter(path, ("id", "x", "y", "vx", "vy")) as writer:
        for k in range(2):
            columns = {"id": [1, 2 + k], "x": [1.0, 2.0], "y": [0.1, 0.1], "vx": [3.0, 3.0], "vy": [4.0, 4.0]}
            writer.write_frame(make_frame(k, 0.5 * k, [[0, 20], [0, 5]], columns))
    exec(compile(example.replace("runs/quick_jump/dump.lammpstrj", str(path)), "docs/mdanalysis.md", "exec"), {})
    assert capsys.readouterr().out == "t = 0.00 s: 2 discs, 5.00 m/s\nt = 0.50 s: 2 discs, 5.00 m/s\n"


def test_radii_are_those_of_the_dump(tmp_path):
    """A disc that gets its own size after it has entered has that; masses go with the square."""
    path = tmp_path / "graded"
    frames = ([1, 2], [0.1, 0.12]), ([2, 1, 3], [0.08, 0.1, 0.12]), ([3, 2], [0.11, 0.08])
    with DumpWriter(path, ("id", "x", "y", "radius"), "binary") as writer:
        for step, (ids, radii) in enumerate(frames):
            columns = {"id": np.array(ids), "x": np.arange(len(ids)), "y": np.ones(len(ids)), "radius": np.array(radii)}
            writer.write_frame(make_frame(step, 0.1 * step, BOX, columns))
    u = mda_reader.universe(path, diameter=0.2, mass=40.0)
    np.testing.assert_allclose(u.atoms.radii, [0.1, 0.08, 0.11], rtol=1e-6)
    np.testing.assert_allclose(u.atoms.masses, 1000 * (2 * np.array([0.1, 0.08, 0.11])) ** 2)
    assert mda_reader.universe(path, mass=40.0).atoms.masses.mean() == pytest.approx(40.0)
