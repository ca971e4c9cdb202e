# SPDX-License-Identifier: GPL-2.0-or-later
"""A heap under a hopper: angle of its flanks and height."""

from __future__ import annotations

import numpy as np

from lammps_jump import Run


def heap(run: Run) -> dict:
    """Angle of the flanks (degrees), height (m), whether it rests, shape."""
    found, rest = run.summary["heap"], run.summary["rest"]
    table = np.genfromtxt(run.folder / "heap.csv", delimiter=",", names=True)
    return {
        "angle": found["angle"],
        "height": found["height"],
        "rest": rest["time"],
        "speed": rest["speed"],
        "x": table["x"],
        "depth": table["depth"],
    }
