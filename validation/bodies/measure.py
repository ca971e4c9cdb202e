# SPDX-License-Identifier: GPL-2.0-or-later
"""What bodies do on slopes, on a hinge and among discs."""

from __future__ import annotations

import numpy as np

from lammps_jump import Run
from lammps_jump.analysis.devices.bodies import around
from lammps_jump.dump.walls import BodyHistory, read_bodies
from lammps_jump.files import BODIES
from lammps_jump.physics.bodies import area_below, pendulum_period
from lammps_jump.runs.results import flow_of


def history_of(run: Run, name: str) -> BodyHistory:
    """A body of a run against time."""
    return read_bodies(run.folder / BODIES)[name]


def floats(run: Run, since: float) -> dict:
    """Mass of the discs that a box displaces over its own, bulk density, and turn in degrees; means from a time on."""
    flow = flow_of(run.case, run.folder)
    (one,) = flow.scene.bodies
    shares, densities, turns = [], [], []
    for frame in run.frames():
        wall = next(wall for wall in flow.walls_at(flow.time(frame)) if wall.name == one.wall.name)
        beside = around(frame, flow, wall)
        if flow.time(frame) >= since and np.isfinite(beside.level):
            outline = np.asarray(wall.outline((-np.inf, np.inf), (-np.inf, np.inf))[0])
            shares.append(beside.density * area_below(outline, beside.level) / one.motion.kind.mass)
            densities.append(beside.density)
            turns.append(np.degrees(wall.pose.angle))
    return {"share": float(np.mean(shares)), "density": float(np.mean(densities)), "turn": float(np.mean(turns))}


def on_a_slope(run: Run) -> dict:
    """Acceleration along the slope over g (m/s^2 over m/s^2), way in the last half over the size, and largest turn."""
    rows = history_of(run, "block")
    late = rows.time >= 0.5 * rows.time[-1]
    fit = np.polyfit(rows.time[late], rows.vx[late], 1)
    return {
        "acceleration": float(fit[0] / 9.81),
        "way": float(np.ptp(rows.x[late])),
        "turn": float(np.degrees(np.abs(rows.angle).max())),
        "moved": float(np.abs(rows.x - rows.x[0]).max()),
    }


def swings(run: Run) -> dict:
    """Period of a block on a hinge over that of the formula."""
    rows = history_of(run, "block")
    (one,) = run.scene.bodies
    kind = one.motion.kind
    zero = np.flatnonzero((rows.angle[:-1] < rows.angle.mean()) & (rows.angle[1:] >= rows.angle.mean()))
    level = rows.angle.mean()
    times = [
        rows.time[i] + (level - rows.angle[i]) / (rows.angle[i + 1] - rows.angle[i]) * (rows.time[i + 1] - rows.time[i])
        for i in zero
    ]
    amplitude = 0.5 * float(np.ptp(rows.angle))
    exact = pendulum_period(kind.mass, kind.inertia_there, float(np.hypot(*kind.arm)), 9.81, amplitude)
    return {"period": float(np.mean(np.diff(times)) / exact), "amplitude": float(np.degrees(amplitude))}
