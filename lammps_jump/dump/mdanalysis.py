# SPDX-License-Identifier: GPL-2.0-or-later
"""A bridge to MDAnalysis: dumps with a varying number of discs as a Universe.

Importing this module registers the format ``JUMPDUMP`` (topology and trajectory) with MDAnalysis; nothing else of the
package imports MDAnalysis.

One atom represents each disc id that ever occurs, in order of the ids. A disc that is not there in a frame has NaN
for its position and velocity, so that nothing is computed with it by accident: comparisons with NaN are false, hence
``prop`` selections leave it out, and `present` gives the group of those that are there.

MDAnalysis keeps positions and velocities as float32; the float64 originals are in ``ts.data``:
``positions`` and ``velocities`` (n_atoms, 3), ``present`` (n_atoms, bool), ``box_low`` (3: the box corner, which
``ts.dimensions`` cannot hold; positions are not shifted by it), ``step``, ``time``. Lengths are metres and times
seconds (MDAnalysis converts nothing). Radii are those of the last frame that holds a disc, where the dump has any.
``ts.dimensions`` makes MDAnalysis treat the box as periodic, which it is not along x and y: give ``dimensions=False``
to leave it out, or keep distances below the free room around the discs.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import MDAnalysis
import numpy as np
from MDAnalysis.coordinates.base import ReaderBase
from MDAnalysis.core.topology import Topology
from MDAnalysis.core.topologyattrs import Atomids, Atomtypes, Masses, Radii, Resids, Resnums, Segids
from MDAnalysis.lib.util import store_init_arguments
from MDAnalysis.topology.base import TopologyReaderBase

from .frame import Frame, FrameHeader
from .read import Dump, open_dump

FORMAT = "JUMPDUMP"
PRESENT = "prop x > -1e30"
"""Selection of the discs that are there: true for every number, false for NaN."""

_scanned: dict[tuple[Any, ...], tuple[np.ndarray, np.ndarray]] = {}


def universe(path: str | Path, *, diameter: float = 0.0, mass: float = 1.0, dimensions: bool = True) -> Any:
    """A dump as an MDAnalysis Universe.

    Parameters
    ----------
    path : str or Path
    diameter : float
        m; half of it becomes the atoms' radius where the dump has no radii.
    mass : float
        kg per metre of width; where the dump has radii, of a disc of `diameter` or, without that, the mean.
    dimensions : bool
        Whether frames carry the box (MDAnalysis then takes it for periodic).

    Returns
    -------
    MDAnalysis.Universe
    """
    return MDAnalysis.Universe(
        str(path), format=FORMAT, topology_format=FORMAT, diameter=diameter, mass=mass, dimensions=dimensions
    )


def present(universe: Any, updating: bool = False) -> Any:
    """AtomGroup of the discs that are there in the current frame; with `updating` it follows the trajectory."""
    return universe.select_atoms(PRESENT, updating=updating)


def all_ids(dump: Dump) -> np.ndarray:
    """Every disc id of a dump, ascending, int64."""
    return _all_discs(dump)[0]


def _all_discs(dump: Dump) -> tuple[np.ndarray, np.ndarray]:
    """Ids and last radii (m; NaN where the file has none) of all discs: one pass, remembered until the file changes."""
    statuses = [(file.resolve(), file.stat()) for file in dump.files]
    key = tuple((str(file), status.st_size, status.st_mtime_ns) for file, status in statuses)
    if key not in _scanned:
        ids, radii = np.empty(0, np.int64), np.empty(0)
        for frame in dump:
            known, before, ids = ids, radii, np.union1d(ids, frame.ids)
            radii = np.full(len(ids), np.nan)
            radii[np.searchsorted(ids, known)] = before
            if frame.radii is not None:
                radii[np.searchsorted(ids, frame.ids)] = frame.radii
        _scanned[key] = ids, radii
    return _scanned[key]


class JumpDumpParser(TopologyReaderBase):  # type: ignore[misc]  # MDAnalysis has no types
    """Topology of a dump: one atom a disc id."""

    format = FORMAT

    def parse(self, diameter: float = 0.0, mass: float = 1.0, **kwargs: object) -> Any:
        """Topology with ids, radii and masses; every atom is of type 'disc'."""
        ids, radii = _all_discs(open_dump(self.filename))
        n = len(ids)
        radii = np.where(np.isfinite(radii), radii, 0.5 * diameter)
        nominal = 0.5 * diameter or float(np.sqrt(np.sum(radii**2) / max(n, 1)))
        masses = mass * (radii / nominal) ** 2 if nominal else np.full(n, float(mass))
        attributes = [
            Atomids(ids),
            Atomtypes(np.full(n, "disc", dtype=object)),
            Masses(masses),
            Radii(radii.astype(np.float32)),
            Resids(np.array([1])),
            Resnums(np.array([1])),
            Segids(np.array(["DISCS"], dtype=object)),
        ]
        return Topology(n, 1, 1, attrs=attributes)


class JumpDumpReader(ReaderBase):  # type: ignore[misc]
    """Trajectory of a dump with a varying number of discs; see the module for what a frame holds."""

    format = FORMAT
    units = {"time": None, "length": None, "velocity": None}  # noqa: RUF012 (MDAnalysis' own way of declaring it)

    @store_init_arguments  # type: ignore[untyped-decorator]
    def __init__(self, filename: str | Path, dimensions: bool = True, **kwargs: object) -> None:
        super().__init__(filename, **kwargs)
        self._dump = open_dump(filename)
        self._ids = all_ids(self._dump)
        self._headers = self._dump.headers()
        self._box = dimensions
        self._moving = {"vx", "vy"} <= set(self._dump.columns)
        self._stream: Iterator[Frame] | None = None
        self.ts = self._Timestep(self.n_atoms, velocities=self._moving, dt=self._interval(), **self._ts_kwargs)
        self._read_next_timestep()

    @property
    def n_atoms(self) -> int:
        """Number of distinct disc ids."""
        return len(self._ids)

    @property
    def n_frames(self) -> int:
        """Number of complete frames."""
        return len(self._headers)

    @staticmethod
    def parse_n_atoms(filename: str | Path, **kwargs: object) -> int:
        """Number of distinct disc ids of a file."""
        return len(all_ids(open_dump(filename)))

    def _interval(self) -> float:
        times = [self._time(header) for header in self._headers[:2]]
        return times[1] - times[0] if len(times) == 2 and times[1] > times[0] else 1.0

    @staticmethod
    def _time(header: FrameHeader | Frame) -> float:
        return float(header.step) if header.time is None else header.time

    def _reopen(self) -> None:
        self._stream = None
        self.ts.frame = -1

    def _read_frame(self, frame: int) -> Any:
        if not 0 <= frame < self.n_frames:
            raise OSError(f"{self.filename}: no frame {frame}; there are {self.n_frames}")
        if self._stream is None or frame != self.ts.frame + 1:
            self._stream = self._dump.select(range(frame, self.n_frames))
        self.ts.frame = frame
        return self._fill(next(self._stream))

    def _read_next_timestep(self, ts: object = None) -> Any:
        if self.ts.frame + 1 >= self.n_frames:
            raise EOFError
        return self._read_frame(self.ts.frame + 1)

    def _fill(self, frame: Frame) -> Any:
        ts = self.ts
        slot = np.searchsorted(self._ids, frame.ids)
        here = np.zeros(self.n_atoms, bool)
        here[slot] = True
        position = np.full((self.n_atoms, 3), np.nan)
        position[slot, 0], position[slot, 1] = frame.x, frame.y
        position[slot, 2] = frame.columns.get("z", 0.0)
        ts.positions = position
        ts.data["positions"] = position
        if self._moving:
            velocity = np.full((self.n_atoms, 3), np.nan)
            velocity[slot, 0], velocity[slot, 1] = frame.vx, frame.vy
            velocity[slot, 2] = frame.columns.get("vz", 0.0)
            ts.velocities = velocity
            ts.data["velocities"] = velocity
        ts.dimensions = [*np.ptp(frame.box, axis=1), 90.0, 90.0, 90.0] if self._box else None
        ts.data.update(present=here, box_low=frame.box[:, 0].copy(), step=frame.step, time=self._time(frame))
        return ts

    def close(self) -> None:
        """Let go of the file."""
        self._stream = None

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state["_stream"] = None  # a reader in another process opens the file anew
        return state
