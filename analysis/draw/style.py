# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of a flow, their style and how they are saved: depth profile, map of depth over distance and time.

Every function returns a matplotlib ``Figure`` with its own Agg canvas: no global state, no screen. Colours are
cividis (readable in grey and for the colour-blind); lines differ in dash as well as in colour.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lammps_jump.analysis.flow import Flow
from lammps_jump.errors import DumpError
from lammps_jump.quoting import figure_text
from lammps_jump.scene.walls import Interval

STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.6,
    "image.cmap": "cividis",
    "figure.dpi": 100,
    "savefig.dpi": 130,
}
BLUE, GOLD, GREY, BLACK, RED = "#00306f", "#b08a00", "#8a8a8a", "#1a1a1a", "#b3263a"
DASHES = ("-", "--", ":", "-.")
WALL = "#c4c4c4"


@contextmanager
def style() -> Iterator[None]:
    """matplotlib settings of this package, for the time of a ``with`` block."""
    with mpl.rc_context(STYLE):
        yield


def new_figure(width: float = 7.2, height: float = 3.6, rows: int = 1, columns: int = 1, **subplots):
    """A figure with its Agg canvas and its axes (call it inside `style`).

    Parameters
    ----------
    width, height : float
        Inches.
    rows, columns : int
        Grid of axes; further keywords go to ``Figure.subplots``.
    """
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **subplots)


@contextmanager
def drawing(*size: float, **subplots) -> Iterator[tuple]:
    """`new_figure` inside `style`, for the time of a ``with`` block; the arguments are those of `new_figure`."""
    with style():
        yield new_figure(*size, **subplots)


def colour_bar(figure: Figure, colours, label: str, **place) -> None:
    """Colour bar without a frame, of an image or map of colours; keywords go to ``Figure.colorbar``."""
    bar = figure.colorbar(colours, **place)
    bar.set_label(label)
    bar.outline.set_visible(False)


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure; the format follows the ending of the name. DumpError where the place cannot be written."""
    path = Path(path)
    try:
        with style():
            if path.suffix == ".png":
                _write_png(figure, path)
            else:
                figure.savefig(path)
    except (OSError, ValueError) as error:
        raise DumpError(f"{path}: the figure cannot be written ({error}).") from error
    return path


def _write_png(figure: Figure, path: Path) -> None:
    """The picture of one drawing: ``savefig`` lays a figure out and draws it twice, which is most of its time."""
    from PIL import Image

    before, dots = figure.get_dpi(), mpl.rcParams["savefig.dpi"]
    figure.set_dpi(dots)
    figure.canvas.draw()
    picture = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    figure.set_dpi(before)
    # level 3 packs a figure in two thirds of the time of zlib's default, for files no larger
    picture.save(path, dpi=(dots, dots), compress_level=3)


def draw_walls(axes, walls, x: Interval, y: Interval) -> None:
    """Walls as grey solids inside the given extent, m."""
    from matplotlib.patches import Polygon

    far = 10 * (abs(x[1] - x[0]) + abs(y[1] - y[0]))
    around = (x[0] - far, x[1] + far), (y[0] - far, y[1] + far)
    for wall in walls:
        for polygon in wall.outline(*around):
            if wall.hollow:
                axes.plot(*np.vstack([polygon, polygon[:1]]).T, color="#464646", lw=1)
            else:
                axes.add_patch(Polygon(polygon, facecolor=WALL, edgecolor="none", zorder=0.5))
    axes.set_xlim(*x)
    axes.set_ylim(*y)


def axis_label(quantity: xr.DataArray) -> str:
    """Name and unit of a quantity for an axis, from its attributes ``long_name`` and ``units``."""
    name = quantity.attrs.get("long_name", quantity.name).removeprefix("time mean of ")
    units = quantity.attrs.get("units", "")
    for text, nice in (("m2 s-1", "m²/s"), ("m3 s-2", "m³/s²"), ("m4 s-3", "m⁴/s³"), ("m s-1", "m/s")):
        units = units.replace(text, nice)
    return f"{name[:1].upper()}{name[1:]}" + (f" [{units}]" if units not in ("", "1") else "")


def depth_profile(
    profiles: xr.Dataset,
    flow: Flow,
    *,
    lines: Mapping[str, float] | None = None,
    marks: Mapping[str, float] | None = None,
) -> Figure:
    """Mean free surface and mass depth along the channel, with the classical depths beside them; velocity below.

    Parameters
    ----------
    profiles : xarray.Dataset
        Of `compute_profiles`.
    flow : Flow
    lines : mapping of label to depth (m), optional
        Horizontal lines to compare with.
    marks : mapping of label to x (m), optional
        Vertical marks: toe, end of the jump.
    """
    compare = lines or {}
    bed = profiles.bed.values
    with drawing(7.6, 5.0, 2, 1, sharex=True, height_ratios=[2.2, 1]) as (figure, (upper, lower)):
        low = min(0.0, float(np.min(bed[np.isfinite(bed)], initial=0.0)))
        depths = [profiles[f"{name}_mean"].values + bed for name in ("surface_depth", "mass_depth")]
        top = float(np.nanmax([1.0, *compare.values(), *depths[0], *depths[1]]))
        draw_walls(upper, flow.scene.walls, _occupied(profiles), (low - 0.04 * top, 1.15 * top))
        _mean(upper, profiles, "surface_depth", bed, color=BLUE, label="free surface")
        _mean(upper, profiles, "mass_depth", bed, color=GOLD, ls="--", label="mass depth")
        for i, (label, value) in enumerate(compare.items()):
            upper.axhline(value, color=BLACK, lw=1, ls=(0, (6, 2 + 2 * i)), zorder=1)
            upper.annotate(
                label, (1, value), (-3, 2), xycoords=("axes fraction", "data"), textcoords="offset points",
                ha="right", fontsize=8, color=BLACK,
            )  # fmt: skip
        upper.legend(loc="upper left", bbox_to_anchor=(0, 0.97), frameon=True, edgecolor="none", framealpha=0.95)
        begin, end, frames = (profiles.attrs[f"window_{name}"] for name in ("begin", "end", "frames"))
        title = f"{flow.title}: mean of {frames} frames, {flow.clock(begin, end)}"
        upper.set(ylabel="Height above y = 0 [m]", title=title)
        _mean(lower, profiles, "velocity", 0.0, color=BLUE, label="mean velocity")
        lower.plot(profiles.x, profiles.surface_velocity_mean, color=GOLD, ls="--", lw=1.2, label="at the surface")
        lower.axhline(0, color=GREY, lw=0.8)
        lower.set(xlabel="Distance x [m]", ylabel="Velocity [m/s]")
        lower.legend(loc="best")
        for label, place in (marks or {}).items():
            for axes in (upper, lower):
                axes.axvline(place, color=RED, lw=1, ls=":")
            upper.annotate(
                label, (place, 1), (3, -10), xycoords=("data", "axes fraction"), textcoords="offset points",
                fontsize=8, color=RED,
            )  # fmt: skip
    return figure


def _mean(axes, profiles: xr.Dataset, name: str, above, *, color: str, **look) -> None:
    """A mean of the window, drawn `above` this height, with two standard errors either side where there are any."""
    mean, error = profiles[f"{name}_mean"].values + above, profiles[f"{name}_stderr"].values
    axes.plot(profiles.x, mean, color=color, **look)
    if np.isfinite(error).any():
        axes.fill_between(profiles.x, mean - 2 * error, mean + 2 * error, color=color, alpha=0.2, lw=0)


def _bin_edges(profiles: xr.Dataset) -> np.ndarray:
    return np.linspace(profiles.attrs["x_low"], profiles.attrs["x_high"], profiles.sizes["x"] + 1)


def _occupied(profiles: xr.Dataset) -> Interval:
    """The bins from the first to the last that held a disc in the window, m; all where none did."""
    edges, held = _bin_edges(profiles), np.flatnonzero(profiles["count_mean"].values > 0)
    return (edges[held[0]], edges[held[-1] + 1]) if held.size else (edges[0], edges[-1])


def xt_map(
    profiles: xr.Dataset,
    variable: str = "surface_depth",
    *,
    toe: tuple[np.ndarray, np.ndarray] | None = None,
    title: str | None = None,
) -> Figure:
    """Map of a profile variable over distance and time.

    Parameters
    ----------
    profiles : xarray.Dataset
    variable : str
        A (time, x) variable.
    toe : (ndarray, ndarray), optional
        Places (m) and times (s) of a tracked front, drawn on top.
    """
    values = profiles[variable].values
    time = profiles.time.values
    with drawing(7.6, 4.2) as (figure, axes):
        axes.grid(False)
        signed = variable in ("velocity", "surface_velocity", "discharge") and np.nanmin(values, initial=0.0) < 0
        x = _bin_edges(profiles)
        finite = values[np.isfinite(values)]
        low, high = (float(np.quantile(finite, q)) for q in (0.002, 0.998)) if finite.size else (0.0, 1.0)
        image = axes.pcolormesh(
            x, _edges(time), values, vmin=low if signed else 0.0, vmax=max(high, 1e-12), rasterized=True
        )
        colour_bar(figure, image, axis_label(profiles[variable]), ax=axes, pad=0.02)
        if finite.size and high > 0 and not signed and min(values.shape) > 1:
            axes.contour(
                profiles.x.values, time, np.nan_to_num(values), levels=high * np.array([0.25, 0.5, 0.75]),
                colors="white", linewidths=0.7,
            )  # fmt: skip
        if toe is not None:
            axes.plot(*toe, color=RED, lw=1.4, ls="--", label="front")
            axes.legend(loc="upper right", labelcolor=BLACK, frameon=True, framealpha=0.9)
        seen = np.flatnonzero(np.isfinite(values).any(axis=0))
        if seen.size:
            axes.set_xlim(x[seen[0]], x[seen[-1] + 1])
        name = figure_text(profiles.attrs.get("title", "").removeprefix("depth profiles of "))
        title = title or f"{name}: {variable.replace('_', ' ')} over distance and time"
        timed = profiles.time.attrs.get("units") != "1"
        axes.set(xlabel="Distance x [m]", ylabel="Time t [s]" if timed else "Step", title=title)
    return figure


def _edges(time: np.ndarray) -> np.ndarray:
    if len(time) == 1:
        return np.array([time[0] - 0.5, time[0] + 0.5])
    middle = 0.5 * (time[1:] + time[:-1])
    return np.concatenate([[time[0] - (middle[0] - time[0])], middle, [time[-1] + (time[-1] - middle[-1])]])
