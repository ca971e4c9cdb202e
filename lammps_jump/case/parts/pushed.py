# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies, lids and tailgates of earlier runs: which of them go on in a case, and where they begin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, inf
from typing import NamedTuple

import numpy as np

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.text import Runs
from lammps_jump.dump.walls import PushedWalls, outline_of, went_of
from lammps_jump.physics.elementary import cos, hypot, sin
from lammps_jump.scene import Wall, Went
from lammps_jump.scene.motion import Placed, Pose

from .base import EarlierRun

NOUNS = {"free": "body", "load": "lid", "hold": "tailgate"}
"""What walls are called, by how they move."""
SAME = 1e-9
"""Difference of outlines that is round-off, over the size of a wall."""
LEAST_TURN = 1e-3
"""Turn in degrees from which on it is named."""


class Pushable(NamedTuple):
    """A wall of a case whose pose is state: its place there, how it moves, point of turning (m) and release (s)."""

    wall: Wall
    kind: str
    about: tuple[float, float]
    begin: float


@dataclass(frozen=True)
class GoingOn:
    """State of the walls of a case from earlier runs.

    Attributes
    ----------
    walls : mapping of str to Went
        Those that go on, by name.
    left : mapping of int to frozenset of str
        By the number of the item of ``initial``: walls of its run that do not go on from there.
    said : tuple of str
        Which go on, begin anew and stay behind, in words.
    """

    walls: Mapping[str, Went] = field(default_factory=dict)
    left: Mapping[int, frozenset[str]] = field(default_factory=dict)
    said: tuple[str, ...] = ()

    def placed(self, one: Wall, about: Mapping[str, tuple[float, float]]) -> Wall:
        """A wall where it begins."""
        went = self.walls.get(one.name)
        return one if went is None else Placed(one, went.pose, about[one.name])


def going_on(case: CaseFields, runs: Runs, pushed: Sequence[Pushable]) -> GoingOn:
    """Walls of a case that go on from the runs that its discs come from: those of the same name, motion and outline.

    Parameters
    ----------
    case : CaseFields
    runs : mapping of tuple to StartState
        `CaseSource.begun`.
    pushed : sequence of Pushable
        Of the case.
    """
    walls: dict[str, Went] = {}
    left: dict[int, frozenset[str]] = {}
    said: list[str] = []
    own, anew = {one.wall.name: one for one in pushed}, dict.fromkeys((one.wall.name for one in pushed), "")
    items = [(index, item) for index, item in enumerate(case.initial) if isinstance(item, EarlierRun)]
    for index, item in items:
        state, behind = runs["initial", index].state.walls, set()
        for name, kind in zip(state.names, state.kinds, strict=True):
            one, noun = own.get(name), f"{NOUNS.get(kind, 'wall')} '{name}'"
            if one is None:
                behind.add(name)
                said.append(f"{noun} of {item.folder} stays behind: this case has none of that name")
            elif why := _unlike(one, item, state, walls):
                behind.add(name)
                anew[name] = f"{why} in {item.folder}"
            elif state.row(name)["released"]:
                walls[name] = _went(one, item, state)
                said.append(_told(one, walls[name], noun, item))
            else:
                said.append(f"{noun} is still held in {item.folder}: it waits here until from, {one.begin:zg} s")
                anew.pop(name, None)
        left[index] = frozenset(behind)
    for name, why in anew.items() if items else ():
        if name not in walls:
            known = all(runs["initial", index].state.walls.known for index, _ in items)
            there = " and ".join(item.folder for _, item in items)
            why = why or (f"{there} has none of that name" if known else f"{there} kept nothing of it")
            said.append(f"{NOUNS[own[name].kind]} '{name}' begins anew, where this case has it: {why}")
    return GoingOn(walls, left, tuple(said))


def _unlike(one: Pushable, item: EarlierRun, state: PushedWalls, taken: Mapping[str, Went]) -> str:
    """Why a wall does not go on; empty where it does."""
    name = one.wall.name
    if name in taken:
        return "it goes on from another run, and there is one of its name"
    if state.kinds[state.names.index(name)] != one.kind:
        return f"it is a {NOUNS.get(state.kinds[state.names.index(name)], 'wall')}"
    old, new = state.outline(name), outline_of(one.wall)
    size = float(np.ptp(new[:, :2], axis=0).max()) or 1.0
    if len(old) != len(new) or np.abs(new - old - (*(new - old)[0, :2], 0.0)).max() > SAME * size:
        return "it has another outline"
    row, (dx, dy) = state.row(name), (new - old)[0, :2]
    if hypot(*(one.about - row["about"] - (dx, dy))) > SAME * size:
        return "it turns about another point"
    x, y = _centre(row)
    ends = item.within
    outside = ends is not None and any(
        not low <= value <= high
        for value, (low, high) in ((x, ends.x or (-inf, inf)), (y, ends.y or (-inf, inf)))
    )  # fmt: skip
    return "it lies outside of within" if outside else ""


def _centre(row: np.void) -> tuple[float, float]:
    """Centre of mass of a wall of an earlier run, m."""
    (x, y, angle), (ax, ay) = row["place"].tolist(), row["arm"].tolist()
    c, s = cos(angle), sin(angle)
    return row["about"][0] + x + c * ax - s * ay, row["about"][1] + y + s * ax + c * ay


def _went(one: Pushable, item: EarlierRun, state: PushedWalls) -> Went:
    """State of a wall that goes on, from its run."""
    row = state.row(one.wall.name)
    dx, dy = (outline_of(one.wall) - state.outline(one.wall.name))[0, :2].tolist()
    way = item.shift[0] - dx, item.shift[1] - dy
    x, y, angle = row["place"].tolist()
    went = went_of(row, Pose(x + way[0], y + way[1], angle))
    if went.listed is not None:
        went = replace(went, listed=Pose(went.listed.x + way[0], went.listed.y + way[1], went.listed.angle))
    if item.velocities == "rest":
        went = replace(went, speed=Pose(), half=None, before=None, force=None)
    return went


def _told(one: Pushable, went: Went, noun: str, item: EarlierRun) -> str:
    """A sentence on a wall that goes on."""
    x, y, angle = went.pose
    turned = f" and turned by {degrees(angle):z.3g} degrees" if abs(degrees(angle)) >= LEAST_TURN else ""
    released = "; it is free from the start, whatever from says" if one.begin > 0 and one.kind != "hold" else ""
    moved = f"moved by ({x:z.4g}, {y:z.4g}) m{turned}"
    return f"{noun} goes on from {item.folder}, {moved} from where this case has it{released}"


def renumbered(contacts: np.ndarray, column: str, old: Sequence[str], new: Sequence[str]) -> np.ndarray:
    """Contacts whose `disc` is 1 + the number of a name, or `partner` -1 - that, by new names; none of others."""
    place = {name: number for number, name in enumerate(new)}
    numbers = np.array([place.get(name, -1) for name in (*old, "")])
    sign = -1 if column == "partner" else 1
    found = numbers[sign * contacts[column] - 1]
    kept = contacts[found >= 0].copy()
    kept[column] = sign * (1 + found[found >= 0])
    return kept
