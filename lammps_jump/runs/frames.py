# SPDX-License-Identifier: GPL-2.0-or-later
"""The frames of a run, as a sequence: by number, by time, one by one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from lammps_jump.dump import Dump, Frame, read_dump
from lammps_jump.errors import DumpError, NearestNames

if TYPE_CHECKING:
    import xarray as xr

MOST_VALUES = 100_000_000
"""Numbers of `Frames.to_xarray`: 0.8 GB."""
COLUMNS = ("x", "y", "vx", "vy", "radius")
UNITS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "radius": "m"}


class Frames(NearestNames):
    """The frames of a run: ``frames[10]``, ``frames[-1]``, ``frames.at(1.5)``, or a loop that holds one at a time.

    Parameters
    ----------
    folder : str or Path
        A run folder.
    time_step : float
        s; gives the time of a frame whose dump has none.
    settle_steps : int
        Steps before t = 0.
    """

    in_words = "the sequence of frames"

    def __init__(self, folder: str | Path, time_step: float, settle_steps: int = 0):
        self.folder = Path(folder)
        self._time_step, self._settle_steps = time_step, settle_steps

    @cached_property
    def _dump(self) -> Dump:
        return read_dump(self.folder)

    @cached_property
    def times(self) -> np.ndarray:
        """Times of the frames, s, shape (n,).

        Raises
        ------
        DumpError
            No dump, or one that cannot be read.
        """
        known = ((one.time, one.step) for one in self._dump.headers())
        times = [self._time_step * (step - self._settle_steps) if time is None else time for time, step in known]
        return np.array(times, dtype=float)

    def __len__(self) -> int:
        return len(self._dump)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self._dump)

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Iterator[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | Iterator[Frame]:
        return self._dump[index]

    def __call__(self, start: int | None = None, stop: int | None = None, step: int | None = None) -> Iterator[Frame]:
        """The frames one by one; numbers as of a slice.

        Raises
        ------
        DumpError
            No dump, or one that cannot be read.
        """
        return iter(self._dump) if start is stop is step is None else self._dump[start:stop:step]

    def at(self, time: float) -> Frame:
        """The frame nearest to a time, s.

        Raises
        ------
        DumpError
            A time outside of those of the frames.
        """
        times = self.times
        if not len(times):
            raise DumpError(f"{self.folder}: its dump holds no frame yet")
        slack = 1e-9 * max(abs(times[0]), abs(times[-1])) + 0.5 * float(np.diff(times).max(initial=0.0))
        if not times[0] - slack <= time <= times[-1] + slack:
            raise DumpError(f"{self.folder}: time {time} s; its frames are from {times[0]:zg} to {times[-1]:zg} s")
        return self._dump[int(np.abs(times - time).argmin())]

    def to_xarray(self) -> xr.Dataset:
        """All frames over time (s) and disc: x, y (m), vx, vy (m/s), radius (m); NaN where a disc is not there.

        Raises
        ------
        DumpError
            More than `MOST_VALUES` numbers, or a dump that cannot be read.
        """
        import xarray as xr  # 0.3 s

        names = [name for name in COLUMNS if name in self._dump.columns]
        ids = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(frame.ids for frame in self)]))
        count = len(names) * len(ids) * len(self)
        if count > MOST_VALUES:
            raise DumpError(
                f"{self.folder}: its frames are {count} numbers for to_xarray, and at most {MOST_VALUES} are allowed; "
                "use a loop over run.frames"
            )
        found = {name: np.full((len(self), len(ids)), np.nan) for name in names}
        for row, frame in enumerate(self):
            columns = np.searchsorted(ids, frame.ids)
            for name in names:
                found[name][row, columns] = frame.column(name)
        arrays = {name: (("time", "disc"), values, {"units": UNITS[name]}) for name, values in found.items()}
        return xr.Dataset(arrays, {"time": ("time", self.times, {"units": "s"}), "disc": ids})

    def __repr__(self) -> str:
        times = self.times
        span = f", {times[0]:zg} to {times[-1]:zg} s" if len(times) else ""
        return f"Frames({str(self.folder)!r}, {len(times)} frames{span})"

    def _repr_html_(self) -> str:
        times = self.times
        span = f", from {times[0]:zg} to {times[-1]:zg} s" if len(times) else ""
        return f"<p>{len(times)} frames{span}; columns: {' '.join(self._dump.columns)}</p>"
