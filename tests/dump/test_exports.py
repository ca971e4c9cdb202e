# SPDX-License-Identifier: GPL-2.0-or-later
"""Exports: what was written is what another reader gets back."""

import base64
import csv
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from children import run_child
from free_bodies import body
from made_up import flow_context

from lammps_jump.analysis.fields import compute_fields
from lammps_jump.analysis.guess import known_coefficients
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.dump.exports import (
    export,
    write_netcdf,
    write_pictures,
    write_profiles_csv,
    write_pvd,
    write_table,
    write_vti,
    write_vtp,
    write_walls,
)
from lammps_jump.dump.find import find_dump, read_dump, read_forces
from lammps_jump.dump.frame import make_frame, ten_indices
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import Motion, MovingWall, gate
from lammps_jump.scene.tracks import Translate
from lammps_jump.scene.walls import Block, Box, Line, Plane

CONTEXT = flow_context(
    domain=((0.0, 2.0), (0.0, 2.0)),
    x_range=(0.0, 2.0),
    walls=(Plane("floor", "y", 0.0, "above"),),
    bin_width=0.5,
)


def frame(step=0):
    x = (np.arange(10) + 0.5) * 0.2
    columns = {"id": np.arange(10, 0, -1), "x": x, "y": 0 * x + 0.1, "vx": 0 * x + 1.0, "vy": 0 * x}
    return make_frame(step, 0.1 * step, [[0, 2], [0, 2]], columns)


def rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def test_table(tmp_path):
    table = {"time": [0.0, 0.5], "n": np.array([1, 2]), "depth": [1 / 3, np.nan], "name": ["a, b", None]}
    path = write_table(table, tmp_path / "t.csv", {"time": "s", "n": "1"})
    assert rows(path) == [["time [s]", "n", "depth", "name"], ["0", "1", "0.3333333333", "a, b"], ["0.5", "2", "", ""]]
    with pytest.raises(DumpError, match="equally long"):
        write_table({"a": [1], "b": [1, 2]}, tmp_path / "t.csv")
    with pytest.raises(DumpError, match="cannot be written"):
        write_table({"a": [1]}, tmp_path / "no" / "t.csv")


def test_profiles_as_tables(tmp_path):
    profiles = compute_profiles([frame(i) for i in range(9)], CONTEXT)
    mean, full = write_profiles_csv(profiles, tmp_path)
    head, *body = rows(mean)
    assert len(body) == 4 and head[0] == "x [m]"
    depth = head.index("mass_depth_mean [m]")
    np.testing.assert_allclose([float(row[depth]) for row in body], profiles.mass_depth_mean, rtol=1e-9)
    head, *body = rows(full)
    assert len(body) == 36
    discharge = head.index("discharge [m2 s-1]")
    np.testing.assert_allclose([float(row[discharge]) for row in body], profiles.discharge.values.ravel(), rtol=1e-9)


def vtk_array(element):
    raw = base64.b64decode(element.text)
    size = int(np.frombuffer(raw[:8], "<u8")[0])
    kind = "<f8" if element.get("type") == "Float64" else "<i8"
    assert len(raw) == 8 + size
    values = np.frombuffer(raw[8:], kind)
    return values.reshape(-1, int(element.get("NumberOfComponents")))


def test_fields_as_a_vtk_image(tmp_path):
    fields = compute_fields(frame(), CONTEXT, x=CONTEXT.x_range, y=(0.0, 0.5))
    root = ET.parse(write_vti(fields, tmp_path / "f.vti")).getroot()
    image = root.find("ImageData")
    ny, nx = fields.density.shape
    assert image.get("WholeExtent") == f"0 {nx} 0 {ny} 0 1"
    origin = [float(v) for v in image.get("Origin").split()]
    np.testing.assert_allclose(origin, [0, 0, 0], atol=1e-12)
    arrays = {a.get("Name"): vtk_array(a) for a in image.iter("DataArray")}
    # x runs fastest in VTK
    np.testing.assert_array_equal(arrays["density"].reshape(ny, nx), fields.density)
    np.testing.assert_array_equal(arrays["velocity"][:, 0].reshape(ny, nx), fields.velocity_x)
    assert arrays["velocity"].shape == (nx * ny, 3)


def test_discs_and_collection_for_paraview(tmp_path):
    root = ET.parse(write_vtp(frame(), tmp_path / "d.vtp", 0.2)).getroot()
    arrays = {a.get("Name"): vtk_array(a) for a in root.iter("DataArray")}
    np.testing.assert_array_equal(arrays["points"][:, 0], frame().x)
    np.testing.assert_array_equal(arrays["id"].ravel(), np.arange(10, 0, -1))
    assert arrays["offsets"].ravel().tolist() == list(range(1, 11))
    pvd = write_pvd([(0.0, tmp_path / "d.vtp"), (0.5, "e.vtp")], tmp_path / "all.pvd")
    sets = list(ET.parse(pvd).getroot().iter("DataSet"))
    assert [s.get("file") for s in sets] == ["d.vtp", "e.vtp"] and float(sets[1].get("timestep")) == 0.5


def cells(path, name):
    """Lines or polygons of walls in a VTK file, each of shape (corners, 2), m."""
    piece = ET.parse(path).getroot()[0][0]
    points = vtk_array(piece.find("Points")[0]).reshape(-1, 3)
    index, ends = (vtk_array(array).ravel() for array in piece.find(name))
    return [points[part, :2] for part in np.split(index, ends[:-1])] if len(ends) else []


def test_walls_for_paraview(tmp_path):
    walls = (
        Block("sill", (1, 2), (0, 1)),
        Line("bed", points=((0, 0), (3, 0), (4, 1))),
        Box("box", (0, 5), (0, 2)),
        Plane("floor", "y", 0.0, "above"),
    )
    path = write_walls(walls, ((0, 6), (-1, 2)), tmp_path / "walls.vtp")
    bed, box = cells(path, "Lines")
    np.testing.assert_allclose(bed, [(0, 0), (3, 0), (4, 1)])
    assert len(box) == 5 and (box[0] == box[-1]).all()
    sill, floor = cells(path, "Polys")
    np.testing.assert_allclose(np.ptp(sill, axis=0), [1, 1])
    np.testing.assert_allclose(floor.min(axis=0), [0, -1])
    piece = ET.parse(path).getroot()[0][0]
    assert vtk_array(piece.find("CellData")[0]).ravel().tolist() == [1, 2, 0, 3]  # lines come first
    assert (piece.get("NumberOfPoints"), piece.get("NumberOfLines"), piece.get("NumberOfPolys")) == ("16", "2", "2")


def test_walls_that_move_have_a_file_a_frame_and_those_that_stand_one(tmp_path):
    frames = [frame(0), frame(1)]
    dump(tmp_path, 2)
    write_netcdf(compute_profiles(frames, CONTEXT), tmp_path / "profiles.nc")
    flow = replace(CONTEXT, scene=replace(CONTEXT.scene, coefficients=known_coefficients(mass=40.0, time_step=0.1)))
    lift = MovingWall(Block("lift", (0, 1), (0, 1)), Motion(kind=Translate(velocity=(0, 2.0), ease=0), time_step=0.1))
    shut = gate(Block("shut", (1, 1), (0, 1)), 1)
    names = []
    for walls in (flow.scene.walls, (shut, *flow.scene.walls, lift)):
        at = replace(flow, scene=replace(flow.scene, walls=walls)).walls_at
        files = export(tmp_path, ("vtk",), tmp_path / f"out{len(walls)}", walls_at=at, room=CONTEXT.scene.domain)
        names.append([path.name for path in files if "walls" in path.name])
    assert names == [["walls.vtp"], ["walls0.vtp", "walls1.vtp", "walls.pvd"]]
    tops = [[part[:, 1].max() for part in cells(tmp_path / "out3" / f"walls{k}.vtp", "Polys")] for k in (0, 1)]
    assert tops == [[1.0], [pytest.approx(1.2)]]
    numbers = ET.parse(tmp_path / "out3" / "walls1.vtp").getroot()[0][0].find("CellData")[0]
    assert vtk_array(numbers).ravel().tolist() == [1, 2]  # the gate, 0, is gone


def test_bodies_for_paraview_stand_at_their_poses(tmp_path):
    """A block that has moved by (2, 1) m and turned by a right angle about its centre of mass."""
    dump(tmp_path, 2)
    write_netcdf(compute_profiles([frame(0), frame(1)], CONTEXT), tmp_path / "profiles.nc")
    time = frame(1).time
    (tmp_path / "walls.csv").write_text(f"time,wall,x,y,angle\n0,box,0,0,0\n{time},box,2,1,{np.pi / 2:.17g}\n")
    scene = replace(CONTEXT.scene, walls=(body(Block("box", (0, 2), (0, 1))),))
    flow = replace(CONTEXT, scene=scene, poses=PoseFile(tmp_path / "walls.csv", scene.lids))
    export(tmp_path, ("vtk",), tmp_path / "out", walls_at=flow.walls_at, room=scene.domain)
    (first,), (last,) = (cells(tmp_path / "out" / f"walls{k}.vtp", "Polys") for k in (0, 1))
    assert sorted(map(tuple, first)) == [(0, 0), (0, 1), (2, 0), (2, 1)]
    corners = [(2.5, 0.5), (2.5, 2.5), (3.5, 0.5), (3.5, 2.5)]
    np.testing.assert_allclose(sorted(map(tuple, np.round(last, 9))), corners)


def dump(tmp_path, frames):
    path = tmp_path / "dump.lammpstrj"
    with DumpWriter(path, ("id", "x", "y", "vx", "vy")) as writer:
        for step in range(frames):
            f = frame(step)
            writer.write_frame(make_frame(step, f.time, f.box, f.columns))
    return open_dump(path)


def test_the_ten_pictures_of_the_thesis(tmp_path):
    source = dump(tmp_path, 91)
    paths = write_pictures(source, tmp_path)
    assert [path.name for path in paths] == [f"picture{i}.dat" for i in range(10)]
    table = np.loadtxt(paths[3])
    assert table[:, 0].tolist() == list(range(1, 11))
    np.testing.assert_allclose(table[:, 1], frame().x[::-1], rtol=1e-9)
    assert ten_indices(91) == list(range(0, 91, 10)) and ten_indices(3) == [0, 1, 2] and ten_indices(0) == []
    assert len(write_pictures(dump(tmp_path, 4), tmp_path)) == 4


def test_a_folder_with_one_dump_in_it_has_that_dump_whatever_its_name(tmp_path):
    with pytest.raises(DumpError, match="no dump in this folder"):
        find_dump(tmp_path)
    with pytest.raises(DumpError, match="no such file"):
        find_dump(tmp_path / "nothing")
    (tmp_path / "dump.parts").mkdir()  # a folder is no dump
    theirs = dump(tmp_path, 2).path.rename(tmp_path / "dump.flow")
    assert find_dump(tmp_path) == find_dump(theirs) == theirs
    assert read_dump(tmp_path).count() == 2
    (tmp_path / "dump.forces").write_text("")
    with pytest.raises(DumpError, match=r"2 dumps in this folder \(dump.flow … dump.forces\); name one"):
        find_dump(tmp_path)
    # a run's own dump goes before whatever else was written beside it
    ours = dump(tmp_path, 3).path
    assert find_dump(tmp_path) == ours and read_dump(tmp_path).count() == 3


def test_forces(tmp_path):
    path = tmp_path / "forces.csv"
    path.write_text("time,structure,fx,fy,moment\n0.1,sill,1,2,3\n0.1,floor,4,5,6\n0.2,sill,-1,-2e3,-3\n")
    forces = read_forces(path)
    assert list(forces) == ["sill", "floor"]
    np.testing.assert_array_equal(forces["sill"].fx, [1, -1])
    np.testing.assert_array_equal(forces["sill"].time, [0.1, 0.2])
    np.testing.assert_array_equal(forces["floor"].moment, [6])
    assert forces["floor"].power is None
    path.write_text("time,structure,fx,fy,moment,power\n0.1,lid,1,2,3,7\n0.1,floor,4,5,6,0\n")
    assert [float(read_forces(path)[name].power[0]) for name in ("lid", "floor")] == [7, 0]
    path.write_text("time,structure,fx,fy,moment\n0.1,sill,1,2,3\n0.2,sill,")
    assert len(read_forces(path)["sill"].time) == 1
    path.write_text("time,structure,fx,fy,moment\n0.1,sill,1,2,x\n0.2,sill,1,2,3\n")
    with pytest.raises(DumpError, match="line 2"):
        read_forces(path)
    path.write_text("t,structure\n")
    with pytest.raises(DumpError, match="no column 'time'"):
        read_forces(path)
    with pytest.raises(DumpError, match="cannot be read"):
        read_forces(tmp_path / "none.csv")


def test_discs_of_several_sizes(tmp_path):
    columns = {"id": [2, 1], "x": [0.0, 1.0], "y": [0.5, 0.5], "vx": [0, 0], "vy": [0, 0], "radius": [0.1, 0.125]}
    graded = make_frame(0, 0.0, [[0, 2], [0, 1]], columns)
    root = ET.parse(write_vtp(graded, tmp_path / "d.vtp", 0.2)).getroot()
    arrays = {a.get("Name"): vtk_array(a) for a in root.iter("DataArray")}
    assert arrays["diameter"].ravel().tolist() == [0.2, 0.25]
    equal = ET.parse(write_vtp(frame(), tmp_path / "e.vtp", 0.2)).getroot()
    (diameters,) = (vtk_array(a) for a in equal.iter("DataArray") if a.get("Name") == "diameter")
    assert (diameters == 0.2).all()
    path = tmp_path / "graded.lammpstrj"
    with DumpWriter(path, tuple(columns)) as writer:
        writer.write_frame(make_frame(0, 0.0, graded.box, graded.columns))
    (picture,) = write_pictures(open_dump(path), tmp_path)
    assert picture.read_text() == "1 1 0.5 0.125\n2 0 0.5 0.1\n"


LOADS = """
import os
os.environ.pop("KMP_DUPLICATE_LIB_OK", None)
before = dict(os.environ)
from lammps_jump.dump.exports import load_netcdf
load_netcdf()
assert os.environ == before, set(os.environ) - set(before)
"""


def test_the_environment_stays_that_of_the_caller():
    """The library behind scipy's NetCDF sets KMP_DUPLICATE_LIB_OK when it is loaded, once a process."""
    status, said = run_child([sys.executable, "-c", LOADS])
    assert status == 0, said
