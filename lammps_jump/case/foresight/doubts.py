# SPDX-License-Identifier: GPL-2.0-or-later
"""What will probably not come out as asked: the window, the stiffness, the channel of a jump and its sill."""

from __future__ import annotations

from math import inf

from lammps_jump.case.design.flow import studied
from lammps_jump.case.design.foot import foot_of
from lammps_jump.case.fields import CaseFields, Column
from lammps_jump.case.parts.beds import RoughBed
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.physics import jump
from lammps_jump.scene import InletRow, Scene, Wall
from lammps_jump.scene.shapes import open_ends

from .asked import empty_window

DROWNED = 1.25
"""Depth over the sequent depth from which on a jump is drowned for sure; discs hold up to 1.1 (measured)."""
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
    if empty := empty_window(case):
        found += empty
    elif window and window[1] > duration * (1 + 1e-3):
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


def drowned(case: CaseFields, scene: Scene) -> list[str]:
    """A sentence on a basin whose water is deeper than its stream holds: at the foot of a bed, or on a level bed.

    The sequent depth is that of the stream there. The water is that at the start behind the foot, or what the sill
    dams: the slow depth with the energy of the sill and of a critical depth upon it.
    """
    inflow = case.inflow
    if not isinstance(inflow, RowsInflow) or not (case.analysis.jump and case.gravity):
        return []
    y1, speed = inflow.over(*studied(case))
    if not y1 or jump.froude(speed, y1, case.gravity) <= 1:
        return []
    foot = foot_of(scene, y1, speed, case.gravity)
    if foot is not None and foot.stream is None:
        return []
    at, level = (inflow.x, inflow.y) if foot is None else (foot.x, inflow.y - foot.fall)
    stream = jump.inflow_theory(y1, speed, case.gravity) if foot is None or foot.stream is None else foot.stream
    where = "inlet" if foot is None else f"foot of the bed, x = {at:.3g} m,"
    told = (
        f"the stream at the {where} has {stream.velocity:.3g} m/s and {stream.depth:.3g} m and holds "
        f"{stream.belanger_y2:.3g} m"
    )
    most = DROWNED * stream.belanger_y2
    filled = max(
        (item.y[1] - level for item in case.initial if isinstance(item, Column) and item.x[0] - at < 0.5 * stream.length
         and item.x[1] > at + stream.length), default=0.0,
    )  # fmt: skip
    if foot is not None and filled > most:
        return [f"the basin is drowned at the start: {told}, the water is {filled:.3g} m deep; start with less"]
    sills = [
        y[1] - level
        for x, y in (wall.extent for wall in case.walls if not isinstance(wall, RoughBed) and _stands(wall))
        if x[0] > at and y[1] > level
    ]
    crest = max(sills, default=0.0) + 1.5 * jump.critical_depth(stream.velocity * stream.depth, case.gravity)
    most_energy = jump.specific_energy(most, stream.velocity * stream.depth / most, case.gravity)
    if sills and crest > most_energy:
        return [
            f"the sill of {max(sills):.3g} m will drown the jump: {told}, the sill dams more than {most:.3g} m; a sill "
            f"of {stream.sill:.3g} m holds it"
        ]
    return []


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
