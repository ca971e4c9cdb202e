# SPDX-License-Identifier: GPL-2.0-or-later
"""Players on the page of a study: of the members of a case by a list, of the points of a study by sliders.

A slider for each axis shows the run there, with its curve and its numbers.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from math import ceil, inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.report import run as report
from lammps_jump.analysis.report.handed_on import read_player
from lammps_jump.analysis.report.page import Boxes, Curve, NumberBox, Player, PlayerChoice, Slider, Text
from lammps_jump.analysis.report.player import make_player
from lammps_jump.errors import DumpError
from lammps_jump.files import PLAYER
from lammps_jump.runs.results import flow_of, packed
from lammps_jump.runs.run import Run
from lammps_jump.runs.summary import results_in
from lammps_jump.sweeps.study import axis_unit, axis_words
from lammps_jump.sweeps.study_folder import StudyResults
from lammps_jump.sweeps.table import flat
from lammps_jump.units import shown

LARGEST = 10_000_000
"""Bytes of the packed frames on a page: eight members of most scenes."""


def player_of(run: Run) -> Player:
    """The player that a run has kept.

    Raises
    ------
    OSError
        It has none: no frame holds a disc.
    ValueError
        The file is damaged.
    """
    results_in(run.folder, run.summary).require_same(PLAYER)
    return read_player(run.folder / PLAYER)


def by_member(found: StudyResults) -> list[PlayerChoice | Text]:
    """One player for the members of a case, as many as the page has room for; nothing where none has frames.

    Members stand in the order of their distance from the means: the sum of squares of ``(number - mean) / sd``.
    """
    numbers = found.values[[item.path for item in found.study.collect]]
    apart = ((numbers - numbers.mean()) / numbers.std()) ** 2
    order = np.argsort(apart.dropna(axis=1, how="all").fillna(inf).sum(axis=1), kind="stable")
    kept: dict[int, Player] = {}
    damaged: list[int] = []
    room = LARGEST
    for number in order:
        seed = int(found.values["seed"][number])
        try:
            player = player_of(found.runs[number])
        except OSError:  # without discs in its frames
            continue
        except ValueError:  # a DumpError is one
            damaged.append(seed)
            continue
        room -= len(player.frames)
        if room >= 0 or not kept:
            kept[seed] = player
        if room <= 0:
            break
    seeds = ", ".join(map(str, sorted(damaged)))
    without = f"Members without a player ({PLAYER} is damaged): {seeds}." if damaged else ""
    if not kept:
        return [Text(without, "small")] if damaged else []
    first, listed = next(iter(kept)), sorted(kept)
    text = f"Member {first} is shown first: its numbers are nearest to the means."
    if left := len(order) - len(kept) - len(damaged):
        text += f" There is no room for {left} of {len(order)} members, those farthest from the means."
    chosen = PlayerChoice([kept[seed] for seed in listed], [f"Member {seed}" for seed in listed], listed.index(first))
    return [chosen, Text(f"{text} {without}".strip(), "small")]


log = logging.getLogger("lammps_jump")


class PlayerPoint(NamedTuple):
    """Point on the page: its number, a run of it, and the player of that run."""

    number: int
    run: Run
    player: Player


def by_point(found: StudyResults) -> list[PlayerChoice | Text]:
    """One player for the points of a study, with a slider for each axis; nothing where no run has frames.

    Each point is shown by the member that is nearest to its means. Where all of them together are larger than
    `LARGEST`, every second frame of each is shown, every third, and so on.
    """
    study = found.study
    chosen = _nearest(found)
    points, damaged = _players(found.runs, chosen)
    if not points:
        return []
    first = len(points) // 2
    axes = [
        Slider(axis_words(axis.name), [shown(value, axis_unit(axis.name)) for value in axis.values])
        for axis in study.axes
    ]
    grid = list(np.ndindex(*(len(axis.values) for axis in study.axes)))
    names = [
        ", ".join(f"{axis.label} {axis.values[i]}" for axis, i in zip(axes, grid[p.number], strict=True))
        for p in points
    ]
    sides = [_side(found, point) for point in points]
    choice = PlayerChoice([p.player for p in points], names, first, axes, [grid[p.number] for p in points], sides)
    said = []
    if len(found.values) > len(chosen):
        said.append("Each point is shown by the start whose numbers are nearest to its means.")
    if missing := len(study.points) - len(points):
        said.append(f"{missing} of {len(study.points)} points have no finished run with frames.")
    if damaged:
        said.append(f"Damaged players, left out: {', '.join(damaged)}.")
    return [choice, *([Text(" ".join(said), "small")] if said else [])]


def _nearest(found: StudyResults) -> dict[int, int]:
    """Row of `StudyResults.values` of the member of each point that is nearest to its means."""
    numbers = found.values.set_index("point")[[item.path for item in found.study.collect]].astype(float)
    apart = ((numbers - numbers.groupby("point").mean()) / numbers.groupby("point").std()) ** 2
    order = np.argsort(apart.sum(axis=1), kind="stable")  # a sum leaves out what is not known
    chosen = {int(numbers.index[row]): int(row) for row in order[::-1]}
    return dict(sorted(chosen.items()))


def _players(runs: Sequence[Run], chosen: dict[int, int]) -> tuple[list[PlayerPoint], list[str]]:
    """The players of the points that have one, and the points whose player is damaged."""
    there, damaged = [], []
    for number, row in chosen.items():
        try:
            there.append(PlayerPoint(number, runs[row], player_of(runs[row])))
        except OSError:  # without discs in its frames
            continue
        except ValueError:  # a DumpError is one
            damaged.append(str(number))
    every = ceil(sum(len(point.player.frames) for point in there) / LARGEST)
    if every > 1:
        there = [point._replace(player=_thinned(point.run, point.player, every)) for point in there]
    return there, damaged


def _thinned(run: Run, player: Player, every: int) -> Player:
    """The player of a run with every n-th of its frames; as it is where its dump is gone."""
    try:
        fewer = make_player(packed(flow_of(run.case, run.folder), run.folder, every), run.folder)
    except DumpError as error:
        log.info(f"note: the player of {run.folder} is not thinned: {error}")
        return player
    return fewer._replace(still=None) if fewer is not None else player


def _side(found: StudyResults, point: PlayerPoint) -> list[Boxes | Curve]:
    """Numbers of a point, means over its starts, and the curves of the run that is shown."""
    study, frame = found.study, flat(found.table, found.study)
    boxes = []
    for item in study.collect:
        mean, high = (item.scale * float(frame[name][point.number]) for name in (item.path, f"{item.path}_high"))
        error = shown(high - mean, digits=2) if np.isfinite(high - mean) else ""
        count = int(frame[f"{item.path}_n"][point.number])
        boxes.append(NumberBox(item.heading, mean if np.isfinite(mean) else None, "", error, f"n = {count}"))
    return [Boxes(boxes), *_curves(point.run.folder)]


def _curves(folder: Path) -> list[Curve]:
    """The curve of a run over the channel, or else its first one; none where they cannot be read."""
    try:
        found = report.curves(folder)
    except DumpError:
        return []
    return list(found.values())[:1]
