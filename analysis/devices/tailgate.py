# SPDX-License-Identifier: GPL-2.0-or-later
"""Tailgates that hold a depth or a front: the height that each has reached, since when, and what it holds.

The height is that of the crest, y. The crest is steady where its height, averaged over a response, is within half a
diameter of the mean of the last quarter of its time. It has settled where what is held is at the target too: from then
on its mean over a response stays near, and its mean up to the end is the target within the 95 % interval. A crest that
is steady and holds something else has a height, no time of settling, and a reason.
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
from lammps_jump.analysis.quantity import HeadlineNumber, Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import STUDENT, Mean, mean_of
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import jump
from lammps_jump.physics.devices import GATE_LOOKS, Holding, gate_areas, gate_sees
from lammps_jump.scene import MovingWall
from lammps_jump.units import ROUND_OFF, Estimates, as_summary, estimate, known, number, shown

LAST = 0.25
"""Share of the time of holding, at the end, in which the height must be steady."""
LEAST = 8
"""Frames in it, at least."""
DEPTH_OFF = 0.02
"""Share of the depth by which a mean over a response may be off where it is held, and half of its interval at most."""
FRONT_OFF = 0.25
"""The same of a front, over the mean depth of the jump."""
FRONT_SLACK, DEPTH_SLACK = 1.0, 0.1
"""Diameters by which a mean may miss the target beyond its interval. A front is read between parts that are five
diameters long. One disc more in the stretch of a depth, ten diameters long, is a tenth of a diameter."""
FROZEN = "it is the same in all of the last frames: the discs stand still"
AT_END = 1e-3
"""Share of its way within which a gate is at an end of it."""


@dataclass(frozen=True)
class Tailgate(Estimates):
    """The height that one gate has reached; absent numbers were not measured, and `reason` says why."""

    height: float = estimate(
        "m",
        "height y of the crest, mean since it settled, else of the last quarter; NaN where it does not stand",
        label="crest at",
        interval="± of the height, 95 % from the swings of one run",
    )
    settled_at: float = number(
        "s", "time from which on the crest stands and what it holds is at the target", default=nan
    )
    at_limit: bool = False
    holds: str = "depth"
    """Quantity that it holds: `depth` or `front`."""
    target: float = number("m", "asked for: mass depth, or place x of the front", default=nan)
    held: float = estimate(
        "m",
        "mean of what it holds, since it settled, else of the last quarter",
        interval="± of that, 95 % from the swings of one run",
    )
    water: float = number(
        "m", "height y of a broad crest that water would need, by energy without loss: E - 1.5 yc", default=nan
    )
    last_height: float = number("m", "height y of the crest at the end", default=nan)
    reason: str | None = None
    """Why it has not settled."""
    no_interval: str | None = None
    """Why what it holds has no interval."""
    no_water: str | None = None
    """Why there is no crest of water."""
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


class Record(NamedTuple):
    """Record of one gate by frames: time (s), height of its crest (m), what it sees (m), its end reached (-1, 0, 1)."""

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
    """Results of the gates; None where a scene has none."""
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
    water, no_water = _crest_of_water(flow, one, holding)
    common: dict[str, Any] = {
        "target": holding.target, "holds": "front" if holding.level else "depth", "table": table,
        "water": water, "no_water": no_water or None,
    }  # fmt: skip
    if len(time) < LEAST / LAST:
        return Tailgate(**common, reason=f"{len(time)} frames show it since {begin:z.3g} s")
    late = int(np.flatnonzero(time >= time[-1] - LAST * (time[-1] - time[0]))[0])
    limit = bool((end[late:] != 0).mean() > 0.5)
    response = GATE_LOOKS * holding.every * scene.time_step
    late_change = _behind(np.abs(_smooth(time, height, response) - height[late:].mean()) > 0.5 * scene.diameter)
    near = _behind(np.abs(_smooth(time, seen, response) - holding.target) > _near(holding))
    slack = (FRONT_SLACK if holding.level else DEPTH_SLACK) * scene.diameter
    first = None if limit else _settled(holding, seen, late, max(late_change, near), slack)
    held = mean_of(seen[late if first is None else first :])
    common |= {
        "at_limit": limit, "held": held.value, "held_interval": _interval(held), "last_height": float(height[-1]),
        "no_interval": None if isfinite(_interval(held)) else FROZEN,
    }  # fmt: skip
    if limit or late_change > late:
        return Tailgate(**common, reason=_no_height(holding, limit, int(end[-1]), held))
    crest = mean_of(height[late if first is None else first :])
    common |= {"height": crest.value, "height_interval": _interval(crest)}
    if first is None:
        return Tailgate(**common, reason=_not_settled(holding, held, near > late))
    return Tailgate(**common, settled_at=float(time[first]))


def _behind(far: np.ndarray) -> int:
    """Index of the first frame after the last one that is far."""
    return int(np.flatnonzero(far)[-1]) + 1 if far.any() else 0


def _near(holding: Holding) -> float:
    """Allowed distance of what is held, m: as a mean over a response, and half of the interval of its mean."""
    return FRONT_OFF * holding.level if holding.level else DEPTH_OFF * holding.target


def _settled(holding: Holding, seen: np.ndarray, late: int, earliest: int, slack: float) -> int | None:
    """The first frame from which on what is held is at its target; None where it is not in the last quarter.

    From each frame between it and the last quarter, the mean up to the end is the target within its interval, or within
    `slack` (m).
    """
    if earliest > late:
        return None
    first = None
    for begin in range(late, earliest - 1, -1):
        mean = mean_of(seen[begin:])
        half = STUDENT * mean.error
        if not (half <= _near(holding) and abs(mean.value - holding.target) <= max(half, slack)):
            break
        first = begin
    return first


def _crest_of_water(flow: Flow, one: MovingWall, holding: Holding) -> tuple[float, str]:
    """Height y of the broad crest that holds the same with water, by energy without loss, m; or why there is none."""
    y1, u1 = flow.inflow_depth, flow.inflow_speed
    if not y1 or not u1:
        return nan, "the discharge is not known without an inflow of rows"
    face, (gx, _) = one.wall.extent[0][0], flow.scene.gravity
    place = holding.target if holding.level else 0.5 * (holding.low + holding.high)
    bed = flow.bed_height(np.array([place, face - flow.scene.diameter]))
    if gx or not abs(bed[1] - bed[0]) < 0.1 * flow.scene.diameter:  # a bed that is not there is NaN
        return nan, "the bed between the place and the gate is not level"
    discharge = abs(u1) * y1
    depth = jump.sequent_depth(abs(u1), y1, flow.gravity) if holding.level else holding.target
    return float(bed[1]) + jump.crest_holding_depth(depth, discharge, flow.gravity), ""


def _interval(mean: Mean) -> float:
    """Half of the 95 % interval, m; NaN where nothing swings: an error of 0 would be a flow that is frozen."""
    return STUDENT * mean.error if mean.error > ROUND_OFF * abs(mean.value) else nan


def _smooth(time: np.ndarray, height: np.ndarray, over: float) -> np.ndarray:
    """Mean over a time around each frame, less at the ends; shape (frames,)."""
    total = np.append(0.0, np.cumsum(height))
    first = np.searchsorted(time, time - 0.5 * over, side="left")
    last = np.searchsorted(time, time + 0.5 * over, side="right")
    return (total[last] - total[first]) / (last - first)


def _what(holding: Holding, held: Mean) -> str:
    """Quantity that a gate holds, and its target, in words."""
    seen = shown(held.value, "m", _interval(held))
    what = f"the front at x = {seen}" if holding.level else f"a mass depth of {seen}"
    return f"{what}, and {holding.target:zg} m is asked for"


def _no_height(holding: Holding, limit: bool, end: int, held: Mean) -> str:
    """Why a gate has reached no height."""
    what = _what(holding, held)
    if limit:
        side = "highest" if end >= 0 else "lowest"
        return f"it stands at the {side} end of its way, with {what}: widen range, or ask for another"
    return f"its height still changes, with {what}: run longer"


def _not_settled(holding: Holding, held: Mean, strays: bool) -> str:
    """Why a gate whose crest is steady has not settled."""
    what, near = _what(holding, held), _near(holding)
    if strays:
        return f"its crest stands, and what it holds still goes by more than {near:z.2g} m off: {what}; run longer"
    if not STUDENT * held.error <= near:
        return f"its crest stands, with {what}; that is known to no better than {near:z.2g} m: run longer"
    return f"its crest stands with {what}: run longer, or give a shorter response"


def summary(gates: Mapping[str, Tailgate]) -> dict[str, Any]:
    """As under ``tailgate`` in ``summary.json``: the gates by name."""
    return {name: as_summary(gate) for name, gate in gates.items()}


def _unsettled(name: str, gate: Tailgate) -> str:
    """A sentence on a gate that has not settled; empty of one that has."""
    lacks = "has not settled" if isfinite(gate.height) else "has found no height"
    return f"The gate {name} {lacks}: {gate.reason}." if gate.reason else ""


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
        guides = {"found": gate.height} if isfinite(gate.height) else {}
        panels += [
            Panel(f"Crest of {name},\ny [m]", [Trace("", time, gate.table["height"])], levels=guides),
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
        if gate.no_water:
            blocks.append(Text(f"There is no crest of water beside it: {gate.no_water}.", "warn"))
        if said := _unsettled(name, gate):
            blocks.append(Text(said, "warn"))
    return Section("Tailgate", blocks)


KEYS = ("height", "height_interval", "water", "settled_at", "target", "held", "held_interval", "last_height")


QUANTITY = Quantity(
    name="tailgate",
    kind="settled_at",
    title="Tailgates",
    result=Tailgate,
    definitions="""\
height        y of the crest where it stands: its mean over a response stays within half a diameter of that of the last
              quarter; mean since the gate settled, else of the last quarter, ± from the swings within this run
settled       from then on the crest stands, means over a response of what is held stay within 2 % of the depth, or
              (y1 + y2)/8 along x, of the target, and the mean up to the end is the target within its ±, or within d/10
              of a depth, d of a front
held          mass depth over ten diameters around the place, or x where the mass depth first comes to (y1 + y2)/2, y2
              after Bélanger; mean since the gate settled, else of the last quarter
water         y of the crest with water, by energy without loss over a broad crest: E - 1.5 yc, E of the depth that is
              asked for, or of y2 after Bélanger; discs need less
""",
    always=lambda flow: any(one.motion.holding for one in flow.scene.walls),
    collector=GateWatch,
    analyse=analyse,
    files={"tailgate.csv": "height of a tailgate and what it holds, against time"},
    captions={"tailgate": "Tailgate"},
    tables=tables,
    figures=figures,
    section=section,
    summary=summary,
    headline=(
        HeadlineNumber("*.height", "water, by energy", "*.water", "crest of {name}, y", plain=True),
        HeadlineNumber("*.held", "asked", "*.target", "{name} holds", plain=True),
    ),
    rank=5,
    structures=lambda _, summary: {
        name: "" for name, one in part(summary, "tailgate").items() if isinstance(one, Mapping)
    },
    named=Named("tailgate", "give a wall of the case the motion hold", "tailgates", "<wall>"),
)
