# SPDX-License-Identifier: GPL-2.0-or-later
"""Interrupted LAMMPS runs go on: every frame once, sums of all parts, and the motion of an uninterrupted run."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from children import engines_that_save_at
from made_up import choose_to_stop_at, run_case, without_analysis

from lammps_jump.case import load_case
from lammps_jump.dump.find import read_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.engines import choice
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, PREVIOUS_FILE, read_checkpoint
from lammps_jump.engines.lammps.loader import program
from lammps_jump.engines.lammps.outputs import read_log
from lammps_jump.engines.launch import Setting, run
from lammps_jump.engines.plugin import plugin_path
from lammps_jump.errors import ResumeError, RunError, RunInterrupted, SetupError
from lammps_jump.scene.motion import gate
from lammps_jump.scene.scene import Pour
from lammps_jump.scene.walls import Plane
from lammps_jump.script.assemble import continuation_text

INPUTS = Path(__file__).parents[2] / "inputs"
pytestmark = pytest.mark.lammps
LONG = pytest.mark.long

GATE = ("run.duration=0.15", "initial.0.settle=0.1", "run.output_interval=0.01", "contact.rotation=true")
FRICTION = (*GATE, "contact.friction=0.1")
COLLAPSE = ("run.duration=0.4", "run.output_interval=0.01")
SIGN = (*COLLAPSE, "contact.friction=0.1", "contact.friction_law=sign")
JUMP = (
    "run.duration=2",
    "initial=[]",
    'outflow=[{"x_beyond": 7}]',
    "walls.sill.x=[6.5, 6.9]",
    "walls.sill.y=[-5, 0.4]",
    "run.output_interval=0.05",
)
RUB = ("contact.friction=0.1", "contact.rotation=true")


def scene_of(name: str, *changes: str):
    return load_case(INPUTS / f"{name}.yaml", list(changes)).scene()


def plugin_of(kernel: str) -> Path | None:
    if kernel == "stock":
        return None
    try:
        return plugin_path()
    except SetupError as error:
        pytest.skip(f"no compiled kernel here: {error}")


def go_on(scene, folder: Path, dump_format: str = "text", stop_at: int | None = None, **engine):
    return run(
        scene, folder, Setting(dump_format=dump_format, stop_at=stop_at, **engine), resume=read_checkpoint(folder)
    )


def frames(folder: Path):
    return [frame.sorted() for frame in open_dump(next(folder.glob("dump.lammps*")))]


def apart(one, two) -> float:
    """Largest difference of a coordinate, m."""
    assert np.array_equal(one.ids, two.ids)
    return max(np.abs(one.x - two.x).max(initial=0), np.abs(one.y - two.y).max(initial=0))


@pytest.mark.parametrize(
    ("kernel", "dump_format", "name", "changes"),
    [
        ("stock", "text", "wave_structure", FRICTION),
        pytest.param("compiled", "gz", "wave_structure", FRICTION, marks=LONG),
        pytest.param("compiled", "text", "dam_break", SIGN, marks=LONG),
        pytest.param("stock", "binary", "quick_jump", JUMP, marks=LONG),
        pytest.param("compiled", "binary", "quick_jump", JUMP, marks=LONG),
        pytest.param("compiled", "text", "quick_jump", (*JUMP, "discs.sizes=null", "contact.friction=0.1"), marks=LONG),
    ],
)
def test_continued_run_is_the_uninterrupted_one(kernel, dump_format, name, changes, tmp_path):
    scene = scene_of(name, *changes)
    engine = {"kernel": kernel, "plugin": plugin_of(kernel)}
    setting = Setting(dump_format=dump_format, **engine)
    whole = run(scene, tmp_path / "whole", setting)
    parts = tmp_path / "parts"
    first = run(scene, parts, replace(setting, stop_at=scene.steps // 4))
    second = go_on(scene, parts, dump_format, 3 * scene.steps // 5, **engine)
    third = go_on(scene, parts, dump_format, **engine)
    assert [result.status for result in (first, second, third)] == ["interrupted", "interrupted", "complete"]
    assert "--resume" in first.message and third.steps == whole.steps == scene.steps
    for result, asked in ((first, scene.steps // 4), (second, 3 * scene.steps // 5)):  # to the end of the window
        assert asked <= result.steps < asked + max(1, scene.probe_steps if scene.probes else 1)
    assert not scene.probes or first.steps % scene.probe_steps == 0
    assert third.resumed == (scene.time(first.steps), scene.time(second.steps))
    assert third.seconds >= second.seconds >= first.seconds >= 0
    for result in (first, second, third):
        assert result.lost == 0 and result.inserted == result.present + result.removed

    one, two = frames(tmp_path / "whole"), frames(parts)
    assert [frame.step for frame in two] == [frame.step for frame in one]
    joined = next(i for i, frame in enumerate(one) if frame.step > first.steps)
    # the same forces up to the order of sums: the tenth digit, or ten times the 1e-12 m that a hundred steps of
    # collisions make of the last bit; a restart from full-step velocities is off by 1e-7 d here
    digit = 1e-11 if dump_format == "binary" else 1e-8
    assert max(apart(a, b) for a, b in zip(one[: joined + 1], two[: joined + 1], strict=True)) < digit
    if name == "wave_structure":  # at rest first, no chaos to the end of so short a run
        assert apart(one[-1], two[-1]) < 1e-7
        assert third.disc_steps == whole.disc_steps

    forces = [read_forces(place / "forces.csv") for place in (tmp_path / "whole", parts)]
    assert forces[0].keys() == forces[1].keys()
    for wall, history in forces[0].items():  # the clock starts from another sum: fifteen digits of it are printed
        assert forces[1][wall].time == pytest.approx(history.time, rel=1e-13, abs=1e-13)
    lines = [{int(row.split()[0]) for row in log_rows(place / "log.lammps")} for place in (tmp_path / "whole", parts)]
    assert lines[0] <= lines[1]  # all rows, and those of the joins
    log = read_log(parts / "log.lammps")
    assert (log.step, log.removed, log.discs) == (scene.steps, third.removed, third.present)
    if name == "quick_jump":  # counted on over the joins
        removed = [int(row.split()[3]) for row in log_rows(parts / "log.lammps")]
        assert removed == sorted(removed) and 0 < second.removed < third.removed


def log_rows(path: Path) -> list[str]:
    """Rows of step, time, discs and counts."""
    return [row for row in path.read_text().splitlines() if re.fullmatch(r"( +[\d.e+-]+){4,}\s*", row)]


@pytest.mark.long
def test_full_step_velocities_would_not_do(tmp_path):
    """The half step is no ornament: without it the first frames differ by more than the digits of the dump."""
    scene = scene_of("dam_break", *COLLAPSE)
    run(scene, tmp_path / "whole")
    place = tmp_path / "parts"
    run(scene, place, Setting(stop_at=scene.steps // 5))
    checkpoint = read_checkpoint(place)
    path = place / f"checkpoint-{checkpoint.step}.npz"
    stored = dict(np.load(path))
    np.savez(path, **{**stored, "half": stored["whole"]})  # the run computes its forces with the velocities of the step
    run(scene, place, resume=checkpoint)
    one, two = frames(tmp_path / "whole"), frames(place)
    later = next(i for i, frame in enumerate(one) if frame.step > checkpoint.step + 50)
    assert 1e-8 * scene.diameter < apart(one[later], two[later]) < 1e-3 * scene.diameter


# --- what could not go on before ------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("kernel", ["stock", "compiled"])
def test_a_pour_goes_on_with_the_discs_that_are_left(kernel, tmp_path):
    """fix pour keeps no state: the others come from a new random stream, and all are there in the end."""
    pour = Pour(x=(12.0, 20.0), y=(6.0, 8.0), count=300, volume_fraction=0.2, speed_down=1.0)
    scene = scene_of("dam_break", "run.duration=1.5", "run.output_interval=0.01")  # time for places in the last layer
    scene = replace(scene, pours=(pour,), probes=())
    engine = {"kernel": kernel, "plugin": plugin_of(kernel)}
    begun = len(scene.positions)
    first = run(scene, tmp_path, Setting(stop_at=scene.steps // 5, **engine))
    assert first.status == "interrupted" and begun < first.inserted < begun + 300
    checkpoint = read_checkpoint(tmp_path)
    options = {"step": checkpoint.step, "removed": (), "kernel": kernel}
    seeds = [re.search(r"pour 300 0 (\d+)", (tmp_path / "in.lammps").read_text())[1]]
    text = continuation_text(scene, poured=first.inserted - begun, **options)
    seeds.append(re.search(rf"pour {begun + 300 - first.inserted} 0 (\d+)", text)[1])
    assert seeds[0] != seeds[1] and "fix             pour_1" not in continuation_text(scene, poured=300, **options)
    last = go_on(scene, tmp_path, **engine)
    assert last.status == "complete" and last.lost == 0 and last.inserted == begun + 300
    ids = [frame.ids for frame in frames(tmp_path)]
    assert np.array_equal(ids[-1], np.arange(1, begun + 301))


@pytest.mark.parametrize(
    ("kernel", "stop"),
    [
        ("compiled", 3500),
        *(pytest.param(*one, marks=LONG) for one in (("stock", 1000), ("stock", 3500), ("compiled", 1000))),
    ],
)
def test_a_gate_before_inlets_goes_on_closed_or_open(kernel, stop, tmp_path):
    shut = gate(Plane("gate", "x", 3.0, "below"), 3000)
    scene = scene_of("quick_jump", "run.duration=2", "contact.friction=0.1")
    rows = tuple(replace(row, first_step=row.first_step + 3000) for row in scene.inlets)
    scene = replace(scene, walls=(*scene.walls, shut), settle_steps=3000, inlets=rows, steps=5900)
    discs = np.array([[1.0 + 0.1601 * i, 0.1 + 0.16 * j] for i in range(12) for j in range(4)])
    scene = replace(scene, positions=discs, velocities=np.zeros_like(discs))
    engine = {"kernel": kernel, "plugin": plugin_of(kernel)}
    whole = run(scene, tmp_path / "whole", Setting(**engine))
    parts = tmp_path / "parts"
    first = run(scene, parts, Setting(stop_at=stop, **engine))
    assert first.status == "interrupted" and stop <= read_checkpoint(parts).step < stop + scene.probe_steps
    last = go_on(scene, parts, **engine)
    assert last.status == "complete" and last.lost == 0 and last.inserted == whole.inserted > len(discs)
    one, two = frames(tmp_path / "whole"), frames(parts)
    assert [frame.step for frame in one] == [frame.step for frame in two]
    joined = next(i for i, frame in enumerate(one) if frame.step > first.steps)
    assert apart(one[joined], two[joined]) < 1e-8
    forces = [read_forces(place / "forces.csv")["sill"] for place in (tmp_path / "whole", parts)]
    assert forces[0].time == pytest.approx(forces[1].time, abs=1e-12)


# --- checkpoints on the way -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kernel", "ranks", "name", "changes"),
    [
        pytest.param("stock", 1, "quick_jump", (*JUMP, *RUB, "run.duration=0.4"), marks=LONG),
        pytest.param("stock", 1, "quick_jump", (*JUMP, *RUB), marks=LONG),
        pytest.param("compiled", 1, "quick_jump", (*JUMP, "contact.friction=0.1"), marks=LONG),
        pytest.param("stock", 1, "wave_structure", FRICTION, marks=LONG),
        pytest.param("compiled", 2, "quick_jump", (*JUMP, "run.duration=0.4"), marks=LONG),
    ],
)
def test_checkpoints_on_the_way_change_nothing(kernel, ranks, name, changes, tmp_path):
    """The motion is that of a run without, to the last bit: of discs, forces on walls, and sizes of frames."""
    scene = scene_of(name, *changes)
    setting = Setting(kernel=kernel, plugin=plugin_of(kernel), ranks=ranks, dump_format="binary")
    setting = replace(setting, checkpoint_interval=1e9)
    run(scene, tmp_path / "whole", setting)
    with engines_that_save_at(700, 1100, 1500, 2001):
        result = run(scene, tmp_path / "saved", setting)
    assert result.status == "complete" and not result.resumed
    steps = [json.loads((tmp_path / "saved" / name).read_text())["step"] for name in (CHECKPOINT_FILE, PREVIOUS_FILE)]
    assert steps[0] > 2001 > steps[1] > 1500
    one, two = frames(tmp_path / "whole"), frames(tmp_path / "saved")
    assert [frame.step for frame in one] == [frame.step for frame in two]
    for before, after in zip(one, two, strict=True):
        assert all(np.array_equal(before.columns[key], after.columns[key]) for key in before.columns)
    forces = [read_forces(place / "forces.csv") for place in (tmp_path / "whole", tmp_path / "saved")]
    for wall, history in forces[0].items():
        assert np.array_equal(history.fx, forces[1][wall].fx) and np.array_equal(history.moment, forces[1][wall].moment)


def test_an_end_asked_for_too_late_is_no_interruption(tmp_path):
    scene = scene_of("energy_box_16", "run.duration=0.2")
    result = run(scene, tmp_path, Setting(stop_at=scene.steps))
    assert result.status == "complete" and result.message == ""


# --- ranks, and the whole job --------------------------------------------------------------------------------------


@pytest.mark.long
def test_two_ranks_end_in_order_and_go_on(tmp_path):
    engine = {"kernel": "compiled", "plugin": plugin_of("compiled"), "ranks": 2}
    if program("mpiexec") is None:
        pytest.skip("the mpich wheel brings no mpiexec")
    scene = scene_of("quick_jump", "run.duration=40", "run.output_interval=0.01")
    window = scene.probe_steps
    place = tmp_path / "parts"
    first = run(scene, place, Setting(stop_at=3 * window - 1, **engine))
    assert first.status == "interrupted" and "--resume" in first.message and first.steps == 3 * window
    second = go_on(scene, place, stop_at=5 * window, **engine)
    assert second.status == "interrupted" and second.resumed == (scene.time(first.steps),)
    assert second.steps == 5 * window and not (place / "stop.request").exists()
    assert second.lost == 0 and second.inserted == second.present > 0

    alone = {"kernel": "compiled", "plugin": engine["plugin"]}  # engine.ranks: auto may choose another number
    third = go_on(scene, place, stop_at=7 * window, **alone)
    assert third.status == "interrupted" and third.steps == 7 * window

    short = replace(scene, steps=third.steps)
    run(short, tmp_path / "whole", Setting(**alone))
    one, two = frames(tmp_path / "whole"), frames(place)
    assert [frame.step for frame in two] == [frame.step for frame in one]
    ranked = [pair for pair in zip(one, two, strict=True) if pair[0].step <= second.steps]
    digit = 1e-8  # the tenth of the dump, at x up to 10 m
    assert max(apart(a, b) for a, b in ranked) < digit
    forces = [len((folder / "forces.csv").read_text().splitlines()) for folder in (tmp_path / "whole", place)]
    assert forces[0] == forces[1] == 1 + third.steps // window


@pytest.mark.long
def test_ranks_that_are_asked_by_their_file_end_in_order(tmp_path):
    """What a signal does: the file is there, and the ranks end at the next window."""
    engine = {"kernel": "compiled", "plugin": plugin_of("compiled"), "ranks": 2}
    if program("mpiexec") is None:
        pytest.skip("the mpich wheel brings no mpiexec")
    scene = scene_of("quick_jump", "run.duration=20000")
    result = run(scene, tmp_path, Setting(**engine), should_stop=lambda: True)
    assert result.status == "interrupted" and 0 <= result.steps < scene.steps
    assert result.steps % scene.probe_steps == 0 and not (tmp_path / "stop.request").exists()


def test_whole_job(tmp_path, monkeypatch):
    """Interrupted, refused for another case, gone on with, and then a folder like any other."""
    case, changes = INPUTS / "dam_break.yaml", ["engine.kernel=stock", *COLLAPSE, "run.duration=0.2"]
    folder = tmp_path / "run"
    without_analysis(monkeypatch)
    with monkeypatch.context() as patch:
        patch.setattr(choice, "choose", choose_to_stop_at(1500))
        with pytest.raises(RunInterrupted, match="--resume"):
            run_case(case, folder, changes)
    first = json.loads((tmp_path / "run/summary.json").read_text())
    assert first["status"] == "interrupted"
    with pytest.raises(ResumeError, match="differs"):
        run_case(case, folder, [*changes, "run.seed=5"], resume=True)
    shutil.copytree(tmp_path / "run", tmp_path / "copy")
    with monkeypatch.context() as patch:  # a part that cannot begin, for want of a library say, spoils nothing
        patch.setattr("lammps_jump.engines.launch.write_continuation", lambda scene, folder, **options: folder)
        with pytest.raises(RunError, match="checkpoint is kept"):
            run_case(case, folder, changes, resume=True)
    summary = run_case(case, folder, changes, resume=True)
    whole = run_case(case, tmp_path / "whole", changes)
    for key in ("status", "steps", "simulated_time", "disc_steps", "discs", "case_hash", "message"):
        assert summary[key] == whole[key]
    assert summary["resumed_at"] == [first["simulated_time"]]
    assert summary["wall_seconds"]["run"] >= first["wall_seconds"]["run"] >= 0
    names = [
        {str(path.relative_to(place)) for path in place.rglob("*")} for place in (tmp_path / "run", tmp_path / "whole")
    ]
    assert names[0] == names[1]
    assert (tmp_path / "run/in.lammps").read_bytes() == (tmp_path / "whole/in.lammps").read_bytes()
    # a part that is killed leaves more than the checkpoint knows of: the next try cuts it off
    again = tmp_path / "copy"
    for name in ("dump.lammpstrj", "log.lammps"):
        with (again / name).open("ab") as file:
            file.write(b"torn")
    run_case(case, again, changes, resume=True)
    assert (again / "dump.lammpstrj").read_bytes() == (tmp_path / "run/dump.lammpstrj").read_bytes()
