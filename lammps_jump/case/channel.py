# SPDX-License-Identifier: GPL-2.0-or-later
"""Domain of a scene with its outlets, its largest speed and the rows of its inflow; limits of a periodic channel."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite, sqrt
from typing import NamedTuple

import numpy as np

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
from lammps_jump.scene import InitialState, InletRow, Interval, MovingWall, Outlet, Plane
from lammps_jump.scene.motion import at_seam, largest_speed, way

from . import checks, live, walls
from .checks import MOST_STEPS
from .discs import Column
from .fields import CaseFields
from .inflow import PourInflow, RowsInflow

MAX_SPEED_MARGIN = 2.0
"""Ratio of the speed at which a disc could jump over an outlet to the largest speed that the case implies."""
Rectangle = tuple[Interval, Interval]
"""Lowest and highest x and y, m."""


def implied_speed(
    case: CaseFields, begun: InitialState, inlets: tuple[InletRow, ...], moving: list[MovingWall], impact: float
) -> float:
    """Largest speed that the case implies, m/s: at the start, at the inlet, of an impact, of a column's fall, of walls.

    `impact` is that for which the contact is made.
    """
    columns = [item.y[1] - item.y[0] for item in case.initial if isinstance(item, Column)]
    falls = [sqrt(2 * case.gravity * height) for height in columns]
    start = float(np.hypot(*begun.velocities.T).max(initial=0.0))
    driven = [largest_speed(one, *walls.span(begun)) for one in moving]
    driven += live.speeds(case, moving)
    return max([*(row.vx for row in inlets), impact, start, *falls, *driven])


def domain_of(
    case: CaseFields, begun: InitialState, inlets: tuple[InletRow, ...], moving: list[MovingWall], speed: float
) -> Rectangle:
    """The given domain, or one around all that the case names, and the ways of walls."""
    if case.domain is not None:
        domain = case.domain.x, case.domain.y
    else:
        ways = [*(way(one, *walls.span(begun)) for one in moving), *live.ways(case, moving)]
        closed = any(wall.hollow for wall in case.walls)
        margin = 2 * begun.largest if closed else 10 * begun.largest + speed * min(case.run.duration, 3.0)
        x, y = ((min(e) - margin, max(e) + margin) for e in (_ends(case, axis, begun, inlets, ways) for axis in "xy"))
        domain = x, y
    checks.check_domain(case, domain)
    return domain


def _ends(
    case: CaseFields, axis: str, begun: InitialState, inlets: tuple[InletRow, ...], ways: list[Rectangle]
) -> list[float]:
    """Coordinates that a domain must hold, m."""
    index = "xy".index(axis)
    values = [*begun.positions[:, index], *(getattr(row, axis) for row in inlets)]
    if isinstance(case.inflow, PourInflow):
        values += getattr(case.inflow, axis)
    values += [end for box in ways for end in box[index] if isfinite(end)]
    outlets = (pair for item in case.outflow for pair in item.model_dump(exclude_none=True).items())
    return values + [at for name, at in outlets if name.startswith(axis)]


def outlets_of(case: CaseFields, begun: InitialState, domain: Rectangle, speed: float) -> tuple[Outlet, ...]:
    """The lines beyond which discs are removed, each looked at before a disc can jump to the edge of the domain.

    Raises
    ------
    FieldError
        A line without room before the edge.
    """
    outlets = []
    for index, item in enumerate(case.outflow):
        ((field, at),) = item.model_dump(exclude_none=True).items()
        axis = field[0]
        side = "above" if field in ("x_beyond", "y_above") else "below"
        low, high = domain[0 if axis == "x" else 1]
        room = high - at if side == "above" else at - low
        if room <= begun.largest:
            raise FieldError(
                f"outflow.{index}.{field}",
                f"{at:zg} m leaves no room before the edge of the domain ([{low:zg}, "
                f"{high:zg}]); discs need a few metres to be taken out in: widen domain or move the outlet",
            )
        every = max(1, min(begun.output_steps, int(room / (MAX_SPEED_MARGIN * speed * begun.time_step))))
        outlets.append(Outlet(axis, at, side, every))
    return tuple(outlets)


SHORTEST = 5.0
"""Least length of a periodic channel, in largest diameters: no disc may meet another on both sides."""
LOOKS = 9, 400
"""Points across the seam and over the height at which walls on both sides of it are compared."""
SAME = 1e-9
"""Largest difference of their distances, in diameters."""


def check_fields(case: CaseFields) -> None:
    """Refuses what is given in the case and has no meaning where x is periodic."""
    if case.domain is None or case.domain.periodic is None:
        return
    refused = {
        "bodies": (case.bodies, "what touches them is not looked for across the seam"),
        "inflow": (case.inflow, "discs that leave at one end enter at the other, so that nothing flows in"),
        "probes.stations": (case.probes.stations, "stations look at a flow from one end to the other"),
        "analysis.jump": (case.analysis.jump, "a jump needs a stream and a tail water, with ends"),
        "analysis.front": (case.analysis.front, "a front would meet its own tail"),
        "analysis.energy": (case.analysis.energy, "it counts what flows in and out; the run's energy ledger has all"),
    }
    for field, (value, reason) in refused.items():
        if value:
            raise FieldError(field, f"is not there with domain.periodic: x: {reason}; drop one of the two")
    for index, outlet in enumerate(case.outflow):
        if outlet.x_beyond is not None or outlet.x_before is not None:
            raise FieldError(
                f"outflow.{index}", "is not there along x with domain.periodic: x; allowed are y_below and y_above"
            )
    for index, item in enumerate(case.initial):
        if isinstance(item, Column) and item.gate and (item.settle or item.gate is not True):
            raise FieldError(
                f"initial.{index}.gate", "a column in a periodic channel has no gate; set gate: false, and no settle"
            )


def check_walls(
    begun: InitialState, walls: Sequence[MovingWall], fields: dict[str, str],
    domain: tuple[Interval, Interval],
) -> None:  # fmt: skip
    """Refuse a channel that is too short, and walls that are not the same on both sides of the seam."""
    (low, high), (bottom, top) = domain
    period, d = high - low, begun.largest
    if period < SHORTEST * d:
        raise FieldError(
            "domain.x",
            f"a periodic channel of {period:zg} m is too short for discs of {d:zg} m; allowed is "
            f"{SHORTEST * d:zg} m or more",
        )
    aside = np.linspace(-d, d, LOOKS[0])
    x, y = (part.ravel() for part in np.meshgrid(aside, np.linspace(bottom, top, LOOKS[1])))
    for one in walls:
        wall, field = one.wall, fields.get(one.wall.name, "walls")
        if one.motion.kind is not None:
            along, _ = way(one, begun.time(0), begun.time(begun.steps))
            if wrong := at_seam(wall.name, along, domain[0], d):
                raise FieldError(f"{field}.motion", f"{wrong}")
            continue
        left, right = wall.distance(low + x, y), wall.distance(high + x, y)
        felt = np.minimum(left, right) < d / 2
        if (np.abs(left - right)[felt] > SAME * d).any():
            raise FieldError(
                field,
                f"wall '{wall.name}' is not the same at both ends of the periodic channel, x = {low:zg} and "
                f"{high:zg} m; let it end {d:zg} m before them, or reach {d:zg} m or more beyond both at one height",
            )


def lid_doubts(walls: Sequence[MovingWall], domain: tuple[Interval, Interval], largest: float) -> list[str]:
    """Sentences on walls that discs may push to the seam: where they go is not known before the run."""
    low, high = domain[0]
    return [
        f"discs may push wall '{wall.name}' along x to the seam of the periodic channel: the run ends where it "
        f"leaves x = {low + largest:zg} to {high - largest:zg} m; with motion.axis: y it stays away from it"
        for wall, motion in walls
        if motion.load is not None and motion.load.axis != "y"
    ]


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


def inlet_of(inflow: RowsInflow, begun: InitialState, seed: int) -> Inlet:
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


def _require_rows(inflow: RowsInflow, begun: InitialState) -> None:
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


def _count(inflow: RowsInflow, begun: InitialState) -> int:
    """Rows of the largest depth."""
    graph = inflow.hydrograph
    return row_count(max(graph.depths), begun.mean_square, begun.largest, graph.least_gap(inflow.spacing))


def _plan(inflow: RowsInflow, begun: InitialState) -> RowPlan:
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


def _rows_against_time(inflow: RowsInflow, begun: InitialState, seed: int) -> tuple[InletRow, ...]:
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
    inlet_rows = []
    for i, (one, factor) in enumerate(zip(entries, seed_factors(len(entries), seed), strict=True)):
        steps = settle + np.maximum(1, np.ceil(one.times / dt - 1e-9).astype(np.int64))
        steps, kept = np.unique(np.minimum(steps, begun.steps), return_index=True)
        if not len(steps):
            continue
        speeds = graph.speed((steps - settle) * dt) * one.relative[kept] * factor
        every = max(1, ceil((begun.steps - settle) / len(steps)))
        height = inflow.y + (i + 0.5) * begun.largest
        inlet_rows.append(
            InletRow(
                inflow.x, height, float(speeds.max()), 0.0, int(steps[0]), every, CLEARANCE * begun.largest,
                turns=tuple(steps.tolist()), speeds=tuple(speeds.tolist()),
            )
        )  # fmt: skip
    return tuple(inlet_rows)
