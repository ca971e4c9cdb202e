# SPDX-License-Identifier: GPL-2.0-or-later
"""Poses of the walls that the discs push: ``walls.csv``, a row a wall and frame, written before the frame."""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Collection, Mapping
from math import isfinite
from pathlib import Path

import numpy as np

from lammps_jump.errors import DumpError
from lammps_jump.files import POSES_HEADER, open_to_read, open_to_write, writes
from lammps_jump.foreign import number_of
from lammps_jump.scene.motion import Pose


class SideWriter:
    """Writes a file frame by frame, each before its frame goes to the dump.

    Parameters
    ----------
    path : Path
    append : bool
        Write behind what the file holds.
    head : bytes
        What a new file begins with.

    Raises
    ------
    DumpError
        The file cannot be written.
    """

    def __init__(self, path: Path, *, append: bool = False, head: bytes = b""):
        with writes(path):
            self._file = open_to_write(path, append=append)
            if not append:
                self._file.write(head)

    def put(self, rows: bytes) -> None:
        """Write, and hand it to the system for readers."""
        self._file.write(rows)
        self._file.flush()

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


MOST_POSES = 200_000_000
"""Bytes of the file that are read: a million frames of two walls."""


class PoseWriter(SideWriter):
    """Writes ``walls.csv``; parameters as of `SideWriter`."""

    def __init__(self, path: Path, *, append: bool = False):
        super().__init__(path, append=append, head=f"{POSES_HEADER}\n".encode())

    def write(self, time: float, poses: Mapping[str, Pose]) -> None:
        """Write the pose of each wall at a time (s)."""
        rows = (f"{time:.15g},{name},{pose.x:.17g},{pose.y:.17g},{pose.angle:.17g}\n" for name, pose in poses.items())
        self.put("".join(rows).encode())


class PoseFile:
    """``walls.csv`` of a run, which may still grow: a later time reads what is new.

    Parameters
    ----------
    path : Path
        Need not be there yet.
    names : collection of str
        Walls of the scene that the discs push; rows of other walls are refused.
    most : int, optional
        Frames of the run: more rows of a wall are refused.

    Notes
    -----
    A row holds the time (s), the name of the wall, its displacement (m) from where the case has it, and its turn (rad).
    An engine writes the rows of a frame before the frame. A last line without its end is not read yet. Empty lines and
    a row that stands there twice are skipped.
    """

    def __init__(self, path: Path, names: Collection[str], most: int | None = None):
        self.path, self.most = path, most
        self._times: dict[str, list[float]] = {name: [] for name in names}
        self._poses: dict[str, list[Pose]] = {name: [] for name in names}
        self._read, self._line = 0, 0

    def at(self, time: float) -> dict[str, Pose]:
        """Pose of each wall at a time (s): straight between rows, the nearest row outside; without rows none.

        Raises
        ------
        DumpError
            A file that cannot be read or is too large, or a line that is no row of it.
        """
        if any(not times or times[-1] < time for times in self._times.values()):
            self._take_in_what_is_new()
        return {name: self._between(times, self._poses[name], time) for name, times in self._times.items() if times}

    def rates(self, time: float) -> dict[str, Pose]:
        """Velocity of each wall at a time (m/s, m/s, rad/s), by a parabola through the last three rows up to it.

        Later rows do not count, so that it is the same while the run goes on. It is 0 at the first row: walls that the
        discs push begin at rest.
        """
        self.at(time)
        return {name: self._rate(times, self._poses[name], time) for name, times in self._times.items() if times}

    @staticmethod
    def _rate(times: list[float], poses: list[Pose], time: float) -> Pose:
        last = max(1, bisect_right(times, time + 1e-9 * abs(time)))  # a row has fifteen digits
        span, rows = np.array(times[max(0, last - 3) : last]), np.array(poses[max(0, last - 3) : last])
        if last == 1:
            return Pose()
        slopes = np.diff(rows, axis=0) / np.diff(span)[:, None]
        bend = (slopes[-1] - slopes[0]) * (span[-1] - span[-2]) / (span[-1] - span[0])
        return Pose(*(slopes[-1] + bend).tolist())

    @staticmethod
    def _between(times: list[float], poses: list[Pose], time: float) -> Pose:
        after = bisect_right(times, time)
        if after in (0, len(times)):
            return poses[max(0, after - 1)]
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        return Pose(*((1 - share) * a + share * b for a, b in zip(poses[after - 1], poses[after], strict=True)))

    def _take_in_what_is_new(self) -> None:
        if not self.path.exists():
            return
        try:
            with open_to_read(self.path) as file:
                size = os.fstat(file.fileno()).st_size
                if size > MOST_POSES:
                    raise DumpError(
                        f"{self.path}: has {size} bytes, at most {MOST_POSES} are read; write fewer frames."
                    )
                file.seek(self._read)
                data = file.read(max(0, size - self._read))
            text = data[: data.rfind(b"\n") + 1].decode()
        except (OSError, UnicodeDecodeError) as error:
            raise DumpError(f"{self.path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
        self._read += len(text.encode())
        for line in text.splitlines():
            self._line += 1
            if self._line > 1:
                if line:
                    self._take_row(line)
            elif line.strip() != POSES_HEADER:
                raise DumpError(f"{self.path}, line 1: {line[:60]!r}; expected {POSES_HEADER}.")

    def _take_row(self, line: str) -> None:
        """One row; DumpError where it is none."""
        try:
            first, name, *rest = line.split(",")
            time, pose = number_of(first), Pose(*map(number_of, rest))
            times = self._times[name]
            if times and (time, pose) == (times[-1], self._poses[name][-1]):
                return
            if len(rest) != len(pose) or not all(map(isfinite, (time, *pose))) or (times and time <= times[-1]):
                raise ValueError
        except (ValueError, TypeError, KeyError):
            raise DumpError(
                f"{self.path}, line {self._line}: {line[:60]!r} is no row of {POSES_HEADER}: allowed are finite "
                f"numbers, growing times and the walls {', '.join(self._times)}."
            ) from None
        if self.most is not None and len(times) >= self.most:
            raise DumpError(
                f"{self.path}, line {self._line}: more rows of the wall {name} than the {self.most} frames of the run"
            )
        times.append(time)
        self._poses[name].append(pose)
