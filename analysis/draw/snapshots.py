# SPDX-License-Identifier: GPL-2.0-or-later
"""Ten pictures of the discs at equal times (the thesis' picture0 … picture9)."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.image import AxesImage

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame, ten_indices
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError

from .painter import View, blank, paint_frame, paint_walls
from .scope import disc_speeds, seen, top_of
from .style import STYLE, colour_bar, style

SIDE, GAP, RIGHT, TOP, HEAD, FOOT = 0.6, 0.22, 0.2, 0.24, 0.24, 1.04
"""Room for labels left of the pictures, between and right of them, above all, above each and below, inches."""
BAR = 0.52, 0.12
"""Bottom and height of the colour bar, inches."""


def snapshots(frames: Dump | Sequence[Frame], flow: Flow) -> Figure:
    """Discs at ten equal times as true circles coloured by speed, walls in grey (the thesis' ten pictures).

    Shown is the studied stretch, as high as discs go. Colours end at the 99.5 % quantile of the speeds.

    Parameters
    ----------
    frames : Dump or sequence of Frame
        Of a Dump only the ten frames are parsed.
    flow : Flow
    """
    indices = ten_indices(len(frames))
    chosen = list(frames.select(indices)) if isinstance(frames, Dump) else [frames[i] for i in indices]
    if not chosen:
        raise DumpError("there is no frame to draw.")
    x, y = seen(chosen, flow)
    top_speed = top_of([disc_speeds(frame) for frame in chosen])
    figure, places, width = layout(len(chosen), (x[1] - x[0]) / (y[1] - y[0]))
    view = View.fitted(x, y, round(width * STYLE["savefig.dpi"]))
    with style(), mpl.rc_context({"axes.grid": False}):
        FigureCanvasAgg(figure)
        for frame, place in zip(chosen, places, strict=True):
            picture = blank(view)
            time = flow.time(frame)
            paint_walls(picture, view, flow.standing_at(time), flow.shut_gates(time))
            paint_frame(picture, view, frame, flow, top_speed)
            axes = figure.add_subplot(place)
            axes.add_image(Painted(picture, axes, view))
            # no title: its place is sought among all ticks, which took a fifth of the time
            text = f"{flow.clock(time)}   {flow.count(frame)} discs"
            axes.annotate(text, (0, 1), (0, 3), "axes fraction", "offset points", fontsize=8)
            lowest, leftmost = place.num1 + place.get_gridspec().ncols >= len(chosen), place.is_first_col()
            for axis, name, labelled in ((axes.xaxis, "x [m]", lowest), (axes.yaxis, "y [m]", leftmost)):
                axis.set_visible(labelled)  # ticks without labels took as long as those with
                axis.set_tick_params(labelsize=7)
                axis.set_label_text(name, fontsize=8)
        wide, high = figure.get_size_inches()
        bar = figure.add_axes((SIDE / wide, BAR[0] / high, 1 - (SIDE + RIGHT) / wide, BAR[1] / high))
        scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(0, top_speed), "cividis")
        colour_bar(figure, scale, "Speed [m/s]", cax=bar, orientation="horizontal")
        figure.suptitle(flow.title, x=0.01, y=1 - 0.07 / high, ha="left", va="top", fontsize=10)
    return figure


class Painted(AxesImage):
    """A picture of a view that fills its axes, pixel for pixel; matplotlib's own images take eight times as long."""

    def __init__(self, picture: np.ndarray, axes: Axes, view: View):
        super().__init__(axes, extent=(*view.x, *view.y), interpolation="nearest")
        self.set_data(picture)
        self.picture = picture
        axes.set(xlim=view.x, ylim=view.y)

    def make_image(self, renderer: Any, magnification: float = 1.0, unsampled: bool = False) -> Any:
        """RGBA from the lowest row on, its place (pixels), and no transformation."""
        picture = self.picture
        left, low, right, high = np.multiply(self.get_window_extent().extents, magnification)
        left, low, right, high = (floor(left + 0.5), ceil(low - 0.5), floor(right + 0.5), ceil(high - 0.5))
        down, across = (
            ((np.arange(wanted) + 0.5) * there / wanted).astype(int)
            for wanted, there in zip((high - low, right - left), picture.shape, strict=False)
        )
        drawn = np.full((len(down), len(across), 4), 255, np.uint8)
        drawn[..., :3] = picture[down[::-1, None], across]
        return drawn, left / magnification, low / magnification, None


def layout(pictures: int, wide: float) -> tuple[Figure, list[SubplotSpec], float]:
    """A figure, at most 9.6 inches wide, with places for equal pictures above a colour bar, and their width (inches).

    The places come from measured labels: no layout engine has to search. Pictures are `wide` times as wide as high.
    """
    columns = min(pictures, 1 if wide > 4.5 else 2 if wide > 1.6 else 5)
    rows = -(-pictures // columns)
    height = (9.6 - SIDE - RIGHT - (columns - 1) * GAP) / columns / wide
    height = min(height, (24 - TOP - FOOT) / rows - HEAD)
    width = height * wide
    across, high = SIDE + columns * width + (columns - 1) * GAP + RIGHT, TOP + rows * (HEAD + height) + FOOT
    figure = Figure(figsize=(across, high))
    sides = {"left": SIDE / across, "right": 1 - RIGHT / across, "bottom": FOOT / high, "top": 1 - (TOP + HEAD) / high}
    grid = figure.add_gridspec(rows, columns, wspace=GAP / width, hspace=HEAD / height, **sides)
    return figure, [grid[divmod(index, columns)] for index in range(pictures)], width
