# SPDX-License-Identifier: GPL-2.0-or-later
"""Ten pictures of the discs at equal times (the thesis' picture0 … picture9), and what of the plane a picture shows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame, ten_indices
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError
from lammps_jump.scene.walls import Interval

from .painter import View, blank, colour_table, coloured, paint_discs, paint_walls
from .style import STYLE, colour_bar, style


def snapshots(
    frames: Dump | Sequence[Frame] | Iterable[Frame],
    flow: Flow,
    *,
    x: Interval | None = None,
    y: Interval | None = None,
    top_speed: float | None = None,
    pictures: int = 10,
    title: str | None = None,
) -> Figure:
    """Discs at ten equal times as true circles coloured by speed, walls in grey (the thesis' ten pictures).

    Parameters
    ----------
    frames : Dump or iterable of Frame
        Of a Dump only the ten frames are parsed.
    flow : Flow
    x, y : (float, float), optional
        What is shown, m; default the studied stretch, and as high as discs go.
    top_speed : float, optional
        m/s at the end of the colour scale; default the 99.5 % quantile over the pictures.
    """
    if isinstance(frames, Dump):
        chosen = list(frames.select(ten_indices(frames.count(), pictures)))
    else:
        given = list(frames)
        chosen = [given[i] for i in ten_indices(len(given), pictures)]
    if not chosen:
        raise DumpError("there is no frame to draw.")
    x = x or seen_range(chosen, flow)
    y = y or seen_heights(chosen, flow, x)
    speeds = [disc_speeds(frame) for frame in chosen]
    top_speed = top_speed or top_of(speeds)
    grid = _Grid.fitted(len(chosen), (x[1] - x[0]) / (y[1] - y[0]))
    view = View.fitted(x, y, round(grid.width * STYLE["savefig.dpi"]))
    table = colour_table()
    with style():
        figure = Figure(figsize=grid.size)
        FigureCanvasAgg(figure)
        first = None
        for index, (frame, speed) in enumerate(zip(chosen, speeds, strict=True)):
            picture = blank(view)
            paint_walls(picture, view, flow.scene.walls, flow.shut_gates(flow.time(frame)))
            paint_discs(picture, view, frame.x, frame.y, flow.radii(frame), coloured(speed, top_speed, table))
            axes = figure.add_axes(grid.place(index), sharex=first, sharey=first)
            first = first or axes
            axes.imshow(picture, extent=(*view.x, *view.y), interpolation="nearest", aspect="auto")
            axes.grid(False)
            axes.set_title(f"t = {flow.time(frame):.2f} s   {frame.n} discs", fontsize=8, pad=3)
            lowest, leftmost = index + grid.columns >= len(chosen), index % grid.columns == 0
            axes.tick_params(labelsize=7, labelbottom=lowest, labelleft=leftmost)
            if lowest:
                axes.set_xlabel("x [m]", fontsize=8)
            if leftmost:
                axes.set_ylabel("y [m]", fontsize=8)
        scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(0, top_speed), "cividis")
        colour_bar(figure, scale, "Speed [m/s]", cax=figure.add_axes(grid.bar), orientation="horizontal")
        figure.suptitle(title or flow.scene.name, x=0.01, y=1 - 0.07 / grid.size[1], ha="left", va="top", fontsize=10)
    return figure


@dataclass(frozen=True)
class _Grid:
    """Places of equal pictures above a colour bar, in inches from measured labels: no layout engine has to search.

    Attributes
    ----------
    columns : int
    width, height : float
        Of one picture.
    size : (float, float)
        Of the figure.
    """

    columns: int
    width: float
    height: float
    size: tuple[float, float]

    SIDE, GAP, RIGHT = 0.6, 0.22, 0.2
    TOP, HEAD, FOOT = 0.24, 0.24, 1.04
    BAR = 0.52, 0.12

    @classmethod
    def fitted(cls, pictures: int, wide: float) -> _Grid:
        """The grid of this many pictures that are `wide` times as wide as high, 9.6 inches wide."""
        columns = min(pictures, 1 if wide > 4.5 else 2 if wide > 1.6 else 5)
        rows = -(-pictures // columns)
        width = (9.6 - cls.SIDE - cls.RIGHT - (columns - 1) * cls.GAP) / columns
        most = (24 - cls.TOP - cls.FOOT) / rows - cls.HEAD
        height = width / wide
        if height > most:
            width, height = width * most / height, most
        total = cls.SIDE + columns * width + (columns - 1) * cls.GAP + cls.RIGHT
        return cls(columns, width, height, (total, cls.TOP + rows * (cls.HEAD + height) + cls.FOOT))

    def place(self, index: int) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of a picture as shares of the figure."""
        row, column = divmod(index, self.columns)
        left = self.SIDE + column * (self.width + self.GAP)
        top = self.TOP + row * (self.HEAD + self.height) + self.HEAD
        wide, high = self.size
        return left / wide, 1 - (top + self.height) / high, self.width / wide, self.height / high

    @property
    def bar(self) -> tuple[float, float, float, float]:
        """The same of the colour bar."""
        wide, high = self.size
        return self.SIDE / wide, self.BAR[0] / high, 1 - (self.SIDE + self.RIGHT) / wide, self.BAR[1] / high


def disc_speeds(frame: Frame) -> np.ndarray:
    """Speeds, m/s; zero where the dump has no velocities."""
    if "vx" in frame.columns and "vy" in frame.columns:
        return np.hypot(frame.vx, frame.vy)
    return np.zeros(frame.n)


def top_of(speeds: Sequence[np.ndarray]) -> float:
    """End of a colour scale: a rounded 99.5 % quantile of all speeds, so that one fast disc does not darken all."""
    together = np.concatenate(list(speeds)) if speeds else np.zeros(0)
    together = together[np.isfinite(together)]
    high = float(np.quantile(together, 0.995)) if together.size else 0.0
    if not high > 0:
        return 1.0
    unit = 10.0 ** np.floor(np.log10(high))
    return float(np.ceil(2 * high / unit) / 2 * unit)


def seen_range(frames: Sequence[Frame], flow: Flow) -> Interval:
    """The studied stretch, cut short where the frames hold neither a disc nor a block, m."""
    low, high = flow.x_range
    parts = [frame.x[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    ends = [float(np.quantile(part, q)) for part in parts if part.size for q in (0.0, 0.999)]
    ends += [end for wall in flow.scene.walls if wall.finite for end in wall.extent[0] if low < end < high]
    if not ends:
        return low, high
    margin = 0.02 * (max(ends) - min(ends)) + 2 * flow.scene.diameter
    return max(low, min(ends) - margin), min(high, max(ends) + margin)


def seen_heights(frames: Sequence[Frame], flow: Flow, x: Interval) -> Interval:
    """Heights worth showing, m: from just below the floor to just above nearly all discs within x."""
    floors = flow.bed_height(np.linspace(*x, 200))
    floors = floors[np.isfinite(floors)]
    low = float(np.min(floors)) if floors.size else flow.scene.domain[1][0]
    heights = [frame.y[(frame.x >= x[0]) & (frame.x <= x[1])] for frame in frames]
    tops = [float(np.quantile(part, 0.995)) for part in heights if part.size]
    top = max([*tops, low + 5 * flow.scene.diameter])
    for wall in flow.scene.walls:
        (start, end), (_, highest) = wall.extent
        if wall.finite and end > x[0] and start < x[1]:
            top = max(top, highest)
    margin = 0.06 * (top - low) + flow.scene.diameter
    return low - margin, top + margin
