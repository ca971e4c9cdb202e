# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies, lids and tailgates of runs that begin from others: where they begin, and that they go on as in one run."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up import call, choose_to_stop_at, plugin_or_skip, reseal

import lammps_jump as lj
from lammps_jump.analysis.draw.preview import scene_drawing
from lammps_jump.case import earlier
from lammps_jump.dump.ended import read_ended
from lammps_jump.dump.find import read_dump
from lammps_jump.engines import choice
from lammps_jump.errors import CaseError, DumpError, RunInterrupted
from lammps_jump.files import BODIES, END_FILE, POSES, read_arrays, write_arrays
from lammps_jump.scene.meeting import corner_names

D = 0.1
LAW = {
    "restitution": 0.4, "friction": 0.4, "friction_law": "history", "impact_speed": 8, "largest_overlap": 0.05,
    "rotation": True, "rolling": {"friction": 0.1},
}  # fmt: skip
SLED = {"name": "sled", "kind": "block", "x": [1.0, 1.6], "y": [0.0, 0.3], "density": 2500, "velocity": [1.5, 0]}
WEDGE = {"name": "wedge", "kind": "polygon", "points": [[1.1, 0.35], [1.6, 0.35], [1.3, 0.8]], "density": 2000,
         "spin": 60}  # fmt: skip
BALL = {"name": "ball", "kind": "circle", "centre": [2.2, 0.25], "radius": 0.2, "mass": 150, "velocity": [-1, 0]}
FLAP = {"name": "flap", "kind": "block", "x": [2.6, 2.7], "y": [0.05, 0.8], "density": 1500, "hinge": [2.65, 0.8],
        "from": 0.031, "spin": 90}  # fmt: skip
CROWD = {
    "name": "crowd",
    "discs": {"diameter": D, "density": 2000, "sizes": {"kind": "uniform", "spread": 0.2}},
    "contact": LAW,
    "domain": {"x": [-1, 6], "y": [-1, 4]},
    "walls": [
        {"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"},
        {"name": "left", "kind": "plane", "axis": "x", "at": 0, "side": "above"},
        {"name": "right", "kind": "plane", "axis": "x", "at": 3, "side": "below"},
        {"name": "lid", "kind": "block", "x": [0.1, 0.7], "y": [0.85, 0.95],
         "motion": {"kind": "load", "mass": 200, "force": [0, -4000]}},
    ],
    "bodies": [SLED, WEDGE, BALL, FLAP],
    "initial": [{"kind": "column", "x": [0.05, 0.95], "y": [0.05, 0.8], "gate": False}],
    "run": {"duration": 0.2, "output_interval": 0.05, "dump_format": "binary"},
    "analysis": {"figures": "none"},
    "engine": {"name": "native"},
}  # fmt: skip
"""Discs that push a sled, upon which a wedge lies; a ball that rolls, a flap that swings, and a lid on the discs."""
COMPILED = {"engine": {"name": "lammps", "kernel": "compiled"}}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("crowds")


@pytest.fixture(scope="module")
def first(place):
    """A run that ends while all moves."""
    return lj.load_case(CROWD).run(place / "first")


def table(run, name: str, columns: slice) -> list[list[str]]:
    """Rows of a table of a run without their times."""
    return [line.split(",")[1:][columns] for line in (run.folder / name).read_text().splitlines()[1:]]


def walls_of(run) -> list[list[str]]:
    """Names and poses, with all digits."""
    return table(run, POSES, slice(0, 4))


def bodies_of(run) -> list[list[str]]:
    """Names, places and velocities; forces are means over the time before."""
    return table(run, BODIES, slice(0, 7))


def numbers(rows: list[list[str]]) -> np.ndarray:
    return np.array([row[1:] for row in rows], float)


def same_bytes(whole, rest, frames: int):
    """The second run is the end of the first, in all digits, and much has moved since."""
    one, two = read_dump(whole.folder), read_dump(rest.folder)
    assert len(two) == frames
    for index in range(-frames, 0):
        pair = one[len(one) + index].sorted(), two[frames + index].sorted()
        for name in ("x", "y", "vx", "vy"):
            assert pair[0].column(name).tobytes() == pair[1].column(name).tobytes(), (index, name)
    for rows in (walls_of, bodies_of):
        assert rows(whole)[-len(rows(rest)) :] == rows(rest)


# --- the same motion --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "begun"),
    [
        ({}, 0.1875),
        *(pytest.param({"friction_law": law, "rolling": None}, 0.25, marks=pytest.mark.long)
          for law in ("viscous", "sign")),
        *(pytest.param({}, begun, marks=pytest.mark.long) for begun in (0.0625, 0.125, 0.25, 0.5, 1.0)),
    ],
)  # fmt: skip
def test_native_goes_on_with_the_same_bytes(place, law, begun):
    """Discs, bodies and a lid, with springs and with the leap-frog, while they collide and when they rest."""
    folder = place / f"{law.get('friction_law')}_{begun}"
    case = lj.load_case(CROWD, {"contact": {**LAW, **law}, "run.duration": begun, "run.output_interval": begun / 4})
    run, whole = case.run(folder / "first"), case.replace({"run.duration": 2 * begun}).run(folder / "whole")
    rest = case.after(run).run(folder / "rest")
    same_bytes(whole, rest, 5)
    assert np.abs(numbers(walls_of(whole))[-5:] - numbers(walls_of(whole))[-25:-20]).max() > 0.01 * D


def test_a_tailgate_goes_on_with_the_same_bytes(place):
    """Its height, its speed and its turns: it looks next when it would have looked in one run."""
    case = lj.load_case({
        "name": "basin", "discs": {"diameter": 0.1, "density": 1000, "sizes": {"kind": "uniform", "spread": 0.2}},
        "contact": {"restitution": 0.3, "friction": 0, "impact_speed": 5},
        "domain": {"x": [-1, 4], "y": [-1, 3]},
        "walls": [{"name": "box", "kind": "box", "x": [0, 3], "y": [0, 3]},
                  {"name": "sill", "kind": "block", "x": [1.5, 1.7], "y": [-0.5, 0.5],
                   "motion": {"kind": "hold", "depth": 0.3, "at": 0.8, "speed": 0.5, "range": [-0.4, 1],
                              "response": 0.5}}],
        "initial": [{"kind": "column", "x": [0, 1.4], "y": [0, 0.8], "gate": False}],
        "run": {"duration": 0.23, "output_interval": 0.23, "dump_format": "binary"}, "engine": {"name": "native"},
        "analysis": {"figures": "none"},
    })  # fmt: skip
    run = case.run(place / "basin")
    whole = case.replace({"run.duration": 0.46}).run(place / "basin_whole")
    rest = case.after(run).run(place / "basin_rest")
    assert "tailgate 'sill' goes on from" in " ".join(case.after(run).check().begins)
    one, two = read_dump(whole.folder), read_dump(rest.folder)
    assert one[2].sorted().x.tobytes() == two[1].sorted().x.tobytes()
    assert walls_of(whole)[1:] == walls_of(rest) and abs(numbers(walls_of(rest))[0, 1]) > 0.01
    row = read_ended(run.folder / END_FILE).walls.row("sill")
    assert row["since"] > 0 and row["area"] > 0


@pytest.mark.lammps
def test_compiled_styles_go_on_as_one_run(place):
    plugin_or_skip()
    case = lj.load_case(CROWD, COMPILED).replace({"run.duration": 0.21, "run.output_interval": 0.035})
    run, whole = case.run(place / "c1"), case.replace({"run.duration": 0.245}).run(place / "c2")
    rest = case.after(run).replace({"run.duration": 0.035}).run(place / "c12")
    assert 980 < rest.result.steps < 1000
    for rows in (walls_of, bodies_of):
        count, digits = len(rows(rest)), 1e-9 * D if rows is walls_of else 1e-6
        assert numbers(rows(whole)[-count:]) == pytest.approx(numbers(rows(rest)), abs=digits)
    ends = (
        np.column_stack([frame.x, frame.y]) for frame in (read_dump(one.folder)[-1].sorted() for one in (whole, rest))
    )
    assert np.abs(np.subtract(*ends)).max() < 1e-9 * D
    held = (place / "c12" / "in.plugin.lammps").read_text()
    assert "went " in held


@pytest.mark.lammps
def test_a_run_goes_from_engine_to_engine_and_back(first, place):
    """Native, compiled, native: bodies and what their corners remember come along each time."""
    plugin_or_skip()
    short = {"run.duration": 0.05, "run.output_interval": 0.05}
    between = lj.load_case(CROWD, short).replace(COMPILED).after(first).run(place / "there")
    back = lj.load_case(CROWD, short).after(between).run(place / "back")
    alone = lj.load_case(CROWD, {**short, "run.duration": 0.1}).after(first).run(place / "alone")
    assert back.result.engine == "native" and between.result.kernel == "compiled"
    assert numbers(walls_of(back)[-5:]) == pytest.approx(numbers(walls_of(alone)[-5:]), abs=1e-9 * D)
    assert np.abs(numbers(walls_of(back)[-5:]) - numbers(walls_of(first)[-5:])).max() > 0.01 * D


@pytest.mark.long
@pytest.mark.lammps
def test_ranks_agree_and_a_stopped_run_goes_on(first, place):
    plugin_or_skip()
    case = lj.load_case(CROWD, COMPILED).replace({"run.duration": 0.1}).after(first)
    one, two = (case.replace({"engine.ranks": ranks}).run(place / f"ranks_{ranks}") for ranks in (1, 2))
    assert two.summary["ranks"] == 2
    assert numbers(walls_of(one)) == pytest.approx(numbers(walls_of(two)), abs=1e-9 * D)
    with pytest.MonkeyPatch.context() as patch, pytest.raises(RunInterrupted):
        patch.setattr(choice, "choose", choose_to_stop_at(1000))
        case.run(place / "part")
    on = case.run(place / "part", resume=True)
    assert numbers(walls_of(one)) == pytest.approx(numbers(walls_of(on)), abs=1e-9 * D)


def test_a_run_that_goes_on_is_resumed_and_stays_whole(first, tmp_path):
    """Its folder holds the bodies that it began with; the bits are those of a run that was not stopped."""
    shutil.copytree(first.folder, tmp_path / "first")
    path = tmp_path / "next.yaml"
    path.write_text(yaml.safe_dump(CROWD | {"initial": [{"kind": "run", "folder": "first"}]}))
    case = lj.load_case(path, {"run.duration": 0.1})
    whole = case.run(tmp_path / "whole")
    with pytest.MonkeyPatch.context() as patch, pytest.raises(RunInterrupted):
        patch.setattr(choice, "choose", choose_to_stop_at(500))
        case.run(tmp_path / "part")
    shutil.rmtree(tmp_path / "first")
    earlier.KNOWN.clear()
    on = lj.load_case(tmp_path / "part").run(tmp_path / "part", resume=True)
    same_bytes(whole, on, 3)
    assert any("body 'sled' goes on" in text for text in on.summary["begins"])


# --- which go on ------------------------------------------------------------------------------------------------------


def begins(first, *, bodies=None, start=(), time="last", **changes):
    """Scene and sentences of a case that begins from a run, with other bodies or another start."""
    data = {**CROWD, **changes, "bodies": CROWD["bodies"] if bodies is None else bodies}
    case = lj.load_case(data).after(first, time=time)
    case = case.replace({f"initial.0.{name}": value for name, value in dict(start).items()}) if start else case
    return case.scene(), "\n".join(case.check().begins)


def pose(scene, name: str):
    return next(one.motion.pose(0) for one in scene.walls if one.wall.name == name)


def test_all_come_along_and_each_is_told(first):
    scene, said = begins(first)
    state = read_ended(first.folder / END_FILE).walls
    assert set(state.names) == {"lid", "sled", "wedge", "ball", "flap"}
    for name in state.names:
        assert pose(scene, name) == tuple(state.row(name)["place"])
        assert f"'{name}' goes on from" in said
    x, y, angle = pose(scene, "flap")
    assert x == y == 0.0 and angle > 0.01  # it has been released, and is held no more
    assert "body 'flap'" in said and "it is free from the start, whatever from says" in said
    assert len(scene.earlier.corners) == len(state.corners) > 0
    assert scene.earlier.corner_names == corner_names(scene.walls)
    sled = next(wall for wall in scene.walls_at(0) if wall.name == "sled")
    assert sled.extent[0][0] == pytest.approx(1.0 + pose(scene, "sled").x, abs=1e-3)
    drawn = [part for shape in scene_drawing(scene, []).shapes for part in getattr(shape, "rings", ())]
    assert any(part.shape == (4, 2) and np.allclose(part, sled.outline(*sled.extent)[0]) for part in drawn)


OTHERS = {
    "outline": ({**SLED, "x": [1.0, 1.7]}, "begins anew, where this case has it: it has another outline in"),
    "angle": ({**SLED, "y": [0.02, 0.32], "angle": 2}, "it has another outline in"),
    "kind": ({"name": "sled", "kind": "circle", "centre": [1.3, 0.3], "radius": 0.3, "density": 2500},
             "it has another outline in"),
    "hinge": ({**SLED, "velocity": [0, 0], "hinge": [1.0, 0.0]}, "it turns about another point in"),
}  # fmt: skip


@pytest.mark.parametrize(("sled", "said"), OTHERS.values(), ids=OTHERS)
def test_a_body_of_another_shape_begins_anew_and_its_contacts_are_forgotten(first, sled, said):
    scene, told = begins(first, bodies=[sled, BALL, FLAP], start={"in_walls": "drop"})
    assert f"body 'sled' {said}" in told or f"body 'sled' begins anew, where this case has it: {said}" in told
    assert pose(scene, "sled") == (0.0, 0.0, 0.0)
    chains, corners = scene.earlier.chains, scene.earlier.corner_names
    touched = {chains[-1 - row["partner"]] for row in scene.earlier.contacts if row["partner"] < 0}
    touched |= {chains[-1 - row["partner"]] for row in scene.earlier.corners}
    touched |= {corners[row["disc"] - 1] for row in scene.earlier.corners}
    assert "lid:0" in touched and not any(name.startswith(("sled:", "wedge:")) for name in touched)
    assert "their walls are gone or begin anew" in told


def test_a_body_that_is_new_or_gone_is_named(first):
    crate = {"name": "crate", "kind": "block", "x": [1.9, 2.2], "y": [1, 1.3], "density": 1000}
    scene, said = begins(first, bodies=[SLED, BALL, crate])
    assert f"body 'crate' begins anew, where this case has it: {first.folder} has none of that name" in said
    for name in ("wedge", "flap"):
        assert f"body '{name}' of {first.folder} stays behind: this case has none of that name" in said
    assert {one.wall.name for one in scene.bodies} == {"sled", "ball", "crate"}


def test_a_lid_that_is_a_body_here_begins_anew(first):
    lid = {"name": "lid", "kind": "block", "x": [0.1, 0.7], "y": [0.85, 0.95], "density": 3000}
    _, said = begins(first, bodies=[lid], walls=CROWD["walls"][:3])
    assert "body 'lid' begins anew, where this case has it: it is a lid in" in said


def test_mass_and_material_are_those_of_the_new_case(first):
    scene, said = begins(first, bodies=[{**SLED, "density": 900, "friction": 0.1}, WEDGE, BALL, FLAP])
    assert "body 'sled' goes on" in said and scene.bodies[0].motion.free.mass == pytest.approx(900 * 0.6 * 0.3)


def test_a_body_that_the_case_has_elsewhere_is_where_the_run_left_it(first):
    """The name and the outline count, not the place; discs and bodies stay together."""
    moved = {**BALL, "centre": [5.0, 1.0]}
    scene, _ = begins(first, bodies=[SLED, WEDGE, moved, FLAP])
    same, _ = begins(first)
    one, other = (next(wall for wall in found.walls_at(0) if wall.name == "ball") for found in (scene, same))
    assert np.allclose(one.extent, other.extent, atol=1e-12)


def test_shift_rest_and_within(first):
    """As discs do, bodies are moved, lose their speeds, and stay behind outside of the region."""
    start = {"shift": [1.0, 0.5], "velocities": "rest", "within": {"x": [0, 2]}}
    walls = [*CROWD["walls"][:2], {**CROWD["walls"][2], "at": 5}, CROWD["walls"][3]]
    far = {**BALL, "centre": [4.0, 0.25]}
    scene, said = begins(first, bodies=[SLED, WEDGE, far], start=start, walls=walls)
    state = read_ended(first.folder / END_FILE).walls
    place = state.row("sled")["place"]
    assert pose(scene, "sled") == pytest.approx((place[0] + 1.0, place[1] + 0.5, place[2]))
    went = next(one.motion.went for one in scene.walls if one.wall.name == "sled")
    assert went.speed == (0, 0, 0) and went.half is None and went.force is None
    assert "body 'ball' begins anew, where this case has it: it lies outside of within" in said


def test_a_body_that_was_not_released_waits_on_by_the_clock_of_the_new_run(place):
    case = lj.load_case(CROWD, {"run.duration": 0.01, "run.output_interval": 0.01})
    run = case.run(place / "held")
    scene, said = begins(run)
    assert "body 'flap' is still held in" in said and "until from, 0.031 s" in said
    flap = next(one.motion for one in scene.walls if one.wall.name == "flap")
    assert flap.went is None and flap.free.begin == 0.031


def test_two_runs_give_each_body_once(first, place):
    other = lj.load_case(CROWD, {"bodies": [SLED], "initial.0.y": [0.05, 0.3], "run.duration": 0.05}).run(place / "two")
    case = lj.load_case(CROWD).after(first)
    (one,) = case.core["initial"]
    two = {"kind": "run", "folder": str(other.folder), "shift": [0, 1.5]}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(other.folder.parent)
        found = lj.load_case(CROWD | {"initial": [{**one, "key": None, "folder": "first"}, {**two, "folder": "two"}]})
        said = "\n".join(found.check().begins)
    assert said.count("body 'sled' goes on from first") == 1 and "body 'sled' goes on from two" not in said


def test_a_new_wall_in_a_body_and_a_body_in_discs_are_refused(first):
    pier = {"name": "pier", "kind": "block", "x": [1.25, 1.35], "y": [0, 2]}
    with pytest.raises(CaseError, match=r"body 'sled' lies .* deep in wall 'pier' at the start"):
        begins(first, walls=[*CROWD["walls"], pier])
    with pytest.raises(CaseError, match=r"discs of .* lie deep in wall 'sled' \(bodies.0\)"):
        begins(first, bodies=[{**SLED, "x": [0.3, 0.8], "y": [0.2, 0.5]}, FLAP])


# --- frames, older runs, damage ---------------------------------------------------------------------------------------


def test_a_frame_of_the_dump_has_its_bodies(first, place):
    """Places of the frame with their speeds, without springs; the run then goes much as the first one went."""
    scene, _ = begins(first, time=0.1)
    rows = {row[0]: row for row in walls_of(first)[10:15]}
    for name in ("sled", "wedge", "ball", "flap", "lid"):
        assert pose(scene, name) == pytest.approx([float(value) for value in rows[name][1:]], abs=1e-15)
    speeds = {row[0]: np.array(row[4:7], float) for row in bodies_of(first)[8:12]}
    for one in scene.bodies:
        expected = speeds[one.wall.name] * np.array(one.motion.free.freedom)
        assert one.motion.went.speed == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert not len(scene.earlier.corners) and not len(scene.earlier.contacts)
    run = lj.load_case(CROWD).after(first, time=0.1).replace({"run.duration": 0.1}).run(place / "frame")
    assert numbers(walls_of(run)[-5:]) == pytest.approx(numbers(walls_of(first)[-5:]), abs=0.02 * D)


def test_a_run_without_its_end_says_that_bodies_begin_anew(first, tmp_path):
    """Of a run that was killed."""
    shutil.copytree(first.folder, tmp_path / "killed")
    (tmp_path / "killed" / END_FILE).unlink()
    _, said = begins(lj.open_run(tmp_path / "killed"), start={"in_walls": "drop"})
    assert said.count("begins anew, where this case has it") == 5 and "killed kept nothing of it" in said


WRONG = {
    "rows": ("walls", lambda rows: np.zeros(3)),
    "names": ("names", lambda names: names[:1]),
    "names twice": ("names", lambda names: np.array(["sled"] * len(names))),
    "kinds": ("kinds", lambda kinds: np.array(["pump"] * len(kinds))),
    "outlines": ("outlines", lambda outlines: outlines[:-1]),
    "outline": ("outlines", lambda outlines: outlines * np.nan),
    "corner": ("corners", lambda corners: changed(corners, "disc", 10_000)),
    "chain": ("corners", lambda corners: changed(corners, "partner", -10_000)),
    "disc": ("corners", lambda corners: changed(corners, "partner", 1)),
    "spring": ("corners", lambda corners: changed(corners, "spring", np.inf)),
    **{name: ("walls", lambda rows, name=name: changed(rows, name, np.inf)) for name in ("place", "force", "since")},
    **{f"{name} nan": ("walls", lambda rows, name=name: changed(rows, name, np.nan)) for name in ("place", "about")},
    "points": ("walls", lambda rows: changed(rows, "points", -4)),
}  # fmt: skip


def changed(rows: np.ndarray, name: str, value: float) -> np.ndarray:
    """A copy of rows, the last of which has another value."""
    rows = rows.copy()
    rows[name][-1] = value
    return rows


@pytest.mark.parametrize(("name", "make"), WRONG.values(), ids=WRONG)
def test_a_state_of_nonsense_is_refused(first, tmp_path, name, make):
    arrays = read_arrays(first.folder / END_FILE)
    assert len(arrays["corners"])
    write_arrays(tmp_path / END_FILE, **(arrays | {name: make(arrays[name])}))
    with pytest.raises(DumpError, match="holds no state"):
        read_ended(tmp_path / END_FILE)


def test_a_list_of_another_place_is_made_anew(first, place):
    """A state that was edited names a place from which walls were never listed: contacts are found all the same."""
    shutil.copytree(first.folder, place / "edited")
    arrays = read_arrays(first.folder / END_FILE)
    walls = arrays["walls"].copy()
    walls["listed"] += 1.0
    write_arrays(place / "edited" / END_FILE, **(arrays | {"walls": walls}))
    reseal(place / "edited")
    ends = [
        lj.load_case(CROWD, {"run.duration": 0.05}).after(place / name).run(place / f"{name}_on")
        for name in (first.folder.name, "edited")
    ]
    assert numbers(walls_of(ends[0])) == pytest.approx(numbers(walls_of(ends[1])), abs=1e-9 * D)


def test_check_tells_it_on_the_screen(first, tmp_path, monkeypatch, capsys):
    shutil.copytree(first.folder, tmp_path / "first")
    path = Path(tmp_path / "next.yaml")
    path.write_text(yaml.safe_dump(CROWD | {"initial": [{"kind": "run", "folder": "first"}], "bodies": [SLED, FLAP]}))
    monkeypatch.chdir(tmp_path)
    status, out, _ = call(monkeypatch, capsys, "check", path)
    assert status == 0
    assert "Body 'sled' goes on from first, moved by (" in out and "Body 'wedge' of first stays behind" in out
    assert "free goes on" in out
