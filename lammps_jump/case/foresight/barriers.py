# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that a flow is to meet and never does: outlets before them, floors that end before them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lammps_jump.case.fields import CaseFields
from lammps_jump.scene import Beginning, InletRow, MovingWall, Outlet
from lammps_jump.scene.free import Free
from lammps_jump.scene.shapes import open_ends
from lammps_jump.scene.tracks import Held
from lammps_jump.scene.walls import Wall, bed_height

SAMPLES = 400
"""Places along the ground before a wall that are looked at."""
WIDE = 1.0
"""Width of a gap in the ground from which on it is named, in diameters of the largest disc."""


class Barrier(NamedTuple):
    """A wall that stands on the ground in the way of the flow.

    `side` is 1 where the flow comes to it along x, and -1 against it; `face` is where they meet, m. `x` are places from
    the far end of the flow to the face, and `bed` the height of the ground there without the wall, NaN without any, m.
    """

    wall: Wall
    side: int
    face: float
    x: np.ndarray
    bed: np.ndarray


def never_met(
    case: CaseFields, begun: Beginning, inlets: Sequence[InletRow], walls: Sequence[MovingWall],
    outlets: Sequence[Outlet],
) -> list[str]:  # fmt: skip
    """Sentences on outlets in the flow, and on ground that ends before a wall that stands in its way.

    Parameters
    ----------
    case : CaseFields
    begun : Beginning
    inlets : sequence of InletRow
    walls : sequence of MovingWall
        Without gates that vanish at t = 0.
    outlets : sequence of Outlet
    """
    loose = begun.positions if begun.fixed is None else begun.positions[: begun.fixed.first - 1]
    found = _in_the_flow(case, loose, inlets, outlets)
    xs = [*loose[:, 0], *(row.x for row in inlets)]
    if not case.gravity or not xs or case.seam:
        return found
    told: dict[object, str] = {}  # an outlet or a gap before several walls is told once
    for barrier in _barriers(walls, begun, (float(min(xs)), float(max(xs)))):
        place = f"wall '{barrier.wall.name}' at x = {barrier.face:zg} m"
        drained = [one for one in outlets if _drains(one, barrier, begun)]
        for one in drained:
            told.setdefault(
                one,
                f"{_field(case, outlets, one)} lies before {place}, in its tail water: it takes out what the wall is "
                "to hold back; move the outlet behind the wall, or below the ground",
            )
        if not drained and (gap := _gap(barrier, begun)):
            near, far = gap
            told.setdefault(
                near,
                f"the ground ends at x = {near:z.4g} m, and {abs(far - near):z.3g} m are without any before {place}: "
                "discs fall through; let the floor reach to the wall",
            )
    return found + list(told.values())


def _field(case: CaseFields, outlets: Sequence[Outlet], one: Outlet) -> str:
    """Name of an outlet in the case."""
    index = list(outlets).index(one)
    ((name, at),) = case.outflow[index].model_dump(exclude_none=True).items()
    return f"outflow[{index}].{name}: {at:zg} m"


def _beyond(one: Outlet, places: np.ndarray) -> np.ndarray:
    """Tells whether places, shape (n, 2), lie where an outlet takes discs out."""
    values = places[:, "xy".index(one.axis)]
    return values > one.at if one.side == "above" else values < one.at


def _in_the_flow(
    case: CaseFields, loose: np.ndarray, inlets: Sequence[InletRow], outlets: Sequence[Outlet]
) -> list[str]:
    """Sentences on outlets that discs stand beyond at the start, or that an inflow enters beyond."""
    found, rows = [], np.array([(row.x, row.y) for row in inlets]).reshape(-1, 2)
    for one in outlets:
        gone, entering = int(_beyond(one, loose).sum()), int(_beyond(one, rows).sum())
        if gone:
            found.append(
                f"{_field(case, outlets, one)} takes {gone} of the {len(loose)} discs out at once that are there at "
                "the start, as they stand beyond it; move it out of the flow"
            )
        if entering:
            found.append(
                f"{_field(case, outlets, one)} takes discs out as they enter: {entering} of the {len(rows)} rows of "
                "the inflow lie beyond it; move it out of the flow"
            )
    return found


def _barriers(walls: Sequence[MovingWall], begun: Beginning, ends: tuple[float, float]) -> Iterator[Barrier]:
    """Solids that stand on the level of the ground before them and reach above it, beside discs that lie there.

    `ends`: least and largest x of the discs and inlets, m.
    """
    for one in walls:
        wall, kind = one.wall, one.motion.kind
        if not (_stays(one) or isinstance(kind, Free)) or not wall.finite or wall.hollow or open_ends(wall.faces):
            continue
        (left, right), (low, top) = one.first.extent
        others = [other.wall for other in walls if other is not one and _stays(other)] + list(begun.beds)
        for side, begin, face in ((1, ends[0], left), (-1, ends[1], right)):
            if side * (face - begin) <= 0:
                continue
            x = np.linspace(begin, face, SAMPLES + 1)[:-1]
            bed = bed_height(others, x, begun.smallest)
            known = bed[np.isfinite(bed)]
            if known.size and low <= known[-1] + begun.smallest and top > known[-1] + begun.largest:
                yield Barrier(wall, side, face, x, bed)


def _stays(one: MovingWall) -> bool:
    """Tells whether a wall stays where it is, but for a gate that holds a flow."""
    return one.motion.kind is None or isinstance(one.motion.kind, Held)


def _drains(one: Outlet, barrier: Barrier, begun: Beginning) -> bool:
    """Tells whether an outlet lies in the flow before a wall: across its way, or above the ground there."""
    if one.axis == "x":
        room = barrier.side * (barrier.face - one.at)
        return (one.side == "above") == (barrier.side > 0) and room > begun.largest
    low = one.side == "below" and np.isfinite(barrier.bed) & (barrier.bed + 0.5 * begun.smallest < one.at)
    return bool(np.any(low))


def _gap(barrier: Barrier, begun: Beginning) -> tuple[float, float] | None:
    """Begin and end of a gap in the ground before a wall, from the side of the flow, m; None where there is none."""
    x, bare = np.append(barrier.x, barrier.face), np.append(np.isnan(barrier.bed), False)
    known = int(np.argmin(bare))  # the first place with ground
    if not bare[known:].any():
        return None
    first = known + int(np.argmax(bare[known:]))
    last = first + int(np.argmin(bare[first:]))
    near, far = float(x[first - 1]), float(x[last])
    return (near, far) if abs(far - near) > WIDE * begun.largest else None
