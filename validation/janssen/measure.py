# SPDX-License-Identifier: GPL-2.0-or-later
"""Vertical stress over the depth of a bin, and Janssen's length that fits it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from lammps_jump import Run

FULL = 0.5
"""Solid fraction from which on a layer is full."""
ENDS = 3
"""Full layers at the floor and at the surface that are left out."""


def janssen(depth: np.ndarray, length: float) -> np.ndarray:
    """Stress over rho_b g, m: length (1 - exp(-depth/length))."""
    return length * (1.0 - np.exp(-depth / length))


def length_of(depth: np.ndarray, stress: np.ndarray) -> float:
    """Length of `janssen` with the least squares; depth and stress in m."""
    high = 10.0 * float(depth.max())
    found = minimize_scalar(
        lambda log: float(np.sum((janssen(depth, np.exp(log)) - stress) ** 2)),
        bounds=(np.log(0.02 * high / 10), np.log(high)),
        method="bounded",
    )
    return float(np.exp(found.x))


def stresses(run: Run, width: float) -> dict:
    """Depth and vertical stress over rho_b g of the layers, and the fitted length, all over the width of the bin."""
    table = np.genfromtxt(run.folder / "layers.csv", delimiter=",", names=True)
    y, packing, stress = table["y"], table["packing"], table["stress_yy"]
    full = np.flatnonzero(packing > FULL)[ENDS:-ENDS]
    step = float(y[1] - y[0])
    density = run.scene.density * float(packing[full].mean()) * 4 / np.pi  # a disc has the mass rho d^2
    weight = run.scene.density * packing * 4 / np.pi * 9.81 * step
    above = np.array([weight[k + 1 :].sum() + 0.5 * weight[k] for k in full])
    depth, push = above / (density * 9.81), stress[full] / (density * 9.81)
    length = length_of(depth, push)
    off = np.sqrt(np.mean((push - janssen(depth, length)) ** 2))
    return {
        "length": length / width,
        "off": float(off) / length,
        "side": float(np.average(table["stress_xx"][full] / stress[full])),
        "depth": depth / width,
        "stress": push / width,
    }
