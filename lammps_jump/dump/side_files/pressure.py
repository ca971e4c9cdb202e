# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces on stretches of outlines against time: ``pressure.npz``, of the native engine, every step counted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lammps_jump.errors import DumpError
from lammps_jump.files import read_arrays, write_arrays
from lammps_jump.foreign import foreign
from lammps_jump.scene.scene import Scene


class StretchForces(NamedTuple):
    """Means over windows of steps.

    Attributes
    ----------
    time : ndarray, shape (windows,), s
        Their ends.
    across, along : ndarray, shape (windows, stretches), N/m
        Force of the discs on the wall, into it and along its outline.
    first : ndarray, shape (windows, stretches), N
        Force into it times the place along the outline.
    """

    time: np.ndarray
    across: np.ndarray
    along: np.ndarray
    first: np.ndarray


def write_pressure(path: Path, scene: Scene, rows: Sequence[tuple[int, np.ndarray]]) -> None:
    """Write the steps at which windows end, and the mean sums of their stretches, shape (windows, stretches, 3)."""
    shape = (len(rows), len(scene.pressure), 3)
    write_arrays(
        path,
        steps=np.array([step for step, _ in rows], np.int64),
        means=np.array([row for _, row in rows], float).reshape(shape),
    )


def read_pressure(path: Path, scene: Scene) -> StretchForces:
    """Rows that `write_pressure` wrote.

    Raises
    ------
    DumpError
        Not there, or no such file of this scene.
    """
    with foreign(DumpError, f"{path.name}: cannot be read", "run the case again"):
        found = read_arrays(path)
        steps, means = found["steps"], found["means"]
        if means.shape != (len(steps), len(scene.pressure), 3) or not np.isfinite(means).all():
            raise ValueError("it has other stretches, or numbers that are not finite")
        if (np.diff(steps) <= 0).any():
            raise ValueError("its steps do not grow")
    return StretchForces(np.array([scene.time(step) for step in steps.tolist()]), *np.moveaxis(means, 2, 0))
