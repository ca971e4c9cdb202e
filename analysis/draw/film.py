# SPDX-License-Identifier: GPL-2.0-or-later
"""Animated colour output: discs as true circles coloured by speed, force arrows on structures, simulated time.

The frame around the moving picture (axes, labels, colour bar) is drawn once with matplotlib; each frame then paints
its discs in software straight into it and goes to ffmpeg (mp4) or into Pillow (gif).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.frame import Frame
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError, SetupError
from lammps_jump.scene.walls import Interval

from .painter import View, colour_table, coloured, paint_arrow, paint_discs, paint_walls
from .snapshots import disc_speeds, seen_heights, seen_range, top_of
from .style import colour_bar, style

NO_FFMPEG = "the animation is a GIF file: MP4 files need ffmpeg, which pip install 'lammps-jump[movie]' brings"
"""What to tell users where a GIF took the place of an MP4."""
ARROW = (179, 38, 58)
SAMPLE = 12
"""Frames that are looked at to find the heights and the speeds worth showing."""


@dataclass(frozen=True)
class _Stage:
    """The picture around the moving part, and where that part goes."""

    picture: np.ndarray
    view: View
    top: int
    left: int
    clock: tuple[int, int]
    digits: dict[str, np.ndarray]
    table: np.ndarray
    top_speed: float


def animate(
    dump: Dump,
    flow: Flow,
    out: str | Path,
    *,
    fps: float = 20.0,
    forces: Mapping[str, ForceHistory] | None = None,
    x: Interval | None = None,
    y: Interval | None = None,
    width: int = 1280,
    top_speed: float | None = None,
    frames: Iterable[int] | None = None,
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
    forces : mapping of structure to ForceHistory, optional
        An arrow on each structure that has a wall of that name: the force, interpolated to the time of the frame.
    x, y : (float, float), optional
        What is shown, m; default the studied stretch, and as high as discs go.
    width : int
        Pixels of the whole picture.
    top_speed : float, optional
        m/s at the end of the colour scale; default from a sample of frames.
    frames : iterable of int, optional
        Indices of the frames to show; default all.
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
    out = Path(out)
    kind = out.suffix.lower()
    if kind not in (".mp4", ".gif"):
        raise DumpError(f"{out}: an animation ends in .mp4 or .gif.")
    if not (np.isfinite(fps) and 0 < fps <= 240):
        raise DumpError(f"fps = {fps}: it must be above 0 and at most 240.")
    if not 320 <= width <= 7680:
        raise DumpError(f"width = {width} pixels: it must be 320 … 7680.")
    indices = list(range(dump.count())) if frames is None else sorted(set(frames))
    if not indices or indices[-1] >= dump.count():
        raise DumpError(f"{dump.path}: no such frames to show; it has {dump.count()}.")
    sample = list(dump.select({indices[round(i)] for i in np.linspace(0, len(indices) - 1, SAMPLE)}))
    if kind == ".mp4" and not has_ffmpeg():
        kind, out = ".gif", out.with_suffix(".gif")
    painter = _Painter(_stage(sample, flow, x, y, width, top_speed), flow, forces or {})
    pictures = _counted((painter.paint(frame) for frame in dump.select(indices)), len(indices), progress)
    try:
        if kind == ".mp4":
            _mp4(pictures, out, fps, painter.stage.picture.shape)
        else:
            _gif(pictures, out, fps)
    except OSError as error:
        raise DumpError(f"{out}: the animation cannot be written ({error.strerror or error}).") from error
    return out


def still(frame: Frame, flow: Flow, out: str | Path, *, width: int = 1280, **view) -> Path:
    """One frame as the animation shows it, as a PNG: for watching a run where there is no screen.

    The file is replaced at once, so that a viewer never sees half a picture. Keywords: x, y, top_speed, forces.
    """
    from PIL import Image

    out = Path(out)
    forces = view.pop("forces", None) or {}
    stage = _stage([frame], flow, view.get("x"), view.get("y"), width, view.get("top_speed"))
    part = out.with_name(out.name + ".part")
    try:
        Image.fromarray(_Painter(stage, flow, forces).paint(frame)).save(part, format="PNG")
        part.replace(out)
    except OSError as error:
        raise DumpError(f"{out}: the picture cannot be written ({error.strerror or error}).") from error
    return out


def _counted(pictures, total, progress):
    for done, picture in enumerate(pictures, start=1):
        yield picture
        if progress:
            progress(done, total)


class _Painter:
    """Paints frames onto copies of the stage."""

    def __init__(self, stage: _Stage, flow: Flow, forces: Mapping[str, ForceHistory]):
        self.stage, self.flow = stage, flow
        self.forces = {}
        for name, history in forces.items():
            try:
                self.forces[name] = (_anchor(flow.scene.wall(name), stage.view), history)
            except KeyError:
                continue  # a force on something that is no wall of this scene
        biggest = max(
            (float(np.quantile(np.hypot(h.fx, h.fy), 0.995)) for _, h in self.forces.values() if len(h.time)),
            default=0.0,
        )
        # the largest force is a third of the picture's height long
        self.metres_per_newton = stage.view.height / stage.view.scale / 3.0 / biggest if biggest > 0 else 0.0
        self.grounds: dict[tuple, np.ndarray] = {}

    def paint(self, frame: Frame) -> np.ndarray:
        """The picture of a frame, shape (height, width, 3), uint8."""
        stage, view, time = self.stage, self.stage.view, self.flow.time(frame)
        picture = self._ground(self.flow.shut_gates(time)).copy()
        inner = picture[stage.top : stage.top + view.height, stage.left : stage.left + view.width]
        colours = coloured(disc_speeds(frame), stage.top_speed, stage.table)
        paint_discs(inner, view, frame.x, frame.y, self.flow.radii(frame), colours)
        for anchor, history in self.forces.values():
            if not len(history.time):
                continue
            fx, fy = (float(np.interp(time, history.time, part)) for part in (history.fx, history.fy))
            pixels = self.metres_per_newton * view.scale
            start = (float(view.column(anchor[0])), float(view.row(anchor[1])))
            end = (start[0] + fx * pixels, start[1] - fy * pixels)
            paint_arrow(inner, start, end, max(3.0, view.height / 90), ARROW)
        self._write(picture, f"t = {time:.2f} s   {frame.n} discs")
        return picture

    def _ground(self, gates) -> np.ndarray:
        if gates not in self.grounds:
            stage, view = self.stage, self.stage.view
            ground = stage.picture.copy()
            inner = ground[stage.top : stage.top + view.height, stage.left : stage.left + view.width]
            paint_walls(inner, view, self.flow.scene.walls, gates)
            self.grounds[gates] = ground
        return self.grounds[gates]

    def _write(self, picture: np.ndarray, text: str) -> None:
        row, column = self.stage.clock
        for letter in text:
            glyph = self.stage.digits[letter]
            height, width = glyph.shape[:2]
            if column + width > picture.shape[1]:
                return
            picture[row : row + height, column : column + width] = glyph
            column += width


def _anchor(wall, view: View) -> tuple[float, float]:
    """Where the arrow of a structure starts: its middle, of what is seen, m."""
    sides = zip(wall.extent, (view.x, view.y), strict=True)
    return tuple(float(np.mean(np.clip(side, *seen))) if side[0] < side[1] else side[0] for side, seen in sides)


def _stage(sample, flow, x, y, width, top_speed) -> _Stage:
    """Axes, labels and colour bar around an empty place for the discs; everything in whole, even pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    x = x or seen_range(sample, flow)
    y = y or seen_heights(sample, flow, x)
    top_speed = top_speed or top_of([disc_speeds(frame) for frame in sample])
    left, right, above, below = 62, 92, 34, 46
    inner = width - left - right
    view = View.fitted(x, y, inner)
    if view.height > 1000:  # tall scenes: narrow the picture rather than letting it grow out of every screen
        inner = max(120, int(inner * 1000 / view.height))
        view = View.fitted(x, y, inner)
    bar_height = max(view.height, 120)
    total_width, total_height = left + view.width + right, above + bar_height + below
    total_width, total_height = total_width + total_width % 2, total_height + total_height % 2
    dpi = 100

    def place(start: float, bottom: float, wide: float, high: float) -> tuple[float, float, float, float]:
        """Shares of the picture, of pixels from the left and from above."""
        return start / total_width, 1 - bottom / total_height, wide / total_width, high / total_height

    with style():
        figure = Figure(figsize=(total_width / dpi, total_height / dpi), dpi=dpi)
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes(place(left, above + view.height, view.width, view.height))
        axes.set(xlim=view.x, ylim=view.y, xlabel="x [m]", ylabel="y [m]")
        axes.grid(False)
        bar_axes = figure.add_axes(place(left + view.width + 16, above + bar_height, 14, bar_height))
        colour_bar(figure, ScalarMappable(Normalize(0, top_speed), "cividis"), "Speed [m/s]", cax=bar_axes)
        corner = 1 - 8 / total_width, 1 - 20 / total_height
        figure.text(*corner, flow.scene.name, ha="right", fontsize=9, color="#555555")
        canvas.draw()
        picture = np.asarray(canvas.buffer_rgba())[..., :3].copy()
    return _Stage(picture, view, above, left, (9, left), _glyphs(), colour_table(), top_speed)


def _glyphs() -> dict[str, np.ndarray]:
    """Letters of the clock as pictures of one height, drawn once."""
    from matplotlib import font_manager
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.truetype(font_manager.findfont("DejaVu Sans"), 16)
    pictures = {}
    for letter in "0123456789.-+e tsdicnaf=":
        width = round(font.getlength("0" if letter.isdigit() else letter))
        image = Image.new("RGB", (width, 20), "white")
        ImageDraw.Draw(image).text((0, 0), letter, font=font, fill="#1a1a1a")
        pictures[letter] = np.asarray(image)
    return pictures


def _mp4(pictures: Iterable[np.ndarray], out: Path, fps: float, shape: tuple[int, ...]) -> None:
    from imageio_ffmpeg import write_frames

    out.open("ab").close()  # a place that cannot be written is found before ffmpeg starts
    # yuv420p and the index in front: plays in every browser while loading
    options = ["-preset", "fast", "-crf", "20", "-movflags", "+faststart", "-f", "mp4"]
    try:
        writer = write_frames(
            str(out), (shape[1], shape[0]), fps=fps, codec="libx264", quality=None, macro_block_size=2,
            ffmpeg_log_level="error", output_params=options,
        )  # fmt: skip
        writer.send(None)
        try:
            for picture in pictures:
                writer.send(np.ascontiguousarray(picture))
        finally:
            writer.close()
    except (RuntimeError, OSError) as error:
        last = str(error).strip().splitlines()[-1:]
        raise SetupError(f"{out}: ffmpeg failed ({''.join(last)}).") from error


def has_ffmpeg() -> bool:
    """Whether MP4 files can be written."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return False
    return True


def _gif(pictures, out: Path, fps: float) -> None:
    from PIL import Image

    images = (Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE) for picture in pictures)
    first = next(images)
    # gif counts hundredths of a second, and browsers slow down below two
    duration = max(20, round(100 / fps) * 10)
    first.save(out, format="GIF", save_all=True, append_images=images, duration=duration, loop=0)
