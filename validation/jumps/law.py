# SPDX-License-Identifier: GPL-2.0-or-later
"""Hydraulic jumps: depth ratio against the Froude number, and the momentum relation with measured thrust."""

from __future__ import annotations

from math import sqrt

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, RED, drawing
from lammps_jump.studies.validation import DERIVED, LOOKED_UP, Found, Law, Point, Row, mean_of

DEPTH, GRAVITY = 0.6, 9.81
"""Of the jet, m; m/s²."""
SPEEDS = {8.0: 1.0, 10.0: 1.0, 13.0: 1.0, 17.0: 1.0, 19.0: 0.85, 21.0: 0.7}
"""Of the jet, m/s, and the share of the sill's height that energy asks for."""


def point(speed: float, starts: int) -> Point:
    """A jet of this speed and the level tail of Bélanger's depth behind it; a sill by a share of E2 - 1.5 yc."""
    flow = speed * DEPTH
    deep = 0.5 * DEPTH * (sqrt(1 + 8 * speed**2 / (GRAVITY * DEPTH)) - 1)
    sill = SPEEDS[speed] * (deep + (flow / deep) ** 2 / (2 * GRAVITY) - 1.5 * (flow**2 / GRAVITY) ** (1 / 3))
    changes = {
        "contact.impact_speed": speed,
        "walls.sill.y": [-5, round(sill, 2)],
        "initial.0.velocity": [speed, 0],
        "initial.1.y": [0, round(deep, 2)],
        "initial.1.velocity": [round(flow / deep, 3), 0],
        "inflow.mean_speed": speed,
    }
    return Point(f"{speed:g} m/s", "jump", "jump.yaml", changes, starts, seconds=0.5 * speed)


def points(quick: bool) -> list[Point]:
    """Jets of six speeds; quick: one."""
    return [point(10.0, 1)] if quick else [point(speed, 3) for speed in SPEEDS]


def rows(found: Found) -> list[Row]:
    """Momentum with thrust, density and profiles closes; the depth ratio beside Bélanger's; jets in order."""
    made = []
    for jet, ones in found.items():
        name = f"jet of {jet}, Fr {np.mean([one['froude'] for one in ones]):.1f}"
        made += [
            Row(f"{name}: momentum that thrust, density, profile and filling leave over", 0.0, DERIVED,
                "momentum of a stretch in the frame of the front", *mean_of([one["unexplained"] for one in ones]),
                (-0.03, 0.03), "3 %: depths and thrust of one run are known within 1 to 2 %"),
            Row(f"{name}: depth behind the jump over Bélanger's, less 1", 0.0, LOOKED_UP, "Bélanger 1828; USBR EM 25",
                *mean_of([one["belanger_deviation"] for one in ones]), (-0.1, 0.1),
                "10 %: pressure and density of discs are not those of water"),
        ]  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Depth ratio against the Froude number."""
    with drawing(7.0, 4.2, 1, 1) as (made, axes):
        place = np.ravel(axes)[0]
        froude = np.linspace(1.5, 11, 50)
        place.plot(froude, 0.5 * (np.sqrt(1 + 8 * froude**2) - 1), "--", color=GREY, label="Bélanger")
        ones = [one for starts in found.values() for one in starts]
        place.plot(
            [one["froude"] for one in ones], [one["ratio"] for one in ones], "o", color=BLUE, ms=5, label="discs"
        )
        names = ("froude", "density_relation_ratio")
        means = sorted([np.mean([one[name] for one in starts]) for name in names] for starts in found.values())
        label = "hydrostatic momentum, with the\nmeasured change of density"
        place.plot(*np.transpose(means), "-x", color=RED, lw=1, ms=6, label=label)
        place.set_xlabel("Froude number of the jet in the frame of the front [1]")
        place.set_ylabel("depth behind over depth before the jump [1]")
        place.legend(frameon=False)
    return made


LAW = Law(
    "Hydraulic jumps",
    "Do momentum, and depth against the Froude number, close over a jump of discs?",
    points,
    rows,
    figure,
    (
        "With jets of 19 and 21 m/s the front walks to the inlet at the sill that energy asks for. Theirs is lower, so "
        "that it stands.",
        "At 24 and 26 m/s the inlet drowned with 0.6 of the height. At 24 m/s it drowned with half, too, and with "
        "discs of 0.1 m. So Froude numbers above 7.3 in the frame of the front are not reached.",
        "A jet of discs loses speed on its way: its Froude number before the jump is below that of the inlet.",
        "Jumps of grains on a slope are the law slope_jumps.",
    ),
)
