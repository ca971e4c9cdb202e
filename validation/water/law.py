# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs in the place of water: the front of a collapsing column."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.devices.front import off_curve
from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, drawing
from lammps_jump.physics.measured import KOSHIZUKA_OKA_FRONT, MARTIN_MOYCE_FRONT
from lammps_jump.studies.validation import DERIVED, SECOND_HAND, Found, Law, Point, Row, around, mean_of

SOURCE = "Martin & Moyce 1952, Phil. Trans. R. Soc. A 244, 312, as tabled in later sources"
KOSHIZUKA = "Koshizuka & Oka 1996, Nucl. Sci. Eng. 123, 421, as tabled in pypr/pysph, examples/db_exp_data.py"
BEGIN = 0.8
"""T before which the gate and the first fall of the column count more than the flow."""
DISTANCE, SECONDS = 3.367, 1.0
"""Wall behind the gate, over H; time after the arrival in which the impulse is taken, sqrt(H/g)."""


def points(quick: bool) -> list[Point]:
    """Columns of n² = 2 and 1, and one that runs against a wall; quick: coarse, without n² = 1."""
    after = {"seconds": SECONDS}
    if quick:
        coarse = {"discs.diameter": 0.25, "initial.0.settle": 0.5, "run.duration": 2.4}
        small = {"discs.diameter": 0.06, "initial.0.settle": 0.5}
        return [
            Point("n² = 2", "column", "column.yaml", coarse, 1, seconds=3),
            Point("wall", "wall", "impact.yaml", small, 1, after, seconds=3),
        ]
    square = {"initial.0.y": [0, 4.25], "run.duration": 2.6}
    return [
        Point("n² = 2", "column", "column.yaml", {}, 5, seconds=40),
        Point("n² = 1", "column", "column.yaml", square, 5, seconds=20),
        Point("wall", "wall", "impact.yaml", {}, 5, after, seconds=25),
    ]


def off_oka(one: Mapping[str, Any]) -> np.ndarray:
    """Front over Koshizuka & Oka's, less 1, at their points behind `BEGIN` that the record covers."""
    time, front = np.asarray(one["T"], float), np.asarray(one["Z"], float)
    return off_curve(time, front, *KOSHIZUKA_OKA_FRONT, BEGIN)


def ritter_impulse(distance: float, seconds: float) -> float:
    """Momentum that Ritter's wave carries through a place in so much time from its arrival, over rho H² sqrt(g H).

    h u² with h/H = (2 - s)²/9, u/sqrt(g H) = 2 (1 + s)/3, s = x/(t sqrt(g H)).
    """
    time = np.linspace(distance / 2, distance / 2 + seconds, 2001)
    share = distance / time
    return float(np.trapezoid(4 / 81 * (2 - share) ** 2 * (1 + share) ** 2, time))


def rows(found: Found) -> list[Row]:
    """The front lags water by up to a fifth; its height is told, and what a wall takes."""
    made = []
    for name, ones in found.items():
        if name != "wall":
            made += rows_of_column(name, ones)
    return made + (rows_of_wall(found["wall"]) if "wall" in found else [])


def rows_of_column(name: str, ones: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Slope, front and height of a column."""
    table = ones[0]["slope_of_table"]
    mean, half = mean_of([one["slope"] for one in ones])
    words = f"{name}: slope dZ/dT of the front"
    made = [Row(words, table, SECOND_HAND, SOURCE, mean, half, around(table, 0.2), "20 %, as the front")]
    if ones[0]["mean_bulk"] is None:
        return made
    reason = "discs have a yield stress and lag: −20 to 0 % by trials of several kinds of contact"
    why = "e 0.95 and sizes ±20 % bring the discs nearer to water than those trials"
    mean, half = mean_of([one["mean_bulk"] for one in ones])
    words = f"{name}: front over that of water, less 1 (T > 0.8)"
    made.append(Row(words, 0.0, SECOND_HAND, SOURCE, mean, half, (-0.2, 0.0), reason, why))
    mean, half = mean_of([float(off_oka(one).mean()) for one in ones])
    words = f"{name}: front over Koshizuka & Oka's, less 1 (T > 0.8)"
    why += "; their water is slower than that of Martin & Moyce"
    made.append(Row(words, 0.0, SECOND_HAND, KOSHIZUKA, mean, half, (-0.2, 0.0), reason, why))
    mean, half = mean_of([one["rms_height"] for one in ones])
    words = f"{name}: height of the column, rms off water"
    made.append(Row(words, None, "", "", mean, half, None, "no limit was found"))
    return made


def rows_of_wall(ones: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Balance of momentum, arrival and impulse at a wall."""
    ritter = "Ritter's wave on a dry bed (docs/theory.md), which has no wall and a column without end"
    no_number = (
        "the pressure impulse of Lobovský et al. 2014 (arXiv 1308.0115) was not found; Ritter's wave meets no wall"
    )
    return [
        Row("wall: momentum that both walls leave over / impulse on the wall", 0.0, DERIVED,
            "momentum of the discs = impulse of the back wall − that on the wall ahead",
            *mean_of([one["left_over"] for one in ones]), (-0.01, 0.01),
            "every step counts; the dump has six digits, and windows of 5 ms end beside frames"),
        Row("wall: arrival of the front, √(H/g)", DISTANCE / 2, DERIVED, ritter,
            *mean_of([one["arrival"] for one in ones]), reason="a column of 2 H is at rest first"),
        Row("wall: impulse in √(H/g) from the arrival / (ρ H² √(g H))", ritter_impulse(DISTANCE, SECONDS), DERIVED,
            ritter, *mean_of([one["impulse"] for one in ones]), reason=no_number),
    ]  # fmt: skip


def figure(found: Found) -> Figure:
    """Draw the front over time beside both experiments, the slopes, and the force on the wall."""
    with drawing(10.2, 3.5, 1, 3) as (made, (one, two, three)):
        for number, start in enumerate(found.get("n² = 2", ())):
            one.plot(start["T"], start["Z"], color=BLUE, lw=0.9, label=None if number else "discs")
        one.plot(*MARTIN_MOYCE_FRONT, "s", color=BLACK, mfc="white", ms=4, label="Martin & Moyce")
        one.plot(*KOSHIZUKA_OKA_FRONT, "o", color=GOLD, ms=4, label="Koshizuka & Oka")
        one.set(xlabel="T = t √(2g/a) [1]", ylabel="front / a [1]", title="front, n² = 2", xlim=(0, 3.4), ylim=(1, 4.5))
        one.legend()
        columns = {name: ones for name, ones in found.items() if name != "wall"}
        for number, (name, ones) in enumerate(columns.items()):
            off = [100 * (start["slope"] / start["slope_of_table"] - 1) for start in ones]
            two.plot([number] * len(ones), off, "o", color=BLUE, mfc="white")
            two.annotate(name, (number, -30), ha="center")
        two.axhspan(-20, 20, color=GREY, alpha=0.2)
        two.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-35, 35), xticks=[], title="speed of the front")
        two.set_ylabel("slope dZ/dT off Martin & Moyce [%]")
        for start in found.get("wall", ()):
            three.plot(start["t"], start["force"], color=BLUE, lw=0.6)
        three.axvline(DISTANCE / 2, color=GREY, ls="--")
        three.annotate("Ritter's front", (DISTANCE / 2, 0.02), rotation=90, ha="right", va="bottom", fontsize=8)
        three.set(xlabel="t √(g/H) [1]", ylabel="force / (ρ g H²) [1]", title="force on the wall", ylim=(0, None))
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
        "thinner than some discs: take SPH, a volume-of-fluid code or shallow-water equations. The table of "
        "docs/howto/discs_and_water.md names one for each question.",
        "Koshizuka & Oka's column, L x 2 L, is that of n² = 2: T and Z are the same numbers. So one run is held "
        "against both experiments.",
        "The wall stands as that of Lobovský et al. 2014: a column 600 mm long and 300 mm deep in a tank of 1610 mm "
        "(second hand). Their pressure impulse is of a sensor near the floor, ours of the whole wall. Single peaks are "
        "those of discs and are not held.",
    ),
)
