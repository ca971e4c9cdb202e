# SPDX-License-Identifier: GPL-2.0-or-later
"""A column that collapses: its front and height in the numbers of Martin & Moyce, and its impulse on a wall."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lammps_jump import Run
from lammps_jump.analysis.devices.front import dimensionless

GRAVITY = 9.81


def column(run: Run) -> dict:
    """Mean deviation of the front from Martin & Moyce's curve (n² = 2 alone), its slope, and the front Z over T."""
    found = run.summary["front"]["martin_moyce"]
    if found["slope_of_table"] is None or found["slope"] is None:
        raise ValueError(f"the column has n² = {found['aspect']:.2f}; curves are known of 1 and 2")
    told = {key: found[key] for key in ("mean_bulk", "rms_bulk", "rms_height", "aspect", "slope", "slope_of_table")}
    seen = dimensionless(run.front.history, GRAVITY)
    return told | {"T": seen["T"], "Z": seen["Z"]}


def impulse_since(time: np.ndarray, force: np.ndarray, begin: float, seconds: float) -> float:
    """Sum of force times step from `begin` on for so many seconds; N s/m. Each force is the mean of the step before."""
    step = float(np.median(np.diff(time)))
    ends = np.concatenate([[time[0] - step], time])
    summed = np.concatenate([[0.0], np.cumsum(force) * step])
    return float(np.subtract(*np.interp([begin + seconds, begin], ends, summed)))


def arrives(time: np.ndarray, force: np.ndarray, least: float) -> float:
    """First time at which the force is above `least`, s."""
    there = np.flatnonzero(force > least)
    if not there.size:
        raise ValueError("the front does not reach the wall; make run.duration longer")
    return float(time[there[0]])


def wall(run: Run, seconds: float) -> dict:
    """Impulse on the front wall in a time sqrt(H/g) times `seconds` from the arrival, and the balance of momentum.

    The unit is rho H² sqrt(g H) with the depth H of the column at t = 0. Arrival: force of 1 % of rho g H²/2.
    """
    scene, (_, depth) = run.scene, run.front.history.column
    back, front = (run.forces[name].history for name in ("back", "front"))
    after = front.time > 0
    time, pushed, push = front.time[after], np.abs(front.fx[after]), np.abs(back.fx[after])
    weight = 0.5 * scene.density * GRAVITY * depth**2
    arrival, span = arrives(time, pushed, 0.01 * weight), sqrt(depth / GRAVITY)
    unit = scene.density * depth**2 * sqrt(GRAVITY * depth)
    frames = [frame for frame in run.frames() if frame.time >= 0]
    first, last = (float((scene.density * (2 * f.radii) ** 2 * f.vx).sum()) for f in (frames[0], frames[-1]))
    begin, end = frames[0].time, frames[-1].time
    given = impulse_since(time, push, begin, end - begin)
    taken = impulse_since(time, pushed, begin, end - begin)
    return {
        "impulse": impulse_since(time, pushed, arrival, seconds * span) / unit,
        "arrival": arrival / span,
        "left_over": (given - taken - (last - first)) / taken,
        "t": time / span,
        "force": pushed / (2 * weight),
        "depth": depth,
    }
