# SPDX-License-Identifier: GPL-2.0-or-later
"""The whole analysis of made-up dumps: files, numbers that JSON can carry, dumps that are nearly nothing."""

import json
import re
from dataclasses import replace
from fnmatch import fnmatch
from functools import partial
from math import nan
from pathlib import Path

import numpy as np
import pytest
from made_up import columns_of_discs, flow_context

from lammps_jump.analysis.guess import from_dump
from lammps_jump.analysis.passes import with_velocities
from lammps_jump.analysis.pipeline import Pictures, analyse
from lammps_jump.analysis.quantities import LISTED, QUANTITIES, result_files
from lammps_jump.analysis.tables import main_numbers
from lammps_jump.cli.analyse import analyze
from lammps_jump.dump.exports import export, read_netcdf
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.files import plain
from lammps_jump.scene.walls import Plane

D = 0.2
pytestmark = pytest.mark.usefixtures("blank_pictures")

EVERYTHING = ("jump", "energy", "front", "force")


context = partial(
    flow_context, domain=((-5.0, 45.0), (-5.0, 20.0)), x_range=(0.0, 40.0), walls=(Plane("floor", "y", 0.0, "above"),),
    stiffness=1e6, stiffness_wall=1e6, time_step=1e-3, window=(0.0, 9.0),
)  # fmt: skip


def assert_ours(names):
    """The next run in the folder clears what this one wrote."""
    unknown = [name for name in names if not any(fnmatch(name, pattern) for pattern in result_files())]
    assert all(name.startswith("force_") for name in unknown), unknown


def dump_of(path, frames, columns=("id", "x", "y", "vx", "vy")):
    with DumpWriter(path, columns) as writer:
        for k, (x, y, u) in enumerate(frames):
            x, y, u = (np.atleast_1d(np.asarray(part, float)) for part in (x, y, u))
            values = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": u + 0 * x, "vy": 0 * x}
            writer.write_frame(make_frame(100 * k, 0.1 * k, [[-5, 45], [-5, 20]], values))
    return path


def bore(front):
    x, y = columns_of_discs(lambda centres: np.where(centres < front, 5, 30), 0.0, 40.0, d=D)
    return x, y, np.where(x < front, 12.0, 0.4)


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    path = dump_of(out / "dump.lammpstrj", [bore(25.0 - 0.2 * k) for k in range(12)])
    rows = "".join(f"{0.1 * k + 0.1:g},floor,0,-5,0\n" for k in range(11))
    (out / "forces.csv").write_text("time,structure,fx,fy,moment\n" + rows)
    return out, analyse(context(probes=("floor",)), path, out, EVERYTHING, pictures=Pictures("all"))


def test_one_pass_leaves_all_files_and_numbers(analysed):
    out, parts = analysed
    text = json.dumps(parts, allow_nan=False)
    assert json.loads(text) == parts
    for name in parts["files"]:
        assert (out / name).stat().st_size > 0, name
    expected = {"profiles.nc", "energy.csv", "front.csv", "jump_track.csv", "jump_frame.csv", "jump_stream.csv"}
    assert expected | {"force_floor.csv"} <= set(parts["files"])
    figures = {
        f"figures/{name}.png"
        for name in ("depth_profile", "jump_frame", "jump_stream", "jump_balance", "front", "energy", "forces")
    }
    assert figures <= set(parts["files"])
    curves = json.loads((out / "curves.json").read_text())
    assert {Path(name).stem for name in figures} <= set(curves) and "depth_map" not in curves
    assert_ours(parts["files"])
    assert parts["jump"]["verdict"] == "jump"
    assert parts["jump"]["speed"] == pytest.approx(-2.0, abs=1e-6)  # the file's ten digits
    assert parts["jump"]["momentum_terms"]["pressure"] is not None
    assert parts["force"]["floor"]["impulse"] == pytest.approx(-5.5)
    assert parts["profiles"]["frames"] == 12


def test_energy_of_the_dump(analysed):
    _, parts = analysed
    _, y, u = bore(25.0)
    expected = 0.5 * 40 * np.sum(u**2) + 40 * 9.81 * np.sum(y)
    # columns of discs whose centres are 0.2 m apart to ten digits: contacts store next to nothing
    assert parts["energy"]["initial"] == pytest.approx(expected, rel=1e-8)


def test_two_pictures_are_drawn_unless_all_are_asked_for(tmp_path, blank_pictures_here):
    """The page draws the curves: matplotlib would take longer for its ten figures than the rest of the analysis."""
    path = dump_of(tmp_path / "d", [bore(25.0 - 0.2 * k) for k in range(12)])
    parts = analyse(context(), path, tmp_path / "out", ("jump", "front"))
    pictures = sorted(path.name for path in (tmp_path / "out" / "figures").iterdir())
    assert pictures == ["depth_profile.png", "snapshots.png"]
    assert [f"figures/{name}" for name in pictures] == [name for name in parts["files"] if name.endswith(".png")]


def test_nothing_but_profiles_when_nothing_is_asked(tmp_path):
    path = dump_of(tmp_path / "d", [bore(20.0)])
    parts = analyse(context(), path, tmp_path / "new" / "folder", (), pictures=Pictures("none"))
    assert parts["files"] == ["profiles.nc"]
    assert not {"jump", "front", "energy", "force"} & set(parts)
    assert read_netcdf(tmp_path / "new" / "folder" / "profiles.nc").sizes["time"] == 1


@pytest.mark.parametrize(
    "frames",
    [
        pytest.param([([], [], [])], id="empty frame"),
        pytest.param([([], [], []), ([], [], [])], id="empty frames", marks=pytest.mark.long),
        pytest.param([([1.0], [0.1], [2.0])], id="one disc", marks=pytest.mark.long),
        pytest.param([([], [], []), ([1.0], [0.1], [2.0]), ([], [], [])], id="comes and goes"),
        pytest.param([([1.0, 1.1], [5.0, 5.0], [0.0, 0.0])], id="falling pair", marks=pytest.mark.long),
    ],
)
def test_next_to_nothing(tmp_path, frames):
    """Nulls and reasons instead of numbers, every figure that can be drawn, no warning from numpy (they are errors)."""
    path = dump_of(tmp_path / "d", frames)
    parts = analyse(context(), path, tmp_path, EVERYTHING)
    json.dumps(parts, allow_nan=False)
    assert parts["jump"]["verdict"] == "no jump found"
    assert parts["jump"]["reason"]


def test_window_without_frames_falls_back_and_says_so(tmp_path):
    path = dump_of(tmp_path / "d", [bore(20.0)] * 4)
    parts = analyse(context(window=(50.0, 60.0)), path, tmp_path, (), pictures=Pictures("none"))
    assert any("second half" in warning for warning in parts["warnings"])
    assert parts["profiles"]["window"][1] == pytest.approx(0.3)


def made_velocities(path, flow):
    warnings = []
    return [frame.vx for frame in with_velocities(open_dump(path), flow, warnings)], warnings


def test_velocities_from_positions(tmp_path):
    """A disc that comes has the velocity until the next frame; one that is seen once has none, and never 0."""
    x = ([1.0, 3.0], [1.5, 3.0, 6.0], [2.0, 3.0, 6.2], [2.5, 3.0, 6.4, 9.0])
    frames = [(where, [0.1] * len(where), [0.0] * len(where)) for where in x]
    path = dump_of(tmp_path / "d", frames, columns=("id", "x", "y"))
    made, warnings = made_velocities(path, context())
    for found, right in zip(made, ([5.0, 0.0], [5.0, 0.0, 2.0], [5.0, 0.0, 2.0], [5.0, 0.0, 2.0, nan]), strict=True):
        assert found == pytest.approx(right, nan_ok=True)
    assert "no vx, vy" in warnings[0] and "left out of means" in warnings[0]
    made, warnings = made_velocities(path, replace(context(), velocities=False))
    assert np.isnan(np.concatenate(made)).all() and "without times" in warnings[0]
    parts = analyse(
        from_dump(open_dump(path), diameter=D), path, tmp_path, ("jump", "front"), pictures=Pictures("none")
    )
    assert parts["front"]["position"] is not None
    path = dump_of(tmp_path / "nan", [([1.0, nan], [0.1, 0.1], [0.0, 0.0])], columns=("id", "x", "y"))
    with pytest.raises(DumpError, match=r"step 0, row 2 .*x is nan, not a number"):
        made_velocities(path, context())


def test_a_disc_that_goes_over_the_seam_keeps_its_velocity(tmp_path):
    frames = [([x], [0.1], [0.0]) for x in (39.0, 39.8, 0.6)]
    path = dump_of(tmp_path / "d", frames, columns=("id", "x", "y"))
    flow = context(periodic=True, domain=((0.0, 40.0), (-5.0, 20.0)))
    assert made_velocities(path, flow)[0] == [pytest.approx([8.0])] * 3


def test_the_box_of_a_bare_dump_tells_where_places_repeat(tmp_path):
    """From -5 to 45 m: the disc goes over the side; one that is told to run on does not come back."""
    frames = [([x], [0.1], [0.0]) for x in (44.0, 44.8, -4.4)]
    path = dump_of(tmp_path / "d", frames, columns=("id", "x", "y"))
    path.write_text(path.read_text().replace("BOX BOUNDS ff", "BOX BOUNDS pp"))
    assert made_velocities(path, context())[0] == [pytest.approx([8.0])] * 3
    further = path.with_name("further")
    further.write_text(path.read_text().replace("id x y", "id xu y"))
    assert made_velocities(further, context())[0][-1] == pytest.approx([-492.0])


def test_contact_forces_say_which_velocities_they_take(tmp_path):
    path = dump_of(tmp_path / "d", [([1.0], [0.1], [0.0])] * 2, columns=("id", "x", "y"))
    assert "Forces of contacts take these velocities" in made_velocities(path, context())[1][0]
    assert "Forces of contacts" not in made_velocities(path, context(stiffness=None))[1][0]


def test_a_dump_without_velocities_has_the_means_of_one_with_them(tmp_path):
    """Discs go at 4 m/s through a channel that fills: those that come and the first frame count with what they have."""
    x, y, _ = bore(20.0)
    frames = [(x + 0.4 * k, y, 4.0) for k in range(6)]
    frames = [
        tuple(part[: len(x) - 500 + 100 * k] for part in (x, y, 4.0 + 0 * x)) for k, (x, y, _) in enumerate(frames)
    ]
    found = {}
    for name, columns in {"whole": ("id", "x", "y", "vx", "vy"), "plain": ("id", "x", "y")}.items():
        path = dump_of(tmp_path / name, frames, columns=columns)
        asked = ("energy", "front", "rest")
        found[name] = analyse(context(), path, tmp_path / f"out_{name}", asked, pictures=Pictures("none"))
        with read_netcdf(tmp_path / f"out_{name}" / "profiles.nc") as profiles:
            found[name]["velocity"] = profiles["velocity_mean"].values
    whole, plain = found["whole"], found["plain"]
    assert plain["velocity"] == pytest.approx(whole["velocity"], rel=1e-9, nan_ok=True)
    assert plain["front"]["highest_surface_speed"] == pytest.approx(4.0)
    assert plain["state"]["speed"] == pytest.approx(4.0) == plain["state"]["along"]
    assert plain["energy"]["initial"] == pytest.approx(whole["energy"]["initial"])
    # the discs that come in the last frame are seen once
    assert plain["energy"]["final"] is None and "velocities of some discs are not known" in plain["energy"]["reason"]


def test_nothing_moves_at_0_where_one_frame_tells_no_velocity(tmp_path):
    path = dump_of(tmp_path / "d", [bore(20.0)], columns=("id", "x", "y"))
    asked = (*EVERYTHING, "layers", "rest", "fields")
    parts = analyse(context(), path, tmp_path / "out", asked, pictures=Pictures("none"))
    assert parts["state"]["speed"] is parts["energy"]["kinetic"] is parts["energy"]["initial"] is None
    assert "not known" in parts["rest"]["reason"] and "not known" in parts["layers"]["reason"]
    with read_netcdf(tmp_path / "out" / "profiles.nc") as profiles:
        assert np.isnan(profiles["velocity_mean"]).all() and np.isfinite(profiles["mass_depth_mean"]).any()
    with read_netcdf(tmp_path / "out" / "fields.nc") as fields:
        assert set(fields.data_vars) == {"density", "contact_xx", "contact_xy", "contact_yy", "hydrostatic"}


def test_unknown_export_is_refused(tmp_path):
    path = dump_of(tmp_path / "d", [bore(20.0)])
    with pytest.raises(DumpError, match=r"export 'xls' is not known: use one of csv, vtk, pictures"):
        export(tmp_path, ("xls",))
    with pytest.raises(
        DumpError, match=r"quantity .ripples. is not known: use jump, grade, .*, overtopping, depth or fields"
    ):
        analyse(context(), path, tmp_path, ("ripples",))


def test_exports_and_fields(tmp_path):
    path = dump_of(tmp_path / "dump.lammpstrj", [bore(20.0)] * 2)
    parts = analyse(context(), path, tmp_path, ("fields",), pictures=Pictures("none"))
    files = [*parts["files"], *(written.name for written in export(tmp_path, ("csv", "vtk", "pictures")))]
    assert {"fields.nc", "fields.vti", "profiles.csv", "picture0.dat", "discs.pvd"} <= set(files)
    assert_ours(files)
    assert all((tmp_path / name).exists() for name in files)
    assert re.findall(r'timestep="([^"]+)"', (tmp_path / "discs.pvd").read_text()) == ["0", "0.1"]


def test_an_export_of_an_analysis_needs_one(tmp_path):
    dump_of(tmp_path / "dump.lammpstrj", [bore(20.0)])
    assert [path.name for path in export(tmp_path, ("pictures",), tmp_path / "elsewhere")] == ["picture0.dat"]
    with pytest.raises(DumpError, match=r"profiles\.nc: cannot be read .*lammps-jump analyze"):
        export(tmp_path, ("vtk",))


def test_the_screen_shows_the_labelled_numbers(analysed):
    lines = main_numbers(analysed[1])
    assert [line.split(":")[0] for line in lines] == ["Hydraulic jump", "jump", "front", "energy", "doubtful"]
    assert lines[1].startswith("jump: verdict jump, Fr1 ") and ", shock speed -2 m/s," in lines[1]
    assert "Compare the " in lines[0] and "by Bélanger" in lines[0] and "Too few frames for errors" in lines[0]
    assert main_numbers({"jump": {"verdict": "drowned inlet", "y1": None}}) == ["jump: verdict drowned inlet"]
    lossy = {"initial": 10.0, "max_deviation": 0.75, "drift": -0.5, "conservative": False}
    assert main_numbers({"energy": lossy}) == ["energy: at the start 10 J/m"]  # no errors of the engine
    assert "deviation 0.75, drift -0.5" in main_numbers({"energy": {**lossy, "conservative": True}})[1]


def test_no_jump_has_no_length_on_the_screen():
    found = {"y2": 3.0, "y2_error": 0.1, "speed": -1.0, "speed_error": 0.2, "length": 5.0, "length_error": None}
    assert (
        "y2 3.00 ± 0.10 m, shock speed -1.00 ± 0.20 m/s, length 5"
        in main_numbers({"jump": {"verdict": "jump", **found, "lower_bounds": []}})[0]
    )
    untold = {"verdict": "jump", **found, "lower_bounds": ["y2"]}
    assert "y2 3.00 ± at least 0.10 m, shock speed -1.00 ± 0.20 m/s, length 5" in main_numbers({"jump": untold})[0]
    assert main_numbers({"jump": {"verdict": "locked heap", **found, "lower_bounds": []}}) == [
        "jump: verdict locked heap, shock speed -1.00 ± 0.20 m/s"
    ]
    assert "length" not in main_numbers({"jump": {"verdict": "marginal jump", **found}})[0]


def test_plain():
    given = {"a": np.float64("nan"), 1: [np.int64(3), float("inf"), np.array([1.0, np.nan])], "b": np.bool_(True)}
    assert plain(given) == {"a": None, "1": [3, None, [1.0, None]], "b": True}


def test_the_command_says_once_what_it_guessed_of_a_bare_dump(tmp_path, capsys, blank_pictures_here):
    dump_of(tmp_path / "dump.flow", [bore(20.0)] * 2)
    analyze(targets=[tmp_path], density=1000.0)
    said = capsys.readouterr().out.splitlines()
    notes = [text for text in said if text.startswith("note: ")]
    parts = json.loads((tmp_path / "dump_analysis" / "summary.json").read_text())
    assert len(notes) == len(set(notes)) == len(parts["warnings"])
    for guess in ("Diameter guessed as 0.2 m", "Gravity taken as 9.81", "Floor taken at y = "):
        assert sum(guess in note for note in notes) == 1
    assert (tmp_path / "dump_analysis" / "summary.json").exists() and "dump_analysis" in said[-1]


def test_what_an_analysis_makes_stands_in_its_row():
    """The marker of a run folder names it before any analysis is loaded."""
    for name, row in LISTED.items():
        made = {made.replace("*", name) for made in row.makes}
        assert made == {*QUANTITIES[name].files, *QUANTITIES[name].captions}, name
