# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of profiles and coarse-grained fields: depth, velocity, maps, pressure at the bed against hydrostatic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.scene.walls import Interval

from .chart import PLACE, TIME, Chart, Map, Panel, Trace, edges_of, shown_walls

if TYPE_CHECKING:
    import xarray as xr


def axis_label(quantity: xr.DataArray) -> str:
    """Name and unit of a quantity for an axis, from its attributes ``long_name`` and ``units``."""
    name = quantity.attrs.get("long_name", quantity.name).removeprefix("time mean of ")
    units = quantity.attrs.get("units", "")
    for text, nice in (("m2 s-1", "m²/s"), ("m3 s-2", "m³/s²"), ("m4 s-3", "m⁴/s³"), ("m s-1", "m/s")):
        units = units.replace(text, nice)
    return f"{name[:1].upper()}{name[1:]}" + (f" [{units}]" if units not in ("", "1") else "")


def depth_profile(profiles: xr.Dataset, flow: Flow, *, lines: Mapping[str, float], marks: Mapping[str, float]) -> Chart:
    """Mean free surface and mass depth along the channel, with the classical depths; velocity below.

    Parameters
    ----------
    profiles : xarray.Dataset
        Of `compute_profiles`.
    flow : Flow
    lines : mapping of label to depth (m)
        Horizontal lines to compare with.
    marks : mapping of label to x (m)
        Vertical marks: toe, end of the jump.
    """
    bed = profiles.bed.values
    surface = _mean(profiles, "surface_depth", bed, "free surface")
    mass = _mean(profiles, "mass_depth", bed, "mass depth", "second")
    low = min(0.0, float(np.min(bed[np.isfinite(bed)], initial=0.0)))
    top = float(np.nanmax([1.0, *lines.values(), *surface.y, *mass.y]))
    x, y = _occupied(profiles), (low - 0.04 * top, 1.15 * top)
    solids = shown_walls(flow.standing_at(profiles.attrs["window_end"]), x, y)
    upper = Panel("Height above y = 0 [m]", (surface, mass), "", lines, marks, solids, x, y, 2.2)
    speed = _mean(profiles, "velocity", 0.0, "mean discharge over mean depth")
    skin = Trace("at the surface", profiles.x.values, profiles.surface_velocity_mean.values, "second")
    lower = Panel("Velocity [m/s]", (speed, skin), marks=marks, xlim=x)
    begin, end, frames = (profiles.attrs[f"window_{name}"] for name in ("begin", "end", "frames"))
    return Chart(f"mean of {frames} frames, {flow.clock(begin, end)}", PLACE, (upper, lower))


def _mean(profiles: xr.Dataset, name: str, above: Any, label: str, look: str = "first") -> Trace:
    """A mean of the window, drawn `above` this height, with its standard error."""
    values, error = profiles[f"{name}_mean"].values + above, profiles[f"{name}_stderr"].values
    return Trace(label, profiles.x.values, values, look, error)


def _bin_edges(profiles: xr.Dataset) -> np.ndarray:
    return np.linspace(profiles.attrs["x_low"], profiles.attrs["x_high"], profiles.sizes["x"] + 1)


def _occupied(profiles: xr.Dataset) -> Interval:
    """The bins from the first to the last that held a disc in the window, m; all where none did."""
    edges, held = _bin_edges(profiles), np.flatnonzero(profiles["count_mean"].values > 0)
    return (edges[held[0]], edges[held[-1] + 1]) if held.size else (edges[0], edges[-1])


def _ever_occupied(profiles: xr.Dataset) -> slice:
    """The bins from the first to the last that ever held a disc, and one to either side; all where none did."""
    held = np.flatnonzero((profiles["mass_depth"].values > 0).any(axis=0))
    return slice(max(held[0] - 1, 0), held[-1] + 2) if held.size else slice(0, profiles.sizes["x"])


def xt_map(
    profiles: xr.Dataset,
    variable: str = "surface_depth",
    *,
    toe: tuple[np.ndarray, np.ndarray] | None = None,
    title: str | None = None,
) -> Map:
    """Map of a profile variable over distance and time.

    Parameters
    ----------
    profiles : xarray.Dataset
    variable : str
        A (time, x) variable.
    toe : (ndarray, ndarray), optional
        Places (m) and times (s) of a tracked front, drawn on top.
    """
    values, held = profiles[variable].values, _ever_occupied(profiles)
    edges, values = _bin_edges(profiles)[held.start : held.stop + 1], values[:, held]
    return Map(
        title or f"{variable.replace('_', ' ')} over distance and time",
        axis_label(profiles[variable]),
        edges,
        profiles.time.values,
        values,
        TIME if profiles.time.attrs.get("units") != "1" else "Step",
        bool(np.nanmin(values, initial=0.0) < 0),
        () if toe is None else (Trace("front", *toe, "theory"),),
    )


def _ring(corners: np.ndarray) -> Trace:
    x, y = np.vstack([corners, corners[:1]]).T
    return Trace("", x, y, "sum")


def field_map(fields: xr.Dataset, flow: Flow, variable: str = "pressure") -> Map:
    """Map of one field over the channel, with its walls.

    Parameters
    ----------
    fields : xarray.Dataset
        Of `compute_fields` or `mean_fields`.
    flow : Flow
    variable : str
    """
    quantity = fields[variable]
    if quantity.attrs.get("units") == "Pa":
        quantity = (quantity / 1e3).assign_attrs(quantity.attrs, units="kPa")
    # where the kernel has only the rim of a disc there is nothing to see
    values = np.where(fields["density"].values > 0.05 * flow.scene.density, quantity.values, np.nan)
    x, y = edges_of(fields.x.values), edges_of(fields.y.values)
    room = (x[0], x[-1]), (y[0] - 0.08 * (y[-1] - y[0]), y[-1])
    walls = flow.standing_at(_time_of(fields, flow))
    hollow = [corners for wall in walls if wall.hollow for corners in wall.outline(*room)]
    return Map(
        _heading(fields, variable),
        axis_label(quantity).replace(", compression positive", ""),
        x,
        fields.y.values,
        values,
        "Height y [m]",
        bool(np.nanmin(values, initial=0.0) < 0),
        [_ring(corners) for corners in hollow],
        shown_walls(walls, *room),
        to_scale=True,
    )


def _heading(fields: xr.Dataset, what: str) -> str:
    when = (
        f"mean of {fields.attrs['frames']} frames" if "frames" in fields.attrs else f"t = {float(fields.time):z.2f} s"
    )
    return f"{what.replace('_', ' ')}, {when} (kernel reach {fields.attrs['reach']:zg} m)"


def _time_of(fields: xr.Dataset, flow: Flow) -> float:
    """Time at which walls that move are shown, s: with the frame, or at the end of the window of a mean."""
    if "frames" in fields.attrs:
        return flow.window[1] if flow.window else 0.0
    return float(fields.time)


def bed_pressure(fields: xr.Dataset) -> xr.Dataset:
    """Vertical stress and weight above, at the lowest open cell of each column.

    Parameters
    ----------
    fields : xarray.Dataset
        With contact stress.

    Returns
    -------
    xarray.Dataset
        ``stress`` (contact and kinetic yy) and ``hydrostatic``, dims (x), Pa; NaN where a column has no open cell.
    """
    held = fields["density"].notnull()
    lowest = fields[["contact_yy", "kinetic_yy", "hydrostatic"]].isel(y=held.argmax("y")).where(held.any("y"))
    lowest = lowest.drop_vars("y").assign(stress=lowest["contact_yy"] + lowest["kinetic_yy"])
    for name, meaning in (("stress", "vertical stress at the bed"), ("hydrostatic", "weight above")):
        lowest[name].attrs = {"units": "Pa", "long_name": meaning}
    return lowest[["stress", "hydrostatic"]]


def bed_pressure_chart(fields: xr.Dataset) -> Chart:
    """Vertical stress at the bed along the channel, and the weight of what lies above."""
    pressure = bed_pressure(fields)
    x, stress, weight = pressure.x.values, pressure.stress.values / 1e3, pressure.hydrostatic.values / 1e3
    lines = (
        Trace("contact and kinetic stress at the bed", x, stress),
        Trace("hydrostatic: weight above", x, weight, "theory"),
    )
    lowest = min(0.0, float(np.min(stress[np.isfinite(stress)], initial=0.0)))
    panel = Panel("Vertical stress [kPa]", lines, ylim=(lowest, None))
    return Chart(_heading(fields, "pressure at the bed"), PLACE, (panel,))
