# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of a disc with a wall of faces: which faces push, and from where.

The rule. A face gives a candidate where its foot, the nearest point, lies inside it; a joint gives one where the feet
of both neighbours lie on it. At a corner, a face whose foot is its end keeps a candidate of its own. If the nearest
candidate is behind its face, the centre is inside the solid, and that face alone pushes. Else the deepest pushes, and
with it each one of another run, or of the same run whose tangent differs by more than `SMOOTH_TURN` from those that
push already. The energy of a contact without friction is then k/2 times the sum over runs of the squared overlap, and
continuous. Planes and boxes push from any depth, each face on its own.

Plain loops, which the twin calls. The core and the plugin hold their own copies (``faces.h``); tests compare them.
"""

from __future__ import annotations

from math import floor, inf, pi, sqrt

import numpy as np

from lammps_jump.physics.elementary import atan2

from .chains import (
    AFTER,
    ARC,
    ARC_LENGTH,
    AT_END,
    AT_START,
    BEFORE,
    CONVEX,
    CORNER,
    CX,
    CY,
    ENDLESS,
    FREE,
    KIND,
    LENGTH,
    LOOP,
    PHI,
    RADIUS,
    RUN,
    SEGMENT,
    SMOOTH_TURN,
    SWEEP,
    TX0,
    TX1,
    TY0,
    TY1,
    X0,
    X1,
    Y0,
    Y1,
    Faces,
)

MOST = 16
"""Contacts of a disc with one wall, at most: the deepest ones."""
SAME_TURN = SMOOTH_TURN * (1 + 1e-6)
"""Turn between two contacts of a run up to which they are one, rad; a little above the limit of a smooth joint."""
TIE = 1e-9
"""Radii by which a face behind must be nearer than one in front: round-off parts the two faces of a sheet."""
NOWHERE, INSIDE, BEGIN, END = range(4)
"""Where the foot of a candidate lies; `NOWHERE`: no candidate."""
Disc = tuple[float, float, float]
"""Place and radius of a disc, m."""


def _ends(faces: Faces, f: int, px: float, py: float) -> tuple[bool, bool]:
    """Tells whether the foot of a point lies at or before the start of a face, and at or behind its end."""
    codes, shape = faces[:2]
    before = codes[f, AT_START] != ENDLESS
    if before:
        before = shape[f, TX0] * (px - shape[f, X0]) + shape[f, TY0] * (py - shape[f, Y0]) <= 0.0
    behind = codes[f, AT_END] != ENDLESS
    if behind:
        behind = shape[f, TX1] * (px - shape[f, X1]) + shape[f, TY1] * (py - shape[f, Y1]) >= 0.0
    return before, behind


def _at_joint(shape: np.ndarray, f: int, end: bool, front: bool, px: float, py: float) -> tuple[float, float, float]:
    """Signed distance of a point to one end of a face, and the unit vector from there; the face's normal on the end."""
    if end:
        vx, vy, tx, ty = shape[f, X1], shape[f, Y1], shape[f, TX1], shape[f, TY1]
    else:
        vx, vy, tx, ty = shape[f, X0], shape[f, Y0], shape[f, TX0], shape[f, TY0]
    dx, dy = px - vx, py - vy
    r = sqrt(dx * dx + dy * dy)
    if r == 0.0:
        return 0.0, -ty, tx
    if front:
        return r, dx / r, dy / r
    return -r, -dx / r, -dy / r


def _in_front(shape: np.ndarray, f: int, end: bool, px: float, py: float) -> bool:
    """Tells whether a point lies in front of the line that touches a face at one end."""
    if end:
        return shape[f, TX1] * (py - shape[f, Y1]) - shape[f, TY1] * (px - shape[f, X1]) >= 0.0
    return shape[f, TX0] * (py - shape[f, Y0]) - shape[f, TY0] * (px - shape[f, X0]) >= 0.0


def _candidate(faces: Faces, f: int, px: float, py: float) -> tuple[int, float, float, float]:
    """Candidate of a face for a point: (place of the foot, signed distance in m, normal).

    The distance is negative behind the face. A joint counts once, at the end of the face before it.
    """
    codes, shape = faces[:2]
    before, behind = _ends(faces, f, px, py)
    if not before and not behind:
        if codes[f, KIND] == ARC:
            dx, dy = px - shape[f, CX], py - shape[f, CY]
            r = sqrt(dx * dx + dy * dy)
            rho = shape[f, RADIUS]
            if r == 0.0:
                return NOWHERE, inf, 0.0, 0.0
            if rho > 0.0:
                return INSIDE, rho - r, -dx / r, -dy / r
            return INSIDE, r + rho, dx / r, dy / r
        tx, ty = shape[f, TX0], shape[f, TY0]
        return INSIDE, tx * (py - shape[f, Y0]) - ty * (px - shape[f, X0]), -ty, tx
    joint = codes[f, AT_END] if behind else codes[f, AT_START]
    front = joint == CONVEX or joint == FREE or _in_front(shape, f, behind, px, py)
    shared = False
    if joint != FREE:
        # the neighbour answers by the same function: no point falls between two answers
        if behind:
            shared = _ends(faces, codes[f, AFTER], px, py)[0]
        else:
            shared = _ends(faces, codes[f, BEFORE], px, py)[1]
    if joint == FREE or (shared and behind) or (joint == CORNER and front and not shared):
        gap, nx, ny = _at_joint(shape, f, behind, front, px, py)
        return END if behind else BEGIN, gap, nx, ny
    return NOWHERE, inf, 0.0, 0.0


def _tangent(faces: Faces, f: int, place: int, nx: float, ny: float) -> float:
    """Angle of the wall's tangent at a candidate, rad, unwrapped along the chain."""
    codes, shape = faces[:2]
    phi = shape[f, PHI]
    if place == INSIDE and codes[f, KIND] != ARC:
        return phi
    tx, ty = shape[f, TX0], shape[f, TY0]
    if place == END:
        phi += shape[f, SWEEP]
        tx, ty = shape[f, TX1], shape[f, TY1]
    angle = atan2(tx * -nx - ty * ny, tx * ny - ty * nx)
    if place == END and codes[f, AT_END] == CONVEX and angle > 0.5 * pi:
        angle -= 2.0 * pi
    return phi + angle


def _apart(faces: Faces, f: int, g: int, one: float, two: float) -> bool:
    """Tells whether contacts of faces f and g, with these tangent angles, push each on its own."""
    codes = faces.codes
    if codes[f, RUN] != codes[g, RUN]:
        return True
    turn = abs(one - two)
    if codes[f, LOOP] == 1:
        turn -= 2.0 * pi * floor(turn / (2.0 * pi))
        turn = min(turn, 2.0 * pi - turn)
    return turn > SAME_TURN


def touching(faces: Faces, deep: int, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc with one wall; returns their number.

    Parameters
    ----------
    faces : Faces
    deep : int
        1 where the wall pushes from any depth.
    near : ndarray of int64
        The faces to look at.
    disc : (float, float, float)
        Place and radius, m.
    found : ndarray, shape (MOST, 4)
        Takes signed distance (m), normal and tangent angle (rad) of each contact, the deepest first.
    which : ndarray of int64, shape (MOST,)
        Takes the face of each contact.
    """
    px, py, radius = disc
    codes, shape = faces[:2]
    if deep == 1:
        return _behind(faces, near, disc, found, which)
    nearest = deepest = lowest = inf
    touch = 0
    for f in near:
        place = NOWHERE
        if codes[f, KIND] == SEGMENT:  # as `_candidate`, without a call: most faces near a disc have no candidate
            tx, ty, dx, dy = shape[f, TX0], shape[f, TY0], px - shape[f, X0], py - shape[f, Y0]
            line = tx * dy - ty * dx
            if line >= radius or line <= -radius:
                continue
            start, end = codes[f, AT_START], codes[f, AT_END]
            if tx * dx + ty * dy <= 0.0 and start != ENDLESS:
                if start != FREE and start != CORNER:
                    continue
            elif tx * (px - shape[f, X1]) + ty * (py - shape[f, Y1]) >= 0.0 and end != ENDLESS:
                g = codes[f, AFTER]
                if end != FREE and end != CORNER:
                    if shape[g, TX0] * (px - shape[g, X0]) + shape[g, TY0] * (py - shape[g, Y0]) > 0.0:
                        continue
            else:
                place, gap, nx, ny = INSIDE, line, -ty, tx
        if place == NOWHERE:
            place, gap, nx, ny = _candidate(faces, f, px, py)
            if place == NOWHERE:
                continue
        away = abs(gap)
        if gap < 0.0:
            away += TIE * radius
        if away < lowest:
            nearest, lowest = gap, away
            if gap < 0.0:
                found[0, 0], found[0, 1], found[0, 2] = gap, nx, ny
                which[0] = f
        if gap >= 0.0 and gap < radius:
            touch += 1
            if gap < deepest:
                deepest = gap
                if nearest >= 0.0:
                    found[0, 0], found[0, 1], found[0, 2] = gap, nx, ny
                    which[0] = f
    if nearest < 0.0:
        return 1 if -nearest < radius else 0
    if touch < 2:
        return touch
    return _select(faces, near, disc, found, which)


def _out_of_reach(faces: Faces, f: int, px: float, py: float, front: float, behind: float) -> bool:
    """Tells whether a point is further in front of or behind the line of a straight face than this (m)."""
    codes, shape = faces[:2]
    if codes[f, KIND] != SEGMENT:
        return False
    line = shape[f, TX0] * (py - shape[f, Y0]) - shape[f, TY0] * (px - shape[f, X0])
    return line >= front or line <= behind


def _behind(faces: Faces, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc with a wall that pushes from any depth: each face on its own."""
    px, py, radius = disc
    kept = 0
    for f in near:
        if _out_of_reach(faces, f, px, py, radius, -inf):
            continue
        place, gap, nx, ny = _candidate(faces, f, px, py)
        if place == INSIDE and gap < radius and kept < MOST:
            found[kept, 0], found[kept, 1], found[kept, 2] = gap, nx, ny
            which[kept] = f
            kept += 1
    return kept


def _select(faces: Faces, near: np.ndarray, disc: Disc, found: np.ndarray, which: np.ndarray) -> int:
    """Contacts of a disc that several candidates touch, in front: the deepest, then those that push on their own."""
    px, py, radius = disc
    kept = 0
    while kept < MOST:
        best = radius
        for f in near:
            if _out_of_reach(faces, f, px, py, best, -best):
                continue
            place, gap, nx, ny = _candidate(faces, f, px, py)
            if place == NOWHERE or gap < 0.0 or gap >= best:
                continue
            angle = _tangent(faces, f, place, nx, ny)
            own = True
            for k in range(kept):
                own = own and (which[k] != f) and _apart(faces, f, which[k], angle, found[k, 3])
            if own:
                best = gap
                found[kept, 0], found[kept, 1], found[kept, 2], found[kept, 3] = gap, nx, ny, angle
                which[kept] = f
        if best == radius:
            break
        kept += 1
    return kept


def foot_at(faces: Faces, f: int, px: float, py: float) -> float:
    """Arc length of the foot of a point on a face, m, counted along the chain from its start.

    It names a place of the wall whatever the faces: a contact that goes on over a joint changes it by its way alone.
    """
    codes, shape = faces[:2]
    before, behind = _ends(faces, f, px, py)
    if before:
        return shape[f, ARC_LENGTH]
    if behind:
        return shape[f, ARC_LENGTH] + shape[f, LENGTH]
    tx, ty = shape[f, TX0], shape[f, TY0]
    if codes[f, KIND] == SEGMENT:
        return shape[f, ARC_LENGTH] + tx * (px - shape[f, X0]) + ty * (py - shape[f, Y0])
    dx, dy, rho = px - shape[f, CX], py - shape[f, CY], shape[f, RADIUS]
    out = ty * dx - tx * dy if rho > 0.0 else tx * dy - ty * dx  # along the radius at the start
    return shape[f, ARC_LENGTH] + abs(rho) * atan2(tx * dx + ty * dy, out)


def away(faces: Faces, f: int, px: float, py: float) -> float:
    """Distance of a point to a face, m; negative behind it, where its foot is inside."""
    shape = faces.shape
    before, behind = _ends(faces, f, px, py)
    if not before and not behind:
        return _candidate(faces, f, px, py)[1]
    first = _at_joint(shape, f, False, True, px, py)[0] if before else inf
    return min(first, _at_joint(shape, f, True, True, px, py)[0] if behind else inf)
