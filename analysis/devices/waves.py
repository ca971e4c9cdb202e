# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves at gauges: depth against time at places along a tank, and the height of the waves that a paddle makes there.

The mean wave of a gauge is the mean of its depth over whole periods, at equal times within the period. Its crest less
its trough is the height: noise of single discs, which another period does not repeat, is averaged first.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan, pi
from typing import Any

import numpy as np

from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report import Block
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.physics import devices
from lammps_jump.units import known, number

PHASES = 20
"""Times within a period at which the mean wave is known."""


@dataclass(frozen=True)
class Waves:
    """Waves of a paddle at gauges; NaN where nothing oscillates or the window holds no whole period."""

    period: float = number("s", "period of the paddle", default=nan)
    periods: int = number("", "whole periods at the end of the window", default=0)
    height: float = number("m", "wave height at the first gauge", default=nan, label="wave height, first gauge")
    height_last: float = number("m", "wave height at the last gauge", default=nan, label="last gauge")
    height_piston: float = number("m", "height of small waves of this piston", default=nan)
    depth: float = number("m", "mean depth at the first gauge", default=nan)
    gauges: tuple[float, ...] = ()
    heights: tuple[float, ...] = ()
    depths: tuple[float, ...] = ()
    means: tuple[float, ...] = ()
    lowest: tuple[float, ...] = ()
    largest: tuple[float, ...] = ()
    reason: str | None = None
    time: np.ndarray | None = field(default=None, metadata={"summary": False})
    records: np.ndarray | None = field(default=None, metadata={"summary": False})


def mean_wave(time: np.ndarray, depth: np.ndarray, period: float, until: float, periods: int) -> np.ndarray:
    """Depth at `PHASES` times within a period (m), mean of so many whole periods before a time (s)."""
    at = until - period * (periods - np.arange(periods * PHASES) / PHASES)
    return np.interp(at, time, depth).reshape(periods, PHASES).mean(axis=0)


def paddle(flow: Flow) -> tuple[float, float, float]:
    """Period (s), stroke along x (m) and begin (s) of the wall that oscillates with the longest stroke; else NaN."""
    waves = [motion.kind.wave() for _, motion in flow.scene.walls if motion.kind is not None]
    moved = [wave for wave in waves if wave is not None and wave.rate[0] > 0]
    if not moved:
        return nan, nan, nan
    wave = max(moved, key=lambda one: abs(one.amplitude[0]))
    return 2.0 * pi / wave.rate[0], 2.0 * abs(wave.amplitude[0]), wave.begin


def analyse(gathered: Gathered) -> Waves | None:
    """Waves at the gauges of a scene; None where it has none."""
    flow, profiles = gathered.flow, gathered.profiles
    gauges = flow.scene.gauges
    if not gauges:
        return None
    x, time, depth = profiles["x"].values, profiles["time"].values, profiles["surface_depth"].values
    records = np.array([[np.interp(place, x, row) for row in depth] for place in gauges])
    low, high = x[0] - 0.5 * flow.bin_width, x[-1] + 0.5 * flow.bin_width
    records[[not low <= place <= high for place in gauges]] = nan  # the gauge is where no profile is
    (first, last), (period, stroke, begin) = window_of(profiles), paddle(flow)
    inside = within(time, (first, last))
    known: dict[str, Any] = {"gauges": tuple(gauges), "time": time, "records": records}
    if inside.any():
        known["means"] = tuple(float(record[inside].mean()) for record in records)
    known |= {"lowest": tuple(map(float, records.min(axis=1))), "largest": tuple(map(float, records.max(axis=1)))}
    if not period > 0:
        return Waves(**known, reason="no wall oscillates, so that no period is known")
    periods = int((last - max(first, begin) + 1e-6 * period) / period)
    if periods < 1:
        return Waves(period, **known, reason=f"the window holds no whole period of {period:zg} s of the moving paddle")
    means = [mean_wave(time, record, period, last, periods) for record in records]
    heights = tuple(float(np.ptp(mean)) for mean in means)
    depths = tuple(float(mean.mean()) for mean in means)
    small = devices.piston_wave_height(stroke, period, depths[0], flow.gravity) if stroke > 0 < depths[0] else nan
    return Waves(period, periods, heights[0], heights[-1], small, depths[0], heights=heights, depths=depths, **known)


def tables(waves: Waves) -> Tables:
    """Depth at each gauge against time, m."""
    assert waves.time is not None and waves.records is not None
    columns = {f"depth_{place:zg}": record for place, record in zip(waves.gauges, waves.records, strict=True)}
    return {"gauges.csv": {"time": waves.time, **columns}}


LOOKS = ("first", "second", "third")


def figures(waves: Waves, gathered: Gathered) -> Drawings:
    """Depth at the gauges against time."""
    assert waves.time is not None and waves.records is not None
    lines = [
        Trace(f"x = {place:zg} m", waves.time, record, LOOKS[k % len(LOOKS)])
        for k, (place, record) in enumerate(zip(waves.gauges, waves.records, strict=True))
    ]
    return {"gauges": Chart("depth at the gauges", TIME, [Panel("Depth of the\nfree surface [m]", lines)])}


def section(waves: Waves) -> Section:
    """Depths by gauge; heights of waves where a paddle makes some."""
    names = {"means": "mean depth of the window [m]", "lowest": "lowest", "largest": "largest of the record"}
    names |= {"heights": "wave height [m]", "depths": "mean depth of whole periods [m]"}
    measured = {name: getattr(waves, name) for name in names if getattr(waves, name)}
    if not measured:
        return Section("Gauges", [])
    columns = zip(waves.gauges, *measured.values(), strict=True)
    rows = [(f"{x:zg}", *(f"{value:z.3f}" if known(value) else None for value in values)) for x, *values in columns]
    blocks: list[Block] = [Table(rows, ("Gauge, x [m]", *(names[name] for name in measured)))]
    if unknown := [str(x) for x, *values in rows if None in values]:
        blocks.append(Text(f"No bed is known, and no depth, at times or always at x = {', '.join(unknown)} m."))
    if not known(waves.height):
        return Section("Gauges", blocks)
    return Section("Waves", [*blocks, Table(described(waves, "period", "periods", "height_piston"))])


def line(summary: Mapping[str, Any]) -> str:
    """A line on the depths at the gauges of the case; empty where there are none."""
    columns = [part(summary, "waves").get(key) or () for key in ("gauges", "means", "largest")]
    known = (row for row in zip(*columns, strict=False) if None not in row)
    each = [f"x = {x:zg} m {mean:z.2f} ({most:z.2f})" for x, mean, most in known]
    return f"depth at gauges, mean of the window (largest), m: {', '.join(each)}" if each else ""


QUANTITY = Quantity(
    name="waves",
    title="Waves at gauges",
    result=Waves,
    definitions="""\
height        crest less trough of the mean wave: the depth at the gauge, averaged over the whole periods of the paddle
              at the end of the window at equal times within the period
piston        S 2 (cosh 2kh − 1)/(sinh 2kh + 2kh), small waves of water; S whole stroke, ω² = g k tanh kh
depth         of the free surface at the gauge, mean of the same periods
gauges        mean: depth over the window; lowest, largest: of all frames
""",
    always=lambda flow: bool(flow.scene.gauges),
    analyse=analyse,
    files={"gauges.csv": "depth at the gauges against time"},
    captions={"gauges": "Depth at the gauges"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(
        HeadlineNumber("height", "piston, small waves", "height_piston", holds="of small waves of a piston"),
        HeadlineNumber("height_last"),
        HeadlineNumber("depth"),
    ),
    rank=20,
    line=line,
)
