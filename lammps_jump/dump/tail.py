# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole frames of a dump that an engine is still writing."""

from __future__ import annotations

import hashlib
import io
import re
import struct
import sys
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lammps_jump.errors import DumpError
from lammps_jump.files import open_to_read

from .formats import walk
from .frame import UNPACKED, DumpFile, Frame
from .read import Dump

MARKER = b"ITEM: TIME\n"
"""First line of each frame that our engines write."""
HEAD = re.compile(
    rb"ITEM: TIME\n[^\n]*\nITEM: TIMESTEP\n\d+\nITEM: NUMBER OF ATOMS\n(\d{1,10})\n"
    rb"ITEM: BOX BOUNDS[^\n]*\n(?:[^\n]*\n){3}ITEM: ATOMS [^\n]*\n"
)
"""First lines of a frame that our engines write, with the number of lines after them."""
BINARY_MARKER = struct.pack("<q10s", -10, b"DUMPCUSTOM")
"""First bytes of each binary frame."""
GZIP = 31
"""Of `zlib`: a stream with the header of gzip."""
WAIT = 0.02
"""Seconds between looks at a file that grows."""
MOST_UNPACKED = 64_000_000
"""Bytes that are unpacked at once."""
MOST_LEFT = 1_500_000_000
"""Bytes of a dump in which a frame is to begin."""


class GrowingDump(Dump):
    """A text or binary dump that grows: a pass over its frames waits for more until `ended` is set.

    Parameters
    ----------
    path : Path
        It need not be there yet.
    format : {'text', 'binary'}
    ended : threading.Event
        To be set once the file is whole.

    Attributes
    ----------
    given_up : bool
        Set it, and then `ended`, to end a pass at once.
    read : hashlib.sha256
        Of the bytes that the last pass has seen.
    """

    most_bytes = sys.maxsize

    def __init__(self, path: Path, format: str, ended: threading.Event):
        super().__init__(path, format, False)
        self.columns = ("id", "x", "y", "vx", "vy")  # at least: known before the first frame is there
        self.ended, self.given_up, self.read = ended, False, hashlib.sha256()

    @property
    def is_whole(self) -> bool:
        """Never: what has not arrived asks for no room."""
        return False

    def _open(self) -> Any:
        while not self.path.exists() and not self.ended.wait(WAIT):
            pass
        return _Growing(self)


class _Growing(io.RawIOBase):
    """The bytes of a dump that grows; its end is that of the whole file."""

    def __init__(self, dump: GrowingDump):
        self.dump, self.file = dump, open_to_read(dump.path).detach()
        dump.read = hashlib.sha256()

    def readable(self) -> bool:
        return True

    def readinto(self, target: Any) -> int:
        while True:
            ended = self.dump.ended.is_set()  # before reading: what is written later is seen the next time
            got = 0 if self.dump.given_up else self.file.readinto(target)
            if got or ended:
                self.dump.read.update(memoryview(target)[:got])
                return got
            self.dump.ended.wait(WAIT)

    def close(self) -> None:
        self.file.close()
        super().close()


class _Arrived(DumpFile):
    """Unpacked bytes of a dump that grows; its size on the disk bounds nothing."""

    most_bytes = 0


class DumpTail:
    """The end of a dump that grows.

    A frame of a text is whole with the last line that it announces, so that it is seen as soon as it is written.

    Parameters
    ----------
    path : Path
        Dump with times; it need not be there yet.
    format : {'text', 'gz', 'binary'}

    Attributes
    ----------
    at_end : bool
        Whether the last call of `new_frames` has seen all of the file.
    """

    def __init__(self, path: Path, format: str = "text"):
        self.path, self.format = path, format
        self._marker = BINARY_MARKER if format == "binary" else MARKER
        self._read, self._left, self._stream = 0, b"", zlib.decompressobj(GZIP)
        self._packed, self._unpacked = b"", 0
        self.at_end = False

    def new_frames(self, *, ended: bool = False, most: int = -1) -> Iterator[Frame]:
        """Frames that have become whole since the last call; of a binary dump the newest once another begins.

        Where the run has `ended` the last is whole too. At most `most` bytes are read, by default all, and of a gzip
        file `MOST_UNPACKED` unpacked; `at_end` then says whether these were the last ones.

        Raises
        ------
        DumpError
            A file that cannot be read, is malformed, or unpacks to more than any dump does.
        """
        self.at_end = not self.path.exists()
        if self.at_end:
            return
        try:
            with open_to_read(self.path) as file:
                file.seek(self._read)
                arrived = b"" if self._packed else file.read(most)
                rest = bool(file.read(1))
        except OSError as error:
            raise DumpError(f"{self.path}: cannot be read ({error.strerror or error})") from None
        self._read += len(arrived)
        data = self._left + (self._unpack(arrived) if self.format == "gz" else arrived)
        self.at_end = not rest and not self._packed
        last = len(data) if ended and self.at_end else self._whole(data)
        self._left = data[last:]
        if len(self._left) > MOST_LEFT:
            raise DumpError(f"{self.path}: no frame begins within {MOST_LEFT:,} bytes, so this is no dump of a run")
        if last:
            yield from self._frames(data[max(data.find(self._marker), 0) : last])

    def _whole(self, data: bytes) -> int:
        """Bytes from the beginning that hold whole frames alone."""
        begun = max(data.rfind(self._marker), 0)
        head = None if self.format == "binary" else HEAD.match(data, begun)
        if head is None:
            return begun
        left = data.count(b"\n", head.end()) - int(head[1])
        return len(data) if left == 0 and data.endswith(b"\n") else begun

    @property
    def was_cut(self) -> bool:
        """Tells whether the file is gone, or shorter than what was read: it began anew, or from an earlier time."""
        try:
            return self.path.stat().st_size < self._read
        except OSError:
            return self._read > 0

    def _unpack(self, arrived: bytes) -> bytes:
        """Content of more bytes of a gzip file, or a part of it; a run that went on has several streams in it."""
        parts, size, packed = [], 0, self._packed + arrived
        try:
            while packed and size < MOST_UNPACKED:
                parts.append(self._stream.decompress(packed, MOST_UNPACKED - size))
                size += len(parts[-1])
                if self._stream.eof:
                    packed, self._stream = self._stream.unused_data, zlib.decompressobj(GZIP)
                else:
                    packed = self._stream.unconsumed_tail
        except zlib.error as error:
            raise DumpError(f"{self.path}: the gzip stream is damaged ({error})") from None
        self._packed = packed
        self._unpacked += size
        if self._unpacked > UNPACKED * max(self._read, MOST_UNPACKED // UNPACKED):
            raise DumpError(f"{self.path}: unpacks to more than {UNPACKED} times its size, as no dump of discs does")
        return b"".join(parts)

    def newest(self, guess: int = 2_000_000, *, ended: bool = False) -> Frame | None:
        """The last whole frame of a text, None where there is none yet; where the run has `ended` the last is whole.

        Reads `guess` bytes from the end, more where a frame is larger.
        """
        try:
            size = self.path.stat().st_size
            with open_to_read(self.path) as file:
                while True:
                    start = max(0, size - guess)
                    file.seek(start)
                    tail = file.read(size - start)
                    stop = len(tail) if ended else tail.rfind(MARKER)
                    begin = tail.rfind(MARKER, 0, max(stop, 0))
                    if begin >= 0:
                        return next(self._frames(tail[begin:stop]), None)
                    if start == 0 or guess > MOST_LEFT:
                        return None
                    guess *= 4
        except OSError:
            return None

    def _frames(self, data: bytes) -> Iterator[Frame]:
        """Frames of whole data; DumpError where it is malformed."""
        of = _Arrived(self.path, "binary" if self.format == "binary" else "text", False)
        of.most_bytes = len(data)
        return (frame for _, frame in walk(of, io.BytesIO(data), lambda index: True) if frame is not None)
