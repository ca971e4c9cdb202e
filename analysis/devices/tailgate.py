# SPDX-License-Identifier: GPL-2.0-or-later
"""Tailgates that hold a depth or a front: the height that each has found, since when, and what it holds.

The height is that of the crest, y. The gate has settled when its height, averaged over a response, stays within half a
diameter of the mean up to the end, for a quarter of its time at least, and what it holds is what the case asks for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import STUDENT, Mean, mean_of
from lammps_jump.dump.frame import Frame
from lammps_jump.physics.devices import GATE_LOOKS, Holding, gate_areas, gate_sees
from lammps_jump.scene import MovingWall
from lammps_jump.units import Estimates, as_summary, estimate, known, number

LAST = 0.25
"""Share of the time of holding, at the end, in which the height must stand."""
LEAST = 8
"""Frames in it, at least."""
DEPTH_OFF = 0.02
"""Share of the depth by which the mean depth may be off where it is held."""
FRONT_OFF = 0.25
"""The same of a front, over the mean depth of the jump."""
AT_END = 1e-3
"""Share of its way within which a gate stands at an end of it."""


@dataclass(frozen=True)
class Tailgate(Estimates):
    """The height that one gate has found; absent numbers were not measured, and `reason` says why."""

    height: float = estimate(
        "m",
        "height y of the crest, mean since it settled",
        label="crest at",
        interval="± of the height, 95 % from the swings of one run",
    )
    settled_at: float = number("s", "time from which on the height stands", default=nan)
    at_limit: bool = False
    target: float = number("m", "asked for: mass depth, or place x of the front", default=nan)
    held: float = estimate(
        "m", "mean of what it holds, since it settled", interval="± of that, 95 % from the swings of one run"
    )
    last_height: float = number("m", "height y of the crest at the end", default=nan)
    reason: str | None = None
    no_interval: str | None = None
    """Why what it holds has no interval."""
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


class Record(NamedTuple):
    """What frames show of one gate: time (s), height of its crest (m), what it sees (m), its end reached (-1, 0, 1)."""

    time: np.ndarray
    height: np.ndarray
    seen: np.ndarray
    end: np.ndarray


class GateWatch:
    """Collects the height of each gate and what it sees, frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self.gates = {one.wall.name: one for one in flow.scene.walls if one.motion.holding}
        self._rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in self.gates}

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        poses = self.flow.poses.at(time) if self.flow.poses and self.gates else {}
        for name, (wall, motion) in self.gates.items():
            if (pose := poses.get(name)) is None or (holding := motion.holding) is None:
                continue
            area = self.flow.relative_masses(frame) * self.flow.scene.diameter**2
            seen, _ = gate_sees(holding, gate_areas(holding, np.asarray(frame.x, float), area))
            near = AT_END * (holding.highest - holding.lowest)
            end = (pose.y >= holding.highest - near) - (pose.y <= holding.lowest + near)
            self._rows[name].append((time, wall.extent[1][1] + pose.y, seen, end))

    def result(self) -> dict[str, Record]:
        """The record of each gate."""
        return {name: Record(*np.array(rows).reshape(-1, 4).T) for name, rows in self._rows.items()}


def analyse(gathered: Gathered) -> dict[str, Tailgate] | None:
    """What each gate has found; None where a scene has none."""
    flow, records = gathered.flow, gathered.histories.get("tailgate", {})
    assert isinstance(records, dict)
    gates = {one.wall.name: one for one in flow.scene.walls if one.motion.holding}
    return {name: _found(flow, one, records[name]) for name, one in gates.items() if name in records} or None


def _found(flow: Flow, one: MovingWall, record: Record) -> Tailgate:
    holding, scene = one.motion.holding, flow.scene
    assert holding is not None
    begin = scene.time(holding.first)
    known = record.time >= begin - 0.5 * scene.time_step
    time, height, seen, end = (column[known] for column in record)
    table = {"time": record.time, "height": record.height, "seen": record.seen}
    if len(time) < LEAST / LAST:
        return Tailgate(target=holding.target, table=table, reason=f"{len(time)} frames show it since {begin:zg} s")
    last = time >= time[-1] - LAST * (time[-1] - time[0])
    limit = bool((end[last] != 0).mean() > 0.5)
    response = GATE_LOOKS * holding.every * scene.time_step
    smooth = _smooth(time, height, response)
    far = np.flatnonzero(np.abs(smooth - height[last].mean()) > 0.5 * scene.diameter)
    first = int(far[-1]) + 1 if far.size else 0
    found, held = mean_of(height[first:]) if first < len(time) else mean_of(height[last]), mean_of(seen[last])
    common: dict[str, Any] = {
        "at_limit": limit, "target": holding.target, "held": held.value, "held_interval": _interval(held),
        "last_height": float(height[-1]), "table": table,
        "no_interval": None if held.error else "it is the same in all of the last frames: the discs stand still",
    }  # fmt: skip
    stands = first < len(time) and bool(time[first] <= time[last][0])
    reason = _why_not(holding, limit, int(end[-1]), held.value, stands)
    if reason:
        return Tailgate(**common, reason=reason)
    common |= {"height": found.value, "height_interval": _interval(found)}
    return Tailgate(settled_at=float(time[first]), **common)


def _interval(mean: Mean) -> float:
    """Half of the 95 % interval, m; NaN where nothing swings: an error of 0 would be a flow that is frozen."""
    return STUDENT * mean.error if mean.error else nan


def _smooth(time: np.ndarray, height: np.ndarray, over: float) -> np.ndarray:
    """Mean over a time around each frame, less at the ends; shape (frames,)."""
    total = np.append(0.0, np.cumsum(height))
    first = np.searchsorted(time, time - 0.5 * over, side="left")
    last = np.searchsorted(time, time + 0.5 * over, side="right")
    return (total[last] - total[first]) / (last - first)


def _why_not(holding: Holding, limit: bool, end: int, held: float, stands: bool) -> str:
    """Why a gate has found no height; empty where it has."""
    what = f"the front at x = {held:z.3g} m" if holding.level else f"a mass depth of {held:z.3g} m"
    asked = f"{holding.target:zg} m is asked for"
    if limit:
        side = "highest" if end >= 0 else "lowest"
        return f"it stands at the {side} end of its way, with {what}, and {asked}: widen range, or ask for another"
    if not stands:
        return f"its height still changes, with {what}, and {asked}: run longer"
    off = abs(held - holding.target)
    if off > (FRONT_OFF * holding.level if holding.level else DEPTH_OFF * holding.target):
        return f"its height stands with {what}, and {asked}: run longer, or give a shorter response"
    return ""


def summary(gates: Mapping[str, Tailgate]) -> dict[str, Any]:
    """As under ``tailgate`` in ``summary.json``: the gates by name."""
    return {name: as_summary(gate) for name, gate in gates.items()}


def notes(gates: object) -> list[str]:
    """Sentences on the gates that have found no height."""
    found = gates if isinstance(gates, Mapping) else {}
    return [f"The gate {name} has found no height: {gate.reason}." for name, gate in found.items() if gate.reason]


def tables(gates: Mapping[str, Tailgate]) -> Tables:
    """Height of each crest and what the gate sees, m, against time."""
    columns: dict[str, np.ndarray] = {}
    for name, gate in gates.items():
        time, height, seen = (gate.table[key] for key in ("time", "height", "seen"))
        columns |= {"time": time, f"height_{name}": height, f"seen_{name}": seen}
    return {"tailgate.csv": columns} if len(columns.get("time", ())) else {}


def figures(gates: Mapping[str, Tailgate], _: Gathered) -> Drawings:
    """Height of each crest and what the gate holds, against time."""
    panels, since = [], None
    for name, gate in gates.items():
        time = gate.table["time"]
        if not len(time):
            continue
        found = {"found": gate.height} if isfinite(gate.height) else {}
        panels += [
            Panel(f"Crest of {name},\ny [m]", [Trace("", time, gate.table["height"])], levels=found),
            Panel("Front x or\nmass depth [m]", [Trace("", time, gate.table["seen"])], levels={"asked": gate.target}),
        ]
        since = (gate.settled_at, float(time[-1])) if isfinite(gate.settled_at) else since
    return {"tailgate": Chart("tailgate", TIME, tuple(panels), since)} if panels else {}


def section(gates: Mapping[str, Tailgate]) -> Section:
    """Height, time of settling and what is held, of each gate."""
    blocks: list[Table | Text] = []
    for name, gate in gates.items():
        keys: Sequence[str] = [key for key in KEYS if known(getattr(gate, key))]
        blocks.append(Table(described(gate, *keys), (f"Tailgate {name}", "")))
        if gate.no_interval:
            blocks.append(Text(f"What the gate {name} holds has no ±: {gate.no_interval}.", "warn"))
        if gate.reason:
            blocks.append(Text(f"The gate {name} has found no height: {gate.reason}.", "warn"))
    return Section("Tailgate", blocks)


KEYS = ("height", "height_interval", "settled_at", "target", "held", "held_interval", "last_height")


QUANTITY = Quantity(
    name="tailgate",
    title="Tailgates",
    result=Tailgate,
    definitions="""\
height        y of the crest; mean since it settled, ± from the swings within this run
settled       from then on the height, averaged over a response, stays within half a diameter of the mean of the last
              quarter; and what is held is off by 2 % of the depth, or (y1 + y2)/8 along x, at most
held          mass depth over ten diameters around the place, or x where the mass depth first comes to (y1 + y2)/2, y2
              after Bélanger; mean of the last quarter
""",
    always=lambda flow: any(one.motion.holding for one in flow.scene.walls),
    collector=GateWatch,
    analyse=analyse,
    files={"tailgate.csv": "height of a tailgate and what it holds, against time"},
    captions={"tailgate": "Tailgate"},
    tables=tables,
    figures=figures,
    section=section,
    notes=notes,
    summary=summary,
    named=Named("tailgate", "give a wall of the case the motion hold", "tailgates", "<wall>"),
)
