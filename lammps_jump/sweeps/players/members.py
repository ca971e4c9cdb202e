# SPDX-License-Identifier: GPL-2.0-or-later
"""The player of the members of a case."""

from __future__ import annotations

from math import inf

import numpy as np

from lammps_jump.analysis.report.page import Player, PlayerChoice, Text
from lammps_jump.analysis.report.player_check import read_player
from lammps_jump.files import PLAYER
from lammps_jump.runs.run import Run
from lammps_jump.runs.summary import results_in
from lammps_jump.sweeps.study_folder import StudyResults

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
