# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases and results as HTML, for notebooks and the page of a case before its run; the frames of a run in sequence."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterator, Sequence
from dataclasses import fields
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, overload

import numpy as np

from lammps_jump.analysis import draw, report
from lammps_jump.case.case import ReadCase
from lammps_jump.dump import Dump, Frame, read_dump
from lammps_jump.errors import DumpError, NearestNames
from lammps_jump.files import read_file, write_text, writes
from lammps_jump.scene import Interval, MovingWall, Scene
from lammps_jump.units import numbers_of, shown, sure_of

from .folder import default_folder

if TYPE_CHECKING:
    import xarray as xr

COEFFICIENTS = ("mass", "stiffness", "restitution", "friction", "damping", "time_step", "contact_duration")
"""The coefficients that are shown."""
MOTION_WORDS = {"begin": "from"}
"""Fields of a motion that a case calls otherwise."""
MOST_PICTURE = 100_000_000
"""Bytes of a picture."""


def case_html(name: str, scene: Scene) -> str:
    """Name, coefficients and the drawing of a case."""
    values = scene.coefficients
    units = {key: number.unit for key, number in numbers_of(values).items()}
    rows = "".join(f"<tr><td>{key}</td><td>{getattr(values, key):z.4g} {units[key]}</td></tr>" for key in COEFFICIENTS)
    drawing = draw.svg_text(draw.scene_drawing(scene))
    return f"<p><b>{html.escape(name)}</b>: {html.escape(scene.description)}</p><table>{rows}</table>{drawing}"


def number_table(results: Sequence[object]) -> str:
    """The labelled numbers of some results, at most five, each with its standard error."""
    rows = [
        (number.meaning, shown(value, number.unit, sure_of(result, number.key).value))
        for result in results
        for number in numbers_of(result).values()
        if number.label != number.meaning and (value := getattr(result, number.key)) == value
    ]
    cells = (f"<tr><td>{html.escape(name)}</td><td>{html.escape(text)}</td></tr>" for name, text in rows[:5])
    return f"<table>{''.join(cells)}</table>"


def drawing_of(case: ReadCase, widest: float = draw.WIDEST) -> draw.Drawing:
    """Drawing of a case before it is run, at most so many pixels wide.

    Raises
    ------
    CaseError
        A scene that cannot be run.
    """
    derived, wanted_case = case.check(), case.fields
    columns = [item for item in wanted_case.initial if item.kind == "column"]
    regions = [
        draw.NamedRegion("column" if len(columns) == 1 else f"column {number}", item.x, item.y)
        for number, item in enumerate(columns, start=1)
    ]
    expected = derived.numbers.get("belanger_y2") if wanted_case.analysis.jump else None
    sequent = expected if isinstance(expected, float) else None
    return draw.scene_drawing(derived.scene, regions, sequent=sequent, widest=widest)


def write_preview(case: ReadCase, folder: str | Path = ".") -> tuple[Path, Path]:
    """Draw a case before it is run; page and picture, ``<stem>.preview.html`` and ``.png`` in the folder.

    Raises
    ------
    CaseError
        A scene that cannot be run.
    DumpError
        The folder cannot be written.
    """
    derived, folder = case.check(), Path(folder)
    scene = derived.scene
    name = default_folder(case).name
    picture, path = folder / f"{name}.preview.png", folder / f"{name}.preview.html"
    with writes(folder):
        folder.mkdir(parents=True, exist_ok=True)
    draw.save(draw.figure(drawing_of(case)), picture)
    page, data = report.page, base64.b64encode(read_file(picture, MOST_PICTURE)).decode()
    caption = "At the start, to scale" + ("; dashed shapes and red arrows: how walls move" if scene.moves else "")
    first: list[report.Block] = [
        page.Picture(caption, f"data:{page.PNG};base64,{data}"),
        page.Items(derived.begins, "Where it begins"),
    ]
    first.append(page.Items(scene.warnings, "Doubtful"))
    walls = page.Table([_wall_row(one, scene) for one in scene.walls], ("Wall", "kind", "x [m]", "y [m]", "motion"))
    rows = [(label, value, unit) for _, group in derived.tables for _, label, value, unit in group]
    numbers = page.Table(rows, ("Number", "value", "unit"), "All numbers that follow from the case")
    title = f"{case.name}: before the run"
    sections = [report.Section("", first), report.Section("", [walls, numbers])]
    text = report.render(title, sections, tab=f"{case.name}: preview", name=scene.description)
    with writes(path):
        return write_text(path, text), picture


def _wall_row(one: MovingWall, scene: Scene) -> tuple[str, ...]:
    """Name, kind, place and motion of a wall, in words."""
    wall, motion = one
    moves = "stands"
    if motion.kind is not None:
        given = {part.name: (getattr(motion.kind, part.name), part.default) for part in fields(motion.kind)}
        motion_words = (
            f"{MOTION_WORDS.get(name, name)} {_plain(value)}"
            for name, (value, default) in given.items()
            if value != default
        )
        moves = f"{motion.kind.kind}: {', '.join(motion_words)}"
    if isfinite(motion.gone):
        moves = f"opens at t = {scene.time(int(motion.gone)):z.4g} s" + (f"; {moves}" if motion.kind else "")
    return wall.name, wall.kind, *map(_ends, wall.extent), moves


def _ends(side: Interval) -> str:
    """An interval in words; of a plane the one number, and nothing where there is no end."""
    low, high = side
    if not (isfinite(low) or isfinite(high)):
        return ""
    text = f"{low:z.4g}" if low == high else f"{low:z.4g} … {high:z.4g}"
    return text.replace("-", "\N{MINUS SIGN}")


def _plain(value: object) -> str:
    """A value of a motion; of a long table its number of rows."""
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return f"{len(value)} rows"
    if isinstance(value, tuple):
        return f"({', '.join(map(_plain, value))})"
    return f"{value:zg}" if isinstance(value, int | float) else str(value)


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
    habits: ClassVar[dict[str, str]] = {
        "to_dataframe": "frames[-1].to_dataframe(), or run.to_xarray().to_dataframe() for all",
        "n_frames": "len(frames)",
        "sel": "frames.at(1.5)",
    }

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
        by_column = {name: np.full((len(self), len(ids)), np.nan) for name in names}
        for row, frame in enumerate(self):
            columns = np.searchsorted(ids, frame.ids)
            for name in names:
                by_column[name][row, columns] = frame.column(name)
        arrays = {name: (("time", "disc"), values, {"units": UNITS[name]}) for name, values in by_column.items()}
        return xr.Dataset(arrays, {"time": ("time", self.times, {"units": "s"}), "disc": ids})

    def __repr__(self) -> str:
        times = self.times
        span = f", {times[0]:zg} to {times[-1]:zg} s" if len(times) else ""
        return f"Frames({str(self.folder)!r}, {len(times)} frames{span})"

    def _repr_html_(self) -> str:
        times = self.times
        span = f", from {times[0]:zg} to {times[-1]:zg} s" if len(times) else ""
        return f"<p>{len(times)} frames{span}; columns: {' '.join(self._dump.columns)}</p>"
