# SPDX-License-Identifier: GPL-2.0-or-later
"""Overtopping of structures: volume and discharge that go over each, depth on its crest, head before it.

A disc has gone over where its way from one frame to the next crosses the middle of the crest above the top of the
structure. Structures are bodies and the probed walls that end; a crest is the highest part of an outline.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of
from lammps_jump.analysis.quantity import Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import as_fields, known_mean, mean_of
from lammps_jump.dump.frame import Frame
from lammps_jump.physics.jump import critical_discharge
from lammps_jump.scene.walls import Wall
from lammps_jump.units import Estimates, as_summary, estimate, known, number

BEFORE, STRETCH = 2.0, 5.0
"""Place before a structure where the head is taken, in its heights, and length of the stretch, in diameters."""
FEWEST = 30
"""Discs from which on there is a discharge: fewer scatter by more than a fifth."""


@dataclass(frozen=True)
class Overtopping(Estimates):
    """Flow over one structure; volumes are by mass, towards `side`."""

    volume: float = number("m^2", "volume that has gone over it, by mass", default=nan)
    discs: int = number("", "discs that have gone over it", default=0)
    since: float = number("s", "discs go over since", default=nan)
    discharge: float = estimate("m^2/s", "mean discharge over it, of the window")
    depth: float = estimate("m", "mass depth over its crest, mean of the window")
    largest_depth: float = number("m", "largest mass depth over its crest", default=nan)
    head: float = estimate("m", "head over its crest, mean of the window")
    critical_discharge: float = number("m^2/s", "critical flow over a broad crest under this head", default=nan)
    discharge_ratio: float = number("", "discharge over that of critical flow", default=nan)
    crest: float = number("m", "height y of its crest, at the start", default=nan)
    side: str | None = None
    reason: str | None = None
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


def structures_of(flow: Flow) -> tuple[str, ...]:
    """Names of bodies and of probed walls that end and have discs outside."""
    scene = flow.scene
    return tuple(
        one.wall.name for one in scene.walls
        if one.wall.finite and not one.wall.hollow and (one.motion.free or one.wall.name in scene.probes)
    )  # fmt: skip


class CrestWatch:
    """Collector of what goes over each structure, frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self.rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in structures_of(flow)}
        self._before: tuple[np.ndarray, ...] | None = None

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        order = np.argsort(frame.ids)
        mass = np.asarray(self.flow.relative_masses(frame), float)
        now = frame.ids[order], frame.x[order], frame.y[order], mass[order], frame.vx[order]
        for wall in self.flow.walls_at(time):
            if wall.name in self.rows:
                self.rows[wall.name].append((time, *self._of(wall, now)))
        self._before = now

    def _of(self, wall: Wall, now: tuple[np.ndarray, ...]) -> tuple[float, ...]:
        """Masses and discs that went over to the right and to the left since the last frame, depth, heads, crest."""
        _, x, y, mass, vx = now
        d = self.flow.scene.diameter
        outline = np.concatenate(wall.outline((0.0, 0.0), (0.0, 0.0)))
        top = float(outline[:, 1].max())
        crest = outline[outline[:, 1] > top - 1e-6 * d, 0]
        middle, width = 0.5 * float(crest.min() + crest.max()), max(float(np.ptp(crest)), 2.0 * d)
        over = self._crossed(now, middle, top)
        here = (np.abs(x - middle) <= 0.5 * width) & (y > top)
        depth = float(mass[here].sum()) * d * d / width
        (low, high), (foot, _) = wall.extent
        away = BEFORE * (top - foot)
        heads = []
        for side, end in ((-1, low), (1, high)):
            near = (side * (x - end) > away) & (side * (x - end) < away + STRETCH * d)
            heads.append(self._head(y[near], vx[near], mass[near], top))
        return *over, depth, *heads, top

    def _crossed(self, now: tuple[np.ndarray, ...], middle: float, top: float) -> tuple[float, float, float]:
        """Relative mass that crossed a place above a height to the right, and to the left, and its discs."""
        if self._before is None:
            return 0.0, 0.0, 0.0
        ids, x, y, mass = now[:4]
        _, here, there = np.intersect1d(ids, self._before[0], assume_unique=True, return_indices=True)
        a, b = self._before[1][there] - middle, x[here] - middle
        crosses = (a < 0) != (b < 0)
        share = a[crosses] / (a[crosses] - b[crosses])
        height = self._before[2][there][crosses] * (1 - share) + y[here][crosses] * share
        above, moved = height > top, mass[here][crosses]
        right = b[crosses] >= 0
        return float(moved[above & right].sum()), float(moved[above & ~right].sum()), float(above.sum())

    def _head(self, y: np.ndarray, vx: np.ndarray, mass: np.ndarray, top: float) -> float:
        """Head over a crest of a stretch of discs, m: of the edges of the highest discs, and of the mean velocity."""
        if len(y) < STRETCH or not self.flow.g:
            return nan
        level = float(np.sort(y)[-max(2, int(STRETCH) // 2)]) + self.flow.scene.radius
        u = float(np.average(vx, weights=mass))
        return level - top + u * u / (2.0 * self.flow.g)

    def result(self) -> dict[str, np.ndarray]:
        """Rows of each structure, shape (frames, 8)."""
        return {name: np.array(rows).reshape(-1, 8) for name, rows in self.rows.items()}


def analyse(gathered: Gathered) -> dict[str, Overtopping] | None:
    """Overtopping of each structure; None where there is none."""
    rows = gathered.histories.get("overtopping") or {}
    return {name: _found(gathered, one) for name, one in rows.items()} or None


def _found(gathered: Gathered, rows: np.ndarray) -> Overtopping:
    """Overtopping by the rows of one structure."""
    flow, area = gathered.flow, gathered.flow.scene.diameter**2
    if len(rows) < 2:
        return Overtopping(reason="it is in fewer than two frames")
    time, right, left, discs, depth, head_left, head_right, crest = rows.T
    side = 1.0 if right.sum() >= left.sum() else -1.0
    gone = side * area * (right - left)
    count = int(discs.sum())
    table = {"time": time, "volume": np.cumsum(gone), "depth": depth, "head": head_left if side > 0 else head_right}
    if not count:
        return Overtopping(crest=float(crest[0]), reason="nothing has gone over it", table=table)
    low, high = window_of(gathered.profiles)
    inside = (time > low) & (time <= high + 1e-9)
    inside[0] = False
    steps = np.diff(time, prepend=time[0])
    numbers: dict[str, Any] = {}
    reason = None
    if discs[inside].sum() >= FEWEST:
        head = mean_of(table["head"][inside])
        numbers = as_fields(discharge=mean_of(gone[inside] / steps[inside]), depth=mean_of(depth[inside]), head=head)
        if head.value > 0:
            critical = critical_discharge(head.value, flow.g)
            numbers |= {"critical_discharge": critical, "discharge_ratio": numbers["discharge"] / critical}
    else:
        reason = f"fewer than {FEWEST} discs go over it in the window of the means, so that there is no discharge"
    return Overtopping(
        volume=float(gone.sum()), discs=count, since=float(time[np.flatnonzero(discs)[0]]), **numbers,
        largest_depth=float(depth.max()), crest=float(crest[0]), side="right" if side > 0 else "left", reason=reason,
        table=table,
    )  # fmt: skip


def summary(found: Mapping[str, Overtopping]) -> dict[str, object]:
    """Mapping as it stands under ``overtopping`` in ``summary.json``: the structures by name."""
    return {name: as_summary(one) for name, one in found.items()}


def tables(found: Mapping[str, Overtopping]) -> Tables:
    """Rows of all structures that discs have gone over, one after the other."""
    parts = [(name, one.table) for name, one in found.items() if one.discs]
    if not parts:
        return {}
    names = np.concatenate([np.full(len(table["time"]), name, dtype=object) for name, table in parts])
    columns = {key: np.concatenate([table[key] for _, table in parts]) for key in parts[0][1]}
    return {"overtopping.csv": {"time": columns.pop("time"), "name": names, **columns}}


def figures(found: Mapping[str, Overtopping], _: Gathered) -> Drawings:
    """Volume over each structure, and depth over its crest, against time."""
    shown = [(name, one.table) for name, one in found.items() if one.discs]
    if not shown:
        return {}
    looks = ("first", "second", "third", "sum")
    curves = {"volume": "Volume over\n[m²]", "depth": "Depth over the\ncrest [m]", "head": "Head over the\ncrest [m]"}
    panels = [
        Panel(label, [Trace(name, one["time"], one[key], looks[k % 4]) for k, (name, one) in enumerate(shown)])
        for key, label in curves.items()
        if any(np.isfinite(known_mean(one[key])) for _, one in shown)
    ]
    return {"overtopping": Chart("overtopping", TIME, panels)}


def section(found: Mapping[str, Overtopping]) -> Section:
    """Numbers of each structure that something has gone over."""
    blocks: list[Table | Text] = []
    for name, one in found.items():
        if not one.discs:
            continue
        keys = [key for key in KEYS if known(getattr(one, key))]
        blocks.append(Table(described(one, *keys), (f"Over {name}, to the {one.side}", "")))
        if one.reason:
            blocks.append(Text(f"Numbers are absent for {name}: {one.reason}.", "small"))
    return Section("Overtopping", blocks)


KEYS = (
    "volume", "discs", "since", "discharge", "discharge_error", "depth", "depth_error", "largest_depth", "head",
    "head_error", "critical_discharge", "discharge_ratio", "crest",
)  # fmt: skip

QUANTITY = Quantity(
    name="overtopping",
    title="Overtopping",
    result=Overtopping,
    definitions="""\
over          a disc whose way between two frames crosses the middle of the crest above its top; to the side to which
              more mass goes, less what comes back
volume        mass over the density of the discs; discharge: the same by time, mean of the window
depth         mass of the discs over the crest over its width (two diameters at least) and the density
head          of the upper edge of the second highest disc in five diameters, two heights before the structure, over the
              crest, with the velocity head of the mean velocity there
critical      flow over a broad crest without loss, (2/3)^(3/2) √g H^(3/2); discs lose energy and carry less
""",
    collector=CrestWatch,
    analyse=analyse,
    files={"overtopping.csv": "volume over structures, depth on their crests and head before them, against time"},
    captions={"overtopping": "Overtopping"},
    tables=tables,
    figures=figures,
    section=section,
    summary=summary,
    named=Named("structure", "name the wall in probes.forces, or give the case a body", "overtopped", "<structure>"),
)
