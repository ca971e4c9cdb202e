# SPDX-License-Identifier: GPL-2.0-or-later
"""Dumps of other programs: without times, with types in place of radii, in files of a frame each."""

import json
from math import sqrt

import numpy as np
import pytest
from made_up import call, columns_of_discs

from lammps_jump.analysis import pipeline
from lammps_jump.analysis.draw import film
from lammps_jump.analysis.guess import from_dump
from lammps_jump.analysis.passes import gather
from lammps_jump.analysis.pipeline import Pictures, analyse
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.analysis.verdicts import headline, verdict
from lammps_jump.dump.exports import read_netcdf
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.runs.results import AnalysisInputs, analyse_dump

pytestmark = pytest.mark.usefixtures("blank_pictures")

D, STEP = 0.2, 2e-4
COLUMNS = ("id", "x", "y", "vx", "vy")


def bore(folder, columns=COLUMNS, *, timed=False, name="flow_7.lammpstrj", frames=20):
    """A step of 6 m of depth that runs upstream at 1 m/s into a stream of 1 m; a frame every 500 steps of 0.2 ms."""
    with DumpWriter(folder / name, columns) as writer:
        for k in range(frames):
            front = 25 - 0.1 * k
            x, y = columns_of_discs(lambda at, front=front: np.where(at < front, 5, 30), 0.0, 40.0, d=D)
            values = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": np.where(x < front, 12.0, 1.5), "vy": 0 * x}
            writer.write_frame(make_frame(500 * k, 500 * k * STEP if timed else None, [[-5, 45], [-5, 20]], values))
    return folder / name


def analysed(path, **given):
    folder = analyse_dump(path, None, AnalysisInputs(D, **given))[1]
    return json.loads((folder / "summary.json").read_text()), folder


@pytest.mark.parametrize(
    "columns",
    [pytest.param(COLUMNS, id="velocities", marks=pytest.mark.long), pytest.param(COLUMNS[:3], id="no velocities")],
)
def test_without_times_nothing_is_made_of_steps(tmp_path, columns):
    found, folder = analysed(bore(tmp_path, columns))
    assert found["profiles"]["axis"] == "step" and found["profiles"]["last_time"] == 500 * 19
    jump, front = found["jump"], found["front"]
    assert jump["y1"] == pytest.approx(1, rel=0.02) and jump["y2"] == pytest.approx(6, rel=0.02)
    assert jump["local"]["sequent_ratio"] == pytest.approx(6, rel=0.03) and jump["length"] > 0
    made = {"time", "members", "drift", "budget", "stream", "mass", "momentum_terms", "head_lost", "class", "speed"}
    made |= {key for key in jump if any(word in key for word in ("froude", "belanger", "head_", "energy", "momentum"))}
    made |= {key for key in jump if "speed" in key}
    assert {key: jump[key] for key in made} == dict.fromkeys(made)
    assert jump["local"]["froude"] is jump["local"]["belanger_y2"] is jump["local"]["energy_loss"] is None
    assert front["position"] is not None
    for key in ("time", "speed", "arrival_time", "ritter", "martin_moyce"):
        assert front[key] is None
    known = "vx" in columns
    assert (jump["local"]["u1"] is None, front["highest_surface_speed"] is None) == (not known, not known)
    profiles = read_netcdf(folder / "profiles.nc")
    assert profiles.time.attrs == {"units": "1", "long_name": "step"}
    assert bool(np.isfinite(profiles.velocity).any()) is known
    for table in ("front.csv", "jump_track.csv"):
        assert (folder / table).read_text().startswith("step,")
    page = (folder / "report.html").read_text()
    assert "speed, Froude number and head are not known" in page
    assert "The front of the discs is at 40.00 m at the last frame." in headline({"front": front})
    curves = json.loads((folder / "curves.json").read_text())
    assert "martin_moyce" not in curves and "jump_frame" not in curves
    assert curves["jump_track"]["x"] == curves["front"]["x"] == "Step" and not curves["front"]["time"]


@pytest.mark.long
def test_a_given_time_step_is_as_good_as_times(tmp_path):
    for name in ("with", "without"):
        (tmp_path / name).mkdir()
    timed, _ = analysed(bore(tmp_path / "with", timed=True))
    found, _ = analysed(bore(tmp_path / "without"), time_step=STEP)
    # a column of discs becomes deep at once: the front moves by whole discs
    assert found["jump"]["speed"] == pytest.approx(-1, rel=0.05) and found["jump"]["froude"] > 1
    assert found["given"]["time_step"] == STEP
    for part in ("jump", "front", "profiles"):
        numbers = {key: value for key, value in timed[part].items() if isinstance(value, float)}
        assert {key: found[part][key] for key in numbers} == pytest.approx(numbers, rel=1e-6, abs=1e-9)
    again, _ = analysed(tmp_path / "with" / "flow_7.lammpstrj", time_step=1.0)
    assert again["jump"] == timed["jump"] and any("its own times" in note for note in again["warnings"])


def test_the_title_is_the_file_name_and_units_are_told(tmp_path):
    path = bore(tmp_path, frames=2)
    assert from_dump(open_dump(path), diameter=D).title == "flow_7.lammpstrj"
    path.write_text(path.read_text().replace("UNITS\nsi", "UNITS\nlj"))
    assert any("units 'lj'" in note for note in from_dump(open_dump(path), diameter=D).notes)


def types(folder, kinds, name="dump"):
    with DumpWriter(folder / name, ("id", "type", "x", "y", "vx", "vy")) as writer:
        x = 0.5 + np.arange(len(kinds))
        columns = {"id": x, "type": kinds, "x": x, "y": 0 * x + 1, "vx": 0 * x, "vy": 0 * x}
        writer.write_frame(make_frame(0, 0.0, [[0, 10], [0, 5]], columns))
    return open_dump(folder / name)


def test_types_have_diameters(tmp_path):
    dump = types(tmp_path, [1, 2, 2])
    flow = from_dump(dump, diameter={1: 0.4, 2: 0.2}, density=900.0, bin_width=1.0)
    assert flow.sized and flow.scene.diameter == pytest.approx(sqrt(0.24 / 3))
    np.testing.assert_array_equal(flow.radii(dump[0]), [0.2, 0.1, 0.1])
    assert flow.bed_height(1.0) == pytest.approx(0.8) and flow.x_range == pytest.approx((0.3, 2.6))
    assert float(compute_profiles(dump, flow).mass_total[0]) == pytest.approx(900 * 0.24)
    same = from_dump(dump, diameter={1: 0.3, 2: 0.3})
    assert not same.sized and same.scene.diameter == 0.3
    with pytest.raises(DumpError, match=r"a disc has type 2; a diameter is given for 1, 3 only"):
        from_dump(dump, diameter={1: 0.3, 3: 0.2})
    with pytest.raises(DumpError, match="no column 'type'"):
        from_dump(open_dump(bore(tmp_path, frames=1)), diameter={1: 0.3, 3: 0.2})


def test_the_command_takes_files_of_a_frame_units_and_types(monkeypatch, capsys, tmp_path):
    for step in range(0, 1500, 500):
        with DumpWriter(tmp_path / f"flow.{step}.lammps", ("id", "type", "x", "y")) as writer:
            x, y = columns_of_discs(lambda at, step=step: np.where(at < 25 - step / 1000, 5, 30), 0.0, 40.0, d=D)
            values = {"id": np.arange(len(x)) + 1, "type": 1 + np.arange(len(x)) % 2, "x": x, "y": y}
            writer.write_frame(make_frame(step, None, [[-5, 45], [-5, 20]], values))
    monkeypatch.chdir(tmp_path)
    options = ["--diameter", "1=20 cm,2=0.21", "--time-step", "0.2 ms", "--bin-width", "50 cm"]
    for files in (["flow.*.lammps"], sorted(path.name for path in tmp_path.glob("flow.*"))):
        status, said, message = call(monkeypatch, capsys, "analyze", *files, *options)
        assert status == 0, message
        assert "A dump of 3000 discs, of whose scene nothing is known" in said and "note: Gravity taken" in said
        assert "report: flow_analysis/report.html" in said
        found = json.loads((tmp_path / "flow_analysis" / "summary.json").read_text())
        assert found["name"] == "flow.*.lammps" and found["profiles"]["frames"] == 3
        assert found["given"] == {"diameter": {"1": 0.2, "2": 0.21}, "time_step": 2e-4, "bin_width": 0.5}
        assert found["front"]["time"] == pytest.approx(1000 * STEP)
        page = (tmp_path / "flow_analysis" / "report.html").read_text()
        assert "--diameter 1=0.2,2=0.21 --time-step 0.0002 --bin-width 0.5" in page
    status, said, _ = call(monkeypatch, capsys, "analyze", *files, *options, "--quiet")
    assert (status, said) == (0, "")


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--diameter", "1=20 kg", "expected a number in m"), ("--diameter", "one=0.2", "write 1=0.2,2=0.1"),
        ("--diameter", "1=0.2,2", "several types"), ("--diameter", "1=0.2,2=-1", "allowed is > 0 m"),
        ("--time-step", "0.1 m", "expected a number in s"), ("--time-step", "0", "allowed is > 0 s"),
        ("--density", "1 g", "expected a number in kg/m^3"), ("--bin-width", "wide", "expected a number in m"),
        ("--gravity", "0", "allowed is > 0 m/s^2"),
    ],
)  # fmt: skip
def test_options_that_say_nothing(monkeypatch, capsys, tmp_path, option, value, said):
    path = bore(tmp_path, frames=1)
    status, _, message = call(monkeypatch, capsys, "analyze", path, option, value)
    flat = " ".join(message.replace("│", " ").split())
    assert status == 2 and option in flat and said in flat
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def overfall(folder, frames=12, **more):
    """A bore as `bore`, whose tail water meets a sill of 2 m at x = 30 m and falls 6 m deep beyond x = 31 m."""
    with DumpWriter(folder / "fall", (*COLUMNS, *more)) as writer:
        for k in range(frames):
            front = 15 - 0.1 * k
            stream = columns_of_discs(lambda at, front=front: np.where(at < front, 5, 30), 0.0, 30.0, d=D)
            above = columns_of_discs(15, 30.0, 31.0, d=D, bed=2.0)
            fall = 31.1 + np.arange(20) * D, 4.0 - 0.025 * np.arange(20) ** 2
            x, y = np.hstack([stream, above, fall])
            values = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": np.where(x < front, 12.0, 1.5), "vy": 0 * x}
            values |= {name: made(x) for name, made in more.items()}
            writer.write_frame(make_frame(500 * k, 0.1 * k, [[-5, 45], [-5, 20], [-2, 2]], values))
    return folder / "fall"


def test_the_floor_ends_before_a_sill_and_a_fall(tmp_path):
    flow = from_dump(open_dump(overfall(tmp_path)), diameter=D)
    assert flow.bed_height(np.array([0.1, 15, 29.9])) == pytest.approx(0, abs=1e-6), "not the lowest falling disc"
    assert np.isnan(flow.bed_height(np.array([30.1, 33]))).all()
    assert any("It runs from x = 0 to 30 m" in note for note in flow.notes)
    found = analyse(flow, tmp_path / "fall", tmp_path / "made", ["jump"], pictures=Pictures("none"))
    tail = found["jump"]["tail"]
    # 3 m are half a depth: the tail water ends before the sill, and has its 6 m
    assert (found["jump"]["at"], found["jump"]["y2"]) == ("tail water", pytest.approx(6, rel=1e-3))
    assert tail["length"] < 30 - 3 - 15
    assert found["jump"]["y2"] == pytest.approx(6, rel=0.02)


def test_a_level_floor_without_a_fall_is_endless(tmp_path):
    flow = from_dump(open_dump(bore(tmp_path)), diameter=D)
    assert flow.bed_height(np.array([-100.0, 100.0])) == pytest.approx(0, abs=1e-6)


def test_a_flow_of_three_dimensions_is_refused(tmp_path, monkeypatch, capsys):
    layer = overfall(tmp_path, frames=2, z=lambda x: 0.1 * np.sin(x))
    assert from_dump(open_dump(layer), diameter=D).scene.diameter == D
    status, _, message = call(monkeypatch, capsys, "analyze", layer, "--diameter", 0.15)
    assert status == 2 and "a flow in three dimensions; allowed is one layer of discs" in message
    assert "z runs from -0.0999" in message and [path.name for path in tmp_path.iterdir()] == ["fall"]


def test_discs_behind_each_other_are_told(tmp_path):
    path = bore(tmp_path, frames=2)
    for diameter, told in ((D, False), (2.5 * D, True)):
        warnings: list[str] = []
        gather(open_dump(path), from_dump(open_dump(path), diameter=diameter), [], warnings)
        assert any("times the area below the surface" in note for note in warnings) is told


def test_gravity_is_given_or_that_of_the_units_and_told(tmp_path):
    path = bore(tmp_path, frames=2)
    assert from_dump(open_dump(path), diameter=D, gravity=1.62).scene.gravity == (0.0, -1.62)
    for units, gravity in (("si", "9.81"), ("cgs", "981"), ("lj", "9.81")):
        path.write_text(path.read_text().replace("UNITS\nsi", f"UNITS\n{units}"))
        flow = from_dump(open_dump(path), diameter=D)
        assert flow.gravity == float(gravity)
        assert any(f"Gravity taken as {gravity} m/s2" in note and "--gravity" in note for note in flow.notes)
        path.write_text(path.read_text().replace(f"UNITS\n{units}", "UNITS\nsi"))


def test_a_guessed_diameter_says_that_it_is_the_smallest(tmp_path):
    for name, usual, told in (("equal", D, False), ("several", 1.1 * D, True)):
        with DumpWriter(tmp_path / name, COLUMNS) as writer:
            x = np.cumsum(np.where(np.arange(100) < 10, D, usual))
            values = {"id": np.arange(100) + 1, "x": x, "y": 0 * x, "vx": 0 * x, "vy": 0 * x}
            writer.write_frame(make_frame(0, 0.0, [[-5, 45], [-5, 20]], values))
        notes = from_dump(open_dump(tmp_path / name)).notes
        assert any(f"guessed as {D:.6g} m" in note and "All discs count as equal" in note for note in notes)
        assert any("the guess is that of the smallest" in note for note in notes) is told


def test_a_steady_flow_is_no_collapsed_column(tmp_path):
    with DumpWriter(tmp_path / "jet", COLUMNS) as writer:
        for k in range(12):
            x = np.arange(0.1, 12, 1.0) + 0.5 * k % 1.0
            y = np.where(x < 8, 0.1, 0.1 - 0.5 * (x - 8) ** 2)
            ids = np.arange(12) + 100 - (k // 2)
            values = {"id": ids, "x": x, "y": y, "vx": 0 * x + 5, "vy": 0 * x}
            writer.write_frame(make_frame(500 * k, 0.1 * k, [[-5, 45], [-20, 20]], values))
    found = analyse(
        from_dump(open_dump(tmp_path / "jet"), diameter=D),
        tmp_path / "jet",
        tmp_path,
        ["front"],
        pictures=Pictures("none"),
    )
    assert found["front"]["column_base"] is found["front"]["ritter"] is found["front"]["martin_moyce"] is None
    assert "collapsed" not in headline(found) and "The front of the discs is at" in headline(found)
    assert verdict(found).startswith("The front of the discs is at")


def test_results_of_a_dump_open_in_the_other_commands(tmp_path, monkeypatch, capsys):
    """Films and figures are empty files here: drawing them takes seconds and is tested elsewhere."""

    def draw_figures(names, shown, folder, dump, flow, ending="png", **_):
        folder.mkdir(exist_ok=True)
        for name in names:
            (folder / f"{name}.{ending}").write_text(f"{flow.bin_width} {len(open_dump(dump))}")

    monkeypatch.setattr(pipeline, "draw_figures", draw_figures)
    monkeypatch.setattr(film, "animate", lambda dump, flow, path, **_: path.write_text(f"{flow.bin_width} {len(dump)}"))
    monkeypatch.setattr(film, "has_ffmpeg", lambda: True)
    monkeypatch.chdir(tmp_path)
    analyse_dump(bore(tmp_path, timed=True, frames=9), None, AnalysisInputs(D, bin_width=0.5))
    made, drawn = "flow_7_analysis", "0.5 9"  # the flow as it was analysed
    for arguments, file, said in (
        (("export", made, "--csv", "--vtk", "--pictures"), f"{made}/picture8.dat", ""),
        (("animate", made), f"{made}/animation.mp4", drawn),
        (("figures", made), f"{made}/figures/jump_track.png", drawn),
        (("compare", made, made, "--out", "page.html"), "page.html", "Velocity of the front"),
    ):
        status, out, message = call(monkeypatch, capsys, *arguments)
        assert (status, message) == (0, ""), arguments
        assert file in out.split() and said in (tmp_path / file).read_text()
    assert (tmp_path / "page.html").read_text().count('class="player"') == 2
    status, _, message = call(monkeypatch, capsys, "export", "flow_7.lammpstrj", "--csv")
    assert status == 2 and "is a dump; allowed is a run folder or the folder of a dump's results" in message
    (tmp_path / "flow_7.lammpstrj").unlink()
    status, _, message = call(monkeypatch, capsys, "figures", made)
    assert status == 2 and "flow_7.lammpstrj, which is no longer there" in message


GRAIN = 0.015
"""Diameter of spheres in a box, m."""


def spheres(folder, *, density=2500.0, mass=lambda d, rho: np.pi / 6 * rho * d**3, radius=True, layers=8, frames=5):
    """A bed of discs in squares in a box, as LAMMPS' ``atom_style sphere`` writes it: mass and radius in columns."""
    x, y = columns_of_discs(layers, 0.0, 0.6, d=GRAIN)
    more = {"mass": mass(GRAIN, density) + 0 * x} | ({"radius": 0.5 * GRAIN + 0 * x} if radius else {})
    with DumpWriter(folder / "pour.dump", (*COLUMNS, *more)) as writer:
        for k in range(frames):
            values = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": 0 * x, "vy": 0 * x} | more
            writer.write_frame(make_frame(500 * k, 0.5 * k, [[-0.1, 0.7], [-0.1, 0.9]], values))
    return folder / "pour.dump"


CYLINDERS, THESIS = (lambda d, rho: np.pi / 4 * rho * d**2), (lambda d, rho: rho * d**2)


@pytest.mark.parametrize(
    ("mass", "said", "per_width"),
    [
        (lambda d, rho: np.pi / 6 * rho * d**3, "Bodies: spheres of 2500 kg/m3", np.pi / 6 * 2500 * GRAIN**2),
        (CYLINDERS, "Bodies: cylinders of 2500 kg/m3 or discs of 1963 kg/m3", np.pi / 4 * 2500 * GRAIN**2),
        (THESIS, "Bodies: cylinders of 3183 kg/m3 or discs of 2500 kg/m3", 2500 * GRAIN**2),
    ],
    ids=["spheres", "cylinders", "discs"],
)
def test_bodies_are_told_and_depths_by_mass_do_not_depend_on_them(tmp_path, mass, said, per_width):
    flow = from_dump(open_dump(spheres(tmp_path, mass=mass)))
    assert any(note.startswith(said) for note in flow.notes), flow.notes
    assert flow.scene.mass == pytest.approx(per_width)
    found = compute_profiles(open_dump(tmp_path / "pour.dump"), flow)
    inside = slice(1, -1)
    assert found.mass_depth_mean.values[inside] == pytest.approx(8 * GRAIN, rel=1e-6)
    assert found.surface_depth_mean.values[inside] == pytest.approx(8 * GRAIN, rel=0.02)
    assert float(found.mass_total[0]) == pytest.approx(8 * 40 * per_width)


def test_bodies_that_are_not_told_are_asked_for(tmp_path):
    path = open_dump(spheres(tmp_path, mass=lambda d, rho: 1e-6))
    flow = from_dump(path)
    assert any("Say which with --bodies" in note for note in flow.notes)
    assert any("Bodies: spheres of" in note for note in from_dump(path, kind="spheres").notes)
    assert not any("g and cm" in note for note in flow.notes)
    (tmp_path / "cgs").mkdir()
    in_cgs = from_dump(open_dump(spheres(tmp_path / "cgs", density=2.5)))
    assert any("In g and cm that is usual: numbers are taken for m, s and kg" in note for note in in_cgs.notes)
    with pytest.raises(DumpError, match=r"density = 1000 kg/m3: masses of 1e-06 kg .* are those of spheres of 0\.56"):
        from_dump(path, density=1000.0)
    bare = from_dump(open_dump(bore(tmp_path, frames=1)), kind="cylinders", density=1000.0, diameter=D)
    assert bare.scene.mass == pytest.approx(np.pi / 4 * 1000 * D**2)


def test_a_dump_whose_depths_contradict_each_other_is_refused(tmp_path, monkeypatch, capsys):
    for diameter, said in ((1.5 * D, "overlap, or lie behind each other"), (0.5 * D, "discs lie packed 0.2 m apart")):
        path = bore(tmp_path, timed=True, frames=4)
        status, _, message = call(monkeypatch, capsys, "analyze", path, "--diameter", diameter)
        assert status == 2 and said in message and "--diameter" in message, message
        assert [entry.name for entry in tmp_path.iterdir()] == [path.name], "nothing is left"
    found, _ = analysed(path)
    assert found["depth"]["ratio"] == pytest.approx(1, abs=0.02)


def test_a_dump_of_grains_is_asked_for_a_heap(tmp_path, monkeypatch, capsys):
    path = spheres(tmp_path)
    status, said, message = call(monkeypatch, capsys, "analyze", path, "--heap", "--rest", "--layers")
    assert status == 0, message
    assert "ydraulic" not in said and "A bed of 0.12 m is at rest." in said
    folder = tmp_path / "pour_analysis"
    found = json.loads((folder / "summary.json").read_text())
    assert found["heap"]["height"] == pytest.approx(8 * GRAIN, rel=0.01) and found["rest"]["time"] == 0.0
    assert found["layers"]["packing"] == pytest.approx(np.pi / 4, rel=0.02)
    assert "jump" not in found and found["given"] == {"analyses": ["layers", "heap", "rest"]}
    assert "lammps-jump analyze pour.dump --layers --heap --rest" in (folder / "report.html").read_text()
    status, said, message = call(monkeypatch, capsys, "figures", folder)
    assert status == 0 and "figures/heap.png" in said and "jump_track" not in said, message
