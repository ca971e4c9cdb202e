# SPDX-License-Identifier: GPL-2.0-or-later
"""Front of a column on pages, in tables and figures of a run."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, cast

import numpy as np

from lammps_jump.analysis.draw.chart import Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.headline import A_JUMP, against_water
from lammps_jump.analysis.report.page import Section, Table, Text, described, percent
from lammps_jump.analysis.verdicts.kinds import at, part
from lammps_jump.analysis.verdicts.water import has_front
from lammps_jump.physics import jump as waves
from lammps_jump.physics import measured
from lammps_jump.units import known, shown

from .front import ASPECT, Front, FrontHistory, FrontTracker, MartinMoyce, analyse, dimensionless, way


def tables(front: Front) -> Tables:
    """Front and column against time, m and m/s."""
    return {"front.csv": {name: value for name, value in vars(front.history).items() if isinstance(value, np.ndarray)}}


def figures(front: Front, gathered: Gathered) -> Drawings:
    """The front against time. Of water also the measurements of Martin & Moyce."""
    flow, history = gathered.flow, cast(FrontHistory, front.history)
    water = martin_moyce_chart(history, flow) if flow.water else None
    return {"front": front_chart(history, flow), "martin_moyce": water}


def section(front: Front) -> Section:
    """The numbers of the front. Those of water stand beside Ritter and Martin & Moyce."""
    if not known(front.position):
        return Section("Front", [Text(shown(front.reason), "warn")])
    rows: list[tuple[str, Any]] = []
    if known(front.column_base):
        size = " × ".join(shown(value, digits=3) for value in (front.column_base, front.column_depth))
        rows.append(("Column at the start, base × height [m]", size))
    rows += described(front, "position", "position_99", "column_height", "speed", "arrival_time")
    moyce, ritter = front.martin_moyce, front.ritter
    if moyce and ritter:
        until = f"Ritter's front, holds until t = {ritter.valid_until:z.2g} s: RMS difference"
        rows.append((until, percent(ritter.rms)))
    if moyce:
        rows += described(moyce, "aspect")
        keys = ("mean_bulk", "rms_bulk", "rms_99", "rms_height") if moyce.comparable else ()
        rows += [(label, percent(value)) for label, value in described(moyce, *keys)]
        rows += described(moyce, "slope", "slope_of_table")
    return Section("Front", [Table(rows), *([Text(front.reason, "warn")] if front.reason else [])])


def front_chart(history: FrontHistory, flow: Flow) -> Chart | None:
    """Front, column height and surface speed against time. Of water also Ritter's front while it holds."""
    if not np.isfinite(history.bulk).any():
        return None
    (base, depth), gravity, time = history.column, flow.gravity, history.time
    fronts = [Trace("bulk front", time, history.bulk), Trace("99 % of the discs", time, history.quantile, "second")]
    if flow.water and gravity > 0 and depth > 0 and flow.timed:
        limit = waves.ritter_wall_time(base, depth, gravity)
        t = np.linspace(0, max(min(limit, time.max()), 1e-9), 20)
        label = f"Ritter, until its wave meets the back wall (t = {limit:z.2g} s)"
        fronts.append(Trace(label, t, base + 2 * t * np.sqrt(gravity * depth), "theory"))
    speeds = (
        Trace("surface, mean", time, history.top_speed),
        Trace("tip (last 5 d)", time, history.tip_speed, "second"),
    )
    panels = (
        Panel("Distance from\nthe back wall [m]", fronts, height=1.5),
        Panel("Column at the\nback wall [m]", (Trace("column", time, history.height),), ylim=(0.0, None)),
        Panel("Velocity u [m/s]", speeds),
    )
    return Chart("front and column", flow.time_axis, panels)


def martin_moyce_chart(history: FrontHistory, flow: Flow) -> Chart | None:
    """Front and column height in Martin & Moyce's variables with their measurements beside them."""
    gravity, (base, depth) = flow.gravity, history.column
    if not (flow.timed and np.isfinite(history.bulk).any() and gravity > 0 and base > 0 and depth > 0):
        return None
    values, live = dimensionless(history, gravity), history.time >= 0
    if live.sum() < 2:
        return None
    ahead, same = way(flow, history, base), abs(depth / base - ASPECT) < 0.1
    fronts = [
        Trace("bulk front", values["T"][live], values["Z"][live]),
        Trace("99 % of the discs", values["T"][live], values["Z99"][live], "second"),
    ]
    columns = [Trace("column", values["tau"][live], values["h"][live])]
    for lines, table in ((fronts, measured.MARTIN_MOYCE_FRONT), (columns, measured.MARTIN_MOYCE_HEIGHT)):
        lines += (
            [Trace("Martin & Moyce 1952, n² = 2", np.array(table.x), np.array(table.y), "measured")] if same else []
        )
    free = ahead.length / base if ahead.blocked else inf
    top = max(5.0, 1.08 * min(free, 6))
    obstacle = {"first obstacle": free} if free < top else {}
    ends = (0.0, float(min(values["T"].max(), 5))), (0.0, float(min(values["tau"].max(), 5.5)))
    panels = (
        Panel("Z = front / a", fronts, "T = n t √(g/a)", obstacle, xlim=ends[0], ylim=(1.0, top)),
        Panel("h / H", columns, "τ = t √(g/a)", xlim=ends[1], ylim=(0.0, 1.05)),
    )
    return Chart(f"n² = H/a = {depth / base:z.3g}{'' if same else ': no measured curve'}", "", panels)


RITTER = "ritter.front_speed"
WATER = """\
Ritter        front of water in an endless reservoir, a + 2 √(g H) t, until its wave meets the back wall
T, Z, n²      n t √(g/a), front/a, H/a of the column of base a and height H at the start
dZ/dT         slope of the bulk front over T, from Martin & Moyce's table beside it where that has the same n²
"""
"""What its numbers mean where it is compared with water."""


def _goes(wanted: HeadlineNumber, summary: Mapping[str, Any]) -> bool:
    front = part(summary, "front")
    if wanted.key == "speed" and (wanted.other == RITTER) != against_water(front):
        return False
    return _is_shown(summary) and part(summary, "jump").get("verdict") not in A_JUMP


def _is_shown(summary: Mapping[str, Any]) -> bool:
    return "given" not in summary or has_front(summary)


def _time(summary: Mapping[str, Any]) -> dict[str, str]:
    time = at(summary, "front.time")
    return {"time": "the last frame" if time is None else f"{time:z.3g} s"}


QUANTITY = Quantity(
    name="front",
    title="Front of a collapse",
    result=Front,
    definitions="""\
bulk front    right edge of the last disc in x before the first gap of two diameters between neighbours' centres;
              without a back wall of the discs from the column's left edge on
99 % front    right edge that 99 % of the discs do not pass
column        top of the discs within one diameter of the back wall, up to the first vertical gap of two diameters
speed         straight line through the bulk front, from a tenth of the free path to the first obstacle
errors        none: one run cannot tell; repeat it from other starts
""",
    beside=WATER,
    collector=FrontTracker,
    analyse=analyse,
    files={"front.csv": "front and column against time"},
    captions={"front": "Front and column", "martin_moyce": "Against Martin & Moyce (1952)"},
    tables=tables,
    figures=figures,
    linked="front",
    section=section,
    headline=(
        HeadlineNumber("position", label="front after {time}"),
        HeadlineNumber("speed", "Ritter", RITTER, holds="of a wave of water on a dry, level bed without friction"),
        HeadlineNumber("speed"),
        HeadlineNumber(
            "martin_moyce.mean_bulk",
            "discs: −20 to 0 %",
            label="off Martin & Moyce’s water",
            scale=0.01,
            unit="%",
            result=MartinMoyce,
        ),
        HeadlineNumber("arrival_time", rank=115),
        HeadlineNumber("column_height", label="column at the back wall", rank=115),
        HeadlineNumber("position_99", rank=115),
    ),
    rank=90,
    is_shown=_goes,
    label_values=_time,
    shown=_is_shown,
    defined=lambda summary: WATER if against_water(part(summary, "front")) else "",
)
