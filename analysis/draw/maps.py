# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of coarse-grained fields: a map, and the pressure at the bed against hydrostatic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lammps_jump.analysis.flow import Flow

from .chart import PLACE, Chart, Map, Panel, Trace, edges_of, shown_walls
from .depths import axis_label

if TYPE_CHECKING:
    import xarray as xr


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
    """Vertical stress at the bed along the channel beside the weight of what lies above."""
    pressure = bed_pressure(fields)
    x, stress, weight = pressure.x.values, pressure.stress.values / 1e3, pressure.hydrostatic.values / 1e3
    lines = (
        Trace("contact and kinetic stress at the bed", x, stress),
        Trace("hydrostatic: weight above", x, weight, "theory"),
    )
    lowest = min(0.0, float(np.min(stress[np.isfinite(stress)], initial=0.0)))
    panel = Panel("Vertical stress [kPa]", lines, ylim=(lowest, None))
    return Chart(_heading(fields, "pressure at the bed"), PLACE, (panel,))
