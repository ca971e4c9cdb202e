# SPDX-License-Identifier: GPL-2.0-or-later
"""The slope at which a layer of grains at rest begins to flow, beside that at which one stops."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, drawing
from lammps_jump.studies.validation import SECOND_HAND, Found, Law, Point, Row, mean_of

STOPS = 16.5
"""Slope at which a layer of the same grains stops, degrees, ± 0.5: the law inclined_flow."""


def points(quick: bool) -> list[Point]:
    """Layers whose slope rises in steps; quick: one, in two steps."""
    if quick:
        options = {"seed": 1, "slopes": [8.0, 12.0, 26.0], "settle": 0.5, "each": 0.3}
        return [Point("layer 1", "starts", options=options, seconds=2)]
    slopes = [8.0, *np.arange(14.0, 26.1, 0.5).tolist()]
    return [
        Point(
            f"layer {seed}", "starts", options={"seed": seed, "slopes": slopes, "settle": 2.0, "each": 1.0}, seconds=25
        )
        for seed in (1, 2, 3, 4)
    ]


def rows(found: Found) -> list[Row]:
    """The starting angle, and that it is not below the stopping one."""
    ones = [one for layers in found.values() for one in layers if one["flows"] is not None]
    angles = [0.5 * (one["flows"] + one["rests"]) for one in ones]
    mean, half = mean_of(angles)
    wide = max(one["flows"] - one["rests"] for one in ones) / 2
    interval = half if half > wide else wide
    made = [
        Row("slope at which a layer of 15 d begins to flow, degrees", None, "", "", mean, interval,
            reason="no number for discs was found; the interval is at least half a step")
    ]  # fmt: skip
    if len(ones) > 1:
        made.append(
            Row("the same less the slope at which it stops, degrees", "not below 0", SECOND_HAND,
                "GDR MiDi 2004: a layer starts at a larger angle than it stops", mean - STOPS, interval, (-0.5, np.inf),
                "the stopping angle is known to 0.5 degrees")
        )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Mean velocity at the end of each step against the slope."""
    with drawing(6.2, 3.8, 1, 1) as (made, axes):
        place = np.ravel(axes)[0]
        for layers, style in zip(found.values(), ("-o", "--s", "-.^", ":D"), strict=False):
            for one in layers:
                place.plot(one["slopes"][1:], one["speeds"][1:], style, color=BLUE, mfc="none", ms=4)
        place.axvline(STOPS, color=GREY, ls="--", label="a layer stops")
        place.axhline(0.01, color=GREY, lw=0.8, label="counted as flow")
        place.set_xlabel("slope, degrees")
        place.set_ylabel("mean velocity after a step / sqrt(g d)")
        place.legend(frameon=False)
    return made


LAW = Law(
    "Starting angle",
    "At which slope does a layer of grains at rest begin to flow?",
    points,
    rows,
    figure,
    (
        "The layer of inclined_flow settles at 8 degrees. Then the slope rises by half a degree a second.",
        "Each step begins with discs at rest and springs of zero length where the one before ended. That lets a layer "
        "creep a little, and the angle may be low by that.",
    ),
)
