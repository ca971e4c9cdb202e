# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that discs push: rows of ``bodies.csv``, and their state at the end of a run, in ``end.npz``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.dump.frame import LARGEST_VALUE
from lammps_jump.dump.tables import read_table
from lammps_jump.errors import DumpError
from lammps_jump.files import BODIES, BODIES_HEADER, POSES, write_text
from lammps_jump.scene.meeting import corner_names
from lammps_jump.scene.motion import MovingWall, Pose, Went
from lammps_jump.scene.scene import CONTACT, Scene
from lammps_jump.scene.walls import Wall

from .poses import PoseFile

Row = tuple[int, str, tuple[float, ...]]
"""Step, name, and the numbers of `BodyHistory` behind the time."""


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
"""How such walls move: bodies, lids and tailgates."""
UNKNOWN = ("half", "before", "force", "listed", "area", "since")
"""Numbers of `PUSHED` that may be unknown."""
STATE = ("place", "speed", "half", "before", "force", "listed")
"""Each along x, along y and as a turn; as `lammps_jump.scene.motion.Went`, where `place` is its pose."""
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
        found = cls(names, kinds, stored["walls"], stored["outlines"], stored["corners"], corner_names)
        _check(found, chains)
        return found

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


def _check(found: PushedWalls, chains: int) -> None:
    """Raise ValueError where a number of pushed walls, in a run with so many chains, is none that a run has."""
    rows, outlines, corners = found.rows, found.outlines, found.corners
    if rows.dtype != PUSHED or rows.ndim != 1 or outlines.ndim != 2 or outlines.shape[1] != 3:
        raise ValueError("its walls are not those of a run")
    if not len(found.names) == len(found.kinds) == len(rows) == len(set(found.names)) or set(found.kinds) - set(KINDS):
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
    if ((disc < 1) | (disc > len(found.corner_names)) | (partner > -1) | (partner < -chains)).any():
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
    found = np.zeros(len(walls), PUSHED)
    found["half"] = found["before"] = found["force"] = found["listed"] = found["area"] = found["since"] = nan
    for row, one, outline in zip(found, walls, outlines, strict=True):
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
    return PushedWalls(names, kinds, found, np.concatenate(outlines), corners, corner_names(scene.walls))


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


def went_of(row: np.void, pose: Pose) -> Went:
    """State of a wall from an earlier run, by its row there; it begins at a pose."""
    values: dict[str, Any] = {
        name: None if np.isnan(row[name]).any() else Pose(*row[name].tolist()) for name in STATE[1:]
    }
    values |= {name: None if np.isnan(row[name]) else float(row[name]) for name in ("area", "since")}
    return Went(pose, **{**values, "speed": values["speed"] or Pose()})
