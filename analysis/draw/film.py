# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of discs as true circles coloured by speed, with force arrows: films, and ten at equal times.

The frame around the moving picture (axes, labels, colour bar) is drawn once with matplotlib; each frame then paints
its discs in software straight into it and goes to ffmpeg (mp4) or into Pillow (gif).
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from math import ceil, floor
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.image import AxesImage
from matplotlib.text import Annotation

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame, require_finite, ten_indices
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError, SetupError
from lammps_jump.files import open_to_write, whole, write_bytes, writes
from lammps_jump.scene.walls import Interval

from .arrows import ForceArrows, ScaleArrow
from .painter import View, blank, disc_speeds, paint_arrow, paint_frame, paint_walls, seen, top_of
from .style import STYLE, colour_bar, style

NO_FFMPEG = "the animation is a GIF file: MP4 files need ffmpeg, which pip install 'lammps-jump[movie]' brings"
"""Note to users where a GIF took the place of an MP4."""
CLOCK = 230
"""Pixels of time and count of discs."""
ABOVE, LEFT = 34, 62
"""Pixels above and left of the discs."""
SAMPLE = 12
"""Frames that are looked at to find the heights and the speeds worth showing."""


def animate(
    dump: Dump,
    flow: Flow,
    out: str | Path,
    *,
    fps: float = 20.0,
    arrows: ForceArrows | None = None,
    width: int = 1280,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a film of a dump.

    Parameters
    ----------
    dump : Dump
    flow : Flow
    out : str or Path
        Ends in ``.mp4`` (H.264, plays everywhere) or ``.gif``. Without ffmpeg a GIF of the same name takes the place
        of an MP4.
    fps : float
        Frames of the dump shown a second.
    arrows : ForceArrows, optional
        Forces that are drawn on the outlines of structures, interpolated to the time of the frame.
    width : int
        Pixels of the whole picture.
    progress : callable(done, all), optional

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    DumpError
        No frame, an ending other than mp4 and gif, a place that cannot be written.
    SetupError
        ffmpeg failed.
    """
    out, count = Path(out), dump.count()
    if out.suffix.lower() not in (".mp4", ".gif"):
        raise DumpError(f"{out}: an animation ends in .mp4 or .gif.")
    if not count:
        raise DumpError(f"{dump.path}: it holds no frame to show.")
    if out.suffix.lower() == ".mp4" and not has_ffmpeg():
        out = out.with_suffix(".gif")
    chosen = dump.select({round(i) for i in np.linspace(0, count - 1, SAMPLE)})
    sample = [require_finite(frame, dump.path) for frame in chosen]
    painter = _Painter(sample, flow, width, arrows)

    def pictures() -> Iterable[np.ndarray]:
        for done, frame in enumerate(dump, start=1):
            yield painter.paint(require_finite(frame, dump.path))
            if progress:
                progress(done, count)

    with writes(f"{out}: the animation"), whole(out) as part:
        if out.suffix.lower() == ".mp4":
            _mp4(pictures(), part, fps, painter.picture.shape)
        else:
            _gif(pictures(), part, fps)
    return out


def still(frame: Frame, flow: Flow, out: str | Path, *, width: int = 1280) -> Path:
    """One frame as the animation shows it, as a PNG: for watching a run where there is no screen.

    The file is replaced at once, so that a viewer never sees half a picture.
    """
    from PIL import Image

    picture = io.BytesIO()
    Image.fromarray(_Painter([frame], flow, width, None).paint(frame)).save(picture, format="PNG")
    with writes(f"{out}: the picture"):
        return write_bytes(Path(out), picture.getbuffer())


class _Painter:
    """Paints frames into copies of the picture around them: axes, labels and colour bar, in whole, even pixels."""

    def __init__(self, sample: Sequence[Frame], flow: Flow, width: int, arrows: ForceArrows | None):
        from matplotlib.font_manager import findfont
        from PIL import ImageFont

        self.flow = flow
        self.top_speed = top_of([disc_speeds(frame) for frame in sample])
        self.view, self.picture = _surroundings(*seen(sample, flow), width, self.top_speed, flow.title)
        self.inside = slice(ABOVE, ABOVE + self.view.height), slice(LEFT, LEFT + self.view.width)
        self.font = ImageFont.truetype(findfont("DejaVu Sans"), 16)
        self.arrows = arrows
        if arrows is not None:
            self._tell_scales(arrows)
        self.ground: tuple[object, np.ndarray] = None, self.picture

    def paint(self, frame: Frame) -> np.ndarray:
        """The picture of a frame, shape (height, width, 3), uint8."""
        view, time = self.view, self.flow.time(frame)
        walls, gates = self.flow.standing_at(time), self.flow.shut_gates(time)
        if self.ground[0] != (walls, gates):
            self.ground = (walls, gates), self.picture.copy()
            paint_walls(self.ground[1][self.inside], view, walls, gates)
        picture = self.ground[1].copy()
        paint_frame(picture[self.inside], view, frame, self.flow, self.top_speed)
        if self.arrows is not None:
            self.arrows.paint(picture[self.inside], view, time, walls)
        self._write(picture[9:29, LEFT : LEFT + CLOCK], f"{self.flow.clock(time)}   {self.flow.count(frame)} discs")
        return picture

    def _tell_scales(self, arrows: ForceArrows) -> None:
        """Write the scales of forces and pressure above the discs, right of the clock, as far as there is room."""
        at = float(LEFT + CLOCK)
        for scale in arrows.scales(self.view):
            long = scale.length * self.view.scale
            wide = round(8 + self.font.getlength(scale.text))
            if at + long + wide > LEFT + self.view.width:
                break
            paint_arrow(self.picture, (at, 20.0), (at + long, 20.0), 3.0, scale.colour)
            self._write(self.picture[9:29, round(at + long) + 8 :], scale.text)
            at += long + wide + 24

    def _write(self, strip: np.ndarray, text: str) -> None:
        from PIL import Image, ImageDraw

        image = Image.fromarray(strip)
        ImageDraw.Draw(image).text((0, 0), text, font=self.font, fill="#1a1a1a")
        strip[:] = image


def _surroundings(x: Interval, y: Interval, width: int, top_speed: float, name: str) -> tuple[View, np.ndarray]:
    """View of the discs, and axes, labels and colour bar around an empty place for them."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    right, below = 92, 46
    inner = width - LEFT - right
    view = View.fitted(x, y, inner)
    if view.height > 1000:  # tall scenes: narrow the picture rather than letting it grow out of every screen
        view = View.fitted(x, y, max(120, int(inner * 1000 / view.height)))
    bar_height = max(view.height, 120)
    wide, high = (size + size % 2 for size in (LEFT + view.width + right, ABOVE + bar_height + below))

    def place(start: float, bottom: float, width: float, height: float) -> tuple[float, float, float, float]:
        """Shares of the picture, of pixels from the left and from above."""
        return start / wide, 1 - bottom / high, width / wide, height / high

    with style():
        figure = Figure(figsize=(wide / 100, high / 100), dpi=100)
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes(place(LEFT, ABOVE + view.height, view.width, view.height))
        axes.set(xlim=view.x, ylim=view.y, xlabel="x [m]", ylabel="y [m]")
        axes.grid(False)
        bar_axes = figure.add_axes(place(LEFT + view.width + 16, ABOVE + bar_height, 14, bar_height))
        colour_bar(figure, ScalarMappable(Normalize(0, top_speed), "cividis"), "Speed [m/s]", cax=bar_axes)
        figure.text(1 - 8 / wide, 1 - 20 / high, name, ha="right", fontsize=9, color="#555555")
        canvas.draw()  # type: ignore[no-untyped-call]
    return view, np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]


def _mp4(pictures: Iterable[np.ndarray], out: Path, fps: float, shape: tuple[int, ...]) -> None:
    from imageio_ffmpeg import write_frames

    open_to_write(out).close()  # a place that cannot be written is reported before ffmpeg starts
    # yuv420p and the index in front: plays in every browser while loading
    options = ["-preset", "fast", "-crf", "20", "-movflags", "+faststart", "-f", "mp4"]
    try:
        film = write_frames(
            str(out), (shape[1], shape[0]), fps=fps, codec="libx264", quality=None, macro_block_size=2,
            ffmpeg_log_level="error", output_params=options,
        )  # fmt: skip
        with closing(film) as writer:
            writer.send(None)
            for picture in pictures:
                writer.send(picture)
    except (RuntimeError, OSError) as error:
        last = str(error).strip().splitlines()[-1:]
        raise SetupError(f"{out}: ffmpeg failed ({''.join(last)}).") from error


def has_ffmpeg() -> bool:
    """Tells whether MP4 files can be written."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return False
    return True


def _gif(pictures: Iterable[np.ndarray], out: Path, fps: float) -> None:
    from PIL import Image

    images = (Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE) for picture in pictures)
    first = next(images)
    # gif counts hundredths of a second, and browsers slow down below two
    duration = max(20, round(100 / fps) * 10)
    first.save(out, format="GIF", save_all=True, append_images=images, duration=duration, loop=0)


SIDE, GAP, RIGHT, TOP, HEAD, FOOT = 0.6, 0.22, 0.2, 0.24, 0.24, 1.04
"""Room for labels left of the pictures, between and right of them, above all, above each and below, inches."""
BAR = 0.52, 0.12
"""Bottom and height of the colour bar, inches."""


def snapshots(frames: Dump | Sequence[Frame], flow: Flow, arrows: ForceArrows | None = None) -> Figure:
    """Discs at ten equal times as true circles coloured by speed, walls in grey (the thesis' ten pictures).

    Shown is the studied stretch, as high as discs go. Colours end at the 99.5 % quantile of the speeds.

    Parameters
    ----------
    frames : Dump or sequence of Frame
        Of a Dump only the ten frames are parsed.
    flow : Flow
    arrows : ForceArrows, optional
        Forces that are drawn on the outlines of structures; their scale is at the top.
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
            walls = flow.standing_at(time)
            paint_walls(picture, view, walls, flow.shut_gates(time))
            paint_frame(picture, view, frame, flow, top_speed)
            if arrows is not None:
                arrows.paint(picture, view, time, walls)
            axes = figure.add_subplot(place)
            axes.add_image(RasterImage(picture, axes, view))
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
        if arrows is not None:
            _tell_scales(figure, arrows.scales(view), width / (x[1] - x[0]))
        figure.suptitle(flow.title, x=0.01, y=1 - 0.07 / high, ha="left", va="top", fontsize=10)
    return figure


def _tell_scales(figure: Figure, scales: Sequence[ScaleArrow], inches: float) -> None:
    """Draw arrows with their sizes at the right end of the top of a figure; `inches` are those of a metre."""
    wide, high = figure.get_size_inches()
    right = 1 - RIGHT / wide
    for scale in reversed(scales):
        colour = [part / 255 for part in scale.colour]
        text = figure.text(right, 1 - 0.14 / high, scale.text, ha="right", va="center", fontsize=8)
        end = right - (0.065 * len(scale.text) + 0.08) / wide
        start = end - scale.length * inches / wide
        look: dict[str, Any] = {"arrowstyle": "-|>", "color": colour, "lw": 2.0, "shrinkA": 0, "shrinkB": 0}
        ends: dict[str, Any] = {"xycoords": "figure fraction", "textcoords": "figure fraction", "arrowprops": look}
        figure.add_artist(Annotation("", (end, text.get_position()[1]), (start, text.get_position()[1]), **ends))
        right = start - 0.25 / wide


class RasterImage(AxesImage):
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
