# SPDX-License-Identifier: GPL-2.0-or-later
"""A flow down a sloping stretch of bed as the bed sees it: turned until the bed is level and gravity leans.

A chute in upright gravity and a level bed in tilted gravity are one flow. Both are measured along and across the bed:
frames, walls and gravity of a chute are turned about the upper end of the stretch, and the same analysis follows.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import atan, cos, sin
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.budgets.head import EnergyFluxes
from lammps_jump.analysis.jump.found import TrackedJump
from lammps_jump.dump.contacts import ContactFile
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import Motion, MovingWall, Pose, WallAtStep
from lammps_jump.scene.walls import Wall

from .contacts import ContactCollector
from .flow import Flow
from .passes import Gathered, Watcher
from .profiles import Binner, add_means, bin_edges, running_rows

LEVEL = 0.05
"""Change of the bed's height from bin to bin below which it counts as level, in diameters; and of its change below
which its slope counts as constant."""
LEAST_BINS = 8


class BedStretch(NamedTuple):
    """A stretch of bed with one slope: its left end on the bed (m), its length along x (m), and its angle (rad).

    The angle is positive where the bed rises towards larger x.
    """

    x: float
    y: float
    length: float
    angle: float

    def place(self, along: np.ndarray | float) -> np.ndarray | float:
        """Place along x of a place along the bed, m."""
        return self.x + (along - self.x) * cos(self.angle)


LEVEL_BED = BedStretch(0.0, 0.0, 0.0, 0.0)


def sloping_stretch(flow: Flow) -> BedStretch | None:
    """The longest stretch of bed with one slope that is not level; None where there is none of eight bins."""
    edges = bin_edges(flow.x_range, flow.bin_width)
    bed = flow.mean_bed(edges)
    rise, least = np.diff(bed), LEVEL * flow.scene.diameter
    groups: list[list[int]] = []
    for gap, step in enumerate(rise):
        if not np.isfinite(step):
            continue
        if groups and groups[-1][-1] == gap - 1 and abs(step - rise[groups[-1]].mean()) < least:
            groups[-1].append(gap)
        else:
            groups.append([gap])
    steep = [group for group in groups if len(group) >= LEAST_BINS - 1 and abs(rise[group].mean()) >= least]
    if not steep:
        return None
    group = max(steep, key=len)
    # the outermost bins may hold a kink: their middles lie on the slope all the same
    slope = float(rise[group].mean()) / flow.bin_width
    first, last = 0.5 * (edges[group[0]] + edges[group[0] + 1]), 0.5 * (edges[group[-1] + 1] + edges[group[-1] + 2])
    return BedStretch(float(first), float(bed[group[0]]), float(last - first), atan(slope))


@dataclass(frozen=True)
class TurnedFlow(Flow):
    """A flow whose x runs along a stretch of its bed.

    Attributes
    ----------
    whole : Flow
        The flow as it is.
    stretch : BedStretch
    """

    whole: Flow | None = field(default=None, compare=False)
    stretch: BedStretch = LEVEL_BED

    def walls_at(self, time: float) -> tuple[Wall, ...]:
        """Walls that are there at a time (s), turned."""
        assert self.whole is not None
        return tuple(_turned_wall(wall, self.stretch) for wall in self.whole.walls_at(time))

    def bed_height(self, x: np.ndarray | float, time: float | None = None) -> np.ndarray:
        """Height of the bed, m: level along the stretch, NaN outside; upright walls, which lean here, are no bed."""
        x, (low, high) = np.asarray(x, float), self.x_range
        return np.where((x >= low) & (x <= high), self.stretch.y, np.nan)

    def turned(self, frame: Frame) -> Frame:
        """A frame of the flow as it is, turned."""
        a, x0, y0 = -self.stretch.angle, self.stretch.x, self.stretch.y
        c, s, columns = cos(a), sin(a), dict(frame.columns)
        dx, dy = frame.x - x0, frame.y - y0
        columns |= {"x": x0 + c * dx - s * dy, "y": y0 + s * dx + c * dy}
        columns |= {"vx": c * frame.vx - s * frame.vy, "vy": s * frame.vx + c * frame.vy}
        return make_frame(frame.step, frame.time, frame.box, columns)


class _TurnedForces:
    """Contact forces as the engine had them, turned by an angle, rad; in place of a `ContactFile`."""

    def __init__(self, written: ContactFile, angle: float):
        self.written, self.angle = written, angle

    def forces(self, *given: Any) -> tuple[np.ndarray, np.ndarray]:
        """As of the file, along and across the bed."""
        (fx, fy), c, s = self.written.forces(*given), cos(self.angle), sin(self.angle)
        return c * fx - s * fy, s * fx + c * fy


def turned_flow(flow: Flow, stretch: BedStretch) -> TurnedFlow:
    """The flow along a stretch of its bed."""
    (gx, gy), a = flow.scene.gravity, -stretch.angle
    gravity = cos(a) * gx - sin(a) * gy, sin(a) * gx + cos(a) * gy
    walls = (MovingWall(_turned_wall(wall, stretch), Motion(motion.gone)) for wall, motion in flow.scene.walls)
    scene = replace(flow.scene, gravity=gravity, walls=tuple(walls), stations=None, groups=())
    kept = {name: value for name, value in vars(flow).items() if name not in ("scene", "x_range")}
    kept["written"] = _TurnedForces(flow.written, a) if flow.written else None
    ends = stretch.x, stretch.x + stretch.length / cos(stretch.angle)
    return TurnedFlow(scene=scene, x_range=ends, **kept, whole=flow, stretch=stretch)


def _turned_wall(wall: Wall, stretch: BedStretch) -> WallAtStep:
    """A wall where it is, turned with the stretch."""
    a, (x0, y0) = -stretch.angle, stretch[:2]
    c, s = cos(a), sin(a)
    if isinstance(wall, WallAtStep):
        body, (px, py, angle), about, (u, v, turn) = wall.body, wall.pose, wall.about, wall.rate
    else:
        body, (px, py, angle), about, (u, v, turn) = wall, Pose(), (x0, y0), Pose()
    dx, dy = about[0] + px - x0, about[1] + py - y0
    pose = Pose(x0 + c * dx - s * dy - about[0], y0 + s * dx + c * dy - about[1], angle + a)
    return WallAtStep(body, pose, about, Pose(c * u - s * v, s * u + c * v, turn))


class AlongBed:
    """Collects what the analysis of a jump needs of a flow along a stretch of its bed.

    Parameters
    ----------
    flow : Flow
        As it is; its frames are turned here, once for all.
    stretch : BedStretch
    """

    def __init__(self, flow: Flow, stretch: BedStretch):
        self.flow = turned_flow(flow, stretch)
        edges = bin_edges(self.flow.x_range, self.flow.bin_width)
        self.contacts = ContactCollector(self.flow, edges) if flow.knows_contacts else None
        self.binner, self.fluxes = Binner(self.flow), EnergyFluxes(self.flow)

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame of the flow as it is."""
        turned, whole = self.flow.turned(frame), self.flow.whole
        assert whole is not None
        watchers: list[Watcher] = [*([self.contacts] if self.contacts else []), self.fluxes]
        for collector in watchers:
            collector.add(turned, time)
        intervals = running_rows(whole, frame).interval  # heights do not tell rows down a slope
        self.binner.add(turned, time, np.full(frame.n, intervals.mean() if len(intervals) else 0.0))

    def result(self) -> Gathered:
        """Numbers along the stretch."""
        contacts, profiles = self.contacts.result() if self.contacts else None, self.binner.result()
        try:
            profiles = add_means(profiles, self.flow.window)
        except DumpError:  # the pass over the whole flow says so
            profiles = add_means(profiles)
        return Gathered(self.flow, profiles, contacts, {"jump": self.fluxes.result()}, {})


TRACKED = ("toe", "end", "position", "reach_end", "compression")


def in_place(jump: TrackedJump, stretch: BedStretch) -> TrackedJump:
    """The same jump with its places along x; lengths, depths and velocities stay those along and across the bed."""

    def moved(result: object, names: tuple[str, ...]) -> dict[str, Any]:
        values = {name: getattr(result, name) for name in names}
        return {name: stretch.place(value) for name, value in values.items() if value is not None}

    track, stream, budget = jump.track, jump.stream, jump.budget
    if track is not None:
        track = replace(track, **moved(track, TRACKED))
    if stream is not None:
        stream = replace(stream, **moved(stream, ("start", "stop", "compression")))
    if budget is not None:
        budget = replace(budget, x=(float(stretch.place(budget.x[0])), float(stretch.place(budget.x[1]))))
    places = moved(jump, ("position", "toe", "end"))
    return replace(jump, track=track, stream=stream, budget=budget, **places)
