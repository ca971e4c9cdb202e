# SPDX-License-Identifier: GPL-2.0-or-later
"""The bytes of a dump: lines of a text, numbers of a binary file, up to an end or a damage."""

from __future__ import annotations

import gzip
import io
import struct
import zlib
from typing import Any

import numpy as np

from lammps_jump.dump.frame import BUFFER, UNPACKED, DumpFile, FrameHeader
from lammps_jump.errors import DumpError

CHUNK = 1 << 17
"""Bytes that are read at once: gzip makes room for as many each time."""
DAMAGE = (EOFError, zlib.error, gzip.BadGzipFile)
"""What reading a gzip file raises that is damaged or cut short."""
CUT_OFF, PASSED_OVER = "is cut off", "passed over"
"""What a warning says of a torn frame, and of a line or a frame that a dump should not hold."""


class NoFrame(DumpError):
    """A file without one whole frame."""


class Truncated(Exception):
    """The file ends inside a frame; the message says where."""


class Torn(Exception):
    """Another frame begins inside a frame, as where a run was killed and a later one appended to its file."""

    def __init__(self, error: DumpError, header: FrameHeader, rows: int):
        self.error, self.step, self.place = error, header.step, f"after {rows} of {header.n} rows"


class Source:
    """The bytes of a dump, up to a damage."""

    def __init__(self, dump: DumpFile, stream: Any):
        self.dump, self.path = dump, dump.path
        self.stream = stream if hasattr(stream, "readinto1") else io.BufferedReader(stream)
        self.taken = 0
        self.damaged = ""

    def read(self, target: memoryview) -> int:
        """Read at most as many bytes as `target` takes; 0 at the end of the file, and where it is damaged."""
        try:
            got = self.stream.readinto1(target[:CHUNK])
        except DAMAGE as error:
            self.damaged = f" (the gzip stream is damaged or cut short: {error})"
            return 0
        self.taken += got
        if self.dump.compressed and self.taken > self.dump.most_bytes:
            raise OSError(f"it unpacks to more than {UNPACKED} times its size, as no dump of discs does")
        return got


class Lines(Source):
    """A window on a stream that slides forward; a line fits into half of it."""

    def __init__(self, dump: DumpFile, stream: Any):
        super().__init__(dump, stream)
        self.bytes = bytearray(BUFFER)
        self.data = np.frombuffer(self.bytes, np.uint8)
        self.begin = self.end = 0
        self.line_number = self.comments = 0
        self.step: int | None = None

    def more(self) -> bool:
        """Read on, keeping what is not yet used; False at the end of the file."""
        left = self.end - self.begin
        if left > len(self.bytes) // 2:
            raise DumpError(f"{self.path}, {self.place()}: no end of a line within {left} bytes, so this is no dump.")
        self.bytes[:left] = self.bytes[self.begin : self.end]
        self.begin, self.end = 0, left
        got = self.read(memoryview(self.bytes)[left:])
        self.end += got
        return got > 0

    def place(self) -> str:
        """Place of the next line in the file."""
        return f"line {self.line_number + 1}"

    def line(self) -> str | None:
        """The next line that is no comment, without its end; None at the end of the file.

        Truncated where it lacks its newline.
        """
        while (line := self._any_line()) is not None and line.lstrip().startswith("#"):
            self.comments += 1
            step = "before the first step" if self.step is None else f"at step {self.step}"
            if self.comments == 1:
                self.dump.warn(f"{self.path}, line {self.line_number}: a comment {step} was {PASSED_OVER}.")
        return line

    def _any_line(self) -> str | None:
        searched = self.begin
        while (stop := self.bytes.find(b"\n", searched, self.end)) < 0:
            searched = self.end - self.begin
            if not self.more():
                if self.begin == self.end:
                    return None
                raise Truncated("inside a line")
        text = self.bytes[self.begin : stop].decode("latin-1").rstrip("\r")
        self.begin = stop + 1
        self.line_number += 1
        return text


class Bytes(Source):
    """A binary dump, one number or block after the other."""

    def place(self) -> str:
        """Place of the next byte in the file."""
        return f"byte {self.taken}"

    def take(self, size: int) -> bytearray:
        """The next `size` bytes; Truncated where the file ends before."""
        if size < 0:
            raise DumpError(f"{self.dump.path}, {self.place()}: a length of {size} bytes: the file is damaged.")
        if size > self.dump.most_bytes:
            raise Truncated(f": the file is too short for {size} bytes at {self.place()}")
        data, done = bytearray(), 0
        while done < size:
            if done == len(data):  # a length is believed as far as bytes have arrived
                data += bytes(min(size - done, max(CHUNK, done)))
            with memoryview(data) as room:
                got = self.read(room[done:])
            if not got:
                raise Truncated(f"at {self.place()}")
            done += got
        return data

    def number(self, code: str) -> Any:
        """The next number, of this code of `struct`."""
        return struct.unpack("<" + code, self.take(struct.calcsize("<" + code)))[0]
