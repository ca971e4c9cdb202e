# SPDX-License-Identifier: GPL-2.0-or-later
"""matplotlib's figures: their style, how charts and scenes are drawn with it, and how they are saved.

Every function returns a matplotlib ``Figure`` with its own Agg canvas: no global state, no screen. Colours are
cividis (readable in grey and for the colour-blind); lines differ in dash as well as in colour.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from threading import Thread
from typing import IO, TYPE_CHECKING, Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, PathPatch, Polygon
from matplotlib.path import Path as Way
from matplotlib.patheffects import withStroke

from lammps_jump.errors import DumpError
from lammps_jump.files import write_bytes
from lammps_jump.quoting import figure_text
from lammps_jump.scene.shapes import thin

from .chart import PLACE, Bars, Chart, Map, Panel, edges_of
from .drawing import BAND, DOTS, HEIGHTS, TEXT, Area, Arrow, Drawing, DrawnDiscs, Shape, Stroke

if TYPE_CHECKING:
    from PIL.Image import Image


STYLE: dict[str, Any] = {
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
    "pdf.fonttype": 42,  # journals refuse the default, Type 3
}
BLUE, GOLD, GREY, BLACK, RED = "#00306f", "#b08a00", "#8a8a8a", "#1a1a1a", "#b3263a"
DASHES = ("-", "--", ":", "-.")
WALL = "#c4c4c4"
LOOKS: dict[str, dict[str, Any]] = {
    "first": {"color": BLUE},
    "second": {"color": GOLD, "ls": "--"},
    "third": {"color": GREY, "ls": "-."},
    "sum": {"color": BLACK, "lw": 1.4},
    "theory": {"color": RED, "ls": (0, (5, 2)), "lw": 1.3},
    "fit": {"color": RED, "lw": 2.2, "alpha": 0.8},
    "measured": {"color": BLACK, "ls": "none", "marker": "o", "mfc": "white", "ms": 4},
    "faint": {"color": "#c9c9c9", "lw": 0.6},
    "dots": {"color": GREY, "ls": "none", "marker": ".", "ms": 2, "alpha": 0.5},
}
"""Settings by which matplotlib draws the looks of a `chart.Trace`."""


def style() -> AbstractContextManager[None]:
    """matplotlib settings of this package, for the time of a ``with`` block."""
    return mpl.rc_context(cast(Any, STYLE))


@contextmanager
def drawing(
    width: float = 7.2, height: float = 3.6, rows: int = 1, columns: int = 1, **subplots: Any
) -> Iterator[tuple[Any, ...]]:
    """A figure with its Agg canvas, and its axes, in this package's `style` for the time of a ``with`` block.

    Parameters
    ----------
    width, height : float
        Inches.
    rows, columns : int
        Grid of axes; further keywords go to ``Figure.subplots``.
    """
    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure, figure.subplots(rows, columns, **subplots)


def colour_bar(figure: Figure, colours: Any, label: str, **place: Any) -> Any:
    """Colour bar without a frame, of an image or map of colours; keywords go to ``Figure.colorbar``."""
    bar = figure.colorbar(colours, **place)
    bar.set_label(label)
    bar.outline.set_visible(False)
    return bar


def save(figure: Figure, path: str | Path, use_picture: Callable[[Image], None] | None = None) -> Path:
    """Write a figure; the format follows the ending of the name. DumpError where the place cannot be written.

    `use_picture` gets the picture of a PNG, in a thread of its own while it is packed.
    """
    path, drawn = Path(path), io.BytesIO()
    try:
        with style():
            if path.suffix == ".png":
                _draw_png(figure, drawn, use_picture)
            else:
                figure.savefig(drawn, format=path.suffix.removeprefix("."))
        return write_bytes(path, drawn.getbuffer())
    except (OSError, ValueError) as error:
        raise DumpError(f"{path}: the figure cannot be written ({error}).") from error


def _draw_png(figure: Figure, out: IO[bytes], use_picture: Callable[[Image], None] | None) -> None:
    """The picture of one drawing: ``savefig`` lays a figure out and draws it twice, which is most of its time."""
    from PIL.Image import fromarray

    before, dots = figure.get_dpi(), mpl.rcParams["savefig.dpi"]
    figure.set_dpi(dots)
    figure.canvas.draw()
    picture = fromarray(np.asarray(cast(Any, figure.canvas).buffer_rgba())).convert("RGB")
    figure.set_dpi(before)
    thread = Thread(target=use_picture, args=(picture,)) if use_picture else None
    if thread:
        thread.start()
    # level 3 packs a figure in two thirds of the time of zlib's default, for files no larger
    picture.save(out, format="PNG", dpi=(dots, dots), compress_level=3)
    if thread:
        thread.join()


def drawn(shown: Chart | Bars | Map) -> Figure:
    """The matplotlib figure of what is described."""
    if isinstance(shown, Chart):
        return _draw_chart(shown)
    return _draw_bars(shown) if isinstance(shown, Bars) else _draw_map(shown)


def _draw_chart(chart: Chart) -> Figure:
    count, has_other_axes = len(chart.panels), any(panel.x for panel in chart.panels)
    heights = [panel.height for panel in chart.panels]
    rows, columns = (1, count) if has_other_axes else (count, 1)
    shape: dict[str, Any] = {} if has_other_axes else {"height_ratios": heights, "sharex": True}
    size = (8.4, 3.8) if has_other_axes else (7.4, 1.2 + 2.5 * sum(heights) / max(heights))
    with drawing(*size, rows, columns, squeeze=False, **shape) as (figure, grid):
        for axes, panel in zip(grid.flat, chart.panels, strict=True):
            _draw_panel(axes, panel)
            if chart.window is not None:
                axes.axvspan(*chart.window, color="#eeeeee", zorder=0)
            axes.set_xlabel(panel.x or (chart.x if panel is chart.panels[-1] else ""))
        grid.flat[0].set_title(chart.heading)
    return figure


def _draw_panel(axes: Axes, panel: Panel) -> None:
    _draw_solids(axes, panel.solids)
    for line in panel.lines:
        look = LOOKS[line.look]
        axes.plot(line.x, line.y, label=line.label or None, **look)
        if line.error is not None and np.isfinite(line.error).any():
            band = line.y - 2 * line.error, line.y + 2 * line.error
            axes.fill_between(line.x, *band, color=look["color"], alpha=0.2, lw=0)
    aside: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8}
    for label, value in panel.levels.items():
        axes.axhline(value, color=RED, lw=1, ls=(0, (6, 2)), zorder=1)
        # apart from the label of a near one
        under = any(value < other < 1.2 * value for other in panel.levels.values())
        place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "color": RED, **aside}
        axes.annotate(label, (0, value), (3, -9 if under else 2), **place)
    for label, value in panel.marks.items():
        axes.axvline(value, color=GREY, lw=1, ls=":")
        axes.annotate(label, (value, 1), (3, -10), xycoords=("data", "axes fraction"), color=GREY, **aside)
    axes.set(ylabel=panel.y, xlim=panel.xlim, ylim=panel.ylim)
    low, high = axes.get_ylim()
    if low < 0 < high:
        axes.axhline(0, color=GREY, lw=0.8, zorder=0.9)
    if len([line for line in panel.lines if line.label]) > 1:
        axes.legend(frameon=True, edgecolor="none", framealpha=0.9)


def _draw_bars(bars: Bars) -> Figure:
    values, places = np.array(list(bars.rows.values())), np.arange(len(bars.rows))[::-1]
    with drawing(7.2, 1.0 + 0.3 * len(values)) as (figure, axes):
        axes.barh(places, values, color=[*[BLUE] * (len(values) - 1), BLACK], height=0.62)
        axes.axvline(0, color=BLACK, lw=0.8)
        span = max(np.abs(values).max(), 1.0)
        axes.set_xlim(-1.35 * span, 1.35 * span)
        for place, value in zip(places, values, strict=True):
            label, side = f"{value:+z.1f}".replace("-", "\N{MINUS SIGN}"), 1 if value >= 0 else -1
            axes.annotate(label, (value, place), (4 * side, 0), textcoords="offset points", fontsize=8, va="center",
                          ha="left" if side > 0 else "right")  # fmt: skip
        axes.set_yticks(places, bars.rows)
        axes.grid(axis="y", visible=False)
        axes.set(xlabel=bars.x, title=bars.heading)
    return figure


def _draw_map(shown: Map) -> Figure:
    values, x, y = shown.values, shown.x, edges_of(shown.y)
    wide, size, place = (x[-1] - x[0]) / (y[-1] - y[0]), (7.6, 4.2), {}
    if shown.to_scale:
        size = 8.4, float(np.clip(7.6 / wide + 1.7 if wide > 3 else 6.4 / wide + 0.8, 2.4, 9.0))
        place = {"orientation": "horizontal" if wide > 3 else "vertical", "aspect": 40}
    with drawing(*size) as (figure, axes):
        axes.grid(False)
        _draw_solids(axes, shown.solids)
        finite = values[np.isfinite(values)]
        off = 0.005 if shown.to_scale else 0.002  # fields have higher peaks than sums over bins
        low, high = (float(np.quantile(finite, q)) for q in (off, 1 - off)) if finite.size else (0.0, 1.0)
        low = min(low, 0.0) if shown.signed else 0.0
        image = axes.pcolormesh(x, y, values, vmin=low, vmax=max(high, 1e-12), rasterized=True)
        colour_bar(figure, image, shown.label, ax=axes, pad=0.02, **place)
        if finite.size and high > 0 and not shown.signed and not shown.to_scale and min(values.shape) > 1:
            axes.contour(
                0.5 * (x[1:] + x[:-1]), shown.y, np.nan_to_num(values), levels=high * np.array([0.25, 0.5, 0.75]),
                colors="white", linewidths=0.7,
            )  # fmt: skip
        for line in shown.lines:
            axes.plot(line.x, line.y, label=line.label, **LOOKS[line.look])
        if any(line.label for line in shown.lines):
            axes.legend(loc="upper right", labelcolor=BLACK, frameon=True, framealpha=0.9)
        seen = np.flatnonzero(np.isfinite(values).any(axis=0))
        if shown.to_scale:
            lowest = min([y[0], *(solid[:, 1].min() for solid in shown.solids)])
            axes.set(xlim=(x[0], x[-1]), ylim=(lowest, y[-1]), aspect="equal")
        elif seen.size:
            axes.set_xlim(x[seen[0]], x[seen[-1] + 1])
        axes.set(xlabel=PLACE, ylabel=shown.side, title=shown.heading)
    return figure


def _draw_solids(axes: Axes, solids: Sequence[np.ndarray]) -> None:
    from matplotlib.patches import Polygon

    for solid in solids:
        edge = WALL if thin(solid) else "none"
        axes.add_patch(Polygon(solid, facecolor=WALL, edgecolor=edge, linewidth=2.0, zorder=0.5))


LEFT, RIGHT, BELOW, ABOVE = 70, 20, 60, 44
"""Pixels around the axes."""
TONES = {"plain": BLACK, "blue": BLUE, "red": RED}
DISC, RIM, EDGE = "#a9c4e4", "#4f7cb3", "#464646"
AREAS: dict[str, dict[str, Any]] = {
    "domain": {"fc": "none", "ec": GREY, "ls": (0, (2, 3)), "lw": 1.0},
    "pour": {"fc": "none", "ec": BLUE, "ls": ":"},
    "ghost": {"fc": WALL, "ec": EDGE, "lw": 0.9, "ls": (0, (4, 2)), "alpha": 0.45},
    "solid": {"fc": WALL, "ec": EDGE, "lw": 1.1},
    "outside": {"fc": WALL, "ec": EDGE, "lw": 1.1},
}
STROKES: dict[str, dict[str, Any]] = {
    "sheet": {"color": EDGE, "lw": 2.4},
    "band": {"color": WALL, "lw": BAND * 72 / DOTS},
    "edge": {"color": EDGE, "lw": 1.6},
    "ghost": {"color": EDGE, "lw": 1.0, "ls": (0, (4, 2)), "alpha": 0.45},
    "outlet": {"color": BLACK, "ls": "-.", "lw": 1.0},
    "level": {"color": RED, "ls": (0, (5, 2)), "lw": 1.5},
    "leader": {"lw": 0.7},
    "mark": {"lw": 1.6},
}


def figure(drawing: Drawing) -> Figure:
    """The figure of a drawing whose labels are placed."""
    (wide, high), (x, y) = drawing.size, (drawing.x, drawing.y)
    size = wide + LEFT + RIGHT, high + ABOVE + BELOW
    with style():
        made = Figure(figsize=(size[0] / DOTS, size[1] / DOTS), dpi=DOTS)
        FigureCanvasAgg(made)
        axes = made.add_axes((LEFT / size[0], BELOW / size[1], wide / size[0], high / size[1]))
        axes.set(xlim=x, ylim=y, xlabel="x [m]", ylabel="y [m]")
        axes.grid(False)
        for shape in drawing.shapes:
            _draw(axes, shape)
        axes.set_title(figure_text(drawing.title), fontsize=11)
        axes.set_title(drawing.aside, fontsize=8.5, color="#555555", loc="right")
    return made


def _draw(axes: Axes, shape: Shape) -> None:
    over = HEIGHTS[shape.look]
    look: dict[str, Any]
    if isinstance(shape, Area):
        look = {**AREAS[shape.look], "zorder": over}
        if len(shape.rings) == 1:
            axes.add_patch(Polygon(shape.rings[0], **look))
        else:
            rings = (Way(np.vstack([ring, ring[:1]]), closed=True) for ring in shape.rings)
            axes.add_patch(PathPatch(Way.make_compound_path(*rings), **look))
    elif isinstance(shape, Stroke):
        look = {"color": TONES[shape.tone], **STROKES[shape.look], "zorder": over, "solid_joinstyle": "round"}
        axes.plot(*shape.points.T, scalex=False, scaley=False, **look)
    elif isinstance(shape, DrawnDiscs):
        look = {"fc": DISC, "ec": RIM, "lw": shape.rim, "zorder": over, "offset_transform": axes.transData}
        sizes, turned = shape.diameters, np.zeros(len(shape.diameters))
        axes.add_collection(EllipseCollection(sizes, sizes, turned, units="xy", offsets=shape.places, **look))
    elif isinstance(shape, Arrow):
        look = {"arrowstyle": "-|>", "mutation_scale": shape.head, "capstyle": "butt", "joinstyle": "miter"}
        look |= {"color": TONES[shape.tone], "lw": shape.width, "zorder": over}
        axes.add_patch(FancyArrowPatch(path=Way(shape.points), **look))
    else:
        halo = [withStroke(linewidth=2.5, foreground="white")]
        look = {"fontsize": TEXT, "path_effects": halo, "va": "bottom", "zorder": over, "color": TONES[shape.tone]}
        axes.text(shape.x, shape.y, figure_text(shape.text), **look)
