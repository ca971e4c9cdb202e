# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of a run while it goes on: the newest frame as a file, and in a window where there is a screen."""

from __future__ import annotations

import io
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from lammps_jump.analysis.draw.film import still
from lammps_jump.analysis.flow import from_scene
from lammps_jump.dump.tail import DumpTail
from lammps_jump.engines.result import Progress, ProgressCallback
from lammps_jump.errors import DumpError
from lammps_jump.files import MOST_TEXT, read_file
from lammps_jump.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SECONDS = 1.5
"""Time between pictures; one costs some hundredths of a second."""
PICTURE = "live.png"


class LiveView:
    """A progress callback that also draws; it hands every report on to `then`.

    Without a screen, or once the window is closed, only the file is drawn. Errors in drawing never end a run.

    Parameters
    ----------
    scene : Scene
    folder : Path
        The run folder; the dump must be text.
    then : callable
        The progress line.
    """

    def __init__(self, scene: Scene, folder: Path, then: ProgressCallback):
        place = folder.absolute()  # the working directory may change while the run goes on
        self.flow = from_scene(scene, folder=place)
        self.tail = DumpTail(place / "dump.lammpstrj")
        self.picture = place / PICTURE
        self.then = then
        self.shown = time.perf_counter()
        self.window, reason = _open_window(scene.name)
        if reason and not getattr(then, "quiet", False):
            print(
                f"note: {reason}: look at {folder / PICTURE}, which is drawn again as the run goes on", file=sys.stderr
            )

    def __call__(self, report: Progress) -> None:
        """Draw when it is time to."""
        self.then(report)
        if time.perf_counter() - self.shown < SECONDS:
            return
        self._draw(ended=False)
        self.shown = time.perf_counter()

    def finish(self) -> None:
        """Draw the last frame of the run."""
        self._draw(ended=True)

    def _draw(self, *, ended: bool) -> None:
        try:
            frame = self.tail.newest(ended=ended)
            if frame is None or not frame.n:
                return
            still(frame, self.flow, self.picture)
        except DumpError:
            return  # the frame is still being written; the next one is drawn
        try:
            if self.window is not None and not _show(self.window, self.picture):
                self.window = None
        except Exception:  # whatever becomes of the window, the run goes on
            self.window = None


def _open_window(title: str) -> tuple[Figure | None, str]:
    """A window, or None and the reason: no screen, no toolkit for one."""
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return None, "there is no screen"
    try:
        import matplotlib
        from matplotlib import pyplot as plt
        from matplotlib.backends.registry import BackendFilter, backend_registry

        backend = matplotlib.get_backend()  # the user's choice, else the first that works here
        if backend.lower() in backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE):  # type: ignore[no-untyped-call]
            return None, f"matplotlib has no toolkit for windows here (backend {backend})"
        plt.ion()
        window = plt.figure(title, figsize=(12, 5))
        window.add_axes((0, 0, 1, 1)).axis("off")
        return window, ""
    except Exception as error:  # toolkits fail in their own ways; the file is written all the same
        return None, f"no window can be opened ({error})"


def _show(window: Figure, picture: Path) -> bool:
    """Show the picture in place of the one before; False where the user has closed the window."""
    from matplotlib import pyplot as plt

    if plt.fignum_exists(window.number):
        window.axes[0].clear()
        window.axes[0].imshow(plt.imread(io.BytesIO(read_file(picture, MOST_TEXT)))).axes.axis("off")
        window.canvas.draw_idle()
        window.canvas.flush_events()
    return plt.fignum_exists(window.number)
