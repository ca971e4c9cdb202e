# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of an inflow to the scene: their heights, speeds and steps; refused where the discs do not suit it."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from lammps_jump.case.checks import MOST_STEPS
from lammps_jump.errors import FieldError
from lammps_jump.physics.inlet import (
    COARSEST_RASTER,
    Hydrograph,
    RowPlan,
    entries_of_rows,
    plan_rows,
    row_count,
    seed_factors,
    seeded_speeds,
    thesis_rows,
)
from lammps_jump.scene import Beginning, InletRow, Plane

from .inflow import RowsInflow

INLET_WALL = "inlet_back"
INLET_CLEARANCE = 0.51
"""Distance from the inlet to the wall behind it, in largest diameters: a disc that enters does not touch the wall."""
MOST_ROWS = 10_000
"""Rows of an inflow; each is a fix of LAMMPS."""
MOST_ENTRIES = 5_000_000
"""Discs that an inflow against time brings: the scene holds the step of each."""
CLEARANCE = 0.999
"""Distance to the next disc below which a place is occupied, in largest diameters."""


class Inlet(NamedTuple):
    """Rows of an inflow, the raster of their steps, and the table where they change with time."""

    rows: tuple[InletRow, ...] = ()
    raster: int = 1
    hydrograph: Hydrograph | None = None


def inlet_of(inflow: RowsInflow, begun: Beginning, seed: int) -> Inlet:
    """The inlet of an inflow by rows.

    Raises
    ------
    FieldError
        No row, too many of them, rows too slow, a schedule that sizes do not have.
    """
    _require_rows(inflow, begun)
    if inflow.table is not None:
        return Inlet(_rows_against_time(inflow, begun, seed), 1, inflow.hydrograph)
    plan = _plan(inflow, begun)
    first = (begun.settle_steps // plan.raster + 1) * plan.raster
    rows = zip(plan.heights, seeded_speeds(plan.speeds, seed), plan.steps, strict=True)
    return Inlet(
        tuple(
            InletRow(inflow.x, inflow.y + height, speed, 0.0, first, steps, CLEARANCE * begun.largest)
            for height, speed, steps in rows
        ),
        plan.raster,
    )


def _require_rows(inflow: RowsInflow, begun: Beginning) -> None:
    """FieldError where the largest depth holds no row, or too many."""
    d, depth = begun.diameter, max(inflow.hydrograph.depths)
    field = "depth" if inflow.table is None else "table"
    if depth < d * (1 - 1e-9):
        raise FieldError(
            f"inflow.{field}",
            f"{depth:zg} m holds no row of discs of {d:zg} m; allowed is one diameter or more: take "
            'smaller discs (numbers are in m; text may have a unit, "100 mm") or a deeper inflow',
        )
    count = _count(inflow, begun)
    if count > MOST_ROWS:
        raise FieldError(
            f"inflow.{field}",
            f"{depth:zg} m holds {count} rows of discs of {d:zg} m; allowed are {MOST_ROWS}: take larger discs",
        )


def _count(inflow: RowsInflow, begun: Beginning) -> int:
    """Rows of the largest depth."""
    graph = inflow.hydrograph
    return row_count(max(graph.depths), begun.mean_square, begun.largest, graph.least_gap(inflow.spacing))


def _plan(inflow: RowsInflow, begun: Beginning) -> RowPlan:
    """Heights, speeds and steps of rows that do not change with time; FieldError where they are too slow."""
    graph, dt = inflow.hydrograph, begun.time_step
    depth, speed = graph.depths[0], graph.speeds[0]
    slowest = _count(inflow, begun) * begun.mean_square / (depth * speed * dt)
    if slowest > MOST_STEPS:
        raise FieldError(
            f"inflow.{'mean_speed' if inflow.discharge is None else 'discharge'}",
            f"{speed:zg} m/s lets a disc in every "
            f"{slowest:z.3g} steps; allowed are {MOST_STEPS:z.0e}: raise it or lower the stiffness",
        )
    if inflow.schedule == "thesis":
        if begun.sizes:
            raise FieldError(
                "inflow.schedule", "'thesis' is for equal discs; allowed is exact where discs.sizes is given"
            )
        return thesis_rows(depth, begun.diameter, speed, dt, profile=inflow.profile)
    return plan_rows(
        depth,
        speed,
        dt,
        mean_square=begun.mean_square,
        largest=begun.largest,
        profile=inflow.profile,
        least_gap=inflow.spacing,
        coarsest=COARSEST_RASTER if begun.sizes else 1,
    )


def inlet_back(inflow: object, largest: float) -> tuple[Plane, ...]:
    """The wall behind a jet: without it a drowned inlet pushes discs upstream, out of the domain."""
    if not isinstance(inflow, RowsInflow) or inflow.back == "open":
        return ()
    return (Plane(INLET_WALL, "x", inflow.x - INLET_CLEARANCE * largest, "above"),)


def _rows_against_time(inflow: RowsInflow, begun: Beginning, seed: int) -> tuple[InletRow, ...]:
    """Rows with the step and the speed of each disc; those that let none in during the run are left out."""
    graph, dt, settle = inflow.hydrograph, begun.time_step, begun.settle_steps
    duration = (begun.steps - settle) * dt
    brought = duration * graph.means(0.0, duration)[1] / begun.mean_square
    if brought > MOST_ENTRIES:
        raise FieldError(
            "inflow.table",
            f"lets {brought:z.3g} discs in during the run; allowed are {MOST_ENTRIES:z.0e}: take larger "
            "discs or a shorter run",
        )
    entries = entries_of_rows(
        graph,
        duration,
        mean_square=begun.mean_square,
        largest=begun.largest,
        profile=inflow.profile,
        least_gap=inflow.spacing,
    )
    found = []
    for i, (one, factor) in enumerate(zip(entries, seed_factors(len(entries), seed), strict=True)):
        steps = settle + np.maximum(1, np.ceil(one.times / dt - 1e-9).astype(np.int64))
        steps, kept = np.unique(np.minimum(steps, begun.steps), return_index=True)
        if not len(steps):
            continue
        speeds = graph.speed((steps - settle) * dt) * one.relative[kept] * factor
        every = max(1, ceil((begun.steps - settle) / len(steps)))
        height = inflow.y + (i + 0.5) * begun.largest
        found.append(
            InletRow(
                inflow.x, height, float(speeds.max()), 0.0, int(steps[0]), every, CLEARANCE * begun.largest,
                turns=tuple(steps.tolist()), speeds=tuple(speeds.tolist()),
            )
        )  # fmt: skip
    return tuple(found)
