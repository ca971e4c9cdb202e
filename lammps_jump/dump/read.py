# SPDX-License-Identifier: GPL-2.0-or-later
"""Streaming reader for LAMMPS dumps: ``dump custom`` as text, gzipped text or binary, recognized by content.

Formats: text as https://docs.lammps.org/dump.html describes it; binary as LAMMPS' ``tools/binary2txt.cpp``
reads it (files with the ``DUMP…`` signature, revision 2, which carry the names of their columns).
"""

from __future__ import annotations

import gzip
import re
import struct
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, overload

from lammps_jump.errors import DumpError
from lammps_jump.files import open_to_read, read_start

from .formats import DAMAGE, PASSED_OVER, NoFrame, walk
from .frame import DumpFile, Frame, FrameHeader


class Dump(DumpFile):
    """A dump file: iterate over it, as often as wanted, to get its frames one by one; made by `open_dump`.

    Attributes
    ----------
    path : Path
    format : {'text', 'binary'}
    columns : tuple of str
        Column names of the first frame, words included.
    units : str or None
        LAMMPS unit style where the file tells.
    warnings : list of str
        What was odd in the last pass: a truncated last frame, columns of words.
    """

    def __iter__(self) -> Iterator[Frame]:
        return self.select(None)

    def select(self, wanted: Iterable[int] | None) -> Iterator[Frame]:
        """The frames of these indices (0, 1, …), in the file's order; the others are passed over unparsed."""
        wanted = None if wanted is None else frozenset(wanted)
        last = None if wanted is None else max(wanted, default=-1)
        for index, (_, frame) in enumerate(self._forward(lambda i: wanted is None or i in wanted)):
            if frame is not None:
                yield frame
            if last is not None and index >= last:
                return

    def __len__(self) -> int:
        return self.count()

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Iterator[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | Iterator[Frame]:
        """A frame by number, or those of a slice one by one; negative numbers count from the end."""
        if isinstance(index, slice):
            numbers = range(self.count())[index]
            if numbers.step > 0:
                return self.select(numbers)
            raise ValueError(f"dump[{index}]: frames are read forwards only; a step above 0 is allowed")
        try:
            (frame,) = self.select([range(self.count())[index]])
        except IndexError:
            raise IndexError(f"dump[{index}]: {self.path} holds {self.count()} frames") from None
        return frame

    def headers(self) -> list[FrameHeader]:
        """Step, time and number of discs of every complete frame (one quick pass, remembered)."""
        return self._headers

    @cached_property
    def _headers(self) -> list[FrameHeader]:
        return [header for header, _ in self._forward(lambda i: False)]

    def count(self) -> int:
        """Number of complete frames."""
        return len(self.headers())

    def _forward(self, parse: Callable[[int], bool]) -> Iterator[tuple[FrameHeader, Frame | None]]:
        """Headers and frames whose steps and times advance; what a warning says of the others.

        A frame that is there twice and the first frames of an appended restart are passed over. Steps that fall back to
        the first or before it are another run's, which ends the pass.
        """
        taken: list[FrameHeader] = []
        passed, warning = 0, ""
        for number, (header, frame) in enumerate(self._pass(lambda _: parse(len(taken))), start=1):
            if not taken or _advances(taken[-1], header):
                taken.append(header)
                yield header, frame
                continue
            passed += 1
            warning = warning or f"{self.path}: frame {number} is at {_place(header)}, after {_place(taken[-1])}: "
            if another := header.step <= taken[0].step and header.step < taken[-1].step:
                before = "frame before it is" if len(taken) == 1 else "frames before it are"
                what = f"another run begins there and was {PASSED_OVER}; only the {len(taken)} {before} used."
            else:
                those = f"{passed} frames that do not advance were" if passed > 1 else "it does not advance and was"
                what = f"{those} {PASSED_OVER}."
            self.warnings = [text for text in self.warnings if not text.startswith(warning)] + [warning + what]
            if another:
                return

    def _open(self) -> Any:
        return _open(self.path, self.compressed)

    def _pass(self, parse: Callable[[int], bool]) -> Iterator[tuple[FrameHeader, Frame | None]]:
        """Headers of all whole frames in the order of the file, and the frames for whose index `parse` is true."""
        self.warnings = []
        try:
            with self._open() as stream:
                yield from walk(self, stream, parse)
        except OSError as error:
            raise DumpError(f"{self.path}: cannot be read ({error.strerror or error}).") from error


def _advances(last: FrameHeader, header: FrameHeader) -> bool:
    """Tells whether a frame is later than the last one, by its step and, where both have one, by its time."""
    if last.time is not None and header.time is not None and header.time <= last.time:
        return False
    return header.step > last.step


def _place(header: FrameHeader) -> str:
    return f"step {header.step}" + ("" if header.time is None else f" ({header.time:.6g} s)")


def _behind(parse: Callable[[int], bool], before: int) -> Callable[[int], bool]:
    """Parse of a frame after `before` others."""
    return lambda index: parse(before + index)


class DumpSeries(Dump):
    """Files of one run with a frame or more each (``dump.*.lammps``), as one dump whose path is their pattern."""

    def __init__(self, path: Path, files: list[Path]):
        first = _identified(files[0])
        super().__init__(path, first.format, first.compressed)
        self.files = files

    def _pass(self, parse: Callable[[int], bool]) -> Iterator[tuple[FrameHeader, Frame | None]]:
        self.warnings, done, first, last = [], 0, None, None
        for file in self.files:
            try:
                part, before = _identified(file), done
                for header, frame in part._pass(_behind(parse, before)):
                    if done == before and first is not None and header.step <= first:
                        raise DumpError(
                            f"{file}: step {header.step} follows step {last} of the file before; allowed are files of "
                            "one run, whose numbers go with their steps: name its files with a pattern in quotes."
                        )
                    first, last, done = header.step if first is None else first, header.step, done + 1
                    self.columns, self.units = self.columns or part.columns, self.units or part.units
                    yield header, frame
            except NoFrame as cut_off:  # a run that was killed leaves such a file
                if file != self.files[-1] or not done:
                    raise
                self.warn(f"{cut_off} It was skipped.")
                continue
            for warning in part.warnings:
                self.warn(warning)


def files_of(path: Path) -> list[Path]:
    """The file itself; where there is none, the files that fit its name as a pattern, by the numbers in their names."""
    if path.exists():
        return [path]
    paths = (file for file in path.parent.glob(path.name) if file.is_file())
    return sorted(
        paths, key=lambda file: [int(part) if i % 2 else part for i, part in enumerate(by_numbers(file.name))]
    )


def by_numbers(name: str) -> list[str]:
    """A name in parts: text and whole numbers in turn, text first."""
    return re.split("([0-9]+)", name)


def open_dump(path: str | Path) -> Dump:
    """Open a LAMMPS dump: text, gzipped text or binary, whatever its name says.

    Parameters
    ----------
    path : str or Path
        A file, or a pattern such as ``dump.*.lammps`` for the files of one run.

    Returns
    -------
    Dump
        Iterable again and again; holds one frame in memory at a time.

    Raises
    ------
    DumpError
        Not there, empty, not a dump, an old binary dump without column names; on iteration, with the line (text)
        or byte (binary) where a file is malformed.
    """
    path = Path(path)
    if path.is_dir():
        raise DumpError(f"{path} is a folder; name a dump file in it.")
    files = files_of(path)
    dump = _identified(path) if files in ([], [path]) else DumpSeries(path, files)
    next(dump.select([0]), None)  # it fills in columns and units, and a wrong file fails at once
    return dump


def _identified(path: Path) -> Dump:
    """A dump whose format is known."""
    head = b""
    try:
        compressed = read_start(path, 2) == b"\x1f\x8b"
        with _open(path, compressed) as stream, suppress(*DAMAGE):
            head = stream.read1(64)
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error}).") from error
    if not head.strip():
        raise NoFrame(f"{path} is empty: no frame of a dump in it. Did the run write its first output?")
    if head.lstrip().startswith(b"ITEM:"):
        return Dump(path, "text", compressed)
    if len(head) >= 16:
        (number,) = struct.unpack("<q", head[:8])
        if -64 <= number < 0 and head[8:12] == b"DUMP":
            return Dump(path, "binary", compressed)
        if struct.unpack(">q", head[:8])[0] in range(-64, 0) and head[8:12] == b"DUMP":
            raise DumpError(f"{path} is a binary dump from a big-endian machine; convert it with binary2txt there.")
    if head[:4] == b"\x28\xb5\x2f\xfd":
        raise DumpError(f"{path} is compressed with zstd; unpack it with 'unzstd' first (gzip is read as it is).")
    raise DumpError(
        f"{path}: line 1 is {head[:30]!r}, not 'ITEM: …': this is not a LAMMPS dump (text, .gz or binary with column "
        "names). Old binary dumps without a signature must be turned into text with LAMMPS' binary2txt."
    )


def _open(path: Path, compressed: bool) -> Any:
    file = open_to_read(path)
    if not compressed:
        return file
    packed = gzip.GzipFile(fileobj=file)
    packed.myfileobj = file  # type: ignore[assignment]  # so that it is closed with it
    return packed
