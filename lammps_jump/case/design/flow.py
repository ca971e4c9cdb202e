# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of ``check`` on the inflow: what hydraulics says of it, and where along the channel that holds."""

from __future__ import annotations

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.physics import jump
from lammps_jump.scene import Scene

from .foot import Foot, foot_of

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
