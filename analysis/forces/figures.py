# SPDX-License-Identifier: GPL-2.0-or-later
"""What figures and section of the forces show: history, impulse, reflected wave, each with its estimate beside it."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from lammps_jump.analysis.budgets.inflow import Arrivals
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Line, Map, Panel
from lammps_jump.analysis.draw.depths import xt_map
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.report.page import Section, Table, Text, cut
from lammps_jump.units import numbers_of

from .history import LOW_PASS, Force, Forces, analyse_forces
from .impulse import with_inflow

LOOKS = ("first", "second", "sum", "third", "fit")
"""Of the structures, in turn."""


def analyse(gathered: Gathered) -> Forces | None:
    """Forces of a run; None where nothing was recorded."""
    if not gathered.forces:
        return None
    momentum, arrivals = (gathered.histories.get(name) for name in ("force", "inflow"))
    if isinstance(arrivals, Arrivals):
        momentum = with_inflow(momentum, arrivals, gathered.flow.scene)
    return analyse_forces(gathered.forces, gathered.flow, momentum, gathered.profiles)


def figures(result: Forces, gathered: Gathered) -> Drawings:
    """Figures of the force in time, its impulse, and the reflected wave."""
    return {
        "forces": history_chart(result),
        "impulse": impulse_chart(result),
        "reflected_wave": reflected_map(result, gathered.thinned),
    }


def section(found: Mapping) -> Section:
    """Forces on the probed structures, the impulse identity, the reflected wave; `found` as in ``summary.json``."""
    numbers, keys = numbers_of(Force), ("peak", "peak_time", "impulse", "peak_moment", "hydrostatic", "stagnation")
    scales = {key: 1.0 if key == "peak_time" else 1e3 for key in keys}
    rows = []
    for name, values in found.items():
        if isinstance(values, dict) and "peak" in values:
            row = [None if values.get(key) is None else values[key] / scale for key, scale in scales.items()]
            row[0] = cut(values, "peak", 1e3) if values.get("peak_error") is not None else row[0]
            rows.append((name, *row))
    heads = [f"{numbers[key].label} [{'k' * (scale > 1)}{numbers[key].unit}]" for key, scale in scales.items()]
    notes = [Text(note) for note in found.get("notes") or []]
    return Section("Forces", [Table(rows, ("Structure", *heads)), *notes])


def history_chart(result: Forces) -> Chart | None:
    """Force components against time, one panel a structure: windows of the record in grey, low-passed in colour."""
    panels = [_history_panel(name, force) for name, force in result.shown.items()]
    return Chart("force of the discs", TIME, panels) if panels else None


def _history_panel(name: str, force: Force) -> Panel:
    table = force.table
    time, smooth = table["time"], {key: table[f"{key}_smooth"] / 1e3 for key in ("fx", "fy")}
    lines = [Line("as recorded", time, table[force.component] / 1e3, "faint")]
    for (key, values), look in zip(smooth.items(), LOOKS, strict=False):
        if np.any(np.nan_to_num(values)):
            lines.append(Line(f"{key}, {LOW_PASS:g} s mean", time, values, look))
    if force.component == "fx" and np.isfinite(table["hydrostatic"]).any():
        sign = np.sign(force.peak) or 1.0
        lines.append(Line("hydrostatic, wetted face", time, sign * table["hydrostatic"] / 1e3, "theory"))
        if force.wall.finite:
            lines.append(Line("oncoming, ρsu² + ρgs²/2", time, sign * table["oncoming"] / 1e3, "third"))
    if np.isfinite(force.peak):
        lines.append(Line("peak", np.array([force.peak_time]), np.array([force.peak / 1e3]), "measured"))
    shown = np.concatenate([[0.0], *smooth.values()])
    ends = 1.2 * np.nanmin(shown), max(1.4 * np.nanmax(shown), 1e-9)
    return Panel(f"{name}: force [kN/m]", lines, ylim=ends)


def impulse_chart(result: Forces) -> Chart | None:
    """Running impulse and overturning moment of every structure."""
    if not result.structures:
        return None
    impulses, moments = [], []
    for i, (name, force) in enumerate(result.shown.items()):
        look, table, axis = LOOKS[i % len(LOOKS)], force.table, force.component[1]
        time, moment = table["time"], table["moment_smooth"]
        impulses.append(Line(f"{name}, {force.component}", time, table[f"impulse_{axis}"] / 1e3, look))
        if np.isfinite(moment).any() and force.component == "fx":
            point = "the foot" if force.wall is not None else "its point"
            moments.append(Line(f"{name}, about {point}, anticlockwise", time, moment / 1e3, look))
    panels = [Panel("Running impulse [kN s/m]", impulses)]
    panels += [Panel(f"Moment, {LOW_PASS:g} s mean [kN m/m]", moments)] if moments else []
    return Chart("impulse and overturning moment", TIME, panels)


def reflected_map(result: Forces, profiles: xr.Dataset) -> Map | None:
    """Map of the mass depth with the reflected front and its straight-line fit."""
    wave = result.reflected
    if wave is None or wave.frames < 3:
        return None
    good = np.isfinite(wave.position)
    ends = wave.time[good][[0, -1]]
    label = f"fit {wave.speed:+.2f} m/s; bore theory {wave.bore_speed:+.2f} m/s"
    shown = xt_map(profiles, "mass_depth", title=f"wave thrown back by {wave.structure}")
    front = Line("reflected front", wave.position[good], wave.time[good], "measured")
    return replace(shown, lines=(front, Line(label, wave.start + wave.speed * ends, ends, "theory")))
