# SPDX-License-Identifier: GPL-2.0-or-later
"""Stress in a tall bin: walls carry what their friction can, after Janssen 1895."""

from __future__ import annotations

from itertools import pairwise
from math import exp
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing
from lammps_jump.studies.validation import DERIVED, SECOND_HAND, Found, Law, Point, Row, mean_of

BINS = {
    "12 d wide": (1.2, 0.5),
    "20 d wide": (2.0, 0.5),
    "12 d wide, wall friction 0.25": (1.2, 0.25),
    "12 d wide, wall friction 0.125": (1.2, 0.125),
}
"""Width (m) and friction of the walls."""
SOURCE = "Janssen 1895 as in Sperl 2006, in two dimensions: λ = W/(2 μ_w K)"


def point(name: str, starts: int, height: float) -> Point:
    """A bin filled to this height, m."""
    width, friction = BINS[name]
    half = 0.5 * width
    changes = {
        "walls.left.at": -half,
        "walls.right.at": half,
        "walls.left.friction": friction,
        "walls.right.friction": friction,
        "initial.0.x": [0.02 - half, half - 0.02],
        "initial.0.y": [0.02, height],
        "analysis.layers.x": [-half, half],
    }
    return Point(name, "stresses", "bin.yaml", changes, starts, {"width": width}, seconds=4 * width * height / 8)


def points(quick: bool) -> list[Point]:
    """Three bins; quick: one, less filled, one start."""
    if quick:
        return [point("12 d wide", 1, 3.0)]
    return [point(name, 3, 7.0) for name in BINS]


def lengths(found: Found, name: str) -> list[float]:
    """Janssen's length over the width, one a start."""
    return [one["length"] for one in found[name]]


def side_share(found: Found, name: str) -> list[float]:
    """K of each start, from the length: the walls' share of the vertical stress, 1/(2 mu_w length/W)."""
    return [1.0 / (2.0 * BINS[name][1] * length) for length in lengths(found, name)]


def rows(found: Found) -> list[Row]:
    """Form of the curve, growth with width and friction, K."""
    first = next(iter(BINS))
    offs = [one["off"] for ones in found.values() for one in ones]
    deepest = [one["stress"][0] / one["depth"][0] for one in found[first]]
    depth = float(np.mean([one["depth"][0] for one in found[first]]))
    made = [
        Row("rms distance from Janssen's curve / λ", 0.0, DERIVED, SOURCE, *mean_of(offs), (0.0, 0.1),
            "force chains in a bin of 12 to 20 d: a tenth of the stress in a layer"),
        Row(f"stress / weight above, {depth:.1f} widths deep, 12 d wide", "below 1", SECOND_HAND,
            "Janssen 1895: walls carry a part", *mean_of(deepest), (0.0, 0.999), "sign"),
    ]  # fmt: skip
    if "20 d wide" in found:
        pairs = zip(lengths(found, "20 d wide"), lengths(found, first), strict=False)
        made.append(
            Row("λ/W, 20 d wide over 12 d wide", 1.0, DERIVED, SOURCE, *mean_of([one / other for one, other in pairs]),
                (0.8, 1.25), "K scatters by a tenth between packings")
        )  # fmt: skip
        names = [first, "12 d wide, wall friction 0.25", "12 d wide, wall friction 0.125"]
        for rough, smooth in pairwise(names):
            pairs = zip(lengths(found, smooth), lengths(found, rough), strict=False)
            ratio = mean_of([one / other for one, other in pairs])
            frictions = f"{BINS[smooth][1]:g} over {BINS[rough][1]:g}"
            made.append(
                Row(f"λ, wall friction {frictions}", 2.0, DERIVED, SOURCE, *ratio,
                    (1.5, 2.5), "K is not the same: walls that carry less turn the stresses less",
                    "the wall carries no more shear than the grains beside it, whose friction at rest is below 0.3 "
                    "(flow down a slope): a wall friction of 0.5 is not used up")
            )  # fmt: skip
    for name in found:
        made.append(
            Row(f"K of the walls, {name}", None, "", "", *mean_of(side_share(found, name)),
                reason="no number for discs was found; where wall friction is not used up, this is less than σ_xx/σ_yy")
        )  # fmt: skip
    made.append(
        Row("σ_xx/σ_yy, 12 d wide", None, "", "", *mean_of([one["side"] for one in found[first]]),
            reason="no number for discs was found")
    )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw stress against depth, with Janssen's curves."""
    looks = ((BLUE, "o", "-"), (GOLD, "s", "--"), (BLACK, "^", "-."), (RED, "D", (0, (5, 1))))
    with drawing(6.6, 4.2) as (made, axes):
        deep = 0.0
        for (name, ones), (colour, mark, dash) in zip(found.items(), looks, strict=False):
            one: dict[str, Any] = dict(ones[0])
            depth = np.linspace(0, max(one["depth"]), 100)
            deep = max(deep, depth[-1])
            length = mean_of(lengths(found, name))[0]
            axes.plot(one["depth"], one["stress"], mark, color=colour, mfc="white", ms=4, label=name)
            axes.plot(depth, [length * (1 - exp(-z / length)) for z in depth], ls=dash, color=colour)
        axes.plot((0, deep), (0, deep), ":", color=GREY, label="no friction at the walls")
        top = max(max(one["stress"]) for ones in found.values() for one in ones)
        axes.set(xlabel="depth / W [1]", ylabel="vertical stress / (ρ$_b$ g W) [1]", ylim=(0, 1.6 * top))
        axes.set_title("stress in a bin; lines: Janssen with fitted λ")
        axes.legend()
    return made


LAW = Law(
    "Janssen's bin",
    "Do the walls of a tall bin carry the weight as Janssen says?",
    points,
    rows,
    figure,
    (
        "Discs of ± 20 %, μ 0.5, e 0.5, spin, springs along contacts. The floor sinks by 0.75 d in 1.5 s while the "
        "stresses are averaged: without that, wall friction is not used up, and K means nothing. The depth is the "
        "weight above over ρ_b g.",
    ),
)
