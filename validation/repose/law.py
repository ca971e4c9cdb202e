# SPDX-License-Identifier: GPL-2.0-or-later
"""Heaps under a hopper: the angle of repose against friction, and a sandpile of others."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing
from lammps_jump.studies.validation import LOOKED_UP, Found, Law, Point, Row, around, mean_of

SLIDING, ROLLING = (0.2, 0.4, 0.8), (0.0, 0.1, 0.3)
"""Coefficients of friction; sliding at rolling friction 0.1, rolling at sliding friction 0.4."""
MIDDLE = (0.4, 0.1)
PILE, BARE = "sandpile", "sandpile, no rolling springs"
LETHE = 0.272
"""Height of the sandpile of Lethe's documentation with an elastic-plastic spring against rolling, m."""
ZHOU = "Zhou, Xu, Yu & Zulli 2001, Phys. Rev. E 64, 021301, abstract"


def point(sliding: float, rolling: float, starts: int, changes: dict[str, Any]) -> Point:
    """A small heap with these coefficients."""
    given = {"contact.friction": sliding, "contact.rolling": {"friction": rolling}, **changes}
    return Point(f"sliding {sliding:g}, rolling {rolling:g}", "heap", "heap.yaml", given, starts, seconds=8)


def points(quick: bool) -> list[Point]:
    """Three coefficients of sliding, three of rolling, the sandpile; quick: two small heaps, no sandpile."""
    if quick:
        less = {"initial.0.y": [0.75, 0.9], "run.duration": 2.0}
        return [point(MIDDLE[0], rolling, 1, less) for rolling in (0.0, 0.3)]
    pairs = [(mu, MIDDLE[1]) for mu in SLIDING] + [(MIDDLE[0], rolling) for rolling in ROLLING]
    found = [point(*pair, 3, {}) for pair in dict.fromkeys(pairs)]
    found.append(Point(PILE, "heap", "sandpile.yaml", {}, 3, seconds=60))
    found.append(Point(BARE, "heap", "sandpile.yaml", {"contact.rolling": None}, 1, seconds=60))
    return found


def means(found: Found, pairs: Sequence[tuple[float, float]], key: str = "angle") -> list[tuple[float, float]]:
    """Mean of a number and its interval at each pair of coefficients that was run."""
    named = [f"sliding {sliding:g}, rolling {rolling:g}" for sliding, rolling in pairs]
    return [mean_of([one[key] for one in found[name]]) for name in named if name in found]


def least_rise(values: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The smallest rise from one value to the next, and its interval."""
    return min(rise(*pair) for pair in pairwise(values))


def rise(low: tuple[float, float], high: tuple[float, float]) -> tuple[float, float]:
    """Rise from one mean to another, and its interval."""
    return high[0] - low[0], float(np.hypot(low[1], high[1]))


def rows(found: Found) -> list[Row]:
    """Rises of the angle, and heights of the sandpile."""
    series = {
        "sliding": [(mu, MIDDLE[1]) for mu in SLIDING],
        "rolling": [(MIDDLE[0], rolling) for rolling in ROLLING],
    }
    made = []
    for name, pairs in series.items():
        angles, heights = means(found, pairs), means(found, pairs, "height")
        if len(angles) < 2:
            continue
        told = "their numbers are of spheres: the sign alone; where an interval holds 0, three starts do not tell"
        for quantity, found_rise in (
            (f"angle of repose, rise over all {name} friction, degrees", rise(angles[0], angles[-1])),
            (f"angle of repose, least rise from one {name} friction to the next, degrees", least_rise(angles)),
            (f"height of the heap, least rise from one {name} friction to the next, m", least_rise(heights)),
        ):
            made.append(Row(quantity, "rises", LOOKED_UP, ZHOU, *found_rise, (0.0, inf), told))
    if PILE in found:
        source = "Lethe's documentation after Ai et al. 2011, read from a figure"
        made += [
            Row("height of the sandpile, m", LETHE, LOOKED_UP, source, *mean_of([one["height"] for one in found[PILE]]),
                around(LETHE, 0.1), "start in the hopper, damping of rolling and the bed are not those of Lethe: 10 %"),
            Row("height without rolling springs / with them", "below 1", LOOKED_UP,
                f"{source}: constant torque 0.242 falling to 0.219 m, viscous 0.187 m",
                found[BARE][0]["height"] / mean_of([one["height"] for one in found[PILE]])[0], limits=(0.0, 0.9),
                reason="only a spring against rolling holds the pile: theirs falls to 0.69 to 0.81"),
        ]  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw angle against friction, and the sandpile."""
    with drawing(9.2, 3.6, 1, 2) as (made, (left, right)):
        looks = (("sliding", SLIDING, "o-", BLUE), ("rolling", ROLLING, "s--", GOLD))
        for name, values, look, colour in looks:
            pairs = [(v, MIDDLE[1]) if name == "sliding" else (MIDDLE[0], v) for v in values]
            here = [v for v, (a, b) in zip(values, pairs, strict=True) if f"sliding {a:g}, rolling {b:g}" in found]
            if not here:
                continue
            centres, halves = zip(*means(found, pairs), strict=True)
            fixed = f"rolling {MIDDLE[1]:g}" if name == "sliding" else f"sliding {MIDDLE[0]:g}"
            left.errorbar(here, centres, yerr=np.nan_to_num(halves), fmt=look, color=colour, capsize=2,
                          label=f"{name} friction varied, {fixed}")  # fmt: skip
        left.set(xlabel="coefficient of friction [1]", ylabel="angle of the flanks [degrees]", ylim=(0, None))
        left.set_title("small heaps")
        left.legend()
        for name, look, colour in ((PILE, "-", BLUE), (BARE, "--", BLACK)):
            if name in found:
                one = found[name][0]
                x, depth = np.array(one["x"]), np.array(one["depth"])
                right.plot(x, depth, look, color=colour, lw=1.2, label=name)
        right.axhline(LETHE, color=RED, ls=":", label="height in Lethe's documentation")
        right.set(xlabel="x [m]", ylabel="height [m]", title="sandpile", xlim=(-0.9, 0.9), ylim=(0, 0.4))
        right.axvline(0, color=GREY, lw=0.5)
        right.legend(loc="upper right")
    return made


LAW = Law(
    "Repose",
    "Does the angle of repose rise with friction and rolling friction, and does a sandpile of others stand as high?",
    points,
    rows,
    figure,
    (
        "Small heaps: some 700 discs of ± 20 %, e 0.5, on a bed as rough as the discs, from a hopper, at rest. The "
        "angle is that of straight lines through both flanks between 20 and 80 % of the height.",
        "Sandpile: 2,500 discs of 6.9 mm and 500 of 8.9 mm, μ 0.8, rolling friction 0.3, e 0.7, 4 MPa.",
    ),
)
