# SPDX-License-Identifier: GPL-2.0-or-later
"""Hydraulics of a case before it is run: rows of ``check`` on the inflow, the foot of a bed that falls, tailgates.

Numbers of the inflow hold at the inlet. Down a spillway or over steps the jump stands at the foot, in another stream:
that there is by energy without loss, with the jump it would make. Of a tailgate: what it measures, how fast it answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, isfinite

import numpy as np

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.errors import FieldError
from lammps_jump.physics import jump
from lammps_jump.physics.devices import GATE_LOOKS, Holding, gate_gains, wave_travel
from lammps_jump.scene import Beginning, InletRow, Interval, MovingWall, Scene
from lammps_jump.scene.tracks import Held
from lammps_jump.scene.walls import bed_height
from lammps_jump.units import number

Row = tuple[str, str, float | int | str | None, str]
"""Key, label, value and unit."""


def flow_rows(case: CaseFields, scene: Scene) -> list[Row]:
    """Theory of the inflow at the inlet, and at the foot of a bed that falls; none without rows, or without gravity."""
    inflow = case.inflow
    if not isinstance(inflow, RowsInflow) or case.gravity == 0:
        return []
    depth, speed = inflow.over(*studied(case))
    if not depth:
        return []
    found = jump.inflow_theory(depth, speed, case.gravity)
    number, y1 = found.froude, found.depth
    low, high = jump.velocity_range(y1, case.gravity)
    carried = sum(scene.discharges)
    below = foot_of(scene, depth, speed, case.gravity)
    there = ", at the inlet" if below else ""
    rows: list[Row] = [
        ("froude", f"Froude number Fr1{there}", number, ""),
        (
            "jump_class",
            f"class of jump{there}",
            found.jump_class if number > 1 else "none: the inflow is subcritical",
            "",
        ),
        ("discharge", f"discharge asked for, {'mean of the window' if inflow.table else 'Va y1'}", speed * y1, "m^2/s"),
        (
            "discharge_rows",
            f"discharge of the rows, {'over the run' if inflow.table else 'in whole steps'}",
            carried,
            "m^2/s",
        ),
        ("mass_flow_rows", "mass flow of the rows", scene.density * carried, "kg/(m s)"),
        ("thesis_speed_low", "mean speed Va of a steady jump, Fr1 = 5", low, "m/s"),
        ("thesis_speed_high", "mean speed Va of a steady jump, Fr1 = 9", high, "m/s"),
    ]
    if number > 1:
        rows += _jump_rows(found, there)
    return [*rows, *_foot_rows(below)]


def _jump_rows(found: jump.Inflow, where: str, key: str = "") -> list[Row]:
    """The jump that a stream would make; `where` stands behind the labels, `key` before the keys."""
    number, y1 = found.froude, found.depth
    rows: list[Row] = [
        ("belanger_y2", "sequent depth y2 (Bélanger, 4.26)", found.belanger_y2, "m"),
        ("downstream_froude", "downstream Froude number", jump.downstream_froude(number), ""),
        ("energy_loss", "energy loss", found.energy_loss, "m"),
        ("jump_length", "jump length (4.27)", found.length, "m"),
        ("sill", "sill that holds the jump, E2 - 1.5 yc", found.sill, "m"),
        ("channel_length", "channel length 1.5 Lj", jump.channel_length(number, y1), "m"),
    ]
    return [(f"{key}{name}", f"{label}{where}", value, unit) for name, label, value, unit in rows]


def _foot_rows(below: Foot | None) -> list[Row]:
    """The stream at the foot of the bed by energy, and its jump; none on a level bed."""
    if below is None:
        return []
    rows: list[Row] = [
        ("foot_x", "foot of the bed at x", below.x, "m"),
        ("foot_fall", "fall of the bed to the foot", below.fall, "m"),
        ("foot_length", "level bed behind the foot", below.length, "m"),
    ]
    stream = below.stream
    if stream is None:
        return rows
    return [
        *rows,
        ("foot_depth", "depth at the foot, by energy without loss", stream.depth, "m"),
        ("foot_speed", "velocity at the foot, the same", stream.velocity, "m/s"),
        ("foot_froude", "Froude number at the foot", stream.froude, ""),
        ("foot_jump_class", "class of jump at the foot", stream.jump_class, ""),
        *_jump_rows(stream, ", at the foot", "foot_"),
    ]


def studied(case: CaseFields) -> tuple[float, float]:
    """Times over which the analysis takes its means, s: for them an inflow against time has its theory."""
    return case.analysis.window or (0.75 * case.run.duration, case.run.duration)


LEVEL = 0.05
"""Slope below which a bed is level: its change of height over a diameter, in diameters."""
LEAST_FALL = 0.5
"""Fall in diameters from which on a bed has a foot."""
POINTS = 4000


@dataclass(frozen=True)
class Foot:
    """The stream at the foot of the bed, and the jump that it would make there."""

    x: float = number("m", "foot of the bed: its longest level stretch begins at x")
    fall: float = number("m", "fall of the bed from the inlet to the foot")
    length: float = number("m", "length of the level bed behind the foot")
    stream: jump.Inflow | None = None


def foot_of(scene: Scene, depth: float, speed: float, gravity: float) -> Foot | None:
    """The foot behind the rows of a scene that carry a depth (m) and a speed (m/s); None on a level or tilted bed.

    The depth there is that of the fast stream with the energy at the inlet and the fall: the least that friction and
    impacts would leave. Where the bed rises the stream stays None.
    """
    if not scene.inlets or scene.gravity[0] or not (depth > 0 and speed > 0):
        return None
    start = min(scene.inlets, key=lambda one: one.y).x
    ends = [outlet.at for outlet in scene.outlets if outlet.axis == "x" and outlet.side == "above"]
    x = np.linspace(start, min([scene.domain[0][1], *ends]), POINTS)
    bed = bed_height(scene.permanent, x, scene.smallest)
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(np.abs(np.diff(bed)) < LEVEL * np.diff(x))) + 1
    begins, long = np.append(0, breaks), np.diff(breaks, prepend=0, append=POINTS)
    longest = int(np.argmax(np.where(np.isfinite(bed[begins]), long, 0)))
    first, last = begins[longest], begins[longest] + long[longest] - 1
    if long[longest] < 2 or not isfinite(bed[first]) or not isfinite(bed[0]):  # a chute to the end has no foot
        return None
    fall = float(bed[0] - bed[first])
    if fall < LEAST_FALL * scene.diameter:
        return None
    discharge = speed * depth
    energy = jump.specific_energy(depth, speed, gravity) + fall
    y1 = jump.fast_depth(discharge, energy, gravity)
    stream = jump.inflow_theory(y1, discharge / y1, gravity) if isfinite(y1) else None
    return Foot(float(x[first]), fall, float(x[last] - x[first]), stream)


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
