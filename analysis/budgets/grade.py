# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy grade line: the head of the stream along the channel, and what is lost of it between any two stations.

The head is ``H = z + p + k``, means of the window by mass: the centre of mass of the discs, half of the depth that is
connected to the bed as the head of hydrostatic pressure, and the kinetic energy carried over that of the discharge,
``sum m u |v|^2/2 / (g sum m u)``. Of water at rest it is the height of the surface, of a free jet z + |v|^2/2g.
It follows from the profiles alone, so that every engine and every dump with velocities has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump.analysis.draw.chart import PLACE, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, cells, cut, heading
from lammps_jump.analysis.statistics import as_fields, mean_of
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.units import Estimates, estimate, known, number, numbers_of

if TYPE_CHECKING:
    import xarray as xr

FLOWS = 0.2
"""Share of the largest discharge of the window that a bin has to carry."""
STILL = 0.02
"""Below this share of sqrt(g s) discs are at rest, and no stream runs."""
SAME = 0.1
"""Share by which the discharges at two stations may differ: what is stored between them is no loss."""
EVERY_WAY = 10.0
"""Kinetic energy over that of the mean velocity from which on discs move every way, as in a pour, and are no stream."""
FEWEST = 4
"""Bins of a stream."""
COLUMNS = ("x", "bed", "depth", "discharge", "velocity_head", "head")
"""Of a station and of the grade line."""


class GradeLine(NamedTuple):
    """The head along the channel, arrays of shape (bins,), in the order of x; NaN where no stream runs.

    Attributes
    ----------
    x, bed, depth : m
        Depth by mass.
    discharge : m^2/s
    level, velocity_head, head : m
        z + p, k, and their sum.
    filling : m^2/s
        What a bin stores: growth of its depth by mass over the window, times its width.
    series : ndarray, shape (frames, bins), m
        The head of each frame of the window, linear about the mean: for its error.
    towards : int
        Direction of the stream along x.
    """

    x: np.ndarray
    bed: np.ndarray
    depth: np.ndarray
    discharge: np.ndarray
    level: np.ndarray
    velocity_head: np.ndarray
    head: np.ndarray
    filling: np.ndarray
    series: np.ndarray
    towards: int


@dataclass(frozen=True)
class Station(Estimates):
    """The stream in the bin of a station."""

    x: float = number("m", "station at x", default=nan)
    bed: float = number("m", "bed", default=nan)
    depth: float = number("m", "mass depth", default=nan)
    discharge: float = number("m^2/s", "discharge", default=nan)
    velocity_head: float = number("m", "velocity head", default=nan)
    head: float = number("m", "head", default=nan)
    lost: float = estimate("m", "head lost since the station before")


@dataclass(frozen=True)
class Grade(Estimates):
    """Heads of a stream, and what is lost between its first and last station and from one to the next."""

    upstream: float = number("m", "first station", default=nan)
    downstream: float = number("m", "last station", default=nan)
    head_upstream: float = number("m", "head at the first station", default=nan)
    head_downstream: float = number("m", "head at the last station", default=nan)
    lost: float = estimate("m", "head lost between the stations", label="head lost between stations")
    stations: tuple[Station, ...] = ()
    reason: str | None = None
    line: GradeLine | None = field(default=None, metadata={"summary": False})

    def between(self, first: float, last: float) -> Station:
        """The stream at the second of two places (m), with the head lost since the first."""
        return _stations(self.line, (first, last))[-1] if self.line is not None else Station(x=last)


def line_of(profiles: xr.Dataset, flow: Flow) -> GradeLine | str:
    """The grade line of the window, or why there is none."""
    if flow.gravity <= 0 or not flow.velocities:
        return "a head needs gravity towards the bed, and velocities"
    inside, g = within(profiles["time"].values, window_of(profiles)), flow.g
    names = ("mass_depth", "surface_depth", "centroid_height", "discharge", "energy_flux")
    s, h, centre, q, e = (np.nan_to_num(profiles[name].values[inside]) for name in names)
    x, bed = profiles["x"].values, profiles["bed"].values
    beds = profiles["bed_at"].values[inside] if "bed_at" in profiles else bed
    depth, discharge = s.mean(axis=0), q.mean(axis=0)
    wet = (depth > 0.5 * flow.scene.diameter) & np.isfinite(bed)
    towards = -1 if discharge[wet].sum() < 0 else 1
    stream = wet & (towards * discharge > FLOWS * np.abs(discharge[wet]).max(initial=0.0))
    is_still = np.abs(discharge) < STILL * np.sqrt(g * np.maximum(depth, 0.0)) * depth
    if stream.sum() < max(FEWEST, 0.5 * wet.sum()) or np.median(is_still[stream]) > 0:
        return "no stream runs along the bed in the window"
    across, along = flow.gravity / g, flow.scene.gravity[0] / g
    with np.errstate(invalid="ignore", divide="ignore"):
        height = (across * (beds + centre + 0.5 * np.minimum(s, h)) - along * x) * s
        level = np.where(stream, height.mean(axis=0) / depth, nan)
        kinetic = np.where(stream, e.mean(axis=0) / discharge / g, nan)
        uniform = (discharge / depth) ** 2 / (2.0 * g)
        if np.median(kinetic[stream]) > EVERY_WAY * np.median(uniform[stream]):
            return "discs move every way in the window, and not along the bed"
        series = level + kinetic + (height - level * s) / depth + (e / g - kinetic * q) / discharge
    times = profiles["time"].values[inside]
    filling = (s[-1] - s[0]) * flow.bin_width / (times[-1] - times[0]) if len(times) > 1 else 0.0 * depth
    return GradeLine(x, bed, depth, discharge, level, kinetic, level + kinetic, filling, series, towards)


def _stations(line: GradeLine, places: tuple[float, ...]) -> tuple[Station, ...]:
    """Stations along the stream at the bins that hold these places, m; NaN where no stream runs."""
    stations: list[Station] = []
    before = -1
    for place in sorted(places, key=lambda x: line.towards * x):
        k = int(np.argmin(np.abs(line.x - place)))
        values = {
            name: float(getattr(line, name)[k]) for name in ("bed", "depth", "discharge", "velocity_head", "head")
        }
        lost = mean_of(line.series[:, before] - line.series[:, k]) if before >= 0 and _alike(line, before, k) else None
        stations.append(Station(x=float(place), **values, **(as_fields(lost=lost) if lost else {})))
        before = k
    return tuple(stations)


def _alike(line: GradeLine, one: int, two: int) -> bool:
    """Tells whether the same stream runs through two bins."""
    pair = line.discharge[[one, two]]
    known = np.isfinite(line.head[[one, two]]).all()
    return bool(known and np.ptp(pair) <= SAME * np.abs(pair).max())


def analyse(gathered: Gathered) -> Grade:
    """Grade line of a flow: at the stations that the case names, else at gauges, else at both ends of the stream."""
    flow = gathered.flow
    line = line_of(gathered.profiles, flow)
    if isinstance(line, str):
        return Grade(reason=line)
    ends = line.x[np.flatnonzero(np.isfinite(line.head))[[0, -1]]]
    heads_at = flow.heads_at or flow.scene.gauges
    places = tuple(heads_at) if len(heads_at) > 1 else tuple(float(x) for x in ends)
    stations = _stations(line, places)
    first, last = stations[0], stations[-1]
    whole = _stations(line, (first.x, last.x))[-1]
    return Grade(
        first.x,
        last.x,
        first.head,
        last.head,
        lost=whole.lost,
        **{"lost_error": whole.lost_error},  # a field that `estimate` adds
        stations=stations,
        reason=_why_no_loss(line, first, last) if np.isnan(whole.lost) else None,
        line=line,
    )


def _why_no_loss(line: GradeLine, first: Station, last: Station) -> str:
    """Why no head lost is given between two stations."""
    for one in (first, last):
        if np.isnan(one.head):
            return f"no stream runs at x = {one.x:z.4g} m in the window; take another station"
    low, high = sorted((first.x, last.x))
    stored = float(line.filling[(line.x > low) & (line.x < high)].sum())
    missing = abs(first.discharge) - abs(last.discharge)
    prefix = (
        f"the discharge is {first.discharge:z.3g} m2/s at x = {first.x:z.4g} m and {last.discharge:z.3g} m2/s at "
        f"{last.x:z.4g} m: "
    )
    if abs(missing - stored) < 0.5 * abs(missing):
        return f"{prefix}the flow is not steady in the window, and what it stores ({stored:z.3g} m2/s) is no loss"
    return (
        f"{prefix}what the flow stores between them ({stored:z.3g} m2/s) is not the difference, so that discs come or "
        "go there; take stations on one side of that place"
    )


def tables(grade: Grade) -> Tables:
    """The grade line over x, with the head lost since the first station."""
    line = grade.line
    if line is None:
        return {}
    columns = {
        name: getattr(line, name) for name in ("x", "bed", "depth", "discharge", "level", "velocity_head", "head")
    }
    return {"grade.csv": columns | {"lost": grade.head_upstream - line.head}}


def figures(grade: Grade, gathered: Gathered) -> Drawings:
    """Energy line, level and bed along x, and the head lost since the first station."""
    line = grade.line
    if line is None:
        return {}
    marks = {f"{station.x:z.4g} m": station.x for station in grade.stations}
    lines = [
        Trace("head H = z + p + k", line.x, line.head),
        Trace("level z + p", line.x, line.level, "third"),
        Trace("bed", line.x, line.bed, "faint"),
    ]
    lost = Trace("", line.x, grade.head_upstream - line.head)
    panels = (
        Panel("Energy head [m]", lines, marks=marks, height=1.6),
        Panel(f"Head lost since\nx = {grade.upstream:z.4g} m [m]", [lost], marks=marks),
    )
    return {"energy_head": Chart("energy head of the window", PLACE, panels)}


def section(grade: Grade) -> Section:
    """Heads at the stations and what is lost between them."""
    if not known(grade.head_upstream):
        return Section("Energy grade line", [Text(grade.reason or "", "small")])
    numbers = numbers_of(Station)
    heads = [heading(numbers[key].meaning, numbers[key].unit) for key in (*COLUMNS, "lost")]
    rows = [(*cells(station, *COLUMNS), cut(station, "lost")) for station in grade.stations]
    text = "Head lost is given where the discharges of two stations are within 10 % of each other."
    return Section("Energy grade line", [Table(rows, heads), Text(grade.reason or "", "warn"), Text(text, "small")])


def _ends(summary: Mapping[str, Any]) -> dict[str, str]:
    ends = [part(summary, "grade").get(key) for key in ("upstream", "downstream")]
    return {"stations": " to ".join(f"{x:z.3g}" for x in ends if isinstance(x, int | float)) + " m"}


QUANTITY = Quantity(
    name="grade",
    title="Energy grade line",
    result=Grade,
    definitions="""\
head        z + p + k of the discs in a bin, means of the window by mass: height of the centre of mass; half of the
            depth that is connected to the bed (hydrostatic pressure); ∑ m u |v|²/2 over g ∑ m u (kinetic energy);
            where discs strike the bed, pressure is more than hydrostatic, and the line dips
lost        difference of the heads of two stations whose discharges are within 10 %; friction, impacts and the jump
stations    analysis.stations (--stations), else the gauges, else the ends of the stream; each is the bin that holds it
error       standard error within this run, from eight pieces of the window
""",
    analyse=analyse,
    files={"grade.csv": "energy grade line over x, and the head lost since the first station"},
    captions={"energy_head": "Energy head along the channel"},
    tables=tables,
    figures=figures,
    marked="energy_head",
    section=section,
    headline=(HeadlineNumber("lost", label="head lost from {stations}"),),
    rank=100,
    label_values=_ends,
)
