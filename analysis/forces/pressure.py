# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressure of the discs along outlines: mean, percentiles and largest of each bin, the resultant, and gauges.

The native engine sums the force on each stretch of an outline at every step (`lammps_jump.scene.pressed`). A value in
time is the mean over a window of the probes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.profiles import window_of
from lammps_jump.analysis.quantity import Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import Mean, as_fields, mean_of
from lammps_jump.dump.walls import StretchForces, read_pressure
from lammps_jump.errors import DumpError
from lammps_jump.scene.pressed import FaceStretch
from lammps_jump.units import Estimates, as_summary, estimate, known, number

if TYPE_CHECKING:
    import xarray as xr

KILO = 1e3
SAME = 1e-6
"""Difference of directions below which stretches are of one straight face."""


@dataclass(frozen=True)
class Pressure(Estimates):
    """Pressure on one wall or at one gauge; of a wall `x`, `y` are the bin with the largest mean, or largest value.

    `reason` says why there is none. `table` holds what ``pressure.nc`` has of its stretches, shape (stretches,), and
    the pressure against time, Pa, shape (windows, stretches).
    """

    x: float = number("m", "x of the gauge, or of the bin with the largest mean", default=nan)
    y: float = number("m", "y of the gauge, or of the bin with the largest mean", default=nan)
    width: float = number("m", "width of the gauge or of that bin", default=nan)
    mean: float = estimate("Pa", "mean pressure there, of the window")
    percentile_95: float = number("Pa", "95 % of the values in time there are below", default=nan)
    percentile_99: float = number("Pa", "99 % of the values in time there are below", default=nan)
    largest: float = number("Pa", "largest pressure on the wall, or at the gauge", default=nan)
    largest_at: float = number("s", "time of the largest pressure", default=nan)
    largest_x: float = number("m", "x of the largest pressure", default=nan)
    largest_y: float = number("m", "y of the largest pressure", default=nan)
    force: float = estimate("N/m", "mean force into the face that bears most, of the window")
    force_x: float = number("m", "x of the point where that force acts", default=nan)
    force_y: float = number("m", "y of the point where that force acts", default=nan)
    force_height: float = number("m", "height of that point over the lowest point of the face", default=nan)
    reason: str | None = None
    stretches: tuple[FaceStretch, ...] = field(default=(), metadata={"summary": False})
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


NOT_SUMMED = "the native engine alone sums forces along outlines: use engine.name: native"


def analyse(gathered: Gathered) -> dict[str, Pressure] | None:
    """Pressure on each wall and at each gauge that the case asks for; None where it asks for none."""
    flow = gathered.flow
    if not flow.scene.pressure:
        return None
    names = dict.fromkeys(one.wall for one in flow.scene.pressure)
    if gathered.pressure is None:
        return {name: Pressure(reason=NOT_SUMMED) for name in names}
    try:
        record = read_pressure(gathered.pressure, flow.scene)
    except DumpError as error:
        return {name: Pressure(reason=str(error)) for name in names}
    live = record.time > 0 if (record.time > 0).any() else np.ones(len(record.time), bool)
    low, high = window_of(gathered.profiles)
    inside = (record.time > low) & (record.time <= high + 1e-9)
    rows = inside, inside if flow.scene.inlets else live
    pressures: dict[str, Pressure] = {}
    for name in names:
        of_wall = [k for k, one in enumerate(flow.scene.pressure) if one.wall == name]
        bins = [k for k in of_wall if not flow.scene.pressure[k].gauge]
        if bins:
            pressures[name] = _found(record, flow.scene.pressure, bins, rows)
        gauges = [k for k in of_wall if flow.scene.pressure[k].gauge]
        pressures |= {
            f"{name}_{place}": _found(record, flow.scene.pressure, [k], rows) for place, k in enumerate(gauges, 1)
        }
    return pressures


def _found(
    record: StretchForces, stretches: tuple[FaceStretch, ...], which: list[int], rows: tuple[np.ndarray, np.ndarray]
) -> Pressure:
    """Pressure on some stretches: means over the first rows, percentiles and largest values over the second."""
    there, (inside, live) = tuple(stretches[k] for k in which), rows
    if not inside.any() or not live.any():
        return Pressure(reason="the record has no row in the window", stretches=there)
    width = np.array([one.width for one in there])
    values = record.across[:, which] / width
    means = [mean_of(values[inside, k]) for k in range(len(which))]
    mean, error = np.array([one.value for one in means]), np.array([one.error for one in means])
    percentiles: dict[str, Any] = {
        f"percentile_{share}": np.percentile(values[live], share, axis=0) for share in (95, 99)
    }
    largest = values[live].max(axis=0)
    table = {
        "time": record.time, "pressure": values, "shear": record.along[:, which] / width,
        "mean": mean, "mean_error": error, **percentiles, "largest": largest,
    }  # fmt: skip
    if not values[live].any():
        return Pressure(reason="nothing touched it", stretches=there, table=table)
    at, top = int(np.argmax(mean)), int(np.argmax(largest))
    when = int(np.argmax(np.where(live, values[:, top], -np.inf)))
    gauge = there[0].gauge
    return Pressure(
        x=there[at].place[0], y=there[at].place[1], width=there[at].width,
        **as_fields(mean=means[at]),
        percentile_95=float(percentiles["percentile_95"][at]), percentile_99=float(percentiles["percentile_99"][at]),
        largest=float(largest[top]), largest_at=float(record.time[when]),
        largest_x=there[top].place[0], largest_y=there[top].place[1],
        **({} if gauge else _resultant(record, there, which, inside)), stretches=there, table=table,
    )  # fmt: skip


def _resultant(
    record: StretchForces, stretches: tuple[FaceStretch, ...], which: Sequence[int], inside: np.ndarray
) -> dict[str, Any]:
    """Mean force into the straight face that bears most, and where it acts; nothing of what is curved there."""
    along = np.array([one.along for one in stretches])
    across, firsts = record.across[inside][:, which], record.first[inside][:, which]
    strongest = int(np.argmax(across.mean(axis=0)))
    face = np.hypot(*(along - along[strongest]).T) < SAME
    # of faces that run alike, such as treads of stairs, those next to each other are one
    parts = np.split(np.flatnonzero(face), np.flatnonzero(np.diff(np.flatnonzero(face)) > 1) + 1)
    face = next(part for part in parts if strongest in part)
    force: Mean = mean_of(across[:, face].sum(axis=1))
    first = float(firsts[:, face].sum(axis=1).mean())
    if not force.value > 0:
        return as_fields(force=force)
    one = stretches[face[0]]
    way = first / force.value - 0.5 * (one.begin + one.end)  # from the middle of the first bin
    x, y = (one.place[k] + way * one.along[k] for k in (0, 1))
    ends = [stretches[k].place[1] + side * 0.5 * stretches[k].width * one.along[1] for k in face for side in (-1, 1)]
    return as_fields(force=force) | {"force_x": x, "force_y": y, "force_height": y - min(ends)}


def dataset(pressures: Mapping[str, Pressure]) -> Mapping[str, xr.Dataset]:
    """All stretches one after the other, as ``pressure.nc``."""
    import xarray as xr  # 0.3 s

    parts = [(name, one) for name, one in pressures.items() if one.table]
    if not parts:
        return {}
    stretches = [(name, stretch) for name, one in parts for stretch in one.stretches]
    units = {"pressure": "Pa", "shear": "Pa", "mean": "Pa", "mean_error": "Pa", "percentile_95": "Pa"}
    units |= {"percentile_99": "Pa", "largest": "Pa"}
    data: dict[str, Any] = {}
    for key, unit in units.items():
        values = np.concatenate([one.table[key] for _, one in parts], axis=-1)
        data[key] = (("time", "s") if values.ndim == 2 else ("s",), values, {"units": unit})
    for key, column in {
        "begin": [one.begin for _, one in stretches], "end": [one.end for _, one in stretches],
        "x": [one.place[0] for _, one in stretches], "y": [one.place[1] for _, one in stretches],
    }.items():  # fmt: skip
        data[key] = ("s", np.array(column), {"units": "m"})
    data["name"] = ("s", np.array([name for name, _ in stretches]), {"long_name": "wall, or gauge"})
    middle = np.array([0.5 * (one.begin + one.end) for _, one in stretches])
    coords = {
        "time": ("time", parts[0][1].table["time"], {"units": "s"}),
        "s": ("s", middle, {"units": "m", "long_name": "place along the outline of its wall"}),
    }
    return {"pressure.nc": xr.Dataset(data, coords)}


def summary(pressures: Mapping[str, Pressure]) -> dict[str, object]:
    """As under ``pressure`` in ``summary.json``: walls and gauges by name."""
    return {name: as_summary(one) for name, one in pressures.items()}


def figures(pressures: Mapping[str, Pressure], _: Gathered) -> Drawings:
    """Pressure along each outline, and at gauges against time."""
    along: list[Panel] = []
    gauges: list[Trace] = []
    for name, one in pressures.items():
        if not one.table:
            continue
        if one.stretches[0].gauge:
            where = f"{name}: x = {one.x:z.3g}, y = {one.y:z.3g} m" if isfinite(one.x) else name
            gauges.append(Trace(where, one.table["time"], one.table["pressure"][:, 0] / KILO, LOOKS[len(gauges) % 4]))
            continue
        label, place = _abscissa(one)
        order = np.argsort(place, kind="stable")
        lines = [
            Trace(words, place[order], one.table[key][order] / KILO, look, error[order] if error is not None else None)
            for key, words, look, error in (
                ("mean", "mean of the window", "first", one.table["mean_error"] / KILO),
                ("percentile_95", "95 %", "second", None), ("percentile_99", "99 %", "third", None),
                ("largest", "largest", "sum", None),
            )
        ]  # fmt: skip
        along.append(Panel(f"{name}:\npressure [kPa]", lines, x=label))
    shown: Drawings = {"pressure": Chart("pressure along the outlines", "Place", along)} if along else {}
    if gauges:
        shown["pressure_gauges"] = Chart("pressure at the gauges", TIME, [Panel("Pressure [kPa]", gauges)])
    return shown


LOOKS = ("first", "second", "third", "sum")


def _abscissa(one: Pressure) -> tuple[str, np.ndarray]:
    """Abscissa of the pressure: y or x of a straight wall, else the place along the outline."""
    along = np.array([stretch.along for stretch in one.stretches])
    places = np.array([stretch.place for stretch in one.stretches])
    if np.ptp(along, axis=0).max() < SAME:
        axis = int(np.argmax(np.abs(along[0])))
        return f"{'xy'[axis]} [m]", places[:, axis]
    return "Along the outline [m]", np.array([0.5 * (stretch.begin + stretch.end) for stretch in one.stretches])


def section(pressures: Mapping[str, Pressure]) -> Section:
    """The numbers of each wall and gauge."""
    blocks: list[Table | Text] = []
    for name, one in pressures.items():
        keys = [key for key in KEYS if known(getattr(one, key))]
        if keys:
            blocks.append(Table(described(one, *keys), (f"Pressure on {name}", "")))
        if one.reason:
            blocks.append(Text(f"No pressure is told for {name}: {one.reason}.", "warn"))
    return Section("Pressure", blocks)


KEYS = (
    "x", "y", "width", "mean", "mean_error", "percentile_95", "percentile_99", "largest", "largest_at", "largest_x",
    "largest_y", "force", "force_error", "force_x", "force_y", "force_height",
)  # fmt: skip

QUANTITY = Quantity(
    name="pressure",
    title="Pressure",
    result=Pressure,
    definitions="""\
pressure      force of the discs into a stretch of an outline over its width; of every step, a value in time is the mean
              over a window of the probes. Discs press at points: a stretch below three diameters shows single ones
mean          of the window of the means; at the bin of the wall where it is largest
percentiles   of the values in time, at the same place; with the largest in the window where discs flow in, else after
              t = 0. Shorter windows have larger ones
force         into the straight face of the bin with the largest mean; it acts where its moment is that of the discs
gauge         named after its wall, with a number: the mean over its width
""",
    always=lambda flow: bool(flow.scene.pressure),
    analyse=analyse,
    files={"pressure.nc": "pressure along outlines against time, with mean, percentiles and largest"},
    captions={"pressure": "Pressure along the outlines", "pressure_gauges": "Pressure at the gauges"},
    datasets=dataset,
    figures=figures,
    section=section,
    summary=summary,
    named=Named("outline", "name the wall in probes.pressure of the case", "pressed", "<wall>"),
)
