# SPDX-License-Identifier: GPL-2.0-or-later
"""Interrupted runs of the native engine go on bit for bit, and what cannot go on is refused untouched."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from children import run_program
from made_up import choose_to_stop_at, run_case, some_long, without_analysis

import lammps_jump as lj
from lammps_jump.case import load_case
from lammps_jump.cli import run as cli
from lammps_jump.cli.app import main
from lammps_jump.cli.progress import ProgressLine
from lammps_jump.dump.read import open_dump
from lammps_jump.engines import choice
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, read_checkpoint, sum_of
from lammps_jump.engines.interrupts import SIGNALS, counted_interrupts, terminate_as_interrupt
from lammps_jump.engines.native import run_native
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.engines.result import Progress, interruption
from lammps_jump.errors import CaseError, ResumeError, RunInterrupted, SetupError
from lammps_jump.identity import scene_key
from lammps_jump.scene.scene import Pour, handmade_scene
from lammps_jump.scene.walls import Box

INPUTS = Path(__file__).parents[2] / "inputs"
JUMP = (
    "run.duration=1.2",
    "run.output_interval=0.05",
    "initial=[]",
    'outflow=[{"x_beyond": 7}]',
    "walls.sill.x=[6.5, 6.9]",
)


def case_scene(name: str, *changes: str):
    return load_case(INPUTS / f"{name}.yaml", ["engine.name=native", *changes]).scene()


def pouring():
    """Places of a pour are drawn at random: the generator's state must go on too."""
    pour = Pour(x=(0.3, 1.7), y=(1.0, 1.3), count=20, volume_fraction=0.3, speed_down=5.0)
    box = Box("box", (0.0, 2.0), (0.0, 3.0))
    return handmade_scene(
        [], [], walls=[box], pours=(pour,), domain=((-1, 3), (-1, 4)), steps=9000, output_steps=500, probes=("box",),
        probe_steps=70,
    )  # fmt: skip


SCENES = {
    "inlets and outlets": lambda: case_scene(
        "quick_jump", *JUMP, "probes.stations={x: [2, 4], speed: 0.5, window: [0.4, 1.0]}"
    ),
    "inlets and outlets, equal discs": lambda: case_scene("quick_jump", *JUMP, "discs.sizes=null"),
    "inflow against time": lambda: case_scene(
        "quick_jump", *JUMP, "inflow.depth=null", "inflow.mean_speed=null",
        "inflow.table=[[0, 0.2, 6], [0.6, 0.6, 10], [0.8, 0.3, 8]]",
    ),
    "gate, friction, spin": lambda: case_scene(
        "wave_structure", "run.duration=0.1", "initial.0.settle=0.1", "run.output_interval=0.01",
        "contact.rotation=true", "contact.friction=0.1",
    ),
    "thesis friction": lambda: case_scene(
        "dam_break", "run.duration=0.1", "run.output_interval=0.01", "contact.friction=0.2", "contact.friction_law=sign"
    ),
    "springs": lambda: case_scene(
        "wave_structure", "run.duration=0.1", "initial.0.settle=0.1", "run.output_interval=0.01",
        "contact.rotation=true", "contact.friction=0.5", "contact.friction_law=history",
        "contact.rolling={friction: 0.1}",
    ),
    "channel": lambda: case_scene("inclined_flow", "run.duration=0.05", "run.output_interval=0.01"),
    "pour": pouring,
}  # fmt: skip


def run_in_parts(scene, folder: Path, fractions=(0.3, 0.7), **options):
    """Run a scene, interrupted at the given fractions of its steps and continued."""
    checkpoint = None
    for fraction in (*fractions, 1.0):
        stop = int(fraction * scene.steps)
        result = run_native(scene, folder, stop_at=stop, resume=checkpoint, **options)
        checkpoint = read_checkpoint(folder)
        if fraction < 1:
            assert result.status == "interrupted" and "--resume" in result.message
            assert checkpoint.step == result.steps == stop
    return result


@pytest.mark.parametrize(
    ("name", "dump_format"),
    [
        *(some_long((name, "binary"), number % 2 > 0) for number, name in enumerate(SCENES)),
        ("inlets and outlets", "text"),
        some_long(("inlets and outlets", "gz")),
    ],
)
def test_continued_is_the_same_bit_for_bit(name, dump_format, tmp_path):
    scene = SCENES[name]()
    whole = run_native(scene, tmp_path / "whole", dump_format=dump_format)
    fractions = (0.1, 0.2) if name == "pour" else (0.3, 0.7)  # 8, 12 of its 20 discs have come
    parts = run_in_parts(scene, tmp_path / "parts", fractions, dump_format=dump_format)
    assert parts.status == whole.status == "complete" and len(parts.resumed) == 2
    for field in ("steps", "disc_steps", "inserted", "present", "removed", "lost", "ledger"):
        assert getattr(parts, field) == getattr(whole, field)
    if name.startswith("inlets and outlets"):
        assert whole.removed > 0
    if name == "pour":
        assert whole.inserted == 20
    one, two = (list(open_dump(next((tmp_path / k).glob("dump.lammps*")))) for k in ("whole", "parts"))
    assert [frame.step for frame in two] == [frame.step for frame in one]
    for a, b in zip(one, two, strict=True):
        assert all(np.array_equal(getattr(a, c), getattr(b, c)) for c in ("ids", "x", "y", "vx", "vy"))
    if scene.probes:
        assert (tmp_path / "parts/forces.csv").read_bytes() == (tmp_path / "whole/forces.csv").read_bytes()


def test_state_holds_every_bit(tmp_path):
    """Text has ten digits: compare the arrays themselves, with new lists to be made in between."""
    scene = SCENES["inlets and outlets"]()
    whole = NativeSimulation(scene)
    whole.run(4321)
    save_state(whole, tmp_path / "state.npz")
    other = load_state(scene, tmp_path / "state.npz")
    assert other.rebuilds == whole.rebuilds
    for simulation in (whole, other):
        simulation.run(1500)
    assert other.rebuilds == whole.rebuilds
    assert np.array_equal(other.positions, whole.positions)
    assert np.array_equal(other.velocities, whole.velocities)
    assert other.forces == whole.forces and other.ledger == whole.ledger


def test_what_a_killed_part_wrote_is_cut_off(tmp_path):
    scene = SCENES["inlets and outlets"]()
    run_native(scene, tmp_path / "whole")
    folder = tmp_path / "parts"
    run_native(scene, folder, stop_at=2000)
    dump = folder / "dump.lammpstrj"
    with dump.open("ab") as file:  # a frame, and half of one more
        file.write(dump.read_bytes()[:1500])
    run_native(scene, folder, resume=read_checkpoint(folder))
    assert dump.read_bytes() == (tmp_path / "whole/dump.lammpstrj").read_bytes()


def test_a_new_run_forgets_the_checkpoint_of_another(tmp_path):
    scene = SCENES["inlets and outlets"]()
    run_native(scene, tmp_path, stop_at=1000)
    assert read_checkpoint(tmp_path) is not None
    run_native(replace(scene, steps=10), tmp_path)
    assert read_checkpoint(tmp_path) is None and not list(tmp_path.glob("checkpoint*"))


def test_an_interruption_in_the_midst_of_a_step_saves_nothing(tmp_path, monkeypatch):
    """The second Ctrl-C does not wait: arrays may be half sorted."""
    scene = SCENES["inlets and outlets"]()

    def pressed_twice(self, target):
        self.step += 1
        raise KeyboardInterrupt

    monkeypatch.setattr(NativeSimulation, "run_some", pressed_twice)
    result = run_native(scene, tmp_path)
    assert result.status == "interrupted" and "cannot go on: a second interruption" in result.message
    assert read_checkpoint(tmp_path) is None


def test_a_full_disk_is_told(tmp_path, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("lammps_jump.engines.native.engine.save_state", full)
    scene = SCENES["inlets and outlets"]()
    result = run_native(scene, tmp_path, stop_at=1000)
    assert result.status == "interrupted" and "cannot go on: its state could not be saved" in result.message
    assert "No space left" in result.message and read_checkpoint(tmp_path) is None


# --- the whole job -----------------------------------------------------------------------------------------------


CHANGES = ["engine.name=native", "run.duration=1.2", "run.output_interval=0.05", "initial=[]"]


def job(folder: Path, changes=CHANGES, **options):
    return run_case(INPUTS / "quick_jump.yaml", folder, changes, **options)


@pytest.fixture
def light(monkeypatch):
    """No figures: seconds for each folder, and other tests look at them."""
    without_analysis(monkeypatch)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A run folder of a run that was interrupted half way; tests work on copies."""
    folder = tmp_path_factory.mktemp("stopped") / "run"
    with pytest.MonkeyPatch.context() as patch:
        without_analysis(patch)
        patch.setattr(choice, "choose", choose_to_stop_at(2500))
        with pytest.raises(RunInterrupted, match=r"lammps-jump run .* --resume"):
            job(folder)
    return folder


@pytest.fixture
def interrupted(stopped, tmp_path, light):
    """A copy of the folder of a run that was interrupted half way."""
    return Path(shutil.copytree(stopped, tmp_path / "run"))


def snapshot(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def resume(folder: Path, changes=CHANGES):
    return run_case(INPUTS / "quick_jump.yaml", folder, changes, resume=True)


def test_folder_afterwards_is_that_of_an_uninterrupted_run(tmp_path, interrupted):
    first = json.loads((interrupted / "summary.json").read_text())
    assert first["status"] == "interrupted" and first["steps"] == 2500
    (interrupted / "fields.vti").write_bytes(b"")  # of the analysis of the part
    summary = resume(interrupted)
    whole = job(tmp_path / "whole")
    for key in ("status", "steps", "simulated_time", "disc_steps", "discs", "ledger", "message", "case_hash"):
        assert summary[key] == whole[key]
    assert summary["resumed_at"] == [first["simulated_time"]] and "resumed_at" not in whole
    for name, seconds in first["wall_seconds"].items():
        assert summary["wall_seconds"][name] >= seconds
    names = [{str(path.relative_to(place)) for path in place.rglob("*")} for place in (interrupted, tmp_path / "whole")]
    assert names[0] == names[1]
    for name in ("dump.lammpstrj", "forces.csv", "case.yaml"):
        assert (interrupted / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    before = snapshot(interrupted)
    resume(interrupted)
    assert snapshot(interrupted) == before  # nothing is left to do


def test_the_folder_alone_is_enough(interrupted):
    cli.run(interrupted, resume=True)
    summary = lj.open_run(interrupted).summary
    assert summary["status"] == "complete" and summary["steps"] == case_scene("quick_jump", *CHANGES).steps


def test_a_run_that_was_killed_in_its_analysis_can_go_on(interrupted):
    (interrupted / "summary.json").unlink()
    assert resume(interrupted)["status"] == "complete"


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda folder: None, "differs from the case"),
        (lambda folder: (folder / CHECKPOINT_FILE).write_text("{"), "cannot be read"),
        (lambda folder: next(folder.glob("checkpoint-*.npz")).unlink(), r"0 bytes, \d+ or more"),
        (lambda folder: os.truncate(folder / "dump.lammpstrj", 100), "100 bytes"),
        (lambda folder: (folder / "case.yaml").unlink(), "holds no run"),
        (lambda folder: set_in(folder / "summary.json", status="failed"), "has failed"),
        (lambda folder: set_in(folder / CHECKPOINT_FILE, scene="another"), "this version of lammps-jump"),
    ],
)
def test_what_cannot_go_on_is_refused_untouched(interrupted, spoil, message):
    spoil(interrupted)
    before = snapshot(interrupted)
    changes = [*CHANGES, "contact.restitution=0.5"] if message.startswith("differs") else CHANGES
    with pytest.raises(ResumeError, match=message) as caught:
        resume(interrupted, changes)
    assert caught.value.exit_status == 2
    assert snapshot(interrupted) == before


@pytest.mark.parametrize("left", ["no folder", "a built folder", "a run without a checkpoint"])
def test_without_a_checkpoint_the_run_starts_from_the_beginning(left, tmp_path, interrupted, caplog):
    caplog.set_level("INFO")
    folder = interrupted
    (folder / CHECKPOINT_FILE).unlink()
    if left != "a run without a checkpoint":
        folder = tmp_path / "another"
    if left == "a built folder":
        cli.build(INPUTS / "quick_jump.yaml", out=folder, set_=CHANGES)
    found = resume(folder)
    assert found["status"] == "complete" and "resumed_at" not in found
    assert "no checkpoint: the run starts from the beginning" in caplog.text


def set_in(path: Path, **values) -> None:
    """Other values in a JSON file; in a checkpoint, whose sum is then that of its content again."""
    content = {**json.loads(path.read_text()), **values}
    if content.pop("sum", None):
        content["sum"] = sum_of(content)
    path.write_text(json.dumps(content))


def test_resume_and_force_exclude_each_other(tmp_path):
    with pytest.raises(CaseError, match="use one of the two"):
        cli.build_and_run(INPUTS / "quick_jump.yaml", out=tmp_path, force=True, resume=True)
    assert not list(tmp_path.iterdir())


def test_an_interrupted_run_starts_anew_where_that_is_asked_for(interrupted):
    before = snapshot(interrupted)
    with pytest.raises(SetupError, match="was interrupted; --resume goes on with it, --force deletes it"):
        job(interrupted)
    assert snapshot(interrupted) == before
    summary = job(interrupted, force=True)
    assert summary["status"] == "complete" and "resumed_at" not in summary
    assert not list(interrupted.glob("checkpoint*"))


@pytest.mark.long
def test_sigterm_ends_the_engine_politely_and_the_run_goes_on(tmp_path, monkeypatch, light, capsys):
    """The signal of a batch system; then `lammps-jump run FOLDER --resume`, and the frames to the last digit."""
    changes = ["run.duration=40", "run.output_interval=0.5"]
    options = ["--engine", "native", *(word for text in changes for word in ("--set", text)), "--quiet"]
    status, output = run_program(
        "build-and-run", INPUTS / "energy_box_16.yaml", "--out", tmp_path, *options, signal_at=(signal.SIGTERM, 30_000)
    )
    assert status == 75 and "--resume" in output
    scene = case_scene("energy_box_16", *changes)
    assert read_checkpoint(tmp_path).step == 30_000 < scene.steps
    cli.run(tmp_path, resume=True, quiet=True)
    run_native(scene, tmp_path / "whole")
    assert (tmp_path / "dump.lammpstrj").read_bytes() == (tmp_path / "whole/dump.lammpstrj").read_bytes()
    monkeypatch.setattr(sys, "argv", ["lammps-jump", "run", str(tmp_path), "--resume"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 0 and "nothing to do" in capsys.readouterr().out


# --- small parts -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGXCPU"])
def test_signals_are_counted_or_raised(name, ctrl_c_heard):
    number = getattr(signal, name)
    assert number in SIGNALS  # else it would end the process of the tests
    before = signal.getsignal(number)
    with terminate_as_interrupt():
        with counted_interrupts(most=2) as pressed:
            for k in range(3):
                assert pressed() == k
                if k < 2:
                    signal.raise_signal(number)
            with pytest.raises(KeyboardInterrupt):  # one too many does not wait
                signal.raise_signal(number)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(number) is before


def test_an_ignored_signal_stays_ignored():
    """A shell ignores Ctrl-C in jobs that it puts into the background."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with counted_interrupts() as pressed:
            signal.raise_signal(signal.SIGINT)
            assert pressed() == 0
            signal.raise_signal(signal.SIGTERM)
            assert pressed() == 1
    finally:
        signal.signal(signal.SIGINT, before)


def test_the_key_of_a_scene_is_of_the_numbers():
    scene = SCENES["inlets and outlets"]()
    assert scene_key(scene) == scene_key(replace(scene, description="other words", warnings=("x",)))
    assert scene_key(scene) != scene_key(replace(scene, skin=1.0000001 * scene.skin))
    discs = case_scene("dam_break")
    assert scene_key(discs) != scene_key(replace(discs, positions=discs.positions + 1e-15))


def test_message_says_how_to_go_on():
    scene = SCENES["inlets and outlets"]()
    text = interruption(scene, 1000, "runs/x", again=1.2)
    assert f"ended at t = {scene.time(1000):.4g} s of {scene.time(scene.steps):.4g} s" in text
    assert "`lammps-jump run runs/x --resume`" in text and "t = 1.2 s" in text
    assert "cannot go on: why" in interruption(scene, 1000, "runs/x", reason="why")


def test_progress_of_a_part_tells_its_own_speed(capsys):
    clock = iter((0.0, 0.0, 20.0))
    line = ProgressLine(10.0, stream=sys.stdout, clock=lambda: next(clock))
    line(Progress(step=900, steps=1000, time=9.0, discs=10**6))
    line(Progress(step=950, steps=1000, time=9.5, discs=10**6))
    assert "95 %" in (text := capsys.readouterr().out) and "2.5 M disc-steps/s" in text and "20 s left" in text


@pytest.mark.parametrize("what", ["n", "compressed", "nothing", "text", "missing"])
@pytest.mark.fault("flipped bits")
def test_a_state_that_was_made_up_is_refused(tmp_path, what):
    """With n = 10^9 it took minutes and all memory."""
    scene, path = pouring(), tmp_path / "checkpoint-0.npz"
    save_state(NativeSimulation(scene), path)
    with np.load(path) as stored:
        arrays = dict(stored)
    if what == "n":
        arrays["plain"] = np.array(json.dumps({**json.loads(str(arrays["plain"])), "n": 10**9}))
    if what == "missing":
        del arrays["near_discs"]
    path.unlink()
    (np.savez_compressed if what == "compressed" else np.savez)(path, **arrays)
    if what in ("nothing", "text"):
        path.write_text("" if what == "nothing" else "no state")
    with pytest.raises(ResumeError, match=r"checkpoint-0\.npz: is no state that a run has saved"):
        load_state(scene, path)
