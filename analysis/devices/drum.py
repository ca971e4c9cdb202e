# SPDX-License-Identifier: GPL-2.0-or-later
"""A drum that turns: the angle of the surface of its discs, the dynamic angle of repose.

In every frame a straight line is fitted to the top edges of the highest discs of strips one diameter wide, over the
middle half of the drum's width. Its ends, where discs climb the wall and pile up below, are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan, degrees, nan

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, described
from lammps_jump.analysis.statistics import as_fields, mean_of
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import devices
from lammps_jump.scene.scene import Scene
from lammps_jump.units import Estimates, estimate, known, number

MIDDLE = 0.5
"""Share of the drum's radius, to either side of its centre, over which the surface is fitted."""

PACKED = 0.82
"""Solid fraction of discs of several sizes that lie at random."""


@dataclass(frozen=True)
class Drum(Estimates):
    """Surface of the discs in a drum, mean of the window."""

    angle: float = estimate("degree", "angle of the surface, rising with the wall", label="surface angle")
    scatter: float = number("degree", "standard deviation of the angle from frame to frame", default=nan)
    froude: float = number("", "Froude number ω²R/g of the drum", default=nan)
    turns: float = number("", "turns of the drum in the window", default=nan)
    filling: float = number("", "share of the drum that discs fill, packed loosely", default=nan)
    reason: str | None = None
    time: np.ndarray | None = field(default=None, metadata={"summary": False})
    angles: np.ndarray | None = field(default=None, metadata={"summary": False})


def turning(scene: Scene) -> tuple[float, float, float, float] | None:
    """Centre (m), radius (m) and rate (rad/s) of the hollow wall that turns steadily; None where there is none."""
    for wall, motion in scene.walls:
        if motion.kind is None or not wall.hollow or motion.is_state:
            continue
        now, later = motion.pose(scene.steps - 1), motion.pose(scene.steps)
        rate = (later.angle - now.angle) / scene.time_step if now and later else 0.0
        if rate:
            (low, high), _ = wall.extent
            return motion.about[0], motion.about[1], 0.5 * (high - low), rate
    return None


def surface_slope(x: np.ndarray, top: np.ndarray, width: float) -> float:
    """Slope of the straight line through the highest top edges (m) in strips of x of this width, m; NaN for too few."""
    strip = np.floor(x / width).astype(int)
    order = np.lexsort((top, strip))
    highest = order[np.flatnonzero(np.diff(strip[order], append=strip.max(initial=0) + 1))]
    return float(np.polyfit(x[highest], top[highest], 1)[0]) if len(highest) >= 4 else nan


class SurfaceAngles:
    """Collects the angle of the surface frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow, self.drum = flow, turning(flow.scene)
        self._rows: list[tuple[float, float]] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        if self.drum is None:
            return
        x0, _, radius, rate = self.drum
        near = np.abs(frame.x - x0) <= MIDDLE * self.flow.fit_stretch * radius
        top = (frame.y + self.flow.radii(frame))[near]
        slope = surface_slope(frame.x[near] - x0, top, self.flow.scene.diameter)
        # a wall that turns counter-clockwise lifts the discs at the right
        self._rows.append((time, degrees(atan(slope)) * (1.0 if rate > 0 else -1.0)))

    def result(self) -> np.ndarray:
        """Times (s) and angles (degrees), shape (frames, 2)."""
        return np.array(self._rows, float).reshape(-1, 2)


def analyse(gathered: Gathered) -> Drum:
    """Surface angle of a drum; with a reason where the scene is none."""
    flow, scene = gathered.flow, gathered.flow.scene
    drum = turning(scene)
    if drum is None or scene.inlets or scene.outlets or flow.gravity <= 0:
        return Drum(reason="no hollow wall turns under gravity, without inflow and outflow")
    time, angles = gathered.histories["drum"].T
    window = window_of(gathered.profiles)
    inside = within(time, window) & np.isfinite(angles)
    if inside.sum() < 2:
        return Drum(reason="the window holds no frame with a surface", time=time, angles=angles)
    _, _, radius, rate = drum
    used = angles[inside]
    mean = mean_of(used)
    return Drum(
        **as_fields(angle=mean),
        scatter=float(used.std(ddof=1)),
        froude=devices.rotation_froude(rate, radius, flow.gravity),
        turns=abs(rate) * (window[1] - window[0]) / (2 * np.pi),
        filling=_filling(scene, radius),
        time=time,
        angles=angles,
    )


def _filling(scene: Scene, radius: float) -> float:
    """Share of the drum that the discs fill: their areas over `PACKED`, over that of the drum."""
    squares = scene.mass * len(scene.positions) / scene.density  # of the diameters
    return float(0.25 * squares / PACKED / radius**2)


def tables(drum: Drum) -> Tables:
    """Angle against time."""
    if drum.time is None or drum.angles is None:
        return {}
    return {"drum.csv": {"time": drum.time, "angle": drum.angles}}


def figures(drum: Drum, gathered: Gathered) -> Drawings:
    """Angle against time."""
    if drum.time is None or drum.angles is None:
        return {}
    panel = Panel("Angle of the\nsurface [degrees]", [Trace("", drum.time, drum.angles)])
    return {"drum": Chart("surface of the discs in the drum", TIME, [panel])}


def section(drum: Drum) -> Section:
    """The angle, and how fast the drum turns."""
    if not known(drum.angle):
        return Section("Drum", [])
    return Section("Drum", [Table(described(drum, "angle", "scatter", "froude", "turns"))])


QUANTITY = Quantity(
    name="drum",
    title="Drum",
    result=Drum,
    definitions="""\
angle         straight line through the top edges of the highest discs of strips one diameter wide, middle half of the
              drum; mean of the window; above 0 where the surface rises with the wall that lifts the discs
scatter       standard deviation of the angle from frame to frame;  Froude number: ω²R/g
""",
    collector=SurfaceAngles,
    analyse=analyse,
    files={"drum.csv": "angle of the surface in a drum against time"},
    captions={"drum": "Surface of the discs in the drum"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(HeadlineNumber("angle"), HeadlineNumber("scatter"), HeadlineNumber("froude")),
    rank=40,
)
