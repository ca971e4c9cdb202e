# SPDX-License-Identifier: GPL-2.0-or-later
"""A gas of discs: Haff's law of cooling and Henderson's pressure."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, drawing
from lammps_jump.studies.validation import DERIVED, SECOND_HAND, Found, Law, Point, Row, around, mean_of

PACKINGS = (0.2, 0.4, 0.6)


def henderson(packing: float) -> float:
    """P A / (N T) of hard discs."""
    return (1.0 + packing**2 / 8.0) / (1.0 - packing) ** 2


def points(quick: bool) -> list[Point]:
    """Cooling at packing 0.1, pressure at three packings; quick: few discs, and one packing."""
    if quick:
        return [
            Point("cooling", "cools", options={"packing": 0.1, "count": 100, "starts": 2, "last": 1.5}),
            Point("pressure 0.2", "presses", options={"packing": 0.2, "count": 100, "starts": 2, "collisions": 60.0}),
        ]
    made = [Point("cooling", "cools", options={"packing": 0.1, "count": 1024, "starts": 5}, seconds=60)]
    for packing in PACKINGS:
        options = {"packing": packing, "count": 500, "starts": 3, "collisions": 150.0}
        made.append(Point(f"pressure {packing:g}", "presses", options=options, seconds=40))
    return made


def rows(found: Found) -> list[Row]:
    """The rate of cooling, and Z at each packing."""
    made = []
    for name, (one,) in found.items():
        if name == "cooling":
            mean, half = mean_of(one["rates"])
            reason = "5 % at packing 0.1: velocities are correlated, 0.97 was measured with stock styles"
            why = (
                "velocities are correlated, so energy decays more slowly than in molecular chaos (Nakanishi, abstract)"
            )
            words = "rate of cooling at packing 0.1 over that of molecular chaos"
            made.append(
                Row(words, 1.0, DERIVED, "Haff's law with Enskog's rate", mean, half, around(1.0, 0.05), reason, why)
            )
            continue
        packing = float(name.split()[1])
        mean, half = mean_of(one["z"])
        reason = "2 %: contacts take 1 % of the time between them, so the discs are a little soft"
        expected = henderson(packing)
        source = "Henderson 1975, by public codes that cite it"
        words = f"P A / (N T) at packing {packing:g}"
        made.append(Row(words, expected, SECOND_HAND, source, mean, half, around(expected, 0.02), reason))
    return made


def figure(found: Found) -> Figure:
    """Energy over time beside Haff's law, and pressure against packing."""
    with drawing(8.6, 3.6, 1, 2) as (made, (left, right)):
        one = found["cooling"][0]
        time = np.array(one["time"])
        left.plot(time, (1.0 + time) ** -2.0, "--", color=GREY, label="Haff")
        left.plot(time, one["energy"], color=BLUE, label="discs, one start")
        left.set_yscale("log")
        left.set_xlabel("time over τ")
        left.set_ylabel("energy over that at the start")
        left.legend(frameon=False)
        packing = np.linspace(0.0, 0.65, 60)
        right.plot(packing, henderson(packing), "--", color=GREY, label="Henderson")
        for name, (found_one,) in found.items():
            if name != "cooling":
                right.plot([float(name.split()[1])] * len(found_one["z"]), found_one["z"], "o", color=BLUE, mfc="white")
        right.set_xlabel("packing")
        right.set_ylabel("P A / (N T)")
        right.legend(frameon=False)
    return made


LAW = Law("A gas of discs", "Does a gas of discs cool and press as kinetic theory says?", points, rows, figure)
