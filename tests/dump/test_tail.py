# SPDX-License-Identifier: GPL-2.0-or-later
"""A dump that is read while it is written gives the frames of the whole file."""

import gzip
from hashlib import sha256

import numpy as np
import pytest

from lammps_jump.dump import tail
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.tail import GrowingDump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError

COLUMNS = ("id", "x", "y", "vx", "vy")


class Writer:
    """Stands for the event of the end: each wait brings the next piece of the file, the last one the end."""

    def __init__(self, path, data, piece):
        self.path, self.pieces, self.waits = path, [data[i : i + piece] for i in range(0, len(data), piece)], 0

    def is_set(self):
        return not self.pieces

    def wait(self, seconds):
        self.waits += 1
        if self.pieces:
            with self.path.open("ab") as file:
                file.write(self.pieces.pop(0))
        return self.is_set()


@pytest.fixture(params=["text", "binary"])
def whole(request, tmp_path):
    path, random = tmp_path / "whole", np.random.default_rng(1)
    with DumpWriter(path, COLUMNS, request.param) as writer:
        for step in range(5):
            values = random.uniform(0, 9, (4, 3 + step))
            columns = dict(zip(COLUMNS, (np.arange(3 + step) + 1, *values), strict=True))
            writer.write_frame(make_frame(step, 0.1 * step, [[0, 9], [0, 9]], columns))
    return open_dump(path)


@pytest.mark.parametrize("piece", [7, 100, 10**6])
def test_frames_are_those_of_the_whole_file(whole, tmp_path, piece):
    data = whole.path.read_bytes()
    writer = Writer(tmp_path / "grows", data, piece)
    grows = GrowingDump(tmp_path / "grows", whole.format, writer)
    for one, other in zip(grows, whole, strict=True):
        assert (one.step, one.time) == (other.step, other.time)
        for name in COLUMNS:
            np.testing.assert_array_equal(one.columns[name], other.columns[name])
    assert writer.waits >= len(data) // piece and grows.read.digest() == sha256(data).digest() and not grows.warnings


def test_a_gzip_dump_is_unpacked_in_pieces(whole, tmp_path, monkeypatch):
    """As much at a time as there is room for; all frames come, over as many calls."""
    if whole.format != "text":
        pytest.skip("only text is packed")
    monkeypatch.setattr(tail, "MOST_UNPACKED", 300)
    path = tmp_path / "dump.gz"
    data = whole.path.read_bytes()
    path.write_bytes(gzip.compress(data[:800]) + gzip.compress(data[800:]))  # a run that went on
    packed, steps, calls = tail.DumpTail(path, "gz"), [], 0
    while not packed.at_end:
        steps += [frame.step for frame in packed.new_frames(ended=True)]
        calls += 1
    assert steps == [0, 1, 2, 3, 4] and calls >= len(data) // 300


def test_a_gzip_bomb_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(tail, "MOST_UNPACKED", 1_000_000)
    path = tmp_path / "dump.gz"
    path.write_bytes(gzip.compress(b"ITEM: TIME\n" + bytes(20_000_000)))
    packed = tail.DumpTail(path, "gz")
    with pytest.raises(DumpError, match="unpacks to more than 50 times its size"):
        for _ in range(20):
            assert not list(packed.new_frames())


def test_a_frame_that_never_begins_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(tail, "MOST_LEFT", 1000)
    (tmp_path / "dump").write_bytes(2000 * b"x")
    with pytest.raises(DumpError, match="no frame begins within 1,000 bytes"):
        list(tail.DumpTail(tmp_path / "dump").new_frames())


def test_a_pass_that_is_given_up_ends_where_it_is(whole, tmp_path):
    writer = Writer(tmp_path / "grows", whole.path.read_bytes(), 100)
    grows, seen = GrowingDump(tmp_path / "grows", whole.format, writer), 0
    for _ in grows:
        seen += 1
        grows.given_up = True
        writer.pieces.clear()
    assert seen < 5 and grows.read.digest() != sha256(whole.path.read_bytes()).digest()
