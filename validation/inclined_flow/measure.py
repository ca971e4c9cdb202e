# SPDX-License-Identifier: GPL-2.0-or-later
"""A steady layer on a slope: velocity, inertial number, friction and packing of its inner layers."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lammps_jump import Run

BOTTOM, TOP = 3.0, 3.0
"""Diameters next to the bed, and below the surface, that are left out: the bed orders discs, the surface is loose."""
DENSE = 0.5
"""Solid fraction that ends the layer at its surface."""


def surface_of(y: np.ndarray, packing: np.ndarray) -> float:
    """Height at which the solid fraction falls below `DENSE`, seen from the densest layer; m."""
    first = int(np.argmax(packing))
    thin = np.flatnonzero(packing[first:] < DENSE)
    if not thin.size:
        return float(y[-1])
    after = first + int(thin[0])
    return float(np.interp(DENSE, [packing[after], packing[after - 1]], [y[after], y[after - 1]]))


def layer(run: Run) -> dict:
    """Thickness over d; mean velocity over sqrt(g d); inner means of I, mu and packing; profiles over height."""
    d, g = run.scene.diameter, 9.81
    table = np.genfromtxt(run.folder / "layers.csv", delimiter=",", names=True)
    y, packing = table["y"], table["packing"]
    surface = surface_of(y, packing)
    bed = float(y[0]) - 0.5 * (float(y[1]) - float(y[0]))
    inner = (y > bed + BOTTOM * d) & (y < surface - TOP * d)
    weight = table["stress_yy"][inner]
    inertial, friction = table["inertial_number"][inner], table["friction"][inner]
    flows = bool(inner.sum() >= 3)
    speeds = [float(np.mean(frame.vx)) for frame in run.frames()]
    late = np.array(speeds[-max(8, len(speeds) // 3) :])
    half = len(late) // 2
    return {
        "thickness": (surface - bed) / d,
        "velocity": float(late.mean()) / sqrt(g * d),
        "drift": float(late[half:].mean() / late[:half].mean() - 1) if late.mean() > 1e-6 else 0.0,
        "inertial": float(np.average(inertial, weights=weight)) if flows else None,
        "spread": float(np.std(inertial) / np.mean(inertial)) if flows else None,
        "friction": float(np.average(friction, weights=weight)) if flows else None,
        "packing": float(packing[inner].mean()) if flows else None,
        "y": (y - bed) / d,
        "u": table["velocity"] / sqrt(g * d),
        "i": table["inertial_number"],
        "surface": (surface - bed) / d,
    }
