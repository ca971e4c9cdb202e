# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls and bodies of a run: where they were at each frame, how discs pushed them, and forces along outlines."""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.errors import DumpError
from lammps_jump.files import (
    BODIES,
    BODIES_HEADER,
    POSES,
    POSES_HEADER,
    open_to_read,
    open_to_write,
    read_arrays,
    write_arrays,
    write_text,
    writes,
)
from lammps_jump.foreign import foreign, number_of
from lammps_jump.scene.meeting import corner_names
from lammps_jump.scene.motion import MovingWall, Pose, WallState
from lammps_jump.scene.scene import CONTACT, Scene
from lammps_jump.scene.walls import Wall

from .find import read_table
from .frame import LARGEST_VALUE


class SideWriter:
    """Writes a file frame by frame, each before its frame goes to the dump.

    Parameters
    ----------
    path : Path
    append : bool
        Write after what the file holds.
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
    a row that occurs twice are skipped.
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


# --- walls that discs push: rows of ``bodies.csv``, and their state at the end of a run, in ``end.npz`` ---------------


Row = tuple[int, str, tuple[float, ...]]
"""Step, name, and the numbers of `BodyHistory` after the time."""


class BodyHistory(NamedTuple):
    """A body against time, arrays of one length.

    Attributes
    ----------
    time : ndarray, s
    x, y : ndarray
        Centre of mass, m.
    angle : ndarray
        Turn since the start, rad.
    vx, vy, spin : ndarray
        m/s, rad/s.
    fx, fy, moment : ndarray
        Of the discs: means over the time up to the row, every step counted, N and N m per metre of width; in the first
        row those of the start. The moment is about the hinge, or the centre of mass.
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    angle: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    spin: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    moment: np.ndarray


def write_bodies(path: Path, scene: Scene, rows: Iterable[Row]) -> None:
    """Write ``bodies.csv``."""
    text = (
        f"{scene.time(step):.10g},{name},{','.join(f'{value:.15g}' for value in values)}\n"
        for step, name, values in rows
    )
    write_text(path, "".join([f"{BODIES_HEADER}\n", *text]))


def read_bodies(path: Path) -> dict[str, BodyHistory]:
    """``bodies.csv`` by body.

    Raises
    ------
    DumpError
        Not there, a wrong header, or a line that is no row of it.
    """
    table = read_table(path)
    if ",".join(table.heads) != BODIES_HEADER:
        raise DumpError(f"{path}, line 1: {','.join(table.heads)[:60]!r}; expected {BODIES_HEADER}.")
    names = np.array([cells[1] for _, cells in table.rows])
    columns = {head: table.numbers(head) for head in table.heads if head != "body"}
    return {
        str(name): BodyHistory(*(column[names == name] for column in columns.values()))
        for name in dict.fromkeys(names.tolist())
    }


KINDS = ("free", "load", "hold")
"""Motions of such walls: bodies, lids and tailgates."""
UNKNOWN = ("half", "before", "force", "listed", "area", "since")
"""Numbers of `PUSHED` that may be unknown."""
STATE = ("place", "speed", "half", "before", "force", "listed")
"""Each along x, along y and as a turn; as `lammps_jump.scene.motion.WallState`, where `place` is its pose."""
PUSHED = np.dtype(
    [
        *((name, bool) for name in ("released",)),
        *((name, float, 2) for name in ("about", "arm")),
        *((name, float, 3) for name in STATE),
        ("area", float),
        ("since", float),
        ("points", np.int64),
    ]
)
"""A wall: whether it has been released; its point of turning where the case has it, and from there to its centre of
mass (m); its state, NaN where that is not known; area that a tailgate saw last (m^2), and the time since that look (s);
points of its outline."""


@dataclass(frozen=True, eq=False)
class PushedWalls:
    """Walls of a run whose pose is its state, at one time.

    Attributes
    ----------
    names, kinds : tuple of str
        Names, and how each moves: `free`, `load` or `hold`.
    rows : ndarray of PUSHED
    outlines : ndarray, shape (points, 3)
        `outline_of` each, one after the other.
    corners : ndarray of CONTACT
        What corners of walls remember: `disc` counts `corner_names` from 1, a `partner` -1 - c means the chain c of the
        run.
    corner_names : tuple of str
        As `lammps_jump.scene.meeting.corner_names`.
    known : bool
        Whether the run kept their state.
    """

    names: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    rows: np.ndarray = field(default_factory=lambda: np.empty(0, PUSHED))
    outlines: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    corners: np.ndarray = field(default_factory=lambda: np.empty(0, CONTACT))
    corner_names: tuple[str, ...] = ()
    known: bool = True

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the file, by name."""
        if not self.names:
            return {"walls": self.rows} if self.known else {}  # each array costs time in the file
        texts = {name: np.array(getattr(self, name), str) for name in ("names", "kinds", "corner_names")}
        return {"walls": self.rows, "outlines": self.outlines, "corners": self.corners, **texts}

    @classmethod
    def of(cls, stored: Mapping[str, np.ndarray], chains: int) -> PushedWalls:
        """Walls of such arrays, in a run with so many chains; ValueError or LookupError where they are none."""
        if not len(stored["walls"]):
            return cls()
        texts = [stored[name] for name in ("names", "kinds", "corner_names")]
        if any(array.dtype.kind != "U" or array.ndim != 1 for array in texts):
            raise ValueError("its walls have no names")
        names, kinds, corner_names = (tuple(map(str, array)) for array in texts)
        walls = cls(names, kinds, stored["walls"], stored["outlines"], stored["corners"], corner_names)
        _check(walls, chains)
        return walls

    def outline(self, name: str) -> np.ndarray:
        """`outline_of` a wall."""
        index = self.names.index(name)
        first = int(self.rows["points"][:index].sum())
        return self.outlines[first : first + int(self.rows["points"][index])]

    def row(self, name: str) -> np.void:
        """State of a wall."""
        return self.rows[self.names.index(name)]

    def at(self, folder: Path, time: float) -> PushedWalls:
        """The same walls at the frame of a run folder at a time (s), as its tables have them.

        Raises
        ------
        DumpError
            A table that is damaged.
        """
        if not self.names:
            return self
        rows = self.rows.copy()
        poses = PoseFile(folder / POSES, self.names)
        there, rates = poses.at(time), poses.rates(time)
        bodies = read_bodies(folder / BODIES) if "free" in self.kinds else {}
        for name in ("half", "before", "force", "listed"):
            rows[name] = nan
        for row, name in zip(rows, self.names, strict=True):
            row["place"], row["speed"] = there.get(name, Pose()), rates.get(name, Pose())
            row["area"] = row["since"] = nan
            if name in bodies:
                own = bodies[name]
                speeds = [float(np.interp(time, own.time, values)) for values in (own.vx, own.vy, own.spin)]
                row["speed"] = speeds if not row["arm"].any() else (0.0, 0.0, speeds[2])
            row["released"] = bool(np.any(row["place"]) or np.any(row["speed"]))
        return PushedWalls(self.names, self.kinds, rows, self.outlines, np.empty(0, CONTACT), self.corner_names)

    def __bool__(self) -> bool:
        """Tells whether there are any."""
        return bool(self.names)


def _check(walls: PushedWalls, chains: int) -> None:
    """Raise ValueError where a number of pushed walls, in a run with so many chains, is none that a run has."""
    rows, outlines, corners = walls.rows, walls.outlines, walls.corners
    if rows.dtype != PUSHED or rows.ndim != 1 or outlines.ndim != 2 or outlines.shape[1] != 3:
        raise ValueError("its walls are not those of a run")
    if not len(walls.names) == len(walls.kinds) == len(rows) == len(set(walls.names)) or set(walls.kinds) - set(KINDS):
        raise ValueError("its walls have no names and motions of their own")
    if (rows["points"] < 1).any() or (rows["points"] > len(outlines)).any() or rows["points"].sum() != len(outlines):
        raise ValueError("its walls have no outlines")
    for name in ("about", "arm", *STATE, "area", "since"):
        unknown = np.isnan(rows[name]) if name in UNKNOWN else np.zeros(rows[name].shape, bool)
        most = np.finfo(float).max if name == "force" else LARGEST_VALUE
        if not ((np.abs(rows[name]) <= most) | unknown).all():
            raise ValueError(f"{name} of a wall is no number of a run")
    if not (np.abs(outlines) <= LARGEST_VALUE).all():
        raise ValueError("the outline of a wall is none")
    if corners.dtype != CONTACT or corners.ndim != 1:
        raise ValueError("contacts of its corners are not those of a run")
    disc, partner = corners["disc"], corners["partner"]
    if ((disc < 1) | (disc > len(walls.corner_names)) | (partner > -1) | (partner < -chains)).any():
        raise ValueError("a contact is of no corner or wall")
    if not all((np.abs(corners[name]) <= LARGEST_VALUE).all() for name in ("foot", "spring", "roll")):
        raise ValueError("a contact of a corner has no length")


NO_WALLS = PushedWalls()


def pushed_walls(
    scene: Scene, rows: Mapping[str, Mapping[str, Any]], slots: tuple[np.ndarray, ...] | None = None
) -> PushedWalls:
    """The walls of a scene whose pose is state.

    Parameters
    ----------
    scene : Scene
    rows : mapping of str to mapping
        Fields of `PUSHED` of each such wall, by its name: what engines know.
    slots : tuple of ndarray, shape (corners, S), optional
        Partners, feet, springs and rolling springs that the corners of all walls remember.
    """
    walls = [one for one in scene.walls if one.wall.name in rows]
    if not walls:
        return PushedWalls()
    outlines = [outline_of(one.wall) for one in walls]
    table = np.zeros(len(walls), PUSHED)
    table["half"] = table["before"] = table["force"] = table["listed"] = table["area"] = table["since"] = nan
    for row, one, outline in zip(table, walls, outlines, strict=True):
        row["about"], row["points"] = one.motion.about, len(outline)
        row["arm"] = one.motion.free.arm if one.motion.free else (0.0, 0.0)
        for name, value in rows[one.wall.name].items():
            row[name] = value
    corners = np.empty(0, CONTACT)
    if slots is not None:
        at = np.nonzero(slots[0])
        corners = np.zeros(len(at[0]), CONTACT)
        corners["disc"] = at[0] + 1
        for name, array in zip(("partner", "foot", "spring", "roll"), slots, strict=True):
            corners[name] = array[at]
    kinds = tuple(kind_of(one) for one in walls)
    names = tuple(one.wall.name for one in walls)
    return PushedWalls(names, kinds, table, np.concatenate(outlines), corners, corner_names(scene.walls))


def kind_of(one: MovingWall) -> str:
    """Kind of motion of such a wall."""
    kind = one.motion.kind
    assert kind is not None
    return str(kind.kind)


def outline_of(wall: Wall) -> np.ndarray:
    """Outline of a wall where the case has it: points (m) and radius of the arc to the next (m; 0: straight)."""
    rows: list[tuple[float, float, float]] = []
    for chain in wall.chains():
        bends = (*chain.bends, *[0.0] * (len(chain.points) - len(chain.bends)))
        rows += [(x, y, bend) for (x, y), bend in zip(chain.points, bends, strict=False)]
    return np.array(rows)


def went_of(row: np.void, pose: Pose) -> WallState:
    """State of a wall from an earlier run, by its row there; it begins at a pose."""
    values: dict[str, Any] = {
        name: None if np.isnan(row[name]).any() else Pose(*row[name].tolist()) for name in STATE[1:]
    }
    values |= {name: None if np.isnan(row[name]) else float(row[name]) for name in ("area", "since")}
    return WallState(pose, **{**values, "speed": values["speed"] or Pose()})


# --- forces on stretches of outlines against time: ``pressure.npz``, of the native engine, every step counted ---------


class StretchForces(NamedTuple):
    """Means over windows of steps.

    Attributes
    ----------
    time : ndarray, shape (windows,), s
        Their ends.
    across, along : ndarray, shape (windows, stretches), N/m
        Force of the discs on the wall, into it and along its outline.
    first : ndarray, shape (windows, stretches), N
        Force into it times the place along the outline.
    """

    time: np.ndarray
    across: np.ndarray
    along: np.ndarray
    first: np.ndarray


def write_pressure(path: Path, scene: Scene, rows: Sequence[tuple[int, np.ndarray]]) -> None:
    """Write the steps at which windows end, and the mean sums of their stretches, shape (windows, stretches, 3)."""
    shape = (len(rows), len(scene.pressure), 3)
    write_arrays(
        path,
        steps=np.array([step for step, _ in rows], np.int64),
        means=np.array([row for _, row in rows], float).reshape(shape),
    )


def read_pressure(path: Path, scene: Scene) -> StretchForces:
    """Rows that `write_pressure` wrote.

    Raises
    ------
    DumpError
        Not there, or no such file of this scene.
    """
    with foreign(DumpError, f"{path.name}: cannot be read", "run the case again"):
        arrays = read_arrays(path)
        steps, means = arrays["steps"], arrays["means"]
        if means.shape != (len(steps), len(scene.pressure), 3) or not np.isfinite(means).all():
            raise ValueError("it has other stretches, or numbers that are not finite")
        if (np.diff(steps) <= 0).any():
            raise ValueError("its steps do not grow")
    return StretchForces(np.array([scene.time(step) for step in steps.tolist()]), *np.moveaxis(means, 2, 0))
