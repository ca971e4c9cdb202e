# SPDX-License-Identifier: GPL-2.0-or-later
"""The power fails while a checkpoint is written: what was not synchronised is there, lost or garbage, at random."""

from __future__ import annotations

import os
import random
from pathlib import Path

import pytest
from fault_table import many
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.engines.checkpoint import CheckpointWriter, read_checkpoint
from lammps_jump.engines.result import RunResult
from lammps_jump.files import write_bytes
from lammps_jump.folders import publish, staging

DUMP = "dump.lammpstrj"


class Disk:
    """What a disk holds of a folder: bodies of files by inode, names in the folder, and what may still be lost."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.synced = self.bodies()
        self.names = self.entries()
        self.since: list[tuple[str, str, str]] = []
        self.moments: list[tuple[dict, dict, dict, list]] = []

    def bodies(self) -> dict[int, bytes]:
        return {path.stat().st_ino: path.read_bytes() for path in self.folder.iterdir()}

    def entries(self) -> dict[str, int]:
        return {path.name: path.stat().st_ino for path in self.folder.iterdir()}

    def note(self) -> None:
        """A moment at which the power may fail."""
        self.moments.append((dict(self.synced), dict(self.names), self.bodies(), list(self.since)))

    def watch(self, patch: pytest.MonkeyPatch) -> None:
        """Follow the calls that change the folder."""
        fsync, calls = os.fsync, {name: getattr(os, name) for name in ("replace", "link", "unlink")}

        def synchronised(place):
            self.note()
            fsync(place)
            path = Path(os.readlink(f"/proc/self/fd/{place}"))
            if path == self.folder:
                self.names, self.since = self.entries(), []
            else:
                self.synced[os.fstat(place).st_ino] = path.read_bytes()

        def follow(name):
            def call(one, other="", **options):
                self.note()
                words = (one, other) if other else (one,)
                calls[name](*words, **options)
                self.since.append((name, Path(one).name, Path(other).name))

            return call

        patch.setattr(os, "fsync", synchronised)
        for name in calls:
            patch.setattr(os, name, follow(name))

    def left(self, moment: int, dice: random.Random) -> dict[str, bytes]:
        """Files after the power failed at a moment."""
        synced, names, now, since = self.moments[moment]
        names = dict(names)
        for name, one, other in since[: dice.randint(0, len(since))]:  # a folder's changes reach the disk in order
            inode = names.get(one)
            if name in ("replace", "unlink"):
                names.pop(one, None)
            if name in ("replace", "link") and inode is not None:
                names[other] = inode
        found = {}
        for name, inode in {**names, **self._new(names, now, dice)}.items():
            sure, live = synced.get(inode, b""), now.get(inode, b"")
            garbage = dice.randbytes(max(len(live) - len(sure), 0))
            found[name] = sure if sure == live else dice.choice([sure, live, sure + garbage])
        return found

    def _new(self, names: dict[str, int], now: dict[int, bytes], dice: random.Random) -> dict[str, int]:
        """Files that were made since the folder was synchronised may be there or not."""
        known = set(names.values())
        return {f"new-{inode}": inode for inode in now if inode not in known and dice.random() < 0.5}


@pytest.fixture(scope="module")
def scene():
    return lj.load_case(INPUTS / "quick_jump.yaml").scene()


def save(writer: CheckpointWriter, folder: Path, step: int) -> None:
    """A checkpoint as the native engine makes it, after frames were added."""
    with (folder / DUMP).open("ab") as file:
        file.write(b"frame %d\n" % step * 50)
    (folder / f"checkpoint-{step}.npz").write_bytes(b"state %d" % step * 100)
    result = RunResult("native", "core", "interrupted", "", step, 1.0, 5, 5, 0, 0, 1.0)
    assert writer.save(lambda: [f"checkpoint-{step}.npz"], result) == ""


@pytest.mark.fault("power cut, unsynced writes lost")
@pytest.mark.parametrize("earlier", [1, 2])
def test_the_old_or_the_new_checkpoint_is_whole(scene, tmp_path, tried, earlier):
    folder, after = tmp_path / "run", tmp_path / "after"
    folder.mkdir()
    writer = CheckpointWriter(scene, folder, [DUMP])
    for number in range(1, earlier + 1):
        save(writer, folder, 100 * number)
    disk = Disk(folder)
    with pytest.MonkeyPatch.context() as patch:
        disk.watch(patch)
        save(writer, folder, 100 * (earlier + 1))
    disk.note()
    times, steps = many(10, 300), set()
    for seed in range(times):
        dice = random.Random(seed)
        after.mkdir()
        for name, body in disk.left(seed % len(disk.moments), dice).items():
            (after / name).write_bytes(body)
        steps.add(read_checkpoint(after).step)
        for path in after.iterdir():
            path.unlink()
        after.rmdir()
    assert steps == {100 * earlier, 100 * (earlier + 1)}
    tried(times)


@pytest.mark.fault("power cut, unsynced writes lost")
def test_a_file_is_on_the_disk_before_it_takes_its_name_and_its_name_after(tmp_path, monkeypatch):
    done, replace = [], os.replace
    monkeypatch.setattr(os, "fsync", lambda place: done.append(Path(os.readlink(f"/proc/self/fd/{place}"))))
    monkeypatch.setattr(os, "replace", lambda *names: done.append("moved") or replace(*names))
    path = write_bytes(tmp_path / "summary.json", b"{}")
    assert path.read_bytes() == b"{}" and done == [tmp_path / ".summary.json.new", "moved", tmp_path]


@pytest.mark.fault("power cut, unsynced writes lost")
def test_results_are_on_the_disk_before_they_are_published(tmp_path, monkeypatch):
    done, replace = [], os.replace
    monkeypatch.setattr(os, "fsync", lambda place: done.append(Path(os.readlink(f"/proc/self/fd/{place}"))))
    monkeypatch.setattr(os, "replace", lambda one, other: done.append(Path(other)) or replace(one, other))
    with staging(tmp_path) as stage:
        path = write_bytes(stage / "profiles.nc", b"[]")
        assert done == [path]  # moved alone: nobody reads it there after the power failed
        publish(stage, tmp_path)
    assert done == [path, path, tmp_path / "profiles.nc"] and (tmp_path / "profiles.nc").read_bytes() == b"[]"
