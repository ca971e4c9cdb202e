# SPDX-License-Identifier: GPL-2.0-or-later
"""Facts of a run for the player of a page, besides its frames: walls, what to show, and Bélanger's depth in time.

In Jupyter the player is a widget, by anywidget: the page of the player in a frame, which tells its time.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import ceil, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.analysis.draw.painter import disc_speeds, seen, top_of
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.profiles import bin_edges
from lammps_jump.dump.find import ForceHistory, forces_in, read_table
from lammps_jump.dump.walls import BodyHistory, read_bodies
from lammps_jump.errors import DumpError, SetupError
from lammps_jump.files import BODIES, text_of
from lammps_jump.physics.jump import sequent_depth
from lammps_jump.scene.motion import MovingWall, Pose
from lammps_jump.scene.walls import Interval, Wall, parts_of

from .frames import FramePacker
from .page import Picture, Player, Section, picture, picture_kind, render

STILL = "snapshots.png"
"""Stands in for the player where there is no script."""
TRACK, COLUMNS = "jump_track.csv", ("time", "position", "found", "mass_depth_1", "velocity_1")
AROUND = 1.0
"""The velocity of the front at an instant is its mean over so many seconds before and after."""

MOST_ROWS, FEWEST_ROWS = 12_000, 60
"""Rows of the records of forces that a page shows, of all walls, and of one where there are many walls."""
MEMBER_ROWS = 500_000
"""Discs times frames of a member, about 1 MB of the page of its study."""


def member_packer(flow: Flow, frames: int) -> FramePacker:
    """Packer that keeps every n-th of the frames of a member, so that they are at most about `MEMBER_ROWS` rows."""
    scene = flow.scene
    mean = (len(scene.positions) + scene.expected_discs) / 2  # in play, where their number grows evenly
    return FramePacker(flow, max(1, ceil(frames * mean / MEMBER_ROWS)))


def make_player(packer: FramePacker, folder: Path) -> Player | None:
    """The player of a run; None where no frame holds a disc.

    Parameters
    ----------
    packer : FramePacker
        Has been shown the frames.
    folder : Path
        With the tables and figures of the analysis.
    """
    player = pack_player(packer, folder)
    return player and player._replace(still=still_of(folder))


def pack_player(packer: FramePacker, folder: Path, forces: Mapping[str, ForceHistory] | None = None) -> Player | None:
    """The same without the picture, which need not be drawn yet; with forces by structure, else those of the folder."""
    packed = packer.result()
    if packed is None:
        return None
    header = packed.header | about_run(packer, folder)
    return Player(
        header | _with_forces(header, packer.flow, forces_in(folder) if forces is None else forces), packed.text
    )


def _with_forces(
    header: Mapping[str, Any], flow: Flow, forces: Mapping[str, ForceHistory]
) -> dict[str, list[dict[str, Any]]]:
    """Walls and gates of a header with the force of the discs on those of which there is a record, N/m against s.

    The record of a body is the one that all bodies have, where its forces are not requested.
    """
    known: dict[str, ForceHistory | BodyHistory] = {**_histories(flow), **forces}
    names = [shape["name"] for key in ("walls", "gates") for shape in header[key]]
    most = max(FEWEST_ROWS, MOST_ROWS // max(1, sum(name in known for name in names)))
    return {
        key: [
            shape | ({"force": _force_of(known[shape["name"]], most)} if shape["name"] in known else {})
            for shape in header[key]
        ]
        for key in ("walls", "gates")
    }


def _force_of(history: ForceHistory | BodyHistory, most: int) -> dict[str, Any]:
    """Force of a record in at most so many rows, each the mean of as many: its time (s) is their last one.

    ``each`` is how long a mean is, s, and ``taken`` of how many rows it is.
    """
    rows = len(history.time)
    taken = max(1, ceil(rows / most))
    ends = np.unique(np.append(np.arange(taken - 1, rows, taken), rows - 1))
    counts = np.diff(ends, prepend=-1)
    force: dict[str, Any] = {"time": history.time[ends]}
    for name in ("fx", "fy"):
        force[name] = np.diff(np.cumsum(getattr(history, name))[ends], prepend=0.0) / counts
    step = float(np.median(np.diff(history.time))) if rows > 1 else 0.0
    return {**force, "each": float(f"{step * taken:z.4g}"), "taken": taken}


def still_of(folder: Path, small: bytes = b"") -> Picture | None:
    """The picture of the discs among the figures of a folder, for a page; None where there is none; see `picture`."""
    still = folder / "figures" / STILL
    there = picture_kind(still) and not still.parent.is_symlink()
    return picture(still, "Ten equal times, discs coloured by speed", small) if there else None


def about_run(packer: FramePacker, folder: Path) -> dict[str, object]:
    """Facts of a run for a player besides its frames, see `make_player`; some frames hold discs."""
    flow, sample = packer.flow, packer.sample()
    x, y = seen(sample, flow)
    scene, edges, bodies = flow.scene, bin_edges(flow.x_range, flow.bin_width), _bodies(packer)
    return {
        "name": scene.name,
        "unit": "s" if flow.timed else "steps",
        "gravity": scene.gravity,
        "seen": (x, y),
        "fastest": top_of([disc_speeds(frame) for frame in sample], 0.1),
        "walls": [_shape(one, packer, (x, y)) | bodies.get(one.wall.name, {}) for one in scene.standing],
        "gates": [{**_shape(one, packer, (x, y)), "until": scene.time(one.motion.gone)} for one in scene.gates],
        "inlets": sorted({(row.x, np.sign(row.vx)) for row in scene.inlets}),
        "outlets": [(outlet.axis, outlet.at, outlet.side) for outlet in scene.outlets],
        "bins": {"low": edges[0], "width": flow.bin_width, "count": len(edges) - 1},
        "seam": scene.domain[0] if scene.periodic else None,
        "fixed": (scene.fixed.first, scene.fixed.last) if scene.fixed else None,
        "area": scene.mass / (scene.density * scene.radius**2),
        "density": scene.density,
        "bed": _lowest_bed(flow, x, y),
        "sequent": _sequent(flow, folder, packer.times),
    }


def _shape(one: MovingWall, packer: FramePacker, shown: tuple[Interval, Interval]) -> dict[str, Any]:
    """A wall where the case has it, m, twice as far as a view shows; where it moves, its pose at each time.

    ``outlines`` are closed polygons, ``lines`` open ones with the discs on their left.
    """
    wall, motion = one
    wide = ((low - (high - low), high + (high - low)) for low, high in shown)
    outlines, lines = ([np.round(part, 9) for part in parts] for parts in parts_of(wall, *wide))
    if isfinite(motion.gone) and not wall.finite:  # a gate is a sheet; what lies behind it stays in sight
        outlines, lines = [], _faces(wall, outlines)
    shape: dict[str, Any] = {"name": wall.name, "hollow": wall.hollow, "outlines": outlines, "lines": lines}
    if motion.kind is None:
        return shape
    pushed = packer.flow.poses.at if motion.is_state and packer.flow.poses else lambda time: {}
    steps = [(time, packer.flow.step_at(time)) for time in packer.times]
    poses = [pushed(time).get(wall.name) or motion.pose(step) or Pose() for time, step in steps]
    fine = int(3 - np.floor(np.log10(packer.q)))  # thousandths of a quantum of the discs
    ways = (np.round(way, places) for way, places in zip(np.array(poses).T, (fine, fine, 6), strict=True))
    return {**shape, "about": motion.about, **dict(zip(("x", "y", "angle"), ways, strict=True))}


def _bodies(packer: FramePacker) -> dict[str, dict[str, Any]]:
    """Of each body the mass, kg/m, and centre where the case has it, m; velocity and force, where they are known."""
    histories = _histories(packer.flow)
    bodies_of_page = {}
    for wall, motion in packer.flow.scene.bodies:
        if motion.free:
            known = _ways_of(histories[wall.name], packer.times) if wall.name in histories else {}
            bodies_of_page[wall.name] = {"body": {"mass": motion.free.mass, "centre": motion.free.centre, **known}}
    return bodies_of_page


def _histories(flow: Flow) -> dict[str, BodyHistory]:
    """Bodies against time. A file that is missing or damaged gives none: the page does without them."""
    try:
        return read_bodies(flow.poses.path.with_name(BODIES)) if flow.scene.bodies and flow.poses else {}
    except DumpError:
        return {}


def _ways_of(history: BodyHistory, times: Sequence[float]) -> dict[str, list[float | None]]:
    """Velocity, m/s, and force of the discs, N/m, of a body at each time; None outside the rows that tell them."""
    rows = history.time
    near = 1e-9 * float(np.abs(rows).max())  # the file has ten digits of a time
    inside = [rows[0] - near <= time <= rows[-1] + near for time in times]
    ways = {name: np.interp(times, rows, getattr(history, name)).tolist() for name in ("vx", "vy", "fx", "fy")}
    return {
        name: [float(f"{value:z.6g}") if known else None for value, known in zip(way, inside, strict=True)]
        for name, way in ways.items()
    }


def _faces(wall: Wall, outlines: list[np.ndarray]) -> list[np.ndarray]:
    """Edges of outlines on which the distance to a wall is 0, with the discs on their left, shape (2, 2) each, m."""
    edges = [edge for ring in outlines for edge in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    on = [edge for edge in edges if all(abs(float(wall.distance(*end))) < 1e-6 for end in edge)]
    return [np.array(edge[::-1]) for edge in on]  # an outline runs anticlockwise round a solid


def _lowest_bed(flow: Flow, x: Interval, y: Interval) -> float:
    """Height of the lowest floor along what is shown, m; the lower end of it where there is none."""
    heights = flow.bed_height(np.linspace(*x, 200))
    return float(np.nanmin(heights)) if np.isfinite(heights).any() else y[0]


def _sequent(flow: Flow, folder: Path, times: Sequence[float]) -> list[list[float] | None]:
    """Bélanger's line of each instant: from x to x (m), and depth (m); None where no jump was found.

    It belongs to mass depth and velocity before the front at that instant, seen from the front. It goes from the front
    to where the bed rises or the channel ends.
    """
    try:
        track = read_table(folder / TRACK)
        when, places, is_measured, depths, speeds = (track.numbers(name) for name in COLUMNS)
    except DumpError:  # no jump was looked for; or damaged: the page is whole without
        return [None] * len(times)
    found_at: list[tuple[int, float, float, float]] = []  # place among the times; of the front, its speed, depth
    for number, k in enumerate(int(np.argmin(np.abs(when - time))) for time in times):
        near = (np.abs(when - when[k]) <= AROUND) & np.isfinite(places)
        if flow.timed and is_measured[k] and near.sum() > 1 and depths[k] > 0:
            seen_from = speeds[k] - np.polyfit(when[near], places[near], 1)[0]
            found_at.append((number, places[k], seen_from, sequent_depth(abs(seen_from), depths[k], flow.g)))
    lines: list[list[float] | None] = [None] * len(times)
    if found_at:
        numbers, starts, seen_from, sequent = np.array(found_at).T
        rows = np.round(np.transpose([starts, _level_until(flow, starts, seen_from), sequent]), 6)
        for number, row in zip(numbers.astype(int).tolist(), rows.tolist(), strict=True):
            lines[number] = row
    return lines


def _level_until(flow: Flow, starts: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """End of the level bed, from each start in its direction, m."""
    low, high = flow.x_range
    x = np.linspace(starts, np.where(directions > 0, high, low), 400, axis=1)
    bed = flow.bed_height(x.ravel()).reshape(x.shape)
    level = np.abs(bed - bed[:, :1]) < 0.5 * flow.scene.diameter
    return np.where(level.all(axis=1), x[:, -1], x[np.arange(len(x)), level.argmin(axis=1)])


SCRIPT = Path(__file__).parent / "widget.js"


def widgets_are_there() -> bool:
    """Tells whether anywidget is installed."""
    return importlib.util.find_spec("anywidget") is not None


def is_running() -> bool:
    """Tells whether this program runs in a notebook: an IPython that has a kernel."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return hasattr(shell, "kernel")


def player_widget(player: Player, title: str) -> Any:
    """A widget that plays a run.

    Returns
    -------
    anywidget.AnyWidget
        ``time`` is the time that is shown, s; ``seek(time)`` goes to another one.

    Raises
    ------
    SetupError
        anywidget is not installed.
    """
    page = render("", [Section("", [player])], tab=title, embedded=True)
    return _widget_class()(title=title, page=page, time=float(player.header["times"][0]))


@lru_cache(maxsize=1)
def _widget_class() -> Any:
    """The class of the widget; anywidget defines its base."""
    try:
        anywidget, traitlets = (importlib.import_module(name) for name in ("anywidget", "traitlets"))
    except ImportError:
        raise SetupError(
            "the player in a notebook needs anywidget, which is not installed: pip install 'lammps-jump[notebook]'"
        ) from None

    class RunWidget(anywidget.AnyWidget):  # type: ignore[misc, name-defined]
        """A run that plays in a notebook."""

        _esm = text_of(SCRIPT)
        title = traitlets.Unicode().tag(sync=True)
        page = traitlets.Unicode().tag(sync=True)
        time = traitlets.Float().tag(sync=True)

        def seek(self, time: float) -> None:
            """Show another time, s."""
            self.send({"seek": float(time)})

    return RunWidget
