# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs at the start: columns with hydrostatic overlaps, lattices, lists; and the closest pair."""

from __future__ import annotations

import numpy as np

from lammps_jump.physics.contact import Coefficients

from .fields import Column, DiscList, Discs, Lattice


def column_counts(column: Column, diameter: float) -> tuple[int, int]:
    """Discs along x and y of a column that fit its rectangle (touching)."""
    slack = 1e-9
    width = (column.x[1] - column.x[0]) / diameter
    height = (column.y[1] - column.y[0]) / diameter
    if column.packing == "hexagonal":
        rows = int((height - 1.0) / (np.sqrt(3.0) / 2.0) + slack) + 1 if height >= 1 - slack else 0
        return int(width - 0.5 + slack), rows
    return int(width + slack), int(height + slack)


def disc_count(item: Column | Lattice | DiscList, diameter: float) -> int:
    """Discs of one item of ``initial``, before any array of them is made."""
    if isinstance(item, Column):
        nx, ny = column_counts(item, diameter)
        return nx * ny
    return item.nx * item.ny if isinstance(item, Lattice) else len(item.positions)


def column_positions(column: Column, discs: Discs, gravity: float, contact: Coefficients) -> np.ndarray:
    """Centres of a column, shape (n, 2), row by row from the bottom.

    With `hydrostatic` and square packing the overlaps of thesis figure 6.2 carry the weight from the first step:
    vertically (discs above) m g / k, horizontally rho g ((n-1) d + d/2) d / k in the n-th row from the top. Against
    floor and back wall they follow from the stiffness of walls. Without overlaps and jitter a square lattice of
    touching frictionless discs never collapses.
    """
    d, radius = discs.diameter, discs.diameter / 2
    nx, ny = column_counts(column, d)
    x0, y0 = column.x[0], column.y[0]
    if column.packing == "hexagonal":
        i, j = np.meshgrid(np.arange(nx), np.arange(ny))
        x = x0 + radius + d * i + radius * (j % 2)
        y = y0 + radius + d * np.sqrt(3.0) / 2.0 * j
        return np.column_stack([x.ravel(), y.ravel()])
    above = ny - 1 - np.arange(ny)  # discs on top of each row
    weight = contact.mass * gravity if column.hydrostatic else 0.0
    vertical = above * weight / contact.stiffness
    bottom = y0 + radius - ny * weight / contact.stiffness_wall
    y_rows = bottom + np.concatenate([[0.0], np.cumsum(d - vertical[:-1])])
    pressure = discs.density * gravity * (above * d + radius) if column.hydrostatic else 0.0 * above
    deepest = max(vertical.max(initial=0.0), pressure.max(initial=0.0) * d / contact.stiffness)
    if deepest > radius:
        raise ValueError(
            f"its own weight would press the discs {deepest:.3g} m into each other; allowed is a radius, {radius:g} m: "
            "raise the stiffness (contact.impact_speed, contact.penetration_fraction), or write hydrostatic: false"
        )
    x_rows = []
    for thrust in pressure * d:
        first = x0 + radius - thrust / contact.stiffness_wall
        x_rows.append(first + np.arange(nx) * (d - thrust / contact.stiffness))
    return np.column_stack([np.concatenate(x_rows), np.repeat(y_rows, nx)])


def arrange(
    item: Column | Lattice | DiscList,
    discs: Discs,
    gravity: float,
    contact: Coefficients,
    random: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities, each of shape (n, 2), of one item of ``initial``.

    Raises
    ------
    ValueError
        Where nothing fits or the velocities do not belong to the discs (the caller adds the place).
    """
    if isinstance(item, Column):
        positions = column_positions(item, discs, gravity, contact)
        if not len(positions):
            raise ValueError(
                f"not one disc of {discs.diameter:g} m fits into x [{item.x[0]:g}, {item.x[1]:g}], "
                f"y [{item.y[0]:g}, {item.y[1]:g}]; make the column wider or higher than one diameter"
            )
        velocities = np.zeros_like(positions)
    elif isinstance(item, Lattice):
        i, j = np.meshgrid(np.arange(item.nx), np.arange(item.ny))
        positions = np.column_stack([i.ravel(), j.ravel()]) * item.spacing + np.array(item.origin)
        velocities = np.tile(np.array(item.velocity, float), (len(positions), 1))
        for number, velocity in item.velocities.items():
            if not 1 <= number <= len(positions):
                raise ValueError(f"velocities names disc {number}; there are discs 1 to {len(positions)}")
            velocities[number - 1] = velocity
    else:
        positions = np.array(item.positions, float).reshape(-1, 2)
        if item.velocities and len(item.velocities) != len(positions):
            raise ValueError(
                f"{len(item.velocities)} velocities for {len(positions)} positions; give one for each, or none"
            )
        velocities = np.array(item.velocities, float) if item.velocities else np.zeros_like(positions)
    if item.jitter:
        positions = positions + random.uniform(-item.jitter, item.jitter, positions.shape) * discs.diameter
    return positions, velocities


def closest_pair(positions: np.ndarray, reach: float) -> tuple[float, int, int] | None:
    """The closest two of `positions` (n, 2) that are nearer than `reach`: (distance, i, j), or None.

    Discs are sorted by cells of side `reach`. Each is compared with its own cell and four of the eight around it. The
    search ends at a pair nearer than a tenth of `reach`: thousands of discs in one cell would take too long.
    """
    if len(positions) < 2:
        return None
    cells = np.floor((positions - positions.min(axis=0)) / reach).astype(np.int64)
    stride = cells[:, 1].max() + 3
    keys = (cells[:, 0] + 1) * stride + cells[:, 1] + 1
    order = np.argsort(keys, kind="stable")
    keys, points = keys[order], positions[order]
    best: tuple[float, int, int] | None = None
    for shift in (0, 1, stride - 1, stride, stride + 1):
        start = np.searchsorted(keys, keys + shift, "left")
        stop = np.searchsorted(keys, keys + shift, "right")
        if shift == 0:
            start = np.arange(len(keys)) + 1
        for offset in range(int(np.max(stop - start, initial=0))):
            mine = np.flatnonzero(start + offset < stop)
            other = start[mine] + offset
            distance = np.hypot(*(points[mine] - points[other]).T)
            least = int(np.argmin(distance))
            if distance[least] < reach and (best is None or distance[least] < best[0]):
                best = (float(distance[least]), int(order[mine[least]]), int(order[other[least]]))
                if best[0] < 0.1 * reach:
                    return best
    return best
