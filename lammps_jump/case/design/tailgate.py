# SPDX-License-Identifier: GPL-2.0-or-later
"""Tailgates of a case: what each one measures, and how fast it answers."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, isfinite

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.errors import FieldError
from lammps_jump.physics import jump
from lammps_jump.physics.devices import GATE_LOOKS, Holding, gate_gains, wave_travel
from lammps_jump.scene import Beginning, InletRow, Interval, MovingWall
from lammps_jump.scene.tracks import Held

STRETCH = 10
"""Width over which a depth is taken, in diameters; half of it is that of the parts in which a front is looked for."""


def with_holdings(
    case: CaseFields, begun: Beginning, walls: list[MovingWall], fields: dict[str, str],
    domain: tuple[Interval, Interval], inlets: tuple[InletRow, ...],
) -> list[MovingWall]:  # fmt: skip
    """The walls, with what tailgates among them measure.

    Raises
    ------
    FieldError
        A depth or a front where the gate cannot hold it: beyond the domain, behind the gate, without inflow.
    """
    found = []
    for one in walls:
        if isinstance(kind := one.motion.kind, Held):
            field = f"{fields[one.wall.name]}.motion"
            left = max([domain[0][0], *(row.x for row in inlets)])
            holding = _holding(case, begun, one, kind, field, (left, domain[0]))
            one = MovingWall(one.wall, replace(one.motion, holding=holding))
        found.append(one)
    return found


def _holding(
    case: CaseFields, begun: Beginning, one: MovingWall, kind: Held, field: str,
    channel: tuple[float, Interval],
) -> Holding:  # fmt: skip
    """Quantity that a gate measures, and its gains."""
    left, domain = channel
    face = one.wall.extent[0][0]
    place, name = (kind.at, "at") if kind.front is None else (kind.front, "front")
    assert place is not None  # one of the two is there
    if not isfinite(face) or not left < face < domain[1]:
        raise FieldError(
            field,
            f"wall '{one.wall.name}' has its side towards the flow at x = {face:zg} m; allowed is a block "
            f"between {left:zg} and {domain[1]:zg} m, in the domain and behind the inlet",
        )
    width = STRETCH * begun.diameter
    half = 0.5 * width if kind.depth is not None else 0.0
    if not left <= place - half <= place + half <= face or place == face:  # a front behind the gate cannot be held
        inner = (left + 0.5 * width, face - 0.5 * width) if kind.depth is not None else (left, face)
        raise FieldError(
            f"{field}.{name}",
            f"{place:zg} m is outside the channel before the gate; allowed is {inner[0]:zg} to "
            f"{inner[1]:zg} m, between its begin and the wall '{one.wall.name}'",
        )
    depth, speed, level, rise = _flow(case, kind, field)
    length = max(face - place, depth)
    travel = wave_travel(length, depth, speed, case.gravity)
    response = travel if kind.response is None else kind.response
    if kind.front is None:
        low, high, bins = place - 0.5 * width, place + 0.5 * width, 1
    else:
        low, high = left, face
        bins = max(2, ceil((face - left) / (0.5 * width)))
    proportional, integral = gate_gains(response, travel, length, rise / length)
    every = max(1, round(response / GATE_LOOKS / begun.time_step))
    first = max(1, begun.settle_steps + ceil(kind.begin / begun.time_step)) if isfinite(kind.begin) else 0
    if one.motion.went is not None:  # the next look of a gate that goes on
        since = one.motion.went.since or 0.0
        first = every - min(round(since / begun.time_step), every - 1)
    return Holding(
        low, high, bins, place if kind.front is not None else depth, level, proportional, integral, kind.speed,
        *kind.range, first, every,
    )  # fmt: skip


def _flow(case: CaseFields, kind: Held, field: str) -> tuple[float, float, float, float]:
    """Depth (m) and speed (m/s) of the stream before the gate, depth at the front, and the rise of depth there, m."""
    stream = case.inflow.over(0.0, case.run.duration) if isinstance(case.inflow, RowsInflow) else (0.0, 0.0)
    y1, u1 = stream
    if case.gravity == 0:
        raise FieldError(field, "a gate holds a depth under gravity, and this case has none; give gravity, m/s^2")
    if kind.depth is not None:
        return kind.depth, y1 * u1 / kind.depth, 0.0, 0.0
    if not y1 or jump.froude(u1, y1, case.gravity) <= 1.0:
        raise FieldError(
            f"{field}.front",
            "a front needs an inflow of rows that is faster than its waves (Froude number above 1); "
            "hold a depth instead, by depth and at",
        )
    y2 = jump.sequent_depth(u1, y1, case.gravity)
    return y2, y1 * u1 / y2, 0.5 * (y1 + y2), y2 - y1
