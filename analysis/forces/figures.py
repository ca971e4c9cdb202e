# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the forces: history, impulse, reflected wave, each with its estimate beside it; and their section."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, DASHES, GOLD, GREY, RED, drawing, style, xt_map
from lammps_jump.analysis.passes import Drawings, Gathered
from lammps_jump.analysis.report.page import Section, Table, Text, with_error
from lammps_jump.units import numbers_of

from .history import LOW_PASS, Force, Forces, analyse_forces

if TYPE_CHECKING:
    import xarray as xr

COLOURS = (BLUE, GOLD, BLACK, GREY, RED)


def analyse(gathered: Gathered) -> Forces | None:
    """Forces of a run; None where nothing was recorded."""
    if not gathered.forces:
        return None
    return analyse_forces(gathered.forces, gathered.flow, gathered.histories.get("force"), gathered.profiles)


def figures(result: Forces, gathered: Gathered) -> Drawings:
    """Figures of the force in time, its impulse, and the reflected wave."""
    return {
        "forces.png": partial(history_figure, result),
        "impulse.png": partial(impulse_figure, result),
        "reflected_wave.png": partial(reflected_figure, result, gathered.thinned),
    }


def section(found: Mapping) -> Section:
    """Forces on the probed structures, the impulse identity, the reflected wave; `found` as in ``summary.json``."""
    numbers, keys = numbers_of(Force), ("peak", "peak_time", "impulse", "peak_moment", "hydrostatic", "stagnation")
    scales = [1.0 if key == "peak_time" else 1e3 for key in keys]
    rows = []
    for name, values in found.items():
        if isinstance(values, dict) and "peak" in values:
            known = [values.get(key) for key in keys]
            row = [None if v is None else v / scale for v, scale in zip(known, scales, strict=True)]
            if values.get("peak_error") is not None:
                row[0] = with_error(values, "peak", 1e3)
            rows.append((name, *row))
    units = [numbers[key].unit if key == "peak_time" else f"k{numbers[key].unit}" for key in keys]
    heads = [f"{numbers[key].label} [{unit}]" for key, unit in zip(keys, units, strict=True)]
    sure = Text(
        "Means and sums over every step. ± is within this run; one run has no error for a number without: repeat it "
        "from other starts."
    )
    notes = [sure, *(Text(note) for note in found.get("notes") or [])]
    return Section("Forces", [Table(rows, ("Structure", *heads)), *notes])


def history_figure(result: Forces) -> Figure | None:
    """Force components against time, one row a structure: windows of the record in grey, low-passed in colour."""
    if not result.structures:
        return None
    rows = len(result.structures)
    with drawing(7.6, 1.1 + 2.3 * rows, rows, 1, sharex=True, squeeze=False) as (figure, grid):
        for axes, (name, force) in zip(grid[:, 0], result.structures.items(), strict=True):
            time, series = force.history.time, force.series
            axes.plot(time, getattr(force.history, force.component) / 1e3, color="#c9c9c9", lw=0.6, label="as recorded")
            for key, colour, dash in (("fx", BLUE, "-"), ("fy", GOLD, "--")):
                if np.any(series.smooth[key]):
                    axes.plot(
                        time, series.smooth[key] / 1e3, color=colour, ls=dash, label=f"{key}, {LOW_PASS:g} s mean"
                    )
            if force.component == "fx" and np.isfinite(series.hydrostatic).any():
                sign = np.sign(force.peak) or 1.0
                axes.plot(time, sign * series.hydrostatic / 1e3, color=BLACK, lw=1, ls=":", label="hydrostatic, ρgh²/2")
                if series.wall.finite:
                    axes.plot(
                        time, sign * series.oncoming / 1e3, color=GREY, lw=1, ls="-.", label="oncoming, ρhu² + ρgh²/2"
                    )
            if np.isfinite(force.peak):
                axes.plot(force.peak_time, force.peak / 1e3, "o", mfc="white", mec=RED, ms=6)
                label = f"{force.peak / 1e3:.0f} kN/m".replace("-", "−")
                axes.annotate(label, (force.peak_time, force.peak / 1e3), (8, 0), color=RED, fontsize=8,
                              textcoords="offset points", va="center")  # fmt: skip
            shown = np.concatenate([[0.0], *(series.smooth[key] / 1e3 for key in ("fx", "fy"))])
            axes.set_ylim(1.2 * shown.min(), max(1.4 * shown.max(), 1e-9))
            axes.axhline(0, color=GREY, lw=0.8)
            axes.set(ylabel="Force [kN/m]", title=f"{name}: force of the discs")
            axes.legend(ncols=2, fontsize=7)
        grid[-1, 0].set_xlabel("Time t [s]")
    return figure


def impulse_figure(result: Forces) -> Figure | None:
    """Running impulse and overturning moment of every structure."""
    if not result.structures:
        return None
    with drawing(8.4, 3.6, 1, 2) as (figure, (left, right)):
        for i, (name, force) in enumerate(result.structures.items()):
            colour, dash = COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)]
            column = 0 if force.component == "fx" else 1
            label = f"{name}, {force.component}"
            left.plot(force.history.time, force.series.impulse[:, column] / 1e3, color=colour, ls=dash, label=label)
            if np.isfinite(force.series.smooth["moment"]).any() and force.component == "fx":
                right.plot(force.history.time, force.series.smooth["moment"] / 1e3, color=colour, ls=dash, label=name)
        for axes in (left, right):
            axes.axhline(0, color=GREY, lw=0.8)
            axes.set_xlabel("Time t [s]")
            if axes.get_legend_handles_labels()[0]:
                axes.legend()
        left.set(ylabel="Running impulse [kN s/m]", title="Impulse")
        right.set(
            ylabel=f"Overturning moment, {LOW_PASS:g} s mean [kN m/m]",
            title="Moment about the foot at the bed, anticlockwise",
        )
    return figure


def reflected_figure(result: Forces, profiles: xr.Dataset) -> Figure | None:
    """Map of the mass depth with the reflected front and its straight-line fit."""
    wave = result.reflected
    if wave is None or wave.motion.points < 3:
        return None
    good = np.isfinite(wave.position)
    figure = xt_map(profiles, "mass_depth", title=f"{result.flow.title}: wave thrown back by {wave.structure}")
    axes = figure.axes[0]
    with style():
        axes.plot(wave.position[good], wave.time[good], "o", mfc="white", mec=BLACK, ms=3, label="reflected front")
        ends = wave.time[good][[0, -1]]
        line = wave.motion.start + wave.motion.speed * ends
        label = f"fit {wave.motion.speed:+.2f} ± {wave.motion.error:.2f} m/s; bore theory {wave.bore_speed:+.2f} m/s"
        axes.plot(line, ends, color=RED, lw=1.8, ls="--", label=label)
        axes.set_xlim(right=float(result.structures[wave.structure].series.wall.extent[0][1]) + 1)
        axes.legend(loc="upper left", frameon=True, framealpha=0.9)
    return figure
