"""Figures of a flow: depth profile, map of depth over distance and time, ten snapshots of the discs.

Every function returns a matplotlib ``Figure`` with its own Agg canvas: no global state, no screen. Colours are
cividis (readable in grey and for the colour-blind); lines differ in dash as well as in colour.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lammps_jump.errors import DumpError
from lammps_jump.walls import Block, Box, Interval, Plane

from .context import FlowContext
from .dump import Dump, Frame, ten_indices
from .painter import View, blank, colour_table, coloured, paint_discs, paint_walls

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


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure; the format follows the ending of the name. DumpError where the place cannot be written."""
    path = Path(path)
    try:
        with style():
            # level 3 packs a figure in half the time of zlib's default, for files a tenth larger
            figure.savefig(path, **({"pil_kwargs": {"compress_level": 3}} if path.suffix == ".png" else {}))
    except (OSError, ValueError) as error:
        raise DumpError(f"{path}: the figure cannot be written ({error}).") from error
    return path


def draw_walls(axes, walls, x: Interval, y: Interval) -> None:
    """Walls as grey solids inside the given extent, m."""
    from matplotlib.patches import Rectangle

    far = 10 * (abs(x[1] - x[0]) + abs(y[1] - y[0]))

    def solid(x0, x1, y0, y1):
        axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, facecolor=WALL, edgecolor="none", zorder=0.5))

    for wall in walls:
        if isinstance(wall, Block):
            solid(*wall.x, *wall.y)
        elif isinstance(wall, Plane):
            low, high = (wall.at - far, wall.at) if wall.side == "above" else (wall.at, wall.at + far)
            solid(*((x[0] - far, x[1] + far, low, high) if wall.axis == "y" else (low, high, y[0] - far, y[1] + far)))
        elif isinstance(wall, Box):
            axes.plot([*wall.x, *wall.x[::-1], wall.x[0]], np.repeat(wall.y, 2)[[0, 1, 3, 2, 0]], color="#464646", lw=1)
    axes.set_xlim(*x)
    axes.set_ylim(*y)


def _label(quantity: xr.DataArray) -> str:
    name = quantity.attrs.get("long_name", quantity.name).removeprefix("time mean of ")
    units = quantity.attrs.get("units", "")
    for text, nice in (("m2 s-1", "m²/s"), ("m3 s-2", "m³/s²"), ("m4 s-3", "m⁴/s³"), ("m s-1", "m/s")):
        units = units.replace(text, nice)
    return f"{name[:1].upper()}{name[1:]}" + (f" [{units}]" if units not in ("", "1") else "")


def depth_profile(
    profiles: xr.Dataset,
    context: FlowContext,
    *,
    lines: Mapping[str, float] | None = None,
    y1: float | None = None,
    y2: float | None = None,
    marks: Mapping[str, float] | None = None,
    title: str | None = None,
) -> Figure:
    """Mean free surface and mass depth along the channel, with the classical depths beside them; velocity below.

    Parameters
    ----------
    profiles : xarray.Dataset
        Of `compute_profiles`.
    context : FlowContext
    lines : mapping of label to depth (m), optional
        Horizontal lines to compare with.
    y1, y2 : float, optional
        Shorthand for the inflow depth and the sequent depth of Bélanger, m.
    marks : mapping of label to x (m), optional
        Vertical marks: toe, end of the jump.
    """
    compare = dict(lines or {})
    if y1 is not None:
        compare |= {f"y₁ = {y1:.3g} m": y1}
    if y2 is not None:
        compare |= {f"Bélanger y₂ = {y2:.3g} m": y2}
    x, bed = profiles.x.values, profiles.bed.values
    surface = profiles.surface_depth_mean.values + bed
    mass = profiles.mass_depth_mean.values + bed
    extent = _occupied(profiles)
    with style():
        figure, (upper, lower) = new_figure(7.6, 5.0, 2, 1, sharex=True, height_ratios=[2.2, 1])
        low = min(0.0, float(np.min(bed[np.isfinite(bed)], initial=0.0)))
        tops = [1.0, *compare.values(), *surface[np.isfinite(surface)], *mass[np.isfinite(mass)]]
        draw_walls(upper, context.walls, extent, (low - 0.04 * max(tops), 1.15 * max(tops)))
        upper.plot(x, surface, color=BLUE, label="free surface")
        _band(upper, x, surface, profiles.surface_depth_stderr.values, BLUE)
        upper.plot(x, mass, color=GOLD, ls="--", label="mass depth")
        _band(upper, x, mass, profiles.mass_depth_stderr.values, GOLD)
        for i, (label, value) in enumerate(compare.items()):
            upper.axhline(value, color=BLACK, lw=1, ls=(0, (6, 2 + 2 * i)), zorder=1)
            upper.annotate(
                label, (1, value), (-3, 2), xycoords=("axes fraction", "data"), textcoords="offset points",
                ha="right", fontsize=8, color=BLACK,
            )  # fmt: skip
        upper.set_ylabel("Height above y = 0 [m]")
        upper.legend(loc="upper left", bbox_to_anchor=(0, 0.97), frameon=True, edgecolor="none", framealpha=0.95)
        begin, end = profiles.attrs["window_begin"], profiles.attrs["window_end"]
        upper.set_title(
            title or f"{context.name}: mean of {profiles.attrs['window_frames']} frames, t = {begin:g} … {end:g} s"
        )
        velocity = profiles.velocity_mean.values
        lower.plot(x, velocity, color=BLUE, label="mean velocity")
        _band(lower, x, velocity, profiles.velocity_stderr.values, BLUE)
        lower.plot(x, profiles.surface_velocity_mean.values, color=GOLD, ls="--", lw=1.2, label="at the surface")
        lower.axhline(0, color=GREY, lw=0.8)
        lower.set_ylabel("Velocity [m/s]")
        lower.set_xlabel("Distance x [m]")
        lower.legend(loc="best")
        for label, place in (marks or {}).items():
            for axes in (upper, lower):
                axes.axvline(place, color=RED, lw=1, ls=":")
            upper.annotate(
                label, (place, 1), (3, -10), xycoords=("data", "axes fraction"), textcoords="offset points",
                fontsize=8, color=RED,
            )  # fmt: skip
    return figure


def _band(axes, x, mean, error, colour) -> None:
    """Two standard errors either side, where there are any."""
    if np.isfinite(error).any():
        axes.fill_between(x, mean - 2 * error, mean + 2 * error, color=colour, alpha=0.2, lw=0)


def _extent(profiles: xr.Dataset) -> Interval:
    return float(profiles.attrs["x_low"]), float(profiles.attrs["x_high"])


def _occupied(profiles: xr.Dataset) -> Interval:
    """The bins from the first to the last that held a disc in the window, m; all where none did."""
    held = np.flatnonzero(profiles["count_mean"].values > 0)
    low, high = _extent(profiles)
    if not held.size:
        return low, high
    width = (high - low) / profiles.sizes["x"]
    return low + width * held[0], low + width * (held[-1] + 1)


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
    with style():
        figure, axes = new_figure(7.6, 4.2)
        axes.grid(False)
        signed = variable in ("velocity", "surface_velocity", "discharge") and np.nanmin(values, initial=0.0) < 0
        x = np.linspace(*_extent(profiles), values.shape[1] + 1)
        finite = values[np.isfinite(values)]
        low, high = (float(np.quantile(finite, q)) for q in (0.002, 0.998)) if finite.size else (0.0, 1.0)
        image = axes.pcolormesh(
            x, _edges(time), values, vmin=low if signed else 0.0, vmax=max(high, 1e-12), rasterized=True
        )
        bar = figure.colorbar(image, ax=axes, pad=0.02)
        bar.set_label(_label(profiles[variable]))
        bar.outline.set_visible(False)
        if finite.size and high > 0 and not signed and min(values.shape) > 1:
            axes.contour(
                profiles.x.values, time, np.nan_to_num(values), levels=high * np.array([0.25, 0.5, 0.75]),
                colors="white", linewidths=0.7,
            )  # fmt: skip
        if toe is not None:
            axes.plot(*toe, color=RED, lw=1.4, ls="--", label="front")
            axes.legend(loc="upper right", labelcolor=BLACK, frameon=True, framealpha=0.9)
        axes.set_xlabel("Distance x [m]")
        axes.set_ylabel("Time t [s]")
        seen = np.flatnonzero(np.isfinite(values).any(axis=0))
        if seen.size:
            axes.set_xlim(x[seen[0]], x[seen[-1] + 1])
        name = profiles.attrs.get("title", "").removeprefix("depth profiles of ")
        axes.set_title(title or f"{name}: {variable.replace('_', ' ')} over distance and time")
    return figure


def _edges(time: np.ndarray) -> np.ndarray:
    if len(time) == 1:
        return np.array([time[0] - 0.5, time[0] + 0.5])
    middle = 0.5 * (time[1:] + time[:-1])
    return np.concatenate([[time[0] - (middle[0] - time[0])], middle, [time[-1] + (time[-1] - middle[-1])]])


def snapshots(
    frames: Dump | Sequence[Frame] | Iterable[Frame],
    context: FlowContext,
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
    context : FlowContext
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
    x = x or seen_range(chosen, context)
    y = y or seen_heights(chosen, context, x)
    speeds = [_speed(frame) for frame in chosen]
    top_speed = top_speed or top_of(speeds)
    wide = (x[1] - x[0]) / (y[1] - y[0])
    columns = 1 if wide > 4.5 else 2 if wide > 1.6 else 5
    rows = -(-len(chosen) // columns)
    panel = 9.0 / columns
    pixels = int(1560 / columns)
    table = colour_table()
    with style():
        figure, grid = new_figure(
            9.6, min(rows * (panel / wide + 0.28) + 0.7, 24), rows, columns, sharex=True, sharey=True, squeeze=False
        )
        for axes in grid.flat[len(chosen) :]:
            axes.set_visible(False)
        for axes, frame, speed in zip(grid.flat, chosen, speeds, strict=False):
            view = View.fitted(x, y, pixels)
            picture = blank(view)
            paint_walls(picture, view, context.walls, context.shut_gates(context.time(frame)))
            paint_discs(picture, view, frame.x, frame.y, context.radius, coloured(speed, top_speed, table))
            axes.imshow(picture, extent=(*view.x, *view.y), interpolation="antialiased", aspect="equal")
            axes.grid(False)
            axes.set_title(f"t = {context.time(frame):.2f} s   {frame.n} discs", fontsize=8, pad=3)
            axes.tick_params(labelsize=7)
        for axes in grid[-1]:
            axes.set_xlabel("x [m]", fontsize=8)
        for axes in grid[:, 0]:
            axes.set_ylabel("y [m]", fontsize=8)
        bar = figure.colorbar(
            mpl.cm.ScalarMappable(mpl.colors.Normalize(0, top_speed), "cividis"),
            ax=grid, orientation="horizontal", fraction=0.02, aspect=60, pad=0.01,
        )  # fmt: skip
        bar.set_label("Speed [m/s]")
        bar.outline.set_visible(False)
        figure.suptitle(title or context.name, x=0.01, ha="left", fontsize=10)
    return figure


def _speed(frame: Frame) -> np.ndarray:
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


def seen_range(frames: Sequence[Frame], context: FlowContext) -> Interval:
    """The studied stretch, cut short where the frames hold neither a disc nor a block, m."""
    low, high = context.x_range
    parts = [frame.x[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    ends = [float(np.quantile(part, q)) for part in parts if part.size for q in (0.0, 0.999)]
    ends += [end for wall in context.walls if isinstance(wall, (Block, Box)) for end in wall.x if low < end < high]
    if not ends:
        return low, high
    margin = 0.02 * (max(ends) - min(ends)) + 2 * context.diameter
    return max(low, min(ends) - margin), min(high, max(ends) + margin)


def seen_heights(frames: Sequence[Frame], context: FlowContext, x: Interval) -> Interval:
    """Heights worth showing, m: from just below the floor to just above nearly all discs within x."""
    floors = context.bed_height(np.linspace(*x, 200))
    floors = floors[np.isfinite(floors)]
    low = float(np.min(floors)) if floors.size else context.domain[1][0]
    heights = [frame.y[(frame.x >= x[0]) & (frame.x <= x[1])] for frame in frames]
    tops = [float(np.quantile(part, 0.995)) for part in heights if part.size]
    top = max([*tops, low + 5 * context.diameter])
    for wall in context.walls:
        if isinstance(wall, (Block, Box)) and wall.x[1] > x[0] and wall.x[0] < x[1]:
            top = max(top, wall.y[1])
    margin = 0.06 * (top - low) + context.diameter
    return low - margin, top + margin
