# SPDX-License-Identifier: GPL-2.0-or-later
"""What leaves a bin through a slot at y = 0: mass above it over time, its fill and bulk density."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lammps_jump import Run

BULK = (10.0, 30.0)
"""Heights between which the bulk density is taken, diameters."""


def discharge(time: np.ndarray, mass: np.ndarray, low: float, high: float) -> float:
    """Mass lost in a second between two times, a straight line."""
    chosen = (time >= low) & (time <= high)
    return -float(np.polyfit(time[chosen], mass[chosen], 1)[0])


def empties(run: Run, width: float, begin: float) -> dict:
    """Mass above the slot and fill over bin width, over time; bulk density; outflow W / (rho_b sqrt(g) d^1.5)."""
    scene = run.scene
    d, rho = scene.diameter, scene.density
    time, mass, fill, bulk = [], [], [], []
    for frame in run.frames():
        above = frame.y > 0
        masses = rho * (2 * frame.radii) ** 2
        inside = (frame.y > BULK[0] * d) & (frame.y < BULK[1] * d)
        time.append(frame.time)
        mass.append(float(masses[above].sum()))
        fill.append(2 * float(frame.y[above].mean()) / width)
        bulk.append(float(masses[inside].sum()) / ((BULK[1] - BULK[0]) * d * width))
    t, m, level, density = (np.array(values) for values in (time, mass, fill, bulk))
    later = t >= begin
    rho_b = float(density[later].mean())
    unit = rho_b * sqrt(9.81) * d**1.5
    return {
        "outflow": discharge(t, m, begin, t[-1]) / unit,
        "bulk": rho_b / rho,
        "fill": [float(level[later][0]), float(level[-1])],
        "time": t,
        "level": level,
        "mass": m / unit,
    }
