# SPDX-License-Identifier: GPL-2.0-or-later
"""What will probably not come out as asked: the window, the stiffness, the channel of a jump and its sill."""

from __future__ import annotations

from math import inf

from lammps_jump.case.design.flow import studied
from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.beds import RoughBed
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.physics import jump
from lammps_jump.scene import InletRow, Wall
from lammps_jump.scene.shapes import open_ends

FASTEST = 1.25
"""Fastest row over the impact speed above which overlaps are doubtful; the 1/7 profile has 1.12."""
UPSTREAM, DOWNSTREAM = 5.0, 3.5
"""Room for a jump: the stream before it in y1; the jump (1.5) and steady tail water (2) in y2 (measured)."""
LOWEST_SILL = 0.55
"""Height of a sill over that of a broad crest that holds the jump of water. In a dry channel discs of `quick_jump` run
over 0.46 of it without a jump, and make one at 0.65 (measured)."""


def doubts(case: CaseFields, impact_speed: float, inlets: tuple[InletRow, ...]) -> list[str]:
    """Sentences on what will probably not come out as asked: window, stiffness, channel, sill.

    Parameters
    ----------
    case : CaseFields
    impact_speed : float
        v0 of (3.20), m/s.
    inlets : tuple of InletRow
    """
    found, window, duration = [], case.analysis.window, case.run.duration
    if window and window[1] > duration * (1 + 1e-3):
        found.append(
            f"analysis.window ends at {window[1]:g} s, the run at {duration:g} s; take a window within the run, or "
            "none for its last quarter"
        )
    elif window and window[1] < 0.5 * duration:
        found.append(
            f"analysis.window ends at {window[1]:g} s and misses the last half of the {duration:g} s; take a later "
            "one, or none for the last quarter"
        )
    fastest = max((row.vx for row in inlets), default=0.0)
    if case.contact.own_stiffness is None and fastest > FASTEST * impact_speed:
        found.append(
            f"the fastest row has {fastest:.3g} m/s, contact.impact_speed is {impact_speed:.3g} m/s: discs press "
            f"{fastest / impact_speed:.2g} times deeper into each other than largest_overlap says; take "
            f"impact_speed: {fastest:.3g}"
        )
    if isinstance(case.inflow, RowsInflow) and case.analysis.jump and case.gravity:
        found += _jump_doubts(case, case.inflow)
    return found


def _stands(wall: Wall) -> bool:
    """Whether a wall is a solid that may be a sill: it ends, and discs are around it."""
    return wall.finite and not wall.hollow and not open_ends(wall.faces)


def _jump_doubts(case: CaseFields, inflow: RowsInflow) -> list[str]:
    """Sentences on a jump that cannot form, has no room, or is not held by the sill."""
    g, (y1, speed) = case.gravity, inflow.over(*studied(case))
    if not y1:
        return ["no disc flows in during the window of the analysis, so that it finds no jump; take another window"]
    number = jump.froude(speed, y1, g)
    if number <= 1:
        return [f"the inflow is subcritical (Fr = {number:.3g}), so that no jump forms; Fr must be above 1"]
    y2 = y1 * jump.belanger(number)
    steps = [
        (x[0], y[1] - inflow.y)
        for x, y in (wall.extent for wall in case.walls if not isinstance(wall, RoughBed) and _stands(wall))
        if x[0] > inflow.x and y[1] > inflow.y
    ]
    outlets = [(item.x_beyond, 0.0) for item in case.outflow if item.x_beyond is not None]
    end, sill = min(steps or outlets, default=(inf, 0.0))
    found, room = [], UPSTREAM * y1 + DOWNSTREAM * y2
    if end - inflow.x < room:
        found.append(
            f"the channel is {end - inflow.x:.3g} m long from the inlet to the sill or outlet; stream, jump and tail "
            f"water need {room:.3g} m (5 y1 + 3.5 y2; 1.5 Lj of water are {jump.channel_length(number, y1):.3g} m)"
        )
    height = jump.sill_holding_height(speed, y1, g)
    if steps and sill < LOWEST_SILL * height:
        found.append(
            f"the jet will run over the sill of {sill:.3g} m without a jump: a broad crest that holds it has "
            f"{height:.3g} m, and discs need {LOWEST_SILL * height:.3g} m or more"
        )
    return found
