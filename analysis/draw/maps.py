# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of coarse-grained fields: a map, and the pressure at the bed against hydrostatic."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lammps_jump.analysis.flow import Flow

from .chart import PLACE, Chart, Line, Panel
from .depths import axis_label
from .style import colour_bar, draw_walls, drawing


def field_map(fields: xr.Dataset, flow: Flow, variable: str = "pressure") -> Figure:
    """Map of one field over the channel, walls in grey.

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
    values = quantity.values
    half = 0.5 * float(fields.attrs["spacing"])
    x, y = (np.append(axis.values - half, axis.values[-1] + half) for axis in (fields.x, fields.y))
    # where the kernel has only the rim of a disc there is nothing to see
    dense = fields["density"].values > 0.05 * flow.scene.density
    finite = values[np.isfinite(values) & dense]
    low, high = (float(np.quantile(finite, q)) for q in (0.005, 0.995)) if finite.size else (0.0, 1.0)
    shown = np.where(dense, values, np.nan)
    wide = (x[-1] - x[0]) / (y[-1] - y[0])
    with drawing(8.4, float(np.clip((7.6 / wide + 1.7) if wide > 3 else 6.4 / wide + 0.8, 2.4, 9.0))) as (figure, axes):
        axes.grid(False)
        below = 0.08 * (y[-1] - y[0])
        draw_walls(axes, flow.scene.walls, (x[0], x[-1]), (y[0] - below, y[-1]))
        image = axes.pcolormesh(x, y, shown, vmin=min(low, 0.0), vmax=max(high, 1e-12), rasterized=True)
        axes.set_aspect("equal")
        label = axis_label(quantity).replace(", compression positive", "")
        side = "horizontal" if wide > 3 else "vertical"
        colour_bar(figure, image, label, ax=axes, pad=0.02, orientation=side, aspect=40)
        axes.set(xlabel="Distance x [m]", ylabel="Height y [m]", title=_heading(fields, flow, variable))
    return figure


def _heading(fields: xr.Dataset, flow: Flow, what: str) -> str:
    when = f"mean of {fields.attrs['frames']} frames" if "frames" in fields.attrs else f"t = {float(fields.time):.2f} s"
    return f"{flow.title}: {what.replace('_', ' ')}, {when} (kernel reach {fields.attrs['reach']:g} m)"


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


def bed_pressure_chart(fields: xr.Dataset, flow: Flow) -> Chart:
    """Vertical stress at the bed along the channel beside the weight of what lies above."""
    pressure = bed_pressure(fields)
    x, stress, weight = pressure.x.values, pressure.stress.values / 1e3, pressure.hydrostatic.values / 1e3
    lines = (
        Line("contact and kinetic stress at the bed", x, stress),
        Line("hydrostatic: weight above", x, weight, "theory"),
    )
    lowest = min(0.0, float(np.min(stress[np.isfinite(stress)], initial=0.0)))
    panel = Panel("Vertical stress [kPa]", lines, y_limits=(lowest, None))
    return Chart(_heading(fields, flow, "pressure at the bed"), PLACE, (panel,))
