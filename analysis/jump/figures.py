# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the hydraulic jump: its track, its mean shape, its momentum balance, the energy head."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing
from lammps_jump.physics import jump as theory
from lammps_jump.units import numbers_of

from .frame import mean_profile
from .stream import running_median
from .summary import Jump

if TYPE_CHECKING:
    import xarray as xr


def track_figure(jump: Jump) -> Figure | None:
    """Toe, end and equal-mass front against time with the fitted straight motion; None where nothing was tracked."""
    result = jump.measured
    track = result.track
    if track is None or not track.found.any():
        return None
    sign = result.direction
    with drawing(7.2, 3.8) as (figure, axes):
        axes.plot(track.time, sign * track.toe, color=BLUE, lw=1.1, label="toe")
        axes.plot(track.time, sign * track.end, color=GOLD, lw=1.1, ls="--", label="end")
        axes.plot(track.time, sign * track.position, color=BLACK, lw=1.4, ls=":", label="front of equal mass")
        if track.compression is not None and np.isfinite(track.compression).any():
            axes.plot(track.time, sign * track.compression, color=GREY, ls="none", marker=".", ms=2, alpha=0.5)
            line = running_median(track.compression)
            axes.plot(track.time, sign * line, color=GREY, ls="-.", label="front of the compression")
        if result.motion is not None:
            ends = np.array(result.window)
            line = sign * (result.motion.start + result.motion.speed * ends)
            label = f"c = {result.speed:+.3f} ± {result.motion.error:.3f} m/s (fit in the window)"
            axes.plot(ends, line, color=RED, lw=2.2, alpha=0.8, label=label)
        axes.axvspan(*result.window, color="#eeeeee", zorder=0)
        axes.set(xlabel=result.flow.time_axis, ylabel="Distance x [m]", title=f"{result.flow.title}: {result.verdict}")
        axes.legend(fontsize=8)
    return figure


def stream_figure(jump: Jump) -> Figure | None:
    """Momentum flux, thrust and their sum along the stream; what Bélanger makes of its state at each place."""
    stream = jump.measured.stream
    if stream is None:
        return None
    edges = np.append(stream.start, stream.stop[-1])
    with drawing(7.2, 5.0, 2, 1, sharex=True, height_ratios=[1.5, 1]) as (figure, (upper, lower)):
        for values, colour, label in (
            (stream.total, BLACK, "momentum flux + thrust"),
            (stream.momentum_flux, BLUE, "momentum flux ∑ m u²/(ρ L)"),
            (stream.thrust, GOLD, "thrust, contact force/ρ"),
        ):
            if np.isfinite(values).all():
                upper.stairs(values, edges, baseline=None, color=colour, label=label, lw=1.6)
        upper.set(
            ylim=(0, None), ylabel="[m³/s²]", title=f"{jump.measured.flow.scene.name}: the stream before the jump"
        )
        lower.stairs(100 * stream.deviation, edges, baseline=None, color=BLUE, lw=1.6)
        lower.axhline(0, color=GREY, lw=0.8)
        lower.set(xlabel="Distance x [m]", ylabel="y₂ off Bélanger\nof this state [%]")
        for axes in (upper, lower):
            if isfinite(stream.compression):
                axes.axvline(stream.compression, color=GREY, ls="-.", lw=1, label="front of the compression")
        upper.legend(fontsize=8, loc="center left")
    return figure


def frame_figure(jump: Jump) -> Figure | None:
    """Mean depth, velocity and packing in the frame of the front, with Bélanger's depth beside them."""
    result = jump.measured
    if result.moving is None:
        return None
    mean = mean_profile(result.moving)
    xi, depth = mean.xi.values, mean["mass_depth"].values
    covered = xi[np.isfinite(depth)]
    limits = max(result.upstream.zone[0] - 2, covered[0]), min(result.downstream.zone[1] + 2, covered[-1])
    with drawing(7.2, 5.4, 2, 1, sharex=True, height_ratios=[1.8, 1]) as (figure, (upper, lower)):
        upper.plot(xi, mean["surface_depth"], color=BLUE, label="free surface h")
        upper.plot(xi, depth, color=GOLD, ls="--", label="mass depth s")
        for label, value, dash in (
            ("Bélanger, front's frame", jump.belanger_y2, "-"),
            ("with the measured density change", jump.density_relation_ratio * jump.y1, (0, (5, 2, 1, 2))),
        ):
            if value > 0:
                upper.axhline(value, color=BLACK, lw=1, ls=dash, label=f"{label}: {value:.2f} m")
        for state, name in ((result.upstream, "1"), (result.downstream, "2")):
            upper.plot(state.zone, [state.mass_depth.value] * 2, color=RED, lw=4, alpha=0.5, solid_capstyle="butt")
            text = f"s{'₁' if name == '1' else '₂'} = {state.mass_depth.value:.2f} m, Fr = {state.froude_relative:.2f}"
            place = np.mean(state.zone), state.mass_depth.value
            offset = (0, 8 if name == "1" else -32)
            upper.annotate(text, place, offset, ha="center", color=RED, textcoords="offset points", fontsize=8)
        for axes in (upper, lower):
            for place, dash in ((result.surface_toe, ":"), (result.surface_end, "-.")):
                axes.axvline(place, color=GREY, lw=1, ls=dash)
        theory_length = f"; thesis (4.27) {jump.length_theory:.1f} m" if isfinite(jump.length_theory) else ""
        title = f"{result.flow.title}, front's frame: length {jump.length:.1f} m{theory_length}"
        top = 1.1 * max(np.nanmax(depth), np.nan_to_num(jump.belanger_y2))
        upper.set(ylim=(0, top), ylabel="Depth [m]", title=title)
        upper.legend(loc="lower right", frameon=True, framealpha=0.95, edgecolor="none")
        with np.errstate(invalid="ignore", divide="ignore"):
            lower.plot(xi, mean["discharge"] / depth, color=BLUE, label="mean velocity u")
        lower.plot(xi, mean["surface_velocity"], color=GOLD, ls="--", label="at the surface")
        lower.axhline(0, color=GREY, lw=0.8)
        lower.set(xlim=limits, xlabel="Distance from the front [m]", ylabel="Velocity [m/s]")
        lower.legend(loc="upper right")
    return figure


def balance_figure(jump: Jump) -> Figure | None:
    """Terms of the momentum balance across the jump, in per cent of the downstream momentum function."""
    terms = jump.measured.balance
    if terms is None:
        return None
    numbers = [number for number in numbers_of(terms).values() if number.key != "pressure_error"]
    rows = {number.meaning: getattr(terms, number.key) for number in numbers}
    rows = {"Bélanger's balance, 1 − 2": terms.classical, **rows}
    rows = {name: 100 * value for name, value in rows.items() if isfinite(value)}
    with drawing(7.2, 3.4) as (figure, axes):
        places = np.arange(len(rows))[::-1]
        values = np.array(list(rows.values()))
        colours = [GOLD, *[BLUE] * (len(rows) - 2), BLACK]
        axes.barh(places, values, color=colours, height=0.62)
        axes.axvline(0, color=BLACK, lw=0.8)
        span = max(np.abs(values).max(), 1.0)
        axes.set_xlim(-1.35 * span, 1.35 * span)
        for place, value in zip(places, values, strict=True):
            label, side = f"{value:+.1f} %".replace("-", "−"), 1 if value >= 0 else -1
            axes.annotate(label, (value, place), (4 * side, 0), textcoords="offset points", fontsize=8, va="center",
                          ha="left" if side > 0 else "right")  # fmt: skip
        axes.set_yticks(places, rows)
        axes.grid(axis="y", visible=False)
        axes.set(
            xlabel="Share of the downstream momentum function [%]",
            title="Momentum across the jump, front's frame: all parts and their sum",
        )
    return figure


def head_figure(profiles: xr.Dataset, jump: Jump) -> Figure | None:
    """Energy head along the channel, averaged over the window, and its loss against theory."""
    flow = jump.measured.flow
    gravity = -flow.scene.gravity[1]
    if gravity <= 0:
        return None
    x, depth, bed = profiles["x"].values, profiles["mass_depth_mean"].values, profiles["bed"].values
    with np.errstate(invalid="ignore", divide="ignore"):
        discharge = profiles["discharge_mean"].values
        flowing = (depth > 0.5 * flow.scene.diameter) & (np.abs(discharge) > 1e-3 * np.nanmax(np.abs(discharge)))
        kinetic = np.where(flowing, profiles["energy_flux_mean"].values / discharge / gravity, np.nan)
        uniform = np.where(flowing, (discharge / depth) ** 2 / (2 * gravity), np.nan)
    if not flowing.any():
        return None
    with drawing(7.2, 3.8) as (figure, axes):
        axes.plot(x, bed + depth + kinetic, color=BLUE, label="head H = z + s + ∫ρu|v|²/2 / (ρ g q)")
        axes.plot(x, bed + depth + uniform, color=GOLD, ls="--", label="with the mean velocity, z + s + u²/2g")
        axes.plot(x, bed + depth, color=GREY, ls=":", label="z + s (mass depth)")
        if isfinite(jump.y1):
            text = (
                f"front's frame: {jump.head_upstream:.2f} m → {jump.head_downstream:.2f} m,\n"
                f"lost {jump.energy_loss:.2f} m; Bélanger {jump.energy_loss_theory:.2f} m"
            )
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            axes.annotate(text, (0.99, 0.98), xycoords="axes fraction", ha="right", va="top", fontsize=8, color=RED,
                          bbox=box)  # fmt: skip
            for place in (jump.toe, jump.end):
                axes.axvline(place, color=RED, lw=1, ls=":")
        elif jump.inflow:
            head = theory.specific_energy(jump.inflow.depth, jump.inflow.velocity, gravity)
            axes.axhline(head, color=BLACK, lw=1, ls="-.", label=f"inflow {head:.2f} m")
        axes.set_ylim(bottom=min(0.0, np.nanmin(bed)))
        title = f"{flow.title}: energy head, mean of the window (laboratory frame)"
        axes.set(xlabel="Distance x [m]", ylabel="Energy head [m]", title=title)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.12), frameon=True, framealpha=0.95, edgecolor="none")
    return figure
