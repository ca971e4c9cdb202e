# SPDX-License-Identifier: GPL-2.0-or-later
"""One time of a dump: the discs as columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from lammps_jump.errors import DumpError, NearestNames

if TYPE_CHECKING:
    import pandas as pd

TEXT_COLUMNS = frozenset({"element", "typelabel"})
"""Columns that LAMMPS fills with words: left out of a frame, with a warning."""


BUFFER = 1 << 22


UNPACKED = 50
"""Times its size that a gzip file may grow."""
LARGEST_FRAME = 1 << 33
"""A count of discs beyond this is taken for garbage rather than believed."""


LARGEST_VALUE = 1e9
"""A position (m) or velocity (m/s) beyond this is of a run that blew up."""
LARGEST_ID = 1 << 53
SIZES = frozenset({"radius", "diameter", "mass"})
LIMITED = SIZES | {"id", "x", "y", "vx", "vy", "xu", "yu", "xs", "ys", "xsu", "ysu"}
"""Columns that are looked at before they are used."""


@dataclass(frozen=True)
class Frame(NearestNames):
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

    in_words = "a frame"
    habits: ClassVar[dict[str, str]] = {
        "positions": 'frame.to_numpy("x", "y")',
        "velocities": 'frame.to_numpy("vx", "vy")',
        "head": "frame.to_dataframe().head()",
        "describe": "frame.to_dataframe().describe()",
        "plot": 'run.show(), which plays the run, or run.plot("snapshots")',
        "n_atoms": "frame.n",
        "speed": "numpy.hypot(frame.vx, frame.vy)",
        "speeds": "numpy.hypot(frame.vx, frame.vy)",
        "r": "frame.radii",
        "[]": "frame.x, or frame.to_dataframe() for a table",
    }

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

    def to_dataframe(self) -> pd.DataFrame:
        """The columns as a pandas table, with the ids of the discs as index."""
        import pandas as pd  # 0.3 s

        columns = {name: values for name, values in self.columns.items() if name != "id"}
        return pd.DataFrame(columns, index=pd.Index(self.ids, name="id"))

    def to_numpy(self, *names: str) -> np.ndarray:
        """Columns side by side, shape (n, number of names); all of them where none is named.

        Raises
        ------
        DumpError
            A column that the dump does not have.
        """
        return np.column_stack([self.column(name) for name in names or self.columns])

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            columns = vars(self).get("columns", {})
            return columns[name] if name in columns else self._missing(name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.columns})

    def _repr_html_(self) -> str:
        time = "" if self.time is None else f", {self.time:zg} s"
        return f"<p>step {self.step}{time}: {self.n} discs</p>{self.to_dataframe().head(10).to_html()}"

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
    def z(self) -> np.ndarray | None:
        """Position across the plane, m; None where the file has none."""
        return self._coordinate("z", 2) if {"z", "zu", "zs", "zsu"} & set(self.columns) else None

    @property
    def vx(self) -> np.ndarray:
        """Horizontal velocity, m/s."""
        return self.column("vx")

    @property
    def vy(self) -> np.ndarray:
        """Vertical velocity, m/s."""
        return self.column("vy")

    @property
    def radii(self) -> np.ndarray | None:
        """Radius of each disc, m, from ``radius`` or ``diameter``; None where the file has neither."""
        if "radius" in self.columns:
            return self.columns["radius"]
        return 0.5 * self.columns["diameter"] if "diameter" in self.columns else None

    def sorted(self) -> Frame:
        """The same frame with its discs in the order of their ids."""
        if "id" not in self.columns or np.all(np.diff(self.columns["id"]) > 0):
            return self
        order = np.argsort(self.columns["id"], kind="stable")
        return replace(self, columns=read_only({name: values[order] for name, values in self.columns.items()}))


@dataclass(frozen=True, slots=True)
class FrameHeader:
    """Header above the discs of one frame."""

    step: int
    time: float | None
    n: int


class DumpFile:
    """Facts of a dump file, and notes of a walk through it.

    Attributes
    ----------
    path : Path
    files : list of Path
        The file itself, or those that its path names as a pattern.
    format : {'text', 'binary'}
    compressed : bool
    columns : tuple of str
        Column names of the first frame, words included.
    units : str or None
        LAMMPS unit style where the file tells.
    periodic : (bool, bool)
        Whether what leaves the box of the last frame along x, and along y, enters at its other side.
    warnings : list of str
        What was odd in the last pass: a truncated last frame, columns of words.
    """

    def __init__(self, path: Path, format: str, compressed: bool):
        self.path, self.format, self.compressed = path, format, compressed
        self.files = [path]
        self.columns: tuple[str, ...] = ()
        self.units: str | None = None
        self.periodic = (False, False)
        self.warnings: list[str] = []

    @property
    def most_bytes(self) -> int:
        """More bytes than a dump of this size holds; packed numbers have a third, of discs at rest a tenth."""
        size = self.path.stat().st_size
        return 50_000_000 + UNPACKED * size if self.compressed else size

    @property
    def is_whole(self) -> bool:
        """Tells whether the bytes of `most_bytes` are there, so that a frame may ask for room before it is read."""
        return not self.compressed

    def warn(self, message: str) -> None:
        """Note something odd once per pass."""
        if message not in self.warnings:
            self.warnings.append(message)


def read_only(columns: dict[str, np.ndarray]) -> Mapping[str, np.ndarray]:
    """The same columns, and none of them can be changed."""
    for values in columns.values():
        values.flags.writeable = False
    return MappingProxyType(columns)


def make_frame(step: int, time: float | None, box: Any, columns: Mapping[str, np.ndarray]) -> Frame:
    """A frame from plain arrays (copied to float64): for made-up dumps and converters.

    Parameters
    ----------
    step, time : int, float or None
    box : array_like, shape (3, 2) or (2, 2)
        Bounds, m; z defaults to (-0.1, 0.1).
    columns : mapping of str to array_like, shape (n,)
    """
    arrays = {name: np.array(values, dtype=float).reshape(-1) for name, values in columns.items()}
    if len({len(values) for values in arrays.values()}) > 1:
        lengths = ", ".join(f"{name} {len(values)}" for name, values in arrays.items())
        raise DumpError(f"the columns of step {step} differ in length: {lengths}.")
    bounds = np.array([[0.0, 0.0], [0.0, 0.0], [-0.1, 0.1]])
    bounds[: len(box)] = box
    return Frame(int(step), None if time is None else float(time), bounds, read_only(arrays))


def require_finite(frame: Frame, source: object) -> Frame:
    """The frame itself; DumpError where a position or velocity is no number or absurd, naming step and disc."""
    if not (frame.time is None or np.isfinite(frame.time)) or not np.isfinite(frame.box).all():
        raise DumpError(f"{source}: step {frame.step}: its time or its box is no number; the file is damaged")
    for name in (column for column in frame.columns if column in LIMITED):
        values = frame.columns[name]
        good = np.abs(values) <= (LARGEST_ID if name == "id" else LARGEST_VALUE)  # false where it is no number
        if name in SIZES:
            good &= values > 0
        if not good.all():
            row = int(np.argmin(good))
            wrong = "beyond what can be" if np.isfinite(values[row]) else "not a number"
            raise DumpError(
                f"{source}: step {frame.step}, row {row + 1} of the frame: {name} is {values[row]}, {wrong}; the "
                "run that wrote it blew up: lower its time step, or analyse the frames before"
            )
    return frame


def ten_indices(count: int, pictures: int = 10) -> list[int]:
    """Indices of equally spaced frames out of `count`, the first and the last among them."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(pictures, count))}) if count else []
