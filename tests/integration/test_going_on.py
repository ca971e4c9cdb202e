# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs that go on from other runs: `initial` of kind `run`."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up import analysed_again, call, choose_to_stop_at, plugin_or_skip, reseal

import lammps_jump as lj
from lammps_jump.case import earlier
from lammps_jump.dump.ended import read_ended, write_ended
from lammps_jump.dump.find import read_dump
from lammps_jump.engines import choice
from lammps_jump.errors import CaseError, RunInterrupted
from lammps_jump.files import END_FILE

D = 0.1
BED = {
    "name": "bed",
    "discs": {"diameter": D, "density": 2000, "sizes": {"kind": "uniform", "spread": 0.2}},
    "contact": {
        "restitution": 0.5, "friction": 0.5, "friction_law": "history", "impact_speed": 3, "largest_overlap": 0.05,
        "rotation": True, "rolling": {"friction": 0.1},
    },
    "domain": {"x": [-1, 6], "y": [-1, 4]},
    "walls": [
        {"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"},
        {"name": "left", "kind": "plane", "axis": "x", "at": 0, "side": "above"},
        {"name": "gate", "kind": "block", "x": [0.8, 0.9], "y": [0, 3]},
    ],
    "initial": [{"kind": "column", "x": [0, 0.75], "y": [0.05, 0.8], "gate": False}],
    "run": {"duration": 0.2, "output_interval": 0.05, "dump_format": "binary"},
    "analysis": {"figures": "none"},
    "engine": {"name": "native"},
}  # fmt: skip
"""Discs of several sizes, with springs, that fall into a container."""
OPEN = {"walls": BED["walls"][:2]}
LAW = BED["contact"]


def last(run, index=-1):
    """Places of a frame, by id, shape (n, 2)."""
    frame = read_dump(run.folder)[index].sorted()
    return np.column_stack([frame.x, frame.y])


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("beds")


@pytest.fixture(scope="module")
def bed(place):
    """A run that ends while its discs move."""
    return lj.load_case(BED).run(place / "bed")


@pytest.fixture(scope="module")
def settled(place):
    """A small heap at rest, a settled bed."""
    return lj.load_case(BED, {"run.duration": 3, "run.output_interval": 0.25}).run(place / "settled")


def case_file(folder: Path, **changes) -> Path:
    """A case file that begins from ``bed`` beside it."""
    data = BED | {"initial": [{"kind": "run", "folder": "bed"}]} | changes
    path = folder / "next.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


# --- the same motion --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["history", "viscous"])
def test_native_goes_on_with_the_same_bytes(bed, place, law):
    """Two runs after each other are one run of twice the time, to the last bit, with springs and with the leap-frog."""
    changes = {} if law == "history" else {"contact": {**LAW, "friction_law": law, "rolling": None}}
    case = lj.load_case(BED, changes)
    first = bed if law == "history" else case.run(place / law)
    whole = case.replace({"run.duration": 0.4}).run(place / f"whole_{law}")
    rest = case.after(first).run(place / f"rest_{law}")
    one, two = read_dump(whole.folder), read_dump(rest.folder)
    assert len(one) == 9 and len(two) == 5
    assert np.abs(last(whole) - last(whole, 4)).max() > 0.1 * D  # it moves
    for index in range(5):
        frames = one[4 + index].sorted(), two[index].sorted()
        for name in ("x", "y", "vx", "vy", "omegaz", "radius"):
            assert frames[0].column(name).tobytes() == frames[1].column(name).tobytes()


def test_without_the_order_of_sums_it_is_the_same_but_for_round_off(bed, place):
    """What the neutral state holds is enough for the same motion; the lists of the engine are for its bits alone."""
    state = read_ended(bed.folder / END_FILE)
    shutil.copytree(bed.folder, place / "plain")
    write_ended(place / "plain" / END_FILE, replace(state, exact={}))
    reseal(place / "plain")
    ends = [lj.load_case(BED).after(place / name).run(place / f"{name}_on") for name in ("bed", "plain")]
    other = lj.load_case(BED, {"engine.skin": 0.02}).after(bed).run(place / "skin")  # its lists do not suit
    for run in (ends[1], other):
        assert 0 < np.abs(last(ends[0]) - last(run)).max() < 1e-9 * D


def test_compiled_styles_go_on_as_one_run(place):
    plugin_or_skip()
    case = lj.load_case(BED, {"engine": {"name": "lammps", "kernel": "compiled"}})
    first, whole = case.run(place / "c1"), case.replace({"run.duration": 0.4}).run(place / "c2")
    rest = case.after(first).run(place / "c12")
    assert rest.result.steps > 1000
    assert np.abs(last(whole) - last(rest)).max() < 1e-9 * D
    assert np.array_equal(last(whole, 4), last(rest, 0))


def test_compiled_and_native_begin_alike(bed, place):
    """The springs of the native bed are those of the compiled styles: a wall that goes, and 1,000 steps."""
    plugin_or_skip()
    case = lj.load_case(BED, OPEN).after(bed)
    other = case.replace({"engine": {"name": "lammps", "kernel": "compiled"}}).run(place / "oc")
    assert np.abs(last(case.run(place / "on"), 2) - last(other, 2)).max() < 1e-9 * D


def test_a_run_goes_from_engine_to_engine_and_back(bed, place):
    """Native, compiled, native: springs come along each time, and the end is that of the native engine alone."""
    plugin_or_skip()
    short = {"run.duration": 0.05, "run.output_interval": 0.05}
    compiled = {"engine": {"name": "lammps", "kernel": "compiled"}}
    between = lj.load_case(BED, short).replace(compiled).after(bed).run(place / "there")
    back = lj.load_case(BED, short).after(between).run(place / "back")
    alone = lj.load_case(BED, {**short, "run.duration": 0.1}).after(bed).run(place / "alone")
    assert back.result.engine == "native" and between.result.kernel == "compiled"
    assert np.abs(last(alone) - last(bed)).max() > 0.01 * D  # it moves
    assert np.abs(last(back) - last(alone)).max() < 1e-9 * D


@pytest.mark.long
def test_compiled_styles_go_on_on_two_ranks_as_on_one(bed, place):
    """Springs of two discs on both sides of the cut are there too."""
    plugin_or_skip()
    case = lj.load_case(BED, {"engine": {"name": "lammps", "kernel": "compiled"}}).after(bed)
    one, two = (case.replace({"engine.ranks": ranks}).run(place / f"ranks_{ranks}") for ranks in (1, 2))
    assert two.summary["ranks"] == 2 and np.abs(last(one) - last(one, 0)).max() > 0.1 * D
    assert np.abs(last(one) - last(two)).max() < 1e-9 * D


def test_stock_styles_say_that_springs_begin_at_zero(bed, place):
    changes = {"engine": {"name": "lammps", "kernel": "stock"}, "contact": {**LAW, "rolling": None}}
    run = lj.load_case(BED, changes).after(bed).run(place / "stock")
    assert any("springs" in text and "begin at 0" in text for text in run.warnings)
    first, old = read_dump(run.folder)[0].sorted(), read_ended(bed.folder / END_FILE).discs
    for name, own in (("x", "x"), ("y", "y"), ("vx", "vx"), ("omegaz", "spin")):
        assert np.array_equal(first.column(name), old[own])
    assert np.array_equal(2 * first.column("radius"), old["diameter"])


def test_a_heap_at_rest_stays(settled, place):
    """Springs that come along hold it: it does not move. From a frame they begin at 0, and it settles again."""
    on = lj.load_case(BED, {"run.duration": 1}).after(settled).run(place / "stays")
    assert np.abs(last(on) - last(settled)).max() < 1e-6 * D
    frame = lj.load_case(BED, {"run.duration": 1}).after(settled, time=3.0).run(place / "again")
    moved = np.abs(last(frame) - last(settled)).max()
    assert 1e-6 * D < moved < 0.1 * D
    assert frame.result.present == settled.result.present and "nearest frame" in frame.summary["begins"][0]


@pytest.mark.long
def test_a_heap_at_rest_stays_for_five_seconds(settled, place):
    whole = lj.load_case(BED, {"run.duration": 8}).after(settled).run(place / "rested")
    on = lj.load_case(BED, {"run.duration": 5}).after(whole).run(place / "five")
    assert np.abs(last(on) - last(on, 0)).max() < 1e-6 * D


# --- what comes along -------------------------------------------------------------------------------------------------


def test_a_wall_that_goes_lets_the_discs_flow(settled, place):
    case = lj.load_case(BED, {**OPEN, "run.duration": 0.5}).after(settled)
    said = case.check().begins
    at_gate = sum("gate" in read_ended(settled.folder / END_FILE).chains[-1 - row["partner"]]
                  for row in read_ended(settled.folder / END_FILE).contacts if row["partner"] < 0)  # fmt: skip
    assert at_gate > 0 and f"that of {at_gate} contacts is dropped: their walls are gone" in said
    run = case.run(place / "breach")
    assert last(run)[:, 0].max() > 0.9 + D
    assert run.result.present == settled.result.present


def test_a_wall_put_in_refuses_or_drops(settled):
    wall = {"name": "pier", "kind": "block", "x": [0.3, 0.4], "y": [0, 1]}
    case = lj.load_case(BED, {"walls": [*BED["walls"], wall]})
    with pytest.raises(CaseError, match=r"initial\.?\[?0\]?: (\d+) discs of .* lie deep in wall 'pier'"):
        case.after(settled).scene()
    drops = case.after(settled).replace({"initial.0.in_walls": "drop"})
    places = drops.scene().positions
    inside = (places[:, 0] > 0.3) & (places[:, 0] < 0.4) & (places[:, 1] < 1)
    assert not inside.any() and 0 < len(places) < settled.result.present
    assert f"{settled.result.present - len(places)} more dropped" in drops.check().begins[0]


def test_discs_keep_their_diameters_and_others_come_after(bed):
    more = {"kind": "lattice", "nx": 3, "ny": 1, "spacing": 0.2, "origin": [2, 2]}
    start = {"kind": "run", "folder": str(bed.folder), "within": {"x": [0.2, 0.6]}, "shift": [2, 0.5]}
    case = lj.load_case(BED).after(bed)
    case = case.replace({"initial": [more, {**start, "velocities": "rest"}]})
    scene, old = case.scene(), read_ended(bed.folder / END_FILE).discs
    old = old[(old["x"] >= 0.2) & (old["x"] <= 0.6)]
    n = len(old)
    assert 0 < n < bed.result.present and len(scene.positions) == n + 3
    assert np.array_equal(scene.positions[:n], np.column_stack([old["x"] + 2, old["y"] + 0.5]))
    assert np.array_equal(scene.diameters(np.arange(1, n + 1)), old["diameter"])
    drawn = lj.load_case(BED).scene().sizes
    assert np.array_equal(scene.diameters(np.arange(n + 1, n + 4)), drawn.diameters(np.arange(n + 1, n + 4)))
    assert not scene.velocities.any() and not scene.earlier.spins.any()


def test_a_law_without_memory_says_what_it_drops(bed):
    case = lj.load_case(BED, {"contact": {**LAW, "friction_law": "viscous", "rolling": None}}).after(bed)
    assert not len(case.scene().earlier.contacts)
    assert any("the law of this case remembers nothing" in text for text in case.check().begins)


def test_rough_beds_are_the_new_cases_own(place):
    """Their discs stay behind, what touched them remembers those of the new case: the same bytes over a rough bed."""
    rough = {"kind": "rough", "name": "bed", "from": [0.05, 0.0], "to": [0.75, 0.0], "diameter": D}
    column = {"kind": "column", "x": [0, 0.75], "y": [0.07, 0.8], "gate": False}
    case = lj.load_case(BED, {"walls": [*BED["walls"][1:], rough], "initial": [column]})
    first, whole = case.run(place / "rough"), case.replace({"run.duration": 0.4}).run(place / "rough_whole")
    state, after = read_ended(first.folder / END_FILE), case.after(first)
    scene = after.scene()
    assert len(scene.positions) == len(state.discs) + scene.fixed.count
    assert scene.fixed.holds(scene.earlier.contacts["disc"]).any()
    assert np.array_equal(last(after.run(place / "rough_on")), last(whole))
    frame = case.replace({"walls": BED["walls"]}).after(first, time=0.1).scene()
    assert len(frame.positions) == len(state.discs)


# --- the folder stays whole -------------------------------------------------------------------------------------------


def test_a_run_stays_whole_without_the_other_one(bed, tmp_path, monkeypatch):
    shutil.copytree(bed.folder, tmp_path / "bed")
    case = lj.load_case(case_file(tmp_path))
    with monkeypatch.context() as patch, pytest.raises(RunInterrupted):
        patch.setattr(choice, "choose", choose_to_stop_at(1000))
        case.run(tmp_path / "next")
    shutil.rmtree(tmp_path / "bed")
    shutil.move(tmp_path / "next", tmp_path / "elsewhere")
    earlier.KNOWN.clear()
    whole = case.run(tmp_path / "whole")
    with pytest.raises(CaseError, match="holds no run"):
        lj.load_case(case_file(tmp_path))
    stored = lj.load_case(tmp_path / "elsewhere")
    assert stored.hash == case.hash and "key" in stored.core["initial"][0]
    on = stored.run(tmp_path / "elsewhere", resume=True)
    assert on.status == "complete" and np.array_equal(last(on), last(whole))
    assert analysed_again(on.folder)["begins"] == list(case.check().begins)
    assert "Begins from bed at t = 0.2 s (its end; key" in on.report(tmp_path / "report.html").read_text()


def test_discs_that_were_made_anew_are_another_run(bed, tmp_path):
    shutil.copytree(bed.folder, tmp_path / "bed")
    case = lj.load_case(case_file(tmp_path))
    lj.load_case(BED, {"run.seed": 5}).run(tmp_path / "bed", force=True)
    earlier.KNOWN.clear()
    other = lj.load_case(case_file(tmp_path))
    assert other.hash != case.hash
    pinned = [{"kind": "run", "folder": "bed", "key": case.core["initial"][0]["key"]}]
    del case
    with pytest.raises(CaseError, match="made anew"):
        lj.load_case(case_file(tmp_path, initial=pinned))


def test_a_damaged_start_is_told(bed, tmp_path):
    run = lj.load_case(BED).after(bed).run(tmp_path / "on")
    (start,) = run.folder.glob("start-*.npz")
    start.write_bytes(b"nothing")
    earlier.KNOWN.clear()
    with pytest.raises(CaseError, match="put the file back"):
        lj.load_case(run.folder)


def test_a_study_reads_the_bed_once(bed, tmp_path, monkeypatch):
    shutil.copytree(bed.folder, tmp_path / "bed")
    read = []
    monkeypatch.setattr(earlier, "read_ended", lambda path: (read.append(path), read_ended(path))[1])
    case = lj.load_case(case_file(tmp_path))
    cases = [case.replace({"contact.friction": 0.1 * k, "run.seed": k}) for k in range(1, 5)]
    assert len({one.hash for one in cases}) == 4 and len(read) == 1
    assert all(one.scene().earlier is not None for one in cases)


def test_without_its_end_state_a_run_gives_its_last_frame(bed, tmp_path):
    shutil.copytree(bed.folder, tmp_path / "bed")
    (tmp_path / "bed" / END_FILE).unlink()
    scene = lj.load_case(case_file(tmp_path)).scene()
    assert np.array_equal(scene.positions, last(bed))
    assert "(the last frame of its dump: it has no end.npz; key" in scene.earlier.origins[0]


def test_a_run_that_was_stopped_says_so(place, tmp_path, monkeypatch):
    """The begun run tells it too, from its own copy."""
    with monkeypatch.context() as patch, pytest.raises(RunInterrupted):
        patch.setattr(choice, "choose", choose_to_stop_at(1000))
        lj.load_case(BED).run(tmp_path / "bed")
    short = {"run.duration": 0.02, "run.output_interval": 0.02}
    run = lj.load_case(case_file(tmp_path)).replace(short).run(tmp_path / "on")
    assert "(where it was stopped; key" in run.summary["begins"][0]
    shutil.rmtree(tmp_path / "bed")
    earlier.KNOWN.clear()
    assert "(where it was stopped; key" in lj.load_case(run.folder).check().begins[0]


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("item", "changes", "said"),
    [
        ({"folder": "none"}, {}, "'none' holds no run; name the folder of a run that has ended"),
        ({"folder": "a\0b"}, {}, "is no folder that can be read (character 2 is U+0000, which cannot be printed"),
        ({"folder": 300 * "a"}, {}, "is no folder that can be read (File name too long)"),
        ({"folder": "../../../../../usr"}, {}, "lies outside the folder of the case and the working directory"),
        ({"time": 7}, {}, "time: bed: 7 s is outside its dump; allowed is 0 to 0.2 s"),
        ({"time": "soon"}, {}, "time"),
        ({"time": [1]}, {}, "time"),
        ({"time": {"a": True}}, {}, "time"),
        ({"within": {"x": [3, 4]}}, {}, "within: holds none of the "),
        ({"velocities": "half"}, {}, "velocities"),
        ({}, {"discs": {**BED["discs"], "density": 900}}, "discs.density: is 900 kg/m3, the discs of bed have 2000"),
        ({}, {"walls": [*BED["walls"], {"name": "pier", "kind": "block", "x": [0.3, 0.4], "y": [0, 1]}]},
         "discs of bed lie deep in wall 'pier' (walls.3), the deepest by "),
        ({"shift": [0.3, 0]}, {}, "discs of bed lie deep in wall 'gate'"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(bed, tmp_path, monkeypatch, capsys, item, changes, said):
    shutil.copytree(bed.folder, tmp_path / "bed")
    monkeypatch.chdir(tmp_path)
    path = case_file(tmp_path, initial=[{"kind": "run", "folder": "bed", **item}], **changes)
    status, _, error = call(monkeypatch, capsys, "build-and-run", path, "--out", "out")
    assert status == 2 and said in error and len(error.strip().splitlines()) <= 2
    assert not (tmp_path / "out").exists()


def test_a_missing_bed_names_the_command_that_makes_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = case_file(tmp_path)
    (tmp_path / "bed.yaml").write_text("name: bed\n")
    status, _, error = call(monkeypatch, capsys, "check", path)
    assert status == 2 and "`lammps-jump build-and-run bed.yaml --out bed` makes it" in error


def test_a_run_that_failed_is_refused(bed, tmp_path):
    shutil.copytree(bed.folder, tmp_path / "bed")
    summary = tmp_path / "bed" / "summary.json"
    summary.write_text(summary.read_text().replace('"status": "complete"', '"status": "failed"'))
    with pytest.raises(CaseError, match="the run there failed"):
        lj.load_case(case_file(tmp_path))
    for text in ("", "{}", '{"status": "well"}', "[]"):
        summary.write_text(text)
        with pytest.raises(CaseError, match=r"summary\.json"):
            lj.load_case(case_file(tmp_path))
    summary.unlink()
    with pytest.raises(CaseError, match=r"summary\.json, which tells how the run ended, cannot be read"):
        lj.load_case(case_file(tmp_path))


def link_to_another(path):
    shutil.copy(path, path.with_name("other"))
    path.unlink()
    path.symlink_to("nowhere")


def pipe(path):
    path.unlink()
    os.mkfifo(path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda path: path.write_bytes(path.read_bytes() + b" "), "is not the one that the run wrote"),
        (pipe, "no regular file"),
        (link_to_another, "No such file"),
    ],
)
def test_an_end_state_that_is_not_of_this_run_is_refused(bed, tmp_path, change, said):
    shutil.copytree(bed.folder, tmp_path / "bed")
    change(tmp_path / "bed" / END_FILE)
    with pytest.raises(CaseError, match=said):
        lj.load_case(case_file(tmp_path))
    assert analysed_again(tmp_path / "bed")["outputs"] == bed.summary["outputs"]  # an analysis does not read it
    with pytest.raises(CaseError, match=said):
        lj.load_case(case_file(tmp_path))
