# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump of grains on a chute: its front, the zone at rest before the sill, and the balance of momentum."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from lammps_jump import Run

SECTIONS = (2.0, 22.8)
"""Ends of the control volume along x, m: behind the inlet, and where the discs fall off the sill."""
BAND = 0.4
"""Width of a section that discs are counted in, m."""
BIN, LAYER = 0.2, 0.45
"""Bins along x, and depth of the layer on the bed that is looked at, m."""
AT_REST = 0.05
"""Share of the speed of the jet below which the layer is at rest."""


def chute(run: Run) -> dict:
    """Numbers of the window of the analysis.

    Momentum: what flows in, its thrust, the weight along the slope, less the forces on bed and sill, less what flows
    out, less the growth in the volume; as a share of what flows in.
    """
    found, scene, case = run.summary["jump"], run.scene, run.case.fields
    if found["verdict"] != "jump":
        raise ValueError(f"no jump: {found['verdict']}, {found.get('reason')}")
    begin, end = case.analysis.window
    slope, density = radians(case.slope), case.discs.density
    edges = np.arange(0.0, 22.0 + 0.5 * BIN, BIN)
    mass, low_mass, low_push = (np.zeros(len(edges) - 1) for _ in range(3))
    times, inside, weights, fluxes = [], [], [], []
    for frame in run.frames():
        if not begin <= frame.time <= end:
            continue
        x, y, vx = frame.column("x"), frame.column("y"), frame.column("vx")
        m = density * (2 * frame.column("radius")) ** 2
        mass += np.histogram(x, edges, weights=m)[0]
        low = y < LAYER
        low_mass += np.histogram(x[low], edges, weights=m[low])[0]
        low_push += np.histogram(x[low], edges, weights=(m * vx)[low])[0]
        held = (x > SECTIONS[0]) & (x < SECTIONS[1])
        times.append(frame.time)
        inside.append(float(np.sum((m * vx)[held])))
        weights.append(float(np.sum(m[held])))
        fluxes.append([float(np.sum((m * vx * vx)[np.abs(x - at) < 0.5 * BAND])) / BAND for at in SECTIONS])
    flux_in, flux_out = np.mean(fluxes, axis=0)
    local = found["local"]
    gravity = case.gravity
    thrust = 0.5 * local["pressure_coefficient_1"] * density * gravity * cos(slope) * local["y1"] * local["h1"]
    push = {name: force.mean_fx for name, force in run.forces.items()}
    growth = (inside[-1] - inside[0]) / (times[-1] - times[0])
    weight = float(np.mean(weights)) * gravity * sin(slope)
    left = flux_in + thrust + weight - push["bed"] - push["sill"] - flux_out - growth
    return {
        "froude": found["froude"],
        "speed": found["speed"],
        "belanger_deviation": found["belanger_deviation"],
        "sequent": found["y2"] / found["y1"],
        "relation": local["sequent_ratio"] / local["full_relation_ratio"] - 1,
        "presses": local["pressure_coefficient_2"],
        "front": _rise(edges, mass / (len(times) * BIN * density), found["y1"]),
        "rest": _length_at_rest(low_push, low_mass, scene),
        "weight": weight / float(flux_in),
        "bed": push["bed"] / float(flux_in),
        "left": float(left / flux_in),
        "x": (0.5 * (edges[1:] + edges[:-1])).tolist(),
        "depth": (mass / (len(times) * BIN * density)).tolist(),
    }


def _rise(edges: np.ndarray, depth: np.ndarray, before: float) -> float:
    """Way over which the depth rises from 10 to 90 % of the way to its highest place, m."""
    middle = 0.5 * (edges[1:] + edges[:-1])
    level = (depth - before) / (depth.max() - before)
    first = int(np.argmax(level > 0.9))
    last = int(np.flatnonzero(level[:first] < 0.1)[-1])
    rising = np.maximum.accumulate(level[last : first + 1])
    begin, end = np.interp((0.1, 0.9), rising, middle[last : first + 1])
    return float(end - begin)


def _length_at_rest(push: np.ndarray, mass: np.ndarray, scene) -> float:
    """Length of the layer on the bed that is at rest, counted from the sill upstream, m."""
    jet = float(np.hypot(*scene.velocities[0]))
    slow = np.divide(push, mass, out=np.zeros_like(push), where=mass > 0) < AT_REST * jet
    moving = np.flatnonzero(~slow[::-1])
    return BIN * float(moving[0] if len(moving) else len(slow))
