# SPDX-License-Identifier: GPL-2.0-or-later
"""Flow as the analysis sees it: the scene, where to look, and when."""

from __future__ import annotations

from collections.abc import Mapping
from ctypes import Array
from dataclasses import dataclass, field
from functools import cached_property
from math import hypot, isfinite
from pathlib import Path

import numpy as np

from lammps_jump.core.law import jump_law, laws_of
from lammps_jump.core.library import core, why_absent
from lammps_jump.dump.contacts import ContactFile
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.dump.walls import PoseFile
from lammps_jump.errors import DumpError
from lammps_jump.files import POSES
from lammps_jump.quoting import figure_text
from lammps_jump.scene.chains import AT_START, ENDLESS, X0, X1
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Interval, Wall, bed_height


@dataclass(frozen=True)
class Flow:
    """Scene of a run, or guessed for a bare dump, with what the analysis adds; made by `from_scene` or `from_dump`.

    Attributes
    ----------
    scene : Scene
        NaN in its coefficients means not known: a bare dump tells no stiffness and often no time step.
    x_range : (float, float)
        The stretch that profiles cover, m: from the inlet to the outlet, else as far as walls and discs go.
    bin_width : float
        Width of the profile bins, m.
    window : (float, float) or None
        Times over which means are taken, s; None: the second half of the frames.
    asked_window : bool
        The window is the case's own, and no default.
    inflow_depth, inflow_speed : float or None
        y1 (m) and Va (m/s) where discs flow in by rows; of an inflow against time means over the window, Va as the
        discharge over y1.
    notes : tuple of str
        What was guessed, in sentences.
    sized : bool
        Discs differ in size, and the frames tell each one's radius or type.
    diameters : mapping of int to float
        Diameter of each type, m, where a bare dump has types in place of radii.
    timed : bool
        Times are known. Step numbers replace them in a bare dump without; nothing is made of them.
    velocities : bool
        Velocities are in the frames, or follow from positions and times.
    water : bool
        The front of a column is to be compared with water's: Ritter, Martin & Moyce.
    written : ContactFile or None
        Contact forces of each frame as the engine had them; None: they are computed from the frame.
    poses : PoseFile or None
        Where the walls are that the discs push; without it they are where the case has them.
    heads_at : tuple of float
        Places along x between which to tell the head lost, m.
    layers : ((float, float) or None, float or None) or None
        Stretch of x and height of the layers over which profiles over y are made, m; None: those of the analysis.
    fit_stretch : float
        Factor on the stretches over which a flank, a surface in a drum or tail water is fitted; a budget of error
        changes it.
    """

    scene: Scene
    x_range: Interval
    bin_width: float
    window: tuple[float, float] | None = None
    asked_window: bool = False
    inflow_depth: float | None = None
    inflow_speed: float | None = None
    notes: tuple[str, ...] = ()
    sized: bool = False
    diameters: Mapping[int, float] = field(default_factory=dict)
    timed: bool = True
    velocities: bool = True
    water: bool = False
    written: ContactFile | None = field(default=None, repr=False, compare=False)
    poses: PoseFile | None = field(default=None, compare=False)
    layers: tuple[Interval | None, float | None] | None = None
    heads_at: tuple[float, ...] = ()
    fit_stretch: float = 1.0

    def count(self, frame: Frame) -> int:
        """Discs of a frame that move."""
        return frame.n - (self.scene.fixed.count if self.scene.fixed else 0)

    def radii(self, frame: Frame) -> np.ndarray:
        """Radius of each disc, m, shape (n,); one number seen n times where discs are equal. Not to be changed."""
        radii = radii_of(frame, self.diameters) if self.sized else self.scene.radius
        if radii is None:
            radii = 0.5 * self.scene.diameters(frame.ids)
        return np.broadcast_to(radii, frame.n)

    def relative_masses(self, frame: Frame) -> np.ndarray:
        """Mass of each disc over the nominal mass, shape (n,); 1 seen n times where discs are equal."""
        return (self.radii(frame) / self.scene.radius) ** 2 if self.sized else np.broadcast_to(1.0, frame.n)

    def by_mass(self, values: np.ndarray, frame: Frame) -> np.ndarray:
        """Values of the discs times their relative masses; the values themselves where discs are equal."""
        return values * self.relative_masses(frame) if self.sized else values

    def largest_radius(self, frame: Frame) -> float:
        """Largest radius of a frame or, where all are smaller, the nominal one, m."""
        return float(self.radii(frame).max(initial=self.scene.radius)) if self.sized else self.scene.radius

    @property
    def title(self) -> str:
        """Name of the scene, for figures."""
        return figure_text(self.scene.name)

    @property
    def g(self) -> float:
        """Magnitude of gravity, m/s^2."""
        return hypot(*self.scene.gravity)

    @property
    def gravity(self) -> float:
        """Gravity across the bed, towards it, m/s^2."""
        return -self.scene.gravity[1]

    @property
    def knows_contacts(self) -> bool:
        """Tells whether there are elastic energy and contact forces."""
        return not self.no_contacts

    @property
    def no_contacts(self) -> str:
        """Why there is no elastic energy and no contact force, in a few words; empty where there is."""
        if not isfinite(self.scene.coefficients.stiffness):
            return "the stiffness of the discs is not known"
        return "" if core() is not None else f"there is no compiled core ({why_absent()})"

    @property
    def time_step(self) -> float:
        """Time step, s; 0 where it is not known."""
        return self.scene.time_step if isfinite(self.scene.time_step) else 0.0

    @property
    def dashpots(self) -> tuple[float, float]:
        """Dashpots of a nominal pair and of a nominal disc at a wall, as the engine used them, N s/m.

        With unequal discs they go with the root of the effective mass: one damping ratio holds for every contact.
        """
        c = self.scene.coefficients
        return c.gamma_normal * 0.5 * c.mass, c.gamma_normal_wall * c.mass

    @cached_property
    def laws(self) -> Array[jump_law]:
        """Numbers of the law of two discs and, after it, of each wall of the scene, as the core has them."""
        scene = self.scene
        return laws_of(scene.law_numbers(), *(scene.law_numbers(wall.name) for wall, _ in scene.walls))

    def time(self, frame: Frame) -> float:
        """Simulated time of a frame, s: the file's own, else from the step, else the step number itself."""
        if self.timed and frame.time is not None:
            return frame.time
        return self.scene.time(frame.step) if self.time_step else float(frame.step)

    def clock(self, time: float, until: float | None = None) -> str:
        """A time or a span of times (s) in words, for figures; steps where there are no times."""
        if not self.timed:
            return f"step {time:z.0f}" if until is None else f"steps {time:z.0f} … {until:z.0f}"
        return f"t = {time:z.2f} s" if until is None else f"t = {time:zg} … {until:zg} s"

    @property
    def time_axis(self) -> str:
        """Label of an axis of times."""
        return "Time t [s]" if self.timed else "Step"

    def step_at(self, time: float) -> float:
        """Step of a time (s), with a fraction between steps; the time itself where it is a step number."""
        return round(time / self.time_step, 6) + self.scene.settle_steps if self.time_step else time

    def number_of(self, wall: Wall) -> int:
        """Number of a wall in the scene, from 0; -1 of one that is not in it."""
        return {one.wall.name: number for number, one in enumerate(self.scene.walls)}.get(wall.name, -1)

    def walls_at(self, time: float) -> tuple[Wall, ...]:
        """Walls that are there at a time (s), where they are; gates that are still shut among them."""
        pushed = (self.poses.at(time), self.poses.rates(time)) if self.poses else ()
        return self.scene.walls_at(self.step_at(time), *pushed)

    def standing_at(self, time: float) -> tuple[Wall, ...]:
        """Walls of `walls_at` that are never taken away."""
        gates = {wall.name for wall, _ in self.scene.gates}
        return tuple(wall for wall in self.walls_at(time) if wall.name not in gates)

    def shut_gates(self, time: float) -> tuple[Wall, ...]:
        """Gates that are still there at a time (s), where they are."""
        gates = {wall.name for wall, _ in self.scene.gates}
        return tuple(wall for wall in self.walls_at(time) if wall.name in gates)

    @cached_property
    def bed_moves(self) -> bool:
        """Tells whether a wall that counts as bed moves."""
        return any(motion.kind is not None and not motion.free for _, motion in self.scene.standing)

    def bed_walls(self, time: float | None = None) -> tuple[Wall, ...]:
        """Walls that count as bed: where they are at a time (s), else where the case has them."""
        if time is None or not self.bed_moves:
            return self.scene.permanent
        bodies = {wall.name for wall, _ in self.scene.bodies}
        return (*(wall for wall in self.standing_at(time) if wall.name not in bodies), *self.scene.beds)

    def bed_height(self, x: np.ndarray | float, time: float | None = None) -> np.ndarray:
        """Height y_b of the bed at x, m; NaN where nothing lies below.

        It is the highest top of the walls that stay, of those that solids below carry without a gap that a disc could
        pass, tried from the lowest underside up. A solid above such a gap (a sluice gate) is no bed.

        Parameters
        ----------
        x : array_like, m
        time : float, optional
            s; without it walls that move are where the case has them.

        Returns
        -------
        ndarray of x's shape, m
        """
        return bed_height(self.bed_walls(time), x, self.scene.smallest)

    def mean_bed(self, edges: np.ndarray, time: float | None = None) -> np.ndarray:
        """Mean height of the bed in each bin, m: exact for straight faces; NaN where any part has no bed.

        Parameters
        ----------
        edges : ndarray, shape (bins + 1,), m
        time : float, optional
            As of `bed_height`.

        Returns
        -------
        ndarray, shape (bins,), m
        """
        ends = np.concatenate([edges, *(_ends(wall) for wall in self.bed_walls(time))])
        cuts = np.unique(ends[(ends >= edges[0]) & (ends <= edges[-1])])
        middle, width = 0.5 * (cuts[1:] + cuts[:-1]), np.diff(cuts)
        # rounding of a bin edge must not borrow a sliver of the next step
        middle, width = middle[width > 1e-9 * self.scene.diameter], width[width > 1e-9 * self.scene.diameter]
        aside = width / np.sqrt(12.0)  # two Gauss points a piece
        height = 0.5 * (self.bed_height(middle - aside, time) + self.bed_height(middle + aside, time))
        index = np.clip(np.searchsorted(edges, middle, side="right") - 1, 0, len(edges) - 2)
        total = np.bincount(index, height * width, len(edges) - 1)
        return total / np.bincount(index, width, len(edges) - 1)


def _ends(wall: Wall) -> np.ndarray:
    """Ends of the faces of a wall along x, m."""
    codes, shape = wall.faces.codes, wall.faces.shape
    return shape[codes[:, AT_START] != ENDLESS][:, [X0, X1]].ravel()


def radii_of(frame: Frame, diameters: Mapping[int, float]) -> np.ndarray | None:
    """Radius of each disc, m, shape (n,), from the file or, where they are given, from the diameters of the types (m).

    None where neither tells; DumpError for a type without a diameter.
    """
    if not diameters:
        return frame.radii
    types = frame.column("type")
    radii = np.full(frame.n, np.nan)
    for kind, diameter in diameters.items():
        radii[types == kind] = 0.5 * diameter
    if np.isnan(radii).any():
        raise DumpError(
            f"step {frame.step}: a disc has type {types[np.isnan(radii)][0]:zg}; a diameter is given for "
            f"{', '.join(map(str, diameters))} only: give one for each type."
        )
    return radii


def from_scene(
    scene: Scene,
    *,
    bin_width: float | None = None,
    window: tuple[float, float] | None = None,
    x_range: Interval | None = None,
    inflow_depth: float | None = None,
    inflow_speed: float | None = None,
    water: bool = False,
    folder: Path | None = None,
) -> Flow:
    """Flow of a scene.

    Parameters
    ----------
    scene : Scene
    bin_width : float, optional
        m; default five diameters.
    window : (float, float), optional
        Times for means, s; default the last quarter of the run.
    x_range : (float, float), optional
        m; default from the inlet (else the left wall, else the domain) to the outlet (else the right wall …).
    inflow_depth, inflow_speed : float, optional
        y1, m, and Va, m/s; default from the inlet rows: the depth by mass that their discs carry, and the mean of their
        speeds. Of an inflow against time what its table has in the window.
    water : bool
        As of `Flow`.
    folder : Path, optional
        Run folder, whose ``walls.csv`` tells where the walls are that the discs push.
    """
    duration, asked_window = scene.time(scene.steps), window is not None
    frames = scene.steps // scene.output_steps + 2
    window = window or (0.75 * duration, duration)
    if scene.inlets and scene.hydrograph is not None:
        inflow_depth, discharge = scene.hydrograph.means(*window)
        inflow_speed = discharge / inflow_depth if inflow_depth else float(scene.hydrograph.speed(window[1]))
    if scene.inlets and inflow_depth is None:
        inflow_depth = sum(q / abs(row.vx) for q, row in zip(scene.discharges, scene.inlets, strict=True))
    if scene.inlets and inflow_speed is None:
        inflow_speed = float(np.mean([row.vx for row in scene.inlets]))
    return Flow(
        scene,
        x_range or _studied(scene),
        bin_width or 5 * scene.diameter,
        window,
        asked_window,
        inflow_depth,
        inflow_speed,
        sized=scene.sizes is not None,
        water=water,
        poses=PoseFile(folder / POSES, scene.lids, frames) if scene.lids and folder is not None else None,
    )


def _studied(scene: Scene) -> Interval:
    """From the inlet to the outlet, else from wall to wall, else the domain."""
    low, high = scene.domain[0]
    for wall in scene.permanent:
        start, end = wall.room("x")
        low, high = max(low, start), min(high, end)
    for outlet in scene.outlets:
        if outlet.axis == "x":
            low, high = (low, min(high, outlet.at)) if outlet.side == "above" else (max(low, outlet.at), high)
    eastward = [row.x for row in scene.inlets if row.vx > 0]
    westward = [row.x for row in scene.inlets if row.vx < 0]
    return max([low, *eastward]), min([high, *westward])


# --- frames of a periodic channel and of rough beds, as analyses look at them: the discs that move, and ---------------


def placed(frame: Frame, scene: Scene) -> Frame:
    """The frame with all discs inside a periodic channel: engines let them run on until their next list."""
    if scene.period is None or not frame.n:
        return frame
    low = scene.domain[0][0]
    x = low + (frame.x - low) % scene.period
    return make_frame(frame.step, frame.time, frame.box, {**frame.columns, "x": x})


def moving(frame: Frame, scene: Scene) -> Frame:
    """The frame without the fixed discs of rough beds."""
    if scene.fixed is None:
        return frame
    return _taken(frame, ~scene.fixed.holds(frame.ids))


def with_images(frame: Frame, scene: Scene) -> Frame:
    """The frame with images of the discs near the ends of a periodic channel, beyond the other end.

    Sums over a part of the channel are then whole at its ends. Ids of images are those of their discs.
    """
    if scene.period is None or not frame.n:
        return frame
    (low, high), d = scene.domain[0], scene.largest
    first, last = frame.x < low + d, frame.x > high - d
    parts = [_taken(frame, where).columns for where in (first, last)]
    shifted = [
        {**columns, "x": columns["x"] + way} for columns, way in zip(parts, (scene.period, -scene.period), strict=True)
    ]
    joined = {
        name: np.concatenate([values, *(part[name] for part in shifted)]) for name, values in frame.columns.items()
    }
    return make_frame(frame.step, frame.time, frame.box, joined)


def fixed_discs(frame: Frame, scene: Scene) -> Frame:
    """The fixed discs of a frame's scene alone, with images, at rest."""
    if scene.fixed is None:
        return _taken(frame, np.zeros(frame.n, bool))
    ids = np.arange(scene.fixed.first, scene.fixed.last + 1)
    x, y = scene.positions[ids - 1].T
    radius = 0.5 * scene.diameters(ids)
    columns = {"id": ids, "x": x, "y": y, "vx": 0 * x, "vy": 0 * x, "radius": radius}
    return with_images(make_frame(frame.step, frame.time, frame.box, columns), scene)


def _taken(frame: Frame, mask: np.ndarray) -> Frame:
    return make_frame(frame.step, frame.time, frame.box, {name: values[mask] for name, values in frame.columns.items()})
