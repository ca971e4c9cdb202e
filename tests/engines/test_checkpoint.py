# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints in a folder: when they are due, the order of their writing, what is damaged, what is cut off."""

from __future__ import annotations

import gzip
import json
import os
import random
import shutil
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.dump.read import open_dump
from lammps_jump.engines import checkpoint as checkpoints
from lammps_jump.engines.checkpoint import (
    CHECKPOINT_FILE,
    PREVIOUS_FILE,
    CheckpointWriter,
    cut_back,
    join_part,
    last_saved,
    read_checkpoint,
    remove_checkpoint,
)
from lammps_jump.engines.interrupts import save_request
from lammps_jump.engines.native import run_native
from lammps_jump.engines.result import RunResult
from lammps_jump.errors import ResumeError
from lammps_jump.files import BINARY_PART, DUMP_NAMES

DUMP = DUMP_NAMES["text"]


@pytest.fixture
def scene():
    return load_case(INPUTS / "energy_box_16.yaml", ["run.duration=2"]).scene()


def result(step: int) -> RunResult:
    return RunResult("native", "core", "interrupted", "", step, 1.0, 16, 16, 0, 0, 1.0)


def write(writer: CheckpointWriter, step: int, more: bytes = b"a frame\n") -> None:
    """A checkpoint at a step, after the dump has grown."""
    with (writer.folder / DUMP).open("ab") as file:
        file.write(more)
    (writer.folder / f"checkpoint-{step}.npz").write_bytes(b"state of %d" % step)
    writer.save(lambda: [f"checkpoint-{step}.npz"], result(step))


@pytest.fixture
def writer(scene, tmp_path):
    return CheckpointWriter(scene, tmp_path, [DUMP, "forces.csv"])


def test_checkpoints_are_due_by_the_clock_and_never_take_a_hundredth_of_the_run(scene, tmp_path, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(checkpoints, "time", SimpleNamespace(monotonic=lambda: now[0]))
    writer = CheckpointWriter(scene, tmp_path, [], 60.0)
    for time, due in ((59, False), (60, True), (61, True)):
        now[0] = time
        assert writer.due() is due
    for spent, until in ((0.5, 60), (0.0, 60), (3.0, 300)):
        now[0] = 1000.0

        def make(spent=spent):
            now[0] += spent
            raise OSError("the disk is full")

        assert writer.save(make, result(1)) == "its state could not be saved (the disk is full)"
        now[0] += until - 1
        assert not writer.due()
        now[0] += 1
        assert writer.due()


def test_a_checkpoint_names_its_files_with_size_and_sum(writer, tmp_path):
    (tmp_path / "forces.csv").write_text("time\n1\n")
    for step in (10, 20):
        write(writer, step)
    found = read_checkpoint(tmp_path)
    assert found.step == 20
    assert {name: entry.size for name, entry in found.outputs.items()} == {
        DUMP: 16,
        "forces.csv": 7,
    }
    assert found == read_checkpoint(tmp_path) and last_saved(tmp_path) == found.time
    again = CheckpointWriter(writer.scene, tmp_path, [DUMP, "forces.csv"])  # one that has not seen it grow
    assert again.save(lambda: ["checkpoint-20.npz"], result(20)) == ""
    assert read_checkpoint(tmp_path).outputs == found.outputs


def test_two_checkpoints_stand_and_no_more(writer, tmp_path):
    """One that is never renewed is of no use (GROMACS issue 4810)."""
    for step in (10, 20, 30, 40):
        write(writer, step)
    steps = [json.loads((tmp_path / name).read_text())["step"] for name in (CHECKPOINT_FILE, PREVIOUS_FILE)]
    assert steps == [40, 30]
    assert sorted(path.name for path in tmp_path.glob("checkpoint-*")) == ["checkpoint-30.npz", "checkpoint-40.npz"]
    (tmp_path / "forces_sill.raw").touch()
    (tmp_path / "checkpoint-of-mine.npz").touch()
    remove_checkpoint(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["checkpoint-of-mine.npz", DUMP]


@pytest.mark.parametrize("damaged", [CHECKPOINT_FILE, "checkpoint-20.npz"])
def test_any_damage_to_the_newest_leads_to_the_one_before(writer, tmp_path, damaged, caplog):
    """Cut at every byte, and 60 single bits."""
    for step in (10, 20):
        write(writer, step)
    path, whole = tmp_path / damaged, (tmp_path / damaged).read_bytes()
    bits = random.Random(1)
    spoilt = [whole[:end] for end in range(0, len(whole), 1 if len(whole) < 100 else 23)]
    for _ in range(60):
        place, bit = bits.randrange(len(whole)), 1 << bits.randrange(8)
        spoilt.append(whole[:place] + bytes([whole[place] ^ bit]) + whole[place + 1 :])
    for text in spoilt:
        path.write_bytes(text)
        try:
            same = json.loads(text) == json.loads(whole)
        except ValueError:
            same = False
        with caplog.at_level("INFO"):
            assert read_checkpoint(tmp_path).step == (20 if same else 10), text
        assert same or "the checkpoint before it is used" in caplog.messages[-1]
    (tmp_path / "checkpoint-10.npz").write_bytes(b"other of 10")
    with pytest.raises(ResumeError, match=r"SHA-256|bytes|cannot be read") as caught:
        read_checkpoint(tmp_path)
    assert "\n" not in str(caught.value) and str(tmp_path) in str(caught.value)


def test_an_output_that_was_changed_is_refused(writer, tmp_path):
    write(writer, 10)
    for text in (b"A frame\n", b"a fram\n\n", b""):
        (tmp_path / DUMP).write_bytes(text)
        with pytest.raises(ResumeError, match=rf"{DUMP}: (is not what the run had written|0 bytes)"):
            read_checkpoint(tmp_path)
    (tmp_path / DUMP).write_bytes(b"a frame\nand more")
    cut_back(tmp_path, read_checkpoint(tmp_path))
    assert (tmp_path / DUMP).read_bytes() == b"a frame\n"


CALLS = ("fsync", "replace", "link", "open")


class Killed(BaseException):
    """The process ends here."""


def third_write(scene, folder, monkeypatch, call, error, fails) -> int:
    """How often a function of `os` is called by the third write of a checkpoint; where `fails` says so it raises."""
    shutil.rmtree(folder)
    folder.mkdir()
    writer = CheckpointWriter(scene, folder, [DUMP])
    for step in (10, 20):
        write(writer, step)
    calls, real = 0, getattr(os, call)

    def failing(*arguments, **options):
        nonlocal calls
        calls += 1
        if fails(calls):
            raise error
        return real(*arguments, **options)

    with monkeypatch.context() as patch, suppress(type(error)):
        patch.setattr(os, call, failing)
        write(writer, 30)
    return calls


@pytest.mark.parametrize("call", CALLS)
def test_wherever_a_write_fails_a_checkpoint_is_whole(writer, tmp_path, monkeypatch, call):
    """The N-th call fails, for N until none does: once, and from then on. The newest or the one before can be read."""
    full = OSError(28, "No space left on device")
    for happens in ("__eq__", "__le__"):  # once, from then on
        for first in range(1, 60):
            calls = third_write(writer.scene, tmp_path, monkeypatch, call, full, getattr(first, happens))
            assert read_checkpoint(tmp_path).step in (20, 30)
            if calls < first:
                break
        assert first > 1 and calls < first


@pytest.mark.parametrize("call", ["fsync", "replace", "link", "unlink"])
def test_wherever_the_process_ends_a_checkpoint_is_whole(writer, tmp_path, monkeypatch, call):
    for first in range(1, 60):
        calls = third_write(writer.scene, tmp_path, monkeypatch, call, Killed(), first.__le__)
        found = read_checkpoint(tmp_path)
        assert found.step in (20, 30)
        cut_back(tmp_path, found)
        assert (tmp_path / DUMP).read_bytes() == (found.step // 10) * b"a frame\n"
        write(CheckpointWriter(writer.scene, tmp_path, [DUMP]), 40)  # the next part writes its own
        assert read_checkpoint(tmp_path).step == 40
        if calls < first:
            break
    assert calls < first


@pytest.mark.parametrize("members", [0, 1, 3])
def test_a_gzip_file_that_was_cut_between_two_blocks_is_ended(writer, tmp_path, members):
    """A checkpoint finds the stream flushed and not ended; what is appended must begin a stream of its own."""
    path = tmp_path / DUMP_NAMES["gz"]
    text = b"".join(b"%d one line of a frame\n" % k for k in range(3000))
    for _ in range(members):
        with gzip.open(path, "ab") as file:
            file.write(text)
    with gzip.open(path, "ab") as file:
        file.write(text)
        file.flush()
        writer = CheckpointWriter(writer.scene, tmp_path, [path.name])
        (tmp_path / "checkpoint-5.npz").touch()
        assert writer.save(lambda: ["checkpoint-5.npz"], result(5)) == ""
        file.write(text)
    for _ in range(2):  # also where the process ends behind it
        cut_back(tmp_path, read_checkpoint(tmp_path))
        assert gzip.decompress(path.read_bytes()) == (members + 1) * text
    with gzip.open(path, "ab") as file:
        file.write(b"the next part")
    assert gzip.decompress(path.read_bytes()) == (members + 1) * text + b"the next part"


def test_a_binary_part_is_joined_once(writer, tmp_path, monkeypatch):
    """Wherever the process ends: the next one cuts back and joins again."""
    whole, part = tmp_path / DUMP_NAMES["binary"], tmp_path / BINARY_PART
    for stop in ("copyfileobj", "flush", "put_checkpoint", None):
        whole.write_bytes(b"first part")
        part.write_bytes(b", second part, and more")
        (tmp_path / "checkpoint-5.npz").touch()
        writer = CheckpointWriter(writer.scene, tmp_path, [whole.name, part.name])
        os.truncate(part, 13)
        assert writer.save(lambda: ["checkpoint-5.npz"], result(5)) == ""
        part.write_bytes(b", second part, and more")
        if stop:
            with monkeypatch.context() as patch, pytest.raises(Killed):
                place = checkpoints.shutil if stop == "copyfileobj" else checkpoints
                real = getattr(place, stop)

                def ends(*arguments, real=real):
                    real(*arguments)
                    raise Killed

                patch.setattr(place, stop, ends)
                join_part(tmp_path)
        found = read_checkpoint(tmp_path)
        cut_back(tmp_path, found)
        join_part(tmp_path)
        assert whole.read_bytes() == b"first part, second part" and not part.exists()
        assert read_checkpoint(tmp_path).outputs.keys() == {whole.name}


@pytest.mark.parametrize("dump_format", DUMP_NAMES)
def test_a_native_run_that_ends_anywhere_goes_on_from_its_last_checkpoint(dump_format, scene, tmp_path, monkeypatch):
    """Checkpoints at steps; killed at others, also within the writing of one. The dump is that of a run without."""
    whole = tmp_path / "whole"
    done = run_native(scene, whole, dump_format=dump_format)
    folder, name = tmp_path / "run", DUMP_NAMES[dump_format]
    resume = None
    for parts, stop in enumerate((700, 1500, 3001, 5000)):

        def at_step(step, stop=stop):
            if step % 600 == 0:
                save_request.make()
            if step == stop:
                raise Killed

        monkeypatch.setattr("lammps_jump.engines.interrupts.at_step", at_step)
        with pytest.raises(Killed):
            run_native(scene, folder, dump_format=dump_format, resume=resume)
        resume = read_checkpoint(folder)
        assert resume.step == stop // 600 * 600 and resume.result.status == "interrupted"
        assert len(resume.result.resumed) == parts
    monkeypatch.setattr("lammps_jump.engines.interrupts.at_step", None)
    result = run_native(scene, folder, dump_format=dump_format, resume=resume)
    assert result.status == "complete" and result.resumed[-1] == scene.time(4800) and result.ledger == done.ledger
    if dump_format == "gz":
        one, two = (gzip.decompress((place / name).read_bytes()) for place in (whole, folder))
        assert one == two
    else:
        assert (folder / name).read_bytes() == (whole / name).read_bytes()
    frames = list(open_dump(folder / name))
    assert [frame.step for frame in frames] == [k * scene.output_steps for k in range(len(frames))]
    assert np.isfinite(frames[-1].x).all()
