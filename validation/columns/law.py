# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns of grains that fall and run out, against discs of others, aluminium rods and sand."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing
from lammps_jump.physics.devices import height_of_rods, run_out_of_rods, run_out_of_sand
from lammps_jump.physics.measured import DISC_HEAPS
from lammps_jump.studies.validation import LOOKED_UP, SECOND_HAND, Found, Law, Point, Row, around, mean_of

AREA, GRAVITY = 14.8, 9.81
"""Of the column, m^2: about 1,500 discs of 0.1 m; m/s^2."""
SHAPES = (0.49, 1.39, 6.0)
"""Aspects of published discs."""
LOW, HIGH = (0.49, 0.9, 1.39), (4.0, 6.0, 9.0)
FRICTION = 0.5
OTHERS = (0.25, 1.0)
"""Friction at which the middle one of `SHAPES` falls too."""
FRONTS = {0.49: 0.88, 1.39: 3.27, 6.0: 11.8}
"""Their run-out over the base where the heap is 1.5 diameters deep."""
THEIRS = (
    "discs by contact dynamics, comphy-lab/basilisk-C, sandbox M1EMN, ShapeTime.A-01, -03, -04; their μ is not known"
)
RODS = "aluminium rods, arXiv 1512.05180, abstract"
LUBE = "sand, Lube et al. 2005 as quoted by Staron & Hinch, physics/0501022"
WIDE = "grains differ in friction, restitution and size, and the columns in width: 25 %"


def point(aspect: float, friction: float, starts: int, area: float = AREA) -> Point:
    """A column of this aspect H/L."""
    base = sqrt(area / aspect)
    height = 1.01 * aspect * base  # it settles by a hundredth
    changes = {
        "initial.0.x": [0, round(base, 4)],
        "initial.0.y": [0, round(height, 4)],
        "contact.friction": friction,
        "contact.impact_speed": round(sqrt(2 * GRAVITY * height), 3),
    }
    name = f"a {aspect:g}" + ("" if friction == FRICTION else f", friction {friction:g}")
    return Point(name, "heap", "column.yaml", changes, starts, seconds=12.0)


def points(quick: bool) -> list[Point]:
    """Columns of six aspects, and one of them at other friction; quick: four small columns, one start each."""
    if quick:
        return [point(aspect, FRICTION, 1, area=1.5) for aspect in (0.49, 1.39, 4.0, 6.0)]
    found = [point(aspect, FRICTION, 3) for aspect in (*LOW, *HIGH)]
    return found + [point(SHAPES[1], friction, 3) for friction in OTHERS]


def own(found: Found) -> dict[float, list[Any]]:
    """Starts at the friction of the law, by the nominal aspect."""
    return {float(name[2:]): list(ones) for name, ones in found.items() if "friction" not in name}


def exponent(columns: dict[float, list[Any]], key: str = "bulk") -> tuple[float, float]:
    """Exponent of a number over the aspect, and its interval: one fit for each start."""
    fits = []
    for ones in zip(*columns.values(), strict=False):
        fits.append(np.polyfit(np.log([one["aspect"] for one in ones]), np.log([one[key] for one in ones]), 1)[0])
    return mean_of(fits)


def shape_off(one: dict[str, Any], aspect: float) -> float:
    """Root mean square of h/L0 less that of published discs, over the root mean square of theirs."""
    theirs = next(heap.shape for heap in DISC_HEAPS if heap.aspect == aspect)
    ours = np.interp(theirs.x, one["x"], one["h"])
    return float(np.sqrt(np.mean((ours - theirs.y) ** 2) / np.mean(np.square(theirs.y))))


def rows(found: Found) -> list[Row]:
    """Exponents, run-out and shape."""
    columns = own(found)
    low = {aspect: ones for aspect, ones in columns.items() if aspect < 2}
    high = {aspect: ones for aspect, ones in columns.items() if aspect > 2}
    made = [
        Row("exponent of run-out, a below 1.5", 1.0, SECOND_HAND, f"{LUBE}; rods 0.96", *exponent(low), (0.85, 1.15),
            "sand, rods and discs of others lie within 0.9 to 1.17"),
        Row("exponent of run-out, a from 4 on", 2 / 3, SECOND_HAND, f"{LUBE}; rods 0.73", *exponent(high),
            around(2 / 3, by=0.12), "0.65 in narrow slots to 0.9 in wide ones (Balmforth & Kerswell 2005)"),
        Row("run-out over a L, a below 1.5", 2.5, SECOND_HAND, "discs, Staron & Hinch 2005, as quoted by others",
            *mean_of([one["bulk"] / one["aspect"] for ones in low.values() for one in ones]), around(2.5, 0.25), WIDE),
    ]  # fmt: skip
    for aspect in (aspect for aspect in SHAPES if aspect in columns):
        ones = columns[aspect]
        theirs = next(heap for heap in DISC_HEAPS if heap.aspect == aspect)
        at = f"a {aspect:g}"
        made += [
            Row(f"{at}: run-out of the bulk / L", theirs.run_out, LOOKED_UP, f"{THEIRS}; outermost disc",
                *mean_of([one["bulk"] for one in ones]), around(theirs.run_out, 0.25), WIDE),
            Row(f"{at}: run-out where 1.5 d deep / L", FRONTS[aspect], LOOKED_UP, THEIRS,
                *mean_of([one["front"] for one in ones]), around(FRONTS[aspect], 0.25), WIDE,
                "1.5 diameters are a larger share of a base that is fewer diameters long"),
            Row(f"{at}: shape, rms of the difference / rms of h", 0.0, LOOKED_UP, THEIRS,
                *mean_of([shape_off(one, aspect) for one in ones]), (0.0, 0.25),
                "25 % in run-out is as much in height, because the area is kept"),
        ]  # fmt: skip
    middle = columns[SHAPES[1]]
    outs, tops = [one["bulk"] for one in middle], [one["top"] for one in middle]
    a = float(np.mean([one["aspect"] for one in middle]))
    made += [
        Row("a 1.39: run-out of the bulk / L, rods", run_out_of_rods(a), LOOKED_UP, RODS, *mean_of(outs),
            around(run_out_of_rods(a), 0.25), WIDE, "rods run out farther: their friction is not in the abstract"),
        Row("a 1.39: top / L, rods", height_of_rods(a), LOOKED_UP, RODS, *mean_of(tops),
            around(height_of_rods(a), 0.25), WIDE),
        Row("a 1.39: run-out of the bulk / L, sand", run_out_of_sand(a), SECOND_HAND, LUBE, *mean_of(outs),
            reason="sand is not two-dimensional: discs run out twice as far, whoever computes them"),
    ]  # fmt: skip
    for name, ones in found.items():
        if "friction" in name:
            made.append(
                Row(f"{name}: run-out of the bulk / L", None, "", "", *mean_of([one["bulk"] for one in ones]),
                    reason="shows what friction does")
            )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw shapes beside those of others, and run-out against aspect."""
    columns = own(found)
    with drawing(9.6, 4.0, 1, 2, width_ratios=(1.15, 1)) as (made, (left, right)):
        looks = (("-", BLUE, "o"), ("--", GOLD, "s"), ("-.", BLACK, "^"))
        for (line, colour, mark), theirs in zip(looks, DISC_HEAPS, strict=True):
            if theirs.aspect not in columns:
                continue
            one = columns[theirs.aspect][0]
            x, h = np.array(one["x"]), np.array(one["h"])
            left.plot(x[x < 4], h[x < 4], line, color=colour, lw=1.3, label=f"ours, a {theirs.aspect:g}")
            left.plot(theirs.shape.x, theirs.shape.y, mark, color=colour, mfc="white", ms=6)
        left.plot([], [], "o", color=GREY, mfc="white", label="marks: discs of others")
        left.set(xlabel="distance / L [1]", ylabel="height / L [1]", title="heaps at rest", ylim=(0, None))
        left.legend()
        for aspect, ones in columns.items():
            mean, half = mean_of([one["bulk"] for one in ones])
            label = "ours, bulk" if aspect == SHAPES[1] else None
            right.errorbar(aspect, mean, yerr=half if half == half else 0, fmt="o", color=BLUE, capsize=2, label=label)
        theirs_x, theirs_y = [heap.aspect for heap in DISC_HEAPS], [heap.run_out for heap in DISC_HEAPS]
        right.plot(theirs_x, theirs_y, "s", ms=9, mfc="none", color=BLACK, label="discs of others, outermost")
        a = np.geomspace(0.4, 10, 200)
        right.plot(a, [run_out_of_rods(v) for v in a], "--", color=GOLD, label="aluminium rods")
        right.plot(a, [run_out_of_sand(v) for v in a], ":", color=RED, label="sand")
        right.set(xscale="log", yscale="log", xlabel="aspect a = H/L [1]", ylabel="run-out / L [1]", title="run-out")
        right.set_yticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
        right.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
        right.minorticks_off()
        right.legend()
    return made


LAW = Law(
    "Columns that fall",
    "Do columns of grains run out as far, and leave heaps of the same shape, as discs of others, rods and sand?",
    points,
    rows,
    figure,
    (
        "About 1,500 discs of ± 20 %, μ 0.5, e 0.5, spin, springs along contacts, no rolling springs; rough bed, "
        "smooth wall behind (the middle of a column that falls to both sides). L is the base of the column, a = H/L.",
        "Two fronts: the bulk ends before the first gap of two diameters between neighbours; the other one is where "
        "the heap is 1.5 diameters deep. A heap is measured at rest: median speed below 0.01 √(g d), top constant.",
    ),
)
