# SPDX-License-Identifier: GPL-2.0-or-later
"""Places of discs, inlets and gauges: in the domain, in no wall, in no other disc.

Each check raises `FieldError` with the remedy.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isinf

import numpy as np

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.packing import deepest_overlap
from lammps_jump.errors import FieldError
from lammps_jump.scene import Beginning, InletRow, Interval, MovingWall, Wall
from lammps_jump.scene.shapes import open_ends


def check_places(
    case: CaseFields,
    scene: Beginning,
    inlets: tuple[InletRow, ...],
    walls: Iterable[MovingWall],
    fields: Mapping[str, str],
    seam: Interval | None,
) -> None:
    """Refuse discs and inlets in a wall at the start, and discs that overlap by more than d/n.

    `fields`: where in the case each wall stands, by name; gates and others stand in none. `seam`: where a periodic
    channel begins and ends, m.
    """
    positions, allowed = scene.positions, 0.5 * scene.overlap_limit
    diameters = scene.diameters(np.arange(1, len(positions) + 1))
    count = len(positions)
    images = np.flatnonzero(positions[:, 0] < seam[0] + scene.largest) if seam else np.empty(0, int)
    shift = [seam[1] - seam[0], 0.0] if seam else [0.0, 0.0]
    found = deepest_overlap(
        np.concatenate([positions, positions[images] + shift]), np.concatenate([diameters, diameters[images]])
    )
    if found is not None and found[0] > allowed * (1 + 1e-9):
        overlap, *both = found
        i, j = sorted(int(one if one < count else images[one - count]) for one in both)
        field = "initial" if scene.fixed is None or not scene.fixed.holds([i + 1, j + 1]).all() else "walls"
        raise FieldError(
            field,
            f"discs {i + 1} at ({positions[i, 0]:zg}, {positions[i, 1]:zg}) and {j + 1} at "
            f"({positions[j, 0]:zg}, {positions[j, 1]:zg}) overlap by {overlap:z.3g} m at the start; allowed is d/n = "
            f"{allowed:z.3g} m; {_less_jitter(case) if field == 'initial' else ''}move them apart",
        )
    if scene.fixed is not None:
        positions, diameters = positions[: scene.fixed.first - 1], diameters[: scene.fixed.first - 1]
    for one in walls:
        field = fields.get(one.wall.name, "initial")
        if wall := one.at(0):
            _check_discs_free_of(wall, field, case, positions, diameters, allowed)
        if isinf(one.motion.gone):
            _check_inlets_free_of(one.wall, inlets, scene.largest)


def gauges(case: CaseFields, room: Interval) -> tuple[float, ...]:
    """Places of the gauges along x (m), in the room of the domain and each once."""
    (low, high), asked = room, case.probes.gauges
    for index, place in enumerate(asked):
        if not low < place < high:
            where = "at the end of" if place in (low, high) else "outside"
            raise FieldError(
                f"probes.gauges.{index}",
                f"{place:zg} m is {where} the domain; allowed is above {low:zg} m and below "
                f"{high:zg} m: move the gauge or widen the domain",
            )
        if place in asked[:index]:
            raise FieldError(f"probes.gauges.{index}", f"{place:zg} m is there already: name each place once")
    return asked


def check_in_domain(
    case: CaseFields, positions: np.ndarray, inlets: Sequence[InletRow], domain: Sequence[Interval]
) -> None:
    """Refuse discs and inlets outside the domain."""
    for axis, label in enumerate("xy"):
        low, high = domain[axis]
        on_seam = axis == 0 and case.seam is not None
        outside = np.flatnonzero((positions[:, axis] <= low - on_seam * 1e-9) | (positions[:, axis] >= high))
        if outside.size:
            value = positions[outside[0], axis]
            raise FieldError(
                f"{'domain' if case.domain else 'initial'}",
                f"disc {outside[0] + 1} starts at {label} = {value:zg} m, "
                f"outside the domain [{low:zg}, {high:zg}]; widen domain.{label}",
            )
        for row in inlets:
            if not low < (row.x, row.y)[axis] < high:
                raise FieldError(
                    "inflow",
                    f"the inlet at {label} = {(row.x, row.y)[axis]:zg} m is outside domain.{label} "
                    f"[{low:zg}, {high:zg}]",
                )


def check_bodies_in_domain(
    walls: Iterable[MovingWall], fields: Mapping[str, str], domain: Sequence[Interval]
) -> list[str]:
    """Refuse bodies whose centre of mass is outside the domain at the start; sentences on such as reach out of it."""
    notes = []
    for one in walls:
        free, wall = one.motion.free, one.first
        if free is None:
            continue
        centre = np.ravel(one.placed.outward(*np.array(free.centre).reshape(2, 1)))
        for axis, label in enumerate("xy"):
            (low, high), ends = domain[axis], wall.extent[axis]
            if not low <= centre[axis] <= high:
                raise FieldError(
                    fields[wall.name],
                    f"body '{wall.name}' has its centre of mass at {label} = {centre[axis]:z.4g} m, outside the domain "
                    f"[{low:zg}, {high:zg}]; widen domain.{label}, or move the body",
                )
            for out, end in ((low - ends[0], low), (ends[1] - high, high)):
                if out > 0:
                    notes.append(
                        f"body '{wall.name}' reaches {out:z.3g} m beyond the edge of the domain, {label} = {end:zg} m, "
                        "at the start: discs there are lost, and the run ends where its centre of mass leaves; widen "
                        f"domain.{label}, or move the body"
                    )
    return notes


def _less_jitter(case: CaseFields) -> str:
    """The remedy where discs are shifted at random; empty where none are."""
    asked = [(f"initial[{k}].jitter", item.jitter) for k, item in enumerate(case.initial) if item.jitter]
    if not asked:
        return ""
    field, jitter = asked[0]
    return (
        f"lower {field}, which shifts each disc by up to {jitter * case.discs.diameter:z.3g} m ({jitter:zg} diameters) "
        "along x and y, or "
    )


def _check_discs_free_of(
    wall: Wall,
    field: str,
    case: CaseFields,
    positions: np.ndarray,
    diameters: np.ndarray,
    allowed: float,
) -> None:
    if not len(positions):
        return
    depth = depths(wall, positions, diameters)
    worst = int(np.argmax(depth))
    turned = (
        "; a line pushes discs on its left: reverse its points if they belong there" if open_ends(wall.faces) else ""
    )
    if depth[worst] > allowed * (1 + 1e-9):
        raise FieldError(
            field,
            f"disc {worst + 1} at ({positions[worst, 0]:zg}, {positions[worst, 1]:zg}) starts "
            f"{depth[worst]:z.3g} m deep in wall '{wall.name}'; allowed is d/n = {allowed:z.3g} m; {_less_jitter(case)}"
            f"move the wall or the discs{turned}",
        )


def depths(wall: Wall, positions: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Depth of discs in a wall, m, shape (n,): below 0 beside it, minus infinity where it does not push them."""
    gap = wall.distance(positions[:, 0], positions[:, 1])
    if open_ends(wall.faces):  # it pushes nothing that is a radius behind it
        gap = np.where(gap < -diameters / 2, np.inf, gap)
    return diameters / 2 - gap


def _check_inlets_free_of(wall: Wall, inlets: tuple[InletRow, ...], largest: float) -> None:
    if not inlets:
        return
    distances = wall.distance(*np.array([(row.x, row.y) for row in inlets]).T)
    if open_ends(wall.faces):  # it pushes nothing that is a radius behind it
        distances = np.where(distances < -largest / 2, np.inf, distances)
    for number, (row, distance) in enumerate(zip(inlets, distances.tolist(), strict=True), 1):
        if distance < largest / 2 * (1 - 1e-6):
            raise FieldError(
                "inflow",
                f"row {number} enters at ({row.x:zg}, {row.y:zg}), {largest / 2 - distance:z.3g} m deep in "
                f"wall '{wall.name}'; move the inlet (inflow.x, inflow.y) or the wall",
            )
