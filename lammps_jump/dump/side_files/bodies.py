# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies against time: ``bodies.csv``, a row a body and window of the probes, or frame where nothing is probed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lammps_jump.dump.tables import read_table
from lammps_jump.errors import DumpError
from lammps_jump.files import BODIES_HEADER, write_text
from lammps_jump.scene.scene import Scene

Row = tuple[int, str, tuple[float, ...]]
"""Step, name, and the numbers of `BodyHistory` behind the time."""


class BodyHistory(NamedTuple):
    """A body against time, arrays of one length.

    Attributes
    ----------
    time : ndarray, s
    x, y : ndarray
        Centre of mass, m.
    angle : ndarray
        Turn since the start, rad.
    vx, vy, spin : ndarray
        m/s, rad/s.
    fx, fy, moment : ndarray
        Of the discs: means over the time up to the row, every step counted, N and N m per metre of width; in the first
        row those of the start. The moment is about the hinge, or the centre of mass.
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    angle: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    spin: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    moment: np.ndarray


def write_bodies(path: Path, scene: Scene, rows: Iterable[Row]) -> None:
    """Write ``bodies.csv``."""
    text = (
        f"{scene.time(step):.10g},{name},{','.join(f'{value:.15g}' for value in values)}\n"
        for step, name, values in rows
    )
    write_text(path, "".join([f"{BODIES_HEADER}\n", *text]))


def read_bodies(path: Path) -> dict[str, BodyHistory]:
    """``bodies.csv`` by body.

    Raises
    ------
    DumpError
        Not there, a wrong header, or a line that is no row of it.
    """
    table = read_table(path)
    if ",".join(table.heads) != BODIES_HEADER:
        raise DumpError(f"{path}, line 1: {','.join(table.heads)[:60]!r}; expected {BODIES_HEADER}.")
    names = np.array([cells[1] for _, cells in table.rows])
    columns = {head: table.numbers(head) for head in table.heads if head != "body"}
    return {
        str(name): BodyHistory(*(column[names == name] for column in columns.values()))
        for name in dict.fromkeys(names.tolist())
    }
