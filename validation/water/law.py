# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs in the place of water: the front of a collapsing column."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, drawing
from lammps_jump.studies.validation import SECOND_HAND, Found, Law, Point, Row, around, mean_of

SOURCE = "Martin & Moyce 1952, Phil. Trans. R. Soc. A 244, 312, as tabled in later sources"


def points(quick: bool) -> list[Point]:
    """Columns of n² = 2 and 1; quick: one coarse column."""
    if quick:
        coarse = {"discs.diameter": 0.25, "initial.0.settle": 0.5, "run.duration": 2.4}
        return [Point("n² = 2", "column", "column.yaml", coarse, 1, seconds=3)]
    square = {"initial.0.y": [0, 4.25], "run.duration": 2.6}
    return [
        Point("n² = 2", "column", "column.yaml", {}, 5, seconds=40),
        Point("n² = 1", "column", "column.yaml", square, 5, seconds=20),
    ]


def rows(found: Found) -> list[Row]:
    """The front lags water by up to a fifth; its height is told."""
    made = []
    for name, ones in found.items():
        table = ones[0]["slope_of_table"]
        mean, half = mean_of([one["slope"] for one in ones])
        reason = "20 %, as the front"
        words = f"{name}: slope dZ/dT of the front"
        made.append(Row(words, table, SECOND_HAND, SOURCE, mean, half, around(table, 0.2), reason))
        if ones[0]["mean_bulk"] is None:
            continue
        mean, half = mean_of([one["mean_bulk"] for one in ones])
        reason = "discs have a yield stress and lag: −20 to 0 % by trials of several kinds of contact"
        why = "e 0.95 and sizes ±20 % bring the discs nearer to water than those trials"
        words = f"{name}: front over that of water, less 1 (T > 0.8)"
        made.append(Row(words, 0.0, SECOND_HAND, SOURCE, mean, half, (-0.2, 0.0), reason, why))
        mean, half = mean_of([one["rms_height"] for one in ones])
        words = f"{name}: height of the column, rms off water"
        made.append(Row(words, None, "", "", mean, half, None, "no limit was found"))
    return made


def figure(found: Found) -> Figure:
    """Deviation of the front's slope, of each start."""
    with drawing(7.0, 3.4, 1, 1) as (made, axes):
        place = np.ravel(axes)[0]
        for number, (name, ones) in enumerate(found.items()):
            place.plot(
                [number] * len(ones),
                [100 * (one["slope"] / one["slope_of_table"] - 1) for one in ones],
                "o",
                color=BLUE,
                mfc="white",
            )
            place.annotate(name, (number, 2), ha="center")
        place.axhspan(-20, 20, color=GREY, alpha=0.2)
        place.set_xticks([])
        place.set_xlim(-0.5, len(found) - 0.5)
        place.set_ylim(-35, 35)
        place.set_ylabel("slope of the front off water [%]")
    return made


LAW = Law(
    "Discs as water",
    "For which questions do discs serve as water?",
    points,
    rows,
    figure,
    (
        "They serve for the depth ratio and the momentum of a jump, and for the front of a dam break within a fifth.",
        "They do not serve for ripples, turbulence, air, surface tension, sloshing of more than one swing, or anything "
        "thinner than some discs: take SPH, a volume-of-fluid code or shallow-water equations.",
        "Koshizuka & Oka's column and the impulse of Lobovský et al. 2014 are not held here yet.",
    ),
)
