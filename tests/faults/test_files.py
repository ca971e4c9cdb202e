# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of a run folder that cannot be written, are cut, or hold a flipped bit: the folder says the truth."""

from __future__ import annotations

import errno
import gzip
import io
import json
import os
import random
import shutil
from pathlib import Path

import pytest
from fault_table import LONG, many
from made_up import INPUTS, troubles, without_analysis

import lammps_jump as lj
from lammps_jump.dump.check import force_troubles
from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import change_text, write_bytes
from lammps_jump.runs import start

pytestmark = pytest.mark.usefixtures("blank_pictures")

CHANGES = {
    "run.duration": 0.3,
    "run.output_interval": 0.02,
    "engine.name": "native",
    "analysis.jump": False,
    "initial": [],
}
DUMP, FORCES = "dump.lammpstrj", "forces.csv"
JSON_FILES = ("summary.json", ".lammps-jump")


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", CHANGES)


@pytest.fixture(scope="module")
def finished(case, tmp_path_factory):
    return case.run(tmp_path_factory.mktemp("finished") / "run")


@pytest.fixture
def folder(finished, tmp_path):
    return Path(shutil.copytree(finished.folder, tmp_path / "run"))


# --- writes that fail


class FaultyFiles:
    """System calls on the files of a folder; the N-th fails, or all from the N-th on."""

    def __init__(self, folder: Path, number: int, error: int, *, persistent: bool):
        self.folder, self.left, self.error, self.persistent = str(folder), number, error, persistent
        self.met = ""

    def __call__(self, place, name: str) -> None:
        """Raise the error where this call is the one, and concerns the folder."""
        if isinstance(place, int):
            place = os.readlink(f"/proc/self/fd/{place}")
        if not os.path.abspath(place).startswith(self.folder):
            return
        self.left -= 1
        if self.left == 0 or (self.left < 0 and self.persistent):
            self.met = f"{name} of {place}"
            raise OSError(self.error, os.strerror(self.error), str(place))

    def patched(self, patch: pytest.MonkeyPatch) -> None:
        """Put the calls in place."""
        for name in ("fsync", "replace", "unlink", "mkdir", "open", "truncate"):
            patch.setattr(os, name, self._failing(getattr(os, name), name))

        real = io.open

        def opened(place, *arguments, **options):
            file = real(place, *arguments, **options)
            if "w" in file.mode and isinstance(file, io.BufferedWriter):
                return FaultyWriter(file, self)
            return file

        patch.setattr("lammps_jump.files.open", opened, raising=False)

    def _failing(self, real, name: str):
        def call(place, *arguments, **options):
            if name != "open" or arguments[0] & os.O_CREAT:  # reading is not the matter here
                self(place, name)
            return real(place, *arguments, **options)

        return call


class FaultyWriter:
    """A file that is being written."""

    def __init__(self, file, faults: FaultyFiles):
        self.file, self.faults = file, faults

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.file.close()

    def __getattr__(self, name):
        return getattr(self.file, name)

    def write(self, data):
        """Write a part of it, then fail where that is asked for."""
        self.file.write(data[: len(data) // 2])
        self.file.flush()
        self.faults(self.file.fileno(), "write")
        return self.file.write(data[len(data) // 2 :])


@pytest.mark.fault("files that cannot be written")
@pytest.mark.parametrize("persistent", [False, True], ids=["once", "from then on"])
@pytest.mark.parametrize(
    "change",
    [lambda path: write_bytes(path, b"a new one"), lambda path: change_text(path, "old", "a new one")],
    ids=["ours", "of the user"],
)
def test_a_file_is_old_or_new_whatever_fails(tmp_path, tried, change, persistent):
    path = tmp_path / "file.json"
    path.write_bytes(b"old")
    for number in range(1, 20):
        faults = FaultyFiles(tmp_path, number, errno.EIO, persistent=persistent)
        with pytest.MonkeyPatch.context() as patch:
            faults.patched(patch)
            try:
                change(path)
            except OSError as error:
                assert error.errno == errno.EIO
        if not faults.met:
            break
        assert path.read_bytes() in (b"old", b"a new one"), faults.met
        path.write_bytes(b"old")
    assert 5 < number < 19 and path.read_bytes() == b"a new one"
    tried(number - 1)


def said_truth(folder: Path, dump: bytes) -> None:
    """What stands in a folder after a fault is whole, and no run that is not is called complete."""
    found = {name: json.loads((folder / name).read_text()) for name in JSON_FILES if (folder / name).exists()}
    if found.get("summary.json", {}).get("status") == "complete":
        assert (folder / DUMP).read_bytes() == dump
    if (folder / "case.yaml").exists():
        lj.load_case(folder)


@pytest.mark.fault("files that cannot be written")
@pytest.mark.parametrize(
    ("code", "persistent"),
    [
        pytest.param(errno.ENOSPC, True, id="no space from then on"),
        pytest.param(errno.EIO, False, id="bad disk once", marks=pytest.mark.long),
        pytest.param(errno.ENOSPC, False, id="no space once", marks=pytest.mark.long),
        pytest.param(errno.EIO, True, id="bad disk from then on", marks=pytest.mark.long),
    ],
)
def test_a_run_tells_the_truth_whatever_fails(case, finished, tmp_path, monkeypatch, tried, persistent, code):
    """At the N-th call for N = 1, 2, … until none is met; then the run is made without a fault."""
    without_analysis(monkeypatch)
    result, dump = finished.result, (finished.folder / DUMP).read_bytes()

    def run(scene, folder, *arguments, **options):
        for name in (DUMP, FORCES):
            shutil.copy(finished.folder / name, folder)
        return result

    monkeypatch.setattr(start.engines, "run", run)
    number, times = 1, 0
    while True:
        folder = tmp_path / str(number)
        faults = FaultyFiles(folder, number, code, persistent=persistent)
        with pytest.MonkeyPatch.context() as patch:
            faults.patched(patch)
            try:
                case.run(folder)
            except JumpError as error:
                assert faults.met and "\n" not in str(error), faults.met
            except OSError as error:  # the command line says it in one sentence
                assert error.filename or error.strerror, faults.met
        if not faults.met:
            break
        times += 1
        (folder / ".lock").unlink(missing_ok=True)  # as if the process had ended
        if folder.exists():
            said_truth(folder, dump)
        done = again(case, folder)
        assert done.status == "complete" and (folder / DUMP).read_bytes() == dump, faults.met
        shutil.rmtree(folder)
        number += 1 if LONG or number < 6 else 7
    assert times > 10
    tried(times)


def again(case, folder: Path):
    """The same run without a fault; anew where the folder says that it cannot go on."""
    try:
        return case.run(folder, resume=True)
    except JumpError:
        return case.run(folder, force=True)


# --- files that are cut, or differ by a bit


def test_an_intact_run_has_no_trouble(finished):
    assert troubles(finished.folder, finished) == []


@pytest.mark.fault("cut files")
def test_a_cut_dump_is_found_at_every_byte(finished, tmp_path, tried):
    """Of the last two frames, half of them in the long form."""
    data = (finished.folder / DUMP).read_bytes()
    start_of_two = data.rfind(b"ITEM: TIME\n", 0, data.rfind(b"ITEM: TIME\n"))
    shutil.copy(finished.folder / FORCES, tmp_path)
    places = range(start_of_two, len(data) - 1)
    for place in random.Random(1).sample(places, many(30, len(places) // 2)):
        (tmp_path / DUMP).write_bytes(data[:place])
        assert troubles(tmp_path, finished), place
    tried(many(30, len(places) // 2))


@pytest.mark.fault("cut files")
def test_a_cut_gzip_dump_is_found_at_every_byte(finished, tmp_path, tried):
    data = gzip.compress((finished.folder / DUMP).read_bytes())
    shutil.copy(finished.folder / FORCES, tmp_path)
    places = random.Random(2).sample(range(1, len(data)), many(20, 500))
    for place in places:
        (tmp_path / f"{DUMP}.gz").write_bytes(data[:place])
        assert troubles(tmp_path, finished), place
    tried(len(places))


@pytest.mark.fault("cut files")
def test_a_cut_force_record_is_found_at_every_byte(finished, tmp_path, tried):
    data = (finished.folder / FORCES).read_bytes()
    last = data.rfind(b",") + 1  # behind it only digits of the last number are missing
    places = range(last) if LONG else random.Random(3).sample(range(last), 60)
    for place in places:
        (tmp_path / FORCES).write_bytes(data[:place])
        assert force_troubles(tmp_path / FORCES, finished.scene, finished.scene.steps), place
    tried(len(places))


@pytest.mark.fault("flipped bits")
def test_a_flipped_bit_is_found_by_the_checksum(case, finished, folder, tried, monkeypatch):
    """In what the engine wrote the run is refused; in a result it is made again."""
    without_analysis(monkeypatch)
    dice = random.Random(4)
    for number in range(many(12, 200)):
        name = dice.choice([DUMP, FORCES])
        data = bytearray((finished.folder / name).read_bytes())
        data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
        (folder / name).write_bytes(data)
        with pytest.raises(DumpError, match="not what the run wrote") as caught:
            start.reanalyse(folder)
        assert f"{name} differs" in str(caught.value), number
        shutil.copy(finished.folder / name, folder)
    case.run(folder, force=True)
    for _ in range(many(6, 60)):
        name = "profiles.nc"
        data = bytearray((folder / name).read_bytes())
        data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
        (folder / name).write_bytes(data)
        run = case.run(folder)
        assert run.status == "complete" and (folder / DUMP).read_bytes() == (finished.folder / DUMP).read_bytes()
    tried(many(18, 260))


@pytest.mark.fault("flipped bits")
def test_a_flipped_bit_in_a_file_of_ours_is_believed_or_refused_in_a_sentence(case, finished, folder, tried):
    """Summary and marker hold no checksum of themselves: what they say of the files is held against those."""
    dice = random.Random(5)
    for _ in range(many(20, 240)):
        name = dice.choice(["summary.json", ".lammps-jump", "case.yaml"])
        data = bytearray((finished.folder / name).read_bytes())
        data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
        (folder / name).write_bytes(data)
        try:
            found = lj.open_run(folder)
            assert found.result.steps >= 0 and found.status
        except JumpError as error:
            assert "\n" not in str(error)
        except UnicodeDecodeError:
            pytest.fail(f"{name}: no sentence")
        shutil.copy(finished.folder / name, folder)
    tried(many(20, 240))
