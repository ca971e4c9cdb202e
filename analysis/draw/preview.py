# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene before it is run: walls and how they move, discs, inlets, outlets, domain, expected depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, sqrt

import numpy as np

from lammps_jump.analysis.flow import from_scene
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import MovingWall, Pose, WallAtStep
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.shapes import rectangle, thin
from lammps_jump.scene.walls import Interval, Wall, parts_of

from .drawing import BAND, HIGHEST, NARROWEST, WIDEST, Area, Drawing, DrawnDiscs, Stroke

FLATTEST, TALLEST = 0.26, HIGHEST / NARROWEST
"""Least and most height of what is shown, in its lengths."""
MOST_DISCS = 30_000
"""Discs that are drawn; of more every n-th is left out."""
ROWS = 24
"""Arrows of an inlet at most."""
SAMPLES, GHOSTS = 400, 4
"""Poses of a way that are looked at, and those that are drawn besides the first."""
SMALL = 200.0
"""Pixels of a wall that its label had better not cover unless it fits."""
MOST_EDGES = 100
"""Edges of a wall that labels had better not cross."""
CROSS = 6.0
"""Pixels from a centre of mass to the ends of the cross there."""
SLOW = 0.01
"""Speed over sqrt(g d) below which a body that goes on from an earlier run counts as at rest."""


@dataclass(frozen=True)
class NamedRegion:
    """A rectangle (m) with a name: discs at the start, or where discs are poured."""

    name: str
    x: Interval
    y: Interval


def scene_drawing(
    scene: Scene, regions: Sequence[NamedRegion] = (), *, sequent: float | None = None, widest: float = WIDEST
) -> Drawing:
    """Drawing of a scene before it is run.

    Parameters
    ----------
    scene : Scene
    regions : sequence of NamedRegion
        Named rectangles of discs.
    sequent : float, optional
        Depth to expect downstream of a jump, m above the bed.
    widest : float
        Pixels of its width at most.
    """
    walls = [(one, _way(one, scene)) for one in scene.walls]
    drawing = Drawing(*_shown(scene, walls, regions, sequent), widest)
    drawing.add(Area("domain", (rectangle(*scene.domain),)))
    _draw_discs(drawing, scene, regions)
    for one, way in sorted(walls, key=lambda pair: not pair[0].wall.hollow):
        _draw_wall(drawing, one.first)
        if way:
            _draw_way(drawing, one, way)
    _draw_traffic(drawing, scene)
    if sequent is not None:
        _draw_sequent(drawing, scene, sequent)
    for one, _ in walls:
        _name_wall(drawing, one, scene)
    drawing.place_labels()
    drawing.title = scene.name
    dotted = " (dotted)" if _edge_seen(drawing, scene) else ""
    drawing.aside = f"domain{dotted}: x {_span(scene.domain[0])} m, y {_span(scene.domain[1])} m"
    return drawing


def _way(one: MovingWall, scene: Scene) -> list[Pose]:
    """Poses along the way of a wall in time, of a gate that holds a flow over its range; empty of others."""
    if holding := one.motion.holding:
        ends = sorted((holding.lowest, holding.highest), key=abs, reverse=True)  # the arrow goes to the further one
        half = SAMPLES // 2
        return [Pose(0.0, float(y)) for y in (*np.linspace(0.0, ends[0], half), *np.linspace(0.0, ends[1], half))]
    if one.motion.kind is None or one.motion.is_state:
        return []
    last = min(float(scene.steps), one.motion.gone - 1)
    poses = [one.motion.pose(step) or Pose() for step in np.linspace(0.0, max(last, 0.0), SAMPLES)]
    return poses if any(pose != poses[0] for pose in poses) else []


def _corners(wall: Wall, x: Interval, y: Interval) -> np.ndarray:
    """Corners of all parts of a wall, shape (n, 2), m."""
    outlines, lines = parts_of(wall, x, y)
    return np.concatenate([*outlines, *lines])


def _at(one: MovingWall, pose: Pose) -> WallAtStep:
    return WallAtStep(one.wall, pose, one.motion.about)


def _shown(
    scene: Scene, walls: list[tuple[MovingWall, list[Pose]]], regions: Sequence[NamedRegion], sequent: float | None
) -> tuple[Interval, Interval]:
    """Part of the plane that is shown, m: all that the case names within the domain, and little of solids below it."""
    half = 0.5 * scene.largest
    points = [scene.positions - half, scene.positions + half, [(row.x, row.y) for row in scene.inlets]]
    given = [(place.x, place.y) for place in regions] + [(pour.x, pour.y) for pour in scene.pours]
    points += map(np.column_stack, given)
    far: list[np.ndarray] = []
    for one, way in walls:
        poses = way[:: SAMPLES // 20] or [Pose()]
        extents = [np.array(_at(one, pose).extent if way else one.first.extent).T for pose in poses]
        low, high = np.min([ends[0] for ends in extents], axis=0), np.max([ends[1] for ends in extents], axis=0)
        solid = one.wall.finite and not one.wall.hollow and all(chain.closed for chain in one.wall.chains())
        points += [[(low[0], high[1]), high]] if solid else [[low, high]]
        far += [low] if solid else []
    for outlet in scene.outlets:
        points.append([(outlet.at, np.nan) if outlet.axis == "x" else (np.nan, outlet.at)])
    if sequent is not None:
        beds = from_scene(scene).bed_height(np.linspace(*scene.domain[0], 200))
        points.append([(np.nan, float(np.min(beds[np.isfinite(beds)], initial=0.0)) + 1.2 * sequent)])
    named = np.concatenate([np.asarray(part, float).reshape(-1, 2) for part in points])
    sides = []
    for axis, (low, high) in enumerate(scene.domain):
        values = named[:, axis]
        values = np.clip(values[np.isfinite(values)], low, high)
        first, last = (values.min(), values.max()) if values.size else (low, high)
        ends = [place[axis] for place in far]
        first = max(low, min([first, *(max(end, first - 0.12 * (last - first)) for end in ends)]))
        if last - first > 0.6 * (high - low):
            first, last = low, high
        margin = min(0.04 * (last - first) + 2 * scene.diameter, 0.12 * (last - first))
        sides.append((first - margin, last + margin))
    return _proportioned(*sides)


def _proportioned(x: Interval, y: Interval) -> tuple[Interval, Interval]:
    """Both intervals; one is longer where the picture would be too flat or too tall for its labels."""
    wide, high = x[1] - x[0], y[1] - y[0]
    if high < FLATTEST * wide:
        return x, (y[0] - 0.15 * (FLATTEST * wide - high), y[1] + 0.85 * (FLATTEST * wide - high))
    more = 0.5 * max(0.0, high / TALLEST - wide)
    return (x[0] - more, x[1] + more), y


def _edge_seen(drawing: Drawing, scene: Scene) -> bool:
    """Tells whether an edge of the domain lies within the picture."""
    views = zip((drawing.x, drawing.y), scene.domain, strict=True)
    return any(view[0] < end < view[1] for view, ends in views for end in ends)


def _span(ends: Interval) -> str:
    return f"{ends[0]:z.4g} … {ends[1]:z.4g}".replace("-", "\N{MINUS SIGN}")


def _draw_discs(drawing: Drawing, scene: Scene, regions: Sequence[NamedRegion]) -> None:
    """Discs at the start, with the mean velocity of those of a region."""
    x, y = scene.positions.T
    every = -(-len(x) // MOST_DISCS) or 1
    size = scene.diameters(np.arange(1, len(x) + 1))
    rim = min(0.6, 0.08 * scene.diameter * drawing.scale)
    drawing.add(DrawnDiscs(scene.positions[::every], size[::every], rim))
    for place in regions:
        held = (x >= place.x[0]) & (x <= place.x[1]) & (y >= place.y[0]) & (y <= place.y[1])
        middle = np.array([np.mean(place.x), np.mean(place.y)])
        drawing.keep_free(place.x, place.y)
        text = f"{place.name}, {int(held.sum())} discs"
        mean = scene.velocities[held].mean(axis=0) if held.any() else np.zeros(2)
        if (speed := hypot(*mean)) > 0.01:
            long = 0.05 * (drawing.x[1] - drawing.x[0]) / speed
            drawing.arrow(np.array([middle - 0.5 * long * mean, middle + 0.5 * long * mean]), "blue")
            text += f", {speed:z.3g} m/s"
        drawing.label(text, middle[0], place.y[1], "blue")
    _draw_movers(drawing, scene, regions)
    for pour in scene.pours:
        drawing.add(Area("pour", (rectangle(pour.x, pour.y),)))
        drawing.label(f"pour, {pour.count} discs", float(np.mean(pour.x)), pour.y[1], "blue")


def _draw_movers(drawing: Drawing, scene: Scene, regions: Sequence[NamedRegion]) -> None:
    """Arrows of single discs that move at the start."""
    speed = np.hypot(*scene.velocities.T)
    movers = np.flatnonzero(speed > 0)
    if regions or not 0 < len(movers) <= ROWS:
        return
    long = 0.06 * (drawing.x[1] - drawing.x[0]) / speed.max()
    for begin, velocity in zip(scene.positions[movers], scene.velocities[movers], strict=True):
        drawing.arrow(np.array([begin, begin + long * velocity]), "blue")
    x, y = scene.positions[movers[speed[movers].argmax()]].tolist()
    drawing.label(f"{speed.max():z.3g} m/s", x, y, "blue")


def _draw_wall(drawing: Drawing, wall: Wall) -> None:
    wide = [(low - (high - low), high + (high - low)) for low, high in (drawing.x, drawing.y)]
    outlines, lines = parts_of(wall, *wide)
    sheets = [part for part in outlines if thin(part)]
    rings = [part for part in outlines if not thin(part)]
    if wall.hollow:
        rings.append(rectangle(*wide)[::-1])  # all that is outside
    if rings:
        drawing.add(Area("outside" if wall.hollow else "solid", tuple(rings)))
    for part in sheets:
        drawing.add(Stroke("sheet", part))
    for part in lines:
        drawing.add(Stroke("band", _band(part, BAND / drawing.scale)))
        drawing.add(Stroke("edge", part))


def _band(line: np.ndarray, width: float) -> np.ndarray:
    """The middle of a band of this width (m) right of a line, where it has no discs."""
    along = np.diff(line, axis=0)
    aside = 0.5 * width * np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]
    return np.stack([line[:-1] + aside, line[1:] + aside], axis=1).reshape(-1, 2)


def _draw_way(drawing: Drawing, one: MovingWall, way: list[Pose]) -> None:
    """Poses along the way, faded, and an arrow from the start to where the wall is farthest from it."""
    corners = _corners(one.wall, drawing.x, drawing.y)
    ways = np.array([np.column_stack(_at(one, pose).outward(*corners.T)) for pose in way])
    kept = [0]
    while len(kept) <= GHOSTS:  # the pose that is farthest from all that are kept
        apart = np.min([_apart(ways, ways[k]) for k in kept], axis=0)
        if apart.max() * drawing.scale < 4:
            break
        kept.append(int(apart.argmax()))
    for k in kept[1:]:
        outlines, lines = parts_of(_at(one, way[k]), drawing.x, drawing.y)
        for part in outlines:
            ring = np.vstack([part, part[:1]])
            drawing.add(Stroke("ghost", ring) if one.wall.hollow else Area("ghost", (part,)))
        for part in lines:
            drawing.add(Stroke("ghost", part))
    end = int(_apart(ways, ways[0]).argmax())
    traced = int(np.hypot(*(ways[end] - ways[0]).T).argmax())
    trace = ways[: end + 1, traced]
    moves = np.append(True, np.hypot(*np.diff(trace, axis=0).T) > 0)
    if moves.sum() > 1:
        drawing.arrow(trace[moves], "red")


def _apart(ways: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Largest distance between corners of each pose and of one, m, shape (poses,)."""
    return np.hypot(*np.moveaxis(ways - pose, -1, 0)).max(axis=1)


def _draw_traffic(drawing: Drawing, scene: Scene) -> None:
    """Inlet rows with arrows as long as they are fast, and outlets."""
    if scene.inlets:
        fastest = max(abs(row.vx) for row in scene.inlets) or 1.0
        long = 0.06 * (drawing.x[1] - drawing.x[0]) / fastest
        rows = sorted(scene.inlets, key=lambda row: row.y)[:: -(-len(scene.inlets) // ROWS)]
        apart = (rows[-1].y - rows[0].y) / max(1, len(rows) - 1) * drawing.scale
        head = float(np.clip(1.2 * apart, 5.0, 13.0)) if len(rows) > 1 else 13.0
        for row in rows:
            drawing.arrow(np.array([(row.x, row.y), (row.x + long * row.vx, row.y)]), "blue", 1.1, head)
        mean, top = np.mean([row.vx for row in scene.inlets]), max(scene.inlets, key=lambda row: row.y)
        count = len(scene.inlets)
        said = f"{count} row{'s' * (count > 1)}, mean {mean:z.3g} m/s"
        if scene.hydrograph:
            said = f"against time, up to {count} row{'s' * (count > 1)} and {fastest:z.3g} m/s"
        drawing.label(f"inlet: {said}", top.x, top.y, "blue")
    for outlet in scene.outlets:
        upright, sign = outlet.axis == "x", 1 if outlet.side == "above" else -1
        sides = (drawing.x, drawing.y)
        along, reach = sides[1 if upright else 0], 0.02 * (drawing.x[1] - drawing.x[0]) * sign
        across = along[0] + 0.8 * (along[1] - along[0])
        ends, thin_one = np.array([(outlet.at, across), (outlet.at + reach, across)]), 1.5 / drawing.scale
        drawn = (outlet.at - thin_one, outlet.at + thin_one)
        line = np.column_stack([[outlet.at] * 2, along])
        drawing.add(Stroke("outlet", line if upright else line[:, ::-1]))
        drawing.keep_free(*((drawn, drawing.y) if upright else (drawing.x, drawn)))
        drawing.arrow(ends if upright else ends[:, ::-1], "plain", 1.0)
        place = ends[0] if upright else ends[0, ::-1]
        drawing.label(f"outlet {outlet.axis} = {outlet.at:zg} m".replace("-", "\N{MINUS SIGN}"), *place)


def _draw_sequent(drawing: Drawing, scene: Scene, sequent: float) -> None:
    """The depth to expect, above the longest stretch where the bed is lowest; none for an inlet above it."""
    flow = from_scene(replace(scene, walls=tuple(one for one in scene.walls if one.motion.kind is None)))
    x = np.linspace(*flow.x_range, 400)
    bed = flow.bed_height(x)
    if not np.isfinite(bed).any():
        return
    low = float(np.nanmin(bed))
    if any(flow.bed_height(row.x) > low + sequent for row in scene.inlets):
        return
    level = np.flatnonzero(bed <= low + 0.5 * scene.diameter)
    stretch = max(np.split(level, np.flatnonzero(np.diff(level) > 1) + 1), key=len)
    ends, height = (float(x[stretch[0]]), float(x[stretch[-1]])), low + sequent
    drawing.add(Stroke("level", np.array([(ends[0], height), (ends[1], height)])))
    drawing.keep_free(ends, (height - 2 / drawing.scale, height + 2 / drawing.scale))
    drawing.label(
        f"sequent depth to expect (Bélanger): {sequent:z.3g} m", ends[0] + 0.7 * (ends[1] - ends[0]), height, "red"
    )


def _name_wall(drawing: Drawing, one: MovingWall, scene: Scene) -> None:
    """The name of a wall and what becomes of it, on its solid or next to its edge."""
    wall, motion = one.first, one.motion
    text = wall.name if motion.kind is None else f"{wall.name} ({motion.kind.kind})"
    if np.isfinite(motion.gone):
        text += f", opens at t = {scene.time(int(motion.gone)):z.3g} s"
    corners = np.clip(_corners(wall, drawing.x, drawing.y), *np.array([drawing.x, drawing.y]).T)
    low, high = corners.min(axis=0), corners.max(axis=0)
    ends, thin_one = np.stack([corners, np.roll(corners, -1, axis=0)]), 1.5 / drawing.scale
    for begin, end in np.moveaxis(np.sort(ends, axis=0), 0, 1)[:MOST_EDGES]:
        if (end - begin).min() < thin_one < (end - begin).max():  # upright or level
            drawing.keep_free((begin[0] - thin_one, end[0] + thin_one), (begin[1] - thin_one, end[1] + thin_one))
    if not wall.hollow and (high - low).max() * drawing.scale < SMALL:
        drawing.keep_free((low[0], high[0]), (low[1], high[1]))
    still = SLOW * sqrt(scene.diameter * hypot(*scene.gravity))
    centre = None if motion.free is None else _draw_body(drawing, one, motion.free, still)
    on = None
    if not wall.hollow and float(wall.distance(*(0.5 * (low + high)))) < 0:
        above = -np.inf if centre is None else float(centre[1]) + CROSS / drawing.scale  # not on the cross
        on = (float(low[0]), float(high[0])), (max(float(low[1]), above), float(high[1]))
    edge = ends.mean(axis=0)
    place = edge[np.argmax(edge[:, 1])]  # the middle of the highest edge
    drawing.label(text, float(place[0]), float(place[1]), on=on)
    if motion.load is not None:
        force = np.array(motion.load.force) / (hypot(*motion.load.force) or 1.0)
        drawing.arrow(np.array([place, place + 0.04 * (drawing.x[1] - drawing.x[0]) * force]), "red")


def _draw_body(drawing: Drawing, one: MovingWall, free: Free, still: float) -> np.ndarray:
    """The centre of mass of a body as a cross, its hinge as a ring, and an arrow where it is thrown; that centre, m."""
    went = one.motion.went
    shown = _at(one, Pose() if went is None else went.pose)
    arm, (centre, point) = CROSS / drawing.scale, np.column_stack(shown.outward(*np.array([free.centre, free.point]).T))
    velocity = free.velocity if went is None else went.speed[:2]
    for x, y in ((1.0, 1.0), (1.0, -1.0)):
        drawing.add(Stroke("mark", centre + arm * np.array([(-x, -y), (x, y)]), "red"))
    drawing.keep_free((centre[0] - arm, centre[0] + arm), (centre[1] - arm, centre[1] + arm))
    if free.hinge is not None:
        turn = np.linspace(0.0, 2 * np.pi, 25)
        ring = point + arm * np.column_stack([np.cos(turn), np.sin(turn)])
        drawing.add(Stroke("mark", ring, "red"))
    if hypot(*velocity) > (0.0 if went is None else still):  # one that goes on is never quite at rest
        way = np.array(velocity) / hypot(*velocity)
        drawing.arrow(np.array([centre, centre + 0.04 * (drawing.x[1] - drawing.x[0]) * way]), "red")
    return centre
