# SPDX-License-Identifier: GPL-2.0-or-later
"""Walk through the two file formats of a dump, frame by frame, in bounded memory; their bytes, and numbers of rows.

The core reads a number with at most 15 digits and a small exponent by one exact operation on two exact doubles; longer
ones (``%.17g``) go through a product in twice the precision, whose error (2^-100) changes the rounding in about one of
10^14 numbers. What neither can do (nan, 20 digits, subnormal) is handed back to Python's ``float``, and so is every
number where there is no core.
"""

from __future__ import annotations

import gzip
import io
import struct
import zlib
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from lammps_jump.core.library import BYTES, INTEGER, INTEGERS, REALS, core, entry
from lammps_jump.errors import DumpError
from lammps_jump.foreign import number_of, whole_of
from lammps_jump.scene.schedule import MOST_FRAMES

from .frame import BUFFER, LARGEST_FRAME, TEXT_COLUMNS, UNPACKED, DumpFile, Frame, FrameHeader, read_only

CHUNK = 1 << 17
"""Bytes that are read at once: gzip makes room for as many each time."""
DAMAGE = (EOFError, zlib.error, gzip.BadGzipFile)
"""Errors of reading a gzip file that is damaged or cut short."""
CUT_OFF, PASSED_OVER = "is cut off", "passed over"
"""Words of a warning for a torn frame, and of a line or a frame that a dump should not hold."""


class NoFrame(DumpError):
    """A file without one whole frame."""


class Truncated(Exception):
    """The file ends inside a frame; the message says where."""


class BrokenFrame(Exception):
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


ROWS_DONE, NEED_MORE, NOT_PLAIN, NEW_ITEM = range(4)
LARGEST_EXPONENT = 290
NEWLINE, I_OF_ITEM, COMMENT = b"\nI#"
BLANKS = tuple(b" \t")
MANY = 1000
"""Rows that are parsed at once without the core."""

Reached = tuple[int, int, int]
"""Rows done so far; where the next row starts, or the row at fault; one of the states above."""


def _powers_of_ten() -> tuple[np.ndarray, np.ndarray]:
    """10^e for e = -290 … 290 as an unevaluated sum of two doubles (high, low)."""
    exact = [Fraction(10) ** e for e in range(-LARGEST_EXPONENT, LARGEST_EXPONENT + 1)]
    high = [float(value) for value in exact]
    low = [float(value - Fraction(part)) for value, part in zip(exact, high, strict=True)]
    return np.array(high), np.array(low)


_POWERS = _powers_of_ten()
_parse_rows = entry(
    "jump_parse_rows", INTEGER, data=BYTES, end=INTEGER, at=INTEGERS, out=REALS, columns=INTEGER, rows=INTEGER,
    is_text=BYTES, high=REALS, low=REALS,
)  # fmt: skip


def parse_rows(data: np.ndarray, place: tuple[int, int], out: np.ndarray, row: int, is_text: np.ndarray) -> Reached:
    """Parse rows into ``out[column, row]`` from a part of `data` on.

    Parameters
    ----------
    data : ndarray of uint8
    place : (int, int)
        Begin and end of the part.
    out : ndarray of float64, contiguous, shape (columns, rows)
    row : int
        The first that is wanted.
    is_text : ndarray of bool, shape (columns,)
        Columns of words, which become NaN.

    Returns
    -------
    row, position, status : int
        A row counts only with its newline, so NEED_MORE leaves the position at the row's start.
    """
    if core() is None:
        return _parse_lines(data, place, out, row, is_text)
    reached = np.array([row, place[0]])
    (columns, rows), (high, low) = out.shape, _POWERS
    status = _parse_rows(
        data=data, end=place[1], at=reached, out=out, columns=columns, rows=rows, is_text=is_text.view(np.uint8),
        high=high, low=low,
    )  # fmt: skip
    return int(reached[0]), int(reached[1]), status


def skip_rows(data: np.ndarray, place: tuple[int, int], row: int, rows: int) -> Reached:
    """As `parse_rows`, but only counting lines, up to row `rows`; NOT_PLAIN before a comment."""
    starts, status = _lines(data, place, rows - row)
    return row + len(starts) - 1, int(starts[-1]), status


def _lines(data: np.ndarray, place: tuple[int, int], most: int) -> tuple[np.ndarray, int]:
    """Starts of at most so many whole lines, and where the last one ends; what stops the counting."""
    begin, end = place
    ends = np.flatnonzero(data[begin:end] == NEWLINE)[:most] + begin + 1
    starts = np.concatenate([[begin], ends])
    place_of = starts[starts < end]
    while (blank := np.isin(data[place_of], BLANKS) & (place_of < end - 1)).any():
        place_of = place_of + blank
    stops = np.flatnonzero(np.isin(data[place_of], (I_OF_ITEM, COMMENT)))
    if stops.size and stops[0] < most:
        return starts[: stops[0] + 1], NEW_ITEM if data[place_of[stops[0]]] == I_OF_ITEM else NOT_PLAIN
    return starts, ROWS_DONE if len(ends) == most else NEED_MORE


def _parse_lines(data: np.ndarray, place: tuple[int, int], out: np.ndarray, row: int, is_text: np.ndarray) -> Reached:
    """As `parse_rows`, by Python's ``float``, some rows at once."""
    starts, status = _lines(data, place, out.shape[1] - row)
    for first in range(0, len(starts) - 1, MANY):
        some = starts[first : first + MANY + 1]
        lines = data[some[0] : some[-1] - 1].tobytes().split(b"\n")
        for number, line in enumerate(lines):
            tokens = line.split()
            try:
                if len(tokens) != len(out) or b"_" in line:
                    raise ValueError
                out[:, row] = [np.nan if text else float(token) for text, token in zip(is_text, tokens, strict=True)]
            except ValueError:
                return row, int(some[number]), NOT_PLAIN
            row += 1
    return row, int(starts[-1]), status


MOST_BLANK = 10_000
MOST_EMPTY = 100_000
FIRST_VALUES = 1 << 20
"""Values of a frame for which there is room before they have arrived, where nobody knows whether they will."""
LARGEST_INT = (1 << 63) - 1
Walked = Iterator[tuple[FrameHeader, Frame | None]]


def walk(dump: DumpFile, stream: Any, parse: Callable[[int], bool]) -> Walked:
    """Headers, and the frames for whose index `parse` is true; a last frame that is cut off is left out and noted."""
    source: Lines | Bytes = Lines(dump, stream) if dump.format == "text" else Bytes(dump, stream)
    empty, index, torn = 0, 0, False
    while True:
        start = source.place()
        try:
            wanted = parse(index)
            frame_headers = (
                _text_frame(dump, source, wanted) if isinstance(source, Lines) else _binary_frame(dump, source, wanted)
            )
        except BrokenFrame as where:
            if index == 0 or torn:
                raise where.error from None
            dump.warn(
                f"{dump.path}: step {where.step}: the frame from {start} {CUT_OFF} {where.place}, and another begins "
                f"there; it was {PASSED_OVER}."
            )
            torn = True
            continue
        except Truncated as where:
            if index == 0:
                raise NoFrame(
                    f"{dump.path}: the file ends at {source.place()}, inside its first frame ({where})"
                    f"{source.damaged}: no complete frame in it."
                ) from None
            dump.warn(
                f"{dump.path}: the last frame (number {index + 1}, from {start}) {CUT_OFF} {where}{source.damaged}; "
                "it was skipped."
            )
            return
        if frame_headers is None:
            return
        if index >= MOST_FRAMES:
            raise DumpError(f"{dump.path}: more than {MOST_FRAMES} frames; read the file in parts.")
        empty += frame_headers[0].n == 0
        if empty > MOST_EMPTY:
            raise DumpError(f"{dump.path}: more than {MOST_EMPTY:,} frames without a disc; name a dump of discs.")
        yield frame_headers
        index, torn = index + 1, False


def _text_frame(dump: DumpFile, buffer: Lines, wanted: bool) -> tuple[FrameHeader, Frame | None] | None:
    head = _text_header(dump, buffer)
    if head is not None:
        header, box, names = head
        return header, _text_rows(dump, buffer, header, box, names, wanted)
    if buffer.damaged:
        raise Truncated("at the end of a frame")
    return None


def _wrong(dump: DumpFile, line: int, text: str, expected: str) -> DumpError:
    return DumpError(f"{dump.path}, line {line}: expected {expected}, found {text[:60]!r}.")


def _text_header(dump: DumpFile, buffer: Lines) -> tuple[FrameHeader, np.ndarray, tuple[str, ...]] | None:
    """(header, box, names) of the next frame, or None at the end of the file."""
    step: int | None = None
    n: int | None = None
    box: np.ndarray | None = None
    time = None
    tilt = 0.0
    blank = 0
    begun = False
    while True:
        line = buffer.line()
        if line is None:
            if begun:
                raise Truncated("inside its header")
            return None
        if not line.strip():
            blank += 1
            if blank > MOST_BLANK:
                raise _wrong(dump, buffer.line_number, line, f"a frame within {MOST_BLANK} blank lines")
            continue
        if not line.startswith("ITEM:"):
            expected = "'ITEM: …'" if begun or n is None else "the next frame"
            raise _wrong(dump, buffer.line_number, line, f"{expected} (does the count of discs fit the rows above?)")
        begun = True
        item, _, rest = line[5:].strip().partition(" ")
        if item == "UNITS":
            dump.units = _value(buffer).strip()
        elif item == "TIME":
            time = _number(dump, buffer, number_of, "a time")
        elif item == "TIMESTEP":
            step = buffer.step = _number(dump, buffer, whole_of, "a step number")
        elif item == "NUMBER" and rest == "OF ATOMS":
            n = _number(dump, buffer, whole_of, "a number of discs")
            if not 0 <= n <= LARGEST_FRAME:
                raise _wrong(dump, buffer.line_number, str(n), "a number of discs, zero or more")
        elif item == "BOX":
            box, tilt = _box(dump, buffer)
            sides = [word for word in rest.split() if len(word) == 2 and not set(word) - set("pfsm")]
            dump.periodic = (sides[:1] == ["pp"], sides[1:2] == ["pp"])
        elif item == "ATOMS":
            if step is None or n is None or box is None:
                first = "TIMESTEP" if step is None else "NUMBER OF ATOMS" if n is None else "BOX BOUNDS"
                raise _wrong(dump, buffer.line_number, line, f"'ITEM: {first}' first")
            names = tuple(rest.split())
            _check_names(dump, names, tilt, f"line {buffer.line_number}")
            return FrameHeader(step, time, n), box, names
        else:
            raise _wrong(dump, buffer.line_number, line, "ITEM: TIMESTEP, TIME, UNITS, NUMBER OF ATOMS, BOX or ATOMS")


def _value(buffer: Lines) -> str:
    line = buffer.line()
    if line is None:
        raise Truncated("inside its header")
    return line


def _number(dump: DumpFile, buffer: Lines, kind: Callable[[str], float], what: str) -> Any:
    text = _value(buffer)
    try:
        number = kind(text)
        if kind is whole_of and abs(number) > LARGEST_INT:
            raise ValueError("beyond what LAMMPS counts")
        return number
    except ValueError:
        raise _wrong(dump, buffer.line_number, text, what) from None


def _box(dump: DumpFile, buffer: Lines) -> tuple[np.ndarray, float]:
    bounds, tilt = np.empty((3, 2)), 0.0
    for axis in range(3):
        text = _value(buffer)
        try:
            values = [number_of(token) for token in text.split()]
        except ValueError:
            values = []
        if len(values) not in (2, 3):
            raise _wrong(dump, buffer.line_number, text, "two bounds of the box")
        bounds[axis] = values[:2]
        tilt += abs(values[2]) if len(values) == 3 else 0.0
    return bounds, tilt


def _check_names(dump: DumpFile, names: tuple[str, ...], tilt: float, where: str) -> None:
    if not names:
        raise DumpError(f"{dump.path}, {where}: no column names after 'ITEM: ATOMS'.")
    if tilt and any(name in names for name in ("xs", "ys", "xsu", "ysu")):
        raise DumpError(f"{dump.path}, {where}: scaled positions in a tilted box are not supported; dump x y.")
    if not dump.columns:
        dump.columns = tuple(dict.fromkeys(names))
    words = sorted(TEXT_COLUMNS.intersection(names))
    if words:
        dump.warn(f"{dump.path}: column {', '.join(words)} holds words and was left out.")


def _text_rows(
    dump: DumpFile, buffer: Lines, header: FrameHeader, box: np.ndarray, names: tuple[str, ...], wanted: bool
) -> Frame | None:
    first_line = buffer.line_number + 1 - buffer.comments
    if 2 * len(names) * header.n > dump.most_bytes:
        raise Truncated(f": the file is too short for {header.n} discs")
    out = _room(dump, len(names), header.n if wanted else 0)
    is_text = np.array([name in TEXT_COLUMNS for name in names])
    row = 0
    while True:
        place = buffer.begin, buffer.end
        if wanted:
            row, buffer.begin, status = parse_rows(buffer.data, place, out, row, is_text)
        else:
            row, buffer.begin, status = skip_rows(buffer.data, place, row, header.n)
            if (item := buffer.bytes.find(b"ITEM:", place[0], buffer.begin)) >= 0:
                buffer.begin, status = item, NEW_ITEM
        buffer.line_number = first_line - 1 + row + buffer.comments
        if status == ROWS_DONE:
            if row == header.n:
                break
            out = _larger(out, row + 1, header.n)
        elif status == NEED_MORE:
            if not buffer.more():
                raise Truncated(f"after {row} of {header.n} rows")
        elif status == NEW_ITEM:
            raise _torn(dump, buffer, header, row)
        else:
            line = buffer.line()  # may read on; a row cut off here is a truncated file, not a malformed one
            if line is None:
                raise Truncated(f"after {row} of {header.n} rows")
            if "ITEM:" in line:
                buffer.begin = buffer.bytes.rfind(b"ITEM:", 0, buffer.begin)
                buffer.line_number -= 1
                raise _torn(dump, buffer, header, row)
            if wanted:
                out = _larger(out, row + 1, header.n)
                out[:, row] = _slow_row(dump, line, names, buffer.line_number)
            row += 1
    return _frame(dump, header, box, names, out) if wanted else None


def _room(dump: DumpFile, columns: int, rows: int) -> np.ndarray:
    """Room for the values of a frame, shape (columns, rows); for fewer rows where they may never arrive."""
    return np.empty((columns, rows if dump.is_whole else min(rows, max(1, FIRST_VALUES // columns))))


def _larger(values: np.ndarray, rows: int, most: int) -> np.ndarray:
    """Values with room for so many rows, and for twice as many as before up to `most`."""
    if rows <= values.shape[1]:
        return values
    grown = np.empty((len(values), min(most, max(rows, 2 * values.shape[1]))))
    grown[:, : values.shape[1]] = values
    return grown


def _torn(dump: DumpFile, buffer: Lines, header: FrameHeader, row: int) -> BrokenFrame:
    """Another frame begins at the place of the buffer."""
    wrong = _wrong(dump, buffer.line_number + 1, "ITEM:", f"disc {row + 1} of {header.n}")
    return BrokenFrame(wrong, header, row)


def _slow_row(dump: DumpFile, line: str, names: tuple[str, ...], number: int) -> list[float]:
    """A row that the fast loop would not take: nan, many digits, or something wrong."""
    tokens = line.split()
    if len(tokens) != len(names):
        raise _wrong(dump, number, line, f"{len(names)} values ({' '.join(names)})")
    values = []
    for name, token in zip(names, tokens, strict=True):
        try:
            values.append(float("nan") if name in TEXT_COLUMNS else number_of(token))
        except ValueError:
            raise _wrong(dump, number, token, f"a number for {name}") from None
    return values


def _binary_frame(dump: DumpFile, source: Bytes, wanted: bool) -> tuple[FrameHeader, Frame | None] | None:
    """The next frame, with signature and revision 2; None at the end of the file."""
    take, number, start = source.take, source.number, source.taken
    try:
        first = number("q")
    except Truncated:
        if source.taken == start:
            return None
        raise
    if not -64 <= first < 0:
        raise DumpError(f"{dump.path}, byte {start}: no frame begins here (found {first}).")
    signature = bytes(take(-first))
    endian, revision = number("i"), number("i")
    if not signature.startswith(b"DUMP") or endian != 1:
        raise DumpError(f"{dump.path}, byte {start}: signature {signature!r}, byte order {endian}: not read.")
    if revision < 2:
        raise DumpError(
            f"{dump.path}: binary revision {revision} carries no column names; turn it into text with "
            "LAMMPS' binary2txt and add them to 'ITEM: ATOMS'."
        )
    step, n, triclinic = number("q"), number("q"), number("i")
    sides = np.frombuffer(take(24), np.int32)  # 0: periodic; both sides of an axis
    dump.periodic = (not sides[:2].any(), not sides[2:4].any())
    box = np.frombuffer(take(48)).reshape(3, 2).copy()
    tilt = float(np.abs(np.frombuffer(take(24))).sum()) if triclinic else 0.0
    width = number("i")
    dump.units = take(number("i")).decode("latin-1") or dump.units
    time = number("d") if number("b") else None
    names = tuple(take(number("i")).decode("latin-1").split())
    if len(names) != width or not 0 <= n <= LARGEST_FRAME:
        raise DumpError(
            f"{dump.path}, byte {start}: damaged: {n} discs with {width} values each, but {len(names)} names."
        )
    _check_names(dump, names, tilt, f"byte {start}")
    header = FrameHeader(step, time, n)
    if 8 * width * n > dump.most_bytes:
        raise Truncated(f": the file is too short for {n} discs")
    return header, _binary_rows(dump, source, header, box, names, wanted, start)


def _binary_rows(
    dump: DumpFile, source: Bytes, header: FrameHeader, box: np.ndarray, names: tuple[str, ...], wanted: bool,
    start: int,
) -> Frame | None:  # fmt: skip
    width, rows, done = len(names), header.n, 0
    out = _room(dump, width, rows if wanted else 0)
    for _ in range(source.number("i")):
        values = source.number("i")
        count, odd = divmod(values, width)
        if odd or count < 0 or done + count > rows:
            raise DumpError(
                f"{dump.path}, frame at byte {start}: a block of {values} values does not fit {rows} discs."
            )
        block = source.take(8 * values)
        if wanted:
            out = _larger(out, done + count, rows)
            out[:, done : done + count] = np.frombuffer(block).reshape(count, width).T
        done += count
    if done != rows:
        raise DumpError(f"{dump.path}, frame at byte {start}: {done} discs found, {rows} announced.")
    return _frame(dump, header, box, names, out) if wanted else None


def _frame(
    dump: DumpFile, header: FrameHeader, box: np.ndarray, names: tuple[str, ...], values: np.ndarray
) -> Frame:  # fmt: skip
    """Frame of values, shape (columns, n), without the columns of words; one that occurs twice with equal values once.

    The dump command of LIGGGHTS' examples writes ``id type type x y z …``.
    """
    columns: dict[str, np.ndarray] = {}
    for name, own in zip(names, values, strict=True):
        if name in TEXT_COLUMNS:
            continue
        first = columns.setdefault(name, own)
        if first is not own and not np.array_equal(first, own, equal_nan=True):
            row = int(np.argmax((first != own) & ~(np.isnan(first) & np.isnan(own))))
            raise DumpError(
                f"{dump.path}, step {header.step}: the column {name} stands twice in {' '.join(names)!r}, and row "
                f"{row + 1} of the frame has {first[row]:.10g} and {own[row]:.10g} there; rename one of them."
            )
    return Frame(header.step, header.time, box, read_only(columns))
