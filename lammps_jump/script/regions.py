# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls as LAMMPS' own regions, made from their chains of faces; numbers as LAMMPS reads them.

One region is a rectangle, a segment (a rectangle without thickness), a circle or a half-plane, at any angle; it may
move. A polyline is an intersection of the outsides of thin rectangles behind its faces. At convex joints these end
where a small circle touches both faces, and the circle takes the place of the vertex. Sub-regions of an intersection
give no velocity to dashpot and friction, so that a polyline must be at rest.
"""

from __future__ import annotations

from itertools import pairwise
from math import atan2, cos, degrees, hypot, inf, pi, sin, tan
from typing import NamedTuple

import numpy as np

from lammps_jump.scene import MovingWall, Scene, Wall
from lammps_jump.scene.chains import ARC, SMOOTH_TURN, Chain, Face, Point, faces_of_chain, turn
from lammps_jump.scene.tracks import ANGLE, BEGIN, PHASE, RATE, WAVE, X, Y


def number(value: float) -> str:
    """Shortest text that LAMMPS reads back as the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def numbers(*values: float) -> str:
    """Several numbers, between blanks."""
    return " ".join(number(value) for value in values)


MOST_FACES = 12
"""Faces of a polyline: each costs every disc 50 ns a step."""
MOST_TRACK = 200
"""Rows of a track: LAMMPS reads all of them at every step, 1 us each."""
ROUNDING = 1e-4
"""Radius of the circle at a convex vertex, in diameters: trajectories are off by 1.2 times as much."""
OVERHANG = 16 * np.finfo(float).eps
"""Excess of that circle, and length that faces lack at a concave vertex, as a share of coordinates: round-off.

A disc feels face and circle at once over a way of some 1e-5 d near the joint, which grows with the root of this."""
THICKNESS = 1.5
"""Thickness of a polyline's rectangles, in radii of that circle: their ends lie inside it."""
LEAST_TURN = 1e-4
"""Smallest turn at a convex joint, rad; the circle would touch both faces at one place."""
RIGHT = 0.5 * pi * (1 + 1e-9)
FAR = 1e4
"""Distance that an opened gate is moved away, m."""


class NotInStock(ValueError):
    """Lack of LAMMPS' own styles for a wall; the message names the wall and the field."""


class LammpsRegion(NamedTuple):
    """A region in a frame of its own.

    Attributes
    ----------
    words : str
        Style, numbers and side.
    angle : float
        Turn about the wall's point that brings it to where the case has it, rad.
    inward : (float, float)
        Unit vector towards the discs, where an opened gate must move the other way; zeros: any way.
    """

    words: str
    angle: float = 0.0
    inward: Point = (0.0, 0.0)


def chain_of(wall: Wall) -> Chain:
    """The one chain of a wall."""
    chains = wall.chains()
    if len(chains) != 1:
        raise NotInStock(f"wall of {len(chains)} chains of faces (wall '{wall.name}', field kind)")
    return chains[0]


def joints(wall: Wall) -> list[float]:
    """Turns between the faces of a wall, rad, positive towards the discs."""
    chain = chain_of(wall)
    faces = faces_of_chain(chain)
    return [turn(faces[i - 1], face) for i, face in enumerate(faces) if i or chain.closed]


def level(wall: Wall) -> bool:
    """Tells whether every face of a wall is straight and along an axis."""
    faces = (face for chain in wall.chains() for face in faces_of_chain(chain))
    return all(face.kind != ARC and 0.0 in face.first for face in faces)


def single_regions(wall: Wall, about: Point) -> list[LammpsRegion]:
    """Regions of a wall of which each pushes on its own; none of a wall that needs an intersection.

    Parameters
    ----------
    wall : Wall
    about : (float, float)
        Point that the regions turn about, m.
    """
    chain = chain_of(wall)
    faces = faces_of_chain(chain)
    if any(face.kind == ARC for face in faces):
        return [LammpsRegion(_circle(wall, chain, faces))]
    turns = joints(wall) if chain.closed else []
    if chain.endless or (len(turns) > 2 and min(turns) > 0.5 * pi - 1e-9):
        # in the hollow of a rectangle a disc meets every line between its ends
        return [_plane(face) for face in faces]
    if len(faces) == 1 or len(turns) == 2 or (len(turns) == 4 and max(np.abs(np.add(turns, 0.5 * pi))) < 1e-9):
        return [_block(faces, about)]
    return []


def _circle(wall: Wall, chain: Chain, faces: list[Face]) -> str:
    first = faces[0]
    around = sum(face.sweep for face in faces)
    same = all(hypot(*np.subtract(face.centre, first.centre)) <= 1e-9 * abs(first.radius) for face in faces)
    if not (chain.closed and same and abs(abs(around) - 2 * pi) < 1e-9):
        raise NotInStock(f"arc among faces (wall '{wall.name}', field points)")
    side = "in" if first.radius > 0 else "out"
    return f"cylinder z {numbers(*first.centre, abs(first.radius))} INF INF side {side}"


def _plane(face: Face) -> LammpsRegion:
    inward = -face.first[1], face.first[0]
    return LammpsRegion(f"plane {numbers(*face.start)} 0 {numbers(*inward)} 0", inward=inward)


def _block(faces: list[Face], about: Point) -> LammpsRegion:
    """A rectangle, or a segment, turned about a point so that it is axis-parallel."""
    angle = atan2(faces[0].first[1], faces[0].first[0])
    angle -= round(angle / (0.5 * pi)) * 0.5 * pi
    angle = 0.0 if abs(angle) < 1e-15 else angle
    corners = np.array([point for face in faces for point in (face.start, face.end)])
    low, high = (ends(turned(corners, -angle, about), axis=0) for ends in (np.min, np.max))
    if len(faces) < 3:
        thin = int(np.argmin(high - low))
        low[thin] = high[thin] = 0.5 * (low[thin] + high[thin])
    return LammpsRegion(f"block {numbers(low[0], high[0], low[1], high[1])} INF INF side out", angle=angle)


def turned(points: np.ndarray, angle: float, about: Point) -> np.ndarray:
    """Points, shape (n, 2), turned about another one; as they are where the angle is 0."""
    if not angle:
        return points
    c, s = cos(angle), sin(angle)
    return (points - about) @ np.array([[c, s], [-s, c]]) + about


def polyline(wall: Wall, scene: Scene) -> list[str]:
    """Commands of the region of a standing polyline, ``solid_NAME``."""
    chain = chain_of(wall)
    faces = faces_of_chain(chain)
    rho = ROUNDING * scene.diameter
    tiny = OVERHANG * max(scene.diameter, np.abs([face.start for face in faces]).max())
    turns = [turn(faces[i - 1], face) if i or chain.closed else 0.0 for i, face in enumerate(faces)]
    _check_joints(wall, chain, faces, turns)
    cuts = [rho * tan(-0.5 * angle) if angle < 0 else tiny for angle in turns]
    cuts = [*cuts, cuts[0]]
    if not chain.closed:  # at open ends nothing is cut
        cuts[0] = cuts[-1] = 0.0
    thickness = _thickness(wall, chain, faces, scene)
    lines, names = [], []
    for i, (face, (cut, end)) in enumerate(zip(faces, pairwise(cuts), strict=True), 1):
        (x, y), (tx, ty), name = face.start, face.first, f"face_{wall.name}_{i}"
        angle = atan2(ty, tx)
        extent = numbers(x + cut, x + face.length - end, y - thickness, y)
        lines += [
            f"variable        {name} equal {number(angle)}",
            f"region          {name} block {extent} INF INF side out rotate v_{name} {numbers(x, y)} 0 0 0 1",
        ]
        names.append(name)
        if turns[i - 1] < 0:
            cx, cy = x + cut * tx + rho * ty, y + cut * ty - rho * tx
            name = f"vertex_{wall.name}_{i}"
            lines.append(f"region          {name} cylinder z {numbers(cx, cy, rho + tiny)} INF INF side out")
            names.append(name)
    return [*lines, f"region          solid_{wall.name} intersect {len(names)} {' '.join(names)}"]


def _check_joints(wall: Wall, chain: Chain, faces: list[Face], turns: list[float]) -> None:
    where = f"(wall '{wall.name}', field points)"
    if len(faces) > MOST_FACES:
        raise NotInStock(f"polyline of {len(faces)} faces, {MOST_FACES} at most {where}")
    for face, angle in zip(faces[0 if chain.closed else 1 :], turns[0 if chain.closed else 1 :], strict=True):
        place = f"at [{face.start[0]:.6g}, {face.start[1]:.6g}] m {where}"
        if angle < -RIGHT:
            raise NotInStock(f"vertex sharper than 90 degrees {place}")
        if -LEAST_TURN < angle <= SMOOTH_TURN * (1 + 1e-9):
            raise NotInStock(f"smooth joint, of {degrees(angle):.3g} degrees, {place}")


def _thickness(wall: Wall, chain: Chain, faces: list[Face], scene: Scene) -> float:
    """Thickness of the rectangles behind the faces, m.

    A disc may see the back of a face through a solid thinner than its radius. There the rectangles fill the solid, so
    that the back lies in the rectangle of the face before it.
    """
    thin, depth, near = THICKNESS * ROUNDING * scene.diameter, inf, inf
    for i, face in enumerate(faces):
        for j, other in enumerate(faces):
            ends = [_behind(face, point) for point in (other.start, other.end)]
            if i == j or max(way for _, way in ends) <= thin:
                continue
            is_next = abs(i - j) == 1 or (chain.closed and abs(i - j) == len(faces) - 1)
            if not is_next:
                near = min(near, _apart(face, other))
            depth = min(depth, _clipped(ends, face.length))
    if near > 0.5 * scene.largest:
        return thin
    if not chain.closed or 0.99 * depth < 4 * thin:
        raise NotInStock(
            f"solid that is {near:.3g} m thick between two faces (wall '{wall.name}', field points; "
            f"{0.5 * scene.largest:.3g} m or more)"
        )
    return min(0.99 * depth, 0.5 * scene.largest)


def _behind(face: Face, point: Point) -> Point:
    """Place along a face and depth behind it, m."""
    dx, dy = point[0] - face.start[0], point[1] - face.start[1]
    return face.first[0] * dx + face.first[1] * dy, face.first[1] * dx - face.first[0] * dy


def _clipped(ends: list[Point], length: float) -> float:
    """Smallest depth of a segment, given in the frame of a face, over that face, m; infinite outside it."""
    (a, da), (b, db) = sorted(ends)
    margin = 1e-9 * length
    low, high = max(a, margin), min(b, length - margin)
    if low >= high:
        return inf
    slope = (db - da) / (b - a)
    return min(da + slope * (low - a), da + slope * (high - a))


def _apart(one: Face, two: Face) -> float:
    """Distance of two faces that do not cross, m."""
    distance = inf
    for face, other in ((one, two), (two, one)):
        for x, y in (other.start, other.end):
            along, _ = _behind(face, (x, y))
            share = min(max(along / face.length, 0.0), 1.0)
            px, py = (a + share * (b - a) for a, b in zip(face.start, face.end, strict=True))
            distance = min(distance, hypot(x - px, y - py))
    return distance


class WayFormulas(NamedTuple):
    """Formulas of where a wall is: displacement (m) and turn (rad); empty: none."""

    x: str
    y: str
    angle: str


def way(moving: MovingWall, now: str = "v_now") -> WayFormulas:
    """Formulas of a wall's pose at the time of a variable, which the engine reads as `pose_py` does."""
    track = moving.motion.track
    return WayFormulas(*(_coordinate(track, first, k, now) for k, first in enumerate((X, Y, ANGLE))))


def _coordinate(track: np.ndarray, first: int, k: int, now: str) -> str:
    """Sum over the rows of a track, each times whether it is in force; `k` is the number of the component."""
    terms = []
    for row, end in zip(track, [*track[1:, BEGIN], inf], strict=False):
        since = f"({now}-({number(row[BEGIN])}))"
        expression = ""
        for coefficient in row[first : first + 5][::-1]:
            if expression:
                expression = f"({expression}*{since}+({number(coefficient)}))"
            elif coefficient:
                expression = f"({number(coefficient)})"
        if row[WAVE + k]:
            rate, phase = number(row[RATE + k]), number(row[PHASE + k])
            sine = f"({number(row[WAVE + k])})*sin({rate}*{since}+({phase}))"
            expression = f"({expression}+{sine})" if expression else sine
        if expression:
            until = f"*({now}<{number(end)})" if end < inf else ""
            terms.append(f"({now}>={number(row[BEGIN])}){until}*{expression}")
    return "+".join(terms)


def clock(scene: Scene) -> list[str]:
    """Variables of the time that motions go by, of the step before and of the step after.

    `back` is 1 where a run that goes on looks at the step before (`lammps_jump.script.assemble`).
    """
    if not scene.moves:
        return []
    start, dt = scene.settle_steps, number(scene.time_step)
    return [
        "variable        back equal 0",
        *(
            f"variable        {name} equal (step-{start}{shift})*{dt}"
            for name, shift in (("now", "-v_back"), ("before", "-1"), ("after", "+1"))
        ),
    ]


LOOK_BACK = "variable        back equal 1"
"""Line before a ``run 0`` that looks at the walls of the step before."""


def first_forces(scene: Scene, kernel: str) -> list[str]:
    """Commands that compute the forces of the present step anew, with the velocities of walls that move.

    A region's velocity is the way since it was looked at last. The first ``run 0`` therefore looks at the step before.
    """
    now = "run             0 post no"
    if kernel != "stock" or not scene.moves:
        return [now]
    return [LOOK_BACK, now, "variable        back equal 0", now]


def check_motion(moving: MovingWall) -> None:
    """NotInStock where no variables of LAMMPS give a motion."""
    wall, motion = moving
    if motion.free is not None:
        raise NotInStock(f"bodies (body '{wall.name}', field bodies)")
    if motion.load is not None:
        raise NotInStock(f"wall that discs push (wall '{wall.name}', field motion, kind load)")
    if motion.holding is not None:
        raise NotInStock(f"tailgate that holds a flow (wall '{wall.name}', field motion, kind hold)")
    if len(motion.track) > MOST_TRACK:
        raise NotInStock(
            f"motion of {len(motion.track)} rows, {MOST_TRACK} at most (wall '{wall.name}', field motion.points)"
        )
