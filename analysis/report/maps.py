# SPDX-License-Identifier: GPL-2.0-or-later
"""Maps of a frame for the page: packing and contact pressure on a grid over the domain, as small whole numbers."""

from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import find_contacts
from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame
from lammps_jump.physics.jump import GRAVITY

CELL = 4
"""Diameters of a cell: a mean over some 14 discs, in which a single collision does not stand out."""
FINEST = 200
"""Cells along a side at most: five pixels of a page each."""
PACKING_STEP = 1 / 32
"""Of the share of area that discs cover."""
PRESSURE_STEP = 1 / 8
"""Of the pressure under one diameter of the discs' material."""


def packing(frame: Frame, flow: Flow) -> np.ndarray:
    """Share of area that discs cover over `PACKING_STEP`, shape (cells,), row by row from below."""
    return _numbers(flow, frame.x, frame.y, np.pi * flow.radii(frame) ** 2 / PACKING_STEP)


def pressure(frame: Frame, flow: Flow) -> np.ndarray:
    """Root of the contact pressure over its unit, shape (cells,): low pressures are told apart.

    The pressure is the mean of both normal stresses: over the contacts of a cell the sum of force times length between
    the centres, or from centre to wall, over twice the area (Love, 1927; Weber, 1966).
    """
    found = find_contacts(frame, flow)
    moment = found.force * np.hypot(*(found.end - found.start).T) / 2
    x, y = (found.start + found.end).T / 2
    return _numbers(flow, x, y, moment / pressure_unit(flow), 0.5)


def about_map(flow: Flow, many: bool) -> dict[str, Any]:
    """Name and grid of the packing, of many discs, or the pressure; a value is unit times number to the power."""
    counts, sides = grid(flow)
    name, unit, power = ("packing", PACKING_STEP, 1) if many else ("pressure", pressure_unit(flow), 2)
    low = [low for low, _ in flow.scene.domain]
    return {"name": name, "unit": unit, "power": power, "low": low, "counts": counts, "sides": sides}


def pressure_unit(flow: Flow) -> float:
    """Pressure of the number 1, Pa."""
    return PRESSURE_STEP * flow.scene.density * (flow.g or GRAVITY) * flow.scene.diameter


def grid(flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of cells; their width and height, m."""
    sides = np.ptp(flow.scene.domain, axis=1)
    counts = np.clip(np.ceil(sides / (CELL * flow.scene.diameter)), 1, FINEST).astype(int)
    return counts, sides / counts


def _numbers(flow: Flow, x: np.ndarray, y: np.ndarray, values: np.ndarray, power: float = 1.0) -> np.ndarray:
    """Power of the sum of values at places (m) over the area of their cells, as whole numbers up to 255."""
    counts, sides = grid(flow)
    low = np.array(flow.scene.domain)[:, 0]
    column, row = np.floor((np.column_stack([x, y]) - low) / sides).T
    inside = (column >= 0) & (column < counts[0]) & (row >= 0) & (row < counts[1])
    cell = (row * counts[0] + column)[inside].astype(int)
    sums = np.bincount(cell, values[inside], counts.prod()) / sides.prod()
    return np.rint(np.clip(sums, 0, None) ** power).clip(max=255).astype("u1")
