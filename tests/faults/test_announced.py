# SPDX-License-Identifier: GPL-2.0-or-later
"""Counts and lengths that a dump announces: memory is asked for what has arrived, and the rest is one sentence."""

from __future__ import annotations

import gzip
import random
import struct
import threading
import tracemalloc
import warnings
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from fault_table import many
from made_up import disc_frame
from mutants import LONGEST, mutant

from lammps_jump.dump.contacts import ContactFile, ContactWriter
from lammps_jump.dump.find import read_forces, table_of
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.tail import DumpTail, GrowingDump
from lammps_jump.dump.walls import PoseFile, read_bodies
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import BODIES_HEADER, FORCES_HEADER, POSES_HEADER

MOST = 24_000_000
"""Bytes that a dump of a kilobyte may ask for: room for 2^20 values twice, and buffers."""
NAMES = ("id", "x", "y", "vx", "vy")
FORMATS = ("text", "gz", "binary")
ENDINGS = {"text": "lammpstrj", "gz": "lammpstrj.gz", "binary": "lammpsbin"}


def written(folder: Path, format: str, discs: int = 3, frames: int = 3) -> Path:
    """A dump of a few discs."""
    path = folder / f"dump.{ENDINGS[format]}"
    rest = np.linspace(0.5, 2.5, discs)
    with DumpWriter(path, NAMES, format) as out:
        for step in range(frames):
            out.write_frame(disc_frame(rest, rest, 1.0, box=[(0, 3), (0, 3)], step=step, time=0.1 * step))
    return path


def grown(path: Path, format: str) -> list[object]:
    """Frames of a dump whose engine has ended."""
    ended = threading.Event()
    ended.set()
    return list(GrowingDump(path, format, ended))


READERS: dict[str, Callable[[Path, str], object]] = {
    "whole": lambda path, format: list(open_dump(path)),
    "grown": grown,
    "tail": lambda path, format: list(DumpTail(path, format).new_frames(ended=True)),
}
PAIRS = [(reader, format) for reader in READERS for format in FORMATS if (reader, format) != ("grown", "gz")]
COUNTS = [2**22, 2**31 - 1, 2**32, 2**33]


def announcing(path: Path, format: str, count: int) -> None:
    """Let the last frame of a dump announce so many discs."""
    data = gzip.decompress(path.read_bytes()) if format == "gz" else path.read_bytes()
    if format == "binary":
        place = data.rindex(b"DUMPCUSTOM") + 10 + 8 + 8  # behind signature, byte order, revision and step
        data = data[:place] + struct.pack("<q", count) + data[place + 8 :]
    else:
        head, _, rest = data.rpartition(b"NUMBER OF ATOMS\n")
        data = head + b"NUMBER OF ATOMS\n%d\n" % count + rest.partition(b"\n")[2]
    path.write_bytes(gzip.compress(data) if format == "gz" else data)


def most_memory(call: Callable[[], object]) -> int:
    """Largest number of bytes that a call had at once."""
    tracemalloc.start()
    try:
        call()
    finally:
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    return most


@pytest.mark.fault("mutants of dumps")
@pytest.mark.parametrize(("reader", "format"), PAIRS)
def test_a_count_is_believed_as_far_as_discs_arrive(tmp_path, reader, format, tried):
    for count in COUNTS:
        path = written(tmp_path, format)
        announcing(path, format, count)

        def read(path=path):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    frames = READERS[reader](path, format)
                except DumpError as error:
                    assert "\n" not in str(error) and len(str(error)) < 600
                else:
                    assert [frame.n for frame in frames] == [3, 3]  # the last one is cut off

        assert most_memory(read) < MOST
    tried(len(COUNTS))


@pytest.mark.fault("mutants of dumps")
@pytest.mark.parametrize("reader", READERS)
def test_a_length_is_believed_as_far_as_bytes_arrive(tmp_path, reader, tried):
    path = written(tmp_path, "binary", frames=1)
    whole = path.read_bytes()
    for place in range(0, len(whole) - 4, 4):
        path.write_bytes(whole[:place] + (0x7FFFFFFF).to_bytes(4, "little") + whole[place + 4 :])

        def read():
            try:
                assert all(frame.n <= 3 for frame in READERS[reader](path, "binary"))
            except DumpError as error:
                assert "\n" not in str(error)

        assert most_memory(read) < MOST
    tried(len(whole) // 4)


@pytest.mark.fault("mutants of dumps")
def test_columns_ask_for_no_room_before_their_discs(tmp_path):
    """A row of 30,000 names, and two milliard discs."""
    path = written(tmp_path, "text", frames=1)
    announcing(path, "text", 2**31)
    names = " ".join(f"c{n}" for n in range(30_000)).encode()
    path.write_bytes(path.read_bytes().replace(b"id x y vx vy", b"id x y vx vy " + names))

    def read():
        with pytest.raises(DumpError):
            grown(path, "text")

    assert most_memory(read) < 2 * MOST


@pytest.mark.parametrize("format", ["text", "binary"])
def test_frames_that_outgrow_their_room_are_whole(tmp_path, monkeypatch, format):
    """Numbers, rows that are read slowly among them, are the same with room for one disc and with room for all."""
    path = written(tmp_path, format, discs=400)
    if format == "text":
        path.write_text(path.read_text().replace("\n7 ", "\n7.00000000000000000000000 "))
    exact = open_dump(path)
    monkeypatch.setattr("lammps_jump.dump.formats.FIRST_VALUES", 1)
    found = grown(path, format)
    assert [frame.n for frame in found] == [400, 400, 400]
    for one, two in zip(exact, found, strict=True):
        assert all(np.array_equal(one.columns[name], two.columns[name]) for name in NAMES)


# --- mutants ----------------------------------------------------------------------------------------------------------

BODY = ",".join(["{time}", "sled", *map(str, np.linspace(-1, 1, 9))])
SIDE_FILES: dict[str, tuple[str, Callable[[Path], object]]] = {
    "forces.csv": (
        FORCES_HEADER + "".join(f"\n0.{n},{name},1.5,-2,0.25" for n in range(1, 5) for name in ("sill", "bed")) + "\n",
        read_forces,
    ),
    "bodies.csv": (
        BODIES_HEADER + "".join("\n" + BODY.format(time=0.1 * n) for n in range(1, 5)) + "\n", read_bodies,
    ),
    "walls.csv": (
        POSES_HEADER + "".join(f"\n0.{n},lid,0.{n},0,0.0{n}" for n in range(1, 5)) + "\n",
        lambda path: [(file.at(0.25), file.rates(0.35)) for file in [PoseFile(path, ["lid"], 9)]],
    ),
    "table.csv": ("t,h\n0,1\n1,1.5\n2,1.7\n", lambda path: table_of(path.read_bytes(), "table.csv").numbers("h")),
}  # fmt: skip
"""What a run writes beside its dump, and what reads it."""


def contacts(folder: Path) -> Path:
    """Contacts of three frames."""
    path = folder / "contacts.bin"
    with closing(ContactWriter(path)) as out:
        for step in (0, 10, 20):
            out.write(step, np.array([[1, 2], [2, -1]]), np.full((2, 5), 0.5 + step))
    return path


def read_contacts(path: Path) -> None:
    """All that is asked of contacts."""
    file = ContactFile(path)
    for step in (20, 10, 0, 5):
        file.contacts(step)
        file.forces(step, np.array([1, 7]), np.array([2, -1]))


def refused_mutants(path: Path, read: Callable[[Path], object], times: int, *, packed: bool = False) -> int:
    """How many of so many mutants of a file are refused, each in a sentence; `packed`: also of what gzip holds."""
    whole, refused = path.read_bytes(), 0
    for seed in range(times):
        print(f"seed {seed}")
        dice = random.Random(f"{path.name} {seed}")
        data = gzip.compress(mutant(gzip.decompress(whole), dice)) if packed and seed % 2 else mutant(whole, dice)
        path.write_bytes(data)
        said: list[str] = []

        def tell(said=said):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    read(path)
                except JumpError as error:
                    said.append(str(error))

        assert most_memory(tell) < MOST
        assert all("\n" not in text and 0 < len(text) < LONGEST for text in said)
        refused += len(said)
        assert path.read_bytes() == data
    return refused


@pytest.mark.fault("mutants of tables of a run")
@pytest.mark.parametrize("name", [*SIDE_FILES, "contacts.bin"])
def test_mutants_of_what_stands_beside_a_dump(tmp_path, name, tried):
    if name in SIDE_FILES:
        path = tmp_path / name
        text, read = SIDE_FILES[name]
        path.write_text(text)
    else:
        path, read = contacts(tmp_path), read_contacts
    read(path)  # as it is
    times = many(20, 2000)
    assert 0 < refused_mutants(path, read, times) < times
    tried(times)


@pytest.mark.fault("mutants of dumps")
@pytest.mark.parametrize(("reader", "format"), PAIRS)
def test_mutants_of_dumps_of_each_format(tmp_path, reader, format, tried):
    path, times = written(tmp_path, format), many(20, 2000)
    whole, read = path.read_bytes(), READERS[reader]
    assert len(list(read(path, format))) == 3 and path.read_bytes() == whole
    assert 0 < refused_mutants(path, lambda path: read(path, format), times, packed=format == "gz") <= times
    tried(times)
