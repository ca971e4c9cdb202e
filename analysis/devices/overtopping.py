# SPDX-License-Identifier: GPL-2.0-or-later
"""Flow over structures and below gates: volume, discharge, depth on the crest, head before it, and closed forms.

A disc has gone over where its way from one frame to the next crosses the middle of the crest above the top of the
structure. Structures are bodies and the probed walls that end; a crest is the highest part of an outline. A gate is a
structure above a gap that a disc passes: what crosses there below its foot has gone below it.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of
from lammps_jump.analysis.quantity import HeadlineNumber, Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import as_fields, known_mean, mean_of
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.dump.frame import Frame
from lammps_jump.physics.jump import brink_depth, critical_depth, critical_discharge, gate_discharge
from lammps_jump.scene.walls import Wall
from lammps_jump.units import Estimates, as_summary, estimate, known, number

BEFORE, STRETCH = 2.0, 5.0
"""Place before a structure where the head is taken, in its heights, and length of the stretch, in diameters."""
BRINK = 2.0
"""Length of the end of a crest over which its depth is taken, in diameters."""
ROW = (
    "time", "right", "left", "discs", "depth", "brink_left", "brink_right", "head_left", "head_right", "crest",
    "below_right", "below_left", "below_discs", "opening",
)  # fmt: skip
"""Columns of a structure, a row a frame."""
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
    critical_depth: float = number("m", "critical depth of this discharge", default=nan)
    brink: float = estimate("m", "mass depth at the brink, the lower end of the crest")
    brink_ratio: float = number("", "depth at the brink over that of a free fall of water", default=nan)
    opening: float = number("m", "gap below it, at the start", default=nan)
    below: float = estimate("m^2/s", "mean discharge below it, of the window")
    below_head: float = estimate("m", "head before it over the bed, mean of the window")
    gate_discharge: float = number("m^2/s", "water under a gate of this opening and head", default=nan)
    gate_ratio: float = number("", "discharge below it over that of water", default=nan)
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
        foot = float(outline[:, 1].min())
        opening = foot - float(self.flow.bed_height(middle))
        is_gate = opening > self.flow.scene.smallest
        over, below = self._crossed(now, middle, top, np.inf), self._crossed(now, middle, -np.inf, foot)
        here = (np.abs(x - middle) <= 0.5 * width) & (y > top)
        depth = float(mass[here].sum()) * d * d / width
        brinks = [
            float(mass[here & (np.abs(x - end) <= BRINK * d)].sum()) * d / BRINK for end in (crest.min(), crest.max())
        ]
        (low, high), (lowest, _) = wall.extent
        away = BEFORE * (opening if is_gate else top - lowest)
        heads = []
        for side, end in ((-1, low), (1, high)):
            near = (side * (x - end) > away) & (side * (x - end) < away + STRETCH * d)
            heads.append(self._head(y[near], vx[near], mass[near], foot - opening if is_gate else top))
        return *over, depth, *brinks, *heads, top, *(below if is_gate else (0.0,) * 3), opening if is_gate else nan

    def _crossed(
        self, now: tuple[np.ndarray, ...], middle: float, low: float, high: float
    ) -> tuple[float, float, float]:
        """Relative mass that crossed a place between two heights to the right, and to the left, and its discs."""
        if self._before is None:
            return 0.0, 0.0, 0.0
        ids, x, y, mass = now[:4]
        _, here, there = np.intersect1d(ids, self._before[0], assume_unique=True, return_indices=True)
        a, b = self._before[1][there] - middle, x[here] - middle
        crosses = (a < 0) != (b < 0)
        share = a[crosses] / (a[crosses] - b[crosses])
        height = self._before[2][there][crosses] * (1 - share) + y[here][crosses] * share
        there, moved = (height > low) & (height < high), mass[here][crosses]
        right = b[crosses] >= 0
        return float(moved[there & right].sum()), float(moved[there & ~right].sum()), float(there.sum())

    def _head(self, y: np.ndarray, vx: np.ndarray, mass: np.ndarray, top: float) -> float:
        """Head over a crest of a stretch of discs, m: of the edges of the highest discs, and of the mean velocity."""
        if len(y) < STRETCH or not self.flow.g:
            return nan
        level = float(np.sort(y)[-max(2, int(STRETCH) // 2)]) + self.flow.scene.radius
        u = float(np.average(vx, weights=mass))
        return level - top + u * u / (2.0 * self.flow.g)

    def result(self) -> dict[str, np.ndarray]:
        """Rows of each structure, shape (frames, columns of `ROW`)."""
        return {name: np.array(rows).reshape(-1, len(ROW)) for name, rows in self.rows.items()}


def analyse(gathered: Gathered) -> dict[str, Overtopping] | None:
    """Overtopping of each structure; None where there is none."""
    rows = gathered.histories.get("overtopping") or {}
    return {name: _found(gathered, one) for name, one in rows.items()} or None


def _found(gathered: Gathered, rows: np.ndarray) -> Overtopping:
    """Overtopping by the rows of one structure."""
    flow, area = gathered.flow, gathered.flow.scene.diameter**2
    if len(rows) < 2:
        return Overtopping(reason="it is in fewer than two frames")
    row = dict(zip(ROW, rows.T, strict=True))
    over, below = row["right"] - row["left"], row["below_right"] - row["below_left"]
    side = 1.0 if (over + below).sum() >= 0 else -1.0
    time, count = row["time"], int(row["discs"].sum())
    table = {
        "time": time, "volume": np.cumsum(side * area * over), "depth": row["depth"],
        "brink": row["brink_right" if side > 0 else "brink_left"],
        "head": row["head_left" if side > 0 else "head_right"],
        "below": np.cumsum(side * area * below),
    }  # fmt: skip
    low, high = window_of(gathered.profiles)
    inside = (time > low) & (time <= high + 1e-9)
    inside[0] = False
    gate = _below(row, table, inside, flow.g)
    if not count:
        reason = None if gate else "nothing has gone over it"
        return Overtopping(
            crest=float(row["crest"][0]), side=SIDES[side] if gate else None, reason=reason, table=table, **gate
        )
    numbers, reason = _over(row, table, inside, flow.g), None
    if not numbers:
        reason = f"fewer than {FEWEST} discs go over it in the window of the means, so that there is no discharge"
    return Overtopping(
        volume=float(table["volume"][-1]), discs=count, since=float(time[np.flatnonzero(row["discs"])[0]]), **numbers,
        largest_depth=float(row["depth"].max()), crest=float(row["crest"][0]), side=SIDES[side], reason=reason,
        table=table, **gate,
    )  # fmt: skip


SIDES = {1.0: "right", -1.0: "left"}


def _over(
    row: Mapping[str, np.ndarray], table: Mapping[str, np.ndarray], inside: np.ndarray, gravity: float
) -> dict[str, Any]:
    """Numbers of the flow over a crest, of the rows inside the window; none of fewer than `FEWEST` discs."""
    if row["discs"][inside].sum() < FEWEST:
        return {}
    rate = mean_of((np.diff(table["volume"], prepend=0.0) / np.diff(row["time"], prepend=nan))[inside])
    head, brink, is_gate = mean_of(table["head"][inside]), mean_of(table["brink"][inside]), isfinite(row["opening"][0])
    numbers: dict[str, Any] = as_fields(discharge=rate, depth=mean_of(row["depth"][inside]), brink=brink)
    if gravity > 0 and rate.value > 0:
        critical = critical_depth(rate.value, gravity)
        numbers |= {"critical_depth": critical, "brink_ratio": brink.value / brink_depth(critical)}
    if is_gate:
        return numbers
    numbers |= as_fields(head=head)
    if head.value > 0:
        critical = critical_discharge(head.value, gravity)
        numbers |= {"critical_discharge": critical, "discharge_ratio": rate.value / critical}
    return numbers


def _below(
    row: Mapping[str, np.ndarray], table: Mapping[str, np.ndarray], inside: np.ndarray, gravity: float
) -> dict[str, Any]:
    """Numbers of the flow below a gate; none of what is no gate, or lets fewer than `FEWEST` discs pass."""
    opening = float(row["opening"][0])
    if not isfinite(opening) or row["below_discs"][inside].sum() < FEWEST:
        return {}
    rate = mean_of((np.diff(table["below"], prepend=0.0) / np.diff(row["time"], prepend=nan))[inside])
    head = mean_of(table["head"][inside])
    numbers: dict[str, Any] = {"opening": opening, **as_fields(below=rate, below_head=head)}
    water = gate_discharge(opening, head.value, gravity)
    return numbers | {"gate_discharge": water, "gate_ratio": rate.value / water if water > 0 else nan}


def summary(overtoppings: Mapping[str, Overtopping]) -> dict[str, object]:
    """Mapping as it is under ``overtopping`` in ``summary.json``: the structures by name."""
    return {name: as_summary(one) for name, one in overtoppings.items()}


def tables(overtoppings: Mapping[str, Overtopping]) -> Tables:
    """Rows of all structures that discs have gone over, one after the other."""
    parts = [(name, one.table) for name, one in overtoppings.items() if one.side]
    if not parts:
        return {}
    names = np.concatenate([np.full(len(table["time"]), name, dtype=object) for name, table in parts])
    columns = {key: np.concatenate([table[key] for _, table in parts]) for key in parts[0][1]}
    return {"overtopping.csv": {"time": columns.pop("time"), "name": names, **columns}}


def figures(overtoppings: Mapping[str, Overtopping], _: Gathered) -> Drawings:
    """Volume over each structure, and depth over its crest, against time."""
    shown = [(name, one.table) for name, one in overtoppings.items() if one.side]
    if not shown:
        return {}
    looks = ("first", "second", "third", "sum")
    gates = [np.any(one["below"]) for _, one in shown]
    head = "Head over the\ncrest [m]" if not any(gates) else "Head over the\nbed [m]" if all(gates) else "Head [m]"
    over = {} if all(gates) else {"volume": "Volume over\n[m²]", "depth": "Depth over the\ncrest [m]"}
    below = {"below": "Volume below\n[m²]"} if any(gates) else {}
    curves = {**over, **below, "head": head}
    panels = [
        Panel(label, [Trace(name, one["time"], one[key], looks[k % 4]) for k, (name, one) in enumerate(shown)])
        for key, label in curves.items()
        if any(np.isfinite(known_mean(one[key])) for _, one in shown)
    ]
    return {"overtopping": Chart("overtopping", TIME, panels)}


def section(overtoppings: Mapping[str, Overtopping]) -> Section:
    """Numbers of each structure that something has gone over."""
    blocks: list[Table | Text] = []
    for name, one in overtoppings.items():
        if not one.side:
            continue
        keys = [key for key in KEYS if known(getattr(one, key))]
        blocks.append(
            Table(described(one, *keys), (f"{'Over' if one.discs else 'Below'} {name}, to the {one.side}", ""))
        )
        if one.reason:
            blocks.append(Text(f"Numbers are absent for {name}: {one.reason}.", "small"))
    return Section("Overtopping", blocks)


KEYS = (
    "volume", "discs", "since", "discharge", "discharge_error", "depth", "depth_error", "largest_depth", "head",
    "head_error", "critical_discharge", "discharge_ratio", "critical_depth", "brink", "brink_error", "brink_ratio",
    "crest", "opening", "below", "below_error", "below_head", "below_head_error", "gate_discharge", "gate_ratio",
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
critical      flow over a broad crest without loss, (2/3)^(3/2) √g H^(3/2); discs lose energy and carry less. The
              critical depth of a discharge is (q²/g)^(1/3)
brink         depth over the last two diameters of the crest; of water that falls freely 0.715 critical depths
gate          a structure above a gap that a disc passes: its head is over the bed, two openings before it. Water has
              C a √(2 g (H − C a)) with C = 0.61, free behind the gate
""",
    collector=CrestWatch,
    analyse=analyse,
    files={"overtopping.csv": "volume over structures, depth on their crests and head before them, against time"},
    captions={"overtopping": "Overtopping"},
    tables=tables,
    figures=figures,
    section=section,
    summary=summary,
    headline=(
        HeadlineNumber("*.discharge", label="discharge over {name}"),
        HeadlineNumber("*.head", label="head over the crest of {name}"),
        HeadlineNumber("*.below", label="discharge below {name}"),
        HeadlineNumber("*.below_head", label="head before {name}, over the bed"),
    ),
    rank=95,
    structures=lambda key, found: {name: "" for name, one in part(found, "overtopping").items() if known(one.get(key))},
    named=Named("structure", "name the wall in probes.forces, or give the case a body", "overtopped", "<structure>"),
)
