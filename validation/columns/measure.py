# SPDX-License-Identifier: GPL-2.0-or-later
"""What is left of a column of grains: run-out, top and shape, over the base of the column."""

from __future__ import annotations

import numpy as np

from lammps_jump import Run

LEAST = 1.5
"""Depth in diameters that ends a heap at its front."""


def front_of(x: np.ndarray, depth: np.ndarray, least: float) -> float:
    """Right end of the stretch, from the deepest place on, that is deeper than `least`; m."""
    first = int(np.argmax(depth))
    shallow = np.flatnonzero(depth[first:] < least)
    if not shallow.size:
        return float(x[-1])
    after = first + int(shallow[0])
    if after == 0:
        return float(x[0])
    return float(np.interp(least, [depth[after], depth[after - 1]], [x[after], x[after - 1]]))


def heap(run: Run) -> dict:
    """Run-outs by three fronts, top, shape; lengths over the base of the column."""
    found, rest = run.summary["heap"], run.summary["rest"]
    table = np.genfromtxt(run.folder / "heap.csv", delimiter=",", names=True)
    names = {name.split("_")[0]: name for name in table.dtype.names}
    x, depth = table[names["x"]], table[names["depth"]]
    base, d = found["base"], run.scene.diameter
    return {
        "aspect": found["aspect"],
        "discs": int(run.summary["discs"]["present"]),
        "front": front_of(x, depth, LEAST * d) / base - 1.0,
        "bulk": found["run_out_over_base"],
        "front_99": found["run_out_99_over_base"],
        "top": found["height_over_base"],
        "rest": rest["time"],
        "speed": rest["speed"],
        "x": (x / base)[x >= 0],
        "h": (depth / base)[x >= 0],
    }
