# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of the hydraulic jump: its track, mean shape, momentum balance, the energy head."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from math import isfinite

import numpy as np

from lammps_jump.analysis.draw.chart import PLACE, Bars, Chart, Panel, Trace, stairs
from lammps_jump.units import numbers_of

from .found import Jump, MeasuredJump, TrackedJump
from .stream import running_median


def track_chart(jump: TrackedJump) -> Chart | None:
    """Toe, end and equal-mass front against time with the fitted straight motion; None where nothing was tracked."""
    track = jump.track
    if track is None or not track.found.any():
        return None
    lines = [
        Trace("toe", track.time, track.toe),
        Trace("end", track.time, track.end, "second"),
        Trace("front of equal mass", track.time, track.position, "sum"),
    ]
    if track.compression is not None and np.isfinite(track.compression).any():
        lines.append(Trace("", track.time, track.compression, "dots"))
        lines.append(Trace("front of the compression", track.time, running_median(track.compression), "third"))
    if isinstance(jump, MeasuredJump):
        ends = np.array(jump.window)
        lines.append(Trace("fit in the window", ends, jump.motion.start + jump.motion.speed * ends, "fit"))
    return Chart(jump.verdict, jump.flow.time_axis, (Panel(PLACE, lines),), jump.window)


def stream_chart(jump: Jump) -> Chart | None:
    """Momentum flux, thrust and their sum along the stream; what Bélanger makes of its state at each place."""
    stream = jump.stream
    if stream is None:
        return None
    edges = np.append(stream.start, stream.stop[-1])
    parts = (
        ("momentum flux + thrust", stream.total, "sum"),
        ("momentum flux ∑ m u²/(ρ L)", stream.momentum_flux, "first"),
        ("thrust, contact force/ρ", stream.thrust, "second"),
    )
    fluxes = [stairs(label, values, edges, look) for label, values, look in parts if np.isfinite(values).all()]
    marks = {"compression": stream.compression} if isfinite(stream.compression) else {}
    off = stairs("y₂ off Bélanger of this state", 100 * stream.deviation, edges)
    panels = (
        Panel("[m³/s²]", fluxes, marks=marks, ylim=(0.0, None), height=1.5),
        Panel("y₂ off Bélanger [%]", [off], marks=marks),
    )
    return Chart("the stream before the jump", PLACE, panels)


def frame_chart(jump: Jump) -> Chart | None:
    """Mean depth, velocity and packing in the frame of the front, with Bélanger's depth beside them."""
    if not isinstance(jump, MeasuredJump):
        return None
    xi, mean = jump.moving.xi, jump.moving.mean
    depth = mean("mass_depth")
    covered = xi[np.isfinite(depth)]
    limits = max(jump.upstream.zone[0] - 2, covered[0]), min(jump.downstream.zone[1] + 2, covered[-1])
    lines = [
        Trace("free surface h", xi, mean("surface_depth")),
        Trace("mass depth s", xi, depth, "second"),
    ]
    for state, name in ((jump.upstream, "s₁"), (jump.downstream, "s₂")):
        lines.append(Trace(name, np.array(state.zone), np.full(2, state.mass_depth), "fit"))
    levels = {f"Bélanger, {jump.of}": jump.belanger_y2} if jump.belanger_y2 > 0 else {}
    marks = {"toe": jump.surface_toe, "end": jump.surface_end}
    top = 1.1 * max(np.nanmax(depth), np.nan_to_num(jump.belanger_y2))
    with np.errstate(invalid="ignore", divide="ignore"):
        speeds = [
            Trace("mean velocity u", xi, mean("discharge") / depth),
            Trace("at the surface", xi, mean("surface_velocity"), "second"),
        ]
    panels = (
        Panel("Depth [m]", lines, "", levels, marks, (), limits, (0.0, top), 1.8),
        Panel("Velocity [m/s]", speeds, marks=marks, xlim=limits),
    )
    return Chart("front's frame", "Distance from the front [m]", panels)


def balance_bars(jump: Jump) -> Bars | None:
    """Terms of the momentum balance across the jump, in per cent of the downstream momentum function."""
    terms = jump.momentum_terms
    if terms is None:
        return None
    numbers = [number for number in numbers_of(terms).values() if number.key != "pressure_error"]
    rows = {"Bélanger's balance, 1 − 2": terms.classical}
    rows |= {number.meaning: getattr(terms, number.key) for number in numbers}
    return Bars(
        "Momentum across the jump, front's frame: all parts and their sum",
        "Share of the downstream momentum function [%]",
        {name: 100 * value for name, value in rows.items() if isfinite(value)},
    )
