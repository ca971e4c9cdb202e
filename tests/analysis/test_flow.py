# SPDX-License-Identifier: GPL-2.0-or-later
"""What the analysis takes from a scene, and what it guesses from a bare dump."""

import numpy as np
import pytest
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.analysis.flow import Flow, from_scene
from lammps_jump.analysis.guess import from_dump
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import gate
from lammps_jump.scene.scene import InletRow, Outlet, handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Block, Box, Plane


def scene(**changes):
    values = {
        "friction": 0.1,
        "domain": ((-1.0, 95.0), (-15.0, 40.0)),
        "walls": (Block("floor", (-10, 60.5), (-10, 0)), Block("sill", (60, 61), (-10, 2))),
        "inlets": tuple(InletRow(0.0, 0.1 + 0.2 * i, 14.0 + i, 0.0, 0, 140, 0.2) for i in range(5)),
        "outlets": (Outlet("x", 90.0, "above", 100), Outlet("y", -5.0, "below", 100)),
        "steps": 1000,
        "settle_steps": 200,
    }
    return handmade_scene([], [], **{**values, **changes})


def test_context_of_a_channel():
    c = from_scene(scene())
    assert c.x_range == (0.0, 90.0)
    # a disc of d^2 every 140 steps in rows of 14 … 18 m/s
    depth = sum(0.2**2 / (140 * c.time_step * speed) for speed in (14, 15, 16, 17, 18))
    assert (c.inflow_depth, c.inflow_speed) == (pytest.approx(depth), pytest.approx(16.0))
    # thesis 3.21-3.23 at n = 10: 2 xi sqrt(k m_eff) at e = 0.2, five digits
    assert c.dashpots == pytest.approx((20634, 29181), rel=1e-4)
    assert c.window == pytest.approx((600 * c.time_step, 800 * c.time_step))
    assert c.time(make_frame(200, None, [[0, 1], [0, 1]], {"x": [], "y": []})) == 0.0
    assert c.time(make_frame(200, 3.5, [[0, 1], [0, 1]], {"x": [], "y": []})) == 3.5
    np.testing.assert_array_equal(c.bed_height([0.0, 59.0, 60.2, 61.0]), [0, 0, 2, 2])
    assert np.isnan(c.bed_height(61.5))
    # half of the bin [60, 62] has no floor
    np.testing.assert_allclose(c.mean_bed(np.array([58.0, 60.0, 61.0, 62.0])), [0, 2, np.nan])
    np.testing.assert_allclose(c.mean_bed(np.array([59.0, 61.0])), [1.0])


def test_the_inflow_of_a_case_has_the_depth_asked_for():
    for sizes in (None, {"kind": "uniform", "spread": 0.2}):
        case = lj.load_case(INPUTS / "quick_jump.yaml").replace({"discs.sizes": sizes})
        c = from_scene(case.scene())
        # intervals are whole steps
        assert c.inflow_depth == pytest.approx(case.fields.inflow.depth, rel=5e-3)
        assert c.sized == (sizes is not None)


def test_radii_and_masses_of_discs():
    sizes = Sizes((0.5, 0.5), (0.1, 0.2), (0.1, 0.3), seed=3)
    equal, graded = from_scene(scene()), from_scene(scene(sizes=sizes))
    columns = {"id": [4, 2, 9], "x": [1, 2, 3], "y": [1, 1, 1]}
    box = [[0, 1], [0, 1]]
    bare, told = make_frame(0, 0.0, box, columns), make_frame(0, 0.0, box, {**columns, "radius": [0.15, 0.05, 0.1]})
    for one in (bare, told):
        assert equal.radii(one).tolist() == [0.1, 0.1, 0.1] and equal.relative_masses(one).tolist() == [1, 1, 1]
        assert equal.radii(one).strides == (0,) == equal.relative_masses(one).strides  # one number, no array
    assert graded.radii(told).tolist() == [0.15, 0.05, 0.1] and graded.largest_radius(told) == 0.15
    np.testing.assert_allclose(graded.relative_masses(told), [2.25, 0.25, 1.0])
    np.testing.assert_array_equal(graded.radii(bare), 0.5 * sizes.diameters([4, 2, 9]))
    empty = make_frame(0, 0.0, box, {"id": [], "x": [], "y": [], "radius": []})
    assert graded.radii(empty).size == 0 and graded.largest_radius(empty) == 0.1


def test_walls_and_gates_bound_the_stretch():
    shut = gate(Plane("gate", "x", 4.0, "below"), 200)
    c = from_scene(scene(walls=(Plane("back", "x", 0.5, "above"), Plane("floor", "y", -1.0, "above"), shut), inlets=()))
    assert c.x_range == (0.5, 90.0)
    assert c.bed_height(3.0) == -1.0
    assert shut.wall in c.walls_at(-0.001) and shut.wall not in c.walls_at(0.0)
    assert c.scene.wall("gate") is shut.wall
    with pytest.raises(KeyError):
        c.scene.wall("none")
    box = from_scene(scene(walls=(Box("box", (0, 2), (0.25, 2)),), inlets=(), outlets=()))
    assert box.x_range == (0, 2) and box.bed_height(1.0) == 0.25 and np.isnan(box.bed_height(3.0))


def test_a_sluice_gate_is_no_floor_but_a_stack_is():
    floor = Plane("floor", "y", 0.0, "above")
    c = from_scene(scene(walls=(Block("sluice", (5, 6), (1, 9)), floor)))
    assert c.bed_height(5.5) == 0.0
    stack = from_scene(scene(walls=(Block("upper", (5, 6), (1, 3)), Block("lower", (4, 7), (-1, 1)), floor)))
    np.testing.assert_array_equal(stack.bed_height([4.5, 5.5]), [1, 3])


def write(path, x, y, **more):
    columns = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": 0 * x, "vy": 0 * x, **more}
    with DumpWriter(path, tuple(columns)) as writer:
        writer.write_frame(make_frame(0, None, [[0, 10], [0, 5]], columns))
    return open_dump(path)


def test_a_bare_dump_is_guessed_and_the_guesses_are_named(tmp_path):
    x, y = (part.ravel() for part in np.meshgrid(0.3 * np.arange(20) + 0.15, 0.3 * np.arange(5) + 1.15))
    c = from_dump(write(tmp_path / "dump", x, y))
    assert c.scene.diameter == pytest.approx(0.3, rel=1e-8) and c.scene.mass == pytest.approx(90, rel=1e-8)
    assert c.bed_height(2.0) == pytest.approx(1.0)
    assert c.x_range == pytest.approx((0.0, 6.0))
    for word in ("Diameter guessed", "Density", "Mass", "Gravity", "Floor", "Profiles from", "step numbers"):
        assert any(word in note for note in c.notes), word
    assert not c.knows_contacts


def test_what_is_given_is_not_guessed(tmp_path):
    x = np.array([0.1, 0.5])
    c = from_dump(
        write(tmp_path / "dump", x, 0 * x + 1, radius=0 * x + 0.05),
        density=900,
        bin_width=0.3,
        time_step=1e-4,
    )
    assert c.scene.diameter == pytest.approx(0.1) and c.scene.mass == pytest.approx(9.0)
    assert c.bin_width == 0.3 and c.time_step == 1e-4
    assert not any(word in note for note in c.notes for word in ("Density", "step numbers"))
    mixed = from_dump(write(tmp_path / "mixed", x, 0 * x + 1, diameter=np.array([0.1, 0.3]), mass=np.array([2.0, 4.0])))
    # the nominal disc is that of mean mass
    assert mixed.scene.diameter == pytest.approx(np.sqrt(0.05)) and mixed.scene.mass == 3.0 and mixed.sized
    assert any("differ in size" in note for note in mixed.notes)
    same = from_dump(write(tmp_path / "same", x, 0 * x + 1, diameter=np.array([0.1, 0.3])), diameter=0.2)
    assert not same.sized and same.scene.diameter == 0.2


def test_a_bare_dump_with_radii(tmp_path):
    """Floor and stretch end at the edges of the discs; the depth by mass holds their mass."""
    x, radius = np.array([0.1, 0.5, 1.2]), np.array([0.1, 0.05, 0.3])
    dump = write(tmp_path / "dump", x, 1.0 + radius, radius=radius)
    c = from_dump(dump, density=900, bin_width=0.5)
    assert c.sized and c.scene.mass == pytest.approx(900 * c.scene.diameter**2)
    assert c.bed_height(0.5) == pytest.approx(1.0) and c.x_range == pytest.approx((0.0, 1.5))
    np.testing.assert_allclose(c.radii(dump[0]), radius)
    profiles = compute_profiles(dump, c)
    assert float(profiles.mass_total[0]) == pytest.approx(900 * np.sum((2 * radius) ** 2))
    assert float(profiles.mass_depth.sum()) * 0.5 == pytest.approx(np.sum((2 * radius) ** 2))
    assert float(profiles.surface_depth.max()) <= 0.6 + 1e-9


def test_what_cannot_be_guessed_is_an_error(tmp_path):
    empty, one = np.array([]), np.array([1.0])
    with pytest.raises(DumpError, match="no frame holds a disc"):
        from_dump(write(tmp_path / "a", empty, empty))
    with pytest.raises(DumpError, match="give the diameter"):
        from_dump(write(tmp_path / "b", one, one))
    with pytest.raises(DumpError, match="on top of each other"):
        from_dump(write(tmp_path / "c", np.array([1.0, 1.0]), np.array([1.0, 1.0])))
    for bad in ({"diameter": -1}, {"density": 0}, {"density": float("nan")}, {"bin_width": 0}, {"time_step": -1}):
        with pytest.raises(DumpError, match=next(iter(bad))):
            from_dump(write(tmp_path / "d", one, one), **bad)
    assert isinstance(from_dump(write(tmp_path / "e", one, one), diameter=0.2), Flow)
