# SPDX-License-Identifier: GPL-2.0-or-later
"""Jumps of grains on a slope: from diffuse to steep, the zone at rest before the sill, the balance of momentum."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, drawing
from lammps_jump.studies.validation import DERIVED, LOOKED_UP, Found, Law, Point, Row, mean_of

SLOPES = (26.0, 28.0, 30.0, 32.0)
"""Degrees."""
RELATION = (
    "`sequent_ratio` of lammps_jump.physics.jump: the ingredients of the relation of Méjean, Faug & Einav 2017, "
    "J. Fluid Mech. 816, by its abstract"
)


def points(quick: bool) -> list[Point]:
    """A jet of 8 m/s down chutes of four slopes; quick: one, for a shorter time."""
    if quick:
        changes = {"slope": 28.0, "run.duration": 8, "analysis.window": [5, 8]}
        return [Point("28 degrees", "chute", "chute.yaml", changes, 1, seconds=4)]
    return [Point(f"{slope:g} degrees", "chute", "chute.yaml", {"slope": slope}, 4, seconds=7) for slope in SLOPES]


def _degrees(name: str) -> float:
    return float(name.split()[0])


def _line(found: Found, number: str) -> tuple[float, float]:
    """Slope of the straight line of a number against the degrees, with its 95 % interval over the starts."""
    starts = min(len(ones) for ones in found.values())
    degrees = [_degrees(name) for name in found]
    lines = [np.polyfit(degrees, [ones[start][number] for ones in found.values()], 1)[0] for start in range(starts)]
    return mean_of([float(one) for one in lines])


def rows(found: Found) -> list[Row]:
    """Momentum closes; front and zone at rest shorten with the slope; the rest is told."""
    made = []
    reason = (
        "5 %: the thrust at the inlet, 3 % of what flows in, is that upstream of the front; at the fall it is left out"
    )
    source = "momentum along the bed with weight, bed and sill; the forces that Méjean, Faug & Einav 2017 name"
    for name, ones in found.items():
        mean, half = mean_of([one["left"] for one in ones])
        words = f"{name}: momentum that flow, thrust, weight, bed and sill leave over"
        made.append(Row(words, 0.0, DERIVED, source, mean, half, (-0.05, 0.05), reason))
    if len(found) > 1:
        mean, half = _line(found, "rest")
        made.append(
            Row(
                "zone at rest before the sill, change with the slope, m a degree",
                "falls",
                LOOKED_UP,
                "Kassab 1999, abstract",
                mean,
                half,
                (-np.inf, 0.0),
                "a trend: numbers were not found",
            )
        )
        mean, half = _line(found, "front")
        made.append(
            Row(
                "length of the front (10 to 90 % of the rise), change with the slope, m a degree",
                "falls",
                LOOKED_UP,
                "Faug 2014, abstract: diffuse to strong",
                mean,
                half,
                (-np.inf, 0.0),
                "a trend: numbers were not found",
            )
        )
    reason = (
        "the relation is hydrostatic, and the grains behind the front are not; no limit was set before the first runs"
    )
    for name, ones in found.items():
        mean, half = mean_of([one["relation"] for one in ones])
        words = f"{name}: y2/y1 over the relation with density, weight and bed, less 1"
        made.append(Row(words, 0.0, DERIVED, RELATION, mean, half, None, reason))
    fits = {
        "presses": "thrust behind the front over that of water as heavy and high",
        "rest": "zone at rest before the sill, m",
        "front": "length of the front, m",
        "belanger_deviation": "y2 over Bélanger's, less 1",
        "speed": "speed of the front, m/s",
        "bed": "friction of the bed / momentum that flows in",
    }
    for name, ones in found.items():
        for number, words in fits.items():
            mean, half = mean_of([one[number] for one in ones])
            made.append(Row(f"{name}: {words}", None, "", "", mean, half, reason="no number was found"))
    return made


def figure(found: Found) -> Figure:
    """Depth along the chute, and the lengths against the slope."""
    with drawing(9.0, 3.8, 1, 2) as (made, axes):
        left, right = np.ravel(axes)
        styles = ("-", "--", "-.", ":")
        for (name, ones), style in zip(found.items(), styles, strict=False):
            left.plot(ones[0]["x"], np.mean([one["depth"] for one in ones], axis=0), style, color=BLUE, label=name)
        left.set_xlabel("x along the bed [m]")
        left.set_ylabel("mass depth [m]")
        left.legend(frameon=False)
        for number, mark, words, colour in (("front", "o", "front", BLUE), ("rest", "s", "zone at rest", GREY)):
            for count, (name, ones) in enumerate(found.items()):
                values = [one[number] for one in ones]
                label = words if count == 0 else None
                right.plot([_degrees(name)] * len(values), values, mark, color=colour, mfc="none", label=label)
        right.set_xlabel("slope [degrees]")
        right.set_ylabel("length [m]")
        right.set_ylim(bottom=0)
        right.legend(frameon=False)
    return made


LAW = Law(
    "Jumps of grains on a slope",
    "Does momentum close over a jump of grains on a slope, and does it steepen with the slope as published?",
    points,
    rows,
    figure,
    (
        "Discs of 0.15 m ± 20 % with friction 0.3 and spin; a jet 1 m deep at 8 m/s; a sill of 2 m. Nothing was chosen "
        "for a result: the slopes are those from 26 to 32 degrees. At 20 degrees the discs lock and the front walks "
        "to the inlet.",
        "Published numbers for such jumps were not found, so the trends of the abstracts and the balance are held.",
        "Méjean, Faug & Einav 2017 say in their abstract what Bélanger's equation lacks: weight and friction over the "
        "length of the jump, and the change of density. Their relation takes them in. It needs that length.",
        "The balance here has the same forces. They are measured: the weight of the discs and the force on the bed, "
        "over the whole chute, and the force on the sill. So no length and no coefficient of friction is assumed.",
        "The depth ratio is also held against momentum over the jump alone, with hydrostatic pressure on both sides. "
        "Their formula was not read; ours is derived from the same forces.",
        "At rest is the lowest 0.45 m where it is slower than 0.05 of the jet.",
    ),
)
