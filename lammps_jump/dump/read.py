"""Streaming reader for LAMMPS dumps: ``dump custom`` as text, gzipped text or binary, told apart by content.

Formats: text as https://docs.lammps.org/dump.html describes it; binary as LAMMPS' ``tools/binary2txt.cpp``
reads it (files with the ``DUMP…`` signature, revision 2, which carry the names of their columns).
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

import numpy as np

from lammps_jump.errors import DumpError

TEXT_COLUMNS = frozenset({"element", "typelabel"})
"""Columns that LAMMPS fills with words: left out of a frame, with a warning."""

BUFFER = 1 << 22
LARGEST_FRAME = 1 << 33
"""A count of discs beyond this is taken for garbage rather than believed."""


@dataclass(frozen=True)
class Frame:
    """One time of a dump.

    Attributes
    ----------
    step : int
    time : float or None
        Simulated time, s, where the file carries it (``dump_modify time yes``).
    box : ndarray, shape (3, 2)
        Low and high bound of x, y, z, m.
    columns : mapping of str to ndarray, shape (n,)
        Every numeric column of the file, float64, read-only, in the file's order of discs.
    """

    step: int
    time: float | None
    box: np.ndarray
    columns: Mapping[str, np.ndarray]

    def column(self, name: str) -> np.ndarray:
        """One column; DumpError naming the columns there are where it is missing."""
        try:
            return self.columns[name]
        except KeyError:
            raise DumpError(
                f"the dump has no column '{name}' at step {self.step}; it has: {' '.join(self.columns) or 'none'}. "
                f"Write it with 'dump … custom … {name}'."
            ) from None

    def _coordinate(self, axis: str, row: int) -> np.ndarray:
        for name in (axis, axis + "u"):
            if name in self.columns:
                return self.columns[name]
        for name in (axis + "s", axis + "su"):
            if name in self.columns:
                low, high = self.box[row]
                return low + self.columns[name] * (high - low)
        return self.column(axis)

    @property
    def n(self) -> int:
        """Number of discs."""
        return len(next(iter(self.columns.values()))) if self.columns else 0

    @property
    def ids(self) -> np.ndarray:
        """Disc ids, int64; 1 … n where the file has none."""
        if "id" in self.columns:
            return self.columns["id"].astype(np.int64)
        return np.arange(1, self.n + 1)

    @property
    def x(self) -> np.ndarray:
        """Horizontal position, m, from ``x``, ``xu`` or (scaled by the box) ``xs``."""
        return self._coordinate("x", 0)

    @property
    def y(self) -> np.ndarray:
        """Vertical position, m, from ``y``, ``yu`` or (scaled by the box) ``ys``."""
        return self._coordinate("y", 1)

    @property
    def vx(self) -> np.ndarray:
        """Horizontal velocity, m/s."""
        return self.column("vx")

    @property
    def vy(self) -> np.ndarray:
        """Vertical velocity, m/s."""
        return self.column("vy")

    def sorted(self) -> Frame:
        """The same frame with its discs in the order of their ids."""
        if "id" not in self.columns or np.all(np.diff(self.columns["id"]) > 0):
            return self
        order = np.argsort(self.columns["id"], kind="stable")
        return replace(self, columns=_frozen({name: values[order] for name, values in self.columns.items()}))


@dataclass(frozen=True, slots=True)
class FrameHeader:
    """What stands above the discs of one frame."""

    step: int
    time: float | None
    n: int


class Dump:
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
        What the last pass found odd: a truncated last frame, columns of words.
    """

    def __init__(self, path: Path, format: str, compressed: bool):
        self.path, self.format, self.compressed = path, format, compressed
        self.columns: tuple[str, ...] = ()
        self.units: str | None = None
        self.warnings: list[str] = []
        self._headers: list[FrameHeader] | None = None

    def __iter__(self) -> Iterator[Frame]:
        return self.select(None)

    def select(self, wanted: Iterable[int] | None) -> Iterator[Frame]:
        """The frames of these indices (0, 1, …), in the file's order; the others are passed over unparsed."""
        wanted = None if wanted is None else frozenset(wanted)
        last = None if wanted is None else max(wanted, default=-1)
        for index, (_, frame) in enumerate(self._pass(lambda i: wanted is None or i in wanted)):
            if frame is not None:
                yield frame
            if last is not None and index >= last:
                return

    def headers(self) -> list[FrameHeader]:
        """Step, time and number of discs of every complete frame (one quick pass, remembered)."""
        if self._headers is None:
            self._headers = [header for header, _ in self._pass(lambda i: False)]
        return self._headers

    def count(self) -> int:
        """Number of complete frames."""
        return len(self.headers())

    def _pass(self, parse) -> Iterator[tuple[FrameHeader, Frame | None]]:
        from . import formats as dump_formats

        self.warnings = []
        walk = dump_formats.walk_text if self.format == "text" else dump_formats.walk_binary
        try:
            with _open(self.path, self.compressed) as stream:
                yield from walk(self, stream, parse)
        except OSError as error:
            raise DumpError(f"{self.path}: cannot be read ({error.strerror or error}).") from error

    @property
    def most_bytes(self) -> int:
        """More bytes than the file can hold once unpacked (deflate never shrinks below 1/1032)."""
        return self.path.stat().st_size * (1100 if self.compressed else 1)

    def warn(self, message: str) -> None:
        """Note something odd once per pass."""
        if message not in self.warnings:
            self.warnings.append(message)


def open_dump(path: str | Path) -> Dump:
    """Open a LAMMPS dump: text, gzipped text or binary, whatever its name says.

    Parameters
    ----------
    path : str or Path

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
    try:
        with open(path, "rb") as file:
            compressed = file.read(2) == b"\x1f\x8b"
        with _open(path, compressed) as stream:
            head = _read_some(stream, 64)
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error}).") from error
    if not head.strip():
        raise DumpError(f"{path} is empty: no frame of a dump in it. Did the run write its first output?")
    if head.lstrip().startswith(b"ITEM:"):
        return _first_look(Dump(path, "text", compressed))
    if len(head) >= 16:
        (number,) = struct.unpack("<q", head[:8])
        if -64 <= number < 0 and head[8:12] == b"DUMP":
            return _first_look(Dump(path, "binary", compressed))
        if struct.unpack(">q", head[:8])[0] in range(-64, 0) and head[8:12] == b"DUMP":
            raise DumpError(f"{path} is a binary dump from a big-endian machine; convert it with binary2txt there.")
    if head[:4] == b"\x28\xb5\x2f\xfd":
        raise DumpError(f"{path} is compressed with zstd; unpack it with 'unzstd' first (gzip is read as it is).")
    raise DumpError(
        f"{path}: line 1 is {head[:30]!r}, not 'ITEM: …': this is not a LAMMPS dump (text, .gz or binary with column "
        "names). Old binary dumps without a signature must be turned into text with LAMMPS' binary2txt."
    )


def _first_look(dump: Dump) -> Dump:
    """Fill in columns and units from the first frame's header, so that a wrong file fails at once."""
    for _ in dump.select([0]):
        break
    return dump


def _open(path: Path, compressed: bool) -> BinaryIO:
    file = open(path, "rb", buffering=0)
    return _Unzipped(file) if compressed else file


class _Unzipped(io.RawIOBase):
    """A gzip file as a stream that hands over every byte before a damage, which ``gzip`` does not."""

    def __init__(self, file: BinaryIO):
        self.file = file
        self.unzip = zlib.decompressobj(wbits=31)
        self.waiting = b""

    def readable(self) -> bool:
        return True

    def readinto(self, target) -> int:
        while True:
            self.waiting = self.waiting or self.file.read(1 << 18)
            if self.unzip.eof:  # another member may follow
                if not self.waiting.strip(b"\0"):
                    return 0
                self.unzip = zlib.decompressobj(wbits=31)
            if not self.waiting:
                raise EOFError("it ends in the middle of the stream")
            part = self.unzip.decompress(self.waiting, len(target))
            self.waiting = self.unzip.unused_data if self.unzip.eof else self.unzip.unconsumed_tail
            if part:
                target[: len(part)] = part
                return len(part)

    def close(self) -> None:
        self.file.close()
        super().close()


def _read_some(stream: BinaryIO, size: int) -> bytes:
    try:
        return stream.read(size)
    except (EOFError, zlib.error):
        return b""


def _frozen(columns: dict[str, np.ndarray]) -> Mapping[str, np.ndarray]:
    for values in columns.values():
        values.flags.writeable = False
    return MappingProxyType(columns)


def make_frame(step: int, time: float | None, box, columns: Mapping[str, np.ndarray]) -> Frame:
    """A frame from plain arrays (copied to float64): for made-up dumps and converters.

    Parameters
    ----------
    step, time : int, float or None
    box : array_like, shape (3, 2) or (2, 2)
        Bounds, m; z defaults to (-0.1, 0.1).
    columns : mapping of str to array_like, shape (n,)
    """
    bounds = np.array([[0.0, 0.0], [0.0, 0.0], [-0.1, 0.1]])
    given = np.asarray(box, float)
    bounds[: len(given)] = given
    arrays = {name: np.array(values, dtype=float).reshape(-1) for name, values in columns.items()}
    if len({len(values) for values in arrays.values()}) > 1:
        lengths = ", ".join(f"{name} {len(values)}" for name, values in arrays.items())
        raise DumpError(f"the columns of step {step} differ in length: {lengths}.")
    return Frame(int(step), None if time is None else float(time), bounds, _frozen(arrays))


def require_finite(frame: Frame, source: object) -> Frame:
    """The frame itself; DumpError where a position or velocity is no number, naming step and disc."""
    for name in ("x", "y", "vx", "vy"):
        values = frame.columns.get(name)
        if values is not None and not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            raise DumpError(
                f"{source}: step {frame.step}, row {row + 1} of the frame: {name} is {values[row]}, not a number; the "
                "run that wrote it blew up: lower its time step, or analyse the frames before"
            )
    return frame


def ten_indices(count: int, pictures: int = 10) -> list[int]:
    """Indices of equally spaced frames out of `count`, the first and the last among them."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(pictures, count))}) if count else []
