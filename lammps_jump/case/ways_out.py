# SPDX-License-Identifier: GPL-2.0-or-later
"""Ways out of the domain that end the run: edges that neither a wall nor an outlet guards; walls without use.

Cells that a disc can come to are filled from the discs at the start and the inlets on, up to the height that their
energy allows and as far as they run in the time. Each choice errs towards silence: half the fastest speed, heaps with
steep flanks, gaps of a cell closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import cos, inf, isfinite, radians, sqrt

import numpy as np

from lammps_jump.scene import InitialState, InletRow, Interval, MovingWall, Outlet, Wall
from lammps_jump.scene.motion import largest_speed, way

from .fields import CaseFields
from .inflow import PourInflow
from .speeds import LEAST_FRICTION, expected, lowest_ground, starts

CELLS = 40_000
"""Most cells, for walls of few faces."""
WORK = 4_000_000
"""Most cells times faces."""
SLOW = 0.5
"""Share of the fastest speed at which discs are taken to run."""
STEEPEST = 0.5
"""Largest tangent of the flanks of a heap that is foreseen."""
ROLLS = 0.1
"""Resistance of discs that roll on others without rolling friction, over their weight."""
MOST_SPANS = 3
"""Stretches that a sentence names."""
BELOW = 4.0
"""Room below the lowest wall or disc in which a fall is seen, in diameters."""

Room = tuple[Interval, Interval]


def unguarded(
    case: CaseFields, begun: InitialState, inlets: Sequence[InletRow], walls: Sequence[MovingWall], domain: Room,
    outlets: Sequence[Outlet],
) -> list[str]:  # fmt: skip
    """Sentences on edges of the domain that discs come to: one for each.

    `walls` are all that are at rest or move, without gates that vanish at t = 0.
    """
    if not case.gravity or not (case.initial or case.inflow):
        return []
    speed, (left, right), (bottom, top) = expected(case).speed, domain[0], domain[1]
    reach = _reach(case, begun, walls, speed)
    highest = max(start.top for start in starts(case))
    fastest = max((largest_speed(one, 0.0, case.run.duration) for one in walls), default=0.0)
    highest += max(max(start.speed for start in starts(case)), fastest) ** 2 / (2 * case.gravity)
    ends = [end for one in walls for end in one.first.extent[1] if isfinite(end)]
    lowest = min([*ends, *begun.positions[:, 1], *(row.y for row in inlets)]) - BELOW * begun.largest
    room = (max(left, reach[0]), min(right, reach[1])), (max(bottom, lowest), min(top, highest + begun.largest))
    seeds = np.array([*begun.positions[: _loose(begun)], *((row.x, row.y) for row in inlets)]).reshape(-1, 2)
    if isinstance(case.inflow, PourInflow):
        seeds = np.vstack([seeds, [[np.mean(case.inflow.x), np.mean(case.inflow.y)]]])
    by_edge: dict[str, np.ndarray] = {}
    swept = np.zeros(len(seeds), bool)
    for one in walls:
        if one.motion.kind is not None:
            (x0, x1), (y0, y1) = way(one, begun.time(0), begun.time(begun.steps))
            swept |= (seeds[:, 0] > x0) & (seeds[:, 0] < x1) & (seeds[:, 1] > y0) & (seeds[:, 1] < y1)
    before = None
    for step in (0, begun.steps):
        there = [wall for one in walls if (wall := one.at(step)) is not None] + list(begun.beds)
        if there == before and not swept.any():
            continue  # nothing moves
        before = there
        for edge, places in _edges(there, seeds[~swept] if step else seeds, room, begun, outlets).items():
            by_edge[edge] = np.concatenate([by_edge.get(edge, np.empty(0)), places])
    said = []
    for edge, at, name in (("left", left, "x_before"), ("right", right, "x_beyond")):
        if edge in by_edge and room[0][edge == "right"] == at and case.seam is None:
            said.append(
                f"discs come to the {edge} edge of the domain, x = {at:z.4g} m, where neither a wall nor an "
                f"outflow is: one that is lost ends the run; add outflow: [{{{name}: …}}] before it, or a wall, "
                "or widen domain.x"
            )
    time = sqrt(2 * max(0.0, highest - bottom) / (case.gravity * cos(radians(case.slope))))
    if "bottom" in by_edge and not any(one.axis == "y" and one.side == "below" for one in outlets):
        if case.run.duration > 2 * time:
            said.append(
                f"nothing holds discs {_spans(by_edge['bottom'])} m: they fall to the lower edge of the "
                f"domain, y = {bottom:z.4g} m, and one that is lost ends the run; add outflow: [{{y_below: …}}] above "
                "it, or close the floor there"
            )
    return said


def _spans(places: np.ndarray) -> str:
    """Stretches of places in words, m."""
    places = np.unique(places)
    breaks = np.flatnonzero(np.diff(places) > 1.5 * np.diff(places).min(initial=np.inf)) + 1
    parts = [f"between x = {part[0]:z.3g} and {part[-1]:z.3g}" for part in np.split(places, breaks)]
    return ", ".join(parts[:MOST_SPANS]) + (", …" if len(parts) > MOST_SPANS else "")


def _loose(begun: InitialState) -> int:
    """Number of discs at the start that are not fixed."""
    return len(begun.positions) if begun.fixed is None else begun.fixed.first - 1


def _reach(case: CaseFields, begun: InitialState, walls: Sequence[MovingWall], speed: float) -> Interval:
    """Places along x between which discs stay or may not come beyond in the time, m."""
    ends = [end for start in starts(case) for end in start.x]
    far = SLOW * speed * case.run.duration
    reach = min(ends) - far, max(ends) + far
    friction = min(case.contact.friction, STEEPEST)
    if friction < LEAST_FRICTION or case.slope or (case.inflow and not isinstance(case.inflow, PourInflow)):
        return reach
    count = _loose(begun) + (case.inflow.count if isinstance(case.inflow, PourInflow) else 0)
    flank = sqrt(count * begun.mean_square / friction)
    middle = 0.5 * (min(ends) + max(ends))
    low, high = min(middle - flank, *ends), max(middle + flank, *ends)
    ground, law = lowest_ground(case), case.contact
    roll = law.rolling.friction if law.rolling else ROLLS if law.rotation else law.friction
    for one in walls:  # what lies on a wall that moves is carried, and thrown off
        (x0, x1), (y0, _) = way(one, 0.0, case.run.duration)
        pace = largest_speed(one, 0.0, case.run.duration)
        if pace and isfinite(x0) and isfinite(x1):
            thrown = pace * sqrt(2 * max(0.0, y0 - ground) / case.gravity) + pace**2 / (2 * roll * case.gravity)
            begin, end = one.wall.extent[0]
            low = min(low, x0 - thrown) if x0 < begin else low
            high = max(high, x1 + thrown) if x1 > end else high
    return max(reach[0], low), min(reach[1], high)


def _edges(
    walls: Sequence[Wall], seeds: np.ndarray, room: Room, begun: InitialState, outlets: Sequence[Outlet]
) -> dict[str, np.ndarray]:
    """Edges of a room that cells filled from `seeds` (n, 2) touch, with the places along x or y where they do, m."""
    (left, right), (bottom, top) = room
    if right - left < begun.largest or top - bottom < begun.largest:
        return {}
    faces = sum(len(wall.faces.shape) for wall in walls) or 1
    cell = max(begun.largest, sqrt((right - left) * (top - bottom) / min(CELLS, WORK / faces)))
    x = np.arange(left + 0.5 * cell, right, cell)
    y = np.arange(bottom + 0.5 * cell, top, cell)
    if len(x) < 2 or len(y) < 2:
        return {}
    across, up = (part.ravel() for part in np.meshgrid(x, y))
    free = np.ones(across.shape, bool)
    near = max(0.49 * begun.smallest, 0.75 * cell)
    for wall in walls:
        free &= _free_of(wall, (left, right, bottom, top, cell), near)
    solid = ~free.reshape(len(y), len(x))
    for line in outlets:
        place = across if line.axis == "x" else up
        free &= place <= line.at if line.side == "above" else place >= line.at
    free = free.reshape(len(y), len(x))
    filled = np.zeros_like(free)
    i = ((seeds[:, 1] - bottom) / cell).astype(int)
    j = ((seeds[:, 0] - left) / cell).astype(int)
    inside = (i >= 0) & (i < len(y)) & (j >= 0) & (j < len(x))
    filled[i[inside], j[inside]] = True
    filled &= free
    before = -1
    while (count := int(filled.sum())) > before:
        before = count
        wide = filled.copy()
        wide[1:] |= filled[:-1]
        wide[:-1] |= filled[1:]
        wide[:, 1:] |= filled[:, :-1]
        wide[:, :-1] |= filled[:, 1:]
        filled = wide & free
    under = solid.any(axis=0)  # below a wall discs come only round its ends
    fall = filled[0] & ~under if (filled[0] & ~under).any() else filled[0]
    sides = {
        "left": (filled[:, 0] & _carried(solid[:, 0], free[:, 0]), y),
        "right": (filled[:, -1] & _carried(solid[:, -1], free[:, -1]), y),
        "bottom": (fall, x),
    }
    return {name: places[hit] for name, (hit, places) in sides.items() if hit.any()}


@lru_cache(maxsize=32)  # of a case that changes most walls stay
def _free_of(wall: Wall, grid: tuple[float, float, float, float, float], near: float) -> np.ndarray:
    """Mask of the cells of a grid (left, right, bottom, top, width of a cell, m) so far from a wall; read-only."""
    left, right, bottom, top, cell = grid
    across, up = np.meshgrid(np.arange(left + 0.5 * cell, right, cell), np.arange(bottom + 0.5 * cell, top, cell))
    gap = wall.distance(across.ravel(), up.ravel())
    is_free = (gap >= near) | ((gap <= -near) & (not wall.deep))
    is_free.setflags(write=False)
    return is_free


def _carried(solid: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Tells whether a wall lies below each cell of a column, upwards from the lowest, with only free cells between."""
    is_carried, ground = np.zeros_like(free), False
    for i in range(len(free)):
        ground = bool(solid[i]) or (ground and bool(free[i]))
        is_carried[i] = ground
    return is_carried


def unused(walls: Sequence[MovingWall], reached: Sequence[MovingWall], own: Sequence[str]) -> list[str]:
    """Sentences on walls of the case, `own`, that no disc can touch: outside the domain, or within another wall."""
    sentences = []
    names = {one.wall.name for one in reached}
    for one in walls:
        if one.wall.name not in own:
            continue
        if one.wall.name not in names:
            sentences.append(
                f"wall '{one.wall.name}' is outside the domain, so that no disc can touch it; move it, or widen domain"
            )
        elif other := _holds(one, walls):
            sentences.append(
                f"wall '{one.wall.name}' lies within wall '{other}', so that no disc can touch it; let it stick out or "
                "drop it"
            )
    return sentences


def _holds(one: MovingWall, walls: Sequence[MovingWall]) -> str | None:
    """Name of a wall at rest that holds all of another one."""
    if one.motion.kind is not None or not one.wall.finite:
        return None
    corners = np.concatenate(one.wall.outline(*one.wall.extent))
    for other in walls:
        if other is one or other.motion.kind is not None or other.wall.hollow:
            continue
        solid = other.wall.deep or (other.wall.thickness > 0 and isfinite(other.wall.thickness))
        if solid and (other.wall.distance(*corners.T) < 0).all() and other.wall.thickness < inf:
            return other.wall.name
    return None
